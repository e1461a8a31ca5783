//! The section `structure`: volumes, assemblies and what is placed in them.

use shotline::scene::{Node, NodeId};

use super::attributes::{Found, Reported};
use super::placements::Placement;
use super::texts::{Text, read_texts};
use super::{Element, MAX_BYTES, Module, elements, tag};
use crate::files::read_regular;
use crate::paths::resolve;
use crate::suggest;

impl Module<'_> {
    /// Reads the volumes; one that is wrong is reported, and the others are read.
    pub(super) fn structure(&mut self, section: Element) {
        for element in elements(section) {
            self.structure_element(element);
        }
    }

    fn structure_element(&mut self, element: Element) {
        let volume = match tag(element) {
            "volume" => self.volume(element),
            "assembly" => self.assembly(element),
            "loop" => {
                // What is wrong has been reported.
                let _ = self.repeat(element, &mut |module, child| module.structure_element(child));
                return;
            }
            // Surfaces of optics.
            "bordersurface" | "skinsurface" => return,
            other => {
                let message = format!("<{other}> has no meaning in <structure>");
                self.report(element, None, message, "it has volumes and assemblies");
                return;
            }
        };
        if let Ok(name) = self.name(element) {
            // Of two with one name the first counts, as in Geant4.
            self.volumes.by_name.entry(name).or_insert(volume.ok());
        }
    }

    fn volume(&mut self, element: Element) -> Found<NodeId> {
        let name = self.name(element)?;
        let (mut solid, mut material, mut contents) = (None, None, Vec::new());
        for child in elements(element) {
            match tag(child) {
                "solidref" => solid = Some(self.solid_of(child, "ref")?),
                "materialref" => material = Some(self.material_of(child)?),
                _ => {}
            }
        }
        let Some(solid) = solid else {
            let message = format!("the volume '{name}' has no solid");
            return Err(self.report(element, None, message, "add <solidref ref=\"...\"/>"));
        };
        for child in elements(element) {
            self.content(child, solid, &mut contents);
        }
        let clip = !contents.is_empty();
        Ok(self.add(element, Node::Object { name, material, priority: 0, node: solid, contents, clip }))
    }

    /// Adds what an element places in a volume; what is wrong is reported.
    fn content(&mut self, element: Element, mother: NodeId, contents: &mut Vec<NodeId>) {
        let placed = match tag(element) {
            "solidref" | "materialref" | "auxiliary" | "colorref" => return,
            "loop" => {
                let _ = self.repeat(element, &mut |module, child| module.content(child, mother, contents));
                return;
            }
            "physvol" => self.physical_volume(element).map(|placed| vec![placed]),
            "replicavol" => self.replicas(element),
            "divisionvol" => self.divisions(element, mother),
            "paramvol" => self.parameterised(element),
            other => Err(self.unsupported(element, format!("<{other}> in <volume>"))),
        };
        contents.extend(placed.into_iter().flatten());
    }

    fn assembly(&mut self, element: Element) -> Found<NodeId> {
        let mut members = Vec::new();
        for child in elements(element) {
            match tag(child) {
                "physvol" => members.extend(self.physical_volume(child)),
                other => {
                    let message = format!("<{other}> has no meaning in <assembly>");
                    self.report(child, None, message, "it has <physvol> elements");
                }
            }
        }
        Ok(self.add(element, Node::Group { members }))
    }

    fn physical_volume(&mut self, element: Element) -> Found<NodeId> {
        self.count_copies(element, 1)?;
        let (mut volume, mut name, mut placement) = (None, String::new(), Placement::NONE);
        for child in elements(element) {
            match tag(child) {
                "volumeref" => {
                    name = self.reference(child, "ref")?;
                    volume = self.volume_of(child)?;
                }
                "file" => {
                    volume = self.file(child)?;
                    let known = volume.map(|volume| self.reader.scene.node(volume));
                    if let Some(Node::Object { name: of_volume, .. }) = known {
                        name = of_volume.clone();
                    }
                }
                _ if self.place(child, "", &mut placement)? => {}
                other => {
                    let message = format!("<{other}> has no meaning in <physvol>");
                    return Err(self.report(child, None, message, "it has a volume and its placement"));
                }
            }
        }
        // What a missing volume lacks has been reported where it is.
        let Some(volume) = volume else {
            if elements(element).any(|child| matches!(tag(child), "volumeref" | "file")) {
                return Err(Reported);
            }
            let help = "add <volumeref ref=\"...\"/>";
            return Err(self.report(element, None, "the placement names no volume", help));
        };
        let label = match element.attribute("name") {
            Some(label) if !label.is_empty() => self.written_out(element, "name", label, true)?,
            _ => format!("{name}_PV"),
        };
        let copy = match element.attribute("copynumber") {
            Some(_) => Some(self.number(element, "copynumber")?),
            None => None,
        };
        let label = copy.map_or(label.clone(), |copy| format!("{label}[{copy}]"));
        Ok(self.placed(element, volume, &placement, label))
    }

    /// Places a volume under a label.
    pub(super) fn placed(
        &mut self,
        element: Element,
        volume: NodeId,
        placement: &Placement,
        label: String,
    ) -> NodeId {
        let transform = placement.of_volume();
        let node = self.add(element, Node::Transform { transform, child: volume });
        self.reader.scene.labels.insert(node, label);
        node
    }

    /// The volume or assembly that an element refers to; `None` if what is wrong with it has been reported.
    pub(super) fn volume_of(&mut self, element: Element) -> Found<Option<NodeId>> {
        let name = self.reference(element, "ref")?;
        if let Some(volume) = self.volumes.by_name.get(&name) {
            return Ok(*volume);
        }
        let known: Vec<_> = self.volumes.by_name.keys().map(String::as_str).collect();
        let help = match suggest::nearest_name(&name, known) {
            Some(near) => format!("did you mean '{near}'?"),
            None => "a volume comes after those that are placed in it".into(),
        };
        let message = format!("there is no volume '{name}' before this line");
        Err(self.report(element, Some("ref"), message, help))
    }

    /// The volume of a module: of its default setup, or the one that is named.
    fn file(&mut self, element: Element) -> Found<Option<NodeId>> {
        let file = self.text(element, "name")?.to_owned();
        let (here, _) = super::texts::place_of(self.texts, element);
        let folder = crate::paths::folder_of(&self.texts[here].path).to_path_buf();
        let path = resolve(&folder, &self.reader.folder, &file, self.reader.options.paths);
        let path = path.map_err(|refusal| self.report(element, Some("name"), refusal.why, refusal.help))?;
        if !self.reader.modules.contains_key(&path) {
            if self.reader.open.contains(&path) {
                let message = format!("'{file}' includes itself");
                return Err(self.report(element, Some("name"), message, "remove the cycle of files"));
            }
            let main = read_regular(&path, MAX_BYTES).and_then(|bytes| Text::of(&path, bytes));
            let texts =
                main.and_then(|main| read_texts(main, &self.reader.folder, self.reader.options.paths));
            self.reader.open.push(path.clone());
            let volumes = texts.and_then(|texts| self.reader.module(texts, false));
            self.reader.open.pop();
            if let Err(error) = &volumes {
                let message = format!("this module cannot be read: {}", error.brief(&file));
                self.report(element, Some("name"), message, "correct the module");
            }
            self.reader.modules.insert(path.clone(), volumes.ok());
        }
        let Some(volumes) = &self.reader.modules[&path] else { return Err(Reported) };
        let found = match element.attribute("volname") {
            Some(name) => volumes.by_name.get(name).copied(),
            None => volumes.world().map(|(_, world)| *world),
        };
        found.ok_or_else(|| {
            let message = format!("'{file}' has no such volume");
            self.report(element, Some("volname"), message, "name a volume of that file, or give it a setup")
        })
    }
}

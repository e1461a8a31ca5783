//! Volumes that are placed many times by one element: replicas, divisions and parameterised volumes.

use shotline::math::{Lattice, Vec3};
use shotline::scene::{Node, NodeId};

use super::attributes::{Found, Reported};
use super::placements::Placement;
use super::units::Measure;
use super::{Element, Module, elements, tag};
use crate::suggest;

/// The direction in which copies follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    /// x, y or z.
    Straight(usize),
    /// Away from the z axis.
    Rho,
    /// About the z axis.
    Phi,
}

impl Axis {
    fn measure(self) -> Measure {
        if self == Axis::Phi { Measure::Angle } else { Measure::Length }
    }
}

/// Copies along an axis, each as wide as the others.
#[derive(Clone, Copy, Debug)]
struct Copies {
    axis: Axis,
    count: usize,
    width: f64,
    offset: f64,
}

/// From so many copies on a lattice computes where they are. Fewer are listed: rays find these in lanes.
const LEAST_IN_LATTICE: usize = 256;

impl Copies {
    /// The axis of a lattice that holds the copies; `None` where they are listed.
    fn in_lattice(&self) -> Option<usize> {
        match self.axis {
            Axis::Straight(axis) if self.count >= LEAST_IN_LATTICE => Some(axis),
            _ => None,
        }
    }
}

impl Module<'_> {
    /// Copies of a volume in a row along an axis, of which the first is at `first`.
    fn lattice(
        &mut self,
        element: Element,
        volume: NodeId,
        copies: Copies,
        axis: usize,
        first: f64,
        label: String,
    ) -> Found<Vec<NodeId>> {
        let (mut counts, mut pitch, mut start) = ([1; 3], [0.0; 3], Vec3::ZERO);
        (counts[axis], pitch[axis], start[axis]) = (copies.count as u32, copies.width, first);
        let named = self.placed(element, volume, &Placement::NONE, label);
        let lattice = Lattice::rectangular(counts, pitch);
        let row = self.add(element, Node::Lattice { lattice, elements: vec![named], table: None });
        // In the names of paths the copies are directly in their mother.
        Ok(vec![self.placed(element, row, &Placement::at(start), String::new())])
    }

    /// Replicas fill their mother; those along x, y and z are centred in it.
    pub(super) fn replicas(&mut self, element: Element) -> Found<Vec<NodeId>> {
        let count = self.count(element, "number")?;
        let Some((volume, name)) = self.copied_volume(element)? else { return Err(Reported) };
        let Some(along) = elements(element).find(|child| tag(*child) == "replicate_along_axis") else {
            let help = "add <replicate_along_axis>";
            return Err(self.report(element, None, "the replicas have no axis", help));
        };
        let copies = self.replicate_along(along, count)?;
        let middle = (count - 1) as f64 * 0.5;
        if let Some(axis) = copies.in_lattice() {
            return self.lattice(
                element,
                volume,
                copies,
                axis,
                -(copies.width * middle),
                format!("{name}_PV"),
            );
        }
        self.count_copies(element, count)?;
        let mut placed = Vec::with_capacity(count);
        for i in 0..count {
            let number = i as f64;
            let (volume, placement) = match copies.axis {
                Axis::Straight(axis) => {
                    let mut position = Vec3::ZERO;
                    position[axis] = copies.width * (number - middle);
                    (volume, Placement::at(position))
                }
                // The placement of a volume turns the mother's frame.
                Axis::Phi => (volume, Placement::turned(-(copies.offset + copies.width * (number + 0.5)))),
                Axis::Rho => {
                    let rmin = copies.offset + copies.width * number;
                    (self.shell(element, volume, [rmin, rmin + copies.width])?, Placement::NONE)
                }
            };
            placed.push(self.placed(element, volume, &placement, format!("{name}_PV[{i}]")));
        }
        Ok(placed)
    }

    fn replicate_along(&mut self, along: Element, count: usize) -> Found<Copies> {
        let (mut axis, mut extent) = (None, [None, Some(0.0)]);
        if let Some(direction) = elements(along).find(|child| tag(*child) == "direction") {
            let axes = [("x", 0), ("y", 1), ("z", 2)].map(|(key, i)| (key, Axis::Straight(i)));
            for (key, of_key) in axes.into_iter().chain([("rho", Axis::Rho), ("phi", Axis::Phi)]) {
                if self.number_or(direction, key, 0.0)? == 1.0 {
                    axis = Some(of_key);
                }
            }
        }
        let Some(axis) = axis else {
            let help = "add <direction x=\"1\"/>, or y, z, rho or phi";
            return Err(self.report(along, None, "the direction of the replicas is not given", help));
        };
        for (length, key) in extent.iter_mut().zip(["width", "offset"]) {
            if let Some(child) = elements(along).find(|child| tag(*child) == key) {
                *length = Some(self.number(child, "value")? * self.factor(child, "unit", axis.measure())?);
            }
        }
        match extent {
            [Some(width), offset] if width > 0.0 => {
                Ok(Copies { axis, count, width, offset: offset.unwrap_or(0.0) })
            }
            _ => Err(self.report(
                along,
                None,
                "the replicas have no positive width",
                "add <width value=\"...\"/>",
            )),
        }
    }

    /// The volume that copies are made of, and its name.
    fn copied_volume(&mut self, element: Element) -> Found<Option<(NodeId, String)>> {
        let Some(child) = elements(element).find(|child| tag(*child) == "volumeref") else {
            let message = format!("<{}> names no volume", tag(element));
            return Err(self.report(element, None, message, "add <volumeref ref=\"...\"/>"));
        };
        let name = self.reference(child, "ref")?;
        Ok(self.volume_of(child)?.map(|volume| (volume, name)))
    }

    /// Divisions have the shape of a part of their mother.
    pub(super) fn divisions(&mut self, element: Element, mother: NodeId) -> Found<Vec<NodeId>> {
        let Some((volume, name)) = self.copied_volume(element)? else { return Err(Reported) };
        let axes =
            [("kXAxis", Axis::Straight(0)), ("kYAxis", Axis::Straight(1)), ("kZAxis", Axis::Straight(2))];
        let axes: Vec<_> = axes.into_iter().chain([("kRho", Axis::Rho), ("kPhi", Axis::Phi)]).collect();
        let written = self.text(element, "axis")?;
        let Some((_, axis)) = axes.iter().find(|(known, _)| *known == written) else {
            let known: Vec<_> = axes.iter().map(|(name, _)| *name).collect();
            let message = format!("'{written}' is no axis");
            return Err(self.report(element, Some("axis"), message, suggest::hint(written, &known)));
        };
        let Some([low, high]) = self.extent(mother, *axis) else {
            let kind = self.kind_of(mother);
            return Err(self.unsupported(element, format!("<divisionvol> of a {kind} along {written}")));
        };
        let copies = self.division(element, *axis, high - low)?;
        if let Some(axis) = copies.in_lattice() {
            let half = copies.width * 0.5;
            let solid = self.cut(element, mother, axis, half)?;
            let volume = self.with_solid(element, volume, solid)?;
            let label = element.attribute("name").map_or_else(|| format!("{name}_PV"), str::to_owned);
            return self.lattice(element, volume, copies, axis, low + copies.offset + half, label);
        }
        self.count_copies(element, copies.count)?;
        let mut placed = Vec::with_capacity(copies.count);
        for i in 0..copies.count {
            let start = copies.offset + copies.width * i as f64;
            let (solid, placement) = match *axis {
                Axis::Straight(axis) => {
                    let half = copies.width * 0.5;
                    let mut position = Vec3::ZERO;
                    position[axis] = low + start + half;
                    (self.cut(element, mother, axis, half), Placement::at(position))
                }
                Axis::Phi => {
                    let changed = [("phi0", low), ("dphi", copies.width)];
                    (self.changed(element, mother, &changed), Placement::turned(-start))
                }
                Axis::Rho => {
                    let changed = [("rmin", low + start), ("rmax", low + start + copies.width)];
                    (self.changed(element, mother, &changed), Placement::NONE)
                }
            };
            let volume = self.with_solid(element, volume, solid?)?;
            let label = match element.attribute("name") {
                Some(label) => format!("{label}[{i}]"),
                None => format!("{name}_PV[{i}]"),
            };
            placed.push(self.placed(element, volume, &placement, label));
        }
        Ok(placed)
    }

    /// How many divisions there are, and how wide they are: one of the two may follow from the mother's extent.
    fn division(&mut self, element: Element, axis: Axis, extent: f64) -> Found<Copies> {
        let unit = self.factor(element, "unit", axis.measure())?;
        let offset = self.number_or(element, "offset", 0.0)? * unit;
        let width = self.number_or(element, "width", 0.0)? * unit;
        let count = if element.has_attribute("number") { self.number(element, "number")? } else { 0.0 };
        let copies = match (count >= 1.0, width > 0.0) {
            (true, true) => (count, width),
            (true, false) => (count, (extent - offset) / count),
            // Rounding must not lose the last.
            (false, true) => (((extent - offset) / width + 1e-9).floor(), width),
            (false, false) => (0.0, 0.0),
        };
        match copies {
            (count, width) if (1.0..1e9).contains(&count) && width > 0.0 => {
                Ok(Copies { axis, count: count as usize, width, offset })
            }
            (count, width) => {
                let message = format!("there would be {count} divisions of a width of {width}");
                let help = "give a \"number\" from 1, a positive \"width\", or both";
                Err(self.report(element, None, message, help))
            }
        }
    }

    /// The kind of a solid, for messages.
    fn kind_of(&self, solid: NodeId) -> &'static str {
        match self.reader.scene.node(solid) {
            Node::Solid { kind, .. } => kind.name,
            Node::Mesh { .. } => "tessellated solid",
            _ => "combination",
        }
    }

    /// The number of a parameter of a solid; a cylinder has those of a tube.
    fn parameter(&self, solid: NodeId, name: &str, index: usize) -> Option<f64> {
        let Node::Solid { kind, params } = self.reader.scene.node(solid) else { return None };
        let name = match (kind.name, name) {
            ("cylinder", "rmin" | "phi0") => return Some(0.0),
            ("cylinder", "dphi") => return Some(360.0),
            ("cylinder", "rmax") => "radius",
            _ => name,
        };
        params.entries.iter().find(|(known, _)| *known == name)?.1.get(index).copied()
    }

    /// From where to where a box or a tube reaches along an axis.
    fn extent(&self, solid: NodeId, axis: Axis) -> Option<[f64; 2]> {
        let of = |name, index| self.parameter(solid, name, index);
        match (self.kind_of(solid), axis) {
            ("box", Axis::Straight(axis)) => Some([of("min", axis)?, of("max", axis)?]),
            ("tube" | "cylinder", Axis::Straight(2)) => Some([of("z0", 0)?, of("z1", 0)?]),
            ("tube" | "cylinder", Axis::Rho) => Some([of("rmin", 0)?, of("rmax", 0)?]),
            ("tube" | "cylinder", Axis::Phi) => {
                let phi0 = of("phi0", 0)?;
                Some([phi0, phi0 + of("dphi", 0)?])
            }
            _ => None,
        }
    }

    /// A box or a tube with a half length along an axis, centred there.
    fn cut(&mut self, element: Element, solid: NodeId, axis: usize, half: f64) -> Found<NodeId> {
        if self.kind_of(solid) != "box" {
            return self.changed(element, solid, &[("z0", -half), ("z1", half)]);
        }
        let mut corner = [0.0; 3];
        for (i, x) in corner.iter_mut().enumerate() {
            *x = if i == axis { half } else { self.parameter(solid, "max", i).unwrap_or(0.0) };
        }
        self.of_kind(element, "box", &[&corner.map(|x| -x), &corner])
    }

    /// A tube with some of its parameters changed.
    fn changed(&mut self, element: Element, solid: NodeId, changes: &[(&str, f64)]) -> Found<NodeId> {
        let value = |name: &str| {
            let changed = changes.iter().find(|(changed, _)| *changed == name).map(|(_, value)| *value);
            changed.or_else(|| self.parameter(solid, name, 0))
        };
        let values = ["rmin", "rmax", "z0", "z1", "phi0", "dphi"].map(|name| [value(name).unwrap_or(0.0)]);
        let values: Vec<&[f64]> = values.iter().map(|value| &value[..]).collect();
        self.of_kind(element, "tube", &values)
    }

    /// A volume with its tube between two other radii.
    fn shell(&mut self, element: Element, volume: NodeId, [rmin, rmax]: [f64; 2]) -> Found<NodeId> {
        let solid = match self.reader.scene.node(volume) {
            Node::Object { node, .. } => *node,
            _ => volume,
        };
        if self.extent(solid, Axis::Rho).is_none() {
            let kind = self.kind_of(solid);
            return Err(self.unsupported(element, format!("<replicavol> of a {kind} along rho")));
        }
        let solid = self.changed(element, solid, &[("rmin", rmin), ("rmax", rmax)])?;
        self.with_solid(element, volume, solid)
    }

    /// A copy of a volume with another solid.
    fn with_solid(&mut self, element: Element, volume: NodeId, solid: NodeId) -> Found<NodeId> {
        let mut copy = self.reader.scene.node(volume).clone();
        match &mut copy {
            Node::Object { node, .. } => *node = solid,
            _ => {
                let message = "an assembly has no solid that could be changed";
                return Err(self.report(element, None, message, "name a volume"));
            }
        }
        Ok(self.add(element, copy))
    }

    /// Copies, each with a placement and dimensions of its own.
    pub(super) fn parameterised(&mut self, element: Element) -> Found<Vec<NodeId>> {
        let Some((volume, name)) = self.copied_volume(element)? else { return Err(Reported) };
        let (mut placed, reported) = (Vec::new(), self.reader.reported());
        for child in elements(element) {
            self.parameters(child, volume, &name, &mut placed);
        }
        if placed.is_empty() && self.reader.reported() == reported {
            let help = "add <parameterised_position_size> with <parameters>";
            return Err(self.report(element, None, "the volume is placed nowhere", help));
        }
        Ok(placed)
    }

    fn parameters(&mut self, element: Element, volume: NodeId, name: &str, placed: &mut Vec<NodeId>) {
        match tag(element) {
            // One directly in another means nothing, and could be nested without end.
            outer @ "parameterised_position_size" => {
                for child in elements(element).filter(|child| tag(*child) != outer) {
                    self.parameters(child, volume, name, placed);
                }
            }
            "loop" => {
                // What is wrong has been reported.
                let _ = self.repeat(element, &mut |module, child| {
                    module.parameters(child, volume, name, placed);
                });
            }
            "parameters" => {
                let label = format!("{name}_param[{}]", placed.len());
                placed.extend(self.parameterised_copy(element, volume, label));
            }
            _ => {}
        }
    }

    fn parameterised_copy(&mut self, element: Element, volume: NodeId, label: String) -> Found<NodeId> {
        self.count_copies(element, 1)?;
        let (mut copy, mut placement) = (volume, Placement::NONE);
        for child in elements(element) {
            if let Some(shape) = tag(child).strip_suffix("_dimensions") {
                let solid = self.dimensions(child, shape)?;
                copy = self.with_solid(child, volume, solid)?;
            } else if !self.place(child, "", &mut placement)? {
                let message = format!("<{}> has no meaning in <parameters>", tag(child));
                return Err(self.report(child, None, message, "it has a placement and dimensions"));
            }
        }
        Ok(self.placed(element, copy, &placement, label))
    }

    /// The solid of some dimensions, some of which have other names than the attributes of the solid.
    fn dimensions(&mut self, element: Element, shape: &str) -> Found<NodeId> {
        self.renamed = match shape {
            "tube" => &[
                ("rmin", "InR"),
                ("rmax", "OutR"),
                ("z", "hz"),
                ("startphi", "StartPhi"),
                ("deltaphi", "DeltaPhi"),
            ],
            "polycone" | "polyhedra" => {
                &[("startphi", "startPhi"), ("deltaphi", "openPhi"), ("numsides", "numSide")]
            }
            _ => &[],
        };
        let solid = self.shape(element, shape);
        self.renamed = &[];
        solid
    }
}

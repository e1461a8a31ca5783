//! A scene to the text of a scene file. Every number reads back bit for bit, and a node with several parents is
//! written once, in `defs`.

use shotline::math::{Lattice, Vec3};
use shotline::scene::{
    Camera, EMPTY_CELL, Lens, Light, LightSource, LocalTransform, Material, MeshFile, Motion, Node, NodeId,
    Op, Rotation, Scene,
};
use shotline::solid::Layout;
use shotline::solid::mesh::Weld;

use super::keys::{HEXAGONAL_LATTICE, LATTICE};
use super::names::Names;
use crate::error::WriteError;

/// The text of a scene.
///
/// # Errors
/// [`WriteError::Unwritable`] for NaN, infinite numbers and meshes without a file (see [`crate::save()`]).
pub fn write_scene(scene: &Scene) -> Result<String, WriteError> {
    let mut writer = Writer { scene, names: Names::of(scene), refused: None };
    let text = writer.document();
    match writer.refused {
        None => Ok(text),
        Some(why) => Err(WriteError::Unwritable(why)),
    }
}

struct Writer<'s> {
    scene: &'s Scene,
    names: Names,
    /// The first thing that cannot be written.
    refused: Option<String>,
}

/// An item still to be written. Items are kept in a list, so that deep scenes need no deep stack.
enum Step {
    Text(String),
    /// A node in full.
    Body {
        id: NodeId,
        depth: usize,
    },
    /// A node, or a reference to it if it has a name.
    NodeOrRef {
        id: NodeId,
        depth: usize,
    },
}

/// A key of a node with its value.
enum Field {
    Plain(String),
    Node(&'static str, NodeId),
    Nodes(&'static str, Vec<NodeId>),
}

impl Writer<'_> {
    fn document(&mut self) -> String {
        let mut sections = vec![vec![Step::Text("  \"shotline\": 1".into())]];
        if let Some(units) = self.scene.units {
            sections.push(vec![Step::Text(format!("  \"units\": {}", quoted(units.name())))]);
        }
        if !self.names.defs.is_empty() {
            sections.push(section("defs", '{', self.defs(), '}'));
        }
        let objects = self.scene.objects.iter().map(|id| vec![Step::NodeOrRef { id: *id, depth: 2 }]);
        sections.push(section("objects", '[', objects.collect(), ']'));
        if let Some(accel) = self.scene.accel {
            sections.push(vec![Step::Text(format!("  \"accel\": {}", quoted(accel)))]);
        }
        let materials: Vec<_> = self.scene.materials.iter().map(|(name, m)| self.material(name, m)).collect();
        if !materials.is_empty() {
            sections.push(section("materials", '{', materials, '}'));
        }
        if let Some(camera) = &self.scene.camera {
            sections.push(vec![Step::Text(format!("  \"camera\": {}", self.camera(camera)))]);
        }
        let lights: Vec<_> = self.scene.lights.iter().map(|l| vec![Step::Text(self.light(l))]).collect();
        if !lights.is_empty() {
            sections.push(section("lights", '[', lights, ']'));
        }
        let motions: Vec<_> = self.scene.motions.iter().map(|m| vec![Step::Text(self.motion(m))]).collect();
        if !motions.is_empty() {
            sections.push(section("motions", '[', motions, ']'));
        }
        let mut steps = vec![Step::Text("{\n".into())];
        separate(&mut steps, sections, ",\n");
        steps.push(Step::Text("\n}\n".into()));
        self.run(steps)
    }

    fn run(&mut self, mut todo: Vec<Step>) -> String {
        let mut out = String::new();
        todo.reverse();
        while let Some(step) = todo.pop() {
            let (id, depth) = match step {
                Step::Text(text) => {
                    out.push_str(&text);
                    continue;
                }
                Step::NodeOrRef { id, depth } => match self.names.of.get(&id) {
                    Some(name) => {
                        out.push_str(&format!("{{ \"ref\": {} }}", quoted(name)));
                        continue;
                    }
                    None => (id, depth),
                },
                Step::Body { id, depth } => (id, depth),
            };
            let fields = self.fields(id);
            todo.extend(layout(fields, depth).into_iter().rev());
        }
        out
    }

    fn defs(&self) -> Vec<Vec<Step>> {
        let entry = |(name, id): &(String, NodeId)| {
            let key = Step::Text(format!("{}: ", quoted(name)));
            // A second name of a node refers to the first.
            let first = self.names.of.get(id) == Some(name);
            vec![
                key,
                if first { Step::Body { id: *id, depth: 2 } } else { Step::NodeOrRef { id: *id, depth: 2 } },
            ]
        };
        self.names.defs.iter().map(entry).collect()
    }

    /// The keys of a node. The keys of a transform are written with those of its child, which is not a transform or has a
    /// name.
    fn fields(&mut self, id: NodeId) -> Vec<Field> {
        let Node::Transform { transform, child } = self.scene.node(id) else { return self.own_fields(id) };
        let mut fields = match self.names.of.get(child) {
            Some(name) => vec![Field::Plain(format!("\"ref\": {}", quoted(name)))],
            None => self.own_fields(*child),
        };
        let nested = fields.iter().position(|f| !matches!(f, Field::Plain(_))).unwrap_or(fields.len());
        let label = self.scene.labels.get(&id);
        let label = label.map(|label| format!("\"label\": {}", quoted(label)));
        let placement = self.placement(transform, label).into_iter().map(Field::Plain).collect::<Vec<_>>();
        fields.splice(nested..nested, placement);
        fields
    }

    fn own_fields(&mut self, id: NodeId) -> Vec<Field> {
        let mut fields = self.fields_of_kind(id);
        // After the key that determines the form of the node.
        // The format gives an accelerator only to nodes that use one.
        let may_have_accel =
            matches!(self.scene.node(id), Node::Mesh { .. } | Node::Csg { .. } | Node::Group { .. });
        let accel = self.scene.accels.get(&id).filter(|_| may_have_accel);
        let accel = accel.map(|name| format!("\"accel\": {}", quoted(name)));
        fields.splice(1.min(fields.len())..1.min(fields.len()), accel.map(Field::Plain));
        fields
    }

    fn fields_of_kind(&mut self, id: NodeId) -> Vec<Field> {
        let scene = self.scene;
        match scene.node(id) {
            Node::Solid { kind, params } => {
                let mut fields = vec![Field::Plain(format!("\"kind\": {}", quoted(kind.name)))];
                for (name, numbers) in &params.entries {
                    let value = match (kind.layout(name), &numbers[..]) {
                        (Some(Layout::Rows { columns, .. }), numbers) => {
                            let rows = numbers.chunks(columns.len()).map(|row| self.numbers(row));
                            format!("[{}]", rows.collect::<Vec<_>>().join(", "))
                        }
                        (_, [x]) => self.number(*x),
                        (_, numbers) => self.numbers(numbers),
                    };
                    fields.push(Field::Plain(format!("{}: {value}", quoted(name))));
                }
                fields
            }
            Node::Mesh { file, .. } => self.mesh(file.as_ref()),
            Node::Csg { op, args } => {
                let op = match op {
                    Op::Union => "union",
                    Op::Intersection => "intersection",
                    Op::Difference => "difference",
                };
                vec![Field::Plain(format!("\"op\": \"{op}\"")), Field::Nodes("args", args.clone())]
            }
            Node::Group { members } => {
                vec![Field::Plain("\"op\": \"group\"".into()), Field::Nodes("args", members.clone())]
            }
            Node::Lattice { lattice, elements, table } => self.lattice(lattice, elements, table.as_deref()),
            Node::Object { name, material, priority, node, contents, clip } => {
                let mut fields = vec![Field::Plain(format!("\"name\": {}", quoted(name)))];
                fields.extend(material.iter().map(|m| Field::Plain(format!("\"material\": {}", quoted(m)))));
                if *priority != 0 {
                    fields.push(Field::Plain(format!("\"priority\": {priority}")));
                }
                if *clip {
                    fields.push(Field::Plain("\"clip\": true".into()));
                }
                fields.push(Field::Node("node", *node));
                if !contents.is_empty() {
                    fields.push(Field::Nodes("contents", contents.clone()));
                }
                fields
            }
            // Reached only below a transform, where such a node has a name.
            Node::Transform { .. } => Vec::new(),
        }
    }

    fn lattice(&mut self, lattice: &Lattice, elements: &[NodeId], table: Option<&[u32]>) -> Vec<Field> {
        let mut keys = match *lattice {
            Lattice::Rectangular { counts, pitch, stagger } => {
                let mut keys = vec![
                    format!("\"op\": \"{LATTICE}\""),
                    format!("\"counts\": {}", self.numbers(&counts.map(f64::from))),
                    format!("\"pitch\": {}", self.numbers(&pitch)),
                ];
                keys.extend(stagger.then(|| "\"stagger\": true".into()));
                keys
            }
            Lattice::Hexagonal { rings, pitch, layers, height } => vec![
                format!("\"op\": \"{HEXAGONAL_LATTICE}\""),
                format!("\"rings\": {rings}"),
                format!("\"pitch\": {}", self.number(pitch)),
                format!("\"layers\": {layers}"),
                format!("\"height\": {}", self.number(height)),
            ],
        };
        keys.extend(table.map(|table| {
            let cell = |&element: &u32| match element {
                EMPTY_CELL => "null".into(),
                element => element.to_string(),
            };
            format!("\"cells\": [{}]", table.iter().map(cell).collect::<Vec<_>>().join(", "))
        }));
        let keys = keys.into_iter().map(Field::Plain);
        keys.chain([Field::Nodes("args", elements.to_vec())]).collect()
    }

    fn mesh(&mut self, file: Option<&MeshFile>) -> Vec<Field> {
        let Some(MeshFile { name, weld }) = file else {
            self.refuse("a mesh that was not read from a file: the scene cannot name its file".into());
            return Vec::new();
        };
        let mut keys = vec!["\"kind\": \"mesh\"".into(), format!("\"file\": {}", quoted(name))];
        keys.extend(weld.map(|weld| match weld {
            Weld::Auto => "\"weld\": \"auto\"".into(),
            Weld::Within(distance) => format!("\"weld\": {}", self.number(distance)),
        }));
        keys.into_iter().map(Field::Plain).collect()
    }

    fn placement(&mut self, transform: &LocalTransform, label: Option<String>) -> Vec<String> {
        let mut keys: Vec<_> = label.into_iter().collect();
        let (scale, rotate, translate) = match *transform {
            LocalTransform::Matrix(matrix) => {
                keys.push(format!("\"transform\": {}", self.numbers(matrix.rows.as_flattened())));
                return keys;
            }
            // A transform without steps must have some key.
            LocalTransform::Steps { scale: None, rotate: None, translate: None } if keys.is_empty() => {
                (Some(Vec3::ONE), None, None)
            }
            LocalTransform::Steps { scale, rotate, translate } => (scale, rotate, translate),
        };
        if let Some(s) = scale {
            let same = s.y.to_bits() == s.x.to_bits() && s.z.to_bits() == s.x.to_bits();
            let factors = if same { self.number(s.x) } else { self.vector(s) };
            keys.push(format!("\"scale\": {factors}"));
        }
        keys.extend(rotate.map(|rotation| self.rotation(rotation)));
        keys.extend(translate.map(|t| format!("\"translate\": {}", self.vector(t))));
        keys
    }

    fn rotation(&mut self, rotation: Rotation) -> String {
        match rotation {
            Rotation::Xyz(angles) => format!("\"rotate\": {}", self.vector(angles)),
            Rotation::About { axis, degrees } => {
                let (axis, degrees) = (self.vector(axis), self.number(degrees));
                format!("\"rotate\": {{ \"axis\": {axis}, \"degrees\": {degrees} }}")
            }
        }
    }

    fn material(&mut self, name: &str, material: &Material) -> Vec<Step> {
        let Material { mu, density, ref composition, color, specular, shininess, mirror } = *material;
        let mut keys = Vec::new();
        for (key, value) in [("mu", mu), ("density", density)] {
            keys.extend(value.map(|x| format!("\"{key}\": {}", self.number(x))));
        }
        if !composition.is_empty() {
            let shares =
                composition.iter().map(|(name, share)| format!("{}: {}", quoted(name), self.number(*share)));
            let shares: Vec<_> = shares.collect();
            keys.push(format!("\"composition\": {}", braced(&shares)));
        }
        keys.extend(color.map(|c| format!("\"color\": {}", self.numbers(&c))));
        for (key, value) in [("specular", specular), ("shininess", shininess), ("mirror", mirror)] {
            keys.extend(value.map(|x| format!("\"{key}\": {}", self.number(x))));
        }
        vec![Step::Text(format!("{}: {}", quoted(name), braced(&keys)))]
    }

    fn camera(&mut self, camera: &Camera) -> String {
        let mut keys = Vec::new();
        for (key, v) in [("eye", camera.eye), ("target", camera.target), ("up", camera.up)] {
            keys.push(format!("\"{key}\": {}", self.vector(v)));
        }
        keys.push(match camera.lens {
            Lens::Pinhole { fov } => format!("\"fov\": {}", self.number(fov)),
            Lens::Orthographic { height } => format!("\"height\": {}", self.number(height)),
        });
        braced(&keys)
    }

    fn light(&mut self, light: &Light) -> String {
        let mut keys = vec![match light.source {
            LightSource::Point(p) => format!("\"point\": {}", self.vector(p)),
            LightSource::Directional(d) => format!("\"direction\": {}", self.vector(d)),
            LightSource::Ambient => "\"ambient\": true".into(),
        }];
        keys.extend(light.color.map(|c| format!("\"color\": {}", self.numbers(&c))));
        keys.extend(light.intensity.map(|x| format!("\"intensity\": {}", self.number(x))));
        braced(&keys)
    }

    fn motion(&mut self, motion: &Motion) -> String {
        let mut keys = vec![format!("\"object\": {}", quoted(&motion.object))];
        keys.extend(motion.rotate.map(|rotation| self.rotation(rotation)));
        for (key, v) in [("about", motion.about), ("translate", motion.translate)] {
            keys.extend(v.map(|v| format!("\"{key}\": {}", self.vector(v))));
        }
        braced(&keys)
    }

    /// The shortest digits that read back as the same float64.
    fn number(&mut self, x: f64) -> String {
        if !x.is_finite() {
            self.refuse(format!("the number {x}: a scene file holds finite numbers only"));
        }
        let text = format!("{x:?}");
        match text.strip_suffix(".0") {
            // Readers with an integer type would lose the sign of "-0".
            Some(whole) if whole != "-0" => whole.to_string(),
            _ => text,
        }
    }

    fn numbers(&mut self, numbers: &[f64]) -> String {
        let all: Vec<_> = numbers.iter().map(|x| self.number(*x)).collect();
        format!("[{}]", all.join(", "))
    }

    fn vector(&mut self, v: Vec3) -> String {
        self.numbers(&v.to_array())
    }

    fn refuse(&mut self, why: String) {
        self.refused.get_or_insert(why);
    }
}

fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

fn braced(keys: &[String]) -> String {
    if keys.is_empty() { "{}".into() } else { format!("{{ {} }}", keys.join(", ")) }
}

/// A key of the file whose entries are written one per line.
fn section(key: &str, open: char, entries: Vec<Vec<Step>>, close: char) -> Vec<Step> {
    if entries.is_empty() {
        return vec![Step::Text(format!("  \"{key}\": {open}{close}"))];
    }
    let mut steps = vec![Step::Text(format!("  \"{key}\": {open}\n    "))];
    separate(&mut steps, entries, ",\n    ");
    steps.push(Step::Text(format!("\n  {close}")));
    steps
}

fn separate(steps: &mut Vec<Step>, entries: Vec<Vec<Step>>, separator: &str) {
    for (i, entry) in entries.into_iter().enumerate() {
        if i > 0 {
            steps.push(Step::Text(separator.into()));
        }
        steps.extend(entry);
    }
}

/// The fields of a node: on one line if it has no nodes below it.
fn layout(fields: Vec<Field>, depth: usize) -> Vec<Step> {
    if fields.iter().all(|f| matches!(f, Field::Plain(_))) {
        let keys: Vec<_> =
            fields.into_iter().filter_map(|f| if let Field::Plain(k) = f { Some(k) } else { None }).collect();
        return vec![Step::Text(braced(&keys))];
    }
    // Without a limit, the indentation of thousands of levels would be most of the file.
    let pad = |depth: usize| "  ".repeat(depth.min(32));
    let (inner, innermost) = (pad(depth + 1), pad(depth + 2));
    let entries = fields.into_iter().map(|field| match field {
        Field::Plain(key) => vec![Step::Text(key)],
        Field::Node(key, id) => {
            vec![Step::Text(format!("\"{key}\": ")), Step::NodeOrRef { id, depth: depth + 1 }]
        }
        Field::Nodes(key, ids) if ids.is_empty() => vec![Step::Text(format!("\"{key}\": []"))],
        Field::Nodes(key, ids) => {
            let mut steps = vec![Step::Text(format!("\"{key}\": [\n{innermost}"))];
            let nodes = ids.into_iter().map(|id| vec![Step::NodeOrRef { id, depth: depth + 2 }]).collect();
            separate(&mut steps, nodes, &format!(",\n{innermost}"));
            steps.push(Step::Text(format!("\n{inner}]")));
            steps
        }
    });
    let mut steps = vec![Step::Text(format!("{{\n{inner}"))];
    separate(&mut steps, entries.collect(), &format!(",\n{inner}"));
    steps.push(Step::Text(format!("\n{}}}", pad(depth))));
    steps
}

//! `shotline info`: the size of a model.

use std::collections::BTreeMap;
use std::time::Instant;

use clap::Args;
use serde_json::{Value, json};
use shotline::aabb::Aabb;
use shotline::compile::{Stats, World};
use shotline::scene::{Material, Node, NodeId, Op, Scene, Units};
use shotline_io::Note;

use crate::failure::Failure;
use crate::findings::note_to_json;
use crate::flags::{Build, Model};
use crate::nesting::Nesting;
use crate::number::{bytes, counted, grouped, json as number, json_vector, short, short_bounds};
use crate::table::{Align, Table};
use crate::{empty_objects, input, output};

/// Report the size of a model
///
/// Nodes, objects, leaves, bounds, materials, memory and the time to load and build it. Shared leaves and objects are counted
/// once; virtual leaves and instances count every placement, as a ray meets them. Notes name what the readers of the files ignored,
/// dropped or repaired, how many times, and the first line or byte. Notes also name empty objects.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    #[command(flatten)]
    build: Build,
    /// Print one JSON document instead. A bound that is infinite is null there: in `min` it stands for minus,
    /// in `max` for plus infinity. `bounds` itself is null if there is nothing
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  shotline info engine.json
  shotline info bunny.ply --json
  shotline info detector.gdml";

/// The maximum number of objects that the text lists; --json lists all.
const MAX_LISTED: usize = 40;

/// What the command reports.
struct Report {
    accel: &'static str,
    units: Option<Units>,
    stats: Stats,
    bounds: Aabb,
    load_s: f64,
    build_s: f64,
    nesting: Nesting,
    objects: Vec<ObjectLine>,
    materials: Vec<(String, Material)>,
    /// The names of objects that are empty by construction.
    empty: Vec<String>,
    notes: Vec<Note>,
}

struct ObjectLine {
    name: String,
    material: Option<String>,
    body: String,
}

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        let begin = Instant::now();
        let document = input::load(&self.model)?;
        let loaded = Instant::now();
        let world: World = input::compile(&document, &self.build)?;
        let report = Report {
            accel: self.build.scene_accel(&document.scene),
            units: document.scene.units,
            stats: world.stats(),
            bounds: world.bounds(),
            load_s: (loaded - begin).as_secs_f64(),
            build_s: loaded.elapsed().as_secs_f64(),
            nesting: Nesting::of(&document.scene),
            objects: objects(&document.scene),
            materials: document.scene.materials.clone(),
            empty: empty_objects::by_construction(&world, &document.scene)
                .into_iter()
                .map(|object| world.object_names()[object as usize].clone())
                .collect(),
            notes: document.notes,
        };
        output::print(&if self.json { format!("{:#}\n", report.to_json()) } else { report.to_text() })?;
        Ok(0)
    }
}

impl Report {
    fn to_json(&self) -> Value {
        let bounds = json!({ "min": json_vector(self.bounds.min), "max": json_vector(self.bounds.max) });
        json!({
            "nodes": self.stats.nodes,
            "objects": self.stats.objects,
            "leaves": self.stats.leaves,
            "virtual_leaves": self.stats.virtual_leaves,
            "instances": self.nesting.instances,
            "depth": self.nesting.depth,
            "bounds": if self.bounds.is_empty() { Value::Null } else { bounds },
            "units": self.units.map(Units::name),
            "memory_bytes": self.stats.memory_bytes,
            "condition": number(self.stats.condition),
            "accel": self.accel,
            "load_s": number(self.load_s),
            "build_s": number(self.build_s),
            "object_list": self.objects.iter().map(|o| json!({
                "name": o.name,
                "material": o.material,
                "body": o.body,
            })).collect::<Vec<_>>(),
            "materials": self.materials.iter().map(|(name, material)| json!({
                "name": name,
                "density": material.density.map(number),
                "mu": material.mu.map(number),
                "composition": material.composition.iter().cloned().collect::<BTreeMap<_, _>>(),
            })).collect::<Vec<_>>(),
            "empty_objects": self.empty,
            "notes": self.notes.iter().map(note_to_json).collect::<Vec<_>>(),
        })
    }

    fn to_text(&self) -> String {
        let units = self.units.map_or_else(String::new, |u| format!(" {u}"));
        let bounds = if self.bounds.is_empty() {
            "nothing".to_string()
        } else {
            format!("{}{units}", short_bounds(&self.bounds))
        };
        let stats = &self.stats;
        let mut out = format!(
            "nodes           {}\n\
             objects         {}\n\
             instances       {}, up to {} in one another\n\
             leaves          {}\n\
             virtual leaves  {}\n\
             bounds          {bounds}\n\
             memory          {}\n\
             condition       {} (by how much the worst transform can enlarge a rounding error)\n\
             load            {} s\n\
             build           {} s with {}\n",
            grouped(stats.nodes as u64),
            grouped(stats.objects as u64),
            grouped(self.nesting.instances),
            grouped(self.nesting.depth),
            grouped(stats.leaves as u64),
            grouped(stats.virtual_leaves),
            bytes(stats.memory_bytes),
            short(stats.condition),
            short((self.load_s * 1e6).round() / 1e6),
            short((self.build_s * 1e6).round() / 1e6),
            self.accel,
        );
        out += "\n";
        out += &self.object_table();
        out += &self.material_table();
        if self.objects.is_empty() {
            out += "note: the scene has no objects\n";
        }
        for name in &self.empty {
            out += &format!("note: object '{name}' is empty\n");
        }
        for note in &self.notes {
            out += &format!("note: {note}\n");
        }
        out
    }

    fn object_table(&self) -> String {
        let column = |name: &str| (name.to_string(), Align::Left);
        let mut table = Table::new(vec![column("object"), column("material"), column("body")]);
        for o in self.objects.iter().take(MAX_LISTED) {
            let material = o.material.clone().unwrap_or_else(|| "-".into());
            table.row(vec![o.name.clone(), material, o.body.clone()]);
        }
        let mut out = table.text();
        if self.objects.len() > MAX_LISTED {
            out += &format!(
                "  and {} more; --json lists all\n",
                grouped((self.objects.len() - MAX_LISTED) as u64)
            );
        }
        out
    }
}

impl Report {
    /// The materials that have a density or elements.
    fn material_table(&self) -> String {
        let is_told = |(_, material): &&(String, Material)| {
            material.density.is_some() || !material.composition.is_empty()
        };
        let told: Vec<_> = self.materials.iter().filter(is_told).collect();
        if told.is_empty() {
            return String::new();
        }
        let names = ["material", "g/cm3", "elements by mass"].map(String::from);
        let mut table = Table::new(names.into_iter().zip([Align::Left, Align::Right, Align::Left]).collect());
        for (name, material) in told.iter().take(MAX_LISTED) {
            let density = material.density.map_or_else(|| "-".into(), short);
            table.row(vec![name.clone(), density, elements(&material.composition)]);
        }
        let more = told.len().saturating_sub(MAX_LISTED) as u64;
        let more = if more > 0 {
            format!("  and {} more; --json lists all\n", grouped(more))
        } else {
            String::new()
        };
        format!("\n{}{more}", table.text())
    }
}

/// The elements of a material, those of the largest share first.
fn elements(composition: &[(String, f64)]) -> String {
    const MOST: usize = 6;
    let mut sorted: Vec<_> = composition.iter().collect();
    sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
    let share = |(name, share): &&(String, f64)| format!("{name} {:.2}%", share * 100.0);
    let mut shares: Vec<String> = sorted.iter().take(MOST).map(share).collect();
    if sorted.len() > MOST {
        shares.push(format!("and {} more", sorted.len() - MOST));
    }
    shares.join(", ")
}

/// Every object of the scene, in the order of the file.
fn objects(scene: &Scene) -> Vec<ObjectLine> {
    let line = |node: &Node| match node {
        Node::Object { name, material, node, .. } => {
            Some(ObjectLine { name: name.clone(), material: material.clone(), body: body(scene, *node) })
        }
        _ => None,
    };
    scene.nodes.iter().filter_map(line).collect()
}

/// The kind of body of a node, below its transforms. The scene has been compiled, so it has no cycle.
fn body(scene: &Scene, mut id: NodeId) -> String {
    loop {
        id = match scene.node(id) {
            Node::Transform { child, .. } => *child,
            Node::Solid { kind, .. } => return kind.name.to_string(),
            Node::Mesh { mesh, .. } => {
                return format!("mesh of {}", counted(mesh.faces.len() as u64, "triangle", "triangles"));
            }
            Node::Csg { op, args } => {
                return format!("{} of {}", operation(*op), grouped(args.len() as u64));
            }
            Node::Group { members } => return format!("group of {}", grouped(members.len() as u64)),
            Node::Lattice { lattice, .. } => return format!("lattice of {}", grouped(lattice.cell_count())),
            Node::Object { name, .. } => return format!("object '{name}'"),
        }
    }
}

fn operation(op: Op) -> &'static str {
    match op {
        Op::Union => "union",
        Op::Intersection => "intersection",
        Op::Difference => "difference",
    }
}

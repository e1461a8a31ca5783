//! `shotline check`: is a model sound?

use clap::Args;
use shotline::compile::{self, World};
use shotline::scene::{Node, Scene};
use shotline::solid::mesh::{Topology, TriangleMesh};

use crate::args::{Build, Model};
use crate::failure::Failure;
use crate::number::{counted, short, short_vector};
use crate::{input, output, overlap};

/// Tell what is wrong with a model
///
/// Examines every mesh and the scene as a whole and lists all that is found. Faults make a model not sound:
/// open edges and flipped faces, which leave a mesh without an inside, errors of the scene, and objects of
/// equal priority that overlap. Remarks do not: edges of more than two faces, faces without area, doubled or
/// inward faces.
///
/// Overlaps are looked for with rays along the axes, spread over the model; a small one may slip through.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    #[command(flatten)]
    build: Build,
}

const EXAMPLES: &str = "\
Exit codes: 0 sound, 1 not sound, 2 cannot be read.

Examples:
  shotline check part.stl
  shotline check engine.json && shotline cast engine.json --rays rays.npy --query segments -o out.npz";

/// What has been found out so far.
#[derive(Default)]
struct Findings {
    text: String,
    faults: usize,
}

impl Findings {
    fn line(&mut self, text: &str) {
        self.text += text;
        self.text.push('\n');
    }

    fn fault(&mut self, text: &str) {
        self.faults += 1;
        self.line(&format!("  fault: {text}"));
    }

    fn remark(&mut self, text: &str) {
        self.line(&format!("  remark: {text}"));
    }
}

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        let document = input::load(&self.model)?;
        let model = self.model.path.display();
        let mut findings = Findings::default();
        for note in &document.notes {
            findings.line(note);
        }
        for (name, mesh) in meshes(&document.scene) {
            examine(name.unwrap_or("mesh"), mesh, &mut findings);
        }
        match compile::compile(&document.scene, self.build.options()) {
            Ok(world) => overlaps(&world, &mut findings),
            Err(errors) => {
                findings.faults += errors.len();
                findings.line(&document.explain(&errors).to_string());
            }
        }
        findings.line(&match findings.faults {
            0 => format!("{model}: sound"),
            n => format!("{model}: not sound, {}", counted(n as u64, "fault", "faults")),
        });
        output::print(&findings.text)?;
        Ok(u8::from(findings.faults > 0))
    }
}

/// The meshes of a scene with the files they came from.
fn meshes(scene: &Scene) -> impl Iterator<Item = (Option<&str>, &TriangleMesh)> {
    scene.nodes.iter().filter_map(|node| match node {
        Node::Mesh { mesh, file } => Some((file.as_deref(), &**mesh)),
        _ => None,
    })
}

fn overlaps(world: &World, findings: &mut Findings) {
    match overlap::survey(world) {
        None => findings.line("not examined for overlaps: the model has no bounds"),
        Some(pairs) if pairs.is_empty() => {}
        Some(pairs) => {
            findings.line("objects of equal priority that overlap:");
            for pair in pairs {
                let (first, second) = (pair.first, pair.second);
                let (rays, point) = (counted(pair.rays as u64, "ray", "rays"), short_vector(pair.point));
                findings.fault(&format!("'{first}' and '{second}', on {rays}, as at {point}"));
            }
        }
    }
}

fn examine(name: &str, mesh: &TriangleMesh, findings: &mut Findings) {
    match Topology::of(mesh) {
        // What is no mesh at all, the scene's errors tell with the place where it is used.
        Err(_) => findings.line(&format!("{name}: not a mesh")),
        Ok(report) => {
            findings.line(&summary(name, &report));
            faults(&report, findings);
            remarks(&report, findings);
        }
    }
}

fn summary(name: &str, report: &Topology) -> String {
    let faces = counted(report.faces as u64, "triangle", "triangles");
    let vertices = counted(report.vertices as u64, "vertex", "vertices");
    let shells = counted(report.shells as u64, "shell", "shells");
    let volume = if report.is_closed() {
        format!("closed, volume {}", short(report.signed_volume.abs()))
    } else {
        "not closed: a surface without an inside".into()
    };
    format!("{name}: {faces}, {vertices}, {shells}, {volume}")
}

fn faults(report: &Topology, findings: &mut Findings) {
    if report.open_edges > 0 {
        let first = report.first_open_edge.map_or_else(String::new, |edge| {
            let [a, b] = edge.vertices;
            let (from, to) = (short_vector(edge.from), short_vector(edge.to));
            format!(", the first between vertices {a} and {b}, from {from} to {to}")
        });
        findings.fault(&format!("{}{first}", counted(report.open_edges as u64, "open edge", "open edges")));
    }
    if report.inconsistent_edges > 0 {
        let edges = counted(report.inconsistent_edges as u64, "edge", "edges");
        findings.fault(&format!("flipped faces: along {edges} two faces run the same way"));
    }
}

fn remarks(report: &Topology, findings: &mut Findings) {
    let counts = [
        (report.crowded_edges, "edge of more than two faces", "edges of more than two faces"),
        (
            report.degenerate_faces,
            "face with two corners in one place",
            "faces with two corners in one place",
        ),
        (report.zero_area_faces, "face without area", "faces without area"),
        (report.duplicate_faces, "duplicate face", "duplicate faces"),
        (report.repeated_vertices, "vertex in the place of another", "vertices in the place of others"),
    ];
    for (count, one, many) in counts {
        if count > 0 {
            findings.remark(&counted(count as u64, one, many));
        }
    }
    if report.is_closed() && report.signed_volume < 0.0 {
        findings.remark("the faces are wound inward; the inside is found all the same");
    }
}

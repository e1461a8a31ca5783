//! Findings in one mesh.

use std::sync::Arc;

use shotline::math::Vec3;
use shotline::measure::Range;
use shotline::solid::Solid;
use shotline::solid::mesh::{Edge, MeshSolid, Tally, Topology, TriangleMesh, Weld, Winding};

use super::{Finding, Findings, Location, Severity};
use crate::number::{counted, short, short_vector};

/// Examines one mesh and adds the findings to the report.
struct Examination<'a> {
    name: &'a str,
    mesh: &'a TriangleMesh,
    report: &'a mut Findings,
}

impl Findings {
    /// Examines a mesh.
    pub fn examine_mesh(&mut self, name: &str, mesh: &Arc<TriangleMesh>, accel: &str) {
        // If it is not a valid mesh, the errors of the scene report that, with the location where it is used.
        let Ok(solid) = MeshSolid::new(mesh.clone(), accel) else {
            return self.line(format!("{name}: not a mesh"));
        };
        let winding = solid.winding();
        let range = winding.as_ref().and_then(|_| out_of_range(&solid));
        self.line(summary(name, solid.topology(), winding.as_ref(), range));
        let mut examination = Examination { name, mesh, report: self };
        if let Some(range) = range {
            examination.volume(range);
        }
        examination.edges(solid.topology());
        examination.faces(solid.topology());
        examination.shells(&solid);
        if let Some(winding) = &winding {
            examination.orientation(solid.topology(), winding);
        }
        examination.intersections(&solid);
        if let Some(winding) = winding {
            examination.cancelling(&winding);
        }
        examination.near_vertices(solid.topology());
    }
}

/// Why the volume of a mesh is not representable as f64; `None` if it is.
fn out_of_range(solid: &MeshSolid) -> Option<Range> {
    Range::of_volume(solid.topology().signed_volume.abs(), &solid.bounds())
}

fn summary(name: &str, topology: &Topology, winding: Option<&Winding>, range: Option<Range>) -> String {
    let faces = counted(topology.faces as u64, "triangle", "triangles");
    let vertices = counted(topology.vertices as u64, "vertex", "vertices");
    let shells = counted(topology.shells.count as u64, "shell", "shells");
    let signed = topology.signed_volume;
    let volume = short(signed.abs());
    let volume = match winding {
        Some(_) if range.is_some() => "closed".into(),
        None => "not closed: a surface without an inside".into(),
        Some(winding) if winding.once => format!("closed, volume {volume}"),
        // `measure` gives the volume of the inside, so this must not be called the volume.
        Some(_) => format!(
            "closed, signed volume {}: the sum over the faces, not the volume of the inside, which `measure` gives",
            short(signed)
        ),
    };
    format!("{name}: {faces}, {vertices}, {shells}, {volume}")
}

impl Examination<'_> {
    fn volume(&mut self, range: Range) {
        let text =
            format!("the volume is too {range} for a 64-bit number; give the model in other units of length");
        self.add(Severity::Fault, "volume_out_of_range", 1, text, Location::default());
    }

    fn edges(&mut self, topology: &Topology) {
        use Severity::{Fault, Remark};
        self.edge(Fault, "open_edges", topology.open_edges, "open edge", "open edges");
        let flipped = (
            "edge of flipped faces, which run along it the same way",
            "edges of flipped faces, which run along them the same way",
        );
        self.edge(Fault, "flipped_faces", topology.inconsistent_edges, flipped.0, flipped.1);
        let non_manifold = ("edge of more than two faces", "edges of more than two faces");
        self.edge(Remark, "crowded_edges", topology.non_manifold_edges, non_manifold.0, non_manifold.1);
    }

    fn edge(&mut self, severity: Severity, kind: &'static str, found: Tally<Edge>, one: &str, many: &str) {
        let Some(edge) = found.first else { return };
        let [a, b] = edge.vertices;
        let faces = match edge.faces {
            [a, b] if a == b => format!("face {a}"),
            [a, b] => format!("faces {a} and {b}"),
        };
        let (from, to) = (short_vector(edge.from), short_vector(edge.to));
        let location = format!("the first between vertices {a} and {b}, from {from} to {to}, at {faces}");
        let text = format!("{}, {location}", counted(found.count as u64, one, many));
        let first = Location {
            faces: edge.faces.into(),
            vertices: vec![a, b],
            point: Some(edge.from),
            ..Location::default()
        };
        self.add(severity, kind, found.count, text, first);
    }

    fn faces(&mut self, topology: &Topology) {
        let text = ("face with two coincident corners", "faces with two coincident corners");
        self.face("degenerate_faces", topology.degenerate_faces, text.0, text.1);
        self.face("zero_area_faces", topology.zero_area_faces, "face without area", "faces without area");
        if let Some([face, twin]) = topology.duplicate_faces.first {
            let count = topology.duplicate_faces.count;
            let (faces, point) =
                (counted(count as u64, "duplicate face", "duplicate faces"), self.corner(face));
            let text = format!(
                "{faces}, the first face {face}, with the corners of face {twin}, at {}",
                short_vector(point)
            );
            let first = Location { faces: vec![face, twin], point: Some(point), ..Location::default() };
            self.add_remark("duplicate_faces", count, text, first);
        }
        if let Some([vertex, earlier]) = topology.duplicate_vertices.first {
            let (count, point) = (topology.duplicate_vertices.count, self.mesh.vertices[vertex as usize]);
            let vertices =
                counted(count as u64, "vertex at the point of another", "vertices at the points of others");
            let text = format!(
                "{vertices}, the first vertex {vertex}, at the point of vertex {earlier}, at {}",
                short_vector(point)
            );
            let first =
                Location { vertices: vec![vertex, earlier], point: Some(point), ..Location::default() };
            self.add_remark("repeated_vertices", count, text, first);
        }
    }

    fn face(&mut self, kind: &'static str, found: Tally<u32>, one: &str, many: &str) {
        let Some(face) = found.first else { return };
        let (faces, point) = (counted(found.count as u64, one, many), self.corner(face));
        let text = format!("{faces}, the first face {face}, at {}", short_vector(point));
        self.add_remark(
            kind,
            found.count,
            text,
            Location { faces: vec![face], point: Some(point), ..Location::default() },
        );
    }

    fn shells(&mut self, solid: &MeshSolid) {
        let topology = solid.topology();
        if let Some(face) = topology.shells.first {
            let (count, point) = (topology.shells.count, self.corner(face));
            let text =
                format!("{count} shells; the second begins with face {face}, at {}", short_vector(point));
            self.add_remark(
                "shells",
                count,
                text,
                Location { faces: vec![face], point: Some(point), ..Location::default() },
            );
        }
        let inverted = (
            "outer shell is wound in the opposite direction, and is solid as well",
            "outer shells are wound in the opposite direction, and are solid as well",
        );
        self.face("turned_shells", solid.inverted_shells(), inverted.0, inverted.1);
    }

    /// Reports where the winding number is negative: in the entire inside, or in some of its regions.
    fn orientation(&mut self, topology: &Topology, winding: &Winding) {
        let Some(face) = winding.negative.first else { return };
        if topology.signed_volume < 0.0 && winding.consistent {
            let text = "the faces are wound inward; the inside is found nevertheless".to_string();
            return self.add_remark("inward_faces", topology.faces, text, Location::default());
        }
        let (count, point) = (winding.negative.count, self.corner(face));
        let faces = counted(count as u64, "face bounds", "faces bound");
        let text = format!(
            "{faces} a region of negative winding number, the first face {face}, at {}: it is inside, as regions of positive number are",
            short_vector(point)
        );
        let first = Location { faces: vec![face], point: Some(point), ..Location::default() };
        self.add_remark("negative_winding", count, text, first);
    }

    fn intersections(&mut self, solid: &MeshSolid) {
        let Some(found) = solid.self_intersections() else {
            let why = "too many faces come near to each other";
            return self
                .report
                .unexamined(format!("{}: faces that pass through each other: {why}", self.name));
        };
        let Some(first) = found.first else { return };
        let [a, b] = first.faces;
        let pairs = counted(found.count as u64, "pair of faces", "pairs of faces");
        let text = format!(
            "{pairs} passing through each other, the first faces {a} and {b}, at {}; the winding number decides what is inside",
            short_vector(first.point)
        );
        let first = Location { faces: vec![a, b], point: Some(first.point), ..Location::default() };
        self.add_remark("self_intersections", found.count, text, first);
    }

    fn cancelling(&mut self, winding: &Winding) {
        let Some(face) = winding.cancelling.first else { return };
        let (count, point) = (winding.cancelling.count, self.corner(face));
        let faces = counted(count as u64, "face cancels", "faces cancel");
        let mut text = format!(
            "{faces} with coincident faces of the opposite orientation, the first face {face}, at {}: no ray hits them",
            short_vector(point)
        );
        let severity = if winding.can_be_hit {
            Severity::Remark
        } else {
            text += "; so nothing of this mesh can ever be hit: give a sheet a thickness, or only one of its sides as a surface";
            Severity::Fault
        };
        let first = Location { faces: vec![face], point: Some(point), ..Location::default() };
        self.add(severity, "cancelling_faces", count, text, first);
    }

    /// Reports if nearly equal vertices are the cause of open edges.
    fn near_vertices(&mut self, topology: &Topology) {
        if topology.is_closed() {
            return;
        }
        let Ok((welded, report)) = self.mesh.welded(Weld::Auto) else { return };
        let (Some(_), Some(apart)) = (report.distance, report.apart) else { return };
        let Ok(topology_after) = Topology::of(&welded) else { return };
        let remaining = topology_after.open_edges.count;
        if remaining >= topology.open_edges.count {
            return;
        }
        let vertices = counted(report.merged as u64, "vertex lies", "vertices lie");
        let result = if remaining == 0 {
            "welded, the mesh is closed".into()
        } else {
            format!("welded, it has {}", counted(remaining as u64, "open edge", "open edges"))
        };
        let text = format!(
            "{vertices} up to {} from others without coinciding, while all other distances are at least {}; {result}: use --weld auto",
            short(report.farthest),
            short(apart)
        );
        self.add_remark("near_vertices", report.merged, text, Location::default());
    }

    /// A point of a face: its first corner.
    fn corner(&self, face: u32) -> Vec3 {
        self.mesh.corners(face)[0]
    }

    fn add_remark(&mut self, kind: &'static str, count: usize, text: String, first: Location) {
        self.add(Severity::Remark, kind, count, text, first);
    }

    fn add(&mut self, severity: Severity, kind: &'static str, count: usize, text: String, first: Location) {
        self.report.add(Finding { severity, subject: self.name.to_string(), kind, count, text, first });
    }
}

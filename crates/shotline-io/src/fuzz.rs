//! Properties that must hold for any bytes: the bodies of the fuzz targets in `fuzz/`. A test also runs them over their
//! corpus.

use std::path::Path;

use shotline::math::Vec3;
use shotline::polygon::invariants;
use shotline::ray::{Ray, Span};
use shotline::scene::{Camera, Node, Scene};
use shotline::testkit::random::Random;
use shotline::testkit::{agreement, bytes};

use crate::document::Document;
use crate::error::ReadError;
use crate::format::{Content, FORMATS, Format};
use crate::mesh_file::NamedMesh;
use crate::{arrays, parse_scene, write_scene};

/// Checks a property of some bytes; panics if it does not hold.
pub type Target = fn(&[u8]);

/// Every target by its name, which is also the name of its corpus.
pub const TARGETS: &[(&str, Target)] = &[
    ("scene", scene),
    ("ply", |bytes| mesh("PLY", bytes)),
    ("obj", |bytes| mesh("OBJ", bytes)),
    ("off", |bytes| mesh("OFF", bytes)),
    ("stl", |bytes| mesh("STL", bytes)),
    ("gdml", |bytes| geometry("GDML", bytes)),
    ("gltf", |bytes| geometry("glTF", bytes)),
    ("3mf", |bytes| geometry("3MF", bytes)),
    ("npy", npy),
    ("polygon", polygon),
    ("cast", cast),
    ("csg", bytes::combination),
    ("weld", bytes::weld),
];

/// Runs the target of a name.
///
/// # Panics
/// If a property does not hold, or there is no such target.
pub fn run(name: &str, bytes: &[u8]) {
    let (_, target) = TARGETS.iter().find(|(known, _)| *known == name).expect("a target");
    target(bytes);
}

fn format(name: &str) -> &'static Format {
    FORMATS.iter().find(|format| format.name == name).expect("a format")
}

/// An error has a message.
fn has_message(error: &ReadError) {
    assert!(
        !error.diagnostics.is_empty() && error.diagnostics.iter().all(|p| !p.message.is_empty()),
        "{error:?}"
    );
    assert!(!error.to_string().is_empty());
}

/// An error has a message and says how to correct the file.
fn has_help(error: &ReadError) {
    has_message(error);
    assert!(error.diagnostics.iter().all(|p| p.help.is_some()), "{error}");
}

/// A scene that can be read is written so that it reads back as the same scene.
fn scene(bytes: &[u8]) {
    match format("scene").read(Path::new("folder/scene.json"), bytes.to_vec()) {
        Err(error) => has_message(&error),
        Ok(document) => {
            let text = write_scene(&document.scene).expect("what was read can be written");
            let again = parse_scene(text.clone(), None).unwrap_or_else(|e| panic!("{text}\n{e}"));
            assert_eq!(write_scene(&again.scene).expect("as before"), text);
        }
    }
}

/// A geometry that can be read is compiled or refused with a message, and is written as a scene that reads back as the same.
fn geometry(name: &str, bytes: &[u8]) {
    let document = match format(name).read(Path::new("folder/geometry"), bytes.to_vec()) {
        Err(error) => return has_message(&error),
        Ok(document) => document,
    };
    if expanded_size(&document.scene).is_some_and(|size| size <= MAX_EXPANDED)
        && let Err(errors) = shotline::compile::compile(&document.scene, Default::default())
    {
        has_message(&document.diagnostics(&errors));
    }
    // A tessellated solid has no file that a scene could name.
    if let Ok(text) = write_scene(&document.scene) {
        let again = parse_scene(text.clone(), None).unwrap_or_else(|e| panic!("{text}\n{e}"));
        assert_eq!(write_scene(&again.scene).expect("as before"), text);
    }
}

/// A mesh that can be read has faces with valid, finite vertices, and is written so that it reads back as the same mesh.
fn mesh(name: &str, bytes: &[u8]) {
    let format = format(name);
    let Content::Mesh { read, write, .. } = format.content else { return };
    let document = match format.read(Path::new("folder/mesh"), bytes.to_vec()) {
        Err(error) => return has_help(&error),
        Ok(document) => document,
    };
    let Some(Node::Mesh { mesh, .. }) = document.scene.nodes.first() else { panic!("{document:?}") };
    assert!(!mesh.faces.is_empty());
    assert!(
        mesh.faces.iter().flatten().all(|i| mesh.vertices.get(*i as usize).is_some_and(|v| v.is_finite()))
    );
    assert!(mesh.polygons.is_empty() || mesh.polygons.len() == mesh.faces.len());
    assert!(mesh.polygons.is_sorted() && document.notes.iter().all(|note| note.count > 0));
    let written = write(NamedMesh::unnamed(mesh)).expect("what was read can be written").bytes;
    let again = read(&written).expect("what was written can be read").mesh;
    let corners = |mesh: &shotline::solid::mesh::TriangleMesh| {
        let zero = Vec3::ZERO; // turns -0.0 into 0.0, which STL does as well
        (0..mesh.faces.len()).map(|i| mesh.corners(i as u32).map(|v| v + zero)).collect::<Vec<_>>()
    };
    assert_eq!(corners(&again), corners(mesh));
}

/// The first three bytes choose a plane; every two bytes after them are a corner in it.
fn polygon(bytes: &[u8]) {
    let [axis, slopes @ ..] = bytes else { return };
    let [u, v, corners @ ..] = slopes else { return };
    let (pairs, _) = corners.as_chunks::<2>();
    let corners: Vec<[i64; 2]> = pairs.iter().take(200).map(|p| p.map(|b| i64::from(b as i8))).collect();
    invariants::check(&corners, usize::from(axis % 3), [*u, *v].map(|b| i64::from(b as i8) / 16));
}

fn npy(bytes: &[u8]) {
    match arrays::parse_rays(bytes) {
        Err(error) => has_help(&error),
        Ok(rows) => {
            assert!(rows.len() * 24 <= bytes.len());
            if let Err(bad) = arrays::rays_of(&rows) {
                assert!(bad.row < rows.len());
            }
        }
    }
}

/// The maximum number of nodes with sharing expanded; more take a fuzzer too long.
const MAX_EXPANDED: u64 = 2000;

/// Casts rays at a scene that can be read: along the view of its camera, and from all directions.
fn cast(bytes: &[u8]) {
    let Ok(text) = String::from_utf8(bytes.to_vec()) else { return };
    let Ok(document) = parse_scene(text, None) else { return };
    match expanded_size(&document.scene) {
        None => assert!(!agreement::check_scene(&document.scene, &[]), "a node contains itself"),
        Some(size) if size > MAX_EXPANDED => {}
        Some(_) => compiled(&document, bytes.iter().fold(0, |sum, b| sum * 31 % 65_537 + u64::from(*b))),
    }
}

fn compiled(document: &Document, seed: u64) {
    let scene = &document.scene;
    let rays: Vec<(Ray, Span)> = rays(scene.camera.as_ref(), &mut Random::new(seed)).collect();
    if !agreement::check_scene(scene, &rays) {
        let errors = shotline::compile::compile(scene, Default::default()).expect_err("refused before");
        has_message(&document.diagnostics(&errors));
    }
}

fn rays(camera: Option<&Camera>, random: &mut Random) -> impl Iterator<Item = (Ray, Span)> {
    let mut pairs: Vec<(Vec3, Vec3)> = camera.map(|c| (c.eye, c.target - c.eye)).into_iter().collect();
    for i in 0..6 {
        let o = random.point(-1.0, 1.0) * [0.5, 3.0, 10.0][i % 3];
        pairs.push((o, random.point(-1.0, 1.0) - o));
    }
    let short = Span::new(0.25, 1.25).unwrap_or(Span::FORWARD);
    let spans = [Span::FORWARD, short].into_iter().cycle();
    pairs.into_iter().filter_map(|(o, d)| Ray::new(o, d).ok()).zip(spans)
}

/// The number of nodes of the largest node with sharing expanded; `None` if a node contains itself.
fn expanded_size(scene: &Scene) -> Option<u64> {
    let mut sizes = vec![1u64; scene.nodes.len()];
    // Each pass fixes the size of at least one more node, unless there is a cycle.
    for _ in 0..=scene.nodes.len() {
        let before = sizes.clone();
        for (i, node) in scene.nodes.iter().enumerate() {
            sizes[i] = node.children().fold(1, |sum, id| sum.saturating_add(before[id.0 as usize]));
        }
        if sizes == before {
            return Some(sizes.into_iter().max().unwrap_or(0));
        }
    }
    None
}

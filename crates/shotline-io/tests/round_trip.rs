//! Scenes that are written and read again are the same, bit for bit.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use shotline::accel::NAMES;
use shotline::compile::{Options, compile};
use shotline::math::{Affine, Vec3};
use shotline::query::Caster;
use shotline::ray::{Ray, Span};
use shotline::scene::{
    Camera, Lens, Light, LightSource, LocalTransform, Material, MeshFile, Motion, Node, NodeId, Op, Rotation,
    Scene, Units,
};
use shotline::shape::{Object, Shape};
use shotline::solid::mesh::{TriangleMesh, Weld};
use shotline::solid::{KINDS, Layout, Params};
use shotline::testkit::random::Random;
use shotline::testkit::scene::random_scene as castable_scene;
use shotline_io::{load, parse_scene, read_mesh, save, write_scene};

/// Any finite float64: every exponent, both zeros, and often a small integer.
fn number(random: &mut Random) -> f64 {
    loop {
        let x = match random.below(6) {
            0 => random.below(7) as f64 - 3.0,
            1 => -0.0,
            2 => f64::from_bits(random.bits() >> 12),
            3 => random.number(-1.0, 1.0),
            _ => f64::from_bits(random.bits()),
        };
        if x.is_finite() {
            return x;
        }
    }
}

fn vector(random: &mut Random) -> Vec3 {
    Vec3::new(number(random), number(random), number(random))
}

fn maybe<T>(random: &mut Random, make: impl Fn(&mut Random) -> T) -> Option<T> {
    (random.below(2) == 0).then(|| make(random))
}

fn transform(random: &mut Random) -> LocalTransform {
    if random.below(2) == 0 {
        return LocalTransform::Matrix(Affine::from_row_major(std::array::from_fn(|_| number(random))));
    }
    let scale = if random.below(2) == 0 { Vec3::splat(number(random)) } else { vector(random) };
    let about = |random: &mut Random| Rotation::About {
        axis: Vec3::new(number(random), 1e-300, number(random)),
        degrees: number(random),
    };
    let rotate = match random.below(3) {
        0 => None,
        1 => Some(Rotation::Xyz(vector(random))),
        _ => Some(about(random)),
    };
    LocalTransform::Steps { scale: Some(scale), rotate, translate: maybe(random, vector) }
}

fn leaf(random: &mut Random) -> Node {
    let kind = KINDS[random.below(KINDS.len())];
    let value = |layout: Layout, random: &mut Random| {
        let count = match layout {
            Layout::Numbers(count) => count,
            Layout::Rows { columns, least } => columns.len() * (least + random.below(3)),
        };
        (0..count).map(|_| number(random)).collect()
    };
    let entries = kind.params.iter().map(|p| (p.name, value(p.layout, random))).collect();
    Node::Solid { kind, params: Params { entries } }
}

/// A mesh with faces of four and five corners.
const POLYGONS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 0.4 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0.5 0.4 1\nv 0 1 1\n\
                        f 5 4 3 2 1\nf 6 7 8 9 10\nf 1 2 7 6\nf 2 3 8 7\nf 3 4 9 8\nf 4 5 10 9\nf 5 1 6 10\n";

/// A tetrahedron that only welding closes.
const NOISY: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1e-15 0 0\nv 1 1e-15 0\nf 1 3 2\nf 5 2 4\nf 6 3 4\nf 3 1 4\n";

/// A tetrahedron with vertices that no face uses and of which one is not finite.
const UNUSED: &str = "ply\nformat ascii 1.0\nelement vertex 6\nproperty double x\nproperty double y\nproperty double z\n\
                      element face 4\nproperty list uchar int vertex_indices\nend_header\n-0 0 0\n1 0 0\n0 1 0\n0 0 1\n\
                      nan 0 0\n9 9 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

const FILES: [(&str, &str); 3] =
    [("polygons.obj", POLYGONS), ("sub/noisy.obj", NOISY), ("unused.ply", UNUSED)];

/// A folder with mesh files.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    FILES.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
    folder
}

/// One of the mesh files, read and possibly welded.
fn mesh(random: &mut Random, folder: &Path) -> Node {
    let (name, _) = FILES[random.below(FILES.len())];
    let weld = [None, Some(Weld::Within(0.0)), Some(Weld::Within(1e-3)), Some(Weld::Auto)][random.below(4)];
    let read = read_mesh(folder.join(name)).unwrap();
    let mesh = weld.map_or(read.clone(), |weld| read.welded(weld).unwrap().0);
    Node::Mesh { mesh: mesh.into(), file: Some(MeshFile { name: name.into(), weld }) }
}

/// A scene whose nodes refer to earlier ones, so that many are shared. Some of them have names.
fn random_scene(random: &mut Random, folder: &Path) -> Scene {
    let mut scene = Scene { units: maybe(random, |r| Units::ALL[r.below(8)].1), ..Scene::default() };
    scene.materials = (0..random.below(3)).map(|i| (format!("m{i} \"\u{e9}\n"), material(random))).collect();
    let mut shapes = vec![scene.add(leaf(random))];
    let mut members = shapes.clone();
    for _ in 0..random.below(20) {
        let some = |random: &mut Random, from: &[NodeId]| from[random.below(from.len())];
        let several = |random: &mut Random, from: &[NodeId]| {
            (0..=random.below(3)).map(|_| some(random, from)).collect()
        };
        let node = match random.below(6) {
            0 => Node::Transform { transform: transform(random), child: some(random, &shapes) },
            1 => Node::Csg {
                op: [Op::Union, Op::Intersection, Op::Difference][random.below(3)],
                args: several(random, &shapes),
            },
            2 => Node::Group { members: several(random, &members) },
            3 => {
                let shape = some(random, &shapes);
                let id = scene.add(object(random, shape, &scene.materials));
                members.push(id);
                continue;
            }
            4 => mesh(random, folder),
            _ => leaf(random),
        };
        let is_transform = matches!(node, Node::Transform { .. });
        let id = scene.add(node);
        if is_transform && random.below(3) == 0 {
            scene.labels.insert(id, format!("label {} \\", random.below(3)));
        }
        shapes.push(id);
        members.push(id);
    }
    for i in 0..random.below(4) {
        let id = members[random.below(members.len())];
        scene.defs.push((format!("part{}{}", 2 * i, ["", " \\/"][random.below(2)]), id));
    }
    for _ in 0..=random.below(3) {
        let shape = shapes[random.below(shapes.len())];
        let mut root = object(random, shape, &scene.materials);
        if let Node::Object { contents, .. } = &mut root {
            contents.extend(scene.objects.iter().filter(|_| random.below(3) == 0));
        }
        let mut root = scene.add(root);
        if random.below(4) == 0 {
            let transform = LocalTransform::translation(random.point(-1.0, 1.0));
            root = scene.add(Node::Transform { transform, child: root });
        }
        scene.objects.push(root);
    }
    looks(&mut scene, random);
    scene
}

fn object(random: &mut Random, node: NodeId, materials: &[(String, Material)]) -> Node {
    let material = random.below(materials.len() + 1);
    Node::Object {
        name: ["o0", "o1", "", "\u{1F600}\t\"o\""][random.below(4)].into(),
        material: materials.get(material).map(|(name, _)| name.clone()),
        priority: random.bits() as i32,
        node,
        contents: Vec::new(),
        clip: random.below(3) == 0,
    }
}

fn material(random: &mut Random) -> Material {
    let share = |random: &mut Random| random.number(0.0, 1.0);
    Material {
        mu: maybe(random, |r| number(r).abs()),
        density: maybe(random, |r| number(r).abs()),
        composition: (0..random.below(3)).map(|i| (format!("E{i} \"{{"), share(random))).collect(),
        color: maybe(random, |r| [share(r), 0.0, 1.0]),
        specular: maybe(random, share),
        shininess: maybe(random, |r| number(r).abs()),
        mirror: maybe(random, share),
    }
}

fn looks(scene: &mut Scene, random: &mut Random) {
    let lens = match random.below(2) {
        0 => Lens::Pinhole { fov: random.number(0.1, 179.0) },
        _ => Lens::Orthographic { height: number(random).abs().max(1e-300) },
    };
    let (eye, target, up) = (vector(random), Vec3::new(0.1, 0.2, 0.3), vector(random));
    scene.camera = maybe(random, |_| Camera { eye, target, up, lens });
    scene.accel = maybe(random, |r| NAMES[r.below(NAMES.len())]);
    for (i, node) in (0..).zip(&scene.nodes) {
        if matches!(node, Node::Csg { .. } | Node::Group { .. } | Node::Mesh { .. }) && random.below(3) == 0 {
            scene.accels.insert(NodeId(i), NAMES[random.below(NAMES.len())]);
        }
    }
    let root = scene.objects.first().map(|id| scene.node(*id).clone());
    if let Some(Node::Object { name: object, .. }) = root {
        let rotate = maybe(random, |r| match r.below(2) {
            0 => Rotation::Xyz(vector(r)),
            _ => Rotation::About { axis: Vec3::new(number(r), 1.0, 0.0), degrees: number(r) },
        });
        scene.motions.push(Motion {
            object,
            rotate,
            about: maybe(random, vector),
            translate: maybe(random, vector),
        });
    }
    for _ in 0..random.below(3) {
        let source = match random.below(3) {
            0 => LightSource::Point(vector(random)),
            1 => LightSource::Directional(Vec3::new(number(random), 1.0, -0.0)),
            _ => LightSource::Ambient,
        };
        let intensity = maybe(random, |r| number(r).abs());
        scene.lights.push(Light { source, color: maybe(random, |_| [0.1, 0.2, 0.3]), intensity });
    }
}

/// The scene as text that is equal for equal graphs: nodes are numbered in breadth-first order. Debug prints the
/// shortest digits that identify a number, and the sign of zero, so equal texts mean equal bits.
fn canonical(scene: &Scene) -> String {
    let Scene { units, nodes, defs, objects, materials, camera, lights, motions, accel, accels, labels } =
        scene;
    let mut out = format!("{units:?} {materials:?} {camera:?} {lights:?} {motions:?} {accel:?}\n");
    let mut numbers: HashMap<NodeId, usize> = HashMap::new();
    let mut order = Vec::new();
    let mut number = |id: NodeId, order: &mut Vec<NodeId>| {
        let next = numbers.len();
        *numbers.entry(id).or_insert_with(|| {
            order.push(id);
            next
        })
    };
    for id in objects {
        out += &format!("object {}\n", number(*id, &mut order));
    }
    let mut at = 0;
    while let Some(id) = order.get(at).copied() {
        at += 1;
        out += &format!("{:?} {:?} ", accels.get(&id), labels.get(&id));
        let mut all = |ids: &[NodeId]| ids.iter().map(|c| number(*c, &mut order)).collect::<Vec<_>>();
        out += &match &nodes[id.0 as usize] {
            Node::Solid { kind, params } => format!("{} {params:?}\n", kind.name),
            Node::Mesh { mesh, file } => format!("{file:?} {mesh:?}\n"),
            Node::Csg { op, args } => format!("{op:?} {:?}\n", all(args)),
            Node::Group { members } => format!("group {:?}\n", all(members)),
            Node::Transform { transform, child } => format!("{transform:?} {:?}\n", all(&[*child])),
            Node::Lattice { lattice, elements, table } => {
                format!("{lattice:?} {:?} {table:?}\n", all(elements))
            }
            Node::Object { name, material, priority, node, contents, clip } => {
                let parts = [&[*node], &contents[..]].concat();
                format!("{name} {material:?} {priority} {clip} {:?}\n", all(&parts))
            }
        };
    }
    let named = defs.iter().map(|(name, id)| format!("{name} {:?}\n", numbers.get(id)));
    out + &named.collect::<String>()
}

/// The scene without the definitions whose names the writer had to invent.
fn without_new_names(mut scene: Scene, original: &Scene) -> Scene {
    scene.defs.truncate(original.defs.len());
    scene
}

#[test]
fn scenes_survive_bit_for_bit() {
    let mut random = Random::new(1);
    let folder = folder();
    for _ in 0..300 {
        let scene = random_scene(&mut random, folder.path());
        let text = write_scene(&scene).unwrap();
        let back =
            parse_scene(text.clone(), Some(folder.path())).unwrap_or_else(|e| panic!("{e}\n{text}")).scene;
        assert_eq!(canonical(&without_new_names(back.clone(), &scene)), canonical(&scene), "{text}");
        // Now every shared node has a name, so the text does not change any more.
        assert_eq!(write_scene(&back).unwrap(), text);
    }
}

/// All crossings of some rays, with every field.
fn crossings(scene: &Scene) -> String {
    let world = compile(scene, Options::default()).unwrap();
    let (mut caster, mut hits, mut out) = (Caster::new(&world), Vec::new(), String::new());
    let mut random = Random::new(5);
    for _ in 0..40 {
        let origin = random.direction() * 6.0;
        let target = Vec3::from(std::array::from_fn(|_| random.number(-0.5, 1.0)));
        let ray = Ray::new(origin, target - origin).unwrap();
        caster.crossings(&ray, Span::FORWARD, &mut hits).unwrap();
        out += &format!("{hits:?}\n");
    }
    out
}

/// The scene without the file names of its meshes.
fn without_files(mut scene: Scene) -> Scene {
    for node in &mut scene.nodes {
        if let Node::Mesh { file, .. } = node {
            *file = None;
        }
    }
    scene
}

#[test]
fn saved_scenes_are_the_same_models() {
    let mut random = Random::new(6);
    let (mut polygons, mut written) = (0, 0);
    for _ in 0..40 {
        let (here, elsewhere) = (folder(), tempfile::tempdir().unwrap());
        let mut scene = castable_scene(&mut random);
        scene.units = maybe(&mut random, |r| Units::ALL[r.below(8)].1);
        for i in 0..2 {
            let node = mesh(&mut random, here.path());
            let node = scene.add(node);
            let materials = scene.materials.clone();
            let inner = scene.add(object(&mut random, node, &materials));
            let placed = scene.add_transform(Affine::translation(Vec3::splat(0.125)), inner);
            let group = scene.add(Node::Group { members: vec![node, placed] });
            scene.accels.insert(node, NAMES[random.below(NAMES.len())]);
            scene.add_object(&format!("meshes {i}"), None, group);
        }
        let before = crossings(&scene);
        polygons += before.matches("polygon: Some").count();
        for folder in [&here, &elsewhere] {
            let path = folder.path().join("saved.json");
            written += save(&path, &scene).unwrap().len();
            let back = load(&path).unwrap().scene;
            assert_eq!(crossings(&back), before);
            let same = without_files(without_new_names(back.clone(), &scene));
            assert_eq!(canonical(&same), canonical(&without_files(scene.clone())));
            // Saving again finds the meshes that were saved and writes none.
            assert_eq!(save(&path, &back).unwrap(), [""; 0]);
        }
    }
    // In the folder of the mesh files no mesh is written; elsewhere both are, each time.
    assert!(polygons > 100 && written == 80, "{polygons} {written}");
}

#[test]
fn a_welded_mesh_is_saved_welded() {
    let folder = folder();
    let text = r#"{ "shotline": 1, "objects": [{ "node": { "kind": "mesh", "file": "sub/noisy.obj", "weld": "auto" } }] }"#;
    let scene = parse_scene(text, Some(folder.path())).unwrap().scene;
    assert!(write_scene(&scene).unwrap().contains(r#""file": "sub/noisy.obj", "weld": "auto""#));
    // The welded file gives this mesh, so the scene keeps naming the file.
    assert_eq!(save(folder.path().join("again.json"), &scene).unwrap(), [""; 0]);
    let elsewhere = tempfile::tempdir().unwrap();
    assert_eq!(save(elsewhere.path().join("again.json"), &scene).unwrap().len(), 1);
    assert!(!std::fs::read_to_string(elsewhere.path().join("again.json")).unwrap().contains("weld"));
}

#[test]
fn meshes_outside_of_the_folder_are_copied_beside_the_scene() {
    let outer = folder();
    let inner = outer.path().join("sub");
    for name in ["../polygons.obj".to_owned(), outer.path().join("polygons.obj").display().to_string()] {
        let mut scene = Scene::default();
        let mesh: Arc<TriangleMesh> = read_mesh(inner.join(&name)).unwrap().into();
        let node = scene.add(Node::Mesh { mesh: mesh.clone(), file: Some(MeshFile { name, weld: None }) });
        scene.add_object("it", None, node);
        save(inner.join("saved.json"), &scene).unwrap();
        let back = load(inner.join("saved.json")).unwrap().scene;
        assert!(back.nodes.iter().any(|node| matches!(node, Node::Mesh { mesh: read, .. } if *read == mesh)));
    }
}

#[test]
fn numbers_survive_bit_for_bit() {
    let extremes = [
        0.0,
        -0.0,
        5e-324,
        -5e-324,
        f64::MIN_POSITIVE,
        f64::MAX,
        f64::MIN,
        0.1,
        1e16,
        1e21,
        123456789012345680.0,
    ];
    let mut random = Random::new(2);
    let numbers = extremes.into_iter().chain(std::iter::from_fn(|| Some(number(&mut random))).take(20_000));
    let mut scene = Scene::default();
    let written: Vec<f64> = numbers.collect();
    for x in &written {
        scene.materials.push((
            format!("{}", scene.materials.len()),
            Material { mu: Some(x.abs()), ..Material::default() },
        ));
        scene.lights.push(Light {
            source: LightSource::Point(Vec3::splat(*x)),
            color: None,
            intensity: None,
        });
    }
    let back = parse_scene(write_scene(&scene).unwrap(), None).unwrap().scene;
    for (x, light) in written.iter().zip(&back.lights) {
        let LightSource::Point(p) = light.source else { panic!() };
        assert_eq!((p.x.to_bits(), p.z.to_bits()), (x.to_bits(), x.to_bits()));
    }
}

#[test]
fn scenes_that_cannot_be_written_are_refused() {
    let mut scene = Scene::default();
    scene.lights.push(Light { source: LightSource::Point(Vec3::NAN), color: None, intensity: None });
    assert!(write_scene(&scene).unwrap_err().to_string().contains("finite"));
    let mut scene = Scene::default();
    let mesh = scene.add(Node::Mesh { mesh: Default::default(), file: None });
    scene.add_object("a", None, mesh);
    assert!(write_scene(&scene).unwrap_err().to_string().contains("not read from a file"));
}

#[test]
fn cycles_are_written_and_read() {
    let mut scene = Scene::default();
    let id = scene.add_csg(Op::Union, vec![NodeId(0), NodeId(0)]);
    scene.add_object("loop", None, id);
    let text = write_scene(&scene).unwrap();
    let back = parse_scene(text, None).unwrap().scene;
    assert!(matches!(back.node(back.defs[0].1), Node::Csg { args, .. } if args[0] == back.defs[0].1));
}

/// A built scene may name an accelerator for a solid, which uses none; the format has no key for it.
#[test]
fn an_accelerator_of_a_solid_is_not_written() {
    let ball = Shape::sphere(1.0).unwrap().with_accel("grid");
    let scene = Scene::of([Object::new("ball", ball.translate([1.0, 0.0, 0.0]))]);
    let text = write_scene(&scene).unwrap();
    assert!(!text.contains("grid") && parse_scene(text.as_str(), None).is_ok(), "{text}");
}

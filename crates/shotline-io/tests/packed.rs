//! A packed scene has the crossings of its original after unpacking, and packs to the same value again.

use std::sync::Arc;

use shotline::compile::{Options, compile};
use shotline::query::Caster;
use shotline::ray::{Ray, Span};
use shotline::scene::{MeshFile, Node, Scene};
use shotline::solid::mesh::{TriangleMesh, Weld};
use shotline::testkit::random::Random;
use shotline::testkit::scene::random_scene;
use shotline_io::pack;

fn tetrahedron(size: f64) -> Arc<TriangleMesh> {
    let at = |x: f64, y: f64, z: f64| [x, y, z].map(|c| c * size).into();
    let vertices = vec![at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 0.0, 1.0)];
    Arc::new(TriangleMesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
}

fn all_crossings(scene: &Scene, rays: &[Ray]) -> String {
    let world = compile(scene, Options::default()).unwrap();
    let mut caster = Caster::new(&world);
    let mut hits = Vec::new();
    rays.iter().for_each(|ray| caster.crossings(ray, Span::FORWARD, &mut hits).expect("within limits"));
    format!("{hits:?}")
}

#[test]
fn packed_scenes_have_the_same_crossings() {
    let mut random = Random::new(31);
    let mut crossings = 0;
    for _ in 0..40 {
        let mut scene = random_scene(&mut random);
        let small = scene.add(Node::Mesh {
            mesh: tetrahedron(0.3),
            file: Some(MeshFile { name: "kept/out.ply".into(), weld: Some(Weld::Auto) }),
        });
        let large = scene.add(Node::Mesh { mesh: tetrahedron(3.0), file: None });
        let group = scene.add(Node::Group { members: vec![small, large, small] });
        scene.add_object("meshes", None, group);
        let ray = |_| Ray::new(random.direction() * 6.0, random.direction()).unwrap();
        let rays: Vec<Ray> =
            (0..60).map(ray).map(|r| Ray::new(r.origin(), r.direction() - r.origin()).unwrap()).collect();
        let packed = pack(&scene).unwrap();
        assert_eq!(packed.meshes.len(), 2);
        let unpacked = packed.clone().unpack().unwrap().scene;
        assert!(unpacked.nodes.iter().all(|n| !matches!(n, Node::Mesh { file: Some(_), .. })));
        assert_eq!(pack(&unpacked).unwrap(), packed);
        let (before, after) = (all_crossings(&scene, &rays), all_crossings(&unpacked, &rays));
        assert_eq!(before, after);
        crossings += before.matches("t_err").count();
    }
    assert!(crossings > 1000, "{crossings}");
}

#[test]
fn missing_meshes_are_reported() {
    let mut scene = Scene::default();
    let mesh = scene.add(Node::Mesh { mesh: tetrahedron(1.0), file: None });
    scene.add_object("it", None, mesh);
    let mut packed = pack(&scene).unwrap();
    packed.meshes.clear();
    let error = packed.unpack().unwrap_err().to_string();
    assert!(error.contains("there is no mesh '0'") && error.contains("0 meshes are given"), "{error}");
}

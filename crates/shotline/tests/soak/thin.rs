//! Meshes with thin walls, far from the origin for their size, with unused vertices. Rays begin on walls, near
//! them and inside them. `closest`, `any`, `count` and `segments` are checked against the crossings, for spans
//! that begin and end at crossings and beside them. The crossings are checked against brute force over all
//! triangles.

use std::sync::Arc;

use shotline::compile::{Options, World, compile};
use shotline::query::Caster;
use shotline::ray::Span;
use shotline::scene::{Node, Scene};
use shotline::solid::mesh::TriangleMesh;
use shotline::testkit::agreement::{check_world, spans_of};
use shotline::testkit::meshes::{Thin, rays_at};
use shotline::testkit::random::Random;

use super::Tally;

/// A mesh compiled with an accelerator and with brute force.
struct Model {
    thin: Thin,
    mesh: TriangleMesh,
    fast: World,
    brute: World,
}

/// The meshes under test.
pub struct Meshes(Vec<Model>);

impl Meshes {
    /// Enough random meshes to include every shape with thick and thin walls, near and far.
    pub fn new() -> Meshes {
        let mut random = Random::new(17);
        Meshes((0..200).map(|_| Model::new(&mut random)).collect())
    }

    /// Tests the given number of rays.
    pub fn run(&self, random: &mut Random, rays: u64, tally: &mut Tally) {
        let (mut left, mut list, mut other) = (rays, Vec::new(), Vec::new());
        while left > 0 {
            let model = &self.0[random.below(self.0.len())];
            let Some(ray) = rays_at(random, &model.mesh, &model.thin, 1).pop() else { continue };
            let spans = spans_of(&model.fast, &ray);
            for _ in 0..left.min(4) {
                let span = spans[random.below(spans.len())];
                check_world(&model.fast, &[(ray, span)]);
                list.clear();
                Caster::new(&model.fast).crossings(&ray, span, &mut list).expect("within limits");
                tally.rays += 1;
                left -= 1;
                tally.crossings += list.len() as u64;
                if tally.rays.is_multiple_of(8) {
                    other.clear();
                    Caster::new(&model.brute).crossings(&ray, span, &mut other).expect("within limits");
                    if format!("{list:?}") != format!("{other:?}") {
                        tally.fail(format!(
                            "{:?}, {ray:?}, {span:?}: {list:?}, by brute force {other:?}",
                            model.thin
                        ));
                    }
                }
            }
            let all = Span::new(-1e30, f64::INFINITY).unwrap_or(Span::FORWARD);
            if Caster::new(&model.fast).count(&ray, all).expect("within limits") % 2 == 1 {
                tally.fail(format!("{:?}, {ray:?}: a line leaves as often as it enters", model.thin));
            }
        }
    }
}

impl Model {
    fn new(random: &mut Random) -> Model {
        let thin = Thin::any(random);
        let mesh = thin.mesh(random);
        let mut scene = Scene::default();
        let node = scene.add(Node::Mesh { mesh: Arc::new(mesh.clone()), file: None });
        scene.add_object("mesh", None, node);
        let world = |accel| compile(&scene, Options { accel: Some(accel) }).expect("a world");
        Model { thin, fast: world("bvh"), brute: world("brute"), mesh }
    }
}

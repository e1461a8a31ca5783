//! A combination of solids and rays at it, decoded from bytes that a fuzzer can vary. Many numbers lie on a
//! coarse grid, so that faces coincide and rays graze surfaces and meet rims.

use std::sync::Arc;

use super::agreement;
use super::leaf::add_varied;
use super::membership::Membership;
use crate::compile::{Options, World, compile};
use crate::math::{Affine, Vec3};
use crate::query::{Caster, Hit};
use crate::ray::{Line, Ray, Span};
use crate::scene::{LocalTransform, Node, NodeId, Op, Rotation, Scene};
use crate::scratch::Scratch;
use crate::solid::mesh::{MeshSolid, TriangleMesh, Weld};

/// A reader of bytes. Returns zeros after the end.
struct Bytes<'b>(&'b [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n
    }

    /// A number from -8 to 8, in sixteenths or finer.
    fn number(&mut self) -> f64 {
        let coarse = f64::from(self.byte() as i8) / 16.0;
        match self.byte() {
            fine @ 192.. => coarse + f64::from(u16::from_le_bytes([self.byte(), fine])) / 1e7,
            _ => coarse,
        }
    }

    /// A number above 0, up to 8.
    fn size(&mut self) -> f64 {
        (f64::from(self.byte()) + 1.0) / 32.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}

/// The maximum number of leaves in a description.
const MAX_LEAVES: usize = 20;

/// The maximum number of nodes of a description, with shared nodes counted at each use.
const MAX_EXPANDED_NODES: usize = 300;

/// Builds the scene that the bytes describe. Checks its results with [`agreement::check_scene`], against brute-force
/// membership, and against the same model at another size.
///
/// # Panics
/// If a result is wrong.
pub fn combination(data: &[u8]) {
    let mut bytes = Bytes(data);
    let rays: Vec<(Ray, Span)> = (0..1 + bytes.below(3)).filter_map(|_| ray(&mut bytes)).collect();
    let power = i32::from(bytes.byte() as i8) * 7;
    let mut scene = Scene::default();
    let Some(root) = tree(&mut bytes, &mut scene) else { return };
    scene.add_object("object", None, root);
    if !agreement::check_scene(&scene, &rays) {
        return;
    }
    let membership = Membership::of(&scene);
    let itself = world(&scene);
    for (ray, span) in &rays {
        agrees_with_membership(&membership, root, ray, *span, &crossings(&itself, ray, *span));
    }
    if power != 0 {
        results_are_independent_of_size(&scene, root, &rays, 2f64.powi(power));
    }
}

fn ray(bytes: &mut Bytes) -> Option<(Ray, Span)> {
    let (o, target) = (bytes.vector(), bytes.vector());
    let direction = match bytes.below(4) {
        0 => target,
        1 => Vec3::AXES[bytes.below(3)] * target.x,
        _ => target - o,
    };
    let span = match bytes.below(4) {
        0 => Span::new(bytes.number(), f64::INFINITY),
        1 => {
            let t_min = bytes.number();
            Span::new(t_min, t_min + bytes.size())
        }
        _ => Ok(Span::FORWARD),
    };
    Ray::new(o, direction).ok().zip(span.ok())
}

/// A tree in postfix order. Solids are pushed onto a stack and operations pop from it.
fn tree(bytes: &mut Bytes, scene: &mut Scene) -> Option<NodeId> {
    let (mut stack, mut leaves) = (Vec::<(NodeId, usize)>::new(), 0);
    while !bytes.0.is_empty() && leaves < MAX_LEAVES {
        let code = bytes.byte();
        match (code % 8, stack.last().copied()) {
            (0..=3, _) | (_, None) => {
                stack.push((leaf(bytes, scene), 1));
                leaves += 1;
            }
            (4, Some((top, size))) => {
                stack.pop();
                stack.push((moved(bytes, scene, top), size + 1));
            }
            (5, Some((top, size))) if size * 2 < MAX_EXPANDED_NODES => stack.push((top, size)),
            _ => {
                let from = stack.len().saturating_sub(2 + usize::from(code >> 6));
                let args: Vec<(NodeId, usize)> = stack.drain(from..).collect();
                let size = 1 + args.iter().map(|(_, size)| size).sum::<usize>();
                if size > MAX_EXPANDED_NODES {
                    return None;
                }
                let op = [Op::Union, Op::Intersection, Op::Difference, Op::Difference];
                let op = op[usize::from(code >> 3) % 4];
                stack.push((scene.add_csg(op, args.into_iter().map(|(node, _)| node).collect()), size));
            }
        }
    }
    let args: Vec<NodeId> = stack.into_iter().map(|(node, _)| node).collect();
    if args.is_empty() { None } else { Some(scene.add_csg(Op::Union, args)) }
}

fn leaf(bytes: &mut Bytes, scene: &mut Scene) -> NodeId {
    if bytes.below(8) == 0 {
        return mesh(bytes, scene);
    }
    let choices = [bytes.byte(), bytes.byte()].map(usize::from);
    let mut choices = choices.into_iter().chain(std::iter::repeat(0));
    add_varied(scene, |n| choices.next().unwrap_or(0) % n, || bytes.size()).0
}

/// A tetrahedron, wound outward or inward.
fn mesh(bytes: &mut Bytes, scene: &mut Scene) -> NodeId {
    let vertices = (0..4).map(|_| bytes.vector()).collect();
    let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    scene.add(Node::Mesh { mesh: Arc::new(TriangleMesh::new(vertices, faces)), file: None })
}

fn moved(bytes: &mut Bytes, scene: &mut Scene, child: NodeId) -> NodeId {
    let mut steps = (None, None, None);
    let which = bytes.byte();
    if which & 1 != 0 {
        let mut factor = || {
            let byte = bytes.byte();
            f64::from(byte % 32 + 1) / if byte < 128 { 8.0 } else { -8.0 }
        };
        steps.0 = Some(if which & 8 != 0 {
            Vec3::splat(factor())
        } else {
            Vec3::new(factor(), factor(), factor())
        });
    }
    if which & 2 != 0 {
        steps.1 = Some(Rotation::Xyz(if which & 16 != 0 { bytes.vector() * 15.0 } else { Vec3::Z * 90.0 }));
    }
    if which & 4 != 0 {
        steps.2 = Some(bytes.vector());
    }
    let (scale, rotate, translate) = steps;
    scene.add(Node::Transform { transform: LocalTransform::Steps { scale, rotate, translate }, child })
}

fn world(scene: &Scene) -> World {
    compile(scene, Options::default()).expect("compiled before")
}

fn crossings(world: &World, ray: &Ray, span: Span) -> Vec<Hit> {
    let mut hits = Vec::new();
    Caster::new(world).crossings(ray, span, &mut hits).expect("within limits");
    hits
}

/// Checks that between crossings, away from rounding, membership matches the list.
fn agrees_with_membership(membership: &Membership, root: NodeId, ray: &Ray, span: Span, hits: &[Hit]) {
    let step = ray.direction().length();
    let mut ends = vec![(span.t_min(), 0.0)];
    ends.extend(hits.iter().map(|h| (h.t, h.t_err)));
    ends.push((span.t_max(), 0.0));
    for (i, pair) in ends.windows(2).enumerate() {
        let ((from, from_err), (to, to_err)) = (pair[0], pair[1]);
        let to = to.min(from + 16.0 / step);
        let t = from.midpoint(to);
        let p = ray.at(t);
        let reach = 1e-7 * (p.abs() + ray.origin().abs()).max_element().max(1.0);
        let clear = to - from > 64.0 * (from_err + to_err) && (to - from) * step > 16.0 * reach;
        let refuted = clear && membership.certainly_differs(root, p, reach, i % 2 == 1);
        assert!(!refuted, "at {t} of {ray:?} {span:?}\n{hits:#?}");
    }
}

/// Checks that the same model and rays scaled by a power of two yield the same lists. The reference is twice the
/// original size, because at the original size one frame fewer rounds the ray.
fn results_are_independent_of_size(scene: &Scene, root: NodeId, rays: &[(Ray, Span)], factor: f64) {
    let scaled = |factor: f64| {
        let mut scaled = Scene { objects: Vec::new(), ..scene.clone() };
        let outer = scaled.add_transform(Affine::scaling(Vec3::splat(factor)), root);
        scaled.add_object("object", None, outer);
        world(&scaled)
    };
    let (twice, other) = (scaled(2.0), scaled(factor));
    let bits = |hits: &[Hit]| hits.iter().map(|h| (h.t.to_bits(), h.entering, h.kind)).collect::<Vec<_>>();
    for (ray, span) in rays {
        let list = |world: &World, factor: f64| {
            let there = Ray::new(ray.origin() * factor, ray.direction() * factor).expect("a ray");
            crossings(world, &there, *span)
        };
        let (a, b) = (list(&twice, 2.0), list(&other, factor));
        assert_eq!(bits(&a), bits(&b), "{factor:e} times: {ray:?} {span:?}\n{a:#?}\n{b:#?}");
    }
}

/// Welds the triangles that the bytes describe, and checks the properties of welding. No vertex moves farther
/// than the distance. Welding again changes nothing. Faces are kept or reported as collapsed. Merging vertices at
/// exactly the same point does not change what rays hit.
///
/// # Panics
/// If one of these does not hold.
pub fn weld(data: &[u8]) {
    let mut bytes = Bytes(data);
    let distance = [0.0, 1.0 / 16.0, 1e-6, 1.0, 1e-300, 1e300][bytes.below(6)];
    let vertices: Vec<Vec3> = (0..=bytes.below(64)).map(|_| bytes.vector()).collect();
    let faces =
        (0..=bytes.below(96)).map(|_| [0; 3].map(|_: u32| bytes.below(vertices.len()) as u32)).collect();
    let mesh = TriangleMesh::new(vertices, faces);
    for weld in [Weld::Within(distance), Weld::Within(0.0), Weld::Auto] {
        let Ok((welded, report)) = mesh.welded(weld) else { panic!("refused: {mesh:?}") };
        assert!(report.farthest <= report.distance.unwrap_or(0.0), "{report:?}");
        assert_eq!(welded.faces.len() + report.collapsed, mesh.faces.len());
        assert_eq!(welded.vertices.len() + report.merged + report.repeated, mesh.vertices.len());
        assert!(welded.vertices.iter().all(|v| mesh.vertices.contains(v)));
        if let Some(distance) = report.distance {
            let again = mesh_again(&welded, Weld::Within(distance));
            assert_eq!(again, welded, "welding again changes it");
        }
    }
    let exact = mesh_again(&mesh, Weld::Within(0.0));
    let hits = |mesh: &TriangleMesh| {
        let Ok(solid) = MeshSolid::new(Arc::new(mesh.clone()), "brute") else { return None };
        let mut hits = Vec::new();
        for (o, d) in
            [(Vec3::new(-9.0, 0.1, 0.2), Vec3::X), (Vec3::new(0.3, 9.0, -0.4), Vec3::new(0.1, -1.0, 0.0))]
        {
            solid.hits(&Line::exact(o, d), Span::FORWARD, &mut hits, &mut Scratch::default());
        }
        Some(hits)
    };
    assert_eq!(hits(&mesh), hits(&exact));
}

fn mesh_again(mesh: &TriangleMesh, weld: Weld) -> TriangleMesh {
    mesh.welded(weld).unwrap_or_else(|e| panic!("{e}")).0
}

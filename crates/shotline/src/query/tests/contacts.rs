//! Rays in the surfaces of operands of every kind, including meshes: a ray is inside a combination where everything
//! around the ray is.

use super::touching::{boxed, csg, halfspace, number, seen, seen_within};
use super::*;
use crate::scene::NodeId;
use crate::solid::mesh::shapes::cubes;

const SIZE: i32 = 4;

/// A set of unit cubes of a grid.
type Cells = std::collections::BTreeSet<[i32; 3]>;

fn mesh(scene: &mut Scene, mesh: TriangleMesh) -> NodeId {
    scene.add(Node::Mesh { mesh: Arc::new(mesh), file: None })
}

fn quadric(scene: &mut Scene, coefficients: [f64; 10]) -> NodeId {
    scene.add_solid("quadric", &[&coefficients]).expect("a quadric")
}

/// A block of cubes of the grid, as a random kind of solid.
fn block(scene: &mut Scene, random: &mut Random, cells: &mut Cells) -> NodeId {
    let mut min = [0; 3];
    let mut max = [0; 3];
    for i in 0..3 {
        let (a, b) = (random.below(SIZE as usize) as i32, random.below(SIZE as usize) as i32);
        (min[i], max[i]) = (a.min(b), a.max(b) + 1);
    }
    let all = (0..SIZE.pow(3)).map(|k| [k % SIZE, k / SIZE % SIZE, k / SIZE / SIZE]);
    cells.extend(all.filter(|cell| (0..3).all(|i| min[i] <= cell[i] && cell[i] < max[i])));
    let places: Vec<[i32; 3]> = cells.iter().copied().collect();
    let axis = random.below(3);
    match random.below(6) {
        0 | 1 => boxed(scene, min.map(f64::from), max.map(f64::from)),
        2 => mesh(scene, cubes(&places)),
        3 => {
            // The mirror image of its mirror image.
            let mirror = Affine::scaling(Vec3::ONE - 2.0 * Vec3::AXES[axis]);
            let child = mesh(scene, cubes(&places).moved(&mirror).inside_out());
            scene.add_transform(mirror, child)
        }
        4 => {
            let child = mesh(scene, cubes(&places).moved(&Affine::rotation_xyz(Vec3::AXES[axis] * -30.0)));
            scene.add_transform(Affine::rotation_xyz(Vec3::AXES[axis] * 30.0), child)
        }
        _ => {
            let sides = (0..3).flat_map(|i| {
                let mut normal = [0.0; 3];
                normal[i] = 1.0;
                let behind = halfspace(scene, normal, f64::from(max[i]));
                normal[i] = -2.0;
                [behind, halfspace(scene, normal, -2.0 * f64::from(min[i]))]
            });
            let sides = sides.collect();
            csg(scene, Op::Intersection, sides)
        }
    }
}

fn combination(scene: &mut Scene, random: &mut Random, depth: u32, cells: &mut Cells) -> NodeId {
    if depth == 0 || random.below(4) == 0 {
        return block(scene, random, cells);
    }
    let mut other = Cells::new();
    let args =
        vec![combination(scene, random, depth - 1, cells), combination(scene, random, depth - 1, &mut other)];
    let op = [Op::Union, Op::Union, Op::Intersection, Op::Difference][random.below(4)];
    *cells = match op {
        Op::Union => &*cells | &other,
        Op::Intersection => &*cells & &other,
        Op::Difference => &*cells - &other,
    };
    csg(scene, op, args)
}

/// Where all cubes around a ray along the grid are in a set, within a span. The ray advances by one or zero on each
/// axis.
fn expected(cells: &Cells, o: [f64; 3], d: [f64; 3], [t_min, t_max]: [f64; 2]) -> Vec<f64> {
    let inside = |t: f64| {
        let p: [f64; 3] = std::array::from_fn(|i| o[i] + t * d[i]);
        let beside = |i: usize, back: bool| if back { p[i].ceil() - 1.0 } else { p[i].floor() } as i32;
        (0..8).all(|k| cells.contains(&std::array::from_fn(|i| beside(i, k >> i & 1 == 1))))
    };
    let mut list = Vec::new();
    let mut was_inside = false;
    for step in 0..160 {
        // A cube can begin at every half and whole step, and a span begins and ends at multiples of an eighth.
        let t = 0.125 * f64::from(step);
        let is_inside = t >= t_min && t < t_max && inside(t + 0.0625);
        if was_inside != is_inside {
            list.push(t);
        }
        was_inside = is_inside;
    }
    list
}

/// The oracle counts cubes. Rays run in faces and along edges of operands, in planes and on diagonals, over the half
/// line and over spans that begin and end anywhere.
#[test]
fn rays_along_a_grid_see_what_is_all_around_them() {
    let mut random = Random::new(29);
    let (mut crossed, mut rays) = (0, 0);
    for _ in 0..500 {
        let mut scene = Scene::default();
        let mut cells = Cells::new();
        let args = vec![
            combination(&mut scene, &mut random, 2, &mut cells),
            boxed(&mut scene, [20.0; 3], [21.0; 3]),
        ];
        let node = csg(&mut scene, Op::Union, args);
        for _ in 0..4 {
            let (axis, diagonal) = (random.below(3), random.below(3));
            let mut o: [f64; 3] = std::array::from_fn(|_| 0.5 * random.below(2 * SIZE as usize + 1) as f64);
            let mut d = [0.0; 3];
            (d[axis], d[diagonal]) = (1.0, 1.0);
            (o[axis], o[diagonal]) = (o[axis] - 7.0, o[diagonal] - 7.0);
            if diagonal == axis {
                o[axis] = -3.0;
            }
            let span = if random.below(2) == 0 {
                [0.0, f64::INFINITY]
            } else {
                let [a, b] = [0; 2].map(|_: i32| 0.25 * random.below(48) as f64);
                // The span may begin where a cube does. It does not end there within rounding, because no two frames
                // would agree.
                [a.min(b), a.max(b) + 0.125]
            };
            let list = seen_within(scene.clone(), node, o, d, Span::new(span[0], span[1]).expect("a span"));
            let expected = expected(&cells, o, d, span);
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
            assert!(
                list.len() == expected.len() && list.iter().zip(&expected).all(near),
                "{list:?}, but {expected:?}: {:?} from {o:?} along {d:?} in {span:?}",
                scene.nodes
            );
            crossed += usize::from(!list.is_empty());
            rays += 1;
        }
    }
    assert!(6 * crossed > rays, "{crossed} of {rays}");
}

/// Faces far from the ray must not matter even if it runs in their planes, and accelerators return different ones of
/// them.
#[test]
fn accelerators_agree_on_rays_in_faces_of_meshes() {
    let mut random = Random::new(30);
    let mut crossed = 0;
    for _ in 0..60 {
        let mut scene = Scene::default();
        let places: Vec<[i32; 3]> =
            (0..8).filter(|_| random.below(2) == 0).map(|i| [i & 1, i >> 1 & 1, i >> 2]).collect();
        let cells = mesh(&mut scene, cubes(&places));
        let far = boxed(&mut scene, [8.0; 3], [9.0; 3]);
        let both = csg(&mut scene, Op::Union, vec![cells, far]);
        scene.add_object("thing", None, both);
        let worlds: Vec<World> = crate::accel::NAMES.iter().map(|name| world(&scene, name)).collect();
        for _ in 0..60 {
            let mut point = || Vec3::from([0; 3].map(|_: i32| 0.25 * random.below(9) as f64));
            let (from, to) = (point(), point());
            let Ok(ray) = Ray::new(from * 2.0 - to, to - from) else { continue };
            let list = crossings(&worlds[0], &ray, Span::FORWARD);
            crossed += usize::from(!list.is_empty());
            for (other, name) in worlds.iter().zip(crate::accel::NAMES) {
                assert_same(&list, &crossings(other, &ray, Span::FORWARD), name);
            }
        }
    }
    assert!(crossed > 1000, "{crossed}");
}

#[test]
fn a_mesh_shares_its_faces_with_solids_and_with_its_mirror_image() {
    let mut scene = Scene::default();
    let slab = cubes(&[[0, 0, 0]])
        .moved(&Affine::from_row_major([2.0, 0.0, 0.0, -1.0, 0.0, 2.0, 0.0, -1.0, 0.0, 0.0, 1.0, -1.0]));
    let below = mesh(&mut scene, slab.clone());
    let above = boxed(&mut scene, [-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]);
    let mirrored = scene.add_transform(Affine::scaling(Vec3::new(1.0, 1.0, -1.0)), below);
    let (o, d) = ([-3.0, 0.2, 0.0], [1.0, 0.0, 0.0]);
    for other in [above, mirrored] {
        let both = csg(&mut scene, Op::Union, vec![below, other]);
        assert_eq!(seen(scene.clone(), both, o, d), [2.0, 4.0]);
        let common = csg(&mut scene, Op::Intersection, vec![below, other]);
        assert!(seen(scene.clone(), common, o, d).is_empty());
        let rest = csg(&mut scene, Op::Difference, vec![below, other]);
        assert!(seen(scene.clone(), rest, o, d).is_empty());
    }
}

/// The gradient of a quadric vanishes along the line where two planes cross, and in a double plane.
#[test]
fn a_ray_along_a_line_without_gradient_sees_what_is_around_it() {
    let mut scene = Scene::default();
    let cube = boxed(&mut scene, [-1.0; 3], [1.0; 3]);
    let mut xy = [0.0; 10];
    xy[3] = 1.0;
    let (one, other) = (quadric(&mut scene, xy), quadric(&mut scene, xy.map(|x| -2.0 * x)));
    let (o, d) = ([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]);
    let both = csg(&mut scene, Op::Union, vec![one, other]);
    let whole = csg(&mut scene, Op::Intersection, vec![cube, both]);
    assert_eq!(seen(scene.clone(), whole, o, d), [2.0, 4.0]);
    let half = csg(&mut scene, Op::Intersection, vec![cube, one]);
    assert!(seen(scene.clone(), half, o, d).is_empty());
    let nothing = csg(&mut scene, Op::Difference, vec![cube, one, other]);
    assert!(seen(scene.clone(), nothing, o, d).is_empty());
    // Half-spaces fill the quarters that the quadric leaves open.
    let quarters = [[1.0, 1.0], [-1.0, -1.0]].map(|[x, y]| {
        let planes = [halfspace(&mut scene, [x, 0.0, 0.0], 0.0), halfspace(&mut scene, [0.0, y, 0.0], 0.0)];
        csg(&mut scene, Op::Intersection, planes.to_vec())
    });
    let filled = csg(&mut scene, Op::Union, vec![one, quarters[0], quarters[1]]);
    let filled = csg(&mut scene, Op::Intersection, vec![cube, filled]);
    assert_eq!(seen(scene.clone(), filled, o, d), [2.0, 4.0]);
    let mut twice = [0.0; 10];
    twice[0] = -1.0;
    let twice = quadric(&mut scene, twice);
    let cut = csg(&mut scene, Op::Intersection, vec![cube, twice]);
    assert_eq!(seen(scene.clone(), cut, [0.0, 0.1, -3.0], d), [2.0, 4.0]);
    let rest = csg(&mut scene, Op::Difference, vec![cube, twice]);
    assert!(seen(scene, rest, [0.0, 0.1, -3.0], d).is_empty());
}

/// A cone changes at its apex from one side of a generator to the other.
#[test]
fn a_ray_along_a_cone_and_through_its_apex_changes_sides() {
    let mut scene = Scene::default();
    let cone = [1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let cones = quadric(&mut scene, cone);
    let outside = quadric(&mut scene, cone.map(|x| -3.0 * x));
    let cube = boxed(&mut scene, [-1.0; 3], [1.0; 3]);
    // In front of the tangent plane along the ray. Above the apex that side is outside the cone, below it is inside.
    let beyond = halfspace(&mut scene, [-1.0, 0.0, 1.0], 0.0);
    let (o, d) = ([-3.0, 0.0, -3.0], [1.0, 0.0, 1.0]);
    let mut within_cube = |args: Vec<NodeId>| {
        let all = csg(&mut scene, Op::Union, args);
        let cut = csg(&mut scene, Op::Intersection, vec![cube, all]);
        seen(scene.clone(), cut, o, d)
    };
    assert_eq!(within_cube(vec![cones, outside]), [2.0, 4.0]);
    assert_eq!(within_cube(vec![outside, beyond]), [2.0, 3.0]);
    // The tangent plane separates from the cone at once, so a gap is left on both sides of the ray.
    assert!(within_cube(vec![cones, beyond]).is_empty());
}

/// A rod that rests on a plate is tangent to it along a line, which is not in the interior of their union.
#[test]
fn a_ray_along_a_line_where_curved_surfaces_touch_is_not_inside() {
    let mut scene = Scene::default();
    let rod = number(&mut scene, "cylinder", &[1.0, -1.0, 1.0]);
    let thick = number(&mut scene, "cylinder", &[2.0, -1.0, 1.0]);
    let plate = boxed(&mut scene, [1.0, -3.0, -1.0], [2.0, 3.0, 1.0]);
    let block = boxed(&mut scene, [-1.0, -3.0, -1.0], [1.0, 3.0, 1.0]);
    let thick = scene.add_transform(Affine::translation(Vec3::new(-1.0, 0.0, 0.0)), thick);
    let (o, d) = ([1.0, 0.0, -3.0], [0.0, 0.0, 1.0]);
    let mut list = |op: Op, args: Vec<NodeId>| {
        let node = csg(&mut scene, op, args);
        (node, seen(scene.clone(), node, o, d))
    };
    let (_, resting) = list(Op::Union, vec![rod, plate]);
    assert!(resting.is_empty(), "{resting:?}");
    let (hollow, _) = list(Op::Difference, vec![block, rod]);
    // A bore that is tangent to the face from inside leaves nothing there; the plug of a wider one overlaps it.
    assert!(list(Op::Union, vec![hollow, plate]).1.is_empty());
    assert_eq!(list(Op::Union, vec![hollow, plate, rod]).1, [2.0, 4.0]);
    assert_eq!(list(Op::Union, vec![hollow, plate, thick]).1, [2.0, 4.0]);
    assert!(list(Op::Union, vec![plate, thick]).1.is_empty());
}

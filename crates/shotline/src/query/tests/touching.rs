//! Rays in faces, rays parallel to unbounded surfaces, and chains of events.

use super::*;

const TURN: Vec3 = Vec3::new(10.0, 20.0, 330.0);

pub(super) fn boxed(scene: &mut Scene, min: [f64; 3], max: [f64; 3]) -> crate::scene::NodeId {
    scene.add_solid("box", &[&min, &max]).expect("a box")
}

pub(super) fn halfspace(scene: &mut Scene, normal: [f64; 3], offset: f64) -> crate::scene::NodeId {
    scene.add_solid("halfspace", &[&normal, &[offset]]).expect("a half-space")
}

pub(super) fn number(scene: &mut Scene, kind: &str, numbers: &[f64]) -> crate::scene::NodeId {
    let values: Vec<&[f64]> = numbers.chunks(1).collect();
    scene.add_solid(kind, &values).expect("a solid")
}

pub(super) fn csg(scene: &mut Scene, op: Op, args: Vec<crate::scene::NodeId>) -> crate::scene::NodeId {
    scene.add(Node::Csg { op, args })
}

/// As [`seen_within`], for the half line.
pub(super) fn seen(scene: Scene, node: crate::scene::NodeId, o: [f64; 3], d: [f64; 3]) -> Vec<f64> {
    seen_within(scene, node, o, d, Span::FORWARD)
}

/// The `t` at which a ray crosses a node, as it is and under a rotation of both. All queries must agree.
pub(super) fn seen_within(
    mut scene: Scene,
    node: crate::scene::NodeId,
    o: [f64; 3],
    d: [f64; 3],
    span: Span,
) -> Vec<f64> {
    let turn = Affine::rotation_xyz(TURN);
    let turned = scene.add_transform(turn, node);
    let lists = [(node, Affine::IDENTITY), (turned, turn)].map(|(node, frame)| {
        let mut scene = scene.clone();
        scene.add_object("thing", None, node);
        let ray = Ray::new(frame.point(o.into()), frame.vector(d.into())).expect("a ray");
        let lists = ["brute", "bvh", "grid"].map(|accel| {
            let world = world(&scene, accel);
            let list = crossings(&world, &ray, span);
            let mut caster = Caster::new(&world);
            assert_eq!(
                caster.closest(&ray, span).expect("within limits").map(|h| h.t),
                list.first().map(|h| h.t)
            );
            assert_eq!(caster.any(&ray, span), Ok(!list.is_empty()));
            list
        });
        assert_same(&lists[0], &lists[1], "bvh");
        assert_same(&lists[0], &lists[2], "grid");
        lists[0].iter().map(|h| h.t).collect::<Vec<_>>()
    });
    let [plain, turned] = lists;
    let near = |(a, b): (&f64, &f64)| a == b || (a - b).abs() < 1e-12 * a.abs().max(1.0);
    assert!(
        plain.len() == turned.len() && plain.iter().zip(&turned).all(near),
        "{plain:?} turned: {turned:?}"
    );
    plain
}

#[test]
fn a_ray_in_a_shared_face_sees_no_seam() {
    let mut scene = Scene::default();
    let (low, high) =
        (boxed(&mut scene, [0.0; 3], [1.0; 3]), boxed(&mut scene, [0.0, 0.0, 1.0], [1.0, 1.0, 2.0]));
    let both = csg(&mut scene, Op::Union, vec![low, high]);
    let (o, d) = ([-1.0, 0.5, 1.0], [1.0, 0.0, 0.0]);
    assert_eq!(seen(scene.clone(), both, o, d), [1.0, 2.0]);
    // A face that only one operand has is outside, and so is a gap.
    assert!(seen(scene.clone(), low, o, d).is_empty());
    let common = csg(&mut scene, Op::Intersection, vec![low, high]);
    assert!(seen(scene.clone(), common, o, d).is_empty());
    // A ray that begins in the face.
    assert_eq!(seen(scene, both, [0.5, 0.5, 1.0], d), [0.0, 0.5]);
}

#[test]
fn a_ray_leaves_where_the_face_is_no_longer_shared() {
    let mut scene = Scene::default();
    let plate = boxed(&mut scene, [0.0; 3], [4.0, 4.0, 1.0]);
    let block = boxed(&mut scene, [1.0, 1.0, 1.0], [2.0, 2.0, 3.0]);
    let both = csg(&mut scene, Op::Union, vec![plate, block]);
    assert_eq!(seen(scene, both, [-1.0, 1.5, 1.0], [1.0, 0.0, 0.0]), [2.0, 3.0]);
}

#[test]
fn a_ray_along_an_edge_sees_no_seam_if_the_operands_close_around_it() {
    let mut scene = Scene::default();
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let boxes = corners.map(|[y, z]| boxed(&mut scene, [0.0, y, z], [1.0, y + 1.0, z + 1.0]));
    let (o, d) = ([-1.0, 1.0, 1.0], [1.0, 0.0, 0.0]);
    let four = csg(&mut scene, Op::Union, boxes.to_vec());
    assert_eq!(seen(scene.clone(), four, o, d), [1.0, 2.0]);
    let three = csg(&mut scene, Op::Union, boxes[..3].to_vec());
    assert!(seen(scene, three, o, d).is_empty());
}

#[test]
fn halves_of_a_ball_and_stacked_cylinders_have_no_seam() {
    let mut scene = Scene::default();
    let ball = number(&mut scene, "sphere", &[1.0]);
    let (below, above) =
        (halfspace(&mut scene, [0.0, 0.0, 1.0], 0.25), halfspace(&mut scene, [0.0, 0.0, -2.0], -0.5));
    let halves = [below, above].map(|half| csg(&mut scene, Op::Intersection, vec![ball, half]));
    let whole = csg(&mut scene, Op::Union, halves.to_vec());
    let chord = seen(scene.clone(), whole, [-2.0, 0.0, 0.25], [1.0, 0.0, 0.0]);
    let half = (1.0f64 - 0.0625).sqrt();
    assert!(
        chord.len() == 2
            && (chord[0] - (2.0 - half)).abs() < 1e-15
            && (chord[1] - (2.0 + half)).abs() < 1e-15
    );
    assert!(seen(scene.clone(), halves[0], [-2.0, 0.0, 0.25], [1.0, 0.0, 0.0]).is_empty());
    let lower = number(&mut scene, "cylinder", &[1.0, 0.0, 0.1]);
    let upper = number(&mut scene, "cylinder", &[1.0, 0.1, 0.7]);
    let stack = csg(&mut scene, Op::Union, vec![lower, upper]);
    assert_eq!(seen(scene, stack, [-3.0, 0.0, 0.1], [1.0, 0.0, 0.0]), [2.0, 4.0]);
}

#[test]
fn a_plug_fills_its_hole_along_the_wall_too() {
    let mut scene = Scene::default();
    let block = boxed(&mut scene, [-2.0, -2.0, 0.0], [2.0, 2.0, 3.0]);
    let bore = number(&mut scene, "cylinder", &[1.0, -1.0, 4.0]);
    let plug = number(&mut scene, "cylinder", &[1.0, 0.0, 3.0]);
    let drilled = csg(&mut scene, Op::Difference, vec![block, bore]);
    let (o, d) = ([1.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    assert!(seen(scene.clone(), drilled, o, d).is_empty());
    let filled = csg(&mut scene, Op::Union, vec![drilled, plug]);
    assert_eq!(seen(scene, filled, o, d), [1.0, 4.0]);
}

/// A ray that is parallel to a cutting plane up to rounding: the far root must not swallow near crossings.
#[test]
fn a_crossing_near_infinity_swallows_nothing() {
    let mut scene = Scene::default();
    let ball = number(&mut scene, "sphere", &[1.0]);
    let cube = boxed(&mut scene, [-3.0; 3], [-2.0, 3.0, 3.0]);
    for degrees in [0.0, 30.0, 57.0, 330.0] {
        for offset in [-0.75, 0.75] {
            let half = halfspace(&mut scene, [1.0, 2.0, 0.0], offset);
            let turn = Affine::rotation_xyz(Vec3::new(degrees, 2.0 * degrees, degrees));
            let turned = scene.add_transform(turn, half);
            let cut = csg(&mut scene, Op::Intersection, vec![cube, turned]);
            let both = csg(&mut scene, Op::Union, vec![ball, cut]);
            let along = turn.vector(Vec3::new(-2.0, 1.0, 0.0)).to_array();
            let list = seen(scene.clone(), both, (Vec3::from(along) * -4.0).to_array(), along);
            // The ray crosses the ball about the origin, however it crosses the cube.
            let (from, to) = (4.0 - 0.2f64.sqrt(), 4.0 + 0.2f64.sqrt());
            let has = |t: f64| list.iter().any(|x| (x - t).abs() < 1e-12);
            assert!(has(from) && has(to), "{degrees} degrees, offset {offset}: {list:?}");
        }
    }
}

#[test]
fn a_ray_inside_an_endless_cylinder_stays_inside() {
    let mut scene = Scene::default();
    let mut coefficients = [0.0; 10];
    (coefficients[0], coefficients[1], coefficients[9]) = (1.0, 1.0, -1.0);
    let rod = scene.add_solid("quadric", &[&coefficients]).expect("a quadric");
    let cube = boxed(&mut scene, [-2.0; 3], [2.0; 3]);
    let (cut, holed) = (
        csg(&mut scene, Op::Intersection, vec![cube, rod]),
        csg(&mut scene, Op::Difference, vec![cube, rod]),
    );
    let (along, beside) = ([0.3, 0.2, -5.0], [1.3, 0.2, -5.0]);
    let d = [0.0, 0.0, 1.0];
    assert_eq!(seen(scene.clone(), cut, along, d), [3.0, 7.0]);
    assert!(seen(scene.clone(), cut, beside, d).is_empty());
    assert!(seen(scene.clone(), holed, along, d).is_empty());
    assert_eq!(seen(scene, holed, beside, d), [3.0, 7.0]);
}

#[test]
fn thin_layers_seen_from_afar_are_one_body() {
    for (count, thickness, gap, distance) in
        [(1000, 1e-6, 0.0, 1e9), (1000, 1e-9, 0.0, 1e6), (300, 1e-6, 1e-6, 1e9), (1000, 1e-6, 0.0, 3.0)]
    {
        let mut scene = Scene::default();
        let pitch = thickness + gap;
        let layers = (0..count)
            .map(|i| f64::from(i) * pitch)
            .map(|z| boxed(&mut scene, [0.0, 0.0, z], [1.0, 1.0, z + thickness]))
            .collect();
        let stack = csg(&mut scene, Op::Union, layers);
        scene.add_object("stack", None, stack);
        let world = world(&scene, "bvh");
        let ray = Ray::new(Vec3::new(0.3, 0.4, -distance), Vec3::Z).expect("a ray");
        let list = crossings(&world, &ray, Span::FORWARD);
        let (first, last) = (list.first().expect("an entry"), list.last().expect("an exit"));
        let end = distance + f64::from(count) * pitch - gap;
        assert!(
            (first.t - distance).abs() <= first.t_err
                && (last.t - end).abs() <= 1e-15 * distance + last.t_err
        );
        assert!(gap > 0.0 || distance < 1e6 || list.len() == 2, "{} crossings", list.len());
        // From the middle of the stack outward.
        let start = distance + 0.5 * f64::from(count) * pitch;
        let rest = crossings(&world, &ray, Span::new(start, f64::INFINITY).expect("a span"));
        assert_eq!(rest.last().map(|h| h.t), Some(last.t));
        assert!(rest.len().is_multiple_of(2) && rest[0].t >= start);
    }
}

/// Layers in two objects, each thicker than the bounds of its faces, but beginning within the bounds of a face of the
/// other. The chain that their faces form must not swallow the segments of either.
#[test]
fn thin_objects_that_overlap_keep_their_segments() {
    for count in [1, 2, 500] {
        let mut scene = Scene::default();
        let layers = [0.0, 2e-6].map(|offset| {
            let boxes = (0..count)
                .map(|i| f64::from(i) * 8e-6 + offset)
                .map(|z| boxed(&mut scene, [0.0, 0.0, z], [1.0, 1.0, z + 4e-6]))
                .collect();
            csg(&mut scene, Op::Union, boxes)
        });
        scene.add_object("below", None, layers[0]);
        scene.add_object("above", None, layers[1]);
        let world = world(&scene, "bvh");
        let ray = Ray::new(Vec3::new(0.3, 0.4, -1e9), Vec3::Z).expect("a ray");
        let mut segments = Vec::new();
        Caster::new(&world)
            .segments(&ray, Span::FORWARD, Overlaps::Priority, &mut segments)
            .expect("within limits");
        let length =
            |object: u32| segments.iter().filter(|s| s.object == object).map(|s| s.length).sum::<f64>();
        let (below, above) = (length(0) / f64::from(count), length(1) / f64::from(count));
        // An end that coincides with the start of the other object is replaced by it.
        assert!((1.7e-6..4.3e-6).contains(&below), "{count}: {below}");
        assert!((above - 4e-6).abs() < 3e-7, "{count}: {above}");
    }
}

//! Points of a surface that its mesh has to reach, wherever the cells of the octree are: where lines through the object meet it,
//! and lines through each of the solids that it is made of. So a small bore or pin is not missed between coarse cells.

use shotline::aabb::Aabb;
use shotline::math::{Affine, ComposedTransform, Vec3};
use shotline::query::batch::BatchError;
use shotline::ray::Ray;
use shotline::scene::{Node, NodeId, Scene};

use crate::surface::Surface;

/// Lines along each axis through the longest side of an object, and the fewest through any side.
const LINES: f64 = 64.0;
const FEWEST: f64 = 16.0;

/// The same for the lines that meet points by which a mesh is examined when it seems to be done.
const LAST_LINES: f64 = 300.0;

/// Lines through an object are no closer than this part of the tolerance: there may be many small objects.
const CLOSEST: f64 = 0.5;

/// The fewest and the most lines across a side of the box of a solid. There are as many as the shortest side fits in half of it, so
/// that a long bar is met all along.
const ACROSS_SOLID: (f64, f64) = (3.0, 64.0);

/// The most lines along a bar: a needle may be thinner there than its box, so they are as close as the tolerance.
const MOST_ALONG: f64 = 256.0;

/// Beyond so many lines, no more solids get lines of their own.
const MOST_LINES: usize = 1 << 20;

/// How far lines begin before a box and end behind it, in parts of its side.
const BEYOND: f64 = 0.01;

/// The most nodes of a scene that are looked at for solids, so that shared groups in groups cost no more.
const MOST_NODES: usize = 1 << 16;

/// Points of the surface of an object below a root, within bounds, that its mesh has to reach from the beginning.
pub fn first_points(
    scene: &Scene,
    root: NodeId,
    bounds: &Aabb,
    tolerance: f64,
    surface: &Surface,
) -> Result<Vec<Vec3>, BatchError> {
    let mut lines = lines_through_object(bounds, LINES, tolerance);
    lines_through_solids(scene, root, tolerance, &mut lines);
    points_on(&lines, surface)
}

/// Points of a surface within bounds by which its mesh is examined in the end.
pub fn last_points(bounds: &Aabb, tolerance: f64, surface: &Surface) -> Result<Vec<Vec3>, BatchError> {
    points_on(&lines_through_object(bounds, LAST_LINES, tolerance), surface)
}

fn points_on(lines: &[[Vec3; 2]], surface: &Surface) -> Result<Vec<Vec3>, BatchError> {
    let mut points = Vec::new();
    let ray = |[start, end]: &[Vec3; 2]| Ray::new(*start, *end - *start);
    surface.cast(lines, ray, |[start, end], line| {
        points.extend(line.crossings.iter().map(|crossing| *start + (*end - *start) * crossing.t));
    })?;
    Ok(points)
}

/// Lines from side to side of the box of an object: at most so many across its longest side.
fn lines_through_object(bounds: &Aabb, most: f64, tolerance: f64) -> Vec<[Vec3; 2]> {
    let size = bounds.size();
    let counts =
        (size / (size.max_element() / most).max(CLOSEST * tolerance)).max(Vec3::splat(FEWEST)).ceil();
    lines_through_box(*bounds, counts).collect()
}

/// Lines along the axes through a box, equally spaced: `counts` of them across each side.
fn lines_through_box(bounds: Aabb, counts: Vec3) -> impl Iterator<Item = [Vec3; 2]> {
    (0..3).flat_map(move |axis| {
        let places =
            move |axis: usize| (0..counts[axis] as u32).map(move |i| (f64::from(i) + 0.5) / counts[axis]);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        places(u).flat_map(move |at_u| places(v).map(move |at_v| line(&bounds, axis, (at_u, at_v))))
    })
}

/// The line along an axis through a box, which begins before it and ends behind it, at parts of the two other sides.
fn line(bounds: &Aabb, axis: usize, (at_u, at_v): (f64, f64)) -> [Vec3; 2] {
    let mut at = Vec3::ZERO;
    (at[(axis + 1) % 3], at[(axis + 2) % 3]) = (at_u, at_v);
    [-BEYOND, 1.0 + BEYOND].map(|along| {
        at[axis] = along;
        bounds.min + at * bounds.size()
    })
}

/// Adds lines through the boxes of the solids below a node.
fn lines_through_solids(scene: &Scene, root: NodeId, tolerance: f64, lines: &mut Vec<[Vec3; 2]>) {
    let mut todo = vec![(root, ComposedTransform::IDENTITY)];
    for _ in 0..MOST_NODES {
        let Some((id, frame)) = todo.pop().filter(|_| lines.len() < MOST_LINES) else { return };
        match scene.node(id) {
            Node::Solid { kind, params } => {
                if let (Ok(solid), Ok(pair)) = (kind.build(params), frame.placement()) {
                    let to_world = pair.parent_from_local;
                    let local = lines_through_solid(&solid.bounds(), &to_world, tolerance);
                    lines.extend(local.map(|line| line.map(|point| to_world.point(point))));
                }
            }
            Node::Transform { transform, child } => todo.push((*child, transform.inside(&frame))),
            node => todo.extend(node.children().map(|child| (child, frame))),
        }
    }
}

/// Lines through the box of a solid; none if it has no size or no end.
fn lines_through_solid(
    bounds: &Aabb,
    to_world: &Affine,
    tolerance: f64,
) -> impl Iterator<Item = [Vec3; 2]> + use<> {
    let bounds = Some(*bounds).filter(|bounds| bounds.is_finite() && !bounds.is_empty());
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| to_world.vector(axis).length());
    bounds.into_iter().flat_map(move |bounds| {
        let size = bounds.size() * Vec3::from_array(axes);
        let (fewest, most) = ACROSS_SOLID;
        let mut counts =
            (size / (2.0 * size.min_element())).ceil().clamp(Vec3::splat(fewest), Vec3::splat(most));
        let longest = size.max_position();
        if counts[longest] > fewest {
            counts[longest] = counts[longest].max((size[longest] / tolerance).ceil().min(MOST_ALONG));
        }
        lines_through_box(bounds, counts)
    })
}

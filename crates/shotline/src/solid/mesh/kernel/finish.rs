//! Computes hits that were found, as many at a time as a register has lanes: the operations of [`super::super::plane::PlaneHit`] lane by lane, so
//! that every lane has its bits. What these cannot decide takes the plain path.

use super::block::{Block, Coordinate};
use super::context::Kernel;
use super::found::LaneHit;
use super::ray::SMALLEST;
use super::widths::load_halves;
use crate::accel::wide::LEAF_SIZE;
use crate::crossing::Crossing;
use crate::math::{Affine, Dd, HALF_ULP, UNIT_RANGE, Vec3, power_of_two};
use crate::simd::{Doubles, Simd, Task};
use crate::solid::mesh::exact::minus;
use crate::solid::mesh::mesh_hit::MeshHit;
use crate::solid::mesh::mesh_line::{RESOLVED, STEEPEST};
use crate::solid::mesh::plane::{self, ENOUGH, PRODUCTS, SMALL};

/// The largest number of lanes.
const MAX_LANES: usize = 8;

/// Numbers of hits, one for each lane.
struct Gathered<F: Doubles> {
    corners: [[F; 3]; 3],
    origin: [F; 3],
    direction: [F; 3],
    /// The `t` before scaling is that after scaling times this.
    unscale: F,
    errors: Option<Errors<F>>,
}

/// What the errors of lines need.
struct Errors<F: Doubles> {
    origin: [F; 3],
    direction: [F; 3],
    /// The axis in which the direction is largest.
    along: [usize; MAX_LANES],
}

/// The hits that were computed, and a mask of those that are right.
struct Computed<F: Doubles> {
    t: F::Array,
    t_err: F::Array,
    descent: F::Array,
    is_certain: u8,
}

/// Hits that are to be computed.
struct Finish<'a, C> {
    kernel: &'a Kernel<'a, C>,
    lane_hits: &'a [LaneHit],
    hits: &'a mut Vec<MeshHit>,
}

impl<C: Coordinate> Task for Finish<'_, C> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        self.kernel.finish_lanes::<S::Wide>(self.lane_hits, self.hits);
    }
}

/// Unit normals in world coordinates, and masks of the lanes that are right, and of those whose rays run against them.
struct Normals<F: Doubles> {
    normal: [F::Array; 3],
    is_certain: u8,
    is_against: u8,
}

impl<C: Coordinate> Kernel<'_, C> {
    /// Appends the hits of lane hits, in their order.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(&self, lane_hits: &[LaneHit], hits: &mut Vec<MeshHit>) {
        S::call(Finish { kernel: self, lane_hits, hits });
    }

    /// Appends the hits of lane hits, in their order.
    #[inline(always)]
    fn finish_lanes<F: Doubles>(&self, lane_hits: &[LaneHit], hits: &mut Vec<MeshHit>) {
        for some in lane_hits.chunks(F::LANES) {
            let gathered = self.gather::<F>(some);
            let computed = compute::<F>(&gathered);
            let normals = if self.block.wants_normals {
                self.normals::<F>(&gathered, some)
            } else {
                Normals { normal: [F::splat(f64::NAN).store(); 3], is_certain: !0, is_against: 0 }
            };
            for (lane, lane_hit) in some.iter().enumerate() {
                if computed.is_certain & normals.is_certain & 1 << lane != 0 {
                    hits.push(self.hit(lane_hit, lane, &computed, &normals));
                } else {
                    hits.extend(self.finish_plainly(lane_hit));
                }
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn finish_plainly(&self, lane_hit: &LaneHit) -> Option<MeshHit> {
        let &LaneHit { row, leaf, lane, is_off_edges } = lane_hit;
        let (crossing, _) = self.plain_hit(row as usize, leaf, lane as usize, || ())?;
        if !self.block.wants_normals {
            return Some(MeshHit { row, crossing, is_off_edges, normal: Vec3::NAN, is_against: false });
        }
        let triangle = self.blocks[leaf as usize].triangle(lane as usize);
        let normal = self.block.world_normal(self.frame.oriented(plane::normal(triangle.corners)));
        let is_against = normal.dot(self.block.ray(row as usize).1) < 0.0;
        Some(MeshHit { row, crossing, is_off_edges, normal, is_against })
    }

    #[inline(always)]
    fn hit<F: Doubles>(
        &self,
        lane_hit: &LaneHit,
        lane: usize,
        computed: &Computed<F>,
        normals: &Normals<F>,
    ) -> MeshHit {
        let face = self.blocks[lane_hit.leaf as usize].faces[lane_hit.lane as usize];
        // The line enters where it runs against the normal.
        let entering = computed.descent[lane] < 0.0;
        let crossing = Crossing::new(computed.t[lane], computed.t_err[lane], entering, 0);
        MeshHit {
            row: lane_hit.row,
            crossing: Crossing { primitive: face, ..crossing },
            is_off_edges: lane_hit.is_off_edges,
            normal: Vec3::new(normals.normal[0][lane], normals.normal[1][lane], normals.normal[2][lane]),
            is_against: normals.is_against >> lane & 1 == 1,
        }
    }

    /// The operations of [`plane::normal`] and [`super::lines::RayBlock::world_normal`].
    #[inline(always)]
    fn normals<F: Doubles>(&self, of: &Gathered<F>, lane_hits: &[LaneHit]) -> Normals<F> {
        let splat = F::splat;
        let [a, b, c] = of.corners;
        let (u, v) = ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
        let component = |j: usize, k: usize| u[j] * v[k] - v[j] * u[k];
        let normal = [component(1, 2), component(2, 0), component(0, 1)];
        let area = size_of(&u) * size_of(&v);
        let is_certain = splat(SMALL).is_less(area) & (area / splat(64.0)).is_less(size_of(&normal));
        let normal = if self.frame.is_inward { [-normal[0], -normal[1], -normal[2]] } else { normal };
        let normal = covector::<F>(self.block.frames[0], &covector::<F>(self.block.frames[1], &normal));
        let size = size_of(&normal);
        let is_certain =
            is_certain & splat(UNIT_RANGE[0]).is_at_most(size) & size.is_less(splat(UNIT_RANGE[1]));
        let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
        let reciprocal = splat(1.0) / length;
        let normal = [normal[0] * reciprocal, normal[1] * reciprocal, normal[2] * reciprocal];
        let rows: [usize; MAX_LANES] = std::array::from_fn(|lane| nth(lane_hits, lane).row as usize);
        let [_, d] = load_halves::<F>(self.block.rays, &rows);
        let along = normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2];
        Normals {
            normal: [normal[0].store(), normal[1].store(), normal[2].store()],
            is_certain,
            is_against: along.is_less(splat(0.0)),
        }
    }

    #[inline(always)]
    fn gather<F: Doubles>(&self, lane_hits: &[LaneHit]) -> Gathered<F> {
        let rows: [usize; MAX_LANES] = std::array::from_fn(|lane| nth(lane_hits, lane).row as usize);
        let triangles: [(&Block<C>, usize); MAX_LANES] = std::array::from_fn(|lane| {
            let &LaneHit { leaf, lane, .. } = nth(lane_hits, lane);
            (&self.blocks[leaf as usize], lane as usize % LEAF_SIZE)
        });
        let size = power_of_two(self.frame.size.exponent());
        let [origin, direction] = load_halves::<F>(self.lines().rows, &rows);
        let (of_o, of_d) = (F::splat(1.0 / size), size_of(&direction).power_below_one());
        let errors = self.lines().errors.map(|errors| {
            let [origin, of_direction] = load_halves::<F>(errors, &rows);
            let along = rows.map(|row| longest_axis(self.lines().nominal(row).1));
            Errors { origin: times(origin, of_o), direction: times(of_direction, of_d), along }
        });
        Gathered {
            corners: [corner(&triangles, 0), corner(&triangles, 1), corner(&triangles, 2)],
            origin: times(origin, of_o),
            direction: times(direction, of_d),
            unscale: F::splat(size) * of_d,
            errors,
        }
    }
}

/// A corner of the triangles of all lanes, each a block and a lane of it. Not a closure, which would not be inlined into
/// code compiled for the instructions of `F`.
#[inline(always)]
fn corner<C: Coordinate, F: Doubles>(triangles: &[(&Block<C>, usize); MAX_LANES], corner: usize) -> [F; 3] {
    let coordinate = |axis: usize, lane: usize| {
        let (block, of_leaf) = triangles[lane];
        block.coordinates[axis][corner][of_leaf]
    };
    [
        C::gather(|lane| coordinate(0, lane)),
        C::gather(|lane| coordinate(1, lane)),
        C::gather(|lane| coordinate(2, lane)),
    ]
}

#[inline(always)]
fn times<F: Doubles>(v: [F; 3], factor: F) -> [F; 3] {
    [v[0] * factor, v[1] * factor, v[2] * factor]
}

/// The hit of a lane. Behind the last one, that is taken again.
#[inline(always)]
fn nth(lane_hits: &[LaneHit], lane: usize) -> &LaneHit {
    &lane_hits[lane.min(lane_hits.len() - 1)]
}

/// The operations of [`Affine::covector`].
#[inline(always)]
fn covector<F: Doubles>(frame: &Affine, n: &[F; 3]) -> [F; 3] {
    let m = &frame.rows;
    let splat = F::splat;
    let c = |j: usize| n[0] * splat(m[0][j]) + n[1] * splat(m[1][j]) + n[2] * splat(m[2][j]);
    [c(0), c(1), c(2)]
}

/// The largest absolute value of the components.
#[inline(always)]
fn size_of<F: Doubles>(v: &[F; 3]) -> F {
    v[0].abs().greater(v[1].abs()).greater(v[2].abs())
}

#[inline(always)]
fn compute<F: Doubles>(of: &Gathered<F>) -> Computed<F> {
    let splat = F::splat;
    let [a, b, c] = of.corners;
    let (o, d) = (of.origin, of.direction);
    let size = |v: &[Dd<F>; 3]| size_of(&[v[0].hi, v[1].hi, v[2].hi]);
    // As in `PlaneHit::of`.
    let (u, v, h) = (minus(b, a), minus(c, a), minus(a, o));
    let normal = plane::cross(&u, &v);
    let (height, descent) =
        (plane::dot(&normal, &h), plane::dot(&normal, &[d[0].into(), d[1].into(), d[2].into()]));
    let (area, depth) = (size(&u) * size(&v), size(&h));
    let doubt = splat(PRODUCTS) * area;
    let is_certain = doubt.is_at_most(splat(ENOUGH) * descent.hi.abs())
        & (doubt * depth).is_less(height.hi.abs())
        & splat(SMALL).is_at_most(area * depth.lesser(splat(1.0)));
    let reciprocal = descent.recip();
    let t = (height * reciprocal).hi;
    let products = doubt * (depth + t.abs()) * reciprocal.hi.abs();
    let t_err = splat(1.001 * HALF_ULP) * t.abs() + splat(1.01) * products;
    let t = clamp::<F>(t, [&a, &b, &c], &o, &d);
    let t_err = match &of.errors {
        Some(errors) => {
            t_err + t_err_of_line::<F>(of, errors, t, [normal[0].hi, normal[1].hi, normal[2].hi], descent.hi)
        }
        None => t_err,
    };
    // `t` that may underflow take the plain path.
    let is_certain = is_certain & splat(SMALLEST).is_less(t.abs());
    Computed {
        t: (t * of.unscale).store(),
        t_err: (t_err * of.unscale).store(),
        descent: descent.hi.store(),
        is_certain,
    }
}

/// The operations of [`super::super::mesh_line::MeshLine::t_err_of_line`]. It is zero for lines that are exact.
#[inline(always)]
fn t_err_of_line<F: Doubles>(of: &Gathered<F>, errors: &Errors<F>, t: F, normal: [F; 3], descent: F) -> F {
    let splat = F::splat;
    let (o_err, d_err, t) = (errors.origin, errors.direction, t.abs());
    let point_err = [o_err[0] + d_err[0] * t, o_err[1] + d_err[1] * t, o_err[2] + d_err[2] * t];
    // As in `PlaneHit::t_err_of`.
    let descent = descent.abs();
    let steps = [normal[0].abs() / descent, normal[1].abs() / descent, normal[2].abs() / descent];
    let remaining = splat(1.0) - dot::<F>(&d_err, &steps);
    let bound = dot::<F>(&point_err, &steps) / remaining.greater(splat(0.0));
    let (bound, worst) = (bound.store(), point_err[0].greater(point_err[1].greater(point_err[2])).store());
    // Along each axis.
    let [a, b, c] = of.corners;
    let interval = |i: usize| a[i].greater(b[i]).greater(c[i]) - a[i].lesser(b[i]).lesser(c[i]);
    let intervals = [interval(0).store(), interval(1).store(), interval(2).store()];
    let sizes = [of.direction[0].abs().store(), of.direction[1].abs().store(), of.direction[2].abs().store()];
    F::from_fn(|lane| {
        let along = errors.along[lane] % 3;
        let (size, bound) = (sizes[along][lane], bound[lane]);
        let is_resolved = bound <= RESOLVED * (intervals[along][lane] / size);
        if is_resolved { bound } else { bound.min(STEEPEST * worst[lane] / size) }
    })
}

/// The axis in which a direction is largest, as for [`super::super::sheared_ray::ShearedRay`].
#[inline(always)]
fn longest_axis(d: Vec3) -> usize {
    let size = d.abs();
    if size.z >= size.x && size.z >= size.y { 2 } else { usize::from(size.y >= size.x) }
}

#[inline(always)]
fn dot<F: Doubles>(a: &[F; 3], b: &[F; 3]) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Keeps `t` within the interval of the triangle's box, as [`crate::aabb::BoxRay::enter_exit`] does.
#[inline(always)]
fn clamp<F: Doubles>(t: F, corners: [&[F; 3]; 3], o: &[F; 3], d: &[F; 3]) -> F {
    let splat = F::splat;
    let (mut enter, mut exit) = (splat(f64::NEG_INFINITY), splat(f64::INFINITY));
    for axis in 0..3 {
        let [a, b, c] = [corners[0][axis], corners[1][axis], corners[2][axis]];
        let (low, high) = (a.lesser(b).lesser(c), a.greater(b).greater(c));
        let inverse = splat(1.0) / d[axis];
        let (of_low, of_high) = ((low - o[axis]) * inverse, (high - o[axis]) * inverse);
        // A NaN, from a plane in which the line runs, leaves the bound.
        enter = of_high.where_negative(inverse, of_low).greater(enter);
        exit = of_low.where_negative(inverse, of_high).lesser(exit);
    }
    let (shrink, grow) = (splat(1.0 - 6.0 * HALF_ULP), splat(1.0 + 6.0 * HALF_ULP));
    let enter = (enter * shrink).lesser(enter * grow);
    let exit = (exit * shrink).greater(exit * grow);
    t.greater(enter).lesser(exit)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::index::Blocks;
    use super::super::lines::{BlockQuery, Lines, RayBlock};
    use super::super::prepare::Preparation;
    use super::*;

    type Wide = <Portable as Simd>::Wide;
    use crate::ray::{Line, Span};
    use crate::simd::Portable;
    use crate::solid::mesh::MeshSolid;
    use crate::solid::mesh::kernel::{MeshFrame, WideIndex};
    use crate::testkit::meshes::{Thin, rays_at};
    use crate::testkit::random::Random;

    /// Lines with errors from none to large ones.
    fn lines(random: &mut Random, solid: &MeshSolid, thin: &Thin) -> Vec<Line> {
        let mut lines = Vec::new();
        for ray in rays_at(random, &solid.mesh, thin, 60) {
            let mut error =
                |v: Vec3| v.abs() * random.point(0.0, 1.0) * [0.0, 1e-16, 1e-10, 1e-4][random.below(4)];
            let (o_err, d_err) = (error(ray.origin()), error(ray.direction()));
            lines.push(Line { o_err, d_err, ..Line::of(&ray) });
        }
        lines
    }

    /// Compares all hits of lines with those of the plain path. Returns how many there are, and how many of them it need
    /// not compute.
    fn compare<C: Coordinate>(
        solid: &MeshSolid,
        index: &WideIndex,
        blocks: &[Block<C>],
        lines: &[Line],
    ) -> [usize; 2] {
        let frame = MeshFrame { size: solid.size, scaled_bounds: solid.scaled_bounds, is_inward: false };
        let row = |a: Vec3, b: Vec3| [a.x, a.y, a.z, b.x, b.y, b.z];
        let rows: Vec<_> = lines.iter().map(|line| row(line.o, line.d)).collect();
        let errors: Vec<_> = lines.iter().map(|line| row(line.o_err, line.d_err)).collect();
        let block = RayBlock {
            rays: &rows,
            frames: [&Affine::IDENTITY; 2],
            wants_normals: false,
            lines: Lines { rows: &rows, errors: Some(&errors) },
            span: Span::FORWARD,
            ends: None,
            cancel: None,
        };
        let preparation = Preparation::of(&frame, index.tree.frame, BlockQuery::All);
        let (tree, has_duplicates) = (&index.tree, false);
        let kernel = Kernel { frame: &frame, tree, blocks, has_duplicates, preparation, block: &block };
        let mut lane_hits = Vec::new();
        for row in 0..rows.len() as u32 {
            for (leaf, triangles) in (0..).zip(blocks) {
                for lane in 0..triangles.triangles().1 as u32 {
                    if kernel.plain_hit(row as usize, leaf, lane as usize, || ()).is_some() {
                        lane_hits.push(LaneHit { row, leaf, lane, is_off_edges: false });
                    }
                }
            }
        }
        let mut hits = Vec::new();
        kernel.finish::<Portable>(&lane_hits, &mut hits);
        assert_eq!(hits.len(), lane_hits.len());
        for (hit, lane_hit) in hits.iter().zip(&lane_hits) {
            let plain = kernel.finish_plainly(lane_hit).expect("a hit");
            let bits = |hit: &MeshHit| (hit.crossing.t.to_bits(), hit.crossing.t_err.to_bits());
            assert_eq!(bits(hit), bits(&plain), "{:?}", lines[lane_hit.row as usize]);
            assert_eq!(hit.crossing, plain.crossing);
        }
        let certain = |some: &[LaneHit]| {
            let lanes = (1u32 << some.len()) - 1;
            (u32::from(compute::<Wide>(&kernel.gather(some)).is_certain) & lanes).count_ones() as usize
        };
        [lane_hits.len(), lane_hits.chunks(4).map(certain).sum()]
    }

    #[test]
    fn hits_of_lines_with_errors_have_the_bits_of_the_plain_path() {
        let mut random = Random::new(5);
        let mut counts = [0; 2];
        for _ in 0..100 {
            let thin = if random.below(2) == 0 { Thin::any(&mut random) } else { Thin::near(&mut random) };
            let Ok(solid) = MeshSolid::new(Arc::new(thin.mesh(&mut random)), "bvh") else { continue };
            let lines = lines(&mut random, &solid, &thin);
            let index = solid.index.as_wide().expect("a wide index");
            let [all, certain] = match &index.blocks {
                Blocks::Single(blocks) => compare(&solid, index, blocks, &lines),
                Blocks::Double(blocks) => compare(&solid, index, blocks, &lines),
            };
            counts = [counts[0] + all, counts[1] + certain];
        }
        assert!(counts[0] > 1000 && 2 * counts[1] > counts[0], "{counts:?}");
    }
}

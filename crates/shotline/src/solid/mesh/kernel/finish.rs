//! Computes hits that were found, four at a time: the operations of [`super::super::plane::PlaneHit`] lane by lane, so
//! that every lane has its bits. What these cannot decide takes the plain path.

use super::block::Coordinate;
use super::context::Kernel;
use super::found::LaneHit;
use super::ray::SMALLEST;
use crate::crossing::Crossing;
use crate::math::{Affine, Dd, HALF_ULP, Real, UNIT_RANGE, Vec3, power_of_two};
use crate::simd::{F64x4, Simd};
use crate::solid::mesh::exact::minus;
use crate::solid::mesh::mesh_hit::MeshHit;
use crate::solid::mesh::mesh_line::{RESOLVED, STEEPEST, exponent_within_range};
use crate::solid::mesh::plane::{self, ENOUGH, PRODUCTS, SMALL};

/// The number of hits that are computed at a time.
const LANES: usize = 4;

/// Numbers of up to four hits, number by number.
struct Gathered {
    corners: [[[f64; LANES]; 3]; 3],
    origin: [[f64; LANES]; 3],
    direction: [[f64; LANES]; 3],
    /// The `t` before scaling is that after scaling times this.
    unscale: [f64; LANES],
    errors: Option<Errors>,
}

/// What the errors of up to four lines need.
#[derive(Clone, Copy, Default)]
struct Errors {
    origin: [[f64; LANES]; 3],
    direction: [[f64; LANES]; 3],
    /// The axis in which the direction is largest.
    along: [usize; LANES],
}

/// The hits that were computed, and a mask of those that are right.
struct Computed {
    t: [f64; LANES],
    t_err: [f64; LANES],
    descent: [f64; LANES],
    is_certain: u8,
}

/// Unit normals in world coordinates, and masks of the lanes that are right, and of those whose rays run against them.
struct Normals {
    normal: [[f64; LANES]; 3],
    is_certain: u8,
    is_against: u8,
}

impl<C: Coordinate> Kernel<'_, C> {
    /// Appends the hits of lane_hits, in their order.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(&self, lane_hits: &[LaneHit], hits: &mut Vec<MeshHit>) {
        for some in lane_hits.chunks(LANES) {
            let gathered = self.gather(some);
            let computed = compute::<S>(&gathered);
            let normals = if self.block.wants_normals {
                self.normals::<S>(&gathered, some)
            } else {
                Normals { normal: [[f64::NAN; LANES]; 3], is_certain: !0, is_against: 0 }
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
    fn hit(&self, lane_hit: &LaneHit, lane: usize, computed: &Computed, normals: &Normals) -> MeshHit {
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
    fn normals<S: Simd>(&self, of: &Gathered, lane_hits: &[LaneHit]) -> Normals {
        let splat = <S::F64 as Real>::splat;
        let [a, b, c] = [load::<S>(&of.corners[0]), load::<S>(&of.corners[1]), load::<S>(&of.corners[2])];
        let (u, v) = ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
        let component = |j: usize, k: usize| u[j] * v[k] - v[j] * u[k];
        let normal = [component(1, 2), component(2, 0), component(0, 1)];
        let area = size::<S>(&u) * size::<S>(&v);
        let is_certain = splat(SMALL).is_less(area) & (area / splat(64.0)).is_less(size::<S>(&normal));
        let normal = if self.frame.is_inward { [-normal[0], -normal[1], -normal[2]] } else { normal };
        let normal = covector::<S>(self.block.frames[0], &covector::<S>(self.block.frames[1], &normal));
        let size = size::<S>(&normal);
        let is_certain =
            is_certain & splat(UNIT_RANGE[0]).is_at_most(size) & size.is_less(splat(UNIT_RANGE[1]));
        let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
        let reciprocal = splat(1.0) / length;
        let normal = [normal[0] * reciprocal, normal[1] * reciprocal, normal[2] * reciprocal];
        let mut direction = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let (_, d) = self.block.ray(lane_hits[lane.min(lane_hits.len() - 1)].row as usize);
            (direction[0][lane], direction[1][lane], direction[2][lane]) = (d.x, d.y, d.z);
        }
        let d = load::<S>(&direction);
        let along = normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2];
        Normals {
            normal: [normal[0].store(), normal[1].store(), normal[2].store()],
            is_certain,
            is_against: along.is_less(splat(0.0)),
        }
    }

    #[inline(always)]
    fn gather(&self, lane_hits: &[LaneHit]) -> Gathered {
        let mut out = Gathered {
            corners: [[[0.0; LANES]; 3]; 3],
            origin: [[0.0; LANES]; 3],
            direction: [[0.0; LANES]; 3],
            unscale: [0.0; LANES],
            errors: self.lines().errors.map(|_| Errors::default()),
        };
        let size = self.frame.size.exponent();
        for lane in 0..LANES {
            let LaneHit { row, leaf, lane: of_leaf, .. } = lane_hits[lane.min(lane_hits.len() - 1)];
            let block = &self.blocks[leaf as usize];
            let (o, d) = self.lines().nominal(row as usize);
            let exponent = exponent_within_range(d.abs().max_element());
            let (o, d) = (o * power_of_two(-size), d * power_of_two(-exponent));
            for axis in 0..3 {
                for corner in 0..3 {
                    out.corners[corner][axis][lane] =
                        block.coordinates[axis][corner][of_leaf as usize % LANES].to_f64();
                }
                out.origin[axis][lane] = o[axis];
                out.direction[axis][lane] = d[axis];
            }
            out.unscale[lane] = power_of_two((size - exponent).clamp(-1000, 1000));
            if let (Some(out), Some(errors)) = (&mut out.errors, self.lines().errors) {
                let of_row = &errors[row as usize];
                for axis in 0..3 {
                    out.origin[axis][lane] = of_row[axis] * power_of_two(-size);
                    out.direction[axis][lane] = of_row[3 + axis] * power_of_two(-exponent);
                }
                out.along[lane] = longest_axis(d);
            }
        }
        out
    }
}

/// The operations of [`Affine::covector`].
#[inline(always)]
fn covector<S: Simd>(frame: &Affine, n: &[S::F64; 3]) -> [S::F64; 3] {
    let m = &frame.rows;
    let splat = <S::F64 as Real>::splat;
    let c = |j: usize| n[0] * splat(m[0][j]) + n[1] * splat(m[1][j]) + n[2] * splat(m[2][j]);
    [c(0), c(1), c(2)]
}

/// The largest absolute value of the components.
#[inline(always)]
fn size<S: Simd>(v: &[S::F64; 3]) -> S::F64 {
    v[0].abs().greater(v[1].abs()).greater(v[2].abs())
}

#[inline(always)]
fn load<S: Simd>(v: &[[f64; LANES]; 3]) -> [S::F64; 3] {
    [S::F64::load(&v[0]), S::F64::load(&v[1]), S::F64::load(&v[2])]
}

#[inline(always)]
fn compute<S: Simd>(of: &Gathered) -> Computed {
    let splat = <S::F64 as Real>::splat;
    let [a, b, c] = [load::<S>(&of.corners[0]), load::<S>(&of.corners[1]), load::<S>(&of.corners[2])];
    let (o, d) = (load::<S>(&of.origin), load::<S>(&of.direction));
    let size = |v: &[Dd<S::F64>; 3]| size::<S>(&[v[0].hi, v[1].hi, v[2].hi]);
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
    let t = clamp::<S>(t, [&a, &b, &c], &o, &d);
    let t_err = match &of.errors {
        Some(errors) => {
            t_err + t_err_of_line::<S>(of, errors, t, [normal[0].hi, normal[1].hi, normal[2].hi], descent.hi)
        }
        None => t_err,
    };
    let unscale = S::F64::load(&of.unscale);
    // `t` that may underflow take the plain path.
    let is_certain = is_certain & splat(SMALLEST).is_less(t.abs());
    Computed {
        t: (t * unscale).store(),
        t_err: (t_err * unscale).store(),
        descent: descent.hi.store(),
        is_certain,
    }
}

/// The operations of [`super::super::mesh_line::MeshLine::t_err_of_line`]. It is zero for lines that are exact.
#[inline(always)]
fn t_err_of_line<S: Simd>(
    of: &Gathered,
    errors: &Errors,
    t: S::F64,
    normal: [S::F64; 3],
    descent: S::F64,
) -> S::F64 {
    let splat = <S::F64 as Real>::splat;
    let (o_err, d_err, t) = (load::<S>(&errors.origin), load::<S>(&errors.direction), t.abs());
    let point_err = [o_err[0] + d_err[0] * t, o_err[1] + d_err[1] * t, o_err[2] + d_err[2] * t];
    // As in `PlaneHit::t_err_of`.
    let descent = descent.abs();
    let steps = [normal[0].abs() / descent, normal[1].abs() / descent, normal[2].abs() / descent];
    let remaining = splat(1.0) - dot::<S>(&d_err, &steps);
    let bound = dot::<S>(&point_err, &steps) / remaining.greater(splat(0.0));
    let (bound, worst) = (bound.store(), point_err[0].greater(point_err[1].greater(point_err[2])).store());
    let mut of_line = [0.0; LANES];
    for lane in 0..LANES {
        let along = errors.along[lane] % 3;
        let [a, b, c] = [of.corners[0][along][lane], of.corners[1][along][lane], of.corners[2][along][lane]];
        let size = of.direction[along][lane].abs();
        let longest_interval = (a.max(b).max(c) - a.min(b).min(c)) / size;
        let bound = bound[lane];
        let is_resolved = bound <= RESOLVED * longest_interval;
        of_line[lane] = if is_resolved { bound } else { bound.min(STEEPEST * worst[lane] / size) };
    }
    S::F64::load(&of_line)
}

/// The axis in which a direction is largest, as for [`super::super::sheared_ray::ShearedRay`].
#[inline(always)]
fn longest_axis(d: Vec3) -> usize {
    let size = d.abs();
    if size.z >= size.x && size.z >= size.y { 2 } else { usize::from(size.y >= size.x) }
}

#[inline(always)]
fn dot<S: Simd>(a: &[S::F64; 3], b: &[S::F64; 3]) -> S::F64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Keeps `t` within the interval of the triangle's box, as [`crate::aabb::BoxRay::enter_exit`] does.
#[inline(always)]
fn clamp<S: Simd>(t: S::F64, corners: [&[S::F64; 3]; 3], o: &[S::F64; 3], d: &[S::F64; 3]) -> S::F64 {
    let splat = <S::F64 as Real>::splat;
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

    use super::super::block::Block;
    use super::super::index::Blocks;
    use super::super::lines::{BlockQuery, Lines, RayBlock};
    use super::super::prepare::Preparation;
    use super::*;
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
            (u32::from(compute::<Portable>(&kernel.gather(some)).is_certain) & lanes).count_ones() as usize
        };
        [lane_hits.len(), lane_hits.chunks(LANES).map(certain).sum()]
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

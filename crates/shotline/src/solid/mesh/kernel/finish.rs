//! Computes hits that were found, four at a time: the operations of [`super::super::plane::PlaneHit`] lane by lane, so
//! that every lane has its bits. What these cannot decide, and lines that are not exact, take the plain path.

use super::block::Coordinate;
use super::context::Kernel;
use super::found::LaneHit;
use super::ray::SMALLEST;
use crate::crossing::Crossing;
use crate::math::{Affine, Dd, HALF_ULP, Real, UNIT_RANGE, Vec3, power_of_two};
use crate::simd::{F64x4, Simd};
use crate::solid::mesh::exact::minus;
use crate::solid::mesh::mesh_hit::MeshHit;
use crate::solid::mesh::mesh_line::exponent_within_range;
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
        if self.lines().errors.is_some() {
            hits.extend(lane_hits.iter().filter_map(|lane_hit| self.finish_plainly(lane_hit)));
            return;
        }
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

//! The triangles of a leaf, lane by lane.

use crate::accel::wide::{LEAF_SIZE, NONE};
use crate::math::Vec3;
use crate::simd::{Doubles, Simd};
use crate::solid::mesh::mesh_line::Triangle;

/// A type in which the corners of a mesh are stored without rounding. Most files hold float32, which takes half the
/// memory.
pub(in crate::solid::mesh) trait Coordinate: Copy + Send + Sync + 'static {
    fn from_f64(x: f64) -> Self;
    fn to_f64(self) -> f64;
    fn load<S: Simd>(from: &[Self; LEAF_SIZE]) -> S::F64x4;
    /// One coordinate for each lane.
    #[inline(always)]
    fn gather<F: Doubles>(coordinate: impl Fn(usize) -> Self) -> F {
        F::from_fn(|lane| coordinate(lane).to_f64())
    }
}

impl Coordinate for f32 {
    #[inline(always)]
    fn from_f64(x: f64) -> f32 {
        x as f32
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn load<S: Simd>(from: &[f32; LEAF_SIZE]) -> S::F64x4 {
        S::widen(from)
    }
}

impl Coordinate for f64 {
    #[inline(always)]
    fn from_f64(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline(always)]
    fn load<S: Simd>(from: &[f64; LEAF_SIZE]) -> S::F64x4 {
        S::F64x4::load(from)
    }
}

/// Whether float32 holds a coordinate without rounding.
pub(super) fn is_single(x: f64) -> bool {
    f64::from(x as f32) == x
}

/// Up to four scaled triangles. The corners of unused lanes are NaN: they are never hit.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(in crate::solid::mesh) struct Block<C> {
    /// By axis, corner and lane.
    pub coordinates: [[[C; LEAF_SIZE]; 3]; 3],
    pub faces: [u32; LEAF_SIZE],
}

impl<C: Coordinate> Block<C> {
    pub fn of(triangles: [Option<Triangle>; LEAF_SIZE]) -> Block<C> {
        let coordinate = |triangle: Option<Triangle>, corner: usize, axis: usize| {
            C::from_f64(triangle.map_or(f64::NAN, |t| t.corners[corner][axis]))
        };
        Block {
            coordinates: std::array::from_fn(|axis| {
                std::array::from_fn(|corner| triangles.map(|t| coordinate(t, corner, axis)))
            }),
            faces: triangles.map(|t| t.map_or(NONE, |t| t.face)),
        }
    }

    /// The triangles of all lanes, and how many of them are used; these come first.
    pub fn triangles(&self) -> ([Triangle; LEAF_SIZE], usize) {
        let count = self.faces.iter().take_while(|face| **face != NONE).count();
        (std::array::from_fn(|lane| self.triangle(lane)), count)
    }

    /// The triangle of a lane.
    pub fn triangle(&self, lane: usize) -> Triangle {
        let corner = |corner: usize| {
            Vec3::from([0, 1, 2].map(|axis: usize| self.coordinates[axis][corner][lane].to_f64()))
        };
        Triangle { corners: [corner(0), corner(1), corner(2)], face: self.faces[lane] }
    }
}

//! Normals at boundaries of rays in lanes, with the bits of those of single rays.

use super::lane_bodies::{Bodies, leaves_in_lanes};
use super::level_visit::ones;
use crate::compile::Leaf;
use crate::crossing::NO_PRIMITIVE;
use crate::lanes::LineLanes;
use crate::lanes::vector::{covector, covector_each, units, where_set};
use crate::math::{Affine, Vec3, unit};
use crate::simd::Doubles;
use crate::solid::lanes::InLanes;

/// A normal of each lane, axis by axis.
pub(super) type NormalLanes = [[f64; 8]; 3];

/// The transforms from the world to bodies, innermost first.
#[derive(Clone, Copy)]
pub(super) enum Frames<'n> {
    /// All lines meet the same body.
    Same(&'n [&'n Affine]),
    /// The transform of each lane, and the lanes that have one.
    Each(&'n [([&'n Affine; 8], u8)]),
}

/// The leaves at whose surfaces normals are computed.
pub(super) enum Leaves<'n> {
    Of(Bodies<'n>),
    /// A leaf of each lane, its frame, and the lanes in which it is subtracted.
    Each {
        solids: &'n [InLanes<'n>; 8],
        frames: [&'n Affine; 8],
        subtracted: u8,
    },
}

/// What normals are computed of.
pub(super) struct Normals<'n, F> {
    pub leaves: Leaves<'n>,
    /// The lines in the frame of the body.
    pub line: &'n LineLanes<F>,
    pub frames: Frames<'n>,
}

impl<F: Doubles> Normals<'_, F> {
    /// The normals in world coordinates in some lanes, at the crossings with surfaces of a leaf, as for a single ray.
    #[inline(always)]
    pub fn at(&self, leaf: u32, t: F, surface: F, lanes: u8) -> NormalLanes {
        // Turns -0.0 into 0.0, as in the fold of a single ray.
        let t = t + F::splat(0.0);
        let (mut normal, subtracted) = match &self.leaves {
            Leaves::Of(bodies) => {
                let subtracted = if bodies.first().program.is_subtracted(leaf) { u8::MAX } else { 0 };
                (bodies.outward_normals(leaf, self.line, t, surface, lanes), subtracted)
            }
            Leaves::Each { solids, frames, subtracted } => {
                (normals_of_each(solids, frames, self.line, t, surface), *subtracted)
            }
        };
        match self.frames {
            Frames::Same(frames) => {
                for frame in frames {
                    normal = covector(frame, normal);
                }
            }
            Frames::Each(frames) => {
                for (frames, lanes) in frames {
                    normal = where_set(covector_each(frames, normal), *lanes, normal);
                }
            }
        }
        let (mut of_length_one, ordinary) = units(normal);
        if subtracted != 0 {
            let [x, y, z] = of_length_one;
            of_length_one = where_set([-x, -y, -z], subtracted, of_length_one);
        }
        let mut normals = [[f64::NAN; 8]; 3];
        for (numbers, to) in of_length_one.into_iter().zip(&mut normals) {
            numbers.store_some(to, 0);
        }
        let unusual = lanes & !ordinary;
        if unusual != 0 {
            let normal = [normal[0].store(), normal[1].store(), normal[2].store()];
            for lane in ones(u32::from(unusual)) {
                let normal = unit(Vec3::new(normal[0][lane], normal[1][lane], normal[2][lane]));
                let normal = if subtracted >> lane & 1 == 1 { -normal } else { normal };
                (0..3).for_each(|axis| normals[axis][lane] = normal[axis]);
            }
        }
        normals
    }
}

impl Bodies<'_> {
    /// The normals, in the frame of the body, at the crossings of lines in that frame with surfaces of a leaf.
    #[inline(always)]
    fn outward_normals<F: Doubles>(
        &self,
        leaf: u32,
        line: &LineLanes<F>,
        t: F,
        surface: F,
        lanes: u8,
    ) -> [F; 3] {
        if let Bodies::Each(bodies) = self
            && let (Some(solids), frames) = leaves_in_lanes(bodies, leaf)
        {
            return normals_of_each(&solids, &frames, line, t, surface);
        }
        let leaf = &self.first().leaves[leaf as usize];
        let p = line.in_frame(&leaf.local_from_body).at(t);
        let outward = match leaf.solid.in_lanes() {
            Some(solid) => solid.normal(p, surface),
            None => normals_one_by_one(leaf, &p, surface, lanes),
        };
        covector(&leaf.local_from_body, outward)
    }
}

#[inline(always)]
fn normals_of_each<F: Doubles>(
    solids: &[InLanes<'_>; 8],
    frames: &[&Affine; 8],
    line: &LineLanes<F>,
    t: F,
    surface: F,
) -> [F; 3] {
    let p = line.in_frames(frames).at(t);
    covector_each(frames, InLanes::normal_each(solids, p, surface))
}

/// The normals at points of a solid that takes one line at a time.
#[inline(always)]
fn normals_one_by_one<F: Doubles>(leaf: &Leaf, p: &[F; 3], surface: F, lanes: u8) -> [F; 3] {
    let (p, surface) = ([p[0].store(), p[1].store(), p[2].store()], surface.store());
    let mut normals = [[0.0; 8]; 3];
    for lane in ones(u32::from(lanes)) {
        let p = Vec3::new(p[0][lane], p[1][lane], p[2][lane]);
        let normal = leaf.solid.normal(p, surface[lane] as u32, NO_PRIMITIVE);
        (0..3).for_each(|axis| normals[axis][lane] = normal[axis]);
    }
    [F::load_some(&normals[0], 0), F::load_some(&normals[1], 0), F::load_some(&normals[2], 0)]
}

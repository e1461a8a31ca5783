//! Solids of curved surfaces.

use shotline::math::{Affine, Vec3};
use shotline::solid::{ParamError, Params};

use super::Writer;
use super::kinds::{Between, Made, Sector, between, in_sector, sector};
use super::shapes::Placed;

/// Geant4 refuses a torus that comes nearer than this to its axis, in millimetres.
const LEAST_HOLE: f64 = 1e-6;

impl Writer<'_> {
    /// A full length along z.
    pub(super) fn tube(&self, rmin: f64, rmax: f64, z: Between, part: Sector) -> Result<Made, ParamError> {
        let element = self.element("tube").length("rmin", rmin).length("rmax", rmax).length("z", z.length());
        Ok(Made::at_height(in_sector(element, part), z.middle()))
    }

    pub(super) fn cut_tube(&self, p: &Params) -> Result<Made, ParamError> {
        let z = between(p)?;
        let element = self.element("cutTube").length("rmin", p.number("rmin")?);
        let element = element.length("rmax", p.number("rmax")?).length("z", z.length());
        let [low, high] = [p.vector("normal0")?, p.vector("normal1")?];
        let element = element.number("lowX", low.x).number("lowY", low.y).number("lowZ", low.z);
        let element = element.number("highX", high.x).number("highY", high.y).number("highZ", high.z);
        Ok(Made::at_height(in_sector(element, sector(p)?), z.middle()))
    }

    /// A full length along z, and the inner and outer radii at both ends.
    pub(super) fn cone(&self, radii: [f64; 4], z: Between, part: Sector) -> Result<Made, ParamError> {
        let mut element = self.element("cone");
        for (key, r) in ["rmin1", "rmax1", "rmin2", "rmax2"].iter().zip(radii) {
            element = element.length(key, r);
        }
        Ok(Made::at_height(in_sector(element.length("z", z.length()), part), z.middle()))
    }

    pub(super) fn sphere(&self, p: &Params) -> Result<Made, ParamError> {
        let element =
            self.element("sphere").length("rmin", p.number("rmin")?).length("rmax", p.number("rmax")?);
        let element =
            element.number("starttheta", p.number("theta0")?).number("deltatheta", p.number("dtheta")?);
        Ok(Made::centred(in_sector(element, sector(p)?)))
    }

    pub(super) fn torus(&self, ring: f64, [rmin, rmax]: [f64; 2], part: Sector) -> Result<Made, ParamError> {
        if (ring - rmax) * self.structure.millimetres < LEAST_HOLE {
            return Ok(Made::Refused(
                "GDML has no torus without a hole around its axis, and Geant4 wants one of 1e-6 mm",
            ));
        }
        let element = self.element("torus").length("rmin", rmin).length("rmax", rmax).length("rtor", ring);
        Ok(Made::centred(in_sector(element, part)))
    }

    /// Half lengths.
    pub(super) fn elliptical_cylinder(&self, p: &Params) -> Result<Made, ParamError> {
        let z = between(p)?;
        let element = self.element("eltube").length("dx", p.number("a")?).length("dy", p.number("b")?);
        Ok(Made::at_height(element.length("dz", z.length() * 0.5).in_millimetres(), z.middle()))
    }

    /// dx and dy are slopes without a unit, and the middle is half way between the ends.
    pub(super) fn elliptical_cone(&self, p: &Params) -> Result<Made, ParamError> {
        let (z, height) = (between(p)?, p.number("height")?);
        let element = self.element("elcone").number("dx", p.number("a")? / height);
        let element = element.number("dy", p.number("b")? / height);
        let element = element.length("zmax", p.number("apex")? - z.middle());
        Ok(Made::at_height(element.length("zcut", z.length() * 0.5).in_millimetres(), z.middle()))
    }

    /// Cuts of 0 on both sides are none.
    pub(super) fn ellipsoid(&self, axes: Vec3, cuts: Option<[f64; 2]>) -> Result<Made, ParamError> {
        let element = self.element("ellipsoid");
        let mut element = element.length("ax", axes.x).length("by", axes.y).length("cz", axes.z);
        if let Some([low, high]) = cuts.filter(|[low, high]| *low > -axes.z || *high < axes.z) {
            element = element.length("zcut1", low.max(-axes.z)).length("zcut2", high.min(axes.z));
        }
        Ok(Made::centred(element.in_millimetres()))
    }

    /// A half length. The upper radius is the greater one, so one that narrows upwards is turned over.
    pub(super) fn paraboloid(&self, radii: [f64; 2], z: Between) -> Result<Made, ParamError> {
        let ([r0, r1], half) = (radii, z.length() * 0.5);
        let up = Affine::translation(Vec3::new(0.0, 0.0, z.middle()));
        let (low, high, place) = match r0 < r1 {
            true => (r0, r1, up),
            false if r0 > r1 => (r1, r0, up.then_after(&Affine::rotation_xyz(Vec3::new(180.0, 0.0, 0.0)))),
            false => return self.tube(0.0, r1, z, [0.0, 360.0]),
        };
        let element = self.element("paraboloid").length("rlo", low).length("rhi", high).length("dz", half);
        Ok(Made::Element(element.in_millimetres(), place))
    }

    /// A full length, with the waist in the middle. Where the ends are not equally far from it, a box cuts them off.
    pub(super) fn hyperboloid(&mut self, radii: [f64; 2], stereo: [f64; 2], z: Between) -> Made {
        let farthest = z.low.abs().max(z.high.abs());
        let is_centred = z.low == -z.high;
        let half = if is_centred { farthest } else { 1.25 * farthest };
        let ([rmin, rmax], [inner, outer]) = (radii, stereo);
        let element = self.element("hype").length("rmin", rmin).length("rmax", rmax);
        let element = element.number("inst", inner).number("outst", outer).length("z", 2.0 * half);
        let element = element.in_millimetres_and_degrees();
        if is_centred {
            return Made::centred(element);
        }
        let whole = self.add_solid(element);
        let widest = 2.5 * libm::hypot(rmax, half * libm::tan(outer.to_radians()));
        let cut = self.solid("box", |element| {
            let element = element.length("x", widest).length("y", widest);
            element.length("z", z.length()).in_millimetres()
        });
        let both = self.solid("intersection", |element| {
            let element = element.reference("first", &whole).reference("second", &cut);
            element.position("position", Vec3::new(0.0, 0.0, z.middle()))
        });
        Made::Added(Placed::centred(both))
    }
}

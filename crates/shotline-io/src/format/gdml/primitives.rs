//! Boxes and the solids of one curved surface. Some lengths are halved on reading, as Geant4 does; which, differs from solid to
//! solid.

use shotline::scene::NodeId;

use super::attributes::Found;
use super::{Element, Module};

impl Module<'_> {
    /// Full lengths.
    pub(super) fn cuboid(&mut self, element: Element) -> Found<NodeId> {
        let [x, y, z] = [self.half(element, "x")?, self.half(element, "y")?, self.half(element, "z")?];
        self.of_kind(element, "box", &[&[-x, -y, -z], &[x, y, z]])
    }

    /// Half of a full length that must be positive.
    pub(super) fn half(&mut self, element: Element, key: &str) -> Found<f64> {
        Ok(self.positive(element, key)? * 0.5)
    }

    /// A full length along z.
    pub(super) fn tube(&mut self, element: Element) -> Found<NodeId> {
        let [rmin, rmax] = self.radii(element, "rmin", "rmax")?;
        let z = self.half(element, "z")?;
        let [phi0, dphi] = self.sector(element, "startphi", "deltaphi")?;
        if rmin == 0.0 && dphi == 360.0 {
            return self.of_kind(element, "cylinder", &[&[rmax], &[-z], &[z]]);
        }
        self.of_kind(element, "tube", &[&[rmin], &[rmax], &[-z], &[z], &[phi0], &[dphi]])
    }

    pub(super) fn cut_tube(&mut self, element: Element) -> Found<NodeId> {
        let [rmin, rmax] = self.radii(element, "rmin", "rmax")?;
        let z = self.half(element, "z")?;
        let [phi0, dphi] = self.sector(element, "startphi", "deltaphi")?;
        let mut normals = [[0.0; 3]; 2];
        for (normal, keys) in normals.iter_mut().zip([["lowX", "lowY", "lowZ"], ["highX", "highY", "highZ"]])
        {
            for (x, key) in normal.iter_mut().zip(keys) {
                *x = self.number_or(element, key, 0.0)?;
            }
        }
        // Geant4 takes normals of length 0 for those of a tube that is not cut.
        for (normal, z) in normals.iter_mut().zip([-1.0, 1.0]) {
            if *normal == [0.0; 3] {
                normal[2] = z;
            }
        }
        let [low, high] = &normals;
        self.of_kind(element, "cut_tube", &[&[rmin], &[rmax], &[-z], &[z], low, high, &[phi0], &[dphi]])
    }

    pub(super) fn cone(&mut self, element: Element) -> Found<NodeId> {
        let z = self.half(element, "z")?;
        let [phi0, dphi] = self.sector(element, "startphi", "deltaphi")?;
        let mut r = [0.0; 4];
        for (r, key) in r.iter_mut().zip(["rmin1", "rmax1", "rmin2", "rmax2"]) {
            *r = self.radius(element, key)?;
        }
        if r[1] == 0.0 && r[3] == 0.0 {
            let message = "\"rmax1\" and \"rmax2\" are 0: the cone has no volume";
            return Err(self.report(element, Some("rmax1"), message, "give it a radius"));
        }
        let is_solid = r[0] == 0.0 && r[2] == 0.0 && dphi == 360.0;
        match is_solid {
            true if r[1] == r[3] => self.of_kind(element, "cylinder", &[&[r[1]], &[-z], &[z]]),
            true => self.of_kind(element, "cone", &[&[r[1]], &[r[3]], &[-z], &[z]]),
            false => {
                let [[rmin0, rmax0], [rmin1, rmax1]] = [[r[0], r[1]], [r[2], r[3]]];
                let values: &[&[f64]] =
                    &[&[rmin0], &[rmax0], &[rmin1], &[rmax1], &[-z], &[z], &[phi0], &[dphi]];
                self.of_kind(element, "cone_section", values)
            }
        }
    }

    pub(super) fn orb(&mut self, element: Element) -> Found<NodeId> {
        let r = self.positive(element, "r")?;
        self.of_kind(element, "sphere", &[&[r]])
    }

    pub(super) fn sphere(&mut self, element: Element) -> Found<NodeId> {
        let [rmin, rmax] = self.radii(element, "rmin", "rmax")?;
        let [phi0, dphi] = self.sector(element, "startphi", "deltaphi")?;
        let theta0 = self.angle_or(element, "starttheta", 0.0)?;
        if !(0.0..180.0).contains(&theta0) {
            let message = format!("\"starttheta\" is {theta0} degrees, but must be from 0 to below 180");
            return Err(self.report(element, Some("starttheta"), message, "correct the angle or its unit"));
        }
        // Geant4 cuts the angle off at the pole, and takes up to 1e-9 less than it for the pole.
        let most = 180.0 - theta0;
        let dtheta = self.angle(element, "deltatheta")?;
        if dtheta <= 0.0 {
            let message = format!("\"deltatheta\" is {dtheta} degrees, but must be positive");
            return Err(self.report(element, Some("deltatheta"), message, "correct the angle"));
        }
        let dtheta = if dtheta >= most - 3e-8 { most } else { dtheta };
        if rmin == 0.0 && dphi == 360.0 && dtheta == 180.0 {
            return self.of_kind(element, "sphere", &[&[rmax]]);
        }
        self.of_kind(element, "sphere_section", &[&[rmin], &[rmax], &[phi0], &[dphi], &[theta0], &[dtheta]])
    }

    pub(super) fn torus(&mut self, element: Element) -> Found<NodeId> {
        let [rmin, rmax] = self.radii(element, "rmin", "rmax")?;
        let rtor = self.positive(element, "rtor")?;
        let [phi0, dphi] = self.sector(element, "startphi", "deltaphi")?;
        if rmin == 0.0 && dphi == 360.0 {
            return self.of_kind(element, "torus", &[&[rtor], &[rmax]]);
        }
        self.of_kind(element, "torus_section", &[&[rtor], &[rmin], &[rmax], &[phi0], &[dphi]])
    }

    /// Half lengths.
    pub(super) fn elliptical_tube(&mut self, element: Element) -> Found<NodeId> {
        let [a, b] = [self.positive(element, "dx")?, self.positive(element, "dy")?];
        let z = self.positive(element, "dz")?;
        if a == b {
            return self.of_kind(element, "cylinder", &[&[a], &[-z], &[z]]);
        }
        self.of_kind(element, "elliptical_cylinder", &[&[a], &[b], &[-z], &[z]])
    }

    /// The cone `(x / dx)^2 + (y / dy)^2 = (zmax - z)^2` from `-zcut` to `zcut`; dx and dy are slopes without a unit.
    pub(super) fn elliptical_cone(&mut self, element: Element) -> Found<NodeId> {
        let [dx, dy] = [self.number(element, "dx")?, self.number(element, "dy")?];
        let [apex, cut] = [self.positive(element, "zmax")?, self.positive(element, "zcut")?];
        // Geant4 cuts no further than at the apex.
        let cut = cut.min(apex);
        self.of_kind(element, "elliptical_cone", &[&[dx], &[dy], &[1.0], &[apex], &[-cut], &[cut]])
    }

    /// Two cuts of 0 are none.
    pub(super) fn ellipsoid(&mut self, element: Element) -> Found<NodeId> {
        let [a, b] = [self.positive(element, "ax")?, self.positive(element, "by")?];
        let c = self.positive(element, "cz")?;
        let [low, high] = [self.length_or_zero(element, "zcut1")?, self.length_or_zero(element, "zcut2")?];
        let [low, high] = if [low, high] == [0.0; 2] { [-c, c] } else { [low.max(-c), high.min(c)] };
        if low >= high {
            let message = "the cuts leave nothing of the ellipsoid";
            return Err(self.report(element, Some("zcut2"), message, "\"zcut1\" must be below \"zcut2\""));
        }
        if [low, high] == [-c, c] {
            return self.of_kind(element, "ellipsoid", &[&[a, b, c]]);
        }
        self.of_kind(element, "ellipsoid_section", &[&[a, b, c], &[low], &[high]])
    }

    /// A half length.
    pub(super) fn paraboloid(&mut self, element: Element) -> Found<NodeId> {
        let [low, high] = [self.radius(element, "rlo")?, self.positive(element, "rhi")?];
        let z = self.positive(element, "dz")?;
        self.of_kind(element, "paraboloid_section", &[&[low], &[high], &[-z], &[z]])
    }

    /// A full length. Geant4 takes the tangents of the stereo angles, which files without a unit give in radians beyond a turn.
    pub(super) fn hyperboloid(&mut self, element: Element) -> Found<NodeId> {
        let [rmin, rmax] = self.radii(element, "rmin", "rmax")?;
        let [inner, outer] = [self.angle_or(element, "inst", 0.0)?, self.angle_or(element, "outst", 0.0)?];
        let z = self.half(element, "z")?;
        let [inner, outer] = [inner, outer].map(|stereo| {
            let turned = stereo.abs() % 180.0;
            turned.min(180.0 - turned)
        });
        let values: &[&[f64]] = &[&[rmin], &[rmax], &[inner], &[outer], &[-z], &[z]];
        self.of_kind(element, "hyperboloid_shell", values)
    }
}

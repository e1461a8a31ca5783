//! Kinds of solids to elements of GDML, with the lengths halved or not as Geant4 wants them.

use shotline::math::{Affine, Vec3};
use shotline::solid::{Kind, ParamError, Params};

use super::Writer;
use super::report::Reported;
use super::shapes::Placed;
use super::xml::Xml;

/// What a solid becomes.
pub(super) enum Made {
    /// An element, and where its solid is.
    Element(Xml, Affine),
    /// A solid that has been added.
    Added(Placed),
    /// Why GDML cannot hold it.
    Refused(&'static str),
}

impl Made {
    pub(super) fn centred(element: Xml) -> Made {
        Made::Element(element, Affine::IDENTITY)
    }

    pub(super) fn at_height(element: Xml, z: f64) -> Made {
        Made::Element(element, Affine::translation(Vec3::new(0.0, 0.0, z)))
    }
}

impl Writer<'_> {
    /// The solid of a kind.
    pub(super) fn kind(&mut self, kind: &Kind, params: &Params) -> Result<Placed, Reported> {
        let made = kind.build(params).and_then(|_| self.made(kind, params));
        match made {
            Ok(Made::Element(element, place)) => Ok(Placed { solid: self.add_solid(element), place }),
            Ok(Made::Added(placed)) => Ok(placed),
            Ok(Made::Refused(why)) => Err(self.refuse(&format!("its {}: {why}", kind.name))),
            Err(error) => Err(self.refuse(&format!("its {}: {} {}", kind.name, error.param, error.why))),
        }
    }

    fn made(&mut self, kind: &Kind, p: &Params) -> Result<Made, ParamError> {
        match kind.name {
            "box" => self.cuboid(p),
            "sphere" => {
                Ok(Made::centred(self.element("orb").length("r", p.number("radius")?).in_millimetres()))
            }
            "ellipsoid" => self.ellipsoid(p.vector("semi_axes")?, None),
            "ellipsoid_section" => {
                self.ellipsoid(p.vector("semi_axes")?, Some([p.number("z0")?, p.number("z1")?]))
            }
            "cylinder" => self.tube(0.0, p.number("radius")?, between(p)?, WHOLE),
            "tube" => self.tube(p.number("rmin")?, p.number("rmax")?, between(p)?, sector(p)?),
            "cut_tube" => self.cut_tube(p),
            "cone" => self.cone([0.0, p.number("r0")?, 0.0, p.number("r1")?], between(p)?, WHOLE),
            "cone_section" => {
                let [rmin0, rmax0] = [p.number("rmin0")?, p.number("rmax0")?];
                let [rmin1, rmax1] = [p.number("rmin1")?, p.number("rmax1")?];
                self.cone([rmin0, rmax0, rmin1, rmax1], between(p)?, sector(p)?)
            }
            "sphere_section" => self.sphere(p),
            "torus" => self.torus(p.number("R")?, [0.0, p.number("r")?], WHOLE),
            "torus_section" => self.torus(p.number("R")?, [p.number("rmin")?, p.number("rmax")?], sector(p)?),
            "elliptical_cylinder" => self.elliptical_cylinder(p),
            "elliptical_cone" => self.elliptical_cone(p),
            "paraboloid" => self.paraboloid([0.0, p.number("radius")?], between(p)?),
            "paraboloid_section" => self.paraboloid([p.number("r0")?, p.number("r1")?], between(p)?),
            "hyperboloid" => {
                let (a, c) = (p.number("a")?, p.number("c")?);
                let stereo = libm::atan(a / c).to_degrees();
                Ok(self.hyperboloid([0.0, a], [0.0, stereo], between(p)?))
            }
            "hyperboloid_shell" => {
                let radii = [p.number("rmin")?, p.number("rmax")?];
                let stereo = [p.number("stereo_min")?, p.number("stereo_max")?];
                Ok(self.hyperboloid(radii, stereo, between(p)?))
            }
            "revolved" => self.revolved(p, "genericPolycone"),
            "generic_polyhedra" => self.revolved(p, "genericPolyhedra"),
            "polycone" => self.planes(p, "polycone"),
            "polyhedra" => self.planes(p, "polyhedra"),
            "extruded" => self.extruded(p),
            "tetrahedron" => self.tetrahedron(p),
            "trapezoid" => self.trapezoid(p),
            "twisted_tube" => self.twisted_tube(p),
            "twisted_trapezoid" => self.twisted_trapezoid(p),
            "halfspace" => Ok(Made::Refused("GDML has no half-space; use a box that is large enough")),
            "quadric" => Ok(Made::Refused("GDML has no general quadric")),
            "hyperboloid2" => Ok(Made::Refused("GDML has no hyperboloid of two sheets")),
            _ => Ok(Made::Refused("GDML has no such solid")),
        }
    }

    fn cuboid(&self, p: &Params) -> Result<Made, ParamError> {
        let (min, max) = (p.vector("min")?, p.vector("max")?);
        let size = max - min;
        let element = self.element("box").length("x", size.x).length("y", size.y).length("z", size.z);
        Ok(Made::Element(element.in_millimetres(), Affine::translation(min * 0.5 + max * 0.5)))
    }
}

/// From where to where a solid reaches along z.
#[derive(Clone, Copy)]
pub(super) struct Between {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Between {
    pub(super) fn middle(&self) -> f64 {
        self.low * 0.5 + self.high * 0.5
    }

    pub(super) fn length(&self) -> f64 {
        self.high - self.low
    }
}

pub(super) fn between(p: &Params) -> Result<Between, ParamError> {
    Ok(Between { low: p.number("z0")?, high: p.number("z1")? })
}

/// The angles in degrees where a part begins and that it takes.
pub(super) type Sector = [f64; 2];

const WHOLE: Sector = [0.0, 360.0];

pub(super) fn sector(p: &Params) -> Result<Sector, ParamError> {
    Ok([p.number("phi0")?, p.number("dphi")?])
}

/// An element with the angles of a part, and the units.
pub(super) fn in_sector(element: Xml, [phi0, dphi]: Sector) -> Xml {
    element.number("startphi", phi0).number("deltaphi", dphi).in_millimetres_and_degrees()
}

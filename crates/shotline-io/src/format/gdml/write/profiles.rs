//! Solids given by lists of points or planes.

use shotline::solid::{ParamError, Params};

use super::Writer;
use super::kinds::{Made, in_sector, sector};
use super::xml::Xml;

impl Writer<'_> {
    /// A polygon that is turned about the axis, roundly or in flat sides.
    pub(super) fn revolved(&self, p: &Params, tag: &'static str) -> Result<Made, ParamError> {
        let mut element = self.with_sides(p, tag)?;
        for [r, z] in &p.rows::<2>("points")?.rows {
            element.add(element.inner("rzpoint").length("r", *r).length("z", *z));
        }
        Ok(Made::centred(in_sector(element, sector(p)?)))
    }

    /// Radii at planes across the axis.
    pub(super) fn planes(&self, p: &Params, tag: &'static str) -> Result<Made, ParamError> {
        let mut element = self.with_sides(p, tag)?;
        for [z, rmin, rmax] in &p.rows::<3>("planes")?.rows {
            element.add(element.inner("zplane").length("z", *z).length("rmin", *rmin).length("rmax", *rmax));
        }
        Ok(Made::centred(in_sector(element, sector(p)?)))
    }

    fn with_sides(&self, p: &Params, tag: &'static str) -> Result<Xml, ParamError> {
        let element = self.element(tag);
        match tag {
            "polyhedra" | "genericPolyhedra" => Ok(element.number("numsides", p.number("sides")?)),
            _ => Ok(element),
        }
    }

    pub(super) fn extruded(&self, p: &Params) -> Result<Made, ParamError> {
        let mut element = self.element("xtru").in_millimetres();
        for [x, y] in &p.rows::<2>("polygon")?.rows {
            element.add(element.inner("twoDimVertex").length("x", *x).length("y", *y));
        }
        for (order, [z, x, y, scale]) in p.rows::<4>("sections")?.rows.iter().enumerate() {
            let section = element.inner("section").number("zOrder", order as f64).length("zPosition", *z);
            let section = section.length("xOffset", *x).length("yOffset", *y);
            element.add(section.number("scalingFactor", *scale));
        }
        Ok(Made::centred(element))
    }
}

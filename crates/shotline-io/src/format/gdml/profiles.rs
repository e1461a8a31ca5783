//! Solids given by lists of points or planes: revolved and extruded profiles.

use shotline::scene::NodeId;

use super::attributes::Found;
use super::units::Measure;
use super::{Element, Module, elements, tag};

impl Module<'_> {
    pub(super) fn polycone(&mut self, element: Element) -> Found<NodeId> {
        let planes = self.rows(element, "zplane", &["z", "rmin", "rmax"], 2)?;
        let [phi0, dphi] = self.turn(element)?;
        self.of_kind(element, "polycone", &[&planes, &[phi0], &[dphi]])
    }

    pub(super) fn generic_polycone(&mut self, element: Element) -> Found<NodeId> {
        let points = self.rows(element, "rzpoint", &["r", "z"], 3)?;
        let [phi0, dphi] = self.turn(element)?;
        self.of_kind(element, "revolved", &[&points, &[phi0], &[dphi]])
    }

    pub(super) fn polyhedra(&mut self, element: Element) -> Found<NodeId> {
        let planes = self.rows(element, "zplane", &["z", "rmin", "rmax"], 2)?;
        let sides = self.count(element, "numsides")? as f64;
        let [phi0, dphi] = self.turn(element)?;
        self.of_kind(element, "polyhedra", &[&planes, &[sides], &[phi0], &[dphi]])
    }

    pub(super) fn generic_polyhedra(&mut self, element: Element) -> Found<NodeId> {
        let points = self.rows(element, "rzpoint", &["r", "z"], 3)?;
        let sides = self.count(element, "numsides")? as f64;
        let [phi0, dphi] = self.turn(element)?;
        self.of_kind(element, "generic_polyhedra", &[&points, &[sides], &[phi0], &[dphi]])
    }

    /// The sections are in the order of the file; Geant4 does not read `zOrder`.
    pub(super) fn extruded(&mut self, element: Element) -> Found<NodeId> {
        let polygon = self.rows(element, "twoDimVertex", &["x", "y"], 3)?;
        let mut sections = self.rows(element, "section", &["zPosition", "xOffset", "yOffset"], 2)?;
        let mut scaled = Vec::with_capacity(sections.len() / 3 * 4);
        for (row, section) in sections.chunks_exact(3).zip(children(element, "section")) {
            scaled.extend_from_slice(row);
            scaled.push(self.number_or(section, "scalingFactor", 1.0)?);
        }
        sections = scaled;
        self.of_kind(element, "extruded", &[&polygon, &sections])
    }

    /// Where a revolved solid begins and how far it turns; Geant4 takes an angle of 0 or less for a full turn.
    fn turn(&mut self, element: Element) -> Found<[f64; 2]> {
        let dphi = self.angle_or(element, "deltaphi", 0.0)?;
        if dphi <= 0.0 || dphi >= 360.0 - 3e-8 {
            return Ok([self.angle_or(element, "startphi", 0.0)?, 360.0]);
        }
        Ok([self.angle_or(element, "startphi", 0.0)?, dphi])
    }

    /// The lengths of the attributes of all children of a name, row by row; the unit is that of the element.
    fn rows(&mut self, element: Element, name: &str, keys: &[&str], least: usize) -> Found<Vec<f64>> {
        let unit = self.factor(element, "lunit", Measure::Length)?;
        let mut rows = Vec::new();
        for child in children(element, name) {
            for key in keys {
                rows.push(self.number_or(child, key, 0.0)? * unit);
            }
        }
        if rows.len() < least * keys.len() {
            let message = format!(
                "<{}> has {} of the {least} <{name}> it needs",
                tag(element),
                rows.len() / keys.len()
            );
            return Err(self.report(element, None, message, format!("add <{name}> elements")));
        }
        Ok(rows)
    }
}

fn children<'a>(element: Element<'a>, name: &'a str) -> impl Iterator<Item = Element<'a>> {
    elements(element).filter(move |child| tag(*child) == name)
}

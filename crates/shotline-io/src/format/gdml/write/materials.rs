//! Materials: a density, and elements by their shares of the mass.

use shotline::scene::Material;

use super::super::chemical_elements::{Chemical, find};
use super::super::geant4_materials;
use super::Writer;
use super::names::as_xml_name;
use super::xml::Xml;

/// The density of the universe, which Geant4 takes for that of vacuum, in g/cm^3.
const VACUUM: f64 = 1e-25;

/// What Geant4 takes vacuum for.
const HYDROGEN: Chemical = Chemical { number: 1, mass: 1.008 };

impl<'s> Writer<'s> {
    /// Writes the materials of the scene, after the elements that they are made of.
    pub(super) fn write_materials(&mut self) {
        let scene = self.scene;
        let mut elements: Vec<(&str, String)> = Vec::new();
        for (name, material) in &scene.materials {
            if is_of_geant4(name, material) {
                self.materials.insert(Some(name), name.clone());
                continue;
            }
            for (part, _) in material.composition.iter().filter(|_| !is_pure(name, material)) {
                if !geant4_materials::is_name(part) && !elements.iter().any(|(known, _)| known == part) {
                    let written = self.chemical_element(part);
                    elements.push((part, written));
                }
            }
        }
        for (name, material) in
            scene.materials.iter().filter(|(name, material)| !is_of_geant4(name, material))
        {
            let written = self.xml_name(name);
            let written = self.material_names.free(&written);
            self.add_material(&written, name, material, &elements);
            self.materials.insert(Some(name), written);
        }
    }

    /// Writes an element, and returns its name, which no material has.
    fn chemical_element(&mut self, name: &str) -> String {
        let wanted = as_xml_name(name);
        let free = self.names.free(&wanted);
        let written = if free == wanted { free } else { self.names.free(&format!("{wanted}_element")) };
        let chemical = self.chemical(name);
        let element = self.element("element").text("name", &written).number("Z", f64::from(chemical.number));
        with_atom(element, &chemical).write(&mut self.materials_text);
        written
    }

    /// The atomic number and the mass of an element; hydrogen's for one that is not known, with a note.
    fn chemical(&mut self, name: &str) -> Chemical {
        find(name).unwrap_or_else(|| {
            let what = "elements whose atomic numbers are not known were written as hydrogen; correct the elements and materials";
            self.report.lose(what, name);
            HYDROGEN
        })
    }

    fn add_material(&mut self, written: &str, name: &str, material: &Material, elements: &[(&str, String)]) {
        let mut element = self.element("material").text("name", written);
        if material.density.is_none() {
            self.report.lose("materials without a density were written with that of vacuum", name);
        }
        let density =
            element.inner("D").number("value", material.density.unwrap_or(VACUUM)).text("unit", "g/cm3");
        let sum: f64 = material.composition.iter().map(|(_, share)| share).sum();
        if is_pure(name, material) || sum.is_nan() || sum <= 0.0 {
            let is_vacuum = material.density.is_some_and(|density| density <= VACUUM);
            let chemical = if is_vacuum { HYDROGEN } else { self.chemical(name) };
            element = element.number("Z", f64::from(chemical.number)).with(density);
            element = with_atom(element, &chemical);
        } else {
            element.add(density);
            for (part, share) in material.composition.iter().filter(|(_, share)| *share > 0.0) {
                let known = elements.iter().find(|(known, _)| known == part);
                let reference = known.map_or(part.as_str(), |(_, written)| written);
                element.add(element.inner("fraction").number("n", share / sum).text("ref", reference));
            }
        }
        element.write(&mut self.materials_text);
    }

    /// The name in the file of the material of an object; one that is not defined is written as vacuum.
    pub(super) fn material(&mut self, name: Option<&'s str>) -> String {
        let Some(name) = name else {
            let object = self.object.clone();
            self.report.lose("objects without a material were written with vacuum", &object);
            return self.vacuum();
        };
        if let Some(known) = self.materials.get(&Some(name)) {
            return known.clone();
        }
        let wanted = self.xml_name(name);
        let written = self.material_names.free(&wanted);
        self.add_material(&written, name, &Material::default(), &[]);
        self.materials.insert(Some(name), written.clone());
        written
    }

    /// The material of empty space.
    pub(super) fn vacuum(&mut self) -> String {
        if let Some(known) = self.materials.get(&None) {
            return known.clone();
        }
        let name = self.names.free("Vacuum");
        let element = self.element("material").text("name", &name).number("Z", 1.0).text("state", "gas");
        let state =
            |element: &Xml, tag, value, unit| element.inner(tag).number("value", value).text("unit", unit);
        // As Geant4's G4_Galactic.
        let [temperature, pressure] =
            [state(&element, "T", 2.73, "K"), state(&element, "P", 3e-18, "pascal")];
        let density = state(&element, "D", VACUUM, "g/cm3");
        let element = element.with(temperature).with(pressure).with(density);
        with_atom(element, &HYDROGEN).write(&mut self.materials_text);
        self.materials.insert(None, name.clone());
        name
    }
}

/// Whether a material is one that Geant4 defines, of which the scene says nothing else.
fn is_of_geant4(name: &str, material: &Material) -> bool {
    let is_unknown = material.density.is_none() && material.composition.is_empty();
    let is_known = geant4_materials::find(name)
        .is_some_and(|known| known.density == material.density && known.composition == material.composition);
    geant4_materials::is_name(name) && (is_unknown || is_known)
}

/// Whether a material is made of the one element of its own name.
fn is_pure(name: &str, material: &Material) -> bool {
    matches!(&material.composition[..], [(part, _)] if part == name)
}

fn with_atom(element: Xml, chemical: &Chemical) -> Xml {
    let atom = element.inner("atom").number("value", chemical.mass).text("unit", "g/mole");
    element.with(atom)
}

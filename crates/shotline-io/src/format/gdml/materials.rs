//! The section `materials`: densities, and the shares of the elements in the mass of each material.

use std::collections::HashMap;

use shotline::scene::Material;

use super::attributes::Found;
use super::units::Measure;
use super::{Element, Module, elements, geant4_materials, tag};
use crate::note::{Effect, Note};
use crate::suggest;

/// The isotopes, elements and materials of a file.
#[derive(Default)]
pub(super) struct Substances {
    /// The masses of a mole of each isotope and element, in grams.
    masses: HashMap<String, f64>,
    /// The shares of elements in each element and material.
    shares: HashMap<String, Vec<(String, f64)>>,
    /// The names of materials in the scene, by their names in the file.
    materials: HashMap<String, String>,
}

impl Module<'_> {
    /// Reads the materials; one that is wrong is reported, and the others are read.
    pub(super) fn materials(&mut self, section: Element) {
        for element in elements(section) {
            self.substance(element);
        }
    }

    fn substance(&mut self, element: Element) {
        // What is wrong has been reported.
        let _ = match tag(element) {
            "isotope" => self.isotope(element),
            "element" => self.element(element),
            "material" => self.material(element),
            "define" => {
                self.define(element);
                Ok(())
            }
            "loop" => self.repeat(element, &mut |module, child| module.substance(child)),
            other => {
                let message = format!("<{other}> has no meaning in <materials>");
                Err(self.report(element, None, message, "it has isotopes, elements and materials"))
            }
        };
    }

    fn isotope(&mut self, element: Element) -> Found<()> {
        let (name, mass) = (self.name(element)?, self.atom(element)?);
        self.substances.masses.insert(name, mass.unwrap_or(0.0));
        Ok(())
    }

    /// An element has a mass, or shares of isotopes by number.
    fn element(&mut self, element: Element) -> Found<()> {
        let name = self.name(element)?;
        let mut mass = self.atom(element)?;
        for child in elements(element).filter(|child| tag(*child) == "fraction") {
            let isotope = self.reference(child, "ref")?;
            let share = self.number(child, "n")?;
            let Some(of_isotope) = self.substances.masses.get(&isotope).copied() else {
                let known: Vec<_> = self.substances.masses.keys().map(String::as_str).collect();
                let help = suggest::hint(&isotope, &known);
                let message = format!("there is no isotope '{isotope}' before this line");
                return Err(self.report(child, Some("ref"), message, help));
            };
            mass = Some(mass.unwrap_or(0.0) + share * of_isotope);
        }
        self.substances.masses.insert(name.clone(), mass.unwrap_or(0.0));
        self.substances.shares.insert(name.clone(), vec![(name, 1.0)]);
        Ok(())
    }

    /// The mass of a mole in grams.
    fn atom(&mut self, element: Element) -> Found<Option<f64>> {
        match elements(element).find(|child| tag(*child) == "atom") {
            Some(atom) => Ok(Some(self.number(atom, "value")?)),
            None => Ok(None),
        }
    }

    fn material(&mut self, element: Element) -> Found<()> {
        let name = self.name(element)?;
        let density = self.density(element)?;
        let mut shares: Vec<(String, f64)> = Vec::new();
        // The sum of the fractions by mass; infinite where there are others.
        let mut by_mass = 0.0;
        for child in elements(element) {
            let is_by_number = match tag(child) {
                "fraction" => false,
                "composite" => true,
                _ => continue,
            };
            let of = self.reference(child, "ref")?;
            let mut share = self.number(child, "n")?;
            if share < 0.0 {
                let message = format!("the share of '{of}' is {share}");
                return Err(self.report(child, Some("n"), message, "it must not be negative"));
            }
            by_mass += if is_by_number { f64::INFINITY } else { share };
            if is_by_number {
                let mass = self.substances.masses.get(&of).copied();
                share *= mass.or_else(|| geant4_materials::mass(&of)).unwrap_or(0.0);
            }
            for (part, of_part) in self.shares_of(child, &of)? {
                match shares.iter_mut().find(|(known, _)| *known == part) {
                    Some((_, sum)) => *sum += share * of_part,
                    None => shares.push((part, share * of_part)),
                }
            }
        }
        if shares.is_empty() && element.has_attribute("Z") {
            shares.push((name.clone(), 1.0));
        }
        if by_mass.is_finite() && by_mass > 0.0 && (by_mass - 1.0_f64).abs() > 0.01 {
            let text =
                format!("the fractions of the material '{name}' sum to {by_mass}, and were scaled to 1");
            self.reader.notes.push(Note::new("fractions_scaled", Effect::Changed, 1, text));
        }
        let sum: f64 = shares.iter().map(|(_, share)| share).sum();
        if sum > 0.0 {
            shares.iter_mut().for_each(|(_, share)| *share = (*share / sum).clamp(0.0, 1.0));
        }
        self.substances.shares.insert(name.clone(), shares.clone());
        self.add_material(name, Material { density, composition: shares, ..Material::default() });
        Ok(())
    }

    /// The density in g/cm^3, if it is given.
    fn density(&mut self, element: Element) -> Found<Option<f64>> {
        for child in elements(element) {
            match tag(child) {
                "D" => {
                    let factor = self.factor(child, "unit", Measure::Density)?;
                    let density = self.number(child, "value")? * factor;
                    if density < 0.0 {
                        let message = format!("the density is {density} g/cm3");
                        return Err(self.report(child, Some("value"), message, "it must not be negative"));
                    }
                    return Ok(Some(density));
                }
                "Dref" => {
                    let name = self.reference(child, "ref")?;
                    return self.evaluate(child, "ref", &name).map(Some);
                }
                _ => {}
            }
        }
        Ok(None)
    }

    /// The shares of elements in an element or material.
    fn shares_of(&mut self, element: Element, name: &str) -> Found<Vec<(String, f64)>> {
        let known = &self.substances.shares;
        if let Some(shares) = known.get(name).or_else(|| known.get(without_pointer(name))) {
            return Ok(shares.clone());
        }
        if let Some(material) = geant4_materials::find(name) {
            return Ok(material.composition);
        }
        if geant4_materials::is_name(name) {
            return Ok(vec![(name.to_owned(), 1.0)]);
        }
        let help = suggest::hint(name, &known.keys().map(String::as_str).collect::<Vec<_>>());
        let message = format!("there is no element or material '{name}' before this line");
        Err(self.report(element, Some("ref"), message, help))
    }

    /// Adds a material under its name, or under a new one if another file has a different material of that name.
    fn add_material(&mut self, name: String, material: Material) {
        let scene = &mut self.reader.scene;
        let mut free = name.clone();
        let mut number = 1;
        while let Some((_, known)) = scene.materials.iter().find(|(known, _)| *known == free) {
            if *known == material {
                break;
            }
            number += 1;
            free = format!("{name} ({number})");
        }
        if !scene.materials.iter().any(|(known, _)| *known == free) {
            scene.materials.push((free.clone(), material));
        }
        self.substances.materials.entry(name).or_insert(free);
    }

    /// The name in the scene of the material that an element refers to.
    pub(super) fn material_of(&mut self, element: Element) -> Found<String> {
        let name = self.reference(element, "ref")?;
        let known = &self.substances.materials;
        if let Some(found) = known.get(&name).or_else(|| known.get(without_pointer(&name))) {
            return Ok(found.clone());
        }
        let stripped = known.iter().filter(|(known, _)| without_pointer(known) == without_pointer(&name));
        if let Some((_, found)) = stripped.min() {
            return Ok(found.clone());
        }
        if let Some(material) = geant4_materials::find(&name) {
            self.add_material(name.clone(), material);
            return Ok(name);
        }
        if geant4_materials::is_name(&name) {
            let text = format!(
                "the material '{name}' is not among those that Geant4 defines itself: its density and elements are not known"
            );
            self.reader.notes.push(Note::new("unknown_materials", Effect::Changed, 1, text));
            self.add_material(name.clone(), Material::default());
            return Ok(name);
        }
        let help = suggest::hint(&name, &known.keys().map(String::as_str).collect::<Vec<_>>());
        let message = format!("there is no material '{name}'");
        Err(self.report(element, Some("ref"), message, help))
    }
}

/// A name without the address that programs append to make it unique, as in `Air0x1f3a`.
fn without_pointer(name: &str) -> &str {
    name.find("0x").map_or(name, |at| &name[..at])
}

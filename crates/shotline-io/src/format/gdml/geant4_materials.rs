//! The materials that Geant4 defines itself, which files name without describing them.

use shotline::scene::Material;

use super::chemical_elements;

/// What their names begin with.
const PREFIX: &str = "G4_";

/// Name, density in g/cm^3, and shares of the mass, separated by tabs.
const TABLE: &str = include_str!("geant4_materials.tsv");

/// Whether a name is one that Geant4 uses for its own.
pub(super) fn is_name(name: &str) -> bool {
    name.starts_with(PREFIX)
}

/// The material of a name, if Geant4 has it.
pub(super) fn find(name: &str) -> Option<Material> {
    if !is_name(name) {
        return None;
    }
    TABLE.lines().find_map(|line| {
        let mut cells = line.split('\t');
        if cells.next() != Some(name) {
            return None;
        }
        let density = cells.next()?.parse().ok()?;
        let share = |text: &str| {
            let (element, share) = text.split_once('=')?;
            Some((element.to_owned(), share.parse().ok()?))
        };
        let composition = cells.next()?.split(' ').map(share).collect::<Option<_>>()?;
        Some(Material { density: Some(density), composition, ..Material::default() })
    })
}

/// The mass of a mole of one that is a single element, in grams.
pub(super) fn mass(name: &str) -> Option<f64> {
    match &find(name)?.composition[..] {
        [(element, _)] => chemical_elements::find(element).map(|chemical| chemical.mass),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_a_material_of_known_elements() {
        let lines = TABLE.lines().filter(|line| !line.starts_with('#'));
        let mut count = 0;
        for name in lines.filter_map(|line| line.split('\t').next()) {
            let material = find(name).unwrap_or_else(|| panic!("{name}"));
            let sum: f64 = material.composition.iter().map(|(_, share)| share).sum();
            assert!((sum - 1.0).abs() < 1e-7, "{name}: {sum}");
            assert!(material.density.is_some_and(|density| density > 0.0), "{name}");
            assert!(
                material.composition.iter().all(|(part, _)| chemical_elements::find(part).is_some()),
                "{name}"
            );
            count += 1;
        }
        assert_eq!(count, 309);
    }

    #[test]
    fn water_air_and_lead_are_known() {
        let density = |name: &str| find(name).and_then(|material| material.density);
        assert_eq!(
            ["G4_WATER", "G4_Pb", "G4_Nothing", "Water"].map(density),
            [Some(1.0), Some(11.35), None, None]
        );
        assert_eq!(["G4_Si", "G4_WATER"].map(mass), [Some(28.085), None]);
    }
}

//! MTL: the materials of OBJ files. Of each its colour and its highlight are read.

use std::fmt::Write;

use shotline::scene::Material;

use crate::bytes::{Cursor, Word, text_start, without_comment, words};
use crate::diagnostic::RawDiagnostic;

/// The first line of the files of materials that shotline writes.
pub(crate) const MATERIALS_MARK: &str = "# materials, written by shotline\n";

/// The text of a file of materials; `None` if none of them has a colour or a highlight.
pub(crate) fn write_materials(materials: &[(String, &Material)]) -> Option<String> {
    let mut out = String::from(MATERIALS_MARK);
    let mut has_look = false;
    for (name, Material { color, specular, shininess, .. }) in materials {
        has_look |= color.is_some() || specular.is_some() || shininess.is_some();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "newmtl {name}");
        if let Some([red, green, blue]) = color {
            let _ = writeln!(out, "Kd {red:?} {green:?} {blue:?}");
        }
        if let Some(strength) = specular {
            let _ = writeln!(out, "Ks {strength:?} {strength:?} {strength:?}");
        }
        if let Some(exponent) = shininess {
            let _ = writeln!(out, "Ns {exponent:?}");
        }
    }
    has_look.then_some(out)
}

/// The materials of a file, in its order. Lines that say nothing of colour or highlight, such as textures, are passed over.
///
/// # Errors
/// A word that is not a number.
pub(crate) fn read_materials(bytes: &[u8]) -> Result<Vec<(String, Material)>, RawDiagnostic> {
    let mut materials: Vec<(String, Material)> = Vec::new();
    let mut cursor = Cursor::new(bytes, text_start(bytes)?);
    while let Some((start, line)) = cursor.line() {
        let line: Vec<Word> = words(without_comment(line), start).collect();
        let Some((keyword, values)) = line.split_first() else { continue };
        if keyword.bytes == b"newmtl" {
            let name = values.iter().map(Word::text).collect::<Vec<_>>().join(" ");
            materials.push((name, Material::default()));
        }
        let Some((_, material)) = materials.last_mut() else { continue };
        match keyword.bytes {
            b"Kd" => material.color = color(values)?,
            b"Ks" => material.specular = color(values)?.map(|[r, g, b]| r.max(g).max(b)),
            b"Ns" => {
                let number = values.first().map(|word| word.finite()).transpose()?;
                material.shininess = number.filter(|exponent| *exponent > 0.0);
            }
            _ => {}
        }
    }
    Ok(materials)
}

/// A colour from one number, which is grey, or from three; `None` for spectra and CIE colours.
fn color(values: &[Word]) -> Result<Option<[f64; 3]>, RawDiagnostic> {
    if values.first().is_none_or(|word| matches!(word.bytes, b"spectral" | b"xyz")) {
        return Ok(None);
    }
    let mut numbers = [0.0; 3];
    for (i, number) in numbers.iter_mut().enumerate() {
        *number = values.get(i).unwrap_or(&values[0]).finite()?.clamp(0.0, 1.0);
    }
    Ok(Some(numbers))
}

//! Materials, cameras and lights.

use shotline::math::{Affine, Vec3, unit};
use shotline::scene::{Camera, Lens, Light, LightSource, Material};

use super::color::srgb;
use super::fields::{Field, List, Read};
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind, Notes};
use crate::unique_names::UniqueNames;

const SURFACES: NoteKind = NoteKind {
    name: "surfaces_not_read",
    effect: Effect::Kept,
    one: "of 1 material textures, transparency, roughness or the like were not read",
    many: "of # materials textures, transparency, roughness or the like were not read",
};

const SPOTS: NoteKind = NoteKind {
    name: "spots",
    effect: Effect::Kept,
    one: "1 spot light became a light that shines in all directions",
    many: "# spot lights became lights that shine in all directions",
};

const RELATIVE: NoteKind = NoteKind {
    name: "light_intensities",
    effect: Effect::Kept,
    one: "the intensity of 1 light was divided by that of the strongest of its type",
    many: "the intensities of # lights were divided by that of the strongest of their type",
};

/// The keys of a material that are read, or say nothing about its look.
const READ: [&str; 3] = ["name", "extras", "doubleSided"];

/// The names and the materials of a file.
pub(super) fn materials(list: List, notes: &mut Notes) -> Read<Vec<(String, Material)>> {
    let mut names = UniqueNames::default();
    let mut materials = Vec::with_capacity(list.len());
    for (number, field) in list.iter().enumerate() {
        let default = format!("material{number}");
        let name = names.free(field.name().unwrap_or(&default));
        materials.push((name, material(field, &format!("material {number}"), notes)?));
    }
    Ok(materials)
}

fn material(field: Field, what: &str, notes: &mut Notes) -> Read<Material> {
    let mut is_simple = true;
    for (key, value) in field.members(what)? {
        is_simple &= match key {
            "pbrMetallicRoughness" => is_plain(value)?,
            "alphaMode" => value.text(key)? == "OPAQUE",
            "emissiveFactor" => value.numbers::<3>(key)? == [0.0; 3],
            _ => READ.contains(&key),
        };
    }
    if !is_simple {
        notes.add(&SURFACES, RawLocation::Text(field.range()));
    }
    let base = field.get("pbrMetallicRoughness").and_then(|pbr| pbr.get("baseColorFactor"));
    let color = match base {
        Some(base) => {
            let [red, green, blue, _] = base.numbers::<4>("\"baseColorFactor\"")?;
            Some([red, green, blue].map(srgb))
        }
        None => None,
    };
    Ok(Material { color, ..Material::default() })
}

/// Whether a surface is of its colour only: neither metal nor smooth, which says nothing more than that it is dull.
fn is_plain(surface: Field) -> Read<bool> {
    let mut is_plain = true;
    for (key, value) in surface.members("pbrMetallicRoughness")? {
        is_plain &= match key {
            "baseColorFactor" => true,
            "metallicFactor" => value.number(key)? == 0.0,
            "roughnessFactor" => value.number(key)? == 1.0,
            _ => false,
        };
    }
    Ok(is_plain)
}

/// A camera that a node places: it looks along the negative z axis of the node.
pub(super) fn camera(field: Field, world_from_node: &Affine) -> Read<Camera> {
    let kind = field.required("type", "the camera")?;
    let lens = match kind.text("\"type\"")? {
        "perspective" => {
            let yfov = field.required("perspective", "the camera")?.required("yfov", "\"perspective\"")?;
            let fov = yfov.number("\"yfov\"")?.to_degrees();
            if !(fov > 0.0 && fov < 180.0) {
                return Err(yfov.error("the angle of view must be above 0 and below pi"));
            }
            Lens::Pinhole { fov }
        }
        "orthographic" => {
            let ymag = field.required("orthographic", "the camera")?.required("ymag", "\"orthographic\"")?;
            // Some programs write a negative one to turn the picture over.
            let height = 2.0 * ymag.number("\"ymag\"")?.abs();
            if !(height > 0.0 && height.is_finite()) {
                return Err(ymag.error("the height of the picture must not be 0"));
            }
            Lens::Orthographic { height }
        }
        other => {
            let message = format!("there is no camera of the type '{other}'");
            return Err(kind.error(message).help("there are perspective and orthographic"));
        }
    };
    let eye = world_from_node.point(Vec3::ZERO);
    let ahead = unit(world_from_node.vector(-Vec3::Z));
    Ok(Camera { eye, target: eye + ahead, up: unit(world_from_node.vector(Vec3::Y)), lens })
}

/// The lights that nodes have placed.
#[derive(Debug, Default)]
pub(super) struct Lights {
    placed: Vec<(Light, f64)>,
}

impl Lights {
    /// Adds a light (KHR_lights_punctual), which shines along the negative z axis of its node.
    pub(super) fn add(&mut self, field: Field, world_from_node: &Affine, notes: &mut Notes) -> Read<()> {
        let kind = field.required("type", "the light")?;
        let source = match kind.text("\"type\"")? {
            "directional" => LightSource::Directional(unit(world_from_node.vector(-Vec3::Z))),
            word @ ("point" | "spot") => {
                if word == "spot" {
                    notes.add(&SPOTS, RawLocation::Text(field.range()));
                }
                LightSource::Point(world_from_node.point(Vec3::ZERO))
            }
            other => {
                let message = format!("there is no light of the type '{other}'");
                return Err(kind.error(message).help("there are directional, point and spot"));
            }
        };
        let color = field.get("color").map(|color| color.numbers::<3>("\"color\"")).transpose()?;
        let intensity = match field.get("intensity") {
            Some(intensity) => {
                let number = intensity.number("\"intensity\"")?;
                if number < 0.0 {
                    return Err(intensity.error("the intensity of a light must not be negative"));
                }
                number
            }
            None => 1.0,
        };
        let color = color.map(|color| color.map(srgb));
        self.placed.push((Light { source, color, intensity: None }, intensity));
        Ok(())
    }

    /// The lights. Intensities are in candela and lux, which say nothing without distances and an exposure: beyond 1 only
    /// how they compare is kept.
    pub(super) fn finish(self, notes: &mut Notes) -> Vec<Light> {
        let is_point = |light: &Light| matches!(light.source, LightSource::Point(_));
        let mut strongest = [1.0_f64; 2];
        for (light, intensity) in &self.placed {
            let of_type = &mut strongest[usize::from(is_point(light))];
            *of_type = of_type.max(*intensity);
        }
        let scaled = |(light, intensity): (Light, f64)| {
            let most = strongest[usize::from(is_point(&light))];
            if most > 1.0 {
                notes.add(&RELATIVE, RawLocation::File);
            }
            Light { intensity: Some(intensity / most).filter(|x| *x != 1.0), ..light }
        };
        self.placed.into_iter().map(scaled).collect()
    }
}

//! Materials, the camera and the lights.

use shotline::math::Vec3;
use shotline::scene::{Camera, Lens, Light, LightSource, Material};

use super::keys::{CAMERA, LIGHT, MATERIAL, names};
use super::values::{Values, numbers_in_words};
use crate::json::ValueId;

pub(super) fn read_materials(values: &mut Values, at: ValueId) -> Vec<(String, Material)> {
    let members = values.object(at, "\"materials\"").unwrap_or(&[]);
    members.iter().map(|m| (m.key.to_string(), read_material(values, m.value))).collect()
}

fn read_material(values: &mut Values, at: ValueId) -> Material {
    if values.object(at, "a material").is_none() {
        return Material::default();
    }
    values.only(at, "a material", &names(MATERIAL).collect::<Vec<_>>());
    Material {
        mu: number(values, at, "mu", not_negative),
        density: number(values, at, "density", not_negative),
        composition: composition(values, at),
        color: color(values, at),
        specular: number(values, at, "specular", share),
        shininess: number(values, at, "shininess", not_negative),
        mirror: number(values, at, "mirror", share),
    }
}

fn composition(values: &mut Values, material: ValueId) -> Vec<(String, f64)> {
    let members = values.tree.get(material, "composition");
    let members = members.and_then(|at| values.object(at, "\"composition\"")).unwrap_or(&[]);
    let mut shares = Vec::new();
    for member in members {
        let Some(mass) = values.number(member.value, "a share of the mass") else { continue };
        if let Some(expected) = share(mass) {
            values.report(
                member.value,
                format!("this share of the mass is {mass}"),
                format!("it must be {expected}"),
            );
        }
        shares.push((member.key.to_string(), mass));
    }
    shares
}

/// The vertical angle of view, in degrees, of a camera without "fov" and "height".
pub(super) const DEFAULT_FOV: f64 = 40.0;

pub(super) fn read_camera(values: &mut Values, at: ValueId) -> Option<Camera> {
    values.object(at, "\"camera\"")?;
    values.only(at, "the camera", &names(CAMERA).collect::<Vec<_>>());
    for key in ["eye", "target"] {
        values.required(at, "the camera", key, &numbers_in_words(3));
    }
    let eye = vector(values, at, "eye");
    let target = vector(values, at, "target");
    let up = vector(values, at, "up");
    let fov = number(values, at, "fov", half_turn);
    let height = number(values, at, "height", positive);
    if let (Some(_), Some(height)) = (values.tree.get(at, "fov"), values.tree.get(at, "height")) {
        values.report(
            height,
            "the camera has a \"fov\" as well",
            "keep \"height\" for a parallel projection only",
        );
    }
    let (eye, target) = (eye?, target?);
    if eye == target {
        values.report_at_start(at, "the camera stands at its own target", "move \"eye\" or \"target\"");
    }
    let view = target - eye;
    let along_z = view.x == 0.0 && view.y == 0.0;
    let lens = match height {
        Some(height) => Lens::Orthographic { height },
        None => Lens::Pinhole { fov: fov.unwrap_or(DEFAULT_FOV) },
    };
    Some(Camera { eye, target, up: up.unwrap_or(if along_z { Vec3::Y } else { Vec3::Z }), lens })
}

pub(super) fn read_lights(values: &mut Values, at: ValueId) -> Vec<Light> {
    let lights = values.array(at, "\"lights\"").unwrap_or(&[]);
    lights.iter().filter_map(|light| read_light(values, *light)).collect()
}

fn read_light(values: &mut Values, at: ValueId) -> Option<Light> {
    values.object(at, "a light")?;
    values.only(at, "a light", &names(LIGHT).collect::<Vec<_>>());
    let (color, intensity) = (color(values, at), number(values, at, "intensity", not_negative));
    let has = |key: &str| usize::from(values.tree.get(at, key).is_some());
    if has("point") + has("direction") + has("ambient") != 1 {
        let help = "give it a \"point\", a \"direction\" or \"ambient\": true";
        values.report_at_start(at, "a light has exactly one source", help);
        return None;
    }
    let source = if let Some(value) = values.tree.get(at, "ambient") {
        if !values.boolean(value, "\"ambient\"")? {
            values.report(value, "\"ambient\" can only be true", "leave the light out instead");
        }
        LightSource::Ambient
    } else if let Some(point) = vector(values, at, "point") {
        LightSource::Point(point)
    } else {
        let direction = vector(values, at, "direction")?;
        if direction == Vec3::ZERO {
            values.report_at_start(at, "the direction of this light is zero", "give it a direction");
        }
        LightSource::Directional(direction)
    };
    Some(Light { source, color, intensity })
}

/// Returns the valid range, as text, if a number is outside of it.
type Range = fn(f64) -> Option<&'static str>;

fn not_negative(x: f64) -> Option<&'static str> {
    (x < 0.0).then_some("at least 0")
}

fn positive(x: f64) -> Option<&'static str> {
    (x <= 0.0).then_some("above 0")
}

fn share(x: f64) -> Option<&'static str> {
    (!(0.0..=1.0).contains(&x)).then_some("from 0 to 1")
}

fn half_turn(x: f64) -> Option<&'static str> {
    (x <= 0.0 || x >= 180.0).then_some("above 0 and below 180 degrees")
}

fn number(values: &mut Values, at: ValueId, key: &str, range: Range) -> Option<f64> {
    let at = values.tree.get(at, key)?;
    let x = values.number(at, &format!("\"{key}\""))?;
    if let Some(expected) = range(x) {
        values.report(at, format!("\"{key}\" is {x}"), format!("it must be {expected}"));
    }
    Some(x)
}

fn vector(values: &mut Values, at: ValueId, key: &str) -> Option<Vec3> {
    let at = values.tree.get(at, key)?;
    values.vector(at, &format!("\"{key}\"")).map(Vec3::from)
}

fn color(values: &mut Values, at: ValueId) -> Option<[f64; 3]> {
    let at = values.tree.get(at, "color")?;
    let color = values.vector(at, "\"color\"")?;
    if let Some(x) = color.iter().find(|x| share(**x).is_some()) {
        values.report(at, format!("\"color\" has the component {x}"), "components go from 0 to 1");
    }
    Some(color)
}

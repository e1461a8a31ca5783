//! What the pixels of a slice are coloured by, and the colours.

use std::collections::BTreeMap;

use shotline::compile::World;
use shotline::scene::Scene;

use super::owners::{Part, Slice};
use crate::color;
use crate::surface_material;

/// What has a colour of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorBy {
    /// Each object.
    #[default]
    Object,
    /// Each material.
    Material,
    /// Each placement of an object.
    Instance,
}

impl ColorBy {
    /// The name on the command line and in pictures.
    pub fn name(self) -> &'static str {
        match self {
            ColorBy::Object => "object",
            ColorBy::Material => "material",
            ColorBy::Instance => "instance",
        }
    }

    /// The number of what owns a part: of the object, of the material, -1 if it has none, or of the path.
    pub fn number(self, part: &Part) -> i64 {
        match self {
            ColorBy::Object => part.object.into(),
            ColorBy::Material => part.material.map_or(-1, i64::from),
            ColorBy::Instance => part.path as i64,
        }
    }
}

/// Something that has a colour of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its number: see [`ColorBy::number`].
    pub number: i64,
    /// Its name.
    pub name: String,
    /// sRGB from 0 to 255.
    pub color: [u8; 3],
    /// Its area in pixels.
    pub area: f64,
}

/// The colour of what has no material.
const NO_MATERIAL: [u8; 3] = [0xD8, 0xD8, 0xD8];

/// With at most so many objects or materials in a scene, each has one colour in all slices. With more, colours are those of the
/// places in the list of what is on the slice, so that they differ clearly.
const MOST_FIXED: usize = 16;

/// Everything that is on a slice, the largest first. A material with a colour has that; everything else has colours that
/// differ clearly.
pub fn regions(slice: &Slice, world: &World, scene: &Scene, by: ColorBy) -> Vec<Region> {
    let mut areas: BTreeMap<i64, (f64, u32)> = BTreeMap::new();
    let width = f64::from(slice.width);
    for part in slice.rows.iter().flatten() {
        let [from, to] = part.columns.map(|column| column.clamp(0.0, width));
        areas.entry(by.number(part)).or_insert((0.0, part.object)).0 += to - from;
    }
    let all = match by {
        ColorBy::Object => world.object_names().len(),
        ColorBy::Material => world.material_names().len(),
        ColorBy::Instance => usize::try_from(world.path_count()).unwrap_or(usize::MAX),
    };
    let region = |(place, (&number, &(area, object))): (usize, (&i64, &(f64, u32)))| {
        let material = || surface_material::material(world, scene, object)?.1.color;
        let (name, color) = match (by, usize::try_from(number)) {
            (ColorBy::Object, Ok(number)) => {
                (world.object_names().get(number).cloned().unwrap_or_default(), None)
            }
            (ColorBy::Material, Ok(number)) => {
                let name = world.material_names().get(number).cloned().unwrap_or_default();
                (name, material().map(|channels| channels.map(byte)))
            }
            (ColorBy::Instance, Ok(number)) => (world.path_name(number as u64), None),
            (_, Err(_)) => ("no material".into(), Some(NO_MATERIAL)),
        };
        let place = usize::try_from(number).ok().filter(|_| all <= MOST_FIXED).unwrap_or(place);
        Region { number, name, color: color.unwrap_or_else(|| distinct(place)), area }
    };
    let mut regions: Vec<Region> = areas.iter().enumerate().map(region).collect();
    regions.sort_by(|a, b| b.area.total_cmp(&a.area).then(a.number.cmp(&b.number)));
    regions
}

fn byte(channel: f64) -> u8 {
    (channel.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// Colours that differ in hue, by the golden angle, and in lightness: neighbours are far apart, and any number can be made. They
/// are colours of Oklab (B. Ottosson, 2020), in which equal steps look equal.
fn distinct(number: usize) -> [u8; 3] {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    const LIGHTNESS: [f64; 3] = [0.72, 0.84, 0.60];
    const CHROMA: [f64; 3] = [0.115, 0.095, 0.125];
    let hue = 4.4 + GOLDEN_ANGLE * number as f64;
    let (lightness, chroma) = (LIGHTNESS[number % 3], CHROMA[number % 3]);
    let (a, b) = (chroma * hue.cos(), chroma * hue.sin());
    let cone = |a_weight: f64, b_weight: f64| (lightness + a_weight * a + b_weight * b).powi(3);
    let (l, m, s) = (
        cone(0.396_337_777_4, 0.215_803_757_3),
        cone(-0.105_561_345_8, -0.063_854_172_8),
        cone(-0.089_484_177_5, -1.291_485_548),
    );
    let linear = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    ];
    linear.map(|channel| byte(color::encode(channel)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_colours_are_told_apart() {
        let colors: Vec<[u8; 3]> = (0..16).map(distinct).collect();
        for (i, a) in colors.iter().enumerate() {
            for b in &colors[..i] {
                let distance: u32 = a.iter().zip(b).map(|(x, y)| u32::from(x.abs_diff(*y))).sum();
                assert!(distance > 24, "{a:?} and {b:?}");
            }
        }
    }
}

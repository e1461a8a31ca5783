//! The materials of surfaces, by object, with defaults for what the scene does not give.

use shotline::compile::World;
use shotline::math::Vec3;
use shotline::scene::{Material, Scene};

use crate::color::{self, Rgb};

/// Colours for materials and objects without one: soft, and distinct also in grey.
const PALETTE: [[f64; 3]; 8] = [
    [0.49, 0.64, 0.78],
    [0.91, 0.68, 0.50],
    [0.58, 0.73, 0.57],
    [0.82, 0.53, 0.54],
    [0.93, 0.83, 0.58],
    [0.65, 0.59, 0.77],
    [0.52, 0.72, 0.71],
    [0.77, 0.69, 0.61],
];

/// The exponent of a highlight for which the material gives a strength only.
const SHININESS: f64 = 40.0;

/// How a surface reflects light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMaterial {
    pub color: Rgb,
    pub specular: f64,
    pub shininess: f64,
    pub mirror: f64,
}

impl SurfaceMaterial {
    fn new(material: &Material, fallback: [f64; 3]) -> SurfaceMaterial {
        SurfaceMaterial {
            color: color::linear(material.color.unwrap_or(fallback)).max(Vec3::ZERO),
            specular: material.specular.unwrap_or(0.0).max(0.0),
            shininess: material.shininess.unwrap_or(SHININESS).max(0.0),
            // A mirror reflects at most all light.
            mirror: material.mirror.unwrap_or(0.0).clamp(0.0, 1.0),
        }
    }
}

/// The surface material of each object. A material without a colour gets one of the palette, by the number of the
/// material. An object without a material gets one by the number of the object.
pub fn surface_materials(world: &World, scene: &Scene) -> Vec<SurfaceMaterial> {
    let objects = 0..world.object_names().len();
    objects
        .map(|object| match material(world, scene, object as u32) {
            Some((number, material)) => SurfaceMaterial::new(material, PALETTE[number % PALETTE.len()]),
            None => SurfaceMaterial::new(&Material::default(), PALETTE[object % PALETTE.len()]),
        })
        .collect()
}

/// The material of an object, with its number in the scene.
pub fn material<'s>(world: &World, scene: &'s Scene, object: u32) -> Option<(usize, &'s Material)> {
    let name = world.material_names().get(world.object_material(object)? as usize)?;
    let number = scene.materials.iter().position(|(n, _)| n == name)?;
    Some((number, &scene.materials[number].1))
}

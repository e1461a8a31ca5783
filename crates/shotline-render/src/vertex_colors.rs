//! The colours that meshes have at their vertices.

use shotline::compile::{HitMeshes, World};
use shotline::math::Vec3;
use shotline::query::Hit;
use shotline::query::batch::{ClosestRows, Fields};

use crate::color::{self, Rgb};

/// The attribute of meshes that holds colours, as sRGB from 0 to 1.
const COLOR: &str = "color";

/// The colours of the meshes of a world.
#[derive(Debug)]
pub(crate) struct VertexColors<'w> {
    meshes: HitMeshes<'w>,
}

impl<'w> VertexColors<'w> {
    /// The columns of hits that tell where they are on a mesh.
    pub fn fields() -> Fields {
        Fields::SURFACE | Fields::PRIMITIVE | Fields::PATH
    }

    /// `None` if no mesh has colours.
    pub fn new(world: &'w World) -> Option<VertexColors<'w>> {
        world.has_attribute(COLOR).then(|| VertexColors { meshes: HitMeshes::new(world) })
    }

    /// The colour at the hit of a row, which is at a point; `None` if there is none.
    pub fn of_row(&mut self, rows: &ClosestRows, row: usize, point: Vec3) -> Option<Rgb> {
        let surface = u32::try_from(rows.surface[row]).ok()?;
        let primitive = u32::try_from(rows.primitive[row]).ok()?;
        self.at(surface, primitive, rows.path[row] as u64, point)
    }

    /// The colour at a hit, which is at a point; `None` if there is none.
    pub fn of_hit(&mut self, hit: &Hit, point: Vec3) -> Option<Rgb> {
        self.at(hit.surface?, hit.primitive?, hit.path, point)
    }

    fn at(&mut self, surface: u32, primitive: u32, path: u64, point: Vec3) -> Option<Rgb> {
        let hit = self.meshes.get(surface, path)?;
        let attribute = hit.mesh().attribute(COLOR).filter(|attribute| attribute.width >= 3)?;
        let mut value = [0.0; 4];
        hit.interpolate(attribute, primitive, point, &mut value[..attribute.width.min(4)]);
        let [red, green, blue, _] = value;
        let rgb = [red, green, blue].map(|channel| channel.clamp(0.0, 1.0));
        rgb.iter().all(|channel| channel.is_finite()).then(|| color::linear(rgb))
    }
}

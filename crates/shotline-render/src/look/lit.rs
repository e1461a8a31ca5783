//! Surfaces in light: shade, shadow, highlight, mirror.

use shotline::math::Vec3;
use shotline::query::QueryError;
use shotline::ray::Ray;

use super::{Look, Shader, ShaderContext};
use crate::background::Background;
use crate::color::Rgb;
use crate::error::RenderError;
use crate::exposure::Sample;
use crate::light::{Lighting, Lights, sample_lamp, sample_sky};
use crate::sampling::SampleNumbers;
use crate::surface_material::{SurfaceMaterial, surface_materials};
use crate::tracer::{PixelTracer, SurfacePoint};

pub(super) static LOOK: Look = Look {
    name: "lit",
    summary: "surfaces in the colours of their materials, with shadows, highlights and mirrors",
    background: Background::STUDIO,
    is_local: true,
    shader: |context| Ok(Box::new(Lit::new(context)?)),
};

/// The maximum number of reflections of a ray.
const BOUNCES: u32 = 6;
/// A reflection that adds less than this to a pixel is not traced.
const FAINT: f64 = 1.0 / 512.0;
/// The relative difference of ambient light from above and from the side: 1 + `SKY` from above, 1 - `SKY` from below.
const SKY: f64 = 0.35;
/// The fraction of the sky's light that an occluder passes on, since it is lit itself.
const PASSED_ON: f64 = 0.35;

struct Lit {
    materials: Vec<SurfaceMaterial>,
    lights: Lights,
    zenith: Vec3,
    /// What mirrors show where rays meet nothing.
    background: Background,
    lighting: Lighting,
}

/// A point to be shaded.
struct ShadingPoint<'a> {
    surface: SurfacePoint,
    material: &'a SurfaceMaterial,
    /// The unit vector back to the viewer.
    view: Vec3,
    numbers: &'a SampleNumbers,
}

impl Shader for Lit {
    fn sample(
        &self,
        tracer: &mut PixelTracer,
        ray: &Ray,
        numbers: &SampleNumbers,
    ) -> Result<Sample, QueryError> {
        let light = self.incoming(tracer, ray, numbers, 1.0, BOUNCES)?;
        Ok(light.map_or(Sample::NOTHING, Sample::opaque))
    }
}

impl Lit {
    fn new(context: &ShaderContext) -> Result<Lit, RenderError> {
        let background = match context.background {
            Background::Transparent => LOOK.background,
            other => other,
        };
        let lights = Lights::new(&context.scene.lights, context.view);
        Ok(Lit {
            materials: surface_materials(context.world, context.scene),
            lights: lights.map_err(|(index, error)| RenderError::Light { index, error })?,
            zenith: context.view.zenith(),
            background,
            lighting: context.lighting,
        })
    }

    /// The light that comes back along a ray; `None` if the ray meets nothing. `weight` is the fraction of it that
    /// reaches the picture.
    fn incoming(
        &self,
        tracer: &mut PixelTracer,
        ray: &Ray,
        numbers: &SampleNumbers,
        weight: f64,
        bounces: u32,
    ) -> Result<Option<Rgb>, QueryError> {
        let Some(surface) = tracer.surface(ray)? else { return Ok(None) };
        let material = &self.materials[surface.hit.object as usize];
        let point = ShadingPoint { surface, material, view: -ray.direction().normalize(), numbers };
        let own = self.reflected_light(tracer, &point)?;
        let mirrored_weight = weight * material.mirror;
        if bounces == 0 || mirrored_weight < FAINT {
            return Ok(Some(own));
        }
        let direction = surface.normal * (2.0 * surface.normal.dot(point.view)) - point.view;
        let mirrored = match Ray::new(surface.start, direction) {
            Ok(ray) => self.incoming(tracer, &ray, numbers, mirrored_weight, bounces - 1)?,
            Err(_) => None,
        };
        Ok(Some(own.lerp(mirrored.unwrap_or_else(|| self.background_along(direction)), material.mirror)))
    }

    /// The background around the scene, by elevation.
    fn background_along(&self, direction: Vec3) -> Rgb {
        self.background.color((direction.dot(self.zenith) + 1.0) / 2.0).unwrap_or(Vec3::ZERO)
    }

    /// The light of lamps and the ambient light that a surface reflects to the viewer.
    fn reflected_light(&self, tracer: &mut PixelTracer, point: &ShadingPoint) -> Result<Rgb, QueryError> {
        let ambient = point.material.color * self.lights.ambient * self.ambient_factor(tracer, point)?;
        let mut lamps = 0..self.lights.lamps.len();
        lamps.try_fold(ambient, |sum, lamp| Ok(sum + self.lamp(tracer, point, lamp)?.unwrap_or(Vec3::ZERO)))
    }

    /// The fraction of the ambient light that arrives.
    fn ambient_factor(&self, tracer: &mut PixelTracer, point: &ShadingPoint) -> Result<f64, QueryError> {
        let unoccluded = |toward: Vec3| 1.0 + SKY * toward.dot(self.zenith);
        let normal = point.surface.normal;
        match self.lighting {
            Lighting::Sharp => Ok(unoccluded(normal)),
            Lighting::Soft => {
                let toward = sample_sky(normal, point.numbers.sky);
                let is_occluded = tracer.is_occluded(&point.surface, toward, f64::INFINITY, None)?;
                Ok(unoccluded(toward) * if is_occluded { PASSED_ON } else { 1.0 })
            }
        }
    }

    /// Lambert's shade and Blinn's highlight of one lamp; `None` in its shadow.
    fn lamp(
        &self,
        tracer: &mut PixelTracer,
        point: &ShadingPoint,
        number: usize,
    ) -> Result<Option<Rgb>, QueryError> {
        let lamp = &self.lights.lamps[number];
        let &ShadingPoint { ref surface, material, view, numbers } = point;
        let (middle, reach) = lamp.direction_from(surface.start);
        let toward = match self.lighting {
            Lighting::Sharp => middle,
            Lighting::Soft => sample_lamp(middle, numbers.lamp),
        };
        let Some(light) = toward.try_normalize() else { return Ok(None) };
        let cosine = surface.normal.dot(light);
        if cosine <= 0.0 || tracer.is_occluded(surface, toward, reach, Some(number))? {
            return Ok(None);
        }
        let half = (light + view).try_normalize().unwrap_or(surface.normal);
        let highlight = material.specular * surface.normal.dot(half).max(0.0).powf(material.shininess);
        Ok(Some(lamp.color * (material.color * cosine + Vec3::splat(highlight))))
    }
}

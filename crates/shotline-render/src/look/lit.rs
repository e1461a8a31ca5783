//! Surfaces in light: shade, shadow, highlight, mirror.

use shotline::math::Vec3;
use shotline::query::batch::BatchError;
use shotline::ray::{Ray, Span};

use super::{Look, Shader, ShaderContext};
use crate::background::Background;
use crate::color::Rgb;
use crate::error::RenderError;
use crate::exposure::Sample;
use crate::hatch::hatched;
use crate::light::{Lighting, Lights, sample_lamp, sample_sky};
use crate::sampling::SampleNumbers;
use crate::surface_material::{SurfaceMaterial, surface_materials};
use crate::tracer::{SampleRays, SurfacePoint, Tracer};

pub(super) static LOOK: Look = Look {
    name: "lit",
    summary: "surfaces in the colours of their materials, with shadows, highlights and mirrors",
    background: Background::STUDIO,
    is_local: true,
    shows_surfaces: true,
    blends: true,
    hatches: true,
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

/// How much darker a cut is that is seen edge on. Otherwise the light of a cut is the same everywhere, without shade, shadow and
/// highlight, so that it is seen to be a cut, and cuts by different planes can be told apart.
const CUT_SHADE: f64 = 0.3;

struct Lit {
    materials: Vec<SurfaceMaterial>,
    lights: Lights,
    zenith: Vec3,
    /// The direction of view.
    forward: Vec3,
    /// What mirrors show where rays meet nothing.
    background: Background,
    lighting: Lighting,
    hatch: bool,
}

/// A point to be shaded.
struct ShadingPoint<'a> {
    surface: SurfacePoint,
    material: SurfaceMaterial,
    /// The unit vector back to the viewer.
    view: Vec3,
    sample: u32,
    numbers: &'a SampleNumbers,
}

impl ShadingPoint<'_> {
    /// The direction of a mirrored ray.
    fn mirrored(&self) -> Vec3 {
        self.surface.normal * (2.0 * self.surface.normal.dot(self.view)) - self.view
    }

    /// Lambert's shade and Blinn's highlight of a lamp that is not in shadow.
    fn shade(&self, &LampWay { light, cosine, .. }: &LampWay) -> Rgb {
        let (normal, material) = (self.surface.normal, self.material);
        let half = (light + self.view).try_normalize().unwrap_or(normal);
        let highlight = material.specular * normal.dot(half).max(0.0).powf(material.shininess);
        material.color * cosine + Vec3::splat(highlight)
    }
}

/// The way from a point to a lamp.
struct LampWay {
    /// The number of the point.
    point: usize,
    /// The unit vector to the lamp.
    light: Vec3,
    cosine: f64,
}

impl Shader for Lit {
    fn shade(
        &self,
        tracer: &mut Tracer,
        rays: &SampleRays,
        numbers: &[SampleNumbers],
        samples: &mut [Sample],
    ) -> Result<(), BatchError> {
        let incoming = self.incoming(tracer, rays, numbers, &vec![1.0; rays.len()], BOUNCES)?;
        samples.copy_from_slice(&incoming);
        Ok(())
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
            forward: context.view.forward(),
            background,
            lighting: context.lighting,
            hatch: context.hatch,
        })
    }

    /// The light that comes back along each ray from what it meets. `weights` are the fractions of it that reach the picture.
    fn incoming(
        &self,
        tracer: &mut Tracer,
        rays: &SampleRays,
        numbers: &[SampleNumbers],
        weights: &[f64],
        bounces: u32,
    ) -> Result<Vec<Sample>, BatchError> {
        let shading_point = |surface: SurfacePoint| {
            let sample = rays.sample(surface.ray);
            let material = self.materials[surface.object as usize];
            let material = SurfaceMaterial { color: surface.color.unwrap_or(material.color), ..material };
            let view = -rays.ray(surface.ray).direction().normalize();
            ShadingPoint { surface, material, view, sample, numbers: &numbers[sample as usize] }
        };
        let mut incoming = vec![Sample::NOTHING; rays.len()];
        let (cuts, surfaces): (Vec<_>, Vec<_>) = tracer.layers(rays)?.into_iter().partition(|s| s.is_cut);
        for cut in cuts {
            let light = 1.0 - CUT_SHADE * (1.0 - cut.normal.dot(self.forward).abs());
            let color = self.materials[cut.object as usize].color * light;
            let position = numbers[rays.sample(cut.ray) as usize].position;
            let color = if self.hatch { hatched(color, cut.object, position) } else { color };
            incoming[cut.ray].add(color, cut.weight);
        }
        let points: Vec<_> = surfaces.into_iter().map(shading_point).collect();
        let mut reflected = self.reflected_light(tracer, &points)?;
        let (mut mirrored, mut mirrored_weights, mut mirrors) =
            (SampleRays::default(), Vec::new(), Vec::new());
        for (number, point) in points.iter().enumerate() {
            let weight = weights[point.surface.ray] * point.surface.weight * point.material.mirror;
            if bounces == 0 || weight < FAINT {
                continue;
            }
            let direction = point.mirrored();
            let background = self.background_along(direction);
            if self.lighting == Lighting::Plain {
                reflected[number] = reflected[number].lerp(background, point.material.mirror);
                continue;
            }
            match Ray::new(point.surface.start, direction) {
                Ok(ray) => {
                    mirrored.push(ray, point.sample);
                    mirrored_weights.push(weight);
                    mirrors.push((number, background));
                }
                Err(_) => reflected[number] = reflected[number].lerp(background, point.material.mirror),
            }
        }
        if !mirrored.is_empty() {
            let light = self.incoming(tracer, &mirrored, numbers, &mirrored_weights, bounces - 1)?;
            for ((number, background), light) in mirrors.into_iter().zip(light) {
                let seen = light.color + background * (1.0 - light.alpha);
                reflected[number] = reflected[number].lerp(seen, points[number].material.mirror);
            }
        }
        for (point, color) in points.iter().zip(reflected) {
            incoming[point.surface.ray].add(color, point.surface.weight);
        }
        Ok(incoming)
    }

    /// The background around the scene, by elevation.
    fn background_along(&self, direction: Vec3) -> Rgb {
        self.background.color((direction.dot(self.zenith) + 1.0) / 2.0).unwrap_or(Vec3::ZERO)
    }

    /// The light of lamps and the ambient light that each surface reflects to the viewer.
    fn reflected_light(&self, tracer: &mut Tracer, points: &[ShadingPoint]) -> Result<Vec<Rgb>, BatchError> {
        let factors = self.ambient_factors(tracer, points)?;
        let ambient =
            |(point, factor): (&ShadingPoint, f64)| point.material.color * self.lights.ambient * factor;
        let mut reflected: Vec<Rgb> = points.iter().zip(factors).map(ambient).collect();
        for lamp in 0..self.lights.lamps.len() {
            self.add_lamp(tracer, points, lamp, &mut reflected)?;
        }
        Ok(reflected)
    }

    /// The fraction of the ambient light that arrives at each point.
    fn ambient_factors(&self, tracer: &mut Tracer, points: &[ShadingPoint]) -> Result<Vec<f64>, BatchError> {
        let unoccluded = |toward: Vec3| 1.0 + SKY * toward.dot(self.zenith);
        if self.lighting != Lighting::Soft {
            return Ok(points.iter().map(|point| unoccluded(point.surface.normal)).collect());
        }
        let (mut factors, mut rays, mut of_rays) =
            (Vec::with_capacity(points.len()), SampleRays::default(), Vec::new());
        for (number, point) in points.iter().enumerate() {
            let toward = sample_sky(point.surface.normal, point.numbers.sky);
            factors.push(unoccluded(toward));
            if let Ok(ray) = Ray::new(point.surface.start, toward) {
                rays.push(ray, point.sample);
                of_rays.push(number);
            }
        }
        for (number, is_occluded) in of_rays.into_iter().zip(tracer.occluded(&rays, Span::FORWARD, None)?) {
            factors[number] *= if *is_occluded { PASSED_ON } else { 1.0 };
        }
        Ok(factors)
    }

    /// Adds the light of one lamp at each point that is not in its shadow.
    fn add_lamp(
        &self,
        tracer: &mut Tracer,
        points: &[ShadingPoint],
        number: usize,
        reflected: &mut [Rgb],
    ) -> Result<(), BatchError> {
        let lamp = &self.lights.lamps[number];
        let (mut rays, mut ways) = (SampleRays::default(), Vec::new());
        for (index, point) in points.iter().enumerate() {
            let middle = lamp.direction_from(point.surface.start);
            let toward = match self.lighting {
                Lighting::Sharp | Lighting::Plain => middle,
                Lighting::Soft => sample_lamp(middle, point.numbers.lamp),
            };
            let Some(light) = toward.try_normalize() else { continue };
            let cosine = point.surface.normal.dot(light);
            if cosine <= 0.0 {
                continue;
            }
            let way = LampWay { point: index, light, cosine };
            if self.lighting == Lighting::Plain {
                reflected[index] += lamp.color * point.shade(&way);
                continue;
            }
            match Ray::new(point.surface.start, toward) {
                Ok(ray) => {
                    rays.push(ray, point.sample);
                    ways.push(way);
                }
                Err(_) => reflected[index] += lamp.color * point.shade(&way),
            }
        }
        let occluded = tracer.occluded(&rays, lamp.span(), Some(number))?;
        for (way, _) in ways.iter().zip(occluded).filter(|(_, is_occluded)| !**is_occluded) {
            reflected[way.point] += lamp.color * points[way.point].shade(way);
        }
        Ok(())
    }
}

//! Surfaces in light: shade, shadow, highlight, mirror.

use shotline::math::Vec3;
use shotline::query::QueryError;
use shotline::ray::Ray;

use super::{Look, Shader, Stage};
use crate::backdrop::Backdrop;
use crate::color::Rgb;
use crate::film::Sample;
use crate::finish::{Finish, finishes};
use crate::light::{Lamp, Lights};
use crate::sight::{Eye, Place};

pub(super) static LOOK: Look = Look {
    name: "lit",
    summary: "surfaces in the colours of their materials, with shadows, highlights and mirrors",
    backdrop: Backdrop::STUDIO,
    shader: |stage| Ok(Box::new(Lit::new(stage)?)),
};

/// How often light is followed from mirror to mirror.
const BOUNCES: u32 = 6;
/// A mirror that adds less than this to a pixel is not followed.
const FAINT: f64 = 1.0 / 512.0;
/// How much more of the light from everywhere comes from above than from below.
const SKY: f64 = 0.35;

struct Lit {
    finishes: Vec<Finish>,
    lights: Lights,
    zenith: Vec3,
    /// What mirrors show where there is nothing.
    sky: Backdrop,
}

impl Shader for Lit {
    fn sample(&self, eye: &mut Eye, ray: &Ray) -> Result<Sample, QueryError> {
        Ok(self.seen(eye, ray, 1.0, BOUNCES).map_or(Sample::NOTHING, Sample::opaque))
    }
}

impl Lit {
    fn new(stage: &Stage) -> Result<Lit, crate::RenderError> {
        let sky = if stage.backdrop == Backdrop::Transparent { LOOK.backdrop } else { stage.backdrop };
        Ok(Lit {
            finishes: finishes(stage.world, stage.scene),
            lights: Lights::new(&stage.scene.lights, stage.view)?,
            zenith: stage.view.zenith(),
            sky,
        })
    }

    /// The light that comes back along a ray, of which `share` ends up in the picture.
    fn seen(&self, eye: &mut Eye, ray: &Ray, share: f64, bounces: u32) -> Option<Rgb> {
        let place = eye.surface(ray)?;
        let finish = &self.finishes[place.hit.object as usize];
        let view = -ray.direction().normalize();
        let own = self.shaded(eye, &place, finish, view);
        let mirrored = share * finish.mirror;
        if bounces == 0 || mirrored < FAINT {
            return Some(own);
        }
        let direction = place.normal * (2.0 * place.normal.dot(view)) - view;
        let reflected = Ray::new(place.start, direction).ok();
        let reflected = reflected.and_then(|ray| self.seen(eye, &ray, mirrored, bounces - 1));
        Some(own.lerp(reflected.unwrap_or_else(|| self.sky(direction)), finish.mirror))
    }

    /// The backdrop around the scene, by elevation.
    fn sky(&self, direction: Vec3) -> Rgb {
        self.sky.color((direction.dot(self.zenith) + 1.0) / 2.0).unwrap_or(Vec3::ZERO)
    }

    /// What a surface sends to the viewer of the light that falls on it.
    fn shaded(&self, eye: &mut Eye, place: &Place, finish: &Finish, view: Vec3) -> Rgb {
        let above = 1.0 + SKY * place.normal.dot(self.zenith);
        let mut sum = finish.color * self.lights.ambient * above;
        for lamp in &self.lights.lamps {
            sum += lit_by(lamp, eye, place, finish, view).unwrap_or(Vec3::ZERO);
        }
        sum
    }
}

/// Lambert's shade and Blinn's highlight of one lamp; `None` in its shadow.
fn lit_by(lamp: &Lamp, eye: &mut Eye, place: &Place, finish: &Finish, view: Vec3) -> Option<Rgb> {
    let (toward, reach) = lamp.seen_from(place.start);
    let light = toward.try_normalize()?;
    let facing = place.normal.dot(light);
    if facing <= 0.0 || eye.blocked(place, toward, reach) {
        return None;
    }
    let half = (light + view).try_normalize().unwrap_or(place.normal);
    let highlight = finish.specular * place.normal.dot(half).max(0.0).powf(finish.shininess);
    Some(lamp.color * (finish.color * facing + Vec3::splat(highlight)))
}

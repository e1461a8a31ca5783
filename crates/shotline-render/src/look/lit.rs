//! Surfaces in light: shade, shadow, highlight, mirror.

use shotline::math::Vec3;
use shotline::query::QueryError;
use shotline::ray::Ray;

use super::{Look, Shader, Stage};
use crate::backdrop::Backdrop;
use crate::color::Rgb;
use crate::error::RenderError;
use crate::film::Sample;
use crate::finish::{Finish, finishes};
use crate::light::{Lighting, Lights, to_part_of_lamp, to_part_of_sky};
use crate::sampling::Chance;
use crate::sight::{Eye, Place};

pub(super) static LOOK: Look = Look {
    name: "lit",
    summary: "surfaces in the colours of their materials, with shadows, highlights and mirrors",
    backdrop: Backdrop::STUDIO,
    local: true,
    shader: |stage| Ok(Box::new(Lit::new(stage)?)),
};

/// How often light is followed from mirror to mirror.
const BOUNCES: u32 = 6;
/// A mirror that adds less than this to a pixel is not followed.
const FAINT: f64 = 1.0 / 512.0;
/// How much more of the light from everywhere comes from above than from below.
const SKY: f64 = 0.35;
/// The part of the sky's light that what covers it passes on, being lit itself.
const PASSED_ON: f64 = 0.35;

struct Lit {
    finishes: Vec<Finish>,
    lights: Lights,
    zenith: Vec3,
    /// What mirrors show where there is nothing.
    backdrop: Backdrop,
    lighting: Lighting,
}

/// A place that is looked at.
struct Spot<'a> {
    place: Place,
    finish: &'a Finish,
    /// The unit vector back to the viewer.
    view: Vec3,
    chance: &'a Chance,
}

impl Shader for Lit {
    fn sample(&self, eye: &mut Eye, ray: &Ray, chance: &Chance) -> Result<Sample, QueryError> {
        Ok(self.seen(eye, ray, chance, 1.0, BOUNCES)?.map_or(Sample::NOTHING, Sample::opaque))
    }
}

impl Lit {
    fn new(stage: &Stage) -> Result<Lit, RenderError> {
        let backdrop = if stage.backdrop == Backdrop::Transparent { LOOK.backdrop } else { stage.backdrop };
        Ok(Lit {
            finishes: finishes(stage.world, stage.scene),
            lights: Lights::new(&stage.scene.lights, stage.view)?,
            zenith: stage.view.zenith(),
            backdrop,
            lighting: stage.lighting,
        })
    }

    /// The light that comes back along a ray, of which `share` ends up in the picture.
    fn seen(
        &self,
        eye: &mut Eye,
        ray: &Ray,
        chance: &Chance,
        share: f64,
        bounces: u32,
    ) -> Result<Option<Rgb>, QueryError> {
        let Some(place) = eye.surface(ray)? else { return Ok(None) };
        let finish = &self.finishes[place.hit.object as usize];
        let spot = Spot { place, finish, view: -ray.direction().normalize(), chance };
        let own = self.shaded(eye, &spot)?;
        let mirrored = share * finish.mirror;
        if bounces == 0 || mirrored < FAINT {
            return Ok(Some(own));
        }
        let direction = place.normal * (2.0 * place.normal.dot(spot.view)) - spot.view;
        let reflected = match Ray::new(place.start, direction) {
            Ok(ray) => self.seen(eye, &ray, chance, mirrored, bounces - 1)?,
            Err(_) => None,
        };
        Ok(Some(own.lerp(reflected.unwrap_or_else(|| self.behind(direction)), finish.mirror)))
    }

    /// The backdrop around the scene, by elevation.
    fn behind(&self, direction: Vec3) -> Rgb {
        self.backdrop.color((direction.dot(self.zenith) + 1.0) / 2.0).unwrap_or(Vec3::ZERO)
    }

    /// What a surface sends to the viewer of the light that falls on it.
    fn shaded(&self, eye: &mut Eye, spot: &Spot) -> Result<Rgb, QueryError> {
        let everywhere = spot.finish.color * self.lights.ambient * self.sky(eye, spot)?;
        let mut lamps = 0..self.lights.lamps.len();
        lamps.try_fold(everywhere, |sum, lamp| Ok(sum + self.lamp(eye, spot, lamp)?.unwrap_or(Vec3::ZERO)))
    }

    /// How much of the light from everywhere arrives.
    fn sky(&self, eye: &mut Eye, spot: &Spot) -> Result<f64, QueryError> {
        let open = |toward: Vec3| 1.0 + SKY * toward.dot(self.zenith);
        let normal = spot.place.normal;
        match self.lighting {
            Lighting::Sharp => Ok(open(normal)),
            Lighting::Soft => {
                let toward = to_part_of_sky(normal, spot.chance.sky);
                let covered = eye.blocked(&spot.place, toward, f64::INFINITY, None)?;
                Ok(open(toward) * if covered { PASSED_ON } else { 1.0 })
            }
        }
    }

    /// Lambert's shade and Blinn's highlight of one lamp; `None` in its shadow.
    fn lamp(&self, eye: &mut Eye, spot: &Spot, number: usize) -> Result<Option<Rgb>, QueryError> {
        let lamp = &self.lights.lamps[number];
        let &Spot { ref place, finish, view, chance } = spot;
        let (middle, reach) = lamp.seen_from(place.start);
        let toward = match self.lighting {
            Lighting::Sharp => middle,
            Lighting::Soft => to_part_of_lamp(middle, chance.lamp),
        };
        let Some(light) = toward.try_normalize() else { return Ok(None) };
        let facing = place.normal.dot(light);
        if facing <= 0.0 || eye.blocked(place, toward, reach, Some(number))? {
            return Ok(None);
        }
        let half = (light + view).try_normalize().unwrap_or(place.normal);
        let highlight = finish.specular * place.normal.dot(half).max(0.0).powf(finish.shininess);
        Ok(Some(lamp.color * (finish.color * facing + Vec3::splat(highlight))))
    }
}

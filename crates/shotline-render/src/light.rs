//! Lights: checked ones, and what a scene without any is lit by.

use shotline::math::Vec3;
use shotline::scene::{Light, LightSource};

use crate::camera::{View, unit};
use crate::color::{self, Rgb};
use crate::error::RenderError;

/// What is wrong with a light.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LightError {
    /// Its direction is none.
    #[error("`direction` is zero or not finite: give the direction in which the light travels")]
    Direction,
    /// Its place is none.
    #[error("`point` has a component that is NaN or infinite")]
    Point,
    /// Its strength is none.
    #[error("`intensity` is {0}, but must be finite and not negative")]
    Intensity(f64),
}

/// All the light of a picture.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Lights that cast shadows.
    pub lamps: Vec<Lamp>,
    /// The sum of those that do not.
    pub ambient: Rgb,
}

/// A light that casts shadows.
#[derive(Clone, Copy, Debug)]
pub struct Lamp {
    source: Source,
    /// Its linear colour times its strength.
    pub color: Rgb,
}

#[derive(Clone, Copy, Debug)]
enum Source {
    At(Vec3),
    /// A unit vector against the light.
    Toward(Vec3),
}

impl Lamp {
    /// From a point toward the light: a direction, and how many of its lengths away the light is. The
    /// direction is zero for the light's own place.
    pub fn seen_from(&self, point: Vec3) -> (Vec3, f64) {
        match self.source {
            Source::At(place) => (place - point, 1.0),
            Source::Toward(direction) => (direction, f64::INFINITY),
        }
    }
}

impl Lights {
    /// Checks the lights of a scene; a scene without any is lit by [`automatic`] ones.
    ///
    /// # Errors
    /// [`RenderError::Light`], the first.
    pub fn new(lights: &[Light], view: &View) -> Result<Lights, RenderError> {
        if lights.is_empty() {
            return Lights::new(&automatic(view), view);
        }
        let mut out = Lights::default();
        for (index, light) in lights.iter().enumerate() {
            out.add(light).map_err(|error| RenderError::Light { index, error })?;
        }
        Ok(out)
    }

    fn add(&mut self, light: &Light) -> Result<(), LightError> {
        let intensity = light.intensity.unwrap_or(1.0);
        if !(intensity >= 0.0 && intensity.is_finite()) {
            return Err(LightError::Intensity(intensity));
        }
        let color = color::linear(light.color.unwrap_or([1.0; 3])) * intensity;
        let source = match light.source {
            LightSource::Ambient => {
                self.ambient += color;
                return Ok(());
            }
            LightSource::Point(p) if p.is_finite() => Source::At(p),
            LightSource::Point(_) => return Err(LightError::Point),
            LightSource::Directional(d) => Source::Toward(-unit(d).ok_or(LightError::Direction)?),
        };
        self.lamps.push(Lamp { source, color });
        Ok(())
    }
}

/// The lights of a scene without any: a warm key from above the left shoulder, a cool fill along the view,
/// whose shadows hide behind what casts them, and some light from everywhere.
pub fn automatic(view: &View) -> Vec<Light> {
    let key = view.forward() * 0.7 + view.right() * 0.7 - view.zenith();
    let light = |source, color, intensity| Light { source, color: Some(color), intensity: Some(intensity) };
    vec![
        light(LightSource::Directional(key), [1.0, 0.98, 0.95], 0.75),
        light(LightSource::Directional(view.forward()), [0.93, 0.96, 1.0], 0.15),
        light(LightSource::Ambient, [0.95, 0.97, 1.0], 0.25),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(light: Light) -> LightError {
        Lights::default().add(&light).unwrap_err()
    }

    #[test]
    fn lights_that_do_not_shine_are_refused() {
        let light = |source| Light { source, color: None, intensity: None };
        assert_eq!(error(light(LightSource::Directional(Vec3::ZERO))), LightError::Direction);
        assert_eq!(error(light(LightSource::Point(Vec3::NAN))), LightError::Point);
        let negative = Light { intensity: Some(-1.0), ..light(LightSource::Ambient) };
        assert_eq!(error(negative), LightError::Intensity(-1.0));
    }
}

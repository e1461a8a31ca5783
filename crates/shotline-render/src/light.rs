//! Lights: checked ones, and what a scene without any is lit by.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

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

/// How light falls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lighting {
    /// Lamps are points and light from everywhere reaches everything: sharp shadows, no noise.
    #[default]
    Sharp,
    /// Lamps have a size, and light from everywhere is the sky's, kept out of corners. What part of a lamp
    /// and of the sky a sample asks is left to chance, so it wants many: 32 or more.
    Soft,
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
    /// From a point toward the lamp: a direction, and how many of its lengths away the lamp is. The
    /// direction is zero for the lamp's own place.
    pub fn seen_from(&self, point: Vec3) -> (Vec3, f64) {
        match self.source {
            Source::At(place) => (place - point, 1.0),
            Source::Toward(direction) => (direction, f64::INFINITY),
        }
    }
}

/// The tangent of the angle at which a soft lamp's radius is seen, from wherever.
const LAMP_SIZE: f64 = 0.045;

/// A direction moved to another part of the lamp it goes to, of about the same length.
pub fn to_part_of_lamp(toward: Vec3, part: [f64; 2]) -> Vec3 {
    let (across, along) = toward.normalize_or_zero().any_orthonormal_pair();
    let [x, y] = disc(part);
    toward + (across * x + along * y) * (LAMP_SIZE * toward.length())
}

/// A direction to a part of the sky over a surface; parts that shine on it more steeply are asked more often
/// (Malley: the points of a disc, raised to the hemisphere).
pub fn to_part_of_sky(normal: Vec3, part: [f64; 2]) -> Vec3 {
    let (across, along) = normal.any_orthonormal_pair();
    let [x, y] = disc(part);
    across * x + along * y + normal * (1.0 - x * x - y * y).max(0.0).sqrt()
}

/// A point of the unit disc from one of the unit square, equal areas to equal areas; the middle stays.
fn disc(part: [f64; 2]) -> [f64; 2] {
    let [x, y] = part.map(|p| 2.0 * p - 1.0);
    if x == 0.0 && y == 0.0 {
        return [0.0; 2];
    }
    // Squares around the middle become circles (Shirley and Chiu 1997).
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    [radius * angle.cos(), radius * angle.sin()]
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

/// The lights of a scene without any: a warm lamp far above the left shoulder, a fainter one at the eye,
/// whose shadows hide behind what casts them, and some cool light from everywhere.
pub fn automatic(view: &View) -> Vec<Light> {
    let key = view.forward() * 0.7 + view.right() * 0.7 - view.zenith();
    let light = |source, color, intensity| Light { source, color: Some(color), intensity: Some(intensity) };
    vec![
        light(LightSource::Directional(key), [1.0, 0.97, 0.92], 0.7),
        light(view.headlight(), [0.95, 0.97, 1.0], 0.12),
        light(LightSource::Ambient, [0.93, 0.96, 1.0], 0.33),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disc_is_filled_evenly() {
        let n = 40;
        let middle = |i: usize| (i as f64 + 0.5) / n as f64;
        let points = (0..n * n).map(|i| disc([middle(i % n), middle(i / n)]));
        let radii: Vec<f64> = points.map(|[x, y]| x.hypot(y)).collect();
        assert!(radii.iter().all(|r| *r < 1.0));
        // Half of the area is within the root of one half.
        let inner = radii.iter().filter(|r| **r < 0.5f64.sqrt()).count() as f64 / radii.len() as f64;
        assert!((inner - 0.5).abs() < 0.02, "{inner}");
        assert_eq!(disc([0.5, 0.5]), [0.0, 0.0]);
    }

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

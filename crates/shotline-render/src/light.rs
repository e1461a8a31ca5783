//! Valid lights, and the automatic lights of a scene without any.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use shotline::math::Vec3;
use shotline::ray::Span;
use shotline::scene::{Light, LightSource};

use crate::camera::{View, unit};
use crate::color::{self, Rgb};

/// Why a light is not valid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LightError {
    /// Its direction is not valid.
    #[error("`direction` is zero or not finite: give the direction in which the light travels")]
    Direction,
    /// Its position is not valid.
    #[error("`point` has a component that is NaN or infinite")]
    Point,
    /// Its strength is not valid.
    #[error("`intensity` is {0}, but must be finite and not negative")]
    Intensity(f64),
}

/// The model of light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lighting {
    /// Lamps are points, and ambient light reaches everything: sharp shadows, no noise.
    #[default]
    Sharp,
    /// As `Sharp`, but lamps light all that faces them and mirrors show only the background: no shadows and no reflections, one ray
    /// for each sample. For pictures that must be made at once, such as those while a view is turned.
    Plain,
    /// Lamps have a size, and ambient light comes from the sky, so that corners are darker. Each sample takes a random
    /// point of each lamp and of the sky, so a picture needs many samples: 32 or more.
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
    /// The direction from a point to the lamp. It is zero at the position of the lamp.
    pub fn direction_from(&self, point: Vec3) -> Vec3 {
        match self.source {
            Source::At(position) => position - point,
            Source::Toward(direction) => direction,
        }
    }

    /// The part of a ray in the direction from its origin to the lamp that is before the lamp.
    pub fn span(&self) -> Span {
        match self.source {
            Source::At(_) => Span::new(0.0, 1.0).unwrap_or(Span::FORWARD),
            Source::Toward(_) => Span::FORWARD,
        }
    }
}

/// The tangent of the angle that the radius of a soft lamp subtends, from every point.
const LAMP_SIZE: f64 = 0.045;

/// The direction to a sample point of a lamp, from the direction to its middle. The lengths are about the same.
pub fn sample_lamp(toward: Vec3, numbers: [f64; 2]) -> Vec3 {
    let (across, along) = toward.normalize_or_zero().any_orthonormal_pair();
    let [x, y] = disc(numbers);
    toward + (across * x + along * y) * (LAMP_SIZE * toward.length())
}

/// The direction to a sample point of the sky over a surface, with a density proportional to the cosine to the normal
/// (Malley: the points of a disc, raised to the hemisphere).
pub fn sample_sky(normal: Vec3, numbers: [f64; 2]) -> Vec3 {
    let (across, along) = normal.any_orthonormal_pair();
    let [x, y] = disc(numbers);
    across * x + along * y + normal * (1.0 - x * x - y * y).max(0.0).sqrt()
}

/// Maps a point of the unit square to the unit disc: equal areas to equal areas, and middle to middle.
fn disc(point: [f64; 2]) -> [f64; 2] {
    let [x, y] = point.map(|p| 2.0 * p - 1.0);
    if x == 0.0 && y == 0.0 {
        return [0.0; 2];
    }
    // Squares around the middle become circles (Shirley and Chiu 1997).
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    [radius * angle.cos(), radius * angle.sin()]
}

impl Lights {
    /// Checks the lights of a scene; a scene without any gets [`automatic`] ones.
    ///
    /// # Errors
    /// The first [`LightError`], with the index of the light.
    pub fn new(lights: &[Light], view: &View) -> Result<Lights, (usize, LightError)> {
        if lights.is_empty() {
            return Lights::new(&automatic(view), view);
        }
        let mut out = Lights::default();
        for (index, light) in lights.iter().enumerate() {
            out.add(light).map_err(|error| (index, error))?;
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

/// The lights of a scene without any: a warm lamp far away to the upper left behind the camera, a fainter one at the
/// eye, whose shadows are hidden behind the objects that cast them, and some cool ambient light.
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
        // Half of the area of the disc is within a radius of sqrt(1/2).
        let inner = radii.iter().filter(|r| **r < 0.5f64.sqrt()).count() as f64 / radii.len() as f64;
        assert!((inner - 0.5).abs() < 0.02, "{inner}");
        assert_eq!(disc([0.5, 0.5]), [0.0, 0.0]);
    }

    fn error(light: Light) -> LightError {
        Lights::default().add(&light).unwrap_err()
    }

    #[test]
    fn invalid_lights_are_errors() {
        let light = |source| Light { source, color: None, intensity: None };
        assert_eq!(error(light(LightSource::Directional(Vec3::ZERO))), LightError::Direction);
        assert_eq!(error(light(LightSource::Point(Vec3::NAN))), LightError::Point);
        let negative = Light { intensity: Some(-1.0), ..light(LightSource::Ambient) };
        assert_eq!(error(negative), LightError::Intensity(-1.0));
    }
}

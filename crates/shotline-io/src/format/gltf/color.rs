//! Colours: linear in glTF, sRGB in scenes.
//!
//! Pictures use the curve too, and have their own: here `libm` gives a file the same bits on every machine, there the power
//! of the machine, which is faster, is taken for each pixel and rounded to a byte.

/// The sRGB value of a linear one (IEC 61966-2-1), from 0 to 1.
pub(super) fn srgb(linear: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * libm::pow(x, 1.0 / 2.4) - 0.055 }
}

/// The linear value of an sRGB one, from 0 to 1.
pub(super) fn linear(srgb: f64) -> f64 {
    let x = srgb.clamp(0.0, 1.0);
    if x <= 0.040_45 { x / 12.92 } else { libm::pow((x + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::{linear, srgb};

    #[test]
    fn colours_come_back() {
        for step in 0..=255 {
            let x = f64::from(step) / 255.0;
            assert!((srgb(linear(x)) - x).abs() < 1e-7, "{x}");
        }
    }

    #[test]
    fn colours_are_those_of_the_standard() {
        assert_eq!((srgb(0.0), srgb(-1.0)), (0.0, 0.0));
        assert!((srgb(1.0) - 1.0).abs() < 1e-15 && (srgb(7.0) - 1.0).abs() < 1e-15);
        // A grey of 128 of 255 in sRGB is 0.2158605 of the light.
        assert!((srgb(0.215_860_5) - 128.0 / 255.0).abs() < 1e-6);
        assert!((srgb(0.003_130_8) - 0.040_449_9).abs() < 1e-6);
    }
}

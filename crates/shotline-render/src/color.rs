//! Colours: scenes give sRGB from 0 to 1; light is summed in linear values.

use shotline::math::Vec3;

/// A linear colour: red, green and blue in `x`, `y` and `z`.
pub type Rgb = Vec3;

/// The linear value of one sRGB channel (IEC 61966-2-1).
pub fn decode(srgb: f64) -> f64 {
    if srgb <= 0.04045 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB value of one linear channel, clamped to 0 and 1.
pub fn encode(linear: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The linear colour of an sRGB one.
pub fn linear(srgb: [f64; 3]) -> Rgb {
    Vec3::from(srgb.map(decode))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_comes_back() {
        for byte in 0..=255u8 {
            let back = encode(decode(f64::from(byte) / 255.0)) * 255.0;
            assert_eq!(back.round() as u8, byte);
        }
    }
}

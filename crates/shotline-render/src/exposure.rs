//! The samples of pixels, before they become a picture.

use shotline::math::Vec3;

use crate::color::Rgb;

/// The value of a ray, or the mean over the rays of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The value that the look computes, in most looks a linear colour. It is already multiplied by `alpha`.
    pub color: Rgb,
    /// The fraction of the background that is covered.
    pub alpha: f64,
    /// The fraction that is covered by lines, which are drawn over the colour when the picture is developed.
    pub ink: f64,
}

impl Sample {
    /// The background alone.
    pub const NOTHING: Sample = Sample { color: Vec3::ZERO, alpha: 0.0, ink: 0.0 };

    /// Adds a colour that covers a share of the background.
    pub(crate) fn add(&mut self, color: Rgb, weight: f64) {
        self.color += color * weight;
        self.alpha += weight;
    }

    /// A sample that covers the background.
    pub fn opaque(color: Rgb) -> Sample {
        Sample { color, alpha: 1.0, ink: 0.0 }
    }
}

/// Exposed rows of a film: the mean of each pixel's samples, row by row from the top.
#[derive(Clone, Debug)]
pub struct Exposure {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The mean sample of each pixel.
    pub samples: Vec<Sample>,
}

impl Exposure {
    /// Sets the colour of a pixel, if it is in the picture.
    pub fn set(&mut self, column: u32, row: u32, color: Rgb) {
        if column < self.width && row < self.height {
            let index = row as usize * self.width as usize + column as usize;
            self.samples[index] = Sample::opaque(color);
        }
    }
}

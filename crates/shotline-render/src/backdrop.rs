//! What is behind everything.

use crate::color::{self, Rgb};

/// What a picture shows where there is nothing. Colours are sRGB from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backdrop {
    /// Nothing: the picture has an alpha channel.
    Transparent,
    /// A vertical gradient.
    Gradient {
        /// The colour at the top of the picture.
        top: [f64; 3],
        /// The colour at its bottom.
        bottom: [f64; 3],
    },
}

impl Backdrop {
    /// A quiet sky, the backdrop of most looks.
    pub const STUDIO: Backdrop = Backdrop::Gradient { top: [0.70, 0.76, 0.82], bottom: [0.95, 0.95, 0.94] };
    /// Plain white.
    pub const WHITE: Backdrop = Backdrop::plain([1.0; 3]);
    /// Plain black.
    pub const BLACK: Backdrop = Backdrop::plain([0.0; 3]);

    /// One colour.
    pub const fn plain(color: [f64; 3]) -> Backdrop {
        Backdrop::Gradient { top: color, bottom: color }
    }

    /// The linear colour at a height from 0, the bottom of the picture, to 1; `None` where transparent.
    pub fn color(&self, height: f64) -> Option<Rgb> {
        match *self {
            Backdrop::Transparent => None,
            Backdrop::Gradient { top, bottom } => {
                let (top, bottom) = (color::linear(top), color::linear(bottom));
                Some(bottom + (top - bottom) * height.clamp(0.0, 1.0))
            }
        }
    }
}

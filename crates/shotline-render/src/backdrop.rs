//! What is behind everything.

use std::str::FromStr;

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

/// A text that names no backdrop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected studio, white, black, transparent or a colour such as #336699")]
pub struct UnknownBackdrop;

impl FromStr for Backdrop {
    type Err = UnknownBackdrop;

    /// `studio`, `white`, `black`, `transparent`, or a colour as `#RRGGBB`.
    fn from_str(text: &str) -> Result<Backdrop, UnknownBackdrop> {
        let hex = |digits: &str| {
            let part = |i| digits.get(i..i + 2).and_then(|pair| u8::from_str_radix(pair, 16).ok());
            let color = [part(0)?, part(2)?, part(4)?];
            (digits.len() == 6).then(|| Backdrop::plain(color.map(|byte| f64::from(byte) / 255.0)))
        };
        match text {
            "studio" => Some(Backdrop::STUDIO),
            "white" => Some(Backdrop::WHITE),
            "black" => Some(Backdrop::BLACK),
            "transparent" => Some(Backdrop::Transparent),
            _ => text.strip_prefix('#').and_then(hex),
        }
        .ok_or(UnknownBackdrop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read() {
        assert_eq!("white".parse(), Ok(Backdrop::WHITE));
        assert_eq!("#ff0000".parse(), Ok(Backdrop::plain([1.0, 0.0, 0.0])));
        for wrong in ["#ff00", "#ff00000", "#é0000", "red"] {
            assert_eq!(wrong.parse::<Backdrop>(), Err(UnknownBackdrop));
        }
    }
}

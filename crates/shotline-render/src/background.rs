//! The background of a picture.

use std::str::FromStr;

use crate::color::{self, Rgb};

/// What a picture shows where rays meet nothing. Colours are sRGB from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// No colour: the picture has an alpha channel.
    Transparent,
    /// A vertical gradient.
    Gradient {
        /// The colour at the top of the picture.
        top: [f64; 3],
        /// The colour at its bottom.
        bottom: [f64; 3],
    },
}

impl Background {
    /// A soft sky, the background of the look `lit`.
    pub const STUDIO: Background =
        Background::Gradient { top: [0.70, 0.76, 0.82], bottom: [0.95, 0.95, 0.94] };
    /// Plain white.
    pub const WHITE: Background = Background::plain([1.0; 3]);
    /// Plain black.
    pub const BLACK: Background = Background::plain([0.0; 3]);

    /// One colour.
    pub const fn plain(color: [f64; 3]) -> Background {
        Background::Gradient { top: color, bottom: color }
    }

    /// The linear colour at a height from 0, the bottom of the picture, to 1; `None` where transparent.
    pub fn color(&self, height: f64) -> Option<Rgb> {
        match *self {
            Background::Transparent => None,
            Background::Gradient { top, bottom } => {
                let (top, bottom) = (color::linear(top), color::linear(bottom));
                Some(bottom + (top - bottom) * height.clamp(0.0, 1.0))
            }
        }
    }
}

/// The text does not name a background.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected studio, white, black, transparent or a colour such as #336699")]
pub struct UnknownBackground;

impl FromStr for Background {
    type Err = UnknownBackground;

    /// `studio`, `white`, `black`, `transparent`, or a colour as `#RRGGBB`.
    fn from_str(text: &str) -> Result<Background, UnknownBackground> {
        let hex = |digits: &str| {
            let byte = |i| digits.get(i..i + 2).and_then(|pair| u8::from_str_radix(pair, 16).ok());
            let color = [byte(0)?, byte(2)?, byte(4)?];
            (digits.len() == 6).then(|| Background::plain(color.map(|channel| f64::from(channel) / 255.0)))
        };
        match text {
            "studio" => Some(Background::STUDIO),
            "white" => Some(Background::WHITE),
            "black" => Some(Background::BLACK),
            "transparent" => Some(Background::Transparent),
            _ => text.strip_prefix('#').and_then(hex),
        }
        .ok_or(UnknownBackground)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read() {
        assert_eq!("white".parse(), Ok(Background::WHITE));
        assert_eq!("#ff0000".parse(), Ok(Background::plain([1.0, 0.0, 0.0])));
        for wrong in ["#ff00", "#ff00000", "#é0000", "red"] {
            assert_eq!(wrong.parse::<Background>(), Err(UnknownBackground));
        }
    }
}

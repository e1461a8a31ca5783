//! Animated PNG.

use ::png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};

use crate::image::Image;

/// A writer of an animated PNG, which browsers show. Frames are added one after the other; viewers repeat them forever.
pub struct Movie<'a> {
    writer: ::png::Writer<&'a mut Vec<u8>>,
}

impl<'a> Movie<'a> {
    /// Begins a movie of `frames` frames at `fps` frames per second. All have the size and the channels of the first.
    ///
    /// # Errors
    /// The encoder's error if a number is out of range, such as zero frames.
    pub fn new(
        out: &'a mut Vec<u8>,
        first: &Image,
        frames: u32,
        fps: u16,
    ) -> Result<Movie<'a>, EncodingError> {
        let mut encoder = encoder(out, first);
        encoder.set_animated(frames, 0)?;
        encoder.set_frame_delay(1, fps)?;
        Ok(Movie { writer: encoder.write_header()? })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// The encoder's error for a frame of another size, or for one frame too many.
    pub fn add(&mut self, image: &Image) -> Result<(), EncodingError> {
        self.writer.write_image_data(&image.to_bytes())
    }

    /// Ends the movie.
    ///
    /// # Errors
    /// The encoder's error if there are too few frames.
    pub fn finish(self) -> Result<(), EncodingError> {
        self.writer.finish()
    }
}

/// An encoder of eight-bit sRGB.
fn encoder<'a>(out: &'a mut Vec<u8>, image: &Image) -> Encoder<'a, &'a mut Vec<u8>> {
    let mut encoder = Encoder::new(out, image.width(), image.height());
    encoder.set_color(if image.channels() == 4 { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder
}

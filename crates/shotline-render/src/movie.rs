//! Moving pictures as animated PNG.

use ::png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};

use crate::image::Image;

/// A moving picture as an animated PNG, which browsers show; frame after frame is added, and repeated without end.
pub struct Movie<'a> {
    writer: ::png::Writer<&'a mut Vec<u8>>,
}

impl<'a> Movie<'a> {
    /// Begins a movie of so many frames, each the size and kind of the first, so many a second.
    ///
    /// # Errors
    /// What the encoder says of impossible numbers, such as no frames.
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
    /// What the encoder says of a frame of another size, or of one too many.
    pub fn add(&mut self, image: &Image) -> Result<(), EncodingError> {
        self.writer.write_image_data(&image.to_bytes())
    }

    /// Ends the movie.
    ///
    /// # Errors
    /// What the encoder says of too few frames.
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

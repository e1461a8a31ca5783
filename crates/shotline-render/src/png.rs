//! Pictures as PNG.

use ::png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};

use crate::image::Image;

/// The picture as an eight-bit sRGB PNG, with alpha if its backdrop is transparent.
///
/// The bytes are complete, so that a caller can write the file whole or not at all.
pub fn encode_png(image: &Image) -> Vec<u8> {
    let mut out = Vec::new();
    let encoder = encoder(&mut out, image);
    // An image has at least one pixel and as many bytes as its size says, and memory does not fail to write.
    let mut writer = encoder.write_header().expect("an image has a size that PNG takes");
    writer.write_image_data(&image.to_bytes()).expect("an image has the bytes of its size");
    writer.finish().expect("a PNG in memory ends");
    out
}

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

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use shotline::math::Vec3;

    use super::*;
    use crate::backdrop::Backdrop;
    use crate::film::{Exposure, Sample};

    fn decoded(image: &Image) -> (ColorType, Vec<u8>) {
        let mut reader = ::png::Decoder::new(Cursor::new(encode_png(image))).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height, info.bit_depth), (2, 1, BitDepth::Eight));
        (info.color_type, bytes)
    }

    #[test]
    fn png_decodes_back() {
        let half = Sample { color: Vec3::new(0.5, 0.0, 0.0), alpha: 0.5 };
        let exposure = Exposure { width: 2, height: 1, samples: vec![half, Sample::NOTHING] };
        let opaque = Image::compose(&exposure, Backdrop::WHITE);
        assert_eq!(decoded(&opaque), (ColorType::Rgb, vec![255, 188, 188, 255, 255, 255]));
        let clear = Image::compose(&exposure, Backdrop::Transparent);
        assert_eq!(decoded(&clear), (ColorType::Rgba, vec![255, 0, 0, 128, 0, 0, 0, 0]));
    }
}

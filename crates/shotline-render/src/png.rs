//! Pictures as PNG.

use std::collections::HashMap;

use ::png::{BitDepth, ColorType, Encoder, EncodingError, Filter, SrgbRenderingIntent};

use crate::image::Image;

/// The picture as an eight-bit sRGB PNG, with alpha if its background is transparent. Pictures of few colours, such as
/// heat maps, have a palette and take half the bytes.
///
/// The bytes are complete, so that a caller can write the file atomically.
pub fn encode_png(image: &Image) -> Vec<u8> {
    // An image has at least one pixel and as many bytes as its size needs, and writing to memory does not fail.
    encode_bytes(image.width(), image.height(), image.to_bytes()).expect("an image has the bytes of its size")
}

/// The PNG of eight-bit sRGB pixels, row by row from the top: 3 bytes each, or 4 with alpha.
///
/// # Errors
/// If there are no pixels, or if they do not have 3 or 4 bytes each.
pub fn encode_bytes(width: u32, height: u32, mut bytes: Vec<u8>) -> Result<Vec<u8>, EncodingError> {
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, width, height);
    if bytes.len() as u64 == u64::from(width) * u64::from(height) * 4 {
        encoder.set_color(ColorType::Rgba);
    } else if let Some(Indexed { palette, indices }) = Indexed::new(&bytes) {
        encoder.set_color(ColorType::Indexed);
        encoder.set_palette(palette);
        encoder.set_filter(Filter::NoFilter);
        bytes = indices;
    } else {
        encoder.set_color(ColorType::Rgb);
    }
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(out)
}

/// A picture of at most 256 colours.
struct Indexed {
    palette: Vec<u8>,
    indices: Vec<u8>,
}

impl Indexed {
    /// From red, green, blue for each pixel; `None` if there are more colours.
    fn new(bytes: &[u8]) -> Option<Indexed> {
        let (mut palette, mut known) = (Vec::new(), HashMap::new());
        let index = |color| {
            *known.entry(color).or_insert_with(|| {
                palette.extend_from_slice(color);
                palette.len() / 3 - 1
            })
        };
        let indices: Result<_, _> = bytes.chunks_exact(3).map(index).map(u8::try_from).collect();
        Some(Indexed { indices: indices.ok()?, palette })
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use shotline::math::Vec3;

    use super::*;
    use crate::background::Background;
    use crate::exposure::{Exposure, Sample};

    fn decoded(image: &Image) -> (ColorType, Vec<u8>) {
        let mut decoder = ::png::Decoder::new(Cursor::new(encode_png(image)));
        decoder.set_transformations(::png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(
            (info.width, info.height, info.bit_depth),
            (image.width(), image.height(), BitDepth::Eight)
        );
        (info.color_type, bytes)
    }

    #[test]
    fn png_decodes_back() {
        let half = Sample { color: Vec3::new(0.5, 0.0, 0.0), alpha: 0.5, ink: 0.0 };
        let exposure = Exposure { width: 2, height: 1, samples: vec![half, Sample::NOTHING] };
        let opaque = Image::compose(&exposure, Background::WHITE);
        assert_eq!(decoded(&opaque), (ColorType::Rgb, vec![255, 188, 188, 255, 255, 255]));
        let many = |n: u32| {
            let sample =
                |i: u32| Sample::opaque(Vec3::new(f64::from(i % 16) / 15.0, f64::from(i / 16) / 17.0, 0.0));
            let exposure = Exposure { width: n, height: 1, samples: (0..n).map(sample).collect() };
            Image::compose(&exposure, Background::BLACK)
        };
        for n in [255, 256, 257] {
            assert_eq!(decoded(&many(n)), (ColorType::Rgb, many(n).to_bytes()), "{n} colours");
        }
        let clear = Image::compose(&exposure, Background::Transparent);
        assert_eq!(decoded(&clear), (ColorType::Rgba, vec![255, 0, 0, 128, 0, 0, 0, 0]));
    }
}

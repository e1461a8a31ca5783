//! Pictures as JPEG.

use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

use crate::image::Image;

/// The quality of the encoder from 1 to 100: so high that the edges of lines and letters stay clean.
const QUALITY: u8 = 92;

/// Why a picture cannot be a JPEG, and how to correct that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JpegError {
    /// The background is transparent.
    #[error("JPEG has no transparent background: write a PNG (.png), or choose a colour for the background")]
    Transparent,
    /// The picture has no pixels, or too many.
    #[error(
        "a JPEG of {width}x{height} pixels: each side must be from 1 to {}; write a PNG (.png), or make the picture smaller",
        u16::MAX
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// The pixels do not have three bytes each.
    #[error("the pixels of a JPEG have three bytes each")]
    Channels,
}

/// The picture as an eight-bit sRGB JPEG, with all of its colours at full resolution.
///
/// # Errors
/// [`JpegError`].
pub fn encode_jpeg(image: &Image) -> Result<Vec<u8>, JpegError> {
    encode_jpeg_bytes(image.width(), image.height(), &image.to_bytes())
}

/// The JPEG of eight-bit sRGB pixels, row by row from the top: 3 bytes each.
///
/// # Errors
/// [`JpegError`], also for pixels of 4 bytes, which are transparent.
pub fn encode_jpeg_bytes(width: u32, height: u32, bytes: &[u8]) -> Result<Vec<u8>, JpegError> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels > 0 && bytes.len() as u64 == pixels * 4 {
        return Err(JpegError::Transparent);
    }
    if bytes.len() as u64 != pixels * 3 {
        return Err(JpegError::Channels);
    }
    let size = JpegError::Size { width, height };
    let side = |side: u32| u16::try_from(side).ok().filter(|side| *side > 0).ok_or(size);
    let (across, down) = (side(width)?, side(height)?);
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, QUALITY);
    encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
    encoder.set_optimized_huffman_tables(true);
    // Writing to memory does not fail, and the size has been checked.
    encoder.encode(bytes, across, down, ColorType::Rgb).map_err(|_| size)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::background::Background;
    use crate::exposure::{Exposure, Sample};

    /// The height and the width in the frame header.
    fn size(jpeg: &[u8]) -> Option<[u16; 2]> {
        let at = jpeg.windows(2).position(|marker| marker == [0xFF, 0xC0])? + 5;
        let number = |at: usize| u16::from_be_bytes([jpeg[at], jpeg[at + 1]]);
        Some([number(at), number(at + 2)])
    }

    #[test]
    fn jpegs_have_the_size_of_the_picture() {
        let exposure = Exposure { width: 33, height: 9, samples: vec![Sample::NOTHING; 33 * 9] };
        let jpeg = encode_jpeg(&Image::compose(&exposure, Background::WHITE)).unwrap();
        assert!(jpeg.starts_with(&[0xFF, 0xD8]) && jpeg.ends_with(&[0xFF, 0xD9]));
        assert_eq!(size(&jpeg), Some([9, 33]));
        let transparent = Image::compose(&exposure, Background::Transparent);
        assert_eq!(encode_jpeg(&transparent), Err(JpegError::Transparent));
    }

    #[test]
    fn wrong_sizes_are_errors() {
        assert_eq!(encode_jpeg_bytes(0, 5, &[]), Err(JpegError::Size { width: 0, height: 5 }));
        let wide = encode_jpeg_bytes(65_536, 1, &[0; 3 * 65_536]);
        assert!(wide.unwrap_err().to_string().contains("from 1 to 65535"));
        assert_eq!(encode_jpeg_bytes(2, 2, &[0; 11]), Err(JpegError::Channels));
    }
}

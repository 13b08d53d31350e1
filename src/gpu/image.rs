//! Pictures as PNG files.

use glam::UVec2;

use super::legend::add_legend;
use super::{Camera, Gpu, Renderer, Scene, SceneOptions, View};
use crate::error::{ErrorCode, UserError};

/// Largest side of a picture that may be asked for, pixels.
pub const MAX_SIDE: u32 = 8192;

/// Why a picture could not be encoded.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The number of bytes does not fit the size.
    #[error("{width} × {height} pixels need {expected} bytes, not {got}")]
    Size {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// 4 · width · height.
        expected: usize,
        /// Bytes given.
        got: usize,
    },
    /// The encoder failed.
    #[error("cannot encode the picture: {0}")]
    Encode(#[from] png::EncodingError),
}

impl From<ImageError> for UserError {
    fn from(error: ImageError) -> Self {
        Self::new(ErrorCode::Picture, error.to_string(), "")
    }
}

/// Encodes 8-bit RGBA rows, top row first, as a PNG file in memory, so that the caller can write it
/// atomically.
///
/// # Errors
/// [`ImageError::Size`] when `rgba` does not have 4 · `width` · `height` bytes; [`ImageError::Encode`] when
/// the encoder fails, as it does for a side of 0.
pub fn encode_png(width: u32, height: u32, rgba: &[u8]) -> Result<Vec<u8>, ImageError> {
    let expected = width as usize * height as usize * 4;
    if rgba.len() != expected {
        return Err(ImageError::Size { width, height, expected, got: rgba.len() });
    }
    let mut file = Vec::with_capacity(expected / 4 + 1024);
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgba)?;
    writer.finish()?;
    Ok(file)
}

/// One picture of a scene as a PNG file in memory, with its colour scale if `legend`.
///
/// # Errors
/// When the device or the encoder fails.
pub fn draw_png(
    gpu: &Gpu,
    renderer: &mut Renderer,
    scene: &Scene,
    view: View,
    options: &SceneOptions,
    size: UVec2,
    legend: bool,
) -> Result<Vec<u8>, UserError> {
    let camera = Camera::standard(view, scene.framing(), size.x as f32 / size.y as f32);
    renderer.render(gpu, scene, &camera, options, size, 4);
    let mut picture = renderer.read_rgba(gpu)?;
    if legend {
        add_legend(&mut picture, options);
    }
    Ok(encode_png(picture.width, picture.height, &picture.rgba)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_survives_encoding() {
        let rgba: Vec<u8> = (0..5 * 3 * 4).map(|i| (i * 7) as u8).collect();
        let file = encode_png(5, 3, &rgba).expect("fits");
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("is a PNG");
        let mut back = vec![0; reader.output_buffer_size().expect("fits")];
        let info = reader.next_frame(&mut back).expect("has a frame");
        assert_eq!((info.width, info.height), (5, 3));
        assert_eq!(back, rgba);
    }

    #[test]
    fn a_wrong_number_of_bytes_is_refused() {
        let error = encode_png(2, 2, &[0; 15]).unwrap_err();
        assert!(matches!(error, ImageError::Size { expected: 16, got: 15, .. }), "{error}");
        assert_eq!(UserError::from(error).code, ErrorCode::Picture);
    }
}

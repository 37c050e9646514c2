//! Pictures of quad meshes as PNG files.

use crate::engine::quad::QuadMesh;
use crate::engine::render::{RenderOptions, render_quads};

/// A square picture of the quads, `size` pixels wide (clamped to 16 to 4096), as the bytes of a PNG file. The same
/// quads give the same bytes.
///
/// # Errors
/// Only what the encoder reports; it writes to memory.
pub fn preview_png(quads: &QuadMesh, size: usize) -> Result<Vec<u8>, png::EncodingError> {
    let image = render_quads(quads, &RenderOptions { width: size, height: size, ..RenderOptions::default() });
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&image.rgba)?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn the_file_is_read_back_to_the_same_picture() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let quads = QuadMesh { positions, quads: vec![[0, 1, 2, 3]] };
        let bytes = preview_png(&quads, 64).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (64, 64));
        let options = RenderOptions { width: 64, height: 64, ..RenderOptions::default() };
        assert_eq!(pixels, render_quads(&quads, &options).rgba);
    }
}

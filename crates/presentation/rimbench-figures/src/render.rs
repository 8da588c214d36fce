//! Writes a drawing to disk: as SVG, and as PNG for the preview, which services that show links cannot read as SVG.

use std::io::Write;
use std::path::Path;

use super::drawing::Drawing;
use super::paint::{self, Pixels};
pub use super::vector::{svg, write};
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;

/// Writes an image of pixels, `scale` of them per px of the SVG.
///
/// # Errors
/// [`Error::File`] if it cannot be written.
pub fn write_png(drawing: &Drawing, path: &Path, scale: f64) -> Result<()> {
    let undrawn = |message: String| Error::file(path, format!("cannot write the figure: {message}"));
    let pixels = paint::pixels(drawing, scale).map_err(undrawn)?;
    write_atomically(path, |file| encode(&pixels, file).map_err(std::io::Error::other))
}

/// Encodes pixels as PNG, quickly: the file is some tenths larger than it could be.
fn encode(pixels: &Pixels, file: &mut dyn Write) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(file, pixels.width as u32, pixels.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::FilterType::Sub);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels.rgb)?;
    writer.finish()
}

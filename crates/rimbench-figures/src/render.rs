//! Writes a drawing to disk as SVG; as PNG for the preview, which services that show links cannot read as SVG.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::drawing::Drawing;
use super::paint::{self, Pixels};
use super::vector;
pub use super::vector::svg;
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;

/// Writes `<name>.svg` into a folder that exists, whole or not at all, and returns where. The bytes depend on the drawing only.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written to.
pub fn write(drawing: &Drawing, folder: &Path, name: &str) -> Result<PathBuf> {
    let path = folder.join(format!("{name}.svg"));
    write_atomically(&path, |file| file.write_all(vector::svg(drawing).as_bytes()))?;
    Ok(path)
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_is_not_there_is_an_error_that_names_the_file() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let missing = place.path().join("missing");
        let error = write(&Drawing::new(20.0, 10.0), &missing, "force").unwrap_err();
        assert!(matches!(&error, Error::File { path, .. } if *path == missing.join("force.svg")), "{error}");
    }
}

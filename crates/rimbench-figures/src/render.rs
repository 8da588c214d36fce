//! Writes a drawing to disk, as SVG for the report and as PNG for everything that cannot show SVG.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::drawing::Drawing;
use super::paint::{self, Pixels};
use super::vector;
pub use super::vector::svg;
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;

/// Pixels of the PNG per px of the SVG: 288 per inch.
pub const PNG_SCALE: f64 = 3.0;

/// Where a figure was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FigureFiles {
    /// The vector image.
    pub svg: PathBuf,
    /// The pixel image, 288 pixels per inch of the vector image.
    pub png: PathBuf,
}

/// Writes `<name>.svg` and `<name>.png` into a folder that exists, each whole or not at all. The bytes depend on the drawing only.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written to.
pub fn write(drawing: &Drawing, folder: &Path, name: &str) -> Result<FigureFiles> {
    let files = FigureFiles { svg: folder.join(format!("{name}.svg")), png: folder.join(format!("{name}.png")) };
    let svg = vector::svg(drawing);
    write_atomically(&files.svg, |file| file.write_all(svg.as_bytes()))?;
    write_png(drawing, &files.png, PNG_SCALE)?;
    Ok(files)
}

/// Writes the pixel image alone.
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

    #[test]
    fn nothing_but_the_two_files_is_left_behind() {
        let place = tempfile::tempdir().expect("a temporary folder");
        write(&Drawing::new(20.0, 10.0), place.path(), "empty").expect("a writable folder");
        let entries = std::fs::read_dir(place.path()).expect("a folder");
        let mut names: Vec<_> = entries.map(|entry| entry.expect("an entry").file_name()).collect();
        names.sort();
        assert_eq!(names, ["empty.png", "empty.svg"]);
    }
}

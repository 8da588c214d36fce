//! Writes a drawing to disk, as SVG for the report and as PNG for everything that cannot show SVG.

use std::fs;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use super::drawing::Drawing;
use super::paint::{self, Pixels};
use rimbench_core::error::{Error, Result};

/// Pixels of the PNG per px of the SVG.
pub const PNG_SCALE: f64 = 2.0;

/// Where a figure was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FigureFiles {
    /// The vector image.
    pub svg: PathBuf,
    /// The pixel image, twice the size of the vector image.
    pub png: PathBuf,
}

/// Writes `<name>.svg` and `<name>.png` into a folder that exists.
///
/// Each file is first written under a temporary name beside its final one and then renamed, so that a reader never
/// sees half a figure. The bytes depend on the drawing only.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written to.
pub fn write(drawing: &Drawing, folder: &Path, name: &str) -> Result<FigureFiles> {
    let files = FigureFiles { svg: folder.join(format!("{name}.svg")), png: folder.join(format!("{name}.png")) };
    put(&files.svg, "svg", |path| fs::write(path, paint::svg(drawing)?).map_err(|error| error.to_string()))?;
    put(&files.png, "png", |path| encode(&paint::pixels(drawing, PNG_SCALE)?, path))?;
    Ok(files)
}

/// Lets `write` fill a temporary file, then gives it its name.
fn put(path: &Path, extension: &str, write: impl FnOnce(&Path) -> Result<(), String>) -> Result<()> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".{stem}.{}.partial.{extension}", std::process::id()));
    let written = write(&partial).and_then(|()| fs::rename(&partial, path).map_err(|error| error.to_string()));
    written.map_err(|message| {
        let _ = fs::remove_file(&partial);
        Error::file(path, format!("cannot write the figure: {message}"))
    })
}

/// Encodes pixels as PNG, quickly: the file is some tenths larger than it could be.
fn encode(pixels: &Pixels, path: &Path) -> Result<(), String> {
    let file = BufWriter::new(fs::File::create(path).map_err(|error| error.to_string())?);
    let mut encoder = png::Encoder::new(file, pixels.width as u32, pixels.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::FilterType::Sub);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    let mut writer = encoder.write_header().map_err(|error| error.to_string())?;
    writer.write_image_data(&pixels.rgb).map_err(|error| error.to_string())?;
    writer.finish().map_err(|error| error.to_string())
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
        let entries = fs::read_dir(place.path()).expect("a folder");
        let mut names: Vec<_> = entries.map(|entry| entry.expect("an entry").file_name()).collect();
        names.sort();
        assert_eq!(names, ["empty.png", "empty.svg"]);
    }
}

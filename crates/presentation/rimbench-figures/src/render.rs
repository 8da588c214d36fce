//! Writes a drawing to disk: as SVG, as PNG by plotters, and as PDF, made of the SVG by svg2pdf in a build with the
//! feature `pdf`, which takes four minutes of a processor.

use std::io::Write;
use std::path::Path;

use super::drawing::Drawing;
use super::paint::{self, Pixels};
pub use super::vector::svg;
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;

/// What figures are written as, by the ends of files' names.
pub const FORMATS: [&str; 3] = ["svg", "png", "pdf"];
/// Pixels of a PNG per px of the SVG.
const PIXELS: f64 = 2.0;

/// Checks that a figure can be written into a file of this name.
///
/// # Errors
/// [`Error::File`] for a name that ends otherwise than [`FORMATS`], and for a PDF in a build without the feature.
pub fn check_format(path: &Path) -> Result<()> {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("svg" | "png") => Ok(()),
        Some("pdf") if cfg!(feature = "pdf") => Ok(()),
        Some("pdf") => {
            let text = "cannot be made: this rimbench was built without the feature `pdf`; valid: .svg or .png, or a build with `--features pdf`";
            Err(Error::file(path, text))
        }
        _ => Err(Error::file(path, "is no name of a figure: it must end in .svg, .png or .pdf")),
    }
}

/// Writes a drawing as its file's name says, whole or not at all. The bytes depend on the drawing only.
///
/// # Errors
/// Those of [`check_format`]; [`Error::File`] if it cannot be written.
pub fn write(drawing: &Drawing, path: &Path) -> Result<()> {
    check_format(path)?;
    let bytes = match path.extension().and_then(|extension| extension.to_str()) {
        Some("png") => return write_png(drawing, path, PIXELS),
        Some("pdf") => pdf(drawing).map_err(|why| Error::file(path, format!("cannot write the figure: {why}")))?,
        _ => svg(drawing).into_bytes(),
    };
    write_atomically(path, |file| file.write_all(&bytes))
}

/// The SVG as a PDF, its text as text in the embedded typeface.
#[cfg(feature = "pdf")]
fn pdf(drawing: &Drawing) -> Result<Vec<u8>, String> {
    use svg2pdf::{ConversionOptions, PageOptions, to_pdf, usvg};
    let mut options = usvg::Options::default();
    super::font::FACES.iter().for_each(|face| options.fontdb_mut().load_font_data(face.to_vec()));
    let light = svg(drawing).replace(super::vector::DARK, "");
    let tree = usvg::Tree::from_str(&light, &options).map_err(|error| error.to_string())?;
    to_pdf(&tree, ConversionOptions::default(), PageOptions { dpi: 96.0 }).map_err(|error| error.to_string())
}

#[cfg(not(feature = "pdf"))]
fn pdf(_: &Drawing) -> Result<Vec<u8>, String> {
    Err("no feature `pdf`".to_owned())
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

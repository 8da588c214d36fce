//! The embedded typeface: Inter (SIL Open Font License, see `font/LICENSE.txt`), regular and semi-bold.
//!
//! No system font is read, so a PNG looks the same on every machine. The text of an SVG stays text in a typeface that
//! the viewer has, and long texts are told their length. Layouts leave the slack that short ones need.

use std::sync::Once;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

const NAME: &str = "Inter";

/// Weight of the letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// Ordinary text.
    Regular,
    /// Titles.
    Bold,
}

/// Height of a capital letter, in em.
pub const CAP_HEIGHT: f64 = 2048.0 / 2816.0;

/// Ascender minus descender in em: what plotters calls the size of this font is this much larger than its em.
pub const LINE_HEIGHT: f64 = (2728.0 + 680.0) / 2816.0;

/// How much wider another typeface may be in which a viewer shows the text of an SVG.
pub const WIDER: f64 = 1.1;

/// Regular and semi-bold, as OpenType.
pub const FACES: [&[u8]; 2] = [include_bytes!("font/Inter-Regular.otf"), include_bytes!("font/Inter-SemiBold.otf")];

/// Makes the typeface known to plotters; only the first call does anything.
fn register() {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| {
        for (style, bytes) in [FontStyle::Normal, FontStyle::Bold].into_iter().zip(FACES) {
            assert!(register_font(NAME, style, bytes).is_ok(), "the embedded font is an OpenType file");
        }
    });
}

/// Gives the typeface in what plotters calls its size.
pub fn face(plotters_size: f64, weight: Weight) -> FontDesc<'static> {
    register();
    let style = match weight {
        Weight::Regular => FontStyle::Normal,
        Weight::Bold => FontStyle::Bold,
    };
    FontDesc::new(FontFamily::Name(NAME), plotters_size, style)
}

/// Measures the advance of a line of text in px; `size` is its em in px.
pub fn width(text: &str, size: f64, weight: Weight) -> f64 {
    const FINE: f64 = 1000.0; // plotters rounds to whole pixels
    let ((left, _), (right, _)) =
        face(FINE * LINE_HEIGHT, weight).layout_box(text).expect("the embedded font is registered");
    f64::from(right - left) / FINE * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_scale_with_the_size_and_semi_bold_is_wider() {
        let narrow = width("effective mass", 10.0, Weight::Regular);
        assert!((width("effective mass", 20.0, Weight::Regular) - 2.0 * narrow).abs() < 1e-9);
        assert!(width("effective mass", 10.0, Weight::Bold) > narrow);
    }

    #[test]
    fn the_signs_figures_need_are_in_the_font() {
        let missing = |c: char| {
            let mut ink = 0.0;
            let drawn = face(40.0, Weight::Regular).draw(&c.to_string(), (0, 0), |_, _, coverage| {
                ink += coverage;
                Ok::<(), std::convert::Infallible>(())
            });
            drawn.is_err() || ink == 0.0
        };
        let wanted = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻₀₁₂−×·±∞≤≥≈→αβγδλμρφωΔΩ°";
        assert_eq!(wanted.chars().filter(|&c| missing(c)).collect::<String>(), "");
    }
}

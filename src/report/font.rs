//! The embedded typeface: Inter (SIL Open Font License, see `font/LICENSE.txt`), regular and semi-bold.
//!
//! No system font is read, so a figure looks the same on every machine. The text of an SVG stays text; it names Inter
//! first and generic sans-serif families after it, and layouts leave the slack such a replacement needs.

use std::sync::Once;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

use super::drawing::Weight;

/// The families an SVG asks for, in order.
pub const SVG_FAMILY: &str = "Inter, 'Helvetica Neue', Helvetica, Arial, sans-serif";

/// Height of a capital letter, in em.
pub const CAP_HEIGHT: f64 = 2048.0 / 2816.0;

/// Ascender minus descender in em: what plotters calls the size of this font is this much larger than its em.
const LINE_HEIGHT: f64 = (2728.0 + 680.0) / 2816.0;

const NAME: &str = "rimbench-inter";

/// Makes the typeface known to plotters; only the first call does anything.
fn register() {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| {
        let faces: [(FontStyle, &'static [u8]); 2] = [
            (FontStyle::Normal, include_bytes!("font/Inter-Regular.otf")),
            (FontStyle::Bold, include_bytes!("font/Inter-SemiBold.otf")),
        ];
        for (style, bytes) in faces {
            assert!(register_font(NAME, style, bytes).is_ok(), "the embedded font is an OpenType file");
        }
    });
}

fn face(plotters_size: f64, weight: Weight) -> FontDesc<'static> {
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

/// Renders a line of text: calls `ink` with pixels relative to the start of its baseline (x to the right, y down) and
/// their coverage in [0, 1]. `size` is its em in px.
pub fn rasterise(text: &str, size: f64, weight: Weight, mut ink: impl FnMut(i32, i32, f64)) {
    // An even whole size: plotters puts the baseline at half of it and truncates.
    let even = 2.0 * (0.5 * size * LINE_HEIGHT).round().max(1.0);
    let baseline = (0.5 * even) as i32;
    let drawn = face(even, weight).draw(text, (0, 0), |x, y, coverage| {
        ink(x, y - baseline, f64::from(coverage));
        Ok::<(), std::convert::Infallible>(())
    });
    drawn.expect("the embedded font is registered").unwrap_or_else(|never| match never {});
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_em_of_the_text_is_the_size_asked_for() {
        let (mut top, mut bottom) = (i32::MAX, i32::MIN);
        rasterise("H", 200.0, Weight::Regular, |_, y, coverage| {
            if coverage > 0.5 {
                (top, bottom) = (top.min(y), bottom.max(y));
            }
        });
        let height = f64::from(bottom - top + 1);
        assert!((height - 200.0 * CAP_HEIGHT).abs() < 2.0, "capital {height} px high");
        assert_eq!(bottom, -1, "a capital stands on the baseline");
    }

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
            rasterise(&c.to_string(), 40.0, Weight::Regular, |_, _, coverage| ink += coverage);
            ink == 0.0
        };
        let wanted = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻₀₁₂−×·±∞≤≥≈→αβγδλμρφωΔΩ°";
        assert_eq!(wanted.chars().filter(|&c| missing(c)).collect::<String>(), "");
    }
}

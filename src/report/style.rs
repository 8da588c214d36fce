//! One colour, dash and marker per coupling scheme, the same in every figure.
//!
//! The colours are those of Okabe and Ito (safe for the common colour-vision deficiencies); dash and marker tell the
//! series apart in grey. A variant of a scheme (another force return, say) keeps the colour and changes dash and
//! marker. A name that is not in the list gets a style computed from its letters, so a user's scheme looks the same
//! today and tomorrow.

use super::drawing::{Color, Dash};

/// The sign at a data point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// Filled circle.
    Circle,
    /// Filled square.
    Square,
    /// Filled diamond.
    Diamond,
    /// Filled triangle, point down. (Point up is reserved for values beyond the axis.)
    Triangle,
    /// Filled pentagon.
    Pentagon,
    /// Filled star.
    Star,
    /// Upright cross.
    Plus,
    /// Diagonal cross.
    Cross,
    /// Open circle.
    OpenCircle,
    /// Open square.
    OpenSquare,
    /// Open diamond.
    OpenDiamond,
}

/// How one series is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesStyle {
    /// Colour of line and marker.
    pub color: Color,
    /// Dash pattern of the line.
    pub dash: Dash,
    /// Width of the line, px.
    pub width: f64,
    /// Sign at the data points.
    pub marker: Marker,
}

const SOLID: Dash = &[];
const LONG: Dash = &[14.0, 3.0];
const DASHED: Dash = &[7.0, 3.0];
const SHORT: Dash = &[4.0, 2.5];
const DOTTED: Dash = &[1.8, 2.2];
const DASH_DOT: Dash = &[8.0, 2.5, 1.8, 2.5];
const DASH_DOT_DOT: Dash = &[8.0, 2.5, 1.8, 2.5, 1.8, 2.5];

const FIXED: [(&str, SeriesStyle); 9] = [
    ("reference", entry(Color(0x00, 0x00, 0x00), SOLID, Marker::Circle)),
    ("zero-order-hold", entry(Color(0xE6, 0x9F, 0x00), SHORT, Marker::Square)),
    ("first-order-hold", entry(Color(0x56, 0xB4, 0xE9), DASH_DOT_DOT, Marker::Triangle)),
    ("second-order-hold", entry(Color(0xCC, 0x79, 0xA7), DOTTED, Marker::Pentagon)),
    ("rim-smooth", entry(Color(0xD5, 0x5E, 0x00), LONG, Marker::Diamond)),
    ("rim-smooth-active", entry(Color(0x8C, 0x3B, 0x0C), DASH_DOT, Marker::OpenDiamond)),
    ("rim-nonsmooth", entry(Color(0x00, 0x72, 0xB2), DASHED, Marker::Circle)),
    ("rim-nonsmooth-gap", entry(Color(0x00, 0x9E, 0x73), DASH_DOT, Marker::Square)),
    ("rim-fixed-mass", entry(Color(0x80, 0x80, 0x80), DOTTED, Marker::Cross)),
];

/// Dark enough for white paper and none of the fixed colours.
const SPARE_COLORS: [Color; 7] = [
    Color(0x88, 0x22, 0x55),
    Color(0x33, 0x22, 0x88),
    Color(0x99, 0x8A, 0x22),
    Color(0x11, 0x77, 0x33),
    Color(0xAA, 0x44, 0x99),
    Color(0x66, 0x11, 0x00),
    Color(0x4B, 0x6A, 0x88),
];
const SPARE_DASHES: [Dash; 5] = [DASHED, SHORT, DASH_DOT, DOTTED, LONG];
const SPARE_MARKERS: [Marker; 6] =
    [Marker::Star, Marker::Plus, Marker::Triangle, Marker::OpenCircle, Marker::OpenSquare, Marker::Pentagon];

const fn entry(color: Color, dash: Dash, marker: Marker) -> SeriesStyle {
    SeriesStyle { color, dash, width: 1.7, marker }
}

/// Finds the style of a scheme, of `reference`, or of any other name.
///
/// A variant may follow the scheme's name after `/`, `+`, `:`, `(` or a space, as in `rim-nonsmooth/profile`; see
/// [`style_of_variant`].
pub fn style_of(name: &str) -> SeriesStyle {
    let name = name.trim();
    match name.find(['/', '+', ':', '(', ' ']) {
        Some(end) if end > 0 => {
            style_of_variant(&name[..end], name[end..].trim_matches(|c: char| "/+:() ".contains(c)))
        }
        _ => FIXED.iter().find(|(fixed, _)| *fixed == name).map_or_else(|| spare(name), |(_, style)| *style),
    }
}

/// Finds the style of a scheme's variant: the scheme's colour with another dash and marker. A scheme's default force
/// return (`mean` with a reduced interface model, else `held`), and an empty variant, look like the scheme itself.
pub fn style_of_variant(scheme: &str, variant: &str) -> SeriesStyle {
    let base = style_of(scheme);
    let (dash, marker) = match variant {
        "" => return base,
        "mean" if scheme.starts_with("rim-") => return base,
        "held" if !scheme.starts_with("rim-") => return base,
        "mean" => (LONG, Marker::OpenSquare),
        "held" => (DOTTED, Marker::Triangle),
        "gauss-seidel" => (LONG, Marker::OpenSquare),
        "extrapolated" => (DOTTED, Marker::Triangle),
        "profile-extrapolated" => (DASH_DOT_DOT, Marker::OpenDiamond),
        "mean-5" => (SHORT, Marker::Plus),
        "mean-all" => (DASHED, Marker::Diamond),
        "profile-5" => (DASH_DOT, Marker::Star),
        "profile-10" => (DASHED, Marker::OpenDiamond),
        "profile-20" => (DOTTED, Marker::Pentagon),
        "profile" => (SOLID, Marker::OpenCircle),
        "end" => (DASHED, Marker::Cross),
        other => {
            let code = code_of(other);
            (pick(&SPARE_DASHES, code), pick(&SPARE_MARKERS, code / 64))
        }
    };
    SeriesStyle { dash, marker, ..base }
}

fn spare(name: &str) -> SeriesStyle {
    let code = code_of(name);
    entry(pick(&SPARE_COLORS, code), pick(&SPARE_DASHES, code / 64), pick(&SPARE_MARKERS, code / 4096))
}

fn pick<T: Copy>(list: &[T], code: u64) -> T {
    list[(code % list.len() as u64) as usize]
}

/// FNV-1a: the same on every machine and in every version.
fn code_of(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |code, byte| (code ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_styles_differ_without_colour() {
        for (index, (name, style)) in FIXED.iter().enumerate() {
            for (other, second) in &FIXED[..index] {
                assert!((style.dash, style.marker) != (second.dash, second.marker), "{name} and {other} in grey");
                assert_ne!(style.color, second.color, "{name} and {other}");
            }
        }
    }

    #[test]
    fn a_variant_keeps_the_colour_and_changes_dash_and_marker() {
        let (mean, profile) = (style_of("rim-nonsmooth"), style_of("rim-nonsmooth/profile"));
        assert_eq!(mean.color, profile.color);
        assert!(mean.dash != profile.dash && mean.marker != profile.marker);
        assert_eq!(style_of("rim-nonsmooth (mean)"), mean);
        assert_eq!(style_of_variant("rim-nonsmooth", "profile"), profile);
    }

    #[test]
    fn an_unknown_name_has_a_stable_style_of_its_own() {
        assert_eq!(style_of("my-scheme"), style_of("my-scheme"));
        assert!(FIXED.iter().all(|(_, style)| style.color != style_of("my-scheme").color));
    }
}

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

/// Schemes that cannot run in real time; the ceilings among them are grey.
const NOT_REAL_TIME: [&str; 3] = ["iterated-aitken", "iterated-quasi-newton", "monolithic"];

const FIXED: [(&str, SeriesStyle); 20] = [
    ("reference", entry(Color(0x00, 0x00, 0x00), SOLID, Marker::Circle)),
    ("zero-order-hold", entry(Color(0xE6, 0x9F, 0x00), SHORT, Marker::Square)),
    ("first-order-hold", entry(Color(0x56, 0xB4, 0xE9), DASH_DOT_DOT, Marker::Triangle)),
    ("second-order-hold", entry(Color(0xCC, 0x79, 0xA7), DOTTED, Marker::Pentagon)),
    ("rim-smooth", entry(Color(0xD5, 0x5E, 0x00), LONG, Marker::Diamond)),
    ("rim-smooth-active", entry(Color(0x8C, 0x3B, 0x0C), DASH_DOT, Marker::OpenDiamond)),
    ("rim-nonsmooth", entry(Color(0x00, 0x72, 0xB2), DASHED, Marker::Circle)),
    ("rim-nonsmooth-gap", entry(Color(0x00, 0x9E, 0x73), DASH_DOT, Marker::Square)),
    ("rim-fixed-mass", entry(Color(0x80, 0x80, 0x80), DOTTED, Marker::Cross)),
    ("interface-jacobian", entry(Color(0x7C, 0xA8, 0x1A), LONG, Marker::Star)),
    ("c1-extrapolated-interpolation", entry(Color(0x6A, 0x3D, 0x9A), DASH_DOT, Marker::Pentagon)),
    ("c1-extrapolated-interpolation-quadratic", entry(Color(0xA8, 0x7B, 0xD0), DASHED, Marker::Pentagon)),
    ("predicted-acceleration", entry(Color(0xC2, 0x18, 0x5B), LONG, Marker::Circle)),
    ("nepce", entry(Color(0x0E, 0x6E, 0x7C), SHORT, Marker::Triangle)),
    ("nepce-feedthrough", entry(Color(0x45, 0xB7, 0xC4), DASHED, Marker::Triangle)),
    ("energy-leak-damper", entry(Color(0x7A, 0x5C, 0x3E), SHORT, Marker::Plus)),
    ("transmission-line", entry(Color(0xB0, 0x8A, 0x00), DASH_DOT, Marker::Plus)),
    ("iterated-aitken", entry(Color(0x5A, 0x5A, 0x5A), DASHED, Marker::OpenCircle)),
    ("iterated-quasi-newton", entry(Color(0x9C, 0x9C, 0x9C), DOTTED, Marker::OpenCircle)),
    ("monolithic", entry(Color(0x2E, 0x2E, 0x2E), LONG, Marker::OpenCircle)),
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

/// What a legend or table says of a label: ceilings are marked as not real-time.
pub fn shown_name(label: &str) -> String {
    let scheme = label.split(['/', '+', ':', '(', ' ']).next().unwrap_or_default();
    if NOT_REAL_TIME.contains(&scheme) { format!("{label} (not real-time)") } else { label.to_owned() }
}

/// A style for the entry at `index` of a list that only grows, and whose names are no schemes: neighbours differ in colour,
/// dash and marker, and no two of the first 55 agree in both dash and marker.
pub fn style_in_list(index: usize) -> SeriesStyle {
    const COLORS: [Color; 8] = [
        Color(0x00, 0x72, 0xB2),
        Color(0xD5, 0x5E, 0x00),
        Color(0x00, 0x9E, 0x73),
        Color(0xCC, 0x79, 0xA7),
        Color(0x33, 0x22, 0x88),
        Color(0xE6, 0x9F, 0x00),
        Color(0x56, 0xB4, 0xE9),
        Color(0x80, 0x80, 0x80),
    ];
    const MARKERS: [Marker; 11] = [
        Marker::Circle,
        Marker::Square,
        Marker::OpenCircle,
        Marker::Diamond,
        Marker::Plus,
        Marker::Triangle,
        Marker::OpenSquare,
        Marker::Star,
        Marker::Cross,
        Marker::OpenDiamond,
        Marker::Pentagon,
    ];
    entry(COLORS[index % COLORS.len()], SPARE_DASHES[index % SPARE_DASHES.len()], MARKERS[index % MARKERS.len()])
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
    fn the_styles_of_a_list_differ_without_colour() {
        let pair = |index: usize| (style_in_list(index).dash, style_in_list(index).marker);
        assert!((0..55).all(|index| (0..index).all(|other| pair(index) != pair(other))));
        assert!((1..55).all(|index| style_in_list(index).color != style_in_list(index - 1).color));
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

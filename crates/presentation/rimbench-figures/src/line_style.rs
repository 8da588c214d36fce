//! Colour, dash and marker of each scheme, the same in every figure.

use super::drawing::{Color, DashPattern, Stroke};

/// Width of a line, px.
const WIDTH: f64 = 1.35;

/// Colour, dash and marker of one series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineStyle {
    /// Colour of line and marker.
    pub color: Color,
    /// Dash pattern of the line.
    pub dash: Dash,
    /// Sign at the data points.
    pub marker: Marker,
}

/// Dash pattern of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// No gaps.
    Solid,
    /// Long dashes.
    Long,
    /// Dashes.
    Dashed,
    /// Short dashes.
    Short,
    /// Dots.
    Dotted,
    /// Dash and dot.
    DashDot,
    /// Dash and two dots.
    DashDotDot,
}

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
    /// Triangle that points up: a value beyond the axis. Of no series, as are the next two.
    Beyond,
    /// Open triangle that points up: some runs lost.
    SomeLost,
    /// Dash: runs that gave no answer.
    Silent,
}

/// Names (those of the glossary) and styles of the built-in schemes. The colours begin with those of Okabe and Ito; all
/// stand out from white paper, and no two merge for readers with a common deficiency of colour vision (tests compute
/// both). Dash and marker tell the series apart in grey.
pub(super) const SCHEMES: [(&str, &str, LineStyle); 23] = [
    ("rim-smooth", "smooth model", LineStyle::new([0xD5, 0x5E, 0x00], Dash::Long, Marker::Diamond)),
    (
        "rim-smooth-active",
        "smooth model, loaded contacts",
        LineStyle::new([0x8C, 0x3B, 0x0C], Dash::DashDot, Marker::OpenDiamond),
    ),
    ("rim-nonsmooth", "non-smooth model", LineStyle::new([0x00, 0x72, 0xB2], Dash::Dashed, Marker::Circle)),
    ("rim-nonsmooth-gap", "gap tracking", LineStyle::new([0x00, 0x9E, 0x73], Dash::DashDot, Marker::Square)),
    ("rim-split", "split models", LineStyle::new([0x70, 0x20, 0xE8], Dash::Long, Marker::Square)),
    ("rim-answers", "answers", LineStyle::new([0x00, 0x7A, 0x5E], Dash::Short, Marker::Diamond)),
    ("rim-fixed-mass", "fixed-mass model", LineStyle::new([0x7B, 0x7D, 0x7F], Dash::Dotted, Marker::Cross)),
    ("zero-order-hold", "zero-order hold", LineStyle::new([0xA7, 0x73, 0x33], Dash::Short, Marker::Square)),
    ("first-order-hold", "first-order hold", LineStyle::new([0x0D, 0x9B, 0xE8], Dash::DashDotDot, Marker::Triangle)),
    ("second-order-hold", "second-order hold", LineStyle::new([0xB7, 0x66, 0x97], Dash::Dotted, Marker::Pentagon)),
    (
        "c1-extrapolated-interpolation",
        "C¹ extrapolation",
        LineStyle::new([0x60, 0x30, 0x8A], Dash::DashDot, Marker::Pentagon),
    ),
    ("true-acceleration", "true acceleration", LineStyle::new([0xB4, 0x29, 0x59], Dash::Long, Marker::Circle)),
    ("nepce", "NEPCE", LineStyle::new([0x00, 0x62, 0x77], Dash::Short, Marker::Triangle)),
    (
        "integral-correction-first-order",
        "first-order NEPCE",
        LineStyle::new([0x13, 0x4E, 0x9E], Dash::DashDot, Marker::Triangle),
    ),
    ("energy-leak-damper", "energy-leak damper", LineStyle::new([0x79, 0x5B, 0x3C], Dash::Short, Marker::Plus)),
    ("transmission-line", "transmission line", LineStyle::new([0x99, 0x97, 0x2A], Dash::DashDotDot, Marker::Pentagon)),
    ("hydraulic-line", "hydraulic line", LineStyle::new([0x68, 0x57, 0x21], Dash::Dotted, Marker::Diamond)),
    ("interface-jacobian", "interface Jacobian", LineStyle::new([0x6E, 0xA1, 0x51], Dash::Long, Marker::Star)),
    ("interface-exponential", "interface exponential", LineStyle::new([0x51, 0x8B, 0x09], Dash::DashDot, Marker::Star)),
    (
        "model-corrected-outputs",
        "model-corrected outputs",
        LineStyle::new([0x4B, 0x66, 0x9E], Dash::Long, Marker::Pentagon),
    ),
    ("interface-mass", "interface mass", LineStyle::new([0x5B, 0x6E, 0x1F], Dash::Dashed, Marker::Diamond)),
    ("iterated-aitken", "fixed-point iteration", LineStyle::new([0x5B, 0x5B, 0x5B], Dash::Dashed, Marker::OpenCircle)),
    ("monolithic", "monolithic solution", LineStyle::new([0x2E, 0x2E, 0x2E], Dash::Long, Marker::OpenCircle)),
];

/// Dark enough for white paper and none of the colours of the built-in schemes.
pub(super) const SPARE_COLORS: [[u8; 3]; 7] = [
    [0x88, 0x22, 0x55],
    [0x33, 0x22, 0x88],
    [0x99, 0x8A, 0x22],
    [0x11, 0x77, 0x33],
    [0xAA, 0x44, 0x99],
    [0x66, 0x11, 0x00],
    [0x4B, 0x6A, 0x88],
];
const SPARE_DASHES: [Dash; 5] = [Dash::Dashed, Dash::Short, Dash::DashDot, Dash::Dotted, Dash::Long];
const SPARE_MARKERS: [Marker; 6] =
    [Marker::Star, Marker::Plus, Marker::Triangle, Marker::OpenCircle, Marker::OpenSquare, Marker::Pentagon];

impl LineStyle {
    /// Puts a style together.
    pub const fn new([red, green, blue]: [u8; 3], dash: Dash, marker: Marker) -> Self {
        LineStyle { color: Color(red, green, blue), dash, marker }
    }

    /// Returns how its line is drawn.
    pub fn stroke(&self) -> Stroke {
        Stroke { color: self.color, width: WIDTH, dash: self.dash.pattern() }
    }

    /// Returns the style of a built-in scheme; for another name a spare one, chosen by its letters, so that it is the
    /// same on every machine.
    pub fn of_name(name: &str) -> Self {
        Self::free(name, |_| false)
    }

    /// Returns the style of a built-in scheme, or from the spare one of this name on the next that is not `taken`.
    pub(super) fn free(name: &str, taken: impl Fn(&LineStyle) -> bool) -> Self {
        if let Some((.., style)) = SCHEMES.iter().find(|(scheme, ..)| *scheme == name) {
            return *style;
        }
        let code = code_of(name);
        let spare = |next: u64| {
            let color = pick(&SPARE_COLORS, code.wrapping_add(next));
            LineStyle::new(color, pick(&SPARE_DASHES, code / 64), pick(&SPARE_MARKERS, code / 4096 + next / 7))
        };
        // Seven colours, six markers.
        (0..42).map(spare).find(|style| !taken(style)).unwrap_or_else(|| spare(0))
    }

    /// Makes the same colour with dash and marker computed from the letters of a variant's name.
    pub fn of_variant(self, name: &str) -> Self {
        let code = code_of(name);
        LineStyle { dash: pick(&SPARE_DASHES, code), marker: pick(&SPARE_MARKERS, code / 64), ..self }
    }
}

impl Dash {
    fn pattern(self) -> DashPattern {
        match self {
            Dash::Solid => &[],
            Dash::Long => &[10.0, 2.4],
            Dash::Dashed => &[5.5, 2.4],
            Dash::Short => &[3.2, 2.0],
            Dash::Dotted => &[1.4, 1.8],
            Dash::DashDot => &[6.4, 2.0, 1.4, 2.0],
            Dash::DashDotDot => &[6.4, 2.0, 1.4, 2.0, 1.4, 2.0],
        }
    }
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
    use rimbench_core::schemes::standard_schemes;
    use std::path::Path;

    #[test]
    fn the_styles_of_the_schemes_differ_without_colour() {
        for (index, (scheme, _, one)) in SCHEMES.iter().enumerate() {
            for (other, _, two) in &SCHEMES[..index] {
                assert!((one.dash, one.marker) != (two.dash, two.marker), "{scheme} and {other} in grey");
                assert_ne!(one.color, two.color, "{scheme} and {other}");
            }
            assert!(!SPARE_COLORS.contains(&[one.color.0, one.color.1, one.color.2]), "{scheme}");
        }
    }

    #[test]
    fn every_dash_has_a_pattern_of_its_own() {
        use Dash::{DashDot, DashDotDot, Dashed, Dotted, Long, Short, Solid};
        let patterns = [Solid, Long, Dashed, Short, Dotted, DashDot, DashDotDot].map(Dash::pattern);
        assert!((0..patterns.len()).all(|i| (0..i).all(|j| patterns[i] != patterns[j])));
    }

    #[test]
    fn every_scheme_with_a_page_has_a_style_and_no_other() {
        let mut schemes: Vec<_> = standard_schemes().into_iter().map(|scheme| scheme.name).collect();
        let mut drawn = SCHEMES.map(|(name, ..)| name);
        schemes.retain(|name| Path::new("../../../docs/schemes").join(format!("{name}.md")).is_file());
        schemes.sort();
        drawn.sort_unstable();
        assert_eq!(schemes, drawn);
    }

    #[test]
    fn the_style_of_a_name_is_that_of_its_letters() {
        // What was drawn with the first version of this program: figures of a user's own scheme must not change their
        // looks.
        let mine = LineStyle::new([0x4B, 0x6A, 0x88], Dash::Short, Marker::Triangle);
        assert_eq!(LineStyle::of_name("my-scheme"), mine);
        assert_ne!(LineStyle::of_name("my-other-scheme"), mine);
        assert_eq!(mine.of_variant("fast").color, mine.color);
    }

    #[test]
    fn two_schemes_of_a_user_must_look_different_even_if_their_letters_choose_one_style() {
        let mut taken = Vec::new();
        for _ in 0..42 {
            let style = LineStyle::free("my-scheme", |style| taken.contains(style));
            assert!(!taken.contains(&style));
            taken.push(style);
        }
    }
}

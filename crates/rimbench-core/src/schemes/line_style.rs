//! How a scheme is drawn, said where the scheme is, so that it looks the same in every figure. Plain data: nothing here draws.

/// Colour, dash and marker of one series. The colours of the built-in schemes begin with those of Okabe and Ito; the others are chosen so
/// that all stand out from white paper and no two merge for readers with a common deficiency of colour vision, which the tests of the
/// figures compute. Dash and marker tell the series apart in grey.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineStyle {
    /// Red, green, blue.
    pub color: [u8; 3],
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
}

/// Dark enough for white paper and none of the colours of the built-in schemes.
const SPARE_COLORS: [[u8; 3]; 7] = [
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
    pub const fn new(color: [u8; 3], dash: Dash, marker: Marker) -> Self {
        LineStyle { color, dash, marker }
    }

    /// Makes a style computed from the letters of a name, the same today and tomorrow, on every machine.
    pub fn of_name(name: &str) -> Self {
        let code = code_of(name);
        LineStyle::new(pick(&SPARE_COLORS, code), pick(&SPARE_DASHES, code / 64), pick(&SPARE_MARKERS, code / 4096))
    }

    /// Makes the same colour with dash and marker computed from the letters of a variant's name.
    pub fn of_variant(self, name: &str) -> Self {
        let code = code_of(name);
        LineStyle { dash: pick(&SPARE_DASHES, code), marker: pick(&SPARE_MARKERS, code / 64), ..self }
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
    use crate::schemes::standard_schemes;

    #[test]
    fn the_styles_of_the_schemes_differ_without_colour() {
        let schemes = standard_schemes();
        for (index, scheme) in schemes.iter().enumerate() {
            for other in &schemes[..index] {
                let (one, two) = (scheme.line, other.line);
                assert!((one.dash, one.marker) != (two.dash, two.marker), "{} and {} in grey", scheme.name, other.name);
                assert_ne!(one.color, two.color, "{} and {}", scheme.name, other.name);
            }
            assert!(!SPARE_COLORS.contains(&scheme.line.color), "{}", scheme.name);
        }
    }

    #[test]
    fn the_style_of_a_name_is_that_of_its_letters() {
        // What was drawn with the first version of this program: figures of a user's own scheme must not change their looks.
        let mine = LineStyle::new([0x4B, 0x6A, 0x88], Dash::Short, Marker::Triangle);
        assert_eq!(LineStyle::of_name("my-scheme"), mine);
        assert_ne!(LineStyle::of_name("my-other-scheme"), mine);
        assert_eq!(mine.of_variant("fast").color, mine.color);
    }
}

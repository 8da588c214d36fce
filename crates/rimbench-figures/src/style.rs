//! How schemes are drawn: as their entries say, the same in every figure.
//!
//! A variant of a scheme (another force return, say) keeps the colour and changes dash and marker. A name that no entry has gets
//! a style computed from its letters, so a user's scheme looks the same today and tomorrow.

use super::drawing::{Color, DashPattern};
use rimbench_core::name::Name;
use rimbench_core::schemes::{Dash, LineStyle, Marker, SchemeEntry, standard_schemes};

/// Width of a line, px.
const WIDTH: f64 = 1.35;

/// How one series is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesStyle {
    /// Colour of line and marker.
    pub color: Color,
    /// Dash pattern of the line.
    pub dash: DashPattern,
    /// Width of the line, px.
    pub width: f64,
    /// Sign at the data points.
    pub marker: Marker,
}

impl From<LineStyle> for SeriesStyle {
    fn from(LineStyle { color: [red, green, blue], dash, marker }: LineStyle) -> Self {
        SeriesStyle { color: legible(Color(red, green, blue)), dash: pattern(dash), width: WIDTH, marker }
    }
}

/// Contrast that a line needs against the paper, as accessibility guidelines have it for graphics.
const CONTRAST: f64 = 3.0;

/// The colour, darkened until it stands out from white paper.
fn legible(color: Color) -> Color {
    let shares = (0..=20).map(|k| f64::from(k) * 0.03);
    shares.map(|share| color.mix(Color(0, 0, 0), share)).find(|color| contrast(*color) >= CONTRAST).unwrap_or(color)
}

/// Contrast of a colour to white, from 1 to 21, by relative luminance.
fn contrast(Color(red, green, blue): Color) -> f64 {
    let linear = |channel: u8| {
        let share = f64::from(channel) / 255.0;
        if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
    };
    1.05 / (0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue) + 0.05)
}

fn pattern(dash: Dash) -> DashPattern {
    match dash {
        Dash::Solid => &[],
        Dash::Long => &[10.0, 2.4],
        Dash::Dashed => &[5.5, 2.4],
        Dash::Short => &[3.2, 2.0],
        Dash::Dotted => &[1.4, 1.8],
        Dash::DashDot => &[6.4, 2.0, 1.4, 2.0],
        Dash::DashDotDot => &[6.4, 2.0, 1.4, 2.0, 1.4, 2.0],
    }
}

/// The reference, which is no scheme.
const REFERENCE: (&str, LineStyle) = ("reference", LineStyle::new([0x00; 3], Dash::Solid, Marker::Circle));

/// What ends a scheme's name in a label.
const ENDS: [char; 5] = ['/', '+', ':', '(', ' '];

/// How schemes are drawn, and which of them cannot run in real time.
#[derive(Debug, Clone, PartialEq)]
pub struct Styles {
    schemes: Vec<SchemeStyle>,
}

#[derive(Debug, Clone, PartialEq)]
struct SchemeStyle {
    name: Name,
    line: LineStyle,
    real_time: bool,
    /// The force return that the scheme has by itself; no variant of it.
    force_return: String,
}

impl Styles {
    /// Those of these schemes.
    pub fn of<'a>(schemes: impl IntoIterator<Item = &'a SchemeEntry>) -> Self {
        let style = |scheme: &SchemeEntry| SchemeStyle {
            name: scheme.name.clone(),
            line: scheme.line,
            real_time: scheme.real_time(),
            force_return: scheme.sequence_and_return(None, None).map(|(_, back)| back.to_string()).unwrap_or_default(),
        };
        Styles { schemes: schemes.into_iter().map(style).collect() }
    }

    /// Those of the built-in schemes.
    pub fn standard() -> Self {
        Self::of(&standard_schemes())
    }

    /// Finds the style of a scheme, of `reference`, or of any other name.
    ///
    /// A variant may follow the scheme's name after `/`, `+`, `:`, `(` or a space, as in `rim-nonsmooth/profile`.
    pub fn of_label(&self, label: &str) -> SeriesStyle {
        let label = label.trim();
        let (name, variant) = match label.find(ENDS) {
            Some(end) if end > 0 => (&label[..end], label[end..].trim_matches(|c| ENDS.contains(&c) || c == ')')),
            _ => (label, ""),
        };
        self.of_variant(name, variant).into()
    }

    /// The style of a scheme's variant: the scheme's colour with another dash and marker. Its own force return, and an empty
    /// variant, look like the scheme itself.
    fn of_variant(&self, name: &str, variant: &str) -> LineStyle {
        let known = self.schemes.iter().find(|scheme| scheme.name == name);
        let line = match known {
            Some(scheme) => scheme.line,
            None if name == REFERENCE.0 => REFERENCE.1,
            None => LineStyle::of_name(name),
        };
        let usual = known.map_or("held", |scheme| &scheme.force_return);
        let (dash, marker) = match variant {
            "" => return line,
            variant if variant == usual => return line,
            "mean" => (Dash::Long, Marker::OpenSquare),
            "held" => (Dash::Dotted, Marker::Triangle),
            "gauss-seidel" => (Dash::Long, Marker::OpenSquare),
            "extrapolated" => (Dash::Dotted, Marker::Triangle),
            "profile-extrapolated" => (Dash::DashDotDot, Marker::OpenDiamond),
            "mean-5" => (Dash::Short, Marker::Plus),
            "mean-all" => (Dash::Dashed, Marker::Diamond),
            "profile-5" => (Dash::DashDot, Marker::Star),
            "profile-10" => (Dash::Dashed, Marker::OpenDiamond),
            "profile-20" => (Dash::Dotted, Marker::Pentagon),
            "profile" => (Dash::Solid, Marker::OpenCircle),
            "end" => (Dash::Dashed, Marker::Cross),
            "semi-implicit" => (Dash::Dotted, Marker::Plus),
            "midpoint" => (Dash::DashDot, Marker::Star),
            "event-split" => (Dash::Dashed, Marker::Diamond),
            "equal" => (Dash::Solid, Marker::Circle),
            "closings" => (Dash::Dotted, Marker::Plus),
            "defect" => (Dash::Long, Marker::Diamond),
            "defect-blind" => (Dash::Short, Marker::OpenDiamond),
            "audited" => (Dash::DashDot, Marker::Cross),
            "libcosim" => (Dash::DashDotDot, Marker::OpenSquare),
            other => return line.of_variant(other),
        };
        LineStyle { dash, marker, ..line }
    }

    /// What a legend or table says of a label: schemes that cannot run in real time are marked.
    pub fn shown_name(&self, label: &str) -> String {
        let name = label.split(ENDS).next().unwrap_or_default();
        let ceiling = self.schemes.iter().any(|scheme| scheme.name == name && !scheme.real_time);
        if ceiling { format!("{label} (not real-time)") } else { label.to_owned() }
    }
}

/// A style for the entry at `index` of a list that only grows, and whose names are no schemes: neighbours differ in colour,
/// dash and marker, and no two of the first 55 agree in both dash and marker.
pub fn style_in_list(index: usize) -> SeriesStyle {
    const COLORS: [[u8; 3]; 8] = [
        [0x00, 0x72, 0xB2],
        [0xD5, 0x5E, 0x00],
        [0x00, 0x9E, 0x73],
        [0xCC, 0x79, 0xA7],
        [0x33, 0x22, 0x88],
        [0xE6, 0x9F, 0x00],
        [0x56, 0xB4, 0xE9],
        [0x80, 0x80, 0x80],
    ];
    const DASHES: [Dash; 5] = [Dash::Dashed, Dash::Short, Dash::DashDot, Dash::Dotted, Dash::Long];
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
    let (dash, marker) = (DASHES[index % DASHES.len()], MARKERS[index % MARKERS.len()]);
    LineStyle::new(COLORS[index % COLORS.len()], dash, marker).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dash_has_a_pattern_of_its_own() {
        use Dash::{DashDot, DashDotDot, Dashed, Dotted, Long, Short, Solid};
        let patterns = [Solid, Long, Dashed, Short, Dotted, DashDot, DashDotDot].map(pattern);
        assert!((0..patterns.len()).all(|i| (0..i).all(|j| patterns[i] != patterns[j])));
    }

    #[test]
    fn the_styles_of_a_list_differ_without_colour() {
        let pair = |index: usize| (style_in_list(index).dash, style_in_list(index).marker);
        assert!((0..55).all(|index| (0..index).all(|other| pair(index) != pair(other))));
        assert!((1..55).all(|index| style_in_list(index).color != style_in_list(index - 1).color));
    }

    #[test]
    fn every_colour_stands_out_from_the_paper_and_dark_ones_are_left_as_they_are() {
        let mut pale = 0;
        for scheme in standard_schemes() {
            let [red, green, blue] = scheme.line.color;
            let own = Color(red, green, blue);
            assert!(contrast(legible(own)) >= CONTRAST, "{}", scheme.name);
            assert_eq!(legible(own) == own, contrast(own) >= CONTRAST, "{}", scheme.name);
            pale += usize::from(contrast(own) < CONTRAST);
        }
        assert!(pale > 0 && (contrast(Color::WHITE) - 1.0).abs() < 1e-12);
        assert!((contrast(Color(0, 0, 0)) - 21.0).abs() < 1e-9);
        assert!((0..8).all(|index| contrast(style_in_list(index).color) >= CONTRAST));
    }

    #[test]
    fn a_scheme_is_drawn_as_its_entry_says() {
        let mut mine = standard_schemes().swap_remove(0);
        mine.name = "my-scheme".into();
        mine.line = LineStyle::new([1, 2, 3], Dash::Short, Marker::Star);
        let styles = Styles::of([&mine]);
        assert_eq!(styles.of_label("my-scheme"), mine.line.into());
        assert_eq!(styles.of_label("my-scheme").color, Color(1, 2, 3));
        // What is in no entry looks as its letters say, and not like the others.
        assert_eq!(styles.of_label("another-scheme"), LineStyle::of_name("another-scheme").into());
        assert_ne!(styles.of_label("another-scheme"), styles.of_label("my-scheme"));
        assert_eq!(styles.of_label("reference").color, Color(0, 0, 0));
    }

    #[test]
    fn a_variant_keeps_the_colour_and_changes_dash_and_marker() {
        let styles = Styles::standard();
        let (mean, profile) = (styles.of_label("rim-nonsmooth"), styles.of_label("rim-nonsmooth/profile"));
        assert_eq!(mean.color, profile.color);
        assert!(mean.dash != profile.dash && mean.marker != profile.marker);
        // The force return that a scheme has by itself is no variant.
        assert_eq!(styles.of_label("rim-nonsmooth (mean)"), mean);
        assert_ne!(styles.of_label("rim-nonsmooth (held)"), mean);
        assert_eq!(styles.of_label("zero-order-hold/held"), styles.of_label("zero-order-hold"));
        assert_ne!(styles.of_label("zero-order-hold/mean"), styles.of_label("zero-order-hold"));
    }

    #[test]
    fn only_what_takes_steps_again_is_marked_as_not_real_time() {
        let styles = Styles::standard();
        assert_eq!(styles.shown_name("monolithic"), "monolithic (not real-time)");
        assert_eq!(styles.shown_name("iterated-aitken/fine"), "iterated-aitken/fine (not real-time)");
        assert_eq!(styles.shown_name("rim-nonsmooth (mean)"), "rim-nonsmooth (mean)");
    }
}

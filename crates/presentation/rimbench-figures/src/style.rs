//! How schemes are drawn, the same in every figure.
//!
//! A variant of a scheme (another force return, say) keeps the colour and changes dash and marker. A user's scheme gets
//! a free style, chosen by the letters of its name.

use super::drawing::Color;
use super::line_style::{Dash, LineStyle, Marker, SCHEMES, SPARE_COLORS};
use rimbench_core::name::Name;
use rimbench_core::schemes::{SchemeEntry, standard_schemes};

/// Contrast that a line needs against the paper, as accessibility guidelines have it for graphics.
const CONTRAST: f64 = 3.0;

/// Lightens a colour until it stands out from dark paper.
pub fn on_dark_paper(color: Color) -> Color {
    let shares = (0..=20).map(|k| f64::from(k) * 0.03);
    // Contrast to white 1.05 / (L + 0.05); 17 is that of the dark paper of pages, L = 0.012.
    let mut lightened = shares.map(|share| color.mix(Color::WHITE, share));
    lightened.find(|color| 17.0 / contrast(*color) >= CONTRAST + 1.0).unwrap_or(color)
}

/// Contrast of a colour to white, from 1 to 21, by relative luminance.
fn contrast(Color(red, green, blue): Color) -> f64 {
    let linear = |channel: u8| {
        let share = f64::from(channel) / 255.0;
        if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
    };
    1.05 / (0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue) + 0.05)
}

/// The reference, which is no scheme.
const REFERENCE: (&str, LineStyle) = ("reference", LineStyle::new([0x00; 3], Dash::Solid, Marker::Circle));

/// The colour of what others are held against.
pub const BASELINE: Color = Color(0x84, 0x8A, 0x91);

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
        let mut styles: Vec<SchemeStyle> = Vec::new();
        for scheme in schemes {
            let back = scheme.sequence_and_return(None, None).map(|(_, back)| back.to_string());
            styles.push(SchemeStyle {
                name: scheme.name.clone(),
                line: LineStyle::free(&scheme.name, |style| styles.iter().any(|other| other.line == *style)),
                real_time: scheme.real_time(),
                force_return: back.unwrap_or_default(),
            });
        }
        Styles { schemes: styles }
    }

    /// Those of the built-in schemes.
    pub fn standard() -> Self {
        Self::of(&standard_schemes())
    }

    /// Finds the style of a scheme, of `reference`, or of any other name.
    ///
    /// A variant may follow the scheme's name after `/`, `+`, `:`, `(` or a space, as in `rim-nonsmooth/profile`.
    pub fn of_label(&self, label: &str) -> LineStyle {
        let label = label.trim();
        let (name, variant) = match label.find(ENDS) {
            Some(end) if end > 0 => (&label[..end], label[end..].trim_matches(|c| ENDS.contains(&c) || c == ')')),
            _ => (label, ""),
        };
        self.of_variant(name, variant)
    }

    /// Finds the style of a row of an experiment, whose label may begin with another name than its scheme's, as in
    /// `gap/profile` of `rim-nonsmooth-gap`: the scheme's colour all the same.
    pub fn of_row(&self, label: &str, scheme: &str) -> LineStyle {
        let (name, variant) = label.split_once('/').unwrap_or((label, label));
        let known = |name: &str| self.schemes.iter().any(|entry| entry.name == name);
        if known(label.split(ENDS).next().unwrap_or_default()) || name == REFERENCE.0 || !known(scheme) {
            return self.of_label(label);
        }
        self.of_variant(scheme, variant)
    }

    /// The style of what others are held against: grey.
    pub fn baseline(style: LineStyle) -> LineStyle {
        LineStyle { color: BASELINE, dash: Dash::Solid, ..style }
    }

    /// The style of a scheme's variant: the scheme's colour with another dash and marker. Its own force return, and an
    /// empty variant, look like the scheme itself.
    fn of_variant(&self, name: &str, variant: &str) -> LineStyle {
        let known = self.schemes.iter().find(|scheme| scheme.name == name);
        let line = match known {
            Some(scheme) => scheme.line,
            None if name == REFERENCE.0 => REFERENCE.1,
            None => LineStyle::of_name(name),
        };
        let usual = known.map_or("held", |scheme| &scheme.force_return);
        if variant.is_empty() || variant == usual { line } else { line.of_variant(variant) }
    }

    /// What a legend or table says of a label: the scheme's name and its variant in words, and schemes that cannot run
    /// in real time are marked.
    pub fn shown_name(&self, label: &str) -> String {
        let name = label.split(ENDS).next().unwrap_or_default();
        let ceiling = self.schemes.iter().any(|scheme| scheme.name == name && !scheme.real_time);
        let label = in_words(label);
        if ceiling { format!("{label} (not real-time)") } else { label }
    }
}

/// A label with its variants in words: `rim-smooth/1um` is `smooth model, margin 1 µm`.
fn in_words(label: &str) -> String {
    let mut parts = label.split('/');
    let first = parts.next().unwrap_or_default();
    let (id, rest) = first.split_at(first.find(ENDS).unwrap_or(first.len()));
    let known = SCHEMES.iter().find(|(scheme, ..)| *scheme == id);
    let name = known.map_or_else(|| first.to_owned(), |(_, name, _)| format!("{name}{rest}"));
    with_variants(name, parts)
}

/// A sentence with the labels of known schemes in words.
pub(crate) fn labels_in_words(text: &str) -> String {
    let bare = |word: &str| word.trim_end_matches([',', ':', ';', ')']).to_owned();
    let words: Vec<&str> = text.split(' ').collect();
    let word = |(index, word): (usize, &&str)| {
        let label = bare(word);
        let name = label.split('/').next().unwrap_or_default();
        let said = match SCHEMES.iter().any(|(scheme, ..)| *scheme == name) {
            true => in_words(&label) + &word[label.len()..],
            false => return (*word).to_owned(),
        };
        // A sentence may go on with the end of the name: the monolithic solution.
        match (said.rsplit_once(' '), words.get(index + 1)) {
            (Some((start, end)), Some(next)) if bare(next) == end => start.to_owned(),
            _ => said,
        }
    };
    let said = words.iter().enumerate().map(word).collect::<Vec<_>>().join(" ");
    let mut letters = said.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// A name with its variants in words.
pub(crate) fn with_variants<'a>(name: String, variants: impl Iterator<Item = &'a str>) -> String {
    variants.fold(name, |said, variant| format!("{said}, {}", variant_in_words(variant)))
}

/// A variant in words; an unknown one stays as it is.
fn variant_in_words(variant: &str) -> String {
    if let Some((digits, unit)) = margin(variant) {
        return format!("margin {digits} {unit}");
    }
    if let Some((first, last)) = variant.rsplit_once('-') {
        if margin(last).is_some() {
            return format!("{}, {}", variant_in_words(first), variant_in_words(last));
        }
        let steps = |count: u32| if count == 1 { "1 step late".to_owned() } else { format!("{count} steps late") };
        match (first, last.parse::<u32>()) {
            ("late" | "catch-up-late", Ok(count)) => return steps(count),
            ("raw-late", Ok(count)) => return format!("{}, taken for the present", steps(count)),
            ("coarse-late", Ok(count)) => return format!("{}, in coarse steps", steps(count)),
            ("extrapolated-late", Ok(count)) => return format!("{}, along its rates", steps(count)),
            _ => {}
        }
        if let ("profile" | "mean", Ok(parts)) = (first, last.parse::<u32>()) {
            return format!("{first} of {parts}");
        }
    }
    match variant {
        "gauss-seidel" => "actuator first".to_owned(),
        "jacobi" => "parallel".to_owned(),
        "mechanics-first" => "mechanics first".to_owned(),
        "mechanics-law" => "the mechanics’ law".to_owned(),
        "active" => "touching contacts".to_owned(),
        "end" => "end force".to_owned(),
        "held" => "held force".to_owned(),
        "mean-all" => "mean of all".to_owned(),
        "fine" => "fine mechanics".to_owned(),
        "1ms-steps" => "steps of 1 ms".to_owned(),
        "own-step" => "own step".to_owned(),
        "one-row" => "one row".to_owned(),
        "one-row-profile" => "one row, profile".to_owned(),
        "equal" => "equal steps".to_owned(),
        "closings" => "short after closings".to_owned(),
        "defect" => "steps by its defect".to_owned(),
        "libcosim" => "energy controller".to_owned(),
        "mean-shares" => "last means, equal shares".to_owned(),
        "mean-rows" => "last means, row sums".to_owned(),
        "mean-body" => "last means, whole body".to_owned(),
        "blind-shares" => "blind, equal shares".to_owned(),
        "force-hold-late-1" => "late force held".to_owned(),
        "force-linear-late-1" => "late force extrapolated".to_owned(),
        "force-rates-late-1" => "late force from the rates".to_owned(),
        other => other.to_owned(),
    }
}

/// The width in a variant that is a contact margin, and its unit.
fn margin(variant: &str) -> Option<(&str, &'static str)> {
    let width = |unit: &str| variant.strip_suffix(unit).filter(|digits| digits.parse::<f64>().is_ok());
    width("um").map(|digits| (digits, "µm")).or(width("mm").map(|digits| (digits, "mm")))
}

/// Changes colours of series of which more than two would share one, then signs, then dashes, of those that would look
/// the same: of one colour no two labels of a figure share a sign while there are others, and none share dash and sign.
pub fn told_apart(labels: &[&str], styles: &mut [LineStyle]) {
    const MARKERS: [Marker; 11] = [
        Marker::OpenCircle,
        Marker::OpenSquare,
        Marker::Triangle,
        Marker::Cross,
        Marker::Diamond,
        Marker::Star,
        Marker::OpenDiamond,
        Marker::Plus,
        Marker::Pentagon,
        Marker::Square,
        Marker::Circle,
    ];
    const DASHES: [Dash; 7] =
        [Dash::Solid, Dash::Long, Dash::Dashed, Dash::Short, Dash::Dotted, Dash::DashDot, Dash::DashDotDot];
    // Two share a colour at most; further ones have one that no scheme has. Grey is for baselines, however many.
    for index in 0..styles.len() {
        let (before, own) = (styles[..index].to_vec(), styles[index].color);
        let same = before.iter().zip(labels).filter(|(style, label)| style.color == own && **label != labels[index]);
        let same: std::collections::BTreeSet<&str> = same.map(|(_, label)| *label).collect();
        let is_new = !labels[..index].contains(&labels[index]);
        let free = SPARE_COLORS.map(|[red, green, blue]| Color(red, green, blue));
        let free = free.into_iter().find(|color| before.iter().all(|style| style.color != *color));
        if let Some(color) = free.filter(|_| is_new && same.len() >= 2 && own != BASELINE) {
            styles[index].color = color;
        }
    }
    for index in 0..styles.len() {
        let others: Vec<LineStyle> = styles[..index]
            .iter()
            .zip(labels)
            .filter(|(style, label)| **label != labels[index] && style.color == styles[index].color)
            .map(|(style, _)| *style)
            .collect();
        // Of one colour, first of all another sign; with all signs taken, another dash.
        let has_sign = |marker: Marker| others.iter().any(|other| other.marker == marker);
        let has_both =
            |style: &LineStyle| others.iter().any(|other| (other.dash, other.marker) == (style.dash, style.marker));
        let own = styles[index];
        if !has_sign(own.marker) {
            continue;
        }
        if let Some(marker) = MARKERS.into_iter().find(|marker| !has_sign(*marker)) {
            styles[index].marker = marker;
        } else if has_both(&own) {
            let mut free = DASHES.iter().flat_map(|&dash| MARKERS.map(|marker| LineStyle { dash, marker, ..own }));
            styles[index] = free.find(|style| !has_both(style)).unwrap_or(own);
        }
    }
    // A label has one look, however often it is drawn.
    for index in 0..styles.len() {
        if let Some(first) = labels[..index].iter().position(|label| *label == labels[index]) {
            styles[index] = styles[first];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_stands_out_from_the_paper() {
        for (scheme, _, LineStyle { color, .. }) in SCHEMES {
            assert!(contrast(color) >= CONTRAST, "{scheme}");
        }
        assert!(SPARE_COLORS.iter().all(|&[red, green, blue]| contrast(Color(red, green, blue)) >= CONTRAST));
        assert!((contrast(Color::WHITE) - 1.0).abs() < 1e-12);
        assert!((contrast(Color(0, 0, 0)) - 21.0).abs() < 1e-9);
    }

    /// How far apart colours are for an eye with all three kinds of cones, and with one kind missing (Machado, Oliveira
    /// and Fernandes 2009, severity 1), as a distance in CIE L*a*b*; 2.3 is just noticeable.
    fn least_distance(one: Color, other: Color) -> f64 {
        const EYES: [[[f64; 3]; 3]; 4] = [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
            [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
            [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
        ];
        let lab = |Color(red, green, blue): Color, eye: &[[f64; 3]; 3]| {
            let linear = [red, green, blue].map(|channel| {
                let share = f64::from(channel) / 255.0;
                if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
            });
            let seen = eye.map(|row| row.iter().zip(linear).map(|(a, b)| a * b).sum::<f64>().clamp(0.0, 1.0));
            const XYZ: [[f64; 3]; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
            const WHITE: [f64; 3] = [0.95047, 1.0, 1.08883];
            let root = |t: f64| if t > 0.008856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
            let xyz: Vec<f64> = XYZ
                .iter()
                .zip(WHITE)
                .map(|(row, white)| root(row.iter().zip(seen).map(|(a, b)| a * b).sum::<f64>() / white))
                .collect();
            [116.0 * xyz[1] - 16.0, 500.0 * (xyz[0] - xyz[1]), 200.0 * (xyz[1] - xyz[2])]
        };
        let apart = |eye: &[[f64; 3]; 3]| {
            let (a, b) = (lab(one, eye), lab(other, eye));
            a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        EYES.iter().map(apart).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn no_two_colours_of_schemes_merge_for_readers_who_see_colours_otherwise() {
        // Black and white are 100 apart for every eye.
        assert!((least_distance(Color(0, 0, 0), Color::WHITE) - 100.0).abs() < 0.1);
        // What a red-green deficiency merges: the colours that these two schemes once had.
        assert!(least_distance(Color(0xD5, 0x5E, 0x00), Color(0xB0, 0x8A, 0x00)) < 3.0);
        for (index, (scheme, _, one)) in SCHEMES.into_iter().enumerate() {
            for (other, _, two) in SCHEMES.into_iter().take(index) {
                let apart = least_distance(one.color, two.color);
                assert!(apart > 6.5, "{scheme} and {other} are {apart:.1} apart");
            }
        }
        // Those that stand in most figures are farther apart.
        let common = ["zero-order-hold", "first-order-hold", "transmission-line", "interface-jacobian", "rim-smooth"];
        let common: Vec<&str> =
            common.into_iter().chain(["rim-smooth-active", "rim-nonsmooth", "rim-nonsmooth-gap"]).collect();
        let styles = Styles::standard();
        for (index, one) in common.iter().enumerate() {
            for two in &common[..index] {
                let apart = least_distance(styles.of_label(one).color, styles.of_label(two).color);
                assert!(apart > 10.0, "{one} and {two} are {apart:.1} apart");
            }
        }
    }

    #[test]
    fn no_two_labels_of_a_figure_look_the_same() {
        let mut looks = vec![REFERENCE.1; 60];
        let names: Vec<String> = (0..60).map(|k| format!("x/{}", k / 2)).collect();
        let labels: Vec<&str> = names.iter().map(String::as_str).collect();
        told_apart(&labels, &mut looks);
        for i in 0..60 {
            for j in 0..i {
                assert_eq!(looks[i] == looks[j], labels[i] == labels[j], "{} and {}", labels[i], labels[j]);
            }
        }
        assert_eq!(looks[0], REFERENCE.1);
        // While there are signs, each label of one colour has its own.
        let differ = |i: usize, j: usize| (looks[i].color, looks[i].marker) != (looks[j].color, looks[j].marker);
        assert!((0..20).all(|i| (0..i).all(|j| labels[i] == labels[j] || differ(i, j))));
    }

    #[test]
    fn two_series_share_a_colour_at_most() {
        let styles = Styles::standard();
        let labels: Vec<String> =
            (0..6).map(|k| format!("rim-nonsmooth-gap/{}", k / 2 * 2)).chain(["rim-nonsmooth-gap/x".into()]).collect();
        let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
        let mut looks: Vec<LineStyle> = labels.iter().map(|label| styles.of_label(label)).collect();
        told_apart(&labels, &mut looks);
        let own = styles.of_label("rim-nonsmooth-gap").color;
        // Of four labels two keep the colour of their scheme, wherever they are drawn.
        assert_eq!(
            looks.iter().map(|look| look.color == own).collect::<Vec<_>>(),
            [true, true, true, true, false, false, false]
        );
        assert!(looks[4] == looks[5] && looks[6].color != looks[4].color);
    }

    #[test]
    fn a_row_has_the_colour_of_its_scheme_whatever_it_is_called() {
        let styles = Styles::standard();
        let gap = styles.of_label("rim-nonsmooth-gap");
        assert_eq!(
            styles.of_row("gap/event-split", "rim-nonsmooth-gap"),
            styles.of_label("rim-nonsmooth-gap/event-split")
        );
        assert_eq!(styles.of_row("mine", "rim-nonsmooth-gap").color, gap.color);
        assert_eq!(styles.of_row("rim-smooth/1mm", "rim-nonsmooth-gap"), styles.of_label("rim-smooth/1mm"));
        assert_eq!(styles.of_row("mine", "my-scheme"), styles.of_label("mine"));
    }

    #[test]
    fn a_legend_says_in_words_what_a_variant_is() {
        let styles = Styles::standard();
        for (label, words) in [
            ("rim-smooth/1um", "smooth model, margin 1 µm"),
            ("rim-nonsmooth/profile-1mm", "non-smooth model, profile, margin 1 mm"),
            ("rim-nonsmooth-gap/profile-10", "gap tracking, profile of 10"),
            ("zero-order-hold/gauss-seidel", "zero-order hold, actuator first"),
            ("rim-nonsmooth-gap/raw-late-5", "gap tracking, 5 steps late, taken for the present"),
            ("rim-nonsmooth-gap/profile/coarse-late-10", "gap tracking, profile, 10 steps late, in coarse steps"),
            ("rim-nonsmooth-gap/extrapolated-late-1", "gap tracking, 1 step late, along its rates"),
            ("mine", "mine"),
            ("iterated-aitken/fine", "fixed-point iteration, fine mechanics (not real-time)"),
        ] {
            assert_eq!(styles.shown_name(label), words);
        }
    }

    #[test]
    fn a_scheme_of_a_user_has_a_style_of_its_own() {
        let mut mine = standard_schemes().swap_remove(0);
        mine.name = "my-scheme".into();
        let styles = Styles::of([&mine]);
        assert_eq!(styles.of_label("my-scheme"), LineStyle::of_name("my-scheme"));
        // So has a name without an entry.
        assert_eq!(styles.of_label("another-scheme"), LineStyle::of_name("another-scheme"));
        assert_ne!(styles.of_label("another-scheme"), styles.of_label("my-scheme"));
        assert_eq!(styles.of_label("reference").color, Color(0, 0, 0));
    }

    #[test]
    fn a_variant_keeps_the_colour_and_has_a_sign_of_its_own_in_a_figure() {
        let styles = Styles::standard();
        let (mean, profile) = (styles.of_label("rim-nonsmooth"), styles.of_label("rim-nonsmooth/profile"));
        assert_eq!(mean.color, profile.color);
        assert_ne!(mean, profile);
        // Names may choose one sign; a figure that shows both tells them apart by it.
        let mut looks = [mean, profile];
        told_apart(&["rim-nonsmooth", "rim-nonsmooth/profile"], &mut looks);
        assert_ne!(looks[0].marker, looks[1].marker);
        // The force return that a scheme has by itself is no variant.
        assert_eq!(styles.of_label("rim-nonsmooth (mean)"), mean);
        assert_ne!(styles.of_label("rim-nonsmooth (held)"), mean);
        assert_eq!(styles.of_label("zero-order-hold/held"), styles.of_label("zero-order-hold"));
        assert_ne!(styles.of_label("zero-order-hold/mean"), styles.of_label("zero-order-hold"));
    }

    #[test]
    fn only_what_takes_steps_again_is_marked_as_not_real_time() {
        let styles = Styles::standard();
        assert_eq!(styles.shown_name("monolithic"), "monolithic solution (not real-time)");
        assert_eq!(styles.shown_name("rim-nonsmooth (mean)"), "non-smooth model (mean)");
    }
}

//! The display list as SVG: true dashes, a named group for each series, shapes of one look in one path.

use super::drawing::{Anchor, Color, Drawing, PanelData, Point, Shape, Stroke, Text, Weight};
use std::fmt::Write;

/// Millimetres per px of the page.
const MM: f64 = 25.4 / 96.0;

/// Typefaces for the text, the first that a viewer has; from the second on each looks like the ones before it.
const FAMILIES: &str = "Inter,Arial,Liberation Sans,Helvetica,DejaVu Sans,sans-serif";
/// A text from this width on is told its length, px, so that it keeps to its place in every typeface.
const LONG: f64 = 30.0;

/// What makes a picture dark where the page around it is; a page that has the picture inside does that itself.
pub const DARK: &str =
    "<style>@media (prefers-color-scheme:dark){svg{filter:invert(.93) hue-rotate(180deg)}}</style>\n";

/// Formats a drawing as a self-contained SVG document; equal drawings give equal bytes.
pub fn svg(drawing: &Drawing) -> String {
    document(drawing, "", &inside(drawing.shapes.iter()))
}

/// Formats drawings of one size as a document that shows one after the other, each for some seconds, from the first
/// again after the last. Where motion is not wanted, or not known, `still` stands.
pub fn svg_of_frames(frames: &[Drawing], seconds: f64, still: usize) -> String {
    let Some(first) = frames.first() else { return svg(&Drawing::new(0.0, 0.0)) };
    let is_common = |shape: &&Shape| frames.iter().all(|frame| frame.shapes.contains(shape));
    let total = seconds * frames.len() as f64;
    let mut text = inside(first.shapes.iter().filter(is_common));
    for (index, frame) in frames.iter().enumerate() {
        let class = if index == still { "f s" } else { "f" };
        let own = inside(frame.shapes.iter().filter(|shape| !is_common(shape)));
        let delay = hundredths(seconds * index as f64 - total);
        let _ = write!(text, "<g class=\"{class}\" style=\"animation-delay:{delay}s\">\n{own}</g>\n");
    }
    // A look has a name, as it is there in every frame.
    let mut sheet = format!(
        ".f{{visibility:hidden;animation:f {}s step-end infinite}}.s{{visibility:visible}}\
         @keyframes f{{0%{{visibility:visible}}{}%{{visibility:hidden}}}}\
         @media (prefers-reduced-motion:reduce){{.f{{animation:none}}}}",
        hundredths(total),
        hundredths(100.0 / frames.len() as f64)
    );
    let looks: std::collections::BTreeSet<String> =
        text.split("<path").skip(1).filter_map(|path| Some(path.split(" d=").next()?.to_owned())).collect();
    for (index, look) in looks.iter().enumerate() {
        text = text.replace(&format!("<path{look} d="), &format!("<path class=\"p{index}\" d="));
        let _ = write!(sheet, ".p{index}{{{}}}", look.trim().replace("=\"", ":").replace('"', ";"));
    }
    document(first, &format!("<style>{sheet}</style>\n"), &text)
}

/// The elements of some shapes.
fn inside<'a>(shapes: impl Iterator<Item = &'a Shape>) -> String {
    let mut writer = Writer { text: String::new(), open: None };
    shapes.for_each(|shape| writer.shape(shape));
    writer.settle(None);
    writer.text
}

/// A document of the size and with the words of a drawing.
fn document(drawing: &Drawing, sheet: &str, text: &str) -> String {
    let (width, height) = (drawing.width, drawing.height);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}mm\" height=\"{}mm\" viewBox=\"0 0 {} {}\" role=\"img\" \
         font-family=\"{FAMILIES}\" stroke-linejoin=\"round\">\n<title>{}</title>\n<desc>{}</desc>\n{DARK}{sheet}\
         <path d=\"M0 0h{}v{}H0z\" fill=\"#fff\"/>\n{}</svg>\n",
        hundredths(width * MM),
        hundredths(height * MM),
        hundredths(width),
        hundredths(height),
        escaped(&drawing.title),
        escaped(&description(drawing)),
        hundredths(width),
        hundredths(height),
        text
    )
}

/// What a picture shows: what it says itself, or its panels by their quantities.
fn description(drawing: &Drawing) -> String {
    let panel = |panel: &PanelData| {
        let names: Vec<&str> = panel.series.iter().map(|series| series.name.as_str()).collect();
        format!("{}: {} over {} of {}.", panel.title, panel.y, panel.x, names.join(", "))
    };
    match &*drawing.description {
        "" if drawing.data.is_empty() => drawing.title.clone(),
        "" => drawing.data.iter().map(panel).collect::<Vec<_>>().join(" "),
        words => words.to_owned(),
    }
}

/// Escapes what would be markup, for text and for attributes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// What shapes that stand in one element have in common.
#[derive(Debug, Clone, PartialEq)]
enum Look {
    Path { fill: Option<Color>, stroke: Option<Stroke> },
    Text { size: f64, color: Color, weight: Weight, anchor: Anchor },
}

struct Writer {
    text: String,
    /// The element that further shapes of the same look go into, and the last point of its path in hundredths.
    open: Option<(Look, [i64; 2])>,
}

impl Writer {
    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Path { points, closed, fill, stroke } => {
                self.settle(Some(Look::Path { fill: *fill, stroke: *stroke }));
                self.path(points, *closed);
            }
            Shape::Disc { centre, radius, fill, stroke } => {
                self.settle(Some(Look::Path { fill: *fill, stroke: *stroke }));
                self.path(&[(centre.0 - radius, centre.1)], false);
                let (r, d) = (hundredths(*radius), hundredths(2.0 * radius));
                let _ = write!(self.text, "a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0-{d} 0z");
            }
            Shape::Text(text) => {
                let Text { size, color, weight, anchor, .. } = *text;
                self.settle(Some(Look::Text { size, color, weight, anchor }));
                self.letters(text);
            }
            Shape::Open(class, told) => {
                self.settle(None);
                let _ = writeln!(self.text, "<g class=\"{class}\" data-{class}=\"{}\">", escaped(told));
            }
            Shape::Close => {
                self.settle(None);
                self.text.push_str("</g>\n");
            }
        }
    }

    /// Ends the open element if what comes looks otherwise, and opens one for it.
    fn settle(&mut self, look: Option<Look>) {
        if self.open.as_ref().map(|(open, _)| open) == look.as_ref() {
            return;
        }
        match self.open.take() {
            Some((Look::Path { .. }, _)) => self.text.push_str("\"/>\n"),
            Some((Look::Text { .. }, _)) => self.text.push_str("</g>\n"),
            None => {}
        }
        let Some(look) = look else { return };
        match &look {
            Look::Path { fill, stroke } => {
                self.text.push_str("<path");
                let fill = fill.map_or_else(|| "none".to_owned(), Color::hex);
                let _ = write!(self.text, " fill=\"{fill}\"");
                if let Some(stroke) = stroke {
                    let _ = write!(self.text, " stroke=\"{}\"", stroke.color.hex());
                    let _ = write!(self.text, " stroke-width=\"{}\"", hundredths(stroke.width));
                    if !stroke.dash.is_empty() {
                        let dash: Vec<String> = stroke.dash.iter().map(|&length| hundredths(length)).collect();
                        let _ = write!(self.text, " stroke-dasharray=\"{}\"", dash.join(" "));
                    }
                }
                self.text.push_str(" d=\"");
            }
            Look::Text { size, color, weight, anchor } => {
                let _ = write!(self.text, "<g font-size=\"{}\" fill=\"{}\"", hundredths(*size), color.hex());
                if *weight == Weight::Bold {
                    self.text.push_str(" font-weight=\"600\"");
                }
                match anchor {
                    Anchor::Start => {}
                    Anchor::Middle => self.text.push_str(" text-anchor=\"middle\""),
                    Anchor::End => self.text.push_str(" text-anchor=\"end\""),
                }
                self.text.push_str(">\n");
            }
        }
        self.open = Some((look, [0, 0]));
    }

    /// Adds a path; points after the first are relative, on a grid of tenths (0.026 mm), so that rounding does not add
    /// up.
    fn path(&mut self, points: &[Point], closed: bool) {
        let Some((_, last)) = &mut self.open else { return };
        for (index, &(x, y)) in points.iter().enumerate() {
            let at = [(10.0 * x).round() as i64 * 10, (10.0 * y).round() as i64 * 10];
            if index == 0 {
                self.text.push('M');
                number(&mut self.text, at[0], true);
                number(&mut self.text, at[1], false);
            } else {
                let step = [at[0] - last[0], at[1] - last[1]];
                match step {
                    [0, 0] => continue,
                    [across, 0] => {
                        self.text.push('h');
                        number(&mut self.text, across, true);
                    }
                    [0, down] => {
                        self.text.push('v');
                        number(&mut self.text, down, true);
                    }
                    [across, down] => {
                        self.text.push('l');
                        number(&mut self.text, across, true);
                        number(&mut self.text, down, false);
                    }
                }
            }
            *last = at;
        }
        if closed {
            self.text.push('z');
        }
    }

    fn letters(&mut self, text: &Text) {
        let tenth = |length: f64| hundredths((10.0 * length).round() / 10.0);
        let (x, y) = (tenth(text.at.0), tenth(text.at.1));
        let content = escaped(&text.content);
        let length = match text.width() {
            width if width < LONG => String::new(),
            width => format!(" textLength=\"{}\" lengthAdjust=\"spacingAndGlyphs\"", tenth(width)),
        };
        let _ = match text.upwards {
            true => writeln!(self.text, "<text transform=\"translate({x} {y})rotate(-90)\"{length}>{content}</text>"),
            false => writeln!(self.text, "<text x=\"{x}\" y=\"{y}\"{length}>{content}</text>"),
        };
    }
}

/// A length in hundredths, without what can be left out.
fn hundredths(length: f64) -> String {
    let mut text = String::new();
    number(&mut text, (100.0 * length).round() as i64, true);
    text
}

/// Writes hundredths as a number; one that does not come first has a sign or a space before it.
fn number(text: &mut String, hundredths: i64, first: bool) {
    if hundredths < 0 {
        text.push('-');
    } else if !first {
        text.push(' ');
    }
    let (whole, part) = (hundredths.abs() / 100, hundredths.abs() % 100);
    if whole > 0 || part == 0 {
        let _ = write!(text, "{whole}");
    }
    match part {
        0 => {}
        part if part % 10 == 0 => {
            let _ = write!(text, ".{}", part / 10);
        }
        part => {
            let _ = write!(text, ".{part:02}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::font;
    use super::*;

    const BLACK: Color = Color(0, 0, 0);

    #[test]
    fn markup_in_a_label_stays_text_and_a_long_one_is_as_long_in_every_typeface() {
        let mut drawing = Drawing::new(96.0, 48.0);
        drawing.title = "a < b".to_owned();
        drawing.text(Text::new("a < b & c", (1.0, 2.0), 5.0));
        drawing.group("x\"y", |drawing| drawing.line(vec![(0.0, 0.0), (1.0, 1.0)], Stroke::solid(BLACK, 1.0)));
        let document = svg(&drawing);
        assert!(document.contains(">a &lt; b &amp; c</text>") && document.contains("<title>a &lt; b</title>"));
        assert!(document.contains("data-series=\"x&quot;y\""), "{document}");
        assert!(!document.contains("textLength"), "{document}");
        drawing.text(Text::new("below the reference's uncertainty", (1.0, 20.0), 8.0));
        let length = (10.0 * font::width("below the reference's uncertainty", 8.0, Weight::Regular)).round() / 10.0;
        assert!(svg(&drawing).contains(&format!(" textLength=\"{length}\" lengthAdjust")), "{length}");
        assert!(document.contains("width=\"25.4mm\" height=\"12.7mm\" viewBox=\"0 0 96 48\""), "{document}");
    }

    #[test]
    fn a_dashed_line_is_one_path_and_shapes_of_one_look_share_it() {
        let mut drawing = Drawing::new(100.0, 100.0);
        let dashed = Stroke { color: BLACK, width: 1.5, dash: &[4.0, 2.5] };
        drawing.line(vec![(0.0, 0.0), (50.0, 0.2), (50.0, 80.0)], dashed);
        drawing.line(vec![(1.0, 1.0), (2.5, 1.0)], dashed);
        drawing.disc((5.0, 5.0), 2.0, Some(BLACK), None);
        let document = svg(&drawing);
        let path = "stroke-dasharray=\"4 2.5\" d=\"M0 0l50 .2v79.8M1 1h1.5\"/>";
        assert!(document.contains(path), "{document}");
        assert!(document.contains("d=\"M3 5a2 2 0 1 0 4 0a2 2 0 1 0-4 0z\""), "{document}");
    }

    #[test]
    fn relative_steps_do_not_drift() {
        let mut drawing = Drawing::new(100.0, 100.0);
        let points: Vec<Point> = (0..=999).map(|k| (0.1 * f64::from(k) / 3.0, f64::from(k % 2))).collect();
        drawing.line(points, Stroke::solid(BLACK, 1.0));
        let document = svg(&drawing);
        let path = document.split(" d=\"M").last().unwrap().split('"').next().unwrap();
        let across: f64 =
            path.split('l').skip(1).map(|step| step.split([' ', '-']).next().unwrap().parse::<f64>().unwrap()).sum();
        assert!((across - 33.3).abs() < 1e-9, "{across}");
    }
}

//! Writes a drawing as SVG: real paths, real text, a generic font family at the end of the list.

use std::fmt::Write;

use super::drawing::{Anchor, Color, Drawing, Point, Shape, Stroke, Text, Weight};
use super::font::SVG_FAMILY;

/// Formats a drawing as a self-contained SVG document; equal drawings give equal bytes.
pub fn document(drawing: &Drawing) -> String {
    let (width, height) = (number(drawing.width), number(drawing.height));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"{SVG_FAMILY}\" stroke-linejoin=\"round\">\n"
    );
    if !drawing.title.is_empty() {
        let _ = writeln!(svg, "<title>{}</title>", escaped(&drawing.title));
    }
    let _ = writeln!(svg, "<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>");
    for shape in &drawing.shapes {
        match shape {
            Shape::Path { points, closed, fill, stroke } => path(&mut svg, points, *closed, *fill, *stroke),
            Shape::Text(content) => text(&mut svg, content),
        }
    }
    svg.push_str("</svg>\n");
    svg
}

fn path(svg: &mut String, points: &[Point], closed: bool, fill: Option<Color>, stroke: Option<Stroke>) {
    svg.push_str("<path d=\"");
    for (index, point) in points.iter().enumerate() {
        let separator = ["M", "L", " "][index.min(2)];
        let _ = write!(svg, "{separator}{},{}", number(point.0), number(point.1));
    }
    let fill = fill.map_or_else(|| "none".to_owned(), hex);
    let _ = write!(svg, "{}\" fill=\"{fill}\"", if closed { "Z" } else { "" });
    if let Some(Stroke { color, width, dash }) = stroke {
        let _ = write!(svg, " stroke=\"{}\" stroke-width=\"{}\"", hex(color), number(width));
        if !dash.is_empty() {
            let lengths: Vec<String> = dash.iter().map(|&length| number(length)).collect();
            let _ = write!(svg, " stroke-dasharray=\"{}\"", lengths.join(" "));
        }
    }
    svg.push_str("/>\n");
}

fn text(svg: &mut String, text: &Text) {
    let (x, y) = (number(text.at.0), number(text.at.1));
    let _ = write!(svg, "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" fill=\"{}\"", number(text.size), hex(text.color));
    match text.anchor {
        Anchor::Start => {}
        Anchor::Middle => svg.push_str(" text-anchor=\"middle\""),
        Anchor::End => svg.push_str(" text-anchor=\"end\""),
    }
    if text.weight == Weight::Bold {
        svg.push_str(" font-weight=\"600\"");
    }
    if text.upwards {
        let _ = write!(svg, " transform=\"rotate(-90 {x} {y})\"");
    }
    let _ = writeln!(svg, ">{}</text>", escaped(&text.content));
}

fn hex(Color(red, green, blue): Color) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Two decimals at most, no negative zero.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_have_no_negative_zero() {
        assert_eq!([number(1.5), number(-0.001), number(20.0), number(1.0 / 3.0)], ["1.5", "0", "20", "0.33"]);
    }

    #[test]
    fn markup_in_a_label_stays_text() {
        let mut drawing = Drawing::new(10.0, 10.0);
        drawing.text(Text::new("a < b & c", (1.0, 2.0), 8.0));
        assert!(document(&drawing).contains(">a &lt; b &amp; c</text>"));
    }
}

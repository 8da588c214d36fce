//! Draws the display list with plotters: elements on a drawing area over its SVG or its bitmap backend.
//!
//! plotters places corners and widths on whole units of a backend, so the backend's grid is finer than the page. An SVG
//! keeps that grid as its view box and opens at page size; a bitmap is averaged down to the pixels of the PNG, which
//! smooths all edges.

use plotters::backend::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text as Line};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, FontTransform, RGBColor, TextStyle};

use super::dash::dashes;
use super::drawing::{Anchor, Color, Drawing, Point, Shape, Stroke, Text};
use super::font;

/// Units of the SVG's grid per px of the page.
const SVG_GRID: f64 = 20.0;
/// Bitmap pixels averaged into one of the image, along each side.
const FINE: usize = 4;

/// An RGB image, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pixels {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Three bytes per pixel.
    pub rgb: Vec<u8>,
}

/// Formats a drawing as a self-contained SVG document; equal drawings give equal bytes.
///
/// # Errors
/// What plotters says.
pub fn svg(drawing: &Drawing) -> Result<String, String> {
    let mut document = String::new();
    let size @ (columns, rows) = (whole(drawing.width * SVG_GRID), whole(drawing.height * SVG_GRID));
    paint(drawing, SVGBackend::with_string(&mut document, size), Medium::Vector)?;
    // The opening tag is rewritten: page size, round corners, a title for screen readers.
    let shapes = document.split_once('>').map_or("", |(_, shapes)| shapes.trim_start());
    let (width, height) = (drawing.width, drawing.height);
    let title = drawing.title.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {columns} {rows}\" role=\"img\" stroke-linejoin=\"round\">\n<title>{title}</title>\n{shapes}"
    ))
}

/// Paints a drawing at `scale` pixels per px of the page.
///
/// # Errors
/// What plotters says.
pub fn pixels(drawing: &Drawing, scale: f64) -> Result<Pixels, String> {
    let (width, height) = (whole(drawing.width * scale) as usize, whole(drawing.height * scale) as usize);
    let mut fine = vec![0; 3 * FINE * FINE * width * height];
    let size = ((FINE * width) as u32, (FINE * height) as u32);
    paint(drawing, BitMapBackend::with_buffer(&mut fine, size), Medium::Pixels { grid: scale * FINE as f64 })?;
    Ok(Pixels { width, height, rgb: averaged(&fine, width) })
}

/// Averages squares of `FINE` by `FINE` pixels; `width` is that of the result.
fn averaged(fine: &[u8], width: usize) -> Vec<u8> {
    let count = (FINE * FINE) as u16;
    let mut rgb = Vec::with_capacity(fine.len() / (FINE * FINE));
    let mut columns = vec![0_u16; 3 * FINE * width];
    for rows in fine.chunks_exact((FINE * columns.len()).max(1)) {
        columns.fill(0);
        for row in rows.chunks_exact(columns.len()) {
            columns.iter_mut().zip(row).for_each(|(sum, &byte)| *sum += u16::from(byte));
        }
        for square in columns.chunks_exact(3 * FINE) {
            let sum = |channel: usize| square[channel..].iter().step_by(3).sum::<u16>();
            rgb.extend([0, 1, 2].map(|channel| ((sum(channel) + count / 2) / count) as u8));
        }
    }
    rgb
}

/// What plotters' backends do differently.
#[derive(Debug, Clone, Copy)]
enum Medium {
    /// The viewer joins the corners of a line and lays out the text.
    Vector,
    /// Corners are inclusive pixels, a line of several segments is one even-odd polygon, text hangs from half its size.
    Pixels { grid: f64 },
}

fn paint<DB: DrawingBackend>(drawing: &Drawing, backend: DB, medium: Medium) -> Result<(), String> {
    let page = backend.into_drawing_area();
    let painted = page.fill(&rgb(Color::WHITE)).and_then(|()| {
        drawing.shapes.iter().try_for_each(|shape| match shape {
            Shape::Path { points, closed, fill, stroke } => {
                if let Some(color) = fill {
                    medium.fill(&page, points, *color)?;
                }
                stroke.map_or(Ok(()), |stroke| medium.outline(&page, points, *closed, stroke))
            }
            Shape::Text(text) => medium.text(&page, text),
        })
    });
    painted.and_then(|()| page.present()).map_err(|error| error.to_string())
}

type Page<DB> = DrawingArea<DB, plotters::coord::Shift>;
type Painted<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

impl Medium {
    fn grid(self) -> f64 {
        match self {
            Medium::Vector => SVG_GRID,
            Medium::Pixels { grid } => grid,
        }
    }

    fn unit(self, point: Point) -> (i32, i32) {
        ((point.0 * self.grid()).round() as i32, (point.1 * self.grid()).round() as i32)
    }

    fn fill<DB: DrawingBackend>(self, page: &Page<DB>, points: &[Point], color: Color) -> Painted<DB> {
        let corners: Vec<_> = points.iter().map(|&point| self.unit(point)).collect();
        let style = rgb(color).filled();
        match corners[..] {
            [a, b, c, d] if (a.1, b.0, c.1, d.0) == (b.1, c.0, d.1, a.0) => page.draw(&Rectangle::new([a, c], style)),
            _ => page.draw(&Polygon::new(corners, style)),
        }
    }

    fn outline<DB: DrawingBackend>(
        self,
        page: &Page<DB>,
        points: &[Point],
        closed: bool,
        stroke: Stroke,
    ) -> Painted<DB> {
        // A ring goes on to its second corner, so that the first one is joined, too.
        let again = if closed { points.iter().take(2) } else { [].iter().take(0) };
        let path: Vec<Point> = points.iter().chain(again).copied().collect();
        dashes(&path, stroke.dash).iter().try_for_each(|piece| self.line(page, piece, stroke))
    }

    fn line<DB: DrawingBackend>(self, page: &Page<DB>, points: &[Point], stroke: Stroke) -> Painted<DB> {
        let (color, width) = (rgb(stroke.color), stroke.width * self.grid());
        match self {
            Medium::Vector => {
                let path: Vec<_> = points.iter().map(|&point| self.unit(point)).collect();
                page.draw(&PathElement::new(path, color.stroke_width(whole(width))))
            }
            Medium::Pixels { .. } => {
                // With an odd width, the line covers the next even number of pixels, half of them either side.
                let half = whole(0.5 * width).max(1);
                let style = color.stroke_width(2 * half - 1);
                let path: Vec<_> = points.iter().map(|&point| self.unit(point)).map(|(x, y)| (x - 1, y - 1)).collect();
                path.windows(2).try_for_each(|pair| page.draw(&PathElement::new(pair, style)))?;
                let corners = path.iter().skip(1).take(path.len().saturating_sub(2));
                corners.copied().try_for_each(|at| page.draw(&Circle::new(at, half - 1, color.filled())))
            }
        }
    }

    fn text<DB: DrawingBackend>(self, page: &Page<DB>, text: &Text) -> Painted<DB> {
        let em = text.size * self.grid();
        // plotters' size of the text, and how far its top anchor is above the baseline.
        let (size, above) = match self {
            Medium::Vector => (1.24 * em, 0.76 * em),
            Medium::Pixels { .. } => {
                let half = (0.5 * em * font::LINE_HEIGHT).round().max(1.0);
                (2.0 * half, half)
            }
        };
        let (x, y) = (text.at.0 * self.grid(), text.at.1 * self.grid());
        let (at, turned) = match text.upwards {
            true => ((x - above, y), FontTransform::Rotate270),
            false => ((x, y - above), FontTransform::None),
        };
        let across = match text.anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let style = TextStyle::from(font::face(size, text.weight).transform(turned)).pos(Pos::new(across, VPos::Top));
        let at = (at.0.round() as i32, at.1.round() as i32);
        page.draw(&Line::new(text.content.as_str(), at, style.color(&rgb(text.color))))
    }
}

fn rgb(Color(red, green, blue): Color) -> RGBColor {
    RGBColor(red, green, blue)
}

fn whole(length: f64) -> u32 {
    length.round() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Color = Color(0, 0, 0);

    fn paint(drawing: &Drawing, scale: f64) -> Pixels {
        pixels(drawing, scale).expect("a drawing in memory")
    }

    fn grey(pixels: &Pixels, column: usize, row: usize) -> u8 {
        pixels.rgb[3 * (row * pixels.width + column)]
    }

    #[test]
    fn a_half_covered_pixel_is_half_grey() {
        let mut drawing = Drawing::new(4.0, 4.0);
        drawing.area(vec![(1.0, 1.0), (2.5, 1.0), (2.5, 3.0), (1.0, 3.0)], Some(BLACK), None);
        let pixels = paint(&drawing, 1.0);
        assert_eq!([grey(&pixels, 0, 1), grey(&pixels, 1, 1), grey(&pixels, 3, 1)], [255, 0, 255]);
        assert!(grey(&pixels, 2, 1).abs_diff(128) <= 1);
    }

    #[test]
    fn a_hairline_on_whole_pixels_is_sharp() {
        let mut drawing = Drawing::new(6.0, 6.0);
        drawing.line(vec![(0.0, 2.5), (6.0, 2.5)], Stroke::solid(BLACK, 1.0));
        drawing.line(vec![(3.5, 0.0), (3.5, 6.0)], Stroke::solid(BLACK, 1.0));
        let pixels = paint(&drawing, 2.0);
        let column: Vec<u8> = (0..12).map(|row| grey(&pixels, 1, row)).collect();
        assert_eq!(column, [255, 255, 255, 255, 0, 0, 255, 255, 255, 255, 255, 255]);
        let row: Vec<u8> = (0..12).map(|column| grey(&pixels, column, 1)).collect();
        assert_eq!(row, [255, 255, 255, 255, 255, 255, 0, 0, 255, 255, 255, 255]);
    }

    #[test]
    fn a_line_that_crosses_itself_is_not_darker_there_and_leaves_no_hole() {
        let mut drawing = Drawing::new(9.0, 9.0);
        let bow = vec![(0.0, 4.5), (9.0, 4.5), (9.0, 0.0), (4.5, 0.0), (4.5, 9.0)];
        drawing.line(bow, Stroke::solid(BLACK, 1.0));
        let pixels = paint(&drawing, 2.0);
        assert_eq!([grey(&pixels, 4, 8), grey(&pixels, 8, 8), grey(&pixels, 8, 15)], [0, 0, 0]);
    }

    #[test]
    fn shapes_beyond_the_page_are_cut_off() {
        let mut drawing = Drawing::new(4.0, 4.0);
        drawing.disc((0.0, 0.0), 50.0, Some(BLACK), None);
        assert!(paint(&drawing, 2.0).rgb.iter().all(|&byte| byte == 0));
    }

    #[test]
    fn a_capital_stands_on_its_baseline_whichever_way_it_reads() {
        let ink = |text: Text| {
            let mut drawing = Drawing::new(60.0, 60.0);
            drawing.text(text.anchored(Anchor::Middle));
            let pixels = paint(&drawing, 1.0);
            let dark: Vec<_> =
                (0..3600).map(|k| (k % 60, k / 60)).filter(|&(x, y)| grey(&pixels, x, y) < 128).collect();
            let span = |along: fn(&(usize, usize)) -> usize| {
                (dark.iter().map(along).min().unwrap_or(0), dark.iter().map(along).max().unwrap_or(0) + 1)
            };
            (span(|p| p.0), span(|p| p.1))
        };
        let cap = (font::CAP_HEIGHT * 40.0).round() as usize;
        let (across, up) = ink(Text::new("H", (30.0, 45.0), 40.0));
        assert!(
            up.1 == 45 && up.0.abs_diff(45 - cap) <= 1 && (across.0 + across.1).abs_diff(60) <= 8,
            "{across:?} {up:?}"
        );
        let (across, up) = ink(Text::new("H", (45.0, 30.0), 40.0).upwards());
        assert!(
            across.1 == 45 && across.0.abs_diff(45 - cap) <= 1 && (up.0 + up.1).abs_diff(60) <= 8,
            "{across:?} {up:?}"
        );
    }

    #[test]
    fn markup_in_a_label_stays_text_in_a_family_with_a_fallback() {
        let mut drawing = Drawing::new(10.0, 10.0);
        drawing.title = "a < b".to_owned();
        drawing.text(Text::new("a < b & c", (1.0, 2.0), 8.0));
        let document = svg(&drawing).expect("a drawing in memory");
        assert!(document.contains("\na &lt; b &amp; c\n</text>") && document.contains("<title>a &lt; b</title>"));
        assert!(document.contains(", sans-serif\""), "{document}");
        assert!(
            document.starts_with("<svg ") && document.contains(" width=\"10\" height=\"10\" viewBox=\"0 0 200 200\"")
        );
    }
}

//! Draws the display list with plotters, as elements on a drawing area over its bitmap backend.
//!
//! plotters places corners and widths on whole units of a backend, so the backend's grid is finer than the page, and is
//! averaged down to the pixels of the PNG, which smooths all edges. The SVG is written by `vector`, with what plotters'
//! backend lacks.

use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text as Line};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, FontTransform, RGBColor, TextStyle};

use super::dash::dashes;
use super::drawing::{Anchor, Color, Drawing, Point, Shape, Stroke, Text};
use super::font;

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

/// Paints a drawing at `scale` pixels per px of the page.
///
/// # Errors
/// What plotters says.
pub fn pixels(drawing: &Drawing, scale: f64) -> Result<Pixels, String> {
    let (width, height) = (whole(drawing.width * scale) as usize, whole(drawing.height * scale) as usize);
    let mut fine = vec![0; 3 * FINE * FINE * width * height];
    let size = ((FINE * width) as u32, (FINE * height) as u32);
    paint(drawing, BitMapBackend::with_buffer(&mut fine, size), Grid(scale * FINE as f64))?;
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

/// A grid of so many units per px of the page. Corners are inclusive pixels, a line of several segments is one even-odd
/// polygon, text hangs from half its size.
#[derive(Debug, Clone, Copy)]
struct Grid(f64);

fn paint(drawing: &Drawing, backend: BitMapBackend<'_>, grid: Grid) -> Result<(), String> {
    let page = backend.into_drawing_area();
    let path = |points: &[Point], closed, fill: Option<Color>, stroke: Option<Stroke>| {
        if let Some(color) = fill {
            grid.fill(&page, points, color)?;
        }
        stroke.map_or(Ok(()), |stroke| grid.outline(&page, points, closed, stroke))
    };
    let painted = page.fill(&rgb(Color::WHITE)).and_then(|()| {
        drawing.shapes.iter().try_for_each(|shape| match shape {
            Shape::Path { points, closed, fill, stroke } => path(points, *closed, *fill, *stroke),
            Shape::Disc { centre, radius, fill, stroke } => path(&corners(*centre, *radius), true, *fill, *stroke),
            Shape::Text(text) => grid.text(&page, text),
            Shape::Open(..) | Shape::Close => Ok(()),
        })
    });
    painted.and_then(|()| page.present()).map_err(|error| error.to_string())
}

/// A disc as a polygon that looks round.
fn corners(centre: Point, radius: f64) -> Vec<Point> {
    let count = (8.0 + 6.0 * radius.max(0.0).sqrt()).ceil();
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / count;
        (centre.0 + radius * angle.cos(), centre.1 + radius * angle.sin())
    };
    (0..count as usize).map(corner).collect()
}

type Page<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;
type Painted = Result<(), DrawingAreaErrorKind<<BitMapBackend<'static> as DrawingBackend>::ErrorType>>;

impl Grid {
    fn unit(self, point: Point) -> (i32, i32) {
        ((point.0 * self.0).round() as i32, (point.1 * self.0).round() as i32)
    }

    fn fill(self, page: &Page<'_>, points: &[Point], color: Color) -> Painted {
        let corners: Vec<_> = points.iter().map(|&point| self.unit(point)).collect();
        let style = rgb(color).filled();
        match corners[..] {
            [a, b, c, d] if (a.1, b.0, c.1, d.0) == (b.1, c.0, d.1, a.0) => page.draw(&Rectangle::new([a, c], style)),
            _ => page.draw(&Polygon::new(corners, style)),
        }
    }

    fn outline(self, page: &Page<'_>, points: &[Point], closed: bool, stroke: Stroke) -> Painted {
        // A ring goes on to its second corner, so that the first one is joined, too.
        let again = if closed { points.iter().take(2) } else { [].iter().take(0) };
        let path: Vec<Point> = points.iter().chain(again).copied().collect();
        dashes(&path, stroke.dash).iter().try_for_each(|piece| self.line(page, piece, stroke))
    }

    fn line(self, page: &Page<'_>, points: &[Point], stroke: Stroke) -> Painted {
        let color = rgb(stroke.color);
        // With an odd width, the line covers the next even number of pixels, half of them either side.
        let half = whole(0.5 * stroke.width * self.0).max(1);
        let style = color.stroke_width(2 * half - 1);
        let path: Vec<_> = points.iter().map(|&point| self.unit(point)).map(|(x, y)| (x - 1, y - 1)).collect();
        path.windows(2).try_for_each(|pair| page.draw(&PathElement::new(pair, style)))?;
        let corners = path.iter().skip(1).take(path.len().saturating_sub(2));
        corners.copied().try_for_each(|at| page.draw(&Circle::new(at, half - 1, color.filled())))
    }

    fn text(self, page: &Page<'_>, text: &Text) -> Painted {
        // plotters' size of the text, and how far its top anchor is above the baseline.
        let above = (0.5 * text.size * self.0 * font::LINE_HEIGHT).round().max(1.0);
        let (x, y) = (text.at.0 * self.0, text.at.1 * self.0);
        let (at, turned) = match text.upwards {
            true => ((x - above, y), FontTransform::Rotate270),
            false => ((x, y - above), FontTransform::None),
        };
        let across = match text.anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let style = TextStyle::from(font::face(2.0 * above, text.weight).transform(turned));
        let at = (at.0.round() as i32, at.1.round() as i32);
        let style = style.pos(Pos::new(across, VPos::Top));
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
}

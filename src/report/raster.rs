//! Paints a drawing into pixels with smooth edges.
//!
//! plotters' own bitmap lines have whole-pixel corners and widths and no smoothing for thick lines, too coarse for a
//! figure; here an area is filled by scan lines (non-zero winding, eight per pixel row, exact coverage along the row).
//! Letters come from plotters' font renderer at four times the resolution.

use super::drawing::{Color, Drawing, Point, Shape, Text};
use super::{font, stroke};

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

/// Scan lines per pixel row.
const SCANS: usize = 8;
/// Letters are rendered this much larger and averaged.
const LETTER_DETAIL: i32 = 4;

/// Paints a drawing at `scale` pixels per px of the page.
pub fn paint(drawing: &Drawing, scale: f64) -> Pixels {
    let (width, height) = ((drawing.width * scale).round() as usize, (drawing.height * scale).round() as usize);
    let mut pixels = Pixels { width, height, rgb: vec![255; 3 * width * height] };
    let enlarge = |points: &[Point]| points.iter().map(|p| (p.0 * scale, p.1 * scale)).collect::<Vec<_>>();
    for shape in &drawing.shapes {
        match shape {
            Shape::Path { points, closed, fill, stroke } => {
                if let Some(color) = fill {
                    pixels.fill(&[enlarge(points)], *color);
                }
                if let Some(line) = stroke {
                    let polygons = stroke::outline(points, *closed, line);
                    pixels.fill(&polygons.iter().map(|polygon| enlarge(polygon)).collect::<Vec<_>>(), line.color);
                }
            }
            Shape::Text(text) => pixels.letters(text, scale),
        }
    }
    pixels
}

/// One side of a polygon, downwards.
struct Edge {
    top: Point,
    bottom: Point,
    winding: i32,
}

impl Pixels {
    /// Fills the union of polygons (of equal orientation) with a colour.
    fn fill(&mut self, polygons: &[Vec<Point>], color: Color) {
        let mut edges = Vec::new();
        for polygon in polygons {
            for (&a, &b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
                if a.1 < b.1 {
                    edges.push(Edge { top: a, bottom: b, winding: 1 });
                } else if b.1 < a.1 {
                    edges.push(Edge { top: b, bottom: a, winding: -1 });
                }
            }
        }
        edges.sort_by(|a, b| a.top.1.total_cmp(&b.top.1));
        let Some(first) = edges.first() else { return };
        let lowest = edges.iter().map(|edge| edge.bottom.1).fold(f64::NEG_INFINITY, f64::max);
        let rows = (first.top.1.max(0.0) as usize)..(lowest.max(0.0).ceil() as usize).min(self.height);

        let (mut next, mut active) = (0, Vec::<usize>::new());
        let mut coverage = vec![0.0; self.width];
        let mut crossings = Vec::new();
        for row in rows {
            let (mut left, mut right) = (self.width, 0);
            for scan in 0..SCANS {
                let y = row as f64 + (scan as f64 + 0.5) / SCANS as f64;
                while next < edges.len() && edges[next].top.1 <= y {
                    active.push(next);
                    next += 1;
                }
                active.retain(|&edge| edges[edge].bottom.1 > y);
                crossings.clear();
                crossings.extend(active.iter().map(|&edge| {
                    let Edge { top, bottom, winding } = &edges[edge];
                    (top.0 + (y - top.1) / (bottom.1 - top.1) * (bottom.0 - top.0), *winding)
                }));
                crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
                let mut winding = 0;
                for pair in crossings.windows(2) {
                    winding += pair[0].1;
                    if winding != 0 {
                        let span = self.cover(&mut coverage, pair[0].0, pair[1].0);
                        (left, right) = (left.min(span.0), right.max(span.1));
                    }
                }
            }
            for (column, share) in coverage.iter_mut().enumerate().take(right).skip(left) {
                if *share > 0.0 {
                    self.blend(column, row, color, *share);
                    *share = 0.0;
                }
            }
        }
    }

    /// Adds one scan line's span to the coverage of a row; returns the columns it touched.
    fn cover(&self, coverage: &mut [f64], from: f64, to: f64) -> (usize, usize) {
        let (from, to) = (from.clamp(0.0, self.width as f64), to.clamp(0.0, self.width as f64));
        let (first, last) = (from as usize, (to.ceil() as usize).min(self.width));
        for (column, share) in coverage.iter_mut().enumerate().take(last).skip(first) {
            let inside = to.min(column as f64 + 1.0) - from.max(column as f64);
            *share += inside.max(0.0) / SCANS as f64;
        }
        (first, last)
    }

    fn blend(&mut self, column: usize, row: usize, color: Color, share: f64) {
        let at = 3 * (row * self.width + column);
        let below = Color(self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]);
        let Color(red, green, blue) = below.mix(color, share.min(1.0));
        self.rgb[at..at + 3].copy_from_slice(&[red, green, blue]);
    }

    fn letters(&mut self, text: &Text, scale: f64) {
        let detail = f64::from(LETTER_DETAIL) * scale;
        let (lead_x, lead_y) = if text.upwards { (0.0, text.lead()) } else { (-text.lead(), 0.0) };
        let origin_x = ((text.at.0 + lead_x) * detail).round() as i32;
        let origin_y = ((text.at.1 + lead_y) * detail).round() as i32;
        let mut touched = std::collections::BTreeMap::<(i32, i32), f64>::new();
        font::rasterise(&text.content, text.size * detail, text.weight, |x, y, share| {
            let (x, y) = if text.upwards { (y, -x - 1) } else { (x, y) };
            let pixel = ((origin_y + y).div_euclid(LETTER_DETAIL), (origin_x + x).div_euclid(LETTER_DETAIL));
            *touched.entry(pixel).or_default() += share / f64::from(LETTER_DETAIL * LETTER_DETAIL);
        });
        for ((row, column), share) in touched {
            if (0..self.height as i32).contains(&row) && (0..self.width as i32).contains(&column) {
                self.blend(column as usize, row as usize, text.color, share);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::drawing::Stroke;
    use super::*;

    fn grey(pixels: &Pixels, column: usize, row: usize) -> u8 {
        pixels.rgb[3 * (row * pixels.width + column)]
    }

    #[test]
    fn a_half_covered_pixel_is_half_grey() {
        let mut drawing = Drawing::new(4.0, 4.0);
        drawing.area(vec![(1.0, 1.0), (2.5, 1.0), (2.5, 3.0), (1.0, 3.0)], Some(Color(0, 0, 0)), None);
        let pixels = paint(&drawing, 1.0);
        assert_eq!([grey(&pixels, 0, 1), grey(&pixels, 1, 1), grey(&pixels, 3, 1)], [255, 0, 255]);
        assert!(grey(&pixels, 2, 1).abs_diff(128) <= 1);
    }

    #[test]
    fn a_line_that_crosses_itself_is_not_darker_there_and_leaves_no_hole() {
        let mut drawing = Drawing::new(9.0, 9.0);
        let bow = vec![(0.0, 4.5), (9.0, 4.5), (9.0, 0.0), (4.5, 0.0), (4.5, 9.0)];
        drawing.line(bow, Stroke::solid(Color(0, 0, 0), 1.0));
        let pixels = paint(&drawing, 1.0);
        assert_eq!([grey(&pixels, 2, 4), grey(&pixels, 4, 4), grey(&pixels, 4, 7)], [0, 0, 0]);
    }

    #[test]
    fn shapes_beyond_the_page_are_cut_off() {
        let mut drawing = Drawing::new(4.0, 4.0);
        drawing.disc((0.0, 0.0), 50.0, Some(Color(0, 0, 0)), None);
        assert!(paint(&drawing, 2.0).rgb.iter().all(|&byte| byte == 0));
    }
}

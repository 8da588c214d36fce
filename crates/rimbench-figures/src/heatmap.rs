//! A map of categories × values: one row per scheme, one column per step size, colour for a share in [0, 1].
//!
//! Light is 0 and dark blue is 1, monotone in lightness, so that it also reads in grey. Hatching marks a cell whose
//! value needs a warning (stable but wrong); a cell without a value, skipped for a reason, is grey with a dash.

use plotters::style::RGBColor;
use plotters::style::colors::colormaps::{ColorMap, DerivedColorMap};

use super::axes::{AXIS, LABEL_SIZE, TICK, TICK_SIZE, TITLE_SIZE, tick_below};
use super::clip::Rect;
use super::drawing::{Anchor, Color, Datum, Drawing, PanelData, SeriesData, Stroke, Text, Weight};
use super::figure::fits;
use super::font;
use super::hatch::diagonals;
use super::ticks::signed;
use rimbench_core::error::Result;

const MARGIN: f64 = 14.0;
const ROW_LABEL: f64 = 9.6;
const SWATCH: f64 = 10.0;
const BAR_WIDTH: f64 = 12.0;
const BELOW: f64 = 38.0;
const KEY: f64 = 24.0;
const HATCH_DISTANCE: f64 = 6.0;

const STOPS: [RGBColor; 6] = [
    RGBColor(0xFD, 0xF4, 0xE3),
    RGBColor(0xD3, 0xE8, 0xD3),
    RGBColor(0x93, 0xCF, 0xC6),
    RGBColor(0x4F, 0xA3, 0xBF),
    RGBColor(0x2B, 0x6C, 0xA6),
    RGBColor(0x14, 0x35, 0x6B),
];
const SKIPPED: Color = Color(0xD9, 0xDC, 0xDF);

/// One cell.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cell {
    /// Share in [0, 1]; none if the combination was skipped.
    pub value: Option<f64>,
    /// What is written instead of it.
    pub shown: Option<f64>,
    /// Whether the value needs a warning.
    pub hatched: bool,
}

/// One row.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Category, usually a scheme.
    pub label: String,
    /// Colour of its swatch.
    pub color: Color,
    /// Cells in the order of the columns; missing ones count as skipped.
    pub cells: Vec<Cell>,
}

impl Row {
    /// The label without what is remarked of it.
    fn name(&self) -> &str {
        self.label.split(" (").next().unwrap_or_default()
    }
}

/// A whole map.
#[derive(Debug, Clone, PartialEq)]
pub struct Heatmap {
    /// Width, px.
    pub width: f64,
    /// Height, px.
    pub height: f64,
    /// Heading; may be empty.
    pub title: String,
    /// Quantity of the columns, with its unit.
    pub x_label: String,
    /// Value of each column, ascending. Columns are equally wide: a logarithmic grid comes out evenly spaced.
    pub columns: Vec<f64>,
    /// Names of the columns, read upwards, where they are no values.
    pub names: Vec<String>,
    /// Quantity of the cells, beside the colour bar.
    pub value_label: String,
    /// What grey cells mean, below the map; may be empty.
    pub skipped_label: String,
    /// What hatching means, below the map; may be empty.
    pub hatch_label: String,
    /// Writes the value into each cell that has room for it.
    pub show_values: bool,
    /// Rows from the top.
    pub rows: Vec<Row>,
}

/// Looks up the colour of a share in [0, 1].
pub fn color_of(share: f64) -> Color {
    let RGBColor(red, green, blue) = DerivedColorMap::new(&STOPS).get_color(share.clamp(0.0, 1.0));
    Color(red, green, blue)
}

impl Heatmap {
    /// Draws the map if its cells have room in it.
    ///
    /// # Errors
    /// [`Error::Incompatible`](rimbench_core::error::Error::Incompatible) if not.
    pub fn draw_if_it_fits(&self) -> Result<Drawing> {
        let area = self.area();
        let (width, height) = (area.right - area.left, area.bottom - area.top);
        fits(&[("width", self.width, width), ("height", self.height, height)]).map(|()| self.draw())
    }

    /// Where the cells stand.
    fn area(&self) -> Rect {
        let widest =
            self.rows.iter().map(|row| font::width(&row.label, ROW_LABEL, Weight::Regular)).fold(0.0, f64::max);
        let keys = self.has_skipped() || self.has_hatched();
        Rect {
            left: MARGIN + widest + SWATCH + 16.0,
            top: MARGIN + if self.title.is_empty() { 0.0 } else { TITLE_SIZE + 10.0 },
            right: self.width - MARGIN - BAR_WIDTH - 56.0,
            bottom: self.height - MARGIN - self.below() - if keys { KEY } else { 0.0 },
        }
    }

    /// Room below the cells for what the columns are, px.
    fn below(&self) -> f64 {
        let widest = self.names.iter().map(|name| font::width(name, TICK_SIZE, Weight::Regular)).fold(0.0, f64::max);
        let label = if self.x_label.is_empty() { 0.0 } else { LABEL_SIZE + 6.0 };
        if self.names.is_empty() { BELOW } else { widest + 12.0 + label }
    }

    /// Draws the map.
    pub fn draw(&self) -> Drawing {
        let mut drawing = Drawing::new(self.width, self.height);
        drawing.title.clone_from(&self.title);
        let (area, keys) = (self.area(), self.has_skipped() || self.has_hatched());
        drawing.text(Text::new(&self.title, (area.left, area.top - 10.0), TITLE_SIZE).bold());
        for (index, row) in self.rows.iter().enumerate() {
            drawing.group(row.name(), |drawing| self.draw_row(drawing, &area, index, row));
        }
        drawing.data = vec![self.data(&area)];
        self.draw_columns(&mut drawing, &area);
        self.draw_bar(&mut drawing, &area);
        if keys {
            self.draw_keys(&mut drawing, &area);
        }
        drawing
    }

    /// The data of the map: a series per row.
    fn data(&self, area: &Rect) -> PanelData {
        let datum = |index: usize, column: usize, cell: &Cell| Datum {
            x: self.columns[column],
            y: cell.value.unwrap_or(f64::NAN),
            range: None,
            note: {
                let said = match (cell.value, cell.hatched) {
                    (None, _) => self.skipped_label.as_str(),
                    (_, true) => self.hatch_label.as_str(),
                    _ => "",
                };
                let column = self.names.get(column).map_or_else(String::new, |name| match cell.shown {
                    Some(shown) => format!("{name}: {shown}"),
                    None => name.clone(),
                });
                [column.as_str(), said].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
            },
            at: Some(self.cell(area, index, column).centre()),
        };
        let series = |(index, row): (usize, &Row)| SeriesData {
            name: row.name().to_owned(),
            points: (0..self.columns.len())
                .map(|column| datum(index, column, row.cells.get(column).unwrap_or(&Cell::default())))
                .collect(),
        };
        PanelData {
            title: self.title.clone(),
            x: self.x_label.clone(),
            y: self.value_label.clone(),
            series: self.rows.iter().enumerate().map(series).collect(),
        }
    }

    fn cell(&self, area: &Rect, row: usize, column: usize) -> Rect {
        let width = area.width() / self.columns.len().max(1) as f64;
        let height = area.height() / self.rows.len().max(1) as f64;
        let (left, top) = (area.left + column as f64 * width, area.top + row as f64 * height);
        Rect { left, top, right: left + width, bottom: top + height }
    }

    fn draw_row(&self, drawing: &mut Drawing, area: &Rect, index: usize, row: &Row) {
        let middle = self.cell(area, index, 0).centre().1;
        let swatch_left = area.left - 8.0 - SWATCH;
        let half = 0.5 * SWATCH;
        let swatch = Rect { left: swatch_left, top: middle - half, right: swatch_left + SWATCH, bottom: middle + half };
        drawing.area(swatch.inset(1.0).corners(), Some(row.color), None);
        let label = Text::new(&row.label, (swatch_left - 6.0, middle), ROW_LABEL).anchored(Anchor::End);
        drawing.text(label.centred());
        for column in 0..self.columns.len() {
            let cell = row.cells.get(column).copied().unwrap_or_default();
            self.draw_cell(drawing, &self.cell(area, index, column).inset(0.75), cell);
        }
    }

    fn draw_cell(&self, drawing: &mut Drawing, place: &Rect, cell: Cell) {
        let Some(share) = cell.value.filter(|share| !share.is_nan()) else {
            drawing.area(place.corners(), Some(SKIPPED), None);
            let (x, y) = place.centre();
            drawing.line(vec![(x - 4.0, y), (x + 4.0, y)], Stroke::solid(Color(0x8A, 0x91, 0x98), 1.4));
            return;
        };
        let color = color_of(share);
        drawing.area(place.corners(), Some(color), None);
        if cell.hatched {
            hatch(drawing, place, on(color));
        }
        let number = cell.shown.map_or_else(|| signed(format!("{share:.2}")), |shown| format!("{shown}"));
        let number = Text::new(number, place.centre(), 9.4);
        let number = number.anchored(Anchor::Middle).colored(on(color)).centred();
        let half = 0.5 * number.width() + 2.0;
        if self.show_values && 2.0 * half + 2.0 <= place.width() && place.height() >= 12.0 {
            if cell.hatched {
                let (x, y) = place.centre();
                let patch = Rect { left: x - half, top: y - 5.6, right: x + half, bottom: y + 5.6 };
                drawing.area(patch.corners(), Some(color), None);
            }
            drawing.text(number);
        }
    }

    fn draw_columns(&self, drawing: &mut Drawing, area: &Rect) {
        if !self.names.is_empty() {
            let step = area.width() / self.names.len() as f64;
            for (column, name) in self.names.iter().enumerate() {
                let at = (area.left + (column as f64 + 0.5) * step, area.bottom + 7.0);
                let text = Text::new(name, at, TICK_SIZE).anchored(Anchor::End).upwards().centred();
                drawing.text(text.colored(Color::SOFT_INK));
            }
            let label = Text::new(&self.x_label, (area.centre().0, area.bottom + self.below() - 4.0), LABEL_SIZE);
            drawing.text(label.anchored(Anchor::Middle));
            return;
        }
        let labels: Vec<String> = self.columns.iter().map(|value| signed(format!("{value}"))).collect();
        let widest = labels.iter().map(|l| font::width(l, TICK_SIZE, Weight::Regular)).fold(0.0, f64::max);
        let step = area.width() / labels.len().max(1) as f64;
        let stride = ((widest + 7.0) / step).ceil().max(1.0) as usize;
        for (column, label) in labels.iter().enumerate() {
            let at = (area.left + (column as f64 + 0.5) * step, area.bottom + 1.0);
            tick_below(drawing, at, if column % stride == 0 { label } else { "" });
        }
        let label = Text::new(&self.x_label, (area.centre().0, area.bottom + 32.0), LABEL_SIZE);
        drawing.text(label.anchored(Anchor::Middle));
    }

    fn draw_bar(&self, drawing: &mut Drawing, area: &Rect) {
        let (left, right) = (area.right + 16.0, area.right + 16.0 + BAR_WIDTH);
        let steps = 64;
        let height = |share: f64| area.bottom - share * area.height();
        for k in 0..steps {
            let (low, high) = (f64::from(k) / f64::from(steps), f64::from(k + 1) / f64::from(steps));
            // Each slice reaches down to the bottom, so that no seam shows between slices.
            let slice = Rect { left, top: height(1.0 - low), right, bottom: area.bottom };
            drawing.area(slice.corners(), Some(color_of(1.0 - 0.5 * (low + high))), None);
        }
        drawing.area(Rect { left, right, ..*area }.corners(), None, Some(AXIS));
        for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let y = height(share);
            drawing.line(vec![(right, y), (right + TICK, y)], AXIS);
            let text = Text::new(format!("{share}"), (right + 6.0, y), TICK_SIZE);
            drawing.text(text.colored(Color::SOFT_INK).centred());
        }
        let place = (self.width - MARGIN - 0.5 * LABEL_SIZE, area.centre().1);
        drawing.text(Text::new(&self.value_label, place, LABEL_SIZE).anchored(Anchor::Middle).upwards().centred());
    }

    fn draw_keys(&self, drawing: &mut Drawing, area: &Rect) {
        let y = area.bottom + self.below() + 12.0;
        let mut left = area.left;
        let keys = [
            (self.has_skipped(), &self.skipped_label, Cell::default()),
            (self.has_hatched(), &self.hatch_label, Cell { value: Some(0.6), shown: None, hatched: true }),
        ];
        for (_, label, cell) in keys.iter().filter(|(used, label, _)| *used && !label.is_empty()) {
            let sample = Rect { left, top: y - 7.0, right: left + 22.0, bottom: y + 7.0 };
            match cell.value {
                Some(_) => {
                    drawing.area(sample.corners(), Some(Color::WHITE), Some(Stroke::solid(Color::SOFT_INK, 0.8)));
                    hatch(drawing, &sample, Color::SOFT_INK);
                }
                None => self.draw_cell(drawing, &sample, *cell),
            }
            let text = Text::new(*label, (sample.right + 7.0, y), LABEL_SIZE).centred();
            left = sample.right + 7.0 + text.width() + 26.0;
            drawing.text(text);
        }
    }

    fn has_skipped(&self) -> bool {
        let skipped = |row: &Row| row.cells.len() < self.columns.len() || row.cells.iter().any(|c| c.value.is_none());
        self.rows.iter().any(skipped)
    }

    fn has_hatched(&self) -> bool {
        self.rows.iter().flat_map(|row| &row.cells).any(|cell| cell.hatched && cell.value.is_some())
    }
}

/// Legible on top of `color`.
fn on(color: Color) -> Color {
    if color.luminance() > 0.55 { Color::INK } else { Color::WHITE }
}

fn hatch(drawing: &mut Drawing, place: &Rect, color: Color) {
    for (from, to) in diagonals(place, HATCH_DISTANCE) {
        drawing.line(vec![from, to], Stroke::solid(color, 0.9));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colour_scale_is_monotone_in_lightness() {
        let lightness: Vec<f64> = (0..=100).map(|k| color_of(f64::from(k) / 100.0).luminance()).collect();
        assert!(lightness.windows(2).all(|pair| pair[1] <= pair[0] + 0.004), "{lightness:?}");
        assert_eq!([color_of(0.0), color_of(1.0)], [Color(0xFD, 0xF4, 0xE3), Color(0x14, 0x35, 0x6B)]);
    }
}

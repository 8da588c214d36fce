//! A dot matrix: a row per scheme, a column per macro step or limit, and in each cell a sign for what became of the runs.

use super::axes::{LABEL_SIZE, TICK_SIZE, TITLE_SIZE};
use super::data::MARKER;
use super::dots::{DotRow, Sample, draw_key, draw_row_label, key_lines, labels_width};
use super::drawing::{Anchor, Color, Datum, Drawing, PanelData, SeriesData, Stroke, Text};
use super::figure::fits;
use super::marker;
use crate::line_style::Marker;
use rimbench_core::error::Result;

const MARGIN: f64 = 8.0;
const ROW: f64 = 16.0;
const ABOVE: f64 = TITLE_SIZE + 12.0;
const BELOW: f64 = 36.0;
const KEY_LINE: f64 = 14.0;
const BETWEEN: f64 = 26.0;
/// What [`Cell::Wrong`] means.
const WRONG: &str = "all complete, but the median error is above a tenth of the peak";
/// Radius of the disc around a count of one, and what the largest count adds, px.
const COUNT: [f64; 2] = [4.6, 3.2];

/// What became of the runs of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell {
    /// None was run.
    NotRun,
    /// All completed, and are right.
    Right,
    /// All completed, and are wrong.
    Wrong,
    /// This share failed.
    Lost(f64),
    /// Nothing is known of any, though they were run.
    Silent,
    /// So many of the problems belong here.
    Count(usize),
}

/// A column: its words, and its value in the data.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// What stands below it.
    pub label: String,
    /// Its value.
    pub value: f64,
}

/// Columns that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct MatrixPanel {
    /// Heading.
    pub title: String,
    /// Quantity of the columns.
    pub quantity: String,
    /// The columns, from the left.
    pub columns: Vec<Column>,
    /// Cells by row and column.
    pub cells: Vec<Vec<Cell>>,
}

/// The whole picture. Its height follows from its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// Width, px.
    pub width: f64,
    /// Rows from the top.
    pub rows: Vec<DotRow>,
    /// Panels, from the left.
    pub panels: Vec<MatrixPanel>,
}

impl Matrix {
    /// Draws the matrix if its columns have room in it.
    ///
    /// # Errors
    /// [`Error::Incompatible`](rimbench_core::error::Error::Incompatible) if not.
    pub fn draw(&self) -> Result<Drawing> {
        fits(&[("width", self.width, self.column_width() * 4.0)])?;
        let key = key_lines(self.key(), self.width);
        let (top, inside) = (MARGIN + ABOVE, ROW * self.rows.len() as f64);
        let height = top + inside + BELOW + KEY_LINE * key.len() as f64 + MARGIN;
        let mut drawing = Drawing::new(self.width, height);
        drawing.title = self.panels.iter().map(|panel| panel.title.as_str()).collect::<Vec<_>>().join("; ");
        let step = self.column_width();
        let mut left = MARGIN + labels_width(&self.rows);
        for (index, panel) in self.panels.iter().enumerate() {
            self.draw_panel(&mut drawing, panel, (left, top), step, index == 0);
            left += step * panel.columns.len() as f64 + BETWEEN;
        }
        for (index, entries) in key.iter().enumerate() {
            draw_key(&mut drawing, entries, self.width, top + inside + BELOW + 8.0 + KEY_LINE * index as f64);
        }
        Ok(drawing)
    }

    fn column_width(&self) -> f64 {
        let columns: usize = self.panels.iter().map(|panel| panel.columns.len()).sum();
        let between = BETWEEN * (self.panels.len().max(1) - 1) as f64;
        ((self.width - 2.0 * MARGIN - labels_width(&self.rows) - between) / columns.max(1) as f64).min(64.0)
    }

    fn draw_panel(
        &self,
        drawing: &mut Drawing,
        panel: &MatrixPanel,
        (left, top): (f64, f64),
        step: f64,
        labelled: bool,
    ) {
        let (right, bottom) = (left + step * panel.columns.len() as f64, top + ROW * self.rows.len() as f64);
        let counts = panel.cells.iter().flatten();
        let most = counts.filter_map(|cell| if let Cell::Count(count) = cell { Some(*count) } else { None }).max();
        drawing.text(Text::new(&panel.title, (left, top - 9.0), TITLE_SIZE).bold());
        for column in 0..panel.columns.len() {
            if column % 2 == 0 {
                let (from, to) = (left + step * column as f64, left + step * (column + 1) as f64);
                let corners = vec![(from, top), (to, top), (to, bottom), (from, bottom)];
                drawing.area(corners, Some(Color::WHITE.mix(Color::GRID, 0.4)), None);
            }
        }
        let mut data = Vec::new();
        for (index, (row, cells)) in self.rows.iter().zip(&panel.cells).enumerate() {
            let y = top + (index as f64 + 0.5) * ROW;
            drawing.line(vec![(left, y), (right, y)], Stroke { dash: &[1.0, 3.0], ..Stroke::solid(Color::GRID, 0.8) });
            drawing.group(&row.name, |drawing| {
                if labelled {
                    draw_row_label(drawing, row, (left, y));
                }
                let mut points = Vec::new();
                for (column, cell) in panel.columns.iter().zip(cells) {
                    let at = (left + (points.len() as f64 + 0.5) * step, y);
                    draw_cell(drawing, at, *cell, row.color, most.unwrap_or(1));
                    let (value, note) = Self::said(*cell, &column.label);
                    points.push(Datum { x: column.value, y: value, range: None, note, at: Some(at) });
                }
                data.push(SeriesData { name: row.name.clone(), points });
            });
        }
        for (index, column) in panel.columns.iter().enumerate() {
            let at = (left + (index as f64 + 0.5) * step, bottom + 10.0);
            let text = Text::new(&column.label, at, TICK_SIZE).anchored(Anchor::Middle).centred();
            drawing.text(text.colored(Color::SOFT_INK));
        }
        let middle = (0.5 * (left + right), bottom + 29.0);
        drawing.text(Text::new(&panel.quantity, middle, LABEL_SIZE).anchored(Anchor::Middle));
        let y = "share of the runs that complete".to_owned();
        drawing.data.push(PanelData { title: panel.title.clone(), x: panel.quantity.clone(), y, series: data });
    }

    /// The value of a cell in the data, and what else is said of it.
    fn said(cell: Cell, column: &str) -> (f64, String) {
        match cell {
            Cell::NotRun => (f64::NAN, "not run".to_owned()),
            Cell::Right => (1.0, String::new()),
            Cell::Wrong => (1.0, WRONG.to_owned()),
            Cell::Lost(share) => (1.0 - share, format!("{:.0} % of the runs diverged", 100.0 * share)),
            Cell::Silent => (f64::NAN, "no answer".to_owned()),
            Cell::Count(count) => (count as f64, format!("{count} with the limit: {column}")),
        }
    }

    fn key(&self) -> Vec<(Sample, String)> {
        let cells = || self.panels.iter().flat_map(|panel| panel.cells.iter().flatten());
        let any = |test: fn(&Cell) -> bool| cells().any(test);
        let entries = [
            (any(|cell| *cell == Cell::Right), Sample::Sign(Marker::Circle), "all runs complete"),
            (any(|cell| *cell == Cell::Wrong), Sample::Sign(Marker::OpenCircle), WRONG),
            (any(|cell| matches!(cell, Cell::Lost(share) if *share < 1.0)), Sample::Lost(false), "some diverge"),
            (
                any(|cell| matches!(cell, Cell::Lost(share) if *share >= 1.0)),
                Sample::Sign(Marker::Cross),
                "all diverge",
            ),
            (any(|cell| *cell == Cell::NotRun), Sample::Nothing, "–  not run"),
            (any(|cell| *cell == Cell::Silent), Sample::Nothing, "?  no answer"),
        ];
        let used = entries.into_iter().filter(|(used, ..)| *used);
        used.map(|(_, sample, words)| (sample, words.to_owned())).collect()
    }
}

fn draw_cell(drawing: &mut Drawing, at: (f64, f64), cell: Cell, color: Color, most: usize) {
    let letters = |drawing: &mut Drawing, words: &str, color: Color| {
        drawing.text(Text::new(words, at, TICK_SIZE).anchored(Anchor::Middle).colored(color).centred());
    };
    match cell {
        Cell::NotRun => letters(drawing, "–", Color::SOFT_INK),
        Cell::Silent => letters(drawing, "?", Color::SOFT_INK),
        Cell::Right => marker::draw(drawing, Marker::Circle, at, 1.5 * MARKER, color),
        Cell::Wrong => marker::draw(drawing, Marker::OpenCircle, at, 1.4 * MARKER, color),
        Cell::Lost(share) if share >= 1.0 => {
            marker::draw(drawing, Marker::Cross, at, 0.8 * MARKER, Color::SOFT_INK.mix(Color::WHITE, 0.45));
        }
        Cell::Lost(_) => marker::draw_lost(drawing, at, 1.2 * MARKER, color, false),
        Cell::Count(0) => {}
        Cell::Count(count) => {
            drawing.disc(at, COUNT[0] + COUNT[1] * (count as f64 / most as f64).sqrt(), Some(color), None);
            letters(drawing, &count.to_string(), Color::WHITE);
        }
    }
}

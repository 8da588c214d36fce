//! Ranked rows, one per scheme, so that neither lines cross nor colours have to be told apart: a sign per value along
//! an axis, or in each column a sign for what became of the runs.

use super::axes::{
    AXIS, BELOW, GRID, TICK, TICK_SIZE, TITLE_SIZE, crisp, fitting_ticks, labels, tick_below, ticks_below,
};
use super::chart::{Absent, Axis, Loss, NO_ANSWER};
use super::clip::Rect;
use super::data::MARKER;
use super::drawing::{Anchor, Color, Datum, Drawing, PanelData, SeriesData, Stroke, Text, Weight};
use super::figure::fits;
use super::scale::{AxisMap, interval};
use super::{font, marker};
use crate::line_style::Marker;
use rimbench_core::error::Result;

const MARGIN: f64 = 8.0;
/// Height of a row, px.
const ROW: f64 = 14.0;
const ROW_LABEL: f64 = 9.4;
const SWATCH: f64 = 8.0;
const BETWEEN_COLUMNS: f64 = 16.0;
const BETWEEN_ROWS: f64 = 6.0;
/// Least and largest width of the part right of a panel that a kind of sign gets for the runs that it lost, px.
const LOST: [f64; 2] = [21.0, 26.0];
/// What stands below these parts.
const FAILED: &str = "failed, %";
/// What stands there for runs that gave no answer.
const SILENT: &str = "?";
/// Between the words there, px.
const BETWEEN_LOST: f64 = 3.5;
/// How far signs of one row stand above each other, px.
const APART: f64 = 2.1;
/// Height of the first line that says what the signs are, and of each further one, px.
const KEY: f64 = 20.0;
const KEY_LINE: f64 = 14.0;
/// Widest column of a grid, px.
const WIDEST_COLUMN: f64 = 64.0;
/// Radius of the disc around a count of one, and what the largest count adds, px.
const COUNT: [f64; 2] = [4.4, 2.4];
/// What [`Cell::Wrong`] means.
const WRONG: &str = "all complete, but the median error is above a tenth of the peak";
/// Between an entry of these lines and the next, px.
const BETWEEN_ENTRIES: f64 = 14.0;
/// Width of a shaded sample, px.
const SHADED: f64 = 16.0;

/// Signs, by their number.
const SIGNS: [Marker; 9] = [
    Marker::Circle,
    Marker::OpenSquare,
    Marker::Diamond,
    Marker::OpenCircle,
    Marker::Square,
    Marker::OpenDiamond,
    Marker::Triangle,
    Marker::Star,
    Marker::Cross,
];

/// A value of one row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// The value; NaN where there is none.
    pub value: f64,
    /// From the least to the largest, where that is known.
    pub range: Option<[f64; 2]>,
    /// What is lost of its runs, or why there are none.
    pub lost: Result<Loss, Absent>,
}

/// What a kind of sign stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Sign {
    /// Its value in the data behind the picture, a macro step, say.
    pub value: f64,
    /// In few letters, at the place of lost runs.
    pub short: String,
    /// In the legend.
    pub label: String,
}

/// A row: one scheme.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What stands before it.
    pub label: String,
    /// Its name in the data.
    pub name: String,
    /// Its colour.
    pub color: Color,
}

/// The colours of no failure and of nothing else.
const NONE_FAILED: Color = Color(0xD9, 0xE8, 0xDF);
const ALL_FAILED: Color = Color(0xB0, 0x12, 0x0A);

/// What an entry of the key shows before its words.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Sample {
    Sign(Marker),
    /// Runs of which some were lost.
    SomeLost,
    Shade,
    Nothing,
}

impl Sample {
    fn width(self) -> f64 {
        match self {
            Sample::Sign(_) | Sample::SomeLost => 2.0 * MARKER,
            Sample::Shade => SHADED,
            Sample::Nothing => -5.0,
        }
    }
}

/// What became of the runs of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell {
    /// None was run.
    Absent(Absent),
    /// All completed, and are right.
    Right,
    /// All completed, and are wrong.
    Wrong,
    /// This share failed.
    Lost(f64),
    /// This share failed, as a number.
    Failed(f64),
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

/// A panel: one quantity of all schemes.
#[derive(Debug, Clone, PartialEq)]
pub struct RowsPanel {
    /// Heading.
    pub title: String,
    /// What its rows show.
    pub content: Content,
}

/// What the rows of a panel show.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// Signs along an axis.
    Dots(Dots),
    /// Signs in columns.
    Grid(Grid),
}

/// Values along an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Dots {
    /// The quantity, across.
    pub axis: Axis,
    /// A value for each row and sign.
    pub dots: Vec<Vec<Dot>>,
    /// Values of single runs by row, as faint marks; none, or one list per row.
    pub marks: Vec<Vec<f64>>,
    /// Values up to this say nothing.
    pub floor: Option<f64>,
}

/// What became of runs, in columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Quantity of the columns.
    pub quantity: String,
    /// The columns, from the left.
    pub columns: Vec<Column>,
    /// Cells by row and column.
    pub cells: Vec<Vec<Cell>>,
}

/// The whole picture. Its height follows from its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct RowsPlot {
    /// Width, px.
    pub width: f64,
    /// Panels in a line.
    pub columns: usize,
    /// What the signs along axes stand for, in words, with its unit.
    pub quantity: String,
    /// Kinds of signs along axes.
    pub signs: Vec<Sign>,
    /// Rows from the top.
    pub rows: Vec<Row>,
    /// Panels.
    pub panels: Vec<RowsPanel>,
}

impl RowsPlot {
    /// Draws the plot if its panels have room in it.
    ///
    /// # Errors
    /// [`Error::Incompatible`](rimbench_core::error::Error::Incompatible) if not.
    pub fn draw_if_it_fits(&self) -> Result<Drawing> {
        let narrowest = self.widths().into_iter().fold(f64::INFINITY, f64::min);
        fits(&[("width", self.width, narrowest)]).map(|()| self.draw())
    }

    fn columns(&self) -> usize {
        self.columns.clamp(1, self.panels.len().max(1))
    }

    /// Room for lost runs, px.
    fn lost_width(&self) -> f64 {
        // Without it what was not run would look like what lost none.
        let said = self.dots().any(|dot| dot.lost.is_err() || dot.lost.is_ok_and(|lost| lost.is_any()));
        if said { self.lost_column() * self.signs.len() as f64 + 12.0 } else { 0.0 }
    }

    /// Whether all panels lose the same runs: the last one of a line says it for all.
    fn lost_once(&self) -> bool {
        let lost = |panel: &RowsPanel| match &panel.content {
            Content::Dots(dots) => dots.dots.iter().flatten().map(|dot| dot.lost).collect(),
            Content::Grid(_) => Vec::new(),
        };
        self.panels.windows(2).all(|pair| lost(&pair[0]) == lost(&pair[1]))
    }

    /// Room for lost runs right of a panel in this column, px.
    fn lost_width_in(&self, column: usize) -> f64 {
        if column + 1 < self.columns() && self.lost_once() { 0.0 } else { self.lost_width() }
    }

    /// Width of the part of one kind of sign in it, px.
    fn lost_column(&self) -> f64 {
        let words = self.signs.iter().map(|sign| font::width(&sign.short, TICK_SIZE, Weight::Regular));
        let heading = font::width(FAILED, TICK_SIZE, Weight::Regular) / self.signs.len().max(1) as f64;
        (words.fold(0.0, f64::max) + BETWEEN_LOST).clamp(LOST[0], LOST[1]).max(heading)
    }

    /// All values along axes.
    fn dots(&self) -> impl Iterator<Item = &Dot> {
        let dots = self.panels.iter().map(|panel| match &panel.content {
            Content::Dots(dots) => &dots.dots[..],
            Content::Grid(_) => &[],
        });
        dots.flatten().flatten()
    }

    /// All cells of grids.
    fn cells(&self) -> impl Iterator<Item = &Cell> {
        let cells = self.panels.iter().map(|panel| match &panel.content {
            Content::Dots(_) => &[],
            Content::Grid(grid) => &grid.cells[..],
        });
        cells.flatten().flatten()
    }

    /// Width of each panel of a line, px: equal parts, or in proportion to the columns of grids.
    fn widths(&self) -> Vec<f64> {
        let columns = self.columns();
        let taken = 2.0 * MARGIN
            + labels_width(&self.rows)
            + (0..columns).map(|column| self.lost_width_in(column)).sum::<f64>()
            + (columns - 1) as f64 * BETWEEN_COLUMNS;
        let room = self.width - taken;
        let counts: Option<Vec<usize>> = self.panels.iter().map(RowsPanel::grid_columns).collect();
        match counts {
            Some(counts) if counts.len() == columns => {
                let step = (room / counts.iter().sum::<usize>().max(1) as f64).min(WIDEST_COLUMN);
                counts.into_iter().map(|count| step * count as f64).collect()
            }
            _ => vec![(room / columns as f64).floor(); columns],
        }
    }

    /// Draws the plot.
    pub fn draw(&self) -> Drawing {
        let columns = self.columns();
        let lines = self.panels.len().div_ceil(columns);
        let (above, inside) = (TITLE_SIZE + 10.0, ROW * self.rows.len().max(1) as f64 + 6.0);
        let line = above + inside + BELOW;
        let key = key_lines(self.key(), self.width);
        let key_height = if key.is_empty() { 0.0 } else { KEY + KEY_LINE * (key.len() - 1) as f64 };
        let height = 2.0 * MARGIN + lines as f64 * line + (lines.max(1) - 1) as f64 * BETWEEN_ROWS + key_height;
        let mut drawing = Drawing::new(self.width, height);
        drawing.title = self.panels.iter().map(|panel| panel.title.as_str()).collect::<Vec<_>>().join("; ");
        let widths = self.widths();
        if widths.iter().any(|width| *width < 1.0) {
            return drawing;
        }
        for (index, panel) in self.panels.iter().enumerate() {
            let (row, column) = (index / columns, index % columns);
            let before =
                (0..column).map(|before| widths[before] + self.lost_width_in(before) + BETWEEN_COLUMNS).sum::<f64>();
            let left = MARGIN + labels_width(&self.rows) + before;
            let top = MARGIN + above + row as f64 * (line + BETWEEN_ROWS);
            let [left, top] = [left, top].map(crisp);
            self.draw_panel(
                &mut drawing,
                Rect { left, top, right: left + widths[column], bottom: top + inside },
                panel,
                column,
            );
        }
        for (index, entries) in key.iter().enumerate() {
            draw_key(
                &mut drawing,
                entries,
                self.width,
                height - MARGIN - key_height + 0.6 * KEY + KEY_LINE * index as f64,
            );
        }
        drawing
    }

    fn draw_panel(&self, drawing: &mut Drawing, area: Rect, panel: &RowsPanel, column: usize) {
        let lost_left = (self.lost_width_in(column) > 0.0).then_some(area.right + 12.0);
        let (map, x, y) = match &panel.content {
            Content::Dots(dots) => {
                let map = dots.draw_axis(drawing, &area);
                labels(drawing, &area, &panel.title, &dots.axis.label);
                if let Some(left) = lost_left {
                    self.draw_lost_axis(drawing, &area, left);
                }
                (Some(map), self.quantity.clone(), dots.axis.label.clone())
            }
            Content::Grid(grid) => {
                grid.draw_columns(drawing, &area);
                labels(drawing, &area, &panel.title, &grid.quantity);
                (None, grid.quantity.clone(), "share of the runs that complete".to_owned())
            }
        };
        let mut series = Vec::new();
        for (index, row) in self.rows.iter().enumerate() {
            let y = area.top + 3.0 + (index as f64 + 0.5) * ROW;
            drawing.line(vec![(area.left, y), (area.right, y)], Stroke { dash: &[1.0, 3.0], ..GRID });
            drawing.group(&row.name, |drawing| {
                if column == 0 {
                    draw_row_label(drawing, row, (area.left, y));
                }
                match (&panel.content, &map) {
                    (Content::Dots(dots), Some(map)) => {
                        dots.draw_marks(drawing, map, y, (index, row.color));
                        series.push(self.draw_row(drawing, map, (lost_left, y), row, &dots.dots[index]));
                    }
                    (Content::Grid(grid), _) => series.push(grid.draw_row(drawing, &area, y, row, &grid.cells[index])),
                    (Content::Dots(_), None) => {}
                }
            });
        }
        drawing.data.push(PanelData { title: panel.title.clone(), x, y, series });
    }

    /// Draws the signs of one row and returns its data.
    fn draw_row(
        &self,
        drawing: &mut Drawing,
        map: &AxisMap,
        (lost_left, y): (Option<f64>, f64),
        row: &Row,
        dots: &[Dot],
    ) -> SeriesData {
        let inside = |value: f64| map.position(value).filter(|at| (map.start..=map.end).contains(at));
        let height = |index: usize| y + APART * (index as f64 - 0.5 * (self.signs.len() as f64 - 1.0)).clamp(-2.0, 2.0);
        for (index, dot) in dots.iter().enumerate() {
            let ends = dot.range.map(|range| range.map(|end| map.position(end)));
            if let Some([Some(from), Some(to)]) = ends {
                let ends = [from, to].map(|end| end.clamp(map.start, map.end));
                let bar = Stroke::solid(row.color, 0.7);
                drawing.line(ends.map(|end| (end, height(index))).to_vec(), bar);
            }
        }
        if let Some(word) = without_sign(dots) {
            drawing.text(Text::new(word, (map.start + 5.0, y), TICK_SIZE).colored(Color::SOFT_INK).centred());
        }
        let mut points = Vec::new();
        for (index, (dot, sign)) in dots.iter().zip(&self.signs).enumerate() {
            let at = inside(dot.value).map(|x| (x, height(index)));
            if let Some(at) = at {
                marker::draw(drawing, SIGNS[index % SIGNS.len()], at, MARKER, row.color);
            }
            let column = lost_left.map(|left| left + (index as f64 + 0.5) * self.lost_column());
            if let Some(column) = column {
                let (said, color) = match dot.lost {
                    Ok(loss) if loss.failed > 0.0 => (format!("{:.0}", (100.0 * loss.failed).max(1.0)), Color::INK),
                    Ok(loss) if loss.silent > 0.0 => (SILENT.to_owned(), Color::INK),
                    Ok(_) => ("0".to_owned(), Color::SOFT_INK),
                    Err(absent) => (absent.sign().to_owned(), Color::SOFT_INK),
                };
                let said = Text::new(&said, (column, y), TICK_SIZE).anchored(Anchor::Middle);
                drawing.text(said.colored(color).centred());
            }
            let note = dot.lost.map_or_else(|absent| absent.in_words().to_owned(), |loss| loss.in_words());
            let lost = column.filter(|_| dot.lost.is_ok_and(|loss| loss.is_any()));
            let at = at.or(lost.map(|column| (column, y)));
            points.push(Datum { x: sign.value, y: dot.value, range: dot.range, note, at });
        }
        SeriesData { name: row.name.clone(), points }
    }

    /// The part for lost runs: a column for each kind of sign.
    fn draw_lost_axis(&self, drawing: &mut Drawing, area: &Rect, left: f64) {
        let column = self.lost_column();
        let right = left + column * self.signs.len() as f64;
        let edge = Stroke { dash: &[1.5, 2.5], ..AXIS };
        drawing.line(vec![(left, area.top), (left, area.bottom)], edge);
        for (index, sign) in self.signs.iter().enumerate() {
            let at = (left + (index as f64 + 0.5) * column, area.bottom + TICK + 7.5);
            let text = Text::new(&sign.short, at, TICK_SIZE).anchored(Anchor::Middle).centred();
            // Of one kind of sign the subtitle says enough, and a number above "%" would be read as a share.
            if text.width() <= column && self.signs.len() > 1 {
                drawing.text(text.colored(Color::SOFT_INK));
            }
        }
        let middle = 0.5 * (left + right);
        let word = Text::new(FAILED, (middle, area.bottom + BELOW - 6.0), TICK_SIZE).anchored(Anchor::Middle);
        drawing.text(word.colored(Color::SOFT_INK));
    }

    /// What the signs stand for.
    fn key(&self) -> Vec<(Sample, String)> {
        let sign = |(index, sign): (usize, &Sign)| (Sample::Sign(SIGNS[index % SIGNS.len()]), sign.label.clone());
        let several = self.signs.iter().enumerate().filter(|_| self.signs.len() > 1);
        let mut entries: Vec<(Sample, String)> = several.map(sign).collect();
        let has_floor = |panel: &RowsPanel| matches!(&panel.content, Content::Dots(dots) if dots.floor.is_some());
        if self.panels.iter().any(has_floor) {
            entries.push((Sample::Shade, "below the reference's uncertainty".to_owned()));
        }
        let is_silent = |dot: &Dot| dot.lost.is_ok_and(|loss| loss.failed == 0.0 && loss.silent > 0.0);
        if self.dots().any(is_silent) || self.cells().any(|cell| *cell == Cell::Silent) {
            entries.push((Sample::Nothing, format!("{SILENT}  {NO_ANSWER}")));
        }
        for absent in Absent::ALL {
            if self.dots().any(|dot| dot.lost == Err(absent)) || self.cells().any(|cell| *cell == Cell::Absent(absent))
            {
                entries.push((Sample::Nothing, format!("{}  {}", absent.sign(), absent.in_words())));
            }
        }
        let any = |test: fn(&Cell) -> bool| self.cells().any(test);
        let of_cells = [
            (any(|cell| *cell == Cell::Right), Sample::Sign(Marker::Circle), "all runs complete"),
            (any(|cell| *cell == Cell::Wrong), Sample::Sign(Marker::OpenCircle), WRONG),
            (any(|cell| matches!(cell, Cell::Lost(share) if *share < 1.0)), Sample::SomeLost, "some fail"),
            (any(|cell| matches!(cell, Cell::Lost(share) if *share >= 1.0)), Sample::Sign(Marker::Cross), "all fail"),
        ];
        let used = of_cells.into_iter().filter(|(used, ..)| *used);
        entries.extend(used.map(|(_, sample, words)| (sample, words.to_owned())));
        entries
    }
}

impl RowsPanel {
    /// Number of columns of a grid; none along an axis.
    fn grid_columns(&self) -> Option<usize> {
        match &self.content {
            Content::Dots(_) => None,
            Content::Grid(grid) => Some(grid.columns.len()),
        }
    }
}

impl Dots {
    /// Draws the axis and what lies below the floor; returns how values become places.
    fn draw_axis(&self, drawing: &mut Drawing, area: &Rect) -> AxisMap {
        let values = self.dots.iter().flatten().flat_map(|dot| {
            let [low, high] = dot.range.unwrap_or([f64::NAN; 2]);
            [dot.value, low, high]
        });
        let (low, high) = interval(&self.axis, values, 0.06);
        let map = AxisMap { scale: self.axis.scale, low, high, start: area.left, end: area.right };
        if let Some(at) = self.floor.and_then(|floor| map.position(floor)).filter(|at| *at > area.left) {
            let shaded = Rect { right: at.min(area.right), ..*area };
            drawing.area(shaded.corners(), Some(super::guides::SHADE), None);
        }
        ticks_below(drawing, &map, &fitting_ticks(&map), area.bottom, area.top);
        drawing.line(vec![(area.left, area.top), (area.left, area.bottom), (area.right, area.bottom)], AXIS);
        map
    }

    /// Draws a faint mark for every run of a row.
    fn draw_marks(&self, drawing: &mut Drawing, map: &AxisMap, y: f64, (index, color): (usize, Color)) {
        let places = self.marks.get(index).into_iter().flatten().filter_map(|value| map.position(*value));
        for x in places.filter(|x| (map.start..=map.end).contains(x)) {
            drawing.line(vec![(x, y - 3.6), (x, y + 3.6)], Stroke::solid(color.mix(Color::WHITE, 0.45), 0.7));
        }
    }
}

impl Grid {
    fn step(&self, area: &Rect) -> f64 {
        (area.right - area.left) / self.columns.len().max(1) as f64
    }

    /// Shades every other column and writes below each what it is.
    fn draw_columns(&self, drawing: &mut Drawing, area: &Rect) {
        for (index, column) in self.columns.iter().enumerate() {
            let left = area.left + index as f64 * self.step(area);
            if index % 2 == 0 {
                let shaded = Rect { left, right: left + self.step(area), ..*area };
                drawing.area(shaded.corners(), Some(Color::WHITE.mix(Color::GRID, 0.4)), None);
            }
            tick_below(drawing, (left + 0.5 * self.step(area), area.bottom), &column.label);
        }
    }

    /// Draws the cells of one row and returns its data.
    fn draw_row(&self, drawing: &mut Drawing, area: &Rect, y: f64, row: &Row, cells: &[Cell]) -> SeriesData {
        let counts = self.cells.iter().flatten();
        let most = counts.filter_map(|cell| if let Cell::Count(count) = cell { Some(*count) } else { None }).max();
        let mut points = Vec::new();
        for (index, (column, cell)) in self.columns.iter().zip(cells).enumerate() {
            let at = (area.left + (index as f64 + 0.5) * self.step(area), y);
            draw_cell(drawing, at, *cell, row.color, (most.unwrap_or(1), self.step(area)));
            let (value, note) = said(*cell, &column.label);
            points.push(Datum { x: column.value, y: value, range: None, note, at: Some(at) });
        }
        SeriesData { name: row.name.clone(), points }
    }
}

/// The value of a cell in the data, and what else is said of it.
fn said(cell: Cell, column: &str) -> (f64, String) {
    match cell {
        Cell::Absent(absent) => (f64::NAN, absent.in_words().to_owned()),
        Cell::Right => (1.0, String::new()),
        Cell::Wrong => (1.0, WRONG.to_owned()),
        Cell::Lost(share) | Cell::Failed(share) => (1.0 - share, format!("{:.0} % of the runs failed", 100.0 * share)),
        Cell::Silent => (f64::NAN, "no answer".to_owned()),
        Cell::Count(count) => (count as f64, format!("{count} with the limit: {column}")),
    }
}

/// Draws a cell; `most` is the largest count of its grid, `width` that of its column.
fn draw_cell(drawing: &mut Drawing, at: (f64, f64), cell: Cell, color: Color, (most, width): (usize, f64)) {
    let letters = |drawing: &mut Drawing, words: &str, color: Color| {
        drawing.text(Text::new(words, at, TICK_SIZE).anchored(Anchor::Middle).colored(color).centred());
    };
    match cell {
        Cell::Absent(absent) => letters(drawing, absent.sign(), Color::SOFT_INK),
        Cell::Silent => letters(drawing, SILENT, Color::SOFT_INK),
        Cell::Right => marker::draw(drawing, Marker::Circle, at, 1.5 * MARKER, color),
        Cell::Wrong => marker::draw(drawing, Marker::OpenCircle, at, 1.4 * MARKER, color),
        Cell::Failed(share) => {
            let shade =
                Color::WHITE.mix(NONE_FAILED, 0.5).mix(ALL_FAILED, if share > 0.0 { 0.2 + 0.8 * share } else { 0.0 });
            let (across, up) = (0.5 * width - 0.6, 0.5 * ROW - 0.6);
            let place = Rect { left: at.0 - across, top: at.1 - up, right: at.0 + across, bottom: at.1 + up };
            drawing.area(place.corners(), Some(shade), None);
            if share > 0.0 {
                let ink = if share > 0.45 { Color::WHITE } else { Color::INK };
                letters(drawing, &format!("{:.0}", (100.0 * share).max(1.0)), ink);
            }
        }
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

/// Room for labels left of the first panel of a line, px.
fn labels_width(rows: &[Row]) -> f64 {
    let widest = rows.iter().map(|row| font::width(&row.label, ROW_LABEL, Weight::Regular)).fold(0.0, f64::max);
    widest + SWATCH + 12.0
}

/// Writes the label of a row, with a swatch of its colour, left of a place.
fn draw_row_label(drawing: &mut Drawing, row: &Row, (right, y): (f64, f64)) {
    let (left, half) = (right - 7.0 - SWATCH, 0.5 * SWATCH);
    let swatch = Rect { left, top: y - half, right: left + SWATCH, bottom: y + half };
    drawing.area(swatch.corners(), Some(row.color), None);
    drawing.text(Text::new(&row.label, (left - 5.0, y), ROW_LABEL).anchored(Anchor::End).centred());
}

/// Breaks the entries of a key into as many lines as the width asks for.
fn key_lines(entries: Vec<(Sample, String)>, width: f64) -> Vec<Vec<(Sample, String)>> {
    let mut lines: Vec<Vec<(Sample, String)>> = Vec::new();
    for entry in entries {
        let room = width - 2.0 * MARGIN - entry_width(&entry);
        match lines.last_mut() {
            Some(line) if line_width(line) + BETWEEN_ENTRIES <= room => line.push(entry),
            _ => lines.push(vec![entry]),
        }
    }
    lines
}

/// Draws one line of a key in the middle of a width.
fn draw_key(drawing: &mut Drawing, entries: &[(Sample, String)], width: f64, y: f64) {
    let mut x = (0.5 * (width - line_width(entries))).max(MARGIN);
    for entry in entries {
        let (sample, label) = entry;
        match *sample {
            Sample::Sign(sign) => marker::draw(drawing, sign, (x + MARKER, y), MARKER, Color::SOFT_INK),
            Sample::SomeLost => marker::draw_lost(drawing, (x + MARKER, y), MARKER, Color::SOFT_INK, false),
            Sample::Shade => {
                let sample = Rect { left: x, top: y - 4.0, right: x + SHADED, bottom: y + 4.0 };
                drawing.area(sample.corners(), Some(super::guides::SHADE), None);
            }
            Sample::Nothing => {}
        }
        drawing.text(Text::new(label, (x + sample.width() + 5.0, y), TICK_SIZE).centred());
        x += entry_width(entry) + BETWEEN_ENTRIES;
    }
}

/// Width of an entry of the key, px.
fn entry_width((sample, label): &(Sample, String)) -> f64 {
    sample.width() + 5.0 + font::width(label, TICK_SIZE, Weight::Regular)
}

/// Width of a line of the key, px.
fn line_width(entries: &[(Sample, String)]) -> f64 {
    entries.iter().map(entry_width).sum::<f64>() + BETWEEN_ENTRIES * (entries.len().max(1) - 1) as f64
}

/// What is said of a row without any sign in a panel; nothing of one that has some.
fn without_sign(dots: &[Dot]) -> Option<&'static str> {
    let shown = |dot: &Dot| dot.value.is_finite() || dot.lost.is_ok_and(|loss| loss.is_any());
    let absent = dots.iter().map(|dot| dot.lost.err()).collect::<Option<Vec<Absent>>>();
    let why = absent.map(|absent| absent.first().map_or("not run", |absent| absent.in_words()));
    (!dots.iter().any(shown)).then_some(why.unwrap_or("no value"))
}

#[cfg(test)]
mod tests {
    use super::super::drawing::Shape;
    use super::*;

    fn plot(values: &[[f64; 2]], lost: f64) -> RowsPlot {
        let row = |k: usize| Row { label: format!("row {k}"), name: format!("row-{k}"), color: Color(0, 0, 90) };
        let dot = |value: f64| Dot {
            value,
            range: None,
            lost: Ok(Loss { failed: if value.is_nan() { lost } else { 0.0 }, silent: 0.0 }),
        };
        let sign = |value: f64| Sign { value, short: format!("{value}"), label: format!("H = {value} ms") };
        RowsPlot {
            width: 500.0,
            columns: 2,
            quantity: "macro step H (ms)".to_owned(),
            signs: vec![sign(1.0), sign(5.0)],
            rows: (0..values.len()).map(row).collect(),
            panels: vec![RowsPanel {
                title: "(a)".to_owned(),
                content: Content::Dots(Dots {
                    axis: Axis::log10("error"),
                    dots: values.iter().map(|row| row.map(dot).to_vec()).collect(),
                    marks: Vec::new(),
                    floor: None,
                }),
            }],
        }
    }

    fn dots_of(plot: &mut RowsPlot) -> &mut Dots {
        let Content::Dots(dots) = &mut plot.panels[0].content else { panic!() };
        dots
    }

    fn words(drawing: &Drawing) -> Vec<&str> {
        let words = drawing.shapes.iter().filter_map(|shape| match shape {
            Shape::Text(text) => Some(text.content.as_str()),
            _ => None,
        });
        words.collect()
    }

    #[test]
    fn every_row_has_its_name_and_a_lost_run_says_failed() {
        let drawing = plot(&[[1.0, 2.0], [3.0, f64::NAN]], 1.0).draw();
        for wanted in ["row 0", "row 1", "H = 5 ms", "failed, %", "100"] {
            assert!(words(&drawing).contains(&wanted), "{wanted}: {:?}", words(&drawing));
        }
        let note = &drawing.data[0].series[1].points[1];
        assert!(note.note == "100 % of the runs failed" && note.at.is_some(), "{note:?}");
        assert!(!words(&plot(&[[1.0, 2.0]], 0.0).draw()).contains(&"failed, %"));
    }

    #[test]
    fn equal_values_of_one_row_stand_beside_each_other() {
        let drawing = plot(&[[2.0, 2.0]], 0.0).draw();
        let [one, two] = &drawing.data[0].series[0].points[..] else { panic!() };
        assert!(one.at.unwrap().1 != two.at.unwrap().1);
    }

    #[test]
    fn a_key_of_many_entries_is_broken_into_lines_and_nothing_ends_beyond_the_picture() {
        let mut long = plot(&[[1.0, 2.0], [3.0, f64::NAN]], 0.5);
        let few = long.draw().height;
        for (index, sign) in long.signs.iter_mut().enumerate() {
            sign.label = format!("macro step {} of each case, in many more words", index + 1);
        }
        let more = (0..5).map(|k| Sign { label: format!("macro step {k} of each case"), ..long.signs[0].clone() });
        long.signs.extend(more.collect::<Vec<_>>());
        dots_of(&mut long).floor = Some(1.5);
        let drawing = long.draw();
        let rightmost = |text: &Text| match text.anchor {
            Anchor::Start => text.at.0 + text.width(),
            Anchor::Middle => text.at.0 + 0.5 * text.width(),
            Anchor::End => text.at.0,
        };
        let mut levels = Vec::new();
        for shape in &drawing.shapes {
            let Shape::Text(text) = shape else { continue };
            assert!(rightmost(text) <= drawing.width && text.at.1 <= drawing.height, "{text:?}");
            if text.content.starts_with("macro step") || text.content.starts_with("below") {
                levels.push(text.at.1);
            }
        }
        levels.dedup();
        assert!(levels.len() > 1 && levels.windows(2).all(|pair| pair[1] - pair[0] >= TICK_SIZE), "{levels:?}");
        assert!(drawing.height >= few + KEY_LINE * (levels.len() - 1) as f64 - 1e-9);
    }

    #[test]
    fn a_run_without_an_answer_is_not_drawn_as_failed() {
        let mut silent = plot(&[[1.0, f64::NAN]], 0.0);
        dots_of(&mut silent).dots[0][1].lost = Ok(Loss { failed: 0.0, silent: 1.0 });
        let drawing = silent.draw();
        assert!(words(&drawing).contains(&"?") && words(&drawing).contains(&"?  no answer"));
        assert!(!words(&drawing).contains(&"100"));
        let note = &drawing.data[0].series[0].points[1].note;
        assert_eq!(note, "100 % of the runs gave no answer");
    }

    #[test]
    fn words_below_lost_runs_do_not_touch() {
        let mut plot = plot(&[[1.0, 2.0], [3.0, f64::NAN]], 1.0);
        for (sign, short) in plot.signs.iter_mut().zip(["0.2", "0.5"]) {
            sign.short = short.to_owned();
        }
        let drawing = plot.draw();
        let find = |word: &str| {
            let is_it = |shape: &&Shape| matches!(shape, Shape::Text(text) if text.content == word);
            let Some(Shape::Text(text)) = drawing.shapes.iter().find(is_it) else { panic!("{word}") };
            (text.at.0 - 0.5 * text.width(), text.at.0 + 0.5 * text.width())
        };
        assert!(find("0.5").0 - find("0.2").1 >= 3.0, "{:?} {:?}", find("0.2"), find("0.5"));
    }

    #[test]
    fn a_row_without_a_sign_says_why() {
        let mut none = plot(&[[1.0, 2.0], [f64::NAN, f64::NAN], [f64::NAN, f64::NAN]], 0.0);
        dots_of(&mut none).dots[2].iter_mut().for_each(|dot| dot.lost = Err(Absent::NotRun));
        let drawing = none.draw();
        let count = |word: &str| words(&drawing).iter().filter(|said| **said == word).count();
        assert_eq!((count("no value"), count("not run")), (1, 1));
    }

    /// A blank was read as either.
    #[test]
    fn what_lost_none_what_was_not_run_and_what_was_left_out_look_different() {
        let mut plot = plot(&[[1.0, 2.0], [3.0, f64::NAN], [4.0, f64::NAN]], 0.0);
        dots_of(&mut plot).dots[1][1].lost = Err(Absent::NotRun);
        dots_of(&mut plot).dots[2][1].lost = Err(Absent::LeftOut);
        let drawing = plot.draw();
        let count = |word: &str| words(&drawing).iter().filter(|said| **said == word).count();
        assert_eq!(["0", "–", "/"].map(count), [4, 1, 1], "{:?}", words(&drawing));
        assert_eq!(["–  not run", "/  left out"].map(count), [1, 1]);
    }
}

//! A ranked dot plot: a row per scheme, a sign per value, so that neither lines cross nor colours have to be told apart.

use super::axes::{AXIS, BELOW, GRID, TICK, TICK_SIZE, TITLE_SIZE, crisp, fitting_ticks, labels, ticks_below};
use super::chart::{Axis, Loss, NO_ANSWER};
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
const DIVERGED: &str = "diverged, %";
/// What stands there for runs that gave no answer.
const SILENT: &str = "?";
/// Between the words there, px.
const BETWEEN_LOST: f64 = 3.5;
/// How far signs of one row stand above each other, px.
const APART: f64 = 2.1;
/// Height of the first line that says what the signs are, and of each further one, px.
const KEY: f64 = 20.0;
const KEY_LINE: f64 = 14.0;
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
    /// What is lost of its runs; none where nothing was run.
    pub lost: Option<Loss>,
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
pub struct DotRow {
    /// What stands before it.
    pub label: String,
    /// Its name in the data.
    pub name: String,
    /// Its colour.
    pub color: Color,
}

/// What an entry of the key shows before its words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Sample {
    Sign(Marker),
    /// Runs that were lost: all of them, or some.
    Lost(bool),
    Shade,
    Nothing,
}

impl Sample {
    fn width(self) -> f64 {
        match self {
            Sample::Sign(_) | Sample::Lost(_) => 2.0 * MARKER,
            Sample::Shade => SHADED,
            Sample::Nothing => -5.0,
        }
    }
}

/// A panel: one quantity of all schemes.
#[derive(Debug, Clone, PartialEq)]
pub struct DotPanel {
    /// Heading.
    pub title: String,
    /// The quantity, across.
    pub axis: Axis,
    /// A value for each row and sign.
    pub dots: Vec<Vec<Dot>>,
    /// Values of single runs by row, as faint marks; none, or one list per row.
    pub marks: Vec<Vec<f64>>,
    /// Values up to this say nothing.
    pub floor: Option<f64>,
}

/// The whole picture. Its height follows from its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct DotPlot {
    /// Width, px.
    pub width: f64,
    /// Panels in a line.
    pub columns: usize,
    /// What the signs stand for, in words, with its unit.
    pub quantity: String,
    /// Kinds of signs.
    pub signs: Vec<Sign>,
    /// Rows from the top.
    pub rows: Vec<DotRow>,
    /// Panels.
    pub panels: Vec<DotPanel>,
}

impl DotPlot {
    /// Draws the plot if its panels have room in it.
    ///
    /// # Errors
    /// [`Error::Incompatible`](rimbench_core::error::Error::Incompatible) if not.
    pub fn draw_if_it_fits(&self) -> Result<Drawing> {
        fits(&[("width", self.width, self.panel_width())]).map(|()| self.draw())
    }

    fn columns(&self) -> usize {
        self.columns.clamp(1, self.panels.len().max(1))
    }

    /// Room for lost runs right of each panel, px.
    fn lost_width(&self) -> f64 {
        let lost = self
            .panels
            .iter()
            .flat_map(|panel| panel.dots.iter().flatten())
            .any(|dot| dot.lost.is_some_and(|lost| lost.is_any()));
        if lost { self.lost_column() * self.signs.len() as f64 + 12.0 } else { 0.0 }
    }

    /// Width of the part of one kind of sign in it, px.
    fn lost_column(&self) -> f64 {
        let words = self.signs.iter().map(|sign| font::width(&sign.short, TICK_SIZE, Weight::Regular));
        let heading = font::width(DIVERGED, TICK_SIZE, Weight::Regular) / self.signs.len().max(1) as f64;
        (words.fold(0.0, f64::max) + BETWEEN_LOST).clamp(LOST[0], LOST[1]).max(heading)
    }

    fn panel_width(&self) -> f64 {
        let columns = self.columns() as f64;
        let taken =
            2.0 * MARGIN + labels_width(&self.rows) + columns * self.lost_width() + (columns - 1.0) * BETWEEN_COLUMNS;
        ((self.width - taken) / columns).floor()
    }

    /// Draws the plot.
    pub fn draw(&self) -> Drawing {
        let columns = self.columns();
        let lines = self.panels.len().div_ceil(columns);
        let (above, inside) = (TITLE_SIZE + 10.0, ROW * self.rows.len().max(1) as f64 + 6.0);
        let line = above + inside + BELOW;
        let key = key_lines(self.key(), self.width);
        let key_height = KEY + KEY_LINE * (key.len().max(1) - 1) as f64;
        let height = 2.0 * MARGIN + lines as f64 * line + (lines.max(1) - 1) as f64 * BETWEEN_ROWS + key_height;
        let mut drawing = Drawing::new(self.width, height);
        drawing.title = self.panels.iter().map(|panel| panel.title.as_str()).collect::<Vec<_>>().join("; ");
        let width = self.panel_width();
        if width < 1.0 {
            return drawing;
        }
        for (index, panel) in self.panels.iter().enumerate() {
            let (row, column) = (index / columns, index % columns);
            let left =
                MARGIN + labels_width(&self.rows) + column as f64 * (width + self.lost_width() + BETWEEN_COLUMNS);
            let top = MARGIN + above + row as f64 * (line + BETWEEN_ROWS);
            let [left, top] = [left, top].map(crisp);
            self.draw_panel(
                &mut drawing,
                Rect { left, top, right: left + width, bottom: top + inside },
                panel,
                column == 0,
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

    fn draw_panel(&self, drawing: &mut Drawing, area: Rect, panel: &DotPanel, labelled: bool) {
        let values = panel.dots.iter().flatten().flat_map(|dot| {
            let [low, high] = dot.range.unwrap_or([f64::NAN; 2]);
            [dot.value, low, high]
        });
        let (low, high) = interval(&panel.axis, values, 0.06);
        let map = AxisMap { scale: panel.axis.scale, low, high, start: area.left, end: area.right };
        if let Some(at) = panel.floor.and_then(|floor| map.position(floor)).filter(|at| *at > area.left) {
            let shaded = Rect { right: at.min(area.right), ..area };
            drawing.area(shaded.corners(), Some(super::guides::SHADE), None);
        }
        ticks_below(drawing, &map, &fitting_ticks(&map), area.bottom, area.top);
        drawing.line(vec![(area.left, area.top), (area.left, area.bottom), (area.right, area.bottom)], AXIS);
        labels(drawing, &area, &panel.title, &panel.axis.label);
        let lost_left = area.right + 12.0;
        if self.lost_width() > 0.0 {
            self.draw_lost_axis(drawing, &area, lost_left);
        }
        let mut data = Vec::new();
        for (index, (row, dots)) in self.rows.iter().zip(&panel.dots).enumerate() {
            let y = area.top + 3.0 + (index as f64 + 0.5) * ROW;
            drawing.line(vec![(area.left, y), (area.right, y)], Stroke { dash: &[1.0, 3.0], ..GRID });
            drawing.group(&row.name, |drawing| {
                if labelled {
                    draw_row_label(drawing, row, (area.left, y));
                }
                for x in panel.marks.get(index).into_iter().flatten().filter_map(|value| map.position(*value)) {
                    if (area.left..=area.right).contains(&x) {
                        let mark = Stroke::solid(row.color.mix(Color::WHITE, 0.45), 0.7);
                        drawing.line(vec![(x, y - 3.6), (x, y + 3.6)], mark);
                    }
                }
                data.push(self.draw_row(drawing, &map, (lost_left, y), row, dots));
            });
        }
        let x = if self.quantity.is_empty() { String::new() } else { self.quantity.clone() };
        drawing.data.push(PanelData { title: panel.title.clone(), x, y: panel.axis.label.clone(), series: data });
    }

    /// Draws the signs of one row and returns its data.
    fn draw_row(
        &self,
        drawing: &mut Drawing,
        map: &AxisMap,
        (lost_left, y): (f64, f64),
        row: &DotRow,
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
            let column = lost_left + (index as f64 + 0.5) * self.lost_column();
            let lost = dot.lost.filter(Loss::is_any);
            if let Some(loss) = lost {
                let failed = format!("{:.0}", (100.0 * loss.failed).max(1.0));
                let share = Text::new(if loss.failed > 0.0 { &failed } else { SILENT }, (column, y), TICK_SIZE);
                drawing.text(share.anchored(Anchor::Middle).centred());
            }
            let note = dot.lost.map_or_else(|| "not run".to_owned(), |loss| loss.in_words());
            let at = at.or(lost.map(|_| (column, y)));
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
            if text.width() <= column {
                drawing.text(text.colored(Color::SOFT_INK));
            }
        }
        let middle = 0.5 * (left + right);
        let word = Text::new(DIVERGED, (middle, area.bottom + BELOW - 6.0), TICK_SIZE).anchored(Anchor::Middle);
        drawing.text(word.colored(Color::SOFT_INK));
    }

    /// What the signs stand for.
    fn key(&self) -> Vec<(Sample, String)> {
        let sign = |(index, sign): (usize, &Sign)| (Sample::Sign(SIGNS[index % SIGNS.len()]), sign.label.clone());
        let mut entries: Vec<(Sample, String)> = self.signs.iter().enumerate().map(sign).collect();
        if self.panels.iter().any(|panel| panel.floor.is_some()) {
            entries.push((Sample::Shade, "below the reference's uncertainty".to_owned()));
        }
        let is_silent = |dot: &Dot| dot.lost.is_some_and(|loss| loss.failed == 0.0 && loss.silent > 0.0);
        if self.panels.iter().flat_map(|panel| panel.dots.iter().flatten()).any(is_silent) {
            entries.push((Sample::Nothing, format!("{SILENT}  {NO_ANSWER}")));
        }
        entries
    }
}

/// Room for labels left of the first panel of a line, px.
pub(crate) fn labels_width(rows: &[DotRow]) -> f64 {
    let widest = rows.iter().map(|row| font::width(&row.label, ROW_LABEL, Weight::Regular)).fold(0.0, f64::max);
    widest + SWATCH + 12.0
}

/// Writes the label of a row, with a swatch of its colour, left of a place.
pub(crate) fn draw_row_label(drawing: &mut Drawing, row: &DotRow, (right, y): (f64, f64)) {
    let (left, half) = (right - 7.0 - SWATCH, 0.5 * SWATCH);
    let swatch = Rect { left, top: y - half, right: left + SWATCH, bottom: y + half };
    drawing.area(swatch.corners(), Some(row.color), None);
    drawing.text(Text::new(&row.label, (left - 5.0, y), ROW_LABEL).anchored(Anchor::End).centred());
}

/// Breaks the entries of a key into as many lines as the width asks for.
pub(crate) fn key_lines(entries: Vec<(Sample, String)>, width: f64) -> Vec<Vec<(Sample, String)>> {
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
pub(crate) fn draw_key(drawing: &mut Drawing, entries: &[(Sample, String)], width: f64, y: f64) {
    let mut x = (0.5 * (width - line_width(entries))).max(MARGIN);
    for entry in entries {
        let (sample, label) = entry;
        match *sample {
            Sample::Sign(sign) => marker::draw(drawing, sign, (x + MARKER, y), MARKER, Color::SOFT_INK),
            Sample::Lost(all) => marker::draw_lost(drawing, (x + MARKER, y), MARKER, Color::SOFT_INK, all),
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
    let shown = |dot: &Dot| dot.value.is_finite() || dot.lost.is_some_and(|loss| loss.is_any());
    let run = dots.iter().any(|dot| dot.lost.is_some());
    (!dots.iter().any(shown)).then_some(if run { "no value" } else { "not run" })
}

#[cfg(test)]
mod tests {
    use super::super::drawing::Shape;
    use super::*;

    fn plot(values: &[[f64; 2]], lost: f64) -> DotPlot {
        let row = |k: usize| DotRow { label: format!("row {k}"), name: format!("row-{k}"), color: Color(0, 0, 90) };
        let dot = |value: f64| Dot {
            value,
            range: None,
            lost: Some(Loss { failed: if value.is_nan() { lost } else { 0.0 }, silent: 0.0 }),
        };
        let sign = |value: f64| Sign { value, short: format!("{value}"), label: format!("H = {value} ms") };
        DotPlot {
            width: 500.0,
            columns: 2,
            quantity: "macro step H (ms)".to_owned(),
            signs: vec![sign(1.0), sign(5.0)],
            rows: (0..values.len()).map(row).collect(),
            panels: vec![DotPanel {
                title: "(a)".to_owned(),
                axis: Axis::log10("error"),
                dots: values.iter().map(|row| row.map(dot).to_vec()).collect(),
                marks: Vec::new(),
                floor: None,
            }],
        }
    }

    fn words(drawing: &Drawing) -> Vec<&str> {
        let words = drawing.shapes.iter().filter_map(|shape| match shape {
            Shape::Text(text) => Some(text.content.as_str()),
            _ => None,
        });
        words.collect()
    }

    #[test]
    fn every_row_has_its_name_and_a_lost_run_says_diverged() {
        let drawing = plot(&[[1.0, 2.0], [3.0, f64::NAN]], 1.0).draw();
        for wanted in ["row 0", "row 1", "H = 5 ms", "diverged, %", "100"] {
            assert!(words(&drawing).contains(&wanted), "{wanted}: {:?}", words(&drawing));
        }
        let note = &drawing.data[0].series[1].points[1];
        assert!(note.note == "100 % of the runs diverged" && note.at.is_some(), "{note:?}");
        assert!(!words(&plot(&[[1.0, 2.0]], 0.0).draw()).contains(&"diverged, %"));
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
        long.panels[0].floor = Some(1.5);
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
    fn a_run_without_an_answer_is_not_drawn_as_diverged() {
        let mut silent = plot(&[[1.0, f64::NAN]], 0.0);
        silent.panels[0].dots[0][1].lost = Some(Loss { failed: 0.0, silent: 1.0 });
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
        none.panels[0].dots[2].iter_mut().for_each(|dot| dot.lost = None);
        let drawing = none.draw();
        let count = |word: &str| words(&drawing).iter().filter(|said| **said == word).count();
        assert_eq!((count("no value"), count("not run")), (1, 1));
    }
}

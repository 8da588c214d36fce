//! The rows of a plot, one per scheme, so that neither lines cross nor colours have to be told apart: a sign per value
//! along an axis, or in each column a sign for what became of the runs.

use super::axes::{AXIS, BELOW, GRID, TICK, TICK_SIZE, fitting_ticks, label_width, labels, tick_below, ticks_below};
use super::chart::{Cell, Guide, Mode, Name, Plot, Series};
use super::clip::Rect;
use super::data::{self, MARKER};
use super::drawing::{Anchor, Color, Drawing, Point, SeriesData, Stroke, Text};
use super::scale::{AxisMap, interval};
use super::{guides, marker};
use crate::line_style::Marker;

/// Height of a row, px.
const ROW: f64 = 14.0;
const SWATCH: f64 = 8.0;
/// Least and largest width of the part right of a panel that a kind of sign gets for the runs that it lost, px.
const LOST: [f64; 2] = [21.0, 26.0];
/// Between a panel and that part, px.
const BESIDE: f64 = 12.0;
/// What stands below it.
const FAILED: &str = "failed, %";
/// What stands there for runs that gave no answer.
pub const SILENT: &str = "?";
/// Between the words there, px.
const BETWEEN_LOST: f64 = 3.5;
/// How far signs of one row stand above each other, px.
const APART: f64 = 2.1;
/// Widest column of cells, px.
pub const WIDEST_COLUMN: f64 = 64.0;
/// Radius of the disc around a count of one, and what the largest count adds, px.
const COUNT: [f64; 2] = [4.4, 2.4];
/// What [`Cell::Wrong`] means.
pub const WRONG: &str = "all complete, but the median error is above a tenth of the peak";
/// The colours of no failure and of nothing else.
const NONE_FAILED: Color = Color(0xD9, 0xE8, 0xDF);
const ALL_FAILED: Color = Color(0xB0, 0x12, 0x0A);

/// Signs, by their number.
pub const SIGNS: [Marker; 9] = [
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

/// Height of the area of a panel with rows, px.
pub fn height(panel: &Plot) -> f64 {
    if panel.has_rows() { ROW * panel.layers.len() as f64 + 6.0 } else { 0.0 }
}

/// Room left of a panel for the labels of its rows, px.
pub fn labels_width(panel: &Plot) -> f64 {
    panel.layers.iter().map(|series| label_width(&series.label)).fold(0.0, f64::max) + SWATCH + 12.0
}

/// Number of columns of cells; none along an axis.
pub fn columns(panel: &Plot) -> Option<usize> {
    panel.layers.first().filter(|series| series.mode == Mode::Cells).map(|_| panel.axes[0].names.len())
}

/// What became of the runs of rows along an axis.
fn lost(panel: &Plot) -> impl Iterator<Item = &Cell> {
    panel.layers.iter().filter(|series| series.mode == Mode::Row).flat_map(|series| &series.cells)
}

/// Room for what is lost right of a panel, px.
pub fn lost_width(panel: &Plot) -> f64 {
    // Without it what was not run would look like what lost none.
    let said = lost(panel).any(|cell| *cell != Cell::Failed(0.0));
    if said { lost_column(panel) * panel.axes[0].names.len() as f64 + BESIDE } else { 0.0 }
}

/// Whether all panels lose the same runs: the last one of a line says it for all.
pub fn lose_the_same(panels: &[Plot]) -> bool {
    panels.windows(2).all(|pair| lost(&pair[0]).eq(lost(&pair[1])))
}

/// Width of the part of one kind of sign in it, px.
fn lost_column(panel: &Plot) -> f64 {
    let names = &panel.axes[0].names;
    let widest = names.iter().map(|name| label_width(&name.short)).fold(0.0, f64::max);
    (widest + BETWEEN_LOST).clamp(LOST[0], LOST[1]).max(label_width(FAILED) / names.len().max(1) as f64)
}

/// Draws the rows of a panel into its plotting area, with their labels where it is the `first` of a line, and beside it
/// what is lost where there is `room` for it. Returns their data.
pub fn draw(drawing: &mut Drawing, panel: &Plot, area: &Rect, [first, room]: [bool; 2]) -> Vec<SeriesData> {
    let [names, values] = &panel.axes;
    let map = match columns(panel) {
        Some(_) => {
            draw_columns(drawing, area, &names.names);
            labels(drawing, area, &panel.title, &names.label);
            None
        }
        None => {
            labels(drawing, area, &panel.title, &values.label);
            Some(draw_axis(drawing, panel, area))
        }
    };
    if room {
        draw_lost_axis(drawing, panel, area);
    }
    let mut data = Vec::new();
    for (index, series) in panel.layers.iter().enumerate() {
        let y = area.top + 3.0 + (index as f64 + 0.5) * ROW;
        drawing.line(vec![(area.left, y), (area.right, y)], Stroke { dash: &[1.0, 3.0], ..GRID });
        drawing.group(series.data_name(), |drawing| {
            if first {
                draw_row_label(drawing, series, (area.left, y));
            }
            let places = match &map {
                Some(map) => draw_row(drawing, panel, series, map, (room.then_some(area.right + BESIDE), y)),
                None => draw_cells(drawing, panel, series, area, y),
            };
            data.push(data::exact(series, |index| places.get(index).copied().flatten()));
        });
    }
    data
}

/// Draws the axis of values and what lies below the floor; returns how values become places.
fn draw_axis(drawing: &mut Drawing, panel: &Plot, area: &Rect) -> AxisMap {
    let axis = &panel.axes[1];
    let of_row = |series: &'_ Series| {
        let bars = series.bars.iter().flat_map(|(_, ends)| *ends);
        series.points.iter().map(|point| point.1).chain(bars).collect::<Vec<f64>>()
    };
    let (low, high) = interval(axis, panel.layers.iter().flat_map(of_row), 0.06);
    let map = AxisMap { scale: axis.scale, low, high, start: area.left, end: area.right };
    for mark in &panel.marks {
        let Guide::Below(y) = mark else { continue };
        if let Some(at) = map.position(*y).filter(|at| *at > area.left) {
            let shaded = Rect { right: at.min(area.right), ..*area };
            drawing.area(shaded.corners(), Some(guides::SHADE), None);
        }
    }
    ticks_below(drawing, &map, &fitting_ticks(&map), area.bottom, area.top);
    drawing.line(vec![(area.left, area.top), (area.left, area.bottom), (area.right, area.bottom)], AXIS);
    map
}

/// Draws the bars, signs and marks of one row, and what it lost from `lost` on; returns where its points stand.
fn draw_row(
    drawing: &mut Drawing,
    panel: &Plot,
    series: &Series,
    map: &AxisMap,
    (lost, y): (Option<f64>, f64),
) -> Vec<Option<Point>> {
    let (names, color) = (&panel.axes[0].names, series.style.color);
    let inside = |value: f64| map.position(value).filter(|at| (map.start..=map.end).contains(at));
    for x in series.marks.iter().filter_map(|value| inside(*value)) {
        drawing.line(vec![(x, y - 3.6), (x, y + 3.6)], Stroke::solid(color.mix(Color::WHITE, 0.45), 0.7));
    }
    let height = |index: usize| y + APART * (index as f64 - 0.5 * (names.len() as f64 - 1.0)).clamp(-2.0, 2.0);
    for (x, ends) in &series.bars {
        let index = series.points.iter().position(|point| point.0 == *x).unwrap_or(0);
        if let [Some(from), Some(to)] = ends.map(|end| map.position(end)) {
            let ends = [from, to].map(|end| (end.clamp(map.start, map.end), height(index)));
            drawing.line(ends.to_vec(), Stroke::solid(color, 0.7));
        }
    }
    if let Some(word) = without_sign(series) {
        drawing.text(Text::new(word, (map.start + 5.0, y), TICK_SIZE).colored(Color::SOFT_INK).centred());
    }
    let mut places = Vec::new();
    for (index, ((point, cell), sign)) in series.points.iter().zip(&series.cells).zip(SIGNS).enumerate() {
        let at = inside(point.1).map(|x| (x, height(index)));
        if let Some(at) = at {
            marker::draw(drawing, sign, at, MARKER, color);
        }
        let beside = lost.map(|left| (left + (index as f64 + 0.5) * lost_column(panel), y));
        if let Some(beside) = beside {
            let (said, color) = match *cell {
                Cell::Absent(absent) => (absent.sign().to_owned(), Color::SOFT_INK),
                Cell::Silent => (SILENT.to_owned(), Color::INK),
                Cell::Failed(share) if share > 0.0 => (per_cent(share), Color::INK),
                _ => ("0".to_owned(), Color::SOFT_INK),
            };
            drawing.text(Text::new(&said, beside, TICK_SIZE).anchored(Anchor::Middle).colored(color).centred());
        }
        let is_lost = !matches!(cell, Cell::Absent(_) | Cell::Failed(0.0));
        places.push(at.or(beside.filter(|_| is_lost)));
    }
    places
}

/// The part for lost runs: a column for each kind of sign.
fn draw_lost_axis(drawing: &mut Drawing, panel: &Plot, area: &Rect) {
    let (left, column, names) = (area.right + BESIDE, lost_column(panel), &panel.axes[0].names);
    let edge = Stroke { dash: &[1.5, 2.5], ..AXIS };
    drawing.line(vec![(left, area.top), (left, area.bottom)], edge);
    for (index, name) in names.iter().enumerate() {
        let at = (left + (index as f64 + 0.5) * column, area.bottom + TICK + 7.5);
        let text = Text::new(&name.short, at, TICK_SIZE).anchored(Anchor::Middle).centred();
        // Of one kind of sign the subtitle says enough, and a number above "%" would be read as a share.
        if text.width() <= column && names.len() > 1 {
            drawing.text(text.colored(Color::SOFT_INK));
        }
    }
    let middle = left + 0.5 * column * names.len() as f64;
    let word = Text::new(FAILED, (middle, area.bottom + BELOW - 6.0), TICK_SIZE).anchored(Anchor::Middle);
    drawing.text(word.colored(Color::SOFT_INK));
}

/// Width of one of so many columns.
fn step(area: &Rect, columns: usize) -> f64 {
    area.width() / columns.max(1) as f64
}

/// Shades every other column and writes below each what it is.
fn draw_columns(drawing: &mut Drawing, area: &Rect, names: &[Name]) {
    let step = step(area, names.len());
    for (index, name) in names.iter().enumerate() {
        let left = area.left + index as f64 * step;
        if index % 2 == 0 {
            let shaded = Rect { left, right: left + step, ..*area };
            drawing.area(shaded.corners(), Some(Color::WHITE.mix(Color::GRID, 0.4)), None);
        }
        tick_below(drawing, (left + 0.5 * step, area.bottom), &name.short);
    }
}

/// Draws the cells of one row; returns where they stand.
fn draw_cells(drawing: &mut Drawing, panel: &Plot, series: &Series, area: &Rect, y: f64) -> Vec<Option<Point>> {
    let counts = panel.layers.iter().flat_map(|series| &series.cells);
    let most = counts.filter_map(|cell| if let Cell::Count(count) = cell { Some(*count) } else { None }).max();
    let step = step(area, panel.axes[0].names.len());
    let place = |index: usize| (area.left + (index as f64 + 0.5) * step, y);
    for (index, cell) in series.cells.iter().enumerate() {
        draw_cell(drawing, place(index), *cell, series.style.color, (most.unwrap_or(1), step));
    }
    (0..series.cells.len()).map(|index| Some(place(index))).collect()
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
                letters(drawing, &per_cent(share), ink);
            }
        }
        Cell::Lost(share) if share >= 1.0 => {
            marker::draw(drawing, Marker::Cross, at, 0.8 * MARKER, Color::SOFT_INK.mix(Color::WHITE, 0.45));
        }
        Cell::Lost(_) => marker::draw(drawing, Marker::SomeLost, at, 1.2 * MARKER, color),
        Cell::Count(0) => {}
        Cell::Count(count) => {
            drawing.disc(at, COUNT[0] + COUNT[1] * (count as f64 / most as f64).sqrt(), Some(color), None);
            letters(drawing, &count.to_string(), Color::WHITE);
        }
    }
}

/// A share that is not zero, as a number of per cent.
fn per_cent(share: f64) -> String {
    format!("{:.0}", (100.0 * share).max(1.0))
}

/// Writes the label of a row, with a swatch of its colour, left of a place.
fn draw_row_label(drawing: &mut Drawing, series: &Series, (right, y): Point) {
    let (left, half) = (right - 7.0 - SWATCH, 0.5 * SWATCH);
    let swatch = Rect { left, top: y - half, right: left + SWATCH, bottom: y + half };
    drawing.area(swatch.corners(), Some(series.style.color), None);
    drawing.text(Text::new(&series.label, (left - 5.0, y), TICK_SIZE).anchored(Anchor::End).centred());
}

/// What is said of a row without any sign in a panel; nothing of one that has some.
fn without_sign(series: &Series) -> Option<&'static str> {
    let mut shown = series.points.iter().zip(&series.cells);
    let absent = |cell: &Cell| if let Cell::Absent(absent) = cell { Some(absent.in_words()) } else { None };
    let why: Option<Vec<&str>> = series.cells.iter().map(absent).collect();
    let is_shown =
        |(point, cell): (&Point, &Cell)| point.1.is_finite() || !matches!(cell, Cell::Absent(_) | Cell::Failed(0.0));
    let words = why.map_or("no value", |why| why.first().copied().unwrap_or("not run"));
    (!shown.any(is_shown)).then_some(words)
}

#[cfg(test)]
mod tests {
    use super::super::chart::{Absent, Axis, Figure, Loss};
    use super::super::drawing::Shape;
    use super::super::line_style::LineStyle;
    use super::*;

    fn plot(values: &[[f64; 2]], lost: f64) -> Figure {
        let name = |value: f64| Name { value, short: format!("{value}"), label: format!("H = {value} ms") };
        let across = Axis::named("macro step H (ms)", vec![name(1.0), name(5.0)]);
        let row = |(k, values): (usize, &[f64; 2])| {
            let loss = values.map(|value| Loss { failed: if value.is_nan() { lost } else { 0.0 }, silent: 0.0 });
            Series {
                name: format!("row-{k}"),
                notes: loss.iter().map(Loss::in_words).collect(),
                cells: loss.map(Cell::of).to_vec(),
                mode: Mode::Row,
                ..Series::new(
                    format!("row {k}"),
                    vec![(1.0, values[0]), (5.0, values[1])],
                    LineStyle::of_name("rim-nonsmooth"),
                )
            }
        };
        let panel =
            values.iter().enumerate().map(row).fold(Plot::new("(a)", across, Axis::log10("error")), Plot::layer);
        Figure::new(500.0, 0.0, None).panel(panel)
    }

    fn set(figure: &mut Figure, row: usize, cell: Cell) {
        figure.panels[0].layers[row].cells[1] = cell;
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
        let drawing = plot(&[[1.0, 2.0], [3.0, f64::NAN]], 1.0).draw().unwrap();
        for wanted in ["row 0", "row 1", "H = 5 ms", "failed, %", "100"] {
            assert!(words(&drawing).contains(&wanted), "{wanted}: {:?}", words(&drawing));
        }
        let note = &drawing.data[0].series[1].points[1];
        assert!(note.note == "100 % of the runs failed" && note.at.is_some(), "{note:?}");
        assert!(!words(&plot(&[[1.0, 2.0]], 0.0).draw().unwrap()).contains(&"failed, %"));
    }

    #[test]
    fn equal_values_of_one_row_stand_beside_each_other() {
        let drawing = plot(&[[2.0, 2.0]], 0.0).draw().unwrap();
        let [one, two] = &drawing.data[0].series[0].points[..] else { panic!() };
        assert!(one.at.unwrap().1 != two.at.unwrap().1);
    }

    #[test]
    fn a_key_of_many_entries_is_broken_into_lines_and_nothing_ends_beyond_the_picture() {
        let mut long = plot(&[[1.0, 2.0], [3.0, f64::NAN]], 0.5);
        let few = long.draw().unwrap().height;
        let names = &mut long.panels[0].axes[0].names;
        names.extend(
            (0..5)
                .map(|k| Name { label: format!("macro step {k} of each case"), ..names[0].clone() })
                .collect::<Vec<_>>(),
        );
        long.panels[0].marks = vec![Guide::Below(1.5)];
        let drawing = long.draw().unwrap();
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
        assert!(drawing.height >= few + TICK_SIZE * (levels.len() - 1) as f64);
    }

    #[test]
    fn a_run_without_an_answer_is_not_drawn_as_failed() {
        let mut silent = plot(&[[1.0, f64::NAN]], 0.0);
        set(&mut silent, 0, Cell::of(Loss { failed: 0.0, silent: 1.0 }));
        let drawing = silent.draw().unwrap();
        assert!(words(&drawing).contains(&"?") && words(&drawing).contains(&"?  no answer"));
        assert!(!words(&drawing).contains(&"100"));
        assert!(drawing.data[0].series[0].points[1].at.is_some());
    }

    #[test]
    fn words_below_lost_runs_do_not_touch() {
        let mut plot = plot(&[[1.0, 2.0], [3.0, f64::NAN]], 1.0);
        for (name, short) in plot.panels[0].axes[0].names.iter_mut().zip(["0.2", "0.5"]) {
            name.short = short.to_owned();
        }
        let drawing = plot.draw().unwrap();
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
        none.panels[0].layers[2].cells = vec![Cell::Absent(Absent::NotRun); 2];
        let drawing = none.draw().unwrap();
        let count = |word: &str| words(&drawing).iter().filter(|said| **said == word).count();
        assert_eq!((count("no value"), count("not run")), (1, 1));
    }

    /// A blank was read as either.
    #[test]
    fn what_lost_none_what_was_not_run_and_what_was_left_out_look_different() {
        let mut plot = plot(&[[1.0, 2.0], [3.0, f64::NAN], [4.0, f64::NAN]], 0.0);
        set(&mut plot, 1, Cell::Absent(Absent::NotRun));
        set(&mut plot, 2, Cell::Absent(Absent::LeftOut));
        let drawing = plot.draw().unwrap();
        let count = |word: &str| words(&drawing).iter().filter(|said| **said == word).count();
        assert_eq!(["0", "–", "/"].map(count), [4, 1, 1], "{:?}", words(&drawing));
        assert_eq!(["–  not run", "/  left out"].map(count), [1, 1]);
    }
}

//! The legend shared by all panels: one entry per label, beside the data and never over it.

use super::chart::{Absent, Cell, Guide, Mode, NO_ANSWER, Plot, Series};
use super::clip::Rect;
use super::data::MARKER;
use super::drawing::{Color, Drawing, Text, Weight};
use super::line_style::{LineStyle, Marker};
use super::{font, guides, marker, rows};

/// Size of the entries, px.
const SIZE: f64 = 9.8;
/// Height of a row, px.
pub const ROW: f64 = 15.0;
const SAMPLE: f64 = 27.0;
const GAP: f64 = 5.0;
const BETWEEN: f64 = 15.0;
/// How far the signs of what is lost stand below the middle, px.
const LOWER: f64 = 0.5;

/// What stands before an entry.
enum Sample {
    Series {
        name: String,
        style: LineStyle,
        sign: bool,
    },
    /// A patch of this colour.
    Area(Color),
    /// A sign, so far below the middle of the letters, px.
    Sign(Marker, f64),
    Nothing,
}

/// The entries of a figure.
#[derive(Default)]
pub struct Legend {
    entries: Vec<(Sample, String)>,
}

impl Legend {
    /// Collects one entry per label, in order of appearance, and one for the triangle of infinite values if needed.
    pub fn of(panels: &[Plot], infinite: bool) -> Self {
        let mut entries: Vec<(Sample, String)> = Vec::new();
        for series in panels.iter().filter(|panel| !panel.has_rows()).flat_map(|panel| &panel.layers) {
            let label = entry(panels, series);
            let known = entries.iter().any(|(_, known)| *known == label);
            if !known && !series.label.is_empty() {
                let sign = series.mode != Mode::Line;
                let name = series.data_name().to_owned();
                let sample = Sample::Series { name, style: series.style, sign };
                entries.push((sample, label));
            }
        }
        if panels.iter().flat_map(|panel| &panel.marks).any(|guide| matches!(guide, Guide::Below(_))) {
            entries.push((Sample::Area(guides::SHADE), "below the reference's uncertainty".to_owned()));
        }
        if infinite && !entries.is_empty() {
            entries.push((Sample::Sign(Marker::Beyond, LOWER), "infinite".to_owned()));
        }
        let shares = || panels.iter().flat_map(|panel| &panel.layers).flat_map(|series| &series.lost).map(|p| p.1);
        let signs =
            [(Marker::SomeLost, "some runs failed"), (Marker::Cross, "all runs failed"), (Marker::Silent, NO_ANSWER)];
        for (sign, label) in signs.into_iter().filter(|(sign, _)| shares().any(|loss| loss.sign() == *sign)) {
            entries.push((Sample::Sign(sign, LOWER), label.to_owned()));
        }
        entries.extend(of_rows(panels));
        Legend { entries }
    }

    /// The entries of lines, and the others.
    pub fn split(self) -> (Legend, Legend) {
        let is_line = |(sample, _): &(Sample, String)| matches!(sample, Sample::Series { .. });
        let (lines, others) = self.entries.into_iter().partition(is_line);
        (Legend { entries: lines }, Legend { entries: others })
    }

    /// Width as a single column, px.
    pub fn column_width(&self) -> f64 {
        self.entries.iter().map(width).fold(0.0, f64::max)
    }

    /// Height as a single column, px.
    pub fn column_height(&self) -> f64 {
        self.entries.len() as f64 * ROW
    }

    /// Height as centred rows within a width, px; zero without entries.
    pub fn rows_height(&self, available: f64) -> f64 {
        self.rows(available).len() as f64 * ROW
    }

    /// Draws it as centred rows, the first row's upper edge at `top`.
    pub fn draw_rows(&self, drawing: &mut Drawing, left: f64, top: f64, available: f64) {
        for (index, row) in self.rows(available).into_iter().enumerate() {
            let length: f64 = row.iter().map(|entry| width(entry)).sum::<f64>() + BETWEEN * (row.len() - 1) as f64;
            let mut x = left + 0.5 * (available - length).max(0.0);
            for entry in row {
                draw_entry(drawing, entry, x, top + (index as f64 + 0.5) * ROW);
                x += width(entry) + BETWEEN;
            }
        }
    }

    /// Draws each entry as near as there is room to the height at which its line ends, between two heights.
    pub fn draw_at_lines(&self, drawing: &mut Drawing, left: f64, [top, bottom]: [f64; 2], ends: &[(String, f64)]) {
        let end = |label: &str| ends.iter().find(|(known, _)| *known == label).map_or(top, |(_, end)| *end);
        let mut entries: Vec<(f64, &(Sample, String))> =
            self.entries.iter().map(|entry| (end(&entry.1), entry)).collect();
        entries.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut next = top + 0.5 * ROW;
        for place in &mut entries {
            place.0 = place.0.max(next);
            next = place.0 + ROW;
        }
        let mut last = bottom - 0.5 * ROW;
        for place in entries.iter_mut().rev() {
            place.0 = place.0.min(last);
            last = place.0 - ROW;
        }
        for (y, entry) in entries {
            draw_entry(drawing, entry, left, y);
        }
    }

    /// Breaks the entries into rows of about equal length.
    fn rows(&self, available: f64) -> Vec<Vec<&(Sample, String)>> {
        let fill = |limit: f64| {
            let (mut rows, mut length) = (Vec::<Vec<_>>::new(), f64::INFINITY);
            for entry in &self.entries {
                length += BETWEEN + width(entry);
                match rows.last_mut() {
                    Some(row) if length <= limit => row.push(entry),
                    _ => {
                        rows.push(vec![entry]);
                        length = width(entry);
                    }
                }
            }
            rows
        };
        let fewest = fill(available).len();
        let narrower = (1..=20).map(|k| available * f64::from(k) / 20.0);
        narrower.map(fill).find(|rows| rows.len() <= fewest).unwrap_or_default()
    }
}

/// What the signs of rows stand for.
fn of_rows(panels: &[Plot]) -> Vec<(Sample, String)> {
    let mut entries: Vec<(Sample, String)> = Vec::new();
    let along = panels.iter().find(|panel| panel.has_rows() && rows::columns(panel).is_none());
    let names = along.map_or(&[][..], |panel| &panel.axes[0].names);
    let several = names.iter().zip(rows::SIGNS).filter(|_| names.len() > 1);
    entries.extend(several.map(|(name, sign)| (Sample::Sign(sign, 0.0), name.label.clone())));
    let any = |test: &dyn Fn(&Cell) -> bool| {
        panels.iter().flat_map(|panel| &panel.layers).flat_map(|series| &series.cells).any(test)
    };
    let mut say = |said: bool, sample: Sample, words: String| entries.extend(said.then_some((sample, words)));
    say(any(&|cell| *cell == Cell::Silent), Sample::Nothing, format!("{}  {NO_ANSWER}", rows::SILENT));
    for absent in Absent::ALL {
        let words = format!("{}  {}", absent.sign(), absent.in_words());
        say(any(&|cell| *cell == Cell::Absent(absent)), Sample::Nothing, words);
    }
    say(any(&|cell| *cell == Cell::Right), Sample::Sign(Marker::Circle, 0.0), "all runs complete".into());
    say(any(&|cell| *cell == Cell::Wrong), Sample::Sign(Marker::OpenCircle, 0.0), rows::WRONG.into());
    for (all, sign, words) in [(false, Marker::SomeLost, "some fail"), (true, Marker::Cross, "all fail")] {
        let is_lost = |cell: &Cell| matches!(cell, Cell::Lost(share) if (*share >= 1.0) == all);
        say(any(&is_lost), Sample::Sign(sign, LOWER), words.into());
    }
    entries
}

/// What the legend says of a series: its label, and where it is nowhere drawn that it is not.
fn entry(panels: &[Plot], series: &Series) -> String {
    let name = series.data_name();
    let of_name = |panel: &&Plot| panel.layers.iter().any(|other| other.label == series.label);
    let is_drawn = panels.iter().filter(of_name).any(|panel| panel.shows(&series.label, name));
    let is_known = |panel: &Plot| {
        let own = panel.layers.iter().filter(|other| other.label == series.label);
        own.flat_map(|other| &other.points).any(|(x, y)| x.is_finite() && y.is_finite())
    };
    match (is_drawn, panels.iter().any(is_known)) {
        (true, _) => series.label.clone(),
        (false, true) => format!("{}: outside the frame", series.label),
        (false, false) => format!("{}: nowhere drawn", series.label),
    }
}

/// Room of a sample and the gap behind it, px.
fn indent(sample: &Sample) -> f64 {
    let sign = match sample {
        Sample::Series { .. } | Sample::Area(_) => SAMPLE,
        Sample::Sign(..) => 2.0 * MARKER,
        Sample::Nothing => -GAP,
    };
    sign + GAP
}

fn width((sample, label): &(Sample, String)) -> f64 {
    indent(sample) + font::width(label, SIZE, Weight::Regular)
}

fn draw_entry(drawing: &mut Drawing, entry: &(Sample, String), left: f64, y: f64) {
    match &entry.0 {
        Sample::Series { name, .. } => drawing.group(name, |drawing| draw_inside(drawing, entry, left, y)),
        _ => draw_inside(drawing, entry, left, y),
    }
}

fn draw_inside(drawing: &mut Drawing, (sample, label): &(Sample, String), left: f64, y: f64) {
    match sample {
        Sample::Series { style, sign, .. } => {
            drawing.line(vec![(left, y), (left + SAMPLE, y)], style.stroke());
            if *sign {
                marker::draw(drawing, style.marker, (left + 0.5 * SAMPLE, y), MARKER, style.color);
            }
        }
        Sample::Area(color) => {
            let place = Rect { left, top: y - 0.35 * SIZE, right: left + SAMPLE, bottom: y + 0.35 * SIZE };
            drawing.area(place.corners(), Some(*color), None);
        }
        Sample::Sign(sign, lower) => {
            marker::draw(drawing, *sign, (left + MARKER, y + lower), MARKER, Color::SOFT_INK);
        }
        Sample::Nothing => {}
    }
    drawing.text(Text::new(label, (left + indent(sample), y), SIZE).centred());
}

//! A case at a row of instants, one row per scheme.

use super::trace_figure::{lost_run, trace};
use super::valid;
use super::{FigureOptions, Source};
use crate::case_picture::{Motion, View, arrow};
use crate::clip::Rect;
use crate::drawing::{Anchor, Color, Drawing, Stroke, Text};
use crate::figure::fits;
use crate::style::Styles;
use crate::ticks::signed;
use rimbench_cases::cases::{Drawing as CaseDrawing, standard_cases};
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::{ResultsTable, read_table};
use rimbench_results::selection::Runs;
use serde::Deserialize;
use std::path::Path;

/// Options of a manoeuvre figure.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManoeuvreFigure {
    /// Width, px; 680 px are 180 mm on paper, two columns.
    #[serde(default = "valid::width", deserialize_with = "valid::pixels")]
    width: f64,
    /// Scheme rows, one row of drawings each.
    schemes: Vec<String>,
    /// Instants, s; the communication point nearest to each is drawn.
    #[serde(deserialize_with = "valid::some_numbers")]
    instants_s: Vec<f64>,
    /// By how much the difference from the reference is drawn larger.
    #[serde(deserialize_with = "valid::positive")]
    enlarged: f64,
}

/// Contact force of the arrow in the legend, N.
const ARROW_N: f64 = 2000.0;
const MARGIN: f64 = 8.0;
const HEADER: f64 = 18.0;
const ROW_LABEL: f64 = 20.0;
const BETWEEN: f64 = 8.0;
const LEGEND: f64 = 26.0;
const EDGE: Stroke = Stroke { color: Color(0xC9, 0xCE, 0xD3), width: 1.0, dash: &[] };
/// Column of the actuator's force.
const FORCE: &str = "actuator_force_n";

/// What an experiment of one case draws: the case, its reference, and how runs move.
struct Scene {
    of: CaseDrawing,
    reference: ResultsTable,
}

impl Scene {
    /// Reads the case and its parameters from the results.
    fn read(folder: &Path, runs: &Runs<'_>) -> Result<Self> {
        let table = read_table(&folder.join("parameters.csv"))?;
        let [case, parameter, value] = ["case", "parameter", "value"].map(|name| table.column(name));
        let (case, parameter, value) = (case?, parameter?, value?);
        let name = if table.is_empty() { "" } else { table.text(0, case) };
        let known = standard_cases().into_iter().find(|known| known.name == name);
        let known = known.ok_or_else(|| Error::file(table.path(), format!("has no case that is drawn: `{name}`")))?;
        let mut parameters = known.default_parameters();
        for row in table.rows_where(case, name) {
            parameters.set(table.text(row, parameter), table.text(row, value))?;
        }
        let of = (known.drawing)(&parameters);
        let of = of.ok_or_else(|| Error::file(table.path(), format!("{name} is not drawn with these")))?;
        if !of.coordinates().is_empty() {
            let text = format!("{name} is drawn by the places of single bodies, which no trace has: the page has them");
            return Err(Error::file(table.path(), text));
        }
        Ok(Scene { of, reference: trace(folder, runs, "reference")? })
    }

    fn motion(&self, trace: &ResultsTable, enlarged: f64) -> Result<Motion> {
        Motion::read(&self.of, trace, &self.reference, enlarged)
    }
}

impl FigureOptions for ManoeuvreFigure {
    type Panel = ();

    /// Draws the figure from `parameters.csv` and the traces.
    ///
    /// # Errors
    /// [`Error::File`] for what is not there; [`Error::Incompatible`] if its cells have no room.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
        let (folder, runs) = (&*source.folder, Runs::of(source.runs()?));
        let scene = Scene::read(folder, &runs)?;
        let reference = scene.motion(&scene.reference, 1.0)?;
        let columns = self.instants_s.len() as f64;
        let cell = ((self.width - 2.0 * MARGIN - BETWEEN * (columns - 1.0)) / columns).floor();
        fits(&[("width", self.width, cell)])?;
        let [[left, right], [low, high]] = scene.of.view;
        let tall = (cell * (high - low) / (right - left)).round();
        let row_height = ROW_LABEL + tall + BETWEEN;
        let height = 2.0 * MARGIN + HEADER + self.schemes.len() as f64 * row_height + LEGEND - BETWEEN;
        let mut drawing = Drawing::new(self.width, height);
        let left_of = |column: usize| MARGIN + column as f64 * (cell + BETWEEN);
        for (column, instant) in self.instants_s.iter().enumerate() {
            let text = Text::new(format!("t = {instant:.3} s"), (left_of(column) + 0.5 * cell, MARGIN + 10.0), 10.6);
            drawing.text(text.bold().anchored(Anchor::Middle));
        }
        for (index, label) in self.schemes.iter().enumerate() {
            let (trace, color) = (trace(folder, &runs, label)?, styles.of_label(label).color);
            let end = lost_run(&runs, label).map_or("ended", |row| runs.run(row).found.outcome.name());
            let (motion, force) = (scene.motion(&trace, self.enlarged)?, trace.column(FORCE)?);
            let top = MARGIN + HEADER + index as f64 * row_height;
            let name = Text::new(styles.shown_name(label), (MARGIN, top + 0.5 * ROW_LABEL), 10.6).bold();
            let rule_y = (top + 0.5 * ROW_LABEL).floor() + 0.5;
            let rule = vec![(MARGIN + name.width() + 10.0, rule_y), (self.width - MARGIN, rule_y)];
            drawing.text(name.colored(color.mix(Color::INK, 0.15)).centred());
            drawing.line(rule, Stroke::solid(color.mix(Color::WHITE, 0.55), 1.0));
            for (column, &instant) in self.instants_s.iter().enumerate() {
                let (left, top) = (left_of(column) + 0.5, top + ROW_LABEL + 0.5);
                let place = Rect { left, top, right: left + cell - 1.0, bottom: top + tall - 1.0 };
                let there = motion.row_at(instant);
                let finite = |row: &usize| motion.columns.values().all(|values| values[*row].is_finite());
                if let Some(row) = there.filter(finite) {
                    let view = View { place, follow: motion.follow[row] };
                    view.draw(&mut drawing, &scene.of, &motion.row(row), Some(color));
                    if let Some(row) = reference.row_at(instant) {
                        view.draw(&mut drawing, &scene.of, &reference.row(row), None);
                    }
                    let kilonewtons = trace.number(row, force) / 1000.0;
                    let plus = if kilonewtons >= 0.005 { "+" } else { "" };
                    let words = format!("F = {plus}{} kN", signed(format!("{kilonewtons:.2}")));
                    drawing.text(Text::new(words, (left + 5.0, place.bottom - 3.0), 9.4));
                } else {
                    let text = Text::new(end, place.centre(), 10.0).anchored(Anchor::Middle);
                    drawing.text(text.colored(Color::SOFT_INK).centred());
                }
                drawing.area(place.corners(), None, Some(EDGE));
            }
        }
        let place = Rect { left: 0.0, top: 0.0, right: cell, bottom: tall };
        self.legend(&mut drawing, &scene.of, View { place, follow: 0.0 }.scale(&scene.of));
        Ok(drawing)
    }
}

impl ManoeuvreFigure {
    fn legend(&self, drawing: &mut Drawing, of: &CaseDrawing, scale: f64) {
        use rimbench_cases::cases::Shape::Arrow;
        let (y, mut x) = (drawing.height - MARGIN - 10.0, MARGIN);
        let mut words = vec!["thin outline: the reference".to_owned()];
        if let Some(Arrow { scale: per_newton, .. }) = of.shapes.iter().find(|shape| matches!(shape, Arrow { .. })) {
            let length = scale * per_newton * ARROW_N;
            arrow(drawing, (MARGIN, y), (MARGIN + length, y), 1);
            x += length + 7.0;
            words.insert(0, format!("contact force of {} kN", ARROW_N / 1000.0));
        }
        if self.enlarged > 1.0 {
            words.push(format!("differences from it {} times larger", self.enlarged));
        }
        drawing.text(Text::new(words.join(" · "), (x, y), 9.8).centred());
    }
}

//! One macro step magnified: what happens to a contact, and what schemes believe of it.

use super::valid;
use super::{FigureOptions, Source};
use crate::case_picture::{View, poses, within};
use crate::clip::{Rect, polygon, polyline};
use crate::data::straightened;
use crate::drawing::{Anchor, Color, Datum, Drawing, PanelData, Point, SeriesData, Stroke, Text};
use crate::style::Styles;
use crate::ticks::{linear, signed};
use rimbench_cases::cases::standard_cases;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::{ResultsTable, read_table};
use rimbench_results::run_table::Run;
use serde::Deserialize;

/// Options of a figure of the mechanism.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MechanismFigure {
    /// Scheme rows whose beliefs are stored.
    beliefs: Vec<String>,
    /// What each of them believes, in words.
    words: Vec<String>,
    /// Panels, from the left.
    #[serde(deserialize_with = "valid::panels")]
    panels: Vec<MechanismPanel>,
}

/// A macro step.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MechanismPanel {
    /// Heading.
    title: String,
    /// What happens, in words.
    note: String,
    /// The case whose beliefs are shown.
    case: String,
    /// The contact that opens or closes, by name.
    contact: String,
    /// Where it is on its frame: that of the drawing, and the point, m.
    frame: String,
    /// x and y in that frame, m.
    #[serde(deserialize_with = "valid::some_numbers")]
    at: Vec<f64>,
}

/// Right and wrong: colours that a deuteranope tells apart, beside sign and word.
const RIGHT: Color = Color(0x00, 0x63, 0x9C);
const WRONG: Color = Color(0xB8, 0x4A, 0x00);
/// Share of the largest true force by which a right force may be off.
const OFF: f64 = 0.01;
/// Gap below which a contact is drawn as closed, as a share of the largest that happens.
const CLOSED: f64 = 0.01;
/// Forces beyond so many times the true ones are cut.
const BEYOND: f64 = 3.0;
const WIDTH: f64 = 830.0;
const COLUMNS: [f64; 2] = [190.0, 324.0];
const LANE: f64 = 59.0;
const LANES: f64 = 128.0;
const STROBES: usize = 5;
const SOFT: Stroke = Stroke { color: Color::SOFT_INK, width: 1.2, dash: &[] };

/// What happens, or what a scheme believes: per micro step time (s), gap (m), contact force and force (N).
struct Rows {
    rows: Vec<[f64; 4]>,
    /// Whether any contact acts.
    acts: bool,
}

impl Rows {
    fn read(table: &ResultsTable, scheme: &str, contact: &str) -> Result<Self> {
        let names = [
            "time_s".to_owned(),
            format!("gap_{contact}_m"),
            format!("contact_force_{contact}_n"),
            "actuator_force_n".to_owned(),
        ];
        let mut columns = [0; 4];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = table.column(&name)?;
        }
        let of_scheme = table.rows_where(table.column("scheme")?, scheme);
        if of_scheme.len() < 2 {
            return Err(Error::file(table.path(), format!("has no belief of `{scheme}`")));
        }
        let forces = |name: &String| name.starts_with("contact_force_");
        let forces: Vec<usize> = (0..table.names().len()).filter(|&column| forces(&table.names()[column])).collect();
        let acts = of_scheme.iter().any(|&row| forces.iter().any(|&column| table.number(row, column) != 0.0));
        let rows = of_scheme.iter().map(|&row| columns.map(|column| table.number(row, column))).collect();
        Ok(Rows { rows, acts })
    }

    fn first(&self) -> [f64; 4] {
        self.rows[0]
    }

    fn last(&self) -> [f64; 4] {
        self.rows[self.rows.len() - 1]
    }

    fn most(&self, column: usize) -> f64 {
        self.rows.iter().map(|row| row[column].abs()).fold(0.0, f64::max)
    }

    /// Whether the contact pulls, or acts at a distance, as only one that is held does.
    fn is_welded(&self, closed: f64) -> bool {
        self.pull() < 0.0 || self.rows.iter().skip(1).any(|row| row[2].abs() > 0.0 && row[1] > closed)
    }

    /// The contact force that pulls most, N; 0 where none does.
    fn pull(&self) -> f64 {
        self.rows.iter().map(|row| row[2]).fold(0.0, f64::min)
    }
}

/// A force in N below 10 kN, else in kN.
fn force(newtons: f64) -> String {
    match newtons.abs() {
        large if large >= 1e4 => signed(format!("{:.1} kN", newtons / 1e3)),
        _ => signed(format!("{newtons:.0} N")),
    }
}

/// How a page asks for what is believed under a label: the scheme, and what it takes for closed contacts if that is not
/// its own.
fn asked(source: &Source, label: &str) -> String {
    let Ok(table) = source.runs() else { return label.to_owned() };
    let contacts = table.setting("contact_detection").ok();
    let run = table.runs().iter().find(|run| *run.label == *label);
    let words = |run: &Run| {
        let contacts = contacts.map_or("", |place| &*run.settings[place]);
        format!("{} {contacts}", run.scheme).trim_end().to_owned()
    };
    run.map_or_else(|| label.to_owned(), words)
}

/// A macro step with what is shown of it.
struct Column<'a> {
    panel: &'a MechanismPanel,
    table: ResultsTable,
    truth: Rows,
    beliefs: Vec<Rows>,
    left: f64,
    width: f64,
}

impl Column<'_> {
    fn opens(&self) -> bool {
        self.truth.last()[1] > self.truth.first()[1]
    }

    fn closed(&self) -> f64 {
        CLOSED * self.truth.most(1)
    }

    fn is_right(&self, rows: &Rows) -> bool {
        (rows.last()[3] - self.truth.last()[3]).abs() <= OFF * self.truth.most(3)
    }

    fn x(&self, time: f64) -> f64 {
        let [start, end] = [self.truth.first()[0], self.truth.last()[0]];
        self.left + 14.0 + (self.width - 28.0) * (time - start) / (end - start)
    }

    /// What becomes of the contact, in words.
    fn verdict(&self, rows: &Rows) -> Vec<String> {
        let (gap, closed) = (rows.last()[1], self.closed());
        let micrometres = |gap: f64| format!("{:.0} µm", gap * 1e6);
        let words = match self.opens() {
            _ if gap < -closed => ["sinks in".to_owned(), String::new()],
            true if gap > closed => ["lifts off".to_owned(), format!("by {}", micrometres(gap))],
            true if rows.pull() < 0.0 => ["pulls it down".to_owned(), format!("with {}", force(-rows.pull()))],
            true => ["stands still".to_owned(), String::new()],
            false if gap > closed && gap < rows.first()[1] - closed => ["falls".to_owned(), String::new()],
            false if gap > closed => ["hangs in air".to_owned(), String::new()],
            false => [format!("falls {}", micrometres(rows.first()[1])), "and lands".to_owned()],
        };
        words.into_iter().filter(|line| !line.is_empty()).collect()
    }

    /// A lane with what happens, or with a belief and what happens.
    fn lane(&self, drawing: &mut Drawing, top: f64, rows: &Rows, is_truth: bool) {
        let right = is_truth || self.is_right(rows);
        let color = if is_truth {
            Color::INK
        } else if right {
            RIGHT
        } else {
            WRONG
        };
        let lane = Rect { left: self.left, top, right: self.left + self.width, bottom: top + LANE };
        let ground = top + if self.opens() { 44.0 } else { 31.0 };
        let scale = if self.opens() { 20.0 } else { 11.0 } / self.truth.most(1);
        let at = |row: &[f64; 4], least: f64| (self.x(row[0]), ground - scale * row[1].max(least));
        drawing.area(lane.corners(), Some(Color(0xF6, 0xF7, 0xF9)), None);
        drawing.area(Rect { top: ground, ..lane }.corners(), Some(Color::GRID), None);
        drawing.line(vec![(lane.left, ground), (lane.right, ground)], SOFT);
        let path = |rows: &Rows, least: f64| straight(rows.rows.iter().map(|row| at(row, least)).collect());
        let (own, true_path) = (path(rows, f64::NEG_INFINITY), path(&self.truth, 0.0));
        if !right {
            let between: Vec<Point> = own.iter().chain(true_path.iter().rev()).copied().collect();
            drawing.area(polygon(&between, &lane), Some(color.mix(Color::WHITE, 0.72)), None);
        }
        let strobes: Vec<&[f64; 4]> =
            (0..=STROBES).map(|strobe| &rows.rows[(rows.rows.len() - 1) * strobe / STROBES]).collect();
        for row in &strobes {
            let (x, y) = at(row, f64::NEG_INFINITY);
            let (fill, edge) = (color.mix(Color::WHITE, 0.8), Stroke::solid(color, 1.4));
            match self.opens() {
                true => drawing.disc((x, y - 9.0), 9.0, Some(fill), Some(edge)),
                false => {
                    let corners = [(x - 9.0, y - 15.0), (x + 9.0, y - 15.0), (x, y)];
                    drawing.area(polygon(&corners, &lane), Some(fill), Some(edge));
                }
            }
        }
        if !is_truth {
            drawing.line(true_path, Stroke { color: Color::INK, width: 1.3, dash: &[4.0, 3.0] });
        }
        for piece in polyline(&own, |_| lane) {
            drawing.line(piece, Stroke::solid(color, 2.0));
        }
        let welded = rows.acts && !right && rows.is_welded(self.closed());
        for row in strobes.iter().filter(|_| rows.acts) {
            let (x, y) = at(row, f64::NEG_INFINITY);
            if welded {
                drawing.line(vec![(x, y), (x, ground)], Stroke::solid(color, 3.6));
                drawing.area(vec![(x - 6.0, ground), (x, ground - 7.0), (x + 6.0, ground)], Some(color), None);
            } else if lane.inset(3.0).contains((x, y)) {
                let fill = if row[1].abs() <= self.closed() { color } else { Color::WHITE };
                drawing.disc((x, y), 3.4, Some(fill), Some(Stroke::solid(color, 1.5)));
            }
        }
        let (x, shade) = (lane.right + 7.0, color);
        drawing.text(Text::new(force(rows.last()[3]), (x, top + 24.0), 13.0).bold().colored(shade));
        let indent = if is_truth { 0.0 } else { 15.0 };
        if !is_truth {
            let signs: &[&[Point]] = match right {
                true => &[&[(0.0, -4.0), (3.5, 0.0), (9.5, -9.0)]],
                false => &[&[(1.0, -8.5), (9.0, -0.5)], &[(9.0, -8.5), (1.0, -0.5)]],
            };
            for sign in signs {
                let points = sign.iter().map(|(dx, dy)| (x + dx, top + 41.0 + dy)).collect();
                drawing.line(points, Stroke::solid(color, 2.0));
            }
        }
        for (line, words) in self.verdict(rows).iter().enumerate() {
            let at = (x + indent, top + 41.0 + 14.0 * line as f64);
            drawing.text(Text::new(words, at, 11.5).colored(if is_truth { Color::SOFT_INK } else { color }));
        }
    }

    /// The machine when the macro step starts, with a ring around the contact.
    fn machine(&self, drawing: &mut Drawing) -> Result<()> {
        let wrong = |text: &str| Error::file(self.table.path(), format!("{}: {text}", self.panel.case));
        let case = standard_cases().into_iter().find(|case| case.name == self.panel.case.as_str());
        let case = case.ok_or_else(|| wrong("is no case that is drawn"))?;
        let of = (case.drawing)(&case.default_parameters()).ok_or_else(|| wrong("is not drawn"))?;
        let row = self.table.rows_where(self.table.column("scheme")?, "")[0];
        let value = |name: &str| self.table.column(name).map_or(f64::NAN, |column| self.table.number(row, column));
        let place = Rect { left: self.left, top: 22.0, right: self.left + 178.0, bottom: LANES - 16.0 };
        let view = View { place, follow: of.follow.map_or(0.0, value) };
        view.draw(drawing, &of, &value, Some(Color::SOFT_INK));
        let frame = poses(&of, &value).get(&*self.panel.frame).copied();
        let frame = frame.ok_or_else(|| wrong("has no such frame"))?;
        let [x, y] = within(frame, [self.panel.at[0], self.panel.at[1]]);
        let ([[left, right], [low, high]], scale, middle) = (of.view, view.scale(&of), place.centre());
        let ring =
            (middle.0 + scale * (x - view.follow - 0.5 * (left + right)), middle.1 - scale * (y - 0.5 * (low + high)));
        drawing.disc(ring, 10.0, None, Some(Stroke::solid(Color::INK, 1.6)));
        Ok(())
    }
}

impl FigureOptions for MechanismFigure {
    type Panel = MechanismPanel;

    /// Draws the figure from `traces/beliefs-<case>.csv`.
    ///
    /// # Errors
    /// [`Error::File`] for what is not there.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
        let columns = self.panels.iter().enumerate().map(|(index, panel)| {
            let table = read_table(&source.folder.join(format!("traces/beliefs-{}.csv", panel.case)))?;
            let rows = |scheme: &str| Rows::read(&table, scheme, &panel.contact);
            let (truth, beliefs) = (rows("")?, self.beliefs.iter().map(|scheme| rows(scheme)).collect::<Result<_>>()?);
            let left = COLUMNS[0] + COLUMNS[1] * index as f64;
            Ok(Column { panel, table, truth, beliefs, left, width: COLUMNS[1] - 106.0 })
        });
        let columns = columns.collect::<Result<Vec<_>>>()?;
        let names: Vec<String> = self.beliefs.iter().map(|scheme| styles.shown_name(scheme)).collect();
        let lane_top = |index: usize| LANES + (LANE + 5.0) * index as f64;
        let (bottom, plot) = (lane_top(1 + names.len()), 96.0);
        let mut drawing = Drawing::new(WIDTH, bottom + 36.0 + plot + 12.0);
        self.legend(&mut drawing);
        for (index, name) in ["what happens".to_owned()].iter().chain(&names).enumerate() {
            let top = lane_top(index);
            let name = name[..1].to_uppercase() + &name[1..];
            drawing.text(Text::new(name, (12.0, top + 22.0), 12.0).bold());
            let words = index.checked_sub(1).map_or("", |index| &self.words[index]);
            for (line, text) in soft(words, (12.0, 0.0)).broken(176.0).into_iter().enumerate() {
                drawing.text(Text { at: (12.0, top + 37.0 + 14.0 * line as f64), ..text });
            }
        }
        // One scale of forces for all.
        let truths = columns.iter().map(|column| column.truth.most(3)).fold(0.0, f64::max);
        let shown = columns.iter().flat_map(|column| column.beliefs.iter().chain([&column.truth]));
        let shown =
            shown.filter(|rows| rows.most(3) <= BEYOND * truths).flat_map(|rows| rows.rows.iter().map(|row| row[3]));
        let (low, high) = shown.fold((0.0, 0.0), |(low, high): (f64, f64), force| (low.min(force), high.max(force)));
        let (low, high) = (low - 0.08 * (high - low), high + 0.08 * (high - low));
        let top = bottom + 36.0;
        let y = |force: f64| top + plot * (high - force) / (high - low);
        drawing.text(Text::new("Force of the actuator", (12.0, top + 16.0), 12.0).bold());
        drawing.text(soft("grey: what happens", (12.0, top + 31.0)));
        let ticks = linear(low / 1e3, high / 1e3, 4);
        for (index, column) in columns.iter().enumerate() {
            column.machine(&mut drawing)?;
            let beside = column.left + 190.0;
            drawing.text(Text::new(&column.panel.title, (beside, 40.0), 12.4).bold());
            for (line, words) in column.panel.note.split("; ").enumerate() {
                drawing.text(soft(words, (beside, 57.0 + 14.0 * line as f64)));
            }
            let end = column.left + column.width + 7.0;
            drawing.text(soft("force at the end", (end, LANES - 5.0)));
            let [start, end] = [column.truth.first(), column.truth.last()].map(|row| row[0]);
            let panel = column.panel;
            let told = format!("{} {} {start} {end} {}", panel.case, panel.contact, column.truth.rows.len() - 1);
            drawing.part("step", &told, |drawing| {
                drawing.part("lane", "", |drawing| column.lane(drawing, lane_top(0), &column.truth, true));
                for (belief, rows) in column.beliefs.iter().enumerate() {
                    let lane = |drawing: &mut Drawing| column.lane(drawing, lane_top(1 + belief), rows, false);
                    drawing.part("lane", &asked(source, &self.beliefs[belief]), lane);
                }
                drawing.part("span", "", |drawing| {
                    let words = format!("{:.0} ms, no exchange", 1e3 * (end - start));
                    let middle = column.left + 0.5 * column.width;
                    drawing.text(soft(&words, (middle, bottom + 11.0)).anchored(Anchor::Middle));
                    for x in [start, end].map(|time| column.x(time)) {
                        drawing.line(vec![(x, bottom - 2.0), (x, bottom + 5.0)], SOFT);
                    }
                });
                let told = format!("{} {}", y(0.0) - y(1.0), BEYOND * truths);
                drawing.part("forces", &told, |drawing| {
                    self.forces(drawing, (column, &names), (top, plot), &y, BEYOND * truths);
                });
            });
            for tick in ticks.ticks.iter().filter(|_| index == 0) {
                let at = (column.left - 6.0, y(1e3 * tick.value));
                drawing.text(soft(&format!("{} kN", tick.label), at).anchored(Anchor::End).centred());
            }
        }
        Ok(drawing)
    }

    fn finish(&mut self) -> Result<(), String> {
        if self.beliefs.len() != self.words.len() || self.panels.len() != 2 {
            return Err(
                "beliefs and words belong together, and panels are two: one of a contact that opens or closes each"
                    .into(),
            );
        }
        let point = self.panels.iter().find(|panel| panel.at.len() != 2);
        point.map_or(Ok(()), |panel| Err(format!("panels: at = {:?} is not valid; valid: [x, y], m", panel.at)))
    }
}

impl MechanismFigure {
    fn legend(&self, drawing: &mut Drawing) {
        let words =
            ["contact closed", "contact open", "held closed by the model", "what happens", "belief and truth differ"];
        for (index, words) in words.iter().enumerate() {
            let y = 26.0 + 17.0 * index as f64;
            match index {
                0 | 1 => {
                    let fill = if index == 0 { Color::INK } else { Color::WHITE };
                    drawing.disc((21.0, y), 3.6, Some(fill), Some(Stroke::solid(Color::INK, 1.5)));
                }
                2 => drawing.area(vec![(15.0, y + 3.0), (21.0, y - 4.0), (27.0, y + 3.0)], Some(WRONG), None),
                3 => {
                    let dashed = Stroke { color: Color::INK, width: 1.3, dash: &[4.0, 3.0] };
                    drawing.line(vec![(12.0, y), (30.0, y)], dashed);
                }
                _ => {
                    let place = Rect { left: 12.0, top: y - 5.0, right: 30.0, bottom: y + 5.0 };
                    drawing.area(place.corners(), Some(WRONG.mix(Color::WHITE, 0.72)), None);
                }
            }
            drawing.text(soft(words, (36.0, y)).centred());
        }
    }

    /// The forces of a macro step, each with its name where it ends; one beyond all others is cut and told.
    fn forces(
        &self,
        drawing: &mut Drawing,
        (column, names): (&Column<'_>, &[String]),
        (top, height): (f64, f64),
        y: &dyn Fn(f64) -> f64,
        most: f64,
    ) {
        let place = Rect { left: column.left, top, right: column.left + column.width, bottom: top + height };
        drawing.area(place.corners(), Some(Color(0xF6, 0xF7, 0xF9)), None);
        drawing.line(vec![(place.left, y(0.0)), (place.right, y(0.0))], SOFT);
        let path = |rows: &Rows| rows.rows.iter().map(|row| (column.x(row[0]), y(row[3]))).collect::<Vec<Point>>();
        drawing.line(straight(path(&column.truth)), Stroke::solid(Color::SOFT_INK.mix(Color::WHITE, 0.55), 6.0));
        let mut series = Vec::new();
        let mut ends: Vec<(f64, Vec<&str>, Color)> = Vec::new();
        // In short, as there is little room.
        let short = |name: &String| name.split(',').next().unwrap_or_default().replace(" model", "");
        let names: Vec<String> = names.iter().map(short).collect();
        let named = column.beliefs.iter().zip(&names);
        for (rows, name) in named.clone().chain([(&column.truth, &"what happens".to_owned())]) {
            let points = rows.rows.iter().zip(path(rows));
            let datum = |(row, at): (&[f64; 4], Point)| Datum {
                x: row[0],
                y: row[3],
                range: None,
                note: String::new(),
                at: place.contains(at).then_some(at),
            };
            series.push(SeriesData { name: name.clone(), points: points.map(datum).collect() });
        }
        for (rows, name) in named {
            let color = if column.is_right(rows) { RIGHT } else { WRONG };
            drawing.group(name, |drawing| {
                for piece in polyline(&straight(path(rows)), |_| place) {
                    drawing.line(piece, Stroke::solid(color, 2.0));
                }
            });
            if rows.most(3) > most {
                let words = format!("{name}: {}", force(rows.last()[3]));
                drawing.text(Text::new(words, (place.left + 26.0, top + 13.0), 11.5).colored(color));
                continue;
            }
            let end = y(rows.last()[3]);
            match ends.iter_mut().find(|(other, ..)| (other - end).abs() < 4.0) {
                Some((_, names, _)) => names.push(name),
                None => ends.push((end, vec![name], color)),
            }
        }
        ends.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut below = top;
        for (end, names, color) in ends {
            let first =
                (end - 6.0 * (names.len() - 1) as f64).max(below).min(top + height - 13.0 * names.len() as f64 + 8.0);
            for (line, name) in names.iter().enumerate() {
                let at = (place.right + 7.0, first + 13.0 * line as f64);
                drawing.text(Text::new(*name, at, 11.5).colored(color).centred());
            }
            below = first + 13.0 * names.len() as f64;
        }
        let title = column.panel.title.clone();
        drawing.data.push(PanelData { title, x: "time t (s)".into(), y: "force F (N)".into(), series });
    }
}

/// Words beside.
fn soft(words: &str, at: Point) -> Text {
    Text::new(words, at, 11.5).colored(Color::SOFT_INK)
}

/// Leaves out points that nobody sees.
fn straight(points: Vec<Point>) -> Vec<Point> {
    straightened(points, |at| (*at, false))
}

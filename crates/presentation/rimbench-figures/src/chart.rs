//! What a chart is: panels with axes, series, guides and notes, laid out in a grid under one legend.
//!
//! These types only describe; [`Figure::draw`] turns them into a [`Drawing`](super::drawing::Drawing).

use super::line_style::{LineStyle, Marker};

/// Whether equal distances are equal differences or equal ratios.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios; values ≤ 0 cannot be shown and break the line.
    Log10,
    /// Equal ratios on either side of zero, and linear within ± 10 to this power: where the sign matters.
    SymLog(i32),
}

/// One axis of a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity with its unit.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// The interval shown, at whose ends what lies outside is cut; without one, all finite values of all series and slope
    /// guides.
    pub range: Option<[f64; 2]>,
    /// What its values are called, where these are few: kinds of signs, or columns.
    pub names: Vec<Name>,
}

/// A value of an axis with what it is called.
#[derive(Debug, Clone, PartialEq)]
pub struct Name {
    /// The value.
    pub value: f64,
    /// In few letters.
    pub short: String,
    /// In the legend.
    pub label: String,
}

impl Axis {
    /// A linear axis that shows everything.
    pub fn linear(label: impl Into<String>) -> Self {
        Axis { label: label.into(), scale: Scale::Linear, range: None, names: Vec::new() }
    }

    /// A logarithmic axis that shows everything.
    pub fn log10(label: impl Into<String>) -> Self {
        Axis { scale: Scale::Log10, ..Axis::linear(label) }
    }

    /// An axis for values of either sign over many magnitudes: linear within ± `least`, which becomes a power of ten,
    /// logarithmic beyond.
    pub fn symlog(label: impl Into<String>, least: f64) -> Self {
        let power = least.log10().round().clamp(-300.0, 300.0) as i32;
        Axis { scale: Scale::SymLog(power), ..Axis::linear(label) }
    }

    /// An axis of a few values, each with its name.
    pub fn named(label: impl Into<String>, names: Vec<Name>) -> Self {
        Axis { names, ..Axis::linear(label) }
    }

    /// Shows an interval only, if there is one.
    pub fn within(self, range: Option<[f64; 2]>) -> Self {
        Axis { range, ..self }
    }
}

/// How the points of a series become a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Straight lines from point to point.
    Line,
    /// These, and a sign at every point; of more than 60 points only some get one.
    LineMarkers,
    /// Every value is held until the next point; a sign now and then, so that lines on each other can be told apart.
    Steps,
    /// A row of its own, so that neither lines cross nor colours have to be told apart: the value along the horizontal
    /// axis, a sign for each name of the abscissa, and on the right what was lost of each.
    Row,
    /// A row of its own with a column for each name of the abscissa, and in it what became of the runs.
    Cells,
}

/// What became of the runs of a point.
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

impl Cell {
    /// What is lost of runs that there are.
    pub fn of(loss: Loss) -> Self {
        if loss.failed == 0.0 && loss.silent > 0.0 { Cell::Silent } else { Cell::Failed(loss.failed) }
    }
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// What the legend says; series of one label share an entry, an empty label has none.
    pub label: String,
    /// Points (x, y). NaN breaks the line; y = +∞ is drawn in a band above the axis.
    pub points: Vec<(f64, f64)>,
    /// Colour, dash, width and marker.
    pub style: LineStyle,
    /// Line, markers, both, or steps.
    pub mode: Mode,
    /// What it is called in the data behind the picture, where that is not its label: the row of a scheme without
    /// remarks on it.
    pub name: String,
    /// Thin bars: abscissa, from, to.
    pub bars: Vec<(f64, [f64; 2])>,
    /// What else is known of each point, for tables; none, or as many as points.
    pub notes: Vec<String>,
    /// What is written beside each point where there is room, from both ends inwards; none, or as many as points.
    pub tags: Vec<String>,
    /// Where runs have no value because they did not come to their end: signs in a band above the axis.
    pub lost: Vec<(f64, Loss)>,
    /// What became of the runs of each point of a row.
    pub cells: Vec<Cell>,
    /// Values of single runs of a row, as faint marks.
    pub marks: Vec<f64>,
}

impl Series {
    /// A series drawn as a line.
    pub fn new(label: impl Into<String>, points: Vec<(f64, f64)>, style: LineStyle) -> Self {
        let (name, bars, notes, tags) = Default::default();
        let (lost, cells, marks) = Default::default();
        Series { label: label.into(), points, style, mode: Mode::Line, name, bars, notes, tags, lost, cells, marks }
    }

    /// What it is called in the data behind the picture.
    pub fn data_name(&self) -> &str {
        if self.name.is_empty() { &self.label } else { &self.name }
    }

    /// Draws it another way.
    pub fn mode(mut self, mode: Mode) -> Self {
        self.mode = mode;
        self
    }
}

/// A line that is not data.
#[derive(Debug, Clone, PartialEq)]
pub enum Guide {
    /// A dashed line at a value of y.
    Horizontal(f64),
    /// A dashed line at a value of x, with what stands beside it.
    Vertical(f64, String),
    /// The area from the lower end of the axis up to a value of y, shaded, with a dashed line along its upper edge:
    /// where values say nothing. It does not widen the axis.
    Below(f64),
    /// The triangle under y = y₀ (x/x₀)^order from x₀ to x₁, for two logarithmic axes.
    Slope {
        /// Order, written beside the vertical leg.
        order: f64,
        /// Corner (x₀, y₀) of the hypotenuse.
        from: (f64, f64),
        /// x₁, either side of x₀.
        to_x: f64,
    },
}

/// Shares of the runs at one abscissa that have no value. These two are never one: a run whose end nobody waited for
/// has not failed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Loss {
    /// Of those with an answer, the share that failed.
    pub failed: f64,
    /// Of all, the share that gave no answer.
    pub silent: f64,
}

/// Why there are no runs, which is neither a failure nor none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absent {
    /// None was asked for.
    NotRun,
    /// They were left out for a reason: the scheme cannot be run there.
    LeftOut,
}

impl Absent {
    /// Both.
    pub const ALL: [Self; 2] = [Absent::NotRun, Absent::LeftOut];

    /// Says which it is of runs that are skipped, or not there.
    pub fn of(skipped: usize) -> Self {
        if skipped > 0 { Absent::LeftOut } else { Absent::NotRun }
    }

    /// What stands at its place.
    pub fn sign(self) -> &'static str {
        match self {
            Absent::NotRun => "–",
            Absent::LeftOut => "/",
        }
    }

    /// What is said of it.
    pub fn in_words(self) -> &'static str {
        match self {
            Absent::NotRun => "not run",
            Absent::LeftOut => "left out",
        }
    }
}

/// What is said of runs that failed.
pub const FAILED: &str = "failed";
/// What is said of those that gave no answer.
pub const NO_ANSWER: &str = "no answer";

impl Loss {
    /// What is said of it; nothing if there is none.
    pub fn in_words(&self) -> String {
        let share =
            |share: f64, what: &str| (share > 0.0).then(|| format!("{:.0} % of the runs {what}", 100.0 * share));
        let said = [share(self.failed, FAILED), share(self.silent, "gave no answer")];
        said.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// Its sign: a cross where all runs failed.
    pub fn sign(&self) -> Marker {
        match self.failed {
            failed if failed >= 1.0 => Marker::Cross,
            failed if failed > 0.0 => Marker::SomeLost,
            _ => Marker::Silent,
        }
    }
}

/// One pair of axes with what is plotted on them.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Heading, for example "(a) actuator force". May be empty.
    pub title: String,
    /// Horizontal and vertical axis; of rows the second one lies below them, and the first has the names of the signs.
    pub axes: [Axis; 2],
    /// Series, the first at the back, or on top of all rows.
    pub layers: Vec<Series>,
    /// Reference lines and slopes.
    pub marks: Vec<Guide>,
    /// Remarks, one line of text each, upwards from the lower left corner.
    pub notes: Vec<String>,
}

impl Plot {
    /// An empty panel.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        let (layers, marks, notes) = Default::default();
        Plot { title: title.into(), axes: [x, y], layers, marks, notes }
    }

    /// Whether its series are rows.
    pub fn has_rows(&self) -> bool {
        self.layers.iter().any(|series| matches!(series.mode, Mode::Row | Mode::Cells))
    }

    /// Whether a series leaves any sign in it: a point inside its axes, as far as these are fixed, or runs that were
    /// lost.
    pub(crate) fn shows(&self, label: &str, name: &str) -> bool {
        let within = |axis: &Axis, value: f64| axis.range.is_none_or(|[low, high]| (low..=high).contains(&value));
        let positive = |axis: &Axis, value: f64| axis.scale != Scale::Log10 || value > 0.0;
        let [across, upwards] = &self.axes;
        let is_seen = |&(x, y): &(f64, f64)| {
            let up = y == f64::INFINITY || (y.is_finite() && positive(upwards, y));
            x.is_finite() && positive(across, x) && within(across, x) && up
        };
        let points = self.layers.iter().filter(|series| series.label == label).flat_map(|series| &series.points);
        let lost = self.layers.iter().any(|series| series.data_name() == name && !series.lost.is_empty());
        // A line that is cut may still cross its frame: only what is all on one side is out of it.
        let seen: Vec<f64> = points.filter(|point| is_seen(point)).map(|point| point.1).collect();
        let Some([low, high]) = upwards.range else { return lost || !seen.is_empty() };
        lost || seen.iter().any(|y| *y >= low) && seen.iter().any(|y| *y <= high || y.is_infinite())
    }

    /// Adds a series in front of those already there.
    pub fn layer(mut self, series: Series) -> Self {
        self.layers.push(series);
        self
    }
}

/// A whole figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Width, px.
    pub width: f64,
    /// Height, px; rows have what they need.
    pub height: f64,
    /// Panels per row.
    pub columns: usize,
    /// Panels, row by row.
    pub panels: Vec<Plot>,
    /// What the picture itself says below its panels.
    pub note: String,
}

impl Figure {
    /// A figure without panels, all in one row unless there are so many per row.
    pub fn new(width: f64, height: f64, columns: Option<usize>) -> Self {
        Figure { width, height, columns: columns.unwrap_or(usize::MAX), panels: Vec::new(), note: String::new() }
    }

    /// Adds a panel.
    pub fn panel(mut self, panel: Plot) -> Self {
        self.panels.push(panel);
        self
    }
}

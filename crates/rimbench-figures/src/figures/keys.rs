//! Every key of `figures.toml`: what it takes, what stands for it where it is absent, and what it means. The list is what the
//! checks go by and what the documentation is made from.

/// One key.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What it takes.
    pub takes: Takes,
    /// What holds without it.
    pub absent: Absent,
    /// What it means.
    pub about: &'static str,
}

/// What a key takes.
#[derive(Debug, Clone, Copy)]
pub enum Takes {
    /// Any text in one line.
    Text,
    /// A name that is safe as that of a file.
    FileName,
    /// An experiment, `group/name`.
    Experiment,
    /// Experiments.
    Experiments,
    /// Labels of scheme rows, which must be there.
    Labels,
    /// One of these.
    Choice(&'static [&'static str]),
    /// A width or height, px.
    Pixels,
    /// A whole number from 1 to 12.
    Columns,
    /// A finite number above zero.
    Positive,
    /// A finite number above one.
    AboveOne,
    /// Finite numbers, at least one.
    Numbers,
    /// `true` or `false`.
    Flag,
    /// An interval `[low, high]`.
    Interval,
    /// An interval of numbers above zero, for a logarithmic axis.
    PositiveInterval,
    /// Left, bottom, width, height as shares of the panel.
    Place,
    /// `[order, [x, y]]`, x and y above zero.
    Slope,
    /// A table with these keys.
    Table(&'static [Key]),
    /// Tables with these keys, at least one.
    Tables(&'static [Key]),
}

/// What holds where a key is absent.
#[derive(Debug, Clone, Copy)]
pub enum Absent {
    /// It must be given.
    Needed,
    /// This, as TOML writes it.
    Default(&'static str),
    /// What another key says.
    Like(&'static str),
    /// This, in words.
    Then(&'static str),
}

impl Takes {
    /// What is valid, in words.
    pub fn words(self) -> String {
        match self {
            Takes::Text => "text in one line".to_owned(),
            Takes::FileName => {
                format!("a file name of letters, digits, `-`, `_` and `.`, not first, at most {LONGEST_NAME} long")
            }
            Takes::Experiment => "an experiment, \"group/name\"".to_owned(),
            Takes::Experiments => "a list of experiments, [\"group/name\", …]".to_owned(),
            Takes::Labels => "a list of labels of scheme rows".to_owned(),
            Takes::Choice(names) => names.join(" | "),
            Takes::Pixels => format!("a number of px from {} to {}", PIXELS[0], PIXELS[1]),
            Takes::Columns => "a whole number from 1 to 12".to_owned(),
            Takes::Positive => "a finite number above 0".to_owned(),
            Takes::AboveOne => "a finite number above 1".to_owned(),
            Takes::Numbers => "a list of finite numbers, at least one".to_owned(),
            Takes::Flag => "true | false".to_owned(),
            Takes::Interval => "[low, high], finite, low < high".to_owned(),
            Takes::PositiveInterval => "[low, high], finite, 0 < low < high".to_owned(),
            Takes::Place => "[left, bottom, width, height], shares of the panel, within it".to_owned(),
            Takes::Slope => "[order, [x, y]], finite, x and y above 0".to_owned(),
            Takes::Table(keys) => {
                format!("a table of {}", keys.iter().map(|key| key.name).collect::<Vec<_>>().join(", "))
            }
            Takes::Tables(_) => "[[figure.panels]], at least one".to_owned(),
        }
    }
}

impl Absent {
    /// What holds, in words.
    pub fn words(self) -> String {
        match self {
            Absent::Needed => "needed".to_owned(),
            Absent::Default(value) => value.to_owned(),
            Absent::Like(key) => format!("as `{key}`"),
            Absent::Then(words) => words.to_owned(),
        }
    }
}

/// Least and largest width and height, px.
pub const PIXELS: [f64; 2] = [240.0, 4000.0];
/// Longest name of a file.
pub const LONGEST_NAME: usize = 80;

const fn key(name: &'static str, takes: Takes, absent: Absent, about: &'static str) -> Key {
    Key { name, takes, absent, about }
}

use Absent::{Default, Like, Needed, Then};

const AUTOMATIC: Absent = Then("all that is shown");
const ALL_LABELS: Absent = Then("all there are");
const PARTS: &[&str] = &["signed", "absolute", "positive", "negative"];

/// Kinds of figures.
pub const KINDS: [&str; 9] = [
    "manoeuvre",
    "traces",
    "dots",
    "sweep",
    "phases",
    "stability-map",
    "work-precision",
    "parameter-sweep",
    "performance-profile",
];

/// Keys of every figure.
pub const COMMON: &[Key] = &[
    key("id", Takes::FileName, Needed, "name of the files and anchor in the report; no two figures share one"),
    key("kind", Takes::Choice(&KINDS), Needed, "what kind of figure it is"),
    key("experiment", Takes::Experiment, Needed, "whose results it reads, and beside which it is written"),
    key("source", Takes::Text, Default("\"runs.csv\""), "the files it reads, for the reader"),
    key("caption", Takes::Text, Default("\"\""), "what the reader sees"),
    key("width", Takes::Pixels, Default("680"), "width, px; 680 px are 180 mm on paper, two columns"),
];

const HEIGHT: Key = key("height", Takes::Pixels, Default("330"), "height, px");
const NOTE: Key = key("note", Takes::Text, Then("none"), "what the picture itself says below its panels");
const TITLE: Key = key("title", Takes::Text, Default("\"\""), "heading");
const LABELS: Key = key("labels", Takes::Labels, ALL_LABELS, "scheme rows shown");
const ONLY: Key = key("only", Takes::Table(ONLY_KEYS), ONE_PROBLEM, "the part of the results shown");
const PART: Key = key(
    "part",
    Takes::Choice(PARTS),
    Default("\"signed\""),
    "which values of a signed metric; the label should say so",
);
const METRIC: Key = key("metric", Takes::Text, Needed, "a column of runs.csv, or `fraction_stable`");
const METRIC_LABEL: Key = key("label", Takes::Text, Like("metric"), "heading of the vertical axis");
const RANGE: Key = key("range", Takes::PositiveInterval, AUTOMATIC, "vertical axis, logarithmic");

/// Several cases, or several sets of parameters, are not drawn as one unless that is said.
const ONE_PROBLEM: Absent = Then("the only one there is");

const ONLY_KEYS: &[Key] = &[
    key("case", Takes::Text, ONE_PROBLEM, "one case; \"all\" pools several"),
    key(
        "set",
        Takes::Text,
        ONE_PROBLEM,
        "its parameters as in the column `set` of runs.csv; \"\" where none is set; \"all\" pools several",
    ),
];

const BAND: Key =
    key("band", Takes::Table(BAND_KEYS), Then("none"), "an area from the least to the largest of some scheme rows");

const BAND_KEYS: &[Key] = &[
    key("labels", Takes::Labels, Needed, "scheme rows; those lost at a point are left out there"),
    key("label", Takes::Text, Needed, "what the legend says"),
];

const WITHOUT_EXACT: Key = key(
    "without_exact",
    Takes::Flag,
    Default("false"),
    "leave out cases in which the model of some run is the mechanics itself (`model_exact`)",
);

/// What the columns of a stability map are.
const ACROSS: &[&str] = &["macro-step", "case"];

/// What the bars at a median show.
const BARS: &[&str] = &["range", "bootstrap"];

/// Kinds of figures, each with its keys besides those that all have.
const KEYS: [(&str, &[Key]); KINDS.len()] = [
    (
        "manoeuvre",
        &[
            key("schemes", Takes::Labels, Needed, "scheme rows, one row of drawings each"),
            key("instants_s", Takes::Numbers, Needed, "instants, s; the communication point nearest to each is drawn"),
            key("arrow_force_n", Takes::Positive, Default("2000"), "contact force of the arrow in the legend, N"),
            key(
                "animated_s",
                Takes::Interval,
                Then("stills only"),
                "part of the run, s, that is shown in motion as well: two images that loop, for light and for dark pages, `<id>-moving-light.svg` and `<id>-moving-dark.svg`",
            ),
            key("slow_s", Takes::Interval, Like("animated_s"), "the part of it that plays slowly, s"),
        ],
    ),
    (
        "traces",
        &[
            HEIGHT,
            key("series", Takes::Labels, Needed, "scheme rows, or `reference`; the first at the back"),
            BAND,
            key("panels", Takes::Tables(TRACE_PANEL), Needed, "panels, from the left"),
        ],
    ),
    (
        "dots",
        &[
            COLUMNS,
            LABELS,
            key("macro_steps_ms", Takes::Numbers, AUTOMATIC, "macro steps shown, ms; at most nine"),
            NOTE,
            key("panels", Takes::Tables(DOTS_PANEL), Needed, "panels, from the left"),
        ],
    ),
    ("sweep", &[HEIGHT, COLUMNS, NOTE, key("panels", Takes::Tables(SWEEP_PANEL), Needed, "panels, from the left")]),
    ("phases", &[HEIGHT, ONLY, key("panels", Takes::Tables(PHASE_PANEL), Needed, "panels, from the left")]),
    (
        "stability-map",
        &[
            HEIGHT,
            TITLE,
            key(
                "metric",
                Takes::Text,
                Default("\"force_error_rms_of_peak\""),
                "what says whether a stable run is right",
            ),
            key("wrong_above", Takes::Positive, Default("0.1"), "a cell whose median metric is above this is hatched"),
            key("hatch_label", Takes::Text, Default("\"stable, but wrong\""), "what hatching means, in words"),
            key(
                "across",
                Takes::Choice(ACROSS),
                Default("\"macro-step\""),
                "columns: macro steps, or cases, each with its own macro steps, of which a cell has the largest up to which all runs completed",
            ),
            ONLY,
            LABELS,
        ],
    ),
    (
        "work-precision",
        &[
            HEIGHT,
            key("metric", Takes::Text, Needed, "the error, a column of runs.csv"),
            METRIC_LABEL,
            RANGE,
            LABELS,
            COLUMNS,
            key("panels", Takes::Tables(WORK_PANEL), Needed, "panels, from the left"),
        ],
    ),
    (
        "parameter-sweep",
        &[
            HEIGHT,
            key("parameter", Takes::Text, Needed, "the parameter across, by name"),
            key("x_label", Takes::Text, Like("parameter"), "heading of the horizontal axis"),
            key("panels", Takes::Tables(PARAMETER_PANEL), Needed, "panels, from the left"),
        ],
    ),
    (
        "performance-profile",
        &[
            HEIGHT,
            key("also", Takes::Experiments, Default("[]"), "further experiments whose problems count as well"),
            key("labels", Takes::Labels, Then("those in every experiment"), "scheme rows shown"),
            key(
                "at",
                Takes::Numbers,
                Then("the whole profiles as lines"),
                "ratios, or budgets, at which the share is shown: a row per scheme, ranked, in place of lines",
            ),
            key("panels", Takes::Tables(PROFILE_PANEL), Needed, "panels, from the left"),
        ],
    ),
];

/// Keys of one kind of figure besides those that all have.
pub fn keys_of(kind: &str) -> Option<&'static [Key]> {
    KEYS.iter().find(|(name, _)| *name == kind).map(|(_, keys)| *keys)
}

const COLUMNS: Key = key("columns", Takes::Columns, Then("all panels in one row"), "panels per row");

const TRACE_PANEL: &[Key] = &[
    TITLE,
    key("column", Takes::Text, Needed, "a column of the traces"),
    key("label", Takes::Text, Like("column"), "heading of the vertical axis"),
    key("log", Takes::Flag, Default("false"), "logarithmic vertical axis"),
    key("time_s", Takes::Interval, AUTOMATIC, "horizontal axis, s"),
    key("range", Takes::Interval, AUTOMATIC, "vertical axis; above 0 where it is logarithmic"),
    key("steps", Takes::Flag, Default("false"), "held between communication points instead of joined by lines"),
    key("inset", Takes::Table(TRACE_INSET), Then("none"), "a part of the panel magnified inside it"),
];

const TRACE_INSET: &[Key] = &[
    key("time_s", Takes::Interval, Needed, "horizontal axis, s"),
    key("range", Takes::Interval, Needed, "vertical axis"),
    key("place", Takes::Place, Needed, "where it stands"),
];

const DOTS_PANEL: &[Key] = &[TITLE, METRIC, METRIC_LABEL, RANGE, ONLY, WITHOUT_EXACT];

const SWEEP_PANEL: &[Key] = &[
    TITLE,
    METRIC,
    METRIC_LABEL,
    RANGE,
    ONLY,
    PART,
    LABELS,
    BAND,
    WITHOUT_EXACT,
    key(
        "bars",
        Takes::Choice(BARS),
        Default("\"range\""),
        "from least to largest value, or the 95 % interval of the median by the bootstrap over cases (of one case: over runs)",
    ),
    key("macro_steps_ms", Takes::PositiveInterval, AUTOMATIC, "horizontal axis, ms; nothing beyond is drawn"),
    key(
        "symlog",
        Takes::PositiveInterval,
        Then("a logarithmic axis"),
        "vertical axis for values of both signs: linear within ± the first, logarithmic beyond, up to ± the second",
    ),
    key(
        "floor",
        Takes::Text,
        Then("that of the metric, where it has one"),
        "column with the uncertainty of the reference; the region below it is shaded",
    ),
    key("slope", Takes::Slope, Then("none"), "slope triangle: order and first corner (H in ms, value)"),
    key(
        "orders_over_ms",
        Takes::Interval,
        Then("all"),
        "interval of H, ms, over which orders in the legend are fitted",
    ),
];

const PHASE_PANEL: &[Key] = &[TITLE, key("metric", Takes::Text, Needed, "a column of runs.csv"), METRIC_LABEL, RANGE];

const WORK_PANEL: &[Key] = &[
    TITLE,
    key("cost", Takes::Text, Needed, "a column of cost.csv, or counters of runs.csv joined by `+`"),
    key("label", Takes::Text, Like("cost"), "heading of the horizontal axis"),
    key("range", Takes::PositiveInterval, AUTOMATIC, "horizontal axis, logarithmic"),
    ONLY,
];

const PARAMETER_PANEL: &[Key] = &[
    TITLE,
    METRIC,
    METRIC_LABEL,
    key("range", Takes::Interval, AUTOMATIC, "vertical axis; logarithmic, so above 0, but for `fraction_stable`"),
    ONLY,
    PART,
    LABELS,
    key("macro_step_s", Takes::Positive, Then("the only one there is"), "macro step of the runs shown, s"),
];

const PROFILE_PANEL: &[Key] = &[
    TITLE,
    key("label", Takes::Text, Default("\"ratio to the best\""), "heading of the horizontal axis"),
    key("most", Takes::AboveOne, Default("100"), "largest ratio shown; with `budget` the largest budget"),
    key(
        "budget",
        Takes::Positive,
        Then("a performance profile"),
        "least budget shown: makes it a data profile, the share solved within a cost per simulated second",
    ),
    WITHOUT_EXACT,
    key(
        "cost",
        Takes::Text,
        Then("the largest stable macro step"),
        "cost of the cheapest run that is good enough: as above",
    ),
    key("metric", Takes::Text, Then("none"), "what must be small enough, a column of runs.csv"),
    key("tolerance", Takes::Positive, Then("any"), "how small"),
];

/// A key with the place it belongs to: `every figure`, a kind, or a kind and the table in it.
pub fn all_keys() -> Vec<(String, &'static Key)> {
    let mut all = Vec::new();
    list("every figure", COMMON, &mut all);
    for kind in KINDS {
        list(kind, keys_of(kind).unwrap_or_default(), &mut all);
    }
    all
}

fn list(place: &str, keys: &'static [Key], all: &mut Vec<(String, &'static Key)>) {
    for key in keys {
        all.push((place.to_owned(), key));
        if let Takes::Table(inner) | Takes::Tables(inner) = key.takes {
            list(&format!("{place}: {}", key.name), inner, all);
        }
    }
}

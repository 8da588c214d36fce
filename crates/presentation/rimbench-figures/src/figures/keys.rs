//! Every key of `figures.toml`, declared once: a field of a struct, with what it takes, what holds where it is absent, and what it
//! means. The checks go by it, and the documentation is made from it.

use super::{FIGURES, NAMES};
pub use Absent::{Like, Needed, Then, Usual};

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
    Usual(&'static str),
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
            Takes::Numbers => "a list of finite numbers, at least one".to_owned(),
            Takes::Flag => "true | false".to_owned(),
            Takes::Interval => "[low, high], finite, low < high".to_owned(),
            Takes::PositiveInterval => "[low, high], finite, 0 < low < high".to_owned(),
            Takes::Place => "[left, bottom, width, height], shares of the panel, within it".to_owned(),
            Takes::Slope => "[order, [x, y]], finite, x and y above 0".to_owned(),
            Takes::Table(keys) => {
                format!("a table of {}", keys.iter().map(|key| key.name).collect::<Vec<_>>().join(", "))
            }
            Takes::Tables(keys) => {
                format!("tables of {}, at least one", keys.iter().map(|key| key.name).collect::<Vec<_>>().join(", "))
            }
        }
    }
}

impl Absent {
    /// What holds, in words.
    pub fn words(self) -> String {
        match self {
            Absent::Needed => "needed".to_owned(),
            Absent::Usual(value) => value.to_owned(),
            Absent::Like(key) => format!("as `{key}`"),
            Absent::Then(words) => words.to_owned(),
        }
    }
}

/// Least and largest width and height, px.
pub const PIXELS: [f64; 2] = [240.0, 4000.0];
/// Longest name of a file.
pub const LONGEST_NAME: usize = 80;

/// Declares the keys of a table as a struct that is read from it, with the list of its [`Key`]s.
macro_rules! keys {
    ($(#[$doc:meta])* $vis:vis struct $name:ident { $($field_vis:vis $field:ident: $type:ty = $key:expr),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Default, serde::Deserialize)]
        $vis struct $name {
            $(#[serde(default)] $field_vis $field: $type,)*
        }

        impl $name {
            /// The keys.
            pub const KEYS: &'static [Key] = &[$(Key { name: stringify!($field), ..$key }),*];
        }
    };
}
pub(super) use keys;

/// A key that gets its name from its field.
pub const fn key(takes: Takes, absent: Absent, about: &'static str) -> Key {
    Key { name: "", takes, absent, about }
}

/// The panels of a figure.
pub const fn panels(keys: &'static [Key]) -> Key {
    key(
        Takes::Tables(keys),
        Needed,
        "panels, from the left; a key of theirs may stand in the figure instead, for all that do not say otherwise",
    )
}

/// What holds for an interval that is not given.
pub const AUTOMATIC: Absent = Then("all that is shown");
/// Several cases, or several sets of parameters, are not drawn as one unless that is said.
pub const ONE_PROBLEM: Absent = Then("the only one there is");

/// Key of every figure.
pub const WIDTH: Key = key(Takes::Pixels, Usual("680"), "width, px; 680 px are 180 mm on paper, two columns");
/// Key of figures and panels.
pub const TITLE: Key = key(Takes::Text, Usual("\"\""), "heading");
/// Key of figures.
pub const HEIGHT: Key = key(Takes::Pixels, Usual("330"), "height, px");
/// Key of figures.
pub const NOTE: Key = key(Takes::Text, Then("none"), "what the picture itself says below its panels");
/// Key of figures.
pub const COLUMNS: Key = key(Takes::Columns, Then("all panels in one row"), "panels per row");
/// Key of figures and panels.
pub const LABELS: Key = key(Takes::Labels, Then("all there are"), "scheme rows shown");
/// Key of panels.
pub const METRIC: Key = key(Takes::Text, Needed, "a column of runs.csv, or `fraction_stable`");
/// Key of panels.
pub const METRIC_LABEL: Key = key(Takes::Text, Like("metric"), "heading of the vertical axis");
/// Key of panels.
pub const RANGE: Key = key(Takes::PositiveInterval, AUTOMATIC, "vertical axis, where it is logarithmic");
/// Key of panels.
pub const SYMLOG: Key = key(
    Takes::PositiveInterval,
    Then("a logarithmic axis"),
    "vertical axis for values of both signs: linear within ± the first, logarithmic beyond, up to ± the second",
);
/// Key of panels.
pub const WITHIN: Key = key(
    Takes::Positive,
    Then("the metric itself"),
    "show the share of the runs that complete with at most this much of the metric instead, on a linear axis",
);
/// Key of panels.
pub const WITHOUT_EXACT: Key = key(
    Takes::Flag,
    Usual("false"),
    "leave out cases in which the model of some run is the mechanics itself (`model_exact`)",
);

/// Keys of every figure.
pub const COMMON: &[Key] = &[
    Key {
        name: "id",
        ..key(Takes::FileName, Needed, "name of the files and anchor in the report; no two figures share one")
    },
    Key { name: "kind", ..key(Takes::Choice(&NAMES), Needed, "what kind of figure it is") },
    Key {
        name: "experiment",
        ..key(Takes::Experiment, Needed, "whose results it reads, and beside which it is written")
    },
    Key { name: "source", ..key(Takes::Text, Usual("\"runs.csv\""), "the files it reads, for the reader") },
    Key { name: "title", ..key(Takes::Text, Usual("\"\""), "what is found, above the picture") },
    Key {
        name: "subtitle",
        ..key(Takes::Text, Usual("\"\""), "what is drawn, and under which conditions, below the title")
    },
    Key {
        name: "claims",
        ..key(Takes::Labels, Usual("[]"), "claims of its experiments that the title says in words, by their ids")
    },
    Key { name: "caption", ..key(Takes::Text, Usual("\"\""), "how to read it") },
    Key { name: "width", ..WIDTH },
];

/// Keys of one kind of figure besides those that all have.
pub fn keys_of(kind: &str) -> Option<Vec<&'static Key>> {
    let keys = FIGURES[NAMES.iter().position(|name| *name == kind)?];
    Some(keys.iter().filter(|key| COMMON.iter().all(|common| common.name != key.name)).collect())
}

/// A key with the place it belongs to: `every figure`, a kind, or a kind and the table in it.
pub fn all_keys() -> Vec<(String, &'static Key)> {
    let mut all = Vec::new();
    list("every figure", &COMMON.iter().collect::<Vec<_>>(), &mut all);
    for kind in NAMES {
        list(kind, &keys_of(kind).unwrap_or_default(), &mut all);
    }
    all
}

fn list(place: &str, keys: &[&'static Key], all: &mut Vec<(String, &'static Key)>) {
    for key in keys {
        all.push((place.to_owned(), key));
        if let Takes::Table(inner) | Takes::Tables(inner) = key.takes {
            list(&format!("{place}: {}", key.name), &inner.iter().collect::<Vec<_>>(), all);
        }
    }
}

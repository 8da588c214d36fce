//! One fact about a run.

use super::given::Given;
use std::fmt;

/// What a fact says.
#[derive(Debug, Clone, PartialEq)]
pub enum FactValue {
    /// A name or a sentence; empty where there is nothing to say.
    Text(String),
    /// A number; infinite or not a number where it is so.
    Number(f64),
    /// A count.
    Count(u64),
    /// Whether something is so.
    Truth(bool),
}

impl From<Given> for FactValue {
    fn from(given: Given) -> Self {
        match given {
            Given::Text(text) => FactValue::Text(text),
            Given::Number(number) => FactValue::Number(number),
        }
    }
}

impl fmt::Display for FactValue {
    /// Writes numbers as the shortest text that reads back to the same bits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FactValue::Text(text) => f.write_str(text),
            FactValue::Number(number) => write!(f, "{number:?}"),
            FactValue::Count(count) => count.fmt(f),
            FactValue::Truth(truth) => truth.fmt(f),
        }
    }
}

/// One fact about a run: its name in data, with the unit, and what it says; nothing where it does not apply.
#[derive(Debug, Clone, PartialEq)]
pub struct Fact {
    /// Name of the column.
    pub name: &'static str,
    /// What it says.
    pub value: Option<FactValue>,
    /// Whether a run without it has the id, and a table of such runs the columns, that it had before there was such an
    /// option.
    pub of_some_runs: bool,
}

impl Fact {
    /// States what applies to some runs only.
    pub fn new(name: &'static str, value: Option<FactValue>) -> Self {
        Fact { name, value, of_some_runs: false }
    }

    /// Makes it one of some runs: those without it stay as they were.
    pub(super) fn of_some_runs(self) -> Self {
        Fact { of_some_runs: true, ..self }
    }

    /// States a name or a sentence.
    pub fn text(name: &'static str, text: impl Into<String>) -> Self {
        Fact::new(name, Some(FactValue::Text(text.into())))
    }

    /// States a number, if it applies.
    pub fn number(name: &'static str, number: impl Into<Option<f64>>) -> Self {
        Fact::new(name, number.into().map(FactValue::Number))
    }

    /// States a count.
    pub fn count(name: &'static str, count: u64) -> Self {
        Fact::new(name, Some(FactValue::Count(count)))
    }

    /// Writes it as a cell of a table; empty where it does not apply.
    pub fn cell(&self) -> String {
        self.value.as_ref().map(FactValue::to_string).unwrap_or_default()
    }
}

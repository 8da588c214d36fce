//! What keys of `figures.toml` take beyond their type, and where in a figure a fault is.

use rimbench_core::error::{Error, shortened};
use rimbench_runs::Finding;
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer};
use serde_path_to_error::{Path, Segment};
use toml::{Table, Value};

/// Least and largest width and height, px.
pub const PIXELS: [f64; 2] = [240.0, 4000.0];
/// Longest name of a file.
pub const LONGEST_NAME: usize = 80;

/// Reads a table as a struct.
///
/// # Errors
/// The key, and what is wrong with it.
pub fn read<T: DeserializeOwned>(table: Table) -> Result<T, String> {
    serde_path_to_error::deserialize(Value::Table(table)).map_err(|error| said(&error))
}

/// What is wrong, with the key that it is of.
pub fn said(error: &serde_path_to_error::Error<toml::de::Error>) -> String {
    let (place, message) = (place(error.path()), error.inner().message());
    match (place.is_empty(), message.starts_with("= ")) {
        (true, _) => message.to_owned(),
        (false, true) => format!("{place} {message}"),
        (false, false) => format!("{place}: {message}"),
    }
}

/// A place in a table as a reader counts: `panels 1: range`.
fn place(path: &Path) -> String {
    let mut place = String::new();
    for segment in path {
        match segment {
            Segment::Seq { index } => place += &format!(" {}", index + 1),
            Segment::Map { key } if place.is_empty() => place += key,
            Segment::Map { key } => place += &format!(": {key}"),
            Segment::Enum { .. } | Segment::Unknown => {}
        }
    }
    place
}

/// The names of the fields of a struct, as serde knows them.
pub fn fields<T: DeserializeOwned>() -> &'static [&'static str] {
    struct Fields<'a>(&'a mut &'static [&'static str]);
    impl<'de> Deserializer<'de> for Fields<'_> {
        type Error = serde::de::value::Error;

        fn deserialize_any<V: serde::de::Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
            Err(Self::Error::custom("only fields are asked for"))
        }

        fn deserialize_struct<V: serde::de::Visitor<'de>>(
            self,
            _: &'static str,
            fields: &'static [&'static str],
            visitor: V,
        ) -> Result<V::Value, Self::Error> {
            *self.0 = fields;
            self.deserialize_any(visitor)
        }

        serde::forward_to_deserialize_any! {
            bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct
            seq tuple tuple_struct map enum identifier ignored_any
        }
    }
    let mut names: &[&str] = &[];
    T::deserialize(Fields(&mut names)).err();
    names
}

/// Finds a text of more than one line, or with characters that an SVG cannot hold.
pub fn unwritable(value: &Value) -> Option<&str> {
    match value {
        Value::String(text) => Some(text.as_str()).filter(|text| text.contains(char::is_control)),
        Value::Array(values) => values.iter().find_map(unwritable),
        Value::Table(table) => table.values().find_map(unwritable),
        _ => None,
    }
}

/// Reads a value that `accept` must take; `valid` says what it takes.
fn accepted<'de, D: Deserializer<'de>, T, U: From<T>>(
    from: D,
    valid: &str,
    accept: impl Fn(&Value) -> Option<T>,
) -> Result<U, D::Error> {
    let value = Value::deserialize(from)?;
    let wrong = || D::Error::custom(format!("= {} is not valid; valid: {valid}", shortened(&written(&value))));
    accept(&value).map(U::from).ok_or_else(wrong)
}

/// Declares functions that read what some keys take: a value, or one that may be left out.
macro_rules! takes {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $valid:expr, $accept:expr;)*) => {
        $($(#[$doc])* pub fn $name<'de, D: Deserializer<'de>, U: From<$type>>(from: D) -> Result<U, D::Error> {
            accepted(from, &$valid, $accept)
        })*
    };
}

takes! {
    /// A width or height.
    pixels: f64 = format!("a number of px from {} to {}", PIXELS[0], PIXELS[1]),
        |value| number(value).filter(|px| (PIXELS[0]..=PIXELS[1]).contains(px));
    /// Panels in a row.
    columns: usize = "a whole number from 1 to 12",
        |value| value.as_integer().filter(|count| (1..=12).contains(count)).map(|count| count as usize);
    /// Significant digits.
    digits: usize = "a whole number from 1 to 8",
        |value| value.as_integer().filter(|count| (1..=8).contains(count)).map(|count| count as usize);
    /// A text, or a number as text, of a condition.
    condition: String = "a text, a number, or { not = […], among = […], below = … }", text_of;
    /// Texts or numbers as texts.
    texts: Vec<String> = "a list of texts or numbers", |value| value.as_array()?.iter().map(text_of).collect();
    /// A number above zero.
    positive: f64 = "a finite number above 0", |value| number(value).filter(|number| *number > 0.0);
    /// Numbers, at least one.
    some_numbers: Vec<f64> = "a list of finite numbers, at least one", |value| numbers(value).filter(|it| !it.is_empty());
    /// An interval.
    interval: [f64; 2] = "[low, high], finite, low < high", |value| ends(value).filter(|[low, high]| low < high);
    /// An interval of a logarithmic axis.
    positive_interval: [f64; 2] = "[low, high], finite, 0 < low < high",
        |value| ends(value).filter(|[low, high]| 0.0 < *low && low < high);
    /// A slope triangle.
    slope: (f64, [f64; 2]) = "[order, [x, y]], finite, x and y above 0", |value| match &value.as_array()?[..] {
        [order, at] => Some((number(order)?, ends(at).filter(|at| at.iter().all(|at| *at > 0.0))?)),
        _ => None,
    };
    /// A name that is safe as that of a file, and nothing else.
    file_name: String = format!("a file name of letters, digits, `-`, `_` and `.`, not first, at most {LONGEST_NAME} long"),
        |value| value.as_str().filter(|text| is_file_name(text)).map(str::to_owned);
    /// An experiment.
    experiment: String = "an experiment, \"group/name\", both names of folders",
        |value| value.as_str().filter(|text| is_experiment(text)).map(str::to_owned);
}

/// The name of the share of the runs that completed.
const FRACTION_STABLE: &str = "fraction_stable";

/// Reads what a figure shows of runs: a number of each, or the share that completed.
pub fn metric<'de, D: Deserializer<'de>>(from: D) -> Result<Finding, D::Error> {
    match &*String::deserialize(from)? {
        FRACTION_STABLE => Ok(Finding::Completed),
        name => Finding::named(name).map_err(D::Error::custom),
    }
}

/// Names what a figure shows as its file does.
pub fn metric_name(metric: Finding) -> String {
    if metric == Finding::Completed { FRACTION_STABLE } else { metric.name() }.to_owned()
}

/// Reads panels: at least one.
pub fn panels<'de, D: Deserializer<'de>, P: Deserialize<'de>>(from: D) -> Result<Vec<P>, D::Error> {
    let panels = Vec::deserialize(from)?;
    if panels.is_empty() { Err(D::Error::custom("= [] is not valid; valid: tables, at least one")) } else { Ok(panels) }
}

/// Refuses a key that goes with something else only.
///
/// # Errors
/// The keys that stand there, and what they need.
pub fn refuse(keys: &[(&str, bool)], needs: &str) -> Result<(), String> {
    let there = keys.iter().find(|(_, there)| *there);
    there.map_or(Ok(()), |(key, _)| Err(format!("panels: `{key}` {needs}")))
}

/// Names a key that is not known, with those that are.
pub fn unknown_key<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> String {
    Error::unknown("key", name, known).to_string()
}

/// A value as a file has it, tables aside.
fn written(value: &Value) -> String {
    match value {
        Value::String(text) => format!("\"{text}\""),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => format!("{number:?}"),
        Value::Boolean(flag) => flag.to_string(),
        Value::Datetime(time) => time.to_string(),
        Value::Array(values) => format!("[{}]", values.iter().map(written).collect::<Vec<_>>().join(", ")),
        Value::Table(_) => "a table".to_owned(),
    }
}

/// Width of a figure, px: 180 mm on paper, two columns.
pub fn width() -> f64 {
    680.0
}

/// Height of a figure, px.
pub fn height() -> f64 {
    330.0
}

/// A finite number, whole or not.
fn number(value: &Value) -> Option<f64> {
    let number = value.as_float().or_else(|| value.as_integer().map(|number| number as f64))?;
    number.is_finite().then_some(number)
}

/// A text, or a number as Rust writes it.
fn text_of(value: &Value) -> Option<String> {
    value.as_str().map(str::to_owned).or_else(|| number(value).map(|number| number.to_string()))
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(number).collect()
}

fn ends(value: &Value) -> Option<[f64; 2]> {
    numbers(value)?.try_into().ok()
}

/// Whether a name is safe as that of a file.
pub fn is_file_name(text: &str) -> bool {
    let safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    (1..=LONGEST_NAME).contains(&text.len()) && text.chars().all(safe) && !text.starts_with('.')
}

/// Whatever a folder of results may be called.
fn is_experiment(text: &str) -> bool {
    let is_name = |name: &str| !name.trim_matches('.').is_empty() && !name.contains(['/', '\\']);
    !text.contains(char::is_control)
        && text.split_once('/').is_some_and(|(group, name)| is_name(group) && is_name(name))
}

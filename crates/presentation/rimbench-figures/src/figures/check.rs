//! Checks a figure of `figures.toml` key by key, says all that is wrong with it at once, and fills in what may be left out.

use super::keys::{Absent, COMMON, Key, LONGEST_NAME, PIXELS, Takes, keys_of};
use super::xy_figure::{OF_PARAMETERS, OF_STEPS};
use rimbench_core::error::Error;
use toml::{Table, Value};

/// Returns all that is wrong with a figure; what may be left out stands in it afterwards.
pub fn check(figure: &mut Table) -> Vec<String> {
    let mut faults = Vec::new();
    let kind = figure.get("kind").and_then(Value::as_str).unwrap_or_default().to_owned();
    // Of a figure whose kind nobody knows only the keys that all have can be judged.
    let own = keys_of(&kind);
    let is_known = own.is_some();
    let keys: Vec<&Key> = COMMON.iter().chain(own.unwrap_or_default()).collect();
    hand_down(figure, &keys);
    check_table(figure, &keys, "", is_known, &mut faults);
    for panel in figure.get("panels").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_table) {
        let logarithmic = kind == "traces" && panel.get("log").and_then(Value::as_bool) == Some(true);
        if let Some(range) = panel.get("range").filter(|range| logarithmic && !fits(Takes::PositiveInterval, range)) {
            faults.push(wrong("panels: range", range, Takes::PositiveInterval));
        }
        let across = panel.get("x").and_then(Value::as_table);
        let has = |name: &str| across.is_some_and(|across| across.contains_key(name));
        if has("parameter") && has("cost") {
            faults.push("panels: x: a parameter or a cost is across, not both".to_owned());
        }
        let steps_only = OF_STEPS.iter().filter(|_| has("parameter") || has("cost"));
        for key in steps_only.filter(|key| panel.contains_key(**key)) {
            faults.push(format!("panels: `{key}` needs the macro step across"));
        }
        for key in ["symlog", "within"].iter().filter(|key| has("cost") && panel.contains_key(**key)) {
            faults.push(format!("panels: `{key}` does not go with a cost across"));
        }
        for key in OF_PARAMETERS.iter().filter(|key| panel.contains_key(**key) && !has("parameter")) {
            faults.push(format!("panels: `{key}` needs a parameter across; otherwise `only` chooses runs"));
        }
    }
    faults
}

/// Moves keys of panels that stand in the figure into every panel that does not say otherwise.
fn hand_down(figure: &mut Table, keys: &[&Key]) {
    let tables = keys.iter().find_map(|key| match key.takes {
        Takes::Tables(inner) => Some(inner),
        _ => None,
    });
    for key in tables.into_iter().flatten().filter(|key| keys.iter().all(|own| own.name != key.name)) {
        let Some(Value::Array(panels)) = figure.get("panels").filter(|_| figure.contains_key(key.name)) else {
            continue;
        };
        let (mut panels, value) = (panels.clone(), figure[key.name].clone());
        for panel in panels.iter_mut().filter_map(Value::as_table_mut) {
            panel.entry(key.name).or_insert_with(|| value.clone());
        }
        figure.insert("panels".to_owned(), Value::Array(panels));
        figure.remove(key.name);
    }
}

/// Labels that a figure asks for, `reference` aside.
pub fn labels(figure: &Table) -> Vec<String> {
    let lists = ["labels", "series", "schemes"].into_iter().filter_map(|key| figure.get(key));
    let panels = figure.get("panels").and_then(Value::as_array).into_iter().flatten();
    let bands = |table: &'_ Table| table.get("band").and_then(|band| band.get("labels")).cloned();
    let of_bands: Vec<Value> = panels.clone().filter_map(Value::as_table).filter_map(bands).collect();
    let of_panels = panels.clone().filter_map(|panel| panel.get("lines"));
    let lines = figure.get("lines").into_iter().chain(of_panels).filter_map(Value::as_array).flatten();
    let of_lines = lines.filter_map(|line| line.get("labels"));
    let lists = lists.chain(panels.filter_map(|panel| panel.get("labels"))).chain(of_lines).chain(&of_bands);
    let texts = lists.filter_map(Value::as_array).flatten().filter_map(Value::as_str);
    texts.filter(|label| *label != "reference").map(str::to_owned).collect()
}

fn check_table(table: &mut Table, keys: &[&Key], place: &str, complete: bool, faults: &mut Vec<String>) {
    for name in table.keys().filter(|name| complete && !keys.iter().any(|key| key.name == *name)) {
        faults.push(format!("{place}{}", Error::unknown("key", name, keys.iter().map(|key| key.name))));
    }
    for key in keys {
        match (table.get_mut(key.name), key.absent) {
            (Some(value), _) => check_value(key, value, place, faults),
            (None, Absent::Needed) => {
                faults.push(format!("{place}key `{}` is missing: {} ({})", key.name, key.about, key.takes.words()));
            }
            (None, Absent::Usual(text)) => {
                table.insert(key.name.to_owned(), parsed(text));
            }
            (None, Absent::Like(other)) => {
                if let Some(value) = table.get(other).cloned() {
                    table.insert(key.name.to_owned(), value);
                }
            }
            (None, Absent::Then(_)) => {}
        }
    }
}

fn check_value(key: &Key, value: &mut Value, place: &str, faults: &mut Vec<String>) {
    let inside = format!("{place}{}: ", key.name);
    let refs = |keys: &'static [Key]| keys.iter().collect::<Vec<_>>();
    match (key.takes, &mut *value) {
        (Takes::Table(keys), Value::Table(table)) => check_table(table, &refs(keys), &inside, true, faults),
        (Takes::Tables(keys), Value::Array(tables)) if !tables.is_empty() && tables.iter().all(Value::is_table) => {
            for (index, table) in tables.iter_mut().filter_map(Value::as_table_mut).enumerate() {
                let inside = format!("{place}{} {}: ", key.name, index + 1);
                check_table(table, &refs(keys), &inside, true, faults);
            }
        }
        (takes, value) if !fits(takes, value) => faults.push(wrong(&format!("{place}{}", key.name), value, takes)),
        _ => {}
    }
}

fn wrong(key: &str, value: &Value, takes: Takes) -> String {
    Error::invalid(key, written(value), takes.words()).to_string()
}

/// Whether a value is what a key takes.
fn fits(takes: Takes, value: &Value) -> bool {
    let text = value.as_str();
    match takes {
        Takes::Text => text.is_some_and(|text| !text.contains(char::is_control)),
        Takes::FileName => text.is_some_and(is_file_name),
        Takes::Experiment => text.is_some_and(is_experiment),
        Takes::Experiments => all(value, |entry| entry.as_str().is_some_and(is_experiment)),
        Takes::Labels => all(value, Value::is_str),
        Takes::Choice(names) => text.is_some_and(|text| names.contains(&text)),
        Takes::Pixels => number(value).is_some_and(|px| (PIXELS[0]..=PIXELS[1]).contains(&px)),
        Takes::Columns => value.as_integer().is_some_and(|count| (1..=12).contains(&count)),
        Takes::Positive => number(value).is_some_and(|number| number > 0.0),
        Takes::Numbers => numbers(value).is_some_and(|numbers| !numbers.is_empty()),
        Takes::Flag => value.is_bool(),
        Takes::Interval => numbers(value).is_some_and(|ends| matches!(ends[..], [low, high] if low < high)),
        Takes::PositiveInterval => {
            numbers(value).is_some_and(|ends| matches!(ends[..], [low, high] if 0.0 < low && low < high))
        }
        Takes::Place => numbers(value).is_some_and(|place| {
            let inside = |from: f64, length: f64| from >= 0.0 && length > 0.0 && from + length <= 1.0;
            matches!(place[..], [left, bottom, width, height] if inside(left, width) && inside(bottom, height))
        }),
        Takes::Slope => value.as_array().is_some_and(|slope| {
            let corner =
                |corner: &Value| numbers(corner).is_some_and(|at| matches!(at[..], [x, y] if x > 0.0 && y > 0.0));
            matches!(&slope[..], [order, at] if number(order).is_some() && corner(at))
        }),
        Takes::Table(_) | Takes::Tables(_) => false,
    }
}

/// A finite number, whole or not.
fn number(value: &Value) -> Option<f64> {
    let number = value.as_float().or_else(|| value.as_integer().map(|number| number as f64))?;
    number.is_finite().then_some(number)
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(number).collect()
}

fn all(value: &Value, is_good: impl Fn(&Value) -> bool) -> bool {
    value.as_array().is_some_and(|values| values.iter().all(is_good))
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

/// Whether a text is safe as the name of a file or folder, and nothing else.
fn is_file_name(text: &str) -> bool {
    let safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    (1..=LONGEST_NAME).contains(&text.len()) && text.chars().all(safe) && !text.starts_with('.')
}

fn is_experiment(text: &str) -> bool {
    text.split_once('/').is_some_and(|(group, name)| is_file_name(group) && is_file_name(name))
}

/// The value of a default, which is written as in a file.
fn parsed(text: &str) -> Value {
    let table: Option<Table> = toml::from_str(&format!("value = {text}")).ok();
    table.and_then(|mut table| table.remove("value")).unwrap_or_else(|| Value::String(text.to_owned()))
}

//! `rimbench list experiment-schema`: what an editor needs to check a file while it is written, from what reads the file and what this
//! program can run.

use rimbench::cases::{Case, Parameter, Range};
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench::harness::{Experiment, claim_metrics};
use rimbench::runs::{RunOption, RunRequest, counter_names};
use serde_json::{Map, Value, json};

/// A text that no option takes, so that what refuses it says what it would take.
const NONSENSE: &str = "?";

/// Options of a run that the grid sets, not a row.
const SET_BY_GRID: [&str; 3] = ["case", "macro_step_s", "phase"];

fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> Value {
    json!({ "enum": names.into_iter().collect::<Vec<_>>() })
}

/// The schema of an experiment file: that of the format, with the cases, schemes, metrics and counters there are.
pub(super) fn experiment(catalogue: &Catalogue) -> Value {
    let mut schema = Experiment::schema();
    let own = &mut schema["properties"];
    own["schemes"]["items"] = scheme_row(catalogue, &own["macro_steps_s"]);
    let of_case = |case: &std::sync::Arc<Case>| {
        let own: Map<String, Value> =
            case.parameters.iter().map(|parameter| (parameter.name.clone().into_owned(), values(parameter))).collect();
        json!({
            "if": { "properties": { "name": { "const": &*case.name } } },
            "then": { "properties": { "set": { "properties": own, "additionalProperties": false } } },
        })
    };
    let names = || catalogue.cases().iter().map(|case| &*case.name);
    let case = &mut own["cases"]["items"];
    case["properties"]["name"] = one_of(names());
    case["allOf"] = catalogue.cases().iter().map(of_case).collect();
    let claim = &mut own["claims"]["items"]["properties"];
    claim["case"]["enum"] = names().chain(["all"]).collect();
    claim["metric"]["enum"] = claim_metrics().collect();
    claim["at_equal"]["enum"] = counter_names().into_iter().collect();
    schema
}

/// One value of a parameter, or a list of them.
fn values(parameter: &Parameter) -> Value {
    let value = match &parameter.range {
        Range::Finite => json!({ "type": "number" }),
        Range::Positive => json!({ "type": "number", "exclusiveMinimum": 0 }),
        Range::NotNegative => json!({ "type": "number", "minimum": 0 }),
        Range::Fraction => json!({ "type": "number", "minimum": 0, "maximum": 1 }),
        Range::Whole(least, most) => {
            json!({ "type": "number", "multipleOf": 1, "minimum": least, "maximum": most })
        }
        Range::OneOf(names) => one_of(names.iter().map(|name| &**name)),
    };
    let about = format!("{} ({}; default {})", parameter.about, parameter.unit, parameter.default);
    json!({ "anyOf": [value, { "type": "array", "items": value }], "description": about })
}

/// One `[[schemes]]`: a label, macro steps of its own, and any option that a run has.
fn scheme_row(catalogue: &Catalogue, macro_steps: &Value) -> Value {
    let mut properties = Map::new();
    properties
        .insert("label".into(), json!({ "type": "string", "description": "Name of the row in tables and figures" }));
    properties.insert("macro_steps_s".into(), macro_steps.clone());
    let tolerances = json!({ "type": "array", "items": { "type": "number", "exclusiveMinimum": 0 } });
    properties.insert("step_tolerances".into(), tolerances);
    for option in RunRequest::OPTIONS.iter().filter(|option| !SET_BY_GRID.contains(&option.key)) {
        let mut value = match option.key {
            "scheme" => one_of(catalogue.schemes().iter().map(|scheme| &*scheme.name)),
            "solver" => one_of(catalogue.solvers().iter().map(|solver| &*solver.name)),
            _ => option_values(option),
        };
        value["description"] = option.about.into();
        properties.insert(option.key.into(), value);
    }
    properties.insert("delivery".into(), delivery(&properties));
    json!({ "type": "object", "required": ["scheme"], "additionalProperties": false, "properties": properties })
}

/// The table `delivery` of a row: how samples and forces arrive, and what is done with late ones.
fn delivery(options: &Map<String, Value>) -> Value {
    let steps = || json!({ "type": "integer", "minimum": 0 });
    let channel = |option: &str| {
        let parts = json!({
            "delay": steps(),
            "jitter": steps(),
            "loss": { "type": "number", "minimum": 0, "exclusiveMaximum": 1 },
            "seed": steps(),
            "missed": { "type": "array", "items": steps() },
            "log": { "type": "string" },
            "deadline_s": { "type": "number", "exclusiveMinimum": 0 },
        });
        let table = json!({ "type": "object", "additionalProperties": false, "properties": parts });
        json!({ "anyOf": [options[option].clone(), table] })
    };
    let [samples, forces] = ["late_samples", "late_forces"].map(|key| options[key].clone());
    let parts = json!({ "up": channel("delivery_up"), "down": channel("delivery_down"), "late_samples": samples, "late_forces": forces });
    json!({ "type": "object", "additionalProperties": false, "properties": parts })
}

/// What an option takes, from the error of its own parser: the names it knows (of those with a number behind a colon the number is left
/// open), a number, or a count with a word beside it.
fn option_values(option: &RunOption) -> Value {
    match RunRequest::default().put(option.key, NONSENSE) {
        Err(Error::UnknownName { valid, .. }) => {
            let alone = |name: &str| RunRequest::default().put(option.key, name).is_ok();
            let (open, closed): (Vec<&String>, Vec<&String>) = valid.iter().partition(|name| name.contains(":<"));
            // Names that are none alone are parts of a list, each with a value.
            let (whole, parts): (Vec<&str>, Vec<&str>) =
                closed.into_iter().map(String::as_str).partition(|name| alone(name));
            let mut choices = vec![one_of(whole)];
            if !parts.is_empty() {
                let part = format!("({}):[^,]+", parts.join("|"));
                choices.push(json!({ "type": "string", "pattern": format!("^{part}(, *{part})*$") }));
            }
            for name in open {
                let name = name.split(":<").next().unwrap_or_default();
                // What has a number may have a usual one.
                let rest = if alone(name) { "(:.+)?" } else { ":.+" };
                choices.push(json!({ "type": "string", "pattern": format!("^{name}{rest}$") }));
            }
            json!({ "anyOf": choices })
        }
        _ if RunRequest::default().put(option.key, "0.5").is_ok() => json!({ "type": "number" }),
        _ => json!({ "anyOf": [{ "type": "integer", "minimum": 1 }, { "type": "string" }] }),
    }
}

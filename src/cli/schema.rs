//! `rimbench list experiment-schema`, `case-schema`: what an editor needs to check a file while it is written, from what this program can run.

use rimbench::cases::{Case, Parameter, Range};
use rimbench::catalogue::Catalogue;
use rimbench::cosim::Outcome;
use rimbench::error::Error;
use rimbench::harness::{STATISTICS, claim_metrics};
use rimbench::runs::{EvaluatedRun, RunOption, RunRequest};
use serde_json::{Map, Value, json};

/// A text that no option takes, so that what refuses it says what it would take.
const NONSENSE: &str = "?";

/// Which JSON Schema the schemas are.
const DRAFT: &str = "https://json-schema.org/draft/2020-12/schema";

/// Options of a run that the grid sets, not a row.
const SET_BY_GRID: [&str; 3] = ["case", "macro_step_s", "phase"];

/// An object that has these keys and no others.
fn object(required: &[&str], properties: Value) -> Value {
    json!({ "type": "object", "required": required, "additionalProperties": false, "properties": properties })
}

fn above_zero(about: &str) -> Value {
    json!({ "type": "number", "exclusiveMinimum": 0, "description": about })
}

fn text(about: &str) -> Value {
    json!({ "type": "string", "description": about })
}

fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> Value {
    json!({ "enum": names.into_iter().collect::<Vec<_>>() })
}

fn list_of(items: Value) -> Value {
    json!({ "type": "array", "items": items })
}

/// The schema of an experiment file, in the dialect of 2020-12.
pub(super) fn experiment(catalogue: &Catalogue) -> Value {
    let definitions = json!({
        "macro_steps": { "anyOf": [
            { "type": "array", "minItems": 1, "items": above_zero("H, s") },
            object(&["from", "to", "per_decade"], json!({
                "from": above_zero("s"), "to": above_zero("s"), "per_decade": { "type": "integer", "minimum": 1, "maximum": 1000 },
            })),
        ], "description": "Macro steps H, s: a list, or evenly spread in logarithms" },
        "phases": { "anyOf": [
            { "type": "integer", "minimum": 1 },
            list_of(json!({ "type": "number", "exclusiveMinimum": 0, "maximum": 1 })),
        ], "description": "So many of the phase ensemble, or the phases themselves" },
    });
    let [macro_steps, phases] = ["macro_steps", "phases"].map(|name| json!({ "$ref": format!("#/$defs/{name}") }));
    let properties = json!({
        "question": text("What the experiment answers, in words"),
        "macro_steps_s": macro_steps,
        "phases": phases,
        "duration_s": above_zero("Simulated time, s"),
        "micro_step_s": above_zero("Longest micro step of the actuator side, s"),
        "trace_every_s": above_zero("Store traces, one row per so many seconds"),
        "traces": list_of(text("A label")),
        "reference_step_s": above_zero("Coarsest of the three steps of the reference, s"),
        "wall_limit_s": above_zero("Wall time after which a run ends with outcome `timeout`, s"),
        "timed": { "type": "boolean", "description": "Whether wall times are compared, so that nothing may run beside a run" },
        "quick": object(&[], json!({ "macro_steps_s": macro_steps, "phases": phases })),
        "cases": { "type": "array", "minItems": 1, "items": case(catalogue, &macro_steps) },
        "schemes": { "type": "array", "minItems": 1, "items": scheme_row(catalogue, &macro_steps) },
        "claims": list_of(claim(catalogue)),
    });
    let Value::Object(mut schema) = object(&["question", "macro_steps_s", "cases", "schemes"], properties) else {
        unreachable!("an object is one")
    };
    schema.insert("$schema".into(), DRAFT.into());
    schema.insert("title".into(), "Experiment of rimbench".into());
    schema.insert("$defs".into(), definitions);
    Value::Object(schema)
}

/// The schema of a file that makes a case of FMUs.
pub(super) fn case_file() -> Value {
    let flag = |about: &str| json!({ "type": "boolean", "description": about });
    let names = |about: &str| list_of(text(about));
    let fmu = json!({
        "fmu": text("The file, relative to this one"),
        "needs": names("A library that is loaded before"),
        "start": { "type": "object", "description": "Values that are set before a run" },
        "observe": names("A variable that becomes a column"),
        "interface_work": text("The variable that counts the work received, an energy"),
        "direct_feedthrough": flag("Whether outputs follow inputs at once"),
        "probe_step_s": above_zero("The longest step by which an FMU without derivatives is probed, s"),
    });
    let side = object(&["fmu"], fmu);
    let end = json!({ "anyOf": [
        text("A variable"),
        object(&["variable", "factor"], json!({ "variable": text("Its name"), "factor": { "type": "number", "not": { "const": 0 } } })),
    ]});
    let ends = object(&["position", "velocity", "force"], json!({ "position": end, "velocity": end, "force": end }));
    let columns = json!({ "type": "array", "minItems": 3, "maxItems": 3, "items": { "type": "string" } });
    let row = object(&["mechanics", "actuator"], json!({ "columns": columns, "mechanics": ends, "actuator": ends }));
    let parameter = object(
        &["default"],
        json!({
            "default": { "type": "number" },
            "unit": text("Its unit"),
            "about": text("What it is"),
            "mechanics": text("The variable of that side that takes it"),
            "actuator": text("The variable of that side that takes it"),
        }),
    );
    let properties = json!({
        "name": { "type": "string", "pattern": "^[a-z][a-z0-9]*(-[a-z0-9]+)*$" },
        "about": text("One line"),
        "duration_s": above_zero("Simulated time, s"),
        "macro_step_s": above_zero("Usual H, s"),
        "micro_step_s": above_zero("Longest step of the actuator, s"),
        "reference_step_s": above_zero("Coarsest of the three steps of the reference, s"),
        "process": one_of(["own", "same"]),
        "answer_within_s": { "type": "number", "minimum": 0.001, "description": "s; after so long without an answer a process is ended" },
        "mechanics": side,
        "actuator": side,
        "interface": { "type": "array", "minItems": 1, "items": row },
        "parameters": { "type": "object", "additionalProperties": parameter },
    });
    let required = ["name", "duration_s", "macro_step_s", "mechanics", "actuator", "interface"];
    let mut schema = object(&required, properties);
    schema["$schema"] = DRAFT.into();
    schema["title"] = "Case of rimbench made of FMUs".into();
    schema
}

/// One `[[cases]]`: what may be set depends on its name.
fn case(catalogue: &Catalogue, macro_steps: &Value) -> Value {
    let Value::Object(mut entry) = object(
        &["name"],
        json!({
            "name": one_of(catalogue.cases().iter().map(|case| &*case.name)),
            "set": { "type": "object", "description": "Parameters; a list makes a grid" },
            "macro_steps_s": macro_steps,
            "duration_s": above_zero("s"),
            "micro_step_s": above_zero("s"),
        }),
    ) else {
        unreachable!("an object is one")
    };
    let of_case = |case: &std::sync::Arc<Case>| {
        let own: Map<String, Value> =
            case.parameters.iter().map(|parameter| (parameter.name.clone().into_owned(), values(parameter))).collect();
        json!({
            "if": { "properties": { "name": { "const": &*case.name } } },
            "then": { "properties": { "set": { "properties": own, "additionalProperties": false } } },
        })
    };
    entry.insert("allOf".into(), catalogue.cases().iter().map(of_case).collect());
    Value::Object(entry)
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
    json!({ "anyOf": [value, list_of(value.clone())], "description": about })
}

/// One `[[schemes]]`: a label, macro steps of its own, and any option that a run has.
fn scheme_row(catalogue: &Catalogue, macro_steps: &Value) -> Value {
    let mut properties = Map::new();
    properties.insert("label".into(), text("Name of the row in tables and figures"));
    properties.insert("macro_steps_s".into(), macro_steps.clone());
    properties
        .insert("step_tolerances".into(), list_of(above_zero("Tolerances of a step control, an axis of the grid")));
    for option in RunRequest::OPTIONS.iter().filter(|option| !SET_BY_GRID.contains(&option.key)) {
        let mut value = match option.key {
            "scheme" => one_of(catalogue.schemes().iter().map(|scheme| &*scheme.name)),
            "solver" => one_of(catalogue.solvers().iter().map(|solver| &*solver.name)),
            _ => option_values(option),
        };
        value["description"] = option.about.into();
        properties.insert(option.key.into(), value);
    }
    object(&["scheme"], Value::Object(properties))
}

/// What an option takes, as whatever reads it says: the names it knows (of those with a number behind a colon the number is left
/// open), a number, or a count with a word beside it.
fn option_values(option: &RunOption) -> Value {
    match RunRequest::default().put(option.key, NONSENSE) {
        Err(Error::UnknownName { valid, .. }) => {
            let (open, closed): (Vec<&String>, Vec<&String>) = valid.iter().partition(|name| name.contains(":<"));
            let mut choices = vec![one_of(closed.into_iter().map(String::as_str))];
            for name in open {
                let name = name.split(":<").next().unwrap_or_default();
                // What has a number may have a usual one.
                let alone = RunRequest::default().put(option.key, name).is_ok();
                choices.push(
                    json!({ "type": "string", "pattern": format!("^{name}{}$", if alone { "(:.+)?" } else { ":.+" }) }),
                );
            }
            json!({ "anyOf": choices })
        }
        _ if RunRequest::default().put(option.key, "0.5").is_ok() => json!({ "type": "number" }),
        _ => json!({ "anyOf": [{ "type": "integer", "minimum": 1 }, { "type": "string" }] }),
    }
}

/// One `[[claims]]`.
fn claim(catalogue: &Catalogue) -> Value {
    let counters = EvaluatedRun::not_evaluated(Outcome::Completed).counters();
    let cases = catalogue.cases().iter().map(|case| &*case.name).chain(["all"]);
    object(
        &["id", "by", "text", "scheme", "metric", "expect", "finding"],
        json!({
            "id": text("Short name"),
            "by": one_of(["paper", "ours"]),
            "text": text("The claim in words"),
            "case": one_of(cases),
            "set": text("Parameters set, as in the column `set` of runs.csv, or `all`"),
            "scheme": text("Label of a scheme row"),
            "at_equal": one_of(counters.iter().map(|counter| counter.name)),
            "relative_to": text("Label of another row: the ratio to it is measured"),
            "macro_step_s": above_zero("H, s; all if absent"),
            "metric": one_of(claim_metrics()),
            "statistic": one_of(STATISTICS),
            "expect": { "type": "string", "pattern": "^\\s*(>=|<=)\\s*[-+0-9.eE]+\\s*$" },
            "finding": one_of(["reproduced", "not-reproduced", "not-measured"]),
            "superseded": text("Why another claim has taken its place"),
        }),
    )
}

//! `rimbench list`: cases, schemes, solvers, metrics, parameters, keys of the list of figures.

use super::json::Object;
use super::project::Project;
use super::screen::{Table, cut_width, paragraph, wrap};
use super::{Format, print, print_json, program, with_files};
use clap::{Args, ValueEnum};
use rimbench::cases::Case;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{MechanicsSteps, Port, Side};
use rimbench::error::Error;
use rimbench::fmi::export::{outputs_at_start, text};
use rimbench::fmi::import::SideNotes;
use rimbench::metrics::{METRICS, Only};
use rimbench::parameter::unit_of;
use rimbench::runs::RunSpec;
use rimbench::shipped::FIGURE_KEYS;
use rimbench::solver_entry::SolverEntry;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Arguments of `list`.
#[derive(Debug, Args)]
#[command(arg_required_else_help = true)]
pub struct List {
    /// What to list
    what: What,
    /// Only this case (for cases and parameters)
    #[arg(long, value_name = "CASE")]
    case: Option<String>,
    /// All that is known of each, not only name and purpose
    #[arg(long, conflicts_with = "format")]
    long: bool,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    Cases,
    Schemes,
    Solvers,
    Metrics,
    Parameters,
    /// Keys of a list of figures, for `report --figures --file`
    FigureKeys,
}

/// One entry: key and value pairs, in the order of the columns.
type Entry = Vec<(&'static str, String)>;

impl List {
    pub(super) fn run(mut self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let catalogue = &*with_files(catalogue, &SideNotes::default(), &mut self.case, &mut None)?;
        let case = self.case.as_deref().map(|name| catalogue.case(name)).transpose()?;
        let entries: Vec<Entry> = match self.what {
            What::Cases if self.format == Format::Json => return print_json(&cases(catalogue, case)?),
            What::Cases => catalogue
                .cases()
                .iter()
                .filter(|known| case.is_none_or(|case| case.name == known.name))
                .map(|case| entry(&case.name, &case.about, [("for", case.purpose.to_string())]))
                .collect(),
            What::Schemes | What::Solvers | What::Metrics if case.is_some() => {
                let message = "--case goes with `list cases` and `list parameters` only";
                return Err(Error::Incompatible(message.to_owned()).into());
            }
            What::Schemes => catalogue
                .schemes()
                .iter()
                .map(|scheme| {
                    let gain = scheme.gain.as_ref().map(|gain| format!("{} ({})", gain.default, gain.about));
                    let more = [
                        ("order", scheme.order.to_string()),
                        ("sequence", scheme.sequence.to_string()),
                        ("gain", gain.unwrap_or_default()),
                        ("real-time", if scheme.real_time() { "yes" } else { "no" }.to_owned()),
                    ];
                    entry(&scheme.name, &scheme.about, more)
                })
                .collect(),
            What::Solvers => catalogue
                .solvers()
                .iter()
                .map(|solver| entry(&solver.name, &solver.about, [("guaranteed", solver.guaranteed.to_string())]))
                .collect(),
            What::Metrics => METRICS
                .iter()
                .map(|metric| {
                    let of = match metric.only {
                        Some(Only::Friction) => "contacts have friction",
                        Some(Only::Split) => "a mechanics has several bonds",
                        Some(Only::Trials) => "steps of the mechanics are tried",
                        Some(Only::Audit) => "the model is audited",
                        Some(Only::Divided) => "the error is divided",
                        Some(Only::Believed) => "a model that is believed is audited",
                        Some(Only::Late) => "samples may be late",
                        Some(Only::Column) => "the case records it",
                        Some(Only::Claimed) => "a claim is about it",
                        None => "",
                    };
                    entry(metric.name, metric.about, [("unit", metric.unit.to_owned()), ("where", of.to_owned())])
                })
                .collect(),
            What::Parameters if case.is_none() && self.format == Format::Table => {
                let message = format!(
                    "`list parameters` needs a case; valid: --case NAME, as `{} list cases` names them",
                    program()
                );
                return Err(Error::Incompatible(message).into());
            }
            What::Parameters => catalogue
                .cases()
                .iter()
                .filter(|known| case.is_none_or(|case| case.name == known.name))
                .flat_map(|case| case.parameters.iter().map(|parameter| (&case.name, parameter)))
                .map(|(case, parameter)| {
                    let more = [
                        ("unit", parameter.unit.to_string()),
                        ("default", parameter.default.to_string()),
                        ("valid", parameter.range.to_string()),
                        ("source", parameter.source.to_string()),
                        ("case", case.to_string()),
                    ];
                    // A short list shows what a parameter is, and of how much.
                    let value = format!("{} {}", parameter.default, parameter.unit);
                    let about = match self.format == Format::Table && !self.long {
                        true => format!("{} · {}", value.trim_end(), parameter.about),
                        false => parameter.about.to_string(),
                    };
                    entry(&parameter.name, &about, more)
                })
                .collect(),
            What::FigureKeys => match self.format {
                Format::Table => return print(&page(FIGURE_KEYS.trim_end())),
                Format::Json => {
                    let message = "`list figure-keys` is a page of the book and has no JSON: leave --format out";
                    return Err(Error::Incompatible(message.to_owned()).into());
                }
            },
        };
        match self.format {
            Format::Json => print_json(&all_as_json(&entries)),
            Format::Table if self.long => print(&entries.iter().map(long).collect::<Vec<_>>().join("\n\n")),
            Format::Table => print(&short(&entries)),
        }
    }
}

/// Name and purpose, a line each where both fit. Of a longer purpose what stands before its first semicolon, colon or
/// bracket, if that is half a line at least; further lines rather than half a sentence.
fn short(entries: &[Entry]) -> String {
    let text = |entry: &Entry, at: usize| entry.get(at).map_or(String::new(), |(_, value)| value.clone());
    let longest = entries.iter().map(|entry| text(entry, 0).chars().count()).max().unwrap_or(0);
    let room = cut_width().saturating_sub(longest + 2).max(20);
    let line = |entry: &Entry| {
        let (name, about) = (text(entry, 0), text(entry, 1));
        let ends = ["; ", ": ", " ("].iter().filter_map(|end| about.find(end));
        let first = ends.min().filter(|end| about.chars().count() > room && *end >= room / 2);
        let lines = wrap(first.map_or(&*about, |end| &about[..end]), room);
        format!("{name:<longest$}  {}", lines.join(&format!("\n{}", " ".repeat(longest + 2))))
    };
    let lines: Vec<String> = entries.iter().map(line).collect();
    format!("{}\n\n{} · --long for the rest", lines.join("\n"), entries.len())
}

/// A page of the book: whole where its reader is a program, else paragraphs and tables as wide as the screen.
fn page(text: &str) -> String {
    if cut_width() == usize::MAX {
        return text.to_owned();
    }
    let cells = |line: &str| -> Vec<String> {
        let line = line.trim_matches('|').replace("\\|", "\n");
        line.split('|').map(|cell| cell.trim().replace('\n', "|")).collect()
    };
    let part = |part: &str| {
        let mut rows = part.lines().filter(|line| line.starts_with('|')).map(cells);
        let Some(head) = rows.next() else { return paragraph(part, 0) };
        let mut table = Table::new(&head.iter().map(String::as_str).collect::<Vec<_>>());
        rows.skip(1).for_each(|row| table.add_row(row));
        table.to_string()
    };
    text.split("\n\n").map(part).collect::<Vec<_>>().join("\n\n")
}

/// An entry with everything that is known of it.
fn long(entry: &Entry) -> String {
    let [(_, name), (_, about), rest @ ..] = &entry[..] else { return String::new() };
    let rest = rest.iter().filter(|(_, value)| !value.is_empty()).map(|(key, value)| format!("{key}: {value}"));
    let lines = [about.clone(), rest.collect::<Vec<_>>().join(" · ")];
    let lines = lines.iter().filter(|line| !line.is_empty()).map(|line| format!("    {}", paragraph(line, 4)));
    format!("{name}\n{}", lines.collect::<Vec<_>>().join("\n"))
}

fn entry<const N: usize>(name: &str, about: &str, more: [(&'static str, String); N]) -> Entry {
    [("name", name.to_owned()), ("about", about.to_owned())].into_iter().chain(more).collect()
}

/// The cases, or one of them, with all that is declared of each: ports with what they say at the start, times, columns of
/// a trace, and where the ranking asks for it the macro steps and phases that it asks for.
fn cases(catalogue: &Catalogue, only: Option<&Arc<Case>>) -> anyhow::Result<Value> {
    let ranking = Project::find().ranking()?;
    let mut ranked: Vec<RunSpec> = Vec::new();
    for file in ranking.experiments() {
        ranked.extend(Project::experiment(&file)?.problems(catalogue)?);
    }
    let mut listed = Vec::new();
    for case in catalogue.cases().iter().filter(|known| only.is_none_or(|only| only.name == known.name)) {
        let mut object = Object::default();
        object.put("name", &*case.name);
        object.put("about", &*case.about);
        object.put("for", case.purpose.to_string());
        object.put("ports", ports(case)?);
        object.number("duration_s", case.defaults.duration_s);
        object.put("grid", grid(case, &ranked));
        let rows = case
            .interface_columns
            .iter()
            .map(|row| json!({"position": &*row.position, "velocity": &*row.velocity, "force": &*row.force}));
        object.put("interface", rows.collect::<Value>());
        let columns = case.trace_columns.iter().map(|name| json!({"name": &**name, "unit": unit_of(name)}));
        object.put("columns", columns.collect::<Value>());
        listed.push(Value::from(object));
    }
    Ok(Value::Array(listed))
}

fn ports(case: &Case) -> anyhow::Result<Value> {
    let mut sides = (case.build)(&case.default_parameters(), &SolverEntry::active_set())?.sides;
    let start = outputs_at_start(case, &mut sides)?;
    let of = |side: Side| {
        let ports = sides[side].ports();
        let said = |ports: &[Port], start: &[f64]| {
            let port = |(port, start): (&Port, &f64)| {
                let mut object = Object::default();
                object.put("name", &*port.name);
                object.put("unit", unit_of(&port.name));
                object.number("start", *start);
                Value::from(object)
            };
            ports.iter().zip(start).map(port).collect::<Value>()
        };
        json!({
            "inputs": said(&ports.inputs, &start[side.other()]),
            "outputs": said(&ports.outputs, &start[side]),
            "direct_feedthrough": ports.direct_feedthrough,
        })
    };
    Ok(json!({"mechanics": of(Side::Mechanics), "actuator": of(Side::Actuator)}))
}

/// Usual steps of a case, and what the ranking asks of it, by sets of parameters.
fn grid(case: &Case, ranked: &[RunSpec]) -> Value {
    // As `--set` takes them.
    let mut sets: BTreeMap<Vec<String>, Vec<&RunSpec>> = BTreeMap::new();
    for spec in ranked.iter().filter(|spec| spec.case.name == case.name) {
        let changed = spec.parameters.iter().filter(|(parameter, value)| parameter.default != **value);
        let set = changed.map(|(parameter, value)| format!("{}={}", parameter.name, text(value)));
        sets.entry(set.collect()).or_default().push(spec);
    }
    let sets = sets.into_iter().map(|(set, specs)| {
        let axis = |of: fn(&RunSpec) -> f64| {
            let mut values: Vec<f64> = Vec::new();
            for value in specs.iter().map(|spec| of(spec)) {
                if !values.contains(&value) {
                    values.push(value);
                }
            }
            values
        };
        json!({
            "set": set,
            "duration_s": specs[0].duration,
            "macro_steps_s": axis(|spec| spec.macro_step),
            "phases": axis(|spec| spec.phase),
            "micro_step_s": specs[0].micro_step,
            "mechanics_steps": specs[0].mechanics_steps.to_string(),
        })
    });
    let (usual, steps) = (&case.defaults, MechanicsSteps::ONE.to_string());
    json!({
        "macro_step_s": usual.macro_step_s,
        "micro_step_s": usual.micro_step_s,
        "mechanics_steps": steps,
        "ranking": sets.collect::<Value>(),
    })
}

/// An array of objects; a default that is a number stands as a number, one that is a choice as a text.
fn all_as_json(entries: &[Entry]) -> Value {
    let object = |entry: &Entry| {
        let mut object = Object::default();
        for (key, value) in entry {
            match value.parse::<f64>() {
                Ok(number) if matches!(*key, "default" | "order") => object.number(*key, number),
                _ => object.put(*key, value.as_str()),
            }
        }
        Value::from(object)
    };
    Value::Array(entries.iter().map(object).collect())
}

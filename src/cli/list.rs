//! `rimbench list`: cases, schemes, solvers, metrics, parameters, keys of the list of figures, schemas of files.

use super::json::Object;
use super::screen::{cut, paragraph, width};
use super::{Format, print, schema};
use clap::{Args, ValueEnum};
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench::figures::{FigureKey, figure_keys};
use rimbench::fmi::import::case_file_schema;
use rimbench::metrics::{METRICS, Only};
use serde_json::Value;

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
    /// JSON Schema of an experiment file, for editors
    ExperimentSchema,
    /// JSON Schema of a case file, for editors
    CaseSchema,
}

/// One entry: key and value pairs, in the order of the columns.
type Entry = Vec<(&'static str, String)>;

impl List {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let case = self.case.as_deref().map(|name| catalogue.case(name)).transpose()?;
        let entries: Vec<Entry> = match self.what {
            What::Cases => catalogue
                .cases()
                .iter()
                .filter(|known| case.is_none_or(|case| case.name == known.name))
                .map(|case| {
                    let mut entry = named(&case.name, &case.about);
                    entry.push(("for", case.purpose.to_string()));
                    entry
                })
                .collect(),
            What::ExperimentSchema => return print_schema(&schema::experiment(catalogue)),
            What::CaseSchema => return print_schema(&case_file_schema()),
            What::Schemes | What::Solvers | What::Metrics if case.is_some() => {
                let message = "--case goes with `list cases` and `list parameters` only";
                return Err(Error::Incompatible(message.to_owned()).into());
            }
            What::Schemes => catalogue
                .schemes()
                .iter()
                .map(|scheme| {
                    let mut entry = named(&scheme.name, &scheme.about);
                    entry.push(("order", scheme.order.to_string()));
                    entry.push(("sequence", scheme.sequence.to_string()));
                    let gain = scheme.gain.as_ref().map(|gain| format!("{} ({})", gain.default, gain.about));
                    entry.push(("gain", gain.unwrap_or_default()));
                    entry.push(("real-time", if scheme.real_time() { "yes" } else { "no" }.to_owned()));
                    entry
                })
                .collect(),
            What::Solvers => catalogue
                .solvers()
                .iter()
                .map(|solver| {
                    let mut entry = named(&solver.name, &solver.about);
                    entry.push(("guaranteed", solver.guaranteed.clone().into_owned()));
                    entry
                })
                .collect(),
            What::Metrics => METRICS
                .iter()
                .map(|metric| {
                    let mut entry = named(metric.name, metric.about);
                    entry.push(("unit", metric.unit.to_owned()));
                    let of = match metric.only {
                        Some(Only::Friction) => "contacts have friction",
                        Some(Only::Split) => "each actuator has a model",
                        Some(Only::Audit) => "the model is audited",
                        Some(Only::Column) => "the case records it",
                        None => "",
                    };
                    entry.push(("where", of.to_owned()));
                    entry
                })
                .collect(),
            What::Parameters => catalogue
                .cases()
                .iter()
                .filter(|known| case.is_none_or(|case| case.name == known.name))
                .flat_map(|case| case.parameters.iter().map(|parameter| (&case.name, parameter)))
                .map(|(case, parameter)| {
                    let mut entry = named(&parameter.name, &parameter.about);
                    entry.push(("unit", parameter.unit.clone().into_owned()));
                    entry.push(("default", parameter.default.to_string()));
                    entry.push(("valid", parameter.range.to_string()));
                    entry.push(("source", parameter.source.clone().into_owned()));
                    entry.push(("case", case.clone().into_owned()));
                    entry
                })
                .collect(),
            What::FigureKeys => figure_keys().into_iter().map(of_figures).collect(),
        };
        match self.format {
            Format::Json => print(&serde_json::to_string_pretty(&json(&entries))?),
            Format::Table if self.long => print(&entries.iter().map(long).collect::<Vec<_>>().join("\n\n")),
            Format::Table => print(&short(&entries)),
        }
    }
}

/// Name and purpose, a line each.
fn short(entries: &[Entry]) -> String {
    let text = |entry: &Entry, at: usize| entry.get(at).map_or(String::new(), |(_, value)| value.clone());
    let longest = entries.iter().map(|entry| text(entry, 0).chars().count()).max().unwrap_or(0);
    let line = |entry: &Entry| {
        let (name, about) = (text(entry, 0), text(entry, 1));
        format!("{name:<longest$}  {}", cut(&about, width().saturating_sub(longest + 2)))
    };
    let lines: Vec<String> = entries.iter().map(line).collect();
    format!("{}\n\n{} · --long for the rest", lines.join("\n"), entries.len())
}

/// An entry with everything that is known of it.
fn long(entry: &Entry) -> String {
    let [(_, name), (_, about), rest @ ..] = &entry[..] else { return String::new() };
    let rest = rest.iter().filter(|(_, value)| !value.is_empty()).map(|(key, value)| format!("{key}: {value}"));
    let lines = [about.clone(), rest.collect::<Vec<_>>().join(" · ")];
    let lines = lines.iter().filter(|line| !line.is_empty()).map(|line| format!("    {}", paragraph(line, 4)));
    format!("{name}\n{}", lines.collect::<Vec<_>>().join("\n"))
}

fn print_schema(schema: &Value) -> anyhow::Result<()> {
    print(&serde_json::to_string_pretty(schema)?)
}

fn of_figures(key: FigureKey) -> Entry {
    let mut entry = named(key.name, key.about);
    entry.extend([("place", key.place), ("takes", key.takes), ("absent", key.absent)]);
    entry
}

fn named(name: &str, about: &str) -> Entry {
    vec![("name", name.to_owned()), ("about", about.to_owned())]
}

/// An array of objects; a default that is a number stands as a number, one that is a choice as a text.
fn json(entries: &[Entry]) -> Value {
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

//! `rimbench list`: cases, schemes, solvers, metrics, parameters, keys of the list of figures, schemas of files.

use super::json::Object;
use super::{Format, print, schema, table};
use clap::{Args, ValueEnum};
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench::figures::{FigureKey, figure_keys};
use rimbench::fmi::import::case_file_schema;
use rimbench::metrics::{METRICS, is_of_friction};
use serde_json::Value;

/// Arguments of `list`.
#[derive(Debug, Args)]
pub struct List {
    /// What to list
    what: What,
    /// Only this case (for cases and parameters)
    #[arg(long, value_name = "CASE")]
    case: Option<String>,
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
                    entry.push((
                        "where",
                        if is_of_friction(metric.name) { "contacts have friction" } else { "" }.to_owned(),
                    ));
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
            Format::Table => {
                let header: Vec<&str> =
                    entries.first().map(|entry| entry.iter().map(|(key, _)| *key).collect()).unwrap_or_default();
                let mut table = table(&header);
                table.add_rows(entries.iter().map(|entry| entry.iter().map(|(_, value)| value)));
                print(&table.to_string())
            }
        }
    }
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

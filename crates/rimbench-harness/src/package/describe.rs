//! What a package says of itself: for programs, for people, for who cites it.

use super::columns::Column;
use super::{Citation, DESCRIPTION, Resource};
use crate::experiment::Experiment;
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_results::checksums::CHECKSUMS;
use serde_json::{Value, json};

/// What the texts are made of.
pub(super) struct About<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) citation: &'a Citation,
    /// Whether the results are those of the quick plan.
    pub(super) quick: bool,
    pub(super) runs: usize,
    pub(super) claims: usize,
    pub(super) resources: &'a [Resource],
}

/// Tables by name, with what a row of them is.
const TABLES: [(&str, &str); 7] = [
    (
        "runs.csv",
        "One row per run: what determines it, how it ended, what was measured, exact counts; the same on every machine",
    ),
    ("cost.csv", "One row per run: wall times; of the machine named in provenance.csv"),
    ("provenance.csv", "One row per run: source, compiler, machine and its load"),
    ("parameters.csv", "Every parameter of every case, resolved"),
    ("settings.csv", "What scales the coupling of each set of parameters, and how many draws were rejected before it"),
    ("reference.csv", "Uncertainty and observed order of the references, by column"),
    ("claims.csv", "What the experiment claims, what was measured, and whether it holds"),
];

/// What each language needs to read the tables.
const LOADERS: [(&str, &str, &str); 4] = [
    ("load.py", "Python, pandas", include_str!("loaders/load.py")),
    ("load.jl", "Julia, CSV and DataFrames", include_str!("loaders/load.jl")),
    ("load.m", "MATLAB", include_str!("loaders/load.m")),
    ("load.R", "R", include_str!("loaders/load.R")),
];

impl About<'_> {
    /// Files with their texts.
    pub(super) fn files(&self) -> Vec<(&'static str, String)> {
        let mut files = vec![("README.md", self.readme()), ("CITATION.cff", self.citation_file())];
        files.extend(LOADERS.map(|(name, _, text)| (name, text.to_owned())));
        // Last: a folder without it is no package.
        files.push((DESCRIPTION, format!("{:#}\n", self.description())));
        files
    }

    fn title(&self) -> &str {
        self.citation.title.as_deref().unwrap_or(&self.experiment.question)
    }

    fn description(&self) -> Value {
        let mut description = json!({
            "profile": "data-package",
            "name": plain(&format!("rimbench-{}", self.experiment.name())),
            "title": self.title(),
            "description": format!(
                "{} runs of co-simulations of mechanical systems with contact, computed by rimbench {}: {}",
                self.runs,
                env!("CARGO_PKG_VERSION"),
                self.experiment.question
            ),
            "licenses": [{ "name": self.citation.licence }],
            "contributors": self.citation.authors.iter().map(|name| json!({ "title": name, "role": "author" })).collect::<Vec<_>>(),
            "keywords": ["co-simulation", "multibody", "contact", "complementarity", "benchmark"],
            "rimbench": {
                "experiment": self.experiment.name(),
                "quick": self.quick,
                "version": env!("CARGO_PKG_VERSION"),
                "numerics_version": NUMERICS_VERSION,
            },
            "resources": self.resources.iter().map(resource).collect::<Vec<_>>(),
        });
        if let Some(day) = &self.citation.released {
            description["created"] = format!("{day}T00:00:00Z").into();
        }
        description
    }

    fn readme(&self) -> String {
        let mut text = format!("# {}\n\n", self.title());
        text += &format!(
            "Results of the experiment `{}`: {} runs of co-simulations of mechanical systems with contact. Cite it as `CITATION.cff` says; \
             licence of the data: {}.\n\n",
            self.experiment.name(),
            self.runs,
            self.citation.licence
        );
        text += "| file | what it is |\n|---|---|\n";
        let there = |name: &str| self.resources.iter().any(|resource| resource.path == name);
        for (name, about) in TABLES.iter().filter(|(name, _)| there(name)) {
            text += &format!("| `{name}` | {about} |\n");
        }
        let traces = self.resources.iter().filter(|resource| resource.path.starts_with("traces/")).count();
        if traces > 0 {
            text += &format!("| `traces/` | {traces} time series: of runs by their `run_id`, and of references |\n");
        }
        text += "| `experiment.toml` | The question, the grid of runs and the claims, as the program reads them |\n";
        text += &format!("| `{DESCRIPTION}` | Every file and every column: type, unit, meaning |\n");
        text += &format!("| `{CHECKSUMS}` | Checksums of the files |\n\n");
        if self.claims > 0 {
            text += &format!(
                "The experiment makes {} claims; `claims.csv` says of each whether it was reproduced.\n\n",
                self.claims
            );
        }
        text += "Units stand in the names of columns (`_n` newtons, `_m_s` metres per second) and in the description. An empty cell says that \
                 a quantity does not apply, `INF` and `-INF` are infinite numbers, `NaN` is no number.\n\n";
        text += "## Load it\n\n";
        for (name, language, code) in LOADERS {
            let fence = name.rsplit('.').next().unwrap_or_default().replace('m', "matlab").replace("py", "python");
            text += &format!("{language} (`{name}`):\n\n```{fence}\n{code}```\n\n");
        }
        text +=
            &format!("## Check it\n\n```sh\nsha256sum --check {CHECKSUMS}\nfrictionless validate {DESCRIPTION}\n```\n");
        text
    }

    fn citation_file(&self) -> String {
        let quoted = |text: &str| Value::from(text).to_string();
        let mut text = String::from(
            "cff-version: 1.2.0\nmessage: If you use these data, please cite them, and the program that computed them.\n",
        );
        text += &format!("title: {}\ntype: dataset\nlicense: {}\n", quoted(self.title()), self.citation.licence);
        if let Some(day) = &self.citation.released {
            text += &format!("date-released: {day}\n");
        }
        text += "authors:\n";
        for author in &self.citation.authors {
            text += &match author.split_once(',') {
                Some((family, given)) => {
                    format!("  - family-names: {}\n    given-names: {}\n", quoted(family.trim()), quoted(given.trim()))
                }
                None => format!("  - name: {}\n", quoted(author)),
            };
        }
        text += &format!(
            "references:\n  - type: software\n    title: {}\n    version: {}\n    authors:\n      - name: The rimbench authors\n",
            quoted("rimbench: benchmark of non-iterative co-simulation of mechanical systems with contact"),
            env!("CARGO_PKG_VERSION"),
        );
        text
    }
}

/// A name as descriptions want it: small letters, digits, `-`, `_`, `.`.
fn plain(name: &str) -> String {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-_.".contains(c);
    name.to_lowercase().chars().map(|c| if allowed(c) { c } else { '-' }).collect()
}

fn resource(resource: &Resource) -> Value {
    let path = &resource.path;
    let stem = path.rsplit_once('.').map_or(path.as_str(), |(stem, _)| stem);
    let mut entry = json!({
        "name": plain(&stem.replace('/', "-").replace("traces", "trace")),
        "path": path,
        "encoding": "utf-8",
        "bytes": resource.bytes,
        "hash": format!("sha256:{}", resource.sha256),
    });
    let Some(columns) = &resource.columns else {
        entry["format"] = "toml".into();
        entry["mediatype"] = "application/toml".into();
        entry["description"] = "The experiment as the program reads it".into();
        return entry;
    };
    let about =
        TABLES.iter().find(|(name, _)| name == path).map_or("A trajectory, one row per time", |(_, about)| about);
    entry["profile"] = "tabular-data-resource".into();
    entry["format"] = "csv".into();
    entry["mediatype"] = "text/csv".into();
    entry["description"] = about.into();
    entry["schema"] = json!({ "fields": columns.iter().map(field).collect::<Vec<_>>(), "missingValues": [""] });
    let keyed = |key: &str| columns.iter().any(|(name, _)| name == key);
    if path == "runs.csv" {
        entry["schema"]["primaryKey"] = json!(["run_id"]);
    } else if keyed("run_id") {
        let reference = json!({ "resource": "runs", "fields": ["run_id"] });
        entry["schema"]["foreignKeys"] = json!([{ "fields": ["run_id"], "reference": reference }]);
    }
    entry
}

fn field((name, column): &(String, Column)) -> Value {
    let mut field = json!({ "name": name, "type": column.kind.name(), "description": column.about });
    if !column.unit.is_empty() {
        field["unit"] = column.unit.as_str().into();
    }
    field
}

//! The files of a pack: a problem as others can read, rebuild and score it without this program.

use super::columns::resource;
use super::judge::{Judged, SCORES, judge_rows};
use super::problem::{Problem, csv_of, zipped};
use rimbench_cases::cases::problem_text;
use rimbench_core::cosim::{Bounds, StopFlag, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums::sha256;
use rimbench_runs::{RunSpec, simulate};
use serde_json::{Value, json};

/// Files that are the same in every pack.
const SAME: [(&str, &str); 5] = [
    ("score.py", include_str!("files/score.py")),
    ("replay.py", include_str!("files/replay.py")),
    ("masters/fmpy_loop.py", include_str!("files/fmpy_loop.py")),
    ("masters/fmpy_ssp.py", include_str!("files/fmpy_ssp.py")),
    ("masters/libcosim.py", include_str!("files/libcosim.py")),
];

/// The part of `problem.md` that is of no model.
const RULES: &str = include_str!("files/rules.md");

/// Makes the files of a pack but for FMUs: names with contents. `spec` is a run of the problem, whose scheme makes the
/// example.
///
/// # Errors
/// [`Error::Incompatible`] for a case that has no text; those of the run.
pub fn pack_files(spec: &RunSpec, problem: &Problem, rows: &Trajectory) -> Result<Vec<(String, Vec<u8>)>> {
    let text = problem_text(&spec.case, &spec.parameters)?;
    let score = serde_json::to_vec_pretty(problem).map_err(|error| Error::Incompatible(error.to_string()))?;
    let mut files = vec![
        ("problem.md".to_owned(), (text + "\n" + &rules(problem)).into_bytes()),
        ("reference.csv.gz".to_owned(), zipped(&csv_of(rows))?),
        ("score.json".to_owned(), score),
    ];
    files.extend(SAME.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec())));
    files.extend(example(spec, problem, rows)?);
    let package = data_package(problem, &files)?;
    files.push(("datapackage.json".to_owned(), package));
    Ok(files)
}

/// What is exchanged, what a file holds and how it is scored, with the numbers of a problem.
fn rules(problem: &Problem) -> String {
    let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    let rows = problem.rows.iter().map(|row| {
        let [p, v, f] = row.columns();
        let [up, uv, uf] = row.uncertainty;
        let peak = row.force_peak_n.map_or("–".to_owned(), |peak| format!("{peak:.6}"));
        format!("| `{p}` | `{v}` | `{f}` | `{}` | {peak} | {up:.1e}, {uv:.1e}, {uf:.1e} |\n", row.received)
    });
    let rows: String = rows.collect();
    [
        ("version", problem.version.clone()),
        ("duration", problem.duration_s.to_string()),
        ("macro_steps", list(&problem.macro_steps_s)),
        ("phases", list(&problem.phases)),
        ("micro_step", problem.micro_step_s.to_string()),
        (
            "mechanics_steps",
            match &*problem.mechanics_steps {
                "1" => "one step".to_owned(),
                "all" => "as many steps as the actuator".to_owned(),
                steps => format!("{steps} steps"),
            },
        ),
        ("sampling", problem.sampling_s.to_string()),
        ("rows", rows.trim_end().to_owned()),
    ]
    .into_iter()
    .fold(RULES.to_owned(), |text, (name, value)| text.replace(&format!("{{{name}}}"), &value))
}

/// One trajectory with its score: of the longest macro step at which it completes, or of the shortest.
fn example(spec: &RunSpec, problem: &Problem, rows: &Trajectory) -> Result<Vec<(String, Vec<u8>)>> {
    let known = (problem.clone(), rows.clone());
    let phase = problem.phases.get(1).copied().unwrap_or(1.0);
    let mut found = None;
    for step in problem.macro_steps_s.iter().rev() {
        let spec = spec.with(|own| (own.macro_step, own.phase) = (*step, phase))?;
        let result = simulate(&spec, Bounds::default(), None, StopFlag::never())?;
        let of_row = problem.rows.iter().flat_map(|row| [&row.position, &row.velocity, &row.force, &row.received]);
        let columns = of_row.filter_map(|name| result.trajectory.index_of(name));
        let run = result.trajectory.selected(&std::iter::once(0).chain(columns).collect::<Vec<_>>());
        let judged = judge_rows(&run, &known, None).map_err(Error::Incompatible)?;
        let completed = judged.outcome == "completed";
        found = Some((run, judged));
        if completed {
            break;
        }
    }
    let Some((run, judged)) = found else { return Ok(Vec::new()) };
    let score = serde_json::to_vec_pretty(&judged.to_json(problem)).unwrap_or_default();
    Ok(vec![("example/run.csv.gz".to_owned(), zipped(&csv_of(&run))?), ("example/score.json".to_owned(), score)])
}

impl Judged {
    /// Lists what `score.py` prints; a score that is no finite number is null.
    pub fn to_json(&self, problem: &Problem) -> Value {
        let mut found = json!({
            "problem": problem.problem, "version": problem.version, "outcome": self.outcome,
            "macro_step_s": self.macro_step_s, "phase": self.phase, "points": self.points,
            "diverged_at_s": self.diverged_at_s,
        });
        for (name, value) in SCORES.iter().zip(self.scores) {
            if value.is_some() {
                found[name] = json!(value);
            }
        }
        if self.interface_residual_j.is_some() {
            found["interface_residual_j"] = json!(self.interface_residual_j);
        }
        found
    }
}

/// Describes the files as a data package (<https://datapackage.org>), with checksums.
fn data_package(problem: &Problem, files: &[(String, Vec<u8>)]) -> Result<Vec<u8>> {
    let time = json!({"name": "time_s", "type": "number", "unit": "s", "description": "Time"});
    let of_row = problem.rows.iter().flat_map(|row| {
        let about = ["Position", "Velocity", "The actuator's own force"];
        row.columns().into_iter().zip(about).map(|(name, about)| field(name, about))
    });
    let fields: Vec<Value> = std::iter::once(time).chain(of_row).collect();
    let received = problem.rows.iter().map(|row| field(&row.received, "Force received over the step that ends here"));
    let resources = files.iter().map(|(path, bytes)| {
        let mut resource = resource(path, Some(sha256(bytes)));
        resource["bytes"] = json!(bytes.len());
        if path.ends_with(".csv.gz") {
            let received = received.clone().filter(|_| path.starts_with("example"));
            resource["schema"] = json!({"fields": fields.iter().cloned().chain(received).collect::<Vec<_>>()});
        }
        resource
    });
    let package = json!({
        "name": problem.name().to_lowercase(), "version": problem.version,
        "title": format!("rimbench, problem {}", problem.name()),
        "licenses": [{"name": "MIT"}], "resources": resources.collect::<Vec<_>>(),
    });
    serde_json::to_vec_pretty(&package).map_err(|error| Error::Incompatible(error.to_string()))
}

fn field(name: &str, about: &str) -> Value {
    json!({"name": name, "type": "number", "unit": rimbench_cases::parameter::unit_of(name), "description": about})
}

//! The files of an experiment.
//!
//! ```text
//! runs.csv        one row per run: what determines it, outcome, metrics, counters; deterministic
//! cost.csv        one row per run: wall time, latency of macro steps; machine-dependent
//! provenance.csv  one row per run: revision, lock file, compiler, processor
//! parameters.csv  every parameter of every case, resolved
//! settings.csv    what scales the coupling of each set of parameters, and how many draws were rejected before it
//! reference.csv   uncertainty and observed order of the reference, per column
//! traces/         one file per run, and the reference, where the experiment asks for them; beliefs within a macro step
//! datapackage.json  the tables with unit and meaning of every column, and checksums
//! summary.csv     medians, and digest.toml: what is kept where rows are made
//! SHA256SUMS      checksums of all these, written last: what lacks one or differs from it is not drawn and not verified
//! records/        the store (see [`Store`](super::Store)); not a result
//! ```

use super::experiment::{COPY, Experiment, PlannedRun};
use super::open::{DATA_PACKAGE, describe};
use super::provenance::RunOrigin;
use super::run_row::{RunRow, TraceMark, line_of, row};
use rimbench_core::cosim::{Outcome, StopFlag, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums::{self, sha256_of_file};
use rimbench_results::kept::{DIGEST, SUMMARY};
use rimbench_results::run_table::{Run, RunTable};
use rimbench_results::trace;
use rimbench_runs::catalogue::Catalogue;
use rimbench_runs::metrics::Only;
use rimbench_runs::{
    Costs, Fact, Findings, Reference, RunSpec, believed, interface_oscillation, names_of, only_of, what_happens,
};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

/// Tells whether the tables of a plan have a column: one of some runs only if it has such a run.
fn has(planned: &[PlannedRun], name: &str) -> bool {
    only_of(name).is_none_or(|only| planned.iter().any(|run| run.spec.has_column(name, only)))
}

/// Columns of `runs.csv` that the plan says: id and label, what determines a run. An option is asked for by row and
/// case.
pub(super) fn plan_header(planned: &[PlannedRun]) -> Vec<&'static str> {
    let mut seen = HashSet::new();
    let kinds = planned.iter().filter(|run| seen.insert((&run.label, &run.spec.case.name)));
    let facts: Vec<Vec<Fact>> = kinds.map(|run| run.spec.facts()).collect();
    let names = facts.first().into_iter().flatten().map(|fact| fact.name);
    let kept = names
        .enumerate()
        .filter(|&(at, _)| facts.iter().any(|facts| !facts[at].of_some_runs || facts[at].value.is_some()));
    ["run_id", "label"].into_iter().chain(kept.map(|(_, name)| name)).collect()
}

/// What a run's row of `runs.csv` says in these columns, those of [`plan_header`].
pub(super) fn plan_cells(run: &PlannedRun, header: &[&str]) -> Vec<String> {
    let facts = run.spec.facts();
    let kept = facts.iter().filter(|fact| header.contains(&fact.name)).map(Fact::cell);
    [run.id.clone(), run.label.clone()].into_iter().chain(kept).collect()
}

/// Whether a table of runs has one of a plan, by all that determines a run but the version of the numerics, of which
/// ids are.
pub(super) fn shares_runs(planned: &[PlannedRun], table: &RunTable) -> bool {
    let header = plan_header(planned);
    let both = |(theirs, name): (usize, &str)| Some((theirs, header.iter().position(|own| *own == name)?));
    let both: Vec<(usize, usize)> = table.settings().enumerate().filter_map(both).collect();
    let settings = |run: &Run| both.iter().map(|&(theirs, _)| run.settings[theirs].to_string()).collect();
    let stored: HashSet<Vec<String>> = table.runs().iter().map(settings).collect();
    planned.iter().any(|run| {
        let cells = plan_cells(run, &header);
        stored.contains(&both.iter().map(|&(_, own)| cells[own].clone()).collect::<Vec<String>>())
    })
}

/// Columns of `runs.csv` that say what was found: the same for every experiment, but for those of some runs and of a
/// claim; what does not apply is empty.
fn findings_header(experiment: &Experiment, planned: &[PlannedRun]) -> Vec<&'static str> {
    let mut names = names_of(|each| Findings::nothing(&Outcome::Completed).columns(each));
    names.retain(|name| match only_of(name) {
        Some(Only::Claimed) => experiment.claims().iter().any(|claim| claim.metric.name() == *name),
        _ => has(planned, name),
    });
    names
}

/// Columns of `cost.csv` that the plan says.
const COST_PLAN: [&str; 4] = ["run_id", "label", "macro_step_s", "phase"];

/// Makes the folder of the traces.
fn traces_in(folder: &Path) -> Result<PathBuf> {
    let traces = folder.join("traces");
    std::fs::create_dir_all(&traces).map_err(|error| Error::file(&traces, format!("cannot be made: {error}")))?;
    Ok(traces)
}

/// Name of the trace of a run.
pub(super) fn trace_name(run_id: &str) -> String {
    format!("{run_id}.csv")
}

/// Writes `runs.csv`, `cost.csv` and `provenance.csv` from the rows of runs, in the order of the plan.
///
/// # Errors
/// [`Error::File`] naming the file.
pub(super) fn write_tables<'a>(
    folder: &Path,
    experiment: &Experiment,
    planned: &[PlannedRun],
    row_of: impl Fn(&PlannedRun) -> Option<&'a RunRow>,
) -> Result<()> {
    let tables = tables(folder, experiment, planned, row_of)?;
    for (name, table) in ["runs.csv", "cost.csv", "provenance.csv"].into_iter().zip(tables).rev() {
        write_atomically(&folder.join(name), |file| file.write_all(table.as_bytes()))?;
    }
    Ok(())
}

/// Checks that `runs.csv` says what the rows of runs say.
///
/// # Errors
/// [`Error::File`] if it says something else, or if the row of a run is not there.
pub(super) fn check_runs<'a>(
    folder: &Path,
    experiment: &Experiment,
    planned: &[PlannedRun],
    row_of: impl Fn(&PlannedRun) -> Option<&'a RunRow>,
) -> Result<()> {
    let [runs, ..] = tables(folder, experiment, planned, row_of)?;
    let path = folder.join("runs.csv");
    let same = std::fs::read(&path).is_ok_and(|written| written == runs.as_bytes());
    if same { Ok(()) } else { Err(Error::file(path, "is not what is stored in records/: run the experiment again")) }
}

/// The texts of `runs.csv`, `cost.csv` and `provenance.csv`.
fn tables<'a>(
    folder: &Path,
    experiment: &Experiment,
    planned: &[PlannedRun],
    row_of: impl Fn(&PlannedRun) -> Option<&'a RunRow>,
) -> Result<[String; 3]> {
    let (plan, kept) = (plan_header(planned), findings_header(experiment, planned));
    let costs = names_of(|each| Costs::default().columns(each));
    let of_cost: Vec<usize> = (0..plan.len()).filter(|&at| COST_PLAN.contains(&plan[at])).collect();
    let origin = names_of(|each| RunOrigin::default().columns(each));
    let header = [
        [&plan[..], &kept, &["wall_limit_s", "trace"]].concat(),
        [&COST_PLAN[..], &costs].concat(),
        [&["run_id"][..], &origin].concat(),
    ];
    let mut tables = header.map(|header| row(&header) + "\n");
    for run in planned {
        let gone = || Error::file(folder, format!("the row of run {} has gone", run.id));
        let mut stored = row_of(run).ok_or_else(gone)?.clone();
        let findings = line_of(|each| {
            stored.found.columns(&mut |name, cell| {
                if kept.contains(&name) {
                    each(name, cell);
                }
            });
        });
        let [runs, cost, provenance] = &mut tables;
        let limit = stored.wall_limit_s.map(number).unwrap_or_default();
        let trace = experiment.trace_of(&run.label).map(|_| trace_name(&run.id)).unwrap_or_default();
        let cells = plan_cells(run, &plan);
        *runs += &[&row(&cells), &findings, &limit, &trace].map(String::as_str).join(",");
        let of_cost: Vec<&str> = of_cost.iter().map(|&at| &*cells[at]).collect();
        *cost += &[row(&of_cost), line_of(|each| stored.costs.columns(each))].join(",");
        *provenance += &[&run.id, &*line_of(|each| stored.origin.columns(each))].join(",");
        tables.iter_mut().for_each(|table| table.push('\n'));
    }
    Ok(tables)
}

/// Writes `parameters.csv`, `settings.csv`, `reference.csv` and the traces of the references, one reference at a time,
/// and returns the names of those traces, each with the one of `names` where there are several. A reference that took
/// longer than its runs may take, or that there is none of, has no rows. `rejected_draws` are those before a setting,
/// by case and set, where an event is required.
///
/// # Errors
/// [`Error::File`] naming the file; whatever makes a reference fail.
pub(super) fn write_references<'a>(
    folder: &Path,
    references: impl Iterator<Item = Result<(&'a RunSpec, Option<Reference>)>>,
    names: &[String],
    rejected_draws: &BTreeMap<(String, String), usize>,
    trace_every_s: Option<f64>,
) -> Result<Vec<String>> {
    let mut traces = Vec::new();
    let mut parameters = vec![row(&["case", "set", "parameter", "value", "unit", "source"])];
    let scales = ["interface_frequency_rad_s", "interface_damping_ratio", "effective_mass_ratio"];
    let mut settings = vec![row(&[&["case", "set"][..], &scales, &["rejected_draws"]].concat())];
    let mut columns = vec![row(&["case", "set", "column", "rms_uncertainty", "observed_order", "finest_step_s"])];
    for (index, found) in references.enumerate() {
        let (spec, reference) = found?;
        let (case, set) = (&*spec.case.name, spec.parameters.given());
        for (parameter, value) in spec.parameters.iter() {
            let value = value.to_string();
            parameters.push(row(&[case, &set, &parameter.name, &value, &parameter.unit, &parameter.source]));
        }
        let Some(reference) = reference else { continue };
        let [frequency, damping, ratio] = dimensionless(spec, &reference)?;
        let rejected = rejected_draws.get(&(case.to_owned(), set.clone())).map(usize::to_string).unwrap_or_default();
        settings.push(row(&[case, &set, &frequency, &damping, &ratio, &rejected]));
        for (column, name) in reference.trajectory.columns().iter().enumerate().skip(1) {
            let (uncertainty, order) = (number(reference.uncertainty[column]), number(reference.order[column]));
            columns.push(row(&[case, &set, name, &uncertainty, &order, &number(reference.step)]));
        }
        if let Some(every) = trace_every_s {
            let name = match names.get(index) {
                Some(case) => format!("reference-{case}.csv"),
                None => "reference.csv".to_owned(),
            };
            write_trace(folder, &name, &reference.trajectory, every)?;
            traces.push(name);
        }
    }
    for (name, rows) in [("parameters.csv", parameters), ("settings.csv", settings), ("reference.csv", columns)] {
        write_atomically(&folder.join(name), |file| rows.iter().try_for_each(|row| writeln!(file, "{row}")))?;
    }
    Ok(traces)
}

/// What scales the coupling of a setting: frequency and damping ratio of its interface, by how much contacts change its
/// mass.
fn dimensionless(spec: &RunSpec, reference: &Reference) -> Result<[String; 3]> {
    let oscillation = if spec.case.from_outside { None } else { interface_oscillation(spec)? };
    let [frequency, damping] = oscillation.map_or([String::new(), String::new()], |both| both.map(number));
    let masses = reference.trajectory.index_of("effective_mass_kg");
    let masses = masses.into_iter().flat_map(|column| reference.trajectory.column(column));
    let (least, most) = masses.fold((f64::INFINITY, 0.0_f64), |(least, most), mass| (least.min(mass), most.max(mass)));
    Ok([frequency, damping, if most > 0.0 { number(most / least) } else { String::new() }])
}

/// What two processes that finish one job at once do not write alike.
const MEASURED: [&str; 2] = ["cost.csv", "provenance.csv"];

/// Seals the results, of which these are the traces: from now on a file that is changed or gone is noticed. What
/// another process has replaced meanwhile is sealed again, so that the last of them leaves all as it was written.
///
/// # Errors
/// [`Error::File`] naming a file that has gone meanwhile.
pub(super) fn write_checksums(folder: &Path, traces: impl Iterator<Item = String>) -> Result<()> {
    let others = ["parameters.csv", "settings.csv", "reference.csv", COPY, SUMMARY, DIGEST];
    let tables = ["runs.csv"].into_iter().chain(MEASURED).chain(others).map(str::to_owned);
    let files: Vec<String> = tables.chain(traces.map(|name| format!("traces/{name}"))).collect();
    describe(folder, &files, &MEASURED)?;
    let files: Vec<String> = files.into_iter().chain([DATA_PACKAGE.to_owned()]).collect();
    loop {
        checksums::write(folder, files.clone())?;
        let sums = checksums::read(folder)?.unwrap_or_default();
        if MEASURED.iter().all(|name| sha256_of_file(&folder.join(name)).as_ref() == sums.get(*name)) {
            return Ok(());
        }
    }
}

/// Writes a trajectory to the folder's traces, thinned to one row per `every` seconds; first and last rows always
/// stand.
///
/// # Errors
/// [`Error::File`] naming the file.
pub(super) fn write_trace(folder: &Path, name: &str, trajectory: &Trajectory, every: f64) -> Result<TraceMark> {
    let traces = traces_in(folder)?;
    let path = traces.join(name);
    trace::write_trace(&path, trajectory, Some(every))?;
    let sha256 = sha256_of_file(&path).ok_or_else(|| Error::file(&path, "has gone as soon as it was written"))?;
    Ok(TraceMark { every_s: every, sha256 })
}

/// Writes what happens and what schemes believe in the macro step of some runs that starts at `at_s` (s), each with its
/// label, as `traces/beliefs-<case>.csv`: the columns of a run behind the label, of which what happens has none.
///
/// # Errors
/// Those of [`believed`]; [`Error::File`] naming the file.
pub(super) fn write_beliefs(
    folder: &Path,
    catalogue: &Catalogue,
    at_s: f64,
    runs: &[(String, RunSpec)],
    stop: StopFlag<'_>,
) -> Result<String> {
    let first = &runs[0].1;
    let from = what_happens(first, catalogue, at_s, stop)?;
    let traces = traces_in(folder)?;
    let name = format!("beliefs-{}.csv", first.case.name);
    let mut lines = vec![row(&["scheme"]) + "," + &row(from.happens.columns())];
    let mut add = |label: &str, rows: &Trajectory| {
        lines.extend(rows.rows().map(|values| {
            let numbers: Vec<String> = values.iter().map(|value| number(*value)).collect();
            row(&[label]) + "," + &row(&numbers)
        }));
    };
    add("", &from.happens);
    for (label, spec) in runs {
        add(label, &believed(spec, &from)?);
    }
    write_atomically(&traces.join(&name), |file| lines.iter().try_for_each(|line| writeln!(file, "{line}")))?;
    Ok(name)
}

/// Copies the trace of a run from the results folder of a shard, if it has one.
///
/// # Errors
/// [`Error::File`] naming the file.
pub(super) fn copy_trace(from: &Path, to: &Path, id: &str) -> Result<()> {
    let name = trace_name(id);
    let Ok(content) = std::fs::read(from.join("traces").join(&name)) else { return Ok(()) };
    let traces = traces_in(to)?;
    write_atomically(&traces.join(&name), |file| file.write_all(&content))
}

/// Shortest text that reads back to the same bits; `inf` and `NaN` where it is so.
fn number(value: f64) -> String {
    format!("{value:?}")
}

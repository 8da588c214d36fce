//! Who takes part: scheme rows with their runs, problem by problem.

use rimbench_cases::catalogue::Catalogue;
use rimbench_core::cosim::{OutcomeClass, OutcomeKind};
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::InformationClass;
use rimbench_results::results_table::ResultsTable;
use std::collections::{BTreeMap, BTreeSet};

/// What is compared.
const ERROR: &str = "force_error_rms_of_peak";

/// Error that a failure is charged, and the most that any error counts.
pub(super) const CHARGE: f64 = 1.0;

/// Columns that make a problem.
pub(super) const PROBLEM: [&str; 8] = [
    "case",
    "set",
    "duration_s",
    "micro_step_s",
    "mechanics_integrator",
    "actuator_integrator",
    "macro_step_s",
    "phase",
];

/// Columns of what can be chosen for a scheme row. Within a row they are the same on every problem: otherwise it would be several rows,
/// each where it is best.
const OPTIONS: [&str; 11] = [
    "scheme",
    "sequence",
    "force_return",
    "mechanics_steps",
    "redundancy",
    "model_motion",
    "contact_detection",
    "solver",
    "gain",
    "step_control",
    "step_tolerance",
];

/// The first of the [`OPTIONS`] in which two runs differ, and what it is in each.
fn first_differing<'a>(one: &'a [String], other: &'a [String]) -> Option<(&'static str, &'a str, &'a str)> {
    let differs = |((option, one), other): ((&'static str, &'a String), &'a String)| {
        (one != other).then_some((option, one.as_str(), other.as_str()))
    };
    OPTIONS.into_iter().zip(one).zip(other).find_map(differs)
}

/// One run of a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outcome {
    pub(super) error: f64,
    pub(super) failed: bool,
    pub(super) skipped: bool,
}

/// What is known of a row before it is ranked.
#[derive(Debug, Clone)]
pub(super) struct Entrant {
    pub(super) class: InformationClass,
    pub(super) tuned_on: BTreeSet<String>,
    pub(super) outcomes: BTreeMap<Vec<String>, Outcome>,
    /// Its [`OPTIONS`], and the case of the run that has them; of runs on cases that it was not tuned on.
    pub(super) options: Option<(Vec<String>, String)>,
    /// Per macro step, of completed runs: exchanges, steps of the mechanics.
    pub(super) work: [Vec<f64>; 2],
}

/// What a scheme of the catalogue needs, and what it was tuned on: a gain that is not the default was chosen by somebody on something.
pub(super) fn of_catalogue(
    catalogue: &Catalogue,
    runs: &ResultsTable,
    row: usize,
) -> Result<(InformationClass, BTreeSet<String>)> {
    let scheme = catalogue.scheme(runs.text(row, runs.column("scheme")?))?;
    let gain = runs.number(row, runs.column("gain")?);
    let usual = scheme.gain.as_ref().is_none_or(|known| gain.is_nan() || gain == known.default);
    let tuned_on =
        if usual { BTreeSet::new() } else { BTreeSet::from([runs.text(row, runs.column("case")?).to_owned()]) };
    Ok((class_of_run(InformationClass::of(scheme), runs, row)?, tuned_on))
}

/// The class of a run: control of the macro step takes steps again, whatever the scheme.
fn class_of_run(of_scheme: InformationClass, runs: &ResultsTable, row: usize) -> Result<InformationClass> {
    let controlled = runs.text(row, runs.column("step_control")?) != "none";
    Ok(if controlled { of_scheme.max(InformationClass::Repetition) } else { of_scheme })
}

/// Enters the runs of a table; `who` says class and tuning of a run.
///
/// # Errors
/// [`Error::File`] for a row that has other options on one problem than on another, unless it was tuned on that case.
pub(super) fn enter(
    entrants: &mut BTreeMap<String, Entrant>,
    runs: &ResultsTable,
    who: impl Fn(usize) -> Result<(InformationClass, BTreeSet<String>)>,
) -> Result<()> {
    let problem = PROBLEM.iter().map(|name| runs.column(name)).collect::<Result<Vec<usize>>>()?;
    let [label, outcome, error, step, duration] =
        ["label", "outcome", ERROR, "macro_step_s", "duration_s"].map(|name| runs.column(name));
    let (label, outcome, error, step, duration) = (label?, outcome?, error?, step?, duration?);
    let options = OPTIONS.map(|name| runs.column(name).ok());
    let counters = [runs.column("exchanges")?, runs.column("mechanics_micro_steps")?];
    for row in 0..runs.len() {
        let (information, tuned_on) = who(row)?;
        let key: Vec<String> = problem.iter().map(|&column| runs.text(row, column).to_owned()).collect();
        let ended: OutcomeKind = runs.text(row, outcome).parse()?;
        let (class, skipped) = (ended.class(), !ended.was_run());
        // What was run and gave no answer is no problem that the row has: it then lacks one, and is not ranked.
        if class == OutcomeClass::NoAnswer && !skipped {
            continue;
        }
        let value = runs.number(row, error);
        let (completed, failed) = (class == OutcomeClass::Completed, class == OutcomeClass::Failed);
        let error = if completed && value.is_finite() { value.min(CHARGE) } else { CHARGE };
        let entrant = entrants.entry(runs.text(row, label).to_owned()).or_insert_with(|| Entrant {
            class: information,
            tuned_on: BTreeSet::new(),
            outcomes: BTreeMap::new(),
            options: None,
            work: [Vec::new(), Vec::new()],
        });
        let case = &key[0];
        if !tuned_on.contains(case) {
            let own: Vec<String> =
                options.iter().map(|column| column.map_or("", |column| runs.text(row, column)).to_owned()).collect();
            let (known, there) = entrant.options.get_or_insert_with(|| (own.clone(), case.clone()));
            if let Some((option, was, is)) = first_differing(known, &own) {
                let message = format!(
                    "row `{}` has {option} = `{was}` on `{there}` and `{is}` on `{case}`: what is ranked under one label is the same \
                     everywhere",
                    runs.text(row, label)
                );
                return Err(Error::file(runs.path(), message));
            }
        }
        entrant.class = entrant.class.max(information);
        entrant.tuned_on.extend(tuned_on);
        // One row that was run several ways on a problem, as with several gains, has the worst of them: none was chosen beforehand.
        let known = entrant.outcomes.entry(key).or_insert(Outcome { error, failed, skipped });
        if error > known.error || failed {
            *known = Outcome { error, failed, skipped };
        }
        if completed {
            let steps = (runs.number(row, duration) / runs.number(row, step)).max(1.0);
            for (work, &counter) in entrant.work.iter_mut().zip(&counters) {
                work.push(runs.number(row, counter) / steps);
            }
        }
    }
    Ok(())
}

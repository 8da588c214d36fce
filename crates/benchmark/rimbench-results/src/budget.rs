//! What a budget buys: so many communication points and so many steps of the mechanics per second, and which form of
//! each scheme errs least within them.
//!
//! ```text
//! budget.csv   a row per case, set, budget and way of coupling, the best first; where settings are drawn, all of them in one
//! ```
//! A way is what labels say up to their last `/`, a form what they say behind it, at a macro step.

use crate::atomic_file::write_atomically;
use crate::kept::PooledSets;
use crate::run_table::RunTable;
use crate::selection::{ALL, Runs};
use rimbench_core::error::{Error, Result};
use rimbench_runs::Finding;
use rimbench_statistics::Pool;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Name of the file.
pub const BUDGET: &str = "budget.csv";

/// By how much a budget may be exceeded: a phase below 1 has one macro step more, and a step is split at an impact.
const SLACK: [f64; 2] = [1.03, 1.05];

/// Where the error is judged: inside macro steps as well, or long ones look better than they are.
const ERROR: &str = "force_error_inside_rms_n";

/// The same error at communication points, and over the peak: their ratio is the peak.
const SAMPLED: [&str; 2] = ["force_error_rms_n", "force_error_rms_of_peak"];

/// The budgets that an experiment asks about.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budgets {
    /// Communication points and mechanics steps, each per second of simulated time.
    pub per_s: Vec<[f64; 2]>,
    /// Labels with this word in them are left out when it is told a second time what is best.
    pub without: Option<String>,
}

impl Budgets {
    /// Finds the first pair that is no budget; a list without one has none to show.
    pub fn wrong(&self) -> Option<&[f64]> {
        let is_wrong = |pair: &&[f64; 2]| !pair.iter().all(|count| count.is_finite() && *count > 0.0);
        self.per_s.iter().find(is_wrong).map(|pair| &pair[..]).or(self.per_s.is_empty().then_some(&[]))
    }
}

/// A form of a way of coupling, at a macro step.
#[derive(Debug, Clone, PartialEq)]
pub struct Form<'a> {
    /// What it is a form of.
    pub way: &'a str,
    /// Its place in a list of the caller's; of runs, the row of its first.
    pub place: usize,
    /// Communication points and steps of the mechanics that it takes, trials and repeated ones included, each per second
    /// of simulated time.
    pub spent: [f64; 2],
    /// How wrong it is; infinite if it fails.
    pub error: f64,
}

/// Returns the way of a label.
pub fn way_of(label: &str) -> &str {
    label.rsplit_once('/').map_or(label, |(way, _)| way)
}

/// Finds of each way the form with the least error within a budget, the best way first.
pub fn best_within<'f, 'a>(forms: &'f [Form<'a>], budget: [f64; 2]) -> Vec<&'f Form<'a>> {
    let fits = |form: &&Form<'_>| form.error.is_finite() && (0..2).all(|of| form.spent[of] <= SLACK[of] * budget[of]);
    let mut best: BTreeMap<&str, &Form<'_>> = BTreeMap::new();
    for form in forms.iter().filter(fits) {
        let own = best.entry(form.way).or_insert(form);
        if form.error < own.error {
            *own = form;
        }
    }
    let mut best: Vec<_> = best.into_values().collect();
    best.sort_by(|a, b| a.error.total_cmp(&b.error));
    best
}

/// Computes the factor between the errors of a way and of another, or of the best of [`ALL`], within a budget: infinite
/// where nothing of the one completes, none where nothing of the other does.
pub fn ratio_within(forms: &[Form<'_>], budget: [f64; 2], [way, other]: [&str; 2]) -> Option<f64> {
    let best = best_within(forms, budget);
    let other = best.iter().find(|form| other == ALL || form.way == other)?;
    Some(best.iter().find(|form| form.way == way).map_or(f64::INFINITY, |own| own.error / other.error))
}

/// Lists the forms of each case and set: a form that fails at one phase has failed, else its error is the median over
/// phases of what `error` says of a run.
pub fn forms_of<'t>(runs: &Runs<'t>, error: impl Fn(usize) -> f64) -> BTreeMap<[&'t str; 2], Vec<Form<'t>>> {
    let mut all: BTreeMap<_, Vec<Form<'_>>> = BTreeMap::new();
    let groups =
        runs.by_key(|run| (run.problem(), &*run.label, run.macro_step_s.to_bits(), run.step_tolerance.to_bits()));
    for ((problem, label, ..), of_form) in groups {
        let (tally, completed) = (of_form.tally(), of_form.completed());
        let per_s = |count: fn(&rimbench_core::cosim::Work) -> u64| {
            let found = |row: usize| &runs.run(row).found;
            completed.pool(|row| count(&found(row).work) as f64 / found(row).ended_at_s).median()
        };
        let spent = [per_s(|work| work.cosim.macro_steps), per_s(|work| work.sides.mechanics.micro_steps)];
        let ([Some(points), Some(steps)], 0) = (spent, tally.failed + tally.no_answer) else { continue };
        let Some(error) = completed.pool(&error).median() else { continue };
        let form = Form { way: way_of(label), place: of_form.rows()[0], spent: [points, steps], error };
        all.entry(problem).or_default().push(form);
    }
    all
}

/// Says what each budget buys, as the text of `budget.csv`.
///
/// # Errors
/// [`Error::File`] for a column that is not there.
pub fn budget_csv(table: &RunTable, budgets: &Budgets, pooled: &PooledSets) -> Result<String> {
    let [inside, sampled, of_peak] = [ERROR, SAMPLED[0], SAMPLED[1]].map(Finding::named);
    let [inside, sampled, of_peak] = [inside?, sampled?, of_peak?];
    [inside, sampled, of_peak].into_iter().try_for_each(|finding| table.check(finding))?;
    let all = Runs::of(table);
    let error = |row| all.value(row, inside);
    let of_peak = |form: &Form<'_>| form.error * all.value(form.place, of_peak) / all.value(form.place, sampled);
    let mut text = "case,set,exchanges_per_s,mechanics_steps_per_s,without,rank,way,label,macro_step_s,error_of_peak,ratio,ratio_q1,ratio_q3,first,settings\n"
        .to_owned();
    let short = |value: f64| format!("{:?}", format!("{value:.5e}").parse().unwrap_or(value));
    for without in std::iter::once("").chain(budgets.without.as_deref()) {
        let runs = all.select(|row| without.is_empty() || !all.label(row).contains(without));
        let forms = forms_of(&runs, error);
        for budget @ [points, steps] in &budgets.per_s {
            let mut line = |problem: [&str; 2], rank: usize, way: &str, rest: String| {
                text += &format!("{},{points},{steps},{without},{rank},{way},{rest}\n", problem.join(","));
            };
            if pooled.is_empty() {
                for (problem, forms) in &forms {
                    let best = best_within(forms, *budget);
                    for (rank, form) in best.iter().enumerate() {
                        let run = all.run(form.place);
                        let [error, ratio] = [of_peak(form), form.error / best[0].error].map(short);
                        let rest =
                            format!("{},{:?},{error},{ratio},,,{},1", run.label, run.macro_step_s, u8::from(rank == 0));
                        line(*problem, rank + 1, form.way, rest);
                    }
                }
                continue;
            }
            let mut ways: Vec<&str> = runs.labels(&[]).into_iter().map(way_of).collect();
            ways.sort_unstable();
            ways.dedup();
            let ratios = |way: &str| Pool::of(forms.values().filter_map(|of| ratio_within(of, *budget, [way, ALL])));
            let mut pools: Vec<(&str, Pool, usize)> = Vec::new();
            for way in ways {
                let firsts = forms.values().filter(|of| ratio_within(of, *budget, [way, ALL]) == Some(1.0)).count();
                pools.push((way, ratios(way), firsts));
            }
            pools.sort_by(|a, b| a.1.quartiles()[1].total_cmp(&b.1.quartiles()[1]));
            let settings = forms.values().filter(|of| !best_within(of, *budget).is_empty()).count();
            for (rank, (way, pool, firsts)) in pools.iter().enumerate() {
                let [q1, median, q3] = pool.quartiles().map(short);
                let first = short(*firsts as f64 / settings.max(1) as f64);
                line([ALL, ""], rank + 1, way, format!(",,,{median},{q1},{q3},{first},{settings}"));
            }
        }
    }
    Ok(text)
}

/// Writes `budget.csv` beside `runs.csv`.
///
/// # Errors
/// [`Error::File`].
pub fn keep_budget(folder: &Path, budgets: &Budgets, pooled: &PooledSets) -> Result<()> {
    let text = budget_csv(&RunTable::read_from(folder)?, budgets, pooled)?;
    write_atomically(&folder.join(BUDGET), |file| file.write_all(text.as_bytes()))
}

/// Checks that the `budget.csv` in a folder is the one that its rows give.
///
/// # Errors
/// [`Error::File`] if it is another, or not there.
pub fn check_budget(folder: &Path, table: &RunTable, budgets: &Budgets, pooled: &PooledSets) -> Result<()> {
    let path = folder.join(BUDGET);
    let written =
        std::fs::read_to_string(&path).map_err(|error| Error::file(&path, format!("cannot be read: {error}")))?;
    let same = written == budget_csv(table, budgets, pooled)?;
    if same { Ok(()) } else { Err(Error::file(&path, "is not that of runs.csv beside it: run the experiment again")) }
}

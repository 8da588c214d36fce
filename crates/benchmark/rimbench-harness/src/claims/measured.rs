//! What was measured of a claim.

use super::witnesses::OfFailed;
use crate::experiment::{AtEqual, Claim, Statistic};
use rimbench_core::cosim::OutcomeClass;
use rimbench_core::error::Result;
use rimbench_results::budget::{best_within, forms_of, ratio_within};
use rimbench_results::claims::CheckedClaim;
use rimbench_results::run_table::RunTable;
use rimbench_results::selection::{ALL, Runs};
use rimbench_runs::Finding;
use rimbench_statistics::{
    Costed, PairedRatios, PairedRun, Pool, Share, bootstrap_interval, order_of_medians, ratios_at_equal_cost,
    share_interval, share_told_by_threshold,
};
use std::collections::{BTreeMap, BTreeSet};

/// Holds a claim against the rows of an experiment, of which it is told what of a case and a set was drawn.
pub(super) fn check(
    claim: &Claim,
    experiment: &str,
    table: &RunTable,
    draw_of: &dyn Fn([&str; 2]) -> String,
) -> Result<CheckedClaim> {
    let runs = Runs::of(table);
    let problem = runs.of_problem(claim.case.as_deref(), claim.set.as_deref());
    if let Some(budgets) = claim.budgets() {
        return at_budgets(claim, budgets, experiment, &problem, draw_of);
    }
    let about = problem.select(|row| claim.is_about(runs.macro_step(row)));
    let labels = [Some(&claim.scheme), claim.relative_to.as_ref()];
    let rows: Vec<usize> =
        labels.into_iter().flatten().flat_map(|label| about.of_label(label).rows().to_vec()).collect();
    let all = about.with_rows(rows);
    let values = Values::of(claim, &all)?;
    let is_known = |row: usize| !values.value[row].is_nan();
    let known = all.select(is_known);
    // For an order failures count only below the largest macro step with a value, on the way to H = 0.
    let fitted = known.iter().map(|run| run.macro_step_s).fold(0.0, f64::max);
    let is_fitted = |row| claim.statistic != Statistic::Order || runs.macro_step(row) < fitted;
    let has_failed = |row| runs.class(row) == OutcomeClass::Failed;
    let refutes = |row| has_failed(row) && values.of_failed(row) == OfFailed::Against && is_fitted(row);
    let [failed, refuting] = [all.select(has_failed), all.select(refutes)];
    let measured = values.measured(known.rows());
    let drawn = known.witnesses(draw_of);
    let counted = |count: &dyn Fn(&[usize]) -> [usize; 2]| {
        share_interval(&drawn.iter().map(|rows| count(rows)).collect::<Vec<_>>()).filter(|_| drawn.len() > 1)
    };
    let interval = match claim.statistic {
        // Of one that is drawn twice each ratio counts twice.
        Statistic::Median if claim.is_about_ratios() && known.problems().len() > 1 => {
            Pool::grouped(drawn.iter().map(|rows| values.ratios(rows).ratios)).interval()
        }
        Statistic::Median | Statistic::Order => bootstrap_interval(&drawn, |drawn| values.measured(&drawn)),
        Statistic::ShareBetter => counted(&|rows| {
            let share = values.share(rows);
            [share.better, share.better + share.worse]
        }),
        Statistic::Mean if claim.is_a_share() => {
            counted(&|rows| [rows.iter().filter(|&&row| values.value[row] == 1.0).count(), rows.len()])
        }
        _ => None,
    };
    let exact = runs.exact_problems();
    let without_exact = match known.problems().iter().any(|problem| exact.contains(problem)) {
        true => values.measured(known.select(|row| !exact.contains(&runs.problem(row))).rows()),
        false => None,
    };
    let settings = match claim.statistic {
        Statistic::ShareBetter => values.share(known.rows()).in_words(),
        _ if claim.is_about_ratios() && claim.at_equal.is_none() => values.ratios(known.rows()).in_words(),
        _ => String::new(),
    };
    let mut remarks = if claim.counts_ends() { Vec::new() } else { values.failed_in_words([&all, &failed, &refuting]) };
    // Those that failed are told already.
    let is_told = |row| has_failed(row) && !claim.counts_ends();
    let left_out = all.select(|row| !is_known(row) && !is_told(row)).rows().len();
    if left_out > 0 {
        remarks.push(format!("{left_out} of {} runs left out: {}", all.rows().len(), claim.why_left_out()));
    }
    let remarks = if remarks.is_empty() { String::new() } else { format!(" ({})", remarks.join("; ")) };
    let asked = all.select(|row| is_known(row) || refutes(row));
    let quantity = format!("{}{settings}{remarks}", claim.quantity());
    Ok(CheckedClaim {
        without_exact,
        runs: asked.rows().len(),
        failed: failed.rows().len(),
        run_ids: asked.iter().map(|run| run.id.to_string()).collect(),
        ..claim.checked(experiment, quantity, (measured, interval), !refuting.rows().is_empty())
    })
}

/// Holds a claim about the best forms within budgets against runs: a ratio for each case, set and budget, or with
/// `within` the share of them that are no larger.
fn at_budgets(
    claim: &Claim,
    budgets: &[[f64; 2]],
    experiment: &str,
    runs: &Runs<'_>,
    draw_of: &dyn Fn([&str; 2]) -> String,
) -> Result<CheckedClaim> {
    runs.table().check(claim.metric)?;
    let is_wanted = |row: usize| claim.without.as_ref().is_none_or(|word| !runs.label(row).contains(word.as_str()));
    let runs = runs.select(is_wanted);
    let other = claim.relative_to.as_deref().unwrap_or(ALL);
    let (mut groups, mut lost, mut rows) = (BTreeMap::<String, Vec<f64>>::new(), 0, BTreeSet::new());
    for (problem, forms) in forms_of(&runs, |row| runs.value(row, claim.metric)) {
        for budget in budgets {
            let Some(ratio) = ratio_within(&forms, *budget, [&claim.scheme, other]) else {
                lost += 1;
                continue;
            };
            let value = claim.within.map_or(ratio, |most| f64::from(ratio <= most * (1.0 + 1e-9)));
            groups.entry(draw_of(problem)).or_default().push(value);
            let best = best_within(&forms, *budget);
            rows.extend(
                best.iter().filter(|form| form.way == claim.scheme || form.way == other).map(|form| form.place),
            );
        }
    }
    let values = || groups.values().flatten().copied();
    let interval = match claim.within {
        Some(_) => share_interval(
            &groups.values().map(|own| [own.iter().filter(|own| **own == 1.0).count(), own.len()]).collect::<Vec<_>>(),
        ),
        None => Pool::grouped(groups.values().cloned()).interval(),
    };
    let interval = interval.filter(|_| groups.len() > 1);
    let measured = claim.statistic.of(values().map(|value| (0.0, value)));
    let lost = if lost > 0 { format!(" ({lost} left out: nothing completes there)") } else { String::new() };
    let quantity = format!("{}, {} ratios{lost}", claim.quantity(), values().count());
    Ok(CheckedClaim {
        runs: runs.rows().len(),
        failed: runs.tally().failed,
        run_ids: rows.into_iter().map(|row| runs.run(row).id.to_string()).collect(),
        ..claim.checked(experiment, quantity, (measured, interval), false)
    })
}

/// What the runs of a table have to say of a claim, by row.
struct Values<'a> {
    claim: &'a Claim,
    runs: &'a Runs<'a>,
    /// The claim's metric; NaN where a run says nothing of it.
    value: Vec<f64>,
    /// Tolerance of a step control, 0 without one.
    tolerance: Vec<f64>,
    /// The counter that is to be equal, if any; else 0.
    cost: Vec<f64>,
    /// What an error must exceed to be known; NaN where it is not asked for.
    floor: Vec<f64>,
    /// Whether the two rows have a macro step in common; else each has one of its own.
    shares_steps: bool,
}

impl<'a> Values<'a> {
    fn of(claim: &'a Claim, runs: &'a Runs<'a>) -> Result<Self> {
        let table = runs.table();
        let (metric, cost) = (claim.metric, claim.at_equal.as_ref().and_then(AtEqual::counter));
        [Some(metric).filter(|metric| !Finding::ENDS.contains(metric)), cost]
            .into_iter()
            .flatten()
            .try_for_each(|finding| table.check(finding))?;
        let known = matches!(claim.statistic, Statistic::Order | Statistic::ShareBetter);
        let all = table.len();
        let steps = |label: &String| -> BTreeSet<u64> {
            runs.of_label(label).iter().map(|run| run.macro_step_s.to_bits()).collect()
        };
        let other = claim.relative_to.as_ref().map(steps);
        let mut values = Values {
            claim,
            runs,
            value: vec![f64::NAN; all],
            tolerance: vec![0.0; all],
            cost: vec![0.0; all],
            floor: vec![f64::NAN; all],
            shares_steps: other.is_none_or(|other| !other.is_disjoint(&steps(&claim.scheme))),
        };
        for &row in runs.rows() {
            let (run, number) = (runs.run(row), runs.value(row, metric));
            let number = if claim.is_by_magnitude() { number.abs() } else { number };
            let has_order = claim.statistic == Statistic::Order && run.found.has_order(metric);
            let failed = runs.class(row) == OutcomeClass::Failed;
            let of_failed = failed.then(|| values.of_failed(row));
            values.value[row] = match number {
                _ if runs.class(row) == OutcomeClass::NoAnswer => f64::NAN,
                _ if claim.within.is_some() => {
                    f64::from(!failed && claim.within.is_some_and(|most| number.abs() <= most))
                }
                _ if claim.statistic.is_threshold() && !number.is_nan() => f64::from(!failed),
                _ if of_failed == Some(OfFailed::Infinite) => f64::INFINITY,
                _ if matches!(of_failed, Some(OfFailed::Against | OfFailed::LeftOut)) => f64::NAN,
                _ if claim.statistic == Statistic::Order && !has_order => f64::NAN,
                _ => claim.above.filter(|_| !number.is_nan()).map_or(number, |above| f64::from(number > above)),
            };
            values.tolerance[row] = if run.step_tolerance.is_finite() { run.step_tolerance } else { 0.0 };
            values.floor[row] = run.found.floor(metric).filter(|_| known).unwrap_or(f64::NAN);
            values.cost[row] = cost.map_or(0.0, |counter| runs.value(row, counter));
        }
        Ok(values)
    }

    /// What a run says of the claim if it failed.
    fn of_failed(&self, row: usize) -> OfFailed {
        self.claim.of_failed(self.runs.label(row) != self.claim.scheme)
    }

    /// How many runs of each of the rows compared failed, of all, and whether they speak against the claim; nothing of
    /// those of which none did.
    fn failed_in_words(&self, runs: [&Runs<'_>; 3]) -> Vec<String> {
        let of = |label: &String| {
            let [all, failed, refuting] = runs.map(|runs| runs.of_label(label).rows().len());
            let whose = if self.claim.relative_to.is_some() { format!(" of {label}") } else { String::new() };
            let worse = if refuting > 0 { ", which is worse than every number" } else { "" };
            (failed > 0).then(|| format!("{failed} of {all}{whose} failed{worse}"))
        };
        [Some(&self.claim.scheme), self.claim.relative_to.as_ref()].into_iter().flatten().filter_map(of).collect()
    }

    /// The statistic of some rows, or of the factors between those of two schemes, or the ratio of two shares.
    fn measured(&self, rows: &[usize]) -> Option<f64> {
        if self.claim.is_about_ratios() {
            return self.claim.statistic.of(self.ratios(rows).ratios.into_iter().map(|ratio| (0.0, ratio)));
        }
        if self.claim.statistic == Statistic::ShareBetter {
            return self.share(rows).share();
        }
        if self.claim.statistic.is_threshold() {
            return self.told_by_threshold(rows);
        }
        let of = |label: &str| {
            let own = rows.iter().filter(|&&row| self.runs.label(row) == label);
            self.claim.statistic.of(own.map(|&row| (self.runs.macro_step(row), self.value[row])))
        };
        let own = of(&self.claim.scheme);
        match &self.claim.relative_to {
            None => own,
            // Nothing over nothing is no measurement.
            Some(other) => own.zip(of(other)).map(|(own, other)| own / other).filter(|ratio| !ratio.is_nan()),
        }
    }

    /// What a threshold for all cases, or one for each, tells.
    fn told_by_threshold(&self, rows: &[usize]) -> Option<f64> {
        let per_case = self.claim.statistic == Statistic::ThresholdPerCase;
        let mut groups: BTreeMap<&str, Vec<(f64, bool)>> = BTreeMap::new();
        for &row in rows {
            let case = if per_case { self.runs.problem(row)[0] } else { ALL };
            groups.entry(case).or_default().push((self.runs.macro_step(row), self.value[row] > 0.5));
        }
        share_told_by_threshold(groups.into_values())
    }

    /// The runs of the two rows, to be compared setting by setting.
    fn paired(&self, rows: &[usize]) -> impl Iterator<Item = PairedRun<'a>> {
        rows.iter().map(|&row| PairedRun {
            problem: self.runs.problem(row),
            macro_step: if self.shares_steps { self.runs.macro_step(row) } else { 0.0 },
            is_other: self.runs.label(row) != self.claim.scheme,
            error: self.value[row],
            floor: self.floor[row],
        })
    }

    /// In how many settings the one row is better than the other.
    fn share(&self, rows: &[usize]) -> Share {
        Share::of(self.paired(rows), self.claim.apart.unwrap_or(0.0))
    }

    /// The factors between the two rows: one per case, set and macro step; at equal counts one per case and set.
    fn ratios(&self, rows: &[usize]) -> PairedRatios {
        if self.claim.at_equal.is_none() {
            return PairedRatios::of(self.paired(rows));
        }
        let ratios = ratios_at_equal_cost(rows.iter().map(|&row| Costed {
            problem: self.runs.problem(row),
            setting: [self.runs.macro_step(row), self.tolerance[row]],
            is_other: self.runs.label(row) != self.claim.scheme,
            cost: self.cost[row],
            error: self.value[row],
        }));
        PairedRatios { ratios, ..PairedRatios::default() }
    }
}

impl Claim {
    /// What is said of it when it was held against runs of an experiment.
    fn checked(
        &self,
        experiment: &str,
        quantity: String,
        (measured, interval): (Option<f64>, Option<[f64; 2]>),
        is_refuted: bool,
    ) -> CheckedClaim {
        CheckedClaim {
            experiment: experiment.to_owned(),
            id: self.id.clone(),
            by: self.by,
            text: self.text.clone(),
            quantity,
            measured,
            low: interval.map(|[low, _]| low),
            high: interval.map(|[_, high]| high),
            without_exact: None,
            expected: self.expect.to_string(),
            verdict: self.verdict(measured, is_refuted),
            finding: self.finding,
            superseded: self.superseded.clone(),
            variant_of: self.variant_of.clone(),
            numbers_known: self.numbers_known,
            runs: 0,
            failed: 0,
            run_ids: Vec::new(),
        }
    }

    /// What is measured, in words.
    fn quantity(&self) -> String {
        let (statistic, than) = match self.statistic {
            Statistic::ShareBetter => ("share of settings with less".to_owned(), "than"),
            Statistic::OneThreshold => ("share told by one macro step, of those with".to_owned(), ""),
            Statistic::ThresholdPerCase => ("share told by one macro step per case, of those with".to_owned(), ""),
            _ => (format!("{:?} of", self.statistic).to_lowercase(), "relative to"),
        };
        let relative = self.relative_to.as_ref().map(|other| format!(" {than} {other}")).unwrap_or_default();
        let equal = self.at_equal.as_ref().map(|equal| format!(" at equal {equal}")).unwrap_or_default();
        let without = self.without.as_ref().map(|word| format!(", without {word}")).unwrap_or_default();
        let step = self.macro_step_s.map(|step| format!(" at H = {} ms", step * 1e3)).unwrap_or_default();
        let problem = [("case", &self.case), ("set", &self.set)].map(|(key, value)| match value.as_deref() {
            None => String::new(),
            Some(ALL) => format!(", all {key}s"),
            Some(value) => format!(", {key} {value}"),
        });
        let above = self.above.map(|above| format!(" > {above}")).unwrap_or_default();
        let name = self.metric.name();
        let metric = if self.is_by_magnitude() { format!("|{name}|") } else { name.to_owned() };
        let within = self.within.map(|within| format!(" ≤ {within}, completed,")).unwrap_or_default();
        let [scheme, problem, whom] = [&*self.scheme, &problem.concat(), self.witnesses_in_words()];
        let apart = self.apart.map(|apart| format!(", {} % apart", 100.0 * apart)).unwrap_or_default();
        format!("{statistic} {metric}{above}{within} of {scheme}{relative}{apart}{equal}{without}{step}{problem}{whom}")
    }

    /// Why a run can be left out.
    fn why_left_out(&self) -> &'static str {
        match self.metric {
            Finding::Completed | Finding::Failed => "skipped, timed out or failed by a defect",
            _ if self.within.is_some() => "skipped, timed out or failed by a defect",
            Finding::FailedAt => "not failed",
            _ if self.statistic == Statistic::Order => "without a value, or within the reference's uncertainty",
            _ => "without a value",
        }
    }
}

impl Statistic {
    /// Of pairs (macro step, value).
    fn of(self, pairs: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
        if self == Statistic::Order {
            return order_of_medians(pairs);
        }
        let pool = Pool::of(pairs.map(|(_, value)| value));
        match self {
            Statistic::Median => pool.median(),
            Statistic::Min => pool.range().map(|[least, _]| least),
            Statistic::Max => pool.range().map(|[_, most]| most),
            Statistic::Mean => pool.mean(),
            Statistic::Order | Statistic::ShareBetter | Statistic::OneThreshold | Statistic::ThresholdPerCase => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Verdict;
    use std::path::Path;

    #[test]
    fn statistics_over_phases_and_steps() {
        let of = |statistic: Statistic| {
            statistic.of([(1.0, 2.0), (1.0, 4.0), (2.0, 6.0), (2.0, 6.0), (2.0, 60.0)].into_iter())
        };
        assert_eq!((of(Statistic::Median), of(Statistic::Max)), (Some(6.0), Some(60.0)));
        approx::assert_relative_eq!(of(Statistic::Order).unwrap(), 1.0, epsilon = 1e-12);
        assert_eq!(Statistic::Min.of(std::iter::empty()), None);
    }

    /// A table of rows, each with its end, below a header.
    fn table(header: &str, rows: &str) -> RunTable {
        RunTable::parse(Path::new("runs.csv"), &format!("{header}\n{rows}")).unwrap()
    }

    /// A claim with these keys beside those that all have, checked against a table.
    fn check_in(table: &RunTable, keys: &str) -> CheckedClaim {
        let all = "id = \"c\"\nby = \"ours\"\ntext = \"t\"\nscheme = \"x\"\nfinding = \"reproduced\"";
        let expect = if keys.contains("expect") { "" } else { "expect = \">= 0\"" };
        check(&toml::from_str(&format!("{all}\n{expect}\n{keys}")).unwrap(), "e", table, &|problem| problem.concat())
            .unwrap()
    }

    /// The same against rows of a case, a set, a macro step, an outcome and an error, all of one label.
    fn checked(keys: &str, rows: &[&str]) -> CheckedClaim {
        let row = |(id, row): (usize, &&str)| format!("{id},x,{row},\n");
        let rows: String = rows.iter().enumerate().map(row).collect();
        check_in(&table("run_id,label,case,set,macro_step_s,outcome,velocity_error_rms_m_s,outcome_at_s", &rows), keys)
    }

    #[test]
    fn an_order_is_that_of_the_runs_that_completed_and_says_how_many_did_not() {
        let rows = [
            "box,,0.001,completed,1.0",
            "box,,0.002,completed,2.0",
            "box,,0.004,completed,4.0",
            "box,,0.004,diverged,1e9",
            "box,,0.008,diverged,1e9",
        ];
        let table_of = |header: &str| {
            let rows: String = rows.iter().enumerate().map(|(id, row)| format!("{id},x,{row},\n")).collect();
            table(header, &rows)
        };
        let header = "run_id,label,case,set,macro_step_s,outcome,force_error_rms_n,outcome_at_s";
        let claim = check_in(&table_of(header), "metric = \"force_error_rms_n\"\nstatistic = \"order\"");
        approx::assert_relative_eq!(claim.measured.unwrap(), 1.0, epsilon = 1e-12);
        assert!(claim.quantity.ends_with("(2 of 5 failed)"), "{}", claim.quantity);
        assert_eq!(claim.run_ids, ["0", "1", "2"]);
        assert_eq!(claim.failed, 2);
        // A step that fails between two that hold leaves no order.
        let unsteady = rows[4].replace("0.008", "0.002");
        let text = [&rows[..4], &[&unsteady]].concat();
        let text: String = text.iter().enumerate().map(|(id, row)| format!("{id},x,{row},\n")).collect();
        let claim = check_in(&table(header, &text), "metric = \"force_error_rms_n\"\nstatistic = \"order\"");
        assert_eq!(claim.verdict, Verdict::NotReproduced);
    }

    #[test]
    fn an_order_has_an_interval_over_phases_and_leaves_out_what_the_reference_cannot_tell_from_zero() {
        let header = "run_id,label,case,set,macro_step_s,phase,outcome,position_error_rms_m,outcome_at_s,\
                      reference_position_uncertainty_m";
        let mut rows = String::new();
        // Second order down to an uncertainty of 1e-6 m, where the errors stay; every phase has a constant of its own.
        for (phase, constant) in [(0.25, 0.5), (0.5, 1.0), (0.75, 1.5), (1.0, 3.0)] {
            for step in [1e-3, 2e-3, 4e-3, 8e-3_f64] {
                let error = (constant * step * step).max(1e-6);
                rows += &format!("r,x,box,,{step},{phase},completed,{error},,1e-6\n");
            }
        }
        let order = check_in(&table(header, &rows), "metric = \"position_error_rms_m\"\nstatistic = \"order\"");
        // Two runs lie at 1e-6 m: those of 1 ms with constants of at most 1.
        assert!(order.quantity.contains("(2 of 16 runs left out"), "{}", order.quantity);
        let (low, high) = (order.low.unwrap(), order.high.unwrap());
        assert!(low <= 2.0 && 2.0 <= high && low < order.measured.unwrap() + 1e-12, "{low} {high}");
        assert!(high - low < 0.8, "{low} {high}");
    }

    #[test]
    fn at_equal_counts_each_case_has_one_ratio_whatever_the_macro_steps_and_tolerances() {
        let header =
            "run_id,label,case,set,macro_step_s,step_tolerance,outcome,velocity_error_rms_m_s,outcome_at_s,exchanges";
        let mut rows = String::new();
        for (case, factor) in [("a", 0.5), ("b", 2.0), ("c", 3.0)] {
            for count in [100.0, 400.0_f64] {
                rows += &format!("r,y,{case},,{},,completed,{},,{count}\n", 1.0 / count, 1e4 / (count * count));
            }
            // One macro step, two tolerances, and a run that went astray.
            for (tolerance, count) in [(0.1, 150.0), (0.01, 300.0_f64)] {
                let error = factor * 1e4 / (count * count);
                rows += &format!("r,x,{case},,0.005,{tolerance},completed,{error},,{count}\n");
            }
            rows += &format!("r,x,{case},,0.005,0.001,diverged,1e9,,350\n");
        }
        let keys = "relative_to = \"y\"\nat_equal = \"exchanges\"\ncase = \"all\"\nmetric = \"velocity_error_rms_m_s\"\nexpect = \"<= 1\"";
        let checked = check_in(&table(header, &rows), keys);
        approx::assert_relative_eq!(checked.measured.unwrap(), 2.0, max_relative = 1e-12);
        assert_eq!(
            checked.quantity,
            "median of velocity_error_rms_m_s of x relative to y at equal exchanges, all cases \
             (3 of 9 of x failed, which is worse than every number)"
        );
    }

    /// Within budgets it is the best forms of two ways that are compared, each case once.
    #[test]
    fn within_budgets_the_best_forms_of_two_ways_are_compared_case_by_case() {
        let header = "run_id,label,case,set,macro_step_s,outcome,ended_at_s,macro_steps,mechanics_micro_steps,\
                      velocity_error_rms_m_s,outcome_at_s";
        let mut rows = String::new();
        for (case, factor) in [("a", 0.5), ("b", 2.0), ("c", 3.0)] {
            for (label, steps, error) in
                [("x/1", 100, 4.0 * factor), ("x/4", 400, factor), ("y/1", 100, 1.0), ("z/1", 100, 0.1)]
            {
                rows += &format!("r,{label},{case},,0.01,completed,1,100,{steps},{error},\n");
            }
        }
        let of = |keys: &str| {
            let keys = format!("{keys}\ncase = \"all\"\nmetric = \"velocity_error_rms_m_s\"");
            check_in(&table(header, &rows), &keys)
        };
        let ratio = of("relative_to = \"y\"\nat_equal = [100, 400]");
        assert_eq!((ratio.measured, ratio.runs), (Some(2.0), 12));
        assert_eq!(of("relative_to = \"y\"\nat_equal = [[100, 100]]").measured, Some(8.0));
        let share = "relative_to = \"all\"\nwithout = \"z\"\nwithin = 1.0\nstatistic = \"mean\"\nat_equal = [100, 400]";
        assert_eq!(of(share).measured, Some(1.0 / 3.0));
        assert_eq!(of(&share.replace("without = \"z\"\n", "")).measured, Some(0.0));
    }

    /// Energy created is not less than energy lost.
    #[test]
    fn what_may_be_below_zero_is_compared_by_its_magnitude() {
        let header = "run_id,label,case,set,macro_step_s,outcome,interface_residual_j,outcome_at_s";
        let mut rows = String::new();
        for (step, own, other) in [(1e-3, -2.8, 1.0), (2e-3, -11.2, -4.0)] {
            rows += &format!("r,x,box,,{step},completed,{own},\nr,y,box,,{step},completed,{other},\n");
        }
        let metric = "metric = \"interface_residual_j\"\n";
        let of = |keys: &str| check_in(&table(header, &rows), &format!("{metric}{keys}"));
        let ratio = of("relative_to = \"y\"\nexpect = \"<= 0.1\"\nmacro_step_s = 1e-3");
        assert_eq!((ratio.measured, ratio.verdict), (Some(2.8), Verdict::NotReproduced));
        assert_eq!(ratio.quantity, "median of |interface_residual_j| of x relative to y at H = 1 ms");
        assert_eq!(of("relative_to = \"y\"\nstatistic = \"share-better\"").measured, Some(0.0));
        // Of what has no uncertainty no order is known.
        assert_eq!(of("statistic = \"order\"").measured, None);
        // Alone it keeps its sign.
        assert_eq!(of("statistic = \"max\"").measured, Some(-2.8));
    }

    #[test]
    fn a_share_counts_settings_and_says_how_many_there_are() {
        let header =
            "run_id,label,case,set,macro_step_s,outcome,force_error_rms_n,outcome_at_s,reference_force_uncertainty_n";
        let mut rows = String::new();
        // Better, worse, worse because it fails, both unknown, both failed, without a reference.
        for (set, own, other) in [
            ("m=1", "completed,1.0", "completed,2.0"),
            ("m=2", "completed,3.0", "completed,2.0"),
            ("m=3", "diverged,0.1", "completed,2.0"),
            ("m=4", "completed,0.01", "completed,0.02"),
            ("m=5", "diverged,1.0", "solver-failed,2.0"),
            ("m=6", "skipped,", "skipped,"),
        ] {
            for (label, outcome) in [("x", own), ("y", other)] {
                rows += &format!("r,{label},box,{set},0.001,{outcome},,0.05\n");
            }
        }
        let keys = "relative_to = \"y\"\nset = \"all\"\nmetric = \"force_error_rms_n\"\nstatistic = \"share-better\"";
        let claim = check_in(&table(header, &rows), keys);
        approx::assert_relative_eq!(claim.measured.unwrap(), 1.0 / 3.0, max_relative = 1e-14);
        assert!(claim.low.unwrap() < 0.1 && claim.high.unwrap() > 0.7, "{:?} {:?}", claim.low, claim.high);
        assert_eq!(
            claim.quantity,
            "share of settings with less force_error_rms_n of x than y, all sets: 1 of 3, and 2 ties \
             (2 of 6 of x failed; 1 of 6 of y failed; 2 of 12 runs left out: without a value)"
        );
        let completed = check_in(&table(header, &rows), "set = \"all\"\nmetric = \"completed\"\nstatistic = \"mean\"");
        assert_eq!((completed.measured, completed.runs), (Some(0.6), 5));
    }

    #[test]
    fn a_threshold_is_chosen_among_the_runs_that_have_the_metric() {
        let rows = [
            "a,,0.001,completed,1.0",
            "a,,0.002,diverged,1.0",
            "b,,0.001,completed,1.0",
            "b,,0.002,completed,0.0",
            "b,,0.004,diverged,",
        ];
        let told = |statistic: &str| {
            let claim = checked(
                &format!("case = \"all\"\nmetric = \"velocity_error_rms_m_s\"\nstatistic = \"{statistic}\""),
                &rows,
            );
            (claim.measured, claim.runs)
        };
        assert_eq!(told("one-threshold"), (Some(0.75), 4));
        assert_eq!(told("threshold-per-case"), (Some(1.0), 4));
    }

    #[test]
    fn a_usable_run_completes_within_the_bound() {
        let rows = [
            "box,,0.001,completed,0.05",
            "box,,0.001,completed,-0.1",
            "box,,0.001,completed,0.2",
            "box,,0.001,diverged,0.01",
            "box,,0.001,completed,",
            "box,,0.001,skipped,",
        ];
        let claim = checked("metric = \"velocity_error_rms_m_s\"\nwithin = 0.1\nstatistic = \"mean\"", &rows);
        assert_eq!((claim.measured, claim.runs), (Some(0.4), 5));
        assert!(
            claim.quantity.starts_with("mean of velocity_error_rms_m_s ≤ 0.1, completed, of x"),
            "{}",
            claim.quantity
        );
    }

    #[test]
    fn a_claim_selects_its_case_and_its_set() {
        let rows = ["box,,0.001,completed,1.0", "box,m=2,0.001,completed,3.0", "ball,,0.001,completed,8.0"];
        let measured = |keys: &str| checked(&format!("metric = \"velocity_error_rms_m_s\"\n{keys}"), &rows).measured;
        assert_eq!(measured("case = \"box\"\nset = \"m=2\""), Some(3.0));
        assert_eq!(measured("case = \"box\"\nset = \"\""), Some(1.0));
        assert_eq!(measured("case = \"ball\""), Some(8.0));
        assert_eq!(measured("case = \"box\"\nset = \"all\""), Some(2.0));
        assert_eq!(measured("case = \"all\"\nset = \"all\""), Some(3.0));
        let claim = checked("metric = \"velocity_error_rms_m_s\"\ncase = \"all\"\nset = \"m=2\"", &rows);
        assert!(claim.quantity.ends_with(", all cases, set m=2"), "{}", claim.quantity);
    }

    #[test]
    fn a_median_has_an_interval_over_cases_and_is_told_without_those_in_which_the_model_is_exact() {
        let header = "run_id,label,case,set,macro_step_s,phase,outcome,velocity_error_rms_m_s,outcome_at_s,model_exact";
        let mut rows = String::new();
        for (case, error) in [("a", 1.0), ("b", 2.0), ("c", 3.0), ("d", 50.0)] {
            for phase in [0.5, 1.0] {
                // The model of another scheme is exact on case d.
                let exact = case == "d";
                rows += &format!("{case}{phase},x,{case},,0.001,{phase},completed,{error},,false\n");
                rows += &format!("{case}{phase}y,y,{case},,0.001,{phase},completed,{},,{exact}\n", 2.0 * error);
            }
        }
        let runs = table(header, &rows);
        let checked =
            |keys: &str| check_in(&runs, &format!("metric = \"velocity_error_rms_m_s\"\ncase = \"all\"\n{keys}"));
        let median = checked("");
        assert_eq!((median.measured, median.without_exact), (Some(2.5), Some(2.0)));
        // Of four cases all may be the first or the last.
        assert!(median.low.unwrap() < 2.0 && median.high.unwrap() > 3.0, "{:?} {:?}", median.low, median.high);
        // A ratio that is the same in every case is certain.
        let ratio = checked("relative_to = \"y\"");
        assert_eq!((ratio.measured, ratio.low, ratio.high), (Some(0.5), Some(0.5), Some(0.5)));
        let largest = checked("statistic = \"max\"");
        assert_eq!((largest.measured, largest.low, largest.without_exact), (Some(50.0), None, Some(3.0)));
    }

    /// Whatever is asked: a run that took too long has no value, and one that could not be solved has not held.
    #[test]
    fn an_outcome_counts_by_its_class_in_every_quantity() {
        let header = "run_id,label,case,set,macro_step_s,outcome,velocity_error_rms_m_s,outcome_at_s\n";
        let rows = [
            "0,x,box,,0.001,timeout,9.0,0.1\n",
            "1,x,box,,0.001,panicked,8.0,\n",
            "2,x,box,,0.001,solver-failed,1.0,0.2\n",
        ];
        let all = table(header.trim_end(), &rows.concat());
        let of = |metric: &str| check_in(&all, &format!("metric = \"{metric}\"\nstatistic = \"max\""));
        let alive = of("velocity_error_rms_m_s");
        assert_eq!((alive.measured, alive.failed, alive.verdict), (None, 1, Verdict::NotReproduced));
        assert_eq!(of("velocity_error_rms_m_s\"\nwitnesses = \"all").run_ids, ["2"]);
        assert_eq!(["failed", "completed", "failed_at_s"].map(|name| of(name).measured), [1.0, 0.0, 0.2].map(Some));
        let silent = table(header.trim_end(), &rows[..2].concat());
        assert_eq!(check_in(&silent, "metric = \"velocity_error_rms_m_s\"").verdict, Verdict::NotMeasured);
    }

    /// A hold that breaks down misses no touch-down.
    #[test]
    fn a_run_that_failed_is_no_witness_of_how_good_it_is() {
        let rows = [
            "box,,0.001,completed,0.1",
            "box,,0.001,completed,0.3",
            "box,,0.001,diverged,0.0",
            "box,,0.001,timeout,9.0",
        ];
        let of = |keys: &str| checked(&format!("metric = \"velocity_error_rms_m_s\"\n{keys}"), &rows);
        for (statistic, measured) in [("median", 0.2), ("min", 0.1), ("max", 0.3), ("mean", 0.2)] {
            let good = of(&format!("statistic = \"{statistic}\"\nexpect = \"<= 1\""));
            assert_eq!((good.verdict, good.failed), (Verdict::NotReproduced, 1), "{statistic}");
            approx::assert_relative_eq!(good.measured.unwrap(), measured, max_relative = 1e-14);
            assert!(good.quantity.contains("(1 of 4 failed, which is worse than every number; 1 of 4 runs left out"));
            assert_eq!(good.run_ids, ["0", "1", "2"]);
            // That it is bad is told by those that came to their end.
            let bad = of(&format!("statistic = \"{statistic}\"\nexpect = \">= 0.1\""));
            assert_eq!((bad.verdict, bad.run_ids), (Verdict::Reproduced, vec!["0".to_owned(), "1".to_owned()]));
            let survivors = of(&format!("statistic = \"{statistic}\"\nexpect = \"<= 1\"\nwitnesses = \"completed\""));
            assert_eq!((survivors.verdict, survivors.measured), (Verdict::Reproduced, good.measured));
            assert!(survivors.quantity.contains(", completed runs only (1 of 4 failed;"), "{}", survivors.quantity);
        }
        let before = of("statistic = \"min\"\nwitnesses = \"all\"\nexpect = \"<= 0\"");
        assert_eq!((before.verdict, before.measured, before.runs), (Verdict::Reproduced, Some(0.0), 3));
        assert!(before.quantity.contains(", before it fails (1 of 4 failed;"), "{}", before.quantity);
        let share = of("above = 0.2\nstatistic = \"mean\"\nexpect = \"<= 0.9\"");
        assert_eq!((share.verdict, share.measured), (Verdict::NotReproduced, Some(0.5)));
    }

    #[test]
    fn a_time_out_is_no_failure() {
        let rows = ["box,,0.001,completed,0.1", "box,,0.001,timeout,9.0", "box,,0.001,panicked,9.0"];
        let claim = checked("metric = \"velocity_error_rms_m_s\"\nstatistic = \"max\"\nexpect = \"<= 1\"", &rows);
        assert_eq!((claim.verdict, claim.measured, claim.failed), (Verdict::Reproduced, Some(0.1), 0));
        assert!(claim.quantity.ends_with("(2 of 3 runs left out: without a value)"), "{}", claim.quantity);
    }

    #[test]
    fn in_a_ratio_a_phase_that_failed_is_infinite_and_two_rows_that_fail_have_none() {
        let header = "run_id,label,case,set,macro_step_s,outcome,velocity_error_rms_m_s,outcome_at_s";
        let of = |own: [&str; 2], other: [&str; 2], keys: &str| {
            let rows = [("x", own), ("y", other)]
                .map(|(label, rows)| rows.map(|row| format!("r,{label},box,,0.001,{row},\n")).concat());
            let keys = format!("metric = \"velocity_error_rms_m_s\"\nrelative_to = \"y\"\n{keys}");
            check_in(&table(header, &rows.concat()), &keys)
        };
        let [lived, died] = [["completed,1.0", "completed,2.0"], ["completed,1.0", "diverged,1e9"]];
        let [better, worse] = ["expect = \"<= 0.5\"", "expect = \">= 0.2\""];
        let of_all = |own, other| {
            let checked = [better, worse].map(|keys| of(own, other, keys));
            (checked[0].measured, checked.map(|claim| claim.verdict))
        };
        let [holds, fails] = [Verdict::Reproduced, Verdict::NotReproduced];
        assert_eq!(of_all(lived, lived), (Some(1.0), [fails, holds]));
        assert_eq!(of_all(died, lived), (Some(f64::INFINITY), [fails, holds]));
        // What the baseline made before it diverged is no measure of it, and that it did no praise of none.
        assert_eq!(of_all(lived, died), (Some(0.0), [holds, fails]));
        assert_eq!(of_all(died, died), (None, [Verdict::NotMeasured; 2]));
        let quantity = of(died, died, better).quantity;
        assert!(
            quantity.ends_with(", 1 left out in which both fail (1 of 2 of x failed; 1 of 2 of y failed)"),
            "{quantity}"
        );
        let completed = of(died, lived, "expect = \"<= 0.7\"\nwitnesses = \"completed\"");
        assert_eq!((completed.measured, completed.verdict), (Some(1.0 / 1.5), holds));
    }

    /// A crane of 10 kN, a ball of 1 N: the ratio of the medians over both is that of no machine.
    #[test]
    fn the_median_of_ratios_is_over_machines_and_macro_steps_and_not_a_ratio_of_medians() {
        let header = "run_id,label,case,set,macro_step_s,phase,outcome,force_error_rms_n,outcome_at_s";
        let mut rows = String::new();
        for (case, step, errors) in [
            ("ball", 1e-3, [1.0, 1.0]),
            ("ball", 2e-3, [2.0, 2.0]),
            ("box", 1e-3, [90.0, 100.0]),
            ("box", 2e-3, [110.0, 100.0]),
            ("crane", 1e-3, [4e4, 1e4]),
            ("crane", 2e-3, [4e4, 1e4]),
        ] {
            for (label, error) in ["x", "y"].into_iter().zip(errors) {
                rows += &format!(
                    "r,{label},{case},,{step},0.5,completed,{error},\nr,{label},{case},,{step},1,completed,{error},\n"
                );
            }
        }
        let of = |rows: &str, keys: &str| {
            let keys = format!("metric = \"force_error_rms_n\"\nrelative_to = \"y\"\ncase = \"all\"\n{keys}");
            check_in(&table(header, rows), &keys)
        };
        let median = of(&rows, "");
        approx::assert_relative_eq!(median.measured.unwrap(), 1.05, max_relative = 1e-14);
        assert!(median.quantity.ends_with("all cases: the ratio in each of 6 settings"), "{}", median.quantity);
        // Machines are drawn whole: one that is drawn twice counts twice.
        assert_eq!((median.low, median.high), (Some(1.0), Some(4.0)));
        let of_statistic = |statistic: &str| of(&rows, &format!("statistic = \"{statistic}\"")).measured.unwrap();
        assert_eq!([of_statistic("max"), of_statistic("min")], [4.0, 0.9]);
        // Rows with one macro step each are compared though it is not the same.
        let own_steps: String =
            rows.lines().filter(|row| row.contains(",x,") == row.contains(",0.001,")).collect::<Vec<_>>().join("\n");
        assert_eq!(of(&own_steps, "").measured, Some(0.9));
    }

    /// Of what is best at one or has a sign, what is good lies on either side.
    #[test]
    fn what_a_run_without_error_would_meet_speaks_well_of_it() {
        let of = |metric: &str, keys: &str| {
            let header = format!("run_id,label,case,set,macro_step_s,outcome,{metric},outcome_at_s");
            let rows = "0,x,box,,0.001,completed,0.95,\n1,x,box,,0.001,solver-failed,0.95,0.1\n";
            check_in(&table(&header, rows), &format!("metric = \"{metric}\"\n{keys}")).verdict
        };
        assert_eq!(of("touch_down_peak_ratio", "expect = \">= 0.9\""), Verdict::NotReproduced);
        assert_eq!(of("touch_down_peak_ratio", "expect = \"<= 1.1\""), Verdict::NotReproduced);
        assert_eq!(of("touch_down_peak_ratio", "expect = \"<= 0.96\""), Verdict::Reproduced);
        assert_eq!(of("model_defect_rank", "expect = \">= 0.9\""), Verdict::NotReproduced);
        assert_eq!(of("interface_residual_j", "expect = \">= -1\""), Verdict::NotReproduced);
        assert_eq!(of("interface_residual_j", "expect = \">= 0.5\""), Verdict::Reproduced);
        // That a run fails as predicted is what is asked.
        let predicted = "statistic = \"mean\"\nexpect = \"<= 0.95\"";
        assert_eq!(of("completed_as_predicted", predicted), Verdict::Reproduced);
    }

    #[test]
    fn a_run_that_was_never_made_does_not_count_as_one_that_stays_stable() {
        let rows = ["box,,0.001,skipped,", "box,,0.001,timeout,", "box,,0.001,diverged,"];
        let mean = checked("metric = \"failed\"\nstatistic = \"mean\"", &rows);
        assert_eq!(mean.measured, Some(1.0));
        assert!(mean.quantity.contains("2 of 3 runs left out"), "{}", mean.quantity);
        let never = checked("metric = \"failed\"\nstatistic = \"max\"", &rows[..2]);
        assert_eq!((never.measured, never.verdict), (None, Verdict::NotMeasured));
    }
}

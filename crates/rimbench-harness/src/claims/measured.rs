//! What was measured of a claim.

use super::ALL;
use super::declared::{Claim, Statistic, Verdict};
use super::table::CheckedClaim;
use crate::equal_cost::{self, CostedRun};
use rimbench_core::error::Result;
use rimbench_results::results_table::{ResultsTable, uncertainty_of};
use rimbench_statistics::{bootstrap_interval, median, order_of_convergence};
use std::collections::{BTreeMap, BTreeSet};

/// Outcomes that say nothing about whether a run diverges.
const NO_ANSWER: [&str; 3] = ["skipped", "timeout", "panicked"];

/// Holds a claim against the rows of an experiment.
pub(super) fn check(claim: &Claim, experiment: &str, runs: &ResultsTable) -> Result<CheckedClaim> {
    let mut basis = Basis::default();
    let mut samples = samples(claim, Of::Own, &claim.scheme, runs, &mut basis)?;
    if let Some(other) = &claim.relative_to {
        samples.extend(self::samples(claim, Of::Other, other, runs, &mut basis)?);
    }
    let measured = claim.measured(&samples);
    let interval = match claim.statistic {
        Statistic::Median if claim.at_equal.is_some() => {
            let ratios: Vec<Vec<f64>> = ratios(&samples).into_iter().map(|ratio| vec![ratio]).collect();
            bootstrap_interval(&ratios, |drawn| median(drawn.to_vec()))
        }
        Statistic::Median | Statistic::Order => claim.interval(&samples),
        _ => None,
    };
    let without_exact = match samples.iter().any(|sample| sample.exact) {
        true => claim.measured(&samples.iter().filter(|sample| !sample.exact).cloned().collect::<Vec<_>>()),
        false => None,
    };
    let verdict = match measured {
        None => Verdict::NotMeasured,
        Some(value) if claim.expect.at_least && value >= claim.expect.bound => Verdict::Reproduced,
        Some(value) if !claim.expect.at_least && value <= claim.expect.bound => Verdict::Reproduced,
        Some(_) => Verdict::NotReproduced,
    };
    let statistic = format!("{:?}", claim.statistic).to_lowercase();
    let relative = claim.relative_to.as_ref().map(|other| format!(" relative to {other}")).unwrap_or_default();
    let equal = claim.at_equal.as_ref().map(|counter| format!(" at equal {counter}")).unwrap_or_default();
    let step = claim.macro_step_s.map(|step| format!("{equal} at H = {} ms", step * 1e3)).unwrap_or(equal);
    let problem = [("case", &claim.case), ("set", &claim.set)].map(|(key, value)| match value.as_deref() {
        None => String::new(),
        Some(ALL) => format!(", all {key}s"),
        Some(value) => format!(", {key} {value}"),
    });
    let left_out = match basis.left_out {
        0 => String::new(),
        count => format!(" ({count} of {} runs left out: {})", basis.run_ids.len() + count, claim.why_left_out()),
    };
    Ok(CheckedClaim {
        experiment: experiment.to_owned(),
        id: claim.id.clone(),
        by: claim.by,
        text: claim.text.clone(),
        quantity: format!(
            "{statistic} of {} of {}{relative}{step}{}{left_out}",
            claim.metric,
            claim.scheme,
            problem.concat()
        ),
        measured,
        low: interval.map(|[low, _]| low),
        high: interval.map(|[_, high]| high),
        without_exact,
        expected: claim.expect.to_string(),
        verdict,
        finding: claim.finding,
        superseded: claim.superseded.clone(),
        runs: basis.run_ids.len(),
        run_ids: basis.run_ids,
    })
}

/// What a measurement rests on.
#[derive(Default)]
struct Basis {
    run_ids: Vec<String>,
    left_out: usize,
}

/// Whose run it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    Own,
    Other,
}

/// What one run has to say.
#[derive(Debug, Clone)]
struct Sample {
    of: Of,
    /// Case, set, phase.
    origin: [String; 3],
    /// Whether the model of some run of its case and set is the mechanics itself.
    exact: bool,
    step: f64,
    /// Where the step is controlled; else 0.
    tolerance: f64,
    /// The counter that is to be equal, if any; else 0.
    cost: f64,
    value: f64,
}

/// The claim's metric over the runs of one scheme row.
fn samples(claim: &Claim, of: Of, label: &str, runs: &ResultsTable, basis: &mut Basis) -> Result<Vec<Sample>> {
    let (case, set) = (runs.column("case")?, runs.column("set")?);
    let is = |row: usize, column: usize, wanted: &Option<String>| {
        wanted.as_deref().is_none_or(|wanted| wanted == ALL || runs.text(row, column) == wanted)
    };
    let (id, step, outcome) = (runs.column("run_id")?, runs.column("macro_step_s")?, runs.column("outcome")?);
    let value = match claim.metric.as_str() {
        "diverged" => outcome,
        "diverged_at_s" => runs.column("outcome_at_s")?,
        metric => runs.column(metric)?,
    };
    let [phase, exact, tolerance] = ["phase", "model_exact", "step_tolerance"].map(|name| runs.column(name).ok());
    // The counters stand behind the settings, of which one has the same name as a counter.
    let cost = claim.at_equal.as_ref().map(|counter| runs.last_column(counter)).transpose()?;
    let or_zero = |row: usize, column: Option<usize>| column.map_or(0.0, |column| runs.number(row, column));
    let uncertainty = uncertainty_of(&claim.metric).and_then(|name| runs.column(name).ok());
    // Of an error no larger than what the reference may be wrong by, nothing is known but that it is small.
    let unknown = |row: usize, error: f64| uncertainty.is_some_and(|column| error <= runs.number(row, column));
    let problem = |row: usize| (runs.text(row, case), runs.text(row, set));
    let is_exact = |&row: &usize| exact.is_some_and(|exact| runs.text(row, exact) == "true");
    let exact: BTreeSet<_> = (0..runs.len()).filter(is_exact).map(problem).collect();
    let mut samples = Vec::new();
    for row in runs.rows_where(runs.column("label")?, label) {
        if !(claim.is_about(runs.number(row, step)) && is(row, case, &claim.case) && is(row, set, &claim.set)) {
            continue;
        }
        let ended = runs.text(row, outcome);
        let number = match claim.metric.as_str() {
            "diverged" if NO_ANSWER.contains(&ended) => f64::NAN,
            "diverged" => f64::from(ended == "diverged"),
            "diverged_at_s" if ended != "diverged" => f64::NAN,
            // What a run that did not complete has is no point on the way to H = 0.
            _ if (claim.statistic == Statistic::Order || cost.is_some()) && ended != "completed" => f64::NAN,
            _ if claim.statistic == Statistic::Order && unknown(row, runs.number(row, value)) => f64::NAN,
            _ => runs.number(row, value),
        };
        if number.is_nan() {
            basis.left_out += 1;
        } else {
            basis.run_ids.push(runs.text(row, id).to_owned());
            let phase = phase.map_or("", |phase| runs.text(row, phase));
            samples.push(Sample {
                of,
                origin: [runs.text(row, case), runs.text(row, set), phase].map(str::to_owned),
                exact: exact.contains(&problem(row)),
                step: runs.number(row, step),
                tolerance: Some(or_zero(row, tolerance)).filter(|value| value.is_finite()).unwrap_or(0.0),
                cost: or_zero(row, cost),
                value: number,
            });
        }
    }
    Ok(samples)
}

/// What the two rows have to say at equal counts, one ratio per case and set.
fn ratios<'a>(samples: impl IntoIterator<Item = &'a Sample>) -> Vec<f64> {
    let run = |sample: &'a Sample| CostedRun {
        problem: &sample.origin[..2],
        setting: [sample.step, sample.tolerance],
        is_other: sample.of == Of::Other,
        cost: sample.cost,
        error: sample.value,
    };
    equal_cost::ratios(samples.into_iter().map(run))
}

impl Claim {
    /// The statistic of the samples, or the ratio of the two schemes' ones.
    fn measured<'a>(&self, samples: impl IntoIterator<Item = &'a Sample> + Clone) -> Option<f64> {
        if self.at_equal.is_some() {
            return self.statistic.of(ratios(samples).into_iter().map(|ratio| (0.0, ratio)).collect());
        }
        let of = |wanted: Of| {
            let own = samples.clone().into_iter().filter(|sample| sample.of == wanted);
            self.statistic.of(own.map(|sample| (sample.step, sample.value)).collect())
        };
        match self.relative_to {
            None => of(Of::Own),
            // Nothing over nothing is no measurement.
            Some(_) => of(Of::Own).zip(of(Of::Other)).map(|(own, other)| own / other).filter(|ratio| !ratio.is_nan()),
        }
    }

    /// How far it can be trusted: cases are drawn anew, or phases where there is one case only.
    fn interval(&self, samples: &[Sample]) -> Option<[f64; 2]> {
        let problems: BTreeSet<_> = samples.iter().map(|sample| &sample.origin[..2]).collect();
        let parts = if problems.len() > 1 { 2 } else { 3 };
        let mut witnesses: BTreeMap<_, Vec<&Sample>> = BTreeMap::new();
        for sample in samples {
            witnesses.entry(&sample.origin[..parts]).or_default().push(sample);
        }
        let witnesses: Vec<Vec<&Sample>> = witnesses.into_values().collect();
        bootstrap_interval(&witnesses, |drawn| self.measured(drawn.iter().copied()))
    }
}

impl Claim {
    /// Why a run can be left out.
    fn why_left_out(&self) -> &'static str {
        match self.metric.as_str() {
            "diverged" => "skipped, timed out or failed by a defect",
            "diverged_at_s" => "not diverged",
            _ if self.statistic == Statistic::Order => {
                "not completed, without a value, or within the reference's uncertainty"
            }
            _ if self.at_equal.is_some() => "not completed, or without a value",
            _ => "without a value",
        }
    }
}

impl Statistic {
    /// Of pairs (macro step, value).
    fn of(self, pairs: Vec<(f64, f64)>) -> Option<f64> {
        let values: Vec<f64> = pairs.iter().map(|(_, value)| *value).collect();
        match self {
            _ if values.is_empty() => None,
            Statistic::Median => median(values),
            Statistic::Min => values.into_iter().reduce(f64::min),
            Statistic::Max => values.into_iter().reduce(f64::max),
            Statistic::Mean => Some(values.iter().sum::<f64>() / values.len() as f64),
            Statistic::Order => {
                let mut steps: Vec<f64> = pairs.iter().map(|(step, _)| *step).collect();
                // Rows of several cases or sets do not stand in the order of the steps.
                steps.sort_by(f64::total_cmp);
                steps.dedup();
                let of_step = |step: f64| pairs.iter().filter(|pair| pair.0 == step).map(|pair| pair.1).collect();
                let points: Vec<(f64, f64)> =
                    steps.into_iter().filter_map(|step| Some((step, median(of_step(step))?))).collect();
                order_of_convergence(&points)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_over_phases_and_steps() {
        let pairs = vec![(1.0, 2.0), (1.0, 4.0), (2.0, 6.0), (2.0, 6.0), (2.0, 60.0)];
        assert_eq!(Statistic::Median.of(pairs.clone()), Some(6.0));
        assert_eq!(Statistic::Max.of(pairs.clone()), Some(60.0));
        approx::assert_relative_eq!(Statistic::Order.of(pairs).unwrap(), 1.0, epsilon = 1e-12);
        assert_eq!(Statistic::Min.of(Vec::new()), None);
    }

    /// A table of rows, each with its end, below a header.
    fn table(header: &str, rows: &str) -> ResultsTable {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        std::fs::write(&path, format!("{header}\n{rows}")).unwrap();
        ResultsTable::read(&path).unwrap()
    }

    /// A claim with these keys beside those that all have, checked against a table.
    fn check_in(table: &ResultsTable, keys: &str) -> CheckedClaim {
        let all = "id = \"c\"\nby = \"ours\"\ntext = \"t\"\nscheme = \"x\"\nfinding = \"reproduced\"";
        let expect = if keys.contains("expect") { "" } else { "expect = \">= 0\"" };
        check(&toml::from_str(&format!("{all}\n{expect}\n{keys}")).unwrap(), "e", table).unwrap()
    }

    /// The same against rows of a case, a set, a macro step, an outcome and an error, all of one label.
    fn checked(keys: &str, rows: &[&str]) -> CheckedClaim {
        let row = |(id, row): (usize, &&str)| format!("{id},x,{row},\n");
        let rows: String = rows.iter().enumerate().map(row).collect();
        check_in(&table("run_id,label,case,set,macro_step_s,outcome,error,outcome_at_s", &rows), keys)
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
        let claim = checked("metric = \"error\"\nstatistic = \"order\"", &rows);
        approx::assert_relative_eq!(claim.measured.unwrap(), 1.0, epsilon = 1e-12);
        assert!(claim.quantity.contains("(2 of 5 runs left out: not completed"), "{}", claim.quantity);
        assert_eq!(claim.run_ids, ["0", "1", "2"]);
        assert_eq!(checked("metric = \"error\"\nstatistic = \"max\"", &rows).measured, Some(1e9));
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
        let header = "run_id,label,case,set,macro_step_s,step_tolerance,outcome,error,outcome_at_s,exchanges";
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
        let keys =
            "relative_to = \"y\"\nat_equal = \"exchanges\"\ncase = \"all\"\nmetric = \"error\"\nexpect = \"<= 1\"";
        let checked = check_in(&table(header, &rows), keys);
        approx::assert_relative_eq!(checked.measured.unwrap(), 2.0, max_relative = 1e-12);
        assert_eq!(
            checked.quantity,
            "median of error of x relative to y at equal exchanges, all cases (3 of 15 runs left out: not completed, or without a value)"
        );
    }

    #[test]
    fn a_claim_selects_its_case_and_its_set() {
        let rows = ["box,,0.001,completed,1.0", "box,m=2,0.001,completed,3.0", "ball,,0.001,completed,8.0"];
        let measured = |keys: &str| checked(&format!("metric = \"error\"\n{keys}"), &rows).measured;
        assert_eq!(measured("case = \"box\"\nset = \"m=2\""), Some(3.0));
        assert_eq!(measured("case = \"box\"\nset = \"\""), Some(1.0));
        assert_eq!(measured("case = \"ball\""), Some(8.0));
        assert_eq!(measured("case = \"box\"\nset = \"all\""), Some(2.0));
        assert_eq!(measured("case = \"all\"\nset = \"all\""), Some(3.0));
        let claim = checked("metric = \"error\"\ncase = \"all\"\nset = \"m=2\"", &rows);
        assert!(claim.quantity.ends_with(", all cases, set m=2"), "{}", claim.quantity);
    }

    #[test]
    fn a_median_has_an_interval_over_cases_and_is_told_without_those_in_which_the_model_is_exact() {
        let header = "run_id,label,case,set,macro_step_s,phase,outcome,error,outcome_at_s,model_exact";
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
        let checked = |keys: &str| check_in(&runs, &format!("metric = \"error\"\ncase = \"all\"\n{keys}"));
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

    #[test]
    fn a_run_that_was_never_made_does_not_count_as_one_that_stays_stable() {
        let rows = ["box,,0.001,skipped,", "box,,0.001,timeout,", "box,,0.001,diverged,"];
        let mean = checked("metric = \"diverged\"\nstatistic = \"mean\"", &rows);
        assert_eq!(mean.measured, Some(1.0));
        assert!(mean.quantity.contains("2 of 3 runs left out"), "{}", mean.quantity);
        let never = checked("metric = \"diverged\"\nstatistic = \"max\"", &rows[..2]);
        assert_eq!((never.measured, never.verdict), (None, Verdict::NotMeasured));
    }
}

//! The largest accurate macro step: case × scheme.

use super::store::Study;
use crate::vector::escaped;
use rimbench_core::cosim::OutcomeClass;
use rimbench_results::run_table::RunTable;
use rimbench_runs::Finding;
use rimbench_runs::metrics::USABLE;
use rimbench_statistics::Pool;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// What one scheme did on one case with one choice of options: by macro step, the errors of its runs by run id, or as
/// what they count.
type Tried = BTreeMap<u64, BTreeMap<String, Result<f64, OutcomeClass>>>;

/// One case with its parameters, one scheme.
type Pair = (String, String);

/// The section, or nothing if no study has runs of a scheme as it is.
pub(super) fn section(studies: &[Study]) -> String {
    let mut all: BTreeMap<Pair, BTreeMap<Vec<String>, Tried>> = BTreeMap::new();
    for runs in studies.iter().filter_map(|study| study.runs.as_ref()) {
        collect(runs, &mut all);
    }
    // With one choice of options: that with most runs.
    let mut unknown: BTreeSet<(&str, &str)> = BTreeSet::new();
    let limits: BTreeMap<&Pair, Option<f64>> = all
        .iter()
        .filter_map(|(pair, choices)| {
            let most = choices.values().max_by_key(|tried| tried.values().map(BTreeMap::len).sum::<usize>())?;
            let limit = Some(limit(most)).filter(|_| most.len() > 1)?;
            if limit.is_none() {
                unknown.insert((&pair.0, &pair.1));
            }
            limit.map(|limit| (pair, limit))
        })
        .collect();
    // Where few schemes were tried, the best of them says little.
    let all: BTreeSet<&str> = limits.keys().map(|(_, scheme)| scheme.as_str()).collect();
    let half = all.len().div_ceil(2).max(2);
    let mut tried: BTreeMap<&str, usize> = BTreeMap::new();
    limits.keys().for_each(|(case, _)| *tried.entry(case).or_default() += 1);
    let cases: Vec<&str> = tried.iter().filter(|(_, count)| **count >= half).map(|(case, _)| *case).collect();
    let few = tried.len() - cases.len();
    if cases.is_empty() {
        return String::new();
    }
    let of = |case: &str, scheme: &str| limits.get(&(case.to_owned(), scheme.to_owned())).copied();
    let best: BTreeMap<&str, f64> = cases
        .iter()
        .map(|case| (*case, all.iter().filter_map(|scheme| of(case, scheme).flatten()).fold(0.0, f64::max)))
        .collect();
    // From the best scheme to the worst, by the mean shade over the cases that it was tried on.
    let mean = |scheme: &str| {
        let shades = cases.iter().filter_map(|case| Some(shade(of(case, scheme)?, best[case]) as f64));
        let shades: Vec<f64> = shades.collect();
        if shades.is_empty() { -1.0 } else { shades.iter().sum::<f64>() / shades.len() as f64 }
    };
    let mut schemes: Vec<&str> = all.iter().copied().filter(|scheme| mean(scheme) >= 0.0).collect();
    schemes.sort_by(|a, b| mean(b).total_cmp(&mean(a)));
    // Of few schemes or one case a sentence says as much as a table.
    if schemes.len() < 3 || cases.len() < 2 {
        let said = |case: &&str| {
            let of_scheme = |scheme: &&str| {
                let step = of(case, scheme)?.map_or("none".to_owned(), |step| format!("{} ms", milliseconds(step)));
                Some(format!("{} {step}", escaped(scheme)))
            };
            let limits: Vec<String> = schemes.iter().filter_map(of_scheme).collect();
            format!("<p>Largest accurate macro step of {}: {}.</p>\n", escaped(case), limits.join(", "))
        };
        let said: String = cases.iter().map(said).collect();
        return format!("<section id=\"grid\"><h2>Largest accurate step</h2>\n{said}</section>\n");
    }
    let head: String =
        schemes.iter().map(|scheme| format!("<th scope=\"col\"><span>{}</span></th>", escaped(scheme))).collect();
    let mut rows = String::new();
    for case in &cases {
        let _ = write!(rows, "<tr><th scope=\"row\">{}</th>", escaped(case));
        for scheme in &schemes {
            let cell = match of(case, scheme) {
                None if unknown.contains(&(case, scheme)) => "<td class=\"none\">?</td>".to_owned(),
                None => "<td></td>".to_owned(),
                Some(None) => "<td class=\"none\">none</td>".to_owned(),
                Some(Some(step)) => {
                    format!("<td class=\"shade-{}\">{}</td>", shade(Some(step), best[case]), milliseconds(step))
                }
            };
            rows.push_str(&cell);
        }
        rows.push_str("</tr>\n");
    }
    let few = match few {
        0 => String::new(),
        few => format!(
            " Cases or sets of parameters on which fewer than half of the schemes were tried are left out ({few})."
        ),
    };
    format!(
        "<section id=\"grid\"><h2>Largest accurate step</h2>\n<p>Macro step in milliseconds up to which, at every step tried, all \
         runs completed and the median rms force error was at most a tenth of the reference’s peak; schemes as they are, without \
         options of an experiment. Darker is closer to the best of the row; <em>none</em>: not even at the shortest step tried; ?: a \
         run beyond gave no answer; an empty cell was not tried at two steps. A limit is one of the steps tried, and no more than the longest of them. Schemes stand from the best \
         to the worst by their mean shade.{few}</p>\n\
         <div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"Largest accurate step\"><table class=\"grid\"><thead><tr><th scope=\"col\">case</th>{head}</tr></thead><tbody>\n{rows}</tbody></table></div></section>\n"
    )
}

/// Options that are no part of what a scheme is tried at.
const TRIED: [&str; 6] = ["macro_step_s", "phase", "step_control", "step_tolerance", "min_macro_step_s", "set"];

fn collect(table: &RunTable, all: &mut BTreeMap<Pair, BTreeMap<Vec<String>, Tried>>) {
    let Some(error) = Finding::named("force_error_rms_of_peak").ok().filter(|error| table.has(*error)) else { return };
    let options = table.settings().enumerate().skip_while(|(_, name)| *name != "scheme").skip(1);
    let options: Vec<usize> = options.filter(|(_, name)| !TRIED.contains(name)).map(|(place, _)| place).collect();
    let as_it_is = table.runs().iter().filter(|run| run.label == run.scheme && run.found.outcome.was_run());
    for run in as_it_is {
        let [case, set] = run.problem();
        let problem = if set.is_empty() { case.to_owned() } else { format!("{case}, {set}") };
        let choice: Vec<String> = options.iter().map(|&place| run.settings[place].to_string()).collect();
        let value = match run.found.outcome.class() {
            OutcomeClass::Completed => Ok(run.found.value(error)),
            class => Err(class),
        };
        let tried = all.entry((problem, run.scheme.to_string())).or_default().entry(choice).or_default();
        // Steps are above zero, so that their bits are in order.
        tried.entry(run.macro_step_s.to_bits()).or_default().insert(run.id.to_string(), value);
    }
}

/// Shade of a limit: four of them, a factor of three apart, and 0 for none.
fn shade(limit: Option<f64>, best: f64) -> usize {
    limit.map_or(0, |step| 4 - ((best / step).log(3.0).round() as usize).min(3))
}

/// The largest step up to which all was accurate, if any was; nothing where the first step that is not says nothing.
fn limit(tried: &Tried) -> Option<Option<f64>> {
    let accurate = |errors: &BTreeMap<String, Result<f64, OutcomeClass>>| {
        let completed: Result<Vec<f64>, _> = errors.values().copied().collect();
        completed.is_ok_and(|errors| Pool::of(errors).median().is_some_and(|error| error <= USABLE))
    };
    let good = tried.iter().take_while(|(_, errors)| accurate(errors)).count();
    let mut steps = tried.iter().skip(good.saturating_sub(1));
    let last = if good > 0 { steps.next().map(|(step, _)| f64::from_bits(*step)) } else { None };
    let beyond = steps.next().is_some_and(|(_, errors)| {
        let is = |class| errors.values().any(|end| *end == Err(class));
        is(OutcomeClass::NoAnswer) && !is(OutcomeClass::Failed)
    });
    (!beyond).then_some(last)
}

fn milliseconds(step_s: f64) -> String {
    format!("{}", (step_s * 1e9).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_ends_where_a_run_is_lost_or_wrong_for_the_first_time() {
        let tried = |steps: &[(f64, [Result<f64, OutcomeClass>; 3])]| -> Tried {
            let runs = |errors: &[Result<f64, OutcomeClass>; 3]| {
                errors.iter().enumerate().map(|(k, error)| (k.to_string(), *error)).collect()
            };
            steps.iter().map(|(step, errors)| (step.to_bits(), runs(errors))).collect()
        };
        let good = [Ok(0.01), Ok(0.02), Ok(0.3)];
        let [lost, silent] = [OutcomeClass::Failed, OutcomeClass::NoAnswer].map(|class| [Err(class), Ok(0.0), Ok(0.0)]);
        assert_eq!(limit(&tried(&[(1e-3, good), (2e-3, good)])), Some(Some(2e-3)));
        assert_eq!(limit(&tried(&[(1e-3, good), (2e-3, lost), (5e-3, good)])), Some(Some(1e-3)));
        assert_eq!(limit(&tried(&[(1e-3, [Ok(0.2); 3]), (2e-3, good)])), Some(None));
        // A run that was cut off gives no limit, nor do longer steps beyond it.
        assert_eq!(limit(&tried(&[(1e-3, good), (2e-3, silent), (5e-3, good)])), None);
        assert_eq!(limit(&tried(&[(1e-3, silent), (2e-3, lost)])), None);
        assert_eq!(limit(&tried(&[(1e-3, good), (2e-3, lost), (5e-3, silent)])), Some(Some(1e-3)));
        assert_eq!([Some(9.0), Some(3.0), Some(0.1), None].map(|limit| shade(limit, 9.0)), [4, 3, 1, 0]);
        assert_eq!(milliseconds(5e-3), "5");
        assert_eq!(milliseconds(2e-6), "0.002");
    }
}

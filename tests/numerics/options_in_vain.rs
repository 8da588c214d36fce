//! Sweeps: an option that changes nothing must not make another run of it, and every parameter must reach run and
//! reference.

use crate::support::{Changed, catalogue, schemes};
use rimbench::cosim::{Outcome, StopFlag, Trajectory};
use rimbench::harness::{Cache, monotonic_clock, obtain_reference};
use rimbench::parameter::{Parameter, Range, Value};
use rimbench::runs::{RunRequest, RunSpec, evaluate, simulate};
use std::cell::OnceCell;
use std::collections::BTreeMap;

/// Cases on which every option has something to do: contacts that open and close, redundant ones, friction, none but
/// feedthrough.
const CASES: [(&str, &str); 6] = [
    ("wedge-box", "0.9"),
    ("wedge-box-friction", "0.3"),
    ("crane-set-down", "0.6"),
    ("linear-oscillator", "0.3"),
    ("cradle", "0.6"),
    ("tripod", "0.3"),
];

/// A value or more of each option beside the usual one.
const OPTIONS: [(&str, &[&str]); 12] = [
    ("sequence", &["jacobi", "gauss-seidel", "gauss-seidel-mechanics-first"]),
    ("force_return", &["held", "end", "mean", "profile"]),
    ("mechanics_steps", &["2", "all"]),
    ("mechanics_step_s", &["2e-3", "1e-3", "7e-4"]),
    ("mechanics_integrator", &["midpoint", "event-split"]),
    ("actuator_integrator", &["midpoint"]),
    ("model_motion", &["extrapolated"]),
    ("contact_detection", &["active", "mechanics-law", "margin:1e-2"]),
    ("friction_rows", &["slip-direction"]),
    ("contacts_act", &["mechanics-step"]),
    ("gain", &["0.25"]),
    ("step_control", &["energy-residual", "model-defect"]),
];

/// All that is known of a run, as text; none of one that did not begin.
fn findings(spec: &RunSpec, cache: &Cache) -> Option<Vec<String>> {
    let reference = obtain_reference(spec, cache, StopFlag::never()).unwrap();
    let run = simulate(spec, reference.bounds(spec).unwrap(), Some(monotonic_clock), StopFlag::never()).unwrap();
    let began = !matches!(run.report.outcome, Outcome::Skipped { .. });
    let bits = |row: &[f64]| row.iter().map(|value| format!("{:x}", value.to_bits())).collect::<String>();
    let rows: Vec<String> = run.trajectory.rows().map(bits).collect();
    let found = evaluate(spec, run, &reference).unwrap();
    began.then(|| rows.into_iter().chain(found.found.facts().iter().map(|fact| fact.cell())).collect())
}

#[test]
#[ignore = "ten seconds; part of .ci/sweeps"]
fn an_option_that_changes_nothing_is_refused_or_leaves_the_run_id() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    // What each option did, over all cases: whether it was of any use.
    let mut of_use: BTreeMap<(String, String), bool> = BTreeMap::new();
    for (case, duration) in CASES {
        for scheme in schemes() {
            let request = |key: &str, value: &str| {
                let mut request = RunRequest::of(case, &*scheme.name);
                for (key, value) in [("duration_s", duration), ("macro_step_s", "2e-3"), (key, value)] {
                    request.put(key, value).unwrap();
                }
                if key == "step_control" {
                    request.put("step_tolerance", "1e-3").unwrap();
                }
                request.resolve(catalogue())
            };
            let usual = request("phase", "1").unwrap();
            let Some(own) = findings(&usual, &cache) else { continue };
            for (key, values) in OPTIONS {
                for value in values {
                    let Ok(spec) = request(key, value) else { continue };
                    if spec.id() == usual.id() {
                        continue;
                    }
                    if let Some(other) = findings(&spec, &cache) {
                        let known = of_use.entry((scheme.name.to_string(), format!("{key} = {value}"))).or_default();
                        *known |= own != other;
                    }
                }
            }
        }
    }
    assert!(of_use.len() > 250, "{} options tried", of_use.len());
    let in_vain: Vec<String> = of_use
        .iter()
        .filter(|(_, of_use)| !**of_use)
        .map(|((scheme, option), _)| format!("{scheme}: {option}"))
        .collect();
    assert!(in_vain.is_empty(), "{} of {} change nothing:\n{}", in_vain.len(), of_use.len(), in_vain.join("\n"));
}

/// A number 3 % larger, instead of 0 the middle of its sensible range (a rebound of 3 % is over within a step); another
/// choice.
fn changed_value(parameter: &Parameter, value: &Value) -> Option<String> {
    let middle = || parameter.study.map_or(0.03, |[least, most]| 0.5 * (least + most));
    match (value, &parameter.range) {
        (Value::Number(number), _) => Some(format!("{:?}", if *number == 0.0 { middle() } else { 1.03 * number })),
        (Value::Choice(chosen), Range::OneOf(values)) => {
            values.iter().find(|value| *value != chosen).map(ToString::to_string)
        }
        _ => None,
    }
}

/// Whether two runs are the same to round-off: with a restitution that nothing uses, sums are taken in another order.
fn same(one: &Trajectory, other: &Trajectory) -> bool {
    let peak = |column: usize| one.rows().map(|row| row[column].abs()).fold(0.0, f64::max);
    let peaks: Vec<f64> = (0..one.rows().next().map_or(0, <[f64]>::len)).map(peak).collect();
    let near = |(one, other): (&[f64], &[f64])| {
        one.iter()
            .zip(other)
            .zip(&peaks)
            .all(|((one, other), peak)| one == other || (one - other).abs() < 1e-11 * peak.max(1e-3))
    };
    one.rows().len() == other.rows().len() && one.rows().zip(other.rows()).all(near)
}

#[test]
#[ignore = "a minute; part of .ci/sweeps"]
fn every_parameter_reaches_the_run_and_the_reference() {
    let mut without_effect = Vec::new();
    let mut tried = 0;
    for case in catalogue().cases() {
        let short = (case.defaults.duration_s * 0.5).min(1.0).max(4.0 * case.defaults.macro_step_s);
        let run = |(scheme, duration, finer): (&str, f64, f64), set: &[(String, String)]| {
            let mut request = RunRequest::of(&*case.name, scheme);
            request.duration_s = Some(duration);
            request.macro_step_s = Some(case.defaults.macro_step_s / finer);
            request.set = set.to_vec();
            let spec = request.resolve(catalogue()).ok()?;
            let result = simulate(&spec, Default::default(), Some(monotonic_clock), StopFlag::never()).ok()?;
            let reference = rimbench::runs::Reference::exact(&spec, StopFlag::never()).ok()?;
            let reference = match reference {
                Some(reference) => reference.trajectory,
                None => rimbench::runs::Reference::solution(&spec.of_the_reference(), 1, StopFlag::never()).ok()?.rows,
            };
            Some((result.trajectory, reference))
        };
        let whole = case.defaults.duration_s;
        let kinds = [
            ("rim-nonsmooth-gap", short, 1.0),
            // Half a manoeuvre may have no impact, or long steps a rebound that is none.
            ("rim-nonsmooth-gap", whole, 1.0),
            ("rim-nonsmooth-gap", short, 10.0),
            // A model that the case has not runs nowhere.
            ("zero-order-hold", whole, 1.0),
        ];
        let usual = kinds.map(|_| OnceCell::new());
        // How fast a penetration decays is a matter of steps, of which an exact solution has none.
        let numbers =
            |(own, value): &(&Parameter, &Value)| own.name != "stabilisation" && matches!(value, Value::Number(_));
        for (parameter, value) in case.default_parameters().iter().filter(numbers) {
            let Some(more) = changed_value(parameter, value) else { continue };
            let set = [(parameter.name.to_string(), more)];
            // What comes later than the run, or belongs to another choice, changes neither.
            let alike = |(&kind, usual): (_, &OnceCell<Option<(Trajectory, Trajectory)>>)| {
                let usual = usual.get_or_init(|| run(kind, &[])).as_ref()?;
                let changed = run(kind, &set)?;
                Some(same(&usual.0, &changed.0) == same(&usual.1, &changed.1))
            };
            let mut found = kinds.iter().zip(&usual).filter_map(alike).peekable();
            tried += usize::from(found.peek().is_some());
            if found.peek().is_some() && !found.any(|alike| alike) {
                without_effect.push(format!("{}: {}", case.name, parameter.name));
            }
        }
    }
    assert!(tried > 300, "{tried} parameters tried");
    assert!(without_effect.is_empty(), "{} of {tried}:\n{}", without_effect.len(), without_effect.join("\n"));
}

/// Every choice of a case once beside its defaults, and every number beside that: a parameter that changes neither run
/// nor reference belongs to another choice, and is refused.
#[test]
#[ignore = "a minute; part of .ci/sweeps"]
fn a_parameter_of_another_choice_is_refused() {
    let (mut in_vain, mut tried, mut refused) = (Vec::new(), 0, 0);
    for case in catalogue().cases() {
        let defaults = case.default_parameters();
        let choices = case.parameters.iter().flat_map(|parameter| match &parameter.range {
            Range::OneOf(values) => {
                values.iter().map(|value| (parameter.name.to_string(), value.to_string())).collect()
            }
            _ => Vec::new(),
        });
        let choices: Vec<(String, String)> = choices.collect();
        if choices.is_empty() {
            continue;
        }
        let resolved = |scheme: &str, set: &[(String, String)]| {
            let mut request = RunRequest::of(&*case.name, scheme);
            request.set = set.to_vec();
            request.resolve(catalogue())
        };
        let found = |set: &[(String, String)], longer: f64| {
            // A run that diverges early meets little of a manoeuvre: the hold only where no model applies.
            ["rim-nonsmooth-gap", "zero-order-hold"].iter().find_map(|scheme| {
                let spec = resolved(scheme, set).ok()?.changed(|own| own.duration *= longer);
                let run = simulate(&spec, Default::default(), Some(monotonic_clock), StopFlag::never()).ok()?;
                let began = !matches!(run.report.outcome, Outcome::Skipped { .. });
                began.then(|| run.trajectory.rows().flatten().map(|value| value.to_bits()).collect::<Vec<_>>())
            })
        };
        for choice in choices {
            let beside = std::slice::from_ref(&choice);
            let Some(usual) = found(beside, 1.0) else { continue };
            for (parameter, value) in defaults.iter().filter(|(own, _)| own.name != choice.0) {
                let Some(more) = changed_value(parameter, value) else { continue };
                let set = [choice.clone(), (parameter.name.to_string(), more)];
                tried += 1;
                match resolved("zero-order-hold", &set) {
                    Err(error) => refused += usize::from(error.to_string().contains("has no effect with")),
                    // What comes later than the run belongs to no other choice.
                    Ok(_) if found(&set, 1.0).as_ref() == Some(&usual) && found(&set, 3.0) == found(beside, 3.0) => {
                        in_vain.push(format!("{}: {} with {}={}", case.name, parameter.name, choice.0, choice.1));
                    }
                    Ok(_) => {}
                }
            }
        }
    }
    assert!(tried > 100 && refused >= 2, "{tried} parameters tried, {refused} refused");
    assert!(in_vain.is_empty(), "{} of {tried}:\n{}", in_vain.len(), in_vain.join("\n"));
}

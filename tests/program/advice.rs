//! `rimbench advise`: nothing in an exhaustive sweep is cheaper than what is advised, and what cannot be told is said.

use crate::program::{assert_has, cache, call, json, refused};
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{ForceReturn, MechanicsSteps, Outcome, Sequence, Side, StopFlag};
use rimbench::harness::{Cache, METRIC, USUAL_PRICES, obtain_reference, phase_ensemble};
use rimbench::metrics::METRICS;
use rimbench::runs::{RunRequest, evaluate, simulate};
use serde_json::Value;

const PHASES: usize = 4;

/// An advice as JSON.
fn advised(options: &str) -> Value {
    json(&mut call(&format!("advise --per-decade 5 --format json {options}")))
}

/// What a choice comes to when its command is called, at its own phase or at another.
fn called_again(choice: &Value, phase: Option<f64>) -> Value {
    let mut words: Vec<&str> = choice["command"].as_str().unwrap().split(' ').skip(1).collect();
    let place = 1 + words.iter().position(|word| *word == "--phase").unwrap();
    let phase = phase.map_or_else(|| words[place].to_owned(), |phase| phase.to_string());
    words[place] = &phase;
    json(&mut call(&format!("{} --format json", words.join(" "))))
}

/// Every scheme in every form at every macro step, by loops of its own and as many phases again: nothing that meets the
/// error is cheaper.
#[test]
fn nothing_in_an_exhaustive_sweep_is_cheaper_than_what_is_advised_and_that_holds_where_nobody_looked() {
    let sides = [Side::Actuator, Side::Mechanics].map(|first| Some(Sequence::GaussSeidel { first }));
    let forms = [
        (None, None, None),
        (Some(Sequence::Jacobi), Some(ForceReturn::Held), None),
        (sides[0], Some(ForceReturn::Mean), None),
        (sides[0], Some(ForceReturn::End), None),
        (sides[0], Some(ForceReturn::Profile), MechanicsSteps::count(10)),
        (sides[0], Some(ForceReturn::Profile), Some(MechanicsSteps::AsActuator)),
        (sides[1], Some(ForceReturn::Held), None),
    ];
    let (catalogue, cache) = (Catalogue::standard(), Cache::in_folder(cache()));
    let place = METRICS.iter().position(|metric| metric.name == METRIC).unwrap();
    for (case, duration_s, error, range) in [
        ("elastic-bar", None, 0.02, "--from 2.5e-6 --to 1e-4"),
        ("wedge-box", Some(0.3), 0.01, "--duration 0.3 --from 1e-3 --to 2e-2"),
    ] {
        let advice = advised(&format!("--case {case} --error {error} --phases {PHASES} {range}"));
        let (best, other) = (&advice["advised"], &advice["runner_up"]);
        let least = best["cost"].as_f64().unwrap();
        assert!(least <= other["cost"].as_f64().unwrap() && best["scheme"] != other["scheme"], "{advice:#}");
        assert!(best["time_per_macro_step_s"].as_f64().unwrap() > 0.0);
        for &phase in &phase_ensemble(2 * PHASES)[PHASES..] {
            assert!(called_again(best, Some(phase))[METRIC].as_f64().unwrap() <= error, "{case} at {phase}: {best:#}");
        }
        let usual = RunRequest { duration_s, ..RunRequest::of(case, "zero-order-hold") }.resolve(&catalogue).unwrap();
        let reference = obtain_reference(&usual, &cache, StopFlag::never()).unwrap();
        let cost_within = |request: &RunRequest| {
            let mut cost = 0.0_f64;
            for phase in phase_ensemble(PHASES) {
                let spec = RunRequest { phase: Some(phase), ..request.clone() }.resolve(&catalogue).ok()?;
                let result = simulate(&spec, reference.bounds(&spec).unwrap(), None, StopFlag::never()).unwrap();
                let run = evaluate(&spec, result, &reference).unwrap();
                if run.outcome != Outcome::Completed || run.found.metrics[place].is_none_or(|own| own > error) {
                    return None;
                }
                let (work, sides, scheme) = (run.found.work, run.found.work.sides, run.found.work.scheme);
                let [mechanics, actuator] = [sides.mechanics, sides.actuator].map(|side| side.micro_steps);
                let counts = [work.cosim.exchanges, mechanics, actuator, scheme.solves + scheme.parametric];
                cost = cost.max(counts.iter().zip(USUAL_PRICES).map(|(count, price)| *count as f64 * price).sum());
            }
            Some(cost)
        };
        let mut cells = 0;
        for scheme in catalogue.schemes().iter().filter(|scheme| scheme.real_time()) {
            for (sequence, force_return, mechanics_steps) in forms {
                for step in advice["macro_steps_s"].as_array().unwrap() {
                    let own =
                        RunRequest { macro_step_s: step.as_f64(), duration_s, ..RunRequest::of(case, &*scheme.name) };
                    let request = RunRequest { sequence, force_return, mechanics_steps, ..own };
                    let Some(cost) = cost_within(&request) else { continue };
                    cells += 1;
                    assert!(cost >= least * (1.0 - 1e-9), "{case}: {request:?} costs {cost}, not {least}");
                }
            }
        }
        assert!(cells > 20, "{case}: only {cells} cells meet the error: the sweep sees nothing");
    }
}

#[test]
fn where_nothing_can_be_advised_the_reason_is_said() {
    for (options, notes) in [
        // Coarse steps only, and an error that no coupling has.
        (
            "--case wedge-box --duration 0.2 --from 10ms --to 20ms --error 0.01%",
            ["None: no form", "The nearest: ", "% of the peak force"],
        ),
        // An error below what the reference knows.
        ("--case disc-pile --duration 0.05 --error 1e-9", ["None can be told: ", "reference", "is uncertain"]),
        // A scheme that the case has nothing to offer for.
        (
            "--case elastic-bar --scheme hydraulic-line --error 50%",
            ["None: no form", "No form could be run.", "Skipped: "],
        ),
    ] {
        let advice = advised(options);
        assert!(advice["advised"].is_null() && advice["runner_up"].is_null(), "{advice:#}");
        assert_has(&advice["notes"].to_string(), &notes);
    }
    // Runs that took longer than they may, against a reference that is there.
    let limited = "--case wedge-box --duration 0.2 --from 10ms --to 20ms --error 2% --wall-limit 1e-7";
    assert!(advised(limited)["undecided"].as_u64().unwrap() > 50);
}

#[test]
fn what_falls_without_information_follows_from_what_schemes_need() {
    for (options, reason) in [
        ("--scheme monolithic", "monolithic is no co-simulation"),
        ("--scheme rim-nonsmooth --no-model", "rim-nonsmooth needs an interface model of the mechanics (--no-model)"),
        ("--scheme iterated-aitken --real-time", "iterated-aitken takes steps again (--real-time)"),
        ("--scheme iterated-aitken --no-feedback", "within its macro step (--no-feedback)"),
        ("--scheme interface-jacobian --no-feedback", "within its macro step (--no-feedback)"),
        ("--scheme energy-leak-damper --no-feedback", "within its macro step (--no-feedback)"),
        ("--force-return mean --no-feedback", "within its macro step (--no-feedback)"),
    ] {
        assert_has(&refused(&mut call(&format!("advise --case elastic-bar --error 1% {options}"))), &[reason]);
    }
    for options in ["--no-model --no-feedback --real-time", "--scheme rim-nonsmooth --no-feedback"] {
        let advice = advised(&format!("--case elastic-bar --error 5% {options}"));
        let forms = ["advised", "runner_up"].map(|choice| advice[choice]["form"].as_str());
        assert!(forms[0].is_some() && forms.iter().flatten().all(|form| form.contains(", held, ")), "{advice:#}");
    }
}

#[test]
fn an_advice_is_the_same_for_any_number_of_threads_and_prices_change_it() {
    let of_bar = |options: &str| advised(&format!("--case elastic-bar --error 2% {options}"));
    let (one, mut two) = (of_bar("--jobs 1"), of_bar("--jobs 2"));
    for choice in ["advised", "runner_up", "finer"].into_iter().filter(|choice| !one[choice].is_null()) {
        two[choice]["time_per_macro_step_s"] = one[choice]["time_per_macro_step_s"].clone();
    }
    assert_eq!(two, one);
    // What half the error costs is told where it was seen.
    let bar = advised("--case elastic-bar --error 20% --phases 4");
    let [(error, cost), (finer, dearer)] = ["advised", "finer"].map(|choice| {
        let of = |key: &str| bar[choice][key].as_f64().unwrap();
        (of("worst_error"), of("cost"))
    });
    assert!(finer <= 0.5 * error && dearer >= cost, "{bar:#}");
    let (best, facts) = (&one["advised"], called_again(&one["advised"], None));
    assert_eq!((&facts["run_id"], &facts[METRIC]), (&best["run_id"], &best["worst_error"]));
    // Where mechanics solves cost everything, as few of them as can be are advised.
    let dear = of_bar("--costs 0,1e6,0,0");
    let solves = |advice: &Value| advice["advised"]["work"][1].as_f64().unwrap();
    assert!(solves(&dear) <= solves(&one));
    assert_eq!(dear["advised"]["cost"].as_f64().unwrap(), 1e6 * solves(&dear));
    // A mechanics of a step of its own is paid for the steps that it takes.
    let own = "--case wedge-box --duration 0.3 --from 5e-4 --to 1e-2 --error 2% --phases 2 --mechanics-step 1ms";
    let best = &advised(own)["advised"];
    assert_has(best["command"].as_str().unwrap(), &[" --mechanics-step "]);
    let (facts, work) = (called_again(best, None), |place: usize| best["work"][place].as_f64().unwrap());
    assert_eq!(facts["mechanics_micro_steps"].as_f64(), Some(work(1)));
    let steps =
        (best["macro_step_s"].as_f64().unwrap() / 1e-3 - 1e-6).ceil() * 0.3 / best["macro_step_s"].as_f64().unwrap();
    assert!(work(1) >= steps.floor() && work(1) >= 300.0, "{best:#}");
    let cost: f64 = USUAL_PRICES.iter().enumerate().map(|(place, price)| price * work(place)).sum();
    assert_eq!(best["cost"].as_f64(), Some(cost));
    assert_has(&of_bar("--to 5e-6")["notes"].to_string(), &["the largest macro step that was tried"]);
}

#[test]
fn trials_of_the_mechanics_are_paid_for_and_advised_where_exchanges_are_dear_and_there_is_no_model() {
    let of_box = |options: &str| {
        advised(&format!("--case wedge-box --duration 0.3 --from 1e-3 --to 2e-2 --error 3% --phases 2 {options}"))
    };
    let asked = &of_box("--scheme rim-answers")["advised"];
    let (facts, trials) = (called_again(asked, None), |facts: &Value| facts["trials_per_step"].as_f64().unwrap());
    let steps = facts["macro_steps"].as_f64().unwrap();
    assert_eq!(facts["mechanics_micro_steps"].as_f64(), asked["work"][1].as_f64());
    let paid = asked["work"][1].as_f64().unwrap() / steps;
    assert!(trials(&facts) >= 3.0 && (paid - 1.0 - trials(&facts)).abs() < 1e-9, "{paid} {facts:#}");
    // A bus on which an exchange costs more than all steps between two of them.
    let on_bus = of_box("--no-model --costs 1e6,1,1,1");
    assert_eq!(on_bus["advised"]["scheme"], "rim-answers", "{on_bus:#}");
    // What acts within the macro step cannot be asked for where that may not be.
    let refusal = call("advise --case wedge-box --error 3% --scheme rim-answers --no-feedback");
    assert_has(&refused(&mut { refusal }), &["within its macro step (--no-feedback)"]);
}

/// More of the one or the other is never worse, nothing spends more than it may, and what is said is what the run has.
#[test]
fn within_a_budget_the_least_error_is_advised_and_what_is_no_budget_is_refused() {
    let case = "advise --case wedge-box --duration 0.3 --phases 2 --no-model --format json";
    let within = |exchanges: u32, steps: u32| {
        json(&mut call(&format!("{case} --exchanges {exchanges} --mechanics-steps {steps}")))
    };
    let error = |choice: &Value| choice["worst_error"].as_f64().unwrap();
    let small = within(200, 400);
    let (best, other) = (&small["advised"], &small["runner_up"]);
    assert!(error(best) <= error(other) && best["scheme"] != other["scheme"], "{small:#}");
    let spent = |of: usize| best["spent_per_s"][of].as_f64().unwrap();
    assert!(spent(0) <= 1.03 * 200.0 && spent(1) <= 1.05 * 400.0, "{best:#}");
    let facts = called_again(best, None);
    let metric = |name: &str| facts[name].as_f64().unwrap();
    let inside = metric("force_error_inside_rms_n") * metric(METRIC) / metric("force_error_rms_n");
    assert!((inside / error(best) - 1.0).abs() < 1e-12, "{inside} {best:#}");
    for (of, larger) in [within(400, 400), within(200, 800)].iter().enumerate() {
        let more = error(&small["doubled"][of]);
        assert!(error(&larger["advised"]) <= more * (1.0 + 1e-12) && more <= error(best), "{larger:#}");
    }
    for (options, reason) in [
        ("--exchanges 0 --mechanics-steps 1000", "exchanges = 0 is not valid"),
        ("--exchanges nan --mechanics-steps 1000", "exchanges = NaN is not valid"),
        ("--exchanges -5 --mechanics-steps 1000", "exchanges = -5 is not valid"),
        ("--exchanges 200 --mechanics-steps 100", "at least the exchanges, 200"),
        ("--exchanges 200", "needs --mechanics-steps"),
        ("--exchanges 200 --mechanics-steps all", "mechanics-steps = all is not valid"),
        ("--exchanges 200 --mechanics-step 1ms", "and no --mechanics-step"),
        ("--exchanges 200 --mechanics-steps 1000 --error 1%", "cannot be used with"),
        ("", "--error"),
    ] {
        assert_has(&refused(&mut call(&format!("{case} {options}"))), &[reason]);
    }
}

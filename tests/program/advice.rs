//! `rimbench advise`: what is advised holds where nobody has looked, nothing cheaper does, and nonsense is refused.

use crate::program::{assert_has, cache, call, json, printed, rimbench};
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{ForceReturn, MechanicsSteps, Outcome, Sequence, Side, StopFlag};
use rimbench::harness::{
    Advice, Budget, Cache, Choice, Information, METRIC, Prices, Question, advise, logarithmic_grid, obtain_reference,
    phase_ensemble,
};
use rimbench::metrics::METRICS;
use rimbench::runs::{EvaluatedRun, RunRequest, evaluate, simulate};
use serde_json::Value;

/// Phases of the search and kept aside, as the program has them.
const PHASES: usize = 4;

/// What the tests ask, the case and its settings aside.
struct Asked {
    fixed: RunRequest,
    error: f64,
    macro_steps: Vec<f64>,
    budget: Budget,
}

impl Asked {
    fn of(case: &str, duration_s: Option<f64>, error: f64, [from, to]: [f64; 2]) -> Self {
        let fixed = RunRequest { case: Some(case.to_owned()), duration_s, ..RunRequest::default() };
        let macro_steps = logarithmic_grid(from, to, 5).unwrap();
        Asked { fixed, error, macro_steps, budget: Budget::default() }
    }

    fn advice(&self, catalogue: &Catalogue) -> Advice {
        // References are those of all tests; runs are made anew.
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path());
        if self.fixed.wall_limit_s.is_some() {
            // One that is kept takes no time.
            let patient =
                RunRequest { wall_limit_s: None, scheme: Some("zero-order-hold".to_owned()), ..self.fixed.clone() };
            obtain_reference(&patient.resolve(catalogue).unwrap(), &cache, StopFlag::never()).unwrap();
        }
        let question = Question {
            catalogue,
            fixed: &self.fixed,
            error: self.error,
            information: Information::default(),
            prices: Prices::default(),
            macro_steps: &self.macro_steps,
            phases: PHASES,
            kept_aside: PHASES,
            exhaustive: false,
            budget: self.budget,
            cache: &cache,
            progress: &|_| {},
            stop: StopFlag::never(),
        };
        advise(question).unwrap()
    }
}

/// A run by way of the library, beside the advice; none if case and form do not go together.
fn made(catalogue: &Catalogue, request: &RunRequest) -> Option<EvaluatedRun> {
    let spec = request.resolve(catalogue).ok()?;
    let reference = obtain_reference(&spec, &Cache::in_folder(cache()), StopFlag::never()).unwrap();
    let result = simulate(&spec, reference.bounds(&spec).unwrap(), None, StopFlag::never()).unwrap();
    Some(evaluate(&spec, result, &reference).unwrap())
}

fn error_of(run: &EvaluatedRun) -> Option<f64> {
    let place = METRICS.iter().position(|metric| metric.name == METRIC).unwrap();
    run.metrics[place].filter(|_| run.outcome == Outcome::Completed)
}

/// Cases of different kinds whose runs take milliseconds, with the macro steps that are tried.
fn small_cases() -> [Asked; 4] {
    [
        Asked::of("elastic-bar", None, 0.02, [1e-6, 1e-4]),
        Asked::of("wedge-box", Some(0.4), 0.01, [1e-3, 2e-2]),
        Asked::of("hydraulic-crane", Some(0.5), 0.01, [2e-3, 5e-2]),
        Asked::of("precice-oscillator", None, 0.01, [1e-3, 1e-1]),
    ]
}

#[test]
fn what_is_advised_is_stable_and_within_the_error_at_phases_that_nobody_looked_at() {
    let catalogue = Catalogue::standard();
    for asked in small_cases() {
        let advice = asked.advice(&catalogue);
        let name = asked.fixed.case.as_deref().unwrap();
        let choices: Vec<&Choice> = advice.best.iter().chain(&advice.runner_up).collect();
        assert_eq!(choices.len(), 2, "{name}: {advice:?}");
        assert!(choices[0].cost <= choices[1].cost, "{name}");
        assert_ne!(choices[0].request.scheme, choices[1].request.scheme, "{name}");
        for choice in choices {
            assert!(choice.worst_error() <= asked.error && choice.limit.last_stable >= choice.macro_step, "{name}");
            for &phase in &phase_ensemble(3 * PHASES)[2 * PHASES..] {
                let run = made(&catalogue, &RunRequest { phase: Some(phase), ..choice.request.clone() }).unwrap();
                let error = error_of(&run);
                let (form, step, outcome) = (&choice.form, choice.macro_step, &run.outcome);
                let at = format!("{:?} {form} at H = {step}, phase {phase}: {outcome}", choice.request.scheme);
                assert!(error.is_some_and(|error| error <= asked.error), "{name}: {at} {error:?}");
            }
        }
    }
}

/// Every scheme in every form at every macro step and phase, by loops of its own: nothing that meets the error is cheaper than what
/// is advised would be one macro step of the grid further on.
#[test]
fn nothing_in_an_exhaustive_sweep_is_cheaper_by_more_than_one_step_of_the_grid() {
    let catalogue = Catalogue::standard();
    let asked = Asked::of("elastic-bar", None, 0.02, [2.5e-6, 1e-4]);
    let best = asked.advice(&catalogue).best.unwrap();
    let bound = best.cost_one_step_on.unwrap();
    assert!(bound < best.cost);
    let actuator = Some(Sequence::GaussSeidel { first: Side::Actuator });
    let mechanics = Some(Sequence::GaussSeidel { first: Side::Mechanics });
    let forms = [
        (None, None, None),
        (Some(Sequence::Jacobi), Some(ForceReturn::Held), None),
        (actuator, Some(ForceReturn::Mean), None),
        (actuator, Some(ForceReturn::End), None),
        (actuator, Some(ForceReturn::Profile), MechanicsSteps::count(10)),
        (actuator, Some(ForceReturn::Profile), Some(MechanicsSteps::AsActuator)),
        (mechanics, Some(ForceReturn::Held), None),
    ];
    let prices = Prices::default();
    let (mut met, mut cheaper) = (0, Vec::new());
    for scheme in catalogue.schemes().iter().filter(|scheme| scheme.real_time()) {
        for (sequence, force_return, mechanics_steps) in forms {
            for &step in &asked.macro_steps {
                let meets = |phase: f64| {
                    let request = RunRequest {
                        scheme: Some(scheme.name.clone().into_owned()),
                        sequence,
                        force_return,
                        mechanics_steps,
                        macro_step_s: Some(step),
                        phase: Some(phase),
                        ..asked.fixed.clone()
                    };
                    made(&catalogue, &request).filter(|run| error_of(run).is_some_and(|error| error <= asked.error))
                };
                let runs: Vec<EvaluatedRun> = phase_ensemble(2 * PHASES).into_iter().map_while(meets).collect();
                if runs.len() < 2 * PHASES {
                    continue;
                }
                met += 1;
                let work = &runs[0].work;
                let cost = prices.exchange * work.cosim.exchanges as f64
                    + prices.mechanics_solve * work.sides.mechanics.micro_steps as f64
                    + prices.micro_step * work.sides.actuator.micro_steps as f64
                    + prices.model_solve * (work.scheme.solves + work.scheme.parametric) as f64;
                if cost < bound {
                    cheaper.push(format!("{} {sequence:?} {force_return:?} {step}: {cost}", scheme.name));
                }
            }
        }
    }
    assert!(met > 100, "only {met} runs meet the error: the sweep sees nothing");
    assert!(cheaper.is_empty(), "cheaper than {bound}: {cheaper:?}");
}

#[test]
fn where_nothing_meets_the_error_none_is_said_with_the_reason() {
    let catalogue = Catalogue::standard();
    let none = |asked: Asked| {
        let advice = asked.advice(&catalogue);
        assert!(advice.best.is_none() && advice.runner_up.is_none(), "{advice:?}");
        advice
    };
    // Coarse steps only, and an error that no coupling has.
    let coarse = Asked::of("wedge-box", Some(0.2), 1e-4, [1e-2, 2e-2]);
    let real_time = |name: &str| catalogue.scheme(name).unwrap().real_time();
    let fallen = none(coarse).fallen;
    assert!(fallen.iter().any(|fallen| fallen.reason.contains("% of the peak force") && fallen.run.is_some()));
    assert!(fallen.iter().any(|fallen| !real_time(&fallen.scheme)));
    // An error below what the reference knows.
    let advice = none(Asked::of("disc-pile", Some(0.05), 1e-9, [1e-3, 5e-3]));
    assert!(advice.reference_uncertainty.unwrap() > 1e-9 && advice.computed == 0);
    // A scheme that the case has nothing to offer for.
    let mut oil = Asked::of("elastic-bar", None, 0.5, [1e-6, 1e-5]);
    oil.fixed.scheme = Some("hydraulic-line".to_owned());
    let fallen = none(oil).fallen;
    assert!(!fallen.is_empty() && fallen.iter().all(|fallen| fallen.reason.starts_with("skipped")), "{fallen:?}");
}

#[test]
fn a_search_whose_budget_is_spent_says_what_is_open() {
    let mut asked = Asked::of("elastic-bar", None, 0.02, [1e-6, 1e-4]);
    let catalogue = Catalogue::standard();
    for runs in [20, 40] {
        asked.budget.runs = Some(runs);
        let advice = asked.advice(&catalogue);
        assert!(advice.open > 0 && advice.computed <= runs, "{} open, {} runs", advice.open, advice.computed);
        assert_eq!(asked.advice(&catalogue), advice);
    }
}

#[test]
fn a_form_that_took_longer_than_it_may_is_undecided_and_not_without_the_error() {
    let mut asked = Asked::of("wedge-box", Some(0.9), 0.02, [1e-3, 1e-2]);
    asked.fixed.wall_limit_s = Some(1e-7);
    let advice = asked.advice(&Catalogue::standard());
    assert!(advice.best.is_none() && advice.timed_out > 50, "{} timed out", advice.timed_out);
}

const ASK: &str = "advise --case elastic-bar --error 2% --format json";

fn advised(options: &str) -> Value {
    json(&mut call(&format!("{ASK} {options}")))
}

#[test]
fn an_advice_is_the_same_for_any_number_of_threads_and_from_stored_runs() {
    let folder = tempfile::tempdir().unwrap();
    let again = |jobs: &str, fresh: bool| {
        let mut command = call(&format!("{ASK} --jobs {jobs}"));
        if fresh {
            command.env("RIMBENCH_CACHE", folder.path());
        }
        let mut advice = json(&mut command);
        let made = advice["runs_made"].as_u64().unwrap();
        let object = advice.as_object_mut().unwrap();
        object.retain(|key, _| !["runs_made", "runs_stored", "notes"].contains(&key.as_str()));
        (made, advice)
    };
    let (made, first) = again("1", true);
    assert!(made > 50);
    assert_eq!(again("2", true), (0, first.clone()), "all runs are stored");
    assert_eq!(again("3", false).1, first);
}

#[test]
fn every_number_of_an_advice_comes_with_a_command_that_gives_it_again() {
    let advice = advised("");
    let again = |command: &Value| {
        let typed = command.as_str().unwrap().split(' ').skip(1);
        json(rimbench().args(typed).args(["--format", "json"]))
    };
    for choice in [&advice["advised"], &advice["runner_up"]] {
        let run = &choice["runs"][1];
        let facts = again(&run["command"]);
        assert_eq!((&facts["run_id"], &facts[METRIC]), (&run["run_id"], &run["error"]));
        assert_eq!(facts["phase"], run["phase"]);
        let limit = again(&choice["limit_command"]);
        assert!(limit["last_stable_s"].as_f64() >= choice["last_stable_s"].as_f64(), "{choice} {limit}");
    }
    let text = printed(&mut call("advise --case elastic-bar --error 2% --all"));
    let run_id = advice["advised"]["runs"][0]["run_id"].as_str().unwrap();
    assert_has(&text, &[run_id, "rimbench limit ", "Why not the others", "What this rests on"]);
}

#[test]
fn less_information_leaves_fewer_schemes_and_prices_change_the_advice() {
    let everything = json(&mut call("list schemes --format json")).as_array().unwrap().len();
    let refused = |advice: &Value, why: &str| {
        let fallen = advice["fallen"].as_array().unwrap();
        fallen.iter().filter(|fallen| fallen["reason"].as_str().unwrap().contains(why)).count()
    };
    let no_model = advised("--no-model");
    assert!((5..everything).contains(&refused(&no_model, "(--no-model)")));
    assert!((5..everything).contains(&refused(&advised("--no-feedback"), "(--no-feedback)")));
    assert_eq!(refused(&advised("--real-time"), "(--real-time)"), 2);
    // Where mechanics solves cost everything, as few of them as can be are advised.
    let dear = advised("--mechanics-cost 1e6 --micro-cost 0 --exchanges-cost 0 --model-cost 0");
    let solves = |advice: &Value| advice["advised"]["mechanics_solves"].as_f64().unwrap();
    assert!(solves(&dear) <= solves(&advised("")));
    assert_eq!(dear["advised"]["cost"].as_f64().unwrap(), 1e6 * solves(&dear));
}

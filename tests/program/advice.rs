//! `rimbench advise`: nothing in an exhaustive sweep is cheaper than what is advised, and what cannot be told is said.

use crate::program::{call, json};
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{ForceReturn, MechanicsSteps, Outcome, Sequence, Side, StopFlag};
use rimbench::harness::{
    Advice, Cache, Information, METRIC, Question, USUAL_PRICES, advise, logarithmic_grid, obtain_reference,
    phase_ensemble,
};
use rimbench::metrics::METRICS;
use rimbench::runs::{RunRequest, evaluate, simulate};
use serde_json::Value;

const PHASES: usize = 8;

/// The advice, and the macro steps that were tried.
fn advice(
    case: &str,
    change: impl Fn(&mut RunRequest),
    error: f64,
    [from, to]: [f64; 2],
) -> (Advice, Vec<f64>, RunRequest) {
    let mut fixed = RunRequest { case: Some(case.to_owned()), ..RunRequest::default() };
    change(&mut fixed);
    let macro_steps = logarithmic_grid(from, to, 5).unwrap();
    let question = Question {
        catalogue: &Catalogue::standard(),
        fixed: &fixed,
        error,
        information: Information::ALL,
        prices: USUAL_PRICES,
        macro_steps: &macro_steps,
        phases: PHASES,
        cache: &Cache::in_folder(crate::program::cache()),
        progress: &|_| {},
        stop: StopFlag::never(),
    };
    (advise(question).unwrap(), macro_steps, fixed)
}

/// Every scheme in every form at every macro step, by loops of its own and as many phases again: nothing that meets the error is cheaper.
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
    let catalogue = Catalogue::standard();
    let place = METRICS.iter().position(|metric| metric.name == METRIC).unwrap();
    for (case, duration_s, error, range) in
        [("elastic-bar", None, 0.02, [2.5e-6, 1e-4]), ("wedge-box", Some(0.3), 0.01, [1e-3, 2e-2])]
    {
        let (advice, macro_steps, fixed) = advice(case, |request| request.duration_s = duration_s, error, range);
        let [best, other] = [0, 1].map(|rank| &advice.rows[advice.chosen[rank]]);
        let met = best.met.as_ref().unwrap();
        assert!(met.cost <= other.met.as_ref().unwrap().cost && best.request.scheme != other.request.scheme);
        assert!(met.time_per_step_s().unwrap() > 0.0);
        let cost_within = |request: &RunRequest, phases: &[f64]| {
            let mut cost = 0.0_f64;
            for &phase in phases {
                let spec = RunRequest { phase: Some(phase), ..request.clone() }.resolve(&catalogue).ok()?;
                let cache = Cache::in_folder(crate::program::cache());
                let reference = obtain_reference(&spec, &cache, StopFlag::never()).unwrap();
                let result = simulate(&spec, reference.bounds(&spec).unwrap(), None, StopFlag::never()).unwrap();
                let run = evaluate(&spec, result, &reference).unwrap();
                if run.outcome != Outcome::Completed || run.found.metrics[place].is_none_or(|own| own > error) {
                    return None;
                }
                let (sides, scheme) = (&run.found.work.sides, &run.found.work.scheme);
                let counts = [
                    run.found.work.cosim.exchanges,
                    sides.mechanics.micro_steps,
                    sides.actuator.micro_steps,
                    scheme.solves + scheme.parametric,
                ];
                cost = cost.max(counts.iter().zip(USUAL_PRICES).map(|(count, price)| *count as f64 * price).sum());
            }
            Some(cost)
        };
        let advised = RunRequest { macro_step_s: Some(met.macro_step), ..best.request.clone() };
        assert!(cost_within(&advised, &phase_ensemble(2 * PHASES)[PHASES..]).is_some(), "{case}: {advised:?}");
        let mut cells = 0;
        for scheme in catalogue.schemes().iter().filter(|scheme| scheme.real_time()) {
            for (sequence, force_return, mechanics_steps) in forms {
                for &step in &macro_steps {
                    let (scheme, macro_step_s) = (Some(scheme.name.to_string()), Some(step));
                    let request =
                        RunRequest { scheme, sequence, force_return, mechanics_steps, macro_step_s, ..fixed.clone() };
                    let Some(cost) = cost_within(&request, &phase_ensemble(PHASES)) else { continue };
                    cells += 1;
                    assert!(cost >= met.cost * (1.0 - 1e-9), "{case}: {request:?} costs {cost}, not {}", met.cost);
                }
            }
        }
        assert!(cells > 20, "{case}: only {cells} cells meet the error: the sweep sees nothing");
    }
}

#[test]
fn where_nothing_can_be_advised_the_reason_is_said() {
    let none = |(advice, ..): (Advice, Vec<f64>, RunRequest)| {
        assert!(advice.chosen.is_empty(), "{:?}", advice.chosen);
        advice
    };
    // Coarse steps only, and an error that no coupling has.
    let coarse = none(advice("wedge-box", |request| request.duration_s = Some(0.2), 1e-4, [1e-2, 2e-2]));
    assert!(coarse.rows.iter().any(|row| row.reason().contains("% of the peak force")));
    // An error below what the reference knows.
    let uncertain = none(advice("disc-pile", |request| request.duration_s = Some(0.05), 1e-9, [1e-3, 5e-3]));
    assert!(uncertain.reference_uncertainty.unwrap() > 1e-9 && uncertain.runs == 0);
    // A scheme that the case has nothing to offer for.
    let oil = none(advice("elastic-bar", |request| request.scheme = Some("hydraulic-line".into()), 0.5, [1e-6, 1e-5]));
    assert!(!oil.rows.is_empty() && oil.rows.iter().all(|row| row.reason().starts_with("skipped")));
    // Runs that took longer than they may, against a reference that is there.
    let short = |request: &mut RunRequest| request.duration_s = Some(0.2);
    advice(
        "wedge-box",
        |request| (short(request), request.scheme = Some("zero-order-hold".into())).0,
        0.5,
        [1e-2, 2e-2],
    );
    let limited =
        none(advice("wedge-box", |request| (short(request), request.wall_limit_s = Some(1e-7)).0, 0.02, [1e-2, 2e-2]));
    assert!(limited.rows.iter().filter(|row| row.no_answer(true)).count() > 50);
}

fn advised(options: &str) -> Value {
    json(&mut call(&format!("advise --case elastic-bar --error 2% --per-decade 5 --format json {options}")))
}

#[test]
fn an_advice_is_the_same_for_any_number_of_threads_and_prices_change_it() {
    let one = advised("--jobs 1");
    let mut two = advised("--jobs 2");
    for (choice, own) in [("advised", &one["advised"]), ("runner_up", &one["runner_up"])] {
        let time = "time_per_macro_step_s";
        assert!(own[time].as_f64().unwrap() > 0.0, "{own}");
        two[choice][time] = own[time].clone();
    }
    assert_eq!(two, one);
    let run = &one["advised"]["runs"][1];
    let typed: Vec<&str> = run["command"].as_str().unwrap().split(' ').skip(1).collect();
    let facts = json(crate::program::rimbench().args(typed).args(["--format", "json"]));
    assert_eq!((&facts["run_id"], &facts[METRIC]), (&run["run_id"], &run["error"]));
    // Where mechanics solves cost everything, as few of them as can be are advised.
    let dear = advised("--costs 0,1e6,0,0");
    let solves = |advice: &Value| advice["advised"]["mechanics_solves"].as_f64().unwrap();
    assert!(solves(&dear) <= solves(&one));
    assert_eq!(dear["advised"]["cost"].as_f64().unwrap(), 1e6 * solves(&dear));
    // Up to a macro step at which it is still good: that there may be larger ones is said.
    let short = advised("--to 5e-6");
    assert!(
        short["advised"]["is_largest_tried"] == true && short["notes"][0].as_str().unwrap().contains("largest"),
        "{short}"
    );
}

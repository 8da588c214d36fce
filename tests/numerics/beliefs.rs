//! What schemes believe within one macro step from one true state: a contact opens, or a contact closes.

use crate::support::*;
use rimbench::runs::{believed, what_happens};

const REVERSAL: (&str, f64, f64) = ("wedge-box-reversal", 0.3, 10e-3);
const LANDING: (&str, f64, f64) = ("wedge-box", 1.695, 5e-3);

fn asked((case, _, step): (&str, f64, f64), scheme: &str) -> RunRequest {
    let margin = (scheme == "rim-smooth").then_some(ContactDetection::Margin { width: 1e-3 });
    RunRequest { contact_detection: margin, ..RunRequest::of(case, scheme).at_macro_step(step) }
}

/// What happens, and what a scheme believes.
fn both(of: (&str, f64, f64), scheme: &str) -> [Trajectory; 2] {
    let spec = asked(of, scheme).resolve(catalogue()).unwrap();
    let from = what_happens(&spec, catalogue(), of.1, StopFlag::never()).unwrap();
    let belief = believed(&spec, &from).unwrap();
    [from.happens, belief]
}

fn column(rows: &Trajectory, name: &str) -> Vec<f64> {
    rows.column(rows.index_of(name).unwrap()).collect()
}

/// The force at the end, and its mean over the macro step, N.
fn force(rows: &Trajectory) -> [f64; 2] {
    let force = column(rows, "actuator_force_n");
    let (end, before) = force.split_last().unwrap();
    [*end, before.iter().sum::<f64>() / before.len() as f64]
}

fn assert_near(found: [f64; 2], expected: [f64; 2], within: f64) {
    let near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= within);
    assert!(near, "{found:?} {expected:?}");
}

// Expected forces were computed from the equations of the interface model by another program, and agree to half a digit of
// what it prints. It took velocities at `t_k` as (q_k − q_{k−1})/h, so that a force of the landing differs by a digit.
const PRINTED: f64 = 5.1e-3;

#[test]
fn a_contact_that_opens_is_missed_by_a_hold_and_a_smooth_model_and_followed_by_the_others() {
    let [happens, hold] = both(REVERSAL, "zero-order-hold");
    assert_near(force(&happens), [1028.00, 451.35], PRINTED);
    assert_near(force(&hold), [2067.59, 677.86], PRINTED);
    for (scheme, expected) in [("rim-smooth", [2067.59, 677.86]), ("rim-nonsmooth", [1028.00, 451.35])] {
        assert_near(force(&both(REVERSAL, scheme)[1]), expected, PRINTED);
    }
    let gap_tracking = &both(REVERSAL, "rim-nonsmooth-gap")[1];
    assert_near(force(gap_tracking), [1028.00, 451.35], PRINTED);
    let [gap, true_gap] = [gap_tracking, &happens].map(|rows| *column(rows, "gap_disc_ledge_m").last().unwrap());
    assert!((gap - 7.56e-6).abs() < 5e-9 && (gap - true_gap).abs() < 5e-9, "{gap} {true_gap}");
}

#[test]
fn the_contact_that_a_smooth_model_holds_pulls_and_one_that_may_open_never_does() {
    let pull = |scheme: &str| column(&both(REVERSAL, scheme)[1], "contact_force_disc_ledge_n");
    let last = *pull("rim-smooth").last().unwrap();
    assert!((last + 13_813.2).abs() < 0.1, "{last}");
    assert!(pull("rim-nonsmooth").iter().all(|force| *force >= -1e-9));
}

#[test]
fn a_contact_that_closes_is_followed_by_gap_tracking_alone() {
    let [happens, hold] = both(LANDING, "zero-order-hold");
    assert_near(force(&happens), [-770.98, -495.85], PRINTED);
    assert_near(force(&hold), [-182.84, -182.83], PRINTED);
    assert_near(force(&both(LANDING, "rim-nonsmooth")[1]), [-182.83, -182.83], PRINTED);
    assert_near(force(&both(LANDING, "rim-smooth")[1]), [26_242.97, 15_911.22], 0.5);
    assert_near(force(&both(LANDING, "rim-nonsmooth-gap")[1]), [-771.15, -495.92], 2.0 * PRINTED);
}

/// Up to the reversal the box rests, in a run as together.
#[test]
fn a_belief_is_what_the_run_of_the_scheme_passes_to_the_mechanics() {
    let run = asked(REVERSAL, "rim-nonsmooth").resolve(catalogue()).unwrap();
    let rows = simulate(&run, Bounds::default(), None, StopFlag::never()).unwrap().trajectory;
    let passed = column(&rows, "force_to_mechanics_n")[31];
    let [_, mean] = force(&both(REVERSAL, "rim-nonsmooth")[1]);
    assert!((passed - mean).abs() < 1e-3, "{passed} {mean}");
}

#[test]
fn a_time_between_micro_steps_and_a_scheme_that_iterates_are_refused() {
    let spec = |scheme: &str| asked(REVERSAL, scheme).resolve(catalogue()).unwrap();
    let wrong = what_happens(&spec("zero-order-hold"), catalogue(), 0.300_01, StopFlag::never()).err().unwrap();
    assert!(wrong.to_string().contains("a multiple of the micro step, 0.00005 s"), "{wrong}");
    let wrong = what_happens(&spec("zero-order-hold"), catalogue(), 2.5, StopFlag::never()).err().unwrap();
    assert!(wrong.to_string().contains("ends within 1 s"), "{wrong}");
    let from = what_happens(&spec("iterated-aitken"), catalogue(), 0.3, StopFlag::never()).unwrap();
    let wrong = believed(&spec("iterated-aitken"), &from).unwrap_err().to_string();
    assert!(wrong.contains("iterated-aitken iterates"), "{wrong}");
}

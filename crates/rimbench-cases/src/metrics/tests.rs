//! Metrics on runs small enough to be worked by hand.

use super::*;
use rimbench_core::cosim::{Outcome, Report, Trajectory};

/// Time, force, force received, gap: what the metrics look at here.
const COLUMNS: [&str; 4] = ["time_s", "f_n", "force_to_mechanics_n", "gap_m"];

/// A run, and all that a metric may want to know besides.
struct Given<'a> {
    run: Trajectory,
    reference: Trajectory,
    report: Report,
    touch_downs: Vec<[f64; 2]>,
    inside: Option<Inside<'a>>,
    effective_mass: Option<usize>,
}

impl Given<'_> {
    /// Communication points every 10 ms with forces, received over the step that ends there, and gaps; the impulse of the reference.
    fn new(forces: &[f64], gaps: &[f64], impulses: &[f64]) -> Self {
        let rows = forces.iter().zip(gaps).enumerate();
        let run = rows.flat_map(|(k, (force, gap))| [time(k), *force, *force, *gap]).collect();
        let reference = impulses.iter().enumerate().flat_map(|(k, impulse)| [time(k), *impulse]).collect();
        Given {
            run: Trajectory::from_data(COLUMNS.map(str::to_owned).to_vec(), run),
            reference: Trajectory::from_data(vec!["time_s".to_owned(), impulse_column("f_n")], reference),
            report: Report::not_run(Outcome::Completed),
            touch_downs: Vec::new(),
            inside: None,
            effective_mass: None,
        }
    }

    fn value(&self, name: &str) -> Option<f64> {
        let metric = METRICS.iter().find(|metric| metric.name == name).unwrap();
        let (reference_force_peak, reference_touch_down_peak) = (Some(9.0), Some(4.0));
        // Position and velocity are not looked at: any column will do.
        let row = InterfaceRow { position: 3, velocity: 3, force: 1, reference_force_peak, reference_touch_down_peak };
        (metric.compute)(&Evidence {
            run_contacts: &[contact_intervals(&self.run, 3)],
            interface: &[row],
            effective_mass: self.effective_mass,
            gaps: &[3],
            touch_downs: &self.touch_downs,
            inside: self.inside.as_ref(),
            ..Evidence::bare(&self.run, &self.reference, &self.report)
        })
    }
}

fn time(k: usize) -> f64 {
    k as f64 * 0.01
}

const OPEN: [f64; 8] = [1.0; 8];
const IMPULSE: &str = "impulse_error_20ms_n_s";

#[test]
fn a_force_that_is_off_by_a_constant_is_off_by_its_impulse_in_every_window() {
    // 5 N received, 3 N in the reference: 2 N over the 20 ms of a window.
    let impulses: Vec<f64> = (0..8).map(|k| 3.0 * time(k)).collect();
    let error = Given::new(&[5.0; 8], &OPEN, &impulses).value(IMPULSE).unwrap();
    approx::assert_relative_eq!(error, 0.04, epsilon = 1e-14);
}

#[test]
fn an_impulse_that_comes_late_counts_where_a_window_parts_it_and_one_that_is_spread_does_not_otherwise() {
    // 0.05 N s within the step that ends at 20 ms in the reference, a step later in the run: the window that ends at 20 ms lacks it.
    let mut forces = [0.0; 8];
    forces[3] = 5.0;
    let late = Given::new(&forces, &OPEN, &[0.0, 0.0, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05]).value(IMPULSE).unwrap();
    approx::assert_relative_eq!(late, 0.05, epsilon = 1e-14);
    // The same step: nothing is wrong with the impulse, however short the reference's impact was.
    let same = Given::new(&forces, &OPEN, &[0.0, 0.0, 0.0, 0.05, 0.05, 0.05, 0.05, 0.05]).value(IMPULSE).unwrap();
    assert!(same.abs() < 1e-15, "{same:e}");
}

#[test]
fn a_run_shorter_than_a_window_has_no_impulse_error() {
    assert_eq!(Given::new(&[5.0; 2], &[1.0; 2], &[0.0; 2]).value(IMPULSE), None);
    assert_eq!(Given::new(&[], &[], &[]).value(IMPULSE), None);
}

#[test]
fn the_residual_in_impacts_is_that_of_the_steps_in_which_a_contact_closed() {
    const RESIDUAL: &str = "interface_residual_in_impacts_j";
    // Closed at rows 2 and 6, open again at 4.
    let mut given = Given::new(&[0.0; 8], &[1.0, 0.5, 0.0, 0.0, 1.0, 0.5, 0.0, 0.0], &[0.0; 8]);
    assert_eq!(given.value(RESIDUAL), None, "no residual was counted");
    let residual = [0.0, 1.0, 3.0, 3.5, 3.5, 3.0, 1.0, 9.0];
    given.report.interface_residual = (0..8).map(|k| [time(k), residual[k]]).collect();
    // 3 − 1 in the step to row 2, 1 − 3 in that to row 6.
    assert_eq!(given.value(RESIDUAL), Some(0.0));
    given.report.interface_residual[6][1] = 2.5;
    assert_eq!(given.value(RESIDUAL), Some(1.5));
    // Closed from the first row on: nothing closes.
    let mut resting = Given::new(&[0.0; 3], &[0.0; 3], &[0.0; 3]);
    resting.report.interface_residual = vec![[0.0, 0.0], [0.01, 5.0], [0.02, 7.0]];
    assert_eq!(resting.value(RESIDUAL), Some(0.0));
}

/// Errors of 3, 1, 4 and 2 N at the ends of four macro steps; what the run started from counts for nothing.
#[test]
fn the_rank_of_the_models_defect_is_that_of_the_force_errors_at_the_ends_of_macro_steps() {
    const RANK: &str = "model_defect_rank";
    let mut given = Given::new(&[99.0, 3.0, -1.0, 4.0, -2.0], &OPEN[..5], &[0.0; 5]);
    let zeros = (0..5).flat_map(|k| [time(k), 0.0]).collect();
    given.reference = Trajectory::from_data(["time_s", "f_n"].map(str::to_owned).to_vec(), zeros);
    assert_eq!(given.value(RANK), None, "no defect was noted");
    let with = |defects: [f64; 4]| defects.iter().enumerate().map(|(k, e)| [time(k + 1), *e]).collect::<Vec<_>>();
    given.report.model_defect = with([0.3, 0.1, 0.9, 0.2]);
    assert_eq!(given.value(RANK), Some(1.0));
    // Ranks 2 0 3 1 against 2 1 3 0: two are off by one, 1 − 6·2/(4·15).
    given.report.model_defect = with([0.3, 0.2, 0.9, 0.1]);
    approx::assert_relative_eq!(given.value(RANK).unwrap(), 0.8, epsilon = 1e-15);
}

#[test]
fn a_peak_at_the_opening_of_the_valve_is_no_touch_down() {
    const RATIO: &str = "touch_down_peak_ratio";
    let mut given = Given::new(&[0.0, 50.0, 0.0, 1.0, -6.0, 2.0, 0.0, 20.0], &OPEN, &[0.0; 8]);
    assert_eq!(given.value(RATIO), None, "nothing closes in the reference");
    given.touch_downs = vec![[0.025, 0.055]];
    assert_eq!(given.value(RATIO), Some(1.5));
    // A run that ended before has no peak there.
    given.touch_downs = vec![[0.5, 0.7]];
    assert_eq!(given.value(RATIO), None);
}

/// Of a reference with a dip of 4 N a run that sees 2 N of it is off by 2 N in one of the rows near it, and by 50 N elsewhere.
#[test]
fn a_touch_down_is_judged_by_itself() {
    const METRICS: [&str; 2] = ["touch_down_error_rms_of_peak", "reference_touch_down_peak_ratio"];
    let mut given = Given::new(&[0.0, 50.0, 0.0, 1.0, -2.0, 1.0, 0.0, 0.0], &OPEN, &[0.0; 8]);
    assert_eq!(METRICS.map(|name| given.value(name)), [None; 2], "nothing closes in the reference");
    given.touch_downs = vec![[0.025, 0.055]];
    let forces = [0.0, 0.0, 0.0, 1.0, -4.0, 1.0, 0.0, 0.0_f64];
    let rows = forces.iter().enumerate().flat_map(|(k, force)| [time(k), *force]).collect();
    given.reference = Trajectory::from_data(["time_s", "f_n"].map(str::to_owned).to_vec(), rows);
    let near = (0..8).filter(|&k| (0.025..=0.055).contains(&time(k))).count() as f64;
    approx::assert_relative_eq!(given.value(METRICS[0]).unwrap(), (4.0 / near).sqrt() / 4.0, max_relative = 1e-14);
    assert_eq!(given.value(METRICS[1]), Some(1.0));
}

#[test]
fn inside_a_macro_step_forces_are_compared_where_a_micro_step_starts_and_positions_in_its_middle() {
    let table = |columns: &[&str], data: Vec<f64>| {
        Trajectory::from_data(columns.iter().map(|name| (*name).to_owned()).collect(), data)
    };
    let log = table(&["time_s", "middle_s", "f_n", "gap_m"], vec![0.0, 0.5, 1.0, 10.0, 1.0, 1.5, 5.0, 10.0]);
    let forces = table(&["time_s", "f_n"], vec![0.0, 1.0, 1.0, 1.0]);
    let positions = table(&["time_s", "gap_m"], vec![0.5, 7.0, 1.5, 14.0]);
    let mut given = Given::new(&[], &[], &[]);
    assert_eq!(given.value("force_error_inside_rms_n"), None, "nothing was noted");
    given.inside = Some(Inside { log: &log, reference: [forces, positions] });
    // Errors 0 and 4 N, 3 and −4 m.
    assert_eq!(given.value("force_error_inside_rms_n"), Some(8.0_f64.sqrt()));
    assert_eq!(given.value("position_error_inside_rms_m"), Some(12.5_f64.sqrt()));
    // A coupling that exchanges other quantities has no such error.
    let other = table(&["time_s", "middle_s", "p_pa"], vec![0.0, 0.5, 1.0]);
    given.inside = Some(Inside { log: &other, reference: [other.clone(), other.clone()] });
    assert_eq!(given.value("force_error_inside_rms_n"), None);
}

#[test]
fn an_interface_that_is_locked_throughout_has_an_effective_mass_that_does_not_vary() {
    let ratio = |masses: &[f64]| {
        let mut given = Given::new(masses, &vec![1.0; masses.len()], &vec![0.0; masses.len()]);
        given.effective_mass = Some(1);
        given.value("effective_mass_ratio")
    };
    assert_eq!(ratio(&[200.0, 300.0]), Some(1.5));
    assert_eq!(ratio(&[200.0, f64::INFINITY]), Some(f64::INFINITY));
    assert_eq!(ratio(&[f64::INFINITY; 3]), Some(1.0));
    assert_eq!(ratio(&[f64::NAN, f64::INFINITY]), Some(1.0), "what is not known does not count");
    assert_eq!(ratio(&[f64::NAN; 2]), None, "nothing is known");
}

#[test]
fn a_position_of_half_a_step_later_is_right_half_a_step_back() {
    let columns = ["time_s", "s_m", "w_m_s"].map(str::to_owned).to_vec();
    let moved = |late: f64| (1..5).flat_map(|k| [time(k), 2.0 * (time(k) + late), 2.0]).collect();
    let [run, reference] = [0.005, 0.0].map(|late| Trajectory::from_data(columns.clone(), moved(late)));
    let row = InterfaceRow {
        position: 1,
        velocity: 2,
        force: 0,
        reference_force_peak: None,
        reference_touch_down_peak: None,
    };
    let report = Report::not_run(Outcome::Completed);
    let error = |name: &str, half_steps: &[f64]| {
        let metric = METRICS.iter().find(|metric| metric.name == name).unwrap();
        (metric.compute)(&Evidence { interface: &[row], half_steps, ..Evidence::bare(&run, &reference, &report) })
            .unwrap()
    };
    approx::assert_abs_diff_eq!(error("position_error_rms_m", &[]), 0.01, epsilon = 1e-15);
    approx::assert_abs_diff_eq!(error("position_error_aligned_rms_m", &[0.005; 4]), 0.0, epsilon = 1e-15);
    approx::assert_abs_diff_eq!(error("position_error_aligned_rms_m", &[0.0; 4]), 0.01, epsilon = 1e-15);
}

#[test]
fn a_run_ends_as_predicted_if_it_completes_and_does_not_grow_or_neither() {
    let given = |outcome: Outcome, predicted_growth: Option<f64>| {
        let (given, report) = (Given::new(&OPEN, &OPEN, &[]), Report::not_run(outcome));
        let evidence = Evidence { predicted_growth, ..Evidence::bare(&given.run, &given.reference, &report) };
        ["completed_as_predicted", "failed_unforeseen"]
            .map(|name| (METRICS.iter().find(|metric| metric.name == name).unwrap().compute)(&evidence))
    };
    let failed = || Outcome::OutOfRange { at_s: 1.0, quantity: "x".into(), value: 0.0 };
    let completed = |growth| given(Outcome::Completed, Some(growth));
    let values = |pairs: [[f64; 2]; 3]| pairs.map(|pair| pair.map(Some));
    assert_eq!([0.9, 1.0, 1.1].map(completed), values([[1.0, 0.0], [1.0, 0.0], [0.0, 0.0]]));
    // Only a failure that was not foreseen errs on the unsafe side.
    assert_eq!(
        [0.9, 1.0, 1.1].map(|growth| given(failed(), Some(growth))),
        values([[0.0, 1.0], [0.0, 1.0], [1.0, 0.0]])
    );
    assert_eq!([given(Outcome::Completed, None), given(Outcome::Timeout { at_s: 1.0 }, Some(0.9))], [[None; 2]; 2]);
}

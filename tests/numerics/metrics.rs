//! Metrics on runs small enough to be worked by hand.

use crate::support::*;
use rimbench::metrics::{Columns, Evidence, InterfaceRow, METRICS, Sums, contact_intervals, friction_phases};

/// The sums of a run, taken all at once; they must be those of rows one by one, and of halves.
fn sums(columns: Columns, run: &Trajectory, reference: &Trajectory, residuals: &[f64]) -> Sums {
    let of = |block: usize| {
        let mut sums = Sums::new(columns.clone());
        for start in (0..run.len()).step_by(block.max(1)) {
            let rows = start..run.len().min(start + block);
            let rest = (start.min(reference.len()), reference.len().saturating_sub(start));
            sums.add(run, rows, &reference.slice(rest.0, rest.1), residuals.get(start..).unwrap_or_default());
        }
        sums
    };
    let whole = of(run.len());
    for block in [1, run.len().div_ceil(2)] {
        assert_eq!(format!("{:?}", of(block)), format!("{whole:?}"), "blocks of {block}");
    }
    whole
}

/// A run of which nothing else is known.
fn bare<'a>(sums: &'a Sums, report: &'a Report) -> Evidence<'a> {
    Evidence {
        sums,
        run_contacts: &[],
        reference_contacts: &[],
        run_friction: &[],
        reference_friction: &[],
        report,
        audited: false,
        predicted_growth: None,
    }
}

/// The value of a metric by name.
fn measured(name: &str, evidence: &Evidence<'_>) -> Option<f64> {
    (METRICS.iter().find(|metric| metric.name == name).unwrap().compute)(evidence)
}

/// What a run comes to does not depend on whether its rows are kept, and where no trace is wanted few are.
#[test]
fn a_run_whose_trace_is_not_wanted_keeps_its_last_rows_and_comes_to_the_same() {
    let options: [&[(&str, &str)]; 2] = [
        &[("macro_step_s", "0.2e-3")],
        &[("macro_step_s", "0.2e-3"), ("step_control", "model-defect"), ("step_tolerance", "1e3")],
    ];
    // Rows that are one macro step late.
    let late = |case: &str| {
        [("published_driver", "true")].into_iter().filter(|_| case == "hydraulic-crane").collect::<Vec<_>>()
    };
    for (case, scheme, options) in [
        ("wedge-box", "zero-order-hold", options[0]),
        ("wedge-box-friction", "rim-nonsmooth-gap", options[1]),
        ("hydraulic-crane", "zero-order-hold", options[0]),
    ] {
        let mut options = options.to_vec();
        options.push(("duration_s", "1.0"));
        let spec = spec_with(case, scheme, &options, &late(case));
        let reference = Reference::compute(&spec, StopFlag::never()).unwrap();
        let [whole, few] = [true, false]
            .map(|wanted| spec.prepare().unwrap().evaluate(&reference, true, wanted, None, StopFlag::never()).unwrap());
        let result = simulate_inside(&spec, reference.bounds(&spec).unwrap(), None, StopFlag::never()).unwrap();
        let after = evaluate(&spec, result, &reference).unwrap();
        for other in [&whole, &few] {
            assert_eq!(format!("{:?}", other.found), format!("{:?}", after.found), "{case}");
        }
        assert_eq!(whole.trajectory, after.trajectory, "{case}");
        let (rows, kept) = (whole.trajectory.len(), few.trajectory.len());
        assert!(rows > 1500 && kept <= 1025, "{case}: {kept} of {rows}");
        assert_eq!(few.trajectory.row(kept - 1), whole.trajectory.row(rows - 1), "{case}");
    }
}

/// Time, force, force received, gap: what the metrics look at here.
const COLUMNS: [&str; 4] = ["time_s", "f_n", "force_to_mechanics_n", "gap_m"];

/// A run, and all that a metric may want to know besides.
struct Given {
    run: Trajectory,
    reference: Trajectory,
    report: Report,
    touch_downs: Vec<[f64; 2]>,
    inside: Option<[Trajectory; 3]>,
    effective_mass: Option<usize>,
    residuals: Vec<f64>,
}

impl Given {
    /// Communication points every 10 ms with forces, received over the step that ends there, and gaps; the impulse of
    /// the reference.
    fn new(forces: &[f64], gaps: &[f64], impulses: &[f64]) -> Self {
        let rows = forces.iter().zip(gaps).enumerate();
        let run = rows.flat_map(|(k, (force, gap))| [time(k), *force, *force, *gap]).collect();
        let reference = impulses.iter().enumerate().flat_map(|(k, impulse)| [time(k), *impulse]).collect();
        Given {
            run: Trajectory::from_data(COLUMNS.map(str::to_owned).to_vec(), run),
            reference: Trajectory::from_data(vec!["time_s".to_owned(), "f_n_impulse_n_s".to_owned()], reference),
            report: Report::not_run(Outcome::Completed),
            touch_downs: Vec::new(),
            inside: None,
            effective_mass: None,
            residuals: Vec::new(),
        }
    }

    fn value(&self, name: &str) -> Option<f64> {
        let (reference_force_peak, reference_touch_down_peak) = (Some(9.0), Some(4.0));
        // Position and velocity are not looked at: any column will do.
        let row = InterfaceRow { position: 3, velocity: 3, force: 1, reference_force_peak, reference_touch_down_peak };
        let columns = Columns {
            interface: vec![row],
            effective_mass: self.effective_mass,
            gaps: vec![3],
            touch_downs: self.touch_downs.clone(),
            each_force_error: true,
            ..Columns::default()
        };
        let mut sums = sums(columns, &self.run, &self.reference, &self.residuals);
        if let Some([log, forces, positions]) = &self.inside {
            sums.add_inside(self.run.columns(), log, [forces, positions]);
        }
        let run_contacts = &[contact_intervals(&self.run, 3)];
        measured(name, &Evidence { run_contacts, ..bare(&sums, &self.report) })
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
    // 0.05 N s within the step that ends at 20 ms in the reference, a step later in the run: the window that ends at 20
    // ms lacks it.
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
    given.residuals = residual.to_vec();
    // 3 − 1 in the step to row 2, 1 − 3 in that to row 6.
    assert_eq!(given.value(RESIDUAL), Some(0.0));
    given.residuals[6] = 2.5;
    assert_eq!(given.value(RESIDUAL), Some(1.5));
    // Closed from the first row on: nothing closes.
    let mut resting = Given::new(&[0.0; 3], &[0.0; 3], &[0.0; 3]);
    resting.residuals = vec![0.0, 5.0, 7.0];
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

/// Of a reference with a dip of 4 N a run that sees 2 N of it is off by 2 N in one of the rows near it, and by 50 N
/// elsewhere.
#[test]
fn a_touch_down_is_judged_by_itself() {
    const NAMES: [&str; 2] = ["touch_down_error_rms_of_peak", "reference_touch_down_peak_ratio"];
    let mut given = Given::new(&[0.0, 50.0, 0.0, 1.0, -2.0, 1.0, 0.0, 0.0], &OPEN, &[0.0; 8]);
    assert_eq!(NAMES.map(|name| given.value(name)), [None; 2], "nothing closes in the reference");
    given.touch_downs = vec![[0.025, 0.055]];
    let forces = [0.0, 0.0, 0.0, 1.0, -4.0, 1.0, 0.0, 0.0_f64];
    let rows = forces.iter().enumerate().flat_map(|(k, force)| [time(k), *force]).collect();
    given.reference = Trajectory::from_data(["time_s", "f_n"].map(str::to_owned).to_vec(), rows);
    let near = (0..8).filter(|&k| (0.025..=0.055).contains(&time(k))).count() as f64;
    approx::assert_relative_eq!(given.value(NAMES[0]).unwrap(), (4.0 / near).sqrt() / 4.0, max_relative = 1e-14);
    assert_eq!(given.value(NAMES[1]), Some(1.0));
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
    given.inside = Some([log, forces, positions]);
    // Errors 0 and 4 N, 3 and −4 m.
    assert_eq!(given.value("force_error_inside_rms_n"), Some(8.0_f64.sqrt()));
    assert_eq!(given.value("position_error_inside_rms_m"), Some(12.5_f64.sqrt()));
    // A coupling that exchanges other quantities has no such error.
    let other = table(&["time_s", "middle_s", "p_pa"], vec![0.0, 0.5, 1.0]);
    given.inside = Some([0, 1, 2].map(|_| other.clone()));
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
    // Nothing has been stepped at the start, where it is in time.
    let at = |k: usize, late: f64| time(k) + if k == 1 { 0.0 } else { late };
    let moved = |late: f64| (1..5).flat_map(|k| [time(k), 2.0 * at(k, late), 2.0]).collect();
    let [run, reference] = [0.005, 0.0].map(|late| Trajectory::from_data(columns.clone(), moved(late)));
    let row = InterfaceRow {
        position: 1,
        velocity: 2,
        force: 0,
        reference_force_peak: None,
        reference_touch_down_peak: None,
    };
    let report = Report::not_run(Outcome::Completed);
    let error = |name: &str, first_order: Option<(MechanicsSteps, f64)>| {
        let columns = Columns { interface: vec![row], first_order, ..Columns::default() };
        measured(name, &bare(&sums(columns, &run, &reference, &[]), &report)).unwrap()
    };
    let (late, one) = (0.01 * f64::sqrt(0.75), Some((MechanicsSteps::ONE, 1e-4)));
    approx::assert_abs_diff_eq!(error("position_error_rms_m", one), late, epsilon = 1e-15);
    approx::assert_abs_diff_eq!(error("position_error_aligned_rms_m", one), 0.0, epsilon = 1e-15);
    approx::assert_abs_diff_eq!(error("position_error_aligned_rms_m", None), late, epsilon = 1e-15);
}

#[test]
fn a_run_ends_as_predicted_if_it_completes_and_does_not_grow_or_neither() {
    let given = |outcome: Outcome, predicted_growth: Option<f64>| {
        let (sums, report) = (Sums::default(), Report::not_run(outcome));
        let evidence = Evidence { predicted_growth, ..bare(&sums, &report) };
        ["completed_as_predicted", "failed_unforeseen"].map(|name| measured(name, &evidence))
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

/// Rows at times `step` apart up to `end`.
fn gaps_over(step: f64, end: f64, gaps: impl Fn(f64) -> [f64; 2]) -> Trajectory {
    let rows = (0..=(end / step).round() as usize).map(|k| k as f64 * step);
    let data = rows.flat_map(|t| [t, gaps(t)[0], gaps(t)[1]]).collect();
    Trajectory::from_data(["time_s", "gap_a_m", "gap_b_m"].map(str::to_owned).to_vec(), data)
}

fn event_values(run: &Trajectory, reference: &Trajectory) -> [Option<f64>; 3] {
    let aligned = reference.resampled(run.column(0));
    let report = Report::not_run(Outcome::Completed);
    let sums = sums(Columns { gaps: vec![1, 2], ..Columns::default() }, run, &aligned, &[]);
    let evidence = Evidence {
        run_contacts: &[1, 2].map(|gap| contact_intervals(run, gap)),
        reference_contacts: &[1, 2].map(|gap| contact_intervals(reference, gap)),
        ..bare(&sums, &report)
    };
    ["event_time_shift_max_s", "events_missed", "wrong_contact_state_s"].map(|name| measured(name, &evidence))
}

/// Approaches at 0.1 m/s, closed from `from` to `to`, then leaves at 0.1 m/s.
fn gap(t: f64, from: f64, to: f64) -> f64 {
    0.1 * (from - t).max(t - to).max(0.0)
}

#[test]
fn events_are_shifted_missed_and_wrong_for_as_long_as_they_were_made() {
    let reference = gaps_over(5e-5, 2.0, |t| [gap(t, 0.5, 1.0), gap(t, 1.2, 9.0)]);
    let same = event_values(&reference, &reference);
    assert_eq!(same, [Some(0.0), Some(0.0), Some(0.0)]);
    // 7 ms late to close, 10 ms late to open, on a grid of 5 ms; the other is 4 ms early.
    let run = gaps_over(5e-3, 2.0, |t| [gap(t, 0.507, 1.01), gap(t, 1.196, 9.0)]);
    let [shift, missed, wrong] = event_values(&run, &reference).map(Option::unwrap);
    approx::assert_relative_eq!(shift, 7e-3, epsilon = 1e-4);
    approx::assert_relative_eq!(wrong, 7e-3 + 10e-3 + 4e-3, epsilon = 3e-4);
    assert_eq!(missed, 0.0);
    // Contact b never closes: missed, and wrong to the end; what overlaps in time counts once.
    let run = gaps_over(5e-3, 2.0, |t| [gap(t, 0.5, 1.3), 1.0]);
    let [shift, missed, wrong] = event_values(&run, &reference).map(Option::unwrap);
    assert!(shift < 1e-4 && missed == 1.0, "{shift} {missed}");
    approx::assert_relative_eq!(wrong, 1.0, epsilon = 1e-3);
    // A run that ended before anything closed has missed nothing.
    let run = gaps_over(5e-3, 0.4, |t| [gap(t, 0.5, 1.0), 1.0]);
    assert_eq!(event_values(&run, &reference), [None, Some(0.0), Some(0.0)]);
}

#[test]
fn a_second_closing_does_not_steal_the_match_of_the_first() {
    let reference = gaps_over(5e-5, 2.0, |t| [gap(t, 0.5, 9.0), 1.0]);
    // Bounces off at 0.52 s for 40 ms: only the first closing is the reference's.
    let run = gaps_over(1e-3, 2.0, |t| [gap(t, 0.503, 0.52).min(gap(t, 0.56, 9.0)), 1.0]);
    let [shift, missed, wrong] = event_values(&run, &reference).map(Option::unwrap);
    approx::assert_relative_eq!(shift, 3e-3, epsilon = 1e-4);
    assert_eq!(missed, 0.0);
    approx::assert_relative_eq!(wrong, 43e-3, epsilon = 1e-3);
    // Closing 0.15 s late is not the same event.
    let run = gaps_over(1e-3, 2.0, |t| [gap(t, 0.65, 9.0), 1.0]);
    let [shift, missed, wrong] = event_values(&run, &reference);
    assert_eq!((shift, missed), (None, Some(1.0)));
    approx::assert_relative_eq!(wrong.unwrap(), 0.15, epsilon = 1e-3);
}

const FRICTION: [&str; 5] =
    ["wrong_friction_state_share", "release_time_shift_max_s", "releases_missed", "stick_intervals", "slip_reversals"];

/// Rows at times `step` apart up to `end`; the state is that of the interval before.
fn states_over(step: f64, end: f64, state: impl Fn(f64) -> f64) -> Trajectory {
    let rows = (0..=(end / step).round() as usize).map(|k| k as f64 * step);
    let data = rows.flat_map(|t| [t, state(t - 0.5 * step)]).collect();
    Trajectory::from_data(["time_s", "contact_state_a"].map(str::to_owned).to_vec(), data)
}

fn friction_values(run: &Trajectory, reference: &Trajectory) -> [Option<f64>; 5] {
    let phases = |of: &Trajectory| vec![friction_phases(of, 1)];
    let (aligned, report) = (reference.resampled(run.column(0)), Report::not_run(Outcome::Completed));
    let sums = sums(Columns { states: vec![1], ..Columns::default() }, run, &aligned, &[]);
    let evidence =
        Evidence { run_friction: &phases(run), reference_friction: &phases(reference), ..bare(&sums, &report) };
    FRICTION.map(|name| measured(name, &evidence))
}

/// Sticks up to `release`, slides forwards to 0.5 s, sticks to 0.7 s, slides back.
fn states(release: f64) -> impl Fn(f64) -> f64 {
    move |t| match t {
        t if t < release => 1.0,
        t if t < 0.5 => 2.0,
        t if t < 0.7 => 1.0,
        _ => 3.0,
    }
}

#[test]
fn a_late_release_is_shifted_and_wrong_for_as_long_as_it_is_late() {
    let reference = states_over(1e-4, 1.0, states(0.3));
    let same = friction_values(&reference, &reference);
    assert_eq!(same, [Some(0.0), Some(0.0), Some(0.0), Some(2.0), Some(1.0)]);
    let [wrong, shift, missed, sticks, reversals] =
        friction_values(&states_over(1e-2, 1.0, states(0.33)), &reference).map(Option::unwrap);
    approx::assert_relative_eq!(shift, 0.03, epsilon = 1e-9);
    approx::assert_relative_eq!(wrong, 0.03, epsilon = 1e-9);
    assert_eq!([missed, sticks, reversals], [0.0, 2.0, 1.0]);
}

#[test]
fn a_contact_that_never_lets_go_has_missed_its_releases() {
    let reference = states_over(1e-4, 1.0, states(0.3));
    let [wrong, shift, missed, sticks, reversals] = friction_values(&states_over(1e-2, 1.0, |_| 1.0), &reference);
    approx::assert_relative_eq!(wrong.unwrap(), 0.2 + 0.3, epsilon = 1e-9);
    assert_eq!([shift, missed, sticks, reversals], [None, Some(2.0), Some(1.0), Some(0.0)]);
    // One that ended before anything let go has missed nothing.
    let early = friction_values(&states_over(1e-2, 0.25, |_| 1.0), &reference);
    assert_eq!(early, [Some(0.0), None, Some(0.0), Some(1.0), Some(0.0)]);
}

#[test]
fn a_flicker_parts_no_stick_and_a_flight_does() {
    let flicker = |t: f64| if (0.4..0.404).contains(&t) { 2.0 } else { 1.0 };
    let [.., sticks, reversals] = friction_values(&states_over(1e-3, 1.0, flicker), &states_over(1e-3, 1.0, |_| 1.0));
    assert_eq!([sticks, reversals], [Some(1.0), Some(0.0)]);
    // Forwards, in the air, backwards: no reversal of a slip.
    let flight = |t: f64| {
        if t < 0.4 {
            2.0
        } else if t < 0.402 {
            0.0
        } else {
            3.0
        }
    };
    let [.., reversals] = friction_values(&states_over(1e-3, 1.0, flight), &states_over(1e-3, 1.0, |_| 1.0));
    assert_eq!(reversals, Some(0.0));
    let hop = |t: f64| if (0.4..0.404).contains(&t) { 0.0 } else { 1.0 };
    let [.., sticks, _] = friction_values(&states_over(1e-3, 1.0, hop), &states_over(1e-3, 1.0, |_| 1.0));
    assert_eq!(sticks, Some(2.0));
}

#[test]
fn a_case_without_friction_has_none_of_its_metrics() {
    let plain = Trajectory::from_data(vec!["time_s".to_owned()], vec![0.0, 1.0]);
    let (sums, report) = (sums(Columns::default(), &plain, &plain, &[]), Report::not_run(Outcome::Completed));
    assert_eq!(FRICTION.map(|name| measured(name, &bare(&sums, &report))), [None; 5]);
}

//! Coupling: where a reduced interface model is exact it must give the monolithic solution to round-off, schemes must
//! differ only where contacts do, and each sequence and force return must do what a calculation by hand does.

use crate::support::*;

const ACTUATOR_FIRST: Sequence = Sequence::GaussSeidel { first: Side::Actuator };
const RIM: [&str; 3] = ["rim-smooth", "rim-nonsmooth", "rim-nonsmooth-gap"];
/// Those that carry the whole model, free acceleration and contacts included.
const WHOLE_MODEL: [&str; 4] = ["rim-smooth", "rim-smooth-active", "rim-nonsmooth", "rim-nonsmooth-gap"];

/// A scheme on the ledge: until 0.4 s the wedge box only translates, and no contact opens or closes.
fn on_the_ledge(scheme: &str, macro_step: f64, force_return: ForceReturn, steps: MechanicsSteps) -> RunResult {
    let usual = wedge_box_spec(scheme, macro_step);
    let (sequence, duration) = (ACTUATOR_FIRST, 0.4);
    completed(&usual.changed(|own| {
        (own.force_return, own.mechanics_steps, own.sequence, own.duration) = (force_return, steps, sequence, duration)
    }))
}

/// What rounding may do to force and length of the wedge box on the ledge.
///
/// The length, 2.5 m, is rounded to 4e-16 m per micro step; the oil spring is 2 β A / l₁ = 2e7 N/m: 1e-8 N each time.
/// The cylinder's friction damps within 25 ms or 500 micro steps, of which the roundings add up like √500: 2e-7 N. In
/// the length they add up over all 8000: 4e-14 m, and the force's share (2e-7 N on 250 kg for 25 ms) is below that.
const FORCE_ROUNDING: f64 = 2e-7;
const LENGTH_ROUNDING: f64 = 4e-14;

#[test]
fn schemes_must_not_differ_while_no_contact_opens_or_closes() {
    let smooth = on_the_ledge("rim-smooth", 5e-3, ForceReturn::Mean, ONE);
    for other in ["rim-nonsmooth", "rim-nonsmooth-gap"] {
        // The left wedge is 33 mm up, the disc 60 mm above the floor: open contacts with gaps take no part either.
        let result = on_the_ledge(other, 5e-3, ForceReturn::Mean, ONE);
        for (name, limit) in
            [("actuator_force_n", FORCE_ROUNDING), ("actuator_length_m", LENGTH_ROUNDING), ("effective_mass_kg", 1e-10)]
        {
            let off = apart(&smooth.trajectory, &result.trajectory, name).0;
            // Mass: 250 kg from a few sums of condition 10.
            assert!(off <= limit, "{other}: {name} off by {off}");
        }
        assert_eq!(result.report.work.scheme.failures, 0);
        let work = result.report.work.scheme;
        assert!(work.solves + work.parametric >= 8000, "one complementarity problem per micro step");
        assert!(work.solves <= 100, "one that is solved per macro step: no contact opens or closes");
    }
    assert_eq!(smooth.report.work.scheme.solves, 0, "the smooth model solves none");
}

#[test]
fn at_the_touch_down_the_smooth_model_must_lock_and_the_nonsmooth_ones_must_not() {
    for phase in [0.2, 0.4, 0.6, 0.8, 1.0] {
        for scheme in RIM {
            let usual = wedge_box_spec(scheme, 5e-3);
            let margin = spec_with("wedge-box", "rim-smooth", &[("contact_detection", "margin:1e-3")], &[]);
            let result = run(&if scheme == "rim-smooth" { margin } else { usual }.changed(|own| own.phase = phase));
            let all = |name: &str| column(&result.trajectory, name);
            let heaviest = largest(all("effective_mass_kg"));
            let peak = largest(all("actuator_force_n").into_iter().map(f64::abs));
            let lift = largest(all("gap_right_wedge_m"));
            if scheme == "rim-smooth" {
                // The box approaches at 30 mm/s: the margin of 1 mm lasts 33 ms, at least six communication points with
                // three contacts closed. The oil spring of 2e7 N/m is then squeezed by 0.28 m/s × 5 ms = 1.4 mm, 28 kN
                // less what friction and valve let through.
                assert_eq!(heaviest, f64::INFINITY, "phase {phase}: the smooth model did not lock");
                assert!(peak > 5e3, "phase {phase}: no spike, {peak} N");
                assert!(lift > 1e-3, "phase {phase}: the box stayed down, {lift} m");
            } else {
                // On ledge, ramp or wedges the actuator feels 250 to 276.3 kg (closed forms in the wedge box's own
                // tests); a contact set that the margin makes up may not be far from one of them.
                assert!(heaviest < 300.0, "{scheme} phase {phase}: {heaviest} kg");
                // The reference peaks at 1009 N; its first swing is sampled at 5 ms.
                assert!(peak < 1.1 * 1009.0, "{scheme} phase {phase}: {peak} N");
                // Penetration cannot exceed, nor lift-off, one step's motion at the touch-down: 30 mm/s × 5 ms.
                assert!(lift < 1.5e-4, "{scheme} phase {phase}: {lift} m");
            }
        }
    }
}

/// A body on a guide (joint) with weight and a load, pushed against springs by one or two interface rows; on the floor.
fn linear_system(interface: usize) -> LinearModel {
    let rows: [(&[f64], f64); 2] = [(&[0.8, 0.6, -0.1], 1.0), (&[0.8, -0.6, 0.4], 2.0)];
    // Presses on the contact with 200 N and leaves 3.8 N·m/m along the one freedom (0.6, 0.8, −4) that is left.
    let body = LinearModel::new(&[2.0, 3.0, 0.4], &[5.0, -200.0, -40.2], &rows[..interface]);
    // Guide along (0.6, 0.8), then down onto the floor: its reaction is part of the model, its normal is not the
    // guide's.
    let bilateral = ConstantRows::new(&[(&[0.8, -0.6, 0.0], 0.0)]);
    LinearModel { bilateral, ..body.over(&[(&[0.0, 1.0, 0.2], 0.0)]) }
}

fn linear_springs(interface: usize) -> Springs {
    Springs::new(&[300.0, 500.0][..interface], &[4.0, 2.0][..interface])
}

/// Largest difference between co-simulation and monolithic solution of a mechanics of constant matrices, relative to
/// the largest value of each variable.
fn off_monolithic(
    scheme: &str,
    interface: usize,
    grid: CommunicationGrid,
    micro_step: f64,
    build: &dyn Fn() -> NonSmoothMechanics<LinearModel>,
) -> (f64, Vec<Vec<f64>>) {
    let both = || (build(), linear_springs(interface));
    let (mut mechanics, mut springs) = both();
    let rows = coupled_rows(scheme, grid, micro_step, sides(&mut mechanics, &mut springs), None);
    let (mut mechanics, mut springs) = both();
    let steps = reference_steps(micro_step, (grid.duration() / micro_step).round() as usize, 1);
    let reference = monolithic_rows(steps, sides(&mut mechanics, &mut springs));
    let width = 1 + 3 * interface;
    let scale: Vec<f64> = (0..width).map(|c| largest(reference.iter().map(|row| row[c].abs()))).collect();
    let mut worst = 0.0_f64;
    for row in &rows {
        let same = &reference[(row[0] / micro_step).round() as usize];
        for c in 0..width {
            worst = worst.max((row[c] - same[c]).abs() / scale[c]);
        }
    }
    (worst, rows)
}

#[test]
fn a_model_with_constant_matrices_must_be_exact_for_any_macro_step_and_interface() {
    for interface in [1, 2] {
        for scheme in WHOLE_MODEL {
            for (macro_step, phase) in [(0.01, 1.0), (0.1, 1.0), (0.1, 0.35), (0.5, 0.2)] {
                let grid = CommunicationGrid::new(macro_step, phase, 2.0).unwrap();
                let build = || stepper(linear_system(interface), PLASTIC);
                let (off, rows) = off_monolithic(scheme, interface, grid, 1e-3, &build);
                // 2000 micro steps, each rounding a dozen sums; the oscillation carries an error on without amplifying
                // it, up to its number of radians, 15 rad/s × 2 s: 2000 × 30 ε at the very worst, 45 × 30 ε if random.
                let round_off = 2000.0 * 30.0 * f64::EPSILON;
                assert!(off < round_off, "{scheme} m={interface} H={macro_step} phase {phase}: {off}");
                let moved = largest(rows.iter().map(|row| (row[1] - 1.0).abs()));
                assert!(moved > 1e-3, "it must have moved: {moved} m");
            }
        }
    }
}

#[test]
fn the_linear_system_must_keep_its_contact_loaded_or_the_exactness_above_means_little() {
    for interface in [1, 2] {
        let mut mechanics: NonSmoothMechanics<_> = stepper(linear_system(interface), PLASTIC);
        let mut springs = linear_springs(interface);
        let (mut force, mut y) = (vec![0.0; interface], vec![0.0; 2 * interface]);
        for step in 0..2000 {
            mechanics.outputs(&force, &mut y).unwrap();
            if step > 0 {
                springs.step(0.0, &y, 1e-3).unwrap();
            }
            springs.outputs(&y, &mut force).unwrap();
            mechanics.step(0.0, &force, 1e-3).unwrap();
            let load = mechanics.contact_impulses()[0] / 1e-3;
            assert!(load > 10.0, "m={interface}: the contact carries {load} N in step {step}");
        }
    }
}

/// A ball of 1 kg that falls from 2 cm and bounces, hung on a spring of 30 N/m; height and velocity at all
/// communication points.
fn bouncing(scheme: Option<&str>, restitution: f64, macro_step: f64) -> Vec<[f64; 2]> {
    let model = LinearModel::new(&[1.0], &[-9.81], &[(&[1.0], 0.0)]).over(&[(&[1.0], 0.02)]);
    let law = ContactLaw { restitution, ..PLASTIC };
    let (mut mechanics, mut spring) = (stepper(model, law), Springs::new(&[30.0], &[0.0]));
    let sides = sides(&mut mechanics, &mut spring);
    let rows = match scheme {
        Some(name) => coupled_rows(name, CommunicationGrid::new(macro_step, 1.0, 1.0).unwrap(), 1e-3, sides, None),
        None => monolithic_rows(reference_steps(1e-3, 1000, (macro_step / 1e-3).round() as usize), sides),
    };
    rows.iter().map(|row| [row[1], row[2]]).collect()
}

#[test]
fn a_bounce_within_the_macro_step_must_be_that_of_the_mechanics() {
    for restitution in [0.0, 0.5, 0.9] {
        let bounces = bouncing(None, restitution, 1e-3);
        let count = bounces.windows(2).filter(|pair| pair[0][1] < -1e-3 && pair[1][1] > 1e-3).count();
        assert!(if restitution == 0.0 { count == 0 } else { count >= 4 }, "e = {restitution}: {count} bounces");
        let reference = bouncing(None, restitution, 0.1);
        let coupled = bouncing(Some("rim-nonsmooth-gap"), restitution, 0.1);
        assert_eq!(reference.len(), coupled.len());
        for (coupled, reference) in coupled.iter().zip(&reference) {
            // Heights of 2 cm and velocities of 0.6 m/s after 1000 micro steps of a few roundings each.
            approx::assert_abs_diff_eq!(coupled[0], reference[0], epsilon = 1e-14);
            approx::assert_abs_diff_eq!(coupled[1], reference[1], epsilon = 1e-12);
        }
    }
}

/// A mechanics that offers its reduced model a few times and then no longer, as one in another process might.
struct Withdraws {
    inner: Box<dyn Subsystem>,
    offers_left: usize,
}

impl Subsystem for Withdraws {
    subsystem_methods!(step_of_inner ports_of_inner outputs_of_inner counters_of_inner no_clone);
    fn capabilities(&mut self) -> &mut dyn Capabilities {
        self
    }
}

impl Capabilities for Withdraws {
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel> {
        self.inner.capabilities().empty_interface_model()
    }
    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        let Some(left) = self.offers_left.checked_sub(1) else { return Ok(false) };
        self.offers_left = left;
        self.inner.capabilities().interface_model(h, model)
    }
}

#[test]
fn a_model_that_is_withdrawn_must_end_the_run_and_not_be_used_stale() {
    let run = |offers_left: usize| {
        let PerSide { mechanics, mut actuator } = usual_system(case_by_name("wedge-box")).sides;
        let mut mechanics = Withdraws { inner: mechanics, offers_left };
        let grid = CommunicationGrid::new(5e-3, 1.0, 0.1).unwrap();
        let setup = Setup::new(grid, 5e-5, ACTUATOR_FIRST, ForceReturn::Mean);
        let mut sides = PerSide { mechanics: &mut mechanics as &mut dyn Subsystem, actuator: &mut *actuator };
        let coupling = coupled(scheme_by_name("rim-nonsmooth"), sides.lend());
        observed(&setup, sides, coupling, &mut |_| {})
    };
    // 20 macro steps have 21 communication points.
    assert_eq!(run(21).outcome, Outcome::Completed);
    let report = run(7);
    assert_eq!(report.outcome.name(), "subsystem-failed");
    approx::assert_abs_diff_eq!(report.outcome.at_s().unwrap(), 7.0 * 5e-3, epsilon = 1e-15);
    assert!(report.outcome.reason().contains("interface model"), "{}", report.outcome.reason());
    assert_eq!(report.work.cosim.macro_steps, 7);
    // What was never there is no failure of the run: case and scheme do not go together.
    assert_eq!(run(0).outcome.name(), "skipped");
}

/// Two macro steps of 0.5 s with two micro steps each: mass 2 kg, spring 4 N/m that integrates its own deflection.
fn by_hand(
    scheme: &str,
    sequence: Sequence,
    force_return: ForceReturn,
    mechanics_steps: MechanicsSteps,
) -> Vec<[f64; 4]> {
    let model = LinearModel::new(&[2.0], &[0.0], &[(&[1.0], 0.0)]).moving(&[1.0]);
    let (mut mechanics, mut spring) = (stepper(model, PLASTIC), Springs::new(&[4.0], &[0.0]));
    let grid = CommunicationGrid::new(0.5, 1.0, 1.0).unwrap();
    let mut setup = Setup::new(grid, 0.25, sequence, force_return);
    setup.mechanics_steps = mechanics_steps;
    let entry = scheme_by_name(scheme);
    let (report, rows) = rows_of(&setup, sides(&mut mechanics, &mut spring), entry);
    assert_eq!(report.outcome, Outcome::Completed);
    // Position, velocity, force at the point, force received since the last one.
    rows.iter().map(|row| [row[1], row[2], row[3], row[4]]).collect()
}

#[test]
fn sequences_and_force_returns_must_do_what_the_calculation_by_hand_does() {
    // F = −4 x, v̇ = F/2. All numbers are sums of powers of two: no rounding, so equality is meant.
    //
    // held: F₀ = 0, v = 1, s = 0.5, x = 0.5;          F₁ = −2, v = 1 − ½·1 = 0.5, s = 0.75, x = 0.5 + ½·1 = 1, F₂ = −4
    let held = vec![[0.0, 1.0, 0.0, 0.0], [0.5, 1.0, -2.0, 0.0], [0.75, 0.5, -4.0, -2.0]];
    assert_eq!(by_hand("zero-order-hold", Sequence::Jacobi, ForceReturn::Held, ONE), held);
    // With the actuator first but its past returned, nothing changes.
    assert_eq!(by_hand("zero-order-hold", ACTUATOR_FIRST, ForceReturn::Held, ONE), held);
    // end: x = 0.5, F = −2 over the first step: v = 0.5, s = 0.25;     x = 0.75, F = −3: v = −0.25, s = 0.125
    assert_eq!(
        by_hand("zero-order-hold", ACTUATOR_FIRST, ForceReturn::End, ONE),
        [[0.0, 1.0, 0.0, 0.0], [0.25, 0.5, -2.0, -2.0], [0.125, -0.25, -3.0, -3.0]]
    );
    // mean: F = 0, −1: mean −½: v = 0.875, s = 0.4375;     F = −2, −2.875: mean −2.4375: v = 0.265625, s = 0.5703125
    assert_eq!(
        by_hand("zero-order-hold", ACTUATOR_FIRST, ForceReturn::Mean, ONE),
        [[0.0, 1.0, 0.0, 0.0], [0.4375, 0.875, -2.0, -0.5], [0.5703125, 0.265625, -3.75, -2.4375]]
    );
    // profile in two sub-steps: the same forces and so the same velocities, but each when it acted: s differs.
    assert_eq!(
        by_hand("zero-order-hold", ACTUATOR_FIRST, ForceReturn::Profile, MechanicsSteps::count(2).unwrap()),
        [[0.0, 1.0, 0.0, 0.0], [0.46875, 0.875, -2.0, -0.5], [0.69140625, 0.265625, -3.75, -2.4375]]
    );
    // Mechanics first: it steps with the force held, and the spring then with the velocity at the end of the step:
    // v = 1, x = 0.5;     F = −2: v = 0.5, s = 0.75, x = 0.5 + ½·0.5 = 0.75, F₂ = −3
    assert_eq!(
        by_hand("zero-order-hold", Sequence::GaussSeidel { first: Side::Mechanics }, ForceReturn::Held, ONE),
        [[0.0, 1.0, 0.0, 0.0], [0.5, 1.0, -2.0, 0.0], [0.75, 0.5, -3.0, -2.0]]
    );
    // Linear extrapolation starts as the hold. In the second step the spring gets the velocity 1 (twice the same) and
    // the mechanics, at the middle of its step, F = −2 + (−2 − 0)/2 = −3: v = 1 − ½·1.5 = 0.25, s = 0.625.
    assert_eq!(
        by_hand("first-order-hold", Sequence::Jacobi, ForceReturn::Held, ONE),
        [[0.0, 1.0, 0.0, 0.0], [0.5, 1.0, -2.0, 0.0], [0.625, 0.25, -4.0, -3.0]]
    );
    // The reduced model moves along: w = 1, x = ¼, F = −1: w = 1 − ¼·½ = 0.875, x = 0.46875. With the mean (0 − 1)/2
    // the mechanics reaches the same velocity; the second step: F = −1.875, w = 0.640625, x = 0.62890625, F =
    // −2.515625, w = 0.326171875, x = 0.71044921875, F₂ = −2.841796875; mean −2.1953125, s = 0.4375 + ½ w.
    for scheme in WHOLE_MODEL {
        assert_eq!(
            by_hand(scheme, ACTUATOR_FIRST, ForceReturn::Mean, ONE),
            [
                [0.0, 1.0, 0.0, 0.0],
                [0.4375, 0.875, -1.875, -0.5],
                [0.6005859375, 0.326171875, -2.841796875, -2.1953125]
            ]
        );
    }
}

#[test]
fn a_force_return_that_the_sequence_cannot_deliver_must_be_refused() {
    let mechanics_first = Sequence::GaussSeidel { first: Side::Mechanics };
    for scheme in schemes() {
        for force_return in [ForceReturn::End, ForceReturn::Mean, ForceReturn::Profile] {
            for sequence in [Sequence::Jacobi, mechanics_first] {
                let message = scheme.sequence_and_return(Some(sequence), Some(force_return)).unwrap_err().to_string();
                assert!(
                    message.contains("actuator goes first") || message.contains("actuator must go first"),
                    "{message}"
                );
            }
        }
        let model_first = scheme.sequence_and_return(Some(mechanics_first), None);
        assert_eq!(model_first.is_err(), scheme.needs.contains(&Requirement::NotMechanicsFirst), "{}", scheme.name);
    }
}

/// A block on two feet of a rough floor, thrown against its springs; they pull at it obliquely, so that what presses
/// changes with them.
fn block_on_rough_floor(interface: usize, at_rest: f64) -> NonSmoothMechanics<LinearModel> {
    let rows: [(&[f64], f64); 2] = [(&[0.9, -0.2, 0.1], 1.0), (&[0.8, -0.1, -0.3], 2.0)];
    let block = LinearModel::new(&[2.0, 2.0, 0.4], &[0.0, -2.0 * 9.81, 0.0], &rows[..interface])
        .over(&[(&[0.0, 1.0, -0.5], 0.0), (&[0.0, 1.0, 0.5], 0.0)])
        .along(&[(&[1.0, 0.0, 0.2], 0.0), (&[1.0, 0.0, 0.2], 0.0)])
        .moving(&[1.5, 0.0, 0.0]);
    stepper(block, PLASTIC).with_friction(Friction { coefficient: 0.3, at_rest, restitution: 0.0 }, solver()).unwrap()
}

/// The theorem of exactness with friction: the states come with the model, with a coefficient at rest of its own what
/// they have left of it, and both sides take the same of several solutions.
#[test]
fn a_model_with_friction_and_constant_matrices_must_be_exact_through_slip_reversals_and_stick() {
    let micro_step = 1e-3;
    for (interface, at_rest) in [(1, 0.3), (2, 0.3), (1, 0.45), (2, 0.45)] {
        for macro_step in [4e-3, 20e-3, 100e-3] {
            let grid = CommunicationGrid::new(macro_step, 1.0, 1.2).unwrap();
            let (worst, rows) = off_monolithic("rim-nonsmooth-gap", interface, grid, micro_step, &|| {
                block_on_rough_floor(interface, at_rest)
            });
            // 1200 steps of the same numbers on two ways.
            assert!(worst <= 1e-10, "interface {interface}, at rest {at_rest}, H = {macro_step}: {worst}");
            let speeds: Vec<f64> = rows.iter().map(|row| row[1 + interface]).collect();
            let reversals = speeds.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
            assert!(reversals > 0 || macro_step > 50e-3, "it must slide back");
            assert!(speeds.last().unwrap().abs() <= 1e-12, "and stick at the end: {speeds:?}");
        }
    }
    // One that decides once per macro step does not go along.
    let grid = CommunicationGrid::new(20e-3, 1.0, 1.2).unwrap();
    for scheme in ["rim-smooth", "rim-smooth-active"] {
        let (worst, _) = off_monolithic(scheme, 1, grid, micro_step, &|| block_on_rough_floor(1, 0.3));
        assert!(worst > 1e-3, "{scheme}: {worst}");
    }
}

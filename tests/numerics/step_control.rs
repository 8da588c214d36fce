//! Step control: the error must stay near the tolerance, no step may go uncounted, and the times must add up.

use crate::support::*;
use rimbench_core::cosim::subsystem_methods;

use StepControl::EnergyResidual;

/// The quarter car over its step, chassis and wheel integrated exactly, so that all error is the coupling's.
fn quarter_car(scheme: &str, coupling: &str, macro_step: f64, control: Option<StepRule>) -> RunSpec {
    set_spec("quarter-car", &[("coupling", coupling)], scheme, macro_step).changed(|own| {
        (own.step_control, own.micro_step, own.mechanics_steps, own.sequence, own.force_return, own.duration) =
            (control, 1e-3, MechanicsSteps::AsActuator, Sequence::Jacobi, ForceReturn::Held, 2.0)
    })
}

fn control(kind: StepControl, tolerance: f64, macro_step: f64) -> Option<StepRule> {
    StepRule::new(kind, Some(tolerance), None, macro_step).unwrap()
}

/// Largest error of the wheel's position over the run, m; the step in the road is 0.1 m.
fn error(result: &RunResult) -> f64 {
    let case = case_by_name("quarter-car");
    let solution = exact_solution(case, &case.default_parameters());
    let wheel = result.trajectory.index_of("x2_m").unwrap();
    let mut exact = vec![0.0; result.trajectory.columns().len()];
    largest(result.trajectory.rows().map(|row| {
        solution(row[0], &mut exact);
        (row[wheel] - exact[wheel]).abs()
    }))
}

#[test]
fn a_smaller_tolerance_must_buy_a_smaller_error_with_more_steps() {
    // The first step is short (φ = 0.02): the energy residual takes nothing back, so what a long first step costs at
    // the step of the road would stay, whatever the tolerance.
    for scheme in ["zero-order-hold", "first-order-hold"] {
        let mut last = (f64::INFINITY, 0);
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let control = control(EnergyResidual, tolerance, 2e-2);
            let result =
                completed(&quarter_car(scheme, "force-displacement", 2e-2, control).changed(|own| own.phase = 0.02));
            let (error, steps) = (error(&result), result.report.work.cosim.macro_steps);
            assert!(error < last.0 && steps > last.1, "{scheme} {tolerance:e}: {error:e} m in {steps} steps");
            last = (error, steps);
        }
    }
}

/// Whatever model moves together with the actuator foresees where the mechanics will be, and is held against it.
#[test]
fn a_model_that_moves_with_the_actuator_must_set_the_steps_by_where_it_goes_astray() {
    for scheme in ["interface-mass", "rim-fixed-mass", "rim-smooth-active", "rim-nonsmooth", "rim-nonsmooth-gap"] {
        let [coarse, fine] = [1e-1, 1e-3].map(|tolerance| {
            let spec = usual_spec("wedge-box", scheme, 1e-2);
            completed(&spec.changed(|own| own.step_control = control(StepControl::ModelDefect, tolerance, 1e-2)))
        });
        let steps = |result: &RunResult| result.report.work.cosim.macro_steps;
        assert!(steps(&fine) > 2 * steps(&coarse), "{scheme}: {} and {} steps", steps(&coarse), steps(&fine));
    }
}

#[test]
fn times_must_add_up_and_every_step_must_be_counted() {
    for phase in [1.0, 0.3] {
        let control = control(EnergyResidual, 1e-2, 1e-2);
        let result =
            run(&quarter_car("zero-order-hold", "force-displacement", 1e-2, control).changed(|own| own.phase = phase));
        let (counters, rule) = (result.report.work.cosim, control.unwrap());
        let time = column(&result.trajectory, "time_s");
        assert_eq!((time[0], *time.last().unwrap(), result.report.ended_at_s), (0.0, 2.0, 2.0));
        assert_eq!(time.len() as u64, counters.macro_steps + 1);
        let lengths: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        // Differences of times up to 2 s are rounded to 4e-16 s.
        assert!(largest(lengths.iter().copied()) <= 1e-2 + 1e-15);
        let shortest = smallest(lengths[..lengths.len() - 1].iter().copied());
        assert!(shortest >= rule.shortest - 1e-15, "{shortest}");
        assert!(lengths.iter().any(|length| *length < 0.9e-2), "nothing was controlled");
        // The longest first step, φH, is what the run starts from.
        assert_eq!((time[1], counters.repeated_macro_steps), (phase * 1e-2, 0));
        assert_eq!(counters.exchanges, counters.macro_steps + 1);
        assert!(result.report.work.sides.actuator.micro_steps >= counters.macro_steps);
    }
}

#[test]
fn a_control_that_cannot_work_must_be_skipped_with_the_reason() {
    let control = control(EnergyResidual, 1e-2, 1e-2);
    let result = run(&quarter_car("zero-order-hold", "displacement-displacement", 1e-2, control));
    assert!(result.report.outcome.reason().contains("work both sides count"), "{}", result.report.outcome);
}

#[test]
fn a_step_control_must_change_the_run_id_and_nothing_else_may() {
    let plain = quarter_car("zero-order-hold", "force-displacement", 1e-2, None);
    let controlled = |tolerance| plain.changed(|own| own.step_control = control(EnergyResidual, tolerance, 1e-2));
    assert_ne!(plain.id(), controlled(1e-2).id());
    assert_ne!(controlled(1e-3).id(), controlled(1e-2).id());
    assert_eq!(controlled(1e-3).id(), controlled(1e-3).id());
}

/// A mass that integrates itself exactly under a held force.
#[derive(Clone)]
struct HeldMass {
    mass: f64,
    state: [f64; 2],
    ports: Ports,
}

impl Capabilities for HeldMass {}

impl Subsystem for HeldMass {
    subsystem_methods!(ports capabilities clone);

    fn outputs(&mut self, _u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        y.copy_from_slice(&self.state);
        Ok(())
    }
    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let [x, v] = &mut self.state;
        *x += h * *v + 0.5 * h * h * u[0] / self.mass;
        *v += h * u[0] / self.mass;
        Ok(())
    }
    fn counters(&self) -> SubsystemCounters {
        SubsystemCounters::default()
    }
}

/// Kyllingstad, arXiv 2512.13845: a damped oscillator, m = c = k = 1, whose mass and spring both integrate the
/// velocity. A change of the step from H_a to H_b at t* leaves
/// ```text
/// x_mass − x_spring = Σ ½ H_n (v_{n+1} − v_n) = ½ H_b v(t) − ½ H_a v(0) + ½ (H_a − H_b) v(t*)
/// ```
/// for good, also once all has come to rest.
#[test]
fn a_change_of_the_step_must_leave_the_offset_of_the_closed_form() {
    let h = 0.1;
    for (phase, steps) in [(1.0, 7), (0.25, 1), (0.25, 8), (0.5, 400), (0.05, 3)] {
        let (spring_ports, mass_ports) = (force_displacement_ports(1).1, force_displacement_ports(1).0);
        let mut mass = HeldMass { mass: 1.0, state: [0.0, 1.0], ports: mass_ports };
        let mut spring = Springs::new(&[1.0], &[1.0]);
        assert_eq!(&spring_ports, spring.ports());
        let first = phase * h;
        let grid = CommunicationGrid::new(h, phase, first + f64::from(steps) * h).unwrap();
        let setup = Setup::new(grid, 1.0, Sequence::Jacobi, ForceReturn::Held);
        let mut velocities = Vec::new();
        let mut sides = sides(&mut mass, &mut spring);
        let coupling = coupled(scheme_by_name("zero-order-hold"), sides.lend());
        let report = observed(&setup, sides, coupling, &mut |point| velocities.push(point.y.mechanics[1]));
        assert_eq!((report.outcome, velocities.len()), (Outcome::Completed, steps as usize + 2));
        let [start, changed, end] = [velocities[0], velocities[1], velocities[steps as usize + 1]];
        let closed_form = 0.5 * h * end - 0.5 * first * start + 0.5 * (first - h) * changed;
        let offset = mass.state[0] - spring.deflection[0];
        // Sums of up to 400 roundings of numbers up to 1.
        assert!(
            (offset - closed_form).abs() < 4e-16 * (f64::from(steps) + 1.0),
            "{phase} {steps}: {offset} {closed_form}"
        );
        if steps == 400 {
            assert!(end.abs() < 1e-7 && (offset + 0.5 * first * start + 0.25 * h * changed).abs() < 1e-8, "{offset}");
        }
    }
}

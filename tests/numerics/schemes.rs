//! What every scheme must do, by name: whatever is listed is checked, and skipped only where a case lacks what it
//! needs.

use crate::support::*;

/// The run, or nothing where the case lacks what the scheme needs.
fn possible(spec: &RunSpec) -> Option<RunResult> {
    let result = run(spec);
    if matches!(result.report.outcome, Outcome::Skipped { .. }) {
        return None;
    }
    assert_eq!(result.report.outcome, Outcome::Completed, "{} on {}", spec.scheme.name, spec.case.name);
    Some(result)
}

fn error(spec: &RunSpec) -> Option<f64> {
    Some(error_of_positions(spec, &possible(spec)?.trajectory))
}

/// How far a measured order may be from the declared one.
const MARGIN: f64 = 0.15;

/// Order over H, 2 H, 4 H with exact subsystems and micro steps so short that only H matters.
///
/// An order is what is left as H → 0: where it is less than declared, H is halved, at most eight times. Where the
/// coarse error happens to be small, because two parts of it cancel, it needs one; where it goes with H ln(τ/H) as that
/// of the energy-leak damper, six or seven.
///
/// Signal-based schemes: the first macro step is a hundredth of the others, because a scheme that has fewer samples
/// then than it needs otherwise leaves the error of a lower order for good. Model-based ones go at their default force
/// return, with one step of the mechanics.
fn measured_order(scheme: &SchemeEntry, (case, set, finest): SmoothCase, coupling: &str) -> Option<f64> {
    let set = [set, &[("coupling", coupling), ("integrator", "exact")]].concat();
    let point = |times: f64| {
        let mut spec = set_spec(case, &set, &scheme.name, times * finest);
        let micro_step = spec.macro_step.min(2e-5);
        spec = spec.changed(|own| {
            (own.micro_step, own.mechanics_steps, own.duration, own.phase) = (micro_step, ALL, 0.5, 0.01)
        });
        if scheme.family == Family::Model {
            spec = spec.changed(|own| (own.macro_step, own.micro_step) = (2.0 * times * finest, 2e-6));
            spec = spec.changed(|own| (own.mechanics_steps, own.duration, own.phase) = (ONE, 0.2, 1.0));
        }
        Some((spec.macro_step, error(&spec)?))
    };
    let mut points = vec![point(4.0)?, point(2.0)?, point(1.0)?];
    let mut order = order_of_convergence(&points).unwrap();
    for halvings in 1..=8 {
        if order >= f64::from(scheme.order) - MARGIN {
            break;
        }
        points.push(point(0.5_f64.powi(halvings))?);
        order = order_of_convergence(&points[points.len() - 3..]).unwrap();
    }
    Some(order)
}

/// A scheme that an experiment names reaches its declared order on every smooth case, and does not do better on all of
/// them. Ceilings are left out: with many micro steps per macro step their error here is that of the micro steps, or of
/// the tolerance they iterate to.
#[test]
fn measured_orders_are_the_declared_ones() {
    let mut faults = Vec::new();
    // No linear case has oil or several rows; `hydraulic_line` and `many_actuators` measure the orders of schemes that
    // ask for some.
    let measured = |scheme: &&std::sync::Arc<SchemeEntry>| {
        let elsewhere = scheme.bonds.is_some() || scheme.needs.contains(&Requirement::TransmissionLines);
        scheme.real_time() && is_published(&scheme.name) && !elsewhere
    };
    for scheme in schemes().iter().filter(measured) {
        let declared = f64::from(scheme.order);
        let mut orders = Vec::new();
        for case in SMOOTH {
            for coupling in ["force-displacement", "displacement-displacement", "force-force"] {
                orders.extend(measured_order(scheme, case, coupling).map(|order| (order, case.0, coupling)));
            }
        }
        if orders.is_empty() {
            faults.push(format!("{}: no smooth case offers what it needs", scheme.name));
        }
        let least = orders.iter().map(|(order, ..)| *order).fold(f64::INFINITY, f64::min);
        if (least - declared).abs() > MARGIN {
            faults.push(format!(
                "{}: the least order is {least:.3}, and that declared, {declared}, asks for {:.2} to {:.2}; all of them: {orders:.3?}",
                scheme.name,
                declared - MARGIN,
                declared + MARGIN
            ));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The hold and the quadratic extrapolation between them bound what constants can lose: weights of the polynomial of
/// degree 2 through 0, 0.3, 1.3 at 2.3 add up to 17 in magnitude, each with some six roundings.
const CONSTANT: f64 = 17.0 * 6.0 * f64::EPSILON;

#[test]
fn constants_are_reproduced_from_the_first_sample_on() {
    let (mechanics, actuator) = force_displacement_ports(1);
    let ports = PerSide { mechanics: &mechanics, actuator: &actuator };
    check_coupling(ports).unwrap();
    let grid = CommunicationGrid::new(1.0, 0.3, 7.0).unwrap();
    for scheme in schemes().iter().filter(|scheme| scheme.family == Family::Signal) {
        let gain = scheme.gain_value(None).unwrap().unwrap_or(1.0);
        let empty = ReducedInterfaceModel::zeros(0, 1);
        let options = ModelOptions::default();
        let detection = scheme.detection(None).unwrap();
        let model = scheme.has_model().then_some(ModelConstruction { empty: &empty, options: &options, detection });
        let mut built = (scheme.build)(&Construction { ports, model, gain }).unwrap();
        // An interface at rest under load: position 0.7 m, force 300 N, spring of 4 N/m and damper of 2 N·s/m behind
        // it.
        let (y, force) = ([0.7, 0.0], [300.0]);
        let mut model = ReducedInterfaceModel::zeros(0, 1);
        (model.h[0], model.a[0]) = (1.0, -force[0]);
        let rates = OutputRates { rate: vec![0.0], feedthrough: vec![0.0, -2.0], rate_gain: vec![0.0, -4.0] };
        let mut lines = LineForces::new(1, 4, 0.0);
        for k in 0..grid.macro_steps() {
            let step: MacroStep = grid.step(k);
            let sample = Sample { model: Some(&model), ..Sample::of_outputs(step, &y, step.length / 4.0) };
            built.receive(Side::Mechanics, &sample).unwrap();
            lines.begin(&[2.0]);
            (0..4).for_each(|_| lines.push(&force));
            let line_forces = Some(&lines);
            let sample = Sample { y: &force, model: None, rates: Some(&rates), line_forces, ..sample };
            built.receive(Side::Actuator, &sample).unwrap();
            let (mut u, mut received) = (y, force);
            for j in 0..4 {
                let at = MicroStep::new(step, j, 4);
                built.input(Side::Actuator, at, &force, &mut u).unwrap();
                built.input(Side::Mechanics, at, &y, &mut received).unwrap();
                // A velocity made from a force by an impedance of order 1 keeps the roundings of the force.
                let name = format!("{} in macro step {k}: {u:?} {received:?}", scheme.name);
                assert!((u[0] - y[0]).abs() <= CONSTANT * (y[0] + 300.0) && u[1].abs() <= CONSTANT * 300.0, "{name}");
                assert!((received[0] - force[0]).abs() <= CONSTANT * 300.0, "{name}");
            }
        }
    }
}

/// Schemes that move where nothing should, with the reason.
const SAGGING: [(&str, &str); 1] =
    [("rim-fixed-mass", "without the free acceleration the model falls within each macro step, on purpose")];

/// A mass under its weight on a spring that carries it, 1000 macro steps.
#[test]
fn a_system_at_rest_under_load_stays_where_it_is() {
    const WEIGHT: f64 = 300.0;
    const STEPS: usize = 1000;
    for scheme in schemes() {
        let mut model = LinearModel::new(&[30.0], &[-WEIGHT], &[(&[1.0], 0.25)]);
        model.q[0] = 0.5;
        let (mut mechanics, mut actuator) = (stepper(model, PLASTIC), Springs::new(&[1000.0], &[50.0]));
        actuator.deflection[0] = -WEIGHT / 1000.0;
        if scheme.incompatibility(sides(&mut mechanics, &mut actuator)).is_some() {
            continue;
        }
        let (sequence, force_return) = scheme.sequence_and_return(None, None).unwrap();
        let grid = CommunicationGrid::new(1e-3, 0.4, 1e-3 * STEPS as f64).unwrap();
        let setup = Setup::new(grid, 1e-4, sequence, force_return);
        let (report, rows) = rows_of(&setup, sides(&mut mechanics, &mut actuator), scheme);
        assert_eq!(report.outcome, Outcome::Completed, "{}", scheme.name);
        let way = largest(rows.iter().map(|row| (row[1] - 0.75).abs()));
        // A rounding of the weight, in a stable system, moves the mass by that over the stiffness; a thousand of them
        // in a row.
        let rounding = STEPS as f64 * WEIGHT * f64::EPSILON / 1000.0 * 10.0;
        match SAGGING.iter().find(|(name, _)| *name == scheme.name) {
            Some((_, reason)) => assert!(way > 100.0 * rounding, "{} no longer sags ({reason})", scheme.name),
            None => assert!(way <= rounding, "{}: moves by {way:e} m, rounding explains {rounding:e} m", scheme.name),
        }
    }
}

#[test]
fn two_runs_are_the_same_to_the_bit() {
    for scheme in schemes() {
        let again = || {
            let mut spec = wedge_box_spec(&scheme.name, 4e-3);
            spec = spec.changed(|own| (own.phase, own.duration) = (0.3, 0.4));
            bits(&run(&spec).trajectory)
        };
        assert_eq!(again(), again(), "{}", scheme.name);
    }
}

/// What the position of the communication points does to the end of a run vanishes with H: from H to H/4 the spread
/// over phases must at least halve, where order 1 quarters it.
#[test]
fn runs_at_all_phases_meet_as_the_macro_step_vanishes() {
    for scheme in schemes() {
        let spread = |macro_step: f64| -> Option<f64> {
            let mut ends = Vec::new();
            for phase in [0.2, 0.5, 0.8, 1.0] {
                let mut spec = set_spec("linear-oscillator", &REST, &scheme.name, macro_step);
                spec = spec.changed(|own| (own.phase, own.duration, own.micro_step) = (phase, 0.5, 1e-4));
                let result = possible(&spec)?;
                ends.push(result.trajectory.row(result.trajectory.len() - 1)[2]);
            }
            Some(largest(ends.iter().copied()) - smallest(ends))
        };
        let (Some(coarse), Some(fine)) = (spread(4e-3), spread(1e-3)) else { continue };
        assert!(fine <= 0.5 * coarse + 1e-12, "{}: {coarse:e} m, then {fine:e} m", scheme.name);
    }
}

#[test]
fn fewer_macro_steps_than_samples_are_no_trouble() {
    for scheme in schemes() {
        for macro_steps in 1..=3_usize {
            let usual = set_spec("linear-oscillator", &REST, &scheme.name, 1e-3);
            let spec = usual.with(|own| own.duration = 1e-3 * macro_steps as f64);
            if macro_steps < scheme.samples {
                let message = spec.unwrap_err().to_string();
                assert!(message.contains(&format!("the {} samples", scheme.samples)), "{message}");
                continue;
            }
            let spec = spec.unwrap();
            let Some(result) = possible(&spec) else { continue };
            let end = result.trajectory.row(macro_steps);
            // Mass 1 starts at 1 m with 110 N on 1 kg: within 3 ms nothing moves by more than 110/2 · 9e-6 m, twice
            // that with whatever the start-up makes of the force.
            assert!((end[1] - 1.0).abs() < 1e-3 && end[2].abs() < 1e-3, "{}: {end:?}", scheme.name);
        }
    }
}

#[test]
fn a_macro_step_that_does_not_divide_the_duration_ends_on_time_and_costs_no_accuracy() {
    for scheme in schemes() {
        let run = |macro_step: f64| {
            let mut spec = set_spec("linear-oscillator", &REST, &scheme.name, macro_step);
            spec = spec.changed(|own| (own.duration, own.micro_step) = (0.5, 1e-4));
            let end = possible(&spec)?.report.ended_at_s;
            Some((end, error(&spec)?))
        };
        // 0.7 ms leaves a last step of 0.2 ms; order 3 would lose at most (1/0.7)³ < 3 against 1 ms even if the error
        // were flat.
        let (Some((end, error)), Some((_, coarser))) = (run(0.7e-3), run(1e-3)) else { continue };
        assert_eq!(end, 0.5, "{}", scheme.name);
        assert!(error <= 1.5 * coarser + 1e-12, "{}: {error:e} m, at 1 ms {coarser:e} m", scheme.name);
    }
}

/// The ledger of the damper against the audit of the loop: what the pool holds is what the interface created, and what
/// the damper took is missing there.
#[test]
fn the_energy_leak_damper_takes_out_what_its_ledger_says() {
    let residual = |gain: f64| {
        let usual = wedge_box_spec("energy-leak-damper", 1e-3);
        let result = completed(&usual.changed(|own| (own.gain, own.duration) = (Some(gain), 1.0)));
        (result.report.audit.work.residual_j().unwrap(), result.report.scheme.dissipated_j.unwrap())
    };
    let ((without, nothing), (with, taken)) = (residual(0.0), residual(0.5));
    assert_eq!(nothing, 0.0);
    assert!(taken > 0.0, "{taken} J");
    // Sent minus received: energy from nowhere is negative.
    assert!(with.abs() < without.abs(), "residual {without} J without, {with} J with the damper, which took {taken} J");
}

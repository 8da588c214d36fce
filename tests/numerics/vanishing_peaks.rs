//! Errors relative to a vanishing peak, references that do not exist, and orders of rounding errors.

use crate::support::*;
use rimbench::cases::{BuildSide, CoupledSystem};
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench_core::cosim::subsystem_methods;
use std::sync::Arc;

/// A system at rest, in weightlessness, or held by what sticks: the force of the reference is rounding.
const AT_REST: [(&str, &[(&str, &str)]); 4] = [
    ("wedge-box", &[("spool_final", "0.5")]),
    ("wedge-box-reversal", &[("spool_final", "0.5"), ("holding_pull_n", "1e-12")]),
    ("bouncing-ball", &[("gravity_m_s2", "0")]),
    ("gripper", &[("spool_close", "0.5"), ("spool_open", "0.5")]),
];

#[test]
fn an_error_over_a_peak_of_rounding_must_be_no_share_and_no_divergence() {
    for (case, set) in AT_REST {
        let spec = |scheme| spec_with(case, scheme, &[("macro_step_s", "1e-3"), ("duration_s", "0.5")], set);
        let spec_of_hold = spec("zero-order-hold");
        let reference = coarse_reference(&spec_of_hold);
        for row in &spec_of_hold.case.interface_columns {
            assert_eq!(reference.force_peak(&spec_of_hold.case, &row.force).known(), None, "{case}: {}", row.force);
            assert!(reference.uncertainty_of(&row.force).unwrap() > 0.0, "{case}: ± 0");
        }
        for spec in [spec_of_hold, spec("rim-nonsmooth"), spec("rim-nonsmooth-gap")] {
            let run = run_within(&spec, reference.bounds(&spec).unwrap());
            assert_eq!(run.report.outcome, Outcome::Completed, "{case} {}", spec.scheme.name);
            let facts = evaluate(&spec, run, &reference).unwrap().found.facts();
            let share = facts.iter().find(|fact| fact.name == "force_error_rms_of_peak").unwrap().cell();
            assert!(share.is_empty(), "{case} {}: {share}", spec.scheme.name);
        }
    }
}

/// Impacts of a chaotic machine: above the scale of the case there is no reference, below it a force that is not known,
/// and at rest none.
#[test]
fn a_force_that_is_not_known_must_be_told_from_no_force_and_from_no_reference() {
    // As it is, the case is judged by its energy, and needs no reference that is known.
    let random = |seed, unbounded| {
        let set = [("seed", seed), ("actuator", "spring"), ("own_frequency_rad_s", "0")];
        let spec = spec_with("random-body", "zero-order-hold", &[], &set);
        let mut case = Case::clone(&spec.case);
        let build = Arc::clone(&case.build);
        case.build = Arc::new(move |parameters, solver| Ok(CoupledSystem { unbounded, ..build(parameters, solver)? }));
        let spec = spec.changed(|own| own.case = Arc::new(case));
        let reference = Reference::compute(&spec, StopFlag::never());
        reference.map(|reference| reference.without_peak(&spec.case)).map_err(|error| error.to_string())
    };
    let refused = random("332211", false).unwrap_err();
    assert!(refused.contains("has no reference") && refused.contains("is uncertain by"), "{refused}");
    for known in [random("332211", true), random("341333", false)] {
        assert_eq!(known, Ok(Some("the force of the reference is not known to a tenth")));
    }
    let (case, set) = AT_REST[2];
    let spec = spec_with(case, "zero-order-hold", &[("duration_s", "0.5")], set);
    assert_eq!(coarse_reference(&spec).without_peak(&spec.case), Some("no force to speak of"));
    let usual = spec_with(case, "zero-order-hold", &[("duration_s", "0.5")], &[]);
    assert_eq!(coarse_reference(&usual).without_peak(&usual.case), None);
}

#[test]
fn a_stiffness_beyond_every_machine_must_end_at_once() {
    let spec = spec_with("cradle", "zero-order-hold", &[], &[("base_stiffness_n_m", "1e300")]);
    match Reference::compute(&spec, StopFlag::never()) {
        Err(Error::Incompatible(reason)) => assert!(reason.contains("carriage_position_m is not finite"), "{reason}"),
        other => panic!("{:?}", other.map(|reference| reference.uncertainty)),
    }
}

/// The first step of a held force moves a system near rest more than all of its reference.
#[test]
fn a_system_near_rest_must_not_count_as_diverged_for_what_its_case_would_not_notice() {
    let set = [("spool_final", "0.499")];
    let spec = spec_with("wedge-box", "zero-order-hold", &[("macro_step_s", "1e-3"), ("duration_s", "0.5")], &set);
    let reference = coarse_reference(&spec);
    let (scale, bounds) = (spec.case.scale.unwrap(), reference.bounds(&spec).unwrap());
    let peak = reference.largest[reference.trajectory.index_of("actuator_velocity_m_s").unwrap()];
    assert!(peak < 0.1 * scale.velocity_m_s, "{peak} m/s is not near rest");
    // Position and velocity, and the force.
    assert_eq!(bounds.mechanics[1], DIVERGENCE_FACTOR * (0.1 * scale.velocity_m_s));
    assert!(bounds.actuator[0] >= DIVERGENCE_FACTOR * (0.1 * scale.force_n));
}

/// Of each case with an interface, so that what is nothing for it is known. Numbers are those of a reference, coarse.
#[test]
fn the_scale_of_a_case_must_be_the_largest_motion_and_force_at_its_defaults() {
    let mut wrong = Vec::new();
    for case in cases().iter().filter(|case| !case.interface_columns.is_empty()) {
        let spec = usual_spec(&case.name, "zero-order-hold", case.defaults.macro_step_s);
        let spec = spec.changed(|own| own.duration = spec.duration.min(10.0));
        let solution = match Reference::exact(&spec, StopFlag::never()).unwrap() {
            Some(reference) => reference.trajectory,
            None => Reference::solution(&with_coarse_reference(&spec), 1, StopFlag::never()).unwrap().rows,
        };
        let most = |name: &str| largest(column(&solution, name).iter().map(|value| value.abs()));
        let over = |of: fn(&rimbench::cases::InterfaceColumns) -> &Name| {
            largest(case.interface_columns.iter().map(|row| most(of(row))))
        };
        let found = [over(|row| &row.position), over(|row| &row.velocity), over(|row| &row.force)];
        let declared = case.scale.map(|scale| [scale.position_m, scale.velocity_m_s, scale.force_n]);
        let near = |(declared, found): (&f64, &f64)| (0.5..=2.0).contains(&(declared / found));
        if !declared.is_some_and(|declared| declared.iter().zip(&found).all(near)) {
            wrong.push(format!("{}: {found:?}, declared {declared:?}", case.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A mass from outside with a fault.
struct Faulty {
    mass: Box<dyn Subsystem>,
    /// Steps below this give no number, s.
    no_number_below: f64,
    /// Steps below this do nothing, s.
    own_step: f64,
    lost: bool,
}

impl Capabilities for Faulty {}

impl Subsystem for Faulty {
    subsystem_methods!(capabilities no_clone);

    fn ports(&self) -> &Ports {
        self.mass.ports()
    }
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.mass.outputs(u, y)?;
        if self.lost {
            y.fill(f64::NAN);
        }
        Ok(())
    }
    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.lost |= h < self.no_number_below;
        if h >= self.own_step { self.mass.step(t, u, h) } else { Ok(()) }
    }
    fn counters(&self) -> SubsystemCounters {
        self.mass.counters()
    }
}

fn from_outside(no_number_below: f64, own_step: f64) -> rimbench::error::Result<Reference> {
    let original = case_by_name("linear-oscillator").clone();
    let inside = original.clone();
    let build: BuildSide = std::sync::Arc::new(move |parameters, _| {
        let mass = (inside.build)(parameters, solver())?.sides.mechanics;
        Ok(Box::new(Faulty { mass, no_number_below, own_step, lost: false }))
    });
    let mut case = original.with_side("outside", Side::Mechanics, build).unwrap();
    case.defaults.reference_step_s = 4e-4;
    case.defaults.reference_sampling_s = 4e-4;
    case.defaults.macro_step_s = 1e-3;
    let mut catalogue = Catalogue::standard();
    catalogue.add_case(case).unwrap();
    let mut request = RunRequest::of("outside", "zero-order-hold");
    request.put("duration_s", "0.1").unwrap();
    Reference::compute(&request.resolve(&catalogue).unwrap(), StopFlag::never())
}

#[test]
fn a_reference_with_a_value_that_is_no_number_must_be_none() {
    assert!(from_outside(0.0, 0.0).is_ok());
    for below in [1.5e-4, 3e-4, 5e-4] {
        match from_outside(below, 0.0) {
            Err(Error::Incompatible(reason)) => assert!(reason.contains("has no reference"), "{reason}"),
            other => panic!("{:?}", other.map(|reference| reference.uncertainty)),
        }
    }
}

#[test]
fn a_side_that_stands_in_the_steps_of_a_reference_must_have_none() {
    match from_outside(0.0, 7e-4) {
        Err(Error::Incompatible(reason)) => assert!(reason.contains("longer steps of its own"), "{reason}"),
        other => panic!("{:?}", other.map(|reference| reference.uncertainty)),
    }
}

#[test]
fn the_midpoint_rule_must_be_refused_where_contacts_rebound() {
    let mut machines = 0;
    for case in cases() {
        let set = |e: &str| {
            let usual = usual_spec(&case.name, "zero-order-hold", case.defaults.macro_step_s);
            let mut parameters = usual.parameters.clone();
            parameters.set("restitution", e).ok()?;
            let (rule, duration) = (MechanicsIntegrator::Midpoint, 2.0 * usual.macro_step);
            let change = |own: &mut RunSettings| {
                (own.parameters, own.mechanics_integrator, own.duration) = (parameters, rule, duration)
            };
            let spec = usual.changed(change);
            Some(run(&spec).report.outcome)
        };
        let Some(with) = set("0.8") else { continue };
        machines += 1;
        let Outcome::Skipped { reason } = with else { panic!("{}: {with:?}", case.name) };
        // Contacts with friction or by the dozen are refused for that.
        let plain = !matches!(set("0"), Some(Outcome::Skipped { .. }) | None);
        assert!(!plain || reason.contains("restitution"), "{}: {reason}", case.name);
    }
    assert!(machines >= 17, "{machines} machines");
}

#[test]
fn the_least_of_many_gaps_must_be_no_contact() {
    for case in cases() {
        let mut system = usual_system(case);
        let mechanics = system.sides.mechanics.capabilities().contact_mechanics();
        let contacts = mechanics.map_or(&[][..], |mechanics| mechanics.contact_names());
        let contacts: Vec<String> = contacts.iter().map(|name| format!("gap_{name}_m")).collect();
        let gaps = case.recorded_columns().into_iter().filter(|name| name.starts_with("gap_"));
        for gap in gaps {
            let least = ["gap_lowest_m", "gap_supports_least_m", "gap_wedges_least_m"].contains(&gap.as_str());
            assert_eq!(contacts.contains(&gap), !least, "{}: {gap}", case.name);
        }
    }
    let spec = spec_with("n-wedge-box", "zero-order-hold", &[("duration_s", "0.05")], &[]);
    let reference = coarse_reference(&spec);
    assert!(!reference.is_contact_gap("gap_supports_least_m") && reference.is_contact_gap("gap_left_support_m"));
    let unpacked = Reference::unpack(&spec.case, reference.pack()).unwrap();
    assert!(unpacked.trajectory == reference.trajectory && unpacked.contacts == reference.contacts);
    assert!(!unpacked.is_contact_gap("gap_supports_least_m") && unpacked.is_contact_gap("gap_left_support_m"));
    // With what stands at events; numbers that do not fit are none.
    let spec = spec_with("rocking-block", "zero-order-hold", &[("duration_s", "0.12")], &[]);
    let reference = coarse_reference(&spec);
    let packed = reference.pack();
    let unpacked = Reference::unpack(&spec.case, packed.clone()).unwrap();
    assert!(!reference.events.is_empty() && unpacked.events == reference.events && unpacked.judged == reference.judged);
    for at_events in [f64::NAN, -1.0, 0.5, 1.0, 1e300, f64::INFINITY] {
        let mut damaged = packed.clone();
        *damaged.last_mut().unwrap() = at_events;
        assert!(Reference::unpack(&spec.case, damaged).is_none(), "{at_events}");
    }
}

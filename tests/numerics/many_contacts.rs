//! Heaps and rows of which few contacts are coupled, against the same with every entry kept.
//!
//! A solver behind a trait object is given dense problems: with it mechanics and schemes keep everything.

use crate::support::*;

fn spec(case: &str, set: &[(&str, &str)], duration: f64, macro_step: f64) -> RunSpec {
    spec_with(case, "rim-nonsmooth-gap", &[], set)
        .changed(|own| (own.duration, own.macro_step) = (duration, macro_step))
}

fn of_everything(spec: &RunSpec) -> RunSpec {
    with_opaque_solver(spec).changed(|own| own.solver = opaque_active_set())
}

const H: f64 = 1e-3;

fn mechanics(spec: &RunSpec) -> (Box<dyn Subsystem>, ReducedInterfaceModel) {
    let mut mechanics = (spec.case.build)(&spec.parameters, &spec.solver).unwrap().sides.mechanics;
    let mut model = mechanics.capabilities().empty_interface_model().unwrap();
    // A few steps under a push, so that discs move and meet.
    for _ in 0..30 {
        mechanics.step(0.0, &[2e4], H).unwrap();
    }
    assert!(mechanics.capabilities().interface_model(H, &mut model).unwrap());
    (mechanics, model)
}

#[test]
fn the_model_of_a_heap_keeps_what_meets_and_says_what_the_whole_one_says() {
    for (case, set) in
        [("disc-pile", [("columns", "7"), ("layers", "5")]), ("disc-row", [("discs", "40"), ("disc_gap_m", "1e-3")])]
    {
        let spec = spec(case, &set, 0.1, 5e-3);
        let ((mut few, sparse), (mut all, whole)) = (mechanics(&spec), mechanics(&of_everything(&spec)));
        assert!(sparse.delassus_pattern().is_some() && whole.delassus_pattern().is_none());
        let rows = sparse.contacts() + sparse.interface();
        assert!(sparse.h.len() < rows * rows / 3, "{} of {}", sparse.h.len(), rows * rows);
        let near = |a: f64, b: f64, scale: f64, what: &str| {
            assert!((a - b).abs() <= 1e-9 * scale, "{case}: {what} {a:e} instead of {b:e}");
        };
        let size = largest(whole.h.iter().map(|h| h.abs()));
        for row in 0..rows {
            for column in 0..rows {
                near(sparse.entry(row, column), whole.entry(row, column), size, "H");
            }
            near(sparse.w[row], whole.w[row], 1.0, "w");
            near(sparse.a[row], whole.a[row], 10.0, "a");
        }
        let counts =
            [few.counters(), all.counters()].map(|counters| (counters.solver.solves, counters.solver.failures));
        assert_eq!(counts[0], counts[1]);
        // Some contacts closed for good: those of every third.
        let closed: Vec<usize> = (0..sparse.contacts()).step_by(3).collect();
        let mut condensed = [Condensation::of(&sparse), Condensation::of(&whole)];
        condense(&sparse, &closed, &mut condensed[0]);
        condense(&whole, &closed, &mut condensed[1]);
        let [of_few, of_all] = &condensed;
        assert_eq!(of_few.rank, of_all.rank);
        near(of_few.effective_mass, of_all.effective_mass, of_all.effective_mass, "effective mass");
        near(of_few.a[0], of_all.a[0], 10.0, "a of the interface");
        near(of_few.w[0], of_all.w[0], 1.0, "w of the interface");
        let motion = |mechanics: &mut Box<dyn Subsystem>| {
            let mut motion = [0.0; 2];
            mechanics.outputs(&[0.0], &mut motion).unwrap();
            motion
        };
        let [few, all] = [motion(&mut few), motion(&mut all)];
        near(few[0], all[0], 1.0, "length");
        near(few[1], all[1], 1.0, "velocity");
    }
}

#[test]
fn whole_runs_of_rows_and_heaps_are_those_with_every_entry_kept() {
    let runs = [
        (spec("disc-row", &[("discs", "40"), ("disc_gap_m", "0")], 0.3, 5e-3), 1e-8),
        // Impacts of a heap amplify round-off: over its first motion it has not come far.
        (spec("disc-pile", &[("columns", "7"), ("layers", "5")], 0.05, 5e-3), 1e-6),
    ];
    for (spec, tolerance) in runs {
        let (few, all) = (run(&spec), run(&of_everything(&spec)));
        assert_eq!(few.report.outcome, all.report.outcome);
        let case = &spec.case.name;
        for name in ["blade_x_m", "actuator_force_n", "effective_mass_kg"] {
            let (found, expected) = (column(&few.trajectory, name), column(&all.trajectory, name));
            let size = largest(expected.iter().filter(|x| x.is_finite()).map(|x| x.abs()));
            let apart = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a - b).abs() };
            let off = largest(found.iter().zip(&expected).map(apart)) / size;
            assert!(off <= tolerance, "{case}: {name} off by {off:e}");
        }
        let work = few.report.work;
        assert_eq!((work.scheme.failures, work.sides.mechanics.solver.failures), (0, 0));
    }
}

#[test]
fn contacts_of_which_few_are_coupled_keep_non_zeros_and_others_every_entry() {
    let sparse = |case: &str, set: &[(&str, &str)]| {
        let spec = spec(case, set, 0.1, 5e-3);
        let mut system = (spec.case.build)(&spec.parameters, &spec.solver).unwrap();
        let model = system.sides.mechanics.capabilities().empty_interface_model().unwrap();
        model.delassus_pattern().is_some()
    };
    // Σ k² products over the velocities that k contacts share, of n contacts.
    assert!(!sparse("disc-row", &[("discs", "2")]), "17 of 25: nothing to save");
    assert!(sparse("disc-row", &[("discs", "4")]), "43 of 81");
    assert!(sparse("disc-pile", &[("columns", "2"), ("layers", "2")]), "60 of 81");
    assert!(!sparse("n-wedge-box", &[("supports", "64")]), "every contact moves the same body");
}

#[test]
fn what_needs_every_entry_gets_it_and_runs_as_with_every_entry_kept() {
    let usual = spec("disc-pile", &[("columns", "7"), ("layers", "5"), ("wall_gap_m", "0")], 0.02, 5e-3);
    let asked = [
        usual.changed(|own| own.mechanics_integrator = MechanicsIntegrator::Midpoint),
        usual.changed(|own| own.mechanics_integrator = MechanicsIntegrator::EventSplit),
        usual.changed(|own| own.actuator_integrator = ActuatorIntegrator::Midpoint),
        usual.changed(|own| own.belief = Some("mass:1.2".parse().unwrap())),
        usual.clone().audited().unwrap(),
    ];
    for (number, spec) in asked.into_iter().enumerate() {
        let (few, all) = (run(&spec), run(&of_everything(&spec)));
        assert_eq!(few.report.outcome, Outcome::Completed, "{number}");
        let [found, expected] = [&few, &all].map(|run| column(&run.trajectory, "actuator_force_n"));
        let off = max_difference(&found, &expected) / largest(expected.iter().map(|x| x.abs()));
        assert!(off <= 1e-9, "{number}: off by {off:e}");
        assert_eq!(few.report.audit.model.is_some(), spec.audit, "{number}");
    }
}

//! Random bodies with two contacts against random passive actuators: whose energy grows?

use crate::support::*;

const KINDS: [&str; 6] = ["spring", "cubic", "damped", "saturating", "varying", "active"];

/// Bounds were set before the first run, from another implementation: none of 750, and 30 to 56 %.
#[test]
fn none_of_six_passive_actuators_gains_energy_against_the_admissible_model_and_many_do_against_the_smooth_one() {
    let (mut admissible, mut smooth, systems) = (Vec::new(), 0, 60);
    for (seed, actuator) in (0..systems).zip(KINDS.iter().cycle()) {
        let set = [("seed", seed.to_string()), ("actuator", (*actuator).to_owned())];
        let growth = |scheme: &str| {
            let usual = usual_spec("random-body", scheme, 0.02);
            let set: Vec<_> = set.iter().map(|(key, value)| (*key, value.as_str())).collect();
            let run = run(&usual.changed(|own| own.parameters = case_with("random-body", &set).1));
            let most = largest(column(&run.trajectory, "energy_growth"));
            // A run that cannot go on has grown beyond bounds.
            if run.report.outcome == Outcome::Completed { most } else { f64::INFINITY }
        };
        let most = growth("rim-nonsmooth");
        if most > 1.05 {
            admissible.push((seed, actuator, most));
        }
        smooth += usize::from(growth("rim-smooth-active") > 1.05);
    }
    assert!(admissible.is_empty(), "{admissible:?}");
    assert!(smooth * 10 >= systems, "{smooth} of {systems}");
}

/// In one loop no energy is gained, and before a contact closes only dampers lose any.
#[test]
fn a_random_body_and_its_actuator_gain_no_energy_in_one_loop_and_lose_none_without_damper_before_an_impact() {
    for actuator in KINDS {
        let (mut least, mut free): (f64, usize) = (1.0, 0);
        for seed in ["0", "1", "2", "3", "4", "5"] {
            // ωh is 8e-3 at most, and a step changes the energy by half of it.
            let alone = march("random-body", &[("seed", seed), ("actuator", actuator)], 2e-5, 25_000, 50);
            let (growth, closed) = (column(&alone, "energy_growth"), column(&alone, "closed_contacts"));
            assert!(largest(growth.iter().copied()) < 1.005, "{actuator} {seed}");
            let before = closed.iter().skip(1).take_while(|closed| **closed == 0.0).count();
            free += before;
            least = growth[..=before].iter().copied().fold(least, f64::min);
        }
        assert_eq!(least < 0.995, ["damped", "varying"].contains(&actuator), "{actuator}: {least}");
        assert!(free > 100, "{free}");
    }
}

//! Contacts that give way: an implicit spring and damper per contact, in the mechanics and in the models made from it.

use crate::support::*;
use rimbench::contact_law::ContactSpring;

const fn compliant(stiffness: f64, damping: f64) -> ContactLaw {
    ContactLaw { spring: Some(ContactSpring { stiffness, damping }), ..PLASTIC }
}

/// 2 kg over a floor, with as many contacts at the same place as asked for.
fn falling(law: ContactLaw, contacts: usize, height: f64, velocity: f64) -> NonSmoothMechanics<LinearModel> {
    let contacts = vec![(&[1.0][..], 0.0); contacts];
    let mut model = LinearModel::new(&[2.0], &[-2.0 * 9.81], &[(&[1.0], 0.0)]).over(&contacts).moving(&[velocity]);
    model.q[0] = height;
    stepper(model, law)
}

fn after(mut mechanics: NonSmoothMechanics<LinearModel>, h: f64, steps: usize) -> NonSmoothMechanics<LinearModel> {
    for step in 0..steps {
        mechanics.step(step as f64 * h, &[0.0], h).unwrap();
    }
    mechanics
}

#[test]
fn at_rest_the_weight_compresses_the_spring_and_redundant_contacts_share_it() {
    for contacts in [1, 3] {
        let rest = after(falling(compliant(1e4, 200.0), contacts, 0.0, 0.0), 1e-3, 20_000);
        // k g = m g, spread over equal springs.
        let share = 2.0 * 9.81 / contacts as f64;
        approx::assert_relative_eq!(rest.position()[0], -share / 1e4, max_relative = 1e-9);
        for impulse in rest.contact_impulses() {
            approx::assert_relative_eq!(impulse / 1e-3, share, max_relative = 1e-9);
        }
    }
}

#[test]
fn one_step_is_that_of_a_spring_and_a_damper_taken_at_its_end() {
    let (k, c, h, m) = (5e3, 40.0, 2e-3, 2.0);
    for (height, velocity) in [(-1e-3, -0.2), (1e-4, -0.5), (-1e-3, 5.0), (0.1, -0.5)] {
        let stepped = after(falling(compliant(k, c), 1, height, velocity), h, 1);
        // m (v⁺ − v) = h (−m g + max(0, −k (x + h v⁺) − c v⁺)), solved with the contact and without; above the floor
        // the damper takes (x + h v⁺)/h for v⁺, what goes too far.
        let free = velocity - h * 9.81;
        let drawn = if height > 0.0 { h * k + c } else { h * k };
        let pressed = (m * velocity - h * m * 9.81 - drawn * height) / (m + h * h * k + h * c);
        let presses =
            if height > 0.0 { height + h * free < 0.0 } else { -k * (height + h * pressed) - c * pressed > 0.0 };
        let expected = if presses { pressed } else { free };
        approx::assert_relative_eq!(stepped.velocity()[0], expected, max_relative = 1e-12);
    }
}

#[test]
fn ever_stiffer_contacts_must_become_the_rigid_ones() {
    let rigid = after(falling(PLASTIC, 1, 0.02, 0.0), 1e-3, 100);
    let off = [1e6, 1e8, 1e10].map(|stiffness| {
        // Damped as heavily as 2 kg on that spring need not to bounce.
        let damping = 2.0 * (2.0_f64 * stiffness).sqrt();
        (after(falling(compliant(stiffness, damping), 1, 0.02, 0.0), 1e-3, 100).position()[0] - rigid.position()[0])
            .abs()
    });
    // What is left is the static compression, m g/k, and round-off of 2 cm.
    for (off, stiffness) in off.iter().zip([1e6, 1e8, 1e10]) {
        assert!(*off <= 1.01 * 2.0 * 9.81 / stiffness + 1e-16, "k = {stiffness}: {off} m");
    }
}

#[test]
fn the_account_must_close_and_what_is_lost_is_what_the_dampers_took() {
    let dropped = |h: f64| {
        let mut mechanics = after(falling(compliant(1e4, 50.0), 1, 0.02, 0.0), h, (2.0 / h) as usize);
        let account = mechanics.energy_account().unwrap();
        assert!(account.closure().abs() < 1e-12, "h = {h}: {} J", account.closure());
        account
    };
    let (coarse, fine) = (dropped(4e-4), dropped(0.25e-4));
    // At rest: down by 2 cm and the static compression x = m g/k, of which ½ k x² is in the spring.
    let (weight, k) = (2.0 * 9.81, 1e4);
    let compression = weight / k;
    let stored = -weight * (0.02 + compression) + 0.5 * k * compression * compression;
    for account in [coarse, fine] {
        approx::assert_relative_eq!(account.stored, stored, max_relative = 1e-6);
        assert!(account.contact > 0.0);
    }
    // The rest went to the damper, but for what the step itself lost or created, and that goes with h: of order one,
    // with a factor that depends on where in a step the contact closes.
    assert!((fine.contact + stored).abs() < 0.02 * -stored, "{fine:?}");
    assert!(fine.integration.abs() < 0.25 * coarse.integration.abs(), "{coarse:?}, {fine:?}");
}

/// Where a compliant mass, hung on an actuator's spring, is at all communication points of 50 ms; alone or with a
/// scheme.
fn coupled_positions(scheme: Option<(&str, Option<ContactDetection>)>) -> Vec<f64> {
    let mut mechanics = falling(compliant(2e3, 5.0), 2, 0.02, 0.0);
    let mut spring = Springs::new(&[30.0], &[0.0]);
    let sides = sides(&mut mechanics, &mut spring);
    let rows = match scheme {
        Some((name, detection)) => {
            let grid = CommunicationGrid::new(0.05, 1.0, 1.0).unwrap();
            coupled_rows(name, grid, 1e-3, sides, Some(&ModelOptions { detection, ..Default::default() }))
        }
        None => monolithic_rows(reference_steps(1e-3, 1000, 50), sides),
    };
    rows.iter().map(|row| row[1]).collect()
}

#[test]
fn with_constant_matrices_the_model_with_the_same_springs_must_be_the_mechanics() {
    let alone = coupled_positions(None);
    assert!(smallest(alone.iter().copied()) < -1e-3, "the mass never presses");
    // With gaps, and with a margin that takes all contacts in.
    for way in [("rim-nonsmooth-gap", None), ("rim-nonsmooth", Some(ContactDetection::Margin { width: 1.0 }))] {
        let coupled = coupled_positions(Some(way));
        assert!(max_difference(&coupled, &alone) < 1e-13, "{way:?}: {} m", max_difference(&coupled, &alone));
    }
}

#[test]
fn the_wedge_box_must_run_on_compliant_contacts_with_friction_and_without_and_its_audit_must_close() {
    for (case, peaks) in [("wedge-box", 900.0..1100.0), ("wedge-box-friction", 1600.0..1900.0)] {
        for scheme in ["rim-nonsmooth", "rim-nonsmooth-gap", "rim-smooth-active"] {
            let set = [("contact_compliance_m_n", "1e-7"), ("contact_damping_n_s_m", "2e4")];
            let result = completed(&spec_with(case, scheme, &[("phase", "0.4")], &set));
            let closure = result.report.audit.closure().unwrap();
            // Sums of some 1e3 J, 500 macro steps of 100 micro steps, a few roundings each.
            assert!(closure.abs() < 1e-6, "{case} {scheme}: {closure} J");
            // Rigid contacts have 991 and 1811 N.
            let peak = largest(column(&result.trajectory, "actuator_force_n"));
            assert!(peaks.contains(&peak), "{case} {scheme}: peak {peak} N");
            // 2.5 kN on three springs of 1e7 N/m: a tenth of a millimetre each.
            let gap = *column(&result.trajectory, "gap_right_wedge_m").last().unwrap();
            assert!((-3e-4..-2e-5).contains(&gap), "{case} {scheme}: {gap} m");
        }
    }
}

#[test]
fn ever_stiffer_contacts_with_friction_must_become_the_rigid_ones() {
    let force = |set: &[(&str, &str)]| column(&march("wedge-box-friction", set, 5e-5, 50_000, 20), "actuator_force_n");
    let rigid = force(&[]);
    let off = ["1e-7", "1e-8", "1e-9"].map(|compliance| {
        let set = [("contact_compliance_m_n", compliance), ("contact_damping_n_s_m", "1e5")];
        rms_difference(&force(&set), &rigid)
    });
    // Of a peak of 1.8 kN.
    assert!(off[0] > 2.0 * off[1] && off[1] > 2.0 * off[2] && off[2] < 10.0, "{off:?} N");
}

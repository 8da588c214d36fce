//! Impacts with known answers: rocking block, bouncing ball, three-ball cradle, redundant supports.

use crate::support::*;
use rimbench::cosim::Subsystem;
use rimbench::interface_model::Rows;
use rimbench::mechanics::{ContactLaw, MechanicalModel, ModelSize, NonSmoothMechanics};

#[test]
fn three_balls_in_a_row_must_part_as_moreau_says_and_not_as_newton_did() {
    // Equal masses, touching; the first one comes with 1 m/s. H = [2 −1; −1 2]/m, b = (1 + e)(−1, 0).
    let masses = vec![0.3; 3];
    let model = LinearModel {
        mass: masses,
        force: vec![0.0; 3],
        unilateral: ConstantRows::new(&[(&[-1.0, 1.0, 0.0], 0.0), (&[0.0, -1.0, 1.0], 0.0)]),
        interface: ConstantRows::new(&[(&[1.0, 0.0, 0.0], 0.0)]),
        q: vec![0.0; 3],
        v: vec![1.0, 0.0, 0.0],
        ..LinearModel::default()
    };
    for (restitution, wanted) in [
        (1.0, [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]),
        // Plastic: all go on together.
        (0.0, [1.0 / 3.0; 3]),
        (0.5, [0.0, 0.5, 0.5]),
    ] {
        let mut mechanics = stepper(model.clone(), ContactLaw { restitution, ..PLASTIC });
        mechanics.step(0.0, &[0.0], 1e-3).unwrap();
        for (found, wanted) in mechanics.velocity().iter().zip(wanted) {
            // A 2×2 problem of condition 3.
            approx::assert_abs_diff_eq!(found, &wanted, epsilon = 8.0 * f64::EPSILON);
        }
        let kinetic: f64 = mechanics.velocity().iter().map(|v| 0.5 * 0.3 * v * v).sum();
        if restitution == 1.0 {
            approx::assert_relative_eq!(kinetic, 0.15, max_relative = 8.0 * f64::EPSILON);
        }
    }
}

#[test]
fn a_plastic_contact_must_stay_where_another_one_rebounds() {
    let model = LinearModel::new(&[1.0; 2], &[0.0; 2], &[(&[1.0, 0.0], 0.0)])
        .over(&[(&[1.0, 0.0], 5e-4), (&[0.0, 1.0], 5e-4)])
        .moving(&[-1.0; 2]);
    let model = LinearModel { plastic: &[1], ..model };
    for rule in [None, Some(SecondOrder::EventSplit)] {
        let mut mechanics = stepper(model.clone(), ContactLaw { restitution: 0.5, ..PLASTIC });
        if let Some(rule) = rule {
            mechanics.use_second_order(rule).unwrap();
        }
        // Half a step to the floor; the semi-implicit step reaches it in one and stops in the next.
        (0..2).for_each(|_| mechanics.step(0.0, &[0.0], 1e-3).unwrap());
        assert!(max_difference(mechanics.velocity(), &[0.5, 0.0]) <= 1e-12, "{rule:?}: {:?}", mechanics.velocity());
    }
}

/// A rigid beam `(x, y, θ)`, 4 kg, on supports at `at` below it, its weight 0.1 m right of the middle; falling with
/// `speed`.
fn supported(at: &[f64], speed: f64, solver: &rimbench::solver_entry::SolverEntry) -> NonSmoothMechanics<LinearModel> {
    let rows: Vec<[f64; 3]> = at.iter().map(|x| [0.0, 1.0, *x]).collect();
    let rows: Vec<(&[f64], f64)> = rows.iter().map(|row| (row.as_slice(), 0.0)).collect();
    let model = LinearModel {
        mass: vec![4.0, 4.0, 0.5],
        // A load of 10 N hangs 0.1 m right of the centre of mass: moment −1 N·m.
        force: vec![0.0, -4.0 * 9.81 - 10.0, -1.0],
        unilateral: ConstantRows::new(&rows),
        interface: ConstantRows::new(&[(&[1.0, 0.0, 0.0], 0.0)]),
        q: vec![0.0; 3],
        v: vec![0.0, -speed, 0.0],
        ..LinearModel::default()
    };
    let (ports, _) = force_displacement_ports(1);
    NonSmoothMechanics::new(model, PLASTIC, ports, solver.checked(at.len()))
}

#[test]
fn redundant_supports_must_carry_the_right_force_and_moment_with_every_solver() {
    let h = 1e-3;
    for solver in solvers() {
        for at in [vec![-0.5, 0.0, 0.5], vec![-0.4, -0.1, 0.2, 0.6], vec![-0.5, -0.5, 0.1, 0.5, 0.5, 0.0]] {
            for speed in [0.0, 0.3] {
                let mut mechanics = supported(&at, speed, solver);
                mechanics.step(0.0, &[0.0], h).unwrap();
                let impulses = mechanics.contact_impulses();
                assert!(impulses.iter().all(|impulse| *impulse >= 0.0), "{}: {impulses:?}", solver.name);
                let (weight, moment) = (h * (4.0 * 9.81 + 10.0) + 4.0 * speed, h * 1.0);
                let resultant: f64 = impulses.iter().sum();
                let about: f64 = impulses.iter().zip(&at).map(|(impulse, x)| impulse * x).sum();
                // Accepted residuals are `tolerance` relative to the velocity before, weight/m; times mass and inertia.
                let tolerance = 10.0 * solver.tolerance * weight;
                assert!((resultant - weight).abs() <= tolerance, "{} {at:?}: {resultant} is not {weight}", solver.name);
                assert!((about - moment).abs() <= tolerance, "{} {at:?}: {about} is not {moment}", solver.name);
                assert!(mechanics.velocity().iter().all(|v| v.abs() <= tolerance), "it must stop level");
            }
        }
    }
}

#[test]
fn a_load_beyond_the_supports_must_tip_the_beam() {
    // Supports end at 0.01 m; the resultant of the weight acts at 1/49.24 = 0.0203 m.
    let mut mechanics = supported(&[-0.5, -0.2, 0.01], 0.0, &solvers()[0]);
    mechanics.step(0.0, &[0.0], 1e-3).unwrap();
    let impulses = mechanics.contact_impulses();
    assert_eq!(impulses[..2], [0.0, 0.0], "only the last support may carry");
    assert!(impulses[2] > 0.0 && mechanics.velocity()[2] < 0.0, "it must turn clockwise");
}

/// A point of 1 kg on a rope of 1 m: the gap is what is left of its length, and the row turns with the point.
#[derive(Clone, Copy)]
struct OnRope {
    gravity: f64,
    q: [f64; 2],
    v: [f64; 2],
}

impl MechanicalModel for OnRope {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: 2, unilateral: 1, interface: 1, ..ModelSize::default() }
    }
    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.q.to_vec(), self.v.to_vec())
    }
    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.fill(1.0);
    }
    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[0.0, -self.gravity]);
    }
    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let r = q[0].hypot(q[1]);
        let across = (q[0] * v[1] - q[1] * v[0]) / r;
        rows.jacobian.copy_from_slice(&[-q[0] / r, -q[1] / r]);
        rows.position[0] = 1.0 - r;
        rows.convective[0] = -across * across / r;
    }
    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian.copy_from_slice(&[1.0, 0.0]);
        rows.position[0] = q[0];
    }
    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.gravity * q[1]
    }
    fn names(&self) -> ModelNames {
        ModelNames::of(&[], &["rope"])
    }
}

/// A pendulum swings on a rope that stays taut. Each step leaves a gap of ½h²|c| and an approach of ½h|c|, which is
/// nothing that hits.
#[test]
fn a_contact_that_rests_on_a_row_that_turns_must_not_rebound_from_what_the_steps_make_of_it() {
    for h in [1e-2, 1e-3, 1e-4] {
        let states = |restitution: f64| {
            let rope = OnRope { gravity: 9.81, q: [0.6, -0.8], v: [0.0; 2] };
            let mut mechanics = stepper(rope, ContactLaw { restitution, ..PLASTIC });
            let steps = (0..(1.0 / h) as usize).map(|_| {
                mechanics.step(0.0, &[0.0], h).unwrap();
                [mechanics.position()[0], mechanics.position()[1], mechanics.contact_impulses()[0]].map(f64::to_bits)
            });
            steps.collect::<Vec<_>>()
        };
        let plastic = states(0.0);
        assert!(plastic.iter().all(|[_, _, impulse]| f64::from_bits(*impulse) > 0.0), "the rope stays taut");
        for restitution in [0.3, 0.5, 1.0] {
            assert_eq!(states(restitution), plastic, "e = {restitution}, h = {h}");
        }
    }
}

/// A point flies into its rope, across it with 2 m/s. What counts as rest is of order h: it turns with 4 m/s², so that
/// a rebound of less than h · 4 m/s² is over in a step. Any speed is an impact if the step is short enough.
#[test]
fn an_impact_on_a_row_that_turns_must_be_one_once_the_step_is_short_enough() {
    for (along, h, taut, rebounds) in [
        (1.0, 1e-3, false, true),
        (0.01, 1e-2, false, false),
        (0.01, 2e-3, false, false),
        (0.01, 1e-3, false, true),
        (0.01, 1e-5, false, true),
        (0.01, 1e-2, true, false),
        (0.01, 1e-3, true, true),
        (0.01, 1e-5, true, true),
    ] {
        let e = 0.5;
        // Taut at the start, or within the first step.
        let gap = if taut { 0.0 } else { 0.5 * h * along };
        let rope = OnRope { gravity: 0.0, q: [1.0 - gap, 0.0], v: [along, 2.0] };
        let mut mechanics = stepper(rope, ContactLaw { restitution: e, ..PLASTIC });
        mechanics.step(0.0, &[0.0], h).unwrap();
        // w⁺ + h c + e w⁻ = 0, where it is hit; else w⁺ + h c + g/h = 0.
        let outwards = mechanics.velocity()[0];
        let wanted = if rebounds { -e * along } else { gap / h } - 4.0 * h;
        // c is −4 m/s² over 1 m, and the point is ½ h w⁻ short of that.
        assert!((outwards - wanted).abs() <= 2.1 * h * h, "{along} m/s, h = {h}: {outwards}, not {wanted}");
    }
}

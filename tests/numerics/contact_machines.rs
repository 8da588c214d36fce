//! The machines with contacts: closed forms and energy.

use crate::support::*;
use rimbench::cases::{Car, HalfCar};
use rimbench::models::{ContactList, CraneGeometry, CraneWithRope, Discs, DiscsGeometry};

fn last(run: &Trajectory, name: &str) -> f64 {
    *column(run, name).last().unwrap()
}

/// The value of a column at the row nearest to a time.
fn at(run: &Trajectory, time: f64, name: &str) -> f64 {
    let index = run.index_of(name).unwrap();
    let nearest = run.rows().min_by(|a, b| (a[0] - time).abs().total_cmp(&(b[0] - time).abs()));
    nearest.unwrap()[index]
}

pub fn crane(start_angle: f64) -> CraneGeometry {
    CraneGeometry {
        link_1_length: 1.0,
        link_2_length: 0.5,
        rod_mass: 200.0,
        joint_mass: 250.0,
        end_mass: 100.0,
        pin_x: 0.75_f64.sqrt(),
        attachment: 0.5,
        start_angles: [start_angle, 0.0],
        gravity: 9.81,
    }
}

#[test]
fn a_taut_rope_is_the_second_link_of_the_hydraulic_crane() {
    let model = CraneWithRope::new(crane(std::f64::consts::FRAC_PI_6), -1.0).unwrap();
    approx::assert_relative_eq!(model.taut().equilibrium_force(), 8829.0, max_relative = 1e-12);
    let mut mechanics = stepper(model, PLASTIC);
    // Held by that force, nothing moves and the rope carries the load.
    mechanics.step(0.0, &[8829.0], 1e-3).unwrap();
    // Weight times h, rounded in sums of some 1e4 N.
    approx::assert_relative_eq!(mechanics.contact_impulses()[0], 981e-3, max_relative = 1e-10);
    assert_eq!(mechanics.contact_impulses()[1], 0.0);
    assert!(mechanics.velocity().iter().all(|v| v.abs() < 1e-13), "{:?}", mechanics.velocity());
}

pub fn car() -> Car {
    defaults("half-car")
}

#[test]
fn a_half_car_at_rest_stands_on_its_wheels_with_the_weight_shared_by_the_levers() {
    let model = HalfCar::new(Car { speed_m_s: 0.0, ..car() }).unwrap();
    let forces = model.equilibrium_forces();
    // 500 kg × 9.81 m/s² on 2.6 m.
    approx::assert_relative_eq!(forces[0], 4905.0 * 1.4 / 2.6, max_relative = 1e-14);
    approx::assert_relative_eq!(forces[1], 4905.0 * 1.2 / 2.6, max_relative = 1e-14);
    let mut mechanics = stepper(model, PLASTIC);
    mechanics.step(0.0, &forces, 1e-3).unwrap();
    for (impulse, strut) in mechanics.contact_impulses().iter().zip(forces) {
        approx::assert_relative_eq!(*impulse, 1e-3 * (strut + 40.0 * 9.81), max_relative = 1e-12);
    }
    assert!(mechanics.velocity().iter().all(|v| v.abs() < 1e-14));
    // The rows of the interface are coupled through the body: 1/m_b − a_f a_r/I, and on the diagonal 1/m_b + a²/I +
    // 1/m_w.
    let eq3 = mechanics.linearisation();
    let (_, model) = reduce(eq3, mechanics.velocity(), 1e-3, 0.0);
    approx::assert_relative_eq!(model.entry(2, 3), 1.0 / 500.0 - 1.2 * 1.4 / 600.0, max_relative = 1e-12);
    approx::assert_relative_eq!(model.entry(2, 2), 1.0 / 500.0 + 1.44 / 600.0 + 1.0 / 40.0, max_relative = 1e-12);
}

#[test]
fn on_the_smooth_road_the_half_car_stays_in_equilibrium_and_on_the_washboard_its_wheels_fly() {
    let run = run(&usual_spec("half-car", "rim-nonsmooth-gap", 5e-3));
    assert_eq!(run.report.outcome, Outcome::Completed);
    let gaps = ["gap_front_wheel_m", "gap_rear_wheel_m"].map(|name| largest(column(&run.trajectory, name)));
    // Clear of the road by several contact margins of 1 mm.
    assert!(gaps.iter().all(|gap| *gap > 3e-3), "a wheel stayed on the road: {gaps:?}");
    // 1 m at 8 m/s before the front wheel gets there.
    assert!((at(&run.trajectory, 0.12, "front_force_n") - 4905.0 * 1.4 / 2.6).abs() < 1e-6);
}

/// A row of discs with equal gaps before a blade that may already move.
pub fn row(discs: u32, gap: f64, velocity: f64) -> DiscsGeometry {
    let radius = 0.1;
    let x = |disc: u32| f64::from(disc) * (2.0 * radius + gap) + gap + radius;
    DiscsGeometry {
        blade_mass: 100.0,
        blade_velocity: velocity,
        disc_mass: 20.0,
        radius,
        centres: (0..discs).map(|disc| [x(disc), radius]).collect(),
        bumps: Vec::new(),
        wall_x: x(discs - 1) + 2.1 * radius,
        actuator_length: 1.5,
        gravity: 9.81,
    }
}

#[test]
fn a_blade_without_force_takes_the_discs_along_and_keeps_the_momentum() {
    let (count, speed, h) = (5, 0.5, 1e-3);
    let mut mechanics = stepper(Discs::new(row(count, 0.005, speed), ContactList::Neighbours).unwrap(), PLASTIC);
    // After k plastic impacts all that was hit moves with M v₀/(M + k m); five gaps of 5 mm take 66 ms, the wall is
    // 0.11 m away.
    for _ in 0..90 {
        mechanics.step(0.0, &[0.0], h).unwrap();
        let momentum = 100.0 * mechanics.velocity()[0]
            + 20.0 * mechanics.velocity()[1..].chunks(2).map(|disc| disc[0]).sum::<f64>();
        approx::assert_relative_eq!(momentum, 100.0 * speed, max_relative = 1e-12);
    }
    for disc in 0..count as usize {
        approx::assert_relative_eq!(mechanics.velocity()[1 + 2 * disc], 50.0 / 200.0, max_relative = 1e-9);
        assert!(mechanics.velocity()[2 + 2 * disc].abs() < 1e-12, "a disc left the floor");
    }
    // What the impacts took: T₀ (1 − M/(M + 5 m)) = 12.5 J / 2, booked in the contacts by the law v̄ᵀ P.
    approx::assert_relative_eq!(mechanics.ledger().contact, -6.25, max_relative = 1e-9);
}

#[test]
fn a_closed_row_is_one_mass_and_against_the_wall_it_is_locked() {
    // Three discs in touch: effective mass M + 3 m if all contacts press, as seen by the interface.
    let mut mechanics = stepper(Discs::new(row(3, 0.0, 0.0), ContactList::Neighbours).unwrap(), PLASTIC);
    let mut observed = vec![0.0; mechanics.capabilities().observables().len()];
    mechanics.step(0.0, &[100.0], 1e-4).unwrap();
    mechanics.capabilities().observe(1e-4, &mut observed);
    let names = mechanics.capabilities().observables();
    let of = |name: &str| observed[names.iter().position(|known| *known == name).unwrap()];
    approx::assert_relative_eq!(of("active_effective_mass_kg"), 160.0, max_relative = 1e-9);
    let row = run(&usual_spec("disc-row", "rim-nonsmooth-gap", 5e-3));
    assert_eq!(last(&row.trajectory, "effective_mass_kg"), f64::INFINITY);
    assert!(last(&row.trajectory, "actuator_velocity_m_s").abs() < 1e-9);
    // All ten gaps of 5 mm and 20 mm to the wall.
    approx::assert_relative_eq!(last(&row.trajectory, "blade_x_m"), 0.07, epsilon = 1e-6);
    // The blade's push goes through every disc to the wall.
    let [blade, wall] = ["contact_force_blade_n", "contact_force_wall_n"].map(|name| last(&row.trajectory, name));
    approx::assert_relative_eq!(blade, last(&row.trajectory, "actuator_force_n"), max_relative = 1e-6);
    approx::assert_relative_eq!(wall, blade, max_relative = 1e-6);
}

#[test]
fn the_list_of_contacts_of_row_and_pile_is_valid_throughout_their_manoeuvres() {
    for (case, reach) in [("disc-row", 0.1), ("disc-pile", 0.073)] {
        let run = run(&usual_spec(case, "rim-nonsmooth-gap", 5e-3));
        assert_eq!(run.report.outcome, Outcome::Completed);
        let moved = largest(column(&run.trajectory, "largest_displacement_m"));
        assert!(moved < reach, "{case}: moved {moved} m, the list holds for {reach} m");
    }
}

#[test]
fn a_stalled_gripper_squeezes_with_the_force_at_which_its_valves_balance() {
    let run = run(&usual_spec("gripper", "rim-nonsmooth-gap", 5e-3));
    let (kappa, supply, tank, area) = (0.4_f64, 7.6e6, 1e5, 1e-3);
    let (fed, drained) = (kappa * kappa, (1.0 - kappa) * (1.0 - kappa));
    let low = (fed * supply + drained * tank) / (fed + drained);
    let high = (drained * supply + fed * tank) / (fed + drained);
    let squeeze = (high - low) * area;
    // The pressures approach this with a time constant far below the second since closing; what is left of it at 1.45 s
    // is below one part in a thousand.
    let of = |name: &str| at(&run.trajectory, 1.45, name);
    for name in ["left_force_n", "right_force_n"] {
        approx::assert_relative_eq!(of(name), squeeze, max_relative = 1e-3);
    }
    // Each side's two pads carry its cylinder's force together; single pads are not unique.
    for side in ["left", "right"] {
        let pads = of(&format!("contact_force_{side}_lower_pad_n")) + of(&format!("contact_force_{side}_upper_pad_n"));
        approx::assert_relative_eq!(pads, of(&format!("{side}_force_n")), max_relative = 1e-3);
    }
    // The floor carries the weight, whatever the jaws do.
    let floor = of("contact_force_left_corner_n") + of("contact_force_right_corner_n");
    approx::assert_relative_eq!(floor, 50.0 * 9.81, max_relative = 1e-3);
    assert_eq!(of("rank_h_uu"), 4.0, "six rows closed, two of them redundant");
    assert_eq!(of("effective_mass_kg"), f64::INFINITY);
}

#[test]
fn the_load_is_set_down_the_rope_goes_slack_and_the_load_is_lifted_again() {
    let run = run(&usual_spec("crane-set-down", "rim-nonsmooth-gap", 2e-3));
    let of = |time: f64, name: &str| at(&run.trajectory, time, name);
    assert!(of(0.1, "gap_rope_m").abs() < 1e-6 && of(0.1, "gap_ground_m") > 0.02);
    approx::assert_relative_eq!(of(0.1, "contact_force_rope_n"), 981.0, max_relative = 1e-3);
    // On the ground with a slack rope it carries its whole weight.
    // Twice the contact margin: relieved of the load, the cylinder all but stops sinking.
    assert!(of(1.55, "gap_rope_m") > 2e-3, "{}", of(1.55, "gap_rope_m"));
    approx::assert_relative_eq!(of(1.55, "contact_force_ground_n"), 981.0, max_relative = 1e-6);
    assert!(of(3.95, "gap_rope_m") < 1e-3 && of(3.95, "gap_ground_m") > 1e-2, "not lifted");
}

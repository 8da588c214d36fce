//! Cases with contacts by the dozen and the thousand, against forces, impulses and energies in closed form.

use crate::support::*;
use rimbench::cases::wall_forces;

fn observed(mechanics: &mut dyn Subsystem, name: &str, h: f64) -> f64 {
    let names = mechanics.capabilities().observables().to_vec();
    let mut row = vec![0.0; names.len()];
    mechanics.capabilities().observe(h, &mut row);
    row[names.iter().position(|known| *known == name).unwrap()]
}

#[test]
fn a_packing_stands_on_forces_that_go_straight_through_and_are_turned_back_by_the_walls() {
    // Lines of force that no wall turns back, that are turned back once, and often; both kinds of layers on top.
    for (columns, layers, angle) in [(4, 5, 0.9), (2, 9, 0.7), (3, 6, 0.8), (12, 10, 1.0)] {
        let [wide, high, angled] = [columns.to_string(), layers.to_string(), angle.to_string()];
        let set = [("columns", &*wide), ("layers", &*high), ("packing_angle_rad", &*angled), ("disc_mass_kg", "10")];
        let (case, parameters) = case_with("packed-box", &set);
        let mut mechanics = (case.build)(&parameters, solver()).unwrap().sides.mechanics;
        let weight = 10.0 * 9.81;
        let forces = wall_forces(columns, layers, angle, weight);
        let held: f64 = forces.iter().sum();
        for _ in 0..20 {
            mechanics.step(0.0, &[held], 1e-4).unwrap();
        }
        let mut of = |name: &str| observed(&mut *mechanics, name, 1e-4);
        // Nothing moves: positions of metres round to 1e-16 per step.
        let moved = of("largest_displacement_m");
        assert!(moved < 1e-12, "{columns} × {layers}: {moved}");
        // The lowest discs at the walls carry most.
        let lowest = forces.last().unwrap();
        approx::assert_relative_eq!(of("contact_force_blade_n"), *lowest, max_relative = 1e-8);
        // The first two discs: what the second passes on to the first, at the end of the same line.
        let (sin, cos) = angle.sin_cos();
        let passed_on = 0.5 * (lowest / cos - weight / sin);
        approx::assert_relative_eq!(of("contact_force_pair_n"), passed_on, max_relative = 1e-8);
        // All of them: the walls' and, of each disc, those below it, from the lines of force alone.
        let all = 2.0 * held + sum_of_forces_between(columns, layers, weight / sin);
        approx::assert_relative_eq!(of("contact_force_sum_n"), all, max_relative = 1e-8);
        let discs = layers * columns - layers / 2;
        assert_eq!(of("closed_contacts"), f64::from(2 * discs));
        assert_eq!(of("rank_h_uu"), f64::from(2 * discs), "no contact is redundant");
    }
}

/// The sum of the forces between discs, and of discs on the half discs of the floor, by following each line of force
/// down from the top.
fn sum_of_forces_between(columns: u32, layers: u32, unit: f64) -> f64 {
    let last = 2 * columns as i64 - 2;
    let mut sum = 0.0;
    for start in 0..=last {
        // Places of the top layer: those of a layer with m discs are even.
        if (start + i64::from(layers - 1)) % 2 != 0 {
            continue;
        }
        for mut direction in [-1, 1] {
            if start + direction < 0 || start + direction > last {
                continue;
            }
            let (mut place, mut force) = (start, 0.0);
            for _ in 0..layers {
                let at_wall = place == 0 || place == last;
                force += if at_wall { unit } else { 0.5 * unit };
                if place + direction < 0 || place + direction > last {
                    direction = -direction;
                }
                sum += force;
                place += direction;
            }
        }
    }
    sum
}

#[test]
fn the_wall_of_the_packing_is_held_at_rest_let_out_and_pushed_back() {
    let run = completed(&usual_spec("packed-box", "rim-nonsmooth-gap", 5e-3));
    let (time, wall) = (column(&run.trajectory, "time_s"), column(&run.trajectory, "blade_x_m"));
    let at = |t: f64| wall[time.iter().position(|row| *row >= t - 1e-9).unwrap()];
    // At rest until the spool moves, but for what pressures of 1e6 Pa round to.
    assert!(at(0.1).abs() < 1e-9, "{}", at(0.1));
    assert!(at(0.35) < -5e-3 && at(0.8) > 5e-3, "{} {}", at(0.35), at(0.8));
    // Let out by 11.8 mm it takes 1640.4 N to hold the wall, by the potential energy of the packing that sinks; the
    // cylinder still moves.
    let force = column(&run.trajectory, "force_to_mechanics_n");
    let furthest = time.iter().position(|row| *row >= 0.4 - 1e-9).unwrap();
    approx::assert_relative_eq!(force[furthest], 1640.4, max_relative = 0.01);
    // The list of contacts holds: half of what the next nearest disc is away.
    assert!(largest(column(&run.trajectory, "largest_displacement_m")) < 0.065);
    // A mechanism of one degree of freedom: all contacts stay closed, and the wall is not locked.
    assert!(column(&run.trajectory, "closed_contacts").iter().all(|closed| *closed == 36.0));
    assert!(column(&run.trajectory, "effective_mass_kg").iter().all(|mass| (100.0..1000.0).contains(mass)));
    let closures = run.report.audit.accounts.map(|account| account.unwrap().closure());
    assert!(closures.iter().all(|closure| closure.abs() < 1e-6), "{closures:?}");
}

/// 22 discs that fall apart before the wall, 0.1 m away, holds them; a list made at the start holds for 0.73 radii.
#[test]
fn a_pile_that_goes_farther_than_its_list_must_end() {
    let set = [("wall_gap_m", "0.1"), ("push_start_s", "0.3")];
    let options = [("macro_step_s", "5e-3"), ("micro_step_s", "2.5e-4"), ("duration_s", "0.5")];
    let ended = run(&spec_with("disc-pile", "rim-nonsmooth-gap", &options, &set)).report.outcome;
    // Few enough for steps of the second order.
    let of_second_order = |rule: &str| {
        let set = [("columns", "3"), ("layers", "3"), ("wall_gap_m", "0.12"), ("push_start_s", "0.3")];
        let options = [("macro_step_s", "5e-3"), ("mechanics_integrator", rule)];
        run(&spec_with("disc-pile", "rim-nonsmooth-gap", &options, &set)).report.outcome
    };
    for ended in [ended, of_second_order("midpoint"), of_second_order("event-split")] {
        let Outcome::OutOfRange { quantity, value, at_s } = &ended else { panic!("{ended:?}") };
        assert_eq!(quantity, "largest_displacement_m");
        assert!((0.073..0.08).contains(value) && *at_s > 0.1, "{ended:?}");
    }
}

#[test]
fn large_cases_run_with_thousands_of_contacts_and_say_no_beyond_memory() {
    let (case, parameters) = case_with("packed-box", &[("columns", "20"), ("layers", "20"), ("disc_mass_kg", "0.5")]);
    let mut mechanics = (case.build)(&parameters, solver()).unwrap().sides.mechanics;
    mechanics.step(0.0, &[wall_forces(20, 20, 0.9, 0.5 * 9.81).iter().sum()], 1e-5).unwrap();
    assert_eq!(observed(&mut *mechanics, "closed_contacts", 1e-5), 780.0);
    let (case, mut parameters) = case_with("packed-box", &[("columns", "60"), ("layers", "80")]);
    // Or the cylinder could not hold it.
    parameters.set("gravity_m_s2", "0.01").unwrap();
    // With every entry kept.
    let error = (case.build)(&parameters, solver_by_name("lemke")).map(drop).unwrap_err().to_string();
    assert!(error.starts_with("packed-box: columns, layers") && error.contains("4.0 GiB"), "{error}");
}

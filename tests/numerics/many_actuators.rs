//! Several bonds on one mechanics: one bond is a pair, bonds at once are at once, lossless bodies, the lift table.

use crate::random_bodies::draw;
use crate::support::*;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::models::{ActuatorGroup, ActuatorNames};

const SIX: [(&str, &str); 1] = [("cylinders", "6")];

const fn of_one(position: &'static str, velocity: &'static str, force: &'static str) -> ActuatorNames {
    ActuatorNames { position, velocity, force, observables: &[] }
}
const OF_TWO: [ActuatorNames; 2] =
    [of_one("position_1_m", "velocity_1_m_s", "force_1_n"), of_one("position_2_m", "velocity_2_m_s", "force_2_n")];

/// Runs a body and the bonds of a plan, each with the scheme.
fn run_star(
    setup: &Setup,
    plan: &StarPlan,
    scheme: &str,
    mechanics: &mut (impl Subsystem + 'static),
    actuator: &mut (impl Subsystem + 'static),
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Report {
    let scheme = scheme_by_name(scheme);
    let couple = |_, sides: Sides<'_>| scheme.couple(sides, None, None).map(|built| (built.scheme, built.exchange));
    let star = Star::new(setup, plan, sides(mechanics, actuator), couple).unwrap();
    star.run(setup, sides(mechanics, actuator), RunControl::default(), observe)
}

#[test]
fn one_model_for_all_actuators_is_the_mechanics_to_round_off() {
    // At every macro step: pressed for a second, the oil forgets roundings of 20 kN.
    for h in ["1e-3", "16e-3"] {
        let joint = completed(&of_all_steps("lift-table", h, &[], &SIX)).trajectory;
        let whole = completed(&spec_with("lift-table", "monolithic", &[("macro_step_s", h)], &SIX)).trajectory;
        for name in ["force_1_n", "force_6_n", "box_y_m", "box_angle_rad"] {
            let (off, peak) = apart(&joint, &whole, name);
            assert!(off < 1e-9 * peak, "H = {h}: {name} is off by {off:e} of {peak:e}");
        }
    }
}

#[test]
fn splitting_costs_an_error_of_second_order_or_less_before_anything_touches() {
    for (known, share) in [("mean", "equal"), ("mean", "rows"), ("mean", "whole"), ("law", "whole")] {
        let off = |h: &str| {
            let short = |plan: &[_]| {
                completed(&of_all_steps("lift-table", h, plan, &[]).changed(|own| own.duration = 0.16)).trajectory
            };
            apart(&short(&[]), &short(&[EACH, ("known", known), ("share", share)]), "force_1_n").0
        };
        let ratio = off("1e-3") / off("0.5e-3");
        // The law also knows how the others' forces bend.
        let most = if known == "law" { f64::INFINITY } else { 5.0 };
        assert!((3.0..most).contains(&ratio), "{known} {share}: halved steps divide the error by {ratio:.2}");
    }
}

/// Two springs on a free body: the energy can only come from the coupling.
#[test]
fn blind_models_of_shares_of_a_body_never_heat_up_and_those_of_the_whole_body_do() {
    const H: f64 = 1.0;
    let rng = &mut Pcg64::seed_from_u64(39);
    for star in 0..4 {
        let arms = draw(rng, 2, 0.3);
        let rows: Vec<[f64; 2]> = arms.iter().map(|arm| [1.0, *arm]).collect();
        let inertia = rng.random_range(0.1..1.0);
        let v = draw(rng, 2, 1.0);
        let springs: Vec<f64> = (0..2).map(|_| rng.random_range(0.5_f64..3.0).powi(2)).collect();
        let growth = |share: &str, every: &str| {
            let model = LinearModel::new(&[1.0, inertia], &[0.0, 0.0], &[(&rows[0], 0.0), (&rows[1], 0.0)]).moving(&v);
            let single = springs.iter().map(|k| Springs::new(&[*k], &[0.0])).collect();
            let (mut mechanics, mut actuator) = (stepper(model, PLASTIC), ActuatorGroup::new(single, &OF_TWO));
            let sequence = Sequence::GaussSeidel { first: Side::Actuator };
            let setup =
                Setup::new(CommunicationGrid::new(H, 1.0, 1000.0 * H).unwrap(), 5e-3, sequence, ForceReturn::Mean);
            let (share, every) = (share.parse().unwrap(), every.parse().unwrap());
            let plan = StarPlan { known: Known::Nothing, share, every, ..StarPlan::default() };
            let (mut start, mut most) = (None, 0.0_f64);
            run_star(&setup, &plan, "rim-nonsmooth-gap", &mut mechanics, &mut actuator, &mut |point| {
                // Where both have come to the same time.
                if !((point.time / H).round() as u64).is_multiple_of(8) {
                    return;
                }
                // Both velocities from those of the rows, and the springs' energy F²/2k.
                let [a, b] = [point.y.mechanics[2], point.y.mechanics[3]];
                let turn = (b - a) / (arms[1] - arms[0]);
                let kinetic = 0.5 * (a - arms[0] * turn).powi(2) + 0.5 * inertia * turn.powi(2);
                let springs: f64 = point.y.actuator.iter().zip(&springs).map(|(f, k)| 0.5 * f * f / k).sum();
                let energy = kinetic + springs;
                most = most.max(energy / *start.get_or_insert(energy));
            });
            most
        };
        // Micro steps of 5e-3 at up to 3 rad/s: an oscillation of 8e-3 of the energy, without growth.
        for (share, every) in [("equal", "1"), ("rows", "1"), ("bound", "1"), ("bound", "1,4"), ("bound", "8,1")] {
            let most = growth(share, every);
            assert!(most < 1.01, "star {star}: share {share} every {every} grows by {most}");
        }
        let most = growth("whole", "1");
        assert!(most > 1.1, "star {star}: the whole body for each grows by {most}");
    }
}

/// Two springs on a free body, one after the other, each step of the body with its own force.
#[test]
fn a_bond_that_is_told_all_that_others_have_done_receives_what_it_sends_to_round_off() {
    for every in ["1", "1/2", "1/5"] {
        let model = LinearModel::new(&[1.0, 0.3], &[0.0; 2], &[(&[1.0, -0.2], 0.0), (&[1.0, 0.25], 0.0)]);
        let single = [4.0, 2.0].map(|k| Springs::new(&[k], &[0.0])).into();
        let (mut mechanics, mut actuator) =
            (stepper(model.moving(&[0.3, -0.8]), PLASTIC), ActuatorGroup::new(single, &OF_TWO));
        let sequence = Sequence::GaussSeidel { first: Side::Actuator };
        let mut setup =
            Setup::new(CommunicationGrid::new(0.2, 1.0, 4.0).unwrap(), 0.01, sequence, ForceReturn::Profile);
        setup.mechanics_steps = "20".parse().unwrap();
        let plan = StarPlan { order: "1;2".parse().unwrap(), every: every.parse().unwrap(), ..StarPlan::default() };
        let report = run_star(&setup, &plan, "rim-nonsmooth-gap", &mut mechanics, &mut actuator, &mut |_| {});
        let [first, second] = [0, 1].map(|bond| report.bonds[bond].residual_j().unwrap().abs());
        assert!(second < 1e-13 && first > 1e-6, "{every}: {first:e} and {second:e} J");
    }
}

/// A body that bonds hold by dashpots: a point of attachment moves by `give` times its force on top of the body, so velocities
/// follow forces at once. Says what it received on each row.
struct HeldByDashpots {
    inner: NonSmoothMechanics<LinearModel>,
    give: f64,
    received: [f64; 2],
    ports: Ports,
}

impl HeldByDashpots {
    fn take_half(&mut self, u: &[f64], h: f64) -> Result<(), Failure> {
        let mut y = [0.0; 4];
        self.outputs(u, &mut y)?;
        (0..2).for_each(|row| self.received[row] += 0.5 * h * u[row] * y[2 + row]);
        Ok(())
    }
}

impl Subsystem for HeldByDashpots {
    subsystem_methods!(ports capabilities_of_inner counters_of_inner no_clone);
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.inner.outputs(u, y)?;
        (0..2).for_each(|row| y[2 + row] += self.give * u[row]);
        Ok(())
    }
    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.take_half(u, h)?;
        self.inner.step(t, u, h)?;
        self.take_half(u, h)
    }
}

#[test]
fn where_velocities_follow_forces_at_once_the_work_received_is_that_of_velocities_under_the_force_that_acts() {
    for count in ["1", "3"] {
        let model = LinearModel::new(&[1.0, 0.3], &[0.0; 2], &[(&[1.0, -0.2], 0.0), (&[1.0, 0.25], 0.0)]);
        let inner = stepper(model.moving(&[0.3, -0.8]), PLASTIC);
        let ports = Ports { direct_feedthrough: true, ..inner.ports().clone() };
        let mut mechanics = HeldByDashpots { inner, give: 0.05, received: [0.0; 2], ports };
        // Of two sides only one may follow at once.
        let mut single = [4.0, 2.0].map(|k| Springs::new(&[k], &[0.0]));
        single.iter_mut().for_each(|spring| spring.ports.direct_feedthrough = false);
        let mut actuator = ActuatorGroup::new(single.into(), &OF_TWO);
        let sequence = Sequence::GaussSeidel { first: Side::Actuator };
        let mut setup = Setup::new(CommunicationGrid::new(0.2, 1.0, 4.0).unwrap(), 0.01, sequence, ForceReturn::Mean);
        setup.mechanics_steps = count.parse().unwrap();
        let plan = StarPlan::default();
        let report = run_star(&setup, &plan, "zero-order-hold", &mut mechanics, &mut actuator, &mut |_| {});
        for (bond, of_row) in report.bonds.iter().zip(mechanics.received) {
            approx::assert_relative_eq!(bond.received_j.unwrap(), of_row, max_relative = 1e-12);
        }
        assert!(mechanics.received.iter().all(|work| work.abs() > 0.01), "{:?}", mechanics.received);
    }
}

#[test]
fn the_correlations_of_the_lift_table_are_those_of_its_geometry() {
    // Six cylinders at 0.3 (2i/5 − 1) m; radius of gyration² (1 + 0.36)/12 m².
    let place = |i: usize| 0.3 * (0.4 * i as f64 - 1.0);
    let h = |i: usize, j: usize| 1.0 + place(i) * place(j) * 12.0 / 1.36;
    let c = DMatrix::from_fn(6, 6, |i, j| h(i, j) / (h(i, i) * h(j, j)).sqrt());
    let spec = of_all_steps("lift-table", "5e-3", &[EACH], &SIX).changed(|own| own.duration = 0.05);
    let reference = Reference::compute(&spec, StopFlag::never()).unwrap();
    let of = |name| metric(&spec, completed(&spec), &reference, name);
    approx::assert_relative_eq!(of("interface_lambda"), c.clone().symmetric_eigenvalues().max(), max_relative = 1e-9);
    approx::assert_relative_eq!(of("interface_correlation"), c[(1, 0)].max(c[(5, 4)]), max_relative = 1e-12);
}

/// Two jaws do not feel each other until both hold the box, and then move as one.
#[test]
fn correlations_are_those_with_the_contacts_that_push() {
    let of = |duration: f64| {
        let spec = of_all_steps("gripper", "1e-3", &[EACH], &[]);
        let RunResult { report, trajectory, .. } = run(&spec.changed(|own| own.duration = duration));
        let (found, at) = (report.scheme.interface.unwrap(), trajectory.index_of("interface_lambda").unwrap());
        // The last row of the trace is that of the last communication point.
        assert!((trajectory.row(trajectory.len() - 1)[at] - found.lambda).abs() < 1e-6, "{duration}");
        [found.lambda, found.largest]
    };
    let [[apart, none], [held, one]] = [0.1, 1.0].map(of);
    assert!((apart - 1.0).abs() < 1e-9 && none < 1e-9, "{apart} {none}");
    assert!((held - 2.0).abs() < 1e-6 && (one - 1.0).abs() < 1e-6, "{held} {one}");
}

#[test]
fn a_lift_table_rests_until_it_is_lowered_and_then_both_stops_carry_what_the_cylinders_press() {
    for n in 1..=6 {
        let set = [("cylinders", &*n.to_string())];
        let run = completed(&spec_with("lift-table", "rim-nonsmooth-gap", &[], &set)).trajectory;
        let forces =
            |row: &[f64]| -> f64 { (1..=6).map(|i| row[run.index_of(&format!("force_{i}_n")).unwrap()]).sum() };
        let stops = |row: &[f64]| -> f64 {
            ["left", "right"].map(|s| row[run.index_of(&format!("contact_force_{s}_stop_n")).unwrap()]).iter().sum()
        };
        let weight = 200.0 * 9.81;
        let at = |t: f64| run.rows().find(|row| row[0] > t - 1e-9).unwrap();
        assert!((forces(at(0.1)) - weight).abs() < 1e-6 * weight, "{n}: {} N", forces(at(0.1)));
        // At rest on the stops; pressures still rise, over a macro step of 2 ms by less than a hundredth.
        let pressed = at(0.9);
        let sum = forces(pressed) + stops(pressed);
        assert!(stops(pressed) > weight && (sum - weight).abs() < 0.01 * stops(pressed), "{n}: {sum} N");
        assert!(run.row(run.len() - 1)[run.index_of("gap_right_stop_m").unwrap()] > 1e-3, "{n}: it is lifted again");
    }
}

/// Holding forces and eigenvalues by another program: cylinders in the air, and with the tip on the ground.
#[test]
fn an_excavators_arm_rests_until_it_is_lowered_and_its_cylinders_feel_each_other_more_on_the_ground() {
    let options = [&ALL_STEPS[..], &[("macro_step_s", "1e-3"), ("partition", "each")]].concat();
    let found = completed(&spec_with("excavator-arm", "rim-nonsmooth-gap", &options, &[])).trajectory;
    let of = |row: &[f64], name| row[found.index_of(name).unwrap()];
    let at = |t: f64| found.rows().find(|row| row[0] > t - 1e-9).unwrap();
    for t in [0.0, 0.1] {
        for (name, force) in [("boom_force_n", 10230.2), ("stick_force_n", -1908.9), ("bucket_force_n", 560.9)] {
            approx::assert_abs_diff_eq!(of(at(t), name), force, epsilon = 0.1);
        }
    }
    approx::assert_abs_diff_eq!(of(at(0.0), "interface_lambda"), 2.065, epsilon = 1e-3);
    assert!(of(at(0.7), "gap_tip_m").abs() < 1e-9 && of(at(0.7), "contact_force_tip_n") > 1e3);
    assert!(of(at(0.7), "interface_lambda") > 2.4 && of(at(1.5), "interface_lambda") < 2.1);
}

/// A run of gap tracking in which the mechanics takes every micro step with its own force.
fn of_all_steps(case: &str, macro_step: &str, plan: &[(&str, &str)], set: &[(&str, &str)]) -> RunSpec {
    let options = [&ALL_STEPS[..], &[("macro_step_s", macro_step)], plan].concat();
    spec_with(case, "rim-nonsmooth-gap", &options, set)
}

/// A run with these options besides a macro step of 2 ms.
fn star_spec(case: &str, scheme: &str, options: &[(&str, &str)], set: &[(&str, &str)]) -> RunSpec {
    spec_with(case, scheme, &[&[("macro_step_s", "2e-3")], options].concat(), set)
}

const ALL_STEPS: [(&str, &str); 2] = [("force_return", "profile"), ("mechanics_steps", "all")];
const EACH: (&str, &str) = ("partition", "each");

#[test]
fn one_bond_is_a_pair_to_the_bit() {
    let four = [("cylinders", "4")];
    let cases = [("lift-table", &four[..], "1+2+3+4"), ("half-car", &[], "1+2"), ("gripper", &[], "1+2")];
    let returns = [&[("force_return", "mean")][..], &ALL_STEPS, &[("force_return", "held")]];
    let mut runs = 0;
    for (case, set, all) in cases {
        for scheme in ["rim-nonsmooth-gap", "rim-smooth", "zero-order-hold"] {
            for options in returns {
                let joint = |more: &[(&str, &str)]| run(&star_spec(case, scheme, &[options, more].concat(), set));
                let (pair, star) = (joint(&[]), joint(&[("partition", all)]));
                assert_eq!(bits(&pair.trajectory), bits(&star.trajectory), "{case} {scheme} {options:?}");
                assert_eq!(pair.report.outcome, star.report.outcome, "{case} {scheme} {options:?}");
                assert_eq!(pair.interface_residual, star.interface_residual, "{case} {scheme} {options:?}");
                runs += 1;
            }
        }
    }
    // The mechanics first, where a scheme allows it.
    let first = run(&star_spec("gripper", "zero-order-hold", &[("sequence", "gauss-seidel-mechanics-first")], &[]));
    let options = [("partition", "1+2"), ("order", "hub;1"), ("force_return", "held")];
    let star = run(&star_spec("gripper", "zero-order-hold", &options, &[]));
    assert_eq!(bits(&first.trajectory), bits(&star.trajectory));
    assert_eq!(runs, 27);
}

/// 39 ms are nineteen macro steps of 2 ms and one of 1 ms, or 390 micro steps.
#[test]
fn bonds_that_exchange_every_few_macro_steps_end_with_the_run() {
    for every in ["1", "2", "3", "8"] {
        let options = [EACH, ("every", every), ("micro_step_s", "1e-4"), ("duration_s", "0.039")];
        let report = run(&star_spec("gripper", "rim-nonsmooth-gap", &options, &[])).report;
        assert_eq!(report.outcome, Outcome::Completed);
        assert_eq!(report.booked_micro_steps, [390, 2 * 390], "{every}");
    }
}

#[test]
fn bonds_at_once_are_at_once_whatever_their_names() {
    let four = [("cylinders", "4")];
    for known in ["nothing", "held", "mean", "law"] {
        let of = |partition: &str, every: &str| {
            let plan = [("partition", partition), ("every", every), ("known", known)];
            let spec = star_spec("lift-table", "rim-nonsmooth-gap", &[&ALL_STEPS[..], &plan].concat(), &four);
            let trajectory = run(&spec.changed(|own| own.duration = 0.4)).trajectory;
            ["force_1_n", "force_2_n", "force_3_n", "force_4_n", "box_y_m"]
                .map(|name| trajectory.column(trajectory.index_of(name).unwrap()).map(f64::to_bits).collect::<Vec<_>>())
        };
        assert_eq!(of("1|2|3|4", "1,2,4,1"), of("3|1|4|2", "4,1,1,2"), "{known}");
    }
}

#[test]
fn a_name_that_spells_bonds_runs_what_it_spells() {
    let spelled = run(&star_spec("gripper", "rim-split", &[], &[]));
    let plan = [EACH, ("share", "equal"), ("force_return", "mean")];
    let said = run(&star_spec("gripper", "rim-nonsmooth-gap", &plan, &[]));
    assert_eq!(bits(&spelled.trajectory), bits(&said.trajectory));
    assert_eq!(spelled.report.work, said.report.work);
    let of = |order| bits(&run(&star_spec("gripper", "rim-nonsmooth-gap", &[EACH, ("order", order)], &[])).trajectory);
    assert_eq!(of("each"), of("1;2"));
}

/// Published limits of four cylinders, by another program and on its grid: told of each other 1, 2, 4 and 8 times within
/// a macro step. There a run is lost where a force passes three times the largest of the joint run. Here it also is where
/// a pressure leaves the range of its fluid, which with c = 1e4 N·s/m comes one step of the grid earlier, told once and
/// twice.
#[test]
fn one_after_the_other_or_told_more_often_bonds_go_on_where_at_once_they_fail() {
    let four = |c| [("cylinders", "4"), ("outer_cylinder_m", "0.3"), ("viscous_friction_n_s_m", c)];
    let of = |c: &'static str, h: f64, plan: &[(&str, &str)]| {
        let h = h.to_string();
        let options = [&ALL_STEPS[..], &[("macro_step_s", &h), ("micro_step_s", "5e-5")], plan].concat();
        let ran = run(&spec_with("lift-table", "rim-nonsmooth-gap", &options, &four(c)));
        let force = |row: &[f64], i| row[ran.trajectory.index_of(&format!("force_{i}_n")).unwrap()].abs();
        let most =
            ran.trajectory.rows().fold(0.0_f64, |most, row| (1..=4).fold(most, |most, i| most.max(force(row, i))));
        (most, ran.report.outcome)
    };
    // H/m in 50 µs: the last stable and the first lost, here and there.
    let limits = [
        ("1e4", [(1, 31, 32, 33), (2, 21, 23, 24), (4, 13, 14, 14), (8, 13, 14, 14)]),
        ("1e5", [(1, 15, 16, 16), (2, 11, 12, 12), (4, 32, 33, 33), (8, 29, 30, 30)]),
    ];
    for (c, limits) in limits {
        let limit = 3.0 * of(c, 1e-3, &[]).0;
        for (m, stable, lost, published) in limits {
            let every = if m == 1 { "1".to_owned() } else { format!("1/{m}") };
            let at = |parts: u32| of(c, 5e-5 * f64::from(parts * m), &[EACH, ("every", &every)]);
            let [(most, outcome), (lost_most, lost_outcome)] = [stable, lost].map(at);
            assert!(outcome == Outcome::Completed && most < limit, "c {c} m {m}: {most} N, {outcome:?}");
            let is_lost = lost_outcome != Outcome::Completed;
            assert!(is_lost, "c {c} m {m}: {lost_most} N, {lost_outcome:?}");
            if lost != published {
                let out_of_range = matches!(lost_outcome, Outcome::OutOfRange { .. });
                assert!(out_of_range && lost_most < limit, "c {c} m {m}: {lost_most} N, {lost_outcome:?}");
            }
        }
    }
    let (most, outcome) = of("1e5", 8e-3, &[EACH, ("order", "each")]);
    assert!(outcome == Outcome::Completed && most < 3.0 * of("1e5", 1e-3, &[]).0, "{most} N");
}

#[test]
fn what_does_not_go_together_with_several_bonds_is_refused_with_the_reason() {
    let wrong = [
        (&[("known", "held")][..], "there is one bond: give partition"),
        (&[("partition", "1")], "each of the 2 rows of the interface once, as `1|2`"),
        (&[("partition", "1|0")], "bonds of rows counted from 1"),
        (&[EACH, ("order", "1")], "each of the 2 bonds once, as `1;2`"),
        (&[EACH, ("order", "1;hub,2")], "with the hub anywhere as a stage"),
        (&[EACH, ("every", "1,2,3")], "one number for each of the 2 bonds"),
        (&[EACH, ("every", "1,4"), ("phase", "0.5")], "use phase 1"),
        (&[EACH, ("order", "1;hub;2")], "so it goes first"),
        (&[EACH, ("share", "1.5")], "a number above 0, at most 1"),
        (&[EACH, ("share", "bound")], "use known `nothing`"),
        (
            &[EACH, ("share", "bound"), ("known", "nothing"), ("every", "1,2"), ALL_STEPS[0], ALL_STEPS[1]],
            "use force return `mean`",
        ),
        (&[EACH, ("bond_schemes", "zero-order-hold")], "one name for each of the 2 bonds"),
        (&[EACH, ("bond_micro_steps", "1e-4")], "one number for each of the 2 bonds"),
        (&[EACH, ("step_control", "model-defect"), ("step_tolerance", "0.1")], "use `none`"),
        (&[EACH, ("mass_learning", "within:10")], "each knows its own"),
        (&[EACH, ("actuator_integrator", "midpoint")], "use `euler`"),
    ];
    for (options, reason) in wrong {
        let mut request = RunRequest::of("gripper", "rim-nonsmooth-gap");
        let put = options.iter().try_for_each(|(key, value)| request.put(key, *value));
        let refused = put.and_then(|()| request.resolve(catalogue()).map(drop)).unwrap_err().to_string();
        assert!(refused.contains(reason), "{options:?}: {refused}");
    }
    let mut spelled = RunRequest::of("gripper", "rim-split");
    spelled.put("partition", "each").unwrap();
    assert!(spelled.resolve(catalogue()).unwrap_err().to_string().contains("use rim-nonsmooth-gap"));
    assert!(
        star_spec("gripper", "iterated-aitken", &[], &[]).with(|own| own.star = Some(StarPlan::default())).is_err()
    );
}

//! Several actuators on one mechanics, each with an interface model of its own: the joint limit, lossless bodies, the
//! lift table.

use crate::random_bodies::draw;
use crate::support::*;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A run in which the mechanics takes every micro step with its own force.
fn split_spec(case: &str, scheme: &str, split: Option<&str>, macro_step: &str, set: &[(&str, &str)]) -> RunSpec {
    let mut options = vec![("force_return", "profile"), ("mechanics_steps", "all"), ("macro_step_s", macro_step)];
    options.extend(split.map(|split| ("split", split)));
    spec_with(case, scheme, &options, set)
}

const SIX: [(&str, &str); 1] = [("cylinders", "6")];

#[test]
fn the_joint_model_is_gap_tracking_to_the_bit_and_the_mechanics_to_round_off() {
    for (case, set) in [("lift-table", &SIX[..]), ("half-car", &[]), ("gripper", &[])] {
        let of = |scheme, split, h| completed(&split_spec(case, scheme, split, h, set)).trajectory;
        let (joint, gap) = (of("rim-split", Some("joint"), "5e-3"), of("rim-nonsmooth-gap", None, "5e-3"));
        assert_eq!(bits(&joint), bits(&gap), "{case}");
    }
    // At every macro step: pressed for a second, the oil forgets roundings of 20 kN.
    for h in ["1e-3", "16e-3"] {
        let joint = completed(&split_spec("lift-table", "rim-split", Some("joint"), h, &SIX)).trajectory;
        let whole = completed(&spec_with("lift-table", "monolithic", &[("macro_step_s", h)], &SIX)).trajectory;
        for name in ["force_1_n", "force_6_n", "box_y_m", "box_angle_rad"] {
            let (off, peak) = apart(&joint, &whole, name);
            assert!(off < 1e-9 * peak, "H = {h}: {name} is off by {off:e} of {peak:e}");
        }
    }
}

#[test]
fn splitting_costs_an_error_of_second_order_or_less_before_anything_touches() {
    for split in ["mean:shares", "mean:rows", "mean:body", "law"] {
        let off = |h: &str| {
            let short = |split| split_spec("lift-table", "rim-split", split, h, &[]).changed(|own| own.duration = 0.16);
            apart(&completed(&short(Some("joint"))).trajectory, &completed(&short(Some(split))).trajectory, "force_1_n")
                .0
        };
        let ratio = off("1e-3") / off("0.5e-3");
        // The law also knows how the others' forces bend.
        let most = if split == "law" { f64::INFINITY } else { 5.0 };
        assert!((3.0..most).contains(&ratio), "{split}: halved steps divide the error by {ratio:.2}");
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
        let growth = |split: Split| {
            let model = LinearModel::new(&[1.0, inertia], &[0.0, 0.0], &[(&rows[0], 0.0), (&rows[1], 0.0)]).moving(&v);
            let (mut mechanics, mut actuator) = (stepper(model, PLASTIC), Springs::new(&springs, &[0.0; 2]));
            let sequence = Sequence::GaussSeidel { first: Side::Actuator };
            let setup =
                Setup::new(CommunicationGrid::new(H, 1.0, 1000.0 * H).unwrap(), 5e-3, sequence, ForceReturn::Mean);
            let options = ModelOptions { split, ..ModelOptions::default() };
            let coupling =
                scheme_by_name("rim-split").couple(sides(&mut mechanics, &mut actuator), Some(&options), None).unwrap();
            let (mut start, mut most) = (None, 0.0_f64);
            observed(&setup, sides(&mut mechanics, &mut actuator), coupling, &mut |point| {
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
        for split in [Split::BlindShares, Split::BlindRows] {
            assert!(growth(split) < 1.01, "star {star}: {split} grows by {}", growth(split));
        }
        assert!(
            growth(Split::BlindBody) > 1.1,
            "star {star}: the whole body for each grows by {}",
            growth(Split::BlindBody)
        );
    }
}

#[test]
fn the_correlations_of_the_lift_table_are_those_of_its_geometry() {
    // Six cylinders at 0.3 (2i/5 − 1) m; radius of gyration² (1 + 0.36)/12 m².
    let place = |i: usize| 0.3 * (0.4 * i as f64 - 1.0);
    let h = |i: usize, j: usize| 1.0 + place(i) * place(j) * 12.0 / 1.36;
    let c = DMatrix::from_fn(6, 6, |i, j| h(i, j) / (h(i, i) * h(j, j)).sqrt());
    let spec = split_spec("lift-table", "rim-split", None, "5e-3", &SIX).changed(|own| own.duration = 0.05);
    let reference = Reference::compute(&spec, StopFlag::never()).unwrap();
    let of = |name| metric(&spec, completed(&spec), &reference, name);
    approx::assert_relative_eq!(of("interface_lambda"), c.clone().symmetric_eigenvalues().max(), max_relative = 1e-9);
    approx::assert_relative_eq!(of("interface_correlation"), c[(1, 0)].max(c[(5, 4)]), max_relative = 1e-12);
}

/// Two jaws do not feel each other until both hold the box, and then move as one.
#[test]
fn correlations_are_those_with_the_contacts_that_push() {
    let of = |duration: f64| {
        let options = [("macro_step_s", "1e-3"), ("split", "mean:body"), ("mechanics_steps", "all")];
        let spec = spec_with("gripper", "rim-split", &[&options[..], &[("force_return", "profile")]].concat(), &[]);
        let found = run(&spec.changed(|own| own.duration = duration)).report.scheme.interface.unwrap();
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

#[test]
fn a_split_is_refused_where_there_is_nothing_to_split() {
    let mut request = RunRequest::of("gripper", "rim-nonsmooth-gap");
    request.put("split", "law").unwrap();
    let refused = request.resolve(catalogue()).unwrap_err().to_string();
    assert_eq!(refused, "split = law: scheme `rim-nonsmooth-gap` has one model for all actuators");
    assert!(request.put("split", "mean:row").unwrap_err().to_string().contains("did you mean `mean:rows`"));
}

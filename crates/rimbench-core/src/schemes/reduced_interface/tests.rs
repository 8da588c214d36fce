use super::construction::{SMOOTH_MARGIN, must_hold_every_entry};
use super::*;
use crate::cosim::{MacroStep, PerSide, Port, Ports, Quantity};
use crate::interface_model::ReducedInterfaceModel;
use crate::schemes::model_options::{ModelMotion, ModelOptions};
use crate::schemes::{Construction, ContactDetection, ModelConstruction};
use approx::assert_relative_eq;
use rimbench_contact::linear_algebra::SymmetricPattern;
use std::sync::Arc;

const STEP: MacroStep = MacroStep { index: 0, start: 0.0, length: 4e-3 };
const STEPS: usize = 4;

fn ports(inputs: &[Quantity], outputs: &[Quantity]) -> Ports {
    let named = |of: &[Quantity]| of.iter().map(|&quantity| Port { name: "p".into(), quantity }).collect();
    Ports { inputs: named(inputs), outputs: named(outputs), direct_feedthrough: false }
}

/// Gap tracking with this model, at its communication point, under no force.
fn tracking(model: &ReducedInterfaceModel, motion: ModelMotion) -> ReducedInterface {
    let mut model = model.clone();
    model.mechanics_step = STEP.length;
    let model = &model;
    let motions = [Quantity::Position, Quantity::Velocity];
    let ports =
        PerSide { mechanics: ports(&[Quantity::Force], &motions), actuator: ports(&motions, &[Quantity::Force]) };
    let ports = PerSide { mechanics: &ports.mechanics, actuator: &ports.actuator };
    let options = ModelOptions { motion, ..ModelOptions::default() };
    let model_to_come = Some(ModelConstruction { empty: model, options: &options, detection: None });
    let construction = Construction { ports, model: model_to_come, gain: 1.0 };
    let mut scheme = ReducedInterface::new(Contacts::UnilateralWithGaps, &construction).unwrap();
    let delta = STEP.length / STEPS as f64;
    let sample = Sample { model: Some(model), ..Sample::of_outputs(STEP, &[0.0, 0.0], delta) };
    scheme.receive(Side::Mechanics, &sample).unwrap();
    scheme.receive(Side::Actuator, &Sample::of_outputs(STEP, &[0.0], delta)).unwrap();
    scheme
}

#[test]
fn a_scheme_that_keeps_every_entry_is_refused_where_only_what_is_not_zero_has_room() {
    let chain = |n: usize| (0..n).map(|i| vec![i.saturating_sub(1)]).collect::<Vec<_>>();
    let model = |n| ReducedInterfaceModel::zeros_of(Arc::new(SymmetricPattern::new(&chain(n))), 1);
    let motions = [Quantity::Position, Quantity::Velocity];
    let sides = [ports(&[Quantity::Force], &motions), ports(&motions, &[Quantity::Force])];
    let built = |contacts: Contacts, empty: &ReducedInterfaceModel| {
        let options = ModelOptions::default();
        let detection = (contacts == Contacts::Bilateral).then_some(ContactDetection::Margin { width: SMOOTH_MARGIN });
        let ports = PerSide { mechanics: &sides[0], actuator: &sides[1] };
        let model = Some(ModelConstruction { empty, options: &options, detection });
        ReducedInterface::new(contacts, &Construction { ports, model, gain: 1.0 }).map(drop)
    };
    // 12 matrices of 7000² entries are 4.4 GiB.
    let many = model(7000);
    let refused = built(Contacts::Bilateral, &many).unwrap_err().to_string();
    assert!(refused.contains("7000 contacts, up to 4.4 GiB, and the limit is 4.0 GiB"), "{refused}");
    assert!(built(Contacts::UnilateralWithGaps, &many).is_ok() && built(Contacts::Bilateral, &model(60)).is_ok());
    // At the limit, and beyond.
    assert!(must_hold_every_entry(100, 960_000).is_ok() && must_hold_every_entry(100, 959_999).is_err());
}

fn micro_step(scheme: &mut ReducedInterface, index: usize) -> [f64; 2] {
    let mut u = [0.0; 2];
    scheme.input(Side::Actuator, MicroStep::new(STEP, index, STEPS), &[0.0], &mut u).unwrap();
    u
}

/// Two contacts of 1 kg, of which one stops in the second and third of four steps of 1 ms, and pulls the other along: from 1.01 m/s
/// to 1.22 and 1.43 m/s, by impulses of 0.5 N·s. No acceleration of 210 m/s² follows from that.
#[test]
fn the_next_closing_must_not_be_foreseen_by_the_impact_of_another_contact() {
    let mut model = ReducedInterfaceModel::zeros(2, 1);
    model.h.copy_from_slice(&[1.0, -0.4, 0.0, -0.4, 1.0, 0.0, 0.0, 0.0, 1.0]);
    model.a.copy_from_slice(&[0.0, -10.0, 0.0]);
    model.w.copy_from_slice(&[-1.0, -1.0, 0.0]);
    model.gap.copy_from_slice(&[1.5e-3, 0.1]);
    let mut scheme = tracking(&model, ModelMotion::Frozen);
    let (mut w, mut gap) = (-1.0, 0.1);
    let falls = |gap: f64, w: f64| 2.0 * gap / ((w * w + 20.0 * gap).sqrt() - w);
    for (index, impulse) in [0.0, 0.5, 0.5, 0.0].into_iter().enumerate() {
        micro_step(&mut scheme, index);
        w += -0.01 - 0.4 * impulse;
        gap += 1e-3 * w;
        let first = 0.5e-3 / 1.0;
        let expected = match index {
            // The other one closes before.
            0 => first,
            1 | 2 => gap / -w,
            // The first contact rests, loaded by nothing.
            _ => falls(gap, w),
        };
        assert_relative_eq!(scheme.next_closing().unwrap(), expected, max_relative = 1e-12);
    }
}

/// A contact that touches up to rounding, and is not pressed, is none that closes.
#[test]
fn a_contact_that_touches_and_carries_nothing_is_not_about_to_close() {
    let mut model = ReducedInterfaceModel::zeros(1, 1);
    model.h.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
    model.gap[0] = 1e-13;
    model.w[0] = -1e-17;
    let mut scheme = tracking(&model, ModelMotion::Frozen);
    micro_step(&mut scheme, 0);
    assert_eq!(scheme.next_closing(), None);
}

/// A contact of 1 kg that is pressed with 1 m/s², and from 1.25 ms on, where the surface bends down, with 0.2 m/s², then lets go
/// of the interface, which hangs on it: a quarter of the second step lies before the kink.
#[test]
fn accelerations_must_jump_at_a_kink_and_by_the_share_of_the_step_behind_it() {
    let mut model = ReducedInterfaceModel::zeros(1, 1);
    model.h.copy_from_slice(&[1.0, 0.5, 0.5, 1.0]);
    model.a.copy_from_slice(&[-1.0, 0.0]);
    model.acceleration_jumps = crate::interface_model::AccelerationJumps::with_room(1, 2);
    model.acceleration_jumps.add(1.25e-3).copy_from_slice(&[0.8, 0.0]);
    let velocities = |motion| {
        let mut scheme = tracking(&model, motion);
        [0, 1, 2, 3].map(|index| micro_step(&mut scheme, index)[1])
    };
    // The interface is pushed by half of what keeps the contact: P = δ a.
    let expected = [1.0, 0.25 + 0.75 * 0.2, 0.2, 0.2].map(|press: f64| 0.5e-3 * press);
    let mut sum = 0.0;
    for (found, push) in velocities(ModelMotion::Piecewise).into_iter().zip(expected) {
        sum += push;
        assert_relative_eq!(found, sum, max_relative = 1e-12);
    }
    for (index, found) in velocities(ModelMotion::Frozen).into_iter().enumerate() {
        assert_relative_eq!(found, 0.5e-3 * (index + 1) as f64, max_relative = 1e-12);
    }
}

/// Along the surface: a contact that sticks is pushed with 0.5 m/s², and from 1.25 ms on with 0.1 m/s².
#[test]
fn accelerations_along_the_surface_must_jump_at_a_kink_like_those_off_it() {
    let mut model = ReducedInterfaceModel::zeros_with_friction(&[1.0], 1);
    model.h.copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.5, 1.0]);
    model.a.copy_from_slice(&[-1.0, 0.5, 0.0]);
    model.acceleration_jumps = crate::interface_model::AccelerationJumps::with_room(1, 3);
    model.acceleration_jumps.add(1.25e-3).copy_from_slice(&[0.0, -0.4, 0.0]);
    let velocities = |motion| {
        let mut scheme = tracking(&model, motion);
        [0, 1, 2, 3].map(|index| micro_step(&mut scheme, index)[1])
    };
    // Half of what keeps the contact where it is pushes the interface: P_t = −δ a_t, less than P_n = δ.
    let mut sum = 0.0;
    let pushes = [0.5, 0.25 * 0.5 + 0.75 * 0.1, 0.1, 0.1];
    for (found, push) in velocities(ModelMotion::Piecewise).into_iter().zip(pushes) {
        sum -= 0.5e-3 * push;
        assert_relative_eq!(found, sum, max_relative = 1e-12);
    }
    for (index, found) in velocities(ModelMotion::Frozen).into_iter().enumerate() {
        assert_relative_eq!(found, -0.25e-3 * (index + 1) as f64, max_relative = 1e-12);
    }
}

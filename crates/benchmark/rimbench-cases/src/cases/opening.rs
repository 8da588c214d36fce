//! What sides from outside are tried with when a case of them is opened, before any verdict: few steps, once.

mod adds_up;
mod of_actuator;
mod of_mechanics;

use adds_up::{Move, is_motion, position_over_velocity};
use of_actuator::{Answer, answer_of, answers_late};
use of_mechanics::{OfMechanics, Relation, answer_in_time, moves_against, pushed_place, pushed_rows};
use rimbench_core::cosim::{PerSide, Port, Ports, Quantity, Side, Sides, Subsystem};
use rimbench_core::error::{Cause, Failure};
use rimbench_core::interface_model::ReducedInterfaceModel;

/// What runs on sides whose state or model is not to be believed.
pub const WHAT_REMAINS: &str =
    "what remains are schemes without model, derivatives and iteration, such as zero-order-hold";

/// Steps of both sides together, after which they are tried.
const BEFORE: usize = 2;
/// Steps that are taken twice from one state.
const TWICE: usize = 3;
/// Share of a step by which it is seen whether what was found depends on its length.
const SHORTER: f64 = 1.0 / 16.0;
/// Share of what an output moves in the steps that are taken twice by which it may differ: an integrator of variable
/// step starts anew from a state that is set.
const SAME_STEPS: f64 = 1e-4;
/// Share of an output's magnitude that is round-off.
const ROUND_OFF: f64 = 1e-12;
/// Share by which a position of a model may differ from the output; and, in m and m/s, what is round-off of something
/// at rest.
const SAME_MODEL: [f64; 2] = [1e-6, 1e-9];
/// Share of a velocity, and of what a step changes it by, by which a model's may differ: it puts right what joints have
/// drifted in a step.
const JOINT_DRIFT: f64 = 1e-2;

/// The steps by which sides are tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tried {
    /// Length, s.
    pub h: f64,
    /// Whether a side takes shorter ones as well.
    pub any_step: PerSide<bool>,
    /// Whether what a side says of how its outputs move was probed, and is its motion anyway.
    pub probed: PerSide<bool>,
    /// Whether it is the actuator itself that says that its outputs follow its inputs at once.
    pub declared: bool,
}

/// What does not add up of a side.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// What it is, in words.
    pub words: String,
    /// What sets it right, where that is known.
    pub remedy: Option<Remedy>,
}

/// A number by which a variable of a side is to be multiplied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remedy {
    /// Row of the interface.
    pub row: usize,
    /// Which of its variables.
    pub quantity: Quantity,
    /// The number.
    pub factor: f64,
}

/// What is not to be believed of sides from outside.
#[derive(Debug, Default, PartialEq)]
pub struct Doubts {
    /// Which side failed before it had taken its first steps, and why.
    pub failed: Option<(Side, Failure)>,
    /// Why states that are kept of a side do not come back.
    pub state: PerSide<Option<String>>,
    /// Why the interface model of the mechanics is not one of it.
    pub model: Option<String>,
    /// Why a side cannot be what it says that it is.
    pub faults: PerSide<Option<Fault>>,
    /// What is odd and may be meant.
    pub notes: Vec<String>,
    /// What both put out first, as [`first_outputs`] has it.
    pub first_outputs: Vec<PerSide<Vec<f64>>>,
}

/// Inputs and outputs of both sides.
struct Exchange {
    u: PerSide<Vec<f64>>,
    y: PerSide<Vec<f64>>,
}

/// Tries two sides by steps, at most 20 of each. A side that fails in later ones is left to the runs, in which it fails
/// with its reason.
pub fn doubts_of(mut sides: Sides<'_>, tried: Tried) -> Doubts {
    let mut doubts = Doubts::default();
    let mut of_mechanics = OfMechanics::default();
    let _ = try_sides(&mut sides, tried, &mut doubts, &mut of_mechanics);
    if let Some(fault) = of_mechanics.fault(sides.mechanics.ports(), tried) {
        doubts.faults.mechanics = Some(fault);
    }
    doubts
}

fn try_sides(sides: &mut Sides<'_>, tried: Tried, doubts: &mut Doubts, seen: &mut OfMechanics) -> Result<(), Failure> {
    let h = tried.h;
    let mut at = Exchange::of(sides);
    let outputs = &mut doubts.first_outputs;
    let mut given = Vec::new();
    let first = exchange(sides, &mut at).and_then(|()| {
        doubts.model = wrong_model(&mut *sides.mechanics, &at.y.mechanics, h);
        seen.first_model = model_of(&mut *sides.mechanics, tried);
        try_steps(sides, &mut at, h, &mut |at| {
            outputs.push(at.y.clone());
            given.push(at.u.mechanics.clone());
        })
    });
    if let Err((side, failure)) = first {
        doubts.failed = Some((side, failure.clone()));
        return Err(failure);
    }
    seen.moves.extend((1..outputs.len()).map(|k| Move {
        u: given[k - 1].clone(),
        before: outputs[k - 1].mechanics.clone(),
        after: outputs[k].mechanics.clone(),
        h,
    }));
    if doubts.model.is_none() {
        doubts.model = wrong_model(&mut *sides.mechanics, &at.y.mechanics, h);
    }
    let mut t = BEFORE as f64 * h;
    let answer =
        answer_of(&mut *sides.actuator, (&at.u.actuator, &at.y.actuator), t, tried, &mut doubts.faults.actuator)?;
    if tried.declared && answers_late(&mut *sides.actuator, &at.u.actuator, [t, h], &doubts.first_outputs)? {
        doubts.notes.push(
            "the actuator: it says that its outputs follow its inputs at once (direct feedthrough), and they do so at its next step only; \
             direct_feedthrough = false says that, and what it costs is no fault of a scheme"
                .to_owned(),
        );
    }
    let rows: Vec<usize> = (0..pushed_rows(sides.mechanics.ports())).collect();
    let model = model_of(&mut *sides.mechanics, tried);
    let place = pushed_place(&mut *sides.mechanics, &at.u.mechanics, [t, h], &rows, model)?;
    let early = place.as_ref().and_then(moves_against);
    let suspect = place.as_ref().and_then(|place| place.out());
    if let Some(place) = place {
        seen.moves.extend(place.step());
        seen.places.push(place);
    }
    for side in Side::BOTH {
        let mut moves = Vec::new();
        doubts.state[side] = lost_state(&mut *sides[side], side, &at.u[side], [t, h], &mut moves)?;
        if side == Side::Mechanics {
            seen.moves.extend(moves);
        }
    }
    t += TWICE as f64 * h;
    let mechanics = &mut *sides.mechanics;
    let again = early.map(|(row, _)| row).or(suspect.map(|(relation, row, _)| match relation {
        Relation::Answer { input } => input,
        Relation::Acceleration => row,
    }));
    // In one of two places it may be a contact that throws it back, or what is stiff.
    if let Some(row) = again.filter(|_| doubts.state.mechanics.is_none()) {
        let shorter = if tried.any_step.mechanics { SHORTER * h } else { h };
        let model = model_of(mechanics, tried);
        seen.places.extend(pushed_place(mechanics, &at.u.mechanics, [t, shorter], &[row], model)?);
    }
    let against = match early {
        Some(_) => seen.places.get(1).and_then(moves_against),
        None if seen.places.is_empty() => {
            let model = model_of(mechanics, tried);
            seen.model_in_time = model.map(|model| (seen.moves.len(), model));
            seen.in_time = answer_in_time(mechanics, &at.u.mechanics, [t, h], &mut seen.moves)?;
            seen.in_time.filter(|answer| *answer < 0.0).map(|answer| (0, answer))
        }
        None => None,
    };
    let reversed = against.map(|(row, change)| {
        let ports = mechanics.ports();
        let (force, velocity) = (&ports.inputs[row].name, &ports.outputs[ports.outputs.len() / 2 + row].name);
        let words = format!(
            "the sign of the force is reversed: 1 N more of {force} changes {velocity} by {change:.3e} m/s in a step of {h} s; a force above 0 \
             must drive its own row of the mechanics forwards"
        );
        (row, words)
    });
    match (reversed, answer) {
        (Some(reversed), Answer::PullsBack) => seen.reversed = Some(reversed),
        // Both count it the other way round, or nothing is known of the other: signals do not mind.
        (Some((_, words)), _) => {
            // Unless it is the velocity that is counted so.
            if is_motion(mechanics.ports()) && position_over_velocity(&seen.moves, 0).is_some() {
                return Ok(());
            }
            doubts.notes.push(format!("the mechanics: {words}; where the actuator counts it so as well, a factor of -1 on both sides"));
            doubts.model = Some(format!("{words}; {WHAT_REMAINS}"));
        }
        (None, Answer::PushesOn) => doubts.notes.push(
            "the actuator: its force grows with position and velocity, where a spring and a damper pull back; if that is not meant, its sign \
             is reversed"
                .to_owned(),
        ),
        _ => {}
    }
    Ok(())
}

/// What both sides put out at the beginning and after each of the first steps, to be compared with sides that were made
/// alike; the `others` are those, and step in between, so that what both share shows.
pub fn first_outputs(mut sides: Sides<'_>, mut others: Sides<'_>, h: f64) -> Vec<PerSide<Vec<f64>>> {
    let mut seen = Vec::new();
    let mut at = Exchange::of(&sides);
    let _ = try_steps(&mut sides, &mut at, h, &mut |at| {
        let t = (BEFORE + TWICE + seen.len()) as f64 * h;
        seen.push(at.y.clone());
        for side in Side::BOTH {
            // A failure of this copy is that of the side itself, which has been reported.
            let _ = others[side].step(t, &at.u[side], h);
        }
    });
    seen
}

impl Exchange {
    fn of(sides: &Sides<'_>) -> Self {
        let zeros = |count: &dyn Fn(&Ports) -> usize| PerSide::from_fn(|side| vec![0.0; count(sides[side].ports())]);
        Exchange { u: zeros(&|ports| ports.inputs.len()), y: zeros(&|ports| ports.outputs.len()) }
    }
}

/// A side that failed, and why.
type Failed = (Side, Failure);

/// The first steps of both, told at each point.
fn try_steps(sides: &mut Sides<'_>, at: &mut Exchange, h: f64, told: &mut dyn FnMut(&Exchange)) -> Result<(), Failed> {
    exchange(sides, at)?;
    told(at);
    for k in 0..BEFORE {
        for side in Side::BOTH {
            sides[side].step(k as f64 * h, &at.u[side], h).map_err(|failure| (side, failure))?;
        }
        exchange(sides, at)?;
        told(at);
    }
    Ok(())
}

/// Outputs of both, the side without direct feedthrough first, as in a run.
fn exchange(sides: &mut Sides<'_>, at: &mut Exchange) -> Result<(), Failed> {
    let first = if sides.mechanics.ports().direct_feedthrough { Side::Actuator } else { Side::Mechanics };
    for side in [first, first.other()] {
        sides[side].outputs(&at.u[side], &mut at.y[side]).map_err(|failure| (side, failure))?;
        let (told, heard) = (at.y[side].clone(), &mut at.u[side.other()]);
        heard.copy_from_slice(&told);
    }
    Ok(())
}

/// Why the interface model of a mechanics does not fit its outputs, if it has one and does not.
fn wrong_model(mechanics: &mut dyn Subsystem, y: &[f64], h: f64) -> Option<String> {
    let mut model = mechanics.capabilities().empty_interface_model().filter(|model| !model.smooth)?;
    match mechanics.capabilities().interface_model(h, &mut model) {
        Ok(true) => model.check().and_then(|()| model_against_outputs(&model, y)).err(),
        Ok(false) => None,
        Err(failure) => Some(failure.to_string()),
    }
    .map(|what| format!("its interface model is not one of it: {what}; {WHAT_REMAINS}"))
}

/// The interface model of a mechanics, where it is one of it and was not probed.
fn model_of(mechanics: &mut dyn Subsystem, tried: Tried) -> Option<ReducedInterfaceModel> {
    // Where velocities follow forces at once, they have no accelerations.
    if tried.probed.mechanics || mechanics.ports().direct_feedthrough {
        return None;
    }
    let mut model = mechanics.capabilities().empty_interface_model()?;
    let filled = mechanics.capabilities().interface_model(tried.h, &mut model);
    // One that derivatives make is none if they have the wrong sign, and that is to be said.
    let of_derivatives = model.smooth && model.h.iter().any(|entry| *entry != 0.0);
    let usable = of_derivatives || filled.is_ok_and(|filled| filled && model.check().is_ok());
    usable.then_some(model)
}

/// Compares position and velocity of an interface model with outputs of the same instant.
///
/// # Errors
/// What differs, in words.
pub fn model_against_outputs(model: &ReducedInterfaceModel, y: &[f64]) -> Result<(), String> {
    let (positions, velocities) = y.split_at(y.len() / 2);
    let interface = model.interface_start()..;
    let [share, least] = SAME_MODEL;
    let same = |what: &str, row: usize, unit: &str, [told, output]: [f64; 2], within: f64| {
        let words = || {
            format!(
                "{what}, row {row}, is {told} {unit}, and the output of the same instant is {output} {unit}: a fault of this side, and not \
                 of the scheme"
            )
        };
        ((told - output).abs() <= within + least).then_some(()).ok_or_else(words)
    };
    for (row, (&told, &output)) in model.position.iter().zip(positions).enumerate() {
        same("position", row, "m", [told, output], share * told.abs().max(output.abs()))?;
    }
    let rows = model.w[interface.clone()].iter().zip(&model.a[interface]).zip(velocities);
    for (row, ((&told, a), &output)) in rows.enumerate() {
        let change = (model.mechanics_step * a).abs();
        same("w of the interface", row, "m/s", [told, output], JOINT_DRIFT * (told.abs().max(output.abs()) + change))?;
    }
    Ok(())
}

/// Refuses an interface model over steps `h` (s) that are shorter than the first of which the side has one.
///
/// # Errors
/// [`Cause::NotOffered`] with both steps.
pub fn check_step_of_model(h: f64, from_s: f64) -> Result<(), Failure> {
    if h >= from_s * (1.0 - 1e-9) {
        return Ok(());
    }
    let what = format!(
        "the interface model of the mechanics is one of its own step of {from_s:e} s, and it is to take steps of {h:e} s; valid: macro \
         steps that are no shorter, or a shorter step of its own"
    );
    Err(Cause::NotOffered { what: what.into() }.into())
}

/// Inputs changed by so many times what is little beside them.
fn pushed(ports: &Ports, u: &[f64], times: f64) -> Vec<f64> {
    let change = |(input, u): (&Port, &f64)| u + times * little(input.quantity, *u);
    ports.inputs.iter().zip(u).map(change).collect()
}

/// A change of an input that the same contacts take.
fn little(quantity: Quantity, input: f64) -> f64 {
    let share = if quantity == Quantity::Force { 1e-3 } else { 1e-6 };
    share * input.abs().max(1.0)
}

/// Why a state that was kept is not the one that comes back, if a side keeps states and it is not. Its steps are added
/// to `moves`.
fn lost_state(
    side: &mut dyn Subsystem,
    which: Side,
    u: &[f64],
    [t, h]: [f64; 2],
    moves: &mut Vec<Move>,
) -> Result<Option<String>, Failure> {
    let ports = side.ports().clone();
    let outputs = |side: &mut dyn Subsystem, u: &[f64]| {
        let mut y = vec![0.0; ports.outputs.len()];
        side.outputs(u, &mut y).map(|()| y)
    };
    // To and fro, so that something moves that stood still.
    let inputs: Vec<Vec<f64>> =
        (0..TWICE).map(|k| pushed(&ports, u, if k <= TWICE / 2 { 1.0 } else { -1.0 })).collect();
    let run = |side: &mut dyn Subsystem| -> Result<Vec<Vec<f64>>, Failure> {
        let mut seen = vec![outputs(side, u)?];
        for (k, u) in inputs.iter().enumerate() {
            side.step(t + k as f64 * h, u, h)?;
            seen.push(outputs(side, u)?);
        }
        Ok(seen)
    };
    // It must know where it stands before its state is kept: some tell outputs only when they are asked for them.
    outputs(side, u)?;
    let Ok(mut copy) = side.try_clone() else { return Ok(None) };
    let first = run(side)?;
    moves.extend((0..TWICE).map(|k| Move {
        u: inputs[k].clone(),
        before: first[k].clone(),
        after: first[k + 1].clone(),
        h,
    }));
    let name = if which == Side::Mechanics { "mechanics" } else { "actuator" };
    let lost = |what: String| {
        Some(format!(
            "the state of the {name} does not come back: it was kept, {TWICE} steps were taken, it was set again, and then {what}; \
             {WHAT_REMAINS}"
        ))
    };
    let again = match run(&mut *copy) {
        Ok(again) => again,
        Err(failure) => return Ok(lost(format!("it refused the same steps ({failure})"))),
    };
    let last = outputs(side, &inputs[TWICE - 1])?;
    for (at, port) in ports.outputs.iter().enumerate() {
        let values = || first.iter().map(|y| y[at]);
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
        let slack = SAME_STEPS * (high - low) + ROUND_OFF * low.abs().max(high.abs());
        // NaN equals only the same NaN.
        let differs = |a: f64, b: f64| !((a - b).abs() <= slack || a.to_bits() == b.to_bits());
        let name = &port.name;
        for (k, (one, other)) in first.iter().zip(&again).enumerate() {
            if differs(one[at], other[at]) {
                return Ok(lost(format!("{name} was {} after {k} steps instead of {}", other[at], one[at])));
            }
        }
        if differs(first[TWICE][at], last[at]) {
            return Ok(lost(format!(
                "{name} had become {} instead of {}, by steps of the copy",
                last[at], first[TWICE][at]
            )));
        }
    }
    Ok(None)
}

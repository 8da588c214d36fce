//! What sides from outside are tried with when a case of them is opened, before any verdict: few steps, once.

use rimbench_core::cosim::{PerSide, Port, Ports, Quantity, Side, Sides, Subsystem};
use rimbench_core::error::Failure;
use rimbench_core::interface_model::ReducedInterfaceModel;

/// What runs on sides whose state or model is not to be believed.
pub const WHAT_REMAINS: &str =
    "what remains are schemes without model, derivatives and iteration, such as zero-order-hold";

/// Steps of both sides together, after which they are tried.
const BEFORE: usize = 2;
/// Steps that are taken twice from one state.
const TWICE: usize = 3;
/// Rows of the interface that are pushed one by one.
const PUSHED_ROWS: usize = 2;
/// Share of what an output moves in the steps that are taken twice by which it may differ: an integrator of variable step starts anew
/// from a state that is set.
const SAME_STEPS: f64 = 1e-4;
/// Share of an output's magnitude that is round-off.
const ROUND_OFF: f64 = 1e-12;
/// Share by which a model may differ from the outputs; and, in m and m/s, what is round-off of something at rest.
const SAME_MODEL: [f64; 2] = [1e-6, 1e-9];

/// What is not to be believed of sides from outside.
#[derive(Debug, Default, PartialEq)]
pub struct Doubts {
    /// Why states that are kept of a side do not come back.
    pub state: PerSide<Option<String>>,
    /// Why the interface model of the mechanics is not one of it.
    pub model: Option<String>,
    /// Why the mechanics cannot be what it says that it is: it moves against the force.
    pub reversed: Option<String>,
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

/// Tries two sides by steps of `h` (s), at most 20 of each. A side that fails here is left to the runs, in which it fails with its reason.
pub fn doubts_of(mut sides: Sides<'_>, h: f64) -> Doubts {
    let mut doubts = Doubts::default();
    let _ = try_sides(&mut sides, h, &mut doubts);
    doubts
}

fn try_sides(sides: &mut Sides<'_>, h: f64, doubts: &mut Doubts) -> Result<(), Failure> {
    let mut at = Exchange::of(sides);
    exchange(sides, &mut at)?;
    doubts.model = wrong_model(&mut *sides.mechanics, &at.y.mechanics, h);
    let seen = &mut doubts.first_outputs;
    try_steps(sides, &mut at, h, &mut |at| seen.push(at.y.clone()))?;
    if doubts.model.is_none() {
        doubts.model = wrong_model(&mut *sides.mechanics, &at.y.mechanics, h);
    }
    let mut t = BEFORE as f64 * h;
    let answer = answer_of(&mut *sides.actuator, &at.u.actuator, t, h)?;
    let early = moves_against(&mut *sides.mechanics, &at.u.mechanics, t, h)?;
    for side in Side::BOTH {
        doubts.state[side] = lost_state(&mut *sides[side], side, &at.u[side], t, h)?;
    }
    t += TWICE as f64 * h;
    let mechanics = &mut *sides.mechanics;
    let against = match early {
        // In one of two places it may be a contact that throws it back.
        Some(_) if doubts.state.mechanics.is_none() => moves_against(mechanics, &at.u.mechanics, t, h)?,
        Some(_) => None,
        None if mechanics.try_clone().is_err() => moves_against_in_time(mechanics, &at.u.mechanics, t, h)?,
        None => None,
    };
    let reversed = against.map(|(row, change)| {
        let ports = mechanics.ports();
        let (force, velocity) = (&ports.inputs[row].name, &ports.outputs[ports.outputs.len() / 2 + row].name);
        format!(
            "the sign of the force is reversed: 1 N more of {force} changes {velocity} by {change:.3e} m/s in a step of {h} s; a force above 0 \
             must drive its own row of the mechanics forwards"
        )
    });
    match (reversed, answer) {
        (Some(words), Answer::PullsBack) => doubts.reversed = Some(words),
        // Both count it the other way round, or nothing is known of the other: signals do not mind.
        (Some(words), _) => {
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

/// What both sides put out at the beginning and after each of the first steps, to be compared with sides that were made alike; the
/// `others` are those, and step in between, so that what both share shows.
pub fn first_outputs(mut sides: Sides<'_>, mut others: Sides<'_>, h: f64) -> Vec<PerSide<Vec<f64>>> {
    let mut seen = Vec::new();
    let mut at = Exchange::of(&sides);
    let _ = try_steps(&mut sides, &mut at, h, &mut |at| {
        let t = (BEFORE + TWICE + seen.len()) as f64 * h;
        seen.push(at.y.clone());
        for side in Side::BOTH {
            // What fails there has failed before.
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

/// The first steps of both, told at each point.
fn try_steps(sides: &mut Sides<'_>, at: &mut Exchange, h: f64, told: &mut dyn FnMut(&Exchange)) -> Result<(), Failure> {
    exchange(sides, at)?;
    told(at);
    for k in 0..BEFORE {
        for side in Side::BOTH {
            sides[side].step(k as f64 * h, &at.u[side], h)?;
        }
        exchange(sides, at)?;
        told(at);
    }
    Ok(())
}

/// Outputs of both, the side without direct feedthrough first, as in a run.
fn exchange(sides: &mut Sides<'_>, at: &mut Exchange) -> Result<(), Failure> {
    let first = if sides.mechanics.ports().direct_feedthrough { Side::Actuator } else { Side::Mechanics };
    for side in [first, first.other()] {
        sides[side].outputs(&at.u[side], &mut at.y[side])?;
        let (told, heard) = (at.y[side].clone(), &mut at.u[side.other()]);
        heard.copy_from_slice(&told);
    }
    Ok(())
}

/// Why the interface model of a mechanics does not fit its outputs, if it has one and does not.
fn wrong_model(mechanics: &mut dyn Subsystem, y: &[f64], h: f64) -> Option<String> {
    let mut model = mechanics.capabilities().empty_interface_model().filter(|model| !model.smooth)?;
    match mechanics.capabilities().interface_model(h, &mut model) {
        Ok(true) => model_against_outputs(&model, y).err(),
        Ok(false) => None,
        Err(failure) => Some(failure.to_string()),
    }
    .map(|what| format!("its interface model is not one of it: {what}; {WHAT_REMAINS}"))
}

/// Compares position and velocity of an interface model with outputs of the same instant.
fn model_against_outputs(model: &ReducedInterfaceModel, y: &[f64]) -> Result<(), String> {
    model.check()?;
    let (positions, velocities) = y.split_at(y.len() / 2);
    let w = &model.w[model.interface_start()..];
    for (what, unit, of_model, of_outputs) in
        [("position", "m", &*model.position, positions), ("w of the interface", "m/s", w, velocities)]
    {
        for (row, (told, output)) in of_model.iter().zip(of_outputs).enumerate() {
            let size = told.abs().max(output.abs());
            if (told - output).abs() > SAME_MODEL[0] * size + SAME_MODEL[1] {
                return Err(format!(
                    "{what}, row {row}, is {told} {unit}, and the output of the same instant is {output} {unit}"
                ));
            }
        }
    }
    Ok(())
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

/// Why a state that was kept is not the one that comes back, if a side keeps states and it is not.
fn lost_state(side: &mut dyn Subsystem, which: Side, u: &[f64], t: f64, h: f64) -> Result<Option<String>, Failure> {
    let ports = side.ports().clone();
    let outputs = |side: &mut dyn Subsystem, u: &[f64]| {
        let mut y = vec![0.0; ports.outputs.len()];
        side.outputs(u, &mut y).map(|()| y)
    };
    // To and fro, so that something moves that stood still.
    let inputs: Vec<Vec<f64>> = (0..TWICE).map(|k| pushed(&ports, u, if k < TWICE / 2 { 1.0 } else { -1.0 })).collect();
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
        // No number is like another, unless it is none either.
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

/// How many rows have a force and a velocity, of those that are pushed.
fn pushed_rows(ports: &Ports) -> usize {
    let is_force = ports.inputs.iter().all(|input| input.quantity == Quantity::Force);
    if is_force && ports.outputs.len() == 2 * ports.inputs.len() { ports.inputs.len().min(PUSHED_ROWS) } else { 0 }
}

/// The first row whose velocity falls when its own force grows and rises when it shrinks, with the change by a newton, m/s; none where a
/// side gives no copies.
fn moves_against(mechanics: &mut dyn Subsystem, u: &[f64], t: f64, h: f64) -> Result<Option<(usize, f64)>, Failure> {
    let ports = mechanics.ports().clone();
    let (p, rows) = (ports.outputs.len(), pushed_rows(&ports));
    let after = |row: usize, change: f64| -> Result<Option<Vec<f64>>, Failure> {
        let Ok(mut copy) = mechanics.try_clone() else { return Ok(None) };
        let (mut u, mut y) = (u.to_vec(), vec![0.0; p]);
        u[row] += change;
        copy.step(t, &u, h)?;
        copy.outputs(&u, &mut y)?;
        Ok(Some(y.split_off(p / 2)))
    };
    let Some(as_is) = (if rows > 0 { after(0, 0.0)? } else { None }) else { return Ok(None) };
    for row in 0..rows {
        let change = 0.1 * u[row].abs().max(1.0);
        let [Some(less), Some(more)] = [after(row, -change)?, after(row, change)?] else { return Ok(None) };
        let (less, as_is, more) = (less[row], as_is[row], more[row]);
        let slack = 1e-9 * less.abs().max(more.abs());
        if more < as_is - slack && as_is < less - slack {
            return Ok(Some((row, (more - less) / (2.0 * change))));
        }
    }
    Ok(None)
}

/// The same of the first row of a side that gives no copies, by steps one after the other: as it is, pushed and pulled, and what is
/// beyond its motion before.
fn moves_against_in_time(
    mechanics: &mut dyn Subsystem,
    u: &[f64],
    t: f64,
    h: f64,
) -> Result<Option<(usize, f64)>, Failure> {
    const EACH: usize = 3;
    let ports = mechanics.ports().clone();
    let p = ports.outputs.len();
    if pushed_rows(&ports) == 0 {
        return Ok(None);
    }
    let (mut u, mut y, own) = (u.to_vec(), vec![0.0; p], u[0]);
    let change = own.abs().max(1.0);
    mechanics.outputs(&u, &mut y)?;
    let (mut before, mut gains, mut size) = (y[p / 2], Vec::new(), 0.0_f64);
    for k in 0..3 * EACH {
        u[0] = own + [0.0, change, -change][k / EACH];
        mechanics.step(t + k as f64 * h, &u, h)?;
        mechanics.outputs(&u, &mut y)?;
        gains.push(y[p / 2] - before);
        (before, size) = (y[p / 2], size.max(y[p / 2].abs()));
    }
    let slope = (gains[EACH - 1] - gains[0]) / (EACH - 1) as f64;
    // The first gain of each part may be of the part before, where outputs are those of the step before.
    let beyond = |part: usize| {
        let last = part * EACH + EACH - 1;
        0.5 * (gains[last] + gains[last - 1]) - (gains[EACH - 1] + slope * (last as f64 - 0.5 - (EACH - 1) as f64))
    };
    let (pushed, pulled) = (beyond(1), beyond(2));
    let slack = 10.0 * slope.abs() * EACH as f64 + 1e-9 * size;
    Ok((pushed < -slack && pulled > slack).then_some((0, pushed / change)))
}

/// Which way an actuator answers to where it is and how fast it moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Answer {
    /// It pulls back, as a spring and a damper do.
    PullsBack,
    /// It pushes the further on, in all rows that answer.
    PushesOn,
    /// Neither, or both.
    Unclear,
}

/// How the forces of an actuator change with position and velocity of their rows, after a step of a copy, or at once where there is none.
fn answer_of(actuator: &mut dyn Subsystem, u: &[f64], t: f64, h: f64) -> Result<Answer, Failure> {
    let ports = actuator.ports().clone();
    let rows = ports.outputs.len();
    if ports.inputs.len() != 2 * rows {
        return Ok(Answer::Unclear);
    }
    let mut force = |row: usize, input: usize, change: f64| -> Result<f64, Failure> {
        let (mut u, mut y) = (u.to_vec(), vec![0.0; rows]);
        u[input] += change;
        match actuator.try_clone() {
            Ok(mut copy) => {
                copy.step(t, &u, h)?;
                copy.outputs(&u, &mut y)?;
            }
            Err(_) => actuator.outputs(&u, &mut y)?,
        }
        Ok(y[row])
    };
    let mut seen = [false; 2];
    for row in 0..rows.min(PUSHED_ROWS) {
        for input in [row, rows + row] {
            let change = little(ports.inputs[input].quantity, u[input]);
            let [more, less] = [force(row, input, change)?, force(row, input, -change)?];
            // What is beyond round-off.
            if (more - less).abs() > 1e-9 * more.abs().max(less.abs()) {
                seen[usize::from(more > less)] = true;
            }
        }
    }
    // As it was.
    let mut y = vec![0.0; rows];
    actuator.outputs(u, &mut y)?;
    Ok(match seen {
        [true, false] => Answer::PullsBack,
        [false, true] => Answer::PushesOn,
        _ => Answer::Unclear,
    })
}

//! What sides from outside are tried with when a case of them is opened, before any verdict: few steps, once.

use super::adds_up::{
    AT_REST, Move, Push, Ratio, answer, answer_over_model, answer_over_rate, digits, in_words, is_motion,
    position_over_velocity, step_over_model, step_over_rate,
};
use rimbench_core::cosim::{OutputRates, PerSide, Port, Ports, Quantity, Side, Sides, Subsystem};
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
const PUSHED_ROWS: usize = 4;
/// Rows whose positions and velocities an actuator is pushed by.
const PUSHED_MOTIONS: usize = 2;
/// Share of a step by which it is seen whether what was found depends on its length.
const SHORTER: f64 = 1.0 / 16.0;
/// Share of what an output moves in the steps that are taken twice by which it may differ: an integrator of variable step starts anew
/// from a state that is set.
const SAME_STEPS: f64 = 1e-4;
/// Share of an output's magnitude that is round-off.
const ROUND_OFF: f64 = 1e-12;
/// Share by which a model may differ from the outputs; and, in m and m/s, what is round-off of something at rest.
const SAME_MODEL: [f64; 2] = [1e-6, 1e-9];

/// The steps by which sides are tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tried {
    /// Length, s.
    pub h: f64,
    /// Whether a side takes shorter ones as well.
    pub any_step: PerSide<bool>,
    /// Whether what a side says of how its outputs move was probed, and is its motion anyway.
    pub probed: PerSide<bool>,
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

/// Tries two sides by steps, at most 20 of each. A side that fails in later ones is left to the runs, in which it fails with its reason.
pub fn doubts_of(mut sides: Sides<'_>, tried: Tried) -> Doubts {
    let mut doubts = Doubts::default();
    let mut of_mechanics = OfMechanics::default();
    let _ = try_sides(&mut sides, tried, &mut doubts, &mut of_mechanics);
    if let Some(fault) = of_mechanics.fault(sides.mechanics.ports(), tried) {
        doubts.faults.mechanics = Some(fault);
    }
    doubts
}

/// What is known of a mechanics in one place.
struct Place {
    u: Vec<f64>,
    before: Vec<f64>,
    pushes: Vec<Push>,
    model: Option<ReducedInterfaceModel>,
}

/// Which of its relations does not hold.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Relation {
    /// Of a velocity to a pushed force.
    Answer { input: usize },
    /// Of a velocity to the accelerations.
    Acceleration,
}

/// What was seen of the mechanics.
#[derive(Default)]
struct OfMechanics {
    moves: Vec<Move>,
    /// Answer of the first velocity to its force, (m/s)/N, in steps one after the other.
    in_time: Option<f64>,
    /// Its model at the beginning of the first step.
    first_model: Option<ReducedInterfaceModel>,
    /// Its model at the beginning of steps one after the other, with the place of that step.
    model_in_time: Option<(usize, ReducedInterfaceModel)>,
    places: Vec<Place>,
    /// Whether a force drives its own row backwards and the actuator pulls back, in words.
    reversed: Option<(usize, String)>,
}

impl Place {
    /// The step as it is.
    fn step(&self) -> Option<Move> {
        let push = self.pushes.first()?;
        Some(Move { u: self.u.clone(), before: self.before.clone(), after: push.after[1].clone(), h: push.h })
    }

    fn ratio(&self, relation: Relation, row: usize) -> Option<Ratio> {
        let model = self.model.as_ref()?;
        match relation {
            Relation::Acceleration => step_over_model(&self.step()?, model, row),
            Relation::Answer { input } => {
                let push = self.pushes.iter().find(|push| push.input == input)?;
                answer_over_model(push, &self.before, model, row)
            }
        }
    }

    /// The first relation that does not hold, answers first.
    fn out(&self) -> Option<(Relation, usize, Ratio)> {
        let rows = self.before.len() / 2;
        // What does not answer within a step puts out what was a step ago, or is held.
        if self.pushes.iter().all(|push| answer(push, rows + push.input) == Some(0.0)) {
            return None;
        }
        let answers = self.pushes.iter().flat_map(|push| {
            // Its own row first.
            let others = (0..rows).filter(move |row| *row != push.input);
            std::iter::once(push.input).chain(others).map(|row| (Relation::Answer { input: push.input }, row))
        });
        let all = answers.chain((0..rows).map(|row| (Relation::Acceleration, row)));
        let mut ratios = all.filter_map(|(relation, row)| Some((relation, row, self.ratio(relation, row)?)));
        ratios.find(|(_, _, ratio)| ratio.is_out())
    }
}

impl OfMechanics {
    /// What does not add up, if anything does not: positions and velocities first, because all else is said of them.
    fn fault(&self, ports: &Ports, tried: Tried) -> Option<Fault> {
        if !is_motion(ports) {
            return None;
        }
        let of_motion = (0..ports.outputs.len() / 2).find_map(|row| self.motion(ports, row));
        let reversed = || {
            let (row, words) = self.reversed.clone()?;
            Some(Fault { words, remedy: Some(Remedy { row, quantity: Quantity::Force, factor: -1.0 }) })
        };
        of_motion.or_else(reversed).or_else(|| self.model(ports, tried))
    }

    /// Whether a position moves as its velocity says.
    fn motion(&self, ports: &Ports, row: usize) -> Option<Fault> {
        let ratio = position_over_velocity(&self.moves, row)?;
        let [position, velocity] = [&ports.outputs[row].name, &ports.outputs[ports.outputs.len() / 2 + row].name];
        let pushed = self.places.first().and_then(|place| {
            let push = place.pushes.iter().find(|push| push.input == row)?;
            answer(push, ports.outputs.len() / 2 + row)
        });
        let answers = pushed.or(self.in_time.filter(|_| row == 0)).filter(|answer| *answer != 0.0);
        let of_model = self.places.first().and_then(|place| place.ratio(Relation::Answer { input: row }, row));
        let reversed_alone = ratio < 0.0 && (0.5..=2.0).contains(&-ratio);
        // The derivative of a velocity has its unit, and takes its side.
        let smooth = self.first_model.as_ref().is_some_and(|model| model.smooth);
        let right = !smooth && of_model.is_some_and(|of_model| !of_model.is_out());
        let by_as_much = of_model.is_some_and(|of_model| (0.5..=2.0).contains(&(of_model.value() * ratio)));
        let who = match answers {
            _ if ratio.is_infinite() => Some(Quantity::Velocity),
            _ if ratio == 0.0 => Some(Quantity::Position),
            Some(answer) if reversed_alone => Some(if answer < 0.0 { Quantity::Velocity } else { Quantity::Position }),
            _ if right => Some(Quantity::Position),
            _ if by_as_much => Some(Quantity::Velocity),
            _ => None,
        };
        let seen = format!("{position} changes by {} times what {velocity} says in a step", digits(ratio));
        let words = match who {
            Some(Quantity::Velocity) if ratio.is_infinite() => {
                format!("the velocity is none: {position} changes, and {velocity} is 0")
            }
            Some(Quantity::Position) if ratio == 0.0 => {
                format!("the position is none: {position} stands, and {velocity} is not 0")
            }
            Some(Quantity::Velocity) if reversed_alone => format!("the velocity is reversed: {seen}"),
            Some(Quantity::Position) if reversed_alone => format!("the position is reversed: {seen}"),
            Some(Quantity::Velocity) => {
                format!("the velocity is wrong: {seen}; {}", in_words(1.0 / ratio, Quantity::Velocity))
            }
            Some(_) => format!("the position is wrong: {seen}; {}", in_words(ratio, Quantity::Position)),
            None => format!(
                "position and velocity do not add up: {seen}: the position is {}, the velocity {}, or its clock is another",
                in_words(ratio, Quantity::Position),
                in_words(1.0 / ratio, Quantity::Velocity)
            ),
        };
        let remedy = |quantity| {
            let factor = match quantity {
                _ if reversed_alone => -1.0,
                Quantity::Velocity => rounded(ratio),
                _ => rounded(1.0 / ratio),
            };
            (factor.is_finite() && factor != 0.0).then_some(Remedy { row, quantity, factor })
        };
        Some(Fault { words, remedy: who.and_then(remedy) })
    }

    /// Whether it moves as its model says.
    fn model(&self, ports: &Ports, tried: Tried) -> Option<Fault> {
        let rows = ports.outputs.len() / 2;
        let (relation, row, ratio) = match &self.places[..] {
            [] => self.model_in_time()?,
            [place] => {
                let found = place.out()?;
                (!tried.any_step.mechanics && !may_be_stiff(found.2)).then_some(found)?
            }
            [place, again, ..] => {
                let (relation, row, ratio) = place.out()?;
                let second = again.ratio(relation, row)?;
                (second.is_out() && second.agrees_with(ratio)).then_some((relation, row, second))?
            }
        };
        let first = self.moves.first().zip(self.first_model.as_ref());
        if relation == Relation::Acceleration
            && first.and_then(|(step, model)| step_over_model(step, model, row)).is_some_and(|first| !first.is_out())
        {
            return None;
        }
        let smooth = self.first_model.as_ref().is_some_and(|model| model.smooth);
        let velocity = &ports.outputs[rows + row].name;
        let Ratio { measured, said } = ratio;
        let of_model = in_words(1.0 / ratio.value(), Quantity::Velocity);
        let words = match relation {
            Relation::Answer { input } if smooth => format!(
                "its directional derivatives do not add up: 1 N more of {} changes {velocity} by {measured:.3e} m/s in a step, and they say \
                 {said:.3e} m/s; the derivative is {of_model}",
                ports.inputs[input].name
            ),
            Relation::Answer { input } => format!(
                "the force or its interface model does not add up: 1 N more of {} changes {velocity} by {measured:.3e} m/s in a step, and H \
                 says {said:.3e} m/s; H of the model is {of_model}, or the force {}",
                ports.inputs[input].name,
                in_words(1.0 / ratio.value(), Quantity::Force)
            ),
            Relation::Acceleration if smooth => format!(
                "its derivatives do not add up: {velocity} changes by {measured:.3e} m/s in a step, and the derivative of it says {said:.3e} \
                 m/s; {of_model}"
            ),
            Relation::Acceleration => format!(
                "its interface model does not add up: {velocity} changes by {measured:.3e} m/s in a step, and a + H λ says {said:.3e} m/s; \
                 a of the model is {of_model}"
            ),
        };
        Some(Fault { words, remedy: None })
    }

    /// The same of a side that gives no copies.
    fn model_in_time(&self) -> Option<(Relation, usize, Ratio)> {
        let (at, model) = self.model_in_time.as_ref()?;
        let step = self.moves.get(*at)?;
        let closed = model.at_bound.iter().any(|closed| *closed) || model.gap.iter().any(|gap| *gap <= 1e-6);
        if let Some(measured) = self.in_time.filter(|_| !closed) {
            let ratio =
                Ratio { measured, said: model.entry(model.interface_start(), model.interface_start()) * step.h };
            if ratio.is_out() && !may_be_stiff(ratio) {
                return Some((Relation::Answer { input: 0 }, 0, ratio));
            }
        }
        let first = self.moves.first().zip(self.first_model.as_ref())?;
        (0..step.before.len() / 2).find_map(|row| {
            let [one, other] = [step_over_model(first.0, first.1, row)?, step_over_model(step, model, row)?];
            let out = one.is_out() && other.is_out() && !may_be_stiff(one) && one.agrees_with(other);
            out.then_some((Relation::Acceleration, row, other))
        })
    }
}

/// Whether less was measured than was said because the step is long: what is stiff answers less, and steps of a twentieth are none that
/// anything is computed by.
fn may_be_stiff(ratio: Ratio) -> bool {
    (0.05..1.0).contains(&ratio.value())
}

/// A number as it is meant: a whole one or one over it, where it is one but for what an integrator adds.
fn rounded(number: f64) -> f64 {
    let near = |value: f64| (number / value - 1.0).abs() < 0.02;
    let powers = [1e-6, 1e-3, 1e-2, 1e-1, 10.0, 100.0, 1e3, 1e6];
    let known = powers.into_iter().flat_map(|power| [power, -power]).find(|value| near(*value));
    known.unwrap_or(number)
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
    let w = &model.w[model.interface_start()..];
    for (what, unit, of_model, of_outputs) in
        [("position", "m", &*model.position, positions), ("w of the interface", "m/s", w, velocities)]
    {
        for (row, (told, output)) in of_model.iter().zip(of_outputs).enumerate() {
            let size = told.abs().max(output.abs());
            if (told - output).abs() > SAME_MODEL[0] * size + SAME_MODEL[1] {
                return Err(format!(
                    "{what}, row {row}, is {told} {unit}, and the output of the same instant is {output} {unit}: a fault of this side, and \
                     not of the scheme"
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

/// Why a state that was kept is not the one that comes back, if a side keeps states and it is not. Its steps are added to `moves`.
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

/// A place in which each of these forces is pushed and pulled, from where the mechanics stands; none where it gives no copies.
fn pushed_place(
    mechanics: &mut dyn Subsystem,
    u: &[f64],
    [t, h]: [f64; 2],
    rows: &[usize],
    model: Option<ReducedInterfaceModel>,
) -> Result<Option<Place>, Failure> {
    let p = mechanics.ports().outputs.len();
    let mut before = vec![0.0; p];
    mechanics.outputs(u, &mut before)?;
    let after = |input: usize, change: f64| -> Result<Option<Vec<f64>>, Failure> {
        let Ok(mut copy) = mechanics.try_clone() else { return Ok(None) };
        let (mut u, mut y) = (u.to_vec(), vec![0.0; p]);
        u[input] += change;
        copy.step(t, &u, h)?;
        copy.outputs(&u, &mut y)?;
        Ok(Some(y))
    };
    let Some(as_is) = (if rows.is_empty() { None } else { after(0, 0.0)? }) else { return Ok(None) };
    let mut pushes = Vec::new();
    for &input in rows {
        let change = 0.1 * u[input].abs().max(1.0);
        let [Some(less), Some(more)] = [after(input, -change)?, after(input, change)?] else { return Ok(None) };
        pushes.push(Push { input, change, after: [less, as_is.clone(), more], h });
    }
    Ok(Some(Place { u: u.to_vec(), before, pushes, model }))
}

/// The first row whose velocity falls when its own force grows and rises when it shrinks, with the change by a newton, m/s.
fn moves_against(place: &Place) -> Option<(usize, f64)> {
    let rows = place.before.len() / 2;
    place.pushes.iter().find_map(|push| {
        let [less, as_is, more] = [0, 1, 2].map(|at| push.after[at][rows + push.input]);
        let slack = 1e-9 * less.abs().max(more.abs()) + AT_REST;
        (more < as_is - slack && as_is < less - slack).then_some((push.input, (more - less) / (2.0 * push.change)))
    })
}

/// Answer of the first velocity to its force, (m/s)/N, of a side that gives no copies, by steps one after the other, added to `moves`: as it
/// is, pushed and pulled, and what is beyond its motion before; none where the two do not agree on the sign.
fn answer_in_time(
    mechanics: &mut dyn Subsystem,
    u: &[f64],
    [t, h]: [f64; 2],
    moves: &mut Vec<Move>,
) -> Result<Option<f64>, Failure> {
    const EACH: usize = 3;
    let ports = mechanics.ports().clone();
    let p = ports.outputs.len();
    if pushed_rows(&ports) == 0 {
        return Ok(None);
    }
    let (mut u, mut y, own) = (u.to_vec(), vec![0.0; p], u[0]);
    let change = own.abs().max(1.0);
    mechanics.outputs(&u, &mut y)?;
    let (mut before, mut gains, mut size) = (y.clone(), Vec::new(), 0.0_f64);
    for k in 0..3 * EACH {
        u[0] = own + [0.0, change, -change][k / EACH];
        mechanics.step(t + k as f64 * h, &u, h)?;
        mechanics.outputs(&u, &mut y)?;
        gains.push(y[p / 2] - before[p / 2]);
        moves.push(Move { u: u.clone(), before: std::mem::replace(&mut before, y.clone()), after: y.clone(), h });
        size = size.max(y[p / 2].abs());
    }
    let slope = (gains[EACH - 1] - gains[0]) / (EACH - 1) as f64;
    // The first gain of each part may be of the part before, where outputs are those of the step before.
    let beyond = |part: usize| {
        let last = part * EACH + EACH - 1;
        0.5 * (gains[last] + gains[last - 1]) - (gains[EACH - 1] + slope * (last as f64 - 0.5 - (EACH - 1) as f64))
    };
    let (pushed, pulled) = (beyond(1), beyond(2));
    let slack = 10.0 * slope.abs() * EACH as f64 + 1e-9 * size + AT_REST;
    let opposite = pushed.abs().min(pulled.abs()) > slack && (pushed > 0.0) != (pulled > 0.0);
    Ok(opposite.then_some(pushed / change))
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

/// How the forces of an actuator change with position and velocity of their rows, after a step of a copy, or at once where there is none;
/// and whether that, and its step as it is, are what the derivatives of its outputs say.
fn answer_of(
    actuator: &mut dyn Subsystem,
    (u, y): (&[f64], &[f64]),
    t: f64,
    tried: Tried,
    fault: &mut Option<Fault>,
) -> Result<Answer, Failure> {
    let ports = actuator.ports().clone();
    let rows = ports.outputs.len();
    if ports.inputs.len() != 2 * rows {
        return Ok(Answer::Unclear);
    }
    let after = |actuator: &mut dyn Subsystem, u: &[f64], h: f64| -> Result<Vec<f64>, Failure> {
        let mut y = vec![0.0; rows];
        match actuator.try_clone() {
            Ok(mut copy) => {
                copy.step(t, u, h)?;
                copy.outputs(u, &mut y)?;
            }
            Err(_) => actuator.outputs(u, &mut y)?,
        }
        Ok(y)
    };
    let copies = actuator.try_clone().is_ok();
    let as_is = after(actuator, u, tried.h)?;
    let push = |actuator: &mut dyn Subsystem, input: usize, as_is: &[f64], h: f64| -> Result<Push, Failure> {
        let change = little(ports.inputs[input].quantity, u[input]);
        let mut changed = |change: f64| {
            let mut u = u.to_vec();
            u[input] += change;
            after(actuator, &u, h)
        };
        Ok(Push { input, change, after: [changed(-change)?, as_is.to_vec(), changed(change)?], h })
    };
    let mut pushes = Vec::new();
    let mut seen = [false; 2];
    for row in 0..rows.min(PUSHED_MOTIONS) {
        for input in [row, rows + row] {
            let push = push(actuator, input, &as_is, tried.h)?;
            let [less, more] = [push.after[0][row], push.after[2][row]];
            // What is beyond round-off.
            if (more - less).abs() > 1e-9 * more.abs().max(less.abs()) {
                seen[usize::from(more > less)] = true;
            }
            pushes.push(push);
        }
    }
    // As it was.
    let mut now = vec![0.0; rows];
    actuator.outputs(u, &mut now)?;
    let mut rates = OutputRates::zeros(rows, ports.inputs.len());
    let late = pushes.iter().all(|push| push.after[0] == push.after[1] && push.after[1] == push.after[2]);
    let told = !tried.probed.actuator && copies && !late && actuator.capabilities().output_rates(t, u, &mut rates)?;
    if told {
        let step = |after: &[f64], h: f64| Move { u: u.to_vec(), before: y.to_vec(), after: after.to_vec(), h };
        let answers = pushes.iter().flat_map(|push| (0..rows).map(move |row| (row, Some(push.input))));
        let all = answers.chain((0..rows).map(|row| (row, None)));
        let out = all.filter_map(|(row, input)| {
            let ratio = match input {
                Some(input) => answer_over_rate(pushes.iter().find(|push| push.input == input)?, &rates, row)?,
                None => step_over_rate(&step(&as_is, tried.h), &rates, row)?,
            };
            Some((row, input, ratio)).filter(|_| ratio.is_out())
        });
        if let Some((row, input, ratio)) = { out }.next() {
            // What is stiff answers otherwise in shorter steps.
            let shorter = if tried.any_step.actuator { SHORTER * tried.h } else { tried.h };
            let as_is = after(actuator, u, shorter)?;
            let second = match input {
                Some(input) => answer_over_rate(&push(actuator, input, &as_is, shorter)?, &rates, row),
                None => step_over_rate(&step(&as_is, shorter), &rates, row),
            };
            let force = &ports.outputs[row].name;
            let of = input.map_or_else(String::new, |input| format!(" by {}", ports.inputs[input].name));
            // In a shorter step a rate makes less, and what was put out a step late as much.
            let by_step = |second: Ratio| {
                let less = (second.measured / ratio.measured) / (shorter / tried.h);
                input.is_some() || (0.5..=2.0).contains(&less)
            };
            let agrees = |second: &Ratio| second.is_out() && second.agrees_with(ratio) && by_step(*second);
            if let Some(second) = second.filter(agrees) {
                *fault = Some(Fault {
                    words: format!(
                        "its derivatives do not add up: {force} changes{of} by {:.3e} in a step, and its derivative says {:.3e}; the \
                         derivative is {}",
                        second.measured,
                        second.said,
                        in_words(1.0 / second.value(), Quantity::Force)
                    ),
                    remedy: None,
                });
            }
            actuator.outputs(u, &mut now)?;
        }
    }
    Ok(match seen {
        [true, false] => Answer::PullsBack,
        [false, true] => Answer::PushesOn,
        _ => Answer::Unclear,
    })
}

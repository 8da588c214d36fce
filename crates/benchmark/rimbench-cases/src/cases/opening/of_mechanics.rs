//! What is seen of a mechanics that is pushed, and what of that does not add up.

use super::adds_up::{
    AT_REST, Move, Push, Ratio, answer, answer_over_model, digits, in_words, is_motion, position_over_velocity,
    step_over_model,
};
use super::{Fault, Remedy, Tried};
use rimbench_core::cosim::{Ports, Quantity, Subsystem};
use rimbench_core::error::Failure;
use rimbench_core::interface_model::ReducedInterfaceModel;

/// Rows of the interface that are pushed one by one.
const PUSHED_ROWS: usize = 4;

/// What is known of a mechanics in one place.
pub(super) struct Place {
    u: Vec<f64>,
    before: Vec<f64>,
    pushes: Vec<Push>,
    model: Option<ReducedInterfaceModel>,
}

/// Which of its relations does not hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Relation {
    /// Of a velocity to a pushed force.
    Answer { input: usize },
    /// Of a velocity to the accelerations.
    Acceleration,
}

/// What was seen of the mechanics.
#[derive(Default)]
pub(super) struct OfMechanics {
    pub(super) moves: Vec<Move>,
    /// Answer of the first velocity to its force, (m/s)/N, in steps one after the other.
    pub(super) in_time: Option<f64>,
    /// Its model at the beginning of the first step.
    pub(super) first_model: Option<ReducedInterfaceModel>,
    /// Its model at the beginning of steps one after the other, with the place of that step.
    pub(super) model_in_time: Option<(usize, ReducedInterfaceModel)>,
    pub(super) places: Vec<Place>,
    /// Whether a force drives its own row backwards and the actuator pulls back, in words.
    pub(super) reversed: Option<(usize, String)>,
}

impl Place {
    /// The step as it is.
    pub(super) fn step(&self) -> Option<Move> {
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
    pub(super) fn out(&self) -> Option<(Relation, usize, Ratio)> {
        let rows = self.before.len() / 2;
        // No row answers within the step: outputs are a step late, or the interface is locked.
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
    pub(super) fn fault(&self, ports: &Ports, tried: Tried) -> Option<Fault> {
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

/// Whether less was measured than was said because the step is long: what is stiff answers less, and steps of a
/// twentieth are none that anything is computed by.
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

/// How many rows have a force and a velocity, of those that are pushed.
pub(super) fn pushed_rows(ports: &Ports) -> usize {
    let is_force = ports.inputs.iter().all(|input| input.quantity == Quantity::Force);
    if is_force && ports.outputs.len() == 2 * ports.inputs.len() { ports.inputs.len().min(PUSHED_ROWS) } else { 0 }
}

/// A place in which each of these forces is pushed and pulled, from where the mechanics stands; none where it gives no
/// copies.
pub(super) fn pushed_place(
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

/// The first row whose velocity falls when its own force grows and rises when it shrinks, with the change by a newton,
/// m/s.
pub(super) fn moves_against(place: &Place) -> Option<(usize, f64)> {
    let rows = place.before.len() / 2;
    place.pushes.iter().find_map(|push| {
        let [less, as_is, more] = [0, 1, 2].map(|at| push.after[at][rows + push.input]);
        let slack = 1e-9 * less.abs().max(more.abs()) + AT_REST;
        (more < as_is - slack && as_is < less - slack).then_some((push.input, (more - less) / (2.0 * push.change)))
    })
}

/// Answer of the first velocity to its force, (m/s)/N, of a side that gives no copies, by steps one after the other,
/// added to `moves`: as it is, pushed and pulled, and what is beyond its motion before; none where the two do not agree
/// on the sign.
pub(super) fn answer_in_time(
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

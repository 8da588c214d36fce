//! Which way an actuator answers to its motion, and whether its derivatives say so.

use super::adds_up::{Move, Push, Ratio, answer_over_rate, in_words, step_over_rate};
use super::{Fault, SHORTER, Tried, little, pushed};
use rimbench_core::cosim::{OutputRates, PerSide, Quantity, Subsystem};
use rimbench_core::error::Failure;

/// Rows whose positions and velocities an actuator is pushed by.
const PUSHED_MOTIONS: usize = 2;

/// Which way an actuator answers to where it is and how fast it moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Answer {
    /// It pulls back, as a spring and a damper do.
    PullsBack,
    /// It pushes the further on, in all rows that answer.
    PushesOn,
    /// Neither, or both.
    Unclear,
}

/// How many times what is little an actuator is pushed by to see when it answers.
const PUSHES: [f64; 2] = [1.0, -1e3];

/// Whether an actuator does not answer at once, and does after a step; of one that gives no copies, whether its outputs
/// have moved in the steps `before`.
pub(super) fn answers_late(
    actuator: &mut dyn Subsystem,
    u: &[f64],
    [t, h]: [f64; 2],
    before: &[PerSide<Vec<f64>>],
) -> Result<bool, Failure> {
    let ports = actuator.ports().clone();
    let told = |actuator: &mut dyn Subsystem, times: f64| {
        let mut y = vec![0.0; ports.outputs.len()];
        actuator.outputs(&pushed(&ports, u, times), &mut y).map(|()| y)
    };
    let as_is = told(actuator, 0.0)?;
    let mut at_once = false;
    for times in PUSHES {
        at_once |= told(actuator, times)? != as_is;
    }
    told(actuator, 0.0)?;
    if at_once {
        return Ok(false);
    }
    let mut after = Vec::new();
    for times in [0.0, PUSHES[0], PUSHES[1]] {
        let Ok(mut copy) = actuator.try_clone() else {
            return Ok(before.windows(2).any(|two| two[0].actuator != two[1].actuator));
        };
        copy.step(t, &pushed(&ports, u, times), h)?;
        after.push(told(&mut *copy, times)?);
    }
    Ok(after.iter().any(|y| *y != after[0]))
}

/// How the forces of an actuator change with position and velocity of their rows, after a step of a copy, or at once
/// where there is none; and whether that, and its step as it is, are what the derivatives of its outputs say.
pub(super) fn answer_of(
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
            // Only changes beyond round-off have a sign.
            if (more - less).abs() > 1e-9 * more.abs().max(less.abs()) {
                seen[usize::from(more > less)] = true;
            }
            pushes.push(push);
        }
    }
    // Bring the actuator back to its outputs under the inputs at hand.
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
            // A stiff state answers differently in a shorter step: the ratio is checked there as well.
            let shorter = if tried.any_step.actuator { SHORTER * tried.h } else { tried.h };
            let as_is = after(actuator, u, shorter)?;
            let second = match input {
                Some(input) => answer_over_rate(&push(actuator, input, &as_is, shorter)?, &rates, row),
                None => step_over_rate(&step(&as_is, shorter), &rates, row),
            };
            let force = &ports.outputs[row].name;
            let of = input.map_or_else(String::new, |input| format!(" by {}", ports.inputs[input].name));
            // A rate changes the output in proportion to the step; an output that is a step late changes as much.
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

//! Positions that jump while the velocity goes on, as an angle that wraps does, and an encoder.

use rimbench_core::cosim::{Ports, Quantity};

/// How many times what the velocity says a position moves at least where it jumps on; where it jumps back, once.
const FAR: f64 = 10.0;
/// Share of the largest position so far that it jumps at least: what wraps goes from one end to the other.
const END_TO_END: f64 = 0.5;
/// Share of what a velocity says, and of what a change of it does, by which a position may move otherwise.
const SLACK: [f64; 2] = [0.1, 0.6];
/// Share of a position that is round-off.
const ROUND_OFF: f64 = 1e-12;

/// Watches the outputs of a mechanics, positions and as many velocities, for a jump: a step in which the position moves
/// as the velocity does not, between two in which it does, all of them in one direction.
#[derive(Debug, Clone, Default)]
pub struct JumpWatch {
    last: Vec<f64>,
    rows: Vec<Row>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Row {
    /// Whether the step before moved as its velocity says.
    steady: bool,
    /// From where to where it jumped in the step before.
    jump: Option<[f64; 2]>,
    largest: f64,
}

impl JumpWatch {
    /// Watches nothing where outputs are no positions and velocities.
    pub fn of(ports: &Ports) -> Self {
        let rows = ports.outputs.len() / 2;
        let is_motion = ports.outputs.first().is_some_and(|port| port.quantity == Quantity::Position);
        JumpWatch { last: Vec::new(), rows: vec![Row::default(); if is_motion { rows } else { 0 }] }
    }

    /// Takes the outputs of the beginning, unless it has them.
    pub fn begin(&mut self, y: &[f64]) {
        if self.last.is_empty() && !self.rows.is_empty() {
            self.last = y.to_vec();
        }
    }

    /// Looks at the outputs to which a step of `h` (s) has led.
    ///
    /// # Errors
    /// The jump, in words, one step after it.
    pub fn see(&mut self, h: f64, y: &[f64], ports: &Ports) -> Result<(), String> {
        if self.last.is_empty() {
            self.begin(y);
            return Ok(());
        }
        let count = self.rows.len();
        let mut found = None;
        for (at, row) in self.rows.iter_mut().enumerate() {
            let [x, to, v, w] = [self.last[at], y[at], self.last[count + at], y[count + at]];
            row.largest = row.largest.max(x.abs()).max(to.abs());
            let (said, fastest) = (0.5 * h * (v + w), h * v.abs().max(w.abs()));
            let slack = SLACK[0] * fastest + SLACK[1] * h * (w - v).abs() + ROUND_OFF * row.largest;
            let moves = (to - x - said).abs() <= slack && v * w > 0.0;
            if let Some([from, to]) = row.jump.take().filter(|_| moves) {
                found.get_or_insert((at, from, to, v));
            } else if row.steady && v * w > 0.0 {
                let far = if (to - x) * said < 0.0 { fastest } else { FAR * fastest };
                row.jump = Some([x, to]).filter(|_| (to - x).abs() > far.max(END_TO_END * row.largest));
            }
            row.steady = moves;
        }
        self.last.copy_from_slice(y);
        let Some((at, from, to, v)) = found else { return Ok(()) };
        let name = &ports.outputs[at].name;
        Err(format!(
            "its position {name} jumps from {from} m to {to} m, by {:.3e} m in one step, while its velocity is {v:.3e} m/s: an angle that \
             wraps, or an encoder; valid: a position that counts on; position = {{ start = … }} of a case file takes the integral of \
             the velocity instead",
            to - from
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use libm::{cos, sin};
    use rimbench_core::cosim::Port;
    use std::f64::consts::TAU;

    fn ports() -> Ports {
        let outputs = vec![Port::new("x", Quantity::Position), Port::new("v", Quantity::Velocity)];
        Ports { inputs: Vec::new(), outputs, direct_feedthrough: false }
    }

    fn seen(h: f64, motion: impl Fn(f64) -> [f64; 2]) -> Result<(), String> {
        let mut watch = JumpWatch::of(&ports());
        (0..2000).try_for_each(|k| watch.see(h, &motion(k as f64 * h), &ports()))
    }

    #[test]
    fn what_wraps_is_named_and_what_swings_or_is_hit_is_not() {
        for wrap in [0.5, TAU, 100.0] {
            for speed in [2.0, -0.3] {
                let said = seen(1e-2, |t| {
                    let turns = 0.3 + speed * (10.0 * t + 0.3 * sin(3.0 * t)) / wrap;
                    [(turns - turns.floor()) * wrap, speed * (10.0 + 0.9 * cos(3.0 * t))]
                });
                assert!(said.is_err_and(|said| said.contains("position x jumps from")), "{wrap} {speed}");
            }
        }
        // Even where a step is as long as a period and more.
        for rate in [1.0, 40.0, 400.0, 777.0] {
            let swings = seen(1e-2, |t| [sin(rate * t), rate * cos(rate * t)]);
            assert_eq!(swings, Ok(()), "{rate}");
        }
        let thrown_back = seen(1e-2, |t| [(t % 2.0 - 1.0).abs(), if t % 2.0 < 1.0 { -1.0 } else { 1.0 }]);
        assert_eq!(thrown_back, Ok(()));
    }
}

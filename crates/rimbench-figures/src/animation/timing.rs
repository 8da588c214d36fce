//! When an instant is shown, and the rules of a style sheet that move a part through its states.

use crate::case_picture::Motion;
use std::fmt::Write;

/// Seconds of playing per second outside and inside the slow part, and the rest at the end.
const PACE: [f64; 2] = [1.6, 14.0];
const REST_S: f64 = 1.2;
/// Positions closer than this to the line between keyframes need none of their own, px or degrees.
const SLACK: f64 = 0.06;

/// State of one moving part: translation, px, and a turn, degrees, or a scale.
pub(super) type State = [f64; 3];

/// When what is shown, and how slowly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// From when to when, s.
    pub shown_s: [f64; 2],
    /// The part of it that plays slowly, s.
    pub slow_s: [f64; 2],
    /// The instant of the still, s.
    pub still_s: f64,
}

impl Timing {
    /// Duration of one round, s.
    pub(super) fn round_s(&self) -> f64 {
        self.played(self.shown_s[1]) + REST_S
    }

    /// When an instant is shown, s after the start of a round.
    pub(super) fn played(&self, t: f64) -> f64 {
        let [from, to] = self.shown_s;
        let slow = self.slow_s.map(|end| end.clamp(from, to));
        let t = t.clamp(from, to);
        let inside = (t.min(slow[1]) - slow[0]).max(0.0);
        (t - from - inside) * PACE[0] + inside * PACE[1]
    }

    /// The rows of a run that are shown.
    pub(super) fn shown(&self, motion: &Motion) -> Vec<usize> {
        let [from, to] = self.shown_s;
        (0..motion.times_s.len()).filter(|&row| (from - 1e-9..=to + 1e-9).contains(&motion.times_s[row])).collect()
    }

    /// A rule that moves a class through its states, and the still that it starts from. Returns the attributes of what moves: its class,
    /// and the still for a reader that applies no style sheet.
    pub(super) fn moved(&self, name: &str, states: &[(f64, State)], turns: bool, style: &mut String) -> String {
        let written = |state: &State, [px, deg]: [&str; 2]| {
            let [x, y, third] = state.map(|value| round(value, 100.0));
            match turns {
                true => format!("translate({x}{px},{y}{px}) rotate({third}{deg})"),
                false => format!("translate({x}{px},{y}{px}) scale({third})"),
            }
        };
        // An attribute takes numbers only, a style sheet wants units.
        let (bare, units) = (["", ""], ["px", "deg"]);
        let still = states.iter().min_by(|a, b| (a.0 - self.still_s).abs().total_cmp(&(b.0 - self.still_s).abs()));
        let Some((_, still)) = still else { return format!("class=\"{name}\"") };
        let round_s = self.round_s();
        let timed: Vec<(f64, State)> = states.iter().map(|(t, state)| (self.played(*t) / round_s, *state)).collect();
        let mut frames = String::new();
        let kept = thinned(&timed);
        for (index, (share, state)) in kept.iter().enumerate() {
            let share = round(100.0 * share, 100.0);
            let last = if index + 1 == kept.len() { ",100%" } else { "" };
            let _ = write!(frames, "{share}%{last}{{transform:{}}}", written(state, units));
        }
        let _ = writeln!(
            style,
            ".{name}{{transform:{}}}@keyframes {name}{{{frames}}}\
             @media(prefers-reduced-motion:no-preference){{.{name}{{animation:{name} {:.2}s linear infinite}}}}",
            written(still, units),
            round_s,
        );
        format!("class=\"{name}\" transform=\"{}\"", written(still, bare))
    }
}

/// Drops the states that lie on the line between those kept.
pub(super) fn thinned(states: &[(f64, State)]) -> Vec<(f64, State)> {
    let mut kept: Vec<(f64, State)> = Vec::new();
    let mut start = 0;
    for end in 2..=states.len() {
        let beyond = end == states.len();
        let straight = !beyond && {
            let ((t0, from), (t1, to)) = (states[start], states[end]);
            states[start + 1..end].iter().all(|(t, state)| {
                let share = if t1 > t0 { (t - t0) / (t1 - t0) } else { 0.0 };
                (0..3).all(|k| {
                    (from[k] + share * (to[k] - from[k]) - state[k]).abs() <= if k == 2 { SLACK * 0.2 } else { SLACK }
                })
            })
        };
        if start == 0 && kept.is_empty() {
            kept.extend(states.first());
        }
        if !straight {
            kept.push(states[end - 1]);
            start = end - 1;
        }
    }
    if states.len() < 2 {
        kept = states.to_vec();
    }
    kept
}

/// A number on a grid, without a negative zero.
pub(super) fn round(value: f64, grid: f64) -> f64 {
    (value * grid).round() / grid + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_motion_needs_two_keyframes_and_a_jump_is_kept() {
        let straight: Vec<(f64, State)> = (0..50).map(|k| (f64::from(k), [f64::from(k), 0.0, 0.0])).collect();
        assert_eq!(thinned(&straight).len(), 2);
        let jump: Vec<(f64, State)> =
            (0..50).map(|k| (f64::from(k), [0.0, f64::from(u8::from(k > 20)), 0.0])).collect();
        let kept = thinned(&jump);
        assert!(kept.contains(&(20.0, [0.0; 3])) && kept.contains(&(21.0, [0.0, 1.0, 0.0])), "{kept:?}");
    }

    #[test]
    fn the_slow_part_takes_most_of_the_time() {
        let timing = Timing { shown_s: [1.0, 2.0], slow_s: [1.6, 1.8], still_s: 1.75 };
        let slow = timing.played(1.8) - timing.played(1.6);
        assert!(slow > 0.5 * timing.round_s() && timing.played(1.0) == 0.0, "{slow}");
    }
}

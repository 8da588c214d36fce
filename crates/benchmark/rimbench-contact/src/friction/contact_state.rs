//! The state of a contact with friction.

use super::FrictionProblem;

/// So near the border of the cone, in parts of it, an impulse is on it.
const BORDER: f64 = 1e-12;

/// State of a contact over a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ContactState {
    /// It carries nothing: `P = 0`, `w_n ≥ 0`.
    #[default]
    Open,
    /// It does not move: `w_n = w_t = 0`, `|P_t| ≤ μ P_n`.
    Stick,
    /// It slides forwards: `w_n = 0`, `w_t ≥ 0`, `P_t = −μ P_n`. In space it slides, along a direction that is kept
    /// beside the state.
    SlipPositive,
    /// It slides backwards: `w_n = 0`, `w_t ≤ 0`, `P_t = +μ P_n`.
    SlipNegative,
}

impl ContactState {
    /// All of them.
    pub const ALL: [ContactState; 4] =
        [ContactState::Open, ContactState::Stick, ContactState::SlipPositive, ContactState::SlipNegative];

    /// Returns the number that it has among numbers, in a trace: its place in the list.
    pub fn as_number(self) -> f64 {
        f64::from(self as u8)
    }

    /// Returns the state that a number stands for, if it does.
    pub fn of_number(number: f64) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.as_number() == number)
    }

    /// Returns `P_t / (μ P_n)` of a contact that slides; 0 of one that does not.
    #[inline]
    pub fn friction(self) -> f64 {
        match self {
            ContactState::Open | ContactState::Stick => 0.0,
            ContactState::SlipPositive => -1.0,
            ContactState::SlipNegative => 1.0,
        }
    }

    /// Returns what the contact did in a solution in which it moves by `w_t` (m/s), standing still up to `tolerance`
    /// (m/s).
    ///
    /// One of several redundant contacts may be loaded up to its border and stand still with the others: it has not
    /// slid. States are not unique there, velocities are.
    #[inline]
    pub fn moving(self, w_t: f64, tolerance: f64) -> Self {
        match self {
            ContactState::SlipPositive | ContactState::SlipNegative if w_t.abs() <= tolerance => ContactState::Stick,
            known => known,
        }
    }

    /// Returns the state that impulses (N·s) are those of: nothing, within the cone, or on its border.
    #[inline]
    pub fn of_impulses(p_n: f64, p_t: f64, mu: f64) -> Self {
        let bound = mu * p_n;
        if p_n <= 0.0 {
            ContactState::Open
        } else if p_t.abs() < bound * (1.0 - BORDER) {
            ContactState::Stick
        } else if p_t > 0.0 {
            ContactState::SlipNegative
        } else {
            ContactState::SlipPositive
        }
    }

    /// Writes the states of all contacts that impulses (N·s) are those of.
    pub(super) fn write_of_impulses(problem: FrictionProblem<'_>, impulses: &[f64], states: &mut [Self]) {
        let (normal, tangential) = impulses.split_at(states.len());
        for (contact, (state, mu)) in states.iter_mut().zip(problem.cone.friction).enumerate() {
            *state = Self::of_impulses(normal[contact], tangential[contact], *mu);
        }
    }

    /// Returns the state of a closed contact that moves so (m/s), standing still up to `tolerance` (m/s).
    #[inline]
    pub fn of_closed(w_t: f64, tolerance: f64) -> Self {
        if w_t > tolerance {
            ContactState::SlipPositive
        } else if w_t < -tolerance {
            ContactState::SlipNegative
        } else {
            ContactState::Stick
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impulses_on_the_border_of_the_cone_are_those_of_a_slip_against_them() {
        let of = |p_n, p_t| ContactState::of_impulses(p_n, p_t, 0.5);
        assert_eq!([of(0.0, 0.0), of(-1.0, 0.0)], [ContactState::Open; 2]);
        assert_eq!([of(4.0, 1.99), of(4.0, -1.99), of(0.1, 0.0)], [ContactState::Stick; 3]);
        assert_eq!([of(4.0, 2.0), of(4.0, -2.0)], [ContactState::SlipNegative, ContactState::SlipPositive]);
    }
}

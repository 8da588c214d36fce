//! The excitation of the mechanics in a step, and its share in a piece of it.

use crate::cosim::{ForceProfile, JointActuator, OutputRates, Sent};

/// The excitation of the mechanics in a step.
pub(in crate::mechanics) enum Excitation<'a, 'b> {
    /// Interface forces (N) that are held.
    Force(&'a [f64]),
    /// Interface forces of which each piece takes its own mean.
    Prescribed {
        /// Over the step.
        profile: ForceProfile<'a>,
        /// Time of the step that is over, s.
        done: f64,
    },
    /// An actuator that takes every piece with the mechanics.
    Together {
        /// The actuator, in the state that belongs to the mechanics'.
        actuator: &'a mut dyn JointActuator,
        /// Time of that state, s.
        time: f64,
        /// Is told length (s), force and mean motion of each piece.
        sent: &'a mut Sent<'b>,
    },
}

impl Excitation<'_, '_> {
    /// Tells whether the force of a piece depends on where it ends.
    pub(super) fn varies(&self) -> bool {
        matches!(self, Excitation::Prescribed { .. })
    }
}

/// Force and motion at the interface in a piece.
#[derive(Debug, Clone)]
pub(super) struct InterfaceTrajectory {
    /// `[s; w]` at its start, at its end, and in the mean.
    pub(super) start: Vec<f64>,
    pub(super) end: Vec<f64>,
    pub(super) mean: Vec<f64>,
    /// The actuator's outputs in its middle, with the motion of its start.
    pub(super) middle_force: Vec<f64>,
    /// The forces that act, N, and the largest that has acted so far.
    pub(super) force: Vec<f64>,
    /// Its first moment about the middle of the piece, N·s², and whether it is known.
    pub(super) moment: Vec<f64>,
    pub(super) moment_known: bool,
    pub(super) largest: f64,
    pub(super) rates: OutputRates,
}

impl InterfaceTrajectory {
    /// Makes room for `n_i` interface rows.
    pub(super) fn new(n_i: usize) -> Self {
        let zeros = |count: usize| vec![0.0; count];
        InterfaceTrajectory {
            start: zeros(2 * n_i),
            end: zeros(2 * n_i),
            mean: zeros(2 * n_i),
            middle_force: zeros(n_i),
            force: zeros(n_i),
            moment: zeros(n_i),
            moment_known: false,
            largest: f64::MIN_POSITIVE,
            rates: OutputRates::zeros(n_i, 2 * n_i),
        }
    }
}

//! Volumes of oil that can be replaced by lines whose travel time is the macro step.

use super::communication_grid::MacroStep;
use super::output_history::OutputHistory;

/// The action of the lines on the mechanics over a macro step, known when it begins: the force of row i is
///
/// ```text
/// λ_i(t) = C_i(t) − Z_i w_i(t)       C_i in N, one value per micro step;  Z_i in N·s/m
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LineForces {
    smoothing: f64,
    impedance: Vec<f64>,
    history: OutputHistory,
}

impl LineForces {
    /// Makes lines for an interface of some rows, with room for a number of micro steps per macro step; `smoothing` is
    /// the share α of the wave before that each wave keeps.
    pub fn new(rows: usize, micro_steps: usize, smoothing: f64) -> Self {
        LineForces { smoothing, impedance: vec![0.0; rows], history: OutputHistory::new(rows, micro_steps) }
    }

    /// Makes room for more micro steps.
    pub(crate) fn reserve(&mut self, micro_steps: usize) {
        *self = LineForces::new(self.impedance.len(), micro_steps, self.smoothing);
    }

    /// Returns α, in [0, 1).
    pub fn smoothing(&self) -> f64 {
        self.smoothing
    }

    /// Returns Z_i, N·s/m.
    pub fn impedance(&self) -> &[f64] {
        &self.impedance
    }

    /// Begins a macro step with these Z_i, N·s/m.
    pub fn begin(&mut self, impedance: &[f64]) {
        self.impedance.copy_from_slice(impedance);
        self.history.clear();
    }

    /// Adds C of the next micro step, one value per row, N.
    pub fn push(&mut self, forces: &[f64]) {
        self.history.push(forces);
    }

    /// Returns C in one micro step, one value per row, N.
    pub fn at(&self, micro_step: usize) -> &[f64] {
        self.history.at(micro_step)
    }

    /// Writes the mean of C over part `index` of `parts` equal parts of the macro step.
    pub(crate) fn mean_over(&self, index: usize, parts: usize, mean: &mut [f64]) {
        self.history.mean_over(index, parts, mean);
    }

    /// Copies the values of others of equal size; allocates only what was never there.
    pub(crate) fn copy_from(&mut self, other: &LineForces) {
        self.smoothing = other.smoothing;
        self.impedance.clone_from(&other.impedance);
        self.history.copy_from(&other.history);
    }
}

/// A subsystem whose volumes of oil can be replaced by lines.
pub trait TransmissionLines {
    /// Replaces the volumes by lines, from the next communication point on, with room for a number of micro steps per
    /// macro step.
    fn lay(&mut self, micro_steps: usize, smoothing: f64);

    /// Lets arrive what was sent over the last macro step, given the motion now (`u`, as the subsystem's input), and
    /// writes what the lines will do over `step`, which has `micro_steps`. What leaves its range fails in the next
    /// micro step.
    fn exchange(&mut self, step: MacroStep, micro_steps: usize, u: &[f64], forces: &mut LineForces);
}

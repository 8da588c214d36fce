//! The share of the mechanics that a bond's model has: what its own force moves is lighter by it.

use super::plan::Share;
use crate::cosim::communication_grid::{MacroStep, MicroStep};
use crate::cosim::coupling_scheme::{CouplingScheme, ModelEnd, Sample, SchemeReport};
use crate::cosim::side::Side;
use crate::error::Failure;
use crate::interface_model::Correlation;

/// Drives the model of another scheme with `G + Λ (λ − G)` on the bond's own rows; `G` is the last mean, or nothing.
pub(super) struct SharedModel {
    inner: Box<dyn CouplingScheme>,
    rows: Vec<usize>,
    /// `Λ` of each of them: one over the share.
    factors: Vec<f64>,
    /// Where `Λ` is found anew at every communication point.
    by_rows: Option<Correlation>,
    is_blind: bool,
    guess: Vec<f64>,
    sum: Vec<f64>,
    micro_steps: usize,
    driving: Vec<f64>,
}

impl SharedModel {
    /// Lets a scheme, whose actuator side has `n` rows, move this share of the mechanics; `is_blind`: no force is
    /// guessed.
    pub(super) fn of(
        inner: Box<dyn CouplingScheme>,
        (share, factor): (Share, f64),
        rows: &[usize],
        n: usize,
        is_blind: bool,
    ) -> Box<dyn CouplingScheme> {
        let by_rows = (share == Share::Rows).then(|| Correlation::new(n));
        if factor == 1.0 && by_rows.is_none() {
            return inner;
        }
        let room = || vec![0.0; rows.len()];
        Box::new(SharedModel {
            inner,
            rows: rows.to_vec(),
            factors: vec![factor; rows.len()],
            by_rows,
            is_blind,
            guess: room(),
            sum: room(),
            micro_steps: 0,
            driving: vec![0.0; n],
        })
    }
}

impl CouplingScheme for SharedModel {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        if let (Side::Mechanics, Some(by_rows), Some(model)) = (from, &mut self.by_rows, sample.model) {
            let first = model.interface_start();
            by_rows.set(|i, j| model.entry(first + i, first + j));
            for (factor, &row) in self.factors.iter_mut().zip(&self.rows) {
                *factor = by_rows.row_sum(row, |j| !self.rows.contains(&j));
            }
        }
        if from == Side::Actuator {
            for (at, &row) in self.rows.iter().enumerate().filter(|_| !self.is_blind) {
                self.guess[at] = match self.micro_steps {
                    0 => sample.y[row],
                    count => self.sum[at] / count as f64,
                };
            }
            self.sum.fill(0.0);
            self.micro_steps = 0;
        }
        self.inner.receive(from, sample)
    }

    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            return self.inner.input(to, at, own, u);
        }
        self.driving.copy_from_slice(own);
        self.micro_steps += 1;
        for (at, &row) in self.rows.iter().enumerate() {
            self.sum[at] += own[row];
            let (factor, own) = (self.factors[at], own[row]);
            // A whole body has no need of a guess of the own force.
            let guess = if factor == 1.0 { own } else { self.guess[at] };
            self.driving[row] = guess + factor * (own - guess);
        }
        self.inner.input(to, at, &self.driving, u)
    }

    fn change_macro_step(&mut self, step: MacroStep, micro_step: f64, mechanics_steps: usize) -> Result<(), Failure> {
        self.inner.change_macro_step(step, micro_step, mechanics_steps)
    }

    fn model_end(&mut self) -> Option<ModelEnd<'_>> {
        self.inner.model_end()
    }

    fn loaded_mobility(&mut self) -> Option<&[f64]> {
        self.inner.loaded_mobility()
    }

    fn report(&mut self) -> SchemeReport {
        self.inner.report()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        None
    }
}

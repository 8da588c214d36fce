//! `interface-jacobian`: one Newton step on the coupling equations per macro step, from directional derivatives.
//!
//! Over the macro step the mechanics answers as its condensed interface model does, the actuator as its directional
//! derivatives say; the trapezoidal rule on both gives the increments of velocity, length and force:
//!
//! ```text
//! Δw = H (â + Ĥ (λ_k + ½ Δλ))           Δs = H (w_k + ½ Δw)
//! Δλ = H r + K_s Δs + K_v Δw            K = D + ½ H R
//! ⇒ (I − (K_v + ½ H K_s) ½ H Ĥ) Δλ = H r + H K_s w_k + (K_v + ½ H K_s) H (â + Ĥ λ_k)
//! ```
//! `Ĥ, â` from the interface model with those contacts bilateral that the mechanics' last step found closed and that
//! carry impulse at `t_k`, with friction in the modes of that problem; `r, D, R` from the actuator ([`OutputRates`]).
//! The actuator then gets the velocity on a straight line over Δw and the length that belongs to it, the mechanics the
//! mean force λ_k + ½ Δλ: both sides at once (Jacobi), no step is taken back. **Needs** an interface model of the
//! mechanics, directional derivatives of the actuator, an interface of at most 32 rows. **Order** 2 in H. **Known
//! weakness**: linear over the whole macro step: a valve that opens, a contact that closes within it are not seen;
//! contacts are bilateral as in `rim-smooth-active`. **Source**: after Sicklinger et al. 2014 (interface Jacobian-based
//! co-simulation), with one step and no iteration; the trapezoidal rule and the use of the interface model are ours.

use super::active_contacts::ActiveContacts;
use super::construction::{Construction, ModelConstruction, sent, sent_rates};
use super::entry::{Family, SchemeEntry};
use super::input_polynomial::InputPolynomial;
use super::recorded_modes::RecordedModes;
use super::requirement::Requirement;
use crate::cosim::{CouplingScheme, Cubic, MacroStep, MicroStep, OutputRates, Sample, SchemeReport, Side};
use crate::error::{Cause, Failure, Result};
use crate::interface_model::{Condensation, ReducedInterfaceModel, condense_in_modes};
use nalgebra::{SMatrix, SVector};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        family: Family::Model,
        order: 2,
        needs: vec![
            Requirement::ForceDisplacement,
            Requirement::InterfaceModel,
            Requirement::OutputRates,
            Requirement::Rows(MOST_ROWS),
            Requirement::NotMechanicsFirst,
        ],
        ..SchemeEntry::new(
            "interface-jacobian",
            "One Newton step on the linearised coupling equations per macro step, nothing taken back",
            |construction| match construction.interface() {
                ..=FEW_ROWS => Ok(Box::new(InterfaceJacobian::<FEW_ROWS>::new(construction, |a, b| a.lu().solve(b))?)),
                _ => Ok(Box::new(InterfaceJacobian::<MOST_ROWS>::new(construction, |a, b| a.lu().solve(b))?)),
            },
        )
    }
}

/// Interface rows, a few and at most: what is solved is padded to one of these sizes, so that it lives on the stack.
const FEW_ROWS: usize = 8;
const MOST_ROWS: usize = 32;

#[derive(Clone)]
struct InterfaceJacobian<const N: usize> {
    rows: usize,
    active: ActiveContacts,
    received: ReducedInterfaceModel,
    modes: RecordedModes,
    closed: Vec<usize>,
    condensation: Condensation,
    step: MacroStep,
    position: SVector<f64, N>,
    velocity: SVector<f64, N>,
    force: SVector<f64, N>,
    velocity_change: SVector<f64, N>,
    force_change: SVector<f64, N>,
    motion: InputPolynomial,
    solve: Solve<N>,
}

/// Solves equations of so many rows; none of a singular matrix.
type Solve<const N: usize> = fn(SMatrix<f64, N, N>, &SVector<f64, N>) -> Option<SVector<f64, N>>;

impl<const N: usize> InterfaceJacobian<N> {
    fn new(construction: &Construction<'_>, solve: Solve<N>) -> Result<Self> {
        let ModelConstruction { empty, options, .. } = construction.model()?;
        let (contacts, rows) = (empty.contacts(), empty.interface());
        Ok(InterfaceJacobian {
            rows,
            active: ActiveContacts::of(empty, &options.solver),
            received: empty.clone(),
            modes: RecordedModes::of(empty),
            closed: Vec::with_capacity(contacts),
            condensation: if empty.has_friction() {
                Condensation::of(empty)
            } else {
                Condensation::new(contacts, rows)
            },
            step: MacroStep { index: 0, start: 0.0, length: 0.0 },
            position: SVector::<f64, N>::zeros(),
            velocity: SVector::<f64, N>::zeros(),
            force: SVector::<f64, N>::zeros(),
            velocity_change: SVector::<f64, N>::zeros(),
            force_change: SVector::<f64, N>::zeros(),
            motion: InputPolynomial::new(2 * rows, 2),
            solve,
        })
    }

    /// Solves the linearised coupling equations for the increments over the macro step.
    fn predict(&mut self, lambda: &[f64], rates: &OutputRates) -> Result<(), Failure> {
        self.received.closed_contacts(&mut self.closed);
        self.modes.start_from(&self.received);
        self.active.keep(&mut self.closed, &self.received, lambda, false, &mut self.modes)?;
        condense_in_modes(&self.received, self.modes.get(), &self.closed, &mut self.condensation);
        let (rows, h) = (self.rows, self.step.length);
        let square = |entry: &dyn Fn(usize, usize) -> f64| {
            SMatrix::<f64, N, N>::from_fn(|i, j| if i < rows && j < rows { entry(i, j) } else { 0.0 })
        };
        let column = |values: &[f64]| SVector::<f64, N>::from_fn(|i, _| values.get(i).copied().unwrap_or_default());
        let mobility = square(&|i, j| self.condensation.h[i * rows + j]);
        // K = D + ½ H R; the columns of the positions come first.
        let gain =
            |i: usize, j: usize| rates.feedthrough[i * 2 * rows + j] + 0.5 * h * rates.rate_gain[i * 2 * rows + j];
        let by_position = square(&|i, j| gain(i, j));
        let by_velocity = square(&|i, j| gain(i, rows + j)) + by_position * (0.5 * h);
        self.velocity = column(&self.condensation.w);
        let free = (column(&self.condensation.a) + mobility * self.force) * h;
        let right = column(&rates.rate) * h + by_position * self.velocity * h + by_velocity * free;
        let left = SMatrix::<f64, N, N>::identity() - by_velocity * mobility * (0.5 * h);
        self.force_change = (self.solve)(left, &right)
            .ok_or_else(|| Failure::from(Cause::Singular { matrix: "interface Jacobian" }))?;
        self.velocity_change = free + mobility * self.force_change * (0.5 * h);
        for row in 0..rows {
            let (w, slope) = (self.velocity[row], self.velocity_change[row] / h);
            self.motion.rows[row] = [self.position[row], w, 0.5 * slope, 0.0];
            self.motion.rows[rows + row] = [w, slope, 0.0, 0.0];
        }
        Ok(())
    }
}

impl<const N: usize> CouplingScheme for InterfaceJacobian<N> {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        match from {
            Side::Mechanics => {
                self.step = sample.step;
                self.position.as_mut_slice()[..self.rows].copy_from_slice(&sample.y[..self.rows]);
                self.received.copy_from(sent(sample.model)?);
            }
            Side::Actuator => {
                self.force.as_mut_slice()[..self.rows].copy_from_slice(sample.y);
                let rates = sent_rates(sample.rates)?;
                self.predict(sample.y, rates)?;
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            // The mean over this micro step of a force on a straight line.
            let share = (at.since_exchange + 0.5 * at.length) / self.step.length;
            for (row, u) in u.iter_mut().enumerate() {
                *u = self.force[row] + share * self.force_change[row];
            }
            return Ok(());
        }
        self.motion.mean(at, u);
        Ok(())
    }

    fn input_polynomials(&self, to: Side, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        match to {
            Side::Actuator => self.motion.within(at, polynomials),
            Side::Mechanics => {
                for (row, polynomial) in polynomials.iter_mut().enumerate() {
                    let slope = self.force_change[row] / self.step.length;
                    *polynomial = [self.force[row] + at.since_exchange * slope, slope, 0.0, 0.0];
                }
                true
            }
        }
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport {
            effective_mass: Some(self.condensation.effective_mass),
            counters: self.active.counters(),
            ..SchemeReport::default()
        }
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

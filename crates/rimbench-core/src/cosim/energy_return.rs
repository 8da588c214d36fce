//! Energy that the coupling created, taken out again at the interface.

use super::interface_work::InterfaceWork;
use super::step_prediction::StepPrediction;
use crate::complementarity::{SolverCounters, SolverEntry};
use crate::error::{Failure, Result};
use crate::interface_model::{Condensation, ReducedInterfaceModel, Redundancy, condense};
use crate::linear_algebra::{Lu, body_dot};
use crate::name::by_name;
use std::fmt;

/// What becomes of energy that the coupling creates, as an option of every scheme with an interface model.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum EnergyReturn {
    /// It stays in the system.
    #[default]
    None,
    /// It goes to a pool, and an interface impulse takes it out again; see [`EnergyPool`]. What the coupling loses is lost.
    Pool,
    /// The same, but what the coupling loses counts against what it creates before and afterwards.
    Balance,
}

impl EnergyReturn {
    const NAMES: [(&'static str, EnergyReturn); 3] =
        [("none", EnergyReturn::None), ("pool", EnergyReturn::Pool), ("balance", EnergyReturn::Balance)];
}

by_name!(EnergyReturn, NAMES, "energy return");

/// What was created and what was taken out since the start.
///
/// ```text
/// created = Σ max(E_k, 0)        E_k = received − sent over macro step k, without the work of p; by balance Σ E_k
/// removed = −Σ p ½ (w + w⁺)      as the mechanics received it
/// ```
/// So at every communication point `received − sent ≤ pool`, counted from the start; where losses do not count, from any
/// communication point at which the pool was empty, up to what was overdrawn there.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyBooks {
    /// J.
    pub created_j: f64,
    /// J.
    pub removed_j: f64,
}

impl EnergyBooks {
    /// Returns what is still to be taken out, J: `created − removed`, or 0.
    pub fn pool_j(&self) -> f64 {
        (self.created_j - self.removed_j).max(0.0)
    }

    /// Returns what was taken out too much, J. Round-off where the mechanics steps as its interface model says; what is created next
    /// pays for it. By balance what was lost is in it.
    pub fn overdrawn_j(&self) -> f64 {
        (self.removed_j - self.created_j).max(0.0)
    }
}

/// How close the work of an impulse must come to the energy wanted, relative to it.
const AGREEMENT: f64 = 1e-12;
/// Impulses tried at most where contacts open or close under them.
const MOST_TRIALS: u32 = 12;

/// Takes out of the mechanics, by an impulse p within its next step, what the coupling created in the macro step before.
///
/// ```text
/// p = −α H_eff⁻¹ w̃       w̃ = ½ (w + w₀⁺),  w₀⁺ without p       H_eff with the contacts closed that carry impulse
/// R = −p·½ (w + w⁺(p))   = E        α = 1 − √(1 − 2E/(w̃ᵀ H_eff⁻¹ w̃)), or 1 where E is more than there is
/// ```
/// With one interface row this is `p = −2E/(w̃ + sgn(w̃) √(w̃² − 2 H_eff E))`. Where p opens or closes a contact, `w⁺(p)` is that of the
/// contact problem, and α the result of an iteration; of what has been tried the largest R ≤ E is taken. A locked interface gives
/// nothing, neither does one at rest.
/// # Source
/// Ours.
#[derive(Clone)]
pub struct EnergyPool {
    by_balance: bool,
    prediction: StepPrediction,
    condensation: Condensation,
    loaded: Vec<usize>,
    books: EnergyBooks,
    /// At the last communication point.
    work: InterfaceWork,
    /// What p took out in the macro step since, J.
    removed: f64,
    /// `w⁺` of a trial, and ½ (w + w⁺).
    after: Vec<f64>,
    mean: Vec<f64>,
    /// `H_eff`, then what elimination leaves of it; `H_eff⁻¹ w̃`.
    matrix: Vec<f64>,
    direction: Vec<f64>,
    lu: Lu,
    /// p, N·s; what the mechanics was to receive without it, N; where the interface rows stood.
    impulse: Vec<f64>,
    force: Vec<f64>,
    displacement: Vec<f64>,
}

impl fmt::Debug for EnergyPool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("EnergyPool").field("books", &self.books).finish_non_exhaustive()
    }
}

impl EnergyPool {
    /// Makes an empty pool for models of the size of `empty`; none where no energy is to be returned.
    pub fn new(kind: EnergyReturn, empty: &ReducedInterfaceModel, solver: &SolverEntry) -> Option<Self> {
        let by_balance = match kind {
            EnergyReturn::None => return None,
            EnergyReturn::Pool => false,
            EnergyReturn::Balance => true,
        };
        let (n_u, n_i) = (empty.contacts(), empty.interface());
        let (solver, zeros) = (solver.checked(n_u), vec![0.0; n_i]);
        Some(EnergyPool {
            by_balance,
            prediction: StepPrediction::new(empty, solver),
            condensation: Condensation::new(n_u, n_i),
            loaded: Vec::with_capacity(n_u),
            books: EnergyBooks::default(),
            work: InterfaceWork::default(),
            removed: 0.0,
            after: zeros.clone(),
            mean: zeros.clone(),
            matrix: vec![0.0; n_i * n_i],
            direction: zeros.clone(),
            lu: Lu::new(n_i),
            impulse: zeros.clone(),
            force: zeros.clone(),
            displacement: zeros,
        })
    }

    /// Returns the books.
    pub fn books(&self) -> EnergyBooks {
        self.books
    }

    /// Returns the contact problems solved so far.
    pub fn counters(&self) -> SolverCounters {
        self.prediction.counters()
    }

    /// Takes note of the work across the interface until a communication point.
    pub fn note_work(&mut self, work: InterfaceWork) {
        let before = std::mem::replace(&mut self.work, work).residual_j().unwrap_or(0.0);
        let residual = work.residual_j().unwrap_or(0.0) - before;
        let removed = std::mem::take(&mut self.removed);
        let created = removed - residual;
        self.books.created_j += if self.by_balance { created } else { created.max(0.0) };
    }

    /// Adds to the forces `u` (N) of the mechanics' next step what takes the pool out; `model` must be that of the present state and
    /// of that step, and `displacement` what the mechanics says of its interface rows.
    ///
    /// # Errors
    /// Those of the complementarity solver.
    pub fn give(&mut self, model: &ReducedInterfaceModel, u: &mut [f64], displacement: &[f64]) -> Result<(), Failure> {
        self.force.copy_from_slice(u);
        self.displacement.copy_from_slice(displacement);
        self.impulse.fill(0.0);
        let energy = self.books.pool_j();
        if energy > 0.0 {
            self.find_impulse(model, energy)?;
            for (u, p) in u.iter_mut().zip(&self.impulse) {
                *u += p / model.mechanics_step;
            }
        }
        Ok(())
    }

    /// Books what the impulse did in a step of `h` (s), now that it is known how far the interface rows went, and takes it out of the
    /// forces `u` again.
    pub fn take_back(&mut self, h: f64, u: &mut [f64], displacement: &[f64]) {
        let way = displacement.iter().zip(&self.displacement).map(|(after, before)| after - before);
        let work: f64 = way.zip(&self.impulse).map(|(way, p)| p * way / h).sum();
        self.removed = -work;
        self.books.removed_j -= work;
        u.copy_from_slice(&self.force);
    }

    /// Finds the impulse that takes out `energy` (J), or as much of it as there is.
    fn find_impulse(&mut self, model: &ReducedInterfaceModel, energy: f64) -> Result<(), Failure> {
        self.prediction.set_model(model);
        self.try_impulse(model, 0.0)?;
        if !self.find_direction(model) {
            return Ok(());
        }
        // m(s) = d·½(w + w⁺(s)) falls with s, and R = s m(s).
        let at_rest = body_dot(&self.direction, &self.mean);
        if !(at_rest > 0.0 && at_rest.is_finite()) {
            return Ok(());
        }
        let (mut best, mut largest) = (0.0, 0.0);
        let mut share = smaller_root(at_rest, 0.5 * at_rest, energy);
        for _ in 0..MOST_TRIALS {
            self.try_impulse(model, share)?;
            let reached = body_dot(&self.direction, &self.mean);
            let removed = share * reached;
            if removed > largest && removed <= energy * (1.0 + AGREEMENT) {
                (best, largest) = (share, removed);
            }
            // The chord of m from 0 to here; where no contact opens or closes it is m itself.
            let next = smaller_root(at_rest, (at_rest - reached) / share, energy);
            if !next.is_finite() || (next - share).abs() <= AGREEMENT * share {
                break;
            }
            share = next;
        }
        if best == 0.0 {
            // Feasible whatever the contacts do, for m falls.
            best = energy / at_rest;
            self.try_impulse(model, best)?;
            if body_dot(&self.direction, &self.mean) <= 0.0 {
                best = 0.0;
            }
        }
        for (p, d) in self.impulse.iter_mut().zip(&self.direction) {
            *p = -best * d;
        }
        Ok(())
    }

    /// Finds `½ (w + w⁺)` of a step with `p = −share d`.
    fn try_impulse(&mut self, model: &ReducedInterfaceModel, share: f64) -> Result<(), Failure> {
        for (p, d) in self.impulse.iter_mut().zip(&self.direction) {
            *p = if share == 0.0 { 0.0 } else { -share * d };
        }
        let tried = self.prediction.velocity_after(model, &self.force, &self.impulse, &mut self.after);
        if tried.is_err() {
            self.impulse.fill(0.0);
        }
        tried?;
        for (mean, (after, before)) in self.mean.iter_mut().zip(self.after.iter().zip(&model.w[model.contacts()..])) {
            *mean = 0.5 * (before + after);
        }
        Ok(())
    }

    /// Finds `d = H_eff⁻¹ w̃`; false if there is none. Locked rows have no share in it.
    fn find_direction(&mut self, model: &ReducedInterfaceModel) -> bool {
        let n_i = model.interface();
        self.loaded.clear();
        let impulses = self.prediction.impulses.iter().enumerate();
        self.loaded.extend(impulses.filter(|(_, impulse)| **impulse > 0.0).map(|(contact, _)| contact));
        condense(model, &self.loaded, Redundancy::Drop, &mut self.condensation);
        self.matrix.copy_from_slice(&self.condensation.h);
        self.direction.copy_from_slice(&self.mean);
        for i in 0..n_i {
            if self.matrix[i * n_i + i] <= 0.0 {
                self.matrix[i * n_i + i] = 1.0;
                self.direction[i] = 0.0;
            }
        }
        self.lu.solve(&mut self.matrix, &mut self.direction) && self.direction.iter().all(|d| d.is_finite())
    }
}

/// The smaller s > 0 with `s (m₀ − k s) = energy`; where there is none, that of the largest value.
fn smaller_root(m0: f64, k: f64, energy: f64) -> f64 {
    let discriminant = m0 * m0 - 4.0 * k * energy;
    if discriminant < 0.0 { 0.5 * m0 / k } else { 2.0 * energy / (m0 + discriminant.sqrt()) }
}

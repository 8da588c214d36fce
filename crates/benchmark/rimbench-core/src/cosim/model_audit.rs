//! Where the energy comes from that an interface model creates: the jump from the end of the model to that of the
//! mechanics, by contact.
//!
//! ```text
//! received − sent = jump + first moment + mass + contacts + unfrozen + age
//! jump          T⁺ − T̂ = −½ ΔPᵀ H_uu ΔP + w_u⁺ · ΔP,   ΔP = P − P̂
//! first moment  a_i · (Σ p_j (t_j + ½ h_j) − ∫ t λ dt)
//! mass          ½ pᵀ (H_ii,mech − H_ii,model) p, where what is believed of the mechanics is wrong
//! contacts      what contacts lose in the mechanics beyond what they lose in the model, micro steps included
//! unfrozen      what the mechanics received beyond the frozen model's account of its own steps: rows that turn
//! age           what the model would have been sent had its samples been in time, under the same forces, less what it was sent
//! ```
//! `P̂` follows from where the model's contacts end: `H_uu P̂ = ŵ_u − w_u − H a_u − H_ui p`. Nothing is added to micro
//! steps.
//! # Source
//! `docs/method/no-heavier-than-the-mechanics.md`.

use super::communication_grid::{MacroStep, MicroStep};
use super::coupling_scheme::CouplingScheme;
use super::output_history::OutputHistory;
use crate::interface_model::{Condensation, IndependentRows, ReducedInterfaceModel, condense, smallest_eigenvalue};
use rimbench_contact::friction::{ContactState, StateSystem};
use rimbench_contact::linear_algebra::body_dot;

/// Below this fraction of the largest an impulse counts as zero, and a change of velocity below this fraction of what
/// it is a difference of.
const ROUNDING: f64 = 1e-11;

/// How a contact of an interface model creates energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Creation {
    /// It acted across a gap that the mechanics leaves open.
    Gap,
    /// It pulled while the mechanics opened it.
    Pull,
    /// Its impulse along the surface exceeded the friction of the mechanics, which slid.
    Stick,
    /// The mechanics pushed a penetration out, or rebounded.
    Push,
}

/// A jump that gained energy: at most that much was created there, because the model's own contacts take some of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// The communication point, s.
    pub time: f64,
    /// J.
    pub energy: f64,
    /// The contact that created most of it.
    pub contact: usize,
    /// How that contact did.
    pub by: Creation,
}

/// Energy that an interface model created (above 0) or lost since the start, J, by origin; the sum is minus the
/// interface residual.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ModelEnergy {
    /// Gained as the end of the model was replaced by that of the mechanics: `Σ (T⁺ − T̂)`. What contacts take in the
    /// model is in `contacts`.
    pub jump: f64,
    /// Created by the bias, because the mechanics received the force at other times than it acted.
    pub first_moment: f64,
    /// Created because the model has another mass than the mechanics: what no contact has to do with.
    pub mass: f64,
    /// Created because contacts lose less in the model than in the mechanics.
    pub contacts: f64,
    /// Created because the mechanics' own steps are not those of the frozen model.
    pub unfrozen: f64,
    /// Created because the samples that the model was made of were late.
    pub age: f64,
    /// Largest eigenvalue of `H_mech − H_model` over all macro steps, each with the contacts that carried impulse,
    /// relative to the largest entry of `H_ii`: above 0 the model was heavier than the mechanics in some direction.
    pub heaviness: f64,
    /// The jump that gained most.
    pub largest: Option<Jump>,
}

impl ModelEnergy {
    /// Returns the energy that the model created (above 0) or lost, J: minus the interface residual.
    pub fn created(&self) -> f64 {
        self.jump + self.first_moment + self.contacts + self.unfrozen + self.mass
    }
}

/// Keeps the account of a run; everything is reserved beforehand.
#[derive(Debug, Clone)]
pub(crate) struct ModelAudit {
    energy: ModelEnergy,
    /// Whether every macro step could be audited.
    known: bool,
    /// The mechanics' own model, where another is believed.
    own: Option<Box<ReducedInterfaceModel>>,
    /// Heaviness in the last macro step.
    last: Option<f64>,
    /// Work sent and received up to its start, J.
    counted: [f64; 2],
    /// `p`, `P` and `P̂` of the macro step, N·s.
    impulse: Vec<f64>,
    contacts: Vec<f64>,
    of_model: Vec<f64>,
    /// `a_i · Σ p_j (t_j + ½ h_j)` and `Σ p_jᵀ H_iu (P_before + ½ P_j)` over the mechanics' steps, J.
    moment: f64,
    contact_work: f64,
    rows: IndependentRows,
    right: Vec<f64>,
    closed: Vec<usize>,
    /// The interface of model and mechanics with the contacts that carried impulse.
    condensed: [Condensation; 2],
    difference: Vec<f64>,
    /// What bilateral contacts with friction do.
    states: Vec<ContactState>,
    directions: Vec<[f64; 2]>,
    system: StateSystem,
}

impl ModelAudit {
    /// Reserves models like `empty`, which may be what is `believed` of the mechanics.
    pub(crate) fn new(empty: &ReducedInterfaceModel, believed: bool) -> Self {
        let (rows, n_i) = (empty.interface_start(), empty.interface());
        ModelAudit {
            energy: ModelEnergy { heaviness: f64::NEG_INFINITY, ..ModelEnergy::default() },
            known: empty.delassus_pattern().is_none(),
            own: believed.then(|| Box::new(empty.clone())),
            last: None,
            counted: [0.0; 2],
            impulse: vec![0.0; n_i],
            contacts: vec![0.0; rows],
            of_model: vec![0.0; rows],
            moment: 0.0,
            contact_work: 0.0,
            rows: IndependentRows::new(rows, empty),
            right: vec![0.0; rows],
            closed: Vec::with_capacity(empty.contacts()),
            condensed: [Condensation::of(empty), Condensation::of(empty)],
            difference: vec![0.0; n_i * n_i],
            states: vec![ContactState::Open; empty.friction.len()],
            directions: empty.directions.clone(),
            system: StateSystem::with_tangents(empty.friction.len(), empty.tangents()),
        }
    }

    /// Notes the model of the mechanics before it becomes what is believed of it.
    pub(crate) fn keep_own(&mut self, own: &ReducedInterfaceModel) {
        if let Some(kept) = &mut self.own {
            kept.copy_from(own);
        }
    }

    /// Notes what late samples have created since the start, J.
    pub(crate) fn set_age(&mut self, created: Option<f64>) {
        match created {
            Some(created) => self.energy.age = created,
            None => self.known = false,
        }
    }

    /// Returns the account, if every macro step could be audited.
    pub(crate) fn energy(&self) -> Option<ModelEnergy> {
        (self.known && self.last.is_some()).then_some(self.energy)
    }

    /// Returns what the model has created so far (J), and the heaviness in the last macro step.
    pub(crate) fn so_far(&self) -> Option<[f64; 2]> {
        self.last.filter(|_| self.known).map(|heaviness| [self.energy.created(), heaviness])
    }

    /// Adds a step of the mechanics under the force `lambda` (N) with these contact impulses (N·s).
    pub(crate) fn add_step(
        &mut self,
        model: &ReducedInterfaceModel,
        at: MicroStep,
        lambda: &[f64],
        impulses: Option<&[f64]>,
    ) {
        let model = self.own.as_deref().unwrap_or(model);
        let first = model.interface_start();
        let Some(impulses) = impulses.or((first == 0).then_some(&[])).filter(|own| own.len() == first) else {
            self.known = false;
            return;
        };
        for (i, force) in lambda.iter().enumerate() {
            let p = at.length * force;
            self.moment += p * model.a[first + i] * (at.since_exchange + 0.5 * at.length);
            for (row, (sum, own)) in self.contacts.iter().zip(impulses).enumerate() {
                self.contact_work += p * model.entry(row, first + i) * (sum + 0.5 * own);
            }
        }
        self.contacts.iter_mut().zip(impulses).for_each(|(sum, own)| *sum += own);
    }

    /// Closes a macro step under `forces`, with the work sent and received since the start (J).
    pub(crate) fn finish(
        &mut self,
        model: &ReducedInterfaceModel,
        step: MacroStep,
        forces: &OutputHistory,
        scheme: &mut dyn CouplingScheme,
        work: [Option<f64>; 2],
    ) {
        let first = model.interface_start();
        let (Some(end), [Some(sent), Some(received)], true) = (scheme.model_end(), work, self.known) else {
            self.known = false;
            return;
        };
        // ∫ λ dt, a · ∫ t λ dt
        let count = forces.rows().len() as f64;
        let (delta, mut sent_moment) = (step.length / count, 0.0);
        for (i, (impulse, a)) in self.impulse.iter_mut().zip(&model.a[first..]).enumerate() {
            // The force of micro step j is in n − j + 1 of the sums.
            let [sum, sums] = forces.running_sums(i);
            *impulse = delta * sum;
            sent_moment += delta * delta * a * ((count + 0.5) * sum - sums);
        }
        let own = self.own.as_deref().unwrap_or(model);
        let by_impulse = |of: &ReducedInterfaceModel, row: usize| body_dot(&of.row(row)[first..], &self.impulse);
        let [smooth, own_smooth] = [model, own].map(|of| {
            let moved = self.impulse.iter().enumerate();
            moved.fold(0.0, |sum, (i, p)| sum + p * (of.w[first + i] + 0.5 * by_impulse(of, first + i)))
        });
        let in_model = (sent - self.counted[0]) - smooth - sent_moment;
        let unfrozen = (received - self.counted[1]) - own_smooth - self.moment - self.contact_work;

        // P̂
        let free_of =
            |of: &ReducedInterfaceModel, row: usize| of.w[row] + step.length * of.a[row] + by_impulse(of, row);
        let free = |row: usize| free_of(model, row);
        let mut pushed = false;
        for (&row, w) in end.rows.iter().zip(end.w) {
            let free = free(row);
            self.right[row] = w - free;
            pushed |= (w - free).abs() > ROUNDING * (w.abs() + free.abs());
        }
        self.of_model.fill(0.0);
        if let Some(modes) = end.bilateral_modes {
            modes.close(&model.w, end.rows, &mut self.states, &mut self.directions);
            self.system.factorise_along(modes.friction, &self.states, &self.directions, |row| model.row(row));
            self.right.iter_mut().enumerate().for_each(|(row, right)| *right = free(row));
            end.rows.iter().zip(end.w).for_each(|(&row, w)| self.right[row] -= w);
            self.system.impulses(&self.right, &mut self.of_model);
        } else if pushed {
            let (kept, impulses) = self.rows.solve(model, end.rows, |row| self.right[row]);
            kept.iter().zip(impulses).for_each(|(&row, &impulse)| self.of_model[row] = impulse);
        }
        let all = self.of_model.iter().chain(&self.contacts).chain(&self.impulse);
        let least = ROUNDING * all.fold(0.0, |most: f64, impulse| most.max(impulse.abs()));
        self.of_model.iter_mut().filter(|impulse| impulse.abs() <= least).for_each(|impulse| *impulse = 0.0);

        let (mut jump, mut size, mut largest) = (0.0, 0.0, (0.0, 0, Creation::Pull));
        for row in 0..first {
            let (p, of_model) = (self.contacts[row], self.of_model[row]);
            if p == 0.0 && of_model == 0.0 {
                continue;
            }
            let of_contacts = &own.row(row)[..first];
            let by_contacts = body_dot(of_contacts, &self.contacts);
            let (w, change) = (free_of(own, row) + by_contacts, by_contacts - body_dot(of_contacts, &self.of_model));
            jump += (p - of_model) * (w - 0.5 * change);
            size += (w.abs() + change.abs()) * (p.abs() + of_model.abs());
            let mut note = |created: f64, contact: usize, by: Creation| {
                if created > largest.0 {
                    largest = (created, contact, by);
                }
            };
            match row.checked_sub(model.contacts()) {
                Some(row) => note(w * (p - of_model), row % model.contacts(), Creation::Stick),
                None => {
                    // 0 ≤ w + d ⟂ P ≥ 0
                    let d = if p > 0.0 { -w } else { own.step_gap_velocity(row) };
                    note(d * (of_model - p), row, if d > 0.0 { Creation::Gap } else { Creation::Push });
                    note(-(w + d) * of_model, row, Creation::Pull);
                }
            }
        }
        let (_, contact, by) = largest;
        if jump > ROUNDING * size && self.energy.largest.is_none_or(|most| jump > most.energy) {
            self.energy.largest = Some(Jump { time: step.start + step.length, energy: jump, contact, by });
        }
        let heaviness = self.heaviness(model);
        self.energy.jump += jump;
        self.energy.first_moment += self.moment - sent_moment;
        self.energy.mass += own_smooth - smooth;
        self.energy.contacts += self.contact_work - in_model - jump;
        self.energy.unfrozen += unfrozen;
        self.energy.heaviness = self.energy.heaviness.max(heaviness);
        (self.last, self.counted) = (Some(heaviness), [sent, received]);
        (self.moment, self.contact_work) = (0.0, 0.0);
        self.contacts.fill(0.0);
    }

    /// Returns how much heavier the model is with the contacts that carried impulse; nothing to find where those of the
    /// mechanics are these.
    fn heaviness(&mut self, model: &ReducedInterfaceModel) -> f64 {
        let (first, n_i) = (model.interface_start(), model.interface());
        let closed = |impulses: &[f64], contact: usize| impulses[contact] != 0.0;
        let own = self.own.as_deref().unwrap_or(model);
        if self.own.is_none()
            && (0..model.contacts()).all(|contact| closed(&self.of_model, contact) == closed(&self.contacts, contact))
        {
            return 0.0;
        }
        let both = [(&self.of_model, model), (&self.contacts, own)];
        for ((impulses, of), condensed) in both.into_iter().zip(&mut self.condensed) {
            self.closed.clear();
            self.closed.extend((0..model.contacts()).filter(|&contact| closed(impulses, contact)));
            condense(of, &self.closed, condensed);
        }
        let [of_model, of_own] = &self.condensed;
        let difference = &mut self.difference[..];
        difference.iter_mut().zip(of_model.h.iter().zip(&of_own.h)).for_each(|(d, (model, own))| *d = model - own);
        let largest = (0..n_i).map(|i| own.entry(first + i, first + i)).fold(0.0, f64::max);
        -smallest_eigenvalue(difference, n_i) / largest
    }
}

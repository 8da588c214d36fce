//! The non-smooth stepper: one step of Eq. 1–3 through the reduced model of Eq. 4, offered as a subsystem.

use super::energy_ledger::EnergyLedger;
use super::mechanical_model::MechanicalModel;
use crate::complementarity::{Checked, ComplementaritySolver, Lcp};
use crate::cosim::{EnergyAccount, Ports, Subsystem, SubsystemCounters};
use crate::error::Failure;
use crate::interface_model::{
    Condensation, Elimination, Linearisation, ReducedInterfaceModel, Redundancy, Rows, condense, dot, gap_velocity,
};

/// How contacts behave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLaw {
    /// Fraction γ ∈ [0, 1] of a penetration (or joint error) removed per step.
    pub stabilisation: f64,
    /// Restitution e ∈ [0, 1] of a contact that closes within the step: `w⁺ + e w⁻ ≥ 0`.
    pub restitution: f64,
    /// A contact with `g ≤ contact_margin` counts as closed at a communication point, m.
    pub contact_margin: f64,
}

/// Steps a mechanical model with contacts.
///
/// ```text
/// b_u = w_u + h a_u + H_ui h λ_i + gap term        0 ≤ H_uu P_u + b_u ⟂ P_u ≥ 0
/// v⁺  = v̂ + h α + G A_uᵀ P_u + G A_iᵀ h λ_i        q⁺ = q + h v⁺
/// ```
/// The reduction at `t_k` is made once and serves both the interface model and the step that follows.
/// # Source
/// Raoofian, Kövecses, Teichmann, Eqs. 1–4, with `M̂ = M`, `ĉ = c` (semi-implicit); gap law ours.
#[derive(Clone)]
pub struct NonSmoothMechanics<M> {
    model: M,
    law: ContactLaw,
    ports: Ports,
    observables: Vec<&'static str>,
    q: Vec<f64>,
    v: Vec<f64>,
    v_next: Vec<f64>,
    /// `½ (v⁺ + v⁻)` and `v⁺ − v⁻` of the last step.
    v_mean: Vec<f64>,
    v_change: Vec<f64>,
    eq3: Linearisation,
    elimination: Elimination,
    eq4: ReducedInterfaceModel,
    /// Step for which `eq4` belongs to the present state; NaN when it does not.
    reduced_for: f64,
    solver: Checked,
    h_uu: Vec<f64>,
    b_u: Vec<f64>,
    /// `[P_u; h λ_i]`.
    impulses: Vec<f64>,
    p_b: Vec<f64>,
    last_step: f64,
    closed: Vec<usize>,
    condensation: Condensation,
    ledger: EnergyLedger,
    /// `T` and `V` at the start, J.
    start_energy: [f64; 2],
    counters: SubsystemCounters,
}

impl<M: MechanicalModel> NonSmoothMechanics<M> {
    /// Places `model` at its start state. `ports` must name `n_i` forces in, `n_i` positions and `n_i` velocities out.
    pub fn new(mut model: M, law: ContactLaw, ports: Ports, solver: Checked) -> Self {
        let size = model.size();
        debug_assert_eq!(ports.inputs.len(), size.interface);
        debug_assert_eq!(ports.outputs.len(), 2 * size.interface);
        let (q, v) = model.initial_state();
        model.prepare(&q, &v);
        let eq3 = Linearisation {
            mass: model.empty_mass_matrix(),
            force: vec![0.0; size.velocities],
            bilateral: Rows::zeros(size.bilateral, size.velocities),
            unilateral: Rows::zeros(size.unilateral, size.velocities),
            interface: Rows::zeros(size.interface, size.velocities),
        };
        let observables =
            [model.observables(), model.gap_names(), model.contact_force_names(), &CONTACT_OBSERVABLES].concat();
        let mut mechanics = NonSmoothMechanics {
            observables,
            law,
            ports,
            v_next: v.clone(),
            v_mean: v.clone(),
            v_change: vec![0.0; size.velocities],
            elimination: Elimination::new(&eq3),
            eq4: ReducedInterfaceModel::zeros(size.unilateral, size.interface),
            reduced_for: f64::NAN,
            solver,
            h_uu: vec![0.0; size.unilateral * size.unilateral],
            b_u: vec![0.0; size.unilateral],
            impulses: vec![0.0; size.unilateral + size.interface],
            p_b: vec![0.0; size.bilateral],
            last_step: f64::INFINITY,
            closed: Vec::with_capacity(size.unilateral),
            condensation: Condensation::new(size.unilateral, size.interface),
            ledger: EnergyLedger::default(),
            start_energy: [0.0; 2],
            counters: SubsystemCounters::default(),
            model,
            q,
            v,
            eq3,
        };
        mechanics.linearise();
        mechanics.start_energy = [mechanics.kinetic_energy(), mechanics.model.potential_energy(&mechanics.q)];
        mechanics
    }

    /// Positions.
    pub fn position(&self) -> &[f64] {
        &self.q
    }

    /// Velocities.
    pub fn velocity(&self) -> &[f64] {
        &self.v
    }

    /// Eq. 3 at the present state.
    pub fn linearisation(&self) -> &Linearisation {
        &self.eq3
    }

    /// The energy account.
    pub fn ledger(&self) -> &EnergyLedger {
        &self.ledger
    }

    /// Kinetic plus potential energy, J.
    pub fn energy(&self) -> f64 {
        self.kinetic_energy() + self.model.potential_energy(&self.q)
    }

    fn kinetic_energy(&self) -> f64 {
        0.5 * self.eq3.mass.product(&self.v, &self.v)
    }

    /// Contact impulses of the last step, N·s. Not unique where contacts are redundant.
    pub fn contact_impulses(&self) -> &[f64] {
        &self.impulses[..self.eq3.unilateral.len()]
    }

    fn linearise(&mut self) {
        self.model.prepare(&self.q, &self.v);
        self.model.mass_matrix(&self.q, &mut self.eq3.mass);
        self.model.forces(&self.q, &self.v, &mut self.eq3.force);
        self.model.bilateral(&self.q, &self.v, &mut self.eq3.bilateral);
        self.model.unilateral(&self.q, &self.v, &mut self.eq3.unilateral);
        self.model.interface(&self.q, &self.v, &mut self.eq3.interface);
        self.reduced_for = f64::NAN;
    }

    /// Makes Eq. 4 at the present state for a step `h`, unless it is there already.
    fn reduce(&mut self, h: f64) -> Result<(), Failure> {
        if self.reduced_for == h {
            return Ok(());
        }
        self.elimination.reduce(&self.eq3, &self.v, h, self.law.stabilisation, &mut self.eq4)?;
        self.eq4.contact_margin = self.law.contact_margin;
        self.eq4.restitution = self.law.restitution;
        self.counters.eliminations += 1;
        self.reduced_for = h;
        Ok(())
    }

    /// Solves the contacts of one step; `impulses` then holds `[P_u; h λ_i]`.
    fn solve_contacts(&mut self, lambda: &[f64], h: f64) -> Result<(), Failure> {
        let (n_u, n) = (self.eq4.contacts(), self.impulses.len());
        for (impulse, force) in self.impulses[n_u..].iter_mut().zip(lambda) {
            *impulse = h * force;
        }
        for contact in 0..n_u {
            let (h_uu, h_ui) = self.eq4.h[contact * n..(contact + 1) * n].split_at(n_u);
            let free = self.eq4.w[contact] + h * self.eq4.a[contact];
            self.b_u[contact] = free + dot(h_ui, &self.impulses[n_u..]) + self.contact_term(contact, h);
            for (out, h) in self.h_uu[contact * n_u..(contact + 1) * n_u].iter_mut().zip(h_uu) {
                *out = *h;
            }
        }
        let lcp = Lcp { m: &self.h_uu, q: &self.b_u };
        self.solver.solve(lcp, &mut self.impulses[..n_u]).map(|_| ())
    }

    /// Gap law, or impact law for a bouncing contact that closes within the step.
    fn contact_term(&self, contact: usize, h: f64) -> f64 {
        let (gap, w) = (self.eq4.gap[contact], self.eq4.w[contact]);
        let closes = w < 0.0 && gap + h * w <= 0.0;
        if self.law.restitution > 0.0 && closes {
            return self.law.restitution * w;
        }
        gap_velocity(gap, h, h, self.law.stabilisation)
    }

    /// Books the work of one step. Impulses are paired with `v̄ = ½ (v⁺ + v⁻)`, and `T⁺ − T⁻ = v̄ᵀ M (v⁺ − v⁻)`.
    fn book_energy(&mut self, h: f64) {
        for ((mean, change), (v, v_next)) in
            self.v_mean.iter_mut().zip(&mut self.v_change).zip(self.v.iter().zip(&self.v_next))
        {
            *mean = 0.5 * (v + v_next);
            *change = v_next - v;
        }
        // Most contacts are open: no impulse, no work.
        let work = |rows: &Rows, impulses: &[f64]| -> f64 {
            let acting = impulses.iter().enumerate().filter(|(_, impulse)| **impulse != 0.0);
            acting.map(|(index, impulse)| rows.velocity(index, &self.v_mean) * impulse).sum()
        };
        let (contact, interface) = self.impulses.split_at(self.eq4.contacts());
        self.ledger.book(EnergyLedger {
            applied: h * dot(&self.eq3.force, &self.v_mean),
            bilateral: work(&self.eq3.bilateral, &self.p_b),
            contact: work(&self.eq3.unilateral, contact),
            interface: work(&self.eq3.interface, interface),
            kinetic: self.eq3.mass.product(&self.v_mean, &self.v_change),
            ..EnergyLedger::default()
        });
    }
}

/// Observables that every model with contacts has.
///
/// `effective_mass_kg` is that of the closed contacts; `active_effective_mass_kg` that of the contacts that carried impulse
/// in the last step. The sum of contact forces is also there for contacts that have no name of their own.
const CONTACT_OBSERVABLES: [&str; 5] =
    ["closed_contacts", "rank_h_uu", "effective_mass_kg", "active_effective_mass_kg", "contact_force_sum_n"];

impl<M: MechanicalModel + Clone + 'static> Subsystem for NonSmoothMechanics<M> {
    fn ports(&self) -> &Ports {
        &self.ports
    }

    fn outputs(&self, _u: &[f64], y: &mut [f64]) {
        let n_i = self.eq3.interface.len();
        y[..n_i].copy_from_slice(&self.eq3.interface.position);
        for (index, velocity) in y[n_i..].iter_mut().enumerate() {
            *velocity = self.eq3.interface.velocity(index, &self.v);
        }
    }

    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.reduce(h)?;
        self.solve_contacts(u, h)?;
        self.elimination.velocity_after(h, &self.impulses, &mut self.v_next);
        self.elimination.bilateral_impulses(h, &self.impulses, &mut self.p_b);
        self.book_energy(h);
        std::mem::swap(&mut self.v, &mut self.v_next);
        for (q, v) in self.q.iter_mut().zip(&self.v) {
            *q += h * v;
        }
        self.last_step = h;
        self.counters.micro_steps += 1;
        // A velocity that is not finite has reached the position by now.
        if !self.q.iter().all(|x| x.is_finite()) {
            return Err(Failure::NonFinite { quantity: "mechanical state" });
        }
        let kinetic = self.kinetic_energy();
        self.linearise();
        self.ledger.inertia += self.kinetic_energy() - kinetic;
        Ok(())
    }

    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        self.reduce(h)?;
        model.copy_from(&self.eq4);
        Ok(true)
    }

    fn empty_interface_model(&self) -> Option<ReducedInterfaceModel> {
        Some(ReducedInterfaceModel::zeros(self.eq4.contacts(), self.eq4.interface()))
    }

    fn observables(&self) -> &[&'static str] {
        &self.observables
    }

    fn observe(&mut self, h: f64, row: &mut [f64]) {
        let n_u = self.eq3.unilateral.len();
        let (own, row) = row.split_at_mut(self.model.observables().len());
        let (gaps, row) = row.split_at_mut(self.model.gap_names().len());
        let (forces, contact) = row.split_at_mut(self.model.contact_force_names().len());
        self.model.observe(&self.q, &self.v, own);
        gaps.copy_from_slice(&self.eq3.unilateral.position[..gaps.len()]);
        for (force, impulse) in forces.iter_mut().zip(&self.impulses[..n_u]) {
            *force = impulse / self.last_step;
        }
        contact.fill(f64::NAN);
        contact[4] = self.impulses[..n_u].iter().sum::<f64>() / self.last_step;
        if self.reduce(h).is_ok() {
            self.eq4.closed_contacts(&mut self.closed);
            condense(&self.eq4, &self.closed, Redundancy::Drop, &mut self.condensation);
            contact[0] = self.closed.len() as f64;
            contact[1] = self.condensation.rank as f64;
            contact[2] = self.condensation.effective_mass;
            contact[3] = contact[2];
            if self.last_step.is_finite() {
                self.closed.clear();
                self.closed.extend((0..n_u).filter(|&contact| self.impulses[contact] > 0.0));
                condense(&self.eq4, &self.closed, Redundancy::Drop, &mut self.condensation);
                contact[3] = self.condensation.effective_mass;
            }
        }
    }

    fn interface_work(&self) -> Option<f64> {
        Some(self.ledger.interface)
    }

    fn energy_identity_residual(&self) -> Option<f64> {
        Some(self.ledger.identity_residual)
    }

    fn energy_account(&self) -> Option<EnergyAccount> {
        let [kinetic, potential] = self.start_energy;
        let potential_change = self.model.potential_energy(&self.q) - potential;
        Some(self.ledger.account(self.kinetic_energy() - kinetic + potential_change, potential_change))
    }

    fn try_clone(&self) -> Option<Box<dyn Subsystem>> {
        Some(Box::new(self.clone()))
    }

    fn counters(&self) -> SubsystemCounters {
        SubsystemCounters { solver: self.solver.counters(), ..self.counters }
    }
}

//! One step of Eq. 1–3 through the reduced model of Eq. 4, once Eq. 3 is at hand: what does not depend on the mechanical model.

mod frictional_step;
mod implicit_step;
mod middle_step;

use frictional_step::FrictionalContacts;
pub(super) use frictional_step::friction_observables;
pub use frictional_step::{CONTACT_STATE, Friction};
pub(super) use implicit_step::ImplicitPart;
pub(super) use middle_step::{ContactSet, MiddleStep};

use super::energy_ledger::EnergyLedger;
use super::mechanical_model::ModelSize;
use crate::complementarity::{Checked, ComplementaritySolver, Lcp, SparseActiveSet};
use crate::cosim::{EnergyAccount, SubsystemCounters};
use crate::error::Failure;
use crate::friction::FrictionProblem;
use crate::interface_model::{
    Condensation, ContactSpring, Elimination, GapRates, ImpactRows, ImpactStep, Linearisation, Rebounds,
    ReducedInterfaceModel, Redundancy, Rows, Solved, TOUCHING, condense, gap_velocity, own_approach, resting_approach,
};
use crate::linear_algebra::body_dot;

/// How contacts behave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLaw {
    /// Fraction γ ∈ [0, 1] of a penetration (or joint error) removed per step.
    pub stabilisation: f64,
    /// Restitution e ∈ [0, 1] of a contact that is hit and whose rebound lasts: `w⁺ + e w⁻ ≥ 0`, see [`Rebounds`].
    pub restitution: f64,
    /// Spring and damper of contacts that give way; none for rigid ones. With a spring, γ acts on joints only, and nothing rebounds but
    /// what the spring throws back.
    pub spring: Option<ContactSpring>,
}

impl ContactLaw {
    /// Whether contacts rebound.
    fn bounces(&self) -> bool {
        self.restitution > 0.0 && self.spring.is_none()
    }

    /// Says to a model how its contacts behave.
    fn give_to(&self, model: &mut ReducedInterfaceModel) {
        model.restitution = self.restitution;
        model.spring = self.spring;
        if self.bounces() {
            model.own_approach = vec![0.0; model.contacts()];
        }
    }
}

/// Contacts from which on only what is not zero is kept, where few of them meet (`benches/scaling.rs`).
pub const MANY_CONTACTS: usize = 48;

/// State, Eq. 3 and Eq. 4 of a mechanical system, and its contact solver.
#[derive(Clone)]
pub(super) struct ContactStepper {
    law: ContactLaw,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    v_next: Vec<f64>,
    /// The velocity at the end of a step as its position has it, where the course of the force is known or a contact rebounds.
    pub(super) v_reached: Vec<f64>,
    /// `½ (v⁺ + v⁻)` and `v⁺ − v⁻` of the last step.
    v_mean: Vec<f64>,
    v_change: Vec<f64>,
    pub(super) eq3: Linearisation,
    elimination: Elimination,
    /// Where steps of the second order take stiff forces implicitly.
    pub(super) implicit: Option<Box<ImplicitPart>>,
    pub(super) eq4: ReducedInterfaceModel,
    /// Step for which `eq4` belongs to the present state, if it does.
    reduced_for: Option<f64>,
    solver: Checked,
    /// In its place, where contacts have friction.
    friction: Option<Box<FrictionalContacts>>,
    /// In its place, where few of many contacts meet.
    sparse: Option<SparseActiveSet>,
    h_uu: Vec<f64>,
    b_u: Vec<f64>,
    /// `w⁺` plus gap terms of the last step; whether `eq4.at_bound` has been found from it.
    slack: Vec<f64>,
    closed_known: bool,
    /// Contacts that rebounded in the last step. Empty where nothing bounces.
    rebounds: Rebounds,
    /// Velocities of the contacts' rows without contact forces, where they bounce, and for what their problem is solved.
    free: Vec<f64>,
    solved: Solved,
    /// Approach that the step to come and the last two make of each contact by themselves, m/s. Empty where nothing bounces.
    own_approach: [Vec<f64>; 3],
    /// Contacts that touched in the last step and in the one before: at their bound, or rebounding. Empty where nothing bounces.
    touched: [Vec<bool>; 2],
    /// `[P_u; h λ_i]`; with friction `[P_u; P_t; h λ_i]`.
    impulses: Vec<f64>,
    p_b: Vec<f64>,
    /// Length of the last step, s; infinite before the first, so that forces then are zero.
    last_step: f64,
    closed: Vec<usize>,
    condensation: Condensation,
    pub(super) ledger: EnergyLedger,
    /// What the dampers of compliant contacts have taken, J.
    damper_loss: f64,
    counters: SubsystemCounters,
}

impl ContactStepper {
    /// Makes room for a system of this size, with room for Eq. 3 at hand, at its start state.
    pub(super) fn new(
        size: ModelSize,
        eq3: Linearisation,
        (q, v): (Vec<f64>, Vec<f64>),
        law: ContactLaw,
        solver: Checked,
    ) -> Self {
        let meeting = Elimination::meeting(&eq3);
        let elimination = Elimination::with_meeting(&eq3, meeting.as_deref());
        let sparse = meeting.as_deref().map(|meeting| SparseActiveSet::new(meeting, solver.tolerance()));
        let mut eq4 = match meeting {
            Some(meeting) => ReducedInterfaceModel::zeros_of(meeting, size.interface),
            None => ReducedInterfaceModel::zeros(size.unilateral, size.interface),
        };
        law.give_to(&mut eq4);
        let dense = if sparse.is_some() { 0 } else { size.unilateral };
        let mut stepper = ContactStepper {
            law,
            v_next: v.clone(),
            v_reached: v.clone(),
            v_mean: v.clone(),
            v_change: vec![0.0; size.velocities],
            elimination,
            implicit: None,
            condensation: Condensation::of(&eq4),
            eq4,
            reduced_for: None,
            // A solver that is not asked keeps no room.
            solver: if sparse.is_some() { solver.without_room() } else { solver },
            sparse,
            friction: None,
            h_uu: vec![0.0; dense * dense],
            b_u: vec![0.0; size.unilateral],
            slack: vec![0.0; size.unilateral],
            closed_known: false,
            rebounds: Rebounds::default(),
            free: Vec::new(),
            solved: Solved::Velocity,
            own_approach: [(); 3].map(|()| if law.bounces() { vec![0.0; size.unilateral] } else { Vec::new() }),
            touched: [(); 2].map(|()| if law.bounces() { vec![false; size.unilateral] } else { Vec::new() }),
            impulses: vec![0.0; size.unilateral + size.interface],
            p_b: vec![0.0; size.bilateral],
            last_step: f64::INFINITY,
            closed: Vec::with_capacity(size.unilateral),
            ledger: EnergyLedger::default(),
            damper_loss: 0.0,
            counters: SubsystemCounters::default(),
            q,
            v,
            eq3,
        };
        stepper.make_room_for_rebounds();
        stepper
    }

    /// Makes room for the rows that contacts have by now.
    fn make_room_for_rebounds(&mut self) {
        if self.law.bounces() {
            let (contacts, rows) = (self.eq4.contacts(), self.eq4.interface_start());
            self.rebounds = Rebounds::new(contacts, rows);
            self.free = vec![0.0; rows];
        }
    }

    /// Goes over to rows that stand for other contacts, after a step; `columns` are those of the velocities that they can know. A contact that
    /// was closed or hit in the step must have kept its row.
    ///
    /// # Errors
    /// If they now meet so often that entries which are zero for good are few.
    pub(super) fn relist(&mut self, columns: Option<&[Vec<usize>]>) -> Result<(), Failure> {
        // It follows from the problem of the rows as they were.
        self.find_closed();
        let (rows, velocities) = (self.eq3.unilateral.len(), self.eq3.velocities());
        match columns.filter(|_| self.sparse.is_some()) {
            Some(columns) => self.eq3.unilateral = Rows::in_columns(velocities, columns),
            // What a row no longer knows must be zero.
            None => self.eq3.unilateral = Rows::zeros(rows, velocities),
        }
        let meeting = Elimination::meeting(&self.eq3);
        self.elimination = Elimination::with_meeting(&self.eq3, meeting.as_deref());
        if let Some(solver) = &mut self.sparse {
            let few = "contacts that are listed anew meet so often that there is no room for them";
            let meeting = meeting.ok_or_else(|| Failure::reported(few))?;
            solver.change_pattern(&meeting);
            self.eq4.set_meeting(meeting);
        }
        self.eq4.note_listing();
        self.forget_reduction();
        Ok(())
    }

    /// An interface model of this system's size and law, with nothing in it yet.
    pub(super) fn empty_model(&self) -> ReducedInterfaceModel {
        let mut model = match (self.eq4.meeting(), &self.friction) {
            (Some(meeting), _) => ReducedInterfaceModel::zeros_of(meeting.clone(), self.eq4.interface()),
            (None, Some(friction)) => friction.empty_model(self.eq4.interface()),
            (None, None) => ReducedInterfaceModel::zeros(self.eq4.contacts(), self.eq4.interface()),
        };
        self.law.give_to(&mut model);
        model
    }

    pub(super) fn kinetic_energy(&self) -> f64 {
        0.5 * self.eq3.mass.product(&self.v, &self.v)
    }

    /// Contact impulses of the last step, N·s. Not unique where contacts are redundant.
    pub(super) fn contact_impulses(&self) -> &[f64] {
        &self.impulses[..self.eq3.unilateral.len()]
    }

    pub(super) fn counters(&self) -> SubsystemCounters {
        let solver = match (&self.friction, &self.sparse) {
            (Some(friction), _) => friction.counters(),
            (None, Some(sparse)) => sparse.counters(),
            (None, None) => self.solver.counters(),
        };
        SubsystemCounters { solver, ..self.counters }
    }

    /// Position and velocity of the interface rows.
    pub(super) fn interface_motion(&self, y: &mut [f64]) {
        let n_i = self.eq3.interface.len();
        y[..n_i].copy_from_slice(&self.eq3.interface.position);
        for (index, velocity) in y[n_i..].iter_mut().enumerate() {
            *velocity = self.eq3.interface.velocity(index, &self.v);
        }
    }

    /// Fraction γ of a penetration or joint error removed per step.
    pub(super) fn stabilisation(&self) -> f64 {
        self.law.stabilisation
    }

    /// Whether contacts give way.
    pub(super) fn is_compliant(&self) -> bool {
        self.law.spring.is_some()
    }

    /// Whether only what is not zero is kept of the contacts.
    pub(super) fn is_sparse(&self) -> bool {
        self.sparse.is_some()
    }

    /// Acceleration of a contact without contact forces, as of the last reduction, m/s².
    pub(super) fn free_acceleration(&self, contact: usize, lambda: &[f64]) -> f64 {
        let (n_u, n) = (self.eq4.contacts(), self.impulses.len());
        self.eq4.a[contact] + body_dot(&self.eq4.h[contact * n + n_u..(contact + 1) * n], lambda)
    }

    /// Says which contacts were at their bound in the last step, where the step itself has found out.
    pub(super) fn set_closed(&mut self, closed: &[bool]) {
        self.eq4.at_bound.copy_from_slice(closed);
        self.closed_known = true;
    }

    /// Counts a step that was split at an event.
    pub(super) fn note_split(&mut self) {
        self.counters.splits += 1;
    }

    /// Counts a step with so many events that its rest is taken with the gap law.
    pub(super) fn note_split_fallback(&mut self) {
        self.counters.split_fallbacks += 1;
    }

    /// Says that Eq. 3 is that of a new state.
    pub(super) fn forget_reduction(&mut self) {
        self.reduced_for = None;
    }

    /// Makes Eq. 4 at the present state for a step `h`, unless it is there already.
    pub(super) fn reduce(&mut self, h: f64) -> Result<(), Failure> {
        if self.reduced_for == Some(h) {
            return Ok(());
        }
        self.elimination.reduce(&self.eq3, &self.v, h, self.law.stabilisation, &mut self.eq4)?;
        self.counters.eliminations += 1;
        self.reduced_for = Some(h);
        if self.law.bounces() {
            self.note_own_approach(h);
        }
        Ok(())
    }

    /// Writes the interface model at the present state for a step `h`.
    pub(super) fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<(), Failure> {
        self.reduce_for_model(h)?;
        self.find_closed();
        model.copy_from(&self.eq4);
        Ok(())
    }

    /// Finds the contacts whose row was at its bound in the last step, loaded or not.
    ///
    /// ```text
    /// H_α· P + b_α ≤ τ ‖b‖_∞        τ the tolerance of the solver
    /// ```
    /// `w⁺` is unique where impulses are not, so that it does not matter which of several redundant contacts the solver loads. A
    /// contact that rebounded is on its way out. Before the first step: gaps up to [`TOUCHING`].
    fn find_closed(&mut self) {
        if std::mem::replace(&mut self.closed_known, true) {
            return;
        }
        if self.friction.is_some() {
            return self.find_states();
        }
        if self.last_step.is_infinite() {
            for (closed, gap) in self.eq4.at_bound.iter_mut().zip(&self.eq3.unilateral.position) {
                *closed = *gap <= TOUCHING;
            }
            return;
        }
        let n = self.b_u.len();
        let mut scale = 0.0;
        for (slack, &b) in self.slack.iter_mut().zip(&self.b_u) {
            *slack = b;
            scale = if b.abs() > scale { b.abs() } else { scale };
        }
        if let Some(solver) = &self.sparse {
            self.slack.copy_from_slice(solver.velocities());
        }
        // Few contacts carry impulse, and the matrix is symmetric: its rows are its columns.
        for (contact, &impulse) in self.impulses[..n].iter().enumerate() {
            if impulse != 0.0 && self.sparse.is_none() {
                let column = &self.h_uu[contact * n..(contact + 1) * n];
                for (slack, h) in self.slack.iter_mut().zip(column) {
                    *slack += h * impulse;
                }
            }
        }
        let bound = self.solver.tolerance() * scale;
        for (closed, slack) in self.eq4.at_bound.iter_mut().zip(&self.slack) {
            *closed = *slack <= bound;
        }
        if self.rebounds.any() {
            for (contact, closed) in self.eq4.at_bound.iter_mut().enumerate() {
                *closed &= !self.rebounds.rebounds(contact);
            }
        }
    }

    /// Advances velocities and positions by one step; Eq. 3 stays that of the state before.
    pub(super) fn advance(&mut self, lambda: &[f64], h: f64) -> Result<(), Failure> {
        self.reduce(h)?;
        self.solve_contacts(lambda, h)?;
        self.elimination.velocity_after(h, &self.impulses, &mut self.v_next);
        self.elimination.bilateral_impulses(h, &self.impulses, &mut self.p_b);
        self.book_energy(h);
        std::mem::swap(&mut self.v, &mut self.v_next);
        let reached = if self.rebounds.any() { &self.v_reached } else { &self.v };
        for (q, v) in self.q.iter_mut().zip(reached) {
            *q += h * v;
        }
        self.last_step = h;
        self.closed_known = false;
        self.counters.micro_steps += 1;
        if self.law.bounces() {
            self.own_approach.rotate_right(1);
            self.touched.rotate_right(1);
        }
        // A velocity that is not finite has reached the position by now.
        if !self.q.iter().all(|x| x.is_finite()) {
            return Err(Failure::non_finite("mechanical state"));
        }
        Ok(())
    }

    /// Solves the contacts of one step; `impulses` then holds `[P_u; h λ_i]`.
    fn solve_contacts(&mut self, lambda: &[f64], h: f64) -> Result<(), Failure> {
        for (impulse, force) in self.impulses[self.eq4.interface_start()..].iter_mut().zip(lambda) {
            *impulse = h * force;
        }
        if self.law.bounces() {
            self.find_rebounds(h)?;
        }
        if self.rebounds.any() {
            self.solved = Solved::Way;
            self.solve_problem(h)?;
            self.elimination.velocity_after(h, &self.impulses, &mut self.v_reached);
            self.solved = Solved::Velocity;
        }
        self.solve_problem(h)
    }

    /// Solves the contacts for what is asked.
    fn solve_problem(&mut self, h: f64) -> Result<(), Failure> {
        let (n_u, n) = (self.eq4.contacts(), self.impulses.len());
        if self.sparse.is_some() {
            return self.solve_sparse(h);
        }
        if self.friction.is_some() {
            return self.solve_frictional(h);
        }
        for contact in 0..n_u {
            let (h_uu, h_ui) = self.eq4.h[contact * n..(contact + 1) * n].split_at(n_u);
            let free = self.eq4.w[contact] + h * self.eq4.a[contact];
            self.b_u[contact] = free + body_dot(h_ui, &self.impulses[n_u..]) + self.contact_term(contact, h);
            for (out, h) in self.h_uu[contact * n_u..(contact + 1) * n_u].iter_mut().zip(h_uu) {
                *out = *h;
            }
        }
        if let Some(spring) = self.law.spring {
            return self.solve_compliant(spring, h);
        }
        let lcp = Lcp::new(&self.h_uu, &self.b_u);
        self.solver.solve(lcp, &mut self.impulses[..n_u])?;
        Ok(())
    }

    /// The same where few of many contacts meet.
    fn solve_sparse(&mut self, h: f64) -> Result<(), Failure> {
        let n_u = self.eq4.contacts();
        for contact in 0..n_u {
            self.b_u[contact] = self.eq4.w[contact] + h * self.eq4.a[contact] + self.contact_term(contact, h);
        }
        let (impulses, forces) = self.impulses.split_at_mut(n_u);
        for (i, &force) in forces.iter().enumerate() {
            if let Some(column) = self.eq4.interface_column(i) {
                self.b_u.iter_mut().zip(column).for_each(|(b, h)| *b += h * force);
            }
        }
        if let (Some(solver), Some(rows)) = (&mut self.sparse, self.eq4.contact_rows()) {
            solver.forget_matrix();
            solver.solve(rows, &self.b_u, impulses)?;
        }
        Ok(())
    }

    /// The same with contacts that give way.
    #[cold]
    fn solve_compliant(&mut self, spring: ContactSpring, h: f64) -> Result<(), Failure> {
        self.give_way(spring, h);
        let lcp = Lcp::new(&self.h_uu, &self.b_u);
        self.solver.solve(lcp, &mut self.impulses[..self.b_u.len()])?;
        self.book_dampers(spring, h);
        Ok(())
    }

    /// Puts the law of spring and damper in the place of the rigid one.
    fn give_way(&mut self, spring: ContactSpring, h: f64) {
        let (n, rates) = (self.b_u.len(), spring.gap_rates(h));
        for contact in 0..n {
            self.b_u[contact] += rates.velocity(self.eq4.gap[contact]) - self.contact_term(contact, h);
            self.h_uu[contact * n + contact] += spring.diagonal(h, h);
        }
    }

    /// Books what the dampers take in the step just solved.
    fn book_dampers(&mut self, spring: ContactSpring, h: f64) {
        let (n, rates) = (self.b_u.len(), spring.gap_rates(h));
        for contact in 0..n {
            let (gap, impulse) = (self.eq4.gap[contact], self.impulses[contact]);
            let row = body_dot(&self.h_uu[contact * n..(contact + 1) * n], &self.impulses[..n]);
            let w = self.b_u[contact] + row - rates.velocity(gap) - spring.diagonal(h, h) * impulse;
            self.damper_loss += spring.loss(impulse, gap, w, h);
        }
    }

    /// Energy in the springs of compliant contacts, J.
    pub(super) fn spring_energy(&self) -> f64 {
        let energy = |spring: ContactSpring| self.eq3.unilateral.position.iter().map(|gap| spring.energy(*gap)).sum();
        self.law.spring.map_or(0.0, energy)
    }

    /// The energy account, from changes of kinetic, potential and spring energy since the start (J).
    ///
    /// Of compliant contacts the loss is that of the dampers, and the springs are part of what is stored; what the step itself makes of
    /// both is the integration's.
    pub(super) fn energy_account(&self, kinetic: f64, potential: f64, springs: f64) -> EnergyAccount {
        let account = self.ledger.account(kinetic + potential, potential);
        if self.law.spring.is_none() {
            return account;
        }
        EnergyAccount {
            stored: account.stored + springs,
            contact: self.damper_loss,
            integration: account.integration + springs + self.damper_loss - account.contact,
            ..account
        }
    }

    /// Of a step of this length, how contacts rebound in it.
    fn impact_step(&self, h: f64) -> ImpactStep {
        ImpactStep {
            restitution: self.law.restitution,
            // One restitution for both directions, where there is friction.
            along: self.law.restitution,
            rates: GapRates::new(h, h, self.law.stabilisation),
            advance: h,
            closing_time: h,
            tolerance: self.solver.tolerance(),
        }
    }

    /// Finds the contacts that rebound in a step, whose interface impulses must be there.
    fn find_rebounds(&mut self, h: f64) -> Result<(), Failure> {
        let (rows, step) = (self.eq4.interface_start(), self.impact_step(h));
        for (row, free) in self.free.iter_mut().enumerate() {
            *free = self.eq4.w[row] + h * self.eq4.a[row];
            for (i, impulse) in self.impulses[rows..].iter().enumerate() {
                *free += self.eq4.entry(row, rows + i) * impulse;
            }
        }
        let ContactStepper { rebounds, eq4, free, .. } = self;
        let state = ImpactRows { gap: &eq4.gap, w: &eq4.w[..rows], free };
        if rebounds.note_hits(&step, state, |contact| eq4.own_approach_of(contact)) {
            self.look_ahead(&step)?;
        }
        Ok(())
    }

    /// The same once there are contacts that are hit.
    #[cold]
    fn look_ahead(&mut self, step: &ImpactStep) -> Result<(), Failure> {
        let (n, rows) = (self.impulses.len(), self.eq4.interface_start());
        let ContactStepper { rebounds, eq4, free, solver, sparse, friction, h_uu, .. } = self;
        let state = ImpactRows { gap: &eq4.gap, w: &eq4.w[..rows], free };
        if let (Some(solver), Some(matrix)) = (sparse, eq4.contact_rows()) {
            solver.forget_matrix();
            rebounds.look_ahead(step, state, |b, impulses, velocities| {
                solver.solve(matrix, b, impulses)?;
                velocities.copy_from_slice(solver.velocities());
                Ok(())
            })?;
            return Ok(());
        }
        let matrix = friction.as_mut().map_or(&mut *h_uu, |contacts| &mut contacts.h);
        for (row, out) in matrix.chunks_exact_mut(rows).enumerate() {
            out.copy_from_slice(&eq4.h[row * n..row * n + rows]);
        }
        if let Some(contacts) = friction {
            let FrictionalContacts { solver, h: matrix, .. } = &mut **contacts;
            rebounds.look_ahead(step, state, |b, impulses, velocities| {
                let problem = FrictionProblem { h: matrix, b, friction: &eq4.friction };
                solver.solve(problem, impulses)?;
                problem.velocities(impulses, velocities);
                Ok(())
            })?;
            return Ok(());
        }
        rebounds.look_ahead(step, state, |b, impulses, velocities| {
            solver.solve(Lcp::new(h_uu, b), impulses)?;
            for ((velocity, b), row) in velocities.iter_mut().zip(b).zip(h_uu.chunks_exact(rows)) {
                *velocity = b + body_dot(row, impulses);
            }
            Ok(())
        })?;
        Ok(())
    }

    /// Approach that rounding makes of contacts at rest in a step `h`, of which Eq. 4 must be, m/s.
    fn resting_approach(&self, h: f64) -> f64 {
        let rows = self.eq4.w.iter().zip(&self.eq4.a).map(|(w, a)| (*w, h * a));
        resting_approach(self.solver.tolerance(), rows.take(self.eq4.interface_start()))
    }

    /// Finds what the steps themselves make of contacts at rest; Eq. 4 must be that of a step `h`.
    ///
    /// What they make is met to rounding, so that this comes on top. Where they make nothing a rebound of rounding is rounding. Contacts that
    /// touched in neither of the last two steps do not rest: whatever they approach with, they are hit.
    fn note_own_approach(&mut self, h: f64) {
        self.note_touched();
        let (rounding, jointed) = (self.resting_approach(h), !self.eq3.bilateral.is_empty());
        let rows = &self.eq3.unilateral;
        let ([coming, last, before], [touched, touched_before]) = (&mut self.own_approach, &self.touched);
        for (contact, own) in self.eq4.own_approach.iter_mut().enumerate() {
            let corrected = if jointed { self.eq4.w[contact] - rows.velocity(contact, &self.v) } else { 0.0 };
            coming[contact] = own_approach(h, rows.convective[contact], corrected);
            *own = if touched[contact] || touched_before[contact] {
                coming[contact].max(last[contact]).max(before[contact])
            } else {
                0.0
            };
            *own += if *own > 0.0 { rounding } else { 0.0 };
        }
    }

    /// Finds the contacts that touched in the last step; before the first: gaps up to [`TOUCHING`].
    fn note_touched(&mut self) {
        if self.last_step.is_infinite() {
            for (touched, gap) in self.touched[0].iter_mut().zip(&self.eq3.unilateral.position) {
                *touched = *gap <= TOUCHING;
            }
            return;
        }
        self.find_closed();
        for (contact, (touched, closed)) in self.touched[0].iter_mut().zip(&self.eq4.at_bound).enumerate() {
            *touched = *closed || self.rebounds.rebounds(contact);
        }
    }

    /// Gap law, or what stands for it in the row of a contact that rebounds.
    fn contact_term(&self, contact: usize, h: f64) -> f64 {
        let gap_term = gap_velocity(self.eq4.gap[contact], h, h, self.law.stabilisation);
        if !self.rebounds.any() {
            return gap_term;
        }
        self.rebounds.term(&self.impact_step(h), contact, gap_term, self.eq4.w[contact], self.solved)
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
        let (contact, impulses) = self.impulses.split_at(self.eq4.interface_start());
        let mut interface = 0.0;
        for (row, impulse) in impulses.iter().enumerate() {
            interface += self.eq3.interface.velocity(row, &self.v_mean) * impulse;
        }
        self.ledger.book(EnergyLedger {
            applied: h * body_dot(&self.eq3.force, &self.v_mean),
            bilateral: work(&self.eq3.bilateral, &self.p_b),
            contact: work(&self.eq3.unilateral, &contact[..self.eq3.unilateral.len()]),
            interface,
            kinetic: self.eq3.mass.product(&self.v_mean, &self.v_change),
            ..self.friction.as_ref().map_or_else(EnergyLedger::default, |friction| {
                let tangential = &contact[self.eq3.unilateral.len()..];
                friction.book(work(&self.eq3.tangential, tangential), tangential)
            })
        });
    }

    /// Writes gaps, contact forces of the last step, and what the contacts do to the interface, in the order of
    /// [`CONTACT_OBSERVABLES`]; `h` is the step that follows.
    pub(super) fn observe(&mut self, h: f64, gaps: &mut [f64], forces: &mut [f64], contact: &mut [f64]) {
        let n_u = self.eq3.unilateral.len();
        gaps.copy_from_slice(&self.eq3.unilateral.position[..gaps.len()]);
        for (force, impulse) in forces.iter_mut().zip(&self.impulses[..n_u]) {
            *force = impulse / self.last_step;
        }
        contact.fill(f64::NAN);
        contact[4] = self.impulses[..n_u].iter().sum::<f64>() / self.last_step;
        if self.reduce_for_model(h).is_ok() {
            self.find_closed();
            self.eq4.closed_contacts(&mut self.closed);
            condense(&self.eq4, &self.closed, Redundancy::Drop, &mut self.condensation);
            contact[0] = self.closed.len() as f64;
            contact[1] = self.condensation.rank as f64;
            contact[2] = self.condensation.effective_mass;
            contact[3] = contact[2];
            if self.last_step.is_finite() {
                let active = (0..n_u).filter(|&contact| self.impulses[contact] > 0.0);
                // Mostly the contacts that are closed, or none.
                if !active.clone().eq(self.closed.iter().copied()) {
                    self.closed.clear();
                    self.closed.extend(active);
                    condense(&self.eq4, &self.closed, Redundancy::Drop, &mut self.condensation);
                    contact[3] = self.condensation.effective_mass;
                }
            }
        }
    }
}

/// Observables that every model with contacts has.
///
/// Closed are contacts whose row was at its bound in the last step, whatever a scheme counts as closed. `effective_mass_kg` is that of
/// the closed contacts; `active_effective_mass_kg` that of the contacts that carried impulse
/// in the last step. The sum of contact forces is also there for contacts that have no name of their own.
pub(super) const CONTACT_OBSERVABLES: [&str; 5] =
    ["closed_contacts", "rank_h_uu", "effective_mass_kg", "active_effective_mass_kg", "contact_force_sum_n"];

//! One step by the midpoint rule, and one impact, each from Eq. 3 at a given state.

use super::ContactStepper;
use crate::error::Failure;
use rimbench_contact::complementarity::Lcp;
use rimbench_contact::linear_algebra::body_dot;

/// The contact problem of a step over some of the contacts.
#[derive(Debug, Clone)]
pub(in crate::mechanics) struct ActiveProblem {
    /// The contacts.
    pub(in crate::mechanics) contacts: Vec<usize>,
    /// Velocity that each may not fall below, minus that without its own impulse, m/s: the last part of the right-hand
    /// side.
    pub(in crate::mechanics) terms: Vec<f64>,
    /// Whether its row was at its bound in the step, loaded or not.
    pub(in crate::mechanics) at_bound: Vec<bool>,
    h: Vec<f64>,
    b: Vec<f64>,
    impulses: Vec<f64>,
}

impl ActiveProblem {
    /// Reserves up to `contacts` of them.
    pub(in crate::mechanics) fn new(contacts: usize) -> Self {
        ActiveProblem {
            contacts: Vec::with_capacity(contacts),
            terms: Vec::with_capacity(contacts),
            at_bound: Vec::with_capacity(contacts),
            h: vec![0.0; contacts * contacts],
            b: vec![0.0; contacts],
            impulses: vec![0.0; contacts],
        }
    }

    /// Removes all contacts.
    pub(in crate::mechanics) fn clear(&mut self) {
        self.contacts.clear();
        self.terms.clear();
    }

    /// Adds one contact with its term.
    pub(in crate::mechanics) fn push(&mut self, contact: usize, term: f64) {
        self.contacts.push(contact);
        self.terms.push(term);
    }
}

/// A step by the midpoint rule.
#[derive(Debug, Clone, Copy)]
pub(in crate::mechanics) struct MidpointStep<'a> {
    /// Its length, s.
    pub(in crate::mechanics) h: f64,
    /// The rate at which joint errors decay, 1/s.
    pub(in crate::mechanics) stabilisation_rate: f64,
    /// The velocity at which the forces of Eq. 3 are taken.
    pub(in crate::mechanics) v_m: &'a [f64],
    /// Mean interface forces, N.
    pub(in crate::mechanics) force: &'a [f64],
    /// Their first moments about the middle, `∫ (½h − τ) λ dτ`, N·s², where it is known when they act.
    pub(in crate::mechanics) moment: Option<&'a [f64]>,
}

impl ContactStepper {
    /// Advances by one step of the midpoint rule.
    ///
    /// ```text
    /// v⁺ = v̂ + h α + G (A_uᵀ P_u + A_iᵀ h λ)      M, f, A at the middle       q⁺ = q + ½h (v + v⁺)
    /// 0 ≤ A_u v⁺ + ½h Ȧ_u v + term ⟂ P_u ≥ 0      for the contacts of `set`
    /// A_b v⁺ + ½h Ȧ_b v + stabilisation_rate g_b = 0
    /// ```
    /// Eq. 3 must be that of the middle, its convective terms halved, with the joint errors of the start. Stiff forces
    /// are taken implicitly ([`ImplicitPart`](super::ImplicitPart)). With moments κ the position follows from the
    /// velocity `v′` that impulses `h λ + 2κ/h` would leave: of a free body this adds `G A_iᵀ κ`, its displacement by
    /// the variation of the force.
    pub(in crate::mechanics) fn advance_from_middle(
        &mut self,
        step: MidpointStep<'_>,
        set: &mut ActiveProblem,
    ) -> Result<(), Failure> {
        let h = step.h;
        self.begin_implicit(h, step.v_m);
        let solved = self.solve_middle(step, set);
        self.end_implicit(h);
        solved?;
        self.book_energy(h);
        let v_displacement = if step.moment.is_some() { &self.v_displacement } else { &self.v_next };
        assert_eq!(self.q.len(), self.v.len(), "steps of the second order have a coordinate for each velocity");
        for (q, (v, v_displacement)) in self.q.iter_mut().zip(self.v.iter().zip(v_displacement)) {
            *q += 0.5 * h * (v + v_displacement);
        }
        std::mem::swap(&mut self.v, &mut self.v_next);
        self.last_step = h;
        self.reduced_for = None;
        self.counters.micro_steps += 1;
        if !self.q.iter().all(|x| x.is_finite()) {
            return Err(Failure::non_finite("mechanical state"));
        }
        Ok(())
    }

    /// Finds velocity and impulses at the end of the step.
    fn solve_middle(&mut self, step: MidpointStep<'_>, set: &mut ActiveProblem) -> Result<(), Failure> {
        let MidpointStep { h, stabilisation_rate, force, moment, .. } = step;
        self.elimination.reduce(&self.eq3, &self.v, h, stabilisation_rate * h, &mut self.eq4)?;
        self.counters.eliminations += 1;
        let n_u = self.eq4.contacts();
        if let Some(moment) = moment {
            for (impulse, (force, moment)) in self.impulses[n_u..].iter_mut().zip(force.iter().zip(moment)) {
                *impulse = h * force + 2.0 * moment / h;
            }
            self.solve_set(h, set)?;
            self.elimination.velocity_after(h, &self.impulses, &mut self.v_displacement);
        }
        for (impulse, force) in self.impulses[n_u..].iter_mut().zip(force) {
            *impulse = h * force;
        }
        self.solve_set(h, set)?;
        self.elimination.velocity_after(h, &self.impulses, &mut self.v_next);
        self.elimination.bilateral_impulses(h, &self.impulses, &mut self.p_b);
        Ok(())
    }

    /// Solves the impact of the contacts of `set` at the present state, and writes their terms.
    ///
    /// ```text
    /// v⁺ = v̂ + G A_uᵀ P_u        0 ≤ w⁺ + e w⁻ ⟂ P ≥ 0
    /// ```
    /// Free accelerations `a` of Eq. 4 are those of this state afterwards. Eq. 3 must be that of this state.
    pub(in crate::mechanics) fn collide(&mut self, set: &mut ActiveProblem) -> Result<(), Failure> {
        // No time passes: a step of any length does, and joints are not pulled together.
        self.elimination.reduce(&self.eq3, &self.v, 1.0, 0.0, &mut self.eq4)?;
        self.counters.eliminations += 1;
        let n_u = self.eq4.contacts();
        self.impulses[n_u..].fill(0.0);
        set.terms.clear();
        for &contact in &set.contacts {
            let restitution = if self.eq4.is_plastic(contact) { 0.0 } else { self.law.restitution };
            set.terms.push(restitution * self.eq4.w[contact].min(0.0));
        }
        self.solve_set(0.0, set)?;
        self.elimination.velocity_after(0.0, &self.impulses, &mut self.v_next);
        self.elimination.bilateral_impulses(0.0, &self.impulses, &mut self.p_b);
        self.book_energy(0.0);
        std::mem::swap(&mut self.v, &mut self.v_next);
        self.reduced_for = None;
        self.counters.micro_steps += 1;
        Ok(())
    }

    /// Solves the contact problem of `set` over a step of `h` (s; 0 for an impact), and writes its impulses to
    /// `impulses`.
    fn solve_set(&mut self, h: f64, set: &mut ActiveProblem) -> Result<(), Failure> {
        let (n_u, n, m) = (self.eq4.contacts(), self.impulses.len(), set.contacts.len());
        self.impulses[..n_u].fill(0.0);
        set.at_bound.clear();
        if m == 0 {
            return Ok(());
        }
        let ActiveProblem { contacts, terms, at_bound, h: h_set, b, impulses } = set;
        let mut scale = 0.0_f64;
        for (slot, (&contact, term)) in contacts.iter().zip(&*terms).enumerate() {
            let row = &self.eq4.h[contact * n..(contact + 1) * n];
            let free = self.eq4.w[contact] + h * self.eq4.a[contact];
            b[slot] = free + body_dot(&row[n_u..], &self.impulses[n_u..]) + term;
            scale = scale.max(b[slot].abs());
            for (out, &other) in h_set[slot * m..(slot + 1) * m].iter_mut().zip(&*contacts) {
                *out = row[other];
            }
        }
        let solver = self.contacts.signorini().expect("steps of the second order have rigid contacts without friction");
        solver.solve(Lcp::new(&h_set[..m * m], &b[..m]), &mut impulses[..m])?;
        let bound = solver.tolerance() * scale;
        for (slot, &contact) in contacts.iter().enumerate() {
            let slack = b[slot] + body_dot(&h_set[slot * m..(slot + 1) * m], &impulses[..m]);
            at_bound.push(slack <= bound);
            self.impulses[contact] = impulses[slot];
        }
        Ok(())
    }

    /// Returns the acceleration of a contact without contact forces, as of the last reduction, m/s².
    pub(in crate::mechanics) fn free_acceleration(&self, contact: usize, lambda: &[f64]) -> f64 {
        let (n_u, n) = (self.eq4.contacts(), self.impulses.len());
        self.eq4.a[contact] + body_dot(&self.eq4.h[contact * n + n_u..(contact + 1) * n], lambda)
    }

    /// Counts a step that was split at an event.
    pub(in crate::mechanics) fn count_split(&mut self) {
        self.counters.splits += 1;
    }

    /// Counts a step with so many events that its rest is taken with the gap law.
    pub(in crate::mechanics) fn count_split_fallback(&mut self) {
        self.counters.split_fallbacks += 1;
    }
}

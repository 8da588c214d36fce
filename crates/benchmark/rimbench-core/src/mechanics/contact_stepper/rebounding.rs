//! Contacts that rebound in a step, and those that rest although the step itself makes them approach.

use super::ContactLaw;
use super::step_contacts::StepContacts;
use crate::error::Failure;
use crate::interface_model::{Linearisation, ReducedInterfaceModel, TOUCHING};
use rimbench_contact::contact_law::{
    GapRates, ImpactRows, ImpactStep, Rebounds, Solved, discretisation_approach, rounding_velocity,
};

/// The rebounds of a step, with approaches and touching contacts of the steps before it. Empty where nothing rebounds.
#[derive(Debug, Clone, Default)]
pub(super) struct Rebounding {
    rebounds: Rebounds,
    /// Restitution along the surface.
    along: f64,
    tolerance: f64,
    /// Velocities of the contacts' rows without contact forces, m/s.
    free: Vec<f64>,
    /// Approach of each contact caused by the discretisation in the next step and in the last two, m/s.
    approach: [Vec<f64>; 3],
    /// Contacts that touched in the last step and in the one before: at their bound, or rebounding.
    touched: [Vec<bool>; 2],
}

impl Rebounding {
    /// Reserves the contacts of `eq4`, whose solver accepts residuals up to `tolerance`.
    pub(super) fn new(eq4: &ReducedInterfaceModel, tolerance: f64) -> Self {
        let (contacts, rows) = (eq4.contacts(), eq4.interface_start());
        Rebounding {
            rebounds: Rebounds::new(contacts, rows),
            along: eq4.tangential_restitution,
            tolerance,
            free: vec![0.0; rows],
            approach: [(); 3].map(|()| vec![0.0; contacts]),
            touched: [(); 2].map(|()| vec![false; contacts]),
        }
    }

    /// Tells whether a contact rebounds in the step.
    #[inline]
    pub(super) fn any(&self) -> bool {
        self.rebounds.any()
    }

    /// Tells whether this contact rebounds in the step.
    #[inline]
    pub(super) fn rebounds(&self, contact: usize) -> bool {
        self.rebounds.rebounds(contact)
    }

    /// Returns the impact law over a step of `h` (s).
    fn impact_step(&self, law: &ContactLaw, h: f64) -> ImpactStep {
        ImpactStep {
            restitution: law.restitution,
            along: self.along,
            rates: GapRates::new(h, h, law.stabilisation),
            advance: h,
            closing_time: h,
            tolerance: self.tolerance,
        }
    }

    /// Returns the term of a normal row that moves with `w` (m/s) at the start of a step of `h` (s): the gap term, or
    /// that of a rebound, m/s.
    #[inline]
    pub(super) fn normal_term(
        &self,
        law: &ContactLaw,
        contact: usize,
        gap_term: f64,
        (w, h): (f64, f64),
        solved: Solved,
    ) -> f64 {
        if self.any() { self.impact_term(law, contact, gap_term, (w, h), solved) } else { gap_term }
    }

    #[cold]
    fn impact_term(&self, law: &ContactLaw, contact: usize, gap_term: f64, (w, h): (f64, f64), solved: Solved) -> f64 {
        self.rebounds.term(&self.impact_step(law, h), contact, gap_term, w, solved)
    }

    /// Returns the term of the tangential row of a contact, m/s.
    #[inline]
    pub(super) fn tangential_term(&self, law: &ContactLaw, contact: usize, (w, h): (f64, f64)) -> f64 {
        if !self.any() {
            return 0.0;
        }
        self.rebounds.term_along(&self.impact_step(law, h), contact, w)
    }

    /// Finds the contacts that rebound in a step of `h` (s) under the interface impulses `p_i` (N·s).
    ///
    /// # Errors
    /// As the contact solver reports, which is asked once there are contacts that are hit.
    pub(super) fn find(
        &mut self,
        law: &ContactLaw,
        eq4: &ReducedInterfaceModel,
        p_i: &[f64],
        h: f64,
        contacts: &mut StepContacts,
    ) -> Result<(), Failure> {
        let (rows, step) = (eq4.interface_start(), self.impact_step(law, h));
        for (row, free) in self.free.iter_mut().enumerate() {
            *free = eq4.w[row] + h * eq4.a[row];
            for (i, impulse) in p_i.iter().enumerate() {
                *free += eq4.entry(row, rows + i) * impulse;
            }
        }
        let state = ImpactRows { gap: &eq4.gap, w: &eq4.w[..rows], free: &self.free };
        if self.rebounds.record_hits(&step, state, |contact| eq4.discretisation_approach_of(contact)) {
            contacts.begin_trials(eq4);
            self.rebounds
                .look_ahead(&step, state, |b, impulses, velocities| contacts.try_solve(eq4, b, impulses, velocities))?;
        }
        Ok(())
    }

    /// Records the contacts that touched in the last step; before the first: gaps up to [`TOUCHING`].
    pub(super) fn record_touched(&mut self, at_bound: &[bool], gaps_at_start: Option<&[f64]>) {
        let Rebounding { rebounds, touched: [touched, _], .. } = self;
        for (contact, touched) in touched.iter_mut().enumerate() {
            *touched = match gaps_at_start {
                Some(gaps) => gaps[contact] <= TOUCHING,
                None => at_bound[contact] || rebounds.rebounds(contact),
            };
        }
    }

    /// Writes to Eq. 4 of a step `h` (s) the approach w₀ of contacts at rest that the discretisation causes, at the
    /// velocities `v`.
    ///
    /// Where w₀ is not zero, rounding is added. Contacts that touched in neither of the last two steps do not rest: any
    /// approach is an impact.
    pub(super) fn write_approach(&mut self, eq3: &Linearisation, v: &[f64], h: f64, eq4: &mut ReducedInterfaceModel) {
        let rows = eq4.w.iter().zip(&eq4.a).map(|(w, a)| (*w, h * a));
        let rounding = rounding_velocity(self.tolerance, rows.take(eq4.interface_start()));
        let (rows, jointed) = (&eq3.unilateral, !eq3.bilateral.is_empty());
        let ([coming, last, before], [touched, touched_before]) = (&mut self.approach, &self.touched);
        for (contact, own) in eq4.discretisation_approach.iter_mut().enumerate() {
            let corrected = if jointed { eq4.w[contact] - rows.velocity(contact, v) } else { 0.0 };
            coming[contact] = discretisation_approach(h, rows.convective[contact], corrected);
            *own = if touched[contact] || touched_before[contact] {
                coming[contact].max(last[contact]).max(before[contact])
            } else {
                0.0
            };
            *own += if *own > 0.0 { rounding } else { 0.0 };
        }
    }

    /// Makes the present step the last one.
    pub(super) fn rotate(&mut self) {
        self.approach.rotate_right(1);
        self.touched.rotate_right(1);
    }
}

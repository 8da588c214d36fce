//! Rows that come to stand for other contacts, as bodies travel.

use super::ContactStepper;
use super::step_contacts::StepContacts;
use crate::error::Failure;
use crate::interface_model::{Elimination, Rows};

impl ContactStepper {
    /// Replaces the rows by those of other contacts, after a step; `columns` are those of their non-zeros. A contact
    /// that was closed or hit in the step must have kept its row.
    ///
    /// # Errors
    /// If the pattern of `H_uu` is no longer sparse.
    pub(in crate::mechanics) fn remap_contacts(&mut self, columns: Option<&[Vec<usize>]>) -> Result<(), Failure> {
        // The closed contacts follow from the contact problem of the old rows.
        self.find_closed();
        let (rows, velocities) = (self.eq3.unilateral.len(), self.eq3.velocities());
        match columns.filter(|_| self.contacts.dense_solver().is_some()) {
            Some(columns) => self.eq3.unilateral = Rows::in_columns(velocities, columns),
            // Entries of the old rows must not remain.
            None => self.eq3.unilateral = Rows::zeros(rows, velocities),
        }
        let pattern = Elimination::delassus_pattern(&self.eq3);
        self.elimination = Elimination::with_pattern(&self.eq3, pattern.as_deref());
        if let StepContacts::Sparse { solver, .. } = &mut self.contacts {
            let few = "contacts that are listed again as bodies travel meet so often that there is no room for them";
            let pattern = pattern.ok_or_else(|| Failure::reported(few))?;
            solver.solver.change_pattern(&pattern);
            self.eq4.set_delassus_pattern(pattern);
        }
        self.eq4.count_version();
        self.forget_reduction();
        Ok(())
    }
}

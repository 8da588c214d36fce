//! What a metric may look at.

use super::contact_phase::ContactInterval;
use crate::cosim::{Report, Trajectory};

/// A run, its reference, and which columns are which.
pub struct Evidence<'a> {
    /// The run, one row per communication point.
    pub run: &'a Trajectory,
    /// The reference at the communication points of the run, with the same columns.
    pub reference: &'a Trajectory,
    /// When each contact is closed in the run, in the order of `gaps`.
    pub run_contacts: &'a [Vec<ContactInterval>],
    /// When each contact is closed in the reference at its own sampling, in the order of `gaps`.
    pub reference_contacts: &'a [Vec<ContactInterval>],
    /// Largest magnitude of the interface force in the whole reference, N.
    pub reference_force_peak: f64,
    /// How the run ended.
    pub report: &'a Report,
    /// Column of the interface position.
    pub position: usize,
    /// Column of the interface velocity.
    pub velocity: usize,
    /// Column of the interface force.
    pub force: usize,
    /// Column of the effective mass, where the case has one.
    pub effective_mass: Option<usize>,
    /// Columns of the gaps.
    pub gaps: &'a [usize],
    /// Largest violation of the mechanics' energy identity, J.
    pub energy_identity_residual_j: Option<f64>,
}

/// One metric by name.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// Name with unit, as it stands in data.
    pub name: &'static str,
    /// Unit; `-` for a pure number.
    pub unit: &'static str,
    /// One line.
    pub about: &'static str,
    /// Computes it; `None` where it does not apply.
    pub compute: fn(&Evidence<'_>) -> Option<f64>,
}

impl Evidence<'_> {
    /// Pairs (run, reference) of one column at the communication points of the run.
    pub(super) fn pairs(&self, column: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.run.column(column).zip(self.reference.column(column))
    }
}

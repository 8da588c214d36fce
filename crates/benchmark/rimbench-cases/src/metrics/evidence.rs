//! What a metric may look at.

use super::contact_phase::ContactInterval;
use super::friction_phase::FrictionPhase;
use rimbench_core::cosim::{Report, Trajectory};
use rimbench_statistics::Floor;
use std::sync::Arc;

/// A run, its reference, and which columns are which.
pub struct Evidence<'a> {
    /// The run, one row per communication point.
    pub run: &'a Trajectory,
    /// The reference at the communication points of the run, or at more behind them: at least the interface's columns and the gaps.
    pub reference: &'a Trajectory,
    /// When each contact is closed in the run, in the order of `gaps`.
    pub run_contacts: &'a [Vec<ContactInterval>],
    /// When each contact is closed in the reference at its own sampling, in the order of `gaps`.
    pub reference_contacts: &'a [Vec<ContactInterval>],
    /// What each contact with friction does in the run, of those that the reference knows, too; none without friction.
    pub run_friction: &'a [Vec<FrictionPhase>],
    /// The same contacts, in the same order, in the reference at its own sampling.
    pub reference_friction: &'a [Vec<FrictionPhase>],
    /// How the run ended.
    pub report: &'a Report,
    /// Whether an account of what its model created was asked for.
    pub audited: bool,
    /// The rows of the interface.
    pub interface: &'a [InterfaceRow],
    /// Column of the effective mass, where the case has one.
    pub effective_mass: Option<usize>,
    /// Columns of the gaps of one contact each.
    pub gaps: &'a [usize],
    /// Columns of the least gap of several contacts.
    pub least_gaps: &'a [usize],
    /// Times at which a touch-down of the reference shows, from and to, s.
    pub touch_downs: &'a [[f64; 2]],
    /// What the actuator did inside macro steps, where that was noted.
    pub inside: Option<&'a Inside<'a>>,
    /// Half of the mechanics' last step before each communication point of the run, s; 0 where its rule is of second order.
    pub half_steps: &'a [f64],
    /// See [`predicted_growth`](crate::runs::predicted_growth).
    pub predicted_growth: Option<f64>,
}

/// The micro steps of the actuator and the reference at the same times.
#[derive(Debug)]
pub struct Inside<'a> {
    /// See [`Report::inside`].
    pub log: &'a Trajectory,
    /// The reference at the first two columns of the log, or longer: at the start of each micro step, and in its middle.
    pub reference: [Arc<Trajectory>; 2],
}

/// One row of the interface in run and reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterfaceRow {
    /// Column of the position.
    pub position: usize,
    /// Column of the velocity.
    pub velocity: usize,
    /// Column of the force.
    pub force: usize,
    /// Largest magnitude of the force in the whole reference, N; none where there is no force to speak of.
    pub reference_force_peak: Option<f64>,
    /// The same of the reference's touch-downs, N; none where there are none.
    pub reference_touch_down_peak: Option<f64>,
}

/// One metric by name.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// Name with unit, as it stands in data.
    pub name: &'static str,
    /// Unit; `-` for a pure number.
    pub unit: &'static str,
    /// The runs that it says something of; none where these are all.
    pub only: Option<Only>,
    /// Whether it may be below 0, so that how much it is lies in its magnitude.
    pub signed: bool,
    /// The value of a run without error: 0, or 1 of a ratio or a correlation that is then 1.
    pub ideal: f64,
    /// Whether it tells how the run ended, so that one that failed says as much as one that completed.
    pub ends: bool,
    /// What it must exceed to say more than that it is small; none for what is no error of force or position.
    pub floor: Option<Floor>,
    /// One line.
    pub about: &'static str,
    /// Computes it; `None` where it does not apply.
    pub compute: fn(&Evidence<'_>) -> Option<f64>,
}

/// The runs that a metric says something of, where these are not all. Tables without such runs lack it, but for friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Only {
    /// Of cases whose contacts have friction.
    Friction,
    /// Of schemes with a model for each actuator.
    Split,
    /// Runs whose scheme tries steps of the mechanics.
    Trials,
    /// Whose samples may be late.
    Late,
    /// With an account of what the model created.
    Audit,
    /// Of cases that record the column of which it is the largest value.
    Column,
    /// Of experiments with a claim about it.
    Claimed,
}

/// Declares metrics, one after the other: the constant, the name in data and the unit, whether it is `(signed)`, has its `(ideal_one)` at 1, is both, a `(correlation)`, or tells how a run `(ends)`, the runs that it is for (`of`, where these are not
/// all), what it must exceed to say more than that it is small (`above`, for errors of force and position), one line about it, and how it is
/// computed.
macro_rules! metrics {
    (@floor) => { None };
    (@floor $floor:path) => { Some($floor) };
    (@signed) => { false };
    (@signed signed) => { true };
    (@signed correlation) => { true };
    (@signed $other:ident) => { false };
    (@ideal ideal_one) => { 1.0 };
    (@ideal correlation) => { 1.0 };
    (@ideal $($signed:ident)?) => { 0.0 };
    (@ends ends) => { true };
    (@ends $($other:ident)?) => { false };
    (@only) => { None };
    (@only $only:ident) => { Some($crate::metrics::Only::$only) };
    ($($(#[$doc:meta])* $constant:ident: $name:literal in $unit:literal $(($signed:ident))? $(of $only:ident)? $(above $floor:path)?, $about:literal => $compute:expr;)+) => {$(
        $(#[$doc])*
        pub(super) const $constant: $crate::metrics::Metric = $crate::metrics::Metric {
            name: $name,
            unit: $unit,
            only: metrics!(@only $($only)?),
            signed: metrics!(@signed $($signed)?),
            ideal: metrics!(@ideal $($signed)?),
            ends: metrics!(@ends $($signed)?),
            floor: metrics!(@floor $($floor)?),
            about: $about,
            compute: $compute,
        };
    )+};
}
pub(super) use metrics;

impl Evidence<'_> {
    /// Pairs (run, reference) of one column of the run at its communication points; none if the reference lacks it.
    pub(super) fn pairs(&self, column: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        let in_reference = self.reference.index_of(&self.run.columns()[column]);
        let reference = in_reference.into_iter().flat_map(|column| self.reference.column(column));
        self.run.column(column).zip(reference)
    }
}

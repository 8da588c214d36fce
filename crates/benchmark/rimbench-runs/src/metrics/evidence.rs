//! What a metric may look at.

use super::contact_phase::ContactInterval;
use super::friction_phase::FrictionPhase;
use super::sums::Sums;
use rimbench_core::cosim::Report;

/// What is known of a run and its reference.
pub struct Evidence<'a> {
    /// Of the rows of the run.
    pub sums: &'a Sums,
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
    /// See [`predicted_growth`](crate::predicted_growth).
    pub predicted_growth: Option<f64>,
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

/// What an error must exceed to say more than that it is small: the rms uncertainty of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Floor {
    /// That of the force.
    Force,
    /// That of the force as a share of the peak.
    ShareOfPeak,
    /// That of the position.
    Position,
}

/// The runs that a metric says something of, where these are not all. Tables without such runs lack it, but for
/// friction.
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
    /// Whose error is divided into that of the coupling and that of the mechanics' own step.
    Divided,
    /// With an account of what the model created, of a model that is believed to be another than that of the mechanics.
    Believed,
    /// Of cases that record the column of which it is the largest value.
    Column,
    /// Of experiments with a claim about it.
    Claimed,
}

/// Declares metrics, one after the other: the constant, the name in data and the unit, whether it is `(signed)`, has
/// its `(ideal_one)` at 1, is both, a `(correlation)`, or tells how a run `(ends)`, the runs that it is for (`of`,
/// where these are not all), what it must exceed to say more than that it is small (`above`, for errors of force and
/// position), one line about it, and how it is computed.
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

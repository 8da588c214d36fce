//! What is measured: pure functions of trajectories and reports, listed in [`METRICS`].
//!
//! To add one: write a function from [`Evidence`] to a number, and add an entry to the list. A metric that does not
//! apply to a run is `None`, an empty cell in data.

mod accuracy;
mod contact;
mod contact_event;
mod contact_phase;
mod energy;
mod event;
mod evidence;
mod friction;
mod friction_phase;
mod impulse;
mod inside;
mod interface;
mod macro_step;
mod model_energy;
mod sums;

/// The largest share of a peak that the rms force error of a good run is: of the peak at the event, of a *usable* run,
/// and of the peak of the whole run, of an *accurate* one.
pub const USABLE: f64 = 0.1;

pub use contact::STAYS_DOWN_M;
pub use contact_event::ContactEvent;
pub use contact_phase::{CLOSES_AT, ContactInterval, ContactIntervals, contact_intervals};
pub(crate) use event::touch_downs;
pub use evidence::{Evidence, Floor, Metric, Only};
pub use friction_phase::{FrictionPhase, FrictionPhases, friction_phases};
pub(crate) use impulse::impulse_column;
pub use sums::{Columns, InterfaceRow, Sums};

/// Every metric, in the order of the columns in data.
pub const METRICS: &[Metric] = &[
    accuracy::FORCE_ERROR_RMS,
    accuracy::FORCE_ERROR_L1,
    accuracy::FORCE_ERROR_MAX,
    accuracy::FORCE_ERROR_OF_PEAK,
    accuracy::FORCE_ERROR_OF_EVENT,
    accuracy::FORCE_ERROR_AFTER,
    accuracy::COUPLING_DISTANCE,
    accuracy::MECHANICS_DISTANCE,
    accuracy::COUPLING_SHARE,
    inside::FORCE_ERROR_INSIDE,
    inside::IMPULSE_ERROR,
    accuracy::FORCE_PEAK,
    accuracy::TOUCH_DOWN_PEAK_RATIO,
    accuracy::TOUCH_DOWN_SHOWN,
    accuracy::TOUCH_DOWN_ERROR,
    accuracy::TOUCH_DOWN_PRESSURE,
    accuracy::VELOCITY_END,
    accuracy::VELOCITY_ERROR_RMS,
    accuracy::POSITION_ERROR_RMS,
    accuracy::POSITION_ERROR_ALIGNED,
    inside::POSITION_ERROR_INSIDE,
    accuracy::POSITION_ERROR_END,
    contact::EFFECTIVE_MASS_MAX,
    contact::EFFECTIVE_MASS_RATIO,
    contact::LIFT_OFF,
    contact::CLOSED_AT_END,
    contact::REDUNDANT,
    contact::PENETRATION,
    event::TIME_SHIFT_MAX,
    event::MISSED,
    event::WRONG_STATE,
    friction::WRONG_STATE,
    friction::RELEASE_SHIFT_MAX,
    friction::RELEASES_MISSED,
    friction::STICK_INTERVALS,
    friction::SLIP_REVERSALS,
    energy::WORK_SENT,
    energy::WORK_RECEIVED,
    energy::INTERFACE_RESIDUAL,
    energy::RESIDUAL_IN_IMPACTS,
    energy::INTERFACE_DRIFT,
    energy::STORED_CHANGE,
    energy::GROWTH,
    energy::PUMP_WORK,
    energy::VALVE_DISSIPATION,
    energy::TANK_OUTFLOW,
    energy::VISCOUS_DISSIPATION,
    energy::CONTACT_DISSIPATION,
    energy::FRICTION_DISSIPATION,
    energy::SCHEME_DISSIPATION,
    energy::INTEGRATION_RESIDUAL,
    energy::AUDIT_CLOSURE,
    energy::IDENTITY_RESIDUAL,
    model_energy::BY_JUMP,
    model_energy::BY_FIRST_MOMENT,
    model_energy::BY_CONTACTS,
    model_energy::UNFROZEN,
    model_energy::BY_AGE,
    model_energy::LARGEST_JUMP,
    model_energy::HEAVINESS,
    model_energy::LEARNED_MASS,
    model_energy::BY_MASS,
    model_energy::LATE_ACCELERATION,
    model_energy::CATCH_UP,
    macro_step::MEAN_MACRO_STEP,
    macro_step::DEFECT_RANK,
    interface::LAMBDA,
    interface::CORRELATION,
    interface::CREATED,
    interface::BOOKED,
    interface::TRIALS,
    interface::MOST_TRIALS,
    interface::CUT_TRIALS,
    interface::SECOND_TANGENTS,
    interface::MISS,
    interface::LARGEST_MISS,
    interface::AS_PREDICTED,
    interface::UNFORESEEN,
];

impl Metric {
    /// Tells whether a run may complete with a value that is not finite: of an interface that is locked, and of an
    /// account that was asked for and could not be drawn up.
    pub fn may_be_infinite(&self) -> bool {
        [contact::EFFECTIVE_MASS_MAX, contact::EFFECTIVE_MASS_RATIO, model_energy::HEAVINESS]
            .iter()
            .any(|metric| metric.name == self.name)
    }
}

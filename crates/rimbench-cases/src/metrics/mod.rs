//! What is measured: pure functions of trajectories and reports, listed in [`METRICS`].
//!
//! To add one: write a function from [`Evidence`] to a number, and add an entry to the list. A metric that does not
//! apply to a run is `None`, an empty cell in data.

mod accuracy;
mod contact;
mod contact_phase;
mod energy;
mod event;
mod evidence;
mod impulse;
mod inside;
mod pace;
#[cfg(test)]
mod tests;

pub use contact_phase::{ContactInterval, contact_intervals};
pub(crate) use event::touch_downs;
pub use evidence::{Evidence, Inside, InterfaceRow, Metric};
pub(crate) use impulse::impulse_column;

/// Every metric, in the order of the columns in data.
pub const METRICS: &[Metric] = &[
    accuracy::FORCE_ERROR_RMS,
    accuracy::FORCE_ERROR_L1,
    accuracy::FORCE_ERROR_MAX,
    accuracy::FORCE_ERROR_OF_PEAK,
    inside::FORCE_ERROR_INSIDE,
    impulse::IMPULSE_ERROR,
    accuracy::FORCE_PEAK,
    accuracy::TOUCH_DOWN_PEAK_RATIO,
    accuracy::VELOCITY_ERROR_RMS,
    accuracy::POSITION_ERROR_RMS,
    inside::POSITION_ERROR_INSIDE,
    accuracy::POSITION_ERROR_END,
    contact::EFFECTIVE_MASS_MAX,
    contact::EFFECTIVE_MASS_RATIO,
    contact::LIFT_OFF,
    contact::PENETRATION,
    event::TIME_SHIFT_MAX,
    event::MISSED,
    event::WRONG_STATE,
    energy::WORK_SENT,
    energy::WORK_RECEIVED,
    energy::INTERFACE_RESIDUAL,
    energy::RESIDUAL_IN_IMPACTS,
    energy::INTERFACE_DRIFT,
    energy::STORED_CHANGE,
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
    pace::MEAN_MACRO_STEP,
    pace::DEFECT_RANK,
];

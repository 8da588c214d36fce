//! The modes of contacts with friction in which a model is condensed.

use rimbench_contact::friction::ContactState;

/// Modes and coefficients of contacts with friction, in the order of the model; empty without friction.
#[derive(Debug, Clone, Copy)]
pub struct ContactModes<'a> {
    /// Open, stick, or slip.
    pub states: &'a [ContactState],
    /// Coefficient μ of each contact.
    pub friction: &'a [f64],
}

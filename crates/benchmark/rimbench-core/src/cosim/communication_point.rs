//! The view of a run from outside.

use super::side::PerSide;
use super::subsystem::Sides;
use super::trajectory::Trajectory;

/// The view of an observer at a communication point.
pub struct CommunicationPoint<'a> {
    /// `t_k`, s.
    pub time: f64,
    /// Outputs of each side; those of the actuator are its own, at this instant.
    pub y: PerSide<&'a [f64]>,
    /// The forces that the mechanics received over the macro step that ends here (at `t_0`: those it would be held at).
    pub received: &'a [f64],
    /// Effective mass that the scheme had in the macro step that ends here, kg: it belongs to the communication point
    /// before, and is known only now. That of the last communication point stands in the [`Report`](super::Report).
    pub effective_mass: Option<f64>,
    /// Energy that the scheme's interface model has created so far, J, and how much heavier the model was in the
    /// macro step that ends here (see [`ModelEnergy`](super::ModelEnergy)).
    pub audit: Option<[f64; 2]>,
    /// Largest eigenvalue of the correlations of the interface rows, the larger of the free mechanics' and of that with
    /// the contacts closed that carried impulse in the macro step that ends here; none of one bond.
    pub interface_lambda: Option<f64>,
    /// The mechanics' own step in the macro step that starts here, s.
    pub mechanics_step: f64,
    /// What the coupling has lost (> 0) or created (< 0) so far, J; none where it is not counted.
    pub interface_residual: Option<f64>,
    /// The micro steps so far, where they are noted, as in [`Report::inside`](super::Report::inside): rows taken out
    /// here are not there in the end.
    pub inside: Option<&'a mut Trajectory>,
    /// Both sides.
    pub sides: Sides<'a>,
}

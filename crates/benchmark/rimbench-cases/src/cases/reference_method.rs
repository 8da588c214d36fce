//! What the runs of a case are held against.

use rimbench_core::cosim::{StopFlag, Trajectory};
use rimbench_core::error::Failure;
use rimbench_core::mechanics::ReferenceSteps;

/// Writes the whole row of recorded columns for a time in seconds. One that takes longer than a moment looks at the
/// flag, and leaves a row without numbers when it is raised.
pub type ExactSolution = Box<dyn Fn(f64, StopFlag<'_>, &mut [f64]) + Send + Sync>;

/// Integrates the whole system with steps as given, and writes a row wherever one is due. Looks at the flag in every
/// step.
pub type OwnIntegrator =
    Box<dyn Fn(ReferenceSteps, StopFlag<'_>, &mut Trajectory) -> Result<(), Failure> + Send + Sync>;

/// How the reference of a case is made.
pub enum ReferenceMethod {
    /// Both sides in one loop by semi-implicit Euler (see [`monolithic`](rimbench_core::mechanics::monolithic)) with
    /// steps h, h/2, h/4; its error is estimated by Richardson extrapolation.
    Refined,
    /// Both sides piece by piece, by rules of the second order, cut where gaps close and geometry switches (see
    /// [`ContactMechanics`](rimbench_core::cosim::ContactMechanics)), with steps h, h/2, h/4 likewise.
    EventDriven,
    /// An integrator of the case's own for the whole system, with steps h, h/2, h/4 likewise.
    Own(OwnIntegrator),
    /// A closed form. Runs are compared with it at their own communication points, so it has no error of sampling.
    Exact(ExactSolution),
}

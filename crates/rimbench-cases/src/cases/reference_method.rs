//! What the runs of a case are held against.

use super::parameters::Parameters;
use rimbench_core::cosim::Trajectory;
use rimbench_core::error::{Failure, Result};

/// Writes the whole row of recorded columns for a time in seconds.
pub type ExactSolution = Box<dyn Fn(f64, &mut [f64]) + Send + Sync>;

/// How the reference of a case is made.
#[derive(Debug, Clone, Copy)]
pub enum ReferenceMethod {
    /// Both sides in one loop by semi-implicit Euler (see [`monolithic`](rimbench_core::mechanics::monolithic)) with steps h,
    /// h/2, h/4; its error is estimated by Richardson extrapolation.
    Refined,
    /// An integrator of the case's own for the whole system, with steps h, h/2, h/4 likewise. Called with the step (s),
    /// the number of steps and every how many steps a row is due; writes the first and the last row too.
    Own(fn(&Parameters, f64, usize, usize, &mut Trajectory) -> Result<(), Failure>),
    /// A closed form. Runs are compared with it at their own communication points, so it has no error of sampling.
    Exact(fn(&Parameters) -> Result<ExactSolution>),
}

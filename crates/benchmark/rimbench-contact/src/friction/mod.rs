//! Contact problems with Coulomb friction, in the plane here, in space in [`space`]: `w = H P + b`, contact by contact
//! open, sticking or sliding.
//!
//! ```text
//! 0 ≤ w_n ⟂ P_n ≥ 0        |P_t| ≤ μ P_n,  w_t P_t = −μ P_n |w_t|
//! ```
//! In the plane the law is exact: a contact can do four things, and once it is known which, all is linear. `H` is
//! symmetric positive semidefinite, the law is not: sliding makes the equations unsymmetric, and beyond a coefficient
//! that depends on the geometry there may be several solutions, or none (Painlevé). Velocities and the resultant are
//! then compared, never single impulses.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | `H` | `[H_nn H_nt; H_tn H_tt]`, 2n×2n, all normal rows before all tangential ones | 1/kg |
//! | `b` | velocities without contact impulse; normal rows with their gap term | m/s |
//! | `P`, `w` | impulses, velocities after them | N·s, m/s |
//! | `μ` | coefficient of friction, one per contact | – |
//! | `E_σ`, `F_σ` | rows that stand still, columns that push, for a combination σ of states; see [`StateSystem`] | |
//! | `r` | [natural residual](crate::problem::ContactProblem::natural_residual) | |
//!
//! A coefficient at rest above that in motion is [`Stiction`]: each problem has the one of the two that its history
//! says.
//!
//! Methods propose, the natural residual decides: [`FrictionSolver`] asks the warm active set first, then the others.
//!
//! | method | starts from | for |
//! |---|---|---|
//! | [`ActiveStates`] | the states of the last problem | almost every problem of a simulation |
//! | [`Enumeration`] | nothing | up to five contacts; all solutions |
//! | [`CopositiveLemke`] | nothing | any number; ends with a solution unless a jam loads itself |
//! | [`ContactSweeps`] | nothing | any number; one contact after the other |

mod active_states;
mod contact_state;
mod contact_sweeps;
mod copositive_lemke;
mod enumeration;
mod problem;
mod solver;
pub mod space;
mod state_system;
mod stiction;

pub use active_states::ActiveStates;
pub use contact_state::ContactState;
pub use contact_sweeps::ContactSweeps;
pub use copositive_lemke::CopositiveLemke;
pub use enumeration::{ENUMERATION_LIMIT, Enumeration, FrictionSolution};
pub use problem::FrictionProblem;
pub use solver::{ColdMethods, FrictionSolver, WarmStates};
pub use state_system::StateSystem;
pub use stiction::Stiction;

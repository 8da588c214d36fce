//! The contact problem `w⁺ = H P + b`, `K ∋ P ⟂ w⁺ + s ∈ K*` ([`Cone`]): operator H, right-hand side b, cone K, and the
//! natural residual.

mod cone;
mod contact_problem;
mod delassus;
mod unsolved;

pub(crate) use cone::norm;
pub use cone::{Cone, Coulomb, Signorini};
pub use contact_problem::ContactProblem;
pub use delassus::{DelassusOperator, DenseDelassus};
pub use unsolved::Unsolved;

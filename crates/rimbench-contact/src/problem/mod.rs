//! The contact problem `w⁺ = H P + b`, `K ∋ P ⟂ w⁺ ∈ K*`: an operator H, a right-hand side, a cone K, and the one measure of an answer.

mod cone;
mod contact_problem;
mod delassus;
mod unsolved;

pub use cone::{Cone, Coulomb, Signorini};
pub use contact_problem::ContactProblem;
pub use delassus::{DelassusOperator, DenseDelassus};
pub use unsolved::Unsolved;

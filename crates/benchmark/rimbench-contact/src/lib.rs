//! Fast, checked solutions of many small contact problems, each close to the last one.
//!
//! ```text
//! w⁺ = H P + b        K ∋ P ⟂ w⁺ + s ∈ K*        s_n = μ |w_t⁺| with friction, otherwise 0
//! ```
//! `H` is the Delassus operator `A M⁻¹ Aᵀ` (1/kg), `b` the velocity without contact impulses, plus the term of the
//! contact law (m/s), `P` the impulses (N·s), s De Saxcé's correction, and K the cone of the impulses: `P ≥ 0`
//! (Signorini), or `|P_t| ≤ μ P_n` (Coulomb, in the plane or in space). In a reduced interface model this is Eq. 4 of
//! Raoofian, Kövecses, Teichmann: `H = H_uu`, `P = h λ_u⁺`.
//!
//! ```
//! use rimbench_contact::complementarity::{ComplementaritySolver, Lcp, Unsolved};
//! use rimbench_contact::solver_entry::SolverEntry;
//!
//! fn main() -> Result<(), Unsolved> {
//!     // A box of 1 kg and 0.1 kg·m² on two corners, 0.5 m left and right of its centre: H = A M⁻¹ Aᵀ over their normal rows.
//!     let h = [3.5, -1.5, -1.5, 3.5];
//!     let mut solver = SolverEntry::active_set().checked(2);
//!     let mut impulses = [0.0; 2];
//!     for step in 0..1000 {
//!         // Velocities after 1 ms without contacts: gravity, and a torque that lifts the left corner in the end.
//!         let (fall, turn) = (-9.81e-3, 1e-4 * f64::from(step));
//!         let b = [fall + 0.5 * turn, fall - 0.5 * turn];
//!         let stats = solver.solve(Lcp::new(&h, &b), &mut impulses)?;
//!         assert!(stats.residual <= solver.tolerance());
//!     }
//!     assert!(impulses[0] == 0.0 && impulses[1] > 0.0);
//!     assert_eq!(solver.counters().failures, 0);
//!     Ok(())
//! }
//! ```
//!
//! | module | content |
//! |---|---|
//! | [`problem`] | the contact problem: Delassus operator, cone, natural residual |
//! | [`complementarity`] | problems without friction: solvers that start from the last active set, the check |
//! | [`friction`] | problems with Coulomb friction: in the plane solvers that start from the last states, in [space](friction::space) from the last impulses |
//! | [`contact_law`] | gap term, impact and compliance: the parts of `b` and of the diagonal of `H` that a contact law gives |
//! | [`known_problems`] | problems with their answers, for any solver |
//! | [`solver_entry`] | solvers by name, with the check and the fallback that belong to each |
//! | [`affine_step`] | steps without a solve, as long as the active set stays |
//! | [`linear_algebra`] | factors of active sets, dense and by pattern |
//!
//! Nothing is allocated after construction, and no file, clock or thread is used.

mod known_size;

pub mod affine_step;
pub mod complementarity;
pub mod contact_law;
pub mod friction;
pub mod known_problems;
pub mod linear_algebra;
pub mod problem;
pub mod solver_entry;

/// Hash of the sources of this crate, made when it was built.
pub const SOURCES: &str = env!("RIMBENCH_CONTACT_SOURCES");

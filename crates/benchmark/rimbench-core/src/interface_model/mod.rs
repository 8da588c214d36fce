//! The reduced interface model: a mechanical system as seen through its interface (paper Eqs. 3 and 4).
//!
//! The steps are those of the paper: [`Linearisation`] holds Eq. 3 at one state, [`Elimination`]
//! removes velocities and bilateral impulses, [`ReducedInterfaceModel`] is what is left (Eq. 4), and [`condense`]
//! turns a set of contacts into bilateral constraints, which gives the effective mass.
//!
//! | symbol | shape | unit | meaning |
//! |---|---|---|---|
//! | `M` | n×n | kg, kg·m² | mass matrix |
//! | `A_b`, `A_u`, `A_i` | n_x×n | – | Jacobians of bilateral, unilateral, interface rows |
//! | `f` | n | N, N·m | applied forces minus Coriolis and centrifugal terms, `f_a − c` |
//! | `S` | n_b×n_b | 1/kg | `A_b M⁻¹ A_bᵀ` |
//! | `G` | n×n | 1/kg | `M⁻¹ − M⁻¹ A_bᵀ S⁻¹ A_b M⁻¹` |
//! | `H_xy` | n_x×n_y | 1/kg | `A_x G A_yᵀ`, `x, y ∈ {u, i}` |
//! | `a_x` | n_x | m/s² | free acceleration of the rows `x` |
//! | `w_x` | n_x | m/s | velocity of the rows `x` |
//! | `g` | n_u | m | gaps |
//! | `P_u` | n_u | N·s | contact impulses, `h λ_u⁺` in the paper |
//! | `A_t`, `P_t` | n_u×n, n_u | –, N·s | tangential rows and impulses, where there is friction |
//! | `λ_i` | n_i | N | interface forces |

/// Memory that mechanics or scheme of one run may need, bytes. Several run side by side, so that this is not what a
/// machine has.
pub const MEMORY_LIMIT: u64 = 4 << 30;

mod belief;
mod condensation;
mod contact_modes;
mod correlation;
mod delassus_products;
mod elimination;
mod frictional_condensation;
mod independent_rows;
mod linearisation;
mod local_elimination;
mod reduced_interface_model;

pub use belief::Belief;
pub(crate) use condensation::rank_of_normal_rows;
pub(crate) use condensation::smallest_eigenvalue;
pub use condensation::{Condensation, condense, condense_in_modes};
pub use contact_modes::ContactModes;
pub(crate) use contact_modes::closed_in_space;
pub(crate) use correlation::Correlation;
pub use correlation::InterfaceCorrelation;
pub use elimination::Elimination;
pub use independent_rows::IndependentRows;
pub use linearisation::{Linearisation, MassMatrix, MatrixForm, Rows};
pub use reduced_interface_model::{ReducedInterfaceModel, RowTarget, TOUCHING};

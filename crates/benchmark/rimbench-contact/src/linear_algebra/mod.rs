//! Linear algebra of contacts: no allocation after construction, plain loops where matrices are small, faer above, and
//! where most contacts are not coupled only what is not zero.
//!
//! | type | what it does |
//! |---|---|
//! | [`Cholesky`] | `A = L Lᵀ` at once, in place |
//! | [`Factor`] | `M_AA = L D Lᵀ` for a set of indices that grows and shrinks by one |
//! | [`Lu`] | one dense system with row pivoting |
//! | [`LowRank`] | `A = L Lᵀ` with as many columns as A has rank |
//! | [`SparseRows`] | the entries of a matrix that are not zero, for many products |
//! | [`SymmetricRows`] | a symmetric matrix whose zeros are known beforehand |
//! | [`SparseFactor`] | `M_AA = L D Lᵀ` of such a matrix, for a set of rows that enter and leave |
//! | [`Buffer`] | storage inside its owner while it is short |
//! | [`dot`], [`body_dot`] | inner products of long rows, and of the few numbers of two bodies |

mod buffer;
mod cholesky;
mod dot;
mod factor;
mod low_rank;
mod lu;
mod sparse_factor;
mod sparse_rows;
mod symmetric_rows;

pub use buffer::Buffer;
pub use cholesky::DEPENDENT;
pub use cholesky::{Cholesky, Singular};
pub(crate) use cholesky::{factor_lower, solve_lower};
pub use dot::{body_dot, dot};
pub use factor::Factor;
pub use low_rank::LowRank;
pub use lu::Lu;
pub use lu::largest_entry;
pub(crate) use lu::{eliminate_by_rows, eliminate_few};
pub use sparse_factor::SparseFactor;
pub use sparse_rows::SparseRows;
pub use symmetric_rows::{EliminationOrder, SymmetricPattern, SymmetricRows};

//! Dense linear algebra for tiny to moderate sizes: no allocation after construction, plain loops where matrices are small,
//! faer above.
//!
//! | type | what it does |
//! |---|---|
//! | [`Cholesky`] | `A = L Lᵀ` at once, in place |
//! | [`Factor`] | `M_AA = L D Lᵀ` for a set of indices that grows and shrinks by one |
//! | [`Lu`] | one dense system with row pivoting |
//! | [`SparseRows`] | the entries of a matrix that are not zero, for many products |
//! | [`Buffer`] | storage inside its owner while it is short |
//! | [`dot`] | inner product with independent partial sums |

mod buffer;
mod cholesky;
mod dot;
mod factor;
mod lu;
mod sparse_rows;

pub use buffer::Buffer;
pub use cholesky::Cholesky;
pub use dot::dot;
pub use factor::Factor;
pub use lu::Lu;
pub use sparse_rows::SparseRows;

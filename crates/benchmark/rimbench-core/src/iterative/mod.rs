//! Drivers that real-time schemes are held against: macro steps repeated until both sides agree, or both sides in one
//! loop. They take steps on copies, beside the loop of [`cosim`](crate::cosim), which knows nothing of them; they use
//! its exchange and its way through a macro step.

mod copied_pair;
mod driver;
mod iteration;
mod monolithic;
mod relaxation;

pub use driver::IterativeDriver;
pub use iteration::Iteration;

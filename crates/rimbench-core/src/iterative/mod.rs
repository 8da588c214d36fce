//! Drivers that real-time schemes are held against: macro steps repeated until both sides agree, tried whole and in halves, or both sides
//! in one loop. They take steps on copies, beside the loop of [`cosim`](crate::cosim), which knows nothing of them; they use its
//! exchange and its way through a macro step.

mod copied_pair;
mod driver;
mod iteration;
mod monolithic;
mod relaxation;
mod step_doubling;
mod waveform;

pub use driver::{IterativeDriver, StepDoubling};
pub use iteration::Iteration;
pub use waveform::Waveform;

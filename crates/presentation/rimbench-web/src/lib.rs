//! The numerics of rimbench for a page: text in, columns of numbers out.
//!
//! A run is asked for in the words of an experiment file, one option a line, and simulated and evaluated by the very
//! code of the program. [`Simulator`] is that; [`boundary`] is what a page calls of the module that this crate becomes
//! for `wasm32-unknown-unknown`. There is no clock, no file and no thread here.

pub mod boundary;
mod gallery;
mod simulator;

pub use simulator::{Answer, COARSER, Simulator};

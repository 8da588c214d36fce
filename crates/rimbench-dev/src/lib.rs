//! What those who develop rimbench need and its users do not: the performance tracker.

pub mod perf;

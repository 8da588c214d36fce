//! What those who develop rimbench need and its users do not: the performance tracker, the corpus of contact problems, and the
//! panel of rival solvers.
//!
//! | room | what it holds |
//! |---|---|
//! | [`perf`] | a fixed suite of work, its history, and what counts as a regression |
//! | [`corpus`] | contact problems of actual runs, and what solvers make of them |
//! | [`panel`] | the solvers that the default is held against |

pub mod corpus;
pub mod panel;
pub mod perf;

//! Has the program become slower? A fixed suite, its history, and a comparison that does not depend on luck.
//!
//! | number | depends on | compared |
//! |---|---|---|
//! | work counters ([`COUNTERS`]) | the code | exactly |
//! | instructions, by callgrind | code, target, compiler and its settings, libraries | with a fence as wide as a repetition scatters |

mod benchmark;
mod comparison;
mod history;
mod kernels;
mod measuring;
mod revision;
mod suite;

pub use benchmark::{Benchmark, Repetition, Work};
pub use comparison::{Comparison, Finding, REBUILT, REPEATED, Verdict, compare, fence_of};
pub use history::{COUNTERS, History, Row};
pub use measuring::{ChangedFunction, changed_functions, find_valgrind, measure, record};
pub use revision::{Build, compare_revisions};
pub use suite::BENCHMARKS;

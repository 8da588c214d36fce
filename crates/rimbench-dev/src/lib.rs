//! Has the program become slower? A fixed suite, its history, and decisions that do not depend on luck.
//!
//! | number | depends on | compared |
//! |---|---|---|
//! | work counters ([`COUNTERS`]) | the code | exactly |
//! | instructions, by callgrind | code, target, compiler, libraries | with a fence as wide as a repetition scatters ([`Fence`]) |
//! | wall time | everything | of two revisions measured in turn, as a ratio with an interval, confirmed |
//!
//! | file | concept |
//! |---|---|
//! | `benchmark`, `suite`, `kernels` | what is measured, with the answer each benchmark must give |
//! | `measuring` | one measurement by a program, in a process of its own; rounds of two programs in turn |
//! | `history` | rows of `history.csv` and how they are named |
//! | `comparison` | what is a regression, and what is told about it |
//! | `revision` | a git revision, built in a folder of its own |

mod benchmark;
mod comparison;
mod history;
mod kernels;
mod measuring;
mod revision;
mod suite;

pub use benchmark::{Benchmark, Repetition, Work};
pub use comparison::{Comparison, Fence, Finding, Paired, Verdict, compare};
pub use history::{COUNTERS, History, Row};
pub use measuring::{Instructions, Program, Recording, Round, Sample, measure, measure_rounds};
pub use revision::{Checkout, Repository};
pub use suite::{BENCHMARKS, benchmark_by_name};

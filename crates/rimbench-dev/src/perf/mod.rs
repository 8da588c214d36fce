//! Has the program become slower? A fixed suite, its history, and decisions that do not depend on luck.
//!
//! Three kinds of numbers, by how far they can be trusted:
//!
//! | number | depends on | decided |
//! |---|---|---|
//! | work counters ([`COUNTERS`]) | the code | exactly |
//! | instructions ([`callgrind`]) | code, target, compiler, libraries | against the count before: a millionth more is a regression, of programs built in two folders 0.2 % |
//! | wall time ([`TimeSummary`](rimbench_statistics::TimeSummary)) | everything | as a paired ratio with an interval, confirmed |
//!
//! | file | concept |
//! |---|---|
//! | `benchmark`, `suite`, `kernels` | what is measured, with the answer each benchmark must give |
//! | `fixed_work` | a piece of work that never changes, timed beside every benchmark |
//! | [`callgrind`], `sample` | one measurement by a program, in a process of its own |
//! | `record` | the suite measured in interleaved pairs |
//! | `history` | rows of `history.csv` and how they are named |
//! | `decision`, `comparison`, `comparison_text` | what is a regression; what is told about it |
//! | `revision` | two git revisions, built side by side |

mod benchmark;
pub mod callgrind;
mod comparison;
mod comparison_text;
mod decision;
mod fixed_work;
mod history;
mod kernels;
mod record;
mod revision;
mod sample;
mod suite;

pub use benchmark::{Benchmark, Work};
pub use comparison::{Comparison, Paired, compare_pairs, compare_records};
pub use decision::{Finding, Verdict, decide_counter, decide_instructions, decide_time};
pub use history::{COUNTERS, History, Row};
pub use record::{Plan, Recording, Round, measure_rounds, paired_ratio, placebo_ratio, record};
pub use revision::{Checkout, Repository};
pub use sample::{Program, Sample, measure};
pub use suite::{BENCHMARKS, benchmark_by_name};

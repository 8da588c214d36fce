//! What lets others take part without this program: problems as files, trajectories judged by these files, entries of
//! a ranking.

mod columns;
mod entry;
mod judge;
mod pack;
mod problem;

pub use columns::meaning;
pub(crate) use columns::{DATA_PACKAGE, describe};
pub use entry::{Division, ENTRY, Entry, Evidence, Packs};
pub use judge::{Judged, SCORES, judge};
pub use pack::pack_files;
pub use problem::{Problem, ProblemRow};

//! FMUs of others, and programs of their own, as the sides of a case.
//!
//! ```text
//! case file ─► archive ─► description ─► checks ─► Case
//!                                                    │ builds, for each run
//!                                   ImportedSide ─► Host: in a process of its own, or in this one ─► library
//! ```

mod archive;
mod case_file;
mod description;
mod host;
mod library;
mod like_case;
mod probing;
#[cfg(unix)]
mod process;
#[cfg(not(unix))]
#[path = "no_process.rs"]
mod process;
mod program_member;
mod side;

pub(crate) use case_file::can_name_a_column;
pub use case_file::read_case;
pub(crate) use host::{Ask, Host};
pub use probing::{ProbeQuality, take_probe_errors};
pub use process::{WORKER, serve};
pub(crate) use side::{ImportedSide, Offers};

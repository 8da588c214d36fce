//! FMUs of others as the sides of a case.
//!
//! ```text
//! case file ─► archive ─► description ─► checks ─► Case
//!                                                    │ builds, for each run
//!                                   ImportedSide ─► Host: in a process of its own, or in this one ─► library
//! ```

mod archive;
mod attributes;
mod case;
mod case_file;
mod description;
mod finder;
mod group;
mod host;
mod library;
mod master;
mod member;
mod probing;
#[cfg(unix)]
mod process;
#[cfg(not(unix))]
#[path = "no_process.rs"]
mod process;
mod python;
mod scheme;
mod side;

pub use case::{Programs, read_case};
pub use library::{leave, standard_output};
pub use master::master_script;
pub use probing::{ProbeQuality, SideNotes};
pub use process::{WORKER, serve};
pub use scheme::read_scheme;

//! Result files: written whole or not at all, read back by column name, checked to be as they were written.

pub mod atomic_file;
pub mod budget;
pub mod checksums;
pub mod claims;
pub mod input;
pub mod kept;
pub mod results_table;
pub mod run_table;
pub mod selection;
pub mod text_place;
pub mod trace;

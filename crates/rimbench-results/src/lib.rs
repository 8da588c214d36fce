//! Result files: written whole or not at all, read back by column name.

pub mod atomic_file;
pub mod results_table;

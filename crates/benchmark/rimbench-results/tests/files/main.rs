//! Files that are kept, how files are written and read, and rows of runs.

mod budget;
mod files;
mod kept;
mod runs;

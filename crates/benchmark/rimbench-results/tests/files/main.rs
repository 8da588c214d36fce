//! Claims, files that are kept, how files are written and read, and rows of runs.

mod budget;
mod claims;
mod files;
mod kept;
mod runs;

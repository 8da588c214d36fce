//! Files that are kept, and how files are written and read.

mod files;
mod kept;

//! The version of everything that a digit can depend on.

/// Part of the key of every stored result. A golden test compares results digit by digit and forces
/// this number to be raised when they change.
pub const NUMERICS_VERSION: u32 = 17;

//! Where there are no such sockets, FMUs run in this process.

use super::host::{Ask, Host, Plan};
use rimbench_core::error::{Error, Result};
use std::path::Path;
use std::time::Duration;

/// The hidden command by which the program is a worker.
pub const WORKER: &str = "fmu-worker";

const NEEDS_UNIX: &str = "processes of their own need a Unix; say `process = \"same\"`";

/// What there is not.
pub(super) enum Remote {}

impl Remote {
    pub(super) fn start(_: &Plan, _: &Path, _: Duration) -> Result<Self, String> {
        Err(NEEDS_UNIX.to_owned())
    }
}

impl Host for Remote {
    fn ask(&mut self, _: Ask, _: u32, _: &[f64], _: &mut Vec<f64>) -> Result<(), String> {
        match *self {}
    }
}

/// Is no worker here.
///
/// # Errors
/// Always.
pub fn serve() -> Result<()> {
    Err(Error::Incompatible(NEEDS_UNIX.to_owned()))
}

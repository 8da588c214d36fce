//! Where there are no such sockets, FMUs run in this process.

use super::host::{Ask, Host, Plan};
use rimbench_core::error::{Error, Result};
use std::path::PathBuf;
use std::time::Duration;

/// The hidden command by which the program is a worker.
pub const WORKER: &str = "fmu-worker";

const NEEDS_UNIX: &str = "processes of their own need a Unix; say `process = \"same\"`";

/// What there is not.
pub(super) enum Remote {}

impl Remote {
    pub(super) fn start(_: &Plan, _: &[PathBuf], _: Duration) -> Result<Self, String> {
        Err(NEEDS_UNIX.to_owned())
    }
}

impl Remote {
    pub(super) fn started(_: &[u8], _: &str, _: &[PathBuf], _: Duration, _: bool) -> Result<Self, String> {
        Err("sides of Python need a Unix".to_owned())
    }
}

impl Remote {
    pub(super) fn answers_within(self, _: Duration) -> Result<Self, String> {
        match self {}
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

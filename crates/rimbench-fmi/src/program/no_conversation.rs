//! Where there are no pipes that can be waited for, there are no programs.

use super::command_line::CommandLine;
use super::messages::{Reply, Request, Role};
use serde::de::DeserializeOwned;

/// What there is not.
pub(super) enum Conversation {}

impl Conversation {
    pub(super) fn start(command: &CommandLine) -> Result<Self, String> {
        Err(format!("`{command}` cannot be started: programs of their own need a Unix"))
    }

    pub(super) fn hello<D: DeserializeOwned>(&mut self, _: Role, _: &Request<'_>) -> Result<D, String> {
        match *self {}
    }

    pub(super) fn ask<T>(&mut self, _: &Request<'_>, _: impl FnOnce(Reply) -> Result<T, String>) -> Result<T, String> {
        match *self {}
    }
}

/// There are none to end.
pub fn end_programs() {}

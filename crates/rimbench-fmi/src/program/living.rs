//! Programs that are running, so that none is left behind when this program leaves without taking leave of them.

use rustix::process::{Pid, Signal, kill_process_group};
use std::collections::BTreeSet;
use std::process::Child;
use std::sync::{Mutex, PoisonError};

struct Running {
    /// Process groups, by their first process.
    groups: BTreeSet<i32>,
    /// Whether this program is about to leave.
    over: bool,
}

static RUNNING: Mutex<Running> = Mutex::new(Running { groups: BTreeSet::new(), over: false });

/// A process with a group of its own that is to end with this program.
#[derive(Debug)]
pub(super) struct Living(i32);

impl Living {
    /// Takes a process that has just been started, until this is dropped.
    pub(super) fn of(child: &Child) -> Self {
        let group = child.id() as i32;
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        running.groups.insert(group);
        if running.over {
            end(group);
        }
        Living(group)
    }
}

impl Drop for Living {
    fn drop(&mut self) {
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).groups.remove(&self.0);
    }
}

fn end(group: i32) {
    if let Some(group) = Pid::from_raw(group) {
        let _ = kill_process_group(group, Signal::KILL);
    }
}

/// Ends all programs that cases and schemes have started, with what they have started, for somebody who is about to leave this program:
/// whoever waits for an answer of theirs waits for ever from now on, so that their end is no outcome of a run.
pub fn end_programs() {
    let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    running.over = true;
    running.groups.iter().copied().for_each(end);
}

/// Does not return if this program is about to leave.
pub(super) fn wait_if_over() {
    let over = RUNNING.lock().unwrap_or_else(PoisonError::into_inner).over;
    if over {
        loop {
            std::thread::park();
        }
    }
}

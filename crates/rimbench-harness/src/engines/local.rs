//! Processes of this machine: one command per chunk, as many at once as there are cores for.

use super::{Order, Submission};
use std::thread::available_parallelism;

/// The chunks as commands; what is timed runs one after the other.
pub(super) fn submission(order: &Order<'_>) -> Submission {
    let cores = available_parallelism().map_or(1, usize::from);
    let usual = if order.exclusive { 1 } else { (cores / order.cpus).max(1) };
    let commands = order.chunks.iter().map(|chunk| order.chunk_command(&chunk.places())).collect();
    Submission { files: Vec::new(), commands, at_once: order.at_once.unwrap_or(usual) }
}

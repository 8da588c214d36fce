//! GNU parallel. Its job log is that of one submission: the same command, given again by hand, goes on where it was interrupted; a new
//! submission asks the records instead.

use super::{Order, Submission, Words, list};

pub(super) const PROGRAM: &str = "parallel";

/// A host that fails a chunk is no reason to give it up.
const RETRIES: usize = 3;

pub(super) fn submission(order: &Order<'_>) -> Submission {
    let chunks = order.place.join("chunks.txt");
    let mut command = Words::of(PROGRAM);
    // Its words are words, not a text for the shell.
    command.flag("--quote");
    command.option("--joblog", order.place.join("joblog").display());
    command.flag("--resume");
    command.option("--retries", RETRIES);
    match order.at_once {
        Some(count) => command.option("--jobs", count),
        None => command.option("--jobs", format!("{}%", (100 / order.cpus).max(1))),
    }
    for host in order.hosts {
        command.option("--sshlogin", host);
    }
    if !order.hosts.is_empty() && order.cache.is_some() {
        command.option("--env", "RIMBENCH_CACHE");
    }
    command.extend(order.extra.iter().cloned());
    command.option("--arg-file", chunks.display());
    command.extend(order.chunk_command("{}").words().iter().cloned());
    Submission { files: vec![(chunks, list(order.chunks))], commands: vec![command], at_once: 1 }
}

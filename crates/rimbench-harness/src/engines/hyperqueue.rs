//! A task array of HyperQueue, which begins a task again when its worker is lost.

use super::{Order, Submission, Words, list};

pub(super) const PROGRAM: &str = "hq";

pub(super) fn submission(order: &Order<'_>) -> Submission {
    let (script, text) = order.script("HQ_TASK_ID");
    let chunks = order.place.join("chunks.txt");
    let mut command = Words::of(PROGRAM);
    command.flag("submit");
    command.joined("--name", format!("rimbench-{}", order.name));
    command.joined("--array", format!("1-{}", order.chunks.len()));
    // All of a worker: nothing else runs beside what is timed.
    let cpus = if order.exclusive { "all".to_owned() } else { order.cpus.to_string() };
    command.joined("--cpus", cpus);
    for stream in ["stdout", "stderr"] {
        command.joined(&format!("--{stream}"), order.place.join(format!("%{{TASK_ID}}.{stream}")).display());
    }
    if let Some(cache) = order.cache {
        // Workers have an environment of their own.
        command.joined("--env", format!("RIMBENCH_CACHE={}", cache.display()));
    }
    command.extend(order.extra.iter().cloned());
    command.extend(["--".to_owned(), "sh".to_owned()]);
    command.extend([&script, &chunks].map(|path| path.display().to_string()));
    Submission { files: vec![(script, text), (chunks, list(order.chunks))], commands: vec![command], at_once: 1 }
}

//! A task array of HyperQueue, which begins a task again when its worker is lost.

use super::{Order, Submission, list, words};

pub(super) const PROGRAM: &str = "hq";

pub(super) fn submission(order: &Order<'_>) -> Submission {
    let (script, text) = order.script("HQ_TASK_ID");
    let chunks = order.place.join("chunks.txt");
    let mut command = words([PROGRAM, "submit"]);
    command.push(format!("--name=rimbench-{}", order.name));
    command.push(format!("--array=1-{}", order.chunks.len()));
    // All of a worker: nothing else runs beside what is timed.
    command.push(if order.exclusive { "--cpus=all".to_owned() } else { format!("--cpus={}", order.cpus) });
    for stream in ["stdout", "stderr"] {
        command.push(format!("--{stream}={}", order.place.join(format!("%{{TASK_ID}}.{stream}")).display()));
    }
    if let Some(cache) = order.cache {
        // Workers have an environment of their own.
        command.push(format!("--env=RIMBENCH_CACHE={}", cache.display()));
    }
    command.extend(order.extra.iter().cloned());
    command.extend(words(["--", "sh"]));
    command.extend([&script, &chunks].map(|path| path.display().to_string()));
    Submission { files: vec![(script, text), (chunks, list(order.chunks))], commands: vec![command] }
}

//! A job array of Slurm, whose jobs go back into the queue when their node fails.

use super::{Order, Submission, list, words};

pub(super) const PROGRAM: &str = "sbatch";

/// Longest array where nobody configured another: `MaxArraySize` is 1001 and no index reaches it.
const LONGEST_ARRAY: usize = 1000;

pub(super) fn submission(order: &Order<'_>) -> Submission {
    let (script, text) = order.script("SLURM_ARRAY_TASK_ID");
    let mut submission = Submission { files: vec![(script.clone(), text)], commands: Vec::new() };
    for (index, part) in order.chunks.chunks(LONGEST_ARRAY).enumerate() {
        let chunks = order.place.join(format!("chunks-{}.txt", index + 1));
        let at_once = order.at_once.map(|count| format!("%{count}")).unwrap_or_default();
        let mut command = words([PROGRAM]);
        command.push(format!("--job-name=rimbench-{}", order.name));
        command.push(format!("--array=1-{}{at_once}", part.len()));
        command.extend(words(["--requeue", "--open-mode=append", "--ntasks=1"]));
        command.push(format!("--cpus-per-task={}", order.cpus));
        if order.exclusive {
            command.extend(words(["--exclusive"]));
        }
        command.push(format!("--output={}", order.place.join("%A-%a.out").display()));
        command.extend(order.extra.iter().cloned());
        command.extend([&script, &chunks].map(|path| path.display().to_string()));
        submission.commands.push(command);
        submission.files.push((chunks, list(part)));
    }
    submission
}

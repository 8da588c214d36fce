//! A job array of Slurm, whose jobs go back into the queue when their node fails.

use super::{Order, Submission, Words, list};

pub(super) const PROGRAM: &str = "sbatch";

/// Longest array where nobody configured another: `MaxArraySize` is 1001 and no index reaches it.
const LONGEST_ARRAY: usize = 1000;

pub(super) fn submission(order: &Order<'_>) -> Submission {
    let (script, text) = order.script("SLURM_ARRAY_TASK_ID");
    let mut submission = Submission { files: vec![(script.clone(), text)], commands: Vec::new(), at_once: 1 };
    for (index, part) in order.chunks.chunks(LONGEST_ARRAY).enumerate() {
        let chunks = order.place.join(format!("chunks-{}.txt", index + 1));
        let mut command = Words::of(PROGRAM);
        command.joined("--job-name", format!("rimbench-{}", order.name));
        let at_once = order.at_once.map(|count| format!("%{count}")).unwrap_or_default();
        command.joined("--array", format!("1-{}{at_once}", part.len()));
        command.flag("--requeue");
        command.joined("--open-mode", "append");
        command.joined("--ntasks", 1);
        command.joined("--cpus-per-task", order.cpus);
        if order.exclusive {
            command.flag("--exclusive");
        }
        command.joined("--output", order.place.join("%A-%a.out").display());
        command.extend(order.extra.iter().cloned());
        command.extend([&script, &chunks].map(|path| path.display().to_string()));
        submission.commands.push(command);
        submission.files.push((chunks, list(part)));
    }
    submission
}

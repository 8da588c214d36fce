//! From what is missing of an experiment to a job array of Slurm, whose jobs go back into the queue when their node
//! fails.
//!
//! [`missing_chunks`] makes chunks that last about as long as asked; a [`Submission`] is what Slurm needs to work
//! through them: files to be written and commands to be given, word by word. A chunk is
//! `rimbench run FILE --places FIRST-LAST`: it computes what of these runs is not stored, so that Slurm may begin it
//! twice, lose it, or begin it again. What is done the records say, never an exit code.

mod chunks;

pub use chunks::{Chunk, ChunkLimits, Chunking, missing_chunks};

use rimbench_core::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Where the submissions of an experiment lie in its results folder, numbered from 1; beside the records, and removed
/// with them.
const SUBMISSIONS: &str = "records/submissions";

/// The program that takes the commands.
pub const SBATCH: &str = "sbatch";

/// Slurm's default for the longest array: `MaxArraySize` is 1001 and no index reaches it.
const LONGEST_ARRAY: usize = 1000;

/// What is to be done, and with what.
#[derive(Debug, Clone)]
pub struct SlurmArray<'a> {
    /// Name of the experiment, for lists of jobs.
    pub name: &'a str,
    /// This program, where the chunks run.
    pub program: &'a Path,
    /// Experiment file, absolute.
    pub file: &'a Path,
    /// Files of cases and schemes that the experiment has from outside, absolute, each behind the option that reads it.
    pub more_files: &'a [(&'static str, PathBuf)],
    /// Results folder, absolute.
    pub folder: &'a Path,
    /// Where the files of the submission go, as [`next_place`] says.
    pub place: &'a Path,
    /// What is to be done.
    pub chunks: &'a [Chunk],
    /// Threads of a chunk.
    pub cpus: usize,
    /// Chunks at once; as many as Slurm likes if absent.
    pub at_once: Option<usize>,
    /// Whether the runs are timed, and each chunk must have its machine alone.
    pub exclusive: bool,
    /// Options for `sbatch`.
    pub extra: &'a [String],
}

impl SlurmArray<'_> {
    /// Says what Slurm needs.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for timed runs that would not be alone; [`Error::File`] for a path that a script or
    /// Slurm would read as another.
    pub fn submission(&self) -> Result<Submission> {
        if self.exclusive && self.cpus != 1 {
            let message = "what is timed runs one after the other: --cpus must be 1".to_owned();
            return Err(Error::Incompatible(message));
        }
        let files = self.more_files.iter().map(|(_, file)| &**file);
        let not_text = [self.program, self.file, self.folder, self.place]
            .into_iter()
            .chain(files)
            .find(|path| path.to_str().is_none());
        if let Some(path) = not_text {
            return Err(Error::file(
                path,
                "is no UTF-8 text, which a script for Slurm is; valid: a path of another name",
            ));
        }
        let place = self.place.display().to_string();
        if place.contains('\\') {
            let message = "has a backslash, behind which Slurm numbers no output; valid: a path without one";
            return Err(Error::file(self.place, message));
        }
        // Of the folder % stands for itself.
        let output = Path::new(&place.replace('%', "%%")).join("%A-%a.out").display().to_string();
        let (script, text) = self.script();
        let mut submission = Submission { files: vec![(script.clone(), text)], commands: Vec::new() };
        for (index, part) in self.chunks.chunks(LONGEST_ARRAY).enumerate() {
            let chunks = self.place.join(format!("chunks-{}.txt", index + 1));
            let at_once = self.at_once.map(|count| format!("%{count}")).unwrap_or_default();
            let mut command = words([SBATCH]);
            command.push(format!("--job-name=rimbench-{}", self.name));
            command.push(format!("--array=1-{}{at_once}", part.len()));
            command.extend(words(["--requeue", "--open-mode=append", "--ntasks=1"]));
            command.push(format!("--cpus-per-task={}", self.cpus));
            if self.exclusive {
                command.extend(words(["--exclusive"]));
            }
            command.push(format!("--output={output}"));
            command.extend(self.extra.iter().cloned());
            command.extend([&script, &chunks].map(|path| path.display().to_string()));
            submission.commands.push(command);
            submission.files.push((chunks, list(part)));
        }
        Ok(submission)
    }

    /// The command that runs some places of the plan.
    fn chunk_command(&self, places: &str) -> Vec<String> {
        let shown = |path: &Path| path.display().to_string();
        let mut command = vec![shown(self.program), "run".to_owned(), shown(self.file)];
        self.more_files.iter().for_each(|(option, file)| command.extend([(*option).to_owned(), shown(file)]));
        command.extend(["--out".to_owned(), shown(self.folder), "--jobs".to_owned(), self.cpus.to_string()]);
        command.extend(words(["--places", places]));
        command
    }

    /// A script that runs the chunk whose number Slurm says, from a list that is its argument.
    fn script(&self) -> (PathBuf, String) {
        let command = in_shell(&self.chunk_command("$places"));
        // The one word that the shell has to fill in.
        let command = command.replace("'$places'", "\"$places\"");
        let text = format!(
            "#!/bin/sh\n# SLURM_ARRAY_TASK_ID counts the lines of the list from 1.\n\
             places=$(sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" \"$1\") && exec {command}\n"
        );
        (self.place.join("chunk.sh"), text)
    }
}

/// The places of chunks, one line each.
fn list(chunks: &[Chunk]) -> String {
    chunks.iter().map(|chunk| format!("{}\n", chunk.places())).collect()
}

/// What Slurm needs: files, then commands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Submission {
    /// Files with their contents.
    pub files: Vec<(PathBuf, String)>,
    /// Commands, word by word, to be given in this order.
    pub commands: Vec<Vec<String>>,
}

fn words<const N: usize>(words: [&str; N]) -> Vec<String> {
    words.map(str::to_owned).into()
}

/// Writes a command as a shell reads it.
pub fn in_shell(words: &[String]) -> String {
    // No argument of a process has the one character that cannot be quoted.
    shlex::try_join(words.iter().map(String::as_str)).unwrap_or_else(|_| words.join(" "))
}

/// Says where the files of the next submission of a results folder would go.
pub fn next_place(folder: &Path) -> PathBuf {
    let submissions = folder.join(SUBMISSIONS);
    let known = std::fs::read_dir(&submissions).into_iter().flatten();
    let numbers = known.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse::<u32>().ok());
    submissions.join((numbers.max().unwrap_or(0) + 1).to_string())
}

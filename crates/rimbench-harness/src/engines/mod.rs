//! From what is missing of an experiment to commands of the engines that people operate.
//!
//! [`missing_chunks`] makes chunks that last about as long as asked; a [`Submission`] is what one engine needs to work through them:
//! files to be written and commands to be given, word by word. A chunk is `rimbench run FILE --places FIRST-LAST`: it computes what of
//! these runs is not stored, so that an engine may begin it twice, lose it, or begin it again. What is done the records say, never an
//! exit code. The drivers know nothing but the command line of their engine.

mod chunks;
mod hyperqueue;
mod slurm;

pub use chunks::{Chunk, ChunkLimits, Chunking, missing_chunks};

use rimbench_core::error::{Error, Result};
use rimbench_core::name::by_name;
use std::path::{Path, PathBuf};

/// Where the submissions of an experiment lie in its results folder, numbered from 1; beside the records, and removed with them.
const SUBMISSIONS: &str = "records/submissions";

/// An engine that works through chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    /// A job array of Slurm.
    Slurm,
    /// A task array of HyperQueue.
    HyperQueue,
}

by_name!(Engine, NAMES, "engine");

impl Engine {
    /// All of them, with their names.
    pub const NAMES: [(&'static str, Self); 2] = [("slurm", Engine::Slurm), ("hyperqueue", Engine::HyperQueue)];

    /// Returns the program that takes its commands.
    pub fn program(self) -> &'static str {
        match self {
            Engine::Slurm => slurm::PROGRAM,
            Engine::HyperQueue => hyperqueue::PROGRAM,
        }
    }

    /// Says what the engine needs for an order.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for timed runs that would not be alone.
    pub fn submission(self, order: &Order<'_>) -> Result<Submission> {
        if order.exclusive && order.cpus != 1 {
            let message = format!("engine {self} runs what is timed one after the other: --cpus must be 1");
            return Err(Error::Incompatible(message));
        }
        Ok(match self {
            Engine::Slurm => slurm::submission(order),
            Engine::HyperQueue => hyperqueue::submission(order),
        })
    }
}

/// What is to be done, and with what.
#[derive(Debug, Clone)]
pub struct Order<'a> {
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
    /// Folder of the cache of references, if it is not where each machine has it.
    pub cache: Option<&'a Path>,
    /// What is to be done.
    pub chunks: &'a [Chunk],
    /// Threads of a chunk.
    pub cpus: usize,
    /// Chunks at once; as many as the engine likes if absent.
    pub at_once: Option<usize>,
    /// Whether the runs are timed, and each chunk must have its machine alone.
    pub exclusive: bool,
    /// Options for the engine's own program.
    pub extra: &'a [String],
}

impl Order<'_> {
    /// The command that runs some places of the plan.
    fn chunk_command(&self, places: &str) -> Vec<String> {
        let shown = |path: &Path| path.display().to_string();
        let mut command = vec![shown(self.program), "run".to_owned(), shown(self.file)];
        self.more_files.iter().for_each(|(option, file)| command.extend([(*option).to_owned(), shown(file)]));
        command.extend(["--out".to_owned(), shown(self.folder), "--jobs".to_owned(), self.cpus.to_string()]);
        command.extend(words(["--places", places]));
        command
    }

    /// A script that runs the chunk whose number an environment variable holds, from a list that is its argument.
    fn script(&self, variable: &str) -> (PathBuf, String) {
        let command = in_shell(&self.chunk_command("$places"));
        // The one word that the shell has to fill in.
        let command = command.replace("'$places'", "\"$places\"");
        let text = format!(
            "#!/bin/sh\n# {variable} counts the lines of the list from 1.\nplaces=$(sed -n \"${{{variable}}}p\" \"$1\") && exec {command}\n"
        );
        (self.place.join("chunk.sh"), text)
    }
}

/// The places of chunks, one line each.
fn list(chunks: &[Chunk]) -> String {
    chunks.iter().map(|chunk| format!("{}\n", chunk.places())).collect()
}

/// What an engine needs: files, then commands.
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

#[cfg(test)]
mod tests {
    use super::*;

    const CHUNKS: [Chunk; 3] = [
        Chunk { first: 0, last: 99, runs: 100, seconds: 60.0 },
        Chunk { first: 100, last: 100, runs: 1, seconds: 90.0 },
        Chunk { first: 105, last: 2000, runs: 3, seconds: 1.0 },
    ];

    fn order(chunks: &[Chunk]) -> Order<'_> {
        Order {
            name: "cost",
            program: Path::new("/opt/rim bench/rimbench"),
            file: Path::new("/data/it's/cost.toml"),
            more_files: &[],
            folder: Path::new("/data/results/cost"),
            place: Path::new("/data/results/cost/records/submissions/1"),
            cache: None,
            chunks,
            cpus: 1,
            at_once: None,
            exclusive: false,
            extra: &[],
        }
    }

    #[test]
    fn timed_runs_are_alone() {
        let timed = || Order { exclusive: true, ..order(&CHUNKS) };
        let said = |engine: Engine| in_shell(&engine.submission(&timed()).unwrap().commands[0]);
        assert!(said(Engine::Slurm).contains(" --exclusive "));
        assert!(said(Engine::HyperQueue).contains(" '--cpus=all' "));
        for (name, engine) in Engine::NAMES {
            assert_eq!(name.parse::<Engine>().unwrap(), engine);
            let refused = engine.submission(&Order { cpus: 2, ..timed() }).unwrap_err().to_string();
            assert!(refused.contains("--cpus must be 1"), "{refused}");
        }
        assert!("slrum".parse::<Engine>().unwrap_err().to_string().contains("did you mean `slurm`"));
    }

    #[test]
    fn an_array_of_slurm_is_no_longer_than_slurm_allows() {
        let many: Vec<Chunk> =
            (0..2500).map(|place| Chunk { first: place, last: place, runs: 1, seconds: 60.0 }).collect();
        let submission = Engine::Slurm.submission(&order(&many)).unwrap();
        let lists: Vec<usize> = submission.files.iter().skip(1).map(|(_, text)| text.lines().count()).collect();
        assert_eq!(lists, [1000, 1000, 500]);
        let arrays = &submission.commands;
        assert!(arrays[0].contains(&"--array=1-1000".to_owned()) && arrays[2].contains(&"--array=1-500".to_owned()));
        assert!(arrays[2].last().unwrap().ends_with("chunks-3.txt"), "{arrays:?}");
        let all: String = submission.files[1..].iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(all, list(&many));
    }

    #[test]
    #[cfg(unix)]
    fn a_shell_reads_the_words_that_were_written() {
        for word in ["plain", "", "two words", "it's", "$HOME", "a\"b", "back\\slash", "{}", "*", "ö"] {
            let mut shell = std::process::Command::new("sh");
            let output = shell.args(["-c", &in_shell(&words(["printf", "%s", word]))]).output().unwrap();
            assert_eq!(String::from_utf8_lossy(&output.stdout), word);
        }
    }

    #[test]
    #[cfg(unix)]
    fn the_script_runs_the_line_that_the_engine_counts() {
        let folder = tempfile::tempdir().unwrap();
        let mut order = order(&CHUNKS);
        order.program = Path::new("/bin/echo");
        let (_, script) = order.script("TASK");
        let chunks = folder.path().join("chunks.txt");
        std::fs::write(&chunks, list(&CHUNKS)).unwrap();
        let mut shell = std::process::Command::new("sh");
        let output = shell.args(["-c", &script, "sh"]).arg(&chunks).env("TASK", "2").output().unwrap();
        let said = "run /data/it's/cost.toml --out /data/results/cost --jobs 1 --places 100-100\n";
        assert_eq!(String::from_utf8_lossy(&output.stdout), said);
    }

    #[test]
    fn every_engine_hands_the_files_of_cases_on_to_its_tasks() {
        let files = [("--case-file", "/data/my truck.toml"), ("--case-file", "/data/other.toml")];
        let more_files = files.map(|(option, file)| (option, PathBuf::from(file)));
        let wanted = " --case-file '/data/my truck.toml' --case-file /data/other.toml --out /data/results/cost ";
        for (name, engine) in Engine::NAMES {
            let submission = engine.submission(&Order { more_files: &more_files, ..order(&CHUNKS) }).unwrap();
            let commands = submission.commands.iter().map(|command| in_shell(command));
            let all: String = submission.files.iter().map(|(_, text)| text.clone()).chain(commands).collect();
            assert!(all.contains(wanted), "{name}: {all}");
        }
    }

    #[test]
    fn a_submission_gets_the_next_number() {
        let folder = tempfile::tempdir().unwrap();
        assert!(next_place(folder.path()).ends_with("records/submissions/1"));
        for name in ["2", "10", "notes"] {
            std::fs::create_dir_all(folder.path().join(SUBMISSIONS).join(name)).unwrap();
        }
        assert!(next_place(folder.path()).ends_with("records/submissions/11"));
    }
}

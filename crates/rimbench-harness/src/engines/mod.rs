//! From what is missing of an experiment to commands of the engines that people operate.
//!
//! [`missing_chunks`] makes chunks that last about as long as asked; a [`Submission`] is what one engine needs to work through them:
//! files to be written and commands to be given, word by word. A chunk is `rimbench run FILE --places FIRST-LAST`: it computes what of
//! these runs is not stored, so that an engine may begin it twice, lose it, or begin it again. What is done the records say, never an
//! exit code. The drivers know nothing but the command line of their engine.

mod chunks;
mod hyperqueue;
mod local;
mod parallel;
mod slurm;
mod words;

pub use chunks::{Chunk, ChunkLimits, Chunking, missing_chunks};
pub use words::Words;

use rimbench_core::error::{Error, Result};
use rimbench_core::name::by_name;
use std::path::{Path, PathBuf};

/// Where the submissions of an experiment lie in its results folder, numbered from 1; beside the records, and removed with them.
const SUBMISSIONS: &str = "records/submissions";

/// An engine that works through chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    /// Processes of this machine, started by this program.
    Local,
    /// GNU parallel, here or over hosts that share the file system.
    Parallel,
    /// A job array of Slurm.
    Slurm,
    /// A task array of HyperQueue.
    HyperQueue,
}

by_name!(Engine, NAMES, "engine");

impl Engine {
    /// All of them, with their names.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("local", Engine::Local),
        ("parallel", Engine::Parallel),
        ("slurm", Engine::Slurm),
        ("hyperqueue", Engine::HyperQueue),
    ];

    /// Returns the program that takes its commands; none for the processes that this program starts itself.
    pub fn program(self) -> Option<&'static str> {
        match self {
            Engine::Local => None,
            Engine::Parallel => Some(parallel::PROGRAM),
            Engine::Slurm => Some(slurm::PROGRAM),
            Engine::HyperQueue => Some(hyperqueue::PROGRAM),
        }
    }

    /// Tells whether its commands end only when the chunks have.
    pub fn waits(self) -> bool {
        matches!(self, Engine::Local | Engine::Parallel)
    }

    /// Says what the engine needs for an order.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for timed runs where the engine cannot promise that they are alone, and for options that it does not
    /// have.
    pub fn submission(self, order: &Order<'_>) -> Result<Submission> {
        let refused = |what: &str| Err(Error::Incompatible(format!("engine {self} {what}")));
        if order.exclusive && self == Engine::Parallel {
            return refused(
                "cannot promise that timed runs are alone: it does not know what else runs on its hosts; valid: local, slurm, hyperqueue",
            );
        }
        if order.exclusive && order.cpus != 1 {
            return refused("runs what is timed one after the other: --cpus must be 1");
        }
        if order.exclusive && self == Engine::Local && order.at_once.is_some_and(|count| count != 1) {
            return refused("runs what is timed one after the other: --at-once must be 1");
        }
        if !order.hosts.is_empty() && self != Engine::Parallel {
            return refused("is not told hosts by this program; valid: --host with parallel");
        }
        if !order.extra.is_empty() && self == Engine::Local {
            return refused("has no options of its own; valid: what follows -- goes to parallel, slurm, hyperqueue");
        }
        Ok(match self {
            Engine::Local => local::submission(order),
            Engine::Parallel => parallel::submission(order),
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
    /// Machines to use.
    pub hosts: &'a [String],
    /// Options for the engine's own program.
    pub extra: &'a [String],
}

impl Order<'_> {
    /// The command that runs some places of the plan.
    fn chunk_command(&self, places: &str) -> Words {
        let mut words = Words::of(self.program.display());
        words.extend(["run".to_owned(), self.file.display().to_string()]);
        self.more_files.iter().for_each(|(option, file)| words.option(option, file.display()));
        words.option("--out", self.folder.display());
        words.option("--jobs", self.cpus);
        words.option("--places", places);
        words
    }

    /// A script that runs the chunk whose number an environment variable holds, from a list that is its argument.
    fn script(&self, variable: &str) -> (PathBuf, String) {
        let command = self.chunk_command("$places").to_string();
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
    /// Commands, to be given in this order.
    pub commands: Vec<Words>,
    /// Commands that may run at once.
    pub at_once: usize,
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
            hosts: &[],
            extra: &[],
        }
    }

    #[test]
    fn what_an_engine_cannot_promise_is_refused_with_what_would_be_valid() {
        let refused = |engine: Engine, order: Order<'_>| engine.submission(&order).unwrap_err().to_string();
        let timed = || Order { exclusive: true, ..order(&CHUNKS) };
        let message = refused(Engine::Parallel, timed());
        assert!(message.contains("engine parallel cannot promise") && message.contains("slurm"), "{message}");
        assert!(refused(Engine::Slurm, Order { cpus: 2, ..timed() }).contains("--cpus must be 1"));
        assert!(refused(Engine::Local, Order { at_once: Some(2), ..timed() }).contains("--at-once must be 1"));
        let hosts = ["n1".to_owned()];
        assert!(refused(Engine::Slurm, Order { hosts: &hosts, ..order(&CHUNKS) }).contains("--host with parallel"));
        assert!(refused(Engine::Local, Order { extra: &hosts, ..order(&CHUNKS) }).contains("no options of its own"));
        for (name, engine) in Engine::NAMES {
            assert_eq!(name.parse::<Engine>().unwrap(), engine);
            assert_eq!(engine.submission(&timed()).is_ok(), engine != Engine::Parallel, "{name}");
        }
        assert!("slrum".parse::<Engine>().unwrap_err().to_string().contains("did you mean `slurm`"));
    }

    #[test]
    fn timed_runs_are_alone_wherever_they_are_accepted() {
        let timed = Order { exclusive: true, ..order(&CHUNKS) };
        let said = |engine: Engine| engine.submission(&timed).unwrap().commands[0].to_string();
        assert!(said(Engine::Slurm).contains(" --exclusive "));
        assert!(said(Engine::HyperQueue).contains(" --cpus=all "));
        assert_eq!(Engine::Local.submission(&timed).unwrap().at_once, 1);
    }

    #[test]
    fn an_array_of_slurm_is_no_longer_than_slurm_allows() {
        let many: Vec<Chunk> =
            (0..2500).map(|place| Chunk { first: place, last: place, runs: 1, seconds: 60.0 }).collect();
        let submission = Engine::Slurm.submission(&order(&many)).unwrap();
        let lists: Vec<usize> = submission.files.iter().skip(1).map(|(_, text)| text.lines().count()).collect();
        assert_eq!(lists, [1000, 1000, 500]);
        let arrays: Vec<String> = submission.commands.iter().map(Words::to_string).collect();
        assert!(arrays[0].contains("--array=1-1000 ") && arrays[2].contains("--array=1-500 "), "{arrays:?}");
        assert!(arrays[2].ends_with("chunks-3.txt"), "{arrays:?}");
        let all: String = submission.files[1..].iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(all, list(&many));
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
    fn every_engine_hands_the_files_of_cases_and_schemes_on_to_its_tasks() {
        let files = [("--case-file", "/data/my truck.toml"), ("--scheme-file", "/data/linear.toml")];
        let more_files = files.map(|(option, file)| (option, PathBuf::from(file)));
        let wanted =
            "cost.toml' --case-file '/data/my truck.toml' --scheme-file /data/linear.toml --out /data/results/cost ";
        for (name, engine) in Engine::NAMES {
            let submission = engine.submission(&Order { more_files: &more_files, ..order(&CHUNKS) }).unwrap();
            let commands = submission.commands.iter().map(Words::to_string);
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

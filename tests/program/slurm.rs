//! What is missing of an experiment, handed to Slurm: the commands to the letter, and results that are those of
//! `rimbench run` to the byte, whatever Slurm loses, begins twice or says of itself.

use crate::program::{assert_has, executable, files, rimbench, said, stand_in, two_sets_with};
use assert_cmd::Command;
use rimbench::harness::{Chunk, SlurmArray, in_shell, next_place};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const EXPERIMENT: &str = concat!(
    r#"
question = "Does a cluster do what a laptop does?"
macro_steps_s = [2e-3, 5e-3]
phases = 6
duration_s = 0.2
trace_every_s = 5e-3
traces = ["rim-nonsmooth"]
"#,
    two_sets_with!("rim-nonsmooth"),
);

/// Runs of the experiment: 2 parameter sets, 2 schemes, 2 macro steps, 6 phases.
const RUNS: usize = 48;

/// Six chunks of eight runs where nothing is measured.
const SIX: [&str; 4] = ["--run-time", "1", "--chunk-time", "8"];

/// What `rimbench run` makes of it, once.
static WHOLE: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("array.toml");
    std::fs::write(&file, EXPERIMENT).unwrap();
    rimbench().arg("run").arg(&file).arg("--out").arg(folder.path().join("array")).assert().success();
    folder
});

/// A folder with the experiment, and a place for programs.
struct Workplace(tempfile::TempDir);

impl Workplace {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("array.toml"), EXPERIMENT).unwrap();
        std::fs::create_dir(folder.path().join("bin")).unwrap();
        Workplace(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A program in `bin`, and where it lies.
    fn program(&self, name: &str, script: &str) -> PathBuf {
        let path = self.path("bin").join(name);
        stand_in(&path, script);
        path
    }

    fn submit(&self, extra: &[&str]) -> Command {
        let mut command = rimbench();
        let path = format!("{}:/usr/local/bin:/usr/bin:/bin", self.path("bin").display());
        command.env("PATH", path).arg("run").arg(self.path("array.toml")).arg("--slurm");
        command.arg("--out").arg(self.path("array")).args(extra);
        command
    }

    /// What it prints, with exit code `code`; paths by their names.
    fn said(&self, extra: &[&str], code: i32) -> String {
        let text = said(&mut self.submit(extra), code);
        let text = text.replace(executable().to_str().unwrap(), "RIMBENCH");
        text.replace(self.0.path().to_str().unwrap(), "HERE")
    }

    /// Stands in for Slurm: knows only how an array is asked for and how a task is told its number; the last one first.
    fn slurm(&self) {
        self.program("sbatch", SBATCH);
    }

    fn collect(&self, code: i32) -> String {
        self.run(&["--collect"], code)
    }

    /// Run without Slurm.
    fn run(&self, options: &[&str], code: i32) -> String {
        let out = self.path("array");
        said(rimbench().arg("run").arg(self.path("array.toml")).arg("--out").arg(out).args(options), code)
    }

    fn assert_as_whole(&self) {
        let [one, other] = [self.path("array"), WHOLE.path().join("array")].map(|folder| results(&folder));
        assert_eq!(one.len(), RUNS / 2 + 2 + 3);
        assert!(one == other, "differs from what `rimbench run` makes");
    }
}

const SBATCH: &str = "for word; do case $word in --array=1-*) count=${word#--array=1-};; esac; before=$last; last=$word; done\n\
    while [ \"$count\" -gt 0 ]; do SLURM_ARRAY_TASK_ID=$count sh \"$before\" \"$last\"; count=$((count - 1)); done";

fn results(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let tables = ["runs.csv", "parameters.csv", "reference.csv"].map(|name| folder.join(name));
    let all = files(&folder.join("traces")).into_iter().chain(tables);
    all.map(|path| (path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(&path).unwrap())).collect()
}

const HEAD: &str =
    "48 of 48 runs are missing; in chunks: 3; on one core in all: 48 s (at 1 s per run: none is measured yet)\n\n";

#[test]
fn a_dry_run_prints_the_exact_commands_and_writes_nothing() {
    let place = Workplace::new();
    let chunk = "RIMBENCH run HERE/array.toml --out HERE/array --jobs 1 --places \"$places\"";
    let at = "HERE/array/records/submissions/1";
    let list = "0-19\n20-39\n40-47\n";
    let script = format!(
        "# {at}/chunk.sh\n#!/bin/sh\n# SLURM_ARRAY_TASK_ID counts the lines of the list from 1.\n\
         places=$(sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" \"$1\") && exec {chunk}\n\n"
    );
    let command = format!(
        "sbatch '--job-name=rimbench-array' '--array=1-3%2' --requeue '--open-mode=append' '--ntasks=1' '--cpus-per-task=1' \
         --exclusive '--output={at}/%A-%a.out' '--partition=short' {at}/chunk.sh {at}/chunks-1.txt"
    );
    let options = ["--dry-run", "--run-time", "1", "--chunk-time", "20", "--exclusive", "--at-once", "2"];
    let said = place.said(&[&options[..], &["--", "--partition=short"]].concat(), 0);
    assert_eq!(said, format!("{HEAD}{script}# {at}/chunks-1.txt\n{list}\n# commands\n{command}\n"));
    assert!(!place.path("array").exists(), "a dry run has written something");
}

#[test]
fn an_array_runs_every_chunk_by_its_number() {
    let place = Workplace::new();
    place.slurm();
    let said = place.said(&SIX, 0);
    let collect = "rimbench run HERE/array.toml --out HERE/array --collect\n";
    assert!(said.contains("in chunks: 6;") && said.ends_with(&format!("When they are done: {collect}")), "{said}");
    assert_eq!(said.matches("8 of 8 runs stored").count(), 6, "{said}");
    assert!(!place.path("array/runs.csv").exists(), "a task looks after its own runs only");
    place.collect(0);
    place.assert_as_whole();
    let nothing = format!("Nothing is missing: all 48 runs are stored. Result files: {collect}");
    assert_eq!(place.said(&[], 0), nothing);
    // A larger grid: only what is new, by the times that were measured.
    let larger = EXPERIMENT.replace("phases = 6", "phases = 7");
    std::fs::write(place.path("array.toml"), larger).unwrap();
    let said = place.said(&["--run-time", "1000", "--dry-run"], 0);
    assert!(said.starts_with("8 of 56 runs are missing; in chunks: 1;"), "{said}");
    assert!(said.contains("(by the times of stored runs)"), "{said}");
    // A Slurm that does not take the chunks is an error.
    let place = Workplace::new();
    place.program("sbatch", "echo no such partition >&2; exit 1");
    let said = place.said(&[], 2);
    assert!(said.contains("no such partition") && said.contains("did not take the chunks"), "{said}");
}

#[test]
fn a_killed_chunk_is_submitted_again_and_nothing_else_is() {
    let place = Workplace::new();
    place.slurm();
    // Killed after some of its runs, and without a chance to say so.
    let script = format!(
        "case \"$*\" in *' 16-23') \"{0}\" run \"$2\" --out \"$4\" --places 16-18; kill -9 $$;; esac\nexec \"{0}\" \"$@\"",
        executable().display()
    );
    let lossy = place.program("lossy", &script);
    place.said(&[&SIX[..], &["--program", lossy.to_str().unwrap()]].concat(), 0);
    let said = place.collect(1);
    assert!(said.contains("43 of 48 runs in ") && said.contains("missing: "), "{said}");
    assert!(!place.path("array/runs.csv").exists(), "an incomplete experiment has no results");
    let said = place.said(&["--dry-run"], 0);
    assert!(said.starts_with("5 of 48 runs are missing; in chunks: 1;") && said.contains("\n19-23\n"), "{said}");
    place.said(&[], 0);
    place.collect(0);
    place.assert_as_whole();
}

#[test]
fn records_and_not_exit_codes_say_what_is_done() {
    // Each chunk twice at once, and then an exit code that tells of a failure.
    let place = Workplace::new();
    place.slurm();
    let script = format!("\"{0}\" \"$@\" &\n\"{0}\" \"$@\"\nwait\nexit 3", executable().display());
    let twice = place.program("twice", &script);
    place.said(&[&SIX[..], &["--program", twice.to_str().unwrap()]].concat(), 0);
    place.collect(0);
    place.assert_as_whole();
    // And one that does nothing, and calls it a success.
    let place = Workplace::new();
    place.slurm();
    let idle = place.program("idle", "exit 0");
    place.said(&["--program", idle.to_str().unwrap()], 0);
    assert!(place.collect(1).starts_with("0 of 48 runs in "));
}

#[test]
fn what_cannot_be_submitted_is_one_error() {
    let place = Workplace::new();
    let timed = place.path("timed.toml");
    std::fs::write(&timed, EXPERIMENT.replacen("phases", "timed = true\nphases", 1)).unwrap();
    let path = place.path("bin");
    let refused = |file: &Path, options: &[&str]| {
        let mut command = rimbench();
        command.env("PATH", &path).arg("run").arg(file).args(options).arg("--out").arg(place.path("out"));
        let message = said(&mut command, 2);
        assert!(!place.path("out").exists(), "{options:?}: something was written");
        message
    };
    let file = place.path("array.toml");
    for (file, options, wanted) in [
        (&file, &["--slurm"][..], "needs `sbatch` on the path"),
        (&file, &["--slurm", "--chunk-time", "0"], "--chunk-time = 0 is not valid"),
        (&file, &["--slurm", "--run-time", "inf"], "--run-time = inf is not valid"),
        (&file, &["--slurm", "--cpus", "0"], "1..=1024"),
        (&file, &["--slurm", "--shard", "1/2"], "cannot be used with '--shard"),
        (&file, &["--cpus", "2"], "--slurm"),
        (&timed, &["--slurm", "--dry-run", "--cpus", "4"], "--cpus must be 1"),
        (&place.path("none.toml"), &["--slurm"], "none.toml: cannot be read"),
    ] {
        assert_has(&refused(file, options), &[wanted]);
    }
}

#[test]
fn shards_are_counted_from_0_or_1() {
    let place = Workplace::new();
    let run = |options: &[&str], code: i32| place.run(options, code);
    for (text, first) in [("2/2", "0"), ("0/2", "1"), ("0/0", "0"), ("18446744073709551615/2", "1"), ("1", "1")] {
        let said = run(&["--shard", text, "--first-shard", first], 2);
        assert!(said.contains(&format!("i/n with {first} ≤ i")), "{said}");
    }
    for places in ["5", "5-4", "0-48", "a-b", "0-18446744073709551615"] {
        let said = run(&["--places", places], 2);
        assert!(said.contains("places = ") && said.contains("help: use "), "{said}");
    }
    assert!(run(&["--shard", "0/2", "--first-shard", "0"], 0).contains("24 runs are missing"));
    // The places are those that `--dry-run --format json` says.
    assert!(run(&["--places", "1-1"], 0).contains("1 of 1 runs stored"));
    assert!(run(&["--shard", "2/2"], 0).contains("23 computed now"));
    place.assert_as_whole();
}

fn array(chunks: &[Chunk]) -> SlurmArray<'_> {
    SlurmArray {
        name: "cost",
        program: Path::new("/opt/rim bench/rimbench"),
        file: Path::new("/data/it's/cost.toml"),
        more_files: &[],
        folder: Path::new("/data/results/cost"),
        place: Path::new("/data/results/cost/records/submissions/1"),
        chunks,
        cpus: 1,
        at_once: None,
        exclusive: false,
        extra: &[],
    }
}

#[test]
fn an_array_of_slurm_is_no_longer_than_slurm_allows() {
    let many: Vec<Chunk> = (0..2500).map(|place| Chunk { first: place, last: place, runs: 1, seconds: 60.0 }).collect();
    let submission = array(&many).submission().unwrap();
    let lists: Vec<usize> = submission.files.iter().skip(1).map(|(_, text)| text.lines().count()).collect();
    assert_eq!(lists, [1000, 1000, 500]);
    let arrays = &submission.commands;
    assert!(arrays[0].contains(&"--array=1-1000".to_owned()) && arrays[2].contains(&"--array=1-500".to_owned()));
    assert!(arrays[2].last().unwrap().ends_with("chunks-3.txt"), "{arrays:?}");
    let all: String = submission.files[1..].iter().map(|(_, text)| text.as_str()).collect();
    assert!(all.lines().enumerate().all(|(place, line)| line == format!("{place}-{place}")));
}

#[test]
#[cfg(unix)]
fn a_shell_reads_the_words_that_were_written() {
    for word in ["plain", "", "two words", "it's", "$HOME", "a\"b", "back\\slash", "{}", "*", "ö"] {
        let mut shell = std::process::Command::new("sh");
        let output = shell.args(["-c", &in_shell(&["printf", "%s", word].map(str::to_owned))]).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stdout), word);
    }
}

#[test]
fn tasks_are_handed_the_files_of_cases() {
    let files = [("--case-file", "/data/my truck.toml"), ("--case-file", "/data/other.toml")];
    let more_files = files.map(|(option, file)| (option, PathBuf::from(file)));
    let wanted = " --case-file '/data/my truck.toml' --case-file /data/other.toml --out /data/results/cost ";
    let script = &SlurmArray { more_files: &more_files, ..array(&[]) }.submission().unwrap().files[0].1;
    assert!(script.contains(wanted), "{script}");
}

#[test]
#[cfg(unix)]
fn what_slurm_would_read_as_another_path_is_written_so_or_refused() {
    use std::os::unix::ffi::OsStrExt;
    let some = [Chunk { first: 0, last: 0, runs: 1, seconds: 1.0 }];
    let at = |place: &Path| SlurmArray { place, ..array(&some) }.submission();
    let command = at(Path::new("/data/50 %A of it/1")).unwrap().commands.swap_remove(0);
    assert!(command.contains(&"--output=/data/50 %%A of it/1/%A-%a.out".to_owned()), "{command:?}");
    assert!(command.last().unwrap().starts_with("/data/50 %A of it/1/chunks"), "{command:?}");
    assert!(at(Path::new("/data/back\\slash")).unwrap_err().to_string().contains("backslash"));
    let odd = Path::new(std::ffi::OsStr::from_bytes(b"/data/\xff"));
    let cases = [("--case-file", odd.to_owned())];
    for array in [
        SlurmArray { place: odd, ..array(&some) },
        SlurmArray { program: odd, ..array(&some) },
        SlurmArray { file: odd, ..array(&some) },
        SlurmArray { folder: odd, ..array(&some) },
        SlurmArray { more_files: &cases, ..array(&some) },
    ] {
        assert!(array.submission().unwrap_err().to_string().contains("no UTF-8"));
    }
}

#[test]
fn a_submission_gets_the_next_number() {
    let folder = tempfile::tempdir().unwrap();
    assert!(next_place(folder.path()).ends_with("records/submissions/1"));
    for name in ["2", "10", "notes"] {
        std::fs::create_dir_all(folder.path().join("records/submissions").join(name)).unwrap();
    }
    assert!(next_place(folder.path()).ends_with("records/submissions/11"));
}

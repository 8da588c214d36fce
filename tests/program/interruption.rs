//! Ctrl-C during an experiment: it is answered at once, and twice ends what would go on for long; SIGTERM does at
//! once.
#![cfg(unix)]

use crate::exported_fmus::{CARRIAGE, case_file, exported};
use crate::program::process;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};

/// Runs that take long each: as many micro steps of the actuator, or steps of the mechanics, as a run may have.
const ENDLESS: &str = "question = \"?\"\nmacro_steps_s = [5e-3]\nphases = 4\nduration_s = 1.0\nmicro_step_s = 1e-8\n\
                       [[cases]]\nname = \"linear-oscillator\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n\
                       [[schemes]]\nscheme = \"zero-order-hold\"\nlabel = \"many\"\nmechanics_steps = 500000\n";

/// A child that is ended with the test, whatever becomes of it.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Whether a process is there and not merely unburied.
fn lives(pid: &str) -> bool {
    let state = Command::new("ps").args(["-o", "stat=", "-p", pid]).output().unwrap().stdout;
    let state = String::from_utf8(state).unwrap();
    !state.trim().is_empty() && !state.starts_with('Z')
}

/// A terminal sends Ctrl-C to all processes of its foreground group.
#[test]
fn ctrl_c_in_a_terminal_does_not_end_the_processes_of_fmus() {
    use std::os::unix::process::CommandExt;
    let folder = exported("bouncing-ball", &[]);
    let case = case_file(CARRIAGE, "duration_s = 1.0\nmacro_step_s = 5e-3\nmicro_step_s = 5e-3");
    std::fs::write(folder.path().join("case.toml"), case).unwrap();
    std::fs::write(folder.path().join("endless.toml"), ENDLESS.replace("linear-oscillator", "of-fmus")).unwrap();
    let child = process()
        .args(["--case-file", "case.toml", "run", "endless.toml", "--out", "out", "--jobs", "1"])
        .current_dir(folder.path())
        .process_group(0)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut child = Ended(child);
    let parent = child.0.id().to_string();
    let workers = || -> Vec<String> {
        let all = Command::new("ps").args(["-o", "pid=", "--ppid", &parent]).output().unwrap().stdout;
        String::from_utf8(all).unwrap().split_whitespace().map(str::to_owned).collect()
    };
    // What reads the file, or computes the reference, is gone sooner.
    let (mut seen, mut since) = (workers(), std::time::Instant::now());
    while seen.len() < 2 || since.elapsed().as_secs() < 3 {
        std::thread::sleep(std::time::Duration::from_millis(100));
        assert!(child.0.try_wait().unwrap().is_none(), "it has ended by itself");
        let now = workers();
        if now != seen {
            (seen, since) = (now, std::time::Instant::now());
        }
    }
    let group = format!("-{parent}");
    let at_work = workers();
    assert!(Command::new("kill").args(["-INT", "--", &group]).status().unwrap().success());
    let mut lines = BufReader::new(child.0.stderr.take().unwrap()).lines().map(Result::unwrap);
    lines.find(|line| line.contains("again to stop now")).expect("an answer");
    std::thread::sleep(std::time::Duration::from_millis(300));
    let left = workers();
    assert!(at_work.iter().all(|pid| left.contains(pid)), "{at_work:?} {left:?}");
    assert!(Command::new("kill").args(["-INT", "--", &group]).status().unwrap().success());
    assert_eq!(child.0.wait().unwrap().code(), Some(130));
    while at_work.iter().any(|pid| lives(pid)) {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

#[test]
fn twice_ctrl_c_or_sigterm_ends_runs_that_would_take_long_and_says_so() {
    ended_by(
        &["-INT", "-INT"],
        &[
            "stopping after the runs in progress, after which the same command goes on from there; again to stop now",
            "stopping now; what is stored is kept, and the same command goes on from there",
        ],
    );
    ended_by(&["-TERM"], &["stopping now; what is stored is kept, and the same command goes on from there"]);
}

/// Nothing is stored of a search, and the same command begins again.
#[test]
fn a_search_that_is_stopped_does_not_say_that_it_goes_on() {
    let said = (0..8).map(|k| 100 << k).find_map(|wait_ms| {
        let folder = tempfile::tempdir().unwrap();
        let mut child = process();
        let child = child.args(["advise", "--case", "wedge-box", "--error", "1%", "--phases", "1000"]);
        let child = child.env("RIMBENCH_CACHE", folder.path()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        let mut child = Ended(child.unwrap());
        std::thread::sleep(std::time::Duration::from_millis(wait_ms));
        for signal in ["-INT", "-TERM"] {
            let _ = Command::new("kill").args([signal, &child.0.id().to_string()]).status();
        }
        let mut said = String::new();
        child.0.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        // Before it listens it just ends, which is over long before the search would be.
        said.contains("stopping").then_some(said)
    });
    let said = said.expect("it has never listened");
    assert!(said.contains("stopping") && !said.contains("goes on") && !said.contains("stored"), "{said}");
}

fn ended_by(signals: &[&str], answers: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("endless.toml"), ENDLESS).unwrap();
    let child = process()
        .args(["run", "endless.toml", "--out", "out"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut child = Ended(child);
    // Begun, once its copy of the experiment is there: it listens since before that.
    while !folder.path().join("out/experiment.toml").exists() {
        std::thread::sleep(std::time::Duration::from_millis(20));
        assert!(child.0.try_wait().unwrap().is_none(), "it has ended by itself");
    }
    let mut lines = BufReader::new(child.0.stderr.take().unwrap()).lines().map(Result::unwrap);
    for (signal, answer) in signals.iter().zip(answers) {
        assert!(Command::new("kill").args([*signal, &child.0.id().to_string()]).status().unwrap().success());
        assert_eq!(lines.find(|line| line.contains("stopping")).as_deref(), Some(*answer));
    }
    // Waits as long as it takes.
    assert_eq!(child.0.wait().unwrap().code(), Some(130));
    let mut printed = String::new();
    child.0.stdout.take().unwrap().read_to_string(&mut printed).unwrap();
    assert!(printed.is_empty() || printed.contains("Stopped."), "{printed}");
}

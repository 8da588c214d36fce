//! Ctrl-C during an experiment: it is answered at once, and twice ends what would go on for hours; SIGTERM does at once.
#![cfg(unix)]

use crate::program::process;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};

/// Runs that take hours each: a micro step of the actuator of 10 ns, and a million steps of the mechanics per macro step.
const ENDLESS: &str = "question = \"?\"\nmacro_steps_s = [5e-3]\nphases = 4\nduration_s = 1.0\nmicro_step_s = 1e-8\n\
                       [[cases]]\nname = \"linear-oscillator\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n\
                       [[schemes]]\nscheme = \"zero-order-hold\"\nlabel = \"many\"\nmechanics_steps = 1000000\n";

fn send(signal: &str, child: &Child) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

fn interrupt(child: &Child) {
    send("-INT", child);
}

/// A child that is ended with the test, whatever becomes of it.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A side that never answers its fifth step, and has started something by then.
const HANGS: &str = r#"
import json, os, subprocess, sys, time
count = 0
for line in sys.stdin:
    q = json.loads(line)
    a = {"id": q["id"]}
    if q["ask"] == "hello":
        a |= {"protocol": "rimbench-line", "version": 1, "role": "mechanics", "inputs": q["inputs"], "outputs": q["outputs"]}
    else:
        count += q["ask"] == "step"
        a["y"] = [0.0, -100.0]
    if count == 5:
        sleeper = subprocess.Popen(["sleep", "1000"])
        with open("begun", "w") as file: file.write(f"{os.getpid()} {sleeper.pid}")
        os.rename("begun", "processes")
        time.sleep(1000)
    print(json.dumps(a), flush=True)
"#;

/// Whether a process is there and not merely unburied.
fn lives(pid: &str) -> bool {
    let state = Command::new("ps").args(["-o", "stat=", "-p", pid]).output().unwrap().stdout;
    let state = String::from_utf8(state).unwrap();
    !state.trim().is_empty() && !state.starts_with('Z')
}

#[test]
fn a_program_that_hangs_is_ended_with_the_second_ctrl_c_and_is_no_result() {
    if !Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: there is no python3 on the path");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("hangs.py", HANGS);
    let case = "name = \"hangs\"\nlike = \"linear-oscillator\"\nreference = \"original\"\nanswer_within_s = 600\n[mechanics]\n\
                command = [\"python3\", \"hangs.py\"]\n";
    write("hangs.toml", case);
    let sweep = "question = \"?\"\nmacro_steps_s = [1e-3]\nduration_s = 0.02\n[[cases]]\nname = \"hangs\"\n[[schemes]]\n\
                 scheme = \"zero-order-hold\"\n";
    write("sweep.toml", sweep);
    let simulate: &[&str] = &[
        "simulate",
        "--case",
        "hangs.toml",
        "--scheme",
        "zero-order-hold",
        "--duration",
        "0.02",
        "--macro-step",
        "1e-3",
    ];
    let run: &[&str] = &["--case-file", "hangs.toml", "run", "sweep.toml", "--out", "out"];
    // One has runs to keep, the other leaves with the first; and who sends SIGTERM kills soon after.
    for (arguments, signal, times) in
        [(run, "-INT", 2), (simulate, "-INT", 1), (run, "-TERM", 1), (simulate, "-TERM", 1)]
    {
        let processes = folder.path().join("processes");
        let _ = std::fs::remove_file(&processes);
        let child = process()
            .args(arguments)
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut child = Ended(child);
        while !processes.exists() {
            std::thread::sleep(std::time::Duration::from_millis(20));
            assert!(child.0.try_wait().unwrap().is_none(), "it has ended by itself");
        }
        let pids = std::fs::read_to_string(&processes).unwrap();
        assert!(pids.split(' ').all(lives), "{pids}");
        let mut lines = BufReader::new(child.0.stderr.take().unwrap()).lines().map(Result::unwrap);
        send(signal, &child.0);
        if times == 2 {
            lines.find(|line| line.contains("again to stop now")).expect("an answer");
            assert!(pids.split(' ').all(lives), "an answer is waited for: {pids}");
            send(signal, &child.0);
        }
        assert_eq!(child.0.wait().unwrap().code(), Some(130));
        while pids.split(' ').any(lives) {
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        let rest: Vec<String> = lines.collect();
        assert!(!rest.iter().any(|line| line.contains("hangs.py")), "{rest:?}");
    }
    // Nothing of it is stored.
    let output =
        process().args(["--case-file", "hangs.toml", "collect", "out"]).current_dir(folder.path()).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.code() == Some(1) && said.contains("0 of 1 runs"), "{said}");
}

/// A terminal sends Ctrl-C to all processes of its foreground group.
#[test]
fn ctrl_c_in_a_terminal_does_not_end_the_processes_of_fmus() {
    use std::os::unix::process::CommandExt;
    let folder = tempfile::tempdir().unwrap();
    for side in ["mechanics", "actuator"] {
        let out = format!("{side}.fmu");
        let made = process()
            .args(["fmu", "--case", "bouncing-ball", "--side", side, "--out", &out])
            .current_dir(folder.path())
            .output();
        assert!(made.unwrap().status.success());
    }
    let ends =
        "position = \"interface_position_m\"\nvelocity = \"interface_velocity_m_s\"\nforce = \"actuator_force_n\"\n";
    let case = format!(
        "name = \"of-fmus\"\nduration_s = 1.0\nmacro_step_s = 5e-3\nmicro_step_s = 5e-3\n[mechanics]\nfmu = \"mechanics.fmu\"\n[actuator]\n\
         fmu = \"actuator.fmu\"\n[[interface]]\n[interface.mechanics]\n{ends}[interface.actuator]\n{ends}"
    );
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
    while seen.len() < 2 || since.elapsed().as_secs() < 5 {
        std::thread::sleep(std::time::Duration::from_millis(20));
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
fn twice_ctrl_c_ends_runs_that_would_take_hours_and_says_so() {
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
    interrupt(&child.0);
    let mut lines = BufReader::new(child.0.stderr.take().unwrap()).lines().map(Result::unwrap);
    let answer = lines.find(|line| line.contains("stopping")).expect("an answer");
    assert_eq!(answer, "stopping after the runs in progress; again to stop now");
    interrupt(&child.0);
    let answer = lines.find(|line| line.contains("stopping")).expect("a second answer");
    assert_eq!(answer, "stopping now; what is stored is kept");
    // Waits as long as it takes; the runs themselves would take hours.
    assert_eq!(child.0.wait().unwrap().code(), Some(130));
    let mut printed = String::new();
    child.0.stdout.take().unwrap().read_to_string(&mut printed).unwrap();
    assert!(printed.is_empty() || printed.contains("Stopped."), "{printed}");
}

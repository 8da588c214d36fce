//! Ctrl-C during an experiment: it is answered at once, and twice ends what would go on for hours.
#![cfg(unix)]

use crate::program::process;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};

/// Runs that take hours each: a micro step of the actuator of 10 ns, and a million steps of the mechanics per macro step.
const ENDLESS: &str = "question = \"?\"\nmacro_steps_s = [5e-3]\nphases = 4\nduration_s = 1.0\nmicro_step_s = 1e-8\n\
                       [[cases]]\nname = \"linear-oscillator\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n\
                       [[schemes]]\nscheme = \"zero-order-hold\"\nlabel = \"many\"\nmechanics_steps = 1000000\n";

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

/// A child that is ended with the test, whatever becomes of it.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
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

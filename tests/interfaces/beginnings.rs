//! Sides from outside before their first step, and beside it: where both begin, what they are made of, what their
//! columns say, and what they may do to the program.
#![cfg(target_os = "linux")]

use crate::faulty_guest::{
    Guest, MASS, POSITION, SIDES, SPRING, case, inside, output, python, refused, run, write_case,
};
use crate::program::assert_has;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Column of the first row of the trace of a short run.
fn first(folder: &Path, column: &str) -> Option<f64> {
    run(folder, "--scheme zero-order-hold --duration 0.02 --trace trace.csv");
    let mut reader = csv::Reader::from_path(folder.join("trace.csv")).unwrap();
    let at = reader.headers().unwrap().iter().position(|name| name == column)?;
    reader.records().next().unwrap().unwrap()[at].parse().ok()
}

/// A class of Python that is where a spring of its own carries the force that it has before its first step.
const STEADY: &str = r#"
class Steady(Mass):
    own, moved = 50.0, False

    def outputs(self, u):
        if not self.moved:
            self.x = 0.1 + u[0] / self.own
        return self.x, self.v

    def step(self, t, u, h):
        self.moved = True
        n = max(round(h / 1e-5), 1)
        for _ in range(n):
            self.v += h / n * (u[0] + self.own * (0.1 - self.x))
            self.x += h / n * self.v

    interface_model = None
"#;

/// The mass of each kind of side that begins where a spring of `own` (N/m) carries the force.
fn steady(own: f64, judge: impl Fn(&str, &Path)) {
    for (fault, version) in [("STEADY", 2), ("STEADY", 3), ("SETTLES", 2), ("SETTLES", 3)] {
        let fault = format!("{fault}={own:?}");
        for state in [true, false] {
            let Some(folder) = case(&Guest { version, state, faults: &[&fault], ..MASS }, &SPRING, &[]) else { return };
            for process in ["own", "same"] {
                write_case(folder.path(), &[("[mechanics]", &format!("process = \"{process}\"\n[mechanics]"))]);
                judge(&format!("{fault}, FMI {version}, {process}"), folder.path());
            }
        }
    }
    let Some(folder) = case(&MASS, &SPRING, &[]).filter(|_| python().is_some()) else { return };
    let sides = format!("{SIDES}{}", STEADY.replace("50.0", &format!("{own:?}")));
    fs::write(folder.path().join("sides.py"), sides).unwrap();
    write_case(folder.path(), &[("fmu = \"mass.fmu\"", "python = \"sides.py\"\nclass = \"Steady\"")]);
    judge("Python", folder.path());
}

#[test]
fn both_sides_begin_where_they_agree_and_say_so_where_they_do_nowhere() {
    steady(50.0, |what, folder| {
        let begins = first(folder, POSITION).unwrap();
        assert!((begins - 0.1 / 3.0).abs() < 1e-9, "{what}: {begins}");
    });
    // Its own spring pushes as the other pulls.
    steady(-100.0, |what, folder| {
        let shown = refused(folder);
        assert!(shown.contains("do not agree on where they begin"), "{what}: {shown}");
        assert!(what == "Python" || shown.contains("`f` = "), "{what}: {shown}");
    });
}

/// Ever stiffer springs, in each kind of side.
#[test]
#[ignore = "a sweep of minutes: .ci/sweeps"]
fn a_fault_outside_of_an_initial_residual_is_solved_for_or_told() {
    for own in [1e-3, 0.1, 10.0, 99.0, 101.0, 1e3, 1e6, -1.0, -50.0, -99.9, -200.0, -1e4] {
        steady(own, |what, folder| {
            let output = output(folder, "--scheme zero-order-hold --trace trace.csv --format json");
            if output.status.code() == Some(2) {
                return;
            }
            let (begins, right) = (first(folder, POSITION).unwrap(), 0.1 / (1.0 + 100.0 / own));
            assert!((begins - right).abs() <= 1e-6 * right.abs(), "{own}, {what}: {begins} {right}");
        });
    }
}

/// The hash of what a case is made of.
fn digest(folder: &Path) -> String {
    let output = inside(folder).args(["list", "parameters", "--case", "case.toml"]).output().unwrap();
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let line = shown.lines().find(|line| line.starts_with("fmu_digest")).unwrap();
    line.split_whitespace().nth(1).unwrap().to_owned()
}

#[test]
fn a_fault_outside_of_a_digest_is_none_whatever_kind_of_file_a_side_is_made_of() {
    let Some(folder) = case(&MASS, &Guest { faults: &["NEEDS"], ..SPRING }, &[]) else { return };
    let path = folder.path();
    write_case(path, &[("fmu = \"spring.fmu\"", "fmu = \"spring.fmu\"\nneeds = [\"libk.so\"]")]);
    let library = |k: &str| {
        fs::write(path.join("k.c"), format!("double stiffness(void) {{ return {k}; }}\n")).unwrap();
        let mut compiler = Command::new("cc");
        assert!(
            compiler.args(["-shared", "-fPIC", "-o", "libk.so", "k.c"]).current_dir(path).status().unwrap().success()
        );
    };
    library("100.0");
    let soft = digest(path);
    run(path, "--scheme zero-order-hold");
    assert_eq!(digest(path), soft);
    library("400.0");
    assert_ne!(digest(path), soft);
    let error = || run(path, "--scheme zero-order-hold").0["force_error_rms_n"].clone();
    let beside_the_old_one = error();
    fs::remove_dir_all(path.join("cache")).unwrap();
    assert_eq!(error(), beside_the_old_one);
    if python().is_none() {
        return;
    }
    // A class, a module, a table that it reads, files that it lists, and a text.
    let class = "import helper\nclass Spring(helper.Spring):\n    def __init__(self, parameters):\n        super().__init__(parameters)\n        \
                 self.k = float(open(__file__.replace('sides.py', 'table.txt')).read())\n        self.made_from = MADE\n";
    fs::write(path.join("helper.py"), SIDES).unwrap();
    fs::write(path.join("table.txt"), "100").unwrap();
    fs::write(path.join("late.bin"), [0xff, 0]).unwrap();
    write_case(path, &[("fmu = \"spring.fmu\"", "python = \"sides.py\"\nclass = \"Spring\"")]);
    let sides = |made: &str| fs::write(path.join("sides.py"), class.replace("MADE", made)).unwrap();
    sides("['late.bin']");
    let mut seen = vec![digest(path)];
    assert_eq!(digest(path), seen[0]);
    let mut changed = |what: &str| {
        let now = digest(path);
        assert!(!seen.contains(&now), "{what}");
        seen.push(now);
    };
    fs::write(path.join("helper.py"), format!("{SIDES}\n# another\n")).unwrap();
    changed("a module");
    fs::write(path.join("table.txt"), "200").unwrap();
    changed("a table");
    fs::write(path.join("late.bin"), [0xff, 1]).unwrap();
    changed("a file that is listed");
    sides("'one'");
    changed("the class");
    // A text that is the state of something, and not in the file.
    sides("open(__file__.replace('sides.py', 'late.bin'), 'rb').read().hex()");
    changed("a text");
    sides("['nowhere.bin']");
    assert_has(&refused(path), &["sides.py", "FileNotFoundError", "nowhere.bin"]);
}

#[test]
fn a_fault_outside_of_the_unit_of_what_is_observed_is_none() {
    let units = "<UnitDefinitions><Unit name=\"mm\"><BaseUnit m=\"1\" factor=\"0.001\"/></Unit><Unit name=\"\u{3bc}m\"><BaseUnit m=\"1\" \
                 factor=\"1e-6\"/></Unit><Unit name=\"degC\"><BaseUnit K=\"1\" offset=\"273.15\"/></Unit>";
    for version in [2, 3] {
        for (name, unit, heading) in [
            ("x_mm", "mm", "x_mm"),
            ("way", "mm", "way [mm]"),
            ("x_m", "mm", "x_m [mm]"),
            ("way", "", "way"),
            ("x_n", "N", "x_n"),
            ("way", "degC", "way [degC]"),
            // One letter: the sign of micro here, the Greek one where the unit is defined.
            ("way", "\u{b5}m", "way [\u{b5}m]"),
            ("way", "furlong", "way [furlong]"),
        ] {
            let unit = if unit.is_empty() { String::new() } else { format!(" unit=\"{unit}\"") };
            let head = format!("name=\"{name}\" valueReference=\"10\" causality=\"local\" variability=\"continuous\"");
            let variable = match version {
                2 => format!("<ScalarVariable {head}><Real{unit}/></ScalarVariable></ModelVariables>"),
                _ => format!("<Float64 {head}{unit}/></ModelVariables>"),
            };
            let changes = [("<UnitDefinitions>", units), ("</ModelVariables>", &*variable)];
            let Some(folder) = case(&Guest { version, changes: &changes, ..MASS }, &SPRING, &[]) else { return };
            write_case(
                folder.path(),
                &[("fmu = \"mass.fmu\"", &format!("fmu = \"mass.fmu\"\nobserve = [\"{name}\"]"))],
            );
            // As the FMU has it, whatever its unit is.
            assert_eq!(first(folder.path(), heading), Some(100.0), "{version}: {heading}");
        }
    }
    let clocked = "<Float64 name=\"way\" valueReference=\"10\" clocks=\"77\"/></ModelVariables>";
    let Some(folder) = case(&Guest { changes: &[("</ModelVariables>", clocked)], ..MASS }, &SPRING, &[]) else {
        return;
    };
    write_case(folder.path(), &[("fmu = \"mass.fmu\"", "fmu = \"mass.fmu\"\nobserve = [\"way\"]")]);
    assert_has(&refused(folder.path()), &["variable `way` has clocks = 77", "use a variable without clocks"]);
}

#[test]
fn an_actuator_that_answers_at_its_step_and_says_at_once_is_told() {
    let told = "(direct feedthrough), and they do so at its next step only";
    for version in [2, 3] {
        for state in [true, false] {
            for (faults, is_told) in [(&["LATCH"][..], true), (&[], false)] {
                let Some(folder) = case(&MASS, &Guest { version, state, faults, ..SPRING }, &[]) else { return };
                let (_, shown) = run(folder.path(), "--scheme zero-order-hold");
                assert_eq!(shown.contains(told), is_told, "FMI {version}, states {state}: {shown}");
            }
        }
    }
}

#[test]
fn a_position_that_wraps_is_named_with_its_jump() {
    for version in [2, 3] {
        let Some(folder) = case(&Guest { version, faults: &["WRAPS=0.15"], ..MASS }, &SPRING, &[]) else { return };
        write_case(folder.path(), &[("fmu = \"spring.fmu\"", "fmu = \"spring.fmu\"\nstart = { rest = 0.06 }")]);
        assert_has(
            &refused(folder.path()),
            &["mass.fmu", "interface_position_m jumps from 0.07", "m to -0.07", "wraps"],
        );
    }
}

/// What FMUs that call `exit` do to a sweep of three threads: codes, what is said, folders that are left, rows.
fn exits(faults: &[&str], version: u32) {
    let same = [("[mechanics]", "process = \"same\"\n[mechanics]")];
    let Some(folder) = case(&Guest { version, faults, ..MASS }, &SPRING, &same) else { return };
    let (path, place) = (folder.path(), folder.path().join("unpacked"));
    fs::create_dir(&place).unwrap();
    let sweep = "question = \"?\"\nmacro_steps_s = [1e-3, 4e-3, 5e-3]\nphases = 4\n[[cases]]\nfile = \"case.toml\"\n[[schemes]]\nscheme = \
                 \"zero-order-hold\"\n";
    fs::write(path.join("sweep.toml"), sweep).unwrap();
    let mut rows = Vec::new();
    for _ in 0..4 {
        let mut command = inside(path);
        let output =
            command.env("TMPDIR", &place).args(["run", "sweep.toml", "--out", "out", "--jobs", "3"]).output().unwrap();
        let shown = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{faults:?}: {shown}");
        assert_has(&shown, &["ended this program by itself (exit)", "process = \"own\""]);
        assert_eq!(fs::read_dir(&place).unwrap().count(), 0, "{faults:?}: a folder is left");
        let now = crate::attributes::records(path);
        assert!(rows.iter().all(|row| now.contains(row)), "{faults:?}: a row is lost");
        rows = now;
    }
}

#[test]
fn an_exit_in_any_thread_ends_with_a_message_no_folder_and_all_rows() {
    exits(&["EXIT_ABOVE=3e-3"], 3);
}

/// One thread of the program, three of them at once, and threads of the FMU itself.
#[test]
#[ignore = "a sweep of minutes: .ci/sweeps"]
fn a_fault_outside_of_an_exit_in_any_thread_is_told() {
    for version in [2, 3] {
        for faults in [["EXIT_AT=0.15"], ["EXIT_ABOVE=3e-3"], ["THREADS_EXIT=1"], ["THREADS_EXIT=3"]] {
            exits(&faults, version);
        }
    }
}

#[test]
fn errors_and_paths_arrive_in_every_spelling() {
    let Some(folder) = case(&MASS, &SPRING, &[]) else { return };
    for (written, hint) in [
        ("\"fmus\\box.fmu\"", "a control character"),
        ("\"fmus\\\\box.fmu\"", "a backslash separates no folders here"),
        ("'fmus\\box.fmu'", "a backslash separates no folders here"),
        ("\"C:\\models\\box.fmu\"", "a backslash begins an escape"),
    ] {
        if cfg!(not(windows)) {
            write_case(folder.path(), &[("\"mass.fmu\"", written)]);
            assert_has(&refused(folder.path()), &[hint]);
        }
    }
    if python().is_none() {
        return;
    }
    let wrong = format!(
        "{SIDES}\nclass Odd(Mass):\n    def step(self, t, u, h):\n        raise ValueError('table \\udcfc.csv')\n"
    );
    fs::write(folder.path().join("sides.py"), wrong).unwrap();
    write_case(folder.path(), &[("fmu = \"mass.fmu\"", "python = \"sides.py\"\nclass = \"Odd\"")]);
    assert_has(&refused(folder.path()), &["ValueError: table \\udcfc.csv (sides.py, line "]);
}

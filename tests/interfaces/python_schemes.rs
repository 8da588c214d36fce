//! Schemes that are classes of Python in files, each in a process of its own.
#![cfg(unix)]

use crate::faulty_guest::python;
use crate::program::{assert_has, printed, read, refused, rimbench, root};
use assert_cmd::Command;
use rimbench::catalogue::{Catalogue, SchemeFile};
use rimbench::cosim::{Bounds, StopFlag};
use rimbench::fmi::import::{Programs, read_scheme};
use rimbench::runs::{RunRequest, simulate};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Holds in the three forms, a straight line, and one for each way to go wrong.
const MINE: &str = r#"
import os, sys, time

class Base:
    def __init__(self, outputs):
        self.held, self.outputs = {}, outputs
    def receive(self, side, sample):
        self.held[side] = sample.y
    def other(self, side):
        return self.held["actuator" if side == "mechanics" else "mechanics"]

class PolyHold(Base):
    def polynomial(self, side, step):
        return [(y,) for y in self.other(side)]

class ArrayHold(Base):
    def inputs(self, side, step):
        return [self.other(side)] * step.count

class MicroHold(Base):
    def input(self, side, at, own):
        return self.other(side)

class Line(Base):
    order = samples = 2
    def receive(self, side, sample):
        before = self.held.get(side)
        if before is None:
            rows = [(y, 0.0) for y in sample.y]
        else:
            at = before[0] - sample.time
            rows = [(y, (y - old) / (0.0 - at)) for y, old in zip(sample.y, before[1])]
        self.held[side] = (sample.time, sample.y, rows)
    def polynomial(self, side, step):
        return self.other(side)[2]

class Modelled(PolyHold):
    interface_model = True
    def receive(self, side, sample):
        super().receive(side, sample)
        if side == "mechanics":
            model = sample.model
            rows = len(model["w"])
            assert (len(model["H"]), len(model["H"][0]), len(model["a"])) == (rows,) * 3, model
            assert model["stabilisation"] > 0 and model["mechanics_step"] > 0 and len(model["closed"]) == rows - 1
        else:
            assert sample.model is None

class Unmade(PolyHold):
    def __init__(self, outputs):
        raise KeyError("of this case I know nothing")

class Mute(Base):
    pass

class ZeroOrderHold(PolyHold):
    pass
"#;

fn folder() -> Option<TempDir> {
    if python().is_none() {
        eprintln!("skipped: there is no Python `python3` on the path");
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.py"), MINE).unwrap();
    Some(folder)
}

fn inside(folder: &Path, line: &str) -> Command {
    let mut command = rimbench();
    command.current_dir(folder).args(line.split(' '));
    command
}

fn json(command: &mut Command) -> serde_json::Value {
    serde_json::from_str(&printed(command)).unwrap()
}

#[test]
fn a_hold_in_python_is_the_hold_to_the_bit_in_every_form() {
    let Some(folder) = folder() else { return };
    let mut catalogue = Catalogue::standard();
    catalogue.read_schemes_by(|file| read_scheme(file, &Programs::default()));
    for class in ["PolyHold", "ArrayHold", "MicroHold", "Line"] {
        catalogue.add_scheme_of_file(&SchemeFile::new(folder.path().join("mine.py"), class)).unwrap();
    }
    let run = |case: &str, scheme: &str, steps: usize| {
        let known = &catalogue.case(case).unwrap().defaults;
        let (h, duration) = ([1.0, 2.0, 4.0][steps] * known.macro_step_s, 25.0 * known.macro_step_s);
        let phase = [1.0, 0.7, 0.3][steps];
        let request = RunRequest {
            macro_step_s: Some(h),
            duration_s: Some(duration),
            phase: Some(phase),
            ..RunRequest::of(case, scheme)
        };
        let run = request.resolve(&catalogue).unwrap();
        let result = simulate(&run, Bounds::default(), None, StopFlag::never()).unwrap();
        let columns = result.trajectory.columns().len();
        let bits: Vec<u64> =
            (0..columns).flat_map(|column| result.trajectory.column(column)).map(f64::to_bits).collect();
        assert!(bits.len() > columns, "{case} {scheme}: {:?}", result.report.outcome);
        (format!("{:?}", result.report.outcome), bits)
    };
    let names: Vec<String> = catalogue.cases().iter().map(|case| case.name.to_string()).collect();
    let mut compared = 0;
    for (index, case) in names.iter().step_by(2).take(10).enumerate() {
        for steps in 0..3 {
            let form = ["poly-hold", "array-hold", "micro-hold"][(index + steps) % 3];
            assert!(run(case, form, steps) == run(case, "zero-order-hold", steps), "{case}, {form}, {steps}");
            compared += 1;
        }
    }
    assert_eq!(compared, 30);
    // A polynomial goes to sides that integrate it, as that of a built-in scheme.
    for case in ["linear-oscillator", "wedge-box"] {
        assert!(run(case, "line", 1) == run(case, "first-order-hold", 1), "{case}");
    }
}

const GRID: &str = r#"
question = "?"
macro_steps_s = [5e-3]
duration_s = 0.05
cases = [{ name = "bouncing-ball" }]

[[schemes]]
scheme = "zero-order-hold"

[[claims]]
id = "as-built-in"
by = "ours"
text = "?"
scheme = "poly-hold"
relative_to = "zero-order-hold"
metric = "force_error_rms_n"
expect = "<= 1"
finding = "reproduced"
"#;

const UNMADE: (&str, &str) = ("Unmade", "KeyError: 'of this case I know nothing'");

fn row(class: &str) -> String {
    format!("\n[[schemes]]\nfile = \"mine.py\"\nclass = \"{class}\"\nanswer_within_s = 2.0\n")
}

#[test]
fn a_class_that_goes_wrong_is_a_row_with_its_reason() {
    let Some(folder) = folder() else { return };
    let wrong = [
        ("Raises", "raise ValueError('no idea')", "ValueError: no idea (mine.py, line "),
        ("Hangs", "time.sleep(1e6)", "mine.py: no answer within 2 s"),
        ("Exits", "os._exit(3)", "mine.py: its process ended (exit status: 3)"),
        ("Leaves", "sys.exit()", "SystemExit"),
        ("Nan", "return [float('nan')] * 2", "at 0.025 s gives NaN; valid: finite numbers"),
        ("TooFew", "return []", "gives 0 numbers; valid: 2 rows of 1 to 4"),
        ("Ragged", "return [(1.0,), (1.0, 2.0)]", "rows that are not alike"),
        ("Texts", "return ['1.0']", "'1.0' instead of a number"),
    ];
    let mut code = MINE.to_owned();
    for (class, does, _) in wrong {
        code += &format!(
            "class {class}(PolyHold):\n    def polynomial(self, side, step):\n        if step.start > 0.0201: {does}\n        \
             return super().polynomial(side, step)\n\n"
        );
    }
    fs::write(folder.path().join("mine.py"), code).unwrap();
    let wrong: Vec<_> = wrong.into_iter().map(|(class, _, reason)| (class, reason)).chain([UNMADE]).collect();
    let rows: String = wrong.iter().map(|(class, _)| row(class)).collect();
    fs::write(folder.path().join("grid.toml"), format!("{GRID}{}{rows}", row("PolyHold"))).unwrap();
    assert_has(&printed(&mut inside(folder.path(), "run grid.toml --out out")), &["11 of 11 runs stored"]);
    let table = fs::read_to_string(folder.path().join("out/runs.csv")).unwrap();
    for (class, reason) in wrong {
        let label = &SchemeFile::new("mine.py", class).name;
        let line = table.lines().find(|line| line.contains(&format!(",{label},"))).unwrap_or_else(|| panic!("{table}"));
        assert_has(&line.replace("\"\"", "'"), &["scheme-failed", reason]);
        assert!(!line.contains(&*folder.path().to_string_lossy()), "a row names a folder of this machine: {line}");
    }
    assert_has(
        &printed(&mut inside(folder.path(), "verify grid.toml --results out")),
        &["every verdict is the recorded"],
    );
}

#[test]
fn every_command_knows_a_class_and_says_what_is_missing_where_its_file_has_moved() {
    let Some(folder) = folder() else { return };
    let here = folder.path();
    let call = |line: &str| printed(&mut inside(here, line));
    assert_has(&call("list schemes --scheme-file mine.py:PolyHold"), &["poly-hold", "Class PolyHold in Python"]);
    let of = |scheme: &str| {
        let line = format!("simulate --case bouncing-ball --scheme {scheme} --duration 0.05 --format json");
        json(&mut inside(here, &line))
    };
    let (mine, known) = (of("mine.py:PolyHold"), of("zero-order-hold"));
    assert_eq!((&mine["scheme"], &mine["outcome"]), (&"poly-hold".into(), &"completed".into()));
    assert_eq!(mine["force_error_rms_n"], known["force_error_rms_n"]);
    assert_eq!(of("mine.py:Modelled")["outcome"], "completed", "{:#}", of("mine.py:Modelled"));
    assert_has(
        &call("limit --case linear-oscillator --scheme mine.py:PolyHold --from 10ms --to 100ms --per-decade 3"),
        &["poly-hold"],
    );
    let advice = "advise --case bouncing-ball --scheme mine.py:PolyHold --error 90% --phases 1 --from 1ms --to 2ms";
    assert_has(&call(advice), &["--scheme poly-hold", "--scheme-file", "mine.py:PolyHold"]);

    fs::write(here.join("grid.toml"), format!("{GRID}{}", row("PolyHold"))).unwrap();
    call("run grid.toml --out out");
    let ids = |line: &str| json(&mut inside(here, line))["runs"].as_array().unwrap().clone();
    let plan = ids("run grid.toml --dry-run --format json");
    let verify = |line: &str| call(&format!("{line}verify grid.toml --results out"));
    assert_has(&verify(""), &["every verdict is the recorded one"]);
    call("report out --out page.html");
    // Other code, other runs of its own; equal code, the same.
    fs::write(here.join("mine.py"), format!("{MINE}\n# changed\n")).unwrap();
    let changed = ids("run grid.toml --dry-run --format json");
    assert_eq!(changed[0], plan[0]);
    assert_ne!(changed[1]["run_id"], plan[1]["run_id"]);
    fs::create_dir(here.join("elsewhere")).unwrap();
    fs::remove_file(here.join("mine.py")).unwrap();
    fs::write(here.join("elsewhere/mine.py"), MINE).unwrap();
    let missing = refused(&mut inside(here, "verify grid.toml --results out"));
    assert_has(&missing, &["[[schemes]] in line", "mine.py"]);
    assert_eq!(ids("run grid.toml --dry-run --format json --scheme-file elsewhere/mine.py:PolyHold"), plan);
    assert_has(&verify("--scheme-file elsewhere/mine.py:PolyHold "), &["every verdict is the recorded one"]);
}

#[test]
fn what_is_no_scheme_is_refused_in_one_sentence() {
    let Some(folder) = folder() else { return };
    for (scheme, wanted) in [
        ("mine.py:Mute", "class Mute has no method `input`, `polynomial` or `inputs`"),
        ("mine.py:Nobody", "no attribute 'Nobody'"),
        ("mine.py:ZeroOrderHold", "a name that is not taken yet"),
        ("none.py:PolyHold", "none.py"),
        ("mine.py", "a class in it, as in mine.py:MidHold"),
    ] {
        let refused = refused(&mut inside(folder.path(), &format!("simulate --case bouncing-ball --scheme {scheme}")));
        assert_has(&refused, &[wanted]);
    }
    let fmu = "fmu --case wedge-box --side actuator --out a.fmu --scheme-file mine.py:PolyHold";
    assert_has(&refused(&mut inside(folder.path(), fmu)), &["an FMU is one side of a case"]);
    for (rows, wanted) in [
        ("file = \"mine.py\"".to_owned(), "file and class"),
        (row("not a class"), "the name of a class of Python"),
        (row("PolyHold").replace("2.0", "0.0"), "answer_within_s"),
        (row("PolyHold").replace("mine.py", "nobody.py"), "nobody.py"),
        (row("ZeroOrderHold") + "label = \"mine\"\n", "a name that is not taken yet"),
    ] {
        let rows = rows.trim_start().trim_start_matches("[[schemes]]\n").to_owned();
        fs::write(folder.path().join("grid.toml"), format!("{GRID}\n[[schemes]]\n{rows}\n")).unwrap();
        assert_has(&refused(&mut inside(folder.path(), "run grid.toml --out out")), &["[[schemes]] in line", wanted]);
    }
}

/// The page is copied as whoever reads it would.
#[test]
fn what_the_guide_shows_runs_as_it_is() {
    let Some(folder) = folder() else { return };
    let guide = read(root().join("docs/guide/own-scheme.md"));
    let block =
        |kind: &str| guide.split(&format!("```{kind}\n")).nth(1).unwrap().split("```").next().unwrap().to_owned();
    fs::write(folder.path().join("mine.py"), block("python")).unwrap();
    fs::write(folder.path().join("sweep.toml"), block("toml")).unwrap();
    for line in ["run sweep.toml --out sweep", "verify sweep.toml --results sweep", "report sweep --out page.html"] {
        printed(&mut inside(folder.path(), line));
    }
    assert_has(&read(folder.path().join("sweep/runs.csv")), &["mid-hold"]);
    assert!(!read(folder.path().join("sweep/runs.csv")).contains("scheme-failed"));
}

//! Nothing silently wrong: what could be mixed up, lost, left over or half there is told apart, made again, or said.

use crate::program::{process, rimbench};
use assert_cmd::Command;
use std::path::{Path, PathBuf};
use std::process::Stdio;

const EXPERIMENT: &str = r#"
question = "What can go wrong without a word?"
macro_steps_s = [2e-3, 5e-3]
phases = 4
duration_s = 0.1

[[cases]]
name = "wedge-box"

[[schemes]]
scheme = "zero-order-hold"

[[schemes]]
scheme = "rim-nonsmooth"

[[claims]]
id = "stable"
by = "ours"
text = "stable at the beginning"
scheme = "rim-nonsmooth"
metric = "diverged"
statistic = "max"
expect = "<= 0"
finding = "reproduced"
"#;

/// A folder with experiment files `group/<name>.toml`.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Place(tempfile::tempdir().unwrap());
        std::fs::create_dir(place.path("group")).unwrap();
        place
    }

    fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, text: &str) -> PathBuf {
        let file = self.path("group/strict.toml");
        std::fs::write(&file, text).unwrap();
        file
    }

    /// Where results go without `--out`.
    fn results(&self) -> PathBuf {
        self.path("results/group/strict")
    }

    fn run(&self, text: &str) -> String {
        let file = self.write(text);
        let output = rimbench().current_dir(&self.0).arg("run").arg(file).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).unwrap()
    }

    fn verify(&self, code: i32) -> String {
        let file = self.path("group/strict.toml");
        let output = rimbench().current_dir(&self.0).arg("verify").arg(file).assert().code(code);
        let output = output.get_output();
        String::from_utf8([output.stdout.clone(), output.stderr.clone()].concat()).unwrap()
    }

    /// A column of `runs.csv`.
    fn column(&self, name: &str) -> Vec<String> {
        let mut table = csv::Reader::from_path(self.results().join("runs.csv")).unwrap();
        let column = table.headers().unwrap().iter().position(|column| column == name).unwrap();
        table.records().map(|row| row.unwrap()[column].to_owned()).collect()
    }
}

fn refused(command: &mut Command) -> String {
    let output = command.assert().code(2);
    String::from_utf8(output.get_output().stderr.clone()).unwrap()
}

#[test]
fn rows_with_different_gains_are_told_apart_in_the_table_and_by_claims() {
    let place = Place::new();
    let text = EXPERIMENT
        .replace("scheme = \"zero-order-hold\"", "scheme = \"nepce\"\ngain = 0.25\n[[schemes]]\nscheme = \"nepce\"");
    place.run(&text);
    let labels = place.column("label");
    assert_eq!(labels.iter().filter(|label| *label == "nepce/gain=0.25").count(), 8);
    assert_eq!(labels.iter().filter(|label| *label == "nepce").count(), 8);
    assert_eq!(place.column("gain").iter().filter(|gain| *gain == "0.25").count(), 8);
}

#[test]
fn a_run_that_took_too_long_is_made_again_when_it_may_take_longer() {
    let place = Place::new();
    // The reference is at hand.
    place.run(EXPERIMENT);
    std::fs::remove_dir_all(place.results()).unwrap();
    let limited = |limit: &str| EXPERIMENT.replace("duration_s", &format!("wall_limit_s = {limit}\nduration_s"));
    place.run(&limited("1e-9"));
    assert!(place.column("outcome").iter().all(|outcome| outcome == "timeout"));
    assert!(place.column("wall_limit_s").iter().all(|limit| limit == "1e-9"));
    // Given no more time, what is there stands.
    for limit in ["1e-9", "5e-10"] {
        assert!(place.run(&limited(limit)).contains("0 computed now"), "{limit}");
    }
    let printed = place.run(&limited("1000.0"));
    assert!(
        printed.contains("16 computed now") && printed.contains("16 of those computed had been stored"),
        "{printed}"
    );
    assert!(place.column("outcome").iter().all(|outcome| outcome != "timeout"));
    // What came to its end stands under every limit, and without one.
    assert!(place.run(&limited("1e-9")).contains("0 computed now"));
    assert!(place.run(EXPERIMENT).contains("0 computed now"));
}

#[test]
fn the_wall_limit_covers_the_reference() {
    let place = Place::new();
    let file = place.write(&EXPERIMENT.replace("duration_s", "wall_limit_s = 1e-3\nduration_s"));
    // With a cache of its own the reference has to be computed.
    let run = || {
        rimbench()
            .current_dir(&place.0)
            .env("RIMBENCH_CACHE", place.path("cache"))
            .arg("run")
            .arg(&file)
            .assert()
            .success()
    };
    run();
    assert!(place.column("outcome").iter().all(|outcome| outcome == "timeout"));
    assert!(place.column("ended_at_s").iter().all(|end| end == "0.0"));
    place.write(EXPERIMENT);
    run();
    assert!(place.column("outcome").iter().all(|outcome| outcome != "timeout"));
    place.verify(0);
}

#[test]
fn verify_goes_on_after_a_file_that_it_cannot_check_and_says_which() {
    let place = Place::new();
    place.run(EXPERIMENT);
    std::fs::write(place.path("group/broken.toml"), "macro_steps_s = \n").unwrap();
    let files = ["group/broken.toml", "group/nowhere.toml", "group/strict.toml"];
    let output = rimbench().current_dir(&place.0).arg("verify").args(files).assert().code(2).get_output().clone();
    let (said, shown) = (String::from_utf8(output.stderr).unwrap(), String::from_utf8(output.stdout).unwrap());
    assert!(said.contains("broken.toml") && said.contains("nowhere.toml") && !said.contains("strict.toml"), "{said}");
    assert!(shown.contains("those of 2 of 3 files could not be checked"), "{shown}");
}

#[test]
fn verify_counts_the_runs_and_refuses_what_is_not_the_plan() {
    let place = Place::new();
    place.run(EXPERIMENT);
    place.verify(0);
    let path = place.results().join("runs.csv");
    let whole = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<&str> = whole.lines().collect();
    let with = |text: &str, wanted: &[&str]| {
        std::fs::write(&path, text).unwrap();
        let message = place.verify(2);
        wanted.iter().for_each(|wanted| assert!(message.contains(wanted), "{wanted}: {message}"));
    };
    with(&rows[..2].join("\n"), &["16 planned, 1 found", "15 missing"]);
    with(&format!("{whole}{}\n{}\n", rows[1], rows[3]), &["16 planned, 16 found", "2 there twice"]);
    with(&whole.replace("rim-nonsmooth,", "rim-smooth,"), &["8 with another label or other settings"]);
    // A number in a row that is otherwise as planned.
    let completed = whole.replacen("completed", "diverged", 1);
    assert_ne!(completed, whole);
    with(&completed, &["runs.csv has been changed", "run the experiment again"]);
    std::fs::write(&path, &whole).unwrap();
    place.verify(0);
    // The experiment has been edited since.
    place.write(&EXPERIMENT.replace("phases = 4", "phases = 3"));
    assert!(place.verify(2).contains("12 planned, 12 found; 4 not planned"));
    place.write(&EXPERIMENT.replace("[2e-3, 5e-3]", "[2e-3, 5e-3, 7e-3]"));
    assert!(place.verify(2).contains("24 planned, 16 found; 8 missing"));
    place.write(&EXPERIMENT.replace("duration_s", "reference_step_s = 5e-5\nduration_s"));
    assert!(place.verify(2).contains("another reference_step_s"));
    // Any file counts, and so does the list itself.
    place.write(EXPERIMENT);
    std::fs::remove_file(place.results().join("reference.csv")).unwrap();
    assert!(place.verify(2).contains("reference.csv is missing"));
    place.run(EXPERIMENT);
    place.verify(0);
    // Without it rows are held against the digest that is kept of them; claims were not kept here.
    std::fs::remove_file(place.results().join("SHA256SUMS")).unwrap();
    assert!(place.verify(2).contains("claims.csv"));
    std::fs::write(&path, &completed).unwrap();
    assert!(place.verify(2).contains("is not that of digest.toml"));
    std::fs::remove_file(place.results().join("digest.toml")).unwrap();
    assert!(place.verify(2).contains("digest.toml"));
}

#[test]
fn a_finding_that_was_never_recorded_is_no_failure() {
    let place = Place::new();
    place.run(EXPERIMENT);
    place.write(&EXPERIMENT.replace("\"reproduced\"", "\"not-measured\""));
    assert!(place.verify(0).contains("0 differ"));
    place.write(&EXPERIMENT.replace("\"reproduced\"", "\"not-reproduced\""));
    place.verify(1);
}

#[test]
fn claims_that_would_pool_or_that_nobody_can_check_are_refused() {
    let several =
        EXPERIMENT.replace("name = \"wedge-box\"", "name = \"wedge-box\"\nset = { box_mass_kg = [200.0, 210.0] }");
    let cases = EXPERIMENT
        .replace("[[schemes]]\nscheme = \"zero", "[[cases]]\nname = \"bouncing-ball\"\n[[schemes]]\nscheme = \"zero");
    let claim = EXPERIMENT.split_once("[[claims]]").unwrap().1;
    let said = |text: &str, key: &str| {
        text.replace("scheme = \"rim-nonsmooth\"\nmetric", &format!("{key}\nscheme = \"rim-nonsmooth\"\nmetric"))
    };
    let place = Place::new();
    for (text, wanted) in [
        (several.clone(), "say set = one of \"box_mass_kg=200.0\", \"box_mass_kg=210.0\", or set = \"all\""),
        (cases.clone(), "say case = one of \"bouncing-ball\", \"wedge-box\", or case = \"all\""),
        (said(&several, "set = \"box_mass_kg=220.0\""), "unknown set of a claim"),
        (said(&cases, "case = \"wedge-bocks\""), "unknown case of a claim `wedge-bocks` (did you mean `wedge-box`?)"),
        (format!("{EXPERIMENT}\n[[claims]]{claim}"), "two claims have the id `stable`"),
        (EXPERIMENT.replace("<= 0", ">= nan"), "is no comparison"),
        (EXPERIMENT.replace("<= 0", "<= inf"), "the number finite"),
    ] {
        let message = refused(rimbench().args(["run", "--dry-run"]).arg(place.write(&text)));
        assert!(message.contains(wanted), "{wanted}: {message}");
    }
    for text in [
        said(&several, "set = \"all\""),
        said(&several, "set = \"box_mass_kg=200.0\""),
        said(&cases, "case = \"wedge-box\""),
    ] {
        rimbench().args(["run", "--dry-run"]).arg(place.write(&text)).assert().success();
    }
}

#[test]
fn shards_in_folders_of_any_name_are_collected() {
    let place = Place::new();
    place.run(EXPERIMENT);
    let file = place.path("group/strict.toml");
    for part in 1..=3 {
        let run = ["--shard", &format!("{part}/3"), "--out", &format!("s{part}")];
        rimbench().current_dir(&place.0).arg("run").arg(&file).args(run).assert().success();
    }
    let merge = ["--out", "s2", "--collect", "s1", "s3", "s1", "s2"];
    let output = rimbench().current_dir(&place.0).arg("run").arg(&file).args(merge).assert().success();
    assert!(String::from_utf8_lossy(&output.get_output().stdout).contains("16 of 16 runs in s2"));
    for name in ["runs.csv", "reference.csv", "parameters.csv"] {
        let [one, other] = [place.path("s2"), place.results()].map(|folder| std::fs::read(folder.join(name)).unwrap());
        assert!(one == other, "{name}");
    }
    // What is collected may be run again under its own name.
    rimbench().current_dir(&place.0).arg("run").arg(&file).args(["--out", "s2"]).assert().success();
}

#[test]
fn collect_says_that_there_are_records_of_other_runs_where_some_are_missing() {
    let place = Place::new();
    place.run(EXPERIMENT);
    let collected = |file: &Path| {
        let output =
            rimbench().arg("run").arg(file).arg("--out").arg(place.results()).arg("--collect").output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (code, said) = collected(&place.path("group/strict.toml"));
    assert!(code == Some(0) && !said.contains("other runs"), "{said}");
    let (code, said) = collected(&place.write(&EXPERIMENT.replace("[2e-3, 5e-3]", "[2e-3, 4e-3]")));
    assert!(code == Some(1) && said.contains("8 of 16 runs"), "{said}");
    assert!(said.contains("\nrecords of other runs: 8; has"), "{said}");
}

#[test]
fn traces_asked_for_later_or_with_another_step_are_made_and_damaged_ones_made_again() {
    let place = Place::new();
    let traced = |step: &str| EXPERIMENT.replace("duration_s", &format!("trace_every_s = {step}\nduration_s"));
    place.run(EXPERIMENT);
    assert!(!place.results().join("traces").exists());
    assert!(place.run(&traced("1e-2")).contains("16 computed now"));
    let trace = || place.results().join("traces").join(&place.column("trace")[8]);
    let rows = |path: PathBuf| std::fs::read_to_string(path).unwrap().lines().count();
    let coarse = rows(trace());
    assert!(place.run(&traced("1e-2")).contains("0 computed now"));
    assert!(place.run(&traced("5e-3")).contains("16 computed now"));
    assert!(rows(trace()) > coarse, "the new step is that of the trace");
    let whole = std::fs::read_to_string(trace()).unwrap();
    for damage in [None, Some(""), Some(&whole[..whole.len() / 2])] {
        match damage {
            None => std::fs::remove_file(trace()).unwrap(),
            Some(text) => std::fs::write(trace(), text).unwrap(),
        }
        assert!(place.verify(2).contains("run the experiment again"));
        assert!(place.run(&traced("5e-3")).contains("1 computed now"));
        assert_eq!(std::fs::read_to_string(trace()).unwrap(), whole);
        place.verify(0);
    }
    // Asked for no longer.
    assert!(place.run(EXPERIMENT).contains("0 computed now"));
    assert!(place.column("trace").iter().all(String::is_empty));
}

#[test]
fn a_renamed_label_is_that_of_rows_that_were_there() {
    let place = Place::new();
    place.run(EXPERIMENT);
    let renamed = EXPERIMENT.replace("scheme = \"zero-order-hold\"", "scheme = \"zero-order-hold\"\nlabel = \"hold\"");
    assert!(place.run(&renamed).contains("0 computed now"));
    assert_eq!(place.column("label").iter().filter(|label| *label == "hold").count(), 8);
    place.verify(0);
}

#[test]
fn neither_another_experiment_nor_a_file_of_the_user_is_replaced() {
    let place = Place::new();
    let file = place.write(EXPERIMENT);
    std::fs::create_dir(place.path("other")).unwrap();
    let other = place.path("other/strict.toml");
    // Most of the runs are the same.
    std::fs::write(&other, EXPERIMENT.replace("[2e-3, 5e-3]", "[2e-3, 7e-3]")).unwrap();
    let run = |file: &Path, more: &[&str]| {
        let mut command = rimbench();
        command.current_dir(&place.0).arg("run").arg(file).args(["--out", "s"]).args(more);
        command
    };
    run(&file, &[]).assert().success();
    let before = std::fs::read(place.path("s/runs.csv")).unwrap();
    let message = refused(&mut run(&other, &[]));
    assert!(
        message.contains("group/strict.toml") && message.contains("same name") && message.contains("--fresh"),
        "{message}"
    );
    assert_eq!(std::fs::read(place.path("s/runs.csv")).unwrap(), before);
    run(&other, &["--fresh"]).assert().success();
    assert_ne!(std::fs::read(place.path("s/runs.csv")).unwrap(), before);
    // Without its records the folder is still another experiment's, if no run is shared.
    std::fs::remove_dir_all(place.path("s/records")).unwrap();
    std::fs::write(&other, EXPERIMENT.replace("[2e-3, 5e-3]", "[3e-3]").replace("0.1", "0.2")).unwrap();
    assert!(refused(&mut run(&other, &[])).contains("another experiment of the same name"));

    std::fs::create_dir(place.path("own")).unwrap();
    std::fs::write(place.path("own/runs.csv"), "date,distance_km\n2026-01-01,12\n").unwrap();
    for more in [&["--out", "own"] as &[&str], &["--out", "own", "--fresh"]] {
        let message = refused(rimbench().current_dir(&place.0).arg("run").arg(&file).args(more));
        assert!(message.contains("runs.csv") && message.contains("would be replaced"), "{message}");
    }
    assert_eq!(std::fs::read_dir(place.path("own")).unwrap().count(), 1);
    std::fs::remove_file(place.path("own/runs.csv")).unwrap();
    std::fs::write(place.path("own/experiment.toml"), "my = \"own\"\n").unwrap();
    assert!(
        refused(rimbench().current_dir(&place.0).arg("run").arg(&file).args(["--out", "own"]))
            .contains("experiment.toml")
    );
}

#[test]
fn results_that_vanish_meanwhile_are_an_error() {
    let place = Place::new();
    let file = place.write(&EXPERIMENT.replace("phases = 4", "phases = 600"));
    let process = process()
        .current_dir(&place.0)
        .args(["run", file.to_str().unwrap(), "--out", "s"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let has_log = || {
        let entries = std::fs::read_dir(place.path("s/records")).into_iter().flatten();
        entries.flatten().any(|entry| entry.path().extension().is_some_and(|extension| extension == "log"))
    };
    while !has_log() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    std::fs::remove_dir_all(place.path("s")).unwrap();
    let output = process.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("had been stored") || message.contains("cannot be"), "{message}");
}

#[test]
fn in_a_fresh_clone_only_what_is_missing_is_computed() {
    let place = Place::new();
    let traced = EXPERIMENT.replace("duration_s", "trace_every_s = 1e-2\nduration_s");
    place.run(&traced);
    let before: Vec<_> = ["runs.csv", "cost.csv", "provenance.csv", "SHA256SUMS"]
        .map(|name| std::fs::read_to_string(place.results().join(name)).unwrap())
        .into();
    std::fs::remove_dir_all(place.results().join("records")).unwrap();
    assert!(place.run(&traced).contains("0 computed now"));
    for (name, text) in ["runs.csv", "cost.csv", "provenance.csv", "SHA256SUMS"].iter().zip(&before) {
        assert!(std::fs::read_to_string(place.results().join(name)).unwrap() == *text, "{name}");
    }
    std::fs::remove_dir_all(place.results().join("records")).unwrap();
    assert!(place.run(&traced.replace("phases = 4", "phases = 5")).contains("4 computed now"));
    // What was changed by hand is not believed.
    std::fs::remove_dir_all(place.results().join("records")).unwrap();
    let path = place.results().join("runs.csv");
    std::fs::write(&path, std::fs::read_to_string(&path).unwrap().replacen("completed", "diverged", 1)).unwrap();
    assert!(place.run(&traced).contains("16 computed now"));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), before[0]);
}

#[test]
fn the_reference_states_the_step_that_was_taken() {
    let place = Place::new();
    // Points lie 5e-5 s apart, so of 3e-5 s become two steps of 2.5e-5 s, and a quarter of that for the finest.
    place.run(&EXPERIMENT.replace("duration_s", "reference_step_s = 3e-5\nduration_s"));
    let text = std::fs::read_to_string(place.results().join("reference.csv")).unwrap();
    let step: f64 = text.lines().nth(1).unwrap().rsplit(',').next().unwrap().parse().unwrap();
    approx::assert_relative_eq!(step, 6.25e-6, max_relative = 1e-12);
}

#[test]
fn a_value_equal_to_the_default_stands_in_the_table() {
    let place = Place::new();
    let text =
        EXPERIMENT.replace("name = \"wedge-box\"", "name = \"wedge-box\"\nset = { box_mass_kg = [200.0, 210.0] }");
    place.run(text.split("[[claims]]").next().unwrap());
    let sets = place.column("set");
    assert_eq!(sets.iter().filter(|set| *set == "box_mass_kg=200.0").count(), 16);
    assert_eq!(sets.iter().filter(|set| *set == "box_mass_kg=210.0").count(), 16);
}

#[test]
fn what_is_said_twice_or_has_no_length_or_does_not_apply_is_refused() {
    let simulate = |arguments: &[&str]| {
        refused(rimbench().args(["simulate", "--case", "wedge-box", "--scheme", "rim-smooth"]).args(arguments))
    };
    let message = simulate(&["--set", "box_mass_kg=200", "--set", "box_mass_kg=300"]);
    assert!(message.contains("each key once; box_mass_kg is 200 already"), "{message}");
    assert!(simulate(&["--phase", "1e-300"]).contains("phase = 1e-300"));
    assert!(simulate(&["--duration", "1000", "--macro-step", "0.1"]).contains("duration = "));
    assert!(refused(rimbench().args(["list", "schemes", "--case", "wedge-box"])).contains("--case"));
    let printed = |arguments: &[&str]| {
        String::from_utf8(rimbench().arg("list").args(arguments).assert().success().get_output().stdout.clone())
            .unwrap()
    };
    let cases = printed(&["cases", "--case", "wedge-box"]);
    assert!(cases.contains("wedge-box") && !cases.contains("bouncing-ball"), "{cases}");
    assert!(printed(&["parameters", "--case", "elastic-bar"]).contains("a whole number from 1 to 500"));
}

#[test]
fn a_plan_says_first_how_many_runs_it_has_and_shows_as_many_as_can_be_read() {
    let place = Place::new();
    let file = place.write(&EXPERIMENT.replace("phases = 4", "phases = 100"));
    let printed = |more: &[&str]| {
        let output = rimbench().arg("run").arg(&file).arg("--dry-run").args(more).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).unwrap()
    };
    let short = printed(&[]);
    assert!(short.lines().take(4).any(|line| line == "400 runs, 1 claims") && short.lines().count() < 60, "{short}");
    assert!(short.contains("… and 360 more: --all shows them"));
    assert!(printed(&["--all"]).lines().count() > 400);
}

#[test]
fn a_cache_that_is_of_no_use_says_so() {
    let place = Place::new();
    std::fs::write(place.path("file"), "").unwrap();
    let arguments = ["simulate", "--case", "wedge-box", "--scheme", "rim-smooth", "--duration", "0.05"];
    let output = rimbench().env("RIMBENCH_CACHE", place.path("file")).args(arguments).assert().success();
    let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(said.contains("note: the cache of references is of no use here"), "{said}");
}

#[test]
fn a_group_without_figures_is_refused() {
    let place = Place::new();
    std::fs::create_dir(place.path("results")).unwrap();
    let message = refused(rimbench().args(["report", "--figures", "--group", "nope"]).arg(place.path("results")));
    assert!(message.contains("unknown group of figures `nope`"), "{message}");
}

//! Nothing silently wrong: what could be mixed up, lost, left over or half there is told apart, made again, or said.

use crate::program::{assert_has, assert_refused, call, printed, process, refused, rimbench, said};
use rimbench::everything;
use rimbench::harness::{Experiment, check_claims, write_claims};
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
metric = "failed"
statistic = "max"
expect = "<= 0"
finding = "reproduced"
"#;

/// The first table of rows in a folder `records`, beside which other files stand.
fn table_in(records: &Path) -> PathBuf {
    let mut paths = std::fs::read_dir(records).unwrap().map(|entry| entry.unwrap().path());
    paths.find(|path| path.extension().is_some_and(|extension| extension == "csv")).unwrap()
}

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
        printed(rimbench().current_dir(&self.0).arg("run").arg(file))
    }

    /// The same, of which so many runs are computed and the others were there.
    fn run_computing(&self, count: usize, text: &str) {
        let printed = self.run(text);
        assert!(printed.contains(&format!("{count} computed now")), "{count}: {printed}");
    }

    fn verify(&self, code: i32) -> String {
        said(rimbench().current_dir(&self.0).arg("verify").arg(self.path("group/strict.toml")), code)
    }

    /// Verified, it is refused in these words.
    fn verify_says(&self, wanted: &[&str]) {
        assert_has(&self.verify(2), wanted);
    }

    fn vanish(&self, name: &str) {
        let path = self.results().join(name);
        if path.is_dir() { std::fs::remove_dir_all(path).unwrap() } else { std::fs::remove_file(path).unwrap() }
    }

    /// A column of `runs.csv`.
    fn column(&self, name: &str) -> Vec<String> {
        let mut table = csv::Reader::from_path(self.results().join("runs.csv")).unwrap();
        let column = table.headers().unwrap().iter().position(|column| column == name).unwrap();
        table.records().map(|row| row.unwrap()[column].to_owned()).collect()
    }

    /// How often a cell stands in a column.
    fn count(&self, name: &str, cell: &str) -> usize {
        self.column(name).iter().filter(|found| *found == cell).count()
    }
}

/// The experiment with one more key before its duration.
fn with_key(key: &str) -> String {
    EXPERIMENT.replace("duration_s", &format!("{key}\nduration_s"))
}

/// The experiment with two masses of the box.
fn with_two_masses() -> String {
    EXPERIMENT.replace("name = \"wedge-box\"", "name = \"wedge-box\"\nset = { box_mass_kg = [200.0, 210.0] }")
}

#[test]
fn a_run_that_took_too_long_is_made_again_when_it_may_take_longer() {
    let place = Place::new();
    // The reference is at hand.
    place.run(EXPERIMENT);
    place.vanish("");
    let limited = |limit: &str| with_key(&format!("wall_limit_s = {limit}"));
    place.run(&limited("1e-9"));
    assert_eq!((place.count("outcome", "timeout"), place.count("wall_limit_s", "1e-9")), (16, 16));
    // Given no more time, what is there stands.
    for limit in ["1e-9", "5e-10"] {
        place.run_computing(0, &limited(limit));
    }
    let longer = place.run(&limited("1000.0"));
    assert_has(&longer, &["16 computed now", "16 of those computed had been stored"]);
    assert_eq!(place.count("outcome", "timeout"), 0);
    // What came to its end stands under every limit, and without one.
    place.run_computing(0, &limited("1e-9"));
    place.run_computing(0, EXPERIMENT);
}

#[test]
fn the_wall_limit_covers_the_reference() {
    let place = Place::new();
    // With a cache of its own the reference has to be computed.
    let run = |text: &str| {
        let file = place.write(text);
        printed(rimbench().current_dir(&place.0).env("RIMBENCH_CACHE", place.path("cache")).arg("run").arg(file))
    };
    run(&with_key("wall_limit_s = 1e-3"));
    assert_eq!((place.count("outcome", "timeout"), place.count("ended_at_s", "0.0")), (16, 16));
    run(EXPERIMENT);
    assert_eq!(place.count("outcome", "timeout"), 0);
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
    assert!(shown.contains("2 of 3 files could not be checked"), "{shown}");
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
        place.verify_says(wanted);
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
    for (text, wanted) in [
        (EXPERIMENT.replace("phases = 4", "phases = 3"), "12 planned, 12 found; 4 not planned"),
        (EXPERIMENT.replace("[2e-3, 5e-3]", "[2e-3, 5e-3, 7e-3]"), "24 planned, 16 found; 8 missing"),
        (with_key("reference_step_s = 5e-5"), "another reference_step_s"),
    ] {
        place.write(&text);
        place.verify_says(&[wanted]);
    }
    // Any file counts, and so does the list itself.
    place.write(EXPERIMENT);
    place.vanish("reference.csv");
    place.verify_says(&["reference.csv is missing"]);
    place.run(EXPERIMENT);
    place.verify(0);
    // Without the list, what was run here is not known to be whole.
    place.vanish("SHA256SUMS");
    place.verify_says(&["SHA256SUMS", "missing or empty"]);
    // Of a checkout few files are kept: rows are held against the digest.
    place.vanish("cost.csv");
    place.vanish("records");
    place.verify(0);
    std::fs::write(&path, &completed).unwrap();
    place.verify_says(&["is not that of digest.toml"]);
    place.vanish("digest.toml");
    place.verify_says(&["digest.toml"]);
}

/// Writes the checksums of a folder again, as a forger would.
fn seal(folder: &Path) {
    let sums = rimbench::checksums::read(folder).unwrap().unwrap();
    rimbench::checksums::write(folder, sums.into_keys()).unwrap();
}

#[test]
fn whatever_is_made_of_something_that_is_there_is_made_again_and_compared() {
    let place = Place::new();
    place.run(EXPERIMENT);
    place.verify(0);
    let path = |name: &str| place.results().join(name);
    let text = |name: &str| std::fs::read_to_string(path(name)).unwrap();
    let [summary, digest, runs] = ["summary.csv", "digest.toml", "runs.csv"].map(text);
    let with_sum =
        |text: &str| digest.replacen(&rimbench::checksums::sha256(&summary), &rimbench::checksums::sha256(text), 1);
    let forged = summary.replacen(",4,4,", ",4,3,", 1);
    assert!(forged != summary && with_sum(&forged) != digest);
    let other_rows = runs.replacen(",0.0", ",1.0", 1);
    let of_other_rows = digest.replace(&rimbench::checksums::sha256(&runs), &rimbench::checksums::sha256(&other_rows));
    let other_plan = digest.lines().map(|line| match line.starts_with("plan_sha256") {
        true => format!("plan_sha256 = \"{}\"\n", "0".repeat(64)),
        false => format!("{line}\n"),
    });
    for (files, sealed, wanted) in [
        // Changed alone, any file is missed by its checksum.
        (vec![("summary.csv", forged.clone())], false, "summary.csv has been changed"),
        (vec![("digest.toml", digest.replace("rows = 16", "rows = 5"))], false, "digest.toml has been changed"),
        // With the checksums of the list, by that of the digest, by the plan and by the rows.
        (vec![("summary.csv", forged.clone())], true, "is not that of digest.toml"),
        (vec![("digest.toml", digest.replace("rows = 16", "rows = 5"))], true, "is of 5 runs"),
        (vec![("digest.toml", other_plan.collect())], true, "is not of the runs"),
        (vec![("summary.csv", forged.clone()), ("digest.toml", with_sum(&forged))], true, "is not that of runs.csv"),
        (vec![("runs.csv", other_rows), ("digest.toml", of_other_rows)], true, ""),
    ] {
        files.iter().for_each(|(name, text)| std::fs::write(path(name), text).unwrap());
        if sealed {
            seal(&place.results());
        }
        place.verify_says(&[wanted, "run the experiment again"]);
        for (name, text) in [("summary.csv", &summary), ("digest.toml", &digest), ("runs.csv", &runs)] {
            std::fs::write(path(name), text).unwrap();
        }
        seal(&place.results());
        place.verify(0);
    }
    // All that is made of rows may fit together: what was stored when they were run does not.
    let outcome = runs.replacen(",completed,", ",completed ,", 1);
    assert_ne!(outcome, runs);
    let number = place.column("force_error_rms_n")[0].clone();
    let (fake, scratch) = (runs.replacen(&number, "1.25", 1), tempfile::tempdir().unwrap());
    std::fs::write(scratch.path().join("runs.csv"), &fake).unwrap();
    rimbench::kept::keep(
        scratch.path(),
        &Default::default(),
        &rimbench::kept::Digest::read(&place.results()).unwrap().plan_sha256,
    )
    .unwrap();
    for name in ["runs.csv", "summary.csv", "digest.toml"] {
        std::fs::copy(scratch.path().join(name), path(name)).unwrap();
    }
    seal(&place.results());
    place.verify_says(&["runs.csv", "is not what is stored in records/"]);
    place.vanish("records");
    place.verify(0);
}

#[test]
fn claims_that_are_written_are_those_that_the_rows_give() {
    let place = Place::new();
    place.run(EXPERIMENT);
    let experiment = rimbench::harness::Experiment::read(&place.path("group/strict.toml")).unwrap();
    let catalogue = rimbench::catalogue::Catalogue::standard();
    let claims = rimbench::harness::check_claims(&experiment, &catalogue, &place.results()).unwrap();
    let path = place.results().join("claims.csv");
    rimbench::harness::write_claims(&path, &claims).unwrap();
    place.verify(0);
    let text = std::fs::read_to_string(&path).unwrap();
    for (from, to, wanted) in [
        (",0.0,", ",0.1,", "something else of `stable` than the rows"),
        (",reproduced,reproduced", ",not-reproduced,reproduced", "something else of `stable` than the rows"),
        ("strict,stable,", "strict,other,", "holds other claims than"),
    ] {
        let edited = text.replacen(from, to, 1);
        assert_ne!(edited, text);
        std::fs::write(&path, edited).unwrap();
        place.verify_says(&["claims.csv", wanted]);
    }
}

#[test]
fn verify_finds_what_run_wrote_to_a_folder_of_its_own_and_says_how_to_make_what_is_not_there() {
    let place = Place::new();
    let file = place.write(EXPERIMENT);
    let verify = |results: &str, code| {
        said(rimbench().current_dir(&place.0).arg("verify").arg(&file).args(["--results", results]), code)
    };
    assert_has(&verify("elsewhere", 2), &["--out elsewhere/group/strict` makes it"]);
    printed(rimbench().current_dir(&place.0).arg("run").arg(&file).args(["--out", "elsewhere"]));
    assert_has(&verify("elsewhere", 0), &["1 claim: every verdict is the recorded one"]);
}

#[test]
fn a_defect_of_another_build_is_computed_again_and_one_of_this_build_is_not() {
    let place = Place::new();
    place.run(EXPERIMENT);
    let records = place.results().join("records");
    let table = table_in(&records);
    let whole = std::fs::read_to_string(&table).unwrap();
    let lines: Vec<&str> = whole.lines().collect();
    let names: Vec<&str> = lines[1].split(',').collect();
    let place_of = |name: &str| names.iter().position(|own| *own == name).unwrap();
    let with = |changes: &[(&str, &str)]| {
        let mut cells: Vec<&str> = lines[2].split(',').collect();
        changes.iter().for_each(|(name, text)| cells[place_of(name)] = text);
        let line = cells[..cells.len() - 1].join(",");
        let sealed = format!("{line},{}", &rimbench::checksums::sha256(&line)[..16]);
        std::fs::write(&table, whole.replace(lines[2], &sealed)).unwrap();
    };
    with(&[("outcome", "panicked"), ("reason", "defect of rimbench: clock")]);
    place.run_computing(0, EXPERIMENT);
    with(&[("outcome", "panicked"), ("reason", "defect of rimbench: clock"), ("git_revision", "0123456789ab")]);
    place.run_computing(1, EXPERIMENT);
    // The new row stands, though the old one is there as well.
    place.run_computing(0, EXPERIMENT);
    assert_eq!(place.count("outcome", "panicked"), 0);
}

#[test]
fn a_finding_that_was_never_recorded_is_no_failure() {
    let place = Place::new();
    place.run(EXPERIMENT);
    place.write(&EXPERIMENT.replace("\"reproduced\"", "\"not-measured\""));
    assert_has(&place.verify(0), &["1 claim: of 1 no verdict is recorded"]);
    place.write(&EXPERIMENT.replace("\"reproduced\"", "\"not-reproduced\""));
    place.verify(1);
    // Nor is a claim that does not hold, where it is recorded so.
    place.write(&EXPERIMENT.replace("<= 0", "<= -1"));
    place.verify(1);
    place.write(&EXPERIMENT.replace("<= 0", "<= -1").replace("\"reproduced\"", "\"not-reproduced\""));
    place.verify(0);
}

#[test]
fn claims_that_would_pool_or_that_nobody_can_check_are_refused() {
    let several = with_two_masses();
    let cases = EXPERIMENT
        .replace("[[schemes]]\nscheme = \"zero", "[[cases]]\nname = \"bouncing-ball\"\n[[schemes]]\nscheme = \"zero");
    let claim = EXPERIMENT.split_once("[[claims]]").unwrap().1;
    let said = |text: &str, key: &str| {
        text.replace("scheme = \"rim-nonsmooth\"\nmetric", &format!("{key}\nscheme = \"rim-nonsmooth\"\nmetric"))
    };
    let claim_with = |key: &str, other: &str| {
        let (head, claim) = EXPERIMENT.split_once("[[claims]]").unwrap();
        format!("{head}[[claims]]{}", claim.replacen(key, other, 1))
    };
    let of_errors = |text: &str| text.replace("metric = \"failed\"", "metric = \"force_error_rms_n\"");
    let drawn = said(
        &EXPERIMENT.replacen(
            "name = \"wedge-box\"",
            "name = \"wedge-box\"\ndraw = { settings = 2, seed = 1, declared = [\"box_mass_kg\"] }",
            1,
        ),
        "set = \"all\"",
    );
    let other = "[[schemes]]\nscheme = \"rim-nonsmooth\"\nlabel = \"other\"\nmacro_steps_s = [1e-3]\n\n[[claims]]";
    let two_steps =
        of_errors(&claim_with("scheme", "relative_to = \"other\"\nscheme")).replacen("[[claims]]", other, 1);
    let place = Place::new();
    for (text, wanted) in [
        (several.clone(), "say set = one of \"box_mass_kg=200.0\", \"box_mass_kg=210.0\", or set = \"all\""),
        (cases.clone(), "say case = one of \"bouncing-ball\", \"wedge-box\", or case = \"all\""),
        (said(&several, "set = \"box_mass_kg=220.0\""), "unknown set of a claim"),
        (said(EXPERIMENT, "set = \"x\""), "unknown set of a claim `x`\nhelp: use \"\""),
        (said(&cases, "case = \"wedge-bocks\""), "unknown case of a claim `wedge-bocks`"),
        (format!("{EXPERIMENT}\n[[claims]]{claim}"), "two claims have the id `stable`"),
        (claim_with("id = \"stable\"", "id = \"\""), "id of a claim = \"\" is not valid"),
        (claim_with("id = \"stable\"", "id = \"a b\""), "letters, digits"),
        (claim_with("id = \"stable\"", "id = \"../x\""), "letters, digits"),
        (claim_with("id = \"stable\"", "id = \"a\\nb\""), "letters, digits"),
        (claim_with("metric", "relative_to = \"rim-nonsmooth\"\nmetric"), "relative to itself"),
        (claim_with("metric", "witnesses = \"all\"\nmetric"), "witnesses chooses runs by how they end"),
        (claim_with("metric", "witnesses = \"some\"\nmetric"), "unknown variant `some`"),
        (claim_with("\"failed\"", "\"fails\""), "`metric = \"fails\"`: unknown metric of a claim `fails`"),
        (
            claim_with("metric", "at_equal = \"exchange\"\nmetric"),
            "`at_equal = \"exchange\"`: unknown counter `exchange`",
        ),
        (claim_with("metric", "at_equal = [200, -1]\nmetric"), "exchanges and mechanics steps per second"),
        (claim_with("metric", "at_equal = [200, 1000]\nmetric"), "needs relative_to"),
        (claim_with("metric", "without = \"x\"\nmetric"), "needs budgets in at_equal"),
        (format!("budgets.per_s = [[200, 0]]\n{EXPERIMENT}"), "budgets.per_s = [200.0, 0.0] is not valid"),
        (EXPERIMENT.replace("<= 0", ">= nan"), "is no comparison"),
        (EXPERIMENT.replace("<= 0", "<= inf"), "the number finite"),
    ] {
        let message = refused(rimbench().args(["run", "--dry-run"]).arg(place.write(&text)));
        assert!(message.contains(wanted), "{wanted}: {message}");
    }
    for (text, wanted) in [
        // A newton of a wedge box is none of a ball.
        (
            of_errors(&said(&cases, "case = \"all\"")),
            "claim `stable`: metric = \"force_error_rms_n\" would pool N of 2 machines",
        ),
        (of_errors(&said(&cases, "case = \"all\"")), "use a metric without a unit (as force_error_rms_of_peak)"),
        (of_errors(&drawn), "claim `stable`: metric = \"force_error_rms_n\" would pool N of 2 machines"),
        (two_steps.clone(), "`rim-nonsmooth` and relative_to = \"other\" have no macro step in common"),
    ] {
        let message = refused(rimbench().args(["run", "--dry-run"]).arg(place.write(&text)));
        assert!(message.contains(wanted), "{wanted}: {message}");
    }
    let shares = two_steps.replace("force_error_rms_n", "failed").replace("\"max\"", "\"mean\"");
    let message = refused(rimbench().args(["run", "--dry-run"]).arg(place.write(&shares)));
    assert_has(&message, &["a share of 8 runs of `rim-nonsmooth` against one of 4 other runs"]);
    for text in [
        of_errors(&said(&cases, "case = \"all\"")).replace("_n\"", "_of_peak\""),
        of_errors(&said(&cases, "case = \"all\"\nrelative_to = \"zero-order-hold\"")),
        of_errors(&said(&cases, "case = \"wedge-box\"")),
        of_errors(&said(&several, "set = \"all\"")),
        two_steps.replace("[1e-3]", "[5e-3]"),
        shares.replace("[1e-3]", "[2e-3, 5e-3]"),
        said(&several, "set = \"all\""),
        said(&several, "set = \"box_mass_kg=200.0\""),
        said(&cases, "case = \"wedge-box\""),
    ] {
        rimbench().args(["run", "--dry-run"]).arg(place.write(&text)).assert().success();
    }
}

#[test]
fn collect_says_that_there_are_records_of_other_runs_where_some_are_missing() {
    let place = Place::new();
    place.run(EXPERIMENT);
    let collected = |file: &Path, code: i32| {
        said(rimbench().arg("run").arg(file).arg("--out").arg(place.results()).arg("--collect"), code)
    };
    let whole = collected(&place.path("group/strict.toml"), 0);
    assert!(!whole.contains("other runs"), "{whole}");
    let other = collected(&place.write(&EXPERIMENT.replace("[2e-3, 5e-3]", "[2e-3, 4e-3]")), 1);
    assert_has(&other, &["8 of 16 runs", "\nrows of other runs: 8; has"]);
}

#[test]
fn traces_asked_for_later_or_with_another_step_are_made_and_damaged_ones_made_again() {
    let place = Place::new();
    let traced = |step: &str| with_key(&format!("trace_every_s = {step}"));
    place.run(EXPERIMENT);
    assert!(!place.results().join("traces").exists());
    place.run_computing(16, &traced("1e-2"));
    let trace = || place.results().join("traces").join(&place.column("trace")[8]);
    let rows = |path: PathBuf| std::fs::read_to_string(path).unwrap().lines().count();
    let coarse = rows(trace());
    place.run_computing(0, &traced("1e-2"));
    place.run_computing(16, &traced("5e-3"));
    assert!(rows(trace()) > coarse, "the new step is that of the trace");
    let whole = std::fs::read_to_string(trace()).unwrap();
    for damage in [None, Some(""), Some(&whole[..whole.len() / 2])] {
        match damage {
            None => std::fs::remove_file(trace()).unwrap(),
            Some(text) => std::fs::write(trace(), text).unwrap(),
        }
        place.verify_says(&["run the experiment again"]);
        place.run_computing(1, &traced("5e-3"));
        assert_eq!(std::fs::read_to_string(trace()).unwrap(), whole);
        place.verify(0);
    }
    // Asked for no longer.
    place.run_computing(0, EXPERIMENT);
    assert_eq!(place.count("trace", ""), 16);
}

#[test]
fn a_renamed_label_is_that_of_rows_that_were_there() {
    let place = Place::new();
    place.run(EXPERIMENT);
    let renamed = EXPERIMENT.replace("scheme = \"zero-order-hold\"", "scheme = \"zero-order-hold\"\nlabel = \"hold\"");
    place.run_computing(0, &renamed);
    assert_eq!(place.count("label", "hold"), 8);
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
    assert_has(&message, &["group/strict.toml", "same name", "--fresh"]);
    assert_eq!(std::fs::read(place.path("s/runs.csv")).unwrap(), before);
    run(&other, &["--fresh"]).assert().success();
    assert_ne!(std::fs::read(place.path("s/runs.csv")).unwrap(), before);
    // A table that is empty holds nothing that could be lost.
    std::fs::write(place.path("s/runs.csv"), "").unwrap();
    run(&other, &[]).assert().success();
    // Without its records the folder is still another experiment's, if no run is shared.
    std::fs::remove_dir_all(place.path("s/records")).unwrap();
    std::fs::write(&other, EXPERIMENT.replace("[2e-3, 5e-3]", "[3e-3]").replace("0.1", "0.2")).unwrap();
    assert!(refused(&mut run(&other, &[])).contains("another experiment of the same name"));
    // A run is shared by what determines it, whatever id another version of the numerics gave it.
    let rows = std::fs::read_to_string(place.path("s/runs.csv")).unwrap();
    let with_other_ids = rows.lines().enumerate().map(|(line, row)| match row.split_once(',') {
        Some((_, rest)) if line > 0 => format!("{line:016x},{rest}\n"),
        _ => format!("{row}\n"),
    });
    std::fs::write(place.path("s/runs.csv"), with_other_ids.collect::<String>()).unwrap();
    std::fs::write(&other, EXPERIMENT.replace("[2e-3, 5e-3]", "[2e-3, 9e-3]")).unwrap();
    run(&other, &[]).assert().success();

    // The command that is named is one of a shell.
    let blank = printed(rimbench().current_dir(&place.0).arg("run").arg(&file).args(["--out", "my own"]));
    assert_has(&blank, &["`rimbench report 'my own'`"]);

    std::fs::create_dir(place.path("own")).unwrap();
    let refused_in_own = |more: &[&str]| {
        refused(rimbench().current_dir(&place.0).arg("run").arg(&file).args(["--out", "own"]).args(more))
    };
    std::fs::write(place.path("own/runs.csv"), "date,distance_km\n2026-01-01,12\n").unwrap();
    for more in [&[] as &[&str], &["--fresh"]] {
        assert_has(&refused_in_own(more), &["runs.csv", "would be replaced"]);
    }
    assert_eq!(std::fs::read_dir(place.path("own")).unwrap().count(), 1);
    std::fs::remove_file(place.path("own/runs.csv")).unwrap();
    std::fs::write(place.path("own/experiment.toml"), "my = \"own\"\n").unwrap();
    assert_has(&refused_in_own(&[]), &["experiment.toml"]);
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
        entries.flatten().any(|entry| entry.path().extension().is_some_and(|extension| extension == "csv"))
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
fn a_damaged_row_is_named_by_its_place_and_computed_again() {
    let place = Place::new();
    place.run(EXPERIMENT);
    let kept = ["runs.csv", "digest.toml"].map(|name| place.results().join(name));
    let contents = || kept.each_ref().map(|path| std::fs::read_to_string(path).unwrap());
    let before = contents();
    let table = table_in(&place.results().join("records"));
    let (table_name, whole) = (table.file_name().unwrap().to_string_lossy(), std::fs::read_to_string(&table).unwrap());
    let line = whole.lines().nth(6).unwrap();
    for (text, again) in [
        (whole.replace(line, &line.replacen("completed", "diverged", 1)), vec![7]),
        (whole.replace(line, &line[1..]), vec![7]),
        (whole.replacen("outcome", "income", 1), (3..19).collect()),
        (whole[..whole.len() - 9].to_owned(), vec![18]),
    ] {
        place.vanish("records");
        std::fs::create_dir(place.results().join("records")).unwrap();
        std::fs::write(&table, text).unwrap();
        let said = place.run(EXPERIMENT);
        assert_has(&said, &[&format!("{} computed now", again.len())]);
        again.iter().for_each(|line| assert_has(&said, &[&format!("{table_name}, line {line}: the row is damaged")]));
        assert!(contents() == before, "what is kept has changed");
    }
    // Result files are made of stored rows only: what was changed by hand in them is not believed, and made again.
    std::fs::write(&kept[0], before[0].replacen("completed", "diverged", 1)).unwrap();
    place.run_computing(0, EXPERIMENT);
    place.vanish("records");
    place.run_computing(16, EXPERIMENT);
    assert!(contents() == before, "what is kept has changed");
}

#[test]
fn the_reference_states_the_step_that_was_taken() {
    let place = Place::new();
    // Points lie 5e-5 s apart, so of 3e-5 s become two steps of 2.5e-5 s, and a quarter of that for the finest.
    place.run(&with_key("reference_step_s = 3e-5"));
    let text = std::fs::read_to_string(place.results().join("reference.csv")).unwrap();
    let step: f64 = text.lines().nth(1).unwrap().rsplit(',').next().unwrap().parse().unwrap();
    approx::assert_relative_eq!(step, 6.25e-6, max_relative = 1e-12);
}

#[test]
fn a_value_equal_to_the_default_stands_in_the_table() {
    let place = Place::new();
    place.run(with_two_masses().split("[[claims]]").next().unwrap());
    for set in ["box_mass_kg=200.0", "box_mass_kg=210.0"] {
        assert_eq!(place.count("set", set), 16, "{set}");
    }
}

#[test]
fn lists_are_of_one_case_where_that_means_something() {
    assert_refused("list", &[("schemes --case wedge-box", "--case")]);
    let cases = printed(&mut call("list cases --case wedge-box"));
    assert!(cases.contains("wedge-box") && !cases.contains("bouncing-ball"), "{cases}");
    assert_has(&printed(&mut call("list parameters --case elastic-bar --long")), &["a whole number from 1 to 500"]);
}

#[test]
fn a_list_of_cases_for_programs_has_ports_times_columns_and_what_the_ranking_asks() {
    let cases: serde_json::Value = serde_json::from_str(&printed(&mut call("list cases --format json"))).unwrap();
    let cases = cases.as_array().unwrap();
    let of = |name: &str| cases.iter().find(|case| case["name"] == name).unwrap();
    let asked = |case: &serde_json::Value| case["grid"]["ranking"].as_array().unwrap().clone();
    let ranked: Vec<_> = cases.iter().flat_map(asked).collect();
    let problems = ranked.iter().map(|set| set["macro_steps_s"].as_array().unwrap().len());
    assert_eq!((ranked.len(), problems.sum::<usize>()), (16, 68));
    assert!(asked(of("tripod")).is_empty());
    let bar = of("elastic-bar");
    assert_eq!(asked(bar)[0]["macro_steps_s"], serde_json::json!([1e-6, 2e-6, 5e-6]));
    for case in everything().unwrap().cases() {
        let said = of(&case.name);
        assert_eq!(said["duration_s"], case.defaults.duration_s);
        assert_eq!(said["grid"]["micro_step_s"], case.defaults.micro_step_s);
        assert_eq!(said["columns"].as_array().unwrap().len(), case.trace_columns.len());
        let [mechanics, actuator] = ["mechanics", "actuator"].map(|side| &said["ports"][side]);
        assert_eq!((&mechanics["inputs"], &mechanics["outputs"]), (&actuator["outputs"], &actuator["inputs"]));
    }
    let length = &of("wedge-box")["ports"]["mechanics"]["outputs"][0];
    assert_eq!((length["name"].as_str(), length["unit"].as_str()), (Some("actuator_length_m"), Some("m")));
    assert!(length["start"].as_f64().unwrap() > 2.5, "{length}");
    // The number of a pressure is no part of its unit.
    let unit = |case: &str, column: &str| {
        let columns = of(case)["columns"].as_array().unwrap().clone();
        columns.iter().find(|known| known["name"] == column).map(|known| known["unit"].clone())
    };
    assert_eq!(
        [unit("wedge-box", "pressure_1_pa"), unit("wedge-box", "pressure_2_pa")],
        [Some("Pa".into()), Some("Pa".into())]
    );
}

#[test]
fn a_plan_says_first_how_many_runs_it_has_and_shows_as_many_as_can_be_read() {
    let place = Place::new();
    let file = place.write(&EXPERIMENT.replace("phases = 4", "phases = 100"));
    let plan = |more: &[&str]| printed(rimbench().arg("run").arg(&file).arg("--dry-run").args(more));
    let short = plan(&[]);
    assert!(short.lines().take(4).any(|line| line == "400 runs, 1 claim") && short.lines().count() < 60, "{short}");
    assert_has(&short, &["… and 360 more: --all shows them"]);
    assert!(plan(&["--all"]).lines().count() > 400);
}

/// An audit fills columns, so that it is part of what a run is; one that was skipped, or took too long, has its row all
/// the same.
#[test]
fn an_audited_experiment_with_runs_that_have_no_account_finishes() {
    let place = Place::new();
    // The mechanics of that case offers no model.
    let hold = "[[schemes]]\nscheme = \"zero-order-hold\"";
    let other = "[[cases]]\nname = \"precice-oscillator\"";
    let bare = EXPERIMENT.split("[[claims]]").next().unwrap().replace(hold, other);
    let audited = bare.replace("duration_s", "audit = true\nduration_s");
    place.run_computing(16, &audited);
    assert_eq!((place.count("outcome", "skipped"), place.count("heaviness_max", "")), (8, 8));
    place.run_computing(0, &audited);
    let ids = place.column("run_id");
    // The same runs without an audit are others.
    let place = Place::new();
    place.run_computing(16, &bare);
    assert!(place.column("run_id").iter().all(|id| !ids.contains(id)));
    place.run_computing(16, &audited);
    assert_eq!(place.column("run_id"), ids);
    let slow = audited.replace("duration_s", "wall_limit_s = 1e-9\nduration_s");
    let place = Place::new();
    place.run(&audited);
    place.vanish("");
    place.run_computing(16, &slow);
    place.run_computing(0, &slow);
}

/// A prediction fills columns of claims, so that rows without it are no answer where it is claimed, and those with it
/// are one where it is not.
#[test]
fn a_prediction_that_is_claimed_later_is_made_and_kept_beside_the_rows_without_it() {
    let place = Place::new();
    let claimed =
        EXPERIMENT.replace("metric = \"failed\"", "metric = \"completed_as_predicted\"").replace("<= 0", "<= 1");
    place.run_computing(16, EXPERIMENT);
    place.run_computing(16, &claimed);
    assert_eq!(place.count("completed_as_predicted", ""), 0);
    [EXPERIMENT, &claimed].into_iter().for_each(|text| place.run_computing(0, text));
    let place = Place::new();
    place.run_computing(16, &claimed);
    place.run_computing(0, EXPERIMENT);
}

#[test]
fn one_run_under_two_labels_is_computed_once_and_has_a_row_for_each() {
    let place = Place::new();
    let row = |label: &str, steps: &str| {
        format!("[[schemes]]\nscheme = \"rim-smooth\"\nlabel = \"{label}\"\nmechanics_steps = {steps}\n")
    };
    let text = format!(
        "question = \"?\"\nmacro_steps_s = [1e-3]\nduration_s = 0.1\n[[cases]]\nname = \"wedge-box\"\n{}{}",
        row("twenty", "20"),
        row("every", "\"all\"")
    );
    place.run_computing(1, &text);
    let (ids, labels) = (place.column("run_id"), place.column("label"));
    assert_eq!((ids.len(), &ids[0], labels), (2, &ids[1], vec!["twenty".to_owned(), "every".to_owned()]));
    place.run_computing(0, &text);
    place.verify(0);
    // The trace of the second.
    let traced = text.replace("duration_s", "trace_every_s = 1e-2\ntraces = [\"every\"]\nduration_s");
    place.run_computing(1, &traced);
    assert_eq!(place.column("trace"), ["", &format!("{}.csv", ids[0])]);
    place.run_computing(0, &traced);
}

/// As in a fresh clone: digest and summary, and no rows.
#[test]
fn what_is_kept_without_rows_is_held_against_the_experiment() {
    let place = Place::new();
    let text = EXPERIMENT.split("[[claims]]").next().unwrap();
    place.run(text);
    for name in ["runs.csv", "SHA256SUMS", "experiment.toml", "records"] {
        place.vanish(name);
    }
    place.verify(0);
    for (edited, wanted) in [
        (text.replace("[2e-3, 5e-3]", "[2e-3, 5e-3, 7e-3]"), "is of 16 runs, and"),
        (text.replace("[2e-3, 5e-3]", "[2e-3, 6e-3]"), "a setting or a label is another"),
        (text.replace("duration_s = 0.1", "duration_s = 0.11"), "a setting or a label is another"),
        (
            text.replace("duration_s = 0.1", "duration_s = 0.1\nreference_step_s = 5e-5"),
            "a setting or a label is another",
        ),
    ] {
        place.write(&edited);
        place.verify_says(&[wanted, "digest.toml", "run the experiment again"]);
    }
    place.write(text);
    let digest = place.results().join("digest.toml");
    let whole = std::fs::read_to_string(&digest).unwrap();
    std::fs::write(&digest, whole.replace("rows = 16", "rows = 5")).unwrap();
    place.verify_says(&["is of 5 runs, and", "has 16"]);
}

#[test]
fn rows_are_those_of_the_digest_that_is_kept() {
    let place = Place::new();
    place.run(EXPERIMENT);
    place.verify(0);
    let digest = place.results().join("digest.toml");
    let whole = std::fs::read_to_string(&digest).unwrap();
    let (before, sum) = whole.split_once("runs_sha256 = \"").unwrap();
    std::fs::write(&digest, format!("{before}runs_sha256 = \"{}{}", "0".repeat(8), &sum[8..])).unwrap();
    place.verify_says(&["digest.toml has been changed"]);
    seal(&place.results());
    place.verify_says(&["runs.csv", "is not that of digest.toml"]);
}

/// Without rows a verdict and the number of failed runs must still follow from what is kept.
#[test]
fn a_kept_verdict_that_does_not_follow_from_what_was_measured_is_refused() {
    let place = Place::new();
    let bad = EXPERIMENT.split_once("[[claims]]").unwrap().1.replace("\"stable\"", "\"small\"");
    let bad = bad.replace("metric = \"failed\"\nstatistic = \"max\"\nexpect = \"<= 0\"", MEDIAN);
    let text = format!("{EXPERIMENT}[[claims]]{bad}");
    place.run(&text);
    place.verify(0);
    let claims = place.results().join("claims.csv");
    if !claims.exists() {
        let experiment = Experiment::read(&place.path("group/strict.toml")).unwrap();
        let measured = check_claims(&experiment, &everything().unwrap(), &place.results()).unwrap();
        write_claims(&claims, &measured).unwrap();
    }
    for file in ["runs.csv", "SHA256SUMS"] {
        std::fs::remove_file(place.results().join(file)).unwrap();
    }
    place.verify(0);
    let whole = std::fs::read_to_string(&claims).unwrap();
    let last = |old: &str, new: &str| {
        let (before, after) = whole.rsplit_once(old).unwrap();
        std::fs::write(&claims, format!("{before}{new}{after}")).unwrap();
    };
    last(",reproduced,reproduced,", ",not-reproduced,reproduced,");
    place.verify_says(&["small", "does not follow from what was measured"]);
    last(",0\n", ",1\n");
    place.verify_says(&["1 runs of `small` failed, and the summary says 0"]);
    std::fs::write(&claims, whole.clone()).unwrap();
    place.verify(0);
}

/// A claim on the median of one row.
const MEDIAN: &str = "macro_step_s = 5e-3\nmetric = \"force_error_rms_n\"\nstatistic = \"median\"\nexpect = \"<= 1e9\"";

#[test]
fn narrow_terminals_and_closed_pipes_are_no_panic_and_a_list_in_a_pipe_is_whole() {
    for columns in ["1", "2", "3", "19"] {
        for line in ["simulate --case linear-oscillator --scheme nepce --duration 0.1 --all", "list schemes", "--help"]
        {
            assert!(!said(call(line).env("COLUMNS", columns), 0).contains("panicked"));
        }
    }
    assert!(!printed(&mut call("list cases")).contains('…'));
    let program = assert_cmd::cargo::cargo_bin("rimbench");
    let script = format!("{{ {} simulate --case nowhere; echo $? >&3; }} 2>&- 3>&1", program.display());
    let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "2");
}

/// What was asked has an answer, whichever it is, or none, which is another exit code.
#[test]
fn a_run_without_an_answer_has_another_exit_code_than_one_that_failed() {
    let run = "simulate --case wedge-box --macro-step 5ms --duration 0.3";
    said(&mut call(&format!("{run} --scheme rim-nonsmooth-gap")), 0);
    assert_has(&said(&mut call(&format!("{run} --scheme rim-split")), 1), &["not run"]);
    assert_has(&said(&mut call(&format!("{run} --scheme rim-nonsmooth-gap --wall-limit 1e-9")), 1), &["timeout"]);
    let limit = "limit --case wedge-box --scheme rim-nonsmooth-gap --from 2ms --to 8ms --duration 0.3 --per-decade 2";
    assert_has(&said(&mut call(limit), 0), &["stable up to 8 ms, the largest tried"]);
    let limited = said(&mut call(&format!("{limit} --wall-limit 1e-9")), 1);
    assert_has(&limited, &["no answer at the smallest macro step", "wall-time limit"]);
    assert!(!limited.contains("unstable"), "{limited}");
}

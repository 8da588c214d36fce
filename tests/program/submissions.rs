//! A third party's scheme: passes when it is honest, and is refused or found out by name when it is not; and joins the ranking.

use crate::program::rimbench;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Stdio};
use std::sync::LazyLock;

/// Whether the example's language is there.
fn has_python() -> bool {
    let found = Process::new("python3").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    let found = found.is_ok_and(|status| status.success());
    if !found {
        eprintln!("skipped: no python3");
    }
    found
}

/// The example with its package, made once.
static MADE: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/submission");
    for entry in std::fs::read_dir(example).unwrap().map(|entry| entry.unwrap()).filter(|entry| entry.path().is_file())
    {
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    let scheme = folder.path().join("scheme.toml");
    let results = folder.path().join("results/sweep");
    let sweep = folder.path().join("sweep.toml");
    with(&scheme).arg("run").arg(&sweep).arg("--out").arg(&results).assert().success();
    pack(&scheme, &results, &folder.path().join("package"));
    folder
});

fn with(scheme: &Path) -> assert_cmd::Command {
    let mut command = rimbench();
    command.arg("--scheme-file").arg(scheme);
    command
}

fn pack(scheme: &Path, results: &Path, out: &Path) {
    with(scheme)
        .arg("export")
        .arg(results)
        .arg("--out")
        .arg(out)
        .args(["--author", "The rimbench authors"])
        .assert()
        .success();
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// Copies a folder.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(|entry| entry.unwrap()) {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// A copy of the example and its package.
fn copied() -> tempfile::TempDir {
    let to = tempfile::tempdir().unwrap();
    copy(MADE.path(), to.path());
    to
}

fn edit(folder: &Path, name: &str, from: &str, to: &str) {
    let before = read(folder.join(name));
    assert!(before.contains(from), "{name} has no {from}");
    std::fs::write(folder.join(name), before.replace(from, to)).unwrap();
}

fn checked(folder: &Path, options: &[&str]) -> (Option<i32>, String) {
    let output = rimbench().arg("check-submission").arg(folder).args(options).assert().get_output().clone();
    let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
    (output.status.code(), said)
}

/// The example that is a crate, with its package; none where cargo cannot build it without a network.
fn of_a_crate() -> Option<tempfile::TempDir> {
    let folder = tempfile::tempdir().unwrap();
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/submission-crate"), folder.path());
    let built = Process::new("cargo")
        .envs(of_cargo())
        .args(["build", "--release", "--locked", "--offline", "--quiet", "--manifest-path"])
        .arg(folder.path().join("Cargo.toml"))
        .output();
    let Ok(built) = built else {
        eprintln!("skipped: there is no cargo on the path");
        return None;
    };
    if !built.status.success() {
        let said = String::from_utf8_lossy(&built.stderr);
        // A package that was never fetched is a reason to skip; what is wrong with the sources or the lock file is none.
        assert!(["but --offline was specified", "offline mode"].iter().any(|words| said.contains(words)), "{said}");
        eprintln!("skipped: cargo lacks what the example is built with: {said}");
        return None;
    }
    let [scheme, sweep, results, package] =
        ["scheme.toml", "sweep.toml", "results/sweep", "package"].map(|name| folder.path().join(name));
    with(&scheme).envs(of_cargo()).arg("run").arg(&sweep).arg("--out").arg(&results).assert().success();
    let export = ["--author", "The rimbench authors"];
    with(&scheme)
        .envs(of_cargo())
        .arg("export")
        .arg(&results)
        .arg("--out")
        .arg(&package)
        .args(export)
        .assert()
        .success();
    Some(folder)
}

/// Lets cargo keep what it builds where the tests of this project do, and ask nobody.
fn of_cargo() -> [(&'static str, PathBuf); 2] {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("submission-crate");
    [("CARGO_TARGET_DIR", target), ("CARGO_NET_OFFLINE", "true".into())]
}

/// The cells of a results table, run ids and what the program of the scheme is called aside.
fn numbers(runs: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(runs).unwrap();
    reader.records().map(|row| row.unwrap().iter().skip(1).map(str::to_owned).collect()).collect()
}

#[test]
fn a_crate_is_checked_like_a_class_and_has_its_numbers() {
    let Some(folder) = of_a_crate() else { return };
    let mut command = rimbench();
    command.envs(of_cargo()).arg("check-submission").arg(folder.path()).args(["--seed", "7", "--sample", "3"]);
    let output = command.assert().success().get_output().clone();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("3 equal to the digit, 0 not"), "{said}");
    if has_python() {
        // The same rule in two languages: the same bits, whoever writes and reads them.
        let [own, other] = [folder.path(), MADE.path()].map(|folder| numbers(&folder.join("results/sweep/runs.csv")));
        assert!(own.len() >= 8, "{own:?}");
        assert_eq!(own, other);
    }
}

#[test]
fn an_honest_submission_holds_joins_the_ranking_and_replaces_nobody() {
    if !has_python() {
        return;
    }
    let (folder, place) = (copied(), tempfile::tempdir().unwrap());
    let submissions = place.path().join("submissions");
    let accept = ["--seed", "7", "--sample", "3", "--accept", submissions.to_str().unwrap()];
    let (code, said) = checked(folder.path(), &accept);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("information `samples`, nothing tuned") && said.contains("3 equal to the digit, 0 not"),
        "{said}"
    );
    let check = read(submissions.join("smoothed-hold/check.csv"));
    assert_eq!(check.lines().filter(|line| line.ends_with(",7,true")).count(), 3, "{check}");
    let (code, said) = checked(folder.path(), &accept);
    assert!(code == Some(2) && said.contains("is there already"), "{said}");

    // The same problems, by schemes of this project: and one more, which the submission lacks.
    let rank = |name: &str, steps: &str| {
        let file = place.path().join("own").join(format!("{name}.toml"));
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        let rows = "[[schemes]]\nscheme = \"zero-order-hold\"\n[[schemes]]\nscheme = \"rim-nonsmooth-gap\"\n";
        let rows = rows.to_owned() + "[[schemes]]\nscheme = \"nepce\"\ngain = 0.25\n";
        let text = read(folder.path().join("sweep.toml"))
            .replace("[[schemes]]\nscheme = \"smoothed-hold\"\n", &rows)
            .replace("[1e-3, 2e-3]", steps);
        std::fs::write(&file, text).unwrap();
        let results = place.path().join("results");
        rimbench().arg("run").arg(&file).arg("--out").arg(results.join("own").join(name)).assert().success();
        let ranking = place.path().join(format!("{name}-ranking.toml"));
        std::fs::write(&ranking, format!("question = \"?\"\nexperiments = [\"own/{name}.toml\"]\n")).unwrap();
        let mut command = rimbench();
        command.arg("rank").arg(&ranking).arg("--results").arg(&results).arg("--submissions").arg(&submissions);
        let output = command.assert().success().get_output().clone();
        (String::from_utf8(output.stdout).unwrap(), read(results.join("ranking/ranking.csv")))
    };
    let (said, table) = rank("same", "[1e-3, 2e-3]");
    assert!(said.contains("smoothed-hold (submission smoothed-hold)") && said.contains("samples, tuned:"), "{said}");
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let classes: Vec<(&str, &str)> = rows.iter().map(|row| (row[0], row[4])).collect();
    assert_eq!(classes.len(), 4, "{table}");
    assert!(
        classes.contains(&("samples", "smoothed-hold")) && classes.contains(&("model", "rim-nonsmooth-gap")),
        "{table}"
    );
    let (said, table) = rank("more", "[1e-3, 2e-3, 4e-3]");
    assert!(said.contains("not ranked: smoothed-hold (submission smoothed-hold), lacks 4 problems"), "{said}");
    assert!(!table.contains("smoothed-hold"), "{table}");
    // Nor is what other numerics have computed, whether they are named or not.
    let own = submissions.join("smoothed-hold");
    let now = rimbench::numerics_version::NUMERICS_VERSION;
    let sealed = |from: &str, to: &str| {
        edit(&own, "check.csv", from, to);
        let names: Vec<String> = rimbench::checksums::read(&own).unwrap().unwrap().into_keys().collect();
        rimbench::checksums::write(&own, names).unwrap();
    };
    sealed(&format!(",{now},7,true"), ",1,7,true");
    let (said, table) = rank("same", "[1e-3, 2e-3]");
    assert!(said.contains("not ranked: smoothed-hold (submission smoothed-hold), computed by numerics 1; "), "{said}");
    assert!(!table.contains("smoothed-hold"), "{table}");
    sealed("numerics_version", "something_else");
    assert!(rank("same", "[1e-3, 2e-3]").0.contains("numerics of a version that is not written down; check it again"));
    // What was accepted and is changed is no longer believed.
    edit(&submissions, "smoothed-hold/submission.toml", "samples", "whole");
    let ranking = place.path().join("same-ranking.toml");
    let results = place.path().join("results");
    let output = rimbench()
        .arg("rank")
        .arg(&ranking)
        .arg("--results")
        .arg(&results)
        .arg("--submissions")
        .arg(&submissions)
        .assert();
    let said = String::from_utf8(output.code(2).get_output().stderr.clone()).unwrap();
    assert!(said.contains("submission.toml has been changed"), "{said}");
}

#[test]
fn a_number_that_a_submission_made_up_is_found_out_and_nothing_is_accepted() {
    if !has_python() {
        return;
    }
    let (folder, place) = (copied(), tempfile::tempdir().unwrap());
    let results = folder.path().join("results/sweep");
    let text = read(results.join("runs.csv"));
    let column = text.lines().next().unwrap().split(',').position(|name| name == "force_error_rms_of_peak").unwrap();
    let forged = |line: &str| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if line.contains(",completed,") {
            cells[column] = "0.0001";
        }
        cells.join(",") + "\n"
    };
    std::fs::write(results.join("runs.csv"), text.lines().map(forged).collect::<String>()).unwrap();
    let sums: Vec<String> = read(results.join("SHA256SUMS"))
        .lines()
        .map(|line| {
            let name = line.split("  ").nth(1).unwrap();
            format!("{}  {name}\n", rimbench::checksums::sha256_of_file(&results.join(name)).unwrap())
        })
        .collect();
    std::fs::write(results.join("SHA256SUMS"), sums.concat()).unwrap();
    std::fs::remove_dir_all(folder.path().join("package")).unwrap();
    pack(&folder.path().join("scheme.toml"), &results, &folder.path().join("package"));
    let (code, said) = checked(folder.path(), &["--accept", place.path().join("all").to_str().unwrap()]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("force_error_rms_of_peak is ") && said.contains("0.0001 in the package"), "{said}");
    assert!(said.contains("does not hold") && !place.path().join("all").exists(), "{said}");
}

#[test]
fn what_is_not_as_declared_is_refused_by_name() {
    if !has_python() {
        return;
    }
    let refused = |edited: &dyn Fn(&Path), wanted: &[&str]| {
        let folder = copied();
        edited(folder.path());
        let (code, said) = checked(folder.path(), &["--sample", "1"]);
        assert_eq!(code, Some(2), "{wanted:?}: {said}");
        assert!(wanted.iter().all(|wanted| said.contains(wanted)), "{wanted:?}: {said}");
    };
    // It asks for a model, and says that it needs none.
    let asks = |folder: &Path| {
        edit(folder, "lines.py", "\"role\": \"scheme\"", "\"role\": \"scheme\", \"needs\": [\"interface_model\"]")
    };
    refused(&asks, &["submission.toml: information = samples", "`model`"]);
    refused(
        &|folder| edit(folder, "scheme.toml", "python3", "no-such-language"),
        &["`no-such-language", "cannot be started"],
    );
    refused(
        &|folder| edit(folder, "lines.py", "import json", "raise SystemExit(3)"),
        &["scheme.toml", "exit status: 3"],
    );
    refused(&|folder| edit(folder, "scheme.toml", "20.0", "61.0"), &["scheme.toml", "answer_within_s", "at most 60 s"]);
    let elsewhere = |folder: &Path| edit(folder, "scheme.toml", "\"lines.py\"", "\"/no/such/lines.py\"");
    refused(&elsewhere, &["scheme.toml: command = /no/such/lines.py", "below the folder"]);
    // Another program than that of the package: its runs are other runs.
    refused(&|folder| edit(folder, "smoothed_hold.py", "0.5", "0.6"), &["package", "does not hold the runs"]);
    refused(
        &|folder| edit(folder, "submission.toml", "smoothed-hold", "smoother-hold"),
        &["describes a scheme called `smoothed-hold`"],
    );
    refused(
        &|folder| edit(folder, "submission.toml", "[\"package\"]", "[\"packet\"]"),
        &["packet", "is no data package"],
    );
    refused(
        &|folder| std::fs::remove_file(folder.join("submission.toml")).unwrap(),
        &["submission.toml: cannot be read"],
    );
    refused(&|folder| edit(folder, "package/runs.csv", "completed", "compleated"), &["runs.csv has been changed"]);
    let linked = |folder: &Path| edit(folder, "submission.toml", "\"scheme.toml\"", "\"../scheme.toml\"");
    refused(&linked, &["scheme = ../scheme.toml is not valid", "below the folder"]);
}

/// What comes before the first run counts as well.
#[test]
fn the_limit_holds_from_the_first_word_of_the_program_on() {
    if !has_python() {
        return;
    }
    let folder = copied();
    edit(folder.path(), "lines.py", "import json", "import json, time; time.sleep(2)");
    let (code, said) = checked(folder.path(), &["--limit", "1"]);
    assert!(code == Some(2) && said.contains("package: took longer than --limit 1 s"), "{said}");
}

/// A module that python finds before its own `json`: it writes to what lies on the disk, and hands over the real one.
const MEDDLER: &str = r#"
import pathlib, sys, tempfile
here = sys.path.pop(0)
del sys.modules["json"]
import json
sys.path.insert(0, here)
declaration = pathlib.Path(here, "submission.toml")
declaration.write_text(declaration.read_text().replace("The rimbench authors", "Nobody At All"))
if pathlib.Path(here, "forge").exists():
    for table in pathlib.Path(tempfile.gettempdir()).glob("*/package/results/runs.csv"):
        table.write_text(table.read_text().replace("completed,", "completed,0"))
"#;

#[test]
fn what_a_program_writes_while_it_is_checked_is_not_what_is_accepted() {
    if !has_python() {
        return;
    }
    let (folder, place) = (copied(), tempfile::tempdir().unwrap());
    let before = read(folder.path().join("submission.toml"));
    std::fs::write(folder.path().join("json.py"), MEDDLER).unwrap();
    let check = |name: &str| {
        let (scratch, out) = (tempfile::tempdir().unwrap(), place.path().join(name));
        let mut command = rimbench();
        command.arg("check-submission").arg(folder.path()).args(["--sample", "1", "--seed", "3", "--accept"]).arg(&out);
        let output = command.env("TMPDIR", scratch.path()).assert().get_output().clone();
        let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
        (output.status.code(), said, out)
    };
    let (code, said, out) = check("edited");
    assert_eq!(code, Some(0), "{said}");
    let after = read(folder.path().join("submission.toml"));
    assert!(after.contains("Nobody At All"), "the program did not meddle: {after}");
    assert_eq!(read(out.join("smoothed-hold/submission.toml")), before);
    assert_eq!(read(out.join("smoothed-hold/sweep/runs.csv")), read(folder.path().join("results/sweep/runs.csv")));
    if cfg!(unix) {
        std::fs::write(folder.path().join("forge"), "").unwrap();
        let (code, said, out) = check("forged");
        assert!(code == Some(2) && said.contains("has been changed while its runs were computed"), "{said}");
        assert!(!out.exists(), "{said}");
    }
}

/// One label, and another sequence where that is better.
#[test]
fn a_label_that_is_another_scheme_in_another_package_is_refused_with_both_values() {
    if !has_python() {
        return;
    }
    let folder = copied();
    let scheme = folder.path().join("scheme.toml");
    let one_case = |name: &str, case: &str, options: &str| {
        let text = format!(
            "question = \"?\"\nmacro_steps_s = [2e-3]\n[[cases]]\nname = \"{case}\"\nduration_s = 0.2\n\
             [[schemes]]\nscheme = \"smoothed-hold\"\nlabel = \"mine\"\n{options}"
        );
        let file = folder.path().join(format!("{name}.toml"));
        std::fs::write(&file, text).unwrap();
        let results = folder.path().join("results").join(name);
        with(&scheme).arg("run").arg(&file).arg("--out").arg(&results).assert().success();
        pack(&scheme, &results, &folder.path().join(format!("package-{name}")));
    };
    one_case("one", "bouncing-ball", "sequence = \"gauss-seidel-mechanics-first\"\n");
    one_case("other", "impact-oscillator", "");
    edit(folder.path(), "submission.toml", "[\"package\"]", "[\"package-one\", \"package-other\"]");
    let (code, said) = checked(folder.path(), &["--sample", "1"]);
    assert_eq!(code, Some(2), "{said}");
    for wanted in [
        "package-other: row `mine` has sequence = `gauss-seidel-mechanics-first` in package-one, bouncing-ball",
        "in package-other, impact-oscillator",
        "declare as [[tuned]]",
    ] {
        assert!(said.contains(wanted), "{wanted}: {said}");
    }
    let declared = read(folder.path().join("submission.toml"))
        + "\n[[tuned]]\nwhat = \"who goes first\"\ncases = [\"impact-oscillator\"]\n";
    std::fs::write(folder.path().join("submission.toml"), declared).unwrap();
    let (code, said) = checked(folder.path(), &["--sample", "1"]);
    assert_eq!(code, Some(0), "{said}");
}

fn rows_of(name: &str) -> Vec<BTreeMap<String, String>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/ranking").join(name);
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

/// Words between backticks.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

#[test]
fn the_table_of_the_ranking_is_that_of_its_rows() {
    let rows = rows_of("ranking.csv");
    let score = |row: &BTreeMap<String, String>| row["score"].parse::<f64>().unwrap() * 100.0;
    let page = read(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/results/ranking.md"));
    let table =
        page.lines().skip_while(|line| !line.starts_with("| class | row |")).take_while(|line| line.starts_with('|'));
    let (mut class, mut seen) = (String::new(), 0);
    for line in table.skip(2) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if let Some(named) = quoted(cells[0]).first() {
            class = (*named).to_owned();
        }
        let named: Vec<_> = quoted(cells[1])
            .into_iter()
            .map(|label| {
                let row = rows.iter().find(|row| row["class"] == class && row["label"] == label);
                row.unwrap_or_else(|| panic!("{line}: no {label} in {class}"))
            })
            .collect();
        assert!(!named.is_empty(), "{line}");
        seen += named.len();
        for row in &named {
            let [first, last] = [&row["rank"], &row["rank_last"]];
            let rank = if first == last { first.clone() } else { format!("{first}–{last}") };
            assert_eq!(cells[2], rank, "{line}: {}", row["label"]);
        }
        if cells[1].ends_with("the last") {
            let most = rows.iter().filter(|row| row["class"] == class).map(score).fold(0.0, f64::max);
            assert_eq!(named.iter().map(|row| score(row)).fold(0.0, f64::max), most, "{line}");
        }
        if let Some((_, counts)) = cells[1].split_once("`: ").filter(|(_, counts)| counts.contains("skipped")) {
            assert!(counts.starts_with(&format!("{} of {} ", named[0]["skipped"], named[0]["problems"])), "{line}");
        }
        let written: Vec<&str> = cells[3].trim_end_matches(" %").split(" to ").collect();
        let bounds = [
            named.iter().map(|row| score(row)).fold(f64::INFINITY, f64::min),
            named.iter().map(|row| score(row)).fold(0.0, f64::max),
        ];
        for (text, found) in [(written[0], bounds[0]), (written[written.len() - 1], bounds[1])] {
            let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32);
            let off = (text.parse::<f64>().unwrap() - found).abs();
            assert!(off <= 0.501 * 10_f64.powi(-decimals), "{line}: {found} %");
        }
    }
    assert!(seen >= 20, "only {seen} rows found");
}

#[test]
fn the_findings_of_the_ranking_follow_from_its_rows_and_claims() {
    let rows = rows_of("ranking.csv");
    let page = read(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/results/ranking.md"));
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let of_class = |class: &str| -> Vec<(String, f64, usize)> {
        let own = rows
            .iter()
            .filter(|row| row["class"] == class && row["tuned_on"].is_empty() && row["submission"].is_empty());
        let mut own: Vec<_> = own
            .map(|row| (row["label"].clone(), row["score"].parse().unwrap(), row["failed"].parse().unwrap()))
            .collect();
        own.sort_by(|a: &(String, f64, usize), b| a.1.total_cmp(&b.1));
        own
    };
    let (samples, models) = (of_class("samples"), of_class("model"));
    let (best, last) = (&samples[0], &samples[samples.len() - 1]);
    let ahead = models.iter().filter(|row| row.1 < best.1).count();
    let behind_most = |error: f64| 2 * samples.iter().filter(|row| row.1 < error).count() > samples.len();
    let worse: Vec<String> = models.iter().filter(|row| behind_most(row.1)).map(|row| format!("`{}`", row.0)).collect();
    let (smooth, others) = worse.split_last().unwrap();
    let paper = models.iter().find(|row| row.0 == "rim-nonsmooth").unwrap();
    let problems = &rows[0]["problems"];
    assert_eq!(smooth, "`rim-smooth`");
    for wanted in [
        format!("{problems} problems of"),
        format!("has {:.1} times its error", last.1 / best.1),
        format!("only {ahead} of the {} rows with a model have less error", models.len()),
        format!("needs samples only ({:.1} %); the paper's is one of them ({:.1} %)", best.1 * 100.0, paper.1 * 100.0),
        format!(
            "most of the {} rows with samples are {}: {} and {smooth}",
            samples.len(),
            worse.len(),
            others.join(", ")
        ),
        format!("fails in {} of {problems} problems", models[models.len() - 1].2),
        format!("fails in {} problems or more", samples.iter().map(|row| row.2).min().unwrap()),
    ] {
        assert!(page.contains(&wanted), "{wanted}");
    }
    assert!(paper.1 < best.1);
    // A ratio with its interval is that of a claim.
    let claims: Vec<String> = rows_of("claims.csv")
        .iter()
        .map(|claim| {
            let [measured, low, high] = ["measured", "low", "high"].map(|name| claim[name].parse::<f64>().unwrap());
            assert_eq!(claim["verdict"], "reproduced", "{}", claim["id"]);
            format!("({measured:.2} [{low:.2}, {high:.2}])")
        })
        .collect();
    assert_eq!(claims.len(), 7, "the page says seven");
    let quoted: Vec<&str> = page
        .match_indices("(0.")
        .map(|(place, _)| &page[place..=place + page[place..].find(')').unwrap()])
        .filter(|text| text.contains('['))
        .collect();
    assert!(quoted.len() >= 4, "{quoted:?}");
    for text in quoted {
        assert!(claims.iter().any(|claim| claim == text), "{text}: {claims:?}");
    }
}

/// A package in which the scheme does not occur, as of somebody else.
#[test]
fn a_package_of_another_scheme_is_no_package_of_this_one() {
    if !has_python() {
        return;
    }
    let folder = copied();
    let other: PathBuf = folder.path().join("other/sweep.toml");
    std::fs::create_dir_all(other.parent().unwrap()).unwrap();
    std::fs::write(&other, read(folder.path().join("sweep.toml")).replace("smoothed-hold", "zero-order-hold")).unwrap();
    let results = folder.path().join("other/results");
    rimbench().arg("run").arg(&other).arg("--out").arg(&results).assert().success();
    std::fs::remove_dir_all(folder.path().join("package")).unwrap();
    pack(&folder.path().join("scheme.toml"), &results, &folder.path().join("package"));
    let (code, said) = checked(folder.path(), &[]);
    assert!(code == Some(2) && said.contains("holds no run of `smoothed-hold`"), "{said}");
}

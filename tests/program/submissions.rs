//! A third party's scheme: passes when it is honest, and is refused or found out by name when it is not; and joins the ranking.

use crate::program::rimbench;
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

/// A copy of the example and its package.
fn copied() -> tempfile::TempDir {
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
    let hangs = |folder: &Path| {
        edit(folder, "lines.py", "import json", "import json, time; time.sleep(60)");
        edit(folder, "scheme.toml", "20.0", "0.5");
    };
    refused(&hangs, &["scheme.toml", "within 0.5 s"]);
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

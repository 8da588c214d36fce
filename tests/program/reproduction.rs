//! The main job, in quick form, from an empty folder: files, claims, figures, and that a second run changes nothing.

use crate::program::rimbench;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn reproduce(from: &Path, out: &Path) -> String {
    let output = rimbench()
        .current_dir(from)
        .args(["reproduce", "--quick", "--out"])
        .arg(out)
        .assert()
        .success()
        .get_output()
        .stdout
        .clone();
    String::from_utf8(output).unwrap()
}

/// All files below a folder with their contents, without those that depend on machine or time.
fn deterministic_files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if !["cost.csv", "provenance.csv", "SHA256SUMS"]
                .contains(&path.file_name().unwrap().to_str().unwrap())
            {
                let content = std::fs::read(&path).unwrap();
                files.insert(path.strip_prefix(folder).unwrap().to_owned(), content);
            }
        }
    }
    files
}

#[test]
fn the_quick_reproduction_is_complete_and_repeatable() {
    let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let printed = reproduce(Path::new(env!("CARGO_MANIFEST_DIR")), first.path());
    let files = deterministic_files(first.path());
    for name in [
        "paper/claims.csv",
        "paper/claims.md",
        "paper/report.html",
        "paper/fig1/runs.csv",
        "paper/fig2/runs.csv",
        "paper/fig2/reference.csv",
        "paper/fig2/parameters.csv",
        "paper/fig2/traces/reference.csv",
        "paper/fig1/figures/fig1.svg",
        "paper/fig1/figures/fig1.png",
        "paper/fig2/figures/fig2.svg",
        "paper/fig2/figures/fig2.png",
        "paper/phases/figures/phases.png",
        "paper/convergence/figures/convergence.png",
    ] {
        assert!(files.contains_key(Path::new(name)), "{name} is missing");
    }
    // Once from the project's folder, once from an empty one, with what the program carries.
    let empty = tempfile::tempdir().unwrap();
    reproduce(empty.path(), second.path());
    assert_eq!(std::fs::read_dir(empty.path()).unwrap().count(), 0, "it writes only where it is told to");
    let again = deterministic_files(second.path());
    assert_eq!(files.keys().collect::<Vec<_>>(), again.keys().collect::<Vec<_>>());
    for (name, content) in &files {
        // The report says of which day its results are.
        let made = |content: &[u8]| match name.ends_with("report.html") {
            true => String::from_utf8_lossy(content).lines().filter(|line| !line.contains("class=\"made\"")).collect(),
            false => String::from_utf8_lossy(content).into_owned(),
        };
        assert!(made(content) == made(&again[name]), "{} differs from run to run", name.display());
    }
    // Every claim of the paper is in the printed table, and none has left its recorded finding.
    let mut claims = csv::Reader::from_path(first.path().join("paper/claims.csv")).unwrap();
    let rows: Vec<BTreeMap<String, String>> = claims.deserialize().map(Result::unwrap).collect();
    assert!(rows.len() >= 20);
    for row in &rows {
        // Orders over three macro steps are not those over six; the full run checks them.
        if row["verdict"] != "not-measured" && row["experiment"] != "convergence" {
            assert_eq!(row["verdict"], row["finding"], "{}", row["id"]);
        }
        assert_eq!(row["verdict"] == "not-measured", row["measured"].is_empty(), "{}", row["id"]);
        assert!(row["measured"].is_empty() || row["runs"] != "0", "claim {} rests on no run", row["id"]);
    }
    assert!(printed.contains("reproduced") && printed.contains("report.html"));
}

#[test]
fn each_figure_names_an_experiment_and_its_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let figures = rimbench::figures::FigureList::read(&root.join("paper/figures.toml")).unwrap();
    assert!(figures.figures.len() >= 4);
    for figure in &figures.figures {
        let experiment = root.join("experiments").join(format!("{}.toml", figure.experiment));
        assert!(experiment.is_file(), "{}: no {}", figure.id, experiment.display());
        let results = root.join("results").join(&figure.experiment);
        assert!(results.join("figures").join(format!("{}.svg", figure.id)).is_file(), "{} is not committed", figure.id);
        assert!(!figure.caption.is_empty());
    }
}

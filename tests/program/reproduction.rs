//! The main job, in quick form, from an empty folder: files, claims, figures, and that a second run changes nothing.

use crate::program::{files, printed, rimbench, root, rows_of};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn reproduce(from: &Path, out: &Path) -> String {
    printed(rimbench().current_dir(from).args(["reproduce", "--quick", "--out"]).arg(out))
}

fn deterministic_files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let of_machine = ["cost.csv", "provenance.csv", "SHA256SUMS"];
    let of_machine = |path: &PathBuf| of_machine.iter().any(|name| path.ends_with(name));
    let kept = |path: &PathBuf| !of_machine(path) && !path.iter().any(|part| part == "records");
    let read = |path: PathBuf| (path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(&path).unwrap());
    files(folder).into_iter().filter(kept).map(read).collect()
}

#[test]
fn the_quick_reproduction_is_complete_and_repeatable() {
    let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let printed = reproduce(root(), first.path());
    let files = deterministic_files(first.path());
    let wanted = "claims.csv claims.md report.html fig1/runs.csv fig2/runs.csv fig2/reference.csv fig2/parameters.csv \
                  fig2/traces/reference.csv fig1/figures/fig1.svg fig2/figures/fig2.svg \
                  phases/figures/phases.svg convergence/figures/convergence.svg";
    for name in wanted.split_whitespace() {
        assert!(files.contains_key(&Path::new("paper").join(name)), "{name} is missing");
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
    let rows = rows_of(first.path().join("paper/claims.csv"));
    assert!(rows.len() >= 20);
    for row in &rows {
        // Orders over three macro steps are not those over six; the full run checks them.
        if row["verdict"] != "not-measured" && row["experiment"] != "convergence" {
            assert_eq!(row["verdict"], row["finding"], "{}", row["id"]);
        }
        assert_eq!(row["verdict"] == "not-measured", row["measured"].is_empty(), "{}", row["id"]);
        assert!(row["measured"].is_empty() || row["runs"] != "0", "claim {} rests on no run", row["id"]);
    }
    let last = printed.lines().last().unwrap();
    assert!(last.contains(" claims reproduce") && last.contains("report.html"), "{last}");
}

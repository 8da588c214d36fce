//! The main job, in quick form, from an empty folder: files, claims, figures, and that a second run changes nothing.

use crate::program::{files, printed, rimbench, root, rows_of, said};
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
    assert!(printed.contains(" claims reproduce. "), "{printed}");
    let last = printed.lines().last().unwrap();
    assert!(last.starts_with("Report: ") && last.ends_with("report.html"), "{last}");
}

#[test]
fn what_is_kept_of_the_paper_is_compared_file_by_file_and_a_difference_is_an_exit_code() {
    let place = tempfile::tempdir().unwrap();
    printed(rimbench().current_dir(root()).args(["reproduce", "--quick", "--out"]).arg(place.path()));
    let again = |code: i32| {
        said(rimbench().current_dir(root()).args(["reproduce", "--quick", "--out"]).arg(place.path()), code)
    };
    // Whatever is kept of it in this repository is looked at, but for the PDF, which another command sets.
    let kept = files(&root().join("results/paper"));
    let kept: Vec<&PathBuf> = kept.iter().filter(|file| is_in_repository(file)).collect();
    let looked_at = kept.len() - usize::from(kept.iter().any(|file| file.ends_with("paper.pdf")));
    let same = again(0);
    // Of every experiment rows are there now, and not of two alone.
    let line = same.lines().find(|line| line.contains("kept files came out to the byte")).unwrap();
    let count: usize = line.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!(line.starts_with(&format!("{count} of ")) && count >= looked_at, "{looked_at}: {line}");
    for (name, from, to) in [
        ("claims.csv", ",reproduced,", ",not-reproduced,"),
        ("claims.md", "reproduced", "seen"),
        ("fig1/runs.csv", "completed", "diverged"),
        ("fig2/summary.csv", "0", "1"),
        ("report.html", "<title>", "<title>Not "),
    ] {
        let path = place.path().join("paper").join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        let edited = text.replacen(from, to, 1);
        assert_ne!(edited, text);
        std::fs::write(&path, edited).unwrap();
    }
    let other = again(1);
    for name in ["claims.csv", "claims.md", "fig1/runs.csv", "fig2/summary.csv", "report.html"] {
        assert!(other.contains(&format!("{name}: comes out otherwise than was kept")), "{name}: {other}");
    }
    assert!(other.contains(&format!("{} of {count} kept files", count - 5)), "{other}");
}

/// Rows are those of one program: what another has stored, or might have, is made again, and so is all of it if that is
/// asked for.
#[test]
fn a_second_reproduction_makes_only_what_this_very_program_has_not_stored() {
    let place = tempfile::tempdir().unwrap();
    let records = place.path().join("paper/fig1/records");
    let tables = |more: &[&str]| {
        let mut command = rimbench();
        let command = command.current_dir(root()).args(["reproduce", "--quick", "--out"]).arg(place.path()).args(more);
        let said = printed(command);
        let last = said.lines().find(|line| line.contains(" claims reproduce. ")).unwrap();
        let last = last.split(" in ").next().unwrap().to_owned();
        let tables: Vec<PathBuf> = files(&records).into_iter().filter(|file| file.extension().is_some()).collect();
        (tables, last)
    };
    let first = tables(&[]);
    assert_eq!(tables(&[]), first, "what is stored is not made again, and counts as before");
    for spoil in [&(|| std::fs::write(records.join("made_by"), "another program").unwrap()) as &dyn Fn(), &|| {
        std::fs::remove_file(records.join("made_by")).unwrap()
    }] {
        let before = tables(&[]);
        spoil();
        let after = tables(&[]);
        assert!(after.0 != before.0 && after.0.len() == 1 && after.1 == before.1, "{after:?}");
    }
    let before = tables(&[]);
    assert_ne!(tables(&["--fresh"]).0, before.0);
    // Rows that were there when this program began are not its own.
    std::fs::remove_file(records.join("made_by")).unwrap();
    printed(
        rimbench()
            .current_dir(root())
            .args(["run", "experiments/paper/fig1.toml", "--out"])
            .arg(records.parent().unwrap()),
    );
    assert!(!records.join("made_by").exists());
}

/// Whether a file is one that the rules of the repository keep.
fn is_in_repository(file: &Path) -> bool {
    let git =
        std::process::Command::new("git").current_dir(root()).args(["ls-files", "--error-unmatch"]).arg(file).output();
    git.is_ok_and(|output| output.status.success())
}

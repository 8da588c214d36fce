//! The main job, in quick form, from an empty folder: files, claims, figures, and that a second run changes nothing.

use crate::program::{cache, copy, files, rimbench, root, rows_of, said};
use crate::screens::SMALL;
use crate::support::catalogue;
use assert_cmd::Command;
use rimbench::cosim::StopFlag;
use rimbench::harness::{Cache, Experiment, Job, Summary, run_job};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The quick reproduction from the project's folder, which is made once for all tests, as a terminal of 100 columns
/// shows it.
pub struct Quick {
    pub folder: PathBuf,
    pub printed: String,
    pub progress: String,
}

pub fn quick() -> &'static Quick {
    static QUICK: OnceLock<Quick> = OnceLock::new();
    QUICK.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("quick");
        std::fs::remove_dir_all(&folder).ok();
        let output = reproduce(&folder).env("COLUMNS", "100").assert().success().get_output().clone();
        let [printed, progress] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        Quick { folder, printed, progress }
    })
}

fn reproduce(out: &Path) -> Command {
    let mut command = rimbench();
    command.current_dir(root()).args(["reproduce", "--quick", "--out"]).arg(out);
    command
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
    let second = tempfile::tempdir().unwrap();
    let Quick { folder: first, printed, .. } = quick();
    let files = deterministic_files(first);
    let wanted = "claims.csv claims.md report.html fig1/runs.csv fig2/runs.csv fig2/reference.csv fig2/parameters.csv \
                  fig2/traces/reference.csv fig1/figures/fig1.svg fig2/figures/fig2.svg \
                  phases/figures/phases.svg convergence/figures/convergence.svg";
    for name in wanted.split_whitespace() {
        assert!(files.contains_key(&Path::new("paper").join(name)), "{name} is missing");
    }
    // Once from the project's folder, once from an empty one, with what the program carries.
    let empty = tempfile::tempdir().unwrap();
    reproduce(second.path()).current_dir(empty.path()).assert().success();
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
    let rows = rows_of(first.join("paper/claims.csv"));
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

/// What this very program has stored is not made again, and a quiet command says nothing of its progress.
#[test]
fn what_is_kept_of_the_paper_is_compared_file_by_file_and_a_difference_is_an_exit_code() {
    let place = tempfile::tempdir().unwrap();
    copy(&quick().folder, place.path());
    // Whatever is kept of it in this repository is looked at, but for the PDF, which another command sets.
    let kept = files(&root().join("results/paper"));
    let kept: Vec<&PathBuf> = kept.iter().filter(|file| is_in_repository(file)).collect();
    let looked_at = kept.len() - usize::from(kept.iter().any(|file| file.ends_with("paper.pdf")));
    let quiet = reproduce(place.path()).arg("--quiet").env("COLUMNS", "100").assert().success().get_output().clone();
    let same = String::from_utf8(quiet.stdout).unwrap();
    assert!(quiet.stderr.is_empty() && quick().progress.contains("runs computed"), "{:?}", quiet.stderr);
    let loud = quick().printed.split(" claims reproduce").next().unwrap();
    let (listed, score) = loud.split_at(loud.rfind('\n').map_or(0, |end| end + 1));
    assert!(same.starts_with(listed) && same.contains(&format!("{score} claims reproduce")), "{same}");
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
    // Rows of another program are made anew, those of this one are not.
    std::fs::write(place.path().join("paper/fig2/records/made_by"), "another program").unwrap();
    let other = said(&mut reproduce(place.path()), 1);
    assert!(other.contains("fig1: 0 runs computed") && !other.contains("fig2: 0 runs computed"), "{other}");
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
    let (experiment, catalogue) = (Experiment::parse(Path::new("small.toml"), SMALL.to_owned()).unwrap(), catalogue());
    let (cache, made_by) = (Cache::in_folder(cache()), place.path().join("records/made_by"));
    let run = |of_this_program: bool, fresh: bool| {
        let job = Job::new(&experiment, catalogue, place.path(), &cache, &rimbench::BUILD);
        let job = Job { of_this_program, fresh, ..job };
        let Summary { computed, reused, .. } = run_job(job, &|_| (), StopFlag::never()).unwrap();
        [computed, reused]
    };
    let all = experiment.size(false).unwrap();
    assert_eq!((run(true, false), run(true, false)), ([all, 0], [0, all]));
    std::fs::write(&made_by, "another program").unwrap();
    assert_eq!((run(true, false), run(true, false)), ([all, 0], [0, all]));
    std::fs::remove_file(&made_by).unwrap();
    assert_eq!((run(true, false), run(true, false), run(true, true)), ([all, 0], [0, all], [all, 0]));
    // Rows that were there when this program began are not its own.
    std::fs::remove_file(&made_by).unwrap();
    assert_eq!(run(false, false), [0, all]);
    assert!(!made_by.exists());
}

/// Whether a file is one that the rules of the repository keep.
fn is_in_repository(file: &Path) -> bool {
    let git =
        std::process::Command::new("git").current_dir(root()).args(["ls-files", "--error-unmatch"]).arg(file).output();
    git.is_ok_and(|output| output.status.success())
}

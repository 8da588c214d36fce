//! Whatever happens to the files of an experiment (a subset, another order, twice, edited), running it again gives what
//! a fresh run gives, and checking its claims gives the verdicts of a fresh run; or either is an error that says why.

use crate::program::{cache, copy, files, lines, often, read, two_sets_with};
use proptest::prelude::*;
use rimbench::catalogue::Catalogue;
use rimbench::checksums;
use rimbench::cosim::StopFlag;
use rimbench::error::Result;
use rimbench::everything;
use rimbench::harness::{Cache, CheckedClaim, Experiment, Job, Shard, check_claims, collect_shards, run_job};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const TEXT: &str = concat!(
    r#"
question = "Does any edit change a result without a word?"
macro_steps_s = [5e-3, 1e-2]
phases = 2
duration_s = 0.04
trace_every_s = 1e-2
traces = ["rim-smooth"]
"#,
    two_sets_with!("rim-smooth"),
    r#"
[[claims]]
id = "one"
by = "ours"
text = "of one set"
set = "box_mass_kg=210.0"
scheme = "zero-order-hold"
metric = "force_error_rms_n"
expect = ">= 0"
finding = "reproduced"

[[claims]]
id = "all"
by = "ours"
text = "of all sets"
set = "all"
scheme = "rim-smooth"
metric = "force_error_rms_n"
statistic = "order"
expect = ">= 0.5"
finding = "not-reproduced"
"#
);

/// What does not depend on the machine.
const SAME_EVERYWHERE: [&str; 4] = ["runs.csv", "parameters.csv", "reference.csv", "experiment.toml"];

/// Runs of the experiment, and rows of its tables.
const RUNS: usize = 16;

static CATALOGUE: LazyLock<Catalogue> = LazyLock::new(|| everything().unwrap());

/// A fresh run, made once.
static FRESH: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    run(&folder.path().join("edit"), None).unwrap();
    folder
});

fn experiment() -> Experiment {
    Experiment::parse(Path::new("edit.toml"), TEXT.to_owned()).unwrap()
}

fn with_job<T>(folder: &Path, shard: Option<Shard>, act: impl FnOnce(Job<'_>) -> T) -> T {
    static CACHE: LazyLock<Cache> = LazyLock::new(|| Cache::in_folder(cache()));
    let experiment = experiment();
    let build = &rimbench::BUILD;
    act(Job { shard, ..Job::new(&experiment, &CATALOGUE, folder, &CACHE, build) })
}

fn run(folder: &Path, shard: Option<Shard>) -> Result<()> {
    with_job(folder, shard, |job| run_job(job, &|_| {}, StopFlag::never()).map(drop))
}

fn verdicts(folder: &Path) -> Result<Vec<(String, Option<f64>)>> {
    let name = |claim: &CheckedClaim| format!("{} {} {}", claim.id, claim.verdict, claim.run_ids.join(" "));
    let checked = check_claims(&experiment(), &CATALOGUE, folder)?;
    Ok(checked.iter().map(|claim| (name(claim), claim.measured)).collect())
}

/// What may happen to a file; numbers choose the file and the place in it.
#[derive(Debug, Clone)]
enum Edit {
    Delete(usize),
    Truncate(usize, usize),
    Flip(usize, usize, u8),
    DeleteLine(usize, usize),
    RepeatLine(usize, usize),
    SwapLines(usize, usize, usize),
    Empty(usize),
    /// One file becomes another.
    Become(usize, usize),
    /// All records are gone, as in a clone.
    ForgetRecords,
    /// The records once more, under a name that sorts first.
    RepeatRecords,
}

fn edit() -> impl Strategy<Value = Edit> {
    let n = 0..1000_usize;
    let at = 0..100_000_usize;
    prop_oneof![
        n.clone().prop_map(Edit::Delete),
        (n.clone(), at.clone()).prop_map(|(file, at)| Edit::Truncate(file, at)),
        (n.clone(), at.clone(), 1..255_u8).prop_map(|(file, at, mask)| Edit::Flip(file, at, mask)),
        (n.clone(), at.clone()).prop_map(|(file, line)| Edit::DeleteLine(file, line)),
        (n.clone(), at.clone()).prop_map(|(file, line)| Edit::RepeatLine(file, line)),
        (n.clone(), at.clone(), at).prop_map(|(file, a, b)| Edit::SwapLines(file, a, b)),
        n.clone().prop_map(Edit::Empty),
        (n.clone(), n).prop_map(|(from, to)| Edit::Become(from, to)),
        Just(Edit::ForgetRecords),
        Just(Edit::RepeatRecords),
    ]
}

fn apply(folder: &Path, edit: &Edit) {
    let there = files(folder);
    if there.is_empty() {
        return;
    }
    let file = |index: usize| there[index % there.len()].clone();
    let change = |index: usize, how: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = std::fs::read(file(index)).unwrap();
        if !bytes.is_empty() {
            how(&mut bytes);
            std::fs::write(file(index), bytes).unwrap();
        }
    };
    let change_lines = |index: usize, how: &dyn Fn(&mut Vec<Vec<u8>>)| {
        change(index, &|bytes| {
            let mut split = lines(bytes);
            how(&mut split);
            *bytes = split.concat();
        });
    };
    match *edit {
        Edit::Delete(index) => std::fs::remove_file(file(index)).unwrap(),
        Edit::Truncate(index, at) => change(index, &|bytes| bytes.truncate(at % bytes.len())),
        Edit::Flip(index, at, mask) => change(index, &|bytes| {
            let at = at % bytes.len();
            bytes[at] ^= mask;
        }),
        Edit::DeleteLine(index, line) => change_lines(index, &|lines| drop(lines.remove(line % lines.len()))),
        Edit::RepeatLine(index, line) => change_lines(index, &|lines| lines.push(lines[line % lines.len()].clone())),
        Edit::SwapLines(index, a, b) => change_lines(index, &|lines| {
            let count = lines.len();
            lines.swap(a % count, b % count);
        }),
        Edit::Empty(index) => std::fs::write(file(index), "").unwrap(),
        Edit::Become(from, to) => std::fs::write(file(to), std::fs::read(file(from)).unwrap()).unwrap(),
        Edit::ForgetRecords => drop(std::fs::remove_dir_all(folder.join("records"))),
        Edit::RepeatRecords => {
            let logs = files(&folder.join("records")).into_iter().filter(|path| path.extension().is_some());
            for (index, log) in logs.enumerate() {
                std::fs::copy(&log, folder.join(format!("records/0{index}.csv"))).unwrap();
            }
        }
    }
}

/// Everything that must be as after a fresh run.
fn assert_as_fresh(folder: &Path) {
    let fresh = FRESH.path().join("edit");
    for name in SAME_EVERYWHERE {
        let [one, other] = [&fresh, folder].map(|folder| read(folder.join(name)));
        assert_eq!(one, other, "{name}");
    }
    for trace in files(&fresh.join("traces")) {
        let other = folder.join("traces").join(trace.file_name().unwrap());
        assert!(std::fs::read(&trace).unwrap() == std::fs::read(other).unwrap(), "{}", trace.display());
    }
    assert_eq!(verdicts(folder).unwrap(), verdicts(&fresh).unwrap());
}

proptest! {
    #![proptest_config(often(24, 96))]

    #[test]
    fn any_edits_of_any_files_change_nothing_or_are_said(edits in prop::collection::vec(edit(), 1..5)) {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("edit");
        copy(&FRESH.path().join("edit"), &folder);
        for edit in &edits {
            apply(&folder, edit);
        }
        match verdicts(&folder) {
            Ok(verdicts) => prop_assert_eq!(verdicts, self::verdicts(&FRESH.path().join("edit")).unwrap()),
            Err(error) => prop_assert!(error.to_string().contains(folder.to_str().unwrap()), "{}", error),
        }
        match run(&folder, None) {
            Ok(()) => assert_as_fresh(&folder),
            Err(error) => prop_assert!(error.to_string().contains(folder.to_str().unwrap()), "{}", error),
        }
    }

    /// Whoever edits rows may write new checksums as well: the plan still knows how many runs there are.
    #[test]
    fn any_choice_of_rows_is_all_of_them_or_an_error(rows in prop::collection::vec(1..=RUNS, 0..24), all in any::<bool>()) {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("edit");
        copy(&FRESH.path().join("edit"), &folder);
        let sums = checksums::read(&folder).unwrap().unwrap();
        let mut chosen = rows;
        if all {
            let missing: Vec<usize> = (1..=RUNS).filter(|row| !chosen.contains(row)).collect();
            chosen.sort_unstable();
            chosen.dedup();
            chosen.extend(missing);
        }
        for name in ["runs.csv", "cost.csv", "provenance.csv"] {
            let split = lines(&std::fs::read(folder.join(name)).unwrap());
            let kept: Vec<u8> = std::iter::once(0).chain(chosen.iter().copied()).flat_map(|row| split[row].clone()).collect();
            std::fs::write(folder.join(name), kept).unwrap();
        }
        checksums::write(&folder, sums.into_keys()).unwrap();
        let mut once = chosen.clone();
        once.sort_unstable();
        once.dedup();
        let complete = once.len() == RUNS && chosen.len() == RUNS;
        match verdicts(&folder) {
            Ok(found) => {
                prop_assert!(complete);
                let measured = |found: Vec<(String, Option<f64>)>| found.into_iter().map(|(_, value)| value).collect::<Vec<_>>();
                prop_assert_eq!(measured(found), measured(verdicts(&FRESH.path().join("edit")).unwrap()));
            }
            Err(error) => {
                prop_assert!(!complete);
                let counts = format!("{RUNS} planned, {} found", once.len());
                prop_assert!(error.to_string().contains(&counts), "{}", error);
            }
        }
        // Without records, what is there is taken over and the rest computed.
        std::fs::remove_dir_all(folder.join("records")).unwrap();
        run(&folder, None).unwrap();
        assert_as_fresh(&folder);
    }

    #[test]
    fn shards_collected_in_any_order_and_more_than_once_are_the_whole(
        parts in 1..5_usize,
        order in prop::collection::vec(0..5_usize, 0..8),
        lost in any::<bool>(),
    ) {
        let place = tempfile::tempdir().unwrap();
        let folders: Vec<PathBuf> = (0..parts).map(|part| place.path().join(format!("part-{part}"))).collect();
        for (part, folder) in folders.iter().enumerate() {
            run(folder, Some(Shard::Every { part: part + 1, of: parts })).unwrap();
        }
        // In any order, some more than once; with `lost` some perhaps not at all.
        let mut list: Vec<usize> = order.iter().map(|part| part % parts).collect();
        if !lost {
            list.extend(0..parts);
        }
        let first = list.first().copied().unwrap_or(0);
        let others: Vec<&Path> = list.iter().map(|&part| folders[part].as_path()).collect();
        let (summary, told) = with_job(&folders[first], None, |job| collect_shards(job, &others)).unwrap();
        let mut there = list.clone();
        there.push(first);
        there.sort_unstable();
        there.dedup();
        let stored = (0..RUNS).filter(|index| there.contains(&(index % parts))).count();
        prop_assert_eq!((summary.planned - summary.missing, summary.missing, told.len()), (stored, RUNS - stored, RUNS - stored));
        if stored == RUNS {
            assert_as_fresh(&folders[first]);
        } else {
            prop_assert!(verdicts(&folders[first]).is_err());
        }
    }
}

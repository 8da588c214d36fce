//! The store of runs and the cache of references.

use rimbench::checksums::sha256;
use rimbench::harness::{Asked, Cache, RunRow, Store, TraceMark};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

fn stored(id: &str) -> RunRow {
    let mut row = RunRow::blank(id);
    row.trace = Some(TraceMark { every_s: 1e-3, sha256: "ab".to_owned() });
    (row.found.metrics[0], row.found.reason) = (Some(1.5), "too long, \"too\" far".to_owned());
    row
}

fn open(folder: &Path) -> Store {
    Store::open(folder, Path::new("group/test.toml"), "").unwrap()
}

/// The tables of a store, in the order in which they were begun.
fn tables(folder: &Path) -> Vec<PathBuf> {
    let mut tables: Vec<PathBuf> =
        fs::read_dir(folder.join("records")).unwrap().map(|entry| entry.unwrap().path()).collect();
    tables.sort();
    tables
}

/// The first half of the digits of the SHA-256 behind a line.
fn sealed(line: &str) -> String {
    format!("{line},{}\n", &sha256(line)[..16])
}

#[test]
fn a_run_that_took_too_long_counts_only_for_those_who_give_it_no_more_time() {
    let folder = tempfile::tempdir().unwrap();
    let store = open(folder.path());
    store.append(RunRow { trace: None, wall_limit_s: Some(2.0), ..stored("aa") }).unwrap();
    store.append(stored("bb")).unwrap();
    let store = open(folder.path());
    let holds = |id: &str, limit: Option<u64>| {
        store.get(id).is_some_and(|row| row.answers(Asked::default(), limit.map(Duration::from_secs)))
    };
    assert_eq!([Some(1), Some(2), Some(3), None].map(|limit| holds("aa", limit)), [true, true, false, false]);
    assert_eq!([Some(1), None].map(|limit| holds("bb", limit)), [true, true]);
    assert!(!holds("cc", Some(1)));
    assert_eq!(store.get("bb"), Some(&stored("bb")));
    assert_eq!(Store::experiment_in(folder.path()).as_deref(), Some("test"));
    assert_eq!(Store::experiment_in(&folder.path().join("records")), None);
}

#[test]
fn a_row_that_is_damaged_and_all_below_a_damaged_head_are_named() {
    let folder = tempfile::tempdir().unwrap();
    ["aa", "bb"].into_iter().try_for_each(|id| open(folder.path()).append(stored(id))).unwrap();
    let [path, other] = <[_; 2]>::try_from(tables(folder.path())).unwrap();
    let whole = fs::read_to_string(&path).unwrap();
    let row = fs::read_to_string(other).unwrap().lines().nth(2).unwrap().to_owned();
    let whole = format!("{whole}{}\n{row}\n", row.replace("bb,", "cc,"));
    for (from, to, damaged) in [
        ("", "", vec![4]),
        ("1.5", "1.6", vec![3, 4, 5]),
        (",reason,", ",raeson,", vec![3, 4, 5]),
        ("run_id,", "run-id,", vec![3, 4, 5]),
        ("test.toml\n", "test.tomk\n", vec![3, 4, 5]),
    ] {
        fs::write(&path, whole.replace(from, to)).unwrap();
        let store = open(folder.path());
        assert_eq!(store.damaged.iter().map(|place| place.line).collect::<Vec<_>>(), damaged, "{from} {to}");
        assert!(store.damaged[0].to_string().ends_with(&format!(".csv, line {}", damaged[0])));
    }
}

#[test]
fn a_table_written_with_other_columns_is_read_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    open(folder.path()).append(stored("aa")).unwrap();
    let path = tables(folder.path()).remove(0);
    let whole = fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = whole.lines().collect();
    let [mut names, mut cells] = [lines[1], lines[2]].map(|line| {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
        reader.records().next().unwrap().unwrap().iter().map(str::to_owned).collect::<Vec<_>>()
    });
    [&mut names, &mut cells].into_iter().for_each(|line| drop(line.pop()));
    // A metric less, a column more, in another order.
    let metric = names.iter().position(|name| name == "force_error_rms_n").unwrap();
    [&mut names, &mut cells].into_iter().for_each(|line| drop(line.remove(metric)));
    names.push("gone".into());
    cells.push("1".into());
    [&mut names, &mut cells].into_iter().for_each(|line| line.reverse());
    let [_, _, _, _, own] = <[&str; 5]>::try_from(lines[0].splitn(5, ' ').collect::<Vec<_>>()).unwrap();
    let names = names.join(",");
    let head = format!("# rimbench-store 5 {} {own}\n{names},checksum\n", &sha256(format!("{own}\n{names}"))[..16]);
    let mut row = csv::Writer::from_writer(Vec::new());
    row.write_record(&cells).unwrap();
    let row = String::from_utf8(row.into_inner().unwrap()).unwrap();
    fs::write(&path, head + &sealed(row.trim_end())).unwrap();
    let mut wanted = stored("aa");
    wanted.found.metrics[0] = None;
    assert_eq!((open(folder.path()).get("aa"), open(folder.path()).damaged), (Some(&wanted), vec![]));
}

#[test]
fn a_store_of_something_else_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    open(folder.path()).append(stored("aa")).unwrap();
    let message =
        |file: &str, reference| Store::open(folder.path(), Path::new(file), reference).unwrap_err().to_string();
    assert!(message("other.toml", "").contains("belongs to experiment `test`"));
    assert!(message("test.toml", "other").contains("another reference"));
    let path = tables(folder.path()).remove(0);
    for (text, wanted) in [
        (
            "rimbench-store 4 test abc a,b c d 0123\n",
            "store layout 4, this is layout 5; use another folder, or `rimbench run test.toml --fresh`",
        ),
        ("something else\nand more\n", "no table of runs"),
    ] {
        fs::write(&path, text).unwrap();
        assert!(message("test.toml", "").contains(wanted), "{}", message("test.toml", ""));
    }
    Store::clear(folder.path()).unwrap();
    assert!(open(folder.path()).run_ids().is_empty());
}

/// Where a cache keeps what belongs to a key.
fn cached(folder: &Path, key: &str) -> PathBuf {
    folder.join(format!("{}.bin", sha256(key)))
}

fn bits(numbers: impl AsRef<[f64]>) -> Vec<u64> {
    numbers.as_ref().iter().map(|x| x.to_bits()).collect()
}

#[test]
fn numbers_come_back_to_the_bit_and_damage_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path().join("not-yet-there"));
    let numbers = [1.0, -0.0, f64::INFINITY, f64::MIN_POSITIVE, 0.1 + 0.2];
    assert_eq!(cache.read("key"), None);
    cache.write("key", &numbers);
    assert_eq!(bits(cache.read("key").unwrap()), bits(numbers));
    assert_eq!(cache.read("another key"), None);
    assert!(cache.fault().is_none());
    let path = cached(&folder.path().join("not-yet-there"), "key");
    let mut bytes = fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&path, bytes).unwrap();
    assert_eq!(cache.read("key"), None);
    assert!(cache.fault().unwrap().to_string().contains("damaged"));
}

/// Cut off anywhere, any bit turned over, words exchanged, a longer end, zeros instead of a block: none of it is read.
#[test]
fn whatever_happens_to_a_file_of_the_cache_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let numbers: Vec<f64> = (0..21).map(|k| if k % 5 == 0 { 0.0 } else { f64::from(k) * 0.1 }).collect();
    let path = cached(folder.path(), "key");
    Cache::in_folder(folder.path()).write("key", &numbers);
    let whole = fs::read(&path).unwrap();
    let head = whole.len() - 8 * numbers.len();
    let read = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        Cache::in_folder(folder.path()).read("key")
    };
    assert_eq!(read(&whole), Some(numbers.clone()));
    for length in 0..whole.len() {
        assert_eq!(read(&whole[..length]), None, "cut off at {length}");
    }
    for bit in 0..8 * whole.len() {
        let mut damaged = whole.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(read(&damaged), None, "bit {bit}");
    }
    for (one, other) in (1..numbers.len()).flat_map(|other| (0..other).map(move |one| (one, other))) {
        let mut damaged = whole.clone();
        for byte in 0..8 {
            damaged.swap(head + 8 * one + byte, head + 8 * other + byte);
        }
        assert!(damaged == whole || read(&damaged).is_none(), "words {one} and {other} exchanged");
    }
    for end in [&[0; 8][..], &[0; 32], &[1; 8], &[0]] {
        assert_eq!(read(&[&whole[..], end].concat()), None, "{} bytes more", end.len());
    }
    for from in (head..whole.len() - 32).step_by(8) {
        let mut damaged = whole.clone();
        damaged[from..from + 32].fill(0);
        assert_eq!(read(&damaged), None, "zeros from {from}");
    }
}

/// A file of an older layout is no damage: nobody is told, and it is replaced.
#[test]
fn a_file_of_an_older_layout_is_replaced_without_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    let path = cached(folder.path(), "key");
    fs::write(&path, [&b"rimref02"[..], &[7; 48]].concat()).unwrap();
    assert_eq!(cache.read("key"), None);
    assert!(cache.fault().is_none());
    cache.write("key", &[1.0]);
    assert_eq!(cache.read("key"), Some(vec![1.0]));
    // What only begins alike is damaged.
    for mark in ["rimref99", "rimrefxy", "rimr"] {
        fs::write(&path, [mark.as_bytes(), &[7; 48]].concat()).unwrap();
        let cache = Cache::in_folder(folder.path());
        assert_eq!(cache.read("key"), None);
        assert!(cache.fault().unwrap().to_string().contains("damaged"), "{mark}");
    }
}

#[test]
fn a_file_that_was_given_the_name_of_another_key_is_not_believed() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    cache.write("one case", &[1.0]);
    fs::copy(cached(folder.path(), "one case"), cached(folder.path(), "another case")).unwrap();
    assert_eq!(cache.read("another case"), None);
    assert_eq!(cache.read("one case"), Some(vec![1.0]));
}

#[cfg(unix)]
#[test]
fn a_pipe_in_the_place_of_a_file_is_neither_waited_for_nor_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    let path = cached(folder.path(), "key");
    assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
    assert_eq!(cache.read("key"), None);
    cache.write("key", &[1.0]);
    assert!(fs::metadata(&path).unwrap().file_type().is_fifo());
    assert!(cache.fault().unwrap().to_string().contains("no regular file"));
}

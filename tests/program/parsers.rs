//! Whatever a file says, reading it ends in what it means or in one error that says something; never in a panic, and
//! never in memory that the file's size cannot explain.
//!
//! Texts that are valid are mangled: bytes flipped, pieces cut out, repeated, moved, replaced by what numbers and names
//! stumble over, or by a piece of another kind of file. `PROPTEST_CASES` says how often (256 times each if not set).

use crate::exported_fmus::{CARRIAGE, case_file, repacked, without_library};
use crate::program::{lines, rimbench, root};
use proptest::prelude::*;
use rimbench::catalogue::Catalogue;
use rimbench::checksums;
use rimbench::error::Error;
use rimbench::everything;
use rimbench::figures::{FigureList, TableList};
use rimbench::fmi::import::{Programs, read_case};
use rimbench::harness::{Experiment, Ranking, Store};
use rimbench::perf::History;
use rimbench::results_table::read_table;
use rimbench::run_table::RunTable;
use rimbench::runs::RunRequest;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

static CATALOGUE: LazyLock<Catalogue> = LazyLock::new(|| everything().unwrap());

/// What readers of numbers, names, tables and texts stumble over.
#[rustfmt::skip]
const TOKENS: [&str; 34] = [
    "nan", "-inf", "inf", "1e999", "-0.0", "5e-324", "-1", "0", "18446744073709551616", "0x7f", "1_0", "٣", "é", "\u{feff}", "\0",
    "\r\n", "\n\n", "\t", "\"", "\"\"\"", "'", "\\", "[[", "]]", "{", "}", "= ", ",", ",,,", "#", "../", "true", "[1e-9, 1e9]",
    "{ from = 1e-9, to = 1.0, per_decade = 99999999 }",
];

/// One change; numbers choose the place.
#[derive(Debug, Clone)]
enum Change {
    Flip(usize, u8),
    Cut(usize, usize),
    Repeat(usize, usize),
    Move(usize, usize, usize),
    Insert(usize, usize),
    /// A word (letters, digits, signs) becomes a token.
    Replace(usize, usize),
    /// A piece of another file.
    Splice(usize, usize, usize),
    DropLine(usize),
    RepeatLine(usize),
}

fn change() -> impl Strategy<Value = Change> {
    let at = || any::<u32>().prop_map(|at| at as usize);
    let short = || 1..40_usize;
    prop_oneof![
        (at(), 1..=255_u8).prop_map(|(at, mask)| Change::Flip(at, mask)),
        (at(), short()).prop_map(|(at, length)| Change::Cut(at, length)),
        (at(), short()).prop_map(|(at, length)| Change::Repeat(at, length)),
        (at(), at(), short()).prop_map(|(from, to, length)| Change::Move(from, to, length)),
        (at(), 0..TOKENS.len()).prop_map(|(at, token)| Change::Insert(at, token)),
        (at(), 0..TOKENS.len()).prop_map(|(at, token)| Change::Replace(at, token)),
        (at(), at(), short()).prop_map(|(at, from, length)| Change::Splice(at, from, length)),
        at().prop_map(Change::DropLine),
        at().prop_map(Change::RepeatLine),
    ]
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    prop::collection::vec(change(), 1..6)
}

fn mangled(seed: &[u8], changes: &[Change]) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for change in changes {
        let count = bytes.len();
        if count == 0 {
            break;
        }
        let end = |at: usize, length: usize| (at % count + length).min(count);
        match *change {
            Change::Flip(at, mask) => bytes[at % count] ^= mask,
            Change::Cut(at, length) => drop(bytes.drain(at % count..end(at, length))),
            Change::Repeat(at, length) => {
                let piece = bytes[at % count..end(at, length)].to_vec();
                let to = end(at, length);
                drop(bytes.splice(to..to, piece));
            }
            Change::Move(from, to, length) => {
                let piece: Vec<u8> = bytes.drain(from % count..end(from, length)).collect();
                let to = to % (bytes.len() + 1);
                drop(bytes.splice(to..to, piece));
            }
            Change::Insert(at, token) => drop(bytes.splice(at % count..at % count, TOKENS[token].bytes())),
            Change::Replace(at, token) => {
                let of_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-._".contains(byte);
                let from = at % count - bytes[..at % count].iter().rev().take_while(|byte| of_word(byte)).count();
                let to = from + bytes[from..].iter().take_while(|byte| of_word(byte)).count();
                drop(bytes.splice(from..to, TOKENS[token].bytes()));
            }
            Change::Splice(at, from, length) => {
                let other = &SEEDS[from % SEEDS.len()].1;
                let first = from % other.len().max(1);
                let piece = other[first..(first + length).min(other.len())].to_vec();
                drop(bytes.splice(at % count..at % count, piece));
            }
            Change::DropLine(line) => {
                let mut all = lines(&bytes);
                all.remove(line % all.len());
                bytes = all.concat();
            }
            Change::RepeatLine(line) => {
                let mut all = lines(&bytes);
                all.push(all[line % all.len()].clone());
                bytes = all.concat();
            }
        }
    }
    bytes
}

/// The first bytes of a file of this project, whole lines.
fn beginning(path: &str, bytes: usize) -> Vec<u8> {
    let all = std::fs::read(root().join(path)).unwrap();
    let end = all[..bytes.min(all.len())].iter().rposition(|byte| *byte == b'\n');
    all[..end.map_or(all.len(), |at| at + 1)].to_vec()
}

/// The part of a list of figures before the last that begins in it.
fn whole_figures(mut list: Vec<u8>) -> Vec<u8> {
    const HEAD: &[u8] = b"\n[[figure]]\n";
    let last = list.windows(HEAD.len()).rposition(|part| part == HEAD).expect("several figures");
    list.truncate(last + 1);
    list
}

/// A valid text of every kind.
static SEEDS: LazyLock<Vec<(&str, Vec<u8>)>> = LazyLock::new(|| {
    let all = 1 << 20;
    vec![
        ("experiment", beginning("experiments/paper/phases.toml", all)),
        ("experiment", beginning("experiments/study/friction.toml", all)),
        ("experiment", beginning("experiments/study/model_steps.toml", all)),
        ("figures", whole_figures(beginning("paper/figures.toml", 6000))),
        ("tables", beginning("paper/tables.toml", all)),
        ("history", beginning("results/perf/history.csv", 6000)),
        ("table", beginning("results/paper/fig1/runs.csv", 9000)),
        ("table", beginning("results/paper/claims.csv", 4000)),
        ("checksums", CHECKSUMS.as_bytes().to_vec()),
        ("store", STORE.as_bytes().to_vec()),
        ("ranking", beginning("experiments/ranking.toml", all)),
    ]
});

const CHECKSUMS: &str = "3f5e0a1f2c9d4b6a8e7d0c1b2a394857663f5e0a1f2c9d4b6a8e7d0c1b2a3948  runs.csv\n\
                         0c1b2a394857663f5e0a1f2c9d4b6a8e7d3f5e0a1f2c9d4b6a8e7d0c1b2a3948  traces/0123456789abcdef.csv\n";

const STORE: &str = "# rimbench-store 5 15e9dd29e4ee2c6f e3b0c44298fc e.toml\nrun_id,outcome,ended_at_s,checksum\n\
                     0123456789abcdef,completed,0.5,wrong\n";

fn seeds(kind: &str) -> Vec<&'static [u8]> {
    SEEDS.iter().filter(|seed| seed.0 == kind).map(|seed| seed.1.as_slice()).collect()
}

/// An error, if it is one, says something, on a few lines.
fn says<T>(read: Result<T, Error>) -> Option<T> {
    let error = match read {
        Ok(read) => return Some(read),
        Err(error) => error,
    };
    let said = error.to_string();
    assert!(said.len() > 8 && said.len() < 40_000, "says {} bytes: {}", said.len(), &said[..said.len().min(400)]);
    None
}

fn file_with(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

#[test]
fn what_is_mangled_was_valid() {
    for text in seeds("experiment") {
        let text = String::from_utf8(text.to_vec()).unwrap();
        Experiment::parse(Path::new("e.toml"), text).unwrap().plan(&CATALOGUE, false).unwrap();
    }
    for text in seeds("figures") {
        FigureList::parse(Path::new("f.toml"), std::str::from_utf8(text).unwrap()).unwrap();
    }
    for text in seeds("tables") {
        TableList::parse(Path::new("t.toml"), std::str::from_utf8(text).unwrap()).unwrap();
    }
    for text in seeds("ranking") {
        Ranking::parse(Path::new("r.toml"), std::str::from_utf8(text).unwrap()).unwrap();
    }
    let (_folder, path) = file_with("history.csv", seeds("history")[0]);
    assert!(!History::read(&path).unwrap().rows.is_empty());
    let (_folder, path) = file_with("runs.csv", seeds("table")[0]);
    assert!(!read_table(&path).unwrap().is_empty() && !RunTable::read(&path).unwrap().is_empty());
    let (folder, _) = file_with("SHA256SUMS", seeds("checksums")[0]);
    assert!(checksums::read(folder.path()).unwrap().is_some_and(|sums| sums.len() == 2));
}

/// Two FMUs without a library, and a case file for them: everything is read of them, and nothing of theirs is run.
static FMUS: LazyLock<(tempfile::TempDir, String)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    for side in ["mechanics", "actuator"] {
        let whole = folder.path().join(format!("whole-{side}.fmu"));
        rimbench().args(["fmu", "--case", "bouncing-ball", "--side", side, "--out"]).arg(&whole).assert().success();
        repacked(&whole, &folder.path().join(format!("{side}.fmu")), without_library);
    }
    let head = "duration_s = 0.1\nmacro_step_s = 1e-3\nmicro_step_s = 1e-4\nanswer_within_s = 2.0\n";
    let text = case_file(CARRIAGE, head);
    let more = "start = { serialisable = true }\nobserve = [\"longest_step_s\"]\ninterface_work = \"interface_work_j\"\nprobe_step_s = 1e-5\n";
    let text = text.replacen("fmu = \"mechanics.fmu\"\n", &format!("fmu = \"mechanics.fmu\"\n{more}"), 1);
    let text =
        format!("{text}[parameters.step]\ndefault = 0.0\nunit = \"s\"\nabout = \"a step\"\nmechanics = \"rim.step\"\n");
    (folder, text)
});

/// What reading a case file ends in.
fn case_of(text: &[u8]) -> Result<String, Error> {
    let path = FMUS.0.path().join("case.toml");
    std::fs::write(&path, text).unwrap();
    read_case(&path, Programs::default()).map(|case| case.name.to_string())
}

#[test]
fn the_case_file_that_is_mangled_fails_only_where_the_library_is_none() {
    let said = case_of(FMUS.1.as_bytes()).unwrap_err().to_string();
    assert!(said.contains("its library cannot be loaded"), "{said}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_experiment_is_a_plan_or_an_error(which in 0..3_usize, changes in changes()) {
        let text = mangled(seeds("experiment")[which], &changes);
        let Ok(text) = String::from_utf8(text) else { return Ok(()) };
        let Some(experiment) = says(Experiment::parse(Path::new("e.toml"), text)) else { return Ok(()) };
        for quick in [false, true] {
            for run in says(experiment.plan(&CATALOGUE, quick)).iter().flatten().step_by(97) {
                prop_assert_eq!(run.id.len(), 16);
            }
        }
    }

    #[test]
    fn any_list_of_figures_is_one_or_an_error(changes in changes()) {
        let text = mangled(seeds("figures")[0], &changes);
        let Ok(text) = std::str::from_utf8(&text) else { return Ok(()) };
        says(FigureList::parse(Path::new("f.toml"), text));
    }

    #[test]
    fn any_list_of_tables_is_one_or_an_error(changes in changes()) {
        let text = mangled(seeds("tables")[0], &changes);
        let Ok(text) = std::str::from_utf8(&text) else { return Ok(()) };
        says(TableList::parse(Path::new("t.toml"), text));
    }

    #[test]
    fn any_ranking_is_one_or_an_error(changes in changes()) {
        let text = mangled(seeds("ranking")[0], &changes);
        let Ok(text) = std::str::from_utf8(&text) else { return Ok(()) };
        says(Ranking::parse(Path::new("r.toml"), text));
    }

    #[test]
    fn any_case_file_is_an_error_that_says_something(changes in changes()) {
        // What a file names is started, and no word that came about by chance may be.
        let text = mangled(FMUS.1.as_bytes(), &changes);
        if !text.windows(7).any(|word| word == b"command") {
            let read = says(case_of(&text));
            prop_assert!(read.is_none(), "{read:?} was read without a library");
        }
    }

    #[test]
    fn any_table_history_and_list_of_checksums_is_one_or_an_error(changes in changes(), which in 0..2_usize) {
        let (_table, path) = file_with("runs.csv", &mangled(seeds("table")[which], &changes));
        says(RunTable::read(&path));
        if let Some(table) = says(read_table(&path)) {
            for name in ["run_id", "outcome", "nothing"] {
                let _ = table.column(name).map(|column| (0..table.len()).map(|row| table.number(row, column)).sum::<f64>());
            }
        }
        let (_history, path) = file_with("history.csv", &mangled(seeds("history")[0], &changes));
        says(History::read(&path));
        let (folder, _) = file_with("SHA256SUMS", &mangled(seeds("checksums")[0], &changes));
        // No name leads out of the folder.
        for name in says(checksums::read(folder.path())).flatten().unwrap_or_default().keys() {
            prop_assert!(!name.starts_with('/') && !name.split('/').any(|part| part == ".."), "{name}");
        }
        says(checksums::verify(folder.path()));
    }

    #[test]
    fn any_table_of_a_store_is_rows_or_an_error(changes in changes()) {
        let (folder, _) = file_with("records/1-1.csv", &mangled(STORE.as_bytes(), &changes));
        // A row without its checksum is as good as never written.
        let store = says(Store::open(folder.path(), "e.toml".as_ref(), ""));
        prop_assert!(store.is_none_or(|store| store.get("0123456789abcdef").is_none()));
    }

    #[test]
    fn any_text_of_an_option_or_a_parameter_is_a_value_or_an_error(changes in changes(), which in any::<u32>()) {
        let which = which as usize;
        let texts = ["rim-nonsmooth", "gauss-seidel", "margin:1e-3", "0.5", "delay:2", "all", "1e-3", "3"];
        let Ok(text) = String::from_utf8(mangled(texts[which % texts.len()].as_bytes(), &changes)) else { return Ok(()) };
        for option in RunRequest::OPTIONS {
            let mut request = RunRequest::of("wedge-box", "rim-nonsmooth-gap");
            request.duration_s = Some(0.01);
            says(request.put(option.key, &text).and_then(|()| request.resolve(&CATALOGUE).map(drop)));
        }
        let case = &CATALOGUE.cases()[which % CATALOGUE.cases().len()];
        for parameter in &case.parameters {
            says(case.default_parameters().set(&parameter.name, &text));
        }
    }
}

//! Each room opens only doors below it: checks the direction of every `crate::…` outside comments.

use std::fs;
use std::path::{Path, PathBuf};

/// Each room and the rooms it may use, from the ground up.
const ROOMS: [(&str, &[&str]); 16] = [
    ("error", &[]),
    ("atomic_file", &["error"]),
    ("numerics_version", &[]),
    ("results_table", &["error"]),
    ("complementarity", &["error"]),
    ("interface_model", &["complementarity", "error"]),
    ("cosim", &["interface_model", "complementarity", "error"]),
    ("mechanics", &["cosim", "interface_model", "complementarity", "error"]),
    ("models", &["mechanics", "cosim", "interface_model", "complementarity", "error"]),
    ("schemes", &["cosim", "interface_model", "complementarity", "error"]),
    ("cases", &["models", "mechanics", "cosim", "interface_model", "complementarity", "error"]),
    ("metrics", &["cosim", "error"]),
    (
        "harness",
        &[
            "cases",
            "schemes",
            "metrics",
            "models",
            "mechanics",
            "cosim",
            "interface_model",
            "complementarity",
            "atomic_file",
            "results_table",
            "numerics_version",
            "error",
        ],
    ),
    // Reads results, never simulates; of the metrics it takes the order of convergence.
    ("report", &["metrics", "results_table", "atomic_file", "error"]),
    ("corpus", &["report", "harness", "cases", "schemes", "cosim", "complementarity", "atomic_file", "error"]),
    // The program under measurement is everything else.
    (
        "perf",
        &[
            "report",
            "harness",
            "cases",
            "schemes",
            "models",
            "mechanics",
            "cosim",
            "interface_model",
            "complementarity",
            "atomic_file",
            "error",
        ],
    ),
];

/// Names that follow `crate::` in the code of one line; what stands behind `//` is prose.
fn doors(line: &str) -> Vec<String> {
    let code = line.split("//").next().unwrap_or_default();
    let name = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    code.split("crate::").skip(1).map(name).collect()
}

/// What is wrong with one line of a room, if anything.
fn fault(room: &str, line: &str) -> Option<String> {
    let allowed = ROOMS.iter().find(|(name, _)| *name == room).map(|(_, allowed)| *allowed);
    let Some(allowed) = allowed else { return Some(format!("room `{room}` is not in the list: say what it may use")) };
    doors(line).into_iter().find(|door| door != room && !allowed.contains(&door.as_str())).map(|door| {
        match door.as_str() {
            "" => "`crate::{…}` hides which rooms it opens: write one `use` per room".to_owned(),
            _ => format!("room `{room}` may use {allowed:?}, not `{door}`"),
        }
    })
}

fn sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

#[test]
fn no_room_may_open_a_door_above_it() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    let (mut faults, mut seen) = (Vec::new(), 0);
    for file in &files {
        let path = file.strip_prefix(&src).unwrap();
        let room = path.components().next().unwrap().as_os_str().to_str().unwrap().trim_end_matches(".rs");
        // The roof: the list of rooms, and the commands, which use the library from outside.
        if ["lib", "main", "cli"].contains(&room) {
            continue;
        }
        for (number, line) in fs::read_to_string(file).unwrap().lines().enumerate() {
            seen += doors(line).len();
            faults.extend(fault(room, line).map(|fault| format!("src/{}:{}: {fault}", path.display(), number + 1)));
        }
    }
    assert!(seen > 50, "only {seen} uses of `crate::` found in {} files: the check reads nothing", files.len());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_check_must_see_a_door_that_leads_upwards() {
    assert!(fault("mechanics", "use crate::schemes::SCHEMES;").unwrap().contains("not `schemes`"));
    assert!(fault("report", "    crate::harness::simulate(&spec)").is_some());
    assert!(fault("cosim", "use crate::{error::Error, cases::Case};").unwrap().contains("one `use` per room"));
    assert!(fault("attic", "use crate::error::Error;").unwrap().contains("not in the list"));
    assert_eq!(fault("mechanics", "use crate::cosim::Ports; // not crate::cases"), None);
    assert_eq!(fault("cosim", "/// See [`Error`](crate::harness::simulate)."), None);
}

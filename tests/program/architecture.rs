//! Each room of the core opens only doors below it; between packages the compiler sees to that.

use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the core that others stand on, from the ground up; mechanics and schemes stand on all of them and not on each
/// other.
const FLOORS: [&str; 4] = ["linear_algebra", "complementarity", "interface_model", "cosim"];
const ROOFS: [&str; 2] = ["mechanics", "schemes"];

/// Names that follow `crate::` in the code of one line; what stands behind `//` is prose.
fn doors(line: &str) -> Vec<String> {
    let code = line.split("//").next().unwrap_or_default();
    let name = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    code.split("crate::").skip(1).map(name).collect()
}

/// What is wrong with one line of a room, if anything.
fn fault(room: &str, line: &str) -> Option<String> {
    let floor = |name: &str| FLOORS.iter().position(|floor| *floor == name);
    let below = floor(room).or_else(|| ROOFS.contains(&room).then_some(FLOORS.len()));
    let Some(below) = below else { return Some(format!("room `{room}` is not in the list: say what it stands on")) };
    let open = |door: &str| door == room || door == "error" || floor(door).is_some_and(|floor| floor < below);
    let closed = doors(line).into_iter().find(|door| !open(door))?;
    Some(match closed.as_str() {
        "" => "`crate::{…}` hides which rooms it opens: write one `use` per room".to_owned(),
        _ => format!("room `{room}` stands on {:?}, not on `{closed}`", &FLOORS[..below]),
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
fn no_room_of_the_core_may_open_a_door_above_it() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/rimbench-core/src");
    let (mut faults, mut seen) = (Vec::new(), 0);
    for room in FLOORS.iter().chain(&ROOFS) {
        let mut files = Vec::new();
        sources(&src.join(room), &mut files);
        for file in files {
            for (number, line) in fs::read_to_string(&file).unwrap().lines().enumerate() {
                seen += doors(line).len();
                faults.extend(fault(room, line).map(|fault| format!("{}:{}: {fault}", file.display(), number + 1)));
            }
        }
    }
    assert!(seen > 50, "only {seen} uses of `crate::` found: the check reads nothing");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_check_must_see_a_door_that_leads_upwards() {
    assert!(fault("mechanics", "use crate::schemes::all_schemes;").unwrap().contains("not on `schemes`"));
    assert!(fault("linear_algebra", "    crate::cosim::cosimulate(&setup)").is_some());
    assert!(
        fault("cosim", "use crate::{error::Error, mechanics::monolithic};").unwrap().contains("one `use` per room")
    );
    assert!(fault("attic", "use crate::error::Error;").unwrap().contains("not in the list"));
    assert_eq!(fault("mechanics", "use crate::cosim::Ports; // not crate::schemes"), None);
    assert_eq!(fault("cosim", "/// See [`Error`](crate::schemes::register)."), None);
}

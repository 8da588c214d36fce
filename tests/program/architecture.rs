//! Each room of the core opens only doors below it, and no files of the loop's room go in a circle; between packages the
//! compiler sees to that.

use crate::support::sources;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the contact crate and of the core, each with those that it may open.
const ROOMS: [(&str, &[&str]); 10] = [
    ("linear_algebra", &[]),
    ("contact_law", &[]),
    ("complementarity", &["linear_algebra"]),
    ("friction", &["linear_algebra", "complementarity"]),
    ("affine_step", &["linear_algebra", "contact_law", "complementarity", "friction"]),
    ("interface_model", &[]),
    ("cosim", &["interface_model"]),
    ("ceilings", &["cosim"]),
    ("mechanics", &["interface_model", "cosim"]),
    ("schemes", &["interface_model", "cosim", "ceilings"]),
];

/// The two crates of the numerics.
const CRATES: [&str; 2] = ["rimbench-contact", "rimbench-core"];

/// What every room may open.
const HALLS: [&str; 2] = ["error", "name"];

/// Names that follow `crate::` in the code of one line; what stands behind `//` is prose.
fn doors(line: &str) -> Vec<String> {
    let code = line.split("//").next().unwrap_or_default();
    let name = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    code.split("crate::").skip(1).map(name).collect()
}

/// What is wrong with one line of a room, if anything.
fn fault(room: &str, line: &str) -> Option<String> {
    let Some((_, below)) = ROOMS.iter().find(|(name, _)| *name == room) else {
        return Some(format!("room `{room}` is not in the list: say what it stands on"));
    };
    let open = |door: &str| door == room || HALLS.contains(&door) || below.contains(&door);
    let closed = doors(line).into_iter().find(|door| !open(door))?;
    Some(match closed.as_str() {
        "" => "`crate::{…}` hides which rooms it opens: write one `use` per room".to_owned(),
        _ => format!("room `{room}` stands on {below:?}, not on `{closed}`"),
    })
}

fn code_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("crates").join(name).join("src")
}

/// Folders of the rooms of both crates.
fn rooms() -> Vec<PathBuf> {
    let entries = CRATES.iter().flat_map(|name| fs::read_dir(code_of(name)).unwrap());
    entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()).collect()
}

#[test]
fn no_room_of_the_core_may_open_a_door_above_it() {
    let (mut faults, mut seen) = (Vec::new(), 0);
    let rooms = rooms();
    for folder in &rooms {
        let room = folder.file_name().unwrap().to_string_lossy();
        for (file, text) in sources(folder) {
            for (number, line) in text.lines().enumerate() {
                seen += doors(line).len();
                faults.extend(fault(&room, line).map(|fault| format!("{}:{}: {fault}", file.display(), number + 1)));
            }
        }
    }
    assert!(seen > 50, "only {seen} uses of `crate::` found: the check reads nothing");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert_eq!(rooms.len(), ROOMS.len(), "{rooms:?}");
}

#[test]
fn the_check_must_see_a_door_that_leads_upwards() {
    assert!(fault("mechanics", "use crate::schemes::standard_schemes;").unwrap().contains("not on `schemes`"));
    assert!(fault("linear_algebra", "    crate::cosim::cosimulate(&setup)").is_some());
    let several = "use crate::{error::Error, mechanics::monolithic};";
    assert!(fault("cosim", several).unwrap().contains("one `use` per room"));
    assert!(fault("attic", "use crate::error::Error;").unwrap().contains("not in the list"));
    assert_eq!(fault("mechanics", "use crate::cosim::Ports; // not crate::schemes"), None);
    assert_eq!(fault("cosim", "/// See [`Error`](crate::schemes::SchemeEntry)."), None);
}

/// Files with the files of the same room that each uses.
type Uses = BTreeMap<String, BTreeSet<String>>;

/// Which file uses which, from the `use` lines. A folder with the name of a file is part of that file.
fn uses(room: &str) -> Uses {
    let folder = code_of("rimbench-core").join(room);
    let mut uses = Uses::new();
    for (path, text) in sources(&folder) {
        let inside = path.strip_prefix(&folder).unwrap().with_extension("");
        let own = inside.iter().next().unwrap().to_string_lossy().into_owned();
        let direct = inside.iter().count() == 1;
        for line in text.lines() {
            let prefix = format!("use crate::{room}::");
            let used = line.strip_prefix(&prefix).or_else(|| line.strip_prefix("use super::").filter(|_| direct));
            let Some(used) = used else { continue };
            let file: String = used.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            // The list of what the room shows uses everything.
            if file != own && own != "mod" && file.starts_with(|c: char| c.is_lowercase()) {
                uses.entry(own.clone()).or_default().insert(file);
            }
        }
    }
    uses
}

/// A circle, if there is one.
fn circle(uses: &Uses) -> Option<Vec<String>> {
    fn from(file: &str, uses: &Uses, path: &mut Vec<String>, done: &mut BTreeSet<String>) -> Option<Vec<String>> {
        if let Some(start) = path.iter().position(|known| known == file) {
            return Some(path[start..].to_vec());
        }
        if !done.insert(file.to_owned()) {
            return None;
        }
        path.push(file.to_owned());
        let found = uses.get(file).into_iter().flatten().find_map(|next| from(next, uses, path, done));
        path.pop();
        found
    }
    let mut done = BTreeSet::new();
    uses.keys().find_map(|file| from(file, uses, &mut Vec::new(), &mut done))
}

#[test]
fn the_files_of_the_loop_must_not_use_each_other_in_a_circle() {
    let uses = uses("cosim");
    assert!(uses.len() > 10, "only {} files use others: the check reads nothing", uses.len());
    assert_eq!(circle(&uses), None);
}

#[test]
fn the_check_must_see_a_circle() {
    let uses = |pairs: &[(&str, &str)]| {
        let mut uses = Uses::new();
        for (a, b) in pairs {
            uses.entry((*a).to_owned()).or_default().insert((*b).to_owned());
        }
        uses
    };
    assert_eq!(circle(&uses(&[("a", "b"), ("a", "c"), ("b", "c")])), None);
    assert_eq!(circle(&uses(&[("a", "b"), ("b", "c"), ("c", "b")])), Some(vec!["b".to_owned(), "c".to_owned()]));
}

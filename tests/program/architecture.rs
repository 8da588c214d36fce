//! Each room of the core opens only doors below it, and no files use each other in a circle; between packages the compiler sees to
//! that.

use crate::prose::files;
use crate::support::sources;
use rimbench::cosim::OutcomeKind;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the contact crate and of the core, each with those that it may open.
const ROOMS: [(&str, &[&str]); 11] = [
    ("linear_algebra", &[]),
    ("problem", &["linear_algebra"]),
    ("contact_law", &[]),
    ("complementarity", &["linear_algebra", "problem"]),
    ("friction", &["linear_algebra", "problem", "complementarity"]),
    ("affine_step", &["linear_algebra", "contact_law", "complementarity", "friction"]),
    ("interface_model", &[]),
    ("cosim", &["interface_model"]),
    ("iterative", &["cosim"]),
    ("mechanics", &["interface_model", "cosim"]),
    ("schemes", &["interface_model", "cosim", "iterative"]),
];

/// The two crates of the numerics.
const CRATES: [&str; 2] = ["rimbench-contact", "rimbench-core"];

/// What every room may open; an exported macro stands at the root of its crate, whichever room writes it.
const HALLS: [&str; 3] = ["error", "name", "subsystem_methods"];

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

/// Modules with the modules that each uses.
type Uses = BTreeMap<String, BTreeSet<String>>;

/// Which file uses which, below the `src` of a crate. What a file takes from those it is part of is left out: each may use its parts, and
/// they what it holds for all of them.
fn uses(src: &Path) -> Uses {
    let module = |path: &Path| {
        let inside = path.strip_prefix(src).unwrap().with_extension("");
        let parts: Vec<_> = inside.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        parts.into_iter().filter(|part| !matches!(part.as_str(), "mod" | "lib")).collect::<Vec<_>>()
    };
    let files: Vec<(Vec<String>, String)> =
        sources(src).into_iter().map(|(path, text)| (module(&path), text)).collect();
    let is_file = |path: &[String]| files.iter().any(|(other, _)| other == path);
    let mut uses = Uses::new();
    for (own, text) in &files {
        let code = text.lines().map(code).collect::<Vec<_>>().join("\n");
        let parts = files.iter().filter(|(other, _)| other.len() == own.len() + 1 && other.starts_with(own));
        for (part, _) in parts.filter(|(part, _)| uses_part(&code, &part[own.len()])) {
            uses.entry(own.join("/")).or_default().insert(part.join("/"));
        }
        for (up, path) in paths(&code) {
            let base = if up == 0 { &[][..] } else { &own[..own.len().saturating_sub(up)] };
            let mut used = base.to_vec();
            for part in path {
                used.push(part);
                if !is_file(&used) {
                    used.pop();
                    break;
                }
            }
            if !used.starts_with(own) && !own.starts_with(&used) {
                uses.entry(own.join("/")).or_default().insert(used.join("/"));
            }
        }
    }
    uses
}

/// Whether the code of a file uses what stands in a part of it: to hand it on is no use.
fn uses_part(code: &str, part: &str) -> bool {
    let code = code.replace("self::", "");
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut names, mut others) = (BTreeSet::new(), String::new());
    for statement in code.split_inclusive(';') {
        match statement.split_once(&format!("use {part}::")) {
            Some((before, taken)) if before.trim().is_empty() || before.trim().starts_with("pub") => {
                names.extend(taken.split(|c| !is_word(c)).filter(|name| !name.is_empty() && *name != "as"));
            }
            _ => others += statement,
        }
    }
    others.contains(&format!("{part}::")) || others.split(|c| !is_word(c)).any(|word| names.contains(word))
}

/// The paths in a text that begin with `crate::`, and with `super::` so many times.
fn paths(code: &str) -> Vec<(usize, Vec<String>)> {
    let mut found = Vec::new();
    let mut rest = code;
    while let Some(at) = ["crate::", "super::"].iter().filter_map(|word| rest.find(word)).min() {
        rest = &rest[at..];
        let mut up = 0;
        while let Some(after) = rest.strip_prefix("super::") {
            (up, rest) = (up + 1, after);
        }
        rest = rest.strip_prefix("crate::").filter(|_| up == 0).unwrap_or(rest);
        let group = rest.strip_prefix('{').map(|group| group.split(['}', ';']).next().unwrap_or_default());
        for item in group.map_or(vec![rest], |group| group.split(',').collect()) {
            let mut path = Vec::new();
            for part in item.trim().split("::") {
                let name: String = part.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                let ends = name.len() < part.len();
                path.extend(Some(name).filter(|name| !name.is_empty()));
                if ends {
                    break;
                }
            }
            found.push((up, path));
        }
    }
    found
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
fn no_files_but_parent_and_child_use_each_other_in_a_circle() {
    let mut seen = 0;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let crates =
        ["cases", "contact", "core", "dev", "figures", "fmi", "harness", "python", "results", "statistics", "web"];
    for folder in crates.map(|name| code_of(&format!("rimbench-{name}"))).into_iter().chain([root.join("src")]) {
        assert!(
            sources(&folder).iter().all(|(_, text)| !text.contains("too_many_arguments")),
            "{}: arguments that belong together are one value",
            folder.display()
        );
        let uses = uses(&folder);
        seen += uses.len();
        assert_eq!(circle(&uses), None, "{}", folder.display());
    }
    assert!(seen > 250, "{seen} files use others: the check reads nothing");
}

/// Names of outcomes that are names of something else there: of quantities of claims, columns and statistics of summaries, words.
const OF_OTHERS: [(&str, &[&str]); 4] = [
    ("crates/rimbench-harness/src/comparison.rs", &["completed"]),
    ("crates/rimbench-core/src/error.rs", &["stopped"]),
    ("crates/rimbench-results/src/kept.rs", &["completed"]),
    ("crates/rimbench-figures/src/pages.rs", &["completed"]),
];

#[test]
fn what_an_outcome_counts_as_is_said_in_one_place_and_nothing_else_compares_names() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let rust = sources(&root.join("crates")).into_iter().chain(sources(&root.join("src")));
    let scripts = files(&root.join("crates/rimbench-figures/page"), "js").into_iter();
    let scripts = scripts.map(|file| (file.clone(), fs::read_to_string(file).unwrap()));
    let (mut seen, mut faults, mut used) = (0, Vec::new(), BTreeSet::new());
    for (file, text) in rust.chain(scripts) {
        let path = file.strip_prefix(root).unwrap().to_string_lossy().into_owned();
        if path == "crates/rimbench-core/src/cosim/outcome.rs"
            || path.contains("/tests/")
            || path.ends_with("/tests.rs")
        {
            continue;
        }
        let others = OF_OTHERS.iter().find(|(other, _)| *other == path).map_or(&[][..], |(_, names)| names);
        let code_of_all = text.split("\n#[cfg(test)]\nmod ").next().unwrap_or_default();
        for (number, line) in code_of_all.lines().enumerate() {
            seen += 1;
            for (name, _) in OutcomeKind::NAMES.iter().filter(|(name, _)| code(line).contains(&format!("\"{name}\""))) {
                match others.contains(name) {
                    true => drop(used.insert((path.clone(), *name))),
                    false => faults.push(format!("{path}:{}: `{name}`: ask OutcomeKind or OutcomeClass", number + 1)),
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert_eq!(used.len(), OF_OTHERS.iter().map(|(_, names)| names.len()).sum::<usize>(), "{used:?}");
    assert!(seen > 10_000, "only {seen} lines of code found: the check reads nothing");
}

#[test]
fn medians_are_computed_in_the_table_of_runs_and_nowhere_else() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // A reader asks a pool for its median; who computes one has a function of that name.
    let computes = |line: &str| {
        let code = line.split("//").next().unwrap_or_default();
        code.match_indices("median(").any(|(at, _)| !code[..at].ends_with(['.', '_', '"']))
    };
    let mut seen = 0;
    for place in ["crates", "src", "tests", "benches"] {
        for (file, text) in sources(&root.join(place)) {
            let pool = file.ends_with("rimbench-statistics/src/pool.rs");
            for (number, line) in text.lines().enumerate().filter(|(_, line)| computes(line)) {
                assert!(pool, "{}:{}: {line}: ask a pool", file.display(), number + 1);
                seen += 1;
            }
        }
    }
    assert!(seen > 0, "the table of runs computes none: the check reads nothing");
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
    assert!(uses_part("mod a;\npub use a::A;\nfn f(_: A) {}", "a") && uses_part("mod a;\nfn f() { a::g() }", "a"));
    assert!(!uses_part("mod a;\nmod b;\npub use a::{A, B};\nuse b::C;\nfn f(_: C) {}", "a"));
    let found = paths("use super::{font, clip::Rect};\nuse super::super::a::b; crate::c::d()");
    let path = |up, parts: &[&str]| (up, parts.iter().map(|part| (*part).to_owned()).collect::<Vec<_>>());
    assert_eq!(found, [path(1, &["font"]), path(1, &["clip", "Rect"]), path(2, &["a", "b"]), path(0, &["c", "d"])]);
}

/// Code of a line, without its comment.
fn code(line: &str) -> &str {
    line.split("//").next().unwrap_or_default()
}

/// Files of both crates, with their text.
fn numerics() -> Vec<(PathBuf, String)> {
    CRATES.iter().flat_map(|name| sources(&code_of(name))).collect()
}

/// Words that the field has other terms for.
const OLD_WORDS: &str = "Abilities add_to_diagonal Attachments catch_up ceilings Course factor_of_r Findings ForceFollowing foresee_anew \
    GapMotion give_to give_way hand_over hold_all ImpulseSet KinkFinder Kinks kinks KnownRows LinearFlow lists_like meeting Meetings \
    meetings MiddleStep Need no_abilities not_offered place_of note_defect note_hits note_listing OilLines Outlook own_approach Pace packed_anew PackedModel ParametricStep rated_force \
    relist resting_approach set_r_aside send_ahead speaks_first StepController Supervision take_guess takes_course tell_course \
    Transmission uncut Watched Witness Witnessed without_room";

#[test]
fn the_numerics_must_use_the_terms_of_the_field_and_their_comments_say_what_is_there() {
    let old: BTreeSet<&str> = OLD_WORDS.split_whitespace().collect();
    let (mut faults, mut functions) = (Vec::new(), 0);
    for (file, text) in numerics() {
        let mut verb = None;
        for (number, line) in text.lines().map(str::trim_start).enumerate() {
            let place = || format!("{}:{}: {line}", file.display(), number + 1);
            let mut words = code(line).split(|c: char| !c.is_alphanumeric() && c != '_');
            faults.extend(words.any(|word| old.contains(word)).then(place));
            let documented = verb.filter(|_| line.starts_with("pub") && line.contains("fn "));
            faults.extend(documented.filter(|verb| !verb).map(|_| place()));
            functions += usize::from(documented.is_some());
            verb = verb.filter(|_| line.starts_with(['/', '#']));
            let Some(at) = line.find("//") else { continue };
            let comment = line[at..].trim_start_matches(['/', '!', ' ']).to_lowercase();
            let words: Vec<&str> = comment.split(|c: char| !c.is_alphabetic()).collect();
            verb = verb.or(line.starts_with("/// ").then(|| words[0].ends_with('s')));
            let person = |word| ["who", "whoever", "nobody", "somebody", "everybody"].contains(word);
            faults.extend(words.iter().any(person).then(place));
        }
    }
    assert!(old.len() > 40 && functions > 500 && faults.is_empty(), "{functions} functions\n{}", faults.join("\n"));
}

#[test]
fn the_files_of_the_numerics_must_stay_short() {
    const LONG: [&str; 2] = ["sparse_factor.rs", "sparse_active_set.rs"];
    for (file, text) in numerics() {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        assert!(text.lines().count() <= 480 || LONG.contains(&name.as_str()), "{} is too long", file.display());
    }
}

#[test]
fn every_item_that_the_page_on_the_paper_names_must_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("docs/method/from-the-paper-to-the-code.md")).unwrap();
    let links = page.split("[`").skip(1).map(|rest| {
        let (item, rest) = rest.split_once("`](").expect("an item and its file");
        (item, rest.split_once(')').expect("a file").0)
    });
    let mut seen = 0;
    for (item, file) in links {
        let text = fs::read_to_string(root.join("docs/method").join(file)).unwrap();
        let declares = |line: &str| {
            let line = code(line).trim_start();
            let kinds = ["fn ", "struct ", "enum ", "trait "];
            let named =
                |rest: &str| rest.strip_prefix(item).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric));
            let variant = [format!("{item},"), format!("{item}(")].iter().any(|start| line.starts_with(start.as_str()));
            variant
                || line.strip_prefix("pub ").is_some_and(|field| field.starts_with(&format!("{item}:")))
                || kinds.iter().any(|kind| line.split_once(kind).is_some_and(|(_, rest)| named(rest)))
        };
        assert!(text.lines().any(declares), "{file} has no `{item}`");
        seen += 1;
    }
    assert!(seen > 30, "only {seen} items found");
}

//! Between the yards of crates there are fences, and no files use each other in a circle; between packages the compiler
//! sees to that.

use crate::support::sources;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The folders of the crates, each with the name of its yard.
fn crates() -> Vec<(String, PathBuf)> {
    let folders = |path: &Path| {
        let entries = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
        entries.filter(|path| path.is_dir()).collect::<Vec<_>>()
    };
    let yards = folders(&Path::new(env!("CARGO_MANIFEST_DIR")).join("crates")).into_iter();
    yards.flat_map(|yard| folders(&yard).into_iter().map(move |path| (name_of(&yard), path))).collect()
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

/// The names that a manifest has in any table of dependencies: for a target, for tests and for the build script as
/// well.
fn dependencies(manifest: &toml::Table) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (key, value) in manifest {
        let Some(table) = value.as_table() else { continue };
        match key.as_str() {
            "dependencies" | "dev-dependencies" | "build-dependencies" => found.extend(table.keys().cloned()),
            _ => found.extend(dependencies(table)),
        }
    }
    found
}

#[test]
fn the_benchmark_uses_nothing_of_the_other_yards_and_presentation_no_interface() {
    let crates = crates();
    let yard_of: BTreeMap<String, &str> = crates.iter().map(|(yard, path)| (name_of(path), yard.as_str())).collect();
    let mut seen = 0;
    for (yard, path) in &crates {
        let manifest = std::fs::read_to_string(path.join("Cargo.toml")).unwrap();
        let allowed: &[&str] = match yard.as_str() {
            "benchmark" => &["benchmark"],
            "presentation" => &["benchmark", "presentation"],
            "interfaces" => &["benchmark", "presentation", "interfaces"],
            other => panic!("{other} is no yard: which may its crates use?"),
        };
        for used in dependencies(&manifest.parse().unwrap()) {
            let own = used.starts_with("rimbench");
            seen += usize::from(own);
            let at = yard_of.get(&used).copied();
            assert!(
                !own || at.is_some_and(|at| allowed.contains(&at)) || (yard == "interfaces" && at.is_none()),
                "{} of {yard} uses {used} of {}",
                name_of(path),
                at.unwrap_or("the program")
            );
        }
    }
    assert!(seen > 20, "{seen} uses of own crates: the check reads nothing");
}

/// Modules with the modules that each uses.
type Uses = BTreeMap<String, BTreeSet<String>>;

/// Which file uses which, below the `src` of a crate. What a file takes from those it is part of is left out: each may
/// use its parts, and they what it holds for all of them.
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
fn a_library_whose_tests_are_not_built_must_have_none() {
    let untested = crates().into_iter().map(|(_, path)| path).filter(|path| {
        let manifest = std::fs::read_to_string(path.join("Cargo.toml")).unwrap().parse::<toml::Table>().unwrap();
        manifest.get("lib").and_then(|lib| lib.get("test")).and_then(toml::Value::as_bool) == Some(false)
    });
    let mut seen = 0;
    for (file, _) in untested.flat_map(|path| sources(&path.join("src"))) {
        seen += 1;
        assert!(
            !std::fs::read_to_string(&file).unwrap().contains("#[test]"),
            "{} has tests that never run",
            file.display()
        );
    }
    assert!(seen > 20, "{seen} files");
}

#[test]
fn no_files_but_parent_and_child_use_each_other_in_a_circle() {
    let mut seen = 0;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let crates = crates().into_iter().map(|(_, path)| path.join("src"));
    for folder in crates.chain([root.join("src")]) {
        let uses = uses(&folder);
        seen += uses.len();
        assert_eq!(circle(&uses), None, "{}", folder.display());
    }
    assert!(seen > 250, "{seen} files use others: the check reads nothing");
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

//! Figures and pages, from made-up results and from those that are kept.

mod case_pictures;
mod figures;
mod kept_figures;
mod pages;

use std::path::{Path, PathBuf};

/// The project's folder.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

/// Each of these stands in a text.
fn assert_has(text: &str, wanted: &[&str]) {
    for wanted in wanted {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
}

/// The files of a kind below a folder.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|own| own == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The page of a case or scheme, as the list of its folder has it.
fn page_of(folder: &str, name: &str) -> Option<PathBuf> {
    let folder = root().join("docs").join(folder);
    let row = format!("| [{name}](");
    let list = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let listed = list.lines().find_map(|line| line.strip_prefix(&row)?.split(')').next());
    let page = folder.join(listed.map_or_else(|| format!("{name}.md"), str::to_owned));
    (listed.is_some() || page.is_file()).then_some(page)
}

//! What a folder of results holds.

use crate::drawing::{Drawing, PanelData};
use crate::vector::escaped;
use rimbench_core::cosim::OutcomeKind;
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums::CHECKSUMS;
use rimbench_results::claims::CheckedClaim;
use rimbench_results::kept::{DIGEST, Digest, SUMMARY};
use rimbench_results::results_table::{ResultsTable, read_table};
use rimbench_results::run_table::RunTable;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A figure of a study: its identifier, what the reader sees under it, and the picture or why there is none.
pub type Made = (String, String, std::result::Result<Picture, String>);

/// The picture of a figure.
#[derive(Debug, Clone)]
pub enum Picture {
    /// Drawn from rows, with the values behind it.
    Drawn(Box<Drawing>),
    /// The SVG that is kept where rows are not.
    Kept(String),
}

impl Picture {
    /// Reads the SVG that is kept of a figure.
    ///
    /// # Errors
    /// [`Error::File`] for a file that is missing, or that holds more than shapes and text.
    pub fn kept(path: &Path) -> Result<Self> {
        let svg =
            std::fs::read_to_string(path).map_err(|error| Error::file(path, format!("cannot be read: {error}")))?;
        if is_plain(&svg) { Ok(Picture::Kept(svg)) } else { Err(Error::file(path, "holds more than shapes and text")) }
    }

    pub(super) fn svg(&self) -> String {
        let svg = match self {
            Picture::Drawn(drawing) => crate::vector::svg(drawing),
            Picture::Kept(svg) => svg.clone(),
        };
        svg.replace(crate::vector::DARK, "")
    }

    /// The values behind it; none of a kept one.
    pub(super) fn data(&self) -> &[PanelData] {
        match self {
            Picture::Drawn(drawing) => &drawing.data,
            Picture::Kept(_) => &[],
        }
    }
}

/// Elements and attributes of our pictures.
const ELEMENTS: &str = "svg title desc g path text";
const ATTRIBUTES: &str = "xmlns width height viewBox role font-family stroke-linejoin fill stroke stroke-width stroke-dasharray d font-size \
                          font-weight text-anchor x y textLength lengthAdjust transform class data-series data-step data-lane \
                          data-span data-forces /";

/// Whether a picture holds nothing but what ours hold, so that nothing in it runs or leads elsewhere: it becomes a part of
/// the page.
fn is_plain(svg: &str) -> bool {
    let svg = svg.replace(crate::vector::DARK, "");
    let is_ours = |element: &str| {
        // Within quotes nothing ends a tag: what would is escaped.
        let tag = element.split('>').next().unwrap_or_default();
        let (name, attributes) = tag.split_once(char::is_whitespace).unwrap_or((tag, ""));
        let mut names = attributes.split('"').step_by(2).map(|name| name.trim().trim_end_matches('='));
        let known = |of: &str, name: &str| of.split(' ').any(|own| own == name);
        known(ELEMENTS, name.trim_matches('/')) && names.all(|name| name.is_empty() || known(ATTRIBUTES, name))
    };
    svg.starts_with("<svg") && svg.split('<').skip(1).all(is_ours)
}

/// One study: an experiment with its results.
#[derive(Debug, Clone)]
pub struct Study {
    /// `group/name`, also the beginning of its command.
    pub name: String,
    /// Where its files are.
    pub folder: PathBuf,
    /// Its question, from the copy of the experiment file.
    pub question: String,
    /// Its runs, if they can be read.
    pub runs: Option<RunTable>,
    /// Where rows are not kept: how many there were, and their medians.
    pub kept: Option<(usize, ResultsTable)>,
    /// How many runs are planned, if that is known.
    pub planned: Option<usize>,
    /// Its figures.
    pub figures: Vec<Made>,
    /// Where the simulator of the page shows runs of a figure, by its identifier.
    pub addresses: BTreeMap<String, String>,
    /// Its claims.
    pub claims: Vec<CheckedClaim>,
    /// How many claims its experiment file has that could not be checked, none if not even that is known, and why.
    pub unchecked: Option<(Option<usize>, String)>,
    /// Whether its experiment is, to the letter, the one that the project has at `experiments/<name>.toml`.
    pub is_shipped: bool,
    /// What is wrong with it or missing of it, in sentences.
    pub remarks: Vec<String>,
}

impl Study {
    /// Reads what a study's folder says by itself; figures, claims and the plan come from elsewhere.
    pub fn read(folder: &Path) -> Self {
        let part =
            |path: Option<&Path>| path.and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
        // A folder that is given as `.` has a name all the same.
        let place = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        let name = format!("{}/{}", part(place.parent()), part(Some(&place)));
        let mut remarks = Vec::new();
        let path = folder.join("runs.csv");
        let summary = || Some((Digest::read(folder).ok()?.rows, read_table(&folder.join(SUMMARY)).ok()?));
        // Rows that were there and are gone are missed, not made again.
        let kept = if path.exists() || folder.join(CHECKSUMS).exists() { None } else { summary() };
        let runs = match RunTable::read(&path) {
            Ok(runs) => Some(runs),
            Err(_) if kept.is_some() => None,
            Err(error) => {
                remarks.push(format!("its runs cannot be shown: {}", said(folder, &error)));
                None
            }
        };
        Study {
            name,
            folder: folder.to_owned(),
            question: question(folder),
            runs,
            kept,
            planned: None,
            figures: Vec::new(),
            addresses: BTreeMap::new(),
            claims: Vec::new(),
            unchecked: None,
            is_shipped: false,
            remarks,
        }
    }

    /// An error about it in words that name no folder of this machine: files are named as `group/name/file`.
    pub fn said(&self, error: &Error) -> String {
        said(&self.folder, error)
    }

    /// Says which file holds its experiment, for a command: only that of a shipped one is known.
    pub(super) fn file(&self) -> String {
        if self.is_shipped { format!("experiments/{}.toml", self.name) } else { "FILE".to_owned() }
    }

    /// A command about its experiment, as HTML, and what FILE is in it.
    pub(super) fn command(&self, verb: &str) -> String {
        let file = match self.is_shipped {
            true => String::new(),
            false => format!(", FILE being that of the experiment {}", escaped(&self.name)),
        };
        format!("<code>rimbench {verb} {}</code>{file}", escaped(&self.file()))
    }

    /// Number of runs, whether or not their rows are there.
    pub(super) fn count(&self) -> usize {
        let kept = self.kept.as_ref().map(|(count, _)| *count);
        self.runs.as_ref().map(|table| table.len()).or(kept).unwrap_or_default()
    }

    /// An anchor in the page.
    pub fn anchor(&self) -> String {
        format!("study-{}", self.name.replace(|c: char| !c.is_ascii_alphanumeric(), "-"))
    }

    /// How many runs ended in each way, in the order of the file.
    pub fn outcomes(&self) -> Vec<(&'static str, usize)> {
        let mut counts: Vec<(&'static str, usize)> = Vec::new();
        for run in self.runs.iter().flat_map(RunTable::runs) {
            let name = run.found.outcome.name();
            match counts.iter_mut().find(|(known, _)| *known == name) {
                Some((_, count)) => *count += 1,
                None => counts.push((name, 1)),
            }
        }
        counts
    }

    /// What is missing of it, in sentences.
    pub fn missing(&self) -> Vec<String> {
        let mut missing = self.remarks.clone();
        if let Some(runs) = &self.runs {
            let planned = self.planned.filter(|planned| runs.len() < *planned);
            missing.extend(planned.map(|planned| format!("{} of {planned} planned runs are there", runs.len())));
            if runs.is_empty() {
                missing.push("it holds no run".to_owned());
            } else if self.outcomes().iter().all(|(outcome, _)| *outcome != OutcomeKind::Completed.name()) {
                missing.push("no run completed, so there are no errors to show".to_owned());
            }
        }
        let figures = self.figures.iter().filter_map(|(id, _, made)| Some((id, made.as_ref().err()?)));
        missing.extend(figures.map(|(id, reason)| format!("figure {}: {reason}", id.replace('_', " "))));
        missing
    }

    /// Values of a column of `provenance.csv`.
    pub fn provenance(&self, column: &str) -> BTreeSet<String> {
        let values = |table: ResultsTable| {
            let column = table.column(column).ok()?;
            Some((0..table.len()).map(|row| table.text(row, column).to_owned()).collect())
        };
        read_table(&self.folder.join("provenance.csv")).ok().and_then(values).unwrap_or_default()
    }
}

/// An error about a study's folder without the path that leads to all results.
fn said(folder: &Path, error: &Error) -> String {
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let canonical = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let mut said = error.to_string();
    for place in [absolute, canonical] {
        for above in place.ancestors().skip(1).take(2).collect::<Vec<_>>().into_iter().rev() {
            let above = above.display().to_string();
            if above.len() > 1 {
                said = said.replace(&format!("{above}{}", std::path::MAIN_SEPARATOR), "");
            }
        }
    }
    said
}

/// The question in an experiment file.
fn question(folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join("experiment.toml")).unwrap_or_default();
    let table: toml::Table = toml::from_str(&text).unwrap_or_default();
    table.get("question").and_then(toml::Value::as_str).unwrap_or_default().to_owned()
}

/// What makes a folder that of a study: results, or records from which results are made.
const SIGNS: [&str; 4] = ["runs.csv", "experiment.toml", "records", DIGEST];

/// Finds the folders of studies: the folder itself, those in it, or those in the groups in it.
///
/// # Errors
/// [`Error::File`] if there is no such folder, it cannot be read, or there are none.
pub fn find_studies(folder: &Path) -> Result<Vec<PathBuf>> {
    if !folder.is_dir() {
        return Err(Error::file(folder, "is not a folder of results: name one, or run an experiment first"));
    }
    let is_study = |folder: &PathBuf| SIGNS.iter().any(|sign| folder.join(sign).exists());
    let mut level = vec![folder.to_owned()];
    let mut found = Vec::new();
    // A folder, its groups, their studies.
    for _ in 0..3 {
        let (studies, groups): (Vec<_>, Vec<_>) = level.into_iter().partition(is_study);
        found.extend(studies);
        level = Vec::new();
        for group in groups {
            level.extend(folders(&group)?);
        }
    }
    if found.is_empty() {
        let wanted = "holds no results: `runs.csv` is looked for in it, in <NAME> and in <GROUP>/<NAME>; `rimbench run` makes them";
        return Err(Error::file(folder, wanted));
    }
    found.sort();
    Ok(found)
}

/// The folders in a folder, hidden ones aside.
fn folders(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(|error| Error::file(folder, format!("cannot be read: {error}")))?;
    let paths = entries.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    let hidden = |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    Ok(paths.filter(|path| path.is_dir() && !hidden(path)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kept_picture_that_runs_or_leads_elsewhere_is_no_part_of_a_page() {
        let svg = |inside: &str| format!("<svg xmlns=\"http://www.w3.org/2000/svg\">{inside}</svg>");
        for inside in [
            "<path d=\"M0 0\"/>",
            "<g class=\"series\" data-series=\"one step on b\"></g>",
            "<text>a on=b script</text>",
        ] {
            assert!(is_plain(&svg(inside)), "{inside}");
        }
        for inside in [
            "<script>alert(1)</script>",
            "<path onload=\"alert(1)\"/>",
            "<path\nONCLICK =\"x\"/>",
            "<a href=\"x\">y</a>",
            "<SCRIPT/>",
        ] {
            assert!(!is_plain(&svg(inside)), "{inside}");
        }
        assert!(!is_plain("<html></html>"));
    }
}

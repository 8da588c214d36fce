//! A data package: the results of an experiment as others can cite and load them, without this program.
//!
//! ```text
//! <package>/
//!     datapackage.json    what each file and each column is (Data Package with Table Schema, version 1)
//!     README.md           the same for people, and how to load it
//!     CITATION.cff        how to cite it
//!     load.py, load.jl, load.m, load.R
//!     runs.csv, cost.csv, provenance.csv, parameters.csv, settings.csv, reference.csv, traces/, experiment.toml
//!     claims.csv          what the experiment claims and what came out, if it claims anything
//!     SHA256SUMS          checksums of the package
//! ```
//! Tables are those of the results folder but for one thing: an infinite number is `INF` or `-INF`, as a Table Schema wants it.

mod columns;
mod describe;

use crate::checked_results::checked_runs;
use crate::claims::{CheckedClaim, check_claims, write_claims};
use crate::experiment::Experiment;
use crate::files::make_folder;
use columns::{Column, Kind};
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums;
use std::path::Path;

/// Name of the description.
const DESCRIPTION: &str = "datapackage.json";

/// What a package says of itself that no file of the results does.
#[derive(Debug, Clone)]
pub struct Citation {
    /// Title; what the experiment asks, if absent.
    pub title: Option<String>,
    /// Authors, `Family, Given` or the name of a group.
    pub authors: Vec<String>,
    /// Licence of the data by its SPDX identifier.
    pub licence: String,
    /// Day of the release, `YYYY-MM-DD`.
    pub released: Option<String>,
}

impl Citation {
    /// # Errors
    /// [`Error::InvalidValue`] for no author, for a licence that is no identifier, for a day that is none.
    pub fn check(&self) -> Result<()> {
        let blank = |text: &String| text.trim().is_empty() || text.contains(char::is_control);
        if self.authors.is_empty() || self.authors.iter().any(blank) {
            let found = self.authors.iter().find(|author| blank(author)).map_or("", String::as_str);
            return Err(Error::invalid("author", found, "at least one author, `Family, Given` or the name of a group"));
        }
        if let Some(title) = self.title.as_ref().filter(|title| blank(title)) {
            return Err(Error::invalid("title", title, "a title in words"));
        }
        let plain = |c: char| c.is_ascii_alphanumeric() || ".-+".contains(c);
        if self.licence.is_empty() || !self.licence.chars().all(plain) {
            return Err(Error::invalid("license", &self.licence, "an SPDX identifier, such as CC-BY-4.0 or MIT"));
        }
        let day = |text: &str| {
            let parts: Vec<&str> = text.split('-').collect();
            let number = |part: &str, digits: usize| {
                part.parse::<u32>().ok().filter(|_| part.len() == digits && !part.starts_with('+'))
            };
            let [year, month, day] = parts[..] else { return None };
            let (year, month, day) = (number(year, 4)?, number(month, 2)?, number(day, 2)?);
            let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
            let days = [31, if leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
            (1..=*days.get(month.checked_sub(1)? as usize)?).contains(&day).then_some(())
        };
        match &self.released {
            Some(text) if day(text).is_none() => Err(Error::invalid("released", text, "a day, YYYY-MM-DD")),
            _ => Ok(()),
        }
    }
}

/// A file of a package.
struct Resource {
    /// Path below the package, with `/`.
    path: String,
    /// Names and columns of a table; none for what is no table.
    columns: Option<Vec<(String, Column)>>,
    bytes: u64,
    sha256: String,
}

/// Writes the results of an experiment, which must be whole, as a package into a folder that is empty or not there yet, and says how
/// many files it has.
///
/// # Errors
/// Those of the results (see [`check_claims`]) and of the citation; [`Error::File`] for a folder that holds something, or that cannot
/// be written, in which case nothing is left there.
pub fn export(
    experiment: &Experiment,
    catalogue: &Catalogue,
    folder: &Path,
    out: &Path,
    citation: &Citation,
) -> Result<usize> {
    citation.check()?;
    let (runs, quick) = checked_runs(experiment, catalogue, folder)?;
    refuse_filled(out)?;
    if is_inside(out, folder) {
        return Err(Error::file(out, "lies in the results folder itself: choose a place outside of it"));
    }
    let claims = check_claims(experiment, catalogue, folder)?;
    let was_there = out.is_dir();
    let written = write(experiment, folder, out, citation, (quick, runs.len()), &claims);
    if written.is_err() {
        remove(out, was_there);
    }
    written
}

/// Removes what an export that failed has left; a folder that was there, and empty, stays. What cannot be removed has no description,
/// which is written last.
fn remove(out: &Path, was_there: bool) {
    if !was_there {
        let _ = std::fs::remove_dir_all(out);
        return;
    }
    for entry in std::fs::read_dir(out).into_iter().flatten().flatten() {
        let path = entry.path();
        let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
    }
}

/// Writes all files of a package; returns how many there are.
fn write(
    experiment: &Experiment,
    folder: &Path,
    out: &Path,
    citation: &Citation,
    (quick, runs): (bool, usize),
    claims: &[CheckedClaim],
) -> Result<usize> {
    let stored = checksums::read(folder)?.unwrap_or_default();
    make_folder(out)?;
    let mut resources = Vec::new();
    for name in stored.keys() {
        let columns = copy(folder, out, name)?;
        resources.push(resource(out, name, columns)?);
    }
    if !claims.is_empty() {
        write_claims(&out.join("claims.csv"), claims)?;
        let columns = columns_of(&out.join("claims.csv"), "claims.csv")?;
        resources.push(resource(out, "claims.csv", Some(columns))?);
    }
    let write = |name: &str, text: String| write_atomically(&out.join(name), |file| file.write_all(text.as_bytes()));
    let about = describe::About { experiment, citation, quick, runs, claims: claims.len(), resources: &resources };
    let mut files: Vec<String> = resources.iter().map(|resource| resource.path.clone()).collect();
    for (name, text) in about.files() {
        write(name, text)?;
        files.push(name.to_owned());
    }
    checksums::write(out, files.iter().cloned())?;
    Ok(files.len() + 1)
}

/// Says a column of a trace in words, and its unit: `actuator_force_n` is `actuator force` and `N`.
pub fn column_in_words(name: &str) -> (String, String) {
    let column = columns::trace_column(name);
    (column.about, column.unit)
}

/// Whether a place that may not be there yet lies below a folder.
fn is_inside(place: &Path, folder: &Path) -> bool {
    let there = place.ancestors().find_map(|above| {
        let above = if above.as_os_str().is_empty() { Path::new(".") } else { above };
        above.canonicalize().ok()
    });
    there.zip(folder.canonicalize().ok()).is_some_and(|(place, folder)| place.starts_with(folder))
}

/// Refuses a place where something is already.
fn refuse_filled(out: &Path) -> Result<()> {
    match std::fs::read_dir(out).map(|mut entries| entries.next().is_none()) {
        Ok(true) => Ok(()),
        Ok(false) => Err(Error::file(out, "is not empty: choose a folder that is, or none that is there")),
        Err(_) if out.exists() => Err(Error::file(out, "is no folder")),
        Err(_) => Ok(()),
    }
}

fn resource(out: &Path, name: &str, columns: Option<Vec<(String, Column)>>) -> Result<Resource> {
    let path = out.join(name);
    let gone = || Error::file(&path, "has gone while the package was written");
    let bytes = path.metadata().map_err(|_| gone())?.len();
    let sha256 = checksums::sha256_of_file(&path).ok_or_else(gone)?;
    Ok(Resource { path: name.to_owned(), columns, bytes, sha256 })
}

/// Names and columns of a table.
fn columns_of(path: &Path, name: &str) -> Result<Vec<(String, Column)>> {
    let wrong = |error: csv::Error| Error::file(path, error);
    let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
    let trace = name.starts_with("traces/");
    let column = |header: &str| {
        let known = if trace { Some(columns::trace_column(header)) } else { columns::column(header) };
        let known = known.ok_or_else(|| Error::file(path, format!("has a column `{header}` that nobody can explain")));
        Ok((header.to_owned(), known?))
    };
    reader.headers().map_err(wrong)?.iter().map(column).collect()
}

/// Copies a file; a number that is infinite becomes what a Table Schema calls it.
fn copy(from: &Path, to: &Path, name: &str) -> Result<Option<Vec<(String, Column)>>> {
    let (source, target) = (from.join(name), to.join(name));
    if let Some(parent) = target.parent() {
        make_folder(parent)?;
    }
    if !name.ends_with(".csv") {
        let bytes = std::fs::read(&source).map_err(|error| Error::file(&source, format!("cannot be read: {error}")))?;
        write_atomically(&target, |file| file.write_all(&bytes))?;
        return Ok(None);
    }
    let columns = columns_of(&source, name)?;
    let mut reader = csv::Reader::from_path(&source).map_err(|error| Error::file(&source, error))?;
    write_atomically(&target, |file| {
        let mut writer = csv::Writer::from_writer(file);
        writer.write_record(columns.iter().map(|(name, _)| name))?;
        let mut row = csv::StringRecord::new();
        while reader.read_record(&mut row)? {
            let cells = row.iter().zip(&columns);
            writer.write_record(cells.map(|(cell, (_, column))| match (column.kind, cell) {
                (Kind::Number, "inf") => "INF",
                (Kind::Number, "-inf") => "-INF",
                _ => cell,
            }))?;
        }
        writer.flush()
    })?;
    Ok(Some(columns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{cost_header, runs_header};

    fn citation() -> Citation {
        Citation {
            title: None,
            authors: vec!["Doe, Jane".to_owned()],
            licence: "CC-BY-4.0".to_owned(),
            released: Some("2024-02-29".to_owned()),
        }
    }

    #[test]
    fn a_citation_needs_an_author_a_licence_and_a_day_that_was() {
        citation().check().unwrap();
        let wrong = [
            ("author", Citation { authors: Vec::new(), ..citation() }),
            ("author", Citation { authors: vec![" ".to_owned()], ..citation() }),
            ("title", Citation { title: Some(String::new()), ..citation() }),
            ("license", Citation { licence: "do what you like".to_owned(), ..citation() }),
            ("released", Citation { released: Some("2023-02-29".to_owned()), ..citation() }),
            ("released", Citation { released: Some("2023-2-9".to_owned()), ..citation() }),
            ("released", Citation { released: Some("2023-00-10".to_owned()), ..citation() }),
            ("released", Citation { released: Some("yesterday".to_owned()), ..citation() }),
        ];
        for (key, citation) in wrong {
            let said = citation.check().unwrap_err().to_string();
            assert!(said.starts_with(&format!("{key} = ")), "{said}");
        }
    }

    /// What is new in a table must be explained: nobody reads the code beside it.
    #[test]
    fn every_column_of_every_table_is_explained() {
        let catalogue = Catalogue::standard();
        let text = r#"
question = "?"
macro_steps_s = [5e-3]
[[cases]]
name = "wedge-box-friction"
[[schemes]]
scheme = "rim-nonsmooth"
[[claims]]
id = "c"
by = "ours"
text = "t"
scheme = "rim-nonsmooth"
metric = "position_error_aligned_rms_m"
expect = "<= 1"
finding = "not-measured"
"#;
        let experiment = Experiment::parse(Path::new("e.toml"), text.to_owned()).unwrap();
        let planned = experiment.plan(&catalogue, false).unwrap();
        let tables = [runs_header(&experiment, &planned), cost_header(), crate::provenance::HEADER.to_vec()];
        let has = |metric| tables[0].contains(&metric);
        assert!(has("position_error_aligned_rms_m") && !has("completed_as_predicted"), "only what is claimed");
        for name in tables.concat() {
            let column = columns::column(name).unwrap_or_else(|| panic!("{name} is not explained"));
            assert!(!column.about.is_empty(), "{name}");
        }
        let kind = |name| columns::column(name).unwrap().kind;
        assert_eq!(
            [kind("macro_step_s"), kind("phase"), kind("mechanics_steps")],
            [Kind::Number, Kind::Number, Kind::Text]
        );
        assert_eq!(columns::column("interface_residual_j").unwrap().unit, "J");
        assert_eq!(
            columns::trace_column("box_angle_rad"),
            Column { kind: Kind::Number, unit: "rad".into(), about: "box angle".into() }
        );
    }
}

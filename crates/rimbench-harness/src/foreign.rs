//! Whose a results folder is: what others have put there is not replaced without a word.

use super::experiment::{COPY, Experiment};
use super::files::make_folder;
use super::job::Job;
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use std::collections::HashSet;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// File beside the records that says which experiment file they belong to, on this machine.
const ORIGIN: &str = "records/origin";

/// Refuses a folder that holds somebody's own files under our names, or the results of another experiment file.
///
/// # Errors
/// [`Error::File`] naming what is there and what to do.
pub(super) fn refuse_foreign(job: &Job<'_>) -> Result<()> {
    let (runs, copy) = (job.folder.join("runs.csv"), job.folder.join(COPY));
    let advice = "move it away or choose another folder with --out";
    if runs.exists() && (!copy.is_file() || !begins_as_ours(&runs)) {
        return Err(Error::file(&runs, format!("was not written by an experiment and would be replaced: {advice}")));
    }
    let Ok(text) = std::fs::read_to_string(&copy) else { return Ok(()) };
    if text == job.experiment.source() {
        return Ok(());
    }
    if !runs.exists() && !job.folder.join("records").is_dir() {
        return Err(Error::file(&copy, format!("was not written by this program and would be replaced: {advice}")));
    }
    if job.fresh {
        return Ok(());
    }
    let advice = "use another folder, or --fresh to replace them";
    if let Some(other) = other_file(job.folder, job.experiment.path()) {
        let message = format!("holds the results of {}, an experiment of the same name: {advice}", other.display());
        return Err(Error::file(job.folder, message));
    }
    if runs.exists() && !job.folder.join(ORIGIN).exists() && !shares_runs(&text, job) {
        let message = format!("holds the results of another experiment of the same name: {advice}");
        return Err(Error::file(job.folder, message));
    }
    Ok(())
}

/// Notes which file the records of a folder belong to.
///
/// # Errors
/// [`Error::File`].
pub(super) fn note_origin(job: &Job<'_>) -> Result<()> {
    let records = job.folder.join("records");
    make_folder(&records)?;
    // An experiment that is part of the program has no file.
    let Ok(path) = job.experiment.path().canonicalize() else { return Ok(()) };
    let origin = job.folder.join(ORIGIN);
    let text = path.to_string_lossy().into_owned();
    if std::fs::read_to_string(&origin).is_ok_and(|known| known == text) {
        return Ok(());
    }
    write_atomically(&origin, |file| file.write_all(text.as_bytes()))
}

/// Whether a table has the first column of ours.
fn begins_as_ours(runs: &Path) -> bool {
    let mut line = String::new();
    let mut read = || -> std::io::Result<()> {
        let file = std::fs::File::open(runs)?;
        BufReader::new(file.take(64)).read_line(&mut line).map(drop)
    };
    let regular = runs.metadata().is_ok_and(|found| found.is_file());
    regular && read().is_ok() && line.starts_with("run_id,")
}

/// The file that the records belong to, if it is another than `own` and is still there: what was moved or deleted is no rival.
fn other_file(folder: &Path, own: &Path) -> Option<PathBuf> {
    let other = PathBuf::from(std::fs::read_to_string(folder.join(ORIGIN)).ok()?);
    let own = own.canonicalize().ok()?;
    let same_text = || std::fs::read(&other).ok() == std::fs::read(&own).ok();
    (other != own && other.is_file() && !same_text()).then_some(other)
}

/// Whether an earlier version of the experiment had a run that this one has.
fn shares_runs(text: &str, job: &Job<'_>) -> bool {
    let earlier = Experiment::parse(&job.folder.join(COPY), text.to_owned());
    let shares = |quick| {
        let earlier: HashSet<String> =
            earlier.as_ref().ok()?.plan(job.catalogue, quick).ok()?.into_iter().map(|run| run.id).collect();
        let planned = job.experiment.plan(job.catalogue, job.quick).ok()?;
        Some(planned.iter().any(|run| earlier.contains(&run.id)))
    };
    // What no longer has a plan was ours when it was written.
    [false, true].into_iter().any(|quick| shares(quick).unwrap_or(true))
}

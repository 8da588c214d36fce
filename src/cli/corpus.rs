//! `rimbench solvers --harvest`: harvest the contact problems of actual runs.

use super::print;
use super::progress::Progress;
use rimbench::atomic_file::check_writable_file;
use rimbench::corpus::{Corpus, Harvest, Problem, harvest, harvest_with_friction};
use rimbench::cosim::OutcomeClass;
use rimbench::shipped;
use std::path::{Path, PathBuf};

/// Writes the problems of actual runs, or those with friction, to a file: that of the project, if none is given.
pub(super) fn harvest_to(out: Option<PathBuf>, friction: bool) -> anyhow::Result<()> {
    let shipped = if friction { shipped::FRICTION_CORPUS.0 } else { shipped::CORPUS.0 };
    let out = out.unwrap_or_else(|| PathBuf::from(shipped));
    // A place that cannot be written is found before anything is computed.
    check_writable_file(&out)?;
    let progress = Progress::begin("solvers", None);
    let mut told = |source: &str| {
        progress.about(source);
        progress.done(OutcomeClass::Completed);
    };
    let written = match friction {
        true => written(&harvest_with_friction(&Harvest::with_friction(), &mut told)?, &out),
        false => written(&harvest(&Harvest::default(), &mut told)?, &out),
    };
    progress.end();
    print(&written?)
}

fn written<const FRICTION: bool>(corpus: &Corpus<FRICTION>, path: &Path) -> anyhow::Result<String> {
    corpus.write(path)?;
    let bytes = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let mut sizes: Vec<usize> = corpus.problems().map(Problem::contacts).collect();
    sizes.sort_unstable();
    let counted = sizes.chunk_by(|a, b| a == b).map(|chunk| format!("{} with n = {}", chunk.len(), chunk[0]));
    let counted = counted.collect::<Vec<_>>().join(", ");
    let (problems, stretches) = (corpus.len(), corpus.stretches.len());
    Ok(format!("{}: {problems} problems in {stretches} stretches, {bytes} bytes\n{counted}", path.display()))
}

//! `rimbench solvers --harvest`: harvest the contact problems of actual runs.

use super::print;
use super::progress::Every;
use rimbench::atomic_file::check_writable_file;
use rimbench::corpus::{Corpus, Harvest, Posed, harvest, harvest_with_friction};
use rimbench::shipped;
use std::path::{Path, PathBuf};

/// Writes the problems of actual runs, or those with friction, to a file: that of the project, if none is given.
pub(super) fn harvest_to(out: Option<PathBuf>, friction: bool) -> anyhow::Result<()> {
    let shipped = if friction { shipped::FRICTION_CORPUS.0 } else { shipped::CORPUS.0 };
    let out = out.unwrap_or_else(|| PathBuf::from(shipped));
    // A place that cannot be written is found before anything is computed.
    check_writable_file(&out)?;
    let mut lines = Every::seconds(2.0);
    let mut runs = 0;
    let mut progress = |source: &str| {
        runs += 1;
        if lines.is_due() {
            eprintln!("run {runs}: {source}");
        }
    };
    if friction {
        let corpus = harvest_with_friction(&Harvest::with_friction(), &mut progress)?;
        written(&corpus, &out)
    } else {
        let corpus = harvest(&Harvest::default(), &mut progress)?;
        written(&corpus, &out)
    }
}

fn written<P: Posed>(corpus: &Corpus<P>, path: &Path) -> anyhow::Result<()> {
    corpus.write(path)?;
    let bytes = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let mut sizes: Vec<usize> = corpus.problems().map(P::contacts).collect();
    sizes.sort_unstable();
    let counted = sizes.chunk_by(|a, b| a == b).map(|chunk| format!("{} with n = {}", chunk.len(), chunk[0]));
    print(&format!(
        "{}: {} problems in {} stretches, {bytes} bytes\n{}",
        path.display(),
        corpus.len(),
        corpus.stretches.len(),
        counted.collect::<Vec<_>>().join(", ")
    ))
}

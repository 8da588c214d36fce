//! `rimbench corpus`: harvest the contact problems of actual runs.

use super::print;
use super::progress::Every;
use clap::Args;
use rimbench::atomic_file::{check_writable_file, check_writable_folder};
use rimbench::corpus::{Corpus, Harvest, harvest};
use rimbench::shipped;
use std::path::{Path, PathBuf};

/// Arguments of `corpus`.
#[derive(Debug, Args)]
pub struct CorpusCommand {
    /// The file to write
    #[arg(long, value_name = "FILE", default_value = shipped::CORPUS.0)]
    out: PathBuf,
}

impl CorpusCommand {
    pub(super) fn run(self) -> anyhow::Result<()> {
        // A place that cannot be written is found before anything is computed.
        check_writable_folder(self.out.parent().unwrap_or(Path::new(".")))?;
        check_writable_file(&self.out)?;
        let mut lines = Every::seconds(2.0);
        let mut runs = 0;
        let corpus = harvest(&Harvest::default(), &mut |source| {
            runs += 1;
            if lines.is_due() {
                eprintln!("run {runs}: {source}");
            }
        })?;
        corpus.write(&self.out)?;
        print(&summary(&corpus, &self.out))
    }
}

fn summary(corpus: &Corpus, path: &Path) -> String {
    let bytes = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let mut sizes: Vec<usize> = corpus.problems().map(|problem| problem.q.len()).collect();
    sizes.sort_unstable();
    let counted = sizes.chunk_by(|a, b| a == b).map(|chunk| format!("{} with n = {}", chunk.len(), chunk[0]));
    format!(
        "{}: {} problems in {} stretches, {bytes} bytes\n{}",
        path.display(),
        corpus.len(),
        corpus.stretches.len(),
        counted.collect::<Vec<_>>().join(", ")
    )
}

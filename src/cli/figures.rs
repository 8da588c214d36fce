//! `rimbench figures`: all figures again, from stored results; also of experiments that no list of figures names.

use super::print;
use super::project::Project;
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::figures::FigureList;
use rimbench::figures::style::Styles;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `figures`.
#[derive(Debug, Args)]
pub struct Figures {
    /// Where results are: <DIR>/<group>/<name>
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// List of figures (see `rimbench list figure-keys`) [default: that of the project's folder, or the one built in]
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Only the figures of this group of experiments
    #[arg(long, value_name = "NAME")]
    group: Option<String>,
}

impl Figures {
    /// Exit code 1 if a figure could not be drawn although its experiment has results: an older picture may be left of it.
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        // A list of one's own is all that is asked for; without one, every experiment has figures.
        let (figures, failed) = match &self.file {
            Some(file) => (FigureList::read(file)?, Vec::new()),
            None => Project::find().figures()?.completed(&self.results, self.group.as_deref()),
        };
        let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
        let mut made = figures.make_all(&self.results, self.group.as_deref(), &styles)?;
        made.failed.extend(failed);
        for files in &made.files {
            print(&files.svg.display().to_string())?;
        }
        for (id, reason) in &made.missing {
            print(&format!("not drawn: {id}: {reason}"))?;
        }
        for (id, reason) in &made.failed {
            eprintln!("error: {id} cannot be drawn: {reason}");
        }
        let (drawn, not) = (made.files.len(), made.missing.len() + made.failed.len());
        print(&format!("{drawn} figures drawn, {not} not"))?;
        Ok(if made.failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}

//! `rimbench figures`: all figures again, from stored results.

use super::print;
use super::reproduce::home;
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::figures::FigureList;
use rimbench::figures::style::Styles;
use std::path::PathBuf;

/// Arguments of `figures`.
#[derive(Debug, Args)]
pub struct Figures {
    /// Where results are: <DIR>/<group>/<name>
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Only the figures of this group of experiments
    #[arg(long, value_name = "NAME")]
    group: Option<String>,
}

impl Figures {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let figures = FigureList::read(&home()?.join("paper/figures.toml"))?;
        let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
        let made = figures.make_all(&self.results, self.group.as_deref(), &styles)?;
        for files in &made.files {
            print(&files.svg.display().to_string())?;
        }
        for (id, reason) in &made.missing {
            print(&format!("not drawn: {id}: {reason}"))?;
        }
        print(&format!("{} figures drawn, {} not", made.files.len(), made.missing.len()))
    }
}

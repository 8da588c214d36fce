//! `rimbench export`: results as others can cite and load them.

use super::print;
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::harness::{Citation, Experiment, export};
use std::path::PathBuf;

/// Arguments of `export`.
#[derive(Debug, Args)]
pub struct Export {
    /// Results folder of an experiment, all of whose runs are there
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Folder for the package, empty or not there yet
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Author of the data, `Family, Given` or the name of a group; may be given more than once
    #[arg(long = "author", value_name = "NAME")]
    authors: Vec<String>,
    /// Title; what the experiment asks, if not given
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Licence of the data, an SPDX identifier
    #[arg(long = "license", value_name = "ID", default_value = "CC-BY-4.0")]
    licence: String,
    /// Day of the release
    #[arg(long, value_name = "YYYY-MM-DD")]
    released: Option<String>,
}

impl Export {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let Export { folder, out, authors, title, licence, released } = self;
        let citation = Citation { title, authors, licence, released };
        let experiment = Experiment::read_from_results(&folder)?;
        let files = export(&experiment, catalogue, &folder, &out, &citation)?;
        print(&format!("{}: {files} files in {}", experiment.name(), out.display()))
    }
}

//! The figures of the report, from entries in `paper/figures.toml`: figure → experiment, files, columns, caption.
//!
//! To add one of a known kind: add an entry to the file. To add a kind: write a file with a function from its
//! description and the experiment's folder to a [`Drawing`], and a variant of [`FigureKind`].

mod manoeuvre_figure;
mod phase_figure;
mod sweep_figure;
mod trace_figure;

use super::drawing::Drawing;
use super::render;
use crate::error::{Error, Result};
use serde::Deserialize;
use std::path::Path;

/// The file that lists all figures.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureList {
    /// In the order of the report.
    #[serde(rename = "figure")]
    pub figures: Vec<FigureEntry>,
}

/// One figure: where its numbers come from and what it shows.
#[derive(Debug, Clone, Deserialize)]
pub struct FigureEntry {
    /// File name and anchor.
    pub id: String,
    /// Experiment whose results it reads, `group/name`.
    pub experiment: String,
    /// Files it reads, relative to the experiment's folder.
    pub source: String,
    /// What the reader sees.
    pub caption: String,
    /// What kind of figure it is, with its options.
    #[serde(flatten)]
    pub kind: FigureKind,
}

/// The kinds of figures.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum FigureKind {
    /// The wedge box at a row of instants.
    Manoeuvre(manoeuvre_figure::ManoeuvreFigure),
    /// Columns of traces over time.
    Traces(trace_figure::TraceFigure),
    /// A metric against the macro step.
    Sweep(sweep_figure::SweepFigure),
    /// Metrics of each scheme over the phase ensemble.
    Phases(phase_figure::PhaseFigure),
}

impl FigureList {
    /// Reads the list.
    ///
    /// # Errors
    /// [`Error::File`] with the line that is wrong.
    pub fn read(path: &Path) -> Result<Self> {
        let text =
            std::fs::read_to_string(path).map_err(|error| Error::file(path, format!("cannot be read: {error}")))?;
        toml::from_str(&text).map_err(|error| Error::file(path, format!("is no list of figures: {error}")))
    }
}

impl FigureEntry {
    /// Draws the figure from the results below `results` and writes it beside them.
    ///
    /// # Errors
    /// [`Error::File`] for results that are missing or do not hold what the figure shows.
    pub fn make(&self, results: &Path) -> Result<render::FigureFiles> {
        let folder = results.join(&self.experiment);
        let figures = folder.join("figures");
        std::fs::create_dir_all(&figures).map_err(|error| Error::file(&figures, format!("cannot be made: {error}")))?;
        render::write(&self.draw(&folder)?, &figures, &self.id)
    }

    fn draw(&self, folder: &Path) -> Result<Drawing> {
        match &self.kind {
            FigureKind::Manoeuvre(figure) => figure.draw(folder),
            FigureKind::Traces(figure) => figure.draw(folder),
            FigureKind::Sweep(figure) => figure.draw(folder),
            FigureKind::Phases(figure) => figure.draw(folder),
        }
    }
}

//! The figures of the report, from entries in `paper/figures.toml`: figure → experiment, files, columns, caption.
//!
//! To add one of a known kind: add an entry to the file. To add a kind: write a file with a function from its
//! description and the experiment's folder to a [`Drawing`], and a variant of [`FigureKind`].

mod cost;
mod latency_figure;
mod manoeuvre_figure;
mod parameter_figure;
mod phase_figure;
mod profile_figure;
mod stability_figure;
mod statistics;
mod sweep_figure;
mod trace_figure;
mod work_precision_figure;

use super::drawing::Drawing;
use super::render;
use super::style::Styles;
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums;
use serde::Deserialize;
use std::collections::BTreeSet;
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
    /// Fraction of phases that are stable: scheme × macro step.
    StabilityMap(stability_figure::StabilityFigure),
    /// An error metric against cost.
    WorkPrecision(work_precision_figure::WorkPrecisionFigure),
    /// A metric against a parameter of the case.
    ParameterSweep(parameter_figure::ParameterFigure),
    /// Share of the problems in which a scheme is within a factor of the best.
    PerformanceProfile(profile_figure::ProfileFigure),
    /// Wall time of single macro steps.
    Latency(latency_figure::LatencyFigure),
}

/// What came of drawing all figures.
#[derive(Debug, Clone, Default)]
pub struct MadeFigures {
    /// Files written.
    pub files: Vec<render::FigureFiles>,
    /// Figures that cannot be drawn from the results there are: id and reason.
    pub missing: Vec<(String, String)>,
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

    /// The figures of one group of experiments, or of all.
    pub fn of_group(&self, group: Option<&str>) -> Vec<&FigureEntry> {
        self.figures.iter().filter(|figure| group.is_none_or(|group| figure.group() == group)).collect()
    }

    /// Draws the figures of one group of experiments, or of all, whose results are there; names the others.
    ///
    /// Results that lack a file or a column (older than the figure, say) count as missing, with the reason.
    ///
    /// # Errors
    /// [`Error::File`] if there is no such folder of results; [`Error::UnknownName`] for a group without figures.
    pub fn make_all(&self, results: &Path, group: Option<&str>, styles: &Styles) -> Result<MadeFigures> {
        if !results.is_dir() {
            return Err(Error::file(results, "is no folder of results"));
        }
        if let Some(group) = group.filter(|group| self.of_group(Some(group)).is_empty()) {
            let groups: BTreeSet<&str> = self.figures.iter().map(FigureEntry::group).collect();
            return Err(Error::unknown("group of figures", group, groups));
        }
        let mut made = MadeFigures::default();
        for figure in self.of_group(group) {
            let folder = results.join(&figure.experiment);
            if !folder.join("runs.csv").is_file() {
                let reason = format!("no results in {}: run experiments/{}.toml", folder.display(), figure.experiment);
                made.missing.push((figure.id.clone(), reason));
                continue;
            }
            match figure.make(results, styles) {
                Ok(files) => made.files.push(files),
                Err(error) => made.missing.push((figure.id.clone(), error.to_string())),
            }
        }
        Ok(made)
    }
}

impl FigureEntry {
    /// The group of its experiment.
    pub fn group(&self) -> &str {
        self.experiment.split('/').next().unwrap_or_default()
    }

    /// Draws the figure from the results below `results` and writes it beside them.
    ///
    /// # Errors
    /// [`Error::File`] for results that are missing or do not hold what the figure shows.
    pub fn make(&self, results: &Path, styles: &Styles) -> Result<render::FigureFiles> {
        let folder = results.join(&self.experiment);
        // Half a file, or one that was edited, is no source of a figure.
        checksums::verify(&folder)?;
        let figures = folder.join("figures");
        std::fs::create_dir_all(&figures).map_err(|error| Error::file(&figures, format!("cannot be made: {error}")))?;
        render::write(&self.draw(&folder, styles)?, &figures, &self.id)
    }

    fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        match &self.kind {
            FigureKind::Manoeuvre(figure) => figure.draw(folder, styles),
            FigureKind::Traces(figure) => figure.draw(folder, styles),
            FigureKind::Sweep(figure) => figure.draw(folder, styles),
            FigureKind::Phases(figure) => figure.draw(folder, styles),
            FigureKind::StabilityMap(figure) => figure.draw(folder, styles),
            FigureKind::WorkPrecision(figure) => figure.draw(folder, styles),
            FigureKind::ParameterSweep(figure) => figure.draw(folder, styles),
            FigureKind::PerformanceProfile(figure) => figure.draw(folder, styles),
            FigureKind::Latency(figure) => figure.draw(folder, styles),
        }
    }
}

//! `rimbench report`: the page of a results folder.

use super::print;
use super::project::Project;
use clap::Args;
use rayon::prelude::*;
use rimbench::BUILD;
use rimbench::atomic_file::check_writable_folder;
use rimbench::catalogue::Catalogue;
use rimbench::error::Result;
use rimbench::figures::FigureList;
use rimbench::figures::report::{Claim, Report, Study, Verdict, Written, find_studies};
use rimbench::figures::style::Styles;
use rimbench::harness::{CheckedClaim, Claimant, Experiment, Verdict as Checked, check_claims};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportCommand {
    /// A study, a group of studies, or all results; the page is written into it, as report.html
    #[arg(value_name = "DIR", default_value = "results")]
    folder: PathBuf,
    /// Show the page in the browser
    #[arg(long)]
    open: bool,
}

impl ReportCommand {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let (path, written) = write_page(catalogue, &self.folder)?;
        for left_out in &written.left_out {
            eprintln!("note: left out: {left_out}");
        }
        print(&format!("{} ({:.2} MB)", path.display(), written.bytes as f64 / 1e6))?;
        if self.open {
            show(&path);
        }
        Ok(())
    }
}

/// Writes the page of a folder of results into it.
///
/// # Errors
/// A folder that is not there, holds no results or cannot be written.
pub(super) fn write_page(catalogue: &Catalogue, folder: &Path) -> Result<(PathBuf, Written)> {
    let project = Project::find();
    let (figures, (source, text)) = (project.figures()?, project.report()?);
    let folders = find_studies(folder)?;
    check_writable_folder(folder)?;
    let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
    let studies: Vec<Study> = folders.par_iter().map(|folder| study(folder, catalogue, &figures, &styles)).collect();
    let is_paper = studies.iter().any(|study| study.name.starts_with("paper/"));
    let report = Report {
        folder,
        studies,
        text: is_paper.then_some((source, &text)),
        program: format!("rimbench {} of commit {}", BUILD.version, BUILD.git_revision),
        remarks: Vec::new(),
    };
    let path = folder.join("report.html");
    let written = report.write(&path)?;
    Ok((path, written))
}

/// A study with all that is known of it; what is wrong with a part of it is said there, and leaves the other parts.
fn study(folder: &Path, catalogue: &Catalogue, figures: &FigureList, styles: &Styles) -> Study {
    let mut study = Study::read(folder);
    match Experiment::read_from_results(folder) {
        Ok(experiment) => {
            let count = study.runs.as_ref().map_or(0, |runs| runs.len());
            let planned = |quick| experiment.plan(catalogue, quick).map(|plan| plan.len());
            match planned(false) {
                Ok(all) => study.planned = Some(planned(true).ok().filter(|quick| *quick == count).unwrap_or(all)),
                Err(error) => study.remarks.push(format!("its plan cannot be made: {error}")),
            }
            if !experiment.claims().is_empty() {
                match check_claims(&experiment, catalogue, folder) {
                    Ok(claims) => study.claims = claims.into_iter().map(claim).collect(),
                    Err(error) => study.remarks.push(format!("its claims are not checked: {error}")),
                }
            }
        }
        Err(error) => study.remarks.push(format!("its claims and its plan are not known: {error}")),
    }
    if folder.join("records").is_dir() {
        let command = format!("`rimbench run experiments/{}.toml`", study.name);
        study
            .remarks
            .push(format!("runs of it are recorded and not in its files yet: {command} goes on where it was left"));
    }
    // A figure names its experiment as <group>/<name> below a folder of results.
    let place = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    if let (Some(results), true) = (place.ancestors().nth(2), study.runs.is_some()) {
        let own = figures.figures.iter().filter(|figure| figure.experiment == study.name);
        let made = own.map(|figure| {
            let drawn = figure.drawn(results, styles).map_err(|error| error.to_string());
            (figure.id.clone(), figure.caption.clone(), drawn)
        });
        study.figures = made.collect();
    }
    study
}

fn claim(claim: CheckedClaim) -> Claim {
    let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
    Claim {
        of_paper: claim.by == Claimant::Paper,
        measured: number(claim.measured),
        interval: [number(claim.low), number(claim.high)],
        without_exact: number(claim.without_exact),
        verdict: match claim.verdict {
            Checked::Reproduced => Verdict::Reproduced,
            Checked::NotReproduced => Verdict::NotReproduced,
            Checked::NotMeasured => Verdict::NotMeasured,
        },
        run_ids: claim.run_ids.split_whitespace().map(str::to_owned).collect(),
        id: claim.id,
        text: claim.text,
        quantity: claim.quantity,
        expected: claim.expected,
        superseded: claim.superseded,
    }
}

/// Hands the page to what shows pages here; the page is there whether or not that works.
fn show(path: &Path) {
    let (program, arguments): (&str, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("cmd", &["/C", "start", ""]),
        _ => ("xdg-open", &[]),
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(path).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if let Err(error) = command.spawn() {
        eprintln!("note: {program} cannot show the page ({error}): open it in a browser");
    }
}

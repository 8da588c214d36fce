//! `rimbench report`: the page of a results folder; figures and PDF.

use super::figures::draw_figures;
use super::paper::set_pdf;
use super::project::Project;
use super::{print, program};
use clap::Args;
use rayon::prelude::*;
use rimbench::BUILD;
use rimbench::atomic_file::check_writable_folder;
use rimbench::catalogue::Catalogue;
use rimbench::checksums::CHECKSUMS;
use rimbench::error::Result;
use rimbench::figures::render::{FORMATS, write_png};
use rimbench::figures::report::{Picture, Report, Study, Written, address, find_studies};
use rimbench::figures::style::Styles;
use rimbench::figures::{FigureEntry, FigureList, preview};
use rimbench::harness::{Experiment, check_claims, check_kept_claims};
use rimbench::kept::DIGEST;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportCommand {
    /// A study, a group of studies, or all results; the page is written into it, as report.html
    #[arg(value_name = "DIR", default_value = "results")]
    folder: PathBuf,
    /// Show the page in the browser
    #[arg(long, conflicts_with = "part")]
    open: bool,
    /// No page: draw the figures of all experiments whose rows are there
    #[arg(long, group = "part")]
    figures: bool,
    /// No page: set the technical report, every number of it from stored results
    #[arg(long, group = "part", conflicts_with = "folder")]
    pdf: bool,
    /// File of the PDF [default: results/paper/paper.pdf]
    #[arg(long, value_name = "PATH", requires = "pdf", conflicts_with_all = ["folder", "open", "figures"])]
    out: Option<PathBuf>,
    /// Only the figures of this group of experiments
    #[arg(long, value_name = "NAME", requires = "figures", conflicts_with_all = ["open", "pdf"])]
    group: Option<String>,
    /// What figures are written as; pdf in a build with `--features pdf`
    #[arg(long, value_parser = FORMATS, default_value = "svg", requires = "figures", conflicts_with_all = ["open", "pdf"])]
    format: String,
    /// List of figures (see `rimbench list figure-keys`) [default: that of the project's folder, or the one built in]
    #[arg(long, value_name = "FILE", requires = "figures", conflicts_with_all = ["open", "pdf"])]
    file: Option<PathBuf>,
}

impl ReportCommand {
    /// Exit code 1 if a figure could not be drawn.
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        if self.figures {
            return draw_figures(catalogue, &self.folder, self.file.as_deref(), (self.group.as_deref(), &self.format));
        }
        if self.pdf {
            set_pdf(&self.out.unwrap_or_else(|| PathBuf::from("results/paper/paper.pdf")))?;
            return Ok(ExitCode::SUCCESS);
        }
        let (path, written, not_shown) = write_page(catalogue, &self.folder)?;
        for left_out in &written.left_out {
            eprintln!("note: left out: {left_out}");
        }
        for remark in &not_shown {
            eprintln!("note: {remark}");
        }
        print(&format!("{} ({:.2} MB)", path.display(), written.bytes as f64 / 1e6))?;
        if self.open {
            show(&path);
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Writes the page of a folder of results into it; returns where, how large it is, and what it does not show, in
/// sentences.
///
/// # Errors
/// A folder that is not there, holds no results or cannot be written.
pub(super) fn write_page(catalogue: &Catalogue, folder: &Path) -> Result<(PathBuf, Written, Vec<String>)> {
    let project = Project::find();
    let (figures, (source, text)) = (project.figures()?, project.report()?);
    let folders = find_studies(folder)?;
    check_writable_folder(folder)?;
    let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
    let studies: Vec<Study> =
        folders.par_iter().map(|folder| study(folder, catalogue, project, &figures, &styles)).collect();
    let is_paper = studies.iter().any(|study| study.name.starts_with("paper/") && study.is_shipped);
    let of_study =
        |study: &Study| study.missing().into_iter().map(|said| format!("{}: {said}", study.name)).collect::<Vec<_>>();
    let not_shown = studies.iter().flat_map(of_study).collect();
    let report = Report {
        folder,
        studies,
        text: is_paper.then_some((source, &text)),
        listed: figures.figures.iter().map(|figure| (figure.id.clone(), figure.experiment.clone())).collect(),
        program: format!("rimbench {} of commit {}", BUILD.version, BUILD.git_revision),
    };
    let manoeuvre = report.studies.iter().find(|study| study.name == "paper/fig1" && study.is_shipped);
    if let Some((study, case)) = manoeuvre.zip(catalogue.case("wedge-box").ok())
        && let Some(drawing) = (case.drawing)(&case.default_parameters())
        && let Ok(preview) = preview(&study.folder, &drawing, &styles)
    {
        write_png(&preview, &folder.join("preview.png"), 2.0)?;
    }
    let path = folder.join("report.html");
    let written = report.write(&path)?;
    Ok((path, written, not_shown))
}

/// A study with all that is known of it; what is wrong with a part of it is said there, and leaves the other parts.
fn study(folder: &Path, catalogue: &Catalogue, project: Project, figures: &FigureList, styles: &Styles) -> Study {
    let mut study = Study::read(folder);
    let own = std::fs::read_to_string(folder.join("experiment.toml")).ok();
    let shipped = project.experiment_text(&study.name);
    // Of a checkout medians, claims and figures are kept, and neither rows nor the experiment's copy.
    let has_kept = folder.join(DIGEST).exists() && !folder.join(CHECKSUMS).exists();
    let has_rows = folder.join("runs.csv").exists();
    study.is_shipped = match &own {
        Some(_) => own.as_deref() == shipped.as_deref(),
        None => has_kept && shipped.is_some(),
    };
    if let (Some(_), Some(_), false) = (&own, &shipped, study.is_shipped) {
        let remark =
            format!("its experiment is another than experiments/{}.toml: it has no figure of that", study.name);
        study.remarks.push(remark);
    }
    let experiment = match (&own, &shipped) {
        (None, Some(text)) if has_kept => {
            let path = format!("experiments/{}.toml", study.name);
            Experiment::parse(Path::new(&path), text.clone().into_owned())
        }
        _ => Experiment::read_from_results(folder),
    };
    match experiment {
        Ok(experiment) => {
            if study.question.is_empty() {
                experiment.question.clone_into(&mut study.question);
            }
            let count = study.runs.as_ref().map_or(0, |runs| runs.len());
            let planned = |quick| experiment.size(quick).ok();
            study.planned = planned(true).filter(|quick| *quick == count).or_else(|| planned(false));
            if !experiment.claims().is_empty() {
                let checked = match has_kept {
                    true => check_kept_claims(&experiment, catalogue, folder).map(|kept| kept.claims),
                    false => check_claims(&experiment, catalogue, folder),
                };
                match checked {
                    Ok(claims) => study.claims = claims,
                    Err(error) => {
                        let reason = study.said(&error);
                        study.remarks.push(format!("its claims are not checked: {reason}"));
                        study.unchecked = Some((Some(experiment.claims().len()), reason));
                    }
                }
            }
        }
        Err(error) => {
            let reason = study.said(&error);
            study.remarks.push(format!("its claims and its plan are not known: {reason}"));
            study.unchecked = Some((None, reason));
        }
    }
    // Records are left where all runs are in the files as well.
    let count = study.runs.as_ref().map_or(0, |runs| runs.len());
    if (has_rows || !has_kept) && folder.join("records").is_dir() && study.planned.is_none_or(|planned| count < planned)
    {
        let file = if study.is_shipped { format!("experiments/{}.toml", study.name) } else { "FILE".to_owned() };
        let remark = format!(
            "its files hold no whole plan, and runs are recorded: `{} run {file}` goes on from those",
            program()
        );
        study.remarks.push(remark);
    }
    // A figure names its experiment as <group>/<name> below a folder of results.
    let place = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    if let (Some(results), true) = (place.ancestors().nth(2), study.runs.is_some() || has_kept) {
        // Those of the list show what the shipped experiment is about; any other has those that all have.
        let none = FigureList { figures: Vec::new() };
        let list = if study.is_shipped { figures } else { &none };
        let listed = match has_kept {
            true => {
                Ok(list.of_part(None).into_iter().filter(|figure| figure.experiment == study.name).cloned().collect())
            }
            false => list.of_experiment(&study.name, folder),
        };
        match listed {
            Ok(own) => {
                let own: Vec<FigureEntry> = own;
                let made = own.iter().map(|figure| {
                    let drawn = match has_kept {
                        true => Picture::kept(&folder.join("figures").join(format!("{}.svg", figure.id))),
                        false => figure.drawn(results, styles).map(|drawing| Picture::Drawn(Box::new(drawing))),
                    };
                    let drawn = drawn.map_err(|error| study.said(&error));
                    let said = figure.said(results).map(|said| said.caption);
                    (figure.id.clone(), said.unwrap_or_else(|error| study.said(&error)), drawn)
                });
                study.figures = made.collect();
                study.addresses = own
                    .iter()
                    .filter_map(|figure| Some((figure, study.runs.as_ref()?)))
                    .filter_map(|(figure, runs)| Some((figure.id.clone(), address(catalogue, runs, figure.labels())?)))
                    .collect();
            }
            Err(error) => study.remarks.push(format!("its figures are not drawn: {}", study.said(&error))),
        }
    }
    study
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

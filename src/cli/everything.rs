//! `rimbench reproduce --everything`: all results that the project keeps something of, made anew and held against what
//! it kept.

use super::interruption::Interruption;
use super::progress::Progress;
use super::project::Project;
use super::report::write_page;
use super::{INTERRUPTED, print, warn_of_cache};
use rayon::prelude::*;
use rimbench::BUILD;
use rimbench::atomic_file::{check_writable_folder, write_atomically};
use rimbench::catalogue::Catalogue;
use rimbench::checksums::{sha256, sha256_of_file};
use rimbench::error::{Error, Result};
use rimbench::figures::report::DATE_LINE;
use rimbench::figures::style::Styles;
use rimbench::figures::{FigureEntry, claims_markdown, fill_page, has_markers};
use rimbench::harness::{Cache, CheckedClaim, Experiment, Job, check_fresh_claims, run_job_until, write_claims};
use rimbench::input::read_text;
use rimbench::kept::{DIGEST, SUMMARY};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// The group whose claims and page stand together.
const PAPER: &str = "paper";

/// Makes all experiments, or those named `only` as `<group>/<name>`, resuming what is stored, and what is made of them;
/// exit code 1 if something kept comes out otherwise.
pub(super) fn everything(catalogue: &Catalogue, out: &Path, only: &[String]) -> anyhow::Result<ExitCode> {
    let started = Instant::now();
    let project = Project::find();
    if project != Project::Here {
        let message = "not here: all that is kept is computed again in the folder of the project";
        return Err(Error::file("experiments", message).into());
    }
    let groups = ["paper", "published", "study"].map(|group| project.experiments(group));
    let experiments: Vec<Experiment> = groups.into_iter().collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    let experiments = chosen(experiments, only)?;
    // What asks for tools that the two main commands do without is left as it is kept where they are not.
    let mut left = Vec::new();
    let mut ready = Vec::new();
    for experiment in experiments {
        match experiment.needs.lacking() {
            Some(what) if !only.is_empty() => return Err(Error::file(experiment.path(), what).into()),
            Some(what) => left.push(format!("skipped: {}: {what}", experiment.full_name())),
            None => ready.push(experiment),
        }
    }
    let experiments = ready;
    left.iter().try_for_each(|line| print(line))?;
    let (figures, tables) = (project.figures()?, project.tables()?);
    check_writable_folder(out)?;
    let mut total = 0;
    for experiment in &experiments {
        total += experiment.plan_at_first_draw(catalogue, false)?.len();
    }
    // Files that rest on all experiments stay as they are if only some are run.
    let whole = only.is_empty();
    // Pages quote kept results, also those of other commands.
    let pages = if whole && out == Path::new("results") { pages()? } else { Vec::new() };
    let names: Vec<String> = experiments.iter().map(Experiment::full_name).collect();
    let figures: Vec<&FigureEntry> =
        figures.figures.iter().filter(|figure| names.contains(&figure.experiment)).collect();
    let kept = Kept::look(out, &experiments, &figures, &pages, (whole, whole));

    let interruption = Interruption::listen(true);
    let progress = Progress::begin("reproduce", Some(total));
    let cache = Cache::of_user();
    let mut of_paper: Vec<CheckedClaim> = Vec::new();
    let (mut computed, mut changed) = (0, 0);
    for experiment in &experiments {
        progress.about(experiment.full_name());
        let folder = experiment.results_folder(out);
        let job = Job::new(experiment, catalogue, &folder, &cache, &BUILD);
        let summary = match run_job_until(job, &|step| progress.after(step), interruption.flags()) {
            Ok(summary) if summary.missing == 0 => summary,
            Ok(_) | Err(Error::Stopped) => {
                progress.end();
                print("Stopped. What is stored is kept; the same command goes on from there.")?;
                return Ok(ExitCode::from(INTERRUPTED));
            }
            Err(error) => return Err(error.into()),
        };
        computed += summary.computed;
        progress.group_done(&format!(
            "{}: {} runs computed, {} were there",
            experiment.full_name(),
            summary.computed,
            summary.reused
        ));
        let claims = check_fresh_claims(experiment, catalogue, &folder)?;
        changed += claims.iter().filter(|claim| claim.differs()).count();
        if experiment.group() == PAPER {
            of_paper.extend(claims);
        } else if !claims.is_empty() {
            write_claims(&folder.join("claims.csv"), &claims)?;
        }
    }
    if whole {
        write_both(&out.join(PAPER), &of_paper)?;
    }
    progress.about("drawing figures");
    let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
    figures.par_iter().try_for_each(|figure| figure.make(out, &styles).map(drop))?;
    if whole {
        changed += project.ranking()?.write(catalogue, out, &out.join("ranking"))?.differing.len();
        write_page(catalogue, &out.join(PAPER))?;
    }
    for page in &pages {
        let text = read_text(page)?;
        let filled = fill_page(page, &text, out, &tables)?;
        if filled != text {
            write_atomically(page, |file| file.write_all(filled.as_bytes()))?;
        }
    }
    progress.end();
    warn_of_cache(&cache);

    let remade = kept.remade();
    remade.differing.iter().try_for_each(|sentence| print(sentence))?;
    print(&format!(
        "{} experiments, {total} runs ({computed} of them computed now), {} figures, {} pages in {:.0} s: {} of {} files differ from what was \
         kept, {changed} claims from the recorded finding",
        experiments.len(),
        figures.len(),
        pages.len(),
        started.elapsed().as_secs_f64(),
        remade.differing.len(),
        remade.files,
    ))?;
    Ok(if remade.differing.is_empty() && changed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Those of the experiments that are asked for.
fn chosen(experiments: Vec<Experiment>, only: &[String]) -> Result<Vec<Experiment>> {
    let names: Vec<String> = experiments.iter().map(Experiment::full_name).collect();
    if let Some(unknown) = only.iter().find(|wanted| !names.contains(wanted)) {
        return Err(Error::unknown("experiment", unknown, names.iter().map(String::as_str)));
    }
    Ok(experiments.into_iter().filter(|own| only.is_empty() || only.contains(&own.full_name())).collect())
}

/// What is kept of results, with the checksums that it has by now.
pub(super) struct Kept {
    before: BTreeMap<PathBuf, Option<String>>,
}

/// What has become of what was kept.
pub(super) struct Remade {
    /// How many files were looked at.
    pub(super) files: usize,
    /// Those that are not as they were, each in a sentence.
    pub(super) differing: Vec<String>,
}

impl Kept {
    /// Looks at what is kept below a folder of results: of each experiment digest, medians, claims, figures, and rows
    /// where they are; of a `whole` group its claims and its page; the ranking with `everything`; pages with numbers
    /// in them.
    pub(super) fn look(
        out: &Path,
        experiments: &[Experiment],
        figures: &[&FigureEntry],
        others: &[PathBuf],
        (whole, everything): (bool, bool),
    ) -> Self {
        let mut files = Vec::new();
        for experiment in experiments {
            let folder = experiment.results_folder(out);
            files.extend([DIGEST, SUMMARY].map(|name| folder.join(name)));
            if experiment.group() == PAPER {
                // Of the two figures of the paper rows are kept as well.
                files.extend(
                    ["runs.csv", "experiment.toml"]
                        .map(|name| folder.join(name))
                        .into_iter()
                        .filter(|file| file.exists()),
                );
            } else if !experiment.claims().is_empty() {
                files.push(folder.join("claims.csv"));
            }
            let own = figures.iter().filter(|figure| figure.experiment == experiment.full_name());
            files.extend(own.map(|figure| folder.join(format!("figures/{}.svg", figure.id))));
        }
        if whole {
            let paper = out.join(PAPER);
            files.extend(["claims.csv", "claims.md", "report.html", "preview.png"].map(|name| paper.join(name)));
        }
        if everything {
            files.extend(["ranking/ranking.csv", "ranking/claims.csv"].map(|name| out.join(name)));
        }
        files.extend(others.iter().cloned());
        Kept { before: files.into_par_iter().map(|file| (file.clone(), sum(&file))).collect() }
    }

    /// Leaves out files that are not there.
    pub(super) fn there(mut self) -> Self {
        self.before.retain(|_, sum| sum.is_some());
        self
    }

    /// Looks again.
    pub(super) fn remade(self) -> Remade {
        let after: Vec<Option<String>> = self.before.par_iter().map(|(file, _)| sum(file)).collect();
        let differing = self.before.iter().zip(&after).filter_map(|((file, before), after)| {
            let what = match (before, after) {
                (None, Some(_)) => "was not kept",
                (Some(_), None) => "is no longer made",
                (before, after) if before != after => "comes out otherwise than was kept",
                _ => return None,
            };
            Some(format!("{}: {what}", file.display()))
        });
        Remade { files: self.before.len(), differing: differing.collect() }
    }
}

/// The SHA-256 of a file, of a page without the line that says of which day, commit and machine it is.
fn sum(file: &Path) -> Option<String> {
    if file.extension().is_none_or(|extension| extension != "html") {
        return sha256_of_file(file);
    }
    let text = std::fs::read_to_string(file).ok()?;
    Some(sha256(text.split_inclusive('\n').filter(|line| !line.contains(DATE_LINE)).collect::<String>()))
}

/// Pages of the project that have markers: README and all below `docs`.
pub(super) fn pages() -> Result<Vec<PathBuf>> {
    let (mut pages, mut folders) = (vec![PathBuf::from("README.md")], vec![PathBuf::from("docs")]);
    while let Some(folder) = folders.pop() {
        let wrong = |error| Error::file(&folder, format!("cannot be read: {error}"));
        for entry in std::fs::read_dir(&folder).map_err(wrong)? {
            let path = entry.map_err(wrong)?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                pages.push(path);
            }
        }
    }
    pages.sort();
    let mut with_markers = Vec::new();
    for page in pages {
        if has_markers(&read_text(&page)?) {
            with_markers.push(page);
        }
    }
    Ok(with_markers)
}

/// Writes claims as CSV and as Markdown.
pub(super) fn write_both(folder: &Path, claims: &[CheckedClaim]) -> Result<()> {
    write_claims(&folder.join("claims.csv"), claims)?;
    let markdown = claims_markdown(claims);
    write_atomically(&folder.join("claims.md"), |file| file.write_all(markdown.as_bytes()))
}

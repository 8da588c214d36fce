//! `rimbench report --figures`: all figures again, from stored results; also of experiments that no list of figures
//! names.

use super::number::counted;
use super::print;
use super::project::Project;
use rimbench::catalogue::Catalogue;
use rimbench::figures::FigureList;
use rimbench::figures::report::find_studies;
use rimbench::figures::style::Styles;
use std::path::Path;
use std::process::ExitCode;

/// Draws the figures of all results, of a group or of a study in `folder`. Exit code 1 if a figure could not be drawn
/// although its experiment has results, as an older picture may be left of it, or if there are no results of what was
/// asked for by name.
pub(super) fn draw_figures(
    catalogue: &Catalogue,
    folder: &Path,
    file: Option<&Path>,
    (group, format): (Option<&str>, &str),
) -> anyhow::Result<ExitCode> {
    let studies = if folder.is_dir() { find_studies(folder)? } else { Vec::new() };
    let place = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    // How far below the folder its studies are says whether it is all results, a group or a study.
    let depth = studies.iter().filter_map(|study| Some(study.strip_prefix(folder).ok()?.components().count())).max();
    let results = place.ancestors().nth(2 - depth.unwrap_or(2).min(2)).unwrap_or(&place);
    let own = place.strip_prefix(results).unwrap_or(Path::new("")).to_string_lossy().into_owned();
    let part = if own.is_empty() { group } else { Some(&*own) };
    // Errors and files are named as the folder was.
    let results = if own.is_empty() { folder } else { results };
    // A list of one's own is all that is asked for; without one, every experiment has figures.
    let (figures, failed) = match file {
        Some(file) => (FigureList::read(file)?, Vec::new()),
        None => Project::find().figures()?.completed(results, part),
    };
    let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
    let mut made = figures.make_all(results, part, (&styles, format))?;
    made.failed.extend(failed);
    for file in &made.files {
        print(&file.display().to_string())?;
    }
    let by_name = file.is_some() || depth == Some(0);
    for (id, reason) in made.missing.iter().filter(|_| by_name) {
        print(&format!("not drawn: {id}: {reason}"))?;
    }
    for (id, reason) in &made.failed {
        eprintln!("error: {id} cannot be drawn: {reason}");
    }
    let mut said = format!("{} drawn", counted(made.files.len(), "figure"));
    if !made.failed.is_empty() {
        said += &format!(", {} could not be", made.failed.len());
    }
    if !made.missing.is_empty() {
        said +=
            &format!(", {} of experiments without rows here left as they are", counted(made.missing.len(), "figure"));
    }
    print(&said)?;
    let is_whole = made.failed.is_empty() && (made.missing.is_empty() || !by_name);
    Ok(if is_whole { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

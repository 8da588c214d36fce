//! `rimbench report --figures`: all figures again, from stored results; also of experiments that no list of figures names.

use super::print;
use super::project::Project;
use rimbench::catalogue::Catalogue;
use rimbench::figures::FigureList;
use rimbench::figures::style::Styles;
use std::path::Path;
use std::process::ExitCode;

/// Exit code 1 if a figure could not be drawn although its experiment has results: an older picture may be left of it.
pub(super) fn draw_figures(
    catalogue: &Catalogue,
    results: &Path,
    file: Option<&Path>,
    group: Option<&str>,
) -> anyhow::Result<ExitCode> {
    // A list of one's own is all that is asked for; without one, every experiment has figures.
    let (figures, failed) = match file {
        Some(file) => (FigureList::read(file)?, Vec::new()),
        None => Project::find().figures()?.completed(results, group),
    };
    let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
    let mut made = figures.make_all(results, group, &styles)?;
    made.failed.extend(failed);
    for file in &made.files {
        print(&file.display().to_string())?;
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

//! Draws a case for those who find a link to the page of the paper.

use super::trace_figure::trace;
use crate::case_picture::{Motion, View};
use crate::clip::Rect;
use crate::drawing::{Anchor, Color, Drawing, Text};
use crate::style::Styles;
use rimbench_cases::cases::Drawing as CaseDrawing;
use rimbench_core::error::{Error, Result};
use rimbench_results::run_table::RunTable;
use rimbench_results::selection::Runs;
use rimbench_runs::Finding;
use rimbench_runs::metrics::STAYS_DOWN_M;
use std::path::Path;

/// By how much the preview enlarges what a run does otherwise than the reference.
const ENLARGED: f64 = 12.0;
/// The instant of the preview, s: the box with the smooth model is in the air.
const INSTANT: f64 = 1.75;

/// Draws what a link to the page of the paper shows, 600 × 315 px: both models of the source paper after touch-down.
///
/// # Errors
/// [`Error::File`] for traces that are not there.
pub fn preview(folder: &Path, of: &CaseDrawing, styles: &Styles) -> Result<Drawing> {
    let table = RunTable::read_from(folder)?;
    let runs = Runs::of(&table);
    let reference = trace(folder, &runs, "reference")?;
    let mut drawing = Drawing::new(600.0, 315.0);
    let question = "How long may the macro step be?";
    drawing.title = question.to_owned();
    drawing.text(Text::new(question, (20.0, 44.0), 27.0).bold());
    let words = "Co-simulation of a machine with contacts: the same macro step, two interface models";
    drawing.text(Text::new(words, (20.0, 70.0), 14.0).colored(Color::SOFT_INK));
    for (label, left) in [("rim-smooth", 10.0), ("rim-nonsmooth", 305.0)] {
        let said = verdict(&runs, label)?;
        let (motion, color) =
            (Motion::read(of, &trace(folder, &runs, label)?, &reference, ENLARGED)?, styles.of_label(label).color);
        let row = motion.row_at(INSTANT).ok_or_else(|| Error::file(folder, format!("has no row at {INSTANT} s")))?;
        let place = Rect { left, top: 88.0, right: left + 285.0, bottom: 252.0 };
        View { place, follow: motion.follow[row] }.draw(&mut drawing, of, &motion.row(row), Some(color));
        let middle = (left + 142.5, 276.0);
        let name = Text::new(format!("{}: {said}", styles.shown_name(label)), middle, 15.0).bold();
        drawing.text(name.anchored(Anchor::Middle).colored(color));
    }
    let words = format!("rimbench · H = 5 ms, differences from the reference {ENLARGED} times larger");
    drawing.text(Text::new(words, (300.0, 303.0), 11.0).anchored(Anchor::Middle).colored(Color::SOFT_INK));
    Ok(drawing)
}

/// Says by how far a contact opens that is closed in the reference; nothing where the run has no such height.
fn verdict(runs: &Runs<'_>, label: &str) -> Result<String> {
    let height = Finding::named("lift_off_height_m")?;
    runs.table().check(height)?;
    let opened_m = runs.of_label(label).rows().first().map_or(f64::NAN, |&row| runs.value(row, height));
    Ok(match opened_m {
        _ if !opened_m.is_finite() => String::new(),
        _ if opened_m <= STAYS_DOWN_M => "stays down".to_owned(),
        _ if opened_m < 1e-3 => format!("lifts off {:.2} mm", 1e3 * opened_m),
        _ => format!("lifts off {:.0} mm", 1e3 * opened_m),
    })
}

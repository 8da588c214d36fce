//! `rimbench judge`: a trajectory from anywhere, scored by a problem pack; an entry, scored by all of its packs; two
//! results side by side.

use super::number::{percent, quantity};
use super::screen::{Mood, Table, headline, row};
use super::simulate::error_row;
use super::{Format, print, print_json};
use clap::Args;
use rimbench::atomic_file::write_atomically;
use rimbench::error::{Error, Result};
use rimbench::harness::{ENTRY, Entry, Judged, Packs, Problem, judge};
use rimbench::kept::{SUMMARY, SummaryRow, read_rows};
use rimbench::results_table::read_table;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `judge`.
#[derive(Debug, Args)]
pub struct Judge {
    /// A trajectory (CSV, perhaps compressed); or the folder of an entry; or two folders of results or entries, which
    /// are held side by side
    #[arg(value_name = "FILE", required = true, num_args = 1..=2)]
    what: Vec<PathBuf>,
    /// The pack of a trajectory's problem (see `rimbench pack`)
    #[arg(long, value_name = "FOLDER")]
    problem: Option<PathBuf>,
    /// Folder with the packs of an entry's problems
    #[arg(long, value_name = "FOLDER", conflicts_with = "problem")]
    problems: Option<PathBuf>,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

impl Judge {
    pub(super) fn run(self) -> anyhow::Result<ExitCode> {
        match (&self.what[..], &self.problem, &self.problems) {
            ([file], Some(folder), None) => of_file(file, folder, self.format)?,
            ([entry], None, Some(packs)) => of_entry(entry, packs)?,
            ([before, after], None, None) => side_by_side(before, after, self.format)?,
            _ => {
                let valid = "FILE --problem PACK, ENTRY --problems FOLDER, or two folders";
                return Err(Error::invalid("judge", format!("{} places", self.what.len()), valid).into());
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Scores the runs of an entry and writes its summary.
fn of_entry(folder: &Path, packs: &Path) -> anyhow::Result<()> {
    let entry = Entry::read(folder)?;
    let (rows, text) = entry.judge(folder, &Packs::read(packs)?)?;
    let path = folder.join(SUMMARY);
    write_atomically(&path, |file| file.write_all(&text))?;
    let mut table = Table::new(&["problem", "H", "completed", "force error"]);
    for row in &rows {
        let [case, set, _, step, _] = &row.keys;
        let share = row.quartiles[1][1];
        let share = if share.is_nan() { "–".to_owned() } else { percent(share) };
        let step = quantity(step.parse().unwrap_or(f64::NAN), "s");
        let completed = format!("{}/{}", row.completed, row.runs);
        table.add_row([format!("{case} {set}").trim_end().to_owned(), step, completed, share]);
    }
    print(&table.to_string())?;
    print(&format!("{}: medians of completed runs over phases, as a share of the peak", path.display()))
}

fn of_file(file: &Path, folder: &Path, format: Format) -> anyhow::Result<()> {
    let problem = Problem::read(folder)?;
    let judged = judge(file, &problem, None)?;
    match format {
        Format::Json => print_json(&judged.to_json(&problem.0)),
        Format::Table => print(&first_screen(&judged, &problem.0)),
    }
}

/// The verdict and the numbers that matter most, as `simulate` has them.
fn first_screen(judged: &Judged, problem: &Problem) -> String {
    let about = format!("{} · H = {} · φ = {:.4}", problem.name(), quantity(judged.macro_step_s, "s"), judged.phase);
    let (verdict, mood) = match judged.diverged_at_s {
        Some(at_s) => (format!("diverged at {}", quantity(at_s, "s")), Mood::Bad),
        None if judged.outcome == "completed" => ("completed".to_owned(), Mood::Good),
        None => (format!("ended early, at {}", quantity(judged.ended_at_s, "s")), Mood::Bad),
    };
    let mut lines = vec![headline(&about, &verdict, mood)];
    let uncertain = |of: usize| problem.rows.iter().map(|row| row.uncertainty[of]).reduce(f64::max);
    if let Some(force) = judged.score("force_error_rms_n") {
        let share = judged.score("force_error_rms_of_peak");
        let share = share.map(|share| format!(", {} of the peak", percent(share))).unwrap_or_default();
        lines.push(error_row("force error", (force, "N"), &share, uncertain(2)));
    }
    if let Some(position) = judged.score("position_error_rms_m") {
        lines.push(error_row("position error", (position, "m"), "", uncertain(0)));
    }
    if let Some(peak) = judged.score("touch_down_peak_ratio").filter(|peak| peak.is_finite()) {
        lines.push(row("touch-down", &format!("peak {} of the reference's", percent(peak))));
    }
    if let Some(residual) = judged.interface_residual_j {
        let label = if residual < 0.0 { "energy created" } else { "energy lost" };
        lines.push(row(label, &format!("{} at the interface", quantity(residual.abs(), "J"))));
    }
    lines.join("\n")
}

/// Rows of the summaries of two folders by what they are of, in which more changed than the last of six digits, with
/// the reference's uncertainty where rows of runs say it.
fn side_by_side(before: &Path, after: &Path, format: Format) -> anyhow::Result<()> {
    let folders = [before, after];
    let [old, new] = folders.map(|folder| -> Result<_> {
        let rows = read_rows(&folder.join(SUMMARY))?;
        Ok((rows, folder.join(ENTRY).is_file(), uncertainties(folder)?))
    });
    let ((old, old_entry, known), (new, new_entry, _)) = (old?, new?);
    // Entries have names of their own; what they are of is the problem.
    let of_entries = old_entry || new_entry;
    let same = |a: &SummaryRow, b: &SummaryRow| {
        (0..a.keys.len()).all(|key| a.keys[key] == b.keys[key] || (key == 2 && of_entries))
    };
    let mut pairs = Vec::new();
    for a in &old {
        pairs.extend(new.iter().filter(|b| same(a, b)).map(|b| (a, b)));
    }
    let alone = old.iter().filter(|a| !new.iter().any(|b| same(a, b))).count()
        + new.iter().filter(|b| !old.iter().any(|a| same(a, b))).count();
    let mut table = Table::new(&["problem", "row", "H", "completed", "force error", "moved"]);
    let mut moved = Vec::new();
    for (a, b) in &pairs {
        let [error, other] = [a, b].map(|row| row.quartiles[0][1]);
        let allowed =
            known.get(&a.keys[..2].join(" ")).copied().unwrap_or(0.0).max(1e-5 * error.abs().max(other.abs()));
        let apart = (error - other).abs() > allowed || error.is_nan() != other.is_nan();
        if apart || (a.completed, a.failed, a.no_answer) != (b.completed, b.failed, b.no_answer) {
            moved.push((a, b, error, other));
        }
    }
    for (a, b, error, other) in &moved {
        let step = quantity(a.keys[3].parse().unwrap_or(f64::NAN), "s");
        let label = if a.keys[2] == b.keys[2] { a.keys[2].clone() } else { format!("{} → {}", a.keys[2], b.keys[2]) };
        let of = |error: f64| if error.is_nan() { "–".to_owned() } else { quantity(error, "N") };
        table.add_row([
            a.keys[..2].join(" ").trim_end().to_owned(),
            label,
            step,
            format!("{}/{} → {}/{}", a.completed, a.runs, b.completed, b.runs),
            format!("{} → {}", of(*error), of(*other)),
            if error.is_nan() || other.is_nan() { "–".to_owned() } else { percent(other / error - 1.0) },
        ]);
    }
    if format == Format::Json {
        let rows = moved.iter().map(|(a, b, error, other)| {
            json!({
                "case": a.keys[0], "set": a.keys[1], "labels": [a.keys[2], b.keys[2]], "macro_step_s": a.keys[3],
                "completed": [a.completed, b.completed], "runs": [a.runs, b.runs], "force_error_rms_n": [error, other],
            })
        });
        return print_json(&json!({"compared": pairs.len(), "alone": alone, "moved": rows.collect::<Vec<_>>()}));
    }
    let about = format!("{} against {}", before.display(), after.display());
    let word = format!("{} of {} rows moved", moved.len(), pairs.len());
    print(&headline(&about, &word, if moved.is_empty() { Mood::Good } else { Mood::Open }))?;
    if !moved.is_empty() {
        print(&table.to_string())?;
    }
    if alone > 0 {
        print(&format!("{alone} rows are in one of the two only."))?;
    }
    Ok(())
}

/// The largest uncertainty of a reference's force, N, by case and set, where a folder has rows of runs.
fn uncertainties(folder: &Path) -> Result<BTreeMap<String, f64>> {
    let path = folder.join("runs.csv");
    if !path.is_file() {
        return Ok(BTreeMap::new());
    }
    let table = read_table(&path)?;
    let [case, set, uncertainty] = ["case", "set", "reference_force_uncertainty_n"].map(|name| table.column(name));
    let (case, set, uncertainty) = (case?, set?, uncertainty?);
    let mut found: BTreeMap<String, f64> = BTreeMap::new();
    for row in 0..table.len() {
        let key = format!("{} {}", table.text(row, case), table.text(row, set));
        let own = found.entry(key).or_default();
        *own = own.max(table.number(row, uncertainty));
    }
    Ok(found)
}

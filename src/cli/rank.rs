//! `rimbench report --ranking`: which scheme row has least error, of those that know as much.

use super::print;
use super::project::Project;
use super::screen::{Mood, Table, paragraph, verdict};
use rimbench::catalogue::Catalogue;
use rimbench::harness::{CheckedRankClaim, RankedRow, Verdict};
use std::path::Path;
use std::process::ExitCode;

/// Ranks what a file names, and writes ranking.csv and claims.csv to `out`, or to `ranking` below the results. Exit code 1 if a claim comes
/// out otherwise than was recorded.
pub(super) fn rank(catalogue: &Catalogue, file: &Path, results: &Path, out: Option<&Path>) -> anyhow::Result<ExitCode> {
    let ranked = Project::ranking(file)?.rank(catalogue, results, Project::experiment)?;
    let out = out.map_or_else(|| results.join("ranking"), Path::to_owned);
    ranked.write(&out)?;
    let of_group =
        |a: &RankedRow, b: &RankedRow| (&a.class, a.tuned_on.is_empty()) == (&b.class, b.tuned_on.is_empty());
    for group in ranked.rows.chunk_by(of_group) {
        let tuned = if group[0].tuned_on.is_empty() { "" } else { ", tuned" };
        print(&format!("{}{tuned}:\n{}\n", group[0].class, of_rows(group)))?;
    }
    for row in &ranked.unranked {
        print(&paragraph(&format!("not ranked: {}, {}", row.label, row.why), 2))?;
    }
    let differ = ranked.claims.iter().map(say).filter(|(_, differs)| *differs).count();
    ranked.claims.iter().try_for_each(|claim| print(&paragraph(&say(claim).0, 2)))?;
    let said = format!(
        "{} rows over {} problems of {} cases in {}; {} claims, {differ} differ from the recorded finding",
        ranked.rows.len(),
        ranked.problems,
        ranked.cases,
        out.display(),
        ranked.claims.len(),
    );
    print(&verdict(&said, if differ == 0 { Mood::Good } else { Mood::Bad }))?;
    Ok(if differ == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn of_rows(rows: &[RankedRow]) -> String {
    let mut table =
        Table::new(&["rank", "row", "error / peak", "95 % interval", "failed", "skipped", "exchanges per H"]);
    for row in rows {
        let rank =
            if row.rank == row.rank_last { row.rank.to_string() } else { format!("{}–{}", row.rank, row.rank_last) };
        let interval = row.score_low.zip(row.score_high);
        table.add_row([
            rank,
            row.label.clone(),
            percent(row.score),
            interval.map_or("–".to_owned(), |(low, high)| format!("{} to {}", percent(low), percent(high))),
            format!("{}/{}", row.failed, row.problems),
            format!("{}/{}", row.skipped, row.problems),
            row.exchanges_per_macro_step.map_or("–".to_owned(), |count| format!("{count:.1}")),
        ]);
    }
    table.to_string()
}

fn percent(share: f64) -> String {
    format!("{:.3} %", share * 100.0)
}

/// A claim in words, and whether it differs from what was recorded.
fn say(claim: &CheckedRankClaim) -> (String, bool) {
    let differs = claim.finding != Verdict::NotMeasured && claim.finding != claim.verdict;
    let measured = match (claim.measured, claim.low, claim.high) {
        (Some(ratio), Some(low), Some(high)) => format!("{ratio:.3} [{low:.3}, {high:.3}]"),
        _ => "–".to_owned(),
    };
    let changed = if differs { " (differs from the recorded finding)" } else { "" };
    let CheckedRankClaim { text, row, ahead_of, verdict, .. } = claim;
    (format!("claim: {text}: error of {row} over that of {ahead_of} {measured}: {verdict}{changed}"), differs)
}

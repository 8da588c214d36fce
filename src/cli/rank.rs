//! `rimbench rank`: which scheme row has least error, of those that know as much.

use super::{print, table};
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::harness::{Accepted, CheckedRankClaim, RankedRow, Ranking, Verdict};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `rank`.
#[derive(Debug, Args)]
pub struct Rank {
    /// Ranking file: which experiments, and what is claimed
    #[arg(value_name = "FILE", default_value = "experiments/ranking.toml")]
    file: PathBuf,
    /// Where results are: <DIR>/<group>/<name>
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Submissions that `check-submission` has accepted [default: <results>/submissions]
    #[arg(long, value_name = "DIR")]
    submissions: Option<PathBuf>,
    /// Folder for ranking.csv and claims.csv [default: <results>/ranking]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Rank {
    /// Ends with exit code 1 if a claim comes out otherwise than was recorded.
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        let ranking = Ranking::read(&self.file)?;
        let submissions = self.submissions.unwrap_or_else(|| self.results.join("submissions"));
        let submissions = Accepted::read_all(&submissions, catalogue)?;
        let ranked = ranking.rank(catalogue, &self.results, &submissions)?;
        let out = self.out.unwrap_or_else(|| self.results.join("ranking"));
        ranked.write(&out)?;
        let of_group =
            |a: &RankedRow, b: &RankedRow| (&a.class, a.tuned_on.is_empty()) == (&b.class, b.tuned_on.is_empty());
        for group in ranked.rows.chunk_by(of_group) {
            let tuned = if group[0].tuned_on.is_empty() { "" } else { ", tuned" };
            print(&format!("{}{tuned}:\n{}\n", group[0].class, of_rows(group)))?;
        }
        for row in &ranked.unranked {
            print(&format!("not ranked: {}{}, {}", row.label, by(&row.submission), row.why))?;
        }
        let differ = ranked.claims.iter().map(say).filter(|(_, differs)| *differs).count();
        ranked.claims.iter().try_for_each(|claim| print(&say(claim).0))?;
        print(&format!(
            "{} rows over {} problems of {} cases in {}; {} claims, {differ} differ from the recorded finding",
            ranked.rows.len(),
            ranked.problems,
            ranked.cases,
            out.display(),
            ranked.claims.len(),
        ))?;
        Ok(if differ == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}

fn of_rows(rows: &[RankedRow]) -> String {
    let mut table = table(&["rank", "row", "error / peak", "95 % interval", "failed", "skipped", "exchanges per H"]);
    for row in rows {
        let rank =
            if row.rank == row.rank_last { row.rank.to_string() } else { format!("{}–{}", row.rank, row.rank_last) };
        let interval = row.score_low.zip(row.score_high);
        table.add_row([
            rank,
            format!("{}{}", row.label, by(&row.submission)),
            percent(row.score),
            interval.map_or("–".to_owned(), |(low, high)| format!("{} to {}", percent(low), percent(high))),
            format!("{}/{}", row.failed, row.problems),
            format!("{}/{}", row.skipped, row.problems),
            row.exchanges_per_macro_step.map_or("–".to_owned(), |count| format!("{count:.1}")),
        ]);
    }
    table.to_string()
}

fn by(submission: &str) -> String {
    if submission.is_empty() { String::new() } else { format!(" (submission {submission})") }
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

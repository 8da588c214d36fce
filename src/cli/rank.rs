//! `rimbench rank`: rows of experiments and entries of others by their errors.

use super::progress::say;
use super::project::Project;
use super::screen::{Mood, Table, verdict};
use super::{Format, answered, print, print_json};
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::harness::{RULES, Ranking};
use rimbench::results_table::read_table;
use serde_json::{Map, Value};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `rank`.
#[derive(Debug, Args)]
pub struct Rank {
    /// Ranking (TOML): its experiments and entries [default: experiments/ranking.toml]
    #[arg(value_name = "RANKING")]
    ranking: Option<PathBuf>,
    /// Folder with results of the experiments
    #[arg(long, value_name = "FOLDER", default_value = "results")]
    results: PathBuf,
    /// Folder for ranking.csv, claims.csv and, with entries of the open division, open.csv
    #[arg(long, value_name = "FOLDER", default_value = "results/ranking")]
    out: PathBuf,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

impl Rank {
    /// Exit code 1 if a claim comes out otherwise than was recorded.
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        let ranking = match &self.ranking {
            Some(file) => Ranking::read(file)?,
            None => Project::find().ranking()?,
        };
        let found = ranking.write(catalogue, &self.results, &self.out)?;
        let ranked = read_table(&self.out.join("ranking.csv"))?;
        if self.format == Format::Json {
            let row = |row: usize| {
                let cell = |(column, name): (usize, &String)| {
                    let text = ranked.text(row, column);
                    let value = text.parse::<f64>().map_or_else(|_| Value::from(text), Value::from);
                    (name.clone(), if text.is_empty() { Value::Null } else { value })
                };
                Value::Object(ranked.names().iter().enumerate().map(cell).collect::<Map<_, _>>())
            };
            print_json(&(0..ranked.len()).map(row).collect::<Value>())?;
        } else {
            let header = ["class", "row", "by", "rank", "error, %", "failed", "under other rules"];
            let mut table = Table::new(&header);
            let text = |row: usize, name: &str| ranked.column(name).map_or("", |column| ranked.text(row, column));
            for row in 0..ranked.len() {
                let ranks = [text(row, "rank"), text(row, "rank_last")];
                let rank = if ranks[0] == ranks[1] { ranks[0].to_owned() } else { ranks.join("–") };
                let score: f64 = text(row, "score").parse().unwrap_or(f64::NAN);
                let others = RULES.map(|rule| if text(row, rule).is_empty() { "–" } else { text(row, rule) });
                let tuned = if text(row, "tuned_on").is_empty() { "" } else { " (tuned)" };
                table.add_row([
                    text(row, "class").to_owned() + tuned,
                    text(row, "label").to_owned(),
                    text(row, "by").to_owned(),
                    rank,
                    format!("{:.2}", 100.0 * score),
                    text(row, "failed").to_owned(),
                    others.join(" "),
                ]);
            }
            print(&table.to_string())?;
            print(&format!("Ranks under other rules, in this order: {}.", RULES.join(", ")))?;
        }
        found.notes.iter().for_each(|note| say(&format!("note: {note}")));
        for claim in &found.differing {
            print(&verdict(&format!("claim {claim} comes out otherwise than was recorded"), Mood::Bad))?;
        }
        Ok(answered(found.differing.is_empty()))
    }
}

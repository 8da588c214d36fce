//! `rimbench perf compare`: records of a history, or git revisions built side by side.

use super::perf_measuring::{HISTORY, Measuring};
use super::{print, print_json};
use anyhow::Context;
use clap::{Args, ValueEnum};
use rimbench::BUILD;
use rimbench::error::Error;
use rimbench::harness::Provenance;
use rimbench::perf::{
    Comparison, History, Paired, Program, Recording, Repository, Row, Verdict, compare_pairs, compare_records,
    measure_rounds, paired_ratio, placebo_ratio,
};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `perf compare`.
#[derive(Debug, Args)]
pub struct Compare {
    /// latest, previous, a record or git revision of the history, or another history: FILE (its latest) or FILE@RECORD
    #[arg(value_name = "BASE", required_unless_present = "rev", conflicts_with = "rev")]
    base: Option<String>,
    /// Likewise
    #[arg(value_name = "NEW", required_unless_present = "rev", conflicts_with = "rev")]
    new: Option<String>,
    /// A git revision to build and measure; given twice, first the base
    #[arg(long, value_name = "REV")]
    rev: Vec<String>,
    /// The history
    #[arg(long, value_name = "FILE", default_value = HISTORY)]
    history: PathBuf,
    /// Where to build the revisions [default: a temporary folder]
    #[arg(long, value_name = "DIR", requires = "rev")]
    target_dir: Option<PathBuf>,
    /// How to print
    #[arg(long, value_enum, default_value = "markdown")]
    format: Output,
    #[command(flatten)]
    measuring: Measuring,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Output {
    /// For reading, and for a comment on a change.
    Markdown,
    /// For programs.
    Json,
}

impl Compare {
    pub(super) fn run(self) -> anyhow::Result<ExitCode> {
        let format = self.format;
        let comparison = match (&self.base, &self.new) {
            (Some(base), Some(new)) => self.records(base, new)?,
            _ => self.revisions()?,
        };
        match format {
            Output::Markdown => print(&comparison.markdown())?,
            Output::Json => {
                let mut object = serde_json::to_value(&comparison)?;
                object["regressions"] = comparison.regressions().into();
                print_json(&object)?;
            }
        }
        Ok(if comparison.regressions().is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }

    fn records(&self, base: &str, new: &str) -> anyhow::Result<Comparison> {
        let (base, new) = (self.named(base)?, self.named(new)?);
        Ok(compare_records((&base.0, base.1), (&new.0, new.1))?)
    }

    /// The history and the selector that one argument stands for.
    fn named<'a>(&self, argument: &'a str) -> anyhow::Result<(History, &'a str)> {
        let (file, selector) = argument.rsplit_once('@').unwrap_or((argument, "latest"));
        if file.ends_with(".csv") {
            return Ok((History::read(Path::new(file))?, selector));
        }
        Ok((History::read(&self.history)?, argument))
    }

    /// Builds both revisions, measures them in turn, and measures again what looks slower.
    fn revisions(&self) -> anyhow::Result<Comparison> {
        let [base, new] = self.rev.as_slice() else {
            return Err(Error::invalid("--rev", self.rev.join(" "), "two revisions: --rev BASE --rev NEW").into());
        };
        // Interrupted, the compiler ends by itself, and what was checked out is removed.
        let _ = ctrlc::set_handler(|| {});
        let repository = Repository::around(&std::env::current_dir()?)?;
        let (base, new) = (repository.resolve(base)?, repository.resolve(new)?);
        let folder = tempfile::tempdir().context("no temporary folder")?;
        let target = self.target_dir.clone().map_or_else(|| Ok(folder.path().join("target")), std::path::absolute)?;
        let first = repository.check_out(&base, folder.path())?;
        let base = first.build(&target)?;
        let second =
            if new.starts_with(&base.git_revision) { None } else { Some(repository.check_out(&new, folder.path())?) };
        let new = second.as_ref().map_or_else(|| Ok(base.clone()), |checkout| checkout.build(&target))?;
        self.measure(&base, &new)
    }

    fn measure(&self, base: &Program, new: &Program) -> anyhow::Result<Comparison> {
        let (known, offered) = (base.benchmarks()?, new.benchmarks()?);
        let (common, others): (Vec<String>, Vec<String>) =
            offered.iter().chain(&known).cloned().partition(|name| known.contains(name) && offered.contains(name));
        let mut unique = Vec::new();
        common.into_iter().for_each(|name| {
            if !unique.contains(&name) {
                unique.push(name)
            }
        });
        let plan = self.measuring.plan(&unique)?;
        let provenance = Provenance::collect(&BUILD);
        let records = [base, new].map(|program| Recording::begin(program, &provenance));
        let (mut rows, mut paired): ([Vec<Row>; 2], Vec<Paired>) = Default::default();
        for benchmark in &plan.benchmarks {
            eprintln!("{benchmark}");
            let rounds = measure_rounds(base, Some(new), benchmark, plan.rounds.max(1))?;
            let bases: Vec<_> = rounds.iter().map(|round| &round.base).collect();
            let news: Vec<_> = rounds.iter().filter_map(|round| round.new.as_ref()).collect();
            for (side, samples) in [bases, news].into_iter().enumerate() {
                let mut row = records[side].row(benchmark, &samples, None);
                records[side].count_instructions(&mut row, plan.valgrind.as_deref())?;
                rows[side].push(row);
            }
            let right = rows.iter().all(|rows| rows.last().is_some_and(Row::is_ok));
            if let Some((ratio, placebo)) = paired_ratio(&rounds).zip(placebo_ratio(&rounds)).filter(|_| right) {
                let mut pair = Paired { benchmark: benchmark.clone(), ratio, placebo, second: None };
                let [_, high] = ratio.interval();
                if pair.decide() == Verdict::Suspected || high < 1.0 {
                    pair.second = paired_ratio(&measure_rounds(base, Some(new), benchmark, plan.rounds)?);
                }
                paired.push(pair);
            }
        }
        let [base, new] = rows;
        let mut comparison = compare_pairs(&base, &new, &paired);
        if !others.is_empty() {
            comparison.notes.push(format!("not in both revisions: {}", others.join(", ")));
        }
        Ok(comparison)
    }
}

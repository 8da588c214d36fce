//! `rimbench solvers`: give the corpus to every solver and compare.

use super::corpus::CORPUS;
use super::{Format, json_number, print, table};
use clap::Args;
use rimbench::atomic_file::{check_writable_folder, write_atomically};
use rimbench::catalogue::Catalogue;
use rimbench::complementarity::SolverEntry;
use rimbench::corpus::{Corpus, Replay, Solve, Start, draw_profile, replay};
use rimbench::error::{Error, Result};
use rimbench::figures::render;
use rimbench::name::Name;
use rimbench::statistics::{nearest_rank, performance_ratios, share_within};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Arguments of `solvers`.
#[derive(Debug, Args)]
pub struct Solvers {
    /// The corpus of contact problems (see `rimbench corpus`)
    #[arg(long, value_name = "FILE", default_value = CORPUS)]
    corpus: PathBuf,
    /// Only these solvers (see `rimbench list solvers`); may be repeated
    #[arg(long, value_name = "NAME")]
    solver: Vec<String>,
    /// Only problems whose source begins so, for example `wedge-box rim-nonsmooth`
    #[arg(long, value_name = "TEXT")]
    source: Option<String>,
    /// Write work.csv (the same everywhere), time.csv and the performance profile as csv, svg and png (of this machine) to a
    /// folder
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

/// Factors of the performance profile.
const FACTORS: [f64; 10] = [1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 30.0, 100.0, 1000.0, f64::INFINITY];

/// Sizes that results are grouped by, upper ends.
const SIZES: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, usize::MAX];

/// A row: key and value, in the order of the columns.
type Row = Vec<(Name, Value)>;

impl Solvers {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let chosen = self.chosen(catalogue)?;
        if let Some(folder) = &self.out {
            check_writable_folder(folder)?;
        }
        let mut corpus = Corpus::read(&self.corpus)?;
        if let Some(source) = &self.source {
            corpus = corpus.of_source(source);
            if corpus.is_empty() {
                let expected = "the beginning of a source in the corpus, for example the name of a case";
                return Err(Error::invalid("--source", source, expected).into());
            }
        }
        let mut replays = Vec::new();
        for solver in chosen {
            eprintln!("{}", solver.name);
            replays.extend([Start::Warm, Start::Cold].map(|start| replay(&corpus, &solver, start)));
        }
        let work: Vec<Row> =
            replays.iter().flat_map(|replay| grouped(replay).map(|(group, s)| work(group, &s))).collect();
        let time: Vec<Row> =
            replays.iter().flat_map(|replay| grouped(replay).map(|(group, s)| time(group, &s))).collect();
        let profile = profile(&replays);
        if let Some(folder) = &self.out {
            for (name, rows) in [("work.csv", &work), ("time.csv", &time), ("profile.csv", &profile)] {
                write_csv(&folder.join(name), rows)?;
            }
            render::write(&draw_profile(&replays, catalogue.solvers()), folder, "profile")?;
        }
        let overall: Vec<Row> = replays.iter().map(overall).collect();
        match self.format {
            Format::Json => {
                let parts = [("overall", &overall), ("work", &work), ("time", &time), ("profile", &profile)];
                let object = parts.map(|(name, rows)| (name.to_owned(), json(rows))).into_iter();
                print(&serde_json::to_string_pretty(&Value::Object(object.collect()))?)
            }
            Format::Table => {
                print(&text(&overall))?;
                print("\nFraction of problems solved within a factor of the fastest, warm:")?;
                print(&text(&profile))
            }
        }
    }

    fn chosen(&self, catalogue: &Catalogue) -> Result<Vec<Arc<SolverEntry>>> {
        if self.solver.is_empty() {
            return Ok(catalogue.solvers().to_vec());
        }
        self.solver.iter().map(|name| catalogue.solver(name).cloned()).collect()
    }
}

/// A replay and an upper end of sizes; the first are the columns that say so.
fn grouped(replay: &Replay) -> impl Iterator<Item = (Row, Vec<Solve>)> {
    let ends = SIZES.iter().scan(0, |from, &end| {
        let group = (*from + 1, end);
        *from = end;
        Some(group)
    });
    ends.filter_map(move |(from, end)| {
        let solves: Vec<Solve> = replay.solves.iter().filter(|s| (from..=end).contains(&s.n)).copied().collect();
        let largest = solves.iter().map(|solve| solve.n).max()?;
        let mut row = named(replay);
        put(&mut row, [("n_from", from.into()), ("n_to", largest.into()), ("problems", solves.len().into())]);
        Some((row, solves))
    })
}

fn named(replay: &Replay) -> Row {
    let start = if replay.start == Start::Warm { "warm" } else { "cold" };
    vec![("solver".into(), replay.solver.name.as_ref().into()), ("start".into(), start.into())]
}

fn put<const N: usize>(row: &mut Row, columns: [(&'static str, Value); N]) {
    row.extend(columns.map(|(key, value)| (key.into(), value)));
}

/// What does not depend on the machine.
fn work(mut row: Row, solves: &[Solve]) -> Row {
    let total = |count: fn(&Solve) -> u32| solves.iter().map(|solve| u64::from(count(solve))).sum::<u64>();
    let most = solves.iter().map(|solve| solve.stats.pivots).max().unwrap_or(0);
    let solved = solves.iter().filter(|solve| solve.solved);
    let refused = solves.iter().filter(|solve| solve.refused).count();
    let worst = solved.clone().map(|solve| solve.stats.residual).fold(f64::NAN, f64::max);
    put(
        &mut row,
        [
            ("refused", refused.into()),
            ("failures", (solves.len() - refused - solved.count()).into()),
            ("pivots", total(|solve| solve.stats.pivots).into()),
            ("most_pivots", most.into()),
            ("factorisations", total(|solve| solve.stats.factorisations).into()),
            ("worst_accepted_residual", json_number(worst)),
        ],
    );
    row
}

/// What does.
fn time(mut row: Row, solves: &[Solve]) -> Row {
    let mut times: Vec<f64> = solves.iter().filter(|solve| solve.solved).map(|solve| solve.time_ns).collect();
    for (name, percent) in [("median_ns", 50), ("p99_ns", 99), ("max_ns", 100)] {
        row.push((name.into(), json_number(nearest_rank(&mut times, percent).unwrap_or(f64::NAN).round())));
    }
    row
}

/// One line for the reader.
fn overall(replay: &Replay) -> Row {
    let with_work = work(named(replay), &replay.solves);
    let mut row = time(with_work, &replay.solves);
    row.push(("mean_ns".into(), json_number((10.0 * replay.mean_ns).round() / 10.0)));
    row
}

/// The performance profile of the warm replays.
fn profile(replays: &[Replay]) -> Vec<Row> {
    let warm: Vec<&Replay> = replays.iter().filter(|replay| replay.start == Start::Warm).collect();
    let ratios = performance_ratios(&warm.iter().map(|replay| replay.costs()).collect::<Vec<_>>());
    let row = |factor: f64| {
        let share = |ratios: &Vec<f64>| json_number((1e4 * share_within(ratios, factor)).round() / 1e4);
        let columns = warm.iter().zip(&ratios).map(|(replay, ratios)| (replay.solver.name.clone(), share(ratios)));
        std::iter::once(("factor".into(), json_number(factor))).chain(columns).collect()
    };
    FACTORS.into_iter().map(row).collect()
}

fn json(rows: &[Row]) -> Value {
    let object =
        |row: &Row| row.iter().map(|(key, value)| (key.clone().into_owned(), value.clone())).collect::<Map<_, _>>();
    rows.iter().map(|row| Value::Object(object(row))).collect()
}

fn cell(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

fn text(rows: &[Row]) -> String {
    let header: Vec<&str> = rows.first().map(|row| row.iter().map(|(key, _)| &**key).collect()).unwrap_or_default();
    let mut table = table(&header);
    table.add_rows(rows.iter().map(|row| row.iter().map(|(_, value)| cell(value))));
    table.to_string()
}

fn write_csv(path: &Path, rows: &[Row]) -> Result<()> {
    write_atomically(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        if let Some(first) = rows.first() {
            writer.write_record(first.iter().map(|(key, _)| &**key))?;
        }
        for row in rows {
            writer.write_record(row.iter().map(|(_, value)| cell(value)))?;
        }
        writer.flush()
    })
}

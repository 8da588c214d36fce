//! `rimbench solvers`: give the corpus to every solver and compare; or harvest it.

use super::corpus::harvest_to;
use super::json::Object;
use super::progress::plain_time;
use super::project::Project;
use super::screen::Table;
use super::{Format, print, print_json};
use clap::Args;
use rimbench::atomic_file::{check_writable_folder, write_atomically};
use rimbench::catalogue::Catalogue;
use rimbench::corpus::{
    Contestant, Corpus, FrictionMethod, FrictionalCorpus, LARGE_SYSTEMS, LargeCorpus, LargeReplay, Replay, Solve,
    Start, Uniqueness, draw_profile, replay, replay_large, replay_with_friction,
};
use rimbench::error::{Error, Result};
use rimbench::figures::render;
use rimbench::name::Name;
use rimbench::runs::FactValue;
use rimbench::shipped;
use rimbench::solver_entry::SolverEntry;
use rimbench::statistics::{nearest_rank, performance_ratios, share_within};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Arguments of `solvers`.
#[derive(Debug, Args)]
pub struct Solvers {
    /// Problems with friction, and the methods that solve them: active-states, enumeration, lemke, sweeps, and in-turn, which is what simulations
    /// have
    #[arg(long)]
    friction: bool,
    /// Problems of 65 to 1560 contacts, made anew from their cases, for the solver of many contacts, Clarabel with sparse matrices and
    /// all that are given whole ones; each as far as it gets in a few seconds
    #[arg(long, conflicts_with_all = ["friction", "corpus", "source"])]
    large: bool,
    /// The corpus of contact problems (see --harvest) [default: that of the project's folder, or the one built in]
    #[arg(long, value_name = "FILE")]
    corpus: Option<PathBuf>,
    /// Only these solvers (see `rimbench list solvers`); may be repeated
    #[arg(long, value_name = "NAME")]
    solver: Vec<String>,
    /// Only problems whose source begins so, for example `wedge-box rim-nonsmooth`
    #[arg(long, value_name = "TEXT")]
    source: Option<String>,
    /// Compare nothing: harvest the corpus from actual runs; with --friction that with friction
    #[arg(long, conflicts_with_all = ["large", "corpus", "source", "solver", "format"])]
    harvest: bool,
    /// Write work.csv (the same everywhere), time.csv and the performance profile as csv, svg and png (of this machine) to a
    /// folder; with --harvest the file to write [default: data/contact-problems/corpus.lcp, with friction friction.lcp beside it]
    #[arg(long, value_name = "PATH")]
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
type Row = Vec<(Name, FactValue)>;

impl Solvers {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        if self.harvest {
            return harvest_to(self.out, self.friction);
        }
        match (self.friction, self.large) {
            (true, _) => self.compare_with_friction(),
            (false, true) => self.compare_large(catalogue),
            (false, false) => self.compare(catalogue),
        }
    }

    /// Those asked for, or all.
    fn chosen(&self, catalogue: &Catalogue) -> Result<Vec<Arc<SolverEntry>>> {
        if self.solver.is_empty() {
            return Ok(catalogue.solvers().to_vec());
        }
        self.solver.iter().map(|name| catalogue.solver(name).cloned()).collect()
    }

    fn compare_large(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let contestants = Contestant::with(&self.chosen(catalogue)?);
        self.check_folder()?;
        let mut rows: Vec<Row> = Vec::new();
        let mut before: Option<(&str, usize, Vec<LargeReplay>)> = None;
        for (done, &system) in LARGE_SYSTEMS.iter().enumerate() {
            let corpus = LargeCorpus::of(system)?;
            let n = corpus.contacts();
            eprintln!("{} of {}: {}, {n} contacts", done + 1, LARGE_SYSTEMS.len(), system.case);
            let smaller = before.as_ref().filter(|(case, ..)| *case == system.case);
            let replays: Vec<LargeReplay> = contestants
                .iter()
                .enumerate()
                .map(|(at, contestant)| {
                    replay_large(&corpus, contestant, smaller.map(|(_, contacts, replays)| (*contacts, &replays[at])))
                })
                .collect();
            rows.extend(replays.iter().map(|replay| large_row(&corpus, replay, &replays[0])));
            before = Some((system.case, n, replays));
        }
        if let Some(folder) = &self.out {
            write_csv(&folder.join("large.csv"), &rows)?;
        }
        match self.format {
            Format::Json => print_json(&json(&rows)),
            Format::Table => print(&text(&rows)),
        }
    }

    fn compare(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let chosen = self.chosen(catalogue)?;
        self.check_folder()?;
        let corpus = self.corpus.as_deref().map_or_else(|| Project::find().corpus(shipped::CORPUS), Corpus::read)?;
        let corpus = self.of_source(corpus)?;
        let names: Vec<Name> = chosen.iter().map(|solver| solver.name.clone()).collect();
        let replays = replays(&names, |at, start| replay(&corpus, &chosen[at], start));
        let known: Vec<Name> = catalogue.solvers().iter().map(|solver| solver.name.clone()).collect();
        self.say(&replays, &known, work, None)
    }

    fn compare_with_friction(self) -> anyhow::Result<()> {
        let known = FrictionMethod::NAMES.map(|(_, method)| method);
        let chosen: Vec<FrictionMethod> = if self.solver.is_empty() {
            known.to_vec()
        } else {
            self.solver.iter().map(|name| name.parse()).collect::<Result<_>>()?
        };
        self.check_folder()?;
        let corpus =
            self.corpus.as_deref().map_or_else(|| Project::find().corpus(shipped::FRICTION_CORPUS), Corpus::read)?;
        let corpus = self.of_source(corpus)?;
        let names: Vec<Name> = chosen.iter().map(|method| method.name()).collect();
        let replays = replays(&names, |at, start| replay_with_friction(&corpus, chosen[at], start));
        self.say(&replays, &known.map(FrictionMethod::name), frictional_work, Some(uniqueness(&corpus)))
    }

    fn check_folder(&self) -> Result<()> {
        self.out.as_deref().map_or(Ok(()), check_writable_folder)
    }

    /// Only what was asked for.
    fn of_source<const F: bool>(&self, corpus: Corpus<F>) -> Result<Corpus<F>> {
        let Some(source) = &self.source else { return Ok(corpus) };
        let chosen = corpus.of_source(source);
        if chosen.is_empty() {
            let expected = "the beginning of a source in the corpus, for example the name of a case";
            return Err(Error::invalid("--source", source, expected));
        }
        Ok(chosen)
    }

    /// Writes and prints it all; `solutions` says how many problems have several.
    fn say(self, replays: &[Replay], known: &[Name], work: Work, solutions: Option<Row>) -> anyhow::Result<()> {
        let by_size = |of: fn(Row, &[Solve]) -> Row| -> Vec<Row> {
            replays.iter().flat_map(|replay| grouped(replay).map(move |(group, s)| of(group, &s))).collect()
        };
        let (done, time, profile) = (by_size(work), by_size(time), profile(replays));
        let solutions: Vec<Row> = solutions.into_iter().collect();
        if let Some(folder) = &self.out {
            for (name, rows) in [("work.csv", &done), ("time.csv", &time), ("profile.csv", &profile)] {
                write_csv(&folder.join(name), rows)?;
            }
            if !solutions.is_empty() {
                write_csv(&folder.join("solutions.csv"), &solutions)?;
            }
            render::write(&draw_profile(replays, known), folder, "profile")?;
        }
        let whole = |replay: &Replay| work(named(replay), &replay.solves);
        match self.format {
            Format::Json => {
                let overall: Vec<Row> =
                    replays.iter().map(|replay| with_mean(self::time(whole(replay), &replay.solves), replay)).collect();
                let parts = [("overall", &overall), ("work", &done), ("time", &time), ("profile", &profile)];
                let with_friction = (!solutions.is_empty()).then_some(("solutions", &solutions));
                let object = parts.into_iter().chain(with_friction).map(|(name, rows)| (name.to_owned(), json(rows)));
                print_json(&Value::Object(object.collect()))
            }
            Format::Table => {
                // One row per solver and start is too wide for most terminals: what was done, and how long it took, apart.
                print(&text(&replays.iter().map(whole).collect::<Vec<_>>()))?;
                print("\nTimes of problems solved, ns:")?;
                let mut times: Vec<Row> = replays.iter().map(whole_time).collect();
                put_ratios(&mut times, replays);
                print(&text(&times))?;
                print("\nFraction of problems solved within a factor of the fastest, warm:")?;
                print(&text(&profile))?;
                if !solutions.is_empty() {
                    print(
                        "\nProblems with more than one solution, among those with few enough contacts to list them all:",
                    )?;
                    print(&text(&solutions))?;
                }
                Ok(())
            }
        }
    }
}

/// What of a group of solves does not depend on the machine.
type Work = fn(Row, &[Solve]) -> Row;

/// Gives the corpus to each solver, and says how far it is: solvers differ too much for an estimate before the first is done.
fn replays(names: &[Name], replay: impl Fn(usize, Start) -> Replay) -> Vec<Replay> {
    let began = Instant::now();
    let mut replays = Vec::new();
    for (done, name) in names.iter().enumerate() {
        let elapsed = began.elapsed().as_secs_f64();
        let left = (done > 0).then(|| elapsed / done as f64 * (names.len() - done) as f64);
        let left = left.map_or_else(String::new, |left| format!(", about {} left", plain_time(left)));
        eprintln!("{} of {}: {name}{left}", done + 1, names.len());
        replays.extend([Start::Warm, Start::Cold].map(|start| replay(done, start)));
        if let Some(panic) = replays.iter().rev().take(2).find_map(|replay| replay.panic.as_ref()) {
            eprintln!("note: {name} panicked, which is a defect of it and counts as failures: {panic}");
        }
    }
    replays
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
        let sizes = [("n_from", count(from)), ("n_to", count(largest)), ("problems", count(solves.len()))];
        Some((put(named(replay), sizes), solves))
    })
}

fn named(replay: &Replay) -> Row {
    let start = if replay.start == Start::Warm { "warm" } else { "cold" };
    vec![("solver".into(), text_of(&replay.solver)), ("start".into(), text_of(start))]
}

fn text_of(text: &str) -> FactValue {
    FactValue::Text(text.to_owned())
}

fn count(count: usize) -> FactValue {
    FactValue::Count(count as u64)
}

fn put<const N: usize>(mut row: Row, columns: [(&'static str, FactValue); N]) -> Row {
    row.extend(columns.map(|(key, value)| (key.into(), value)));
    row
}

/// What does not depend on the machine.
fn work(row: Row, solves: &[Solve]) -> Row {
    let total = |of: fn(&Solve) -> u32| FactValue::Count(solves.iter().map(|solve| u64::from(of(solve))).sum());
    let most = solves.iter().map(|solve| solve.stats.pivots).max().unwrap_or(0);
    let solved = solves.iter().filter(|solve| solve.solved);
    let refused = solves.iter().filter(|solve| solve.refused).count();
    let worst = solved.clone().map(|solve| solve.stats.residual).fold(f64::NAN, f64::max);
    put(
        row,
        [
            ("refused", count(refused)),
            ("failures", count(solves.len() - refused - solved.count())),
            ("pivots", total(|solve| solve.stats.pivots)),
            ("most_pivots", FactValue::Count(most.into())),
            ("factorisations", total(|solve| solve.stats.factorisations)),
            ("worst_accepted_residual", FactValue::Number(worst)),
        ],
    )
}

/// What does.
fn time(row: Row, solves: &[Solve]) -> Row {
    let mut times: Vec<f64> = solves.iter().filter(|solve| solve.solved).map(|solve| solve.time_ns).collect();
    let mut rank = |percent| FactValue::Number(nearest_rank(&mut times, percent).unwrap_or(f64::NAN).round());
    put(row, [("median_ns", rank(50)), ("p99_ns", rank(99)), ("max_ns", rank(100))])
}

/// The same with friction, where a method may be one that has others behind it.
fn frictional_work(row: Row, solves: &[Solve]) -> Row {
    put(work(row, solves), [("fallbacks", count(solves.iter().filter(|solve| solve.stats.fallback).count()))])
}

fn uniqueness(corpus: &FrictionalCorpus) -> Row {
    let Uniqueness { listed, several, several_impulses, none, least_margin, beyond_painleve } = Uniqueness::of(corpus);
    put(
        Vec::new(),
        [
            ("problems", count(corpus.len())),
            ("listed", count(listed)),
            ("several_velocities", count(several)),
            ("several_impulses_only", count(several_impulses)),
            ("without_solution", count(none)),
            ("least_margin", FactValue::Number(least_margin)),
            ("margin_not_above_0", count(beyond_painleve)),
        ],
    )
}

/// What a solver made of the problems of one large system, beside the first.
fn large_row(corpus: &LargeCorpus, replay: &LargeReplay, first: &LargeReplay) -> Row {
    let tenth = |number: f64| FactValue::Number((10.0 * number).round() / 10.0);
    put(
        Vec::new(),
        [
            ("case", text_of(corpus.system.case)),
            ("contacts", count(corpus.contacts())),
            ("solver", text_of(&replay.solver)),
            ("problems", count(corpus.len())),
            ("given", count(replay.given)),
            ("solved", count(replay.solved)),
            ("worst_accepted_residual", FactValue::Number(replay.worst_residual)),
            ("pivots", FactValue::Count(replay.pivots)),
            ("median_us", tenth(1e-3 * replay.median_ns)),
            ("over_the_first", tenth(replay.median_ns / first.median_ns)),
        ],
    )
}

/// Over all sizes.
fn whole_time(replay: &Replay) -> Row {
    with_mean(time(named(replay), &replay.solves), replay)
}

/// Puts the mean time over that of the first beside it: ratios carry from machine to machine better than times.
fn put_ratios(rows: &mut [Row], replays: &[Replay]) {
    let Some(first) = replays.first().map(|replay| replay.mean_ns) else { return };
    for (row, replay) in rows.iter_mut().zip(replays) {
        row.push(("over_the_first".into(), FactValue::Number((100.0 * replay.mean_ns / first).round() / 100.0)));
    }
}

fn with_mean(row: Row, replay: &Replay) -> Row {
    put(row, [("mean_ns", FactValue::Number((10.0 * replay.mean_ns).round() / 10.0))])
}

/// The performance profile of the warm replays.
fn profile(replays: &[Replay]) -> Vec<Row> {
    let warm: Vec<&Replay> = replays.iter().filter(|replay| replay.start == Start::Warm).collect();
    let ratios = performance_ratios(&warm.iter().map(|replay| replay.costs()).collect::<Vec<_>>());
    let row = |factor: f64| {
        let share = |ratios: &Vec<f64>| FactValue::Number((1e4 * share_within(ratios, factor)).round() / 1e4);
        let columns = warm.iter().zip(&ratios).map(|(replay, ratios)| (replay.solver.clone(), share(ratios)));
        std::iter::once(("factor".into(), FactValue::Number(factor))).chain(columns).collect()
    };
    FACTORS.into_iter().map(row).collect()
}

fn json(rows: &[Row]) -> Value {
    let object = |row: &Row| {
        let mut object = Object::default();
        row.iter().for_each(|(key, value)| object.value(&**key, Some(value)));
        Value::from(object)
    };
    rows.iter().map(object).collect()
}

/// As in all tables; what is not a number is `nan`, whatever the sign that the machine gave it.
fn cell(value: &FactValue) -> String {
    match value {
        FactValue::Number(number) if number.is_nan() => "nan".to_owned(),
        value => value.to_string(),
    }
}

/// For reading: headings that can be broken, and no more digits than one looks at.
fn text(rows: &[Row]) -> String {
    let header: Vec<String> =
        rows.first().map(|row| row.iter().map(|(key, _)| heading(key)).collect()).unwrap_or_default();
    let mut table = Table::new(&header.iter().map(String::as_str).collect::<Vec<_>>());
    rows.iter().for_each(|row| table.add_row(row.iter().map(|(_, value)| short(value))));
    table.to_string()
}

/// A column's name as words, of lengths that leave room for others.
fn heading(key: &str) -> String {
    match key {
        "worst_accepted_residual" => "worst residual".to_owned(),
        key => key.trim_end_matches("_ns").replace('_', " "),
    }
}

fn short(value: &FactValue) -> String {
    match value {
        FactValue::Number(number) if *number != 0.0 && number.abs() < 1e-3 => format!("{number:.1e}"),
        FactValue::Number(number) if number.abs() >= 100.0 => format!("{number:.0}"),
        value => cell(value),
    }
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

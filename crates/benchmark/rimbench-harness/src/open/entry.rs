//! An entry: what somebody ran over the packs with one setting, and what came of it.
//!
//! ```text
//! <entry>/entry.toml     who, what and which runs, each with its file and checksum, or its outcome
//! <entry>/summary.csv    medians over phases, as results of an experiment have them
//! ```

use super::judge::{Judged, judge};
use super::problem::{LEAST_PHASES, Problem, pack_version};
use rimbench_core::cosim::Trajectory;
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::InformationClass;
use rimbench_results::checksums::sha256_of_file;
use rimbench_results::input::read_text;
use rimbench_results::kept::{SUMMARY, SUMMARY_METRICS, SummaryRow, read_rows, summary_text};
use rimbench_results::text_place::said_at;
use rimbench_runs::metrics::USABLE;
use rimbench_statistics::Pool;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Name of the file that describes an entry.
pub const ENTRY: &str = "entry.toml";

/// What an entry says of itself.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Its row in tables.
    pub name: String,
    /// The most that it asks for, by name.
    class: String,
    /// Where it is ranked.
    pub division: Division,
    /// What of a side it uses besides inputs, outputs and steps.
    #[serde(default)]
    uses: Vec<Use>,
    /// Program and version.
    pub tool: String,
    /// Version of the program.
    pub version: String,
    /// The setting, one for all runs.
    pub settings: String,
    /// Who made it.
    pub authors: Vec<String>,
    /// Whether they made the benchmark as well.
    pub of_the_benchmark: bool,
    /// Day, as 2026-11-28.
    pub date: String,
    /// Licence of the data.
    pub licence: String,
    /// On what it ran.
    pub machine: String,
    /// Problems that settings were chosen on.
    #[serde(default)]
    pub tuned_on: BTreeSet<String>,
    /// What shows that the runs are what they say: `told`, `replayed` or `repeated` by others.
    pub evidence: Evidence,
    /// Version of the packs.
    pack_version: String,
    /// Where the trajectories are, if not here.
    pub trajectories: Option<Archive>,
    /// Its runs.
    pub runs: Vec<EntryRun>,
}

/// Which rules an entry keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Division {
    /// The pack's sides and steps, its macro steps, four phases or more, one setting for all.
    Closed,
    /// Anything that a trajectory can be had from.
    Open,
}

/// What shows that runs are what they say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Evidence {
    /// The word of its authors.
    Told,
    /// `replay.py` of the pack holds all runs that completed.
    Replayed,
    /// Others ran it again.
    Repeated,
}

/// What of a side a master may use, which decides the least class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Use {
    Derivatives,
    Inside,
    Model,
    States,
    Whole,
}

/// Where trajectories are.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Archive {
    /// Address.
    pub url: String,
    /// Checksum, hexadecimal.
    pub sha256: String,
    /// Size.
    pub bytes: u64,
}

/// A run of an entry: a file with its checksum, or an outcome.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EntryRun {
    problem: String,
    macro_step_s: f64,
    phase: f64,
    file: Option<PathBuf>,
    sha256: Option<String>,
    outcome: Option<Told>,
    #[serde(default, rename = "reason")]
    _reason: String,
}

/// Outcomes of runs that have no file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Told {
    /// It broke off.
    Failed,
    /// It took too long, or could not be begun.
    NoAnswer,
}

/// Trajectories that were scored, and numbers of runs without one: broken off, without an answer.
type OfRuns = (Vec<Judged>, [usize; 2]);

impl Entry {
    /// Reads what an entry's folder says of it, and checks what can be checked without trajectories.
    ///
    /// # Errors
    /// [`Error::File`] with key, value and what would be valid.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(ENTRY);
        let text = read_text(&path)?;
        let wrong = |error: toml::de::Error| {
            Error::file(&path, format!("is no entry: {}", said_at(&text, error.span(), error.message())))
        };
        let entry: Entry = toml::from_str(&text).map_err(wrong)?;
        entry.check().map_err(|error| Error::file(&path, error))?;
        Ok(entry)
    }

    /// Returns the class that it says.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn class(&self) -> Result<InformationClass> {
        let found = InformationClass::LIST.iter().find(|(name, _)| *name == self.class);
        let names = InformationClass::LIST.iter().map(|(name, _)| *name);
        found.map(|(_, class)| *class).ok_or_else(|| Error::unknown("class", &self.class, names))
    }

    fn check(&self) -> Result<()> {
        let least = self.uses.iter().map(|used| match used {
            Use::Derivatives => InformationClass::Derivatives,
            Use::Inside => InformationClass::Inside,
            Use::Model => InformationClass::Model,
            Use::States => InformationClass::Repetition,
            Use::Whole => InformationClass::Whole,
        });
        let (class, least) = (self.class()?, least.max().unwrap_or(InformationClass::Samples));
        if class < least {
            return Err(Error::invalid("class", &self.class, format!("{least} or more, by what it uses")));
        }
        let version = pack_version();
        if self.pack_version != version {
            return Err(Error::invalid("pack_version", &self.pack_version, version));
        }
        let mut seen = BTreeSet::new();
        for run in &self.runs {
            let place = format!("runs: {}, H = {:?} s, phase {:?}", run.problem, run.macro_step_s, run.phase);
            let is_sum = |sum: &String| sum.len() == 64 && sum.bytes().all(|byte| byte.is_ascii_hexdigit());
            let wrong = match (&run.file, &run.sha256, run.outcome) {
                _ if !seen.insert((&run.problem, run.macro_step_s.to_bits(), run.phase.to_bits())) => "is there twice",
                _ if !(run.phase > 0.0 && run.phase <= 1.0 && run.macro_step_s > 0.0) => {
                    "is no run; valid: a macro step above 0 and a phase in (0, 1]"
                }
                (Some(_), Some(sum), None) if is_sum(sum) => continue,
                (None, None, Some(_)) => continue,
                _ => "has not what it needs; valid: a file with its sha256, or an outcome, failed or no-answer",
            };
            return Err(Error::Incompatible(format!("{place}: {wrong}")));
        }
        if self.runs.is_empty() {
            return Err(Error::Incompatible("runs = [] is not valid; valid: at least one run".to_owned()));
        }
        // The rows of the benchmark's own authors have the phases of their studies.
        if self.division == Division::Closed && !self.of_the_benchmark {
            for ((problem, step), count) in self.counted() {
                if count < LEAST_PHASES {
                    let step = f64::from_bits(step);
                    return Err(Error::Incompatible(format!(
                        "runs: {problem} at H = {step:?} s has {count} phases; valid in the closed division: {LEAST_PHASES} or more"
                    )));
                }
            }
        }
        Ok(())
    }

    /// Runs by problem and macro step.
    fn counted(&self) -> BTreeMap<(&str, u64), usize> {
        let mut counts = BTreeMap::new();
        self.runs.iter().for_each(|run| {
            *counts.entry((&*run.problem, run.macro_step_s.to_bits())).or_default() += 1;
        });
        counts
    }

    /// Scores all its runs by the packs, and returns the rows of its `summary.csv` and as text.
    ///
    /// # Errors
    /// [`Error::File`] for a trajectory that is not there, not that of its checksum, or no result of its problem.
    pub fn judge(&self, folder: &Path, packs: &Packs) -> Result<(Vec<SummaryRow>, Vec<u8>)> {
        let path = folder.join(ENTRY);
        let mut found: BTreeMap<(&str, u64), OfRuns> = BTreeMap::new();
        for run in &self.runs {
            let pack = packs.get(&run.problem).map_err(|error| Error::file(&path, error))?;
            let steps = &pack.0.macro_steps_s;
            let on_grid = steps.iter().any(|step| (step / run.macro_step_s - 1.0).abs() < 1e-9);
            if self.division == Division::Closed && !on_grid {
                let valid = steps.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
                return Err(Error::file(&path, Error::invalid("macro_step_s", run.macro_step_s, valid)));
            }
            let of = found.entry((&run.problem, run.macro_step_s.to_bits())).or_default();
            let (Some(name), Some(sum)) = (&run.file, &run.sha256) else {
                of.1[usize::from(run.outcome == Some(Told::NoAnswer))] += 1;
                continue;
            };
            let file = folder.join(name);
            match sha256_of_file(&file) {
                None => return Err(Error::file(&file, "is not there, and the entry has its checksum")),
                Some(own) if own != sum.to_lowercase() => {
                    return Err(Error::file(&file, format!("has the checksum {own}, and the entry says {sum}")));
                }
                Some(_) => {}
            }
            let judged = judge(&file, pack, Some(run.phase))?;
            let refused = |message: String| Error::file(&file, message);
            if (judged.macro_step_s / run.macro_step_s - 1.0).abs() > 1e-6 {
                let told = run.macro_step_s;
                return Err(refused(format!(
                    "time_s: H is {:.6e} s, and the entry says {told:.6e} s",
                    judged.macro_step_s
                )));
            }
            if self.division == Division::Closed && !judged.received {
                let names: Vec<&str> = pack.0.rows.iter().map(|row| &*row.received).collect();
                return Err(refused(format!("has no column {}, which the closed division asks for", names.join(", "))));
            }
            of.0.push(judged);
        }
        let rows: Vec<SummaryRow> = found
            .into_iter()
            .map(|((problem, step), (judged, [failed, no_answer]))| {
                let (completed, broken): (Vec<_>, Vec<_>) =
                    judged.into_iter().partition(|judged| judged.outcome == "completed");
                let of = |name: &str| -> [f64; 3] {
                    let value = |judged: &Judged| match name {
                        "interface_residual_j" => judged.interface_residual_j,
                        name => judged.score(name),
                    };
                    Pool::of(completed.iter().filter_map(value)).quartiles()
                };
                let is_usable = |judged: &&Judged| {
                    judged.score("force_error_rms_of_event_peak").is_some_and(|error| error <= USABLE)
                };
                let failed = failed + broken.len();
                let pack = packs.get(problem).map(|pack| &pack.0);
                let [case, set] = pack.map_or_else(
                    |_| [problem.to_owned(), String::new()],
                    |pack| [pack.problem.clone(), pack.set.clone()],
                );
                SummaryRow {
                    keys: [case, set, self.name.clone(), format!("{:?}", f64::from_bits(step)), String::new()],
                    runs: completed.len() + failed + no_answer,
                    completed: completed.len(),
                    failed,
                    no_answer,
                    usable: completed.iter().filter(is_usable).count(),
                    quartiles: SUMMARY_METRICS.map(of),
                    worst: None,
                }
            })
            .collect();
        let text = summary_text(&rows, false).map_err(|error| Error::file(folder.join(SUMMARY), error))?;
        Ok((rows, text))
    }

    /// Reads its `summary.csv`, which must be of its runs.
    ///
    /// # Errors
    /// [`Error::File`] if it is not.
    pub fn summary(&self, folder: &Path) -> Result<Vec<SummaryRow>> {
        let path = folder.join(SUMMARY);
        let rows = read_rows(&path)?;
        let told: usize = rows.iter().map(|row| row.runs).sum();
        let consistent = rows
            .iter()
            .all(|row| row.runs == row.completed + row.failed + row.no_answer && row.usable <= row.completed);
        if told != self.runs.len() || !consistent || rows.len() != self.counted().len() {
            let message = format!(
                "is of {told} runs in {} rows, and {ENTRY} has {} in {}: `rimbench judge ENTRY --problems FOLDER` writes it",
                rows.len(),
                self.runs.len(),
                self.counted().len()
            );
            return Err(Error::file(&path, message));
        }
        Ok(rows)
    }
}

/// Problem packs by their names.
pub struct Packs(BTreeMap<String, (Problem, Trajectory)>);

impl Packs {
    /// Reads all packs in a folder.
    ///
    /// # Errors
    /// [`Error::File`] if there is none, or one cannot be read.
    pub fn read(folder: &Path) -> Result<Self> {
        let unreadable = |error: std::io::Error| Error::file(folder, format!("cannot be read: {error}"));
        let mut packs = BTreeMap::new();
        for entry in std::fs::read_dir(folder).map_err(unreadable)? {
            let own = entry.map_err(unreadable)?.path();
            if own.join("score.json").is_file() {
                let pack = Problem::read(&own)?;
                packs.insert(pack.0.name(), pack);
            }
        }
        match packs.is_empty() {
            true => {
                Err(Error::file(folder, "holds no problem pack; `rimbench pack --ranking --out FOLDER` writes them"))
            }
            false => Ok(Packs(packs)),
        }
    }

    fn get(&self, problem: &str) -> Result<&(Problem, Trajectory)> {
        self.0.get(problem).ok_or_else(|| Error::unknown("problem", problem, self.0.keys().map(String::as_str)))
    }
}

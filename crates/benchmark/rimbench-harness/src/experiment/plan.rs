//! The runs that an experiment file stands for.

use super::claims_of_plan::check_claims_against_plan;
use super::draw::{Drawn, Search};
use super::planned_run::PlannedRun;
use super::scheme_row::SchemeRow;
use super::{BeliefEntry, CaseEntry, Experiment};
use crate::grid::{MOST_PLANNED, MOST_RUNS, MacroSteps, PART, grid_point, points_of_grid};
use crate::references::content_key;
use rayon::prelude::*;
use rimbench_cases::cases::Case;
use rimbench_cases::parameter::Parameters;
use rimbench_core::cosim::{CommunicationGrid, StopFlag};
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums::sha256;
use rimbench_runs::catalogue::Catalogue;
use rimbench_runs::metrics::Only;
use rimbench_runs::{Reference, RunRequest, RunSpec, only_of};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::Arc;

/// Where a macro step starts (s), and the runs whose beliefs within it are stored, each with its label.
type Beliefs = (f64, Vec<(String, RunSpec)>);

impl Experiment {
    /// Lists the runs, cases outermost, then schemes, macro steps, tolerances, phases; names are those of the
    /// catalogue.
    ///
    /// # Errors
    /// Names, values or combinations that are not valid, each with the file and the key; an empty grid.
    pub fn plan(&self, catalogue: &Catalogue, quick: bool) -> Result<Vec<PlannedRun>> {
        self.plan_with(catalogue, quick, true)
    }

    /// Lists as many runs of the same labels, with the settings of the first draw whether or not they have the event
    /// that they must: to find the others takes references of hundreds of settings.
    ///
    /// # Errors
    /// As [`plan`](Self::plan).
    pub fn plan_at_first_draw(&self, catalogue: &Catalogue, quick: bool) -> Result<Vec<PlannedRun>> {
        self.plan_with(catalogue, quick, false)
    }

    fn plan_with(&self, catalogue: &Catalogue, quick: bool, search: bool) -> Result<Vec<PlannedRun>> {
        let planned = || {
            self.check_options()?;
            self.check_labels(catalogue)?;
            self.beliefs(catalogue)?;
            let size = self.check_size(quick)?;
            if self.quick.is_some() {
                self.check_size(true).map_err(|error| Error::Incompatible(format!("[quick]: {error}")))?;
            }
            if size > MOST_RUNS {
                return Err(Error::Incompatible(format!(
                    "the grid has {size} runs, more than the {MOST_RUNS} that are planned at once: run its parts, by --places, --shard or \
                     --slurm"
                )));
            }
            let runs = self.lay_out(catalogue, quick, search, 0..size)?;
            if self.audit && !runs.iter().any(|run| run.spec.audit) {
                return Err(Error::Incompatible(
                    "audit = true: no scheme has an interface model that can be audited".to_owned(),
                ));
            }
            refuse_duplicates(&runs)?;
            // A quick plan may leave out what a claim is about.
            if !quick {
                check_claims_against_plan(&self.claims, &runs)?;
            }
            Ok(runs)
        };
        planned().map_err(|error| self.in_file(error))
    }

    /// Lists the runs that a table `perf` chooses, each by a name: `case set/label/H`, and the phase where it is not 1.
    ///
    /// # Errors
    /// As [`plan`](Self::plan); a file without such a table, or one that chooses nothing.
    pub fn measured_runs(&self, catalogue: &Catalogue) -> Result<Vec<(String, RunSpec)>> {
        let none = |what: &str| {
            let valid = "[perf] with schemes = [labels], and macro_steps_s if not all of theirs";
            Error::file(&self.path, format!("{what}; valid: {valid}"))
        };
        let perf = self.perf.as_ref().ok_or_else(|| none("names no run to record"))?;
        let labels = || self.schemes.iter().map(|row| row.label.as_str());
        if let Some(other) = perf.schemes.iter().find(|wanted| !labels().any(|label| label == wanted.as_str())) {
            return Err(self.in_file(Error::unknown("label in [perf]", other, labels())));
        }
        let steps =
            perf.macro_steps_s.as_ref().map(MacroSteps::list).transpose().map_err(|error| self.in_file(error))?;
        let mut runs = self.plan_at_first_draw(catalogue, false)?;
        runs.retain(|run| {
            let step = run.spec.macro_step;
            perf.schemes.contains(&run.label) && steps.as_ref().is_none_or(|steps| steps.contains(&step))
        });
        let named = runs.into_iter().map(|PlannedRun { spec, label, set, .. }| {
            let of = format!("{} {set}", spec.case.name);
            let phase = if spec.phase == 1.0 { String::new() } else { format!("/{}", spec.phase) };
            (format!("{}/{label}/{}{phase}", of.trim_end(), spec.macro_step), spec)
        });
        let named: Vec<_> = named.collect();
        if named.is_empty() { Err(none("[perf] chooses no run of the plan")) } else { Ok(named) }
    }

    /// Lists what is asked of every scheme: the runs of the first one, with the settings of the first draw.
    ///
    /// # Errors
    /// As [`plan`](Self::plan).
    pub fn problems(&self, catalogue: &Catalogue) -> Result<Vec<RunSpec>> {
        let schemes = self.schemes.iter().take(1).cloned().collect();
        let first = Experiment { schemes, audit: false, claims: Vec::new(), ..self.clone() };
        Ok(first.plan_at_first_draw(catalogue, false)?.into_iter().map(|run| run.spec).collect())
    }

    /// The runs whose beliefs are stored, macro step by macro step: its start (s), and each run with its label.
    ///
    /// # Errors
    /// Names, values or combinations that are not valid, with the place of the entry.
    pub(crate) fn beliefs(&self, catalogue: &Catalogue) -> Result<Vec<Beliefs>> {
        let entry = |(index, entry): (usize, &BeliefEntry)| {
            let of_label = |label: &String| {
                let row = self.schemes.iter().find(|row| row.label == *label).map(|row| row.request.clone());
                let request =
                    row.unwrap_or_else(|| RunRequest { scheme: Some(label.clone()), ..RunRequest::default() });
                let request =
                    RunRequest { case: Some(entry.case.clone()), ..request }.at_macro_step(entry.macro_step_s);
                Ok((label.clone(), request.resolve(catalogue)?))
            };
            match entry.schemes.iter().map(of_label).collect::<Result<Vec<_>>>() {
                Ok(runs) if runs.is_empty() => Err(Error::invalid("schemes", "[]", "labels of schemes, one at least")),
                runs => Ok((entry.at_s, runs?)),
            }
            .map_err(|error| Error::Incompatible(format!("[[beliefs]] {}: {error}", index + 1)))
        };
        self.beliefs.iter().enumerate().map(entry).collect()
    }

    /// Returns the checksum of a plan, full or quick: which runs under which labels, held against which reference.
    /// Where settings must have an event, it is that of the first draw and of the event, which say which settings these
    /// are without a search.
    ///
    /// # Errors
    /// Those of the plan.
    pub(crate) fn sum_of_plan(&self, catalogue: &Catalogue, planned: &[PlannedRun], quick: bool) -> Result<String> {
        match self.events_required().next() {
            Some(_) => Ok(self.sum_at_first_draw(&self.plan_at_first_draw(catalogue, quick)?)),
            None => Ok(self.sum_at_first_draw(planned)),
        }
    }

    /// The same of a plan that is [that of the first draw](Self::plan_at_first_draw) already.
    pub(crate) fn sum_at_first_draw(&self, planned: &[PlannedRun]) -> String {
        let events: String = self.events_required().map(|event| format!("requires {}\n", event.name())).collect();
        let runs = planned.iter().map(|run| format!("{} {}\n", run.id, run.label));
        sha256([self.reference_identity() + "\n", events].into_iter().chain(runs).collect::<String>())
    }

    fn in_file(&self, error: Error) -> Error {
        match error {
            error @ Error::File { .. } => error,
            other => Error::file(&self.path, other),
        }
    }

    /// Counts the runs of a plan without laying it out.
    ///
    /// # Errors
    /// An empty grid, or one of more than [`MOST_PLANNED`] runs.
    pub fn size(&self, quick: bool) -> Result<usize> {
        self.check_options().and_then(|()| self.check_size(quick)).map_err(|error| self.in_file(error))
    }

    /// Lays a plan out part by part, each with the place of its first run: all of it at once where that is allowed,
    /// else a hundredth of what is allowed at most is in memory, and ten thousand runs at once. Claims are about
    /// tables, which so many runs have not.
    ///
    /// # Errors
    /// As [`plan`](Self::plan); the first of each part.
    pub fn parts<'a>(
        &'a self,
        catalogue: &'a Catalogue,
        quick: bool,
        places: Range<usize>,
    ) -> impl Iterator<Item = Result<(usize, Vec<PlannedRun>)>> + 'a {
        // Of each run eight bytes.
        let mut seen: HashSet<u64> = HashSet::new();
        places.clone().step_by(PART).map(move |first| {
            let mut part = || {
                self.check_labels(catalogue)?;
                let runs = self.lay_out(catalogue, quick, true, first..(first + PART).min(places.end))?;
                refuse_duplicates(&runs)?;
                let twice = runs.iter().find(|run| !seen.insert(hash_of(&(&run.id, &run.label))));
                match twice.map(is_there_twice) {
                    Some(error) => Err(error),
                    None => Ok((first, runs)),
                }
            };
            part().map_err(|error| self.in_file(error))
        })
    }

    /// Says which cases have a side of fixed step, and of logs that are replayed where they are longer or shorter than
    /// runs.
    ///
    /// # Errors
    /// As [`plan`](Self::plan).
    pub fn notes(&self, catalogue: &Catalogue, quick: bool) -> Result<BTreeSet<String>> {
        let mut notes = BTreeSet::new();
        let phases = self.phases.list();
        let others = phases.iter().filter(|phase| **phase != 1.0).count();
        for case in
            self.cases.iter().filter_map(|entry| entry.find(catalogue).ok()).filter(|case| case.has_fixed_steps())
        {
            let skipped =
                if others > 0 { format!(", {others} of {} phases are skipped", phases.len()) } else { String::new() };
            notes.insert(format!(
                "case {}: a side takes steps of one length only: runs end with their last whole macro step{skipped}",
                case.name
            ));
        }
        if !self.schemes.iter().any(SchemeRow::has_logs) {
            return Ok(notes);
        }
        for run in self.plan_at_first_draw(catalogue, quick)? {
            let grid = *run.spec.communication_points();
            let row = self.schemes.iter().find(|row| row.label == run.label);
            notes.extend(row.map_or(Ok(Vec::new()), |row| row.replay(&grid, &mut RunRequest::default()))?);
        }
        Ok(notes)
    }

    /// Refuses a label under which something else is looked for: another scheme, or the reference.
    fn check_labels(&self, catalogue: &Catalogue) -> Result<()> {
        for row in &self.schemes {
            let label = row.label.as_str();
            let own = row.request.scheme.as_deref() == Some(label);
            let why = match label {
                "reference" => "is the name of the trace of the reference",
                _ if label.trim() != label => "begins or ends with a blank",
                _ if !own && catalogue.scheme(label).is_ok() => "is the name of another scheme",
                _ => continue,
            };
            return Err(row.misnamed(why));
        }
        Ok(())
    }

    /// Counts the runs of a grid before it is laid out, and refuses one that is empty or beyond all use.
    fn check_size(&self, quick: bool) -> Result<usize> {
        let quick = self.quick.as_ref().filter(|_| quick);
        let phases = quick.and_then(|quick| quick.phases.as_ref()).unwrap_or(&self.phases).count();
        let steps = quick.and_then(|quick| quick.macro_steps_s.as_ref()).unwrap_or(&self.macro_steps_s).list()?.len();
        let mut cells: usize = 0;
        for case in &self.cases {
            let draws = case.draw.as_ref().map_or(1, |draw| draw.settings);
            let parameters = points_of_grid(&case.set).saturating_mul(draws);
            if parameters == 0 {
                return Err(case.place(&empty("one value of each parameter in set, and one of settings in draw")));
            }
            for row in &self.schemes {
                let own = row.macro_steps_s.as_ref().or(case.macro_steps_s.as_ref());
                let steps = own.map_or(Ok(steps), |own| Ok(own.list()?.len()))?;
                let tolerances = row.step_tolerances.as_ref().map_or(1, Vec::len);
                if steps.saturating_mul(tolerances) == 0 {
                    return Err(row.place(&empty("one of macro_steps_s, and one of step_tolerances"), &case.name));
                }
                cells = cells.saturating_add(parameters.saturating_mul(steps).saturating_mul(tolerances));
            }
        }
        match cells.saturating_mul(phases) {
            0 => Err(Error::Incompatible(format!(
                "the grid is empty: {} cases, {} schemes, {cells} combinations of them with parameters and macro steps, \
                 {phases} phases; valid: at least one of each",
                self.cases.len(),
                self.schemes.len()
            ))),
            runs if runs > MOST_PLANNED => Err(Error::Incompatible(format!(
                "the grid has {runs} runs, more than the {MOST_PLANNED} that one experiment may have: split it into several files"
            ))),
            runs => Ok(runs),
        }
    }

    /// Lays the runs at these places of the grid out.
    fn lay_out(
        &self,
        catalogue: &Catalogue,
        quick: bool,
        search: bool,
        places: Range<usize>,
    ) -> Result<Vec<PlannedRun>> {
        let catalogue = &*self.with_own_schemes(catalogue)?;
        let quick = self.quick.as_ref().filter(|_| quick);
        let phases = quick.and_then(|quick| quick.phases.as_ref()).unwrap_or(&self.phases).list();
        let quick_steps = quick.and_then(|quick| quick.macro_steps_s.as_ref());
        let predict_growth = self.claims.iter().any(|claim| only_of(claim.metric.name()) == Some(Only::Claimed));
        let (mut runs, mut named, mut next) = (Vec::new(), Vec::new(), 0);
        for entry in &self.cases {
            let case = entry.find(catalogue).map_err(|error| entry.place(&error))?;
            let same =
                |other: &&(Arc<Case>, &CaseEntry)| other.0.name == case.name && other.0.parameters != case.parameters;
            if let Some((_, other)) = named.iter().find(same) {
                let line = other.line;
                let taken = format!(
                    "that of line {line} is another case of that name; valid: a name of its own in the case file"
                );
                return Err(entry.place(&Error::Incompatible(taken)));
            }
            named.push((case.clone(), entry));
            let case = &self.with_own_reference(&case);
            let rows = self.schemes.iter().map(|row| {
                let own = row.macro_steps_s.as_ref().or(entry.macro_steps_s.as_ref());
                let steps = own.or(quick_steps).unwrap_or(&self.macro_steps_s);
                Ok((row, steps.list()?, row.requests()))
            });
            let rows = rows.collect::<Result<Vec<_>>>()?;
            let of_setting =
                rows.iter().map(|(_, steps, requests)| steps.len() * requests.len() * phases.len()).sum::<usize>();
            let settings = entry.settings(case, search, |parameters| self.any_run(entry, catalogue, case, parameters));
            let settings = settings.map_err(|error| entry.place(&error))?;
            let mut told = false;
            for index in 0..settings.len() {
                if next + of_setting <= places.start || next >= places.end {
                    next += of_setting;
                    continue;
                }
                let setting = settings.at(case, index).map_err(|error| entry.place(&error))?;
                let Setting { parameters, pooled_set, rejected_draws } = &setting;
                let set: Arc<str> = parameters.given().into();
                // A machine that was drawn and is none is a row of the results; one that was written is a slip.
                let written = entry.draw.is_none();
                if let Some(any) = self.any_run(entry, catalogue, case, parameters).ok().filter(|_| written) {
                    any.check_built().map_err(|error| entry.place(&error))?;
                }
                for (row, steps, requests) in &rows {
                    let first = runs.len();
                    let scheme = row.request.scheme.as_deref().unwrap_or_default();
                    let as_one = catalogue.scheme(scheme).is_ok_and(|scheme| scheme.moves_as_one());
                    for (macro_step, request) in
                        steps.iter().flat_map(|step| requests.iter().map(move |of| (*step, of)))
                    {
                        // In parallel over phases, as there may be many; `collect` returns the error of the first.
                        let of_phase = |&phase: &f64| {
                            let mut request = self.request(entry, request, macro_step, phase, as_one);
                            if row.has_logs() {
                                let duration = request.duration_s.unwrap_or(case.defaults.duration_s);
                                let grid = CommunicationGrid::new(macro_step, phase, duration);
                                let replayed = grid.and_then(|grid| row.replay(&grid, &mut request));
                                replayed.map_err(|error| row.place(&self.by_key(row, error), &case.name))?;
                            }
                            let spec = request.resolve_for(catalogue, case, parameters);
                            let mut spec = spec.map_err(|error| row.place(&self.by_key(row, error), &case.name))?;
                            let audit = self.audit && spec.not_auditable().is_none();
                            if audit || predict_growth || self.divide_error {
                                spec = spec.with(|own| {
                                    (own.audit, own.predict_growth) = (audit, predict_growth);
                                    own.divide_error = self.divide_error;
                                })?;
                            }
                            let (label, set, pooled_set) = (row.label.clone(), set.clone(), pooled_set.clone());
                            let rejected_draws = *rejected_draws;
                            Ok(PlannedRun { id: spec.id(), spec, label, set, pooled_set, rejected_draws })
                        };
                        let [from, to] =
                            [places.start, places.end].map(|place| place.saturating_sub(next).min(phases.len()));
                        next += phases.len();
                        runs.extend(phases[from..to].par_iter().map(of_phase).collect::<Result<Vec<_>>>()?);
                    }
                    if let Some(run) = runs.get(first).filter(|_| written && !told) {
                        run.spec.check_built().map_err(|error| row.place(&error, &case.name))?;
                    }
                }
                // Other programs take up to seconds to start: which options go with their sides one setting tells.
                told |= case.waits;
            }
        }
        Ok(runs)
    }

    /// An error about a value of a run, by the key that the file has it under.
    fn by_key(&self, row: &SchemeRow, error: Error) -> Error {
        let Error::InvalidValue { key, found, expected } = error else { return error };
        let key = match key.as_str() {
            "macro_step_s" => "macro_steps_s",
            "phase" => "phases",
            "step_tolerance" if row.step_tolerances.is_some() => "step_tolerances",
            "delivery_up" if row.has_delivery => "delivery.up",
            "delivery_down" if row.has_delivery => "delivery.down",
            "reference_step_s" if self.reference_step_s.is_none() => "reference_step_s of the case",
            own => own,
        };
        Error::InvalidValue { key: key.to_owned(), found, expected }
    }

    /// A run of a case with these parameters, for what all of its runs have in common: the reference.
    fn any_run(&self, entry: &CaseEntry, catalogue: &Catalogue, case: &Arc<Case>, set: &Parameters) -> Result<RunSpec> {
        let request = self.schemes.first().and_then(|row| row.requests().into_iter().next()).unwrap_or_default();
        let duration_s = entry.duration_s.or(self.duration_s);
        RunRequest { scheme: request.scheme, duration_s, ..RunRequest::default() }.resolve_for(catalogue, case, set)
    }

    /// What the file asks of one run: the row goes before the case, the case before the experiment. Where both sides
    /// move as one the mechanics has no steps of its own.
    fn request(&self, entry: &CaseEntry, row: &RunRequest, macro_step: f64, phase: f64, as_one: bool) -> RunRequest {
        let row = row.clone();
        let of_all =
            entry.mechanics_step_s.or(self.mechanics_step_s).filter(|_| row.mechanics_steps.is_none() && !as_one);
        RunRequest {
            macro_step_s: Some(macro_step),
            phase: Some(phase),
            micro_step_s: row.micro_step_s.or(entry.micro_step_s).or(self.micro_step_s),
            mechanics_step_s: row.mechanics_step_s.or(of_all),
            duration_s: row.duration_s.or(entry.duration_s).or(self.duration_s),
            wall_limit_s: row.wall_limit_s.or(self.wall_limit_s),
            ..row
        }
    }
}

/// A row of the grid that has no runs, as if it were not there.
fn empty(wanted: &str) -> Error {
    Error::Incompatible(format!("the grid is empty here; valid: at least {wanted}"))
}

/// A set of parameters of a case, with what its runs say of it.
struct Setting {
    parameters: Parameters,
    /// See [`PlannedRun`].
    pooled_set: Option<Arc<str>>,
    rejected_draws: Option<usize>,
}

/// Every point of the grid of a case with every setting drawn.
struct Settings<'a> {
    set: &'a BTreeMap<String, toml::Value>,
    points: usize,
    drawn: Option<Vec<Drawn>>,
}

impl Settings<'_> {
    fn len(&self) -> usize {
        self.points * self.drawn.as_ref().map_or(1, Vec::len)
    }

    fn at(&self, case: &Case, index: usize) -> Result<Setting> {
        let Some(drawn) = &self.drawn else {
            let parameters = grid_point(case, self.set, index)?;
            return Ok(Setting { parameters, pooled_set: None, rejected_draws: None });
        };
        let point = grid_point(case, self.set, index / drawn.len())?;
        let Drawn { values, rejected } = &drawn[index % drawn.len()];
        let (pooled_set, rejected_draws) = (Some(point.given().into()), *rejected);
        Ok(Setting { parameters: drawn_from(&point, values)?, pooled_set, rejected_draws })
    }
}

/// A point of the grid with what was drawn.
fn drawn_from(point: &Parameters, values: &[(String, String)]) -> Result<Parameters> {
    let mut parameters = point.clone();
    values.iter().try_for_each(|(name, value)| parameters.set(name, value))?;
    Ok(parameters)
}

impl CaseEntry {
    /// Every point of its grid with every setting drawn; `any_run` makes a run of parameters.
    fn settings(
        &self,
        case: &Case,
        search: bool,
        any_run: impl Fn(&Parameters) -> Result<RunSpec> + Sync,
    ) -> Result<Settings<'_>> {
        let points = points_of_grid(&self.set);
        let Some(draw) = &self.draw else { return Ok(Settings { set: &self.set, points, drawn: None }) };
        let point = |index: usize| grid_point(case, &self.set, index);
        let has_event = |event, values: &[(String, String)]| {
            let mut happens = None;
            for index in 0..points {
                let run = any_run(&drawn_from(&point(index)?, values)?)?;
                happens = Reference::has_event(&run, event, StopFlag::never())?;
                if happens != Some(true) {
                    break;
                }
            }
            Ok(happens)
        };
        // Only a required event needs a search.
        let search = if search && draw.requires.is_some() {
            let runs = (0..points).map(|index| Ok(content_key(&any_run(&point(index)?)?)));
            Some(Search { has_event: &has_event, key: runs.collect::<Result<Vec<_>>>()?.concat() })
        } else {
            None
        };
        let drawn = draw.settings(case, &self.set, search.as_ref())?;
        Ok(Settings { set: &self.set, points, drawn: Some(drawn) })
    }
}

/// Refuses a plan that holds one run twice under one label: its rows could not be told apart. Under two labels it is
/// computed once.
fn refuse_duplicates(runs: &[PlannedRun]) -> Result<()> {
    let mut seen = HashSet::with_capacity(runs.len());
    let twice = runs.iter().find(|run| !seen.insert((run.id.as_str(), &run.label)));
    twice.map_or(Ok(()), |run| Err(is_there_twice(run)))
}

fn is_there_twice(run: &PlannedRun) -> Error {
    Error::Incompatible(format!(
        "the plan holds one run twice: `{}` at {:?} of macro_steps_s, phase {:?} are the same in everything that determines a run",
        run.label, run.spec.macro_step, run.spec.phase
    ))
}

fn hash_of(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

//! Single runs of an advice: made once, kept by their ids.

use super::price::Work;
use crate::cache::Cache;
use crate::execution::evaluated;
use crate::results::{self, findings_header};
use crate::stock::columns;
use crate::store::{Record, Store, cells_of};
use rimbench_cases::cases::Case;
use rimbench_cases::runs::{Reference, RunSpec, simulate};
use rimbench_core::cosim::{Bounds, Outcome, StopFlag};
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums::sha256;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What an advice wants to know of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// [`RunSpec::id`].
    pub run_id: String,
    /// H, s.
    pub macro_step: f64,
    /// φ.
    pub phase: f64,
    /// How it ended, by name.
    pub outcome: String,
    /// The same in words.
    pub reason: String,
    /// Rms force error over the reference's peak; none where there is none.
    pub error: Option<f64>,
    /// Whether the model was the mechanics itself.
    pub model_exact: bool,
    /// Its work.
    pub work: Work,
}

impl Probe {
    /// Whether it came to its end within bounds.
    pub fn completed(&self) -> bool {
        self.outcome == Outcome::Completed.name()
    }

    /// Whether it was not run, because case and scheme do not go together.
    pub(super) fn skipped(&self) -> bool {
        self.outcome == Outcome::Skipped { reason: String::new() }.name()
    }

    /// Whether it took longer than it may, which says nothing about its error.
    pub(super) fn timed_out(&self) -> bool {
        self.outcome == Outcome::Timeout { at_s: 0.0 }.name()
    }

    /// Whether it came to its end within bounds and within an error.
    pub(super) fn meets(&self, error: f64) -> bool {
        self.completed() && self.error.is_some_and(|own| own <= error)
    }
}

/// The metric by which a run is judged.
pub const METRIC: &str = "force_error_rms_of_peak";

/// Runs specs of one case, parameters and duration against one reference, and remembers them.
pub(super) struct Prober<'a> {
    reference: &'a Reference,
    bounds: Bounds,
    store: Option<Store>,
    /// What has been asked for by now, by run id.
    known: Mutex<HashMap<String, Probe>>,
    stop: StopFlag<'a>,
    /// Runs made now.
    pub(super) computed: AtomicUsize,
    /// Runs found in the store.
    pub(super) reused: AtomicUsize,
}

impl<'a> Prober<'a> {
    /// Opens the store of these sources and this case; one that cannot be opened costs time, not results.
    pub(super) fn new(spec: &RunSpec, reference: &'a Reference, cache: &Cache, stop: StopFlag<'a>) -> Result<Self> {
        let (name, sources) = store_of(&spec.case);
        // Nothing tells when code from outside changes.
        let kept = !spec.case.from_outside;
        let store = kept
            .then(|| Store::open(&cache.folder().join("advice").join(name), "advice", &sources, columns()).ok())
            .flatten();
        let (computed, reused) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let known = Mutex::default();
        Ok(Prober { reference, bounds: reference.bounds(spec)?, store, known, stop, computed, reused })
    }

    /// Makes a run, or reads what came of it. What the actuator does inside macro steps is not looked at, which takes longer than many
    /// a run.
    pub(super) fn probe(&self, spec: &RunSpec) -> Result<Probe> {
        let id = spec.id();
        if let Some(known) = self.known().get(&id) {
            return Ok(known.clone());
        }
        let probe = match self.stored(&id, spec) {
            Some(probe) => {
                self.reused.fetch_add(1, Ordering::Relaxed);
                probe
            }
            None => self.made(&id, spec)?,
        };
        self.known().insert(id, probe.clone());
        Ok(probe)
    }

    /// Runs that have been asked for, stored ones included: the same on every machine.
    pub(super) fn asked(&self) -> usize {
        self.known().len()
    }

    fn known(&self) -> MutexGuard<'_, HashMap<String, Probe>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stored(&self, id: &str, spec: &RunSpec) -> Option<Probe> {
        let store = self.store.as_ref().filter(|store| store.holds(id, spec.wall_limit))?;
        read(spec, store.get(id)?)
    }

    fn made(&self, id: &str, spec: &RunSpec) -> Result<Probe> {
        let run = evaluated(spec, &self.bounds, self.reference, simulate, self.stop)?;
        if matches!(run.outcome, Outcome::Stopped { .. }) {
            return Err(Error::Stopped);
        }
        let record = results::record(id, spec, &run, String::new(), None);
        if let Some(store) = &self.store {
            // A record that is lost is computed again.
            let _ = store.append(&record);
        }
        self.computed.fetch_add(1, Ordering::Relaxed);
        read(spec, &record)
            .ok_or_else(|| Error::Incompatible(format!("run {id} has no findings: a defect of rimbench")))
    }
}

/// Name of the folder of the records of a case, and what they rest on: other sources, metrics or times are other records.
fn store_of(case: &Case) -> (String, String) {
    let [core, contact] = rimbench_core::SOURCES;
    let sources = [core, contact, rimbench_cases::SOURCES];
    let key =
        format!("{sources:?} {} {:?} {:?} {:?}", case.name, case.defaults, case.recorded_columns(), findings_header());
    (sha256(&key)[..16].to_owned(), key)
}

/// What a record says; none if it is no row of findings.
fn read(spec: &RunSpec, record: &Record) -> Option<Probe> {
    let row = cells_of(&record.findings)?;
    let names = findings_header();
    let text = |name: &str| row.get(names.iter().position(|known| *known == name)?);
    let number = |name: &str| text(name)?.parse::<f64>().ok();
    let (outcome, why) = (text("outcome")?.to_owned(), text("reason")?);
    let at = number("outcome_at_s").map(|at| format!(" at {at:.4} s")).unwrap_or_default();
    let why = if why.is_empty() { String::new() } else { format!(": {why}") };
    Some(Probe {
        run_id: record.run_id.clone(),
        macro_step: spec.macro_step,
        phase: spec.phase,
        reason: format!("{outcome}{at}{why}"),
        outcome,
        error: number(METRIC).filter(|error| error.is_finite()),
        model_exact: text("model_exact")? == "true",
        work: Work {
            exchanges: number("exchanges")?,
            mechanics_solves: number("mechanics_micro_steps")?,
            micro_steps: number("actuator_micro_steps")?,
            model_solves: number("scheme_lcp_solves")? + number("scheme_parametric_steps")?,
        },
    })
}

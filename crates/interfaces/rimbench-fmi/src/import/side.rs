//! A subsystem that is an FMU.

use super::host::{Ask, Host};
use super::probing::{ProbeErrors, SideNotes};
use crate::last_words::tell_once;
use crate::model_parts::ModelSize;
use rimbench_cases::cases::{JumpWatch, check_step_of_model, model_against_outputs};
use rimbench_core::cosim::{Capabilities, OutputRates, Ports, Subsystem, SubsystemCounters, subsystem_methods};
use rimbench_core::error::{Cause, Failure};
use rimbench_core::interface_model::ReducedInterfaceModel;
use rimbench_core::name::Name;
use std::borrow::Cow;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// By how much an H from rates may differ from a symmetric one.
const UNSYMMETRIC: f64 = 0.05;
/// The change of a velocity below which how well it was foreseen is not judged, m/s.
const STANDS: f64 = 1e-6;

/// What a mechanics was probed for, until its next step shows how good that is.
#[derive(Debug, Clone, Default)]
struct Foreseen {
    /// The step that it is for, s; 0 if there is none.
    step: f64,
    w: Vec<f64>,
    a: Vec<f64>,
    h: Vec<f64>,
}

impl Foreseen {
    /// By how much the velocities that a step under forces `u` has come to are not those foreseen, of what they have
    /// moved.
    fn miss(&self, u: &[f64], came: &[f64]) -> f64 {
        let (mut miss, mut moved) = (0.0_f64, STANDS);
        for (row, came) in came.iter().enumerate() {
            let of_force: f64 = self.h[row * u.len()..].iter().zip(u).map(|(h, u)| h * u).sum();
            let change = self.step * (self.a[row] + of_force);
            miss = miss.max((self.w[row] + change - came).abs());
            moved = moved.max(change.abs()).max((came - self.w[row]).abs());
        }
        (miss / moved).min(1.0)
    }
}

/// What of an interface the FMU itself has.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    /// Rows whose position is the integral of the velocity, with where it starts, m.
    pub(super) integrals: Vec<(usize, f64)>,
    /// Which of the inputs it takes.
    pub(super) taken: Vec<usize>,
}

/// Capabilities of a foreign side beyond outputs and steps.
#[derive(Debug, Clone, Default)]
pub(super) struct Offers {
    pub(super) rates: bool,
    pub(super) copies: bool,
    pub(super) work: bool,
    /// Its rates are found by probing, and told with their error.
    pub(super) probed: bool,
    /// What its outputs' rates say is its interface model: a mechanics that has no other.
    pub(super) smooth: bool,
    /// The shortest step of which it has an interface model, s.
    pub(super) model_from_s: f64,
    /// Why it has neither rates nor an interface model, where more is to be said than that.
    pub(super) without: Option<Cow<'static, str>>,
    /// Why it gives no copies, likewise.
    pub(super) without_copies: Option<String>,
    pub(super) observables: Vec<Name>,
}

/// One copy of its state.
pub(super) struct ImportedSide {
    host: Arc<Mutex<Box<dyn Host>>>,
    id: u32,
    ports: Ports,
    offers: Offers,
    /// Its integrals are those of this copy.
    shape: Shape,
    /// Whether it has been told with which inputs it begins.
    begun: bool,
    /// An empty interface model.
    model: Option<ReducedInterfaceModel>,
    /// The size of the one that it tells itself; none: `model` is what the rates of its outputs say.
    told: Option<ModelSize>,
    input: Vec<f64>,
    output: Vec<f64>,
    /// Outputs that the last call has told, and the inputs that they are for.
    y: Vec<f64>,
    u: Vec<f64>,
    known: bool,
    /// Where its last step has ended, s; none before anything was asked.
    time: Option<f64>,
    /// The longest step that it has taken, s.
    longest: Option<f64>,
    /// By how much what was probed may be wrong.
    errors: ProbeErrors,
    foreseen: Foreseen,
    jumps: JumpWatch,
    /// The largest that the diagonal of H, and an eigenvalue of it, have been where it follows from rates, 1/kg.
    diagonal: Vec<f64>,
    largest_mobility: f64,
    /// What was refused where nothing can fail.
    failed: Option<Failure>,
    counters: SubsystemCounters,
}

impl ImportedSide {
    /// Takes what drives it; what is to be said of it afterwards is noted under its file.
    pub(super) fn new(
        host: Box<dyn Host>,
        (file, notes): (&Path, &SideNotes),
        ports: Ports,
        offers: Offers,
        shape: Shape,
    ) -> ImportedSide {
        let (y, u) = (vec![0.0; ports.outputs.len()], vec![0.0; ports.inputs.len()]);
        ImportedSide {
            host: Arc::new(Mutex::new(host)),
            id: 0,
            jumps: JumpWatch::of(&ports),
            ports,
            model: None,
            told: None,
            offers,
            shape,
            begun: false,
            input: Vec::new(),
            output: Vec::new(),
            y,
            u,
            known: false,
            time: None,
            longest: None,
            errors: ProbeErrors::of(file, notes),
            foreseen: Foreseen::default(),
            diagonal: Vec::new(),
            largest_mobility: 0.0,
            failed: None,
            counters: SubsystemCounters::default(),
        }
    }

    /// Gives it the interface model that it says itself: it is asked once, for a step (s), for what of that never
    /// changes.
    ///
    /// # Errors
    /// What it says instead.
    pub(super) fn give_model(&mut self, step: f64, size: ModelSize) -> Result<(), String> {
        let (mut filled, mut empty) = (size.empty(), size.empty());
        filled.plastic.resize(if size.plastic { size.contacts } else { 0 }, false);
        self.fill(step, size, &mut filled)?;
        (empty.stabilisation, empty.restitution) = (filled.stabilisation, filled.restitution);
        empty.spring = filled.spring;
        if filled.restitution > 0.0 {
            empty.discretisation_approach = vec![0.0; size.contacts];
        }
        empty.plastic = filled.plastic;
        empty.friction.copy_from_slice(&filled.friction);
        (empty.stiction, empty.tangential_restitution) = (filled.stiction, filled.tangential_restitution);
        (self.model, self.told) = (Some(empty), Some(size));
        Ok(())
    }

    /// Gives a mechanics the interface model that is what the rates of its outputs say, with so many rows.
    pub(super) fn give_smooth_model(&mut self, interface: usize) {
        let empty = self.model.insert(ReducedInterfaceModel::zeros(0, interface));
        empty.smooth = true;
    }

    /// Asks for its outputs while it is being initialised, whatever they depend on.
    pub(super) fn initial_outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.known = false;
        self.outputs(u, y)?;
        // Nothing of a run has been asked so far.
        (self.known, self.time) = (false, None);
        Ok(())
    }

    /// Ends its initialisation, with the inputs that the other side gives by then.
    pub(super) fn begin(&mut self, u: &[f64]) -> Result<(), Failure> {
        (self.begun, self.known) = (true, false);
        self.input.clear();
        self.put(u);
        self.ask(Ask::Begin).map_err(Failure::reported)
    }

    /// Appends what it takes of the inputs to what it is asked with.
    fn put(&mut self, u: &[f64]) {
        if self.shape.taken.len() == u.len() {
            self.input.extend_from_slice(u);
            return;
        }
        self.input.extend(self.shape.taken.iter().map(|at| u[*at]));
    }

    /// Takes outputs that were told; positions that it does not have stay what they are.
    fn take(&mut self) -> Result<(), String> {
        let rows = self.ports.outputs.len() / 2;
        let Shape { integrals, .. } = &self.shape;
        if self.output.len() + integrals.len() != self.y.len() {
            return Err(format!(
                "it tells {} outputs instead of {}",
                self.output.len(),
                self.y.len() - integrals.len()
            ));
        }
        if integrals.is_empty() {
            self.y.copy_from_slice(&self.output);
            return Ok(());
        }
        let mut told = self.output.iter();
        for (at, y) in self.y.iter_mut().enumerate() {
            match integrals.iter().find(|(row, _)| *row == at && at < rows) {
                Some((_, position)) => *y = *position,
                None => *y = told.next().copied().unwrap_or(f64::NAN),
            }
        }
        Ok(())
    }

    /// Rates and gains of what the FMU has, filled up to those of the ports: an integral moves with its velocity, and
    /// no output follows an input that is not taken.
    fn fill_up_rates(&mut self) {
        let (p, n, rows) = (self.ports.outputs.len(), self.ports.inputs.len(), self.ports.outputs.len() / 2);
        let Shape { integrals, taken } = &self.shape;
        let columns = taken.len();
        if integrals.is_empty() && columns == n {
            return;
        }
        let told = std::mem::take(&mut self.output);
        let has: Vec<Option<usize>> = (0..p)
            .scan(0, |next, at| {
                let own = integrals.iter().any(|(row, _)| *row == at && at < rows);
                *next += usize::from(!own);
                Some((!own).then_some(*next - 1))
            })
            .collect();
        let given = p - integrals.len();
        let (rates, gains) = told.split_at(given);
        let (feedthrough, rate_gain) = gains.split_at(given * columns);
        let filled = &mut self.output;
        filled.extend(has.iter().enumerate().map(|(at, own)| own.map_or_else(|| self.y[at + rows], |own| rates[own])));
        for part in [feedthrough, rate_gain] {
            for (at, own) in has.iter().enumerate() {
                for column in 0..n {
                    let taken = taken.iter().position(|taken| *taken == column);
                    // The rate of an integral follows an input as its velocity does.
                    let entry = match (own, taken) {
                        (Some(own), Some(column)) => part[own * columns + column],
                        (None, Some(column)) if std::ptr::eq(part, rate_gain) => {
                            has[at + rows].map_or(0.0, |own| feedthrough[own * columns + column])
                        }
                        _ => 0.0,
                    };
                    filled.push(entry);
                }
            }
        }
    }

    fn ask(&mut self, ask: Ask) -> Result<(), String> {
        let mut host = self.host.lock().unwrap_or_else(PoisonError::into_inner);
        host.ask(ask, self.id, &self.input, &mut self.output)
    }

    fn fill(&mut self, h: f64, size: ModelSize, model: &mut ReducedInterfaceModel) -> Result<(), String> {
        self.input.clear();
        self.input.push(h);
        self.ask(Ask::Model)?;
        size.read(&self.output, model)?;
        model.mechanics_step = h / model.own_steps as f64;
        model.check().map_err(|what| format!("its interface model: {what}"))?;
        if self.known && !self.ports.direct_feedthrough {
            model_against_outputs(model, &self.y)?;
        }
        Ok(())
    }

    /// Asks how the outputs move; one that is probed takes steps of at most `longest` (s) for it.
    fn ask_rates(&mut self, t: f64, u: &[f64], longest: f64) -> Result<(), Failure> {
        self.check()?;
        self.input.clear();
        self.input.push(t);
        if self.offers.probed {
            self.input.push(longest);
        }
        self.put(u);
        self.ask(Ask::Rates).map_err(Failure::reported)?;
        if self.offers.probed {
            let error = self.output.pop().unwrap_or(f64::NAN);
            // With the inputs as they are and each of them changed both ways; of an actuator the same from two step
            // sizes.
            let sizes = if self.offers.smooth { 1 } else { 2 };
            self.counters.micro_steps += sizes * (1 + 2 * self.shape.taken.len() as u64);
            if !self.offers.smooth {
                self.errors.note(error);
            }
            if self.output.iter().any(|number| !number.is_finite()) {
                return Err(Failure::reported("probing it for how its outputs move gives numbers that are not finite"));
            }
        }
        self.fill_up_rates();
        Ok(())
    }

    /// The interface model that follows from how the velocities move: `H = ∂v̇/∂λ`, `a = v̇ − H λ`, with the forces λ
    /// of the last step.
    fn fill_smooth(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<(), Failure> {
        let u = std::mem::take(&mut self.u);
        let asked = self.ask_rates(self.time.unwrap_or(0.0), &u, h);
        self.u = u;
        asked?;
        let m = model.position.len();
        // Of positions and velocities by forces.
        let (rates, gains) = (&self.output[..2 * m], &self.output[2 * m + 2 * m * m..]);
        self.diagonal.resize(m, 0.0);
        for (row, largest) in self.diagonal.iter_mut().enumerate() {
            *largest = largest.max(gains[(m + row) * m + row].abs());
        }
        for row in 0..m {
            for column in 0..m {
                // To round-off it is symmetric anyway.
                let [one, other] = [(row, column), (column, row)].map(|(row, column)| gains[(m + row) * m + column]);
                if (one - other).abs() > UNSYMMETRIC * (self.diagonal[row] * self.diagonal[column]).sqrt() {
                    let what = format!(
                        "its velocities say that H is not symmetric: {one:e} and {other:e} for rows {row} and {column}"
                    );
                    return Err(Failure::reported(what));
                }
                model.h[row * m + column] = 0.5 * (one + other);
            }
        }
        self.largest_mobility = model.clear_round_off(self.largest_mobility);
        for row in 0..m {
            let of_force: f64 = model.h[row * m..].iter().zip(&self.u).map(|(h, u)| h * u).sum();
            model.a[row] = rates[m + row] - of_force;
        }
        let u = std::mem::take(&mut self.u);
        let known = self.know_outputs(&u);
        self.u = u;
        known?;
        model.position.copy_from_slice(&self.y[..m]);
        model.w.copy_from_slice(&self.y[m..]);
        model.mechanics_step = h;
        if self.offers.probed {
            let Foreseen { step, w, a, h: entries } = &mut self.foreseen;
            *step = h;
            for (kept, now) in [(w, &model.w), (a, &model.a), (entries, &model.h)] {
                kept.clone_from(now);
            }
        }
        model.check().map_err(|what| Failure::reported(format!("the smooth model that its velocities make: {what}")))
    }

    /// Asks for the outputs with these inputs, unless they are known.
    fn know_outputs(&mut self, u: &[f64]) -> Result<(), Failure> {
        self.check()?;
        self.time.get_or_insert(0.0);
        if !(self.known && (!self.ports.direct_feedthrough || self.u == u)) {
            self.input.clear();
            self.put(u);
            self.ask(Ask::Outputs).and_then(|()| self.take()).map_err(Failure::reported)?;
            self.known = true;
        }
        Ok(())
    }

    /// Says that something is not offered, and why, where that is known.
    fn without(&self) -> Result<bool, Failure> {
        self.offers.without.clone().map_or(Ok(false), |what| Err(Cause::NotOffered { what }.into()))
    }

    /// What could not be said when it happened.
    fn check(&mut self) -> Result<(), Failure> {
        self.failed.take().map_or(Ok(()), Err)
    }
}

impl Subsystem for ImportedSide {
    subsystem_methods!(ports capabilities counters);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.know_outputs(u)?;
        self.u.copy_from_slice(u);
        y.copy_from_slice(&self.y);
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.check()?;
        if !self.begun {
            self.begin(u)?;
        }
        let rows = self.ports.outputs.len() / 2;
        if !self.shape.integrals.is_empty() {
            self.know_outputs(u)?;
            self.shape.integrals.iter_mut().for_each(|(row, position)| *position += 0.5 * h * self.y[rows + *row]);
        }
        if self.known {
            self.jumps.begin(&self.y);
        }
        self.input.clear();
        self.input.extend([t, h]);
        self.put(u);
        (self.known, self.time) = (false, Some(t + h));
        self.longest = Some(self.longest.map_or(h, |longest| longest.max(h)));
        self.ask(Ask::Step).and_then(|()| self.take()).map_err(Failure::reported)?;
        for (row, position) in &mut self.shape.integrals {
            *position += 0.5 * h * self.y[rows + *row];
            self.y[*row] = *position;
        }
        self.jumps.see(h, &self.y, &self.ports).map_err(|jump| Failure::reported(self.errors.of_file(&jump)))?;
        // The forecast is for one step of the length foreseen: of several own steps for the first.
        if (h - self.foreseen.step).abs() <= 1e-9 * h {
            self.errors.note(self.foreseen.miss(u, &self.y[rows..]));
        }
        self.foreseen.step = 0.0;
        self.u.copy_from_slice(u);
        self.known = true;
        self.counters.micro_steps += 1;
        Ok(())
    }

    fn try_clone(&self) -> Result<Box<dyn Subsystem>, Failure> {
        Ok(Box::new(self.copy()?))
    }
}

impl ImportedSide {
    /// Copies it with its state.
    pub(super) fn copy(&self) -> Result<ImportedSide, Failure> {
        if let Some(why) = &self.offers.without_copies {
            return Err(Cause::NotOffered { what: why.clone().into() }.into());
        }
        let mut number = Vec::new();
        let mut host = self.host.lock().unwrap_or_else(PoisonError::into_inner);
        let asked = self.offers.copies && host.ask(Ask::Copy, self.id, &[], &mut number).is_ok();
        let id = number.first().filter(|_| asked).ok_or(Cause::NotCopied)?;
        Ok(ImportedSide {
            host: Arc::clone(&self.host),
            id: *id as u32,
            ports: self.ports.clone(),
            offers: self.offers.clone(),
            shape: self.shape.clone(),
            begun: self.begun,
            model: self.model.clone(),
            told: self.told,
            input: Vec::new(),
            output: Vec::new(),
            y: self.y.clone(),
            u: self.u.clone(),
            known: self.known,
            time: self.time,
            longest: self.longest,
            errors: self.errors.of_a_copy(),
            foreseen: self.foreseen.clone(),
            jumps: self.jumps.clone(),
            diagonal: self.diagonal.clone(),
            largest_mobility: self.largest_mobility,
            failed: self.failed.clone(),
            counters: self.counters,
        })
    }
}

impl Capabilities for ImportedSide {
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel> {
        self.model.clone()
    }

    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        if self.model.is_none() {
            return self.without();
        }
        check_step_of_model(h, self.offers.model_from_s)?;
        match self.told {
            Some(size) => self.fill(h, size, model).map_err(Failure::reported)?,
            None => self.fill_smooth(h, model)?,
        }
        Ok(true)
    }

    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        if !self.offers.rates {
            return self.without();
        }
        if self.offers.probed && self.time.is_none() {
            // Whether it offers them is asked with inputs that are none, and a model that is probed there may break.
            // Nobody can take this for an answer.
            rates.rate.fill(f64::NAN);
            return Ok(true);
        }
        // Nobody says for which step: no longer than its own.
        self.ask_rates(t, u, self.longest.unwrap_or(f64::INFINITY))?;
        let (p, entries) = (rates.rate.len(), rates.feedthrough.len());
        rates.rate.copy_from_slice(&self.output[..p]);
        rates.feedthrough.copy_from_slice(&self.output[p..p + entries]);
        rates.rate_gain.copy_from_slice(&self.output[p + entries..p + 2 * entries]);
        Ok(true)
    }

    fn observables(&mut self) -> &[Name] {
        &self.offers.observables
    }

    fn observe(&mut self, h: f64, row: &mut [f64]) {
        if row.is_empty() {
            return;
        }
        self.input.clear();
        self.input.push(h);
        match self.ask(Ask::Observe) {
            Ok(()) => {
                row.copy_from_slice(&self.output);
                if let Some(at) = row.iter().position(|value| !value.is_finite()) {
                    let found = format!("observed `{}` is {}", self.offers.observables[at], row[at]);
                    tell_once(&format!("note: {}\n", self.errors.of_file(&found)));
                }
            }
            Err(message) => {
                row.fill(f64::NAN);
                self.failed = Some(Failure::reported(message));
            }
        }
    }

    fn interface_work(&mut self) -> Option<f64> {
        if !self.offers.work {
            return None;
        }
        self.input.clear();
        match self.ask(Ask::Work) {
            Ok(()) => self.output.first().copied(),
            Err(message) => {
                self.failed = Some(Failure::reported(message));
                Some(f64::NAN)
            }
        }
    }
}

impl Drop for ImportedSide {
    fn drop(&mut self) {
        self.input.clear();
        if Arc::strong_count(&self.host) > 1 {
            let _ = self.ask(Ask::Drop);
        } else if self.ask(Ask::Heard).is_ok()
            && let [count, text @ ..] = &*self.output
            && *count > 0.0
        {
            let bytes: Vec<u8> = text.iter().map(|byte| *byte as u8).collect();
            self.errors.warned(*count as u64, &String::from_utf8_lossy(&bytes));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_core::cosim::{Port, Quantity};

    /// Notes how long the steps may be by which it would be probed.
    struct Noted(Arc<Mutex<Vec<f64>>>);

    impl Host for Noted {
        fn ask(&mut self, ask: Ask, _: u32, input: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
            output.clear();
            if ask == Ask::Rates {
                self.0.lock().unwrap().push(input[1]);
                // Two rates, twice two entries, and the error.
                output.resize(7, 0.0);
            } else {
                output.resize(2, 0.0);
            }
            Ok(())
        }
    }

    #[test]
    fn a_side_is_probed_by_no_longer_steps_than_it_takes() {
        let port = |name: &'static str, quantity| Port::new(name, quantity);
        let ports = Ports {
            inputs: vec![port("f", Quantity::Force)],
            outputs: vec![port("x", Quantity::Position), port("v", Quantity::Velocity)],
            direct_feedthrough: false,
        };
        let noted = Arc::new(Mutex::new(Vec::new()));
        let offers = Offers { rates: true, probed: true, smooth: true, ..Offers::default() };
        let shape = Shape { taken: vec![0], ..Shape::default() };
        let file = (Path::new("some.fmu"), &SideNotes::default());
        let mut side = ImportedSide::new(Box::new(Noted(Arc::clone(&noted))), file, ports, offers, shape);
        side.give_smooth_model(1);
        let mut model = side.empty_interface_model().unwrap();
        side.interface_model(1e-4, &mut model).unwrap();
        let mut rates = OutputRates::zeros(2, 1);
        side.output_rates(0.0, &[0.0], &mut rates).unwrap();
        for h in [2e-4, 1e-4] {
            side.step(0.0, &[0.0], h).unwrap();
        }
        side.output_rates(3e-4, &[0.0], &mut rates).unwrap();
        assert_eq!(*noted.lock().unwrap(), [1e-4, f64::INFINITY, 2e-4]);
    }
}

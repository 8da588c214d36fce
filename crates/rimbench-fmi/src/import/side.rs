//! A subsystem that is an FMU.

use super::host::{Ask, Host};
use super::probing::ProbeErrors;
use rimbench_core::contact_law::ContactSpring;
use rimbench_core::cosim::{Capabilities, OutputRates, Ports, Subsystem, SubsystemCounters, subsystem_methods};
use rimbench_core::error::{Cause, Failure};
use rimbench_core::friction::{ContactState, Stiction};
use rimbench_core::interface_model::{AccelerationJumps, ReducedInterfaceModel};
use rimbench_core::name::Name;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// What it can do besides.
#[derive(Debug, Clone, Default)]
pub(super) struct Offers {
    pub(super) rates: bool,
    pub(super) copies: bool,
    pub(super) work: bool,
    /// Its rates are found by probing, and told with their error.
    pub(super) probed: bool,
    /// What its outputs' rates say is its interface model: a mechanics that has no other.
    pub(super) smooth: bool,
    /// Why it has neither rates nor an interface model, where more is to be said than that.
    pub(super) without: Option<&'static str>,
    pub(super) observables: Vec<Name>,
}

/// How large an interface model is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ModelSize {
    pub(super) contacts: usize,
    pub(super) interface: usize,
    /// Whether contacts have tangential rows.
    pub(super) friction: bool,
    /// Most kinks that may lie ahead at once.
    pub(super) kinks: usize,
}

impl ModelSize {
    fn empty(self) -> ReducedInterfaceModel {
        let ModelSize { contacts, interface, friction, kinks } = self;
        let mut empty = if friction {
            ReducedInterfaceModel::zeros_with_friction(&vec![0.0; contacts], interface)
        } else {
            ReducedInterfaceModel::zeros(contacts, interface)
        };
        empty.acceleration_jumps = AccelerationJumps::with_room(kinks, empty.interface_start() + interface);
        empty
    }
}

/// One copy of its state.
pub(super) struct ImportedSide {
    host: Arc<Mutex<Box<dyn Host>>>,
    id: u32,
    ports: Ports,
    offers: Offers,
    /// An empty interface model.
    model: Option<ReducedInterfaceModel>,
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
    /// What was refused where nothing can fail.
    failed: Option<Failure>,
    counters: SubsystemCounters,
}

impl ImportedSide {
    /// Takes what drives it.
    pub(super) fn new(host: Box<dyn Host>, ports: Ports, offers: Offers) -> ImportedSide {
        let (y, u) = (vec![0.0; ports.outputs.len()], vec![0.0; ports.inputs.len()]);
        ImportedSide {
            host: Arc::new(Mutex::new(host)),
            id: 0,
            ports,
            model: None,
            offers,
            input: Vec::new(),
            output: Vec::new(),
            y,
            u,
            known: false,
            time: None,
            longest: None,
            errors: ProbeErrors::default(),
            failed: None,
            counters: SubsystemCounters::default(),
        }
    }

    /// Takes what drives one that says itself, when it is asked for its interface model for a step (s), what of that never changes.
    ///
    /// # Errors
    /// What it says instead.
    pub(super) fn with_model(self, step: f64, size: ModelSize) -> Result<Self, String> {
        let mut side = self;
        let mut filled = size.empty();
        side.fill(step, &mut filled)?;
        let mut empty = size.empty();
        (empty.stabilisation, empty.restitution) = (filled.stabilisation, filled.restitution);
        empty.spring = filled.spring;
        if filled.restitution > 0.0 {
            (empty.discretisation_approach, empty.plastic) = (vec![0.0; size.contacts], vec![false; size.contacts]);
        }
        empty.friction.copy_from_slice(&filled.friction);
        (empty.stiction, empty.tangential_restitution) = (filled.stiction, filled.tangential_restitution);
        side.model = Some(empty);
        Ok(side)
    }

    /// Takes what drives a mechanics whose interface model is what the rates of its outputs say, with so many rows.
    pub(super) fn with_smooth_model(self, interface: usize) -> Self {
        let mut side = self;
        let empty = side.model.insert(ReducedInterfaceModel::zeros(0, interface));
        (empty.smooth, empty.acceleration_jumps.unknown) = (true, true);
        side
    }

    /// Takes what drives one that may be probed; the errors are told as those of `file`.
    pub(super) fn of_file(self, file: &Path) -> Self {
        let mut side = self;
        side.errors = ProbeErrors::of(file);
        side
    }

    fn ask(&mut self, ask: Ask) -> Result<(), String> {
        let mut host = self.host.lock().unwrap_or_else(PoisonError::into_inner);
        host.ask(ask, self.id, &self.input, &mut self.output)
    }

    fn fill(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<(), String> {
        self.input.clear();
        self.input.push(h);
        if model.acceleration_jumps.requested {
            self.input.push(1.0);
        }
        self.ask(Ask::Model)?;
        let mut rest = self.output.as_slice();
        let mut next = |count: usize| {
            let taken = rest.split_off(..count);
            taken.ok_or_else(|| "its interface model has too few numbers".to_owned())
        };
        let (n, contacts, interface) = (model.a.len(), model.gap.len(), model.position.len());
        model.h.copy_from_slice(next(n * n)?);
        model.a.copy_from_slice(next(n)?);
        model.w.copy_from_slice(next(n)?);
        model.position.copy_from_slice(next(interface)?);
        model.gap.copy_from_slice(next(contacts)?);
        let own = next(contacts)?;
        if !model.discretisation_approach.is_empty() {
            for ((approach, plastic), own) in model.discretisation_approach.iter_mut().zip(&mut model.plastic).zip(own)
            {
                (*approach, *plastic) = (own.abs(), own.is_sign_negative());
            }
        }
        model.stabilisation = next(1)?[0];
        model.restitution = next(1)?[0];
        let (stiffness, damping) = (next(1)?[0], next(1)?[0]);
        model.spring = (stiffness > 0.0).then_some(ContactSpring { stiffness, damping });
        model.at_bound.iter_mut().zip(next(contacts)?).for_each(|(at_bound, truth)| *at_bound = *truth != 0.0);
        if model.has_friction() {
            model.friction.copy_from_slice(next(contacts)?);
            let (at_rest, in_motion) = (next(1)?[0], next(1)?[0]);
            model.stiction = (at_rest > 0.0).then_some(Stiction { at_rest, in_motion });
            model.tangential_restitution = next(1)?[0];
            for states in [&mut model.states, &mut model.solved_states] {
                for (state, number) in states.iter_mut().zip(next(contacts)?) {
                    let known = ContactState::of_number(*number);
                    *state = known.ok_or_else(|| {
                        format!(
                            "its interface model has a contact in state {number}; valid: 0 to {}",
                            ContactState::ALL.len() - 1
                        )
                    })?;
                }
            }
        }
        if model.acceleration_jumps.requested && model.acceleration_jumps.places() > 0 {
            let (places, count) = (model.acceleration_jumps.places(), next(1)?[0]);
            let (times, jumps) = (next(places)?, next(places * n)?);
            if !(0.0..=places as f64).contains(&count) {
                return Err(format!("its interface model has {count} kinks ahead, and room for {places}"));
            }
            model.acceleration_jumps.clear();
            for (time, jumps) in times.iter().zip(jumps.chunks_exact(n)).take(count as usize) {
                model.acceleration_jumps.add(*time).copy_from_slice(jumps);
            }
        }
        model.mechanics_step = h;
        model.check().map_err(|what| format!("its interface model: {what}"))
    }

    /// Asks how the outputs move; one that is probed takes steps of at most `longest` (s) for it.
    fn ask_rates(&mut self, t: f64, u: &[f64], longest: f64) -> Result<(), Failure> {
        self.check()?;
        self.input.clear();
        self.input.push(t);
        if self.offers.probed {
            self.input.push(longest);
        }
        self.input.extend_from_slice(u);
        self.ask(Ask::Rates).map_err(Failure::reported)?;
        if self.offers.probed {
            let error = self.output.pop().unwrap_or(f64::NAN);
            self.errors.note(error);
            // The same from two step sizes, with the inputs as they are and each of them changed both ways.
            self.counters.micro_steps += 2 * (1 + 2 * u.len() as u64);
            if self.output.iter().any(|number| !number.is_finite()) {
                return Err(Failure::reported("probing it for how its outputs move gives numbers that are not finite"));
            }
        }
        Ok(())
    }

    /// The interface model that follows from how the velocities move: `H = ∂v̇/∂λ`, `a = v̇ − H λ`, with the forces λ of the last step.
    fn fill_smooth(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<(), Failure> {
        let u = std::mem::take(&mut self.u);
        let asked = self.ask_rates(self.time.unwrap_or(0.0), &u, h);
        self.u = u;
        asked?;
        let m = model.position.len();
        // Of positions and velocities by forces.
        let (rates, gains) = (&self.output[..2 * m], &self.output[2 * m + 2 * m * m..]);
        for row in 0..m {
            let mut free = rates[m + row];
            for column in 0..m {
                // To round-off it is symmetric anyway.
                let [one, other] = [(row, column), (column, row)].map(|(row, column)| gains[(m + row) * m + column]);
                let entry = 0.5 * (one + other);
                model.h[row * m + column] = entry;
                free -= entry * self.u[column];
            }
            model.a[row] = free;
        }
        let u = std::mem::take(&mut self.u);
        let known = self.know_outputs(&u);
        self.u = u;
        known?;
        model.position.copy_from_slice(&self.y[..m]);
        model.w.copy_from_slice(&self.y[m..]);
        model.mechanics_step = h;
        Ok(())
    }

    /// Asks for the outputs with these inputs, unless they are known.
    fn know_outputs(&mut self, u: &[f64]) -> Result<(), Failure> {
        self.check()?;
        self.time.get_or_insert(0.0);
        if !(self.known && (!self.ports.direct_feedthrough || self.u == u)) {
            self.input.clear();
            self.input.extend_from_slice(u);
            self.ask(Ask::Outputs).map_err(Failure::reported)?;
            self.y.copy_from_slice(&self.output);
            self.known = true;
        }
        Ok(())
    }

    /// Says that something is not offered, and why, where that is known.
    fn without(&self) -> Result<bool, Failure> {
        self.offers.without.map_or(Ok(false), |what| Err(Cause::NotOffered { what }.into()))
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
        self.input.clear();
        self.input.extend([t, h]);
        self.input.extend_from_slice(u);
        (self.known, self.time) = (false, Some(t + h));
        self.longest = Some(self.longest.map_or(h, |longest| longest.max(h)));
        self.ask(Ask::Step).map_err(Failure::reported)?;
        self.y.copy_from_slice(&self.output);
        self.u.copy_from_slice(u);
        self.known = true;
        self.counters.micro_steps += 1;
        Ok(())
    }

    fn try_clone(&self) -> Option<Box<dyn Subsystem>> {
        if !self.offers.copies {
            return None;
        }
        let mut number = Vec::new();
        self.host.lock().unwrap_or_else(PoisonError::into_inner).ask(Ask::Copy, self.id, &[], &mut number).ok()?;
        Some(Box::new(ImportedSide {
            host: Arc::clone(&self.host),
            id: *number.first()? as u32,
            ports: self.ports.clone(),
            offers: self.offers.clone(),
            model: self.model.clone(),
            input: Vec::new(),
            output: Vec::new(),
            y: self.y.clone(),
            u: self.u.clone(),
            known: self.known,
            time: self.time,
            longest: self.longest,
            errors: self.errors.of_a_copy(),
            failed: self.failed.clone(),
            counters: self.counters,
        }))
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
        if self.offers.smooth {
            return self.fill_smooth(h, model).map(|()| true);
        }
        self.fill(h, model).map(|()| true).map_err(Failure::reported)
    }

    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        if !self.offers.rates {
            return self.without();
        }
        if self.offers.probed && self.time.is_none() {
            // Whether it offers them is asked with inputs that are none, and a model that is probed there may break. Nobody can take this
            // for an answer.
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
            Ok(()) => row.copy_from_slice(&self.output),
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
        if Arc::strong_count(&self.host) > 1 {
            let _ = self.ask(Ask::Drop);
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
        let side = ImportedSide::new(Box::new(Noted(Arc::clone(&noted))), ports, offers);
        let mut side = side.with_smooth_model(1);
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

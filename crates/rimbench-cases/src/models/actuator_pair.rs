//! Two actuators as one side of a co-simulation with an interface of two rows.

use rimbench_core::cosim::{
    Capabilities, EnergyAccount, LineForces, MacroStep, OutputRates, Port, Ports, Quantity, SecondOrder, Subsystem,
    SubsystemCounters, TransmissionLines,
};
use rimbench_core::error::Failure;
use rimbench_core::name::Name;

/// Names of what one of the two actuators exchanges and shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActuatorNames {
    /// Length in, for example `front_length_m`.
    pub position: &'static str,
    /// Its rate in.
    pub velocity: &'static str,
    /// Force out.
    pub force: &'static str,
    /// One per observable of the actuator, in its order.
    pub observables: &'static [&'static str],
}

/// Two force-producing actuators side by side; they feel each other only through the mechanics.
///
/// ```text
/// u = [s₁ s₂ w₁ w₂]   →   y = [F₁ F₂]
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ActuatorPair<A> {
    units: [A; 2],
    ports: Ports,
    observables: Vec<Name>,
    /// Of one of them.
    own_rates: OutputRates,
    /// Of each of them.
    own_lines: [LineForces; 2],
}

impl<A: Subsystem> ActuatorPair<A> {
    /// Joins two actuators with inputs (length, velocity) and one force as output.
    pub fn new(units: [A; 2], names: [ActuatorNames; 2]) -> Self {
        debug_assert!(units.iter().all(|unit| unit.ports().inputs.len() == 2 && unit.ports().outputs.len() == 1));
        let both = |quantity, name: fn(&ActuatorNames) -> &'static str| {
            names.each_ref().map(|own| Port::new(name(own), quantity))
        };
        let inputs =
            [both(Quantity::Position, |own| own.position), both(Quantity::Velocity, |own| own.velocity)].concat();
        let outputs = both(Quantity::Force, |own| own.force).to_vec();
        let direct_feedthrough = units.iter().any(|unit| unit.ports().direct_feedthrough);
        ActuatorPair {
            ports: Ports { inputs, outputs, direct_feedthrough },
            observables: names.iter().flat_map(|own| own.observables).copied().map(Name::from).collect(),
            own_rates: OutputRates::zeros(1, 2),
            own_lines: [LineForces::new(1, 0, 0.0), LineForces::new(1, 0, 0.0)],
            units,
        }
    }
}

impl<A: Subsystem + Clone + 'static> Subsystem for ActuatorPair<A> {
    fn ports(&self) -> &Ports {
        &self.ports
    }

    #[inline]
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        for (i, unit) in self.units.iter_mut().enumerate() {
            unit.outputs(&[u[i], u[2 + i]], &mut y[i..=i])?;
        }
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        for (i, unit) in self.units.iter_mut().enumerate() {
            unit.step(t, &[u[i], u[2 + i]], h)?;
        }
        Ok(())
    }

    fn capabilities(&mut self) -> &mut dyn Capabilities {
        self
    }

    fn try_clone(&self) -> Option<Box<dyn Subsystem>> {
        Some(Box::new(self.clone()))
    }

    /// Both take every micro step; it counts once.
    fn counters(&self) -> SubsystemCounters {
        self.units[0].counters()
    }
}

impl<A: Subsystem> Capabilities for ActuatorPair<A> {
    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        rates.feedthrough.fill(0.0);
        rates.rate_gain.fill(0.0);
        for (i, unit) in self.units.iter_mut().enumerate() {
            if !unit.capabilities().output_rates(t, &[u[i], u[2 + i]], &mut self.own_rates)? {
                return Ok(false);
            }
            let own = &self.own_rates;
            rates.rate[i] = own.rate[0];
            for (column, j) in [(i, 0), (2 + i, 1)] {
                rates.feedthrough[4 * i + column] = own.feedthrough[j];
                rates.rate_gain[4 * i + column] = own.rate_gain[j];
            }
        }
        Ok(true)
    }

    fn use_second_order(&mut self, rule: SecondOrder) -> Result<(), &'static str> {
        self.units.iter_mut().try_for_each(|unit| unit.capabilities().use_second_order(rule))
    }

    fn oil_lines(&mut self) -> Option<&mut dyn TransmissionLines> {
        let both = self.units.iter_mut().all(|unit| unit.capabilities().oil_lines().is_some());
        if both { Some(self) } else { None }
    }

    fn observables(&mut self) -> &[Name] {
        &self.observables
    }

    fn observe(&mut self, h: f64, row: &mut [f64]) {
        let mut rest = row;
        for unit in &mut self.units {
            let unit = unit.capabilities();
            let (own, others) = rest.split_at_mut(unit.observables().len());
            unit.observe(h, own);
            rest = others;
        }
    }

    fn energy_account(&mut self) -> Option<EnergyAccount> {
        let [first, second] = self.units.each_mut().map(|unit| unit.capabilities().energy_account());
        let (a, b) = (first?, second?);
        Some(EnergyAccount {
            stored: a.stored + b.stored,
            interface: a.interface + b.interface,
            contact: a.contact + b.contact,
            viscous: a.viscous + b.viscous,
            pump: a.pump + b.pump,
            valve: a.valve + b.valve,
            tank: a.tank + b.tank,
            integration: a.integration + b.integration,
            friction: a.friction + b.friction,
        })
    }
}

/// Where both have volumes of oil.
impl<A: Subsystem> TransmissionLines for ActuatorPair<A> {
    fn lay(&mut self, micro_steps: usize, smoothing: f64) {
        self.own_lines = [(); 2].map(|()| LineForces::new(1, micro_steps, smoothing));
        let lines = self.units.iter_mut().filter_map(|unit| unit.capabilities().oil_lines());
        lines.for_each(|lines| lines.lay(micro_steps, smoothing));
    }

    fn exchange(&mut self, step: MacroStep, micro_steps: usize, u: &[f64], forces: &mut LineForces) {
        for (i, (unit, own)) in self.units.iter_mut().zip(&mut self.own_lines).enumerate() {
            if let Some(lines) = unit.capabilities().oil_lines() {
                lines.exchange(step, micro_steps, &[u[i], u[2 + i]], own);
            }
        }
        let [first, second] = &self.own_lines;
        forces.begin(&[first.impedance()[0], second.impedance()[0]]);
        (0..micro_steps).for_each(|j| forces.push(&[first.at(j)[0], second.at(j)[0]]));
    }
}

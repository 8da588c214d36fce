//! Several actuators as one side of a co-simulation, each with a row of the interface.

use rimbench_core::cosim::{
    Capabilities, EnergyAccount, LineForces, MacroStep, OutputRates, Port, Ports, Quantity, SecondOrder, Subsystem,
    SubsystemCounters, TransmissionLines, subsystem_methods,
};
use rimbench_core::error::Failure;
use rimbench_core::name::Name;

/// Names of what one of the actuators exchanges and shows.
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

/// Force-producing actuators side by side; they feel each other only through the mechanics.
///
/// ```text
/// u = [s₁ … s_N w₁ … w_N]   →   y = [F₁ … F_N]
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ActuatorGroup<A> {
    units: Vec<A>,
    ports: Ports,
    observables: Vec<Name>,
    /// Of one of them.
    own_rates: OutputRates,
    /// Of each of them.
    own_lines: Vec<LineForces>,
    /// One number of each.
    row: Vec<f64>,
}

impl<A: Subsystem> ActuatorGroup<A> {
    /// Joins actuators with inputs (length, velocity) and one force as output.
    pub fn new(units: Vec<A>, names: &[ActuatorNames]) -> Self {
        debug_assert_eq!(units.len(), names.len());
        debug_assert!(units.iter().all(|unit| unit.ports().inputs.len() == 2 && unit.ports().outputs.len() == 1));
        let each = |quantity, name: fn(&ActuatorNames) -> &'static str| -> Vec<Port> {
            names.iter().map(|own| Port::new(name(own), quantity)).collect()
        };
        let inputs =
            [each(Quantity::Position, |own| own.position), each(Quantity::Velocity, |own| own.velocity)].concat();
        let outputs = each(Quantity::Force, |own| own.force);
        let direct_feedthrough = units.iter().any(|unit| unit.ports().direct_feedthrough);
        ActuatorGroup {
            ports: Ports { inputs, outputs, direct_feedthrough },
            observables: names.iter().flat_map(|own| own.observables).copied().map(Name::from).collect(),
            own_rates: OutputRates::zeros(1, 2),
            row: vec![0.0; units.len()],
            own_lines: units.iter().map(|_| LineForces::new(1, 0, 0.0)).collect(),
            units,
        }
    }
}

impl<A: Subsystem + Clone + 'static> Subsystem for ActuatorGroup<A> {
    subsystem_methods!(ports capabilities clone);

    #[inline]
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        let n = self.units.len();
        for (i, unit) in self.units.iter_mut().enumerate() {
            unit.outputs(&[u[i], u[n + i]], &mut y[i..=i])?;
        }
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let n = self.units.len();
        for (i, unit) in self.units.iter_mut().enumerate() {
            unit.step(t, &[u[i], u[n + i]], h)?;
        }
        Ok(())
    }

    /// All take every micro step; it counts once.
    fn counters(&self) -> SubsystemCounters {
        self.units[0].counters()
    }
}

impl<A: Subsystem> Capabilities for ActuatorGroup<A> {
    fn actuator_of_row(&mut self, row: usize) -> Option<&mut dyn Subsystem> {
        self.units.get_mut(row).map(|unit| unit as &mut dyn Subsystem)
    }

    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        rates.feedthrough.fill(0.0);
        rates.rate_gain.fill(0.0);
        let n = self.units.len();
        for (i, unit) in self.units.iter_mut().enumerate() {
            if !unit.capabilities().output_rates(t, &[u[i], u[n + i]], &mut self.own_rates)? {
                return Ok(false);
            }
            let own = &self.own_rates;
            rates.rate[i] = own.rate[0];
            for (column, j) in [(i, 0), (n + i, 1)] {
                rates.feedthrough[2 * n * i + column] = own.feedthrough[j];
                rates.rate_gain[2 * n * i + column] = own.rate_gain[j];
            }
        }
        Ok(true)
    }

    fn use_second_order(&mut self, rule: SecondOrder) -> Result<(), &'static str> {
        self.units.iter_mut().try_for_each(|unit| unit.capabilities().use_second_order(rule))
    }

    fn oil_lines(&mut self) -> Option<&mut dyn TransmissionLines> {
        let all = self.units.iter_mut().all(|unit| unit.capabilities().oil_lines().is_some());
        if all { Some(self) } else { None }
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
        let accounts = self.units.iter_mut().map(|unit| unit.capabilities().energy_account());
        accounts.reduce(|sum, one| {
            let (a, b) = (sum?, one?);
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
        })?
    }
}

/// Where all have volumes of oil.
impl<A: Subsystem> TransmissionLines for ActuatorGroup<A> {
    fn lay(&mut self, micro_steps: usize, smoothing: f64) {
        self.own_lines.fill_with(|| LineForces::new(1, micro_steps, smoothing));
        let lines = self.units.iter_mut().filter_map(|unit| unit.capabilities().oil_lines());
        lines.for_each(|lines| lines.lay(micro_steps, smoothing));
    }

    fn exchange(&mut self, step: MacroStep, micro_steps: usize, u: &[f64], forces: &mut LineForces) {
        let n = self.units.len();
        for (i, (unit, own)) in self.units.iter_mut().zip(&mut self.own_lines).enumerate() {
            if let Some(lines) = unit.capabilities().oil_lines() {
                lines.exchange(step, micro_steps, &[u[i], u[n + i]], own);
            }
        }
        let row = &mut self.row;
        row.iter_mut().zip(&self.own_lines).for_each(|(to, own)| *to = own.impedance()[0]);
        forces.begin(row);
        for j in 0..micro_steps {
            row.iter_mut().zip(&self.own_lines).for_each(|(to, own)| *to = own.at(j)[0]);
            forces.push(row);
        }
    }
}

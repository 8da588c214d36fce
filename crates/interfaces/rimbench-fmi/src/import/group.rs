//! The actuator side of a case file: one subsystem from outside, or several, each with rows of its own.

use super::side::ImportedSide;
use rimbench_core::cosim::{Capabilities, OutputRates, Ports, Subsystem, SubsystemCounters, subsystem_methods};
use rimbench_core::error::Failure;
use rimbench_core::name::Name;

/// One of them, with room for what it takes and puts out.
struct Unit {
    rows: Vec<usize>,
    side: ImportedSide,
    u: Vec<f64>,
    y: Vec<f64>,
    rates: OutputRates,
}

impl Unit {
    fn take(&mut self, u: &[f64]) {
        let n = u.len() / 2;
        let motion = self.rows.iter().copied().chain(self.rows.iter().map(|row| n + row));
        self.u.iter_mut().zip(motion).for_each(|(own, at)| *own = u[at]);
    }

    fn put(&self, y: &mut [f64]) {
        self.rows.iter().zip(&self.y).for_each(|(row, own)| y[*row] = *own);
    }
}

/// Actuators side by side: `u = [s₁ … s_N w₁ … w_N] → y = [F₁ … F_N]`, of which each takes and puts out its rows.
pub(super) struct Actuators {
    units: Vec<Unit>,
    ports: Ports,
    observables: Vec<Name>,
}

impl Actuators {
    /// Takes sides with the rows that they have.
    pub(super) fn new(sides: impl Iterator<Item = (Vec<usize>, ImportedSide)>, ports: &Ports) -> Self {
        let unit = |(rows, side): (Vec<usize>, ImportedSide)| {
            let n = rows.len();
            let room = |length| vec![0.0; length];
            Unit { rows, side, u: room(2 * n), y: room(n), rates: OutputRates::zeros(n, 2 * n) }
        };
        let mut units: Vec<Unit> = sides.map(unit).collect();
        let observables = units.iter_mut().flat_map(|unit| unit.side.observables().to_vec()).collect();
        Actuators { units, ports: ports.clone(), observables }
    }

    /// Does what [`ImportedSide::initial_outputs`] does with each.
    pub(super) fn initial_outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.units.iter_mut().try_for_each(|unit| {
            unit.take(u);
            unit.side.initial_outputs(&unit.u, &mut unit.y)?;
            unit.put(y);
            Ok(())
        })
    }

    /// Does what [`ImportedSide::begin`] does with each.
    pub(super) fn begin(&mut self, u: &[f64]) -> Result<(), Failure> {
        self.units.iter_mut().try_for_each(|unit| {
            unit.take(u);
            unit.side.begin(&unit.u)
        })
    }
}

impl Subsystem for Actuators {
    subsystem_methods!(ports capabilities);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.units.iter_mut().try_for_each(|unit| {
            unit.take(u);
            unit.side.outputs(&unit.u, &mut unit.y)?;
            unit.put(y);
            Ok(())
        })
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.units.iter_mut().try_for_each(|unit| {
            unit.take(u);
            unit.side.step(t, &unit.u, h)
        })
    }

    /// All take every micro step, which counts once; in bonds with micro steps of their own the first one's.
    fn counters(&self) -> SubsystemCounters {
        self.units[0].side.counters()
    }

    fn try_clone(&self) -> Result<Box<dyn Subsystem>, Failure> {
        let copies = self.units.iter().map(|unit| Ok((unit.rows.clone(), unit.side.copy()?)));
        let copies: Vec<_> = copies.collect::<Result<_, Failure>>()?;
        Ok(Box::new(Actuators::new(copies.into_iter(), &self.ports)))
    }
}

impl Capabilities for Actuators {
    fn actuator_of_row(&mut self, row: usize) -> Option<&mut dyn Subsystem> {
        let unit = self.units.iter_mut().find(|unit| unit.rows.contains(&row))?;
        Some(&mut unit.side)
    }

    fn rows_beside(&mut self, row: usize) -> &[usize] {
        self.units.iter().find(|unit| unit.rows.contains(&row)).map_or(&[], |unit| &unit.rows)
    }

    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        rates.feedthrough.fill(0.0);
        rates.rate_gain.fill(0.0);
        let n = u.len() / 2;
        for unit in &mut self.units {
            unit.take(u);
            let own = &mut unit.rates;
            if !unit.side.output_rates(t, &unit.u, own)? {
                return Ok(false);
            }
            let columns = 2 * unit.rows.len();
            for (i, row) in unit.rows.iter().enumerate() {
                rates.rate[*row] = own.rate[i];
                for (j, column) in unit.rows.iter().copied().chain(unit.rows.iter().map(|row| n + row)).enumerate() {
                    rates.feedthrough[2 * n * row + column] = own.feedthrough[columns * i + j];
                    rates.rate_gain[2 * n * row + column] = own.rate_gain[columns * i + j];
                }
            }
        }
        Ok(true)
    }

    fn observables(&mut self) -> &[Name] {
        &self.observables
    }

    fn observe(&mut self, h: f64, row: &mut [f64]) {
        let mut rest = row;
        for unit in &mut self.units {
            let (own, others) = rest.split_at_mut(unit.side.observables().len());
            unit.side.observe(h, own);
            rest = others;
        }
    }

    fn interface_work(&mut self) -> Option<f64> {
        self.units.iter_mut().map(|unit| unit.side.interface_work()).sum()
    }
}

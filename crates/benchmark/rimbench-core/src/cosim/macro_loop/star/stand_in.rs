//! The actuator side of one bond of a star: its own actuators, and stand-ins for those of other bonds.

use crate::cosim::energy_account::EnergyAccount;
use crate::cosim::output_rates::OutputRates;
use crate::cosim::subsystem::Capabilities;
use crate::cosim::subsystem::{Subsystem, subsystem_methods};
use crate::error::{Cause, Failure};

/// How the force of another actuator moves with the motion of its row, and the motion that it belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Law {
    pub(super) rate: f64,
    pub(super) feedthrough: [f64; 2],
    pub(super) rate_gain: [f64; 2],
    pub(super) at: [f64; 2],
}

impl Law {
    fn moved(&self, gain: [f64; 2], u: [f64; 2]) -> f64 {
        (0..2).map(|i| gain[i] * (u[i] - self.at[i])).sum()
    }
}

/// What a bond knows of an actuator of another bond, from the last time on that it was told.
///
/// ```text
/// y_j = profile of j, as far as it is told        else F_j + d_j + D_j (u − u_k),  ḋ_j = r_j + R_j (u − u_k)
/// ```
/// `ḋ_j` is taken with the motion at the start of a micro step.
#[derive(Debug, Clone)]
pub(super) struct StandIn {
    force: f64,
    law: Option<Law>,
    drift: f64,
    rate: f64,
    /// Start and length of the parts of the profile, s, and their forces.
    start: f64,
    length: f64,
    profile: Vec<f64>,
}

impl StandIn {
    /// Makes room for a profile of so many parts.
    pub(super) fn new(parts: usize) -> Self {
        let profile = Vec::with_capacity(parts);
        StandIn { force: 0.0, law: None, drift: 0.0, rate: 0.0, start: 0.0, length: 1.0, profile }
    }

    /// Begins anew, with a force and perhaps a law.
    pub(super) fn know(&mut self, force: f64, law: Option<Law>) {
        (self.force, self.law, self.drift) = (force, law, 0.0);
        self.profile.clear();
    }

    /// Is told of a profile from `start` (s) on, in parts of `length` (s).
    pub(super) fn hear(&mut self, start: f64, length: f64, profile: impl Iterator<Item = f64>) {
        (self.start, self.length) = (start, length);
        self.profile.extend(profile);
    }

    fn output(&mut self, now: f64, u: [f64; 2]) -> f64 {
        if let Some(law) = &self.law {
            self.rate = law.rate + law.moved(law.rate_gain, u);
        }
        // A part of the slack of times that are sums, so that each finds its own part.
        let told = self.profile.get(((now - self.start) / self.length + 1e-6) as usize).copied();
        let moved = || self.law.map_or(0.0, |law| law.moved(law.feedthrough, u));
        told.unwrap_or_else(|| self.force + self.drift + moved())
    }

    fn step(&mut self, h: f64) {
        if self.law.is_some() {
            self.drift += h * self.rate;
        }
    }
}

/// Why a side has no bonds.
pub(super) const NOT_APART: &str = "the actuator side is one subsystem, which cannot be divided among bonds";

/// The actuator side as one bond has it: `u = [s₁ … s_N w₁ … w_N] → y = [F₁ … F_N]`, as any other.
pub(super) struct BondSide<'a> {
    /// All actuators.
    pub(super) whole: &'a mut (dyn Subsystem + 'a),
    /// Of each row: none where the actuator is its own.
    pub(super) others: &'a mut [Option<StandIn>],
    pub(super) now: &'a mut f64,
    pub(super) room: &'a mut Room,
}

/// Lends the actuator of one row.
#[inline]
pub(super) fn actuator_of<'a>(
    whole: &'a mut (dyn Subsystem + '_),
    row: usize,
) -> Result<&'a mut dyn Subsystem, Failure> {
    whole.capabilities().actuator_of_row(row).ok_or_else(|| Cause::NotOffered { what: NOT_APART.into() }.into())
}

/// Room for what actuators of several rows take and put out.
#[derive(Debug, Clone)]
pub(super) struct Room {
    /// Rows of the actuator of each row; none at all where each has one.
    rows: Vec<Vec<usize>>,
    u: Vec<f64>,
    y: Vec<f64>,
}

impl Room {
    /// For the actuators of `n` rows.
    pub(super) fn new(n: usize, whole: &mut (dyn Subsystem + '_)) -> Self {
        let rows = (0..n).map(|row| match whole.capabilities().rows_beside(row) {
            [] => vec![row],
            rows => rows.to_vec(),
        });
        let rows: Vec<_> = rows.collect();
        let several = rows.iter().any(|rows| rows.len() > 1);
        Room { rows: if several { rows } else { Vec::new() }, u: Vec::with_capacity(2 * n), y: Vec::with_capacity(n) }
    }

    /// What the actuator of a row takes of the motion of all, at its first row.
    #[cold]
    fn take(&mut self, row: usize, u: &[f64]) -> Option<&[f64]> {
        let (rows, n) = (&self.rows[row], u.len() / 2);
        self.u.clear();
        self.u.extend(rows.iter().map(|row| u[*row]).chain(rows.iter().map(|row| u[n + row])));
        (rows[0] == row).then_some(&self.u)
    }

    /// Asks the actuator that has `row` for its forces; one of several rows is asked at its first.
    #[inline]
    pub(super) fn ask(
        &mut self,
        whole: &mut (dyn Subsystem + '_),
        row: usize,
        u: &[f64],
        y: &mut [f64],
    ) -> Result<(), Failure> {
        let actuator = actuator_of(whole, row)?;
        if self.rows.is_empty() {
            return actuator.outputs(&[u[row], u[u.len() / 2 + row]], &mut y[row..=row]);
        }
        self.ask_all(actuator, row, u, y)
    }

    #[cold]
    fn ask_all(&mut self, of: &mut dyn Subsystem, row: usize, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        if self.take(row, u).is_some() {
            self.y.resize(self.rows[row].len(), 0.0);
            of.outputs(&self.u, &mut self.y)?;
            self.rows[row].iter().zip(&self.y).for_each(|(row, own)| y[*row] = *own);
        }
        Ok(())
    }
}

impl Subsystem for BondSide<'_> {
    subsystem_methods!(capabilities no_clone);

    fn ports(&self) -> &crate::cosim::Ports {
        self.whole.ports()
    }

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        let n = self.others.len();
        for (i, other) in self.others.iter_mut().enumerate() {
            match other {
                None => self.room.ask(self.whole, i, u, y)?,
                Some(other) => y[i] = other.output(*self.now, [u[i], u[n + i]]),
            }
        }
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let n = self.others.len();
        for (i, other) in self.others.iter_mut().enumerate() {
            match other {
                None => {
                    let actuator = actuator_of(self.whole, i)?;
                    if self.room.rows.is_empty() {
                        actuator.step(t, &[u[i], u[n + i]], h)?;
                    } else if let Some(u) = self.room.take(i, u) {
                        actuator.step(t, u, h)?;
                    }
                }
                Some(other) => other.step(h),
            }
        }
        *self.now = t + h;
        Ok(())
    }

    fn counters(&self) -> crate::cosim::SubsystemCounters {
        self.whole.counters()
    }
}

impl Capabilities for BondSide<'_> {
    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        let known = self.whole.capabilities().output_rates(t, u, rates)?;
        let inputs = u.len();
        for (i, _) in self.others.iter().enumerate().filter(|(_, other)| other.is_some()) {
            rates.rate[i] = 0.0;
            rates.feedthrough[i * inputs..(i + 1) * inputs].fill(0.0);
            rates.rate_gain[i * inputs..(i + 1) * inputs].fill(0.0);
        }
        Ok(known)
    }

    fn energy_account(&mut self) -> Option<EnergyAccount> {
        self.whole.capabilities().energy_account()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::Ports;

    #[test]
    fn what_stands_in_for_an_actuator_has_its_profile_as_far_as_it_is_told_and_moves_by_its_law_from_there_on() {
        let mut other = StandIn::new(2);
        let law = Law { rate: 2.0, feedthrough: [0.5, -1.0], rate_gain: [4.0, 8.0], at: [1.0, 2.0] };
        other.know(3.0, Some(law));
        // By D 0.25 − 0.25 N and, over 0.1 s, by (2 + 2 + 2) N/s.
        let u = [1.5, 2.25];
        assert_eq!(other.output(0.0, u), 3.0);
        other.step(0.1);
        assert_eq!(other.output(0.1, [1.5, 2.0]), 3.0 + 0.1 * 6.0 + 0.25);
        other.hear(0.2, 0.1, [7.0, 8.0].into_iter());
        assert_eq!([0.2, 0.3, 0.4].map(|now| other.output(now, [1.0, 2.25])), [7.0, 8.0, 3.0 + 0.1 * 6.0 - 0.25]);
    }

    /// An actuator of the first of three rows and one of the other two: `F = s + 10 w`, with rates that are all 1.
    struct Two {
        ports: Ports,
        asked: usize,
    }

    fn two() -> Two {
        Two { ports: Ports { inputs: Vec::new(), outputs: Vec::new(), direct_feedthrough: true }, asked: 0 }
    }

    impl Subsystem for Two {
        subsystem_methods!(ports capabilities no_counters no_clone);

        fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
            self.asked += 1;
            let (positions, velocities) = u.split_at(y.len());
            y.iter_mut().zip(positions.iter().zip(velocities)).for_each(|(y, (s, w))| *y = s + 10.0 * w);
            Ok(())
        }

        fn step(&mut self, _: f64, _: &[f64], _: f64) -> Result<(), Failure> {
            Ok(())
        }
    }

    impl Capabilities for Two {
        fn actuator_of_row(&mut self, _: usize) -> Option<&mut dyn Subsystem> {
            Some(self)
        }

        fn rows_beside(&mut self, row: usize) -> &[usize] {
            if row > 0 { &[1, 2] } else { &[] }
        }

        fn output_rates(&mut self, _: f64, _: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
            [&mut rates.rate, &mut rates.feedthrough, &mut rates.rate_gain].into_iter().for_each(|of| of.fill(1.0));
            Ok(true)
        }
    }

    #[test]
    fn an_actuator_of_several_rows_is_asked_once_and_takes_the_motion_of_its_own() {
        let (mut whole, mut y) = (two(), [0.0; 3]);
        let mut room = Room::new(3, &mut whole);
        (0..3).for_each(|row| room.ask(&mut whole, row, &[0.5, 1.5, 2.5, 1.0, 2.0, 3.0], &mut y).unwrap());
        assert_eq!((y, whole.asked), ([10.5, 21.5, 32.5], 2));
    }

    #[test]
    fn a_bond_has_the_rates_of_its_own_rows_and_none_of_others() {
        let (mut whole, mut others, mut now) = (two(), [None, Some(StandIn::new(0)), None], 0.0);
        let mut room = Room { rows: Vec::new(), u: Vec::new(), y: Vec::new() };
        let mut side = BondSide { whole: &mut whole, others: &mut others, now: &mut now, room: &mut room };
        let mut rates = OutputRates::zeros(3, 6);
        assert!(side.output_rates(0.0, &[0.0; 6], &mut rates).unwrap());
        let of_rows = [[1.0; 6], [0.0; 6], [1.0; 6]].concat();
        assert_eq!(rates, OutputRates { rate: vec![1.0, 0.0, 1.0], feedthrough: of_rows.clone(), rate_gain: of_rows });
    }
}

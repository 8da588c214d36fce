//! What both sides know of each other where samples are late: the samples kept until they arrive, and what is made of
//! them then.

use super::communication_grid::{MacroStep, MicroStep};
use super::coupling_scheme::{CouplingScheme, Sample};
use super::delivery::{Delivery, ForceBridge, LateRule};
use super::mass_learner::MassLearner;
use super::output_history::OutputHistory;
use super::output_rates::OutputRates;
use super::ports::Ports;
use super::setup::Setup;
use super::side::{PerSide, Side};
use super::subsystem::Subsystem;
use super::work_meter::WorkMeter;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;

/// Samples on their way, in a ring by macro step, and which of them have arrived. Nothing is allocated after the start.
#[derive(Debug, Clone)]
pub(crate) struct LateSamples {
    pub(crate) rule: LateRule,
    bridge: ForceBridge,
    /// By the side that sends: the newest sample that has arrived, by communication point.
    newest: PerSide<Vec<Option<usize>>>,
    ring: Vec<Kept>,
    /// The actuator's outputs at the start, which the mechanics knows.
    initial: Vec<f64>,
    /// Mean force over a coarse step.
    mean: Vec<f64>,
    /// By age from 1: `Σ ā·a`, `Σ ā·ā` and `Σ a·a` of free accelerations that many macro steps apart, within what
    /// samples age.
    accelerations: Vec<[f64; 3]>,
    /// Means and their times of the newest two macro steps whose forces have arrived, the newest first.
    arrived: [(f64, Vec<f64>); 2],
}

/// What is kept of a communication point, and of the macro step that starts there.
#[derive(Debug, Clone)]
pub(crate) struct Kept {
    pub(crate) step: MacroStep,
    pub(crate) time: f64,
    pub(crate) micro_step: f64,
    pub(crate) mechanics_steps: usize,
    /// Outputs of the mechanics.
    pub(crate) motion: Vec<f64>,
    pub(crate) model: Option<ReducedInterfaceModel>,
    /// Outputs of the actuator, with the motion that it knew.
    pub(crate) force: Vec<f64>,
    /// Outputs of the actuator by micro step.
    history: OutputHistory,
    /// Forces for the mechanics by its own step.
    returned: OutputHistory,
    /// Outputs, inputs and rates of the actuator at the end.
    outputs: Vec<f64>,
    inputs: Vec<f64>,
    rates: OutputRates,
}

impl LateSamples {
    pub(crate) fn new(
        delivery: &Delivery,
        setup: &Setup,
        ports: PerSide<&Ports>,
        model: Option<&ReducedInterfaceModel>,
    ) -> Self {
        let points = setup.grid.macro_steps() + 2;
        let newest = PerSide {
            mechanics: delivery.up.newest(Side::Mechanics, points),
            actuator: delivery.down.newest(Side::Actuator, points),
        };
        let ages = Side::BOTH.map(|side| {
            let ages = newest[side].iter().enumerate().map(|(k, newest)| k - newest.unwrap_or(0));
            ages.max().unwrap_or(0)
        });
        let (forces, motions) = (ports.actuator.outputs.len(), ports.mechanics.outputs.len());
        let full = MacroStep { index: 0, start: 0.0, length: setup.grid.macro_step() };
        let kept = Kept {
            step: full,
            time: 0.0,
            micro_step: 0.0,
            mechanics_steps: 1,
            motion: vec![0.0; motions],
            model: model.cloned(),
            force: vec![0.0; forces],
            history: OutputHistory::new(forces, setup.actuator_steps(full)),
            returned: OutputHistory::new(forces, setup.own_mechanics_steps(full)),
            outputs: vec![0.0; forces],
            inputs: vec![0.0; motions],
            rates: OutputRates::zeros(forces, motions),
        };
        LateSamples {
            rule: delivery.late,
            bridge: delivery.bridge,
            newest,
            // The present macro step, the sample at its end, and all that are still waited for.
            ring: vec![kept; ages[0].max(ages[1]) + 2],
            initial: vec![0.0; forces],
            mean: vec![0.0; forces],
            accelerations: vec![[0.0; 3]; ages[0]],
            arrived: [(f64::NAN, vec![0.0; forces]), (f64::NAN, vec![0.0; forces])],
        }
    }

    /// Returns the newest sample of the mechanics at communication point `k`; the first is known from the start.
    pub(crate) fn newest_motion(&self, k: usize) -> usize {
        self.newest.mechanics[k].unwrap_or(0)
    }

    /// Returns the newest sample of the actuator's outputs at communication point `k`; the first is known from the
    /// start.
    pub(crate) fn newest_force(&self, k: usize) -> usize {
        self.newest.actuator[k].unwrap_or(0)
    }

    /// Returns what is kept of communication point `m`.
    pub(crate) fn kept(&self, m: usize) -> &Kept {
        &self.ring[m % self.ring.len()]
    }

    pub(crate) fn kept_mut(&mut self, m: usize) -> &mut Kept {
        let length = self.ring.len();
        &mut self.ring[m % length]
    }

    /// Keeps the fresh sample of the mechanics at the start of `step`, for which both sides have steps of their own: δ
    /// of the actuator in s, the mechanics' by number.
    pub(crate) fn keep(
        &mut self,
        step: MacroStep,
        (micro_step, mechanics_steps): (f64, usize),
        motion: &[f64],
        model: Option<&ReducedInterfaceModel>,
    ) {
        let kept = self.kept_mut(step.index);
        (kept.step, kept.time) = (step, step.start);
        (kept.micro_step, kept.mechanics_steps) = (micro_step, mechanics_steps);
        kept.motion.copy_from_slice(motion);
        if let (Some(own), Some(model)) = (&mut kept.model, model) {
            own.copy_from(model);
        }
        kept.returned.clear();
    }

    /// Keeps what the actuator put out at the start of macro step `k`.
    pub(crate) fn keep_force(&mut self, k: usize, force: &[f64]) {
        if k == 0 {
            self.initial.copy_from_slice(force);
        }
        self.kept_mut(k).force.copy_from_slice(force);
    }

    /// Keeps what the actuator put out in macro step `k`, which it has covered, with its last inputs.
    ///
    /// # Errors
    /// Those of the actuator.
    pub(crate) fn keep_history(
        &mut self,
        k: usize,
        history: &OutputHistory,
        actuator: &mut dyn Subsystem,
        inputs: &[f64],
    ) -> Result<(), Failure> {
        let with_rates = self.bridge == ForceBridge::Rates;
        let kept = self.kept_mut(k);
        kept.history.copy_from(history);
        if with_rates {
            kept.inputs.copy_from_slice(inputs);
            actuator.outputs(inputs, &mut kept.outputs)?;
            actuator.capabilities().output_rates(kept.step.start + kept.step.length, inputs, &mut kept.rates)?;
        }
        Ok(())
    }

    /// Compares the free acceleration at communication point `k` with those since point `m`, rows weighed by the masses
    /// that they move.
    pub(crate) fn compare_accelerations(&mut self, m: usize, k: usize) {
        let LateSamples { ring, accelerations, .. } = self;
        let model = |index: usize| ring[index % ring.len()].model.as_ref();
        for (before, sums) in (m..k).rev().zip(accelerations) {
            let (Some(old), Some(now)) = (model(before), model(k)) else { return };
            for (row, (old, a)) in old.a.iter().zip(&now.a).enumerate() {
                let h = now.entry(row, row);
                if h > 0.0 {
                    [old * a, old * old, a * a].iter().zip(&mut *sums).for_each(|(product, sum)| *sum += product / h);
                }
            }
        }
    }

    /// Returns the least correlation of free accelerations that are no farther apart than samples are old: 1 if they
    /// stay, below 0 if they turn round. None where no sample was late.
    pub(crate) fn acceleration_correlation(&self) -> Option<f64> {
        let of_age = self.accelerations.iter().map(|[both, old, now]| both / (old * now).sqrt());
        of_age.filter(|correlation| correlation.is_finite()).reduce(f64::min)
    }

    /// Brings the scheme's model from communication point `m` to `k`, with the forces that the actuator has had since.
    /// `u` becomes where it is then; returned are the micro steps that it took.
    ///
    /// # Errors
    /// Those of the scheme.
    pub(crate) fn run_forward(
        &mut self,
        m: usize,
        k: usize,
        scheme: &mut dyn CouplingScheme,
        mut learner: Option<&mut MassLearner>,
        u: &mut [f64],
    ) -> Result<u64, Failure> {
        let (coarse, mut passed, mut mean) = (self.rule == LateRule::CatchUpCoarse, 0, std::mem::take(&mut self.mean));
        for kept in (m..k).map(|index| self.kept(index)) {
            let rows = kept.history.rows().len();
            let count = if coarse { rows.div_ceil(k - m) } else { rows };
            let same = count == rows;
            let micro_step = if same { kept.micro_step } else { kept.step.length / count as f64 };
            let mechanics_steps = if same { kept.mechanics_steps } else { kept.mechanics_steps.min(count) };
            scheme.change_macro_step(kept.step, micro_step, mechanics_steps)?;
            for j in 0..count {
                let at = MicroStep { index: passed + j, ..MicroStep::new(kept.step, j, count) };
                if same {
                    scheme.input(Side::Actuator, at, kept.history.at(j), u)?;
                } else {
                    kept.history.mean_over(j, count, &mut mean);
                    scheme.input(Side::Actuator, at, &mean, u)?;
                }
            }
            passed += count;
            if let Some(learner) = &mut learner {
                learner.forecast(kept.step, &kept.history, &u[u.len() / 2..]);
            }
        }
        let Kept { step, micro_step, mechanics_steps, .. } = self.kept(k);
        scheme.change_macro_step(*step, *micro_step, *mechanics_steps)?;
        self.mean = mean;
        Ok(passed as u64)
    }

    /// Replaces the force `u` of own step `i` of `count` of the mechanics in `step` by what the mechanics knows of it.
    pub(crate) fn deliver_force(&mut self, step: MacroStep, i: usize, count: usize, u: &mut [f64]) {
        let k = step.index;
        self.kept_mut(k).returned.push(u);
        let newest = self.newest.actuator[k];
        if newest == Some(k) && self.bridge != ForceBridge::Linear {
            return;
        }
        let Some(n) = newest else {
            u.copy_from_slice(&self.initial);
            return;
        };
        match self.bridge {
            ForceBridge::Hold => {
                let kept = &self.kept(n).returned;
                match kept.rows().len() == count {
                    true => u.copy_from_slice(kept.at(i)),
                    false => kept.mean_over(0, 1, u),
                }
            }
            ForceBridge::Linear => self.go_on(n, step, count, u),
            ForceBridge::Rates => self.model_of_actuator([n, k], MicroStep::new(step, i, count), u),
        }
    }

    /// Goes on along the means of the newest two macro steps whose forces have arrived, to the middle of the present
    /// one.
    fn go_on(&mut self, n: usize, step: MacroStep, count: usize, u: &mut [f64]) {
        let slot = n % self.ring.len();
        let Kept { step: sent, returned, .. } = &self.ring[slot];
        // The present macro step is complete with its last own step.
        let complete = n < step.index || returned.rows().len() == count;
        let time = sent.start + 0.5 * sent.length;
        if complete && self.arrived[0].0 != time {
            self.arrived.swap(0, 1);
            self.arrived[0].0 = time;
            returned.mean_over(0, 1, &mut self.arrived[0].1);
        }
        if n == step.index {
            return;
        }
        let [(last, newest), (before, older)] = &self.arrived;
        let share = (step.start + 0.5 * step.length - last) / (last - before);
        for (u, (newest, older)) in u.iter_mut().zip(newest.iter().zip(older)) {
            // The share is finite as soon as two macro steps have arrived.
            *u = if share.is_finite() { newest + share * (newest - older) } else { *newest };
        }
    }

    /// Follows the actuator from the end of macro step `n` to the middle of an own step of the mechanics in macro step
    /// `k`, with the motion of the mechanics.
    ///
    /// ```text
    /// F = F_n + r τ + D (u − u_n) + R ∫ (u − u_n) dt        trapezoids up to communication point k, held from there on
    /// ```
    fn model_of_actuator(&self, [n, k]: [usize; 2], at: MicroStep, u: &mut [f64]) {
        let Kept { outputs, inputs, rates, step, .. } = self.kept(n);
        let start = step.start + step.length;
        let width = inputs.len();
        for (i, force) in u.iter_mut().enumerate() {
            *force = outputs[i] + rates.rate[i] * (at.middle() - start);
            for (j, input) in inputs.iter().enumerate() {
                let change = |index: usize| self.kept(index).motion[j] - input;
                let between = |index: usize| {
                    0.5 * (change(index) + change(index + 1)) * (self.kept(index + 1).time - self.kept(index).time)
                };
                let sum: f64 = (n + 1..k).map(between).sum::<f64>() + change(k) * (at.middle() - self.kept(k).time);
                *force += rates.feedthrough[i * width + j] * change(k) + rates.rate_gain[i * width + j] * sum;
            }
        }
    }
}

/// A copy of the scheme that has its samples in time, under the forces that the actuator had with late ones.
#[derive(Debug, Clone)]
pub(crate) struct Shadow {
    pub(crate) scheme: SchemeCopy,
    /// What this scheme sends to the actuator.
    u: Vec<f64>,
    /// What the actuator would have sent to this model, J.
    pub(crate) work_sent: WorkMeter,
}

impl Shadow {
    pub(crate) fn new(scheme: Box<dyn CouplingScheme>, actuator: &Ports) -> Self {
        Shadow { scheme: SchemeCopy(scheme), u: vec![0.0; actuator.inputs.len()], work_sent: WorkMeter::new(actuator) }
    }

    /// Starts a macro step from the samples of both sides.
    ///
    /// # Errors
    /// Those of the scheme.
    pub(crate) fn receive(&mut self, mechanics: Sample<'_>, actuator: Sample<'_>) -> Result<(), Failure> {
        self.scheme.0.receive(Side::Mechanics, &mechanics)?;
        self.scheme.0.receive(Side::Actuator, &actuator)?;
        self.u.copy_from_slice(mechanics.y);
        Ok(())
    }

    /// Covers a macro step under the forces that were.
    ///
    /// # Errors
    /// Those of the scheme.
    pub(crate) fn replay(&mut self, step: MacroStep, forces: &OutputHistory) -> Result<(), Failure> {
        let count = forces.rows().len();
        for (j, force) in forces.rows().enumerate() {
            let at = MicroStep::new(step, j, count);
            self.work_sent.add_half_step(at.length, force, &self.u);
            self.scheme.0.input(Side::Actuator, at, force, &mut self.u)?;
            self.work_sent.add_half_step(at.length, force, &self.u);
        }
        Ok(())
    }
}

/// A scheme that is known to be copied.
pub(crate) struct SchemeCopy(pub(crate) Box<dyn CouplingScheme>);

impl Clone for SchemeCopy {
    fn clone(&self) -> Self {
        SchemeCopy(self.0.try_clone().expect("a copy of a scheme can be copied"))
    }
}

impl std::fmt::Debug for SchemeCopy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("SchemeCopy")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::{CommunicationGrid, ForceReturn, Port, Quantity, Sequence};

    /// Four macro steps of 1, 1, 1 and half a second, of two own steps and of one: forces of 0, 1, 4 and 9 N.
    #[test]
    fn a_late_force_goes_on_along_the_means_of_the_newest_two_to_the_middle_of_the_present_step() {
        let port = |quantity| Port::new("row", quantity);
        let inputs = [Quantity::Position, Quantity::Velocity].map(port).to_vec();
        let actuator = Ports { inputs, outputs: vec![port(Quantity::Force)], direct_feedthrough: true };
        let grid = CommunicationGrid::new(1.0, 1.0, 3.5).unwrap();
        let mut setup = Setup::new(grid, 0.5, Sequence::Jacobi, ForceReturn::Held);
        setup.mechanics_steps = "2".parse().unwrap();
        let delivery =
            Delivery { down: "delay:1".parse().unwrap(), bridge: ForceBridge::Linear, ..Delivery::default() };
        let ports = PerSide { mechanics: &actuator.facing(), actuator: &actuator };
        let mut late = LateSamples::new(&delivery, &setup, ports, None);
        // 0 N is known at first, and then held; 1 + 1.5·3 and 4 + 0.75·3 N are on the way from the means before.
        for (k, (count, known)) in [(2, 0.0), (2, 0.0), (2, 2.0), (1, 6.25)].into_iter().enumerate() {
            let step = grid.step(k);
            late.keep(step, (0.5, count), &[0.0, 0.0], None);
            late.keep_force(k, &[0.0]);
            for i in 0..count {
                let mut u = [(k * k) as f64];
                late.deliver_force(step, i, count, &mut u);
                assert_eq!(u, [known], "macro step {k}, own step {i}");
            }
        }
    }
}

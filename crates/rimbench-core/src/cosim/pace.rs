//! Which macro step comes next: the communication grid's, or as long as the energy residual allows.

use super::communication_grid::{CommunicationGrid, MacroStep};
use super::interface_work::InterfaceWork;
use crate::error::{Error, Result};

/// What a controlled macro step is to keep to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRule {
    /// Error allowed per macro step, a pure number: by the energy residual relative to the largest mean power that has crossed the
    /// interface in a macro step, by step doubling relative to the largest value that each coupling variable has had.
    pub tolerance: f64,
    /// Shortest macro step, s. One this short is taken whatever its error; only the last one may be shorter.
    pub shortest: f64,
    /// How the energy residual is made into a step; nothing else looks at it.
    pub controller: EnergyController,
}

/// How the energy residual of a macro step is made into the length of the next.
///
/// ```text
/// audited    δE = sent − received as both sides count it         ε = |δE|/H / (tolerance · P_k),  P_k the largest mean power so far
///            σ = 0.8, ε held within [1e-3, 1e3]
/// published  P_a = Σ λ_{k+1} w_k,  P_b = Σ w_{k+1} λ_k           outputs at the end of the step, inputs that were held during it
///            ε = |P_a − P_b| H / (tolerance · 1 J + tolerance · |max(P_a, P_b)| H)        σ = 0.99
///            while ε or the one before is 0 the step stays as it is
/// both       H ← H σ ε^(−k_I−k_P) ε_before^(k_P),  k_I = 0.15, k_P = 0.2, by no less than 0.2 and no more than 1.5
/// ```
/// *published* is what libcosim's `ecco_algorithm` does, with the parameters of its quarter-truck example (one tolerance for both
/// of its two); the tolerance is the level at which the residual settles. In *audited* the residual and its reference are ours.
/// # Source
/// open-simulation-platform/libcosim, `ecco_algorithm.cpp` (commit 0cc35102) and its test configuration.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum EnergyController {
    /// Works counted by both sides.
    #[default]
    Audited,
    /// Products of the last values, as in libcosim.
    Published,
}

/// Power that each side says crosses the interface at the end of a macro step, W.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct BondPowers {
    /// Σ output of the actuator · velocity that it was given.
    pub(crate) actuator: f64,
    /// Σ velocity that the mechanics has · force that it was given.
    pub(crate) mechanics: f64,
}

impl StepRule {
    /// Checks tolerance and shortest step against the macro step H (s), which is the longest.
    ///
    /// # Errors
    /// [`Error::InvalidValue`].
    pub fn check(&self, macro_step: f64) -> Result<()> {
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            let expected = "a finite number above 0: the error allowed per macro step";
            return Err(Error::invalid("step_tolerance", self.tolerance, expected));
        }
        if !(self.shortest.is_finite() && self.shortest > 0.0) {
            return Err(Error::invalid("min_macro_step_s", self.shortest, "a finite time above 0 s"));
        }
        if self.shortest > macro_step {
            let expected = format!("at most the macro step, {macro_step} s, which is the longest");
            return Err(Error::invalid("min_macro_step_s", self.shortest, expected));
        }
        Ok(())
    }
}

/// A macro step and the time at which it ends, to the bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    pub(crate) step: MacroStep,
    pub(crate) end: f64,
}

impl Interval {
    /// What would follow: where its last communication point is shown.
    pub(crate) fn after(&self) -> MacroStep {
        MacroStep { index: self.step.index + 1, start: self.end, length: self.step.length }
    }
}

/// Gains of the controller, `k_I` and `k_P`, as libcosim's examples have them.
const INTEGRAL_GAIN: f64 = 0.15;
const PROPORTIONAL_GAIN: f64 = 0.2;
/// Aim a little below the tolerance: libcosim's Python example, and its quarter truck.
const SAFETY: f64 = 0.8;
const PUBLISHED_SAFETY: f64 = 0.99;
/// Least and greatest ratio of one macro step to the one before, as libcosim's examples have them.
const CHANGE: [f64; 2] = [0.2, 1.5];

/// Lays one macro step after the other.
///
/// ```text
/// δE_k = (sent − received) over macro step k            what the coupling lost or created, J
/// ε_k  = |δE_k| / H_k / (tolerance · P_k)               P_k = max over j ≤ k of max(|sent_j|, |received_j|) / H_j
/// H_{k+1} = H_k σ ε_k^(−k_I−k_P) ε_{k−1}^(k_P)          held within [0.2, 1.5] H_k and [shortest, H]
/// ```
/// The power residual is that of the energy audit: each side counts the work in its own discretisation, instead of the
/// product of the last values. The reference power is the largest so far instead of the present one, so that a power that
/// passes through zero does not stop the run. Both are *ours*; form, gains and limits are the published ones.
/// [`EnergyController::Published`] has the published residual, too. Nothing is taken back: a first step that is too long stays in
/// the result.
/// # Source
/// Sadjina, Kyllingstad, Skjong, Pedersen, *Energy conservation and power bonds in co-simulations*, Eng. Comput. 33 (2017).
#[derive(Debug, Clone)]
pub(crate) struct Pace {
    grid: CommunicationGrid,
    rule: Option<StepRule>,
    sent: f64,
    received: f64,
    largest_power: f64,
    last_error: Option<f64>,
}

impl Pace {
    /// Whether the next macro step depends on the powers at the end of the last one.
    pub(crate) fn wants_powers(&self) -> bool {
        self.rule.is_some_and(|rule| rule.controller == EnergyController::Published)
    }

    /// The macro steps of `grid`, or with a rule those that keep to it.
    pub(crate) fn new(grid: CommunicationGrid, rule: Option<StepRule>) -> Self {
        Pace { grid, rule, sent: 0.0, received: 0.0, largest_power: 0.0, last_error: None }
    }

    /// The first macro step.
    pub(crate) fn first(&self) -> Interval {
        self.of_grid(0)
    }

    fn of_grid(&self, index: usize) -> Interval {
        Interval { step: self.grid.step(index), end: self.grid.time(index + 1) }
    }

    /// The macro step after `done`, given the work across the interface until its end and, if wanted, the powers there; none after
    /// the last.
    #[inline]
    pub(crate) fn after(&mut self, done: Interval, work: InterfaceWork, powers: BondPowers) -> Option<Interval> {
        let Some(rule) = self.rule else {
            let index = done.step.index + 1;
            return (index < self.grid.macro_steps()).then(|| self.of_grid(index));
        };
        let change = match rule.controller {
            EnergyController::Audited => {
                let error = self.error(rule, done.step.length, work);
                let last = self.last_error.replace(error).unwrap_or(error);
                change(SAFETY, error, last)
            }
            EnergyController::Published => {
                let error = published_error(rule.tolerance, done.step.length, powers);
                let last = self.last_error.replace(error).unwrap_or(0.0);
                if error == 0.0 || last == 0.0 { 1.0 } else { change(PUBLISHED_SAFETY, error, last) }
            }
        };
        let length = done.step.length * change;
        let length = length.clamp(rule.shortest, self.grid.macro_step());
        following(done.step.index + 1, done.end, length, self.grid.duration())
    }

    /// Power residual in units of what is allowed; held within six decades, so that one vanishing error does not make the
    /// controller's memory useless.
    fn error(&mut self, rule: StepRule, length: f64, work: InterfaceWork) -> f64 {
        let (sent, received) = (work.sent_j.unwrap_or(0.0), work.received_j.unwrap_or(0.0));
        let power = [(sent - self.sent) / length, (received - self.received) / length];
        (self.sent, self.received) = (sent, received);
        self.largest_power = self.largest_power.max(power[0].abs()).max(power[1].abs());
        let residual = (power[0] - power[1]).abs();
        let error = if residual > 0.0 { residual / (rule.tolerance * self.largest_power) } else { 0.0 };
        error.clamp(1e-3, 1e3)
    }
}

/// Ratio of the next macro step to the last.
fn change(safety: f64, error: f64, last: f64) -> f64 {
    let change = safety * libm::pow(error, -INTEGRAL_GAIN - PROPORTIONAL_GAIN) * libm::pow(last, PROPORTIONAL_GAIN);
    change.clamp(CHANGE[0], CHANGE[1])
}

/// ε of [`EnergyController::Published`].
fn published_error(tolerance: f64, length: f64, powers: BondPowers) -> f64 {
    let residual = (powers.actuator - powers.mechanics) * length;
    let energy = powers.actuator.max(powers.mechanics) * length;
    residual.abs() / (tolerance + tolerance * energy.abs())
}

/// The macro step of `length` (s) from `start`, or what is left until the `duration`; none if nothing is left.
///
/// The times of a controlled run are sums: no integer knows them beforehand. What is left after a step is never a sliver of
/// round-off.
pub(crate) fn following(index: usize, start: f64, length: f64, duration: f64) -> Option<Interval> {
    let left = duration - start;
    if left <= 0.0 {
        return None;
    }
    let last = left <= length * (1.0 + 1e-9);
    let (length, end) = if last { (left, duration) } else { (length, start + length) };
    Some(Interval { step: MacroStep { index, start, length }, end })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_controller_must_do_what_the_calculation_by_hand_does() {
        let rule = StepRule { tolerance: 0.1, shortest: 1e-3, controller: EnergyController::Audited };
        let mut pace = Pace::new(CommunicationGrid::new(0.1, 1.0, 10.0).unwrap(), Some(rule));
        let work = |sent, received| InterfaceWork { sent_j: Some(sent), received_j: Some(received) };
        // 10 W against 9 W of 10 W: ε = 1, H ← 0.8 H.
        let second = pace.after(pace.first(), work(1.0, 0.9), BondPowers::default()).unwrap();
        approx::assert_relative_eq!(second.step.length, 0.08, max_relative = 1e-14);
        // 10 W against 6 W: ε = 4 after 1, H ← 0.8 · 4^(−0.35) H.
        let third = pace.after(second, work(1.8, 0.9 + 0.48), BondPowers::default()).unwrap();
        approx::assert_relative_eq!(third.step.length, 0.08 * 0.8 * libm::pow(4.0_f64, -0.35), max_relative = 1e-12);
        // No residual at all: ε counts as 1e-3, and the step grows by no more than half.
        let fourth = pace.after(third, work(1.9, 0.9 + 0.48 + 0.1), BondPowers::default()).unwrap();
        approx::assert_relative_eq!(fourth.step.length, 1.5 * third.step.length, max_relative = 1e-9);
        // Ten times the tolerance and more: no shorter than a fifth.
        let fifth = pace.after(fourth, work(1.9 + 1e3, 0.9 + 0.48 + 0.1), BondPowers::default()).unwrap();
        approx::assert_relative_eq!(fifth.step.length, 0.2 * fourth.step.length, max_relative = 1e-9);
    }

    /// Worked by hand from the published code.
    #[test]
    fn the_published_controller_must_do_what_libcosim_does() {
        let rule = StepRule { tolerance: 1e-2, shortest: 1e-3, controller: EnergyController::Published };
        let mut pace = Pace::new(CommunicationGrid::new(0.1, 1.0, 10.0).unwrap(), Some(rule));
        let nothing = InterfaceWork::default();
        let powers = |actuator, mechanics| BondPowers { actuator, mechanics };
        // The first residual only sets the memory: the step stays.
        let second = pace.after(pace.first(), nothing, powers(3.0, 2.0)).unwrap();
        assert_eq!(second.step.length, 0.1);
        // ε₁ = 0.1/(0.01 + 0.01·0.3); then a residual of 0.05 J against 0.01 J, the greater of the signed values.
        let third = pace.after(second, nothing, powers(-0.4, 0.1)).unwrap();
        let (before, now) = (0.1_f64 / 0.013, 0.05_f64 / (0.01 + 0.01 * 0.01));
        let expected = 0.1 * 0.99 * libm::pow(now, -0.35) * libm::pow(before, 0.2);
        approx::assert_relative_eq!(third.step.length, expected, max_relative = 1e-12);
        // No residual: the step stays, and so it does the next time.
        let fourth = pace.after(third, nothing, powers(1.0, 1.0)).unwrap();
        assert_eq!(fourth.step.length, third.step.length);
        let fifth = pace.after(fourth, nothing, powers(9.0, 1.0)).unwrap();
        assert_eq!(fifth.step.length, third.step.length);
    }

    #[test]
    fn a_step_that_all_but_reaches_the_end_reaches_it() {
        let last = following(3, 0.7, 0.3 - 1e-12, 1.0).unwrap();
        assert_eq!((last.end, last.step.length), (1.0, 1.0 - 0.7));
        let before = following(3, 0.5, 0.25, 1.0).unwrap();
        assert_eq!((before.end, before.step.length), (0.75, 0.25));
        assert_eq!(following(4, 1.0, 0.1, 1.0), None);
    }
}

//! Which macro step comes next: the communication grid's, or as long as the error allows that a run finds of itself.

use super::communication_grid::{CommunicationGrid, MacroStep, MicroStep};
use super::interface_work::InterfaceWork;
use super::model_defect::{DefectMeter, ModelDefect};
use super::ports::Ports;
use super::step_rule::{StepControl, StepRule};

/// Differences of the powers that both sides say cross a row of the interface at the end of a macro step, W.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct BondResiduals {
    /// Largest magnitude of the rows.
    pub(crate) largest: f64,
    /// Root mean square of the rows.
    pub(crate) rms: f64,
}

impl BondResiduals {
    /// Takes one difference per row.
    pub(crate) fn of(rows: impl Iterator<Item = f64>) -> Self {
        let (mut largest, mut squares, mut count) = (0.0_f64, 0.0, 0);
        for residual in rows {
            // `max` passes over a NaN; the sum keeps it, so that the mean is NaN.
            largest = largest.max(residual.abs());
            squares += residual * residual;
            count += 1;
        }
        BondResiduals { largest, rms: if count > 0 { (squares / f64::from(count)).sqrt() } else { 0.0 } }
    }
}

/// A macro step and the time at which it ends, to the bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MacroInterval {
    pub(crate) step: MacroStep,
    pub(crate) end: f64,
}

impl MacroInterval {
    /// Returns the macro step itself, as what the exchange at its start is for.
    #[inline]
    pub(crate) fn whole(self) -> MacroStep {
        self.step
    }

    /// Returns one of so many equal parts of it, from 0.
    pub(crate) fn part(self, index: usize, count: usize) -> Self {
        let [at, next] = [index, index + 1].map(|index| MicroStep::new(self.step, index, count));
        // The index goes on over parts: 0, at which a run is initialised, comes once.
        let step = MacroStep { index: self.step.index * count + index, start: at.start, length: at.length };
        MacroInterval { step, end: if index + 1 < count { next.start } else { self.end } }
    }

    /// Returns the step that would follow: where its last communication point is shown.
    pub(crate) fn after(&self) -> MacroStep {
        MacroStep { index: self.step.index + 1, start: self.end, length: self.step.length }
    }
}

/// How the error of a macro step is estimated for the rule that sets the next.
#[derive(Debug)]
pub(crate) enum ErrorMeter {
    /// By the work across the interface alone, which is counted anyway; so where there is no rule.
    Work,
    Powers,
    Defect(DefectMeter),
}

impl ErrorMeter {
    /// Returns that of a rule, for an actuator with these ports.
    pub(crate) fn of(rule: Option<StepRule>, actuator: &Ports) -> Self {
        match rule.map_or(StepControl::None, |rule| rule.control) {
            StepControl::None | StepControl::EnergyResidual => ErrorMeter::Work,
            StepControl::EnergyResidualLibcosim => ErrorMeter::Powers,
            StepControl::ModelDefect | StepControl::ModelDefectBlind => ErrorMeter::Defect(DefectMeter::new(actuator)),
        }
    }
}

/// What it says of a macro step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ErrorEstimate {
    Work,
    Powers(BondResiduals),
    Defect(ModelDefect),
}

/// Gains of the controller, `p k_I` and `p k_P`: Gustafsson's, and with p = 2 those of libcosim's examples.
const INTEGRAL_GAIN: f64 = 0.3;
const PROPORTIONAL_GAIN: f64 = 0.4;
/// Aim a little below the tolerance: libcosim's Python example, and its quarter truck.
const SAFETY: f64 = 0.8;
const PUBLISHED_SAFETY: f64 = 0.99;
/// No step is rejected, so there is nothing to be kept clear of: the tolerance is where the defect settles.
const DEFECT_SAFETY: f64 = 1.0;
/// Where a communication point is placed that is to lie just after a closing: a twentieth of the way behind it, which
/// is what the forecast may be wrong by. Before it the actuator would be told of the impact a macro step late.
const AFTER_CLOSING: f64 = 1.05;
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
/// product of the last values. The reference power is the largest so far instead of the present one, so that a power
/// that passes through zero does not stop the run. Both are *ours*; form, gains and limits are the published ones.
/// [`StepControl::EnergyResidualLibcosim`] has the published residual, too. Nothing is taken back: a first step that is
/// too long stays in the result.
/// # Source
/// Sadjina, Kyllingstad, Skjong, Pedersen, *Energy conservation and power bonds in co-simulations*, Eng. Comput. 33
/// (2017).
#[derive(Debug, Clone)]
pub(crate) struct StepSizeControl {
    grid: CommunicationGrid,
    rule: Option<StepRule>,
    sent: f64,
    received: f64,
    largest_power: f64,
    last_error: Option<f64>,
    /// Length that a macro step was to have before it was cut short for a closing, s.
    length_before_cut: Option<f64>,
}

impl StepSizeControl {
    /// Makes the macro steps of `grid`, or with a rule those that keep to it.
    pub(crate) fn new(grid: CommunicationGrid, rule: Option<StepRule>) -> Self {
        StepSizeControl {
            grid,
            rule,
            sent: 0.0,
            received: 0.0,
            largest_power: 0.0,
            last_error: None,
            length_before_cut: None,
        }
    }

    /// Returns the first macro step.
    pub(crate) fn first(&self) -> MacroInterval {
        self.of_grid(0)
    }

    fn of_grid(&self, index: usize) -> MacroInterval {
        MacroInterval { step: self.grid.step(index), end: self.grid.time(index + 1) }
    }

    /// Returns the macro step after `done`, given the work across the interface until its end and what the rule wants
    /// to know besides; none after the last.
    #[inline]
    pub(crate) fn after(
        &mut self,
        done: MacroInterval,
        work: InterfaceWork,
        estimate: ErrorEstimate,
    ) -> Option<MacroInterval> {
        let Some(rule) = self.rule else {
            let index = done.step.index + 1;
            return (index < self.grid.macro_steps()).then(|| self.of_grid(index));
        };
        let change = match estimate {
            ErrorEstimate::Powers(residuals) => {
                let error = published_error(rule.tolerance, done.step.length, residuals);
                let last = self.last_error.replace(error).unwrap_or(0.0);
                if error == 0.0 || last == 0.0 { 1.0 } else { change(PUBLISHED_SAFETY, rule.order, [error, last]) }
            }
            ErrorEstimate::Defect(defect) => {
                let length = self.length_by_defect(rule, done.step.length, defect);
                let cut = defect
                    .next_closing
                    .filter(|_| rule.control == StepControl::ModelDefect)
                    .map(|time| AFTER_CLOSING * time);
                let cut = cut.filter(|cut| *cut < length).map(|cut| cut.max(rule.shortest));
                self.length_before_cut = cut.map(|_| length);
                return following(done.step.index + 1, done.end, cut.unwrap_or(length), self.grid.duration());
            }
            ErrorEstimate::Work => {
                let error = self.error(rule, done.step.length, work);
                let last = self.last_error.replace(error).unwrap_or(error);
                change(SAFETY, rule.order, [error, last])
            }
        };
        let length = done.step.length * change;
        let length = length.clamp(rule.shortest, self.grid.macro_step());
        following(done.step.index + 1, done.end, length, self.grid.duration())
    }

    /// Length by the defect of the last macro step, which was `done` (s) long.
    ///
    /// A step that was cut short for a closing says nothing about how long one may be, and is not remembered, unless
    /// its defect was too large nevertheless.
    #[cold]
    fn length_by_defect(&mut self, rule: StepRule, done: f64, defect: ModelDefect) -> f64 {
        let error = within_decades(defect.relative / rule.tolerance);
        let length = match self.length_before_cut.take() {
            Some(length_before_cut) if error <= 1.0 => length_before_cut,
            _ => {
                let last = self.last_error.replace(error).unwrap_or(error);
                done * change(DEFECT_SAFETY, rule.order, [error, last])
            }
        };
        length.clamp(rule.shortest, self.grid.macro_step())
    }

    /// Power residual in units of what is allowed.
    fn error(&mut self, rule: StepRule, length: f64, work: InterfaceWork) -> f64 {
        let (sent, received) = (work.sent_j.unwrap_or(0.0), work.received_j.unwrap_or(0.0));
        let power = [(sent - self.sent) / length, (received - self.received) / length];
        (self.sent, self.received) = (sent, received);
        self.largest_power = self.largest_power.max(power[0].abs()).max(power[1].abs());
        let residual = (power[0] - power[1]).abs();
        let error = if residual > 0.0 { residual / (rule.tolerance * self.largest_power) } else { 0.0 };
        within_decades(error)
    }
}

/// An error in units of what is allowed, held within six decades, so that one vanishing error does not make the
/// controller's memory useless; what is not a number asks for the shortest step.
fn within_decades(error: f64) -> f64 {
    if error.is_nan() { 1e3 } else { error.clamp(1e-3, 1e3) }
}

/// Ratio of the next macro step to the last, from the errors of the last and of the one before, which fall with H to
/// the power `order`.
fn change(safety: f64, order: u32, [error, last]: [f64; 2]) -> f64 {
    let [k_i, k_p] = [INTEGRAL_GAIN, PROPORTIONAL_GAIN].map(|gain| gain / f64::from(order));
    let change = safety * libm::pow(error, -k_i - k_p) * libm::pow(last, k_p);
    change.clamp(CHANGE[0], CHANGE[1])
}

/// ε of [`StepControl::EnergyResidualLibcosim`].
fn published_error(tolerance: f64, length: f64, residuals: BondResiduals) -> f64 {
    residuals.rms * length / (tolerance + tolerance * residuals.largest * length)
}

/// Returns the macro step of `length` (s) from `start`, or what is left until the `duration`; none if nothing is left.
///
/// The times of a controlled run are sums: no integer knows them beforehand. What is left after a step is never a
/// sliver of round-off.
pub(crate) fn following(index: usize, start: f64, length: f64, duration: f64) -> Option<MacroInterval> {
    let left = duration - start;
    if left <= 0.0 {
        return None;
    }
    let last = left <= length * (1.0 + 1e-9);
    let (length, end) = if last { (left, duration) } else { (length, start + length) };
    Some(MacroInterval { step: MacroStep { index, start, length }, end })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_controller_must_do_what_the_calculation_by_hand_does() {
        let rule = StepRule { control: StepControl::EnergyResidual, tolerance: 0.1, shortest: 1e-3, order: 2 };
        let mut control = StepSizeControl::new(CommunicationGrid::new(0.1, 1.0, 10.0).unwrap(), Some(rule));
        let work = |sent, received| InterfaceWork { sent_j: Some(sent), received_j: Some(received) };
        // 10 W against 9 W of 10 W: ε = 1, H ← 0.8 H.
        let second = control.after(control.first(), work(1.0, 0.9), ErrorEstimate::Work).unwrap();
        approx::assert_relative_eq!(second.step.length, 0.08, max_relative = 1e-14);
        // 10 W against 6 W: ε = 4 after 1, H ← 0.8 · 4^(−0.35) H.
        let third = control.after(second, work(1.8, 0.9 + 0.48), ErrorEstimate::Work).unwrap();
        approx::assert_relative_eq!(third.step.length, 0.08 * 0.8 * libm::pow(4.0_f64, -0.35), max_relative = 1e-12);
        // No residual at all: ε counts as 1e-3, and the step grows by no more than half.
        let fourth = control.after(third, work(1.9, 0.9 + 0.48 + 0.1), ErrorEstimate::Work).unwrap();
        approx::assert_relative_eq!(fourth.step.length, 1.5 * third.step.length, max_relative = 1e-9);
        // Ten times the tolerance and more: no shorter than a fifth.
        let fifth = control.after(fourth, work(1.9 + 1e3, 0.9 + 0.48 + 0.1), ErrorEstimate::Work).unwrap();
        approx::assert_relative_eq!(fifth.step.length, 0.2 * fourth.step.length, max_relative = 1e-9);
    }

    /// Worked by hand from the published code.
    #[test]
    fn the_published_controller_must_do_what_libcosim_does() {
        let rule = StepRule { control: StepControl::EnergyResidualLibcosim, tolerance: 1e-2, shortest: 1e-3, order: 2 };
        let mut control = StepSizeControl::new(CommunicationGrid::new(0.1, 1.0, 10.0).unwrap(), Some(rule));
        let nothing = InterfaceWork::default();
        let residuals = |rows: &[f64]| ErrorEstimate::Powers(BondResiduals::of(rows.iter().copied()));
        // The first residual only sets the memory: the step stays.
        let second = control.after(control.first(), nothing, residuals(&[1.0])).unwrap();
        assert_eq!(second.step.length, 0.1);
        // ε₁ = 0.1/(0.01 + 0.01·0.1); then 0.3 J and −0.4 J in two rows, whose squares have the mean 0.125 J², against
        // the level of 0.4 J.
        let third = control.after(second, nothing, residuals(&[3.0, -4.0])).unwrap();
        let (before, now) = (0.1_f64 / 0.011, 0.125_f64.sqrt() / (0.01 + 0.01 * 0.4));
        let expected = 0.1 * 0.99 * libm::pow(now, -0.35) * libm::pow(before, 0.2);
        approx::assert_relative_eq!(third.step.length, expected, max_relative = 1e-12);
        // No residual: the step stays, and so it does the next time.
        let fourth = control.after(third, nothing, residuals(&[0.0, 0.0])).unwrap();
        assert_eq!(fourth.step.length, third.step.length);
        let fifth = control.after(fourth, nothing, residuals(&[8.0, 0.0])).unwrap();
        assert_eq!(fifth.step.length, third.step.length);
        // Without rows there is nothing to differ.
        assert_eq!(BondResiduals::of([].into_iter()), BondResiduals::default());
        // However large a residual is, ε is no more than one over the tolerance.
        assert!(published_error(1e-2, 0.1, BondResiduals::of([1e30].into_iter())) <= 1e2 * (1.0 + 4.0 * f64::EPSILON));
    }

    /// k_I = 0.1, k_P = 0.4/3 where the defect falls with H³.
    #[test]
    fn the_defect_of_the_model_must_set_the_step_as_the_calculation_by_hand_does() {
        let rule = StepRule { control: StepControl::ModelDefect, tolerance: 0.1, shortest: 1e-3, order: 3 };
        let mut control = StepSizeControl::new(CommunicationGrid::new(0.1, 0.5, 10.0).unwrap(), Some(rule));
        let mut after = |done, relative, next_closing| {
            let defect = ModelDefect { force: f64::NAN, relative, next_closing };
            control.after(done, InterfaceWork::default(), ErrorEstimate::Defect(defect)).unwrap()
        };
        let first = MacroInterval { step: MacroStep { index: 0, start: 0.0, length: 0.05 }, end: 0.05 };
        // ε = 1: the tolerance is where it settles. A closing beyond the step does not matter.
        let second = after(first, 0.1, Some(0.06));
        assert_eq!(second.step.length, 0.05);
        // ε = 8 after 1.
        let third = after(second, 0.8, None);
        let expected = 0.05 * libm::pow(8.0_f64, -0.7 / 3.0);
        approx::assert_relative_eq!(third.step.length, expected, max_relative = 1e-12);
        // ε = 8 again, 8^(−0.1), but a contact closes before: a twentieth behind it.
        let cut = after(third, 0.8, Some(0.01));
        approx::assert_relative_eq!(cut.step.length, 0.0105, max_relative = 1e-12);
        // The step that was cut had no large defect: the next is as long as it would have been.
        let length_before_cut = after(cut, 0.08, None);
        let as_planned = expected * libm::pow(8.0_f64, -0.1);
        approx::assert_relative_eq!(length_before_cut.step.length, as_planned, max_relative = 1e-12);
        // Nor is its small defect remembered: ε = 1 after 8, not after 0.8.
        let next = after(length_before_cut, 0.1, None);
        approx::assert_relative_eq!(next.step.length, as_planned * libm::pow(8.0_f64, 0.4 / 3.0), max_relative = 1e-12);
        // What is about to close gives the shortest step, what is not a number a fifth of the last.
        assert_eq!(after(length_before_cut, 0.1, Some(1e-6)).step.length, 1e-3);
        let lost = after(length_before_cut, f64::NAN, None);
        assert!(lost.step.length < length_before_cut.step.length, "{}", lost.step.length);
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

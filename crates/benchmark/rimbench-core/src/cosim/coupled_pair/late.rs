//! The exchange where samples may be late or lost.

use super::CoupledPair;
use crate::cosim::communication_grid::MacroStep;
use crate::cosim::coupling_scheme::Sample;
use crate::cosim::delivery::LateRule;
use crate::cosim::force_return::ForceReturn;
use crate::cosim::pair_state::PairState;
use crate::cosim::sent_model::SentModel;
use crate::cosim::side::Side;
use crate::cosim::step_size_control::MacroInterval;
use crate::error::Failure;

impl CoupledPair<'_> {
    /// Sends the samples of a communication point on their way, and hands the newest that have arrived to the scheme.
    ///
    /// ```text
    /// raw         the sample of t_m is handed on as one of t_k
    /// catch-up    it is handed on with its time; a model goes on from t_m to t_k with the forces that the actuator has had since,
    ///             in the actuator's micro steps, or coarse ones under their mean
    /// ```
    /// The actuator starts the macro step with the motion that it knows; the outputs that are recorded are those with
    /// the true one.
    #[cold]
    pub(super) fn exchange_late(&mut self, step: MacroStep) -> Result<(), Failure> {
        let (k, micro_step) = (step.index, self.setup.actuator_micro_step(step));
        let mechanics_steps = self.setup.own_mechanics_steps(step);
        let known = self.state.late.as_ref().map_or(k, |late| late.newest_motion(k));
        if let (Some(late), true) = (&self.state.late, known < k) {
            self.state.u.actuator.copy_from_slice(&late.kept(known).motion);
        }
        self.fill_attachments(step)?;
        let PairState { y, u, own, exchange, late, model, counters, .. } = &mut *self.state;
        let Some(late) = late else { return Ok(()) };
        let scheme = &mut *self.scheme;
        let (model, mut learner, in_time) = match model.as_deref_mut() {
            Some(SentModel { model, learner, in_time, .. }) => (Some(&*model), learner.as_mut(), in_time.as_mut()),
            None => (None, None, None),
        };
        late.keep(step, (micro_step, mechanics_steps), &y.mechanics, model);
        if known < k {
            late.compare_accelerations(known, k);
        }
        let goes_on = late.rule.catches_up() && model.is_some() && known < k;
        let shown = |time: f64| if late.rule == LateRule::Raw { step.start } else { time };
        let kept = late.kept(known);
        let (at, length, mechanics_steps) = match goes_on {
            true => (kept.step, kept.micro_step, kept.mechanics_steps),
            false => (step, micro_step, mechanics_steps),
        };
        let sample = Sample {
            time: shown(kept.time),
            model: match &mut learner {
                Some(learner) => kept.model.as_ref().map(|model| learner.receive(known, model)),
                None => kept.model.as_ref(),
            },
            mechanics_steps,
            ..Sample::of_outputs(at, &kept.motion, length)
        };
        scheme.receive(Side::Mechanics, &sample)?;
        if goes_on {
            scheme.receive(Side::Actuator, &Sample { y: &kept.force, model: None, ..sample })?;
            counters.catch_up_steps += late.run_forward(known, k, scheme, learner, &mut u.actuator)?;
        }
        self.sides.actuator.outputs(&u.actuator, &mut own.actuator)?;
        late.keep_force(k, &own.actuator);
        if !goes_on {
            // Where the force is held, the mechanics has it from this sample.
            let sent = if self.setup.force_return == ForceReturn::Held { late.newest_force(k) } else { k };
            let kept = late.kept(sent);
            let time = if late.rule == LateRule::Raw { step.start } else { kept.time };
            let rates = exchange.output_rates.as_ref();
            let sample = Sample { time, rates, ..Sample::of_outputs(step, &kept.force, micro_step) };
            scheme.receive(Side::Actuator, &sample)?;
        }
        if let Some(in_time) = in_time {
            let mechanics_steps = self.setup.own_mechanics_steps(step);
            let sample = Sample { model, mechanics_steps, ..Sample::of_outputs(step, &y.mechanics, micro_step) };
            let rates = exchange.output_rates.as_ref();
            in_time.receive(sample, Sample { y: &own.actuator, model: None, rates, ..sample })?;
        }
        counters.exchanges += 1;
        Ok(())
    }

    /// Sends the outputs of the mechanics at the end of a macro step on their way, and hands the newest that has
    /// arrived to the scheme.
    #[cold]
    pub(super) fn send_fresh_sample_late(&mut self, MacroInterval { step, end }: MacroInterval) -> Result<(), Failure> {
        let micro_step = self.setup.actuator_micro_step(step);
        let PairState { y, late, .. } = &mut *self.state;
        let Some(late) = late else { return Ok(()) };
        let next = late.kept_mut(step.index + 1);
        next.time = end;
        next.motion.copy_from_slice(&y.mechanics);
        let kept = late.kept(late.newest_motion(step.index + 1));
        let time = if late.rule == LateRule::Raw { end } else { kept.time };
        self.scheme.receive(Side::Mechanics, &Sample { time, ..Sample::of_outputs(step, &kept.motion, micro_step) })
    }
}

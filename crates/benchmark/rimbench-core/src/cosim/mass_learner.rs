//! A receiver that learns the mass: by how much the mechanics' new velocity is not what its interface model forecast
//! from the forces sent.
//!
//! ```text
//! H ← f H                        f a factor on the mobility, 1/f on the mass
//! e = w⁺ − ŵ                     one macro step after a sample, both at the next, by row of the interface
//! s = Ĥ p / f                    how the forecast depends on f: Ĥ with the closed contacts eliminated, p the impulse sent
//! K = P s / (φ R + s · s P)      f ← f + K · e,  P ← (1 − K · s) P / φ         R = (ε max |s|)²
//! ```
//! Recursive least squares with forgetting φ and three numbers of state, (f, P, R). A jump is left out where a contact
//! has opened, closed, or changed between stick and slip in the mechanics: what a contact did there is no mass.
//! # Source
//! `docs/method/learning-the-mass.md`.

use super::communication_grid::MacroStep;
use super::output_history::OutputHistory;
use crate::error::{Error, Result};
use crate::interface_model::{Condensation, ReducedInterfaceModel, condense};
use crate::parts::Parts;
use std::fmt;
use std::str::FromStr;

/// Variance of a factor of which nothing is known yet.
const UNKNOWN: f64 = 4.0;

/// Its largest once something is: forgetting makes nothing unknown again where no force moves the mechanics.
const FORGOTTEN: f64 = 0.01;

/// What a forecast may be off for other reasons than the mass, as a share of the most that the force has ever moved it,
/// ε.
const OTHER_REASONS: f64 = 0.1;

/// Most by which one sample changes the factor: what is no mass does little harm, and a factor of 4 takes seven
/// samples.
const MOST_AT_ONCE: f64 = 1.25;

/// How a receiver learns by which factor the mass of its interface model is wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassLearning {
    /// Share φ of what older samples say that is kept from one to the next, in (0, 1].
    pub forgetting: f64,
    /// Most by which mass and model may differ, above 1: a factor stays between 1/x and x.
    pub within: f64,
}

impl Default for MassLearning {
    fn default() -> Self {
        MassLearning { forgetting: 0.95, within: 10.0 }
    }
}

impl MassLearning {
    /// Checks that the model is one whose mass can be learned.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for matrices that keep their non-zeros only, and for contacts within the model that it
    /// does not list.
    pub fn check_model(&self, model: &ReducedInterfaceModel) -> Result<()> {
        let why = if model.delassus_pattern().is_some() {
            "a model with contacts by the dozen is taken as it is"
        } else if model.smooth {
            "the mechanics' interface model has its contacts within, and does not tell when one opens or closes"
        } else {
            return Ok(());
        };
        Err(Error::Incompatible(format!("mass_learning = {self}: {why}")))
    }
}

impl fmt::Display for MassLearning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "forgetting:{:?},within:{:?}", self.forgetting, self.within)
    }
}

impl FromStr for MassLearning {
    type Err = Error;

    /// Reads `forgetting=PHI,within=X`, each part at most once and in any order.
    fn from_str(text: &str) -> Result<Self> {
        let mut learning = MassLearning::default();
        let parts = Parts::of("mass_learning", text, ["forgetting", "within"])?;
        let share = "a share that is kept, above 0 up to 1, as in `forgetting=0.95`";
        parts.read("forgetting", &mut learning.forgetting, |share| *share > 0.0 && *share <= 1.0, share)?;
        let factor = "a factor above 1, as in `within=10`";
        parts.read("within", &mut learning.within, |factor| factor.is_finite() && *factor > 1.0, factor)?;
        Ok(learning)
    }
}

/// Learns as samples arrive; everything is reserved beforehand.
#[derive(Debug, Clone)]
pub(crate) struct MassLearner {
    rule: MassLearning,
    /// f, and what it was in the forecast.
    factor: f64,
    forecast_with: f64,
    /// P.
    variance: f64,
    /// Most that an impulse has moved a forecast, for a factor of 1, m/s.
    most: f64,
    /// ŵ (m/s) and s of the forecast.
    forecast: Vec<f64>,
    sensitivity: Vec<f64>,
    /// The model as the scheme has it, by the communication point of its sample.
    model: ReducedInterfaceModel,
    sample: Option<usize>,
    /// Whether there is a forecast for the next communication point.
    has_forecast: bool,
    condensation: Condensation,
    closed: Vec<usize>,
    force: Vec<f64>,
}

impl MassLearner {
    /// Reserves models like `empty`.
    pub(crate) fn new(rule: MassLearning, empty: &ReducedInterfaceModel) -> Self {
        let zeros = vec![0.0; empty.interface()];
        MassLearner {
            rule,
            factor: 1.0,
            forecast_with: 1.0,
            variance: UNKNOWN,
            most: 0.0,
            forecast: zeros.clone(),
            sensitivity: zeros.clone(),
            model: empty.clone(),
            sample: None,
            has_forecast: false,
            condensation: Condensation::of(empty),
            closed: Vec::with_capacity(empty.contacts()),
            force: zeros,
        }
    }

    /// Takes the sample of communication point `m`, learns from it if it is new and was forecast, and returns its model
    /// with the mass learned.
    pub(crate) fn receive(&mut self, m: usize, sent: &ReducedInterfaceModel) -> &ReducedInterfaceModel {
        let next = self.sample.is_some_and(|before| before + 1 == m);
        let same = self.model.at_bound == sent.at_bound
            && (self.model.same_contacts(sent) || sent.contacts() == 0)
            && self.model.states == sent.states
            && !(sent.spring.is_some() && sent.at_bound.contains(&true));
        if next && same && self.has_forecast {
            self.learn(&sent.w[sent.interface_start()..]);
        }
        self.sample = Some(m);
        self.has_forecast = false;
        self.model.copy_from(sent);
        self.model.h.iter_mut().for_each(|entry| *entry *= self.factor);
        &self.model
    }

    /// Learns from the velocities (m/s) that were forecast.
    fn learn(&mut self, w: &[f64]) {
        let (s, phi) = (&self.sensitivity, self.rule.forgetting);
        let squares: f64 = s.iter().map(|s| s * s).sum();
        self.most = self.most.max(squares.sqrt());
        let noise = (OTHER_REASONS * self.most).powi(2);
        // The factor may have changed since the forecast.
        let since = self.factor - self.forecast_with;
        let jumps = w.iter().zip(&self.forecast).zip(s).map(|((w, forecast), s)| s * (w - forecast - s * since));
        let gain = self.variance / (phi * noise + squares * self.variance);
        let change = gain * jumps.sum::<f64>();
        if !change.is_finite() {
            return;
        }
        let (asked, before) = (self.factor + change, self.factor);
        let learned = asked.clamp(before / MOST_AT_ONCE, before * MOST_AT_ONCE);
        self.factor = learned.clamp(1.0 / self.rule.within, self.rule.within);
        // A sample that was not followed all the way has not made the factor known.
        if learned == asked {
            let left = (1.0 - gain * squares) * self.variance;
            self.variance = left.max((left / phi).min(FORGOTTEN));
        }
    }

    /// Notes where the scheme's model, started from the newest sample, stands at the end of `step`, which starts there,
    /// under these forces.
    pub(crate) fn forecast(&mut self, step: MacroStep, forces: &OutputHistory, w: &[f64]) {
        if self.sample != Some(step.index) {
            return;
        }
        forces.mean_over(0, 1, &mut self.force);
        self.model.closed_contacts(&mut self.closed);
        condense(&self.model, &self.closed, &mut self.condensation);
        let scale = step.length / self.factor;
        self.forecast.copy_from_slice(w);
        self.forecast_with = self.factor;
        for (s, own) in self.sensitivity.iter_mut().zip(self.condensation.h.chunks_exact(w.len())) {
            *s = own.iter().zip(&self.force).map(|(h, force)| h * force).sum::<f64>() * scale;
        }
        self.has_forecast = !self.condensation.locks_itself;
    }

    /// Returns the factor on the mass.
    pub(crate) fn mass_factor(&self) -> f64 {
        1.0 / self.factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1e-2;

    /// A mass of 2 kg whose model is `belief` times as heavy, under a force of 3 N and its weight, with a contact or
    /// without.
    fn learned(belief: f64, steps: usize, touches: impl Fn(usize) -> bool, push: f64) -> MassLearner {
        let mut sent = ReducedInterfaceModel::zeros(1, 1);
        sent.h.copy_from_slice(&[1.0, 0.0, 0.0, 1.0].map(|h| h / (2.0 * belief)));
        sent.a.copy_from_slice(&[0.0, -9.81]);
        let mut learner = MassLearner::new(MassLearning::default(), &sent);
        let mut forces = OutputHistory::new(1, 1);
        for m in 0..steps {
            sent.at_bound[0] = touches(m);
            let model = learner.receive(m, &sent);
            let (w, force) = (sent.w[1], 3.0 + libm::sin(m as f64));
            let forecast = w + STEP * (model.a[1] + model.entry(1, 1) * force);
            forces.clear();
            forces.push(&[force]);
            learner.forecast(MacroStep { index: m, start: 0.0, length: STEP }, &forces, &[forecast]);
            // Where the contact has just changed it pushes.
            let pushed = if touches(m) == touches(m + 1) { 0.0 } else { push };
            sent.w[1] = w + STEP * (-9.81 + force / 2.0) + pushed;
        }
        learner
    }

    #[test]
    fn the_factor_of_a_body_that_moves_freely_is_found_in_a_few_samples_and_kept_within_its_bounds() {
        for belief in [0.25, 0.5, 1.0, 2.0, 4.0] {
            let found = learned(belief, 10, |_| false, 0.0).mass_factor() * belief;
            assert!((found - 1.0).abs() < 1e-2, "{belief}: {found}");
        }
        let found = learned(100.0, 20, |_| false, 0.0).mass_factor();
        approx::assert_relative_eq!(found, 0.1, max_relative = 1e-12);
    }

    /// Of a forecast that was right: `1/P ← φ (1/P + s²/(φ R))`, with R = s²/100 of the first.
    #[test]
    fn a_sample_makes_the_factor_as_certain_as_its_noise_is_small() {
        let mut learner = learned(1.0, 2, |_| false, 0.0);
        approx::assert_relative_eq!(learner.variance, 1.0 / (0.95 / UNKNOWN + 100.0), max_relative = 1e-12);
        let before = learner.variance;
        (learner.sensitivity[0], learner.most, learner.rule.forgetting) = (3.0, 10.0, 1.0);
        learner.learn(&[learner.forecast[0]]);
        approx::assert_relative_eq!(learner.variance, 1.0 / (1.0 / before + 9.0), max_relative = 1e-12);
    }

    #[test]
    fn a_contact_that_opens_or_closes_is_not_learned_as_mass() {
        let found = learned(1.0, 60, |m| m % 7 < 3, 5.0);
        approx::assert_relative_eq!(found.mass_factor(), 1.0, max_relative = 1e-9);
        // The same pushes from contacts that are not seen to change are.
        let mut blind = learned(1.0, 3, |_| false, 0.0);
        let mut sent = blind.model.clone();
        sent.w[1] += 5.0;
        blind.receive(3, &sent);
        assert!((blind.mass_factor() - 1.0).abs() > 0.1);
    }

    /// Two bodies, the first of which is believed twice as heavy as it is: its own factor is 2, that of the other 1.
    #[test]
    fn of_two_masses_of_which_one_is_wrong_the_mean_is_learned_that_each_forecast_depends_on() {
        for share in [0.1, 0.5, 1.0, 2.0, 10.0] {
            let mut sent = ReducedInterfaceModel::zeros(0, 2);
            sent.h.copy_from_slice(&[0.25, 0.0, 0.0, 0.25]);
            let mut learner = MassLearner::new(MassLearning::default(), &sent);
            let mut forces = OutputHistory::new(2, 1);
            for m in 0..40 {
                learner.receive(m, &sent);
                let force = [1.0, share].map(|share| share * (3.0 + libm::sin(m as f64)));
                let w = [0, 1].map(|row| sent.w[row] + STEP * learner.factor * 0.25 * force[row]);
                forces.clear();
                forces.push(&force);
                learner.forecast(MacroStep { index: m, start: 0.0, length: STEP }, &forces, &w);
                [0.5, 0.25].iter().enumerate().for_each(|(row, own)| sent.w[row] += STEP * own * force[row]);
            }
            let mean = (2.0 + share * share) / (1.0 + share * share);
            assert!((learner.factor - mean).abs() < 1e-2, "{share}: {}, not {mean}", learner.factor);
        }
    }

    #[test]
    fn a_sample_that_was_not_forecast_teaches_nothing() {
        let mut learner = learned(2.0, 1, |_| false, 0.0);
        let mut sent = learner.model.clone();
        sent.w[1] = 7.0;
        // The sample between was lost; and this one arrives a second time.
        learner.receive(2, &sent);
        learner.receive(2, &sent);
        assert_eq!(learner.mass_factor(), 1.0);
    }

    #[test]
    fn the_option_is_written_as_it_is_read_and_nonsense_is_refused() {
        assert_eq!("within:4".parse::<MassLearning>().unwrap().to_string(), "forgetting:0.95,within:4.0");
        let refused = |text: &str| text.parse::<MassLearning>().unwrap_err().to_string();
        assert!(refused("forgetting:0").contains("above 0 up to 1"));
        assert!(refused("within:1").contains("above 1"));
        assert!(refused("witin:2").contains("did you mean `within`"));
        assert!(refused("within:2,within:3").contains("at most once"));
    }
}

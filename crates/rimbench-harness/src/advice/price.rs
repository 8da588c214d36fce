//! What a run costs: its counted work, weighed.

use rimbench_core::error::{Error, Result};

/// What one piece of each kind of work costs, in units of whoever sets them; by default in micro steps of the actuator.
///
/// ```text
/// cost = e · exchanges + m · mechanics solves + μ · micro steps + l · model solves
/// ```
/// A mechanics solve is one step of the mechanics with its contact problem; a model solve is the contact problem of an interface
/// model within one micro step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prices {
    /// One exchange of the coupling variables, e.
    pub exchange: f64,
    /// One step of the mechanics, m.
    pub mechanics_solve: f64,
    /// One micro step of the actuator, μ.
    pub micro_step: f64,
    /// One contact problem of an interface model, l.
    pub model_solve: f64,
}

impl Default for Prices {
    /// Instructions of the wedge box by Valgrind's count (`rimbench perf record`, November 2026), over those of a micro step, 437:
    /// a mechanics step 5699; the model of `rim-nonsmooth-gap` 638 in each micro step; what is left of a macro step of
    /// `zero-order-hold` beside its mechanics step and its micro steps, 3947, of which 2733 find the effective mass.
    fn default() -> Self {
        Prices { exchange: 9.0, mechanics_solve: 13.0, micro_step: 1.0, model_solve: 1.5 }
    }
}

impl Prices {
    /// The names, in the order of [`Work::counts`].
    pub const NAMES: [&'static str; 4] = ["exchange", "mechanics solve", "micro step", "model solve"];

    /// The prices as a list, in the order of [`Work::counts`].
    pub fn list(&self) -> [f64; 4] {
        [self.exchange, self.mechanics_solve, self.micro_step, self.model_solve]
    }

    /// Checks that they are prices.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for one that is negative or not finite; [`Error::Incompatible`] if nothing costs anything.
    pub fn check(&self) -> Result<()> {
        let keys = ["exchanges-cost", "mechanics-cost", "micro-cost", "model-cost"];
        for (key, price) in keys.into_iter().zip(self.list()) {
            if !(price.is_finite() && price >= 0.0) {
                return Err(Error::invalid(key, price, "a finite number, 0 or above"));
            }
        }
        if self.list().iter().all(|price| *price == 0.0) {
            return Err(Error::Incompatible(
                "nothing costs anything, so nothing is cheapest: set one cost above 0".into(),
            ));
        }
        Ok(())
    }

    /// Computes the cost of work.
    pub fn of(&self, work: &Work) -> f64 {
        self.list().iter().zip(work.counts()).map(|(price, count)| price * count).sum()
    }
}

/// Counted work of a run, or what is expected of it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// Exchanges between the sides.
    pub exchanges: f64,
    /// Steps of the mechanics.
    pub mechanics_solves: f64,
    /// Micro steps of the actuator.
    pub micro_steps: f64,
    /// Contact problems of the scheme's interface model.
    pub model_solves: f64,
}

impl Work {
    /// The counts as a list, in the order of [`Prices::NAMES`].
    pub fn counts(&self) -> [f64; 4] {
        [self.exchanges, self.mechanics_solves, self.micro_steps, self.model_solves]
    }

    /// The larger of each.
    pub(super) fn max(&self, other: &Work) -> Work {
        Work {
            exchanges: self.exchanges.max(other.exchanges),
            mechanics_solves: self.mechanics_solves.max(other.mechanics_solves),
            micro_steps: self.micro_steps.max(other.micro_steps),
            model_solves: self.model_solves.max(other.model_solves),
        }
    }

    /// The work per macro step, times `factor` of it; what is done per micro step is that many times `fine` as much.
    pub(super) fn scaled(&self, factor: f64, fine: f64, mechanics_is_fine: bool) -> Work {
        Work {
            exchanges: self.exchanges * factor,
            mechanics_solves: self.mechanics_solves * if mechanics_is_fine { fine } else { factor },
            micro_steps: self.micro_steps * fine,
            model_solves: self.model_solves * fine,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cost_is_the_weighted_sum_and_nonsense_is_no_price() {
        let prices = Prices { exchange: 2.0, mechanics_solve: 10.0, micro_step: 1.0, model_solve: 0.5 };
        let work = Work { exchanges: 3.0, mechanics_solves: 2.0, micro_steps: 100.0, model_solves: 4.0 };
        assert_eq!(prices.of(&work), 6.0 + 20.0 + 100.0 + 2.0);
        for wrong in [-1.0, f64::NAN, f64::INFINITY] {
            let message = Prices { exchange: wrong, ..prices }.check().unwrap_err().to_string();
            assert!(message.starts_with("exchanges-cost = "), "{message}");
        }
        let free = Prices { exchange: 0.0, mechanics_solve: 0.0, micro_step: 0.0, model_solve: 0.0 };
        assert!(free.check().is_err() && Prices::default().check().is_ok());
    }
}

//! What numbers are found of a run: names in claims, figures and tables are read as these once.

use super::findings::{Findings, UNCERTAINTIES, counters};
use crate::metrics::{Floor, METRICS, Metric};
use rimbench_core::cosim::{OutcomeClass, OutcomeKind, Work};
use rimbench_core::error::{Error, Result};

/// A number that is found of a run, see [`Findings::value`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finding {
    /// When it left the path of a completed run, s.
    OutcomeAt,
    /// Time of the last communication point reached, s.
    EndedAt,
    /// A metric, by its place in [`METRICS`].
    Metric(usize),
    /// Uncertainty of the reference's force, N, and position, m.
    Uncertainty(usize),
    /// An exact count of the work, by its place among all.
    Counter(usize),
    /// 1 of a run that completed, 0 of one that failed; no column, and of a run without an answer nothing, as the two
    /// that follow.
    Completed,
    /// The reverse.
    Failed,
    /// When a run failed, s.
    FailedAt,
}

impl Finding {
    /// The rms force error, N.
    pub const FORCE_ERROR: Self = Finding::Metric(0);

    /// How a run ended.
    pub const ENDS: [Self; 3] = [Finding::Completed, Finding::Failed, Finding::FailedAt];

    /// Lists the metrics.
    pub fn metrics() -> impl Iterator<Item = Self> + Clone {
        (0..METRICS.len()).map(Finding::Metric)
    }

    /// Lists all that have a column in data, in its order.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        let ends = [Finding::OutcomeAt, Finding::EndedAt].into_iter();
        ends.chain(Self::metrics()).chain((0..UNCERTAINTIES.len()).map(Finding::Uncertainty)).chain(Self::counters())
    }

    /// Lists the counters.
    pub fn counters() -> impl Iterator<Item = Self> + Clone {
        (0..counters(&mut Work::default()).len()).map(Finding::Counter)
    }

    /// Finds one that has a column in data by its name.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with the names there are.
    pub fn named(name: &str) -> Result<Self> {
        Self::among("column", name, Self::all())
    }

    /// Finds one of some by its name; `kind` is what an error calls these.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with the names there are.
    pub fn among(kind: &'static str, name: &str, some: impl Iterator<Item = Self> + Clone) -> Result<Self> {
        let found = some.clone().find(|finding| finding.name() == name);
        found.ok_or_else(|| Error::unknown(kind, name, some.map(Self::name)))
    }

    /// Returns its name in data, with the unit.
    pub fn name(self) -> &'static str {
        match self {
            Finding::OutcomeAt => "outcome_at_s",
            Finding::EndedAt => "ended_at_s",
            Finding::Metric(index) => METRICS[index].name,
            Finding::Uncertainty(index) => UNCERTAINTIES[index],
            Finding::Counter(index) => counters(&mut Work::default())[index].0,
            Finding::Completed => OutcomeKind::Completed.name(),
            Finding::Failed => "failed",
            Finding::FailedAt => "failed_at_s",
        }
    }

    /// Returns the metric, if it is one.
    pub fn metric(self) -> Option<&'static Metric> {
        if let Finding::Metric(index) = self { Some(&METRICS[index]) } else { None }
    }

    /// Returns its value of a run without error: 0 of what is no metric.
    pub fn ideal(self) -> f64 {
        self.metric().map_or(0.0, |metric| metric.ideal)
    }
}

impl Findings {
    /// Returns a finding; NaN where it does not apply.
    pub fn value(&self, finding: Finding) -> f64 {
        let has_failed = self.outcome.class() == OutcomeClass::Failed;
        let value = match finding {
            Finding::OutcomeAt => self.outcome_at_s,
            Finding::EndedAt => Some(self.ended_at_s),
            Finding::Metric(index) => self.metrics[index],
            Finding::Uncertainty(index) => self.reference_uncertainty[index],
            Finding::Counter(index) => Some(*counters(&mut { self.work })[index].1 as f64),
            _ if self.outcome.class() == OutcomeClass::NoAnswer => None,
            Finding::Completed => Some(f64::from(!has_failed)),
            Finding::Failed => Some(f64::from(has_failed)),
            Finding::FailedAt => self.outcome_at_s.filter(|_| has_failed),
        };
        value.unwrap_or(f64::NAN)
    }

    /// Returns what an error must exceed to be known; NaN where nothing is known of the reference, none of what has no
    /// such bound.
    pub fn floor(&self, error: Finding) -> Option<f64> {
        let [force, position] = self.reference_uncertainty.map(|value| value.unwrap_or(f64::NAN));
        Some(match error.metric()?.floor? {
            Floor::Force => force,
            Floor::ShareOfPeak => force * self.value(error) / self.value(Finding::FORCE_ERROR),
            Floor::Position => position,
        })
    }

    /// Tells whether an order of convergence may be fitted to an error: it is finite and above what the reference is
    /// uncertain by, which is rounding at least. Of what has no such uncertainty none may.
    pub fn has_order(&self, error: Finding) -> bool {
        let value = self.value(error);
        self.floor(error).is_some_and(|floor| value.is_finite() && (floor.is_nan() || value > floor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FactValue;
    use rimbench_core::cosim::Outcome;

    #[test]
    fn each_number_of_a_row_is_a_quantity_by_its_name_with_its_value() {
        let mut found = Findings::nothing(&Outcome::Completed);
        let mut next = 0.0;
        found.columns(&mut |_, cell| {
            next += 1.0;
            let _ = cell.read(&format!("{next}"));
        });
        let number = |value| match value {
            FactValue::Number(number) => Some(number),
            FactValue::Count(count) => Some(count as f64),
            FactValue::Text(_) | FactValue::Truth(_) => None,
        };
        let facts = found.facts().into_iter();
        let numbers: Vec<_> = facts.filter_map(|fact| Some((fact.name, fact.value.and_then(number)?))).collect();
        let findings: Vec<_> = Finding::all().map(|own| (own.name(), found.value(own))).collect();
        assert_eq!(findings, numbers);
        assert!(Finding::all().all(|own| Finding::named(own.name()).is_ok_and(|found| found == own)));
        assert_eq!(Finding::FORCE_ERROR.name(), "force_error_rms_n");
        assert!(Finding::named("nothing").is_err_and(|error| error.to_string().contains("exchanges")));
    }
}

//! From the values of an axis to positions on the page.

use super::chart::{Axis, Range, Scale};
use super::ticks::{self, Ticks};

/// Positions farther from the page than this are all the same; keeps diverged values finite.
const FAR: f64 = 1.0e6;

/// An interval of values laid along an interval of the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisMap {
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Least value shown.
    pub low: f64,
    /// Greatest value shown.
    pub high: f64,
    /// Position of `low`, px.
    pub start: f64,
    /// Position of `high`, px.
    pub end: f64,
}

impl AxisMap {
    /// Finds the position of a value; none for NaN and for values a logarithmic axis cannot show.
    pub fn position(&self, value: f64) -> Option<f64> {
        let share = match self.scale {
            Scale::Linear | Scale::Count => (value - self.low) / (self.high - self.low),
            Scale::Log10 if value <= 0.0 => return None,
            Scale::Log10 => (value / self.low).log10() / (self.high / self.low).log10(),
        };
        let position = self.start + share * (self.end - self.start);
        (!position.is_nan()).then(|| position.clamp(-FAR, FAR))
    }

    /// Chooses ticks, at most about `most` with a label.
    pub fn ticks(&self, most: usize) -> Ticks {
        match self.scale {
            Scale::Linear => ticks::linear(self.low, self.high, most),
            Scale::Count => ticks::whole(self.low, self.high, most),
            Scale::Log10 => ticks::logarithmic(self.low, self.high, most),
        }
    }
}

/// Settles the interval of an axis: the fixed one, or that of the values it can show, widened by `margin` of itself.
pub fn interval(axis: &Axis, values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let logarithmic = axis.scale == Scale::Log10;
    if let Range::Fixed(low, high) = axis.range
        && low < high
        && low.is_finite()
        && high.is_finite()
        && (!logarithmic || low > 0.0)
    {
        return (low, high);
    }
    let shown = values.filter(|value| value.is_finite() && (!logarithmic || *value > 0.0));
    let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    match (low <= high, logarithmic) {
        (false, true) => (1.0, 10.0),
        (false, false) => (0.0, 1.0),
        (true, true) if high / low < 1.0 + 1e-6 => (low / 2.0, high * 2.0),
        (true, true) => {
            let widened = (high / low).powf(margin);
            (low / widened, high * widened)
        }
        (true, false) if high - low <= 1e-9 * high.abs().max(low.abs()) => {
            let half = if high == 0.0 { 1.0 } else { 0.1 * high.abs() };
            (low - half, high + half)
        }
        (true, false) => (low - margin * (high - low), high + margin * (high - low)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_automatic_interval_ignores_what_cannot_be_shown() {
        let values = [f64::NAN, -3.0, 0.0, 10.0, 1000.0, f64::INFINITY];
        assert_eq!(interval(&Axis::log10("m"), values.into_iter(), 0.0), (10.0, 1000.0));
        assert_eq!(interval(&Axis::linear("m"), values.into_iter(), 0.0), (-3.0, 1000.0));
    }

    #[test]
    fn constant_and_missing_data_still_have_an_interval() {
        let (low, high) = interval(&Axis::linear("F"), [5.0, 5.0].into_iter(), 0.1);
        assert!(low < 5.0 && 5.0 < high);
        assert_eq!(interval(&Axis::log10("m"), std::iter::empty(), 0.1), (1.0, 10.0));
    }

    #[test]
    fn a_logarithmic_axis_has_no_place_for_zero_and_a_far_one_for_divergence() {
        let map = AxisMap { scale: Scale::Log10, low: 1.0, high: 100.0, start: 200.0, end: 0.0 };
        assert_eq!(map.position(10.0), Some(100.0));
        assert_eq!(map.position(0.0), None);
        assert_eq!(map.position(f64::NAN), None);
        assert!(map.position(f64::MAX).is_some_and(f64::is_finite));
    }
}

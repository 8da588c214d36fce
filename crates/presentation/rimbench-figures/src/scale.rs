//! From the values of an axis to positions on the page.

use super::chart::{Axis, Scale};
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
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log10 if value <= 0.0 => return None,
            Scale::Log10 => (value / self.low).log10() / (self.high / self.low).log10(),
            Scale::SymLog(power) => {
                let [value, low, high] = [value, self.low, self.high].map(|value| symmetric(value, power));
                (value - low) / (high - low)
            }
        };
        let position = self.start + share * (self.end - self.start);
        (!position.is_nan()).then(|| position.clamp(-FAR, FAR))
    }

    /// Chooses ticks, at most about `most` with a label.
    pub fn ticks(&self, most: usize) -> Ticks {
        match self.scale {
            Scale::Linear => ticks::linear(self.low, self.high, most),
            Scale::Log10 => ticks::logarithmic(self.low, self.high, most),
            Scale::SymLog(power) => ticks::symmetric(self.low, self.high, power, most),
        }
    }
}

/// The signed logarithm: linear within ± 10 to the power, with slope 1 there, and one more for each factor of ten
/// beyond.
fn symmetric(value: f64, power: i32) -> f64 {
    let share = value / 10f64.powi(power);
    if share.abs() <= 1.0 { share } else { share.signum() * (1.0 + share.abs().log10()) }
}

/// Settles the interval of an axis: the fixed one, or that of the values it can show, widened by `margin` of itself.
pub fn interval(axis: &Axis, values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let logarithmic = axis.scale == Scale::Log10;
    if let Some([low, high]) = axis.range
        && low < high
        && low.is_finite()
        && high.is_finite()
        && (!logarithmic || low > 0.0)
    {
        return (low, high);
    }
    let shown = values.filter(|value| value.is_finite() && (!logarithmic || *value > 0.0));
    let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if let (Scale::SymLog(power), true) = (axis.scale, low <= high) {
        // To the next power of ten, and across zero.
        let beyond = |value: f64| match value.abs() / 10f64.powi(power) {
            share if share <= 1.0 => 10f64.powi(power) * value.signum(),
            share => 10f64.powi(power) * 10f64.powi(share.log10().ceil() as i32) * value.signum(),
        };
        return (beyond(low).min(0.0), beyond(high).max(0.0));
    }
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
    fn a_signed_logarithmic_axis_keeps_the_sign_and_has_a_place_for_zero() {
        let map = AxisMap { scale: Scale::SymLog(-2), low: -1.0, high: 1.0, start: 0.0, end: 6.0 };
        let places = [-1.0, -0.1, -0.01, 0.0, 0.005, 0.01, 0.1, 1.0].map(|value| map.position(value).unwrap());
        let wanted = [0.0, 1.0, 2.0, 3.0, 3.5, 4.0, 5.0, 6.0];
        assert!(places.iter().zip(wanted).all(|(place, wanted)| (place - wanted).abs() < 1e-9), "{places:?}");
        assert_eq!(interval(&Axis::symlog("E", 1e-2), [-0.5, 3.0].into_iter(), 0.1), (-1.0, 10.0));
        assert_eq!(interval(&Axis::symlog("E", 1e-2), [2e-3, f64::NAN].into_iter(), 0.1), (0.0, 0.01));
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

//! By how much the scheme's model of the mechanics was wrong at the end of a macro step, as a force.

use super::coupling_scheme::Forecast;
use super::output_rates::OutputRates;
use super::ports::Ports;

/// The force by which the actuator has gone astray during a macro step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelDefect {
    /// Of several rows the largest, N.
    pub(crate) force: f64,
    /// The defect of each row over the largest force that it has had.
    pub(crate) relative: f64,
    /// Time until the next contact closes in the model, s, if one does.
    pub(crate) next_closing: Option<f64>,
}

/// Measures the defect of a scheme's model.
///
/// ```text
/// e = |K (s_model − s)|  at t_{k+1}        K = −∂Ḟ/∂w = −(R_w + D_s)
/// ```
/// `Ḟ = r + D u̇` with `u = (s, w)` and `ṡ = w`: `R_w = ∂r/∂w` is what the velocity does to the state (oil that is
/// displaced), `D_s` what the position does to the force at once (a spring). s_model is the motion that the actuator
/// was given, s the mechanics' own, known at the communication point without being asked for: no exchange is added.
#[derive(Debug, Clone)]
pub(crate) struct DefectMeter {
    rates: OutputRates,
    /// Largest magnitude of each force so far, N; at least what is negligible.
    largest: Vec<f64>,
}

impl DefectMeter {
    /// Makes room for the forces of an actuator with these ports.
    pub(crate) fn new(actuator: &Ports) -> Self {
        DefectMeter {
            rates: OutputRates::zeros(actuator.outputs.len(), actuator.inputs.len()),
            largest: actuator.outputs.iter().map(|port| port.quantity.negligible()).collect(),
        }
    }

    /// Lends room for how the forces move, to be filled before [`measure`](Self::measure).
    pub(crate) fn rates(&mut self) -> &mut OutputRates {
        &mut self.rates
    }

    /// Takes note of forces that the actuator has put out, N.
    pub(crate) fn note_forces(&mut self, forces: &[f64]) {
        for (largest, force) in self.largest.iter_mut().zip(forces) {
            *largest = largest.max(force.abs());
        }
    }

    /// Returns the defect of a model that stands at `forecast` where the mechanics stands at `position` (m).
    pub(crate) fn measure(&self, forecast: Forecast<'_>, position: &[f64]) -> ModelDefect {
        let m = self.largest.len();
        // What is not a number must not pass for a small one.
        let larger = |a: f64, b: f64| if b.is_nan() || b > a { b } else { a };
        let mut defect = ModelDefect { force: 0.0, relative: 0.0, next_closing: forecast.next_closing };
        for (i, largest) in self.largest.iter().enumerate() {
            let (r, d) = (&self.rates.rate_gain[2 * m * i..], &self.rates.feedthrough[2 * m * i..]);
            let force: f64 = (0..m).map(|j| (r[m + j] + d[j]) * (forecast.position[j] - position[j])).sum();
            defect.force = larger(defect.force, force.abs());
            defect.relative = larger(defect.relative, force.abs() / largest);
        }
        defect
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::{Port, Quantity};

    fn meter(rows: usize) -> DefectMeter {
        let ports = |count: usize, quantity| (0..count).map(|_| Port { name: "p".into(), quantity }).collect();
        DefectMeter::new(&Ports {
            inputs: ports(2 * rows, Quantity::Position),
            outputs: ports(rows, Quantity::Force),
            direct_feedthrough: true,
        })
    }

    /// A spring of 3 N/m at once, and oil of 5 N/m that follows the velocity: 8 N/m. A model that is 2 mm ahead is off
    /// by 16 mN, which is 1/250 of the 4 N that there have been.
    #[test]
    fn the_defect_is_the_stiffness_times_how_far_the_model_is_off() {
        let mut meter = meter(1);
        meter.rates().feedthrough.copy_from_slice(&[-3.0, -7.0]);
        meter.rates().rate_gain.copy_from_slice(&[11.0, -5.0]);
        meter.note_forces(&[-4.0]);
        meter.note_forces(&[1.0]);
        let defect = meter.measure(Forecast { position: &[1.002], next_closing: Some(0.5) }, &[1.0, 9.0]);
        approx::assert_relative_eq!(defect.force, 0.016, max_relative = 1e-12);
        approx::assert_relative_eq!(defect.relative, 0.004, max_relative = 1e-12);
        assert_eq!(defect.next_closing, Some(0.5));
    }

    #[test]
    fn of_several_rows_the_worst_counts_each_over_its_own_force_and_what_is_no_number_is_no_small_one() {
        let mut meter = meter(2);
        // Springs of 1 and 2 N/m, and 0.5 N/m from the second row to the first.
        meter.rates().feedthrough.copy_from_slice(&[-1.0, -0.5, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0]);
        meter.note_forces(&[10.0, 100.0]);
        let of = |meter: &DefectMeter, position: &[f64]| {
            let defect = meter.measure(Forecast { position, next_closing: None }, &[0.0, 0.0, 0.0, 0.0]);
            (defect.force, defect.relative)
        };
        // 1 + 0.5·2 = 2 N of 10 and 4 N of 100.
        assert_eq!(of(&meter, &[1.0, 2.0]), (4.0, 0.2));
        assert!(of(&meter, &[f64::NAN, 0.0]).1.is_nan());
    }
}

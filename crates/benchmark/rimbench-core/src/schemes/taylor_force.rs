//! The actuator's force over a macro step to second order, from its directional derivatives.

use crate::cosim::{Cubic, OutputRates};

/// Writes the force that the actuator puts out while the interface moves with velocity `w` and constant acceleration
/// `a`.
///
/// ```text
/// λ̃(τ) = λ_k + τ (r + D u̇) + ½ τ² (R u̇ + D ü)        u̇ = (w, a),  ü = (a, 0)
/// ```
/// It lacks the part of r̈ that comes from inner states: order 2, with a small constant.
pub(super) fn taylor_force(lambda: &[f64], rates: &OutputRates, [w, a]: [&[f64]; 2], rows: &mut [Cubic]) {
    let m = w.len();
    for (i, row) in rows.iter_mut().enumerate() {
        let (d, r) = (&rates.feedthrough[2 * m * i..2 * m * (i + 1)], &rates.rate_gain[2 * m * i..2 * m * (i + 1)]);
        let times = |gain: &[f64], position: &[f64], velocity: &[f64]| -> f64 {
            (0..m).map(|n| gain[n] * position[n] + gain[m + n] * velocity[n]).sum()
        };
        let slope = rates.rate[i] + times(d, w, a);
        let bend: f64 = d.iter().zip(a).map(|(d, a)| d * a).sum();
        *row = [lambda[i], slope, 0.5 * (times(r, w, a) + bend), 0.0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spring of 3 N/m and a damper of 2 N·s/m to the ground, moved by s = t + 2 t² (w = 1, a = 4):
    /// λ = −3 s − 2 ṡ = −2 − 11 t − 6 t².
    #[test]
    fn a_spring_and_a_damper_are_met_to_second_order() {
        let rates = OutputRates { rate: vec![0.0], feedthrough: vec![-3.0, -2.0], rate_gain: vec![0.0, 0.0] };
        let mut rows = [[0.0; 4]];
        taylor_force(&[-2.0], &rates, [&[1.0], &[4.0]], &mut rows);
        assert_eq!(rows[0], [-2.0, -11.0, -6.0, 0.0]);
    }
}

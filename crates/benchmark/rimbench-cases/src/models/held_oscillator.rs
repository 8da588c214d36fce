//! One linear oscillator under a load that is held within each step, or a polynomial of time, by several integrators.

use super::exponential::exponential;
use nalgebra::{Matrix3, Matrix6};
use rimbench_core::cosim::Cubic;

/// How a [`HeldOscillator`] is integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OscillatorIntegrator {
    /// Matrix exponential: no error at all, for a load that is a polynomial of time.
    Exact,
    /// Matrix exponential for a load that is held: of a load that changes within the step, the mean.
    ExactSampled,
    /// `v⁺ = v + h a(x, v)`, `x⁺ = x + h v⁺`.
    SemiImplicitEuler,
    /// Trapezoidal rule.
    Trapezoidal,
    /// Generalised-α with spectral parameters `α_m, α_f`, `γ = ½ − α_m + α_f`, `β = ¼(γ + ½)`; Newmark's average
    /// acceleration for `α_m = α_f = 0`. It carries the acceleration from step to step.
    GeneralisedAlpha {
        /// α_m.
        alpha_m: f64,
        /// α_f.
        alpha_f: f64,
    },
}

/// `ẍ + C ẋ + K x = b`, with `b` held for one step at a time, or a polynomial `Σ b_p τ^p` of degree 3 in it.
///
/// ```text
/// exact               [x v]⁺ = Φ [x v] + γ b       [Φ γ; 0 1] = exp(h [[0 1 0], [−K −C 1], [0 0 0]])
///                     [x v]⁺ = Φ [x v] + Σ_p p! b_p γ_p   [Φ γ_0 … γ_3; 0 N] = exp(h [[0 1 0 0 0 0], [−K −C 1 0 0 0], [0 0 0 1 0 0], …]):
///                     a chain of integrators makes the derivatives of b
/// trapezoidal         v⁺ (1 + hC/2 + h²K/4) = v (1 − hC/2 − h²K/4) + h (b − K x),   x⁺ = x + ½h (v + v⁺)
/// generalised-α       (1 − α_m) a⁺ + α_m a + C v_f + K x_f = b,   (·)_f = (1 − α_f)(·)⁺ + α_f (·)
/// ```
/// # Shapes and units
/// `K` 1/s², `C` 1/s, `b` m/s². The exponential is made once per step size.
#[derive(Debug, Clone)]
pub struct HeldOscillator {
    stiffness: f64,
    damping: f64,
    x: f64,
    v: f64,
    /// Acceleration carried by generalised-α; NaN before the first step.
    a: f64,
    integrator: OscillatorIntegrator,
    step: f64,
    /// First two rows of the exponential.
    exponential: [[f64; 3]; 2],
    /// The step of the exponential with the chain of integrators, and its γ_p, p! multiplied in.
    chain_step: f64,
    chain: [[f64; 2]; 4],
}

impl HeldOscillator {
    /// Builds the oscillator for `K` and `C`, at `start` (m, m/s).
    pub fn new(stiffness: f64, damping: f64, start: [f64; 2], integrator: OscillatorIntegrator) -> Self {
        let [x, v] = start;
        let exponential = [[0.0; 3]; 2];
        HeldOscillator {
            stiffness,
            damping,
            x,
            v,
            a: f64::NAN,
            integrator,
            step: f64::NAN,
            exponential,
            chain_step: f64::NAN,
            chain: [[0.0; 2]; 4],
        }
    }

    /// True if a load that is a polynomial of time is integrated as such.
    pub fn takes_polynomials(&self) -> bool {
        self.integrator == OscillatorIntegrator::Exact
    }

    /// Returns x, m.
    #[inline]
    pub fn position(&self) -> f64 {
        self.x
    }

    /// Returns v, m/s.
    #[inline]
    pub fn velocity(&self) -> f64 {
        self.v
    }

    /// Returns `ẍ` under load `b`, m/s².
    #[inline]
    pub fn acceleration(&self, load: f64) -> f64 {
        load - self.stiffness * self.x - self.damping * self.v
    }

    /// Tells whether the state is a number.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.x.is_finite() && self.v.is_finite()
    }

    /// Advances by `h` (s) under load `b` (m/s²).
    #[inline]
    pub fn advance(&mut self, load: f64, h: f64) {
        let (k, c, x, v) = (self.stiffness, self.damping, self.x, self.v);
        match self.integrator {
            OscillatorIntegrator::Exact | OscillatorIntegrator::ExactSampled => {
                if self.step != h {
                    self.exponentiate(h);
                }
                let [to_x, to_v] = &self.exponential;
                self.x = to_x[0] * x + to_x[1] * v + to_x[2] * load;
                self.v = to_v[0] * x + to_v[1] * v + to_v[2] * load;
            }
            OscillatorIntegrator::SemiImplicitEuler => {
                self.v = v + h * self.acceleration(load);
                self.x = x + h * self.v;
            }
            OscillatorIntegrator::Trapezoidal => {
                let half = 0.5 * h * c + 0.25 * h * h * k;
                self.v = (v * (1.0 - half) + h * (load - k * x)) / (1.0 + half);
                self.x = x + 0.5 * h * (v + self.v);
            }
            OscillatorIntegrator::GeneralisedAlpha { alpha_m, alpha_f } => {
                self.generalised_alpha(load, h, alpha_m, alpha_f);
            }
        }
    }

    /// Advances by `h` (s) under the load `Σ b_p τ^p` (m/s²), exactly; only for [`OscillatorIntegrator::Exact`].
    #[inline]
    pub fn advance_polynomial(&mut self, load: Cubic, h: f64) {
        debug_assert!(self.takes_polynomials());
        if self.chain_step != h {
            self.exponentiate_chain(h);
        }
        if self.step != h {
            self.exponentiate(h);
        }
        let (x, v) = (self.x, self.v);
        let [to_x, to_v] = &self.exponential;
        (self.x, self.v) = (to_x[0] * x + to_x[1] * v, to_v[0] * x + to_v[1] * v);
        for (b, [to_x, to_v]) in load.into_iter().zip(self.chain) {
            self.x += to_x * b;
            self.v += to_v * b;
        }
    }

    /// Advances by `h` where `pull(x, v)` (m/s²) adds to `load` and depends on the state in any way: semi-implicit
    /// Euler if that was asked for, else the classical Runge–Kutta rule of order 4.
    #[inline]
    pub fn advance_with(&mut self, load: f64, pull: impl Fn(f64, f64) -> f64, h: f64) {
        let (k, c) = (self.stiffness, self.damping);
        let a = |x: f64, v: f64| load - k * x - c * v + pull(x, v);
        let (x, v) = (self.x, self.v);
        if self.integrator == OscillatorIntegrator::SemiImplicitEuler {
            self.v = v + h * a(x, v);
            self.x = x + h * self.v;
            return;
        }
        let (v1, a1) = (v, a(x, v));
        let (v2, a2) = (v + 0.5 * h * a1, a(x + 0.5 * h * v1, v + 0.5 * h * a1));
        let (v3, a3) = (v + 0.5 * h * a2, a(x + 0.5 * h * v2, v + 0.5 * h * a2));
        let (v4, a4) = (v + h * a3, a(x + h * v3, v + h * a3));
        self.x = x + h / 6.0 * (v1 + 2.0 * (v2 + v3) + v4);
        self.v = v + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4);
    }

    fn exponentiate(&mut self, h: f64) {
        let generator = Matrix3::new(0.0, 1.0, 0.0, -self.stiffness, -self.damping, 1.0, 0.0, 0.0, 0.0);
        let exponential = exponential(&(generator * h));
        for (row, values) in self.exponential.iter_mut().enumerate() {
            *values = [exponential[(row, 0)], exponential[(row, 1)], exponential[(row, 2)]];
        }
        self.step = h;
    }

    fn exponentiate_chain(&mut self, h: f64) {
        let mut generator = Matrix6::zeros();
        (generator[(0, 1)], generator[(1, 0)], generator[(1, 1)]) = (1.0, -self.stiffness, -self.damping);
        for row in 1..5 {
            generator[(row, row + 1)] = 1.0;
        }
        let exponential = exponential(&(generator * h));
        let mut factorial = 1.0;
        for (power, gain) in self.chain.iter_mut().enumerate() {
            factorial *= power.max(1) as f64;
            *gain = [factorial * exponential[(0, 2 + power)], factorial * exponential[(1, 2 + power)]];
        }
        self.chain_step = h;
    }

    fn generalised_alpha(&mut self, load: f64, h: f64, alpha_m: f64, alpha_f: f64) {
        let (k, c, x, v) = (self.stiffness, self.damping, self.x, self.v);
        if self.a.is_nan() {
            self.a = self.acceleration(load);
        }
        let a = self.a;
        let gamma = 0.5 - alpha_m + alpha_f;
        let beta = 0.25 * (gamma + 0.5);
        let new = 1.0 - alpha_f;
        let (x_free, v_free) = (x + h * v + h * h * (0.5 - beta) * a, v + h * (1.0 - gamma) * a);
        let known = load - alpha_m * a - c * (new * v_free + alpha_f * v) - k * (new * x_free + alpha_f * x);
        self.a = known / (1.0 - alpha_m + new * h * (gamma * c + beta * h * k));
        self.x = x_free + beta * h * h * self.a;
        self.v = v_free + gamma * h * self.a;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const NEWMARK: OscillatorIntegrator = OscillatorIntegrator::GeneralisedAlpha { alpha_m: 0.0, alpha_f: 0.0 };

    /// `x(1)` from (0.3, −2) with K = 50, C = 0.4 under b = 3.
    fn after_one_second(integrator: OscillatorIntegrator, steps: usize) -> f64 {
        let mut oscillator = HeldOscillator::new(50.0, 0.4, [0.3, -2.0], integrator);
        (0..steps).for_each(|_| oscillator.advance(3.0, 1.0 / steps as f64));
        oscillator.position()
    }

    fn closed_form() -> f64 {
        let (k, c, b): (f64, f64, f64) = (50.0, 0.4, 3.0);
        let (omega, rest) = ((k - 0.25 * c * c).sqrt(), b / k);
        let (cosine, sine) = (0.3 - rest, (-2.0 + 0.5 * c * (0.3 - rest)) / omega);
        rest + libm::exp(-0.5 * c) * (cosine * libm::cos(omega) + sine * libm::sin(omega))
    }

    #[test]
    fn the_other_integrators_converge_with_their_order() {
        let damped = OscillatorIntegrator::GeneralisedAlpha { alpha_m: 0.2, alpha_f: 0.4 };
        for (integrator, order) in [
            (OscillatorIntegrator::SemiImplicitEuler, 1.0),
            (OscillatorIntegrator::Trapezoidal, 2.0),
            (NEWMARK, 2.0),
            (damped, 2.0),
        ] {
            let error = |steps| (after_one_second(integrator, steps) - closed_form()).abs();
            let observed = libm::log2(error(400) / error(800));
            assert!((observed - order).abs() < 0.1, "{integrator:?}: {observed}");
        }
    }

    #[test]
    fn newmark_with_average_acceleration_is_the_trapezoidal_rule_while_the_load_is_held() {
        let trapezoidal = after_one_second(OscillatorIntegrator::Trapezoidal, 100);
        assert_relative_eq!(after_one_second(NEWMARK, 100), trapezoidal, epsilon = 1e-12);
    }
}

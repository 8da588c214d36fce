//! Polynomial inputs as such: the limits of the two-mass oscillator with both sides exact, by the loop and by a
//! recurrence that shares no code with it.

use crate::oscillator_theory::{self, HOLDS, K};
use crate::support::*;
use nalgebra::{DMatrix, DVector};
use rimbench::harness::spectral_radius;

const COUPLINGS: [&str; 3] = ["displacement-displacement", "force-force", "force-displacement"];

/// The macro-step map on paper of masses of 1 kg, springs `K` and dampers of `c` N·s/m: both sides exact over H with
/// their input a polynomial through the last samples.
///
/// ```text
/// ẋ = A x + B u(τ),  u(τ) = Σ_j u_{k−j} L_j(τ/H)        x(H) = Φ x_k + Σ_j G_j u_{k−j}
/// [Φ Γ_0 Γ_1 …] = first rows of exp(H [A B 0; 0 0 I; 0 0 0])
/// ```
struct Paper {
    /// Per side: A, B, and C that makes the input from z = (x₁, v₁, x₂, v₂).
    sides: [(DMatrix<f64>, DMatrix<f64>, DMatrix<f64>); 2],
}

impl Paper {
    fn new(coupling: &str, c: f64) -> Self {
        let walled = |k: f64, c: f64| DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -k, -c]);
        let motion = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, K[1], c]);
        let force = |sign: f64| DMatrix::from_row_slice(2, 1, &[0.0, sign]);
        let of = |first: usize| DMatrix::from_fn(2, 4, |i, j| f64::from(u8::from(j == first + i)));
        let tension = DMatrix::from_row_slice(1, 4, &[K[1], c, -K[1], -c]);
        let element = |index: usize| {
            let k = [K[0], K[2]][index] + K[1];
            (walled(k, 2.0 * c), motion.clone(), of(2 - 2 * index))
        };
        let free = |index: usize| (walled([K[0], K[2]][index], c), force([-1.0, 1.0][index]), tension.clone());
        let sides = match coupling {
            "displacement-displacement" => [element(0), element(1)],
            "force-force" => [free(0), free(1)],
            _ => [element(0), free(1)],
        };
        Paper { sides }
    }

    fn spectral_radius(&self, order: usize, h: f64) -> f64 {
        let width = 4 * (order + 1);
        let mut map = DMatrix::zeros(width, width);
        for (side, (a, b, input)) in self.sides.iter().enumerate() {
            let (d, m) = (2, b.ncols());
            let size = d + m * (order + 1);
            let mut generator = DMatrix::zeros(size, size);
            generator.view_mut((0, 0), (d, d)).copy_from(a);
            generator.view_mut((0, d), (d, m)).copy_from(b);
            for p in 0..order {
                generator.view_mut((d + m * p, d + m * (p + 1)), (m, m)).fill_with_identity();
            }
            let exponential = (generator * h).exp();
            let mut own = map.view_mut((2 * side, 2 * side), (2, 2));
            own += exponential.view((0, 0), (d, d));
            for j in 0..=order {
                let mut gain = DMatrix::zeros(d, m);
                let mut factorial = 1.0;
                for p in 0..=order {
                    factorial *= p.max(1) as f64;
                    let weight = factorial * lagrange_coefficient(order, j, p) / h.powi(p as i32);
                    gain += weight * exponential.view((0, d + m * p), (d, m));
                }
                let mut from = map.view_mut((2 * side, 4 * j), (2, 4));
                from += gain * input;
            }
        }
        for j in 1..=order {
            map.view_mut((4 * j, 4 * (j - 1)), (4, 4)).fill_with_identity();
        }
        map.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    }
}

/// Coefficient of θ^p in L_j, nodes 0, −1, …, −order.
fn lagrange_coefficient(order: usize, j: usize, p: usize) -> f64 {
    let vandermonde = DMatrix::from_fn(order + 1, order + 1, |row, column| (-(row as f64)).powi(column as i32));
    let unit = DVector::from_fn(order + 1, |row, _| f64::from(u8::from(row == j)));
    vandermonde.lu().solve(&unit).unwrap()[p]
}

/// First macro step, going up by 0.05 ms to 60 ms, at which a map grows, by bisection; ms.
fn limit_ms(radius: impl Fn(f64) -> f64) -> f64 {
    let grid = (1..1200).map(|step| 0.05e-3 * f64::from(step));
    let Some(mut high) = grid.into_iter().find(|&h| radius(h) > 1.0 + 1e-12) else { return f64::INFINITY };
    let mut low = high - 0.05e-3;
    while high / low.max(1e-9) > 1.0 + 1e-8 {
        let middle = 0.5 * (low + high);
        if radius(middle) > 1.0 { high = middle } else { low = middle }
    }
    1e3 * low
}

/// The case with one step per side and macro step, unless changed afterwards.
fn spec(coupling: &str, hold: &str, sequence: &str, macro_step: f64, set: &[(&str, &str)]) -> RunSpec {
    let set = [&[("variant", "1"), ("coupling", coupling)], set].concat();
    let spec = oscillator_theory::spec("linear-oscillator", &set, hold, sequence, macro_step);
    spec.changed(|own| own.mechanics_steps = usual_spec("linear-oscillator", hold, macro_step).mechanics_steps)
}

/// Displacement–displacement, force–force, force–displacement; order 0, 1, 2; ms.
const LIMITS: [[f64; 3]; 3] =
    [[2.22237, 14.30257, 29.77306], [0.36694, 7.97655, 35.74106], [0.37000, 8.00036, 30.32072]];

#[test]
fn the_limits_with_polynomial_inputs_are_those_of_two_independent_computations() {
    for (coupling, limits) in COUPLINGS.into_iter().zip(LIMITS) {
        let paper = Paper::new(coupling, 0.01);
        for (order, limit) in limits.into_iter().enumerate() {
            let found = limit_ms(|h| paper.spectral_radius(order, h));
            assert!((found / limit - 1.0).abs() < 1e-4, "{coupling} order {order}: {found} ms");
            // The loop itself, on both sides of the limit.
            let probed = |h: f64| spectral_radius(&spec(coupling, HOLDS[order], "jacobi", h, &[])).unwrap();
            let h = 1e-3 * found;
            assert!(probed(0.9999 * h) < 1.0 && probed(1.0001 * h) > 1.0, "{coupling} order {order} at {found} ms");
        }
    }
}

#[test]
fn the_map_of_the_loop_is_the_recurrence_on_paper() {
    for coupling in COUPLINGS {
        for (variant, c) in [("0", 0.0), ("1", 0.01)] {
            let paper = Paper::new(coupling, c);
            for (order, hold) in HOLDS.into_iter().enumerate() {
                for h in [1e-3, 1e-2, 3e-2] {
                    let probed = spectral_radius(&spec(coupling, hold, "jacobi", h, &[("variant", variant)])).unwrap();
                    let radius = paper.spectral_radius(order, h);
                    assert!((probed / radius - 1.0).abs() < 1e-8, "{coupling} {hold} {h} s: {probed}, {radius}");
                }
            }
        }
    }
}

/// With the mechanics first its sample at t_{k+1} is the newest node; force–displacement.
#[test]
fn the_limits_with_the_mechanics_first_are_those_of_the_independent_computation() {
    for (order, limit) in [0.4440, 8.2455, 35.7043].into_iter().enumerate() {
        let sequence = "gauss-seidel-mechanics-first";
        let probed = |h: f64| spectral_radius(&spec(COUPLINGS[2], HOLDS[order], sequence, 1e-3 * h, &[])).unwrap();
        assert!(probed(0.999 * limit) < 1.0 && probed(1.001 * limit) > 1.0, "order {order}");
    }
}

/// A side that holds the mean over each of its micro steps is the polynomial side in the limit, with the square of δ.
#[test]
fn means_over_micro_steps_tend_to_the_polynomial_with_the_square_of_the_micro_step() {
    for coupling in COUPLINGS {
        for hold in &HOLDS[1..] {
            let h = 1e-2;
            let exact = spectral_radius(&spec(coupling, hold, "jacobi", h, &[])).unwrap();
            let off = |micro_steps: f64| {
                let mut sampled = spec(coupling, hold, "jacobi", h, &[("integrator", "exact-sampled")]);
                sampled = sampled.changed(|own| {
                    (own.micro_step, own.mechanics_steps) = (h / micro_steps, MechanicsSteps::AsActuator)
                });
                (spectral_radius(&sampled).unwrap() - exact).abs()
            };
            let order = (off(4.0) / off(8.0)).log2();
            assert!((order - 2.0).abs() < 0.05, "{coupling} {hold}: {order}");
        }
    }
}

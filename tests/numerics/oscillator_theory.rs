//! The two-mass cases against theory: exact solutions, growth rates by two routes, orders, reduced interface models.

use crate::support::*;
use nalgebra::{DMatrix, DVector};
use rimbench::harness::spectral_radius;

/// One sample per step of each side: the mean of its input, held. What the recurrences on paper describe; the case's
/// own `exact` takes polynomials as such (see `polynomial_inputs.rs`).
const SAMPLED: (&str, &str) = ("integrator", "exact-sampled");
const COUPLINGS: [&str; 3] = ["force-displacement", "displacement-displacement", "force-force"];
pub const HOLDS: [&str; 3] = ["zero-order-hold", "first-order-hold", "second-order-hold"];

/// A run with one micro step per macro step and one step of the mechanics, unless changed afterwards.
pub fn spec(case: &str, set: &[(&str, &str)], scheme: &str, sequence: &str, macro_step: f64) -> RunSpec {
    let spec = in_sequence(set_spec(case, set, scheme, macro_step), sequence.parse().unwrap());
    spec.changed(|own| (own.micro_step, own.mechanics_steps) = (macro_step, ONE))
}

fn exact(spec: &RunSpec, t: f64) -> Vec<f64> {
    exact_row(&spec.case, &spec.parameters, t)
}

/// Undamped normal modes, the second way to the exact solution: `x(t) = Σ φ (φᵀ x₀ cos ωt + φᵀ v₀ sin(ωt)/ω)`.
fn normal_modes(k: [f64; 3], start: [f64; 4], t: f64) -> [f64; 2] {
    let stiffness = nalgebra::Matrix2::new(k[0] + k[1], -k[1], -k[1], k[2] + k[1]);
    let modes = stiffness.symmetric_eigen();
    let mut x = [0.0; 2];
    for mode in 0..2 {
        let (omega, shape) = (modes.eigenvalues[mode].sqrt(), modes.eigenvectors.column(mode));
        let (x0, v0) = (shape[0] * start[0] + shape[1] * start[1], shape[0] * start[2] + shape[1] * start[3]);
        let coordinate = x0 * (omega * t).cos() + v0 / omega * (omega * t).sin();
        x[0] += shape[0] * coordinate;
        x[1] += shape[1] * coordinate;
    }
    x
}

#[test]
fn exact_solutions_are_exact() {
    let lim = spec("linear-oscillator", &[], "zero-order-hold", "jacobi", 1e-3);
    let precice = spec("precice-oscillator", &[], "zero-order-hold", "jacobi", 1e-2);
    for step in 0..=200 {
        let t = 0.05 * step as f64;
        let (ours, theirs) = (exact(&lim, t), normal_modes([10.0, 100.0, 1000.0], [0.0, 0.0, 100.0, -100.0], t));
        for i in 0..2 {
            assert!((ours[1 + i] - theirs[i]).abs() < 1e-10, "{t} s: {} and {}", ours[1 + i], theirs[i]);
        }
        assert!((ours[5] / 1e4 - 1.0).abs() < 1e-11, "energy {} J at {t} s", ours[5]);
        let t = t / 10.0;
        let (slow, fast) = ((std::f64::consts::TAU * t).cos(), (3.0 * std::f64::consts::TAU * t).cos());
        let ours = exact(&precice, t);
        assert!((ours[1] - 0.5 * (slow + fast)).abs() < 1e-12 && (ours[2] - 0.5 * (slow - fast)).abs() < 1e-12);
    }
}

/// The damped and the loaded solution have no normal modes; they must satisfy the equations of motion.
#[test]
fn exact_solutions_satisfy_the_equations_of_motion() {
    let damped = spec("linear-oscillator", &[("variant", "1")], "zero-order-hold", "jacobi", 1e-3);
    let car = spec("quarter-car", &[], "zero-order-hold", "jacobi", 1e-3);
    for step in 1..40 {
        let t = 0.01 * step as f64;
        let rate =
            |spec: &RunSpec, column: usize| (exact(spec, t + 1e-5)[column] - exact(spec, t - 1e-5)[column]) / 2e-5;
        let z = exact(&damped, t);
        let force = 100.0 * (z[1] - z[2]) + 0.01 * (z[3] - z[4]);
        assert!((z[6] - force).abs() < 1e-9);
        assert!((rate(&damped, 1) - z[3]).abs() < 1e-4);
        assert!((rate(&damped, 3) - (-10.0 * z[1] - 0.01 * z[3] - force)).abs() < 1e-3);
        assert!((rate(&damped, 4) - (-1000.0 * z[2] - 0.01 * z[4] + force)).abs() < 1e-3);
        let z = exact(&car, t);
        let force = 15_000.0 * (z[1] - z[2]) + 1000.0 * (z[3] - z[4]);
        assert!((400.0 * rate(&car, 3) + force).abs() < 1e-2);
        assert!((40.0 * rate(&car, 4) - (150_000.0 * (0.1 - z[2]) + force)).abs() < 1e-2);
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Growth rates, second route: the recurrence of one macro step written down without the loop.

/// `ẍ = −K x − C v + b` over a step `h` with `b` held, in closed form: `(x, v)⁺ = Φ (x, v) + γ b`.
struct Held {
    phi: [[f64; 2]; 2],
    gamma: [f64; 2],
}

impl Held {
    fn new(k: f64, c: f64, h: f64) -> Self {
        let (omega, decay) = ((k - 0.25 * c * c).sqrt(), (-0.5 * c * h).exp());
        let (cos, sin) = ((omega * h).cos(), (omega * h).sin() / omega);
        let phi = [[decay * (cos + 0.5 * c * sin), decay * sin], [-decay * k * sin, decay * (cos - 0.5 * c * sin)]];
        // The rest position moves to b/K.
        Held { phi, gamma: [(1.0 - phi[0][0]) / k, -phi[1][0] / k] }
    }

    fn step(&self, z: [f64; 2], b: f64) -> [f64; 2] {
        [0, 1].map(|i| self.phi[i][0] * z[0] + self.phi[i][1] * z[1] + self.gamma[i] * b)
    }
}

/// Weights of the samples at `t_k, t_{k−1}, …` (in units of H) in the mean of the polynomial through them over
/// `from … to`: Simpson's rule, exact up to degree 3.
fn lagrange_mean(points: &[f64], from: f64, to: f64) -> Vec<f64> {
    let weight = |j: usize, at: f64| -> f64 {
        (0..points.len()).filter(|&i| i != j).map(|i| (at - points[i]) / (points[j] - points[i])).product()
    };
    let mean = |j| (weight(j, from) + 4.0 * weight(j, 0.5 * (from + to)) + weight(j, to)) / 6.0;
    (0..points.len()).map(mean).collect()
}

/// What is on paper: the coupling, the polynomial's degree, the sequence, micro steps N per macro step, damping, H.
#[derive(Clone, Copy)]
struct Paper<'a> {
    coupling: &'a str,
    order: usize,
    sequence: &'a str,
    micro_steps: usize,
    damping: f64,
    macro_step: f64,
}

pub const K: [f64; 3] = [10.0, 100.0, 1000.0];

impl Paper<'_> {
    /// Input of the actuator side in units of force, from the other mass: `k_c x₂ + c v₂`, or the coupling force itself
    /// where the actuator is the bare element.
    fn actuator_input(&self, z: &[f64; 4]) -> f64 {
        match self.coupling {
            "force-force" => self.force(z),
            _ => K[1] * z[2] + self.damping * z[3],
        }
    }

    /// Input of the mechanics side in units of force.
    fn mechanics_input(&self, z: &[f64; 4]) -> f64 {
        match self.coupling {
            "displacement-displacement" => K[1] * z[0] + self.damping * z[1],
            _ => self.force(z),
        }
    }

    fn force(&self, z: &[f64; 4]) -> f64 {
        K[1] * (z[0] - z[2]) + self.damping * (z[1] - z[3])
    }

    /// One macro step of the LIM oscillator (all masses 1) from the states `(x₁, v₁, x₂, v₂)` at k, k−1, …: the
    /// actuator in N micro steps with the mean of its input over each, the mechanics in one step with one sample: the
    /// mean.
    fn step(&self, past: &[[f64; 4]]) -> [f64; 4] {
        let (now, c, h) = (past[0], self.damping, self.macro_step);
        let behind: Vec<f64> = (0..=self.order).map(|j| -(j as f64)).collect();
        let predicted = |value: &dyn Fn(&[f64; 4]) -> f64, from: f64, to: f64| -> f64 {
            lagrange_mean(&behind, from, to).iter().zip(past).map(|(weight, z)| weight * value(z)).sum()
        };
        let both = self.coupling == "displacement-displacement";
        let mass_2 = Held::new(K[2] + if both { K[1] } else { 0.0 }, if both { 2.0 * c } else { c }, h);
        let advance = |input: f64| mass_2.step([now[2], now[3]], input);
        let mechanics_first = self.sequence == "gauss-seidel-mechanics-first";
        let ahead = advance(predicted(&|z| self.mechanics_input(z), 0.0, 1.0));

        // The actuator. With the mechanics first its polynomial goes through t_{k+1} too, and interpolates.
        let after = [f64::NAN, f64::NAN, ahead[0], ahead[1]];
        let n = self.micro_steps as f64;
        let micro = Held::new(K[0] + K[1], 2.0 * c, h / n);
        let mut z1 = [now[0], now[1]];
        let (mut input, mut sent) = (self.actuator_input(&now), 0.0);
        for j in 0..self.micro_steps {
            sent += match self.coupling {
                "force-displacement" => K[1] * z1[0] + c * z1[1] - input,
                "displacement-displacement" => K[1] * z1[0] + c * z1[1],
                _ => input,
            } / n;
            let (from, to) = (j as f64 / n, (j + 1) as f64 / n);
            input = if mechanics_first && self.coupling != "force-force" {
                let points: Vec<f64> = (0..=self.order).map(|j| 1.0 - j as f64).collect();
                let weights = lagrange_mean(&points, from, to);
                let known = weights[1..].iter().zip(past).map(|(weight, z)| weight * self.actuator_input(z));
                weights[0] * self.actuator_input(&after) + known.sum::<f64>()
            } else {
                predicted(&|z| self.actuator_input(z), from, to)
            };
            z1 = micro.step(z1, input);
        }
        // Actuator first: the mechanics receives the mean of what was sent; else what it predicts itself.
        let received =
            if self.sequence == "gauss-seidel" { sent } else { predicted(&|z| self.mechanics_input(z), 0.0, 1.0) };
        let z2 = advance(received);
        if self.coupling == "force-force" {
            z1 = Held::new(K[0], c, h).step([now[0], now[1]], -received);
        }
        [z1[0], z1[1], z2[0], z2[1]]
    }

    fn spectral_radius(&self) -> f64 {
        let width = 4 * (self.order + 1);
        let mut companion = DMatrix::zeros(width, width);
        for column in 0..width {
            let mut past = vec![[0.0; 4]; self.order + 1];
            past[column / 4][column % 4] = 1.0;
            companion.view_mut((0, column), (4, 1)).copy_from(&DVector::from_column_slice(&self.step(&past)));
            if column + 4 < width {
                companion[(column + 4, column)] = 1.0;
            }
        }
        companion.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    }
}

#[test]
fn growth_rates_by_probing_the_loop_and_by_the_recurrence_on_paper_agree() {
    let mut worst = (0.0, String::new());
    for (variant, damping) in [("0", 0.0), ("1", 0.01)] {
        for coupling in COUPLINGS {
            for (order, hold) in HOLDS.into_iter().enumerate() {
                for sequence in ["jacobi", "gauss-seidel", "gauss-seidel-mechanics-first"] {
                    for (macro_step, micro_steps) in [(1e-3, 1), (1e-2, 1), (1e-2, 7), (5e-2, 10)] {
                        let paper = Paper { coupling, order, sequence, micro_steps, damping, macro_step };
                        let set = [("variant", variant), ("coupling", coupling), SAMPLED];
                        let mut spec = spec("linear-oscillator", &set, hold, sequence, macro_step);
                        spec = spec.changed(|own| own.micro_step = macro_step / micro_steps as f64);
                        let probed = spectral_radius(&spec).unwrap();
                        let difference = (probed - paper.spectral_radius()).abs() / probed.max(1.0);
                        if difference > worst.0 {
                            let what = format!("{variant} {coupling} {hold} {sequence} {macro_step} / {micro_steps}");
                            worst = (difference, what);
                        }
                    }
                }
            }
        }
    }
    assert!(worst.0 < 1e-8, "{worst:?}");
}

/// Undamped, ln ρ / H by the loop.
fn growth_rate(coupling: &str, hold: &str, sequence: &str, macro_step: f64) -> f64 {
    let spec = spec("linear-oscillator", &[("coupling", coupling), SAMPLED], hold, sequence, macro_step);
    spectral_radius(&spec).unwrap().ln() / macro_step
}

#[test]
fn an_undamped_oscillator_has_no_stable_step_with_a_zero_order_hold_and_jacobi() {
    for coupling in COUPLINGS {
        for macro_step in [1e-5, 1e-4, 1e-3, 1e-2, 3e-2] {
            let rate = growth_rate(coupling, HOLDS[0], "jacobi", macro_step);
            assert!(rate > 0.0, "{coupling} at H = {macro_step}: {rate}");
        }
        // 0.1 ms to 0.29 s.
        for step in 0..2000 {
            let h = 1e-4 * 1.004_f64.powi(step);
            let paper = Paper { coupling, order: 0, sequence: "jacobi", micro_steps: 1, damping: 0.0, macro_step: h };
            assert!(paper.spectral_radius() > 1.0, "{coupling} at H = {h}");
        }
    }
}

/// Two exceptions worth knowing: exchanged displacements with the mechanics first make a map that keeps its energy
/// bounded (ρ = 1), and the second-order hold of the force itself damps.
#[test]
fn some_explicit_couplings_do_not_create_energy() {
    for macro_step in [1e-3, 5e-3, 1e-2, 2e-2] {
        let neutral = growth_rate(COUPLINGS[1], HOLDS[0], "gauss-seidel-mechanics-first", macro_step);
        assert!(neutral.abs() < 1e-9, "{macro_step}: {neutral}");
        let damped = growth_rate(COUPLINGS[2], HOLDS[2], "jacobi", macro_step);
        assert!(damped < 0.0, "{macro_step}: {damped}");
    }
}

#[test]
fn energy_grows_as_the_spectral_radius_says() {
    for (coupling, hold, macro_step) in [
        ("force-displacement", HOLDS[0], 5e-3),
        ("displacement-displacement", HOLDS[0], 1e-2),
        ("force-force", HOLDS[1], 2e-2),
        ("force-displacement", HOLDS[2], 2e-2),
    ] {
        let mut spec = spec("linear-oscillator", &[("coupling", coupling)], hold, "jacobi", macro_step);
        let expected = 2.0 * spectral_radius(&spec).unwrap().ln() / macro_step;
        // Long enough for the fastest mode to be alone, short of overflow.
        spec = spec.changed(|own| own.duration = (200.0 / expected).max(20.0));
        let trajectory = completed(&spec).trajectory;
        let late: Vec<(f64, f64)> =
            trajectory.rows().skip(trajectory.len() / 2).map(|row| (row[0], row[5].ln())).collect();
        let n = late.len() as f64;
        let (mean_t, mean_e) = late.iter().fold((0.0, 0.0), |(t, e), point| (t + point.0 / n, e + point.1 / n));
        let slope = late.iter().map(|(t, e)| (t - mean_t) * (e - mean_e)).sum::<f64>()
            / late.iter().map(|(t, _)| (t - mean_t).powi(2)).sum::<f64>();
        assert!((slope / expected - 1.0).abs() < 5e-3, "{coupling} {hold}: {slope} instead of {expected} 1/s");
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Orders: what is special. That every scheme has its declared order is checked in `schemes.rs`.

/// Order over H, 2 H, 4 H; `change` adapts each run.
fn measured_order(
    case: &str,
    set: &[(&str, &str)],
    scheme: &str,
    finest: f64,
    change: impl Fn(&mut RunSettings),
) -> f64 {
    let sequence = scheme_by_name(scheme).sequence.to_string();
    let points = [1.0, 2.0, 4.0].map(|times| {
        let spec = spec(case, set, scheme, &sequence, times * finest).changed(&change);
        (times * finest, error_of_positions(&spec, &completed(&spec).trajectory))
    });
    order_of_convergence(&points).unwrap()
}

/// The full first step shows on the quarter car, whose damper force rises from the start.
#[test]
fn a_constant_first_step_costs_the_second_order_hold_its_third_order() {
    let set = [("coupling", "force-displacement")];
    let order = measured_order("quarter-car", &set, HOLDS[2], 5e-4, |spec| {
        (spec.micro_step, spec.mechanics_steps, spec.duration) = (1e-5, ALL, 1.0);
    });
    assert!((order - 2.0).abs() < 0.15, "{order}");
}

/// A mechanics of order 1 that takes one step per macro step leaves order 1 of what an interface model has with an
/// exact one.
#[test]
fn an_interface_model_has_no_more_than_the_order_of_the_mechanics() {
    for (case, set, finest) in &SMOOTH[..2] {
        for coupling in ["force-displacement", "force-force"] {
            let set = [*set, &[("coupling", coupling), ("integrator", "semi-implicit-euler")]].concat();
            let short = |spec: &mut RunSettings| (spec.micro_step, spec.duration) = (1e-6, 0.4);
            let order = measured_order(case, &set, "rim-smooth", 2.0 * finest, short);
            assert!((order - 1.0).abs() < 0.15, "{case} {coupling}: {order}");
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Reduced interface models.

/// Where nothing but the interface force acts on the mechanics, `H` and `a` do not change: the model is the mechanics.
/// With the forces returned as they acted, a run at H = 50 δ is the run at H = δ, whatever H. A spring at the mechanics
/// changes `a` within the macro step and ends that.
#[test]
fn the_smooth_interface_model_is_exact_for_a_free_mass() {
    let end = |stiffness: &str, macro_step: f64| {
        let set = [("stiffness_2_n_m", stiffness), ("integrator", "semi-implicit-euler")];
        let mut spec = spec("linear-oscillator", &set, "rim-smooth", "gauss-seidel", macro_step);
        spec = spec.changed(|own| own.force_return = "profile".parse().unwrap());
        spec = spec.changed(|own| (own.micro_step, own.mechanics_steps, own.duration) = (1e-4, ALL, 2.0));
        let trajectory = completed(&spec).trajectory;
        trajectory.row(trajectory.len() - 1).to_vec()
    };
    for macro_step in [5e-3, 5e-2] {
        let (coarse, fine) = (end("0", macro_step), end("0", 1e-4));
        for column in 1..5 {
            let difference = (coarse[column] - fine[column]).abs();
            assert!(difference < 1e-9, "free mass at H = {macro_step}, column {column}: {difference:e}");
        }
    }
    assert!((end("1000", 5e-3)[2] - end("1000", 1e-4)[2]).abs() > 1e-6);
}

/// First macro step, going up from 1 µs by 3 %, at which a run grows.
fn first_unstable(radius: impl Fn(f64) -> f64) -> f64 {
    let grid = (0..).map(|step| 1e-6 * 1.03_f64.powi(step)).take_while(|&h| h < 0.3);
    let unstable = |h: f64| radius(h) > 1.0 + 1e-12;
    let Some(mut high) = grid.into_iter().find(|&h| unstable(h)) else { return f64::INFINITY };
    let mut low = high / 1.03;
    while high / low > 1.0 + 1e-7 {
        let middle = (low * high).sqrt();
        if unstable(middle) { high = middle } else { low = middle }
    }
    high
}

/// Growth rates of variant 0 (1/s) at 1 and 10 ms and limits of variant 1 (ms), to which
/// `docs/results/published-oscillators.md` refers: one sample per macro step on each side, the mean of its input. Those
/// with polynomial inputs are in `polynomial_inputs.rs`.
#[test]
fn the_tables_of_growth_rates_and_limits_stand() {
    let close = |measured: f64, table: f64| (measured / table - 1.0).abs() < 1e-3;
    let (jacobi, actuator, mechanics) = ("jacobi", "gauss-seidel", "gauss-seidel-mechanics-first");
    for (coupling, order, rates, limits) in [
        (COUPLINGS[0], 0, [2.970e-2, 2.930e-1, 2.475e-2, 2.448e-1], [0.370, 0.370, 0.444]),
        (COUPLINGS[0], 1, [1.648e-5, 1.638e-2, 1.511e-5, 1.490e-2], [8.811, 0.4036, 9.081]),
        (COUPLINGS[0], 2, [3.527e-7, 3.501e-4, 1.464e-7, 1.452e-4], [30.182, 0.4036, 41.727]),
        (COUPLINGS[1], 0, [4.949e-3, 4.818e-2, 0.0, 0.0], [2.222, 2.222, f64::INFINITY]),
        (COUPLINGS[1], 1, [2.748e-6, 2.793e-3, 1.373e-6, 1.324e-3], [15.79, 4.373, 21.21]),
        (COUPLINGS[1], 2, [3.713e-7, 3.684e-4, 1.650e-7, 1.636e-4], [29.659, 4.530, 39.902]),
        (COUPLINGS[2], 0, [2.995e-2, 2.953e-1, 2.995e-2, 2.953e-1], [0.3669, 0.3669, 0.3669]),
        (COUPLINGS[2], 1, [1.662e-5, 1.653e-2, 1.662e-5, 1.653e-2], [8.785, 0.3669, 8.785]),
        (COUPLINGS[2], 2, [-1.504e-6, -1.491e-3, -1.504e-6, -1.491e-3], [42.783, 0.3669, 42.783]),
    ] {
        let runs = [(jacobi, 1e-3), (jacobi, 1e-2), (mechanics, 1e-3), (mechanics, 1e-2)];
        for ((sequence, macro_step), table) in runs.into_iter().zip(rates) {
            let rate = growth_rate(coupling, HOLDS[order], sequence, macro_step);
            assert!((rate - table).abs() < 1e-3 * table.abs() + 1e-9, "{coupling} {order} {sequence}: {rate}");
        }
        for (sequence, table) in [jacobi, actuator, mechanics].into_iter().zip(limits) {
            let paper = |macro_step| Paper { coupling, order, sequence, micro_steps: 1, damping: 0.01, macro_step };
            let limit = 1e3 * first_unstable(|macro_step| paper(macro_step).spectral_radius());
            assert!(limit == table || close(limit, table), "{coupling} {order} {sequence}: {limit} ms");
        }
    }
}

/// What force return does to the limit of the smooth model: damped oscillator, force–displacement, 20 micro steps.
#[test]
fn returning_the_mean_force_multiplies_the_limit_of_the_interface_model() {
    let limit = |scheme: &str, force_return: &str| {
        first_unstable(|macro_step| {
            let mut spec = spec("linear-oscillator", &[("variant", "1")], scheme, "gauss-seidel", macro_step);
            spec = spec.changed(|own| own.force_return = force_return.parse().unwrap());
            spec = spec.changed(|own| own.micro_step = macro_step / 20.0);
            spec = spec.changed(|own| own.mechanics_steps = if force_return == "profile" { ALL } else { ONE });
            spectral_radius(&spec).unwrap()
        })
    };
    let [held, end, mean, profile] = ["held", "end", "mean", "profile"].map(|name| limit("rim-smooth", name));
    assert!(mean > 100.0 * held && end > 5.0 * held && profile > 50.0 * held && profile < mean);
    assert!(mean > 100.0 * limit("zero-order-hold", "mean"));
}

#[test]
fn what_is_not_linear_has_no_spectral_radius() {
    let radius = |case, set: &[(&str, &str)]| spectral_radius(&spec(case, set, HOLDS[0], "jacobi", 1e-3));
    let nonlinear = radius("quarter-car", &[("damper", "nonlinear")]).unwrap_err().to_string();
    assert!(nonlinear.contains("not linear"), "{nonlinear}");
    assert!(radius("wedge-box", &[]).unwrap_err().to_string().contains("not linear"));
    assert!(radius("quarter-car", &[]).unwrap() < 1.0);
}

/// Order 1 by the held input; but semi-implicit Euler on both sides is leapfrog with its velocities half a step off,
/// and from x = 0, where nothing accelerates, its positions are of order 2.
#[test]
fn the_other_integrators_converge_to_the_same() {
    for (case, integrator, expected) in [
        ("linear-oscillator", "semi-implicit-euler", 2.0),
        ("linear-oscillator", "trapezoidal", 1.0),
        ("precice-oscillator", "newmark", 1.0),
        ("precice-oscillator", "generalised-alpha", 1.0),
    ] {
        let order = measured_order(case, &[("integrator", integrator)], HOLDS[0], 2e-4, |spec| spec.duration = 0.4);
        assert!((order - expected).abs() < 0.15, "{case} {integrator}: {order}");
    }
}

/// The published document: with a single rate, displacement–displacement and force–force coupling are equivalent. So
/// they are, and force–displacement with fresh feedthrough too, with semi-implicit Euler: all are the monolithic rule.
#[test]
fn with_a_single_rate_and_semi_implicit_euler_all_couplings_are_the_monolithic_rule() {
    let h = 1e-3;
    let mut z = [0.0, 0.0, 100.0, -100.0];
    let runs = COUPLINGS.map(|coupling| {
        let set = [("coupling", coupling), ("integrator", "semi-implicit-euler"), ("variant", "1")];
        completed(&spec("linear-oscillator", &set, HOLDS[0], "jacobi", h)).trajectory
    });
    for k in 0..runs[0].len() {
        for run in &runs {
            for (column, value) in z.into_iter().enumerate() {
                assert!((run.row(k)[1 + column] - value).abs() < 1e-9, "step {k}, column {column}");
            }
        }
        let force = K[1] * (z[0] - z[1]) + 0.01 * (z[2] - z[3]);
        let a = [-K[0] * z[0] - 0.01 * z[2] - force, -K[2] * z[1] - 0.01 * z[3] + force];
        for i in 0..2 {
            z[2 + i] += h * a[i];
            z[i] += h * z[2 + i];
        }
    }
}

/// The nonlinear damper, steep without bound at rest, against a fine monolithic solution.
#[test]
fn the_nonlinear_quarter_car_converges() {
    for (hold, expected) in [(HOLDS[0], 1.0), (HOLDS[1], 2.0)] {
        let points = [4e-3, 2e-3, 1e-3].map(|macro_step| {
            let mut spec = spec("quarter-car", &[("damper", "nonlinear")], hold, "jacobi", macro_step);
            spec = spec.changed(|own| (own.micro_step, own.mechanics_steps, own.duration) = (2e-5, ALL, 2.0));
            let ReferenceMethod::Own(solve) = (spec.case.reference)(&spec.parameters).unwrap() else {
                panic!("no reference")
            };
            let trajectory = completed(&spec).trajectory;
            let mut reference = Trajectory::with_capacity(spec.case.recorded_columns(), trajectory.len());
            let every = (macro_step / 2e-5).round() as usize;
            let steps = reference_steps(2e-5, (trajectory.len() - 1) * every, every);
            solve(steps, StopFlag::never(), &mut reference).unwrap();
            let pairs = trajectory.rows().zip(reference.rows());
            let sum: f64 = pairs.map(|(own, theirs)| (own[2] - theirs[2]).powi(2)).sum();
            (macro_step, (sum / trajectory.len() as f64).sqrt())
        });
        let order = order_of_convergence(&points).unwrap();
        assert!((order - expected).abs() < 0.15, "{hold}: {order} {points:?}");
    }
}

//! A bending beam in its own modes, with stops below it.

use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{MassMatrix, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelSize, StiffForces};
use rimbench_core::name::{Name, names};
use std::f64::consts::PI;

/// How the beam is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BeamSupport {
    /// Clamped at ξ = 0, free at ξ = 1.
    Clamped,
    /// Pinned at both ends.
    Pinned,
}

impl BeamSupport {
    /// Returns `β_n L` of mode n (from 1): roots of `cos β cosh β = −1`, or `nπ`.
    pub fn wave_number(self, mode: usize) -> f64 {
        match self {
            BeamSupport::Pinned => mode as f64 * PI,
            BeamSupport::Clamped => {
                let mut beta = (mode as f64 - 0.5) * PI;
                // Newton on cos β + 1/cosh β, which does not overflow; quadratic from a start that is off by 0.3 at most.
                for _ in 0..20 {
                    let sech = 1.0 / libm::cosh(beta);
                    beta -= (libm::cos(beta) + sech) / (-libm::sin(beta) - sech * libm::tanh(beta));
                }
                beta
            }
        }
    }

    /// Returns the mode shape at ξ = x/L, normalised to `∫ φ² dξ = 1`.
    ///
    /// ```text
    /// clamped   φ = cosh βξ − cos βξ − σ (sinh βξ − sin βξ),   σ = (cosh β + cos β)/(sinh β + sin β)
    /// pinned    φ = √2 sin nπξ
    /// ```
    /// With `σ = 1 + ε` the difference of the hyperbolic functions is `e^{−βξ} − ε sinh βξ`: nothing large cancels.
    pub fn shape(self, mode: usize, xi: f64) -> f64 {
        let beta = self.wave_number(mode);
        match self {
            BeamSupport::Pinned => std::f64::consts::SQRT_2 * libm::sin(beta * xi),
            BeamSupport::Clamped => {
                let excess =
                    (libm::exp(-beta) + libm::cos(beta) - libm::sin(beta)) / (libm::sinh(beta) + libm::sin(beta));
                let bend = libm::exp(-beta * xi) - excess * libm::sinh(beta * xi);
                bend - libm::cos(beta * xi) + (1.0 + excess) * libm::sin(beta * xi)
            }
        }
    }
}

/// A stop below the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamStop {
    /// m from the left end.
    pub position: f64,
    /// Distance from the undeflected beam, m.
    pub clearance: f64,
}

/// Dimensions of a [`ModalBeam`].
#[derive(Debug, Clone, PartialEq)]
pub struct BeamGeometry {
    /// How it is held.
    pub support: BeamSupport,
    /// L, m.
    pub length: f64,
    /// EI, N·m².
    pub bending_stiffness: f64,
    /// ρA, kg/m.
    pub mass_per_length: f64,
    /// ζ of all modes.
    pub damping_ratio: f64,
    /// Number of modes N.
    pub modes: usize,
    /// The two stops.
    pub stops: [BeamStop; 2],
    /// Where the actuator holds the beam, m from the left end.
    pub actuator_position: f64,
}

/// Euler–Bernoulli beam; velocities are those of the modal coordinates.
///
/// ```text
/// w(x, t) = Σ φ_n(x/L) η_n(t)       ρAL (η̈_n + 2 ζ ω_n η̇_n + ω_n² η_n) = φ_n(x_a/L) F + Σ φ_n(x_s/L) P_s
/// ω_n = (β_n L)² √(EI/(ρA L⁴))      g_s = w(x_s) + clearance
/// ```
/// Deflection is positive upwards. The semi-implicit step is stable below `2/ω_N`; steps of the second order that are too long for that
/// take all of it implicitly (`K = ρAL ω_n²`, `D = 2 ζ ρAL ω_n`).
#[derive(Debug, Clone, PartialEq)]
pub struct ModalBeam {
    geometry: BeamGeometry,
    modal_mass: f64,
    frequencies: Vec<f64>,
    at_actuator: Vec<f64>,
    at_stops: [Vec<f64>; 2],
    at_end: Vec<f64>,
}

/// Shapes with more waves than this say nothing about a slender beam.
pub const MOST_MODES: usize = 20;

impl ModalBeam {
    /// Builds the beam, straight and at rest.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a point that is not on the beam, or a number of modes that is not 1 to [`MOST_MODES`].
    pub fn new(geometry: BeamGeometry) -> Result<Self> {
        let g = &geometry;
        if !(1..=MOST_MODES).contains(&g.modes) {
            return Err(Error::invalid("modes", g.modes, format!("a whole number from 1 to {MOST_MODES}")));
        }
        let points = [
            ("stop_1_position_m", g.stops[0].position),
            ("stop_2_position_m", g.stops[1].position),
            ("actuator_position_m", g.actuator_position),
        ];
        for (key, position) in points {
            if !(0.0..=g.length).contains(&position) {
                return Err(Error::invalid(key, position, format!("on the beam, from 0 to {} m", g.length)));
            }
        }
        let shapes = |x: f64| -> Vec<f64> { (1..=g.modes).map(|n| g.support.shape(n, x / g.length)).collect() };
        let scale = (g.bending_stiffness / (g.mass_per_length * g.length.powi(4))).sqrt();
        Ok(ModalBeam {
            modal_mass: g.mass_per_length * g.length,
            frequencies: (1..=g.modes).map(|n| g.support.wave_number(n).powi(2) * scale).collect(),
            at_actuator: shapes(g.actuator_position),
            at_stops: g.stops.map(|stop| shapes(stop.position)),
            at_end: shapes(g.length),
            geometry,
        })
    }

    /// Returns ω_n, rad/s.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// Returns the deflection (m) at `x` (m) under a force (N) at `at` (m), of the modes at hand: `Σ φ_n(x) φ_n(at)
    /// F/(M ω_n²)`.
    pub fn static_deflection(&self, x: f64, at: f64, force: f64) -> f64 {
        let (support, length) = (self.geometry.support, self.geometry.length);
        let of_mode = |(index, omega): (usize, &f64)| {
            support.shape(index + 1, x / length) * support.shape(index + 1, at / length) * force
                / (self.modal_mass * omega * omega)
        };
        self.frequencies.iter().enumerate().map(of_mode).sum()
    }
}

fn combine(shapes: &[f64], amplitudes: &[f64]) -> f64 {
    shapes.iter().zip(amplitudes).map(|(shape, amplitude)| shape * amplitude).sum()
}

impl MechanicalModel for ModalBeam {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: self.geometry.modes, bilateral: 0, unilateral: 2, interface: 1 }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; self.geometry.modes], vec![0.0; self.geometry.modes])
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        if let MassMatrix::Diagonal(diagonal) = mass {
            diagonal.fill(self.modal_mass);
        }
    }

    fn forces(&self, q: &[f64], v: &[f64], force: &mut [f64]) {
        for (index, omega) in self.frequencies.iter().enumerate() {
            let pull = omega * q[index] + 2.0 * self.geometry.damping_ratio * v[index];
            force[index] = -self.modal_mass * omega * pull;
        }
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        for (row, (shapes, stop)) in self.at_stops.iter().zip(&self.geometry.stops).enumerate() {
            rows.jacobian[row * shapes.len()..(row + 1) * shapes.len()].copy_from_slice(shapes);
            rows.position[row] = combine(shapes, q) + stop.clearance;
        }
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian.copy_from_slice(&self.at_actuator);
        rows.position[0] = combine(&self.at_actuator, q);
    }

    fn empty_stiff_forces(&self) -> Option<StiffForces> {
        Some(StiffForces::zeros(self.geometry.modes, true))
    }

    fn stiff_forces(&self, _q: &[f64], _v: &[f64], forces: &mut StiffForces) {
        if let StiffForces { stiffness: MassMatrix::Diagonal(k), damping: MassMatrix::Diagonal(d) } = forces {
            for (omega, (k, d)) in self.frequencies.iter().zip(k.iter_mut().zip(d)) {
                *k = self.modal_mass * omega * omega;
                *d = 2.0 * self.geometry.damping_ratio * self.modal_mass * omega;
            }
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let of_mode = |(omega, q): (&f64, &f64)| 0.5 * self.modal_mass * (omega * q).powi(2);
        self.frequencies.iter().zip(q).map(of_mode).sum()
    }

    fn observables(&self) -> Vec<Name> {
        names(&["end_deflection_m"])
    }

    fn contact_names(&self) -> Vec<Name> {
        names(&["stop_1", "stop_2"])
    }

    fn observe(&self, q: &[f64], _v: &[f64], row: &mut [f64]) {
        row[0] = combine(&self.at_end, q);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn beam(support: BeamSupport, modes: usize) -> ModalBeam {
        ModalBeam::new(BeamGeometry {
            support,
            length: 2.0,
            bending_stiffness: 350.0,
            mass_per_length: 2.5,
            damping_ratio: 0.0,
            modes,
            stops: [BeamStop { position: 2.0, clearance: 0.1 }, BeamStop { position: 1.0, clearance: 0.1 }],
            actuator_position: 1.2,
        })
        .unwrap()
    }

    #[test]
    fn the_frequencies_are_those_of_the_textbook() {
        // Blevins, Formulas for Natural Frequency and Mode Shape: clamped–free, eight digits.
        let textbook = [1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839];
        for (n, beta) in textbook.into_iter().enumerate() {
            assert_relative_eq!(BeamSupport::Clamped.wave_number(n + 1), beta, epsilon = 5e-9);
        }
        let scale = (350.0_f64 / (2.5 * 16.0)).sqrt();
        assert_relative_eq!(beam(BeamSupport::Clamped, 1).frequencies()[0], 3.5160152685 * scale, max_relative = 1e-9);
        assert_relative_eq!(beam(BeamSupport::Pinned, 3).frequencies()[2], 9.0 * PI * PI * scale, max_relative = 1e-14);
    }

    #[test]
    fn the_shapes_are_orthonormal_and_meet_their_ends() {
        let n = 4000;
        for support in [BeamSupport::Clamped, BeamSupport::Pinned] {
            for (i, j) in [(1, 1), (1, 3), (4, 4), (2, 9), (12, 12), (20, 20), (19, 20)] {
                let simpson: f64 = (0..=n)
                    .map(|k| {
                        let weight = if k == 0 || k == n { 1.0 } else { 2.0 + 2.0 * f64::from(k % 2) };
                        let xi = f64::from(k) / f64::from(n);
                        weight * support.shape(i, xi) * support.shape(j, xi)
                    })
                    .sum::<f64>()
                    / f64::from(3 * n);
                // Simpson: (1/180) n⁻⁴ (2β)⁴ with β ≤ 63.
                assert_relative_eq!(simpson, f64::from(u8::from(i == j)), epsilon = 1e-8);
            }
            assert!(support.shape(5, 0.0).abs() < 1e-14);
        }
        for mode in 1..=20 {
            assert_relative_eq!(BeamSupport::Clamped.shape(mode, 1.0).abs(), 2.0, epsilon = 1e-11);
            assert!(BeamSupport::Pinned.shape(mode, 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn the_static_deflection_tends_to_the_closed_form_with_the_modes_left_out() {
        let (length, stiffness, force): (f64, f64, f64) = (2.0, 350.0, 7.0);
        for modes in [1, 2, 4, 8, 16] {
            // Each mode adds φ_n² F L³/(EI β⁴), with φ_n(1)² = 4 and β ≥ (n − ½)π − 1e-2 for n ≥ 2: what is left out lies
            // between zero and the integral of that.
            let rest = 4.0 / (3.0 * PI.powi(4) * (modes as f64 - 0.01).powi(3)) * 1.05;
            let tip = beam(BeamSupport::Clamped, modes).static_deflection(length, length, force);
            let closed = force * length.powi(3) / (3.0 * stiffness);
            let missing = (closed - tip) / (force * length.powi(3) / stiffness);
            assert!(missing > 0.0 && missing < rest, "{modes} modes: {missing:e}, at most {rest:e}");
            // In the middle of the pinned beam only odd modes count, φ² = 2.
            let middle = beam(BeamSupport::Pinned, modes).static_deflection(0.5 * length, 0.5 * length, force);
            let missing = 1.0 / 48.0 - middle / (force * length.powi(3) / stiffness);
            let rest = 2.0 / (3.0 * PI.powi(4) * (modes as f64).powi(3));
            assert!(missing > 0.0 && missing < rest, "{modes} modes: {missing:e}, at most {rest:e}");
        }
    }

    #[test]
    fn points_beside_the_beam_and_too_many_modes_are_refused_with_the_numbers() {
        let g = beam(BeamSupport::Pinned, 3).geometry;
        let beside = BeamGeometry { actuator_position: 2.5, ..g.clone() };
        let message = ModalBeam::new(beside).unwrap_err().to_string();
        assert_eq!(message, "actuator_position_m = 2.5 is not valid; valid: on the beam, from 0 to 2 m");
        assert!(ModalBeam::new(BeamGeometry { modes: 21, ..g }).unwrap_err().to_string().contains("from 1 to 20"));
    }
}

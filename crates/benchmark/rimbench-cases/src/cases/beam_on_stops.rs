//! `beam-on-stops`: a flexible beam in N modes that a shaken spring presses against two stops. The mechanics' own step
//! is stable below 2/ω_N. Shown in `docs/cases/beam-on-stops.md`; modes from Blevins, numbers *ours*.

use super::prelude::*;
use rimbench_core::interface_model::{MassMatrix, MatrixForm, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize, StiffForces};
use std::f64::consts::PI;

choices! {
    /// How the beam is held.
    enum BeamSupport {
        /// Clamped at ξ = 0, free at ξ = 1.
        Clamped = "clamped",
        /// Pinned at both ends.
        Pinned = "pinned",
    }
}
parameters! {
    /// A beam, its stops and what shakes it.
    struct Beam from "ours" {
        beam_support: BeamSupport [Clamped, Pinned], "clamped at one end, or pinned at both";
        modes: u32 = 4, 1..=20, "number of modes N";
        length_m: f64 = 2.0, Positive, "length L";
        width_m: f64 = 0.04, Positive, "width of the section";
        thickness_m: f64 = 0.008, Positive, "thickness of the section";
        youngs_modulus_pa: f64 = 210e9, Positive, "Young's modulus E".from("steel");
        density_kg_m3: f64 = 7800.0, Positive, "density ρ".from("steel");
        damping_ratio: f64 = 0.01, NotNegative, "damping ratio ζ of all modes";
        actuator_position_m: f64 = 1.2, NotNegative, "where the actuator holds the beam, from the left end";
        stop_1_position_m: f64 = 2.0, NotNegative, "where stop 1 is, from the left end";
        stop_1_clearance_m: f64 = 0.05, NotNegative, "distance of stop 1 below the straight beam".gap();
        stop_2_position_m: f64 = 0.8, NotNegative, "where stop 2 is, from the left end";
        stop_2_clearance_m: f64 = 0.03, NotNegative, "distance of stop 2 below the straight beam".gap();
        carriage: Carriage with |set| set
            .default("spring_stiffness_n_m", 2000.0).default("spring_damping_n_s_m", 2.0)
            .default("carriage_mass_kg", 0.5).default("base_stiffness_n_m", 4000.0)
            .default("base_damping_n_s_m", 10.0).default("base_position_m", -0.05)
            .default("base_amplitude_m", 0.05).default("base_frequency_hz", 1.0)
            .default("base_phase_rad", 1.5707963267948966);
        contacts: Contacts with |set| set.only(&["stabilisation", "restitution"]);
    }
}

/// Frames of the drawn beam: one moves with the deflection at the actuator, and one in it with that at the end.
const BENT: [[&str; 2]; 8] =
    [["a", "A"], ["b", "B"], ["c", "C"], ["d", "D"], ["e", "E"], ["f", "F"], ["g", "G"], ["h", "H"]];

impl Beam {
    /// Shares of the deflections at the actuator and at the end in that at x: of the cubic that leaves the clamp
    /// straight and has both, or of the half sine between two pins.
    fn bent(&self, x: f64) -> [f64; 2] {
        let (a, l) = (self.actuator_position_m, self.length_m);
        match self.beam_support {
            BeamSupport::Pinned => [libm::sin(PI * x / l) / libm::sin(PI * a / l), 0.0],
            BeamSupport::Clamped if 0.0 < a && a < l => {
                [(x / a).powi(2) * (l - x) / (l - a), (x / l).powi(2) * (x - a) / (l - a)]
            }
            BeamSupport::Clamped => [0.0, (x / l).powi(2)],
        }
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: carriage::trace_columns(
            "carriage_position_m end_deflection_m effective_mass_kg gap_stop_1_m gap_stop_2_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words("carriage_velocity_m_s contact_force_stop_1_n contact_force_stop_2_n"),
        interface_columns: carriage::interface(),
        reference: reference(),
        drawing: drawn(|p: &Beam| {
            let (mut frames, mut shapes) = carriage::springs([p.actuator_position_m, 0.0], [0.0, 1.0], 0.25, Some(0.0));
            let stop = |x: f64, clearance: f64| wall([x - 0.02, -clearance - 0.2], [x + 0.02, -clearance]);
            // Through the deflections at the actuator and at the end.
            for (k, [held, bent]) in BENT.into_iter().enumerate() {
                let share = (k + 1) as f64 / BENT.len() as f64;
                let [actuator, end] = p.bent(share * p.length_m);
                let along = |column, gain| Channel::Column(column, gain, 0.0);
                frames.push(frame(held, share * p.length_m, along("interface_position_m", actuator), 0.0));
                let pose = [0.0.into(), along("end_deflection_m", end), 0.0.into()];
                frames.push(Frame { name: bent, parent: Some(held), pose });
            }
            let half = 0.5 * p.thickness_m;
            let side = |y: f64| BENT.map(|[_, bent]| ([0.0, y], Some(bent)));
            let upper = side(half).into_iter().rev().chain([([0.0, half], None), ([0.0, -half], None)]);
            let beam = side(-half).into_iter().chain(upper).collect();
            shapes.extend([
                wall([-0.08, -0.15], [0.0, 0.15]),
                stop(p.stop_1_position_m, p.stop_1_clearance_m),
                stop(p.stop_2_position_m, p.stop_2_clearance_m),
                Shape::Polygon(beam, Fill::Scheme),
            ]);
            let title = ["Beam on stops", "A shaken spring bends a clamped beam onto two stops."];
            let drawing = Drawing::of(title, [[-0.15, p.length_m + 0.15], [-0.3, 0.6]], frames, shapes);
            Some(drawing.with(LIMITED_BY_ITS_STEP))
        }),
        ..Case::new(
            "beam-on-stops",
            "Bending beam in N modes, pressed against two stops by a carriage on springs",
            times(3.0, 2e-3, 2e-4, [5e-5, 2e-4]),
            build,
        )
    }
}

fn build(p: &Beam, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    assembly.couple(ModalBeam::new(p)?, SpringActuator::new(p.carriage)?, &p.contacts)
}

impl BeamSupport {
    /// Returns `β_n L` of mode n (from 1): roots of `cos β cosh β = −1`, or `nπ`.
    fn wave_number(self, mode: usize) -> f64 {
        match self {
            BeamSupport::Pinned => mode as f64 * PI,
            BeamSupport::Clamped => {
                let mut beta = (mode as f64 - 0.5) * PI;
                // Newton on cos β + 1/cosh β, which does not overflow; quadratic from a start that is off by 0.3 at
                // most.
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
    fn shape(self, mode: usize, xi: f64) -> f64 {
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

/// Euler–Bernoulli beam; velocities are those of the modal coordinates, deflection is positive upwards.
///
#[doc = include_str!("beam_on_stops.md")]
///
/// Steps of the second order that are too long for the semi-implicit step take all of the springs implicitly (`K = ρAL
/// ω_n²`, `D = 2 ζ ρAL ω_n`).
#[derive(Debug, Clone)]
struct ModalBeam {
    p: Beam,
    modal_mass: f64,
    frequencies: Vec<f64>,
    at_actuator: Vec<f64>,
    at_stops: [Vec<f64>; 2],
    at_end: Vec<f64>,
}

impl ModalBeam {
    /// Builds the beam, straight and at rest.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a point that is not on the beam.
    fn new(p: &Beam) -> Result<Self> {
        let points = [named!(p.stop_1_position_m), named!(p.stop_2_position_m), named!(p.actuator_position_m)];
        for (key, position) in points {
            if !(0.0..=p.length_m).contains(&position) {
                return Err(Error::invalid(key, position, format!("on the beam, from 0 to {} m", p.length_m)));
            }
        }
        let modes = 1..=p.modes as usize;
        let shapes = |x: f64| modes.clone().map(|n| p.beam_support.shape(n, x / p.length_m)).collect::<Vec<f64>>();
        let bending_stiffness = p.youngs_modulus_pa * p.width_m * p.thickness_m.powi(3) / 12.0;
        let mass_per_length = p.density_kg_m3 * p.width_m * p.thickness_m;
        let scale = (bending_stiffness / (mass_per_length * p.length_m.powi(4))).sqrt();
        Ok(ModalBeam {
            p: *p,
            modal_mass: mass_per_length * p.length_m,
            frequencies: modes.clone().map(|n| p.beam_support.wave_number(n).powi(2) * scale).collect(),
            at_actuator: shapes(p.actuator_position_m),
            at_stops: [shapes(p.stop_1_position_m), shapes(p.stop_2_position_m)],
            at_end: shapes(p.length_m),
        })
    }
}

fn combine(shapes: &[f64], amplitudes: &[f64]) -> f64 {
    shapes.iter().zip(amplitudes).map(|(shape, amplitude)| shape * amplitude).sum()
}

impl MechanicalModel for ModalBeam {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: self.frequencies.len(),
            unilateral: 2,
            interface: 1,
            stiff_forces: Some(MatrixForm::Diagonal),
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; self.frequencies.len()], vec![0.0; self.frequencies.len()])
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.fill(self.modal_mass);
    }

    fn forces(&self, q: &[f64], v: &[f64], force: &mut [f64]) {
        for (index, omega) in self.frequencies.iter().enumerate() {
            let pull = omega * q[index] + 2.0 * self.p.damping_ratio * v[index];
            force[index] = -self.modal_mass * omega * pull;
        }
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        let clearances = [self.p.stop_1_clearance_m, self.p.stop_2_clearance_m];
        for (row, (shapes, clearance)) in self.at_stops.iter().zip(clearances).enumerate() {
            rows.jacobian[row * shapes.len()..(row + 1) * shapes.len()].copy_from_slice(shapes);
            rows.position[row] = combine(shapes, q) + clearance;
        }
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian.copy_from_slice(&self.at_actuator);
        rows.position[0] = combine(&self.at_actuator, q);
    }

    fn stiff_forces(&self, _q: &[f64], _v: &[f64], forces: &mut StiffForces) {
        if let StiffForces { stiffness: MassMatrix::Diagonal(k), damping: MassMatrix::Diagonal(d) } = forces {
            for (omega, (k, d)) in self.frequencies.iter().zip(k.iter_mut().zip(d)) {
                *k = self.modal_mass * omega * omega;
                *d = 2.0 * self.p.damping_ratio * self.modal_mass * omega;
            }
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let of_mode = |(omega, q): (&f64, &f64)| 0.5 * self.modal_mass * (omega * q).powi(2);
        self.frequencies.iter().zip(q).map(of_mode).sum()
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&["end_deflection_m"], &["stop_1", "stop_2"])
    }

    fn observe(&self, q: &[f64], _v: &[f64], row: &mut [f64]) {
        row[0] = combine(&self.at_end, q);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// EI = 350 N·m², ρA = 2.5 kg/m, L = 2 m.
    fn beam(beam_support: BeamSupport, modes: u32) -> ModalBeam {
        let usual = Beam::defaults();
        let section =
            Beam { width_m: 1.0, thickness_m: 1.0, youngs_modulus_pa: 12.0 * 350.0, density_kg_m3: 2.5, ..usual };
        ModalBeam::new(&Beam { beam_support, modes, ..section }).unwrap()
    }

    /// Deflection (m) at `x` (m) under a force (N) at `at` (m), of the modes at hand: `Σ φ_n(x) φ_n(at) F/(M ω_n²)`.
    fn static_deflection(beam: &ModalBeam, x: f64, at: f64, force: f64) -> f64 {
        let shape = |n: usize, x: f64| beam.p.beam_support.shape(n, x / beam.p.length_m);
        let of_mode = |(index, omega): (usize, &f64)| {
            shape(index + 1, x) * shape(index + 1, at) * force / (beam.modal_mass * omega * omega)
        };
        beam.frequencies.iter().enumerate().map(of_mode).sum()
    }

    #[test]
    fn the_frequencies_are_those_of_the_textbook() {
        // Blevins, Formulas for Natural Frequency and Mode Shape: clamped–free, eight digits.
        let textbook = [1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839];
        for (n, beta) in textbook.into_iter().enumerate() {
            assert_relative_eq!(BeamSupport::Clamped.wave_number(n + 1), beta, epsilon = 5e-9);
        }
        let scale = (350.0_f64 / (2.5 * 16.0)).sqrt();
        assert_relative_eq!(beam(BeamSupport::Clamped, 1).frequencies[0], 3.5160152685 * scale, max_relative = 1e-9);
        assert_relative_eq!(beam(BeamSupport::Pinned, 3).frequencies[2], 9.0 * PI * PI * scale, max_relative = 1e-14);
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
            // Each mode adds φ_n² F L³/(EI β⁴), with φ_n(1)² = 4 and β ≥ (n − ½)π − 1e-2 for n ≥ 2: what is left out
            // lies between zero and the integral of that.
            let rest = 4.0 / (3.0 * PI.powi(4) * (f64::from(modes) - 0.01).powi(3)) * 1.05;
            let tip = static_deflection(&beam(BeamSupport::Clamped, modes), length, length, force);
            let closed = force * length.powi(3) / (3.0 * stiffness);
            let missing = (closed - tip) / (force * length.powi(3) / stiffness);
            assert!(missing > 0.0 && missing < rest, "{modes} modes: {missing:e}, at most {rest:e}");
            // In the middle of the pinned beam only odd modes count, φ² = 2.
            let middle = static_deflection(&beam(BeamSupport::Pinned, modes), 0.5 * length, 0.5 * length, force);
            let missing = 1.0 / 48.0 - middle / (force * length.powi(3) / stiffness);
            let rest = 2.0 / (3.0 * PI.powi(4) * f64::from(modes).powi(3));
            assert!(missing > 0.0 && missing < rest, "{modes} modes: {missing:e}, at most {rest:e}");
        }
    }
}

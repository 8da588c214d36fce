//! Mechanics of the hydraulic crane: two links and two point masses in two angles.

use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{MatrixForm, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

/// Geometry, masses and start of a [`Crane`]. Angles are measured from the x axis, gravity points along −y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CraneGeometry {
    /// Length `L` of link 1, m.
    pub link_1_length: f64,
    /// Length `L_h` of link 2, m.
    pub link_2_length: f64,
    /// Mass `m` of link 1, a uniform rod, kg; link 2 has none.
    pub rod_mass: f64,
    /// Point mass `m_p` at the joint of the links, kg.
    pub joint_mass: f64,
    /// Point mass `m_h` at the end of link 2, kg.
    pub end_mass: f64,
    /// The actuator's fixed end B lies at `(x_B, 0)`, m.
    pub pin_x: f64,
    /// Distance `d` of the actuator's other end from the origin, along link 1, m.
    pub attachment: f64,
    /// `θ₁, θ₂` at the start, rad; the crane starts at rest.
    pub start_angles: [f64; 2],
    /// m/s².
    pub gravity: f64,
}

/// A planar two-link crane with one actuator between the ground and link 1; the actuator's other end lies anywhere on
/// link 1.
///
#[doc = include_str!("crane.md")]
/// # Source
/// Laboratorio de Ingeniería Mecánica, Univ. da Coruña, cosim-benchmarks: the published code. The published document
/// misprints `M₁₁` as `L²(m + m_p + m_h)/3` and `f₁` as `−(L g/2)(m + m_p + m_h) cos θ₁`; with those the published
/// 8829 N at rest would not come out.
#[derive(Debug, Clone, PartialEq)]
pub struct Crane {
    geometry: CraneGeometry,
    sin: [f64; 2],
    cos: [f64; 2],
}

impl Crane {
    /// Builds the crane.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if the actuator would start with no length or in a dead centre.
    pub fn new(geometry: CraneGeometry) -> Result<Self> {
        let mut crane = Crane { geometry, sin: [0.0; 2], cos: [0.0; 2] };
        crane.prepare(&geometry.start_angles, &[0.0; 2]);
        let (length, lever, _) = crane.actuator();
        if length < 1e-6 || !lever.is_finite() || lever.abs() < 1e-6 {
            return Err(Error::Incompatible(format!(
                "impossible geometry: the actuator would start {length:.6} m long with a lever of {lever:.6} m"
            )));
        }
        Ok(crane)
    }

    /// Returns the actuator length at the start, m.
    pub fn start_length(&self) -> f64 {
        let mut start = self.clone();
        start.prepare(&self.geometry.start_angles, &[0.0; 2]);
        start.actuator().0
    }

    /// Returns the actuator force that balances the weight along the actuator at the start, N.
    ///
    /// ```text
    /// F = −(J M⁻¹ Jᵀ)⁻¹ J M⁻¹ (f − c)
    /// ```
    pub fn equilibrium_force(&self) -> f64 {
        let mut start = self.clone();
        let theta = self.geometry.start_angles;
        start.prepare(&theta, &[0.0; 2]);
        let free = start.acceleration([0.0; 2], 0.0)[0];
        let per_newton = start.acceleration([0.0; 2], 1.0)[0] - free;
        -free / per_newton
    }

    /// Returns the actuator length `s` (m), lever `J₁ = ∂s/∂θ₁` (m) and `∂J₁/∂θ₁` (m) at the prepared angles.
    #[inline]
    pub fn actuator(&self) -> (f64, f64, f64) {
        let (d, pin) = (self.geometry.attachment, self.geometry.pin_x);
        let length = (d * d + pin * pin - 2.0 * d * pin * self.cos[0]).sqrt();
        let lever = d * pin * self.sin[0] / length;
        (length, lever, d * pin * self.cos[0] / length - lever * lever / length)
    }

    /// `M₁₁, M₁₂, M₂₂` at the prepared angles.
    #[inline]
    fn mass_entries(&self) -> [f64; 3] {
        let g = &self.geometry;
        let (l1, l2) = (g.link_1_length, g.link_2_length);
        let cos_between = self.cos[0] * self.cos[1] + self.sin[0] * self.sin[1];
        [
            l1 * l1 * (g.rod_mass / 3.0 + g.joint_mass + g.end_mass),
            l1 * l2 * g.end_mass * cos_between,
            l2 * l2 * g.end_mass,
        ]
    }

    /// `f − c` at the prepared angles.
    #[inline]
    fn applied(&self, v: [f64; 2]) -> [f64; 2] {
        let g = &self.geometry;
        let (l1, l2) = (g.link_1_length, g.link_2_length);
        let sin_between = self.sin[0] * self.cos[1] - self.cos[0] * self.sin[1];
        let coupling = l1 * l2 * g.end_mass * sin_between;
        let lifted = 0.5 * g.rod_mass + g.joint_mass + g.end_mass;
        [
            -l1 * g.gravity * lifted * self.cos[0] - coupling * v[1] * v[1],
            -l2 * g.gravity * g.end_mass * self.cos[1] + coupling * v[0] * v[0],
        ]
    }

    /// Returns `θ̈` (rad/s²) at the prepared angles, for velocities `v` (rad/s) and actuator force `F` (N).
    #[inline]
    pub fn acceleration(&self, v: [f64; 2], force: f64) -> [f64; 2] {
        let [m11, m12, m22] = self.mass_entries();
        let [f1, f2] = self.applied(v);
        let f1 = f1 + self.actuator().1 * force;
        let determinant = m11 * m22 - m12 * m12;
        [(m22 * f1 - m12 * f2) / determinant, (m11 * f2 - m12 * f1) / determinant]
    }
}

impl MechanicalModel for Crane {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: 2, interface: 1, mass: MatrixForm::Dense, ..ModelSize::default() }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.geometry.start_angles.to_vec(), vec![0.0; 2])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        self.sin = [libm::sin(q[0]), libm::sin(q[1])];
        self.cos = [libm::cos(q[0]), libm::cos(q[1])];
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        let [m11, m12, m22] = self.mass_entries();
        mass.copy_from_slice(&[m11, m12, m12, m22]);
    }

    fn forces(&self, _q: &[f64], v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&self.applied([v[0], v[1]]));
    }

    fn interface(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        let (length, lever, lever_rate) = self.actuator();
        rows.jacobian[0] = lever;
        rows.position[0] = length;
        rows.convective[0] = lever_rate * v[0] * v[0];
    }

    fn potential_energy(&self, _q: &[f64]) -> f64 {
        let g = &self.geometry;
        let lifted = 0.5 * g.rod_mass + g.joint_mass + g.end_mass;
        g.gravity * (lifted * g.link_1_length * self.sin[0] + g.end_mass * g.link_2_length * self.sin[1])
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&["theta_1_rad", "theta_2_rad"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn crane() -> Crane {
        Crane::new(CraneGeometry {
            link_1_length: 1.0,
            link_2_length: 0.5,
            rod_mass: 200.0,
            joint_mass: 250.0,
            end_mass: 100.0,
            pin_x: 0.75_f64.sqrt(),
            attachment: 0.5,
            start_angles: [std::f64::consts::FRAC_PI_6, -std::f64::consts::FRAC_PI_2],
            gravity: 9.81,
        })
        .unwrap()
    }

    #[test]
    fn power_of_all_forces_is_the_rate_of_energy() {
        // Along θ(t) = θ₀ + v t + ½ θ̈ t² the energy changes with the work of the actuator alone.
        let (theta, v, force) = ([0.7, -1.1], [0.4, -0.9], 5000.0);
        let mut crane = crane();
        crane.prepare(&theta, &v);
        let a = crane.acceleration(v, force);
        let power = force * crane.actuator().1 * v[0];
        let mut energy = |t: f64| {
            let q = [0, 1].map(|i| theta[i] + v[i] * t + 0.5 * a[i] * t * t);
            let w = [0, 1].map(|i| v[i] + a[i] * t);
            crane.prepare(&q, &w);
            let [m11, m12, m22] = crane.mass_entries();
            0.5 * (m11 * w[0] * w[0] + 2.0 * m12 * w[0] * w[1] + m22 * w[1] * w[1]) + crane.potential_energy(&q)
        };
        assert_relative_eq!((energy(1e-5) - energy(-1e-5)) / 2e-5, power, max_relative = 1e-7);
    }

    #[test]
    fn the_convective_term_is_the_rest_of_the_second_derivative_of_the_length() {
        let (theta, v, e) = (0.7, 0.8, 1e-4);
        let mut crane = crane();
        let mut length = |t: f64| {
            crane.prepare(&[theta + v * t, 0.0], &[0.0; 2]);
            crane.actuator().0
        };
        let numeric = (length(e) - 2.0 * length(0.0) + length(-e)) / (e * e);
        crane.prepare(&[theta, 0.0], &[v, 0.0]);
        assert_relative_eq!(crane.actuator().2 * v * v, numeric, max_relative = 1e-6);
    }
}

//! Mechanics of a slider–crank whose slider has play in its guide.

use super::rotation::rotation;
use nalgebra::{Rotation2, Vector2};
use rimbench_core::interface_model::{MassMatrix, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelSize};
use rimbench_core::name::{Name, names};

/// Masses, geometry and start of a [`SliderCrank`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SliderCrankGeometry {
    /// Of crank, connecting rod and slider, kg; crank and rod have their centres of mass in the middle.
    pub masses: [f64; 3],
    /// About the centres of mass, kg·m².
    pub inertias: [f64; 3],
    /// l₁ of the crank and l₂ of the rod, m.
    pub lengths: [f64; 2],
    /// Half the length a and half the height b of the slider, m.
    pub slider: [f64; 2],
    /// c between slider and guide on either side while the slider is in the middle, m.
    pub clearance: f64,
    /// Angular velocities at the start, rad/s.
    pub rates: [f64; 3],
    /// m/s².
    pub gravity: f64,
}

/// Crank, rod and slider. Coordinates: their angles θ₁, θ₂, θ₃ from the axis of the guide.
///
/// ```text
/// corner at r in the slider:   p = l₁ e(θ₁) + l₂ e(θ₂) + R(θ₃) r,   e(θ) = (cos θ, sin θ)
/// upper wall   g = b + c − p_y     n = (0, −1)   t = (−1, 0)
/// lower wall   g = b + c + p_y     n = (0, 1)    t = (1, 0)
///
/// M₁₁ = J₁ + (m₁/4 + m₂ + m₃) l₁²     M₁₂ = (m₂/2 + m₃) l₁ l₂ cos(θ₁ − θ₂)     M₂₂ = J₂ + (m₂/4 + m₃) l₂²     M₃₃ = J₃
/// s = l₁ θ₁, the way of the crank pin
/// ```
/// Where both corners of a side touch, their tangential rows are the same.
/// # Source
/// Flores, Leine, Glocker, *Modeling and analysis of planar rigid multibody systems with translational clearance joints based on the non-smooth
/// dynamics approach* (2010).
#[derive(Debug, Clone, PartialEq)]
pub struct SliderCrank {
    geometry: SliderCrankGeometry,
    /// e(θ₁), e(θ₂).
    along: [Vector2<f64>; 2],
    slider: Rotation2<f64>,
}

const VELOCITIES: usize = 3;
/// Ends of the slider and walls of the corners, in units of a and b.
const CORNERS: [[f64; 2]; 4] = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];

impl SliderCrank {
    /// Stretches crank and rod along the guide, the slider in its middle.
    pub fn new(geometry: SliderCrankGeometry) -> Self {
        SliderCrank { geometry, along: [Vector2::new(1.0, 0.0); 2], slider: Rotation2::identity() }
    }

    /// `(m₂/2 + m₃) l₁ l₂`, kg·m².
    fn coupling(&self) -> f64 {
        let g = &self.geometry;
        (0.5 * g.masses[1] + g.masses[2]) * g.lengths[0] * g.lengths[1]
    }

    /// Weights that crank pin and slider pin carry along with l₁ and l₂, kg.
    fn carried(&self) -> [f64; 2] {
        let [crank, rod, slider] = self.geometry.masses;
        [0.5 * crank + rod + slider, 0.5 * rod + slider]
    }

    /// Writes the rate of a corner's place along a fixed direction, and its convective term; returns the place.
    fn corner(&self, v: &[f64], corner: usize, direction: Vector2<f64>, rows: &mut Rows) -> f64 {
        let g = &self.geometry;
        let [end, wall] = CORNERS[corner];
        let arm = self.slider * Vector2::new(end * g.slider[0], wall * g.slider[1]);
        let arms = [g.lengths[0] * self.along[0], g.lengths[1] * self.along[1], arm];
        let row = &mut rows.jacobian[VELOCITIES * corner..VELOCITIES * (corner + 1)];
        rows.convective[corner] = 0.0;
        for ((entry, arm), rate) in row.iter_mut().zip(&arms).zip(v) {
            *entry = arm.perp(&direction);
            rows.convective[corner] -= rate * rate * arm.dot(&direction);
        }
        arms.iter().map(|arm| arm.dot(&direction)).sum()
    }
}

impl MechanicalModel for SliderCrank {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: VELOCITIES, bilateral: 0, unilateral: 4, interface: 1 }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; VELOCITIES], self.geometry.rates.to_vec())
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        for (along, angle) in self.along.iter_mut().zip(q) {
            let (sin, cos) = libm::sincos(*angle);
            *along = Vector2::new(cos, sin);
        }
        self.slider = rotation(q[2]);
    }

    fn empty_mass_matrix(&self) -> MassMatrix {
        MassMatrix::Dense(vec![0.0; VELOCITIES * VELOCITIES])
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        if let MassMatrix::Dense(dense) = mass {
            let SliderCrankGeometry { masses: [m1, m2, m3], inertias: [j1, j2, j3], lengths: [l1, l2], .. } =
                self.geometry;
            let m12 = self.coupling() * self.along[0].dot(&self.along[1]);
            dense.copy_from_slice(&[
                j1 + (0.25 * m1 + m2 + m3) * l1 * l1,
                m12,
                0.0,
                m12,
                j2 + (0.25 * m2 + m3) * l2 * l2,
                0.0,
                0.0,
                0.0,
                j3,
            ]);
        }
    }

    fn forces(&self, _q: &[f64], v: &[f64], force: &mut [f64]) {
        let g = &self.geometry;
        let [crank, rod] = self.carried();
        // sin(θ₁ − θ₂)
        let turned = self.coupling() * self.along[1].perp(&self.along[0]);
        force.copy_from_slice(&[
            -crank * g.gravity * g.lengths[0] * self.along[0].x - turned * v[1] * v[1],
            -rod * g.gravity * g.lengths[1] * self.along[1].x + turned * v[0] * v[0],
            0.0,
        ]);
    }

    fn unilateral(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        let half = self.geometry.slider[1] + self.geometry.clearance;
        for (corner, [_, wall]) in CORNERS.into_iter().enumerate() {
            rows.position[corner] = half + self.corner(v, corner, Vector2::new(0.0, -wall), rows);
        }
    }

    fn tangential_rows(&self) -> usize {
        4
    }

    fn tangential(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        for (corner, [_, wall]) in CORNERS.into_iter().enumerate() {
            self.corner(v, corner, Vector2::new(-wall, 0.0), rows);
        }
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        let radius = self.geometry.lengths[0];
        rows.jacobian[0] = radius;
        rows.position[0] = radius * q[0];
    }

    fn potential_energy(&self, _q: &[f64]) -> f64 {
        let g = &self.geometry;
        let weights = self.carried().into_iter().zip(g.lengths).zip(&self.along);
        weights.map(|((carried, length), along)| g.gravity * carried * length * along.y).sum()
    }

    fn observables(&self) -> Vec<Name> {
        names(&[
            "crank_angle_rad",
            "rod_angle_rad",
            "slider_angle_rad",
            "crank_rate_rad_s",
            "rod_rate_rad_s",
            "slider_rate_rad_s",
            "slider_x_m",
            "slider_y_m",
        ])
    }

    fn contact_names(&self) -> Vec<Name> {
        names(&["upper_rear", "upper_front", "lower_rear", "lower_front"])
    }

    fn observe(&self, q: &[f64], v: &[f64], row: &mut [f64]) {
        row[..VELOCITIES].copy_from_slice(q);
        row[VELOCITIES..2 * VELOCITIES].copy_from_slice(v);
        let [l1, l2] = self.geometry.lengths;
        let pin = l1 * self.along[0] + l2 * self.along[1];
        row[2 * VELOCITIES..].copy_from_slice(&[pin.x, pin.y]);
    }
}

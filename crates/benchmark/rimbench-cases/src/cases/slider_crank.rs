//! `slider-crank`: a motor turns a crank through a shaft; the slider has play in its guide and touches it with four
//! corners, with friction. The motor is a rotor (mass m_a at the crank's radius) between a shaft (k, c) and what it
//! turns against: c_b times what it is slower than its nominal speed. Shown in `docs/cases/slider-crank.md`; crank,
//! rod, slider and guide of Flores, Leine, Glocker 2010, motor *ours*.

use super::prelude::*;
use crate::models::rotation::rotation;
use nalgebra::{Rotation2, Vector2};
use rimbench_core::interface_model::{MatrixForm, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

parameters! {
    /// A slider-crank, its guide and its motor.
    pub struct Crank from "Flores et al. 2010" {
        crank_length_m: f64 = 0.153, Positive, "length l₁ of the crank";
        rod_length_m: f64 = 0.306, Positive, "length l₂ of the connecting rod";
        slider_half_length_m: f64 = 0.05, Positive, "half the length a of the slider";
        slider_half_height_m: f64 = 0.025, Positive, "half the height b of the slider";
        clearance_m: f64 = 1e-3, Positive, "play c above and below the slider".gap();
        crank_mass_kg: f64 = 0.038, Positive, "mass m₁ of the crank";
        rod_mass_kg: f64 = 0.038, Positive, "mass m₂ of the rod";
        slider_mass_kg: f64 = 0.076, Positive, "mass m₃ of the slider";
        crank_inertia_kg_m2: f64 = 7.4e-5, Positive, "inertia J₁ of the crank about its middle";
        rod_inertia_kg_m2: f64 = 5.9e-4, Positive, "inertia J₂ of the rod about its middle";
        slider_inertia_kg_m2: f64 = 2.7e-6, Positive, "inertia J₃ of the slider";
        speed_rad_s: f64 = 150.0, NotNegative, "speed of crank and motor at the start, and of the motor";
        rotor_mass_kg: f64 = 1.0, Positive, "mass m_a of the rotor at the crank's radius".from("ours");
        shaft_stiffness_n_m: f64 = 1e5, NotNegative, "stiffness k of the shaft; 0 without damping: no motor".from("ours");
        shaft_damping_n_s_m: f64 = 20.0, NotNegative, "damping c of the shaft".from("ours");
        motor_damping_n_s_m: f64 = 50.0, NotNegative, "force c_b of the motor per speed lost".from("ours");
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        /// The contact law.
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution", "friction", "tangential_restitution"])
            .default("restitution", 0.4).source("restitution", "Flores et al. 2010").default("friction", 0.01)
            .within("friction", Positive).source("friction", "Flores et al. 2010");
    }
}

impl Crank {
    /// Of crank, rod and slider, kg; crank and rod have their centres of mass in the middle.
    fn masses(&self) -> [f64; 3] {
        [self.crank_mass_kg, self.rod_mass_kg, self.slider_mass_kg]
    }

    fn lengths(&self) -> [f64; 2] {
        [self.crank_length_m, self.rod_length_m]
    }

    /// Angular velocities at the start, rad/s, with which the slider pin stays on the axis.
    fn rates(&self) -> [f64; 3] {
        let ([crank, rod], speed) = (self.lengths(), self.speed_rad_s);
        [speed, -speed * crank / rod, 0.0]
    }
}

const CORNER_NAMES: [&str; 4] = ["upper_rear", "upper_front", "lower_rear", "lower_front"];

pub(super) fn entry() -> Case {
    Case {
        trace_columns: trace_of(
            &carriage::interface(),
            "crank_angle_rad crank_rate_rad_s slider_x_m slider_y_m slider_angle_rad",
            &CORNER_NAMES,
            "effective_mass_kg gap_*_m contact_state_* closed_contacts",
        ),
        drawing_columns: of_contacts(
            &CORNER_NAMES,
            "rod_angle_rad rod_rate_rad_s slider_rate_rad_s contact_force_*_n friction_force_*_n",
        ),
        interface_columns: carriage::interface(),
        reference: reference(),
        drawing: drawn(|p: &Crank| Some(drawing(p))),
        ..Case::new(
            "slider-crank",
            "Slider-crank whose slider has play in its guide, driven through a shaft (impacts, friction at four corners)",
            times(0.1, 5e-4, 5e-6, [2e-6, 2e-5]),
            build,
        )
    }
}

fn drawing(p: &Crank) -> Drawing {
    let [crank, rod] = [p.crank_length_m, p.rod_length_m];
    let [a, b, guide] = [p.slider_half_length_m, p.slider_half_height_m, p.slider_half_height_m + p.clearance_m];
    let rail = |from: f64, to: f64| {
        let [left, right] = [rod - crank - 2.0 * a, rod + crank + 4.0 * a];
        wall([left, from], [right, to])
    };
    let bar = |name, length: f64, half: f64| rectangle(name, [length / 2.0, 0.0], [length, 2.0 * half]);
    let pin = |name, x: f64, radius| disc(([x, 0.0], Some(name)), radius, Fill::Metal);
    Drawing {
        view: [[-0.2, rod + crank + 0.1], [-0.2, 0.2]],
        frames: vec![
            frame("crank", 0.0, 0.0, "crank_angle_rad"),
            // The rod's angle is that of the world: its frame stands at the pin, turned back by the crank's.
            within("crank", frame("pin", crank, 0.0, Channel::Column("crank_angle_rad", -1.0, 0.0))),
            within("pin", frame("rod", 0.0, 0.0, "rod_angle_rad")),
            frame("slider", "slider_x_m", "slider_y_m", "slider_angle_rad"),
        ],
        shapes: vec![
            rail(guide, guide + 0.014),
            rail(-guide, -guide - 0.014),
            Shape::Polygon(rectangle("slider", [0.0, 0.0], [2.0 * a, 2.0 * b]), Fill::Scheme),
            Shape::Polygon(bar("rod", rod, 0.008), Fill::Metal),
            Shape::Polygon(bar("crank", crank, 0.012), Fill::Scheme),
            pin("crank", 0.0, 0.02),
            pin("rod", 0.0, 0.009),
            pin("rod", rod, 0.009),
        ],
        title: [
            "Slider-crank with play",
            "A motor turns a crank; the slider knocks about in a guide with a millimetre of play.",
        ],
        force: "shaft force at the pin",
        ..Drawing::default()
    }
}

fn build(p: &Crank, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let lengths = p.lengths();
    if lengths[1] <= lengths[0] {
        let expected = format!("more than crank_length_m = {}: a shorter rod lets no crank turn", lengths[0]);
        return Err(Error::invalid("rod_length_m", lengths[1], expected));
    }
    let pin_speed = lengths[0] * p.speed_rad_s;
    let motor = SpringActuator::new(Carriage {
        spring_stiffness_n_m: p.shaft_stiffness_n_m,
        spring_damping_n_s_m: p.shaft_damping_n_s_m,
        carriage_mass_kg: p.rotor_mass_kg,
        base_damping_n_s_m: p.motor_damping_n_s_m,
        carriage_velocity_m_s: pin_speed,
        ..Carriage::defaults()
    })?;
    assembly.couple(SliderCrank::new(*p), motor.with_drift(pin_speed), &p.contacts)
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
/// Flores, Leine, Glocker, *Modeling and analysis of planar rigid multibody systems with translational clearance joints
/// based on the non-smooth dynamics approach* (2010).
#[derive(Debug, Clone)]
pub struct SliderCrank {
    p: Crank,
    /// e(θ₁), e(θ₂).
    along: [Vector2<f64>; 2],
    slider: Rotation2<f64>,
}

const VELOCITIES: usize = 3;
/// Ends of the slider and walls of the corners, in units of a and b.
const CORNERS: [[f64; 2]; 4] = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];

impl SliderCrank {
    /// Stretches crank and rod along the guide, the slider in its middle.
    pub fn new(p: Crank) -> Self {
        SliderCrank { p, along: [Vector2::new(1.0, 0.0); 2], slider: Rotation2::identity() }
    }

    /// `(m₂/2 + m₃) l₁ l₂`, kg·m².
    fn coupling(&self) -> f64 {
        let g = &self.p;
        (0.5 * g.rod_mass_kg + g.slider_mass_kg) * g.crank_length_m * g.rod_length_m
    }

    /// Weights that crank pin and slider pin carry along with l₁ and l₂, kg.
    fn carried(&self) -> [f64; 2] {
        let [crank, rod, slider] = self.p.masses();
        [0.5 * crank + rod + slider, 0.5 * rod + slider]
    }

    /// Writes the rate of a corner's place along a fixed direction, and its convective term; returns the place.
    fn corner(&self, v: &[f64], corner: usize, direction: Vector2<f64>, rows: &mut Rows) -> f64 {
        let g = &self.p;
        let [end, wall] = CORNERS[corner];
        let arm = self.slider * Vector2::new(end * g.slider_half_length_m, wall * g.slider_half_height_m);
        let arms = [g.crank_length_m * self.along[0], g.rod_length_m * self.along[1], arm];
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
        ModelSize {
            velocities: VELOCITIES,
            unilateral: 4,
            tangential: 4,
            interface: 1,
            mass: MatrixForm::Dense,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; VELOCITIES], self.p.rates().to_vec())
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        for (along, angle) in self.along.iter_mut().zip(q) {
            let (sin, cos) = libm::sincos(*angle);
            *along = Vector2::new(cos, sin);
        }
        self.slider = rotation(q[2]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        let ([m1, m2, m3], [l1, l2]) = (self.p.masses(), self.p.lengths());
        let [j1, j2, j3] = [self.p.crank_inertia_kg_m2, self.p.rod_inertia_kg_m2, self.p.slider_inertia_kg_m2];
        let m12 = self.coupling() * self.along[0].dot(&self.along[1]);
        mass.copy_from_slice(&[
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

    fn forces(&self, _q: &[f64], v: &[f64], force: &mut [f64]) {
        let g = &self.p;
        let [crank, rod] = self.carried();
        // sin(θ₁ − θ₂)
        let turned = self.coupling() * self.along[1].perp(&self.along[0]);
        force.copy_from_slice(&[
            -crank * g.gravity_m_s2 * g.crank_length_m * self.along[0].x - turned * v[1] * v[1],
            -rod * g.gravity_m_s2 * g.rod_length_m * self.along[1].x + turned * v[0] * v[0],
            0.0,
        ]);
    }

    fn unilateral(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        let half = self.p.slider_half_height_m + self.p.clearance_m;
        for (corner, [_, wall]) in CORNERS.into_iter().enumerate() {
            rows.position[corner] = half + self.corner(v, corner, Vector2::new(0.0, -wall), rows);
        }
    }

    fn tangential(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        for (corner, [_, wall]) in CORNERS.into_iter().enumerate() {
            self.corner(v, corner, Vector2::new(-wall, 0.0), rows);
        }
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        let radius = self.p.crank_length_m;
        rows.jacobian[0] = radius;
        rows.position[0] = radius * q[0];
    }

    fn potential_energy(&self, _q: &[f64]) -> f64 {
        let g = &self.p;
        let weights = self.carried().into_iter().zip(g.lengths()).zip(&self.along);
        weights.map(|((carried, length), along)| g.gravity_m_s2 * carried * length * along.y).sum()
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(
            &[
                "crank_angle_rad",
                "rod_angle_rad",
                "slider_angle_rad",
                "crank_rate_rad_s",
                "rod_rate_rad_s",
                "slider_rate_rad_s",
                "slider_x_m",
                "slider_y_m",
            ],
            &CORNER_NAMES,
        )
    }

    fn observe(&self, q: &[f64], v: &[f64], row: &mut [f64]) {
        row[..VELOCITIES].copy_from_slice(q);
        row[VELOCITIES..2 * VELOCITIES].copy_from_slice(v);
        let [l1, l2] = self.p.lengths();
        let pin = l1 * self.along[0] + l2 * self.along[1];
        row[2 * VELOCITIES..].copy_from_slice(&[pin.x, pin.y]);
    }
}

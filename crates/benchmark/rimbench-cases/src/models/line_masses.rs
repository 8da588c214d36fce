//! Point masses on one axis, with springs between them and to the ground, and contacts among them and with stops.

use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{MassMatrix, MatrixForm, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize, StiffForces};
use rimbench_core::name::Name;

/// One mass.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LineMass {
    /// kg.
    pub mass: f64,
    /// Of the spring to the ground, N/m.
    pub stiffness: f64,
    /// Of the damper to the ground, N·s/m.
    pub damping: f64,
    /// Position at which the spring to the ground is relaxed, m.
    pub anchor: f64,
    /// Constant force, N.
    pub load: f64,
    /// Position (m) and velocity (m/s) at the start.
    pub start: [f64; 2],
}

impl LineMass {
    /// The part of the force on it that stays as it is, N.
    pub(super) fn held_force(&self) -> f64 {
        self.stiffness * self.anchor + self.load
    }
}

/// A spring between two masses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSpring {
    /// The two masses.
    pub between: [usize; 2],
    /// N/m.
    pub stiffness: f64,
    /// `x₂ − x₁` at which it is relaxed, m.
    pub length: f64,
}

/// A contact between neighbours, `g = x_above − x_below − d ≥ 0`; no mass stands for the ground, which is at 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineContact {
    /// The lower mass.
    pub below: Option<usize>,
    /// The upper mass.
    pub above: Option<usize>,
    /// d, m; negative for a stop above: a mass below a stop at x = p has `d = −p`.
    pub distance: f64,
}

impl LineContact {
    fn write(&self, row: usize, q: &[f64], rows: &mut Rows) {
        let mut gap = -self.distance;
        for (slot, (mass, sign)) in [(self.above, 1.0), (self.below, -1.0)].into_iter().enumerate() {
            if let Some(mass) = mass {
                rows.set(row, slot, mass, sign);
                gap += sign * q[mass];
            }
        }
        rows.position[row] = gap;
    }
}

/// What a [`LineMasses`] is made of, and how its data are named.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LineDescription {
    /// The masses in order of position.
    pub masses: Vec<LineMass>,
    /// Springs between them.
    pub springs: Vec<LineSpring>,
    /// Contacts, in the order of the names.
    pub contacts: Vec<LineContact>,
    /// The mass that the actuator holds.
    pub driven: usize,
    /// Names of the positions of the first masses, then of their velocities.
    pub state_names: Vec<Name>,
    /// Names of the contacts, as [`ModelNames::contacts`] has them.
    pub contact_names: Vec<Name>,
}

/// The mechanics; velocities are those of the masses.
///
/// ```text
/// m_i ẍ_i = load_i − k_i (x_i − anchor_i) − c_i ẋ_i + springs + contacts + F [i driven]
/// ```
/// Where masses are tied to each other, steps of the second order that are long for that take springs and dampers
/// implicitly.
#[derive(Debug, Clone, PartialEq)]
pub struct LineMasses {
    line: LineDescription,
}

impl LineMasses {
    /// Builds the mechanics.
    ///
    /// # Errors
    /// [`Error::Incompatible`] with the gap if a contact would start penetrated.
    pub fn new(line: LineDescription) -> Result<Self> {
        let model = LineMasses { line };
        let (q, v) = model.initial_state();
        let mut rows = Rows::zeros(model.line.contacts.len(), q.len());
        model.unilateral(&q, &v, &mut rows);
        for (contact, gap) in rows.position.iter().enumerate() {
            if *gap < -ROUND_OFF {
                let name =
                    model.line.contact_names.get(contact).map_or("a gap".to_owned(), |name| format!("gap_{name}_m"));
                return Err(Error::Incompatible(format!(
                    "impossible geometry: {name} would start at {gap:.6} m; it must not be below 0"
                )));
            }
        }
        Ok(model)
    }
}

/// Gaps of touching masses are differences of positions of up to some metres, m.
const ROUND_OFF: f64 = 1e-12;

impl MechanicalModel for LineMasses {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: self.line.masses.len(),
            unilateral: self.line.contacts.len(),
            interface: 1,
            stiff_forces: (!self.line.springs.is_empty()).then_some(MatrixForm::Dense),
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let of = |index: usize| self.line.masses.iter().map(|body| body.start[index]).collect();
        (of(0), of(1))
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        for (entry, body) in mass.iter_mut().zip(&self.line.masses) {
            *entry = body.mass;
        }
    }

    fn forces(&self, q: &[f64], v: &[f64], force: &mut [f64]) {
        for (i, body) in self.line.masses.iter().enumerate() {
            force[i] = body.load - body.stiffness * (q[i] - body.anchor) - body.damping * v[i];
        }
        for spring in &self.line.springs {
            let [first, second] = spring.between;
            let tension = spring.stiffness * (q[second] - q[first] - spring.length);
            force[first] += tension;
            force[second] -= tension;
        }
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        self.line.contacts.iter().enumerate().for_each(|(row, contact)| contact.write(row, q, rows));
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[self.line.driven] = 1.0;
        rows.position[0] = q[self.line.driven];
    }

    fn stiff_forces(&self, _q: &[f64], _v: &[f64], forces: &mut StiffForces) {
        let n = self.line.masses.len();
        let StiffForces { stiffness: MassMatrix::Dense(k), damping: MassMatrix::Dense(d) } = forces else { return };
        k.fill(0.0);
        for (i, body) in self.line.masses.iter().enumerate() {
            k[i * n + i] = body.stiffness;
            d[i * n + i] = body.damping;
        }
        for spring in &self.line.springs {
            let [first, second] = spring.between;
            for (row, column, sign) in
                [(first, first, 1.0), (second, second, 1.0), (first, second, -1.0), (second, first, -1.0)]
            {
                k[row * n + column] += sign * spring.stiffness;
            }
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let of_body = |(body, x): (&LineMass, &f64)| 0.5 * body.stiffness * (x - body.anchor).powi(2) - body.load * x;
        let of_spring = |spring: &LineSpring| {
            let [first, second] = spring.between;
            0.5 * spring.stiffness * (q[second] - q[first] - spring.length).powi(2)
        };
        self.line.masses.iter().zip(q).map(of_body).sum::<f64>() + self.line.springs.iter().map(of_spring).sum::<f64>()
    }

    fn names(&self) -> ModelNames {
        ModelNames { observables: self.line.state_names.clone(), contacts: self.line.contact_names.clone() }
    }

    fn observe(&self, q: &[f64], v: &[f64], row: &mut [f64]) {
        let (positions, velocities) = row.split_at_mut(row.len() / 2);
        positions.copy_from_slice(&q[..positions.len()]);
        velocities.copy_from_slice(&v[..velocities.len()]);
    }
}

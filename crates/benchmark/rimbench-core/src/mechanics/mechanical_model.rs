//! The trait by which a case describes a mechanical system.

use super::stiff_forces::StiffForces;
use crate::error::Failure;
use crate::interface_model::{MatrixForm, Rows};
use crate::name::{Name, names};

/// Numbers of velocities, rows and switches, and what else of a model is constant throughout a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ModelSize {
    /// Generalised velocities n.
    pub velocities: usize,
    /// Bilateral rows n_b (joints).
    pub bilateral: usize,
    /// Unilateral rows n_u (possible contacts, open ones included).
    pub unilateral: usize,
    /// Tangential rows: one per unilateral row in the plane, two in space, or none if the model has no friction to
    /// offer.
    pub tangential: usize,
    /// Interface rows n_i.
    pub interface: usize,
    /// Quantities at whose change of sign geometry or forces have a kink, such as the place where a corner turns into a
    /// ramp.
    pub switches: usize,
    /// Which entries the mass matrix has.
    pub mass: MatrixForm,
    /// Whether the mass matrix is the same at every q: then it is written once, and adds nothing to the kinetic energy
    /// as q changes.
    pub constant_mass: bool,
    /// Which entries the stiffness and damping have that a step of the second order is to take implicitly; none where
    /// all forces are taken as they are. A model whose fastest oscillation is of no interest, but sets the step, has
    /// some.
    pub stiff_forces: Option<MatrixForm>,
    /// Contacts that are plastic, whatever the restitution of the others.
    pub plastic: &'static [usize],
}

/// Names of what a model shows.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ModelNames {
    /// What [`observe`](MechanicalModel::observe) writes, with units.
    pub observables: Vec<Name>,
    /// The contacts of the first unilateral rows: of `left_wedge` the gap is `gap_left_wedge_m`, the force
    /// `contact_force_left_wedge_n`. A model with a few contacts names them all; one with many names the first, and
    /// shows the least gap of the others among its observables.
    pub contacts: Vec<Name>,
}

impl ModelNames {
    /// Takes literal names.
    pub fn of(observables: &[&'static str], contacts: &[&'static str]) -> Self {
        ModelNames { observables: names(observables), contacts: names(contacts) }
    }
}

/// A mechanical system in coordinates `q` with velocities `v`.
///
/// [`prepare`](Self::prepare) is called once per state, before the others; a model keeps there what several of them
/// need, such as the sine and cosine of an angle. Rows that are structurally zero need not be written again. What a
/// model has none of, it need not write: joints, contacts, observables.
pub trait MechanicalModel: Send {
    /// Numbers of velocities, rows and switches, and what else is constant.
    fn size(&self) -> ModelSize;

    /// Returns q and v at the start; their units are the model's, those of rows and gaps m and m/s.
    fn initial_state(&self) -> (Vec<f64>, Vec<f64>);

    /// Adds to q what velocities v give in `h` (s): `q + h v` where each velocity is the rate of a coordinate, as it is
    /// unless a model says otherwise. Orientations in space are unit quaternions, of four coordinates for three
    /// velocities.
    ///
    /// # Panics
    /// If there are as many coordinates as velocities for that, and the model has another number and does not say
    /// otherwise.
    #[inline]
    fn advance_positions(&self, q: &mut [f64], v: &[f64], h: f64) {
        assert_eq!(
            q.len(),
            v.len(),
            "a model whose coordinates are not as many as its velocities advances them itself"
        );
        for (q, v) in q.iter_mut().zip(v) {
            *q += h * v;
        }
    }

    /// Takes note of a new state.
    fn prepare(&mut self, _q: &[f64], _v: &[f64]) {}

    /// Writes the entries of `M(q)`: its diagonal, or all of them row by row, as [`ModelSize::mass`] says.
    fn mass_matrix(&self, q: &[f64], entries: &mut [f64]);

    /// Writes `f_a − c`, one entry per velocity: applied forces minus Coriolis and centrifugal terms.
    fn forces(&self, q: &[f64], v: &[f64], force: &mut [f64]);

    /// Writes `A_b`, `Ȧ_b v` and joint errors.
    fn bilateral(&self, _q: &[f64], _v: &[f64], _rows: &mut Rows) {}

    /// Writes `A_u`, `Ȧ_u v` and gaps.
    fn unilateral(&self, _q: &[f64], _v: &[f64], _rows: &mut Rows) {}

    /// Lists the columns of the velocities that each unilateral row can involve, in the order of the
    /// slots that [`Rows::set`] is given, where a row involves few of many; none where all rows may involve all.
    ///
    /// With many contacts, no joints and a diagonal mass only those entries are then kept: the rows must be written by
    /// [`Rows::set`].
    fn contact_columns(&self) -> Option<Vec<Vec<usize>>> {
        None
    }

    /// Checks that bodies have not moved beyond what the list of possible contacts holds for; asked after each step, with
    /// the positions at its end.
    ///
    /// # Errors
    /// If they have.
    fn check_contact_list(&self, _q: &[f64]) -> Result<(), Failure> {
        Ok(())
    }

    /// Writes `A_t`, `Ȧ_t v`: for each unilateral row the velocity along the surface, along its normal turned
    /// clockwise, without positions. In space first those along a direction of each surface, then those along a second
    /// one: both and the normal are orthonormal. Called only for models that have tangential rows, and only with
    /// friction.
    fn tangential(&self, _q: &[f64], _v: &[f64], _rows: &mut Rows) {}

    /// Writes `A_i`, `Ȧ_i v` and interface coordinates.
    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows);

    /// Writes value and rate of each switch.
    fn switch_values(&self, _q: &[f64], _v: &[f64], _switches: &mut [[f64; 2]]) {}

    /// Writes the stiffness and damping of [`ModelSize::stiff_forces`].
    fn stiff_forces(&self, _q: &[f64], _v: &[f64], _forces: &mut StiffForces) {}

    /// Returns the potential energy, J.
    fn potential_energy(&self, q: &[f64]) -> f64;

    /// Names observables and contacts.
    fn names(&self) -> ModelNames {
        ModelNames::default()
    }

    /// Writes the model's own observables: the first of its coordinates, unless it says otherwise.
    fn observe(&self, q: &[f64], _v: &[f64], row: &mut [f64]) {
        row.copy_from_slice(&q[..row.len()]);
    }
}

//! A reduced interface model in space with one tangential row per contact, along the slip at the communication point.

use super::model_options::{FrictionRows, ModelOptions};
use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::friction::ContactState;

/// The planar model that stands for one in space.
///
/// ```text
/// H′ = R H Rᵀ,  a′ = R a,  w′ = R w        R = [n; d·t; i]
/// d = w_t/|w_t| of a contact that moved in the mechanics' last step,  P_t/|P_t| of one that stuck
/// ```
/// A contact that sticks would begin to slide against its friction force. One that was not pushed along its surface has
/// no direction, and takes its first tangent.
#[derive(Clone)]
pub(super) struct SlipRows {
    plane: ReducedInterfaceModel,
    directions: Vec<[f64; 2]>,
}

impl SlipRows {
    /// Reserves models like `empty`, where the options ask for one row.
    pub(super) fn of(empty: &ReducedInterfaceModel, options: &ModelOptions) -> Option<Box<Self>> {
        (options.friction_rows == FrictionRows::SlipDirection).then(|| {
            let mut plane = ReducedInterfaceModel::zeros_with_friction(&empty.friction, empty.interface());
            plane.spring = empty.spring;
            Box::new(SlipRows { plane, directions: empty.directions.clone() })
        })
    }

    /// Returns the model last written.
    pub(super) fn plane(&self) -> &ReducedInterfaceModel {
        &self.plane
    }

    /// Writes what a model in space is in the plane.
    pub(super) fn write(&mut self, model: &ReducedInterfaceModel) {
        let SlipRows { plane, directions } = self;
        let (n, n_t) = (model.contacts(), 2 * model.contacts());
        for (contact, direction) in directions.iter_mut().enumerate() {
            *direction = match model.states[contact] {
                ContactState::Stick => direction_of(&model.solved_forces, n + contact, n_t + contact),
                _ => model.directions[contact],
            };
        }
        // The rows of the model that a row of the plane is made of, and their shares.
        let parts = |row: usize| match row {
            _ if row < n => [(row, 1.0), (row, 0.0)],
            _ if row < n_t => [(row, directions[row - n][0]), (row + n, directions[row - n][1])],
            _ => [(row + n, 1.0), (row + n, 0.0)],
        };
        let rows = plane.a.len();
        for row in 0..rows {
            let own = parts(row);
            let along = |values: &[f64]| own.iter().map(|&(source, share)| share * values[source]).sum::<f64>();
            (plane.a[row], plane.w[row]) = (along(&model.a), along(&model.w));
            for column in 0..=row {
                let entry = parts(column).iter().map(|&(source, share)| share * along(model.row(source))).sum();
                (plane.h[row * rows + column], plane.h[column * rows + row]) = (entry, entry);
            }
        }
        plane.gap.copy_from_slice(&model.gap);
        plane.position.copy_from_slice(&model.position);
        plane.at_bound.copy_from_slice(&model.at_bound);
        plane.friction.copy_from_slice(&model.friction);
        plane.states.copy_from_slice(&model.states);
        plane.solved_states.copy_from_slice(&model.states);
        (plane.stabilisation, plane.mechanics_step) = (model.stabilisation, model.mechanics_step);
        plane.spring = model.spring;
    }
}

/// Returns the direction of the friction force in two rows, the first tangent where there is none.
fn direction_of(forces: &[f64], first: usize, second: usize) -> [f64; 2] {
    let (x, y) = (forces[first], forces[second]);
    let size = (x * x + y * y).sqrt();
    if size > 0.0 { [x / size, y / size] } else { [1.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contacts of 2 kg that slide, stick, and stick without a force along the surface, each moved by the interface as
    /// it is by its tangents.
    #[test]
    fn a_row_lies_along_the_slip_of_a_contact_and_along_its_friction_force_where_it_sticks() {
        let mut model = ReducedInterfaceModel::zeros_in_space(&[0.5; 3], 1);
        let rows = model.a.len();
        for contact in 0..3 {
            for axis in 0..3 {
                let row = 3 * axis + contact;
                model.h[row * rows + row] = 0.5;
                model.w[row] = (1 + axis) as f64;
                model.a[row] = -model.w[row];
            }
            for (row, entry) in [(3 + contact, 0.3), (6 + contact, 0.1)] {
                (model.h[row * rows + 9], model.h[9 * rows + row]) = (entry, entry);
            }
        }
        model.h[9 * rows + 9] = 1.0;
        model.states = vec![ContactState::SlipPositive, ContactState::Stick, ContactState::Stick];
        model.directions[0] = [0.6, -0.8];
        (model.solved_forces[4], model.solved_forces[7]) = (-8.0, 6.0);
        let options = ModelOptions { friction_rows: FrictionRows::SlipDirection, ..ModelOptions::default() };
        let mut one = SlipRows::of(&model, &options).unwrap();
        one.write(&model);
        let plane = one.plane();
        assert!(plane.check().is_ok() && !plane.is_in_space() && plane.interface_start() == 6);
        for (contact, [x, y]) in [[0.6, -0.8], [-0.8, 0.6], [1.0, 0.0]].into_iter().enumerate() {
            let (row, w) = (3 + contact, 2.0 * x + 3.0 * y);
            assert_eq!((plane.w[contact], plane.w[row], plane.a[row]), (1.0, w, -w));
            assert!((plane.entry(row, row) - 0.5).abs() < 1e-15);
            assert_eq!(plane.entry(row, 6), 0.3 * x + 0.1 * y);
        }
        assert_eq!((plane.entry(6, 6), &plane.solved_states), (1.0, &model.states));
    }
}

//! Rows of models are the first and second derivatives of their gaps, joints and lengths.

use crate::contact_machines::{car, crane, row};
use crate::support::*;
use rimbench::cases::{Gripper, HalfCar, SliderCrank};
use rimbench::models::{ContactList, CraneWithRope, Discs, WedgeBox, WedgeBoxGeometry};

/// Along `q + v t` no acceleration acts: rates of positions are `A v`, second derivatives `Ȧ v`; along surfaces `Ȧ v`
/// is the rate of `A v`. `third` bounds the third derivatives there, 1/s³, and ten times it the fourth.
fn assert_derivatives(name: &str, model: &mut impl MechanicalModel, q: &[f64], v: &[f64], third: f64) {
    let e = 1e-4;
    let mut along = Rows::zeros(model.size().tangential, v.len());
    let [before, now, after] = [-e, 0.0, e].map(|t| {
        let place: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + v * t).collect();
        let eq3 = linearise(model, &place, v);
        model.tangential(&place, v, &mut along);
        let rows = [eq3.bilateral, eq3.unilateral, eq3.interface, along.clone()];
        rows.map(|rows| (0..rows.len()).map(|i| [rows.position[i], rows.velocity(i, v), rows.convective[i]]).collect())
    });
    // A mass said to be constant is that of the start.
    if model.size().constant_mass {
        let start = model.initial_state().0;
        assert_eq!(linearise(model, q, v).mass, linearise(model, &start, v).mass, "{name}");
    }
    let each = before.iter().zip(&now).zip(&after).enumerate();
    for (kind, ((before, now), after)) in each {
        let rows: [&Vec<[f64; 3]>; 3] = [before, now, after];
        for (row, now) in now.iter().enumerate() {
            let [before, after] = [rows[0][row], rows[2][row]];
            let close = |found: f64, wanted: f64, bound: f64| {
                assert!((found - wanted).abs() < bound, "{name}, kind {kind}, row {row}: {found}, not {wanted}");
            };
            close((after[1] - before[1]) / (2.0 * e), now[2], third * e * e);
            if kind < 3 {
                close((after[0] - before[0]) / (2.0 * e), now[1], third * e * e);
                // Rounding of a metre in the second difference is 4e-16/e².
                close((after[0] - 2.0 * now[0] + before[0]) / (e * e), now[2], 10.0 * third * e * e);
            }
        }
    }
}

#[test]
fn rows_are_the_derivatives_of_gaps_joints_and_lengths_and_of_velocities_along_surfaces() {
    let mut rope = CraneWithRope::new(crane(0.5), -1.0).unwrap();
    assert_derivatives("rope", &mut rope, &[0.6, 0.7, 0.1], &[0.3, -0.2, 0.15], 200.0);
    let mut car = HalfCar::new(car()).unwrap();
    assert_derivatives("car", &mut car, &[2.13, 0.6, 0.07, 0.02, 0.03], &[0.8, -0.1, 0.3, 0.2, 0.1], 200.0);
    let mut gripper = Gripper::new(defaults("gripper")).unwrap();
    assert_derivatives("gripper", &mut gripper, &[-0.2, 0.22, 0.01, 0.21, 0.1], &[0.2, -0.1, 0.3, 0.1, 0.4], 200.0);
    let mut discs = Discs::new(row(2, 0.005, 0.0), ContactList::Neighbours).unwrap();
    assert_derivatives("discs", &mut discs, &[0.01, 0.11, 0.12, 0.33, 0.1], &[0.3, 0.1, -0.2, 0.3, 0.4], 200.0);
    let mut slider = SliderCrank::new(defaults("slider-crank"));
    assert_derivatives("slider-crank", &mut slider, &[0.7, -0.31, 0.02], &[1.5, -0.6, 0.03], 5.0);
    let block = WedgeBoxGeometry {
        box_mass: 200.0,
        box_size: [0.4, 1.0],
        wedges: vec![[0.2, -0.5], [-0.2, -0.5]],
        start_angle: -0.05,
        attachment: [-0.2, 0.1],
        ground_pin_x: -2.0,
        gravity: 9.81,
        ..WedgeBoxGeometry::default()
    };
    assert_derivatives("block", &mut WedgeBox::new(block).unwrap(), &[0.1, 0.5, 0.07], &[0.3, -0.2, 0.6], 5.0);
    // Disc before, above and beyond the corner; box and disc apart from each other, so that joint rows count too.
    let geometry = wedge_box_geometry();
    let mut model = WedgeBox::new(geometry.clone()).unwrap();
    let corner = model.initial_state().0[3] + geometry.discs[0].ledge_lead;
    for (disc_x, angle) in [(corner - 0.3, 0.3), (corner + 0.012, -0.04), (corner + 0.5, -0.2)] {
        let q = [disc_x + 0.8, 0.45, angle, disc_x, 0.27, 0.1];
        assert_derivatives("wedge box", &mut model, &q, &[0.7, -0.4, 1.3, 0.5, 0.2, -0.6], 5.0);
    }
}

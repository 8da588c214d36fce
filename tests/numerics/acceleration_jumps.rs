//! Gap functions that are sent with the place where their curvature changes.

use crate::support::*;
use approx::assert_relative_eq;

fn moving(motion: ModelMotion) -> Option<ModelOptions> {
    Some(ModelOptions { model_motion: motion, ..ModelOptions::default() })
}

/// The road of the half car is flat, then `½ h (1 − cos k(x − x₀))`: where it begins its curvature is `½ h k²`, and the
/// gap of a wheel that comes to it at speed v gets `−½ h k² v²`. Front and rear come to it at `(x₀ − x)/v`.
#[test]
fn the_kink_of_a_road_lies_where_the_car_will_be_and_bends_the_gap_by_its_curvature() {
    let spec = usual_spec("half-car", "rim-nonsmooth-gap", 5e-3);
    let number = |name: &str| spec.parameters.setting::<f64>(name).unwrap();
    let mut system = usual_system(&spec.case);
    let mechanics = system.sides.mechanics.capabilities();
    let mut model = mechanics.empty_interface_model().unwrap();
    // Nobody asks.
    assert!(mechanics.interface_model(5e-3, &mut model).unwrap());
    assert_eq!(model.acceleration_jumps.iter().count(), 0);
    let quiet = model.clone();
    model.acceleration_jumps.requested = true;
    assert!(mechanics.interface_model(5e-3, &mut model).unwrap());
    let kinks: Vec<(f64, Vec<f64>)> =
        model.acceleration_jumps.iter().map(|(time, jumps)| (time, jumps.to_vec())).collect();
    assert_eq!(kinks.len(), 2);
    let (start, speed) = (number("road_start_m"), number("speed_m_s"));
    let axles = number("front_axle_m") + number("rear_axle_m");
    let wave = std::f64::consts::TAU / number("wavelength_m");
    let bend = 0.5 * number("road_height_m") * wave.powi(2);
    // The sides are looked at 10 nm aside; meanwhile the curvature under the other wheel changes by its own rate.
    let smooth = 2e-8 * bend * wave * speed * speed;
    for (axle, (time, jumps)) in kinks.iter().enumerate() {
        assert_relative_eq!(*time, (start + axle as f64 * axles) / speed, max_relative = 1e-12);
        assert_relative_eq!(jumps[axle], -bend * speed * speed, max_relative = 1e-12);
        assert!(jumps[1 - axle].abs() < 1.0001 * smooth && jumps[2..] == [0.0, 0.0], "{jumps:?}");
    }
    // The rest of the model is what it was, to the bit, and stays so.
    model.acceleration_jumps.clone_from(&quiet.acceleration_jumps);
    assert_eq!(model, quiet);
}

/// On the wedge box the disc comes to the corner and to the ramp.
#[test]
fn a_model_that_knows_the_next_kink_has_less_error_on_the_wedge_box() {
    let spec = |motion, phase: u32| {
        usual_spec("wedge-box", "rim-nonsmooth-gap", 5e-3).changed(|own| {
            (own.mechanics_integrator, own.actuator_integrator, own.model, own.phase) =
                (MechanicsIntegrator::EventSplit, ActuatorIntegrator::Midpoint, moving(motion), f64::from(phase) / 8.0)
        })
    };
    let error = |motion| {
        let errors = (1..=8).map(|phase| {
            let spec = spec(motion, phase);
            metric(&spec, run(&spec), wedge_box_reference(), "force_error_rms_n")
        });
        Pool::of(errors).median().unwrap()
    };
    let [frozen, piecewise] = [ModelMotion::Frozen, ModelMotion::Piecewise].map(error);
    assert!(piecewise < 0.7 * frozen, "{piecewise} N instead of {frozen} N");
}

/// Without a kink nothing moves.
#[test]
fn where_the_geometry_has_no_kink_a_piecewise_model_is_a_frozen_one_to_the_bit() {
    for case in ["crane-set-down", "disc-row", "gripper"] {
        let digits = |motion| {
            let spec = usual_spec(case, "rim-nonsmooth-gap", 5e-3)
                .changed(|own| (own.model, own.duration) = (moving(motion), 0.5));
            bits(&run(&spec).trajectory)
        };
        assert_eq!(digits(ModelMotion::Piecewise), digits(ModelMotion::Frozen), "{case}");
    }
}

/// With friction the jumps are those of `[n; t; i]`, without it those of `[n; i]`.
#[test]
fn a_kink_must_bend_each_row_by_its_own_curvature_with_friction_and_without() {
    let jumps = |friction: Option<f64>| {
        // Rows that bend beyond x = 1 m: off the surface, along it, and at the interface, each by its own curvature.
        let point = LinearModel::new(&[1.0, 1.0], &[0.0, -9.81], &[(&[1.0, 0.0], 0.0)])
            .over(&[(&[0.0, 1.0], 0.0)])
            .along(&[(&[1.0, 0.0], 0.0)])
            .moving(&[0.5, 0.0]);
        let bends = Some([-3.0, 5.0, 7.0]);
        let mut mechanics = stepper(LinearModel { bends, q: vec![0.25, 0.0], ..point }, PLASTIC);
        if let Some(coefficient) = friction {
            let law = Friction { coefficient, at_rest: coefficient, restitution: 0.0 };
            mechanics = mechanics.with_friction(law, solver()).unwrap();
        }
        let mut model = mechanics.empty_interface_model().unwrap();
        model.acceleration_jumps.requested = true;
        assert!(mechanics.interface_model(1e-3, &mut model).unwrap());
        let kinks: Vec<(f64, Vec<f64>)> =
            model.acceleration_jumps.iter().map(|(time, jumps)| (time, jumps.to_vec())).collect();
        assert_eq!(kinks.len(), 1);
        assert_relative_eq!(kinks[0].0, 0.75 / 0.5, max_relative = 1e-14);
        kinks[0].1.clone()
    };
    assert_eq!(jumps(Some(0.3)), [-0.75, 1.25, 1.75]);
    assert_eq!(jumps(None), [-0.75, 1.75]);
}

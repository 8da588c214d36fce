//! `slider-crank`: a motor turns a crank through a shaft; the slider has play in its guide and touches it with four corners, with friction. The
//! motor is a rotor (mass m_a at the crank's radius) between a shaft (k, c) and what it turns against: c_b times what it is slower than its nominal
//! speed. Shown in `docs/cases/slider-crank.md`; crank, rod, slider and guide of Flores, Leine, Glocker 2010, motor *ours*.

use super::prelude::*;

parameters! {
    /// A slider-crank, its guide and its motor.
    struct Crank from "Flores et al. 2010" {
        crank_length_m: f64 = 0.153, Positive, "length l₁ of the crank";
        rod_length_m: f64 = 0.306, Positive, "length l₂ of the connecting rod";
        slider_half_length_m: f64 = 0.05, Positive, "half the length a of the slider";
        slider_half_height_m: f64 = 0.025, Positive, "half the height b of the slider";
        clearance_m: f64 = 1e-3, Positive, "play c above and below the slider";
        crank_mass_kg: f64 = 0.038, Positive, "mass m₁ of the crank";
        rod_mass_kg: f64 = 0.038, Positive, "mass m₂ of the rod";
        slider_mass_kg: f64 = 0.076, Positive, "mass m₃ of the slider";
        crank_inertia_kg_m2: f64 = 7.4e-5, Positive, "inertia J₁ of the crank about its middle";
        rod_inertia_kg_m2: f64 = 5.9e-4, Positive, "inertia J₂ of the rod about its middle";
        slider_inertia_kg_m2: f64 = 2.7e-6, Positive, "inertia J₃ of the slider";
        speed_rad_s: f64 = 150.0, NotNegative, "speed of crank and motor at the start, and of the motor";
        rotor_mass_kg: f64 = 1.0, Positive, "mass m_a of the rotor at the crank's radius" from "ours";
        shaft_stiffness_n_m: f64 = 1e5, NotNegative, "stiffness k of the shaft; 0 without damping: no motor" from "ours";
        shaft_damping_n_s_m: f64 = 20.0, NotNegative, "damping c of the shaft" from "ours";
        motor_damping_n_s_m: f64 = 50.0, NotNegative, "force c_b of the motor per speed lost" from "ours";
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity" from "standard";
        contacts: Contacts only {
            stabilisation;
            restitution = 0.4 from "Flores et al. 2010";
            friction = 0.01 in Positive from "Flores et al. 2010";
            tangential_restitution;
        };
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: words(
            "time_s crank_angle_rad crank_rate_rad_s slider_x_m slider_y_m slider_angle_rad \
             interface_position_m interface_velocity_m_s actuator_force_n force_to_mechanics_n \
             effective_mass_kg gap_upper_rear_m gap_upper_front_m gap_lower_rear_m gap_lower_front_m \
             contact_state_upper_rear contact_state_upper_front contact_state_lower_rear \
             contact_state_lower_front closed_contacts",
        ),
        drawing_columns: words(
            "rod_angle_rad rod_rate_rad_s slider_rate_rad_s contact_force_upper_rear_n \
             contact_force_upper_front_n contact_force_lower_rear_n contact_force_lower_front_n \
             friction_force_upper_rear_n friction_force_upper_front_n friction_force_lower_rear_n \
             friction_force_lower_front_n",
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
        Shape::Polygon(
            [[left, from], [right, from], [right, to], [left, to]].map(|point| (point, None)).to_vec(),
            Fill::Ground,
        )
    };
    let bar = |name, length: f64, half: f64| points(name, [[0.0, -half], [length, -half], [length, half], [0.0, half]]);
    let pin =
        |name, x: f64, radius| Shape::Disc { at: ([x, 0.0], Some(name)), radius, spoke: false, fill: Fill::Metal };
    Drawing {
        view: [[-0.2, rod + crank + 0.1], [-0.2, 0.2]],
        frames: vec![
            frame("crank", 0.0, 0.0, "crank_angle_rad"),
            // The rod's angle is that of the world: its frame stands at the pin, turned back by the crank's.
            Frame {
                name: "pin",
                parent: Some("crank"),
                pose: [crank.into(), 0.0.into(), Channel::Column("crank_angle_rad", -1.0, 0.0)],
            },
            Frame { name: "rod", parent: Some("pin"), pose: [0.0.into(), 0.0.into(), "rod_angle_rad".into()] },
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
    let (lengths, speed) = ([p.crank_length_m, p.rod_length_m], p.speed_rad_s);
    if lengths[1] <= lengths[0] {
        let expected = format!("more than crank_length_m = {}: a shorter rod lets no crank turn", lengths[0]);
        return Err(Error::invalid("rod_length_m", lengths[1], expected));
    }
    let mechanism = SliderCrank::new(SliderCrankGeometry {
        masses: [p.crank_mass_kg, p.rod_mass_kg, p.slider_mass_kg],
        inertias: [p.crank_inertia_kg_m2, p.rod_inertia_kg_m2, p.slider_inertia_kg_m2],
        lengths,
        slider: [p.slider_half_length_m, p.slider_half_height_m],
        clearance: p.clearance_m,
        // So that the slider pin stays on the axis.
        rates: [speed, -speed * lengths[0] / lengths[1], 0.0],
        gravity: p.gravity_m_s2,
    });
    let pin_speed = lengths[0] * speed;
    let motor = SpringActuator::new(SpringActuatorParameters {
        stiffness: p.shaft_stiffness_n_m,
        damping: p.shaft_damping_n_s_m,
        carriage_mass: p.rotor_mass_kg,
        base_damping: p.motor_damping_n_s_m,
        base: BaseMotion { velocity: pin_speed, ..BaseMotion::default() },
        start: [0.0, pin_speed],
        ..SpringActuatorParameters::default()
    })?;
    assembly.couple(mechanism, motor, &p.contacts)
}

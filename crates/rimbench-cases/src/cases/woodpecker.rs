//! `woodpecker`: a bird on a spring pecks its way down a pole; its sleeve jams on the pole and lets go, hop by hop. The spring is the actuator, its
//! length measured on a lever r, so that `k = c/r²`. Shown in `docs/cases/woodpecker.md`; after Glocker 1995 and Leine, Glocker, van Campen 2001;
//! lever *ours*.

use super::prelude::*;

parameters! {
    /// The toy.
    struct Toy from "Glocker 1995" {
        sleeve_mass_kg: f64 = 3e-4, Positive, "mass m_M of the sleeve";
        bird_mass_kg: f64 = 4.5e-3, Positive, "mass m_S of the bird";
        sleeve_inertia_kg_m2: f64 = 5e-9, Positive, "inertia J_M of the sleeve";
        bird_inertia_kg_m2: f64 = 7e-7, Positive, "inertia J_S of the bird about its centre of mass";
        pole_radius_m: f64 = 2.5e-3, Positive, "radius r_O of the pole";
        sleeve_radius_m: f64 = 3.1e-3, Positive, "inner radius r_M of the sleeve, above that of the pole";
        sleeve_half_height_m: f64 = 5.8e-3, Positive, "half the height h_M of the sleeve";
        spring_distance_m: f64 = 1e-2, Positive, "l_M from the middle of the sleeve to the spring";
        bird_distance_m: f64 = 1.5e-2, Positive, "l_G from the spring to the bird's centre of mass";
        beak_height_m: f64 = 2e-2, Positive, "h_S of the beak above the bird's centre of mass";
        beak_length_m: f64 = 2.01e-2, Positive, "l_S of the beak before the bird's centre of mass";
        spring_stiffness_nm_rad: f64 = 5.6e-3, Positive, "torsional stiffness c of the spring";
        spring_lever_m: f64 = 1e-2, Positive, "lever r that length and force of the spring are measured on" from "ours";
        bird_angle_rad: f64 = -0.2788, Finite, "angle φ_S of the bird at the start";
        sleeve_velocity_m_s: f64 = -0.3411, Finite, "velocity of the sleeve at the start";
        bird_rate_rad_s: f64 = -7.4583, Finite, "angular velocity of the bird at the start";
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity" from "standard";
        contacts: Contacts only {
            stabilisation;
            restitution = 0.5, "restitution e of the beak along the normal; the sleeve's edges are plastic" from "Glocker 1995";
            friction = 0.3 in Positive from "Glocker 1995";
        };
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: words(
            "time_s sleeve_y_m sleeve_angle_rad bird_angle_rad interface_position_m interface_velocity_m_s \
             actuator_force_n force_to_mechanics_n effective_mass_kg gap_beak_m gap_lower_edge_m \
             gap_upper_edge_m contact_force_beak_n contact_force_lower_edge_n contact_force_upper_edge_n \
             friction_force_beak_n friction_force_lower_edge_n friction_force_upper_edge_n contact_state_beak \
             contact_state_lower_edge contact_state_upper_edge closed_contacts",
        ),
        interface_columns: carriage::interface(),
        constant_mechanics: true,
        drawing: drawn(|p: &Toy| Some(drawing(p))),
        reference: reference(),
        ..Case::new(
            "woodpecker",
            "Woodpecker toy: a bird on a spring descends a pole in hops, its sleeve jams and lets go (impacts, stick, slip)",
            times(0.3, 5e-4, 1e-5, [1e-5, 5e-5]),
            build,
        )
    }
}

fn drawing(p: &Toy) -> Drawing {
    let [inner, half, outer] = [p.sleeve_radius_m, p.sleeve_half_height_m, p.sleeve_radius_m + 1.5e-3];
    let side = |from: f64, to: f64| {
        Shape::Polygon(points("sleeve", [[from, -half], [to, -half], [to, half], [from, half]]), Fill::Metal)
    };
    let (back, beak) = (p.bird_distance_m, [p.bird_distance_m - p.beak_length_m, p.beak_height_m]);
    let body = [
        [back - 4e-3, -1.2e-2],
        [back + 5e-3, -8e-3],
        [back + 6e-3, 8e-3],
        [back, 2.2e-2],
        beak,
        [back - 5e-3, 1.6e-2],
    ];
    Drawing {
        view: [[-0.03, 0.05], [-0.028, 0.032]],
        frames: vec![
            frame("sleeve", 0.0, 0.0, "sleeve_angle_rad"),
            Frame {
                name: "bird",
                parent: None,
                pose: [p.spring_distance_m.into(), 0.0.into(), "bird_angle_rad".into()],
            },
        ],
        shapes: vec![
            wall([-p.pole_radius_m, -1.0], [p.pole_radius_m, 1.0]),
            side(-outer, -inner),
            side(inner, outer),
            Shape::Spring(([outer, 0.0], Some("sleeve")), ([back - 4e-3, 0.0], Some("bird")), 3e-3),
            Shape::Polygon(points("bird", body), Fill::Scheme),
        ],
        title: [
            "Woodpecker",
            "A bird on a spring pecks its way down a pole, seen from the sleeve that jams and lets go.",
        ],
        ..Drawing::default()
    }
}

fn build(p: &Toy, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let lever = p.spring_lever_m;
    let toy = Woodpecker::new(WoodpeckerGeometry {
        masses: [p.sleeve_mass_kg, p.bird_mass_kg],
        inertias: [p.sleeve_inertia_kg_m2, p.bird_inertia_kg_m2],
        pole_radius: p.pole_radius_m,
        sleeve_radius: p.sleeve_radius_m,
        sleeve_half_height: p.sleeve_half_height_m,
        spring_distance: p.spring_distance_m,
        bird_distance: p.bird_distance_m,
        beak_height: p.beak_height_m,
        beak_length: p.beak_length_m,
        lever,
        bird_angle: p.bird_angle_rad,
        velocities: [p.sleeve_velocity_m_s, p.bird_rate_rad_s],
        gravity: p.gravity_m_s2,
    })?;
    let spring = SpringActuator::new(SpringActuatorParameters {
        stiffness: p.spring_stiffness_nm_rad / (lever * lever),
        ..SpringActuatorParameters::default()
    })?;
    assembly.couple(toy, spring, &p.contacts)
}

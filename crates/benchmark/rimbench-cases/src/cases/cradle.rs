//! `cradle`: three balls on pendulums under Moreau's impact law, the first held by a carriage on springs. Shown in
//! `docs/cases/cradle.md`, which says why it ends where it does; after Moreau 1988 and Glocker 2001, numbers *ours*.

use super::prelude::*;

parameters! {
    /// Three balls and what holds the first.
    struct Cradle from "ours" {
        ball_mass_kg: f64 = 1.0, Positive, "mass of each ball";
        ball_diameter_m: f64 = 0.1, Positive, "diameter D";
        pendulum_frequency_rad_s: f64 = 5.0, NotNegative, "√(g/l) of each pendulum; small angles";
        start_position_m: f64 = -0.1, Finite, "position of the first ball at the start; it touches at 0";
        carriage: Carriage with |set| set
            .default("spring_stiffness_n_m", 2.0).default("carriage_mass_kg", 0.2)
            .default("base_stiffness_n_m", 4.0);
        contacts: Contacts with |set| set
            .only(&["restitution", "stabilisation"]).default("restitution", 1.0)
            .source("restitution", "Moreau 1988");
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: carriage::trace_columns(
            "carriage_position_m ball_2_x_m ball_3_x_m ball_2_velocity_m_s ball_3_velocity_m_s effective_mass_kg \
             gap_1_2_m gap_2_3_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words("carriage_velocity_m_s contact_force_1_2_n contact_force_2_3_n"),
        interface_columns: carriage::interface(),
        constant_mechanics: true,
        drawing: drawn(|p: &Cradle| Some(drawing(p))),
        ..Case::new(
            "cradle",
            "Three balls on pendulums under Moreau's impact law, the first held by a carriage on springs",
            times(1.8, 5e-3, 5e-4, [1e-5, 2e-4]),
            build,
        )
    }
}

fn drawing(p: &Cradle) -> Drawing {
    const STRING: f64 = 0.392;
    let d = p.ball_diameter_m;
    let rest = p.carriage.base_position_m;
    let ball = |name: &'static str| disc(([0.0, 0.0], Some(name)), d / 2.0, Fill::Scheme);
    let string = |x: f64, name: &'static str| Shape::Line(vec![([x, STRING], None), ([0.0, 0.0], Some(name))]);
    Drawing {
        view: [[-0.55, 0.42], [-0.1, 0.42]],
        frames: vec![
            frame("ball 1", "interface_position_m", 0.0, 0.0),
            frame("ball 2", "ball_2_x_m", 0.0, 0.0),
            frame("ball 3", "ball_3_x_m", 0.0, 0.0),
            // Springs of no length at rest are drawn a quarter of a metre long.
            frame("carriage", Channel::Column("carriage_position_m", 1.0, -0.25), 0.0, 0.0),
        ],
        shapes: vec![
            wall([-0.4, STRING], [0.4, STRING + 0.018]),
            wall([rest - 0.55, -0.1], [rest - 0.5, 0.1]),
            string(0.0, "ball 1"),
            string(d, "ball 2"),
            string(2.0 * d, "ball 3"),
            Shape::Spring(([rest - 0.5, 0.0], None), ([-0.03, 0.0], Some("carriage")), 0.04),
            Shape::Spring(([0.03, 0.0], Some("carriage")), ([-d / 2.0, 0.0], Some("ball 1")), 0.03),
            Shape::Polygon(rectangle("carriage", [0.0, 0.0], [0.06, 0.08]), Fill::Metal),
            ball("ball 1"),
            ball("ball 2"),
            ball("ball 3"),
        ],
        title: ["Newton's cradle", "Three balls under Moreau's impact law, the first held by a carriage on springs."],
        ..Drawing::default()
    }
}

fn build(p: &Cradle, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let (diameter, start) = (p.ball_diameter_m, p.start_position_m);
    if start > 0.0 {
        let expected = format!("at most 0 m, where ball 1 touches ball 2; it would start {start} m inside");
        return Err(Error::invalid("start_position_m", start, expected));
    }
    let ball = |index: usize| LineMass {
        mass: p.ball_mass_kg,
        stiffness: p.ball_mass_kg * p.pendulum_frequency_rad_s.powi(2),
        anchor: index as f64 * diameter,
        start: [if index == 0 { start } else { index as f64 * diameter }, 0.0],
        ..LineMass::default()
    };
    let contact = |below: usize| LineContact { below: Some(below), above: Some(below + 1), distance: diameter };
    let model = LineMasses::new(LineDescription {
        masses: (0..3).map(ball).collect(),
        contacts: vec![contact(0), contact(1)],
        state_names: words(
            "ball_1_x_m ball_2_x_m ball_3_x_m ball_1_velocity_m_s ball_2_velocity_m_s ball_3_velocity_m_s",
        ),
        contact_names: words("1_2 2_3"),
        ..LineDescription::default()
    })?;
    assembly.couple(model, SpringActuator::new(p.carriage)?, &p.contacts)
}

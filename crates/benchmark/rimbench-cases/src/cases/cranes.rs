//! The hydraulic crane with its load on a rope: `crane-set-down` and `crane-drag`. Three velocities (θ, load x, y); the
//! rope can pull and not push. Shown in `docs/cases/crane-set-down.md`.
//!
//! Geometry, masses and hydraulics of LIM cosim-benchmarks; rope, ground and manoeuvres are *ours*.

use super::prelude::*;

parameters! {
    /// The link, the rope and the load.
    struct Link from "LIM cosim-benchmarks" {
        link_1_length_m: f64 = 1.0, Positive, "length L of the link";
        rope_length_m: f64 = 0.5, Positive, "length of the rope";
        rod_mass_kg: f64 = 200.0, Positive, "mass m of the link, a uniform rod".study(100.0..400.0);
        joint_mass_kg: f64 = 250.0, NotNegative, "point mass m_p at the end of the link".study(100.0..400.0);
        load_mass_kg: f64 = 100.0, Positive, "mass m_h of the load".study(20.0..200.0);
        pin_x_m: f64 = 0.8660254037844386, Positive, "x of the actuator's fixed end B; its y is 0";
        theta_1_start_rad: f64 = 0.5235987755982989, Finite, "angle of the link at the start";
    }
}
parameters! {
    /// What lifts it.
    struct Jack from "LIM cosim-benchmarks" {
        cylinder: Cylinder with |set| set
            .from("LIM cosim-benchmarks").default("piston_area_m2", 65e-4).default("cylinder_length_m", 0.442)
            .default("viscous_friction_n_s_m", 1e5).default("valve_area_m2", 5e-4);
    }
}
parameters! {
    /// What cranes have besides.
    struct Rest from "LIM cosim-benchmarks" {
        gravity_m_s2: f64 = 9.81, Positive, "gravity";
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution"]).about("restitution", "restitution e of load and rope")
            .source("restitution", "ours");
        attachment_m: f64 = 0.5, Positive, "distance of the actuator's other end from the joint O";
    }
}
parameters! {
    /// The crane that sets its load down.
    struct SetDown from "ours" {
        link: Link;
        ground_height_m: f64 = -0.03, Finite, "height of the ground; the load starts at 0".gap();
        jack: Jack;
        spool_change: f64 = 0.01, Fraction, "spool away from equilibrium while lowering (+) and lifting (−)".study(0.005..0.05);
        lower_start_s: f64 = 0.2, NotNegative, "start of lowering";
        lower_end_s: f64 = 1.6, NotNegative, "end of lowering";
        lift_start_s: f64 = 2.0, NotNegative, "start of lifting";
        spool_ramp_s: f64 = 0.02, Positive, "time in which the spool moves";
        oil: Oil;
        rest: Rest;
    }
}
parameters! {
    /// The crane that drags its load.
    struct Drag from "ours" {
        link: Link;
        jack: Jack;
        spool_change: f64 = 0.01, Fraction, "spool away from equilibrium while lowering (+) and lifting (−)".study(0.005..0.05);
        spool_ramp_s: f64 = 0.02, Positive, "time in which the spool moves";
        oil: Oil;
        rest: Rest;
        load_offset_m: f64 = 0.2, Finite, "how far out from the end of the link the load lies at the start";
        lift_start_s: f64 = 0.2, NotNegative, "start of lifting";
        rough: Contacts with |set| set
            .only(&["friction", "tangential_restitution"]).default("friction", 0.3).within("friction", Positive);
    }
}
/// The crane as the parameters say.
fn geometry(link: &Link, rest: &Rest) -> CraneGeometry {
    CraneGeometry {
        link_1_length: link.link_1_length_m,
        link_2_length: link.rope_length_m,
        rod_mass: link.rod_mass_kg,
        joint_mass: link.joint_mass_kg,
        end_mass: link.load_mass_kg,
        pin_x: link.pin_x_m,
        attachment: rest.attachment_m,
        start_angles: [link.theta_1_start_rad, 0.0],
        gravity: rest.gravity_m_s2,
    }
}

/// A crane with its load on a rope over flat ground.
fn above_ground<P: ParameterSet>(
    name: &'static str,
    about: &'static str,
    build: fn(&P, &Assembly<'_>) -> Result<CoupledSystem>,
) -> Case {
    Case {
        trace_columns: hydraulics::trace_columns(
            "theta_1_rad load_x_m load_y_m",
            "gap_rope_m gap_ground_m contact_force_rope_n contact_force_ground_n closed_contacts",
        ),
        interface_columns: hydraulics::interface(),
        reference: reference(),
        ..Case::new(name, about, times(4.0, 5e-3, 5e-5, [5e-5, 1e-4]), build)
    }
}

/// What a crane with its load on a rope looks like.
fn drawing(link: &Link, rest: &Rest, barrel: f64, floor: f64, [title, about]: [&'static str; 2]) -> Drawing {
    let length = link.link_1_length_m;
    // Measured from the joint; the ground is `floor` below the load's start.
    let hook = [([length, 0.0], Some("link")), ([0.0, 0.0], Some("load"))];
    Drawing {
        view: [[-0.4, 1.45], [-0.28, 0.78]],
        frames: vec![frame("link", 0.0, 0.0, "theta_1_rad"), frame("load", "load_x_m", "load_y_m", 0.0)],
        shapes: vec![
            ground(&[[-5.0, floor - 0.08], [5.0, floor - 0.08]]),
            Shape::Cylinder {
                from: ([link.pin_x_m, 0.0], None),
                to: ([rest.attachment_m, 0.0], Some("link")),
                barrel: 0.8 * barrel,
                width: 0.07,
            },
            Shape::Polygon(rectangle("link", [length / 2.0, 0.0], [length, 0.06]), Fill::Metal),
            disc(([0.0, 0.0], None), 0.05, Fill::Metal),
            Shape::Line(hook.to_vec()),
            Shape::Polygon(rectangle("load", [0.0, 0.0], [0.24, 0.16]), Fill::Scheme),
            upward("contact_force_ground_n", ([0.0, -0.08], Some("load")), 2e-4),
        ],
        title: [title, about],
        force: "cylinder force",
        in_kilonewtons: true,
        ..Drawing::default()
    }
}

/// Lowers the load onto the ground, where rope and ground lock the link for a moment, and lifts it again with a jerk.
pub(super) fn set_down() -> Case {
    let about = "Hydraulic crane that sets a load on a rope on the ground, drags it and lifts it off";
    let drawing = drawn(|p: &SetDown| {
        let text =
            ["Crane sets a load down", "A hydraulic crane lowers its load onto the ground and lifts it with a jerk."];
        let drawing = drawing(&p.link, &p.rest, p.jack.cylinder.cylinder_length_m, p.ground_height_m, text);
        Some(Drawing { schemes: ["first-order-hold", "rim-nonsmooth"], ..drawing })
    });
    let case = above_ground("crane-set-down", about, |p: &SetDown, assembly| {
        let model = CraneWithRope::new(geometry(&p.link, &p.rest), p.ground_height_m)?;
        let (pressures, centre) = p.jack.cylinder.equilibrium(&p.oil, model.taut().equilibrium_force())?;
        let moves = [(named!(p.lower_start_s), 1.0), (named!(p.lower_end_s), 0.0), (named!(p.lift_start_s), -1.0)];
        let spool = hydraulics::moved_spool(centre, p.spool_change, p.spool_ramp_s, &moves)?;
        let cylinder = p.jack.cylinder.starting_at(model.taut().start_length(), &p.oil, pressures, spool)?;
        assembly.couple(model, cylinder, &p.rest.contacts)
    });
    Case { drawing, ..case }
}

/// Drags a load that lies aside over rough ground: it sticks until `T sin φ = μ (m_h g − T cos φ)`, slides and lifts
/// off.
pub(super) fn drag() -> Case {
    let about = "Hydraulic crane that drags a load over rough ground by its rope until it lifts off";
    let mut case = above_ground("crane-drag", about, |p: &Drag, assembly| {
        let model = CraneWithRope::with_load_on_ground(geometry(&p.link, &p.rest), p.load_offset_m)?;
        let (pressures, centre) = p.jack.cylinder.equilibrium(&p.oil, model.link_force())?;
        let moves = [(named!(p.lift_start_s), -1.0)];
        let spool = hydraulics::moved_spool(centre, p.spool_change, p.spool_ramp_s, &moves)?;
        let cylinder = p.jack.cylinder.starting_at(model.taut().start_length(), &p.oil, pressures, spool)?;
        assembly.couple(model, cylinder, &p.rest.contacts)
    });
    case.trace_columns.extend(words("friction_force_ground_n contact_state_ground"));
    case.drawing = drawn(|p: &Drag| {
        let text = ["Crane drags a load", "A hydraulic crane drags its load over rough ground until it lifts off."];
        let tip = p.link.link_1_length_m * libm::sin(p.link.theta_1_start_rad);
        let floor = tip - (p.link.rope_length_m.powi(2) - p.load_offset_m.powi(2)).sqrt();
        Some(drawing(&p.link, &p.rest, p.jack.cylinder.cylinder_length_m, floor, text))
    });
    case
}

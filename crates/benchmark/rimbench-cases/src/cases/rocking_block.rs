//! A block on two corners that a hydraulic cylinder holds: `rocking-block` without friction, `rocking-block-friction`
//! with corners that stick. Shown in `docs/cases/rocking-block.md`. Numbers *ours*; hydraulics of Naya et al. 2011.

use super::prelude::*;

parameters! {
    /// A block, where it starts and where it is held.
    struct Block from "ours" {
        block_mass_kg: f64 = 200.0, Positive, "mass m of the block";
        half_width_m: f64 = 0.2, Positive, "half width b";
        half_height_m: f64 = 0.5, Positive, "half height h (the inertia is that of a rectangle)";
        start_angle_rad: f64 = 0.05, NotNegative, "angle at the start, on the right corner";
        attachment_x_m: f64 = -0.2, Finite, "actuator's end on the block, block frame, x";
        attachment_y_m: f64 = 0.1, Finite, "actuator's end on the block, block frame, y";
        ground_pin_x_m: f64 = -2.0, Finite, "actuator's fixed end, x; its height is the attachment's";
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
    }
}

parameters! {
    /// The block without friction.
    struct Slippery from "ours" {
        block: Block;
        cylinder: Cylinder with |set| set.default("cylinder_length_m", 1.0).default("viscous_friction_n_s_m", 2e3);
        ramp: Ramp with |set| set.default("spool_final", 0.4);
        oil: Oil;
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution", "contact_compliance_m_n", "contact_damping_n_s_m"]);
    }
}
parameters! {
    /// The block with friction.
    struct Rough from "ours" {
        block: Block;
        cylinder: Cylinder with |set| set
            .default("piston_area_m2", 1e-4).source("piston_area_m2", "ours").default("cylinder_length_m", 1.0)
            .default("viscous_friction_n_s_m", 50.0).source("viscous_friction_n_s_m", "ours");
        ramp: Ramp with |set| set.default("spool_final", 0.5).source("spool_final", "ours");
        oil: Oil;
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution", "friction", "tangential_restitution"]).default("friction", 0.5)
            .within("friction", Positive);
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: hydraulics::trace_columns(
            "box_x_m box_y_m box_angle_rad box_rate_rad_s",
            "gap_right_support_m gap_left_support_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words("contact_force_right_support_n contact_force_left_support_n"),
        interface_columns: hydraulics::interface(),
        reference: reference(),
        drawing: drawn(|p: &Slippery| Some(drawing(&p.block, p.cylinder.cylinder_length_m))),
        ..Case::new(
            "rocking-block",
            "Block that rocks on two corners without friction, held by a hydraulic cylinder (closed-form impact law)",
            times(1.5, 2e-3, 5e-5, [2.5e-5, 1e-4]),
            build,
        )
    }
}

/// A corner that sticks leaves the block one way to go, which a strong cylinder would dictate: this one holds with
/// little. Level, the block keeps Housner's `ω⁺/ω⁻ = 1 − 1.5 sin²α`, α = atan(b/h).
pub(super) fn with_friction() -> Case {
    let mut case = Case {
        name: "rocking-block-friction".into(),
        about: "Block that rocks on two corners that stick or slide, held by a hydraulic cylinder (Housner's ratio)"
            .into(),
        parameters: Rough::declared(),
        ..entry()
    };
    case.trace_columns.extend(words("contact_state_right_support contact_state_left_support sticking_contacts"));
    case.drawing_columns.extend(words("friction_force_right_support_n friction_force_left_support_n"));
    let alike = case.drawing;
    case.drawing = Arc::new(move |parameters| {
        let drawing = alike(parameters)?;
        let title = ["Rocking block with friction", drawing.title[1]];
        Some(Drawing { title, ..drawing }.with(LIMITED_BY_ITS_STEP))
    });
    case
}

fn drawing(p: &Block, barrel: f64) -> Drawing {
    let [b, h] = [p.half_width_m, p.half_height_m];
    // The centre starts at x = 0, the right corner on the floor; the cylinder is level at the start.
    let (sin, cos) = (libm::sin(-p.start_angle_rad), libm::cos(p.start_angle_rad));
    let height = b.mul_add(-sin, h * cos) + sin * p.attachment_x_m + cos * p.attachment_y_m;
    Drawing {
        view: [[-1.5, 0.75], [-0.12, 1.12]],
        frames: vec![frame("block", "box_x_m", "box_y_m", "box_angle_rad")],
        shapes: vec![
            ground(&[[-5.0, 0.0], [5.0, 0.0]]),
            Shape::Cylinder {
                from: ([p.ground_pin_x_m, height], None),
                to: ([p.attachment_x_m, p.attachment_y_m], Some("block")),
                barrel,
                width: 0.1,
            },
            Shape::Polygon(rectangle("block", [0.0, 0.0], [2.0 * b, 2.0 * h]), Fill::Scheme),
            upward("contact_force_right_support_n", ([b, -h], Some("block")), 1e-4),
            upward("contact_force_left_support_n", ([-b, -h], Some("block")), 1e-4),
        ],
        title: ["Rocking block", "A block tips from one corner to the other while a hydraulic cylinder holds it."],
        force: "cylinder force",
        in_kilonewtons: true,
        contact: Some(["bounces", "stays down"]),
        ..Drawing::default()
    }
}

fn build(p: &Slippery, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let [mass, b, h] = [p.block.block_mass_kg, p.block.half_width_m, p.block.half_height_m];
    let (angle, overturns) = (p.block.start_angle_rad, libm::atan2(b, h));
    if angle >= overturns {
        let expected = format!("below atan(b/h) = {overturns:.6} rad, where the block falls over");
        return Err(Error::invalid("start_angle_rad", angle, expected));
    }
    let model = WedgeBox::new(WedgeBoxGeometry {
        box_mass: mass,
        box_size: [2.0 * b, 2.0 * h],
        wedges: vec![[b, -h], [-b, -h]],
        wedge_name: "support",
        start_angle: -angle,
        attachment: [p.block.attachment_x_m, p.block.attachment_y_m],
        ground_pin_x: p.block.ground_pin_x_m,
        gravity: p.block.gravity_m_s2,
        ..WedgeBoxGeometry::default()
    })?;
    let cylinder = p.cylinder.starting_at(model.start_length(), &p.oil, p.ramp.start_pressures(), p.ramp.spool()?)?;
    assembly.couple(model, cylinder, &p.contacts)
}

//! A block on two corners that a hydraulic cylinder holds: `rocking-block` without friction, `rocking-block-friction` with corners that stick.
//! Shown in `docs/cases/rocking-block.md`. Numbers *ours*; hydraulics of Naya et al. 2011.

use super::prelude::*;

const BLOCK: &str = "source: ours
    block_mass_kg | kg | 200.0 | positive | mass m of the block
    half_width_m | m | 0.2 | positive | half width b
    half_height_m | m | 0.5 | positive | half height h (the inertia is that of a rectangle)
    start_angle_rad | rad | 0.05 | not negative | angle at the start, on the right corner
    attachment_x_m | m | -0.2 | finite | actuator's end on the block, block frame, x
    attachment_y_m | m | 0.1 | finite | actuator's end on the block, block frame, y
    ground_pin_x_m | m | -2.0 | finite | actuator's fixed end, x; its height is the attachment's
    gravity_m_s2 | m/s² | 9.81 | not negative | gravity | standard
";
const HELD: &str = "
    cylinder_length_m = 1.0
    viscous_friction_n_s_m = 2e3
    spool_final = 0.4
";

pub(super) fn entry() -> Case {
    Case {
        parameters: table(&[BLOCK, CYLINDER, HELD, FLUID, STABILISATION, RESTITUTION, COMPLIANT]),
        trace_columns: hydraulics::trace_columns(
            "box_x_m box_y_m box_angle_rad box_rate_rad_s",
            "gap_right_support_m gap_left_support_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words("contact_force_right_support_n contact_force_left_support_n"),
        interface_columns: hydraulics::interface(),
        reference: reference(),
        ..Case::new(
            "rocking-block",
            "Block that rocks on two corners without friction, held by a hydraulic cylinder (closed-form impact law)",
            times(1.5, 2e-3, 5e-5, [2.5e-5, 1e-4]),
            build,
        )
    }
}

/// A corner that sticks leaves the block one way to go, which a strong cylinder would dictate: this one holds with little. Level, the block
/// keeps Housner's `ω⁺/ω⁻ = 1 − 1.5 sin²α`, α = atan(b/h).
pub(super) fn with_friction() -> Case {
    const WEAK: &str = "
        piston_area_m2 = 1e-4 | ours
        viscous_friction_n_s_m = 50.0 | ours
        spool_final = 0.5 | ours
        friction = 0.5
    ";
    let mut case = Case {
        name: "rocking-block-friction".into(),
        about: "Block that rocks on two corners that stick or slide, held by a hydraulic cylinder (Housner's ratio)"
            .into(),
        // Contacts that give way have no friction.
        parameters: table(&[BLOCK, CYLINDER, HELD, FLUID, STABILISATION, RESTITUTION, WITH_FRICTION, WEAK]),
        ..entry()
    };
    case.trace_columns.extend(words("contact_state_right_support contact_state_left_support sticking_contacts"));
    case.drawing_columns.extend(words("friction_force_right_support_n friction_force_left_support_n"));
    case
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let [mass, b, h] = ["block_mass_kg", "half_width_m", "half_height_m"].map(get);
    let (angle, overturns) = (get("start_angle_rad"), libm::atan2(b, h));
    if angle >= overturns {
        let expected = format!("below atan(b/h) = {overturns:.6} rad, where the block falls over");
        return Err(Error::invalid("start_angle_rad", angle, expected));
    }
    let model = SupportedBox::new(SupportedBoxGeometry {
        box_mass: mass,
        box_inertia: mass * (b * b + h * h) / 3.0,
        supports: vec![[b, -h], [-b, -h]],
        start_angle: -angle,
        attachment: ["attachment_x_m", "attachment_y_m"].map(get),
        ground_pin_x: get("ground_pin_x_m"),
        gravity: get("gravity_m_s2"),
        ..SupportedBoxGeometry::default()
    })?;
    let cylinder = hydraulics::ramped_cylinder(parameters, model.start_length())?;
    coupled(model, cylinder, parameters, solver)
}

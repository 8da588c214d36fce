//! `rocking-block`: a block falls from one lower corner onto the other, on a floor without friction, held by a hydraulic cylinder.
//!
//! ```text
//!                     ┌──────┐
//!   ╠════════[▒▒]═════●      │ 2h          F > 0 pushes to the right
//!   pin     cylinder  │  +   │
//!                     └──────┘
//!   ═════════════════════════════ floor y = 0          corners at (±b, −h) from the centre
//!                        2b
//! ```
//! Three velocities, two contacts. The block starts tilted on its right corner. When it is level both corners touch, and the law of
//! plastic impact without friction gives, I about the centre of mass,
//!
//! ```text
//! ω⁺/ω⁻ = (I − m b²)/(I + m b²)   if I > m b²: the right corner leaves        else the block stops
//! ```
//! (Housner's 1 − 1.5 sin²α belongs to corners that stick.) The cylinder's force is finite, so it takes no part in the impact.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4.
//!
//! **Source**: the impact law follows from two unilateral rows; e.g. Glocker 2001. Numbers *ours*; hydraulics Naya et al. 2011.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::cylinder;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{SupportedBox, SupportedBoxGeometry};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::{Error, Result};
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: cylinder::trace_columns(
            &["box_x_m", "box_y_m", "box_angle_rad", "box_rate_rad_s"],
            &["gap_right_support_m", "gap_left_support_m", "closed_contacts", "rank_h_uu"],
        ),
        drawing_columns: names(&["contact_force_right_support_n", "contact_force_left_support_n"]),
        interface_columns: vec![cylinder::interface()],
        reference: contact_parameters::reference(),
        ..Case::new(
            "rocking-block",
            "Block that rocks on two corners without friction, held by a hydraulic cylinder (closed-form impact law)",
            CaseDefaults {
                duration_s: 1.5,
                macro_step_s: 2e-3,
                micro_step_s: 5e-5,
                reference_step_s: 2.5e-5,
                reference_sampling_s: 1e-4,
            },
            build,
        )
    }
}

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    [own(), cylinder::parameters(1.0, 2e3, 0.4), contact_parameters::all(0.0, "plastic")].concat()
}

fn own() -> Vec<Parameter> {
    use Range::{Finite, NotNegative, Positive};
    vec![
        p("block_mass_kg", "kg", 200.0, Positive, "mass m of the block", OURS),
        p("half_width_m", "m", 0.2, Positive, "half width b", OURS),
        p("half_height_m", "m", 0.5, Positive, "half height h (the inertia is that of a rectangle)", OURS),
        p("start_angle_rad", "rad", 0.05, NotNegative, "angle at the start, on the right corner", OURS),
        p("attachment_x_m", "m", -0.2, Finite, "actuator's end on the block, block frame, x", OURS),
        p("attachment_y_m", "m", 0.1, Finite, "actuator's end on the block, block frame, y", OURS),
        p("ground_pin_x_m", "m", -2.0, Finite, "actuator's fixed end, x; its height is the attachment's", OURS),
        p("gravity_m_s2", "m/s²", 9.81, NotNegative, "gravity", "standard"),
    ]
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (mass, b, h) = (get("block_mass_kg"), get("half_width_m"), get("half_height_m"));
    let (angle, overturns) = (get("start_angle_rad"), libm::atan2(b, h));
    if angle >= overturns {
        let expected = format!("below atan(b/h) = {overturns:.6} rad, where the block falls over");
        return Err(Error::invalid("start_angle_rad", angle, expected));
    }
    let model = SupportedBox::new(SupportedBoxGeometry {
        box_mass: mass,
        box_inertia: mass * (b * b + h * h) / 3.0,
        supports: vec![[b, -h], [-b, -h]],
        discs: Vec::new(),
        washboard: [0.0, 1.0],
        washboard_lead: 0.0,
        start_angle: -angle,
        attachment: [get("attachment_x_m"), get("attachment_y_m")],
        ground_pin_x: get("ground_pin_x_m"),
        gravity: get("gravity_m_s2"),
    })?;
    cylinder::system(model, parameters, solver)
}

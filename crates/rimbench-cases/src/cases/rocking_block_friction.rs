//! `rocking-block-friction`: a block falls from one lower corner onto the other on a rough floor, held by a hydraulic cylinder.
//!
//! The block and the start of `rocking-block`, with friction at both corners and a cylinder weak enough to let it rock. When the block is level both corners touch, and
//! the law of plastic impact gives, with corners that stick,
//!
//! ```text
//! ω⁺/ω⁻ = r = 1 − 1.5 sin²α,  α = atan(b/h)        for μ ≥ (h/b) (1 − r)/(1 + r)
//! ```
//! Without friction the block loses far more: the corner that leaves slides away under it. With less than that coefficient it keeps something in
//! between.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4, semi-implicit.
//!
//! **Source**: Housner 1963; numbers *ours*; hydraulics Naya et al. 2011.

use super::case::Case;
use super::contact_parameters;
use super::parameters::Value;
use super::rocking_block;
use rimbench_core::name::names;

/// A corner that sticks leaves the block one way to go, which the cylinder of `rocking-block` would dictate. This one holds with little.
const WEAK: [(&str, f64); 3] = [("piston_area_m2", 1e-4), ("viscous_friction_n_s_m", 50.0), ("spool_final", 0.5)];

pub(super) fn entry() -> Case {
    let mut case = rocking_block::entry();
    case.name = "rocking-block-friction".into();
    case.about =
        "Block that rocks on two corners that stick or slide, held by a hydraulic cylinder (Housner's ratio)".into();
    // Contacts that give way have no friction.
    case.parameters.retain(|parameter| !parameter.name.starts_with("contact_"));
    case.parameters.extend(contact_parameters::friction(0.5));
    for (name, value) in WEAK {
        for parameter in case.parameters.iter_mut().filter(|parameter| parameter.name == name) {
            (parameter.default, parameter.source) = (Value::Number(value), "ours".into());
        }
    }
    case.trace_columns.extend(names(&[
        "contact_state_right_support",
        "contact_state_left_support",
        "sticking_contacts",
    ]));
    case.drawing_columns.extend(names(&["friction_force_right_support_n", "friction_force_left_support_n"]));
    case
}

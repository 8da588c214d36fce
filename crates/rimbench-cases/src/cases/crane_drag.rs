//! `crane-drag`: the hydraulic crane drags a load over rough ground by its rope until it lifts off.
//!
//! ```text
//!                    ___●  m_p  (end of the link, length L, rod of mass m)
//!               ___--P   ╲
//!          ___--    ╱     ╲  rope at an angle φ to the plumb line: can pull, not push
//!     O ●--θ      ╱ s      ╲
//!   ════╧════════●═══       ■  m_h
//!                B    ▔▔▔▔▔▔▔▔▔▔▔  ground  μ
//! ```
//! The machine of `crane-set-down`. Three velocities (θ, load x, y), two contacts: the rope (tension only) and the load on the ground. The rope has
//! no surface, and so no friction.
//!
//! **Manoeuvre.** The load lies aside of the end of the link, the rope straight and without tension. The spool lifts: tension grows with the load
//! sticking, rope and ground together lock the link, until
//!
//! ```text
//! T sin φ = μ (m_h g − T cos φ)        T = μ m_h g/(sin φ + μ cos φ)
//! ```
//! Then the load slides towards the crane, ever faster, and lifts off where `T cos φ = m_h g`.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4, semi-implicit.
//!
//! **Source**: geometry, masses and hydraulics of LIM cosim-benchmarks; rope, ground, friction and manoeuvre are *ours*.

use super::case::{Case, CoupledSystem};
use super::contact_parameters;
use super::crane_set_down;
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::CraneWithRope;
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;
use std::sync::Arc;

pub(super) fn entry() -> Case {
    let mut case = crane_set_down::entry();
    case.name = "crane-drag".into();
    case.about = "Hydraulic crane that drags a load over rough ground by its rope until it lifts off".into();
    case.parameters = parameters();
    case.build = Arc::new(build);
    case.trace_columns.extend(names(&["friction_force_ground_n", "contact_state_ground"]));
    case
}

/// What the manoeuvre of the set-down needs, and this one does not.
const NOT_HERE: [&str; 4] = ["ground_height_m", "lower_start_s", "lower_end_s", "lift_start_s"];

fn parameters() -> Vec<Parameter> {
    const OURS: &str = "ours";
    let aside = "how far out from the end of the link the load lies at the start";
    let own = [
        p("load_offset_m", "m", 0.2, Range::Finite, aside, OURS),
        p("lift_start_s", "s", 0.2, Range::NotNegative, "start of lifting", OURS),
    ];
    let known = crane_set_down::parameters().into_iter().filter(|known| !NOT_HERE.contains(&&*known.name));
    known.chain(own).chain(contact_parameters::friction(0.3)).collect()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let model = CraneWithRope::with_load_on_ground(crane_set_down::geometry(parameters), get("load_offset_m"))?;
    let (pressures, centre) = hydraulics::equilibrium(parameters, model.link_force())?;
    let (start, ramp) = (get("lift_start_s"), get("spool_ramp_s"));
    let spool = hydraulics::spool(&[
        ("lift_start_s", start, centre),
        ("lift_start_s", start + ramp, centre - get("spool_change")),
    ])?;
    let cylinder = hydraulics::cylinder(parameters, model.taut().start_length(), pressures, spool)?;
    contact_parameters::coupled(model, cylinder, parameters, solver)
}

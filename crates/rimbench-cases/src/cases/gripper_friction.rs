//! `gripper-friction`: two opposed cylinders hold a box in the air by friction, let it slip, and catch it again. Two interfaces.
//!
//! ```text
//!            │◄ jaw    ┌─────────┐    jaw ►│
//!  ╠══[▒▒]───┤◁  pads  │   box   │  pads  ▷├───[▒▒]══╣
//!  anchor    │◁   μ    │         │    μ   ◁│    anchor
//!                      └─────────┘
//!   ══════════════════════════════════════════════════  floor, below
//! ```
//! The machine of `gripper`, closed at the start, the floor out of reach. It holds for as long as
//!
//! ```text
//! F ≥ m g/(2 μ)        F the squeeze of either cylinder; else the box falls with g − 2 μ F/m
//! ```
//! **Manoeuvre.** The valves let the squeeze go from `squeeze_high_n` to `squeeze_low_n`, which is too little, and bring it back: the box slips
//! down between the pads and is caught. The jaws do not move: in the direction of the squeeze the interface is locked, and what changes is only what the
//! pads do along the box. Eight rows of pads that stick hold three freedoms of the box; which pad carries how much is anybody's guess, the sum is not.
//!
//! **Direct feedthrough** of the actuators, through their viscous friction. **Reference**: monolithic, h, h/2, h/4, semi-implicit.
//!
//! **Source**: *ours*; the fluid is that of Naya et al. 2011.

use super::case::{Case, CoupledSystem};
use super::contact_parameters;
use super::fluid;
use super::gripper;
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;
use std::sync::Arc;

pub(super) fn entry() -> Case {
    let mut case = gripper::entry();
    case.name = "gripper-friction".into();
    case.about =
        "Two opposed cylinders hold a box by friction, let it slip and catch it again (two interface rows)".into();
    case.parameters = parameters();
    case.defaults.duration_s = 0.8;
    case.constant_mechanics = false;
    case.build = Arc::new(build);
    case.trace_columns.extend(names(&[
        "contact_state_left_lower_pad",
        "contact_state_left_upper_pad",
        "contact_state_right_lower_pad",
        "contact_state_right_upper_pad",
        "sticking_contacts",
    ]));
    case.drawing_columns.extend(names(&[
        "friction_force_left_lower_pad_n",
        "friction_force_left_upper_pad_n",
        "friction_force_right_lower_pad_n",
        "friction_force_right_upper_pad_n",
    ]));
    case
}

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    use Range::{NotNegative, Positive};
    let own = [
        p("floor_drop_m", "m", 0.15, NotNegative, "height of the box above the floor at the start", OURS),
        p("squeeze_high_n", "N", 600.0, Positive, "squeeze F of both cylinders at the start and at the end", OURS),
        p("squeeze_low_n", "N", 400.0, Positive, "squeeze of both cylinders in between", OURS),
        p("release_start_s", "s", 0.1, NotNegative, "when the squeeze is let go", OURS),
        p("grip_start_s", "s", 0.3, NotNegative, "when it is brought back", OURS),
        p("spool_ramp_s", "s", 0.02, Positive, "time in which the spools move", OURS),
    ];
    [gripper::machine(), own.to_vec(), fluid::parameters(), gripper::law(), contact_parameters::friction(0.5).to_vec()]
        .concat()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (pressures, held) = hydraulics::equilibrium(parameters, get("squeeze_high_n"))?;
    let (_, loose) = hydraulics::equilibrium(parameters, get("squeeze_low_n"))?;
    let (release, grip, ramp) = (get("release_start_s"), get("grip_start_s"), get("spool_ramp_s"));
    let spool = || {
        hydraulics::spool(&[
            ("release_start_s", release, held),
            ("release_start_s", release + ramp, loose),
            ("grip_start_s", grip, loose),
            ("grip_start_s", grip + ramp, held),
        ])
    };
    gripper::system(parameters, solver, [0.0; 2], get("floor_drop_m"), pressures, spool)
}

//! `crane-set-down`: the hydraulic crane sets its load on the ground, drags it, and lifts it again.
//!
//! ```text
//!                    ___●  m_p  (end of the link, length L, rod of mass m)
//!               ___--P  ┆
//!          ___--    ╱   ┆  rope: can pull, not push
//!     O ●--θ      ╱ s   ┆
//!   ════╧════════●═══   ■  m_h
//!                B    ▔▔▔▔▔▔▔▔▔  ground
//! ```
//! Three velocities (θ, load x, y), two contacts: the rope (tension only) and the load on the ground. No friction, so the load
//! slides where the rope pulls it.
//!
//! **Manoeuvre.** At rest, the spool lowers the crane; the load touches the ground, the rope goes slack, the link sinks on
//! without it. The spool then lifts: the rope becomes taut with a jerk, drags the load along and lifts it off. For a moment at set-down and
//! at lift-off rope and ground are closed together, and a bilateral model of both locks the link: two contacts are enough.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4. Start forces and
//! pressures are the published ones of the hydraulic crane (8829 N), because the taut rope is its second link.
//!
//! **Source**: geometry, masses and hydraulics of LIM cosim-benchmarks; rope, ground and manoeuvre are *ours*.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::cylinder;
use super::fluid;
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{CraneGeometry, CraneWithRope};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: cylinder::trace_columns(
            &["theta_1_rad", "load_x_m", "load_y_m"],
            &["gap_rope_m", "gap_ground_m", "contact_force_rope_n", "contact_force_ground_n", "closed_contacts"],
        ),
        interface_columns: vec![cylinder::interface()],
        reference: contact_parameters::reference(),
        ..Case::new(
            "crane-set-down",
            "Hydraulic crane that sets a load on a rope on the ground, drags it and lifts it off",
            CaseDefaults {
                duration_s: 4.0,
                macro_step_s: 5e-3,
                micro_step_s: 5e-5,
                reference_step_s: 5e-5,
                reference_sampling_s: 1e-4,
            },
            build,
        )
    }
}

const LIM: &str = "LIM cosim-benchmarks";
const OURS: &str = "ours";

pub(super) fn parameters() -> Vec<Parameter> {
    use Range::{Finite, Fraction, NotNegative, Positive};
    [
        vec![
            p("link_1_length_m", "m", 1.0, Positive, "length L of the link", LIM),
            p("rope_length_m", "m", 0.5, Positive, "length of the rope", LIM),
            p("rod_mass_kg", "kg", 200.0, Positive, "mass m of the link, a uniform rod", LIM),
            p("joint_mass_kg", "kg", 250.0, NotNegative, "point mass m_p at the end of the link", LIM),
            p("load_mass_kg", "kg", 100.0, Positive, "mass m_h of the load", LIM),
            p("pin_x_m", "m", 0.866_025_403_784_438_6, Positive, "x of the actuator's fixed end B; its y is 0", LIM),
            p("theta_1_start_rad", "rad", std::f64::consts::FRAC_PI_6, Finite, "angle of the link at the start", LIM),
            p("ground_height_m", "m", -0.03, Finite, "height of the ground; the load starts at 0", OURS),
            p("piston_area_m2", "m²", 65e-4, Positive, "piston area A", LIM),
            p("cylinder_length_m", "m", 0.442, Positive, "length l of both chambers together", LIM),
            p("viscous_friction_n_s_m", "N·s/m", 1e5, NotNegative, "viscous friction c of the cylinder", LIM),
            p("valve_area_m2", "m²", 5e-4, Positive, "valve area a_v", LIM),
            p(
                "spool_change",
                "-",
                0.01,
                Fraction,
                "spool away from equilibrium while lowering (+) and lifting (−)",
                OURS,
            ),
            p("lower_start_s", "s", 0.2, NotNegative, "start of lowering", OURS),
            p("lower_end_s", "s", 1.6, NotNegative, "end of lowering", OURS),
            p("lift_start_s", "s", 2.0, NotNegative, "start of lifting", OURS),
            p("spool_ramp_s", "s", 0.02, Positive, "time in which the spool moves", OURS),
        ],
        fluid::parameters(),
        vec![
            p("gravity_m_s2", "m/s²", 9.81, Positive, "gravity", LIM),
            contact_parameters::stabilisation(),
            p("restitution", "-", 0.0, Fraction, "restitution e of load and rope", OURS),
            p("attachment_m", "m", 0.5, Positive, "distance of the actuator's other end from the joint O", LIM),
        ],
    ]
    .concat()
}

/// The crane as the parameters say.
pub(super) fn geometry(parameters: &Parameters) -> CraneGeometry {
    let get = |name: &str| parameters.number(name);
    CraneGeometry {
        link_1_length: get("link_1_length_m"),
        link_2_length: get("rope_length_m"),
        rod_mass: get("rod_mass_kg"),
        joint_mass: get("joint_mass_kg"),
        end_mass: get("load_mass_kg"),
        pin_x: get("pin_x_m"),
        attachment: get("attachment_m"),
        start_angles: [get("theta_1_start_rad"), 0.0],
        gravity: get("gravity_m_s2"),
    }
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let model = CraneWithRope::new(geometry(parameters), get("ground_height_m"))?;
    let (pressures, centre) = hydraulics::equilibrium(parameters, model.taut().equilibrium_force())?;
    let (change, ramp) = (get("spool_change"), get("spool_ramp_s"));
    let [lower, hold, lift] = ["lower_start_s", "lower_end_s", "lift_start_s"].map(|key| (key, get(key)));
    let spool = hydraulics::spool(&[
        (lower.0, lower.1, centre),
        (lower.0, lower.1 + ramp, centre + change),
        (hold.0, hold.1, centre + change),
        (hold.0, hold.1 + ramp, centre),
        (lift.0, lift.1, centre),
        (lift.0, lift.1 + ramp, centre - change),
    ])?;
    let cylinder = hydraulics::cylinder(parameters, model.taut().start_length(), pressures, spool)?;
    contact_parameters::coupled(model, cylinder, parameters, solver)
}

//! `wedge-box-reversal`: the wedge box held against the ramp on three contacts, until the spool is reversed and one of them opens.
//!
//! ```text
//!                      ┌───────────────┐ box
//!   ╠═══════[▒▒]───────┤● attachment   │            F < 0 pulls the disc against the ramp,
//!      ledge   ╭───╮   │       +       │            F > 0 pushes the box away from it
//!   ────╲      │ o─┼───┤               │
//!         ╲ ───╰───╯   └──╲╱───────╲╱──┘
//!   ════════╲══════════════════════════════════════ floor y = 0
//! ```
//! In the wedge box three contacts with normals that are not parallel meet for an instant only: after touch-down the disc is in the air.
//! There a choice of contacts once per macro step and complementarity within it can hardly differ. Here the three *last*: both wedges on the floor,
//! the disc against the ramp, all pressed, the interface truly locked. Then the spool goes through the manoeuvre of the wedge box, the force
//! passes through zero, the disc leaves the ramp between two communication points, and the box slides away.
//!
//! ```text
//! hold     −F₀ pulls:   N_disc = F₀/n_x,   N_left = [g (m_b x_t + m_d (x_t − x_p)) + N_disc ((x_p − x_t) n_y − (y_p − y_t) n_x) + (y_a − y_t) F₀] / 2 x_t
//! opens    when F = 0, since the box then still stands
//! ```
//! The start pressures and the spool of the hold are those at which the cylinder pulls with F₀ at rest.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4. While it is held
//! nothing moves, and the moment of opening is that at which the pressures alone, an equation in them only, let the force vanish.
//!
//! Geometry, masses, cylinder and valve are those of the wedge box; what is new is *ours*.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use super::wedge_box;
use crate::models::WedgeBox;
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;

pub(super) fn entry() -> Case {
    wedge_box::recorded(Case {
        parameters: parameters(),
        reference: contact_parameters::reference(),
        ..Case::new(
            "wedge-box-reversal",
            "Wedge box held against its ramp on three contacts, until the spool is reversed and one opens",
            CaseDefaults {
                duration_s: 1.0,
                macro_step_s: 5e-3,
                micro_step_s: 5e-5,
                reference_step_s: 2.5e-5,
                reference_sampling_s: 5e-5,
            },
            build,
        )
    })
}

const OURS: &str = "ours";

/// What start and manoeuvre of the wedge box need, and this case does not.
const NOT_HERE: [&str; 5] =
    ["ledge_lead_m", "spool_start", "spool_ramp_start_s", "spool_ramp_end_s", "start_pressure_pa"];

fn parameters() -> Vec<Parameter> {
    use Range::{NotNegative, Positive};
    let own = [
        p("holding_pull_n", "N", 90.0, Positive, "force with which the cylinder pulls at first", OURS),
        p("reversal_start_s", "s", 0.3, NotNegative, "start of the spool's ramp to its final command", OURS),
        p("reversal_end_s", "s", 0.4, NotNegative, "end of the spool's ramp", OURS),
    ];
    wedge_box::parameters().into_iter().filter(|known| !NOT_HERE.contains(&&*known.name)).chain(own).collect()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let model = WedgeBox::against_ramp(wedge_box::geometry(parameters, 0.0))?;
    let (pressures, hold) = hydraulics::equilibrium(parameters, -get("holding_pull_n"))?;
    let spool = hydraulics::spool(&[
        ("reversal_start_s", get("reversal_start_s"), hold),
        ("reversal_end_s", get("reversal_end_s"), get("spool_final")),
    ])?;
    let cylinder = hydraulics::of_any_stroke(parameters, model.start_length(), pressures, spool);
    contact_parameters::coupled(model, cylinder, parameters, solver)
}

//! `disc-row`: a loader pushes a row of discs together and against a wall.
//!
//! ```text
//!  ╠════[▒▒]════┤ ( ) ( ) ( ) ( )   … ( )  │
//!  anchor    blade │   gap between discs   │ wall
//!   ════════════════════════════════════════  floor
//! ```
//! 1 + 2n velocities (blade; x and y of n discs: without friction they do not spin), 2n + 1 contacts that matter (blade–first disc,
//! neighbours, last disc–wall, each disc on the floor), of which the interface touches one. No friction.
//!
//! **Manoeuvre.** The blade closes the gaps one after the other, each with an impact, and moves a mass that grows disc by disc;
//! at the wall the whole chain is locked and the cylinder stalls.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4. With the cylinder
//! taken away the row has a closed form: momentum is conserved, `v = M v₀/(M + k m)` after k impacts (`tests/contact_machines.rs`).
//!
//! **Source**: *ours*; the fluid is that of Naya et al. 2011.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::cylinder;
use super::loader;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::ContactList;
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: loader::trace_columns(),
        drawing_columns: names(&loader::DRAWING_COLUMNS),
        interface_columns: vec![cylinder::interface()],
        constant_mechanics: true,
        // Each disc on the floor, and between blade, discs and wall.
        reference: contact_parameters::reference_of(|parameters| 2 * parameters.number("discs") as usize + 1),
        ..Case::new(
            "disc-row",
            "A loader's blade pushes a row of discs together and against a wall (a contact chain)",
            CaseDefaults {
                duration_s: 1.0,
                macro_step_s: 5e-3,
                micro_step_s: 5e-5,
                reference_step_s: 1e-4,
                reference_sampling_s: 2e-4,
            },
            build,
        )
    }
}

fn parameters() -> Vec<Parameter> {
    [
        vec![
            p("discs", "-", 10.0, Range::Whole(2, 2500), "number of discs", "ours"),
            p("disc_gap_m", "m", 5e-3, Range::Finite, "gap between blade, discs and next discs at the start", "ours"),
        ],
        loader::parameters(),
    ]
    .concat()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let discs = parameters.whole("discs");
    let (radius, gap) = (parameters.number("disc_radius_m"), parameters.number("disc_gap_m"));
    let place = |disc: u32| [f64::from(disc) * (2.0 * radius + gap) + gap + radius, radius];
    loader::build(parameters, solver, (0..discs).map(place).collect(), ContactList::Neighbours)
}

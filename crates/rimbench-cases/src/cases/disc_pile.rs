//! `disc-pile`: a loader pushes a heap of discs against a wall: many contacts, of which the interface touches a few.
//!
//! ```text
//!  ╠════[▒▒]════┤( )( )( )( )  │
//!  anchor       │ ( )( )( )    │
//!          blade│( )( )( )( )  │ wall
//!   ═══════════════════════════  floor
//! ```
//! 1 + 2n velocities (blade; x and y of n discs: without friction they do not spin). Layers are hexagonal, with one disc less in each
//! second one; some 3n contacts: many more than a frictionless heap can carry (2n), so its forces are not unique. The number of
//! contacts follows from `columns` and `layers`: 6 × 4 has 62, 10 × 8 has 220, 46 × 38 5 000.
//!
//! **Manoeuvre.** The heap is stacked against the blade, with some room before the wall. Let go, it settles: the upper discs push the
//! lower ones apart until the wall holds them; then the blade pushes all of it.
//!
//! **Contacts**: a list made once, at the start; a run in which discs move farther than it holds for ends (`out-of-range`). With
//! `contact_list = travelling` it is made anew as they do (see [`Discs`](crate::models::Discs)).
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4; with this many impacts its own
//! uncertainty is not small and must be looked at.
//!
//! **Source**: *ours*; the fluid is that of Naya et al. 2011.

use super::case::{Case, CaseDefaults, CoupledSystem};
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
        ..Case::new(
            "disc-pile",
            "A loader's blade pushes a heap of discs against a wall (62 contacts; thousands by its parameters)",
            CaseDefaults {
                duration_s: 0.5,
                macro_step_s: 5e-3,
                micro_step_s: 5e-5,
                reference_step_s: 1e-4,
                reference_sampling_s: 2e-4,
            },
            build,
        )
    }
}

/// A list of contacts that is made anew as discs travel.
const TRAVELLING: &str = "travelling";

fn parameters() -> Vec<Parameter> {
    [
        vec![
            p("columns", "-", 6.0, Range::Whole(2, 60), "discs in the lowest layer", "ours"),
            p("layers", "-", 4.0, Range::Whole(1, 60), "layers", "ours"),
            Parameter::choice(
                "contact_list",
                ["start", TRAVELLING],
                "possible contacts: those near at the start (a run in which discs move farther ends), or near at the time",
                "ours",
            ),
        ],
        loader::parameters(),
    ]
    .concat()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let columns = parameters.whole("columns");
    let layers = parameters.whole("layers");
    let radius = parameters.number("disc_radius_m");
    let mut centres = Vec::new();
    for layer in 0..layers {
        // Each second layer lies in the hollows of the one below.
        let shift = layer % 2;
        for column in 0..columns - shift {
            let x = radius * f64::from(1 + shift + 2 * column);
            centres.push([x, radius * (1.0 + 3.0_f64.sqrt() * f64::from(layer))]);
        }
    }
    let list = match parameters.choice("contact_list") {
        TRAVELLING => ContactList::Travelling,
        _ => ContactList::Start,
    };
    loader::build(parameters, solver, centres, list)
}

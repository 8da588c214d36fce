//! `crane-heap`: the hydraulic crane pulls its load out from under a heap of discs.
//!
//! ```text
//!                    ___●  end of the link
//!               ___--P  ┆
//!          ___--    ╱   ┆ rope: can pull, not push; in front of the discs
//!     O ●--θ      ╱ s  │┆  │
//!   ════╧════════●═══  │()( )│
//!                B     │( )(■)( )│  load ■ on the floor of a pit
//! ```
//! 3 + 2n velocities (θ; x and y of the load and of n discs). The load is a disc as large as the others, in the middle of the lowest layer
//! of a hexagonal heap between two walls. No friction.
//!
//! **Manoeuvre.** The rope hangs loose and the heap settles; the spool lifts, the rope becomes taut with a jerk, and the load is pulled up
//! through the heap, whose discs move aside and fall in behind it.
//!
//! **Contacts.** Discs travel and meet others: what is nearer than `list_reach_radii` is listed, and anew as they travel (see
//! [`CraneInHeap`]).
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4; with this many impacts its own
//! uncertainty must be looked at. With one column, in a shaft, there are closed forms: who is jerked moves as
//! `J θ̇⁻ = (J + (L cos θ)² (m_h + k m)) θ̇⁺`, and the rope carries `(m_h + k m) g`.
//!
//! **Source**: geometry and hydraulics of LIM cosim-benchmarks; load, heap and manoeuvre are *ours*.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::crane_set_down;
use super::cylinder;
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, Value, number as p};
use crate::models::{CraneInHeap, HeapGeometry};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::{Error, Result};

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: cylinder::trace_columns(
            &["theta_1_rad", "load_x_m", "load_y_m", "heap_height_m"],
            &[
                "gap_rope_m",
                "gap_floor_m",
                "gap_lowest_m",
                "contact_force_rope_n",
                "contact_force_floor_n",
                "closed_contacts",
                "contact_force_sum_n",
                "largest_displacement_m",
            ],
        ),
        interface_columns: vec![cylinder::interface()],
        ..Case::new(
            "crane-heap",
            "Hydraulic crane that pulls its load out from under a heap of discs (room for 29 contacts; thousands by its parameters)",
            CaseDefaults {
                duration_s: 1.2,
                macro_step_s: 5e-3,
                micro_step_s: 5e-5,
                reference_step_s: 1e-4,
                reference_sampling_s: 2e-4,
            },
            build,
        )
    }
}

const OURS: &str = "ours";

/// What the crane that sets its load down has and this one has not.
const ELSEWHERE: [&str; 4] = ["ground_height_m", "lower_start_s", "lower_end_s", "spool_ramp_s"];

fn parameters() -> Vec<Parameter> {
    use Range::{NotNegative, Positive, Whole};
    let of_crane = crane_set_down::parameters().into_iter().filter(|parameter| !ELSEWHERE.contains(&&*parameter.name));
    // A load of the heap's own kind, and a manoeuvre of this case.
    let with_own_defaults = of_crane.map(|parameter| {
        let own = match &*parameter.name {
            "load_mass_kg" => 20.0,
            "spool_change" => 0.04,
            "lift_start_s" => 0.2,
            _ => return parameter,
        };
        let about = if parameter.name == "spool_change" {
            "spool away from equilibrium while lifting".into()
        } else {
            parameter.about
        };
        Parameter { default: Value::Number(own), about, source: OURS.into(), ..parameter }
    });
    [
        vec![
            p("columns", "-", 3.0, Whole(1, 61), "discs in the lowest layer, the load among them; an odd number", OURS),
            p("layers", "-", 3.0, Whole(1, 60), "layers", OURS),
            p("disc_radius_m", "m", 0.03, Positive, "radius R of the discs and the load", OURS),
            p("disc_mass_kg", "kg", 4.0, Positive, "mass of each disc", OURS),
            p("wall_gap_m", "m", 3e-3, NotNegative, "distance of either wall from the lowest layer at the start", OURS),
            p("rope_slack_m", "m", 5e-3, NotNegative, "length of the rope that hangs loose at the start", OURS),
            p(
                "list_reach_radii",
                "-",
                0.8,
                Positive,
                "gap up to which contacts are listed, in radii; at most 0.8",
                OURS,
            ),
            p("lift_end_s", "s", 0.9, NotNegative, "end of lifting", OURS),
            p("spool_ramp_s", "s", 0.02, Positive, "time in which the spool moves", OURS),
        ],
        with_own_defaults.collect(),
    ]
    .concat()
}

/// Centres of the discs of a heap as seen from the load: hexagonal, one less in each second layer; in a single column one on the other.
fn heap(columns: u32, layers: u32, radius: f64) -> Vec<[f64; 2]> {
    let middle = f64::from(columns - 1);
    let mut centres = Vec::new();
    for layer in 0..layers {
        let shift = if columns == 1 { 0 } else { layer % 2 };
        let height = f64::from(layer) * if columns == 1 { 2.0 } else { 3.0_f64.sqrt() };
        for column in 0..columns - shift {
            let aside = f64::from(shift + 2 * column) - middle;
            if layer > 0 || aside != 0.0 {
                centres.push([radius * aside, radius * height]);
            }
        }
    }
    centres
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (columns, layers) = (parameters.whole("columns"), parameters.whole("layers"));
    if columns.is_multiple_of(2) {
        return Err(Error::invalid("columns", columns, "an odd number, so that the load lies in the middle"));
    }
    let radius = get("disc_radius_m");
    let model = CraneInHeap::new(
        crane_set_down::geometry(parameters),
        HeapGeometry {
            radius,
            disc_mass: get("disc_mass_kg"),
            centres: heap(columns, layers, radius),
            half_width: radius * f64::from(columns) + get("wall_gap_m"),
            slack: get("rope_slack_m"),
            list_reach_radii: get("list_reach_radii"),
        },
    )?;
    let (pressures, centre) = hydraulics::equilibrium(parameters, model.crane().link_force())?;
    let (change, ramp) = (get("spool_change"), get("spool_ramp_s"));
    let [lift, hold] = ["lift_start_s", "lift_end_s"].map(|key| (key, get(key)));
    let spool = hydraulics::spool(&[
        (lift.0, lift.1, centre),
        (lift.0, lift.1 + ramp, centre - change),
        (hold.0, hold.1, centre - change),
        (hold.0, hold.1 + ramp, centre),
    ])?;
    let cylinder = hydraulics::cylinder(parameters, model.crane().taut().start_length(), pressures, spool)?;
    contact_parameters::coupled(model, cylinder, parameters, solver)
}

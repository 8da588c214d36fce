//! `wedge-box`: the example of the source paper. A hydraulic cylinder pushes a box on two wedges, with a disc behind it.
//!
//! ```text
//!                      ┌───────────────┐ box
//!   ╠═══════[▒▒]───────┤● attachment   │            F > 0 pushes to the right
//!   pin    cylinder    │       +       │
//!              ╭───╮   │    centre     │
//!              │ o─┼───┤               │
//!   ledge ─────╰───╯─● └──╲╱───────╲╱──┘
//!                      ╲  left     right wedge
//!   ═════════════════════╲════════════════════════  floor y = 0
//! ```
//! Six velocities (box and disc, planar), two joint rows: four degrees of freedom, of which the disc's spin is free. Four
//! contacts: right wedge–floor, left wedge–floor, disc–ledge (plane, vertex, or ramp), disc–floor. No
//! friction unless one is set.
//!
//! **Manoeuvre.** The box starts tilted on its right wedge, the disc on the ledge. Pushed forward, the disc rolls over the
//! corner and down the ramp, the box turns until the left wedge touches. At that instant three contacts with normals that
//! are not parallel hold a box with three degrees of freedom: locked, if contacts are taken as bilateral. In truth the disc
//! leaves the ramp and the box slides on.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4. Trusted as
//! far as its own uncertainty says; no published numbers exist, because the paper prints no parameters.
//!
//! The parameters are *ours*; the hydraulic constants are those of Naya et al. 2011. `rimbench list parameters --case
//! wedge-box` prints them with unit, default and source.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::cylinder;
use super::fluid::{self, NAYA};
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{WedgeBox, WedgeBoxGeometry};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;

/// Times of a manoeuvre of this box.
pub(super) const DEFAULTS: CaseDefaults = CaseDefaults {
    duration_s: 2.5,
    macro_step_s: 5e-3,
    micro_step_s: 5e-5,
    reference_step_s: 2.5e-5,
    reference_sampling_s: 5e-5,
};

pub(super) fn entry() -> Case {
    recorded(Case {
        parameters: parameters(),
        reference: contact_parameters::reference(),
        ..Case::new(
            "wedge-box",
            "Box on two wedges with a disc on a ledge, pushed by a hydraulic cylinder (the source paper's example)",
            DEFAULTS,
            build,
        )
    })
}

/// The case with what is recorded of this box.
pub(super) fn recorded(case: Case) -> Case {
    Case {
        trace_columns: cylinder::trace_columns(
            &["box_x_m", "box_y_m", "box_angle_rad"],
            &[
                "gap_right_wedge_m",
                "gap_left_wedge_m",
                "gap_disc_ledge_m",
                "gap_disc_floor_m",
                "closed_contacts",
                "rank_h_uu",
            ],
        ),
        drawing_columns: names(&[
            "disc_ledge_normal_rad",
            "contact_force_right_wedge_n",
            "contact_force_left_wedge_n",
            "contact_force_disc_ledge_n",
            "contact_force_disc_floor_n",
        ]),
        interface_columns: vec![cylinder::interface()],
        ..case
    }
}

const OURS: &str = "ours";

pub(super) fn parameters() -> Vec<Parameter> {
    use Range::{Finite, Fraction, NotNegative, Positive};
    [
        vec![
            p("box_mass_kg", "kg", 200.0, Positive, "mass of the box", OURS),
            p("box_width_m", "m", 1.0, Positive, "width of the box (its inertia is that of a rectangle)", OURS),
            p("box_height_m", "m", 0.6, Positive, "height of the box", OURS),
            p("disc_mass_kg", "kg", 50.0, Positive, "mass of the disc", OURS),
            p("disc_radius_m", "m", 0.2, Positive, "radius of the disc", OURS),
            p("disc_pin_x_m", "m", -0.8, Finite, "joint of the disc in the box frame, x", OURS),
            p("disc_pin_y_m", "m", -0.19, Finite, "joint of the disc in the box frame, y", OURS),
            p(
                "wedge_tip_x_m",
                "m",
                0.4,
                Positive,
                "right wedge tip in the box frame, x (the left one is mirrored)",
                OURS,
            ),
            p("wedge_tip_y_m", "m", -0.4, Finite, "wedge tips in the box frame, y", OURS),
            p("ledge_height_m", "m", 0.06, NotNegative, "height of the ledge above the floor", OURS),
            p(
                "ledge_lead_m",
                "m",
                0.1,
                NotNegative,
                "distance of the ledge's corner ahead of the disc's centre at the start",
                OURS,
            ),
            p("ramp_slope", "-", 0.15, NotNegative, "fall over run of the ramp", OURS),
            p("attachment_x_m", "m", -0.5, Finite, "actuator's end on the box, box frame, x", OURS),
            p("attachment_y_m", "m", 0.3, Finite, "actuator's end on the box, box frame, y", OURS),
            p(
                "ground_pin_x_m",
                "m",
                -3.0,
                Finite,
                "actuator's fixed end, x; its height is the attachment's at the start",
                OURS,
            ),
            p("piston_area_m2", "m²", 0.0065, Positive, "piston area A", NAYA),
            p("cylinder_length_m", "m", 2.0, Positive, "length l of both chambers together", OURS),
            p("viscous_friction_n_s_m", "N·s/m", 1e4, NotNegative, "viscous friction c of the cylinder", OURS),
            p("valve_area_m2", "m²", 5e-5, Positive, "valve area a_v", OURS),
            p("spool_start", "-", 0.5, Fraction, "spool command at the start", OURS),
            p("spool_final", "-", 0.2, Fraction, "spool command after its ramp; below 0.5 extends", OURS),
            p("spool_ramp_start_s", "s", 0.1, NotNegative, "start of the spool's ramp", OURS),
            p("spool_ramp_end_s", "s", 0.2, NotNegative, "end of the spool's ramp", OURS),
            p("start_pressure_pa", "Pa", 3.85e6, Positive, "pressure in both chambers at the start", OURS),
        ],
        fluid::parameters(),
        vec![
            p("gravity_m_s2", "m/s²", 9.81, NotNegative, "gravity", "standard"),
            contact_parameters::stabilisation(),
            contact_parameters::restitution(0.0, "plastic, as in the paper"),
        ],
        contact_parameters::compliance().to_vec(),
        contact_parameters::friction(0.0).to_vec(),
    ]
    .concat()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let model = WedgeBox::new(wedge_box_geometry(parameters))?;
    let (spool, pressures) = (cylinder::ramp(parameters)?, [parameters.number("start_pressure_pa"); 2]);
    let cylinder = hydraulics::of_any_stroke(parameters, model.start_length(), pressures, spool);
    contact_parameters::coupled(model, cylinder, parameters, solver)
}

/// Returns the geometry of the wedge box as the parameters say, which must be those of the case `wedge-box`.
pub fn wedge_box_geometry(parameters: &Parameters) -> WedgeBoxGeometry {
    geometry(parameters, parameters.number("ledge_lead_m"))
}

/// The geometry as the parameters say, with the corner of the ledge so far ahead of the disc (m).
pub(super) fn geometry(parameters: &Parameters, ledge_lead: f64) -> WedgeBoxGeometry {
    let get = |name: &str| parameters.number(name);
    WedgeBoxGeometry {
        box_mass: get("box_mass_kg"),
        box_size: [get("box_width_m"), get("box_height_m")],
        wedge_tip: [get("wedge_tip_x_m"), get("wedge_tip_y_m")],
        disc_mass: get("disc_mass_kg"),
        disc_radius: get("disc_radius_m"),
        disc_pin: [get("disc_pin_x_m"), get("disc_pin_y_m")],
        ledge_height: get("ledge_height_m"),
        ledge_lead,
        ramp_slope: get("ramp_slope"),
        attachment: [get("attachment_x_m"), get("attachment_y_m")],
        ground_pin_x: get("ground_pin_x_m"),
        gravity: get("gravity_m_s2"),
    }
}

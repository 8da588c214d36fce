//! `wedge-box-two-ledges`: the wedge box with a disc on either side, each on a ledge of its own. Two descents, two touch-downs.
//!
//! ```text
//!                      ┌───────────────┐ box
//!   ╠═══════[▒▒]───────┤● attachment   │
//!              ╭───╮   │       +       │   ╭───╮
//!              │ o─┼───┤               ├───┼─o │
//!   ledge ─────╰───╯─● └──╲╱───────╲╱──┘───╰───╯──● ledge
//!   ═════════════════════╲════════════════════════════╲═══ floor y = 0
//! ```
//! Nine velocities, four joint rows, six contacts. The box starts on both discs, its wedges in the air. The left disc reaches the end of its
//! ledge first; the box tilts back while one disc descends and the other is still up, then the right one follows, and the
//! wedges touch while a disc is still on its ramp. The discs roll on tracks of their own.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4.
//!
//! Parameters *ours*; hydraulic constants of Naya et al. 2011.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::cylinder;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{LedgeDisc, SupportedBox, SupportedBoxGeometry};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::{Error, Result};
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: cylinder::trace_columns(
            &["box_x_m", "box_y_m", "box_angle_rad"],
            &[
                "gap_right_support_m",
                "gap_left_support_m",
                "gap_left_disc_ledge_m",
                "gap_left_disc_floor_m",
                "gap_right_disc_ledge_m",
                "gap_right_disc_floor_m",
                "closed_contacts",
                "rank_h_uu",
            ],
        ),
        drawing_columns: names(&["contact_force_right_support_n", "contact_force_left_support_n"]),
        interface_columns: vec![cylinder::interface()],
        reference: contact_parameters::reference(),
        ..Case::new(
            "wedge-box-two-ledges",
            "Wedge box with a disc on a ledge at either side (two descents, repeated over-constraint)",
            CaseDefaults {
                duration_s: 3.0,
                macro_step_s: 5e-3,
                micro_step_s: 5e-5,
                reference_step_s: 1e-4,
                reference_sampling_s: 1e-4,
            },
            build,
        )
    }
}

const OURS: &str = "ours";
const WEDGE_BOX: &str = "as in the wedge box";

fn parameters() -> Vec<Parameter> {
    [own(), cylinder::parameters(2.0, 1e4, 0.2), contact_parameters::all(0.0, "plastic, as in the paper")].concat()
}

fn own() -> Vec<Parameter> {
    use Range::{Finite, NotNegative, Positive};
    vec![
        p("box_mass_kg", "kg", 200.0, Positive, "mass of the box", WEDGE_BOX),
        p("box_width_m", "m", 1.0, Positive, "width of the box (its inertia is that of a rectangle)", WEDGE_BOX),
        p("box_height_m", "m", 0.6, Positive, "height of the box", WEDGE_BOX),
        p(
            "wedge_tip_x_m",
            "m",
            0.4,
            Positive,
            "right wedge tip in the box frame, x (the left one is mirrored)",
            WEDGE_BOX,
        ),
        p("wedge_tip_y_m", "m", -0.4, Finite, "wedge tips in the box frame, y", WEDGE_BOX),
        p("disc_mass_kg", "kg", 50.0, Positive, "mass of each disc", WEDGE_BOX),
        p("disc_radius_m", "m", 0.2, Positive, "radius of each disc", WEDGE_BOX),
        p(
            "disc_pin_x_m",
            "m",
            0.8,
            Positive,
            "joint of the right disc in the box frame, x (the left one is mirrored)",
            OURS,
        ),
        p("disc_pin_y_m", "m", -0.19, Finite, "joints of the discs in the box frame, y", WEDGE_BOX),
        p("left_ledge_height_m", "m", 0.06, NotNegative, "height of the left disc's ledge above the floor", WEDGE_BOX),
        p("right_ledge_height_m", "m", 0.06, NotNegative, "height of the right disc's ledge above the floor", OURS),
        p(
            "left_ledge_lead_m",
            "m",
            0.1,
            NotNegative,
            "distance of the left ledge's corner ahead of its disc",
            WEDGE_BOX,
        ),
        p("right_ledge_lead_m", "m", 0.2, NotNegative, "distance of the right ledge's corner ahead of its disc", OURS),
        p("ramp_slope", "-", 0.15, NotNegative, "fall over run of both ramps", WEDGE_BOX),
        p("attachment_x_m", "m", -0.5, Finite, "actuator's end on the box, box frame, x", WEDGE_BOX),
        p("attachment_y_m", "m", 0.3, Finite, "actuator's end on the box, box frame, y", WEDGE_BOX),
        p("ground_pin_x_m", "m", -3.0, Finite, "actuator's fixed end, x; its height is the attachment's", WEDGE_BOX),
        p("gravity_m_s2", "m/s²", 9.81, NotNegative, "gravity", "standard"),
    ]
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (width, height) = (get("box_width_m"), get("box_height_m"));
    let (x, y) = (get("wedge_tip_x_m"), get("wedge_tip_y_m"));
    if get("disc_pin_x_m") < get("disc_radius_m") {
        let expected = format!("at least the radius {} m, or the discs would overlap", get("disc_radius_m"));
        return Err(Error::invalid("disc_pin_x_m", get("disc_pin_x_m"), expected));
    }
    let disc = |side: f64, ledge_height: &str, ledge_lead: &str| LedgeDisc {
        mass: get("disc_mass_kg"),
        radius: get("disc_radius_m"),
        pin: [side * get("disc_pin_x_m"), get("disc_pin_y_m")],
        ledge_height: get(ledge_height),
        ledge_lead: get(ledge_lead),
        ramp_slope: get("ramp_slope"),
    };
    let model = SupportedBox::new(SupportedBoxGeometry {
        box_mass: get("box_mass_kg"),
        box_inertia: get("box_mass_kg") * (width * width + height * height) / 12.0,
        supports: vec![[x, y], [-x, y]],
        discs: vec![
            disc(-1.0, "left_ledge_height_m", "left_ledge_lead_m"),
            disc(1.0, "right_ledge_height_m", "right_ledge_lead_m"),
        ],
        washboard: [0.0, 1.0],
        washboard_lead: 0.0,
        start_angle: 0.0,
        attachment: [get("attachment_x_m"), get("attachment_y_m")],
        ground_pin_x: get("ground_pin_x_m"),
        gravity: get("gravity_m_s2"),
    })?;
    cylinder::system(model, parameters, solver)
}

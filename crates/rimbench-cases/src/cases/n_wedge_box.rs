//! `n-wedge-box`: the wedge box on 2 to 64 wedges in one plane, on a flat or a wavy floor. Redundant contacts by the dozen.
//!
//! ```text
//!                      ┌───────────────┐ box
//!   ╠═══════[▒▒]───────┤● attachment   │
//!              ╭───╮   │       +       │           n wedges from x = −0.4 to 0.4 m, tips in one plane,
//!              │ o─┼───┤               │           or off it by up to `height_spread_m`
//!   ledge ─────╰───╯─● └╲╱╲╱╲╱╲╱╲╱╲╱╲╱─┘
//!   ═════════════════════╲════════════════∿∿∿∿∿∿∿   floor, waves ahead of the box if `washboard_height_m` > 0
//! ```
//! Six velocities, two joint rows, n + 2 contacts: the rows of the wedges have rank 2 on a flat floor however many there are, so that
//! H_uu is singular from n = 3 on and single contact forces are not unique. Unequal heights (the tips lie on a low-discrepancy set
//! below the plane of the rightmost) make the rows of the closed wedges few in truth and many within a contact margin. On the
//! washboard three wedges may touch slopes that differ: over-constraint comes back again and again.
//!
//! The manoeuvre is that of the wedge box; the wedges stand on a track of their own, beside the disc's, and only that one is wavy. Only
//! the outer wedges have gaps of their own in the data; the least gap of all wedges is there too.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4. With two wedges
//! on a flat floor it is the wedge box.
//!
//! Parameters *ours*; hydraulic constants of Naya et al. 2011.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::cylinder;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{LedgeDisc, SupportedBox, SupportedBoxGeometry};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: cylinder::trace_columns(
            &["box_x_m", "box_y_m", "box_angle_rad"],
            &[
                "gap_right_support_m",
                "gap_left_support_m",
                "gap_disc_ledge_m",
                "gap_disc_floor_m",
                "gap_supports_least_m",
                "closed_contacts",
                "rank_h_uu",
            ],
        ),
        drawing_columns: names(&["contact_force_sum_n"]),
        interface_columns: vec![cylinder::interface()],
        reference: contact_parameters::reference(),
        ..Case::new(
            "n-wedge-box",
            "Wedge box on n coplanar or uneven wedges, on a flat or a wavy floor (redundant contacts)",
            CaseDefaults {
                duration_s: 2.5,
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
    use Range::{Finite, NotNegative, Positive, Whole};
    vec![
        p("supports", "-", 8.0, Whole(2, MOST_SUPPORTS), "number n of wedges", OURS),
        p(
            "height_spread_m",
            "m",
            0.0,
            NotNegative,
            "largest distance of a wedge tip above that of the rightmost",
            OURS,
        ),
        p("washboard_height_m", "m", 0.0, NotNegative, "height of the waves of the wedges' floor", OURS),
        p("washboard_length_m", "m", 0.15, Positive, "length of the waves", OURS),
        p("washboard_lead_m", "m", 0.05, NotNegative, "distance of the first wave ahead of the right wedge", OURS),
        p("box_mass_kg", "kg", 200.0, Positive, "mass of the box", WEDGE_BOX),
        p("box_width_m", "m", 1.0, Positive, "width of the box (its inertia is that of a rectangle)", WEDGE_BOX),
        p("box_height_m", "m", 0.6, Positive, "height of the box", WEDGE_BOX),
        p(
            "wedge_tip_x_m",
            "m",
            0.4,
            Positive,
            "rightmost wedge tip in the box frame, x (the leftmost is mirrored)",
            WEDGE_BOX,
        ),
        p("wedge_tip_y_m", "m", -0.4, Finite, "rightmost wedge tip in the box frame, y", WEDGE_BOX),
        p("disc_mass_kg", "kg", 50.0, Positive, "mass of the disc", WEDGE_BOX),
        p("disc_radius_m", "m", 0.2, Positive, "radius of the disc", WEDGE_BOX),
        p("disc_pin_x_m", "m", -0.8, Finite, "joint of the disc in the box frame, x", WEDGE_BOX),
        p("disc_pin_y_m", "m", -0.19, Finite, "joint of the disc in the box frame, y", WEDGE_BOX),
        p("ledge_height_m", "m", 0.06, NotNegative, "height of the ledge above the floor", WEDGE_BOX),
        p(
            "ledge_lead_m",
            "m",
            0.1,
            NotNegative,
            "distance of the ledge's corner ahead of the disc's centre",
            WEDGE_BOX,
        ),
        p("ramp_slope", "-", 0.15, NotNegative, "fall over run of the ramp", WEDGE_BOX),
        p("attachment_x_m", "m", -0.5, Finite, "actuator's end on the box, box frame, x", WEDGE_BOX),
        p("attachment_y_m", "m", 0.3, Finite, "actuator's end on the box, box frame, y", WEDGE_BOX),
        p("ground_pin_x_m", "m", -3.0, Finite, "actuator's fixed end, x; its height is the attachment's", WEDGE_BOX),
        p("gravity_m_s2", "m/s²", 9.81, NotNegative, "gravity", "standard"),
    ]
}

/// More would say nothing new.
const MOST_SUPPORTS: u32 = 64;

/// Tips of the wedges: the rightmost, the leftmost, then those between from right to left.
fn tips(parameters: &Parameters) -> Result<Vec<[f64; 2]>> {
    let count = parameters.whole("supports");
    let (x, y) = (parameters.number("wedge_tip_x_m"), parameters.number("wedge_tip_y_m"));
    let spread = parameters.number("height_spread_m");
    let last = count as usize - 1;
    let order = [0, last].into_iter().chain(1..last);
    // Multiples of the golden ratio fill an interval evenly whatever their number.
    let tip = |k: usize| [x - 2.0 * x * k as f64 / last as f64, y + spread * (k as f64 * GOLDEN).fract()];
    Ok(order.map(tip).collect())
}

const GOLDEN: f64 = 0.618_033_988_749_894_9;

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (width, height) = (get("box_width_m"), get("box_height_m"));
    let model = SupportedBox::new(SupportedBoxGeometry {
        box_mass: get("box_mass_kg"),
        box_inertia: get("box_mass_kg") * (width * width + height * height) / 12.0,
        supports: tips(parameters)?,
        discs: vec![LedgeDisc {
            mass: get("disc_mass_kg"),
            radius: get("disc_radius_m"),
            pin: [get("disc_pin_x_m"), get("disc_pin_y_m")],
            ledge_height: get("ledge_height_m"),
            ledge_lead: get("ledge_lead_m"),
            ramp_slope: get("ramp_slope"),
        }],
        washboard: [get("washboard_height_m"), get("washboard_length_m")],
        washboard_lead: get("washboard_lead_m"),
        start_angle: 0.0,
        attachment: [get("attachment_x_m"), get("attachment_y_m")],
        ground_pin_x: get("ground_pin_x_m"),
        gravity: get("gravity_m_s2"),
    })?;
    cylinder::system(model, parameters, solver)
}

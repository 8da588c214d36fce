//! `packed-box`: discs packed in a box, one wall of which a cylinder holds: many contacts whose forces at rest are known one by one.
//!
//! ```text
//!  ╠════[▒▒]════│( )   ( )   ( )│   the left wall on the cylinder, the right one fixed
//!  anchor       │   ( )   ( )   │
//!               │( )   ( )   ( )│   each disc on two below it, or on one and a wall
//!   ════════════╧══(_)═══(_)════╧══ half discs on the floor
//! ```
//! 1 + 2N velocities (wall; x and y of N discs: without friction they do not spin). Layers of m and m − 1 discs in turn, neighbours of
//! a layer apart: the centre of a disc lies at the angle α above that of either below. Each disc has two contacts below it, 2N in all:
//! with both walls held as many as there are unknowns, so that forces at rest are unique.
//!
//! **Closed form.** The force of a contact below a disc goes on straight through the discs below that, where weight adds to it, and is
//! turned back by the walls ([`wall_forces`]).
//!
//! **Manoeuvre.** Held in equilibrium; the cylinder lets the wall out, then pushes it back in and lifts the packing, which with all its
//! contacts closed is a mechanism of one degree of freedom.
//!
//! **Contacts**: a list made once, at the start (see [`Discs`]); a run in which discs move farther than it holds for ends.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4.
//!
//! **Source**: *ours*; the fluid is that of Naya et al. 2011.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::cylinder;
use super::fluid;
use super::hydraulics;
use super::loader;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{ContactList, Discs, DiscsGeometry};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::{Error, Result};
use rimbench_core::name::names;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_6};

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: loader::trace_columns(),
        drawing_columns: names(&loader::DRAWING_COLUMNS),
        interface_columns: vec![cylinder::interface()],
        ..Case::new(
            "packed-box",
            "Discs packed in a box, one wall of which a cylinder holds (36 forces at rest in closed form; thousands by its parameters)",
            CaseDefaults {
                duration_s: 0.8,
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

fn parameters() -> Vec<Parameter> {
    use Range::{Fraction, NotNegative, Positive, Whole};
    [
        vec![
            p("columns", "-", 4.0, Whole(2, 60), "discs m in the lowest layer and each second one above", OURS),
            p("layers", "-", 5.0, Whole(1, 80), "layers", OURS),
            p("packing_angle_rad", "rad", 0.9, Positive, "angle α of contacts above the horizontal, π/6 to π/3", OURS),
            p("disc_radius_m", "m", 0.1, Positive, "radius R of the discs", OURS),
            p("disc_mass_kg", "kg", 20.0, Positive, "mass of each disc", OURS),
            p("wall_mass_kg", "kg", 100.0, Positive, "mass of the wall on the cylinder, with its piston", OURS),
            p("actuator_length_m", "m", 1.5, Positive, "length of the actuator at the start", OURS),
            p("piston_area_m2", "m²", 2e-3, Positive, "piston area A", OURS),
            p("cylinder_length_m", "m", 1.0, Positive, "length l of both chambers together", OURS),
            p("viscous_friction_n_s_m", "N·s/m", 1e4, NotNegative, "viscous friction c of the cylinder", OURS),
            p("valve_area_m2", "m²", 1e-5, Positive, "valve area a_v", OURS),
            p(
                "spool_change",
                "-",
                0.1,
                Fraction,
                "spool away from equilibrium while letting out (+) and pushing (−)",
                OURS,
            ),
            p("release_start_s", "s", 0.1, NotNegative, "start of letting out", OURS),
            p("release_end_s", "s", 0.3, NotNegative, "end of letting out", OURS),
            p("push_start_s", "s", 0.4, NotNegative, "start of pushing", OURS),
            p("spool_ramp_s", "s", 0.02, Positive, "time in which the spool moves", OURS),
        ],
        fluid::parameters(),
        vec![
            p("gravity_m_s2", "m/s²", 9.81, NotNegative, "gravity", "standard"),
            contact_parameters::stabilisation(),
            p("restitution", "-", 0.0, Fraction, "restitution e of all contacts", OURS),
        ],
    ]
    .concat()
}

/// Forces of a wall on the discs that touch it, from the top, N.
///
/// ```text
/// P_j = W cot α (1 + j + ⌊j/(2m − 2)⌋)        j layers above, of those layers that have m discs
/// ```
/// W is the weight of a disc. A disc with the forces A_l and A_r of the discs above it, from the left and from the right, passes on
/// `A_r + W/(2 sin α)` to the lower left and `A_l + W/(2 sin α)` to the lower right; at a wall what comes from the one side leaves on the
/// same side with all of its weight, `A + W/sin α`. So a line of force grows by half a `W/sin α` per layer and by another half each time
/// a wall turns it back, every 2m − 2 layers.
/// # Panics
/// If `columns` is below 2: one disc between two walls has no line of force.
/// # Source
/// Ours.
pub fn wall_forces(columns: u32, layers: u32, angle: f64, weight: f64) -> Vec<f64> {
    let (sin, cos) = libm::sincos(angle);
    let force = |above: u32| weight * cos / sin * f64::from(1 + above + above / (2 * columns - 2));
    (0..layers).filter(|above| (layers - 1 - above).is_multiple_of(2)).map(force).collect()
}

/// Centres of the discs, and of the half discs that they lie on.
fn packing(columns: u32, layers: u32, angle: f64, radius: f64) -> [Vec<[f64; 2]>; 2] {
    let (sin, cos) = libm::sincos(angle);
    // Half the distance of neighbours in a layer, and of layers.
    let (aside, up) = (2.0 * radius * cos, 2.0 * radius * sin);
    // A layer and the one above it in turn, from the left: the first two discs touch.
    let mut centres = Vec::new();
    for below in (0..layers).step_by(2) {
        for place in 0..2 * columns - 1 {
            let layer = below + place % 2;
            if layer < layers {
                centres.push([radius + aside * f64::from(place), up * f64::from(1 + layer)]);
            }
        }
    }
    let bumps = (0..columns - 1).map(|bump| [radius + aside * f64::from(1 + 2 * bump), 0.0]);
    [centres, bumps.collect()]
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (columns, layers, angle) = (parameters.whole("columns"), parameters.whole("layers"), get("packing_angle_rad"));
    if angle <= FRAC_PI_6 || angle >= FRAC_PI_3 {
        let expected = format!(
            "between π/6 = {FRAC_PI_6:.6} and π/3 = {FRAC_PI_3:.6}, where discs of a layer or of each second one meet"
        );
        return Err(Error::invalid("packing_angle_rad", angle, expected));
    }
    // Neighbours of a layer are 4 R cos α apart.
    let flattest = libm::acos(0.25 * (2.0 + Discs::LISTED));
    if layers == 1 && angle <= flattest {
        let expected = format!(
            "above {flattest:.6} where layers = 1: two discs of one layer would start more than {} radii apart, and no pair could ever touch",
            Discs::LISTED
        );
        return Err(Error::invalid("packing_angle_rad", angle, expected));
    }
    let radius = get("disc_radius_m");
    let [centres, bumps] = packing(columns, layers, angle, radius);
    let last = centres.iter().map(|centre| centre[0]).fold(f64::NEG_INFINITY, f64::max);
    let length = get("actuator_length_m");
    let geometry = DiscsGeometry {
        blade_mass: get("wall_mass_kg"),
        blade_velocity: 0.0,
        disc_mass: get("disc_mass_kg"),
        radius,
        centres,
        bumps,
        wall_x: last + radius,
        actuator_length: length,
        gravity: get("gravity_m_s2"),
    };
    let model = Discs::new(geometry, ContactList::Start)?;
    let weight = get("disc_mass_kg") * get("gravity_m_s2");
    let held = wall_forces(columns, layers, angle, weight).iter().sum();
    let (pressures, centre) = hydraulics::equilibrium(parameters, held)?;
    let (change, ramp) = (get("spool_change"), get("spool_ramp_s"));
    let [release, hold, push] = ["release_start_s", "release_end_s", "push_start_s"].map(|key| (key, get(key)));
    let spool = hydraulics::spool(&[
        (release.0, release.1, centre),
        (release.0, release.1 + ramp, centre + change),
        (hold.0, hold.1, centre + change),
        (hold.0, hold.1 + ramp, centre),
        (push.0, push.1, centre),
        (push.0, push.1 + ramp, centre - change),
    ])?;
    let cylinder = hydraulics::cylinder(parameters, length, pressures, spool)?;
    contact_parameters::coupled(model, cylinder, parameters, solver)
}

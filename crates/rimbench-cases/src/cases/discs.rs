//! Discs that a cylinder pushes: `disc-row`, `disc-pile`, `packed-box`. 1 + 2n velocities (blade; x and y of n discs: without friction they do
//! not spin). Shown in `docs/cases/disc-row.md` and `docs/cases/packed-box.md`.
//!
//! Numbers *ours*; the fluid is that of Naya et al. 2011.

use super::case::Purpose;
use super::contact_parameters::reference_of;
use super::prelude::*;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_6};

/// What is recorded of discs: the many contacts show as their least gap, the number closed and the sum of their forces; one at the blade,
/// one at the wall and one between discs by name.
fn recorded(case: Case) -> Case {
    Case {
        trace_columns: hydraulics::trace_columns(
            "blade_x_m disc_momentum_x_kg_m_s",
            "gap_blade_m gap_wall_m gap_pair_m gap_lowest_m closed_contacts contact_force_sum_n largest_displacement_m",
        ),
        drawing_columns: words("contact_force_blade_n contact_force_wall_n contact_force_pair_n"),
        interface_columns: hydraulics::interface(),
        ..case
    }
}

const DISCS: &str = "source: ours
    disc_radius_m | m | 0.1 | positive | radius R of the discs
    disc_mass_kg | kg | 20.0 | positive | mass of each disc
";
const LOADER: &str = "
    blade_mass_kg | kg | 100.0 | positive | mass of the blade with its piston
    blade_velocity_m_s | m/s | 0.0 | finite | velocity of the blade at the start
";
const LOADERS_CYLINDER: &str = "
    actuator_length_m | m | 1.5 | positive | length of the actuator at the start
    piston_area_m2 | m² | 2e-3 | positive | piston area A
    cylinder_length_m | m | 1.0 | positive | length l of both chambers together
    viscous_friction_n_s_m | N·s/m | 1e4 | not negative | viscous friction c of the cylinder
    valve_area_m2 | m² | 1e-5 | positive | valve area a_v
";
const PUSH: &str = "
    start_pressure_pa | Pa | 3.85e6 | positive | pressure in both chambers at the start
    spool_push | - | 0.3 | fraction | spool command while pushing; below 0.5 extends
    push_start_s | s | 0.1 | not negative | start of pushing
    spool_ramp_s | s | 0.05 | positive | time in which the spool moves
";
const REST: &str = "source: ours
    gravity_m_s2 | m/s² | 9.81 | not negative | gravity | standard
    stabilisation | - | 0.2 | fraction | fraction γ of a penetration removed per mechanics step
    restitution | - | 0.0 | fraction | restitution e of all contacts
";
const WALL_GAP: &str = "wall_gap_m | m | 0.02 | finite | distance of the wall from the discs at the start";

/// x of the disc farthest to the right, m.
fn last(centres: &[[f64; 2]]) -> f64 {
    centres.iter().map(|centre| centre[0]).fold(f64::NEG_INFINITY, f64::max)
}

/// Both sides for discs with these centres before a loader's blade; the wall stands behind the last of them.
fn loader(
    parameters: &Parameters,
    solver: &SolverEntry,
    centres: Vec<[f64; 2]>,
    list: ContactList,
) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let [radius, length] = ["disc_radius_m", "actuator_length_m"].map(get);
    let geometry = DiscsGeometry {
        blade_mass: get("blade_mass_kg"),
        blade_velocity: get("blade_velocity_m_s"),
        disc_mass: get("disc_mass_kg"),
        radius,
        wall_x: last(&centres) + radius + get("wall_gap_m"),
        actuator_length: length,
        gravity: get("gravity_m_s2"),
        centres,
        bumps: Vec::new(),
    };
    let model = Discs::new(geometry, list)?;
    let [start, ramp] = ["push_start_s", "spool_ramp_s"].map(get);
    let spool = hydraulics::spool(&[("push_start_s", start, 0.5), ("spool_ramp_s", start + ramp, get("spool_push"))])?;
    let cylinder = hydraulics::cylinder(parameters, length, [get("start_pressure_pa"); 2], spool)?;
    coupled(model, cylinder, parameters, solver)
}

/// A row of discs is pushed together and against a wall: each gap closes with an impact.
pub(super) fn row() -> Case {
    const OWN: &str = "source: ours
        discs | - | 10.0 | whole 2..2500 | number of discs
        disc_gap_m | m | 5e-3 | finite | gap between blade, discs and next discs at the start
    ";
    recorded(Case {
        parameters: table(&[OWN, DISCS, LOADER, LOADERS_CYLINDER, PUSH, FLUID, REST, WALL_GAP]),
        constant_mechanics: true,
        // Each disc on the floor, and between blade, discs and wall.
        reference: reference_of(|parameters| 2 * parameters.number("discs") as usize + 1),
        ..Case::new(
            "disc-row",
            "A loader's blade pushes a row of discs together and against a wall (a contact chain)",
            times(1.0, 5e-3, 5e-5, [1e-4, 2e-4]),
            |parameters, solver| {
                let [radius, gap] = ["disc_radius_m", "disc_gap_m"].map(|name| parameters.number(name));
                let place = |disc: u32| [f64::from(disc) * (2.0 * radius + gap) + gap + radius, radius];
                let centres = (0..parameters.whole("discs")).map(place).collect();
                loader(parameters, solver, centres, ContactList::Neighbours)
            },
        )
    })
}

/// A hexagonal heap settles between blade and wall and is pushed: some 3n contacts, many more than it can carry (2n) without friction.
pub(super) fn pile() -> Case {
    const OWN: &str = "source: ours
        columns | - | 6.0 | whole 2..60 | discs in the lowest layer
        layers | - | 4.0 | whole 1..60 | layers
        contact_list | - | start, travelling | choice | possible contacts: those near at the start (a run in which discs move farther ends), or near at the time
    ";
    recorded(Case {
        purpose: Purpose::Speed,
        parameters: table(&[OWN, DISCS, LOADER, LOADERS_CYLINDER, PUSH, FLUID, REST, WALL_GAP]),
        ..Case::new(
            "disc-pile",
            "A loader's blade pushes a heap of discs against a wall (62 contacts; thousands by its parameters)",
            times(0.5, 5e-3, 5e-5, [1e-4, 2e-4]),
            |parameters, solver| {
                let radius = parameters.number("disc_radius_m");
                let mut centres = Vec::new();
                for layer in 0..parameters.whole("layers") {
                    // Each second layer lies in the hollows of the one below.
                    let shift = layer % 2;
                    for column in 0..parameters.whole("columns") - shift {
                        let x = radius * f64::from(1 + shift + 2 * column);
                        centres.push([x, radius * (1.0 + 3.0_f64.sqrt() * f64::from(layer))]);
                    }
                }
                let travelling = parameters.choice("contact_list") == "travelling";
                let list = if travelling { ContactList::Travelling } else { ContactList::Start };
                loader(parameters, solver, centres, list)
            },
        )
    })
}

/// Layers of m and m − 1 discs in turn between two walls, neighbours of a layer apart, each disc on two below it: as many contacts as
/// unknowns, so that forces at rest are unique.
pub(super) fn packed_box() -> Case {
    const OWN: &str = "source: ours
        columns | - | 4.0 | whole 2..60 | discs m in the lowest layer and each second one above
        layers | - | 5.0 | whole 1..80 | layers
        packing_angle_rad | rad | 0.9 | positive | angle α of contacts above the horizontal, π/6 to π/3
    ";
    const WALL: &str = "
        wall_mass_kg | kg | 100.0 | positive | mass of the wall on the cylinder, with its piston
    ";
    const MOVES: &str = "
        spool_change | - | 0.1 | fraction | spool away from equilibrium while letting out (+) and pushing (−)
        release_start_s | s | 0.1 | not negative | start of letting out
        release_end_s | s | 0.3 | not negative | end of letting out
        push_start_s | s | 0.4 | not negative | start of pushing
        spool_ramp_s | s | 0.02 | positive | time in which the spool moves
    ";
    recorded(Case {
        purpose: Purpose::Speed,
        parameters: table(&[OWN, DISCS, WALL, LOADERS_CYLINDER, MOVES, FLUID, REST]),
        ..Case::new(
            "packed-box",
            "Discs packed in a box, one wall of which a cylinder holds (36 forces at rest in closed form; thousands by its parameters)",
            times(0.8, 5e-3, 5e-5, [1e-4, 2e-4]),
            build_packed,
        )
    })
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

fn build_packed(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
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
    let length = get("actuator_length_m");
    let geometry = DiscsGeometry {
        blade_mass: get("wall_mass_kg"),
        blade_velocity: 0.0,
        disc_mass: get("disc_mass_kg"),
        radius,
        wall_x: last(&centres) + radius,
        centres,
        bumps,
        actuator_length: length,
        gravity: get("gravity_m_s2"),
    };
    let model = Discs::new(geometry, ContactList::Start)?;
    let weight = get("disc_mass_kg") * get("gravity_m_s2");
    let held = wall_forces(columns, layers, angle, weight).iter().sum();
    let (pressures, centre) = hydraulics::equilibrium(parameters, held)?;
    let moves = [("release_start_s", 1.0), ("release_end_s", 0.0), ("push_start_s", -1.0)];
    let spool = hydraulics::moved_spool(parameters, centre, &moves)?;
    let cylinder = hydraulics::cylinder(parameters, length, pressures, spool)?;
    coupled(model, cylinder, parameters, solver)
}

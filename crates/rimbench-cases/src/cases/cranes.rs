//! The hydraulic crane with its load on a rope: `crane-set-down`, `crane-drag` and `crane-heap`. Three velocities (θ, load x, y) and those of what
//! it meets; the rope can pull and not push. Shown in `docs/cases/crane-set-down.md` and `docs/cases/crane-heap.md`.
//!
//! Geometry, masses and hydraulics of LIM cosim-benchmarks; rope, ground and manoeuvres are *ours*.

use super::case::Purpose;
use super::prelude::*;

const LINK: &str = "source: LIM cosim-benchmarks
    link_1_length_m | m | 1.0 | positive | length L of the link
    rope_length_m | m | 0.5 | positive | length of the rope
    rod_mass_kg | kg | 200.0 | positive | mass m of the link, a uniform rod
    joint_mass_kg | kg | 250.0 | not negative | point mass m_p at the end of the link
    load_mass_kg | kg | 100.0 | positive | mass m_h of the load
    pin_x_m | m | 0.8660254037844386 | positive | x of the actuator's fixed end B; its y is 0
    theta_1_start_rad | rad | 0.5235987755982989 | finite | angle of the link at the start
    ground_height_m | m | -0.03 | finite | height of the ground; the load starts at 0 | ours
    piston_area_m2 | m² | 65e-4 | positive | piston area A
    cylinder_length_m | m | 0.442 | positive | length l of both chambers together
    viscous_friction_n_s_m | N·s/m | 1e5 | not negative | viscous friction c of the cylinder
    valve_area_m2 | m² | 5e-4 | positive | valve area a_v
";
const MANOEUVRE: &str = "source: ours
    spool_change | - | 0.01 | fraction | spool away from equilibrium while lowering (+) and lifting (−)
    lower_start_s | s | 0.2 | not negative | start of lowering
    lower_end_s | s | 1.6 | not negative | end of lowering
    lift_start_s | s | 2.0 | not negative | start of lifting
";
const RAMP: &str = "spool_ramp_s | s | 0.02 | positive | time in which the spool moves | ours";
const REST: &str = "source: LIM cosim-benchmarks
    gravity_m_s2 | m/s² | 9.81 | positive | gravity
    stabilisation | - | 0.2 | fraction | fraction γ of a penetration removed per mechanics step | ours
    restitution | - | 0.0 | fraction | restitution e of load and rope | ours
    attachment_m | m | 0.5 | positive | distance of the actuator's other end from the joint O
";

/// The crane as the parameters say.
fn geometry(parameters: &Parameters) -> CraneGeometry {
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

/// Lowers the load onto the ground, where rope and ground lock the link for a moment, and lifts it again with a jerk.
pub(super) fn set_down() -> Case {
    Case {
        parameters: table(&[LINK, MANOEUVRE, RAMP, FLUID, REST]),
        trace_columns: hydraulics::trace_columns(
            "theta_1_rad load_x_m load_y_m",
            "gap_rope_m gap_ground_m contact_force_rope_n contact_force_ground_n closed_contacts",
        ),
        interface_columns: hydraulics::interface(),
        reference: reference(),
        ..Case::new(
            "crane-set-down",
            "Hydraulic crane that sets a load on a rope on the ground, drags it and lifts it off",
            times(4.0, 5e-3, 5e-5, [5e-5, 1e-4]),
            |parameters, solver| {
                let model = CraneWithRope::new(geometry(parameters), parameters.number("ground_height_m"))?;
                let (pressures, centre) = hydraulics::equilibrium(parameters, model.taut().equilibrium_force())?;
                let moves = [("lower_start_s", 1.0), ("lower_end_s", 0.0), ("lift_start_s", -1.0)];
                let spool = hydraulics::moved_spool(parameters, centre, &moves)?;
                let cylinder = hydraulics::cylinder(parameters, model.taut().start_length(), pressures, spool)?;
                coupled(model, cylinder, parameters, solver)
            },
        )
    }
}

/// Drags a load that lies aside over rough ground: it sticks until `T sin φ = μ (m_h g − T cos φ)`, slides and lifts off.
pub(super) fn drag() -> Case {
    const CHANGED: &str = "source: ours
        - ground_height_m lower_start_s lower_end_s lift_start_s
        load_offset_m | m | 0.2 | finite | how far out from the end of the link the load lies at the start
        lift_start_s | s | 0.2 | not negative | start of lifting
    ";
    let mut case = Case {
        name: "crane-drag".into(),
        about: "Hydraulic crane that drags a load over rough ground by its rope until it lifts off".into(),
        parameters: table(&[LINK, MANOEUVRE, RAMP, FLUID, REST, CHANGED, WITH_FRICTION]),
        build: Arc::new(|parameters, solver| {
            let offset = parameters.number("load_offset_m");
            let model = CraneWithRope::with_load_on_ground(geometry(parameters), offset)?;
            let (pressures, centre) = hydraulics::equilibrium(parameters, model.link_force())?;
            let spool = hydraulics::moved_spool(parameters, centre, &[("lift_start_s", -1.0)])?;
            let cylinder = hydraulics::cylinder(parameters, model.taut().start_length(), pressures, spool)?;
            coupled(model, cylinder, parameters, solver)
        }),
        ..set_down()
    };
    case.trace_columns.extend(words("friction_force_ground_n contact_state_ground"));
    case
}

/// Pulls its load, a disc, out from under a hexagonal heap of others between two walls.
pub(super) fn heap() -> Case {
    const HEAP: &str = "source: ours
        columns | - | 3.0 | whole 1..61 | discs in the lowest layer, the load among them; an odd number
        layers | - | 3.0 | whole 1..60 | layers
        disc_radius_m | m | 0.03 | positive | radius R of the discs and the load
        disc_mass_kg | kg | 4.0 | positive | mass of each disc
        wall_gap_m | m | 3e-3 | not negative | distance of either wall from the lowest layer at the start
        rope_slack_m | m | 5e-3 | not negative | length of the rope that hangs loose at the start
        list_reach_radii | - | 0.8 | positive | gap up to which contacts are listed, in radii; at most 0.8
        lift_end_s | s | 0.9 | not negative | end of lifting
    ";
    const CHANGED: &str = "
        - ground_height_m lower_start_s lower_end_s
        load_mass_kg = 20.0 | ours
        spool_change = 0.04 | ours | spool away from equilibrium while lifting
        lift_start_s = 0.2 | ours
    ";
    Case {
        purpose: Purpose::Speed,
        parameters: table(&[HEAP, RAMP, LINK, MANOEUVRE, FLUID, REST, CHANGED]),
        trace_columns: hydraulics::trace_columns(
            "theta_1_rad load_x_m load_y_m heap_height_m",
            "gap_rope_m gap_floor_m gap_lowest_m contact_force_rope_n contact_force_floor_n closed_contacts \
             contact_force_sum_n largest_displacement_m",
        ),
        interface_columns: hydraulics::interface(),
        ..Case::new(
            "crane-heap",
            "Hydraulic crane that pulls its load out from under a heap of discs (room for 29 contacts; thousands by its parameters)",
            times(1.2, 5e-3, 5e-5, [1e-4, 2e-4]),
            build_heap,
        )
    }
}

/// Centres of the discs of a heap as seen from the load: hexagonal, one less in each second layer; in a single column one on the other.
fn centres(columns: u32, layers: u32, radius: f64) -> Vec<[f64; 2]> {
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

fn build_heap(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (columns, layers) = (parameters.whole("columns"), parameters.whole("layers"));
    if columns.is_multiple_of(2) {
        return Err(Error::invalid("columns", columns, "an odd number, so that the load lies in the middle"));
    }
    let radius = get("disc_radius_m");
    let heap = HeapGeometry {
        radius,
        disc_mass: get("disc_mass_kg"),
        centres: centres(columns, layers, radius),
        half_width: radius * f64::from(columns) + get("wall_gap_m"),
        slack: get("rope_slack_m"),
        list_reach_radii: get("list_reach_radii"),
    };
    let model = CraneInHeap::new(geometry(parameters), heap)?;
    let (pressures, centre) = hydraulics::equilibrium(parameters, model.crane().link_force())?;
    let spool = hydraulics::moved_spool(parameters, centre, &[("lift_start_s", -1.0), ("lift_end_s", 0.0)])?;
    let cylinder = hydraulics::cylinder(parameters, model.crane().taut().start_length(), pressures, spool)?;
    coupled(model, cylinder, parameters, solver)
}

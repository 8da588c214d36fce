//! `gripper`: two opposed cylinders close on a box. Two interface rows, six contacts of rank four, over-constrained when closed. Shown in
//! `docs/cases/gripper.md`; numbers *ours*, the fluid is that of Naya et al. 2011.

use super::prelude::*;

const PARAMETERS: &str = "source: ours
    jaw_mass_kg | kg | 30.0 | positive | mass of each jaw with its piston
    box_mass_kg | kg | 50.0 | positive | mass of the box
    box_width_m | m | 0.3 | positive | width of the box
    box_height_m | m | 0.4 | positive | height of the box
    lower_pad_m | m | 0.1 | finite | height of the lower pads
    upper_pad_m | m | 0.3 | finite | height of the upper pads
    left_clearance_m | m | 0.02 | finite | distance of the left jaw from the box at the start
    right_clearance_m | m | 0.05 | finite | distance of the right jaw from the box at the start
    actuator_length_m | m | 0.6 | positive | length of both actuators at the start
    piston_area_m2 | m² | 1e-3 | positive | piston area A
    cylinder_length_m | m | 0.6 | positive | length l of both chambers together
    viscous_friction_n_s_m | N·s/m | 5e3 | not negative | viscous friction c of a cylinder
    valve_area_m2 | m² | 4e-6 | positive | valve area a_v
    start_pressure_pa | Pa | 3.85e6 | positive | pressure in all chambers at the start
    spool_close | - | 0.4 | fraction | spool command while closing; below 0.5 extends
    spool_open | - | 0.6 | fraction | spool command while opening
    close_start_s | s | 0.1 | not negative | start of closing
    open_start_s | s | 1.5 | not negative | start of opening
    spool_ramp_s | s | 0.02 | positive | time in which the spools move
";
const REST: &str = "source: ours
    gravity_m_s2 | m/s² | 9.81 | not negative | gravity | standard
    stabilisation | - | 0.2 | fraction | fraction γ of a penetration removed per mechanics step
    restitution | - | 0.0 | fraction | restitution e of pads and corners
";

pub(super) fn entry() -> Case {
    Case {
        parameters: table(&[PARAMETERS, FLUID, REST]),
        trace_columns: words(
            "time_s left_jaw_x_m right_jaw_x_m box_x_m box_y_m box_angle_rad left_length_m right_length_m \
             left_velocity_m_s right_velocity_m_s left_force_n right_force_n force_to_mechanics_n \
             force_2_to_mechanics_n effective_mass_kg gap_left_lower_pad_m gap_left_upper_pad_m gap_right_lower_pad_m \
             gap_right_upper_pad_m gap_left_corner_m gap_right_corner_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words(
            "left_pressure_1_pa left_pressure_2_pa right_pressure_1_pa right_pressure_2_pa \
             contact_force_left_lower_pad_n contact_force_left_upper_pad_n contact_force_right_lower_pad_n \
             contact_force_right_upper_pad_n contact_force_left_corner_n contact_force_right_corner_n",
        ),
        interface_columns: vec![
            InterfaceColumns::new("left_length_m", "left_velocity_m_s", "left_force_n"),
            InterfaceColumns::new("right_length_m", "right_velocity_m_s", "right_force_n"),
        ],
        constant_mechanics: true,
        reference: reference(),
        ..Case::new(
            "gripper",
            "Two opposed cylinders squeeze a box (two interface rows, redundant contacts, over-constrained when closed)",
            times(2.0, 5e-3, 5e-5, [5e-5, 1e-4]),
            build,
        )
    }
}

const NAMES: [ActuatorNames; 2] = [
    ActuatorNames {
        position: "left_length_m",
        velocity: "left_velocity_m_s",
        force: "left_force_n",
        observables: &["left_pressure_1_pa", "left_pressure_2_pa", "left_spool"],
    },
    ActuatorNames {
        position: "right_length_m",
        velocity: "right_velocity_m_s",
        force: "right_force_n",
        observables: &["right_pressure_1_pa", "right_pressure_2_pa", "right_spool"],
    },
];

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let length = get("actuator_length_m");
    let model = Gripper::new(GripperGeometry {
        jaw_mass: get("jaw_mass_kg"),
        box_mass: get("box_mass_kg"),
        box_size: ["box_width_m", "box_height_m"].map(get),
        pad_heights: ["lower_pad_m", "upper_pad_m"].map(get),
        clearances: ["left_clearance_m", "right_clearance_m"].map(get),
        actuator_length: length,
        gravity: get("gravity_m_s2"),
    })?;
    let [close, open, ramp] = ["close_start_s", "open_start_s", "spool_ramp_s"].map(get);
    let spool = hydraulics::spool(&[
        ("close_start_s", close, 0.5),
        ("close_start_s", close + ramp, get("spool_close")),
        ("open_start_s", open, get("spool_close")),
        ("open_start_s", open + ramp, get("spool_open")),
    ])?;
    let pressures = [get("start_pressure_pa"); 2];
    let unit = || hydraulics::cylinder(parameters, length, pressures, spool.clone());
    coupled(model, ActuatorPair::new([unit()?, unit()?], NAMES), parameters, solver)
}

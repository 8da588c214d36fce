//! `gripper`: two opposed cylinders close on a box. Two interfaces, redundant contacts, over-constrained when closed.
//!
//! ```text
//!            │◄ jaw    ┌─────────┐    jaw ►│
//!  ╠══[▒▒]───┤◁  pads  │   box   │  pads  ▷├───[▒▒]══╣
//!  anchor    │◁        │         │        ▷│    anchor
//!   ═══════════════════╧═════════╧═══════════════════  floor
//! ```
//! Five velocities (two jaws, box x, y, φ), six contacts (two pads on each side, two corners on the floor), an interface of two
//! rows. With everything closed the six rows have rank four: two are redundant, and the jaws can only move together, so one of the
//! two directions of the interface is locked. No friction.
//!
//! **Manoeuvre.** Both cylinders extend. The left jaw has less way to go, takes the box along, and both squeeze it: the
//! cylinders stall, and the pressures go to where the valves balance,
//!
//! ```text
//! p₁ = (κ² p_P + (1 − κ)² p_T)/(κ² + (1 − κ)²)      p₂ with κ and 1 − κ exchanged      squeeze = (p₂ − p₁) A
//! ```
//! Then they open again.
//!
//! **Direct feedthrough** of the actuators, through their viscous friction. **Reference**: monolithic, h, h/2, h/4; forces on
//! single pads are not unique, their sums are.
//!
//! **Source**: *ours*; the fluid is that of Naya et al. 2011.

use super::case::{Case, CaseDefaults, CoupledSystem, InterfaceColumns};
use super::contact_parameters;
use super::fluid;
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{ActuatorNames, ActuatorPair, Gripper, GripperGeometry, Spool};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: names(&[
            "time_s",
            "left_jaw_x_m",
            "right_jaw_x_m",
            "box_x_m",
            "box_y_m",
            "box_angle_rad",
            "left_length_m",
            "right_length_m",
            "left_velocity_m_s",
            "right_velocity_m_s",
            "left_force_n",
            "right_force_n",
            "force_to_mechanics_n",
            "force_2_to_mechanics_n",
            "effective_mass_kg",
            "gap_left_lower_pad_m",
            "gap_left_upper_pad_m",
            "gap_right_lower_pad_m",
            "gap_right_upper_pad_m",
            "gap_left_corner_m",
            "gap_right_corner_m",
            "closed_contacts",
            "rank_h_uu",
        ]),
        drawing_columns: names(&[
            "left_pressure_1_pa",
            "left_pressure_2_pa",
            "right_pressure_1_pa",
            "right_pressure_2_pa",
            "contact_force_left_lower_pad_n",
            "contact_force_left_upper_pad_n",
            "contact_force_right_lower_pad_n",
            "contact_force_right_upper_pad_n",
            "contact_force_left_corner_n",
            "contact_force_right_corner_n",
        ]),
        interface_columns: vec![
            InterfaceColumns::new("left_length_m", "left_velocity_m_s", "left_force_n"),
            InterfaceColumns::new("right_length_m", "right_velocity_m_s", "right_force_n"),
        ],
        constant_mechanics: true,
        reference: contact_parameters::reference(),
        ..Case::new(
            "gripper",
            "Two opposed cylinders squeeze a box (two interface rows, redundant contacts, over-constrained when closed)",
            CaseDefaults {
                duration_s: 2.0,
                macro_step_s: 5e-3,
                micro_step_s: 5e-5,
                reference_step_s: 5e-5,
                reference_sampling_s: 1e-4,
            },
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

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    use Range::{Finite, Fraction, NotNegative, Positive};
    let mut machine = machine();
    let at = |name: &str| machine.iter().position(|known| known.name == name).unwrap_or(machine.len());
    let (clearances, pressure) = (at("actuator_length_m"), at("valve_area_m2") + 1);
    machine.splice(
        pressure..pressure,
        [
            p("start_pressure_pa", "Pa", 3.85e6, Positive, "pressure in all chambers at the start", OURS),
            p("spool_close", "-", 0.4, Fraction, "spool command while closing; below 0.5 extends", OURS),
            p("spool_open", "-", 0.6, Fraction, "spool command while opening", OURS),
            p("close_start_s", "s", 0.1, NotNegative, "start of closing", OURS),
            p("open_start_s", "s", 1.5, NotNegative, "start of opening", OURS),
            p("spool_ramp_s", "s", 0.02, Positive, "time in which the spools move", OURS),
        ],
    );
    machine.splice(
        clearances..clearances,
        [
            p("left_clearance_m", "m", 0.02, Finite, "distance of the left jaw from the box at the start", OURS),
            p("right_clearance_m", "m", 0.05, Finite, "distance of the right jaw from the box at the start", OURS),
        ],
    );
    [machine, fluid::parameters(), law()].concat()
}

/// Masses, lengths and cylinders.
pub(super) fn machine() -> Vec<Parameter> {
    use Range::{Finite, NotNegative, Positive};
    vec![
        p("jaw_mass_kg", "kg", 30.0, Positive, "mass of each jaw with its piston", OURS),
        p("box_mass_kg", "kg", 50.0, Positive, "mass of the box", OURS),
        p("box_width_m", "m", 0.3, Positive, "width of the box", OURS),
        p("box_height_m", "m", 0.4, Positive, "height of the box", OURS),
        p("lower_pad_m", "m", 0.1, Finite, "height of the lower pads", OURS),
        p("upper_pad_m", "m", 0.3, Finite, "height of the upper pads", OURS),
        p("actuator_length_m", "m", 0.6, Positive, "length of both actuators at the start", OURS),
        p("piston_area_m2", "m²", 1e-3, Positive, "piston area A", OURS),
        p("cylinder_length_m", "m", 0.6, Positive, "length l of both chambers together", OURS),
        p("viscous_friction_n_s_m", "N·s/m", 5e3, NotNegative, "viscous friction c of a cylinder", OURS),
        p("valve_area_m2", "m²", 4e-6, Positive, "valve area a_v", OURS),
    ]
}

/// Gravity, and the law of the contacts.
pub(super) fn law() -> Vec<Parameter> {
    vec![
        p("gravity_m_s2", "m/s²", 9.81, Range::NotNegative, "gravity", "standard"),
        contact_parameters::stabilisation(),
        p("restitution", "-", 0.0, Range::Fraction, "restitution e of pads and corners", OURS),
    ]
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (close, open, ramp) = (get("close_start_s"), get("open_start_s"), get("spool_ramp_s"));
    let spool = || {
        hydraulics::spool(&[
            ("close_start_s", close, 0.5),
            ("close_start_s", close + ramp, get("spool_close")),
            ("open_start_s", open, get("spool_close")),
            ("open_start_s", open + ramp, get("spool_open")),
        ])
    };
    let clearances = [get("left_clearance_m"), get("right_clearance_m")];
    system(parameters, solver, clearances, 0.0, [get("start_pressure_pa"); 2], spool)
}

/// Both sides: jaws so far from the box (m), the box so high above the floor (m), chambers at these pressures (Pa), and the same command for
/// both valves, which is made once the geometry has been found possible.
pub(super) fn system(
    parameters: &Parameters,
    solver: &SolverEntry,
    clearances: [f64; 2],
    floor_drop: f64,
    pressures: [f64; 2],
    spool: impl FnOnce() -> Result<Spool>,
) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let length = get("actuator_length_m");
    let model = Gripper::new(GripperGeometry {
        jaw_mass: get("jaw_mass_kg"),
        box_mass: get("box_mass_kg"),
        box_size: [get("box_width_m"), get("box_height_m")],
        pad_heights: [get("lower_pad_m"), get("upper_pad_m")],
        clearances,
        floor_drop,
        actuator_length: length,
        gravity: get("gravity_m_s2"),
    })?;
    let spool = spool()?;
    let unit = || hydraulics::cylinder(parameters, length, pressures, spool.clone());
    let actuators = ActuatorPair::new([unit()?, unit()?], NAMES);
    contact_parameters::coupled(model, actuators, parameters, solver)
}

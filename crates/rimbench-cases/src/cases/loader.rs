//! What the cases with discs share: the loader's blade with its cylinder, its parameters and columns.

use super::case::CoupledSystem;
use super::contact_parameters;
use super::cylinder;
use super::fluid;
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{ContactList, Discs, DiscsGeometry};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::Name;

/// Columns of a trace. The many contacts show as their least gap, the number closed and the sum of their forces; one at the blade,
/// one at the wall and one between discs by name.
pub(super) fn trace_columns() -> Vec<Name> {
    cylinder::trace_columns(
        &["blade_x_m", "disc_momentum_x_kg_m_s"],
        &[
            "gap_blade_m",
            "gap_wall_m",
            "gap_pair_m",
            "gap_lowest_m",
            "closed_contacts",
            "contact_force_sum_n",
            "largest_displacement_m",
        ],
    )
}

/// Columns for drawings.
pub(super) const DRAWING_COLUMNS: [&str; 3] = ["contact_force_blade_n", "contact_force_wall_n", "contact_force_pair_n"];

const OURS: &str = "ours";

/// Parameters of blade, discs and cylinder, after those of a case.
pub(super) fn parameters() -> Vec<Parameter> {
    use Range::{Finite, Fraction, NotNegative, Positive};
    [
        vec![
            p("disc_radius_m", "m", 0.1, Positive, "radius R of the discs", OURS),
            p("disc_mass_kg", "kg", 20.0, Positive, "mass of each disc", OURS),
            p("blade_mass_kg", "kg", 100.0, Positive, "mass of the blade with its piston", OURS),
            p("blade_velocity_m_s", "m/s", 0.0, Finite, "velocity of the blade at the start", OURS),
            p("actuator_length_m", "m", 1.5, Positive, "length of the actuator at the start", OURS),
            p("piston_area_m2", "m²", 2e-3, Positive, "piston area A", OURS),
            p("cylinder_length_m", "m", 1.0, Positive, "length l of both chambers together", OURS),
            p("viscous_friction_n_s_m", "N·s/m", 1e4, NotNegative, "viscous friction c of the cylinder", OURS),
            p("valve_area_m2", "m²", 1e-5, Positive, "valve area a_v", OURS),
            p("start_pressure_pa", "Pa", 3.85e6, Positive, "pressure in both chambers at the start", OURS),
            p("spool_push", "-", 0.3, Fraction, "spool command while pushing; below 0.5 extends", OURS),
            p("push_start_s", "s", 0.1, NotNegative, "start of pushing", OURS),
            p("spool_ramp_s", "s", 0.05, Positive, "time in which the spool moves", OURS),
        ],
        fluid::parameters(),
        vec![
            p("gravity_m_s2", "m/s²", 9.81, NotNegative, "gravity", "standard"),
            contact_parameters::stabilisation(),
            p("restitution", "-", 0.0, Fraction, "restitution e of all contacts", OURS),
            p("wall_gap_m", "m", 0.02, Finite, "distance of the wall from the discs at the start", OURS),
        ],
    ]
    .concat()
}

/// Both sides for discs with these centres; the wall stands behind the last of them.
pub(super) fn build(
    parameters: &Parameters,
    solver: &SolverEntry,
    centres: Vec<[f64; 2]>,
    list: ContactList,
) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let radius = get("disc_radius_m");
    let last = centres.iter().map(|centre| centre[0]).fold(f64::NEG_INFINITY, f64::max);
    let length = get("actuator_length_m");
    let geometry = DiscsGeometry {
        blade_mass: get("blade_mass_kg"),
        blade_velocity: get("blade_velocity_m_s"),
        disc_mass: get("disc_mass_kg"),
        radius,
        wall_x: last + radius + get("wall_gap_m"),
        actuator_length: length,
        gravity: get("gravity_m_s2"),
        centres,
        bumps: Vec::new(),
    };
    let model = Discs::new(geometry, list)?;
    let (start, ramp) = (get("push_start_s"), get("spool_ramp_s"));
    let spool = hydraulics::spool(&[("push_start_s", start, 0.5), ("spool_ramp_s", start + ramp, get("spool_push"))])?;
    let cylinder = hydraulics::cylinder(parameters, length, [get("start_pressure_pa"); 2], spool)?;
    contact_parameters::coupled(model, cylinder, parameters, solver)
}

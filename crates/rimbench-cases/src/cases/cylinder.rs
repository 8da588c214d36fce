//! The hydraulic cylinder as parameters, shared by the contact cases that have one.

use super::case::{CoupledSystem, InterfaceColumns};
use super::contact_parameters;
use super::fluid::{self, NAYA};
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{HydraulicCylinder, Spool, SupportedBox};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::{Error, Result};
use rimbench_core::name::{Name, names};

const OURS: &str = "as in the wedge box";

/// The interface of a cylinder and what it pushes.
pub(super) fn interface() -> InterfaceColumns {
    InterfaceColumns::new("actuator_length_m", "actuator_velocity_m_s", "actuator_force_n")
}

/// The columns of a trace: time, those of the case's own, the cylinder with the mass that it feels, and what else the case has, contacts
/// for the most part.
pub(super) fn trace_columns(own: &[&'static str], contacts: &[&'static str]) -> Vec<Name> {
    const SHARED: [&str; 7] = [
        "actuator_length_m",
        "actuator_velocity_m_s",
        "actuator_force_n",
        "force_to_mechanics_n",
        "pressure_1_pa",
        "pressure_2_pa",
        "effective_mass_kg",
    ];
    names(&[&["time_s"], own, &SHARED, contacts].concat())
}

/// Cylinder, valve with its ramp, and fluid.
pub(super) fn parameters(length: f64, friction: f64, spool_final: f64) -> Vec<Parameter> {
    use Range::{Fraction, NotNegative, Positive};
    [
        vec![
            p("piston_area_m2", "m²", 0.0065, Positive, "piston area A", NAYA),
            p("cylinder_length_m", "m", length, Positive, "length l of both chambers together", OURS),
            p("viscous_friction_n_s_m", "N·s/m", friction, NotNegative, "viscous friction c of the cylinder", OURS),
            p("valve_area_m2", "m²", 5e-5, Positive, "valve area a_v", OURS),
            p("spool_start", "-", 0.5, Fraction, "spool command at the start", OURS),
            p("spool_final", "-", spool_final, Fraction, "spool command after its ramp; below 0.5 extends", OURS),
            p("spool_ramp_start_s", "s", 0.1, NotNegative, "start of the spool's ramp", OURS),
            p("spool_ramp_end_s", "s", 0.2, NotNegative, "end of the spool's ramp", OURS),
            p("start_pressure_pa", "Pa", 3.85e6, Positive, "pressure in both chambers at the start", OURS),
        ],
        fluid::parameters(),
    ]
    .concat()
}

/// The ramp of the spool as the parameters say.
///
/// # Errors
/// [`Error::InvalidValue`] for a ramp that ends before it starts.
pub(super) fn ramp(parameters: &Parameters) -> Result<Spool> {
    let get = |name: &str| parameters.number(name);
    let (start, end) = (get("spool_ramp_start_s"), get("spool_ramp_end_s"));
    if end < start {
        return Err(Error::invalid("spool_ramp_end_s", end, format!("at least spool_ramp_start_s = {start}")));
    }
    Ok(Spool::new(vec![(start, get("spool_start")), (end, get("spool_final"))]))
}

/// The cylinder as the parameters say, its piston in the middle at `start_length` (m).
///
/// # Errors
/// Those of [`ramp`]; [`Error::InvalidValue`] for a stroke that would retract the actuator through its fixed end.
fn of(parameters: &Parameters, start_length: f64) -> Result<HydraulicCylinder> {
    let (spool, length) = (ramp(parameters)?, parameters.number("cylinder_length_m"));
    if 0.5 * length > start_length {
        let expected = format!(
            "at most {:.6} m: fully retracted, the actuator would be shorter than nothing from its start length {start_length:.6} m",
            2.0 * start_length
        );
        return Err(Error::invalid("cylinder_length_m", length, expected));
    }
    let pressures = [parameters.number("start_pressure_pa"); 2];
    Ok(hydraulics::of_any_stroke(parameters, start_length, pressures, spool))
}

/// A box with the cylinder at its attachment.
pub(super) fn system(model: SupportedBox, parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let cylinder = of(parameters, model.start_length())?;
    contact_parameters::coupled(model, cylinder, parameters, solver)
}

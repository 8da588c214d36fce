//! The hydraulic cylinder as parameters, shared by the contact cases that have one.

use super::case::CoupledSystem;
use super::contact_parameters;
use super::driven_mass::mirrored;
use super::fluid::{self, NAYA};
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::complementarity::SolverEntry;
use crate::cosim::Subsystem;
use crate::error::{Error, Result};
use crate::mechanics::{MechanicalModel, NonSmoothMechanics};
use crate::models::{CylinderParameters, HydraulicCylinder, Spool, SupportedBox};

const OURS: &str = "as in the wedge box";

pub(super) const PISTON_AREA: Parameter = p("piston_area_m2", "m²", 0.0065, Range::Positive, "piston area A", NAYA);
pub(super) const VALVE_AREA: Parameter = p("valve_area_m2", "m²", 5e-5, Range::Positive, "valve area a_v", OURS);
pub(super) const START_PRESSURE: Parameter =
    p("start_pressure_pa", "Pa", 3.85e6, Range::Positive, "pressure in both chambers at the start", OURS);
pub(super) const SPOOL_START: Parameter =
    p("spool_start", "-", 0.5, Range::Fraction, "spool command at the start", OURS);
pub(super) const RAMP_START: Parameter =
    p("spool_ramp_start_s", "s", 0.1, Range::NotNegative, "start of the spool's ramp", OURS);
pub(super) const RAMP_END: Parameter =
    p("spool_ramp_end_s", "s", 0.2, Range::NotNegative, "end of the spool's ramp", OURS);

pub(super) const fn length(default: f64) -> Parameter {
    p("cylinder_length_m", "m", default, Range::Positive, "length l of both chambers together", OURS)
}

pub(super) const fn friction(default: f64) -> Parameter {
    let about = "viscous friction c of the cylinder";
    p("viscous_friction_n_s_m", "N·s/m", default, Range::NotNegative, about, OURS)
}

pub(super) const fn spool_final(default: f64) -> Parameter {
    let about = "spool command after its ramp; below 0.5 extends";
    p("spool_final", "-", default, Range::Fraction, about, OURS)
}

/// The cylinder as the parameters say, its piston in the middle at `start_length` (m).
///
/// # Errors
/// [`Error::InvalidValue`] for a stroke that would retract the actuator through its fixed end, or a ramp that ends before it
/// starts.
pub(super) fn of(parameters: &Parameters, start_length: f64) -> Result<HydraulicCylinder> {
    let get = |name: &str| parameters.number(name);
    let (ramp_start, ramp_end, length) = (get("spool_ramp_start_s"), get("spool_ramp_end_s"), get("cylinder_length_m"));
    if ramp_end < ramp_start {
        let expected = format!("at least spool_ramp_start_s = {ramp_start}");
        return Err(Error::invalid("spool_ramp_end_s", ramp_end, expected));
    }
    if 0.5 * length > start_length {
        let expected = format!(
            "at most {:.6} m: fully retracted, the actuator would be shorter than nothing from its start length {start_length:.6} m",
            2.0 * start_length
        );
        return Err(Error::invalid("cylinder_length_m", length, expected));
    }
    Ok(HydraulicCylinder::new(
        fluid::of(parameters),
        CylinderParameters {
            piston_area: get("piston_area_m2"),
            cylinder_length: length,
            start_length,
            viscous_friction: get("viscous_friction_n_s_m"),
            valve_area: get("valve_area_m2"),
            start_pressures: [get("start_pressure_pa"); 2],
        },
        Spool::new(vec![(ramp_start, get("spool_start")), (ramp_end, get("spool_final"))]),
    ))
}

/// A box with the cylinder at its attachment.
pub(super) fn system(model: SupportedBox, parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let cylinder = of(parameters, model.start_length())?;
    let checked = solver.checked(model.size().unilateral);
    let law = contact_parameters::law(parameters);
    let mechanics = NonSmoothMechanics::new(model, law, mirrored(cylinder.ports()), checked);
    Ok(CoupledSystem::new(Box::new(mechanics), Box::new(cylinder)))
}

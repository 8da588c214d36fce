//! The hydraulic cylinder of a case from its parameters, and what the cases check of it.

use super::fluid;
use super::parameters::Parameters;
use crate::models::{CylinderParameters, HydraulicCylinder, Spool};
use rimbench_core::error::{Error, Result};

/// A cylinder that starts with its piston in the middle, at the actuator's start length (m).
///
/// # Errors
/// [`Error::InvalidValue`] if the actuator starts so short that its own stroke does not fit into it.
pub(super) fn cylinder(
    parameters: &Parameters,
    start_length: f64,
    start_pressures: [f64; 2],
    spool: Spool,
) -> Result<HydraulicCylinder> {
    let length = parameters.number("cylinder_length_m");
    if 0.5 * length >= start_length {
        let expected = format!(
            "below {:.6}: the actuator starts {start_length:.6} m long and moves by half of its stroke",
            2.0 * start_length
        );
        return Err(Error::invalid("cylinder_length_m", length, expected));
    }
    Ok(of_any_stroke(parameters, start_length, start_pressures, spool))
}

/// The same, whatever its stroke.
pub(super) fn of_any_stroke(
    parameters: &Parameters,
    start_length: f64,
    start_pressures: [f64; 2],
    spool: Spool,
) -> HydraulicCylinder {
    let get = |name: &str| parameters.number(name);
    let cylinder = CylinderParameters {
        piston_area: get("piston_area_m2"),
        cylinder_length: get("cylinder_length_m"),
        start_length,
        viscous_friction: get("viscous_friction_n_s_m"),
        valve_area: get("valve_area_m2"),
        start_pressures,
    };
    HydraulicCylinder::new(fluid::of(parameters), cylinder, spool)
}

/// A spool command through points (parameter that sets the time, time in s, κ).
///
/// # Errors
/// [`Error::InvalidValue`] naming the first time that lies before the one above it; [`Error::Incompatible`] for a κ outside [0, 1].
pub(super) fn spool(points: &[(&str, f64, f64)]) -> Result<Spool> {
    for pair in points.windows(2) {
        let [(_, earlier, _), (key, later, _)] = [pair[0], pair[1]];
        if later < earlier {
            return Err(Error::invalid(key, later, format!("at least {earlier}, when the movement before it ends")));
        }
    }
    if let Some((key, _, kappa)) = points.iter().find(|(_, _, kappa)| !(0.0..=1.0).contains(kappa)) {
        return Err(Error::Incompatible(format!("the spool would go to {kappa:.4} at {key}, outside [0, 1]")));
    }
    Ok(Spool::new(points.iter().map(|&(_, time, kappa)| (time, kappa)).collect()))
}

/// Pressures that hold a force (N) at rest, and the spool that keeps both.
///
/// ```text
/// p₁,₂ = ½(p_P + p_T) ∓ F/(2A)        κ₀ = √(p₁ − p_T) / (√(p_P − p₁) + √(p₁ − p_T))
/// ```
/// # Errors
/// [`Error::Incompatible`] if that takes pressures outside those of tank and pump.
pub(super) fn equilibrium(parameters: &Parameters, force: f64) -> Result<([f64; 2], f64)> {
    let get = |name: &str| parameters.number(name);
    let (supply, tank) = (get("supply_pressure_pa"), get("tank_pressure_pa"));
    let (mean, half) = (0.5 * (supply + tank), 0.5 * force / get("piston_area_m2"));
    let pressures = [mean - half, mean + half];
    if pressures.iter().any(|p| !(tank..=supply).contains(p)) {
        return Err(Error::Incompatible(format!(
            "holding {force:.0} N needs chamber pressures of {:.0} and {:.0} Pa, outside tank ({tank} Pa) and pump ({supply} Pa)",
            pressures[0], pressures[1]
        )));
    }
    let (rise, fall) = ((supply - pressures[0]).sqrt(), (pressures[0] - tank).sqrt());
    Ok((pressures, fall / (rise + fall)))
}

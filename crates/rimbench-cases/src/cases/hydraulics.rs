//! The hydraulic cylinder with its fluid and valve as parameters, and what the cases check of it.

use super::prelude::*;

/// The interface of a cylinder and what it pushes.
pub(super) fn interface() -> Vec<InterfaceColumns> {
    vec![InterfaceColumns::new("actuator_length_m", "actuator_velocity_m_s", "actuator_force_n")]
}

/// The columns of a trace: time, those of the case's own, the cylinder with the mass that it feels, and what else the case has, contacts
/// for the most part.
pub(super) fn trace_columns(own: &'static str, contacts: &'static str) -> Vec<Name> {
    let shared = "actuator_length_m actuator_velocity_m_s actuator_force_n force_to_mechanics_n pressure_1_pa \
                  pressure_2_pa effective_mass_kg";
    [words("time_s"), words(own), words(shared), words(contacts)].concat()
}

pub(super) const FLUID: &str = "source: Naya et al. 2011
    discharge_coefficient | - | 0.67 | positive | discharge coefficient c_d
    fluid_density_kg_m3 | kg/m³ | 850.0 | positive | fluid density ρ
    supply_pressure_pa | Pa | 7.6e6 | positive | pump pressure p_P
    tank_pressure_pa | Pa | 1e5 | not negative | tank pressure p_T
    compressibility_a_1_pa | 1/Pa | 6.53e-10 | positive | fluid compressibility a
    compressibility_b_1_pa2 | 1/Pa² | -1.19e-18 | finite | fluid compressibility b
";

/// A cylinder and its valve with a ramp, those of the wedge box.
pub(super) const CYLINDER: &str = "source: as in the wedge box
    piston_area_m2 | m² | 0.0065 | positive | piston area A | Naya et al. 2011
    cylinder_length_m | m | 2.0 | positive | length l of both chambers together
    viscous_friction_n_s_m | N·s/m | 1e4 | not negative | viscous friction c of the cylinder
    valve_area_m2 | m² | 5e-5 | positive | valve area a_v
    spool_start | - | 0.5 | fraction | spool command at the start
    spool_final | - | 0.2 | fraction | spool command after its ramp; below 0.5 extends
    spool_ramp_start_s | s | 0.1 | not negative | start of the spool's ramp
    spool_ramp_end_s | s | 0.2 | not negative | end of the spool's ramp
    start_pressure_pa | Pa | 3.85e6 | positive | pressure in both chambers at the start
";

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

/// The cylinder with the ramp of its spool, as the parameters say.
///
/// # Errors
/// Those of [`ramp`] and of [`cylinder`].
pub(super) fn ramped_cylinder(parameters: &Parameters, start_length: f64) -> Result<HydraulicCylinder> {
    cylinder(parameters, start_length, [parameters.number("start_pressure_pa"); 2], ramp(parameters)?)
}

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
    let fluid = Fluid {
        discharge_coefficient: get("discharge_coefficient"),
        density: get("fluid_density_kg_m3"),
        supply_pressure: get("supply_pressure_pa"),
        tank_pressure: get("tank_pressure_pa"),
        compressibility_a: get("compressibility_a_1_pa"),
        compressibility_b: get("compressibility_b_1_pa2"),
    };
    HydraulicCylinder::new(fluid, cylinder, spool)
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

/// A spool at rest at `centre` that goes, within `spool_ramp_s` from each of these times on (parameters), to so many times `spool_change` away
/// from it.
///
/// # Errors
/// Those of [`spool`].
pub(super) fn moved_spool(parameters: &Parameters, centre: f64, moves: &[(&str, f64)]) -> Result<Spool> {
    let [change, ramp] = ["spool_change", "spool_ramp_s"].map(|name| parameters.number(name));
    let mut at = centre;
    let points = moves.iter().flat_map(|&(key, times)| {
        let (start, from) = (parameters.number(key), at);
        at = centre + times * change;
        [(key, start, from), (key, start + ramp, at)]
    });
    spool(&points.collect::<Vec<_>>())
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

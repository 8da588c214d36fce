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

parameters! {
    /// The fluid with its pump and tank.
    pub struct Oil from "Naya et al. 2011" {
        discharge_coefficient: f64 = 0.67, Positive, "discharge coefficient c_d";
        fluid_density_kg_m3: f64 = 850.0, Positive, "fluid density ρ";
        supply_pressure_pa: f64 = 7.6e6, Positive, "pump pressure p_P";
        tank_pressure_pa: f64 = 1e5, NotNegative, "tank pressure p_T";
        compressibility_a_1_pa: f64 = 6.53e-10, Positive, "fluid compressibility a" study 4e-10..1.5e-9;
        compressibility_b_1_pa2: f64 = -1.19e-18, Finite, "fluid compressibility b";
    }
}
parameters! {
    /// A cylinder and its valve, by default those of the wedge box.
    pub struct Cylinder from "as in the wedge box" {
        piston_area_m2: f64 = 0.0065, Positive, "piston area A" from "Naya et al. 2011";
        cylinder_length_m: f64 = 2.0, Positive, "length l of both chambers together";
        viscous_friction_n_s_m: f64 = 1e4, NotNegative, "viscous friction c of the cylinder" study 3e3..3e4;
        valve_area_m2: f64 = 5e-5, Positive, "valve area a_v" study 2e-5..1e-4;
    }
}
parameters! {
    /// A ramp of the spool, and the pressure before it.
    pub(super) struct Ramp from "as in the wedge box" {
        spool_start: f64 = 0.5, Fraction, "spool command at the start";
        spool_final: f64 = 0.2, Fraction, "spool command after its ramp; below 0.5 extends" study 0.0..0.4;
        spool_ramp_start_s: f64 = 0.1, NotNegative, "start of the spool's ramp";
        spool_ramp_end_s: f64 = 0.2, NotNegative, "end of the spool's ramp";
        start_pressure_pa: f64 = 3.85e6, Positive, "pressure in both chambers at the start";
    }
}

impl Ramp {
    /// The spool.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a ramp that ends before it starts.
    pub(super) fn spool(&self) -> Result<Spool> {
        let (start, end) = (self.spool_ramp_start_s, self.spool_ramp_end_s);
        if end < start {
            return Err(Error::invalid("spool_ramp_end_s", end, format!("at least spool_ramp_start_s = {start}")));
        }
        Ok(Spool::new(vec![(start, self.spool_start), (end, self.spool_final)]))
    }

    /// Pressures of both chambers at the start, Pa.
    pub(super) fn start_pressures(&self) -> [f64; 2] {
        [self.start_pressure_pa; 2]
    }
}

impl Cylinder {
    /// A cylinder that starts with its piston in the middle, at the actuator's start length (m).
    ///
    /// # Errors
    /// [`Error::InvalidValue`] if the actuator starts so short that its own stroke does not fit into it.
    pub(super) fn starting_at(
        &self,
        start_length: f64,
        oil: &Oil,
        start_pressures: [f64; 2],
        spool: Spool,
    ) -> Result<HydraulicCylinder> {
        if 0.5 * self.cylinder_length_m >= start_length {
            let expected = format!(
                "below {:.6}: the actuator starts {start_length:.6} m long and moves by half of its stroke",
                2.0 * start_length
            );
            return Err(Error::invalid("cylinder_length_m", self.cylinder_length_m, expected));
        }
        Ok(self.of_any_stroke(start_length, oil, start_pressures, spool))
    }

    /// A cylinder whose stroke is not checked.
    pub(super) fn of_any_stroke(
        &self,
        start_length: f64,
        oil: &Oil,
        start_pressures: [f64; 2],
        spool: Spool,
    ) -> HydraulicCylinder {
        let cylinder = CylinderParameters {
            piston_area: self.piston_area_m2,
            cylinder_length: self.cylinder_length_m,
            start_length,
            viscous_friction: self.viscous_friction_n_s_m,
            valve_area: self.valve_area_m2,
            start_pressures,
        };
        let fluid = Fluid {
            discharge_coefficient: oil.discharge_coefficient,
            density: oil.fluid_density_kg_m3,
            supply_pressure: oil.supply_pressure_pa,
            tank_pressure: oil.tank_pressure_pa,
            compressibility_a: oil.compressibility_a_1_pa,
            compressibility_b: oil.compressibility_b_1_pa2,
        };
        HydraulicCylinder::new(fluid, cylinder, spool)
    }

    /// Pressures that hold a force (N) at rest, and the spool that keeps both.
    ///
    /// ```text
    /// p₁,₂ = ½(p_P + p_T) ∓ F/(2A)        κ₀ = √(p₁ − p_T) / (√(p_P − p₁) + √(p₁ − p_T))
    /// ```
    /// # Errors
    /// [`Error::Incompatible`] if that takes pressures outside those of tank and pump.
    pub(super) fn equilibrium(&self, oil: &Oil, force: f64) -> Result<([f64; 2], f64)> {
        let (supply, tank) = (oil.supply_pressure_pa, oil.tank_pressure_pa);
        let (mean, half) = (0.5 * (supply + tank), 0.5 * force / self.piston_area_m2);
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

/// A spool at rest at `centre` that goes, within a time (s) from each of these on (name and value of a parameter), to so many times `change`
/// away from it.
///
/// # Errors
/// Those of [`spool`].
pub(super) fn moved_spool(centre: f64, change: f64, ramp: f64, moves: &[((&'static str, f64), f64)]) -> Result<Spool> {
    let mut at = centre;
    let points = moves.iter().flat_map(|&((key, start), times)| {
        let from = at;
        at = centre + times * change;
        [(key, start, from), (key, start + ramp, at)]
    });
    spool(&points.collect::<Vec<_>>())
}

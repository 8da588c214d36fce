//! The hydraulic cylinder with its fluid and valve as parameters, and what the cases check of it.

use super::prelude::*;

/// The interface of a cylinder and what it pushes.
pub(super) fn interface() -> Vec<InterfaceColumns> {
    vec![InterfaceColumns::new("actuator_length_m", "actuator_velocity_m_s", "actuator_force_n")]
}

/// The columns of a trace of a cylinder and the mass that it feels.
pub(super) fn trace_columns(own: &str, more: &str) -> Vec<Name> {
    trace_of(&interface(), own, &[], &format!("pressure_1_pa pressure_2_pa effective_mass_kg {more}"))
}

parameters! {
    /// A ramp of the spool, and the pressure before it.
    pub(super) struct Ramp from "as in the wedge box" {
        spool_start: f64 = 0.5, Fraction, "spool command at the start";
        spool_final: f64 = 0.2, Fraction, "spool command after its ramp; below 0.5 extends".study(0.0..0.4);
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

/// A spool command through points (parameter that sets the time, time in s, κ).
///
/// # Errors
/// [`Error::InvalidValue`] naming the first time that lies before the one above it; [`Error::Incompatible`] for a κ
/// outside [0, 1].
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

/// A spool at rest at `centre` that goes, within a time (s) from each of these on (name and value of a parameter), to
/// so many times `change` away from it.
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

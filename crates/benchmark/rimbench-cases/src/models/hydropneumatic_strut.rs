//! A hydropneumatic strut: a piston that pumps oil through an orifice into an accumulator with a gas cushion.

use super::spring_actuator::force_ports;
use crate::parameter::parameters;
use rimbench_core::cosim::{
    Capabilities, EnergyAccount, NO_CONTACTS, OutputRates, Ports, SecondOrder, Subsystem, SubsystemCounters,
    subsystem_methods,
};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::name::Name;

parameters! {
    /// Sizes of a strut.
    pub struct Strut from "ours" {
        piston_area_m2: f64 = 1e-3, Positive, "piston area A of a strut";
        gas_volume_m3: f64 = 2e-4, Positive, "gas volume V₀ of a strut at the start";
        gas_exponent: f64 = 1.4, Positive, "polytropic exponent of the gas, above 1".from("adiabatic, two-atomic gas");
        strut_damping_n_s_m: f64 = 1500.0, NotNegative, "damping c of a strut's orifice";
    }
}

/// A strut as an actuator, which carries a load on gas and damps with oil that is incompressible. The force depends
/// directly on the velocity.
///
#[doc = include_str!("strut.md")]
/// # Outcomes
/// [`Cause::OutOfRange`](rimbench_core::error::Cause::OutOfRange) when the gas volume falls to zero: the piston has
/// reached the end of its stroke.
/// # Source
/// Textbook gas spring (for example Bauer, *Hydropneumatic Suspension Systems*, 2011).
#[derive(Debug, Clone, PartialEq)]
pub struct HydropneumaticStrut {
    parameters: Strut,
    start_pressure: f64,
    /// V, m³.
    volume: f64,
    ports: Ports,
    counters: SubsystemCounters,
    account: EnergyAccount,
}

impl HydropneumaticStrut {
    /// Builds the strut, which carries a force (N) at rest at the start.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if it would have to pull at the start (gas cannot), or the exponent is not above 1.
    pub fn new(parameters: Strut, start_force: f64) -> Result<Self> {
        if start_force <= 0.0 {
            let message = format!("a strut would have to carry {start_force:.1} N at the start; gas can only push");
            return Err(Error::Incompatible(message));
        }
        if parameters.gas_exponent <= 1.0 {
            return Err(Error::invalid("gas_exponent", parameters.gas_exponent, "a number above 1"));
        }
        Ok(HydropneumaticStrut {
            start_pressure: start_force / parameters.piston_area_m2,
            volume: parameters.gas_volume_m3,
            ports: force_ports("actuator_length_m", "actuator_velocity_m_s"),
            counters: SubsystemCounters::default(),
            account: EnergyAccount::default(),
            parameters,
        })
    }

    fn pressure(&self) -> f64 {
        let p = &self.parameters;
        self.start_pressure * libm::pow(p.gas_volume_m3 / self.volume, p.gas_exponent)
    }

    /// Returns the stiffness of the gas, N/m: `κ p A²/V`.
    pub fn stiffness(&self) -> f64 {
        let p = &self.parameters;
        p.gas_exponent * self.pressure() * p.piston_area_m2 * p.piston_area_m2 / self.volume
    }

    /// Energy of the gas, J: `p V/(κ − 1)`.
    fn gas_energy(&self) -> f64 {
        self.pressure() * self.volume / (self.parameters.gas_exponent - 1.0)
    }
}

impl Subsystem for HydropneumaticStrut {
    subsystem_methods!(ports capabilities counters clone);

    #[inline]
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        y[0] = self.pressure() * self.parameters.piston_area_m2 - self.parameters.strut_damping_n_s_m * u[1];
        Ok(())
    }

    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let (swept, push) = (h * u[1], self.pressure() * self.parameters.piston_area_m2);
        let before = self.gas_energy();
        self.volume += self.parameters.piston_area_m2 * swept;
        if self.volume.is_nan() {
            return Err(Failure::non_finite("gas_volume_m3"));
        }
        if self.volume <= 0.0 {
            return Err(Failure::out_of_range("gas_volume_m3", self.volume));
        }
        let (change, friction) = (self.gas_energy() - before, self.parameters.strut_damping_n_s_m * u[1] * swept);
        self.account.stored += change;
        self.account.viscous += friction;
        self.account.interface -= push * swept - friction;
        // Euler's straight line through the curved energy of the gas.
        self.account.integration += change + push * swept;
        self.counters.micro_steps += 1;
        Ok(())
    }
}

impl Capabilities for HydropneumaticStrut {
    fn output_rates(&mut self, _t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        let stiffness = self.stiffness();
        rates.rate[0] = -stiffness * u[1];
        rates.feedthrough.copy_from_slice(&[0.0, -self.parameters.strut_damping_n_s_m]);
        rates.rate_gain.copy_from_slice(&[0.0, -stiffness]);
        Ok(true)
    }

    /// The volume follows the mean velocity exactly as it is.
    fn use_second_order(&mut self, rule: SecondOrder) -> Result<(), &'static str> {
        if rule == SecondOrder::Midpoint { Ok(()) } else { Err(NO_CONTACTS) }
    }

    fn observables(&mut self) -> &[Name] {
        &[Name::Borrowed("gas_pressure_pa")]
    }

    fn observe(&mut self, _h: f64, row: &mut [f64]) {
        row[0] = self.pressure();
    }

    fn energy_account(&mut self) -> Option<EnergyAccount> {
        Some(self.account)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::ParameterSet;

    #[test]
    fn a_slow_compression_stores_the_work_done_and_stiffens_as_the_gas_law_says() {
        let undamped = Strut { strut_damping_n_s_m: 0.0, ..Strut::defaults() };
        let mut strut = HydropneumaticStrut::new(undamped, 2500.0).unwrap();
        approx::assert_relative_eq!(strut.stiffness(), 1.4 * 2500.0 * 1e-3 / 2e-4, max_relative = 1e-14);
        // 5 cm in, 100 000 steps: V falls to 1.5e-4 m³.
        let (n, h) = (100_000, 1e-5);
        (0..n).for_each(|_| strut.step(0.0, &[0.0, -0.05], h).unwrap());
        let mut force = [0.0];
        strut.outputs(&[0.0, 0.0], &mut force).unwrap();
        approx::assert_relative_eq!(force[0], 2500.0 * libm::pow(4.0_f64 / 3.0, 1.4), max_relative = 1e-9);
        let work = 2.5e6 * 2e-4 / 0.4 * (libm::pow(4.0_f64 / 3.0, 0.4) - 1.0);
        let account = strut.energy_account().unwrap();
        approx::assert_relative_eq!(account.stored, work, max_relative = 1e-9);
        // Explicit Euler errs by half a step's change of the force: 5e-7 m × (3740 − 2500) N/2.
        assert!(account.integration.abs() < 5e-7 * 620.0 * 1.01, "{}", account.integration);
        assert!(account.closure().abs() < 1e-9);
        let empty = strut.step(0.0, &[0.0, -1e3], 1.0);
        assert!(empty.is_err_and(|failure| failure.to_string().starts_with("gas_volume_m3 =")));
        assert!(HydropneumaticStrut::new(undamped, -1.0).is_err());
    }
}

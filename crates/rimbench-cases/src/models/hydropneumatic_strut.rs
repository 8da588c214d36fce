//! A hydropneumatic strut: a piston that pumps oil through an orifice into an accumulator with a gas cushion.

use super::spring_actuator::force_ports;
use rimbench_core::cosim::{
    Capabilities, EnergyAccount, NO_CONTACTS, OutputRates, Ports, SecondOrder, Subsystem, SubsystemCounters,
    subsystem_methods,
};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::name::Name;

/// Sizes and start of a [`HydropneumaticStrut`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrutParameters {
    /// Piston area `A`, m².
    pub piston_area: f64,
    /// Gas volume at the start `V₀`, m³.
    pub gas_volume: f64,
    /// Polytropic exponent κ > 1.
    pub exponent: f64,
    /// Damping of the orifice `c`, N·s/m, referred to the piston.
    pub damping: f64,
    /// Force it carries at rest at the start, N.
    pub start_force: f64,
}

/// A strut as an actuator: length and velocity in, force out. It carries a load on gas and damps with oil.
///
/// ```text
/// F = A p − c ṡ        p = p₀ (V₀/V)^κ        V̇ = A ṡ
/// ```
/// `F > 0` extends; it depends directly on `ṡ`. The oil is incompressible. Explicit Euler at the micro step.
/// # Outcomes
/// [`Cause::OutOfRange`](rimbench_core::error::Cause::OutOfRange) when the gas volume falls to zero: the piston has reached the end of its stroke.
/// # Source
/// Textbook gas spring (for example Bauer, *Hydropneumatic Suspension Systems*, 2011).
#[derive(Debug, Clone, PartialEq)]
pub struct HydropneumaticStrut {
    parameters: StrutParameters,
    start_pressure: f64,
    /// V, m³.
    volume: f64,
    ports: Ports,
    counters: SubsystemCounters,
    account: EnergyAccount,
}

impl HydropneumaticStrut {
    /// Builds the strut.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if it would have to pull at the start (gas cannot), or the exponent is not above 1.
    pub fn new(parameters: StrutParameters) -> Result<Self> {
        if parameters.start_force <= 0.0 {
            return Err(Error::Incompatible(format!(
                "a strut would have to carry {:.1} N at the start; gas can only push",
                parameters.start_force
            )));
        }
        if parameters.exponent <= 1.0 {
            return Err(Error::invalid("gas_exponent", parameters.exponent, "a number above 1"));
        }
        Ok(HydropneumaticStrut {
            start_pressure: parameters.start_force / parameters.piston_area,
            volume: parameters.gas_volume,
            ports: force_ports("actuator_length_m", "actuator_velocity_m_s"),
            counters: SubsystemCounters::default(),
            account: EnergyAccount::default(),
            parameters,
        })
    }

    /// Stiffness at the start, N/m: `κ p₀ A²/V₀`.
    pub fn stiffness(&self) -> f64 {
        self.gas_stiffness()
    }

    fn pressure(&self) -> f64 {
        let p = &self.parameters;
        self.start_pressure * libm::pow(p.gas_volume / self.volume, p.exponent)
    }

    fn gas_stiffness(&self) -> f64 {
        let p = &self.parameters;
        p.exponent * self.pressure() * p.piston_area * p.piston_area / self.volume
    }

    /// Energy of the gas, J: `p V/(κ − 1)`.
    fn gas_energy(&self) -> f64 {
        self.pressure() * self.volume / (self.parameters.exponent - 1.0)
    }
}

impl Subsystem for HydropneumaticStrut {
    subsystem_methods!(ports capabilities counters clone);

    #[inline]
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        y[0] = self.pressure() * self.parameters.piston_area - self.parameters.damping * u[1];
        Ok(())
    }

    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let (swept, push) = (h * u[1], self.pressure() * self.parameters.piston_area);
        let before = self.gas_energy();
        self.volume += self.parameters.piston_area * swept;
        if self.volume.is_nan() {
            return Err(Failure::non_finite("gas_volume_m3"));
        }
        if self.volume <= 0.0 {
            return Err(Failure::out_of_range("gas_volume_m3", self.volume));
        }
        let (change, friction) = (self.gas_energy() - before, self.parameters.damping * u[1] * swept);
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
        let stiffness = self.gas_stiffness();
        rates.rate[0] = -stiffness * u[1];
        rates.feedthrough.copy_from_slice(&[0.0, -self.parameters.damping]);
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

    #[test]
    fn a_slow_compression_stores_the_work_done_and_stiffens_as_the_gas_law_says() {
        let start =
            StrutParameters { piston_area: 1e-3, gas_volume: 2e-4, exponent: 1.4, damping: 0.0, start_force: 2500.0 };
        let mut strut = HydropneumaticStrut::new(start).unwrap();
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
        assert!(HydropneumaticStrut::new(StrutParameters { start_force: -1.0, ..start }).is_err());
    }

    #[test]
    fn output_rates_are_the_differences_of_forces() {
        let start =
            StrutParameters { piston_area: 1e-3, gas_volume: 2e-4, exponent: 1.4, damping: 900.0, start_force: 2500.0 };
        let strut = HydropneumaticStrut::new(start).unwrap();
        let (u, h) = ([0.0, 0.2], 1e-6);
        let mut rates = OutputRates::zeros(1, 2);
        assert_eq!(strut.clone().output_rates(0.0, &u, &mut rates), Ok(true));
        let force = |strut: &HydropneumaticStrut, w: f64| {
            let mut y = [0.0];
            strut.clone().outputs(&[0.0, w], &mut y).unwrap();
            y[0]
        };
        let mut after = strut.clone();
        after.step(0.0, &u, h).unwrap();
        // Curvature of the gas law: (κ + 1)/2 · A h w/V = 1.2e-6 of the rate.
        approx::assert_relative_eq!((force(&after, 0.2) - force(&strut, 0.2)) / h, rates.rate[0], max_relative = 1e-5);
        approx::assert_relative_eq!(
            force(&strut, 1.2) - force(&strut, 0.2),
            rates.feedthrough[1],
            max_relative = 1e-12
        );
        approx::assert_relative_eq!(rates.rate[0], rates.rate_gain[1] * 0.2, max_relative = 1e-12);
    }
}

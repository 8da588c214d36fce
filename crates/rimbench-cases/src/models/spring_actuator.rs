//! A spring that pushes an interface from a carriage, which a moving base holds: the simplest actuator with a state.

use super::held_oscillator::{HeldOscillator, OscillatorIntegrator};
use rimbench_core::cosim::{
    Capabilities, InputPolynomials, NO_CONTACTS, OutputRates, Port, Ports, Quantity, SecondOrder, Subsystem,
    SubsystemCounters, subsystem_methods,
};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::name::Name;

/// Prescribed motion `x_b = x₀ + V t + A sin(ω t + φ)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BaseMotion {
    /// x₀, m.
    pub position: f64,
    /// V, m/s.
    pub velocity: f64,
    /// A, m.
    pub amplitude: f64,
    /// ω, rad/s.
    pub angular_frequency: f64,
    /// φ, rad.
    pub phase: f64,
}

impl BaseMotion {
    /// Returns position, velocity and acceleration at `t`: m, m/s, m/s².
    #[inline]
    pub fn at(&self, t: f64) -> [f64; 3] {
        let omega = self.angular_frequency;
        let (sine, cosine) = libm::sincos(omega * t + self.phase);
        let swing = self.amplitude * sine;
        [
            self.position + self.velocity * t + swing,
            self.velocity + self.amplitude * omega * cosine,
            -omega * omega * swing,
        ]
    }
}

/// Springs, masses and start of a [`SpringActuator`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpringActuatorParameters {
    /// k of the spring between carriage and interface, N/m.
    pub stiffness: f64,
    /// c of the damper beside it, N·s/m.
    pub damping: f64,
    /// m_a, kg; 0 fixes the carriage to the base.
    pub carriage_mass: f64,
    /// k_b of the spring between base and carriage, N/m.
    pub base_stiffness: f64,
    /// c_b of the damper beside it, N·s/m.
    pub base_damping: f64,
    /// Motion of the base.
    pub base: BaseMotion,
    /// Position (m) and velocity (m/s) of the carriage at the start.
    pub start: [f64; 2],
}

/// The actuator side of a co-simulation: interface position and velocity in, force out.
///
/// ```text
///   base ──k_b,c_b──[m_a]──k,c──• interface        F = k (x_a − s) + c (ẋ_a − ṡ)
///   x_b(t)           x_a        s                  m_a ẍ_a = k_b (x_b − x_a) + c_b (ẋ_b − ẋ_a) − F
/// ```
/// All springs are relaxed where the positions agree. `F > 0` pushes the interface along +s, and depends directly on `s`
/// and `ṡ`. Each micro step is exact for inputs that are polynomials of time, with the base where it is in the middle of the step. A carriage
/// without mass moves with the base.
#[derive(Debug, Clone)]
pub struct SpringActuator {
    parameters: SpringActuatorParameters,
    carriage: HeldOscillator,
    /// Time of the state, s.
    time: f64,
    inputs: InputPolynomials,
    ports: Ports,
    counters: SubsystemCounters,
}

/// Returns the ports of an actuator that answers position and velocity of the interface with a force at once.
pub(crate) fn force_ports(position: &'static str, velocity: &'static str) -> Ports {
    Ports {
        inputs: vec![Port::new(position, Quantity::Position), Port::new(velocity, Quantity::Velocity)],
        outputs: vec![Port::new("actuator_force_n", Quantity::Force)],
        direct_feedthrough: true,
    }
}

impl SpringActuator {
    /// The names of the observables.
    pub const OBSERVABLES: [Name; 2] = [Name::Borrowed("carriage_position_m"), Name::Borrowed("carriage_velocity_m_s")];

    /// Builds the actuator.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for a carriage that has mass, but no spring to the base where the base is to move it.
    pub fn new(parameters: SpringActuatorParameters) -> Result<Self> {
        let p = &parameters;
        if p.carriage_mass > 0.0 && p.base.amplitude != 0.0 && p.base_stiffness == 0.0 && p.base_damping == 0.0 {
            return Err(Error::Incompatible(format!(
                "the base moves by {} m, but neither base_stiffness_n_m nor base_damping_n_s_m joins it to the carriage",
                p.base.amplitude
            )));
        }
        let per_mass = |total: f64| if p.carriage_mass > 0.0 { total / p.carriage_mass } else { 0.0 };
        let carriage = HeldOscillator::new(
            per_mass(p.base_stiffness + p.stiffness),
            per_mass(p.base_damping + p.damping),
            p.start,
            OscillatorIntegrator::Exact,
        );
        let ports = force_ports("interface_position_m", "interface_velocity_m_s");
        let inputs = InputPolynomials::new(ports.inputs.len());
        Ok(SpringActuator { parameters, carriage, time: 0.0, inputs, ports, counters: SubsystemCounters::default() })
    }

    /// Returns position and velocity of the carriage, m, m/s.
    #[inline]
    pub fn carriage(&self) -> [f64; 2] {
        if self.parameters.carriage_mass > 0.0 {
            return [self.carriage.position(), self.carriage.velocity()];
        }
        let [position, velocity, _] = self.parameters.base.at(self.time);
        [position, velocity]
    }

    /// Acceleration that base and interface give the carriage while it is where the others are at zero, m/s².
    #[inline]
    fn load(&self, t: f64, u: &[f64]) -> f64 {
        let p = &self.parameters;
        let [position, velocity, _] = p.base.at(t);
        (p.base_stiffness * position + p.base_damping * velocity + p.stiffness * u[0] + p.damping * u[1])
            / p.carriage_mass
    }
}

impl Subsystem for SpringActuator {
    subsystem_methods!(ports capabilities counters clone);

    #[inline]
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        let [position, velocity] = self.carriage();
        y[0] = self.parameters.stiffness * (position - u[0]) + self.parameters.damping * (velocity - u[1]);
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        if self.parameters.carriage_mass > 0.0 {
            let p = &self.parameters;
            if let Some(course) = self.inputs.take() {
                let [position, velocity, _] = p.base.at(t + 0.5 * h);
                let base = p.base_stiffness * position + p.base_damping * velocity;
                let pull = |power: usize| p.stiffness * course[0][power] + p.damping * course[1][power];
                let load = [base + pull(0), pull(1), pull(2), pull(3)].map(|load| load / p.carriage_mass);
                self.carriage.advance_polynomial(load, h);
            } else {
                self.carriage.advance(self.load(t + 0.5 * h, u), h);
            }
        }
        self.time = t + h;
        self.counters.micro_steps += 1;
        let finite = self.carriage.is_finite();
        if finite { Ok(()) } else { Err(Failure::non_finite(Self::OBSERVABLES[0].clone())) }
    }
}

impl Capabilities for SpringActuator {
    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        let p = &self.parameters;
        let [_, velocity] = self.carriage();
        let (acceleration, per_mass) = if p.carriage_mass > 0.0 {
            (self.carriage.acceleration(self.load(t, u)), 1.0 / p.carriage_mass)
        } else {
            (p.base.at(t)[2], 0.0)
        };
        rates.rate[0] = p.stiffness * velocity + p.damping * acceleration;
        rates.feedthrough.copy_from_slice(&[-p.stiffness, -p.damping]);
        rates.rate_gain.copy_from_slice(&[p.damping * p.stiffness * per_mass, p.damping * p.damping * per_mass]);
        Ok(true)
    }

    fn input_polynomials(&mut self) -> Option<&mut InputPolynomials> {
        (self.parameters.carriage_mass > 0.0).then_some(&mut self.inputs)
    }

    /// Micro steps are exact for the mean input as they are.
    fn use_second_order(&mut self, rule: SecondOrder) -> Result<(), &'static str> {
        if rule == SecondOrder::Midpoint { Ok(()) } else { Err(NO_CONTACTS) }
    }

    fn observables(&mut self) -> &[Name] {
        &Self::OBSERVABLES
    }

    fn observe(&mut self, _h: f64, row: &mut [f64]) {
        row.copy_from_slice(&self.carriage());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters(carriage_mass: f64) -> SpringActuatorParameters {
        SpringActuatorParameters {
            stiffness: 300.0,
            damping: 4.0,
            carriage_mass,
            base_stiffness: 500.0,
            base_damping: 2.0,
            base: BaseMotion { position: 0.1, velocity: 0.0, amplitude: 0.05, angular_frequency: 12.0, phase: 0.4 },
            start: [0.1, 0.0],
        }
    }

    #[test]
    fn output_rates_are_the_differences_of_forces() {
        for mass in [0.7, 0.0] {
            let actuator = SpringActuator::new(parameters(mass)).unwrap();
            let (u, h) = ([0.08, 0.3], 1e-6);
            let force = |actuator: &SpringActuator, u: &[f64]| {
                let mut y = [0.0];
                actuator.clone().outputs(u, &mut y).unwrap();
                y[0]
            };
            let rate = |u: [f64; 2]| {
                let mut after = actuator.clone();
                after.step(0.0, &u, h).unwrap();
                (force(&after, &u) - force(&actuator, &u)) / h
            };
            let mut rates = OutputRates::zeros(1, 2);
            assert_eq!(actuator.clone().output_rates(0.0, &u, &mut rates), Ok(true));
            // One-sided difference: h/2 times the second rate, itself about ω_max² F with ω_max below 40 rad/s.
            approx::assert_relative_eq!(rates.rate[0], rate(u), epsilon = 1e-3 * rates.rate[0].abs());
            let gain = |ds: f64, dv: f64| rate([u[0] + ds, u[1] + dv]) - rate([u[0] - ds, u[1] - dv]);
            for (index, by) in [gain(0.5, 0.0), gain(0.0, 0.5)].into_iter().enumerate() {
                approx::assert_relative_eq!(
                    rates.rate_gain[index],
                    by,
                    epsilon = 1e-3 * rates.rate_gain[0].abs().max(1e-3)
                );
            }
        }
    }

    #[test]
    fn a_carriage_without_mass_moves_with_the_base() {
        let mut actuator = SpringActuator::new(parameters(0.0)).unwrap();
        actuator.step(0.0, &[0.0, 0.0], 0.25).unwrap();
        let expected = 0.1 + 0.05 * libm::sin(12.0_f64 * 0.25 + 0.4);
        approx::assert_relative_eq!(actuator.carriage()[0], expected, epsilon = 1e-15);
    }
}

//! A spring that pushes an interface from a carriage, which a moving base holds: the simplest actuator with a state.

use super::held_oscillator::{HeldOscillator, OscillatorIntegrator};
use crate::parameter::parameters;
use rimbench_core::cosim::{
    Capabilities, InputPolynomials, NO_CONTACTS, OutputRates, Port, Ports, Quantity, SecondOrder, Subsystem,
    SubsystemCounters, subsystem_methods,
};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::name::Name;
use std::f64::consts::TAU;

parameters! {
    /// A carriage on springs between what it pushes and a base that moves, `x_b = x₀ + A sin(ω t + φ)`.
    pub struct Carriage from "ours" {
        spring_stiffness_n_m: f64 = 0.0, NotNegative, "stiffness k between carriage and interface; 0 with no damping uncouples the two sides";
        spring_damping_n_s_m: f64 = 0.0, NotNegative, "damping c between carriage and interface";
        carriage_mass_kg: f64 = 0.0, NotNegative, "mass m_a of the carriage; 0 fixes it to the base";
        base_stiffness_n_m: f64 = 0.0, NotNegative, "stiffness k_b between base and carriage".when(&[["carriage_mass_kg", "> 0"]]);
        base_damping_n_s_m: f64 = 0.0, NotNegative, "damping c_b between base and carriage".when(&[["carriage_mass_kg", "> 0"]]);
        base_position_m: f64 = 0.0, Finite, "middle x₀ of the motion of the base";
        base_amplitude_m: f64 = 0.0, NotNegative, "amplitude A of the motion of the base";
        base_frequency_hz: f64 = 0.0, NotNegative, "frequency ω/2π of the motion of the base";
        base_phase_rad: f64 = 0.0, Finite, "phase φ of the motion of the base";
        carriage_position_m: f64 = 0.0, Finite, "position of the carriage at the start".when(&[["carriage_mass_kg", "> 0"]]);
        carriage_velocity_m_s: f64 = 0.0, Finite, "velocity of the carriage at the start".when(&[["carriage_mass_kg", "> 0"]]);
    }
}

impl Carriage {
    /// Returns ω of the base, rad/s.
    pub fn angular_frequency(&self) -> f64 {
        TAU * self.base_frequency_hz
    }

    /// Returns position, velocity and acceleration of the base at `t`: m, m/s, m/s².
    #[inline]
    pub fn base_at(&self, t: f64) -> [f64; 3] {
        let omega = self.angular_frequency();
        let (sine, cosine) = libm::sincos(omega * t + self.base_phase_rad);
        let swing = self.base_amplitude_m * sine;
        [self.base_position_m + swing, self.base_amplitude_m * omega * cosine, -omega * omega * swing]
    }

    /// Returns position (m) and velocity (m/s) of the carriage at the start.
    pub fn start(&self) -> [f64; 2] {
        let [position, velocity, _] = self.base_at(0.0);
        let own = [self.carriage_position_m, self.carriage_velocity_m_s];
        if self.carriage_mass_kg > 0.0 { own } else { [position, velocity] }
    }
}

/// A carriage on springs that pushes an interface.
///
#[doc = include_str!("carriage.md")]
///
/// Steps are exact for inputs that are polynomials of time. The force depends directly on both inputs.
#[derive(Debug, Clone)]
pub struct SpringActuator {
    parameters: Carriage,
    /// Constant velocity added to the motion of the base, m/s.
    drift: f64,
    /// How far the interface may be from the carriage on either side before they touch, m.
    play: f64,
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
    pub fn new(parameters: Carriage) -> Result<Self> {
        let p = &parameters;
        let held = p.base_stiffness_n_m > 0.0 || p.base_damping_n_s_m > 0.0;
        if p.carriage_mass_kg > 0.0 && p.base_amplitude_m != 0.0 && !held {
            return Err(Error::Incompatible(format!(
                "the base moves by {} m, but neither base_stiffness_n_m nor base_damping_n_s_m joins it to the carriage",
                p.base_amplitude_m
            )));
        }
        let per_mass = |total: f64| if p.carriage_mass_kg > 0.0 { total / p.carriage_mass_kg } else { 0.0 };
        let carriage = HeldOscillator::new(
            per_mass(p.base_stiffness_n_m + p.spring_stiffness_n_m),
            per_mass(p.base_damping_n_s_m + p.spring_damping_n_s_m),
            [p.carriage_position_m, p.carriage_velocity_m_s],
            OscillatorIntegrator::Exact,
        );
        let ports = force_ports("interface_position_m", "interface_velocity_m_s");
        let inputs = InputPolynomials::new(ports.inputs.len());
        let counters = SubsystemCounters::default();
        Ok(SpringActuator { parameters, drift: 0.0, play: 0.0, carriage, time: 0.0, inputs, ports, counters })
    }

    /// Adds a constant velocity (m/s) to the motion of the base.
    pub fn with_drift(self, drift: f64) -> Self {
        SpringActuator { drift, ..self }
    }

    /// Gives a carriage without mass this play (m) to the interface, on either side: they touch or do not, and never
    /// pull.
    pub fn with_play(self, play: f64) -> Self {
        debug_assert!(self.parameters.carriage_mass_kg == 0.0);
        SpringActuator { play, ..self }
    }

    /// Tells by how much spring and damper are deflected, m and m/s; not at all where there is play and nothing
    /// touches.
    #[inline]
    fn deflection(&self, u: &[f64]) -> [f64; 2] {
        let [position, velocity] = self.carriage();
        let [apart, rate] = [position - u[0], velocity - u[1]];
        if self.play == 0.0 {
            return [apart, rate];
        }
        let beyond = apart - apart.clamp(-self.play, self.play);
        let p = &self.parameters;
        // A damper that would pull lets go.
        let pushes = (p.spring_stiffness_n_m * beyond + p.spring_damping_n_s_m * rate) * beyond > 0.0;
        if pushes { [beyond, rate] } else { [0.0; 2] }
    }

    /// Position, velocity and acceleration of the base at `t`.
    #[inline]
    fn base(&self, t: f64) -> [f64; 3] {
        let [position, velocity, acceleration] = self.parameters.base_at(t);
        [position + self.drift * t, self.drift + velocity, acceleration]
    }

    /// Returns position and velocity of the carriage, m, m/s.
    #[inline]
    pub fn carriage(&self) -> [f64; 2] {
        if self.parameters.carriage_mass_kg > 0.0 {
            return [self.carriage.position(), self.carriage.velocity()];
        }
        let [position, velocity, _] = self.base(self.time);
        [position, velocity]
    }

    /// Acceleration that base and interface give the carriage while it is where the others are at zero, m/s².
    #[inline]
    fn load(&self, [position, velocity, _]: [f64; 3], u: &[f64]) -> f64 {
        let p = &self.parameters;
        (p.base_stiffness_n_m * position
            + p.base_damping_n_s_m * velocity
            + p.spring_stiffness_n_m * u[0]
            + p.spring_damping_n_s_m * u[1])
            / p.carriage_mass_kg
    }
}

impl Subsystem for SpringActuator {
    subsystem_methods!(ports capabilities counters clone);

    #[inline]
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        let [apart, rate] = self.deflection(u);
        y[0] = self.parameters.spring_stiffness_n_m * apart + self.parameters.spring_damping_n_s_m * rate;
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        if self.parameters.carriage_mass_kg > 0.0 {
            let base = self.base(t + 0.5 * h);
            let p = &self.parameters;
            if let Some(polynomials) = self.inputs.take() {
                let [position, velocity, _] = base;
                let base = p.base_stiffness_n_m * position + p.base_damping_n_s_m * velocity;
                let pull = |power: usize| {
                    p.spring_stiffness_n_m * polynomials[0][power] + p.spring_damping_n_s_m * polynomials[1][power]
                };
                let load = [base + pull(0), pull(1), pull(2), pull(3)].map(|load| load / p.carriage_mass_kg);
                self.carriage.advance_polynomial(load, h);
            } else {
                self.carriage.advance(self.load(base, u), h);
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
        if self.play > 0.0 && self.deflection(u) == [0.0; 2] {
            rates.rate.fill(0.0);
            rates.feedthrough.fill(0.0);
            rates.rate_gain.fill(0.0);
            return Ok(true);
        }
        let p = &self.parameters;
        let [_, velocity] = self.carriage();
        let (acceleration, per_mass) = if p.carriage_mass_kg > 0.0 {
            (self.carriage.acceleration(self.load(self.base(t), u)), 1.0 / p.carriage_mass_kg)
        } else {
            (self.base(t)[2], 0.0)
        };
        rates.rate[0] = p.spring_stiffness_n_m * velocity + p.spring_damping_n_s_m * acceleration;
        rates.feedthrough.copy_from_slice(&[-p.spring_stiffness_n_m, -p.spring_damping_n_s_m]);
        rates.rate_gain.copy_from_slice(&[
            p.spring_damping_n_s_m * p.spring_stiffness_n_m * per_mass,
            p.spring_damping_n_s_m * p.spring_damping_n_s_m * per_mass,
        ]);
        Ok(true)
    }

    fn input_polynomials(&mut self) -> Option<&mut InputPolynomials> {
        (self.parameters.carriage_mass_kg > 0.0).then_some(&mut self.inputs)
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

//! Both masses on one side and the bare coupling element on the other: force–force coupling.
//!
//! In the literature a manager evaluates the coupling force from what both masses sent, and both receive it, held or
//! extrapolated. As the masses do not feel each other otherwise, they are one subsystem here and the element the other.

use super::held_oscillator::{HeldOscillator, OscillatorIntegrator};
use super::line_masses::LineMass;
use super::two_masses::{CouplingElement, FORCE, polynomial_work, ports};
use rimbench_core::cosim::{
    Capabilities, InputPolynomials, OutputRates, Ports, Quantity, Subsystem, SubsystemCounters, subsystem_methods,
};
use rimbench_core::error::Failure;
use rimbench_core::interface_model::ReducedInterfaceModel;
use rimbench_core::name::Name;

const ELONGATION: [(&str, Quantity); 2] =
    [("elongation_m", Quantity::Position), ("elongation_rate_m_s", Quantity::Velocity)];
const ALL_STATES: [Name; 4] =
    [Name::Borrowed("x1_m"), Name::Borrowed("v1_m_s"), Name::Borrowed("x2_m"), Name::Borrowed("v2_m_s")];

/// Both masses as one subsystem, which do not feel each other but through the coupling force: force in; elongation
/// `x₂ − x₁` and its rate out. Offers a reduced interface model, `H_ii = 1/m₁ + 1/m₂`.
#[derive(Debug, Clone)]
pub struct FreeMasses {
    bodies: [LineMass; 2],
    motions: [HeldOscillator; 2],
    inputs: InputPolynomials,
    ports: Ports,
    work: f64,
    counters: SubsystemCounters,
}

impl FreeMasses {
    /// Builds both masses.
    pub fn new(bodies: [LineMass; 2], integrator: OscillatorIntegrator) -> Self {
        let motion = |body: &LineMass| {
            HeldOscillator::new(body.stiffness / body.mass, body.damping / body.mass, body.start, integrator)
        };
        FreeMasses {
            motions: [motion(&bodies[0]), motion(&bodies[1])],
            bodies,
            inputs: InputPolynomials::new(1),
            ports: Ports { inputs: ports(&[FORCE]), outputs: ports(&ELONGATION), direct_feedthrough: false },
            work: 0.0,
            counters: SubsystemCounters::default(),
        }
    }

    fn elongation(&self) -> [f64; 2] {
        let [first, second] = &self.motions;
        [second.position() - first.position(), second.velocity() - first.velocity()]
    }
}

impl Subsystem for FreeMasses {
    subsystem_methods!(ports capabilities counters clone);

    fn outputs(&mut self, _u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        y.copy_from_slice(&self.elongation());
        Ok(())
    }

    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let before = self.elongation();
        let sides = self.motions.iter_mut().zip(&self.bodies).zip([-1.0, 1.0]);
        if let Some(&[force]) = self.inputs.take() {
            for ((motion, body), sign) in sides {
                let [b0, b1, b2, b3] = force.map(|force| sign * force / body.mass);
                motion.advance_polynomial([b0 + body.held_force() / body.mass, b1, b2, b3], h);
            }
            self.work += polynomial_work(force, before, self.elongation(), h);
        } else {
            for ((motion, body), sign) in sides {
                motion.advance((body.held_force() + sign * u[0]) / body.mass, h);
            }
            self.work += u[0] * (self.elongation()[0] - before[0]);
        }
        self.counters.micro_steps += 1;
        let finite = self.motions.iter().all(HeldOscillator::is_finite);
        if finite { Ok(()) } else { Err(Failure::non_finite(ELONGATION[0].0)) }
    }
}

impl Capabilities for FreeMasses {
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel> {
        Some(ReducedInterfaceModel::zeros(0, 1))
    }

    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        let free = |i: usize| {
            let body = &self.bodies[i];
            self.motions[i].acceleration(body.held_force() / body.mass)
        };
        let [position, velocity] = self.elongation();
        model.h[0] = 1.0 / self.bodies[0].mass + 1.0 / self.bodies[1].mass;
        model.a[0] = free(1) - free(0);
        model.w[0] = velocity;
        model.position[0] = position;
        model.mechanics_step = h;
        Ok(true)
    }

    fn input_polynomials(&mut self) -> Option<&mut InputPolynomials> {
        self.motions[0].takes_polynomials().then_some(&mut self.inputs)
    }

    fn observables(&mut self) -> &[Name] {
        &ALL_STATES
    }

    fn observe(&mut self, _h: f64, row: &mut [f64]) {
        let [first, second] = &self.motions;
        row.copy_from_slice(&[first.position(), first.velocity(), second.position(), second.velocity()]);
    }

    fn interface_work(&mut self) -> Option<f64> {
        Some(self.work)
    }
}

/// The bare coupling element: elongation and rate in, force out. It has no state, only direct feedthrough.
#[derive(Debug, Clone)]
pub struct CouplingForce {
    element: CouplingElement,
    ports: Ports,
    counters: SubsystemCounters,
}

impl CouplingForce {
    /// Builds the element.
    pub fn new(element: CouplingElement) -> Self {
        let ports = Ports { inputs: ports(&ELONGATION), outputs: ports(&[FORCE]), direct_feedthrough: true };
        CouplingForce { element, ports, counters: SubsystemCounters::default() }
    }
}

impl Subsystem for CouplingForce {
    subsystem_methods!(ports capabilities counters clone);

    #[inline]
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        y[0] = -self.element.tension(u[0], u[1]);
        Ok(())
    }

    fn step(&mut self, _t: f64, _u: &[f64], _h: f64) -> Result<(), Failure> {
        self.counters.micro_steps += 1;
        Ok(())
    }
}

impl Capabilities for CouplingForce {
    fn output_rates(&mut self, _t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        rates.rate.fill(0.0);
        rates.feedthrough.copy_from_slice(&[-self.element.stiffness, -self.element.damper_slope(u[1])]);
        rates.rate_gain.fill(0.0);
        Ok(true)
    }
}

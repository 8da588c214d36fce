//! Both masses on one side and the bare coupling element on the other: force–force coupling.
//!
//! In the literature a manager evaluates the coupling force from what both masses sent, and both receive it, held or
//! extrapolated. As the masses do not feel each other otherwise, they are one subsystem here and the element the other.

use super::held_oscillator::{HeldOscillator, OscillatorIntegrator};
use super::two_masses::{CouplingElement, FORCE, WalledMass};
use rimbench_core::cosim::{Port, Ports, Quantity, Subsystem, SubsystemCounters};
use rimbench_core::error::Failure;
use rimbench_core::interface_model::ReducedInterfaceModel;

const ELONGATION: [Port; 2] = [
    Port { name: "elongation_m", quantity: Quantity::Position },
    Port { name: "elongation_rate_m_s", quantity: Quantity::Velocity },
];
const ALL_STATES: [&str; 4] = ["x1_m", "v1_m_s", "x2_m", "v2_m_s"];

/// Both masses as one subsystem, which do not feel each other but through the coupling force: force in; elongation
/// `x₂ − x₁` and its rate out. Offers a reduced interface model, `H_ii = 1/m₁ + 1/m₂`.
#[derive(Debug, Clone)]
pub struct FreeMasses {
    bodies: [WalledMass; 2],
    motions: [HeldOscillator; 2],
    ports: Ports,
    work: f64,
    counters: SubsystemCounters,
}

impl FreeMasses {
    /// Builds both masses.
    pub fn new(bodies: [WalledMass; 2], integrator: OscillatorIntegrator) -> Self {
        let motion = |body: &WalledMass| {
            HeldOscillator::new(body.stiffness / body.mass, body.damping / body.mass, body.start, integrator)
        };
        FreeMasses {
            motions: [motion(&bodies[0]), motion(&bodies[1])],
            bodies,
            ports: Ports { inputs: vec![FORCE], outputs: ELONGATION.to_vec(), direct_feedthrough: false },
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
    fn ports(&self) -> &Ports {
        &self.ports
    }

    fn outputs(&self, _u: &[f64], y: &mut [f64]) {
        y.copy_from_slice(&self.elongation());
    }

    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let [before, _] = self.elongation();
        for ((motion, body), force) in self.motions.iter_mut().zip(&self.bodies).zip([-u[0], u[0]]) {
            motion.advance((body.stiffness * body.wall + force) / body.mass, h);
        }
        self.work += u[0] * (self.elongation()[0] - before);
        self.counters.micro_steps += 1;
        let finite = self.motions.iter().all(HeldOscillator::is_finite);
        if finite { Ok(()) } else { Err(Failure::NonFinite { quantity: ELONGATION[0].name }) }
    }

    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        let free = |i: usize| {
            let body = &self.bodies[i];
            self.motions[i].acceleration(body.stiffness * body.wall / body.mass)
        };
        let [position, velocity] = self.elongation();
        model.h[0] = 1.0 / self.bodies[0].mass + 1.0 / self.bodies[1].mass;
        model.a[0] = free(1) - free(0);
        model.w[0] = velocity;
        model.position[0] = position;
        model.mechanics_step = h;
        Ok(true)
    }

    fn empty_interface_model(&self) -> Option<ReducedInterfaceModel> {
        Some(ReducedInterfaceModel::zeros(0, 1))
    }

    fn observables(&self) -> &[&'static str] {
        &ALL_STATES
    }

    fn observe(&mut self, _h: f64, row: &mut [f64]) {
        let [first, second] = &self.motions;
        row.copy_from_slice(&[first.position(), first.velocity(), second.position(), second.velocity()]);
    }

    fn interface_work(&self) -> Option<f64> {
        Some(self.work)
    }

    fn try_clone(&self) -> Option<Box<dyn Subsystem>> {
        Some(Box::new(self.clone()))
    }

    fn counters(&self) -> SubsystemCounters {
        self.counters
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
        let ports = Ports { inputs: ELONGATION.to_vec(), outputs: vec![FORCE], direct_feedthrough: true };
        CouplingForce { element, ports, counters: SubsystemCounters::default() }
    }
}

impl Subsystem for CouplingForce {
    fn ports(&self) -> &Ports {
        &self.ports
    }

    #[inline]
    fn outputs(&self, u: &[f64], y: &mut [f64]) {
        y[0] = -self.element.tension(u[0], u[1]);
    }

    fn step(&mut self, _t: f64, _u: &[f64], _h: f64) -> Result<(), Failure> {
        self.counters.micro_steps += 1;
        Ok(())
    }

    fn try_clone(&self) -> Option<Box<dyn Subsystem>> {
        Some(Box::new(self.clone()))
    }

    fn counters(&self) -> SubsystemCounters {
        self.counters
    }
}

//! Two masses between two walls, split at the element that couples them.
//!
//! ```text
//!   |--k₁,c₁--[m₁]--k_c,c_c--[m₂]--k₂,c₂--|
//!   F = k_c (x₁ − x₂) + c_c D(v₁ − v₂)        on m₂ along +x, on m₁ against it
//! ```
//! [`MassSide`] is one mass that is driven by a force or, holding the coupling element itself, by the other's motion.

use super::held_oscillator::{HeldOscillator, OscillatorIntegrator};
use super::line_masses::LineMass;
use rimbench_core::cosim::{
    Capabilities, Cubic, InputPolynomials, OutputRates, Port, Ports, Quantity, Subsystem, SubsystemCounters,
    subsystem_methods,
};
use rimbench_core::error::{Cause, Failure};
use rimbench_core::interface_model::ReducedInterfaceModel;
use rimbench_core::name::Name;

/// The element between the masses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CouplingElement {
    /// k_c, N/m.
    pub stiffness: f64,
    /// c_c, N·s/m, or N·(s/m)^p for another exponent than 1.
    pub damping: f64,
    /// p of the damper law `c_c sign(v) |v|^p`; 1 is linear.
    pub exponent: f64,
}

impl CouplingElement {
    /// Tells whether the force is linear in both arguments.
    pub fn is_linear(&self) -> bool {
        self.exponent == 1.0 || self.damping == 0.0
    }

    /// Returns the force (N) that pulls the ends together when they are `elongation` (m) further apart than at rest and
    /// part with `rate` (m/s).
    #[inline]
    pub fn tension(&self, elongation: f64, rate: f64) -> f64 {
        let damper = if self.is_linear() { rate } else { rate.signum() * libm::pow(rate.abs(), self.exponent) };
        self.stiffness * elongation + self.damping * damper
    }

    /// Derivative of the damper's force by its rate (N·s/m); a root at rest has none, and counts as straight.
    #[inline]
    pub fn damper_slope(&self, rate: f64) -> f64 {
        if self.is_linear() || rate == 0.0 {
            self.damping
        } else {
            self.damping * self.exponent * libm::pow(rate.abs(), self.exponent - 1.0)
        }
    }
}

/// What drives a [`MassSide`] and what it puts out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MassRole {
    /// Coupling force in; own position and velocity out. Offers a reduced interface model.
    ForceDriven,
    /// The other's position and velocity in, own ones out; the coupling element is its own copy.
    Displacement(CouplingElement),
    /// The other's position and velocity in, the force on the other out: direct feedthrough.
    ForceGiving(CouplingElement),
}

pub(super) const FORCE: (&str, Quantity) = ("coupling_force_n", Quantity::Force);
const MOTION: [[(&str, Quantity); 2]; 2] = [
    [("x1_m", Quantity::Position), ("v1_m_s", Quantity::Velocity)],
    [("x2_m", Quantity::Position), ("v2_m_s", Quantity::Velocity)],
];
const STATES: [[Name; 2]; 2] =
    [[Name::Borrowed("x1_m"), Name::Borrowed("v1_m_s")], [Name::Borrowed("x2_m"), Name::Borrowed("v2_m_s")]];

/// Ports by name and quantity.
pub(super) fn ports(list: &[(&'static str, Quantity)]) -> Vec<Port> {
    list.iter().map(|&(name, quantity)| Port::new(name, quantity)).collect()
}

/// Work (J) of the force `Σ c_p τ^p` (N) over a step `h` (s) between two states (m, m/s).
///
/// ```text
/// W = ∫ F v dτ,   v the slope of the cubic through positions and velocities of both ends
/// ```
/// Exact for a force that is held; otherwise to order 4 in `h`.
pub(super) fn polynomial_work(force: Cubic, before: [f64; 2], after: [f64; 2], h: f64) -> f64 {
    let ([x0, v0], [x1, v1]) = (before, after);
    let way = x1 - x0;
    // v = v0 + b θ + c θ² with θ = τ/h, whose mean is way/h.
    let b = 6.0 * way / h - 4.0 * v0 - 2.0 * v1;
    let c = 3.0 * (v0 + v1) - 6.0 * way / h;
    let rest: f64 = (1..4)
        .map(|p| {
            let n = p as f64;
            force[p] * h.powi(p as i32 + 1) * (v0 / (n + 1.0) + b / (n + 2.0) + c / (n + 3.0))
        })
        .sum();
    force[0] * way + rest
}

/// One of the two masses as a subsystem.
#[derive(Debug, Clone)]
pub struct MassSide {
    body: LineMass,
    role: MassRole,
    index: usize,
    motion: HeldOscillator,
    inputs: InputPolynomials,
    ports: Ports,
    work: f64,
    counters: SubsystemCounters,
}

impl MassSide {
    /// Builds mass `index` (0 or 1). A nonlinear element knows no exponential: [`OscillatorIntegrator::Exact`] then
    /// stands for the classical Runge–Kutta rule of order 4; it does not go with the implicit integrators.
    pub fn new(index: usize, body: LineMass, role: MassRole, integrator: OscillatorIntegrator) -> Self {
        let (own, other) = (ports(&MOTION[index]), ports(&MOTION[1 - index]));
        let (inputs, outputs, direct_feedthrough) = match role {
            MassRole::ForceDriven => (ports(&[FORCE]), own, false),
            MassRole::Displacement(_) => (other, own, false),
            MassRole::ForceGiving(_) => (other, ports(&[FORCE]), true),
        };
        let element = match role {
            MassRole::Displacement(element) | MassRole::ForceGiving(element) if element.is_linear() => element,
            _ => CouplingElement { stiffness: 0.0, damping: 0.0, exponent: 1.0 },
        };
        let motion = HeldOscillator::new(
            (body.stiffness + element.stiffness) / body.mass,
            (body.damping + element.damping) / body.mass,
            body.start,
            integrator,
        );
        let ports = Ports { inputs, outputs, direct_feedthrough };
        let inputs = InputPolynomials::new(ports.inputs.len());
        MassSide { body, role, index, motion, inputs, ports, work: 0.0, counters: SubsystemCounters::default() }
    }

    /// Force of the coupling element on the other mass.
    #[inline]
    fn given(&self, element: &CouplingElement, u: &[f64]) -> f64 {
        element.tension(self.motion.position() - u[0], self.motion.velocity() - u[1])
    }
}

impl Subsystem for MassSide {
    subsystem_methods!(ports capabilities counters clone);

    #[inline]
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        match &self.role {
            MassRole::ForceGiving(element) => y[0] = self.given(element, u),
            MassRole::ForceDriven | MassRole::Displacement(_) => {
                y.copy_from_slice(&[self.motion.position(), self.motion.velocity()]);
            }
        }
        Ok(())
    }

    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let (body, before) = (self.body, [self.motion.position(), self.motion.velocity()]);
        let from_wall = body.held_force();
        let polynomials = self.inputs.take();
        match (self.role, polynomials) {
            (MassRole::ForceDriven, Some(polynomials)) => {
                let [b0, b1, b2, b3] = polynomials[0].map(|force| force / body.mass);
                self.motion.advance_polynomial([b0 + from_wall / body.mass, b1, b2, b3], h);
                let after = [self.motion.position(), self.motion.velocity()];
                self.work += polynomial_work(polynomials[0], before, after, h);
            }
            (MassRole::ForceDriven, None) => {
                self.motion.advance((from_wall + u[0]) / body.mass, h);
                self.work += u[0] * (self.motion.position() - before[0]);
            }
            (MassRole::Displacement(element) | MassRole::ForceGiving(element), Some(polynomials)) => {
                let pull = |p: usize| element.stiffness * polynomials[0][p] + element.damping * polynomials[1][p];
                let load = [from_wall + pull(0), pull(1), pull(2), pull(3)].map(|load| load / body.mass);
                self.motion.advance_polynomial(load, h);
            }
            (MassRole::Displacement(element) | MassRole::ForceGiving(element), None) => {
                if element.is_linear() {
                    let pull = element.stiffness * u[0] + element.damping * u[1];
                    self.motion.advance((from_wall + pull) / body.mass, h);
                } else {
                    let pull = |x: f64, v: f64| -element.tension(x - u[0], v - u[1]) / body.mass;
                    self.motion.advance_with(from_wall / body.mass, pull, h);
                }
            }
        }
        self.counters.micro_steps += 1;
        if self.motion.is_finite() {
            Ok(())
        } else {
            Err(Cause::NonFinite { quantity: STATES[self.index][0].clone() }.into())
        }
    }
}

impl Capabilities for MassSide {
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel> {
        (self.role == MassRole::ForceDriven).then(|| ReducedInterfaceModel::zeros(0, 1))
    }

    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        if self.role != MassRole::ForceDriven {
            return Ok(false);
        }
        let body = &self.body;
        model.h[0] = 1.0 / body.mass;
        model.a[0] = self.motion.acceleration(body.held_force() / body.mass);
        model.w[0] = self.motion.velocity();
        model.position[0] = self.motion.position();
        model.mechanics_step = h;
        Ok(true)
    }

    fn output_rates(&mut self, _t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        let MassRole::ForceGiving(element) = self.role else { return Ok(false) };
        let (elongation, rate) = (self.motion.position() - u[0], self.motion.velocity() - u[1]);
        let slope = element.damper_slope(rate);
        let (body, m) = (&self.body, self.body.mass);
        let own = body.stiffness * (body.anchor - self.motion.position()) - body.damping * self.motion.velocity();
        let acceleration = (body.load + own - element.tension(elongation, rate)) / m;
        rates.rate[0] = element.stiffness * self.motion.velocity() + slope * acceleration;
        rates.feedthrough.copy_from_slice(&[-element.stiffness, -slope]);
        // Of a nonlinear damper the change of the slope itself is left out.
        rates.rate_gain.copy_from_slice(&[slope * element.stiffness / m, slope * slope / m]);
        Ok(true)
    }

    fn input_polynomials(&mut self) -> Option<&mut InputPolynomials> {
        let linear = match self.role {
            MassRole::ForceDriven => true,
            MassRole::Displacement(element) | MassRole::ForceGiving(element) => element.is_linear(),
        };
        (linear && self.motion.takes_polynomials()).then_some(&mut self.inputs)
    }

    fn observables(&mut self) -> &[Name] {
        &STATES[self.index]
    }

    fn observe(&mut self, _h: f64, row: &mut [f64]) {
        row.copy_from_slice(&[self.motion.position(), self.motion.velocity()]);
    }

    fn interface_work(&mut self) -> Option<f64> {
        (self.role == MassRole::ForceDriven).then_some(self.work)
    }
}

//! What the two-mass cases share: their sides for each coupling, their exact solution, their energy.

use super::case::{CoupledSystem, DerivedColumn, InterfaceColumns, StateVariable};
use super::parameters::{Parameter, Parameters, Range, number};
use super::reference_method::ExactSolution;
use crate::models::{
    CouplingElement, CouplingForce, FreeMasses, MassRole, MassSide, OscillatorIntegrator, OwnPosition,
    StaleFeedthrough, WalledMass,
};
use nalgebra::{Matrix5, Vector4, Vector5};
use rimbench_core::cosim::{StopFlag, Trajectory};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::mechanics::ReferenceSteps;

/// Columns of the trace; with [`FURTHER_COLUMNS`], all that is recorded.
pub(super) const TRACE_COLUMNS: [&str; 6] = ["time_s", "x1_m", "x2_m", "v1_m_s", "v2_m_s", "energy_j"];
/// The coupling force of the true states, by which accuracy is judged.
pub(super) const FURTHER_COLUMNS: [&str; 1] = ["coupling_force_n"];

/// The ways to split two masses.
pub(super) const COUPLINGS: [&str; 3] = ["force-displacement", "displacement-displacement", "force-force"];

/// That of the OSP quarter truck, with what its wheel does differently: stale feedthrough, and a position of its own.
pub(super) const PUBLISHED_UNITS: &str = "published-units";

/// Columns of the state, and the parameters that hold its start.
const STATE: [[&str; 2]; 4] = [["x1_m", "x1_0_m"], ["x2_m", "x2_0_m"], ["v1_m_s", "v1_0_m_s"], ["v2_m_s", "v2_0_m_s"]];

/// The interface by which the couplings are judged.
pub(super) fn interface() -> InterfaceColumns {
    InterfaceColumns::new("x2_m", "v2_m_s", "coupling_force_n")
}

/// The state, for spectral radii.
pub(super) fn state() -> Vec<StateVariable> {
    STATE.map(|[column, initial]| StateVariable { initial: initial.into(), column: column.into() }).to_vec()
}

/// How each side integrates itself, one of `names`.
pub(super) fn integrator(names: &[&'static str], source: &'static str) -> Parameter {
    let about = "how each side integrates itself; exact: polynomial inputs as such; the others: their mean over each step, held";
    Parameter::choice("integrator", names.iter().copied(), about, source)
}

/// The integrators of two of the cases.
pub(super) const INTEGRATORS: [&str; 4] = ["exact", "semi-implicit-euler", "trapezoidal", "exact-sampled"];

/// The one of [`INTEGRATORS`] that the parameters say.
pub(super) fn integrator_of(parameters: &Parameters) -> OscillatorIntegrator {
    match parameters.choice("integrator") {
        "semi-implicit-euler" => OscillatorIntegrator::SemiImplicitEuler,
        "trapezoidal" => OscillatorIntegrator::Trapezoidal,
        "exact-sampled" => OscillatorIntegrator::ExactSampled,
        _ => OscillatorIntegrator::Exact,
    }
}

/// The start of the state, each variable with its default and its description.
pub(super) fn start(values: [f64; 4], about: [&'static str; 4], source: &'static str) -> Vec<Parameter> {
    let [x1, x2, v1, v2] = STATE.map(|[_, initial]| initial);
    vec![
        number(x1, "m", values[0], Range::Finite, about[0], source),
        number(x2, "m", values[1], Range::Finite, about[1], source),
        number(v1, "m/s", values[2], Range::Finite, about[2], source),
        number(v2, "m/s", values[3], Range::Finite, about[3], source),
    ]
}

/// Descriptions of the start of masses that have no names but their numbers.
pub(super) const NUMBERED: [&str; 4] = [
    "position of mass 1 at the start",
    "position of mass 2 at the start",
    "velocity of mass 1 at the start",
    "velocity of mass 2 at the start",
];

/// Two masses and what is between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TwoMasses {
    pub(super) bodies: [WalledMass; 2],
    pub(super) element: CouplingElement,
}

impl TwoMasses {
    /// Both sides, split as the parameter `coupling` says.
    ///
    /// ```text
    /// force-displacement          mass 1 with the coupling element (actuator): (x₂, v₂) → F;  mass 2 (mechanics): F → (x₂, v₂)
    /// displacement-displacement   each mass with a copy of the element: the other's (x, v) → its own
    /// force-force                 both masses (mechanics): F → elongation;  the bare element (actuator): elongation → F
    /// published-units             mass 1 (mechanics): F → (x₁, v₁);  mass 2 with the element, as the published units have it
    /// ```
    /// In the literature's force–force coupling a manager evaluates the force from what both masses sent, and both
    /// receive it, held or extrapolated. As the masses do not feel each other otherwise, that is the third line.
    pub(super) fn system(self, parameters: &Parameters, integrator: OscillatorIntegrator) -> Result<CoupledSystem> {
        self.check(integrator)?;
        let [first, second] = self.bodies;
        let side = |index, body, role| MassSide::new(index, body, role, integrator);
        let element = self.element;
        let mut system = match parameters.choice("coupling") {
            "displacement-displacement" => CoupledSystem::new(
                side(1, second, MassRole::Displacement(element)),
                side(0, first, MassRole::Displacement(element)),
            ),
            "force-force" => CoupledSystem::new(FreeMasses::new(self.bodies, integrator), CouplingForce::new(element)),
            PUBLISHED_UNITS => CoupledSystem::new(
                side(0, first, MassRole::ForceDriven),
                StaleFeedthrough::new(OwnPosition::new(side(1, second, MassRole::ForceGiving(element)))),
            ),
            _ => CoupledSystem::new(
                side(1, second, MassRole::ForceDriven),
                side(0, first, MassRole::ForceGiving(element)),
            ),
        };
        let states = STATE.map(|[column, _]| column);
        system.derived = vec![
            DerivedColumn::new("energy_j", states, move |z| self.energy(Vector4::from_column_slice(z))),
            DerivedColumn::new("coupling_force_n", states, move |z| self.coupling_force(Vector4::from_column_slice(z))),
        ];
        Ok(system)
    }

    fn check(&self, integrator: OscillatorIntegrator) -> Result<()> {
        use OscillatorIntegrator::{Exact, SemiImplicitEuler};
        if self.element.is_linear() || matches!(integrator, Exact | SemiImplicitEuler) {
            return Ok(());
        }
        Err(Error::Incompatible(
            "a nonlinear damper goes with integrator `exact` (which is then Runge-Kutta of order 4) or \
             `semi-implicit-euler`"
                .into(),
        ))
    }

    /// Exact solution of the linear system by one matrix exponential per time.
    ///
    /// ```text
    /// d/dt [x₁ x₂ v₁ v₂ 1]ᵀ = A [x₁ x₂ v₁ v₂ 1]ᵀ        z(t) = exp(A t) z(0)
    /// ```
    pub(super) fn exact(self) -> ExactSolution {
        let generator = self.generator();
        let [first, second] = self.bodies.map(|body| body.start);
        let start = Vector5::new(first[0], second[0], first[1], second[1], 1.0);
        Box::new(move |t, row| {
            let z = (generator * t).exp() * start;
            self.write(t, z.fixed_rows::<4>(0).into_owned(), row);
        })
    }

    /// The nonlinear system by the classical Runge–Kutta rule of order 4, as a [`ReferenceMethod::Own`].
    ///
    /// [`ReferenceMethod::Own`]: super::reference_method::ReferenceMethod::Own
    pub(super) fn runge_kutta(
        self,
        steps: ReferenceSteps,
        stop: StopFlag<'_>,
        out: &mut Trajectory,
    ) -> Result<(), Failure> {
        let h = steps.h;
        let [first, second] = self.bodies.map(|body| body.start);
        let mut z = Vector4::new(first[0], second[0], first[1], second[1]);
        self.write(0.0, z, out.push_row());
        for step in 1..=steps.steps {
            stop.check()?;
            let r1 = self.rate(z);
            let r2 = self.rate(z + 0.5 * h * r1);
            let r3 = self.rate(z + 0.5 * h * r2);
            let r4 = self.rate(z + h * r3);
            z += h / 6.0 * (r1 + 2.0 * (r2 + r3) + r4);
            if steps.shows(step) {
                self.write(step as f64 * h, z, out.push_row());
            }
        }
        if z.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(Failure::non_finite(STATE[0][0])) }
    }

    fn rate(&self, z: Vector4<f64>) -> Vector4<f64> {
        let force = self.coupling_force(z);
        let a = |i: usize, force: f64| {
            let body = &self.bodies[i];
            (body.stiffness * (body.wall - z[i]) - body.damping * z[2 + i] + force) / body.mass
        };
        Vector4::new(z[2], z[3], a(0, -force), a(1, force))
    }

    /// `A` of the linear system, column by column from the rate itself.
    fn generator(&self) -> Matrix5<f64> {
        let offset = self.rate(Vector4::zeros());
        let mut generator = Matrix5::zeros();
        for column in 0..4 {
            let mut unit = Vector4::zeros();
            unit[column] = 1.0;
            generator.fixed_view_mut::<4, 1>(0, column).copy_from(&(self.rate(unit) - offset));
        }
        generator.fixed_view_mut::<4, 1>(0, 4).copy_from(&offset);
        generator
    }

    /// Force of the coupling element on mass 2, N.
    fn coupling_force(&self, z: Vector4<f64>) -> f64 {
        self.element.tension(z[0] - z[1], z[2] - z[3])
    }

    /// Kinetic energy and that of the springs, J.
    fn energy(&self, z: Vector4<f64>) -> f64 {
        let of_body = |i: usize| {
            let body = &self.bodies[i];
            0.5 * (body.mass * z[2 + i] * z[2 + i] + body.stiffness * (z[i] - body.wall).powi(2))
        };
        of_body(0) + of_body(1) + 0.5 * self.element.stiffness * (z[0] - z[1]).powi(2)
    }

    fn write(&self, t: f64, z: Vector4<f64>, row: &mut [f64]) {
        row.copy_from_slice(&[t, z[0], z[1], z[2], z[3], self.energy(z), self.coupling_force(z)]);
    }
}

//! Two masses on springs, the classical test of co-simulation methods: `linear-oscillator`, `precice-oscillator` and `quarter-car`, with their
//! sides for each coupling, their exact solution and their energy. Shown in `docs/cases/two-masses.md`.

use super::case::{CaseDefaults, StateVariable};
use super::prelude::*;
use nalgebra::{Matrix5, Vector4, Vector5};
use rimbench_core::cosim::{StopFlag, Trajectory};
use rimbench_core::error::Failure;
use rimbench_core::mechanics::ReferenceSteps;

/// Coupling of the OSP quarter truck, with what its wheel does differently: stale feedthrough, and a position of its own.
const PUBLISHED_UNITS: &str = "published-units";

/// Columns of the state, and the parameters that hold its start.
const STATE: [[&str; 2]; 4] = [["x1_m", "x1_0_m"], ["x2_m", "x2_0_m"], ["v1_m_s", "v1_0_m_s"], ["v2_m_s", "v2_0_m_s"]];

/// A case of two masses with an exact solution, its interface and its state, for spectral radii.
fn entry(
    name: &'static str,
    about: &'static str,
    tables: &[&'static str],
    times: CaseDefaults,
    masses: fn(&Parameters) -> TwoMasses,
) -> Case {
    Case {
        parameters: table(tables),
        trace_columns: words("time_s x1_m x2_m v1_m_s v2_m_s energy_j"),
        // Of the true states: accuracy is judged by it.
        drawing_columns: words("coupling_force_n"),
        interface_columns: vec![InterfaceColumns::new("x2_m", "v2_m_s", "coupling_force_n")],
        linear_state: STATE
            .map(|[column, initial]| StateVariable { initial: initial.into(), column: column.into() })
            .to_vec(),
        reference: Arc::new(move |parameters| Ok(ReferenceMethod::Exact(masses(parameters).exact()))),
        ..Case::new(name, about, times, move |parameters, _| {
            masses(parameters).system(parameters, integrator_of(parameters))
        })
    }
}

/// How each side integrates itself, by the parameter of that name.
fn integrator_of(parameters: &Parameters) -> OscillatorIntegrator {
    match parameters.choice("integrator") {
        "semi-implicit-euler" => OscillatorIntegrator::SemiImplicitEuler,
        "trapezoidal" => OscillatorIntegrator::Trapezoidal,
        "exact-sampled" => OscillatorIntegrator::ExactSampled,
        "newmark" => OscillatorIntegrator::GeneralisedAlpha { alpha_m: 0.0, alpha_f: 0.0 },
        // The spectral parameters of the preCICE tutorial.
        "generalised-alpha" => OscillatorIntegrator::GeneralisedAlpha { alpha_m: 0.2, alpha_f: 0.4 },
        _ => OscillatorIntegrator::Exact,
    }
}

const INTEGRATORS: &str = "
    integrator | - | exact, semi-implicit-euler, trapezoidal, exact-sampled | choice | how each side integrates itself; exact: polynomial inputs as such; the others: their mean over each step, held
";
const NUMBERED: &str = "
    mass_1_kg | kg | 1.0 | positive | mass m₁
    mass_2_kg | kg | 1.0 | positive | mass m₂
    stiffness_1_n_m | N/m | 10.0 | not negative | stiffness k₁ of the spring between wall and mass 1
    coupling_stiffness_n_m | N/m | 100.0 | not negative | stiffness k_c of the spring between the masses
    stiffness_2_n_m | N/m | 1000.0 | not negative | stiffness k₂ of the spring between mass 2 and wall
";
const START: &str = "
    x1_0_m | m | 0.0 | finite | position of mass 1 at the start
    x2_0_m | m | 0.0 | finite | position of mass 2 at the start
    v1_0_m_s | m/s | 0.0 | finite | velocity of mass 1 at the start
    v2_0_m_s | m/s | 0.0 | finite | velocity of mass 2 at the start
";

/// Two masses between walls, with the same damping of all springs.
fn numbered(parameters: &Parameters, damping: f64) -> TwoMasses {
    let get = |name: &str| parameters.number(name);
    let body = |mass: &str, stiffness: &str, start: [&str; 2]| WalledMass {
        mass: get(mass),
        stiffness: get(stiffness),
        damping,
        wall: 0.0,
        start: start.map(get),
    };
    TwoMasses {
        bodies: [
            body("mass_1_kg", "stiffness_1_n_m", ["x1_0_m", "v1_0_m_s"]),
            body("mass_2_kg", "stiffness_2_n_m", ["x2_0_m", "v2_0_m_s"]),
        ],
        element: CouplingElement { stiffness: get("coupling_stiffness_n_m"), damping, exponent: 1.0 },
    }
}

/// The benchmark of the Laboratorio de Ingeniería Mecánica, Univ. da Coruña, `fgonzalezLIM/cosim-benchmarks` (MIT).
pub(super) fn linear_oscillator() -> Case {
    const FIRST: &str = "source: LIM cosim-benchmarks
        variant | - | 0, 1 | choice | undamped (0) or damped (1)
        coupling | - | force-displacement, displacement-displacement, force-force | choice | what the sides exchange
    ";
    const LAST: &str = "
        damping_n_s_m | N·s/m | 0.01 | not negative | c₁ = c_c = c₂ of variant 1
    ";
    const MOVING: &str = "
        v1_0_m_s = 100.0
        v2_0_m_s = -100.0
    ";
    entry(
        "linear-oscillator",
        "Two masses and three springs (LIM benchmark; exact solution)",
        &[FIRST, INTEGRATORS, NUMBERED, LAST, START, MOVING],
        times(10.0, 1e-3, 1e-4, [1e-3, 1e-3]),
        |parameters| {
            let damped = parameters.choice("variant") == "1";
            numbered(parameters, if damped { parameters.number("damping_n_s_m") } else { 0.0 })
        },
    )
}

/// The preCICE tutorial `oscillator` (Schüller, Birken, Rodenberg et al. 2022), with a solution in two cosines.
pub(super) fn precice_oscillator() -> Case {
    const FIRST: &str = "source: preCICE tutorial oscillator
        coupling | - | displacement-displacement, force-displacement, force-force | choice | what the sides exchange
        integrator | - | exact, newmark, generalised-alpha | choice | how each side integrates itself; exact: polynomial inputs as such; the others: their mean over each step, held
    ";
    // 4π² and 16π².
    const OWN: &str = "
        stiffness_1_n_m = 39.47841760435743
        coupling_stiffness_n_m = 157.91367041742973 | preCICE tutorial oscillator | stiffness k₁₂ of the spring between the masses
        stiffness_2_n_m = 39.47841760435743
        x1_0_m = 1.0
    ";
    entry(
        "precice-oscillator",
        "Two masses and three springs of the preCICE tutorial (exact solution)",
        &[FIRST, NUMBERED, START, OWN],
        times(1.0, 1e-2, 1e-3, [1e-3, 1e-3]),
        |parameters| numbered(parameters, 0.0),
    )
}

/// Chassis (mass 1) and wheel over a step in the road, after the demo of the Open Simulation Platform (libcosim); the exponent's n is ours.
pub(super) fn quarter_car() -> Case {
    const FIRST: &str = "
        damper | - | linear, nonlinear | choice | law of the damper in the suspension | Sadjina et al. 2017
        coupling | - | force-displacement, displacement-displacement, force-force, published-units | choice | what the sides exchange | ours
        source: ours
    ";
    const OWN: &str = "source: OSP quarter car
        chassis_mass_kg | kg | 400.0 | positive | mass m₁ of the chassis
        wheel_mass_kg | kg | 40.0 | positive | mass m₂ of the wheel
        suspension_stiffness_n_m | N/m | 15000.0 | not negative | stiffness k_c of the suspension
        suspension_damping_n_s_m | N·s/m | 1000.0 | not negative | coefficient d of the damper
        damper_shape | - | 1.0 | not negative | n of the nonlinear damper's exponent 2/(1+2n) | ours
        tyre_stiffness_n_m | N/m | 150000.0 | not negative | stiffness k₂ of the tyre
        road_step_m | m | 0.1 | finite | height of the step in the road
        x1_0_m | m | 0.0 | finite | position of the chassis at the start
        x2_0_m | m | 0.0 | finite | position of the wheel at the start
        v1_0_m_s | m/s | 0.0 | finite | velocity of the chassis at the start
        v2_0_m_s | m/s | 0.0 | finite | velocity of the wheel at the start
    ";
    fn masses(parameters: &Parameters) -> TwoMasses {
        let get = |name: &str| parameters.number(name);
        let nonlinear = parameters.choice("damper") == "nonlinear";
        let chassis = WalledMass {
            mass: get("chassis_mass_kg"),
            stiffness: 0.0,
            damping: 0.0,
            wall: 0.0,
            start: ["x1_0_m", "v1_0_m_s"].map(get),
        };
        let wheel = WalledMass {
            mass: get("wheel_mass_kg"),
            stiffness: get("tyre_stiffness_n_m"),
            damping: 0.0,
            wall: get("road_step_m"),
            start: ["x2_0_m", "v2_0_m_s"].map(get),
        };
        let element = CouplingElement {
            stiffness: get("suspension_stiffness_n_m"),
            damping: get("suspension_damping_n_s_m"),
            exponent: if nonlinear { 2.0 / (1.0 + 2.0 * get("damper_shape")) } else { 1.0 },
        };
        TwoMasses { bodies: [chassis, wheel], element }
    }
    Case {
        reference: Arc::new(|parameters| {
            let masses = masses(parameters);
            Ok(match parameters.choice("damper") {
                "nonlinear" => {
                    ReferenceMethod::Own(Box::new(move |steps, stop, out| masses.runge_kutta(steps, stop, out)))
                }
                _ => ReferenceMethod::Exact(masses.exact()),
            })
        }),
        ..entry(
            "quarter-car",
            "Chassis and wheel over a step in the road, linear or nonlinear damper (OSP; exact solution if linear)",
            &[FIRST, INTEGRATORS, OWN],
            times(4.0, 1e-3, 1e-4, [1e-4, 1e-3]),
            masses,
        )
    }
}

/// Two masses and what is between them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TwoMasses {
    bodies: [WalledMass; 2],
    element: CouplingElement,
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
    fn system(self, parameters: &Parameters, integrator: OscillatorIntegrator) -> Result<CoupledSystem> {
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
    fn exact(self) -> ExactSolution {
        let generator = self.generator();
        let [first, second] = self.bodies.map(|body| body.start);
        let start = Vector5::new(first[0], second[0], first[1], second[1], 1.0);
        Box::new(move |t, row| {
            let z = (generator * t).exp() * start;
            self.write(t, z.fixed_rows::<4>(0).into_owned(), row);
        })
    }

    /// The nonlinear system by the classical Runge–Kutta rule of order 4, as a [`ReferenceMethod::Own`].
    fn runge_kutta(self, steps: ReferenceSteps, stop: StopFlag<'_>, out: &mut Trajectory) -> Result<(), Failure> {
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

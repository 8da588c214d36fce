//! Two masses on springs, the classical test of co-simulation methods: `linear-oscillator`, `precice-oscillator` and
//! `quarter-car`, with their sides for each coupling, their exact solution and their energy. Shown in
//! `docs/cases/two-masses.md`.

use super::case::{CaseDefaults, StateVariable};
use super::prelude::*;
use crate::models::exponential;
use nalgebra::{Matrix5, Vector4, Vector5};
use rimbench_core::cosim::{StopFlag, Trajectory};
use rimbench_core::error::Failure;
use rimbench_core::mechanics::ReferenceSteps;

choices! {
    /// What the sides exchange.
    enum CouplingKind {
        ForceDisplacement = "force-displacement",
        DisplacementDisplacement = "displacement-displacement",
        ForceForce = "force-force",
        /// Of the OSP quarter truck, with what its wheel does differently: stale feedthrough, and a position of its
        /// own.
        PublishedUnits = "published-units",
    }
}
choices! {
    /// How each side integrates itself.
    enum Integrator {
        Exact = "exact",
        SemiImplicitEuler = "semi-implicit-euler",
        Trapezoidal = "trapezoidal",
        ExactSampled = "exact-sampled",
        Newmark = "newmark",
        GeneralisedAlpha = "generalised-alpha",
    }
}
choices! {
    /// Of the LIM benchmark.
    enum Variant {
        Undamped = "0",
        Damped = "1",
    }
}
choices! {
    /// Law of the damper in the suspension.
    enum Damper {
        Linear = "linear",
        Nonlinear = "nonlinear",
    }
}

impl Integrator {
    fn of_side(self) -> OscillatorIntegrator {
        match self {
            Integrator::Exact => OscillatorIntegrator::Exact,
            Integrator::SemiImplicitEuler => OscillatorIntegrator::SemiImplicitEuler,
            Integrator::Trapezoidal => OscillatorIntegrator::Trapezoidal,
            Integrator::ExactSampled => OscillatorIntegrator::ExactSampled,
            Integrator::Newmark => OscillatorIntegrator::GeneralisedAlpha { alpha_m: 0.0, alpha_f: 0.0 },
            // The spectral parameters of the preCICE tutorial.
            Integrator::GeneralisedAlpha => OscillatorIntegrator::GeneralisedAlpha { alpha_m: 0.2, alpha_f: 0.4 },
        }
    }
}

/// Columns of the state, and the parameters that hold its start.
const STATE: [[&str; 2]; 4] = [["x1_m", "x1_0_m"], ["x2_m", "x2_0_m"], ["v1_m_s", "v1_0_m_s"], ["v2_m_s", "v2_0_m_s"]];

/// A case of two masses with an exact solution, its interface and its state, for spectral radii.
fn entry<P: ParameterSet>(
    name: &'static str,
    about: &'static str,
    times: CaseDefaults,
    masses: fn(&P) -> TwoMasses,
    how: fn(&P) -> (CouplingKind, Integrator),
    title: [&'static str; 2],
) -> Case {
    Case {
        trace_columns: words("time_s x1_m x2_m v1_m_s v2_m_s energy_j"),
        // Of the true states: accuracy is judged by it.
        drawing_columns: words("coupling_force_n"),
        interface_columns: vec![InterfaceColumns::new("x2_m", "v2_m_s", "coupling_force_n")],
        linear_state: STATE
            .map(|[column, initial]| StateVariable { initial: initial.into(), column: column.into() })
            .to_vec(),
        reference: Arc::new(move |parameters| Ok(ReferenceMethod::Exact(masses(&P::read(parameters)).exact()))),
        drawing: drawn(move |p: &P| Some(drawing(&masses(p), title))),
        ..Case::new(name, about, times, move |p: &P, _| {
            let (coupling, integrator) = how(p);
            masses(p).system(coupling, integrator.of_side())
        })
    }
}

/// Two masses in a line, with the springs that there are.
fn drawing(masses: &TwoMasses, title: [&'static str; 2]) -> Drawing {
    // Large enough for where they start, and for where their springs let them go.
    let reach = |body: &LineMass| {
        let [x, v] = body.start.map(f64::abs);
        if v > 0.0 { x.max(v * (body.mass / (body.stiffness + masses.element.stiffness)).sqrt()) } else { x }
    };
    let size = masses.bodies.iter().map(reach).fold(1.0, |size: f64, reach| size.max(1.0 + 3.0 * reach));
    let at = |x: f64| Channel::Fixed(x * size);
    let moved = |column, x: f64| Channel::Column(column, 1.0, x * size);
    let frames = vec![
        frame("mass 1", moved("x1_m", -0.25), 0.0, 0.0),
        frame("mass 2", moved("x2_m", 0.25), 0.0, 0.0),
        frame("wall 1", at(-0.82), 0.0, 0.0),
        frame("wall 2", at(0.82), 0.0, 0.0),
    ];
    let side = |name: &'static str, x: f64| ([x * size, 0.0], Some(name));
    let mut shapes = vec![Shape::Spring(side("mass 1", 0.08), side("mass 2", -0.08), 0.06 * size)];
    for (body, (mass, wall, towards)) in
        masses.bodies.iter().zip([("mass 1", "wall 1", -1.0), ("mass 2", "wall 2", 1.0)])
    {
        if body.stiffness > 0.0 {
            shapes.push(Shape::Spring(side(wall, -0.02 * towards), side(mass, 0.08 * towards), 0.06 * size));
            shapes.push(Shape::Polygon(rectangle(wall, [0.0, 0.0], [0.04 * size, 0.28 * size]), Fill::Ground));
        }
    }
    let block = |name| Shape::Polygon(rectangle(name, [0.0, 0.0], [0.16 * size, 0.16 * size]), Fill::Scheme);
    shapes.extend([block("mass 1"), block("mass 2")]);
    let view = [[-0.9 * size, 0.9 * size], [-0.2 * size, 0.2 * size]];
    let schemes = ["zero-order-hold", "first-order-hold"];
    Drawing { force: "force between the masses", schemes, ..Drawing::of(title, view, frames, shapes) }
}

parameters! {
    /// Two masses between walls, and three springs.
    struct Masses from "LIM cosim-benchmarks" {
        mass_1_kg: f64 = 1.0, Positive, "mass m₁";
        mass_2_kg: f64 = 1.0, Positive, "mass m₂";
        stiffness_1_n_m: f64 = 10.0, NotNegative, "stiffness k₁ of the spring between wall and mass 1";
        coupling_stiffness_n_m: f64 = 100.0, NotNegative, "stiffness k_c of the spring between the masses";
        stiffness_2_n_m: f64 = 1000.0, NotNegative, "stiffness k₂ of the spring between mass 2 and wall";
    }
}
parameters! {
    /// Where the masses start.
    struct Start from "LIM cosim-benchmarks" {
        x1_0_m: f64 = 0.0, Finite, "position of mass 1 at the start";
        x2_0_m: f64 = 0.0, Finite, "position of mass 2 at the start";
        v1_0_m_s: f64 = 0.0, Finite, "velocity of mass 1 at the start";
        v2_0_m_s: f64 = 0.0, Finite, "velocity of mass 2 at the start";
    }
}

parameters! {
    /// The benchmark of LIM.
    struct LinearOscillator from "LIM cosim-benchmarks" {
        variant: Variant [Undamped, Damped], "undamped (0) or damped (1)";
        coupling: CouplingKind [ForceDisplacement, DisplacementDisplacement, ForceForce], "what the sides exchange";
        integrator: Integrator [Exact, SemiImplicitEuler, Trapezoidal, ExactSampled],
            "how each side integrates itself; exact: polynomial inputs as such; the others: their mean over each step, held";
        masses: Masses;
        damping_n_s_m: f64 = 0.01, NotNegative, "c₁ = c_c = c₂ of variant 1".when(&[["variant", "1"]]);
        start: Start with |set| set.default("v1_0_m_s", 100.0).default("v2_0_m_s", -100.0);
    }
}
parameters! {
    /// The tutorial of preCICE: springs of 4π² and 16π².
    struct PreciceOscillator from "preCICE tutorial oscillator" {
        coupling: CouplingKind [DisplacementDisplacement, ForceDisplacement, ForceForce], "what the sides exchange";
        integrator: Integrator [Exact, Newmark, GeneralisedAlpha],
            "how each side integrates itself; exact: polynomial inputs as such; the others: their mean over each step, held";
        masses: Masses with |set| set
            .from("preCICE tutorial oscillator").default("stiffness_1_n_m", 39.47841760435743)
            .default("coupling_stiffness_n_m", 157.91367041742973)
            .about("coupling_stiffness_n_m", "stiffness k₁₂ of the spring between the masses")
            .default("stiffness_2_n_m", 39.47841760435743);
        start: Start with |set| set.from("preCICE tutorial oscillator").default("x1_0_m", 1.0);
    }
}
parameters! {
    /// The quarter truck of the Open Simulation Platform.
    struct QuarterCar from "OSP quarter car" {
        damper: Damper [Linear, Nonlinear], "law of the damper in the suspension".from("Sadjina et al. 2017");
        coupling: CouplingKind [ForceDisplacement, DisplacementDisplacement, ForceForce, PublishedUnits],
            "what the sides exchange".from("ours");
        integrator: Integrator [Exact, SemiImplicitEuler, Trapezoidal, ExactSampled],
            "how each side integrates itself; exact: polynomial inputs as such; the others: their mean over each step, held".from("ours");
        chassis_mass_kg: f64 = 400.0, Positive, "mass m₁ of the chassis";
        wheel_mass_kg: f64 = 40.0, Positive, "mass m₂ of the wheel";
        suspension_stiffness_n_m: f64 = 15000.0, NotNegative, "stiffness k_c of the suspension";
        suspension_damping_n_s_m: f64 = 1000.0, NotNegative, "coefficient d of the damper";
        damper_shape: f64 = 1.0, NotNegative, "n of the nonlinear damper's exponent 2/(1+2n)".when(&[["damper", "nonlinear"]]).from("ours");
        tyre_stiffness_n_m: f64 = 150000.0, NotNegative, "stiffness k₂ of the tyre";
        road_step_m: f64 = 0.1, Finite, "height of the step in the road";
        x1_0_m: f64 = 0.0, Finite, "position of the chassis at the start";
        x2_0_m: f64 = 0.0, Finite, "position of the wheel at the start";
        v1_0_m_s: f64 = 0.0, Finite, "velocity of the chassis at the start";
        v2_0_m_s: f64 = 0.0, Finite, "velocity of the wheel at the start";
    }
}

/// Two masses between walls, with the same damping of all springs.
fn numbered(masses: &Masses, start: &Start, damping: f64) -> TwoMasses {
    let body = |mass, stiffness, start| LineMass { mass, stiffness, damping, start, ..LineMass::default() };
    TwoMasses {
        bodies: [
            body(masses.mass_1_kg, masses.stiffness_1_n_m, [start.x1_0_m, start.v1_0_m_s]),
            body(masses.mass_2_kg, masses.stiffness_2_n_m, [start.x2_0_m, start.v2_0_m_s]),
        ],
        element: CouplingElement { stiffness: masses.coupling_stiffness_n_m, damping, exponent: 1.0 },
    }
}

/// The benchmark of the Laboratorio de Ingeniería Mecánica, Univ. da Coruña, `fgonzalezLIM/cosim-benchmarks` (MIT).
pub(super) fn linear_oscillator() -> Case {
    entry(
        "linear-oscillator",
        "Two masses and three springs (LIM benchmark; exact solution)",
        times(10.0, 1e-3, 1e-4, [1e-3, 1e-3]),
        |p: &LinearOscillator| {
            numbered(&p.masses, &p.start, if p.variant == Variant::Damped { p.damping_n_s_m } else { 0.0 })
        },
        |p| (p.coupling, p.integrator),
        ["Two masses", "Two masses between walls, thrown at each other against three springs."],
    )
}

/// The preCICE tutorial `oscillator` (Schüller, Birken, Rodenberg et al. 2022), with a solution in two cosines.
pub(super) fn precice_oscillator() -> Case {
    entry(
        "precice-oscillator",
        "Two masses and three springs of the preCICE tutorial (exact solution)",
        times(1.0, 1e-2, 1e-3, [1e-3, 1e-3]),
        |p: &PreciceOscillator| numbered(&p.masses, &p.start, 0.0),
        |p| (p.coupling, p.integrator),
        ["preCICE oscillator", "Two masses and three springs, one mass let go: the tutorial of preCICE."],
    )
}

impl QuarterCar {
    fn masses(&self) -> TwoMasses {
        let of = |mass, start| LineMass { mass, start, ..LineMass::default() };
        let chassis = of(self.chassis_mass_kg, [self.x1_0_m, self.v1_0_m_s]);
        let wheel = LineMass {
            stiffness: self.tyre_stiffness_n_m,
            anchor: self.road_step_m,
            ..of(self.wheel_mass_kg, [self.x2_0_m, self.v2_0_m_s])
        };
        let element = CouplingElement {
            stiffness: self.suspension_stiffness_n_m,
            damping: self.suspension_damping_n_s_m,
            exponent: match self.damper {
                Damper::Linear => 1.0,
                Damper::Nonlinear => 2.0 / (1.0 + 2.0 * self.damper_shape),
            },
        };
        TwoMasses { bodies: [chassis, wheel], element }
    }

    /// Wheel and chassis above the step that the wheel has met.
    fn upright(&self) -> Drawing {
        let frames = vec![
            frame("wheel", 0.0, Channel::Column("x2_m", 1.0, 0.2), 0.0),
            frame("chassis", 0.0, Channel::Column("x1_m", 1.0, 0.75), 0.0),
        ];
        let shapes = vec![
            ground(&[[-9.0, 0.0], [-0.25, 0.0], [-0.25, self.road_step_m], [9.0, self.road_step_m]]),
            Shape::Disc { at: ([0.0, 0.0], Some("wheel")), radius: 0.2, spoke: false, fill: Fill::Metal },
            Shape::Spring(([0.0, 0.0], Some("wheel")), ([0.0, -0.1], Some("chassis")), 0.1),
            Shape::Polygon(rectangle("chassis", [0.0, 0.0], [1.1, 0.2]), Fill::Scheme),
        ];
        let title = ["Quarter car", "A wheel meets a step in the road; spring and damper carry the chassis."];
        let schemes = ["zero-order-hold", "first-order-hold"];
        let drawing = Drawing::of(title, [[-1.3, 1.3], [-0.12, 1.1]], frames, shapes);
        Drawing { force: "force between the masses", schemes, ..drawing }
    }
}

/// Chassis (mass 1) and wheel over a step in the road, after the demo of the Open Simulation Platform (libcosim); the
/// exponent's n is ours.
pub(super) fn quarter_car() -> Case {
    Case {
        reference: Arc::new(|parameters| {
            let p = QuarterCar::read(parameters);
            let masses = p.masses();
            Ok(match p.damper {
                Damper::Nonlinear => {
                    ReferenceMethod::Own(Box::new(move |steps, stop, out| masses.runge_kutta(steps, stop, out)))
                }
                Damper::Linear => ReferenceMethod::Exact(masses.exact()),
            })
        }),
        drawing: drawn(|p: &QuarterCar| Some(p.upright())),
        ..entry(
            "quarter-car",
            "Chassis and wheel over a step in the road, linear or nonlinear damper (OSP; exact solution if linear)",
            times(4.0, 1e-3, 1e-4, [1e-4, 1e-3]),
            QuarterCar::masses,
            |p| (p.coupling, p.integrator),
            ["Quarter car", "A wheel meets a step in the road; spring and damper carry the chassis."],
        )
    }
}

/// Two masses and what is between them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TwoMasses {
    bodies: [LineMass; 2],
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
    fn system(self, coupling: CouplingKind, integrator: OscillatorIntegrator) -> Result<CoupledSystem> {
        self.check(integrator)?;
        let [first, second] = self.bodies;
        let side = |index, body, role| MassSide::new(index, body, role, integrator);
        let element = self.element;
        let mut system = match coupling {
            CouplingKind::DisplacementDisplacement => CoupledSystem::new(
                side(1, second, MassRole::Displacement(element)),
                side(0, first, MassRole::Displacement(element)),
            ),
            CouplingKind::ForceForce => {
                CoupledSystem::new(FreeMasses::new(self.bodies, integrator), CouplingForce::new(element))
            }
            CouplingKind::PublishedUnits => CoupledSystem::new(
                side(0, first, MassRole::ForceDriven),
                StaleFeedthrough::new(OwnPosition::new(side(1, second, MassRole::ForceGiving(element)))),
            ),
            CouplingKind::ForceDisplacement => CoupledSystem::new(
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
        Box::new(move |t, _, row| {
            let z = exponential(&(generator * t)) * start;
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
            (body.stiffness * (body.anchor - z[i]) - body.damping * z[2 + i] + force) / body.mass
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
            0.5 * (body.mass * z[2 + i] * z[2 + i] + body.stiffness * (z[i] - body.anchor).powi(2))
        };
        of_body(0) + of_body(1) + 0.5 * self.element.stiffness * (z[0] - z[1]).powi(2)
    }

    fn write(&self, t: f64, z: Vector4<f64>, row: &mut [f64]) {
        row.copy_from_slice(&[t, z[0], z[1], z[2], z[3], self.energy(z), self.coupling_force(z)]);
    }
}

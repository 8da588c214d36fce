//! `linear-oscillator`: two masses and three springs, the classical test of co-simulation methods.
//!
//! ```text
//!   |--k₁,c₁--[m₁]--k_c,c_c--[m₂]--k₂,c₂--|
//!               → x₁            → x₂
//! ```
//! Two degrees of freedom, linear. `variant` 0 has no damping: energy is conserved, so whatever a run gains or loses is
//! the coupling's doing, and explicit Jacobi with a zero-order hold is unstable for every H. `variant` 1 has
//! c₁ = c_c = c₂ = 0.01 N·s/m. (The published document numbers them 1 and 2, the published code 0 and 1.)
//!
//! | | m₁, m₂ | k₁ | k_c | k₂ | x(0) | v(0) | T |
//! |---|---|---|---|---|---|---|---|
//! | LIM | 1, 1 kg | 10 N/m | 100 N/m | 1000 N/m | 0, 0 m | +100, −100 m/s | 10 s |
//!
//! **Couplings**: `force-displacement` (direct feedthrough of the side of mass 1, which holds the coupling element),
//! `displacement-displacement` (none), `force-force` (the element alone on the actuator side). A reduced interface model
//! is offered in the first and the last. **Integrators**: `exact` (matrix exponential under held inputs, so that only H
//! matters), `semi-implicit-euler`, `trapezoidal`.
//!
//! **Reference**: exact, by matrix exponential; trusted to round-off (1e-10 of the amplitude against normal modes).
//!
//! **Source**: Laboratorio de Ingeniería Mecánica, Univ. da Coruña, `fgonzalezLIM/cosim-benchmarks` (MIT); similar systems
//! in Schweizer et al. 2015, González et al. 2011 and 2019.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::parameters::{Parameter, Parameters, Range};
use super::reference_method::ReferenceMethod;
use super::two_masses::{self, COUPLINGS, FURTHER_COLUMNS, INTEGRATORS, NUMBERED, TRACE_COLUMNS, TwoMasses};
use crate::models::{CouplingElement, WalledMass};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;
use std::sync::Arc;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: names(&TRACE_COLUMNS),
        drawing_columns: names(&FURTHER_COLUMNS),
        interface_columns: vec![two_masses::interface()],
        linear_state: two_masses::state(),
        reference: Arc::new(|parameters| Ok(ReferenceMethod::Exact(masses(parameters).exact()))),
        ..Case::new(
            "linear-oscillator",
            "Two masses and three springs (LIM benchmark; exact solution)",
            CaseDefaults {
                duration_s: 10.0,
                macro_step_s: 1e-3,
                micro_step_s: 1e-4,
                reference_step_s: 1e-3,
                reference_sampling_s: 1e-3,
            },
            build,
        )
    }
}

const LIM: &str = "LIM cosim-benchmarks";

fn parameters() -> Vec<Parameter> {
    [own(), two_masses::start([0.0, 0.0, 100.0, -100.0], NUMBERED, LIM)].concat()
}

fn own() -> Vec<Parameter> {
    use Range::{NotNegative, Positive};
    fn p(name: &'static str, unit: &'static str, default: f64, range: Range, about: &'static str) -> Parameter {
        Parameter::number(name, unit, default, range, about, LIM)
    }
    vec![
        Parameter::choice("variant", ["0", "1"], "undamped (0) or damped (1)", LIM),
        Parameter::choice("coupling", COUPLINGS, "what the sides exchange", LIM),
        two_masses::integrator(&INTEGRATORS, LIM),
        p("mass_1_kg", "kg", 1.0, Positive, "mass m₁"),
        p("mass_2_kg", "kg", 1.0, Positive, "mass m₂"),
        p("stiffness_1_n_m", "N/m", 10.0, NotNegative, "stiffness k₁ of the spring between wall and mass 1"),
        p("coupling_stiffness_n_m", "N/m", 100.0, NotNegative, "stiffness k_c of the spring between the masses"),
        p("stiffness_2_n_m", "N/m", 1000.0, NotNegative, "stiffness k₂ of the spring between mass 2 and wall"),
        p("damping_n_s_m", "N·s/m", 0.01, NotNegative, "c₁ = c_c = c₂ of variant 1"),
    ]
}

fn masses(parameters: &Parameters) -> TwoMasses {
    let get = |name: &str| parameters.number(name);
    let damping = if parameters.choice("variant") == "1" { get("damping_n_s_m") } else { 0.0 };
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

fn build(parameters: &Parameters, _solver: &SolverEntry) -> Result<CoupledSystem> {
    masses(parameters).system(parameters, two_masses::integrator_of(parameters))
}

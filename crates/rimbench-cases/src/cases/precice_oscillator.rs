//! `precice-oscillator`: the two-mass oscillator of the preCICE tutorials, with a solution in two cosines.
//!
//! ```text
//!   |--k₁--[m₁]--k₁₂--[m₂]--k₂--|        u₁,₂(t) = (cos 2πt ± cos 6πt)/2
//!            → u₁        → u₂
//! ```
//! Two degrees of freedom, linear, undamped; starts at rest from u = (1, 0).
//!
//! | | m₁, m₂ | k₁, k₂ | k₁₂ | T |
//! |---|---|---|---|---|
//! | preCICE | 1, 1 kg | 4π² N/m | 16π² N/m | 1 s |
//!
//! **Couplings** as for `linear-oscillator`; the tutorial's is `displacement-displacement` (its participants send k₁₂ u,
//! which is the displacement up to a factor), so that is the default here. **Integrators**: those of the tutorial, `newmark`
//! (average acceleration) and `generalised-alpha` (α_m 0.2, α_f 0.4), under held inputs; and `exact`, the default.
//!
//! **Reference**: exact; the matrix exponential agrees with the two cosines to round-off.
//!
//! **Source**: preCICE tutorial `oscillator`; Schüller, Birken, Rodenberg et al. 2022.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::parameters::{Parameter, Parameters, Range};
use super::reference_method::ReferenceMethod;
use super::two_masses::{self, FURTHER_COLUMNS, NUMBERED, TRACE_COLUMNS, TwoMasses};
use crate::models::{CouplingElement, OscillatorIntegrator, WalledMass};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;
use std::f64::consts::PI;
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
            "precice-oscillator",
            "Two masses and three springs of the preCICE tutorial (exact solution)",
            CaseDefaults {
                duration_s: 1.0,
                macro_step_s: 1e-2,
                micro_step_s: 1e-3,
                reference_step_s: 1e-3,
                reference_sampling_s: 1e-3,
            },
            build,
        )
    }
}

const PRECICE: &str = "preCICE tutorial oscillator";

/// The tutorial's spectral parameters of generalised-α.
const ALPHA_M: f64 = 0.2;
const ALPHA_F: f64 = 0.4;

fn parameters() -> Vec<Parameter> {
    [own(), two_masses::start([1.0, 0.0, 0.0, 0.0], NUMBERED, PRECICE)].concat()
}

fn own() -> Vec<Parameter> {
    use Range::{NotNegative, Positive};
    fn p(name: &'static str, unit: &'static str, default: f64, range: Range, about: &'static str) -> Parameter {
        Parameter::number(name, unit, default, range, about, PRECICE)
    }
    vec![
        Parameter::choice(
            "coupling",
            ["displacement-displacement", "force-displacement", "force-force"],
            "what the sides exchange",
            PRECICE,
        ),
        two_masses::integrator(&["exact", "newmark", "generalised-alpha"], PRECICE),
        p("mass_1_kg", "kg", 1.0, Positive, "mass m₁"),
        p("mass_2_kg", "kg", 1.0, Positive, "mass m₂"),
        p("stiffness_1_n_m", "N/m", 4.0 * PI * PI, NotNegative, "stiffness k₁ of the spring between wall and mass 1"),
        p(
            "coupling_stiffness_n_m",
            "N/m",
            16.0 * PI * PI,
            NotNegative,
            "stiffness k₁₂ of the spring between the masses",
        ),
        p("stiffness_2_n_m", "N/m", 4.0 * PI * PI, NotNegative, "stiffness k₂ of the spring between mass 2 and wall"),
    ]
}

fn masses(parameters: &Parameters) -> TwoMasses {
    let get = |name: &str| parameters.number(name);
    let body = |mass: &str, stiffness: &str, start: [&str; 2]| WalledMass {
        mass: get(mass),
        stiffness: get(stiffness),
        damping: 0.0,
        wall: 0.0,
        start: start.map(get),
    };
    TwoMasses {
        bodies: [
            body("mass_1_kg", "stiffness_1_n_m", ["x1_0_m", "v1_0_m_s"]),
            body("mass_2_kg", "stiffness_2_n_m", ["x2_0_m", "v2_0_m_s"]),
        ],
        element: CouplingElement { stiffness: get("coupling_stiffness_n_m"), damping: 0.0, exponent: 1.0 },
    }
}

fn build(parameters: &Parameters, _solver: &SolverEntry) -> Result<CoupledSystem> {
    let integrator = match parameters.choice("integrator") {
        "newmark" => OscillatorIntegrator::GeneralisedAlpha { alpha_m: 0.0, alpha_f: 0.0 },
        "generalised-alpha" => OscillatorIntegrator::GeneralisedAlpha { alpha_m: ALPHA_M, alpha_f: ALPHA_F },
        _ => OscillatorIntegrator::Exact,
    };
    masses(parameters).system(parameters, integrator)
}

//! `quarter-car`: chassis and wheel over a step in the road, a stiff mechanics side.
//!
//! ```text
//!        [ m₁ chassis ]   → x₁ (up)
//!          k_c ⌇ ╪ d        suspension
//!        [ m₂ wheel ]     → x₂
//!          k₂  ⌇            tyre
//!   ____________|‾‾‾‾‾‾‾  road, 0.1 m higher from t = 0 on
//! ```
//! Two degrees of freedom about the static position, no gravity, all at rest; the wheel is mass 2. `damper`: `linear`
//! (d in N·s/m) or `nonlinear`, `d sign(v) |v|^(2/(1+2n))` (d in N·(s/m)^p with p = 2/(1+2n)). For n = 1 the nonlinear
//! law has a vertical slope at v = 0; the held inputs of order 0 and 1 still measure their orders (1.0 and 1.9).
//!
//! | | m₁ | m₂ | k_c | d | k₂ | road |
//! |---|---|---|---|---|---|---|
//! | OSP | 400 kg | 40 kg | 15 000 N/m | 1000 N·s/m | 150 000 N/m | 0.1 m |
//!
//! **Couplings** as for `linear-oscillator`: in `force-displacement` the chassis with its suspension is the actuator side
//! (direct feedthrough), the wheel on its tyre the mechanics side. `published-units` is the quarter truck as its published units
//! were split and behave: the wheel has the suspension, answers with the velocity it was given a step ago, and keeps a position of
//! the chassis of its own. **Integrators**: `exact` (matrix exponential; with the
//! nonlinear damper, for which there is none, the classical Runge–Kutta rule), `semi-implicit-euler`, `trapezoidal`
//! (linear damper only).
//!
//! **Reference**: linear, exact by matrix exponential; nonlinear, Runge–Kutta of order 4 with refinement, whose observed
//! order shows how rough the damper is. Trusted as far as its own uncertainty says. Digits of the published units come out to 2e-11 m.
//!
//! **Source**: Open Simulation Platform (libcosim) demo; Sadjina et al. 2017. The exponent's n is *ours*.

use super::case::{Case, CaseDefaults, CoupledSystem};
use super::parameters::{Parameter, Parameters, Range};
use super::reference_method::ReferenceMethod;
use super::two_masses::{self, COUPLINGS, FURTHER_COLUMNS, INTEGRATORS, PUBLISHED_UNITS, TRACE_COLUMNS, TwoMasses};
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
        reference: Arc::new(|parameters| {
            let masses = masses(parameters);
            Ok(match parameters.choice("damper") {
                "nonlinear" => {
                    ReferenceMethod::Own(Box::new(move |steps, stop, out| masses.runge_kutta(steps, stop, out)))
                }
                _ => ReferenceMethod::Exact(masses.exact()),
            })
        }),
        ..Case::new(
            "quarter-car",
            "Chassis and wheel over a step in the road, linear or nonlinear damper (OSP; exact solution if linear)",
            CaseDefaults {
                duration_s: 4.0,
                macro_step_s: 1e-3,
                micro_step_s: 1e-4,
                reference_step_s: 1e-4,
                reference_sampling_s: 1e-3,
            },
            build,
        )
    }
}

const OSP: &str = "OSP quarter car";
const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    [own(), two_masses::start([0.0; 4], START, OSP)].concat()
}

fn own() -> Vec<Parameter> {
    use Range::{Finite, NotNegative, Positive};
    fn p(name: &'static str, unit: &'static str, default: f64, range: Range, about: &'static str) -> Parameter {
        Parameter::number(name, unit, default, range, about, OSP)
    }
    vec![
        Parameter::choice(
            "damper",
            ["linear", "nonlinear"],
            "law of the damper in the suspension",
            "Sadjina et al. 2017",
        ),
        Parameter::choice("coupling", [&COUPLINGS[..], &[PUBLISHED_UNITS]].concat(), "what the sides exchange", OURS),
        two_masses::integrator(&INTEGRATORS, OURS),
        p("chassis_mass_kg", "kg", 400.0, Positive, "mass m₁ of the chassis"),
        p("wheel_mass_kg", "kg", 40.0, Positive, "mass m₂ of the wheel"),
        p("suspension_stiffness_n_m", "N/m", 15_000.0, NotNegative, "stiffness k_c of the suspension"),
        p("suspension_damping_n_s_m", "N·s/m", 1000.0, NotNegative, "coefficient d of the damper"),
        Parameter::number("damper_shape", "-", 1.0, NotNegative, "n of the nonlinear damper's exponent 2/(1+2n)", OURS),
        p("tyre_stiffness_n_m", "N/m", 150_000.0, NotNegative, "stiffness k₂ of the tyre"),
        p("road_step_m", "m", 0.1, Finite, "height of the step in the road"),
    ]
}

const START: [&str; 4] = [
    "position of the chassis at the start",
    "position of the wheel at the start",
    "velocity of the chassis at the start",
    "velocity of the wheel at the start",
];

fn masses(parameters: &Parameters) -> TwoMasses {
    let get = |name: &str| parameters.number(name);
    let exponent = match parameters.choice("damper") {
        "nonlinear" => 2.0 / (1.0 + 2.0 * get("damper_shape")),
        _ => 1.0,
    };
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
        exponent,
    };
    TwoMasses { bodies: [chassis, wheel], element }
}

fn build(parameters: &Parameters, _solver: &SolverEntry) -> Result<CoupledSystem> {
    masses(parameters).system(parameters, two_masses::integrator_of(parameters))
}

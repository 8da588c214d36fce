//! The whole command line of rimbench with a case of one's own:
//! `cargo run --release --example custom_case -- simulate --case light-on-heavy --scheme nepce`

use rimbench::cases::{Assembly, Case, CaseDefaults, CoupledSystem, InterfaceColumns};
use rimbench::error::Result;
use rimbench::models::{CouplingElement, LineMass, MassRole, MassSide, OscillatorIntegrator};
use rimbench::name::names;
use rimbench::parameter::parameters;
use std::process::ExitCode;

parameters! {
    /// What can be set.
    struct LightOnHeavy from "ours" {
        coupling_stiffness_n_m: f64 = 100.0, NotNegative,
            "coupling stiffness".study(30.0..300.0);
    }
}

/// 1 kg between wall and spring (actuator) against 20 kg with nothing else to hold them (mechanics).
fn build(p: &LightOnHeavy, _assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let light = LineMass { mass: 1.0, stiffness: 10.0, damping: 1.0, start: [0.1, 0.0], ..LineMass::default() };
    let heavy = LineMass { mass: 20.0, stiffness: 0.0, ..light };
    let element = CouplingElement { stiffness: p.coupling_stiffness_n_m, damping: 1.0, exponent: 1.0 };
    let side = |index, body, role| MassSide::new(index, body, role, OscillatorIntegrator::SemiImplicitEuler);
    Ok(CoupledSystem::new(side(1, heavy, MassRole::ForceDriven), side(0, light, MassRole::ForceGiving(element))))
}

fn case() -> Case {
    let times = CaseDefaults {
        duration_s: 10.0,
        macro_step_s: 1e-3,
        micro_step_s: 1e-4,
        reference_step_s: 1e-3,
        reference_sampling_s: 1e-3,
    };
    Case {
        trace_columns: names(&["time_s", "x1_m", "x2_m", "v1_m_s", "v2_m_s", "coupling_force_n"]),
        interface_columns: vec![InterfaceColumns::new("x2_m", "v2_m_s", "coupling_force_n")],
        ..Case::new("light-on-heavy", "A light mass on a spring drives a heavy one", times, build)
    }
}

fn main() -> ExitCode {
    rimbench::main(rimbench::everything().and_then(|mut catalogue| {
        catalogue.add_case(case())?;
        Ok(catalogue)
    }))
}

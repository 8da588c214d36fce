//! A case of one's own, run by the schemes of shipped experiments in quick form beside the cases that are there:
//! `cargo run --release --example custom_case RESULTS experiments/published/oscillator.toml`

use rimbench::cases::{CASES, Case, CoupledSystem, Parameters, ReferenceMethod, register};
use rimbench::complementarity::SolverEntry;
use rimbench::error::Result;
use rimbench::harness::{Experiment, compare};
use rimbench::models::{CouplingElement, MassRole, MassSide, OscillatorIntegrator, WalledMass};
use std::path::PathBuf;

/// 1 kg between wall and spring (actuator) against 20 kg with nothing else to hold them (mechanics).
fn build(parameters: &Parameters, _solver: &SolverEntry) -> Result<CoupledSystem> {
    let light = WalledMass { mass: 1.0, stiffness: 10.0, damping: 1.0, wall: 0.0, start: [0.1, 0.0] };
    let heavy = WalledMass { mass: 20.0, stiffness: 0.0, ..light };
    let element =
        CouplingElement { stiffness: parameters.number("coupling_stiffness_n_m"), damping: 1.0, exponent: 1.0 };
    let side = |index, body, role| Box::new(MassSide::new(index, body, role, OscillatorIntegrator::SemiImplicitEuler));
    Ok(CoupledSystem::new(side(1, heavy, MassRole::ForceDriven), side(0, light, MassRole::ForceGiving(element))))
}

static CASE: Case = Case {
    name: "light-on-heavy",
    about: "A light mass on a spring drives a heavy one",
    trace_columns: &["time_s", "x1_m", "x2_m", "v1_m_s", "v2_m_s", "coupling_force_n"],
    drawing_columns: &[],
    linear_state: &[],
    reference: |_| ReferenceMethod::Refined,
    build,
    ..CASES[2] // Parameters, times and interface columns of `linear-oscillator`.
};

fn main() -> Result<()> {
    register(&CASE)?;
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let results = arguments.next().unwrap_or_else(|| "custom-case".into());
    let mut tables = arguments
        .map(|file| compare(&Experiment::read(&file)?.with_case(CASE.name)?, &results, true, &rimbench::BUILD));
    tables.try_for_each(|table| table.map(|table| println!("{table}")))
}

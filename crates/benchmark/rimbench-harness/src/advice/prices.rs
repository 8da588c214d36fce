//! What the work of a run costs: of our own cases by counts of instructions, of sides from outside by the clock.

use super::{Catalogue, Error, Result, RunRequest};
use crate::clock::monotonic_clock;
use rimbench_core::cosim::{PerSide, Subsystem};
use rimbench_core::error::Failure;
use rimbench_runs::RunSpec;
use rimbench_statistics::Pool;

/// Usual [prices](super::Question::prices) in micro steps: instructions of the wedge box by Valgrind's count
/// (`rimbench perf record`, November 2026), over those of a micro step, 437. A mechanics step takes 5699; the model of
/// `rim-nonsmooth-gap` 638 in each micro step; what is left of a macro step of `zero-order-hold` beside its mechanics
/// step and its micro steps 3947, of which 2733 find the mass.
pub const USUAL_PRICES: [f64; 4] = [9.0, 13.0, 1.0, 1.5];

/// Steps that are timed, after one that is not.
const STEPS: usize = 12;

/// What work costs: of sides from outside the median time of an exchange of outputs and of a step of each side here,
/// over that of a micro step of the wedge box, timed in the same way. The model is solved by this program: it costs
/// what it always does.
///
/// # Errors
/// Those of building the case; [`Error::Incompatible`] where a side cannot take its first steps.
pub fn prices_of(catalogue: &Catalogue, fixed: &RunRequest) -> Result<[f64; 4]> {
    let case = catalogue.case(fixed.case.as_deref().unwrap_or_default())?;
    if !case.waits {
        return Ok(USUAL_PRICES);
    }
    let scheme = fixed.scheme.clone().or_else(|| Some("zero-order-hold".to_owned()));
    let (_, unit) = times(&RunRequest::of("wedge-box", "zero-order-hold").resolve(&Catalogue::standard())?)?;
    let (exchange, own) =
        times(&RunRequest { scheme, ..fixed.at_macro_step(case.defaults.macro_step_s) }.resolve(catalogue)?)?;
    let [exchange, mechanics, micro_step] = [exchange, own.mechanics, own.actuator].map(|time| time / unit.actuator);
    Ok([exchange + USUAL_PRICES[0], mechanics, micro_step, USUAL_PRICES[3]])
}

/// Seconds that an exchange and one step of each side take.
fn times(spec: &RunSpec) -> Result<(f64, PerSide<f64>)> {
    let failed = |failure: Failure| Error::Incompatible(format!("what a step costs cannot be told: {failure}"));
    let mut sides = (spec.case.build)(&spec.parameters, &spec.solver)?.sides;
    let mut y = sides.as_ref().map(|side| vec![0.0; side.ports().outputs.len()]);
    let own_step = spec.macro_step / spec.mechanics_steps.within(spec.macro_step, spec.micro_step) as f64;
    let (mut exchanges, mut steps) = (Vec::new(), PerSide::<Vec<f64>>::default());
    for step in 0..=STEPS {
        let begun = monotonic_clock();
        sides.mechanics.outputs(&y.actuator, &mut y.mechanics).map_err(failed)?;
        sides.actuator.outputs(&y.mechanics, &mut y.actuator).map_err(failed)?;
        exchanges.push((monotonic_clock() - begun).as_secs_f64());
        let timed = |side: &mut dyn Subsystem, u: &[f64], h: f64| {
            let begun = monotonic_clock();
            side.step(step as f64 * h, u, h).map(|()| (monotonic_clock() - begun).as_secs_f64()).map_err(failed)
        };
        steps.mechanics.push(timed(&mut *sides.mechanics, &y.actuator, own_step)?);
        steps.actuator.push(timed(&mut *sides.actuator, &y.mechanics, spec.micro_step)?);
    }
    let usual = |times: &[f64]| Pool::of(times[1..].iter().copied()).median().unwrap_or(0.0).max(1e-9);
    Ok((usual(&exchanges), steps.as_ref().map(|times| usual(times))))
}

//! What the work of a run costs: of our own cases by counts of instructions, of sides from outside by the clock.

use super::{Catalogue, Result, RunRequest};
use crate::clock::monotonic_clock;
use rimbench_cases::runs::RunSpec;
use rimbench_core::cosim::{PerSide, Subsystem};
use rimbench_core::error::Failure;
use rimbench_statistics::Pool;

/// What one of each kind of [`WORK`](super::WORK) costs, in micro steps: instructions of the wedge box by Valgrind's count (`rimbench perf
/// record`, November 2026), over those of a micro step, 437. A mechanics step takes 5699; the model of `rim-nonsmooth-gap` 638 in each
/// micro step; what is left of a macro step of `zero-order-hold` beside its mechanics step and its micro steps 3947, of which 2733 find
/// the effective mass.
pub const USUAL_PRICES: [f64; 4] = [9.0, 13.0, 1.0, 1.5];

/// Steps that are timed, after one that is not.
const STEPS: usize = 12;

/// Measures what the sides of a case cost here: the median time of an exchange of outputs and of a step of each side, over that of a micro
/// step of the wedge box, timed in the same way. The model is solved by this program: it costs what it always does.
///
/// # Errors
/// Those of building the case; [`Error::Incompatible`](super::Error::Incompatible) where a side cannot take its first steps.
pub fn measured_prices(spec: &RunSpec) -> Result<[f64; 4]> {
    let name = |text: &str| Some(text.to_owned());
    let known = RunRequest { case: name("wedge-box"), scheme: name("zero-order-hold"), ..RunRequest::default() };
    let (_, unit) = times(&known.resolve(&Catalogue::standard())?)?;
    let (exchange, own) = times(spec)?;
    let [least, .., model] = USUAL_PRICES;
    Ok([exchange / unit.actuator + least, own.mechanics / unit.actuator, own.actuator / unit.actuator, model])
}

/// Seconds that an exchange and one step of each side take.
fn times(spec: &RunSpec) -> Result<(f64, PerSide<f64>)> {
    let failed = |failure: Failure| super::Error::Incompatible(format!("what a step costs cannot be told: {failure}"));
    let mut sides = (spec.case.build)(&spec.parameters, &spec.solver)?.sides;
    let mut y = sides.as_ref().map(|side| vec![0.0; side.ports().outputs.len()]);
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
        steps.mechanics.push(timed(&mut *sides.mechanics, &y.actuator, spec.macro_step)?);
        steps.actuator.push(timed(&mut *sides.actuator, &y.mechanics, spec.micro_step)?);
    }
    let usual = |times: &[f64]| Pool::of(times[1..].iter().copied()).median().unwrap_or(0.0).max(1e-9);
    Ok((usual(&exchanges), steps.as_ref().map(|times| usual(times))))
}

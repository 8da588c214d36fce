//! What work costs on this machine, measured as ratios in one process.

use super::price::{Prices, Work};
use crate::clock::monotonic_clock;
use nalgebra::{DMatrix, DVector};
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{RunRequest, simulate};
use rimbench_core::cosim::{Bounds, MechanicsSteps, StopFlag};
use rimbench_core::error::{Error, Result};

/// Micro steps of a run that is timed: long enough for a clock, short enough for a coffee not to get cold.
const MICRO_STEPS: f64 = 20_000.0;

/// Rounds; in each every run is made once, so that what the machine does meanwhile falls on all of them.
const ROUNDS: usize = 9;

/// Measures the prices of a case: wall times of runs that differ in one kind of work each, explained by their counts.
///
/// ```text
/// t_r ≈ e E_r + m M_r + μ μ_r + l L_r       over runs r, by least squares with prices not below 0; then all over μ
/// ```
/// `t_r` is the shortest of several rounds.
///
/// # Errors
/// Bad input; a case on which no run tells the kinds of work apart.
pub fn measured_prices(catalogue: &Catalogue, fixed: &RunRequest) -> Result<Prices> {
    let designs = designs(catalogue, fixed)?;
    let mut times = vec![f64::INFINITY; designs.len()];
    let mut works = vec![Work::default(); designs.len()];
    for _ in 0..ROUNDS {
        for ((design, time), work) in designs.iter().zip(&mut times).zip(&mut works) {
            let spec = design.resolve(catalogue)?;
            let result = simulate(&spec, Bounds::default(), Some(monotonic_clock), StopFlag::never())?;
            *time = time.min(result.wall.as_secs_f64());
            let done = result.report.work;
            *work = Work {
                exchanges: done.cosim.exchanges as f64,
                mechanics_solves: done.sides.mechanics.micro_steps as f64,
                micro_steps: done.sides.actuator.micro_steps as f64,
                model_solves: (done.scheme.solves + done.scheme.parametric) as f64,
            };
        }
    }
    let prices = explained(&works, &times);
    let [exchange, mechanics_solve, micro_step, model_solve] = prices;
    if micro_step <= 0.0 {
        let message = "the times of these runs do not say what a micro step costs: the machine is too busy, or the case too short";
        return Err(Error::Incompatible(message.to_owned()));
    }
    Ok(Prices {
        exchange: exchange / micro_step,
        mechanics_solve: mechanics_solve / micro_step,
        micro_step: 1.0,
        model_solve: model_solve / micro_step,
    })
}

/// Runs that differ in one kind of work: the first scheme of the catalogue that asks for nothing, and, where the case offers a
/// model, the first one that solves contact problems of it.
fn designs(catalogue: &Catalogue, fixed: &RunRequest) -> Result<Vec<RunRequest>> {
    let plain = catalogue.schemes().iter().find(|scheme| scheme.needs.is_empty() && scheme.real_time());
    let plain = plain.ok_or_else(|| Error::Incompatible("no scheme of the catalogue does without needs".into()))?;
    let named = |name: &str| RunRequest { scheme: Some(name.to_owned()), phase: None, ..fixed.clone() };
    let spec = named(&plain.name).resolve(catalogue)?;
    let micro = spec.case.defaults.micro_step_s;
    let duration = spec.duration.min(MICRO_STEPS * micro);
    let of = |name: &str, micro_steps: f64, steps: u32, micro_step: f64| RunRequest {
        duration_s: Some(duration),
        macro_step_s: Some(micro_steps * micro),
        micro_step_s: Some(micro_step),
        mechanics_steps: MechanicsSteps::count(steps),
        ..named(name)
    };
    let mut designs = vec![
        of(&plain.name, 1.0, 1, micro),
        of(&plain.name, 20.0, 1, micro),
        of(&plain.name, 20.0, 20, micro),
        of(&plain.name, 20.0, 1, micro / 4.0),
    ];
    let with_model = catalogue.schemes().iter().filter(|scheme| scheme.has_model() && scheme.real_time());
    for scheme in with_model {
        let Ok(spec) = of(&scheme.name, 20.0, 1, micro).resolve(catalogue) else { continue };
        let work = simulate(&spec, Bounds::default(), None, StopFlag::never())?.report.work.scheme;
        if (work.solves + work.parametric) as f64 > 0.5 * duration / micro {
            designs.extend([of(&scheme.name, 20.0, 1, micro), of(&scheme.name, 20.0, 1, micro / 4.0)]);
            break;
        }
    }
    designs.retain(|design| design.resolve(catalogue).is_ok());
    Ok(designs)
}

/// Prices by least squares, none below zero: of all sets of kinds of work whose prices come out so, the one that explains most.
fn explained(works: &[Work], times: &[f64]) -> [f64; 4] {
    let mut best = ([0.0; 4], f64::INFINITY);
    for set in 1..1_usize << 4 {
        let kinds: Vec<usize> = (0..4).filter(|kind| set & (1 << kind) != 0).collect();
        // Each run in units of its own time: a long one is no better evidence than a short one.
        let counts =
            DMatrix::from_fn(works.len(), kinds.len(), |row, column| works[row].counts()[kinds[column]] / times[row]);
        let ones = DVector::from_element(works.len(), 1.0);
        let svd = counts.clone().svd(true, true);
        let Ok(found) = svd.solve(&ones, 1e-9 * svd.singular_values.max()) else { continue };
        let residual = (&counts * &found - &ones).norm();
        if found.iter().all(|price| *price >= 0.0) && residual < best.1 {
            let mut prices = [0.0; 4];
            kinds.iter().zip(found.iter()).for_each(|(&kind, price)| prices[kind] = *price);
            best = (prices, residual);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prices_are_found_again_from_times_made_of_them_and_none_is_negative() {
        let work = |exchanges, mechanics_solves, micro_steps, model_solves| Work {
            exchanges,
            mechanics_solves,
            micro_steps,
            model_solves,
        };
        let works = [
            work(5e3, 5e3, 2e4, 0.0),
            work(1e3, 1e3, 2e4, 0.0),
            work(1e3, 1e4, 2e4, 0.0),
            work(1e3, 1e3, 8e4, 0.0),
            work(1e3, 1e3, 2e4, 2e4),
        ];
        let prices = Prices { exchange: 3.0, mechanics_solve: 12.0, micro_step: 1.0, model_solve: 1.5 };
        let times: Vec<f64> = works.iter().map(|work| 1e-8 * prices.of(work)).collect();
        for (found, wanted) in explained(&works, &times).into_iter().zip(prices.list()) {
            // Five equations for four unknowns, solved to round-off times their condition, below 1e4.
            approx::assert_relative_eq!(found, 1e-8 * wanted, max_relative = 1e-10);
        }
        // An exchange that seems to give time back costs nothing.
        let odd: Vec<f64> = works.iter().map(|work| 1e-8 * (prices.of(work) - 4.0 * work.exchanges)).collect();
        assert!(explained(&works, &odd).iter().all(|price| *price >= 0.0));
    }
}

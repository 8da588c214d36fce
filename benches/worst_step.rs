//! The longest macro step against the median one: does the work of a step have a tail that would miss a deadline?
//!
//! A machine that does other things lengthens any step now and then. But a run is deterministic, so its k-th macro step does the
//! same work every time: of each the shortest of many runs is taken, and what is left of the tail belongs to the work. Demanded:
//! at most 20 times the median on every wedge box run. A run that diverges says why instead.
//!
//! A lap goes from one communication point to the next: the step, its exchange and the record of a row. With `--bench`, wedge
//! box by every scheme at three macro steps, then every other case by gap tracking at its usual step; without, one run each.

use rimbench::cases::Recorder;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Bounds, Outcome, Supervision, Trajectory};
use rimbench::runs::{RunRequest, RunSpec};
use std::time::Instant;

const WEDGE_BOX: &str = "wedge-box";
const DEMANDED: f64 = 20.0;
const RUNS: usize = 25;
/// Runs are repeated for at most so long, s.
const PATIENCE: f64 = 4.0;

/// Laps of one run, s, or why there are none.
fn laps(spec: &RunSpec) -> Result<Vec<f64>, String> {
    let mut system = (spec.case.build)(&spec.parameters, &spec.solver).map_err(|error| error.to_string())?;
    let setup = spec.setup(Bounds::default()).map_err(|error| error.to_string())?;
    let mut recorder = Recorder::new(&spec.case, &mut system).unwrap();
    let mut sides = system.sides.lend();
    if let Some(reason) = spec.scheme.incompatibility(sides.lend()) {
        return Err(reason);
    }
    let coupling =
        spec.scheme.couple(sides.lend(), spec.model.as_ref(), spec.gain).map_err(|error| error.to_string())?;
    let mut trajectory = Trajectory::with_capacity(spec.case.recorded_columns(), setup.grid.macro_steps() + 1);
    let mut laps = Vec::with_capacity(setup.grid.macro_steps() + 1);
    let mut last = Instant::now();
    let report = coupling.run(&setup, None, sides, Supervision::default(), &mut |point| {
        recorder.record(point, &mut trajectory);
        let now = Instant::now();
        laps.push((now - last).as_secs_f64());
        last = now;
    });
    // The first lap is the way to the first communication point, the second allocates.
    match report.outcome {
        Outcome::Completed => Ok(laps.split_off(2.min(laps.len()))),
        other => Err(other.to_string()),
    }
}

/// Median and longest lap, s, of each lap the shortest of some runs, and the number of runs.
fn tail(spec: &RunSpec, runs: usize) -> Result<(f64, f64, usize), String> {
    let mut shortest = laps(spec)?;
    let began = Instant::now();
    let mut done = 1;
    while done < runs && began.elapsed().as_secs_f64() < PATIENCE {
        for (shortest, lap) in shortest.iter_mut().zip(laps(spec)?) {
            *shortest = shortest.min(lap);
        }
        done += 1;
    }
    shortest.sort_by(f64::total_cmp);
    Ok((shortest[shortest.len() / 2], shortest[shortest.len() - 1], done))
}

fn print(catalogue: &Catalogue, case: &str, scheme: &str, macro_step: f64, runs: usize) -> f64 {
    let request = RunRequest { macro_step_s: Some(macro_step), ..RunRequest::of(case, scheme) };
    let spec = request.resolve(catalogue).expect("the scheme's own sequence and return");
    let title = format!("{case:22} {scheme:38} {:5.2} ms", 1e3 * macro_step);
    match tail(&spec, runs) {
        Ok((median, longest, runs)) => {
            let (median_us, longest_us, ratio) = (1e6 * median, 1e6 * longest, longest / median);
            println!(
                "{title}  median {median_us:9.2} µs  longest {longest_us:9.2} µs  ratio {ratio:5.1}  of {runs} runs"
            );
            ratio
        }
        Err(reason) => {
            println!("{title}  no laps: {reason}");
            0.0
        }
    }
}

fn main() {
    let runs = if std::env::args().any(|argument| argument == "--bench") { RUNS } else { 1 };
    let catalogue = Catalogue::standard();
    let mut worst: f64 = 0.0;
    for scheme in catalogue.schemes() {
        for macro_step in [2e-4, 1e-3, 5e-3] {
            worst = worst.max(print(&catalogue, WEDGE_BOX, &scheme.name, macro_step, runs));
        }
    }
    println!("wedge box: the longest macro step is at most {worst:.1} times the median; demanded {DEMANDED}");
    for case in catalogue.cases().iter().filter(|case| case.name != WEDGE_BOX) {
        let macro_step = 5e-3_f64.min(20.0 * case.defaults.micro_step_s);
        print(&catalogue, &case.name, "rim-nonsmooth-gap", macro_step, runs);
    }
}

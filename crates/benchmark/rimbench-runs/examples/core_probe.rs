//! Digits and work of runs, to the bit: what holds a change of the core to changing no digit.
//!
//! ```text
//! core_probe all [SECONDS]                                           every case, scheme and option that has code of its own: a line per
//!                                                                    run, with a hash over the bits of its trajectory and its counters
//! core_probe run CASE SCHEME H SECONDS REPETITIONS [key=value…]      one run, repeated, for callgrind; parameters as `set:key=value`
//! ```
//! Two revisions agree where their lines do (`.ci/core` compares them, and counts instructions).

use rimbench_core::cosim::{Bounds, StopFlag};
use rimbench_runs::catalogue::Catalogue;
use rimbench_runs::{RunRequest, simulate};

const SCHEMES: [&str; 12] = [
    "zero-order-hold",
    "rim-fixed-mass",
    "rim-smooth",
    "rim-smooth-active",
    "rim-nonsmooth",
    "rim-nonsmooth-gap",
    "interface-mass",
    "interface-jacobian",
    "model-corrected-outputs",
    "true-acceleration",
    "iterated-aitken",
    "monolithic",
];

const OPTIONS: [&[(&str, &str)]; 15] = [
    &[],
    &[("set:friction", "0.3")],
    &[("set:friction", "0.3"), ("set:restitution", "0.4")],
    &[("set:restitution", "0.4")],
    &[("set:contact_compliance_m_n", "1e-7")],
    &[("model_motion", "extrapolated")],
    &[("contact_detection", "mechanics-law")],
    &[("contact_detection", "margin:0.01")],
    &[("solver", "lemke")],
    &[("force_return", "mean"), ("mechanics_steps", "all")],
    &[("force_return", "end"), ("sequence", "jacobi")],
    &[("actuator_integrator", "midpoint")],
    &[("mechanics_integrator", "midpoint"), ("actuator_integrator", "midpoint")],
    &[("mechanics_integrator", "event-split"), ("actuator_integrator", "midpoint")],
    &[("step_control", "model-defect")],
];

fn request(case: &str, scheme: &str, options: &[(&str, &str)]) -> Result<RunRequest, String> {
    let mut request =
        RunRequest { case: Some(case.to_owned()), scheme: Some(scheme.to_owned()), ..RunRequest::default() };
    for (key, text) in options {
        match key.strip_prefix("set:") {
            Some(parameter) => request.set.push((parameter.to_owned(), (*text).to_owned())),
            None => request.put(key, text).map_err(|error| error.to_string())?,
        }
    }
    Ok(request)
}

/// Hashes the bits of every number (FNV-1a).
fn hash(numbers: impl Iterator<Item = f64>) -> u64 {
    numbers
        .flat_map(|x| x.to_bits().to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn one(catalogue: &Catalogue, request: &RunRequest, seconds: f64, repetitions: usize) -> Result<String, String> {
    let mut spec = request.resolve(catalogue).map_err(|error| error.to_string())?;
    if request.duration_s.is_none() && spec.duration > seconds {
        let short = RunRequest { duration_s: Some(seconds), ..request.clone() };
        spec = short.resolve(catalogue).map_err(|error| error.to_string())?;
    }
    let mut line = String::new();
    for _ in 0..repetitions {
        let result = simulate(&spec, Bounds::default(), None, StopFlag::never()).map_err(|error| error.to_string())?;
        let (work, trajectory) = (&result.report.work, &result.trajectory);
        let (scheme, mechanics) = (work.scheme, work.sides.mechanics);
        line = format!(
            "{:016x} rows={} macro={} mechanics={} scheme={scheme:?} solver={:?} {:?}",
            hash(trajectory.rows().flatten().copied()),
            trajectory.len(),
            work.cosim.macro_steps,
            mechanics.micro_steps,
            mechanics.solver,
            result.report.outcome,
        );
    }
    Ok(line)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let catalogue = Catalogue::standard();
    let number = |at: usize, usual: f64| arguments.get(at).and_then(|text| text.parse().ok()).unwrap_or(usual);
    if arguments.first().is_some_and(|word| word == "run") {
        let options: Vec<(&str, &str)> = arguments[6..].iter().filter_map(|text| text.split_once('=')).collect();
        let mut request = request(&arguments[1], &arguments[2], &options).expect("a request");
        (request.macro_step_s, request.duration_s) = (Some(number(3, 5e-3)), Some(number(4, 1.0)));
        println!("{}", one(&catalogue, &request, f64::INFINITY, number(5, 1.0) as usize).expect("a run"));
        return;
    }
    let seconds = number(1, 0.3);
    for case in catalogue.cases() {
        for scheme in SCHEMES {
            for options in OPTIONS {
                let answer = request(&case.name, scheme, options)
                    .and_then(|request| one(&catalogue, &request, seconds, 1))
                    .unwrap_or_else(|reason| format!("refused: {}", reason.lines().next().unwrap_or_default()));
                println!("{} {scheme} {options:?} {answer}", case.name);
            }
        }
    }
}

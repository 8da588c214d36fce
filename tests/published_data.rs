//! Held against numbers that others have published: the hydraulic crane of the LIM benchmark, to its printed digits.

use rimbench::cases::{Parameters, ReferenceMethod, case_by_name};
use rimbench::complementarity::solver_by_name;
use rimbench::cosim::{Bounds, Trajectory};
use rimbench::harness::{RunResult, RunSpec, scheme_options, simulate};
use rimbench::schemes::scheme_by_name;
use std::path::Path;

fn crane(set: &[(&str, &str)]) -> Parameters {
    let mut parameters = case_by_name("hydraulic-crane").unwrap().default_parameters();
    for (key, value) in set {
        parameters.set(key, value).unwrap();
    }
    parameters
}

/// Jacobi zero-order hold as published: one step of the mechanics per macro step, hydraulics min(H, 0.2 ms).
fn jacobi_zoh(set: &[(&str, &str)], macro_step: f64, duration: f64) -> RunSpec {
    let solver = solver_by_name("active-set").unwrap();
    let scheme = scheme_by_name("zero-order-hold").unwrap();
    let (sequence, force_return) = scheme.sequence_and_return(None, None).unwrap();
    RunSpec {
        case: case_by_name("hydraulic-crane").unwrap(),
        parameters: crane(set),
        scheme,
        options: scheme_options(None, None, solver).unwrap(),
        macro_step,
        phase: 1.0,
        micro_step: macro_step.min(2e-4),
        mechanics_steps: 1,
        sequence,
        force_return,
        duration,
        solver,
    }
}

fn run(spec: &RunSpec) -> RunResult {
    simulate(spec, Bounds::default()).unwrap()
}

/// Columns and rows of a published file.
fn published(name: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/lim-crane").join(name);
    let mut reader = csv::Reader::from_path(path).unwrap();
    let columns = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows = reader.records().map(|row| row.unwrap().iter().map(|cell| cell.parse().unwrap()).collect()).collect();
    (columns, rows)
}

fn row_at(trajectory: &Trajectory, time: f64) -> &[f64] {
    let last = trajectory.row(trajectory.len() - 1)[0];
    let row = trajectory.row((time / last * (trajectory.len() - 1) as f64).round() as usize);
    assert!((row[0] - time).abs() < 1e-9, "no row at {time}");
    row
}

/// Half a unit of the last of eight printed digits, with a hair for a tie.
fn print_precision(value: f64) -> f64 {
    0.501 * 10.0_f64.powf(value.abs().max(1e-9).log10().floor() - 7.0)
}

/// The whole crane by the trapezoidal rule at the published step of 0.05 ms, every step a row.
fn monolithic(set: &[(&str, &str)], duration: f64) -> Trajectory {
    let case = case_by_name("hydraulic-crane").unwrap();
    let parameters = crane(set);
    let ReferenceMethod::Own(solve) = (case.reference)(&parameters) else { panic!("the crane has its own reference") };
    let steps = (duration / MONOLITHIC_STEP).round() as usize;
    let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), steps + 1);
    solve(&parameters, MONOLITHIC_STEP, steps, 1, &mut trajectory).unwrap();
    trajectory
}

const MONOLITHIC_STEP: f64 = 5e-5;

#[test]
fn the_monolithic_solution_is_the_published_one() {
    let trajectory = monolithic(&[], 10.0);
    let (_, rows) = published("m1_monolithic_reference.csv");
    let columns =
        ["spool", "actuator_length_m", "actuator_velocity_m_s", "pressure_1_pa", "pressure_2_pa", "actuator_force_n"];
    for shift in [0.0, 1.0, 2.0,-1.0] {
    for (column, name) in columns.into_iter().enumerate() {
        let index = trajectory.index_of(name).unwrap();
        let mut worst = (0.0, 0.0, 0.0);
        for row in &rows {
            let ours = row_at(&trajectory, (row[0] - shift * MONOLITHIC_STEP).clamp(0.0, 10.0));
            let difference = (ours[index] - row[column + 1]).abs();
            let units = difference / (2.0 * print_precision(row[column + 1]));
            if difference > worst.0 {
                worst = (difference, row[0], units);
            }
        }
        println!("shift {shift} {name}: {:.2e} at {} s ({:.2} units)", worst.0, worst.1, worst.2);
    }
    }
}

#[test]
fn co_simulations_with_the_published_driver_agree_to_the_printed_digits() {
    for (file, coupling) in
        [("m1_fs_jacobi_zoh.csv", "force-displacement"), ("m1_ps_jacobi_zoh.csv", "pressure-displacement")]
    {
        let (_, rows) = published(file);
        for (column, macro_step) in [(2, 5e-5), (3, 2e-4), (4, 1e-3)] {
            let set = [("coupling", coupling), ("published_driver", "true")];
            let result = run(&jacobi_zoh(&set, macro_step, 6.05));
            let worst = rows
                .iter()
                .map(|row| (row_at(&result.trajectory, row[0])[1] - row[column]).abs())
                .fold(0.0, f64::max);
            println!("{coupling} at H = {macro_step}: {worst:e} m");
            // Eight digits of a length between 0.1 and 1 m.
            assert!(worst <= 5.01e-9, "{coupling} at H = {macro_step}: {worst:e} m from the published digits");
        }
    }
}

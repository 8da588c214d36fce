//! The reference run (zero-order hold, H = 0.2 ms) side by side with a plain compiled implementation of the same.
//!
//! All run in this one process, turn by turn, so that a slow moment of the machine hits all; what counts is the ratio of
//! the medians. The plain implementation comes in two sizes. With the *same* effort it compares all active sets and
//! records what we record, the effective mass among it; that one is demanded to be 8 times as slow. With the *least* it
//! takes the first active set that fits and records three numbers: less than we do, stated for fairness.
//! Without `--bench` (as in `cargo test --benches`) only the agreement is checked.

#[allow(dead_code)] // What it records besides the interface is looked at by the test.
#[path = "../tests/support/plain_wedge_box.rs"]
mod plain_wedge_box;
mod support;

use plain_wedge_box::{Effort, PlainWedgeBox};
use rimbench::statistics::median;
use std::hint::black_box;
use std::time::Instant;
use support::{DURATION, MICRO_STEP, wedge_box};

const MACRO_STEP: f64 = 2e-4;
/// Of the largest force.
const AGREEMENT: f64 = 1e-8;
const DEMANDED: f64 = 8.0;
const TURNS: usize = 15;

fn timed<T>(run: impl FnOnce() -> T) -> f64 {
    let started = Instant::now();
    black_box(run());
    started.elapsed().as_secs_f64()
}

fn main() {
    let macro_steps = (DURATION / MACRO_STEP).round() as usize;
    let micro_steps = (MACRO_STEP / MICRO_STEP).round() as usize;
    let ours = || wedge_box("zero-order-hold", black_box(MACRO_STEP));
    let plain = |effort| PlainWedgeBox::new(effort).run(black_box(MACRO_STEP), micro_steps, macro_steps);

    let trajectory = ours();
    let force = trajectory.index_of("actuator_force_n").unwrap();
    for effort in [Effort::Same, Effort::Least] {
        let rows = plain(effort);
        assert_eq!(trajectory.len(), rows.len());
        let largest = rows.iter().map(|row| row.interface[2].abs()).fold(0.0, f64::max);
        let apart = |(ours, row): (f64, &plain_wedge_box::Row)| (ours - row.interface[2]).abs();
        let apart = trajectory.column(force).zip(&rows).map(apart).fold(0.0, f64::max);
        assert!(apart <= AGREEMENT * largest, "forces differ by {apart} N");
        println!("{effort:?} effort: forces agree to {:.1e} of {largest:.1} N", apart / largest);
    }

    if std::env::args().any(|argument| argument == "--bench") {
        let mut times = [const { Vec::new() }; 3];
        for _ in 0..TURNS {
            times[0].push(timed(ours));
            times[1].push(timed(|| plain(Effort::Same)));
            times[2].push(timed(|| plain(Effort::Least)));
        }
        let [ours, same, least] = times.map(|times| median(times).unwrap());
        for (name, time) in [("ours", ours), ("plain, same effort", same), ("plain, least effort", least)] {
            let per_step = 1e9 * time / macro_steps as f64;
            println!(
                "{name:20} {:8.3} ms {per_step:7.0} ns per macro step, {:5.1} times ours",
                1e3 * time,
                time / ours
            );
        }
        println!("demanded of the same effort: at least {DEMANDED} times");
    }
}

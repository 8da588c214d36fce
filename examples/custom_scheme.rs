//! A scheme of one's own beside the built-in ones, in the quick form of shipped experiments:
//! `cargo run --release --example custom_scheme RESULTS experiments/paper/*.toml`

use rimbench::cosim::{CouplingScheme, MicroStep, Sample, Side};
use rimbench::error::{Failure, Result};
use rimbench::harness::{Experiment, compare};
use rimbench::schemes::{SCHEMES, SchemeEntry, register};
use std::path::PathBuf;

/// Holds samples smoothed by half; one list per side that sends.
struct SmoothedHold([Vec<f64>; 2]);

impl CouplingScheme for SmoothedHold {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let share = if sample.step.index == 0 { 1.0 } else { 0.5 };
        self.0[from as usize].iter_mut().zip(sample.y).for_each(|(held, y)| *held += share * (y - *held));
        Ok(())
    }
    fn input(&mut self, to: Side, _: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        u.copy_from_slice(&self.0[to.other() as usize]);
        Ok(())
    }
}

static ENTRY: SchemeEntry = SchemeEntry {
    name: "smoothed-hold",
    about: "Hold samples smoothed by half",
    build: |mechanics, actuator, _| Box::new(SmoothedHold([mechanics, actuator].map(|p| vec![0.0; p.outputs.len()]))),
    ..SCHEMES[0] // Family, order, needs of the zero-order hold.
};

fn main() -> Result<()> {
    register(&ENTRY)?;
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let results = arguments.next().unwrap_or_else(|| "custom-scheme".into());
    let mut tables = arguments
        .map(|file| compare(&Experiment::read(&file)?.with_scheme(ENTRY.name)?, &results, true, &rimbench::BUILD));
    tables.try_for_each(|table| table.map(|table| println!("{table}")))
}

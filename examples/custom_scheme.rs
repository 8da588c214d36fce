//! A scheme of one's own beside the built-in ones, in the quick form of shipped experiments:
//! `cargo run --release --example custom_scheme RESULTS experiments/paper/*.toml`

use rimbench::catalogue::Catalogue;
use rimbench::cosim::{CouplingScheme, MicroStep, PerSide, Sample, Side};
use rimbench::error::{Failure, Result};
use rimbench::harness::{Experiment, compare};
use rimbench::schemes::SchemeEntry;
use std::path::PathBuf;

/// Holds samples smoothed by half; one list per side that sends.
#[derive(Clone)]
struct SmoothedHold(PerSide<Vec<f64>>);

impl CouplingScheme for SmoothedHold {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let share = if sample.step.index == 0 { 1.0 } else { 0.5 };
        self.0[from].iter_mut().zip(sample.y).for_each(|(held, y)| *held += share * (y - *held));
        Ok(())
    }
    fn input(&mut self, to: Side, _: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        u.copy_from_slice(&self.0[to.other()]);
        Ok(())
    }
    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

fn main() -> Result<()> {
    let mut catalogue = Catalogue::standard();
    catalogue.add_scheme(SchemeEntry::new("smoothed-hold", "Hold samples smoothed by half", |construction| {
        Ok(Box::new(SmoothedHold(construction.ports.map(|ports| vec![0.0; ports.outputs.len()]))))
    }))?;
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let results = arguments.next().unwrap_or_else(|| "custom-scheme".into());
    for file in arguments {
        let experiment = Experiment::read(&file)?.with_scheme("smoothed-hold")?;
        println!("{}", compare(&experiment, &catalogue, &results, true, &rimbench::BUILD)?);
    }
    Ok(())
}

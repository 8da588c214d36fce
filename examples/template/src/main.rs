//! A scheme of one's own in a crate of one's own, beside two that are built in: `cargo run --release`

use rimbench::catalogue::Catalogue;
use rimbench::cosim::{CouplingScheme, MicroStep, PerSide, Sample, Side};
use rimbench::error::{Failure, Result};
use rimbench::harness::{Experiment, compare};
use rimbench::schemes::SchemeEntry;
use std::path::Path;

/// Holds the mean of the last two samples; one list of each per side that sends.
#[derive(Clone)]
struct MeanHold(PerSide<[Vec<f64>; 2]>);

impl CouplingScheme for MeanHold {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let [last, mean] = &mut self.0[from];
        for ((last, mean), y) in last.iter_mut().zip(mean).zip(sample.y) {
            // The first sample has nothing before it.
            *mean = if sample.step.index == 0 { *y } else { 0.5 * (*last + *y) };
            *last = *y;
        }
        Ok(())
    }
    fn input(&mut self, to: Side, _: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        u.copy_from_slice(&self.0[to.other()][1]);
        Ok(())
    }
    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

fn main() -> Result<()> {
    let mut catalogue = Catalogue::standard();
    catalogue.add_scheme(SchemeEntry::new("mean-hold", "Hold the mean of the last two samples", |construction| {
        let zeros = |ports: &rimbench::cosim::Ports| vec![0.0; ports.outputs.len()];
        Ok(Box::new(MeanHold(construction.ports.map(|ports| [zeros(ports), zeros(ports)]))))
    }))?;
    // Run ids hash names and not code: a fresh folder after a change of the scheme.
    let experiment = Experiment::read(Path::new("experiments/hold.toml"))?.with_scheme("mean-hold")?;
    println!("{}", compare(&experiment, &catalogue, Path::new("results"), false, &rimbench::BUILD)?);
    Ok(())
}

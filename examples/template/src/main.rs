//! The whole command line of rimbench with a scheme of one's own: `cargo run --release -- list schemes`

use rimbench::cosim::{CouplingScheme, MicroStep, PerSide, Sample, Side};
use rimbench::error::{Failure, Result};
use rimbench::schemes::SchemeEntry;
use std::process::ExitCode;

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

fn main() -> ExitCode {
    rimbench::main(rimbench::everything().and_then(|mut catalogue| {
        catalogue.add_scheme(SchemeEntry::new("smoothed-hold", "Hold samples smoothed by half", |construction| {
            Ok(Box::new(SmoothedHold(construction.ports.map(|ports| vec![0.0; ports.outputs.len()]))))
        }))?;
        Ok(catalogue)
    }))
}

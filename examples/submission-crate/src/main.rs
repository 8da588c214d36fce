//! A scheme as a program: it takes note of samples and answers with inputs.

mod lines;

use lines::{Input, Sample, Scheme, Side, serve};

/// Holds samples smoothed by half.
#[derive(Default)]
struct SmoothedHold {
    /// What is held of each side; nothing before its first sample.
    held: [Vec<f64>; 2],
}

impl Scheme for SmoothedHold {
    fn receive(&mut self, side: Side, sample: &Sample) {
        let held = &mut self.held[side as usize];
        if held.is_empty() {
            held.clone_from(&sample.y);
        }
        for (held, y) in held.iter_mut().zip(&sample.y) {
            *held += 0.5 * (y - *held);
        }
    }

    fn inputs(&mut self, side: Side) -> Vec<Input> {
        // A polynomial in time with one coefficient is a constant.
        self.held[side.other() as usize].iter().map(|held| vec![*held]).collect()
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    serve(SmoothedHold::default)
}

//! `rim-split`: each actuator moves a model of the mechanics of its own, with a guess of what the other actuators do.
//!
//! ```text
//! ŵ' = a + H_ui P_u + Σ_j≠i H_·j G_j + H_·i [G_i + Λ_i (λ_i − G_i)]        0 ≤ ŵ_u⁺ + gap ⟂ P_u ≥ 0        Λ_i ≥ Σ_j |H_ij|/√(H_ii H_jj)
//! ```
//! [`Split`] says what is guessed, and how heavy the own model is. Every model is that of `rim-nonsmooth-gap` with all
//! rows, driven by these forces; of its motion the own row is used. With `joint` there is one model under all forces,
//! `rim-nonsmooth-gap` itself. **Needs** an interface of several rows with an interface model, for `law` output rates;
//! not for the mechanics first. **Order** 2 in H. **Known weakness**: only `blind` shares are proved passive.
//! **Source**: ours; shares after Tonge, Benevolenski, Voroshilov 2012.

use super::construction::{Construction, sent, sent_rates};
use super::entry::SchemeEntry;
use super::reduced_interface::{Contacts, ReducedInterface};
use super::requirement::Requirement;
use super::split::Split;
use crate::cosim::{
    CouplingScheme, Forecast, InterfaceCorrelation, MicroStep, OutputRates, Sample, SchemeReport, Side,
};
use crate::error::{Failure, Result};
use crate::interface_model::ReducedInterfaceModel;

pub(super) fn entry() -> SchemeEntry {
    let mut entry =
        ReducedInterface::entry("rim-split", "Split models: one for each actuator", Contacts::UnilateralWithGaps);
    entry.needs.push(Requirement::SeveralRows);
    let build = |construction: &Construction<'_>| -> Result<Box<dyn CouplingScheme>> {
        if construction.model()?.options.split == Split::Joint {
            return Ok(Box::new(ReducedInterface::new(Contacts::UnilateralWithGaps, construction)?));
        }
        Ok(Box::new(SplitModels::new(construction)?))
    };
    SchemeEntry { splits: true, build: std::sync::Arc::new(build), ..entry }
}

/// The model that one actuator moves.
#[derive(Clone)]
struct Spoke {
    model: ReducedInterface,
    /// Λ of its actuator.
    factor: f64,
    /// Positions and velocities of all rows in its model.
    seen: Vec<f64>,
    /// The change of the force of each actuator by its state in this model, N; by the laws only.
    drift: Vec<f64>,
}

#[derive(Clone)]
struct SplitModels {
    split: Split,
    spokes: Vec<Spoke>,
    /// Forces at `t_k`, their guesses, and the sum of those of the micro steps since.
    force: Vec<f64>,
    guess: Vec<f64>,
    sum: Vec<f64>,
    micro_steps: usize,
    /// The outputs of the mechanics at `t_k`, and how forces follow them.
    start: Vec<f64>,
    rates: OutputRates,
    position: Vec<f64>,
    /// One force per row, and feedthrough.
    driving: Vec<f64>,
    through: Vec<f64>,
    /// Of the free mechanics, and with the contacts closed that push.
    correlation: Correlation,
    loaded: Correlation,
}

impl SplitModels {
    fn new(construction: &Construction<'_>) -> Result<Self> {
        let (n, split) = (construction.interface(), construction.model()?.options.split);
        let spoke = |_| {
            let model = ReducedInterface::new(Contacts::UnilateralWithGaps, construction)?;
            Ok(Spoke { model, factor: 1.0, seen: vec![0.0; 2 * n], drift: vec![0.0; n] })
        };
        let room = || vec![0.0; n];
        Ok(SplitModels {
            split,
            spokes: (0..n).map(spoke).collect::<Result<_>>()?,
            force: room(),
            guess: room(),
            sum: room(),
            micro_steps: 0,
            start: vec![0.0; 2 * n],
            rates: OutputRates::zeros(n, 2 * n),
            position: room(),
            driving: room(),
            through: vec![0.0; 2 * n * n],
            correlation: Correlation::new(n),
            loaded: Correlation::new(n),
        })
    }

    /// Begins a macro step from a model of the mechanics.
    fn begin(&mut self, model: &ReducedInterfaceModel) {
        let first = model.interface_start();
        self.correlation.look_at(|i, j| model.entry(first + i, first + j));
        let n = self.force.len();
        for spoke in &mut self.spokes {
            if let Some(mobility) = spoke.model.loaded_mobility() {
                self.loaded.look_at(|i, j| mobility[i * n + j]);
            }
        }
        for (i, spoke) in self.spokes.iter_mut().enumerate() {
            spoke.factor = match self.split {
                Split::MeanRows | Split::BlindRows => self.correlation.row_sum(i),
                Split::MeanShares | Split::BlindShares => self.force.len() as f64,
                Split::MeanBody | Split::BlindBody | Split::Law | Split::Joint => 1.0,
            };
            spoke.seen.copy_from_slice(&self.start);
            spoke.drift.fill(0.0);
        }
    }

    /// Writes the forces that drive the model of actuator `i`, its own being `own`.
    fn drive(&mut self, i: usize, own: f64, length: f64) {
        let (n, Spoke { factor, seen, drift, .. }) = (self.force.len(), &mut self.spokes[i]);
        if self.split == Split::Law {
            let moved = |gains: &[f64]| -> f64 {
                gains.iter().zip(seen.iter().zip(&self.start)).map(|(gain, (u, start))| gain * (u - start)).sum()
            };
            for (j, drift) in drift.iter_mut().enumerate() {
                let gains = 2 * n * j..2 * n * (j + 1);
                self.driving[j] = self.force[j] + *drift + moved(&self.rates.feedthrough[gains.clone()]);
                *drift += length * (self.rates.rate[j] + moved(&self.rates.rate_gain[gains]));
            }
        } else {
            self.driving.copy_from_slice(&self.guess);
        }
        // A whole body has no need of a guess of the own force.
        let guess = if *factor == 1.0 { own } else { self.guess[i] };
        self.driving[i] = guess + *factor * (own - guess);
    }
}

impl CouplingScheme for SplitModels {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        self.spokes.iter_mut().try_for_each(|spoke| spoke.model.receive(from, sample))?;
        if from == Side::Mechanics {
            self.start.copy_from_slice(sample.y);
            self.begin(sent(sample.model)?);
            return Ok(());
        }
        self.force.copy_from_slice(sample.y);
        match self.split {
            Split::MeanRows | Split::MeanShares | Split::MeanBody if self.micro_steps == 0 => {
                self.guess.copy_from_slice(sample.y);
            }
            Split::MeanRows | Split::MeanShares | Split::MeanBody => {
                let mean = |sum: &f64| sum / self.micro_steps as f64;
                self.guess.iter_mut().zip(&self.sum).for_each(|(guess, sum)| *guess = mean(sum));
            }
            Split::Law => self.rates.copy_from(sent_rates(sample.rates)?),
            Split::BlindRows | Split::BlindShares | Split::BlindBody | Split::Joint => {}
        }
        self.sum.fill(0.0);
        self.micro_steps = 0;
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            u.copy_from_slice(&self.force);
            return Ok(());
        }
        let n = own.len();
        self.sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        self.micro_steps += 1;
        for (i, own) in own.iter().enumerate() {
            self.drive(i, *own, at.length);
            let Spoke { model, seen, .. } = &mut self.spokes[i];
            (seen[i], seen[n + i]) = (u[i], u[n + i]);
            model.input(to, at, &self.driving, seen)?;
            (u[i], u[n + i], self.position[i]) = (seen[i], seen[n + i], seen[i]);
        }
        Ok(())
    }

    /// The model of one actuator follows its own law alone.
    fn receive_feedthrough(&mut self, feedthrough: &[f64]) -> Result<(), Failure> {
        for (i, Spoke { model, factor, .. }) in self.spokes.iter_mut().enumerate() {
            let own = feedthrough.len() / self.force.len();
            self.through.fill(0.0);
            for column in [i, self.force.len() + i] {
                self.through[own * i + column] = *factor * feedthrough[own * i + column];
            }
            model.receive_feedthrough(&self.through)?;
        }
        Ok(())
    }

    fn input_at_end(&self, to: Side, u: &mut [f64]) {
        for (i, spoke) in self.spokes.iter().enumerate() {
            spoke.model.row_at_end(to, i, u);
        }
    }

    fn forecast(&self) -> Option<Forecast<'_>> {
        let closing = self.spokes.iter().filter_map(|spoke| spoke.model.forecast()?.next_closing);
        Some(Forecast { position: &self.position, next_closing: closing.reduce(f64::min) })
    }

    fn report(&mut self) -> SchemeReport {
        let [free, loaded] = [self.correlation.found, self.loaded.found];
        let interface = Some(InterfaceCorrelation {
            lambda: free.lambda.max(loaded.lambda),
            largest: free.largest.max(loaded.largest),
        });
        let reports = self.spokes.iter_mut().map(|spoke| spoke.model.report());
        let sum = reports.reduce(|mut sum, report| {
            sum.counters.add(&report.counters);
            sum
        });
        SchemeReport { interface, ..sum.unwrap_or_default() }
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

/// Correlations `C = D^(−½) H D^(−½)` of the rows of the interface by its mobility H, the worst so far, and the largest eigenvalue λ
/// by power iteration.
#[derive(Clone)]
struct Correlation {
    entries: Vec<f64>,
    vector: Vec<f64>,
    image: Vec<f64>,
    found: InterfaceCorrelation,
}

impl Correlation {
    /// Steps of the iteration per communication point, which starts where it ended at the last one.
    const ITERATIONS: usize = 20;

    fn new(n: usize) -> Self {
        let room = || vec![0.0; n];
        Correlation { entries: vec![0.0; n * n], vector: room(), image: room(), found: <_>::default() }
    }

    /// `Λ_i`, 1 of a row that does not move.
    fn row_sum(&self, i: usize) -> f64 {
        let n = self.vector.len();
        self.entries[i * n..(i + 1) * n].iter().map(|c| c.abs()).sum::<f64>().max(1.0)
    }

    /// Looks at the mobility `h` of two rows.
    fn look_at(&mut self, h: impl Fn(usize, usize) -> f64) {
        let n = self.vector.len();
        for (at, entry) in self.entries.iter_mut().enumerate() {
            let (i, j) = (at / n, at % n);
            let scale = (h(i, i) * h(j, j)).sqrt();
            *entry = if scale > 0.0 { h(i, j) / scale } else { f64::from(i == j) };
            if j < i {
                self.found.largest = self.found.largest.max(entry.abs());
            }
        }
        let Correlation { entries, vector, image, found } = self;
        if vector[0] == 0.0 {
            // Not the vector of a symmetric arrangement, which may have no part in the largest.
            vector.iter_mut().enumerate().for_each(|(i, x)| *x = 1.0 / (1.0 + i as f64));
        }
        for _ in 0..Self::ITERATIONS {
            let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|x| *x /= length);
            for (y, row) in image.iter_mut().zip(entries.chunks_exact(n)) {
                *y = row.iter().zip(&*vector).map(|(c, x)| c * x).sum();
            }
            let rayleigh = vector.iter().zip(&*image).map(|(x, y)| x * y).sum::<f64>();
            found.lambda = found.lambda.max(rayleigh);
            vector.copy_from_slice(image);
        }
    }
}

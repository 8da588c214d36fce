//! `rim-answers`: the actuator moves together with the answers of a mechanics that gives no model, asked while the
//! actuator steps.
//!
//! The actuator goes first, so the mechanics still stands at `t_k` and can be asked by trial steps over the macro step
//! H. To a force λ during all of H it answers with the velocity `W(λ)` at its end; each micro step δ takes its share of
//! the answer to its own force:
//!
//! ```text
//! R(λ) = (W(λ) − w_k)/H          w⁺ = w + δ R(λ)          s⁺ = s_s + t w⁺
//! ```
//! with t since the last of its own steps began, at `s_s`: the model ends each where the mechanics does, which moves by
//! its step times its new velocity. One from outside may take several steps in H, of whatever rule. What its end position
//! `S(λ)` says of them is shared out as well, so that a force that stays leads there:
//!
//! ```text
//! s⁺ = s + δ w⁺ + δ/H (d(λ) + H (H − δ)/2 R(λ))          d(λ) = S(λ) − s_k − H W(λ)
//! ```
//!
//! R is a tangent at the last mean force λ̄ (2 n + 1 trials for n rows), trusted within a range of it. A micro step
//! whose force leaves the range asks one trial there. If the answer is as foreseen the range doubles; if not, a second
//! tangent is taken there, and both meet in a kink: a contact that opens or closes, sticks or slides. Nothing of the
//! actuator is set back, and of the mechanics nothing but copies.
//!
//! **Needs** a mechanics that can be copied, and the actuator first with a force return other than `held`: in parallel
//! the mechanics has left `t_k`. **Order** 2 in H. **Known weakness**: one kink along one direction per macro step; a
//! micro step has the velocity of a mechanics that takes all of H, as in the own-step model. **Source**: ours.

use super::entry::{Family, SchemeEntry};
use super::requirement::Requirement;
use crate::cosim::{
    CouplingScheme, Forecast, MicroStep, Sample, SchemeReport, Sequence, Side, TrialReport, TrialSettings, Trials,
};
use crate::error::Failure;

/// Change of a velocity below which an answer is as foreseen, m/s.
const FLOOR: f64 = 1e-6;
/// By how much forces are changed for a tangent, of their magnitude; at least 1 N.
const CHANGE: f64 = 1e-3;
/// Share of the largest velocity of the run below which velocities are not told apart.
const HELD: f64 = 1e-9;
/// How many times the noise of a velocity is no error.
const NOISE: f64 = 6.0;
/// Beyond a second tangent by this share of its distance it is not trusted.
const BEYOND: f64 = 1.5;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        family: Family::Model,
        order: 2,
        sequence: Sequence::GaussSeidel { first: Side::Actuator },
        needs: vec![
            Requirement::ForceDisplacement,
            Requirement::Trials,
            Requirement::NotMechanicsFirst,
            Requirement::ActuatorFirst,
        ],
        ..SchemeEntry::new(
            "rim-answers",
            "Answers of the mechanics over the macro step, tried on copies when the actuator's force needs them; no model",
            |construction| Ok(Box::new(Answers::new(construction.interface()))),
        )
    }
}

/// A tangent: the answer to one force, and how it moves with the force.
#[derive(Debug, Clone)]
struct Tangent {
    /// The force, on top of the mean one, N.
    offset: Vec<f64>,
    /// R there, m/s², and then d, m.
    rate: Vec<f64>,
    /// ∂R/∂λ, 1/kg, and ∂d/∂λ, m/N, row by row.
    slope: Vec<f64>,
}

impl Tangent {
    fn new(rows: usize) -> Self {
        Tangent { offset: vec![0.0; rows], rate: vec![0.0; 2 * rows], slope: vec![0.0; 2 * rows * rows] }
    }

    /// R of one row, or d n rows further, under a force `offset` on top of the mean one.
    #[inline]
    fn at(&self, row: usize, offset: &[f64]) -> f64 {
        let slope = &self.slope[row * offset.len()..(row + 1) * offset.len()];
        let from_here = slope.iter().zip(offset).zip(&self.offset);
        self.rate[row] + from_here.map(|((slope, offset), own)| slope * (offset - own)).sum::<f64>()
    }

    /// Fills it for a force `mean + offset`, whose end is known, by changes of each force both ways.
    fn take(&mut self, from: &Start<'_>, end: &[f64], room: &mut Room, trials: &mut dyn Trials) -> Result<(), Failure> {
        let (n, length) = (self.offset.len(), trials.length());
        let told = !trials.is_semi_implicit();
        for row in 0..n {
            self.rate[row] = (end[n + row] - from.w[row]) / length;
            self.rate[n + row] = if told { end[row] - from.position[row] - length * end[n + row] } else { 0.0 };
        }
        let Room { force, plus, minus, .. } = room;
        for column in 0..n {
            let own = from.mean[column] + self.offset[column];
            let noisy = if trials.settings().noise > 0.0 { from.range } else { 0.0 };
            let change = (CHANGE * own.abs()).max(1.0).max(noisy);
            for (sign, end) in [(1.0, &mut *plus), (-1.0, &mut *minus)] {
                force
                    .iter_mut()
                    .zip(from.mean.iter().zip(&self.offset))
                    .for_each(|(force, (mean, offset))| *force = mean + offset);
                force[column] += sign * change;
                trials.end_under(force, end)?;
            }
            for row in 0..n {
                let moved = plus[n + row] - minus[n + row];
                let beyond = if told { plus[row] - minus[row] - length * moved } else { 0.0 };
                // What contacts hold moves by round-off of either sign.
                let per_force = |moved: f64, over: f64, unit: f64| {
                    if moved.abs() <= HELD * from.fastest * over { 0.0 } else { moved / (2.0 * change * unit) }
                };
                self.slope[row * n + column] = per_force(moved, 1.0, length);
                self.slope[(n + row) * n + column] = per_force(beyond, length, 1.0);
            }
        }
        Ok(())
    }
}

/// From where tangents are taken.
struct Start<'a> {
    position: &'a [f64],
    w: &'a [f64],
    mean: &'a [f64],
    range: f64,
    fastest: f64,
}

#[derive(Debug, Clone)]
struct Room {
    offset: Vec<f64>,
    force: Vec<f64>,
    end: Vec<f64>,
    plus: Vec<f64>,
    minus: Vec<f64>,
}

#[derive(Debug, Clone)]
struct Answers {
    /// Position, m, and velocity, m/s, at `t_k`, and of the model.
    started_at: Vec<f64>,
    start: Vec<f64>,
    w: Vec<f64>,
    position: Vec<f64>,
    /// The mechanics' own steps per macro step, where the last one began, m, and how long ago, s.
    steps: usize,
    begun_at: Vec<f64>,
    since: f64,
    /// Whether it moves by such a step times its new velocity.
    semi_implicit: bool,
    /// The actuator's force at `t_k`, N.
    force: Vec<f64>,
    /// Mean force of the last macro step, and of this one so far, N.
    mean: Vec<f64>,
    sum: Vec<f64>,
    first: Tangent,
    /// The second tangent, where there is one: `direction` leads there from the first, and `kink` is how far along it
    /// they meet, N.
    second: Option<Tangent>,
    spare: Option<Tangent>,
    direction: Vec<f64>,
    kink: f64,
    /// How far a force may be from the mean one, N.
    trusted: f64,
    was_cut: bool,
    /// Largest mean force, N, and velocity, m/s, of the run so far.
    largest: f64,
    fastest: f64,
    floor: f64,
    /// Whether the model was moved over a macro step.
    moved: bool,
    room: Room,
    report: TrialReport,
    misses: Vec<f64>,
}

fn norm(of: &[f64]) -> f64 {
    of.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn most(of: impl Iterator<Item = f64>) -> f64 {
    of.fold(0.0, |most, x| most.max(x.abs()))
}

impl Answers {
    fn new(rows: usize) -> Self {
        let (zeros, ends) = (|| vec![0.0; rows], || vec![0.0; 2 * rows]);
        Answers {
            started_at: zeros(),
            start: zeros(),
            w: zeros(),
            position: zeros(),
            steps: 1,
            begun_at: zeros(),
            since: 0.0,
            semi_implicit: true,
            force: zeros(),
            mean: zeros(),
            sum: vec![f64::NAN; rows],
            first: Tangent::new(rows),
            second: None,
            spare: Some(Tangent::new(rows)),
            direction: zeros(),
            kink: 0.0,
            trusted: 0.0,
            was_cut: false,
            largest: 0.0,
            fastest: 0.0,
            floor: FLOOR,
            moved: false,
            room: Room { offset: zeros(), force: zeros(), end: ends(), plus: ends(), minus: ends() },
            report: TrialReport::default(),
            misses: Vec::new(),
        }
    }

    /// The tangent on whose side of the kink a force lies.
    #[inline]
    fn tangent(&self, offset: &[f64]) -> &Tangent {
        let along = || self.direction.iter().zip(offset).map(|(u, x)| u * x).sum::<f64>();
        match &self.second {
            Some(second) if along() > self.kink => second,
            _ => &self.first,
        }
    }

    /// Takes the first tangent of a macro step.
    fn begin(&mut self, trials: &mut dyn Trials) -> Result<(), Failure> {
        let TrialSettings { range, noise, .. } = trials.settings();
        self.floor = FLOOR.max(NOISE * noise);
        self.largest = self.largest.max(norm(&self.mean));
        self.fastest = self.fastest.max(most(self.start.iter().copied()));
        self.trusted = (range * self.largest).max(1.0);
        self.was_cut = false;
        if let Some(second) = self.second.take() {
            self.spare = Some(second);
        }
        self.semi_implicit = trials.is_semi_implicit();
        trials.end_under(&self.mean, &mut self.room.end)?;
        let from = Start {
            position: &self.started_at,
            w: &self.start,
            mean: &self.mean,
            range: self.trusted,
            fastest: self.fastest,
        };
        let end = std::mem::take(&mut self.room.end);
        let taken = self.first.take(&from, &end, &mut self.room, trials);
        self.room.end = end;
        taken
    }

    /// Tries the force of `room.offset`, which is not trusted, and takes a second tangent there if the answer is not as
    /// foreseen.
    fn try_there(&mut self, own: &[f64], distance: f64, trials: &mut dyn Trials) -> Result<(), Failure> {
        let n = own.len();
        if !trials.has_left(1, n) {
            self.cut();
            return Ok(());
        }
        let mut end = std::mem::take(&mut self.room.end);
        let tried = trials.end_under(own, &mut end);
        let tangent = self.tangent(&self.room.offset);
        let foreseen = |row: usize| self.start[row] + trials.length() * tangent.at(row, &self.room.offset);
        let miss = most((0..n).map(|row| foreseen(row) - end[n + row]));
        let moved = most((0..n).map(|row| end[n + row] - self.start[row]));
        let as_foreseen = miss <= trials.settings().tolerance * moved + self.floor;
        let done = tried.and_then(|()| {
            if as_foreseen {
                self.trusted = 2.0 * distance;
            } else if trials.has_left(2 * n, n) {
                self.take_second(distance, &end, trials)?;
            } else {
                self.cut();
            }
            Ok(())
        });
        self.room.end = end;
        done
    }

    /// Goes on with what is known, as far as this macro step goes.
    fn cut(&mut self) {
        self.trusted = f64::INFINITY;
        self.report.cut += u64::from(!self.was_cut);
        self.was_cut = true;
    }

    /// Takes a second tangent so far from the first, and finds where both meet.
    ///
    /// ```text
    /// R_0(s u) = R_1(s u)      (H_1 − H_0) u s = r_0 − H_0 o_0 − r_1 + H_1 o_1      by the row that differs most
    /// ```
    fn take_second(&mut self, distance: f64, end: &[f64], trials: &mut dyn Trials) -> Result<(), Failure> {
        let n = self.start.len();
        let Some(mut second) = self.second.take().or_else(|| self.spare.take()) else { return Ok(()) };
        second.offset.copy_from_slice(&self.room.offset);
        for (u, offset) in self.direction.iter_mut().zip(&second.offset) {
            *u = offset / distance;
        }
        let from = Start {
            position: &self.started_at,
            w: &self.start,
            mean: &self.mean,
            range: (trials.settings().range * self.largest).max(1.0),
            fastest: self.fastest,
        };
        second.take(&from, end, &mut self.room, trials)?;
        let origin = vec![0.0; n];
        let (mut steepest, mut kink) = (0.0_f64, 0.5 * distance);
        for row in 0..n {
            let slope = |tangent: &Tangent| {
                self.direction.iter().zip(&tangent.slope[row * n..]).map(|(u, slope)| u * slope).sum::<f64>()
            };
            let bend = slope(&second) - slope(&self.first);
            if bend.abs() > steepest {
                steepest = bend.abs();
                kink = (self.first.at(row, &origin) - second.at(row, &origin)) / bend;
            }
        }
        self.kink = if (0.0..=distance).contains(&kink) { kink } else { 0.5 * distance };
        self.second = Some(second);
        self.trusted = BEYOND * distance;
        self.report.further += 1;
        Ok(())
    }

    /// Notes by how much the end of the macro step was not as foreseen.
    fn judge(&mut self, came: &[f64]) {
        let miss = most(self.w.iter().zip(came).map(|(w, came)| w - came));
        let moved = most(self.start.iter().zip(came).map(|(start, came)| start - came));
        let foreseen = most(self.start.iter().zip(&self.w).map(|(start, w)| start - w));
        self.misses.push((miss / moved.max(foreseen).max(self.floor)).min(1.0));
    }
}

impl CouplingScheme for Answers {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        if from == Side::Actuator {
            self.force.copy_from_slice(sample.y);
            if self.sum.iter().any(|sum| sum.is_nan()) {
                // Before the first macro step.
                self.mean.copy_from_slice(sample.y);
            } else {
                self.mean.copy_from_slice(&self.sum);
            }
            self.sum.fill(0.0);
            return Ok(());
        }
        let (position, w) = sample.y.split_at(self.w.len());
        if self.moved {
            self.judge(w);
        }
        self.moved = false;
        self.steps = sample.mechanics_steps;
        self.started_at.copy_from_slice(position);
        self.position.copy_from_slice(position);
        self.w.copy_from_slice(w);
        self.start.copy_from_slice(w);
        Ok(())
    }

    fn ask(&mut self, at: MicroStep, own: &[f64], trials: &mut dyn Trials) -> Result<(), Failure> {
        if at.index == 0 {
            self.begin(trials)?;
        }
        for (offset, (own, mean)) in self.room.offset.iter_mut().zip(own.iter().zip(&self.mean)) {
            *offset = own - mean;
        }
        let distance = norm(&self.room.offset);
        if distance > self.trusted && distance.is_finite() {
            self.try_there(own, distance, trials)?;
        }
        if at.index + 1 == at.count {
            self.report.count += trials.taken() as u64;
            self.report.most = self.report.most.max(trials.taken() as u64);
        }
        Ok(())
    }

    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            u.copy_from_slice(&self.force);
            return Ok(());
        }
        let n = own.len();
        for (row, own) in own.iter().enumerate() {
            self.room.offset[row] = own - self.mean[row];
            self.sum[row] += own / at.count as f64;
        }
        if at.index * self.steps % at.count < self.steps {
            self.begun_at.copy_from_slice(&self.position);
            self.since = 0.0;
        }
        self.since += at.length;
        let (length, whole) = (at.length, at.length * at.count as f64);
        for row in 0..n {
            let tangent = self.tangent(&self.room.offset);
            let rate = tangent.at(row, &self.room.offset);
            let beyond = if self.semi_implicit { 0.0 } else { tangent.at(n + row, &self.room.offset) };
            let w = self.w[row] + length * rate;
            self.w[row] = w;
            self.position[row] = if self.semi_implicit {
                self.begun_at[row] + self.since * w
            } else {
                self.position[row] + length * w + length / whole * beyond + 0.5 * length * (whole - length) * rate
            };
            (u[row], u[n + row]) = (self.position[row], w);
        }
        self.moved = true;
        Ok(())
    }

    fn forecast(&self) -> Option<Forecast<'_>> {
        Some(Forecast { position: &self.position, next_closing: None })
    }

    fn report(&mut self) -> SchemeReport {
        self.misses.sort_by(f64::total_cmp);
        let miss =
            [self.misses.get(self.misses.len() / 2), self.misses.last()].map(|miss| miss.copied().unwrap_or(0.0));
        let trials = (self.report.count > 0).then_some(TrialReport { miss, ..self.report });
        SchemeReport { trials, ..SchemeReport::default() }
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::MacroStep;

    const STEP: MacroStep = MacroStep { index: 0, start: 0.0, length: 0.5 };
    const START: [f64; 2] = [0.7, 1.2];

    /// A free body of 2 kg whose steps are exact.
    struct Exact;

    impl Trials for Exact {
        fn length(&self) -> f64 {
            STEP.length
        }

        fn taken(&self) -> usize {
            0
        }

        fn settings(&self) -> TrialSettings {
            TrialSettings::default()
        }

        fn is_semi_implicit(&self) -> bool {
            false
        }

        fn end_under(&mut self, force: &[f64], end: &mut [f64]) -> Result<(), Failure> {
            let moved = STEP.length * force[0] / 2.0;
            end.copy_from_slice(&[START[0] + STEP.length * (START[1] + 0.5 * moved), START[1] + moved]);
            Ok(())
        }
    }

    #[test]
    fn a_force_that_stays_leads_to_the_position_and_velocity_that_the_mechanics_has_told() {
        let (mut scheme, force) = (Answers::new(1), [3.0]);
        scheme.receive(Side::Actuator, &Sample::of_outputs(STEP, &force, 0.1)).unwrap();
        scheme.receive(Side::Mechanics, &Sample::of_outputs(STEP, &START, 0.1)).unwrap();
        let (mut u, mut end) = ([0.0; 2], [0.0; 2]);
        for index in 0..5 {
            let at = MicroStep::new(STEP, index, 5);
            scheme.ask(at, &force, &mut Exact).unwrap();
            scheme.input(Side::Actuator, at, &force, &mut u).unwrap();
        }
        Exact.end_under(&force, &mut end).unwrap();
        for (u, end) in u.iter().zip(end) {
            approx::assert_relative_eq!(*u, end, max_relative = 1e-14);
        }
    }
}

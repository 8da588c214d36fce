//! The two chambers of a cylinder as lossless lines from the valve to the piston, for the scheme `hydraulic-line`.

use super::HydraulicCylinder;
use rimbench_core::cosim::{EnergyAccount, LineForces, MacroStep, TransmissionLines};
use wide::f64x2;

/// Into which chamber the piston presses as it moves out.
const DISPLACED: [f64; 2] = [1.0, -1.0];

/// One end of a line: what arrives there, and what its pressure (Pa) and the flow into the line (m³/s) were, by micro
/// step.
#[derive(Debug, Clone, PartialEq)]
struct End {
    arriving: Vec<f64>,
    pressure: Vec<f64>,
    flow: Vec<f64>,
}

impl End {
    fn new(micro_steps: usize, pressure: f64, flow: f64) -> Self {
        End { arriving: vec![0.0; micro_steps], pressure: vec![pressure; micro_steps], flow: vec![flow; micro_steps] }
    }

    fn set(&mut self, j: usize, pressure: f64, flow: f64) {
        (self.pressure[j], self.flow[j]) = (pressure, flow);
    }

    /// The wave that leaves in a micro step, Pa.
    fn departing(&self, j: usize, impedance: f64) -> f64 {
        self.pressure[j] + impedance * self.flow[j]
    }
}

/// The oil of one chamber.
#[derive(Debug, Clone, PartialEq)]
struct Line {
    /// Z, Pa·s/m³.
    impedance: f64,
    piston: End,
    valve: End,
}

impl Line {
    /// The wave that arrives at the piston (first) or the valve in micro step `j`, α of it what arrived there before.
    fn next_arrival(&self, j: usize, smoothing: f64) -> [f64; 2] {
        [(&self.piston, &self.valve), (&self.valve, &self.piston)].map(|(end, other)| {
            let fresh = other.departing(j, self.impedance);
            if smoothing == 0.0 { fresh } else { smoothing * end.arriving[j] + (1.0 - smoothing) * fresh }
        })
    }
}

/// Both chambers as lines, and the account of their energy.
///
/// A wave c carries the power `c²/(4Z)`, so the power into an end, `p q = ((p + Z q)² − c²)/(4Z)`, is the difference of
/// two waves, and the stored energy the sum of those under way. Anything else that changes it is booked as integration
/// residual: the line laid anew at each communication point with the Z of then, waves smoothed, and the motion that the
/// piston was told replaced by the one it had.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lines {
    smoothing: f64,
    lines: [Line; 2],
    scratch: Vec<f64>,
    /// Micro steps of the present macro step, how many of them are done, and how long they are, s; none before the
    /// start.
    count: usize,
    done: usize,
    micro_step: f64,
    begun: f64,
    motion: [f64; 2],
    /// Of the waves under way, J.
    energy: f64,
    account: EnergyAccount,
}

impl Lines {
    pub(super) fn account(&self) -> EnergyAccount {
        self.account
    }

    /// Waves that arrive at the two pistons now; none before the lines are in use.
    fn arrivals(&self) -> Option<[f64; 2]> {
        (self.count > 0).then(|| {
            self.lines.each_ref().map(|line| match line.piston.arriving[..self.count].get(self.done) {
                Some(&wave) => wave,
                // At the end of the macro step the next one's are known.
                None => line.next_arrival(0, self.smoothing)[0],
            })
        })
    }

    /// `Σ δ c²/(4Z)` over all waves under way, once those of a macro step have set out.
    fn energy_of_arrivals(&self) -> f64 {
        let of = |line: &Line, waves: &[f64]| waves.iter().map(|c| c * c).sum::<f64>() / (4.0 * line.impedance);
        let each = self
            .lines
            .iter()
            .map(|line| of(line, &line.piston.arriving[..self.count]) + of(line, &line.valve.arriving[..self.count]));
        self.micro_step * each.sum::<f64>()
    }

    /// Corrects what the pistons did over the last macro step: a straight line with the right mean, given the motion
    /// now.
    fn correct_pistons(&mut self, area: f64, now: f64, [s, w]: [f64; 2]) {
        let (mean, rise) = ((s - self.motion[0]) / (now - self.begun), w - self.motion[1]);
        for (line, displaced) in self.lines.iter_mut().zip(DISPLACED) {
            for j in 0..self.count {
                let velocity = mean + rise * ((j as f64 + 0.5) / self.count as f64 - 0.5);
                let flow = displaced * area * velocity;
                line.piston.set(j, line.piston.arriving[j] + line.impedance * flow, flow);
            }
        }
    }

    /// Sends the waves of the last macro step on their way through the coming one of `micro_steps`.
    fn turn_over(&mut self, micro_steps: usize, impedances: [f64; 2]) {
        let (old, smoothing, scratch) = (self.count, self.smoothing, &mut self.scratch);
        for (line, impedance) in self.lines.iter_mut().zip(impedances) {
            line.impedance = impedance;
            for end in 0..2 {
                for (j, value) in scratch[..micro_steps].iter_mut().enumerate() {
                    *value = mean_over(old, j, micro_steps, |j| line.next_arrival(j, smoothing)[end]);
                }
                let target = if end == 0 { &mut line.piston.arriving } else { &mut line.valve.arriving };
                target[..micro_steps].copy_from_slice(&scratch[..micro_steps]);
            }
        }
        self.count = micro_steps;
    }
}

/// Mean over part `index` of `parts` equal parts of what is given by `count` equal pieces.
fn mean_over(count: usize, index: usize, parts: usize, piece: impl Fn(usize) -> f64) -> f64 {
    if count == parts {
        return piece(index);
    }
    // In units of 1/(count·parts) of the macro step all borders are integers.
    let (from, to) = (index * count, (index + 1) * count);
    let pieces = from / parts..count.min(to.div_ceil(parts));
    let share = |j: usize| (to.min((j + 1) * parts) - from.max(j * parts)) as f64 / count as f64;
    pieces.map(|j| share(j) * piece(j)).sum()
}

impl TransmissionLines for HydraulicCylinder {
    fn lay(&mut self, micro_steps: usize, smoothing: f64) {
        // As if pressures and flows had been what they are for long.
        let flows = self.valve_flows(self.p, self.spool.at(self.time));
        let line = |i: usize| {
            let (p, [inflow, outflow]) = (self.pressures()[i], flows.map(|flows| flows.to_array()[i]));
            Line {
                impedance: f64::NAN,
                piston: End::new(micro_steps, p, 0.0),
                valve: End::new(micro_steps, p, inflow - outflow),
            }
        };
        self.lines = Some(Box::new(Lines {
            smoothing,
            lines: [line(0), line(1)],
            scratch: vec![0.0; micro_steps],
            count: 0,
            done: 0,
            micro_step: 0.0,
            begun: 0.0,
            motion: [0.0; 2],
            energy: 0.0,
            account: EnergyAccount::default(),
        }));
    }

    fn exchange(&mut self, step: MacroStep, micro_steps: usize, u: &[f64], forces: &mut LineForces) {
        let (motion, area) = ([u[0], u[1]], self.size.piston_area_m2);
        let Some(mut lines) = self.lines.take() else { return };
        let started = lines.count > 0;
        if started {
            lines.correct_pistons(area, step.start, motion);
            self.p = f64x2::new(lines.lines.each_ref().map(|line| line.piston.pressure[lines.count - 1]));
        } else {
            for (line, displaced) in lines.lines.iter_mut().zip(DISPLACED) {
                line.piston.flow.fill(displaced * area * motion[1]);
            }
            lines.count = micro_steps;
        }
        let chambers = self.chambers(motion[0]);
        let travel = step.length / (1.0 - lines.smoothing);
        let impedances = (self.oil.stiffness(self.p, self.volumes(chambers)) * f64x2::splat(travel)).to_array();
        if !started {
            for (line, impedance) in lines.lines.iter_mut().zip(impedances) {
                line.impedance = impedance;
                for j in 0..micro_steps {
                    // Nothing arrived before the start: what α would keep is what comes.
                    let waves = line.next_arrival(j, 0.0);
                    (line.piston.arriving[j], line.valve.arriving[j]) = (waves[0], waves[1]);
                }
            }
        }
        lines.turn_over(micro_steps, impedances);
        (lines.done, lines.micro_step) = (0, step.length / micro_steps as f64);
        (lines.begun, lines.motion) = (step.start, motion);
        let energy = lines.energy_of_arrivals();
        if started {
            lines.account.integration += energy - lines.energy;
            lines.account.stored += energy - lines.energy;
        }
        lines.energy = energy;
        let [first, second] = &lines.lines;
        forces.begin(&[area * area * (first.impedance + second.impedance) + self.size.viscous_friction_n_s_m]);
        for j in 0..micro_steps {
            forces.push(&[area * (second.piston.arriving[j] - first.piston.arriving[j])]);
        }
        self.p = f64x2::new([0, 1].map(|i| {
            let line = &lines.lines[i];
            line.piston.arriving[0] + line.impedance * DISPLACED[i] * area * motion[1]
        }));
        self.lines = Some(lines);
    }
}

impl HydraulicCylinder {
    /// Pressures at the piston for a velocity, Pa; none where the chambers are no lines.
    pub(super) fn line_pressures(&self, velocity: f64) -> Option<[f64; 2]> {
        let lines = self.lines.as_ref()?;
        let arrivals = lines.arrivals()?;
        Some(
            [0, 1].map(|i| arrivals[i] + lines.lines[i].impedance * DISPLACED[i] * self.size.piston_area_m2 * velocity),
        )
    }

    /// `F` for a velocity, N.
    #[inline(never)]
    pub(super) fn force_of_lines(&self, velocity: f64) -> f64 {
        self.size.force(self.line_pressures(velocity).unwrap_or(self.pressures()), velocity)
    }

    /// One micro step of the lines; false where the chambers are none.
    pub(super) fn step_lines(&mut self, spool: f64, velocity: f64, h: f64) -> bool {
        let Some(pressures) = self.line_pressures(velocity) else { return false };
        let Some(mut lines) = self.lines.take() else { return false };
        let j = lines.done;
        let displacement = self.size.piston_area_m2 * velocity;
        let mut valve_pressures = [0.0; 2];
        let mut change = 0.0;
        for i in 0..2 {
            let line = &mut lines.lines[i];
            let arriving = line.valve.arriving[j];
            let pressure = self.valve_pressure(i, arriving, line.impedance, spool, line.valve.pressure[j]);
            valve_pressures[i] = pressure;
            let [inflow, outflow] = self.valve_flows(f64x2::splat(pressure), spool).map(|flows| flows.to_array()[i]);
            line.valve.set(j, pressure, inflow - outflow);
            line.piston.set(j, pressures[i], DISPLACED[i] * displacement);
            change += h * (pressures[i] * line.piston.flow[j] + pressure * line.valve.flow[j]);
            let [supply, tank] = [self.oil.supply, self.oil.tank].map(|each| each.to_array()[0]);
            lines.account.pump += h * supply * inflow;
            lines.account.valve += h * ((supply - pressure) * inflow + (pressure - tank) * outflow);
            lines.account.tank += h * tank * outflow;
        }
        let friction = self.size.viscous_friction_n_s_m * velocity * velocity;
        lines.account.viscous += h * friction;
        lines.account.interface += h * (friction - (pressures[1] - pressures[0]) * displacement);
        // The valve equation is met to the tolerance of its solution: stored is what the waves are.
        let waves = |line: &Line| {
            let gain = |end: &End| end.departing(j, line.impedance).powi(2) - end.arriving[j].powi(2);
            (gain(&line.piston) + gain(&line.valve)) / (4.0 * line.impedance)
        };
        let stored = h * lines.lines.iter().map(waves).sum::<f64>();
        lines.account.stored += stored;
        lines.account.integration += stored - change;
        lines.energy += stored;
        lines.done += 1;
        let mut of_piston = pressures;
        let beyond = valve_pressures.iter().find(|p| !self.is_valid(**p));
        if let Some(&beyond) = beyond {
            // The end of the line at the valve has no name of its own among the observables: the chamber is out of its
            // range.
            let chamber = usize::from(beyond != valve_pressures[0]);
            of_piston[chamber] = beyond;
        }
        self.p = f64x2::new(of_piston);
        self.lines = Some(lines);
        true
    }

    /// Solves `p = c + Z q(p)` at the valve of a chamber by Newton's method inside a bracket; q falls with p, so the
    /// root is one.
    fn valve_pressure(&self, chamber: usize, arriving: f64, impedance: f64, spool: f64, guess: f64) -> f64 {
        let [supply, tank] = [self.oil.supply, self.oil.tank].map(|each| each.to_array()[0]);
        let openings = self.openings(spool);
        let (k_in, k_out) = (openings[chamber], openings[1 - chamber]);
        // Above the pump's pressure nothing flows in, below the tank's nothing out.
        let (mut low, mut high) = (arriving.min(tank), arriving.max(supply));
        let mut p = guess.clamp(low, high);
        for _ in 0..100 {
            let (rise, fall) = ((supply - p).max(0.0).sqrt(), (p - tank).max(0.0).sqrt());
            let excess = p - arriving - impedance * (k_in * rise - k_out * fall);
            if excess > 0.0 {
                high = p
            } else {
                low = p
            }
            let slope = 1.0 + 0.5 * impedance * (k_in / rise + k_out / fall);
            let newton = p - excess / slope;
            // An infinite slope, where an orifice has no drop, makes a step of nothing.
            let inside = slope.is_finite() && newton > low && newton < high;
            let next = if inside { newton } else { 0.5 * (low + high) };
            if (next - p).abs() <= 1e-12 * supply {
                return next;
            }
            p = next;
        }
        p
    }
}

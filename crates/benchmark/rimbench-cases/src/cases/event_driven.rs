//! Exact solution of one mass that a spring actuator drives between stops, from impact to impact.

use crate::models::{Carriage, LineMass, exponential};
use nalgebra::{SMatrix, SVector};
use rimbench_core::cosim::StopFlag;

/// `[x, ẋ, x_a, ẋ_a, sin, cos, 1]`.
pub(super) type State = SVector<f64, 7>;
type Generator = SMatrix<f64, 7, 7>;

/// A stop: the mass stays where `side (x − position) ≥ 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stop {
    /// +1 for a stop below, −1 for one above.
    pub(super) side: f64,
    /// m.
    pub(super) position: f64,
}

impl Stop {
    /// Gap of a mass at `x`, m.
    pub(super) fn gap(&self, x: f64) -> f64 {
        self.side * (x - self.position)
    }
}

/// One mass between stops, held by an actuator.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DrivenMass {
    pub(super) body: LineMass,
    pub(super) stops: Vec<Stop>,
    pub(super) restitution: f64,
    pub(super) actuator: Carriage,
}

impl DrivenMass {
    /// Force of the actuator on the mass, N.
    pub(super) fn force(&self, z: &State) -> f64 {
        self.actuator.spring_stiffness_n_m * (z[2] - z[0]) + self.actuator.spring_damping_n_s_m * (z[3] - z[1])
    }

    /// `ż = A z`; a stuck mass has no velocity.
    fn rate(&self, z: &State, stuck: bool) -> State {
        let a = &self.actuator;
        let omega = a.angular_frequency();
        let (swing, swing_rate) = (a.base_amplitude_m * z[4], a.base_amplitude_m * omega * z[5]);
        let force = self.force(z);
        let mass = if stuck { [0.0; 2] } else { [z[1], self.acceleration(z)] };
        let carriage = if a.carriage_mass_kg > 0.0 {
            let pull = a.base_stiffness_n_m * (a.base_position_m * z[6] + swing - z[2])
                + a.base_damping_n_s_m * (swing_rate - z[3]);
            (pull - force) / a.carriage_mass_kg
        } else {
            -omega * omega * swing
        };
        State::from([mass[0], mass[1], z[3], carriage, omega * z[5], -omega * z[4], 0.0])
    }

    /// Acceleration of the mass without contact, m/s².
    fn acceleration(&self, z: &State) -> f64 {
        let body = &self.body;
        let spring = body.stiffness * (z[0] - body.anchor * z[6]);
        (body.load * z[6] - spring - body.damping * z[1] + self.force(z)) / body.mass
    }

    fn generator(&self, stuck: bool) -> Generator {
        let mut generator = Generator::zeros();
        for column in 0..7 {
            let mut unit = State::zeros();
            unit[column] = 1.0;
            generator.set_column(column, &self.rate(&unit, stuck));
        }
        generator
    }

    fn initial_state(&self) -> State {
        let a = &self.actuator;
        let (sine, cosine) = libm::sincos(a.base_phase_rad);
        let [position, velocity] = a.start();
        State::from([self.body.start[0], self.body.start[1], position, velocity, sine, cosine, 1.0])
    }
}

/// A piece of the solution without impact.
#[derive(Debug, Clone)]
struct Piece {
    since: f64,
    state: State,
    /// The stop that holds the mass.
    stuck: Option<usize>,
}

/// The solution as pieces between impacts, worked out as far as it is asked for.
///
/// ```text
/// free    ż = A z,    z(t) = exp(A (t − t_n)) z_n
/// impact  g = 0, ġ < 0:  ẋ⁺ = −e ẋ⁻
/// stuck   ẋ = 0 while the acceleration points into the stop
/// ```
/// Events are bracketed on a grid and found by bisection to round-off. A rebound slower than [`SLOWEST`] counts as
/// rest: a Zeno sequence is cut off there. A contact shorter than the grid, which is a graze of a depth below `a Δ²/8`,
/// is missed. After [`MOST_IMPACTS`] the state is not a number.
pub(super) struct EventDriven {
    system: DrivenMass,
    pieces: Vec<Piece>,
    impacts: Vec<Impact>,
    free: Generator,
    held: Generator,
    /// Free and held, over one grid distance.
    steps: [Generator; 2],
    /// Where the solution ends so far.
    time: f64,
    state: State,
    stuck: Option<usize>,
}

/// One impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Impact {
    /// s.
    pub(super) time: f64,
    /// Velocity of the mass just before, m/s.
    pub(super) velocity: f64,
}

/// Distance of the points between which events are looked for, s.
const GRID: f64 = 1e-4;
/// Rebounds below this count as rest, m/s: their height of some 1e-14 m is at the rounding of a gap.
const SLOWEST: f64 = 1e-6;
/// No case is meant to have as many.
const MOST_IMPACTS: usize = 100_000;

impl EventDriven {
    pub(super) fn new(system: DrivenMass) -> Self {
        let (free, held) = (system.generator(false), system.generator(true));
        let state = system.initial_state();
        let mut solution = EventDriven {
            steps: [exponential(&(free * GRID)), exponential(&(held * GRID))],
            system,
            pieces: Vec::new(),
            impacts: Vec::new(),
            free,
            held,
            time: 0.0,
            state,
            stuck: None,
        };
        solution.stuck = solution.resting_on(&state);
        solution.pieces.push(Piece { since: 0.0, state, stuck: solution.stuck });
        solution
    }

    /// Works the solution out up to `end` (s).
    fn extend_to(&mut self, end: f64, flag: StopFlag<'_>) {
        while self.time < end && flag.check().is_ok() {
            let next = self.steps[usize::from(self.stuck.is_some())] * self.state;
            let event = match self.stuck {
                Some(stop) => self.releases(&next, stop).then_some(stop),
                None => (0..self.system.stops.len()).find(|&stop| self.gap(&next, stop) < 0.0),
            };
            match event {
                Some(stop) => self.pass_event(stop),
                None => (self.time, self.state) = (self.time + GRID, next),
            }
        }
    }

    /// Goes on to the event at `stop`, which is less than a grid distance away, and through it.
    fn pass_event(&mut self, stop: usize) {
        let after = self.first_time(stop);
        let mut state = exponential(&(self.of(self.stuck) * after)) * self.state;
        self.time += after;
        if self.stuck.take().is_none() {
            self.impacts.push(Impact { time: self.time, velocity: state[1] });
            state[0] = self.system.stops[stop].position;
            state[1] *= -self.system.restitution;
            if state[1].abs() < SLOWEST && !self.releases(&state, stop) {
                state[1] = 0.0;
                self.stuck = Some(stop);
            }
        }
        if self.impacts.len() >= MOST_IMPACTS {
            state.fill(f64::NAN);
        }
        self.state = state;
        self.pieces.push(Piece { since: self.time, state, stuck: self.stuck });
    }

    fn of(&self, stuck: Option<usize>) -> &Generator {
        if stuck.is_some() { &self.held } else { &self.free }
    }

    fn gap(&self, z: &State, stop: usize) -> f64 {
        self.system.stops[stop].gap(z[0])
    }

    /// Whether the mass, at rest on a stop, is pulled off it.
    fn releases(&self, z: &State, stop: usize) -> bool {
        self.system.stops[stop].side * self.system.acceleration(z) > 0.0
    }

    /// The stop that a mass at rest is held by.
    fn resting_on(&self, z: &State) -> Option<usize> {
        let touching = |stop: &usize| self.gap(z, *stop) <= 0.0 && z[1] == 0.0;
        (0..self.system.stops.len()).find(|stop| touching(stop) && !self.releases(z, *stop))
    }

    /// Time from here at which the event at `stop` happens, given that it has happened one grid distance later.
    fn first_time(&self, stop: usize) -> f64 {
        let (z, stuck) = (&self.state, self.stuck);
        let (mut before, mut after) = (0.0, GRID);
        // Halving 1e-4 s: after 80 times nothing is left of it. At the lower end itself the gap may be rounded below 0.
        for _ in 0..80 {
            let middle = 0.5 * (before + after);
            let there = exponential(&(self.of(stuck) * middle)) * z;
            let happened = if stuck.is_some() { self.releases(&there, stop) } else { self.gap(&there, stop) < 0.0 };
            if happened {
                after = middle;
            } else {
                before = middle;
            }
        }
        after
    }

    /// The state at time `t`, and whether a stop holds the mass; no numbers if the flag was raised before it was found.
    pub(super) fn at(&mut self, t: f64, flag: StopFlag<'_>) -> (State, bool) {
        self.extend_to(t, flag);
        if self.time < t {
            return (State::repeat(f64::NAN), false);
        }
        let piece = &self.pieces[self.pieces.partition_point(|piece| piece.since <= t).saturating_sub(1)];
        (exponential(&(self.of(piece.stuck) * (t - piece.since))) * piece.state, piece.stuck.is_some())
    }

    /// All impacts up to time `t`.
    #[cfg(test)]
    pub(super) fn impacts(&mut self, t: f64) -> &[Impact] {
        self.extend_to(t, StopFlag::never());
        &self.impacts[..self.impacts.partition_point(|impact| impact.time <= t)]
    }
}

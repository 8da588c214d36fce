//! One side of a co-simulation.

mod capabilities;

pub use capabilities::{Capabilities, FIRST_ORDER_ONLY, NO_CONTACTS};

use super::ports::Ports;
use super::side::PerSide;
use crate::error::Failure;
use rimbench_contact::complementarity::SolverCounters;

/// Exact work counters of a subsystem.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SubsystemCounters {
    /// Micro steps taken.
    pub micro_steps: u64,
    /// Eliminations Eq. 3 → Eq. 4.
    pub eliminations: u64,
    /// Steps of the mechanics cut short at an event; the trial that went beyond it is among the micro steps.
    pub splits: u64,
    /// Steps with so many events that their rest was taken with the gap law.
    pub split_fallbacks: u64,
    /// Complementarity solves.
    pub solver: SolverCounters,
}

impl SubsystemCounters {
    /// Adds other counts.
    pub fn add(&mut self, other: &SubsystemCounters) {
        self.micro_steps += other.micro_steps;
        self.eliminations += other.eliminations;
        self.splits += other.splits;
        self.split_fallbacks += other.split_fallbacks;
        self.solver.add(&other.solver);
    }

    /// Returns the counts on top of `earlier` ones of this subsystem.
    pub fn since(&self, earlier: &SubsystemCounters) -> Self {
        SubsystemCounters {
            micro_steps: self.micro_steps - earlier.micro_steps,
            eliminations: self.eliminations - earlier.eliminations,
            splits: self.splits - earlier.splits,
            split_fallbacks: self.split_fallbacks - earlier.split_fallbacks,
            solver: self.solver.since(&earlier.solver),
        }
    }
}

/// One side of a co-simulation, with its own solver.
///
/// The macro loop calls, at each communication point, [`outputs`](Self::outputs), then, if the scheme needs one, the
/// [`interface_model`](Capabilities::interface_model); then for each micro step `outputs` and [`step`](Self::step).
/// There is no way back: non-iterative coupling is a property of this trait. What iterates, or tries a step, works on
/// copies.
///
/// No method has a default: a wrapper that forgets to hand one on does not compile.
pub trait Subsystem: Send {
    /// Names the coupling variables.
    fn ports(&self) -> &Ports;

    /// Writes the outputs `y` of the present state; `u` matters only with direct feedthrough.
    ///
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure>;

    /// Advances from `t` by one micro step `h` (s) with the input held.
    ///
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure>;

    /// Returns the subsystem's optional capabilities: itself, or the capabilities of the subsystem that it wraps.
    fn capabilities(&mut self) -> &mut dyn Capabilities;

    /// Returns exact work counters.
    fn counters(&self) -> SubsystemCounters;

    /// Returns a copy in the present state, counters included.
    ///
    /// # Errors
    /// [`Cause::NotCopied`](crate::error::Cause::NotCopied) if it cannot be copied,
    /// [`Cause::NotOffered`](crate::error::Cause::NotOffered) where more is to be said of why.
    fn try_clone(&self) -> Result<Box<dyn Subsystem>, Failure>;
}

/// Writes methods of a [`Subsystem`] that read alike in many, by name.
///
/// ```text
/// subsystem_methods!(ports capabilities counters clone);     // fields `ports` and `counters`, its own capabilities, copies by `Clone`
/// subsystem_methods!(no_counters no_clone);                  // counts nothing, cannot be copied
/// subsystem_methods!(outputs_of_inner step_of_inner);        // handed on to the field `inner`
/// ```
#[macro_export]
macro_rules! subsystem_methods {
    ($($method:ident)+) => { $($crate::subsystem_methods!(@$method);)+ };
    (@ports) => {
        fn ports(&self) -> &$crate::cosim::Ports { &self.ports }
    };
    (@ports_of_inner) => {
        fn ports(&self) -> &$crate::cosim::Ports { self.inner.ports() }
    };
    (@outputs_of_inner) => {
        fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), $crate::error::Failure> { self.inner.outputs(u, y) }
    };
    (@step_of_inner) => {
        fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), $crate::error::Failure> { self.inner.step(t, u, h) }
    };
    (@capabilities) => {
        fn capabilities(&mut self) -> &mut dyn $crate::cosim::Capabilities { self }
    };
    (@capabilities_of_inner) => {
        fn capabilities(&mut self) -> &mut dyn $crate::cosim::Capabilities { self.inner.capabilities() }
    };
    (@counters) => {
        fn counters(&self) -> $crate::cosim::SubsystemCounters { self.counters }
    };
    (@no_counters) => {
        fn counters(&self) -> $crate::cosim::SubsystemCounters { Default::default() }
    };
    (@counters_of_inner) => {
        fn counters(&self) -> $crate::cosim::SubsystemCounters { self.inner.counters() }
    };
    (@clone) => {
        fn try_clone(&self) -> Result<Box<dyn $crate::cosim::Subsystem>, $crate::error::Failure> { Ok(Box::new(self.clone())) }
    };
    (@no_clone) => {
        fn try_clone(&self) -> Result<Box<dyn $crate::cosim::Subsystem>, $crate::error::Failure> {
            Err($crate::error::Cause::NotCopied.into())
        }
    };
}

pub use crate::subsystem_methods;

/// Both sides, lent.
pub type Sides<'a> = PerSide<&'a mut (dyn Subsystem + 'a)>;

impl Sides<'_> {
    /// Lends them on for a while.
    pub fn lend(&mut self) -> Sides<'_> {
        PerSide { mechanics: &mut *self.mechanics, actuator: &mut *self.actuator }
    }

    /// Returns their coupling variables.
    pub fn ports(&self) -> PerSide<&Ports> {
        PerSide { mechanics: self.mechanics.ports(), actuator: self.actuator.ports() }
    }
}

impl PerSide<Box<dyn Subsystem>> {
    /// Lends both.
    pub fn lend(&mut self) -> Sides<'_> {
        PerSide { mechanics: &mut *self.mechanics, actuator: &mut *self.actuator }
    }
}

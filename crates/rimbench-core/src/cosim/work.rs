//! Exact counts of the work behind a run, wherever it was done.

use super::report::CosimCounters;
use super::subsystem::SubsystemCounters;
use crate::complementarity::SolverCounters;

/// Work of the loop, of both sides and of the scheme; what was done on copies and thrown away included.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// The loop.
    pub cosim: CosimCounters,
    /// The mechanics.
    pub mechanics: SubsystemCounters,
    /// The actuator.
    pub actuator: SubsystemCounters,
    /// Complementarity solves inside the scheme.
    pub scheme: SolverCounters,
}

impl Work {
    /// Adds other work.
    pub(super) fn add(&mut self, other: &Work) {
        self.cosim.macro_steps += other.cosim.macro_steps;
        self.cosim.repeated_macro_steps += other.cosim.repeated_macro_steps;
        self.cosim.exchanges += other.cosim.exchanges;
        self.mechanics.add(&other.mechanics);
        self.actuator.add(&other.actuator);
        self.scheme.add(&other.scheme);
    }

    /// What came on top of `earlier`, the work of the same lineage of copies.
    pub(super) fn since(&self, earlier: &Work) -> Work {
        Work {
            cosim: CosimCounters {
                macro_steps: self.cosim.macro_steps - earlier.cosim.macro_steps,
                repeated_macro_steps: self.cosim.repeated_macro_steps - earlier.cosim.repeated_macro_steps,
                exchanges: self.cosim.exchanges - earlier.cosim.exchanges,
            },
            mechanics: self.mechanics.since(&earlier.mechanics),
            actuator: self.actuator.since(&earlier.actuator),
            scheme: self.scheme.since(&earlier.scheme),
        }
    }

    /// The same work as that of macro steps which led nowhere.
    pub(super) fn discarded(mut self) -> Work {
        self.cosim.repeated_macro_steps += self.cosim.macro_steps;
        self.cosim.macro_steps = 0;
        self
    }
}

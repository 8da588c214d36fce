//! Exact counts of the work behind a run, wherever it was done.

use super::side::PerSide;
use super::subsystem::SubsystemCounters;
use rimbench_contact::complementarity::SolverCounters;

/// Exact counters of the loop itself.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CosimCounters {
    /// Macro steps that the solution is made of.
    pub macro_steps: u64,
    /// Macro steps that are no part of the result: iterations before the last, trial steps, rejected steps. Zero in a non-iterative run.
    pub repeated_macro_steps: u64,
    /// Exchanges between the sides.
    pub exchanges: u64,
    /// Micro steps of a late interface model that bring it to the present.
    pub catch_up_steps: u64,
}

/// Work of the loop, of both sides and of the scheme; what was done on copies and thrown away included.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// The loop.
    pub cosim: CosimCounters,
    /// The sides.
    pub sides: PerSide<SubsystemCounters>,
    /// Complementarity solves inside the scheme.
    pub scheme: SolverCounters,
}

impl Work {
    /// Adds other work.
    pub fn add(&mut self, other: &Work) {
        self.cosim.macro_steps += other.cosim.macro_steps;
        self.cosim.repeated_macro_steps += other.cosim.repeated_macro_steps;
        self.cosim.exchanges += other.cosim.exchanges;
        self.cosim.catch_up_steps += other.cosim.catch_up_steps;
        self.sides.mechanics.add(&other.sides.mechanics);
        self.sides.actuator.add(&other.sides.actuator);
        self.scheme.add(&other.scheme);
    }

    /// Returns the work done since `earlier`, the work of these copies then.
    pub fn since(&self, earlier: &Work) -> Work {
        Work {
            cosim: CosimCounters {
                macro_steps: self.cosim.macro_steps - earlier.cosim.macro_steps,
                repeated_macro_steps: self.cosim.repeated_macro_steps - earlier.cosim.repeated_macro_steps,
                exchanges: self.cosim.exchanges - earlier.cosim.exchanges,
                catch_up_steps: self.cosim.catch_up_steps - earlier.cosim.catch_up_steps,
            },
            sides: self.sides.zip(earlier.sides).map(|(now, earlier)| now.since(&earlier)),
            scheme: self.scheme.since(&earlier.scheme),
        }
    }

    /// Counts this work as that of macro steps which led nowhere.
    pub fn discarded(mut self) -> Work {
        self.cosim.repeated_macro_steps += self.cosim.macro_steps;
        self.cosim.macro_steps = 0;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Work whose counts all differ.
    fn counted(mut last: u64) -> Work {
        let mut count = || {
            last += 7;
            last
        };
        let cosim = CosimCounters {
            macro_steps: count(),
            repeated_macro_steps: count(),
            exchanges: count(),
            catch_up_steps: count(),
        };
        let mut solver = || SolverCounters {
            solves: count(),
            pivots: count(),
            factorisations: count(),
            fallbacks: count(),
            parametric: count(),
            failures: count(),
            worst_residual: 0.0,
        };
        let mut side = |micro_steps: u64| SubsystemCounters {
            micro_steps,
            eliminations: micro_steps + 1,
            splits: micro_steps + 2,
            split_fallbacks: micro_steps + 3,
            solver: solver(),
        };
        let sides = PerSide { mechanics: side(1000), actuator: side(2000) };
        Work { cosim, sides, scheme: solver() }
    }

    #[test]
    fn what_is_done_since_a_moment_is_what_was_added_to_the_work_before_it() {
        let (before, more) = (counted(0), counted(3));
        let mut all = before;
        all.add(&more);
        assert_eq!(all.since(&before), more);
        assert_eq!(all.since(&more), before);
    }
}

//! By what a scheme is run: the loop itself, or one of the ceilings.

use super::copied_pair::CopiedPair;
use super::iteration::Iteration;
use crate::cosim::{
    CommunicationPoint, CoupledPair, Log, MacroInterval, MechanicsSteps, Report, Setup, Timer, View, cover, macro_steps,
};
use crate::error::Failure;

/// By what a scheme is run. All but the loop itself know the future or own both sides, and are not real-time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum IterativeDriver {
    /// The loop: each macro step once, from what is known at its start.
    #[default]
    NonIterative,
    /// Each macro step again and again until what was guessed comes back.
    Iterated(Iteration),
    /// Both sides together at the micro step, with no macro step between them.
    Monolithic,
}

impl IterativeDriver {
    /// Returns the steps that the sides take: together the mechanics takes every micro step.
    pub(crate) fn setup(self, setup: &Setup) -> Setup {
        let mut setup = setup.clone();
        if let IterativeDriver::Monolithic = self {
            setup.mechanics_steps = MechanicsSteps::AsActuator;
        }
        setup
    }

    /// Runs a pair beside the explicit loop ([`cosimulate`](crate::cosim::cosimulate)).
    ///
    /// Iterated steps go on with copies and leave the subsystems given where they were: what is to be known of them
    /// then is what `observe` sees and what the report holds.
    pub(crate) fn run(
        self,
        mut given: CoupledPair<'_>,
        timer: Option<Timer>,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) -> Report {
        if self == IterativeDriver::Monolithic {
            return cover(|pair, interval| pair.advance_together(interval), given, timer, observe);
        }
        let mut log = Log::new(timer, given.setup);
        let mut pair = match CopiedPair::of(&given) {
            Ok(pair) => pair,
            Err(failure) => {
                let work = given.work();
                return log.report(&mut given, work, Err(failure));
            }
        };
        let advance = |pair: &mut CopiedPair<'_>, interval| self.cover(pair, interval);
        let ended = macro_steps(&mut pair, |pair| View::Pair(pair.lend()), advance, &mut log, observe);
        let work = pair.work();
        log.report(&mut pair.lend(), work, ended)
    }

    /// Lets both sides cover a macro step after its exchange.
    fn cover(self, pair: &mut CopiedPair<'_>, interval: MacroInterval) -> Result<(), Failure> {
        match self {
            IterativeDriver::NonIterative => pair.lend().advance(interval),
            IterativeDriver::Iterated(iteration) => {
                pair.iterate(iteration, interval)?;
                pair.state.counters.macro_steps += 1;
                Ok(())
            }
            IterativeDriver::Monolithic => pair.lend().advance_together(interval),
        }
    }
}

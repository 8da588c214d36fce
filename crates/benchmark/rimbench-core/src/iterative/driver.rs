//! By what a scheme is run: the loop itself, or one of the ceilings.

use super::copied_pair::CopiedPair;
use super::iteration::Iteration;
use crate::cosim::{
    CommunicationPoint, CoupledPair, Log, MacroInterval, MechanicsSteps, Report, Setup, Timer, View, cover, macro_steps,
};

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
    /// The loop, with an exchange at every own step of the mechanics, of which there are so many in a macro step; seen
    /// at the communication points of whole macro steps.
    AtOwnSteps(MechanicsSteps),
}

impl IterativeDriver {
    /// Returns the steps that the sides take: together the mechanics takes every micro step.
    pub(crate) fn setup(self, setup: &Setup) -> Setup {
        let mut setup = setup.clone();
        if let IterativeDriver::Monolithic = self {
            setup.mechanics_steps = MechanicsSteps::AsActuator;
        }
        if let IterativeDriver::AtOwnSteps(_) = self {
            setup.mechanics_steps = MechanicsSteps::ONE;
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
        let iteration = match self {
            IterativeDriver::Iterated(iteration) => iteration,
            IterativeDriver::NonIterative => {
                let advance = |pair: &mut CoupledPair<'_>, interval| pair.advance(interval);
                return cover(MacroInterval::whole, advance, given, timer, observe);
            }
            IterativeDriver::Monolithic => {
                let advance = |pair: &mut CoupledPair<'_>, interval| pair.advance_together(interval);
                return cover(MacroInterval::whole, advance, given, timer, observe);
            }
            IterativeDriver::AtOwnSteps(steps) => {
                let micro_step = given.setup.micro_step;
                let count = |interval: MacroInterval| steps.within(interval.step.length, micro_step);
                let advance = |pair: &mut CoupledPair<'_>, interval: MacroInterval| {
                    let count = count(interval);
                    (0..count).try_for_each(|index| {
                        let part = interval.part(index, count);
                        if index > 0 {
                            pair.exchange(part.step)?;
                        }
                        pair.advance(part)
                    })
                };
                return cover(|interval| interval.part(0, count(interval)).step, advance, given, timer, observe);
            }
        };
        let mut log = Log::new(timer, given.setup);
        let mut pair = match CopiedPair::of(&given) {
            Ok(pair) => pair,
            Err(failure) => {
                let work = given.work();
                return log.report(&mut given, work, Err(failure));
            }
        };
        let advance = |pair: &mut CopiedPair<'_>, interval| {
            pair.iterate(iteration, interval)?;
            pair.state.counters.macro_steps += 1;
            Ok(())
        };
        let steps = (MacroInterval::whole, advance);
        let ended = macro_steps(&mut pair, |pair| View::Pair(pair.lend()), steps, &mut log, observe);
        let work = pair.work();
        log.report(&mut pair.lend(), work, ended)
    }
}

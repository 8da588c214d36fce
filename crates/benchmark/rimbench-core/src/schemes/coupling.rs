//! A scheme that has been built for two subsystems, ready to run.

use crate::cosim::{
    CommunicationPoint, CoupledPair, CouplingScheme, ExchangeData, PairState, Report, RunControl, Setup, Sides,
    cosimulate,
};
use crate::iterative::IterativeDriver;

/// A scheme with room for what its subsystems exchange, and by what it is run.
pub struct Coupling {
    /// The scheme.
    pub scheme: Box<dyn CouplingScheme>,
    /// Room for data exchanged in addition to outputs.
    pub exchange: ExchangeData,
    /// By what it is run.
    pub driver: IterativeDriver,
}

impl Coupling {
    /// Runs the two subsystems that the scheme was built for: by the loop ([`cosimulate`]), or beside it, as an
    /// [`IterativeDriver`] has it.
    pub fn run(
        mut self,
        setup: &Setup,
        mut sides: Sides<'_>,
        control: RunControl<'_>,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) -> Report {
        if self.driver == IterativeDriver::NonIterative {
            return cosimulate(setup, sides, &mut *self.scheme, self.exchange, control, observe);
        }
        let setup = &self.driver.setup(setup);
        let state = &mut PairState::new(setup, sides.lend(), self.exchange);
        let pair = CoupledPair { setup, sides: sides.lend(), scheme: &mut *self.scheme, state, stop: control.stop };
        self.driver.run(pair, control.timer, observe)
    }
}

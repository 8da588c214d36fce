//! A scheme that has been built for two subsystems, ready to run.

use crate::ceilings::{Driver, StepDoubling};
use crate::cosim::{Attachments, CommunicationPoint, CouplingScheme, Report, Setup, Sides, Supervision, cosimulate};

/// A scheme with room for what its subsystems exchange, and by what it is run.
pub struct Coupling {
    /// The scheme.
    pub scheme: Box<dyn CouplingScheme>,
    /// Room for what is exchanged besides outputs.
    pub attachments: Attachments,
    /// By what it is run.
    pub driver: Driver,
}

impl Coupling {
    /// Runs the two subsystems that the scheme was built for: by the loop ([`cosimulate`]), or on copies beside it ([`Driver::run`]).
    pub fn run(
        mut self,
        setup: &Setup,
        doubling: Option<StepDoubling>,
        sides: Sides<'_>,
        supervision: Supervision<'_>,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) -> Report {
        if self.driver == Driver::Explicit && doubling.is_none() {
            return cosimulate(setup, sides, &mut *self.scheme, self.attachments, supervision, observe);
        }
        self.driver.run(doubling, setup, sides, &mut *self.scheme, self.attachments, supervision, observe)
    }
}

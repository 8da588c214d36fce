//! Co-simulation of two subsystems: what they are, how they exchange, and the one macro loop. Non-iterative: nothing
//! here takes a step back. What does, stands beside it, in [`iterative`](crate::iterative).
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | `H` | s | macro step, the distance of communication points |
//! | `φ` | – | communication phase: the first macro step is `φH` |
//! | `t_k` | s | communication point k |
//! | `δ` | s | micro step of a subsystem inside a macro step |
//! | `u`, `y` | – | inputs and outputs (the coupling variables) |
//!
//! The three axes of the literature are three places here: the *decomposition* is a [`Subsystem`] pair with its
//! [`Ports`], the *sequence* is [`Sequence`] inside [`cosimulate`], and the *approximation* of the coupling variables
//! between communication points is a [`CouplingScheme`]. [`ForceReturn`] says what the mechanics receives from an
//! actuator that went first.

mod communication_grid;
mod communication_point;
mod contact_mechanics;
mod coupled_pair;
mod coupling_scheme;
mod delivery;
mod energy_account;
mod exchange_data;
mod force_return;
mod input_polynomials;
mod integrators;
mod interface_work;
mod late_samples;
mod latencies;
mod lent_actuator;
mod macro_loop;
mod mass_learner;
mod mechanics_steps;
mod micro_log;
mod model_audit;
mod model_defect;
mod outcome;
mod output_history;
mod output_rates;
mod pair_state;
mod ports;
mod report;
mod run_control;
mod sent_model;
mod setup;
mod side;
mod step_rule;
mod step_size_control;
mod subsystem;
mod trajectory;
mod transmission_lines;
mod trial_steps;
mod trials;
mod work;
mod work_meter;

pub use communication_grid::{CommunicationGrid, MacroStep, MicroStep, division};
pub use communication_point::CommunicationPoint;
pub use contact_mechanics::{ContactMechanics, JointActuator, Sent};
pub use coupling_scheme::{CouplingScheme, Forecast, ModelEnd, Sample, SchemeReport};
pub use delivery::{Channel, Delivery, ForceBridge, LateRule, MOST_LATE};
pub use energy_account::{EnergyAccount, EnergyAudit};
pub use exchange_data::ExchangeData;
pub use force_return::{ForceReturn, Sequence};
pub use input_polynomials::{Cubic, InputPolynomials};
pub use integrators::{ActuatorIntegrator, MechanicsIntegrator, SecondOrder};
pub use interface_work::InterfaceWork;
pub use latencies::Latencies;
pub use macro_loop::cosimulate;
pub use macro_loop::{Every, Known, MicroSteps, Order, Partition, Share, Star, StarPlan, Tells, cannot_divide};
pub use mass_learner::MassLearning;
pub use mechanics_steps::MechanicsSteps;
pub use model_audit::{Creation, Jump, ModelEnergy};
pub use outcome::{Outcome, OutcomeClass, OutcomeKind};
pub use output_history::{ForceProfile, OutputHistory};
pub use output_rates::OutputRates;
pub use ports::{Port, Ports, Quantity, check_coupling};
pub use report::Report;
pub use run_control::{RunControl, StopFlag, Timer};
pub use setup::{Bounds, Exchange, Setup};
pub use side::{PerSide, Side};
pub use step_rule::{StepControl, StepRule};
pub use subsystem::{
    Capabilities, FIRST_ORDER_ONLY, NO_CONTACTS, Sides, Subsystem, SubsystemCounters, subsystem_methods,
};
pub use trajectory::Trajectory;
pub use transmission_lines::{LineForces, TransmissionLines};
pub use trials::{TrialReport, TrialSettings, Trials};
pub use work::{CosimCounters, Work};
pub use work_meter::{WorkMeter, counts_interface_work};

// For the ceilings, which share exchange and steps.
pub(crate) use coupled_pair::CoupledPair;
pub(crate) use exchange_data::{NO_INTERFACE_MODEL, NO_OIL_LINES, NO_OUTPUT_RATES};
pub(crate) use lent_actuator::LentActuator;
pub(crate) use macro_loop::Log;
pub(crate) use macro_loop::{View, cover, macro_steps};
pub(crate) use output_history::overlaps;
pub(crate) use pair_state::PairState;
pub(crate) use step_size_control::MacroInterval;

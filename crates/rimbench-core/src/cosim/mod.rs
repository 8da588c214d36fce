//! Co-simulation of two subsystems: what they are, how they exchange, and the one macro loop. Non-iterative, but for the
//! ceilings that real-time schemes are held against ([`Coupling`]) and for step doubling ([`StepControl`]): these take steps
//! on copies.
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

mod acceleration;
mod communication_grid;
mod coupled_pair;
mod coupling_scheme;
mod energy_account;
mod force_return;
mod held;
mod interface_work;
mod iteration;
mod latency;
mod macro_loop;
mod outcome;
mod output_rates;
mod pace;
mod report;
mod step_control;
mod step_doubling;
mod subsystem;
mod trajectory;
mod work;

pub use acceleration::Acceleration;
pub use communication_grid::{CommunicationGrid, MacroStep, division};
pub use coupling_scheme::{CouplingScheme, Diagnostics, MicroStep, Sample};
pub use energy_account::{EnergyAccount, EnergyAudit};
pub use force_return::{ForceReturn, Sequence};
pub use interface_work::{InterfaceWork, counts_interface_work};
pub use iteration::{Coupling, Iteration};
pub use latency::{Latency, Timing};
pub use macro_loop::{Bounds, CommunicationPoint, Setup, cosimulate};
pub use outcome::Outcome;
pub use output_rates::OutputRates;
pub use report::{CosimCounters, Report};
pub use step_control::{StepControl, StepRule};
pub use subsystem::{Port, Ports, Quantity, Side, Subsystem, SubsystemCounters, check_coupling};
pub use trajectory::Trajectory;
pub use work::Work;

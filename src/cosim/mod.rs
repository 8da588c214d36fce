//! Non-iterative co-simulation of two subsystems: what they are, how they exchange, and the one macro loop.
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
mod coupling_scheme;
mod energy_account;
mod force_return;
mod interface_work;
mod latency;
mod macro_loop;
mod outcome;
mod output_rates;
mod report;
mod subsystem;
mod trajectory;

pub use communication_grid::{CommunicationGrid, MacroStep, division};
pub use coupling_scheme::{CouplingScheme, Diagnostics, MicroStep, Sample};
pub use energy_account::{EnergyAccount, EnergyAudit};
pub use force_return::{ForceReturn, Sequence};
pub use interface_work::InterfaceWork;
pub use latency::{Latency, Timing};
pub use macro_loop::{Bounds, CommunicationPoint, Setup, cosimulate};
pub use outcome::Outcome;
pub use output_rates::OutputRates;
pub use report::{CosimCounters, Report};
pub use subsystem::{Port, Ports, Quantity, Side, Subsystem, SubsystemCounters, check_coupling};
pub use trajectory::Trajectory;

//! Programs in any language as coupling schemes and subsystems: a process, and lines of JSON over its standard input and output.
//!
//! ```text
//! scheme file ─► CommandLine ─► Conversation: one request, one reply ─► ProgramScheme
//! case file ───►     "                "                               ─► ProgramHost ─► ImportedSide
//! ```
//! What is said is in `docs/guide/protocol.md`; the types of it stand in `messages.rs`.

mod command_line;
#[cfg(unix)]
mod conversation;
#[cfg(not(unix))]
#[path = "no_conversation.rs"]
mod conversation;
mod copies;
mod exchange_times;
#[cfg(unix)]
mod living;
mod messages;
mod scheme;
mod subsystem;

pub(crate) use command_line::{CommandLine, answer_within};
#[cfg(not(unix))]
pub use conversation::end_programs;
pub use exchange_times::{ExchangeTimes, take_exchange_times};
#[cfg(unix)]
pub use living::end_programs;
pub(crate) use messages::Named;
pub use messages::{PROTOCOL, VERSION};
pub use scheme::read_scheme;
pub(crate) use subsystem::{ProgramSide, unit};

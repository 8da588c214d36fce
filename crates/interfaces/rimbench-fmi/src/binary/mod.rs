//! What is called in the library of an exported FMU.

mod functions;
mod history;
mod instance;

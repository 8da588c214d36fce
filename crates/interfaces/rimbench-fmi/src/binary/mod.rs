//! What is called in the library of an exported FMU.

mod functions;
mod functions_2;
mod history;
mod instance;

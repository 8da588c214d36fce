//! Machines of others: FMUs and sides in other programs, as the program takes and gives them.

#[allow(dead_code)]
#[path = "../program/exported_fmus.rs"]
mod exported_fmus;
#[allow(dead_code, unused_imports, unused_macros)]
#[path = "../program/program.rs"]
mod program;

mod attributes;
mod beginnings;
mod faulty_guest;
mod fixed_steps;
mod fmi;
mod guest_fmu;
mod outside;
mod python_schemes;
mod several_actuators;

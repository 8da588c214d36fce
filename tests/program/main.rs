//! The program and what it writes: command line, store, performance tracker, examples, documents.

#[path = "../support/mod.rs"]
mod support;

mod advice;
mod any_edit;
mod anywhere;
mod architecture;
mod command_line;
mod conveniences;
mod documents;
mod examples;
mod exported_fmus;
mod interruption;
mod judged;
mod open;
mod outputs;
mod paper;
mod parsers;
mod perf;
mod perf_command_line;
mod plans;
mod program;
mod ranking;
mod report;
mod reproduction;
mod screens;
mod slurm;
mod store;
mod store_survives;
mod strict;

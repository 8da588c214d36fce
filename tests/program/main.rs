//! The program and what it writes: command line, store, figures, performance tracker, examples.

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
mod figures;
mod fmi;
mod guest_fmu;
mod interruption;
mod judged;
mod names;
mod outputs;
mod outside;
mod paper;
mod parsers;
mod perf;
mod perf_command_line;
mod program;
mod prose;
mod ranking;
mod report;
mod reproduction;
mod screens;
mod slurm;
mod store_survives;
mod strict;
mod walks;

//! The program and what it writes: command line, store, figures, performance tracker, examples.

#[path = "../support/mod.rs"]
mod support;

mod advice;
mod any_edit;
mod anywhere;
mod architecture;
mod attributes;
mod command_line;
mod conveniences;
mod documents;
mod draws;
mod examples;
mod figures;
mod files;
mod fmi;
mod guest_fmu;
mod interruption;
mod judged;
mod kept;
mod outputs;
mod outside;
mod pages;
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
mod simulator;
mod slurm;
mod stability;
mod statistics;
mod store;
mod store_survives;
mod strict;

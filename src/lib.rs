//! rimbench
#![allow(missing_docs)]
pub mod cases;
pub mod complementarity;
pub mod cosim;
pub mod error;
pub mod harness;
pub mod interface_model;
pub mod mechanics;
pub mod metrics;
pub mod models;
pub mod numerics_version;
pub mod report;
pub mod schemes;

//! rimbench
#![allow(missing_docs)]
pub mod complementarity;
pub mod error;
pub mod report;

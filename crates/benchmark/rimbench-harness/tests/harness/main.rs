//! Plans, draws and limits of stability, without the program.

mod draws;
mod plans;
mod stability;

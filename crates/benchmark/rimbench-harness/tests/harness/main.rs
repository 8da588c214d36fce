//! Draws and limits of stability, without the program.

mod draws;
mod stability;

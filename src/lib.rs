//! Benchmark of non-iterative co-simulation of mechanical systems with contact.
//!
//! A *co-simulation* splits a system into subsystems, each with its own solver. They exchange coupling variables at
//! communication points `t_k`, a macro step `H` apart, and never go back. Between communication points each side must
//! guess what the other is doing; where contacts open and close meanwhile, the guess can be badly wrong. This library runs
//! any coupling scheme over any case through one macro loop, and measures stability, energy drift, accuracy and cost
//! against fine-step references.
//!
//! # Rooms
//! Each room uses only those below it.
//!
//! | room | what it holds |
//! |---|---|
//! | [`perf`] | a fixed suite of work, its history, and what counts as a regression |
//! | [`report`] | figures and the report, from result files; never simulates |
//! | [`harness`] | experiment file → plan → runs → result files |
//! | [`cases`], [`schemes`], [`metrics`] | what is simulated, how it is coupled, what is measured; explicit lists |
//! | [`models`] | physical models the cases are made from |
//! | [`mechanics`] | the non-smooth stepper and the monolithic reference |
//! | [`cosim`] | subsystems, coupling schemes, and the macro loop |
//! | [`interface_model`] | the reduced interface model (paper Eqs. 3 and 4) |
//! | [`complementarity`] | linear complementarity problems and their solvers |
//!
//! # Symbols
//! | symbol | unit | meaning |
//! |---|---|---|
//! | `H`, `φ`, `δ`, `h` | s, –, s, s | macro step, communication phase, micro step, step of the mechanics |
//! | `u`, `y` | | inputs and outputs of a subsystem, the coupling variables |
//! | `q`, `v` | m, m/s (rad, rad/s) | positions and velocities of a mechanical system |
//! | `λ_i`, `w_i`, `s` | N, m/s, m | interface force, velocity, coordinate |
//! | `g`, `w_u`, `P_u` | m, m/s, N·s | gaps, contact velocities, contact impulses |
//! | `M`, `A_x`, `H_xy` | kg, –, 1/kg | mass matrix, Jacobians, the interface model; see [`interface_model`] |
//!
//! Raoofian, Kövecses, Teichmann, "Non-smooth Reduced Interface Models for Co-simulation of Mechanical Systems", is "the
//! paper" throughout; what is marked *ours* is this project's own choice.

pub mod atomic_file;
pub mod cases;
pub mod complementarity;
pub mod corpus;
pub mod cosim;
pub mod error;
pub mod harness;
pub mod interface_model;
pub mod mechanics;
pub mod metrics;
pub mod models;
pub mod numerics_version;
pub mod perf;
pub mod report;
pub mod results_table;
pub mod schemes;

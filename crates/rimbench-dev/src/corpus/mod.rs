//! Contact problems of actual runs, kept in the order in which they were solved.
//!
//! Published suites of complementarity problems rest on a handful of problem classes; what a solver meets inside a
//! simulation is different: most problems resemble the one before, contacts are redundant as a rule, and a few problems
//! are at the moment where a contact opens or closes. [`harvest`] runs cases that have contacts and keeps stretches of what
//! their solvers were given, [`Corpus`] is those stretches and the file they are kept in, [`replay`] gives them to a
//! solver, warm and cold, and [`draw_profile`] compares solvers over all of them. Problems of hundreds of contacts are too large for the file:
//! [`LargeCorpus`] makes them anew, and [`replay_large`] gives them to solvers as far as these get in a limited time.
//!
//! ```text
//! cases × variations × schemes × H ── harvest ──► Corpus ⇄ file ── replay ──► pivots, residuals, times ──► profile
//! ```

mod contact_problem;
mod format;
mod friction_method;
mod harvest;
mod large;
mod plot;
mod recorder;
mod replay;
mod selection;
mod tape;

pub use contact_problem::{ContactProblem, Corpus, FrictionalCorpus, FrictionalProblem, Problem, Stretch};
pub use friction_method::{FrictionMethod, Uniqueness};
pub use harvest::{FRICTION_VARIATIONS, Harvest, VARIATIONS, Variation, harvest, harvest_with_friction};
pub use large::{Contestant, LARGE_SYSTEMS, LargeCorpus, LargeReplay, LargeSystem, replay_large};
pub use plot::draw_profile;
pub use replay::{Replay, Solve, Start, replay, replay_with_friction};

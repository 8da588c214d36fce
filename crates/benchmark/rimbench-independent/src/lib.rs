//! The wedge box by other routes, for tests and benches of rimbench. This crate depends on none of the others, so what
//! agrees with it agrees with something independent.

pub mod event_driven_wedge_box;
pub mod plain_wedge_box;

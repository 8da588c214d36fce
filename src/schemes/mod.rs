//! The coupling schemes, one file each, listed in [`SCHEMES`].
//!
//! To add one: write a file with a type that implements [`CouplingScheme`](crate::cosim::CouplingScheme) and an
//! `ENTRY`, and add the entry to the list. Every test, sweep and figure then finds it by name.

mod active_contacts;
mod contact_choice;
mod contact_selection;
mod entry;
mod extrapolation;
mod first_order_hold;
mod implicit;
mod interface_jacobian;
mod iterated_aitken;
mod iterated_quasi_newton;
mod monolithic;
mod need;
mod packed_model;
mod reduced_interface;
mod rim_fixed_mass;
mod rim_nonsmooth;
mod rim_nonsmooth_gap;
mod rim_smooth;
mod rim_smooth_active;
mod second_order_hold;
mod zero_order_hold;

pub use contact_choice::ContactChoice;
pub use entry::{Family, ModelMotion, SchemeEntry, SchemeOptions, scheme_by_name};
pub use need::Need;

/// Every coupling scheme.
pub const SCHEMES: &[SchemeEntry] = &[
    zero_order_hold::ENTRY,
    first_order_hold::ENTRY,
    second_order_hold::ENTRY,
    interface_jacobian::ENTRY,
    rim_fixed_mass::ENTRY,
    rim_smooth::ENTRY,
    rim_smooth_active::ENTRY,
    rim_nonsmooth::ENTRY,
    rim_nonsmooth_gap::ENTRY,
    iterated_aitken::ENTRY,
    iterated_quasi_newton::ENTRY,
    monolithic::ENTRY,
];

//! The coupling schemes, one file each, listed in [`SCHEMES`].
//!
//! To add one: write a file with a type that implements [`CouplingScheme`](crate::cosim::CouplingScheme) and an
//! `ENTRY`, and add the entry to the list. Every test, sweep and figure then finds it by name.

mod active_contacts;
mod c1_extrapolated_interpolation;
mod contact_choice;
mod contact_selection;
mod energy_leak_damper;
mod entry;
mod extrapolation;
mod first_order_hold;
mod implicit;
mod interface_jacobian;
mod iterated_aitken;
mod iterated_quasi_newton;
mod monolithic;
mod moving_model;
mod need;
mod nepce;
mod packed_model;
mod predicted_acceleration;
mod reduced_interface;
mod registry;
mod rim_fixed_mass;
mod rim_nonsmooth;
mod rim_nonsmooth_gap;
mod rim_smooth;
mod rim_smooth_active;
mod second_order_hold;
mod transmission_line;
mod zero_order_hold;

pub use contact_choice::ContactChoice;
pub use entry::{Family, Gain, ModelMotion, SchemeEntry, SchemeOptions};
pub use need::Need;
pub use registry::{all_schemes, register, scheme_by_name};

/// Every built-in coupling scheme.
pub const SCHEMES: &[SchemeEntry] = &[
    zero_order_hold::ENTRY,
    first_order_hold::ENTRY,
    second_order_hold::ENTRY,
    c1_extrapolated_interpolation::ENTRY,
    c1_extrapolated_interpolation::QUADRATIC,
    predicted_acceleration::ENTRY,
    nepce::ENTRY,
    nepce::FEEDTHROUGH,
    energy_leak_damper::ENTRY,
    transmission_line::ENTRY,
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

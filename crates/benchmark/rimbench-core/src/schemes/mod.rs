//! The coupling schemes, one file each, listed in [`standard_schemes`].
//!
//! To add one: write a file with a type that implements [`CouplingScheme`](crate::cosim::CouplingScheme) and a function
//! `entry` that says all that others need to know of it, and add that function to the list. Every test, sweep and
//! figure then finds it by name.

mod active_contacts;
mod c1_extrapolated_interpolation;
mod construction;
mod contact_detection;
mod coulomb_contacts;
mod coupling;
mod energy_leak_damper;
mod entry;
mod exponential_step;
mod extrapolation;
mod first_order_hold;
mod hydraulic_line;
mod implicit_feedthrough;
mod information;
mod input_polynomial;
mod interface_acceleration;
mod interface_exponential;
mod interface_jacobian;
mod interface_mass;
mod iterated_aitken;
mod model_contacts;
mod model_corrected_outputs;
mod model_options;
mod monolithic;
mod moving_model;
mod nepce;
mod output_integral;
mod outside;
mod recorded_modes;
mod reduced_interface;
mod requirement;
mod rim_answers;
mod rim_fixed_mass;
mod rim_nonsmooth;
mod rim_nonsmooth_gap;
mod rim_smooth;
mod rim_smooth_active;
mod second_order_hold;
mod slip_rows;
mod taylor_force;
mod transmission_line;
mod true_acceleration;
mod zero_order_hold;

pub use construction::{Construction, ModelConstruction};
pub use contact_detection::{ContactDetection, DetectionRule};
pub use coupling::Coupling;
pub use entry::{BuildScheme, Family, Gain, SchemeEntry};
pub use information::InformationClass;
pub use input_polynomial::InputPolynomial;
pub use model_options::{ContactsAct, FrictionRows, ModelMotion, ModelOptions};
pub use outside::{AnswerForm, Asked, Outside, OutsideScheme};
pub use requirement::Requirement;

/// Describes every built-in coupling scheme.
pub fn standard_schemes() -> Vec<SchemeEntry> {
    vec![
        zero_order_hold::entry(),
        first_order_hold::entry(),
        second_order_hold::entry(),
        c1_extrapolated_interpolation::entry(),
        true_acceleration::entry(),
        nepce::entry(),
        nepce::first_order(),
        energy_leak_damper::entry(),
        transmission_line::entry(),
        hydraulic_line::entry(),
        interface_jacobian::entry(),
        interface_exponential::entry(),
        model_corrected_outputs::entry(),
        interface_mass::entry(),
        rim_fixed_mass::entry(),
        rim_smooth::entry(),
        rim_smooth_active::entry(),
        rim_nonsmooth::entry(),
        rim_nonsmooth_gap::entry(),
        rim_nonsmooth_gap::split_entry(),
        rim_answers::entry(),
        iterated_aitken::entry(),
        monolithic::entry(),
    ]
}

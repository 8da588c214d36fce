//! Everything that is computed: solvers, models, schemes and whole runs against theory, published data and each other.

#[path = "../support/mod.rs"]
mod support;

#[path = "../support/plain_wedge_box.rs"]
mod plain_wedge_box;

mod acceleration_jumps;
mod adversaries;
mod ceilings;
mod complementarity;
mod cones;
mod conservation;
mod contact_compliance;
mod contact_detection;
mod contact_known_answers;
mod contact_machines;
mod contacts_in_space;
mod coupling;
mod elimination;
mod energy_audit;
mod energy_of_contacts;
mod energy_of_models;
mod force_profiles;
mod friction;
mod friction_cases;
mod friction_mechanics;
mod friction_mechanisms;
mod friction_of_others;
mod golden;
mod hydraulic_line;
mod impact;
mod large_cases;
mod late_samples;
mod linear_algebra;
mod lists;
mod many_actuators;
mod many_contacts;
mod metrics;
mod model_steps;
mod nothing_to_speak_of;
mod options;
mod options_in_vain;
mod oscillator_theory;
mod output_rates;
mod outside;
mod parametric_step;
mod plain_implementation;
mod polynomial_inputs;
mod predicted_growth;
mod published_crane;
mod published_data;
mod random_bodies;
mod reference;
mod refusals;
mod requests;
mod restitution;
mod rows;
mod scheme_identities;
mod schemes;
mod schemes_by_hand;
mod second_order;
mod space;
mod step_control;
mod stiff_forces;
mod wedge_box;

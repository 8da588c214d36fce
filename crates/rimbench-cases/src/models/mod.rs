//! Physical models: what the cases are assembled from. A model knows its equations, not the coupling.

mod actuator_group;
mod bare_coupling;
mod crane;
mod crane_in_heap;
mod crane_with_rope;
mod discs;
mod fluid;
mod held_oscillator;
mod hydraulic_cylinder;
mod hydraulic_energy;
mod hydropneumatic_strut;
mod ledge;
mod line_masses;
mod nearby;
#[cfg(test)]
mod output_rates;
mod pressure_coupling;
mod published_driver;
pub(crate) mod rotation;
mod spatial_body;
mod spring_actuator;
mod two_masses;
mod washboard;
mod wedge_box;

pub use actuator_group::{ActuatorGroup, ActuatorNames};
pub use bare_coupling::{CouplingForce, FreeMasses};
pub use crane::{Crane, CraneGeometry};
pub use crane_in_heap::{CraneInHeap, HeapGeometry};
pub use crane_with_rope::CraneWithRope;
pub use discs::{ContactList, Discs, DiscsGeometry};
pub use fluid::Oil;
pub use held_oscillator::{HeldOscillator, OscillatorIntegrator};
pub use hydraulic_cylinder::{Cylinder, HydraulicCylinder, Spool};
pub use hydropneumatic_strut::{HydropneumaticStrut, Strut};
pub use ledge::{Ledge, SurfaceContact};
pub use line_masses::{LineContact, LineDescription, LineMass, LineMasses, LineSpring};
pub use pressure_coupling::{PressureDrivenMechanics, PressureOutput};
pub use published_driver::{OwnPosition, PublishedClock, StaleFeedthrough};
pub use spatial_body::{Foot, LedgeBall, Pin, SpatialBody, SpatialBodyGeometry};
pub(crate) use spring_actuator::force_ports;
pub use spring_actuator::{Carriage, SpringActuator};
pub use two_masses::{CouplingElement, MassRole, MassSide};
pub use washboard::Washboard;
pub(crate) use wedge_box::level_angle;
pub use wedge_box::{LedgeDisc, WedgeBox, WedgeBoxGeometry};

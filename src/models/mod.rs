//! Physical models: what the cases are assembled from. A model knows its equations, not the coupling.

mod actuator_pair;
mod bare_coupling;
mod crane;
mod crane_with_rope;
mod discs;
mod fluid;
mod gripper;
mod half_car;
mod held_oscillator;
mod hydraulic_cylinder;
mod hydraulic_energy;
mod hydropneumatic_strut;
mod ledge;
mod pressure_coupling;
mod published_clock;
mod two_masses;
mod wedge_box;

pub use actuator_pair::{ActuatorNames, ActuatorPair};
pub use bare_coupling::{CouplingForce, FreeMasses};
pub use crane::{Crane, CraneGeometry};
pub use crane_with_rope::CraneWithRope;
pub use discs::{Discs, DiscsGeometry};
pub use fluid::Fluid;
pub use gripper::{Gripper, GripperGeometry};
pub use half_car::{HalfCar, HalfCarGeometry};
pub use held_oscillator::{HeldOscillator, OscillatorIntegrator};
pub use hydraulic_cylinder::{CylinderParameters, HydraulicCylinder, Spool};
pub use hydropneumatic_strut::{HydropneumaticStrut, StrutParameters};
pub use ledge::{Ledge, SurfaceContact};
pub use pressure_coupling::{PressureDrivenMechanics, PressureOutput};
pub use published_clock::PublishedClock;
pub use two_masses::{CouplingElement, MassRole, MassSide, WalledMass};
pub use wedge_box::{WedgeBox, WedgeBoxGeometry};

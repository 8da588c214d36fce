//! Physical models: what the cases are assembled from. A model knows its equations, not the coupling.

mod bare_coupling;
mod crane;
mod fluid;
mod held_oscillator;
mod hydraulic_cylinder;
mod hydraulic_energy;
mod ledge;
mod line_masses;
mod modal_beam;
mod pressure_coupling;
mod published_clock;
mod spring_actuator;
mod supported_box;
mod two_masses;
mod washboard;
mod wedge_box;

pub use bare_coupling::{CouplingForce, FreeMasses};
pub use crane::{Crane, CraneGeometry};
pub use fluid::Fluid;
pub use held_oscillator::{HeldOscillator, OscillatorIntegrator};
pub use hydraulic_cylinder::{CylinderParameters, HydraulicCylinder, Spool};
pub use ledge::{Ledge, SurfaceContact};
pub use line_masses::{LineContact, LineDescription, LineMass, LineMasses, LineSpring};
pub use modal_beam::{BeamGeometry, BeamStop, BeamSupport, MOST_MODES, ModalBeam};
pub use pressure_coupling::{PressureDrivenMechanics, PressureOutput};
pub use published_clock::PublishedClock;
pub use spring_actuator::{BaseMotion, SpringActuator, SpringActuatorParameters};
pub use supported_box::{LedgeDisc, SupportedBox, SupportedBoxGeometry};
pub use two_masses::{CouplingElement, MassRole, MassSide, WalledMass};
pub use washboard::Washboard;
pub use wedge_box::{WedgeBox, WedgeBoxGeometry};

//! Physical models: what the cases are assembled from. A model knows its equations, not the coupling.

mod fluid;
mod hydraulic_cylinder;
mod hydraulic_energy;
mod ledge;
mod wedge_box;

pub use fluid::Fluid;
pub use hydraulic_cylinder::{CylinderParameters, HydraulicCylinder, Spool};
pub use ledge::{Ledge, SurfaceContact};
pub use wedge_box::{WedgeBox, WedgeBoxGeometry};

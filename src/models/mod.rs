//! Physical models: what the cases are assembled from. A model knows its equations, not the coupling.

mod hydraulic_cylinder;
mod ledge;
mod wedge_box;

pub use hydraulic_cylinder::{CylinderParameters, Fluid, HydraulicCylinder, Spool};
pub use ledge::{Ledge, SurfaceContact};
pub use wedge_box::{WedgeBox, WedgeBoxGeometry};

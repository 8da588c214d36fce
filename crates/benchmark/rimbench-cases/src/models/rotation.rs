//! Rotations in the plane, with the same bits on every machine.

use nalgebra::{Matrix2, Rotation2};

/// Makes the rotation by `angle` (rad, counter-clockwise). `Rotation2::new` takes sine and cosine from the system's C
/// library, whose last bits depend on its version; these come from `libm`.
#[inline]
pub(crate) fn rotation(angle: f64) -> Rotation2<f64> {
    let (sin, cos) = libm::sincos(angle);
    Rotation2::from_matrix_unchecked(Matrix2::new(cos, -sin, sin, cos))
}

//! A ledge that ends in a ramp: the ground under a disc, with a corner treated as a vertex.

use nalgebra::Vector2;

/// Ledge of height `h` up to a corner, then a ramp falling with `slope` (fall over run).
///
/// ```text
///      flat          corner (x_c, h)
///   ─────────────────●
///                      ╲  slope
///                        ╲___________ floor y = 0 (the ramp's line goes on below it)
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ledge {
    corner: Vector2<f64>,
    /// Unit vector down the ramp.
    down: Vector2<f64>,
    /// Unit normal of the ramp.
    ramp_normal: Vector2<f64>,
}

/// Contact of a disc with a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceContact {
    /// Distance of the disc's rim from the surface, m; negative means penetration.
    pub gap: f64,
    /// Unit normal, from the surface to the disc's centre.
    pub normal: Vector2<f64>,
    /// Curvature of the path of the centre at constant gap, 1/m: zero on a plane, `1/d` at distance `d` of a vertex.
    pub curvature: f64,
}

impl Ledge {
    /// Builds the ledge with its corner at `(corner_x, height)`.
    pub fn new(corner_x: f64, height: f64, slope: f64) -> Self {
        let down = Vector2::new(1.0, -slope).normalize();
        Ledge { corner: Vector2::new(corner_x, height), down, ramp_normal: Vector2::new(-down.y, down.x) }
    }

    /// Returns its corner, m.
    pub fn corner(&self) -> [f64; 2] {
        self.corner.into()
    }

    /// Returns the contact of a disc of radius `radius` around `centre`.
    ///
    /// ```text
    /// centre behind the corner:           plane of the ledge, normal (0, 1)
    /// centre beyond the ramp's normal:    plane of the ramp
    /// between:                            the vertex; normal (c − corner)/d turns with the disc
    /// ```
    pub fn contact(&self, centre: Vector2<f64>, radius: f64) -> SurfaceContact {
        let from_corner = centre - self.corner;
        if from_corner.x <= 0.0 {
            SurfaceContact { gap: from_corner.y - radius, normal: Vector2::new(0.0, 1.0), curvature: 0.0 }
        } else if from_corner.dot(&self.down) >= 0.0 {
            let distance = from_corner.dot(&self.ramp_normal);
            SurfaceContact { gap: distance - radius, normal: self.ramp_normal, curvature: 0.0 }
        } else {
            let distance = from_corner.norm();
            SurfaceContact { gap: distance - radius, normal: from_corner / distance, curvature: 1.0 / distance }
        }
    }

    /// Returns distance (m) and rate (m/s) of a disc's centre beyond the borders of the corner: ledge to vertex, vertex
    /// to ramp.
    pub fn borders(&self, centre: Vector2<f64>, velocity: Vector2<f64>) -> [[f64; 2]; 2] {
        let from_corner = centre - self.corner;
        [[from_corner.x, velocity.x], [from_corner.dot(&self.down), velocity.dot(&self.down)]]
    }
}

//! Mechanics of the woodpecker toy: a bird on a spring, held by a sleeve that jams on a pole.

use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{MassMatrix, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelSize};
use rimbench_core::name::{Name, names};

/// Masses, geometry and start of a [`Woodpecker`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WoodpeckerGeometry {
    /// m_M of the sleeve and m_S of the bird, kg.
    pub masses: [f64; 2],
    /// J_M and J_S about their centres of mass, kg·m².
    pub inertias: [f64; 2],
    /// r_O, m.
    pub pole_radius: f64,
    /// Inner radius r_M of the sleeve, m.
    pub sleeve_radius: f64,
    /// Half its height, h_M, m.
    pub sleeve_half_height: f64,
    /// l_M from the middle of the sleeve to the spring, m.
    pub spring_distance: f64,
    /// l_G from there to the bird's centre of mass, m.
    pub bird_distance: f64,
    /// h_S of the beak above the bird's centre of mass, m.
    pub beak_height: f64,
    /// l_S of the beak before the bird's centre of mass, m.
    pub beak_length: f64,
    /// Lever r that the spring's length is measured on, m.
    pub lever: f64,
    /// Angle of the bird at the start, rad; the sleeve touches the pole with its lower edge.
    pub bird_angle: f64,
    /// Velocities at the start: of the sleeve, m/s, and of the bird's angle, rad/s.
    pub velocities: [f64; 2],
    /// m/s².
    pub gravity: f64,
}

/// The toy for small angles. Coordinates: height y of the sleeve, angles φ_M of the sleeve and φ_S of the bird.
///
/// ```text
///     ⎡ m_M + m_S   m_S l_M            m_S l_G         ⎤        ⎡ −(m_M + m_S) g ⎤
/// M = ⎢ m_S l_M     J_M + m_S l_M²     m_S l_M l_G     ⎥    f = ⎢ −m_S l_M g     ⎥     s = r (φ_S − φ_M)
///     ⎣ m_S l_G     m_S l_M l_G        J_S + m_S l_G²  ⎦        ⎣ −m_S l_G g     ⎦
///
/// beak          g = l_M + l_G − l_S − r_O − h_S φ_S      t = [1, l_M, l_G − l_S]
/// lower edge    g = r_M − r_O + h_M φ_M                  t = [1, r_M, 0]
/// upper edge    g = r_M − r_O − h_M φ_M                  t = [1, r_M, 0]
/// ```
/// All matrices are constant. The lower and the upper edge cannot touch at once.
/// # Source
/// Equations: Glocker, *Dynamik von Starrkörpersystemen mit Reibung und Stößen* (1995); Leine, Glocker, van Campen, *Nonlinear dynamics of the
/// woodpecker toy* (2001). There the spring is part of the mechanics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Woodpecker {
    geometry: WoodpeckerGeometry,
}

impl Woodpecker {
    /// Places the toy with the sleeve's lower edge on the pole.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if the sleeve does not fit over the pole, or the beak would start inside it.
    pub fn new(geometry: WoodpeckerGeometry) -> Result<Self> {
        let (toy, g) = (Woodpecker { geometry }, &geometry);
        if g.sleeve_radius <= g.pole_radius {
            return Err(Error::Incompatible(format!(
                "impossible geometry: a sleeve of inner radius {} m does not go over a pole of {} m",
                g.sleeve_radius, g.pole_radius
            )));
        }
        let gap = toy.beak_distance() - g.beak_height * g.bird_angle;
        if gap < 0.0 {
            return Err(Error::Incompatible(format!(
                "impossible geometry: with an angle of {} rad the beak would start {gap:.6} m from the pole, inside it",
                g.bird_angle
            )));
        }
        Ok(toy)
    }

    /// Distance of the beak from the pole where the bird is level, m.
    fn beak_distance(&self) -> f64 {
        let g = &self.geometry;
        g.spring_distance + g.bird_distance - g.beak_length - g.pole_radius
    }
}

const VELOCITIES: usize = 3;

impl MechanicalModel for Woodpecker {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: VELOCITIES, bilateral: 0, unilateral: 3, interface: 1 }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let g = &self.geometry;
        let edge = -(g.sleeve_radius - g.pole_radius) / g.sleeve_half_height;
        (vec![0.0, edge, g.bird_angle], vec![g.velocities[0], 0.0, g.velocities[1]])
    }

    fn empty_mass_matrix(&self) -> MassMatrix {
        MassMatrix::Dense(vec![0.0; VELOCITIES * VELOCITIES])
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        if let MassMatrix::Dense(dense) = mass {
            let g = &self.geometry;
            let ([sleeve, bird], [l_m, l_g]) = (g.masses, [g.spring_distance, g.bird_distance]);
            let between = bird * l_m * l_g;
            dense.copy_from_slice(&[
                sleeve + bird,
                bird * l_m,
                bird * l_g,
                bird * l_m,
                g.inertias[0] + bird * l_m * l_m,
                between,
                bird * l_g,
                between,
                g.inertias[1] + bird * l_g * l_g,
            ]);
        }
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        let g = &self.geometry;
        let ([sleeve, bird], down) = (g.masses, -g.gravity);
        force.copy_from_slice(&[
            down * (sleeve + bird),
            down * bird * g.spring_distance,
            down * bird * g.bird_distance,
        ]);
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        let g = &self.geometry;
        let play = g.sleeve_radius - g.pole_radius;
        rows.jacobian.copy_from_slice(&[
            0.0,
            0.0,
            -g.beak_height,
            0.0,
            g.sleeve_half_height,
            0.0,
            0.0,
            -g.sleeve_half_height,
            0.0,
        ]);
        let [beak, edge] = [g.beak_height * q[2], g.sleeve_half_height * q[1]];
        rows.position.copy_from_slice(&[self.beak_distance() - beak, play + edge, play - edge]);
    }

    fn is_plastic(&self, contact: usize) -> bool {
        contact != 0
    }

    fn tangential_rows(&self) -> usize {
        3
    }

    fn tangential(&self, _q: &[f64], _v: &[f64], rows: &mut Rows) {
        let g = &self.geometry;
        let edge = [1.0, g.sleeve_radius, 0.0];
        rows.jacobian[..VELOCITIES].copy_from_slice(&[1.0, g.spring_distance, g.bird_distance - g.beak_length]);
        rows.jacobian[VELOCITIES..2 * VELOCITIES].copy_from_slice(&edge);
        rows.jacobian[2 * VELOCITIES..].copy_from_slice(&edge);
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        let lever = self.geometry.lever;
        rows.jacobian.copy_from_slice(&[0.0, -lever, lever]);
        rows.position[0] = lever * (q[2] - q[1]);
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let g = &self.geometry;
        let [sleeve, bird] = g.masses;
        g.gravity * ((sleeve + bird) * q[0] + bird * (g.spring_distance * q[1] + g.bird_distance * q[2]))
    }

    fn observables(&self) -> Vec<Name> {
        names(&["sleeve_y_m", "sleeve_angle_rad", "bird_angle_rad"])
    }

    fn contact_names(&self) -> Vec<Name> {
        names(&["beak", "lower_edge", "upper_edge"])
    }

    fn observe(&self, q: &[f64], _v: &[f64], row: &mut [f64]) {
        row.copy_from_slice(q);
    }
}

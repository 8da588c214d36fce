//! `woodpecker`: a bird on a spring pecks its way down a pole; its sleeve jams on the pole and lets go, hop by hop. The
//! spring is the actuator, its length measured on a lever r, so that `k = c/r²`. Shown in `docs/cases/woodpecker.md`;
//! after Glocker 1995 and Leine, Glocker, van Campen 2001; lever *ours*.

use super::prelude::*;
use rimbench_core::interface_model::{MatrixForm, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

parameters! {
    /// The toy.
    struct Toy from "Glocker 1995" {
        sleeve_mass_kg: f64 = 3e-4, Positive, "mass m_M of the sleeve";
        bird_mass_kg: f64 = 4.5e-3, Positive, "mass m_S of the bird";
        sleeve_inertia_kg_m2: f64 = 5e-9, Positive, "inertia J_M of the sleeve";
        bird_inertia_kg_m2: f64 = 7e-7, Positive, "inertia J_S of the bird about its centre of mass";
        pole_radius_m: f64 = 2.5e-3, Positive, "radius r_O of the pole";
        sleeve_radius_m: f64 = 3.1e-3, Positive, "inner radius r_M of the sleeve, above that of the pole";
        sleeve_half_height_m: f64 = 5.8e-3, Positive, "half the height h_M of the sleeve";
        spring_distance_m: f64 = 1e-2, Positive, "l_M from the middle of the sleeve to the spring";
        bird_distance_m: f64 = 1.5e-2, Positive, "l_G from the spring to the bird's centre of mass";
        beak_height_m: f64 = 2e-2, Positive, "h_S of the beak above the bird's centre of mass";
        beak_length_m: f64 = 2.01e-2, Positive, "l_S of the beak before the bird's centre of mass";
        spring_stiffness_nm_rad: f64 = 5.6e-3, Positive, "torsional stiffness c of the spring";
        spring_lever_m: f64 = 1e-2, Positive, "lever r that length and force of the spring are measured on".from("ours");
        bird_angle_rad: f64 = -0.2788, Finite, "angle φ_S of the bird at the start";
        sleeve_velocity_m_s: f64 = -0.3411, Finite, "velocity of the sleeve at the start";
        bird_rate_rad_s: f64 = -7.4583, Finite, "angular velocity of the bird at the start";
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution", "friction"]).default("restitution", 0.5)
            .about("restitution", "restitution e of the beak along the normal; the sleeve's edges are plastic")
            .source("restitution", "Glocker 1995").default("friction", 0.3).within("friction", Positive)
            .source("friction", "Glocker 1995");
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: trace_of(
            &carriage::interface(),
            "sleeve_y_m sleeve_angle_rad bird_angle_rad",
            &["beak", "lower_edge", "upper_edge"],
            "effective_mass_kg gap_*_m contact_force_*_n friction_force_*_n contact_state_* closed_contacts",
        ),
        interface_columns: carriage::interface(),
        constant_mechanics: true,
        drawing: drawn(|p: &Toy| Some(drawing(p))),
        reference: reference(),
        ..Case::new(
            "woodpecker",
            "Woodpecker toy: a bird on a spring descends a pole in hops, its sleeve jams and lets go (impacts, stick, slip)",
            times(0.3, 5e-4, 1e-5, [1e-5, 5e-5]),
            build,
        )
    }
}

fn drawing(p: &Toy) -> Drawing {
    let [inner, half, outer] = [p.sleeve_radius_m, p.sleeve_half_height_m, p.sleeve_radius_m + 1.5e-3];
    let side = |from: f64, to: f64| {
        Shape::Polygon(points("sleeve", [[from, -half], [to, -half], [to, half], [from, half]]), Fill::Metal)
    };
    let (back, beak) = (p.bird_distance_m, [p.bird_distance_m - p.beak_length_m, p.beak_height_m]);
    let body = [
        [back - 4e-3, -1.2e-2],
        [back + 5e-3, -8e-3],
        [back + 6e-3, 8e-3],
        [back, 2.2e-2],
        beak,
        [back - 5e-3, 1.6e-2],
    ];
    Drawing {
        view: [[-0.03, 0.05], [-0.028, 0.032]],
        frames: vec![
            frame("sleeve", 0.0, 0.0, "sleeve_angle_rad"),
            frame("bird", p.spring_distance_m, 0.0, "bird_angle_rad"),
        ],
        shapes: vec![
            wall([-p.pole_radius_m, -1.0], [p.pole_radius_m, 1.0]),
            side(-outer, -inner),
            side(inner, outer),
            Shape::Spring(([outer, 0.0], Some("sleeve")), ([back - 4e-3, 0.0], Some("bird")), 3e-3),
            Shape::Polygon(points("bird", body), Fill::Scheme),
        ],
        title: [
            "Woodpecker",
            "A bird on a spring pecks its way down a pole, seen from the sleeve that jams and lets go.",
        ],
        ..Drawing::default()
    }
}

fn build(p: &Toy, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let lever = p.spring_lever_m;
    let spring_stiffness_n_m = p.spring_stiffness_nm_rad / (lever * lever);
    let spring = SpringActuator::new(Carriage { spring_stiffness_n_m, ..Carriage::defaults() })?;
    assembly.couple(Woodpecker::new(p)?, spring, &p.contacts)
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
/// Equations: Glocker, *Dynamik von Starrkörpersystemen mit Reibung und Stößen* (1995); Leine, Glocker, van Campen,
/// *Nonlinear dynamics of the woodpecker toy* (2001). There the spring is part of the mechanics.
#[derive(Debug, Clone, Copy)]
struct Woodpecker(Toy);

impl Woodpecker {
    /// Places the toy with the sleeve's lower edge on the pole.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if the sleeve does not fit over the pole, or the beak would start inside it.
    fn new(g: &Toy) -> Result<Self> {
        let toy = Woodpecker(*g);
        if g.sleeve_radius_m <= g.pole_radius_m {
            return Err(Error::Incompatible(format!(
                "impossible geometry: a sleeve of inner radius {} m does not go over a pole of {} m",
                g.sleeve_radius_m, g.pole_radius_m
            )));
        }
        let gap = toy.beak_distance() - g.beak_height_m * g.bird_angle_rad;
        if gap < 0.0 {
            return Err(Error::Incompatible(format!(
                "impossible geometry: with an angle of {} rad the beak would start {gap:.6} m from the pole, inside it",
                g.bird_angle_rad
            )));
        }
        Ok(toy)
    }

    /// Distance of the beak from the pole where the bird is level, m.
    fn beak_distance(&self) -> f64 {
        let g = &self.0;
        g.spring_distance_m + g.bird_distance_m - g.beak_length_m - g.pole_radius_m
    }
}

const VELOCITIES: usize = 3;

impl MechanicalModel for Woodpecker {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: VELOCITIES,
            unilateral: 3,
            tangential: 3,
            interface: 1,
            mass: MatrixForm::Dense,
            plastic: &[1, 2],
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let g = &self.0;
        let edge = -(g.sleeve_radius_m - g.pole_radius_m) / g.sleeve_half_height_m;
        (vec![0.0, edge, g.bird_angle_rad], vec![g.sleeve_velocity_m_s, 0.0, g.bird_rate_rad_s])
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        let g = &self.0;
        let ([sleeve, bird], [l_m, l_g]) =
            ([g.sleeve_mass_kg, g.bird_mass_kg], [g.spring_distance_m, g.bird_distance_m]);
        let between = bird * l_m * l_g;
        mass.copy_from_slice(&[
            sleeve + bird,
            bird * l_m,
            bird * l_g,
            bird * l_m,
            g.sleeve_inertia_kg_m2 + bird * l_m * l_m,
            between,
            bird * l_g,
            between,
            g.bird_inertia_kg_m2 + bird * l_g * l_g,
        ]);
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        let g = &self.0;
        let ([sleeve, bird], down) = ([g.sleeve_mass_kg, g.bird_mass_kg], -g.gravity_m_s2);
        force.copy_from_slice(&[
            down * (sleeve + bird),
            down * bird * g.spring_distance_m,
            down * bird * g.bird_distance_m,
        ]);
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        let g = &self.0;
        let play = g.sleeve_radius_m - g.pole_radius_m;
        rows.jacobian.copy_from_slice(&[
            0.0,
            0.0,
            -g.beak_height_m,
            0.0,
            g.sleeve_half_height_m,
            0.0,
            0.0,
            -g.sleeve_half_height_m,
            0.0,
        ]);
        let [beak, edge] = [g.beak_height_m * q[2], g.sleeve_half_height_m * q[1]];
        rows.position.copy_from_slice(&[self.beak_distance() - beak, play + edge, play - edge]);
    }

    fn tangential(&self, _q: &[f64], _v: &[f64], rows: &mut Rows) {
        let g = &self.0;
        let edge = [1.0, g.sleeve_radius_m, 0.0];
        rows.jacobian[..VELOCITIES].copy_from_slice(&[1.0, g.spring_distance_m, g.bird_distance_m - g.beak_length_m]);
        rows.jacobian[VELOCITIES..2 * VELOCITIES].copy_from_slice(&edge);
        rows.jacobian[2 * VELOCITIES..].copy_from_slice(&edge);
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        let lever = self.0.spring_lever_m;
        rows.jacobian.copy_from_slice(&[0.0, -lever, lever]);
        rows.position[0] = lever * (q[2] - q[1]);
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let g = &self.0;
        let [sleeve, bird] = [g.sleeve_mass_kg, g.bird_mass_kg];
        g.gravity_m_s2 * ((sleeve + bird) * q[0] + bird * (g.spring_distance_m * q[1] + g.bird_distance_m * q[2]))
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&["sleeve_y_m", "sleeve_angle_rad", "bird_angle_rad"], &["beak", "lower_edge", "upper_edge"])
    }
}

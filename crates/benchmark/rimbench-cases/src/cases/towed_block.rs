//! `towed-block`: a block on a rough floor, towed by a spring whose end moves on at constant speed V: it sticks and
//! slips in turn. Shown in `docs/cases/towed-block.md`; textbook (Den Hartog; Popp and Stelter), numbers *ours*. With
//! `ω² = k/m`, `Δ = (μ_s − μ_k) m g/k`:
//!
//! ```text
//! slip   e(τ) = μ_k m g/k + Δ cos ωτ + (V/ω) sin ωτ        spring extended by e; ẋ = V − ė
//!        from e = μ_s m g/k, for (π + 2 atan(V/(ω Δ)))/ω, to e = (2 μ_k − μ_s) m g/k
//! stick  ė = V, for 2 Δ/V                                  F = μ_k m g ± k √(Δ² + V²/ω²) at most and least
//! ```

use super::prelude::*;
use rimbench_core::friction::ContactState;
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};
use std::f64::consts::PI;

parameters! {
    /// A block and the spring that tows it.
    struct Towed from "ours" {
        block_mass_kg: f64 = 1.0, Positive, "mass m of the block";
        spring_stiffness_n_m: f64 = 100.0, Positive, "stiffness k of the spring, relaxed at the start";
        towing_speed_m_s: f64 = 0.1, Positive, "speed V of the spring's other end";
        gravity_m_s2: f64 = 9.81, Positive, "gravity".from("standard");
        contacts: Contacts with |set| set
            .only(&["stabilisation", "friction", "static_friction"]).default("friction", 0.4)
            .within("friction", Positive).about("friction", "coefficient of friction μ_k of contacts that slide")
            .default("static_friction", 0.5);
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: carriage::trace_columns(
            "effective_mass_kg gap_floor_m contact_force_floor_n friction_force_floor_n contact_state_floor closed_contacts",
        ),
        interface_columns: carriage::interface(),
        constant_mechanics: true,
        drawing: drawn(|p: &Towed| {
            Some(Drawing {
                view: [[-0.25, 0.85], [-0.1, 0.3]],
                frames: vec![
                    frame("block", "interface_position_m", 0.08, 0.0),
                    frame("end", Channel::Column("time_s", p.towing_speed_m_s, 0.35), 0.08, 0.0),
                ],
                shapes: vec![
                    ground(&[[-5.0, 0.0], [5.0, 0.0]]),
                    Shape::Spring(([0.1, 0.0], Some("block")), ([0.0, 0.0], Some("end")), 0.05),
                    Shape::Polygon(rectangle("block", [0.0, 0.0], [0.2, 0.16]), Fill::Scheme),
                    Shape::Polygon(points("end", [[0.0, -0.03], [0.06, 0.0], [0.0, 0.03]]), Fill::Metal),
                ],
                title: ["Towed block", "A spring tows a block over a rough floor: it sticks and slips in turn."],
                ..Drawing::default()
            })
        }),
        reference: Arc::new(|parameters| Ok(ReferenceMethod::Exact(exact(&Towed::read(parameters))))),
        ..Case::new(
            "towed-block",
            "Block towed over a rough floor by a spring: sticks and slips in turn (friction at rest above that in motion; closed form)",
            times(4.0, 5e-3, 5e-5, [1e-4, 2e-4]),
            build,
        )
    }
}

fn build(p: &Towed, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let spring = Carriage { spring_stiffness_n_m: p.spring_stiffness_n_m, ..Carriage::defaults() };
    let spring = SpringActuator::new(spring)?.with_drift(p.towing_speed_m_s);
    assembly.couple(SlidingBlock(*p), spring, &p.contacts)
}

/// A block that does not turn. Coordinates: its place x along the floor and the height y of its sole above it.
///
/// ```text
/// g = y     A_u = [0, 1]     A_t = [1, 0]     A_i = [1, 0]     s = x
/// ```
#[derive(Debug, Clone, Copy)]
struct SlidingBlock(Towed);

impl MechanicalModel for SlidingBlock {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: 2,
            unilateral: 1,
            tangential: 1,
            interface: 1,
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; 2], vec![0.0; 2])
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.fill(self.0.block_mass_kg);
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[0.0, -self.0.block_mass_kg * self.0.gravity_m_s2]);
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[1] = 1.0;
        rows.position[0] = q[1];
    }

    fn tangential(&self, _q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[0] = 1.0;
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[0] = 1.0;
        rows.position[0] = q[0];
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.0.block_mass_kg * self.0.gravity_m_s2 * q[1]
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&[], &["floor"])
    }
}

/// The stick–slip cycle of a block that starts at rest with its spring relaxed.
#[derive(Debug, Clone, Copy)]
struct Cycle {
    mass: f64,
    stiffness: f64,
    speed: f64,
    weight: f64,
    /// Friction at rest and in motion, N.
    friction: [f64; 2],
    omega: f64,
    /// Δ, m.
    drop: f64,
    /// When it first lets go, s.
    first_release: f64,
    /// Lengths of a slip and of a stick, s.
    slip: f64,
    stick: f64,
}

impl Cycle {
    fn of(p: &Towed) -> Self {
        let [mass, stiffness, speed] = [p.block_mass_kg, p.spring_stiffness_n_m, p.towing_speed_m_s];
        let weight = mass * p.gravity_m_s2;
        let friction = p.contacts.coefficients().map(|coefficient| coefficient * weight);
        let omega = (stiffness / mass).sqrt();
        let drop = (friction[0] - friction[1]) / stiffness;
        Cycle {
            mass,
            stiffness,
            speed,
            weight,
            friction,
            omega,
            drop,
            first_release: friction[0] / (stiffness * speed),
            slip: (PI + 2.0 * libm::atan2(speed, omega * drop)) / omega,
            stick: 2.0 * drop / speed,
        }
    }

    /// Extension of the spring, m, velocity of the block, m/s, and whether it sticks.
    fn at(&self, t: f64) -> (f64, f64, bool) {
        let since = t - self.first_release;
        if since <= 0.0 {
            return (self.speed * t, 0.0, true);
        }
        let within = since - (since / (self.slip + self.stick)).floor() * (self.slip + self.stick);
        let [at_rest, in_motion] = self.friction.map(|force| force / self.stiffness);
        if within >= self.slip {
            return (in_motion - self.drop + self.speed * (within - self.slip), 0.0, true);
        }
        if within == 0.0 {
            return (at_rest, 0.0, true);
        }
        let (sin, cos) = libm::sincos(self.omega * within);
        let extension = in_motion + self.drop * cos + self.speed / self.omega * sin;
        (extension, self.speed * (1.0 - cos) + self.omega * self.drop * sin, false)
    }
}

/// The closed form, as rows of the trace.
fn exact(p: &Towed) -> ExactSolution {
    let cycle = Cycle::of(p);
    Box::new(move |t, _, row| {
        let (extension, velocity, sticks) = cycle.at(t);
        let force = cycle.stiffness * extension;
        let (effective_mass, friction, state) = if sticks {
            (f64::INFINITY, -force, ContactState::Stick)
        } else {
            (cycle.mass, -cycle.friction[1], ContactState::SlipPositive)
        };
        row.copy_from_slice(&[
            t,
            cycle.speed * t - extension,
            velocity,
            force,
            force,
            effective_mass,
            0.0,
            cycle.weight,
            friction,
            state.as_number(),
            1.0,
        ]);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cycle_has_the_period_and_the_forces_of_theory() {
        let cycle = Cycle::of(&Towed::defaults());
        let period = cycle.slip + cycle.stick;
        approx::assert_relative_eq!(period, 0.669357, epsilon = 5e-7);
        let forces =
            (0..=100_000).map(|k| cycle.stiffness * cycle.at(cycle.first_release + period * f64::from(k) / 1e5).0);
        let [least, most] = forces.fold([f64::INFINITY, 0.0], |[low, high], force| [force.min(low), force.max(high)]);
        approx::assert_relative_eq!(most, 5.32484, epsilon = 5e-6);
        approx::assert_relative_eq!(least, 2.52316, epsilon = 5e-6);
    }

    /// Force, velocity and their rates fit where a slip begins and ends, and within it the block obeys Newton.
    #[test]
    fn the_closed_form_is_a_motion() {
        let usual = Towed::defaults();
        let at_rest = |static_friction: f64| Contacts { static_friction, ..usual.contacts };
        for set in [
            usual,
            Towed { contacts: at_rest(0.0), ..usual },
            Towed { contacts: at_rest(0.9), towing_speed_m_s: 0.37, ..usual },
        ] {
            let cycle = Cycle::of(&set);
            let step = 1e-6;
            for k in 0..2000 {
                let t = f64::from(k) * 1e-3;
                let [(e, v, _), (later, v_later, sticks)] = [t, t + step].map(|t| cycle.at(t));
                // Rates are below 1 m/s and 10 m/s², and change by at most twice that.
                assert!((later - e - step * (cycle.speed - v)).abs() <= 20.0 * step * step, "{t}");
                let rate = (cycle.stiffness * e - cycle.friction[1]) / cycle.mass;
                let wanted = if sticks { 0.0 } else { v + step * rate };
                assert!((v_later - wanted).abs() <= 20.0 * step, "{t}: {v_later}, not {wanted}");
                assert!(cycle.stiffness * e <= cycle.friction[0] * (1.0 + 1e-12) || !sticks, "{t}");
            }
        }
    }
}

//! Stiff forces taken implicitly: stability, order, books, and the interface model that belongs to the step.

use rimbench::cosim::{Port, Ports, Quantity, SecondOrder, Subsystem};
use rimbench::interface_model::{MassMatrix, Rows};
use rimbench::mechanics::{ContactLaw, MechanicalModel, ModelSize, NonSmoothMechanics, StiffForces};
use rimbench::solver_entry::SolverEntry;

/// Masses on springs and dampers with a floor below the first; the last is held.
///
/// ```text
/// m v̇ = −K q − D v − β v³ + F        β is nobody's stiffness
/// ```
#[derive(Clone)]
struct Chain {
    mass: Vec<f64>,
    forces: StiffForces,
    cubic: f64,
    /// Of the first mass above the floor at q = 0, m.
    clearance: f64,
    start: (Vec<f64>, Vec<f64>),
    offered: bool,
}

impl Chain {
    /// One mass of 1 kg.
    fn oscillator(omega: f64, zeta: f64, start: [f64; 2]) -> Self {
        let forces = StiffForces {
            stiffness: MassMatrix::Diagonal(vec![omega * omega]),
            damping: MassMatrix::Diagonal(vec![2.0 * zeta * omega]),
        };
        let start = (vec![start[0]], vec![start[1]]);
        Chain { mass: vec![1.0], forces, cubic: 0.0, clearance: 1e9, start, offered: true }
    }

    /// Three masses with springs between them, that of the last pair `stiff` (N/m).
    fn of_three(stiff: f64, damping: f64, clearance: f64) -> Self {
        let k = vec![30.0, -20.0, 0.0, -20.0, 20.0 + stiff, -stiff, 0.0, -stiff, stiff];
        let d = k.iter().map(|k| damping * k).collect();
        let forces = StiffForces { stiffness: MassMatrix::Dense(k), damping: MassMatrix::Dense(d) };
        let start = (vec![0.3, 0.1, 0.1], vec![-1.0, 0.5, 0.2]);
        Chain { mass: vec![1.0, 0.5, 2.0], forces, cubic: 0.0, clearance, start, offered: true }
    }

    fn mechanics(self, rule: SecondOrder) -> NonSmoothMechanics<Chain> {
        let ports = Ports {
            inputs: vec![Port::new("force_n", Quantity::Force)],
            outputs: vec![Port::new("q_m", Quantity::Position), Port::new("v_m_s", Quantity::Velocity)],
            direct_feedthrough: false,
        };
        let law = ContactLaw { stabilisation: 0.2, restitution: 0.0, spring: None };
        let mut mechanics = NonSmoothMechanics::new(self, law, ports, SolverEntry::active_set().checked(1));
        mechanics.capabilities().use_second_order(rule).unwrap();
        mechanics
    }

    fn after(self, rule: SecondOrder, force: f64, duration: f64, steps: u32) -> NonSmoothMechanics<Chain> {
        let mut mechanics = self.mechanics(rule);
        let h = duration / f64::from(steps);
        for step in 0..steps {
            mechanics.step(f64::from(step) * h, &[force], h).unwrap();
        }
        mechanics
    }
}

impl MechanicalModel for Chain {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: self.mass.len(),
            unilateral: 1,
            interface: 1,
            stiff_forces: self.offered.then(|| self.forces.stiffness.form()),
            ..ModelSize::default()
        }
    }
    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        self.start.clone()
    }
    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.copy_from_slice(&self.mass);
    }
    fn forces(&self, q: &[f64], v: &[f64], force: &mut [f64]) {
        force.iter_mut().zip(v).for_each(|(force, v)| *force = -self.cubic * v.powi(3));
        self.forces.stiffness.add_product(-1.0, q, force);
        self.forces.damping.add_product(-1.0, v, force);
    }
    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[0] = 1.0;
        rows.position[0] = q[0] + self.clearance;
    }
    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[q.len() - 1] = 1.0;
        rows.position[0] = q[q.len() - 1];
    }
    fn stiff_forces(&self, _q: &[f64], _v: &[f64], forces: &mut StiffForces) {
        forces.clone_from(&self.forces);
    }
    fn potential_energy(&self, q: &[f64]) -> f64 {
        0.5 * self.forces.stiffness.product(q, q)
    }
}

const RULES: [SecondOrder; 2] = [SecondOrder::Midpoint, SecondOrder::EventSplit];

/// Largest amplitude, √(q² + v²/ω²), at the end of 100 to 2000 steps from an amplitude of one.
fn amplitude(h_omega: f64, zeta: f64, offered: bool, rule: SecondOrder) -> f64 {
    let (omega, start) = (1e4, [0.6, 0.8e4]);
    let mut mechanics = Chain { offered, ..Chain::oscillator(omega, zeta, start) }.mechanics(rule);
    let mut largest = 0.0_f64;
    for step in 0..2000 {
        mechanics.step(0.0, &[0.0], h_omega / omega).unwrap();
        if step >= 100 {
            largest = largest.max(mechanics.position()[0].hypot(mechanics.velocity()[0] / omega));
        }
    }
    largest
}

#[test]
fn an_oscillator_does_not_grow_at_any_step_length_unless_its_stiffness_is_kept_back() {
    for rule in RULES {
        for h_omega in [0.1, 1.0, 1.9, 1.99, 2.1, 10.0, 100.0, 1e3] {
            for zeta in [0.0, 0.01, 0.3, 1.0, 5.0] {
                // The explicit rule keeps q² (1 − y²/4) + v²/ω²; the implicit one q² + v²/ω². Each of 2000 steps rounds
                // some ten times, and q beside ½hv.
                let explicit: f64 = 1.0 - 0.25 * h_omega * h_omega;
                let bound = if explicit > 0.0 { 1.0 / explicit.sqrt() } else { 1.0 };
                let largest = amplitude(h_omega, zeta, true, rule);
                assert!(
                    largest <= bound * (1.0 + 2e4 * f64::EPSILON * h_omega.max(1.0)),
                    "hω = {h_omega}, ζ = {zeta}: {largest}"
                );
            }
        }
        // Beyond its limit the explicit rule grows by (x + √(x² − 1))² a step, x = hω/2; or with damping beyond y² +
        // 8ζy = 4.
        assert!(amplitude(2.1, 0.0, false, rule) > 1e6);
        assert!(amplitude(1.95, 0.01, false, rule) < 1.0);
        assert!(amplitude(1.97, 0.01, false, rule) > 1e6);
    }
}

#[test]
fn the_step_has_order_two_whatever_part_of_the_forces_is_taken_implicitly() {
    for rule in RULES {
        for cubic in [0.0, 3.0] {
            // A damper that the explicit rule cannot take at these steps (hd/m of 12 to 50), and whose own motion is
            // over: what is left is slow, and moves on the cubic friction too.
            let mut chain = Chain { cubic, ..Chain::of_three(100.0, 0.0, 1e9) };
            let pair = |of: f64| vec![0.0, 0.0, 0.0, 0.0, of, -of, 0.0, -of, of];
            chain.forces.damping = MassMatrix::Dense(pair(1e3));
            chain.start = (vec![0.3, 0.1, 0.1], vec![-1.0, 0.5, 0.5]);
            let at = |steps| {
                let after = chain.clone().after(rule, 0.0, 1.0, steps);
                [after.position(), after.velocity()].concat()
            };
            let states = [at(40), at(80), at(160)];
            let distance =
                |i: usize| states[i].iter().zip(&states[i + 1]).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
            let ratio = distance(0) / distance(1);
            assert!((3.6..4.4).contains(&ratio), "{rule:?}, β = {cubic}: {ratio}");
        }
    }
}

#[test]
fn the_energy_identity_closes_and_linear_forces_without_damping_keep_their_energy_at_every_step_length() {
    for rule in RULES {
        for (stiff, damping, clearance) in [(4e6, 0.0, 1e9), (4e6, 1e-4, 1e9), (4e6, 0.0, 0.0), (4e6, 1e-4, 0.0)] {
            let chain = Chain::of_three(stiff, damping, clearance);
            // The highest frequency is √(stiff (1/0.5 + 1/2)) = 3162 rad/s: hω = 63.
            let mut mechanics = chain.after(rule, 2.0, 2.0, 100);
            let energies = mechanics.energy().abs() + 1.0;
            let name = format!("{rule:?}, damping {damping}, clearance {clearance}");
            // Matrices of 1e3 (h²K/4 against 1 kg) round 1e3 times the energy of a step.
            let bound = 1e3 * 16.0 * f64::EPSILON * energies;
            let ledger = *mechanics.ledger();
            assert!(ledger.identity_residual < bound, "{name}: {:e}", ledger.identity_residual);
            let account = mechanics.capabilities().energy_account().unwrap();
            if damping == 0.0 {
                let integration = account.integration;
                assert!(integration.abs() < 100.0 * bound, "{name}: {integration:e} J out of nothing");
            } else {
                assert!(account.integration < -1e-3, "{name}: dampers take {} J", account.integration);
            }
            assert_eq!(account.contact > 1e-3, clearance < 1.0, "{name}: {} J in impacts", account.contact);
        }
    }
}

#[test]
fn the_interface_model_over_the_whole_step_ends_where_the_step_does() {
    let force = 2.0;
    for h in [1e-3, 1e-2, 1e-1] {
        let mut mechanics = Chain::of_three(4e6, 1e-4, 1e9).after(SecondOrder::EventSplit, force, 10.0 * h, 10);
        let mut model = mechanics.capabilities().empty_interface_model().unwrap();
        assert!(mechanics.capabilities().interface_model(h, &mut model).unwrap());
        let foretold = model.w[1] + h * (model.a[1] + model.entry(1, 1) * force);
        mechanics.step(0.0, &[force], h).unwrap();
        let reached = mechanics.velocity()[2];
        // Free velocity and answer to the force may be 1e4 times their sum: h f/m̂ of a displacement of 1 m.
        assert!((foretold - reached).abs() < 1e-10, "h = {h}: {foretold} foretold, {reached} reached");
    }
}

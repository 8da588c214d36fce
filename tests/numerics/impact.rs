//! Impacts with known answers: rocking block, bouncing ball, three-ball cradle, redundant supports.

use crate::support::*;
use rimbench::cosim::Subsystem;
use rimbench::interface_model::{MassMatrix, Rows};
use rimbench::mechanics::{ContactLaw, MechanicalModel, ModelSize, NonSmoothMechanics};
use rimbench::name::{Name, names};

/// Free planar block on two corners over the floor, with exact geometry; the interface row pushes its centre sideways.
#[derive(Clone, Copy)]
struct Block {
    mass: f64,
    inertia: f64,
    half_width: f64,
    height: f64,
    gravity: f64,
    q: [f64; 3],
    v: [f64; 3],
}

impl MechanicalModel for Block {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: 3, bilateral: 0, unilateral: 2, interface: 1 }
    }
    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.q.to_vec(), self.v.to_vec())
    }
    fn prepare(&mut self, _q: &[f64], _v: &[f64]) {}
    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        *mass = MassMatrix::Diagonal(vec![self.mass, self.mass, self.inertia]);
    }
    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[0.0, -self.mass * self.gravity, 0.0]);
    }
    fn bilateral(&self, _q: &[f64], _v: &[f64], _rows: &mut Rows) {}
    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let (sin, cos) = q[2].sin_cos();
        for (row, side) in [(0, -self.half_width), (1, self.half_width)] {
            // Arm of the corner (side, −height), turned.
            let (x, y) = (side * cos + self.height * sin, side * sin - self.height * cos);
            rows.jacobian[3 * row..3 * row + 3].copy_from_slice(&[0.0, 1.0, x]);
            rows.position[row] = q[1] + y;
            rows.convective[row] = -v[2] * v[2] * y;
        }
    }
    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian.copy_from_slice(&[1.0, 0.0, 0.0]);
        rows.position[0] = q[0];
    }
    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.mass * self.gravity * q[1]
    }
    fn observables(&self) -> Vec<Name> {
        names(&[])
    }
    fn gap_names(&self) -> Vec<Name> {
        names(&["gap_left_m", "gap_right_m"])
    }
    fn contact_force_names(&self) -> Vec<Name> {
        names(&["force_left_n", "force_right_n"])
    }
    fn observe(&self, _q: &[f64], _v: &[f64], _row: &mut [f64]) {}
}

/// Level on the floor, turning about its left corner so that the right one strikes.
fn striking(inertia: f64, half_width: f64) -> Block {
    let omega = -0.7;
    let height = 0.8;
    Block {
        mass: 3.0,
        inertia,
        half_width,
        height,
        gravity: 0.0,
        q: [0.0, height, 0.0],
        v: [height * -omega, half_width * omega, omega],
    }
}

/// `(I − m b²)/(I + m b²)` if that is positive, else 0: without friction, plastic at both corners.
fn rocking_law(block: &Block) -> f64 {
    let m_b2 = block.mass * block.half_width * block.half_width;
    if block.inertia > m_b2 { (block.inertia - m_b2) / (block.inertia + m_b2) } else { 0.0 }
}

#[test]
fn a_rocking_block_must_keep_the_angular_velocity_of_the_two_corner_impact_law() {
    for (inertia, half_width) in [(2.0, 0.5), (1.0, 0.2), (4.0, 1.0), (0.75, 0.5), (0.5, 0.5), (0.2, 1.0)] {
        let block = striking(inertia, half_width);
        let mut mechanics = stepper(block, PLASTIC);
        let before = mechanics.energy();
        // The corners' centripetal acceleration ω² 0.8 m acts for h: a change of 4e-13 m/s, 1e-12 of ω at most.
        mechanics.step(0.0, &[0.0], 1e-12).unwrap();
        let omega = mechanics.velocity()[2];
        let wanted = rocking_law(&block);
        assert!((omega / block.v[2] - wanted).abs() < 3e-12, "I={inertia} b={half_width}: {}", omega / block.v[2]);
        assert_eq!(mechanics.velocity()[0], block.v[0], "no friction: the floor must not touch ẋ");
        let [left, right] = [0, 1].map(|corner| mechanics.contact_impulses()[corner]);
        assert!(right > 0.0, "the striking corner carries the impact");
        // At I = m b² the other corner is reached by nothing and opens by nothing.
        if inertia != block.mass * half_width * half_width {
            assert_eq!(left == 0.0, wanted > 0.0, "the other corner opens exactly if the block rocks on");
        }
        // All that is lost is contact work, and an impact loses something.
        let ledger = mechanics.ledger();
        let lost = mechanics.energy() - before;
        assert!(ledger.contact < 0.0);
        // m g y does not enter without gravity; sums of three squares round to a few ε.
        assert!((ledger.contact - lost).abs() < 8.0 * f64::EPSILON * before, "{} is not {lost}", ledger.contact);
    }
}

#[test]
fn a_block_that_rocks_under_gravity_must_follow_the_impact_law_at_its_first_impact() {
    let law = |h: f64| {
        let mut block = Block { gravity: 9.81, v: [0.0; 3], ..striking(2.0, 0.5) };
        // Leant to the left on its left corner, 0.02 rad.
        let tilt = 0.02_f64;
        block.q = [0.0, block.height * tilt.cos() + block.half_width * tilt.sin(), tilt];
        let mut mechanics = stepper(block, PLASTIC);
        let (mut before, mut step) = (0.0, 0);
        loop {
            mechanics.step(step as f64 * h, &[0.0], h).unwrap();
            step += 1;
            assert!((step as f64) * h < 2.0, "the right corner must come down");
            // The corner lands in one step and is stopped in the next; two more let the left one open.
            if mechanics.contact_impulses()[1] > 0.0 {
                break;
            }
            before = mechanics.velocity()[2];
        }
        for _ in 0..3 {
            mechanics.step(step as f64 * h, &[0.0], h).unwrap();
            step += 1;
        }
        (mechanics.velocity()[2] / before, rocking_law(&block))
    };
    // Gravity turns the block by about g m b / (I + m b²) = 5 rad/s² during the four steps around the impact, at 0.44 rad/s:
    // 4 h · 5 / 0.44.
    for h in [1e-4, 1e-5] {
        let (found, wanted) = law(h);
        println!("rocking under gravity, h = {h:e}: {found:.6}, law {wanted:.6}");
        assert!((found - wanted).abs() < 50.0 * h, "h={h}: {found} is not {wanted}");
    }
}

/// A ball over the floor; the interface row is its height, pushed by nothing.
fn ball(height: f64, gravity: f64, restitution: f64) -> NonSmoothMechanics<LinearModel> {
    let model = LinearModel {
        mass: vec![1.0],
        force: vec![-gravity],
        unilateral: ConstantRows::new(&[(&[1.0], 0.0)]),
        interface: ConstantRows::new(&[(&[1.0], 0.0)]),
        q: vec![height],
        v: vec![0.0],
        ..LinearModel::default()
    };
    stepper(model, ContactLaw { restitution, ..PLASTIC })
}

#[test]
fn a_bouncing_ball_must_hit_the_floor_in_time_and_return_to_its_heights() {
    let (g, e, h) = (9.81, 0.9, 1e-5);
    let mut mechanics = ball(1.0, g, e);
    let (mut impacts, mut heights, mut highest) = (Vec::new(), Vec::new(), 0.0_f64);
    let mut step = 0;
    while impacts.len() < 5 {
        let falling = mechanics.velocity()[0] < 0.0;
        mechanics.step(step as f64 * h, &[0.0], h).unwrap();
        step += 1;
        if falling && mechanics.velocity()[0] > 0.0 {
            impacts.push(step as f64 * h);
            if impacts.len() > 1 {
                heights.push(highest);
            }
            highest = 0.0;
        }
        highest = highest.max(mechanics.position()[0]);
    }
    let first = (2.0 / g).sqrt();
    assert!((first - 0.451523641).abs() < 1e-9);
    // Semi-implicit Euler falls g t h/2 too far, i.e. arrives h/2 early; the impact then waits for the end of its step.
    assert!((impacts[0] - first).abs() <= 1.5 * h, "first impact at {}", impacts[0]);
    println!("first impact {:.6} s (exact {first:.6}), heights {heights:.6?}", impacts[0]);
    for (bounce, height) in heights.iter().enumerate() {
        let n = bounce as i32 + 1;
        let (exact, speed) = (e.powi(2 * n), first * g);
        // Each bounce starts up to h v above the floor and with a speed wrong by g h, worth another h v; each apex is
        // cut by at most g h²/8. Errors of earlier bounces shrink by e².
        assert!((height - exact).abs() <= 3.0 * f64::from(n) * h * speed, "height {n}: {height} is not {exact}");
        // Time between impacts n and n+1: 2 eⁿ √(2/g), each impact late or early by 1.5 h.
        let flight = impacts[bounce + 1] - impacts[bounce];
        assert!((flight - 2.0 * e.powi(n) * first).abs() <= 3.0 * f64::from(n) * h, "flight {n}: {flight}");
    }
}

#[test]
fn a_bouncing_ball_must_come_to_rest_at_its_zeno_time_and_not_sink() {
    let (g, e, h) = (9.81, 0.9, 1e-4);
    let mut mechanics = ball(1.0, g, e);
    let (mut last_flight, mut lowest) = (0.0, 0.0_f64);
    for step in 0..100_000 {
        mechanics.step(step as f64 * h, &[0.0], h).unwrap();
        // In flight: more than ten steps' worth of free fall above the floor.
        if mechanics.position()[0] > 50.0 * g * h * h {
            last_flight = step as f64 * h;
        }
        lowest = lowest.min(mechanics.position()[0]);
    }
    let zeno = (2.0 / g).sqrt() * (1.0 + e) / (1.0 - e);
    assert!((zeno - 8.578949).abs() < 1e-6);
    println!("last flight ends at {last_flight:.4} s, Zeno time {zeno:.4} s, lowest {lowest:.2e} m");
    // Bounces until e^n first-speed equals the ten steps that end a flight: n ≈ 57; each is timed within 1.5 h, and what is
    // not counted as flight lasts another 2 √(2·50) h / (1 − e).
    let slack = 57.0 * 1.5 * h + 20.0 * h / (1.0 - e);
    assert!((last_flight - zeno).abs() < slack, "{last_flight} is not {zeno} ± {slack}");
    // A contact bounces in the step in which it would close, and one that gravity alone would close lands on the floor:
    // what is left is the rounding of 10⁵ positions below 1 m.
    assert!(lowest >= -1e5 * f64::EPSILON, "sank to {lowest}");
    assert!(mechanics.velocity()[0].abs() < g * h);
}

#[test]
fn three_balls_in_a_row_must_part_as_moreau_says_and_not_as_newton_did() {
    // Equal masses, touching; the first one comes with 1 m/s. H = [2 −1; −1 2]/m, b = (1 + e)(−1, 0).
    let masses = vec![0.3; 3];
    let model = LinearModel {
        mass: masses,
        force: vec![0.0; 3],
        unilateral: ConstantRows::new(&[(&[-1.0, 1.0, 0.0], 0.0), (&[0.0, -1.0, 1.0], 0.0)]),
        interface: ConstantRows::new(&[(&[1.0, 0.0, 0.0], 0.0)]),
        q: vec![0.0; 3],
        v: vec![1.0, 0.0, 0.0],
        ..LinearModel::default()
    };
    for (restitution, wanted) in [
        (1.0, [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]),
        // Plastic: all go on together.
        (0.0, [1.0 / 3.0; 3]),
        (0.5, [0.0, 0.5, 0.5]),
    ] {
        let mut mechanics = stepper(model.clone(), ContactLaw { restitution, ..PLASTIC });
        mechanics.step(0.0, &[0.0], 1e-3).unwrap();
        for (found, wanted) in mechanics.velocity().iter().zip(wanted) {
            // A 2×2 problem of condition 3.
            approx::assert_abs_diff_eq!(found, &wanted, epsilon = 8.0 * f64::EPSILON);
        }
        let kinetic: f64 = mechanics.velocity().iter().map(|v| 0.5 * 0.3 * v * v).sum();
        if restitution == 1.0 {
            approx::assert_relative_eq!(kinetic, 0.15, max_relative = 8.0 * f64::EPSILON);
        }
    }
}

/// A rigid beam `(x, y, θ)`, 4 kg, on supports at `at` below it, its weight 0.1 m right of the middle; falling with `speed`.
fn supported(
    at: &[f64],
    speed: f64,
    solver: &rimbench::complementarity::SolverEntry,
) -> NonSmoothMechanics<LinearModel> {
    let rows: Vec<[f64; 3]> = at.iter().map(|x| [0.0, 1.0, *x]).collect();
    let rows: Vec<(&[f64], f64)> = rows.iter().map(|row| (row.as_slice(), 0.0)).collect();
    let model = LinearModel {
        mass: vec![4.0, 4.0, 0.5],
        // A load of 10 N hangs 0.1 m right of the centre of mass: moment −1 N·m.
        force: vec![0.0, -4.0 * 9.81 - 10.0, -1.0],
        unilateral: ConstantRows::new(&rows),
        interface: ConstantRows::new(&[(&[1.0, 0.0, 0.0], 0.0)]),
        q: vec![0.0; 3],
        v: vec![0.0, -speed, 0.0],
        ..LinearModel::default()
    };
    let (ports, _) = force_displacement_ports(1);
    NonSmoothMechanics::new(model, PLASTIC, ports, solver.checked(at.len()))
}

#[test]
fn redundant_supports_must_carry_the_right_force_and_moment_with_every_solver() {
    let h = 1e-3;
    for solver in solvers() {
        for at in [vec![-0.5, 0.0, 0.5], vec![-0.4, -0.1, 0.2, 0.6], vec![-0.5, -0.5, 0.1, 0.5, 0.5, 0.0]] {
            for speed in [0.0, 0.3] {
                let mut mechanics = supported(&at, speed, solver);
                mechanics.step(0.0, &[0.0], h).unwrap();
                let impulses = mechanics.contact_impulses();
                assert!(impulses.iter().all(|impulse| *impulse >= 0.0), "{}: {impulses:?}", solver.name);
                let (weight, moment) = (h * (4.0 * 9.81 + 10.0) + 4.0 * speed, h * 1.0);
                let resultant: f64 = impulses.iter().sum();
                let about: f64 = impulses.iter().zip(&at).map(|(impulse, x)| impulse * x).sum();
                // Accepted residuals are `tolerance` relative to the velocity before, weight/m; times mass and inertia.
                let tolerance = 10.0 * solver.tolerance * weight;
                assert!((resultant - weight).abs() <= tolerance, "{} {at:?}: {resultant} is not {weight}", solver.name);
                assert!((about - moment).abs() <= tolerance, "{} {at:?}: {about} is not {moment}", solver.name);
                assert!(mechanics.velocity().iter().all(|v| v.abs() <= tolerance), "it must stop level");
            }
        }
    }
}

#[test]
fn a_load_beyond_the_supports_must_tip_the_beam() {
    // Supports end at 0.01 m; the resultant of the weight acts at 1/49.24 = 0.0203 m.
    let mut mechanics = supported(&[-0.5, -0.2, 0.01], 0.0, &solvers()[0]);
    mechanics.step(0.0, &[0.0], 1e-3).unwrap();
    let impulses = mechanics.contact_impulses();
    assert_eq!(impulses[..2], [0.0, 0.0], "only the last support may carry");
    assert!(impulses[2] > 0.0 && mechanics.velocity()[2] < 0.0, "it must turn clockwise");
}

/// A point of 1 kg on a rope of 1 m: the gap is what is left of its length, and the row turns with the point.
#[derive(Clone, Copy)]
struct OnRope {
    gravity: f64,
    q: [f64; 2],
    v: [f64; 2],
}

impl MechanicalModel for OnRope {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: 2, bilateral: 0, unilateral: 1, interface: 1 }
    }
    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.q.to_vec(), self.v.to_vec())
    }
    fn prepare(&mut self, _q: &[f64], _v: &[f64]) {}
    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        *mass = MassMatrix::Diagonal(vec![1.0; 2]);
    }
    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[0.0, -self.gravity]);
    }
    fn bilateral(&self, _q: &[f64], _v: &[f64], _rows: &mut Rows) {}
    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let r = q[0].hypot(q[1]);
        let across = (q[0] * v[1] - q[1] * v[0]) / r;
        rows.jacobian.copy_from_slice(&[-q[0] / r, -q[1] / r]);
        rows.position[0] = 1.0 - r;
        rows.convective[0] = -across * across / r;
    }
    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian.copy_from_slice(&[1.0, 0.0]);
        rows.position[0] = q[0];
    }
    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.gravity * q[1]
    }
    fn observables(&self) -> Vec<Name> {
        names(&[])
    }
    fn gap_names(&self) -> Vec<Name> {
        names(&["gap_m"])
    }
    fn contact_force_names(&self) -> Vec<Name> {
        names(&["force_n"])
    }
    fn observe(&self, _q: &[f64], _v: &[f64], _row: &mut [f64]) {}
}

/// A pendulum swings on a rope that stays taut. Each step leaves a gap of ½h²|c| and an approach of ½h|c|, which is nothing that hits.
#[test]
fn a_contact_that_rests_on_a_row_that_turns_must_not_rebound_from_what_the_steps_make_of_it() {
    for h in [1e-2, 1e-3, 1e-4] {
        let states = |restitution: f64| {
            let rope = OnRope { gravity: 9.81, q: [0.6, -0.8], v: [0.0; 2] };
            let mut mechanics = stepper(rope, ContactLaw { restitution, ..PLASTIC });
            let steps = (0..(1.0 / h) as usize).map(|_| {
                mechanics.step(0.0, &[0.0], h).unwrap();
                [mechanics.position()[0], mechanics.position()[1], mechanics.contact_impulses()[0]].map(f64::to_bits)
            });
            steps.collect::<Vec<_>>()
        };
        let plastic = states(0.0);
        assert!(plastic.iter().all(|[_, _, impulse]| f64::from_bits(*impulse) > 0.0), "the rope stays taut");
        for restitution in [0.3, 0.5, 1.0] {
            assert_eq!(states(restitution), plastic, "e = {restitution}, h = {h}");
        }
    }
}

/// A point flies into its rope, across it with 2 m/s. What counts as rest is of order h: it turns with 4 m/s², so that a rebound of less than
/// h · 4 m/s² is over in a step. Any speed is an impact if the step is short enough.
#[test]
fn an_impact_on_a_row_that_turns_must_be_one_once_the_step_is_short_enough() {
    for (along, h, taut, rebounds) in [
        (1.0, 1e-3, false, true),
        (0.01, 1e-2, false, false),
        (0.01, 2e-3, false, false),
        (0.01, 1e-3, false, true),
        (0.01, 1e-5, false, true),
        (0.01, 1e-2, true, false),
        (0.01, 1e-3, true, true),
        (0.01, 1e-5, true, true),
    ] {
        let e = 0.5;
        // Taut at the start, or within the first step.
        let gap = if taut { 0.0 } else { 0.5 * h * along };
        let rope = OnRope { gravity: 0.0, q: [1.0 - gap, 0.0], v: [along, 2.0] };
        let mut mechanics = stepper(rope, ContactLaw { restitution: e, ..PLASTIC });
        mechanics.step(0.0, &[0.0], h).unwrap();
        // w⁺ + h c + e w⁻ = 0, where it is hit; else w⁺ + h c + g/h = 0.
        let outwards = mechanics.velocity()[0];
        let wanted = if rebounds { -e * along } else { gap / h } - 4.0 * h;
        // c is −4 m/s² over 1 m, and the point is ½ h w⁻ short of that.
        assert!((outwards - wanted).abs() <= 2.1 * h * h, "{along} m/s, h = {h}: {outwards}, not {wanted}");
    }
}

//! The wedge box once more, in the plainest way that is still honest: what speed is measured against, and an
//! independent check.
//!
//! Everything is written down as in the textbook: a heap-allocated matrix for each symbol of paper Eqs. 3 and 4,
//! inverses as inverses, the complementarity problem by trying one active set after the other, nothing kept from one
//! step to the next. Parameters are those of the case's page.

use nalgebra::{DMatrix, DVector, Rotation2, Vector2};

/// What is recorded at each communication point.
#[derive(Debug, Clone)]
pub struct Row {
    /// Actuator length (m), velocity (m/s) and force (N).
    pub interface: [f64; 3],
    /// The rest; empty for [`Effort::Least`].
    pub observed: Vec<f64>,
}

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// The first active set that fits is taken, and only the interface is recorded.
    Least,
    /// All active sets are compared, and everything is recorded that rimbench records.
    Same,
}

/// Position of the effective mass (kg) in [`Row::observed`].
pub const EFFECTIVE_MASS: usize = 0;
/// Position of the rank of `H_cc`.
pub const RANK: usize = 1;

/// m/s².
pub const GRAVITY: f64 = 9.81;
const STABILISATION: f64 = 0.2;
/// Of box and disc in their coordinates, kg and kg·m².
pub const MASS: [f64; 6] = [200.0, 200.0, 200.0 * (1.0 + 0.36) / 12.0, 50.0, 50.0, 0.5 * 50.0 * 0.04];
/// From the centre of the box to the tip of its right wedge, m.
pub const TIP: Vector2<f64> = Vector2::new(0.4, -0.4);
/// To that of its left wedge, m.
pub const OTHER_TIP: Vector2<f64> = Vector2::new(-0.4, -0.4);
/// To the pin of the disc, m.
pub const PIN: Vector2<f64> = Vector2::new(-0.8, -0.19);
/// To where the cylinder pushes, m.
pub const ATTACHMENT: Vector2<f64> = Vector2::new(-0.5, 0.3);
/// Of the disc, m.
pub const RADIUS: f64 = 0.2;
/// Above the ground, m.
pub const LEDGE_HEIGHT: f64 = 0.06;

/// m².
pub const PISTON_AREA: f64 = 0.0065;
const CYLINDER_LENGTH: f64 = 2.0;
/// Of the piston, N·s/m.
pub const FRICTION: f64 = 1e4;
const VALVE_AREA: f64 = 5e-5;
const DISCHARGE: f64 = 0.67;
const DENSITY: f64 = 850.0;
const SUPPLY: f64 = 7.6e6;
const TANK: f64 = 1e5;
const COMPRESSIBILITY: [f64; 2] = [6.53e-10, -1.19e-18];

/// `A`, `Ȧ v` and positions of a kind of rows.
struct Rows {
    a: DMatrix<f64>,
    convective: DVector<f64>,
    position: DVector<f64>,
}

impl Rows {
    fn zeros(count: usize) -> Self {
        let vector = || DVector::zeros(count);
        Rows { a: DMatrix::zeros(count, 6), convective: vector(), position: vector() }
    }

    /// The velocity, along `n`, of the point at `arm` of the body whose velocities start at `first`.
    fn point(&mut self, row: usize, first: usize, n: Vector2<f64>, arm: Vector2<f64>) {
        self.a[(row, first)] = n.x;
        self.a[(row, first + 1)] = n.y;
        self.a[(row, first + 2)] = arm.x * n.y - arm.y * n.x;
    }
}

/// State of both sides.
pub struct PlainWedgeBox {
    q: DVector<f64>,
    v: DVector<f64>,
    pressure: [f64; 2],
    corner: Vector2<f64>,
    ground_pin: Vector2<f64>,
    start_length: f64,
    impulses: DVector<f64>,
    /// Velocities of the contacts after the last step plus their gap terms, over the largest such number without
    /// impulses; none before the first.
    slack: Option<DVector<f64>>,
    effort: Effort,
}

impl PlainWedgeBox {
    /// At rest, right wedge on the floor, disc on the ledge.
    pub fn new(effort: Effort) -> Self {
        // Bisection for the angle at which the disc's centre is at ledge height plus radius.
        let height = |angle: f64| (Rotation2::new(angle) * (PIN - TIP)).y - LEDGE_HEIGHT - RADIUS;
        let (mut low, mut high) = (-0.2, 0.2);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if height(low) * height(middle) <= 0.0 { high = middle } else { low = middle }
        }
        let angle = 0.5 * (low + high);
        let turn = Rotation2::new(angle);
        let centre = Vector2::new(0.0, -(turn * TIP).y);
        let disc = centre + turn * PIN;
        let attachment = centre + turn * ATTACHMENT;
        let ground_pin = Vector2::new(-3.0, attachment.y);
        PlainWedgeBox {
            q: DVector::from_vec(vec![centre.x, centre.y, angle, disc.x, disc.y, 0.0]),
            v: DVector::zeros(6),
            pressure: [3.85e6; 2],
            corner: Vector2::new(disc.x + 0.1, LEDGE_HEIGHT),
            ground_pin,
            start_length: (attachment - ground_pin).norm(),
            impulses: DVector::zeros(4),
            slack: None,
            effort,
        }
    }

    /// Zero-order hold, Jacobi: both sides step from the values at `t_k`.
    pub fn run(mut self, macro_step: f64, micro_steps: usize, macro_steps: usize) -> Vec<Row> {
        let mut rows = Vec::new();
        for k in 0..=macro_steps {
            let t = k as f64 * macro_step;
            let interface = self.interface();
            let (length, velocity) = (interface.position[0], (&interface.a * &self.v)[0]);
            let force = (self.pressure[1] - self.pressure[0]) * PISTON_AREA - FRICTION * velocity;
            let observed = if self.effort == Effort::Same { self.observe(t, macro_step) } else { Vec::new() };
            rows.push(Row { interface: [length, velocity, force], observed });
            if k < macro_steps {
                let h = macro_step / micro_steps as f64;
                for j in 0..micro_steps {
                    self.step_hydraulics(t + j as f64 * h, length, velocity, h);
                }
                self.step_mechanics(force, macro_step);
            }
        }
        rows
    }

    fn joints(&self) -> Rows {
        let (q, v) = (&self.q, &self.v);
        let pin = Rotation2::new(q[2]) * PIN;
        let mut rows = Rows::zeros(2);
        for (row, n) in [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)].into_iter().enumerate() {
            rows.point(row, 0, -n, pin);
            rows.point(row, 3, n, Vector2::zeros());
            rows.position[row] = n.dot(&Vector2::new(q[3] - q[0] - pin.x, q[4] - q[1] - pin.y));
            rows.convective[row] = v[2] * v[2] * n.dot(&pin);
        }
        rows
    }

    fn contacts(&self) -> Rows {
        let (q, v) = (&self.q, &self.v);
        let up = Vector2::new(0.0, 1.0);
        let mut rows = Rows::zeros(4);
        for (row, tip) in [TIP, OTHER_TIP].into_iter().enumerate() {
            let arm = Rotation2::new(q[2]) * tip;
            rows.point(row, 0, up, arm);
            rows.position[row] = q[1] + arm.y;
            rows.convective[row] = -v[2] * v[2] * arm.y;
        }
        let from_corner = Vector2::new(q[3], q[4]) - self.corner;
        let down = Vector2::new(1.0, -0.15).normalize();
        let across = Vector2::new(-down.y, down.x);
        let (distance, normal, curvature) = if from_corner.x <= 0.0 {
            (from_corner.y, up, 0.0)
        } else if from_corner.dot(&down) >= 0.0 {
            (from_corner.dot(&across), across, 0.0)
        } else {
            (from_corner.norm(), from_corner.normalize(), 1.0 / from_corner.norm())
        };
        rows.point(2, 3, normal, Vector2::zeros());
        rows.position[2] = distance - RADIUS;
        rows.convective[2] = curvature * (v[3] * normal.y - v[4] * normal.x).powi(2);
        rows.point(3, 3, up, Vector2::zeros());
        rows.position[3] = q[4] - RADIUS;
        rows
    }

    fn interface(&self) -> Rows {
        let (q, v) = (&self.q, &self.v);
        let arm = Rotation2::new(q[2]) * ATTACHMENT;
        let along = Vector2::new(q[0], q[1]) + arm - self.ground_pin;
        let n = along.normalize();
        let velocity = Vector2::new(v[0] - v[2] * arm.y, v[1] + v[2] * arm.x);
        let mut rows = Rows::zeros(1);
        rows.point(0, 0, n, arm);
        rows.position[0] = along.norm();
        rows.convective[0] = (n.x * velocity.y - n.y * velocity.x).powi(2) / along.norm() - v[2] * v[2] * n.dot(&arm);
        rows
    }

    /// `M⁻¹`, `M⁻¹ A_bᵀ S⁻¹` and `G`.
    fn eliminate(joints: &Rows) -> [DMatrix<f64>; 3] {
        let m = DMatrix::from_diagonal(&DVector::from_row_slice(&MASS));
        let m_inv = m.try_inverse().expect("masses are positive");
        let s_inv = (&joints.a * &m_inv * joints.a.transpose()).try_inverse().expect("the joint rows are independent");
        let to_joints = &m_inv * joints.a.transpose() * s_inv;
        let g = &m_inv - &to_joints * &joints.a * &m_inv;
        [m_inv, to_joints, g]
    }

    /// The columns that rimbench records besides the interface.
    fn observe(&self, t: f64, h: f64) -> Vec<f64> {
        let (contacts, interface) = (self.contacts(), self.interface());
        let [_, _, g] = Self::eliminate(&self.joints());
        let distance = self.slack.as_ref().unwrap_or(&contacts.position);
        let closed: Vec<usize> = (0..4).filter(|&contact| distance[contact] <= 1e-9).collect();
        let a_c = contacts.a.select_rows(&closed);
        let h_ii = (&interface.a * &g * interface.a.transpose())[0];
        let (mut condensed, mut rank) = (h_ii, 0);
        if !closed.is_empty() {
            let h_cc = &a_c * &g * a_c.transpose();
            let h_ci = &a_c * &g * interface.a.transpose();
            let svd = h_cc.svd(true, true);
            let least = 1e-10 * svd.singular_values.max();
            rank = svd.rank(least);
            condensed -= (h_ci.transpose() * svd.pseudo_inverse(least).expect("both sides of the SVD") * h_ci)[0];
        }
        let effective_mass = if condensed <= 1e-12 * h_ii { f64::INFINITY } else { 1.0 / condensed };
        let mut row = vec![effective_mass, rank as f64, t, closed.len() as f64];
        row.extend(self.q.iter().take(3).chain(&self.pressure).chain(contacts.position.iter()));
        row.extend(self.impulses.iter().map(|impulse| impulse / h));
        row
    }

    /// Eqs. 3 and 4, written down.
    fn step_mechanics(&mut self, force: f64, h: f64) {
        let (joints, contacts, interface) = (self.joints(), self.contacts(), self.interface());
        let f = DVector::from_vec(vec![0.0, -MASS[0] * GRAVITY, 0.0, 0.0, -MASS[3] * GRAVITY, 0.0]);
        let [m_inv, to_joints, g] = Self::eliminate(&joints);
        let start = &self.v - &to_joints * (&joints.a * &self.v + &joints.position * (STABILISATION / h));
        let free = &m_inv * &f - &to_joints * (&joints.a * (&m_inv * &f) + &joints.convective);
        let with_interface = &start + (&free + &g * interface.a.transpose() * DVector::from_element(1, force)) * h;

        let h_uu = &contacts.a * &g * contacts.a.transpose();
        let mut b = &contacts.a * &with_interface + &contacts.convective * h;
        for (b, gap) in b.iter_mut().zip(contacts.position.iter()) {
            *b += if *gap > 0.0 { gap / h } else { STABILISATION * gap / h };
        }
        self.impulses = try_active_sets(&h_uu, &b, self.effort);
        self.slack = Some((&h_uu * &self.impulses + &b) / b.amax());
        self.v = with_interface + &g * contacts.a.transpose() * &self.impulses;
        self.q += &self.v * h;
    }

    fn step_hydraulics(&mut self, t: f64, s: f64, velocity: f64, h: f64) {
        let [rate_1, rate_2] = pressure_rates(t, self.pressure, s - self.start_length, velocity);
        self.pressure = [self.pressure[0] + h * rate_1, self.pressure[1] + h * rate_2];
    }
}

/// Rates of the pressures (Pa/s) with the piston out by `out` (m) from its middle.
pub fn pressure_rates(t: f64, [p1, p2]: [f64; 2], out: f64, velocity: f64) -> [f64; 2] {
    let kappa = if t <= 0.1 { 0.5 } else { (0.5 - 3.0 * (t - 0.1)).max(0.2) };
    let (a_in, a_out) = (VALVE_AREA * kappa, VALVE_AREA * (1.0 - kappa));
    let flow = |area: f64, drop: f64| area * DISCHARGE * (2.0 * drop.max(0.0) / DENSITY).sqrt();
    let stiffness = |p: f64, l: f64| {
        let [a, b] = COMPRESSIBILITY;
        (1.0 + a * p + b * p * p) / (a + 2.0 * b * p) / (PISTON_AREA * l)
    };
    let q1 = PISTON_AREA * velocity + flow(a_in, SUPPLY - p1) - flow(a_out, p1 - TANK);
    let q2 = -PISTON_AREA * velocity + flow(a_out, SUPPLY - p2) - flow(a_in, p2 - TANK);
    [stiffness(p1, 0.5 * CYLINDER_LENGTH - out) * q1, stiffness(p2, 0.5 * CYLINDER_LENGTH + out) * q2]
}

/// Solves `0 ≤ M z + q ⟂ z ≥ 0` by trying active sets; takes the first that fits, or the best of all.
fn try_active_sets(m: &DMatrix<f64>, q: &DVector<f64>, effort: Effort) -> DVector<f64> {
    let n = q.len();
    let mut best = (f64::INFINITY, DVector::zeros(n));
    for members in 0_u32..1 << n {
        let set: Vec<usize> = (0..n).filter(|i| members >> i & 1 == 1).collect();
        let m_aa = DMatrix::from_fn(set.len(), set.len(), |r, c| m[(set[r], set[c])]);
        let minus_q = DVector::from_fn(set.len(), |r, _| -q[set[r]]);
        let solved = if set.is_empty() { Some(minus_q) } else { m_aa.lu().solve(&minus_q) };
        let Some(z_a) = solved else { continue };
        let mut z = DVector::zeros(n);
        for (&i, z_i) in set.iter().zip(z_a.iter()) {
            z[i] = *z_i;
        }
        let w = m * &z + q;
        let violation = (0..n).map(|i| (m[(i, i)] * z[i]).min(w[i]).abs()).fold(0.0, f64::max);
        if violation < best.0 {
            best = (violation, z);
        }
        if effort == Effort::Least && best.0 <= 1e-12 * q.amax() {
            break;
        }
    }
    assert!(best.0 <= 1e-9 * q.amax(), "no active set fits");
    best.1
}

//! Mechanics of many discs between a blade and a wall: a row or a heap that a loader pushes.

use nalgebra::Vector2;
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

/// Masses, geometry and start of [`Discs`].
#[derive(Debug, Clone, PartialEq)]
pub struct DiscsGeometry {
    /// kg.
    pub blade_mass: f64,
    /// Velocity of the blade at the start, m/s.
    pub blade_velocity: f64,
    /// Of each disc, kg.
    pub disc_mass: f64,
    /// m.
    pub radius: f64,
    /// Centres at the start, m; the blade's face starts at x = 0, the floor is y = 0.
    pub centres: Vec<[f64; 2]>,
    /// Centres of discs of the same radius that never move, m: what the others may lie on.
    pub bumps: Vec<[f64; 2]>,
    /// x of the wall, m.
    pub wall_x: f64,
    /// Length of the actuator at the start, m.
    pub actuator_length: f64,
    /// m/s².
    pub gravity: f64,
}

/// Two centres, of which one is seen from the other.
struct Apart {
    distance: f64,
    normal: Vector2<f64>,
    /// `|ċ_⊥|²/|c|`, what is left of the second derivative of the distance.
    convective: f64,
}

impl Apart {
    #[inline]
    fn of(apart: Vector2<f64>, rate: Vector2<f64>) -> Self {
        let distance = apart.norm();
        let normal = apart / distance;
        let across = normal.perp(&rate);
        Apart { distance, normal, convective: across * across / distance }
    }
}

/// Tells contacts of a kind, and says what is missing where there is none, with `{}` for the reach of the list.
type Kind = (fn(&Contact) -> bool, &'static str);

/// What a disc can touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Contact {
    Blade(usize),
    Wall(usize),
    Floor(usize),
    Pair(usize, usize),
    Bump(usize, usize),
}

/// Which contacts of [`Discs`] are possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactList {
    /// Those near at the start, for good: discs keep their neighbours, as in a row.
    Neighbours,
    /// Those near at the start; where something moves beyond what that holds for, the run ends.
    Start,
}

/// Discs without friction or spin, the blade that pushes them, and their possible contacts.
///
/// ```text
/// A_ij = [−nᵀ, nᵀ],  n = (c_j − c_i)/|c_j − c_i|,        Ȧv = |ċ_⊥|²/|c_j − c_i|
/// ```
/// Gaps are those of the text of the cases:
///
#[doc = include_str!("../cases/loader.md")]
///
/// A bump is a disc that does not move: `g = |c_d − c_b| − 2R`, `A = nᵀ`.
///
/// A [list](ContactList) made at the start is of whatever is closer than 1.3 radii. It holds for as long as no disc has
/// moved by more than half of what is missing to the nearest contact that is not listed: [`reach`](Self::reach) says
/// how far that is, and the observable `largest_displacement_m` how much of it is used. A row touches at most two bodies.
/// # Source
/// Ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Discs {
    geometry: DiscsGeometry,
    kind: ContactList,
    contacts: Vec<Contact>,
    reach: f64,
}

/// A gap below zero by up to this part of a radius is rounding.
const ROUNDING: f64 = 1e-9;

impl Discs {
    /// Contacts with a gap below this many radii at the start are listed: in a hexagonal heap the direct neighbours,
    /// whose next ones are 1.46 radii away, and both discs at the end of each layer.
    pub const LISTED: f64 = 1.3;

    /// Lists the contacts. The first rows are a disc at the blade, one at the wall and a pair: those have names.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if there are fewer than two discs, or anything would start inside something else.
    pub fn new(geometry: DiscsGeometry, kind: ContactList) -> Result<Self> {
        let count = geometry.centres.len();
        if count < 2 {
            return Err(Error::Incompatible(format!("there must be at least 2 discs, not {count}")));
        }
        let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| Contact::Pair(i, j)));
        let walls = (0..count).flat_map(|i| [Contact::Blade(i), Contact::Wall(i), Contact::Floor(i)]);
        let bumps = (0..count).flat_map(|i| (0..geometry.bumps.len()).map(move |bump| Contact::Bump(i, bump)));
        let (q, _) = Self::state(&geometry);
        // Rounding of a contact that starts closed.
        let closed = -ROUNDING * geometry.radius;
        let kinds: [Kind; 3] = [
            (
                |contact| matches!(contact, Contact::Blade(_)),
                "no disc starts within {} m of the blade or wall that the actuator moves",
            ),
            (|contact| matches!(contact, Contact::Wall(_)), "no disc starts within {} m of the fixed wall"),
            (|contact| matches!(contact, Contact::Pair(..)), "no two discs start within {} m of each other"),
        ];
        let (mut contacts, mut reach) = (Vec::new(), f64::INFINITY);
        for contact in walls.chain(pairs).chain(bumps) {
            let gap = Self::gap_of(&geometry, contact, &q);
            if gap < closed {
                return Err(Error::Incompatible(format!(
                    "impossible geometry: {contact:?} would start with a gap of {gap:.6} m"
                )));
            }
            if gap < Self::LISTED * geometry.radius {
                contacts.push(contact);
            } else {
                // Both bodies may come closer.
                reach = f64::min(reach, 0.5 * gap);
            }
        }
        for (row, (kind, missing)) in kinds.into_iter().enumerate() {
            let found = contacts.iter().position(kind).ok_or_else(|| {
                let listed = format!("{:.6}", Self::LISTED * geometry.radius);
                Error::Incompatible(format!("impossible geometry: {}", missing.replace("{}", &listed)))
            })?;
            contacts.swap(row, found);
        }
        Ok(Discs { geometry, kind, contacts, reach })
    }

    /// How far blade and discs are from where they started, at most, m.
    fn largest_displacement(&self, q: &[f64]) -> f64 {
        let moved = self.geometry.centres.iter().enumerate();
        let moved = moved.map(|(disc, start)| (Self::centre(q, disc) - Vector2::from(*start)).norm_squared());
        moved.fold(q[0] * q[0], f64::max).sqrt()
    }

    /// Returns the number of possible contacts.
    pub fn contacts(&self) -> usize {
        self.contacts.len()
    }

    /// Returns the displacement of discs and blade up to which the list of contacts is complete, m.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    fn state(geometry: &DiscsGeometry) -> (Vec<f64>, Vec<f64>) {
        let q: Vec<f64> = std::iter::once(0.0).chain(geometry.centres.iter().flatten().copied()).collect();
        let mut v = vec![0.0; q.len()];
        v[0] = geometry.blade_velocity;
        (q, v)
    }

    #[inline]
    fn centre(q: &[f64], disc: usize) -> Vector2<f64> {
        Vector2::new(q[1 + 2 * disc], q[2 + 2 * disc])
    }

    /// The velocities that a contact knows; a pair four, the blade and a bump two, wall and floor one.
    #[inline]
    fn columns(&self, contact: Contact) -> [usize; 4] {
        let (x, y) = (|disc: usize| 1 + 2 * disc, |disc: usize| 2 + 2 * disc);
        match contact {
            Contact::Blade(disc) => [0, x(disc), 0, 0],
            Contact::Wall(disc) => [x(disc), 0, 0, 0],
            Contact::Floor(disc) => [y(disc), 0, 0, 0],
            Contact::Pair(i, j) => [x(i), y(i), x(j), y(j)],
            Contact::Bump(disc, _) => [x(disc), y(disc), 0, 0],
        }
    }

    #[inline]
    fn gap_of(geometry: &DiscsGeometry, contact: Contact, q: &[f64]) -> f64 {
        let radius = geometry.radius;
        match contact {
            Contact::Blade(disc) => Self::centre(q, disc).x - radius - q[0],
            Contact::Wall(disc) => geometry.wall_x - radius - Self::centre(q, disc).x,
            Contact::Floor(disc) => Self::centre(q, disc).y - radius,
            Contact::Pair(i, j) => (Self::centre(q, j) - Self::centre(q, i)).norm() - 2.0 * radius,
            Contact::Bump(disc, bump) => {
                (Self::centre(q, disc) - Vector2::from(geometry.bumps[bump])).norm() - 2.0 * radius
            }
        }
    }
}

impl MechanicalModel for Discs {
    fn size(&self) -> ModelSize {
        let velocities = 1 + 2 * self.geometry.centres.len();
        ModelSize { velocities, unilateral: self.contacts(), interface: 1, constant_mass: true, ..ModelSize::default() }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        Self::state(&self.geometry)
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.fill(self.geometry.disc_mass);
        mass[0] = self.geometry.blade_mass;
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force[0] = 0.0;
        force[1..].as_chunks_mut::<2>().0.fill([0.0, -(self.geometry.disc_mass * self.geometry.gravity)]);
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        for (index, &contact) in self.contacts.iter().enumerate() {
            let known = self.columns(contact);
            let mut set = |slot: usize, value: f64| rows.set(index, slot, known[slot], value);
            match contact {
                Contact::Blade(_) => {
                    set(0, -1.0);
                    set(1, 1.0);
                }
                Contact::Wall(_) => set(0, -1.0),
                Contact::Floor(_) => set(0, 1.0),
                Contact::Pair(i, j) => {
                    let apart =
                        Apart::of(Self::centre(q, j) - Self::centre(q, i), Self::centre(v, j) - Self::centre(v, i));
                    let (x, y) = (apart.normal.x, apart.normal.y);
                    [-x, -y, x, y].into_iter().enumerate().for_each(|(slot, entry)| set(slot, entry));
                    rows.position[index] = apart.distance - 2.0 * self.geometry.radius;
                    rows.convective[index] = apart.convective;
                    continue;
                }
                Contact::Bump(disc, bump) => {
                    let apart = Apart::of(
                        Self::centre(q, disc) - Vector2::from(self.geometry.bumps[bump]),
                        Self::centre(v, disc),
                    );
                    set(0, apart.normal.x);
                    set(1, apart.normal.y);
                    rows.convective[index] = apart.convective;
                    rows.position[index] = apart.distance - 2.0 * self.geometry.radius;
                    continue;
                }
            }
            rows.position[index] = Self::gap_of(&self.geometry, contact, q);
        }
    }

    fn contact_columns(&self) -> Option<Vec<Vec<usize>>> {
        let known = |&contact: &Contact| match contact {
            Contact::Blade(_) | Contact::Bump(..) => self.columns(contact)[..2].to_vec(),
            Contact::Wall(_) | Contact::Floor(_) => self.columns(contact)[..1].to_vec(),
            Contact::Pair(..) => self.columns(contact).to_vec(),
        };
        Some(self.contacts.iter().map(known).collect())
    }

    fn check_contact_list(&self, q: &[f64]) -> Result<(), Failure> {
        match self.kind {
            ContactList::Start if self.largest_displacement(q) > self.reach => {
                Err(Failure::out_of_range("largest_displacement_m", self.largest_displacement(q)))
            }
            _ => Ok(()),
        }
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[0] = 1.0;
        rows.position[0] = self.geometry.actuator_length + q[0];
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let heights: f64 = q[1..].as_chunks::<2>().0.iter().map(|disc| disc[1]).sum();
        self.geometry.disc_mass * self.geometry.gravity * heights
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(
            &["blade_x_m", "disc_momentum_x_kg_m_s", "largest_displacement_m", "gap_lowest_m"],
            &["blade", "wall", "pair"],
        )
    }

    fn observe(&self, q: &[f64], v: &[f64], row: &mut [f64]) {
        let momentum: f64 = v[1..].as_chunks::<2>().0.iter().map(|disc| self.geometry.disc_mass * disc[0]).sum();
        let gaps = self.contacts.iter().map(|&contact| Self::gap_of(&self.geometry, contact, q));
        row.copy_from_slice(&[q[0], momentum, self.largest_displacement(q), gaps.fold(f64::INFINITY, f64::min)]);
    }
}

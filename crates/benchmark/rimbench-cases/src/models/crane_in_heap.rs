//! The hydraulic crane that pulls its load out of a heap of discs: contacts that come and go while discs travel.

use super::crane::CraneGeometry;
use super::crane_with_rope::CraneWithRope;
use super::discs::{Apart, potential_of_weights, weigh};
use super::nearby::{Places, ROUNDING, TravellingContacts};
use nalgebra::Vector2;
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize, Sparsity};

/// The heap around the load of a [`CraneInHeap`].
#[derive(Debug, Clone, PartialEq)]
pub struct HeapGeometry {
    /// R of the discs and of the load, m.
    pub radius: f64,
    /// Of each disc, kg.
    pub disc_mass: f64,
    /// Centres of the discs as seen from the load, m.
    pub centres: Vec<[f64; 2]>,
    /// Distance of the walls from the load on either side, m.
    pub half_width: f64,
    /// How much of the rope hangs loose at the start, m.
    pub slack: f64,
    /// Contacts with a gap below this many radii are listed, at most [`CraneInHeap::LARGEST_REACH`].
    pub list_reach_radii: f64,
}

/// Floor, left and right.
const WALLS: usize = 3;

/// What can touch what: bodies are the load, 0, and the discs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Contact {
    Rope,
    Floor(usize),
    Left(usize),
    Right(usize),
    Pair(usize, usize),
}

/// [`CraneWithRope`], whose load is a disc that lies on the floor of a pit, under and between others. No friction, no
/// spin; the rope passes in front of the discs.
///
/// ```text
/// q = (θ, x_0, y_0, x_1, y_1, …)      M = diag(L²(m_l/3 + m_p), m_h, m_h, m, m, …), m_l: the link, m: a disc
/// g_floor = y_b − R − y_f     g_left = x_b − R − x_l     g_right = x_r − R − x_b     g_ij = |c_j − c_i| − 2R
/// ```
/// and the rope as there. Contacts are listed as discs travel: those that are closer than a given number of radii, and
/// always the rope and the load on the floor. Rows without a contact are as far apart as the list reaches.
/// # Source
/// Ours.
#[derive(Debug, Clone, PartialEq)]
pub struct CraneInHeap {
    crane: CraneWithRope,
    geometry: HeapGeometry,
    load_mass: f64,
    gravity: f64,
    /// Place of the load at the start, m.
    start: [f64; 2],
    contacts: TravellingContacts<Contact>,
}

impl CraneInHeap {
    /// Largest number of radii up to which contacts may be listed: farther than that there may be more of them than
    /// rows.
    pub const LARGEST_REACH: f64 = TravellingContacts::<Contact>::LARGEST_REACH;

    /// Lists the contacts: the rope, the load on the floor, then whatever is near.
    ///
    /// # Errors
    /// Those of the crane; [`Error::InvalidValue`] for a list that reaches farther than there are rows, or nowhere;
    /// [`Error::Incompatible`] if anything would start inside something else.
    pub fn new(crane: CraneGeometry, geometry: HeapGeometry) -> Result<Self> {
        let (listed, most) = (geometry.list_reach_radii, Self::LARGEST_REACH);
        if !(listed > 0.0 && listed <= most) {
            return Err(Error::invalid("list_reach_radii", listed, format!("a number above zero, at most {most}")));
        }
        let (load_mass, gravity) = (crane.end_mass, crane.gravity);
        let crane = CraneWithRope::with_slack_rope(crane, geometry.slack)?;
        let (q, _) = crane.initial_state();
        let bodies = 1 + geometry.centres.len();
        let mut model = CraneInHeap {
            crane,
            load_mass,
            gravity,
            start: [q[1], q[2]],
            contacts: TravellingContacts::new(
                vec![Contact::Rope, Contact::Floor(0)],
                // The load on the floor may be listed although it is far.
                TravellingContacts::<Contact>::most(bodies, WALLS).min(WALLS * bodies - 1 + bodies * (bodies - 1) / 2),
                geometry.list_reach_radii * geometry.radius,
            ),
            geometry,
        };
        let (q, v) = model.initial_state();
        let near = model.near(&q, &v);
        if let Some((gap, contact)) = near.iter().min_by(|a, b| a.0.total_cmp(&b.0))
            && *gap < -ROUNDING * model.geometry.radius
        {
            return Err(Error::Incompatible(format!(
                "impossible geometry: {contact:?} would start with a gap of {gap:.6} m"
            )));
        }
        model.contacts.list(&q[1..], near);
        Ok(model)
    }

    /// Contacts with a gap below the reach of the list, but for the rope, each with its gap (m).
    fn near(&self, q: &[f64], v: &[f64]) -> Vec<(f64, Contact)> {
        let (bodies, reach) = (1 + self.geometry.centres.len(), self.contacts.reach());
        let places = Places::of(&q[1..]);
        let pairs = places.pairs_within(2.0 * self.geometry.radius + reach).map(|(i, j)| Contact::Pair(i, j));
        let walls = (0..bodies).flat_map(|body| [Contact::Floor(body), Contact::Left(body), Contact::Right(body)]);
        let near = walls.chain(pairs).map(|contact| (self.gap(contact, q, v), contact));
        near.filter(|(gap, _)| *gap < reach).collect()
    }

    /// Returns the crane with its rope.
    pub fn crane(&self) -> &CraneWithRope {
        &self.crane
    }

    #[inline]
    fn centre(q: &[f64], body: usize) -> Vector2<f64> {
        Vector2::new(q[1 + 2 * body], q[2 + 2 * body])
    }

    fn gap(&self, contact: Contact, q: &[f64], v: &[f64]) -> f64 {
        let (radius, half) = (self.geometry.radius, self.geometry.half_width);
        match contact {
            Contact::Rope => self.crane.rope_row(&q[..3], &v[..3]).1,
            Contact::Floor(body) => Self::centre(q, body).y - self.start[1],
            Contact::Left(body) => Self::centre(q, body).x - radius - (self.start[0] - half),
            Contact::Right(body) => self.start[0] + half - radius - Self::centre(q, body).x,
            Contact::Pair(i, j) => (Self::centre(q, j) - Self::centre(q, i)).norm() - 2.0 * radius,
        }
    }

    /// The velocities that a contact knows, and how many.
    #[inline]
    fn columns(contact: Contact) -> ([usize; 4], usize) {
        let (x, y) = (|body: usize| 1 + 2 * body, |body: usize| 2 + 2 * body);
        match contact {
            Contact::Rope => ([0, 1, 2, 0], 3),
            Contact::Floor(body) => ([y(body), 0, 0, 0], 1),
            Contact::Left(body) | Contact::Right(body) => ([x(body), 0, 0, 0], 1),
            Contact::Pair(i, j) => ([x(i), y(i), x(j), y(j)], 4),
        }
    }

    /// Height of the discs' centre of mass above the load's place at the start, m; the load's where there are none.
    fn height(&self, q: &[f64]) -> f64 {
        let discs = q[3..].as_chunks::<2>().0;
        let sum: f64 = discs.iter().map(|disc| disc[1] - self.start[1]).sum();
        if discs.is_empty() { q[2] - self.start[1] } else { sum / discs.len() as f64 }
    }
}

impl MechanicalModel for CraneInHeap {
    fn size(&self) -> ModelSize {
        let velocities = 3 + 2 * self.geometry.centres.len();
        ModelSize {
            velocities,
            unilateral: self.contacts.rows().len(),
            interface: 1,
            relists: true,
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let (mut q, _) = self.crane.initial_state();
        q.extend(self.geometry.centres.iter().flat_map(|[x, y]| [self.start[0] + x, self.start[1] + y]));
        let v = vec![0.0; q.len()];
        (q, v)
    }

    fn prepare(&mut self, q: &[f64], v: &[f64]) {
        self.crane.prepare(&q[..3], &v[..3]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.fill(self.geometry.disc_mass);
        mass[..3].copy_from_slice(&[self.crane.link_inertia(), self.load_mass, self.load_mass]);
    }

    fn forces(&self, q: &[f64], v: &[f64], force: &mut [f64]) {
        self.crane.forces(&q[..3], &v[..3], &mut force[..3]);
        weigh(&mut force[3..], self.geometry.disc_mass, self.gravity);
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        for (index, &contact) in self.contacts.rows().iter().enumerate() {
            let Some(contact) = contact else {
                rows.position[index] = self.contacts.reach();
                continue;
            };
            let (known, _) = Self::columns(contact);
            let mut set = |slot: usize, value: f64| rows.set(index, slot, known[slot], value);
            match contact {
                Contact::Rope => {
                    let (row, position, convective) = self.crane.rope_row(&q[..3], &v[..3]);
                    row.into_iter().enumerate().for_each(|(slot, entry)| set(slot, entry));
                    (rows.position[index], rows.convective[index]) = (position, convective);
                    continue;
                }
                Contact::Floor(_) | Contact::Left(_) => set(0, 1.0),
                Contact::Right(_) => set(0, -1.0),
                Contact::Pair(i, j) => {
                    let apart =
                        Apart::of(Self::centre(q, j) - Self::centre(q, i), Self::centre(v, j) - Self::centre(v, i));
                    apart.write_pair(rows, index, known, self.geometry.radius);
                    continue;
                }
            }
            rows.position[index] = self.gap(contact, q, v);
        }
    }

    fn sparsity(&self) -> Sparsity {
        let known = |contact: &Option<Contact>| {
            let known = contact.map(Self::columns);
            known.map_or_else(Vec::new, |(columns, count)| columns[..count].to_vec())
        };
        Sparsity { unilateral: Some(self.contacts.rows().iter().map(known).collect()), ..Sparsity::default() }
    }

    fn remap_contacts(&mut self, q: &[f64], v: &[f64], h: f64) -> Result<bool, Failure> {
        if !self.contacts.is_due(&q[1..], &v[1..], h) {
            return Ok(false);
        }
        let near = self.near(q, v);
        self.contacts.remap_contacts(&q[1..], near, ROUNDING * self.geometry.radius)
    }

    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        self.crane.interface(&q[..3], &v[..3], rows);
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.crane.potential_energy(&q[..3]) + potential_of_weights(&q[3..], self.geometry.disc_mass, self.gravity)
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(
            &["theta_1_rad", "load_x_m", "load_y_m", "heap_height_m", "largest_displacement_m", "gap_lowest_m"],
            &["rope", "floor"],
        )
    }

    fn observe(&self, q: &[f64], v: &[f64], row: &mut [f64]) {
        let bodies = 1 + self.geometry.centres.len();
        let start = |body: usize| {
            let aside = if body == 0 { [0.0; 2] } else { self.geometry.centres[body - 1] };
            Vector2::from(self.start) + Vector2::from(aside)
        };
        let moved = (0..bodies).map(|body| (Self::centre(q, body) - start(body)).norm());
        let gaps = self.contacts.rows().iter().flatten().map(|&contact| self.gap(contact, q, v));
        row.copy_from_slice(&[
            q[0],
            q[1],
            q[2],
            self.height(q),
            moved.fold(0.0, f64::max),
            gaps.fold(f64::INFINITY, f64::min),
        ]);
    }
}

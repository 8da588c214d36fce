//! From Eq. 3 to Eq. 4 where joints involve few velocities each, and the mass is diagonal.

use super::delassus_products::DelassusProducts;
use super::joints::{Groups, Joints};
use super::linearisation::{Linearisation, MassMatrix, Rows};
use super::reduced_interface_model::ReducedInterfaceModel;
use crate::error::Failure;
use rimbench_contact::linear_algebra::SymmetricPattern;
use std::ops::Range;

/// Contacts keep what is coupled if that is at most one entry of so many.
const ENTRIES_PER_MEETING: usize = 4;

/// Eliminates velocities and joints row by row: what one row does goes no farther than the joints that it reaches.
///
/// ```text
/// S    = A_b M⁻¹ A_bᵀ = L D Lᵀ, sparse
/// g_x  = G A_xᵀ = y − M⁻¹ A_bᵀ S⁻¹ A_b y          y = M⁻¹ A_xᵀ; only of the groups of joints that y moves
/// H_xz = A_z g_x                                  x, z ∈ {u, t, i}
/// ```
/// No `g_x` is kept: after a step all impulses together take one more solve. Two contacts are coupled that share a
/// velocity or reach one group. Where that leaves few of many, a group of any size costs what it has; where all
/// contacts reach one group, `H_uu` is full, and n_u solves are what it takes.
#[derive(Debug, Clone)]
pub(super) struct JointedElimination {
    joints: Joints,
    inverse_mass: Vec<f64>,
    rows: CsrRows,
    /// Where few of many contacts are coupled: of each contact the others before it, where their entry stands and where
    /// its mirror image.
    products: Option<(Vec<usize>, Vec<[u32; 3]>)>,
    /// `S⁻¹ (A_b v + γ g_b / h)` and `S⁻¹ (A_b M⁻¹ f + Ȧ_b v)`.
    joint_start: Vec<f64>,
    joint_free: Vec<f64>,
    /// One `g_x`, zero between calls; the groups that it reaches.
    g: Vec<f64>,
    reached: Vec<bool>,
    list: Vec<u32>,
}

impl JointedElimination {
    /// Returns which contacts are coupled, if those are few of many.
    pub(super) fn delassus_pattern(contacts: &Rows, joints: &Rows, velocities: usize) -> Option<SymmetricPattern> {
        let (starts, columns) = contacts.columns_by_row()?;
        let groups = Groups::of(joints, velocities)?;
        let places = groups.count() + velocities;
        // How many contacts come to each place, and the last of them.
        let mut knowing = vec![(0_usize, usize::MAX); places];
        for (contact, bounds) in starts.windows(2).enumerate() {
            for &column in &columns[bounds[0]..bounds[1]] {
                let (count, last) = &mut knowing[groups.position_of(column as usize)];
                *count += usize::from(std::mem::replace(last, contact) != contact);
            }
        }
        // An upper bound of its entries, before that much memory is taken.
        let most: usize = knowing.iter().map(|(count, _)| count * count).sum();
        if most > contacts.len() * contacts.len() / ENTRIES_PER_MEETING {
            return None;
        }
        Some(DelassusProducts::pattern(starts, columns, places, |column| groups.position_of(column)))
    }

    /// Makes room; none if the joints keep all their entries.
    pub(super) fn new(eq3: &Linearisation, pattern: Option<&SymmetricPattern>) -> Option<Self> {
        let n = eq3.velocities();
        let joints = Joints::new(&eq3.bilateral, n)?;
        let products = pattern.map(|pattern| {
            let (mut starts, mut entries) = (vec![0], Vec::new());
            for row in 0..pattern.size() {
                for &column in pattern.columns(row).iter().filter(|&&column| column as usize <= row) {
                    let at = |row, column| {
                        pattern.position(row, column).expect("an entry of the pattern and its mirror") as u32
                    };
                    entries.push([column, at(row, column as usize), at(column as usize, row)]);
                }
                starts.push(entries.len());
            }
            (starts, entries)
        });
        let groups = joints.groups.count();
        Some(JointedElimination {
            inverse_mass: vec![0.0; n],
            rows: CsrRows::with_room_for([&eq3.unilateral, &eq3.tangential, &eq3.interface], n),
            products,
            joint_start: vec![0.0; eq3.bilateral.len()],
            joint_free: vec![0.0; eq3.bilateral.len()],
            g: vec![0.0; n],
            reached: vec![false; groups],
            list: Vec::with_capacity(groups),
            joints,
        })
    }

    /// Fills everything of `model` that depends on the state, `start` with `v̂` and `free` with `α`.
    pub(super) fn reduce(
        &mut self,
        eq3: &Linearisation,
        v: &[f64],
        [h, stabilisation]: [f64; 2],
        [start, free]: [&mut [f64]; 2],
        model: &mut ReducedInterfaceModel,
    ) -> Result<(), Failure> {
        if let MassMatrix::Diagonal(mass) = &eq3.mass {
            self.inverse_mass.iter_mut().zip(mass).for_each(|(inverse, mass)| *inverse = 1.0 / mass);
        }
        self.joints.factorise(&eq3.bilateral, &self.inverse_mass)?;
        start.copy_from_slice(v);
        self.joints.project_all(start, |joint| stabilisation * eq3.bilateral.position[joint] / h);
        self.joint_start.copy_from_slice(&self.joints.impulses);
        for (free, (force, inverse)) in free.iter_mut().zip(eq3.force.iter().zip(&self.inverse_mass)) {
            *free = force * inverse;
        }
        self.joints.project_all(free, |joint| eq3.bilateral.convective[joint]);
        self.joint_free.copy_from_slice(&self.joints.impulses);

        self.rows.clear();
        let mut row = 0;
        for rows in [&eq3.unilateral, &eq3.tangential, &eq3.interface] {
            self.rows.read(rows, &self.inverse_mass);
            for convective in &rows.convective {
                model.w[row] = self.rows.along(row, start);
                model.a[row] = self.rows.along(row, free) + convective;
                row += 1;
            }
        }
        for row in 0..row {
            self.response(row);
            self.write(row, model);
            self.forget(row);
        }
        Ok(())
    }

    /// Computes `g_x` of one row.
    fn response(&mut self, row: usize) {
        for entry in self.rows.entries(row) {
            let column = self.rows.columns[entry] as usize;
            self.g[column] = self.rows.scaled[entry];
            if let Some(group) = self.joints.groups.of_velocity(column)
                && !std::mem::replace(&mut self.reached[group], true)
            {
                self.list.push(group as u32);
            }
        }
        for &group in &self.list {
            self.joints.project(group as usize, &mut self.g, |_| 0.0);
        }
    }

    /// Makes it zero again.
    fn forget(&mut self, row: usize) {
        for &group in &self.list {
            self.reached[group as usize] = false;
            self.joints.clear(group as usize, &mut self.g);
        }
        self.list.clear();
        self.rows.columns[self.rows.entries(row)].iter().for_each(|&column| self.g[column as usize] = 0.0);
    }

    /// Writes what the row has of `H` with itself and those before it, and its mirror image.
    fn write(&self, row: usize, model: &mut ReducedInterfaceModel) {
        let Some((starts, products)) = &self.products else {
            let n = model.a.len();
            for column in 0..=row {
                let entry = self.rows.along(column, &self.g);
                (model.h[row * n + column], model.h[column * n + row]) = (entry, entry);
            }
            return;
        };
        let (n_u, n_i) = (model.contacts(), model.interface());
        if row < n_u {
            for &[column, at, mirrored] in &products[starts[row]..starts[row + 1]] {
                let entry = self.rows.along(column as usize, &self.g);
                (model.h[at as usize], model.h[mirrored as usize]) = (entry, entry);
            }
            return;
        }
        // Columns of all rows, one for each of the interface.
        let (first, length) = (model.h.len() - (n_u + n_i) * n_i, n_u + n_i);
        for column in 0..=row {
            let entry = self.rows.along(column, &self.g);
            model.h[first + (row - n_u) * length + column] = entry;
            if column >= n_u {
                model.h[first + (column - n_u) * length + row] = entry;
            }
        }
    }

    /// Computes what the stacked impulses do, `G A_xᵀ P`, with those of the joints.
    fn push(&mut self, impulses: &[f64]) {
        for (row, &impulse) in impulses.iter().enumerate() {
            if impulse != 0.0 {
                for entry in self.rows.entries(row) {
                    self.g[self.rows.columns[entry] as usize] += impulse * self.rows.scaled[entry];
                }
            }
        }
        self.joints.project_all(&mut self.g, |_| 0.0);
    }

    /// Adds what the stacked impulses do to `v`.
    pub(super) fn add_impulses(&mut self, impulses: &[f64], v: &mut [f64]) {
        self.push(impulses);
        v.iter_mut().zip(&mut self.g).for_each(|(v, g)| *v += std::mem::take(g));
    }

    /// Writes `P_b` of a step `h`.
    pub(super) fn bilateral_impulses(&mut self, h: f64, impulses: &[f64], p_b: &mut [f64]) {
        self.push(impulses);
        self.g.fill(0.0);
        let of_state = self.joint_start.iter().zip(&self.joint_free).map(|(start, free)| start + h * free);
        for (out, (of_state, pushed)) in p_b.iter_mut().zip(of_state.zip(&self.joints.impulses)) {
            *out = -(of_state + pushed);
        }
    }
}

/// Rows with their entries that are not zero, `A_x` and `A_x M⁻¹`.
#[derive(Debug, Clone)]
struct CsrRows {
    starts: Vec<usize>,
    columns: Vec<u32>,
    a: Vec<f64>,
    scaled: Vec<f64>,
}

impl CsrRows {
    fn with_room_for(blocks: [&Rows; 3], velocities: usize) -> Self {
        let rows = blocks.iter().map(|rows| rows.len()).sum::<usize>();
        let of_block =
            |rows: &&Rows| rows.columns_by_row().map_or(rows.len() * velocities, |(_, columns)| columns.len());
        let most = blocks.iter().map(of_block).sum();
        CsrRows {
            starts: Vec::with_capacity(rows + 1),
            columns: Vec::with_capacity(most),
            a: Vec::with_capacity(most),
            scaled: Vec::with_capacity(most),
        }
    }

    fn clear(&mut self) {
        self.starts.clear();
        self.starts.push(0);
        self.columns.clear();
        self.a.clear();
        self.scaled.clear();
    }

    fn push(&mut self, column: u32, a: f64, inverse_mass: &[f64]) {
        self.columns.push(column);
        self.a.push(a);
        self.scaled.push(a * inverse_mass[column as usize]);
    }

    /// Appends a block.
    fn read(&mut self, rows: &Rows, inverse_mass: &[f64]) {
        for row in 0..rows.len() {
            match rows.columns_by_row() {
                Some((starts, columns)) => {
                    let entries = starts[row]..starts[row + 1];
                    for (&a, &column) in rows.jacobian[entries.clone()].iter().zip(&columns[entries]) {
                        self.push(column, a, inverse_mass);
                    }
                }
                None => {
                    for (column, &a) in rows.row(row).iter().enumerate() {
                        // NaN is not zero.
                        if a != 0.0 {
                            self.push(column as u32, a, inverse_mass);
                        }
                    }
                }
            }
            self.starts.push(self.columns.len());
        }
    }

    fn entries(&self, row: usize) -> Range<usize> {
        self.starts[row]..self.starts[row + 1]
    }

    /// `A_x x` of one row.
    fn along(&self, row: usize, x: &[f64]) -> f64 {
        let entries = self.entries(row);
        let known = self.a[entries.clone()].iter().zip(&self.columns[entries]);
        known.map(|(a, &column)| a * x[column as usize]).sum()
    }
}

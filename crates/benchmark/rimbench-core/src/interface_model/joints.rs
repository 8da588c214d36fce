//! Joints by the dozen that involve few velocities each: their impulses by a sparse factor, group by group.

use super::delassus_products::DelassusProducts;
use super::linearisation::Rows;
use rimbench_contact::linear_algebra::{DEPENDENT, Singular, SparseFactor, SymmetricPattern, SymmetricRows};
use std::ops::Range;

/// Groups of joints: two that share a velocity are in one.
#[derive(Debug, Clone)]
pub(super) struct Groups {
    /// Group of each velocity that a joint involves.
    of_velocity: Vec<Option<u32>>,
    count: usize,
}

impl Groups {
    /// Finds them; none if the rows keep all their entries.
    pub(super) fn of(joints: &Rows, velocities: usize) -> Option<Self> {
        let (starts, columns) = joints.columns_by_row()?;
        // Each velocity points to another of its group, the first of all to itself.
        let mut towards: Vec<usize> = (0..velocities).collect();
        fn first(towards: &mut [usize], mut at: usize) -> usize {
            while towards[at] != at {
                towards[at] = towards[towards[at]];
                at = towards[at];
            }
            at
        }
        let mut jointed = vec![false; velocities];
        for bounds in starts.windows(2) {
            let known = &columns[bounds[0]..bounds[1]];
            for &column in known {
                jointed[column as usize] = true;
                let (a, b) = (first(&mut towards, known[0] as usize), first(&mut towards, column as usize));
                towards[a.max(b)] = a.min(b);
            }
        }
        let (mut of_velocity, mut count) = (vec![None; velocities], 0);
        for velocity in (0..velocities).filter(|&velocity| jointed[velocity]) {
            let first = first(&mut towards, velocity);
            if first == velocity {
                of_velocity[velocity] = Some(count as u32);
                count += 1;
            } else {
                of_velocity[velocity] = of_velocity[first];
            }
        }
        Some(Groups { of_velocity, count })
    }

    /// Returns how many there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Returns the group of a velocity, if a joint involves it.
    #[inline]
    pub(super) fn of_velocity(&self, velocity: usize) -> Option<usize> {
        self.of_velocity[velocity].map(|group| group as usize)
    }

    /// Returns where rows are coupled: by a group, or by a velocity that no joint involves.
    pub(super) fn position_of(&self, velocity: usize) -> usize {
        self.of_velocity(velocity).unwrap_or(self.count + velocity)
    }
}

/// The joints at one state.
///
/// ```text
/// S = A_b M⁻¹ A_bᵀ = P L D Lᵀ Pᵀ          sparse, in an order that keeps L so; block by block, one for each group
/// ```
/// A chain of joints takes as long as it has members.
#[derive(Debug, Clone)]
pub(super) struct Joints {
    pub(super) groups: Groups,
    /// Where the rows of `A_b` start, and the columns of their entries.
    starts: Vec<usize>,
    columns: Vec<u32>,
    /// `A_b` and `A_b M⁻¹`.
    a: Vec<f64>,
    scaled: Vec<f64>,
    pattern: SymmetricPattern,
    products: DelassusProducts,
    s: Vec<f64>,
    factor: SparseFactor,
    /// Joints by groups, in the order of elimination, and where each group starts.
    members: Vec<u32>,
    group_starts: Vec<usize>,
    /// Impulses of the last that were [held](Self::hold).
    pub(super) impulses: Vec<f64>,
}

impl Joints {
    /// Finds groups and order of elimination; none if the rows keep all their entries.
    pub(super) fn new(joints: &Rows, velocities: usize) -> Option<Self> {
        let (starts, columns) = joints.columns_by_row()?;
        let groups = Groups::of(joints, velocities)?;
        let pattern = DelassusProducts::pattern(starts, columns, velocities, |column| column);
        let mut of_group = vec![Vec::new(); groups.count()];
        // A row without entries belongs to none; its pivot is 0, which the factor refuses.
        for (joint, bounds) in starts.windows(2).enumerate() {
            if let Some(group) = columns[bounds[0]..bounds[1]].first().and_then(|&c| groups.of_velocity(c as usize)) {
                of_group[group].push(joint as u32);
            }
        }
        let (mut members, mut group_starts) = (Vec::with_capacity(joints.len()), vec![0]);
        for mut joints in of_group {
            pattern.elimination_order().sort(&mut joints);
            members.extend(joints);
            group_starts.push(members.len());
        }
        Some(Joints {
            groups,
            a: vec![0.0; columns.len()],
            scaled: vec![0.0; columns.len()],
            products: DelassusProducts::new(starts, columns, &pattern),
            s: vec![0.0; pattern.entries()],
            factor: SparseFactor::new(&pattern),
            pattern,
            members,
            group_starts,
            impulses: vec![0.0; joints.len()],
            starts: starts.to_vec(),
            columns: columns.to_vec(),
        })
    }

    /// Factorises `S`.
    ///
    /// # Errors
    /// [`Singular`] if joints are dependent.
    pub(super) fn factorise(&mut self, rows: &Rows, inverse_mass: &[f64]) -> Result<(), Singular> {
        self.a.copy_from_slice(&rows.jacobian);
        for ((scaled, a), &column) in self.scaled.iter_mut().zip(&self.a).zip(&self.columns) {
            *scaled = a * inverse_mass[column as usize];
        }
        self.products.fill(&self.a, &self.scaled, &mut self.s);
        let s = SymmetricRows { pattern: &self.pattern, entries: &self.s };
        let independent = self.factor.factorise(s, 0.0, DEPENDENT, |_| true);
        if independent == self.impulses.len() { Ok(()) } else { Err(Singular { matrix: "A_b M⁻¹ A_bᵀ" }) }
    }

    fn entries(&self, joint: usize) -> Range<usize> {
        self.starts[joint]..self.starts[joint + 1]
    }

    /// Takes from the velocities `x` what the joints of one group do not let through, and says by what impulses.
    ///
    /// ```text
    /// p = S⁻¹ (A_b x + e)          x − M⁻¹ A_bᵀ p
    /// ```
    pub(super) fn project(&mut self, group: usize, x: &mut [f64], e: impl Fn(usize) -> f64) {
        let members = self.group_starts[group]..self.group_starts[group + 1];
        for &joint in &self.members[members.clone()] {
            let (joint, entries) = (joint as usize, self.entries(joint as usize));
            let known = self.a[entries.clone()].iter().zip(&self.columns[entries]);
            self.impulses[joint] = e(joint) + known.map(|(a, &column)| a * x[column as usize]).sum::<f64>();
        }
        self.factor.solve_among(&self.members[members.clone()], &mut self.impulses);
        for &joint in &self.members[members] {
            let (impulse, entries) = (self.impulses[joint as usize], self.entries(joint as usize));
            for (scaled, &column) in self.scaled[entries.clone()].iter().zip(&self.columns[entries]) {
                x[column as usize] -= impulse * scaled;
            }
        }
    }

    /// Projects on the joints of all groups.
    pub(super) fn project_all(&mut self, x: &mut [f64], e: impl Fn(usize) -> f64) {
        (0..self.groups.count()).for_each(|group| self.project(group, x, &e));
    }

    /// Sets the velocities of a group to zero.
    pub(super) fn clear(&self, group: usize, x: &mut [f64]) {
        for &joint in &self.members[self.group_starts[group]..self.group_starts[group + 1]] {
            self.columns[self.entries(joint as usize)].iter().for_each(|&column| x[column as usize] = 0.0);
        }
    }
}

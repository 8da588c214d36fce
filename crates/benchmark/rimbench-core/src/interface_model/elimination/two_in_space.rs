//! Two bodies in space with a joint, and six contacts with friction or as many other rows: all sizes are known.
//!
//! The rows of `G A_xᵀ` are kept by columns as well, so that a row is multiplied with several of those before it at
//! once.

use super::Elimination;
use crate::error::Failure;
use crate::interface_model::{Linearisation, ReducedInterfaceModel};

const BODY: usize = 6;
const VELOCITIES: usize = 2 * BODY;
const JOINTS: usize = 3;
const ROWS: usize = 19;
/// Velocities, joint rows and others of such a system.
pub(super) const SIZES: (usize, usize, usize) = (VELOCITIES, JOINTS, ROWS);
/// Rows that are taken at once, and how often.
const LANES: usize = 4;
const GROUPS: usize = ROWS.div_ceil(LANES);

/// One number for each velocity.
type Velocities = [f64; VELOCITIES];

impl Elimination {
    /// Does what [`reduce_in_blocks`](Self::reduce_in_blocks) does in blocks of 3, to the same bits.
    pub(super) fn reduce_two_in_space(
        &mut self,
        eq3: &Linearisation,
        v: &[f64],
        [h, stabilisation]: [f64; 2],
        model: &mut ReducedInterfaceModel,
    ) -> Result<(), Failure> {
        let known = |entries: &[f64]| Velocities::try_from(entries).expect("of all velocities");
        let inverse_mass = known(&self.inverse_mass);
        let y = self.eliminate_joint(&inverse_mass, eq3, known(v), [h, stabilisation])?;

        // What every row is multiplied with, and a column to make them even.
        let [start, free] = [&self.start_velocity, &self.free_acceleration].map(|state| known(state));
        let state: [[f64; 6]; VELOCITIES] =
            std::array::from_fn(|l| [start[l], free[l], y[0][l], y[1][l], y[2][l], 0.0]);
        let (contacts, first) = (model.contacts(), model.interface_start());
        let [normal, tangential, interface] = [&eq3.unilateral, &eq3.tangential, &eq3.interface]
            .map(|rows| (rows.jacobian.as_chunks::<VELOCITIES>().0, &rows.convective[..]));
        let row_of = |row: usize| match row {
            row if row < contacts => (&normal.0[row], normal.1[row]),
            row if row < first => (&tangential.0[row - contacts], tangential.1[row - contacts]),
            row => (&interface.0[row - first], interface.1[row - first]),
        };
        let [model_w, model_a] = [&mut model.w, &mut model.a].map(|of_rows| &mut of_rows[..ROWS]);
        let model_h = &mut model.h.as_chunks_mut::<ROWS>().0[..ROWS];
        let coupling = &mut self.coupling.as_chunks_mut::<ROWS>().0[..JOINTS];
        let g_rows = &mut self.g_rows.as_chunks_mut::<VELOCITIES>().0[..ROWS];
        let mut columns = [[[0.0; LANES]; GROUPS]; VELOCITIES];
        for group in 0..GROUPS {
            let here = group * LANES..ROWS.min((group + 1) * LANES);
            let mut occupied = [[false; 2]; LANES];
            for (row, lane) in here.clone().zip(0..LANES) {
                let (a, convective) = row_of(row);
                let mut sums = [0.0; 6];
                for (body, occupied) in occupied[lane].iter_mut().enumerate() {
                    *occupied = a.as_chunks::<BODY>().0[body].iter().any(|&entry| entry != 0.0);
                    if *occupied {
                        add_products(&mut sums, body, a, |l| &state[l]);
                    }
                }
                let [w, acceleration, c @ .., _] = sums;
                (model_w[row], model_a[row]) = (w, acceleration + convective);
                let mut g: Velocities = std::array::from_fn(|l| a[l] * inverse_mass[l]);
                for b in 0..JOINTS {
                    add_multiple(&mut g, -c[b], &y[b]);
                    coupling[b][row] = c[b];
                }
                g_rows[row] = g;
            }
            // As a whole: to read together what was just written one by one would wait for it. What is beyond the last row
            // is not used.
            let of_group: [&Velocities; LANES] = std::array::from_fn(|lane| &g_rows[(here.start + lane).min(ROWS - 1)]);
            for l in 0..VELOCITIES {
                columns[l][group] = of_group.map(|g| g[l]);
            }
            for (row, occupied) in here.zip(occupied) {
                let (a, out) = (row_of(row).0, &mut model_h[row]);
                match occupied {
                    [true, true] => write_products::<0, 1>(a, &columns, group, out),
                    [false, true] => write_products::<1, 1>(a, &columns, group, out),
                    [_, false] => write_products::<0, 0>(a, &columns, group, out),
                }
            }
        }
        // Only one triangle is computed, so that H is symmetric to the bit.
        for row in (1..ROWS).step_by(2) {
            let (above, below) = model_h.split_at_mut(row);
            for (column, above) in above.iter_mut().enumerate() {
                (above[row], above[row + 1]) = (below[0][column], below[1][column]);
            }
            below[0][row + 1] = below[1][row];
        }
        Ok(())
    }

    /// Writes `L`, `s`, `r`, `v̂` and `α`; returns `Y`.
    #[inline(always)]
    fn eliminate_joint(
        &mut self,
        inverse_mass: &Velocities,
        eq3: &Linearisation,
        mut start: Velocities,
        [h, gamma]: [f64; 2],
    ) -> Result<[Velocities; JOINTS], Failure> {
        let force = &eq3.force[..VELOCITIES];
        let mut free: Velocities = std::array::from_fn(|l| force[l] * inverse_mass[l]);
        let a_b: [Velocities; JOINTS] = std::array::from_fn(|b| eq3.bilateral.jacobian.as_chunks().0[b]);
        let mut y = a_b.map(|a_b| -> Velocities { std::array::from_fn(|l| a_b[l] * inverse_mass[l]) });
        let state: [[f64; 2]; VELOCITIES] = std::array::from_fn(|l| [start[l], free[l]]);
        let columns: [[f64; 4]; VELOCITIES] = std::array::from_fn(|l| [a_b[0][l], a_b[1][l], a_b[2][l], 0.0]);
        let (s, r) = (&mut self.joint_start[..JOINTS], &mut self.joint_free[..JOINTS]);
        let schur = &mut self.schur;
        for b in 0..JOINTS {
            let ([mut of_state], mut of_joints) = ([[0.0; 2]], [0.0; 4]);
            for body in 0..2 {
                add_products(&mut of_state, body, &a_b[b], |l| &state[l]);
                add_products(&mut of_joints, body, &y[b], |l| &columns[l]);
            }
            schur.l[b * JOINTS..].iter_mut().zip(&of_joints[..=b]).for_each(|(l, entry)| *l = *entry);
            s[b] = of_state[0] + gamma * eq3.bilateral.position[b] / h;
            r[b] = of_state[1] + eq3.bilateral.convective[b];
        }
        schur.factor("A_b M⁻¹ A_bᵀ")?;
        schur.forward(s);
        schur.forward(r);
        for b in 0..JOINTS {
            let l = &schur.l[b * JOINTS..][..JOINTS];
            for c in 0..b {
                let above = y[c];
                add_multiple(&mut y[b], -l[c], &above);
            }
            let scale = 1.0 / l[b];
            y[b] = y[b].map(|y| y * scale);
            add_multiple(&mut start, -s[b], &y[b]);
            add_multiple(&mut free, -r[b], &y[b]);
        }
        self.start_velocity.copy_from_slice(&start);
        self.free_acceleration.copy_from_slice(&free);
        Ok(y)
    }
}

/// Writes the products of a row, with entries of so many bodies, with the rows up to those of a group.
#[inline(always)]
fn write_products<const FIRST: usize, const LAST: usize>(
    a: &Velocities,
    columns: &[[[f64; LANES]; GROUPS]; VELOCITIES],
    group: usize,
    out: &mut [f64; ROWS],
) {
    let of_group = |at: usize| {
        let mut sums = [0.0; LANES];
        for body in FIRST..=LAST {
            add_products(&mut sums, body, a, |l| &columns[l][at]);
        }
        sums
    };
    let (whole, last) = out.as_chunks_mut::<LANES>();
    for (at, entries) in whole.iter_mut().enumerate().take(group + 1) {
        *entries = of_group(at);
    }
    if group == whole.len() {
        last.copy_from_slice(&of_group(group)[..ROWS % LANES]);
    }
}

/// Adds to each sum the product of the entries of one body with a column, in the order of [`dot`](super::dot) for
/// blocks of 3. Zeros that it begins its halves with are left out, and those of a body that is not in a row may be
/// added: no sum here is −0, to which they would matter.
#[inline(always)]
fn add_products<'a, const W: usize>(
    sums: &mut [f64; W],
    body: usize,
    row: &Velocities,
    column: impl Fn(usize) -> &'a [f64; W],
) {
    for first in [BODY * body, BODY * body + 3] {
        let ([a_0, a_1, a_2], [x, y, z]) = ([0, 1, 2].map(|l| row[first + l]), [0, 1, 2].map(|l| column(first + l)));
        for lane in 0..W {
            sums[lane] += (a_0 * x[lane] + a_2 * z[lane]) + a_1 * y[lane];
        }
    }
}

#[inline(always)]
fn add_multiple(target: &mut Velocities, factor: f64, x: &Velocities) {
    target.iter_mut().zip(x).for_each(|(target, x)| *target += factor * x);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface_model::{MassMatrix, Rows};

    #[test]
    fn sizes_known_give_the_same_bits_as_blocks() {
        let mut count = 0.0;
        let mut anyhow = || {
            count += 1.0;
            libm::sin(12.9898 * count + 78.233 * (count * count % 97.0))
        };
        for turn in 0..50 {
            let mut rows = |count: usize, of_body: &dyn Fn(usize, usize) -> bool| {
                let mut rows = Rows::zeros(count, VELOCITIES);
                for (at, entry) in rows.jacobian.iter_mut().enumerate() {
                    // Zeros of both signs within a body as well.
                    let known = of_body(at / VELOCITIES, at % VELOCITIES / BODY) && anyhow() > -0.4;
                    *entry = if known { anyhow() } else { 0.0_f64.copysign(anyhow()) };
                }
                rows.convective.iter_mut().chain(&mut rows.position).for_each(|entry| *entry = anyhow());
                rows
            };
            let mut joints = rows(JOINTS, &|_, _| true);
            (0..JOINTS).for_each(|row| joints.jacobian[row * VELOCITIES + row] = 2.0 + row as f64);
            // Rows of one body, of the other, of both and of none.
            let unilateral = rows(6, &|row, body| row / 4 == body);
            let tangential = rows(12, &|row, body| row % 4 == body || row % 4 == 2);
            let interface = rows(1, &|_, body| turn % 2 == body);
            let mass = (0..VELOCITIES).map(|_| 1.5 + anyhow()).collect();
            let [force, v] = [(); 2].map(|()| (0..VELOCITIES).map(|_| anyhow()).collect::<Vec<_>>());
            let mass = MassMatrix::Diagonal(mass);
            let eq3 = Linearisation { mass, force, bilateral: joints, unilateral, tangential, interface };
            let build = || (Elimination::new(&eq3), ReducedInterfaceModel::zeros_in_space(&[0.3; 6], 1));
            let [(mut known, mut of_known), (mut blocks, mut of_blocks)] = [build(), build()];
            known.reduce(&eq3, &v, 1e-3, 0.2, &mut of_known).unwrap();
            blocks.invert_mass(&eq3.mass).unwrap();
            blocks.reduce_in_blocks::<3>([4, JOINTS, ROWS], false, &eq3, &v, [1e-3, 0.2], &mut of_blocks).unwrap();
            let bits = |elimination: &Elimination, model: &ReducedInterfaceModel| -> Vec<u64> {
                let Elimination { start_velocity, free_acceleration, g_rows, coupling, .. } = elimination;
                let all = [&model.h, &model.w, &model.a, start_velocity, free_acceleration, g_rows, coupling];
                all.into_iter().flatten().map(|entry| entry.to_bits()).collect()
            };
            assert!(of_known.h.iter().any(|entry| *entry != 0.0));
            assert_eq!(bits(&known, &of_known), bits(&blocks, &of_blocks), "turn {turn}");
        }
    }
}

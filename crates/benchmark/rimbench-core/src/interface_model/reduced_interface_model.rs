//! The reduced interface model of paper Eq. 4, as plain data.

use super::contact_modes::ContactModes;
use nalgebra::{DMatrix, SymmetricEigen};
use rimbench_contact::affine_step::LinearModel;
use rimbench_contact::contact_law::{ContactSpring, gap_velocity};
use rimbench_contact::friction::{ContactState, Stiction};
use rimbench_contact::linear_algebra::{SymmetricPattern, SymmetricRows};
use std::sync::Arc;

/// A contact that starts with a gap up to this counts as closed before the first step: positions of a metre are rounded
/// to 1e-16 m, and start poses are computed to a few of those. m.
pub const TOUCHING: f64 = 1e-9;

/// A mechanical system condensed to its contacts and its interface, frozen at one communication point.
///
/// ```text
/// w_u⁺ = w_u + δ a_u + H_uu P_u + H_ui δ λ_i        0 ≤ w_u⁺ + gap term ⟂ P_u ≥ 0
/// w_i⁺ = w_i + δ a_i + H_iu P_u + H_ii δ λ_i
/// ```
/// # Shapes and units
/// The rows of `u` and `i` are stacked, contacts first: `h` is `(n_u+n_i)²` (1/kg), `a` (m/s²) and `w` (m/s) have
/// length `n_u+n_i`; `gap` n_u (m); `position` n_i (m). With friction the tangential rows stand between the two,
/// `[n; t; i]`, as many as contacts, in space `[n; t1; t2; i]`, twice as many: see
/// [`interface_start`](Self::interface_start).
/// # Source
/// Raoofian, Kövecses, Teichmann, Eq. 4.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedInterfaceModel {
    contacts: usize,
    interface: usize,
    /// Rows of contacts, tangential ones among them.
    contact_rows: usize,
    /// All rows of `h`, where it is dense.
    rows: usize,
    /// Counts how often rows have come to stand for other contacts.
    listing: u64,
    /// The non-zeros of `H_uu`, where it is sparse.
    delassus_pattern: Option<Arc<SymmetricPattern>>,
    /// `H = [H_uu H_ui; H_iu H_ii]`, row-major. Where `H_uu` is sparse, its non-zeros, then `H_ui` column by column,
    /// then `H_ii`: see [`entry`](Self::entry).
    pub h: Vec<f64>,
    /// Free accelerations `[a_u; a_i]`.
    pub a: Vec<f64>,
    /// Velocities `[w_u; w_i]`, consistent with the bilateral constraints.
    pub w: Vec<f64>,
    /// Gaps of the contacts; negative means penetration.
    pub gap: Vec<f64>,
    /// Interface coordinates, for example the actuator's length.
    pub position: Vec<f64>,
    /// Contacts whose row was at its bound in the mechanics' last step, loaded or not; before the first step, those
    /// with `gap ≤` [`TOUCHING`].
    pub at_bound: Vec<bool>,
    /// Fraction γ of a penetration that the mechanics removes in one of its own steps.
    pub stabilisation: f64,
    /// Restitution e of contacts that close.
    pub restitution: f64,
    /// Which contacts are plastic whatever the restitution of the others; empty where none is.
    pub plastic: Vec<bool>,
    /// Approach w₀ of each contact caused by the mechanics' discretisation, m/s; empty where nothing rebounds, or where
    /// it is not known. See [`discretisation_approach`](rimbench_contact::contact_law::discretisation_approach).
    pub discretisation_approach: Vec<f64>,
    /// The mechanics' own step, s.
    pub mechanics_step: f64,
    /// Spring and damper of compliant contacts; none where they are rigid.
    pub spring: Option<ContactSpring>,
    /// Coefficient of friction of each contact in the step that starts here; empty where there is no friction.
    pub friction: Vec<f64>,
    /// The coefficients at rest and in motion, where they differ: `friction` then is what the last step has left of
    /// them.
    pub stiction: Option<Stiction>,
    /// State of each contact in the mechanics' last step: open, or, at its bound, stick or slip; empty without
    /// friction.
    pub states: Vec<ContactState>,
    /// States from which the mechanics' next contact problem starts, as its solver found them in the last. They differ
    /// from `states` for a contact that is closed without an impulse. Of several solutions a solver that starts here
    /// reaches that one; empty without friction.
    pub solved_states: Vec<ContactState>,
    /// Direction in which each contact slid in the mechanics' last step, of length 1, in its two tangential rows; empty
    /// in the plane.
    pub directions: Vec<[f64; 2]>,
    /// Forces of all contact rows in the mechanics' last step, N, from which contact problems in space start; empty in
    /// the plane.
    pub solved_forces: Vec<f64>,
    /// Restitution along the surface of contacts that close.
    pub tangential_restitution: f64,
    /// Whether it has contacts without listing them: those that push are in `h` and `a`, which hold as long as none
    /// opens or closes. Only schemes whose contacts are bilateral can use it.
    pub smooth: bool,
    /// Whether contacts answer to forces of the interface otherwise than the interface to those of contacts,
    /// `H_ui ≠ H_iuᵀ`: so does an engine that takes damping implicitly after it has solved its contacts. `H_uu` is
    /// symmetric all the same.
    pub unsymmetric: bool,
    /// Whether `H_ii` may change from sample to sample, so that a scheme which keeps it asks again.
    pub inertia_varies: bool,
    /// Steps of its own, of `mechanics_step` each, that the mechanics takes in one that it is asked for.
    pub own_steps: usize,
    /// The targets of all contacts, where they are rows of an engine; see [`RowTarget`].
    pub targets: Vec<RowTarget>,
    /// Whether they are, and may be fewer than those that the model was made for.
    pub has_targets: bool,
}

/// The target of a row of an engine's constraint solver, which gives way: the row pushes by `f = P/h` as far as its
/// acceleration stays behind a reference that is taken anew at each of the engine's steps.
///
/// ```text
/// 0 ≤ ẇ − ẇ_ref + R f ⟂ f ≥ 0       ẇ_ref = −b w − k g       ⇔       0 ≤ w⁺ − (1 − h b) w + h k g + R P ⟂ P ≥ 0
/// ```
/// A rigid row follows from it: that beyond the target, which begins each step at rest with the free acceleration
/// `a_u + b w + k g`, R on the diagonal of `H_uu`, gap 0. So a model has it in `H`, `a` and `w`, and every scheme can
/// use it over the first of the engine's steps; here is what the next ones need. Two opposite edges of a pyramid of
/// friction have one distance, which changes by their mean velocity.
/// # Shapes and units
/// `velocity` w, m/s; `damping` b, 1/s; `stiffness` k, 1/s²; `compliance` R, 1/kg; `distance` g, m, 0 where the row
/// rests.
/// # Source
/// Todorov, *Convex and analytically-invertible dynamics with contacts and constraints* (2014), and the documentation
/// of MuJoCo, "Computation": reference acceleration, regularizer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RowTarget {
    /// w.
    pub velocity: f64,
    /// g.
    pub distance: f64,
    /// b.
    pub damping: f64,
    /// k.
    pub stiffness: f64,
    /// R.
    pub compliance: f64,
    /// The row that is the opposite edge; itself where there is none.
    pub opposite: usize,
}

impl RowTarget {
    /// Returns `b w + k g`, by which a row must accelerate beyond where it is, m/s².
    #[inline]
    pub fn asked(&self) -> f64 {
        self.damping * self.velocity + self.stiffness * self.distance
    }
}

impl ReducedInterfaceModel {
    /// Makes a zero model with `contacts` unilateral and `interface` interface rows.
    pub fn zeros(contacts: usize, interface: usize) -> Self {
        Self::zeros_of_rows(contacts, contacts + interface, interface)
    }

    /// Makes a zero model whose contacts have tangential rows, with the coefficients `friction`.
    pub fn zeros_with_friction(friction: &[f64], interface: usize) -> Self {
        let contacts = friction.len();
        ReducedInterfaceModel {
            friction: friction.to_vec(),
            states: vec![ContactState::Open; contacts],
            solved_states: vec![ContactState::Open; contacts],
            ..Self::zeros_of_rows(contacts, 2 * contacts + interface, interface)
        }
    }

    /// Makes a zero model whose contacts have two tangential rows each, with the coefficients `friction`.
    pub fn zeros_in_space(friction: &[f64], interface: usize) -> Self {
        let contacts = friction.len();
        ReducedInterfaceModel {
            friction: friction.to_vec(),
            states: vec![ContactState::Open; contacts],
            directions: vec![[1.0, 0.0]; contacts],
            solved_forces: vec![0.0; 3 * contacts],
            ..Self::zeros_of_rows(contacts, 3 * contacts + interface, interface)
        }
    }

    fn zeros_of_rows(contacts: usize, n: usize, interface: usize) -> Self {
        ReducedInterfaceModel {
            contacts,
            interface,
            contact_rows: n - interface,
            rows: n,
            listing: 0,
            delassus_pattern: None,
            h: vec![0.0; n * n],
            a: vec![0.0; n],
            w: vec![0.0; n],
            gap: vec![0.0; contacts],
            position: vec![0.0; interface],
            at_bound: vec![false; contacts],
            stabilisation: 0.0,
            restitution: 0.0,
            plastic: Vec::new(),
            discretisation_approach: Vec::new(),
            mechanics_step: 0.0,
            spring: None,
            friction: Vec::new(),
            stiction: None,
            states: Vec::new(),
            solved_states: Vec::new(),
            directions: Vec::new(),
            solved_forces: Vec::new(),
            tangential_restitution: 0.0,
            smooth: false,
            unsymmetric: false,
            inertia_varies: false,
            own_steps: 1,
            targets: Vec::new(),
            has_targets: false,
        }
    }

    /// Makes a zero model of rows of an engine, at most `most` of them.
    pub fn zeros_with_targets(most: usize, interface: usize) -> Self {
        let targets = vec![RowTarget::default(); most];
        ReducedInterfaceModel { targets, has_targets: true, ..Self::zeros(most, interface) }
    }

    /// Changes the number of contacts of a dense model without friction, whose numbers are then to be written; within
    /// what it was made for without allocating. Rows stand for other contacts than before.
    pub fn set_contacts(&mut self, contacts: usize) {
        let rows = contacts + self.interface;
        (self.contacts, self.contact_rows, self.rows) = (contacts, contacts, rows);
        self.h.resize(rows * rows, 0.0);
        self.a.resize(rows, 0.0);
        self.w.resize(rows, 0.0);
        self.gap.resize(contacts, 0.0);
        self.at_bound.resize(contacts, false);
        self.targets.resize(contacts, RowTarget::default());
        self.listing += 1;
    }

    /// Takes the targets of rows whose `H`, `a`, `w` and `gap` are filled as they stand, and makes the rows those beyond
    /// them: `R` (1/kg), `b` (1/s), `k` (1/s²) of each row, and the number of the row that is its opposite edge.
    ///
    /// # Errors
    /// Opposite edges that are no rows.
    pub fn take_targets(&mut self, [compliance, damping, stiffness, opposite]: [&[f64]; 4]) -> Result<(), String> {
        let rows = self.contacts;
        let is_row = |number: &f64| number.fract() == 0.0 && (0.0..rows as f64).contains(number);
        if opposite.len() != rows || !opposite.iter().all(is_row) {
            return Err(format!("`opposite` = {opposite:?}; valid: {rows} numbers of rows below {rows}"));
        }
        for (row, target) in self.targets.iter_mut().enumerate() {
            *target = RowTarget {
                velocity: self.w[row],
                distance: self.gap[row],
                damping: damping[row],
                stiffness: stiffness[row],
                compliance: compliance[row],
                opposite: opposite[row] as usize,
            };
        }
        self.go_beyond_targets();
        Ok(())
    }

    /// Makes rows at rest with their free accelerations in `a` and nothing of their own on the diagonal of `H_uu` those
    /// beyond the [`targets`](Self::targets).
    pub fn go_beyond_targets(&mut self) {
        for (row, target) in self.targets.iter().enumerate() {
            self.a[row] += target.asked();
            self.h[row * (self.rows + 1)] += target.compliance;
            (self.w[row], self.gap[row], self.at_bound[row]) = (0.0, 0.0, true);
        }
    }

    /// Makes a zero model whose `H_uu` has this pattern.
    pub fn zeros_of(pattern: Arc<SymmetricPattern>, interface: usize) -> Self {
        let contacts = pattern.size();
        let entries = pattern.entries() + (contacts + interface) * interface;
        let zeros = ReducedInterfaceModel {
            a: vec![0.0; contacts + interface],
            w: vec![0.0; contacts + interface],
            gap: vec![0.0; contacts],
            at_bound: vec![false; contacts],
            contacts,
            contact_rows: contacts,
            ..ReducedInterfaceModel::zeros(0, interface)
        };
        ReducedInterfaceModel { h: vec![0.0; entries], delassus_pattern: Some(pattern), ..zeros }
    }

    /// Returns `H` and `a` as a linear model of contact rows and interface rows.
    #[inline]
    pub fn linear(&self) -> LinearModel<'_> {
        let (contact_rows, interface) = (self.interface_start(), self.interface);
        let (pattern, unsymmetric) = (self.delassus_pattern.as_ref(), self.unsymmetric);
        LinearModel { h: &self.h, a: &self.a, contact_rows, interface, pattern, unsymmetric }
    }

    /// Returns the pattern of `H_uu`, where it is sparse.
    #[inline]
    pub fn delassus_pattern(&self) -> Option<&Arc<SymmetricPattern>> {
        self.delassus_pattern.as_ref()
    }

    /// Returns `H_uu`, where it is sparse.
    #[inline]
    pub fn contact_rows(&self) -> Option<SymmetricRows<'_>> {
        self.delassus_pattern.as_deref().map(|pattern| SymmetricRows { pattern, entries: &self.h[..pattern.entries()] })
    }

    /// Returns column `i` of `[H_ui; H_ii]`, n_u + n_i entries in 1/kg, where `H_uu` is sparse.
    #[inline]
    pub fn interface_column(&self, i: usize) -> Option<&[f64]> {
        let (first, rows) = (self.delassus_pattern.as_ref()?.entries(), self.contacts + self.interface);
        Some(&self.h[first + i * rows..first + (i + 1) * rows])
    }

    /// Returns the number of contacts n_u.
    #[inline]
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// Returns the dimension of the interface n_i (m in the literature).
    #[inline]
    pub fn interface(&self) -> usize {
        self.interface
    }

    /// Tells whether contacts have tangential rows.
    #[inline]
    pub fn has_friction(&self) -> bool {
        !self.friction.is_empty()
    }

    /// Returns the first interface row of the stacked ones: n_u, with friction 2 n_u, in space 3 n_u.
    #[inline]
    pub fn interface_start(&self) -> usize {
        self.contact_rows
    }

    /// Returns the number of tangential rows of each contact with friction: 1 in the plane, 2 in space.
    pub fn tangents(&self) -> usize {
        if self.is_in_space() { 2 } else { 1 }
    }

    /// Tells whether contacts have two tangential rows.
    #[inline]
    pub fn is_in_space(&self) -> bool {
        !self.directions.is_empty()
    }

    /// Checks that a dense `H` is symmetric and positive semidefinite, as for every mechanics. For models from outside.
    ///
    /// # Errors
    /// What is wrong, with the rows.
    pub fn check(&self) -> std::result::Result<(), String> {
        const SLACK: f64 = 1e-6;
        let n = self.rows;
        if self.delassus_pattern.is_some() {
            return Ok(());
        }
        for (name, numbers) in
            [("H", &self.h), ("a", &self.a), ("w", &self.w), ("gap", &self.gap), ("position", &self.position)]
        {
            if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
                return Err(format!("{name} has {} at place {at}, which is no finite number", numbers[at]));
            }
        }
        let at = |row: usize, column: usize| self.h[row * n + column];
        let first = self.interface_start();
        for row in 0..if self.unsymmetric { first } else { n } {
            for column in 0..row {
                let scale = (at(row, row).abs() * at(column, column).abs()).sqrt();
                if (at(row, column) - at(column, row)).abs() > SLACK * scale.max(f64::MIN_POSITIVE) {
                    let (one, other) = (at(row, column), at(column, row));
                    return Err(format!(
                        "H is not symmetric: H[{row}, {column}] = {one:e} and H[{column}, {row}] = {other:e}"
                    ));
                }
            }
        }
        // Elimination without square roots; rows that depend on others leave pivots of round-off.
        let mut left = self.h.clone();
        for row in 0..n {
            let (pivot, own) = (left[row * n + row], at(row, row));
            if own < 0.0 && row >= first {
                return Err(format!(
                    "the sign of the force is reversed: H[{row}, {row}] = {own:e} says that a force above 0 drives its own row of the \
                     interface backwards"
                ));
            }
            if self.unsymmetric && row >= first {
                continue;
            }
            if own < 0.0 || pivot < -SLACK * own {
                return Err(format!(
                    "H is not positive semidefinite: row {row} has the pivot {pivot:e}, of {own:e} on the diagonal"
                ));
            }
            if pivot <= SLACK * own {
                let bound = |below: usize| 2.0 * SLACK * own * at(below, below);
                if let Some(below) = (row + 1..n).find(|&below| left[below * n + row].powi(2) > bound(below)) {
                    return Err(format!("H is not positive semidefinite: rows {row} and {below}"));
                }
                continue;
            }
            let (done, rest) = left.split_at_mut((row + 1) * n);
            let eliminated = &done[row * n + row + 1..];
            for below in rest.chunks_exact_mut(n) {
                let factor = below[row] / pivot;
                below[row + 1..].iter_mut().zip(eliminated).for_each(|(left, own)| *left -= factor * own);
            }
        }
        Ok(())
    }

    /// Takes out of a symmetric, dense `H` that was measured what is none: eigenvalues that are nothing beside the
    /// `largest` magnitude of the run so far (1/kg), and those below 0 that errors may make. Returns the largest
    /// magnitude from now on.
    ///
    /// A reversed force leaves eigenvalues far below 0, which [`check`](Self::check) refuses.
    pub fn clear_round_off(&mut self, largest: f64) -> f64 {
        const NOTHING: f64 = 1e-9;
        const MEASURED: f64 = 0.05;
        let n = self.rows;
        if !self.h.iter().all(|entry| entry.is_finite()) {
            return largest;
        }
        let mut parts = SymmetricEigen::new(DMatrix::from_row_slice(n, n, &self.h));
        let largest = largest.max(parts.eigenvalues.amax());
        let is_nothing = |value: f64| value < NOTHING * largest && value >= -MEASURED * largest;
        if !parts.eigenvalues.iter().any(|value| is_nothing(*value)) {
            return largest;
        }
        parts.eigenvalues.iter_mut().filter(|value| is_nothing(**value)).for_each(|value| *value = 0.0);
        let cleared = parts.recompose();
        let is_held = |row: usize| cleared[(row, row)].abs() <= NOTHING * largest;
        for row in 0..n {
            for column in 0..n {
                let entry = 0.5 * (cleared[(row, column)] + cleared[(column, row)]);
                self.h[row * n + column] = if is_held(row) || is_held(column) { 0.0 } else { entry };
            }
        }
        largest
    }

    /// Returns one entry of the stacked `H`, 1/kg; contacts come first, then tangential rows, interface row `j` is
    /// `interface_start() + j`.
    #[inline]
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.linear().entry(row, column)
    }

    /// Returns one row of the stacked `H`, which must be dense.
    #[inline]
    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.h[row * self.rows..(row + 1) * self.rows]
    }

    /// Tells whether rows of both stand for the same contacts, for two models of one mechanics.
    #[inline]
    pub fn same_contacts(&self, other: &Self) -> bool {
        self.listing == other.listing
    }

    /// Copies another model of equal size and pattern without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        if self.contacts != other.contacts {
            self.set_contacts(other.contacts);
        }
        self.listing = other.listing;
        self.h.copy_from_slice(&other.h);
        self.a.copy_from_slice(&other.a);
        self.w.copy_from_slice(&other.w);
        self.gap.copy_from_slice(&other.gap);
        self.position.copy_from_slice(&other.position);
        self.at_bound.copy_from_slice(&other.at_bound);
        self.stabilisation = other.stabilisation;
        self.restitution = other.restitution;
        if !other.discretisation_approach.is_empty() {
            self.discretisation_approach.copy_from_slice(&other.discretisation_approach);
        }
        self.mechanics_step = other.mechanics_step;
        self.spring = other.spring;
        self.stiction = other.stiction;
        if other.has_targets {
            (self.unsymmetric, self.own_steps) = (other.unsymmetric, other.own_steps);
            self.targets.copy_from_slice(&other.targets);
        }
        // Without friction these are empty, and copying an empty list is a call as well.
        if other.has_friction() {
            self.friction.copy_from_slice(&other.friction);
            self.states.copy_from_slice(&other.states);
            self.solved_states.copy_from_slice(&other.solved_states);
            self.directions.copy_from_slice(&other.directions);
            self.solved_forces.copy_from_slice(&other.solved_forces);
        }
        self.tangential_restitution = other.tangential_restitution;
    }

    /// Returns states and coefficients of contacts with friction in the mechanics' last step.
    #[inline]
    pub fn modes(&self) -> ContactModes<'_> {
        ContactModes { states: &self.states, friction: &self.friction, directions: &self.directions }
    }

    /// Lists the contacts that the mechanics' own last step found closed: the definition that no option changes.
    pub fn closed_contacts(&self, list: &mut Vec<usize>) {
        list.clear();
        list.extend((0..self.contacts).filter(|&contact| self.at_bound[contact]));
    }

    /// Lists the closed contacts and, where contacts rebound, those that may have rebounded in the last step, for
    /// unilateral models.
    ///
    /// ```text
    /// w > 0,  g ≤ 2 h w
    /// ```
    /// A rebound leaves a gap of at most `(e² + ½e (1 + e)) h |w⁻| ≤ 2 h w`, see
    /// [`landing_velocity`](rimbench_contact::contact_law::landing_velocity). Most close again within a macro step; for
    /// the others the condition on closing has no effect.
    pub fn closed_and_leaving_contacts(&self, list: &mut Vec<usize>) {
        let bounces = self.restitution > 0.0 && self.spring.is_none() && !self.has_friction();
        let leaves = |contact: usize| {
            let (gap, w) = (self.gap[contact], self.w[contact]);
            bounces && w > 0.0 && gap <= 2.0 * self.mechanics_step * w
        };
        list.clear();
        list.extend((0..self.contacts).filter(|&contact| self.at_bound[contact] || leaves(contact)));
    }

    /// Returns the largest approach w₀ of a contact that is no impact, m/s, and whether the contact is plastic.
    #[inline]
    pub fn discretisation_approach_of(&self, contact: usize) -> (f64, bool) {
        (self.discretisation_approach.get(contact).copied().unwrap_or(0.0), self.is_plastic(contact))
    }

    /// Tells whether a contact is plastic, whatever the restitution of the others.
    #[inline]
    pub fn is_plastic(&self, contact: usize) -> bool {
        self.plastic.get(contact).copied().unwrap_or(false)
    }

    /// Returns the gap term of the mechanics' own next step for one contact, m/s; see [`gap_velocity`].
    #[inline]
    pub fn step_gap_velocity(&self, contact: usize) -> f64 {
        match self.spring {
            None => gap_velocity(self.gap[contact], self.mechanics_step, self.mechanics_step, self.stabilisation),
            Some(spring) => spring.gap_rates(self.mechanics_step).velocity(self.gap[contact]),
        }
    }

    /// Lists the contacts with `gap ≤ width` (m).
    pub fn contacts_within(&self, width: f64, list: &mut Vec<usize>) {
        list.clear();
        list.extend((0..self.contacts).filter(|&contact| self.gap[contact] <= width));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_off_of_a_held_interface_is_cleared_and_a_reversed_force_is_not() {
        let cleared = |h: [f64; 4], largest: f64| {
            let mut model = ReducedInterfaceModel::zeros(0, 2);
            model.h.copy_from_slice(&h);
            let largest = model.clear_round_off(largest);
            (model.check().is_ok(), model.h, largest)
        };
        assert_eq!(cleared([-3.2e-13, 9e-16, 9e-16, 1.8e-15], 2e-3), (true, vec![0.0; 4], 2e-3));
        assert_eq!(cleared([1e-3, 2e-15, 2e-15, -1e-14], 0.0).1, [1e-3, 0.0, 0.0, 0.0]);
        // A body that is a hundred thousand times as heavy is one.
        assert_eq!(cleared([1e-3, 0.0, 0.0, 1e-8], 0.0).1, [1e-3, 0.0, 0.0, 1e-8]);
        // Held along (1, 1) alone: as large as it was.
        let (sound, h, _) = cleared([0.01, -0.01 - 1e-15, -0.01 - 1e-15, 0.01], 0.0);
        assert!(sound && (h[0] - 0.01).abs() < 1e-15 && (h[1] + 0.01).abs() < 1e-15, "{h:?}");
        assert!(!cleared([-1e-3, 0.0, 0.0, 1e-3], 0.0).0);
        assert!(!cleared([1e-3, 2e-3, 2e-3, 1e-3], 1e-3).0);
    }

    #[test]
    fn the_opposite_of_an_edge_is_a_row_by_its_number_or_is_refused() {
        let taken = |opposite: f64| {
            let mut model = ReducedInterfaceModel::zeros_with_targets(2, 1);
            model.take_targets([&[0.0; 2], &[0.0; 2], &[0.0; 2], &[1.0, opposite]])
        };
        assert_eq!(taken(0.0), Ok(()));
        for number in [0.5, 2.0, -1.0, f64::NAN] {
            assert!(taken(number).unwrap_err().contains("2 numbers of rows below 2"), "{number}");
        }
    }

    #[test]
    fn a_model_that_no_mechanics_can_have_is_told_from_one_with_dependent_rows() {
        let checked = |h: [f64; 4]| {
            let mut model = ReducedInterfaceModel::zeros(1, 1);
            model.h.copy_from_slice(&h);
            model.check()
        };
        for h in [[1.0, 0.5, 0.5, 1.0], [1.0, 1.0, 1.0, 1.0], [0.0; 4]] {
            assert_eq!(checked(h), Ok(()));
        }
        assert!(checked([1.0, f64::NAN, 0.0, 1.0]).unwrap_err().contains("no finite number"));
        assert!(checked([1.0, 0.5, 0.4, 1.0]).unwrap_err().contains("not symmetric: H[1, 0] = 4e-1"));
        for h in [[1.0, 2.0, 2.0, 1.0], [-1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 1.0, 0.0]] {
            let found = checked(h);
            assert!(
                found.as_ref().is_err_and(|what| what.contains("semidefinite") || what.contains("symmetric")),
                "{h:?} {found:?}"
            );
        }
    }
}

//! Which contacts rebound in a step: those that would still be open after another one.

use super::gap::{GapRates, is_hit, landing_velocity, rounding_velocity};

/// The impact law over a step.
#[derive(Debug, Clone, Copy)]
pub struct ImpactStep {
    /// Restitution e along the normal.
    pub restitution: f64,
    /// Restitution along the surface.
    pub along: f64,
    /// The gap law.
    pub rates: GapRates,
    /// By how much a velocity changes a gap, s: the step, or 0 where gaps stand.
    pub advance: f64,
    /// Within which a contact that is hit closes, s.
    pub closing_time: f64,
    /// Tolerance of the solver.
    pub tolerance: f64,
}

/// The contacts at the start of a step.
#[derive(Debug, Clone, Copy)]
pub struct ImpactRows<'a> {
    /// Gaps, m.
    pub gap: &'a [f64],
    /// Velocities `[w_n; w_t]`, m/s.
    pub w: &'a [f64],
    /// Their velocities after the step without contact forces, m/s.
    pub free: &'a [f64],
}

/// The velocity that the contacts of a step with rebounds are solved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solved {
    /// `w⁺` at the end.
    Velocity,
    /// The one by which positions change.
    Displacement,
}

/// The contacts that rebound in a step.
///
/// ```text
/// 0 ≤ w⁺ + e w ⟂ P ≥ 0                      contacts that are hit; all others the gap law, 0 ≤ w⁺ + t ⟂ P ≥ 0
/// 0 ≤ u + (w_free − w) + H P⁺ ⟂ P⁺ ≥ 0      what follows
///     u = −e w of contacts that are hit, w⁺ + t of all others: forces alone
///     u = w⁺ of contacts that are hit, w⁺ plus the gap law of g + h w⁺ of all others: the next step
/// ```
/// Of the contacts that are hit, those rebound that neither of what follows closes. The others have the gap law, as if
/// they did not bounce; the rest is asked again until all last. Of a single contact both say `e |w| > h b`, b its
/// acceleration towards the surface; of several the forces of those that stay closed are in it. The first one counts no
/// rebound that is one of others which throw the contact up, the second none that is stopped by others which are still
/// closing. Where a step has no solution with its rebounds none lasts: thrown back from one wall a body would be through
/// the other by its end.
/// # Shapes and units
/// Velocities m/s, in rows `[n; t]`, without friction `[n]`.
/// # Source
/// Newton's law of impact, in the form of Moreau; which rebound, ours.
///
/// A plastic contact among them has e = 0 and stops in the step in which it is hit, w⁺ ≥ 0, while its position follows
/// the gap law. By the gap law alone an impact takes two steps, and with friction those may slide where one blow
/// sticks.
#[derive(Debug, Clone, Default)]
pub struct Rebounds {
    rebounding: Vec<bool>,
    plastic: Vec<bool>,
    any: bool,
    /// Those that are closed after the trial that follows.
    over: Vec<bool>,
    b: Vec<f64>,
    impulses: Vec<f64>,
    /// `H P + b` of the step, and of what follows.
    after: Vec<f64>,
    velocities: Vec<f64>,
}

impl Rebounds {
    /// Makes room for contacts with so many rows.
    pub fn new(contacts: usize, rows: usize) -> Self {
        Rebounds {
            rebounding: vec![false; contacts],
            plastic: vec![false; contacts],
            any: false,
            over: vec![false; contacts],
            b: vec![0.0; rows],
            impulses: vec![0.0; rows],
            after: vec![0.0; rows],
            velocities: vec![0.0; rows],
        }
    }

    /// Tells whether any contact rebounds, or stops where it is plastic.
    #[inline]
    pub fn any(&self) -> bool {
        self.any
    }

    /// Tells whether this one does.
    #[inline]
    pub fn rebounds(&self, contact: usize) -> bool {
        self.is_hit(contact) && !self.plastic[contact]
    }

    /// Tells whether this one has the law of impact.
    #[inline]
    fn is_hit(&self, contact: usize) -> bool {
        self.any && self.rebounding[contact]
    }

    /// Returns `e` of a contact: 0 of a plastic one.
    #[inline]
    fn of(&self, contact: usize, restitution: f64) -> f64 {
        if self.plastic[contact] { 0.0 } else { restitution }
    }

    /// Notes which contacts are hit, and says whether one is; `own` tells the approach (m/s) up to which a contact
    /// rests, and whether it is plastic.
    #[inline]
    pub fn record_hits(&mut self, step: &ImpactStep, rows: ImpactRows<'_>, own: impl Fn(usize) -> (f64, bool)) -> bool {
        let changes = rows.w.iter().zip(rows.free).map(|(w, free)| (*w, free - w));
        let rounding = rounding_velocity(step.tolerance, changes);
        self.any = false;
        for (contact, (hit, &gap)) in self.rebounding.iter_mut().zip(rows.gap).enumerate() {
            let (own, plastic) = own(contact);
            self.plastic[contact] = plastic;
            *hit = is_hit(gap, rows.w[contact], rounding.max(own), step.closing_time);
            self.any |= *hit;
        }
        self.any
    }

    /// Finds out which of the contacts that are hit rebound; says whether one does. `solve` writes impulses and
    /// velocities `H P + b` for a right-hand side b.
    ///
    /// # Errors
    /// As `solve` reports.
    #[inline]
    pub fn look_ahead<E>(
        &mut self,
        step: &ImpactStep,
        rows: ImpactRows<'_>,
        mut solve: impl FnMut(&[f64], &mut [f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<bool, E> {
        // Each round has one rebound less, or is the last.
        while self.any && self.drop_those_that_are_over(step, rows, &mut solve)? {}
        Ok(self.any)
    }

    /// Tries the step and what follows, and drops the rebounds that are over by then; says whether one was.
    fn drop_those_that_are_over<E>(
        &mut self,
        step: &ImpactStep,
        rows: ImpactRows<'_>,
        solve: &mut impl FnMut(&[f64], &mut [f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<bool, E> {
        let (contacts, n) = (rows.gap.len(), rows.w.len());
        for row in 0..n {
            self.b[row] = rows.free[row] + self.term_of_row(step, rows, row);
        }
        let solved = solve(&self.b[..n], &mut self.impulses[..n], &mut self.after[..n]);
        let trials: &[bool] = if solved.is_ok() { &[false, true] } else { &[] };
        self.over[..contacts].fill(true);
        for &moving in trials {
            let mut largest = 0.0_f64;
            for row in 0..n {
                // Contacts that touch have w⁺ + t = 0.
                let (touching, reached) = (self.after[row], self.after[row] - self.term_of_row(step, rows, row));
                let starts_with = match row.checked_sub(contacts) {
                    Some(_) => reached,
                    None if self.rebounding[row] && moving => reached,
                    None if self.rebounding[row] => -self.of(row, step.restitution) * rows.w[row],
                    None if moving => reached + still_open(step, rows.gap[row] + step.advance * reached),
                    None => touching.max(0.0),
                };
                self.b[row] = starts_with + (rows.free[row] - rows.w[row]);
                largest = largest.max(self.b[row].abs());
            }
            solve(&self.b[..n], &mut self.impulses[..n], &mut self.velocities[..n])?;
            for (over, w) in self.over[..contacts].iter_mut().zip(&self.velocities) {
                *over = (*over && moving) || *w <= step.tolerance * largest;
            }
        }
        let mut dropped = false;
        self.any = false;
        for ((rebounding, over), plastic) in self.rebounding[..contacts].iter_mut().zip(&self.over).zip(&self.plastic) {
            let over = *over && !plastic;
            dropped |= *rebounding && over;
            *rebounding &= !over;
            self.any |= *rebounding;
        }
        if dropped { Ok(true) } else { solved.map(|()| false) }
    }

    /// The terms in the rows of the trial, m/s, in the order of `w`.
    fn term_of_row(&self, step: &ImpactStep, rows: ImpactRows<'_>, row: usize) -> f64 {
        let contacts = rows.gap.len();
        match row.checked_sub(contacts) {
            None => self.term(step, row, still_open(step, rows.gap[row]), rows.w[row], Solved::Velocity),
            Some(contact) => self.term_along(step, contact, rows.w[row]),
        }
    }

    /// Returns the term in the normal row of a contact, m/s, of which the gap law says `gap_term`, and which moves with
    /// `w`.
    #[inline]
    pub fn term(&self, step: &ImpactStep, contact: usize, gap_term: f64, w: f64, solved: Solved) -> f64 {
        match solved {
            _ if !self.is_hit(contact) => gap_term,
            Solved::Velocity => self.of(contact, step.restitution) * w,
            Solved::Displacement => landing_velocity(self.of(contact, step.restitution), gap_term, w),
        }
    }

    /// Returns the term in the tangential row of a contact that slides with `w`, m/s.
    #[inline]
    pub fn term_along(&self, step: &ImpactStep, contact: usize, w: f64) -> f64 {
        if self.rebounds(contact) { step.along * w } else { 0.0 }
    }
}

/// The gap law of a trial, m/s: that a penetration is taken back makes nothing rebound that goes with it.
fn still_open(step: &ImpactStep, gap: f64) -> f64 {
    step.rates.velocity(gap.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: ImpactStep = ImpactStep {
        restitution: 0.5,
        along: 0.0,
        rates: GapRates { open: 100.0, closed: 20.0 },
        advance: 0.01,
        closing_time: 0.01,
        tolerance: 1e-9,
    };

    /// Which of two contacts rebound, `H` being that of bodies of 1 kg one on the other, or of one with nothing else.
    fn rebounding(h: [[f64; 2]; 2], gap: [f64; 2], w: [f64; 2], free: [f64; 2]) -> [bool; 2] {
        let mut rebounds = Rebounds::new(2, 2);
        let rows = ImpactRows { gap: &gap, w: &w, free: &free };
        if rebounds.record_hits(&STEP, rows, |_| (0.0, false)) {
            let solve = |b: &[f64], p: &mut [f64], y: &mut [f64]| {
                // Two contacts: projected Gauss–Seidel.
                p.fill(0.0);
                for _ in 0..400 {
                    for i in 0..2 {
                        let j = 1 - i;
                        p[i] = (-(b[i] + h[i][j] * p[j]) / h[i][i]).max(0.0);
                    }
                }
                (0..2).for_each(|i| y[i] = b[i] + h[i][0] * p[0] + h[i][1] * p[1]);
                if y.iter().all(|y| *y > -1e-9) { Ok(()) } else { Err("no solution") }
            };
            rebounds.look_ahead(&STEP, rows, solve).unwrap();
        }
        [0, 1].map(|contact| rebounds.rebounds(contact))
    }

    #[test]
    fn a_rebound_must_outlast_the_step_that_follows() {
        let alone = [[1.0, 0.0], [0.0, 1.0]];
        // e |w| = 0.1 m/s against h g: 0.0981 and 0.1001 m/s.
        let fall = |b: f64| rebounding(alone, [0.0, 1.0], [-0.2, 0.0], [-0.2 - 0.01 * b, -0.01 * b]);
        assert_eq!(fall(9.81), [true, false]);
        assert_eq!(fall(10.01), [false, false]);
        // What is pulled away rebounds always.
        assert_eq!(fall(-10.0), [true, false]);
    }

    #[test]
    fn a_rebound_must_have_room_before_the_opposite_wall() {
        let walls = [[1.0, -1.0], [-1.0, 1.0]];
        // Thrown back with 0.5 m/s it moves by 5 mm in the step.
        let free = |room: f64| rebounding(walls, [0.0, room], [-1.0, 1.0], [-1.0, 1.0]);
        assert_eq!(free(0.0051), [true, false]);
        assert_eq!(free(0.0049), [false, false]);
    }

    #[test]
    fn a_contact_must_not_rebound_where_others_press_it_that_stay_closed() {
        // A body of 1 kg on another one that lies on the ground: its contact has no acceleration of its own, both fall
        // alike.
        let stack = [[1.0, -1.0], [-1.0, 2.0]];
        let (h, g) = (0.01, 9.81);
        let rows = |w: f64| rebounding(stack, [0.0, 0.0], [0.0, w], [-h * g, w]);
        // The ground holds the lower one: the upper one falls with g, and 0.09 m/s are over in a step, 0.11 m/s are
        // not.
        assert_eq!(rows(-0.18), [false, false]);
        assert_eq!(rows(-0.22), [false, true]);
    }
}

//! When contacts are closed, read from gaps at communication points.

use rimbench_core::cosim::Trajectory;

/// A contact closes when its gap falls to this, m. A plastic step ends within round-off and the curvature of one step
/// of the surface; ours.
pub const CLOSES_AT: f64 = 1e-5;

/// A closed contact opens when its gap exceeds this, m: smaller hops, and what the curvature of a surface lifts a
/// contact in one step of 20 ms, are no opening; ours.
pub(super) const OPENS_AT: f64 = 2e-4;

/// An open interval no longer than this, s, or than one macro step, is chatter: the phase goes on. The touch-down of
/// the wedge box rattles for 3 ms; ours.
pub(super) const CHATTER: f64 = 5e-3;

/// A time during which a contact is closed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ContactPhase {
    /// When it closed, s; `None` where it was closed from the first row.
    pub closed_at: Option<f64>,
    /// When it opened, s; +∞ where it is closed to the last row.
    pub opened_at: f64,
}

/// A time during which a contact is closed, before chatter is merged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactInterval {
    phase: ContactPhase,
    /// Time of the row in which it closed, and of the first open row after it, s.
    closed_row: f64,
    open_row: f64,
}

impl ContactInterval {
    /// When the contact closed, s; none where it was closed from the start.
    pub(super) fn closed_at(&self) -> Option<f64> {
        self.phase.closed_at
    }
}

/// The intervals during which a contact is closed, found row by row.
///
/// A contact that the stepper catches in the step in which it closes arrives at its gap of zero only at the end of that
/// step. So the instant of closing is where the *approach* leads: the line through the last two open rows, held within
/// the interval in which the gap closed; the line across that interval where there is no approach to extrapolate. The
/// instant of opening is where the line across the interval leaves 10 µm.
#[derive(Debug, Clone, Default)]
pub struct ContactIntervals {
    /// Those so far.
    pub found: Vec<ContactInterval>,
    closed: bool,
    /// The last two rows, time and gap, the later one first.
    last: [Option<[f64; 2]>; 2],
    /// Last row at or below the closing level, and the one after it.
    touching: Option<[f64; 2]>,
    leaving: Option<[f64; 2]>,
}

impl ContactIntervals {
    /// Takes one more row; tells whether the contact closes in it.
    pub(super) fn add(&mut self, time: f64, gap: f64) -> bool {
        let row = [time, gap];
        if self.leaving.is_none() {
            self.leaving = Some(row);
        }
        let closes = !self.closed && gap <= CLOSES_AT;
        if closes {
            self.closed = true;
            let closed_at = self.last[0].map(|before| closing_time(self.last[1], before, row));
            self.found.push(ContactInterval {
                phase: ContactPhase { closed_at, opened_at: f64::INFINITY },
                closed_row: time,
                open_row: f64::INFINITY,
            });
        } else if self.closed && gap > OPENS_AT {
            self.closed = false;
            if let (Some(last), Some(before), Some(after)) = (self.found.last_mut(), self.touching, self.leaving) {
                last.phase.opened_at = crossing(before, after);
                last.open_row = after[0];
            }
        }
        if gap <= CLOSES_AT {
            (self.touching, self.leaving) = (Some(row), None);
        }
        let closes = closes && self.last[0].is_some();
        self.last = [Some(row), self.last[0]];
        closes
    }
}

/// Returns the [intervals](ContactIntervals) during which the contact with the gap column `gap` is closed.
pub fn contact_intervals(trajectory: &Trajectory, gap: usize) -> Vec<ContactInterval> {
    let mut intervals = ContactIntervals::default();
    for row in trajectory.rows() {
        intervals.add(row[0], row[gap]);
    }
    intervals.found
}

/// The phases of one contact: its intervals with open times of up to `chatter` (s) between them merged.
pub(super) fn phases(intervals: &[ContactInterval], chatter: f64) -> Vec<ContactPhase> {
    let mut phases: Vec<ContactPhase> = Vec::new();
    let mut open_since = f64::NEG_INFINITY;
    for interval in intervals {
        match phases.last_mut() {
            // Times of rows are rounded.
            Some(last) if interval.closed_row - open_since <= chatter * (1.0 + 1e-9) => {
                last.opened_at = interval.phase.opened_at;
            }
            _ => phases.push(interval.phase),
        }
        open_since = interval.open_row;
    }
    phases
}

/// Instant at which the gap closes between the rows `before` and `after`.
fn closing_time(earlier: Option<[f64; 2]>, before: [f64; 2], after: [f64; 2]) -> f64 {
    if let Some(earlier) = earlier {
        let approached = earlier[1] - before[1];
        if approached > 0.0 {
            let ahead = (before[1] - CLOSES_AT) * (before[0] - earlier[0]) / approached;
            return (before[0] + ahead).clamp(before[0], after[0]);
        }
    }
    crossing(before, after)
}

/// Instant at which the line between two rows crosses the closing level.
fn crossing(before: [f64; 2], after: [f64; 2]) -> f64 {
    let share = (before[1] - CLOSES_AT) / (before[1] - after[1]);
    before[0] + share.clamp(0.0, 1.0) * (after[0] - before[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trajectory(rows: &[[f64; 2]]) -> Trajectory {
        Trajectory::from_data(vec!["time_s".to_owned(), "gap_m".to_owned()], rows.concat())
    }

    fn phases_of(trajectory: &Trajectory, gap: usize, chatter: f64) -> Vec<ContactPhase> {
        phases(&contact_intervals(trajectory, gap), chatter)
    }

    #[test]
    fn a_contact_caught_at_the_end_of_its_step_closes_where_its_approach_leads() {
        // 0.1 m/s, gap zero at 0.123 s; the stepper catches it at 0.13 s with a gap of zero.
        let rows: Vec<[f64; 2]> =
            (0..20).map(|k| f64::from(k) * 0.01).map(|t| [t, (0.1 * (0.123 - t)).max(0.0)]).collect();
        let found = phases_of(&trajectory(&rows), 1, CHATTER);
        assert_eq!(found.len(), 1);
        approx::assert_relative_eq!(found[0].closed_at.unwrap(), 0.123 - CLOSES_AT / 0.1, epsilon = 1e-12);
        assert_eq!(found[0].opened_at, f64::INFINITY);
        // Without two open rows the line across the interval serves; closed from the start has no instant.
        let found = phases_of(&trajectory(&[[0.0, 1e-3], [1.0, -1e-3], [2.0, 3e-3], [3.0, 0.0]]), 1, 0.5);
        approx::assert_relative_eq!(found[0].closed_at.unwrap(), 0.495, epsilon = 1e-12);
        approx::assert_relative_eq!(found[0].opened_at, 1.0 + 1.01e-3 / 4e-3, epsilon = 1e-12);
        assert_eq!(phases_of(&trajectory(&[[0.0, 0.0], [1.0, 0.0]]), 1, CHATTER)[0].closed_at, None);
    }

    #[test]
    fn hops_and_chatter_are_one_phase_and_a_lift_off_is_not() {
        // A hop below the opening level, then a rattle of 4 ms above it, then a lift-off of 20 ms.
        let gap = |k: usize| match k {
            0..10 => 1e-3 * (10 - k) as f64,
            20..25 => 1e-4,
            40..44 => 5e-4,
            60..80 => 5e-4,
            _ => 0.0,
        };
        let rows: Vec<[f64; 2]> = (0..100).map(|k| [k as f64 * 1e-3, gap(k)]).collect();
        let found = phases_of(&trajectory(&rows), 1, CHATTER);
        assert_eq!(found.len(), 2, "{found:?}");
        approx::assert_relative_eq!(found[0].closed_at.unwrap(), 0.01, epsilon = 1e-4);
        approx::assert_relative_eq!(found[0].opened_at, 0.059, epsilon = 1e-4);
        approx::assert_relative_eq!(found[1].closed_at.unwrap(), 0.0795, epsilon = 6e-4);
        assert_eq!(phases_of(&trajectory(&rows), 1, 0.0).len(), 3);
        assert_eq!(phases_of(&trajectory(&rows), 1, 0.02).len(), 1);
    }
}

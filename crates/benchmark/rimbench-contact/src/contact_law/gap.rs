//! Gap law and impact law of one step, used alike by the mechanics and by the models made from it.

/// Returns the velocity by which a contact must at least open, or may at most close, in one step.
///
/// ```text
/// 0 ≤ w⁺ + max(g, 0)/h_open + γ·min(g, 0)/h_closed ⟂ P ≥ 0
/// ```
/// An open contact may use up its gap within `h_open`; a penetration `−g` decays by the fraction γ within `h_closed`.
/// The mechanics uses its own step for both. A model that tracks the gap opens and closes at the actuator's micro step
/// but lets a penetration decay as slowly as the mechanics does.
/// # Shapes and units
/// `gap` m; `h_open`, `h_closed` s; returns m/s.
/// # Source
/// Ours.
#[inline]
pub fn gap_velocity(gap: f64, h_open: f64, h_closed: f64, stabilisation: f64) -> f64 {
    if gap > 0.0 { gap / h_open } else { stabilisation * gap / h_closed }
}

/// The gap law with both times fixed, for use in many steps of equal length: products instead of divisions.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GapRates {
    /// `1/h_open`, 1/s.
    pub open: f64,
    /// `γ/h_closed`, or what stands for it, 1/s.
    pub closed: f64,
}

impl GapRates {
    /// Fixes `h_open`, `h_closed` (s) and γ.
    pub fn new(h_open: f64, h_closed: f64, stabilisation: f64) -> Self {
        GapRates { open: 1.0 / h_open, closed: stabilisation / h_closed }
    }

    /// Returns [`gap_velocity`] to round-off, m/s.
    #[inline]
    pub fn velocity(&self, gap: f64) -> f64 {
        gap * if gap > 0.0 { self.open } else { self.closed }
    }
}

/// Tells whether a contact is hit in a step: whether it closes within it, faster than what rests does.
///
/// ```text
/// w < −w₀ and g + h w ≤ 0
/// ```
/// A contact that is hit rebounds if the rebound lasts, see [`Rebounds`](super::Rebounds), and has the gap law if not.
/// # Shapes and units
/// `gap` m; `w` the velocity before, m/s; `own` the approach w₀ ≥ 0 of contacts that rest, m/s, see
/// [`discretisation_approach`] and [`rounding_velocity`]; `h` s.
/// # Source
/// Ours.
#[inline]
pub fn is_hit(gap: f64, w: f64, own: f64, h: f64) -> bool {
    w < -own && gap + h * w <= 0.0
}

/// Returns the velocity term by which a contact that rebounds moves in the step in which it is hit, m/s.
///
/// ```text
/// (1 − e²) t + ½e (1 + e) w          t the gap law: g⁺ = e² g + ½e (1 + e) h |w|
/// ```
/// Its velocity at the end is that of Newton's law, `w⁺ = −e w`, which says nothing of where it is by then. To leave it
/// where the velocity takes it, `g⁺ = g + e h |w|`, is to turn it round before it has touched: with e = 0 it would hang
/// above its surface by up to h |w|. The semi-implicit step keeps `½w² + b g − ½h b w` under any constant acceleration
/// b towards the surface; a law of impact is to leave e² of that, and that makes the position above, whatever b is.
/// With e = 0 it is the gap law, with e = 1 Newton's.
/// # Shapes and units
/// `gap_term` t, `w` the velocity before, m/s.
/// # Source
/// Ours.
#[inline]
pub fn landing_velocity(restitution: f64, gap_term: f64, w: f64) -> f64 {
    (1.0 - restitution * restitution) * gap_term + 0.5 * restitution * (1.0 + restitution) * w
}

/// Returns the approach that a semi-implicit step makes by itself of a contact at rest, m/s: up to this, it is taken
/// for one that still rests.
///
/// ```text
/// w₀ = h |c| + max(0, A (v − v̂))        c = Ȧ v
/// ```
/// **The row turns.** A contact at rest over a step ends it with `A v⁺ = −h c − g/h`: the convective term is foreseen,
/// and an open gap may be used up. Along the row as it then stands the velocity is
/// `w = A v⁺ + h c' = h (c' − c) − g/h`, with c' that of v⁺, and the gap, of which the step's straight way leaves out
/// the curvature, is `g' = g + h A v⁺ + ½h² c' = h² (½c' − c)`. While c stays that is a gap of `½h²|c|` and an approach
/// of `½h|c|` in every step, which together fulfil the condition of an impact, `g + h w = 0`. Where c comes to be
/// within a step, from the geometry or from a velocity that jumps, the approach is `h|c'|`. Where it ceases to be a gap
/// of `h²|c|` is left, the next step uses it up, and the one after finds the approach `h|c|`: two steps later than the
/// row has turned.
///
/// **The joints turn.** Velocities are made consistent with the joints, `v̂`, before contacts see them: what that adds
/// to the approach of a row is known to the bit, and is of order h as well.
///
/// Of order h both: an impact of any speed is one if the step is short enough. The mechanics takes the largest of this
/// step and the last two, for contacts that touched in one of the last two; to all others any approach is an impact. It
/// is an estimate: a bend of the row between two points of the steps is not seen, and what is hit again within two
/// steps at less than w₀ does not rebound.
/// # Shapes and units
/// `h` s; `convective` c of the row, m/s²; `corrected` `A (v̂ − v)` m/s; returns m/s.
/// # Source
/// Ours.
#[inline]
pub fn discretisation_approach(h: f64, convective: f64, corrected: f64) -> f64 {
    h * convective.abs() + (-corrected).max(0.0)
}

/// Returns the approach up to which a contact that closes rests, with what a solver leaves, and is not hit, m/s.
///
/// ```text
/// τ max_j (|w_j| + |h a_j|)
/// ```
/// Along the normal a rebound of rounding is rounding. But it would take a contact that rests for one on its way out;
/// and along the surface it is the whole velocity of a contact that slides, and would turn it round with e.
/// # Shapes and units
/// `tolerance` τ of the solver; `rows` velocity before the step and its change by the free acceleration, of all rows of
/// contacts, m/s.
#[inline]
pub fn rounding_velocity(tolerance: f64, rows: impl Iterator<Item = (f64, f64)>) -> f64 {
    tolerance * rows.fold(0.0, |largest: f64, (w, change)| largest.max(w.abs() + change.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_rests_up_to_what_the_solver_leaves_of_the_largest_velocity() {
        let bound = rounding_velocity(1e-9, [(-1e-17, -9.81e-3), (0.5, 0.0)].into_iter());
        approx::assert_relative_eq!(bound, 0.5e-9, max_relative = 1e-12);
        // All stand still: weight over a step.
        let bound = rounding_velocity(1e-9, [(-1e-17, -1e-2)].into_iter());
        approx::assert_relative_eq!(bound, 1e-11, max_relative = 1e-12);
    }

    #[test]
    fn a_step_approaches_a_contact_as_its_row_turns_and_as_the_joints_add_towards_it() {
        assert_eq!(discretisation_approach(0.5, -4.0, 1.0), 2.0);
        assert_eq!(discretisation_approach(0.5, 4.0, -1.0), 3.0);
    }

    #[test]
    fn a_contact_is_hit_only_if_it_closes_within_the_step() {
        assert!(is_hit(0.01, -1.0, 0.0, 0.02) && is_hit(0.0, -1.0, 0.0, 0.02));
        // Too far away, or moving off.
        assert!(!is_hit(0.03, -1.0, 0.0, 0.02) && !is_hit(-0.01, 1.0, 0.0, 0.02));
        // What steps make by themselves is no impact.
        assert!(!is_hit(0.0, -1.0, 1.0, 0.02) && is_hit(0.0, -1.0, 0.99, 0.02));
    }

    #[test]
    fn a_rebound_must_leave_the_part_of_the_energy_that_restitution_says_under_any_acceleration() {
        let (h, gap, w) = (0.01, 0.004, -1.0);
        for (e, b) in [(0.0, 3.0), (0.3, 9.81), (0.8, -20.0), (1.0, 5.0)] {
            let energy = |gap: f64, w: f64| 0.5 * w * w + b * gap - 0.5 * h * b * w;
            let after = energy(gap - h * landing_velocity(e, gap / h, w), -e * w);
            approx::assert_relative_eq!(after, e * e * energy(gap, w), epsilon = 1e-15, max_relative = 1e-13);
        }
        // The gap law at one end, Newton's at the other.
        assert_eq!((landing_velocity(0.0, 0.4, w), landing_velocity(1.0, 0.4, w)), (0.4, w));
    }
}

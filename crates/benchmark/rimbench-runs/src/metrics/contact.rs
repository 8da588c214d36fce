//! What contacts do: effective mass, lift-off, penetration.

use super::evidence::metrics;

/// Bound of "stays down", m: a contact that opens by at most this has not lifted off. Claims, figures and page share
/// it.
pub const STAYS_DOWN_M: f64 = 1e-5;

metrics! {
    EFFECTIVE_MASS_MAX: "effective_mass_max_kg" in "kg",
    "Largest effective mass at a communication point; inf for a locked interface"
    => |evidence| evidence.sums.masses.map(|[_, high]| high);

    EFFECTIVE_MASS_RATIO: "effective_mass_ratio" in "-",
    "Largest over smallest effective mass at a communication point; inf for an interface that is locked at some of them, 1 for one that is at all"
    => |evidence| {
        let [low, high] = evidence.sums.masses?;
        // Locked throughout, the mass is infinite and constant: the ratio is 1, not ∞/∞.
        Some(if low == high { 1.0 } else { high / low })
    };

    LIFT_OFF: "lift_off_height_m" in "m",
    "Largest gap of a contact while the same contact is closed in the reference"
    => |evidence| evidence.sums.lifted.map(|height| height.max(0.0));

    CLOSED_AT_END: "closed_contacts_end" in "-" of Claimed,
    "Contacts with a gap of at most 10 µm at the last communication point reached"
    => |evidence| evidence.sums.closed.filter(|_| !evidence.sums.columns.gaps.is_empty()).map(|count| count as f64);

    REDUNDANT: "redundant_contacts_max" in "-",
    "Most closed contacts at a communication point less the rank of their normal rows: rigid ones with friction in space then have no \
     unique velocities"
    => |evidence| evidence.sums.redundant;

    PENETRATION: "penetration_m" in "m",
    "Deepest penetration of any contact at a communication point"
    => |evidence| evidence.sums.lowest.map(|lowest| (-lowest).max(0.0));
}

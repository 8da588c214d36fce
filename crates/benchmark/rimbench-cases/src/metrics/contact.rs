//! What contacts do: effective mass, lift-off, penetration.

use super::contact_phase::CLOSES_AT;
use super::evidence::{Evidence, metrics};

/// A contact of the reference with a gap below this counts as closed, m.
const CLOSED_IN_REFERENCE: f64 = 1e-6;

/// Bound of "stays down", m: a contact that opens by at most this has not lifted off. Claims, figures and page share it.
pub const STAYS_DOWN_M: f64 = 1e-5;

metrics! {
    EFFECTIVE_MASS_MAX: "effective_mass_max_kg" in "kg",
    "Largest effective mass at a communication point; inf for a locked interface"
    => |evidence| effective_masses(evidence).map(|masses| masses.fold(f64::NEG_INFINITY, f64::max));

    EFFECTIVE_MASS_RATIO: "effective_mass_ratio" in "-",
    "Largest over smallest effective mass at a communication point; inf for an interface that is locked at some of them, 1 for one that is at all"
    => |evidence| {
        let (low, high) = effective_masses(evidence)?
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mass| (low.min(mass), high.max(mass)));
        // What is locked from the first point to the last does not vary: equal, and not infinity over itself.
        Some(if low == high { 1.0 } else { high / low })
    };

    LIFT_OFF: "lift_off_height_m" in "m",
    "Largest gap of a contact while the same contact is closed in the reference"
    => |evidence| {
        let lifted = evidence.gaps.iter().flat_map(|&gap| {
            evidence.pairs(gap).filter(|(_, reference)| *reference <= CLOSED_IN_REFERENCE).map(|(own, _)| own)
        });
        lifted.reduce(f64::max).map(|height| height.max(0.0))
    };

    CLOSED_AT_END: "closed_contacts_end" in "-" of Claimed,
    "Contacts with a gap of at most 10 µm at the last communication point reached"
    => |evidence| {
        let last = |&gap: &usize| evidence.run.column(gap).last();
        let gaps = evidence.gaps.iter().map(last).collect::<Option<Vec<f64>>>()?;
        (!gaps.is_empty()).then(|| gaps.iter().filter(|gap| **gap <= CLOSES_AT).count() as f64)
    };

    REDUNDANT: "redundant_contacts_max" in "-",
    "Most closed contacts at a communication point less the rank of their normal rows: rigid ones with friction in space then have no \
     unique velocities"
    => |evidence| {
        let [closed, rank] = ["closed_contacts", "rank_h_uu"].map(|name| evidence.run.index_of(name));
        let beyond = evidence.run.column(closed?).zip(evidence.run.column(rank?)).map(|(closed, rank)| closed - rank);
        beyond.filter(|count| !count.is_nan()).reduce(f64::max)
    };

    PENETRATION: "penetration_m" in "m",
    "Deepest penetration of any contact at a communication point"
    => |evidence| {
        let gaps = evidence.gaps.iter().chain(evidence.least_gaps);
        gaps.flat_map(|&gap| evidence.run.column(gap)).reduce(f64::min).map(|lowest| (-lowest).max(0.0))
    };
}

fn effective_masses<'a>(evidence: &'a Evidence<'_>) -> Option<impl Iterator<Item = f64> + 'a> {
    let column = evidence.effective_mass?;
    let mut masses = evidence.run.column(column).filter(|mass| !mass.is_nan()).peekable();
    masses.peek()?;
    Some(masses)
}

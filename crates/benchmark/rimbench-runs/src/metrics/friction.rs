//! What contacts with friction do, held against the reference: who sticks when.
//! Only what the run lived to see counts.

use super::event::matched;
use super::evidence::{Evidence, metrics};
use super::friction_phase::FrictionPhase;
use rimbench_core::friction::ContactState;

metrics! {
    WRONG_STATE: "wrong_friction_state_share" in "-" of Friction,
    "Share of the time in which some contact does not do what it does in the reference: open, stick, slip one way or the other"
    => |evidence| {
        let (end, _) = span(evidence)?;
        let pairs: Vec<_> = evidence.run_friction.iter().zip(evidence.reference_friction).collect();
        let mut borders: Vec<f64> =
            pairs.iter().flat_map(|(run, reference)| run.iter().chain(*reference)).map(|phase| phase.since).collect();
        borders.extend([0.0, end]);
        borders.retain(|time| (0.0..=end).contains(time));
        borders.sort_by(f64::total_cmp);
        let differs = |t: f64| pairs.iter().any(|(run, reference)| state_at(run, t) != state_at(reference, t));
        // States do not change between two borders.
        let pieces = borders.windows(2).filter(|piece| piece[1] > piece[0]);
        let wrong = pieces.filter(|piece| differs(0.5 * (piece[0] + piece[1]))).map(|piece| piece[1] - piece[0]);
        Some(wrong.fold(0.0, |sum, piece| sum + piece) / end)
    };

    RELEASE_SHIFT_MAX: "release_time_shift_max_s" in "s" of Friction,
    "Largest shift in time, early or late, of a contact that sticks and starts to slide in both run and reference"
    => |evidence| {
        releases(evidence)?
            .iter()
            .flat_map(|[run, reference]| matched(run, reference))
            .map(|(run, reference)| (run - reference).abs())
            .reduce(f64::max)
    };

    RELEASES_MISSED: "releases_missed" in "-" of Friction,
    "Contacts that stick and start to slide in the reference but not within 0.1 s in the run"
    => |evidence| {
        let missed = |[run, reference]: &[Vec<f64>; 2]| reference.len() - matched(run, reference).count();
        Some(releases(evidence)?.iter().map(missed).sum::<usize>() as f64)
    };

    STICK_INTERVALS: "stick_intervals" in "-" of Friction,
    "Times for which a contact sticks in the run, that at the start among them; slips up to max(H, 5 ms) between them do not part them"
    => |evidence| {
        let (_, chatter) = span(evidence)?;
        Some(evidence.run_friction.iter().map(|phases| sticks(phases, chatter).len()).sum::<usize>() as f64)
    };

    SLIP_REVERSALS: "slip_reversals" in "-" of Friction,
    "Changes of the direction in which a contact slides in the run, with or without a stick between; after a lift-off it starts again"
    => |evidence| {
        span(evidence)?;
        Some(evidence.run_friction.iter().map(|phases| reversals(phases)).sum::<usize>() as f64)
    };
}

/// End of the run, and how long a slip may be that parts no sticks, s; none where the case has no friction or the run
/// no interval.
fn span(evidence: &Evidence<'_>) -> Option<(f64, f64)> {
    let end = evidence.sums.end.filter(|end| *end > 0.0 && !evidence.run_friction.is_empty())?;
    Some((end, evidence.sums.chatter))
}

fn state_at(phases: &[FrictionPhase], t: f64) -> Option<ContactState> {
    phases[..phases.partition_point(|phase| phase.since <= t)].last().map(|phase| phase.state)
}

/// When each stick ends, s (+∞ where it does not), and whether in a slip.
fn sticks(phases: &[FrictionPhase], chatter: f64) -> Vec<(f64, bool)> {
    let mut sticks: Vec<(f64, bool)> = Vec::new();
    for (index, phase) in phases.iter().enumerate().filter(|(_, phase)| phase.state == ContactState::Stick) {
        let next = phases.get(index + 1);
        let end = next.map_or((f64::INFINITY, false), |next| (next.since, next.state.friction() != 0.0));
        match sticks.last_mut() {
            // Times of rows are rounded.
            Some(last) if last.1 && phase.since - last.0 <= chatter * (1.0 + 1e-9) => *last = end,
            _ => sticks.push(end),
        }
    }
    sticks
}

/// Instants at which each contact starts to slide up to the end of the run, in run and reference.
fn releases(evidence: &Evidence<'_>) -> Option<Vec<[Vec<f64>; 2]>> {
    let (end, chatter) = span(evidence)?;
    let of = |phases: &[FrictionPhase]| -> Vec<f64> {
        sticks(phases, chatter).into_iter().filter(|(at, slides)| *slides && *at <= end).map(|(at, _)| at).collect()
    };
    let pairs = evidence.run_friction.iter().zip(evidence.reference_friction);
    Some(pairs.map(|(run, reference)| [of(run), of(reference)]).collect())
}

fn reversals(phases: &[FrictionPhase]) -> usize {
    let (mut direction, mut count) = (None, 0);
    for phase in phases {
        match phase.state {
            ContactState::Open => direction = None,
            ContactState::Stick => (),
            slides => {
                count += usize::from(direction.is_some_and(|other| other != slides));
                direction = Some(slides);
            }
        }
    }
    count
}

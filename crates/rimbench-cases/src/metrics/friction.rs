//! What contacts with friction do, held against the reference: who sticks when.
//! Only what the run lived to see counts.

use super::contact_phase::CHATTER;
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

/// End of the run, and how long a slip may be that parts no sticks, s; none where the case has no friction or the run no interval.
fn span(evidence: &Evidence<'_>) -> Option<(f64, f64)> {
    let end = evidence.run.end_time().filter(|end| *end > 0.0 && !evidence.run_friction.is_empty())?;
    let steps = evidence.run.column(0).zip(evidence.run.column(0).skip(1)).map(|(from, to)| to - from);
    Some((end, steps.fold(CHATTER, f64::max)))
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

#[cfg(test)]
mod tests {
    use super::super::friction_phase::friction_phases;
    use super::*;
    use rimbench_core::cosim::{Outcome, Report, Trajectory};

    /// Rows at times `step` apart up to `end`; the state is that of the interval before.
    fn trajectory(step: f64, end: f64, state: impl Fn(f64) -> f64) -> Trajectory {
        let rows = (0..=(end / step).round() as usize).map(|k| k as f64 * step);
        let data = rows.flat_map(|t| [t, state(t - 0.5 * step)]).collect();
        Trajectory::from_data(["time_s", "contact_state_a"].map(str::to_owned).to_vec(), data)
    }

    fn values(run: &Trajectory, reference: &Trajectory) -> [Option<f64>; 5] {
        let phases = |trajectory: &Trajectory| vec![friction_phases(trajectory, 1)];
        let (aligned, report) = (reference.resampled(run.column(0)), Report::not_run(Outcome::Completed));
        let evidence = Evidence {
            run_friction: &phases(run),
            reference_friction: &phases(reference),
            ..Evidence::bare(run, &aligned, &report)
        };
        [WRONG_STATE, RELEASE_SHIFT_MAX, RELEASES_MISSED, STICK_INTERVALS, SLIP_REVERSALS]
            .map(|metric| (metric.compute)(&evidence))
    }

    /// Sticks up to `release`, slides forwards to 0.5 s, sticks to 0.7 s, slides back.
    fn states(release: f64) -> impl Fn(f64) -> f64 {
        move |t| match t {
            t if t < release => 1.0,
            t if t < 0.5 => 2.0,
            t if t < 0.7 => 1.0,
            _ => 3.0,
        }
    }

    #[test]
    fn a_late_release_is_shifted_and_wrong_for_as_long_as_it_is_late() {
        let reference = trajectory(1e-4, 1.0, states(0.3));
        let same = values(&reference, &reference);
        assert_eq!(same, [Some(0.0), Some(0.0), Some(0.0), Some(2.0), Some(1.0)]);
        let [wrong, shift, missed, sticks, reversals] =
            values(&trajectory(1e-2, 1.0, states(0.33)), &reference).map(Option::unwrap);
        approx::assert_relative_eq!(shift, 0.03, epsilon = 1e-9);
        approx::assert_relative_eq!(wrong, 0.03, epsilon = 1e-9);
        assert_eq!([missed, sticks, reversals], [0.0, 2.0, 1.0]);
    }

    #[test]
    fn a_contact_that_never_lets_go_has_missed_its_releases() {
        let reference = trajectory(1e-4, 1.0, states(0.3));
        let [wrong, shift, missed, sticks, reversals] = values(&trajectory(1e-2, 1.0, |_| 1.0), &reference);
        approx::assert_relative_eq!(wrong.unwrap(), 0.2 + 0.3, epsilon = 1e-9);
        assert_eq!([shift, missed, sticks, reversals], [None, Some(2.0), Some(1.0), Some(0.0)]);
        // One that ended before anything let go has missed nothing.
        let early = values(&trajectory(1e-2, 0.25, |_| 1.0), &reference);
        assert_eq!(early, [Some(0.0), None, Some(0.0), Some(1.0), Some(0.0)]);
    }

    #[test]
    fn a_flicker_parts_no_stick_and_a_flight_does() {
        let flicker = |t: f64| if (0.4..0.404).contains(&t) { 2.0 } else { 1.0 };
        let [.., sticks, reversals] = values(&trajectory(1e-3, 1.0, flicker), &trajectory(1e-3, 1.0, |_| 1.0));
        assert_eq!([sticks, reversals], [Some(1.0), Some(0.0)]);
        // Forwards, in the air, backwards: no reversal of a slip.
        let flight = |t: f64| {
            if t < 0.4 {
                2.0
            } else if t < 0.402 {
                0.0
            } else {
                3.0
            }
        };
        let [.., reversals] = values(&trajectory(1e-3, 1.0, flight), &trajectory(1e-3, 1.0, |_| 1.0));
        assert_eq!(reversals, Some(0.0));
        let hop = |t: f64| if (0.4..0.404).contains(&t) { 0.0 } else { 1.0 };
        let [.., sticks, _] = values(&trajectory(1e-3, 1.0, hop), &trajectory(1e-3, 1.0, |_| 1.0));
        assert_eq!(sticks, Some(2.0));
    }

    #[test]
    fn a_case_without_friction_has_none_of_it() {
        let plain = Trajectory::from_data(vec!["time_s".to_owned()], vec![0.0, 1.0]);
        let report = Report::not_run(Outcome::Completed);
        let evidence = Evidence::bare(&plain, &plain, &report);
        for metric in [WRONG_STATE, RELEASE_SHIFT_MAX, RELEASES_MISSED, STICK_INTERVALS, SLIP_REVERSALS] {
            assert_eq!((metric.compute)(&evidence), None, "{}", metric.name);
        }
    }
}

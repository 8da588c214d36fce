//! Contact events of a run held against those of the reference.
//!
//! An event is the closing of a contact at the start of a contact phase (see [`phases`]): several impacts in quick succession
//! are one event. Run and reference are read by the same rules with the same chatter, `max(H, 5 ms)`; the reference at its own
//! sampling. Only what the run lived to see counts: a run that ended early is compared up to its end.

use super::contact_phase::{CHATTER, ContactInterval, ContactPhase, phases};
use super::evidence::{Evidence, metrics};

/// Events further apart than this, s, are not the same event; ours.
const SAME_EVENT: f64 = 0.1;

metrics! {
    TIME_SHIFT_MAX: "event_time_shift_max_s" in "s",
    "Largest shift in time, early or late, of a contact that closes in both run and reference"
    => |evidence| {
        let matched = contacts(evidence)?.flat_map(|contact| contact.matched());
        matched.map(|(run, reference)| (run - reference).abs()).reduce(f64::max)
    };

    MISSED: "events_missed" in "-",
    "Contacts that close in the reference but not within 0.1 s in the run"
    => |evidence| {
        Some(
            contacts(evidence)?
                .map(|contact| contact.reference_events().count() - contact.matched().len())
                .sum::<usize>() as f64,
        )
    };

    WRONG_STATE: "wrong_contact_state_s" in "s",
    "Total time during which some contact is open in the run and closed in the reference, or the reverse"
    => |evidence| {
        let end = evidence.run.end_time()?;
        Some(time_of_difference(&contacts(evidence)?.collect::<Vec<_>>(), end))
    };
}

/// Times, s, within [`SAME_EVENT`] of a contact that closes: where a touch-down shows in the force, early or late.
pub(crate) fn touch_downs(contacts: &[Vec<ContactInterval>]) -> Vec<[f64; 2]> {
    let mut closings: Vec<f64> = contacts.iter().flatten().filter_map(ContactInterval::closed_at).collect();
    closings.sort_by(f64::total_cmp);
    let mut windows: Vec<[f64; 2]> = Vec::new();
    for time in closings {
        match windows.last_mut().filter(|window| window[1] >= time - SAME_EVENT) {
            Some(window) => window[1] = time + SAME_EVENT,
            None => windows.push([time - SAME_EVENT, time + SAME_EVENT]),
        }
    }
    windows
}

/// The phases of one contact up to the end of the run.
struct Contact {
    run: Vec<ContactPhase>,
    reference: Vec<ContactPhase>,
    end: f64,
}

impl Contact {
    fn run_events(&self) -> impl Iterator<Item = f64> {
        self.run.iter().filter_map(|phase| phase.closed_at)
    }

    fn reference_events(&self) -> impl Iterator<Item = f64> {
        self.reference.iter().filter_map(|phase| phase.closed_at).filter(|time| *time <= self.end)
    }

    fn matched(&self) -> Vec<(f64, f64)> {
        let [run, reference] = [self.run_events().collect::<Vec<_>>(), self.reference_events().collect()];
        matched(&run, &reference).collect()
    }
}

/// Pairs (run, reference) of events that are each other's nearest and within 0.1 s, s.
pub(super) fn matched(run: &[f64], reference: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    run.iter().filter_map(move |&event| {
        let counterpart = nearest(reference, event)?;
        let mutual = nearest(run, counterpart)? == event;
        (mutual && (event - counterpart).abs() <= SAME_EVENT).then_some((event, counterpart))
    })
}

fn nearest(events: &[f64], to: f64) -> Option<f64> {
    events.iter().copied().min_by(|a, b| (a - to).abs().total_cmp(&(b - to).abs()))
}

/// All contacts; `None` where the case has none or the run has no interval.
fn contacts<'a>(evidence: &'a Evidence<'_>) -> Option<impl Iterator<Item = Contact> + 'a> {
    let end = evidence.run.end_time().filter(|end| *end > 0.0 && !evidence.gaps.is_empty())?;
    let steps = evidence.run.column(0).zip(evidence.run.column(0).skip(1)).map(|(from, to)| to - from);
    let chatter = steps.fold(CHATTER, f64::max);
    Some(evidence.run_contacts.iter().zip(evidence.reference_contacts).map(move |(run, reference)| Contact {
        run: phases(run, chatter),
        reference: phases(reference, chatter),
        end,
    }))
}

/// Time within `[0, end]` during which the state of any contact differs, s.
fn time_of_difference(contacts: &[Contact], end: f64) -> f64 {
    // Each border of a phase toggles one state of one contact.
    let mut toggles: Vec<(f64, usize)> = Vec::new();
    for (index, contact) in contacts.iter().enumerate() {
        for phase in contact.run.iter().chain(&contact.reference) {
            toggles.extend([phase.closed_at.unwrap_or(0.0), phase.opened_at].map(|time| (time.min(end), index)));
        }
    }
    toggles.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Run and reference toggle the same flag: it is up where they differ.
    let mut differs = vec![false; contacts.len()];
    let (mut differing, mut since, mut total) = (0_usize, 0.0, 0.0);
    for (time, index) in toggles {
        if differing > 0 {
            total += time - since;
        }
        differs[index] = !differs[index];
        differing = if differs[index] { differing + 1 } else { differing - 1 };
        since = time;
    }
    total
}

#[cfg(test)]
mod tests {
    use super::super::contact_phase::contact_intervals;
    use super::*;
    use rimbench_core::cosim::{Outcome, Report, Trajectory};

    const NAMES: [&str; 3] = ["time_s", "gap_a_m", "gap_b_m"];

    /// Rows at times `step` apart up to `end`.
    fn trajectory(step: f64, end: f64, gaps: impl Fn(f64) -> [f64; 2]) -> Trajectory {
        let rows = (0..=(end / step).round() as usize).map(|k| k as f64 * step);
        let data = rows.flat_map(|t| [t, gaps(t)[0], gaps(t)[1]]).collect();
        Trajectory::from_data(NAMES.map(str::to_owned).to_vec(), data)
    }

    fn values(run: &Trajectory, reference: &Trajectory) -> [Option<f64>; 3] {
        let aligned = reference.resampled(run.column(0));
        let report = Report::not_run(Outcome::Completed);
        let evidence = Evidence {
            run_contacts: &[1, 2].map(|gap| contact_intervals(run, gap)),
            reference_contacts: &[1, 2].map(|gap| contact_intervals(reference, gap)),
            gaps: &[1, 2],
            ..Evidence::bare(run, &aligned, &report)
        };
        [TIME_SHIFT_MAX, MISSED, WRONG_STATE].map(|metric| (metric.compute)(&evidence))
    }

    /// Approaches at 0.1 m/s, closed from `from` to `to`, then leaves at 0.1 m/s.
    fn gap(t: f64, from: f64, to: f64) -> f64 {
        0.1 * (from - t).max(t - to).max(0.0)
    }

    #[test]
    fn events_are_shifted_missed_and_wrong_for_as_long_as_they_were_made() {
        let reference = trajectory(5e-5, 2.0, |t| [gap(t, 0.5, 1.0), gap(t, 1.2, 9.0)]);
        let same = values(&reference, &reference);
        assert_eq!(same, [Some(0.0), Some(0.0), Some(0.0)]);
        // 7 ms late to close, 10 ms late to open, on a grid of 5 ms; the other is 4 ms early.
        let run = trajectory(5e-3, 2.0, |t| [gap(t, 0.507, 1.01), gap(t, 1.196, 9.0)]);
        let [shift, missed, wrong] = values(&run, &reference).map(Option::unwrap);
        approx::assert_relative_eq!(shift, 7e-3, epsilon = 1e-4);
        approx::assert_relative_eq!(wrong, 7e-3 + 10e-3 + 4e-3, epsilon = 3e-4);
        assert_eq!(missed, 0.0);
        // Contact b never closes: missed, and wrong to the end; what overlaps in time counts once.
        let run = trajectory(5e-3, 2.0, |t| [gap(t, 0.5, 1.3), 1.0]);
        let [shift, missed, wrong] = values(&run, &reference).map(Option::unwrap);
        assert!(shift < 1e-4 && missed == 1.0, "{shift} {missed}");
        approx::assert_relative_eq!(wrong, 1.0, epsilon = 1e-3);
        // A run that ended before anything closed has missed nothing.
        let run = trajectory(5e-3, 0.4, |t| [gap(t, 0.5, 1.0), 1.0]);
        assert_eq!(values(&run, &reference), [None, Some(0.0), Some(0.0)]);
    }

    #[test]
    fn touch_downs_that_overlap_are_one_window() {
        let reference = trajectory(1e-3, 2.0, |t| [gap(t, 0.5, 0.9), gap(t, 0.55, 1.0).min(gap(t, 1.5, 9.0))]);
        let contacts = [1, 2].map(|gap| contact_intervals(&reference, gap)).to_vec();
        let [first, second] = touch_downs(&contacts).try_into().unwrap();
        for (value, exact) in first.into_iter().chain(second).zip([0.4, 0.65, 1.4, 1.6]) {
            approx::assert_relative_eq!(value, exact, epsilon = 1e-4);
        }
    }

    #[test]
    fn a_second_closing_does_not_steal_the_match_of_the_first() {
        let reference = trajectory(5e-5, 2.0, |t| [gap(t, 0.5, 9.0), 1.0]);
        // Bounces off at 0.52 s for 40 ms: only the first closing is the reference's.
        let run = trajectory(1e-3, 2.0, |t| [gap(t, 0.503, 0.52).min(gap(t, 0.56, 9.0)), 1.0]);
        let [shift, missed, wrong] = values(&run, &reference).map(Option::unwrap);
        approx::assert_relative_eq!(shift, 3e-3, epsilon = 1e-4);
        assert_eq!(missed, 0.0);
        approx::assert_relative_eq!(wrong, 43e-3, epsilon = 1e-3);
        // Closing 0.15 s late is not the same event.
        let run = trajectory(1e-3, 2.0, |t| [gap(t, 0.65, 9.0), 1.0]);
        let [shift, missed, wrong] = values(&run, &reference);
        assert_eq!((shift, missed), (None, Some(1.0)));
        approx::assert_relative_eq!(wrong.unwrap(), 0.15, epsilon = 1e-3);
    }
}

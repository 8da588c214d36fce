//! Contact events of a run held against those of the reference.
//!
//! An event is the closing of a contact at the start of a contact phase (see [`phases`]): several impacts in quick
//! succession are one event. Run and reference are read by the same rules with the same chatter, `max(H, 5 ms)`; the
//! reference at its own sampling. Only what the run lived to see counts: a run that ended early is compared up to its
//! end.

use super::contact_phase::{ContactInterval, ContactPhase, phases};
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
        let end = evidence.sums.end?;
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
    let end = evidence.sums.end.filter(|end| *end > 0.0 && !evidence.sums.columns.gaps.is_empty())?;
    let chatter = evidence.sums.chatter;
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
    use rimbench_core::cosim::Trajectory;

    #[test]
    fn touch_downs_that_overlap_are_one_window() {
        // Approaches at 0.1 m/s, closed from `from` to `to`, then leaves at 0.1 m/s.
        let gap = |t: f64, from: f64, to: f64| 0.1 * (from - t).max(t - to).max(0.0);
        let row = |t: f64| [t, gap(t, 0.5, 0.9), gap(t, 0.55, 1.0).min(gap(t, 1.5, 9.0))];
        let rows: Vec<[f64; 3]> = (0..=2000).map(|k| row(f64::from(k) * 1e-3)).collect();
        let names = ["time_s", "gap_a_m", "gap_b_m"].map(str::to_owned).to_vec();
        let reference = Trajectory::from_data(names, rows.concat());
        let contacts = [1, 2].map(|gap| contact_intervals(&reference, gap)).to_vec();
        let [first, second] = touch_downs(&contacts).try_into().unwrap();
        for (value, exact) in first.into_iter().chain(second).zip([0.4, 0.65, 1.4, 1.6]) {
            approx::assert_relative_eq!(value, exact, epsilon = 1e-4);
        }
    }
}

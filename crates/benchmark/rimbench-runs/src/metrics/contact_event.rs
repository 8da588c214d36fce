//! What a case with contacts is about: an event of one kind that has to happen for a run to say anything.

use super::contact_phase::{CHATTER, ContactInterval, phases};
use super::friction_phase::FrictionPhase;
use rimbench_core::friction::ContactState;

/// Something that contacts do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactEvent {
    /// A contact that was open closes.
    Closing,
    /// A contact that was closed opens, for longer than chatter takes.
    Opening,
    /// A contact with friction begins to stick.
    Sticking,
}

impl ContactEvent {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Closing, Self::Opening, Self::Sticking];

    /// Returns its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Closing => "closing",
            Self::Opening => "opening",
            Self::Sticking => "sticking",
        }
    }

    /// Tells whether it happens to one of the contacts; none where no contact could.
    pub(crate) fn happens(
        self,
        contacts: &[Vec<ContactInterval>],
        friction: &[(String, Vec<FrictionPhase>)],
    ) -> Option<bool> {
        let closed = || contacts.iter().flat_map(|contact| phases(contact, CHATTER));
        let any = match self {
            Self::Closing => closed().any(|phase| phase.closed_at.is_some()),
            Self::Opening => closed().any(|phase| phase.opened_at.is_finite()),
            // What sticks from the start does not begin to.
            Self::Sticking => friction
                .iter()
                .flat_map(|(_, phases)| phases.iter().skip(1))
                .any(|phase| phase.state == ContactState::Stick),
        };
        let possible = if self == Self::Sticking { !friction.is_empty() } else { !contacts.is_empty() };
        possible.then_some(any)
    }
}

#[cfg(test)]
mod tests {
    use super::super::contact_phase::contact_intervals;
    use super::super::friction_phase::friction_phases;
    use super::*;
    use rimbench_core::cosim::Trajectory;

    fn trajectory(values: &[f64]) -> Trajectory {
        let rows = values.iter().enumerate().flat_map(|(k, value)| [k as f64 * 1e-3, *value]).collect();
        Trajectory::from_data(vec!["time_s".to_owned(), "value".to_owned()], rows)
    }

    #[test]
    fn an_event_is_one_that_begins_within_the_run_and_is_no_chatter() {
        let of_gap = |gaps: &[f64]| {
            let contacts = [contact_intervals(&trajectory(gaps), 1)];
            [ContactEvent::Closing, ContactEvent::Opening].map(|event| event.happens(&contacts, &[]))
        };
        let (open, shut) = ([1e-3; 8], [0.0; 8]);
        assert_eq!(of_gap(&open), [Some(false); 2]);
        // Closed from the start is no closing, and a rattle of 2 ms neither that nor an opening.
        assert_eq!(of_gap(&shut), [Some(false); 2]);
        assert_eq!(of_gap(&[shut.as_slice(), &[1e-3; 2], &shut].concat()), [Some(false); 2]);
        assert_eq!(of_gap(&[open, shut].concat()), [Some(true), Some(false)]);
        assert_eq!(of_gap(&[shut, open].concat()), [Some(false), Some(true)]);
        assert_eq!(of_gap(&[shut, open, shut].concat()), [Some(true); 2]);
        let [slip, stick] = [ContactState::SlipPositive, ContactState::Stick].map(ContactState::as_number);
        let sticks = |states: &[f64]| {
            let friction = [(String::new(), friction_phases(&trajectory(states), 1))];
            ContactEvent::Sticking.happens(&[], &friction)
        };
        assert_eq!(
            [[slip, slip], [stick, slip], [slip, stick]].map(|states| sticks(&states)),
            [Some(false), Some(false), Some(true)]
        );
        assert_eq!(ContactEvent::ALL.map(|event| event.happens(&[], &[])), [None; 3]);
    }
}

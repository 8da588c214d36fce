//! A reduced interface model as received, and as it stands within the macro step: frozen or extrapolated.

use super::model_options::ModelMotion;
use crate::cosim::MicroStep;
use crate::interface_model::ReducedInterfaceModel;

/// The model between two communication points.
///
/// ```text
/// extrapolated    H(t) = H_k + (t − t_k) (H_k − H_{k−1})/(t_k − t_{k−1})        a(t) alike
/// frozen          H(t) = H_k
/// ```
/// A model whose closed contacts, or with friction their states, differ from those of the one before stays frozen.
#[derive(Clone)]
pub(super) struct MovingModel {
    motion: ModelMotion,
    /// As received.
    pub(super) received: ReducedInterfaceModel,
    /// As it is used in the present micro step, where that is another.
    current: ReducedInterfaceModel,
    apart: bool,
    received_at: f64,
    /// By how much the macro step starts after the sample, s: a late one is brought to the present over several.
    ahead: f64,
    /// Rates of `H` and `a`; used only where `extrapolating`.
    h_rate: Vec<f64>,
    a_rate: Vec<f64>,
    extrapolating: bool,
}

impl MovingModel {
    /// Makes room for models like `empty`; none has been received yet.
    pub(super) fn new(empty: &ReducedInterfaceModel, motion: ModelMotion) -> Self {
        MovingModel {
            motion,
            received: empty.clone(),
            current: empty.clone(),
            apart: false,
            received_at: f64::NAN,
            ahead: 0.0,
            h_rate: vec![0.0; empty.h.len()],
            a_rate: vec![0.0; empty.a.len()],
            extrapolating: false,
        }
    }

    /// Takes a model as it is at `time` (s).
    pub(super) fn receive(&mut self, time: f64, model: &ReducedInterfaceModel) {
        // A late sample that is used again keeps the rates that it had.
        if time != self.received_at {
            self.extrapolating =
                self.motion == ModelMotion::Extrapolated && self.take_rates(time - self.received_at, model);
        }
        self.received.copy_from(model);
        (self.received_at, self.ahead, self.apart) = (time, 0.0, false);
        if self.motion == ModelMotion::Extrapolated {
            self.lend();
        }
    }

    /// Returns the model as it is used in the present micro step.
    #[inline]
    pub(super) fn current(&self) -> &ReducedInterfaceModel {
        if self.apart { &self.current } else { &self.received }
    }

    /// Lends the model as received, and that of the present micro step to be changed.
    pub(super) fn lend(&mut self) -> (&ReducedInterfaceModel, &mut ReducedInterfaceModel) {
        if !self.apart {
            self.current.copy_from(&self.received);
            self.apart = true;
        }
        (&self.received, &mut self.current)
    }

    /// Goes on in the macro step that starts at `time` (s).
    pub(super) fn go_on_from(&mut self, time: f64) {
        self.ahead = time - self.received_at;
    }

    /// Differences of the last two models, and whether they can be gone on with: not if a contact has opened or closed.
    fn take_rates(&mut self, elapsed: f64, model: &ReducedInterfaceModel) -> bool {
        // Rows that now stand for other contacts have no rate.
        let same = self.received.same_contacts(model)
            && self.received.at_bound == model.at_bound
            && self.received.states == model.states;
        if !(elapsed > 0.0 && same) {
            return false;
        }
        self.h_rate.resize(model.h.len(), 0.0);
        let rates = [(&mut self.h_rate, &model.h, &self.received.h), (&mut self.a_rate, &model.a, &self.received.a)];
        for (rate, now, before) in rates {
            for (rate, (now, before)) in rate.iter_mut().zip(now.iter().zip(before)) {
                *rate = (now - before) / elapsed;
            }
        }
        true
    }

    /// Tells whether the model stays as it was received.
    pub(super) fn stays(&self) -> bool {
        self.motion == ModelMotion::Frozen
    }

    /// Lets the model stand still until the next one arrives.
    pub(super) fn freeze(&mut self) {
        self.extrapolating = false;
    }

    /// Brings the model to the middle of a micro step; says whether it has moved.
    #[inline]
    pub(super) fn move_to(&mut self, at: MicroStep) -> bool {
        self.motion == ModelMotion::Extrapolated && self.moves_to(at)
    }

    #[inline(never)]
    fn moves_to(&mut self, at: MicroStep) -> bool {
        if self.extrapolating {
            self.extrapolate(self.ahead + at.since_exchange + 0.5 * at.length);
        }
        self.extrapolating
    }

    fn extrapolate(&mut self, since: f64) {
        let parts = [
            (&mut self.current.h, &self.received.h, &self.h_rate),
            (&mut self.current.a, &self.received.a, &self.a_rate),
        ];
        for (current, received, rate) in parts {
            for (current, (received, rate)) in current.iter_mut().zip(received.iter().zip(rate)) {
                *current = received + since * rate;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_contact::friction::ContactState;

    /// A micro step whose middle is 50 ms after the communication point.
    const MIDDLE: MicroStep = MicroStep { index: 2, count: 5, length: 0.02, start: 0.14, since_exchange: 0.04 };

    /// One contact with friction, one interface row.
    fn model(entry: f64, state: ContactState) -> ReducedInterfaceModel {
        let mut model = ReducedInterfaceModel::zeros_with_friction(&[0.5], 1);
        model.h.fill(entry);
        model.states[0] = state;
        model
    }

    #[test]
    fn a_model_whose_rows_stand_for_other_contacts_than_before_is_not_gone_on_with() {
        let model = |entry: f64| {
            let mut model = ReducedInterfaceModel::zeros(1, 1);
            model.h.fill(entry);
            model
        };
        let mut moving = MovingModel::new(&model(0.0), ModelMotion::Extrapolated);
        moving.receive(0.0, &model(1.0));
        moving.receive(0.1, &model(2.0));
        assert!(moving.move_to(MIDDLE));
        let mut other = model(3.0);
        other.set_contacts(1);
        moving.receive(0.2, &other);
        assert!(!moving.move_to(MIDDLE));
        moving.receive(0.3, &other);
        assert!(moving.move_to(MIDDLE));
    }

    #[test]
    fn a_late_model_goes_on_from_its_sample_and_keeps_its_rates_when_it_is_used_again() {
        let mut moving = MovingModel::new(&model(0.0, ContactState::Open), ModelMotion::Extrapolated);
        moving.receive(0.0, &model(1.0, ContactState::Stick));
        for _ in 0..2 {
            moving.receive(0.1, &model(2.0, ContactState::Stick));
            moving.go_on_from(0.4);
            assert!(moving.move_to(MIDDLE));
            // 0.3 s to the macro step, 0.05 s in it.
            assert!((moving.current.h[0] - 5.5).abs() < 1e-14, "{}", moving.current.h[0]);
        }
    }

    #[test]
    fn a_model_with_friction_must_go_on_while_the_mechanics_says_the_same_of_its_contacts() {
        let mut moving = MovingModel::new(&model(0.0, ContactState::Open), ModelMotion::Extrapolated);
        moving.receive(0.0, &model(1.0, ContactState::Stick));
        moving.receive(0.1, &model(2.0, ContactState::Stick));
        assert!(moving.move_to(MIDDLE));
        assert!((moving.current.h[0] - 2.5).abs() < 1e-15);
        moving.receive(0.2, &model(3.0, ContactState::SlipPositive));
        assert!(!moving.move_to(MIDDLE), "the mechanics says that it slides now");
    }
}

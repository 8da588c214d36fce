//! Contacts that act over the mechanics' own step: the own-step model.
//!
//! The mechanics takes n steps of length h per macro step. To a force λ during all of such a step it answers with the
//! velocity Φ(λ), by the contact law of Eq. 4 over h instead of δ, from where it stands at the start of the step. Each
//! micro step takes its share of the answer to its own force, and at the end of the part of the macro step the model is
//! where the mechanics will be under the mean force:
//!
//! ```text
//! w ← w + (δ/h) (Φ(λ) − w_s)        s = s_s + t w                t after the start of a part
//! w_s ← Φ(λ̄)   w ← w_s              s_s ← s_s + h w_s   g ← g + h w_c     at its end
//! ```
//! The mechanics moves by `h Φ(λ̄)`, and the model ends where it does.
//!
//! While the set of contacts that push stays, Φ is affine: a micro step is one multiply-add for each row of the
//! interface, and a look at the region of the forces, a range where it has one row. Where velocity is not linear over
//! the step, what is left of it goes by micro steps: where friction, and not a stop or the actuator, ends a slip, turns
//! it, or changes as a contact begins or ceases to stick, slide or push, and where the set has changed in most steps of
//! the mechanics of late.
//! # Source
//! `docs/method/own-step.md`

use super::super::model_contacts::{FrozenModel, ModelContacts, ModelState};
use super::ReducedInterface;
use super::gap_law::GapTerm;
use super::targets::Targets;
use crate::cosim::{MicroStep, overlaps};
use crate::error::Failure;
use crate::interface_model::TOUCHING;
use rimbench_contact::affine_step::{DiscretisedModel, ForceRegion, StepContactLaw};

/// What remains of a slip that goes on, at least.
const GOES_ON: f64 = 0.5;

/// What friction may do to a slip that changes, of the change, at least: as much as all else.
const OF_ITS_SIZE: f64 = 0.5;

/// A step by itself, after which the affine step looks at all contacts.
const ALONE: MicroStep = MicroStep { index: 0, count: 1, length: 0.0, start: 0.0, since_exchange: 0.0 };

/// The part of the macro step in which the model is, and how far it has come in it.
#[derive(Clone)]
pub(super) struct OwnStep {
    /// n, and h in s.
    steps: usize,
    length: f64,
    /// The micro steps of the macro step, those taken, and the part that the last one fell into.
    micro_steps: usize,
    taken: usize,
    part: usize,
    course: Course,
    /// What contacts do in the last answer that was solved (an affine one leaves that as it is), of which of them that
    /// has changed, and by which impulses they push, N·s.
    doing: Vec<Doing>,
    differ: Vec<bool>,
    pushed: Vec<f64>,
    /// In how many parts of the macro step that has changed, and how many macro steps there are without a break up to
    /// the last in each of which it has in most parts.
    parts_changed: usize,
    unsteady: usize,
    /// `Σ σ` over the micro steps of the part that are not on the present region, σ the share of each.
    elapsed: f64,
    /// Velocity of the interface, m/s.
    w: Vec<f64>,
    /// `Σ σ λ` over them: with the others, at its end, the mean force, N.
    mean: Vec<f64>,
    /// `Σ σ` and `Σ σ λ` over those on the present region.
    share: f64,
    forces: Vec<f64>,
    /// By how much those before have changed the contacts' velocities, m/s.
    changes: Vec<f64>,
    /// Forces that keep the active set, with their answer.
    region: ForceRegion,
    /// Micro steps that were one multiply-add.
    multiples: u64,
    micro: MicroSteps,
    /// Positions at the start of the part, m.
    start: Vec<f64>,
    /// By how much rebounds change what is added to them, in the last answer and by the shares of all so far, m.
    rebound: Box<[f64]>,
    rebounds: Vec<f64>,
}

/// How a part goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Course {
    /// No force has been answered yet.
    Ahead,
    /// By answers over the whole step of the mechanics: whether a contact is hit in the last one, where contacts
    /// rebound, and whether contacts do something else than in the first.
    OverStep { hit: bool, changed: bool },
    /// What is left of it by micro steps.
    ByMicroSteps,
}

/// What came of a force that was answered.
enum Answer {
    /// It is affine in the force.
    Affine,
    Solved,
    /// Velocity is no longer linear over the step: what is left of it is to go by micro steps.
    Bent,
}

/// Unsteady macro steps on end from which a change is answered by micro steps.
const UNSTEADY: usize = 2;

/// What a contact does in an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Doing {
    Nothing,
    Pushing,
    Sliding,
}

/// Eq. 4 over a micro step; since a model has arrived there is none while the length is not a number.
#[derive(Clone)]
struct MicroSteps {
    length: f64,
    discretised: DiscretisedModel,
    law: StepContactLaw,
}

/// The contacts of the model over the mechanics' own step. `state` holds `w` and gaps at the start of the part, and
/// `w⁺` of the last answer.
pub(super) struct StepContacts<'a> {
    frozen: FrozenModel<'a>,
    contacts: &'a mut ModelContacts,
    state: &'a mut ModelState,
    gap_term: GapTerm,
    targets: &'a mut Targets,
}

impl OwnStep {
    /// Makes room for so many contacts, their rows, and rows of the interface.
    pub(super) fn new(discretised: &DiscretisedModel, (contacts, rows, interface): (usize, usize, usize)) -> Self {
        let of_interface = || vec![0.0; interface];
        OwnStep {
            steps: 1,
            length: f64::NAN,
            micro_steps: 0,
            taken: 0,
            part: 0,
            course: Course::Ahead,
            doing: vec![Doing::Nothing; contacts],
            differ: vec![false; contacts],
            pushed: vec![0.0; contacts],
            parts_changed: 0,
            unsteady: 0,
            elapsed: 0.0,
            w: of_interface(),
            mean: of_interface(),
            share: 0.0,
            forces: of_interface(),
            changes: vec![0.0; rows],
            region: ForceRegion::new(rows, interface),
            multiples: 0,
            micro: MicroSteps { length: f64::NAN, discretised: discretised.clone(), law: StepContactLaw::default() },
            start: of_interface(),
            rebound: of_interface().into(),
            rebounds: of_interface(),
        }
    }

    /// Divides a macro step of `length` (s) into the mechanics' own steps, and returns theirs.
    pub(super) fn set_steps(&mut self, length: f64, steps: usize) -> f64 {
        (self.steps, self.length) = (steps, length / steps as f64);
        (self.micro_steps, self.taken, self.micro.length) = (0, 0, f64::NAN);
        self.length
    }

    /// Starts part `part` from `state.position` and `state.w_plus`, which has so many contact rows.
    pub(super) fn start_part(&mut self, state: &mut ModelState, contact_rows: usize, part: usize) {
        if part == 0 {
            let is_unsteady = self.parts_changed > 0 && 2 * self.parts_changed >= self.steps;
            self.unsteady = if is_unsteady { self.unsteady + 1 } else { 0 };
            self.parts_changed = 0;
        }
        std::mem::swap(&mut state.w, &mut state.w_plus);
        self.w.copy_from_slice(&state.w[contact_rows..contact_rows + self.mean.len()]);
        self.start.copy_from_slice(&state.position);
        (self.part, self.course) = (part, Course::Ahead);
        self.region.clear();
        (self.share, self.elapsed) = (0.0, 0.0);
        for sums in [&mut self.mean, &mut self.forces, &mut self.changes, &mut self.rebounds] {
            sums.fill(0.0);
        }
    }

    /// Returns the number of micro steps that were one multiply-add.
    pub(super) fn multiples(&self) -> u64 {
        self.multiples
    }

    /// Returns the time that gaps are behind velocities at the end of the macro step, s.
    pub(super) fn gaps_behind(&self) -> f64 {
        if self.course == Course::ByMicroSteps { 0.0 } else { self.length }
    }

    /// Tells whether positions are where the part's start and the present velocity lead: with an engine's rows, whose
    /// sets change in most of its steps, as well where micro steps are taken. By their own path laws of position would
    /// correct the difference at each exchange.
    #[inline(always)]
    fn moves_with_end(&self, of: &StepContacts<'_>) -> bool {
        self.course != Course::ByMicroSteps || of.frozen.received.has_targets
    }

    /// Takes a micro step wholly inside the part that keeps the active set, from the velocities `start` of the
    /// interface at the start of the part; false where it is to be taken in another way.
    #[inline(always)]
    fn multiply(&mut self, start: &[f64], lambda: &[f64]) -> bool {
        if !self.region.contains(lambda) || (self.taken + 1) * self.steps > (self.part + 1) * self.micro_steps {
            return false;
        }
        let share = self.steps as f64 / self.micro_steps as f64;
        self.share += share;
        for (i, force) in lambda.iter().enumerate() {
            self.w[i] += share * (self.region.velocity(i, lambda) - start[i]);
            self.forces[i] += share * force;
        }
        self.multiples += 1;
        true
    }

    /// Takes a micro step by its pieces in the mechanics' own steps.
    #[inline(never)]
    fn step(&mut self, mut of: StepContacts<'_>, lambda: &[f64], at: MicroStep) -> Result<(), Failure> {
        if self.taken == self.micro_steps {
            // A model that is run forward goes on with the next macro step.
            self.end_macro_step(&mut of)?;
            self.micro_steps = at.count;
        }
        for (part, overlap) in overlaps(self.taken, self.micro_steps, self.steps) {
            if part != self.part {
                self.end_part(&mut of, part)?;
            }
            let share = overlap as f64 / self.micro_steps as f64;
            if self.course == Course::Ahead {
                self.begin(&mut of, lambda)?;
            }
            self.take(&mut of, share, lambda)?;
        }
        Ok(())
    }

    /// Finds out how a part goes whose first force is `lambda` (N).
    fn begin(&mut self, of: &mut StepContacts<'_>, lambda: &[f64]) -> Result<(), Failure> {
        if let Answer::Affine = self.answer(of, lambda)? {
            self.course = Course::OverStep { hit: false, changed: false };
        }
        if of.ends_a_slip(&self.pushed, lambda, self.length) {
            self.go_by_micro_steps(of);
        }
        Ok(())
    }

    /// Leaves the rest of the part to micro steps, from where its contacts are.
    #[cold]
    fn go_by_micro_steps(&mut self, of: &mut StepContacts<'_>) {
        let StepContacts { contacts, state, frozen, targets, .. } = of;
        let n = frozen.discretised.contacts();
        self.course = Course::ByMicroSteps;
        self.write_contacts(state, n);
        state.w_plus[n..n + self.w.len()].copy_from_slice(&self.w);
        if targets.is_on() {
            // From here micro steps ask for their share each: what was asked for beforehand is taken back.
            targets.add_more(-(1.0 - self.elapsed) * self.length, &mut state.w_plus[..n]);
        }
        let half = 0.5 * self.elapsed * frozen.law.gap_step;
        let velocities = state.w.iter().zip(&state.w_plus[..n]);
        state.gap.iter_mut().zip(velocities).for_each(|(gap, (w, w_plus))| *gap += half * (w + w_plus));
        contacts.leave_region(frozen.law, state);
    }

    /// Adds the impulses of the part so far, those of the answer to the mean force until now.
    #[cold]
    fn push_so_far(&mut self, of: &mut StepContacts<'_>) -> Result<(), Failure> {
        if self.elapsed > 0.0 {
            let mean: Vec<f64> = self.mean.iter().map(|sum| sum / self.elapsed).collect();
            let law = self.trial_law(of.frozen.law);
            of.contacts.try_solve(FrozenModel { law: &law, ..of.frozen }, of.state, &mean)?;
            of.targets.add_impulses(self.elapsed * self.length, self.elapsed, &of.state.impulses);
        }
        Ok(())
    }

    /// Writes the answer to the force `lambda` (N), which leaves positions as they are.
    fn answer(&mut self, of: &mut StepContacts<'_>, lambda: &[f64]) -> Result<Answer, Failure> {
        let law = self.trial_law(of.frozen.law);
        let StepContacts { contacts, state, frozen, .. } = of;
        std::mem::swap(&mut state.position, &mut self.rebound);
        state.position.fill(0.0);
        if contacts.step_in_region(frozen.discretised, &law, state, lambda, ALONE) {
            std::mem::swap(&mut state.position, &mut self.rebound);
            return Ok(Answer::Affine);
        }
        self.leave_region(contacts, state, frozen.discretised.contacts());
        let hit = contacts.try_solve(FrozenModel { law: &law, ..*frozen }, state, lambda)?;
        std::mem::swap(&mut state.position, &mut self.rebound);
        Ok(self.record(of, lambda, hit))
    }

    /// Records what contacts do in an answer in which one is `hit` or none.
    fn record(&mut self, of: &mut StepContacts<'_>, lambda: &[f64], hit: bool) -> Answer {
        let (m, rows) = of.contacts_and_rows();
        let (begun, mut changed) = (self.course != Course::Ahead, false);
        for (contact, doing) in self.doing[..m].iter_mut().enumerate() {
            let now = if of.state.impulses[contact] <= 0.0 {
                Doing::Nothing
            } else if rows > 1 && of.slip(contact, &of.state.w_plus, &of.state.w_plus) > slip_of_rest(self.length) {
                Doing::Sliding
            } else {
                Doing::Pushing
            };
            self.differ[contact] = begun && *doing != now;
            changed |= self.differ[contact];
            *doing = now;
        }
        for (pushed, impulse) in self.pushed.iter_mut().zip(&of.state.impulses[..m]) {
            *pushed = impulse.max(*pushed);
        }
        let before = matches!(self.course, Course::OverStep { changed: true, .. });
        self.parts_changed += usize::from(changed && !before);
        self.course = Course::OverStep { hit, changed: before || changed };
        let (pushed, differ) = (&self.pushed, &self.differ);
        let bends = changed && rows > 1 && of.friction_bends(pushed, lambda, self.length, |_, contact| differ[contact]);
        self.pushed.iter_mut().zip(&of.state.impulses[..m]).for_each(|(pushed, impulse)| *pushed = *impulse);
        if bends || changed && self.unsteady >= UNSTEADY { Answer::Bent } else { Answer::Solved }
    }

    /// Takes a share of the mechanics' own step under the force `lambda` (N).
    fn take(&mut self, of: &mut StepContacts<'_>, share: f64, lambda: &[f64]) -> Result<(), Failure> {
        if self.course == Course::ByMicroSteps {
            return self.take_micro_step(of, share, lambda);
        }
        let answer = self.answer(of, lambda)?;
        if let Answer::Bent = answer {
            if of.targets.is_on() {
                self.push_so_far(of)?;
            }
            self.go_by_micro_steps(of);
            return self.take_micro_step(of, share, lambda);
        }
        let StepContacts { contacts, state, frozen, .. } = of;
        let n = frozen.discretised.contacts();
        for (rebounds, rebound) in self.rebounds.iter_mut().zip(&self.rebound) {
            *rebounds += share * rebound;
        }
        for (w, (answer, start)) in self.w.iter_mut().zip(state.w_plus[n..].iter().zip(&state.w[n..])) {
            *w += share * (answer - start);
        }
        if let Answer::Solved = answer {
            self.elapsed += share;
            self.mean.iter_mut().zip(lambda).for_each(|(sum, force)| *sum += share * force);
            self.add_changes(share, state, n);
            return Ok(());
        }
        self.share += share;
        self.forces.iter_mut().zip(lambda).for_each(|(sum, force)| *sum += share * force);
        let law = self.trial_law(frozen.law);
        contacts.find_force_region(FrozenModel { law: &law, ..*frozen }, state, lambda, &mut self.region);
        Ok(())
    }

    /// Takes a micro step of Eq. 4, or the piece of one that lies in this part.
    #[cold]
    fn take_micro_step(&mut self, of: &mut StepContacts<'_>, share: f64, lambda: &[f64]) -> Result<(), Failure> {
        let StepContacts { contacts, state, frozen, gap_term, targets } = of;
        let FrozenModel { set, received, .. } = *frozen;
        let (length, micro) = (share * self.length, &mut self.micro);
        if micro.length != length {
            contacts.leave_region(&micro.law, state);
            micro.discretised.discretise(received.linear(), contacts.rows(set), length);
            if let Some(spring) = received.spring {
                let opening_time = gap_term.opening_time(received, length);
                micro.discretised.regularise(set.len(), spring.diagonal(length, opening_time));
            }
            (micro.length, micro.law) = (length, gap_term.law(received, length));
        }
        let MicroSteps { discretised, law, .. } = &*micro;
        std::mem::swap(&mut state.w, &mut state.w_plus);
        let n = discretised.contacts();
        if targets.is_on() {
            targets.add_more(length, &mut state.w[..n]);
        }
        if !contacts.step_in_region(discretised, law, state, lambda, ALONE) {
            contacts.solve(FrozenModel { discretised, law, ..*frozen }, state, lambda)?;
        }
        if targets.is_on() {
            targets.add_impulses(length, 1.0, &state.impulses[..n]);
        }
        self.w.copy_from_slice(&state.w_plus[n..n + lambda.len()]);
        add_travel(&mut state.position, length, &self.w);
        Ok(())
    }

    /// Ends a part where the mechanics' own step ends under the mean force, or where its micro steps have come to, and
    /// starts another.
    fn end_part(&mut self, of: &mut StepContacts<'_>, next: usize) -> Result<(), Failure> {
        let StepContacts { contacts, state, frozen, targets, .. } = of;
        let n = frozen.discretised.contacts();
        if self.course == Course::ByMicroSteps {
            contacts.leave_region(&self.micro.law, state);
            if frozen.received.has_targets {
                state.position.copy_from_slice(&self.start);
                add_travel(&mut state.position, self.length, &self.w);
            }
            self.renew(targets, state, n);
            self.start_part(state, n, next);
            return Ok(());
        }
        let law = self.trial_law(frozen.law);
        self.leave_region(contacts, state, n);
        state.position.copy_from_slice(&self.start);
        if contacts.step_in_region(frozen.discretised, &law, state, &self.mean, ALONE) {
            let step = frozen.law.gap_step;
            state.gap.iter_mut().zip(&state.w_plus[..n]).for_each(|(gap, w)| *gap += step * w);
        } else {
            contacts.solve(*frozen, state, &self.mean)?;
        }
        add_travel(&mut state.position, self.length, &state.w_plus[n..]);
        if targets.is_on() {
            targets.add_impulses(self.length, 1.0, &state.impulses[..n]);
            self.renew(targets, state, n);
        }
        self.start_part(state, n, next);
        Ok(())
    }

    /// Takes the targets of the next step of the engine, all that they ask for at its start.
    fn renew(&self, targets: &mut Targets, state: &mut ModelState, contact_rows: usize) {
        if targets.is_on() {
            targets.end_step(&mut state.w_plus[..contact_rows]);
            targets.add_more(self.length, &mut state.w_plus[..contact_rows]);
        }
    }

    /// Ends a macro step, if one has begun, of a model that is run forward over several.
    fn end_macro_step(&mut self, of: &mut StepContacts<'_>) -> Result<(), Failure> {
        if self.taken > 0 {
            self.end_part(of, 0)?;
            self.taken = 0;
        }
        Ok(())
    }

    /// Returns the contact law of a trial from the start of the part: gaps stay, and where no contact is hit none
    /// rebounds.
    fn trial_law(&self, law: &StepContactLaw) -> StepContactLaw {
        let rebounds = matches!(self.course, Course::Ahead | Course::OverStep { hit: true, .. });
        let restitution = if rebounds { law.restitution } else { 0.0 };
        StepContactLaw { gap_step: 0.0, restitution, ..*law }
    }

    /// Adds up what the micro steps on the present region did: the mean of answers that are affine is the answer to the
    /// mean.
    fn leave_region(&mut self, contacts: &ModelContacts, state: &mut ModelState, contact_rows: usize) {
        self.region.clear();
        if self.share > 0.0 {
            for (mean, force) in self.mean.iter_mut().zip(&mut self.forces) {
                *mean += *force;
                *force /= self.share;
            }
            contacts.velocities_with_set(state, &self.forces);
            self.add_changes(self.share, state, contact_rows);
            self.elapsed += self.share;
            self.share = 0.0;
            self.forces.fill(0.0);
        }
    }

    /// Writes the velocities that contacts have by now.
    fn write_contacts(&self, state: &mut ModelState, contact_rows: usize) {
        let start = state.w.iter().zip(&self.changes);
        state.w_plus[..contact_rows].iter_mut().zip(start).for_each(|(w_plus, (w, change))| *w_plus = w + change);
    }

    fn add_changes(&mut self, share: f64, state: &ModelState, contact_rows: usize) {
        let answers = state.w_plus[..contact_rows].iter().zip(&state.w);
        self.changes.iter_mut().zip(answers).for_each(|(change, (answer, w))| *change += share * (answer - w));
    }
}

impl StepContacts<'_> {
    /// The contacts of the set, and the rows of each.
    fn contacts_and_rows(&self) -> (usize, usize) {
        let rows = self.contacts.rows_of_contact();
        (self.frozen.discretised.contacts() / rows, rows)
    }

    /// The product of the slips of a contact in two vectors of velocities, m²/s².
    fn slip(&self, contact: usize, w: &[f64], other: &[f64]) -> f64 {
        let (m, rows) = self.contacts_and_rows();
        (1..rows).map(|axis| axis * m + contact).map(|row| w[row] * other[row]).sum()
    }

    /// Tells whether friction ends or turns a slip, by impulses `pushed` (N·s), within the step of `length` (s) that was
    /// answered under `lambda` (N); in space it turns every one, from step to step by little, which adds up.
    fn ends_a_slip(&mut self, pushed: &[f64], lambda: &[f64], length: f64) -> bool {
        let rows = self.contacts_and_rows().1;
        let ends = |of: &Self, contact: usize| {
            let before = of.slip(contact, &of.state.w, &of.state.w);
            let goes_on = rows == 2 && of.slip(contact, &of.state.w, &of.state.w_plus) >= GOES_ON * before;
            pushed[contact] > 0.0 && before > slip_of_rest(length) && !goes_on
        };
        rows > 1 && self.friction_bends(pushed, lambda, length, ends)
    }

    /// Tells whether friction, by impulses `pushed` (N·s), bends the slip of one of these contacts in the step of
    /// `length` (s) that was answered under `lambda` (N).
    fn friction_bends(
        &mut self,
        pushed: &[f64],
        lambda: &[f64],
        length: f64,
        which: impl Fn(&Self, usize) -> bool,
    ) -> bool {
        let bent = |of: &Self, contact: usize| which(of, contact) && of.may_bend(contact, pushed, length);
        let m = self.contacts_and_rows().0;
        (0..m).any(|contact| bent(self, contact)) && {
            let found = self.contacts.solve_without_friction(self.frozen, self.state, lambda);
            (0..m).any(|contact| bent(self, contact) && (!found || self.bends(contact, length)))
        }
    }

    /// Tells whether what friction may do to the slip of a contact, `Σ_j |H_tj| μ_j P_j`, is of the size of its change.
    fn may_bend(&self, contact: usize, pushed: &[f64], length: f64) -> bool {
        let ((m, rows), StepContacts { frozen, state, .. }) = (self.contacts_and_rows(), self);
        let (h, received) = (frozen.discretised.h_uu(), frozen.received);
        let [mut slip, mut change, mut most] = [0.0_f64; 3];
        for row in (1..rows).map(|axis| axis * m + contact) {
            let (w, w_plus) = (state.w[row], state.w_plus[row]);
            slip += (w * w).max(w_plus * w_plus);
            change += (w_plus - w).powi(2);
            let of = |(other, pushed): (usize, &f64)| {
                let own = received.friction[frozen.set[other]];
                let friction = received.stiction.map_or(own, |stiction| stiction.at_rest.max(own));
                let mobility = (1..rows).map(|axis| h[row * rows * m + axis * m + other].abs()).sum::<f64>();
                mobility * friction * pushed
            };
            most += pushed[..m].iter().enumerate().map(of).sum::<f64>().powi(2);
        }
        slip > slip_of_rest(length) && most >= OF_ITS_SIZE * OF_ITS_SIZE * change
    }

    /// Tells whether the slip of a contact is another one without friction. Where a stop ends it, it is the same.
    fn bends(&self, contact: usize, length: f64) -> bool {
        let ((m, rows), bare) = (self.contacts_and_rows(), self.contacts.velocities_without_friction());
        let apart = |row: usize| (self.state.w_plus[row] - bare[row]).powi(2);
        (1..rows).map(|axis| apart(axis * m + contact)).sum::<f64>() > slip_of_rest(length)
    }
}

/// Adds to positions (m) what velocities `w` (m/s) give in `time` (s).
fn add_travel(position: &mut [f64], time: f64, w: &[f64]) {
    position.iter_mut().zip(w).for_each(|(position, w)| *position += time * w);
}

/// The square of the slip, m²/s², that within a step of `length` (s) goes no farther than contacts that touch are
/// apart.
fn slip_of_rest(length: f64) -> f64 {
    (TOUCHING / length).powi(2)
}

impl ReducedInterface {
    /// Writes the input of the actuator in a micro step under the force `lambda` (N), where contacts act over the
    /// mechanics' own step.
    ///
    /// # Errors
    /// As the contact solver reports.
    #[inline]
    pub(super) fn input_over_own_step(&mut self, at: MicroStep, lambda: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let Some((own, of)) = self.own_step() else { return Ok(()) };
        let n = of.frozen.discretised.contacts();
        if !own.multiply(&of.state.w[n..], lambda) {
            own.step(of, lambda, at)?;
            if at.index == 0 {
                self.record_first_step();
            }
        }
        let Some((own, of)) = self.own_step() else { return Ok(()) };
        own.taken += 1;
        let (u_position, u_velocity) = u.split_at_mut(lambda.len());
        if own.moves_with_end(&of) {
            // s⁺ = s_s + t w_i⁺
            let since = own.taken as f64 * at.length - own.part as f64 * own.length;
            for (i, w) in own.w.iter().enumerate() {
                of.state.position[i] = own.start[i] + own.rebounds[i] + since * w;
            }
        }
        u_position.copy_from_slice(&of.state.position);
        u_velocity.copy_from_slice(&own.w);
        Ok(())
    }

    /// Brings the contacts to where the last micro step ends.
    pub(super) fn bring_contacts_up_to_date(&mut self) {
        let Some((own, StepContacts { contacts, state, frozen, .. })) = self.own_step() else { return };
        if own.course != Course::ByMicroSteps {
            let n = frozen.discretised.contacts();
            own.leave_region(contacts, state, n);
            own.write_contacts(state, n);
        }
    }

    /// Ends a macro step of a model that is run forward over several.
    ///
    /// # Errors
    /// As the contact solver reports.
    pub(super) fn end_own_steps(&mut self) -> Result<(), Failure> {
        match self.own_step() {
            Some((own, mut of)) => own.end_macro_step(&mut of),
            None => Ok(()),
        }
    }

    #[inline(always)]
    fn own_step(&mut self) -> Option<(&mut OwnStep, StepContacts<'_>)> {
        let ReducedInterface { own, discretised, law, set, model, contacts, state, gap_term, targets, .. } = self;
        let frozen = FrozenModel { discretised, law, set: set.contacts(), received: &model.received };
        Some((own.as_deref_mut()?, StepContacts { frozen, contacts, state, gap_term: *gap_term, targets }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_rests_that_goes_no_farther_within_a_step_than_contacts_that_touch_are_apart() {
        for length in [1e-4, 1e-3, 5e-2] {
            let rests = |part: f64| (part * TOUCHING / length).powi(2) <= slip_of_rest(length);
            assert!(rests(0.99) && !rests(1.01), "{length} s");
        }
    }
}

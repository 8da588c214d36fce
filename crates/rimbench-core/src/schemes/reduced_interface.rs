//! The actuator moves together with a reduced interface model of the mechanics: what all RIM schemes share.
//!
//! At each communication point the model `H, a, w, g` arrives and is frozen (or moves). In each micro step δ the
//! actuator's own force λ drives the model, and the model answers with the interface velocity and position:
//!
//! ```text
//! w_u⁺ = w_u + δ a_u + H_uu P_u + δ H_ui λ        w_i⁺ = w_i + δ a_i + H_iu P_u + δ H_ii λ        s⁺ = s + δ w_i⁺
//! ```
//! The schemes differ in one decision only, [`Contacts`]: what `P_u` is. Which contacts there are is [`ContactDetection`]'s.

use super::active_contacts::ActiveContacts;
use super::construction::{Construction, ModelConstruction, sent};
use super::contact_detection::{ContactDetection, DetectionRule};
use super::entry::{Family, SchemeEntry};
use super::force_following::ForceFollowing;
use super::frictional_set::FrictionalSet;
use super::model_options::ModelMotion;
use super::moving_model::MovingModel;
use super::need::Need;
use super::packed_model::PackedModel;
use super::parametric_step::{GapMotion, MicroState, ParametricStep};
use crate::complementarity::{Checked, ComplementaritySolver, Lcp, SparseActiveSet};
use crate::cosim::{CouplingScheme, Forecast, MicroStep, Sample, SchemeReport, Sequence, Side};
use crate::error::{Error, Failure, Result};
use crate::interface_model::{
    Condensation, GapRates, ImpactRows, ImpactStep, MEMORY_LIMIT, Rebounds, ReducedInterfaceModel, Redundancy, Solved,
    TOUCHING, condense, resting_approach,
};

/// Where no other is asked for, the smooth model counts a contact as closed up to this gap, m. Ours: the source paper does not say
/// how its simulator detects contacts, and without a margin the model does not show what the paper shows.
const SMOOTH_MARGIN: f64 = 1e-3;

/// Square matrices over all contacts that a scheme keeps at most where it keeps every entry: packed and condensed forms, contact
/// problems, workspaces of two solvers.
const SQUARES: u64 = 12;

/// Refuses to keep every entry of the matrices of so many contacts, of which the mechanics keeps only what is not zero.
///
/// # Errors
/// [`Error::Incompatible`] beyond `limit` bytes, with what is needed, at most.
fn must_hold_every_entry(contacts: usize, limit: u64) -> Result<()> {
    const GIB: f64 = (1_u64 << 30) as f64;
    let bytes = 8 * SQUARES * (contacts as u64).pow(2);
    if bytes <= limit {
        return Ok(());
    }
    Err(Error::Incompatible(format!(
        "with these options the scheme keeps every entry of the matrices of {contacts} contacts, up to {:.1} GiB, and the limit is {:.1} \
         GiB: fewer contacts, or a scheme that keeps what is not zero (`rim-nonsmooth-gap` with all contacts, a frozen model and the default \
         solver)",
        bytes as f64 / GIB,
        limit as f64 / GIB
    )))
}

/// Solves the packed contacts without friction for `b`; `anew` says that they have been packed since the last time.
#[inline]
fn solve_packed(
    packed: &PackedModel,
    anew: bool,
    solver: &mut Checked,
    sparse: &mut Option<SparseActiveSet>,
    b: &[f64],
    impulses: &mut [f64],
) -> Result<(), Failure> {
    if let (Some(solver), Some(rows)) = (sparse, packed.contact_rows()) {
        if anew {
            solver.change_pattern(rows.pattern);
            // Macro steps begin alike: with penetrations, and with the force of the point itself.
            solver.start_series();
        }
        solver.solve(rows, b, impulses)?;
        return Ok(());
    }
    let lcp = Lcp::new(packed.h_uu(), b);
    if anew { solver.solve(lcp, impulses) } else { solver.attempt_again(lcp, impulses) }?;
    Ok(())
}

/// How contacts enter the model within the macro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contacts {
    /// Contacts closed at `t_k` are bilateral: `w_c⁺ = 0`, eliminated beforehand.
    Bilateral,
    /// Those of them that carry impulse at `t_k` are bilateral, the others are left out.
    BilateralActive,
    /// Contacts closed at `t_k` may open: `0 ≤ w_u⁺ ⟂ P_u ≥ 0`, or the law that comes with their detection.
    Unilateral,
    /// All contacts are there with their gaps: `0 ≤ w_u⁺ + g/δ ⟂ P_u ≥ 0`, `g⁺ = g + δ w_u⁺`.
    UnilateralWithGaps,
}

/// What the gaps do in the complementarity condition of a micro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GapTerm {
    /// Nothing: `w_u⁺ ≥ 0`.
    None,
    /// They stand as at `t_k`, with the mechanics' own step.
    Frozen,
    /// They move with the model.
    Tracked,
}

/// A coupling scheme made from a reduced interface model.
#[derive(Clone)]
pub(super) struct ReducedInterface {
    contacts: Contacts,
    detection: Option<ContactDetection>,
    gap_term: GapTerm,
    redundancy: Redundancy,
    model: MovingModel,
    /// Contacts in the model, and those of the communication point before.
    set: Vec<usize>,
    previous_set: Vec<usize>,
    condensation: Condensation,
    solver: Checked,
    /// In its place, where few of many contacts meet and all are in the set.
    sparse: Option<SparseActiveSet>,
    /// In its place, where contacts have friction.
    friction: Option<Box<FrictionalSet>>,
    active: ActiveContacts,
    /// The model as a micro step uses it.
    packed: PackedModel,
    /// True until the matrix of `packed` has been given to the solver.
    packed_anew: bool,
    /// Where micro steps are of the second order, how the force follows the motion; whether they are.
    following: ForceFollowing,
    follows: bool,
    /// The micro step while the active set stays the same; none where it is not affine.
    parametric: Option<ParametricStep>,
    gap_motion: GapMotion,
    /// Contacts that rebound in a micro step, and the velocities by which it changes positions then.
    rebounds: Rebounds,
    way: Vec<f64>,
    /// By how much contacts went too far in the micro step last solved, m/s.
    left: f64,
    /// Right-hand side and impulses of the complementarity problem.
    b_u: Vec<f64>,
    p_u: Vec<f64>,
    /// State of the model between communication points: `[w_u; w_i]` with the contacts in the order of `set` (none
    /// where they are bilateral; with friction their tangential rows after them), gaps, interface position.
    w: Vec<f64>,
    /// `w⁺` without contact impulses.
    w_free: Vec<f64>,
    gap: Vec<f64>,
    position: Vec<f64>,
    /// The actuator's force at the last communication point.
    force: Vec<f64>,
    /// The force with which a micro step of the second order starts.
    start_force: Vec<f64>,
    micro_step: f64,
    diagnosis: Diagnosis,
}

/// What is needed to say which mass the actuator pushes.
#[derive(Clone)]
struct Diagnosis {
    /// Contacts that carried impulse in the first micro step since the communication point; until it is solved, in the last one
    /// before.
    loaded: Vec<usize>,
    /// The model with those contacts closed.
    condensation: Condensation,
    /// Where contacts are bilateral: the effective mass at the communication point.
    bilateral_mass: f64,
}

impl ReducedInterface {
    /// Describes the scheme with contacts of this kind.
    pub(super) fn entry(name: &'static str, about: &'static str, contacts: Contacts) -> SchemeEntry {
        let usual = |default| Some(DetectionRule { default, has_law: contacts != Contacts::Bilateral });
        SchemeEntry {
            family: Family::Model,
            contact_detection: match contacts {
                Contacts::Bilateral => usual(ContactDetection::Margin { width: SMOOTH_MARGIN }),
                Contacts::BilateralActive | Contacts::Unilateral => usual(ContactDetection::Active),
                Contacts::UnilateralWithGaps => None,
            },
            order: 2,
            sequence: Sequence::GaussSeidel { first: Side::Actuator },
            needs: match contacts {
                Contacts::Bilateral => vec![Need::ForceDisplacement, Need::InterfaceModel, Need::NotMechanicsFirst],
                _ => vec![Need::ForceDisplacement, Need::InterfaceModel, Need::ListedContacts, Need::NotMechanicsFirst],
            },
            moves_model: true,
            ..SchemeEntry::new(name, about, move |construction| Ok(Box::new(Self::new(contacts, construction)?)))
        }
    }

    fn new(contacts: Contacts, construction: &Construction<'_>) -> Result<Self> {
        let ModelConstruction { empty, options, detection } = construction.model()?;
        let (n_u, n_i, first) = (empty.contacts(), empty.interface(), empty.interface_start());
        let friction = FrictionalSet::of(empty, &options.solver);
        // A solver that was asked for by name is given every problem.
        let affine = options.motion != ModelMotion::Extrapolated
            && empty.spring.is_none()
            && options.solver.goes_by_active_sets();
        // A coefficient that a contact has at rest only changes from micro step to micro step.
        let affine = affine
            && empty.stiction.is_none()
            && matches!(contacts, Contacts::Unilateral | Contacts::UnilateralWithGaps);
        // The set is all contacts, and the model has no more of them than it says.
        let all = matches!(detection, None | Some(ContactDetection::MechanicsLaw));
        let tolerance = options.solver.tolerance;
        let sparse = empty.meeting().filter(|_| affine && all).map(|meeting| SparseActiveSet::new(meeting, tolerance));
        if sparse.is_none() && empty.meeting().is_some() {
            must_hold_every_entry(n_u, MEMORY_LIMIT)?;
        }
        let bounces = empty.restitution > 0.0;
        // A solver that is not asked keeps no room.
        let solver = options.solver.checked(if sparse.is_some() || friction.is_some() { 0 } else { n_u });
        Ok(ReducedInterface {
            contacts,
            detection,
            gap_term: match (contacts, detection) {
                (Contacts::UnilateralWithGaps, _) => GapTerm::Tracked,
                (_, Some(ContactDetection::MechanicsLaw)) => GapTerm::Frozen,
                // A spring presses by its gap.
                (Contacts::Unilateral, _) if empty.spring.is_some() => GapTerm::Tracked,
                _ => GapTerm::None,
            },
            redundancy: options.redundancy,
            model: MovingModel::new(empty, options.motion),
            set: Vec::with_capacity(n_u),
            previous_set: Vec::with_capacity(n_u),
            condensation: Condensation::of(empty),
            active: match contacts {
                Contacts::BilateralActive => ActiveContacts::of(empty, &options.solver),
                _ => ActiveContacts::new(0, n_i, &options.solver),
            },
            packed: if sparse.is_some() { PackedModel::of_all(empty) } else { PackedModel::new(first, n_i) },
            packed_anew: true,
            following: ForceFollowing::new(n_i),
            follows: false,
            parametric: affine.then(|| match &sparse {
                Some(sparse) => ParametricStep::sparse(n_u, n_i, sparse.factor()),
                None if friction.is_some() => ParametricStep::with_friction(n_u, n_i),
                None => ParametricStep::new(n_u, n_i),
            }),
            solver,
            sparse,
            friction,
            gap_motion: GapMotion::default(),
            rebounds: if bounces { Rebounds::new(n_u, first) } else { Rebounds::default() },
            way: vec![0.0; if bounces { first + n_i } else { 0 }],
            left: 0.0,
            b_u: vec![0.0; first],
            p_u: vec![0.0; first],
            w: vec![0.0; first + n_i],
            w_free: vec![0.0; first + n_i],
            gap: vec![0.0; n_u],
            position: vec![0.0; n_i],
            force: vec![0.0; n_i],
            start_force: vec![0.0; n_i],
            micro_step: f64::NAN,
            diagnosis: Diagnosis {
                loaded: Vec::with_capacity(n_u),
                condensation: Condensation::of(empty),
                bilateral_mass: f64::NAN,
            },
        })
    }

    fn receive_model(&mut self, sample: &Sample<'_>, model: &ReducedInterfaceModel) -> Result<(), Failure> {
        // The last micro step of the macro step that ends here.
        self.note_loaded();
        std::mem::swap(&mut self.set, &mut self.previous_set);
        match self.detection {
            None | Some(ContactDetection::MechanicsLaw) => {
                self.set.clear();
                self.set.extend(0..model.contacts());
            }
            Some(ContactDetection::Active) if self.contacts == Contacts::Unilateral => {
                model.closed_and_leaving_contacts(&mut self.set);
            }
            Some(ContactDetection::Active) => model.closed_contacts(&mut self.set),
            Some(ContactDetection::Margin { width }) => model.contacts_within(width, &mut self.set),
        }
        self.model.receive(sample.time, model);
        self.micro_step = sample.actuator_micro_step;
        // Which contacts carry impulse depends on the force, which arrives next.
        if self.waits_for_force() { Ok(()) } else { self.begin() }
    }

    /// Notes which contacts carry impulse in the micro step just solved.
    fn note_loaded(&mut self) {
        let loaded = self.set.iter().zip(&self.p_u[..self.packed.contacts()]).filter(|(_, impulse)| **impulse > 0.0);
        self.diagnosis.loaded.clear();
        self.diagnosis.loaded.extend(loaded.map(|(&contact, _)| contact));
    }

    /// Notes what contacts with friction do in the micro step just solved, after which the velocities are in `w_free`.
    fn note_states(&mut self) {
        let (Some(friction), m, n) = (&self.friction, self.set.len(), self.packed.contacts()) else { return };
        let rows = self.w_free[..n].iter().zip(self.packed.drift(n)).map(|(w, drift)| (*w, *drift));
        let standstill = resting_approach(friction.tolerance(), rows);
        friction.note_states(&self.set, &mut self.model.received, &self.w_free[m..n], standstill);
    }

    /// Whether the set of contacts depends on the actuator's force.
    fn waits_for_force(&self) -> bool {
        self.contacts == Contacts::BilateralActive
    }

    /// Sets the model to its start at the communication point, once the set of contacts is known.
    fn begin(&mut self) -> Result<(), Failure> {
        if self.set != self.previous_set {
            self.model.freeze();
        }
        if let Some(friction) = &mut self.friction {
            friction.take(&self.set, &self.model.received);
        }
        self.prepare()?;
        let (model, time) = (&self.model.received, self.opening_time());
        self.gap_motion = GapMotion {
            rates: match (self.gap_term, model.spring) {
                (GapTerm::None, _) => GapRates::default(),
                (_, None) => GapRates::new(time, model.mechanics_step, model.stabilisation),
                (_, Some(spring)) => spring.gap_rates(time),
            },
            advance: if self.gap_term == GapTerm::Tracked { self.micro_step } else { 0.0 },
            restitution: if model.spring.is_none() { model.restitution } else { 0.0 },
            closing_time: time,
        };
        let n = self.packed.contacts();
        let rows = self.friction.as_ref().map_or(&self.set[..], |friction| friction.rows());
        for (w, &row) in self.w.iter_mut().zip(&rows[..n]) {
            *w = model.w[row];
        }
        for (gap, &contact) in self.gap.iter_mut().zip(&self.set[..n.min(self.set.len())]) {
            *gap = if self.gap_term == GapTerm::None { 0.0 } else { model.gap[contact] };
        }
        let w_i = match self.contacts {
            Contacts::Bilateral | Contacts::BilateralActive => &self.condensation.w[..],
            Contacts::Unilateral | Contacts::UnilateralWithGaps => &model.w[model.interface_start()..],
        };
        self.w[n..n + w_i.len()].copy_from_slice(w_i);
        self.position.copy_from_slice(&model.position);
        self.diagnosis.bilateral_mass = self.condensation.effective_mass;
        Ok(())
    }

    /// Time within which an open contact may use up its gap, s.
    fn opening_time(&self) -> f64 {
        match self.gap_term {
            GapTerm::Frozen => self.model.received.mechanics_step,
            GapTerm::None | GapTerm::Tracked => self.micro_step,
        }
    }

    /// Derives from the model as it stands what a micro step needs.
    fn prepare(&mut self) -> Result<(), Failure> {
        self.packed_anew = true;
        if let Some(parametric) = &mut self.parametric {
            parametric.catch_up(&self.gap_motion, &mut self.w, &mut self.gap);
            parametric.forget();
        }
        match self.contacts {
            Contacts::Bilateral | Contacts::BilateralActive => {
                condense(&self.model.current, &self.set, self.redundancy, &mut self.condensation);
                self.packed.pack_condensed(&self.condensation, self.micro_step);
                if self.follows {
                    self.packed.follow(&mut self.following)?;
                }
            }
            Contacts::Unilateral | Contacts::UnilateralWithGaps => {
                let rows = self.friction.as_ref().map_or(&self.set[..], |friction| friction.rows());
                self.packed.pack(&self.model.current, rows, self.micro_step);
                if self.follows {
                    self.packed.follow(&mut self.following)?;
                }
                if let Some(spring) = self.model.received.spring {
                    self.packed.add_to_diagonal(spring.diagonal(self.micro_step, self.opening_time()));
                }
            }
        }
        Ok(())
    }

    /// Fills `w_free` with the velocities without contact impulses, and solves for `p_u`.
    #[inline]
    fn solve_contacts(&mut self, lambda: &[f64]) -> Result<(), Failure> {
        let n = self.packed.contacts();
        let rows = n + lambda.len();
        self.packed.free_velocity(&self.w[..rows], lambda, &mut self.w_free[..rows]);
        if self.gap_motion.restitution > 0.0 {
            self.find_rebounds(rows)?;
        }
        self.write_problem(n, Solved::Velocity);
        let ReducedInterface { solver, sparse, packed, packed_anew, b_u, p_u, .. } = self;
        solve_packed(packed, std::mem::replace(packed_anew, false), solver, sparse, &b_u[..n], &mut p_u[..n])
    }

    /// The same with friction.
    #[cold]
    fn solve_frictional(&mut self, lambda: &[f64]) -> Result<(), Failure> {
        let n = self.packed.contacts();
        let rows = n + lambda.len();
        self.packed.free_velocity(&self.w[..rows], lambda, &mut self.w_free[..rows]);
        if self.gap_motion.restitution > 0.0 {
            self.find_rebounds(rows)?;
        }
        self.write_problem(n, Solved::Velocity);
        let anew = std::mem::replace(&mut self.packed_anew, false);
        if let Some(friction) = &mut self.friction {
            friction.solve(&self.packed, anew, &self.b_u[..n], &mut self.p_u[..n])?;
        }
        Ok(())
    }

    /// Writes the right-hand side of the first `n` rows: contacts, then tangential rows.
    #[inline]
    fn write_problem(&mut self, n: usize, solved: Solved) {
        let contacts = n.min(self.set.len());
        self.b_u[..n].copy_from_slice(&self.w_free[..n]);
        if self.gap_term != GapTerm::None {
            for (b, gap) in self.b_u[..contacts].iter_mut().zip(&self.gap) {
                *b += self.gap_motion.rates.velocity(*gap);
            }
        }
        if self.rebounds.any() {
            let step = self.impact_step();
            for row in 0..n {
                let along = row.checked_sub(contacts);
                let term = match along {
                    Some(contact) => self.rebounds.term_along(&step, contact, self.w[row]),
                    None => self.rebounds.term(&step, row, step.rates.velocity(self.gap[row]), self.w[row], solved),
                };
                self.b_u[row] = self.w_free[row] + term;
            }
        }
    }

    /// How contacts rebound in a micro step.
    fn impact_step(&self) -> ImpactStep {
        let GapMotion { rates, advance, restitution, closing_time } = self.gap_motion;
        let tolerance = self.friction.as_ref().map_or(self.solver.tolerance(), |friction| friction.tolerance());
        ImpactStep {
            restitution,
            along: self.model.received.tangential_restitution,
            rates,
            advance,
            closing_time,
            tolerance,
        }
    }

    /// Finds the contacts that rebound in a micro step without whose impulses the velocities are in `w_free`, and where one does by which
    /// velocities positions change. `rows` are those of contacts and interface.
    fn find_rebounds(&mut self, rows: usize) -> Result<(), Failure> {
        let (n, step) = (self.packed.contacts(), self.impact_step());
        let contacts = n.min(self.set.len());
        let ReducedInterface { rebounds, set, model, gap, w, w_free, .. } = self;
        let state = ImpactRows { gap: &gap[..contacts], w: &w[..n], free: &w_free[..n] };
        // The model's own rows do not turn: what the mechanics' steps have made by themselves it finds as they have left it.
        if rebounds.note_hits(&step, state, |slot| model.received.own_approach_of(set[slot])) {
            self.look_ahead(&step, rows)?;
        }
        Ok(())
    }

    /// The same once there are contacts that are hit.
    #[cold]
    fn look_ahead(&mut self, step: &ImpactStep, rows: usize) -> Result<(), Failure> {
        let n = self.packed.contacts();
        let ReducedInterface {
            rebounds, set, packed, packed_anew, solver, sparse, friction, gap, w, w_free, way, ..
        } = self;
        let state = ImpactRows { gap: &gap[..n.min(set.len())], w: &w[..n], free: &w_free[..n] };
        let mut solve = |b: &[f64], impulses: &mut [f64]| -> Result<(), Failure> {
            let anew = std::mem::replace(packed_anew, false);
            match friction {
                Some(friction) => friction.try_solve(packed, anew, b, impulses).map(drop)?,
                None => solve_packed(packed, anew, solver, sparse, b, impulses)?,
            }
            Ok(())
        };
        let lasts = rebounds.look_ahead(step, state, |b, impulses, velocities| {
            solve(b, impulses)?;
            way[..n].copy_from_slice(b);
            packed.add_impulses(impulses, &mut way[..rows]);
            velocities.copy_from_slice(&way[..n]);
            Ok(())
        })?;
        if lasts {
            self.write_problem(n, Solved::Way);
            let ReducedInterface { packed, solver, sparse, friction, b_u, p_u, w_free, way, .. } = self;
            let (b, impulses) = (&b_u[..n], &mut p_u[..n]);
            match friction {
                Some(friction) => friction.try_solve(packed, false, b, impulses).map(drop)?,
                None => solve_packed(packed, false, solver, sparse, b, impulses)?,
            }
            way[..rows].copy_from_slice(&w_free[..rows]);
            packed.add_impulses(impulses, &mut way[..rows]);
        }
        Ok(())
    }

    /// Takes a micro step under the force `lambda` (N); the velocities are then in `w`, those before in `w_free`.
    #[inline(always)]
    fn step(&mut self, lambda: &[f64], at: MicroStep) -> Result<(), Failure> {
        match self.contacts {
            Contacts::Bilateral | Contacts::BilateralActive => {
                let n_i = lambda.len();
                self.packed.free_velocity(&self.w[..n_i], lambda, &mut self.w_free[..n_i]);
            }
            Contacts::Unilateral | Contacts::UnilateralWithGaps => {
                if !self.step_with_last_set(lambda, at) {
                    self.step_by_solving(lambda)?;
                }
                if at.index == 0 {
                    self.note_loaded();
                    self.note_states();
                }
            }
        }
        std::mem::swap(&mut self.w, &mut self.w_free);
        Ok(())
    }

    /// The input of a micro step of the second order: the mean motion, from a force that follows it.
    #[inline(never)]
    fn input_following(&mut self, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let (n, n_i) = (self.packed.contacts(), own.len());
        let mut force = std::mem::take(&mut self.start_force);
        force.copy_from_slice(own);
        self.following.force_at_start(u, &self.position, &self.w[n..n + n_i], &mut force);
        let stepped = self.step(&force, at);
        self.start_force = force;
        stepped?;
        let (u_position, u_velocity) = u.split_at_mut(n_i);
        for (i, (w, before)) in self.w[n..n + n_i].iter().zip(&self.w_free[n..]).enumerate() {
            let mean = 0.5 * (w + before);
            u_position[i] = self.position[i] + 0.5 * at.length * mean;
            u_velocity[i] = mean;
            self.position[i] += at.length * mean;
        }
        Ok(())
    }

    /// Takes the micro step with the active set of the last one, if that is its set too; the velocities are then in `w_free`.
    #[inline(always)]
    fn step_with_last_set(&mut self, lambda: &[f64], at: MicroStep) -> bool {
        let Some(parametric) = &mut self.parametric else { return false };
        if parametric.looks_ahead() {
            if let &[force] = lambda
                && parametric.go_on(&self.gap_motion, force, &self.w, &mut self.w_free)
            {
                return true;
            }
            parametric.catch_up(&self.gap_motion, &mut self.w, &mut self.gap);
        }
        if !parametric.is_known() {
            // Impulses of another model say nothing.
            if self.packed_anew {
                return false;
            }
            if let Some(friction) = &self.friction {
                let (states, mu) = (friction.states(), friction.friction());
                parametric.find_of_states(&self.packed, &self.gap_motion, states, mu, self.left);
            } else {
                let solved = self.sparse.as_ref().map(SparseActiveSet::factor);
                parametric.find(&self.packed, &self.gap_motion, &self.p_u[..self.packed.contacts()], self.left, solved);
            }
        }
        let state = MicroState { w: &self.w, next: &mut self.w_free, gap: &mut self.gap, impulses: &mut self.p_u };
        let (packed, motion) = (&self.packed, &self.gap_motion);
        if parametric.is_known()
            && match self.friction {
                None => parametric.step::<false>(packed, motion, lambda, state),
                Some(_) => parametric.step::<true>(packed, motion, lambda, state),
            }
        {
            if self.sparse.is_some() {
                // The last one looks at all contacts: whoever asks at the communication point finds them as they are.
                let steps = at.count.saturating_sub(at.index + 2);
                parametric.look_ahead(motion, lambda, steps, &self.w_free, &self.gap);
            }
            return true;
        }
        parametric.forget();
        false
    }

    /// Takes the micro step by solving its contact problem; the velocities are then in `w_free`.
    #[inline(never)]
    fn step_by_solving(&mut self, lambda: &[f64]) -> Result<(), Failure> {
        match self.friction {
            None => self.solve_contacts(lambda)?,
            Some(_) => self.solve_frictional(lambda)?,
        }
        let n = self.packed.contacts();
        let w = &mut self.w_free[..n + lambda.len()];
        self.packed.add_impulses(&self.p_u[..n], w);
        // A contact that bounces does not follow its gap term.
        self.left = 0.0;
        if self.parametric.is_some() && self.gap_motion.restitution == 0.0 {
            let slack = |(w, gap): (&f64, &f64)| w + self.gap_motion.rates.velocity(*gap);
            // Tangential rows, behind those of the contacts, have no gaps.
            self.left = -w[..n.min(self.set.len())].iter().zip(&self.gap).map(slack).fold(0.0, f64::min);
        }
        let mut ways = &*w;
        if self.rebounds.any() {
            // Whoever asked for the step moves the interface on by its velocity.
            for (position, (way, w)) in self.position.iter_mut().zip(self.way[n..].iter().zip(&w[n..])) {
                *position += self.packed.length() * (way - w);
            }
            ways = &self.way;
        }
        if self.gap_term == GapTerm::Tracked {
            for (gap, w) in self.gap.iter_mut().zip(&ways[..self.set.len()]) {
                *gap += self.packed.length() * w;
            }
        }
        Ok(())
    }

    /// Time until the first of the contacts that are open closes, its acceleration being that of the last micro step, s. Where a contact
    /// was hit in that step the difference of its velocities is no acceleration, and they are taken as they are. What touches and
    /// carries nothing is not open. Rows of friction, which stand behind those of the contacts, close nothing.
    fn next_closing(&self) -> Option<f64> {
        // With friction the packed rows are twice as many.
        let tracked = (self.gap_term == GapTerm::Tracked).then_some(self.set.len())?;
        let delta = self.packed.length();
        // A contact that closes comes to rest in two steps: in the first it uses up its gap, in the second it stops.
        let approached = |slot: usize| (self.gap[slot] - delta * self.w[slot]).max(-delta * self.w_free[slot]);
        let hit = (0..tracked).any(|slot| self.p_u[slot] > 0.0 && approached(slot) > TOUCHING);
        let open = (0..tracked).filter(|&slot| self.gap[slot] > TOUCHING && self.p_u[slot] <= 0.0);
        let closing = open.filter_map(|slot| {
            let (gap, w) = (self.gap[slot], self.w[slot]);
            let a = if hit { 0.0 } else { (w - self.w_free[slot]) / delta };
            let speed = (w * w - 2.0 * a * gap).sqrt() - w;
            (speed > 0.0).then(|| 2.0 * gap / speed)
        });
        closing.reduce(f64::min)
    }

    /// Leaves in `set` the contacts that carry impulse with the actuator's force.
    fn keep_active_contacts(&mut self) -> Result<(), Failure> {
        let law = self.gap_term == GapTerm::Frozen;
        let MovingModel { received, current, .. } = &mut self.model;
        if received.has_friction() {
            self.active.keep_with_friction(&mut self.set, received, &self.force, law)?;
            current.states.copy_from_slice(&received.states);
            current.friction.copy_from_slice(&received.friction);
        } else {
            self.active.keep(&mut self.set, received, &self.force, law)?;
        }
        if law {
            // What is bilateral then moves as the law says: w_c⁺ = −gap term.
            for &contact in &self.set {
                current.w[contact] += received.step_gap_velocity(contact);
            }
        }
        Ok(())
    }
}

impl CouplingScheme for ReducedInterface {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        match from {
            Side::Mechanics => self.receive_model(sample, sent(sample.model)?)?,
            Side::Actuator => {
                self.force.copy_from_slice(sample.y);
                if self.waits_for_force() {
                    self.keep_active_contacts()?;
                    self.begin()?;
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            u.copy_from_slice(&self.force);
            return Ok(());
        }
        debug_assert_eq!(at.length, self.packed.length());
        if self.model.move_to(at) {
            self.prepare()?;
        }
        if self.follows {
            return self.input_following(at, own, u);
        }
        self.step(own, at)?;
        let (n, n_i) = (self.packed.contacts(), own.len());
        let w_i = &self.w[n..n + n_i];
        let (u_position, u_velocity) = u.split_at_mut(n_i);
        for (i, w) in w_i.iter().enumerate() {
            self.position[i] += at.length * w;
            u_position[i] = self.position[i];
            u_velocity[i] = *w;
        }
        Ok(())
    }

    fn follow(&mut self, feedthrough: &[f64]) -> Result<(), Failure> {
        let anew = self.following.set(feedthrough, self.micro_step);
        let first = !std::mem::replace(&mut self.follows, true);
        if anew || first { self.prepare() } else { Ok(()) }
    }

    fn input_at_end(&self, to: Side, u: &mut [f64]) {
        if to == Side::Actuator && self.follows {
            let (position, velocity) = u.split_at_mut(self.position.len());
            position.copy_from_slice(&self.position);
            velocity.copy_from_slice(&self.w[self.packed.contacts()..][..self.position.len()]);
        }
    }

    fn forecast(&self) -> Option<Forecast<'_>> {
        Some(Forecast { position: &self.position, next_closing: self.next_closing() })
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }

    fn report(&mut self) -> SchemeReport {
        let effective_mass = match self.contacts {
            Contacts::Bilateral | Contacts::BilateralActive => self.diagnosis.bilateral_mass,
            Contacts::Unilateral | Contacts::UnilateralWithGaps => {
                let Diagnosis { loaded, condensation, .. } = &mut self.diagnosis;
                condense(&self.model.received, loaded, self.redundancy, condensation);
                condensation.effective_mass
            }
        };
        let mut counters = self.sparse.as_ref().map_or_else(|| self.solver.counters(), SparseActiveSet::counters);
        if let Some(friction) = &self.friction {
            counters.add(&friction.counters());
        }
        counters.add(&self.active.counters());
        counters.parametric += self.parametric.as_ref().map_or(0, ParametricStep::steps);
        SchemeReport { effective_mass: Some(effective_mass), dissipated_j: None, counters }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::{MacroStep, PerSide, Port, Ports, Quantity};
    use crate::linear_algebra::SymmetricPattern;
    use crate::schemes::model_options::ModelOptions;
    use approx::assert_relative_eq;
    use std::sync::Arc;

    const STEP: MacroStep = MacroStep { index: 0, start: 0.0, length: 4e-3 };
    const STEPS: usize = 4;

    fn ports(inputs: &[Quantity], outputs: &[Quantity]) -> Ports {
        let named = |of: &[Quantity]| of.iter().map(|&quantity| Port { name: "p".into(), quantity }).collect();
        Ports { inputs: named(inputs), outputs: named(outputs), direct_feedthrough: false }
    }

    /// Gap tracking with this model, at its communication point, under no force.
    fn tracking(model: &ReducedInterfaceModel, motion: ModelMotion) -> ReducedInterface {
        let mut model = model.clone();
        model.mechanics_step = STEP.length;
        let model = &model;
        let motions = [Quantity::Position, Quantity::Velocity];
        let ports =
            PerSide { mechanics: ports(&[Quantity::Force], &motions), actuator: ports(&motions, &[Quantity::Force]) };
        let ports = PerSide { mechanics: &ports.mechanics, actuator: &ports.actuator };
        let options = ModelOptions { motion, ..ModelOptions::default() };
        let model_to_come = Some(ModelConstruction { empty: model, options: &options, detection: None });
        let construction = Construction { ports, model: model_to_come, gain: 1.0 };
        let mut scheme = ReducedInterface::new(Contacts::UnilateralWithGaps, &construction).unwrap();
        let delta = STEP.length / STEPS as f64;
        let sample = Sample { model: Some(model), ..Sample::of_outputs(STEP, &[0.0, 0.0], delta) };
        scheme.receive(Side::Mechanics, &sample).unwrap();
        scheme.receive(Side::Actuator, &Sample::of_outputs(STEP, &[0.0], delta)).unwrap();
        scheme
    }

    #[test]
    fn a_scheme_that_keeps_every_entry_is_refused_where_only_what_is_not_zero_has_room() {
        let chain = |n: usize| (0..n).map(|i| vec![i.saturating_sub(1)]).collect::<Vec<_>>();
        let model = |n| ReducedInterfaceModel::zeros_of(Arc::new(SymmetricPattern::new(&chain(n))), 1);
        let motions = [Quantity::Position, Quantity::Velocity];
        let sides = [ports(&[Quantity::Force], &motions), ports(&motions, &[Quantity::Force])];
        let built = |contacts: Contacts, empty: &ReducedInterfaceModel| {
            let options = ModelOptions::default();
            let detection =
                (contacts == Contacts::Bilateral).then_some(ContactDetection::Margin { width: SMOOTH_MARGIN });
            let ports = PerSide { mechanics: &sides[0], actuator: &sides[1] };
            let model = Some(ModelConstruction { empty, options: &options, detection });
            ReducedInterface::new(contacts, &Construction { ports, model, gain: 1.0 }).map(drop)
        };
        // 12 matrices of 7000² entries are 4.4 GiB.
        let many = model(7000);
        let refused = built(Contacts::Bilateral, &many).unwrap_err().to_string();
        assert!(refused.contains("7000 contacts, up to 4.4 GiB, and the limit is 4.0 GiB"), "{refused}");
        assert!(built(Contacts::UnilateralWithGaps, &many).is_ok() && built(Contacts::Bilateral, &model(60)).is_ok());
        // At the limit, and beyond.
        assert!(must_hold_every_entry(100, 960_000).is_ok() && must_hold_every_entry(100, 959_999).is_err());
    }

    fn micro_step(scheme: &mut ReducedInterface, index: usize) -> [f64; 2] {
        let mut u = [0.0; 2];
        scheme.input(Side::Actuator, MicroStep::new(STEP, index, STEPS), &[0.0], &mut u).unwrap();
        u
    }

    /// Two contacts of 1 kg, of which one stops in the second and third of four steps of 1 ms, and pulls the other along: from 1.01 m/s
    /// to 1.22 and 1.43 m/s, by impulses of 0.5 N·s. No acceleration of 210 m/s² follows from that.
    #[test]
    fn the_next_closing_must_not_be_foreseen_by_the_impact_of_another_contact() {
        let mut model = ReducedInterfaceModel::zeros(2, 1);
        model.h.copy_from_slice(&[1.0, -0.4, 0.0, -0.4, 1.0, 0.0, 0.0, 0.0, 1.0]);
        model.a.copy_from_slice(&[0.0, -10.0, 0.0]);
        model.w.copy_from_slice(&[-1.0, -1.0, 0.0]);
        model.gap.copy_from_slice(&[1.5e-3, 0.1]);
        let mut scheme = tracking(&model, ModelMotion::Frozen);
        let (mut w, mut gap) = (-1.0, 0.1);
        let falls = |gap: f64, w: f64| 2.0 * gap / ((w * w + 20.0 * gap).sqrt() - w);
        for (index, impulse) in [0.0, 0.5, 0.5, 0.0].into_iter().enumerate() {
            micro_step(&mut scheme, index);
            w += -0.01 - 0.4 * impulse;
            gap += 1e-3 * w;
            let first = 0.5e-3 / 1.0;
            let expected = match index {
                // The other one closes before.
                0 => first,
                1 | 2 => gap / -w,
                // The first contact rests, loaded by nothing.
                _ => falls(gap, w),
            };
            assert_relative_eq!(scheme.next_closing().unwrap(), expected, max_relative = 1e-12);
        }
    }

    /// What touches up to rounding, and is not pressed, closes nothing.
    #[test]
    fn a_contact_that_touches_and_carries_nothing_is_not_about_to_close() {
        let mut model = ReducedInterfaceModel::zeros(1, 1);
        model.h.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
        model.gap[0] = 1e-13;
        model.w[0] = -1e-17;
        let mut scheme = tracking(&model, ModelMotion::Frozen);
        micro_step(&mut scheme, 0);
        assert_eq!(scheme.next_closing(), None);
    }

    /// A contact of 1 kg that is pressed with 1 m/s², and from 1.25 ms on, where the surface bends down, with 0.2 m/s², then lets go
    /// of the interface, which hangs on it: a quarter of the second step lies before the kink.
    #[test]
    fn accelerations_must_jump_at_a_kink_and_by_the_share_of_the_step_behind_it() {
        let mut model = ReducedInterfaceModel::zeros(1, 1);
        model.h.copy_from_slice(&[1.0, 0.5, 0.5, 1.0]);
        model.a.copy_from_slice(&[-1.0, 0.0]);
        model.kinks = crate::interface_model::Kinks::with_room(1, 2);
        model.kinks.add(1.25e-3).copy_from_slice(&[0.8, 0.0]);
        let velocities = |motion| {
            let mut scheme = tracking(&model, motion);
            [0, 1, 2, 3].map(|index| micro_step(&mut scheme, index)[1])
        };
        // The interface is pushed by half of what keeps the contact: P = δ a.
        let expected = [1.0, 0.25 + 0.75 * 0.2, 0.2, 0.2].map(|press: f64| 0.5e-3 * press);
        let mut sum = 0.0;
        for (found, push) in velocities(ModelMotion::Piecewise).into_iter().zip(expected) {
            sum += push;
            assert_relative_eq!(found, sum, max_relative = 1e-12);
        }
        for (index, found) in velocities(ModelMotion::Frozen).into_iter().enumerate() {
            assert_relative_eq!(found, 0.5e-3 * (index + 1) as f64, max_relative = 1e-12);
        }
    }

    /// The same along the surface: a contact that sticks is pushed with 0.5 m/s², and from 1.25 ms on with 0.1 m/s².
    #[test]
    fn accelerations_along_the_surface_must_jump_at_a_kink_like_those_off_it() {
        let mut model = ReducedInterfaceModel::zeros_with_friction(&[1.0], 1);
        model.h.copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.5, 1.0]);
        model.a.copy_from_slice(&[-1.0, 0.5, 0.0]);
        model.kinks = crate::interface_model::Kinks::with_room(1, 3);
        model.kinks.add(1.25e-3).copy_from_slice(&[0.0, -0.4, 0.0]);
        let velocities = |motion| {
            let mut scheme = tracking(&model, motion);
            [0, 1, 2, 3].map(|index| micro_step(&mut scheme, index)[1])
        };
        // Half of what keeps the contact where it is pushes the interface: P_t = −δ a_t, less than P_n = δ.
        let mut sum = 0.0;
        let pushes = [0.5, 0.25 * 0.5 + 0.75 * 0.1, 0.1, 0.1];
        for (found, push) in velocities(ModelMotion::Piecewise).into_iter().zip(pushes) {
            sum -= 0.5e-3 * push;
            assert_relative_eq!(found, sum, max_relative = 1e-12);
        }
        for (index, found) in velocities(ModelMotion::Frozen).into_iter().enumerate() {
            assert_relative_eq!(found, -0.25e-3 * (index + 1) as f64, max_relative = 1e-12);
        }
    }
}

//! Construction of a scheme from the treatment of contacts, the options, and the size of the model.

use super::super::active_contacts::ActiveContacts;
use super::super::construction::{Construction, ModelConstruction};
use super::super::contact_detection::{ContactDetection, DetectionRule};
use super::super::coulomb_contacts::{CoulombContacts, SpaceContacts};
use super::super::entry::{Family, SchemeEntry};
use super::super::implicit_feedthrough::ImplicitFeedthrough;
use super::super::model_contacts::{Complementarity, ModelContacts, ModelState, Signorini};
use super::super::model_options::{ContactsAct, ModelMotion, ModelOptions};
use super::super::moving_model::MovingModel;
use super::super::recorded_modes::RecordedModes;
use super::super::requirement::Requirement;
use super::super::slip_rows::SlipRows;
use super::ReducedInterface;
use super::contact_set::{ContactSet, Contacts};
use super::effective_mass::EffectiveMass;
use super::gap_law::GapTerm;
use super::own_step::OwnStep;
use super::targets::Targets;
use crate::cosim::{Sequence, Side};
use crate::error::{Error, Result};
use crate::interface_model::{Condensation, MEMORY_LIMIT, ReducedInterfaceModel};
use rimbench_contact::affine_step::DiscretisedModel;
use rimbench_contact::affine_step::{AffineStep, DenseFactor, ModeFactor, SparseSetFactor, StepContactLaw};
use rimbench_contact::complementarity::SparseSolver;

/// Square matrices over all contacts of a scheme that keeps every entry, at most: discretised and condensed forms,
/// contact problems, workspaces of two solvers.
const SQUARES: u64 = 12;

impl GapTerm {
    /// Returns the gap term of these contacts; the force of compliant ones follows from their gap.
    ///
    /// From one step of the mechanics to the next its law goes on with the gaps.
    pub(super) fn of(
        contacts: Contacts,
        detection: Option<ContactDetection>,
        compliant: bool,
        act: ContactsAct,
    ) -> Self {
        match (contacts, detection) {
            (Contacts::UnilateralWithGaps, _) => GapTerm::Tracked,
            (_, Some(ContactDetection::MechanicsLaw)) if act == ContactsAct::MechanicsStep => GapTerm::Tracked,
            (_, Some(ContactDetection::MechanicsLaw)) => GapTerm::Frozen,
            (Contacts::Unilateral, _) if compliant => GapTerm::Tracked,
            _ => GapTerm::None,
        }
    }
}

/// Refuses to keep every entry of the matrices of so many contacts, of which the mechanics keeps the non-zeros only.
///
/// # Errors
/// [`Error::Incompatible`] beyond `limit` bytes, with what is needed, at most.
pub(super) fn must_hold_every_entry(contacts: usize, limit: u64) -> Result<()> {
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

/// Tells whether micro steps that keep their active set are affine in state and force.
fn is_affine(contacts: Contacts, empty: &ReducedInterfaceModel, options: &ModelOptions) -> bool {
    // A solver chosen by name solves every problem; with stiction the coefficient of friction changes between micro
    // steps.
    !contacts.are_bilateral()
        && options.model_motion != ModelMotion::Extrapolated
        && options.solver.goes_by_active_sets()
        && empty.spring.is_none()
        && empty.stiction.is_none()
}

/// Makes the solver of the contacts, and the discretised model that it works on.
fn model_contacts(
    contacts: Contacts,
    detection: Option<ContactDetection>,
    empty: &ReducedInterfaceModel,
    options: &ModelOptions,
) -> Result<(ModelContacts, DiscretisedModel)> {
    let (n_u, n_i, first) = (empty.contacts(), empty.interface(), empty.interface_start());
    let affine = is_affine(contacts, empty, options);
    // All contacts are in the set, so that the pattern of the mechanics is that of the model.
    let all = matches!(detection, None | Some(ContactDetection::MechanicsLaw));
    if let Some(pattern) = empty.delassus_pattern().filter(|_| affine && all) {
        let solver = SparseSolver::new(pattern, options.solver.tolerance);
        let step = AffineStep::new(n_u, n_i, SparseSetFactor::new(solver.solver.factor(), n_u, n_i));
        let contacts = Complementarity::new(solver, Some(step), empty);
        return Ok((ModelContacts::Sparse(Box::new(contacts)), DiscretisedModel::by_pattern(pattern.clone(), n_i)));
    }
    if empty.delassus_pattern().is_some() {
        must_hold_every_entry(n_u, MEMORY_LIMIT)?;
    }
    let solved = if contacts.are_bilateral() {
        ModelContacts::Bilateral
    } else if let Some(solver) = SpaceContacts::of(empty, &options.solver) {
        ModelContacts::Space(Box::new(Complementarity::new(*solver, None, empty)))
    } else if let Some(solver) = CoulombContacts::of(empty, &options.solver) {
        let step = affine.then(|| AffineStep::new(first, n_i, ModeFactor::new(n_u)));
        ModelContacts::Coulomb(Box::new(Complementarity::new(*solver, step, empty)))
    } else {
        let step = affine.then(|| AffineStep::new(n_u, n_i, DenseFactor::new(n_u, n_i)));
        let solver = Signorini(options.solver.checked(n_u));
        ModelContacts::Signorini(Box::new(Complementarity::new(solver, step, empty)))
    };
    Ok((solved, DiscretisedModel::new(first, n_i)))
}

impl ReducedInterface {
    /// Describes the scheme with this treatment of contacts.
    pub(in super::super) fn entry(name: &'static str, about: &'static str, contacts: Contacts) -> SchemeEntry {
        let usual = |default| Some(DetectionRule { default, has_law: contacts != Contacts::Bilateral });
        SchemeEntry {
            family: Family::Model,
            contact_detection: match contacts {
                Contacts::UnilateralWithGaps => None,
                _ => usual(ContactDetection::Active),
            },
            order: 2,
            sequence: Sequence::GaussSeidel { first: Side::Actuator },
            needs: match contacts {
                Contacts::Bilateral => {
                    vec![Requirement::ForceDisplacement, Requirement::InterfaceModel, Requirement::NotMechanicsFirst]
                }
                _ => vec![
                    Requirement::ForceDisplacement,
                    Requirement::InterfaceModel,
                    Requirement::ListedContacts,
                    Requirement::NotMechanicsFirst,
                ],
            },
            moves_model: true,
            slides: !contacts.are_bilateral(),
            acts_over_mechanics_step: !contacts.are_bilateral(),
            ..SchemeEntry::new(name, about, move |construction| Ok(Box::new(Self::new(contacts, construction)?)))
        }
    }

    pub(in super::super) fn new(contacts: Contacts, construction: &Construction<'_>) -> Result<Self> {
        let ModelConstruction { empty, options, detection } = construction.model()?;
        let slip_rows = SlipRows::of(empty, options);
        let empty = slip_rows.as_ref().map_or(empty, |rows| rows.plane());
        let (n_u, n_i, first) = (empty.contacts(), empty.interface(), empty.interface_start());
        let (solved, discretised) = model_contacts(contacts, detection, empty, options)?;
        let active = match contacts {
            Contacts::BilateralActive => ActiveContacts::of(empty, &options.solver),
            _ => ActiveContacts::none(&options.solver),
        };
        // A model without contacts has none that could act, and may stand for a mechanics that is solved exactly.
        let acts = options.contacts_act == ContactsAct::MechanicsStep && n_u > 0;
        Ok(ReducedInterface {
            own: acts.then(|| Box::new(OwnStep::new(&discretised, (n_u, first, n_i)))),
            set: ContactSet::new(contacts, detection, n_u, active),
            model: MovingModel::new(empty, options.model_motion),
            discretised,
            condensation: Condensation::of(empty),
            modes: RecordedModes::of(empty),
            contacts: solved,
            gap_term: match empty.has_targets {
                true => GapTerm::None,
                false => GapTerm::of(contacts, detection, empty.spring.is_some(), options.contacts_act),
            },
            law: StepContactLaw::default(),
            state: ModelState::new(n_u, first, n_i),
            force: vec![0.0; n_i],
            feedthrough: ImplicitFeedthrough::new(n_i),
            contact_step: f64::NAN,
            micro_step: f64::NAN,
            engine_steps: 1,
            targets: Targets::default(),
            mass: EffectiveMass::new(empty),
            slip_rows,
        })
    }
}

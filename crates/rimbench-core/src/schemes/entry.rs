//! What the list of schemes holds about each one.

use super::contact_choice::ContactChoice;
use super::need::Need;
use crate::complementarity::SolverEntry;
use crate::cosim::{CouplingScheme, ForceReturn, Ports, Sequence, Side, Subsystem};
use crate::error::{Error, Result, find_by_name};
use crate::interface_model::Redundancy;
use std::fmt;
use std::str::FromStr;

/// Where a scheme takes its picture of the other side from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Past samples of the coupling variables only.
    Signal,
    /// A reduced interface model.
    Model,
    /// The other side itself: steps are taken again, or both sides together. Not real-time; what the others are held against.
    Ceiling,
}

/// What happens to the matrices of a reduced interface model within a macro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ModelMotion {
    /// `H` and `a` stay as they were at `t_k`.
    #[default]
    Frozen,
    /// `H` and `a` go on linearly from the last two communication points; frozen after a change of the contact set.
    Extrapolated,
}

impl ModelMotion {
    const NAMES: [(&'static str, ModelMotion); 2] =
        [("frozen", ModelMotion::Frozen), ("extrapolated", ModelMotion::Extrapolated)];
}

impl fmt::Display for ModelMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::NAMES[*self as usize].0)
    }
}

impl FromStr for ModelMotion {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        find_by_name("model motion", &Self::NAMES, |(name, _)| name, text).map(|(_, motion)| *motion)
    }
}

/// The one number by which a scheme can be tuned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// What it does.
    pub about: &'static str,
    /// Used unless another is asked for.
    pub default: f64,
    /// Least and greatest value that make sense.
    pub range: [f64; 2],
}

/// Options of the schemes. Redundancy, motion and solver concern the model-based ones only.
#[derive(Debug, Clone, Copy)]
pub struct SchemeOptions {
    /// Treatment of dependent contacts where they become bilateral.
    pub redundancy: Redundancy,
    /// Frozen or extrapolated model.
    pub motion: ModelMotion,
    /// Contacts that take part within a macro step (non-smooth models only).
    pub contacts: ContactChoice,
    /// Solver of the complementarity problems inside the scheme.
    pub solver: &'static SolverEntry,
    /// Value of the scheme's gain; its default if none.
    pub gain: Option<f64>,
}

impl SchemeOptions {
    /// The defaults, with `solver` for the complementarity problems inside the scheme.
    pub fn of(solver: &'static SolverEntry) -> Self {
        SchemeOptions {
            redundancy: Redundancy::Drop,
            motion: ModelMotion::Frozen,
            contacts: ContactChoice::All,
            solver,
            gain: None,
        }
    }

    /// The same with a choice of contacts by name; without a name as it is.
    ///
    /// # Errors
    /// [`Error::UnknownName`] or [`Error::InvalidValue`]; [`Error::Incompatible`] with an extrapolated model, whose rates would
    /// take up the loads of contacts left out.
    pub fn with_contacts(self, contacts: Option<&str>) -> Result<Self> {
        let Some(contacts) = contacts.map(str::parse).transpose()? else { return Ok(self) };
        if contacts != ContactChoice::All && self.motion == ModelMotion::Extrapolated {
            return Err(Error::Incompatible(format!(
                "contacts = {contacts} does not go with an extrapolated model: use model_motion `frozen` or contacts `all`"
            )));
        }
        Ok(SchemeOptions { contacts, ..self })
    }
}

/// A coupling scheme by name.
#[derive(Debug, Clone, Copy)]
pub struct SchemeEntry {
    /// Kebab-case name.
    pub name: &'static str,
    /// One line.
    pub about: &'static str,
    /// Signal- or model-based, or a ceiling.
    pub family: Family,
    /// Declared order in H of the coupling itself: smooth system, exact subsystems, default force return.
    pub order: u32,
    /// Samples of the past that the scheme needs to be what it is; with fewer it falls back to less.
    pub samples: usize,
    /// Sequence used unless another is asked for.
    pub sequence: Sequence,
    /// What both sides must offer; a run between others is skipped with the reason.
    pub needs: &'static [Need],
    /// What can be tuned, if anything.
    pub gain: Option<Gain>,
    /// Builds the scheme for a pair of subsystems' ports (mechanics, actuator).
    pub build: fn(&Ports, &Ports, &SchemeOptions) -> Box<dyn CouplingScheme>,
}

impl SchemeEntry {
    /// The sequence and force return to use, given what the user asked for.
    ///
    /// Where only one is given the other follows: a force return other than `held` needs the actuator first; a
    /// Gauss–Seidel sequence with the actuator first returns the mean.
    ///
    /// # Errors
    /// [`Error::Incompatible`] where both are given and do not go together, or where a model-based scheme is asked to
    /// let the mechanics go first.
    pub fn sequence_and_return(
        &self,
        sequence: Option<Sequence>,
        force_return: Option<ForceReturn>,
    ) -> Result<(Sequence, ForceReturn)> {
        let actuator_first = Sequence::GaussSeidel { first: Side::Actuator };
        let sequence = match (sequence, force_return) {
            (Some(sequence), _) => sequence,
            (None, Some(ForceReturn::Held)) => Sequence::Jacobi,
            (None, Some(_)) => actuator_first,
            (None, None) => self.sequence,
        };
        let held = sequence != actuator_first || self.needs.contains(&Need::HeldReturn);
        let default_return = if held { ForceReturn::Held } else { ForceReturn::Mean };
        let force_return = force_return.unwrap_or(default_return);
        self.check_sequence(sequence)?;
        force_return.check(sequence)?;
        self.check_force_return(force_return)?;
        Ok((sequence, force_return))
    }

    /// Checks that the scheme can live with a force return.
    ///
    /// # Errors
    /// [`Error::Incompatible`] where the scheme acts through the force it hands to the mechanics and would be bypassed.
    pub fn check_force_return(&self, force_return: ForceReturn) -> Result<()> {
        if self.needs.contains(&Need::HeldReturn) && force_return != ForceReturn::Held {
            return Err(Error::Incompatible(format!(
                "scheme `{}` acts through the force it hands to the mechanics, which force return `{force_return}` \
                 replaces: use force return `held`",
                self.name
            )));
        }
        Ok(())
    }

    /// The value of the gain to use: the one asked for, else the default; none where the scheme has no gain.
    ///
    /// # Errors
    /// [`Error::Incompatible`] where a gain is asked for that the scheme does not have; [`Error::InvalidValue`] for one
    /// outside its range.
    pub fn gain_value(&self, asked: Option<f64>) -> Result<Option<f64>> {
        match (self.gain, asked) {
            (None, None) => Ok(None),
            (Some(gain), None) => Ok(Some(gain.default)),
            (None, Some(value)) => {
                let tunable: Vec<&str> = super::all_schemes()
                    .iter()
                    .filter(|scheme| scheme.gain.is_some())
                    .map(|scheme| scheme.name)
                    .collect();
                Err(Error::Incompatible(format!(
                    "gain = {value}: scheme `{}` has no gain; schemes that have one: {}",
                    self.name,
                    tunable.join(", ")
                )))
            }
            (Some(gain), Some(value)) => {
                let [least, greatest] = gain.range;
                if !(least..=greatest).contains(&value) {
                    let expected = format!("a number from {least} to {greatest} ({})", gain.about);
                    return Err(Error::invalid("gain", value, expected));
                }
                Ok(Some(value))
            }
        }
    }

    /// Checks that the scheme can live with a sequence.
    ///
    /// # Errors
    /// [`Error::Incompatible`] where a model-based scheme would have to let the mechanics go first.
    pub fn check_sequence(&self, sequence: Sequence) -> Result<()> {
        if self.family == Family::Model && sequence == (Sequence::GaussSeidel { first: Side::Mechanics }) {
            return Err(Error::Incompatible(format!(
                "scheme `{}` lets the actuator move together with a model of the mechanics, so the actuator goes \
                 first: use sequence `gauss-seidel` or `jacobi`",
                self.name
            )));
        }
        Ok(())
    }

    /// Whether no step is ever taken again, so that the scheme can run in real time.
    pub fn real_time(&self) -> bool {
        self.family != Family::Ceiling
    }

    /// Why this scheme cannot couple these subsystems, if it cannot.
    pub fn incompatibility(&self, mechanics: &dyn Subsystem, actuator: &dyn Subsystem) -> Option<String> {
        self.needs.iter().find_map(|need| need.unmet(mechanics, actuator))
    }
}

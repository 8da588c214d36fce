//! An entry of a list of schemes.

use super::construction::{Construction, ModelConstruction};
use super::contact_detection::{ContactDetection, DetectionRule};
use super::coupling::Coupling;
use super::model_options::{ContactsAct, FrictionRows, ModelMotion, ModelOptions};
use super::requirement::Requirement;
use crate::cosim::{
    CouplingScheme, ExchangeData, ForceReturn, LineForces, Sequence, Side, Sides, StarPlan, cannot_divide,
    check_coupling,
};
use crate::error::{Error, Result};
use crate::iterative::IterativeDriver;
use crate::name::Name;
use std::fmt;
use std::sync::Arc;

/// Where a scheme takes its picture of the other side from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Samples of the coupling variables only.
    Signal,
    /// A reduced interface model.
    Model,
}

/// The one number by which a scheme can be tuned.
#[derive(Debug, Clone, PartialEq)]
pub struct Gain {
    /// Its working, in one sentence.
    pub about: Name,
    /// Used unless another is asked for.
    pub default: f64,
    /// Least and greatest value that make sense.
    pub range: [f64; 2],
}

/// Builds a scheme, with all its buffers.
pub type BuildScheme = Arc<dyn Fn(&Construction<'_>) -> Result<Box<dyn CouplingScheme>> + Send + Sync>;

/// A coupling scheme by name.
#[derive(Clone)]
pub struct SchemeEntry {
    /// Kebab-case name.
    pub name: Name,
    /// One line.
    pub about: Name,
    /// Signal- or model-based.
    pub family: Family,
    /// Declared order in H of the coupling itself: smooth system, exact subsystems, default force return.
    pub order: u32,
    /// Samples of the past that the scheme needs to be what it is; with fewer it falls back to less.
    pub samples: usize,
    /// Sequence used unless another is asked for.
    pub sequence: Sequence,
    /// Requirements on both sides; a run between others is skipped with the reason. The data exchanged besides outputs
    /// follow.
    pub needs: Vec<Requirement>,
    /// How contacts are detected, if that is left open.
    pub contact_detection: Option<DetectionRule>,
    /// Its parameter, if it has one.
    pub gain: Option<Gain>,
    /// Whether its frozen model has all contacts under the mechanics' own contact law, so that it is the mechanics
    /// itself where that does not change within a macro step.
    pub has_mechanics_law: bool,
    /// The scheme moves a reduced interface model within the macro step, which may be frozen or not.
    pub moves_model: bool,
    /// Contacts of its model stick and slide within the macro step, which leaves a choice of their tangential rows.
    pub slides: bool,
    /// Contacts of its model may act over the mechanics' own step.
    pub acts_over_mechanics_step: bool,
    /// The bonds that it is a name for; none: one, unless others are asked for.
    pub bonds: Option<StarPlan>,
    /// Digest of its code, a part of what determines a run; none of what is built in, whose code has a version.
    pub digest: Option<Name>,
    /// Whether it is code in a process of its own, or of another language: only the wall clock tells what it takes.
    pub waits: bool,
    /// By what it is run. Only what the loop itself runs can run in real time.
    pub driver: IterativeDriver,
    /// Builds the scheme.
    pub build: BuildScheme,
}

impl fmt::Debug for SchemeEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SchemeEntry").field("name", &self.name).finish_non_exhaustive()
    }
}

impl SchemeEntry {
    /// Describes a scheme of first order that extrapolates one sample, needs nothing, and lets both sides step at once.
    /// What is different is changed afterwards.
    pub fn new(
        name: impl Into<Name>,
        about: impl Into<Name>,
        build: impl Fn(&Construction<'_>) -> Result<Box<dyn CouplingScheme>> + Send + Sync + 'static,
    ) -> Self {
        SchemeEntry {
            name: name.into(),
            about: about.into(),
            family: Family::Signal,
            order: 1,
            samples: 1,
            sequence: Sequence::Jacobi,
            needs: Vec::new(),
            contact_detection: None,
            gain: None,
            has_mechanics_law: false,
            moves_model: false,
            slides: false,
            acts_over_mechanics_step: false,
            bonds: None,
            digest: None,
            waits: false,
            driver: IterativeDriver::NonIterative,
            build: Arc::new(build),
        }
    }

    /// Builds the scheme for two subsystems, with room for what they will exchange. Options and gain of none are the
    /// defaults.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for ports, needs or options that do not go together; [`Error::InvalidValue`] for a gain
    /// out of range.
    pub fn couple(&self, mut sides: Sides<'_>, options: Option<&ModelOptions>, gain: Option<f64>) -> Result<Coupling> {
        let usual = ModelOptions::default();
        let options = options.unwrap_or(&usual);
        let rates = self.needs.contains(&Requirement::OutputRates)
            || (self.needs.contains(&Requirement::OutputRatesIfFeedthrough)
                && sides.actuator.ports().direct_feedthrough);
        let mut exchange = ExchangeData::new(sides.lend(), self.has_model(), rates)
            .map_err(|failure| Error::Incompatible(failure.to_string()))?;
        let ports = sides.ports();
        check_coupling(ports)?;
        let detection = self.detection(options.detection)?;
        let model = exchange.interface_model.as_ref().map(|empty| ModelConstruction { empty, options, detection });
        if let Some(ModelConstruction { empty, options, .. }) = model {
            self.check_options(options)?;
            options.check_model(empty)?;
        }
        let gain = self.gain_value(gain)?.unwrap_or(1.0);
        let rows = ports.actuator.outputs.len();
        exchange.trials = self.needs.contains(&Requirement::Trials);
        exchange.line_forces =
            self.needs.contains(&Requirement::TransmissionLines).then(|| LineForces::new(rows, 0, gain));
        let construction = Construction { ports, model, gain };
        let scheme = (self.build)(&construction)?;
        Ok(Coupling { scheme, exchange, driver: self.driver })
    }

    /// Checks that options of a reduced interface model go together with the scheme.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for a model that is to move in a scheme that takes it at `t_k` only, for rows of
    /// contacts that are bilateral, or not in it, and for contacts that are to act over the mechanics' step in a model
    /// without any, or one that moves.
    pub fn check_options(&self, options: &ModelOptions) -> Result<()> {
        if options.model_motion != ModelMotion::Frozen && !self.moves_model {
            return Err(Error::Incompatible(format!(
                "model_motion = {} does not go with scheme {}, which looks at the model at communication points only: use model_motion \
                 `frozen`, or a scheme that moves a model within the macro step",
                options.model_motion, self.name
            )));
        }
        if options.friction_rows != FrictionRows::Cone && !self.slides {
            return Err(Error::Incompatible(format!(
                "friction_rows = {}: no contact of scheme `{}` sticks and slides within a macro step; use rim-nonsmooth or \
                 rim-nonsmooth-gap",
                options.friction_rows, self.name
            )));
        }
        if options.contacts_act == ContactsAct::MechanicsStep {
            let why = if !self.acts_over_mechanics_step {
                format!(
                    "scheme `{}` has no contacts that act within a macro step: use rim-nonsmooth or rim-nonsmooth-gap",
                    self.name
                )
            } else if options.model_motion != ModelMotion::Frozen {
                format!(
                    "model_motion = {}: the mechanics' answer over its own step is that of the model as it was sent: use model_motion `frozen`",
                    options.model_motion
                )
            } else {
                return Ok(());
            };
            return Err(Error::Incompatible(format!("contacts_act = {}: {why}", options.contacts_act)));
        }
        Ok(())
    }

    /// Tells whether both sides move as one between communication points, where nothing is exchanged and neither goes
    /// first.
    pub fn moves_as_one(&self) -> bool {
        self.driver == IterativeDriver::Monolithic
    }

    /// Tells whether the scheme is made from a reduced interface model, and so has the options of one.
    pub fn has_model(&self) -> bool {
        self.needs.contains(&Requirement::InterfaceModel)
    }

    /// Returns the sequence and the force return to use, given what the user asked for.
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
        let held = sequence != actuator_first || self.needs.contains(&Requirement::HeldReturn);
        let default_return = if held { ForceReturn::Held } else { ForceReturn::Mean };
        let force_return = force_return.unwrap_or(default_return);
        self.check_sequence(sequence)?;
        force_return.check(sequence)?;
        self.check_force_return(force_return)?;
        // With the force of the start held it makes no difference which side goes first, unless a macro step is taken
        // again.
        let as_one = force_return == ForceReturn::Held && sequence == actuator_first && self.real_time();
        Ok((if as_one { Sequence::Jacobi } else { sequence }, force_return))
    }

    /// Checks that the scheme can live with a force return.
    ///
    /// # Errors
    /// [`Error::Incompatible`] where the scheme acts through the force it hands to the mechanics and would be bypassed.
    pub fn check_force_return(&self, force_return: ForceReturn) -> Result<()> {
        if self.needs.contains(&Requirement::HeldReturn) && force_return != ForceReturn::Held {
            return Err(Error::Incompatible(format!(
                "scheme `{}` acts through the force it hands to the mechanics, which force return `{force_return}` \
                 replaces: use force return `held`",
                self.name
            )));
        }
        Ok(())
    }

    /// Checks that the scheme can live with a sequence.
    ///
    /// # Errors
    /// [`Error::Incompatible`] where a model-based scheme would have to let the mechanics go first.
    pub fn check_sequence(&self, sequence: Sequence) -> Result<()> {
        if self.needs.contains(&Requirement::NotMechanicsFirst)
            && sequence == (Sequence::GaussSeidel { first: Side::Mechanics })
        {
            return Err(Error::Incompatible(format!(
                "scheme `{}` lets the actuator move together with a model of the mechanics, so the actuator goes \
                 first: use sequence `gauss-seidel` or `jacobi`",
                self.name
            )));
        }
        if self.needs.contains(&Requirement::ActuatorFirst) && sequence == Sequence::Jacobi {
            return Err(Error::Incompatible(format!(
                "scheme `{}` asks the mechanics while the actuator steps, so the actuator must go first: use sequence `gauss-seidel` and a \
                 force return other than `held`",
                self.name
            )));
        }
        Ok(())
    }

    /// Returns the contact detection to use: the one asked for, else the default; none where the scheme detects no
    /// contacts.
    ///
    /// # Errors
    /// [`Error::Incompatible`] where one is asked for that the scheme does not have.
    pub fn detection(&self, asked: Option<ContactDetection>) -> Result<Option<ContactDetection>> {
        let refused = |asked: ContactDetection, reason: &str| {
            Err(Error::Incompatible(format!("contact_detection = {asked}: scheme `{}` {reason}", self.name)))
        };
        match (self.contact_detection, asked) {
            (None, None) => Ok(None),
            (Some(rule), None) => Ok(Some(rule.default)),
            (None, Some(asked)) if self.has_model() => refused(
                asked,
                "has no such choice: its contacts are all that there are, or those that the mechanics found closed",
            ),
            (None, Some(asked)) => refused(asked, "has no reduced interface model"),
            (Some(rule), Some(ContactDetection::MechanicsLaw)) if !rule.has_law => refused(
                ContactDetection::MechanicsLaw,
                "makes every contact bilateral that it detects, and a law is of no use there: use `active` or `margin:<m>`",
            ),
            (Some(_), Some(asked)) => Ok(Some(asked)),
        }
    }

    /// Returns the value of the gain to use: the one asked for, else the default; none where the scheme has no gain.
    ///
    /// # Errors
    /// [`Error::Incompatible`] where a gain is asked for that the scheme does not have; [`Error::InvalidValue`] for one
    /// outside its range.
    pub fn gain_value(&self, asked: Option<f64>) -> Result<Option<f64>> {
        match (&self.gain, asked) {
            (None, None) => Ok(None),
            (Some(gain), None) => Ok(Some(gain.default)),
            (None, Some(value)) => {
                Err(Error::Incompatible(format!("gain = {value}: scheme `{}` has no gain", self.name)))
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

    /// Tells whether no step is ever taken again, so that the scheme can run in real time.
    pub fn real_time(&self) -> bool {
        self.driver == IterativeDriver::NonIterative
    }

    /// Says why this scheme cannot couple these subsystems, if it cannot.
    pub fn incompatibility(&self, mut sides: Sides<'_>) -> Option<String> {
        let unmet = self.needs.iter().find_map(|need| need.unmet(sides.lend()));
        unmet.or_else(|| self.bonds.as_ref().and_then(|bonds| cannot_divide(bonds, sides)))
    }
}

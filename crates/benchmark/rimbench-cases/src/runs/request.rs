//! What a file or the command line asks of one run, in their own words.

use rimbench_core::cosim::{
    ActuatorIntegrator, Channel, ForceBridge, ForceReturn, LateRule, MechanicsIntegrator, MechanicsSteps, Sequence,
    StepControl,
};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{Belief, Redundancy};
use rimbench_core::schemes::{ContactDetection, ContactsAct, FrictionRows, ModelMotion, Split};
use std::fmt;

/// A value as a file or the command line gives it.
#[derive(Debug, Clone, PartialEq)]
pub enum Given {
    /// A word, or what is still to be read as one value or another.
    Text(String),
    /// A number; a time is in seconds.
    Number(f64),
}

impl From<f64> for Given {
    fn from(number: f64) -> Self {
        Given::Number(number)
    }
}

impl<T: AsRef<str> + ?Sized> From<&T> for Given {
    fn from(text: &T) -> Self {
        Given::Text(text.as_ref().to_owned())
    }
}

impl fmt::Display for Given {
    /// Writes a number as the shortest text that reads back to the same bits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Given::Text(text) => f.write_str(text),
            Given::Number(number) => write!(f, "{number:?}"),
        }
    }
}

/// An option of a run, for whoever offers it to a user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunOption {
    /// Its name in files and data, with the unit.
    pub key: &'static str,
    /// What it takes, in a word.
    pub takes: &'static str,
    /// What it does.
    pub about: &'static str,
}

/// Defines the request, the list of its options, and how each is read, from one list.
macro_rules! run_options {
    ($($(#[doc = $about:literal])+ $key:ident: $kind:ty, $takes:literal;)+) => {
        /// What is asked of one run; what is left out is as the case and the scheme have it. Texts are names in a
        /// [`Catalogue`](crate::catalogue::Catalogue).
        #[derive(Debug, Clone, Default, PartialEq)]
        pub struct RunRequest {
            $($(#[doc = $about])+ pub $key: Option<$kind>,)+
            /// Parameters of the case, key and value, in the order in which they are set
            pub set: Vec<(String, String)>,
        }

        impl RunRequest {
            /// All options but the parameters of the case.
            pub const OPTIONS: &'static [RunOption] =
                &[$(RunOption { key: stringify!($key), takes: $takes, about: concat!($($about),+).trim_ascii() }),+];

            /// Sets one option.
            ///
            /// # Errors
            /// [`Error::UnknownName`] for a key that is none; whatever reading a text says.
            pub fn put(&mut self, key: &str, value: impl Into<Given>) -> Result<()> {
                let value = value.into();
                match key {
                    $(stringify!($key) => self.$key = Some(<$kind as OptionValue>::read(key, value)?),)+
                    _ => return Err(Error::unknown("option", key, Self::OPTIONS.iter().map(|option| option.key))),
                }
                Ok(())
            }

            /// Lists the options that are given, with values of which [`put`](Self::put) makes the same.
            pub fn given(&self) -> Vec<(&'static str, Given)> {
                let values = [$((stringify!($key), self.$key.as_ref().map(OptionValue::write))),+];
                values.into_iter().filter_map(|(key, value)| Some((key, value?))).collect()
            }
        }
    };
}

run_options! {
    /// Case by name (see `rimbench list cases`)
    case: String, "NAME";
    /// Coupling scheme by name (see `rimbench list schemes`)
    scheme: String, "NAME";
    /// Order of the sides: jacobi, gauss-seidel (actuator first), gauss-seidel-mechanics-first
    sequence: Sequence, "ORDER";
    /// What the mechanics receives: held, end, mean, profile, pieces
    force_return: ForceReturn, "RETURN";
    /// The mechanics' own steps per macro step, or `all` for as many as the actuator takes; if not given 1, on linear cases all
    mechanics_steps: MechanicsSteps, "N";
    /// Longest step of the mechanics, s, instead of their number: a macro step has as many equal ones as it takes
    mechanics_step_s: f64, "S";
    /// How the mechanics steps: semi-implicit, midpoint, event-split; semi-implicit if not given
    mechanics_integrator: MechanicsIntegrator, "RULE";
    /// How the actuator steps: euler (its own, of the first order), midpoint; euler if not given
    actuator_integrator: ActuatorIntegrator, "RULE";
    /// Dependent contacts that become bilateral: drop, pseudo-inverse, regularised:EPS (a relative compliance)
    redundancy: Redundancy, "TREATMENT";
    /// Interface model within a macro step: frozen, extrapolated, half-kick (springs and dampers of the mechanics act at t_k), piecewise (from kink to kink of the geometry)
    model_motion: ModelMotion, "MOTION";
    /// Contacts closed for an interface model: active (of the mechanics' last step), mechanics-law, margin:M (gaps up to M metres)
    contact_detection: ContactDetection, "DETECTION";
    /// Where each of several actuators has a model of its own, what it contains of the others, and how heavy it is: mean, blind, each with :rows, :shares, :body; law; joint
    split: Split, "SPLIT";
    /// Friction of contacts in space within an interface model: cone (two rows each), slip-direction (one row along the slip at t_k)
    friction_rows: FrictionRows, "ROWS";
    /// Step over which contacts of an interface model act: micro-step (an impulse acts at once), mechanics-step (it is spread over the mechanics' own step)
    contacts_act: ContactsAct, "OVER";
    /// How samples of the mechanics reach the actuator: delay:D,jitter:J (macro steps), loss:P, seed:S, missed:K+K*L; in time if not given
    delivery_up: Channel, "HOW";
    /// How forces reach the mechanics, likewise
    delivery_down: Channel, "HOW";
    /// What the actuator makes of late samples: catch-up (uses their time, runs a model forward to the present), raw
    late_samples: LateRule, "RULE";
    /// What the mechanics makes of late forces: hold, linear, rates (a model of the actuator); hold if not given
    late_forces: ForceBridge, "RULE";
    /// What an interface model believes of the mechanics, which stays as it is: mass:RHO, friction:F (factors), gap:M (added, m), missing:C, closed:C (contacts)
    belief: Belief, "HOW";
    /// Solver of the complementarity problems (see `rimbench list solvers`); active-set if not given
    solver: String, "NAME";
    /// The scheme's gain, where it has one (see `rimbench list schemes`)
    gain: f64, "X";
    /// Macro step H, s
    macro_step_s: f64, "S";
    /// How the macro step is controlled, H being the first and the longest: none, energy-residual, energy-residual-libcosim, model-defect and model-defect-blind (of schemes with an interface model)
    step_control: StepControl, "HOW";
    /// Error allowed per macro step where the step is controlled, a pure number
    step_tolerance: f64, "TOL";
    /// Shortest macro step where the step is controlled, s; H/100 if not given
    min_macro_step_s: f64, "S";
    /// Communication phase φ in (0, 1]: the first macro step is φH long; 1 if not given
    phase: f64, "PHI";
    /// Longest micro step of the actuator side, s
    micro_step_s: f64, "S";
    /// Simulated time, s
    duration_s: f64, "S";
    /// Wall time after which the run ends with outcome `timeout`, s; none if not given
    wall_limit_s: f64, "S";
}

impl RunRequest {
    /// Asks for a case with a scheme, everything else as they have it.
    pub fn of(case: impl Into<String>, scheme: impl Into<String>) -> Self {
        RunRequest { case: Some(case.into()), scheme: Some(scheme.into()), ..RunRequest::default() }
    }

    /// Asks the same at one of the macro steps (s) that are gone through: one shorter than the mechanics' longest step is one step.
    pub fn at_macro_step(&self, macro_step: f64) -> Self {
        let mechanics_step_s = self.mechanics_step_s.map(|step| step.min(macro_step));
        RunRequest { macro_step_s: Some(macro_step), mechanics_step_s, ..self.clone() }
    }
}

/// The value of an option.
trait OptionValue: Sized {
    fn read(key: &str, given: Given) -> Result<Self>;

    fn write(&self) -> Given;
}

impl OptionValue for String {
    fn read(_key: &str, given: Given) -> Result<Self> {
        Ok(given.to_string())
    }

    fn write(&self) -> Given {
        Given::from(self)
    }
}

impl OptionValue for f64 {
    fn read(key: &str, given: Given) -> Result<Self> {
        match given {
            Given::Number(number) => Ok(number),
            Given::Text(text) => text.trim().parse().map_err(|_| Error::invalid(key, text, "a number")),
        }
    }

    fn write(&self) -> Given {
        Given::Number(*self)
    }
}

/// What says itself what is wrong with a text.
macro_rules! read_by_name {
    ($($kind:ty),+) => {
        $(impl OptionValue for $kind {
            fn read(_key: &str, given: Given) -> Result<Self> {
                given.to_string().parse()
            }

            fn write(&self) -> Given {
                Given::Text(self.to_string())
            }
        })+
    };
}

read_by_name!(
    Sequence,
    ForceReturn,
    MechanicsSteps,
    MechanicsIntegrator,
    ActuatorIntegrator,
    Redundancy,
    ModelMotion,
    ContactDetection,
    Split,
    FrictionRows,
    ContactsAct,
    Channel,
    LateRule,
    ForceBridge,
    Belief,
    StepControl
);

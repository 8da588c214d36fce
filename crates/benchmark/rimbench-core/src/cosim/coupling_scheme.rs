//! The approximation of the coupling variables between communication points.

use super::communication_grid::{MacroStep, MicroStep};
use super::input_polynomials::Cubic;
use super::output_rates::OutputRates;
use super::side::Side;
use super::transmission_lines::LineForces;
use super::trials::{TrialReport, Trials};
use crate::error::Failure;
use crate::interface_model::{ContactModes, InterfaceCorrelation, ReducedInterfaceModel};
use rimbench_contact::complementarity::SolverCounters;

/// The sample that one side sends at a communication point.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// When it was taken, s.
    pub time: f64,
    /// The outputs of the sending side.
    pub y: &'a [f64],
    /// The sender reduced to its interface, if the scheme needs it and this is the mechanics' sample of the
    /// communication point.
    pub model: Option<&'a ReducedInterfaceModel>,
    /// How the actuator's outputs move, if the scheme needs it and this is the actuator's sample of the communication
    /// point.
    pub rates: Option<&'a OutputRates>,
    /// The action of lines in the place of the actuator's oil on the mechanics over the macro step that starts here, if
    /// the scheme needs it and this is the actuator's sample of the communication point.
    pub line_forces: Option<&'a LineForces>,
    /// The macro step that starts here.
    pub step: MacroStep,
    /// Micro step of the actuator side in that macro step, s.
    pub actuator_micro_step: f64,
    /// Steps of its own that the mechanics takes in that macro step.
    pub mechanics_steps: usize,
}

impl<'a> Sample<'a> {
    /// Makes the sample of a side that sends its outputs `y` and nothing else, at the start of `step`, in which the
    /// mechanics takes one step; δ of the actuator in s.
    pub fn of_outputs(step: MacroStep, y: &'a [f64], actuator_micro_step: f64) -> Self {
        Sample {
            time: step.start,
            y,
            model: None,
            rates: None,
            line_forces: None,
            step,
            actuator_micro_step,
            mechanics_steps: 1,
        }
    }
}

/// The report of a scheme.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SchemeReport {
    /// Effective mass with the model received last, kg; `+inf` for a locked interface. Where contacts are free to open,
    /// it is that with the contacts that carried impulse in the first micro step since; if there has been none yet, in
    /// the last one before.
    pub effective_mass: Option<f64>,
    /// Energy that the scheme itself has taken out of the system since the start, J, if it does such a thing.
    pub dissipated_j: Option<f64>,
    /// How the actuators feel each other, where they have several bonds.
    pub interface: Option<InterfaceCorrelation>,
    /// What was tried of the mechanics since the start, if the scheme does such a thing.
    pub trials: Option<TrialReport>,
    /// Complementarity solves inside the scheme since the start.
    pub counters: SolverCounters,
}

/// Where a scheme's own model of the mechanics stands at the end of the micro step whose input it wrote last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast<'a> {
    /// Interface coordinates, m.
    pub position: &'a [f64],
    /// Time until its next contact closes, s, if one does.
    pub next_closing: Option<f64>,
}

/// Where the contacts of a scheme's own model end a macro step in which the model stayed as it was sent.
#[derive(Debug, Clone, Copy)]
pub struct ModelEnd<'a> {
    /// Rows of the contacts that the model has, in the model that was sent.
    pub rows: &'a [usize],
    /// Their velocities, m/s.
    pub w: &'a [f64],
    /// What bilateral contacts with friction do; none where there are none.
    pub bilateral_modes: Option<ContactModes<'a>>,
}

/// A picture of the other side between communication points: an input for each micro step.
///
/// At each communication point the loop calls [`receive`](Self::receive) for the mechanics, then for the actuator; then
/// [`input`](Self::input) once per micro step of each side. In the Gauss–Seidel sequence that starts with the
/// mechanics, the mechanics' new sample arrives before the actuator's micro steps: what was extrapolation becomes
/// interpolation.
pub trait CouplingScheme: Send {
    /// Takes note of what `from` sends at a communication point.
    ///
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure>;

    /// Writes to `u` the input of side `to` for one micro step, its mean where it changes within the step. `own` is
    /// what that side puts out at the start of the micro step; `u` holds the input used last (at the first micro step,
    /// the fresh exchange value).
    ///
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure>;

    /// Asks the mechanics, which still stands at the communication point, before an [`input`](Self::input) of the
    /// actuator with the same `own`: called of schemes that need [`Trials`](crate::schemes::Requirement::Trials).
    ///
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    fn ask(&mut self, _at: MicroStep, _own: &[f64], _mechanics: &mut dyn Trials) -> Result<(), Failure> {
        Ok(())
    }

    /// Says how the outputs of the actuator follow its inputs directly, before an [`input`](Self::input) whose `own` is
    /// what the actuator puts out in the middle of the micro step with the inputs `u` of its start (see
    /// [`ActuatorIntegrator::Midpoint`](super::ActuatorIntegrator::Midpoint)).
    ///
    /// ```text
    /// y = own + D (ū − u)        ū the mean input over the micro step, which `input` then writes
    /// ```
    /// A scheme that solves for the motion of the other side solves for `y` with it; the others need not listen.
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    #[inline]
    fn receive_feedthrough(&mut self, _feedthrough: &[f64]) -> Result<(), Failure> {
        Ok(())
    }

    /// Writes the input at the end of the micro step whose mean [`input`](Self::input) has just written, for a scheme
    /// that knows both.
    #[inline]
    fn input_at_end(&self, _to: Side, _u: &mut [f64]) {}

    /// Writes the polynomials of the inputs within the micro step whose mean [`input`](Self::input) has just written,
    /// for a subsystem that integrates polynomials (see [`InputPolynomials`](super::InputPolynomials)). False: what
    /// `input` wrote is held, in this and all other micro steps of the macro step.
    #[inline]
    fn input_polynomials(&self, _to: Side, _at: MicroStep, _polynomials: &mut [Cubic]) -> bool {
        false
    }

    /// Changes the macro step that the micro steps to come, of length `micro_step` (s), belong to, in which the
    /// mechanics takes so many steps of its own: for a model that is brought to the present over macro steps of several
    /// lengths.
    ///
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    fn change_macro_step(
        &mut self,
        _step: MacroStep,
        _micro_step: f64,
        _mechanics_steps: usize,
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Says where the scheme's own model of the mechanics has come to with the actuator's force; none from a scheme
    /// that moves no such model.
    fn forecast(&self) -> Option<Forecast<'_>> {
        None
    }

    /// Says where the contacts of the scheme's own model end the macro step; none from a scheme without one, or whose
    /// model does not stay as it was sent.
    fn model_end(&mut self) -> Option<ModelEnd<'_>> {
        None
    }

    /// Returns the mobility of the interface (1/kg, row-major) of the model received last with those of its contacts
    /// closed that carried impulse in the last micro step; none where none did, and from a scheme without a model of
    /// contacts that open.
    fn loaded_mobility(&mut self) -> Option<&[f64]> {
        None
    }

    /// Reports on the scheme's own picture of the other side. Looks at what was solved; solves no contact problem.
    fn report(&mut self) -> SchemeReport {
        SchemeReport::default()
    }

    /// Returns a copy in the present state, or nothing if the scheme cannot be copied.
    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>>;
}

//! What a catalogue holds about each case.

use super::drawing::DrawCase;
use super::reference_method::ReferenceMethod;
use crate::models::ActuatorNames;
use crate::parameter::{Parameter, ParameterSet, Parameters};
use rimbench_core::cosim::{CommunicationGrid, MechanicsSteps, PerSide, Quantity, Side, StarPlan, Subsystem};
use rimbench_core::error::{Error, Result};
use rimbench_core::mechanics::is_contact_state;
use rimbench_core::name::{Name, names};
use rimbench_core::solver_entry::SolverEntry;
use std::fmt;
use std::sync::Arc;

/// Two subsystems that fit each other, and how the case wants them recorded.
pub struct CoupledSystem {
    /// The mechanics may offer an interface model, the actuator may use it.
    pub sides: PerSide<Box<dyn Subsystem>>,
    /// Each row of the trace holds the values of the communication point before (a quirk of a published driver).
    pub late_rows: bool,
    /// Its runs end where they are no longer finite, and not beyond a multiple of the reference.
    pub unbounded: bool,
    /// Forces that follow the motion at once have no bound of their own: a sample after an impact says nothing of what
    /// they do, which the motion tells.
    pub bounded_by_motion: bool,
    /// Columns that neither side knows alone.
    pub derived: Vec<DerivedColumn>,
}

impl CoupledSystem {
    /// Puts two subsystems together that are recorded in the usual way.
    pub fn new(mechanics: impl Subsystem + 'static, actuator: impl Subsystem + 'static) -> Self {
        Self::of(PerSide { mechanics: Box::new(mechanics), actuator: Box::new(actuator) })
    }

    /// Does the same with boxes.
    pub fn of(sides: PerSide<Box<dyn Subsystem>>) -> Self {
        CoupledSystem { sides, late_rows: false, unbounded: false, bounded_by_motion: false, derived: Vec::new() }
    }
}

/// A number from some columns of a row.
pub type RowFunction = Box<dyn Fn(&[f64]) -> f64 + Send>;

/// A column computed from others of the same row, for example the energy of the whole system.
pub struct DerivedColumn {
    /// Name with unit.
    pub name: Name,
    /// The columns it is computed from.
    pub from: Vec<Name>,
    /// Its value, given theirs in the same order.
    pub value: RowFunction,
}

impl DerivedColumn {
    /// Computes `name` from the columns `from`.
    pub fn new(
        name: impl Into<Name>,
        from: impl IntoIterator<Item = impl Into<Name>>,
        value: impl Fn(&[f64]) -> f64 + Send + 'static,
    ) -> Self {
        DerivedColumn { name: name.into(), from: from.into_iter().map(Into::into).collect(), value: Box::new(value) }
    }
}

/// A state variable of a linear case that can be set and seen: what a spectral radius is probed with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StateVariable {
    /// The parameter that holds its start value.
    pub initial: Name,
    /// The column that records it.
    pub column: Name,
}

/// Times used unless others are asked for, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaseDefaults {
    /// Simulated time.
    pub duration_s: f64,
    /// Macro step.
    pub macro_step_s: f64,
    /// Longest micro step of the actuator side.
    pub micro_step_s: f64,
    /// Coarsest of the three steps of the monolithic reference.
    pub reference_step_s: f64,
    /// Distance of the stored points of the reference.
    pub reference_sampling_s: f64,
}

/// Plausibility bound of macro steps, far beyond any use, so that a slip of the exponent is an error and not an endless
/// run.
pub const MOST_STEPS: f64 = 1e7;

/// The same of what is within them: micro steps, and steps of the mechanics.
pub const MOST_SMALL_STEPS: f64 = 1e9;

/// The same of the coarsest of the three references.
const MOST_REFERENCE_STEPS: f64 = 1e8;

impl CaseDefaults {
    /// Returns the communication points of phase φ in (0, 1].
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for steps that are not positive, a macro step above the duration, and steps that are too
    /// many.
    pub fn grid(&self, phase: f64) -> Result<CommunicationGrid> {
        let CaseDefaults { duration_s, macro_step_s, micro_step_s, .. } = *self;
        let nonsense = !(macro_step_s > 0.0 && duration_s > 0.0 && duration_s.is_finite());
        if !nonsense && duration_s / macro_step_s > MOST_STEPS {
            let expected = format!("at least {:e} s for this duration", duration_s / MOST_STEPS);
            return Err(Error::invalid("macro_step_s", macro_step_s, expected));
        }
        let grid = CommunicationGrid::new(macro_step_s, phase, duration_s)?;
        if !(micro_step_s.is_finite() && micro_step_s > 0.0) {
            return Err(Error::invalid("micro_step_s", micro_step_s, "a finite time above 0 s"));
        }
        if duration_s / micro_step_s > MOST_SMALL_STEPS {
            let expected = format!("at least {:e} s for this duration", duration_s / MOST_SMALL_STEPS);
            return Err(Error::invalid("micro_step_s", micro_step_s, expected));
        }
        Ok(grid)
    }

    /// Checks the steps of the reference: one that would never end is found before it is begun.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a duration with too many points, or a step longer than their distance or shorter
    /// than any use.
    pub fn check_reference(&self) -> Result<()> {
        let (step, sampling) = (self.reference_step_s, self.reference_sampling_s);
        if self.duration_s / sampling > MOST_STEPS {
            let expected =
                format!("at most {:e} s, for which the reference has {MOST_STEPS:e} points", MOST_STEPS * sampling);
            return Err(Error::invalid("duration_s", self.duration_s, expected));
        }
        let least = self.duration_s / MOST_REFERENCE_STEPS;
        if !(step >= least && step <= sampling) {
            let expected =
                format!("a time from {least:e} s to {sampling:e} s, the distance of the points of the reference");
            return Err(Error::invalid("reference_step_s", format!("{step:e}"), expected));
        }
        Ok(())
    }
}

/// Simulated time, macro step, longest micro step, then step and sampling of the reference, s.
pub(super) fn times(duration_s: f64, macro_step_s: f64, micro_step_s: f64, reference: [f64; 2]) -> CaseDefaults {
    let [reference_step_s, reference_sampling_s] = reference;
    CaseDefaults { duration_s, macro_step_s, micro_step_s, reference_step_s, reference_sampling_s }
}

/// What a case is there for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Purpose {
    /// To tell schemes apart.
    #[default]
    Schemes,
    /// To time solvers and detection with many contacts.
    Speed,
}

impl fmt::Display for Purpose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Purpose::Schemes => "schemes",
            Purpose::Speed => "speed",
        })
    }
}

/// Which columns hold the coupling variables of one row of the interface, by which accuracy is judged.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InterfaceColumns {
    /// Position along the interface.
    pub position: Name,
    /// Velocity along the interface.
    pub velocity: Name,
    /// Force across the interface.
    pub force: Name,
}

impl InterfaceColumns {
    /// Names the three columns.
    pub fn new(position: impl Into<Name>, velocity: impl Into<Name>, force: impl Into<Name>) -> Self {
        InterfaceColumns { position: position.into(), velocity: velocity.into(), force: force.into() }
    }

    /// The rows of actuators side by side.
    pub(super) fn of(actuators: &[ActuatorNames]) -> Vec<Self> {
        actuators.iter().map(|own| InterfaceColumns::new(own.position, own.velocity, own.force)).collect()
    }
}

/// Lists columns; one with a `*` stands for that of each contact, as in `gap_*_m`.
pub(super) fn of_contacts(contacts: &[&str], columns: &str) -> Vec<Name> {
    let each = |column: &str| -> Vec<Name> {
        let of = |contact: &&str| column.replace('*', contact).into();
        if column.contains('*') { contacts.iter().map(of).collect() } else { vec![column.to_owned().into()] }
    };
    columns.split_whitespace().flat_map(each).collect()
}

/// The columns of a trace: time, the case's own, what each row of the interface exchanges, the force that the mechanics
/// gets, and what else there is, with a `*` for each contact.
pub(super) fn trace_of(interface: &[InterfaceColumns], own: &str, contacts: &[&str], more: &str) -> Vec<Name> {
    let exchanged = interface.iter().flat_map(|row| [&row.position, &row.velocity, &row.force]).cloned();
    let more = of_contacts(contacts, &format!("force_to_mechanics_n {more}"));
    of_contacts(&[], &format!("time_s {own}")).into_iter().chain(exchanged).chain(more).collect()
}

/// Which steps a side can take.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PossibleSteps {
    /// Steps of one length only, all through a run.
    pub equal: bool,
    /// Multiples of this only, s.
    pub multiple_of: Option<f64>,
}

/// Share of a step by which it may miss a multiple.
const SAME_STEP: f64 = 1e-6;

impl PossibleSteps {
    /// Tells whether a step (s) is a multiple of what it must be one of.
    pub fn allows(&self, step: f64) -> bool {
        let is_multiple = |count: f64| count.round() >= 1.0 && (count - count.round()).abs() < SAME_STEP;
        self.multiple_of.is_none_or(|unit| is_multiple(step / unit))
    }

    /// Tells whether all steps of a run must be of one length.
    pub fn are_fixed(&self) -> bool {
        self.equal || self.multiple_of.is_some()
    }
}

/// Of these many multiples of what a side takes one is looked for that would do.
pub const MOST_MULTIPLES: u32 = 10_000;

/// What a case is built with in addition to its parameters.
#[derive(Debug, Clone, Copy)]
pub struct Assembly<'a> {
    /// All parameters.
    pub parameters: &'a Parameters,
    /// Serves the complementarity problems of the mechanics.
    pub solver: &'a SolverEntry,
}

/// Says what runs with these parameters are held against.
pub type ChooseReference = Arc<dyn Fn(&Parameters) -> Result<ReferenceMethod> + Send + Sync>;

/// Builds both sides. The solver serves the complementarity problems of the mechanics.
pub type BuildCase = Arc<dyn Fn(&Parameters, &SolverEntry) -> Result<CoupledSystem> + Send + Sync>;

/// Magnitudes that the motion of an interface has in a case: its own scale, against which a motion or a force may be
/// nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Of positions.
    pub position_m: f64,
    /// Of velocities.
    pub velocity_m_s: f64,
    /// Of forces.
    pub force_n: f64,
}

impl Scale {
    /// Returns that of a quantity, in its unit; 0 of a pressure, of which none is declared.
    pub fn of(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Position => self.position_m,
            Quantity::Velocity => self.velocity_m_s,
            Quantity::Force => self.force_n,
            Quantity::Pressure => 0.0,
        }
    }
}

/// A case by name.
#[derive(Clone)]
pub struct Case {
    /// Kebab-case name.
    pub name: Name,
    /// One line.
    pub about: Name,
    /// What it is there for.
    pub purpose: Purpose,
    /// Everything that can be set.
    pub parameters: Vec<Parameter>,
    /// Times.
    pub defaults: CaseDefaults,
    /// Columns of a trace, in order; the first is the time.
    pub trace_columns: Vec<Name>,
    /// Further columns, not in the trace: for drawings, and what metrics need.
    pub drawing_columns: Vec<Name>,
    /// What accuracy is judged by: one entry per row of the interface. With several the worst row counts.
    pub interface_columns: Vec<InterfaceColumns>,
    /// Its own scale: the largest magnitudes at the defaults; none where these are not known.
    pub scale: Option<Scale>,
    /// The macro step at which a page first shows it, ms; its usual one unless it is told.
    pub shown_step_ms: f64,
    /// All state variables, positions first, then their velocities in the same order, if the case is linear for at
    /// least some of its parameters; else none.
    pub linear_state: Vec<StateVariable>,
    /// Whether mass matrix, applied forces and Jacobians of the mechanics are the same in all states, joints closed,
    /// friction at most at contacts that are not redundant: an interface model with all contacts then *is* the
    /// mechanics (`RunSpec::model_is_exact`).
    pub constant_mechanics: bool,
    /// What runs are held against.
    pub reference: ChooseReference,
    /// The case whose reference runs are held against instead, with the same parameters; none: they are held against
    /// their own.
    pub judged_by: Option<Arc<Case>>,
    /// Digest of its code, a part of what determines a run and its reference; none of what is built in.
    pub digest: Option<Name>,
    /// Whether code from outside has a part in it: no reference of it is kept then, because nothing tells when that
    /// code changes.
    pub from_outside: bool,
    /// Whether a side is an FMU or a class of Python, perhaps in a process of its own: only the wall clock tells what
    /// its steps take.
    pub waits: bool,
    /// Which steps each side can take.
    pub steps: PerSide<PossibleSteps>,
    /// The bonds that its runs have unless an option says otherwise; none: one.
    pub bonds: Option<StarPlan>,
    /// Builds both sides.
    pub build: BuildCase,
    /// What it looks like.
    pub drawing: DrawCase,
}

impl fmt::Debug for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Case").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Case {
    /// Describes a case that records the time only, and whose reference is refined. Its parameters are the fields of
    /// what it is built from. What is different is changed afterwards.
    pub fn new<P: ParameterSet>(
        name: impl Into<Name>,
        about: impl Into<Name>,
        defaults: CaseDefaults,
        build: impl Fn(&P, &Assembly<'_>) -> Result<CoupledSystem> + Send + Sync + 'static,
    ) -> Self {
        Case::with_parameters(name, about, defaults, P::declared(), move |parameters, solver| {
            build(&P::read(parameters), &Assembly { parameters, solver })
        })
    }

    /// Does the same for a case whose parameters are known only when the program runs.
    pub fn with_parameters(
        name: impl Into<Name>,
        about: impl Into<Name>,
        defaults: CaseDefaults,
        parameters: Vec<Parameter>,
        build: impl Fn(&Parameters, &SolverEntry) -> Result<CoupledSystem> + Send + Sync + 'static,
    ) -> Self {
        Case {
            name: name.into(),
            about: about.into(),
            purpose: Purpose::Schemes,
            parameters,
            defaults,
            trace_columns: names(&["time_s"]),
            drawing_columns: Vec::new(),
            interface_columns: Vec::new(),
            scale: None,
            shown_step_ms: 1e3 * defaults.macro_step_s,
            linear_state: Vec::new(),
            constant_mechanics: false,
            reference: Arc::new(|_| Ok(ReferenceMethod::Refined)),
            judged_by: None,
            digest: None,
            from_outside: false,
            waits: false,
            steps: PerSide::default(),
            bonds: None,
            build: Arc::new(build),
            drawing: Arc::new(|_| None),
        }
    }

    /// Returns the parameters at their defaults.
    pub fn default_parameters(&self) -> Parameters {
        Parameters::defaults(self.name.clone(), &self.parameters)
    }

    /// The mechanics' own steps per macro step unless others are asked for: one; on a linear case as many as the
    /// actuator takes, so that what is seen is the coupling.
    pub fn usual_mechanics_steps(&self) -> MechanicsSteps {
        if self.linear_state.is_empty() { MechanicsSteps::ONE } else { MechanicsSteps::AsActuator }
    }

    /// Tells whether a side takes steps of one length only: a run then is at phase 1, and ends with its last whole
    /// macro step.
    pub fn has_fixed_steps(&self) -> bool {
        Side::BOTH.into_iter().any(|side| self.steps[side].are_fixed())
    }

    /// The time (s) of which macro steps must be multiples where the mechanics takes so many steps in each; none where
    /// they may be of any length.
    pub fn unit_of_macro_steps(&self, mechanics_steps: u32) -> Option<f64> {
        let PerSide { mechanics, actuator } = self.steps;
        let own = mechanics.multiple_of.map(|unit| f64::from(mechanics_steps) * unit);
        let Some((unit, other)) = own.zip(actuator.multiple_of) else { return own.or(actuator.multiple_of) };
        let mut multiples = (1..=MOST_MULTIPLES).map(|count| f64::from(count) * unit);
        // Without a common one no macro step suits both, and each run is skipped with that reason.
        multiples.find(|step| actuator.allows(*step)).or(Some(unit.max(other)))
    }

    /// Tells whether both sides may be asked for a step (s).
    pub fn allows_step(&self, step: f64) -> bool {
        Side::BOTH.into_iter().all(|side| self.steps[side].allows(step))
    }

    /// Gives a case its scale: m, m/s, N.
    pub(super) fn scaled(self, position_m: f64, velocity_m_s: f64, force_n: f64) -> Self {
        Case { scale: Some(Scale { position_m, velocity_m_s, force_n }), ..self }
    }

    /// Says at which macro step, ms, a page first shows it.
    pub(super) fn shown_at(self, step_ms: f64) -> Self {
        Case { shown_step_ms: step_ms, ..self }
    }

    /// Returns the scale of a column of the interface, in its unit; none of others, and where the case declares none.
    pub fn scale_of(&self, column: &str) -> Option<f64> {
        let scale = self.scale?;
        self.interface_columns.iter().find_map(|row| match column {
            _ if *row.position == *column => Some(scale.position_m),
            _ if *row.velocity == *column => Some(scale.velocity_m_s),
            _ if *row.force == *column => Some(scale.force_n),
            _ => None,
        })
    }

    /// Tells whether runs record what contacts with friction do.
    pub fn records_friction(&self) -> bool {
        self.trace_columns.iter().chain(&self.drawing_columns).any(|column| is_contact_state(column))
    }

    /// Returns all columns that a run records: those of the trace, then those of drawings.
    pub fn recorded_columns(&self) -> Vec<String> {
        self.trace_columns.iter().chain(&self.drawing_columns).map(|name| name.clone().into_owned()).collect()
    }
}

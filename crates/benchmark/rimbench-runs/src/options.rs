//! The options of a run, in one list: what each takes and does, what it is of, when it is in vain, where its value
//! goes, and what it says of a run. Command line, experiments, Python, run ids and tables read it.

use super::fact::{Fact, FactValue};
use super::given::Given;
use super::perturbation::Perturbation;
use super::spec::RunSpec;
use rimbench_cases::cases::Case;
use rimbench_core::cosim::{
    ActuatorIntegrator, Channel, Every, Exchange, ForceBridge, ForceReturn, Known, LateRule, MassLearning,
    MechanicsIntegrator, MechanicsSteps, MicroSteps, Order, Partition, Sequence, Share, StarPlan, StepControl, Tells,
    TrialSettings,
};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::Belief;
use rimbench_core::parts;
use rimbench_core::schemes::{
    ContactDetection, ContactsAct, FrictionRows, ModelMotion, ModelOptions, Requirement, SchemeEntry,
};
use std::fmt::Display;

/// What an option is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OptionOf {
    /// What is run, for how long, in which macro steps.
    Run,
    /// The coupling scheme.
    Scheme,
    /// The macro loop: how both sides step and exchange.
    Loop,
    /// The reduced interface model.
    Model,
}

/// What a scheme must have for an option to mean anything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Needs {
    Nothing,
    /// Sides that step between communication points, each for itself.
    Exchange,
    /// A reduced interface model.
    Model,
    /// Steps of the mechanics that are tried.
    Trials,
}

impl Needs {
    /// Says what a scheme lacks.
    fn lacks(self, scheme: &SchemeEntry) -> Option<&'static str> {
        match self {
            Needs::Nothing => None,
            Needs::Exchange => scheme
                .moves_as_one()
                .then_some("has no such choice, because its sides move as one between communication points"),
            Needs::Trials => (!scheme.needs.contains(&Requirement::Trials))
                .then_some("tries no steps of the mechanics: use rim-answers"),
            Needs::Model => (!scheme.has_model()).then_some("has no reduced interface model"),
        }
    }
}

/// An option of a run, for whoever offers it to a user.
#[derive(Debug, Clone, Copy)]
pub struct RunOption {
    /// Its name in files and data, with the unit.
    pub key: &'static str,
    /// What it takes, in a word.
    pub takes: &'static str,
    /// What it does.
    pub about: &'static str,
    /// What it is of.
    pub of: OptionOf,
    needs: Needs,
    given: fn(&RunRequest) -> Option<Given>,
    fact: fn(&RunSpec) -> Option<Fact>,
}

/// Where the values of options go that mean the same for every case and scheme.
pub(super) struct Parts {
    pub(super) exchange: Exchange,
    pub(super) model: ModelOptions,
}

/// Defines the request and the list of its options. Of each: name, type, what it takes in a word, what it is of and
/// what that needs, the part in which its value has the same name, and what it says: of `all` runs, of `some`, so that
/// others keep their ids, or of `none`; the value itself if that is left out, of `some` only where it is not the usual
/// one, that of `Exchange::new` or `ModelOptions::default()`.
macro_rules! run_options {
    ($($(#[doc = $about:literal])+ $key:ident: $kind:ident, $takes:literal, $of:ident $(($needs:ident))?
        $(=> $part:ident)?, $whose:ident $(|$run:ident| $says:expr)?;)+) => {
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
            pub const OPTIONS: &'static [RunOption] = &[$(RunOption {
                key: stringify!($key),
                takes: $takes,
                about: concat!($($about),+).trim_ascii(),
                of: OptionOf::$of,
                needs: run_options!(@needs $($needs)?),
                given: |request| request.$key.as_ref().map(|value| run_options!(@write $kind value)),
                fact: run_options!(@fact $whose $key $kind $($part)?, $(|$run| $says)?),
            }),+];

            /// Sets one option.
            ///
            /// # Errors
            /// [`Error::UnknownName`] for a key that is none; whatever reading a text says.
            pub fn put(&mut self, key: &str, value: impl Into<Given>) -> Result<()> {
                let value = value.into();
                if let Some(parts) = step_control_parts(key, &value)? {
                    return parts.into_iter().try_for_each(|(key, value)| self.put(key, &value));
                }
                match key {
                    $(stringify!($key) => self.$key = Some(run_options!(@read $kind key value)),)+
                    _ => return Err(Error::unknown("option", key, Self::OPTIONS.iter().map(|option| option.key))),
                }
                Ok(())
            }

            /// Puts the values that need nothing else to be understood into their places.
            pub(super) fn fill(&self, parts: &mut Parts) {
                $($(if let Some(value) = &self.$key {
                    parts.$part.$key = *value;
                })?)+
            }
        }
    };
    (@needs) => { Needs::Nothing };
    (@needs $needs:ident) => { Needs::$needs };
    (@read f64 $key:ident $given:ident) => { $given.number($key)? };
    (@read String $key:ident $given:ident) => { $given.to_string() };
    (@read $kind:ident $key:ident $given:ident) => { $given.to_string().parse::<$kind>().map_err(|error| of_option(error, $key))? };
    (@write f64 $value:expr) => { Given::from(*$value) };
    (@write $kind:ident $value:expr) => { Given::Text($value.to_string()) };
    (@fact none $key:ident $kind:ident, |$run:ident| $says:expr) => { |$run| $says };
    (@fact all $key:ident $kind:ident $part:ident,) => {
        run_options!(@fact all $key $kind, |run| run_options!(@write $kind &run_options!(@value $part run).$key).into())
    };
    (@fact some $key:ident $kind:ident $part:ident,) => {
        run_options!(@fact some $key $kind, |run| {
            let (value, usual) = (&run_options!(@value $part run).$key, run_options!(@usual $part run).$key);
            run_options!(@write $kind (*value != usual).then_some(value)?).into()
        })
    };
    (@fact all $key:ident $kind:ident $($part:ident)?, |$run:ident| $says:expr) => {
        |$run| {
            let said = || -> Option<FactValue> { Some($says) };
            Some(Fact::new(stringify!($key), said()))
        }
    };
    (@fact some $key:ident $kind:ident $($part:ident)?, |$run:ident| $says:expr) => {
        |$run| {
            let said = || -> Option<FactValue> { Some($says) };
            Some(Fact::new(stringify!($key), said()).of_some_runs())
        }
    };
    (@value model $run:ident) => { $run.model.as_ref()? };
    (@value exchange $run:ident) => { $run.exchange };
    (@usual model $run:ident) => { ModelOptions::default() };
    (@usual exchange $run:ident) => { Exchange::new($run.micro_step, $run.sequence, $run.force_return) };
}

run_options! {
    /// Case by name (see `rimbench list cases`)
    case: String, "NAME", Run,
        all |run| text(&run.case.name);
    /// Coupling scheme by name (see `rimbench list schemes`)
    scheme: String, "NAME", Scheme,
        all |run| text(&run.scheme.name);
    /// Order of the sides: jacobi, gauss-seidel (actuator first), gauss-seidel-mechanics-first
    sequence: Sequence, "ORDER", Loop(Exchange),
        all |run| text(run.sequence);
    /// What the mechanics receives: held, end, mean, profile, pieces
    force_return: ForceReturn, "RETURN", Loop(Exchange),
        all |run| text(run.force_return);
    /// The mechanics' own steps per macro step, or `all` for as many as the actuator takes; if not given 1, on linear
    /// cases all
    mechanics_steps: MechanicsSteps, "N", Loop(Exchange),
        all |run| run.mechanics_steps.longest().is_none().then(|| text(run.mechanics_steps))?;
    /// Longest step of the mechanics, s, in place of their number
    mechanics_step_s: f64, "S", Loop(Exchange),
        some |run| number(run.mechanics_steps.longest()?);
    /// The mechanics steps: semi-implicit (if not given), midpoint, event-split
    mechanics_integrator: MechanicsIntegrator, "RULE", Loop,
        all |run| text(run.mechanics_integrator);
    /// The actuator steps: euler (its own; if not given), midpoint
    actuator_integrator: ActuatorIntegrator, "RULE", Loop => exchange, all;
    /// Within a macro step: frozen, extrapolated
    model_motion: ModelMotion, "MOTION", Model(Model) => model, all;
    /// Contacts that it takes for closed: active (of the mechanics' last step), mechanics-law, margin:M (gaps up to M
    /// metres)
    contact_detection: ContactDetection, "DETECTION", Model,
        all |run| text(run.model.as_ref()?.detection?);
    /// Friction in space within it: cone (two rows per contact), slip-direction (one row along the slip at t_k)
    friction_rows: FrictionRows, "ROWS", Model(Model) => model,
        some |run| text(run.model.as_ref().filter(|_| run.has_slip_rows())?.friction_rows);
    /// Step over which its contacts act: micro-step (at once), mechanics-step (spread over the mechanics' own)
    contacts_act: ContactsAct, "OVER", Model(Model) => model, some;
    /// How samples of the mechanics reach the actuator: delay=D,jitter=J (macro steps), loss=P, seed=S, missed=K+K*L;
    /// in time if not given
    delivery_up: Channel, "HOW", Loop,
        some |run| text(&run.delivery.as_ref()?.up);
    /// How forces reach the mechanics, likewise
    delivery_down: Channel, "HOW", Loop,
        some |run| text(&run.delivery.as_ref()?.down);
    /// Late samples: catch-up (by their time, a model runs forward to the present), catch-up-coarse (at constant cost),
    /// raw
    late_samples: LateRule, "RULE", Model,
        some |run| text(run.delivery.as_ref()?.late);
    /// Late forces: hold (if not given), linear, rates (of a model)
    late_forces: ForceBridge, "RULE", Loop,
        some |run| text(run.delivery.as_ref()?.bridge);
    /// What it believes wrongly: mass=RHO, friction=F (factors), gap=M (added, m), missing=C, closed=C (contacts)
    belief: Belief, "HOW", Model(Model),
        some |run| text(run.belief.as_ref()?);
    /// Its factor of mass is learned: forgetting=PHI (share of older samples kept), within=X (bound); not if not given
    mass_learning: MassLearning, "HOW", Model(Model),
        some |run| text(run.mass_learning.as_ref()?);
    /// Steps of the mechanics that are tried: range=R (of the largest force), tolerance=T, most=N per macro step,
    /// noise=V (m/s)
    trials: TrialSettings, "HOW", Scheme(Trials) => exchange, some;
    /// Bonds of a mechanics with several actuators, by interface rows counted from 1: each, or as 1+2|3; one bond if not
    /// given
    partition: Partition, "ROWS", Loop(Exchange),
        some |run| text(&run.own_plan()?.partition);
    /// Order of the bonds in a macro step: together (if not given), each in turn, or stages as 3;1,2, with the hub (the
    /// mechanics, last if not given) anywhere as a stage
    order: Order, "STAGES", Loop(Exchange),
        some |run| text(run.unusual(|plan| &plan.order)?);
    /// Macro steps in the step of each bond, as 1,4, or of all, as 4; 1/8 to be told of the others 8 times within one
    every: Every, "N", Loop(Exchange),
        some |run| text(run.unusual(|plan| &plan.every)?);
    /// What a bond knows of the others' forces: nothing, held, mean (of their last steps; if not given), law (of their
    /// output rates)
    known: Known, "WHAT", Loop(Exchange),
        some |run| text(run.unusual(|plan| &plan.known)?);
    /// What a bond that has stepped ahead tells the others: profile (if not given), mean
    tells: Tells, "WHAT", Loop(Exchange),
        some |run| text(run.unusual(|plan| &plan.tells)?);
    /// Share of the mechanics in the model of each bond: whole (if not given), equal, rows, bound, or a number
    share: Share, "SHARE", Loop(Exchange),
        some |run| text(run.unusual(|plan| &plan.share)?);
    /// Scheme of each bond, in their order, separated by commas; that of the run if not given
    bond_schemes: String, "NAMES", Scheme(Exchange),
        some |run| text(run.names_of_bond_schemes()?);
    /// Longest micro step of each bond, s, in their order, separated by commas; that of the run if not given
    bond_micro_steps: MicroSteps, "S,S", Loop(Exchange),
        some |run| text(run.unusual(|plan| &plan.micro_steps)?);
    /// Masses, stiffnesses, oil, friction and gaps are off by drawn factors: within=X (a share), seed=S, of=machine (if
    /// not given; held against the reference without) or of=model (it alone believes so)
    perturbation: Perturbation, "HOW", Run,
        some |run| text(run.perturbation?);
    /// Solver of the complementarity problems (see `rimbench list solvers`); active-set if not given
    solver: String, "NAME", Run,
        all |run| text(&run.solver.name);
    /// The scheme's gain, where it has one (see `rimbench list schemes`)
    gain: f64, "X", Scheme,
        all |run| number(run.gain?);
    /// Macro step H, s
    macro_step_s: f64, "S", Run,
        all |run| number(run.macro_step);
    /// What shortens macro steps below H: none, energy-residual, energy-residual-libcosim, model-defect,
    /// model-defect-blind; with its tolerance and shortest step by=HOW,tolerance=TOL,shortest=S
    step_control: StepControl, "HOW", Loop,
        all |run| text(run.step_control.map_or(StepControl::None, |rule| rule.control));
    /// Error allowed per macro step that is controlled, a pure number
    step_tolerance: f64, "TOL", Loop,
        all |run| number(run.step_control?.tolerance);
    /// Shortest macro step that is controlled, s; H/100 if not given
    min_macro_step_s: f64, "S", Loop,
        all |run| number(run.step_control?.shortest);
    /// Communication phase φ in (0, 1]: the first macro step is φH long; 1 if not given
    phase: f64, "PHI", Run,
        all |run| number(run.phase);
    /// Longest micro step of the actuator side, s
    micro_step_s: f64, "S", Loop,
        all |run| number(run.micro_step);
    /// Simulated time, s
    duration_s: f64, "S", Run,
        all |run| number(run.duration);
    /// Wall time after which the run ends with outcome `timeout`, s; none if not given
    wall_limit_s: f64, "S", Run,
        none |_run| None;
}

impl RunRequest {
    /// Asks for a case with a scheme, everything else as they have it.
    pub fn of(case: impl Into<String>, scheme: impl Into<String>) -> Self {
        RunRequest { case: Some(case.into()), scheme: Some(scheme.into()), ..RunRequest::default() }
    }

    /// Asks the same at one of the macro steps (s) that are gone through: one shorter than the mechanics' longest step
    /// is one step.
    pub fn at_macro_step(&self, macro_step: f64) -> Self {
        let mechanics_step_s = self.mechanics_step_s.map(|step| step.min(macro_step));
        RunRequest { macro_step_s: Some(macro_step), mechanics_step_s, ..self.clone() }
    }

    /// Returns the plan of several bonds that is asked for, if one is.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for what is of several bonds where there is one, and for a plan where the scheme's name
    /// spells one.
    pub(super) fn star(&self, scheme: &SchemeEntry, case: &Case) -> Result<Option<StarPlan>> {
        const OF_BONDS: [&str; 8] =
            ["partition", "order", "every", "known", "tells", "share", "bond_schemes", "bond_micro_steps"];
        let given = self.given();
        let asked = given.iter().find(|(key, _)| OF_BONDS.contains(key));
        let refused = |why: String| match asked {
            Some((key, value)) => Err(Error::Incompatible(format!("{key} = {value}: {why}"))),
            None => Ok(None),
        };
        if let Some(bonds) = &scheme.bonds {
            let why =
                format!("scheme `{}` has its own: use rim-nonsmooth-gap, which is that of its bonds", scheme.name);
            return refused(why).map(|_| Some(bonds.clone()));
        }
        let usual = match (&self.partition, &case.bonds) {
            (Some(partition), _) => StarPlan { partition: partition.clone(), ..StarPlan::default() },
            // Schemes that move both sides as one or repeat steps have no bonds.
            (None, Some(bonds)) if scheme.real_time() => bonds.clone(),
            (None, _) => return refused("there is one bond: give partition, such as `each`".to_owned()),
        };
        let known = self.known.unwrap_or(usual.known);
        if let (Known::Nothing, Some(tells)) = (known, self.tells) {
            return Err(Error::Incompatible(format!(
                "tells = {tells}: with known = nothing no bond is told of another"
            )));
        }
        Ok(Some(StarPlan {
            order: self.order.clone().unwrap_or(usual.order),
            every: self.every.clone().unwrap_or(usual.every),
            known,
            tells: self.tells.unwrap_or(usual.tells),
            share: self.share.unwrap_or(usual.share),
            micro_steps: self.bond_micro_steps.clone().unwrap_or(usual.micro_steps),
            partition: usual.partition,
        }))
    }

    /// Sets options of which each is given once, also as a part of `step_control`.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for one that is given by itself and as a part; those of [`put`](Self::put).
    pub fn put_all(&mut self, given: &[(impl AsRef<str>, Given)]) -> Result<()> {
        let is_given = |key: &str| given.iter().any(|(other, _)| other.as_ref() == key);
        for (key, value) in given {
            let parts = step_control_parts(key.as_ref(), value)?.unwrap_or_default();
            let twice = |(_, key): &&(&str, &str)| is_given(key) && parts.iter().any(|(option, _)| option == key);
            if let Some((part, key)) = PARTS[1..].iter().find(twice) {
                return Err(Error::Incompatible(format!("step_control.{part} and {key}: give one of the two")));
            }
            self.put(key.as_ref(), value.clone())?;
        }
        Ok(())
    }

    /// Lists the options that are given, with values of which [`put`](Self::put) makes the same.
    pub fn given(&self) -> Vec<(&'static str, Given)> {
        Self::OPTIONS.iter().filter_map(|option| Some((option.key, (option.given)(self)?))).collect()
    }

    /// Refuses what a scheme has no use for.
    ///
    /// # Errors
    /// [`Error::Incompatible`], naming the option and what the scheme lacks.
    pub(super) fn refuse_in_vain(&self, scheme: &SchemeEntry) -> Result<()> {
        let mut asked = Self::OPTIONS.iter().filter_map(|option| Some((option, (option.given)(self)?)));
        let in_vain = asked.find_map(|(option, value)| Some((option.key, value, option.needs.lacks(scheme)?)));
        in_vain.map_or(Ok(()), |(key, value, why)| {
            Err(Error::Incompatible(format!("{key} = {value}: scheme `{}` {why}", scheme.name)))
        })
    }
}

/// What was an option once, with the only value that is left and the option before which it was said: run ids and kept
/// tables go on saying the first of each run with a model, the second of schemes with bonds of their own.
pub(super) const SETTLED: [(&str, &str, &str); 2] =
    [("redundancy", "drop", "model_motion"), ("split", "mean:shares", "friction_rows")];

/// What all options say of a run, in their order.
pub(super) fn facts_of(run: &RunSpec) -> impl Iterator<Item = Fact> {
    let settled = |before: &str| {
        let (name, value, _) = SETTLED.into_iter().find(|(.., next)| *next == before)?;
        Some(match name {
            "split" => Fact::new(name, run.scheme.bonds.as_ref().map(|_| text(value))).of_some_runs(),
            _ => Fact::new(name, run.model.as_ref().map(|_| text(value))),
        })
    };
    RunRequest::OPTIONS.iter().flat_map(move |option| settled(option.key).into_iter().chain((option.fact)(run)))
}

/// Parts of a step control, and the option that each is.
const PARTS: [(&str, &str); 3] =
    [("by", "step_control"), ("tolerance", "step_tolerance"), ("shortest", "min_macro_step_s")];

/// The options that a step control in parts stands for.
fn step_control_parts(key: &str, value: &Given) -> Result<Option<Vec<(&'static str, String)>>> {
    let (Given::Text(text), "step_control") = (value, key) else { return Ok(None) };
    if !text.contains(['=', ':']) {
        return Ok(None);
    }
    let parts = parts::Parts::of("step_control", text, PARTS.map(|(part, _)| part))?;
    Ok(Some(PARTS.into_iter().filter_map(|(part, option)| Some((option, parts.get(part)?.to_owned()))).collect()))
}

/// An error about the value of an option, under the name by which it was given: what is read does not know for which
/// one.
fn of_option(error: Error, option: &str) -> Error {
    match error {
        Error::InvalidValue { found, expected, .. } => Error::InvalidValue { key: option.to_owned(), found, expected },
        other => other,
    }
}

fn text(text: impl Display) -> FactValue {
    FactValue::Text(text.to_string())
}

fn number(number: f64) -> FactValue {
    FactValue::Number(number)
}

#[cfg(test)]
mod tests {
    use super::super::fact::{Fact, FactValue};
    use super::super::given::Given;
    use crate::RunRequest;
    use crate::catalogue::Catalogue;

    /// What a guest adds to the exchange.
    struct Exchange {
        force_factor: f64,
    }

    impl Exchange {
        fn new((): (), (): (), (): ()) -> Self {
            Exchange { force_factor: 1.0 }
        }
    }

    struct RunSpec {
        exchange: Exchange,
        micro_step: (),
        sequence: (),
        force_return: (),
    }

    #[test]
    fn an_option_of_some_runs_keeps_the_ids_of_others_whatever_its_usual_value() {
        let fact: fn(&RunSpec) -> Option<Fact> = run_options!(@fact some force_factor f64 exchange,);
        let mut request = RunRequest::of("wedge-box", "zero-order-hold");
        request.put("macro_step_s", "5e-3").unwrap();
        let run = request.resolve(&Catalogue::standard()).unwrap();
        let id = |force_factor: f64| {
            let exchange = Exchange { force_factor };
            let guest = fact(&RunSpec { exchange, micro_step: (), sequence: (), force_return: () });
            run.id_of(run.facts().into_iter().chain(guest))
        };
        assert_eq!(id(Exchange::new((), (), ()).force_factor), run.id());
        // Where the usual value is not the default of the type, that default is a change.
        assert_ne!(id(0.0), run.id());
        assert_ne!(id(0.0), id(2.0));
    }
}

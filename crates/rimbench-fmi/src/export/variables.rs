//! The variables of an exported FMU. A value reference is the place in their list, on both sides of the boundary.

use super::build_side;
use rimbench_cases::cases::{self, Case, Parameters, Value};
use rimbench_core::cosim::{OutputRates, Side, Subsystem};
use rimbench_core::error::Result;

/// Parts of the reduced interface model, for `n = n_u + n_i` rows, contacts first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// `H`, n×n, 1/kg.
    H,
    /// Free accelerations, n, m/s².
    A,
    /// Velocities, n, m/s.
    W,
    /// Gaps, n_u, m.
    Gap,
    /// Approaches that the mechanics' steps make by themselves, n_u, m/s.
    DiscretisationApproach,
    /// Interface coordinates, n_i, m.
    Position,
    /// Whether a contact was at its bound in the last step, n_u.
    AtBound,
    /// γ.
    Stabilisation,
    /// e.
    Restitution,
    /// k of compliant contacts, N/m; 0: rigid.
    Stiffness,
    /// c of compliant contacts, N·s/m.
    Damping,
    /// Coefficients of friction of the next step, n_u.
    Friction,
    /// Coefficient of a contact at rest, where that is another; else 0.
    FrictionAtRest,
    /// Likewise of one that slides.
    FrictionInMotion,
    /// Restitution along the surface.
    TangentialRestitution,
    /// What contacts did in the last step, n_u: [`ContactState`](rimbench_core::friction::ContactState) by its number.
    State,
    /// From which the next contact problem starts, likewise.
    SolvedState,
    /// How many kinks lie ahead.
    KinkCount,
    /// When each is reached, s; room for all that there may be.
    KinkTime,
    /// By how much accelerations jump there, one row for each, m/s².
    KinkJump,
}

/// What a variable stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The independent variable.
    Time,
    /// An input by its place.
    Input(usize),
    /// An output by its place.
    Output(usize),
    /// The rate of an output with inputs held, by its place.
    Rate(usize),
    /// A parameter of the case by its place.
    Parameter(usize),
    /// Longest step of its own.
    LongestStep,
    /// Whether steps are noted so that a state can be serialised.
    Serialisable,
    /// Step for which the interface model and the observables are given.
    ModelStep,
    /// A part of the interface model.
    Model(Model),
    /// A further quantity by its place.
    Observable(usize),
    /// Work received through the interface.
    InterfaceWork,
}

/// One variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// What it stands for.
    pub kind: Kind,
    /// Its unit; empty where it has none.
    pub unit: String,
    /// One line.
    pub about: String,
    /// Extents of an array; empty: one value.
    pub dimensions: Vec<usize>,
}

impl Variable {
    /// Returns how many values it has.
    pub fn size(&self) -> usize {
        self.dimensions.iter().product()
    }
}

/// What one side of a case shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Variables {
    /// All variables; the place of one is its value reference.
    pub list: Vec<Variable>,
    /// Numbers of inputs and outputs.
    pub inputs: usize,
    /// Likewise.
    pub outputs: usize,
    /// Whether outputs depend on inputs at once.
    pub feedthrough: bool,
    /// Whether the rates of outputs are known.
    pub rates: bool,
    /// Whether it can be copied, and so its state kept.
    pub copies: bool,
}

impl Variables {
    /// Lists those of one side of a case with these parameters.
    ///
    /// # Errors
    /// Those of building the case.
    pub fn of(case: &Case, side: Side, parameters: &Parameters) -> Result<Self> {
        let mut subsystem = build_side(case, side, parameters)?;
        Ok(Self::of_subsystem(&mut *subsystem, parameters))
    }

    /// Lists those of a subsystem that has been built with these parameters.
    pub fn of_subsystem(subsystem: &mut dyn Subsystem, parameters: &Parameters) -> Self {
        let ports = subsystem.ports().clone();
        let (inputs, outputs) = (ports.inputs.len(), ports.outputs.len());
        let mut rates = OutputRates::zeros(outputs, inputs);
        let rates = matches!(subsystem.capabilities().output_rates(0.0, &vec![0.0; inputs], &mut rates), Ok(true));
        let mut list = Vec::new();
        let mut put = |name: &str, kind: Kind, unit: &str, about: &str, dimensions: &[usize]| {
            let (name, unit, about) = (name.to_owned(), unit.to_owned(), about.to_owned());
            list.push(Variable { name, kind, unit, about, dimensions: dimensions.to_vec() });
        };
        put("time", Kind::Time, "s", "Simulated time", &[]);
        for (k, port) in ports.inputs.iter().enumerate() {
            put(&port.name, Kind::Input(k), unit_of(&port.name), "Held over a communication step", &[]);
        }
        for (k, port) in ports.outputs.iter().enumerate() {
            put(&port.name, Kind::Output(k), unit_of(&port.name), "Of the present state", &[]);
        }
        for (k, port) in ports.outputs.iter().enumerate().filter(|_| rates) {
            let unit = format!("{}/s", unit_of(&port.name));
            put(&format!("der({})", port.name), Kind::Rate(k), &unit, "Rate of the output with its inputs held", &[]);
        }
        for (k, (parameter, _)) in parameters.iter().enumerate() {
            let unit = said(&parameter.unit);
            let about = format!("{}; valid: {}", parameter.about, parameter.range);
            put(&parameter.name, Kind::Parameter(k), unit, &about, &[]);
        }
        let about = "Longest step that the model takes by itself; 0: as long as the communication step";
        put("longest_step_s", Kind::LongestStep, "s", about, &[]);
        let about =
            "Keep a note of every communication step, 8 (3 + inputs) bytes each, from which a state can be serialised";
        put("serialisable", Kind::Serialisable, "", about, &[]);
        put(
            "rim.step",
            Kind::ModelStep,
            "s",
            "Step of the mechanics for which local quantities and rim.* are given",
            &[],
        );
        if let Some(model) = subsystem.capabilities().empty_interface_model() {
            let (contacts, interface) = (model.contacts(), model.interface());
            let n = model.interface_start() + interface;
            put(
                "rim.H",
                Kind::Model(Model::H),
                "1/kg",
                "Interface model: [H_uu H_ui; H_iu H_ii], contacts first, with friction their tangential rows behind them",
                &[n, n],
            );
            put("rim.a", Kind::Model(Model::A), "m/s²", "Interface model: free accelerations [a_u; a_i]", &[n]);
            put("rim.w", Kind::Model(Model::W), "m/s", "Interface model: velocities [w_u; w_i]", &[n]);
            put("rim.position", Kind::Model(Model::Position), "m", "Interface model: coordinates", &[interface]);
            if contacts > 0 {
                put(
                    "rim.gap",
                    Kind::Model(Model::Gap),
                    "m",
                    "Interface model: gaps, below zero in penetration",
                    &[contacts],
                );
                let about = "Interface model: approaches that the mechanics' steps make by themselves, of which nothing bounces back";
                put(
                    "rim.discretisation_approach",
                    Kind::Model(Model::DiscretisationApproach),
                    "m/s",
                    about,
                    &[contacts],
                );
                let about = "Interface model: whether a contact was at its bound in the last step";
                put("rim.at_bound", Kind::Model(Model::AtBound), "", about, &[contacts]);
            }
            let about = "Interface model: fraction of a penetration that the mechanics removes in one step";
            put("rim.stabilisation", Kind::Model(Model::Stabilisation), "", about, &[]);
            put(
                "rim.restitution",
                Kind::Model(Model::Restitution),
                "",
                "Interface model: restitution of closing contacts",
                &[],
            );
            let about = "Interface model: stiffness of compliant contacts; 0: rigid";
            put("rim.contact_stiffness", Kind::Model(Model::Stiffness), "N/m", about, &[]);
            put(
                "rim.contact_damping",
                Kind::Model(Model::Damping),
                "N·s/m",
                "Interface model: damping of compliant contacts",
                &[],
            );
            if model.has_friction() {
                let about = "Interface model: coefficients of friction in the step that starts here";
                put("rim.friction", Kind::Model(Model::Friction), "", about, &[contacts]);
                let about = "Interface model: coefficient of friction of a contact that stood still; 0: coefficients do not change";
                put("rim.friction_at_rest", Kind::Model(Model::FrictionAtRest), "", about, &[]);
                let about =
                    "Interface model: coefficient of friction of any other contact; 0: coefficients do not change";
                put("rim.friction_in_motion", Kind::Model(Model::FrictionInMotion), "", about, &[]);
                let about = "Interface model: restitution of closing contacts along the surface";
                put("rim.tangential_restitution", Kind::Model(Model::TangentialRestitution), "", about, &[]);
                let about = "Interface model: what contacts did in the last step: 0 open, 1 sticking, 2 sliding forwards, 3 backwards";
                put("rim.state", Kind::Model(Model::State), "", about, &[contacts]);
                let about = "Interface model: states from which the next contact problem starts, numbered likewise";
                put("rim.solved_state", Kind::Model(Model::SolvedState), "", about, &[contacts]);
            }
            let places = model.acceleration_jumps.places();
            if places > 0 {
                let about = "Interface model: how many kinks of the geometry lie ahead";
                put("rim.kink_count", Kind::Model(Model::KinkCount), "", about, &[]);
                let about = "Interface model: times from now at which they are reached, as many as there are";
                put("rim.kink_time", Kind::Model(Model::KinkTime), "s", about, &[places]);
                let about = "Interface model: jumps of rim.a there, a row for each";
                put("rim.kink_jump", Kind::Model(Model::KinkJump), "m/s²", about, &[places, n]);
            }
        }
        if subsystem.capabilities().interface_work().is_some() {
            let about = "Work received through the interface since the start, as the model's own steps count it";
            put("interface_work_j", Kind::InterfaceWork, "J", about, &[]);
        }
        for (k, name) in subsystem.capabilities().observables().iter().enumerate() {
            put(name, Kind::Observable(k), unit_of(name), "A further quantity of the model", &[]);
        }
        let copies = subsystem.try_clone().is_some();
        // A name of the model's own stands where a parameter has it as well.
        let mut seen = std::collections::BTreeSet::new();
        list.retain(|variable| seen.insert(variable.name.clone()));
        Variables { list, inputs, outputs, feedthrough: ports.direct_feedthrough, rates, copies }
    }

    /// Finds the variable of a value reference.
    pub fn get(&self, reference: u32) -> Option<&Variable> {
        self.list.get(usize::try_from(reference).ok()?)
    }

    /// Tells whether it has an interface model.
    pub fn has_model(&self) -> bool {
        self.list.iter().any(|variable| matches!(variable.kind, Kind::Model(_)))
    }
}

/// Whether a parameter is a name rather than a number.
pub(crate) fn is_choice(value: &Value) -> bool {
    matches!(value, Value::Choice(_))
}

/// Unit that a name in data ends in; empty where it says none.
fn unit_of(name: &str) -> &'static str {
    said(cases::unit_of(name))
}

/// A unit as FMI has it: nothing for a pure number.
fn said(unit: &str) -> &str {
    if unit == "-" { "" } else { unit }
}

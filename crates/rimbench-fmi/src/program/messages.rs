//! What is said, line by line. `docs/guide/protocol.md` describes it for those who write programs.

use rimbench_core::cosim::Side;
use rimbench_core::interface_model::ReducedInterfaceModel;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_json::value::RawValue;
use std::collections::BTreeMap;

/// What the protocol is called, in the first line of both.
pub const PROTOCOL: &str = "rimbench-line";

/// Its version. One that speaks another is refused.
pub const VERSION: u32 = 1;

/// A variable: name and unit.
pub(crate) type Named = (String, String);

/// What a program is asked to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Role {
    Scheme,
    Mechanics,
    Actuator,
}

impl From<Side> for Role {
    fn from(side: Side) -> Self {
        match side {
            Side::Mechanics => Role::Mechanics,
            Side::Actuator => Role::Actuator,
        }
    }
}

/// One line to a program: what is asked, and a number by which its reply is known.
#[derive(Debug, Serialize)]
pub(super) struct Numbered<'a> {
    pub(super) id: u64,
    #[serde(flatten)]
    pub(super) request: &'a Request<'a>,
}

/// What a program is asked.
#[derive(Debug, Serialize)]
#[serde(tag = "ask", rename_all = "snake_case")]
pub(super) enum Request<'a> {
    /// The first: what are you?
    Hello {
        protocol: &'static str,
        version: u32,
        role: Role,
        /// Of a subsystem: what it will be given, and what it is to give, in this order.
        #[serde(skip_serializing_if = "Option::is_none")]
        inputs: Option<&'a [Named]>,
        #[serde(skip_serializing_if = "Option::is_none")]
        outputs: Option<&'a [Named]>,
    },
    /// The second, once per run.
    Begin {
        /// Of a subsystem.
        #[serde(skip_serializing_if = "Option::is_none")]
        parameters: Option<&'a BTreeMap<String, Value>>,
        /// Of a scheme.
        #[serde(skip_serializing_if = "Option::is_none")]
        sides: Option<&'a Sides>,
        #[serde(skip_serializing_if = "Option::is_none")]
        gain: Option<f64>,
    },
    /// Of a scheme: which inputs do both sides get over this macro step?
    Inputs { step: Step, mechanics: Sample<'a>, actuator: Sample<'a> },
    /// Of a subsystem: advance.
    Step {
        time_s: f64,
        length_s: f64,
        u: &'a [f64],
        /// The inputs as polynomials of the time since `time_s`, for one that takes them.
        #[serde(skip_serializing_if = "Option::is_none")]
        polynomials: Option<&'a [[f64; 4]]>,
    },
    /// Of a subsystem with direct feedthrough: what do you put out with these inputs?
    Outputs { u: &'a [f64] },
    /// Of an actuator that knows them: how do your outputs move?
    Rates { time_s: f64, u: &'a [f64] },
    /// Of a mechanics that has one: its reduced interface model.
    InterfaceModel { step_s: f64 },
    /// Of one that offers it: give your state, whatever it is.
    State,
    /// Go back to a state that you have given.
    Restore { state: &'a RawValue },
}

impl Request<'_> {
    pub(super) fn hello<'a>(role: Role, inputs: Option<&'a [Named]>, outputs: Option<&'a [Named]>) -> Request<'a> {
        Request::Hello { protocol: PROTOCOL, version: VERSION, role, inputs, outputs }
    }

    /// What is asked, as it stands in the line.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Request::Hello { .. } => "hello",
            Request::Begin { .. } => "begin",
            Request::Inputs { .. } => "inputs",
            Request::Step { .. } => "step",
            Request::Outputs { .. } => "outputs",
            Request::Rates { .. } => "rates",
            Request::InterfaceModel { .. } => "interface_model",
            Request::State => "state",
            Request::Restore { .. } => "restore",
        }
    }

    /// Whether it is asked before anything runs.
    pub(super) fn is_of_the_start(&self) -> bool {
        matches!(self, Request::Hello { .. } | Request::Begin { .. })
    }

    /// Whether it is part of a macro step, and so of what an exchange costs.
    pub(super) fn is_of_a_step(&self) -> bool {
        !matches!(self, Request::Hello { .. } | Request::Begin { .. } | Request::State | Request::Restore { .. })
    }
}

/// What a scheme stands between.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Sides {
    pub(super) mechanics: SidePorts,
    pub(super) actuator: SidePorts,
}

/// The coupling variables of one side.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct SidePorts {
    pub(super) inputs: Vec<Named>,
    pub(super) outputs: Vec<Named>,
    pub(super) direct_feedthrough: bool,
}

/// The macro step that begins.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Step {
    pub(super) index: usize,
    pub(super) start_s: f64,
    pub(super) length_s: f64,
    /// Micro steps of the actuator in it.
    pub(super) actuator_steps: usize,
}

/// What one side has sent.
#[derive(Debug, Serialize)]
pub(super) struct Sample<'a> {
    pub(super) time_s: f64,
    pub(super) y: &'a [f64],
    /// Of the mechanics, if the scheme needs it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) interface_model: Option<&'a Model>,
    /// Of the actuator, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rates: Option<&'a Rates>,
}

/// A reduced interface model, without friction.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(super) struct Model {
    #[serde(rename = "H")]
    h: Vec<Vec<f64>>,
    a: Vec<f64>,
    w: Vec<f64>,
    gap: Vec<f64>,
    position: Vec<f64>,
    closed: Vec<bool>,
    own_approach: Vec<f64>,
    stabilisation: f64,
    restitution: f64,
    /// Of contacts that give way; 0: they are rigid.
    contact_stiffness: f64,
    contact_damping: f64,
    mechanics_step_s: f64,
}

impl Model {
    /// Writes down a model.
    ///
    /// # Errors
    /// Numbers in it that are not finite.
    pub(super) fn of(model: &ReducedInterfaceModel) -> Result<Self, String> {
        let rows = model.interface_start() + model.interface();
        let spring = model.spring.map_or([0.0; 2], |spring| [spring.stiffness, spring.damping]);
        let written = Model {
            h: (0..rows).map(|row| (0..rows).map(|column| model.entry(row, column)).collect()).collect(),
            a: model.a.clone(),
            w: model.w.clone(),
            gap: model.gap.clone(),
            position: model.position.clone(),
            closed: model.at_bound.clone(),
            own_approach: model.own_approach.clone(),
            stabilisation: model.stabilisation,
            restitution: model.restitution,
            contact_stiffness: spring[0],
            contact_damping: spring[1],
            mechanics_step_s: model.mechanics_step,
        };
        let numbers = written.h.iter().flatten().chain(&written.a).chain(&written.w).chain(&written.gap);
        let numbers = numbers.chain(&written.position).chain(&written.own_approach);
        if numbers.copied().all(f64::is_finite) {
            Ok(written)
        } else {
            Err("the interface model has numbers that are not finite".to_owned())
        }
    }
}

/// How the actuator's outputs move.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(super) struct Rates {
    pub(super) rate: Vec<f64>,
    pub(super) feedthrough: Vec<f64>,
    pub(super) rate_gain: Vec<f64>,
}

/// What a scheme says it is.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SchemeDescription {
    #[serde(default = "one")]
    pub(super) order: u32,
    #[serde(default = "one_sample")]
    pub(super) samples: usize,
    #[serde(default)]
    pub(super) needs: Vec<SchemeNeed>,
    pub(super) gain: Option<GainDescription>,
    #[serde(default)]
    pub(super) state: bool,
}

fn one() -> u32 {
    1
}

fn one_sample() -> usize {
    1
}

/// What a scheme cannot do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum SchemeNeed {
    InterfaceModel,
    Rates,
    ForceDisplacement,
}

/// What can be tuned.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GainDescription {
    #[serde(default)]
    pub(super) about: String,
    pub(super) default: f64,
    pub(super) range: [f64; 2],
}

/// What a subsystem says it is.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SideDescription {
    pub(super) inputs: Vec<Named>,
    pub(super) outputs: Vec<Named>,
    #[serde(default)]
    pub(super) direct_feedthrough: bool,
    #[serde(default)]
    pub(super) state: bool,
    #[serde(default)]
    pub(super) polynomials: bool,
    #[serde(default)]
    pub(super) rates: bool,
    #[serde(default)]
    pub(super) interface_work: bool,
    #[serde(default)]
    pub(super) observables: Vec<String>,
    pub(super) interface_model: Option<ModelDescription>,
}

/// What of an interface model never changes.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelDescription {
    #[serde(default)]
    pub(super) contacts: usize,
    #[serde(default)]
    pub(super) stabilisation: f64,
    #[serde(default)]
    pub(super) restitution: f64,
    #[serde(default)]
    pub(super) contact_stiffness: f64,
    #[serde(default)]
    pub(super) contact_damping: f64,
}

/// One line from a program, behind the first. What a request does not ask for is not looked at.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Reply {
    /// That of the request.
    pub(super) id: Option<u64>,
    /// Why it cannot go on.
    pub(super) error: Option<String>,
    pub(super) y: Option<Vec<f64>>,
    pub(super) observed: Option<Vec<f64>>,
    pub(super) interface_work_j: Option<f64>,
    pub(super) rate: Option<Vec<f64>>,
    /// Row by row, outputs by inputs.
    pub(super) feedthrough: Option<Vec<f64>>,
    pub(super) rate_gain: Option<Vec<f64>>,
    #[serde(rename = "H")]
    pub(super) h: Option<Vec<Vec<f64>>>,
    pub(super) a: Option<Vec<f64>>,
    pub(super) w: Option<Vec<f64>>,
    pub(super) gap: Option<Vec<f64>>,
    pub(super) position: Option<Vec<f64>>,
    pub(super) own_approach: Option<Vec<f64>>,
    pub(super) closed: Option<Vec<bool>>,
    /// As it was said: it may hold integers that no number of ours does.
    pub(super) state: Option<Box<RawValue>>,
    pub(super) mechanics: Option<Inputs>,
    pub(super) actuator: Option<Inputs>,
}

/// The inputs of one side over a macro step.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Inputs {
    /// Of each input the coefficients of 1, τ, τ², τ³, as many as there are; τ is the time since the communication point, s.
    pub(super) polynomials: Option<Vec<Vec<f64>>>,
    /// Of each of any number of equal parts of the macro step the inputs, held.
    pub(super) pieces: Option<Vec<Vec<f64>>>,
}

/// Takes a part of a reply that must be there.
pub(super) fn wanted<T>(part: Option<T>, name: &str) -> Result<T, String> {
    part.ok_or_else(|| format!("`{name}` is missing"))
}

/// Copies numbers of which there must be so many.
pub(super) fn copy_wanted(part: Option<Vec<f64>>, name: &str, to: &mut [f64]) -> Result<(), String> {
    let part = wanted(part, name)?;
    if part.len() != to.len() {
        return Err(format!("`{name}` has {} numbers instead of {}", part.len(), to.len()));
    }
    to.copy_from_slice(&part);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_comes_back_as_it_was_said() {
        let state = r#"{"rng":170141183460469231731687303715884105729,"x":[-0.0,1e-400,0.10],"a":"\u00b5","a":null}"#;
        let reply: Reply = serde_json::from_str(&format!(r#"{{"state": {state}, "id": 7}}"#)).unwrap();
        assert_eq!(reply.id, Some(7));
        let state_said = reply.state.unwrap();
        let line = serde_json::to_string(&Numbered { id: 8, request: &Request::Restore { state: &state_said } });
        assert_eq!(line.unwrap(), format!(r#"{{"id":8,"ask":"restore","state":{state}}}"#));
        let line = serde_json::to_string(&Numbered { id: 9, request: &Request::State });
        assert_eq!(line.unwrap(), r#"{"id":9,"ask":"state"}"#);
    }
}

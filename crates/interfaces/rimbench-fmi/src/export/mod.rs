//! One side of a case as an FMU for co-simulation, for FMI 3.0 or 2.0.

mod archive;
mod description;
mod reference_files;
mod system_structure;
mod units;
mod variables;

pub use crate::model_parts::{ModelPart, ModelSize, PartType, PartVariable};
pub(crate) use archive::platform;
pub use archive::{check_case, find_library, pack, zipped};
pub use reference_files::{README, ReferenceFiles, reference_files};
pub use system_structure::system_structure;
pub use variables::{Kind, Variable, Variables};

use rimbench_cases::cases::{Case, CoupledSystem};
use rimbench_cases::parameter::{Parameters, Value};
use rimbench_core::cosim::{PerSide, Side, Subsystem};
use rimbench_core::error::{Error, Result};
use rimbench_core::solver_entry::SolverEntry;
use rimbench_results::checksums::hex;
use rimbench_runs::RunSpec;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

/// Name of the file among the FMU's resources that says what it is.
pub const RESOURCE: &str = "rimbench.json";

/// The proposed layered standard for reduced interface models: name and version. Its manifest lies in `extra/<name>/`.
pub const LAYERED_STANDARD: [&str; 2] = ["rimbench.reduced-interface", "0.3.0"];

/// Version of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fmi {
    /// FMI 2.0: no arrays, and so no interface model.
    #[serde(rename = "2.0")]
    Two,
    /// FMI 3.0.
    #[serde(rename = "3.0")]
    Three,
}

/// What the library needs to know to be one side of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contents {
    /// What the library must have been built from: [`sources`](crate::sources).
    pub sources: String,
    /// The version of the standard that the FMU is for.
    pub fmi: Fmi,
    /// The case, by name.
    pub case: String,
    /// `mechanics` or `actuator`.
    pub side: String,
    /// The parameters that are not at their defaults, as texts.
    pub set: BTreeMap<String, String>,
    /// Longest step that the subsystem takes by itself, s; 0: as long as the communication step.
    pub longest_step_s: f64,
    /// Step for which the interface model is given at first, s.
    pub model_step_s: f64,
    /// Inputs before any are set: what the other side puts out at the beginning.
    pub input_starts: Vec<f64>,
}

/// Name of a side.
pub fn side_name(side: Side) -> &'static str {
    match side {
        Side::Mechanics => "mechanics",
        Side::Actuator => "actuator",
    }
}

/// Builds one side of a case.
///
/// # Errors
/// Those of building the case.
pub fn build_side(case: &Case, side: Side, parameters: &Parameters) -> Result<Box<dyn Subsystem>> {
    let CoupledSystem { sides, .. } = (case.build)(parameters, &SolverEntry::active_set())?;
    Ok(match side {
        Side::Mechanics => sides.mechanics,
        Side::Actuator => sides.actuator,
    })
}

impl Contents {
    /// Describes one side of the case of a run, with the run's parameters and steps.
    ///
    /// # Errors
    /// Those of building the case, and outputs that fail at the start.
    pub fn of(spec: &RunSpec, side: Side, fmi: Fmi) -> Result<Self> {
        let set = spec.parameters.iter().filter(|(parameter, value)| parameter.default != **value);
        let set = set.map(|(parameter, value)| (parameter.name.to_string(), text(value))).collect();
        let alone = side == Side::Mechanics && spec.case.linear_state.is_empty();
        Ok(Contents {
            sources: crate::sources(),
            fmi,
            case: spec.case.name.to_string(),
            side: side_name(side).to_owned(),
            set,
            longest_step_s: if alone { 0.0 } else { spec.micro_step },
            model_step_s: spec.macro_step,
            input_starts: first_inputs(spec, side)?,
        })
    }

    /// What distinguishes this FMU from all others: a hash of everything above.
    pub fn token(&self) -> String {
        hex(&Sha256::digest(format!("{self:?}"))[..16])
    }
}

/// What a side of the case of a run is given at the start: the side without direct feedthrough speaks first.
fn first_inputs(spec: &RunSpec, side: Side) -> Result<Vec<f64>> {
    let CoupledSystem { mut sides, .. } = (spec.case.build)(&spec.parameters, &spec.solver)?;
    if sides.mechanics.capabilities().empty_interface_model().is_some_and(|model| model.is_in_space()) {
        return Err(Error::Incompatible(format!(
            "case {}: contacts with friction in space are not exported as an FMU: an interface model has no variables for their second \
             tangential rows",
            spec.case.name
        )));
    }
    let mut told = outputs_at_start(&spec.case, &mut sides)?;
    Ok(std::mem::take(&mut told[side.other()]))
}

/// Returns what both sides of a case put out at the beginning: the one without direct feedthrough speaks first, and the
/// other has heard it.
///
/// # Errors
/// [`Error::Incompatible`] for outputs that fail.
pub fn outputs_at_start(case: &Case, sides: &mut PerSide<Box<dyn Subsystem>>) -> Result<PerSide<Vec<f64>>> {
    let first = if sides.mechanics.ports().direct_feedthrough { Side::Actuator } else { Side::Mechanics };
    let mut told = PerSide::from_fn(|side| vec![0.0; sides[side].ports().outputs.len()]);
    for side in [first, first.other()] {
        let u = match side == first {
            true => vec![0.0; sides[side].ports().inputs.len()],
            false => told[first].clone(),
        };
        let outputs = sides[side].outputs(&u, &mut told[side]);
        outputs.map_err(|failure| Error::Incompatible(format!("case {}: {failure}", case.name)))?;
    }
    Ok(told)
}

/// A value as it would be typed, to the bit.
pub fn text(value: &Value) -> String {
    match value {
        Value::Number(number) => format!("{number:?}"),
        Value::Choice(choice) => choice.to_string(),
    }
}

//! The FMU of a side, with all that a case file names in it.

use super::archive::Unpacked;
use super::case_file::{CaseFile, ProcessKind};
use super::description::{Exponents, FORCE, LENGTH, Type, VELOCITY};
use super::finder::Finder;
use super::host::{Host, Plan, Probe, Scaled, Start};
use super::library::Loaded;
use super::process::Remote;
use super::side::{ImportedSide, ModelSize, Offers};
use crate::export::side_name;
use rimbench_cases::cases::Parameters;
use rimbench_core::cosim::{Port, Ports, Quantity, Side, Subsystem};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::Name;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Units of positions, velocities and forces.
const UNITS: [(Quantity, Exponents, &str); 3] =
    [(Quantity::Position, LENGTH, "m"), (Quantity::Velocity, VELOCITY, "m/s"), (Quantity::Force, FORCE, "N")];

/// By how much forces are changed where an FMU is probed, of their magnitude: little enough that the same contacts push.
const FORCE_CHANGE: f64 = 1e-3;
/// Likewise positions and velocities: a force that follows a stiff element answers to micrometres.
const MOTION_CHANGE: f64 = 1e-6;
/// Where no micro step is given, the share of the macro step by which an FMU is probed.
const PROBED_SHARE: f64 = 0.1;

/// Why there are no rates of an FMU's outputs.
const NO_RATES: &str = "its FMU has no directional derivatives of them, and cannot be probed for them, which takes states to be kept \
                        and set, and steps of any length";
/// Why there is no interface model.
const NO_MODEL: &str = "its FMU has none, no directional derivatives of how its velocities move, and cannot be probed for them, which \
                        takes states to be kept and set, and steps of any length";

/// One FMU with what the case makes of it.
pub(super) struct FmuMember {
    pub(super) unpacked: Unpacked,
    plan: Plan,
    pub(super) ports: Ports,
    pub(super) offers: Offers,
    /// The size of its interface model.
    model: Option<ModelSize>,
    /// Parameters of the case with the variables that take them.
    parameters: Vec<(String, Scaled)>,
}

impl FmuMember {
    /// Opens the FMU of a side and finds all that the case file names in it.
    pub(super) fn open(file: &CaseFile, fmu: &Path, side: Side, rows: &[[String; 3]]) -> Result<Self> {
        let table = file.side(side);
        let unpacked = Unpacked::open(fmu)?;
        if unpacked.description.only_once && file.process == ProcessKind::Same {
            return Err(Error::file(
                fmu,
                "may be in a process only once (canBeInstantiatedOnlyOncePerProcess), and a case is built more often: valid: process = \"own\"",
            ));
        }
        let finder = Finder { unpacked: &unpacked };
        let [given, taken] = given_and_taken(side, rows.len());
        let coupled = |list: &[(usize, usize)], causality: &str| -> Result<Vec<(Port, Scaled)>> {
            let one = |&(row, which): &(usize, usize)| {
                let (quantity, exponents, unit) = UNITS[which];
                let (name, factor) = file.interface[row].end(side, which);
                let variable = finder.coupling(name, causality, side, exponents, unit)?;
                if variable.is_in_unknown_unit() && factor.is_none() {
                    return Err(finder.wrong(format!(
                        "variable `{name}` is in `{}`, which the FMU does not define by SI base units; valid: a unit that it defines, or a \
                         factor to {unit}, {{ variable = \"{name}\", factor = … }}",
                        variable.unit
                    )));
                }
                let factor = factor.unwrap_or(1.0);
                if !(factor.is_finite() && factor != 0.0) {
                    return Err(finder.wrong(format!(
                        "variable `{name}`: factor = {factor} is not valid; valid: a finite number but 0"
                    )));
                }
                let scaled = Scaled {
                    reference: variable.reference,
                    factor: factor * variable.factor,
                    offset: factor * variable.offset,
                };
                Ok((Port::new(rows[row][which].clone(), quantity), scaled))
            };
            list.iter().map(one).collect()
        };
        let outputs = coupled(&given, "output")?;
        let inputs = coupled(&taken, "input")?;
        let description = &unpacked.description;
        let depends = || {
            let depends = |output: &Scaled, input: &Scaled| description.depends(output.reference, input.reference);
            let said = outputs.iter().all(|(_, output)| description.dependencies.contains_key(&output.reference));
            // Where nothing is said: positions and velocities are states, forces may follow them at once.
            if !said && side == Side::Mechanics {
                return false;
            }
            outputs.iter().any(|(_, output)| inputs.iter().any(|(_, input)| depends(output, input)))
        };
        let ports = Ports {
            inputs: inputs.iter().map(|(port, _)| port.clone()).collect(),
            outputs: outputs.iter().map(|(port, _)| port.clone()).collect(),
            direct_feedthrough: table.direct_feedthrough.unwrap_or_else(depends),
        };
        let starts = table.start.iter().map(|(name, value)| finder.start(side, name, value)).collect::<Result<_>>()?;
        let mut parameters: Vec<(String, Scaled)> = Vec::new();
        for (name, parameter) in &file.parameters {
            let to = if side == Side::Mechanics { &parameter.mechanics } else { &parameter.actuator };
            if parameter.mechanics.is_none() && parameter.actuator.is_none() {
                return Err(Error::Incompatible(format!(
                    "[parameters.{name}] names no variable: mechanics = \"…\" or actuator = \"…\""
                )));
            }
            if let Some(to) = to {
                let variable = finder.settable(to)?;
                if variable.kind != Type::Number {
                    return Err(
                        finder.wrong(format!("variable `{to}` is no Float64: parameters of a case are numbers"))
                    );
                }
                let units = [&*parameter.unit, &*variable.unit].map(|unit| if unit == "-" { "" } else { unit });
                if units.iter().all(|unit| !unit.is_empty()) && units[0] != units[1] {
                    return Err(finder.wrong(format!(
                        "variable `{to}` is in `{}`, and [parameters.{name}] says unit = {:?}; valid: the same, or none, for its values \
                         go to the FMU as they are",
                        variable.unit, parameter.unit
                    )));
                }
                if table.start.contains_key(to) {
                    return Err(Error::Incompatible(format!(
                        "variable `{to}` is set twice: in start of [{}] and by [parameters.{name}]",
                        side_name(side)
                    )));
                }
                if let Some((other, _)) = parameters.iter().find(|(_, scaled)| scaled.reference == variable.reference) {
                    return Err(Error::Incompatible(format!(
                        "variable `{to}` of [{}] is set twice: by [parameters.{other}] and [parameters.{name}]",
                        side_name(side)
                    )));
                }
                parameters.push((name.clone(), Scaled { reference: variable.reference, factor: 1.0, offset: 0.0 }));
            }
        }
        let observed: Vec<Scaled> = table.observe.iter().map(|name| finder.readable(name)).collect::<Result<_>>()?;
        let work = table.interface_work.as_ref().map(|name| finder.work(name)).transpose()?;
        let rate_of = |(_, output): &(Port, Scaled)| -> Option<Scaled> {
            let rate = description.variables.iter().find(|variable| variable.derivative == Some(output.reference))?;
            // What the case file says of the output holds of its rate; the unit is the rate's own, where it has one.
            let of = description.variables.iter().find(|variable| variable.reference == output.reference)?;
            if rate.is_in_unknown_unit() {
                return None;
            }
            let units = if rate.exponents.is_some() { rate.factor / of.factor } else { 1.0 };
            Some(Scaled { reference: rate.reference, factor: output.factor * units, offset: 0.0 })
        };
        let rates: Option<Vec<Scaled>> =
            outputs.iter().map(rate_of).collect::<Option<_>>().filter(|_| description.derivatives);
        let plain = inputs.iter().chain(&outputs).all(|(_, scaled)| scaled.factor == 1.0);
        let model = if side == Side::Mechanics && plain && unpacked.layered { finder.model(rows.len())? } else { None };
        let mechanics = side == Side::Mechanics;
        let probe =
            (rates.is_none() && model.is_none() && description.keeps_state && description.any_step).then(|| Probe {
                step: table.probe_step_s.or(file.micro_step_s).unwrap_or(PROBED_SHARE * file.macro_step_s),
                change: if mechanics { FORCE_CHANGE } else { MOTION_CHANGE },
                feedthrough: ports.direct_feedthrough,
            });
        let moves = rates.is_some() || probe.is_some();
        // Velocities that jump with a force have no accelerations.
        let smooth = mechanics && model.is_none() && moves && !ports.direct_feedthrough;
        let offers = Offers {
            rates: !mechanics && moves,
            probed: probe.is_some(),
            smooth,
            without: match (mechanics, moves) {
                (false, false) => Some(NO_RATES),
                (true, _) if !smooth => Some(NO_MODEL),
                _ => None,
            },
            copies: description.keeps_state,
            work: work.is_some(),
            observables: table.observe.iter().cloned().map(Name::from).collect(),
        };
        let model_size = model.as_ref().map(|(_, size)| *size);
        let plan = Plan {
            file: unpacked.file.clone(),
            library: unpacked.library.clone(),
            needs: table.needs.clone(),
            resources: unpacked.folder.path().join("resources"),
            version_2: description.is_version_2(),
            token: description.token.clone(),
            starts,
            inputs: inputs.into_iter().map(|(_, scaled)| scaled).collect(),
            outputs: outputs.into_iter().map(|(_, scaled)| scaled).collect(),
            rates,
            derivatives: description.derivatives,
            smooth,
            probe,
            keeps_state: description.keeps_state,
            step: description.variable("rim.step").filter(|_| unpacked.layered).map(|variable| variable.reference),
            model: model.map(|(model, _)| model),
            observed,
            work,
        };
        Ok(FmuMember { plan, ports, offers, model: model_size, parameters, unpacked })
    }

    /// Makes the side for a run; `step` (s) is one for which it may be asked for its interface model.
    pub(super) fn side(
        &self,
        parameters: &Parameters,
        process: &Process,
        step: f64,
    ) -> Result<Box<dyn Subsystem>, String> {
        let side = ImportedSide::new(self.host(parameters, process)?, self.ports.clone(), self.offers.clone());
        let side = side.of_file(&self.unpacked.file);
        Ok(Box::new(match self.model {
            Some(size) => side.with_model(step, size)?,
            None if self.offers.smooth => side.with_smooth_model(self.ports.inputs.len()),
            None => side,
        }))
    }

    /// Starts what drives it.
    fn host(&self, parameters: &Parameters, process: &Process) -> Result<Box<dyn Host>, String> {
        let mut plan = self.plan.clone();
        for (name, variable) in &self.parameters {
            let number = parameters.setting(name).ok_or_else(|| format!("parameter {name} is not one of the case"))?;
            plan.starts.push(Start::Number(variable.reference, variable.inwards(number)));
        }
        match process {
            Process::Same => Ok(Box::new(Loaded::new(plan)?)),
            Process::Own { program, answer_within } => Ok(Box::new(Remote::start(&plan, program, *answer_within)?)),
        }
    }
}

/// Where FMUs run.
pub(super) enum Process {
    Same,
    Own { program: PathBuf, answer_within: Duration },
}

/// What a side of an interface with so many rows puts out and takes, as pairs of row and variable: positions of all rows, then
/// velocities; forces go the other way.
fn given_and_taken(side: Side, rows: usize) -> [Vec<(usize, usize)>; 2] {
    let list = |which: &[usize]| which.iter().flat_map(|&which| (0..rows).map(move |row| (row, which))).collect();
    let (motion, force) = (list(&[0, 1]), list(&[2]));
    if side == Side::Mechanics { [motion, force] } else { [force, motion] }
}

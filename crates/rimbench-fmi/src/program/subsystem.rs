//! A program as one side of a case.

use super::command_line::CommandLine;
use super::conversation::Conversation;
use super::copies::Copies;
use super::messages::{ModelDescription, Named, Reply, Request, SideDescription, copy_wanted, wanted};
use crate::import::{Ask, Host, ImportedSide, Offers, can_name_a_column};
use rimbench_core::cosim::{Port, Ports, Quantity, Side};
use rimbench_core::interface_model::{ContactSpring, ReducedInterfaceModel, TOUCHING};
use rimbench_core::name::Name;
use serde_json::Value;
use std::collections::BTreeMap;

/// Most contacts of an interface model, whose square must have room.
const MOST_CONTACTS: usize = 4096;

/// The unit in which a coupling variable crosses.
pub(crate) fn unit(port: &Port) -> &'static str {
    match port.quantity {
        Quantity::Position => "m",
        Quantity::Velocity => "m/s",
        Quantity::Force => "N",
        Quantity::Pressure => "Pa",
    }
}

/// A program that has said what it is.
pub(crate) struct ProgramSide {
    command: CommandLine,
    side: Side,
    ports: Ports,
    /// By which the program knows its ports.
    names: [Vec<Named>; 2],
    description: SideDescription,
}

impl ProgramSide {
    /// Asks a program what it is. It stands for a side with these ports, which it knows by these names, inputs and outputs.
    ///
    /// # Errors
    /// In words, that it cannot be started, or what of its description does not fit.
    pub(crate) fn open(
        command: CommandLine,
        side: Side,
        ports: &Ports,
        names: [Vec<Named>; 2],
    ) -> Result<ProgramSide, String> {
        let mut program = ProgramSide {
            description: asked(&mut Conversation::start(&command)?, side, &names)?,
            command,
            side,
            ports: ports.clone(),
            names,
        };
        program.ports.direct_feedthrough = program.description.direct_feedthrough;
        program.check().map_err(|wrong| format!("`{}` describes itself with {wrong}", program.command))?;
        Ok(program)
    }

    /// Hash of the command and its files.
    pub(crate) fn digest(&self) -> &str {
        &self.command.digest
    }

    pub(crate) fn ports(&self) -> &Ports {
        &self.ports
    }

    pub(crate) fn observables(&self) -> &[String] {
        &self.description.observables
    }

    fn check(&self) -> Result<(), String> {
        let SideDescription { inputs, outputs, observables, interface_model, rates, interface_work, .. } =
            &self.description;
        for (what, found, valid) in [("inputs", inputs, &self.names[0]), ("outputs", outputs, &self.names[1])] {
            if found != valid {
                let list = |named: &[Named]| {
                    let each = named.iter().map(|(name, unit)| format!("[\"{name}\", \"{unit}\"]"));
                    each.collect::<Vec<_>>().join(", ")
                };
                return Err(format!("`{what}` = [{}]; valid: [{}]", list(found), list(valid)));
            }
        }
        if let Some(name) = observables.iter().find(|name| !can_name_a_column(name)) {
            return Err(format!("an observable {name:?}; valid: a name without commas, quotes and line breaks"));
        }
        let mechanics = self.side == Side::Mechanics;
        for (what, has, valid) in [
            ("interface_model", interface_model.is_some(), mechanics),
            ("interface_work", *interface_work, mechanics),
            ("rates", *rates, !mechanics),
        ] {
            if has && !valid {
                let whose = if mechanics { "an actuator" } else { "a mechanics" };
                return Err(format!("`{what}`, which is for {whose}"));
            }
        }
        if *rates && self.ports.inputs.is_empty() {
            return Err("`rates`, and no inputs".to_owned());
        }
        let Some(model) = interface_model else { return Ok(()) };
        let ModelDescription { contacts, stabilisation, restitution, contact_stiffness, contact_damping } = model;
        if *contacts > MOST_CONTACTS {
            return Err(format!("`contacts` = {contacts}; valid: at most {MOST_CONTACTS}"));
        }
        for (name, value) in [("stabilisation", stabilisation), ("restitution", restitution)] {
            if !(0.0..=1.0).contains(value) {
                return Err(format!("`{name}` = {value}; valid: a number in [0, 1]"));
            }
        }
        for (name, value) in [("contact_stiffness", contact_stiffness), ("contact_damping", contact_damping)] {
            if !(value.is_finite() && *value >= 0.0) {
                return Err(format!("`{name}` = {value}; valid: a finite number, 0 or above"));
            }
        }
        let positions = |ports: &[Port], quantity| ports.iter().filter(|port| port.quantity == quantity).count();
        if positions(&self.ports.inputs, Quantity::Force) != positions(&self.ports.outputs, Quantity::Position) {
            return Err("`interface_model`, and not as many forces as positions".to_owned());
        }
        Ok(())
    }

    /// Starts the program for a run.
    ///
    /// # Errors
    /// In words, what keeps it from beginning.
    pub(crate) fn begin(&self, parameters: &BTreeMap<String, Value>) -> Result<impl Host + use<>, String> {
        let mut conversation = Conversation::start(&self.command)?;
        if asked(&mut conversation, self.side, &self.names)? != self.description {
            return Err(format!("`{}` describes itself otherwise than before", self.command));
        }
        let mut known = Known { y: vec![0.0; self.ports.outputs.len()], ..Known::default() };
        let request = Request::Begin { parameters: Some(parameters), sides: None, gain: None };
        let d = &self.description;
        conversation.ask(&request, |reply| known.take(d, reply, !d.direct_feedthrough))?;
        Ok(ProgramHost {
            description: d.clone(),
            copies: Copies::new(conversation),
            known: vec![known],
            interface: self.ports.outputs.len() / 2,
        })
    }

    /// The side for a run. A program that cannot begin is one that fails there, so that it costs one run.
    pub(crate) fn side(&self, parameters: &BTreeMap<String, Value>) -> ImportedSide {
        let d = &self.description;
        let model = d.interface_model.as_ref().map(|model| {
            let interface = self.ports.outputs.len() / 2;
            let mut empty = ReducedInterfaceModel::zeros(model.contacts, interface);
            (empty.stabilisation, empty.restitution) = (model.stabilisation, model.restitution);
            empty.spring = spring(model);
            // It is not asked for them.
            empty.kinks.blind = true;
            if model.restitution > 0.0 {
                empty.own_approach = vec![0.0; model.contacts];
            }
            empty
        });
        let offers = Offers {
            rates: d.rates,
            copies: d.state,
            work: d.interface_work,
            polynomials: d.polynomials,
            finite_only: true,
            observables: d.observables.iter().cloned().map(Name::from).collect(),
            ..Offers::default()
        };
        let host: Box<dyn Host> = match self.begin(parameters) {
            Ok(host) => Box::new(host),
            Err(message) => Box::new(Failed(message)),
        };
        ImportedSide::new(host, self.ports.clone(), offers, model)
    }
}

fn spring(model: &ModelDescription) -> Option<ContactSpring> {
    let (stiffness, damping) = (model.contact_stiffness, model.contact_damping);
    (stiffness > 0.0).then_some(ContactSpring { stiffness, damping })
}

fn asked(conversation: &mut Conversation, side: Side, names: &[Vec<Named>; 2]) -> Result<SideDescription, String> {
    let request = Request::hello(side.into(), Some(&names[0]), Some(&names[1]));
    conversation.hello(side.into(), &request)
}

/// One that could not begin.
struct Failed(String);

impl Host for Failed {
    fn ask(&mut self, ask: Ask, id: u32, _: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
        // A copy of it fails as it does, which is another thing than having none.
        if matches!(ask, Ask::Copy) {
            output.clear();
            output.push(f64::from(id));
            return Ok(());
        }
        Err(self.0.clone())
    }
}

/// What a copy has said of its state.
#[derive(Debug, Clone, Default)]
struct Known {
    y: Vec<f64>,
    observed: Vec<f64>,
    work: f64,
}

impl Known {
    fn take(&mut self, description: &SideDescription, reply: Reply, outputs: bool) -> Result<(), String> {
        if outputs {
            copy_wanted(reply.y, "y", &mut self.y)?;
        }
        if !description.observables.is_empty() {
            self.observed.resize(description.observables.len(), 0.0);
            copy_wanted(reply.observed, "observed", &mut self.observed)?;
        }
        if description.interface_work {
            self.work = wanted(reply.interface_work_j, "interface_work_j")?;
        }
        Ok(())
    }
}

/// Drives a program that is a subsystem.
struct ProgramHost {
    description: SideDescription,
    copies: Copies,
    known: Vec<Known>,
    /// Rows of the interface.
    interface: usize,
}

impl Host for ProgramHost {
    fn ask(&mut self, ask: Ask, id: u32, input: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
        let copy = id as usize;
        let description = &self.description;
        let (inputs, outputs) = (description.inputs.len(), description.outputs.len());
        output.clear();
        match ask {
            Ask::Outputs => {
                let known = &mut self.known[copy];
                if description.direct_feedthrough {
                    let request = Request::Outputs { u: input };
                    self.copies.of(copy)?.ask(&request, |reply| copy_wanted(reply.y, "y", &mut known.y))?;
                }
                output.extend_from_slice(&known.y);
            }
            Ask::Step => {
                let known = &mut self.known[copy];
                let (times, rest) = input.split_at(2);
                let (u, course) = rest.split_at(inputs);
                let (rows, _) = course.as_chunks::<4>();
                let polynomials = (!rows.is_empty()).then_some(rows);
                let request = Request::Step { time_s: times[0], length_s: times[1], u, polynomials };
                self.copies.of(copy)?.ask(&request, |reply| known.take(description, reply, true))?;
                output.extend_from_slice(&known.y);
            }
            Ask::Rates => {
                let request = Request::Rates { time_s: input[0], u: &input[1..] };
                output.resize(outputs * (1 + 2 * inputs), 0.0);
                let (rate, gains) = output.split_at_mut(outputs);
                let (feedthrough, rate_gain) = gains.split_at_mut(outputs * inputs);
                self.copies.of(copy)?.ask(&request, |reply| {
                    copy_wanted(reply.rate, "rate", rate)?;
                    copy_wanted(reply.feedthrough, "feedthrough", feedthrough)?;
                    copy_wanted(reply.rate_gain, "rate_gain", rate_gain)
                })?;
            }
            Ask::Model => {
                let Some(model) = &description.interface_model else { return Err("has no interface model".into()) };
                let interface = self.interface;
                let request = Request::InterfaceModel { step_s: input[0] };
                self.copies.of(copy)?.ask(&request, |reply| write_model(model, interface, reply, output))?;
            }
            Ask::Observe => output.extend_from_slice(&self.known[copy].observed),
            Ask::Work => output.push(self.known[copy].work),
            Ask::Copy => {
                let new = self.copies.copy(copy);
                let known = self.known[copy].clone();
                match self.known.get_mut(new) {
                    Some(free) => *free = known,
                    None => self.known.push(known),
                }
                output.push(new as f64);
            }
            Ask::Drop => self.copies.drop_copy(copy),
        }
        Ok(())
    }
}

/// Writes the parts of an interface model one after the other, as a host does.
fn write_model(model: &ModelDescription, interface: usize, reply: Reply, to: &mut Vec<f64>) -> Result<(), String> {
    let contacts = model.contacts;
    let n = contacts + interface;
    let rows = wanted(reply.h, "H")?;
    if rows.len() != n {
        return Err(format!("`H` has {} rows instead of {n}", rows.len()));
    }
    for row in rows {
        if row.len() != n {
            return Err(format!("a row of `H` has {} numbers instead of {n}", row.len()));
        }
        to.extend(row);
    }
    let mut put = |part: Option<Vec<f64>>, name: &str, count: usize| {
        let start = to.len();
        to.resize(start + count, 0.0);
        copy_wanted(part, name, &mut to[start..])
    };
    // Without contacts there is nothing to say of them.
    let of_contacts = |part: Option<Vec<f64>>| if contacts == 0 { Some(part.unwrap_or_default()) } else { part };
    let gap = of_contacts(reply.gap);
    let closed = reply.closed.unwrap_or_else(|| gap.iter().flatten().map(|gap| *gap <= TOUCHING).collect());
    put(reply.a, "a", n)?;
    put(reply.w, "w", n)?;
    put(reply.position, "position", interface)?;
    put(gap, "gap", contacts)?;
    put(Some(reply.own_approach.unwrap_or_else(|| vec![0.0; contacts])), "own_approach", contacts)?;
    to.extend([model.stabilisation, model.restitution, model.contact_stiffness, model.contact_damping]);
    if closed.len() != contacts {
        return Err(format!("`closed` has {} entries instead of {contacts}", closed.len()));
    }
    to.extend(closed.iter().map(|closed| f64::from(u8::from(*closed))));
    Ok(())
}

//! A case file that puts programs in the place of one or both sides of a built-in case.

use super::case_file::{CaseFile, DIGESTS, ReferenceKind, digest, parameters};
use super::program_member::ProgramMember;
use crate::export::side_name;
use crate::program::{Named, unit};
use rimbench_cases::cases::Case;
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::cosim::{Port, Side};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::Name;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Makes the case: parameters, times, columns and what is not given come from the original.
///
/// # Errors
/// What of the file does not go together; what the programs say and should not.
pub(super) fn read(path: &Path, text: &str, file: &CaseFile, original: &Arc<Case>, patience: Duration) -> Result<Case> {
    let refused = |message: String| Err(Error::Incompatible(message));
    if !file.interface.is_empty() {
        return refused(format!("[[interface]] is that of {}, which this case is like: valid: none", original.name));
    }
    for (name, table) in &file.parameters {
        if table.mechanics.is_some() || table.actuator.is_some() {
            return refused(format!(
                "[parameters.{name}] names a variable: programs of a case that is like another are told of all parameters by their names"
            ));
        }
        if original.parameters.iter().any(|known| known.name == *name) {
            return refused(format!("[parameters.{name}]: case {} has a parameter of that name", original.name));
        }
    }
    let system = (original.build)(&original.default_parameters(), &SolverEntry::active_set())?;
    let named = |ports: &[Port]| -> Vec<Named> {
        ports.iter().map(|port| (port.name.to_string(), unit(port).to_owned())).collect()
    };
    let mut members = Vec::new();
    for (side, table) in [(Side::Mechanics, &file.mechanics), (Side::Actuator, &file.actuator)] {
        let Some(table) = table else { continue };
        let name = side_name(side);
        if table.command.is_none() {
            return refused(format!("[{name}] of a case that is like another: valid: a `command`"));
        }
        let ports = system.sides[side].ports();
        let names = [named(&ports.inputs), named(&ports.outputs)];
        members.push((side, ProgramMember::open(path, table, side, ports, names, patience)?));
    }
    if members.is_empty() {
        return refused(format!(
            "has neither [mechanics] nor [actuator]: a case that is like {} has a program in the place of one or both",
            original.name
        ));
    }
    let digest = digest(text, members.iter().map(|(_, member)| member.side.digest()));
    let mut case = Case::clone(original);
    case.parameters.extend(parameters(file, DIGESTS[1], &digest));
    let defaults = case.default_parameters();
    members.iter().try_for_each(|(_, member)| member.try_to_begin(&defaults))?;
    for (side, member) in members {
        let build = move |parameters: &_, _: &_| -> Result<Box<dyn rimbench_core::cosim::Subsystem>> {
            Ok(Box::new(member.made(parameters)))
        };
        case = case.with_side(file.name.clone(), side, Arc::new(build))?;
    }
    let defaults = &mut case.defaults;
    defaults.duration_s = file.duration_s.unwrap_or(defaults.duration_s);
    defaults.macro_step_s = file.macro_step_s.unwrap_or(defaults.macro_step_s);
    defaults.micro_step_s = file.micro_step_s.unwrap_or(defaults.micro_step_s.min(defaults.macro_step_s));
    defaults.reference_step_s = file.reference_step_s.unwrap_or(defaults.reference_step_s);
    let about = if file.about.is_empty() {
        format!("{}, with a program of {} in it", original.name, path.display())
    } else {
        file.about.clone()
    };
    Ok(Case {
        name: Name::from(file.name.clone()),
        about: Name::from(about),
        judged_by: (file.reference == Some(ReferenceKind::Original)).then(|| Arc::clone(original)),
        // What tells when the programs change is a parameter.
        from_outside: false,
        ..case
    })
}

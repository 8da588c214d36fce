//! A case one side of which comes from elsewhere: a script, a separate program, or another model.

use super::case::{Case, CoupledSystem};
use super::recorder::sources;
use super::reference_method::ReferenceMethod;
use crate::parameter::Parameters;
use rimbench_core::cosim::{Ports, Side, Subsystem};
use rimbench_core::error::Result;
use rimbench_core::name::Name;
use rimbench_core::solver_entry::SolverEntry;
use std::sync::Arc;

/// Builds one side from the parameters of the case and the ports that the side it stands in for has.
pub type BuildSide = Arc<dyn Fn(&Parameters, &Ports) -> Result<Box<dyn Subsystem>> + Send + Sync>;

impl Case {
    /// The same case under another name, with one side from elsewhere: parameters, times and the other side stay; its
    /// reference is refined.
    ///
    /// Columns that nobody offers any more are left out, and an interface row whose columns are not all there is not
    /// judged; what the new side can observe besides becomes columns. It is built once for that, with the default
    /// parameters. No reference of it is kept ([`from_outside`](Case::from_outside)).
    ///
    /// # Errors
    /// Those of building it.
    pub fn with_side(&self, name: impl Into<Name>, side: Side, build: BuildSide) -> Result<Case> {
        let original = self.build.clone();
        let replaced = move |parameters: &Parameters, solver: &SolverEntry| -> Result<CoupledSystem> {
            let mut system = original(parameters, solver)?;
            system.sides[side] = build(parameters, system.sides[side].ports())?;
            Ok(system)
        };
        let mut system = replaced(&self.default_parameters(), &SolverEntry::active_set())?;
        let offered = sources(&mut system);
        let mut case = Case {
            name: name.into(),
            from_outside: true,
            waits: true,
            constant_mechanics: false,
            // A closed form or an integrator of the original's own knows nothing of the new side.
            reference: Arc::new(|_| Ok(ReferenceMethod::Refined)),
            ..self.clone()
        };
        // A derived column goes with the columns that it is derived from.
        let mut derived: Vec<_> = std::mem::take(&mut system.derived);
        loop {
            let there = |name: &Name| offered.contains(name) || derived.iter().any(|column| column.name == *name);
            case.trace_columns.retain(there);
            case.drawing_columns.retain(there);
            let before = derived.len();
            let kept = |name: &Name| case.trace_columns.contains(name) || case.drawing_columns.contains(name);
            derived.retain(|column| kept(&column.name) && column.from.iter().all(kept));
            if derived.len() == before {
                break;
            }
        }
        let new = system.sides[side].capabilities().observables().to_vec();
        for name in new {
            if !case.trace_columns.contains(&name) && !case.drawing_columns.contains(&name) {
                case.trace_columns.push(name);
            }
        }
        let columns: Vec<Name> = case.trace_columns.iter().chain(&case.drawing_columns).cloned().collect();
        case.interface_columns
            .retain(|row| [&row.position, &row.velocity, &row.force].iter().all(|name| columns.contains(name)));
        if !case.linear_state.iter().all(|variable| columns.contains(&variable.column)) {
            case.linear_state.clear();
        }
        let derived: Vec<Name> = derived.into_iter().map(|column| column.name).collect();
        case.build = Arc::new(move |parameters, solver| {
            let mut system = replaced(parameters, solver)?;
            system.derived.retain(|column| derived.contains(&column.name));
            Ok(system)
        });
        Ok(case)
    }
}

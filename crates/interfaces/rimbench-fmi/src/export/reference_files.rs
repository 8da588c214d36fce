//! What is published beside an FMU for those who import it, by the rules of the FMI project's cross-check (version 4.1):
//! a run of the case as inputs and outputs of the FMU, its steps, and a text.

use rimbench_cases::cases::{Case, CoupledSystem};
use rimbench_core::cosim::{Bounds, Outcome, Side, StopFlag, Trajectory};
use rimbench_core::error::Result;
use rimbench_core::name::Name;
use rimbench_runs::{RunSpec, simulate};
use std::sync::Arc;

/// Name of the text, which is the same for all FMUs, so that several may lie in one folder.
pub const README: &str = "Readme.txt";
const README_TEXT: &str = include_str!("readme.txt");

/// Within what a run of the FMU elsewhere should agree: round-off of other processors, amplified by contacts. Ours; with
/// the same library it agrees to the bit.
const RELATIVE_TOLERANCE: f64 = 1e-6;

/// Files that go beside an FMU.
pub struct ReferenceFiles {
    /// Names with contents: `…_in.csv`, `…_ref.csv`, `…_ref.opt`, [`README`].
    pub files: Vec<(String, Vec<u8>)>,
    /// Communication points of the run.
    pub points: usize,
    /// What became of it.
    pub outcome: Outcome,
}

impl ReferenceFiles {
    /// Tells whether a text is [`README`] as some version of this program writes it.
    pub fn is_readme(text: &[u8]) -> bool {
        let title = README_TEXT.lines().next().unwrap_or_default();
        text.starts_with(title.as_bytes())
    }
}

/// Runs the case of `spec` with its scheme, and says what one side heard and said at every communication point, beside
/// the FMU `model`.fmu.
///
/// # Errors
/// Those of the run.
pub fn reference_files(spec: &RunSpec, side: Side, model: &str) -> Result<ReferenceFiles> {
    let system = (spec.case.build)(&spec.parameters, &spec.solver)?;
    let ports = system.sides[side].ports();
    let inputs = ports.inputs.len();
    let names = ports.inputs.iter().chain(&ports.outputs).map(|port| port.name.clone());
    let columns: Vec<Name> = std::iter::once(Name::from("time_s")).chain(names).collect();
    let build = spec.case.build.clone();
    let bare = Case {
        trace_columns: columns.clone(),
        drawing_columns: Vec::new(),
        interface_columns: Vec::new(),
        linear_state: Vec::new(),
        build: Arc::new(move |parameters, solver| Ok(CoupledSystem::of(build(parameters, solver)?.sides))),
        ..Case::clone(&spec.case)
    };
    let spec = spec.with(|own| own.case = Arc::new(bare))?;
    let result = simulate(&spec, Bounds::default(), None, StopFlag::never())?;
    let told = &result.trajectory;
    let heard: Vec<usize> = (0..=inputs).collect();
    let said: Vec<usize> = (0..columns.len()).filter(|at| *at == 0 || *at > inputs).collect();
    let options = format!(
        "StartTime,0.0\nStopTime,{:?}\nStepSize,{step:?}\nRelTol,{RELATIVE_TOLERANCE:?}\nOutputIntervalLength,{step:?}\n",
        told.end_time().unwrap_or(0.0),
        step = spec.macro_step
    );
    let files = vec![
        (format!("{model}_in.csv"), table(told, &heard)),
        (format!("{model}_ref.csv"), table(told, &said)),
        (format!("{model}_ref.opt"), options.into_bytes()),
        (README.to_owned(), README_TEXT.replace("{version}", env!("CARGO_PKG_VERSION")).into_bytes()),
    ];
    Ok(ReferenceFiles { files, points: told.len(), outcome: result.report.outcome })
}

/// Columns as CSV, the first named `time`, names in quotation marks, numbers by the shortest text that reads back to the same bits.
fn table(trajectory: &Trajectory, columns: &[usize]) -> Vec<u8> {
    let line = |cell: &dyn Fn(usize) -> String| {
        let cells: Vec<String> = columns.iter().map(|at| cell(*at)).collect();
        cells.join(",") + "\n"
    };
    let mut text = line(&|at| format!("{:?}", if at == 0 { "time" } else { &trajectory.columns()[at] }));
    trajectory.rows().for_each(|row| text += &line(&|at| format!("{:?}", row[at])));
    text.into_bytes()
}

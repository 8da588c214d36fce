//! Builders shared by the tests: the wedge box at its defaults, small systems with constant matrices, simple actuators.
#![allow(dead_code, unused_imports, unused_macros)]

use rimbench::cases::CoupledSystem;
use rimbench::catalogue::Catalogue;
use rimbench::complementarity::{ActiveSet, Solver};
use rimbench::error::Result;
use rimbench::harness::monotonic_clock;
use rimbench::models::{WedgeBox, WedgeBoxGeometry};
use rimbench::parameter::{ParameterSet, Parameters, Value};
use rimbench::solver_entry::SolverEntry;
use std::io::Write;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};

#[path = "rivals/mod.rs"]
mod rivals;
pub use rivals::{ENUMERATION_LIMIT, relaxed_cones, rivals};

/// What most tests speak of.
pub use rimbench::cases::{Case, Recorder, ReferenceMethod};
pub use rimbench::cosim::*;
pub use rimbench::error::Failure;
pub use rimbench::interface_model::*;
pub use rimbench::mechanics::*;
pub use rimbench::name::{Name, names};
pub use rimbench::runs::*;
pub use rimbench::schemes::*;
pub use rimbench::statistics::{Pool, order_of_convergence};

/// Plastic contacts without position stabilisation.
pub const PLASTIC: ContactLaw = ContactLaw { stabilisation: 0.0, restitution: 0.0, spring: None };

/// One step of the mechanics per macro step, and as many as the actuator takes.
pub const ONE: MechanicsSteps = MechanicsSteps::ONE;
pub const ALL: MechanicsSteps = MechanicsSteps::AsActuator;

pub const SEQUENCES: [Sequence; 3] = [
    Sequence::Jacobi,
    Sequence::GaussSeidel { first: Side::Actuator },
    Sequence::GaussSeidel { first: Side::Mechanics },
];

/// What the program runs, with rival solvers.
pub fn catalogue() -> &'static Catalogue {
    static CATALOGUE: OnceLock<Catalogue> = OnceLock::new();
    CATALOGUE.get_or_init(|| {
        let mut catalogue = rimbench::everything().unwrap();
        rivals().into_iter().for_each(|solver| catalogue.add_solver(solver).unwrap());
        catalogue
    })
}

/// A run of a scheme on a case with these options and parameters.
pub fn spec_with(case: &str, scheme: &str, options: &[(&str, &str)], set: &[(&str, &str)]) -> RunSpec {
    let mut request = RunRequest::of(case, scheme);
    options.iter().for_each(|(key, value)| request.put(key, value).unwrap());
    request.set = set.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    request.resolve(catalogue()).unwrap()
}

/// Every solver, the rivals among them.
pub fn solvers() -> &'static [Arc<SolverEntry>] {
    catalogue().solvers()
}

pub fn schemes() -> &'static [Arc<SchemeEntry>] {
    catalogue().schemes()
}

pub fn cases() -> &'static [Arc<Case>] {
    catalogue().cases()
}

/// Whether an experiment of the project names a case or a scheme: from then on it has a page, a picture and a verdict,
/// and keeps its order.
pub fn is_published(name: &str) -> bool {
    rimbench::shipped::EXPERIMENTS.iter().any(|(_, text)| text.contains(&format!("\"{name}\"")))
}

pub fn solver_by_name(name: &str) -> &'static Arc<SolverEntry> {
    catalogue().solver(name).unwrap()
}

pub fn scheme_by_name(name: &str) -> &'static Arc<SchemeEntry> {
    catalogue().scheme(name).unwrap()
}

pub fn case_by_name(name: &str) -> &'static Arc<Case> {
    catalogue().case(name).unwrap()
}

pub fn solver() -> &'static Arc<SolverEntry> {
    solver_by_name("active-set")
}

pub fn wedge_box_case() -> &'static Arc<Case> {
    case_by_name("wedge-box")
}

/// Whether contacts have friction, for which some options are refused.
pub fn has_friction(parameters: &Parameters) -> bool {
    parameters.iter().any(|(parameter, value)| parameter.name == "friction" && *value != Value::Number(0.0))
}

/// A run that comes to its end.
pub fn completed(spec: &RunSpec) -> RunResult {
    let result = run(spec);
    let name = format!("{} on {} at H = {}", spec.scheme.name, spec.case.name, spec.macro_step);
    assert_eq!(result.report.outcome, Outcome::Completed, "{name}");
    result
}

/// The reference of the wedge box, computed once.
pub fn wedge_box_reference() -> &'static Reference {
    static REFERENCE: OnceLock<Reference> = OnceLock::new();
    REFERENCE.get_or_init(|| {
        let mut case = Case::clone(wedge_box_case());
        case.defaults.reference_step_s = case.defaults.reference_sampling_s;
        let spec = wedge_box_spec("zero-order-hold", 1e-3).changed(|own| own.case = Arc::new(case));
        Reference::compute(&spec, StopFlag::never()).unwrap()
    })
}

/// The reference of a run by longer steps, which leave errors of schemes to three digits; computed once for all tests.
pub fn coarse_reference(spec: &RunSpec) -> Arc<Reference> {
    static KNOWN: Mutex<Vec<(RunSpec, Arc<Reference>)>> = Mutex::new(Vec::new());
    let spec = with_coarse_reference(spec);
    let known = |(other, _): &&(RunSpec, _)| spec.shares_reference_with(other);
    if let Some((_, reference)) = KNOWN.lock().unwrap().iter().find(known) {
        return reference.clone();
    }
    let reference = Arc::new(Reference::compute(&spec, StopFlag::never()).unwrap());
    KNOWN.lock().unwrap().push((spec, reference.clone()));
    reference
}

/// A run whose reference takes one step per stored point, up to four times as long as usual.
pub fn with_coarse_reference(spec: &RunSpec) -> RunSpec {
    let mut case = Case::clone(&spec.case);
    let defaults = &mut case.defaults;
    defaults.reference_sampling_s = defaults.reference_sampling_s.max(4.0 * defaults.reference_step_s.min(5e-5));
    defaults.reference_step_s = defaults.reference_sampling_s;
    spec.changed(|own| own.case = Arc::new(case))
}

/// A metric of a run against its reference.
pub fn metric(spec: &RunSpec, run: RunResult, reference: &Reference, name: &str) -> f64 {
    let facts = evaluate(spec, run, reference).unwrap().found.facts();
    facts.into_iter().find(|fact| fact.name == name).unwrap().cell().parse().unwrap()
}

/// Largest difference of two runs in a column, and the largest magnitude in the first.
pub fn apart(one: &Trajectory, other: &Trajectory, name: &str) -> (f64, f64) {
    let [one, other] = [one, other].map(|run| column(run, name));
    (max_difference(&one, &other), largest(one.iter().map(|value| value.abs())))
}

/// All values of a run, to the bit.
pub fn bits(run: &Trajectory) -> Vec<u64> {
    run.rows().flatten().map(|value| value.to_bits()).collect()
}

/// The active set behind a trait object: no solver that goes by active sets or keeps few entries, as far as others
/// know.
pub fn opaque_active_set() -> Arc<SolverEntry> {
    let build = Arc::new(|capacity| Solver::other(ActiveSet::new(capacity)));
    Arc::new(SolverEntry { name: "active-set-opaque".into(), build, ..SolverEntry::active_set() })
}

/// The same run with every contact problem solved by that.
pub fn with_opaque_solver(spec: &RunSpec) -> RunSpec {
    let solver = opaque_active_set();
    let model = spec.model.clone().map(|model| ModelOptions { solver: solver.clone(), ..model });
    spec.changed(|own| own.model = model)
}

/// A case, its parameters and a macro step.
pub type SmoothCase = (&'static str, &'static [(&'static str, &'static str)], f64);

pub const REST: [(&str, &str); 3] = [("x1_0_m", "1"), ("v1_0_m_s", "0"), ("v2_0_m_s", "0")];

/// The smooth cases, each from rest, with the finest macro step of a refinement.
pub const SMOOTH: [SmoothCase; 3] =
    [("linear-oscillator", &REST, 5e-4), ("quarter-car", &[], 5e-4), ("precice-oscillator", &[], 1e-3)];

/// Rms distance of both positions of a two-mass case from its closed form over a run.
pub fn error_of_positions(spec: &RunSpec, trajectory: &Trajectory) -> f64 {
    let solution = exact_solution(&spec.case, &spec.parameters);
    let mut row = vec![0.0; trajectory.columns().len()];
    let mut sum = 0.0;
    for own in trajectory.rows() {
        solution(own[0], &mut row);
        sum += (own[1] - row[1]).powi(2) + (own[2] - row[2]).powi(2);
    }
    (sum / trajectory.len() as f64).sqrt()
}

/// The parameters of a case at their defaults, as the struct that declares them.
pub fn defaults<P: ParameterSet>(case: &str) -> P {
    P::read(&case_by_name(case).default_parameters())
}

/// Both sides of a case at its defaults.
pub fn usual_system(case: &Case) -> CoupledSystem {
    (case.build)(&case.default_parameters(), solver()).unwrap()
}

/// A case at its defaults with one scheme; sequence, force return and gain are the scheme's own.
pub fn usual_spec(case: &str, scheme: &str, macro_step: f64) -> RunSpec {
    let request = RunRequest { macro_step_s: Some(macro_step), ..RunRequest::of(case, scheme) };
    request.resolve(catalogue()).unwrap()
}

/// The same with some of the parameters set.
pub fn set_spec(case: &str, set: &[(&str, &str)], scheme: &str, macro_step: f64) -> RunSpec {
    usual_spec(case, scheme, macro_step).changed(|own| own.parameters = case_with(case, set).1)
}

/// A sequence of its own, with the force return that a scheme has with it.
pub fn in_sequence(spec: RunSpec, sequence: Sequence) -> RunSpec {
    let (sequence, force_return) = spec.scheme.sequence_and_return(Some(sequence), None).unwrap();
    spec.changed(|own| (own.sequence, own.force_return) = (sequence, force_return))
}

/// A run with other settings that are valid.
pub trait Changed {
    fn changed(&self, change: impl FnOnce(&mut RunSettings)) -> RunSpec;
}

impl Changed for RunSpec {
    fn changed(&self, change: impl FnOnce(&mut RunSettings)) -> RunSpec {
        self.with(change).unwrap()
    }
}

/// The wedge box in the same way.
pub fn wedge_box_spec(scheme: &str, macro_step: f64) -> RunSpec {
    usual_spec("wedge-box", scheme, macro_step)
}

/// Runs without bounds: a run that diverges goes on until it cannot.
pub fn run(spec: &RunSpec) -> RunResult {
    run_within(spec, Bounds::default())
}

/// Runs; beyond `bounds` it counts as diverged.
pub fn run_within(spec: &RunSpec, bounds: Bounds) -> RunResult {
    simulate(spec, bounds, Some(monotonic_clock), StopFlag::never()).unwrap()
}

/// The closed form of a case.
pub fn exact_solution(case: &Case, parameters: &Parameters) -> impl Fn(f64, &mut [f64]) + use<> {
    match (case.reference)(parameters).unwrap() {
        ReferenceMethod::Exact(solution) => move |t, row: &mut [f64]| solution(t, StopFlag::never(), row),
        ReferenceMethod::Refined | ReferenceMethod::EventDriven | ReferenceMethod::Own(_) => {
            panic!("{} has no closed form", case.name)
        }
    }
}

/// The row of the closed form at time `t`.
pub fn exact_row(case: &Case, parameters: &Parameters, t: f64) -> Vec<f64> {
    let mut row = vec![0.0; case.recorded_columns().len()];
    exact_solution(case, parameters)(t, &mut row);
    row
}

/// A case with some of its parameters set.
pub fn case_with(name: &str, set: &[(&str, &str)]) -> (&'static Arc<Case>, Parameters) {
    let case = case_by_name(name);
    let mut parameters = case.default_parameters();
    for (key, value) in set {
        parameters.set(key, value).unwrap();
    }
    (case, parameters)
}

/// Both sides in one loop with step `h` for `steps` steps, a row after every `every`.
pub fn march(name: &str, set: &[(&str, &str)], h: f64, steps: usize, every: usize) -> Trajectory {
    let (case, parameters) = case_with(name, set);
    let mut system = (case.build)(&parameters, solver()).unwrap();
    let mut recorder = Recorder::new(case, &mut system).unwrap();
    let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), steps / every + 2);
    monolithic(system.sides.lend(), reference_steps(h, steps, every), StopFlag::never(), &mut |point| {
        recorder.record(point, &mut trajectory)
    })
    .unwrap();
    trajectory
}

/// Both sides, lent.
pub fn sides<'a>(
    mechanics: &'a mut (impl Subsystem + 'static),
    actuator: &'a mut (impl Subsystem + 'static),
) -> Sides<'a> {
    PerSide { mechanics, actuator }
}

/// A scheme at its defaults, built for two sides.
pub fn coupled(scheme: &SchemeEntry, sides: Sides<'_>) -> Coupling {
    scheme.couple(sides, None, None).unwrap()
}

/// Steps of a reference of which every `every`-th is shown.
pub fn reference_steps(h: f64, steps: usize, every: usize) -> ReferenceSteps {
    ReferenceSteps { h, steps, every }
}

/// The monolithic wedge box over `duration`, one row per `sampling`, calling `look` at every step.
pub fn wedge_box_monolithic(h: f64, sampling: f64, duration: f64, mut look: impl FnMut(f64, &[f64])) -> Trajectory {
    let case = wedge_box_case();
    let mut system = usual_system(case);
    let mut recorder = Recorder::new(case, &mut system).unwrap();
    let (steps, every) = ((duration / h).round() as usize, (sampling / h).round() as usize);
    let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), steps / every + 2);
    let mut scratch = Trajectory::with_capacity(case.recorded_columns(), steps + 2);
    let mut step = 0;
    monolithic(system.sides.lend(), reference_steps(h, steps, 1), StopFlag::never(), &mut |point| {
        let kept = step % every == 0 || step == steps;
        let into = if kept { &mut trajectory } else { &mut scratch };
        recorder.record(point, into);
        let row = into.row(into.len() - 1);
        look(row[0], row);
        step += 1;
    })
    .unwrap();
    trajectory
}

/// A column by name.
pub fn column(trajectory: &Trajectory, name: &str) -> Vec<f64> {
    let index = trajectory.index_of(name).unwrap_or_else(|| panic!("no column {name}"));
    trajectory.column(index).collect()
}

pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

pub fn smallest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::INFINITY, f64::min)
}

/// Largest absolute difference of two equally long lists.
pub fn max_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// Root mean square difference of two equally long lists.
pub fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    (a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>() / a.len() as f64).sqrt()
}

/// The geometry of the wedge box at its defaults.
pub fn wedge_box_geometry() -> WedgeBoxGeometry {
    rimbench::cases::wedge_box_geometry(&wedge_box_case().default_parameters())
}

/// The mechanics of the wedge box as its own type, for what a trait object does not show.
pub fn wedge_box_mechanics(law: ContactLaw) -> NonSmoothMechanics<WedgeBox> {
    let ports = usual_system(wedge_box_case()).sides.mechanics.ports().clone();
    NonSmoothMechanics::new(WedgeBox::new(wedge_box_geometry()).unwrap(), law, ports, solver().checked(4))
}

/// The hydraulic cylinder of the wedge box.
pub fn wedge_box_cylinder() -> Box<dyn Subsystem> {
    usual_system(wedge_box_case()).sides.actuator
}

/// Eq. 3 of a model at one state.
pub fn linearise(model: &mut impl MechanicalModel, q: &[f64], v: &[f64]) -> Linearisation {
    let size = model.size();
    let mut eq3 = Linearisation {
        mass: MassMatrix::zeros(size.velocities, size.mass),
        force: vec![0.0; size.velocities],
        bilateral: Rows::zeros(size.bilateral, size.velocities),
        unilateral: Rows::zeros(size.unilateral, size.velocities),
        tangential: Rows::zeros(0, size.velocities),
        interface: Rows::zeros(size.interface, size.velocities),
    };
    model.prepare(q, v);
    model.mass_matrix(q, eq3.mass.entries_mut());
    model.forces(q, v, &mut eq3.force);
    model.bilateral(q, v, &mut eq3.bilateral);
    model.unilateral(q, v, &mut eq3.unilateral);
    model.interface(q, v, &mut eq3.interface);
    eq3
}

/// Eq. 4 from Eq. 3.
pub fn reduce(eq3: &Linearisation, v: &[f64], h: f64, stabilisation: f64) -> (Elimination, ReducedInterfaceModel) {
    let mut elimination = Elimination::new(eq3);
    let mut model = ReducedInterfaceModel::zeros(eq3.unilateral.len(), eq3.interface.len());
    elimination.reduce(eq3, v, h, stabilisation, &mut model).unwrap();
    (elimination, model)
}

/// A block of constant rows: `position = A q + offset`, `Ȧ v = 0`.
#[derive(Debug, Clone, Default)]
pub struct ConstantRows {
    pub jacobian: Vec<Vec<f64>>,
    pub offset: Vec<f64>,
}

impl ConstantRows {
    pub fn new(rows: &[(&[f64], f64)]) -> Self {
        ConstantRows {
            jacobian: rows.iter().map(|(row, _)| row.to_vec()).collect(),
            offset: rows.iter().map(|(_, offset)| *offset).collect(),
        }
    }

    fn write(&self, q: &[f64], rows: &mut Rows) {
        for (index, (row, offset)) in self.jacobian.iter().zip(&self.offset).enumerate() {
            let n = row.len();
            rows.jacobian[index * n..(index + 1) * n].copy_from_slice(row);
            rows.position[index] = offset + row.iter().zip(q).map(|(a, q)| a * q).sum::<f64>();
        }
    }
}

/// A mechanical system whose mass, force and rows never change: its reduced model is exact for any macro step.
#[derive(Debug, Clone, Default)]
pub struct LinearModel {
    pub mass: Vec<f64>,
    pub force: Vec<f64>,
    pub bilateral: ConstantRows,
    pub unilateral: ConstantRows,
    pub tangential: ConstantRows,
    pub interface: ConstantRows,
    /// A contact that never rebounds, if any.
    pub plastic: &'static [usize],
    pub q: Vec<f64>,
    pub v: Vec<f64>,
}

impl LinearModel {
    /// Masses and forces on them, at rest at the origin, with these interface rows and nothing else.
    pub fn new(mass: &[f64], force: &[f64], interface: &[(&[f64], f64)]) -> Self {
        let rest = vec![0.0; mass.len()];
        LinearModel {
            mass: mass.to_vec(),
            force: force.to_vec(),
            interface: ConstantRows::new(interface),
            q: rest.clone(),
            v: rest,
            ..LinearModel::default()
        }
    }

    /// With contacts.
    pub fn over(self, unilateral: &[(&[f64], f64)]) -> Self {
        LinearModel { unilateral: ConstantRows::new(unilateral), ..self }
    }

    /// With surfaces along which there may be friction.
    pub fn along(self, tangential: &[(&[f64], f64)]) -> Self {
        LinearModel { tangential: ConstantRows::new(tangential), ..self }
    }

    /// From these velocities.
    pub fn moving(self, v: &[f64]) -> Self {
        LinearModel { v: v.to_vec(), ..self }
    }
}

impl MechanicalModel for LinearModel {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: self.mass.len(),
            bilateral: self.bilateral.offset.len(),
            unilateral: self.unilateral.offset.len(),
            tangential: self.tangential.offset.len(),
            interface: self.interface.offset.len(),
            plastic: self.plastic,
            ..ModelSize::default()
        }
    }
    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.q.clone(), self.v.clone())
    }
    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.copy_from_slice(&self.mass);
    }
    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&self.force);
    }
    fn bilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        self.bilateral.write(q, rows);
    }
    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        self.unilateral.write(q, rows);
    }
    fn tangential(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        self.tangential.write(q, rows);
    }
    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        self.interface.write(q, rows);
    }
    fn potential_energy(&self, q: &[f64]) -> f64 {
        -self.force.iter().zip(q).map(|(f, q)| f * q).sum::<f64>()
    }
    fn names(&self) -> ModelNames {
        let contacts = (1..=self.unilateral.offset.len()).map(|contact| contact.to_string().into()).collect();
        ModelNames { contacts, ..ModelNames::default() }
    }
}

/// Ports of a force–displacement coupling of dimension 1 or 2, of the mechanics and of the actuator.
pub fn force_displacement_ports(interface: usize) -> (Ports, Ports) {
    let port = |quantity, names: [&'static str; 2]| -> Vec<Port> {
        names[..interface].iter().map(|&name| Port::new(name, quantity)).collect()
    };
    let forces = port(Quantity::Force, ["force_1_n", "force_2_n"]);
    let mut motion = port(Quantity::Position, ["position_1_m", "position_2_m"]);
    motion.extend(port(Quantity::Velocity, ["velocity_1_m_s", "velocity_2_m_s"]));
    (
        Ports { inputs: forces.clone(), outputs: motion.clone(), direct_feedthrough: false },
        Ports { inputs: motion, outputs: forces, direct_feedthrough: true },
    )
}

pub fn stepper<M: MechanicalModel>(model: M, law: ContactLaw) -> NonSmoothMechanics<M> {
    let size = model.size();
    let (ports, _) = force_displacement_ports(size.interface);
    NonSmoothMechanics::new(model, law, ports, solver().checked(size.unilateral))
}

/// Springs and dampers that integrate their own deflection: `ẋ = w`, `F = −k x − c w`, explicit Euler, no memory else.
#[derive(Debug, Clone)]
pub struct Springs {
    pub stiffness: Vec<f64>,
    pub damping: Vec<f64>,
    pub deflection: Vec<f64>,
    pub ports: Ports,
    steps: u64,
}

impl Springs {
    pub fn new(stiffness: &[f64], damping: &[f64]) -> Self {
        Springs {
            stiffness: stiffness.to_vec(),
            damping: damping.to_vec(),
            deflection: vec![0.0; stiffness.len()],
            ports: force_displacement_ports(stiffness.len()).1,
            steps: 0,
        }
    }
}

impl Subsystem for Springs {
    subsystem_methods!(ports capabilities clone);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        let m = self.stiffness.len();
        for i in 0..m {
            y[i] = -self.stiffness[i] * self.deflection[i] - self.damping[i] * u[m + i];
        }
        Ok(())
    }
    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let m = self.stiffness.len();
        for (deflection, velocity) in self.deflection.iter_mut().zip(&u[m..]) {
            *deflection += h * velocity;
        }
        self.steps += 1;
        Ok(())
    }

    fn counters(&self) -> SubsystemCounters {
        SubsystemCounters { micro_steps: self.steps, ..SubsystemCounters::default() }
    }
}

impl Capabilities for Springs {
    fn output_rates(&mut self, _t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        let m = self.stiffness.len();
        rates.feedthrough.fill(0.0);
        rates.rate_gain.fill(0.0);
        for i in 0..m {
            rates.rate[i] = -self.stiffness[i] * u[m + i];
            rates.feedthrough[i * 2 * m + m + i] = -self.damping[i];
            rates.rate_gain[i * 2 * m + m + i] = -self.stiffness[i];
        }
        Ok(true)
    }
}

/// Runs two sides with a scheme that was built for them.
pub fn observed(
    setup: &Setup,
    sides: Sides<'_>,
    coupling: Coupling,
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Report {
    coupling.run(setup, sides, RunControl::default(), observe)
}

/// One row per communication point: time, outputs of the mechanics, outputs of the actuator, force received.
pub fn rows_of(setup: &Setup, mut sides: Sides<'_>, scheme: &SchemeEntry) -> (Report, Vec<Vec<f64>>) {
    let mut rows = Vec::new();
    let coupling = coupled(scheme, sides.lend());
    let report = observed(setup, sides, coupling, &mut |point| rows.push(row_of(&point)));
    (report, rows)
}

/// The same with every micro step of the actuator first, its profile returned in as many steps of the mechanics.
pub fn coupled_rows(
    scheme: &str,
    grid: CommunicationGrid,
    h: f64,
    mut sides: Sides<'_>,
    model: Option<&ModelOptions>,
) -> Vec<Vec<f64>> {
    let first = Sequence::GaussSeidel { first: Side::Actuator };
    let mut setup = Setup::new(grid, h, first, ForceReturn::Profile);
    setup.mechanics_steps = ALL;
    let coupling = scheme_by_name(scheme).couple(sides.lend(), model, None).unwrap();
    let mut rows = Vec::new();
    let report = observed(&setup, sides, coupling, &mut |point| rows.push(row_of(&point)));
    assert_eq!(report.outcome, Outcome::Completed);
    rows
}

/// The same in one loop.
pub fn monolithic_rows(steps: ReferenceSteps, sides: Sides<'_>) -> Vec<Vec<f64>> {
    let mut rows = Vec::new();
    monolithic(sides, steps, StopFlag::never(), &mut |point| rows.push(row_of(&point))).unwrap();
    rows
}

pub fn row_of(point: &CommunicationPoint<'_>) -> Vec<f64> {
    [&[point.time], point.y.mechanics, point.y.actuator, point.received].concat()
}

/// A folder of the data of others, which the project does not hold: below the one that `RIMBENCH_DATA_OF_OTHERS` names.
///
/// Where the variable is not set the test is to end; a line says so, past the capture of the harness, so that who runs
/// the tests sees what was not tested.
pub fn data_of_others(folder: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("RIMBENCH_DATA_OF_OTHERS") else {
        let test = std::thread::current().name().unwrap_or("a test").to_owned();
        let line = format!("skipped: {test}: RIMBENCH_DATA_OF_OTHERS is not set, no data from {folder}\n");
        let _ = std::io::stderr().write_all(line.as_bytes());
        return None;
    };
    Some(PathBuf::from(root).join(folder))
}

/// The files below a folder with their code, tests left out.
pub fn sources(folder: &std::path::Path) -> Vec<(std::path::PathBuf, String)> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            files.push((path, text.split("#[cfg(test)]").next().unwrap_or_default().to_owned()));
        }
    }
    files
}

//! Bodies, loads and force histories at random, for one macro step of any scheme.

use crate::support::*;
use nalgebra::DMatrix;
use rand::RngExt;
use rand_pcg::Pcg64;

pub const ACTUATOR_FIRST: Sequence = Sequence::GaussSeidel { first: Side::Actuator };

/// Macro step, s, and relative size up to which a sum over the micro steps of one counts as round-off.
pub const H: f64 = 0.3;
pub const ROUND_OFF: f64 = 1e-11;

/// An actuator that plays one force after the other, whatever it is given.
pub struct Played {
    pub forces: Vec<Vec<f64>>,
    /// The inputs of all steps.
    pub told: Vec<Vec<f64>>,
    ports: Ports,
}

impl Played {
    pub fn new(forces: Vec<Vec<f64>>) -> Self {
        Played { ports: force_displacement_ports(forces[0].len()).1, told: Vec::new(), forces }
    }

    pub fn random(rng: &mut Pcg64, micro_steps: usize, interface: usize) -> Self {
        Played::new((0..micro_steps).map(|_| draw(rng, interface, 6.0)).collect())
    }
}

impl Capabilities for Played {}

impl Subsystem for Played {
    subsystem_methods!(ports capabilities no_counters no_clone);

    fn outputs(&mut self, _u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        y.copy_from_slice(&self.forces[self.told.len().min(self.forces.len() - 1)]);
        Ok(())
    }
    fn step(&mut self, _t: f64, u: &[f64], _h: f64) -> Result<(), Failure> {
        self.told.push(u.to_vec());
        Ok(())
    }
}

/// A mechanics whose interface model is changed before it is sent.
pub struct Misreported<F, M = LinearModel> {
    pub inner: NonSmoothMechanics<M>,
    pub change: F,
}

impl<F: Fn(&mut ReducedInterfaceModel) + Send, M: MechanicalModel + Clone + 'static> Subsystem for Misreported<F, M> {
    subsystem_methods!(step_of_inner ports_of_inner outputs_of_inner counters_of_inner no_clone);
    fn capabilities(&mut self) -> &mut dyn Capabilities {
        self
    }
}

impl<F: Fn(&mut ReducedInterfaceModel), M: MechanicalModel + Clone + 'static> Capabilities for Misreported<F, M> {
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel> {
        self.inner.empty_interface_model()
    }
    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        let offered = self.inner.interface_model(h, model);
        (self.change)(model);
        offered
    }
    fn interface_work(&mut self) -> Option<f64> {
        self.inner.interface_work()
    }
}

pub fn draw(rng: &mut Pcg64, len: usize, size: f64) -> Vec<f64> {
    (0..len).map(|_| size * rng.random_range(-1.0..1.0)).collect()
}

pub fn rows(rng: &mut Pcg64, count: usize, columns: usize) -> ConstantRows {
    ConstantRows { jacobian: (0..count).map(|_| draw(rng, columns, 1.0)).collect(), offset: vec![0.0; count] }
}

/// A body of 2 to 5 freedoms with a load, moving anyhow, with this many contacts at zero gap and interface rows.
pub fn body(rng: &mut Pcg64, contacts: usize, interface: usize) -> LinearModel {
    let n = rng.random_range(2..6);
    LinearModel {
        mass: (0..n).map(|_| rng.random_range(0.3..3.0)).collect(),
        force: draw(rng, n, 3.0),
        unilateral: rows(rng, contacts, n),
        interface: rows(rng, interface, n),
        q: vec![0.0; n],
        v: draw(rng, n, 1.0),
        ..LinearModel::default()
    }
}

/// One whose contacts do not depend on each other, so that bilateral ones and penetrations have one answer.
pub fn independent(rng: &mut Pcg64, interface: usize) -> LinearModel {
    loop {
        let contacts = rng.random_range(1..4);
        let model = body(rng, contacts, interface);
        let values = matrix(&model.unilateral, model.mass.len()).singular_values();
        if contacts < model.mass.len() && values.min() > 0.05 * values.max() {
            return model;
        }
    }
}

/// A positive semidefinite matrix, row-major.
pub fn semidefinite(rng: &mut Pcg64, n: usize, rank: usize) -> DMatrix<f64> {
    let half = DMatrix::from_vec(n, rank, draw(rng, n * rank, 1.0));
    &half * half.transpose()
}

/// One macro step with the mean force returned: the report and the micro steps in it.
pub fn macro_step(
    (mechanics, actuator): (&mut (impl Subsystem + 'static), &mut (impl Subsystem + 'static)),
    (scheme, options): (&str, &ModelOptions),
    (micro_steps, mechanics_steps, force_return): (usize, u32, ForceReturn),
) -> Report {
    let grid = CommunicationGrid::new(H, 1.0, H).unwrap();
    let mut setup = Setup::new(grid, H / micro_steps as f64, ACTUATOR_FIRST, force_return);
    setup.mechanics_steps = MechanicsSteps::count(mechanics_steps).unwrap();
    let coupling = scheme_by_name(scheme).couple(sides(mechanics, actuator), Some(options), None).unwrap();
    let control = RunControl { inside: Some(usize::MAX), audit: true, ..RunControl::default() };
    let report = coupling.run(&setup, sides(mechanics, actuator), control, &mut |_| ());
    assert_eq!(report.outcome, Outcome::Completed);
    report
}

/// Interface velocities of the model at the end of each micro step.
pub fn velocities(report: &Report, interface: usize) -> Vec<Vec<f64>> {
    let inside = report.inside.as_ref().unwrap();
    inside.rows().map(|row| row[row.len() - interface..].to_vec()).collect()
}

pub fn matrix(rows: &ConstantRows, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows.jacobian.len(), columns, |i, j| rows.jacobian[i][j])
}

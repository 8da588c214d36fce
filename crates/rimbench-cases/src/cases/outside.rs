//! A case one side of which comes from elsewhere: a script, a program of its own, somebody else's model.

use super::case::{Case, CoupledSystem};
use super::parameters::Parameters;
use super::recorder::sources;
use super::reference_method::ReferenceMethod;
use rimbench_core::cosim::{Ports, Side, Subsystem};
use rimbench_core::error::Result;
use rimbench_core::name::Name;
use rimbench_core::solver_entry::SolverEntry;
use std::sync::Arc;

/// Builds one side from the parameters of the case and the ports that the side it stands in for has.
pub type BuildSide = Arc<dyn Fn(&Parameters, &Ports) -> Result<Box<dyn Subsystem>> + Send + Sync>;

impl Case {
    /// The same case under another name, with one side from elsewhere: parameters, times and the other side stay; its reference is refined.
    ///
    /// Columns that nobody offers any more are left out, and an interface row whose columns are not all there is not judged; what the
    /// new side can observe besides becomes columns. It is built once for that, with the default parameters. No reference of it is kept
    /// ([`from_outside`](Case::from_outside)).
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

#[cfg(test)]
mod tests {
    use super::super::two_masses::linear_oscillator;
    use super::*;
    use crate::catalogue::Catalogue;
    use crate::models::{LineMass, MassRole, MassSide, OscillatorIntegrator};
    use crate::runs::{Reference, RunRequest, RunResult, evaluate, simulate};
    use rimbench_core::cosim::{Bounds, Capabilities, Outcome, StopFlag, SubsystemCounters, subsystem_methods};
    use rimbench_core::error::Failure;

    /// A side that can do nothing besides stepping, made from one that can do more.
    struct Bare(Box<dyn Subsystem>);

    impl Capabilities for Bare {}

    impl Subsystem for Bare {
        subsystem_methods!(capabilities no_clone);

        fn ports(&self) -> &Ports {
            self.0.ports()
        }
        fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
            self.0.outputs(u, y)
        }
        fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
            self.0.step(t, u, h)
        }
        fn counters(&self) -> SubsystemCounters {
            self.0.counters()
        }
    }

    fn mass(parameters: &Parameters) -> Box<dyn Subsystem> {
        let [mass, stiffness, x, v] =
            ["mass_2_kg", "stiffness_2_n_m", "x2_0_m", "v2_0_m_s"].map(|name| parameters.setting(name).unwrap());
        let body = LineMass { mass, stiffness, start: [x, v], ..LineMass::default() };
        Box::new(MassSide::new(1, body, MassRole::ForceDriven, OscillatorIntegrator::SemiImplicitEuler))
    }

    fn catalogue(build: BuildSide) -> Catalogue {
        let original = linear_oscillator();
        let mut catalogue = Catalogue::standard();
        let outside = original.with_side("outside", Side::Mechanics, build).unwrap();
        let judged_by = Some(catalogue.case("linear-oscillator").unwrap().clone());
        catalogue.add_case(Case { judged_by, ..outside }).unwrap();
        catalogue
    }

    fn run(catalogue: &Catalogue, case: &str, scheme: &str) -> (RunResult, Box<[Option<f64>]>) {
        let mut request = RunRequest::of(case, scheme);
        request.set.push(("integrator".into(), "semi-implicit-euler".into()));
        request.put("duration_s", "0.1").unwrap();
        let spec = request.resolve(catalogue).unwrap();
        let result = simulate(&spec, Bounds::default(), None, StopFlag::never()).unwrap();
        let reference = Reference::compute(&spec, StopFlag::never()).unwrap();
        (result.clone(), evaluate(&spec, result, &reference).unwrap().found.metrics)
    }

    #[test]
    fn the_same_side_from_outside_gives_the_same_digits_against_the_same_reference() {
        let catalogue = catalogue(Arc::new(|parameters, _| Ok(mass(parameters))));
        let (own, own_metrics) = run(&catalogue, "outside", "rim-smooth");
        let (built_in, metrics) = run(&catalogue, "linear-oscillator", "rim-smooth");
        assert_eq!(own.report.outcome, Outcome::Completed);
        assert_eq!(own.trajectory, built_in.trajectory);
        assert_eq!(own_metrics, metrics);
        assert!(metrics.iter().flatten().any(|value| *value > 0.0));
    }

    #[test]
    fn what_a_side_from_outside_does_not_offer_is_left_out_and_schemes_that_need_it_say_so() {
        let catalogue = catalogue(Arc::new(|parameters, _| Ok(Box::new(Bare(mass(parameters))))));
        let (bare, _) = run(&catalogue, "outside", "zero-order-hold");
        assert_eq!(bare.report.outcome, Outcome::Completed);
        let (built_in, _) = run(&catalogue, "linear-oscillator", "zero-order-hold");
        for (index, name) in bare.trajectory.columns().iter().enumerate() {
            let known = built_in.trajectory.index_of(name).unwrap();
            assert!(bare.trajectory.column(index).eq(built_in.trajectory.column(known)), "{name}");
        }
        let (skipped, metrics) = run(&catalogue, "outside", "rim-smooth");
        assert!(matches!(skipped.report.outcome, Outcome::Skipped { .. }));
        assert!(metrics.iter().all(Option::is_none));
    }
}

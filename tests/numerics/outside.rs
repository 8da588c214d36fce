//! Sides of cases from outside the library.

use crate::support::*;
use rimbench::cases::BuildSide;
use rimbench::catalogue::Catalogue;
use rimbench::models::{LineMass, MassRole, MassSide, OscillatorIntegrator};
use rimbench::parameter::Parameters;
use rimbench_core::cosim::subsystem_methods;
use std::sync::Arc;

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
    let (mut catalogue, original) = (Catalogue::standard(), case_by_name("linear-oscillator"));
    let outside = original.with_side("outside", Side::Mechanics, build).unwrap();
    catalogue.add_case(Case { judged_by: Some(original.clone()), ..outside }).unwrap();
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

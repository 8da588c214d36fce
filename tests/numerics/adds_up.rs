//! What sides say of their own motion: of ours it is so, and of what is off by a sign, a unit or a size it is found out
//! and named.

use crate::support::*;
use rimbench::cases::{CoupledSystem, Doubts, Tried, doubts_of, model_against_outputs};
use rimbench_core::cosim::subsystem_methods;
use std::sync::Arc;

/// What is said wrongly of a side, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Lie {
    /// Positions, velocities and forces by these.
    outputs: Option<(Quantity, f64)>,
    /// Forces that are taken.
    inputs: Option<f64>,
    /// H, a of the interface model.
    model: Option<[f64; 2]>,
    /// Rates, feedthrough, gains of rates.
    rates: Option<[f64; 3]>,
    /// Outputs are those of the step before.
    late: bool,
    /// Positions and velocities move in steps of its own, in so many of those that are asked for.
    own_steps: usize,
    copies: bool,
    /// Whether its interface model is held against its outputs whenever it is asked for.
    compared: bool,
}

struct Liar {
    side: Box<dyn Subsystem>,
    lie: Lie,
    ports: Ports,
    before: Vec<f64>,
    taken: usize,
    waited: f64,
}

const HONEST: Lie = Lie {
    outputs: None,
    inputs: None,
    model: None,
    rates: None,
    late: false,
    own_steps: 1,
    copies: true,
    compared: false,
};

impl Liar {
    fn of(side: Box<dyn Subsystem>, lie: Lie) -> Box<dyn Subsystem> {
        let ports = side.ports().clone();
        Box::new(Liar { before: vec![f64::NAN; ports.outputs.len()], ports, side, lie, taken: 0, waited: 0.0 })
    }

    fn told(&mut self, u: &[f64]) -> Result<Vec<f64>, Failure> {
        let mut y = vec![0.0; self.ports.outputs.len()];
        self.side.outputs(u, &mut y)?;
        if let Some((quantity, factor)) = self.lie.outputs {
            let of = self.ports.outputs.iter().zip(&mut y).filter(|(port, _)| port.quantity == quantity);
            of.for_each(|(_, y)| *y *= factor);
        }
        Ok(y)
    }

    fn taken(&self, u: &[f64]) -> Vec<f64> {
        u.iter().map(|u| self.lie.inputs.unwrap_or(1.0) * u).collect()
    }
}

impl Subsystem for Liar {
    subsystem_methods!(ports capabilities no_counters);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        let now = self.told(&self.taken(u))?;
        let late = self.lie.late && self.before[0].is_finite();
        y.copy_from_slice(if late { &self.before } else { &now });
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let u = self.taken(u);
        self.before = self.told(&u)?;
        self.taken += 1;
        self.waited += h;
        if self.taken.is_multiple_of(self.lie.own_steps) {
            self.side.step(t + h - self.waited, &u, self.waited)?;
            self.waited = 0.0;
        }
        Ok(())
    }

    fn try_clone(&self) -> Result<Box<dyn Subsystem>, Failure> {
        if !self.lie.copies {
            return Err(rimbench::error::Cause::NotCopied.into());
        }
        let (side, ports, before) = (self.side.try_clone()?, self.ports.clone(), self.before.clone());
        Ok(Box::new(Liar { side, ports, before, ..*self }))
    }
}

impl Capabilities for Liar {
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel> {
        self.side.capabilities().empty_interface_model()
    }

    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        let filled = self.side.capabilities().interface_model(h, model)?;
        if let Some([of_h, of_a]) = self.lie.model {
            model.h.iter_mut().for_each(|h| *h *= of_h);
            model.a.iter_mut().for_each(|a| *a *= of_a);
        }
        if self.lie.compared {
            model_against_outputs(model, &self.told(&vec![0.0; self.ports.inputs.len()])?)
                .map_err(Failure::reported)?;
        }
        Ok(filled)
    }

    fn observables(&mut self) -> &[Name] {
        self.side.capabilities().observables()
    }

    fn observe(&mut self, h: f64, row: &mut [f64]) {
        self.side.capabilities().observe(h, row);
    }

    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        let told = self.side.capabilities().output_rates(t, u, rates)?;
        if let Some([of_rate, of_feedthrough, of_gain]) = self.lie.rates {
            rates.rate.iter_mut().for_each(|rate| *rate *= of_rate);
            rates.feedthrough.iter_mut().for_each(|entry| *entry *= of_feedthrough);
            rates.rate_gain.iter_mut().for_each(|entry| *entry *= of_gain);
        }
        Ok(told)
    }
}

fn doubts(case: &Case, set: &[(&str, &str)], h: f64, lies: PerSide<Lie>) -> Doubts {
    let mut parameters = case.default_parameters().lasting(case.defaults.duration_s);
    set.iter().for_each(|(name, value)| parameters.set(name, value).unwrap());
    let system = (case.build)(&parameters, solver()).unwrap();
    let PerSide { mechanics, actuator } = system.sides;
    let mut sides =
        PerSide { mechanics: Liar::of(mechanics, lies.mechanics), actuator: Liar::of(actuator, lies.actuator) };
    let (any_step, probed) = (PerSide::from_fn(|_| true), PerSide::from_fn(|_| false));
    let tried = Tried { h, any_step, probed, declared: false };
    doubts_of(sides.lend(), tried)
}

#[test]
fn what_our_own_sides_say_adds_up_whatever_they_offer_and_however_they_step() {
    let mut wrong = Vec::new();
    for case in cases() {
        for (what, lie) in [
            ("as it is", HONEST),
            ("without copies", Lie { copies: false, ..HONEST }),
            ("a step late", Lie { late: true, ..HONEST }),
            ("by two steps", Lie { own_steps: 2, ..HONEST }),
            ("by seven steps", Lie { own_steps: 7, ..HONEST }),
        ] {
            let times = case.defaults;
            for h in [times.micro_step_s, times.reference_step_s] {
                let found = doubts(case, &[], h, PerSide { mechanics: lie, actuator: lie });
                for side in Side::BOTH {
                    if let Some(fault) = &found.faults[side] {
                        wrong.push(format!("{} {what}, {h} s, {side:?}: {}", case.name, fault.words));
                    }
                }
                // A contact may be hit in the first steps of it, and a force may be beyond its range in long ones.
                if let Some((side, failure)) = found.failed.filter(|_| lie == HONEST && h <= times.micro_step_s) {
                    wrong.push(format!("{}: {side:?} fails: {failure}", case.name));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} are called wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// A model puts right what the joints of its mechanics have drifted, by the square of a step.
#[test]
fn no_interface_model_of_ours_is_called_wrong_during_a_run_however_long_its_steps() {
    let mut asked = 0;
    for case in cases() {
        for times in [1.0, 4.0] {
            let mut held = Case::clone(case);
            let build = case.build.clone();
            held.build = Arc::new(move |parameters, solver| {
                let system = build(parameters, solver)?;
                let PerSide { mechanics, actuator } = system.sides;
                let mechanics = Liar::of(mechanics, Lie { compared: true, ..HONEST });
                Ok(CoupledSystem { sides: PerSide { mechanics, actuator }, ..system })
            });
            let spec = usual_spec(&case.name, "rim-nonsmooth-gap", times * case.defaults.macro_step_s);
            let spec = spec.with(|settings| settings.case = Arc::new(held)).unwrap();
            let outcome = run(&spec).report.outcome;
            let fault = outcome.reason().contains("a fault of this side");
            assert!(!fault, "{} at {times} H: {outcome:?}", case.name);
            asked += usize::from(outcome == Outcome::Completed);
        }
    }
    assert!(asked > 40, "{asked} runs complete");
}

/// Machines without a contact that is closed at the start; the last has two rows.
const FREE: [(&str, &[(&str, &str)]); 2] = [("linear-oscillator", &[("v2_0_m_s", "0.3")]), ("bouncing-ball", &[])];

#[test]
fn a_sign_a_unit_and_a_size_of_what_a_mechanics_says_are_found_and_named() {
    let sizes = [-1.0, 1000.0, 1e-3, 57.3, -1000.0, 4.0];
    for (name, set) in FREE {
        let case = case_by_name(name);
        let h = case.defaults.micro_step_s;
        let words = |lie: Lie| {
            let found = doubts(case, set, h, PerSide { mechanics: lie, actuator: HONEST });
            (found.faults.mechanics.clone(), format!("{name} {lie:?}: {found:?}"))
        };
        for copies in [true, false] {
            for size in sizes {
                for (quantity, name) in [(Quantity::Position, "position"), (Quantity::Velocity, "velocity")] {
                    let (fault, said) = words(Lie { outputs: Some((quantity, size)), copies, ..HONEST });
                    let fault = fault.unwrap_or_else(|| panic!("{said}"));
                    assert!(fault.words.contains(name), "{said}");
                    // What is proposed sets it right.
                    if let Some(remedy) = fault.remedy {
                        assert_eq!(remedy.quantity, quantity, "{said}");
                        assert!((remedy.factor * size - 1.0).abs() < 0.15, "{said}");
                    }
                    assert!(size != -1.0 || fault.remedy.is_some(), "{said}");
                    assert!(size != -1.0 || fault.words.contains("reversed"), "{said}");
                }
                if size > 0.0 {
                    for model in [[size, size], [1.0, size], [size, 1.0]] {
                        let (fault, said) = words(Lie { model: Some(model), copies, ..HONEST });
                        // Without a load of its own a is nothing, and so is what is said of it; what is a little less
                        // may be stiff.
                        let unsaid = model[0] == 1.0 || (!copies && size == 4.0);
                        assert!(fault.is_some_and(|fault| fault.words.contains("model")) || unsaid, "{said}");
                    }
                    let (fault, said) = words(Lie { inputs: Some(size), copies, ..HONEST });
                    // Beside its own motion a little answer in steps one after the other is none.
                    let unsaid = !copies && size < 1.0;
                    assert!(fault.is_some_and(|fault| fault.words.contains("force")) || unsaid, "{said}");
                }
            }
        }
    }
}

#[test]
fn a_sign_a_unit_and_a_size_of_the_derivatives_of_a_force_are_found() {
    let case = case_by_name("linear-oscillator");
    for size in [-1.0, 1000.0, 1e-3, 0.0, 4.0] {
        for rates in [[size, size, size], [size, 1.0, 1.0], [1.0, size, 1.0]] {
            let lie = Lie { rates: Some(rates), ..HONEST };
            let found = doubts(
                case,
                &[("v2_0_m_s", "0.3"), ("v1_0_m_s", "0.2")],
                case.defaults.micro_step_s,
                PerSide { mechanics: HONEST, actuator: lie },
            );
            let fault = found.faults.actuator.clone().unwrap_or_else(|| panic!("{rates:?}: {found:?}"));
            assert!(fault.words.contains("derivative"), "{rates:?}: {}", fault.words);
        }
    }
}

//! How much a coupling grows per macro step, predicted without a run from its linearisation.

use super::RunSpec;
use nalgebra::DMatrix;
use rimbench_core::cosim::{ActuatorIntegrator, ForceReturn, OutputRates, Sequence, Side, Sides, division};
use rimbench_core::error::{Cause, Error, Failure, Result};
use rimbench_core::interface_model::{Belief, Condensation, condense};

/// A spectral radius this close to one is one: the accuracy to which it is probed.
pub const NEUTRAL: f64 = 1e-9;

/// Actuator and mechanics of one interface row, linear, contacts as they are.
///
/// ```text
/// m ẇ = λ − k x − d w,  ẋ = w          λ = F − c w,  Ḟ = −K w − ν F
/// ```
/// The mechanics takes one semi-implicit step of H. The actuator is exact for an input that is held over its micro step
/// δ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearCoupling {
    /// Mass m of the mechanics at the interface, kg.
    pub mass: f64,
    /// Stiffness k that the mechanics has of its own, N/m.
    pub own_stiffness: f64,
    /// Damping d that the mechanics has of its own, N·s/m; taken explicitly.
    pub own_damping: f64,
    /// Stiffness K of the actuator, N/m.
    pub stiffness: f64,
    /// Damping c of the actuator, its direct feedthrough, N·s/m.
    pub damping: f64,
    /// Leak ν of the actuator, 1/s.
    pub leak: f64,
}

/// A scheme whose macro step is known as a linear map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Recurrence {
    /// Both sides hold what they received at `t_k`.
    HeldByBoth,
    /// The mechanics goes first under the force of `t_k`; the actuator holds the velocity after it.
    MechanicsFirst,
    /// The actuator goes first, holds the velocity of `t_k`, and returns its mean force.
    MeanReturned,
    /// The same, but it returns its force at the end.
    EndReturned,
    /// The actuator moves with a model of so many times the mass and returns its mean force.
    Model {
        /// Mass of the model over that of the mechanics.
        mass_ratio: f64,
    },
}

impl LinearCoupling {
    /// Returns the spectral radius of the map of one macro step `H` (s) with so many micro steps: stable up to 1.
    pub fn growth(&self, recurrence: Recurrence, macro_step: f64, micro_steps: usize) -> f64 {
        // A position that nothing depends on is no state.
        let first = usize::from(self.own_stiffness == 0.0);
        let mut map = DMatrix::zeros(3 - first, 3 - first);
        for column in first..3 {
            let mut unit = [0.0; 3];
            unit[column] = 1.0;
            let end = self.macro_step(unit, recurrence, macro_step, micro_steps);
            (first..3).for_each(|row| map[(row - first, column - first)] = end[row]);
        }
        map.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    }

    /// Returns natural frequency `ω = √(K/m)`, 1/s, and damping ratio `ζ = c/(2√(K m))` of the actuator on the
    /// mechanics; none of a locked interface.
    pub fn oscillation(&self) -> Option<[f64; 2]> {
        let frequency = (self.stiffness / self.mass).sqrt();
        (frequency > 0.0).then(|| [frequency, 0.5 * self.damping / (frequency * self.mass)])
    }

    /// Advances position x, velocity w and force F by one macro step.
    fn macro_step(&self, [x, w, start]: [f64; 3], recurrence: Recurrence, h: f64, micro_steps: usize) -> [f64; 3] {
        let delta = h / micro_steps as f64;
        let decay = libm::exp(-self.leak * delta);
        let reach = if self.leak > 0.0 { (1.0 - decay) / self.leak } else { delta };
        let bias = -(self.own_stiffness * x + self.own_damping * w) / self.mass;
        let after = |impulse: f64| w + h * bias + impulse / self.mass;
        let held = h * (start - self.damping * w);
        let (mut force, mut model, mut impulse) = (start, w, 0.0);
        for _ in 0..micro_steps {
            let lambda = force - self.damping * model;
            impulse += delta * lambda;
            model = match recurrence {
                Recurrence::Model { mass_ratio } => model + delta * (bias + lambda / (mass_ratio * self.mass)),
                Recurrence::MechanicsFirst => after(held),
                _ => w,
            };
            force = decay * force - self.stiffness * reach * model;
        }
        let w = after(match recurrence {
            Recurrence::HeldByBoth | Recurrence::MechanicsFirst => held,
            Recurrence::MeanReturned | Recurrence::Model { .. } => impulse,
            Recurrence::EndReturned => h * (force - self.damping * w),
        });
        [x + h * w, w, force]
    }
}

/// Predicts how much a run grows per macro step, and by which linear coupling, from mass and actuator at its start with
/// the contacts that are closed there. A mechanics is taken to have no springs and dampers of its own. None: there is
/// no such map of its scheme, or of its sides; or the case is linear, and its spectral radius is probed instead.
///
/// # Errors
/// What fails in building a side, or in its numerics at its start; one that does not offer what is asked, or says that
/// it cannot, has no such map.
pub fn predicted_growth(spec: &RunSpec) -> Result<Option<(f64, LinearCoupling)>> {
    let Some(recurrence) = recurrence(spec).filter(|_| spec.case.linear_state.is_empty()) else { return Ok(None) };
    let micro_steps = division(spec.macro_step, spec.micro_step);
    let growth = |coupling: LinearCoupling| (coupling.growth(recurrence, spec.macro_step, micro_steps), coupling);
    Ok(linear_coupling(spec)?.map(growth))
}

/// Returns the [oscillation](LinearCoupling::oscillation) of a run at its start, with the contacts that are closed
/// there; none where the sides do not tell.
///
/// # Errors
/// Those of [`predicted_growth`].
pub fn interface_oscillation(spec: &RunSpec) -> Result<Option<[f64; 2]>> {
    Ok(linear_coupling(spec)?.and_then(|coupling| coupling.oscillation()))
}

/// The linear coupling at the start of a run; none where a side does not offer what is asked, or says that it cannot.
fn linear_coupling(spec: &RunSpec) -> Result<Option<LinearCoupling>> {
    let mut system = spec.build()?;
    match linearise(system.sides.lend(), spec.macro_step).map_err(Failure::into_cause) {
        Err(Cause::NotOffered { .. } | Cause::NotCopied | Cause::Reported { .. }) => Ok(None),
        found => found.map_err(|cause| Error::Incompatible(cause.to_string())),
    }
}

fn recurrence(spec: &RunSpec) -> Option<Recurrence> {
    const ACTUATOR_FIRST: Sequence = Sequence::GaussSeidel { first: Side::Actuator };
    // The map is that of samples in time, steps as they are asked for, and a mass that stays as it is.
    let other = spec.delivery.is_some() || spec.step_control.is_some() || spec.mass_learning.is_some();
    if other || spec.actuator_integrator != ActuatorIntegrator::Euler {
        return None;
    }
    // With contacts believed open or closed the effective mass is another one, which is not known before the run.
    let belief = spec.belief.clone().unwrap_or_default();
    if belief != (Belief { mass: belief.mass, friction: belief.friction, ..Belief::default() }) {
        return None;
    }
    match (&*spec.scheme.name, spec.sequence, spec.force_return) {
        ("zero-order-hold", Sequence::Jacobi, ForceReturn::Held) => Some(Recurrence::HeldByBoth),
        ("zero-order-hold", Sequence::GaussSeidel { first: Side::Mechanics }, _) => Some(Recurrence::MechanicsFirst),
        ("zero-order-hold", ACTUATOR_FIRST, ForceReturn::Mean | ForceReturn::Profile) => Some(Recurrence::MeanReturned),
        ("zero-order-hold", ACTUATOR_FIRST, ForceReturn::End) => Some(Recurrence::EndReturned),
        (name, ACTUATOR_FIRST, ForceReturn::Mean | ForceReturn::Profile) if name.starts_with("rim-") => {
            Some(Recurrence::Model { mass_ratio: belief.mass })
        }
        _ => None,
    }
}

/// Linearises both sides at the start of a run of this macro step (s), where they have one interface row and the
/// actuator remembers its own deflection.
fn linearise(sides: Sides<'_>, macro_step: f64) -> std::result::Result<Option<LinearCoupling>, Failure> {
    let ports = sides.ports();
    if (ports.actuator.outputs.len(), ports.actuator.inputs.len()) != (1, 2) {
        return Ok(None);
    }
    let Some(mut model) = sides.mechanics.capabilities().empty_interface_model() else { return Ok(None) };
    if !sides.mechanics.capabilities().interface_model(macro_step, &mut model)? {
        return Ok(None);
    }
    let (mut closed, mut condensed) = (Vec::new(), Condensation::of(&model));
    model.closed_contacts(&mut closed);
    condense(&model, &closed, &mut condensed);

    let (mut u, mut rates) = ([0.0; 2], OutputRates::zeros(1, 2));
    sides.mechanics.outputs(&[0.0], &mut u)?;
    if !sides.actuator.capabilities().output_rates(0.0, &u, &mut rates)? || rates.feedthrough[0] != 0.0 {
        return Ok(None);
    }
    let coupling = LinearCoupling {
        mass: condensed.effective_mass,
        own_stiffness: 0.0,
        own_damping: 0.0,
        stiffness: -rates.rate_gain[1],
        damping: -rates.feedthrough[1],
        leak: 0.0,
    };
    // The leak: how the rate of the force follows the force, on a copy that is pushed a little. Without a copy there is
    // none, which is on the safe side.
    let Ok(mut pushed) = sides.actuator.try_clone() else { return Ok(Some(coupling)) };
    let (mut forces, rate) = ([[0.0; 1]; 2], rates.rate[0]);
    pushed.outputs(&u, &mut forces[0])?;
    pushed.step(0.0, &[u[0], u[1] + PUSH / PUSHED_FOR], PUSHED_FOR)?;
    pushed.outputs(&u, &mut forces[1])?;
    pushed.capabilities().output_rates(0.0, &u, &mut rates)?;
    let [[before], [after]] = forces;
    let leak = (rate - rates.rate[0]) / (after - before);
    Ok(Some(LinearCoupling { leak: if leak.is_finite() { leak.max(0.0) } else { 0.0 }, ..coupling }))
}

/// By how far an actuator is pushed to find its leak, m, and for how long, s: far above the rounding of a length of a
/// metre, far below one that would bend a curve.
const PUSH: f64 = 1e-7;
const PUSHED_FOR: f64 = 1e-4;

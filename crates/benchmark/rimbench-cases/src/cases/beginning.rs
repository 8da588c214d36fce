//! Where two sides begin: the forces under which the mechanics is where the actuator answers with these forces.
//!
//! ```text
//! x = M(λ)   motion that the mechanics puts out under forces λ, before its first step
//! A(x)       forces that the actuator puts out there
//! r(λ) = A(M(λ)) − λ = 0
//! ```
//! Where the motion does not follow the forces, as that of most mechanics, one exchange says all. Else r is solved for
//! by Newton's method, with ∂r/∂λ from differences that shrink with r, and steps that are halved until r shrinks.

use super::case::CoupledSystem;
use rimbench_core::cosim::{PerSide, Subsystem, subsystem_methods};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::linear_algebra::Lu;

/// Steps of Newton's method, far beyond what a smooth residual takes.
const MOST_STEPS: usize = 50;
/// How often a step is halved.
const MOST_HALVINGS: usize = 20;
/// Share of the forces below which a residual is round-off, and share of their scale below which it shrinks by a full
/// step or not at all.
const ROUND_OFF: [f64; 2] = [1e-16, 1e-12];
/// Share of it up to which both sides agree: some know what they begin with to so many digits only.
const AGREED: f64 = 1e-6;
/// How many times the scale forces may be: beyond, what both agree within is round-off of them.
const MOST: f64 = 1e8;
/// Least change of a force by which it is seen what it does, of the scale.
const LEAST_CHANGE: f64 = 1e-6;

/// What both sides say of one and the same beginning.
#[derive(Debug, Clone, PartialEq)]
pub struct Beginning {
    /// Forces that the mechanics has, N.
    pub force: Vec<f64>,
    /// What it puts out then.
    pub motion: Vec<f64>,
    /// Forces that the actuator answers to that, N.
    pub told: Vec<f64>,
    /// Whether the motion follows the forces.
    pub follows: bool,
}

/// Why there is no beginning.
#[derive(Debug, Clone, PartialEq)]
pub enum NoBeginning<E> {
    /// A side failed.
    Failed(E),
    /// The nearest that was found, with the row in which it does not agree, and within what it would, N.
    Apart(Beginning, usize, f64),
}

impl Beginning {
    /// The largest `|r|` with its row; infinite where it is no number.
    fn residual(&self) -> (f64, usize) {
        let apart = self.force.iter().zip(&self.told).map(|(force, told)| (told - force).abs());
        let apart = apart.map(|apart| if apart.is_nan() { f64::INFINITY } else { apart });
        apart.zip(0..).fold((0.0, 0), |most, one| if one.0 > most.0 { one } else { most })
    }

    fn scale(&self) -> f64 {
        let sizes = self.force.iter().chain(&self.told).map(|force| force.abs());
        sizes.filter(|size| size.is_finite()).fold(0.0, f64::max)
    }

    /// Whether both sides agree, for forces of this scale (N); none: that of the forces themselves.
    pub fn agrees(&self, scale: Option<f64>) -> bool {
        self.residual().0 <= AGREED * scale.unwrap_or(0.0).max(self.scale())
    }
}

/// Finds where two sides begin that exchange so many forces and `outputs`. `exchange` gives the mechanics forces, and
/// writes what it puts out and what the actuator answers to that. Both agree within 10⁻⁶ of `scale` (N), or of what the
/// actuator answers where no force acts, whichever is larger.
///
/// # Errors
/// [`NoBeginning`]: what `exchange` says, or how far apart the sides remain.
pub fn beginning<E>(
    forces: usize,
    outputs: usize,
    scale: Option<f64>,
    mut exchange: impl FnMut(&[f64], &mut [f64], &mut [f64]) -> Result<(), E>,
) -> Result<Beginning, NoBeginning<E>> {
    let m = forces;
    let mut exchanged = |force: Vec<f64>| {
        let (mut motion, mut told) = (vec![0.0; outputs], vec![0.0; m]);
        exchange(&force, &mut motion, &mut told).map_err(NoBeginning::Failed)?;
        Ok(Beginning { force, motion, told, follows: false })
    };
    let first = exchanged(vec![0.0; m])?;
    if first.told == first.force {
        return Ok(first);
    }
    let mut best = exchanged(first.told.clone())?;
    if best.motion == first.motion {
        return Ok(best);
    }
    let scale = scale.unwrap_or(0.0).max(first.scale());
    if first.residual().0 <= best.residual().0 {
        best = first;
    }
    let (mut jacobian, mut lu) = (vec![0.0; m * m], Lu::new(m));
    'newton: for _ in 0..MOST_STEPS {
        let (size, _) = best.residual();
        if size <= ROUND_OFF[0] * best.scale() || !size.is_finite() {
            break;
        }
        for column in 0..m {
            let apart = best.told[column] - best.force[column];
            let change = if apart.abs() > LEAST_CHANGE * scale { apart } else { LEAST_CHANGE * scale };
            let mut force = best.force.clone();
            force[column] += change;
            let changed = exchanged(force)?;
            for row in 0..m {
                let answer = (changed.told[row] - best.told[row]) / change;
                jacobian[row * m + column] = answer - if row == column { 1.0 } else { 0.0 };
            }
        }
        let mut step: Vec<f64> = best.force.iter().zip(&best.told).map(|(force, told)| force - told).collect();
        if !lu.solve(&mut jacobian, &mut step) {
            break;
        }
        let most = if size <= ROUND_OFF[1] * scale { 0 } else { MOST_HALVINGS };
        for halved in 0..=most {
            let share = 0.5_f64.powi(halved as i32);
            let next = exchanged(best.force.iter().zip(&step).map(|(force, step)| force + share * step).collect())?;
            if next.residual().0 < size {
                best = next;
                continue 'newton;
            }
        }
        break;
    }
    let (apart, row) = best.residual();
    // The distance between both decides, not how the search ended.
    if apart <= AGREED * scale && best.scale() <= MOST * scale {
        Ok(Beginning { follows: true, ..best })
    } else {
        Err(NoBeginning::Apart(best, row, AGREED * scale))
    }
}

/// Says in words that two sides do not agree, with both numbers and what they are of: the position and the force that
/// the mechanics puts out and takes, and the force that the actuator puts out.
pub fn apart_in_words(at: &Beginning, row: usize, within: f64, [position, taken, told]: [&str; 3]) -> String {
    let (force, place, answer) = (at.force[row], at.motion[row], at.told[row]);
    format!(
        "the two sides do not agree on where they begin: under {taken} = {force} N the mechanics is at {position} = {place} m, and there the \
         actuator answers {told} = {answer} N, where {within:.1e} N may lie between both; valid: start values with which both are at rest, \
         or a mechanics whose position does not follow its force before its first step"
    )
}

/// A mechanics whose outputs follow its inputs before its first step, with those that it begins with.
struct Begun {
    inner: Box<dyn Subsystem>,
    /// None after its first step.
    u: Option<Vec<f64>>,
}

impl Subsystem for Begun {
    subsystem_methods!(ports_of_inner capabilities_of_inner counters_of_inner);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.inner.outputs(self.u.as_deref().unwrap_or(u), y)
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.u = None;
        self.inner.step(t, u, h)
    }

    fn try_clone(&self) -> Result<Box<dyn Subsystem>, Failure> {
        Ok(Box::new(Begun { inner: self.inner.try_clone()?, u: self.u.clone() }))
    }
}

impl CoupledSystem {
    /// Lets the mechanics begin where both sides agreed, which matters where its motion follows its forces, although it
    /// does not say so.
    #[must_use]
    pub fn begun(mut self, at: Beginning) -> Self {
        if at.follows && !self.sides.mechanics.ports().direct_feedthrough {
            self.sides.mechanics = Box::new(Begun { inner: self.sides.mechanics, u: Some(at.force) });
        }
        self
    }

    /// Finds where both sides begin by asking them for their outputs, for forces of this scale (N), if one is known.
    ///
    /// # Errors
    /// What a side fails with; how far apart both remain.
    pub fn agreed(mut self, scale: Option<f64>) -> Result<Self> {
        let PerSide { mechanics, actuator } = &mut self.sides;
        let ports = [mechanics.ports().clone(), actuator.ports().clone()];
        let found = beginning(ports[1].outputs.len(), ports[0].outputs.len(), scale, |force, motion, told| {
            mechanics.outputs(force, motion)?;
            actuator.outputs(motion, told)
        });
        match found {
            Ok(at) => Ok(self.begun(at)),
            // No failure here: the run starts from the state as it is, fails, and says why.
            Err(NoBeginning::Failed(_)) => Ok(self),
            Err(NoBeginning::Apart(at, row, within)) => {
                let names = [&ports[0].outputs[row], &ports[0].inputs[row], &ports[1].outputs[row]];
                Err(Error::Incompatible(apart_in_words(&at, row, within, names.map(|port| &*port.name))))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the mechanics is under forces, and what the actuator answers there.
    fn found(
        m: usize,
        motion: impl Fn(&[f64]) -> Vec<f64>,
        told: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Result<Beginning, NoBeginning<()>> {
        beginning(m, m, None, |force, x, y| {
            x.copy_from_slice(&motion(force));
            y.copy_from_slice(&told(x));
            Ok(())
        })
    }

    #[test]
    fn both_sides_begin_where_each_exchange_would_lead_further_away() {
        for stiffer in [0.5, 2.0, 50.0, 1e6] {
            // A mass on a spring of its own, coupled to one that is so much stiffer.
            let at = found(1, |f| vec![0.1 + f[0] / 50.0], |x| vec![-stiffer * 50.0 * x[0]]).unwrap();
            assert!((at.motion[0] * (1.0 + stiffer) / 0.1 - 1.0).abs() < 1e-9, "{stiffer}: {at:?}");
            assert!(at.follows);
        }
        // Rows that pull at each other, and a spring that hardens.
        let at = found(
            2,
            |f| vec![0.1 + (f[0] + 0.5 * f[1]) / 50.0, (0.5 * f[0] + f[1]) / 50.0],
            |x| x.iter().map(|x| -100.0 * x - 1e4 * x.powi(3)).collect(),
        )
        .unwrap();
        assert!(at.residual().0 < 1e-9, "{at:?}");
    }

    #[test]
    fn a_motion_that_does_not_follow_forces_is_found_by_one_exchange() {
        let mut count = 0;
        let at = beginning(1, 1, None, |_, x, y| {
            count += 1;
            (x[0], y[0]) = (0.1, -10.0);
            Ok::<_, ()>(())
        });
        assert_eq!(at, Ok(Beginning { force: vec![-10.0], motion: vec![0.1], told: vec![-10.0], follows: false }));
        assert_eq!(count, 2);
    }

    #[test]
    fn sides_that_agree_nowhere_are_told_apart_with_both_numbers() {
        // The one pushes by 1 N more than the other has, wherever that is.
        let Err(NoBeginning::Apart(at, row, within)) = found(1, |f| vec![f[0]], |x| vec![x[0] + 1.0]) else { panic!() };
        let words = apart_in_words(&at, row, within, ["x", "f", "g"]);
        for part in ["f = 0 N", "x = 0 m", "g = 1 N"] {
            assert!(words.contains(part), "{words}");
        }
        assert!(found(1, |_| vec![f64::NAN], |x| vec![x[0]]).is_err());
    }
}

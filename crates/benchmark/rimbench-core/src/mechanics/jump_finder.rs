//! Looks ahead for the kinks of a model's geometry.

use super::mechanical_model::{MechanicalModel, ModelSize};
use crate::interface_model::{AccelerationJumps, Rows};

/// How far from a kink, in the switch's own unit, its two sides are looked at: well above the round-off of a coordinate
/// of a metre, and a curvature of 100/m is resolved to a millionth.
const ASIDE: f64 = 1e-8;

/// Room to evaluate the rows of a model where it is not yet.
#[derive(Debug, Clone)]
pub(super) struct JumpFinder {
    switches: Vec<[f64; 2]>,
    q: Vec<f64>,
    rows: [Rows; 3],
}

impl JumpFinder {
    /// Makes room, if the model has switches.
    pub(super) fn of<M: MechanicalModel>(model: &M) -> Option<Box<Self>> {
        let ModelSize { velocities: n, unilateral, tangential, interface, switches, .. } = model.size();
        (switches > 0).then(|| {
            Box::new(JumpFinder {
                switches: vec![[0.0; 2]; switches],
                q: model.initial_state().0,
                rows: [unilateral, tangential, interface].map(|count| Rows::zeros(count, n)),
            })
        })
    }

    /// Adds to `kinks` those that the motion from the state `(q, v)` comes to, as [`AccelerationJumps`] says.
    /// Afterwards the model knows the state again.
    pub(super) fn find<M: MechanicalModel>(
        &mut self,
        model: &mut M,
        (q, v): (&[f64], &[f64]),
        acceleration_jumps: &mut AccelerationJumps,
    ) {
        model.switch_values(q, v, &mut self.switches);
        let mut looked = false;
        for switch in 0..self.switches.len() {
            let [value, rate] = self.switches[switch];
            if value * rate >= 0.0 {
                continue;
            }
            let (time, aside) = (-value / rate, (ASIDE / rate).abs());
            let jumps = acceleration_jumps.add(time);
            for (time, sign) in [(time - aside, -1.0), (time + aside, 1.0)] {
                self.q.copy_from_slice(q);
                model.advance_positions(&mut self.q, v, time);
                self.evaluate(model, v);
                // Without friction there is no room for the tangential rows.
                let [unilateral, tangential, interface] = &self.rows;
                let with_friction = jumps.len() > unilateral.len() + interface.len();
                let tangential = if with_friction { &tangential.convective[..] } else { &[] };
                let convective = [&unilateral.convective[..], tangential, &interface.convective].into_iter().flatten();
                for (jump, convective) in jumps.iter_mut().zip(convective) {
                    *jump += sign * convective;
                }
            }
            looked = true;
        }
        if looked {
            model.prepare(q, v);
        }
    }

    fn evaluate<M: MechanicalModel>(&mut self, model: &mut M, v: &[f64]) {
        let [unilateral, tangential, interface] = &mut self.rows;
        model.prepare(&self.q, v);
        model.unilateral(&self.q, v, unilateral);
        if !tangential.is_empty() {
            model.tangential(&self.q, v, tangential);
        }
        model.interface(&self.q, v, interface);
    }
}

//! `energy-input-correction`: count the energy that the interface creates or loses, and
//! correct the force so that it comes back.
//!
//! Like `energy-leak-damper`, but signed: what was lost is given back, too.
//!
//! ```text
//! E ← E + received − sent                     as in `created_energy`; E > 0: created
//! f_k = −α E w_k/(H w_kᵀw_k)                  |f_k| ≤ γ |λ_k|,  γ = 0.2;  0 where the interface rests
//! u_λ = λ_k + f_k                             over the macro step
//! ```
//! `received` grows by f·w·H = −αE over the macro step, as far as the velocity stays what it was.
//! **Needs** a force–displacement coupling and force return `held`: with the actuator first and its mean returned the force is not
//! the scheme's to change. **Order** 1 in H, that of the hold, up to a
//! logarithm. **Known weakness**: acts late, on moving
//! interfaces only; what an impact left in the pool is paid back over many steps in the wrong place; holds energy, not phase; books
//! the energy of the interface only.
//! **Source**: after the idea of Rodríguez, Rodríguez, Sputh, Pastorino, Naya, González, Multibody Syst. Dyn. 55 (2022) (energy
//! artefacts found from exchanged variables, removed by correcting inputs). Formula not read, derived here; nothing is said about
//! the authors' method.

use super::energy_correcting_hold::{Correction, EnergyCorrectingHold};
use super::entry::{Gain, SchemeEntry};
use super::line_style::{Dash, LineStyle, Marker};
use super::need::Need;

/// γ, most correction per coupling force (ours).
const BOUND: f64 = 0.2;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        needs: vec![Need::ForceDisplacement, Need::HeldReturn],
        gain: Some(Gain {
            about: "α, the share of the energy that is corrected per macro step".into(),
            default: 1.0,
            range: [0.0, 2.0],
        }),
        line: LineStyle::new([0xA7, 0x8F, 0x3D], Dash::Dotted, Marker::Plus),
        ..SchemeEntry::new(
            "energy-input-correction",
            "Hold; energy created or lost at the interface comes back through a bounded correction of the force",
            |construction| Ok(Box::new(hold(construction.interface(), construction.gain))),
        )
    }
}

fn hold(rows: usize, share: f64) -> EnergyCorrectingHold {
    EnergyCorrectingHold::new(rows, Correction { share, bound: BOUND, gives_back: true })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schemes::energy_correcting_hold::macro_step;

    #[test]
    fn a_joule_created_is_taken_out_and_a_joule_lost_is_given_back() {
        // 4 N over a mean of 1.25 m/s is received, over 1 m/s sent: 1 J from nowhere, wanted −1/1.5 N, the bound is 0.8 N.
        let mut scheme = hold(1, 1.0);
        assert_eq!(macro_step(&mut scheme, 0, 1.0, 4.0), 4.0);
        approx::assert_relative_eq!(macro_step(&mut scheme, 1, 1.5, 4.0), 4.0 - 1.0 / 1.5, epsilon = 1e-14);
        let mut scheme = hold(1, 1.0);
        macro_step(&mut scheme, 0, 1.5, 4.0);
        // Received over 1.25, sent over 1.5: 1 J lost, wanted +1 N, the bound is 0.8 N.
        approx::assert_relative_eq!(macro_step(&mut scheme, 1, 1.0, 4.0), 4.8, epsilon = 1e-14);
    }

    #[test]
    fn an_interface_at_rest_gets_no_correction() {
        let mut scheme = hold(1, 1.0);
        macro_step(&mut scheme, 0, 1.0, 4.0);
        assert_eq!(macro_step(&mut scheme, 1, 0.0, 4.0), 4.0);
    }
}

//! The own scale of each case: the largest position, velocity and force of its interface at the defaults, which a test compares with its
//! reference.

use super::case::Scale;

/// Name, m, m/s, N.
const SCALES: [(&str, f64, f64, f64); 34] = [
    ("wedge-box", 3.2, 0.28, 990.0),
    ("hydraulic-crane", 0.6, 0.033, 11e3),
    ("linear-oscillator", 4.2, 120.0, 1200.0),
    ("quarter-car", 0.14, 4.5, 5300.0),
    ("precice-oscillator", 0.77, 13.0, 160.0),
    ("crane-set-down", 0.52, 0.02, 10e3),
    ("half-car", 0.54, 1.6, 5100.0),
    ("gripper", 0.64, 0.061, 2900.0),
    ("lift-table", 0.84, 0.12, 22e3),
    ("disc-row", 1.6, 0.12, 10e3),
    ("disc-pile", 1.5, 0.11, 10e3),
    ("packed-box", 1.5, 0.064, 3100.0),
    ("falling-chain", 2.2e-3, 0.1, 70.0),
    ("crane-heap", 0.55, 0.066, 11e3),
    ("random-body", 1.2e-3, 0.2, 76.0),
    ("bouncing-ball", 1.0, 4.2, 2.9),
    ("elastic-bar", 1.0, 0.16, 85.0),
    ("impact-oscillator", 0.28, 3.4, 27.0),
    ("cradle", 0.1, 0.52, 0.2),
    ("slider-between-stops", 0.1, 2.3, 55.0),
    ("rocking-block", 1.9, 0.1, 4100.0),
    ("beam-on-stops", 0.044, 0.46, 84.0),
    ("n-wedge-box", 3.2, 0.28, 990.0),
    ("wedge-box-two-ledges", 3.3, 0.28, 1100.0),
    ("wedge-box-reversal", 2.7, 0.28, 1100.0),
    ("wedge-box-friction", 2.6, 0.28, 1800.0),
    ("towed-block", 0.35, 0.24, 5.3),
    ("rocking-block-friction", 1.8, 0.4, 39.0),
    ("crane-drag", 0.53, 8.5e-3, 8600.0),
    ("slider-crank", 2.3, 24.0, 340.0),
    ("woodpecker", 4.2e-3, 0.18, 0.24),
    ("tripod", 1.8, 0.3, 1600.0),
    ("four-legs", 1.8, 0.3, 1600.0),
    ("wedge-box-space", 3.2, 0.28, 1800.0),
];

/// Finds the scale of a built-in case.
pub(super) fn scale_of(case: &str) -> Option<Scale> {
    let (_, position_m, velocity_m_s, force_n) = *SCALES.iter().find(|(name, ..)| *name == case)?;
    Some(Scale { position_m, velocity_m_s, force_n })
}

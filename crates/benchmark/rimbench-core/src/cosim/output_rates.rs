//! Directional derivatives of a subsystem's outputs.

/// How the outputs of a subsystem move, to first order in its inputs; what directional derivatives (FMI 3.0) provide.
///
/// ```text
/// ẏ = r + D u̇        r = ∂y/∂x ẋ(x, u) + ∂y/∂t,   D = ∂y/∂u,   R = ∂r/∂u
/// ```
/// # Shapes and units
/// `rate` p (output per s); `feedthrough` p×n, row-major (output per input); `rate_gain` p×n (output per input and s),
/// for p outputs and n inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputRates {
    /// `r`, with the input held.
    pub rate: Vec<f64>,
    /// `D`.
    pub feedthrough: Vec<f64>,
    /// `R`.
    pub rate_gain: Vec<f64>,
}

impl OutputRates {
    /// Zeros for `outputs` outputs and `inputs` inputs.
    pub fn zeros(outputs: usize, inputs: usize) -> Self {
        OutputRates {
            rate: vec![0.0; outputs],
            feedthrough: vec![0.0; outputs * inputs],
            rate_gain: vec![0.0; outputs * inputs],
        }
    }

    /// Advances outputs by `length` (s) with the input held: `y += length · r`.
    #[inline]
    pub(crate) fn advance(&self, length: f64, outputs: &mut [f64]) {
        for (output, rate) in outputs.iter_mut().zip(&self.rate) {
            *output += length * rate;
        }
    }
}

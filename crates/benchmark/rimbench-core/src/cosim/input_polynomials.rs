//! Polynomials of a subsystem's inputs within one micro step.

/// Coefficients of one input: powers of time from 0 to 3.
pub type Cubic = [f64; 4];

/// Room for the inputs within the next micro step as polynomials of the time since its start, for a subsystem that
/// integrates them exactly. Others receive the mean, as the `u` of [`Subsystem::step`](super::Subsystem::step).
///
/// ```text
/// u_i(t_j + τ) = Σ_p c_ip τ^p,   p = 0 … 3,   0 ≤ τ ≤ δ
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct InputPolynomials {
    rows: Vec<Cubic>,
    given: bool,
}

impl InputPolynomials {
    /// Makes room for a number of inputs; nothing is given yet.
    pub fn new(inputs: usize) -> Self {
        InputPolynomials { rows: vec![[0.0; 4]; inputs], given: false }
    }

    /// Lets `write` fill in the coefficients of the next micro step; it says whether it did, and so does this.
    #[inline]
    pub fn give(&mut self, write: impl FnOnce(&mut [Cubic]) -> bool) -> bool {
        self.given = write(&mut self.rows);
        self.given
    }

    /// Takes the coefficients given since the last call; none if the inputs are to be held.
    #[inline]
    pub fn take(&mut self) -> Option<&[Cubic]> {
        std::mem::take(&mut self.given).then_some(&self.rows[..])
    }
}

//! The exact step of a small linear system with constant right-hand side.

/// Largest sum of magnitudes in a row of `S h` for which the series is summed; longer steps are halved, then squared.
const SUMMED: f64 = 0.5;
/// Terms of the series: 0.5^15/15! is below round-off.
const TERMS: u32 = 15;

/// `y' = S y + c` over steps of one length, by the matrix exponential with scaling and squaring.
///
/// ```text
/// [y; 1]⁺ = exp(h [S c; 0 0]) [y; 1]
/// ```
#[derive(Debug, Clone)]
pub(super) struct ExponentialStep {
    n: usize,
    /// The exponential of the extended system, row-major, (n+1)×(n+1); and room to make it.
    exponential: Vec<f64>,
    scaled: Vec<f64>,
    term: Vec<f64>,
    product: Vec<f64>,
    next: Vec<f64>,
}

impl ExponentialStep {
    /// Makes room for systems of size `n`.
    pub(super) fn new(n: usize) -> Self {
        let square = || vec![0.0; (n + 1) * (n + 1)];
        ExponentialStep {
            n,
            exponential: square(),
            scaled: square(),
            term: square(),
            product: square(),
            next: vec![0.0; n],
        }
    }

    /// Makes the exponential for steps of `h` (s). `generator` is S, row-major; `constant` c.
    pub(super) fn prepare(&mut self, generator: &[f64], constant: &[f64], h: f64) {
        let (n, width) = (self.n, self.n + 1);
        let rows = generator.chunks(n).zip(constant);
        let size = rows.map(|(row, c)| h * (row.iter().map(|s| s.abs()).sum::<f64>() + c.abs())).fold(0.0, f64::max);
        // What is not finite, or so stiff that it means nothing, is not squared for ever.
        let halvings = if size > SUMMED { libm::log2(size / SUMMED).ceil().clamp(0.0, 60.0) as i32 } else { 0 };
        let scale = h * 0.5_f64.powi(halvings);
        for i in 0..n {
            for j in 0..n {
                self.scaled[i * width + j] = scale * generator[i * n + j];
            }
            self.scaled[i * width + n] = scale * constant[i];
        }
        self.scaled[n * width..].fill(0.0);
        identity(&mut self.term, width);
        identity(&mut self.exponential, width);
        for order in 1..=TERMS {
            multiply(&self.term, &self.scaled, &mut self.product, width);
            for ((term, product), sum) in self.term.iter_mut().zip(&self.product).zip(&mut self.exponential) {
                *term = product / f64::from(order);
                *sum += *term;
            }
        }
        for _ in 0..halvings {
            multiply(&self.exponential, &self.exponential, &mut self.product, width);
            std::mem::swap(&mut self.exponential, &mut self.product);
        }
    }

    /// Takes one step.
    pub(super) fn advance(&mut self, y: &mut [f64]) {
        for (next, row) in self.next.iter_mut().zip(self.exponential.chunks(self.n + 1)) {
            *next = row[self.n] + row.iter().zip(&*y).map(|(e, y)| e * y).sum::<f64>();
        }
        y.copy_from_slice(&self.next);
    }

    /// Writes `S y + c`.
    pub(super) fn rate(&self, generator: &[f64], constant: &[f64], y: &[f64], rate: &mut [f64]) {
        for ((rate, row), c) in rate.iter_mut().zip(generator.chunks(self.n)).zip(constant) {
            *rate = c + row.iter().zip(y).map(|(s, y)| s * y).sum::<f64>();
        }
    }
}

fn identity(matrix: &mut [f64], width: usize) {
    matrix.fill(0.0);
    matrix.iter_mut().step_by(width + 1).for_each(|entry| *entry = 1.0);
}

fn multiply(a: &[f64], b: &[f64], product: &mut [f64], width: usize) {
    for (i, row) in product.chunks_mut(width).enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = (0..width).map(|l| a[i * width + l] * b[l * width + j]).sum();
        }
    }
}

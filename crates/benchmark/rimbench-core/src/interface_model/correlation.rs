//! How strongly the rows of an interface feel each other.

/// How the rows of an interface feel each other, at its largest since the start: `C = D^(−½) H_ii D^(−½)` with the
/// diagonal `D` of `H_ii`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InterfaceCorrelation {
    /// Largest eigenvalue λ of `C`: from 1, for rows that do not feel each other, to their number.
    pub lambda: f64,
    /// Largest magnitude of `C_ij` of two rows.
    pub largest: f64,
}

/// Correlations of the rows of the interface by its mobility H, the worst so far, and the largest eigenvalue λ by power
/// iteration.
#[derive(Debug, Clone)]
pub(crate) struct Correlation {
    entries: Vec<f64>,
    vector: Vec<f64>,
    image: Vec<f64>,
    pub(crate) found: InterfaceCorrelation,
    /// λ of the mobility that was looked at last.
    pub(crate) lambda: f64,
}

impl Correlation {
    /// Steps of the iteration per communication point, which starts where it ended at the last one.
    const ITERATIONS: usize = 20;

    pub(crate) fn new(n: usize) -> Self {
        let room = || vec![0.0; n];
        Correlation {
            entries: vec![0.0; n * n],
            vector: room(),
            image: room(),
            found: <_>::default(),
            lambda: f64::NAN,
        }
    }

    /// `Σ_j |C_ij|` over row `i` itself and those that `is_other` names; 1 of a row that does not move.
    pub(crate) fn row_sum(&self, i: usize, is_other: impl Fn(usize) -> bool) -> f64 {
        let n = self.vector.len();
        let row = self.entries[i * n..(i + 1) * n].iter().enumerate();
        row.filter(|(j, _)| *j == i || is_other(*j)).map(|(_, c)| c.abs()).sum::<f64>().max(1.0)
    }

    /// Takes the mobility `h` of two rows.
    pub(crate) fn set(&mut self, h: impl Fn(usize, usize) -> f64) {
        let n = self.vector.len();
        for (at, entry) in self.entries.iter_mut().enumerate() {
            let (i, j) = (at / n, at % n);
            let scale = (h(i, i) * h(j, j)).sqrt();
            *entry = if scale > 0.0 { h(i, j) / scale } else { f64::from(i == j) };
            if j < i {
                self.found.largest = self.found.largest.max(entry.abs());
            }
        }
    }

    /// Takes the mobility `h` of two rows, and looks for its λ.
    pub(crate) fn look_at(&mut self, h: impl Fn(usize, usize) -> f64) {
        self.set(h);
        let n = self.vector.len();
        let Correlation { entries, vector, image, found, lambda } = self;
        *lambda = 0.0;
        if vector[0] == 0.0 {
            // Not the vector of a symmetric arrangement, which may have no part in the largest.
            vector.iter_mut().enumerate().for_each(|(i, x)| *x = 1.0 / (1.0 + i as f64));
        }
        for _ in 0..Self::ITERATIONS {
            let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|x| *x /= length);
            for (y, row) in image.iter_mut().zip(entries.chunks_exact(n)) {
                *y = row.iter().zip(&*vector).map(|(c, x)| c * x).sum();
            }
            let rayleigh = vector.iter().zip(&*image).map(|(x, y)| x * y).sum::<f64>();
            *lambda = lambda.max(rayleigh);
            vector.copy_from_slice(image);
        }
        found.lambda = found.lambda.max(*lambda);
    }
}

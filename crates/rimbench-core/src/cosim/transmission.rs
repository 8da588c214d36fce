//! The actuator's outputs over a macro step, as the mechanics receives them.

/// The actuator's outputs over one macro step, handed to the mechanics as the force return says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Transmission {
    width: usize,
    count: usize,
    /// Row j: output at the start of micro step j.
    outputs: Vec<f64>,
}

impl Transmission {
    pub(crate) fn new(width: usize, micro_steps: usize) -> Self {
        Transmission { width, count: 0, outputs: vec![0.0; width * micro_steps] }
    }

    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes over another's outputs in the room there is.
    pub(crate) fn copy_from(&mut self, other: &Transmission) {
        (self.width, self.count) = (other.width, other.count);
        self.outputs.clone_from(&other.outputs);
    }

    #[inline]
    pub(crate) fn push(&mut self, output: &[f64]) {
        let at = self.count * self.width;
        self.outputs[at..at + self.width].copy_from_slice(output);
        self.count += 1;
    }

    /// Output in one micro step.
    pub(crate) fn at(&self, micro_step: usize) -> &[f64] {
        &self.outputs[micro_step * self.width..(micro_step + 1) * self.width]
    }

    /// Mean output over part `index` of `parts` equal parts of the macro step; micro steps that straddle a border
    /// count with the share that lies inside.
    pub(crate) fn mean_over(&self, index: usize, parts: usize, mean: &mut [f64]) {
        mean.fill(0.0);
        // In units of 1/(count·parts) of the macro step all borders are integers.
        let (from, to) = (index * self.count, (index + 1) * self.count);
        for j in from / parts..self.count.min(to.div_ceil(parts)) {
            let overlap = to.min((j + 1) * parts) - from.max(j * parts);
            let weight = overlap as f64 / self.count as f64;
            for (sum, y) in mean.iter_mut().zip(&self.outputs[j * self.width..(j + 1) * self.width]) {
                *sum += weight * y;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_share_out_straddling_micro_steps_and_keep_the_impulse() {
        let mut transmission = Transmission::new(1, 3);
        for force in [1.0, 2.0, 6.0] {
            transmission.push(&[force]);
        }
        let mean = |index, parts| {
            let mut out = [0.0];
            transmission.mean_over(index, parts, &mut out);
            out[0]
        };
        approx::assert_relative_eq!(mean(0, 1), 3.0, epsilon = 1e-15);
        // Halves: (1 + ½·2)/1.5 and (½·2 + 6)/1.5.
        approx::assert_relative_eq!(mean(0, 2), 2.0 / 1.5, epsilon = 1e-15);
        approx::assert_relative_eq!(mean(1, 2), 7.0 / 1.5, epsilon = 1e-15);
        for parts in 1..8 {
            let total: f64 = (0..parts).map(|index| mean(index, parts)).sum();
            approx::assert_relative_eq!(total / parts as f64, 3.0, epsilon = 1e-14);
        }
    }

    proptest::proptest! {
        #[test]
        fn the_parts_of_a_macro_step_hand_over_its_impulse_whatever_the_outputs_and_their_number(
            outputs in proptest::collection::vec([-1e4f64..1e4, -1e4f64..1e4], 1..60),
            parts in 1usize..80,
        ) {
            let mut transmission = Transmission::new(2, outputs.len());
            outputs.iter().for_each(|output| transmission.push(output));
            let (mut mean, mut total) = ([0.0; 2], [0.0; 2]);
            for index in 0..parts {
                transmission.mean_over(index, parts, &mut mean);
                for row in 0..2 {
                    total[row] += mean[row] / parts as f64;
                    // A mean lies among what it is made of.
                    let least = outputs.iter().map(|output| output[row]).fold(f64::INFINITY, f64::min);
                    let greatest = outputs.iter().map(|output| output[row]).fold(f64::NEG_INFINITY, f64::max);
                    proptest::prop_assert!(mean[row] >= least - 1e-9 && mean[row] <= greatest + 1e-9);
                }
            }
            for row in 0..2 {
                let exact = outputs.iter().map(|output| output[row]).sum::<f64>() / outputs.len() as f64;
                // Each of at most 140 shares is rounded a few times: 1e4 * 140 * 1e-16 * a few.
                proptest::prop_assert!((total[row] - exact).abs() < 1e-9, "{} against {exact}", total[row]);
            }
        }
    }
}

//! The actuator's outputs over a macro step, as the mechanics receives them.

/// Numbers that are held over each of so many equal parts of a macro step, as the means over any others: the actuator's outputs, handed to
/// the mechanics as the force return says.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputHistory {
    width: usize,
    count: usize,
    /// Row j: output at the start of micro step j.
    outputs: Vec<f64>,
}

impl OutputHistory {
    /// Makes room for `micro_steps` rows of `width` numbers.
    pub fn new(width: usize, micro_steps: usize) -> Self {
        OutputHistory { width, count: 0, outputs: vec![0.0; width * micro_steps] }
    }

    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes over another's outputs in the room there is.
    pub(crate) fn copy_from(&mut self, other: &OutputHistory) {
        (self.width, self.count) = (other.width, other.count);
        self.outputs.clone_from(&other.outputs);
    }

    /// Adds the row of the next part, for which there must be room.
    #[inline]
    pub fn push(&mut self, output: &[f64]) {
        let at = self.count * self.width;
        self.outputs[at..at + self.width].copy_from_slice(output);
        self.count += 1;
    }

    /// Outputs of all micro steps.
    pub(crate) fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.outputs.chunks_exact(self.width).take(self.count)
    }

    /// Returns the sum `s_n` of one output over the n micro steps, and that of `s_1 … s_n`.
    pub(crate) fn running_sums(&self, output: usize) -> [f64; 2] {
        let add = |[sum, sums]: [f64; 2], y: &f64| [sum + y, sums + (sum + y)];
        match self.width {
            1 => self.outputs[..self.count].iter().fold([0.0; 2], add),
            _ => self.rows().map(|row| &row[output]).fold([0.0; 2], add),
        }
    }

    /// Returns the output in one micro step.
    pub(crate) fn at(&self, micro_step: usize) -> &[f64] {
        &self.outputs[micro_step * self.width..(micro_step + 1) * self.width]
    }

    /// Returns the mean output over part `index` of `parts` equal parts of the macro step; micro steps that straddle a border
    /// count with the share that lies inside.
    pub fn mean_over(&self, index: usize, parts: usize, mean: &mut [f64]) {
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

impl OutputHistory {
    /// Returns the profile of the outputs over part `index` of `parts` equal parts of the macro step, moved so that its mean is `mean`.
    pub(crate) fn profile<'a>(&'a self, index: usize, parts: usize, mean: &'a [f64]) -> ForceProfile<'a> {
        let border = |index: usize| (index * self.count) as f64 / parts as f64;
        ForceProfile { history: self, from: border(index), to: border(index + 1), mean }
    }

    /// Calls `act` with each micro step's output, and from where to where it acts between `from` and `to` (in micro steps).
    fn each_between(&self, from: f64, to: f64, mut act: impl FnMut(&[f64], f64, f64)) {
        let (first, end) = (from as usize, (to.ceil() as usize).min(self.count));
        for (j, output) in self.outputs.chunks_exact(self.width).enumerate().take(end).skip(first) {
            act(output, from.max(j as f64), to.min((j + 1) as f64));
        }
    }
}

/// The profile of the forces over a step of the mechanics.
#[derive(Debug, Clone, Copy)]
pub struct ForceProfile<'a> {
    history: &'a OutputHistory,
    /// Of the step, in micro steps.
    from: f64,
    to: f64,
    mean: &'a [f64],
}

impl ForceProfile<'_> {
    /// Writes the mean force (N) over the share `from` to `to` of the step, and its first moment about the middle of that time.
    ///
    /// ```text
    /// κ = ∫ (x_m − x) F dx        x the share of the step, x_m the middle, κ in N
    /// ```
    /// Over the whole step the mean is that of the step, to the bit; pieces that make up the step hand over its impulse to round-off,
    /// wherever the borders are.
    pub fn over(&self, from: f64, to: f64, mean: &mut [f64], moment: &mut [f64]) {
        let (length, whole) = (self.to - self.from, from <= 0.0 && to >= 1.0);
        let [start, end] = [from, to].map(|share| self.from + share * length);
        let middle = 0.5 * (start + end);
        mean.copy_from_slice(self.mean);
        moment.fill(0.0);
        self.history.each_between(start, end, |output, start_here, end_here| {
            let (time, middle_here) = (end_here - start_here, 0.5 * (start_here + end_here));
            for (i, y) in output.iter().enumerate() {
                moment[i] += (middle - middle_here) * time * y / (length * length);
                if !whole {
                    mean[i] += time * y / (end - start);
                }
            }
        });
        if !whole {
            self.history.each_between(self.from, self.to, |output, start_here, end_here| {
                mean.iter_mut().zip(output).for_each(|(mean, y)| *mean -= (end_here - start_here) * y / length);
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::strategy::Strategy;

    #[test]
    fn means_share_out_straddling_micro_steps_and_keep_the_impulse() {
        let mut history = OutputHistory::new(1, 3);
        for force in [1.0, 2.0, 6.0] {
            history.push(&[force]);
        }
        let mean = |index, parts| {
            let mut out = [0.0];
            history.mean_over(index, parts, &mut out);
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

    #[test]
    fn a_piece_within_a_micro_step_has_its_output_and_a_whole_step_its_mean() {
        let mut history = OutputHistory::new(1, 4);
        [1.0, 2.0, 6.0, 4.0].iter().for_each(|force| history.push(&[*force]));
        // The second half, with an impulse that adds 0.5 N to its mean of 5 N.
        let mean = [5.5];
        let profile = history.profile(1, 2, &mean);
        let over = |from, to| {
            let (mut force, mut moment) = ([0.0], [0.0]);
            profile.over(from, to, &mut force, &mut moment);
            [force[0], moment[0]]
        };
        // ¼ before the middle 6 N act for ½, ¼ behind it 4 N: κ = ½·¼ (6 − 4); within a micro step there is none.
        assert_eq!([over(0.0, 1.0), over(0.0, 0.5), over(0.5, 1.0)], [[5.5, 0.25], [6.5, 0.0], [4.5, 0.0]]);
        assert_eq!(over(0.25, 0.75), [5.5, 0.0625]);
        approx::assert_relative_eq!(over(0.3, 0.3 + 1e-9)[0], 6.5, max_relative = 1e-6);
    }

    proptest::proptest! {
        #[test]
        fn pieces_hand_over_the_impulse_of_the_step_wherever_they_end(
            outputs in proptest::collection::vec([-1e4f64..1e4, -1e4f64..1e4], 1..60),
            mut borders in proptest::collection::vec(0.0f64..1.0, 0..12),
            (parts, index) in (1usize..7).prop_flat_map(|parts| (proptest::strategy::Just(parts), 0..parts)),
            moved in -1e4f64..1e4,
        ) {
            let mut history = OutputHistory::new(2, outputs.len());
            outputs.iter().for_each(|output| history.push(output));
            let mut mean = [0.0; 2];
            history.mean_over(index, parts, &mut mean);
            mean[1] += moved;
            let profile = history.profile(index, parts, &mean);
            borders.extend([0.0, 1.0]);
            borders.sort_by(f64::total_cmp);
            let (mut force, mut moment, mut total) = ([0.0; 2], [0.0; 2], [0.0; 2]);
            for piece in borders.windows(2) {
                // A piece of no length has no mean.
                if piece[1] - piece[0] < 1e-9 {
                    continue;
                }
                profile.over(piece[0], piece[1], &mut force, &mut moment);
                (0..2).for_each(|row| total[row] += (piece[1] - piece[0]) * force[row]);
            }
            for row in 0..2 {
                // Each of at most 13 pieces sums at most 60 shares of up to 3e4 N, rounded a few times: 3e4 * 800 * 1e-16 * a few; what
                // is left out is 13 pieces of 3e4 * 1e-9.
                proptest::prop_assert!((total[row] - mean[row]).abs() < 1e-3, "{} against {}", total[row], mean[row]);
            }
        }

        #[test]
        fn the_parts_of_a_macro_step_hand_over_its_impulse_whatever_the_outputs_and_their_number(
            outputs in proptest::collection::vec([-1e4f64..1e4, -1e4f64..1e4], 1..60),
            parts in 1usize..80,
        ) {
            let mut history = OutputHistory::new(2, outputs.len());
            outputs.iter().for_each(|output| history.push(output));
            let (mut mean, mut total) = ([0.0; 2], [0.0; 2]);
            for index in 0..parts {
                history.mean_over(index, parts, &mut mean);
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

//! The actuator's outputs over a macro step, as the mechanics receives them.

/// Lists the parts, of `others` equal ones, that part `index` of `parts` equal parts of the same macro step overlaps,
/// each with the overlap in units of 1/(parts·others) of the macro step, in which all borders are integers.
#[inline]
pub(crate) fn overlaps(index: usize, parts: usize, others: usize) -> impl Iterator<Item = (usize, usize)> {
    let (from, to) = (index * others, (index + 1) * others);
    (from / parts..others.min(to.div_ceil(parts)))
        .map(move |other| (other, to.min((other + 1) * parts) - from.max(other * parts)))
}

/// Numbers that are held over each of so many equal parts of a macro step, as the means over any others: the actuator's
/// outputs, handed to the mechanics as the force return says.
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
        match *output {
            [output] if self.width == 1 => self.outputs[at] = output,
            _ => self.outputs[at..at + self.width].copy_from_slice(output),
        }
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

    /// Returns the mean output over part `index` of `parts` equal parts of the macro step; micro steps that straddle a
    /// border count with the share that lies inside.
    #[inline]
    pub fn mean_over(&self, index: usize, parts: usize, mean: &mut [f64]) {
        match mean {
            // Each part is a micro step, whose share is 1.
            [mean] if parts == self.count && self.width == 1 => *mean = 0.0 + self.outputs[index],
            mean => self.mean_over_part(index, parts, mean),
        }
    }

    fn mean_over_part(&self, index: usize, parts: usize, mean: &mut [f64]) {
        mean.fill(0.0);
        if parts == 1 {
            let weight = 1.0 / self.count as f64;
            for output in self.outputs.chunks_exact(self.width.max(1)).take(self.count) {
                mean.iter_mut().zip(output).for_each(|(sum, y)| *sum += weight * y);
            }
            return;
        }
        for (j, overlap) in overlaps(index, parts, self.count) {
            let weight = overlap as f64 / self.count as f64;
            for (sum, y) in mean.iter_mut().zip(&self.outputs[j * self.width..(j + 1) * self.width]) {
                *sum += weight * y;
            }
        }
    }
}

impl OutputHistory {
    /// Returns the profile of the outputs over part `index` of `parts` equal parts of the macro step, moved so that its
    /// mean is `mean`.
    pub(crate) fn profile<'a>(&'a self, index: usize, parts: usize, mean: &'a [f64]) -> ForceProfile<'a> {
        let border = |index: usize| (index * self.count) as f64 / parts as f64;
        ForceProfile { history: self, from: border(index), to: border(index + 1), mean }
    }

    /// Calls `act` with each micro step's output, and from where to where it acts between `from` and `to` (in micro
    /// steps).
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
    /// Writes the mean force (N) over the share `from` to `to` of the step, and its first moment about the middle of
    /// that time.
    ///
    /// ```text
    /// κ = ∫ (x_m − x) F dx        x the share of the step, x_m the middle, κ in N
    /// ```
    /// Over the whole step the mean is that of the step, to the bit; pieces that make up the step hand over its impulse
    /// to round-off, wherever the borders are.
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

    /// Outputs, borders of pieces and what is added to a mean, anyhow spread.
    #[test]
    fn pieces_hand_over_the_impulse_of_the_step_wherever_they_end() {
        let anyhow = |k: usize| 0.5 + 0.5 * libm::sin(12.9898 * k as f64 + 78.233 * (k * k) as f64);
        for turn in 0..500 {
            let (count, parts) = (1 + turn % 59, 1 + turn % 7);
            let (index, mut history) = (turn % parts, OutputHistory::new(1, count));
            (0..count).for_each(|k| history.push(&[1e4 * anyhow(turn + 61 * k)]));
            let mut mean = [0.0];
            history.mean_over(index, parts, &mut mean);
            mean[0] += 1e4 * anyhow(turn + 7);
            let profile = history.profile(index, parts, &mean);
            let mut borders: Vec<f64> = (0..turn % 12).map(|k| anyhow(turn + 13 * k)).chain([0.0, 1.0]).collect();
            borders.sort_by(f64::total_cmp);
            let (mut force, mut moment, mut total) = ([0.0], [0.0], 0.0);
            // A piece of no length has no mean.
            for piece in borders.windows(2).filter(|piece| piece[1] - piece[0] > 1e-9) {
                profile.over(piece[0], piece[1], &mut force, &mut moment);
                total += (piece[1] - piece[0]) * force[0];
            }
            // Each of at most 13 pieces sums at most 60 shares of up to 3e4 N, rounded a few times: 3e4 * 800 * 1e-16 *
            // a few; what is left out is 13 pieces of 3e4 * 1e-9.
            assert!((total - mean[0]).abs() < 1e-3, "{turn}: {total} against {}", mean[0]);
        }
    }
}

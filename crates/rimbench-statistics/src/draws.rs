//! Random draws that are the same on every machine.

/// Steele, Lea, Flood: SplitMix64 (2014).
pub(crate) struct Draws(u64);

impl Draws {
    /// Starts a sequence.
    pub(crate) fn from(seed: u64) -> Self {
        Draws(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    /// A whole number below `count`, by multiplication; the bias is below `count / 2⁶⁴`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.bits()) * count as u128) >> 64) as usize
    }

    /// A number in [0, 1): the 53 bits that fit.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-53)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_that_of_the_source() {
        // First outputs for seed 1234567 of the authors' program, as java.util.SplittableRandom has them.
        let mut draws = Draws::from(1_234_567);
        assert_eq!([draws.bits(), draws.bits()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
    }

    #[test]
    fn every_value_is_drawn_about_as_often_as_the_others() {
        let mut counts = [0_u32; 7];
        let mut draws = Draws::from(1);
        (0..70_000).for_each(|_| counts[draws.below(7)] += 1);
        // Five standard deviations of a binomial count: 5 √(70000 · 6/49).
        assert!(counts.iter().all(|count| count.abs_diff(10_000) < 463), "{counts:?}");
    }
}

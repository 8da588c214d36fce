//! Units as texts, and what they are in the base units of the SI.

/// Exponents of kg, m, s and rad.
pub(crate) type Exponents = [i32; 4];

/// Names of the attributes of a base unit in FMI, in the order of [`Exponents`].
pub(crate) const BASE: [&str; 4] = ["kg", "m", "s", "rad"];

/// Reads a unit such as `N·s/m` or `kg·m²`; none if a part of it is not known.
pub(crate) fn exponents(unit: &str) -> Option<Exponents> {
    let mut total = [0; 4];
    for (index, factors) in unit.split('/').enumerate() {
        let sign = if index == 0 { 1 } else { -1 };
        for factor in factors.split('·').filter(|factor| *factor != "1") {
            let (symbol, power) = match factor.char_indices().last()? {
                (at, '²') => (&factor[..at], 2),
                (at, '³') => (&factor[..at], 3),
                _ => (factor, 1),
            };
            let one = match symbol {
                "kg" => [1, 0, 0, 0],
                "m" => [0, 1, 0, 0],
                "s" => [0, 0, 1, 0],
                "rad" => [0, 0, 0, 1],
                "Hz" => [0, 0, -1, 0],
                "N" => [1, 1, -2, 0],
                "Pa" => [1, -1, -2, 0],
                "J" => [1, 2, -2, 0],
                "W" => [1, 2, -3, 0],
                _ => return None,
            };
            total.iter_mut().zip(one).for_each(|(total, one)| *total += sign * power * one);
        }
    }
    Some(total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_in_base_units_and_unknown_ones_are_not() {
        assert_eq!(exponents("N·s/m"), Some([1, 0, -1, 0]));
        assert_eq!(exponents("kg·m²"), Some([1, 2, 0, 0]));
        assert_eq!(exponents("1/kg"), Some([-1, 0, 0, 0]));
        assert_eq!(exponents("m/s/s"), exponents("m/s²"));
        assert_eq!(exponents("furlong"), None);
    }
}

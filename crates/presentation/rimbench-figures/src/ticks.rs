//! Where an axis has ticks and what they say.

/// One tick of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// Value at the tick.
    pub value: f64,
    /// What it says; empty for a minor tick.
    pub label: String,
}

/// Ticks of an axis, with the power of ten all labels leave out.
#[derive(Debug, Clone, PartialEq)]
pub struct Ticks {
    /// The ticks in ascending order.
    pub ticks: Vec<Tick>,
    /// Every label is to be multiplied by 10 to this power.
    pub exponent: i32,
}

/// Chooses at most `most` round values in [low, high], 1, 2 or 5 times a power of ten apart.
///
/// Values of 10⁵ and more, or below 10⁻³, share a factored-out power of ten, a multiple of three.
pub fn linear(low: f64, high: f64, most: usize) -> Ticks {
    let least_step = (high - low) / (most.max(2) as f64 - 0.5);
    let decade = 10f64.powf(least_step.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|s| *s >= least_step * (1.0 - 1e-9));
    let step = step.unwrap_or(10.0 * decade);
    let slack = 1e-9 * (high - low);
    let (first, last) = (((low - slack) / step).ceil() as i64, ((high + slack) / step).floor() as i64);

    let largest = low.abs().max(high.abs()).log10();
    let outside = !(-2.0..5.0).contains(&largest);
    let exponent = if outside { 3 * (largest / 3.0).floor() as i32 } else { 0 };
    let unit = 10f64.powi(exponent);
    let decimals = (-(step / unit).log10() - 1e-9).ceil().clamp(0.0, 9.0) as usize;
    let tick = |k: i64| {
        let value = k as f64 * step;
        Tick { value, label: signed(format!("{:.decimals$}", value / unit)) }
    };
    Ticks { ticks: (first..=last).map(tick).collect(), exponent }
}

/// Chooses ticks of a logarithmic axis from `low` > 0 to `high`, at most about `most` with a label.
///
/// Within four decades of everyday size the labels are plain numbers, otherwise powers of ten. An interval shorter than
/// a factor of four has the ticks of a linear one.
pub fn logarithmic(low: f64, high: f64, most: usize) -> Ticks {
    if high / low < 4.0 {
        return linear(low, high, most);
    }
    let (bottom, top) = (low.log10(), high.log10());
    let decades = (bottom.floor() as i32)..=(top.floor() as i32);
    let inside = |value: f64| value >= low * (1.0 - 1e-9) && value <= high * (1.0 + 1e-9);
    let plain = low >= 0.9e-3 && high <= 1.1e5 && top - bottom <= 4.0;
    let whole: usize = decades.clone().filter(|&d| inside(10f64.powi(d))).count();

    let candidates: [&[u32]; 3] = [&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[1, 2, 5], &[1]];
    let count = |mantissas: &[u32]| {
        let values = decades.clone().flat_map(|d| mantissas.iter().map(move |&m| f64::from(m) * 10f64.powi(d)));
        values.filter(|&value| inside(value)).count()
    };
    // Powers of ten only, unless that leaves an axis with hardly a label.
    let sets = if plain || whole < 2 { &candidates[..] } else { &candidates[2..] };
    let labelled = sets.iter().find(|set| count(set) <= most).copied().unwrap_or(&[1]);
    let stride = (whole as f64 / most.max(1) as f64).ceil().max(1.0) as i32;

    let mut ticks = Vec::new();
    for decade in decades {
        let minor: &[u32] = if stride == 1 { candidates[0] } else { &[1] };
        for &mantissa in minor {
            let value = f64::from(mantissa) * 10f64.powi(decade);
            if inside(value) {
                let shown = labelled.contains(&mantissa) && decade.rem_euclid(stride) == 0;
                let label = if shown { power_label(mantissa, decade, plain) } else { String::new() };
                ticks.push(Tick { value, label });
            }
        }
    }
    Ticks { ticks, exponent: 0 }
}

/// Chooses ticks of a signed logarithmic axis that is linear within ± 10 to the power `least`: zero, and powers of ten
/// on either side, as many as fit, the largest of each side among them.
pub fn symmetric(low: f64, high: f64, least: i32, most: usize) -> Ticks {
    let last = |end: f64| if end > 0.0 { (end.log10() + 1e-9).floor() as i32 } else { i32::MIN };
    let (down, up) = (last(-low), last(high));
    let count = |end: i32| if end >= least { (end - least + 1) as usize } else { 0 };
    let stride = ((count(down) + count(up)) as f64 / most.saturating_sub(1).max(2) as f64).ceil().max(1.0) as i32;
    let tick = |sign: f64, power: i32, end: i32| {
        let shown = (end - power) % stride == 0;
        let label = match (shown, sign < 0.0) {
            (false, _) => String::new(),
            (true, true) => format!("−{}", power_of_ten(power)),
            (true, false) => power_of_ten(power),
        };
        Tick { value: sign * 10f64.powi(power), label }
    };
    let below = (least..=down.max(least - 1)).rev().filter(|_| down >= least).map(|power| tick(-1.0, power, down));
    let above = (least..=up.max(least - 1)).filter(|_| up >= least).map(|power| tick(1.0, power, up));
    let zero = Tick { value: 0.0, label: "0".to_owned() };
    Ticks { ticks: below.chain([zero]).chain(above).collect(), exponent: 0 }
}

/// Formats 10 to a power with superscript digits.
pub fn power_of_ten(exponent: i32) -> String {
    let raised = |c: char| {
        c.to_digit(10).map_or('⁻', |digit| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize])
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// Replaces a hyphen by a true minus sign, and negative zero by zero.
pub fn signed(number: String) -> String {
    match number.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| c == '0' || c == '.') => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
        None => number,
    }
}

fn power_label(mantissa: u32, decade: i32, plain: bool) -> String {
    if plain {
        let decimals = (-decade).max(0) as usize;
        format!("{:.decimals$}", f64::from(mantissa) * 10f64.powi(decade))
    } else if mantissa == 1 {
        power_of_ten(decade)
    } else {
        format!("{mantissa}·{}", power_of_ten(decade))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_round_share_a_power_of_ten_have_a_true_minus_and_are_thinned_to_what_fits() {
        for (ticks, exponent, wanted) in [
            (linear(-1.02, 1.1, 5), 0, "−1.0 −0.5 0.0 0.5 1.0"),
            (linear(0.0, 2.5, 6), 0, "0.0 0.5 1.0 1.5 2.0 2.5"),
            (linear(1.68, 1.72, 5), 0, "1.68 1.69 1.70 1.71 1.72"),
            (linear(0.0, 8.0e6, 5), 6, "0 2 4 6 8"),
            (linear(0.0, 4.0e-6, 5), -6, "0 1 2 3 4"),
            (linear(-2.0e4, 2.0e4, 5), 0, "−20000 −10000 0 10000 20000"),
            (logarithmic(0.2, 20.0, 8), 0, "0.2 0.5 1 2 5 10 20"),
            (logarithmic(100.0, 1000.0, 5), 0, "100 200 500 1000"),
            (logarithmic(1e-7, 1e-2, 9), 0, "10⁻⁷ 10⁻⁶ 10⁻⁵ 10⁻⁴ 10⁻³ 10⁻²"),
            (logarithmic(1e-12, 1.0, 5), 0, "10⁻¹² 10⁻⁹ 10⁻⁶ 10⁻³ 10⁰"),
            // Less than a decade.
            (logarithmic(1.5e-7, 9.0e-7, 6), 0, "2·10⁻⁷ 5·10⁻⁷"),
            (logarithmic(230.0, 340.0, 4), 0, "250 300"),
            (symmetric(-1.0, 1.0, -1, 9), 0, "−10⁰ −10⁻¹ 0 10⁻¹ 10⁰"),
            (symmetric(0.0, 100.0, 0, 5), 0, "0 10⁰ 10¹ 10²"),
            (symmetric(-10.0, 0.0, 0, 5), 0, "−10¹ −10⁰ 0"),
        ] {
            let labels: Vec<&str> =
                ticks.ticks.iter().map(|tick| &*tick.label).filter(|label| !label.is_empty()).collect();
            assert_eq!((labels.join(" ").as_str(), ticks.exponent), (wanted, exponent));
        }
        // Never two at one place.
        let thinned = symmetric(-1e4, 1e4, -4, 7);
        let labelled = thinned.ticks.iter().filter(|tick| !tick.label.is_empty());
        assert!(labelled.clone().count() <= 8 && labelled.clone().any(|tick| tick.label == "−10⁴"), "{thinned:?}");
        assert!(thinned.ticks.windows(2).all(|pair| pair[0].value < pair[1].value), "{thinned:?}");
    }
}

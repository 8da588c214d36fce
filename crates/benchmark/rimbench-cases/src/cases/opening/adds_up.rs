//! What a side from outside says of its own motion against its motion: one function for each row and each source.
//!
//! ```text
//! Δx  against v h                positions and velocities
//! Δv/ΔF/h  against H             a pushed force and the interface model
//! Δv/h  against a + H λ          a step and the interface model
//! Δy, Δy/Δu  against h r, D + h R        a step, a pushed input and the derivatives of outputs
//! ```
//! What is said may be off by a factor of two, because steps are as long as they are. A row of which nothing can be
//! said is not judged: one that stands, one whose contacts are closed or close within the step, one that answers to a
//! push otherwise than to a pull, and one whose ratio depends on the length of the step.

use rimbench_core::cosim::{OutputRates, Ports, Quantity};
use rimbench_core::interface_model::{ReducedInterfaceModel, TOUCHING};

/// Factor by which what is said may be off.
const OFF: f64 = 2.0;
/// Share of a position by which it may differ for no reason but round-off.
const ROUND_OFF: f64 = 1e-12;
/// Share of a velocity or a force below which a change of it is none.
const NO_CHANGE: f64 = 1e-9;
/// Round-off of a velocity at rest, m/s.
pub(super) const AT_REST: f64 = 1e-12;
/// Share of its parts below which a sum has cancelled, and says nothing.
const CANCELLED: f64 = 1e-3;
/// Within which factor steps must agree on the ratio.
const AGREE: f64 = 4.0;

/// One step that was taken.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Move {
    pub(super) u: Vec<f64>,
    pub(super) before: Vec<f64>,
    pub(super) after: Vec<f64>,
    pub(super) h: f64,
}

/// The same step with one input changed both ways, and as it is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Push {
    pub(super) input: usize,
    pub(super) change: f64,
    /// Outputs after it: less, as it is, more.
    pub(super) after: [Vec<f64>; 3],
    pub(super) h: f64,
}

/// What was measured over what was said; where that is not 1, it is `out`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ratio {
    pub(super) measured: f64,
    pub(super) said: f64,
}

impl Ratio {
    pub(super) fn value(self) -> f64 {
        self.measured / self.said
    }

    /// Whether it is beyond the factor that is allowed.
    pub(super) fn is_out(self) -> bool {
        !(1.0 / OFF..=OFF).contains(&self.value())
    }

    /// Whether another one says the same.
    pub(super) fn agrees_with(self, other: Ratio) -> bool {
        agree(&[self.value(), other.value()])
    }
}

/// Whether ratios are one and the same ratio, nothing and infinite ones included.
fn agree(ratios: &[f64]) -> bool {
    let (low, high) = ratios
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), ratio| (low.min(*ratio), high.max(*ratio)));
    let one_sign = low > 0.0 || high < 0.0;
    let magnitudes = [low.abs().min(high.abs()), low.abs().max(high.abs())];
    let all = |is: fn(f64) -> bool| ratios.iter().all(|ratio| is(*ratio));
    all(|ratio| ratio == 0.0) || all(f64::is_infinite) || (one_sign && magnitudes[1] <= AGREE * magnitudes[0])
}

/// Tells whether outputs are positions, then as many velocities.
pub(super) fn is_motion(ports: &Ports) -> bool {
    let (positions, velocities) = ports.outputs.split_at(ports.outputs.len() / 2);
    positions.len() == velocities.len()
        && positions.iter().all(|port| port.quantity == Quantity::Position)
        && velocities.iter().all(|port| port.quantity == Quantity::Velocity)
}

/// Change of a position over what its velocity says, where most steps agree that it is another.
pub(super) fn position_over_velocity(moves: &[Move], row: usize) -> Option<f64> {
    let (mut judged, mut out) = (0, Vec::new());
    for Move { before, after, h, .. } in moves {
        let rows = before.len() / 2;
        let [x, y] = [before[row], after[row]];
        let [v, w] = [before[rows + row], after[rows + row]];
        let (moved, noise) = (y - x, ROUND_OFF * x.abs().max(y.abs()));
        if moved == 0.0 && v == w && v != 0.0 {
            // It has not stepped: its own steps are longer than h, or it acts with a delay.
            return None;
        }
        let (least, most) = (h * v.min(w), h * v.max(w));
        if moved.abs() <= noise && least.abs().max(most.abs()) <= noise {
            continue;
        }
        let within = |from: f64, to: f64| (from - noise..=to + noise).contains(&moved);
        let one_way = least > 0.0 || most < 0.0;
        let fits = match one_way {
            true if least > 0.0 => within(least / OFF, OFF * most),
            true => within(OFF * least, most / OFF),
            // The velocity starts at zero or changes its sign: the motion may be anything between the bounds.
            false => within(OFF * least, OFF * most),
        };
        judged += usize::from(one_way || !fits);
        if !fits {
            let largest = if least.abs() > most.abs() { least } else { most };
            out.push(or_none(moved / largest));
        }
    }
    // A contact or an event spoils a step or two.
    let most = out.len() >= 2 && 4 * out.len() >= 3 * judged && agree(&out);
    most.then(|| or_none(ratio_of_all(moves, row)))
}

/// A ratio, or 0 where it is round-off.
fn or_none(ratio: f64) -> f64 {
    if ratio.abs() < ROUND_OFF { 0.0 } else { ratio }
}

/// The ratio over all steps, by the velocity at the beginning, in the middle or at the end of each, whichever says
/// most.
fn ratio_of_all(moves: &[Move], row: usize) -> f64 {
    let by = |share: f64| {
        let pairs = moves.iter().map(|Move { before, after, h, .. }| {
            let rows = before.len() / 2;
            let velocity = (1.0 - share) * before[rows + row] + share * after[rows + row];
            [h * velocity, after[row] - before[row]]
        });
        let sum = |of: fn([f64; 2]) -> f64| pairs.clone().map(of).sum::<f64>();
        let ratio = sum(|[said, moved]| said * moved) / sum(|[said, _]| said * said);
        let left: f64 = pairs.clone().map(|[said, moved]| (moved - ratio * said).powi(2)).sum();
        (ratio, left)
    };
    if moves.iter().all(|step| step.after[step.after.len() / 2 + row] == 0.0) {
        return f64::INFINITY;
    }
    let [first, middle, last] = [0.0, 0.5, 1.0].map(by);
    let better = |one: (f64, f64), other: (f64, f64)| if other.1 < one.1 { other } else { one };
    better(better(last, middle), first).0
}

/// Whether a model has no contact that is closed, or closes within so long (s).
fn is_free(model: &ReducedInterfaceModel, h: f64) -> bool {
    let within = |(gap, w): (&f64, &f64)| *gap <= TOUCHING + 2.0 * h * w.abs();
    !model.at_bound.iter().any(|closed| *closed) && !model.gap.iter().zip(&model.w).any(within)
}

/// Answer of an output to a push, per unit of it; none where a push and a pull do not say the same.
pub(super) fn answer(push: &Push, output: usize) -> Option<f64> {
    let [less, as_is, more] = [0, 1, 2].map(|at| push.after[at][output]);
    let (up, down) = (more - as_is, as_is - less);
    let slack = NO_CHANGE * less.abs().max(more.abs());
    let same = (up - down).abs() <= 0.5 * (up + down).abs() + 2.0 * slack;
    let answer = if (up + down).abs() <= 2.0 * slack { 0.0 } else { (up + down) / (2.0 * push.change) };
    same.then_some(answer)
}

/// Answer of a velocity to its own pushed force over `H h` of the model; none where nothing can be said.
pub(super) fn answer_over_model(
    push: &Push,
    before: &[f64],
    model: &ReducedInterfaceModel,
    row: usize,
) -> Option<Ratio> {
    let rows = before.len() / 2;
    let start = model.interface_start();
    if !is_free(model, push.h) {
        return None;
    }
    let entry = |i: usize, j: usize| model.entry(start + i, start + j);
    let said = entry(row, push.input) * push.h;
    let measured = answer(push, rows + row)?;
    // A coupling of two rows below 5 % of their own entries is not judged.
    let own = (entry(row, row) * entry(push.input, push.input)).abs().sqrt() * push.h;
    if row != push.input && said.abs().max(measured.abs()) <= 0.05 * own {
        return None;
    }
    // A zero answer says nothing: the row is locked, or answers later.
    let noise = (NO_CHANGE * before[rows + row].abs() + AT_REST) / push.change;
    (measured != 0.0 && measured.abs().max(said.abs()) > noise && said.is_finite()).then_some(Ratio { measured, said })
}

/// Change of a velocity in a step over `h (a + H λ)` of the model at its beginning; none where nothing can be said.
pub(super) fn step_over_model(step: &Move, model: &ReducedInterfaceModel, row: usize) -> Option<Ratio> {
    let rows = step.before.len() / 2;
    let start = model.interface_start();
    if !is_free(model, step.h) {
        return None;
    }
    let parts: Vec<f64> =
        (0..step.u.len()).map(|column| model.entry(start + row, start + column) * step.u[column]).collect();
    let free = model.a[start + row];
    let (said, size) = (
        step.h * (free + parts.iter().sum::<f64>()),
        step.h * (free.abs() + parts.iter().map(|part| part.abs()).sum::<f64>()),
    );
    let [v, w] = [step.before[rows + row], step.after[rows + row]];
    let (measured, noise) = (w - v, CANCELLED * size + NO_CHANGE * v.abs().max(w.abs()));
    // A velocity that does not change at all is locked, or answers later.
    let stands = measured == 0.0;
    (said.is_finite() && !stands && measured.abs().max(said.abs()) > noise).then_some(Ratio { measured, said })
}

/// Change of an output in a step over what its rate says; none where nothing can be said.
pub(super) fn step_over_rate(step: &Move, rates: &OutputRates, output: usize) -> Option<Ratio> {
    let [from, to] = [step.before[output], step.after[output]];
    let (measured, said) = (to - from, step.h * rates.rate[output]);
    let noise = NO_CHANGE * from.abs().max(to.abs());
    (said.is_finite() && measured != 0.0 && measured.abs().max(said.abs()) > noise).then_some(Ratio { measured, said })
}

/// Answer of an output to a pushed input over `D + h R`; none where nothing can be said.
pub(super) fn answer_over_rate(push: &Push, rates: &OutputRates, output: usize) -> Option<Ratio> {
    let at = output * (rates.feedthrough.len() / rates.rate.len().max(1)) + push.input;
    let said = rates.feedthrough[at] + push.h * rates.rate_gain[at];
    let measured = answer(push, output)?;
    let noise = NO_CHANGE * push.after[1][output].abs() / push.change;
    (said.is_finite() && measured != 0.0 && measured.abs().max(said.abs()) > noise).then_some(Ratio { measured, said })
}

/// Says what a ratio looks like, of a force or of a motion: a sign, a unit, or just a number.
pub(super) fn in_words(ratio: f64, quantity: Quantity) -> String {
    const MOTIONS: [(f64, &str); 9] = [
        (1e3, "mm for m"),
        (1e-3, "km for m"),
        (1e6, "µm for m"),
        (100.0, "cm for m"),
        (57.295_779_5, "° for rad"),
        (9.549_296_6, "1/min for rad/s"),
        (39.370_078_7, "in for m"),
        (3.280_839_9, "ft for m"),
        (3.6, "km/h for m/s"),
    ];
    const FORCES: [(f64, &str); 5] = [
        (1e3, "mN for N"),
        (1e-3, "kN for N"),
        (1e-6, "MN for N"),
        (0.101_971_6, "kgf for N"),
        (0.224_808_9, "lbf for N"),
    ];
    let size = ratio.abs();
    if size == 0.0 {
        return "0, where it is something".to_owned();
    }
    if !size.is_finite() {
        return "something, where it is 0".to_owned();
    }
    let near = |value: f64| (size / value - 1.0).abs() < 0.02;
    let known = if quantity == Quantity::Force { &FORCES[..] } else { &MOTIONS };
    let inverse = known.iter().find(|(value, _)| near(1.0 / value));
    let unit = match (known.iter().find(|(value, _)| near(*value)), inverse) {
        (Some((_, unit)), _) => format!(", as of {unit}"),
        (_, Some((_, unit))) => format!(", the reverse of {unit}"),
        _ => String::new(),
    };
    let size_in_words = digits(size);
    match ratio < 0.0 {
        true if near(1.0) => "reversed in sign".to_owned(),
        true => format!("reversed in sign, and {size_in_words} times as large{unit}"),
        false => format!("{size_in_words} times as large{unit}"),
    }
}

/// A number with three digits.
pub(super) fn digits(number: f64) -> String {
    let size = number.abs();
    if !(1e-4..1e6).contains(&size) {
        return format!("{number:.2e}");
    }
    let behind = (2.0 - libm::log10(size).floor()).max(0.0) as usize;
    format!("{number:.behind$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moves(x: &[f64], v: &[f64]) -> Vec<Move> {
        let at = |k: usize| vec![x[k], v[k]];
        (1..x.len()).map(|k| Move { u: vec![0.0], before: at(k - 1), after: at(k), h: 0.1 }).collect()
    }

    #[test]
    fn a_velocity_that_is_not_that_of_the_position_is_found_by_its_ratio_and_nothing_else_is() {
        let [x, v] = [[0.0, 0.1, 0.3, 0.6], [0.0, 1.0, 2.0, 3.0]];
        let [far, fast] = [[0.0, 1.1, 2.3, 3.6], [10.0, 11.0, 12.0, 13.0]];
        let ratio = |x: &[f64], v: &[f64]| position_over_velocity(&moves(x, v), 0);
        let times = |list: [f64; 4], factor: f64| list.map(|number| factor * number);
        assert_eq!(ratio(&x, &v), None);
        for factor in [-1.0, 1000.0, 1e-3, 3.0, -57.3] {
            let near = |found: Option<f64>, wanted: f64| (found.unwrap() / wanted - 1.0).abs() < 0.15;
            assert!(near(ratio(&times(far, factor), &fast), factor), "{factor}");
            assert!(near(ratio(&far, &times(fast, factor)), 1.0 / factor), "{factor}");
        }
        // Not a word on explicit, trapezoidal and late velocities, on what stands, waits, or is hit.
        for (x, v) in [
            ([0.0, 0.0, 0.1, 0.3], v),
            ([0.0, 0.05, 0.2, 0.45], v),
            (x, [0.0, 0.0, 1.0, 2.0]),
            ([1.0; 4], [0.0; 4]),
            ([1.0; 4], [2.0; 4]),
            ([0.0, 0.0, 0.0, 0.6], [2.0; 4]),
            ([0.0, 0.1, 0.1, 0.0], [1.0, 1.0, -1.0, -1.0]),
        ] {
            assert_eq!(ratio(&x, &v), None, "{x:?} {v:?}");
        }
        // A velocity that says nothing, and a position that does not follow.
        assert_eq!(ratio(&x, &[0.0; 4]), Some(f64::INFINITY));
        assert_eq!(ratio(&[0.5; 4], &[1.0, 1.1, 1.2, 1.3]), Some(0.0));
        assert_eq!(ratio(&[0.0, 0.0, 1e-210, 2e-210], &[1.0, 1.1, 1.2, 1.3]), Some(0.0));
    }

    #[test]
    fn a_ratio_is_called_what_it_looks_like() {
        for (ratio, quantity, words) in [
            (-1.0016, Quantity::Velocity, "reversed in sign"),
            (1001.4, Quantity::Position, "1001 times as large, as of mm for m"),
            (0.001, Quantity::Force, "0.00100 times as large, as of kN for N"),
            (-57.3, Quantity::Position, "reversed in sign, and 57.3 times as large, as of ° for rad"),
            (0.01, Quantity::Velocity, "0.0100 times as large, the reverse of cm for m"),
            (7.0, Quantity::Force, "7.00 times as large"),
            (0.0, Quantity::Force, "0, where it is something"),
        ] {
            assert_eq!(in_words(ratio, quantity), words);
        }
    }
}

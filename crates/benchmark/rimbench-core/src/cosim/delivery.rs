//! When samples arrive: in time, late, or never.

use super::side::Side;
use crate::error::{Error, Result};
use crate::name::by_name;
use crate::parts::Parts;
use std::fmt;
use std::str::FromStr;

/// The most macro steps by which a sample may be late: a plausibility bound, far beyond any use.
pub const MOST_LATE: u32 = 100_000;

/// The way of samples in one direction.
///
/// ```text
/// sample m arrives at communication point m + delay + j_m + missed_m, or never        j_m uniform in 0, …, jitter
/// ```
/// The newest sample that has arrived counts. `j_m` and losses are drawn from a hash of seed, direction and m: they
/// depend neither on the order of calls nor on the scheme, so that two schemes lose the same samples.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Channel {
    /// Macro steps by which every sample is late.
    pub delay: u32,
    /// Most macro steps by which a sample is late on top.
    pub jitter: u32,
    /// Share of samples that never arrive, in [0, 1).
    pub loss: f64,
    /// Seed of jitter and losses.
    pub seed: u64,
    /// Samples of macro steps that missed their deadline: index, and macro steps by which each is late on top; in the
    /// order of time.
    pub missed: Vec<(u32, u32)>,
}

impl Channel {
    /// Tells whether every sample arrives in time.
    pub fn is_in_time(&self) -> bool {
        *self == Channel { seed: self.seed, ..Channel::default() }
    }

    /// Lists, for each of the communication points from 0, the newest sample that has arrived; none before the first.
    pub(crate) fn newest(&self, direction: Side, points: usize) -> Vec<Option<usize>> {
        let mut newest = vec![None; points];
        let mut missed = self.missed.iter().peekable();
        for m in 0..points {
            let draw = |what: u64| hash(hash(self.seed, 2 * what + u64::from(direction == Side::Actuator)), m as u64);
            let late = missed.next_if(|(step, _)| *step as usize == m).map_or(0, |(_, late)| *late);
            let jitter = (draw(0) % (u64::from(self.jitter) + 1)) as usize;
            let lost = ((draw(1) >> 11) as f64) < self.loss * (1_u64 << 53) as f64;
            let arrival = m + self.delay as usize + jitter + late as usize;
            if !lost && let Some(newest) = newest.get_mut(arrival) {
                *newest = Some(m);
            }
        }
        let mut last = None;
        for newest in &mut newest {
            last = last.max(*newest);
            *newest = last;
        }
        newest
    }

    /// Checks it against a run of so many macro steps; `name` is that of the option.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a delay of the whole run or more, and a missed deadline beyond its end.
    pub fn check(&self, name: &'static str, macro_steps: usize) -> Result<()> {
        let most = self.delay as usize + self.jitter as usize;
        if most >= macro_steps {
            let expected = format!("delay and jitter below the {macro_steps} macro steps of the run together");
            return Err(Error::invalid(name, self, expected));
        }
        match self.missed.last() {
            Some((step, _)) if *step as usize >= macro_steps => {
                let expected = format!("missed macro steps from 0 to {}, those of the run", macro_steps - 1);
                Err(Error::invalid(name, self, expected))
            }
            _ => Ok(()),
        }
    }
}

/// Mixes two numbers: SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), with the counter as its state.
fn hash(seed: u64, counter: u64) -> u64 {
    let mut z = seed.wrapping_add(counter.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Channel { delay, jitter, loss, seed, missed } = self;
        write!(f, "delay:{delay}")?;
        if *jitter > 0 {
            write!(f, ",jitter:{jitter}")?;
        }
        if *loss > 0.0 {
            write!(f, ",loss:{loss:?}")?;
        }
        if *seed > 0 {
            write!(f, ",seed:{seed}")?;
        }
        for (index, (step, late)) in missed.iter().enumerate() {
            f.write_str(if index == 0 { ",missed:" } else { "+" })?;
            write!(f, "{step}")?;
            if *late != 1 {
                write!(f, "*{late}")?;
            }
        }
        Ok(())
    }
}

impl FromStr for Channel {
    type Err = Error;

    /// Reads `delay=D,jitter=J,loss=P,seed=S,missed=K+K*L+…`, each part at most once and in any order.
    fn from_str(text: &str) -> Result<Self> {
        let mut channel = Channel::default();
        let Channel { delay, jitter, loss, seed, missed } = &mut channel;
        let parts = Parts::of("delivery", text, ["delay", "jitter", "loss", "seed", "missed"])?;
        let steps = "whole macro steps, 0 to 100000, as in `delay=2`";
        parts.read("delay", delay, |steps| *steps <= MOST_LATE, steps)?;
        parts.read("jitter", jitter, |steps| *steps <= MOST_LATE, steps)?;
        let share = "a share of lost samples from 0 to below 1, as in `loss=0.2`";
        parts.read("loss", loss, |loss| (0.0..1.0).contains(loss), share)?;
        parts.read("seed", seed, |_| true, "a whole number from 0 as the seed, as in `seed=3`")?;
        if let Some(text) = parts.get("missed") {
            *missed = missed_steps(text).map_err(|why| parts.refused(&why))?;
        }
        Ok(channel)
    }
}

/// Reads macro steps that missed their deadline, `3+7*2`: that of index 3 by one step, that of index 7 by two.
fn missed_steps(text: &str) -> std::result::Result<Vec<(u32, u32)>, String> {
    let mut missed: Vec<(u32, u32)> = Vec::new();
    for word in text.split('+') {
        let (step, late) = word.split_once('*').unwrap_or((word, "1"));
        let number = |text: &str| text.trim().parse::<u32>().ok();
        let (Some(step), Some(late)) = (number(step), number(late).filter(|late| (1..=MOST_LATE).contains(late)))
        else {
            return Err(
                "macro steps joined by `+`, each with `*` and by how many steps it is late if more than one".into()
            );
        };
        if missed.last().is_some_and(|(before, _)| *before >= step) {
            return Err("missed macro steps in the order of time, each once".into());
        }
        missed.push((step, late));
    }
    Ok(missed)
}

/// What a receiver makes of a sample that is late.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LateRule {
    /// An extrapolation uses the time at which the sample was taken; an interface model is run forward to the present
    /// with the forces that the actuator has had since, contacts included.
    #[default]
    CatchUp,
    /// As catching up, but the delay takes a model as many steps as one macro step, and at most one more for each macro
    /// step of age.
    CatchUpCoarse,
    /// The sample is taken for one of now.
    Raw,
}

impl LateRule {
    const NAMES: [(&'static str, LateRule); 3] =
        [("catch-up", LateRule::CatchUp), ("catch-up-coarse", LateRule::CatchUpCoarse), ("raw", LateRule::Raw)];

    /// Tells whether a model is run forward.
    pub fn catches_up(self) -> bool {
        self != LateRule::Raw
    }
}

by_name!(LateRule, NAMES, "treatment of late samples");

/// What the mechanics takes for a force that has not arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ForceBridge {
    /// The newest that has.
    #[default]
    Hold,
    /// The straight line through the newest two.
    Linear,
    /// A model of the actuator at the mechanics: its output rates at the end of the newest macro step that has arrived.
    Rates,
}

impl ForceBridge {
    const NAMES: [(&'static str, ForceBridge); 3] =
        [("hold", ForceBridge::Hold), ("linear", ForceBridge::Linear), ("rates", ForceBridge::Rates)];
}

by_name!(ForceBridge, NAMES, "bridge over late forces");

/// Both directions of a coupling whose samples may be late.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Delivery {
    /// From the mechanics to the actuator: outputs and interface model.
    pub up: Channel,
    /// From the actuator to the mechanics: forces.
    pub down: Channel,
    /// What the actuator makes of late samples.
    pub late: LateRule,
    /// What the mechanics makes of late forces.
    pub bridge: ForceBridge,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn newest(text: &str, points: usize) -> Vec<Option<usize>> {
        text.parse::<Channel>().unwrap().newest(Side::Mechanics, points)
    }

    /// Published with the generator: its first numbers from the seed 0, of which three stand here.
    #[test]
    fn numbers_are_those_of_split_mix() {
        let numbers = [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4, 0x06c4_5d18_8009_454f];
        assert_eq!([0, 1, 2].map(|counter| hash(0, counter)), numbers);
    }

    #[test]
    fn a_delay_shifts_every_sample_and_a_missed_deadline_one() {
        assert_eq!(newest("delay:2", 5), [None, None, Some(0), Some(1), Some(2)]);
        assert_eq!(newest("missed:1+2*2", 6), [Some(0), Some(0), Some(1), Some(3), Some(4), Some(5)]);
    }

    #[test]
    fn losses_are_as_many_as_asked_and_depend_on_seed_and_direction_only() {
        let channel: Channel = "loss:0.2,seed:7".parse().unwrap();
        let lost = |direction: Side| {
            let newest = channel.newest(direction, 10_000);
            newest.iter().enumerate().map(|(k, newest)| *newest != Some(k)).collect::<Vec<bool>>()
        };
        let share = lost(Side::Mechanics).iter().filter(|lost| **lost).count() as f64 / 1e4;
        // Four standard deviations of 10 000 draws.
        assert!((share - 0.2).abs() < 0.016, "{share}");
        assert_ne!(lost(Side::Mechanics), lost(Side::Actuator));
        // A longer run has the losses of a shorter one at its start.
        assert_eq!(channel.newest(Side::Mechanics, 100), channel.newest(Side::Mechanics, 200)[..100]);
    }

    #[test]
    fn jitter_stays_within_its_bound_and_samples_may_overtake() {
        let newest = newest("delay:1,jitter:3,seed:1", 1000);
        let age = |(k, newest): (usize, &Option<usize>)| newest.map(|m| k - m);
        let ages: Vec<usize> = newest.iter().enumerate().skip(4).filter_map(age).collect();
        assert_eq!((ages.iter().min(), ages.iter().max()), (Some(&1), Some(&4)));
        assert!(newest.windows(2).all(|pair| pair[0] <= pair[1]));
    }

    #[test]
    fn a_channel_is_written_as_it_is_read() {
        for text in ["delay:0", "delay:3,jitter:1,loss:0.25,seed:9", "delay:0,missed:3+7*2"] {
            assert_eq!(text.parse::<Channel>().unwrap().to_string(), text);
        }
        assert!("delay:0,seed:4".parse::<Channel>().unwrap().is_in_time());
    }

    #[test]
    fn nonsense_is_refused_with_what_is_valid() {
        let refused = |text: &str| text.parse::<Channel>().unwrap_err().to_string();
        assert!(refused("delay:-1").contains("whole macro steps"));
        assert!(refused("loss:1").contains("below 1"));
        assert!(refused("loss:nan").contains("below 1"));
        assert!(refused("dealy:1").contains("did you mean `delay`"));
        assert!(refused("delay:1,delay:2").contains("at most once"));
        assert!(refused("missed:7+3").contains("in the order of time"));
        let channel: Channel = "delay:9,jitter:1".parse().unwrap();
        assert!(channel.check("delivery_up", 10).unwrap_err().to_string().contains("below the 10 macro steps"));
        assert!(channel.check("delivery_up", 11).is_ok());
    }
}

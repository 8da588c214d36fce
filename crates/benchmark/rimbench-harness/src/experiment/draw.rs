//! Settings of a case drawn at random: machines as an axis of the grid.

use crate::cache::Cache;
use crate::grid::scalar_text;
use crate::references::has_none;
use rayon::prelude::*;
use rimbench_cases::cases::Case;
use rimbench_cases::parameter::{Parameter, Range};
use rimbench_core::error::{Error, Result};
use rimbench_runs::metrics::ContactEvent;
use rimbench_statistics::latin_hypercube;
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;

/// Significant digits of a drawn value.
const DIGITS: usize = 3;

/// A range with this ratio of its ends is drawn from in logarithms.
const LOGARITHMIC: f64 = 10.0;

/// Hypercubes drawn at most for settings that have the event asked for: in one of so many settings it must happen.
const MOST_HYPERCUBES: usize = 64;

/// The key `draw` of a case: a Latin hypercube over ranges of its parameters, the same at each point of the grid.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Draw {
    /// Number of settings.
    #[serde(deserialize_with = "whole")]
    pub(super) settings: usize,
    /// What the draws start from; the same seed has the same settings.
    #[serde(deserialize_with = "whole")]
    seed: usize,
    /// Parameters that are drawn over the range that the case declares as sensible.
    #[serde(default)]
    declared: Vec<String>,
    /// Parameters that are drawn over a range given here, by name: from, to.
    #[serde(default)]
    ranges: BTreeMap<String, [f64; 2]>,
    /// What must happen in the reference at each point of the grid: a setting in which it does not is drawn again.
    #[serde(default, deserialize_with = "event")]
    pub(super) requires: Option<ContactEvent>,
}

impl Draw {
    /// Tells whether it draws a parameter, by name.
    pub(super) fn draws(&self, name: &str) -> bool {
        self.ranges.contains_key(name) || self.declared.iter().any(|own| own == name)
    }
}

/// A setting that was drawn.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Drawn {
    /// Values of parameters by name.
    pub(super) values: Values,
    /// How many were rejected since the one before, where something is required of them.
    pub(super) rejected: Option<usize>,
}

/// Values of parameters by name.
type Values = Vec<(String, String)>;

/// Tells whether the reference of a setting has an event; none where no contact of the case could have it.
pub(super) type HasEvent<'a> = dyn Fn(ContactEvent, &[(String, String)]) -> Result<Option<bool>> + Sync + 'a;

/// How it is found out whether a setting has an event.
pub(super) struct Search<'a> {
    /// Tells it of values drawn, at every point of the grid; none where no contact could have it.
    pub(super) has_event: &'a HasEvent<'a>,
    /// Settings other than the drawn values that determine the event.
    pub(super) key: String,
}

/// Reads the name of an event.
fn event<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<ContactEvent>, D::Error> {
    let value = toml::Value::deserialize(deserializer)?;
    let found = ContactEvent::ALL.into_iter().find(|event| value.as_str() == Some(event.name()));
    let valid = || ContactEvent::ALL.map(ContactEvent::name).join(" | ");
    found.map(Some).ok_or_else(|| serde::de::Error::custom(format!("requires takes one of {}", valid())))
}

/// Reads a number of something, so that a slip is told as what it is.
fn whole<'de, D: Deserializer<'de>>(deserializer: D) -> Result<usize, D::Error> {
    let value = toml::Value::deserialize(deserializer)?;
    let number = value.as_integer().and_then(|number| usize::try_from(number).ok());
    number.ok_or_else(|| serde::de::Error::custom("expected a whole number, 0 or above"))
}

impl Draw {
    /// Draws the settings. Where an event is required, hypercubes are drawn one after the other, and their settings
    /// kept in order where `search` tells that it happens; without a search they are those of the first one.
    ///
    /// # Errors
    /// A parameter that the case does not have, that is no number or is set as well, a range that is no range or leaves
    /// what is valid; an event that no contact of the case can have, or that hardly ever happens.
    pub(super) fn settings(
        &self,
        case: &Case,
        set: &BTreeMap<String, toml::Value>,
        search: Option<&Search<'_>>,
    ) -> Result<Vec<Drawn>> {
        let ranges = self.ranges(case)?;
        if ranges.is_empty() {
            return Err(Error::Incompatible("draw: names no parameter, in declared or in ranges".into()));
        }
        if let Some((name, value)) = set.iter().find(|(name, _)| ranges.contains_key(name.as_str())) {
            let value = scalar_text(name, value).unwrap_or_else(|_| "[…]".into());
            return Err(Error::Incompatible(format!("{name} = {value} is set, and drawn: leave one of the two out")));
        }
        let value = |(x, (name, (parameter, range))): (&f64, (&String, &(&Parameter, [f64; 2])))| {
            (name.clone(), format!("{:?}", drawn(*x, *range, &parameter.range)))
        };
        // The first hypercube is that of the seed, the others are away from those of neighbouring seeds.
        let hypercube = |index: usize| -> Vec<Values> {
            let seed = (self.seed as u64).wrapping_add((index as u64) << 32);
            let points = latin_hypercube(self.settings, ranges.len(), seed);
            points.iter().map(|point| point.iter().zip(&ranges).map(value).collect()).collect()
        };
        let (Some(event), Some(search)) = (self.requires, search) else {
            return Ok(hypercube(0).into_iter().map(|values| Drawn { values, rejected: None }).collect());
        };
        let places = self.places(case, event, search, &hypercube)?;
        let before = [None].into_iter().chain(places.iter().copied().map(Some));
        let kept = places.iter().zip(before).map(|(&place, before)| Drawn {
            values: hypercube(place / self.settings).swap_remove(place % self.settings),
            rejected: Some(place - before.map_or(0, |before| before + 1)),
        });
        Ok(kept.collect())
    }

    /// The places, in all hypercubes, of the settings that have the event. They are found once and kept like a
    /// reference.
    fn places(
        &self,
        case: &Case,
        event: ContactEvent,
        search: &Search<'_>,
        hypercube: &dyn Fn(usize) -> Vec<Values>,
    ) -> Result<Vec<usize>> {
        let cache = Cache::of_user();
        // The first settings stand for how settings are made of draws.
        let key = format!("settings of {self:?}\n{:?}\n{}", [hypercube(0), hypercube(1)], search.key);
        if let Some(places) = cache.read(&key).filter(|places| places.len() == self.settings && !case.from_outside) {
            return Ok(places.into_iter().map(|place| place as usize).collect());
        }
        let happens = |values: &Values| match (search.has_event)(event, values) {
            Ok(Some(happens)) => Ok(happens),
            Ok(None) => Err(Error::Incompatible(format!(
                "draw: requires = \"{}\", and no contact of case `{}` can do that with these parameters",
                event.name(),
                case.name
            ))),
            // A setting without a reference is drawn again too.
            Err(error) if has_none(&error) => Ok(false),
            Err(error) => Err(error),
        };
        let mut places = Vec::with_capacity(self.settings);
        for index in 0..MOST_HYPERCUBES {
            let found: Vec<bool> = hypercube(index).par_iter().map(happens).collect::<Result<_>>()?;
            places.extend((0..self.settings).filter(|&place| found[place]).map(|place| index * self.settings + place));
            if places.len() >= self.settings {
                places.truncate(self.settings);
                if !case.from_outside {
                    cache.write(&key, &places.iter().map(|&place| place as f64).collect::<Vec<_>>());
                }
                return Ok(places);
            }
        }
        Err(Error::Incompatible(format!(
            "draw: requires = \"{}\", which happens in {} of {} settings drawn, and {} are wanted: give ranges in which it does, or \
             fewer settings",
            event.name(),
            places.len(),
            MOST_HYPERCUBES * self.settings,
            self.settings
        )))
    }

    /// What is drawn over which range, by name.
    fn ranges<'c>(&self, case: &'c Case) -> Result<BTreeMap<String, (&'c Parameter, [f64; 2])>> {
        let parameter = |name: &String| {
            let names = || case.parameters.iter().map(|parameter| &*parameter.name);
            let found = case.parameters.iter().find(|parameter| parameter.name == *name);
            found.ok_or_else(|| Error::unknown("parameter in draw", name, names()))
        };
        let mut ranges = BTreeMap::new();
        for name in &self.declared {
            let found = parameter(name)?;
            let Some(range) = found.study else {
                let message = format!("draw: case `{}` declares no sensible range of `{name}`", case.name);
                return Err(Error::Incompatible(format!("{message}: give one, ranges = {{ {name} = [from, to] }}")));
            };
            if self.ranges.contains_key(name) || ranges.insert(name.clone(), (found, range)).is_some() {
                return Err(Error::Incompatible(format!("draw: `{name}` is named twice")));
            }
        }
        for (name, &[from, to]) in &self.ranges {
            let found = parameter(name)?;
            // An end is valid if a set of parameters takes it.
            for end in [from, to] {
                case.default_parameters().set(name, &format!("{end:?}"))?;
            }
            if from >= to {
                return Err(Error::invalid(name, format!("[{from:?}, {to:?}]"), "a range from less to more"));
            }
            ranges.insert(name.clone(), (found, [from, to]));
        }
        Ok(ranges)
    }
}

/// The value at `x` in [0, 1) of a range, with three digits.
fn drawn(x: f64, [from, to]: [f64; 2], valid: &Range) -> f64 {
    let value =
        if from > 0.0 && to >= LOGARITHMIC * from { from * (to / from).powf(x) } else { from + (to - from) * x };
    let value = match valid {
        Range::Whole(..) => value.round(),
        _ => format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value),
    };
    value.clamp(from, to)
}

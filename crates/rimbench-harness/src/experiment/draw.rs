//! Settings of a case drawn at random: machines as an axis of the grid.

use crate::cache::Cache;
use crate::grid::scalar_text;
use crate::references::has_none;
use rayon::prelude::*;
use rimbench_cases::cases::{Case, Parameter, Range};
use rimbench_cases::metrics::ContactEvent;
use rimbench_core::error::{Error, Result};
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
    /// What determines that besides the values.
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
    /// Draws the settings. Where an event is required, hypercubes are drawn one after the other, and their settings kept in order where
    /// `search` tells that it happens.
    ///
    /// # Errors
    /// A parameter that the case does not have, that is no number or is set as well, a range that is no range or leaves what is valid; an
    /// event that no contact of the case can have, or that hardly ever happens.
    pub(super) fn settings(
        &self,
        case: &Case,
        set: &BTreeMap<String, toml::Value>,
        search: &Search<'_>,
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
        let Some(event) = self.requires else {
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

    /// The places, in all hypercubes, of the settings that have the event. They are found once and kept like a reference.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Experiment;
    use rimbench_cases::catalogue::Catalogue;
    use std::path::Path;

    fn parsed(case: &str) -> Result<Experiment> {
        let text = format!(
            "question = \"?\"\nmacro_steps_s = [5e-3]\nphases = 2\n[[cases]]\nname = \"wedge-box\"\n{case}\n\
             [[schemes]]\nscheme = \"nepce\"\n"
        );
        Experiment::parse(Path::new("usual.toml"), text)
    }

    fn sets(case: &str) -> Vec<(String, Option<String>)> {
        let plan = parsed(case).unwrap().plan(&Catalogue::standard(), false).unwrap();
        plan.iter().map(|run| (run.spec.parameters.given(), run.pooled_set.as_deref().map(str::to_owned))).collect()
    }

    #[test]
    fn each_point_of_the_grid_has_the_same_settings_in_their_ranges() {
        let case = "set = { restitution = [0.0, 0.3] }\n[cases.draw]\nsettings = 8\nseed = 5\ndeclared = [\"ramp_slope\"]\n\
                    [cases.draw.ranges]\nviscous_friction_n_s_m = [100, 3e4]\n";
        let found = sets(case);
        assert_eq!(found.len(), 2 * 8 * 2);
        let number = |set: &str, name: &str| -> f64 {
            set.split(' ').find_map(|word| word.strip_prefix(name)?.strip_prefix('=')).unwrap().parse().unwrap()
        };
        let drawn = |set: &str| ["ramp_slope", "viscous_friction_n_s_m"].map(|name| number(set, name));
        let of = |restitution: &str| {
            let own = found.iter().filter(|(_, pooled)| pooled.as_deref() == Some(restitution));
            own.map(|(set, _)| drawn(set)).collect::<Vec<_>>()
        };
        let settings = of("restitution=0.0");
        assert_eq!(settings, of("restitution=0.3"));
        assert!(
            settings.iter().all(|[slope, friction]| (0.08..=0.3).contains(slope) && (100.0..=3e4).contains(friction))
        );
        // In logarithms: half of them below the geometric mean.
        let mean = (100.0 * 3e4_f64).sqrt();
        assert_eq!(settings.iter().filter(|[_, friction]| *friction < mean).count(), settings.len() / 2);
        assert!(settings.iter().flatten().all(|value| format!("{value:.2e}").parse() == Ok(*value)));
        assert_eq!(sets("set = { restitution = 0.3 }")[0].1, None);
    }

    /// Boxes that a small valve moves too little for the left wedge to land.
    #[test]
    fn a_setting_without_the_event_is_drawn_again_and_counted() {
        let plan = |requires: &str| {
            let case = format!(
                "duration_s = 2.5\nset = {{ restitution = [0.0, 0.3] }}\n[cases.draw]\nsettings = 4\nseed = 201\n{requires}\n\
                 [cases.draw.ranges]\nvalve_area_m2 = [1e-6, 1e-4]\nspool_final = [0.2, 0.4]\n"
            );
            parsed(&case).unwrap().plan(&Catalogue::standard(), false).unwrap()
        };
        let sets = |plan: &[crate::PlannedRun]| -> Vec<String> {
            plan.iter().step_by(2).map(|run| run.spec.parameters.given()).collect()
        };
        let (any, landing) = (plan(""), plan("requires = \"closing\""));
        assert_eq!((any.len(), landing.len()), (2 * 4 * 2, 2 * 4 * 2));
        assert_ne!(sets(&any), sets(&landing));
        assert_eq!(sets(&landing), sets(&plan("requires = \"closing\"")));
        assert!(any.iter().all(|run| run.rejected_draws.is_none()));
        let rejected: Vec<usize> = landing.iter().map(|run| run.rejected_draws.unwrap()).collect();
        assert_eq!(rejected[..8], rejected[8..]);
        assert!(rejected[..8].iter().step_by(2).sum::<usize>() > 4, "{rejected:?}");
        for run in landing.iter().step_by(2) {
            let reference =
                rimbench_cases::runs::Reference::compute(&run.spec, rimbench_core::cosim::StopFlag::never());
            assert!(!reference.unwrap().touch_downs.is_empty(), "{}", run.spec.parameters.given());
        }
    }

    #[test]
    fn values_have_three_digits_stay_in_their_range_and_are_whole_where_the_parameter_is() {
        assert_eq!(drawn(0.5, [0.0, 1.0 / 3.0], &Range::Fraction), 0.167);
        assert_eq!(drawn(0.5, [1.0, 100.0], &Range::Positive), 10.0);
        assert_eq!(drawn(0.9999, [0.5, 1.2345], &Range::Positive), 1.23);
        assert_eq!(drawn(0.0, [1.2345, 2.0], &Range::Positive), 1.2345);
        assert_eq!(drawn(0.4, [2.0, 7.0], &Range::Whole(1, 9)), 4.0);
    }

    #[test]
    fn what_cannot_be_drawn_is_one_sentence_with_what_is_valid() {
        let refused = |draw: &str| {
            let case = format!("set = {{ restitution = 0.3 }}\n[cases.draw]\n{draw}\n");
            let planned = parsed(&case).and_then(|experiment| experiment.plan(&Catalogue::standard(), false));
            planned.unwrap_err().to_string()
        };
        let of_case = "usual.toml: [[cases]] in line 4 (`wedge-box`): ";
        for (draw, wanted) in [
            (
                "settings = 2\nseed = 1\nranges = { box_mass_kg = [-1.0, 5.0] }",
                "box_mass_kg = -1.0 is not valid; valid: a finite number above 0",
            ),
            (
                "settings = 2\nseed = 1\nranges = { box_mass_kg = [5.0, 2.0] }",
                "box_mass_kg = [5.0, 2.0] is not valid; valid: a range from less to more",
            ),
            ("settings = 2\nseed = 1\nranges = { box_mass_kg = [nan, 2.0] }", "box_mass_kg = NaN is not valid"),
            (
                "settings = 2\nseed = 1\nranges = { box_mas_kg = [1.0, 2.0] }",
                "unknown parameter in draw `box_mas_kg` (did you mean `box_mass_kg`?)",
            ),
            ("settings = 2\nseed = 1\nranges = { restitution = [0.1, 0.2] }", "restitution = 0.3 is set, and drawn"),
            (
                "settings = 2\nseed = 1\ndeclared = [\"gravity_m_s2\"]",
                "draw: case `wedge-box` declares no sensible range of `gravity_m_s2`",
            ),
            (
                "settings = 2\nseed = 1\ndeclared = [\"ramp_slope\", \"ramp_slope\"]",
                "draw: `ramp_slope` is named twice",
            ),
            ("settings = 2\nseed = 1", "draw: names no parameter"),
            (
                "settings = 1\nseed = 1\nrequires = \"sticking\"\nranges = { box_mass_kg = [100.0, 200.0] }",
                "draw: requires = \"sticking\", and no contact of case `wedge-box` can do that with these parameters",
            ),
            (
                "settings = 1\nseed = 1\nrequires = \"closing\"\nranges = { valve_area_m2 = [1e-8, 2e-8] }",
                "draw: requires = \"closing\", which happens in 0 of 64 settings drawn, and 1 are wanted: give ranges",
            ),
        ] {
            let message = refused(draw);
            assert!(message.starts_with(&format!("{of_case}{wanted}")), "{message}");
        }
        for (draw, wanted) in [
            (
                "settings = 2\nseed = \"noon\"",
                "usual.toml: is no experiment: line 9, column 8: `seed = \"noon\"`: expected a whole number, 0 or above",
            ),
            ("settings = 2\nseed = -1", "column 8: `seed = -1`: expected a whole number, 0 or above"),
            ("settings = 0.5\nseed = 1", "column 12: `settings = 0.5`: expected a whole number, 0 or above"),
            ("settings = 2", "missing field `seed`"),
            ("settings = 2\nseed = 1\nrequires = \"landing\"", "requires takes one of closing | opening | sticking"),
            ("settings = 2\nseed = 1\nrequires = 1", "requires takes one of closing | opening | sticking"),
            ("settings = 0\nseed = 1\nranges = { box_mass_kg = [1.0, 5.0] }", "usual.toml: the grid is empty"),
            (
                "settings = 9000000\nseed = 1\nranges = { box_mass_kg = [1.0, 5.0] }",
                "the grid has 18000000 runs, more than the 100000",
            ),
        ] {
            let message = refused(draw);
            assert!(message.contains(wanted) && message.lines().count() == 1, "{message}");
        }
    }
}

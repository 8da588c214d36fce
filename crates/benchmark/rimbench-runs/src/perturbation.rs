//! What nobody knows of a machine: its parameters are off by drawn factors.

use rimbench_cases::parameter::{Parameter, Parameters, Value};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::Belief;
use rimbench_core::parts::Parts;
use rimbench_statistics::latin_hypercube;
use sha2::{Digest, Sha256};
use std::fmt;
use std::str::FromStr;

/// Units of masses, inertias, stiffnesses, compliances, dampings, and the compressibility of oil.
const UNITS: [&str; 6] = ["kg", "kg·m²", "N/m", "m/N", "N·s/m", "1/Pa"];

/// Factors by which a machine is off: it is simulated with them, and held against the reference without; or its
/// interface model alone is off by them.
///
/// ```text
/// p̂_i = p_i (1 + x (2 u_i − 1))        u_i uniform in [0, 1), drawn by the seed for this case and these parameters
/// ```
/// They are of masses, inertias, stiffnesses, compliances, dampings, the compressibility of oil, friction and gaps. A
/// model has one factor of mass, one of friction, and one distance that is added to every gap: those of the first
/// parameter of the kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perturbation {
    /// x.
    within: f64,
    seed: u64,
    /// Whether the model alone is off.
    of_model: bool,
}

impl Perturbation {
    /// Whether the machine itself is off.
    pub(super) fn is_of_machine(&self) -> bool {
        !self.of_model
    }

    /// What is not known of a machine, each with its value and its factor.
    fn factors<'p>(&self, of: &'p Parameters) -> Vec<(&'p Parameter, f64, f64)> {
        let unknown = |parameter: &Parameter| {
            UNITS.contains(&&*parameter.unit) || *parameter.name == *"friction" || parameter.is_gap
        };
        let unknown: Vec<_> = of
            .iter()
            .filter_map(|(parameter, value)| match value {
                Value::Number(value) if *value != 0.0 && unknown(parameter) => Some((parameter, *value)),
                _ => None,
            })
            .collect();
        let hash = Sha256::digest(format!("{} {}\n{}", self.seed, of.case(), of.text()));
        let seed = hash[..8].iter().fold(0_u64, |seed, &byte| seed << 8 | u64::from(byte));
        let drawn = latin_hypercube(1, unknown.len(), seed).swap_remove(0);
        let factor = |u: f64| 1.0 + self.within * (2.0 * u - 1.0);
        unknown.into_iter().zip(drawn).map(|((parameter, value), u)| (parameter, value, factor(u))).collect()
    }

    /// The parameters of the machine that is simulated in place of this one.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a value that is not valid.
    pub(super) fn machine(&self, of: &Parameters) -> Result<Parameters> {
        let mut off = of.clone();
        for (parameter, value, factor) in self.factors(of) {
            off.set(&parameter.name, &format!("{:?}", value * factor))?;
        }
        Ok(off)
    }

    /// What an interface model of the machine believes; none where the machine itself is off.
    pub(super) fn belief(&self, of: &Parameters) -> Option<Belief> {
        let factors = self.of_model.then(|| self.factors(of))?;
        let first = |is: &dyn Fn(&Parameter) -> bool| factors.iter().find(|(parameter, ..)| is(parameter));
        let factor = |found: Option<&(_, f64, f64)>| found.map_or(1.0, |(_, _, factor)| *factor);
        let gap = first(&|of| of.is_gap);
        Some(Belief {
            mass: factor(first(&|of| *of.unit == *"kg")),
            friction: factor(first(&|of| of.name == "friction")),
            gap: gap.map_or(0.0, |(_, value, factor)| value.abs() * (factor - 1.0)),
            ..Belief::default()
        })
    }
}

impl fmt::Display for Perturbation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Perturbation { within, seed, of_model } = self;
        write!(f, "within:{within:?},seed:{seed}{}", if *of_model { ",of:model" } else { "" })
    }
}

impl FromStr for Perturbation {
    type Err = Error;

    /// Reads `within=X,seed=S,of=machine`, each part at most once and in any order.
    fn from_str(text: &str) -> Result<Self> {
        let parts = Parts::of("perturbation", text, ["within", "seed", "of"])?;
        let (mut within, mut seed, mut of) = (f64::NAN, 1, "machine".to_owned());
        let share = "a share above 0 and below 1 by which parameters may be off, as in `within=0.1`";
        parts.read("within", &mut within, |_| true, share)?;
        if !(within > 0.0 && within < 1.0) {
            return Err(parts.refused(share));
        }
        parts.read("seed", &mut seed, |_| true, "what the draw starts from, a whole number, as in `seed=1`")?;
        parts.read(
            "of",
            &mut of,
            |of| ["machine", "model"].contains(&&**of),
            "what is off, `of=machine` or `of=model`",
        )?;
        Ok(Perturbation { within, seed, of_model: of == "model" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RunRequest;
    use crate::catalogue::Catalogue;

    #[test]
    fn a_perturbation_is_written_as_it_is_read_and_nonsense_is_refused() {
        for text in ["within:0.1,seed:3", "within:0.5,seed:1,of:model"] {
            assert_eq!(text.parse::<Perturbation>().unwrap().to_string(), text);
        }
        for (text, word) in [("seed=1", "above 0"), ("within=1", "below 1"), ("within=0.1,of=oil", "of=machine")] {
            assert!(text.parse::<Perturbation>().unwrap_err().to_string().contains(word), "{text}");
        }
    }

    #[test]
    fn what_is_off_is_off_within_its_share_for_each_machine_anew_and_the_model_by_the_same_draw() {
        let catalogue = Catalogue::standard();
        let resolved = |mass: &str, of: &str| {
            let mut request = RunRequest::of("wedge-box-friction", "rim-nonsmooth-gap");
            request.set.push(("box_mass_kg".to_owned(), mass.to_owned()));
            request.put("perturbation", &format!("within=0.1,seed=2,of={of}")).unwrap();
            request.resolve(&catalogue).unwrap()
        };
        let spec = resolved("150", "machine");
        let off = spec.perturbation.unwrap().machine(&spec.parameters).unwrap();
        let ratio = |name: &str| off.setting::<f64>(name).unwrap() / spec.parameters.setting::<f64>(name).unwrap();
        let unknown = ["box_mass_kg", "disc_mass_kg", "friction", "ledge_lead_m", "compressibility_a_1_pa"];
        assert!(unknown.into_iter().all(|name| (ratio(name) - 1.0).abs() <= 0.1 && ratio(name) != 1.0));
        assert!(["box_width_m", "gravity_m_s2", "stabilisation"].into_iter().all(|name| ratio(name) == 1.0));
        let belief = resolved("150", "model").belief.clone().unwrap();
        let masses = [belief.mass, belief.friction].map(|factor| (1e9 * factor).round());
        assert_eq!(masses, ["box_mass_kg", "friction"].map(|name| (1e9 * ratio(name)).round()));
        assert!(spec.belief.is_none() && belief.gap != 0.0);
        assert_ne!(resolved("151", "model").belief, Some(belief));
    }
}

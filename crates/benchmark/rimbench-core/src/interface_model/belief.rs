//! An interface model that is wrong: what a scheme believes of a mechanics that it does not know exactly.

use super::reduced_interface_model::ReducedInterfaceModel;
use crate::error::{Error, Result};
use crate::parts::Parts;
use std::fmt;
use std::str::FromStr;

/// A gap that no motion closes, m.
const FAR: f64 = 1e6;

/// By how much an interface model differs from the mechanics, which stays as it is.
///
/// ```text
/// mass ρ        H ← H/ρ, accelerations a as they are: every mass and inertia ρ times as large, under its weight and what grows with it
/// friction f    μ ← f μ            gap g    gaps g ← g + δ (m)            missing c, closed c    contact c never closes, or is closed
/// ```
/// A model with ρ ≤ 1 is no heavier than the mechanics in any direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// ρ.
    pub mass: f64,
    /// Factor of each coefficient of friction.
    pub friction: f64,
    /// Added to every gap, m.
    pub gap: f64,
    /// A contact that the model lacks.
    pub missing: Option<usize>,
    /// A contact that the model has closed.
    pub closed: Option<usize>,
}

impl Default for Belief {
    fn default() -> Self {
        Belief { mass: 1.0, friction: 1.0, gap: 0.0, missing: None, closed: None }
    }
}

impl Belief {
    /// Makes a true model into what is believed.
    pub(crate) fn distort(&self, model: &mut ReducedInterfaceModel) {
        model.h.iter_mut().for_each(|entry| *entry /= self.mass);
        model.friction.iter_mut().for_each(|friction| *friction *= self.friction);
        model.gap.iter_mut().for_each(|gap| *gap += self.gap);
        if let Some(contact) = self.missing {
            (model.gap[contact], model.at_bound[contact]) = (FAR, false);
        }
        if let Some(contact) = self.closed {
            (model.gap[contact], model.at_bound[contact]) = (0.0, true);
        }
    }

    /// Checks that the model has the contacts and the friction that are wrong.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a contact that there is not; [`Error::Incompatible`] for friction where there is
    /// none, and for a model whose matrices keep their non-zeros only.
    pub fn check_model(&self, model: &ReducedInterfaceModel) -> Result<()> {
        let contacts = if model.has_targets { 0 } else { model.contacts() };
        for (what, contact) in [("missing", self.missing), ("closed", self.closed)] {
            if let Some(contact) = contact.filter(|contact| *contact >= contacts) {
                let expected = match contacts {
                    0 => "none of the two: the model has no contact".to_owned(),
                    1 => format!("{what}:0, the only contact of the model"),
                    _ => format!("a contact of the model, from {what}:0 to {what}:{}", contacts - 1),
                };
                return Err(Error::invalid("belief", format!("{what}:{contact}"), expected));
            }
        }
        if self.friction != 1.0 && !model.has_friction() {
            return Err(Error::Incompatible("belief friction: the mechanics has no friction".to_owned()));
        }
        if model.delassus_pattern().is_some() {
            return Err(Error::Incompatible("belief: a model with contacts by the dozen is taken as it is".to_owned()));
        }
        Ok(())
    }
}

impl fmt::Display for Belief {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Belief { mass, friction, gap, missing, closed } = self;
        write!(f, "mass:{mass:?}")?;
        if *friction != 1.0 {
            write!(f, ",friction:{friction:?}")?;
        }
        if *gap != 0.0 {
            write!(f, ",gap:{gap:?}")?;
        }
        for (what, contact) in [("missing", missing), ("closed", closed)] {
            if let Some(contact) = contact {
                write!(f, ",{what}:{contact}")?;
            }
        }
        Ok(())
    }
}

impl FromStr for Belief {
    type Err = Error;

    /// Reads `mass=RHO,friction=F,gap=M,missing=C,closed=C`, each part at most once and in any order.
    fn from_str(text: &str) -> Result<Self> {
        let mut belief = Belief::default();
        let parts = Parts::of("belief", text, ["mass", "friction", "gap", "missing", "closed"])?;
        let factor = "a factor of mass above 0, as in `mass=1.2`";
        parts.read("mass", &mut belief.mass, |mass| mass.is_finite() && *mass > 0.0, factor)?;
        let factor = "a factor of friction from 0, as in `friction=0.8`";
        parts.read("friction", &mut belief.friction, |factor| factor.is_finite() && *factor >= 0.0, factor)?;
        parts.read("gap", &mut belief.gap, |gap| gap.is_finite(), "metres added to every gap, as in `gap=1e-4`")?;
        for (key, place) in [("missing", &mut belief.missing), ("closed", &mut belief.closed)] {
            let mut contact = 0;
            parts.read(key, &mut contact, |_| true, "the index of a contact from 0, as in `missing=1`")?;
            *place = parts.get(key).map(|_| contact);
        }
        Ok(belief)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_belief_is_written_as_it_is_read_and_nonsense_is_refused() {
        for text in ["mass:1.2", "mass:1.0,friction:0.8,gap:-0.0001,missing:2,closed:0"] {
            assert_eq!(text.parse::<Belief>().unwrap().to_string(), text);
        }
        let refused = |text: &str| text.parse::<Belief>().unwrap_err().to_string();
        assert!(refused("mass:0").contains("above 0"));
        assert!(refused("mas:1").contains("did you mean `mass`"));
        assert!(refused("gap:inf").contains("metres"));
        assert!(refused("mass:1,mass:1").contains("at most once"));
    }

    #[test]
    fn a_wrong_model_differs_in_what_is_believed_and_nothing_else() {
        let mut model = ReducedInterfaceModel::zeros_with_friction(&[0.5, 0.4], 1);
        model.h.fill(2.0);
        model.a.fill(3.0);
        let belief: Belief = "mass:2,friction:0.5,gap:0.25,missing:1".parse().unwrap();
        belief.check_model(&model).unwrap();
        belief.distort(&mut model);
        assert!(model.h.iter().all(|entry| *entry == 1.0) && model.a.iter().all(|a| *a == 3.0));
        assert_eq!((model.friction, model.gap), (vec![0.25, 0.2], vec![0.25, FAR]));
        let none = ReducedInterfaceModel::zeros(1, 1);
        assert!(belief.check_model(&none).unwrap_err().to_string().contains("missing:0, the only contact"));
    }
}

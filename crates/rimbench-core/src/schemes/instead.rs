//! Names of schemes that are gone, and which scheme to take instead.

use crate::error::Error;

const INSTEAD: [(&str, &str); 9] = [
    ("adaptive-order-hold", "second-order-hold"),
    ("c1-extrapolated-interpolation-quadratic", "c1-extrapolated-interpolation"),
    ("energy-input-correction", "energy-leak-damper"),
    ("integral-correction-linear", "integral-correction-first-order"),
    ("iterated-quasi-newton", "iterated-aitken"),
    ("nepce-feedthrough", "nepce"),
    ("relaxed-hold", "nepce"),
    ("relaxed-prediction", "true-acceleration"),
    ("true-acceleration-linear", "true-acceleration"),
];

/// What to answer to the name of a scheme that is gone.
pub fn instead_of(name: &str) -> Option<Error> {
    let (_, instead) = INSTEAD.iter().find(|(gone, _)| *gone == name)?;
    Some(Error::Incompatible(format!("scheme `{name}` is gone: use `{instead}`")))
}

#[cfg(test)]
mod tests {
    use super::super::standard_schemes;
    use super::*;

    #[test]
    fn what_is_gone_is_in_no_list_and_what_to_take_instead_is() {
        let known = |name: &str| standard_schemes().iter().any(|scheme| scheme.name == name);
        for (gone, instead) in INSTEAD {
            assert!(!known(gone) && known(instead), "{gone}, {instead}");
        }
        assert_eq!(
            instead_of("relaxed-prediction").unwrap().to_string(),
            "scheme `relaxed-prediction` is gone: use `true-acceleration`"
        );
        assert!(instead_of("nepce").is_none());
    }
}

//! Options are read as they are written, and nonsense is refused with what would be valid.

use crate::support::*;
use std::fmt::{Debug, Display};
use std::str::FromStr;

/// Each value is read from what it is written as, and each text refused in these words.
fn assert_read<T>(values: impl IntoIterator<Item = T>, refused: &[(&str, &str)])
where
    T: FromStr<Err = rimbench::error::Error> + Display + PartialEq + Debug,
{
    for value in values {
        assert_eq!(value.to_string().parse::<T>().unwrap(), value);
    }
    for (text, wanted) in refused {
        let message = text.parse::<T>().unwrap_err().to_string();
        assert!(message.contains(wanted), "{text}: {message}");
    }
}

#[test]
fn options_are_read_as_they_are_written_and_nonsense_is_refused() {
    let margins = [0.0, 1e-6, 1e-3].map(|width| ContactDetection::Margin { width });
    assert_read(
        [ContactDetection::Active, ContactDetection::MechanicsLaw].into_iter().chain(margins),
        &[
            ("margin:-1e-3", "not below 0"),
            ("margin:inf", "not below 0"),
            ("margin:wide", "not below 0"),
            ("margin", "valid: active"),
            ("mechanics-lw", "did you mean `mechanics-law`"),
        ],
    );
    assert_read(
        [FrictionRows::Cone, FrictionRows::SlipDirection],
        &[("slip-directions", "did you mean `slip-direction`"), ("facets", "unknown friction rows")],
    );
    assert_read(
        [ContactsAct::MicroStep, ContactsAct::MechanicsStep],
        &[("mechanic-step", "did you mean `mechanics-step`"), ("step", "unknown step over which contacts act")],
    );
    let steps = ["0", "-1", "1.5", "1000001", "some", ""].map(|text| (text, "from 1 to 1000000, or `all`"));
    assert_read([ONE, ALL], &steps);
    assert_eq!([ONE, ALL].map(|steps| steps.to_string()), ["1", "all"]);
    assert_read(
        MechanicsIntegrator::ALL.map(|(_, value)| value),
        &[("event", "mechanics_integrator"), ("event", "event-split")],
    );
    assert_read(ActuatorIntegrator::ALL.map(|(_, value)| value), &[]);
    assert_read(ForceReturn::ALL.map(|(_, value)| value), &[("meen", "did you mean `mean`")]);
    // Only an actuator that went first can return more than the held force.
    assert!(ForceReturn::Mean.check(Sequence::Jacobi).is_err());
    assert!(ForceReturn::Mean.check(Sequence::GaussSeidel { first: Side::Mechanics }).is_err());
    assert!(ForceReturn::Held.check(Sequence::Jacobi).is_ok());
}

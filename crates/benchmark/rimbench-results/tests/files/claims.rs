//! How claims are shown.

use rimbench_results::claims::{digits_apart, digits_of};

#[test]
fn a_value_has_as_many_digits_as_tell_it_from_its_bound() {
    for (value, bound, digits) in [
        (0.895_240_19, 0.9, 3),
        (0.5, 0.9, 2),
        (0.9, 0.9, 2),
        (0.899_999_9, 0.9, 7),
        (-1.000_4, -1.0, 5),
        (1e9, 0.9, 2),
        (f64::INFINITY, 0.9, 2),
        (f64::NAN, 0.9, 2),
        (0.949, 0.95, 3),
        (0.994_9, 0.995, 2),
    ] {
        assert_eq!(digits_apart(value, bound, 2), digits, "{value} beside {bound}");
    }
    assert_eq!([0.995, 100.0, 2e-5, 1.0].map(digits_of), [3, 1, 1, 1]);
}

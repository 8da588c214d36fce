//! Refuses what would not fit into memory, before any of it is taken.

use super::parameters::Parameters;
use super::values::{Range, Setting};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::MEMORY_LIMIT as LIMIT;
use rimbench_core::mechanics::ModelSize;

const GIB: f64 = (1_u64 << 30) as f64;

/// Refuses a case whose mechanics and scheme need more than the limit, naming the parameters that set its size.
///
/// # Errors
/// [`Error::InvalidValue`] with the bytes needed and the limit.
pub(super) fn must_hold(bytes: u64, size: ModelSize, parameters: &Parameters) -> Result<()> {
    if bytes <= LIMIT {
        return Ok(());
    }
    let counts = parameters.iter().filter(|(parameter, _)| matches!(parameter.range, Range::Whole(..)));
    let count = |value| u32::of(value).map_or_else(String::new, |count| count.to_string());
    let (keys, values): (Vec<&str>, Vec<String>) =
        counts.map(|(parameter, value)| (&*parameter.name, count(value))).unzip();
    let ModelSize { unilateral: contacts, bilateral: joints, .. } = size;
    let joints = if joints == 0 { String::new() } else { format!(" and {joints} joints") };
    Err(Error::invalid(
        format!("{}: {}", parameters.case(), keys.join(", ")),
        values.join(", "),
        format!(
            "what fits into {:.1} GiB, where these {contacts} contacts{joints} need up to {:.1} GiB with the solver that was asked for \
             and what is kept of their matrices",
            LIMIT as f64 / GIB,
            bytes as f64 / GIB
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::Catalogue;
    use rimbench_core::solver_entry::SolverEntry;

    #[test]
    fn a_case_beyond_memory_is_refused_with_what_it_needs_and_the_limit() {
        let catalogue = Catalogue::standard();
        let case = catalogue.case("disc-row").unwrap();
        let mut parameters = case.default_parameters();
        parameters.set("discs", "2500").unwrap();
        // Every entry is kept: at least the 5002² of one matrix, 0.19 GiB, a score of times.
        let Err(Error::InvalidValue { key, found, expected }) = (case.build)(&parameters, &SolverEntry::lemke()) else {
            panic!("5001 contacts with every entry kept are refused");
        };
        assert_eq!((key.as_str(), found.as_str()), ("disc-row: discs", "2500"));
        assert!(expected.contains("4.0 GiB") && expected.contains("5001 contacts"), "{expected}");
        let size = ModelSize { velocities: 2501, unilateral: 5001, interface: 1, ..ModelSize::default() };
        assert!(must_hold(LIMIT, size, &parameters).is_ok() && must_hold(LIMIT + 1, size, &parameters).is_err());
    }
}

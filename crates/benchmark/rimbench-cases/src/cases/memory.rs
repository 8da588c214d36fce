//! Refuses what would not fit into memory, before any of it is taken.

use crate::parameter::{Parameters, Range, Setting};
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

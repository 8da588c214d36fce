//! Distance from the reference inside macro steps: what the actuator did, and what it was told of the motion, micro step by micro
//! step.
//!
//! At communication points a scheme has just been told the truth. Between them it guesses, and that is where the actuator's state
//! goes astray.

use super::accuracy::{rms, worst};
use super::evidence::{Evidence, Inside, metrics};

metrics! {
    FORCE_ERROR_INSIDE: "force_error_inside_rms_n" in "N" above super::FORCE_FLOOR,
    "Root mean square over micro steps, inside macro steps as well, of the actuator's own force minus the reference's"
    => |evidence| {
        let inside = evidence.inside?;
        worst(evidence, |row| error(inside, name(evidence, row.force), 0))
    };

    POSITION_ERROR_INSIDE: "position_error_inside_rms_m" in "m" above super::POSITION_FLOOR,
    "Root mean square over micro steps of the interface position that the actuator was given minus the reference's"
    => |evidence| {
        let inside = evidence.inside?;
        worst(evidence, |row| error(inside, name(evidence, row.position), 1))
    };
}

fn name<'a>(evidence: &'a Evidence<'_>, column: usize) -> &'a str {
    &evidence.run.columns()[column]
}

/// Of what the actuator's log calls `column`, against the reference at the times in its column `time`; none where the coupling
/// exchanges something else.
fn error(inside: &Inside, column: &str, time: usize) -> Option<f64> {
    let (own, reference) = (inside.log.index_of(column)?, &inside.reference[time]);
    let exact = reference.index_of(column)?;
    rms(inside.log.column(own).zip(reference.column(exact)).map(|(own, exact)| own - exact))
}

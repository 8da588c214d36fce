//! Distance from the reference at the communication points of the run.
//!
//! An interface of several rows is as accurate as its worst row: each metric is taken row by row, and the largest
//! magnitude counts. A sum over rows would hide one bad row behind many good ones.

use super::evidence::{Evidence, metrics};
use super::sums::{InterfaceRow, OfInterface};

metrics! {
    FORCE_ERROR_RMS: "force_error_rms_n" in "N" above super::Floor::Force,
    "Root mean square over communication points of the actuator's own force minus the reference's"
    => |evidence| worst(evidence, |_, sums| sums.force.rms());

    FORCE_ERROR_L1: "force_error_l1_n" in "N" above super::Floor::Force,
    "Mean over communication points of the magnitude of the actuator's own force minus the reference's: of an impact that \
     comes late by Δt it counts Δt, where the rms counts its root"
    => |evidence| worst(evidence, |_, sums| sums.force.mean());

    FORCE_ERROR_MAX: "force_error_max_n" in "N" above super::Floor::Force,
    "Largest difference of the actuator's own force from the reference's at a communication point"
    => |evidence| worst(evidence, |_, sums| sums.force.largest());

    FORCE_ERROR_OF_PEAK: "force_error_rms_of_peak" in "-" above super::Floor::ShareOfPeak,
    "Rms force error as a fraction of the reference's largest force magnitude; empty where there is no force to speak of"
    => |evidence| worst(evidence, |row, sums| Some(sums.force.rms()? / row.reference_force_peak?));

    FORCE_ERROR_OF_EVENT: "force_error_rms_of_event_peak" in "-" above super::Floor::ShareOfPeak,
    "Rms force error as a fraction of the reference's largest force magnitude within 0.1 s of a contact that closes; where none does, \
     or without force to speak of there, of its largest"
    => |evidence| {
        worst(evidence, |row, sums| Some(sums.force.rms()? / row.reference_touch_down_peak.or(row.reference_force_peak)?))
    };

    FORCE_ERROR_AFTER: "force_error_after_1s_of_peak" in "-" of Claimed above super::Floor::ShareOfPeak,
    "Rms force error from 1 s on as a fraction of the reference's largest force magnitude"
    => |evidence| worst(evidence, |row, sums| Some(sums.settled.rms()? / row.reference_force_peak?));

    COUPLING_DISTANCE: "coupling_distance_rms_n" in "N" of Divided,
    "Root mean square over communication points of the actuator's own force minus that of the run's centre, the own-step \
     model asked anew at every own step of the mechanics; of the row with the largest error"
    => |evidence| divided(evidence)?.parts[0].rms();

    MECHANICS_DISTANCE: "mechanics_distance_rms_n" in "N" of Divided,
    "The same of the force of the run's centre minus the reference's: what the mechanics' own step is wrong by"
    => |evidence| divided(evidence)?.parts[1].rms();

    COUPLING_SHARE: "coupling_share" in "-" (signed) of Divided,
    "Share of the squared force error that is the coupling's, by projection; the rest is the mechanics' own step's. Outside 0 to 1 the \
     two cancel in part"
    => |evidence| divided(evidence)?.coupling_share();

    FORCE_PEAK: "force_peak_n" in "N",
    "Largest magnitude of the actuator's own force"
    => |evidence| worst(evidence, |_, sums| sums.force_peak);

    TOUCH_DOWN_PEAK_RATIO: "touch_down_peak_ratio" in "-" (ideal_one),
    "Largest force magnitude within 0.1 s of a contact that closes in the reference, over that of the reference there"
    => |evidence| worst(evidence, |row, sums| Some(sums.near.0? / row.reference_touch_down_peak?));

    TOUCH_DOWN_SHOWN: "reference_touch_down_peak_ratio" in "-" (ideal_one) of Claimed,
    "The same of the reference at the communication points of the run: what of its peak can be seen there at all"
    => |evidence| worst(evidence, |row, sums| Some(sums.near.1? / row.reference_touch_down_peak?));

    TOUCH_DOWN_ERROR: "touch_down_error_rms_of_peak" in "-" of Claimed,
    "Rms force error within 0.1 s of a contact that closes in the reference, as a fraction of the largest force magnitude of the reference there"
    => |evidence| worst(evidence, |row, sums| Some(sums.near.2.rms()? / row.reference_touch_down_peak?));

    TOUCH_DOWN_PRESSURE: "touch_down_pressure_max_pa" in "Pa" of Claimed,
    "Largest pressure of the first chamber within 0.1 s of a contact that closes in the reference"
    => |evidence| evidence.sums.pressure_near;

    VELOCITY_END: "velocity_end_m_s" in "m/s" of Claimed,
    "Interface velocity at the last communication point reached"
    => |evidence| worst(evidence, |_, sums| sums.last_velocity);

    VELOCITY_ERROR_RMS: "velocity_error_rms_m_s" in "m/s",
    "Root mean square of the interface velocity minus the reference's"
    => |evidence| worst(evidence, |_, sums| sums.velocity.rms());

    POSITION_ERROR_RMS: "position_error_rms_m" in "m" above super::Floor::Position,
    "Root mean square of the interface position minus the reference's"
    => |evidence| worst(evidence, |_, sums| sums.position.rms());

    POSITION_ERROR_ALIGNED: "position_error_aligned_rms_m" in "m" of Claimed above super::Floor::Position,
    "The same with the run's position read half a step of the mechanics back, s − ½ h w, where the mechanics steps semi-implicitly: \
     there the positions of that rule are those of the communication point, if the force is that of the step"
    => |evidence| worst(evidence, |_, sums| sums.aligned.rms());

    POSITION_ERROR_END: "position_error_end_m" in "m" (signed) above super::Floor::Position,
    "Interface position minus the reference's at the last communication point reached"
    => |evidence| worst(evidence, |_, sums| sums.position.last());
}

/// The row with the largest force error, if all of it is divided.
fn divided<'a>(evidence: &'a Evidence<'_>) -> Option<&'a OfInterface> {
    let rms = |row: &OfInterface| row.force.rms().unwrap_or(0.0);
    let worst = evidence.sums.interface.iter().max_by(|a, b| rms(a).total_cmp(&rms(b)));
    worst.filter(|row| row.coupling_share().is_some())
}

/// The value of largest magnitude over the rows of the interface, with its sign; NaN wins.
pub(super) fn worst(
    evidence: &Evidence<'_>,
    of_row: impl Fn(&InterfaceRow, &OfInterface) -> Option<f64>,
) -> Option<f64> {
    let larger = |a: f64, b: f64| if b.is_nan() || b.abs() > a.abs() { b } else { a };
    let rows = evidence.sums.columns.interface.iter().zip(&evidence.sums.interface);
    rows.filter_map(|(row, sums)| of_row(row, sums)).reduce(larger)
}

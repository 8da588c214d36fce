//! Distance from the reference at the communication points of the run.
//!
//! An interface of several rows is as accurate as its worst row: each metric is taken row by row, and the largest magnitude
//! counts. A sum over rows would hide one bad row behind many good ones.

use super::evidence::{Evidence, InterfaceRow, metrics};

metrics! {
    FORCE_ERROR_RMS: "force_error_rms_n" in "N" above super::FORCE_FLOOR,
    "Root mean square over communication points of the actuator's own force minus the reference's"
    => |evidence| worst(evidence, |row| rms_error(evidence, row.force));

    FORCE_ERROR_L1: "force_error_l1_n" in "N" above super::FORCE_FLOOR,
    "Mean over communication points of the magnitude of the actuator's own force minus the reference's: of an impact that \
     comes late by Δt it counts Δt, where the rms counts its root"
    => |evidence| {
        worst(evidence, |row| {
            let errors = evidence.pairs(row.force).map(|(own, reference)| (own - reference).abs());
            let (sum, count) = errors.fold((0.0, 0_usize), |(sum, count), error| (sum + error, count + 1));
            (count > 0).then(|| sum / count as f64)
        })
    };

    FORCE_ERROR_MAX: "force_error_max_n" in "N" above super::FORCE_FLOOR,
    "Largest difference of the actuator's own force from the reference's at a communication point"
    => |evidence| {
        worst(evidence, |row| {
            evidence.pairs(row.force).map(|(own, reference)| (own - reference).abs()).reduce(f64::max)
        })
    };

    FORCE_ERROR_OF_PEAK: "force_error_rms_of_peak" in "-" above super::SHARE_FLOOR,
    "Rms force error as a fraction of the reference's largest force magnitude; empty where there is no force to speak of"
    => |evidence| worst(evidence, |row| Some(rms_error(evidence, row.force)? / row.reference_force_peak?));

    FORCE_ERROR_AFTER: "force_error_after_1s_of_peak" in "-" of Claimed above super::SHARE_FLOOR,
    "Rms force error from 1 s on as a fraction of the reference's largest force magnitude"
    => |evidence| {
        worst(evidence, |row| {
            let late = evidence.run.column(0).zip(evidence.pairs(row.force)).filter(|(t, _)| *t >= SETTLED_S);
            Some(rms(late.map(|(_, (own, reference))| own - reference))? / row.reference_force_peak?)
        })
    };

    FORCE_PEAK: "force_peak_n" in "N",
    "Largest magnitude of the actuator's own force"
    => |evidence| worst(evidence, |row| peak(evidence.run.column(row.force)));

    TOUCH_DOWN_PEAK_RATIO: "touch_down_peak_ratio" in "-" (ideal_one),
    "Largest force magnitude within 0.1 s of a contact that closes in the reference, over that of the reference there"
    => |evidence| {
        worst(evidence, |row| {
            let rows = evidence.run.rows().filter(|values| is_near(evidence, values[0]));
            Some(peak(rows.map(|values| values[row.force]))? / row.reference_touch_down_peak?)
        })
    };

    TOUCH_DOWN_SHOWN: "reference_touch_down_peak_ratio" in "-" (ideal_one) of Claimed,
    "The same of the reference at the communication points of the run: what of its peak can be seen there at all"
    => |evidence| {
        worst(evidence, |row| {
            let exact = row.reference_touch_down_peak?;
            let near = evidence.run.column(0).zip(evidence.pairs(row.force)).filter(|(t, _)| is_near(evidence, *t));
            Some(peak(near.map(|(_, (_, reference))| reference))? / exact)
        })
    };

    TOUCH_DOWN_ERROR: "touch_down_error_rms_of_peak" in "-" of Claimed,
    "Rms force error within 0.1 s of a contact that closes in the reference, as a fraction of the largest force magnitude of the reference there"
    => |evidence| {
        worst(evidence, |row| {
            let exact = row.reference_touch_down_peak?;
            let near = evidence.run.column(0).zip(evidence.pairs(row.force)).filter(|(t, _)| is_near(evidence, *t));
            Some(rms(near.map(|(_, (own, reference))| own - reference))? / exact)
        })
    };

    TOUCH_DOWN_PRESSURE: "touch_down_pressure_max_pa" in "Pa" of Claimed,
    "Largest pressure of the first chamber within 0.1 s of a contact that closes in the reference"
    => |evidence| {
        let pressure = evidence.run.column(evidence.run.index_of("pressure_1_pa")?);
        let near = evidence.run.column(0).zip(pressure).filter(|(t, _)| is_near(evidence, *t));
        peak(near.map(|(_, pressure)| pressure))
    };

    VELOCITY_END: "velocity_end_m_s" in "m/s" of Claimed,
    "Interface velocity at the last communication point reached"
    => |evidence| worst(evidence, |row| evidence.run.column(row.velocity).last());

    VELOCITY_ERROR_RMS: "velocity_error_rms_m_s" in "m/s",
    "Root mean square of the interface velocity minus the reference's"
    => |evidence| worst(evidence, |row| rms_error(evidence, row.velocity));

    POSITION_ERROR_RMS: "position_error_rms_m" in "m" above super::POSITION_FLOOR,
    "Root mean square of the interface position minus the reference's"
    => |evidence| worst(evidence, |row| rms_error(evidence, row.position));

    POSITION_ERROR_ALIGNED: "position_error_aligned_rms_m" in "m" of Claimed above super::POSITION_FLOOR,
    "The same with the run's position read half a step of the mechanics back, s − ½ h w, where the mechanics steps semi-implicitly: \
     there the positions of that rule are those of the communication point, if the force is that of the step"
    => |evidence| {
        worst(evidence, |row| {
            let back = evidence.half_steps.iter().zip(evidence.run.column(row.velocity)).map(|(half, w)| half * w);
            rms(evidence.pairs(row.position).zip(back).map(|((own, reference), back)| own - back - reference))
        })
    };

    POSITION_ERROR_END: "position_error_end_m" in "m" (signed) above super::POSITION_FLOOR,
    "Interface position minus the reference's at the last communication point reached"
    => |evidence| {
        worst(evidence, |row| evidence.pairs(row.position).last().map(|(own, reference)| own - reference))
    };
}

/// From here on what was wrong at the start may have been learned, s.
const SETTLED_S: f64 = 1.0;

/// Whether a touch-down of the reference shows at a time.
fn is_near(evidence: &Evidence<'_>, t: f64) -> bool {
    evidence.touch_downs.iter().any(|[from, to]| (*from..=*to).contains(&t))
}

/// The value of largest magnitude over the rows of the interface, with its sign; NaN wins.
pub(super) fn worst(evidence: &Evidence<'_>, of_row: impl Fn(&InterfaceRow) -> Option<f64>) -> Option<f64> {
    let larger = |a: f64, b: f64| if b.is_nan() || b.abs() > a.abs() { b } else { a };
    evidence.interface.iter().filter_map(of_row).reduce(larger)
}

fn rms_error(evidence: &Evidence<'_>, column: usize) -> Option<f64> {
    rms(evidence.pairs(column).map(|(own, reference)| own - reference))
}

pub(super) fn rms(errors: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = errors.fold((0.0, 0_usize), |(sum, count), error| (sum + error.powi(2), count + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

fn peak(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.map(f64::abs).reduce(f64::max)
}

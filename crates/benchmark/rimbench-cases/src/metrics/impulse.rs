//! Impulses over windows of fixed length: what an impact leaves behind, however its force is spread in time.

use super::evidence::{Evidence, metrics};

/// Length of the windows, s. *Ours*.
const WINDOW: f64 = 20e-3;

/// Name of the column of the reference that holds the running integral of a force column.
pub(crate) fn impulse_column(force: &str) -> String {
    format!("{force}_impulse_n_s")
}

metrics! {
    /// ```text
    /// e = max over windows [a, b] of |Σ λ_received Δt − ∫ λ_ref dt|        b: first communication point with b − a ≥ 20 ms
    /// ```
    /// The force that the mechanics receives is a mean over each macro step, so its impulse is exact.
    IMPULSE_ERROR: "impulse_error_20ms_n_s" in "N s",
    "Largest difference, over windows of 20 ms, of the impulse that the mechanics received from the reference's"
    => |evidence| {
        let columns = ["force_to_mechanics_n", "force_2_to_mechanics_n"];
        evidence
            .interface
            .iter()
            .zip(columns)
            .filter_map(|(row, received)| error(evidence, row.force, received))
            .reduce(f64::max)
    };
}

fn error(evidence: &Evidence<'_>, force: usize, received: &str) -> Option<f64> {
    let received = evidence.run.index_of(received)?;
    let impulse = evidence.reference.index_of(&impulse_column(&evidence.run.columns()[force]))?;
    let (mut delivered, mut last) = (0.0, evidence.run.rows().next()?[0]);
    let lags: Vec<(f64, f64)> = evidence
        .run
        .rows()
        .zip(evidence.reference.column(impulse))
        .map(|(row, reference)| {
            delivered += row[received] * (row[0] - last);
            last = row[0];
            (row[0], delivered - reference)
        })
        .collect();
    let (mut worst, mut from) = (None::<f64>, 0);
    for &(time, lag) in &lags {
        // The latest start that is a window away.
        while lags.get(from + 1).is_some_and(|start| time - start.0 >= WINDOW * (1.0 - 1e-9)) {
            from += 1;
        }
        if time - lags[from].0 >= WINDOW * (1.0 - 1e-9) {
            let error = (lag - lags[from].1).abs();
            worst = Some(worst.map_or(error, |worst| if error <= worst { worst } else { error }));
        }
    }
    worst
}

//! Impulses over windows of fixed length: what an impact leaves behind, however its force is spread in time.

use std::collections::VecDeque;

/// Length of the windows, s. *Ours*.
const WINDOW: f64 = 20e-3;

/// Name of the column of the reference that holds the running integral of a force column.
pub(crate) fn impulse_column(force: &str) -> String {
    format!("{force}_impulse_n_s")
}

/// Columns of the forces that the mechanics receives, of the first two rows of the interface.
pub(super) const RECEIVED: [&str; 2] = ["force_to_mechanics_n", "force_2_to_mechanics_n"];

/// The largest error so far, and the lags within the last window.
#[derive(Debug, Clone, Default)]
pub(super) struct ImpulseError {
    pub(super) worst: Option<f64>,
    delivered: f64,
    last: Option<f64>,
    /// Times and lags, from the latest that is a window away.
    lags: VecDeque<(f64, f64)>,
}

impl ImpulseError {
    /// Takes the force received over the step that ends at `time`, and the impulse of the reference up to then.
    pub(super) fn add(&mut self, time: f64, force: f64, reference: f64) {
        self.delivered += force * (time - self.last.unwrap_or(time));
        self.last = Some(time);
        let lag = self.delivered - reference;
        self.lags.push_back((time, lag));
        let is_window = |start: &(f64, f64)| time - start.0 >= WINDOW * (1.0 - 1e-9);
        while self.lags.get(1).is_some_and(is_window) {
            self.lags.pop_front();
        }
        if let Some((_, start)) = self.lags.front().filter(|start| is_window(start)) {
            let error = (lag - start).abs();
            self.worst = Some(self.worst.map_or(error, |worst| if error <= worst { worst } else { error }));
        }
    }
}

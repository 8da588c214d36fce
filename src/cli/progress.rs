//! What a command says while it works: a bar on a terminal, a plain line now and then elsewhere, all on the standard
//! error.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rimbench::cosim::OutcomeClass;
use rimbench::harness::Step;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two plain lines, s: rare enough for a log, often enough to see that something happens.
const BETWEEN_LINES_S: f64 = 10.0;

/// Whether nothing is said.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Says nothing from now on, or what there is to say.
pub(super) fn be_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// Says a line, unless nothing is to be said.
pub(super) fn say(line: &str) {
    if !QUIET.load(Ordering::Relaxed) {
        eprintln!("{line}");
    }
}

/// How far a number of runs has come: failures so far, and the time left where it is known how many there will be.
pub(super) struct Progress {
    state: Arc<Mutex<State>>,
    /// Says it in lines, where there is no terminal for a bar.
    lines: Mutex<Option<Heartbeat>>,
}

struct State {
    command: &'static str,
    total: Option<usize>,
    bar: ProgressBar,
    began: Instant,
    done: usize,
    failed: usize,
    no_answer: usize,
    about: String,
}

impl Progress {
    /// Begins with `total` runs to be done, if that is known.
    pub(super) fn begin(command: &'static str, total: Option<usize>) -> Self {
        let target =
            if QUIET.load(Ordering::Relaxed) { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(total.map(|total| total as u64), target);
        // One line of 80: what does not fit is left out.
        let style = match total {
            Some(_) => "{bar:20} {pos}/{len} runs, {elapsed} elapsed, {eta} left  {wide_msg}",
            None => "{spinner} {pos} runs, {elapsed} elapsed  {wide_msg}",
        };
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        let plain = bar.is_hidden();
        let state = State {
            command,
            total,
            bar,
            began: Instant::now(),
            done: 0,
            failed: 0,
            no_answer: 0,
            about: String::new(),
        };
        let state = Arc::new(Mutex::new(state));
        let shared = Arc::clone(&state);
        let lines = plain.then(|| {
            Heartbeat::lines(move |elapsed| shared.lock().unwrap_or_else(PoisonError::into_inner).line(elapsed))
        });
        Progress { state, lines: Mutex::new(lines) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Corrects the number of runs: what is stored already, or another's, is not to be done.
    pub(super) fn to_do(&self, total: usize) {
        let mut state = self.state();
        let total = total.max(state.done);
        state.total = Some(total);
        state.bar.set_length(total as u64);
    }

    /// Says what the runs that follow are about.
    pub(super) fn about(&self, text: impl Into<String>) {
        let mut state = self.state();
        state.about = text.into();
        state.bar.set_message(state.message());
    }

    /// One run is done.
    pub(super) fn done(&self, class: OutcomeClass) {
        let mut state = self.state();
        state.done += 1;
        state.bar.inc(1);
        match class {
            OutcomeClass::Completed => return,
            OutcomeClass::Failed => state.failed += 1,
            OutcomeClass::NoAnswer => state.no_answer += 1,
        }
        state.bar.set_message(state.message());
    }

    /// Counts a run that is done; how many there are is known before.
    pub(super) fn after(&self, step: Step) {
        if let Step::Done(class) = step {
            self.done(class);
        }
    }

    /// Says that a group of runs is done, where there is no bar to show it.
    pub(super) fn group_done(&self, text: &str) {
        if self.state().bar.is_hidden() {
            say(text);
        }
    }

    /// Takes the bar away.
    pub(super) fn end(&self) {
        drop(self.lines.lock().unwrap_or_else(PoisonError::into_inner).take());
        let state = self.state();
        state.bar.finish_and_clear();
        // Who saw lines go by sees where they ended.
        if state.bar.is_hidden() && state.began.elapsed().as_secs_f64() > BETWEEN_LINES_S {
            say(&state.line(state.began.elapsed().as_secs_f64()));
        }
    }
}

impl State {
    fn message(&self) -> String {
        let counted = |count: usize, what: &str| if count > 0 { format!("{count} {what}") } else { String::new() };
        let (failed, silent) = (counted(self.failed, "failed"), counted(self.no_answer, "without an answer"));
        [self.about.as_str(), &failed, &silent]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join(", ")
    }

    fn line(&self, elapsed: f64) -> String {
        let left = |total: usize| elapsed / self.done as f64 * total.saturating_sub(self.done) as f64;
        let left =
            self.total.filter(|_| self.done > 0).map(|total| format!(", about {} left", plain_time(left(total))));
        let left = left.unwrap_or_default();
        let message = self.message();
        let message = if message.is_empty() { message } else { format!(" ({message})") };
        let State { command, done, total, .. } = self;
        let of = total.map_or_else(String::new, |total| format!(" of {total}"));
        format!("{command}: {done}{of} runs{message}, {} elapsed{left}", plain_time(elapsed))
    }
}

/// Says every few seconds that a command without a known end is still at work, until it is dropped.
pub(super) struct Heartbeat {
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Heartbeat {
    /// Begins to say that a command is at work.
    pub(super) fn of(command: &'static str) -> Self {
        Self::lines(move |elapsed| format!("{command}: at work for {}", plain_time(elapsed)))
    }

    /// Begins to say what `line` makes of the time since, s.
    pub(super) fn lines(line: impl Fn(f64) -> String + Send + 'static) -> Self {
        Self::every(Duration::from_secs_f64(BETWEEN_LINES_S), move |elapsed| say(&line(elapsed)))
    }

    fn every(period: Duration, say: impl Fn(f64) + Send + 'static) -> Self {
        let (end, ended) = channel();
        let began = Instant::now();
        let thread = std::thread::spawn(move || {
            while ended.recv_timeout(period) == Err(RecvTimeoutError::Timeout) {
                say(began.elapsed().as_secs_f64());
            }
        });
        Heartbeat { end: Some(end), thread: Some(thread) }
    }
}

impl Drop for Heartbeat {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            // It says nothing more once this returns.
            let _ = thread.join();
        }
    }
}

/// A time for reading: `40 s`, `12 min`, `3.5 h`.
pub(super) fn plain_time(seconds: f64) -> String {
    match seconds {
        _ if seconds < 100.0 => format!("{seconds:.0} s"),
        _ if seconds < 6000.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_how_many_runs_are_done_how_many_failed_and_how_long_the_rest_will_take() {
        let state = |done, failed| State {
            command: "run",
            total: Some(100),
            bar: ProgressBar::hidden(),
            began: Instant::now(),
            done,
            failed,
            no_answer: failed / 3,
            about: String::new(),
        };
        assert_eq!(state(0, 0).line(30.0), "run: 0 of 100 runs, 30 s elapsed");
        assert_eq!(
            state(20, 3).line(10.0),
            "run: 20 of 100 runs (3 failed, 1 without an answer), 10 s elapsed, about 40 s left"
        );
        let unknown = State { total: None, ..state(20, 0) };
        assert_eq!(unknown.line(10.0), "run: 20 runs, 10 s elapsed");
        assert_eq!([0.4, 99.0, 150.0, 5400.0, 9000.0].map(plain_time), ["0 s", "99 s", "2 min", "90 min", "2.5 h"]);
    }

    #[test]
    fn what_is_stored_already_is_no_part_of_what_is_left() {
        let progress = Progress::begin("run", Some(100));
        progress.to_do(20);
        (0..10).for_each(|_| progress.done(OutcomeClass::Completed));
        let line = progress.state().line(10.0);
        progress.end();
        assert_eq!(line, "run: 10 of 20 runs, 10 s elapsed, about 10 s left");
    }

    #[test]
    fn a_heartbeat_is_heard_until_it_is_dropped() {
        let (heard, hears) = channel();
        let beat = Heartbeat::every(Duration::from_millis(1), move |elapsed| heard.send(elapsed).unwrap_or(()));
        assert!(hears.recv_timeout(Duration::from_secs(60)).is_ok());
        drop(beat);
        // Ends, because no sender is left.
        hears.iter().for_each(drop);
    }
}

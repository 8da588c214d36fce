//! How the outputs of a loaded FMU move, found by steps from a state to which it is set back.

use super::super::host::Probe;
use super::{FATAL, Keep, Loaded};
use std::ptr;

/// How many roundings of an output are taken for what its own arithmetic and that of differences may add up to.
const ROUNDINGS: f64 = 8.0;
/// Share of the largest velocity of a run below which velocities are not told apart: what holds an interface is solved
/// to some digits.
const HELD: f64 = 1e-9;

/// What probing needs, and what it has found.
#[derive(Default)]
pub(super) struct Probed {
    /// The state from which it goes out.
    pub(super) kept: Option<Keep>,
    /// Rates, feedthrough and rate gain by the longer steps, and by the shorter ones.
    coarse: Vec<f64>,
    fine: Vec<f64>,
    /// The largest magnitude that each output has had in this probe.
    magnitude: Vec<f64>,
    /// The largest velocity of any output of a mechanics since the run began, m/s.
    fastest: f64,
    input: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
}

impl Probed {
    /// How far the shorter steps' numbers are from the longer steps', of the largest of both in the same row of the
    /// same block (rates, feedthrough, rate gain); the worst row, and 1 at most. A number that is no more than what
    /// round-off alone may make of outputs of that size counts as 0.
    fn error(&self, probe: Probe, u: &[f64]) -> f64 {
        let (p, n) = (self.magnitude.len(), u.len());
        // Of the shorter steps, where round-off is most.
        let (step, change) = (0.5 * probe.step, |at: usize| 0.5 * probe.change_of(u[at]));
        let roundings = |row: usize| ROUNDINGS * f64::EPSILON * self.magnitude[row];
        let blocks = [
            (0, 1, &(|row, _| roundings(row) / step) as &dyn Fn(usize, usize) -> f64),
            (p, n, &|row, at| roundings(row) / change(at)),
            (p + p * n, n, &|row, at| roundings(row) / (step * change(at))),
        ];
        let mut worst = 0.0_f64;
        for (start, columns, floor) in blocks {
            for row in 0..p {
                let (mut apart, mut largest) = (0.0_f64, 0.0_f64);
                for at in 0..columns {
                    let entry = start + row * columns + at;
                    let (coarse, fine) = (self.coarse[entry], self.fine[entry]);
                    if !(coarse.is_finite() && fine.is_finite()) {
                        return 1.0;
                    }
                    let size = coarse.abs().max(fine.abs());
                    if size > floor(row, at) {
                        (apart, largest) = (apart.max((coarse - fine).abs()), largest.max(size));
                    }
                }
                if apart > 0.0 {
                    worst = worst.max(apart / largest);
                }
            }
        }
        worst.min(1.0)
    }

    /// Sets to 0 by how much a velocity, an output from `first` on, follows an input where the difference holds nothing
    /// but round-off: an interface that contacts hold stands still under any force.
    fn clear_round_off(&mut self, probe: Probe, first: usize, u: &[f64]) {
        let (p, n) = (self.magnitude.len(), u.len());
        let [position, velocity] =
            [&self.magnitude[..first], &self.magnitude[first..]].map(|of| of.iter().copied().fold(0.0, f64::max));
        self.fastest = self.fastest.max(velocity);
        // A velocity may itself be a difference of positions over the step.
        let floor = (HELD * self.fastest).max(ROUNDINGS * f64::EPSILON * (velocity + position / probe.step));
        for row in first..p {
            for (at, u) in u.iter().enumerate() {
                let gain = &mut self.fine[p + p * n + row * n + at];
                if gain.abs() * probe.step * 2.0 * probe.change_of(*u) <= floor {
                    *gain = 0.0;
                }
            }
        }
    }
}

impl Loaded {
    /// Appends rates, feedthrough and rate gain as steps from here show them, and their relative error; the state is
    /// what it was afterwards, with inputs `u`.
    ///
    /// ```text
    /// r = (y(t + δ) − y(t))/δ         inputs held
    /// D = (y(u + Δ) − y(u − Δ))/2Δ    at once
    /// R = (r(u + Δ) − r(u − Δ))/2Δ    each from the same state
    /// ```
    /// Of an actuator with δ and Δ, and with half of both: the latter is the answer, and what lies between the two its
    /// error. A mechanics answers over δ and nothing else: how good that is its next step shows.
    pub(super) fn probe(&mut self, probe: Probe, t: f64, u: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
        let mut probed = std::mem::take(&mut self.probed);
        let kept = self.keep_for_probing(&mut probed, u);
        let begun = kept.is_ok();
        probed.magnitude.clear();
        probed.magnitude.resize(self.plan.outputs.len(), 0.0);
        let mut done = kept.and_then(|()| {
            if self.plan.smooth {
                self.probe_once(&mut probed, probe, t, u)
            } else {
                self.probe_twice(&mut probed, probe, t, u)
            }
        });
        // Back to the state that was kept just now, whatever has become of it; but after Fatal nothing may be called.
        if begun && self.worst.get() < FATAL {
            done = done.and(self.set_state(probed.kept).and_then(|()| self.put(u)));
        }
        if done.is_ok() {
            if self.plan.smooth {
                probed.clear_round_off(probe, self.plan.positions, u);
            }
            output.extend_from_slice(&probed.fine);
            output.push(if self.plan.smooth { 0.0 } else { probed.error(probe, u) });
        }
        self.probed = probed;
        done.map_err(|why| format!("{why} (while it was probed for how its outputs move)"))
    }

    /// Keeps the present state, with these inputs, as that from which probing goes out.
    fn keep_for_probing(&mut self, probed: &mut Probed, u: &[f64]) -> Result<(), String> {
        self.put(u)?;
        let Some(functions) = &self.common.state else { return Err("it keeps no state".to_owned()) };
        let mut kept = probed.kept.unwrap_or(ptr::null_mut());
        // SAFETY: the instance is alive; `kept` is null or a state of it that has not been freed.
        let status = unsafe { (functions.get)(self.instance, &raw mut kept) };
        probed.kept = (!kept.is_null()).then_some(kept);
        self.check(status, "getting its state")
    }

    fn probe_twice(&mut self, probed: &mut Probed, probe: Probe, t: f64, u: &[f64]) -> Result<(), String> {
        for share in [1.0, 0.5] {
            std::mem::swap(&mut probed.coarse, &mut probed.fine);
            self.probe_once(probed, Probe { step: share * probe.step, change: share * probe.change, ..probe }, t, u)?;
        }
        Ok(())
    }

    /// Fills `probed.fine`.
    fn probe_once(&mut self, probed: &mut Probed, probe: Probe, t: f64, u: &[f64]) -> Result<(), String> {
        let (p, n) = (self.plan.outputs.len(), u.len());
        let Probed { kept, fine, magnitude, input, before, after, .. } = probed;
        fine.clear();
        fine.resize(p * (1 + 2 * n), 0.0);
        let (rate, gains) = fine.split_at_mut(p);
        let (feedthrough, rate_gain) = gains.split_at_mut(p * n);
        self.shoot(*kept, t, u, probe.step, [before, after])?;
        for row in 0..p {
            rate[row] = (after[row] - before[row]) / probe.step;
            magnitude[row] = magnitude[row].max(before[row].abs()).max(after[row].abs());
        }
        for at in 0..n {
            let change = probe.change_of(u[at]);
            // What the inputs are in the end, to the last bit.
            let ends = [u[at] + change, u[at] - change];
            let width = ends[0] - ends[1];
            for (end, sign) in ends.into_iter().zip([1.0, -1.0]) {
                input.clear();
                input.extend_from_slice(u);
                input[at] = end;
                self.shoot(*kept, t, input, probe.step, [before, after])?;
                for row in 0..p {
                    let entry = row * n + at;
                    // Differences first, and one division of each: outputs may be large beside what changes in them.
                    feedthrough[entry] += sign * before[row];
                    rate_gain[entry] += sign * (after[row] - before[row]);
                    magnitude[row] = magnitude[row].max(before[row].abs()).max(after[row].abs());
                }
            }
            for entry in (0..p).map(|row| row * n + at) {
                feedthrough[entry] = if probe.feedthrough { feedthrough[entry] / width } else { 0.0 };
                rate_gain[entry] /= probe.step * width;
            }
        }
        Ok(())
    }

    /// Outputs before and after a step from a state that was kept.
    fn shoot(
        &mut self,
        from: Option<Keep>,
        t: f64,
        u: &[f64],
        h: f64,
        [before, after]: [&mut Vec<f64>; 2],
    ) -> Result<(), String> {
        self.set_state(from)?;
        self.put(u)?;
        before.clear();
        self.take_outputs(before)?;
        self.step(t, h)?;
        after.clear();
        self.take_outputs(after)
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::super::super::host::{Start, Type};
    use super::super::version::StateFunctions;
    use super::super::*;

    const STEP: f64 = 1e-3;
    const CHANGE: f64 = 1e-6;

    /// An FMU without an archive: one input, two outputs.
    struct Guest {
        x: [f64; 2],
        u: f64,
        /// What a step makes of the state.
        advance: fn([f64; 2], f64, f64) -> [f64; 2],
        say: fn([f64; 2], f64) -> [f64; 2],
        /// What the step after so many more returns, if it does not go well.
        fault: Option<(usize, c_int)>,
        /// What keeping a state returns.
        keeping: c_int,
        longest: f64,
        states_set: usize,
        after_fatal: usize,
        fatal: bool,
    }

    impl Guest {
        fn new(x: [f64; 2], advance: fn([f64; 2], f64, f64) -> [f64; 2], say: fn([f64; 2], f64) -> [f64; 2]) -> Guest {
            Guest {
                x,
                u: 0.0,
                advance,
                say,
                fault: None,
                keeping: 0,
                longest: 0.0,
                states_set: 0,
                after_fatal: 0,
                fatal: false,
            }
        }
    }

    /// # Safety
    /// The instance is a [`Guest`] that nobody else looks at.
    unsafe fn called<'a>(instance: Instance) -> &'a mut Guest {
        // SAFETY: as the caller says.
        let guest = unsafe { &mut *instance.cast::<Guest>() };
        guest.after_fatal += usize::from(guest.fatal);
        guest
    }

    unsafe extern "C" fn nothing(_: Instance) {}
    unsafe extern "C" fn well(_: Instance) -> c_int {
        0
    }
    unsafe extern "C" fn get_state(instance: Instance, kept: *mut Keep) -> c_int {
        // SAFETY: `Loaded` has this guest for its instance.
        let guest = unsafe { called(instance) };
        if guest.keeping == 0 {
            // SAFETY: a place where null stands, or three numbers that were made here.
            unsafe {
                if (*kept).is_null() {
                    *kept = Box::into_raw(Box::new([0.0; 3])).cast();
                }
                *(*kept).cast::<[f64; 3]>() = [guest.x[0], guest.x[1], guest.u];
            }
        }
        guest.keeping
    }
    unsafe extern "C" fn set_state(instance: Instance, kept: Keep) -> c_int {
        // SAFETY: `Loaded` has this guest for its instance, and hands over three numbers that were made by `get_state`.
        let (guest, [x, y, u]) = unsafe { (called(instance), *kept.cast::<[f64; 3]>()) };
        (guest.x, guest.u) = ([x, y], u);
        guest.states_set += 1;
        0
    }
    unsafe extern "C" fn free_state(_: Instance, kept: *mut Keep) -> c_int {
        // SAFETY: three numbers that were boxed by `get_state`, and are freed once.
        drop(unsafe { Box::from_raw((*kept).cast::<[f64; 3]>()) });
        0
    }

    struct OfGuest;

    impl Version for OfGuest {
        fn enter(&self, _: &Opened, _: Instance, _: f64, _: Option<f64>) -> Result<(c_int, &'static str), String> {
            Ok((0, ""))
        }
        fn set_start(&self, _: &Opened, _: Instance, _: &Start) -> Result<c_int, String> {
            Ok(0)
        }
        fn set(&self, instance: Instance, _: &[u32], values: &[f64]) -> c_int {
            // SAFETY: `Loaded` has this guest for its instance.
            unsafe { called(instance).u = values[0] };
            0
        }
        fn get(&self, instance: Instance, _: &[u32], values: &mut [f64]) -> c_int {
            // SAFETY: as above.
            let guest = unsafe { called(instance) };
            values.copy_from_slice(&(guest.say)(guest.x, guest.u));
            0
        }
        fn read(&self, _: &Opened, _: Instance, _: Type, _: u32, _: &mut [f64]) -> Result<c_int, String> {
            Ok(0)
        }
        fn step(&self, instance: Instance, [_, h]: [f64; 2], _: bool) -> Result<c_int, String> {
            // SAFETY: as above.
            let guest = unsafe { called(instance) };
            guest.longest = guest.longest.max(h);
            match &mut guest.fault {
                Some((0, status)) => {
                    guest.fatal = *status == FATAL;
                    return Ok(*status);
                }
                Some((left, _)) => *left -= 1,
                None => {}
            }
            guest.x = (guest.advance)(guest.x, guest.u, h);
            Ok(0)
        }
        fn derivative(&self, _: Instance, _: &[u32], _: u32, _: &mut [f64]) -> Option<c_int> {
            None
        }
    }

    /// As an actuator with direct feedthrough, probed by [`STEP`] and [`CHANGE`]; `guest` outlives it.
    fn loaded(guest: &mut Guest) -> Loaded {
        let plain = |reference| Scaled { reference, kind: Type::Float64, element: None, factor: 1.0, offset: 0.0 };
        let plan = Plan {
            side: String::new(),
            needs_tool: false,
            begin: 0.0,
            limits: Vec::new(),
            file: "guest.fmu".into(),
            library: "".into(),
            needs: Vec::new(),
            resources: "".into(),
            version_2: false,
            token: String::new(),
            log: false,
            lodger: false,
            time_unit: 1.0,
            stop: None,
            starts: Vec::new(),
            inputs: vec![plain(0)],
            outputs: vec![plain(1), plain(2)],
            positions: 0,
            rates: None,
            derivatives: false,
            smooth: false,
            probe: Some(Probe { step: STEP, change: CHANGE, feedthrough: true }),
            keeps_state: true,
            model: None,
            step: None,
            observed_names: Vec::new(),
            observed: Vec::new(),
            work: None,
        };
        Loaded {
            common: Common {
                free: nothing,
                terminate: well,
                exit_initialization: well,
                state: Some(StateFunctions { get: get_state, set: set_state, free: free_state }),
            },
            version: ManuallyDrop::new(Box::new(OfGuest)),
            instance: (&raw mut *guest).cast(),
            copies: vec![Slot { kept: None, used: true, time: 0.0 }],
            present: 0,
            inputs: Places::of(&plan.inputs),
            outputs: Places::of(&plan.outputs),
            rates: Places::default(),
            room: Vec::new(),
            said: ManuallyDrop::new(Box::new(Said::default())),
            opened: ManuallyDrop::new(Opened {
                library: libloading::os::unix::Library::this().into(),
                file: "guest.fmu".to_owned(),
            }),
            probed: Probed::default(),
            stepping: true,
            warnings: RefCell::default(),
            house: None,
            worst: Cell::new(0),
            plan,
        }
    }

    /// Rates, feedthrough, rate gain and the estimate, of steps of at most `longest` (s).
    fn rates(loaded: &mut Loaded, longest: f64, u: f64) -> Result<Vec<f64>, String> {
        let mut output = Vec::new();
        loaded.ask(Ask::Rates, 0, &[0.0, longest, u], &mut output).map(|()| output)
    }

    #[test]
    fn numbers_that_hold_nothing_but_round_off_are_no_error_of_probing() {
        // The second state does not follow the input, but its last digits do.
        let advance =
            |[x, y]: [f64; 2], u: f64, h: f64| [x + h * (2.0 + 5.0 * u), (y + 0.1 * h) * (3.0 + u) / (3.0 + u)];
        let mut guest = Guest::new([1.0, 1e3], advance, |x, _| x);
        let mut one = loaded(&mut guest);
        let mut round_off = 0;
        for u in (1..40).map(|k| 0.37 * f64::from(k)) {
            let found = rates(&mut one, 1.0, u).unwrap();
            // Rates, feedthrough, rate gain.
            approx::assert_abs_diff_eq!(found[0], 2.0 + 5.0 * u, epsilon = 1e-9);
            approx::assert_abs_diff_eq!(found[4], 5.0, epsilon = 1e-5);
            round_off += usize::from(found[5] != 0.0);
            assert!(found[6] < 1e-5, "{found:?}");
        }
        assert!(round_off > 0, "no digit of the second state follows the input");
    }

    #[test]
    fn an_estimate_of_probing_knows_of_no_other_probe() {
        // Rates beside which the others are small, and rates that change within a step.
        let advance = |[x, y]: [f64; 2], u: f64, h: f64| [x + h * u * (1.0 + 400.0 * h), y];
        let mut guest = Guest::new([0.0, 0.0], advance, |x, _| x);
        let mut one = loaded(&mut guest);
        let large = rates(&mut one, 1.0, 1e6).unwrap();
        let small = rates(&mut one, 1.0, 1.0).unwrap();
        // δ = 1 ms and 0.5 ms: 1.4 and 1.2.
        for found in [large, small] {
            approx::assert_abs_diff_eq!(found[6], 0.2 / 1.4, epsilon = 1e-4);
        }
    }

    #[test]
    fn feedthrough_of_outputs_far_from_zero_is_probed_with_all_digits_that_they_have() {
        let mut guest = Guest::new([0.0, 0.0], |x, _, _| x, |_, u| [1e6 + 400.0 * u, 0.0]);
        let mut one = loaded(&mut guest);
        for u in [0.3, 0.7, 1.1, 2.3] {
            let found = rates(&mut one, 1.0, u).unwrap();
            // ε|y|/Δ is 4e-4.
            approx::assert_abs_diff_eq!(found[2], 400.0, epsilon = 1e-3);
        }
    }

    #[test]
    fn no_step_of_probing_is_longer_than_what_is_asked_for() {
        for (longest, taken) in [(1e-4, 1e-4), (1.0, STEP)] {
            let mut guest = Guest::new([0.0, 0.0], |x, _, _| x, |x, _| x);
            rates(&mut loaded(&mut guest), longest, 0.0).unwrap();
            assert_eq!(guest.longest, taken);
        }
    }

    #[test]
    fn an_fmu_that_breaks_while_it_is_probed_is_set_back_only_where_that_is_allowed() {
        for status in [2, ERROR, FATAL] {
            let mut guest = Guest::new([1.0, 2.0], |[x, y], _, h| [x + h, y - h], |x, _| x);
            guest.fault = Some((3, status));
            let message = rates(&mut loaded(&mut guest), 1.0, 0.5).unwrap_err();
            assert!(message.contains("while it was probed"), "{message}");
            assert_eq!(guest.after_fatal, 0, "status {status}");
            // Four shots, and back.
            assert_eq!(guest.states_set, if status == FATAL { 4 } else { 5 });
            assert_eq!(guest.x, [1.0, 2.0], "status {status}");
        }
        // A state that could not be kept is not replaced by an older one.
        let mut guest = Guest::new([1.0, 2.0], |[x, y], _, h| [x + h, y - h], |x, _| x);
        let mut one = loaded(&mut guest);
        rates(&mut one, 1.0, 0.5).unwrap();
        // SAFETY: the guest is alive, and `one` does not look at it now.
        let inside = unsafe { &mut *one.instance.cast::<Guest>() };
        (inside.x, inside.keeping) = ([7.0, 8.0], 2);
        rates(&mut one, 1.0, 0.5).unwrap_err();
        drop(one);
        assert_eq!(guest.x, [7.0, 8.0]);
    }
}

//! The library of an FMU, loaded into this process.

#![allow(unsafe_code, reason = "functions of a library that others wrote")]

#[cfg(unix)]
mod lodger;
#[cfg(not(unix))]
#[path = "library/no_lodger.rs"]
mod lodger;
mod printf;
mod probing;
mod three;
mod two;
mod version;

use self::lodger::House;
use self::probing::Probed;
use self::three::Three;
use self::two::Two;
use self::version::{Common, Instance, Keep, Made, Opened, Version};
use super::host::{Ask, Element, Host, ModelVariables, NEEDS_TOOL, Plan, Probe, Scaled, Start, Type};
use std::cell::{Cell, RefCell};
use std::ffi::{c_char, c_int, c_void};
use std::io::Write;
use std::mem::ManuallyDrop;
use std::ptr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// How much of the end of the log of one call is repeated, characters.
const LONGEST_LOG: usize = 400;

/// Statuses after which little, or nothing, may be asked of an instance.
const ERROR: c_int = 3;
const FATAL: c_int = 4;

#[cfg(unix)]
mod system {
    unsafe extern "C" {
        pub(super) fn dup2(from: std::ffi::c_int, to: std::ffi::c_int) -> std::ffi::c_int;
        pub(super) fn _exit(status: std::ffi::c_int) -> !;
    }
}

/// Makes the standard input an empty file, so that no process that an FMU starts holds what it was.
#[cfg(unix)]
pub(super) fn leave_standard_input() -> std::io::Result<()> {
    use std::os::fd::AsRawFd;
    let empty = std::fs::File::open("/dev/null")?;
    // SAFETY: both descriptors are open; nobody has read ahead from the standard input.
    if unsafe { system::dup2(empty.as_raw_fd(), 0) } < 0 { Err(std::io::Error::last_os_error()) } else { Ok(()) }
}

/// Ends this process without a word to the libraries in it, one of which may never return.
#[cfg(unix)]
pub(super) fn leave_at_once() -> ! {
    // SAFETY: it takes a number and does not return.
    unsafe { system::_exit(1) }
}

/// Ends the program with a code, whatever FMUs in this process are at.
pub fn leave(code: u8) -> ! {
    lodger::leave(code)
}

/// Our own standard output, where an FMU in this process has the usual one.
pub fn standard_output() -> Option<std::fs::File> {
    lodger::standard_output()
}

/// What the library has said since it was last asked.
#[derive(Default)]
struct Said {
    text: Mutex<String>,
    /// What the instance is called, which is another name in each run, and its side, which stands for that in what is
    /// recorded.
    instance: String,
    side: String,
    /// Whether one of it was a warning.
    warned: AtomicBool,
    /// Whether it is shown as it comes, and how the FMU is called there.
    shown_as: Option<String>,
}

/// What is said where an FMU fails and says nothing, with its log on or off.
fn without_reason(log: bool) -> String {
    let more = if log { "" } else { "; `log = true` of its side in the case file asks for its log" };
    format!("it does not say why{more}")
}

/// The status of a warning.
const WARNING: c_int = 1;

/// # Safety
/// `said` is a [`Said`], and `message` a text that ends in zero, or null.
unsafe fn note(said: *mut c_void, status: c_int, message: *const c_char) {
    // SAFETY: what it points to is a `Said`, as the caller says.
    let (Some(said), false) = (unsafe { said.cast::<Said>().as_ref() }, message.is_null()) else { return };
    // SAFETY: it is not null, so that it ends in zero, as the caller says.
    let message = unsafe { std::ffi::CStr::from_ptr(message) }.to_string_lossy();
    if let Ok(mut text) = said.text.lock() {
        let from = text.len();
        if from > 0 {
            text.push_str("; ");
        }
        let message = message.replace(&said.instance, &said.side);
        text.extend(message.trim().chars().map(|c| if c.is_control() { ' ' } else { c }));
        if status == WARNING {
            said.warned.store(true, Ordering::Relaxed);
        }
        if let Some(name) = &said.shown_as {
            // One write, so that lines of several processes stay lines. Where nobody listens nobody is told.
            let line = format!("{name}: {}\n", text[from..].trim_start_matches("; "));
            let _ = std::io::stderr().lock().write_all(line.as_bytes());
        }
        // Why a call failed is said last.
        if let Some((beyond, _)) = text.char_indices().rev().nth(LONGEST_LOG - 1) {
            text.drain(..beyond);
        }
    }
}

/// A copy of an FMU's state.
#[derive(Default)]
struct Slot {
    /// The state while another copy is the present one, or what was one: the FMU may write over it.
    kept: Option<Keep>,
    /// Whether somebody has it.
    used: bool,
    /// The time that it has come to, s.
    time: f64,
}

/// What goes to the FMU as a whole: an array of which elements are coupled, or a variable of type Float32.
struct Array {
    reference: u32,
    kind: Type,
    values: Vec<f64>,
}

/// Where numbers that cross the boundary are in an FMU.
#[derive(Default)]
struct Places {
    /// Variables of one value and of type Float64, in order.
    single: Vec<u32>,
    arrays: Vec<Array>,
    /// Elements: place among all numbers, which array, place in it.
    of_arrays: Vec<(usize, usize, usize)>,
}

impl Places {
    fn of(list: &[Scaled]) -> Places {
        let mut places = Places::default();
        for (place, scaled) in list.iter().enumerate() {
            if scaled.is_single() {
                places.single.push(scaled.reference);
                continue;
            }
            let Scaled { reference, kind, element, .. } = scaled;
            let Element { at, of } = element.unwrap_or(Element { at: 0, of: 1 });
            let known = places.arrays.iter().position(|array| array.reference == *reference);
            let array = known.unwrap_or_else(|| {
                places.arrays.push(Array { reference: *reference, kind: *kind, values: vec![0.0; of] });
                places.arrays.len() - 1
            });
            places.of_arrays.push((place, array, at));
        }
        places
    }
}

/// An FMU in this process.
pub(super) struct Loaded {
    plan: Plan,
    instance: Instance,
    common: Common,
    version: ManuallyDrop<Box<dyn Version>>,
    copies: Vec<Slot>,
    present: usize,
    inputs: Places,
    outputs: Places,
    rates: Places,
    room: Vec<f64>,
    said: ManuallyDrop<Box<Said>>,
    opened: ManuallyDrop<Opened>,
    probed: Probed,
    /// Whether it has come to step mode, from which it may be asked to terminate.
    stepping: bool,
    /// How often it has warned, and what it said first.
    warnings: RefCell<(u64, String)>,
    /// What is set back after each call, where it is in our process.
    house: Option<House>,
    /// The worst status so far.
    worst: Cell<c_int>,
}

// SAFETY: an instance is called from one thread at a time, which is all that FMI asks; `Loaded` is never shared.
unsafe impl Send for Loaded {}

impl Loaded {
    /// Loads, makes an instance, sets its start values, and lets it begin.
    pub(super) fn new(plan: Plan) -> Result<Self, String> {
        static MADE: AtomicU64 = AtomicU64::new(0);
        let house = plan.lodger.then(House::enter).transpose().map_err(|error| error.to_string())?;
        let shown_as = plan.log.then(|| plan.file.display().to_string());
        // The standard wants names of instances to be unique: those of a run and its reference, of all threads and all
        // processes.
        let instance = format!("{}-{}-{}", plan.side, std::process::id(), MADE.fetch_add(1, Ordering::Relaxed));
        let said = Box::new(Said { shown_as, instance, side: plan.side.clone(), ..Said::default() });
        let environment: *mut c_void = (&raw const *said).cast_mut().cast();
        let at_work = house.as_ref().map(|_| lodger::AtWork::on(&plan.file, &plan.side));
        let opened = Opened::new(&plan)?;
        let make = if plan.version_2 { Two::make } else { Three::make };
        let made = make(&opened, &plan, &said.instance, environment);
        drop(at_work);
        if let Some(house) = &house {
            house.tidy();
        }
        let Made { instance, common, version } = made?;
        if instance.is_null() {
            let said = said.text.lock().map(|text| text.clone()).unwrap_or_default();
            let said = if said.is_empty() { without_reason(plan.log) } else { said };
            let tool = if plan.needs_tool { format!("; {NEEDS_TOOL}") } else { String::new() };
            return Err(opened.wrong(format_args!("no instance can be made: {said}{tool}")));
        }
        let mut loaded = Loaded {
            instance,
            common,
            version: ManuallyDrop::new(version),
            copies: vec![Slot { kept: None, used: true, time: 0.0 }],
            present: 0,
            inputs: Places::of(&plan.inputs),
            outputs: Places::of(&plan.outputs),
            rates: plan.rates.as_deref().map(Places::of).unwrap_or_default(),
            room: Vec::new(),
            said: ManuallyDrop::new(said),
            opened: ManuallyDrop::new(opened),
            probed: Probed::default(),
            stepping: false,
            warnings: RefCell::default(),
            house,
            worst: Cell::new(0),
            plan,
        };
        let at_work = loaded.at_work();
        let entered = loaded.enter();
        drop(at_work);
        loaded.tidy();
        entered.map(|()| loaded)
    }

    /// From instantiation to initialisation mode.
    fn enter(&mut self) -> Result<(), String> {
        self.plan.starts.iter().try_for_each(|start| self.set_start(start))?;
        // An array that is coupled in part is set as a whole, and begins with what it has.
        let mut arrays = std::mem::take(&mut self.inputs.arrays);
        for array in arrays.iter_mut().filter(|array| array.values.len() > 1) {
            self.get_all(array.kind, array.reference, &mut array.values)?;
        }
        self.inputs.arrays = arrays;
        let begin = self.plan.begin;
        let end = self.plan.stop.map(|stop| begin + stop / self.plan.time_unit);
        let (status, what) = self.version.enter(&self.opened, self.instance, begin, end)?;
        self.check(status, what)?;
        // What an output begins with may follow from parameters as initialisation begins; as it is exact, it may be set
        // then.
        self.plan.starts.iter().filter(|start| start.exact).try_for_each(|start| self.set_start(start))
    }

    fn set_start(&self, start: &Start) -> Result<(), String> {
        let status = self.version.set_start(&self.opened, self.instance, start)?;
        self.check(status, &format!("setting the start value of `{}`", start.variable))
    }

    /// From initialisation to step mode, with these inputs.
    fn begin(&mut self, u: &[f64]) -> Result<(), String> {
        self.check_limits(u)?;
        self.put(u)?;
        // SAFETY: the instance is alive and being initialised.
        let status = unsafe { (self.common.exit_initialization)(self.instance) };
        self.check(status, "ExitInitializationMode")?;
        self.stepping = true;
        Ok(())
    }

    /// Refuses inputs (in SI) beyond what the FMU says that they may be.
    fn check_limits(&self, u: &[f64]) -> Result<(), String> {
        for (at, name, limits) in &self.plan.limits {
            let Some((u, scale)) = u.get(*at).zip(self.plan.inputs.get(*at)) else { continue };
            let value = scale.inwards(*u);
            limits.check(value).map_err(|valid| {
                self.opened.wrong(format_args!("input `{name}` = {value} is not valid; valid: {valid}"))
            })?;
        }
        Ok(())
    }

    /// Says that its code is at work until what this gives is dropped, where that is in our process.
    fn at_work(&self) -> Option<lodger::AtWork> {
        self.house.as_ref().map(|_| lodger::AtWork::on(&self.plan.file, &self.plan.side))
    }

    /// Sets back what the library may have changed of the process that it is in.
    fn tidy(&self) {
        if let Some(house) = &self.house {
            house.tidy();
        }
    }

    /// A status as a result: `OK` and `Warning` are none, but warnings are counted, whether the status says so or the
    /// log.
    fn check(&self, status: c_int, what: &str) -> Result<(), String> {
        if (0..=WARNING).contains(&status) {
            if status == WARNING || self.said.warned.load(Ordering::Relaxed) {
                self.said.warned.store(false, Ordering::Relaxed);
                let mut warnings = self.warnings.borrow_mut();
                warnings.0 += 1;
                if let (true, Ok(mut text)) = (warnings.1.is_empty(), self.said.text.lock()) {
                    warnings.1 = std::mem::take(&mut text);
                }
            }
            return Ok(());
        }
        self.worst.set(self.worst.get().max(if (0..=5).contains(&status) { status % 5 } else { FATAL }));
        let name = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];
        let name = usize::try_from(status)
            .ok()
            .and_then(|status| name.get(status))
            .copied()
            .unwrap_or("a status that there is not");
        let said = self.said.text.lock().map(|mut text| std::mem::take(&mut *text)).unwrap_or_default();
        let said = if said.is_empty() { without_reason(self.plan.log) } else { said };
        Err(self.opened.wrong(format_args!("{what} returned {name}: {said}")))
    }

    fn set(&self, references: &[u32], values: &[f64]) -> Result<(), String> {
        let n = references.len();
        if n != values.len() {
            return Err(format!("{} values for {n} variables", values.len()));
        }
        if n == 0 {
            return Ok(());
        }
        let status = self.version.set(self.instance, references, values);
        self.check(status, "setting a number")
    }

    fn get(&self, references: &[u32], values: &mut [f64]) -> Result<(), String> {
        if references.is_empty() {
            return Ok(());
        }
        let status = self.version.get(self.instance, references, values);
        self.check(status, "getting a number")
    }

    /// Gets all values of a variable of any type that has numbers or truths.
    fn get_all(&self, kind: Type, reference: u32, values: &mut [f64]) -> Result<(), String> {
        if kind == Type::Float64 {
            return self.get(&[reference], values);
        }
        let status = self.version.read(&self.opened, self.instance, kind, reference, values)?;
        self.check(status, &format!("getting a value of type {}", kind.name()))
    }

    /// Sets the inputs, given in SI.
    fn put(&mut self, u: &[f64]) -> Result<(), String> {
        if u.len() != self.plan.inputs.len() {
            return Err(format!("{} inputs for {}", u.len(), self.plan.inputs.len()));
        }
        let mut room = std::mem::take(&mut self.room);
        room.clear();
        if self.inputs.arrays.is_empty() {
            room.extend(u.iter().zip(&self.plan.inputs).map(|(u, scale)| scale.inwards(*u)));
            let done = self.set(&self.inputs.single, &room);
            self.room = room;
            return done;
        }
        let Places { single, arrays, of_arrays } = &mut self.inputs;
        for (u, scale) in u.iter().zip(&self.plan.inputs).filter(|(_, scale)| scale.is_single()) {
            room.push(scale.inwards(*u));
        }
        for &(place, array, at) in &*of_arrays {
            arrays[array].values[at] = self.plan.inputs[place].inwards(u[place]);
        }
        let status = if single.is_empty() { 0 } else { self.version.set(self.instance, single, &room) };
        let mut done = self.check(status, "setting a number");
        for array in &self.inputs.arrays {
            done = done.and_then(|()| {
                let (reference, values) = (&[array.reference], &array.values);
                if array.kind == Type::Float64 {
                    return self.check(self.version.set(self.instance, reference, values), "setting an array");
                }
                let status = self.version.set_short(&self.opened, self.instance, array.reference, values)?;
                self.check(status, "setting a number of type Float32")
            });
        }
        self.room = room;
        done
    }

    /// Appends the outputs, in SI.
    fn take_outputs(&mut self, output: &mut Vec<f64>) -> Result<(), String> {
        if self.outputs.arrays.is_empty() {
            let from = output.len();
            output.resize(from + self.outputs.single.len(), 0.0);
            self.get(&self.outputs.single, &mut output[from..])?;
            output[from..].iter_mut().zip(&self.plan.outputs).for_each(|(y, scale)| *y = scale.outwards(*y));
            return Ok(());
        }
        let mut places = std::mem::take(&mut self.outputs);
        let done = self.take(&mut places, &self.plan.outputs, output);
        self.outputs = places;
        done
    }

    /// Appends the values of some variables, in SI.
    fn take(&self, places: &mut Places, scales: &[Scaled], output: &mut Vec<f64>) -> Result<(), String> {
        let from = output.len();
        if places.arrays.is_empty() {
            output.resize(from + places.single.len(), 0.0);
            self.get(&places.single, &mut output[from..])?;
        } else {
            let mut singles = vec![0.0; places.single.len()];
            self.get(&places.single, &mut singles)?;
            for array in &mut places.arrays {
                self.get_all(array.kind, array.reference, &mut array.values)?;
            }
            let mut singles = singles.into_iter();
            output.extend(
                scales.iter().map(|scale| if scale.is_single() { singles.next().unwrap_or(f64::NAN) } else { 0.0 }),
            );
            for &(place, array, at) in &places.of_arrays {
                output[from + place] = places.arrays[array].values[at];
            }
        }
        output[from..].iter_mut().zip(scales).for_each(|(value, scale)| *value = scale.outwards(*value));
        Ok(())
    }

    /// Appends numbers of whatever type, as their scale has them.
    fn look(&self, observed: &[Scaled], output: &mut Vec<f64>) -> Result<(), String> {
        let mut array = Vec::new();
        for scale in observed {
            let Element { at, of } = scale.element.unwrap_or(Element { at: 0, of: 1 });
            array.clear();
            array.resize(of, 0.0);
            self.get_all(scale.kind, scale.reference, &mut array)?;
            output.push(scale.outwards(array[at]));
        }
        Ok(())
    }

    /// Makes a copy the present one.
    fn activate(&mut self, id: usize) -> Result<(), String> {
        if id == self.present {
            return Ok(());
        }
        let kept =
            self.copies.get(id).filter(|copy| copy.used).and_then(|copy| copy.kept).ok_or("there is no such copy")?;
        if self.copies[self.present].used {
            self.store(self.present)?;
        }
        self.set_state(Some(kept))?;
        self.present = id;
        Ok(())
    }

    /// Keeps the present state under a number.
    fn store(&mut self, id: usize) -> Result<(), String> {
        let Some(functions) = &self.common.state else { return Err("it keeps no state".to_owned()) };
        let mut kept = self.copies[id].kept.unwrap_or(ptr::null_mut());
        // SAFETY: the instance is alive; `kept` is null or a state of it that has not been freed.
        let status = unsafe { (functions.get)(self.instance, &raw mut kept) };
        self.copies[id].kept = (!kept.is_null()).then_some(kept);
        self.check(status, "getting its state")
    }

    fn release(&mut self, kept: Option<Keep>) {
        if let (Some(functions), Some(mut kept)) = (&self.common.state, kept) {
            // SAFETY: the instance is alive; the state is one of it, and who hands it over has it no more. What cannot
            // be freed is the FMU's loss.
            let _ = unsafe { (functions.free)(self.instance, &raw mut kept) };
        }
    }

    /// `∂unknowns/∂inputs`, row by row, in SI; the unknowns are outputs, or their rates, from a place on.
    fn jacobian(&self, unknowns: &[u32], first: usize, of_rates: bool, output: &mut Vec<f64>) -> Result<(), String> {
        let scales = if of_rates { self.plan.rates.as_deref().unwrap_or_default() } else { &*self.plan.outputs };
        let scales = &scales[first..];
        let (rows, columns) = (unknowns.len(), self.plan.inputs.len());
        let from = output.len();
        output.resize(from + rows * columns, 0.0);
        let mut column = vec![0.0; rows];
        for (at, (input, scale)) in self.inputs.single.iter().zip(&self.plan.inputs).enumerate() {
            column.fill(0.0);
            let status = self.version.derivative(self.instance, unknowns, *input, &mut column);
            let status = status.ok_or("it has no directional derivatives")?;
            self.check(status, "a directional derivative")?;
            for (row, (value, own)) in column.iter().zip(scales).enumerate() {
                output[from + row * columns + at] = value * (own.factor / scale.factor);
            }
        }
        Ok(())
    }

    fn set_state(&self, kept: Option<Keep>) -> Result<(), String> {
        let (Some(functions), Some(kept)) = (&self.common.state, kept) else {
            return Err("it keeps no state".to_owned());
        };
        // SAFETY: the instance is alive, and `kept` is a state of it that has not been freed: only `release` frees, as
        // its last use.
        let status = unsafe { (functions.set)(self.instance, kept) };
        self.check(status, "setting its state")
    }

    /// Appends the parts of the interface model.
    fn read_model(&self, input: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
        let Some(ModelVariables { step, size, references }) = &self.plan.model else {
            return Err("it has no interface model".to_owned());
        };
        let [h] = input else { return Err("a model needs a step".to_owned()) };
        self.set(&[*step], &[*h])?;
        for (part, &reference) in size.parts().zip(references) {
            let from = output.len();
            output.resize(from + part.count(*size), 0.0);
            self.get_all(part.part_type.into(), reference, &mut output[from..])?;
        }
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Result<(), String> {
        let unit = self.plan.time_unit;
        // Some take no step for good as long as one may go back behind it.
        let no_way_back = !self.copies.iter().any(|copy| copy.used && copy.time < t);
        let status = self.version.step(self.instance, [self.plan.begin + t / unit, h / unit], no_way_back);
        let status = status.map_err(|why| self.opened.wrong(why))?;
        self.check(status, "DoStep")
    }
}

impl Host for Loaded {
    fn ask(&mut self, ask: Ask, id: u32, input: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
        output.clear();
        if self.worst.get() == FATAL {
            return Err(self.opened.wrong("it has returned Fatal before: nothing more can be asked of it"));
        }
        // What it said of calls that went well explains no other.
        if let Ok(mut text) = self.said.text.lock() {
            text.clear();
        }
        let at_work = self.at_work();
        let done = self.answer(ask, id, input, output);
        drop(at_work);
        if let Some(house) = &self.house {
            house.tidy();
        }
        done
    }
}

impl Loaded {
    fn answer(&mut self, ask: Ask, id: u32, input: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
        if ask == Ask::Heard {
            let warnings = self.warnings.get_mut();
            output.push(warnings.0 as f64);
            output.extend(warnings.1.bytes().map(f64::from));
            return Ok(());
        }
        if ask == Ask::Drop {
            // The next copy takes its place.
            self.copies.get_mut(id as usize).ok_or("there is no such copy")?.used = false;
            return Ok(());
        }
        self.activate(id as usize)?;
        match ask {
            Ask::Outputs => {
                self.put(input)?;
                self.take_outputs(output)
            }
            Ask::Begin => self.begin(input),
            Ask::Step => {
                let [t, h, u @ ..] = input else { return Err("a step needs a time and a length".to_owned()) };
                self.check_limits(u)?;
                self.put(u)?;
                self.copies[self.present].time = *t;
                self.step(*t, *h)?;
                self.copies[self.present].time = t + h;
                self.take_outputs(output)
            }
            Ask::Rates => {
                let [t, u @ ..] = input else { return Err("rates need a time".to_owned()) };
                if let Some(probe) = self.plan.probe {
                    let [longest, u @ ..] = u else { return Err("probing needs a longest step".to_owned()) };
                    return self.probe(Probe { step: probe.step.min(*longest), ..probe }, *t, u, output);
                }
                self.put(u)?;
                let mut places = std::mem::take(&mut self.rates);
                let taken = self.take(&mut places, self.plan.rates.as_deref().unwrap_or_default(), output);
                self.rates = places;
                taken?;
                if self.plan.smooth {
                    // Positions and velocities do not follow forces at once, and an FMU may refuse to say by how much.
                    let (rows, columns, positions) =
                        (self.plan.outputs.len(), self.plan.inputs.len(), self.plan.positions);
                    output.resize(output.len() + rows * columns + positions * columns, 0.0);
                    return self.jacobian(&self.rates.single[positions..], positions, true, output);
                }
                self.jacobian(&self.outputs.single, 0, false, output)?;
                self.jacobian(&self.rates.single, 0, true, output)
            }
            Ask::Model => self.read_model(input, output),
            Ask::Observe => {
                if let Some(step) = self.plan.step {
                    self.set(&[step], input)?;
                }
                self.look(&self.plan.observed, output).map_err(|what| {
                    let name = self.plan.observed_names.get(output.len()).map_or("", |name| name);
                    format!("{what} (observe = {name:?})")
                })
            }
            Ask::Work => {
                let Some(work) = self.plan.work else { return Err("it counts no work".to_owned()) };
                self.look(&[work], output)
            }
            Ask::Copy => {
                let free = (0..self.copies.len()).find(|at| !self.copies[*at].used && *at != self.present);
                let id = free.unwrap_or(self.copies.len());
                if free.is_none() {
                    self.copies.push(Slot::default());
                }
                self.store(id)?;
                (self.copies[id].used, self.copies[id].time) = (true, self.copies[self.present].time);
                output.push(id as f64);
                Ok(())
            }
            Ask::Drop | Ask::Heard | Ask::Describe | Ask::Receive | Ask::Answer => Ok(()),
        }
    }
}

impl Drop for Loaded {
    fn drop(&mut self) {
        // After Fatal no function may be called, and whatever it left running may still need its code and its log.
        if self.worst.get() == FATAL {
            return;
        }
        let _at_work = self.at_work();
        for id in 0..self.copies.len() {
            let kept = self.copies[id].kept.take();
            self.release(kept);
        }
        let kept = self.probed.kept.take();
        self.release(kept);
        // SAFETY: the instance is alive, and nobody has it afterwards; the library goes last, because the rest calls
        // into it or is called from it. Nothing is dropped twice: `self` is not used again.
        unsafe {
            if self.stepping && self.worst.get() < ERROR {
                let _ = (self.common.terminate)(self.instance);
            }
            (self.common.free)(self.instance);
            ManuallyDrop::drop(&mut self.version);
            ManuallyDrop::drop(&mut self.said);
            ManuallyDrop::drop(&mut self.opened);
        }
    }
}

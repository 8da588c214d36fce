//! The library of an FMU, loaded into this process.
//!
//! Types and names are those of the standards' `fmi3FunctionTypes.h` and `fmi2FunctionTypes.h`, by hand.

#![allow(unsafe_code, reason = "functions of a library that others wrote")]

use super::host::{Ask, Host, Plan, Probe, Scaled, Start};
use libloading::Library;
use std::cell::Cell;
use std::ffi::{CString, c_char, c_int, c_void};
use std::fmt::Display;
use std::mem::ManuallyDrop;
use std::ptr;
use std::sync::Mutex;

type Instance = *mut c_void;
type Keep = *mut c_void;
/// How much of the end of the log of one call is repeated, characters.
const LONGEST_LOG: usize = 400;

/// Statuses after which little, or nothing, may be asked of an instance.
const ERROR: c_int = 3;
const FATAL: c_int = 4;

/// How many roundings of an output are taken for what its own arithmetic and that of differences may add up to.
const ROUNDINGS: f64 = 8.0;

type Log3 = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// What a library calls with printf's arguments in FMI 2.0; of these only the text is used.
type Log2 = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char);

#[repr(C)]
struct Callbacks2 {
    log: Log2,
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    finished: *const c_void,
    environment: *mut c_void,
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

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

/// What the library has said since it was last asked.
type Said = Mutex<String>;

/// # Safety
/// `said` is a [`Said`], and `message` a text that ends in zero, or null.
unsafe fn note(said: *mut c_void, message: *const c_char) {
    let (Some(said), false) = (unsafe { said.cast::<Said>().as_ref() }, message.is_null()) else { return };
    let message = unsafe { std::ffi::CStr::from_ptr(message) }.to_string_lossy();
    if let Ok(mut said) = said.lock() {
        if !said.is_empty() {
            said.push_str("; ");
        }
        said.extend(message.trim().chars().map(|c| if c.is_control() { ' ' } else { c }));
        // Why a call failed is said last.
        if let Some((beyond, _)) = said.char_indices().rev().nth(LONGEST_LOG - 1) {
            said.drain(..beyond);
        }
    }
}

unsafe extern "C" fn log_3(environment: *mut c_void, _status: c_int, _category: *const c_char, message: *const c_char) {
    unsafe { note(environment, message) };
}

unsafe extern "C" fn log_2(
    environment: *mut c_void,
    _name: *const c_char,
    _status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    unsafe { note(environment, message) };
}

/// A folder as FMI 2.0 wants it: a URI, in which all but a few characters are written as `%` and their code.
fn uri(folder: &std::path::Path) -> String {
    let path = folder.display().to_string();
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-._~:".contains(&byte);
    let written = |byte: u8| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    format!("file://{}", path.bytes().map(written).collect::<String>())
}

/// What an error says, with what is behind it; one line.
fn why(error: &dyn std::error::Error) -> String {
    let behind = error.source().map_or(String::new(), |source| format!(" ({source})"));
    format!("{error}{behind}").replace('\n', " ")
}

/// Loads a library for good, its symbols for all that are loaded after it.
#[cfg(unix)]
fn load_for_all(library: &std::path::Path) -> Result<(), libloading::Error> {
    use libloading::os::unix::{Library, RTLD_GLOBAL, RTLD_NOW};
    // SAFETY: whoever names a library trusts it.
    unsafe { Library::open(Some(library), RTLD_NOW | RTLD_GLOBAL) }.map(std::mem::forget)
}

/// Loads a library for good.
#[cfg(not(unix))]
fn load_for_all(library: &std::path::Path) -> Result<(), libloading::Error> {
    // SAFETY: whoever names a library trusts it.
    unsafe { Library::new(library) }.map(std::mem::forget)
}

/// Functions whose types are the same in both versions, by what they are called.
struct Functions {
    free: unsafe extern "C" fn(Instance),
    terminate: unsafe extern "C" fn(Instance) -> c_int,
    exit_initialization: unsafe extern "C" fn(Instance) -> c_int,
    numbers: Numbers,
    step: Step,
    state: Option<StateFunctions>,
    derivative: Option<Derivative>,
    /// Truths as bytes: what a library writes need be none of the two that a `bool` may have.
    booleans: Option<unsafe extern "C" fn(Instance, *const u32, usize, *mut u8, usize) -> c_int>,
    integers: Option<unsafe extern "C" fn(Instance, *const u32, usize, *mut i32, usize) -> c_int>,
}

struct StateFunctions {
    get: unsafe extern "C" fn(Instance, *mut Keep) -> c_int,
    set: unsafe extern "C" fn(Instance, Keep) -> c_int,
    free: unsafe extern "C" fn(Instance, *mut Keep) -> c_int,
}

#[derive(Clone, Copy)]
enum Numbers {
    Two {
        get: unsafe extern "C" fn(Instance, *const u32, usize, *mut f64) -> c_int,
        set: unsafe extern "C" fn(Instance, *const u32, usize, *const f64) -> c_int,
    },
    Three {
        get: unsafe extern "C" fn(Instance, *const u32, usize, *mut f64, usize) -> c_int,
        set: unsafe extern "C" fn(Instance, *const u32, usize, *const f64, usize) -> c_int,
    },
}

#[derive(Clone, Copy)]
enum Step {
    Two(unsafe extern "C" fn(Instance, f64, f64, c_int) -> c_int),
    Three(unsafe extern "C" fn(Instance, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int),
}

#[derive(Clone, Copy)]
enum Derivative {
    Two(unsafe extern "C" fn(Instance, *const u32, usize, *const u32, usize, *const f64, *mut f64) -> c_int),
    Three(
        unsafe extern "C" fn(
            Instance,
            *const u32,
            usize,
            *const u32,
            usize,
            *const f64,
            usize,
            *mut f64,
            usize,
        ) -> c_int,
    ),
}

/// A copy of an FMU's state.
#[derive(Default)]
struct Slot {
    /// The state while another copy is the present one, or what was one: the FMU may write over it.
    kept: Option<Keep>,
    /// Whether somebody has it.
    used: bool,
}

/// What probing needs, and what it has found.
#[derive(Default)]
struct Probed {
    /// The state from which it goes out.
    kept: Option<Keep>,
    /// Rates, feedthrough and rate gain by the longer steps, and by the shorter ones.
    coarse: Vec<f64>,
    fine: Vec<f64>,
    /// The largest magnitude that each output has had in this probe.
    magnitude: Vec<f64>,
    input: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
}

impl Probed {
    /// How far the shorter steps' numbers are from the longer steps', of the largest of both in the same row of the same block (rates,
    /// feedthrough, rate gain); the worst row from `first` on, and 1 at most. A number that is no more than what round-off alone may make of
    /// outputs of that size counts as 0.
    fn error(&self, probe: Probe, first: usize, u: &[f64]) -> f64 {
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
            for row in first..p {
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
}

/// An FMU in this process.
pub(super) struct Loaded {
    plan: Plan,
    functions: Functions,
    instance: Instance,
    copies: Vec<Slot>,
    present: usize,
    inputs: Vec<u32>,
    outputs: Vec<u32>,
    rates: Vec<u32>,
    observed: Vec<u32>,
    room: Vec<f64>,
    truths: Vec<u8>,
    integers: Vec<i32>,
    said: ManuallyDrop<Box<Said>>,
    callbacks: ManuallyDrop<Option<Box<Callbacks2>>>,
    library: ManuallyDrop<Library>,
    probed: Probed,
    /// Whether it has come to step mode, from which it may be asked to terminate.
    stepping: bool,
    /// The worst status so far.
    worst: Cell<c_int>,
}

// SAFETY: an instance is called from one thread at a time, which is all that FMI asks; `Loaded` is never shared.
unsafe impl Send for Loaded {}

impl Loaded {
    /// Loads, makes an instance, sets its start values, and lets it begin.
    pub(super) fn new(plan: Plan) -> Result<Self, String> {
        let said = Box::new(Said::default());
        let environment: *mut c_void = (&raw const *said).cast_mut().cast();
        let file = plan.file.display().to_string();
        let wrong = |message: &dyn Display| format!("{file}: {message}");
        plan.needs.iter().try_for_each(|needed| {
            load_for_all(needed).map_err(|error| {
                wrong(&format!("needs = {}, which cannot be loaded: {}", needed.display(), why(&error)))
            })
        })?;
        // SAFETY: what a library does when it is loaded is its own business; whoever names an FMU trusts it.
        let library = unsafe { Library::new(&plan.library) }
            .map_err(|error| wrong(&format!("its library cannot be loaded: {}", why(&error))))?;
        /// A function by its name.
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the type is that of the standard for this name.
                *unsafe { library.get($name) }.map_err(|error| {
                    wrong(&format!("its library has no {}: {}", String::from_utf8_lossy($name), why(&error)))
                })?
            };
        }
        let two = plan.version_2;
        let functions = if two {
            Functions {
                free: function!(b"fmi2FreeInstance"),
                terminate: function!(b"fmi2Terminate"),
                exit_initialization: function!(b"fmi2ExitInitializationMode"),
                numbers: Numbers::Two { get: function!(b"fmi2GetReal"), set: function!(b"fmi2SetReal") },
                step: Step::Two(function!(b"fmi2DoStep")),
                state: None,
                derivative: if plan.derivatives {
                    Some(Derivative::Two(function!(b"fmi2GetDirectionalDerivative")))
                } else {
                    None
                },
                booleans: None,
                integers: None,
            }
        } else {
            Functions {
                free: function!(b"fmi3FreeInstance"),
                terminate: function!(b"fmi3Terminate"),
                exit_initialization: function!(b"fmi3ExitInitializationMode"),
                numbers: Numbers::Three { get: function!(b"fmi3GetFloat64"), set: function!(b"fmi3SetFloat64") },
                step: Step::Three(function!(b"fmi3DoStep")),
                state: None,
                derivative: if plan.derivatives {
                    Some(Derivative::Three(function!(b"fmi3GetDirectionalDerivative")))
                } else {
                    None
                },
                booleans: if plan.model.is_some() { Some(function!(b"fmi3GetBoolean")) } else { None },
                integers: if plan.model.as_ref().is_some_and(|model| !model.states.is_empty() || model.kinks.is_some())
                {
                    Some(function!(b"fmi3GetInt32"))
                } else {
                    None
                },
            }
        };
        let state = match (plan.keeps_state, two) {
            (false, _) => None,
            (true, true) => Some(StateFunctions {
                get: function!(b"fmi2GetFMUstate"),
                set: function!(b"fmi2SetFMUstate"),
                free: function!(b"fmi2FreeFMUstate"),
            }),
            (true, false) => Some(StateFunctions {
                get: function!(b"fmi3GetFMUState"),
                set: function!(b"fmi3SetFMUState"),
                free: function!(b"fmi3FreeFMUState"),
            }),
        };
        let functions = Functions { state, ..functions };
        let text = |text: &str| CString::new(text).map_err(|_| wrong(&"a text has a zero in it"));
        let (name, token) = (text("rimbench")?, text(&plan.token)?);
        let resources = plan.resources.display();
        let mut callbacks = None;
        let instance = if two {
            let resources = text(&uri(&plan.resources))?;
            let given = callbacks.insert(Box::new(Callbacks2 {
                log: log_2,
                allocate: calloc,
                free,
                finished: ptr::null(),
                environment,
            }));
            type Instantiate = unsafe extern "C" fn(
                *const c_char,
                c_int,
                *const c_char,
                *const c_char,
                *const Callbacks2,
                c_int,
                c_int,
            ) -> Instance;
            let instantiate: Instantiate = function!(b"fmi2Instantiate");
            // SAFETY: types of the standard; the callbacks live as long as the instance. 1: fmi2CoSimulation.
            unsafe { instantiate(name.as_ptr(), 1, token.as_ptr(), resources.as_ptr(), &raw const **given, 0, 0) }
        } else {
            let resources = text(&format!("{resources}/"))?;
            type Instantiate = unsafe extern "C" fn(
                *const c_char,
                *const c_char,
                *const c_char,
                bool,
                bool,
                bool,
                bool,
                *const u32,
                usize,
                *mut c_void,
                Option<Log3>,
                *const c_void,
            ) -> Instance;
            let instantiate: Instantiate = function!(b"fmi3InstantiateCoSimulation");
            // SAFETY: types of the standard; what `environment` points to lives as long as the instance.
            unsafe {
                instantiate(
                    name.as_ptr(),
                    token.as_ptr(),
                    resources.as_ptr(),
                    false,
                    false,
                    false,
                    false,
                    ptr::null(),
                    0,
                    environment,
                    Some(log_3),
                    ptr::null(),
                )
            }
        };
        if instance.is_null() {
            let said = said.lock().map(|said| said.clone()).unwrap_or_default();
            let said = if said.is_empty() { "it does not say why".to_owned() } else { said };
            return Err(wrong(&format!("no instance can be made: {said}")));
        }
        let references = |list: &[Scaled]| list.iter().map(|variable| variable.reference).collect::<Vec<_>>();
        let mut loaded = Loaded {
            functions,
            instance,
            copies: vec![Slot { kept: None, used: true }],
            present: 0,
            inputs: references(&plan.inputs),
            outputs: references(&plan.outputs),
            rates: plan.rates.as_deref().map(references).unwrap_or_default(),
            observed: references(&plan.observed),
            room: Vec::new(),
            truths: Vec::new(),
            integers: Vec::new(),
            said: ManuallyDrop::new(said),
            callbacks: ManuallyDrop::new(callbacks),
            library: ManuallyDrop::new(library),
            probed: Probed::default(),
            stepping: false,
            worst: Cell::new(0),
            plan,
        };
        loaded.begin()?;
        loaded.stepping = true;
        Ok(loaded)
    }

    /// From instantiation to step mode.
    fn begin(&mut self) -> Result<(), String> {
        let (instance, two) = (self.instance, self.plan.version_2);
        let starts = self.plan.starts.clone();
        for start in &starts {
            self.set_start(start)?;
        }
        // SAFETY: types of the standard, and an instance that is alive; so in all that follows.
        let status = if two {
            type Setup = unsafe extern "C" fn(Instance, c_int, f64, f64, c_int, f64) -> c_int;
            type Enter = unsafe extern "C" fn(Instance) -> c_int;
            let (setup, enter): (Setup, Enter) =
                (self.find(b"fmi2SetupExperiment")?, self.find(b"fmi2EnterInitializationMode")?);
            let status = unsafe { setup(instance, 0, 0.0, 0.0, 0, 0.0) };
            self.check(status, "fmi2SetupExperiment")?;
            unsafe { enter(instance) }
        } else {
            type Enter = unsafe extern "C" fn(Instance, bool, f64, f64, bool, f64) -> c_int;
            let enter: Enter = self.find(b"fmi3EnterInitializationMode")?;
            unsafe { enter(instance, false, 0.0, 0.0, false, 0.0) }
        };
        self.check(status, "EnterInitializationMode")?;
        let status = unsafe { (self.functions.exit_initialization)(instance) };
        self.check(status, "ExitInitializationMode")
    }

    fn find<F: Copy>(&self, name: &[u8]) -> Result<F, String> {
        // SAFETY: callers give the type that the standard has for the name.
        let found = unsafe { self.library.get::<F>(name) };
        found.map(|function| *function).map_err(|error| {
            format!(
                "{}: its library has no {}: {}",
                self.plan.file.display(),
                String::from_utf8_lossy(name),
                why(&error)
            )
        })
    }

    fn set_start(&mut self, start: &Start) -> Result<(), String> {
        let (instance, two) = (self.instance, self.plan.version_2);
        type Set2<T> = unsafe extern "C" fn(Instance, *const u32, usize, *const T) -> c_int;
        type Set3<T> = unsafe extern "C" fn(Instance, *const u32, usize, *const T, usize) -> c_int;
        let status = match (start, two) {
            (Start::Number(at, value), _) => return self.set(&[*at], &[*value]),
            (Start::Integer(at, value), true) => unsafe {
                self.find::<Set2<c_int>>(b"fmi2SetInteger")?(instance, at, 1, value)
            },
            (Start::Integer(at, value), false) => unsafe {
                self.find::<Set3<i32>>(b"fmi3SetInt32")?(instance, at, 1, value, 1)
            },
            (Start::Boolean(at, value), true) => unsafe {
                self.find::<Set2<c_int>>(b"fmi2SetBoolean")?(instance, at, 1, &c_int::from(*value))
            },
            (Start::Boolean(at, value), false) => unsafe {
                self.find::<Set3<bool>>(b"fmi3SetBoolean")?(instance, at, 1, value, 1)
            },
            (Start::Text(at, value), two) => {
                let text = CString::new(value.as_str()).map_err(|_| "a start value has a zero in it")?;
                let pointer = text.as_ptr();
                if two {
                    unsafe { self.find::<Set2<*const c_char>>(b"fmi2SetString")?(instance, at, 1, &pointer) }
                } else {
                    unsafe { self.find::<Set3<*const c_char>>(b"fmi3SetString")?(instance, at, 1, &pointer, 1) }
                }
            }
        };
        self.check(status, "setting a start value")
    }

    /// A status as a result: `OK` and `Warning` are none.
    fn check(&self, status: c_int, what: &str) -> Result<(), String> {
        if (0..=1).contains(&status) {
            return Ok(());
        }
        self.worst.set(self.worst.get().max(if (0..=5).contains(&status) { status % 5 } else { FATAL }));
        let name = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];
        let name = usize::try_from(status)
            .ok()
            .and_then(|status| name.get(status))
            .copied()
            .unwrap_or("a status that there is not");
        let said = self.said.lock().map(|mut said| std::mem::take(&mut *said)).unwrap_or_default();
        let said = if said.is_empty() { String::new() } else { format!(": {said}") };
        Err(format!("{}: {what} returned {name}{said}", self.plan.file.display()))
    }

    fn set(&self, references: &[u32], values: &[f64]) -> Result<(), String> {
        if references.is_empty() {
            return Ok(());
        }
        let n = references.len();
        let status = match self.functions.numbers {
            Numbers::Two { set, .. } => unsafe { set(self.instance, references.as_ptr(), n, values.as_ptr()) },
            Numbers::Three { set, .. } => unsafe {
                set(self.instance, references.as_ptr(), n, values.as_ptr(), values.len())
            },
        };
        self.check(status, "setting a number")
    }

    fn get(&self, references: &[u32], values: &mut [f64]) -> Result<(), String> {
        if references.is_empty() {
            return Ok(());
        }
        let n = references.len();
        let status = match self.functions.numbers {
            Numbers::Two { get, .. } => unsafe { get(self.instance, references.as_ptr(), n, values.as_mut_ptr()) },
            Numbers::Three { get, .. } => unsafe {
                get(self.instance, references.as_ptr(), n, values.as_mut_ptr(), values.len())
            },
        };
        self.check(status, "getting a number")
    }

    /// Sets the inputs, given in SI.
    fn put(&mut self, u: &[f64]) -> Result<(), String> {
        if u.len() != self.inputs.len() {
            return Err(format!("{} inputs for {}", u.len(), self.inputs.len()));
        }
        let mut room = std::mem::take(&mut self.room);
        room.clear();
        room.extend(u.iter().zip(&self.plan.inputs).map(|(u, scale)| scale.inwards(*u)));
        let done = self.set(&self.inputs, &room);
        self.room = room;
        done
    }

    /// Appends the values of some variables, in SI.
    fn take(&self, references: &[u32], scales: &[Scaled], output: &mut Vec<f64>) -> Result<(), String> {
        let from = output.len();
        output.resize(from + references.len(), 0.0);
        self.get(references, &mut output[from..])?;
        output[from..].iter_mut().zip(scales).for_each(|(value, scale)| *value = scale.outwards(*value));
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
        let Some(functions) = &self.functions.state else { return Err("it keeps no state".to_owned()) };
        let mut kept = self.copies[id].kept.unwrap_or(ptr::null_mut());
        let status = unsafe { (functions.get)(self.instance, &raw mut kept) };
        self.copies[id].kept = (!kept.is_null()).then_some(kept);
        self.check(status, "getting its state")
    }

    fn release(&mut self, kept: Option<Keep>) {
        if let (Some(functions), Some(mut kept)) = (&self.functions.state, kept) {
            // What cannot be freed is the FMU's loss.
            let _ = unsafe { (functions.free)(self.instance, &raw mut kept) };
        }
    }

    /// `∂unknowns/∂inputs`, row by row, in SI; the unknowns are outputs, or their rates, from a place on.
    fn jacobian(&self, unknowns: &[u32], first: usize, of_rates: bool, output: &mut Vec<f64>) -> Result<(), String> {
        let scales = if of_rates { self.plan.rates.as_deref().unwrap_or_default() } else { &*self.plan.outputs };
        let scales = &scales[first..];
        let (rows, columns) = (unknowns.len(), self.inputs.len());
        let from = output.len();
        output.resize(from + rows * columns, 0.0);
        let Some(derivative) = self.functions.derivative else {
            return Err("it has no directional derivatives".to_owned());
        };
        let mut column = vec![0.0; rows];
        for (at, (input, scale)) in self.inputs.iter().zip(&self.plan.inputs).enumerate() {
            let status = match derivative {
                Derivative::Two(call) => unsafe {
                    call(self.instance, unknowns.as_ptr(), rows, input, 1, &1.0, column.as_mut_ptr())
                },
                Derivative::Three(call) => unsafe {
                    call(self.instance, unknowns.as_ptr(), rows, input, 1, &1.0, 1, column.as_mut_ptr(), rows)
                },
            };
            self.check(status, "a directional derivative")?;
            for (row, (value, own)) in column.iter().zip(scales).enumerate() {
                output[from + row * columns + at] = value * (own.factor / scale.factor);
            }
        }
        Ok(())
    }

    /// Appends rates, feedthrough and rate gain as steps from here show them, and their relative error; the state is what it was
    /// afterwards, with inputs `u`.
    ///
    /// ```text
    /// r = (y(t + δ) − y(t))/δ         inputs held
    /// D = (y(u + Δ) − y(u − Δ))/2Δ    at once
    /// R = (r(u + Δ) − r(u − Δ))/2Δ    each from the same state
    /// ```
    /// With δ and Δ, and with half of both: the latter is the answer, and what lies between the two its error.
    fn probe(&mut self, probe: Probe, t: f64, u: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
        let mut probed = std::mem::take(&mut self.probed);
        let kept = self.keep_for_probing(&mut probed, u);
        let begun = kept.is_ok();
        let mut done = kept.and_then(|()| self.probe_twice(&mut probed, probe, t, u));
        // Back to the state that was kept just now, whatever has become of it; but after Fatal nothing may be called.
        if begun && self.worst.get() < FATAL {
            done = done.and(self.set_state(probed.kept).and_then(|()| self.put(u)));
        }
        if done.is_ok() {
            output.extend_from_slice(&probed.fine);
            // Of a mechanics only velocities matter: what a step adds to a position is of the step, and not of the model.
            let first = if self.plan.smooth { self.outputs.len() / 2 } else { 0 };
            output.push(probed.error(probe, first, u));
        }
        self.probed = probed;
        done.map_err(|why| format!("{why} (while it was probed for how its outputs move)"))
    }

    /// Keeps the present state, with these inputs, as that from which probing goes out.
    fn keep_for_probing(&mut self, probed: &mut Probed, u: &[f64]) -> Result<(), String> {
        self.put(u)?;
        let Some(functions) = &self.functions.state else { return Err("it keeps no state".to_owned()) };
        let mut kept = probed.kept.unwrap_or(ptr::null_mut());
        let status = unsafe { (functions.get)(self.instance, &raw mut kept) };
        probed.kept = (!kept.is_null()).then_some(kept);
        self.check(status, "getting its state")
    }

    fn probe_twice(&mut self, probed: &mut Probed, probe: Probe, t: f64, u: &[f64]) -> Result<(), String> {
        probed.magnitude.clear();
        probed.magnitude.resize(self.outputs.len(), 0.0);
        for share in [1.0, 0.5] {
            std::mem::swap(&mut probed.coarse, &mut probed.fine);
            self.probe_once(probed, Probe { step: share * probe.step, change: share * probe.change, ..probe }, t, u)?;
        }
        Ok(())
    }

    /// Fills `probed.fine`.
    fn probe_once(&mut self, probed: &mut Probed, probe: Probe, t: f64, u: &[f64]) -> Result<(), String> {
        let (p, n) = (self.outputs.len(), u.len());
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
        self.take(&self.outputs, &self.plan.outputs, before)?;
        self.step(t, h)?;
        after.clear();
        self.take(&self.outputs, &self.plan.outputs, after)
    }

    fn set_state(&self, kept: Option<Keep>) -> Result<(), String> {
        let (Some(functions), Some(kept)) = (&self.functions.state, kept) else {
            return Err("it keeps no state".to_owned());
        };
        let status = unsafe { (functions.set)(self.instance, kept) };
        self.check(status, "setting its state")
    }

    /// Appends the parts of the interface model.
    fn read_model(
        &self,
        input: &[f64],
        output: &mut Vec<f64>,
        truths: &mut Vec<u8>,
        integers: &mut Vec<i32>,
    ) -> Result<(), String> {
        let Some(model) = &self.plan.model else { return Err("it has no interface model".to_owned()) };
        let [step, kinks @ ..] = input else { return Err("a model needs a step".to_owned()) };
        self.set(&[model.step], &[*step])?;
        let append = |output: &mut Vec<f64>, &(reference, count): &(u32, usize)| {
            let from = output.len();
            output.resize(from + count, 0.0);
            self.get(&[reference], &mut output[from..])
        };
        let mut append_integers = |output: &mut Vec<f64>, reference: u32, count: usize| {
            let Some(get) = self.functions.integers else { return Err("it gives no whole numbers".to_owned()) };
            integers.clear();
            integers.resize(count, 0);
            let status = unsafe { get(self.instance, &reference, 1, integers.as_mut_ptr(), count) };
            self.check(status, "getting a whole number")?;
            output.extend(integers.iter().map(|number| f64::from(*number)));
            Ok(())
        };
        model.numbers.iter().try_for_each(|part| append(output, part))?;
        for &(reference, count) in &model.truths {
            let Some(get) = self.functions.booleans else { return Err("it gives no truths".to_owned()) };
            truths.clear();
            truths.resize(count, 0);
            let status = unsafe { get(self.instance, &reference, 1, truths.as_mut_ptr(), count) };
            self.check(status, "getting a truth")?;
            output.extend(truths.iter().map(|truth| f64::from(u8::from(*truth != 0))));
        }
        model.friction.iter().try_for_each(|part| append(output, part))?;
        model.states.iter().try_for_each(|&(reference, count)| append_integers(output, reference, count))?;
        if let (Some((count, parts)), [wanted, ..]) = (&model.kinks, kinks)
            && *wanted != 0.0
        {
            append_integers(output, *count, 1)?;
            parts.iter().try_for_each(|part| append(output, part))?;
        }
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Result<(), String> {
        let status = match self.functions.step {
            Step::Two(call) => unsafe { call(self.instance, t, h, 0) },
            Step::Three(call) => {
                let (mut event, mut terminate, mut early, mut last) = (0, 0, 0, t);
                let status = unsafe {
                    call(self.instance, t, h, false, &raw mut event, &raw mut terminate, &raw mut early, &raw mut last)
                };
                if (0..=1).contains(&status) && (terminate != 0 || early != 0) {
                    let what = if terminate != 0 {
                        "wants the simulation to end"
                    } else {
                        "returned before the end of its step"
                    };
                    return Err(format!("{}: it {what} at {last} s", self.plan.file.display()));
                }
                status
            }
        };
        self.check(status, "DoStep")
    }
}

impl Host for Loaded {
    fn ask(&mut self, ask: Ask, id: u32, input: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
        output.clear();
        if self.worst.get() == FATAL {
            return Err(format!(
                "{}: it has returned Fatal before: nothing more can be asked of it",
                self.plan.file.display()
            ));
        }
        // What it said of calls that went well explains no other.
        if let Ok(mut said) = self.said.lock() {
            said.clear();
        }
        if ask == Ask::Drop {
            // Its room is for the next copy.
            self.copies.get_mut(id as usize).ok_or("there is no such copy")?.used = false;
            return Ok(());
        }
        self.activate(id as usize)?;
        match ask {
            Ask::Outputs => {
                self.put(input)?;
                self.take(&self.outputs, &self.plan.outputs, output)
            }
            Ask::Step => {
                let [t, h, u @ ..] = input else { return Err("a step needs a time and a length".to_owned()) };
                self.put(u)?;
                self.step(*t, *h)?;
                self.take(&self.outputs, &self.plan.outputs, output)
            }
            Ask::Rates => {
                let [t, u @ ..] = input else { return Err("rates need a time".to_owned()) };
                if let Some(probe) = self.plan.probe {
                    let [longest, u @ ..] = u else { return Err("probing needs a longest step".to_owned()) };
                    return self.probe(Probe { step: probe.step.min(*longest), ..probe }, *t, u, output);
                }
                self.put(u)?;
                self.take(&self.rates, self.plan.rates.as_deref().unwrap_or_default(), output)?;
                if self.plan.smooth {
                    // Positions and velocities do not follow forces at once, and an FMU may refuse to say by how much.
                    let (rows, columns) = (self.outputs.len(), self.inputs.len());
                    output.resize(output.len() + rows * columns + rows / 2 * columns, 0.0);
                    return self.jacobian(&self.rates[rows / 2..], rows / 2, true, output);
                }
                self.jacobian(&self.outputs, 0, false, output)?;
                self.jacobian(&self.rates, 0, true, output)
            }
            Ask::Model => {
                // Room that is there already, lent for the while.
                let (mut truths, mut integers) = (std::mem::take(&mut self.truths), std::mem::take(&mut self.integers));
                let read = self.read_model(input, output, &mut truths, &mut integers);
                (self.truths, self.integers) = (truths, integers);
                read
            }
            Ask::Observe => {
                if let Some(step) = self.plan.step {
                    self.set(&[step], input)?;
                }
                self.take(&self.observed, &self.plan.observed, output)
            }
            Ask::Work => {
                let Some(work) = self.plan.work else { return Err("it counts no work".to_owned()) };
                self.take(&[work.reference], &[work], output)
            }
            Ask::Copy => {
                let free = (0..self.copies.len()).find(|at| !self.copies[*at].used && *at != self.present);
                let id = free.unwrap_or(self.copies.len());
                if free.is_none() {
                    self.copies.push(Slot::default());
                }
                self.store(id)?;
                self.copies[id].used = true;
                output.push(id as f64);
                Ok(())
            }
            Ask::Drop => Ok(()),
        }
    }
}

impl Drop for Loaded {
    fn drop(&mut self) {
        // After Fatal no function may be called, and whatever it left running may still need its code and its log.
        if self.worst.get() == FATAL {
            return;
        }
        for id in 0..self.copies.len() {
            let kept = self.copies[id].kept.take();
            self.release(kept);
        }
        let kept = self.probed.kept.take();
        self.release(kept);
        // SAFETY: the instance is alive, and nobody has it afterwards; the library goes last, because the rest calls into it or is
        // called from it. Nothing is dropped twice: `self` is not used again.
        unsafe {
            if self.stepping && self.worst.get() < ERROR {
                let _ = (self.functions.terminate)(self.instance);
            }
            (self.functions.free)(self.instance);
            ManuallyDrop::drop(&mut self.callbacks);
            ManuallyDrop::drop(&mut self.said);
            ManuallyDrop::drop(&mut self.library);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[cfg(unix)]
    use guest::{Guest, loaded, rates};

    /// An FMU without an archive: one input, two outputs.
    #[cfg(unix)]
    mod guest {
        use super::super::*;

        pub(super) const STEP: f64 = 1e-3;
        pub(super) const CHANGE: f64 = 1e-6;

        pub(super) struct Guest {
            pub(super) x: [f64; 2],
            pub(super) u: f64,
            /// What a step makes of the state.
            pub(super) advance: fn([f64; 2], f64, f64) -> [f64; 2],
            pub(super) say: fn([f64; 2], f64) -> [f64; 2],
            /// What the step after so many more returns, if it does not go well.
            pub(super) fault: Option<(usize, c_int)>,
            /// What keeping a state returns.
            pub(super) keeping: c_int,
            pub(super) longest: f64,
            pub(super) states_set: usize,
            pub(super) after_fatal: usize,
            pub(super) fatal: bool,
        }

        impl Guest {
            pub(super) fn new(
                x: [f64; 2],
                advance: fn([f64; 2], f64, f64) -> [f64; 2],
                say: fn([f64; 2], f64) -> [f64; 2],
            ) -> Guest {
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
            let guest = unsafe { &mut *instance.cast::<Guest>() };
            guest.after_fatal += usize::from(guest.fatal);
            guest
        }

        unsafe extern "C" fn nothing(_: Instance) {}
        unsafe extern "C" fn well(_: Instance) -> c_int {
            0
        }
        unsafe extern "C" fn get(instance: Instance, _: *const u32, n: usize, values: *mut f64, _: usize) -> c_int {
            let guest = unsafe { called(instance) };
            unsafe { std::slice::from_raw_parts_mut(values, n) }.copy_from_slice(&(guest.say)(guest.x, guest.u));
            0
        }
        unsafe extern "C" fn set(instance: Instance, _: *const u32, _: usize, values: *const f64, _: usize) -> c_int {
            unsafe { called(instance).u = *values };
            0
        }
        unsafe extern "C" fn step(
            instance: Instance,
            _: f64,
            h: f64,
            _: bool,
            _: *mut u8,
            _: *mut u8,
            _: *mut u8,
            _: *mut f64,
        ) -> c_int {
            let guest = unsafe { called(instance) };
            guest.longest = guest.longest.max(h);
            match &mut guest.fault {
                Some((0, status)) => {
                    guest.fatal = *status == FATAL;
                    return *status;
                }
                Some((left, _)) => *left -= 1,
                None => {}
            }
            guest.x = (guest.advance)(guest.x, guest.u, h);
            0
        }
        unsafe extern "C" fn get_state(instance: Instance, kept: *mut Keep) -> c_int {
            let guest = unsafe { called(instance) };
            if guest.keeping == 0 {
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
            let guest = unsafe { called(instance) };
            let [x, y, u] = unsafe { *kept.cast::<[f64; 3]>() };
            (guest.x, guest.u) = ([x, y], u);
            guest.states_set += 1;
            0
        }
        unsafe extern "C" fn free_state(_: Instance, kept: *mut Keep) -> c_int {
            drop(unsafe { Box::from_raw((*kept).cast::<[f64; 3]>()) });
            0
        }

        /// As an actuator with direct feedthrough, probed by [`STEP`] and [`CHANGE`]; `guest` outlives it.
        pub(super) fn loaded(guest: &mut Guest) -> Loaded {
            let plain = |reference| Scaled { reference, factor: 1.0, offset: 0.0 };
            let plan = Plan {
                file: "guest.fmu".into(),
                library: "".into(),
                needs: Vec::new(),
                resources: "".into(),
                version_2: false,
                token: String::new(),
                starts: Vec::new(),
                inputs: vec![plain(0)],
                outputs: vec![plain(1), plain(2)],
                rates: None,
                derivatives: false,
                smooth: false,
                probe: Some(Probe { step: STEP, change: CHANGE, feedthrough: true }),
                keeps_state: true,
                model: None,
                step: None,
                observed: Vec::new(),
                work: None,
            };
            Loaded {
                functions: Functions {
                    free: nothing,
                    terminate: well,
                    exit_initialization: well,
                    numbers: Numbers::Three { get, set },
                    step: Step::Three(step),
                    state: Some(StateFunctions { get: get_state, set: set_state, free: free_state }),
                    derivative: None,
                    booleans: None,
                    integers: None,
                },
                instance: (&raw mut *guest).cast(),
                copies: vec![Slot { kept: None, used: true }],
                present: 0,
                inputs: vec![0],
                outputs: vec![1, 2],
                rates: Vec::new(),
                observed: Vec::new(),
                room: Vec::new(),
                truths: Vec::new(),
                integers: Vec::new(),
                said: ManuallyDrop::new(Box::new(Said::default())),
                callbacks: ManuallyDrop::new(None),
                library: ManuallyDrop::new(libloading::os::unix::Library::this().into()),
                probed: Probed::default(),
                stepping: true,
                worst: Cell::new(0),
                plan,
            }
        }

        /// Rates, feedthrough, rate gain and the estimate, of steps of at most `longest` (s).
        pub(super) fn rates(loaded: &mut Loaded, longest: f64, u: f64) -> Result<Vec<f64>, String> {
            let mut output = Vec::new();
            loaded.ask(Ask::Rates, 0, &[0.0, longest, u], &mut output).map(|()| output)
        }
    }

    #[test]
    #[cfg(unix)]
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
    #[cfg(unix)]
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
    #[cfg(unix)]
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
    #[cfg(unix)]
    fn no_step_of_probing_is_longer_than_what_is_asked_for() {
        for (longest, taken) in [(1e-4, 1e-4), (1.0, guest::STEP)] {
            let mut guest = Guest::new([0.0, 0.0], |x, _, _| x, |x, _| x);
            rates(&mut loaded(&mut guest), longest, 0.0).unwrap();
            assert_eq!(guest.longest, taken);
        }
    }

    #[test]
    #[cfg(unix)]
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

    #[test]
    fn a_folder_of_any_name_is_a_uri() {
        let folder = std::path::Path::new("/models/my models/50 % é/resources");
        assert_eq!(uri(folder), "file:///models/my%20models/50%20%25%20%C3%A9/resources");
        assert_eq!(
            uri(std::path::Path::new("/models/rimbench-fmu-x1/resources")),
            "file:///models/rimbench-fmu-x1/resources"
        );
    }
}

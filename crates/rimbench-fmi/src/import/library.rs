//! The library of an FMU, loaded into this process.
//!
//! Types and names are those of the standards' `fmi3FunctionTypes.h` and `fmi2FunctionTypes.h`, by hand.

#![allow(unsafe_code, reason = "functions of a library that others wrote")]

mod functions;
mod probing;

use self::functions::{Derivative, Functions, Numbers, StateFunctions, Step};
use self::probing::Probed;
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
    // SAFETY: what it points to is a `Said`, as the caller says.
    let (Some(said), false) = (unsafe { said.cast::<Said>().as_ref() }, message.is_null()) else { return };
    // SAFETY: it is not null, so that it ends in zero, as the caller says.
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
    // SAFETY: the library hands on the environment that it was given, which is a `Said`, and a text, as the standard has it.
    unsafe { note(environment, message) };
}

unsafe extern "C" fn log_2(
    environment: *mut c_void,
    _name: *const c_char,
    _status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the library hands on the environment that it was given, which is a `Said`, and a text, as the standard has it.
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

/// A copy of an FMU's state.
#[derive(Default)]
struct Slot {
    /// The state while another copy is the present one, or what was one: the FMU may write over it.
    kept: Option<Keep>,
    /// Whether somebody has it.
    used: bool,
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
        let status = if two {
            type Setup = unsafe extern "C" fn(Instance, c_int, f64, f64, c_int, f64) -> c_int;
            type Enter = unsafe extern "C" fn(Instance) -> c_int;
            let (setup, enter): (Setup, Enter) =
                (self.find(b"fmi2SetupExperiment")?, self.find(b"fmi2EnterInitializationMode")?);
            // SAFETY: the types are those of the standard for these names, and the instance is alive and has just been made.
            let status = unsafe { setup(instance, 0, 0.0, 0.0, 0, 0.0) };
            self.check(status, "fmi2SetupExperiment")?;
            // SAFETY: as above, and the experiment has been set up.
            unsafe { enter(instance) }
        } else {
            type Enter = unsafe extern "C" fn(Instance, bool, f64, f64, bool, f64) -> c_int;
            let enter: Enter = self.find(b"fmi3EnterInitializationMode")?;
            // SAFETY: the type is that of the standard for this name, and the instance is alive and has just been made.
            unsafe { enter(instance, false, 0.0, 0.0, false, 0.0) }
        };
        self.check(status, "EnterInitializationMode")?;
        // SAFETY: the instance is alive and being initialised.
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
            (Start::Integer(at, value), true) => {
                let set = self.find::<Set2<c_int>>(b"fmi2SetInteger")?;
                // SAFETY: the type is that of the standard for this name, the instance is alive; one reference, one value.
                unsafe { set(instance, at, 1, value) }
            }
            (Start::Integer(at, value), false) => {
                let set = self.find::<Set3<i32>>(b"fmi3SetInt32")?;
                // SAFETY: as above.
                unsafe { set(instance, at, 1, value, 1) }
            }
            (Start::Boolean(at, value), true) => {
                let set = self.find::<Set2<c_int>>(b"fmi2SetBoolean")?;
                // SAFETY: as above; truths are whole numbers in FMI 2.0.
                unsafe { set(instance, at, 1, &c_int::from(*value)) }
            }
            (Start::Boolean(at, value), false) => {
                let set = self.find::<Set3<bool>>(b"fmi3SetBoolean")?;
                // SAFETY: as above.
                unsafe { set(instance, at, 1, value, 1) }
            }
            (Start::Text(at, value), two) => {
                let text = CString::new(value.as_str()).map_err(|_| "a start value has a zero in it")?;
                let pointer = text.as_ptr();
                if two {
                    let set = self.find::<Set2<*const c_char>>(b"fmi2SetString")?;
                    // SAFETY: as above; the text ends in zero and outlives the call.
                    unsafe { set(instance, at, 1, &pointer) }
                } else {
                    let set = self.find::<Set3<*const c_char>>(b"fmi3SetString")?;
                    // SAFETY: as above; the text ends in zero and outlives the call.
                    unsafe { set(instance, at, 1, &pointer, 1) }
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
        let n = references.len();
        if n != values.len() {
            return Err(format!("{} values for {n} variables", values.len()));
        }
        if n == 0 {
            return Ok(());
        }
        let status = match self.functions.numbers {
            // SAFETY: the instance is alive, and there is one value for each reference.
            Numbers::Two { set, .. } => unsafe { set(self.instance, references.as_ptr(), n, values.as_ptr()) },
            // SAFETY: the instance is alive, and each pointer goes with its count.
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
            // SAFETY: the instance is alive; FMI 2.0 has no arrays, and callers make room for a number for each reference.
            Numbers::Two { get, .. } => unsafe { get(self.instance, references.as_ptr(), n, values.as_mut_ptr()) },
            // SAFETY: the instance is alive, and each pointer goes with its count.
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
        // SAFETY: the instance is alive; `kept` is null or a state of it that has not been freed.
        let status = unsafe { (functions.get)(self.instance, &raw mut kept) };
        self.copies[id].kept = (!kept.is_null()).then_some(kept);
        self.check(status, "getting its state")
    }

    fn release(&mut self, kept: Option<Keep>) {
        if let (Some(functions), Some(mut kept)) = (&self.functions.state, kept) {
            // SAFETY: the instance is alive; the state is one of it, and who hands it over has it no more. What cannot be freed is the
            // FMU's loss.
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
                // SAFETY: the instance is alive; `rows` unknowns with room for as many numbers, one input with one seed.
                Derivative::Two(call) => unsafe {
                    call(self.instance, unknowns.as_ptr(), rows, input, 1, &1.0, column.as_mut_ptr())
                },
                // SAFETY: as above, and each pointer goes with its count.
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

    fn set_state(&self, kept: Option<Keep>) -> Result<(), String> {
        let (Some(functions), Some(kept)) = (&self.functions.state, kept) else {
            return Err("it keeps no state".to_owned());
        };
        // SAFETY: the instance is alive, and `kept` is a state of it that has not been freed: only `release` frees, as its last use.
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
            // SAFETY: the instance is alive; one reference, and room for `count` numbers.
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
            // SAFETY: the instance is alive; one reference, and room for `count` bytes, which any bits may fill.
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
            // SAFETY: the instance is alive and has been initialised.
            Step::Two(call) => unsafe { call(self.instance, t, h, 0) },
            Step::Three(call) => {
                let (mut event, mut terminate, mut early, mut last) = (0, 0, 0, t);
                // SAFETY: the instance is alive and has been initialised; there is room for all four that it tells, bytes being bytes
                // whatever it takes for a truth.
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

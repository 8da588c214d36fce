//! The functions of FMI 3.0 as a master calls them, written by hand after the standard's `fmi3FunctionTypes.h`, and what
//! those of FMI 2.0 share with them.
//!
//! Every call is held: a panic is `fmi3Fatal` and never goes through the caller. What the master hands over are
//! pointers that it vouches for, as the standard asks.

#![allow(unsafe_code, reason = "functions with names and pointers of another language")]

use super::instance::{Instance, Kept};
use std::ffi::{CStr, CString, c_char, c_void};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::ptr;

/// The same in both versions, as these are.
const OK: i32 = 0;
pub(super) const ERROR: i32 = 3;
const FATAL: i32 = 4;

/// Environment of the master, status, category, message.
type Log3 = Option<unsafe extern "C" fn(*mut c_void, i32, *const c_char, *const c_char)>;

/// Environment of the master, name of the instance, status, category, a format of printf, what it prints.
pub(super) type Log2 = Option<unsafe extern "C" fn(*mut c_void, *const c_char, i32, *const c_char, *const c_char, ...)>;

pub(super) enum Log {
    Three(Log3),
    /// With the name of the instance.
    Two(Log2, CString),
}

/// Where an instance may speak.
pub(super) struct Voice {
    pub(super) environment: *mut c_void,
    pub(super) log: Log,
}

/// An instance, and where it may speak.
pub struct Handle {
    pub(super) instance: Instance,
    voice: Voice,
    /// Texts that were asked for last.
    texts: Vec<CString>,
    /// Whether a call has panicked: what it has left is not to be relied on.
    broken: bool,
}

/// A state that a master keeps.
pub struct KeptState(Kept);

impl Voice {
    fn say(&self, status: i32, message: &str) {
        let (environment, category) = (self.environment, c"error".as_ptr());
        let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the master gave the function for this environment, and all texts outlive the call. The format prints
        // one text, whatever stands in it.
        unsafe {
            match &self.log {
                Log::Three(Some(log)) => log(environment, status, category, message.as_ptr()),
                Log::Two(Some(log), name) => {
                    log(environment, name.as_ptr(), status, category, c"%s".as_ptr(), message.as_ptr());
                }
                Log::Three(None) | Log::Two(None, _) => {}
            }
        }
    }
}

/// Makes an instance, or says why there is none.
pub(super) fn instantiate(voice: Voice, make: impl FnOnce() -> Result<Instance, String>) -> *mut Handle {
    match catch_unwind(AssertUnwindSafe(make)) {
        Ok(Ok(instance)) => Box::into_raw(Box::new(Handle { instance, voice, texts: Vec::new(), broken: false })),
        Ok(Err(message)) => {
            voice.say(ERROR, &message);
            ptr::null_mut()
        }
        Err(_) => ptr::null_mut(),
    }
}

/// Calls `act` on an instance; a refusal is told and becomes `fmi3Error`, a panic `fmi3Fatal`.
pub(super) fn with(handle: *mut Handle, act: impl FnOnce(&mut Handle) -> Result<(), String>) -> i32 {
    // SAFETY: the master hands over what it was given when it made the instance, from one thread at a time.
    let Some(handle) = (unsafe { handle.as_mut() }) else { return ERROR };
    if handle.broken {
        handle.voice.say(FATAL, "a call before this one has panicked: this instance can only be freed");
        return FATAL;
    }
    match catch_unwind(AssertUnwindSafe(|| act(&mut *handle))) {
        Ok(Ok(())) => OK,
        Ok(Err(message)) => {
            handle.voice.say(ERROR, &message);
            ERROR
        }
        Err(_) => {
            handle.broken = true;
            handle.voice.say(FATAL, "a defect of rimbench: the model panicked");
            FATAL
        }
    }
}

/// A list that a master hands over.
///
/// # Safety
/// `first` points to `count` values, or `count` is 0.
pub(super) unsafe fn list<'a, T>(first: *const T, count: usize) -> Result<&'a [T], String> {
    match (count, first.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(format!("a list of {count} values is a null pointer")),
        // SAFETY: it is not null, so that there are as many values as the caller says.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts(first, count) }),
    }
}

/// Room that a master hands over, in which nothing need stand yet.
///
/// # Safety
/// `first` points to room for `count` values that nobody else uses, or `count` is 0.
pub(super) unsafe fn room<'a, T>(first: *mut T, count: usize) -> Result<&'a mut [MaybeUninit<T>], String> {
    match (count, first.is_null()) {
        (0, _) => Ok(&mut []),
        (_, true) => Err(format!("room for {count} values is a null pointer")),
        // SAFETY: it is not null, so that the room is as large as the caller says, and nobody else's; what stands there
        // is not looked at.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts_mut(first.cast(), count) }),
    }
}

/// Writes a value where a master wants it, if it does.
///
/// # Safety
/// `place` has room for a value, or is null.
unsafe fn tell<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: it is not null, so that there is room; what stands there is not looked at.
        unsafe { place.write(value) };
    }
}

/// # Safety
/// A text that ends in zero, or null.
pub(super) unsafe fn words<'a>(text: *const c_char, what: &str) -> Result<&'a str, String> {
    if text.is_null() {
        return Err(format!("{what} is a null pointer"));
    }
    // SAFETY: it is not null, so that it ends in zero, as the caller says.
    unsafe { CStr::from_ptr(text) }.to_str().map_err(|_| format!("{what} is not in UTF-8"))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    event_mode: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _intermediates: usize,
    environment: *mut c_void,
    log: Log3,
    _update: *const c_void,
) -> *mut Handle {
    instantiate(Voice { environment, log: Log::Three(log) }, || {
        // SAFETY: both are texts that end in zero and outlive this call, as the standard has it, or null.
        let (token, resources) = unsafe { (words(token, "the token")?, words(resources, "the resource path")?) };
        if event_mode {
            return Err("event mode is not offered".to_owned());
        }
        Instance::new(token, Path::new(resources.strip_prefix("file://").unwrap_or(resources)))
    })
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3FreeInstance(handle: *mut Handle) {
    if !handle.is_null() {
        // SAFETY: it came from `Box::into_raw`, and the master gives it back once.
        let owned = unsafe { Box::from_raw(handle) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(owned)));
    }
}

#[unsafe(no_mangle)]
extern "C" fn fmi3EnterInitializationMode(
    handle: *mut Handle,
    _has_tolerance: bool,
    _tolerance: f64,
    start: f64,
    _has_stop: bool,
    _stop: f64,
) -> i32 {
    with(handle, |handle| handle.instance.enter_initialization(start))
}

#[unsafe(no_mangle)]
pub(super) extern "C" fn fmi3ExitInitializationMode(handle: *mut Handle) -> i32 {
    with(handle, |handle| handle.instance.exit_initialization())
}

#[unsafe(no_mangle)]
pub(super) extern "C" fn fmi3Terminate(handle: *mut Handle) -> i32 {
    with(handle, |handle| {
        handle.instance.terminate();
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub(super) extern "C" fn fmi3Reset(handle: *mut Handle) -> i32 {
    with(handle, |handle| handle.instance.reset())
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SetDebugLogging(
    handle: *mut Handle,
    _on: bool,
    _count: usize,
    _categories: *const *const c_char,
) -> i32 {
    with(handle, |_| Ok(()))
}

/// Functions that hand over values of variables or take them, `$take` being `room` or `list`.
macro_rules! of_values {
    ($($name:ident($take:ident $pointer:ty) |$handle:ident, $refs:ident, $values:ident| $act:expr;)*) => {$(
        #[unsafe(no_mangle)]
        pub(super) unsafe extern "C" fn $name(
            h: *mut Handle,
            refs: *const u32,
            n: usize,
            values: $pointer,
            count: usize,
        ) -> i32 {
            with(h, |$handle| {
                // SAFETY: the standard has a master hand over `n` references and `count` values or room for them, for
                // the length of this call.
                let ($refs, $values) = unsafe { (list(refs, n)?, $take(values, count)?) };
                $act
            })
        }
    )*};
}

of_values! {
    fmi3GetFloat64(room *mut f64) |handle, refs, values| handle.instance.get_numbers(refs, values);
    fmi3GetBoolean(room *mut bool) |handle, refs, values| handle.instance.get_booleans(refs, values);
    fmi3GetInt32(room *mut i32) |handle, refs, values| handle.instance.get_integers(refs, values);
    fmi3GetString(room *mut *const c_char) |handle, refs, values| {
        pairs(refs, values).map(drop)?;
        let texts = refs.iter().map(|at| Ok(CString::new(handle.instance.get_text(*at)?).unwrap_or_default()));
        handle.texts = texts.collect::<Result<_, String>>()?;
        values.iter_mut().zip(&handle.texts).for_each(|(value, text)| {
            value.write(text.as_ptr());
        });
        Ok(())
    };
    fmi3SetFloat64(list *const f64) |handle, refs, values| {
        pairs(refs, values)?.try_for_each(|(at, value)| handle.instance.set_number(*at, *value))
    };
    // As bytes: what a master hands over need be none of the two that a `bool` may have.
    fmi3SetBoolean(list *const u8) |handle, refs, values| {
        pairs(refs, values)?.try_for_each(|(at, value)| handle.instance.set_boolean(*at, *value != 0))
    };
    fmi3SetString(list *const *const c_char) |handle, refs, values| {
        pairs(refs, values)?.try_for_each(|(at, text)| {
            // SAFETY: each value is a text that ends in zero and outlives this call, as the standard has it, or null.
            handle.instance.set_text(*at, unsafe { words(*text, "a text") }?)
        })
    };
}

/// Variables with their values, one each.
pub(super) fn pairs<'a, T>(
    references: &'a [u32],
    values: &'a [T],
) -> Result<impl Iterator<Item = (&'a u32, &'a T)>, String> {
    if references.len() == values.len() {
        Ok(references.iter().zip(values))
    } else {
        Err(format!("{} variables have {} values", references.len(), values.len()))
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DoStep(
    h: *mut Handle,
    t: f64,
    length: f64,
    _no_way_back: bool,
    event: *mut bool,
    terminate: *mut bool,
    early: *mut bool,
    last: *mut f64,
) -> i32 {
    let status = with(h, |handle| handle.instance.do_step(t, length));
    // SAFETY: a master hands over room for each of the four, or null for what it does not want to know.
    unsafe {
        [event, terminate, early].into_iter().for_each(|place| tell(place, false));
        tell(last, if status == OK { t + length } else { t });
    }
    status
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3GetDirectionalDerivative(
    h: *mut Handle,
    unknowns: *const u32,
    n_unknowns: usize,
    knowns: *const u32,
    n_knowns: usize,
    seed: *const f64,
    n_seed: usize,
    out: *mut f64,
    n_out: usize,
) -> i32 {
    with(h, |handle| {
        // SAFETY: each pointer goes with the count behind it, and `out` is room for this call alone, as the standard
        // has it.
        let (unknowns, knowns, seed, out) =
            unsafe { (list(unknowns, n_unknowns)?, list(knowns, n_knowns)?, list(seed, n_seed)?, room(out, n_out)?) };
        handle.instance.directional(unknowns, knowns, seed, out)
    })
}

/// Hands a state over; one that is there already is written over, as the standard says.
///
/// # Safety
/// `place` is null, or what stands there is null or a state that was handed over and is not freed.
unsafe fn hand_over(kept: Kept, place: *mut *mut KeptState) -> Result<(), String> {
    // SAFETY: as the caller says.
    let place = unsafe { place.as_mut() }.ok_or("there is no room for a state")?;
    // SAFETY: as the caller says; a state that was handed over came from a box.
    match unsafe { place.as_mut() } {
        Some(old) => old.0 = kept,
        None => *place = Box::into_raw(Box::new(KeptState(kept))),
    }
    Ok(())
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3GetFMUState(h: *mut Handle, state: *mut *mut KeptState) -> i32 {
    with(h, |handle| {
        let kept = handle.instance.keep()?;
        // SAFETY: the standard has a master hand over null, or a state that it got from here.
        unsafe { hand_over(kept, state) }
    })
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3SetFMUState(h: *mut Handle, state: *mut KeptState) -> i32 {
    with(h, |handle| {
        // SAFETY: a state that the master got from here and has not freed, as the standard has it, or null.
        let state = unsafe { state.as_ref() }.ok_or("there is no state")?;
        handle.instance.restore(&state.0)
    })
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3FreeFMUState(h: *mut Handle, state: *mut *mut KeptState) -> i32 {
    with(h, |_| {
        // SAFETY: the place where the master keeps a state, as the standard has it, or null.
        let place = unsafe { state.as_mut() }.ok_or("there is no state")?;
        if !place.is_null() {
            // SAFETY: it came from `Box::into_raw` and is given back once: null stands there afterwards.
            drop(unsafe { Box::from_raw(*place) });
            *place = ptr::null_mut();
        }
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3SerializedFMUStateSize(
    h: *mut Handle,
    state: *mut KeptState,
    size: *mut usize,
) -> i32 {
    with(h, |handle| {
        // SAFETY: a state that the master got from here and has not freed, as the standard has it, or null.
        let state = unsafe { state.as_ref() }.ok_or("there is no state")?;
        if size.is_null() {
            return Err("there is no room for a size".to_owned());
        }
        let length = handle.instance.serialised_len(&state.0)?;
        // SAFETY: a master hands over room for a number.
        unsafe { tell(size, length) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3SerializeFMUState(
    h: *mut Handle,
    state: *mut KeptState,
    bytes: *mut u8,
    size: usize,
) -> i32 {
    with(h, |handle| {
        // SAFETY: a state that the master got from here and has not freed, or null, and room for `size` bytes for this
        // call alone.
        let (state, bytes) = unsafe { (state.as_ref().ok_or("there is no state")?, room(bytes, size)?) };
        let serialised = handle.instance.serialised(&state.0)?;
        if serialised.len() != bytes.len() {
            return Err(format!("the state has {} bytes, and there is room for {}", serialised.len(), bytes.len()));
        }
        bytes.iter_mut().zip(serialised).for_each(|(place, byte)| {
            place.write(byte);
        });
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3DeserializeFMUState(
    h: *mut Handle,
    bytes: *const u8,
    size: usize,
    state: *mut *mut KeptState,
) -> i32 {
    with(h, |handle| {
        // SAFETY: the standard has a master hand over `size` bytes, for the length of this call.
        let bytes = unsafe { list(bytes, size)? };
        let kept = handle.instance.deserialised(bytes)?;
        // SAFETY: the standard has a master hand over null, or a state that it got from here.
        unsafe { hand_over(kept, state) }
    })
}

/// Kinds of FMU that these are not.
macro_rules! no_instance {
    ($($name:ident)*) => {
        $(
            #[unsafe(no_mangle)]
            extern "C" fn $name() -> *mut c_void {
                ptr::null_mut()
            }
        )*
    };
}

no_instance! { fmi3InstantiateModelExchange fmi3InstantiateScheduledExecution }

/// What a standard lists and this library refuses, whatever the arguments behind the instance.
macro_rules! refused {
    ($($name:ident)*) => {
        $(
            #[unsafe(no_mangle)]
            extern "C" fn $name(h: *mut Handle) -> i32 {
                with(h, |_| Err(concat!(stringify!($name), " is not offered").to_owned()))
            }
        )*
    };
}
pub(super) use refused;

refused! {
    fmi3ActivateModelPartition fmi3CompletedIntegratorStep fmi3EnterConfigurationMode fmi3EnterContinuousTimeMode fmi3EnterEventMode
    fmi3EnterStepMode fmi3EvaluateDiscreteStates fmi3ExitConfigurationMode fmi3GetAdjointDerivative fmi3GetBinary fmi3GetClock
    fmi3GetContinuousStateDerivatives fmi3GetContinuousStates fmi3GetEventIndicators fmi3GetFloat32 fmi3GetInt16
    fmi3GetInt64 fmi3GetInt8 fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetNominalsOfContinuousStates
    fmi3GetNumberOfContinuousStates fmi3GetNumberOfEventIndicators fmi3GetNumberOfVariableDependencies fmi3GetOutputDerivatives
    fmi3GetShiftDecimal fmi3GetShiftFraction fmi3GetUInt16 fmi3GetUInt32 fmi3GetUInt64 fmi3GetUInt8 fmi3GetVariableDependencies
    fmi3SetBinary fmi3SetClock fmi3SetContinuousStates fmi3SetFloat32 fmi3SetInt16 fmi3SetInt32 fmi3SetInt64 fmi3SetInt8
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction fmi3SetTime fmi3SetUInt16 fmi3SetUInt32
    fmi3SetUInt64 fmi3SetUInt8 fmi3UpdateDiscreteStates
}

//! The functions of FMI 2.0 for co-simulation, over the same instance, after the standard's `fmi2FunctionTypes.h`.

#![allow(unsafe_code, reason = "functions with names and pointers of another language")]

use super::functions::{
    Handle, KeptState, Log, Log2, Voice, fmi3DeserializeFMUState, fmi3ExitInitializationMode, fmi3FreeFMUState,
    fmi3FreeInstance, fmi3GetDirectionalDerivative, fmi3GetFMUState, fmi3GetFloat64, fmi3GetString, fmi3Reset,
    fmi3SerializeFMUState, fmi3SerializedFMUStateSize, fmi3SetFMUState, fmi3SetFloat64, fmi3SetString, fmi3Terminate,
    instantiate, list, pairs, refused, room, with, words,
};
use super::instance::Instance;
use std::ffi::{CStr, c_char, c_void};
use std::mem::MaybeUninit;
use std::path::PathBuf;
use std::ptr;

/// The functions that a master hands over, of which one is called.
#[repr(C)]
struct Callbacks {
    log: Log2,
    allocate: *const c_void,
    free: *const c_void,
    finished: *const c_void,
    environment: *mut c_void,
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// The path that a URI of a file names, in which `%` and two hexadecimal digits are a byte.
fn path_of(uri: &str) -> Result<PathBuf, String> {
    let none = || format!("the resource location {uri} is not valid; valid: a URI of a folder, as file:///…");
    let path = uri.strip_prefix("file:").ok_or_else(none)?;
    let path = path.strip_prefix("//localhost").or_else(|| path.strip_prefix("//")).unwrap_or(path);
    let mut bytes = Vec::with_capacity(path.len());
    let mut parts = path.split('%');
    bytes.extend(parts.next().unwrap_or_default().bytes());
    for part in parts {
        let (code, rest) = part.split_at_checked(2).ok_or_else(none)?;
        bytes.push(u8::from_str_radix(code, 16).map_err(|_| none())?);
        bytes.extend(rest.bytes());
    }
    let path = String::from_utf8(bytes).map_err(|_| none())?;
    // What is `/C:/…` there is `C:/…` here.
    let path = if cfg!(windows) { path.strip_prefix('/').unwrap_or(&path) } else { &path };
    Ok(path.into())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: i32,
    token: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: i32,
    _logging: i32,
) -> *mut Handle {
    // SAFETY: the standard has a master hand over its functions, or null.
    let (log, environment) = unsafe { callbacks.as_ref() }.map_or((None, ptr::null_mut()), |c| (c.log, c.environment));
    // SAFETY: a text that ends in zero and outlives this call, as the standard has it.
    let name = if name.is_null() { c"" } else { unsafe { CStr::from_ptr(name) } };
    instantiate(Voice { environment, log: Log::Two(log, name.to_owned()) }, || {
        // SAFETY: both are texts that end in zero and outlive this call, as the standard has it, or null.
        let (token, resources) = unsafe { (words(token, "the guid")?, words(resources, "the resource location")?) };
        // 1: fmi2CoSimulation.
        if kind != 1 {
            return Err("this FMU is for co-simulation".to_owned());
        }
        Instance::new(token, &path_of(resources)?)
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2FreeInstance(handle: *mut Handle) {
    // SAFETY: both standards have a master vouch for the same.
    unsafe { fmi3FreeInstance(handle) }
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetupExperiment(h: *mut Handle, _: i32, _: f64, start: f64, _: i32, _: f64) -> i32 {
    with(h, |handle| handle.instance.begin_at(start))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2EnterInitializationMode(h: *mut Handle) -> i32 {
    with(h, |handle| handle.instance.enter_initialization_there())
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetDebugLogging(h: *mut Handle, _on: i32, _count: usize, _categories: *const *const c_char) -> i32 {
    with(h, |_| Ok(()))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2DoStep(h: *mut Handle, t: f64, length: f64, _no_way_back: i32) -> i32 {
    with(h, |handle| handle.instance.do_step(t, length))
}

/// What FMI 3.0 has as well, there with the numbers of values besides.
macro_rules! same {
    ($($name:ident = $three:ident($($argument:ident: $kind:ty),*)($($passed:ident)*);)*) => {$(
        #[unsafe(no_mangle)]
        #[allow(unused_unsafe, reason = "some take no pointer but the instance")]
        unsafe extern "C" fn $name(h: *mut Handle $(, $argument: $kind)*) -> i32 {
            // SAFETY: both standards have a master vouch for the same.
            unsafe { $three(h $(, $passed)*) }
        }
    )*};
}

same! {
    fmi2ExitInitializationMode = fmi3ExitInitializationMode()();
    fmi2Terminate = fmi3Terminate()();
    fmi2Reset = fmi3Reset()();
    fmi2GetReal = fmi3GetFloat64(refs: *const u32, n: usize, values: *mut f64)(refs n values n);
    fmi2SetReal = fmi3SetFloat64(refs: *const u32, n: usize, values: *const f64)(refs n values n);
    fmi2GetString = fmi3GetString(refs: *const u32, n: usize, values: *mut *const c_char)(refs n values n);
    fmi2SetString = fmi3SetString(refs: *const u32, n: usize, values: *const *const c_char)(refs n values n);
    fmi2GetDirectionalDerivative = fmi3GetDirectionalDerivative(
        unknowns: *const u32, n: usize, knowns: *const u32, m: usize, seed: *const f64, out: *mut f64
    )(unknowns n knowns m seed m out n);
    fmi2GetFMUstate = fmi3GetFMUState(state: *mut *mut KeptState)(state);
    fmi2SetFMUstate = fmi3SetFMUState(state: *mut KeptState)(state);
    fmi2FreeFMUstate = fmi3FreeFMUState(state: *mut *mut KeptState)(state);
    fmi2SerializedFMUstateSize = fmi3SerializedFMUStateSize(state: *mut KeptState, size: *mut usize)(state size);
    fmi2SerializeFMUstate = fmi3SerializeFMUState(state: *mut KeptState, bytes: *mut u8, n: usize)(state bytes n);
    fmi2DeSerializeFMUstate =
        fmi3DeserializeFMUState(bytes: *const u8, n: usize, state: *mut *mut KeptState)(bytes n state);
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetBoolean(h: *mut Handle, refs: *const u32, n: usize, values: *mut i32) -> i32 {
    with(h, |handle| {
        // SAFETY: the standard has a master hand over `n` references and room for as many values.
        let (refs, values) = unsafe { (list(refs, n)?, room(values, n)?) };
        for (at, value) in refs.iter().zip(values) {
            let mut truth = [MaybeUninit::new(false)];
            handle.instance.get_booleans(&[*at], &mut truth)?;
            // SAFETY: a truth stood there from the beginning.
            value.write(unsafe { truth[0].assume_init() }.into());
        }
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetBoolean(h: *mut Handle, refs: *const u32, n: usize, values: *const i32) -> i32 {
    with(h, |handle| {
        // SAFETY: the standard has a master hand over `n` references and `n` values.
        let (refs, values) = unsafe { (list(refs, n)?, list(values, n)?) };
        pairs(refs, values)?.try_for_each(|(at, value)| handle.instance.set_boolean(*at, *value != 0))
    })
}

refused! {
    fmi2CancelStep fmi2GetBooleanStatus fmi2GetInteger fmi2GetIntegerStatus fmi2GetRealOutputDerivatives fmi2GetRealStatus fmi2GetStatus
    fmi2GetStringStatus fmi2SetInteger fmi2SetRealInputDerivatives
}

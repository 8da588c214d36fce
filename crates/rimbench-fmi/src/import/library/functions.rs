//! The functions of an FMU's library that a master calls, as both versions of the standard declare them.

use super::{Instance, Keep};
use std::ffi::c_int;

/// Functions whose types are the same in both versions, by what they are called.
pub(super) struct Functions {
    pub(super) free: unsafe extern "C" fn(Instance),
    pub(super) terminate: unsafe extern "C" fn(Instance) -> c_int,
    pub(super) exit_initialization: unsafe extern "C" fn(Instance) -> c_int,
    pub(super) numbers: Numbers,
    pub(super) step: Step,
    pub(super) state: Option<StateFunctions>,
    pub(super) derivative: Option<Derivative>,
    /// Truths as bytes: what a library writes need be none of the two that a `bool` may have.
    pub(super) booleans: Option<unsafe extern "C" fn(Instance, *const u32, usize, *mut u8, usize) -> c_int>,
    pub(super) integers: Option<unsafe extern "C" fn(Instance, *const u32, usize, *mut i32, usize) -> c_int>,
}

pub(super) struct StateFunctions {
    pub(super) get: unsafe extern "C" fn(Instance, *mut Keep) -> c_int,
    pub(super) set: unsafe extern "C" fn(Instance, Keep) -> c_int,
    pub(super) free: unsafe extern "C" fn(Instance, *mut Keep) -> c_int,
}

#[derive(Clone, Copy)]
pub(super) enum Numbers {
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
pub(super) enum Step {
    Two(unsafe extern "C" fn(Instance, f64, f64, c_int) -> c_int),
    Three(unsafe extern "C" fn(Instance, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int),
}

#[derive(Clone, Copy)]
pub(super) enum Derivative {
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

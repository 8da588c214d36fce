//! What a master calls in the library of an FMU, whatever the version of the standard.

use super::super::host::{Plan, Start, Type};
use libloading::Library;
use rimbench_results::input::path_hint;
use std::ffi::{CString, c_int, c_void};
use std::fmt::Display;

pub(super) type Instance = *mut c_void;
pub(super) type Keep = *mut c_void;

/// One version of the standard; each call is of an instance that is alive, and returns its status.
pub(super) trait Version {
    /// Begins to initialise an instance that has its start values, for a run from `begin` to `end`, if that is known;
    /// with the status of which function.
    fn enter(
        &self,
        opened: &Opened,
        instance: Instance,
        begin: f64,
        end: Option<f64>,
    ) -> Result<(c_int, &'static str), String>;

    /// Sets a start value.
    fn set_start(&self, opened: &Opened, instance: Instance, start: &Start) -> Result<c_int, String>;

    /// Sets as many numbers as there are references.
    fn set(&self, instance: Instance, references: &[u32], values: &[f64]) -> c_int;

    /// Gets numbers: as many as there are references, or all of one array.
    fn get(&self, instance: Instance, references: &[u32], values: &mut [f64]) -> c_int;

    /// Reads one variable of any type that has numbers or truths, all of its values.
    fn read(
        &self,
        opened: &Opened,
        instance: Instance,
        kind: Type,
        reference: u32,
        values: &mut [f64],
    ) -> Result<c_int, String>;

    /// Sets all values of a variable of type Float32, which FMI 3.0 alone has.
    fn set_short(&self, opened: &Opened, _: Instance, _: u32, _: &[f64]) -> Result<c_int, String> {
        Err(opened.wrong("it has no numbers of type Float32"))
    }

    /// Takes a step from a time on, of a length; whether no state from before will be set any more.
    ///
    /// # Errors
    /// Why a step that went well is none.
    fn step(&self, instance: Instance, from: [f64; 2], no_way_back: bool) -> Result<c_int, String>;

    /// What each unknown changes by with an input, if there are directional derivatives.
    fn derivative(&self, instance: Instance, unknowns: &[u32], input: u32, column: &mut [f64]) -> Option<c_int>;
}

/// An instance with what its library does with it.
pub(super) struct Made {
    pub(super) instance: Instance,
    pub(super) common: Common,
    pub(super) version: Box<dyn Version>,
}

/// Functions whose types are the same in both versions.
pub(super) struct Common {
    pub(super) free: unsafe extern "C" fn(Instance),
    pub(super) terminate: unsafe extern "C" fn(Instance) -> c_int,
    pub(super) exit_initialization: unsafe extern "C" fn(Instance) -> c_int,
    pub(super) state: Option<StateFunctions>,
}

pub(super) struct StateFunctions {
    pub(super) get: unsafe extern "C" fn(Instance, *mut Keep) -> c_int,
    pub(super) set: unsafe extern "C" fn(Instance, Keep) -> c_int,
    pub(super) free: unsafe extern "C" fn(Instance, *mut Keep) -> c_int,
}

impl Common {
    /// Finds them by how their names begin, and by what a state is called in them.
    pub(super) fn find(opened: &Opened, plan: &Plan, [begin, state]: [&str; 2]) -> Result<Self, String> {
        let of_state = || {
            Ok::<_, String>(StateFunctions {
                get: opened.find(&format!("{begin}Get{state}"))?,
                set: opened.find(&format!("{begin}Set{state}"))?,
                free: opened.find(&format!("{begin}Free{state}"))?,
            })
        };
        Ok(Common {
            free: opened.find(&format!("{begin}FreeInstance"))?,
            terminate: opened.find(&format!("{begin}Terminate"))?,
            exit_initialization: opened.find(&format!("{begin}ExitInitializationMode"))?,
            state: plan.keeps_state.then(of_state).transpose()?,
        })
    }
}

/// A library, with the FMU that it is of.
pub(super) struct Opened {
    pub(super) library: Library,
    pub(super) file: String,
}

impl Opened {
    /// Loads what a library takes for granted, and the library.
    pub(super) fn new(plan: &Plan) -> Result<Self, String> {
        let file = plan.file.display().to_string();
        for needed in &plan.needs {
            load_for_all(needed).map_err(|error| {
                let (name, hint) = (needed.display(), path_hint(needed));
                format!("{file}: needs = {name}, which cannot be loaded: {}{hint}", why(&error))
            })?;
        }
        // SAFETY: what a library does when it is loaded is its own business; whoever names an FMU trusts it.
        match unsafe { Library::new(&plan.library) } {
            Ok(library) => Ok(Opened { library, file }),
            Err(error) => Err(format!("{file}: its library cannot be loaded: {}", why(&error))),
        }
    }

    /// A function by its name.
    pub(super) fn find<F: Copy>(&self, name: &str) -> Result<F, String> {
        // SAFETY: callers give the type that the standard has for the name.
        let found = unsafe { self.library.get::<F>(name) };
        found
            .map(|function| *function)
            .map_err(|error| self.wrong(format_args!("its library has no {name}: {}", why(&error))))
    }

    /// A text that ends in zero.
    pub(super) fn text(&self, text: &str) -> Result<CString, String> {
        CString::new(text).map_err(|_| self.wrong("a text has a zero in it"))
    }

    pub(super) fn wrong(&self, message: impl Display) -> String {
        format!("{}: {message}", self.file)
    }
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

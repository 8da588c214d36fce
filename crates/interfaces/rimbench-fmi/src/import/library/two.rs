//! FMI 2.0, as its `fmi2FunctionTypes.h` has it.

use super::super::host::{Plan, Start, Type, Values};
use super::printf::log;
use super::version::{Common, Instance, Made, Opened, Version};
use std::ffi::{c_char, c_int, c_void};
use std::ptr;

type Get<T> = unsafe extern "C" fn(Instance, *const u32, usize, *mut T) -> c_int;
type Set<T> = unsafe extern "C" fn(Instance, *const u32, usize, *const T) -> c_int;
type Derivative = unsafe extern "C" fn(Instance, *const u32, usize, *const u32, usize, *const f64, *mut f64) -> c_int;
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> Instance;
/// What a library calls with printf's arguments behind the text.
type Log = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char);

#[repr(C)]
struct Callbacks {
    log: Log,
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    finished: *const c_void,
    environment: *mut c_void,
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

pub(super) struct Two {
    get: Get<f64>,
    set: Set<f64>,
    step: unsafe extern "C" fn(Instance, f64, f64, c_int) -> c_int,
    derivative: Option<Derivative>,
    /// The instance calls them as long as it lives.
    _callbacks: Box<Callbacks>,
}

impl Two {
    /// Makes an instance that says what it has to say to `environment`, a `Said` that outlives it.
    pub(super) fn make(opened: &Opened, plan: &Plan, name: &str, environment: *mut c_void) -> Result<Made, String> {
        let callbacks = Box::new(Callbacks { log, allocate: calloc, free, finished: ptr::null(), environment });
        let given: *const Callbacks = &raw const *callbacks;
        let common = Common::find(opened, plan, ["fmi2", "FMUstate"])?;
        let derivative = plan.derivatives.then(|| opened.find("fmi2GetDirectionalDerivative"));
        let version = Two {
            get: opened.find("fmi2GetReal")?,
            set: opened.find("fmi2SetReal")?,
            step: opened.find("fmi2DoStep")?,
            derivative: derivative.transpose()?,
            _callbacks: callbacks,
        };
        let (name, token, resources) =
            (opened.text(name)?, opened.text(&plan.token)?, opened.text(&uri(&plan.resources))?);
        let instantiate: Instantiate = opened.find("fmi2Instantiate")?;
        // SAFETY: types of the standard; the callbacks live as long as the instance. 1: fmi2CoSimulation.
        let instance =
            unsafe { instantiate(name.as_ptr(), 1, token.as_ptr(), resources.as_ptr(), given, 0, plan.log.into()) };
        Ok(Made { instance, common, version: Box::new(version) })
    }
}

impl Version for Two {
    fn enter(
        &self,
        opened: &Opened,
        instance: Instance,
        begin: f64,
        end: Option<f64>,
    ) -> Result<(c_int, &'static str), String> {
        type Setup = unsafe extern "C" fn(Instance, c_int, f64, f64, c_int, f64) -> c_int;
        type Enter = unsafe extern "C" fn(Instance) -> c_int;
        let (setup, enter): (Setup, Enter) =
            (opened.find("fmi2SetupExperiment")?, opened.find("fmi2EnterInitializationMode")?);
        // SAFETY: the types are those of the standard for these names, and the instance is alive and has just been
        // made.
        let status = unsafe { setup(instance, 0, 0.0, begin, end.is_some().into(), end.unwrap_or(0.0)) };
        if !(0..=1).contains(&status) {
            return Ok((status, "fmi2SetupExperiment"));
        }
        // SAFETY: as above, and the experiment has been set up.
        Ok((unsafe { enter(instance) }, "EnterInitializationMode"))
    }

    fn set_start(&self, opened: &Opened, instance: Instance, start: &Start) -> Result<c_int, String> {
        let at = &start.reference;
        Ok(match &start.values {
            Values::Numbers(list) => self.set(instance, &[*at], &list[..1]),
            Values::Whole(list) => {
                let set: Set<c_int> = opened.find("fmi2SetInteger")?;
                // SAFETY: the type is that of the standard for this name, the instance is alive; one reference, one
                // value.
                unsafe { set(instance, at, 1, &(list[0] as c_int)) }
            }
            Values::Truths(list) => {
                let set: Set<c_int> = opened.find("fmi2SetBoolean")?;
                // SAFETY: as above; truths are whole numbers.
                unsafe { set(instance, at, 1, &c_int::from(list[0])) }
            }
            Values::Texts(list) => {
                let (set, text): (Set<*const c_char>, _) = (opened.find("fmi2SetString")?, opened.text(&list[0])?);
                // SAFETY: as above; the text ends in zero and outlives the call.
                unsafe { set(instance, at, 1, &text.as_ptr()) }
            }
        })
    }

    fn read(
        &self,
        opened: &Opened,
        instance: Instance,
        kind: Type,
        reference: u32,
        values: &mut [f64],
    ) -> Result<c_int, String> {
        let get: Get<c_int> = opened.find(if kind == Type::Boolean { "fmi2GetBoolean" } else { "fmi2GetInteger" })?;
        let mut value = 0;
        // SAFETY: the type is that of the standard for both names, the instance is alive; one reference, room for one
        // value.
        let status = unsafe { get(instance, &reference, 1, &raw mut value) };
        values.fill(if kind == Type::Boolean { f64::from(u8::from(value != 0)) } else { f64::from(value) });
        Ok(status)
    }

    fn set(&self, instance: Instance, references: &[u32], values: &[f64]) -> c_int {
        // SAFETY: the instance is alive, and there is one value for each reference.
        unsafe { (self.set)(instance, references.as_ptr(), references.len(), values.as_ptr()) }
    }

    fn get(&self, instance: Instance, references: &[u32], values: &mut [f64]) -> c_int {
        // SAFETY: the instance is alive; there are no arrays, and callers make room for a number for each reference.
        unsafe { (self.get)(instance, references.as_ptr(), references.len(), values.as_mut_ptr()) }
    }

    fn step(&self, instance: Instance, [t, h]: [f64; 2], no_way_back: bool) -> Result<c_int, String> {
        // SAFETY: the instance is alive and has been initialised.
        Ok(unsafe { (self.step)(instance, t, h, no_way_back.into()) })
    }

    fn derivative(&self, instance: Instance, unknowns: &[u32], input: u32, column: &mut [f64]) -> Option<c_int> {
        let (call, rows) = (self.derivative?, unknowns.len());
        // SAFETY: the instance is alive; `rows` unknowns with room for as many numbers, one input with one seed.
        Some(unsafe { call(instance, unknowns.as_ptr(), rows, &input, 1, &1.0, column.as_mut_ptr()) })
    }
}

/// A folder as a URI, in which all but a few characters are written as `%` and their code.
fn uri(folder: &std::path::Path) -> String {
    let path = folder.display().to_string();
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-._~:".contains(&byte);
    let written = |byte: u8| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    format!("file://{}", path.bytes().map(written).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::uri;

    #[test]
    fn a_folder_of_any_name_is_a_uri() {
        let folder = std::path::Path::new("/models/my models/50 % é/fmu-x1");
        assert_eq!(uri(folder), "file:///models/my%20models/50%20%25%20%C3%A9/fmu-x1");
    }
}

//! FMI 3.0, as its `fmi3FunctionTypes.h` has it.

use super::super::host::{Plan, Start};
use super::note;
use super::version::{Common, Instance, Made, Opened, Version};
use std::ffi::{c_char, c_int, c_void};
use std::ptr;

type Get<T> = unsafe extern "C" fn(Instance, *const u32, usize, *mut T, usize) -> c_int;
type Set<T> = unsafe extern "C" fn(Instance, *const u32, usize, *const T, usize) -> c_int;
type Step = unsafe extern "C" fn(Instance, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;
type Derivative =
    unsafe extern "C" fn(Instance, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int;
type Log = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);
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
    Option<Log>,
    *const c_void,
) -> Instance;

unsafe extern "C" fn log(environment: *mut c_void, _status: c_int, _category: *const c_char, message: *const c_char) {
    // SAFETY: the library hands on the environment that it was given, which is a `Said`, and a text, as the standard has it.
    unsafe { note(environment, message) };
}

pub(super) struct Three {
    get: Get<f64>,
    set: Set<f64>,
    step: Step,
    derivative: Option<Derivative>,
    truths: Option<Get<u8>>,
    integers: Option<Get<i32>>,
}

impl Three {
    /// Makes an instance that says what it has to say to `environment`, a `Said` that outlives it.
    pub(super) fn make(opened: &Opened, plan: &Plan, environment: *mut c_void) -> Result<Made, String> {
        let common = Common::find(opened, plan, ["fmi3", "FMUState"])?;
        let model = plan.model.as_ref();
        let integers = model.is_some_and(|model| !model.states.is_empty() || model.kinks.is_some());
        let version = Three {
            get: opened.find("fmi3GetFloat64")?,
            set: opened.find("fmi3SetFloat64")?,
            step: opened.find("fmi3DoStep")?,
            derivative: plan.derivatives.then(|| opened.find("fmi3GetDirectionalDerivative")).transpose()?,
            truths: model.map(|_| opened.find("fmi3GetBoolean")).transpose()?,
            integers: integers.then(|| opened.find("fmi3GetInt32")).transpose()?,
        };
        let resources = opened.text(&format!("{}/", plan.resources.display()))?;
        let (name, token) = (opened.text("rimbench")?, opened.text(&plan.token)?);
        let instantiate: Instantiate = opened.find("fmi3InstantiateCoSimulation")?;
        let [name, token, resources] = [&name, &token, &resources].map(|text| text.as_ptr());
        let (no_variables, nothing) = (ptr::null(), ptr::null());
        // SAFETY: types of the standard; the texts live until it returns, and what `environment` points to as long as the instance.
        let instance = unsafe {
            instantiate(
                name,
                token,
                resources,
                false,
                false,
                false,
                false,
                no_variables,
                0,
                environment,
                Some(log),
                nothing,
            )
        };
        Ok(Made { instance, common, version: Box::new(version) })
    }
}

impl Version for Three {
    fn enter(&self, opened: &Opened, instance: Instance) -> Result<(c_int, &'static str), String> {
        type Enter = unsafe extern "C" fn(Instance, bool, f64, f64, bool, f64) -> c_int;
        let enter: Enter = opened.find("fmi3EnterInitializationMode")?;
        // SAFETY: the type is that of the standard for this name, and the instance is alive and has just been made.
        Ok((unsafe { enter(instance, false, 0.0, 0.0, false, 0.0) }, "EnterInitializationMode"))
    }

    fn set_start(&self, opened: &Opened, instance: Instance, start: &Start) -> Result<c_int, String> {
        Ok(match start {
            Start::Number(at, value) => self.set(instance, &[*at], &[*value]),
            Start::Integer(at, value) => {
                let set: Set<i32> = opened.find("fmi3SetInt32")?;
                // SAFETY: the type is that of the standard for this name, the instance is alive; one reference, one value.
                unsafe { set(instance, at, 1, value, 1) }
            }
            Start::Boolean(at, value) => {
                let set: Set<bool> = opened.find("fmi3SetBoolean")?;
                // SAFETY: as above.
                unsafe { set(instance, at, 1, value, 1) }
            }
            Start::Text(at, value) => {
                let (set, text): (Set<*const c_char>, _) = (opened.find("fmi3SetString")?, opened.text(value)?);
                // SAFETY: as above; the text ends in zero and outlives the call.
                unsafe { set(instance, at, 1, &text.as_ptr(), 1) }
            }
        })
    }

    fn set(&self, instance: Instance, references: &[u32], values: &[f64]) -> c_int {
        // SAFETY: the instance is alive, and each pointer goes with its count.
        unsafe { (self.set)(instance, references.as_ptr(), references.len(), values.as_ptr(), values.len()) }
    }

    fn get(&self, instance: Instance, references: &[u32], values: &mut [f64]) -> c_int {
        // SAFETY: the instance is alive, and each pointer goes with its count.
        unsafe { (self.get)(instance, references.as_ptr(), references.len(), values.as_mut_ptr(), values.len()) }
    }

    fn step(&self, instance: Instance, t: f64, h: f64) -> Result<c_int, String> {
        let (mut event, mut terminate, mut early, mut last) = (0, 0, 0, t);
        // SAFETY: the instance is alive and has been initialised; there is room for all four that it tells, bytes being bytes
        // whatever it takes for a truth.
        let status = unsafe {
            (self.step)(instance, t, h, false, &raw mut event, &raw mut terminate, &raw mut early, &raw mut last)
        };
        match (0..=1).contains(&status) {
            true if terminate != 0 => Err(format!("it wants the simulation to end at {last} s")),
            true if early != 0 => Err(format!("it returned before the end of its step at {last} s")),
            _ => Ok(status),
        }
    }

    fn derivative(&self, instance: Instance, unknowns: &[u32], input: u32, column: &mut [f64]) -> Option<c_int> {
        let (call, rows) = (self.derivative?, unknowns.len());
        // SAFETY: the instance is alive; `rows` unknowns, one input with one seed, and each pointer goes with its count.
        Some(unsafe { call(instance, unknowns.as_ptr(), rows, &input, 1, &1.0, 1, column.as_mut_ptr(), column.len()) })
    }

    fn truths(&self, instance: Instance, reference: u32, values: &mut [u8]) -> Option<c_int> {
        // SAFETY: the instance is alive; one reference, and room for so many bytes, which any bits may fill.
        self.truths.map(|get| unsafe { get(instance, &reference, 1, values.as_mut_ptr(), values.len()) })
    }

    fn integers(&self, instance: Instance, reference: u32, values: &mut [i32]) -> Option<c_int> {
        // SAFETY: the instance is alive; one reference, and room for so many numbers.
        self.integers.map(|get| unsafe { get(instance, &reference, 1, values.as_mut_ptr(), values.len()) })
    }
}

//! FMI 3.0, as its `fmi3FunctionTypes.h` has it.

use super::super::host::{Plan, Start, Type, Values};
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

unsafe extern "C" fn log(environment: *mut c_void, status: c_int, _category: *const c_char, message: *const c_char) {
    // SAFETY: the library hands on the environment that it was given, which is a `Said`, and a text, as the standard
    // has it.
    unsafe { note(environment, status, message) };
}

/// Share of a step by which the time that an FMU has come to may differ from the end of the step.
const SAME_TIME: f64 = 1e-6;

pub(super) struct Three {
    get: Get<f64>,
    set: Set<f64>,
    step: Step,
    derivative: Option<Derivative>,
}

impl Three {
    /// Makes an instance that says what it has to say to `environment`, a `Said` that outlives it.
    pub(super) fn make(opened: &Opened, plan: &Plan, name: &str, environment: *mut c_void) -> Result<Made, String> {
        let common = Common::find(opened, plan, ["fmi3", "FMUState"])?;
        let version = Three {
            get: opened.find("fmi3GetFloat64")?,
            set: opened.find("fmi3SetFloat64")?,
            step: opened.find("fmi3DoStep")?,
            derivative: plan.derivatives.then(|| opened.find("fmi3GetDirectionalDerivative")).transpose()?,
        };
        let resources = opened.text(&format!("{}/", plan.resources.display()))?;
        let (name, token) = (opened.text(name)?, opened.text(&plan.token)?);
        let instantiate: Instantiate = opened.find("fmi3InstantiateCoSimulation")?;
        let [name, token, resources] = [&name, &token, &resources].map(|text| text.as_ptr());
        let (no_variables, nothing) = (ptr::null(), ptr::null());
        // SAFETY: types of the standard; the texts live until it returns, and what `environment` points to as long as
        // the instance.
        let instance = unsafe {
            instantiate(
                name,
                token,
                resources,
                false,
                plan.log,
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
    fn enter(
        &self,
        opened: &Opened,
        instance: Instance,
        begin: f64,
        end: Option<f64>,
    ) -> Result<(c_int, &'static str), String> {
        type Enter = unsafe extern "C" fn(Instance, bool, f64, f64, bool, f64) -> c_int;
        let enter: Enter = opened.find("fmi3EnterInitializationMode")?;
        // SAFETY: the type is that of the standard for this name, and the instance is alive and has just been made.
        Ok((
            unsafe { enter(instance, false, 0.0, begin, end.is_some(), end.unwrap_or(0.0)) },
            "EnterInitializationMode",
        ))
    }

    fn set_start(&self, opened: &Opened, instance: Instance, start: &Start) -> Result<c_int, String> {
        let Start { reference, kind, values, .. } = start;
        /// Sets values that are converted to one type.
        macro_rules! set {
            ($type:ty, $name:literal, $values:expr, $convert:expr) => {{
                let set: Set<$type> = opened.find(concat!("fmi3Set", $name))?;
                let values: Vec<$type> = $values.iter().map($convert).collect();
                // SAFETY: the type is that of the standard for this name, the instance is alive; one reference with all
                // of its values.
                unsafe { set(instance, reference, 1, values.as_ptr(), values.len()) }
            }};
        }
        macro_rules! whole {
            ($type:ty, $name:literal, $values:expr) => {
                set!($type, $name, $values, |value| *value as $type)
            };
        }
        Ok(match (kind, values) {
            (Type::Float32, Values::Numbers(list)) => set!(f32, "Float32", list, |value| *value as f32),
            (_, Values::Numbers(list)) => self.set(instance, &[*reference], list),
            (Type::Int8, Values::Whole(list)) => whole!(i8, "Int8", list),
            (Type::UInt8, Values::Whole(list)) => whole!(u8, "UInt8", list),
            (Type::Int16, Values::Whole(list)) => whole!(i16, "Int16", list),
            (Type::UInt16, Values::Whole(list)) => whole!(u16, "UInt16", list),
            (Type::Int32, Values::Whole(list)) => whole!(i32, "Int32", list),
            (Type::UInt32, Values::Whole(list)) => whole!(u32, "UInt32", list),
            (Type::UInt64, Values::Whole(list)) => whole!(u64, "UInt64", list),
            (_, Values::Whole(list)) => whole!(i64, "Int64", list),
            (_, Values::Truths(list)) => set!(bool, "Boolean", list, |value| *value),
            (_, Values::Texts(list)) => {
                let texts = list.iter().map(|text| opened.text(text)).collect::<Result<Vec<_>, _>>()?;
                // The texts end in zero and outlive the call.
                set!(*const c_char, "String", texts, |text| text.as_ptr())
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
        macro_rules! read {
            ($type:ty, $name:literal) => {
                read!($type, $name, |value| value as f64)
            };
            ($type:ty, $name:literal, $convert:expr) => {{
                let get: Get<$type> = opened.find(concat!("fmi3Get", $name))?;
                let mut room: Vec<$type> = vec![Default::default(); values.len()];
                // SAFETY: the type is that of the standard for this name, the instance is alive; one reference, and
                // room for its values.
                let status = unsafe { get(instance, &reference, 1, room.as_mut_ptr(), room.len()) };
                let convert: fn($type) -> f64 = $convert;
                values.iter_mut().zip(room).for_each(|(value, read)| *value = convert(read));
                status
            }};
        }
        Ok(match kind {
            Type::Float32 => read!(f32, "Float32", f64::from),
            Type::Int8 => read!(i8, "Int8", f64::from),
            Type::UInt8 => read!(u8, "UInt8", f64::from),
            Type::Int16 => read!(i16, "Int16", f64::from),
            Type::UInt16 => read!(u16, "UInt16", f64::from),
            Type::Int32 => read!(i32, "Int32", f64::from),
            Type::UInt32 => read!(u32, "UInt32", f64::from),
            Type::Int64 => read!(i64, "Int64"),
            Type::UInt64 => read!(u64, "UInt64"),
            // What a library writes need be none of the two that a `bool` may have.
            Type::Boolean => read!(u8, "Boolean", |truth| f64::from(u8::from(truth != 0))),
            Type::Float64 | Type::Text | Type::Other => return Err(opened.wrong("asked for a number that is none")),
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

    fn set_short(&self, opened: &Opened, instance: Instance, reference: u32, values: &[f64]) -> Result<c_int, String> {
        let set: Set<f32> = opened.find("fmi3SetFloat32")?;
        let values: Vec<f32> = values.iter().map(|value| *value as f32).collect();
        // SAFETY: the type is that of the standard for this name, the instance is alive; one reference with all of its
        // values.
        Ok(unsafe { set(instance, &reference, 1, values.as_ptr(), values.len()) })
    }

    fn step(&self, instance: Instance, [t, h]: [f64; 2], no_way_back: bool) -> Result<c_int, String> {
        let (mut event, mut terminate, mut early, mut last) = (0, 0, 0, f64::NAN);
        // SAFETY: the instance is alive and has been initialised; there is room for all four that it tells, bytes being
        // bytes whatever it takes for a truth.
        let status = unsafe {
            (self.step)(instance, t, h, no_way_back, &raw mut event, &raw mut terminate, &raw mut early, &raw mut last)
        };
        match (0..=1).contains(&status) {
            true if terminate != 0 => Err(format!("it wants the simulation to end at {last} s")),
            true if early != 0 => Err(format!("it returned before the end of its step at {last} s")),
            // One that says nothing leaves what was there.
            true if (last - (t + h)).abs() > SAME_TIME * h => Err(format!(
                "DoStep returned OK, but has come to {last} and not to {}, in the unit of its time (lastSuccessfulTime): valid: steps that \
                 it takes, perhaps multiples of its own",
                t + h
            )),
            _ => Ok(status),
        }
    }

    fn derivative(&self, instance: Instance, unknowns: &[u32], input: u32, column: &mut [f64]) -> Option<c_int> {
        let (call, rows) = (self.derivative?, unknowns.len());
        // SAFETY: the instance is alive; `rows` unknowns, one input with one seed, and each pointer goes with its
        // count.
        Some(unsafe { call(instance, unknowns.as_ptr(), rows, &input, 1, &1.0, 1, column.as_mut_ptr(), column.len()) })
    }
}

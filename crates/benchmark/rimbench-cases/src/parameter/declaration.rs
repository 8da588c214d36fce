//! Parameters of a case declared once, as the fields of a struct.

use super::{Parameter, Parameters, Range, Setting};

/// A struct whose fields are parameters of a case, or sets of them; made by [`parameters!`](crate::parameters).
pub trait ParameterSet: Copy + Send + Sync + 'static {
    /// Lists its parameters, in the order of the fields.
    fn declared() -> Vec<Parameter>;

    /// Reads the fields by their names; one that the case does not declare has the default of its declaration.
    fn read(parameters: &Parameters) -> Self;

    /// Sets all of them to their defaults.
    fn defaults() -> Self {
        Self::read(&Parameters::defaults("".into(), &Self::declared()))
    }
}

/// Of a case with nothing to set.
impl ParameterSet for () {
    fn declared() -> Vec<Parameter> {
        Vec::new()
    }

    fn read(_parameters: &Parameters) -> Self {}
}

/// The parameters of a set that cases share, as one case declares them.
#[derive(Debug, Clone)]
pub struct SharedSet(Vec<Parameter>);

impl SharedSet {
    /// Takes all parameters of a set as they are.
    pub fn of<Set: ParameterSet>() -> Self {
        SharedSet(Set::declared())
    }

    /// Returns the parameters.
    pub fn declared(self) -> Vec<Parameter> {
        self.0
    }

    /// Gives all of them another source.
    #[must_use]
    pub fn from(mut self, source: &'static str) -> Self {
        self.0.iter_mut().for_each(|parameter| parameter.source = source.into());
        self
    }

    /// Takes a part of them, in this order.
    ///
    /// # Panics
    /// If the set has no such parameter, as all below: a defect of the case.
    #[must_use]
    pub fn only(self, names: &[&str]) -> Self {
        SharedSet(names.iter().map(|name| self.0[self.place(name)].clone()).collect())
    }

    /// Gives one another default.
    #[must_use]
    pub fn default(self, name: &str, default: impl Setting) -> Self {
        self.with(name, |parameter| parameter.default = default.value())
    }

    /// Gives one other valid values.
    #[must_use]
    pub fn within(self, name: &str, range: Range) -> Self {
        self.with(name, |parameter| parameter.range = range)
    }

    /// Says of one otherwise what it is.
    #[must_use]
    pub fn about(self, name: &str, about: &'static str) -> Self {
        self.with(name, |parameter| parameter.about = about.into())
    }

    /// Gives one another source.
    #[must_use]
    pub fn source(self, name: &str, source: &'static str) -> Self {
        self.with(name, |parameter| parameter.source = source.into())
    }

    fn with(mut self, name: &str, change: impl FnOnce(&mut Parameter)) -> Self {
        let place = self.place(name);
        change(&mut self.0[place]);
        self
    }

    fn place(&self, name: &str) -> usize {
        let place = self.0.iter().position(|parameter| parameter.name == name);
        place.unwrap_or_else(|| panic!("`{name}` is no parameter of the set"))
    }
}

/// Pairs the name of a parameter with its value, for an error that says which one is wrong: `named!(p.belt.speed_m_s)`
/// is `("speed_m_s", p.belt.speed_m_s)`.
#[macro_export]
macro_rules! named {
    ($value:expr) => {
        (stringify!($value).rsplit('.').next().unwrap_or_default().trim(), $value)
    };
}

/// Declares an enum whose variants are the names that a parameter may have; `for Kind { … }` gives the names to an enum
/// that is there.
///
/// ```
/// rimbench_cases::choices! {
///     /// How a beam is held.
///     pub enum Support {
///         /// At one end.
///         Clamped = "clamped",
///         /// At both.
///         Pinned = "pinned",
///     }
/// }
/// ```
#[macro_export]
macro_rules! choices {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $kind:ident { $($(#[$about:meta])* $variant:ident = $name:literal,)+ }
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        $visibility enum $kind { $($(#[$about])* $variant,)+ }

        $crate::choices! { for $kind { $($variant = $name,)+ } }
    };
    (for $kind:ident { $($variant:ident = $name:literal,)+ }) => {
        impl $crate::parameter::Setting for $kind {
            type Valid = &'static [Self];

            fn value(self) -> $crate::parameter::Value {
                $crate::parameter::Value::Choice(match self { $($kind::$variant => $name,)+ }.into())
            }

            fn of(value: &$crate::parameter::Value) -> Option<Self> {
                [$($kind::$variant),+].into_iter().find(|kind| $crate::parameter::Setting::value(*kind) == *value)
            }

            fn range(valid: &'static [Self]) -> $crate::parameter::Range {
                let name = |kind: &Self| $crate::parameter::Setting::value(*kind).to_string().into();
                $crate::parameter::Range::OneOf(valid.iter().map(name).collect())
            }
        }
    };
}

/// Declares the parameters of a case as the fields of a struct. The unit of a number is the end of its name.
///
/// ```
/// use rimbench_cases::cases::Contacts;
/// use rimbench_cases::parameter::ParameterSet;
///
/// rimbench_cases::choices! {
///     /// What holds it.
///     pub enum Support { /// At one end.
///         Clamped = "clamped", /// At both.
///         Pinned = "pinned", }
/// }
/// rimbench_cases::parameters! {
///     /// A beam above a stop.
///     pub struct Beam from "ours" {
///         support: Support [Clamped, Pinned], "how it is held";          // the first is the default
///         modes: u32 = 4, 1..=20, "number of modes";                      // default, valid values
///         length_m: f64 = 2.0, Positive, "length".study(1.0..3.0);        // then what a `Parameter` can be told
///         density_kg_m3: f64 = 7800.0, Positive, "density".from("steel");
///         tilt_rad: f64 = 0.0, Finite, "slope".when(&[["support", "clamped"]]);
///         /// Two parameters of a set that cases share, with a default of this case.
///         contacts: Contacts with |set| set.only(&["stabilisation", "restitution"]).default("restitution", 0.5);
///     }
/// }
/// let names: Vec<_> = Beam::declared().into_iter().map(|parameter| parameter.name).collect();
/// assert_eq!(names, ["support", "modes", "length_m", "density_kg_m3", "tilt_rad", "stabilisation", "restitution"]);
/// ```
/// The valid values of an `f64` are a [`Range`](crate::parameter::Range) without its path. A set is taken whole
/// (`carriage: Carriage;`), or as a function makes it of the whole [`SharedSet`](crate::parameter::SharedSet).
#[macro_export]
macro_rules! parameters {
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $set:ident from $source:literal {
            $(
                $(#[$group:meta])*
                $field:ident: $kind:ident
                $(= $default:expr, $valid:expr, $about:literal $(.$more:ident($($argument:expr),*))*)?
                $([$($choice:ident),+], $meaning:literal $(.$other:ident($($given:expr),*))*)?
                $(with $shared:expr)?
                ;
            )*
        }
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        $visibility struct $set {
            $(
                $(#[$group])* $(#[doc = $about])? $(#[doc = $meaning])?
                pub $field: $kind,
            )*
        }

        #[allow(clippy::approx_constant, reason = "a default has the digits of its source")]
        impl $crate::parameter::ParameterSet for $set {
            #[allow(clippy::vec_init_then_push, reason = "one push per field")]
            fn declared() -> Vec<$crate::parameter::Parameter> {
                let mut list = Vec::new();
                $($crate::parameter_field!(declare list $source $field $kind
                    $(number [$default] [$valid] [$about] [$(.$more($($argument),*))*])?
                    $(choice [$($choice)+] [$meaning] [$(.$other($($given),*))*])?
                    $(shared [$shared])?
                );)*
                list
            }

            fn read(parameters: &$crate::parameter::Parameters) -> Self {
                $set {
                    $($field: $crate::parameter_field!(read parameters $field $kind $([$default])? $($(<$choice>)+)?),)*
                }
            }
        }
    };
}

/// One field of [`parameters!`].
#[doc(hidden)]
#[macro_export]
macro_rules! parameter_field {
    (declare $list:ident $source:literal $field:ident $kind:ident
        number [$default:expr] [$valid:expr] [$about:literal] [$($more:tt)*]) => {{
        #[allow(unused_imports)]
        use $crate::parameter::Range::*;
        let parameter = $crate::parameter::Parameter::of::<$kind>(stringify!($field), $default, $valid, $about, $source);
        $list.push(parameter $($more)*);
    }};
    (declare $list:ident $source:literal $field:ident $kind:ident
        choice [$first:ident $($choice:ident)*] [$about:literal] [$($more:tt)*]) => {
        $crate::parameter_field!(declare $list $source $field $kind
            number [$kind::$first] [&[$kind::$first, $($kind::$choice),*]] [$about] [$($more)*])
    };
    (declare $list:ident $source:literal $field:ident $kind:ident $(shared [$shared:expr])?) => {{
        #[allow(unused_imports)]
        use $crate::parameter::{Range::*, SharedSet};
        let set = SharedSet::of::<$kind>();
        $(let shared: fn(SharedSet) -> SharedSet = $shared;
        let set = shared(set);)?
        $list.extend(set.declared());
    }};
    (read $parameters:ident $field:ident $kind:ident [$default:expr]) => {
        $parameters.setting(stringify!($field)).unwrap_or($default)
    };
    (read $parameters:ident $field:ident $kind:ident <$first:ident> $(<$choice:ident>)*) => {
        $crate::parameter_field!(read $parameters $field $kind [$kind::$first])
    };
    (read $parameters:ident $field:ident $kind:ident) => {
        <$kind as $crate::parameter::ParameterSet>::read($parameters)
    };
}

pub use crate::{choices, named, parameters};

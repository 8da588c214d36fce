//! Parameters of a case declared once, as the fields of a struct.

use super::parameters::{Parameter, Parameters};
use super::values::{Range, Setting};

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

/// A parameter of a set, with what one case changes of it: nothing or one of each; of the sources the first.
#[doc(hidden)]
pub fn changed<Set: ParameterSet, Field: Setting>(
    name: &str,
    _field: fn(&Set) -> Field,
    default: &[Field],
    range: &[Range],
    [about, own_source, source]: [&[&'static str]; 3],
) -> Parameter {
    let known = Set::declared().into_iter().find(|parameter| parameter.name == name);
    let known = known.expect("a field of the set is one of its parameters");
    Parameter {
        default: default.first().map_or(known.default, |default| default.value()),
        range: range.first().cloned().unwrap_or(known.range),
        about: about.first().map_or(known.about, |about| (*about).into()),
        source: own_source.iter().chain(source).next().map_or(known.source, |source| (*source).into()),
        ..known
    }
}

/// The parameters of a set with another source, if there is one, and with some of them changed.
#[doc(hidden)]
pub fn with_changes<Set: ParameterSet>(changed: &[Parameter], source: &[&'static str]) -> Vec<Parameter> {
    let mut list = Set::declared();
    for known in &mut list {
        match changed.iter().find(|change| change.name == known.name) {
            Some(change) => *known = change.clone(),
            None => source.iter().for_each(|source| known.source = (*source).into()),
        }
    }
    list
}

/// Pairs the name of a parameter with its value, for an error that says which one is wrong: `named!(p.belt.speed_m_s)` is
/// `("speed_m_s", p.belt.speed_m_s)`.
#[macro_export]
macro_rules! named {
    ($value:expr) => {
        (stringify!($value).rsplit('.').next().unwrap_or_default().trim(), $value)
    };
}

/// Declares an enum whose variants are the names that a parameter may have; `for Kind { … }` gives the names to an enum that is there.
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
        impl $crate::cases::Setting for $kind {
            type Valid = &'static [Self];

            fn value(self) -> $crate::cases::Value {
                $crate::cases::Value::Choice(match self { $($kind::$variant => $name,)+ }.into())
            }

            fn of(value: &$crate::cases::Value) -> Option<Self> {
                [$($kind::$variant),+].into_iter().find(|kind| $crate::cases::Setting::value(*kind) == *value)
            }

            fn range(valid: &'static [Self]) -> $crate::cases::Range {
                let name = |kind: &Self| $crate::cases::Setting::value(*kind).to_string().into();
                $crate::cases::Range::OneOf(valid.iter().map(name).collect())
            }
        }
    };
}

/// Declares the parameters of a case as the fields of a struct. The unit of a number is the end of its name.
///
/// ```
/// use rimbench_cases::cases::{Contacts, ParameterSet};
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
///         length_m: f64 = 2.0, Positive, "length" study 1.0..3.0;         // and a sensible range for studies
///         density_kg_m3: f64 = 7800.0, Positive, "density" from "steel";  // a source of its own
///         tilt_rad: f64 = 0.0, Finite, "slope" when support = "clamped";  // of use with that choice, or `> number`, only
///         /// Two parameters of a set that cases share, with a default of this case.
///         contacts: Contacts only { stabilisation; restitution = 0.5 };
///     }
/// }
/// let names: Vec<_> = Beam::declared().into_iter().map(|parameter| parameter.name).collect();
/// assert_eq!(names, ["support", "modes", "length_m", "density_kg_m3", "tilt_rad", "stabilisation", "restitution"]);
/// ```
/// The valid values of an `f64` are a [`Range`](crate::cases::Range) without its path. A set is taken whole (`carriage: Carriage;`), with
/// changes (`Carriage { base_damping_n_s_m = 5.0 }`), or in part (`only { … }`), and
/// `Carriage from "source"` gives it another source. A change is `name = default in Range, "about" from "source"`, of which all but the
/// name may be left out.
#[macro_export]
macro_rules! parameters {
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $set:ident from $source:literal {
            $(
                $(#[$group:meta])*
                $field:ident: $kind:ident $(from $whole:literal)?
                $(= $default:expr, $valid:expr, $about:literal $(study $least:literal .. $most:literal)?
                    $(when $($with:ident = $needed:literal),+)? $(from $own:literal)?)?
                $([$($choice:ident),+], $meaning:literal $(from $origin:literal)?)?
                $({ $($changes:tt)* })?
                $(only { $($only:tt)* })?
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
        impl $crate::cases::ParameterSet for $set {
            #[allow(clippy::vec_init_then_push, reason = "one push per field")]
            fn declared() -> Vec<$crate::cases::Parameter> {
                let mut list = Vec::new();
                $($crate::parameter_field!(declare list $source $field $kind from [$($whole)?]
                    $(number [$default] [$valid] [$about] [$($least, $most)?] [$($($with $needed)+)?] [$($own)?])?
                    $(choice [$($choice)+] [$meaning] [$($origin)?])?
                    $(changes { $($changes)* })?
                    $(only { $($only)* })?
                );)*
                list
            }

            fn read(parameters: &$crate::cases::Parameters) -> Self {
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
    (declare $list:ident $source:literal $field:ident $kind:ident from []
        number [$default:expr] [$valid:expr] [$about:literal] [$($least:literal, $most:literal)?]
        [$($with:ident $needed:literal)*] [$($own:literal)?]) => {{
        #[allow(unused_imports)]
        use $crate::cases::Range::*;
        let sources = [$($own,)? $source];
        let parameter = $crate::cases::Parameter::of::<$kind>(stringify!($field), $default, $valid, $about, sources[0]);
        $list.push($crate::cases::Parameter {
            study: [$([$least, $most])?].first().copied(),
            only_with: &[$([stringify!($with), $needed]),*],
            ..parameter
        });
    }};
    (declare $list:ident $source:literal $field:ident $kind:ident from []
        choice [$first:ident $($choice:ident)*] [$about:literal] [$($own:literal)?]) => {{
        let (sources, valid) = ([$($own,)? $source], &[$kind::$first, $($kind::$choice),*]);
        $list.push($crate::cases::Parameter::of::<$kind>(stringify!($field), $kind::$first, valid, $about, sources[0]));
    }};
    (declare $list:ident $source:literal $field:ident $kind:ident from $whole:tt $(changes { $($changes:tt)* })?) => {{
        #[allow(unused_mut)]
        let mut changed = Vec::new();
        $($crate::parameter_field!(change changed $kind $whole $($changes)*);)?
        $list.extend($crate::cases::with_changes::<$kind>(&changed, &$whole));
    }};
    (declare $list:ident $source:literal $field:ident $kind:ident from $whole:tt only { $($only:tt)* }) => {
        $crate::parameter_field!(change $list $kind $whole $($only)*)
    };
    (change $list:ident $kind:ident $whole:tt
        $($name:ident $(= $default:literal)? $(in $range:ident)? $(, $about:literal)? $(from $own:literal)?);+ $(;)?) => {
        $($list.push($crate::cases::changed(
            stringify!($name),
            |set: &$kind| set.$name,
            &[$($default)?],
            &[$($crate::cases::Range::$range)?],
            [&[$($about)?], &[$($own)?], &$whole],
        ));)+
    };
    (read $parameters:ident $field:ident $kind:ident [$default:expr]) => {
        $parameters.setting(stringify!($field)).unwrap_or($default)
    };
    (read $parameters:ident $field:ident $kind:ident <$first:ident> $(<$choice:ident>)*) => {
        $parameters.setting(stringify!($field)).unwrap_or($kind::$first)
    };
    (read $parameters:ident $field:ident $kind:ident) => {
        <$kind as $crate::cases::ParameterSet>::read($parameters)
    };
}

pub use crate::{choices, named, parameters};

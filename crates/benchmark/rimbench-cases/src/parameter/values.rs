//! What a parameter may be, and the unit that a name ends in.

use rimbench_core::error::{Error, Result};
use rimbench_core::name::Name;
use std::fmt;
use std::ops::RangeInclusive;

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number in the parameter's unit.
    Number(f64),
    /// One of a list of names.
    Choice(Name),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(number) => write!(f, "{number:?}"),
            Value::Choice(name) => f.write_str(name),
        }
    }
}

/// What a parameter may be.
#[derive(Debug, Clone, PartialEq)]
pub enum Range {
    /// Any finite number.
    Finite,
    /// A finite number above zero.
    Positive,
    /// A finite number, zero or above.
    NotNegative,
    /// A number in [0, 1].
    Fraction,
    /// A whole number within these bounds.
    Whole(u32, u32),
    /// One of these names.
    OneOf(Vec<Name>),
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Range::Finite => f.write_str("a finite number"),
            Range::Positive => f.write_str("a finite number above 0"),
            Range::NotNegative => f.write_str("a finite number, 0 or above"),
            Range::Fraction => f.write_str("a number in [0, 1]"),
            Range::Whole(least, most) => write!(f, "a whole number from {least} to {most}"),
            Range::OneOf(names) => write!(f, "one of {}", names.join(", ")),
        }
    }
}

impl Range {
    /// Accepts a number or says no.
    fn admits(&self, number: f64) -> bool {
        number.is_finite()
            && match self {
                Range::Finite => true,
                Range::Positive => number > 0.0,
                Range::NotNegative => number >= 0.0,
                Range::Fraction => (0.0..=1.0).contains(&number),
                Range::Whole(least, most) => {
                    number.fract() == 0.0 && (f64::from(*least)..=f64::from(*most)).contains(&number)
                }
                Range::OneOf(_) => false,
            }
    }

    /// Reads a value from text.
    pub(super) fn parse(&self, key: &str, text: &str) -> Result<Value> {
        let invalid = || Error::invalid(key, text, self.to_string());
        if let Range::OneOf(names) = self {
            let found = names.iter().find(|name| *name == text);
            return found.cloned().map(Value::Choice).ok_or_else(invalid);
        }
        let number = text.trim().parse::<f64>().map_err(|_| invalid())?;
        if self.admits(number) { Ok(Value::Number(number)) } else { Err(invalid()) }
    }
}

/// What a field of a set of parameters may be: a number, a whole number, a switch, or one of some names
/// ([`choices!`](crate::choices)).
pub trait Setting: Copy + 'static {
    /// How its valid values are declared.
    type Valid;

    /// Writes it as a value.
    fn value(self) -> Value;

    /// Reads it from a value of its kind.
    fn of(value: &Value) -> Option<Self>;

    /// Says which values are valid.
    fn range(valid: Self::Valid) -> Range;
}

impl Setting for f64 {
    type Valid = Range;

    fn value(self) -> Value {
        Value::Number(self)
    }

    fn of(value: &Value) -> Option<Self> {
        match value {
            Value::Number(number) => Some(*number),
            Value::Choice(_) => None,
        }
    }

    fn range(valid: Range) -> Range {
        valid
    }
}

impl Setting for u32 {
    type Valid = RangeInclusive<u32>;

    fn value(self) -> Value {
        Value::Number(f64::from(self))
    }

    fn of(value: &Value) -> Option<Self> {
        f64::of(value).map(|number| number as u32)
    }

    fn range(valid: RangeInclusive<u32>) -> Range {
        Range::Whole(*valid.start(), *valid.end())
    }
}

impl Setting for bool {
    type Valid = [bool; 2];

    fn value(self) -> Value {
        Value::Choice(if self { "true" } else { "false" }.into())
    }

    fn of(value: &Value) -> Option<Self> {
        match value {
            Value::Choice(name) => name.parse().ok(),
            Value::Number(_) => None,
        }
    }

    fn range(valid: [bool; 2]) -> Range {
        Range::OneOf(valid.map(|value| value.to_string().into()).to_vec())
    }
}

/// Returns the unit that a name in data ends in; `-` where it says none.
pub fn unit_of(name: &str) -> &'static str {
    without_unit(name).1
}

/// Splits a name in data into what it says before its unit, and the unit.
pub fn without_unit(name: &str) -> (&str, &'static str) {
    const ENDINGS: [(&str, &str); 25] = [
        ("_1_pa2", "1/Pa²"),
        ("_1_pa", "1/Pa"),
        ("_nm_rad", "N·m/rad"),
        ("_kg_m3", "kg/m³"),
        ("_kg_m2", "kg·m²"),
        ("_kg_m_s", "kg·m/s"),
        ("_m_s2", "m/s²"),
        ("_rad_s", "rad/s"),
        ("_n_s_m", "N·s/m"),
        ("_m3_s", "m³/s"),
        ("_n_m", "N/m"),
        ("_m_n", "m/N"),
        ("_m_s", "m/s"),
        ("_n_s", "N·s"),
        ("_rad", "rad"),
        ("_pa", "Pa"),
        ("_kg", "kg"),
        ("_m3", "m³"),
        ("_m2", "m²"),
        ("_hz", "Hz"),
        ("_n", "N"),
        ("_j", "J"),
        ("_w", "W"),
        ("_m", "m"),
        ("_s", "s"),
    ];
    let ends = || ENDINGS.iter().filter_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit)));
    // The first of several pressures is a number of it and no reciprocal.
    ends().find(|(said, unit)| !(*unit == "1/Pa" && said.ends_with("pressure"))).unwrap_or((name, "-"))
}

//! Values that are made of parts: on the command line `key=value,…`, in a file a table.

use crate::error::{Error, Result};
use std::str::FromStr;

/// The parts of a value, each known key at most once and in any order. Results say `key:value`, which is read as well.
pub struct Parts<'a, const N: usize> {
    option: &'static str,
    text: &'a str,
    keys: [&'static str; N],
    values: [Option<&'a str>; N],
}

impl<'a, const N: usize> Parts<'a, N> {
    /// Splits the text of an option.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a key that is none of these; [`Error::InvalidValue`] for one that comes twice.
    pub fn of(option: &'static str, text: &'a str, keys: [&'static str; N]) -> Result<Self> {
        let mut parts = Parts { option, text, keys, values: [None; N] };
        for part in text.split(',').map(str::trim) {
            let (key, value) = part.split_once(['=', ':']).unwrap_or((part, ""));
            let place = keys.iter().position(|known| *known == key.trim_end());
            let place = place.ok_or_else(|| Error::unknown(option, key, keys))?;
            if parts.values[place].replace(value.trim_start()).is_some() {
                return Err(parts.refused(&format!("each of {} at most once", keys.join(", "))));
            }
        }
        Ok(parts)
    }

    /// Returns the text of a part, if it is there.
    pub fn get(&self, key: &str) -> Option<&'a str> {
        self.keys.iter().position(|known| *known == key).and_then(|place| self.values[place])
    }

    /// Reads a part into its place, if it is there; `expected` says what is valid.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for what cannot be read or is not valid.
    pub fn read<T: FromStr>(
        &self,
        key: &str,
        into: &mut T,
        is_valid: impl Fn(&T) -> bool,
        expected: &str,
    ) -> Result<()> {
        let Some(value) = self.get(key) else { return Ok(()) };
        *into = value.parse().ok().filter(is_valid).ok_or_else(|| self.refused(expected))?;
        Ok(())
    }

    /// Says what would be valid instead of the whole value.
    pub fn refused(&self, expected: &str) -> Error {
        Error::invalid(self.option, self.text, expected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_read_in_any_order_once_and_as_results_write_them() {
        for text in ["x=1,y=2.5", "y = 2.5 , x = 1", "x:1,y:2.5"] {
            let parts = Parts::of("place", text, ["x", "y"]).unwrap();
            let (mut x, mut y) = (0_u32, 0.0);
            parts.read("x", &mut x, |x| *x > 0, "a count above 0").unwrap();
            parts.read("y", &mut y, |y: &f64| y.is_finite(), "a number").unwrap();
            assert_eq!((x, y), (1, 2.5), "{text}");
        }
        let refused = |text: &str| Parts::of("place", text, ["x", "yaw"]).map(drop).unwrap_err().to_string();
        assert!(refused("x=1,x=2").contains("each of x, yaw at most once"));
        assert!(refused("yow=1").contains("did you mean `yaw`"));
        assert!(refused("").contains("valid: x, yaw"));
    }
}

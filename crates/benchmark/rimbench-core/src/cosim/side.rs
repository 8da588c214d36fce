//! The two sides, and whatever comes once per side.

use std::ops::{Index, IndexMut};

/// The two sides. The actuator side is the one that can use a reduced interface model, the mechanics side the one
/// that can offer it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Offers the interface model.
    Mechanics,
    /// Uses it.
    Actuator,
}

impl Side {
    /// Both, the mechanics first.
    pub const BOTH: [Side; 2] = [Side::Mechanics, Side::Actuator];

    /// Returns the other side.
    #[inline]
    pub fn other(self) -> Side {
        match self {
            Side::Mechanics => Side::Actuator,
            Side::Actuator => Side::Mechanics,
        }
    }
}

/// One thing per side.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PerSide<T> {
    /// Value of the mechanics.
    pub mechanics: T,
    /// Value of the actuator.
    pub actuator: T,
}

impl<T> PerSide<T> {
    /// Makes one thing for each side.
    pub fn from_fn(mut make: impl FnMut(Side) -> T) -> Self {
        PerSide { mechanics: make(Side::Mechanics), actuator: make(Side::Actuator) }
    }

    /// Turns each into something else.
    pub fn map<U>(self, mut change: impl FnMut(T) -> U) -> PerSide<U> {
        PerSide { mechanics: change(self.mechanics), actuator: change(self.actuator) }
    }

    /// Pairs both with those of another.
    pub fn zip<U>(self, other: PerSide<U>) -> PerSide<(T, U)> {
        PerSide { mechanics: (self.mechanics, other.mechanics), actuator: (self.actuator, other.actuator) }
    }

    /// Returns references to both.
    pub fn as_ref(&self) -> PerSide<&T> {
        PerSide { mechanics: &self.mechanics, actuator: &self.actuator }
    }

    /// Returns references to both, to be changed.
    pub fn as_mut(&mut self) -> PerSide<&mut T> {
        PerSide { mechanics: &mut self.mechanics, actuator: &mut self.actuator }
    }

    /// Returns that of `side` and that of the other, to be changed.
    pub fn split_mut(&mut self, side: Side) -> (&mut T, &mut T) {
        match side {
            Side::Mechanics => (&mut self.mechanics, &mut self.actuator),
            Side::Actuator => (&mut self.actuator, &mut self.mechanics),
        }
    }

    /// Iterates over both, the mechanics first.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        [&self.mechanics, &self.actuator].into_iter()
    }
}

impl<T> IntoIterator for PerSide<T> {
    type Item = T;
    type IntoIter = std::array::IntoIter<T, 2>;

    fn into_iter(self) -> Self::IntoIter {
        [self.mechanics, self.actuator].into_iter()
    }
}

impl<T> Index<Side> for PerSide<T> {
    type Output = T;

    #[inline]
    fn index(&self, side: Side) -> &T {
        match side {
            Side::Mechanics => &self.mechanics,
            Side::Actuator => &self.actuator,
        }
    }
}

impl<T> IndexMut<Side> for PerSide<T> {
    #[inline]
    fn index_mut(&mut self, side: Side) -> &mut T {
        match side {
            Side::Mechanics => &mut self.mechanics,
            Side::Actuator => &mut self.actuator,
        }
    }
}

//! One side of a run: the one that was given, or a copy that has taken its place.

use std::ops::{Deref, DerefMut};

/// Something that was lent to the loop, or a copy of it that the loop owns.
pub(super) enum Held<'a, T: ?Sized> {
    /// As it was given.
    Given(&'a mut T),
    /// A copy.
    Copy(Box<T>),
}

impl<T: ?Sized> Deref for Held<'_, T> {
    type Target = T;

    #[inline]
    fn deref(&self) -> &T {
        match self {
            Held::Given(given) => given,
            Held::Copy(copy) => copy,
        }
    }
}

impl<T: ?Sized> DerefMut for Held<'_, T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut T {
        match self {
            Held::Given(given) => given,
            Held::Copy(copy) => copy,
        }
    }
}

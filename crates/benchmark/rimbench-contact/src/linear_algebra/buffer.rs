//! Storage that lives inside its owner up to `N` elements and on the heap above.

use std::ops::{Deref, DerefMut};

/// A slice of at least `N` elements: inline until a longer one is asked for, then on the heap for good.
///
/// Growing forgets the contents. It is the only operation that allocates, and it does so once per larger length.
#[derive(Debug, Clone)]
pub struct Buffer<T, const N: usize> {
    inline: [T; N],
    heap: Vec<T>,
}

impl<T: Copy + Default, const N: usize> Buffer<T, N> {
    /// Reserves room for `len` elements.
    pub fn new(len: usize) -> Self {
        let mut buffer = Buffer { inline: [T::default(); N], heap: Vec::new() };
        buffer.grow(len);
        buffer
    }

    /// Makes room for `len` elements; allocates only if no earlier length was as large.
    pub fn grow(&mut self, len: usize) {
        if len > N && len > self.heap.len() {
            self.heap.resize(len, T::default());
        }
    }
}

impl<T, const N: usize> Deref for Buffer<T, N> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        if self.heap.is_empty() { &self.inline } else { &self.heap }
    }
}

impl<T, const N: usize> DerefMut for Buffer<T, N> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        if self.heap.is_empty() { &mut self.inline } else { &mut self.heap }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_slices_are_inline_and_long_ones_never_shrink() {
        let mut buffer = Buffer::<f64, 4>::new(3);
        assert_eq!((buffer.len(), buffer.heap.capacity()), (4, 0));
        buffer.grow(9);
        buffer.grow(2);
        assert_eq!(buffer.len(), 9);
    }
}

//! The communication steps in which an instance has moved, shared by its copies.

use std::sync::Arc;

/// One communication step.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Taken {
    /// When, in the model's own time, s.
    pub(super) t: f64,
    pub(super) h: f64,
    /// Longest step of the model's own in it, s.
    pub(super) longest: f64,
    pub(super) u: Box<[f64]>,
}

#[derive(Debug)]
struct Link {
    taken: Taken,
    before: Option<Arc<Link>>,
}

/// A list that grows at its end; a copy costs nothing, whatever its length.
#[derive(Debug, Clone, Default)]
pub(super) struct History {
    last: Option<Arc<Link>>,
    length: usize,
}

impl History {
    pub(super) fn push(&mut self, taken: Taken) {
        self.last = Some(Arc::new(Link { taken, before: self.last.take() }));
        self.length += 1;
    }

    pub(super) fn len(&self) -> usize {
        self.length
    }

    /// All steps, the first one first.
    pub(super) fn steps(&self) -> Vec<&Taken> {
        let mut steps = Vec::with_capacity(self.length);
        let mut next = self.last.as_ref();
        while let Some(link) = next {
            steps.push(&link.taken);
            next = link.before.as_ref();
        }
        steps.reverse();
        steps
    }
}

impl Drop for History {
    /// One link after the other: a long chain would not fit on the stack otherwise.
    fn drop(&mut self) {
        let mut next = self.last.take();
        while let Some(link) = next {
            next = Arc::into_inner(link).and_then(|mut link| link.before.take());
        }
    }
}

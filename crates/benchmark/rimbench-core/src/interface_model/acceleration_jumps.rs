//! Places ahead at which the geometry of a mechanical model has a kink.

/// When the free accelerations of a model will jump, and by how much.
///
/// ```text
/// t_j = t_k − d_j/ḋ_j          d_j distance from the kink, ḋ_j < 0 its rate at t_k
/// Δa_x = (Ȧ_x v)⁺ − (Ȧ_x v)⁻     at q + (t_j − t_k) v, on both sides of the kink
/// ```
/// Gaps and rows are continuous there: a plane becomes an arc, or an arc a plane, and the gap's second derivative jumps
/// with the curvature under one velocity. Both numbers are those of a motion with constant velocity, and off by
/// `O((t_j − t_k)²)` and `O(t_j − t_k)`: the velocity of the model by `O(H²)`, as it is without a kink.
/// # Shapes and units
/// Times since `t_k`, s; jumps `[n; t; i]` like [`a`](super::ReducedInterfaceModel::a), m/s².
#[derive(Debug, Default, PartialEq)]
pub struct AccelerationJumps {
    /// Whether they are to be found: each costs two evaluations of the model's rows.
    pub requested: bool,
    /// Whether they cannot be found; an empty list then says nothing.
    pub unknown: bool,
    places: usize,
    rows: usize,
    times: Vec<f64>,
    jumps: Vec<f64>,
}

impl Clone for AccelerationJumps {
    /// Copies with the capacity: a vector's own copy has capacity for its entries and no more, and a model that is
    /// copied before the loop must not allocate for its first kink within it.
    fn clone(&self) -> Self {
        let mut copy = AccelerationJumps {
            requested: self.requested,
            unknown: self.unknown,
            places: self.places,
            rows: self.rows,
            times: Vec::with_capacity(self.times.capacity()),
            jumps: Vec::with_capacity(self.jumps.capacity()),
        };
        copy.copy_from(self);
        copy
    }
}

impl AccelerationJumps {
    /// Makes room for `places` kinks of models with `rows` rows.
    pub fn with_room(places: usize, rows: usize) -> Self {
        let (times, jumps) = (Vec::with_capacity(places), Vec::with_capacity(places * rows));
        AccelerationJumps { requested: false, unknown: false, places, rows, times, jumps }
    }

    /// Returns how many there may be at once.
    pub fn places(&self) -> usize {
        self.places
    }

    /// Forgets those that there are.
    pub fn clear(&mut self) {
        self.times.clear();
        self.jumps.clear();
    }

    /// Adds a kink `time` (s) after the communication point; returns where its jumps belong, all zero.
    pub fn add(&mut self, time: f64) -> &mut [f64] {
        self.times.push(time);
        let first = self.jumps.len();
        self.jumps.resize(first + self.rows, 0.0);
        &mut self.jumps[first..]
    }

    /// Returns the kinks: when each is reached, s after the communication point, and by how much accelerations of all
    /// rows jump there.
    pub fn iter(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.times.iter().copied().zip(self.jumps.chunks_exact(self.rows.max(1)))
    }

    /// Takes over the kinks of another model without allocating.
    pub(super) fn copy_from(&mut self, other: &Self) {
        if self.times.is_empty() && other.times.is_empty() {
            return;
        }
        self.times.clear();
        self.times.extend_from_slice(&other.times);
        self.jumps.clear();
        self.jumps.extend_from_slice(&other.jumps);
    }
}

//! Which of many travelling discs are near each other, and the rows of contacts that come and go.

use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::f64::consts::SQRT_2;

/// Centres of discs, by the places where they are.
pub(super) struct Places(RTree<GeomWithData<[f64; 2], usize>>);

impl Places {
    /// Sorts the centres, `[x_0, y_0, x_1, y_1, …]` (m).
    pub(super) fn of(centres: &[f64]) -> Self {
        let places = centres.as_chunks::<2>().0.iter().enumerate();
        Places(RTree::bulk_load(places.map(|(disc, centre)| GeomWithData::new(*centre, disc)).collect()))
    }

    /// Returns all pairs `i < j` whose centres are at most `distance` (m) apart, in no particular order.
    pub(super) fn pairs_within(&self, distance: f64) -> impl Iterator<Item = (usize, usize)> + use<'_> {
        self.0.iter().flat_map(move |one| {
            let near = self.0.locate_within_distance(*one.geom(), distance * distance);
            near.filter(|other| one.data < other.data).map(|other| (one.data, other.data))
        })
    }
}

/// Rows of the possible contacts of discs that travel: as many as ever, while contacts come and go.
///
/// Listed are contacts with a gap below the reach r, and listed anew once
///
/// ```text
/// √2 max |q_k − q_k'| + √2 h max |v_k| > r/4        q': when they were listed; h the step to come
/// ```
/// No disc has gone or will go farther than that, so that a contact that is not listed has a gap of `r/2` at least at the end of that step,
/// but for what velocities change by in it. What stays listed keeps its row.
///
/// Discs of radius R that do not overlap, with those joined whose centres are less than `2√2 R` apart, are a planar graph: of four whose
/// connections cross two are closer than 2 R. So are the walls that they are near. Of N discs and walls there are 3 N − 6 contacts at most.
/// # Source
/// Verlet, Phys. Rev. 159 (1967), for lists with a reach; the bound is Euler's.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TravellingContacts<C> {
    rows: Vec<Option<C>>,
    /// How many of the first stand for the same throughout.
    permanent: usize,
    reach: f64,
    /// Coordinates when they were listed.
    listed_at: Vec<f64>,
}

impl<C: Copy + Ord> TravellingContacts<C> {
    /// Largest reach in radii for which there are never more contacts than rows: `2√2 − 2`, and a little less, for discs that overlap by
    /// rounding and more.
    pub(super) const LARGEST_REACH: f64 = 0.8;

    /// Returns how many contacts discs and walls may be near to at a time.
    pub(super) fn most(discs: usize, walls: usize) -> usize {
        (3 * (discs + walls)).saturating_sub(6)
    }

    /// Makes rows for contacts that stay and for `others` that come and go, none of which is listed yet.
    pub(super) fn new(permanent: Vec<C>, others: usize, reach: f64) -> Self {
        let count = permanent.len();
        let rows = permanent.into_iter().map(Some).chain((0..others).map(|_| None)).collect();
        TravellingContacts { rows, permanent: count, reach, listed_at: Vec::new() }
    }

    /// Returns what each row stands for.
    pub(super) fn rows(&self) -> &[Option<C>] {
        &self.rows
    }

    /// Returns the gap up to which contacts are listed, m.
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// Tells whether contacts must be listed anew before a step of `h` (s), for bodies with these coordinates and velocities.
    pub(super) fn is_due(&self, q: &[f64], v: &[f64], h: f64) -> bool {
        let moved = q.iter().zip(&self.listed_at).fold(0.0_f64, |most, (now, then)| most.max((now - then).abs()));
        let speed = v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        SQRT_2 * (moved + h * speed) > 0.25 * self.reach
    }

    /// Lists these contacts, each with its gap (m), for bodies with these coordinates; tells whether a row stands for another one than before.
    ///
    /// Should there be more than rows, which takes discs that overlap by a tenth of their radius, those with the smallest gaps are listed.
    pub(super) fn list(&mut self, q: &[f64], mut near: Vec<(f64, C)>) -> bool {
        self.listed_at.clear();
        self.listed_at.extend_from_slice(q);
        let (permanent, others) = self.rows.split_at_mut(self.permanent);
        near.retain(|(_, contact)| !permanent.contains(&Some(*contact)));
        if near.len() > others.len() {
            near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            near.truncate(others.len());
        }
        let mut near: Vec<C> = near.into_iter().map(|(_, contact)| contact).collect();
        near.sort_unstable();
        let mut stays = vec![false; near.len()];
        let mut changed = false;
        for row in others.iter_mut() {
            let Some(contact) = row else { continue };
            match near.binary_search(contact) {
                Ok(at) => stays[at] = true,
                Err(_) => (*row, changed) = (None, true),
            }
        }
        let mut free = others.iter_mut().filter(|row| row.is_none());
        for (contact, _) in near.into_iter().zip(stays).filter(|(_, stays)| !stays) {
            let Some(row) = free.next() else { break };
            (*row, changed) = (Some(contact), true);
        }
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Centres on a disturbed hexagonal lattice of spacing 2, seen row by row.
    fn lattice(columns: usize, layers: usize, disturb: impl Fn(usize) -> f64) -> Vec<f64> {
        let centre = |k: usize| {
            let (column, layer) = (k % columns, k / columns);
            let x = 2.0 * column as f64 + (layer % 2) as f64 + disturb(2 * k);
            [x, 3.0_f64.sqrt() * layer as f64 + disturb(2 * k + 1)]
        };
        (0..columns * layers).flat_map(centre).collect()
    }

    fn distance(centres: &[f64], (i, j): (usize, usize)) -> f64 {
        libm::hypot(centres[2 * i] - centres[2 * j], centres[2 * i + 1] - centres[2 * j + 1])
    }

    #[test]
    fn pairs_are_those_that_a_look_at_all_of_them_finds() {
        let centres = lattice(9, 7, |k| 0.8 * libm::sin(12.9 * k as f64));
        let places = Places::of(&centres);
        let all = || (0..63).flat_map(|i| (i + 1..63).map(move |j| (i, j)));
        for reach in [0.1, 1.9, 2.7, 40.0] {
            let mut found: Vec<_> = places.pairs_within(reach).collect();
            found.sort_unstable();
            let expected: Vec<_> = all().filter(|pair| distance(&centres, *pair) <= reach).collect();
            assert_eq!(found, expected, "{reach}");
        }
    }

    /// The densest packing has all the contacts that there can be, with its outer discs near the walls.
    #[test]
    fn there_are_never_more_contacts_near_than_the_bound_says() {
        let mut fullest = 0.0_f64;
        for (columns, layers) in [(2, 2), (5, 4), (20, 30)] {
            for wide in [1.0, 1.2, 1.39] {
                let centres: Vec<f64> = lattice(columns, layers, |_| 0.0).iter().map(|x| wide * x).collect();
                let count = Places::of(&centres)
                    .pairs_within(2.0 + TravellingContacts::<(usize, usize)>::LARGEST_REACH)
                    .count();
                let most = TravellingContacts::<(usize, usize)>::most(columns * layers, 0);
                assert!(count <= most, "{count} of {most}");
                fullest = fullest.max(count as f64 / most as f64);
            }
        }
        assert!(fullest > 0.9, "{fullest}");
    }

    #[test]
    fn what_stays_near_keeps_its_row_and_what_comes_takes_a_free_one() {
        let mut contacts = TravellingContacts::new(vec![9, 4], 3, 0.8);
        let near = |of: &[i32]| of.iter().map(|&contact| (0.1, contact)).collect::<Vec<_>>();
        let centres = [0.0, 0.0, 2.0, 0.0];
        assert!(contacts.list(&centres, near(&[7, 2, 4])));
        assert_eq!(contacts.rows(), [Some(9), Some(4), Some(2), Some(7), None]);
        assert!(!contacts.list(&centres, near(&[2, 7])), "a permanent one stays");
        assert!(contacts.list(&centres, near(&[1, 7, 3])));
        assert_eq!(contacts.rows(), [Some(9), Some(4), Some(1), Some(7), Some(3)]);
        // More than there are rows: the nearest.
        assert!(contacts.list(&centres, vec![(0.3, 1), (0.2, 5), (0.1, 6), (0.0, 7)]));
        assert_eq!(contacts.rows(), [Some(9), Some(4), Some(5), Some(7), Some(6)]);
        // A quarter of the reach, by way gone or by way to come.
        assert!(!contacts.is_due(&[0.14, 0.14, 2.0, 0.0], &[0.0; 4], 1.0));
        assert!(contacts.is_due(&[0.0, 0.15, 2.0, 0.0], &[0.0; 4], 1.0));
        assert!(contacts.is_due(&[0.0, 0.14, 2.0, 0.0], &[0.0, 0.0, 3.0, -4.0], 5e-3));
    }
}

//! Which of many travelling discs are near each other, and the rows of contacts that come and go.

use rimbench_core::error::Failure;
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::f64::consts::SQRT_2;

/// A gap below zero by up to this part of a radius is rounding.
pub(super) const ROUNDING: f64 = 1e-9;

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
/// so that a contact that is not listed has a gap of `r/2` left, as long as discs go less than `r/4` in that step. One
/// that has closed all the same is found at its end, and is an error. What stays listed keeps its row.
///
/// Discs of radius R that do not overlap, with those joined whose centres are less than `2√2 R` apart, are a planar
/// graph: of four whose connections cross two are closer than 2 R. So are the walls that they are near. Of N discs and
/// walls there are 3 N − 6 contacts at most. Should there be more, which takes discs that overlap by a fiftieth of
/// their radius, the farthest are not listed, and r is the gap of the nearest of those.
/// # Source
/// Verlet, Phys. Rev. 159 (1967), for lists with a reach; the bound is Euler's.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TravellingContacts<C> {
    rows: Vec<Option<C>>,
    /// How many of the first stand for the same throughout.
    permanent: usize,
    reach: f64,
    /// Gap up to which the last list is complete, m.
    complete_to: f64,
    /// Coordinates when they were listed.
    listed_at: Vec<f64>,
}

impl<C: Copy + Ord> TravellingContacts<C> {
    /// Largest reach in radii for which there are never more contacts than rows: `2√2 − 2`, and a little less, for
    /// discs that overlap.
    pub(super) const LARGEST_REACH: f64 = 0.8;

    /// Returns how many contacts discs and walls may be near to at a time.
    pub(super) fn most(discs: usize, walls: usize) -> usize {
        (3 * (discs + walls)).saturating_sub(6)
    }

    /// Makes rows for contacts that stay and for `others` that come and go, none of which is listed yet.
    pub(super) fn new(permanent: Vec<C>, others: usize, reach: f64) -> Self {
        let count = permanent.len();
        let rows = permanent.into_iter().map(Some).chain((0..others).map(|_| None)).collect();
        TravellingContacts { rows, permanent: count, reach, complete_to: reach, listed_at: Vec::new() }
    }

    /// Returns what each row stands for.
    pub(super) fn rows(&self) -> &[Option<C>] {
        &self.rows
    }

    /// Returns the gap up to which contacts are listed, m.
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// Tells whether contacts must be listed anew before a step of `h` (s), for bodies with these coordinates and
    /// velocities.
    pub(super) fn is_due(&self, q: &[f64], v: &[f64], h: f64) -> bool {
        let moved = q.iter().zip(&self.listed_at).fold(0.0_f64, |most, (now, then)| most.max((now - then).abs()));
        let speed = v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        SQRT_2 * (moved + h * speed) > 0.25 * self.complete_to
    }

    /// Lists these contacts, each with its gap (m), for bodies with these coordinates; tells whether a row stands for
    /// another one than before, and the least gap of those that are new.
    pub(super) fn list(&mut self, q: &[f64], mut near: Vec<(f64, C)>) -> Listed {
        self.listed_at.clear();
        self.listed_at.extend_from_slice(q);
        let (permanent, others) = self.rows.split_at_mut(self.permanent);
        near.retain(|(_, contact)| !permanent.contains(&Some(*contact)));
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.complete_to = near.get(others.len()).map_or(self.reach, |(gap, _)| *gap);
        near.truncate(others.len());
        near.sort_unstable_by_key(|(_, contact)| *contact);
        let mut stays = vec![false; near.len()];
        let mut listed = Listed { changed: false, least_new_gap: f64::INFINITY };
        for row in others.iter_mut() {
            let Some(contact) = row else { continue };
            match near.binary_search_by(|(_, near)| near.cmp(contact)) {
                Ok(at) => stays[at] = true,
                Err(_) => (*row, listed.changed) = (None, true),
            }
        }
        let mut free = others.iter_mut().filter(|row| row.is_none());
        for ((gap, contact), _) in near.into_iter().zip(stays).filter(|(_, stays)| !stays) {
            let Some(row) = free.next() else { break };
            *row = Some(contact);
            listed = Listed { changed: true, least_new_gap: listed.least_new_gap.min(gap) };
        }
        listed
    }

    /// The same after a step.
    ///
    /// # Errors
    /// If one that is new has closed, by more than `rounding` (m): nothing has stopped it.
    pub(super) fn remap_contacts(&mut self, q: &[f64], near: Vec<(f64, C)>, rounding: f64) -> Result<bool, Failure> {
        let Listed { changed, least_new_gap } = self.list(q, near);
        if least_new_gap < -rounding {
            return Err(Failure::out_of_range("gap_not_listed_m", least_new_gap));
        }
        Ok(changed)
    }
}

/// What a list is beside the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Listed {
    /// Whether a row stands for another contact.
    pub(super) changed: bool,
    /// m; infinite where nothing is new.
    pub(super) least_new_gap: f64,
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

    /// Discs of radius 1 in a box whose walls touch the outermost.
    #[test]
    fn there_are_never_more_contacts_near_than_the_bound_says_and_with_a_larger_reach_there_are() {
        let least_and_most = |centres: &[f64], axis: usize| {
            let along = || centres.iter().skip(axis).step_by(2).copied();
            [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)]
        };
        let near = |centres: &[f64], reach: f64| {
            let ([left, right], [floor, _]) = (least_and_most(centres, 0), least_and_most(centres, 1));
            let discs = centres.as_chunks::<2>().0;
            let walls = discs.iter().map(|[x, y]| [x - left, right - x, y - floor]);
            let walls: usize = walls.map(|gaps| gaps.iter().filter(|gap| **gap <= reach).count()).sum();
            walls + Places::of(centres).pairs_within(2.0 + reach).count()
        };
        let reach = TravellingContacts::<(usize, usize)>::LARGEST_REACH;
        // Hexagonal packings have most contacts that touch, and square ones are the first to have diagonals.
        let square = |n: usize| (0..n * n).flat_map(move |k| [2.0 * (k % n) as f64, 2.0 * (k / n) as f64]).collect();
        let packings: [Vec<f64>; 5] =
            [lattice(2, 2, |_| 0.0), lattice(5, 4, |_| 0.0), lattice(20, 30, |_| 0.0), square(3), square(12)];
        let mut fullest = 0.0_f64;
        for centres in &packings {
            for wide in [1.0, 1.2, 1.39] {
                let centres: Vec<f64> = centres.iter().map(|x| wide * x).collect();
                let most = TravellingContacts::<(usize, usize)>::most(centres.len() / 2, 3);
                let count = near(&centres, reach);
                assert!(count <= most, "{count} of {most}");
                fullest = fullest.max(count as f64 / most as f64);
            }
        }
        assert!(fullest > 0.9, "{fullest}");
        assert!(near(&packings[4], 0.83) > TravellingContacts::<(usize, usize)>::most(144, 3));
    }

    #[test]
    fn what_stays_near_keeps_its_row_and_what_comes_takes_a_free_one() {
        let mut contacts = TravellingContacts::new(vec![9, 4], 3, 0.8);
        let near = |of: &[i32]| of.iter().map(|&contact| (0.1, contact)).collect::<Vec<_>>();
        let centres = [0.0, 0.0, 2.0, 0.0];
        let list = |contacts: &mut TravellingContacts<i32>, near| contacts.list(&centres, near).changed;
        assert!(list(&mut contacts, near(&[7, 2, 4])));
        assert_eq!(contacts.rows(), [Some(9), Some(4), Some(2), Some(7), None]);
        assert!(!list(&mut contacts, near(&[2, 7])), "a permanent one stays");
        assert!(list(&mut contacts, near(&[1, 7, 3])));
        assert_eq!(contacts.rows(), [Some(9), Some(4), Some(1), Some(7), Some(3)]);
        // More than there are rows: the nearest, and it holds for less.
        assert!(list(&mut contacts, vec![(0.4, 1), (0.2, 5), (0.1, 6), (0.0, 7)]));
        assert_eq!(contacts.rows(), [Some(9), Some(4), Some(5), Some(7), Some(6)]);
        assert!(contacts.is_due(&[0.0, 0.08, 2.0, 0.0], &[0.0; 4], 1.0));
        // What is new and has closed was missed; what was listed has been looked after.
        assert_eq!(contacts.remap_contacts(&centres, vec![(-0.1, 5), (0.1, 6)], 1e-9), Ok(true));
        assert_eq!(contacts.remap_contacts(&centres, vec![(-0.1, 5), (-1e-10, 3)], 1e-9), Ok(true));
        let missed = contacts.remap_contacts(&centres, vec![(-0.1, 5), (-0.2, 8)], 1e-9).unwrap_err();
        assert!(missed.to_string().contains("gap_not_listed_m = -2"), "{missed}");
        assert_eq!(contacts.remap_contacts(&centres, near(&[1]), 1e-9), Ok(true));
        // A quarter of the reach, by way gone or by way to come.
        assert!(!contacts.is_due(&[0.14, 0.14, 2.0, 0.0], &[0.0; 4], 1.0));
        assert!(contacts.is_due(&[0.0, 0.15, 2.0, 0.0], &[0.0; 4], 1.0));
        assert!(contacts.is_due(&[0.0, 0.14, 2.0, 0.0], &[0.0, 0.0, 3.0, -4.0], 5e-3));
    }
}

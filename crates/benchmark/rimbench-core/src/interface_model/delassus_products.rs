//! Which rows share velocities, and the products that this makes.

use rimbench_contact::linear_algebra::SymmetricPattern;

/// `A M⁻¹ Aᵀ` of rows that involve few velocities each, pair by pair.
#[derive(Debug, Clone)]
pub(super) struct DelassusProducts {
    /// Of each entry at or below the diagonal: where it stands, and where its mirror image.
    places: Vec<[u32; 2]>,
    /// Where the products of a meeting end, and the two entries of `A` in each.
    ends: Vec<u32>,
    products: Vec<[u32; 2]>,
}

impl DelassusProducts {
    /// Returns which rows are coupled: those that share one of so many velocities.
    pub(super) fn pattern(starts: &[usize], columns: &[u32], velocities: usize) -> SymmetricPattern {
        let mut knowing = vec![Vec::new(); velocities];
        let known = |bounds: &[usize]| columns[bounds[0]..bounds[1]].iter().map(|&column| column as usize);
        for (row, bounds) in starts.windows(2).enumerate() {
            known(bounds).for_each(|velocity| knowing[velocity].push(row));
        }
        let others = |bounds: &[usize]| known(bounds).flat_map(|velocity| knowing[velocity].iter().copied()).collect();
        SymmetricPattern::new(&starts.windows(2).map(others).collect::<Vec<_>>())
    }

    /// Lists the products of every meeting in `pattern`, of rows that keep their entries between `starts` in `columns`.
    pub(super) fn new(starts: &[usize], columns: &[u32], pattern: &SymmetricPattern) -> Self {
        let (mut places, mut ends, mut products) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..pattern.size() {
            for &column in pattern.columns(row).iter().filter(|&&column| column as usize <= row) {
                let other = column as usize;
                let Some(mirrored) = pattern.position(other, row) else { continue };
                let Some(at) = pattern.position(row, other) else { continue };
                places.push([at as u32, mirrored as u32]);
                for a in starts[row]..starts[row + 1] {
                    let b = (starts[other]..starts[other + 1]).find(|&b| columns[b] == columns[a]);
                    products.extend(b.map(|b| [a as u32, b as u32]));
                }
                ends.push(products.len() as u32);
            }
        }
        DelassusProducts { places, ends, products }
    }

    /// Writes the entries of the matrix from those of `A` and of `A M⁻¹`.
    pub(super) fn fill(&self, a: &[f64], scaled: &[f64], entries: &mut [f64]) {
        let mut first = 0;
        for (&[at, mirrored], &end) in self.places.iter().zip(&self.ends) {
            let products = &self.products[first as usize..end as usize];
            let entry = products.iter().map(|&[row, other]| a[row as usize] * scaled[other as usize]).sum();
            (entries[at as usize], entries[mirrored as usize]) = (entry, entry);
            first = end;
        }
    }
}

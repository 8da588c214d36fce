//! The area that some scheme rows cover, as a figure asks for it.

use super::keys::*;
use crate::chart::Band;
use crate::style::Styles;
use std::collections::BTreeMap;

keys! {
    /// From the least to the largest value of some scheme rows.
    pub struct BandSpec {
        pub labels: Vec<String> =
            key(Takes::Labels, Needed, "scheme rows; those lost at a point are left out there"),
        pub label: String = key(Takes::Text, Needed, "what the legend says"),
    }
}

/// Key of figures and panels.
pub const BAND: Key =
    key(Takes::Table(BandSpec::KEYS), Then("none"), "an area from the least to the largest of some scheme rows");

impl BandSpec {
    /// Fills the area between the least and the largest of the curves at each abscissa that one of them has; one that has no finite
    /// value there is left out, and where none has one the band breaks. Its colour is that of the first row.
    pub fn filled(&self, curves: &[Vec<(f64, f64)>], styles: &Styles) -> Band {
        // Abscissas are times or macro steps, so not below zero: their bits are in order.
        let mut edges: BTreeMap<u64, [f64; 2]> = BTreeMap::new();
        for &(x, y) in curves.iter().flatten().filter(|(x, _)| *x >= 0.0) {
            let edge = edges.entry((x + 0.0).to_bits()).or_insert([f64::NAN; 2]);
            if y.is_finite() {
                *edge = [edge[0].min(y), edge[1].max(y)];
            }
        }
        let points = edges.into_iter().map(|(x, edge)| (f64::from_bits(x), edge)).collect();
        let color = self.labels.first().map_or(crate::drawing::Color::SOFT_INK, |label| styles.of_label(label).color);
        Band { label: self.label.clone(), points, color }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_is_as_wide_as_its_curves_and_breaks_where_all_are_lost() {
        let spec = BandSpec { labels: vec!["rim-smooth".to_owned()], label: "margins".to_owned() };
        let one = vec![(0.0, 1.0), (1.0, 5.0), (2.0, f64::INFINITY), (3.0, 2.0)];
        let other = vec![(0.0, 3.0), (1.0, -1.0), (2.0, f64::NAN)];
        let band = spec.filled(&[one, other], &Styles::standard());
        let [first, second, third, fourth] = band.points.try_into().unwrap();
        assert_eq!((first, second, fourth), ((0.0, [1.0, 3.0]), (1.0, [-1.0, 5.0]), (3.0, [2.0, 2.0])));
        assert!(third.0 == 2.0 && third.1.iter().all(|edge| edge.is_nan()));
    }
}

//! Inner products: of long rows, with independent partial sums so that they are not bound by the latency of one
//! addition, and of the few numbers of two bodies.

/// Returns `Σ a_k b_k` over the shorter of the two lengths.
///
/// Up to seven elements are added in order; above, eight partial sums are kept. The result depends on the lengths and
/// values only, never on the machine.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    if a.len() < 8 { a.iter().zip(b).map(|(x, y)| x * y).sum() } else { long(a, b) }
}

#[inline]
fn long(a: &[f64], b: &[f64]) -> f64 {
    let (a_blocks, a_rest) = a.as_chunks::<8>();
    let (b_blocks, b_rest) = b.as_chunks::<8>();
    let mut partial = [0.0; 8];
    for (x, y) in a_blocks.iter().zip(b_blocks) {
        for lane in 0..8 {
            partial[lane] += x[lane] * y[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    let [p0, p1, p2, p3, p4, p5, p6, p7] = partial;
    ((p0 + p4) + (p1 + p5)) + ((p2 + p6) + (p3 + p7)) + rest
}

/// Returns `Σ a_k b_k` for vectors of two planar bodies or few numbers.
///
/// In order; six elements, the coordinates of two planar bodies and the most frequent size, body by body: a length
/// known to the compiler halves the work. So it does with twelve, two bodies in space.
#[inline]
pub fn body_dot(a: &[f64], b: &[f64]) -> f64 {
    if let (Ok(a), Ok(b)) = (<&[f64; 6]>::try_from(a), <&[f64; 6]>::try_from(b)) {
        return (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
    }
    if let (Ok(a), Ok(b)) = (<&[f64; 12]>::try_from(a), <&[f64; 12]>::try_from(b)) {
        return a.iter().zip(b).map(|(x, y)| x * y).sum();
    }
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_to_seven_products_are_added_in_order_and_more_in_eight_sums() {
        let a = [1e16, 1.0, 1.0, 1.0, -1e16, 1.0, 1.0, 1.0, 1.0];
        // In order a large number swallows what is added to it before it is taken away again.
        assert_eq!([5, 7, 8, 9].map(|length| dot(&a[..length], &[1.0; 9])), [0.0, 2.0, 6.0, 7.0]);
    }
}

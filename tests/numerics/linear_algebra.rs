//! Factors and solutions of small dense systems.

use rand::{RngExt, SeedableRng};
use rimbench::linear_algebra::{Cholesky, Factor, Lu, Singular, largest_entry};

#[test]
fn the_known_answer_is_found_at_every_size() {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
    let mut lu = Lu::new(100);
    for n in [1, 2, 5, 17, 63, 64, 100] {
        let mut a: Vec<f64> = (0..n * n).map(|_| rng.random_range(-1.0..1.0)).collect();
        let wanted: Vec<f64> = (0..n).map(|_| rng.random_range(-1.0..1.0)).collect();
        let product = |row: &[f64]| row.iter().zip(&wanted).map(|(a, x)| a * x).sum();
        let mut x: Vec<f64> = a.chunks(n).map(product).collect();
        assert!(lu.solve(&mut a, &mut x));
        assert!(x.iter().zip(&wanted).all(|(x, wanted)| (x - wanted).abs() < 1e-10), "n = {n}");
    }
}

#[test]
fn a_singular_or_undefined_matrix_is_refused() {
    for n in [2, 80] {
        let one: Vec<f64> = (0..n * n).map(|k| f64::from(u8::from(k % (n + 1) == 0))).collect();
        let (mut repeated, mut undefined) = (one.clone(), one);
        repeated.copy_within((n - 2) * n..(n - 1) * n, (n - 1) * n);
        undefined[0] = f64::NAN;
        for mut a in [repeated, undefined, vec![0.0; n * n]] {
            assert!(!Lu::new(n).solve(&mut a, &mut vec![1.0; n]), "n = {n}");
        }
    }
}

#[test]
fn appending_and_removing_in_any_order_leaves_the_factor_of_the_set() {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
    for n in [5, 8, 23] {
        let b: Vec<f64> = (0..n * n).map(|_| rng.random_range(-1.0..1.0)).collect();
        let entry = |i: usize, j: usize| (0..n).map(|k| b[i * n + k] * b[j * n + k]).sum::<f64>();
        let m: Vec<f64> =
            (0..n * n).map(|at| entry(at / n, at % n) + if at / n == at % n { 0.1 } else { 0.0 }).collect();
        let mut factor = Factor::new(n);
        let mut set = Vec::new();
        for step in 0..20 * n {
            let j = rng.random_range(0..n);
            if let Some(k) = set.iter().position(|&i| i == j) {
                factor.remove(k);
                set.remove(k);
            } else {
                let d = factor.border(&m, &set, j);
                factor.push(d);
                set.push(j);
            }
            if set.is_empty() {
                continue;
            }
            let wanted: Vec<f64> = (0..set.len()).map(|r| (r + step) as f64 - 3.0).collect();
            let row = |i: &usize| set.iter().zip(&wanted).map(|(j, x)| m[i * n + j] * x).sum();
            let mut x: Vec<f64> = set.iter().map(row).collect();
            factor.solve(&mut x);
            let scale = 1.0 + largest_entry(&wanted);
            assert!(x.iter().zip(&wanted).all(|(x, wanted)| (x - wanted).abs() < 1e-8 * scale));
        }
    }
}

#[test]
fn a_repeated_row_has_pivot_zero() {
    let m = [2.0, 2.0, 2.0, 2.0];
    let mut factor = Factor::new(2);
    let d = factor.border(&m, &[], 0);
    factor.push(d);
    assert_eq!(factor.border(&m, &[0], 1), 0.0);
    let mut p = [0.0];
    factor.direction(&mut p);
    assert_eq!(p, [1.0]);
}

fn spd(n: usize) -> Vec<f64> {
    let mut a = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..n {
            a[i * n + j] = 1.0 / (1.0 + (i as f64 - j as f64).abs()) + if i == j { 1.0 } else { 0.0 };
        }
    }
    a
}

#[test]
fn small_and_large_sizes_solve_to_round_off() {
    for n in [1, 2, 5, 15, 16, 17, 64] {
        let a = spd(n);
        let mut factor = Cholesky::new(n);
        factor.l.copy_from_slice(&a);
        // Only the lower triangle counts.
        (0..n).for_each(|i| factor.l[i * n + i + 1..(i + 1) * n].fill(f64::NAN));
        factor.factor("test").unwrap();
        let exact: Vec<f64> = (0..n).map(|i| f64::sin(i as f64)).collect();
        let mut x: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[i * n + j] * exact[j]).sum()).collect();
        factor.solve(&mut x);
        for (found, wanted) in x.iter().zip(&exact) {
            approx::assert_abs_diff_eq!(found, wanted, epsilon = 1e-12);
        }
    }
}

#[test]
fn a_dependent_row_is_reported_by_the_name_of_the_matrix() {
    for n in [2, 40] {
        let mut a = spd(n);
        // The last row and column are those of the last but one.
        for i in 0..n {
            a[(n - 1) * n + i] = a[(n - 2) * n + i];
        }
        for i in 0..n {
            a[i * n + n - 1] = a[i * n + n - 2];
        }
        let mut factor = Cholesky::new(n);
        factor.l.copy_from_slice(&a);
        assert_eq!(factor.factor("S"), Err(Singular { matrix: "S" }));
    }
}

//! Planar problems with friction of Siconos: nobody's home ground. They are not in this tree, see
//! `support::data_of_others`.
//!
//! The files are those of `numerics/src/FrictionContact/test/data` whose first number is a 2, as Siconos 4.4 writes
//! them: the dimension, the number of contacts, the kind of matrix, its sizes, the matrix (dense by columns, or blocks
//! by rows of blocks, each by columns), q, and the coefficients. Contacts come one after the other there, each with its
//! normal and its tangential row.

use crate::support::*;
use rimbench::complementarity::{SolveStats, Unsolved};
use rimbench::friction::{
    ActiveStates, ContactState, ContactSweeps, CopositiveLemke, ENUMERATION_LIMIT, Enumeration, FrictionProblem,
    FrictionSolver,
};
use std::path::Path;

/// Contacts up to which problems are solved in a test; the larger ones take all methods together minutes.
const MOST_CONTACTS: usize = 89;

/// A problem with T tangential rows per contact.
pub struct OfOthers<const T: usize> {
    pub name: String,
    pub h: Vec<f64>,
    pub b: Vec<f64>,
    pub friction: Vec<f64>,
}

impl<const T: usize> OfOthers<T> {
    pub fn problem(&self) -> FrictionProblem<'_, T> {
        FrictionProblem::with_friction(&self.h, &self.b, &self.friction)
    }
}

/// Reads a file; none if it has another number of rows per contact.
fn read<const T: usize>(path: &Path) -> Option<OfOthers<T>> {
    let per_contact = 1 + T;
    let text = std::fs::read_to_string(path).ok()?;
    let mut numbers = text.split_whitespace().map(|word| word.parse::<f64>().expect("a number"));
    let mut next = || numbers.next().expect("another number");
    if next() != per_contact as f64 {
        return None;
    }
    let (n, kind) = (next() as usize, next());
    let size = per_contact * n;
    // A global problem begins with its mass matrix.
    if [next(), next()] != [size as f64; 2] {
        return None;
    }
    // Their rows: n, t of the first contact, n, t of the second; ours: all n, then all t.
    let ours = |row: usize| row % per_contact * n + row / per_contact;
    let mut h = vec![0.0; size * size];
    if kind == 0.0 {
        assert_eq!([next(), next()], [size as f64; 2]);
        for entry in 0..size * size {
            h[ours(entry % size) * size + ours(entry / size)] = next();
        }
    } else {
        let blocks = next() as usize;
        assert_eq!([next(), next()], [n as f64; 2], "blocks of the rows of a contact");
        for _ in 0..2 * n {
            next();
        }
        let (filled, entries) = (next() as usize, next() as usize);
        let starts: Vec<usize> = (0..filled).map(|_| next() as usize).collect();
        let columns: Vec<usize> = (0..entries).map(|_| next() as usize).collect();
        assert_eq!(blocks, entries);
        for (block, &column) in columns.iter().enumerate() {
            assert_eq!(next(), block as f64, "blocks are numbered");
            let row = starts.iter().rposition(|start| *start <= block).expect("a row of blocks");
            for entry in 0..per_contact * per_contact {
                let (row, column) =
                    (per_contact * row + entry % per_contact, per_contact * column + entry / per_contact);
                h[ours(row) * size + ours(column)] = next();
            }
        }
    }
    let mut b = vec![0.0; size];
    for row in 0..size {
        b[ours(row)] = next();
    }
    let friction = (0..n).map(|_| next()).collect();
    let name = path.file_name().expect("a file").to_string_lossy().into_owned();
    Some(OfOthers { name, h, b, friction })
}

/// What each method makes of a problem, from nothing: its natural residual, infinite where it gave up.
fn residuals(planar: &OfOthers<1>) -> [(&'static str, f64); 5] {
    let (problem, n) = (planar.problem(), planar.friction.len());
    let (mut states, mut p) = (vec![ContactState::Open; n], vec![0.0; 2 * n]);
    let judge =
        |found: Result<SolveStats, Unsolved>, p: &[f64]| found.map_or(f64::INFINITY, |_| problem.natural_residual(p));
    let found = ActiveStates::new(n).attempt(problem, false, &mut states, &mut p);
    let active = judge(found, &p);
    let found = Enumeration::new(n.min(ENUMERATION_LIMIT)).attempt(problem, 1e-12, &mut states, &mut p);
    let enumeration = judge(found, &p);
    let found = CopositiveLemke::new(n).attempt(problem, &mut states, &mut p);
    let lemke = judge(found, &p);
    p.fill(0.0);
    let (_, residual) = ContactSweeps::<1>::new(n).sweep(problem, 1e-10, 5000, &mut p);
    let sweeps = if residual <= 1e-10 { residual } else { f64::INFINITY };
    let mut solver = FrictionSolver::new(n, 1e-9);
    let found = solver.solve(problem, &mut p);
    let all = judge(found, &p);
    [("active states", active), ("enumeration", enumeration), ("lemke", lemke), ("sweeps", sweeps), ("in turn", all)]
}

pub fn problems<const T: usize>(folder: &str) -> Option<Vec<OfOthers<T>>> {
    let folder = data_of_others(folder)?;
    let Ok(files) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: problems of Siconos: there is no folder {}", folder.display());
        return None;
    };
    let mut paths: Vec<_> = files.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let problems: Vec<_> = paths.iter().filter_map(|path| read(path)).collect();
    assert!(!problems.is_empty(), "no problem in the folder");
    Some(problems)
}

#[test]
fn the_planar_problems_of_others_must_be_solved_by_one_of_the_methods() {
    let Some(problems) = problems::<1>("siconos-planar") else { return };
    for planar in problems.iter().filter(|planar| planar.friction.len() <= MOST_CONTACTS) {
        let found = residuals(planar);
        assert!(found[4].1 <= 1e-9, "{}: {found:?}", planar.name);
    }
}

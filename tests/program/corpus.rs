//! The corpus of contact problems: the committed file, the harvest, the replay, and the two commands.

use crate::program::{assert_has, json, read, refused, rimbench, root};
use crate::support::{case_by_name, cases, data_of_others, solver_by_name, solvers};
use assert_cmd::Command;
use rimbench::complementarity::{ComplementaritySolver, Lcp, SolveStats, Solver, Unsolved};
use rimbench::corpus::{
    ContactProblem, Corpus, FRICTION_VARIATIONS, FrictionMethod, FrictionalCorpus, FrictionalProblem, Harvest, Solve,
    Start, Stretch, Uniqueness, VARIATIONS, harvest, harvest_with_friction, replay, replay_with_friction,
};
use rimbench::solver_entry::SolverEntry;
use serde_json::Value;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const FILE: &str = "data/contact-problems/corpus.lcp";

fn committed() -> Corpus {
    Corpus::read(&root().join(FILE)).unwrap()
}

/// In the tree, whose corpus it finds.
fn in_tree() -> Command {
    let mut command = rimbench();
    command.current_dir(root());
    command
}

fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("corpus");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

#[test]
fn the_committed_corpus_holds_hundreds_of_different_problems_in_little_space() {
    let corpus = committed();
    assert!(corpus.len() >= 500, "{}", corpus.len());
    assert!(corpus.problems().all(|problem| !problem.b.is_empty()), "a problem without contact needs no solver");
    let bytes = corpus.to_bytes().unwrap();
    assert!(bytes.len() < 2 << 20, "{} bytes", bytes.len());
    let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let different: HashSet<_> = corpus.problems().map(|problem| (bits(&problem.h), bits(&problem.b))).collect();
    assert!(different.len() >= 500, "{} different ones", different.len());
    let sources: HashSet<&str> = corpus.stretches.iter().map(|stretch| stretch.source.as_str()).collect();
    assert!(sources.len() >= 20, "{sources:?}");
}

/// Every problem has been solved in a run; active set and Lemke must solve it again, bare, and the warm start must pay.
#[test]
fn the_pivoting_solvers_solve_the_whole_corpus() {
    let corpus = committed();
    let pivots = |name: &str, start: Start| {
        let replay = replay(&corpus, solver_by_name(name), start);
        assert_eq!(replay.solves.len(), corpus.len());
        let failures = replay.solves.iter().filter(|solve| !solve.solved).count();
        assert_eq!(failures, 0, "{name} {start:?}");
        replay.solves.iter().map(|solve| u64::from(solve.stats.pivots)).sum::<u64>()
    };
    let (warm, cold) = (pivots("active-set", Start::Warm), pivots("active-set", Start::Cold));
    assert!(3 * warm < cold, "{warm} pivots warm, {cold} cold");
    // It keeps no warm start.
    pivots("lemke", Start::Cold);
}

/// An interior point is good to the root of its gap where a contact is degenerate; it is asked for as small a gap as that takes.
#[test]
fn the_interior_point_solves_the_whole_corpus() {
    let corpus = committed();
    let entry = solver_by_name("clarabel");
    let mut solver = (entry.build)(corpus.largest());
    let mut z = vec![0.0; corpus.largest()];
    let mut solved = |problem: &ContactProblem| match solver.solve(problem.lcp(), &mut z[..problem.b.len()]) {
        Ok(stats) => stats.residual <= entry.tolerance,
        Err(_) => false,
    };
    assert_eq!(corpus.problems().filter(|problem| !solved(problem)).count(), 0);
}

#[test]
fn redundant_contacts_are_in_the_corpus() {
    let redundant = |m: &[f64], n: usize| {
        let singular = nalgebra::DMatrix::from_row_slice(n, n, m).singular_values();
        singular.min() < 1e-12 * singular.max()
    };
    let corpus = committed();
    let count = corpus.problems().filter(|problem| redundant(&problem.h, problem.b.len())).count();
    assert!(4 * count > corpus.len(), "{count} of {}", corpus.len());
}

#[test]
fn two_harvests_give_the_same_file() {
    let plan = Harvest { cases: vec![case_by_name("wedge-box").clone()], bytes_per_solver: 1000 };
    let mut runs = 0;
    let first = harvest(&plan, &mut |_| runs += 1).unwrap().to_bytes().unwrap();
    assert!(runs >= 8, "{runs} runs");
    assert_eq!(first, harvest(&plan, &mut |_| {}).unwrap().to_bytes().unwrap());
}

#[test]
fn every_variation_is_one_its_case_allows() {
    for variation in VARIATIONS.iter().chain(FRICTION_VARIATIONS) {
        let case = cases().iter().find(|case| case.name == variation.case).expect("a case of the list");
        let mut parameters = case.default_parameters();
        for (key, value) in variation.settings {
            parameters.set(key, value).unwrap();
        }
        assert_ne!(parameters, case.default_parameters(), "{variation:?} changes nothing");
    }
}

/// A case whose contacts have friction is one for the other harvest; that of the cases without must not stumble over it, and a case
/// without contacts is in neither.
#[test]
fn each_case_is_harvested_in_the_corpus_that_its_contacts_belong_to() {
    let cases = ["towed-block", "bouncing-ball", "quarter-car"].map(|name| case_by_name(name).clone()).to_vec();
    let plan = Harvest { cases, bytes_per_solver: 500 };
    let only = |mut sources: Vec<&str>, case: &str| {
        sources.retain(|source| !source.starts_with(case));
        assert!(sources.is_empty(), "{sources:?}");
    };
    let without = harvest(&plan, &mut |_| {}).unwrap();
    assert!(!without.is_empty());
    only(without.stretches.iter().map(|stretch| &*stretch.source).collect(), "bouncing-ball ");
    let with = harvest_with_friction(&plan, &mut |_| {}).unwrap();
    assert!(!with.is_empty());
    only(with.stretches.iter().map(|stretch| &*stretch.source).collect(), "towed-block ");
    assert_eq!(with.to_bytes(), harvest_with_friction(&plan, &mut |_| {}).unwrap().to_bytes(), "not the same twice");
}

const FRICTION_FILE: &str = "data/contact-problems/friction.lcp";

fn committed_with_friction() -> FrictionalCorpus {
    Corpus::read(&root().join(FRICTION_FILE)).unwrap()
}

#[test]
fn the_committed_corpus_with_friction_holds_problems_of_cases_that_have_it() {
    let corpus = committed_with_friction();
    assert!(corpus.len() >= 2000, "{}", corpus.len());
    let mut harvested = 0;
    for case in cases().iter().filter(|case| !corpus.of_source(&format!("{} ", case.name)).is_empty()) {
        assert!(case.default_parameters().setting("friction") > Some(0.0), "{}", case.name);
        harvested += 1;
    }
    assert!(harvested >= 6, "only {harvested} cases with friction are in it");
}

/// Every problem has been solved in a run. Alone the active set of states gives up on some; with the others behind it nothing is left.
#[test]
fn the_methods_for_friction_solve_the_whole_corpus_in_turn_and_lemke_does_alone() {
    let corpus = committed_with_friction();
    let outcome = |method: FrictionMethod, start: Start| {
        let replay = replay_with_friction(&corpus, method, start);
        assert_eq!((replay.solves.len(), &replay.panic), (corpus.len(), &None));
        let failed = |solve: &&Solve| !solve.solved && !solve.refused;
        let changes: u64 = replay.solves.iter().map(|solve| u64::from(solve.stats.pivots)).sum();
        (replay.solves.iter().filter(failed).count(), changes)
    };
    for start in [Start::Warm, Start::Cold] {
        for method in [FrictionMethod::InTurn, FrictionMethod::Lemke, FrictionMethod::Enumeration] {
            assert_eq!(outcome(method, start).0, 0, "{method} {start:?}");
        }
    }
    let [warm, cold] = [Start::Warm, Start::Cold].map(|start| outcome(FrictionMethod::ActiveStates, start));
    assert!(warm.0 < cold.0 && 5 * warm.1 < cold.1, "{warm:?} warm, {cold:?} cold");
    assert!(50 * cold.0 < corpus.len(), "{cold:?}");
}

fn alone(problem: FrictionalProblem) -> FrictionalCorpus {
    Corpus { stretches: vec![Stretch { source: "made up".to_owned(), first: 0, problems: vec![problem] }] }
}

/// The rod of Painlevé at tan θ = 2 has one solution below μ = 4/3 and three above; impulses of redundant contacts are not unique at any.
#[test]
fn problems_with_several_solutions_are_counted() {
    let (cos, sin) = (0.2_f64.sqrt(), 0.8_f64.sqrt());
    // Mass and half length 1, inertia 1/3.
    let of_rod = [1.0 + 3.0 * cos * cos, -3.0 * sin * cos, -3.0 * sin * cos, 1.0 + 3.0 * sin * sin];
    let found = |mu: f64| {
        let b = vec![1e-3, -1.0];
        Uniqueness::of(&alone(FrictionalProblem { h: of_rod.into(), b, friction: vec![mu] }))
    };
    let (below, above) = (found(1.3), found(1.4));
    assert_eq!((below.listed, below.several, below.beyond_painleve), (1, 0, 0), "{below:?}");
    assert_eq!((above.listed, above.several, above.beyond_painleve), (1, 1, 1), "{above:?}");
    // Twice the same contact.
    let same = |row: usize, column: usize| f64::from(u8::from(row / 2 == column / 2));
    let h: Vec<f64> = (0..16).map(|at| same(at / 4, at % 4)).collect();
    let b = vec![-1.0, -1.0, 0.1, 0.1];
    let redundant = Uniqueness::of(&alone(FrictionalProblem { h: h.into(), b, friction: vec![0.3; 2] }));
    assert_eq!((redundant.several, redundant.several_impulses, redundant.none), (0, 1, 0), "{redundant:?}");
}

fn compared(arguments: &[&str], folder: &Path) -> (Value, String) {
    let run = || (json(in_tree().args(arguments).arg("--out").arg(folder)), read(folder.join("work.csv")));
    let ((facts, work), (_, again)) = (run(), run());
    assert_eq!(work, again, "work depends on the problems alone");
    (facts, work)
}

#[test]
fn the_comparison_with_friction_is_written_with_what_has_several_solutions() {
    let folder = scratch("friction");
    let arguments = ["solvers", "--friction", "--source", "woodpecker", "--format", "json"];
    let (facts, work) = compared(&arguments, &folder);
    assert!(work.lines().next().unwrap().ends_with("worst_accepted_residual,fallbacks"), "{work}");
    let overall = facts["overall"].as_array().unwrap();
    assert_eq!(overall.len(), 2 * FrictionMethod::NAMES.len());
    assert!(overall.iter().all(|row| row["fallbacks"].is_number()));
    let solutions = &facts["solutions"][0];
    assert_eq!(solutions["problems"], solutions["listed"], "the toy has three contacts");
    let written = read(folder.join("solutions.csv"));
    assert!(written.starts_with("problems,listed,several_velocities"), "{written}");
    let figure = read(folder.join("profile.svg"));
    assert!(FrictionMethod::NAMES.iter().all(|(name, _)| figure.contains(name)));
}

#[test]
fn the_comparison_is_written_with_work_apart_from_time() {
    let folder = scratch("out");
    let source = "wedge-box rim-nonsmooth-gap";
    let arguments = ["solvers", "--source", source, "--solver", "active-set", "--solver", "lemke", "--format", "json"];
    let (facts, work) = compared(&arguments, &folder);
    assert!(work.starts_with("solver,start,n_from,n_to,problems,refused,failures,pivots"), "{work}");
    assert!(read(folder.join("time.csv")).contains("median_ns"));
    let figure = read(folder.join("profile.svg"));
    assert!(["active-set", "lemke"].iter().all(|name| figure.contains(name)) && !figure.contains("clarabel"));
    assert!(std::fs::read(folder.join("profile.png")).unwrap().starts_with(b"\x89PNG"));
    let overall = facts["overall"].as_array().unwrap();
    assert_eq!(overall.len(), 4, "two solvers, warm and cold");
    assert!(overall.iter().all(|row| row["failures"] == 0 && row["median_ns"].is_number()));
    let profile = facts["profile"].as_array().unwrap();
    let last = profile.last().unwrap();
    assert!(last["factor"].is_null() && last["not_finite"]["factor"] == "inf", "{last}");
    assert_eq!(profile.last().unwrap()["lemke"], 1.0);
}

/// One problem: two contacts, of which the first cannot be moved by any impulse.
fn with_zero_diagonal() -> Corpus {
    let problem = ContactProblem { h: vec![0.0, 0.0, 0.0, 2.0].into(), b: vec![0.5, -1.0], friction: Vec::new() };
    Corpus { stretches: vec![Stretch { source: "made up".to_owned(), first: 0, problems: vec![problem] }] }
}

#[test]
fn a_zero_on_the_diagonal_ends_no_solver_of_the_panel() {
    let corpus = with_zero_diagonal();
    for solver in solvers() {
        let replay = replay(&corpus, solver, Start::Warm);
        assert_eq!(replay.panic, None, "{}", solver.name);
    }
    for name in ["active-set", "lemke", "enumeration"] {
        assert!(replay(&corpus, solver_by_name(name), Start::Cold).solves[0].solved, "{name}");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zero.lcp");
    corpus.write(&file).unwrap();
    let facts = json(in_tree().args(["solvers", "--format", "json", "--corpus"]).arg(&file));
    assert_eq!(facts["overall"].as_array().unwrap().len(), 2 * solvers().len());
}

#[derive(Debug, Clone)]
struct Panicking;

impl ComplementaritySolver for Panicking {
    fn attempt(&mut self, _: Lcp<'_>, _: &mut [f64]) -> Result<SolveStats, Unsolved> {
        panic!("index out of bounds")
    }
}

#[test]
fn a_solver_that_panics_fails_at_all_problems_and_says_so() {
    let corpus = with_zero_diagonal();
    let build = Arc::new(|_: usize| Solver::other(Panicking));
    let entry = Arc::new(SolverEntry { name: "panicking".into(), build, ..SolverEntry::active_set() });
    let replay = replay(&corpus, &entry, Start::Warm);
    assert_eq!(replay.panic.as_deref(), Some("index out of bounds"));
    assert_eq!(replay.solves.len(), corpus.len());
    assert!(replay.solves.iter().all(|solve| !solve.solved && !solve.refused) && replay.costs() == [f64::INFINITY]);
}

#[test]
fn what_cannot_be_read_or_written_is_said_in_one_error() {
    let text = scratch("text.lcp");
    std::fs::write(&text, "case,H\n").unwrap();
    let mut bytes = std::fs::read(root().join(FILE)).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    let damaged = scratch("damaged.lcp");
    std::fs::write(&damaged, bytes).unwrap();
    let path = |path: &Path| path.to_str().unwrap().to_owned();
    let (folder, below) = (path(text.parent().unwrap()), path(&text.join("below-a-file.lcp")));
    for (options, expected) in [
        (["--corpus", &path(&text)], "is not a corpus of contact problems"),
        (["--corpus", &path(&damaged)], "its checksum does not fit"),
        (["--corpus", &path(&scratch("missing.lcp"))], "missing.lcp"),
        (["--solver", "lemk"], "did you mean `lemke`?"),
        (["--friction", "--solver=lemk"], "did you mean `lemke`?"),
        (["--friction", "--source=wedge-bx"], "--source = wedge-bx is not valid"),
        (["--friction", &format!("--corpus={}", path(&text))], "is not a corpus of contact problems with"),
        (["--friction", &format!("--corpus={FILE}")], "is not a corpus of contact problems with"),
        (["--harvest", &format!("--out={folder}")], "is a folder; the name of a file"),
        (["--source", "wedge-bx"], "--source = wedge-bx is not valid"),
        (["--harvest", &format!("--out={below}")], "cannot be written: there is no folder"),
    ] {
        let message = refused(in_tree().arg("solvers").args(options));
        assert_has(&message, &[expected]);
        assert!(message.lines().count() <= 2, "{message}");
    }
}

/// What the docs say of each solver on frictional problems of others, of which the normal rows were taken (Siconos).
#[test]
fn the_pivoting_solvers_solve_the_problems_of_others() {
    let Some(folder) = data_of_others("siconos") else { return };
    for (file, count) in [("frictional_normal_rows_small.lcp", 42), ("frictional_normal_rows_large.lcp", 2)] {
        let corpus = Corpus::<false>::read(&folder.join(file)).unwrap();
        assert_eq!(corpus.len(), count);
        for name in ["active-set", "lemke"] {
            let entry = solver_by_name(name);
            let mut solver = (entry.build)(corpus.largest());
            for stretch in &corpus.stretches {
                for problem in &stretch.problems {
                    let mut z = vec![0.0; problem.b.len()];
                    solver.reset();
                    let solved = solver.solve(problem.lcp(), &mut z);
                    let solved = solved.is_ok_and(|stats| stats.residual <= entry.tolerance);
                    assert!(solved, "{name}, n = {}, {}", z.len(), stretch.source);
                }
            }
        }
    }
}

//! Results that may not change silently: a digit that moves forces the numerics version up.

use crate::support::{Changed, run, schemes, usual_spec};
use rimbench::numerics_version::NUMERICS_VERSION;
use std::path::Path;

/// The version that `GOLDEN` belongs to.
const GOLDEN_VERSION: u32 = 16;

/// Scheme with a page, then actuator length (m) and force (N) at the end of a run at H = 1 ms with phase 0.3.
///
/// Most schemes run 0.15 s, into the first force peak; those named `rim` 1.72 s, through the touch-down. One that
/// splits an interface runs on the gripper.
const GOLDEN: &[(&str, f64, f64)] = &[
    ("zero-order-hold", 2.516314097965119, 715.5199218039622),
    ("first-order-hold", 2.516253106151541, 696.4934111482635),
    ("second-order-hold", 2.5162524693082906, 686.2554318265807),
    ("c1-extrapolated-interpolation", 2.516254036752268, 706.7443765093092),
    ("true-acceleration", 2.5162496751501697, 697.508932326469),
    ("nepce", 2.516252939409688, 686.9323406909964),
    ("integral-correction-first-order", 2.5162523006958195, 684.9072776202909),
    ("energy-leak-damper", 2.5163085879763742, 691.1884364205303),
    ("transmission-line", 2.5162196712904374, 722.454875694985),
    ("hydraulic-line", 2.5161949121156217, 649.1085664157247),
    ("interface-jacobian", 2.5162487499625645, 697.6939517925528),
    ("interface-exponential", 2.5162497137107804, 695.3722096491413),
    ("model-corrected-outputs", 2.51625114896993, 688.9719214809643),
    ("interface-mass", 2.51624907226924, 685.6427284688189),
    ("rim-fixed-mass", 2.9483457956485357, -101.85542027569181),
    ("rim-smooth", 2.9479246818531117, -104.83485276439933),
    ("rim-smooth-active", 2.9479246818531117, -104.83485276439933),
    ("rim-nonsmooth", 2.9479251973238623, -104.48335365429102),
    ("rim-nonsmooth-gap", 2.947914880750162, -105.57837701250082),
    ("rim-split", 0.634993901208292, 2884.615380124392),
    ("rim-answers", 2.9479183905793076, -102.75506541483082),
    ("iterated-aitken", 2.5162524012692193, 685.5580571345263),
    ("monolithic", 2.516186000453088, 686.9672945881946),
];

/// Results agree to ten digits on any processor; a change of method moves far more.
const SAME: f64 = 1e-10;

fn end_of_run(name: &str) -> (f64, f64) {
    let duration = match name {
        "rim-split" => 1.0,
        _ if name.starts_with("rim") => 1.72,
        _ => 0.15,
    };
    let case = if name == "rim-split" { "gripper" } else { "wedge-box" };
    let spec = usual_spec(case, name, 1e-3).changed(|own| (own.phase, own.duration) = (0.3, duration));
    let (run, row) = (run(&spec).trajectory, &spec.case.interface_columns[0]);
    let last = |name| run.row(run.len() - 1)[run.index_of(name).unwrap()];
    (last(&row.position), last(&row.force))
}

#[test]
fn a_changed_digit_raises_the_numerics_version() {
    assert_eq!(NUMERICS_VERSION, GOLDEN_VERSION, "new numerics version: update GOLDEN and GOLDEN_VERSION");
    let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/schemes");
    let found: Vec<(&str, f64, f64)> = schemes()
        .iter()
        .filter(|scheme| pages.join(format!("{}.md", scheme.name)).is_file())
        .map(|scheme| {
            let (length, force) = end_of_run(&scheme.name);
            (&*scheme.name, length, force)
        })
        .collect();
    let differences = differences(GOLDEN, &found);
    assert!(
        differences.is_empty(),
        "results have changed: raise NUMERICS_VERSION unless only a scheme is new, say why in the commit, and change \
         these rows of GOLDEN\n{differences}"
    );
}

/// The rows that are new, changed or gone, and no others.
fn differences(golden: &[(&str, f64, f64)], found: &[(&str, f64, f64)]) -> String {
    let close = |a: f64, b: f64| (a - b).abs() <= SAME * b.abs();
    let same = |a: &(&str, f64, f64), b: &(&str, f64, f64)| a.0 == b.0 && close(a.1, b.1) && close(a.2, b.2);
    let other = found.iter().filter(|found| !golden.iter().any(|golden| same(found, golden)));
    let gone = golden.iter().filter(|golden| !found.iter().any(|found| found.0 == golden.0));
    let other = other.map(|(name, length, force)| format!("    (\"{name}\", {length:?}, {force:?}),\n"));
    other.chain(gone.map(|golden| format!("    no more: \"{}\"\n", golden.0))).collect()
}

#[test]
fn only_the_rows_that_differ_are_shown() {
    let golden = [("a", 1.0, 2.0), ("b", 3.0, 4.0), ("c", 5.0, 6.0)];
    let found = [("a", 1.0, 2.0), ("b", 3.0, 4.5), ("new", 7.0, 8.0)];
    assert_eq!(differences(&golden, &golden), "");
    let shown = differences(&golden, &found);
    assert_eq!(shown, "    (\"b\", 3.0, 4.5),\n    (\"new\", 7.0, 8.0),\n    no more: \"c\"\n");
}

//! Results that may not change silently: a digit that moves forces the numerics version up.

use crate::support::{Changed, RunSpec, cases, run, schemes, spec_with, usual_spec};
use rimbench::numerics_version::NUMERICS_VERSION;
use std::path::Path;

/// The version that both tables belong to.
const GOLDEN_VERSION: u32 = 17;

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

/// Case, then actuator position (m) at the end of a run as the case has it and root mean square of the force (N) over its communication
/// points, with the non-smooth model, and with a hold where there are no displacements to have one of.
const GOLDEN_OF_CASES: &[(&str, f64, f64)] = &[
    ("wedge-box", 3.164252432913168, 187.1449355036659),
    ("hydraulic-crane", 0.5153512375525982, 7904.277071084052),
    ("linear-oscillator", -0.9713612775844582, 624.7420248788125),
    ("quarter-car", 0.09998455108507225, 557.7425369294609),
    ("precice-oscillator", -0.40403659909540796, 138.865949939727),
    ("crane-set-down", 0.5157302540894266, 8657.019789691001),
    ("half-car", 0.584810978926797, 2954.671923970468),
    ("gripper", 0.6124576483204197, 1620.6257722389291),
    ("lift-table", 0.8117491172495808, 13260.289686315557),
    ("excavator-arm", 0.9648193678503463, 8910.68680676693),
    ("disc-row", 1.5700000000000005, 5191.877041601703),
    ("disc-pile", 1.5200000000000002, 6166.098288355173),
    ("packed-box", 1.5100818554870052, 1551.0858837385936),
    ("random-body", -0.0006386987559371532, 49.60611268196728),
    ("bouncing-ball", 0.15629256115125947, 1.1366662544758794),
    ("elastic-bar", 1.0000278935224347, 33.61133598065662),
    ("impact-oscillator", -0.12536788922199713, 11.72178176142686),
    ("cradle", -0.037930445276744995, 0.09995559427893785),
    ("slider-between-stops", -0.08093321733224856, 37.12887806323459),
    ("mass-between-stops", 0.8535772591559619, 2567.508277970193),
    ("hardware-contact", -0.04628905333865902, 85.74589166483636),
    ("rocking-block", 1.9346997062289595, 276.3737436720616),
    ("beam-on-stops", 0.007539786579672578, 46.50673285501083),
    ("n-wedge-box", 3.164252433864502, 187.1449217447164),
    ("wedge-box-two-ledges", 3.2910411104920354, 306.0571031581739),
    ("wedge-box-reversal", 2.6799963097756283, 230.10324153236385),
    ("wedge-box-friction", 2.564601121912935, 678.2224013568585),
    ("towed-block", 0.3534199328123729, 3.981715297253977),
    ("rocking-block-friction", 1.7748660646682124, 10.98991384993581),
    ("crane-drag", 0.5268086311213727, 7880.882219218277),
    ("slider-crank", 2.285944207793664, 164.13833831160233),
    ("woodpecker", -0.003907074099691911, 0.13310605515639087),
    ("tripod", 1.7150107908091912, 718.9105075913154),
    ("four-legs", 1.7149904503416429, 727.9680909393588),
    ("wedge-box-space", 3.158344335558131, 477.9139241653491),
];

/// Results agree to ten digits on any processor; a change of method moves far more. A macro step that is
/// longer by 1e-13 of it moves the end of no case by more than 2e-10 of that.
const SAME: f64 = 1e-10;

fn end_of_run(name: &str) -> (f64, f64) {
    let duration = match name {
        "rim-split" => 1.0,
        _ if name.starts_with("rim") => 1.72,
        _ => 0.15,
    };
    let case = if name == "rim-split" { "gripper" } else { "wedge-box" };
    let spec = usual_spec(case, name, 1e-3).changed(|own| (own.phase, own.duration) = (0.3, duration));
    let [position, force] = interface_of(&spec);
    (*position.last().unwrap(), *force.last().unwrap())
}

fn run_of_case(name: &str) -> (f64, f64) {
    let scheme = if name == "precice-oscillator" { "zero-order-hold" } else { "rim-nonsmooth" };
    let [position, force] = interface_of(&spec_with(name, scheme, &[], &[]).changed(|own| own.phase = 0.3));
    (*position.last().unwrap(), (force.iter().map(|force| force * force).sum::<f64>() / force.len() as f64).sqrt())
}

/// Positions and forces of the first interface row.
fn interface_of(spec: &RunSpec) -> [Vec<f64>; 2] {
    let (run, row) = (run(spec).trajectory, &spec.case.interface_columns[0]);
    [&row.position, &row.force].map(|name| {
        let column = run.index_of(name).unwrap();
        (0..run.len()).map(|at| run.row(at)[column]).collect()
    })
}

#[test]
fn a_changed_digit_raises_the_numerics_version() {
    assert_eq!(NUMERICS_VERSION, GOLDEN_VERSION, "new numerics version: update both tables and GOLDEN_VERSION");
    let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/schemes");
    let row = |name: &'static str, (position, force): (f64, f64)| (name, position, force);
    let schemes = schemes().iter().filter(|scheme| pages.join(format!("{}.md", scheme.name)).is_file());
    let schemes: Vec<_> = schemes.map(|scheme| row(&scheme.name, end_of_run(&scheme.name))).collect();
    let cases: Vec<_> = cases().iter().map(|case| row(&case.name, run_of_case(&case.name))).collect();
    let differences = [differences(GOLDEN, &schemes), differences(GOLDEN_OF_CASES, &cases)].concat();
    assert!(
        differences.is_empty(),
        "results have changed: raise NUMERICS_VERSION unless only a scheme or a case is new, say why in the commit, and change \
         these rows of GOLDEN and GOLDEN_OF_CASES\n{differences}"
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

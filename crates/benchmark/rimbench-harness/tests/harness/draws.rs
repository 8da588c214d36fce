//! Settings drawn at random.

use rimbench_core::cosim::StopFlag;
use rimbench_core::error::Result;
use rimbench_harness::{Experiment, PlannedRun};
use rimbench_runs::Reference;
use rimbench_runs::catalogue::Catalogue;
use std::path::Path;

fn parsed(case: &str) -> Result<Experiment> {
    let text = format!(
        "question = \"?\"\nmacro_steps_s = [5e-3]\nphases = 2\n[[cases]]\nname = \"wedge-box\"\n{case}\n\
         [[schemes]]\nscheme = \"nepce\"\n"
    );
    Experiment::parse(Path::new("usual.toml"), text)
}

fn sets(case: &str) -> Vec<(String, Option<String>)> {
    let plan = parsed(case).unwrap().plan(&Catalogue::standard(), false).unwrap();
    plan.iter().map(|run| (run.spec.parameters.given(), run.pooled_set.as_deref().map(str::to_owned))).collect()
}

#[test]
fn each_point_of_the_grid_has_the_same_settings_in_their_ranges() {
    let case = "set = { restitution = [0.0, 0.3] }\n[cases.draw]\nsettings = 8\nseed = 5\ndeclared = [\"ramp_slope\"]\n\
                [cases.draw.ranges]\nviscous_friction_n_s_m = [100, 3e4]\n";
    let found = sets(case);
    assert_eq!(found.len(), 2 * 8 * 2);
    let number = |set: &str, name: &str| -> f64 {
        set.split(' ').find_map(|word| word.strip_prefix(name)?.strip_prefix('=')).unwrap().parse().unwrap()
    };
    let drawn = |set: &str| ["ramp_slope", "viscous_friction_n_s_m"].map(|name| number(set, name));
    let of = |restitution: &str| {
        let own = found.iter().filter(|(_, pooled)| pooled.as_deref() == Some(restitution));
        own.map(|(set, _)| drawn(set)).collect::<Vec<_>>()
    };
    let settings = of("restitution=0.0");
    assert_eq!(settings, of("restitution=0.3"));
    assert!(settings.iter().all(|[slope, friction]| (0.08..=0.3).contains(slope) && (100.0..=3e4).contains(friction)));
    // In logarithms: half of them below the geometric mean.
    let mean = (100.0 * 3e4_f64).sqrt();
    assert_eq!(settings.iter().filter(|[_, friction]| *friction < mean).count(), settings.len() / 2);
    assert!(settings.iter().flatten().all(|value| format!("{value:.2e}").parse() == Ok(*value)));
    assert_eq!(sets("set = { restitution = 0.3 }")[0].1, None);
    // What is counted is whole.
    let text = "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"disc-row\"\n[cases.draw]\nsettings = 6\nseed = 1\n\
                ranges = { discs = [2, 200] }\n[[schemes]]\nscheme = \"nepce\"\n";
    let plan = Experiment::parse(Path::new("usual.toml"), text.to_owned()).unwrap().plan(&Catalogue::standard(), false);
    let discs = |run: &PlannedRun| run.spec.parameters.setting::<u32>("discs");
    assert!(plan.unwrap().iter().all(|run| discs(run).is_some_and(|count| (2..=200).contains(&count))));
}

/// Boxes that a small valve moves too little for the left wedge to land.
#[test]
fn a_setting_without_the_event_is_drawn_again_and_counted() {
    let plan = |requires: &str| {
        let case = format!(
            "duration_s = 2.5\nset = {{ restitution = [0.0, 0.3] }}\n[cases.draw]\nsettings = 2\nseed = 201\n{requires}\n\
             [cases.draw.ranges]\nvalve_area_m2 = [1e-6, 1e-4]\nspool_final = [0.2, 0.4]\n"
        );
        let (experiment, catalogue) = (parsed(&case).unwrap(), Catalogue::standard());
        let plan = experiment.plan(&catalogue, false).unwrap();
        let first = experiment.plan_at_first_draw(&catalogue, false).unwrap();
        (plan, first.iter().map(|run| run.id.clone()).collect::<Vec<String>>())
    };
    let sets = |plan: &[PlannedRun]| -> Vec<String> { plan.iter().map(|run| run.spec.parameters.given()).collect() };
    let ((any, first_of_any), (landing, first)) = (plan(""), plan("requires = \"closing\""));
    // Without a search it is the draw of the seed.
    assert_eq!(first, first_of_any);
    assert_eq!(first, any.iter().map(|run| run.id.clone()).collect::<Vec<String>>());
    assert_eq!((any.len(), landing.len()), (2 * 2 * 2, 2 * 2 * 2));
    assert_ne!(sets(&any), sets(&landing));
    assert!(any.iter().all(|run| run.rejected_draws.is_none()));
    let rejected: Vec<usize> = landing.iter().map(|run| run.rejected_draws.unwrap()).collect();
    assert_eq!(rejected[..4], rejected[4..]);
    assert!(rejected.iter().sum::<usize>() > 0, "{rejected:?}");
    for run in landing.iter().step_by(2) {
        let solution = Reference::solution(&run.spec.of_the_reference(), 1, StopFlag::never()).unwrap().rows;
        let gap = solution.index_of("gap_left_wedge_m").unwrap();
        let least = solution.column(gap).fold(f64::INFINITY, f64::min);
        assert!(least < 1e-6, "{least} m with {}", run.spec.parameters.given());
    }
}

#[test]
fn what_cannot_be_drawn_is_one_sentence_with_what_is_valid() {
    let refused = |draw: &str| {
        let case = format!("duration_s = 0.2\nset = {{ restitution = 0.3 }}\n[cases.draw]\n{draw}\n");
        let planned = parsed(&case).and_then(|experiment| experiment.plan(&Catalogue::standard(), false));
        planned.unwrap_err().to_string()
    };
    let of_case = "usual.toml: [[cases]] in line 4 (`wedge-box`): ";
    for (draw, wanted) in [
        (
            "settings = 2\nseed = 1\nranges = { box_mass_kg = [-1.0, 5.0] }",
            "box_mass_kg = -1.0 is not valid; valid: a finite number above 0",
        ),
        (
            "settings = 2\nseed = 1\nranges = { box_mass_kg = [5.0, 2.0] }",
            "box_mass_kg = [5.0, 2.0] is not valid; valid: a range from less to more",
        ),
        ("settings = 2\nseed = 1\nranges = { box_mass_kg = [nan, 2.0] }", "box_mass_kg = NaN is not valid"),
        (
            "settings = 2\nseed = 1\nranges = { box_mas_kg = [1.0, 2.0] }",
            "unknown parameter in draw `box_mas_kg` (did you mean `box_mass_kg`?)",
        ),
        ("settings = 2\nseed = 1\nranges = { restitution = [0.1, 0.2] }", "restitution = 0.3 is set, and drawn"),
        (
            "settings = 2\nseed = 1\ndeclared = [\"gravity_m_s2\"]",
            "draw: case `wedge-box` declares no sensible range of `gravity_m_s2`",
        ),
        ("settings = 2\nseed = 1\ndeclared = [\"ramp_slope\", \"ramp_slope\"]", "draw: `ramp_slope` is named twice"),
        ("settings = 2\nseed = 1", "draw: names no parameter"),
        (
            "settings = 1\nseed = 1\nrequires = \"sticking\"\nranges = { box_mass_kg = [100.0, 200.0] }",
            "draw: requires = \"sticking\", and no contact of case `wedge-box` can do that with these parameters",
        ),
        (
            "settings = 1\nseed = 1\nrequires = \"closing\"\nranges = { valve_area_m2 = [1e-8, 2e-8] }",
            "draw: requires = \"closing\", which happens in 0 of 64 settings drawn, and 1 are wanted: give ranges",
        ),
    ] {
        let message = refused(draw);
        assert!(message.starts_with(&format!("{of_case}{wanted}")), "{message}");
    }
    for (draw, wanted) in [
        (
            "settings = 2\nseed = \"noon\"",
            "usual.toml: is no experiment: line 10, column 8: `seed = \"noon\"`: expected a whole number, 0 or above",
        ),
        ("settings = 2\nseed = -1", "column 8: `seed = -1`: expected a whole number, 0 or above"),
        ("settings = 0.5\nseed = 1", "column 12: `settings = 0.5`: expected a whole number, 0 or above"),
        ("settings = 2", "missing field `seed`"),
        ("settings = 2\nseed = 1\nrequires = \"landing\"", "requires takes one of closing | opening | sticking"),
        ("settings = 2\nseed = 1\nrequires = 1", "requires takes one of closing | opening | sticking"),
        (
            "settings = 0\nseed = 1\nranges = { box_mass_kg = [1.0, 5.0] }",
            "(`wedge-box`): the grid is empty here; valid: at least one value",
        ),
        (
            "settings = 9000000\nseed = 1\nranges = { box_mass_kg = [1.0, 5.0] }",
            "the grid has 18000000 runs, more than the 1000000",
        ),
    ] {
        let message = refused(draw);
        assert!(message.contains(wanted) && message.lines().count() == 1, "{message}");
    }
}

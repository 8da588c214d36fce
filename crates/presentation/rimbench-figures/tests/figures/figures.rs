//! Every kind of figure is written, complete and reproducible. The data are synthetic; no run is needed.
//!
//! Set `RIMBENCH_FIGURES_DIR` to an existing folder to keep the figures and look at them.

use crate::{assert_has, root};
use rimbench_figures::chart::{Axis, Figure, Guide, Mode, Plot, Series};
use rimbench_figures::drawing::{Datum, Drawing, PanelData, SeriesData, Shape};
use rimbench_figures::line_style::LineStyle;
use rimbench_figures::render;
use rimbench_figures::style::Styles;
use rimbench_figures::{FigureList, MadeFigures, figure_keys};
use rimbench_results::checksums;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The style of a built-in scheme, or a variant of one.
fn style_of(label: &str) -> LineStyle {
    Styles::standard().of_label(label)
}

#[test]
fn every_kind_of_drawing_is_written_whole_and_twice_the_same() {
    let force = ["(a) actuator force", "rim-nonsmooth-gap", "effective mass (kg)", "∞", "infinite"];
    check(&force_and_mass().draw().unwrap(), "force-and-mass", &force);
    // At 5 ms all runs of one scheme are lost, and the other has none; at 1 ms errors are nine tenths of the peak.
    let place = MadeUp::new();
    place.edit("runs.csv", |k, row| match k {
        0 => Some(row.replace(",force_error_rms_n,", ",force_error_rms_of_peak,")),
        _ if !row.contains(",0.005,") => Some(row.replace(",completed,0.00", ",completed,0.9")),
        _ => row.contains("rim-smooth").then(|| row.replace("completed", "diverged")),
    });
    let wrong = "all complete, but the median error is above a tenth of the peak";
    place.check("map", &["macro step H (ms)", "–  not run", wrong, "all fail"]);
}

#[test]
fn an_empty_figure_is_an_empty_page() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str| render::write(&Figure::new(200.0, 100.0, None).draw().unwrap(), &place.path().join(name));
    write("empty.svg").expect("a writable folder");
    assert!(place.path().join("empty.svg").is_file());
    // A PDF is made in a build that can; what cannot be written is told and leaves nothing.
    match (write("empty.pdf"), cfg!(feature = "pdf")) {
        (Ok(()), true) => assert!(read(&place.path().join("empty.pdf")).starts_with(b"%PDF")),
        (Err(error), false) => assert_has(&error.to_string(), &["empty.pdf", "--features pdf"]),
        other => panic!("{other:?}"),
    }
    assert_has(&write("empty.gif").unwrap_err().to_string(), &["empty.gif", ".svg, .png or .pdf"]);
    assert_has(&write("missing/empty.svg").unwrap_err().to_string(), &["missing"]);
}

/// Results of a made-up experiment `study/made-up`: two schemes, two macro steps, two phases, two margins.
fn made_up_results(folder: &Path) {
    let folder = folder.join("study/made-up");
    std::fs::create_dir_all(&folder).unwrap();
    let mut runs = String::from(
        "run_id,case,set,label,macro_step_s,phase,outcome,force_error_rms_n,interface_residual_j,reference_force_uncertainty_n,\
         actuator_micro_steps,mechanics_micro_steps\n",
    );
    let mut cost = String::from("run_id,wall_s\n");
    let mut id = 0;
    for (label, scale, limit) in [("rim-smooth", 9.0, 2e-3), ("rim-nonsmooth-gap/profile", 1.0, 1.0)] {
        for set in ["", "margin_m=0.1"] {
            for step in [0.5e-3, 1e-3, 5e-3] {
                for phase in [1.0, 0.4] {
                    let outcome = if step > limit && phase < 0.9 { "diverged" } else { "completed" };
                    let (error, residual) = (scale * step * phase, if label.contains('/') { -step } else { step });
                    runs += &format!(
                        "{id:x},box,{set},{label},{step},{phase},{outcome},{error},{residual},1e-4,500,{}\n",
                        (1.0 / step) as u64
                    );
                    cost += &format!("{id:x},{}\n", 1e-2 / step);
                    id += 1;
                }
            }
        }
    }
    let parameters = "case,set,parameter,value\nbox,,margin_m,0.01\nbox,margin_m=0.1,margin_m,0.1\n";
    for (name, text) in [("runs.csv", runs.as_str()), ("cost.csv", cost.as_str()), ("parameters.csv", parameters)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    seal(&folder);
}

/// Says of made-up results that they are as they were written.
fn seal(folder: &Path) {
    checksums::write(folder, ["runs.csv", "cost.csv", "parameters.csv"].map(str::to_owned)).unwrap();
}

/// Made-up results in a folder of their own.
pub struct MadeUp(tempfile::TempDir);

impl MadeUp {
    pub fn new() -> Self {
        let place = tempfile::tempdir().expect("a temporary folder");
        made_up_results(place.path());
        MadeUp(place)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join("study/made-up").join(name)
    }

    /// Changes the lines of a table, each by its number and text, and seals them.
    fn edit(&self, table: &str, change: impl Fn(usize, &str) -> Option<String>) {
        let rows = std::fs::read_to_string(self.path(table)).unwrap();
        let changed = rows.lines().enumerate().filter_map(|(k, row)| change(k, row));
        std::fs::write(self.path(table), changed.map(|row| row + "\n").collect::<String>()).unwrap();
        seal(&self.path(""));
    }

    /// Draws the figures of a list.
    pub fn draw(&self, list: &str) -> MadeFigures {
        let figures = FigureList::parse(Path::new("my.toml"), list).unwrap();
        figures.make_all(self.0.path(), Some("study"), (&Styles::standard(), "svg")).unwrap()
    }

    /// Checks the picture of one of the made-up figures.
    fn check(&self, id: &str, labels: &[&str]) {
        let figures = FigureList::parse(Path::new("my.toml"), &only(&[id])).unwrap().figures;
        check(&figures[0].drawn(self.0.path(), &Styles::standard()).unwrap(), id, labels);
    }

    /// Why a figure was not drawn.
    fn reason(&self, list: &str, id: &str) -> String {
        self.draw(list).failed.into_iter().find(|(failed, _)| failed == id).expect("not drawn").1
    }

    /// The texts of a figure that was.
    fn texts(&self, id: &str) -> BTreeMap<String, usize> {
        texts_in(&self.path(&format!("figures/{id}.svg")))
    }
}

/// A list of those of the made-up figures that have these names.
pub fn only(ids: &[&str]) -> String {
    let named = |part: &&str| ids.iter().any(|id| part.contains(&format!("id = \"{id}\"")));
    MADE_UP_FIGURES.split("[[figure]]").filter(named).map(|part| format!("[[figure]]{part}")).collect()
}

/// A list with one figure of each kind that reads the made-up results, and some that cannot be drawn.
const MADE_UP_FIGURES: &str = r#"
[[figure]]
id = "map"
kind = "stability-map"
experiment = "study/made-up"
title = "made up"
[[figure.panels]]
only = { set = "all" }

[[figure]]
id = "sweep"
kind = "xy"
experiment = "study/made-up"
[[figure.panels]]
title = "created"
metric = "force_error_rms_n"
only = { set = "all" }
label = "error (N)"
range = [1e-6, 1e-1]
slope = [1.0, [2.0, 1e-3]]

[[figure]]
id = "work"
kind = "xy"
experiment = "study/made-up"
metric = "force_error_rms_n"
label = "error (N)"
range = [1e-4, 1.0]
[[figure.panels]]
title = "(a)"
only = { set = "all" }
x = { cost = "wall_s", label = "wall time (s)" }
[[figure.panels]]
title = "(b)"
only = { case = "box", set = "all" }
x = { cost = "actuator_micro_steps + mechanics_micro_steps", label = "steps" }

[[figure]]
id = "margin"
kind = "xy"
experiment = "study/made-up"
x = { parameter = "margin_m", label = "margin (m)" }
[[figure.panels]]
title = "(a)"
metric = "force_error_rms_n"
label = "error (N)"
range = [1e-4, 1.0]
macro_step_s = 5e-3
[[figure.panels]]
title = "(b)"
metric = "fraction_stable"
macro_step_s = 5e-3
label = "fraction stable"
labels = ["rim-smooth"]

[[figure]]
id = "other"
kind = "xy"
experiment = "paper/not-run"
[[figure.panels]]
metric = "force_error_rms_n"
"#;

#[test]
fn figures_are_drawn_from_stored_results_and_those_that_cannot_be_are_named() {
    let place = MadeUp::new();
    let made = place.draw(MADE_UP_FIGURES);
    assert_eq!((made.files.len(), made.missing.len()), (4, 0), "{:?}", made.failed);
    for (id, labels) in [
        ("map", &["made up", "smooth model", "some fail", "1", "5"] as &[&str]),
        ("sweep", &["created", "gap tracking, profile, order 1.00"]),
        ("sweep", &["failed", "some runs failed"]),
        ("work", &["smooth model: some runs failed", "wall time (s)", "steps", "gap tracking, profile"]),
        ("margin", &["fraction stable", "smooth model", "gap tracking, profile"]),
    ] {
        place.check(id, labels);
    }
    assert_eq!(place.texts("margin").get("margin (m)"), Some(&2));
    // Of one problem it is known down to where its reference is.
    place.draw(&only(&["sweep"]).replace("set = \"all\"", "set = \"\""));
    assert!(place.texts("sweep").contains_key("uncertainty of the reference"), "{:?}", place.texts("sweep"));
    // Without a group the experiment that was not run is named.
    let figures = FigureList::parse(Path::new("my.toml"), &only(&["map", "other"])).unwrap();
    let made = figures.make_all(place.0.path(), None, (&Styles::standard(), "svg")).unwrap();
    assert_eq!((made.files.len(), made.missing.len()), (1, 1));
    assert_has(&made.missing[0].1, &["experiments/paper/not-run.toml"]);
}

/// One sees where a line ends because nothing completes, and which line others are held against.
#[test]
fn a_line_that_fails_ends_in_a_cross_and_a_baseline_is_grey_and_named() {
    let place = MadeUp::new();
    place.edit("runs.csv", |_, row| {
        let fails = row.contains("rim-smooth,0.005,");
        Some(if fails { row.replace("completed", "diverged") } else { row.to_owned() })
    });
    let keys = "baselines = [\"rim-smooth\"]\nnames = { rim-smooth = \"in time\" }\n\
                labels = [\"rim-smooth\", \"rim-nonsmooth-gap/profile\"]\nonly = { set = \"all\" }";
    let list = only(&["sweep"]).replace("only = { set = \"all\" }", keys);
    place.draw(&list);
    let svg = String::from_utf8(read(&place.path("figures/sweep.svg"))).unwrap();
    let texts = texts_of(&svg);
    assert!(texts.contains_key("in time") && texts.contains_key("all runs failed"), "{texts:?}");
    assert!(svg.contains("stroke=\"#848a91\" stroke-width=\"1\" stroke-dasharray=\"1 2.5\""), "no dots to the cross");
    let unknown = list.replace("names = { rim-smooth", "names = { rim-smoth");
    assert_has(&refused(&unknown), &["rim-smoth", "rim-smooth"]);
    // A bound is not what was measured: the number is that of the claim.
    let titled =
        list.replace("id = \"sweep\"", "id = \"sweep\"\ntitle = \"{claim=study/made-up:growth unit=times} as much\"");
    assert_has(&place.reason(&titled, "sweep"), &["claims.csv"]);
    std::fs::write(place.path("claims.csv"), "id,measured\ngrowth,10.69\n").unwrap();
    place.draw(&titled);
    assert!(place.texts("sweep").contains_key("11 times as much"), "{:?}", place.texts("sweep"));
}

#[test]
fn what_fails_and_what_was_not_run_differ_in_a_table_of_failures() {
    let place = MadeUp::new();
    place.edit("runs.csv", |_, row| (!row.contains("gap/profile,0.005,")).then(|| row.to_owned()));
    place.draw(&only(&["map"]).replace("\"stability-map\"", "\"stability-map\"\nby_case = true"));
    let texts = place.texts("map");
    assert_eq!(["box", "50", "–", "smooth model"].map(|word| texts.get(word).copied()), [Some(1); 4], "{texts:?}");
}

#[test]
fn an_unknown_column_or_parameter_is_named() {
    let place = MadeUp::new();
    // A number of runs that these have not, and a parameter of no case.
    let wrong = only(&["work", "margin"]);
    let wrong = wrong.replace("actuator_micro_steps +", "exchanges +").replace("\"margin_m\"", "\"mass_kg\"");
    assert_has(&place.reason(&wrong, "work"), &["runs.csv", "unknown column `exchanges`", "mechanics_micro_steps"]);
    assert_has(&place.reason(&wrong, "margin"), &["mass_kg"]);
    let figures = FigureList::parse(Path::new("my.toml"), &wrong).unwrap();
    assert!(figures.make_all(&place.path("nowhere"), None, (&Styles::standard(), "svg")).is_err());
}

/// A panel may show one case of several; one that is not there is named with those that are.
#[test]
fn a_figure_of_one_case_has_only_its_runs() {
    let place = MadeUp::new();
    let of_set = |set: &str| only(&["map"]).replace("{ set = \"all\" }", &format!("{{ set = \"{set}\" }}"));
    // Both phases of rim-smooth at 5 ms stay stable in the set that is shown, and in that only.
    place.edit("runs.csv", |_, row| {
        let stable = row.contains("margin_m=0.1,rim-smooth");
        Some(if stable { row.replace("diverged", "completed") } else { row.to_owned() })
    });
    let some_fail = |list: &str| {
        place.draw(list);
        place.texts("map").contains_key("some fail")
    };
    assert!(!some_fail(&of_set("margin_m=0.1")) && some_fail(&only(&["map"])));
    let reason = place.reason(&of_set("margin_m=0.2"), "map");
    assert_has(&reason, &["map.svg is older", "margin_m=0.2", "margin_m=0.1"]);
}

/// Reads a list with one figure of a kind, and returns what is wrong with it.
fn refused(figure: &str) -> String {
    FigureList::parse(Path::new("my.toml"), figure).unwrap_err().to_string()
}

const LEAST_XY: &str = "[[figure]]\nid = \"mine\"\nkind = \"xy\"\nexperiment = \"study/made-up\"\n";
const LEAST_PANEL: &str = "[[figure.panels]]\nmetric = \"force_error_rms_n\"\n";
/// The same of the made-up results, which have two sets of parameters.
const POOLED_PANEL: &str = "[[figure.panels]]\nmetric = \"force_error_rms_n\"\nonly = { set = \"all\" }\n";

#[test]
fn what_is_wrong_with_a_list_is_told_all_at_once_with_lines_and_nothing_panics() {
    for (line, wanted) in [
        ("width = 0", "width = 0 is not valid; valid: a number of px from 240 to 4000"),
        ("width = 1", "width = 1 is"),
        ("width = -1", "width = -1 is"),
        ("width = 1e9", "width = 1000000000.0 is"),
        ("width = nan", "width = NaN is"),
        ("width = \"wide\"", "width = \"wide\" is"),
        ("height = inf", "height = inf is"),
        ("widht = 700", "unknown key `widht` (did you mean `width`?)"),
        ("columns = 0", "columns = 0 is"),
    ] {
        let message = refused(&format!("{LEAST_XY}{line}\n{LEAST_PANEL}"));
        assert_has(&message, &["my.toml: [[figure]] in line 1 (`mine`): ", wanted]);
    }
    for (line, wanted) in [
        ("range = [1.0, 1e-3]", "range = [1.0, 0.001] is not valid; valid: [low, high], finite, 0 < low < high"),
        ("range = [0.0, 1.0]", "range = "),
        ("range = [1.0]", "range = [1.0] is"),
        ("slope = [1.0, [0.0, 1.0]]", "slope = "),
        ("only = { caze = \"box\" }", "only: caze: unknown field `caze`, expected one of `case`, `set`, `without`"),
        ("labels = [1, 2]", "labels 1: invalid type: integer `1`, expected a string"),
    ] {
        let message = refused(&format!("{LEAST_XY}{LEAST_PANEL}{line}\n"));
        assert_has(&message, &[&format!("panels 1: {wanted}")]);
    }
    for id in ["../mine", "/mine", "a/b", "", ".", "..", ".hidden", "a b", "\u{e9}", &"x".repeat(400_000)] {
        let message = refused(&format!("{}{LEAST_PANEL}", LEAST_XY.replace("mine", id)));
        assert!(message.contains("id = ") && message.contains("a file name of letters"), "{message}");
        assert!(message.len() < 600, "{} characters", message.len());
    }
    for experiment in ["made-up", "../study/made-up", "/study/made-up", "study/..", "study/a/b"] {
        let message = refused(&format!("{}{LEAST_PANEL}", LEAST_XY.replace("study/made-up", experiment)));
        assert!(message.contains("experiment = "), "{message}");
    }
    for (key, wanted) in [
        ("x = { cost = \"exchanges\", parameter = \"mass\" }", "not several"),
        ("x = { cost = \"exchanges\" }\nwithin = 0.1", "`within` does not go with a cost across"),
        ("macro_step_s = 0.1", "`macro_step_s` needs a parameter across"),
        ("x = { cost = \"exchanges + pivots\" }", "panels 1: x: cost: unknown cost `pivots`; valid: wall_s, "),
        ("x = { parametre = \"mass\" }", "unknown field `parametre`, expected one of `parameter`"),
    ] {
        for message in [format!("{LEAST_XY}{LEAST_PANEL}{key}\n"), format!("{LEAST_XY}{key}\n{LEAST_PANEL}")]
            .map(|it| refused(&it))
        {
            assert!(message.contains(wanted) && message.lines().count() == 1, "{message}");
        }
    }
    // The first of each figure, and that of the second with its line.
    let twice = format!("{LEAST_XY}width = 0\n{LEAST_PANEL}{LEAST_XY}height = 0\n{LEAST_PANEL}");
    let message = refused(&twice);
    let missing = "panels 1: missing field `metric`";
    assert_has(&message, &["2 things are wrong", "in line 1 (`mine`): width = 0", "in line 8 (`mine`): height = 0"]);
    let message = refused(&format!("{LEAST_XY}[[figure.panels]]\n"));
    assert_has(&message, &[missing]);
    let message = refused(&format!("{LEAST_XY}{}", LEAST_PANEL.replace("force_error_rms_n", "force_error")));
    assert_has(&message, &["panels 1: metric: unknown column `force_error`", "force_error_rms_n"]);
    let message = refused(&format!("{LEAST_XY}{LEAST_PANEL}{LEAST_XY}{LEAST_PANEL}"));
    assert!(message.contains("[[figure]] in line 7 (`mine`): another figure has this id"), "{message}");
    let message = refused("[[figure]]\n");
    assert!(message.contains("missing field `id`"), "{message}");
    let message = refused(&LEAST_XY.replace("\"xy\"", "\"xyz\""));
    assert_has(&message, &["unknown kind of figure `xyz` (did you mean `xy`?)"]);
    let message = refused(&format!("{LEAST_XY}note = \"two\\nlines\"\n{LEAST_PANEL}"));
    assert_has(&message, &["note = ", "text in one line"]);
    assert!(refused("[[figures]]\n").contains("line 1, column 3"), "{}", refused("[[figures]]\n"));
}

#[test]
fn what_may_be_left_out_has_a_default_and_the_figure_is_drawn() {
    let place = MadeUp::new();
    let made = place.draw(&format!("{LEAST_XY}{POOLED_PANEL}"));
    assert_eq!((made.files.len(), &made.failed[..]), (1, &[][..]));
    let svg = std::fs::read_to_string(place.path("figures/mine.svg")).unwrap();
    assert_has(&svg, &["viewBox=\"0 0 680 330\""]);
    assert!(texts_of(&svg).contains_key("force_error_rms_n"), "the label is the metric");
}

#[test]
fn a_label_that_no_run_has_and_panels_without_room_are_told() {
    let place = MadeUp::new();
    let wrong = format!("{LEAST_XY}{POOLED_PANEL}labels = [\"rim-smooth\", \"rim-smoth\"]\n");
    assert_has(&place.reason(&wrong, "mine"), &["unknown label `rim-smoth` (did you mean `rim-smooth`?)"]);
    let narrow = format!("{LEAST_XY}width = 240\nheight = 240\n{}", POOLED_PANEL.repeat(12));
    assert_has(&place.reason(&narrow, "mine"), &["width = 240 px leaves"]);
    assert!(!place.path("figures").exists(), "nothing is made for a figure that cannot be drawn");
}

#[test]
fn a_figure_that_would_pool_cases_sets_or_macro_steps_without_a_word_is_refused() {
    let place = MadeUp::new();
    let silent = place.draw(&MADE_UP_FIGURES.replace("only = { set = \"all\" }\n", "")).failed;
    for wanted in ["map", "sweep", "work"] {
        let (_, reason) = silent.iter().find(|(id, _)| id == wanted).expect("not drawn");
        assert_has(reason, &["drawn as one", "\"margin_m=0.1\""]);
    }
    let of_any_step = only(&["margin"]).replace("macro_step_s = 5e-3\n", "");
    assert_has(&place.reason(&of_any_step, "margin"), &["several values of macro_step_s"]);
    // A second case with the same margins.
    place.edit("runs.csv", |k, row| {
        Some(if k > 0 && k.is_multiple_of(2) { row.replace(",box,", ",ball,") } else { row.to_owned() })
    });
    place.edit("parameters.csv", |k, row| {
        Some(if k == 0 { row.to_owned() } else { format!("{row}\n{}", row.replacen("box", "ball", 1)) })
    });
    for (id, wanted) in [("map", "case = …"), ("margin", "case and set")] {
        assert_has(&place.reason(&only(&[id]), id), &[wanted, "ball"]);
    }
}

#[test]
fn half_a_file_or_an_edited_one_is_no_source_of_a_figure() {
    let place = MadeUp::new();
    let path = place.path("runs.csv");
    let whole = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<&str> = whole.lines().collect();
    for other in
        [rows[..2].join("\n"), whole.replacen("diverged", "completed", 1), rows[..].join("\n") + "\n" + rows[1] + "\n"]
    {
        std::fs::write(&path, other).unwrap();
        let failed = place.draw(MADE_UP_FIGURES).failed;
        assert!(failed.len() == 4 && failed[0].1.contains("runs.csv has been changed"), "{failed:?}");
    }
    std::fs::write(&path, whole).unwrap();
    std::fs::remove_file(place.path("SHA256SUMS")).unwrap();
    assert_has(&place.reason(MADE_UP_FIGURES, "map"), &["run the experiment again"]);
    let figures = FigureList::parse(Path::new("my.toml"), MADE_UP_FIGURES).unwrap();
    let message = figures.make_all(place.0.path(), Some("nope"), (&Styles::standard(), "svg")).unwrap_err().to_string();
    assert_has(&message, &["unknown group of figures `nope`", "study"]);
}

/// Writes a drawing twice and checks: equal bytes, as pixels too, each label once, nothing outside the page.
fn check(drawing: &Drawing, name: &str, labels: &[&str]) {
    let place = tempfile::tempdir().expect("a temporary folder");
    let written = || {
        let [svg, png] = ["pixels.svg", "pixels.png"].map(|name| place.path().join(name));
        render::write(drawing, &svg).expect("a writable folder");
        render::write_png(drawing, &png, 1.0).expect("a writable folder");
        [svg, png].map(|file| read(&file))
    };
    let [svg, png] = written();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    assert!(written() == [svg.clone(), png], "{name} is not reproducible");

    let svg = String::from_utf8(svg).expect("an SVG is text");
    let texts = texts_of(&svg);
    for label in labels {
        assert_eq!(texts.get(*label), Some(&1), "{label} in {name}: {texts:?}");
    }
    for shape in &drawing.shapes {
        let corners = match shape {
            Shape::Path { points, .. } => points.clone(),
            Shape::Disc { centre: (x, y), radius, .. } => vec![(x - radius, y - radius), (x + radius, y + radius)],
            Shape::Open(..) | Shape::Close => continue,
            Shape::Text(text) => {
                let (back, forth) = (text.lead(), text.width() - text.lead());
                let along = |d: f64| {
                    if text.upwards { (text.at.0, text.at.1 - d) } else { (text.at.0 + d, text.at.1) }
                };
                vec![along(-back), along(forth)]
            }
        };
        for (x, y) in corners {
            let inside = (0.0..=drawing.width).contains(&x) && (0.0..=drawing.height).contains(&y);
            assert!(inside, "({x}, {y}) of {shape:?} is outside {name}");
        }
    }
    if let Ok(folder) = std::env::var("RIMBENCH_FIGURES_DIR") {
        render::write(drawing, &Path::new(&folder).join(name).with_extension("svg")).expect("a writable folder");
    }
}

pub fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).expect("a written figure")
}

fn texts_in(svg: &Path) -> BTreeMap<String, usize> {
    texts_of(&String::from_utf8(read(svg)).expect("an SVG is text"))
}

/// Counts the text elements of an SVG and checks that all its elements are known and tags are balanced.
pub fn texts_of(svg: &str) -> BTreeMap<String, usize> {
    let mut texts = BTreeMap::new();
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    // It is dark where the page around it is.
    assert_eq!(svg.matches("<style>@media (prefers-color-scheme:dark){svg{").count(), 1);
    let mut open: Vec<&str> = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (inside, after) = tag.split_once('>').expect("a tag has an end");
        assert!(!inside.contains("NaN") && !inside.contains("inf"), "{tag}");
        if let Some(name) = inside.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
            continue;
        }
        let name = inside.split([' ', '/']).next().unwrap_or_default();
        assert!(["svg", "title", "desc", "style", "path", "g", "text"].contains(&name), "{tag}");
        if name == "text" {
            let plain = after.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&");
            *texts.entry(plain).or_default() += 1;
        }
        if !inside.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
    texts
}

/// Something like the paper's Fig. 2: forces of which one is lost, and a mass that becomes infinite.
fn force_and_mass() -> Figure {
    let sample = |f: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..=500).map(|k| 5e-3 * f64::from(k)).map(|t| (t, f(t))).collect()
    };
    let force = |scheme: &str, f: &dyn Fn(f64) -> f64| Series::new(scheme, sample(f), style_of(scheme));
    let smooth = |t: f64| 1000.0 * (-(t - 0.2f64).powi(2) / 0.003).exp() - 181.0 * (t / 2.5);
    let forces = [
        force("reference", &smooth),
        force("zero-order-hold", &|t| if t > 0.3 { f64::NAN } else { 40.0 * (t / 0.04).exp() * (900.0 * t).sin() }),
        force("rim-smooth", &|t| smooth(t) + 21_000.0 * (-(t - 1.693).abs() / 0.012).exp() * (700.0 * t).sin()),
        force("rim-nonsmooth-gap", &|t| smooth(t - 1e-3)),
    ];
    let masses = [("rim-smooth", f64::INFINITY), ("rim-nonsmooth", 310.0)]
        .map(|(scheme, locked)| force(scheme, &|t| if (1.693..1.713).contains(&t) { locked } else { 250.0 }))
        .map(|series| series.mode(Mode::Steps));
    let panel = |title: &str, x: Axis, y: Axis, series: &[Series]| {
        series.iter().cloned().fold(Plot::new(title, x, y), Plot::layer)
    };
    let time = || Axis::linear("time t (s)");
    let newtons = || Axis::linear("actuator force F (N)").within(Some([-2000.0, 2000.0]));
    let mass = Axis::log10("effective mass (kg)").within(Some([100.0, 1e4]));
    let zoom = Axis::linear("time t (s), touch-down").within(Some([1.66, 1.78]));
    let force = panel("(a) actuator force", time(), newtons(), &forces);
    Figure::new(1180.0, 400.0, Some(3))
        .panel(Plot { marks: vec![Guide::Horizontal(0.0)], ..force })
        .panel(panel("(b) effective mass at the interface", time(), mass, &masses))
        .panel(panel("(c) force at touch-down", zoom, newtons(), &forces))
}

/// Results of an experiment that no list names: schemes on cases, each with macro steps of its own, that diverge at the
/// largest.
fn unlisted_results(folder: &Path, name: &str, cases: &[(&str, [f64; 3])], schemes: usize) {
    let folder = folder.join(name);
    std::fs::create_dir_all(&folder).unwrap();
    let mut runs = String::from("run_id,case,set,label,scheme,macro_step_s,phase,outcome,force_error_rms_of_peak\n");
    let mut id = 0;
    for (case, steps) in cases {
        for scheme in 0..schemes {
            for (index, step) in steps.iter().enumerate() {
                let lost = index == 2 && scheme == 0;
                let (outcome, error) =
                    if lost { ("diverged", f64::NAN) } else { ("completed", 0.01 * (index + scheme + 1) as f64) };
                runs += &format!("{id:x},{case},,row-{scheme}/1um,rim-smooth,{step},1.0,{outcome},{error}\n");
                id += 1;
            }
        }
    }
    std::fs::write(folder.join("runs.csv"), runs).unwrap();
    checksums::write(&folder, ["runs.csv".to_owned()]).unwrap();
}

#[test]
fn an_experiment_that_no_list_names_has_a_map_of_its_stability_and_its_errors() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let steps = [1e-3, 2e-3, 5e-3];
    // Whatever a file is called that is run.
    for odd in ["mine/ü; $(x)", "mine/ ", &format!("mine/{}", "n".repeat(245))] {
        unlisted_results(place.path(), odd, &[("box", steps)], 3);
        let (list, failed) = FigureList { figures: Vec::new() }.completed(place.path(), None);
        let made = list.make_all(place.path(), None, (&Styles::standard(), "svg")).unwrap();
        assert!(failed.is_empty() && made.failed.is_empty() && made.files.len() == 2, "{odd}: {failed:?} {made:?}");
        std::fs::remove_dir_all(place.path().join(odd)).unwrap();
    }
    unlisted_results(place.path(), "mine/few", &[("box", steps)], 3);
    unlisted_results(place.path(), "mine/many", &[("box", steps), ("bar", [1e-6, 2e-6, 5e-6])], 20);
    std::fs::create_dir_all(place.path().join("mine/broken")).unwrap();
    std::fs::write(place.path().join("mine/broken/runs.csv"), "a,b\n1,2\n").unwrap();
    let none = FigureList { figures: Vec::new() };
    let (list, failed) = none.completed(place.path(), None);
    let [(name, reason)] = &failed[..] else { panic!("{failed:?}") };
    assert!(name == "mine/broken" && reason.contains("is no table of runs"), "{reason}");
    let made = list.make_all(place.path(), None, (&Styles::standard(), "svg")).unwrap();
    assert!(made.failed.is_empty() && made.files.len() == 4, "{made:?}");
    let texts = |name: &str, id: &str| texts_in(&place.path().join(format!("{name}/figures/{id}.svg")));
    let few = texts("mine/few", "mine-few-error");
    let says = |words: &str| few.keys().any(|text| text.starts_with(words));
    assert!(says("failed") && says("smooth model, row-0, margin 1 µm"), "{few:?}");
    // Of many schemes rows, with the cases' own macro steps; a map by case has the largest stable one.
    let many = texts("mine/many", "mine-many-error");
    assert!(many.contains_key("smooth model, row-19, margin 1 µm") && many.contains_key("(b) box"), "{many:?}");
    // Row 0 diverges at the largest step of both, its limits are 2 µs and 2 ms; those of some others are beyond the
    // steps tried.
    let map = texts("mine/many", "mine-many-stability");
    assert!(["2 µs", "all tried", "none"].iter().all(|limit| map.contains_key(*limit)), "{map:?}");
    // A list that names an experiment says all of it.
    let named = format!(
        "{}[[figure.panels]]\nmetric = \"force_error_rms_of_peak\"\n",
        LEAST_XY.replace("study/made-up", "mine/few")
    );
    let (list, _) = FigureList::parse(Path::new("my.toml"), &named).unwrap().completed(place.path(), Some("mine"));
    assert!(!list.figures.iter().any(|figure| figure.id.starts_with("mine-few")), "{:?}", list.figures);
}

#[test]
fn a_picture_that_leaves_cases_out_says_so_itself() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let names: Vec<String> = (0..8).map(|case| format!("case-{case:02}")).collect();
    let cases: Vec<(&str, [f64; 3])> = names.iter().map(|name| (name.as_str(), [1e-3, 2e-3, 5e-3])).collect();
    unlisted_results(place.path(), "mine/lines", &cases, 3);
    unlisted_results(place.path(), "mine/rows", &cases, 20);
    unlisted_results(place.path(), "mine/all", &cases[..6], 20);
    let (list, failed) = FigureList { figures: Vec::new() }.completed(place.path(), None);
    let made = list.make_all(place.path(), None, (&Styles::standard(), "svg")).unwrap();
    assert!(failed.is_empty() && made.failed.is_empty(), "{failed:?} {made:?}");
    for (name, left_out) in [("lines", true), ("rows", true), ("all", false)] {
        let texts = texts_in(&place.path().join(format!("mine/{name}/figures/mine-{name}-error.svg")));
        let said = texts.keys().any(|text| text.starts_with("2 more cases are not drawn"));
        assert_eq!(said, left_out, "{name}: {texts:?}");
        assert!(texts.contains_key("(f) case-05"), "{texts:?}");
    }
}

#[test]
fn ranked_rows_signed_axes_and_lost_phases_say_what_they_show() {
    let place = MadeUp::new();
    let drawn = |text: &str| {
        let made = place.draw(text);
        assert!(made.failed.is_empty(), "{:?}", made.failed);
        place.texts("mine")
    };
    let kind = |kind: &str| LEAST_XY.replace("\"xy\"", &format!("\"{kind}\""));
    let dots = drawn(&format!("{}{POOLED_PANEL}", kind("dots")));
    for wanted in ["gap tracking, profile", "H = 1 ms", "H = 5 ms", "failed, %", "50"] {
        assert!(dots.contains_key(wanted), "{wanted}: {dots:?}");
    }
    let panel =
        "[[figure.panels]]\nmetric = \"interface_residual_j\"\nonly = { set = \"all\" }\nsymlog = [1e-4, 1.0]\n";
    let signed = drawn(&format!("{LEAST_XY}{panel}"));
    assert!(["−10⁰", "0", "10⁰"].iter().all(|tick| signed.contains_key(*tick)), "{signed:?}");
    // Every run of one macro step has a faint mark; what broke off is counted.
    place.edit("runs.csv", |k, row| (k == 0 || row.contains(",0.005,")).then(|| row.to_owned()));
    let phases = drawn(&format!("{}runs = true\n{POOLED_PANEL}", kind("dots")));
    assert!(phases.contains_key("failed, %") && phases.contains_key("50"), "{phases:?}");
}

/// The page of keys is written by hand; what a figure takes are the fields of its struct.
#[test]
fn the_page_of_keys_has_those_that_figures_take_and_no_others() {
    let page = std::fs::read_to_string(root().join("docs/guide/figure-keys.md")).unwrap();
    let mut said = BTreeSet::new();
    for section in page.split("\n## ").skip(1).filter(|section| !section.starts_with("Table")) {
        let kind = section.strip_prefix('`').and_then(|rest| rest.split('`').next()).unwrap_or_default();
        for line in section.lines().filter_map(|line| line.strip_prefix("| `")) {
            let (key, rest) = line.split_once("` | ").unwrap();
            let kinds =
                if section.starts_with("Several") { rest.split(" | ").next().unwrap_or_default() } else { kind };
            said.extend(kinds.split(", ").map(|kind| (kind, key)));
        }
    }
    // Every kind has a width, which stands with the keys of all.
    let taken = figure_keys().into_iter().map(|(kind, key)| (if key == "width" { "" } else { kind }, key));
    let taken: BTreeSet<_> = taken.collect();
    let differ: Vec<_> = said.symmetric_difference(&taken).collect();
    assert!(differ.is_empty(), "docs/guide/figure-keys.md and what figures take differ in (kind, key) {differ:?}");
}

/// The values of a drawing, a line for each panel and each series.
fn plotted(drawing: &Drawing) -> Vec<String> {
    let series = |series: &SeriesData| {
        let point = |point: &Datum| match point.range {
            Some([low, high]) => {
                format!(", {} {:.5} {low:.5} to {high:.5} {}", point.x, point.y, point.note).trim_end().to_owned()
            }
            None => format!(", {} {:.5} {}", point.x, point.y, point.note).trim_end().to_owned(),
        };
        format!("{}{}", series.name, series.points.iter().map(point).collect::<String>())
    };
    let panel = |panel: &PanelData| {
        let head = format!("{} | {} | {}", panel.title, panel.x, panel.y);
        [head].into_iter().chain(panel.series.iter().map(series)).collect::<Vec<_>>()
    };
    drawing.data.iter().flat_map(panel).collect()
}

/// What is shown does not depend on how it is laid out: values of each kind that plots, as they were with another layout.
#[test]
fn every_kind_plots_the_values_that_it_did() {
    let place = MadeUp::new();
    let dots = LEAST_XY.replace("\"xy\"", "\"dots\"") + POOLED_PANEL;
    let by_case = only(&["map"]).replace("\"stability-map\"", "\"stability-map\"\nby_case = true");
    let mut found = String::new();
    for list in [only(&["sweep"]), only(&["map"]), by_case, dots, only(&["margin"])] {
        let figures = FigureList::parse(Path::new("my.toml"), &list).unwrap().figures;
        found += &(plotted(&figures[0].drawn(place.0.path(), &Styles::standard()).unwrap()).join("\n") + "\n");
    }
    assert_eq!(found, PLOTTED);
}

/// Title and axes of each panel, then name, abscissae, ordinates, ranges and remarks of each series.
const PLOTTED: &str = "\
created | macro step H (ms) | error (N)
rim-smooth, 0.5 0.00315 0.00180 to 0.00450, 1 0.00630 0.00360 to 0.00900, 5 0.04500 50 % of the runs failed
rim-nonsmooth-gap/profile, 0.5 0.00035 0.00020 to 0.00050, 1 0.00070 0.00040 to 0.00100, 5 0.00350 0.00200 to 0.00500
 | macro step H (ms) | share of the runs that complete
rim-nonsmooth-gap/profile, 0.5 1.00000, 1 1.00000, 5 1.00000
rim-smooth, 0.5 1.00000, 1 1.00000, 5 0.50000 50 % of the runs failed
smooth model | macro step H (ms), n = 4 each | share of the runs that complete
box, 0.5 1.00000 0 % of the runs failed, 1 1.00000 0 % of the runs failed, 5 0.50000 50 % of the runs failed
gap tracking, profile | macro step H (ms), n = 4 each | share of the runs that complete
box, 0.5 1.00000 0 % of the runs failed, 1 1.00000 0 % of the runs failed, 5 1.00000 0 % of the runs failed
 | macro step H (ms) | force_error_rms_n
rim-nonsmooth-gap/profile, 0.5 0.00035 0.00020 to 0.00050, 1 0.00070 0.00040 to 0.00100, 5 0.00350 0.00200 to 0.00500
rim-smooth, 0.5 0.00315 0.00180 to 0.00450, 1 0.00630 0.00360 to 0.00900, 5 0.04500 50 % of the runs failed
(a) | margin (m) | error (N)
rim-smooth, 0.01 0.04500 50 % of the runs failed, 0.1 0.04500 50 % of the runs failed
rim-nonsmooth-gap/profile, 0.01 0.00350 0.00200 to 0.00500, 0.1 0.00350 0.00200 to 0.00500
(b), n = 2 | margin (m) | fraction stable
rim-smooth, 0.01 0.50000, 0.1 0.50000
";

/// Two macro steps of two micro steps each, as `[[beliefs]]` are stored: a contact opens, and one closes.
#[test]
fn a_belief_is_judged_by_its_force_at_the_end_and_told_by_what_becomes_of_the_contact() {
    let place = MadeUp::new();
    let folder = place.path("traces");
    std::fs::create_dir_all(&folder).unwrap();
    let header =
        "scheme,time_s,box_x_m,box_y_m,box_angle_rad,gap_disc_ledge_m,contact_force_disc_ledge_n,actuator_force_n\n";
    let rows = |scheme: &str, gaps: [f64; 3], contact: f64, end: f64| -> String {
        let row = |k: usize| {
            let (contact, force) = if k == 0 { (0.0, 0.0) } else { (contact, end * k as f64 / 2.0) };
            format!("{scheme},{},0.0,0.4,0.0,{},{contact},{force}\n", 5e-3 * k as f64, gaps[k])
        };
        (0..3).map(row).collect()
    };
    let write = |case: &str, of: [String; 5]| {
        let text = header.to_owned() + &of.concat();
        std::fs::write(folder.join(format!("beliefs-{case}.csv")), text).unwrap();
    };
    let opens = [0.0, 2e-6, 8e-6];
    let schemes = ["zero-order-hold", "rim-smooth", "rim-nonsmooth", "rim-nonsmooth-gap"];
    write(
        "wedge-box-reversal",
        [
            rows("", opens, 0.0, 1000.0),
            rows(schemes[0], [0.0; 3], 0.0, 2000.0),
            rows(schemes[1], [0.0; 3], -13_800.0, 2000.0),
            rows(schemes[2], opens, 0.0, 1009.0),
            rows(schemes[3], opens, 0.0, 1011.0),
        ],
    );
    write(
        "wedge-box",
        [
            rows("", [4e-5, 0.0, 0.0], 500.0, -700.0),
            rows(schemes[0], [4e-5, 0.0, -8e-5], 0.0, -100.0),
            rows(schemes[1], [4e-5; 3], 900.0, 26_200.0),
            rows(schemes[2], [4e-5, 0.0, -8e-5], 0.0, -100.0),
            rows(schemes[3], [4e-5, 0.0, 0.0], 500.0, -701.0),
        ],
    );
    let panel = |case: &str| {
        format!(
            "[[figure.panels]]\ntitle = \"{case}\"\nnote = \"it; moves\"\ncase = \"{case}\"\ncontact = \"disc_ledge\"\n\
             frame = \"box\"\nat = [-0.8, -0.39]\n"
        )
    };
    let list = format!(
        "[[figure]]\nid = \"mine\"\nkind = \"mechanism\"\nexperiment = \"study/made-up\"\nbeliefs = {schemes:?}\n\
         words = [\"\", \"\", \"\", \"\"]\n{}{}",
        panel("wedge-box-reversal"),
        panel("wedge-box")
    );
    let list = FigureList::parse(Path::new("list.toml"), &list).unwrap();
    let drawing = list.figures[0].drawn(place.0.path(), &Styles::standard()).unwrap();
    let texts = texts_of(&render::svg(&drawing));
    let told = |words: &str| texts.get(words).copied().unwrap_or(0);
    // A hundredth of the largest true force is right, more is not.
    let color = |words: &str| {
        let of = |shape: &Shape| matches!(shape, Shape::Text(text) if text.content == words).then(|| shape.clone());
        match drawing.shapes.iter().find_map(of) {
            Some(Shape::Text(text)) => text.color,
            _ => panic!("no {words}: {texts:?}"),
        }
    };
    assert!(color("1009 N") != color("1011 N") && color("1011 N") == color("26.2 kN"));
    assert_eq!([told("lifts off"), told("by 8 µm")], [3, 3], "{texts:?}");
    assert_eq!([told("pulls it down"), told("with 13.8 kN"), told("hangs in air"), told("26.2 kN")], [1; 4]);
    assert_eq!([told("sinks in"), told("falls 40 µm"), told("and lands")], [2; 3]);
    assert_eq!(drawing.data.len(), 2);
    assert!(drawing.data.iter().all(|panel| panel.series.len() == 5));
}

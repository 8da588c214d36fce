//! The figures that are kept: their titles, numbers, words and pictures against results, claims and pages.

use crate::figures::{MadeUp, only, read, texts_of};
use crate::{files, root};
use rimbench_figures::drawing::Shape;
use rimbench_figures::style::Styles;
use rimbench_figures::{FigureEntry, FigureList};
use std::collections::BTreeMap;
use std::path::Path;

/// The claims of a folder of results, `group/name:id` or `group:id`, and what came of them.
fn verdicts(results: &Path) -> BTreeMap<String, String> {
    let mut verdicts = BTreeMap::new();
    for path in files(results, "csv").into_iter().filter(|path| path.ends_with("claims.csv")) {
        let table = rimbench_results::results_table::read_table(&path).unwrap();
        let (id, verdict) = (table.column("id").unwrap(), table.column("verdict").unwrap());
        let place = path.parent().unwrap().strip_prefix(results).unwrap().display().to_string();
        let rows = (0..table.len()).map(|row| (table.text(row, id), table.text(row, verdict)));
        verdicts.extend(rows.map(|(id, verdict)| (format!("{place}:{id}"), verdict.to_owned())));
    }
    verdicts
}

#[test]
fn every_title_of_a_figure_rests_on_claims_that_reproduce_and_every_figure_is_on_a_page() {
    let root = root();
    let figures = FigureList::read(&root.join("paper/figures.toml")).unwrap().figures;
    let verdicts = verdicts(&root.join("results"));
    let pages: String =
        files(&root.join("docs"), "md").iter().map(|page| std::fs::read_to_string(page).unwrap()).collect();
    let mut faults = Vec::new();
    for figure in &figures {
        let id = &figure.id;
        if figure.title.is_empty() || figure.subtitle.is_empty() {
            faults.push(format!("{id} has no title or no subtitle"));
        }
        if !root.join(format!("experiments/{}.toml", figure.experiment)).is_file() {
            faults.push(format!("{id}: no experiment {}", figure.experiment));
        }
        if !root.join(format!("results/{}/figures/{id}.svg", figure.experiment)).is_file() {
            faults.push(format!("{id} is not committed"));
        }
        let has_claims = verdicts.keys().any(|claim| claim.starts_with(&format!("{}:", figure.experiment)));
        if figure.claims.is_empty() && has_claims {
            faults.push(format!("{id}: the title names no claim"));
        }
        for claim in &figure.claims {
            match verdicts.get(claim).map(String::as_str) {
                Some("reproduced") => {}
                verdict => faults.push(format!("{id}: `{claim}` of the title is {verdict:?}")),
            }
        }
        if !pages.contains(&format!("{}/figures/{id}.svg", figure.experiment)) {
            faults.push(format!("{id} is on no page"));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
    assert!(verdicts.values().any(|verdict| verdict == "not-reproduced"), "no title could fail");
}

/// All numbers in a value, as they are and in its texts.
fn numbers_in(value: &toml::Value, into: &mut Vec<f64>) {
    match value {
        toml::Value::Integer(number) => into.push(*number as f64),
        toml::Value::Float(number) => into.push(*number),
        toml::Value::String(text) => into.extend(numbers_of(text)),
        toml::Value::Array(values) => values.iter().for_each(|value| numbers_in(value, into)),
        toml::Value::Table(table) => table.values().for_each(|value| numbers_in(value, into)),
        _ => {}
    }
}

/// The numbers of a text that are no part of a word, as 0.3 of "friction 0.3" and 50 of "50mm".
fn numbers_of(text: &str) -> Vec<f64> {
    let begins = |at: usize| !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '.');
    let starts = text.match_indices(|c: char| c.is_ascii_digit()).map(|(at, _)| at).filter(|&at| begins(at));
    let number = |at: usize| {
        let end = text[at..].find(|c: char| !(c.is_ascii_digit() || "e.-".contains(c))).unwrap_or(text.len() - at);
        (1..=end).rev().find_map(|length| text[at..at + length].parse().ok())
    };
    starts.filter_map(number).collect()
}

/// A bound was read as what was measured: "five times" where it was eleven.
#[test]
fn a_number_said_of_a_figure_is_a_setting_or_filled_from_a_claim() {
    let strange = |table: &toml::Table, experiment: &str| -> Vec<String> {
        let mut own = table.clone();
        let texts: Vec<toml::Value> =
            ["title", "subtitle", "caption"].iter().filter_map(|key| own.remove(*key)).collect();
        own.remove("claims");
        let mut settings = Vec::new();
        numbers_in(&toml::Value::Table(own), &mut settings);
        let mut experiment: toml::Table = toml::from_str(experiment).unwrap();
        experiment.remove("claims");
        numbers_in(&toml::Value::Table(experiment), &mut settings);
        let is_set = |number: &f64| {
            let units = [1.0, 1e-2, 1e-3, 1e-6].map(|unit| unit * number);
            settings.iter().any(|set| units.iter().any(|value| (value - set).abs() <= 1e-9 * set.abs().max(1e-9)))
        };
        let said = texts.iter().filter_map(toml::Value::as_str).flat_map(|text| {
            let filled = text.split('{').map(|part| part.rsplit('}').next().unwrap_or_default().to_owned());
            filled.flat_map(|part| numbers_of(&part)).collect::<Vec<_>>()
        });
        said.filter(|number| !is_set(number)).map(|number| number.to_string()).collect()
    };
    let faults: Vec<String> = kept_figures()
        .iter()
        .filter_map(|(figure, table, _)| {
            let experiment = root().join(format!("experiments/{}.toml", figure.experiment));
            let strange = strange(table, &std::fs::read_to_string(experiment).unwrap());
            (!strange.is_empty()).then(|| format!("{}: {}", figure.id, strange.join(", ")))
        })
        .collect();
    assert!(faults.is_empty(), "neither a setting nor `{{claim=…}}`: {faults:#?}");
    let made_up: toml::Table =
        toml::from_str("title = \"At 5 ms 7 times {claim=a/b:c unit=times} of 0.3\"\nlabels = [\"x/0.3\"]").unwrap();
    assert_eq!(strange(&made_up, "macro_steps_ms = [5]"), ["7"]);
}

/// A picture in a page is shown in the typeface of its reader, and the widest common one is a quarter wider than that
/// of the layout.
#[test]
fn no_text_of_a_kept_figure_leaves_it_in_any_common_typeface() {
    for (figure, _, svg) in kept_figures() {
        let attribute = |tag: &str, name: &str| -> Option<String> {
            Some(tag.split(&format!(" {name}=\"")).nth(1)?.split('"').next()?.to_owned())
        };
        let number = |tag: &str, name: &str| attribute(tag, name).and_then(|text| text.parse::<f64>().ok());
        let frame = svg.split("viewBox=\"0 0 ").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
        let (mut anchor, mut size, mut seen) = (String::new(), 0.0, 0);
        for tag in svg.split('<').skip(1) {
            if tag.starts_with("g font-size") {
                anchor = attribute(tag, "text-anchor").unwrap_or_default();
                size = number(tag, "font-size").unwrap();
            }
            let (Some(x), true) = (number(tag, "x"), tag.starts_with("text ")) else { continue };
            let letters = tag.split('>').nth(1).unwrap_or_default().chars().count() as f64;
            let width = number(tag, "textLength").unwrap_or(0.7 * size * letters);
            let left = x - width
                * match anchor.as_str() {
                    "middle" => 0.5,
                    "end" => 1.0,
                    _ => 0.0,
                };
            assert!(left >= -0.5 && left + width <= frame + 0.5, "{}: {tag}", figure.id);
            seen += 1;
        }
        assert!(seen > 5, "{}", figure.id);
    }
}

/// The figures of the list, each with its table and its kept picture.
fn kept_figures() -> Vec<(FigureEntry, toml::Table, String)> {
    let root = root();
    let path = root.join("paper/figures.toml");
    let list: toml::Table = toml::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let tables = list["figure"].as_array().unwrap().iter().map(|table| table.as_table().unwrap().clone());
    let figures = FigureList::read(&path).unwrap().figures.into_iter().zip(tables);
    let with_picture = |(figure, table): (FigureEntry, toml::Table)| {
        let picture = root.join(format!("results/{}/figures/{}.svg", figure.experiment, figure.id));
        let svg = std::fs::read_to_string(picture).unwrap();
        (figure, table, svg)
    };
    figures.map(with_picture).collect()
}

/// More can neither be told apart nor be read.
#[test]
fn a_kept_figure_has_at_most_twelve_words_above_six_panels_and_seven_lines_or_rows_in_each() {
    let mut bounded = 0;
    for (figure, table, svg) in kept_figures() {
        let title = figure.said(&root().join("results")).unwrap().title;
        assert!(title.split_whitespace().count() <= 12, "{} has a long title", figure.id);
        let panels = table.get("panels").and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
        assert!(panels.len() <= 6, "{} has {} panels", figure.id, panels.len());
        let listed = |table: &toml::Table| {
            ["labels", "series", "schemes"].iter().find_map(|key| Some(table.get(*key)?.as_array()?.len()))
        };
        let across = |panel: &toml::Table| Some(panel.get("x")?.get("parameter")?.as_str()?.to_owned());
        for panel in panels.iter().filter_map(toml::Value::as_table) {
            // Over a parameter many labels are one line; and all rows there are stand in the picture.
            let named = listed(panel).or(listed(&table)).filter(|_| across(panel).or(across(&table)).is_none());
            let drawn = || {
                let rows = svg.split("data-series=\"").skip(1).filter_map(|part| part.split('"').next());
                rows.collect::<std::collections::BTreeSet<_>>().len()
            };
            let lines = named.unwrap_or_else(drawn);
            assert!((1..=7).contains(&lines), "{} has {lines} lines or rows", figure.id);
            bounded += 1;
        }
    }
    assert!(bounded > 50, "{bounded}");
}

/// What a text about a picture points at and the picture does not have.
fn missing_in(svg: &str, text: &str) -> Vec<String> {
    let text = format!(" {} ", text.to_lowercase().replace(['.', ',', ';', ':', '(', ')'], " "));
    let drawn = texts_of(svg).into_keys().collect::<Vec<_>>().join("\n").to_lowercase();
    // Lengths and colours of what is drawn, outside the dark style.
    let shapes = svg.split("</style>").last().unwrap_or_default();
    let says = |words: &[&str]| words.iter().any(|word| text.contains(&format!(" {word} ")));
    let names = ["gap tracking", "non-smooth model", "smooth model", "interface jacobian", "event-split", "libcosim"];
    let named = names.iter().filter(|name| says(&[name, &format!("{name}s")]) && !drawn.contains(*name));
    let mut missing: Vec<String> = named.map(|name| (*name).to_owned()).collect();
    for (words, is_there) in [
        (&["circle", "circles"][..], shapes.contains(" 0 1 0 ")),
        (&["bar from", "bars from", "bars are"], shapes.contains("stroke-width=\".7\"")),
        (&["faint mark", "faint marks"], shapes.matches("stroke-width=\".7\"").count() > 1),
        (&["arrow", "arrows"], drawn.contains("contact force of")),
        (&["∞", "infinite"], drawn.contains('∞')),
        (&["numbers under"], drawn.contains("f = ")),
        (&["ceilings", "not for real time"], drawn.contains("not real-time")),
        (&["share that failed", "share of runs that failed"], drawn.contains("failed, %")),
    ] {
        if says(words) && !is_there {
            missing.push(words[0].to_owned());
        }
    }
    let hues = ["red", "orange", "yellow", "green", "blue", "purple", "brown", "grey"];
    let colours: Vec<&str> = shapes.split('#').skip(1).filter_map(|part| part.get(..6)).filter_map(hue).collect();
    let coloured = hues.into_iter().filter(|colour| says(&[colour]) && !colours.contains(colour));
    missing.extend(coloured.map(str::to_owned));
    missing
}

/// The everyday name of a colour.
fn hue(hex: &str) -> Option<&'static str> {
    let channel = |at: usize| Some(f64::from(u8::from_str_radix(hex.get(at..at + 2)?, 16).ok()?));
    let [red, green, blue] = [channel(0)?, channel(2)?, channel(4)?];
    let (low, high) = (red.min(green).min(blue), red.max(green).max(blue));
    let turn = match high {
        _ if high - low < 0.15 * 255.0 => return Some("grey"),
        _ if high == red => 60.0 * ((green - blue) / (high - low)).rem_euclid(6.0),
        _ if high == green => 60.0 * ((blue - red) / (high - low) + 2.0),
        _ => 60.0 * ((red - green) / (high - low) + 4.0),
    };
    Some(match turn {
        15.0..45.0 if high < 180.0 => "brown",
        15.0..45.0 => "orange",
        45.0..70.0 => "yellow",
        70.0..170.0 => "green",
        170.0..260.0 => "blue",
        260.0..330.0 => "purple",
        _ => "red",
    })
}

#[test]
fn what_a_caption_points_at_is_in_its_picture() {
    let faults: Vec<String> = kept_figures()
        .iter()
        .filter_map(|(figure, _, svg)| {
            let said = figure.said(&root().join("results")).unwrap();
            let missing = missing_in(svg, &format!("{} {} {}", said.title, said.subtitle, said.caption));
            (!missing.is_empty()).then(|| format!("{}: no {} in the picture", figure.id, missing.join(", ")))
        })
        .collect();
    assert!(faults.is_empty(), "{faults:#?}");
    let place = MadeUp::new();
    place.draw(&only(&["sweep"]));
    let svg = String::from_utf8(read(&place.path("figures/sweep.svg"))).unwrap();
    for (text, missing) in [
        ("Numbers under the floor are forces", "numbers under"),
        ("Arrows are contact forces", "arrow"),
        ("The interface Jacobian is ahead", "interface jacobian"),
        ("∞ is a locked interface", "∞"),
        ("The purple line is the reference", "purple"),
    ] {
        assert_eq!(missing_in(&svg, text), [missing], "{text}");
    }
    assert!(missing_in(&svg, "Gap tracking and the smooth model, with bars").is_empty());
}

/// Every figure of the list: in the legend no two rows have the same line and sign.
#[test]
#[ignore = "needs the rows of all experiments, which `rimbench reproduce --everything` makes; part of .ci/all"]
fn no_two_rows_of_a_shipped_figure_look_the_same() {
    let root = root();
    let list = FigureList::read(&root.join("paper/figures.toml")).unwrap();
    let mut compared = 0;
    for figure in list.figures.iter().filter(|figure| figure.experiment != "study/wedge_box") {
        let drawing = figure.drawn(&root.join("results"), &Styles::standard()).unwrap();
        let (mut groups, mut open): (Vec<(String, Vec<&Shape>)>, bool) = (Vec::new(), false);
        for shape in &drawing.shapes {
            match shape {
                Shape::Open(_, name) => {
                    groups.push((name.clone(), Vec::new()));
                    open = true;
                }
                Shape::Close => open = false,
                shape if open => groups.last_mut().unwrap().1.push(shape),
                _ => {}
            }
        }
        // An entry of the legend begins with a level line of 27 px; its shapes are compared wherever it stands.
        let mut looks: BTreeMap<String, String> = BTreeMap::new();
        for (name, shapes) in groups {
            let Some(Shape::Path { points, closed: false, .. }) = shapes.first() else { continue };
            let [from, to] = points[..] else { continue };
            if from.1 != to.1 || (to.0 - from.0 - 27.0).abs() > 1e-9 {
                continue;
            }
            let at = |point: (f64, f64)| format!("{:.3} {:.3}", point.0 - from.0, point.1 - from.1);
            let look = |shape: &&Shape| match shape {
                Shape::Path { points, closed, fill, stroke } => {
                    let points: Vec<String> = points.iter().map(|&point| at(point)).collect();
                    format!("{points:?} {closed} {fill:?} {stroke:?};")
                }
                Shape::Disc { centre, radius, fill, stroke } => {
                    format!("{} {radius} {fill:?} {stroke:?};", at(*centre))
                }
                _ => String::new(),
            };
            let look: String = shapes.iter().map(look).collect();
            compared += 1;
            let other = looks.insert(look, name.clone());
            assert!(other.as_ref().is_none_or(|other| *other == name), "{}: {name} and {other:?}", figure.id);
        }
    }
    assert!(compared > 100, "{compared}");
}

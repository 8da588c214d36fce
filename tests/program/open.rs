//! Open problems: packs, the judge of trajectories from anywhere, entries and their rank.

use crate::program::{assert_has, cache, printed, read, refused, rimbench, root, rows_of};
use crate::support::{in_sequence, set_spec};
use approx::assert_relative_eq;
use rimbench::catalogue::Catalogue;
use rimbench::checksums::sha256;
use rimbench::cosim::{Bounds, Sequence, Side, StopFlag};
use rimbench::harness::{Cache, Entry, Packs, Problem, Ranking, SCORES, judge, obtain_reference, pack_files};
use rimbench::kept::{SummaryRow, read_summary, summary_text};
use rimbench::numerics_version::NUMERICS_VERSION;
use rimbench::runs::{RunSpec, evaluate, simulate};
use rimbench::trace::write_trace;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The version of packs of this program.
fn pack_version() -> String {
    format!("{NUMERICS_VERSION}.1")
}

/// Writes the pack of a run's problem below a folder.
fn pack(spec: &RunSpec, folder: &Path) -> PathBuf {
    let reference = obtain_reference(spec, &Cache::in_folder(cache()), StopFlag::never()).unwrap();
    let (problem, rows) = Problem::of(spec, &reference, &[]).unwrap();
    let place = folder.join(problem.name());
    for (name, bytes) in pack_files(spec, &problem, &rows).unwrap() {
        let path = place.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    place
}

/// A run as a file.
fn trace(spec: &RunSpec, file: &Path) {
    let run = simulate(spec, Bounds::default(), None, StopFlag::never()).unwrap();
    write_trace(file, &run.trajectory, None).unwrap();
}

fn shortened(case: &str, duration: f64, macro_step: f64) -> RunSpec {
    set_spec(case, &[], "zero-order-hold", macro_step).with(|own| own.duration = duration).unwrap()
}

/// Python with NumPy, if there is one.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("RIMBENCH_PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from);
    let numpy = Command::new(&python).args(["-c", "import numpy"]).output().is_ok_and(|found| found.status.success());
    if !numpy {
        println!("skipped: no Python with NumPy");
    }
    numpy.then_some(python)
}

/// What `score.py` of a pack prints, or what it refuses.
fn scored(python: &Path, pack: &Path, file: &Path) -> Result<serde_json::Value, String> {
    let output = Command::new(python).arg(pack.join("score.py")).arg(file).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    if output.status.success() { Ok(serde_json::from_slice(&output.stdout).unwrap()) } else { Err(said) }
}

#[test]
fn judge_scorer_and_simulate_have_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("wedge-box", 0.4, 2e-3),
        ("n-wedge-box", 0.3, 2e-3),
        ("wedge-box-two-ledges", 0.3, 2e-3),
        ("rocking-block", 0.5, 1e-3),
        ("beam-on-stops", 0.5, 1e-3),
        ("half-car", 0.4, 2e-3),
        ("gripper", 0.3, 1e-3),
        ("disc-row", 0.4, 2e-3),
        ("bouncing-ball", 1.0, 2e-3),
        ("impact-oscillator", 1.0, 2e-3),
        ("crane-set-down", 0.4, 2e-3),
        ("hydraulic-crane", 2.5, 5e-3),
    ];
    let (python, mut count, mut within) = (python(), 0, 0);
    for (case, duration, macro_step) in cases {
        let usual = shortened(case, duration, macro_step);
        let place = pack(&usual, folder.path());
        let problem = Problem::read(&place).unwrap();
        let reference = obtain_reference(&usual, &Cache::in_folder(cache()), StopFlag::never()).unwrap();
        for (sequence, phase) in [(Sequence::Jacobi, 1.0), (Sequence::GaussSeidel { first: Side::Mechanics }, 0.382)] {
            for step in [macro_step, 2.3 * macro_step, 4.0 * macro_step] {
                let spec = in_sequence(usual.clone(), sequence);
                let spec = spec.with(|own| (own.macro_step, own.phase) = (step, phase)).unwrap();
                let run = simulate(&spec, Bounds::default(), None, StopFlag::never()).unwrap();
                let file = folder.path().join("run.csv");
                write_trace(&file, &run.trajectory, None).unwrap();
                let wanted = evaluate(&spec, run, &reference).unwrap();
                let found = judge(&file, &problem, Some(phase)).unwrap();
                assert_relative_eq!(found.macro_step_s, step, max_relative = 1e-9);
                let mut close = true;
                let python = python.as_ref().map(|python| scored(python, &place, &file).unwrap());
                // Rows are rounded to a tenth of their uncertainty, and no rms moves by more than what all of them do.
                let rounded =
                    |of: usize| problem.0.rows.iter().map(|row| 0.1 * row.uncertainty[of]).fold(0.0, f64::max);
                let peaks = problem.0.rows.iter().filter_map(|row| row.touch_down_peak_n.or(row.force_peak_n));
                let peak = peaks.fold(f64::INFINITY, f64::min);
                for name in SCORES {
                    let (own, known) = (found.score(name), wanted.found.metric(name));
                    // A closed form has no running impulse; its rows have.
                    assert!(own.is_some() || known.is_none(), "{case}: {name}");
                    let (Some(own), Some(known)) = (own, known) else { continue };
                    let allowed = match name {
                        name if name.starts_with("position") => rounded(0),
                        name if name.starts_with("velocity") => rounded(1),
                        name if name.contains("of_") => rounded(2) / peak,
                        "impulse_error_20ms_n_s" => 20e-3 * rounded(2),
                        _ => rounded(2),
                    };
                    assert!((own - known).abs() <= allowed.max(1e-6 * known.abs()), "{case}: {name}: {own} {known}");
                    close = close && (own - known).abs() <= 1e-6 * known.abs();
                    if let Some(python) = &python {
                        let theirs = python[name].as_f64().unwrap();
                        assert_relative_eq!(own, theirs, max_relative = 1e-12, epsilon = 1e-300);
                    }
                }
                within += usize::from(close);
                count += 1;
            }
        }
    }
    assert!(count == 72 && within >= 40, "{within} of {count} within 1e-6");
}

#[test]
fn a_pack_has_the_same_bytes_again_and_its_example_has_its_score() {
    let folder = tempfile::tempdir().unwrap();
    let spec = shortened("rocking-block", 0.5, 1e-3);
    let reference = obtain_reference(&spec, &Cache::in_folder(cache()), StopFlag::never()).unwrap();
    let (problem, rows) = Problem::of(&spec, &reference, &[]).unwrap();
    let files = pack_files(&spec, &problem, &rows).unwrap();
    assert_eq!(files, pack_files(&spec, &problem, &rows).unwrap());
    let place = pack(&spec, folder.path());
    let package: serde_json::Value = serde_json::from_str(&read(place.join("datapackage.json"))).unwrap();
    for resource in package["resources"].as_array().unwrap() {
        let bytes = std::fs::read(place.join(resource["path"].as_str().unwrap())).unwrap();
        assert_eq!(resource["hash"], format!("sha256:{}", sha256(&bytes)), "{resource}");
    }
    let again = judge(&place.join("example/run.csv.gz"), &Problem::read(&place).unwrap(), None).unwrap();
    let told: serde_json::Value = serde_json::from_str(&read(place.join("example/score.json"))).unwrap();
    assert_eq!(again.to_json(&problem), told);
    // As a reader of the text alone needs it: no place is left, and all that counts is said.
    let page = read(place.join("problem.md"));
    assert_has(&page, &["# rocking-block", "**Start.**", "actuator_force_n", "four phases or more", &pack_version()]);
    let guide = read(root().join("docs/guide/enter-your-tool.md"));
    assert_has(&guide, &[&format!("pack_version = \"{}\"", pack_version())]);
    assert!(!page.contains(['{', '}']), "{page}");
    assert!(read(place.join("score.py")).lines().count() <= 150);
}

/// Changes a column of a table, given its rows as numbers.
fn changed(table: &str, change: impl Fn(&mut Vec<Vec<f64>>)) -> String {
    let (header, rest) = table.split_once('\n').unwrap();
    let mut rows: Vec<Vec<f64>> =
        rest.lines().map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    change(&mut rows);
    let line = |row: &Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    header.to_owned() + "\n" + &rows.iter().map(line).collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn what_is_no_result_of_the_problem_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let place = pack(&shortened("wedge-box", 0.4, 1e-3), folder.path());
    let problem = Problem::read(&place).unwrap();
    let spec = shortened("wedge-box", 0.4, 1e-3);
    let run = simulate(&spec, Bounds::default(), None, StopFlag::never()).unwrap().trajectory;
    let row = &problem.0.rows[0];
    let columns =
        ["time_s", &row.position, &row.velocity, &row.force, &row.received].map(|name| run.index_of(name).unwrap());
    let file = folder.path().join("run.csv");
    write_trace(&file, &run.selected(&columns), None).unwrap();
    let good = read(&file);
    assert_eq!(judge(&file, &problem, None).unwrap().outcome, "completed");
    let each = |change: fn(&mut Vec<f64>)| move |rows: &mut Vec<Vec<f64>>| rows.iter_mut().for_each(change);
    let short = |value: f64| format!("{value:.3e}").parse().unwrap();
    let attacks: Vec<(&str, String, &str)> = vec![
        ("a row is missing", changed(&good, |rows| drop(rows.remove(57))), "no grid"),
        ("the first row is missing", changed(&good, |rows| drop(rows.remove(0))), "must rise from 0"),
        (
            "times of step ends",
            changed(&good, |rows| rows.iter_mut().skip(1).for_each(|row| row[0] += 1e-3)),
            "time_s: ",
        ),
        ("rows twice", changed(&good, |rows| rows.insert(9, rows[9].clone())), "must rise"),
        ("beyond the end", changed(&good, each(|row| row[0] *= 1.1)), "at most 0.4 s"),
        ("mm", changed(&good, each(|row| row[1] *= 1e3)), "begins with"),
        ("mm/s", changed(&good, each(|row| row[2] *= 1e3)), "is not the rate of"),
        ("columns exchanged", changed(&good, each(|row| row.swap(1, 2))), "begins with"),
        ("velocity and force exchanged", changed(&good, each(|row| row.swap(2, 3))), "is not the rate of"),
        ("sign of the velocity", changed(&good, each(|row| row[2] *= -1.0)), "is not the rate of"),
        ("another start", changed(&good, each(|row| row[1] += 1e-4)), "begins with"),
        (
            "four digits",
            changed(&good, |rows| rows.iter_mut().for_each(|row| row[3] = short(row[3]))),
            "six digits or fewer",
        ),
        ("another name", good.replacen("actuator_force_n", "force", 1), "has no column actuator_force_n"),
        ("a name twice", good.replacen("force_to_mechanics_n", "actuator_force_n", 1), "two columns are called"),
        ("a word", good.replacen("\n0.0,", "\nzero,", 1), "time_s = `zero`"),
        ("nothing", "time_s\n".to_owned(), "fewer than two rows"),
    ];
    let python = python();
    for (attack, text, wanted) in attacks {
        assert_ne!(text, good, "{attack}");
        std::fs::write(&file, text).unwrap();
        let said = judge(&file, &problem, None).expect_err(attack).to_string();
        assert!(said.contains(wanted) && !said.contains('\n'), "{attack}: {said}");
        if let Some(python) = &python {
            let said = scored(python, &place, &file).expect_err(attack);
            assert!(said.starts_with("refused: ") && said.lines().count() == 1, "{attack}: {said}");
        }
    }
    // What is a result is scored as what it is.
    let scored = |text: &str, file: &Path| {
        std::fs::write(file, text).unwrap();
        judge(file, &problem, None).unwrap()
    };
    assert_eq!(scored(&changed(&good, |rows| rows.truncate(150)), &file).outcome, "ended-early");
    let nan = changed(&good, |rows| rows[100][3] = f64::NAN);
    assert_eq!(scored(&nan, &file).diverged_at_s, Some(run.row(100)[0]));
    let far = changed(&good, |rows| rows[100][3] = 1e9);
    assert_eq!(scored(&far, &file).outcome, "diverged");
    // The command, and packs of other versions.
    std::fs::write(&file, &good).unwrap();
    let call = |problem: &Path| {
        let mut call = rimbench();
        call.arg("judge").arg(&file).arg("--problem").arg(problem);
        call
    };
    assert_has(&printed(&mut call(&place)), &["wedge-box", "completed", "force error", "of the peak"]);
    let rule = read(place.join("score.json"));
    std::fs::write(place.join("score.json"), rule.replace(&pack_version(), "15.1")).unwrap();
    assert_has(&refused(&mut call(&place)), &["15.1", &pack_version()]);
    assert_has(&refused(&mut call(folder.path())), &["score.json", "cannot be read"]);
}

/// What is done to an entry, and what is said of it.
type Attack = (&'static str, Box<dyn Fn(String) -> String>, &'static str);

/// An entry of some runs of the wedge box in a folder; `edit` changes its text.
fn entry(folder: &Path, edit: impl Fn(String) -> String) -> PathBuf {
    let place = folder.join("entry");
    std::fs::create_dir_all(&place).unwrap();
    let mut runs = String::new();
    for phase in [1.0, 0.25, 0.5, 0.75] {
        let name = format!("{phase}.csv");
        let spec = shortened("wedge-box", 0.4, 1e-3).with(|own| own.phase = phase).unwrap();
        trace(&spec, &place.join(&name));
        let sum = sha256(std::fs::read(place.join(&name)).unwrap());
        runs += &format!(
            "    {{ problem = \"wedge-box\", macro_step_s = 0.001, phase = {phase:?}, file = \"{name}\", sha256 = \"{sum}\" }},\n"
        );
    }
    let text = format!(
        "name = \"mine\"\nclass = \"samples\"\ndivision = \"closed\"\nuses = []\ntool = \"T\"\nversion = \"1\"\nsettings = \"\"\n\
         authors = [\"A\"]\nof_the_benchmark = false\ndate = \"2026-11-28\"\nlicence = \"MIT\"\nmachine = \"m\"\nevidence = \"told\"\n\
         pack_version = \"{}\"\nruns = [\n{runs}]\n",
        pack_version()
    );
    std::fs::write(place.join("entry.toml"), edit(text)).unwrap();
    place
}

#[test]
fn an_entry_is_judged_or_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let packs = folder.path().join("packs");
    pack(&shortened("wedge-box", 0.4, 1e-3), &packs);
    let place = entry(folder.path(), |text| text);
    let call = |place: &Path| {
        let mut call = rimbench();
        call.arg("judge").arg(place).arg("--problems").arg(&packs);
        call
    };
    printed(&mut call(&place));
    let rows = rows_of(place.join("summary.csv"));
    assert_eq!((rows.len(), &*rows[0]["label"], &*rows[0]["completed"]), (1, "mine", "4"));
    std::fs::remove_file(place.join("summary.csv")).unwrap();
    let lines = |text: &str, keep: fn(usize) -> bool| {
        text.lines().enumerate().filter(|(at, _)| keep(*at)).map(|(_, line)| format!("{line}\n")).collect::<String>()
    };
    let attacks: [Attack; 11] = [
        ("another phase", Box::new(|text| text.replace("phase = 0.25", "phase = 0.3")), "0.300000 H"),
        ("another macro step", Box::new(|text| text.replace("0.001, phase = 1.0", "0.003, phase = 1.0")), "phases"),
        ("three phases", Box::new(move |text| lines(&text, |at| at != 15)), "has 3 phases"),
        ("a checksum", Box::new(|text| text.replace("sha256 = \"", "sha256 = \"0")), "sha256"),
        ("pack version", Box::new(|text| text.replace(&pack_version(), "15.1")), "pack_version = 15.1"),
        ("class", Box::new(|text| text.replace("\"samples\"", "\"sample\"")), "unknown class"),
        ("class below use", Box::new(|text| text.replace("uses = []", "uses = [\"states\"]")), "repetition or more"),
        ("a problem", Box::new(|text| text.replace("\"wedge-box\"", "\"wedge\"")), "unknown problem `wedge`"),
        ("twice", Box::new(|text| text.replace("phase = 0.25", "phase = 1.0")), "is there twice"),
        ("a key", Box::new(|text| text.replace("licence", "license")), "license"),
        ("no file", Box::new(|text| text.replace("0.25.csv", "0.26.csv")), "is not there"),
    ];
    for (attack, edit, wanted) in attacks {
        let place = entry(folder.path(), edit);
        let said = refused(&mut call(&place));
        assert!(said.contains(wanted), "{attack}: {said}");
        assert!(!place.join("summary.csv").exists(), "{attack}");
    }
    // A file that was changed, and one without the forces that were received.
    let place = entry(folder.path(), |text| text);
    let file = place.join("1.csv");
    let text = read(&file);
    std::fs::write(&file, text.replace("force_to_mechanics_n", "other_n")).unwrap();
    assert_has(&refused(&mut call(&place)), &["has the checksum"]);
    let sums = [text.clone(), text.replace("force_to_mechanics_n", "other_n")].map(sha256);
    let entry_file = place.join("entry.toml");
    let described = read(&entry_file);
    std::fs::write(&entry_file, described.replace(&sums[0], &sums[1])).unwrap();
    assert_has(&refused(&mut call(&place)), &["force_to_mechanics_n", "closed division"]);
    // In the open division it may be missing, and two entries can be held side by side.
    std::fs::write(&entry_file, read(&entry_file).replace("closed", "open")).unwrap();
    printed(&mut call(&place));
    let both = printed(rimbench().arg("judge").arg(&place).arg(&place));
    assert_has(&both, &["0 of 1 rows moved"]);
    let kept = root().join("results/study/wedge_box");
    let other = root().join("results/study/schemes_crane");
    assert_has(&printed(rimbench().arg("judge").arg(&kept).arg(&kept)), &["0 of"]);
    assert_has(&printed(rimbench().arg("judge").arg(&kept).arg(&other)), &["rows are in one of the two only"]);
}

#[test]
fn our_own_rows_as_entries_of_others_repeat_the_ranking() {
    let folder = tempfile::tempdir().unwrap();
    let catalogue = Catalogue::standard();
    let ranking = Ranking::read(&root().join("experiments/ranking.toml")).unwrap();
    let known = rows_of(root().join("results/ranking/ranking.csv"));
    let mut rows: BTreeMap<String, Vec<SummaryRow>> = BTreeMap::new();
    for file in ranking.experiments() {
        let name = file.strip_prefix(root().join("experiments")).unwrap().with_extension("");
        for row in read_summary(&root().join("results").join(name)).unwrap() {
            let own = rows.entry(row.keys[2].clone()).or_default();
            // One row that was run several ways has the worst of them: an entry has one way.
            assert!(
                row.keys[4].is_empty() || !known.iter().any(|known| known["label"] == row.keys[2]),
                "{:?}",
                row.keys
            );
            own.push(row);
        }
    }
    for row in known.iter().filter(|row| row["by"] == "authors") {
        let own = &rows[&row["label"]];
        let place = folder.path().join("entries").join(row["label"].replace('/', "-"));
        std::fs::create_dir_all(&place).unwrap();
        std::fs::write(place.join("summary.csv"), summary_text(own, false).unwrap()).unwrap();
        let runs = own.iter().flat_map(|row| {
            let [problem, set, _, step, _] = row.keys.clone();
            (0..row.runs).map(move |run| {
                format!(
                    "{{ problem = \"{problem}{set}\", macro_step_s = {step}, phase = 0.{}, outcome = \"failed\" }},\n",
                    run + 1
                )
            })
        });
        let runs: String = runs.collect();
        let tuned: Vec<&str> = row["tuned_on"].split(' ').filter(|case| !case.is_empty()).collect();
        let text = format!(
            "name = \"{}\"\nclass = \"{}\"\ndivision = \"closed\"\ntool = \"rimbench\"\nversion = \"1\"\nsettings = \"\"\nauthors = []\n\
             of_the_benchmark = true\ndate = \"2026-11-28\"\nlicence = \"MIT\"\nmachine = \"any\"\ntuned_on = {tuned:?}\nevidence = \"told\"\n\
             pack_version = \"{}\"\nruns = [\n{runs}]\n",
            row["label"],
            row["class"],
            pack_version()
        );
        std::fs::write(place.join("entry.toml"), text).unwrap();
    }
    let file = folder.path().join("ranking.toml");
    std::fs::write(&file, "question = \"?\"\nentries = [\"entries/*\"]\n").unwrap();
    let out = folder.path().join("out");
    let found = Ranking::read(&file).unwrap().write(&catalogue, &root().join("results"), &out).unwrap();
    assert_eq!(found.notes, [""; 0]);
    let again = rows_of(out.join("ranking.csv"));
    let own: Vec<_> = known.iter().filter(|row| row["by"] == "authors").collect();
    assert_eq!(again.len(), own.len());
    for known in own {
        let again = again.iter().find(|row| row["label"] == known["label"]).unwrap();
        let number = |row: &BTreeMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
        for name in ["score", "score_low", "score_high", "problems", "runs", "failed"] {
            assert_relative_eq!(number(again, name), number(known, name), max_relative = 1e-12);
        }
        assert_eq!(
            (&again["class"], &again["tuned_on"], &again["by"]),
            (&known["class"], &known["tuned_on"], &known["by"])
        );
    }
    // Classes below what is used, and others' names, are refused.
    let place = folder.path().join("entries/zero-order-hold");
    let text = read(place.join("entry.toml"));
    std::fs::write(place.join("entry.toml"), text.replace("evidence", "uses = [\"model\"]\nevidence")).unwrap();
    let mut call = rimbench();
    call.arg("rank").arg(&file).arg("--results").arg(root().join("results")).arg("--out").arg(&out);
    assert_has(&refused(&mut call), &["entry.toml", "class = samples", "model or more"]);
    assert!(Entry::read(&place).is_err() && Packs::read(&place).is_err());
}

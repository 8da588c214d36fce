//! The page of a results folder: what it holds, what it says is missing, how large it may be.

use crate::program::{assert_has, read, refused, rimbench, root, said};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

const EXPERIMENT: &str = "question = \"Which hold is better on the oscillator?\"\n\
    macro_steps_s = [1e-3, 2e-3]\ntrace_every_s = 0.1\n\
    [[cases]]\nname = \"linear-oscillator\"\nduration_s = 1.0\n\
    [[schemes]]\nscheme = \"zero-order-hold\"\n[[schemes]]\nscheme = \"first-order-hold\"\n\
    [[claims]]\nid = \"small\"\nby = \"ours\"\ntext = \"The error is < 1 & small\"\nscheme = \"zero-order-hold\"\n\
    metric = \"position_error_rms_m\"\nexpect = \"<= 1\"\nfinding = \"reproduced\"\n\
    [[claims]]\nid = \"none\"\nby = \"paper\"\ntext = \"There is no error\"\nscheme = \"zero-order-hold\"\n\
    metric = \"position_error_rms_m\"\nexpect = \"<= 0\"\nfinding = \"not-reproduced\"\n";

/// An experiment run in a folder of its own; returns where its results are.
fn results(folder: &Path) -> PathBuf {
    std::fs::create_dir_all(folder.join("mine")).unwrap();
    std::fs::write(folder.join("mine/holds.toml"), EXPERIMENT).unwrap();
    rimbench().current_dir(folder).args(["run", "mine/holds.toml"]).assert().success();
    folder.join("results/mine/holds")
}

fn page(folder: &Path) -> String {
    rimbench().current_dir(folder).args(["report", "."]).assert().success();
    let page = read(folder.join("report.html"));
    assert!(page.len() <= 3_000_000);
    // Self-contained: nothing is fetched from anywhere.
    for fetched in ["src=\"", "@import", "url(http"] {
        assert!(!page.contains(fetched), "{fetched}");
    }
    // The icon is in the page.
    assert!(page.split("<link ").skip(1).all(|link| link.starts_with("rel=\"icon\" href=\"data:")));
    page
}

/// What is missing, as the page says it.
fn missing(page: &str) -> &str {
    page.split("id=\"missing\"").nth(1).and_then(|rest| rest.split("</section>").next()).expect("a section")
}

#[test]
fn a_study_has_a_page_with_its_claims_failures_first() {
    let folder = tempfile::tempdir().unwrap();
    let study = results(folder.path());
    let page = page(&study);
    assert!(page.contains("<strong>0 of 1 sentence of the paper and 1 of all 2 claims reproduce</strong>"));
    let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text} is not in the page"));
    let mark = |kind: &str, id: &str| at(&format!("class=\"mark {kind}\" href=\"#claim-mine-holds-{id}\""));
    assert!(mark("no", "none") < mark("yes", "small"));
    assert!(at("What the paper says") < at("What we say"));
    // Markup of a claim is text.
    assert!(page.contains("The error is &lt; 1 &amp; small") && !page.contains("< 1 & small"));
    assert!(page.contains("id=\"claim-mine-holds-small\"") && page.contains("Which hold is better on the oscillator?"));
    // Where the file of an experiment lies is known of none but those of the project.
    assert!(page.contains("<code>rimbench verify FILE</code>, FILE being that of the experiment mine/holds"));
    assert!(page.contains("<code>rimbench run FILE</code>") && !page.contains("experiments/mine"));
    // What was found before what can be tried; nothing is said of when a claim was written.
    assert!(at("<section id=\"claims\">") < at("<section id=\"try\"") && at("href=\"#claims\">Skip") < at("<header>"));
    assert!(!page.contains("were tuned") && !page.contains("The paper, remade"));
    let said = page.rfind(" of position error rms of zero-order hold is ").unwrap();
    assert!(said > at("<section id=\"claims\">"));
    // Figures come first, each with its claims folded under it; the table of all claims is behind a fold.
    let under = at("<summary>1 of 2 claims reproduce</summary>");
    assert!(at("<figure id=") < under && under < at("<section id=\"claims\">"));
    assert!(at("<section id=\"claims\">") < at("<details class=\"fold\"><summary>What the paper says: 1 claims"));
    // Records are left beside results that have all runs.
    assert!(study.join("records").is_dir() && !missing(&page).contains("recorded"));
    // The folder on this machine is nobody's business.
    assert!(!page.contains(folder.path().to_str().unwrap()));
    assert!(!missing(&page).contains("planned"));
    // The same from its group, and from all results.
    for above in [study.parent().unwrap(), study.ancestors().nth(2).unwrap()] {
        assert!(
            self::page(above).contains("<strong>0 of 1 sentence of the paper and 1 of all 2 claims reproduce</strong>")
        );
    }
}

#[test]
fn a_folder_without_results_is_one_error_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    for (name, wanted) in [
        ("nowhere", "nowhere: is not a folder of results"),
        (".", "holds no results"),
        ("file", "file: is not a folder of results"),
    ] {
        assert_has(&refused(rimbench().current_dir(folder.path()).args(["report", name])), &[wanted]);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn half_a_sweep_failures_alone_and_no_run_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let study = results(folder.path());
    let runs = read(study.join("runs.csv"));
    let rows: Vec<&str> = runs.lines().collect();
    assert_eq!(rows.len(), 5);
    let with = |rows: &[String]| {
        std::fs::write(study.join("runs.csv"), rows.join("\n") + "\n").unwrap();
        page(&study)
    };
    let half: Vec<String> = rows[..3].iter().map(|row| (*row).to_owned()).collect();
    let page = with(&half);
    assert!(
        page.contains("2 runs of 4 planned") && page.contains("2 claims, not checked: ") && !page.contains("No claim")
    );
    let wanted = ["2 of 4 planned runs are there", "claims are not checked", "`rimbench run FILE` goes on from those"];
    assert_has(missing(&page), &wanted);
    // The same from elsewhere names no folder of this machine, and what is not shown is said on the terminal.
    let told = |page: &Path| {
        let told = said(rimbench().current_dir("/").arg("report").arg(page), 0);
        let page = read(page.join("report.html"));
        assert!(!page.contains(folder.path().to_str().unwrap()), "{}", missing(&page));
        told
    };
    assert_has(&told(&study), &["note: mine/holds: 2 of 4 planned runs are there"]);
    let failed: Vec<String> = rows.iter().map(|row| row.replace(",completed,", ",diverged,")).collect();
    assert!(missing(&with(&failed)).contains("no run completed"));
    let page = with(&half[..1]);
    assert!(missing(&page).contains("it holds no run") && page.contains("0 runs of 4 planned"));
    let page = with(&half[..2]);
    assert!(page.contains("1 run in 1 study"));
    std::fs::remove_dir_all(study.join("traces")).unwrap();
    assert!(missing(&self::page(&study)).contains("No traces are stored of: mine/holds"));
    // Neither rows nor files: what is left says so.
    std::fs::write(study.join("runs.csv"), "a,b\n1,2\n").unwrap();
    assert!(missing(&self::page(&study)).contains("its runs cannot be shown"));
    assert_has(&told(&study), &["note: mine/holds: its runs cannot be shown: "]);
    std::fs::remove_file(study.join("runs.csv")).unwrap();
    assert!(missing(&self::page(&study)).contains("its runs cannot be shown"));
}

/// One study of the paper, its experiment as given, with markup wherever a file can have some.
fn hostile(folder: &Path, experiment: &str) -> String {
    let study = folder.join("results/paper/fig2");
    std::fs::create_dir_all(&study).unwrap();
    let write = |name: &str, text: &str| std::fs::write(study.join(name), text).unwrap();
    write("experiment.toml", experiment);
    write(
        "parameters.csv",
        "case,set,parameter,value,unit,source\n\
         wedge-box,,`<script>alert(1)</script>,<b>1</b>,kg,<img src=x onerror=alert(2)>\n\
         wedge-box,,a|b,1,kg,\"[x](javascript:alert(3))|\n\n<script>alert(4)</script>\"\n",
    );
    write("reference.csv", "<script>alert(5)</script>\n");
    write(
        "runs.csv",
        "run_id,label,case,set,scheme,macro_step_s,outcome,reason\n\
         a,<img src=x onerror=alert(6)>,wedge-box,<b>lost</b>,<script>alert(7)</script>,1e-3,completed,</script><script>alert(8)</script>\n",
    );
    let page = page(&folder.join("results"));
    for markup in ["<script>alert", "<img", "href=\"javascript", "<b>"] {
        assert!(!page.contains(markup), "{markup}");
    }
    page
}

#[test]
fn what_stands_in_a_file_is_never_markup_and_the_text_of_the_paper_is_for_its_experiments_alone() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = read(root().join("experiments/paper/fig2.toml"));
    let page = hostile(folder.path(), &shipped);
    assert!(page.contains("&lt;img src=x onerror=alert(2)&gt;") && page.contains("[x](javascript:alert(3))|"));
    // A page with the paper leads to the book, the report, the source and the article on the method.
    for link in ["../docs/README.md", "paper/paper.pdf", "../README.md", "https://asmedigitalcollection.asme.org/"] {
        assert!(page.contains(&format!("<a href=\"{link}")), "{link}");
    }
    // One experiment of the paper: its text, and in place of the others why they are not there.
    assert!(page.contains("The paper, remade") && page.contains("rimbench run experiments/paper/fig2.toml"));
    for other in ["fig1", "phases", "convergence"] {
        assert!(page.contains(&format!("Not shown: no results of paper/{other}.")), "{other}");
    }
    assert!(page.contains("figure fig2: "), "{}", missing(&page));
    let page = hostile(folder.path(), &format!("{shipped}\n# another\n"));
    assert!(!page.contains("The paper, remade") && !page.contains("reduced interface model</em>"));
    assert!(!page.contains("figure fig2: "), "{}", missing(&page));
    assert!(missing(&page).contains("another than experiments/paper/fig2.toml"), "{}", missing(&page));
}

/// What is kept in the project: medians, claims and figures, and no rows.
#[test]
fn a_page_of_a_fresh_checkout_shows_every_kept_claim_figure_and_summary() {
    let folder = tempfile::tempdir().unwrap();
    let listed = Command::new("git").current_dir(root()).args(["ls-files", "results", "experiments", "paper"]).output();
    let listed = String::from_utf8(listed.unwrap().stdout).unwrap();
    let kept: Vec<&str> = listed.lines().filter(|file| root().join(file).is_file()).collect();
    for file in &kept {
        std::fs::create_dir_all(folder.path().join(file).parent().unwrap()).unwrap();
        std::fs::copy(root().join(file), folder.path().join(file)).unwrap();
    }
    let told = said(rimbench().current_dir(folder.path()).arg("report"), 0);
    let page = read(folder.path().join("results/report.html"));
    assert!(page.len() <= 3_000_000, "{}", page.len());
    assert!(!page.contains("(os error") && !told.contains("(os error"), "{told}");
    assert!(!page.contains("not checked") && !page.contains("is not drawn"), "{told}");
    let (mut studies, mut figures, mut claims) = (0, 0, 0);
    for file in kept {
        let parts: Vec<&str> = file.split('/').collect();
        let ["results", group, name, rest @ ..] = &parts[..] else { continue };
        let anchor = format!("{group}-{name}").replace('_', "-");
        match rest {
            ["digest.toml"] => {
                studies += 1;
                assert!(page.contains(&format!("id=\"study-{anchor}\"")), "{file}");
                let rows = root().join(format!("results/{group}/{name}/runs.csv")).exists();
                assert!(rows || page.contains(&format!("data-study=\"study-{anchor}\"")), "{file}");
                assert!(page.contains(&format!("<code>rimbench run experiments/{group}/{name}.toml</code>")), "{file}");
            }
            ["figures", figure] if figure.ends_with(".svg") && !figure.contains("moving") => {
                let id = figure.trim_end_matches(".svg");
                // Perhaps of a study without a digest, as those about performance.
                figures += usize::from(page.contains(&format!("id=\"figure-{id}\"")));
            }
            ["claims.csv"] => {
                let table = read(root().join(file));
                let mut lines = csv::Reader::from_reader(table.as_bytes());
                let column = lines.headers().unwrap().iter().position(|name| name == "id").unwrap();
                for row in lines.records() {
                    let id = row.unwrap()[column].replace(|c: char| !c.is_ascii_alphanumeric(), "-");
                    claims += 1;
                    assert!(
                        page.contains(&format!("id=\"claim-{}-{id}\"", anchor.trim_start_matches("study-"))),
                        "{file}: {id}"
                    );
                }
            }
            _ => {}
        }
    }
    assert!(studies > 25 && figures > 25 && claims > 200, "{studies} studies, {figures} figures, {claims} claims");
}

/// One bound for "stays down" in metrics, claims and page.
#[test]
fn what_stays_down_is_the_same_for_claims_and_page() {
    use rimbench::metrics::{STAYS_DOWN_M, USABLE};
    let experiment: toml::Table = read(root().join("experiments/paper/fig1.toml")).parse().unwrap();
    let claims = experiment["claims"].as_array().unwrap();
    let bounds: Vec<f64> = claims
        .iter()
        .filter(|claim| claim["id"].as_str().unwrap().starts_with("box-stays-down"))
        .map(|claim| claim["expect"].as_str().unwrap().strip_prefix("<= ").unwrap().parse().unwrap())
        .collect();
    assert!(bounds.len() == 2 && bounds.iter().all(|bound| *bound == STAYS_DOWN_M), "{bounds:?}");
    let folder = tempfile::tempdir().unwrap();
    let page = page(&results(folder.path()));
    let known = page.split("id=\"known\">").nth(1).and_then(|rest| rest.split("</script>").next()).unwrap();
    let known: serde_json::Value = serde_json::from_str(known).unwrap();
    assert_eq!((known["stays_down_m"].as_f64(), known["usable"].as_f64()), (Some(STAYS_DOWN_M), Some(USABLE)));
    assert_eq!(known["schemes"]["rim-nonsmooth-gap"]["name"], "gap tracking");
}

/// So many runs do not fit with all that is known of them.
#[test]
fn a_page_of_very_many_runs_is_no_larger_and_says_what_it_leaves_out() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("results/mine/many");
    std::fs::create_dir_all(&study).unwrap();
    let mut runs = String::from(
        "run_id,label,case,set,scheme,macro_step_s,phase,outcome,reason,force_error_rms_n,position_error_rms_m,work_sent_j\n",
    );
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state
    };
    for _ in 0..60_000 {
        let [id, force, position, work] = [next(), next(), next(), next()];
        let share = |bits: u64| (bits >> 11) as f64 / (1_u64 << 53) as f64;
        let [force, position, work] = [force, position, work].map(share);
        let _ = writeln!(runs, "{id:016x},a,box,,a,0.001,1.0,completed,,{force},{position},{work}");
    }
    std::fs::write(study.join("runs.csv"), runs).unwrap();
    assert_has(&said(rimbench().current_dir(folder.path()).arg("report"), 0), &["note: left out: "]);
    let page = read(folder.path().join("results/report.html"));
    assert!(page.len() <= 3_000_000, "{}", page.len());
    assert!(missing(&page).contains("so that the page is no larger than 3 MB"), "{}", missing(&page));
    assert!(page.contains("60000 runs in 1 study"));
}

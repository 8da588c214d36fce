//! The ranking: what the command writes of an experiment, and that the page says what the committed tables say.

use crate::program::{assert_has, printed, read, rimbench, root, rows_of};
use crate::support::{largest, smallest};
use std::collections::BTreeMap;

#[test]
fn rows_are_ranked_by_what_they_need_to_know_and_a_chosen_gain_counts_as_tuned() {
    let folder = tempfile::tempdir().unwrap();
    let text = "question = \"?\"\nmacro_steps_s = [1e-3, 2e-3]\nphases = 2\nduration_s = 0.5\n[[cases]]\nname = \"bouncing-ball\"\n\
                [[schemes]]\nscheme = \"zero-order-hold\"\n[[schemes]]\nscheme = \"rim-nonsmooth-gap\"\n\
                [[schemes]]\nscheme = \"nepce\"\ngain = 0.25\n";
    std::fs::create_dir(folder.path().join("own")).unwrap();
    std::fs::write(folder.path().join("own/sweep.toml"), text).unwrap();
    std::fs::write(folder.path().join("mine.toml"), "question = \"?\"\nexperiments = [\"own/sweep.toml\"]\n").unwrap();
    let called = |words: &[&str]| printed(rimbench().current_dir(folder.path()).args(words));
    called(&["run", "own/sweep.toml"]);
    let said = called(&["report", "--ranking=mine.toml"]);
    assert_has(&said, &["samples, tuned:", "3 rows over 4 problems of 1 cases"]);
    let table = read(folder.path().join("results/ranking/ranking.csv"));
    let classes: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let classes: Vec<[&str; 3]> = classes.iter().map(|row| [row[0], row[1], row[4]]).collect();
    let expected =
        [["samples", "", "zero-order-hold"], ["samples", "bouncing-ball", "nepce"], ["model", "", "rim-nonsmooth-gap"]];
    assert_eq!(classes, expected, "{table}");
}

fn committed(name: &str) -> Vec<BTreeMap<String, String>> {
    rows_of(root().join("results/ranking").join(name))
}

/// Words between backticks.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

#[test]
fn the_table_of_the_ranking_is_that_of_its_rows() {
    let rows = committed("ranking.csv");
    let score = |row: &BTreeMap<String, String>| row["score"].parse::<f64>().unwrap() * 100.0;
    let page = read(root().join("docs/results/ranking.md"));
    let table =
        page.lines().skip_while(|line| !line.starts_with("| class | row |")).take_while(|line| line.starts_with('|'));
    let (mut class, mut seen) = (String::new(), 0);
    for line in table.skip(2) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if let Some(named) = quoted(cells[0]).first() {
            class = (*named).to_owned();
        }
        let named: Vec<_> = quoted(cells[1])
            .into_iter()
            .map(|label| {
                let row = rows.iter().find(|row| row["class"] == class && row["label"] == label);
                row.unwrap_or_else(|| panic!("{line}: no {label} in {class}"))
            })
            .collect();
        assert!(!named.is_empty(), "{line}");
        seen += named.len();
        for row in &named {
            let [first, last] = [&row["rank"], &row["rank_last"]];
            let rank = if first == last { first.clone() } else { format!("{first}–{last}") };
            assert_eq!(cells[2], rank, "{line}: {}", row["label"]);
        }
        if cells[1].ends_with("the last") {
            let most = rows.iter().filter(|row| row["class"] == class).map(score).fold(0.0, f64::max);
            assert_eq!(named.iter().map(|row| score(row)).fold(0.0, f64::max), most, "{line}");
        }
        if let Some((_, counts)) = cells[1].split_once("`: ").filter(|(_, counts)| counts.contains("skipped")) {
            assert!(counts.starts_with(&format!("{} of {} ", named[0]["skipped"], named[0]["problems"])), "{line}");
        }
        let written: Vec<&str> = cells[3].trim_end_matches(" %").split(" to ").collect();
        let scores: Vec<f64> = named.iter().map(|row| score(row)).collect();
        let bounds = [smallest(scores.iter().copied()), largest(scores)];
        for (text, found) in [(written[0], bounds[0]), (written[written.len() - 1], bounds[1])] {
            let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32);
            let off = (text.parse::<f64>().unwrap() - found).abs();
            assert!(off <= 0.501 * 10_f64.powi(-decimals), "{line}: {found} %");
        }
    }
    assert!(seen >= 20, "only {seen} rows found");
}

#[test]
fn the_findings_of_the_ranking_follow_from_its_rows_and_claims() {
    let rows = committed("ranking.csv");
    let page = read(root().join("docs/results/ranking.md"));
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let of_class = |class: &str| -> Vec<(String, f64, usize)> {
        let own = rows.iter().filter(|row| row["class"] == class && row["tuned_on"].is_empty());
        let mut own: Vec<_> = own
            .map(|row| (row["label"].clone(), row["score"].parse().unwrap(), row["failed"].parse().unwrap()))
            .collect();
        own.sort_by(|a: &(String, f64, usize), b| a.1.total_cmp(&b.1));
        own
    };
    let (samples, models) = (of_class("samples"), of_class("model"));
    let (best, last) = (&samples[0], &samples[samples.len() - 1]);
    let ahead = models.iter().filter(|row| row.1 < best.1).count();
    let behind_most = |error: f64| 2 * samples.iter().filter(|row| row.1 < error).count() > samples.len();
    let worse: Vec<String> = models.iter().filter(|row| behind_most(row.1)).map(|row| format!("`{}`", row.0)).collect();
    let (smooth, others) = worse.split_last().unwrap();
    let paper = models.iter().find(|row| row.0 == "rim-nonsmooth").unwrap();
    let problems = &rows[0]["problems"];
    assert_eq!(smooth, "`rim-smooth`");
    for wanted in [
        format!("{problems} problems of"),
        format!("has {:.1} times its error", last.1 / best.1),
        format!("only {ahead} of the {} rows with a model have less error", models.len()),
        format!("needs samples only ({:.1} %); the paper's is one of them ({:.1} %)", best.1 * 100.0, paper.1 * 100.0),
        format!(
            "most of the {} rows with samples are {}: {} and {smooth}",
            samples.len(),
            worse.len(),
            others.join(", ")
        ),
        format!("fails in {} of {problems} problems", models[models.len() - 1].2),
        format!("fails in {} problems or more", samples.iter().map(|row| row.2).min().unwrap()),
    ] {
        assert!(page.contains(&wanted), "{wanted}");
    }
    assert!(paper.1 < best.1);
    // A ratio with its interval is that of a claim.
    let claims: Vec<String> = committed("claims.csv")
        .iter()
        .map(|claim| {
            let [measured, low, high] = ["measured", "low", "high"].map(|name| claim[name].parse::<f64>().unwrap());
            assert_eq!(claim["verdict"], "reproduced", "{}", claim["id"]);
            format!("({measured:.2} [{low:.2}, {high:.2}])")
        })
        .collect();
    assert_eq!(claims.len(), 7, "the page says seven");
    let quoted: Vec<&str> = page
        .match_indices("(0.")
        .map(|(place, _)| &page[place..=place + page[place..].find(')').unwrap()])
        .filter(|text| text.contains('['))
        .collect();
    assert!(quoted.len() >= 4, "{quoted:?}");
    for text in quoted {
        assert!(claims.iter().any(|claim| claim == text), "{text}: {claims:?}");
    }
}

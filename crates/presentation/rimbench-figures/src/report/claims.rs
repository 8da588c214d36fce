//! The claims in the page: a mark each in the head, and in prose with what was measured against its bound.

use super::store::Study;
use super::{Report, folded};
use crate::chart::Scale;
use crate::claims_table;
use crate::number::{TIED, counted, with_digits};
use crate::scale::AxisMap;
use crate::style::labels_in_words;
use crate::vector::escaped;
use rimbench_cases::parameter::without_unit;
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_results::claims::{CheckedClaim, Claimant, Verdict, claims_score, digits_of, tally};
use std::fmt::Write;

/// The class of a verdict, its sign, and what it is called.
fn shown(verdict: Verdict) -> [&'static str; 3] {
    match verdict {
        Verdict::NotReproduced => ["no", "✗", "not reproduced"],
        Verdict::NotMeasured => ["open", "–", "not measured"],
        Verdict::Reproduced => ["yes", "✓", "reproduced"],
    }
}

/// Who claims, as the head counts it, and what the table of it is called.
const CLAIMANTS: [(Claimant, &str, &str); 3] = [
    (Claimant::Paper, "the paper’s", "What the paper says"),
    (Claimant::PaperOurBound, "the paper’s by a bound of ours", "What the paper says in words, by bounds of ours"),
    (Claimant::Ours, "ours", "What we say"),
];

fn anchor(claim: &CheckedClaim, study: &Study) -> String {
    let id = claim.id.replace(|c: char| !c.is_ascii_alphanumeric(), "-");
    format!("claim-{}-{id}", study.anchor().trim_start_matches("study-"))
}

/// The measured value against its bound, drawn: shaded where the claim holds.
fn drawn(claim: &CheckedClaim) -> String {
    const WIDTH: f64 = 180.0;
    let Some((at_least, bound)) = claim.bound() else { return String::new() };
    let values = [Some(bound), claim.measured, claim.low, claim.high];
    let values = || values.into_iter().flatten().filter(|value| value.is_finite());
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    // Ratios on a logarithmic line, everything else on a linear one with its zero.
    let logarithmic = low > 0.0 && high / low > 20.0;
    let (low, high) = match (logarithmic, low < high) {
        (true, _) => (low / 2.0, high * 2.0),
        (false, true) => (low.min(0.0) - 0.08 * (high - low), high.max(0.0) + 0.08 * (high - low)),
        (false, false) => (low.min(0.0) - 0.5 * low.abs() - 0.1, low.max(0.0) + 0.5 * low.abs() + 0.1),
    };
    let scale = if logarithmic { Scale::Log10 } else { Scale::Linear };
    let line = AxisMap { scale, low, high, start: 0.0, end: WIDTH };
    let place = |value: f64| line.position(value).unwrap_or_default().clamp(0.0, WIDTH);
    let at = place(bound);
    let (from, to) = if at_least { (at, WIDTH) } else { (0.0, at) };
    let mut svg = format!(
        "<svg class=\"bound\" viewBox=\"0 0 180 18\" width=\"180\" height=\"18\" aria-hidden=\"true\">\
         <path class=\"ok\" d=\"M{from:.1} 3H{to:.1}V15H{from:.1}z\"/><path class=\"axis\" d=\"M0 9H180\"/>\
         <path class=\"limit\" d=\"M{at:.1} 1V17\"/>"
    );
    if let Some([from, to]) = claim.interval().map(|ends| ends.map(place)) {
        let _ = write!(svg, "<path class=\"interval\" d=\"M{from:.1} 9H{to:.1}\"/>");
    }
    match claim.measured {
        Some(measured) if measured.is_finite() => {
            let _ = write!(svg, "<circle class=\"dot\" cx=\"{:.1}\" cy=\"9\" r=\"4\"/>", place(measured));
        }
        Some(measured) if measured.is_infinite() => svg.push_str("<path class=\"dot\" d=\"M170 5L178 9L170 13z\"/>"),
        _ => {}
    }
    svg + "</svg>"
}

/// One row.
fn row(claim: &CheckedClaim, study: &Study, place: [usize; 2]) -> String {
    let anchor = anchor(claim, study);
    let mut measured = escaped(&labels_in_words(&measured(claim, 3)));
    if let Some(value) = claim.without_exact.filter(|value| value.is_finite()) {
        let value = claims_table::shown(claim, value, 3);
        let _ = write!(measured, "<br><span class=\"soft\">{value} without exact models</span>");
    }
    let replaced = match claim.superseded.as_str() {
        "" => String::new(),
        reason => format!("<br><span class=\"soft\">Replaced by another claim: {}</span>", escaped(reason)),
    };
    let figures = study.figures.iter().filter(|(_, _, made)| made.is_ok());
    let mut links: Vec<String> = figures.map(|(id, _, _)| link_to(id)).collect();
    links.insert(0, format!("<a href=\"#{}\">study</a>", study.anchor()));
    // Without a script the study is what there is of its runs.
    let runs = format!(
        "<button type=\"button\" class=\"show-runs\" data-claim=\"{},{}\" hidden>{}</button>",
        place[0],
        place[1],
        if claim.run_ids.len() == 1 { "1 run".to_owned() } else { format!("{} runs", claim.run_ids.len()) }
    );
    let command = study.command("verify");
    let crosses = match (claim.bound(), claim.low, claim.high) {
        (Some((_, bound)), Some(low), Some(high)) if low < bound && bound < high => {
            "<br><span class=\"soft\">its interval crosses the bound</span>"
        }
        _ => "",
    };
    let [class, sign, word] = shown(claim.verdict);
    format!(
        "<tr id=\"{anchor}\" class=\"{class}\"><td><span class=\"verdict {class}\"><span aria-hidden=\"true\">{sign}</span> {word}</span>{crosses}</td>\
         <td>{text}{replaced}<details><summary>Check it</summary>{command}</details></td>\
         <td>{drawn}{measured}</td>\
         <td class=\"links\">{runs} {links}</td></tr>\n",
        text = escaped(&labels_in_words(&claim.text)),
        drawn = drawn(claim),
        links = links.join(" "),
    )
}
/// A link to a figure.
pub(super) fn link_to(id: &str) -> String {
    format!("<a href=\"#figure-{id}\">figure {}</a>", escaped(&id.replace('_', " ")))
}

/// The claims of a study that count, folded under its figure, a line each, failures first.
pub(super) fn under(study: &Study) -> String {
    let mut own: Vec<&CheckedClaim> = study.claims.iter().filter(|claim| claim.counts()).collect();
    if own.is_empty() {
        return String::new();
    }
    own.sort_by_key(|claim| claim.verdict);
    let good = own.iter().filter(|claim| claim.verdict == Verdict::Reproduced).count();
    let line = |claim: &&CheckedClaim| {
        let [class, sign, word] = shown(claim.verdict);
        format!(
            "<li><span class=\"verdict {class}\"><span aria-hidden=\"true\">{sign}</span> {word}</span> <a href=\"#{}\">{}</a> \
             <span class=\"soft\">{}</span></li>\n",
            anchor(claim, study),
            escaped(&labels_in_words(&claim.text)),
            escaped(&labels_in_words(&measured(claim, 2))),
        )
    };
    let head = format!("{good} of {} claims reproduce", own.len());
    folded(true, &head, &format!("<ul class=\"said\">\n{}</ul>\n", own.iter().map(line).collect::<String>()))
}

/// Says what was measured and what was expected, in a sentence with at least so many digits; of runs that fail or
/// complete, how many.
pub fn measured(claim: &CheckedClaim, least: usize) -> String {
    if let Some(said) = counted_runs(claim) {
        return said;
    }
    let (quantity, unit) = words(&claim.quantity);
    let shown = |value: f64| with_digits(value, unit, claim.digits(value, least)).replace(TIED, " ");
    let expected = claim.bound().map_or_else(
        || claim.expected.clone(),
        |(at_least, bound)| {
            let bound = with_digits(bound, unit, digits_of(bound)).replace(TIED, " ");
            format!("{} {bound}", if at_least { "≥" } else { "≤" })
        },
    );
    let Some(value) = claim.measured else {
        return format!("{quantity} is not known, expected {expected}");
    };
    let interval =
        claim.interval().map_or_else(String::new, |[low, high]| format!(" [{}, {}]", shown(low), shown(high)));
    format!("{quantity} is {}{interval}, expected {expected}", shown(value))
}

/// How many runs fail or complete, where that is what is claimed of all, of most or of none.
fn counted_runs(claim: &CheckedClaim) -> Option<String> {
    let (statistic, rest) = claim.quantity.split_once(" of ")?;
    let (metric, whose) = rest.split_once(" of ")?;
    let (many, verb) = match metric {
        "failed" => (claim.failed, "fail"),
        "completed" => (claim.runs.checked_sub(claim.failed)?, "complete"),
        _ => return None,
    };
    let expected = match (statistic, claim.bound()?) {
        ("min", (true, 1.0)) => "all",
        ("median", (true, 1.0)) if claim.runs == 1 => "all",
        ("median", (true, 1.0)) => "most",
        ("max", (false, 0.0)) => "none",
        _ => return None,
    };
    claim.measured?;
    let ending = if claim.runs == 1 { "s" } else { "" };
    Some(format!("{many} of {} of {whose} {verb}{ending}, expected {expected}", counted(claim.runs, "run")))
}

/// A quantity in words with its unit: `median of force_error_rms_n of x` is `median of force error rms of x`, N.
pub fn words(quantity: &str) -> (String, &'static str) {
    let mut unit = "";
    let order = quantity.starts_with("order ") || quantity.contains(" over ") || quantity.contains("relative");
    let spoken: Vec<String> = quantity
        .split(' ')
        .map(|word| match column_in_words(word) {
            Some((words, found)) => {
                unit = if order { "" } else { found };
                words
            }
            None => word.to_owned(),
        })
        .collect();
    (spoken.join(" "), unit)
}

/// A column's name as words, and its unit; none for what is no column's name.
pub(super) fn column_in_words(name: &str) -> Option<(String, &'static str)> {
    if !name.contains('_') || !name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_') {
        return None;
    }
    let (stem, unit) = name.strip_suffix("_per_s").map_or_else(|| without_unit(name), |stem| (stem, "1/s"));
    let stem = if stem == "failed_at" { "time of failure" } else { stem.trim_end_matches("_at") };
    Some((stem.replace('_', " "), unit.trim_matches('-')))
}

/// The marks of the head, failures first; each leads to its claim.
pub(super) fn marks(report: &Report<'_>) -> String {
    let mut claims: Vec<(&Study, &CheckedClaim)> = claims(report).filter(|(_, claim)| claim.counts()).collect();
    let unchecked = unchecked(report);
    if claims.is_empty() && unchecked.is_empty() {
        return String::from("<p class=\"score\">No claims are recorded for these results.</p>\n");
    }
    if claims.is_empty() {
        return unchecked;
    }
    claims.sort_by_key(|(_, claim)| claim.verdict);
    let parts = CLAIMANTS.map(|(by, name, _)| match tally(self::claims(report).map(|(_, claim)| claim), Some(by)) {
        [_, 0] => String::new(),
        [good, all] => format!("{name} {good} of {all}"),
    });
    // They are in the table, and elsewhere they count.
    let count = |is: fn(&CheckedClaim) -> bool| self::claims(report).filter(|(_, claim)| is(claim)).count();
    let superseded = count(|claim| !claim.superseded.is_empty());
    let variants = count(|claim| claim.superseded.is_empty() && !claim.variant_of.is_empty());
    let more = [(variants, "variants"), (superseded, "superseded")]
        .map(|(count, what)| if count == 0 { String::new() } else { format!("{count} more are {what}") });
    let parts: Vec<&String> = parts.iter().chain(&more).filter(|part| !part.is_empty()).collect();
    let mut text = format!(
        "<p class=\"score\"><strong>{}</strong> <span class=\"soft\">({})</span></p>\n<ul class=\"marks\" aria-label=\"Claims, failures first\">",
        score(report),
        parts.into_iter().cloned().collect::<Vec<_>>().join("; ")
    );
    // Of many the table says which.
    for (study, claim) in claims.into_iter().filter(|_| !report.is_long()) {
        let [class, sign, word] = shown(claim.verdict);
        let (anchor, said) = (anchor(claim, study), escaped(&labels_in_words(&claim.text)));
        let _ = write!(
            text,
            "<li><a class=\"mark {class}\" href=\"#{anchor}\" title=\"{said}\" aria-label=\"{word}: {said}\">{sign}</a></li>"
        );
    }
    text + "</ul>\n" + &unchecked
}

/// How many of the claims reproduce, the paper's first.
pub(super) fn score(report: &Report<'_>) -> String {
    claims_score(claims(report).map(|(_, claim)| claim))
}

/// The same where there is room for the paper's sentences alone, if there are any.
pub(super) fn short_score(report: &Report<'_>) -> String {
    match tally(claims(report).map(|(_, claim)| claim), Some(Claimant::Paper)) {
        [_, 0] => score(report),
        [good, all] => format!("{good} of {all} sentences reproduce"),
    }
}

/// Claims that could not be checked, a line for each study that has some.
fn unchecked(report: &Report<'_>) -> String {
    let studies = report.studies.iter().filter_map(|study| Some((study, study.unchecked.as_ref()?)));
    let line = |(study, (count, reason)): (&Study, &(Option<usize>, String))| {
        let claims = match count {
            Some(1) => "1 claim, not checked".to_owned(),
            Some(count) => format!("{count} claims, not checked"),
            None => "Claims are not known".to_owned(),
        };
        let (anchor, name, reason) = (study.anchor(), escaped(&study.name), escaped(reason));
        format!(
            "<p class=\"score\">{claims}: {reason}. This program is of numerics version \
             {NUMERICS_VERSION} <span class=\"soft\">(<a href=\"#{anchor}\">{name}</a>)</span></p>\n"
        )
    };
    studies.map(line).collect()
}

fn claims<'a>(report: &'a Report<'_>) -> impl Iterator<Item = (&'a Study, &'a CheckedClaim)> + Clone {
    report.studies.iter().flat_map(|study| study.claims.iter().map(move |claim| (study, claim)))
}

/// The section of the claims.
pub(super) fn section(report: &Report<'_>) -> String {
    if claims(report).next().is_none() {
        return String::new();
    }
    let mut text = String::from(
        "<section id=\"claims\"><h2>Claims</h2>\n<p>A verdict compares a measured quantity with the bound that the experiment’s \
         file gives. Claims added after the first run are marked in the experiment’s file. In each drawing the claim holds in the shaded part, \
         the upright line is its bound, the dot what was measured, the thin bar its 95 % interval where it has one.</p>\n",
    );
    for (by, _, title) in CLAIMANTS {
        let mut rows = Vec::new();
        for (index, study) in report.studies.iter().enumerate() {
            for (number, claim) in study.claims.iter().enumerate().filter(|(_, claim)| claim.by == by) {
                let verdict = claim.counts().then_some(claim.verdict);
                rows.push((verdict.is_none(), verdict, row(claim, study, [index, number])));
            }
        }
        if rows.is_empty() {
            continue;
        }
        rows.sort_by_key(|(replaced, verdict, _)| (*replaced, *verdict));
        let count = rows.len();
        let rows: String = rows.into_iter().map(|(.., row)| row).collect();
        let table = format!(
            "<div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{title}\"><table class=\"claims\"><thead><tr><th>Verdict</th><th>Claim</th><th>Measured against its bound</th><th>Leads to</th></tr></thead><tbody>\n{rows}</tbody></table></div>\n"
        );
        let words = format!("{title}: {count} claims, failures first");
        let _ = write!(text, "<h3>{title}</h3>\n{}", folded(true, &words, &table));
    }
    text + "</section>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_become_words_with_their_units() {
        assert_eq!(
            words("median of force_error_rms_n of rim-smooth/1mm"),
            ("median of force error rms of rim-smooth/1mm".to_owned(), "N")
        );
        assert_eq!(words("order of position_error_rms_m of a"), ("order of position error rms of a".to_owned(), ""));
        assert_eq!(column_in_words("velocity_error_rms_m_s"), Some(("velocity error rms".to_owned(), "m/s")));
        assert_eq!(column_in_words("diverged"), None);
    }

    #[test]
    fn the_bound_is_drawn_where_the_claim_holds() {
        let mut claim = CheckedClaim {
            experiment: "mine".to_owned(),
            id: "a".to_owned(),
            by: Claimant::Paper,
            text: String::new(),
            quantity: String::new(),
            measured: Some(1.0),
            low: None,
            high: None,
            without_exact: None,
            expected: "≥ 2".to_owned(),
            verdict: Verdict::NotReproduced,
            finding: Verdict::NotReproduced,
            superseded: String::new(),
            variant_of: String::new(),
            numbers_known: false,
            runs: 0,
            failed: 0,
            run_ids: Vec::new(),
        };
        let shaded = |claim: &CheckedClaim| {
            let drawn = drawn(claim);
            let path = drawn
                .split("class=\"ok\" d=\"M")
                .nth(1)
                .unwrap()
                .split(['H', ' ', 'V'])
                .map(|n| n.parse::<f64>().unwrap_or(f64::NAN))
                .collect::<Vec<_>>();
            let dot: f64 = drawn.split("cx=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
            (path[0]..path[2]).contains(&dot)
        };
        assert!(!shaded(&claim));
        claim.measured = Some(3000.0);
        assert!(shaded(&claim));
        claim.expected = "≤ 2".to_owned();
        assert!(!shaded(&claim));
        // A verdict that the interval does not bear out says so; one of either side of the bound does not.
        let study = Study::read(std::path::Path::new("nowhere/mine/<b>"));
        for (interval, crosses) in
            [([Some(1.0), Some(3000.0)], true), ([Some(2.5), Some(3000.0)], false), ([None; 2], false)]
        {
            [claim.low, claim.high] = interval;
            let row = row(&claim, &study, [0, 0]);
            assert_eq!(row.contains("crosses the bound"), crosses, "{row}");
            assert!(row.contains("experiment mine/&lt;b&gt;") && !row.contains("<b>"), "{row}");
        }
        // What is told from its bound by the fourth digit has four.
        claim = CheckedClaim { measured: Some(0.89952), expected: "≥ 0.9".to_owned(), ..claim };
        assert!(
            row(&claim, &study, [0, 0]).contains("is 0.8995 ") || row(&claim, &study, [0, 0]).contains("is 0.8995,"),
            "{}",
            row(&claim, &study, [0, 0])
        );
        claim.measured = Some(0.8952);
        let study = Study { claims: vec![claim.clone()], ..study };
        assert!(under(&study).contains("is 0.895, expected ≥ 0.9"), "{}", under(&study));
        assert!(claims_table::claims_markdown(&[claim.clone()]).contains("| 0.895 | ≥ 0.9 |"));
        // The name of a scheme does not end twice.
        assert_eq!(
            labels_in_words("it agrees with the monolithic solution, and monolithic beside rim-smooth (model)"),
            "It agrees with the monolithic solution, and monolithic solution beside smooth model (model)"
        );
        // Runs are counted, lengths have units that a person would use, schemes have their names.
        let of = |quantity: &str, measured: f64, expected: &str| {
            let [quantity, expected] = [quantity, expected].map(str::to_owned);
            labels_in_words(&super::measured(
                &CheckedClaim {
                    quantity,
                    measured: Some(measured),
                    expected,
                    runs: 1,
                    low: None,
                    high: None,
                    ..claim.clone()
                },
                3,
            ))
        };
        assert_eq!(
            of("median of failed of rim-smooth/1um", 0.0, "≥ 1"),
            "0 of 1 run of smooth model, margin 1 µm fails, expected all"
        );
        assert_eq!(
            of("median of lift_off_height_m of rim-nonsmooth", 5.007e-5, "≤ 0.00001"),
            "Median of lift off height of non-smooth model is 50.1 µm, expected ≤ 10 µm"
        );
    }
}

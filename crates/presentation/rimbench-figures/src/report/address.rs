//! What of a study the simulator of the page can show: the address of its state.

use rimbench_cases::cases::offered_steps_ms;
use rimbench_results::run_table::{Run, RunTable};
use rimbench_results::selection::Runs;
use rimbench_runs::RunRequest;
use rimbench_runs::catalogue::Catalogue;

/// Finds the address at which the page's simulator shows runs of the first two of these labels that it can show, at the
/// middle of their macro steps; all labels if none are given. What it shows there are these runs to the bit: their
/// identifiers are the same.
pub fn address(catalogue: &Catalogue, table: &RunTable, labels: &[String]) -> Option<String> {
    let all = Runs::of(table);
    let shown = |label: &str, beside: Option<&Shown>| {
        let mut rows = all.of_label(label).rows().to_vec();
        rows.sort_by(|&one, &other| all.macro_step(one).total_cmp(&all.macro_step(other)));
        let later = rows.split_off(rows.len() / 2);
        let shown =
            later.into_iter().chain(rows.into_iter().rev()).filter_map(|row| Shown::of(catalogue, table, all.run(row)));
        shown.into_iter().find(|own| beside.is_none_or(|beside| own.place == beside.place))
    };
    let named = if labels.is_empty() { all.labels(&[]) } else { labels.iter().map(String::as_str).collect() };
    let mut labels = named.into_iter();
    let first = labels.find_map(|label| shown(label, None))?;
    let second = labels.find_map(|label| shown(label, Some(&first)).filter(|own| own.side != first.side));
    let sides = [("a", Some(first.side)), ("b", second.map(|second| second.side))];
    let sides = sides.into_iter().filter_map(|(side, own)| Some((side, own?)));
    let sides = sides.map(|(side, [scheme, contacts, late])| {
        let options = [("contacts", contacts), ("late", late)].into_iter().filter(|(_, value)| !value.is_empty());
        options.fold(format!("&{side}={scheme}"), |text, (key, value)| format!("{text}&{key}-{side}={value}"))
    });
    Some(first.place + &sides.collect::<String>())
}

/// A run as the simulator's address has it.
struct Shown {
    /// Case, macro step, age of the samples and phase, which both sides share.
    place: String,
    /// Scheme, what it takes for closed contacts and what it makes of late samples, each if that is not its own.
    side: [String; 3],
}

impl Shown {
    fn of(catalogue: &Catalogue, table: &RunTable, run: &Run) -> Option<Self> {
        let text = |name: &str| table.setting(name).map_or("", |place| &*run.settings[place]);
        let case = catalogue.case(run.problem()[0]).ok()?;
        (case.drawing)(&case.default_parameters())?;
        let step_s = run.macro_step_s;
        let offered = offered_steps_ms(case.defaults.macro_step_s);
        let step_ms = offered.into_iter().find(|ms| (1e-3 * ms - step_s).abs() <= 1e-12 * step_s)?;
        let phase = run.phase.parse::<f64>().ok().filter(|phase| *phase != 1.0);
        let age = match text("delivery_up") {
            "" => None,
            late => Some(late.strip_prefix("delay:")?.parse().ok()?),
        };
        let same = |contacts: &str, late: &str| {
            let mut request = RunRequest::of(case.name.to_string(), &*run.scheme);
            let options = [
                ("macro_step_s", text("macro_step_s")),
                ("phase", &*run.phase),
                ("contact_detection", contacts),
                ("delivery_up", text("delivery_up")),
                ("late_samples", late),
            ];
            for (key, value) in options.into_iter().filter(|(_, value)| !value.is_empty()) {
                request.put(key, value).ok()?;
            }
            let id = request.resolve(catalogue).ok()?.id().to_string();
            (id == *run.id).then(|| [&*run.scheme, contacts, late].map(str::to_owned))
        };
        let (contacts, late) = (text("contact_detection"), text("late_samples"));
        let side =
            same("", "").or_else(|| same(contacts, "")).or_else(|| same("", late)).or_else(|| same(contacts, late));
        let shared = [("late", age), ("phase", phase)];
        let place =
            shared.into_iter().filter_map(|(key, value)| Some(format!("&{key}={}", value?))).collect::<String>();
        Some(Shown { place: format!("case={}&h={step_ms}{place}", case.name), side: side? })
    }
}

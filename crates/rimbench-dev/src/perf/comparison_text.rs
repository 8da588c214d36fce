//! A comparison for reading, and for programs.

use super::comparison::Comparison;
use super::decision::{Finding, Verdict};
use super::history::COUNTERS;

impl Comparison {
    /// The comparison as a table; of the counters only those that changed.
    pub fn markdown(&self) -> String {
        let mut text = format!("Base {}, new {}.\n\n", self.base, self.new);
        text += "| benchmark | quantity | base | new | new / base | fence or 95 % interval | verdict |\n";
        text += "|---|---|---|---|---|---|---|\n";
        for finding in self.findings.iter().filter(|finding| finding.is_worth_telling()) {
            text += &finding.markdown();
        }
        let counters = self.findings.iter().filter(|finding| finding.is_counter());
        let (same, all) =
            (counters.clone().filter(|finding| finding.verdict == Verdict::Same).count(), counters.count());
        text += &format!("\n{same} of {all} counters are the same.\n");
        self.notes.iter().for_each(|note| text += &format!("- {note}\n"));
        text += &match self.regressions() {
            names if names.is_empty() => "\nNo regression.".to_owned(),
            names => format!("\nRegressed: {}.", names.join("; ")),
        };
        text
    }
}

impl Finding {
    fn is_counter(&self) -> bool {
        COUNTERS.iter().any(|(name, _)| *name == self.quantity)
    }

    fn is_worth_telling(&self) -> bool {
        !self.is_counter() || self.verdict != Verdict::Same
    }

    fn markdown(&self) -> String {
        let number = |value: Option<f64>| match value {
            None => "–".to_owned(),
            Some(value) if value.fract() == 0.0 && self.quantity != "time" => format!("{value}"),
            Some(value) => format!("{value:.4}"),
        };
        let ratio = self.base.zip(self.new).filter(|(base, _)| *base > 0.0).map(|(base, new)| new / base);
        let interval = self.interval.map_or("–".to_owned(), |[low, high]| match self.quantity.as_str() {
            "time" => format!("{low:.3} … {high:.3}"),
            _ => format!("{low:.0} … {high:.0}"),
        });
        let note = if self.note.is_empty() { String::new() } else { format!(" ({})", self.note) };
        format!(
            "| {} | {} | {} | {} | {} | {interval} | {}{note} |\n",
            self.benchmark,
            self.quantity,
            number(self.base),
            number(self.new),
            ratio.map_or("–".to_owned(), |ratio| format!("{ratio:.4}")),
            self.verdict
        )
    }
}

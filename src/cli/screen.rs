//! What a person reads: a line with the verdict, lines with a label, tables and errors, none wider than the terminal
//! and no word broken.

use super::program;
use rimbench::error::{with_short_numbers, without_system_number};

/// Columns where there is no terminal.
const COLUMNS: usize = 80;

/// A narrower terminal breaks the lines itself.
const LEAST: usize = 20;

/// Width of the labels below a headline.
const LABEL: usize = 18;

/// How a verdict is coloured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mood {
    Good,
    Bad,
    Open,
}

/// Characters in a line: `$COLUMNS` if it is set, else what the terminal says, else 80.
pub(super) fn width() -> usize {
    let set = std::env::var("COLUMNS").ok().and_then(|columns| columns.trim().parse().ok()).filter(|width| *width > 0);
    let terminal = || console::Term::stdout().size_checked().map(|(_, columns)| usize::from(columns));
    set.or_else(terminal).unwrap_or(COLUMNS).max(LEAST)
}

/// Characters after which a line of a list is cut: none where its reader is a program.
pub(super) fn cut_width() -> usize {
    let read_by_program = std::env::var_os("COLUMNS").is_none() && !console::Term::stdout().is_term();
    if read_by_program { usize::MAX } else { width() }
}

/// Bold and in colour on a terminal, unless `NO_COLOR` is set.
fn coloured(text: &str, mood: Mood) -> String {
    if std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty()) {
        return text.to_owned();
    }
    let style = console::style(text).bold();
    match mood {
        Mood::Good => style.green(),
        Mood::Bad => style.red(),
        Mood::Open => style.yellow(),
    }
    .to_string()
}

/// The first line: what it is about, and the verdict at the right end, or below if both do not fit.
pub(super) fn headline(about: &str, verdict: &str, mood: Mood) -> String {
    headline_within(width(), about, verdict, mood)
}

fn headline_within(width: usize, about: &str, verdict: &str, mood: Mood) -> String {
    let [left, right] = [about, verdict].map(|text| text.chars().count());
    if left + 2 + right <= width {
        // Far apart on a wide screen they would be two texts.
        let between = width.min(COLUMNS).saturating_sub(left + right).max(2);
        return format!("{about}{}{}", " ".repeat(between), coloured(verdict, mood));
    }
    let verdict: Vec<String> = wrap(verdict, width).iter().map(|line| coloured(line, mood)).collect();
    format!("{}\n{}", wrap(about, width).join("\n"), verdict.join("\n"))
}

/// A line that is a verdict, wrapped where it does not fit.
pub(super) fn verdict(text: &str, mood: Mood) -> String {
    wrap(text, width()).iter().map(|line| coloured(line, mood)).collect::<Vec<_>>().join("\n")
}

/// A line with a label; the text goes on below its own beginning.
pub(super) fn row(label: &str, text: &str) -> String {
    row_within(width(), label, text)
}

fn row_within(width: usize, label: &str, text: &str) -> String {
    let indent = (2 + LABEL).min(width / 2);
    let lines = wrap(text, width - indent);
    // On a narrow screen a label may be longer than its column.
    let own = (indent - 2).max(label.chars().count() + 1);
    let first = format!("  {label:<own$}{}", lines.first().map_or("", String::as_str));
    lines.iter().skip(1).fold(first.trim_end().to_owned(), |text, line| format!("{text}\n{}{line}", " ".repeat(indent)))
}

/// A line with a label and a command, which goes on as a shell has it.
pub(super) fn command_row(label: &str, command: &str) -> String {
    let indent = 2 + LABEL;
    let lines = wrap(command, width().saturating_sub(indent + 2).max(20));
    format!("  {label:<LABEL$}{}", lines.join(&format!(" \\\n{}", " ".repeat(indent))))
}

/// A paragraph, whose further lines begin with so many spaces.
pub(super) fn paragraph(text: &str, indent: usize) -> String {
    let width = width();
    let lines = wrap(text, width.saturating_sub(indent).max(20));
    lines.join(&format!("\n{}", " ".repeat(indent)))
}

/// Lines of at most so many characters; a word that is longer has a line of its own.
pub(super) fn wrap(text: &str, width: usize) -> Vec<String> {
    let (mut lines, mut line, mut length) = (Vec::new(), String::new(), 0);
    for word in text.split([' ', '\n']).filter(|word| !word.is_empty()) {
        let own = word.chars().count();
        if length > 0 && length + 1 + own > width {
            lines.push(std::mem::take(&mut line));
            length = 0;
        }
        if length > 0 {
            line.push(' ');
            length += 1;
        }
        line.push_str(word);
        length += own;
    }
    if length > 0 || lines.is_empty() {
        lines.push(line);
    }
    lines
}

/// Rows under headings.
#[derive(Debug, Clone)]
pub(super) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Begins with the headings.
    pub(super) fn new(header: &[&str]) -> Self {
        Table { rows: vec![header.iter().map(|&cell| cell.to_owned()).collect()] }
    }

    /// Adds a row.
    pub(super) fn add_row<T: Into<String>>(&mut self, row: impl IntoIterator<Item = T>) {
        self.rows.push(row.into_iter().map(Into::into).collect());
    }

    fn text(&self, width: usize) -> String {
        let columns = self.rows[0].len();
        let of_column = |column: usize| self.rows.iter().filter_map(move |row| row.get(column));
        let widest = |column: usize, of: fn(&str) -> usize| of_column(column).map(|cell| of(cell)).max().unwrap_or(0);
        let longest_word = |cell: &str| cell.split(' ').map(|word| word.chars().count()).max().unwrap_or(0);
        let mut widths: Vec<usize> = (0..columns).map(|column| widest(column, |cell| cell.chars().count())).collect();
        let least: Vec<usize> = (0..columns).map(|column| widest(column, longest_word)).collect();
        let gaps = 2 * columns.saturating_sub(1);
        if least.iter().sum::<usize>() + gaps > width {
            return self.records(width);
        }
        // The widest column gives way first.
        while widths.iter().sum::<usize>() + gaps > width {
            let room = (0..columns).filter(|&column| widths[column] > least[column]);
            let Some(widest) = room.max_by_key(|&column| widths[column]) else { break };
            widths[widest] -= 1;
        }
        let is_number = |cell: &String| {
            cell.is_empty() || cell == "–" || cell.starts_with(|c: char| c.is_ascii_digit() || c == '-')
        };
        let numeric: Vec<bool> = (0..columns).map(|column| of_column(column).skip(1).all(is_number)).collect();
        let mut lines = Vec::new();
        for (number, row) in self.rows.iter().enumerate() {
            let cells: Vec<Vec<String>> = row.iter().zip(&widths).map(|(cell, width)| wrap(cell, *width)).collect();
            for line in 0..cells.iter().map(Vec::len).max().unwrap_or(0) {
                let mut text = String::new();
                for (column, cell) in cells.iter().enumerate() {
                    let (cell, width) = (cell.get(line).map_or("", String::as_str), widths[column]);
                    let padding = " ".repeat(width - cell.chars().count());
                    let gap = if column == 0 { "" } else { "  " };
                    text += &if numeric[column] {
                        format!("{gap}{padding}{cell}")
                    } else {
                        format!("{gap}{cell}{padding}")
                    };
                }
                lines.push(text.trim_end().to_owned());
            }
            if number == 0 {
                lines.push("─".repeat((widths.iter().sum::<usize>() + gaps).min(width)));
            }
        }
        lines.join("\n")
    }

    /// Where the columns do not fit side by side: a line for the first cell, and below it the others behind their
    /// headings.
    fn records(&self, width: usize) -> String {
        let mut text = Vec::new();
        for row in self.rows.iter().skip(1) {
            text.extend(wrap(&row[0], width));
            let others = self.rows[0].iter().zip(row).skip(1).filter(|(_, cell)| !cell.is_empty());
            let others: Vec<String> = others.map(|(heading, cell)| format!("{heading} {cell}")).collect();
            text.extend(wrap(&others.join(" · "), width.saturating_sub(4)).iter().map(|line| format!("    {line}")));
        }
        text.join("\n")
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text(width()))
    }
}

/// Lists that commands print, by what an unknown name should have named.
const LISTS: [(&str, &str); 6] = [
    ("case", "list cases"),
    ("scheme", "list schemes"),
    ("solver", "list solvers"),
    ("metric", "list metrics"),
    ("parameter", "list parameters --case NAME"),
    ("statistic or metric", "list metrics"),
];

/// An error in two lines: what is wrong and where, and what to do. `flags` are those of the command line, without their
/// dashes, and `typed` those of this call.
pub(super) fn error(message: &str, flags: &[String], typed: &[String]) -> String {
    let message = without_system_number(&with_short_numbers(message));
    let (what, valid) = message.split_once("; valid: ").unzip();
    let what = what.unwrap_or(&message);
    let list = LISTS.iter().find(|(kind, _)| what.contains(&format!("unknown {kind} `")));
    let list = list.map(|(_, command)| format!("`{} {command}` lists all", program()));
    let (what, near) = match what.split_once(" (did you mean ").map(|(before, rest)| (before, rest.split_once("?)"))) {
        Some((before, Some((near, after)))) => (format!("{before}{after}"), Some(format!("did you mean {near}?"))),
        _ => (what.to_owned(), None),
    };
    let valid = valid.filter(|_| near.is_none() && list.is_none()).map(|valid| format!("use {valid}"));
    let help: Vec<String> = [near, valid, list].into_iter().flatten().collect();
    // What a file says wrong has the names of the file.
    let of_file = [".toml", ".csv", ".fmu"].iter().any(|ending| what.contains(ending));
    let named = |text: &str| if of_file { text.to_owned() } else { in_flags(text, flags) };
    let what = named(&flagged(&what, flags, typed));
    let help: Vec<String> = help.iter().map(|help| named(help)).collect();
    let said = format!("error: {what}");
    let said = if help.is_empty() { vec![said] } else { vec![said, format!("help: {}", help.join(" "))] };
    // A program reads it as it is.
    let width = if console::Term::stderr().is_term() { width() } else { usize::MAX };
    let lines = |line: &String| line.split('\n').flat_map(|line| wrap(line, width)).collect::<Vec<_>>().join("\n");
    said.iter().map(lines).collect::<Vec<_>>().join("\n")
}

/// A key of a run that is also a flag is said as the flag that was typed; of one that was not it is the default that
/// does not fit.
fn flagged(what: &str, flags: &[String], typed: &[String]) -> String {
    let Some((key, rest)) = what.split_once(" = ") else { return what.to_owned() };
    let flag = key.strip_suffix("_s").unwrap_or(key).replace('_', "-");
    match rest.split_once(" is not valid") {
        _ if !flags.contains(&flag) => what.to_owned(),
        Some((value, after)) if !typed.contains(&flag) => {
            format!("--{flag} = {value}, the default, is not valid{after}")
        }
        _ => format!("--{flag} = {rest}"),
    }
}

/// Keys of several words that are also flags are said as flags wherever they stand, with a value as it would be typed.
fn in_flags(text: &str, flags: &[String]) -> String {
    let is_key = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut out = String::new();
    let mut rest = text;
    while let Some(start) = rest.find(is_key) {
        let end = rest[start..].find(|c| !is_key(c)).map_or(rest.len(), |length| start + length);
        let key = &rest[start..end];
        let flag = key.strip_suffix("_s").unwrap_or(key).replace('_', "-");
        out += &rest[..start];
        rest = &rest[end..];
        if key.contains('_') && flags.contains(&flag) {
            out += &format!("--{flag}");
            if let Some((value, after)) = rest.strip_prefix(" = \"").and_then(|value| value.split_once('"')) {
                out += &format!(" {value}");
                rest = after;
            }
        } else {
            out += key;
        }
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_fit_and_no_word_is_broken() {
        let text = "zero-order-hold with the actuator first is unstable at a-word-that-is-longer-than-the-line";
        for width in [12, 20, 40, 80] {
            for line in wrap(text, width) {
                assert!(line.chars().count() <= width || !line.contains(' '), "{width}: {line}");
            }
            assert_eq!(wrap(text, width).join(" "), text);
        }
        assert_eq!(headline_within(20, "box · hold", "fine", Mood::Good), "box · hold      fine");
        assert_eq!(headline_within(200, "box · hold", "fine", Mood::Good).chars().count(), COLUMNS);
        assert_eq!(headline_within(12, "box · hold", "fine", Mood::Good), "box · hold\nfine");
        assert_eq!(
            row_within(40, "error", "of many words that go on below"),
            "  error             of many words that\n                    go on below"
        );
    }

    #[test]
    fn a_table_gives_way_where_words_allow_it_and_becomes_records_where_they_do_not() {
        let mut table = Table::new(&["name", "about", "n"]);
        table.add_row(["zero-order-hold", "every input is held at its last value", "1"]);
        table.add_row(["nepce", "energy", "12"]);
        assert!(
            table
                .text(80)
                .lines()
                .nth(2)
                .unwrap()
                .starts_with("zero-order-hold  every input is held at its last value   1")
        );
        for width in [30, 40, 80] {
            assert!(table.text(width).lines().all(|line| line.chars().count() <= width), "{}", table.text(width));
            assert!(table.text(width).contains("zero-order-hold"));
        }
        assert_eq!(table.text(22).lines().next(), Some("zero-order-hold"));
    }

    #[test]
    fn an_error_says_what_is_wrong_and_then_what_to_do() {
        let flags = ["wall-limit".to_owned(), "macro-step".to_owned()];
        let said = |message: &str| error(message, &flags, &flags[..1]);
        assert_eq!(
            said("macro_step_s = 1 is not valid; valid: at most the duration").lines().next(),
            Some("error: --macro-step = 1, the default, is not valid")
        );
        assert_eq!(
            said("gain = 2 is given: add wall_limit_s = \"1\" or macro_step_s, of `macro_steps`"),
            "error: gain = 2 is given: add --wall-limit 1 or --macro-step, of `macro_steps`"
        );
        let of_table = "runs.csv: unknown column `macro_step_s`";
        assert_eq!(said(of_table), format!("error: {of_table}"));
        let of_file = "box.toml: macro_step_s = 1 is not valid";
        assert_eq!(said(of_file), format!("error: {of_file}"));
        assert_eq!(
            said("wall_limit_s = 0 is not valid; valid: a time from 1e-9 s"),
            "error: --wall-limit = 0 is not valid\nhelp: use a time from 1e-9 s"
        );
        assert_eq!(
            said("unknown case `wedge-bx` (did you mean `wedge-box`?); valid: wedge-box, gripper"),
            format!(
                "error: unknown case `wedge-bx`\nhelp: did you mean `wedge-box`? `{} list cases` lists all",
                program()
            )
        );
        assert_eq!(
            said("box_mass_kg = 0 is not valid; valid: more").lines().next(),
            Some("error: box_mass_kg = 0 is not valid")
        );
        assert_eq!(said("disk full"), "error: disk full");
    }
}

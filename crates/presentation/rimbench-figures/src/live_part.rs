//! The live part of the page: what simulates, with the numerics themselves as a module for the browser; figures and
//! runs.
//!
//! The module is the crate `rimbench-web`, compiled by `.ci/web-module` and committed, so that neither of the two
//! commands needs another compiler; `.ci/page.mjs digits` holds it against the program. Everything stands in the one
//! file of the report.

use crate::drawing::Color;
use crate::seven_bits::seven_bits;
use crate::style::{Styles, on_dark_paper};
use flate2::Compression;
use flate2::write::GzEncoder;
use rimbench_core::schemes::standard_schemes;
use rimbench_runs::metrics::{STAYS_DOWN_M, USABLE};
use serde_json::{Map, Value, json};
use std::io::Write;

/// Controls and empty drawings.
pub const SECTION: &str = include_str!("../page/try.html");
/// The table of runs and the drawer of one run, empty.
pub const RUNS: &str = include_str!("../page/runs.html");
/// How all of it looks, in light and dark and in print.
pub const STYLE: &str = concat!(include_str!("../page/page.css"), include_str!("../page/try.css"));

/// The module, compressed.
const MODULE: &[u8] = include_bytes!("../page/rimbench.wasm.gz");
const WORKER: &str = include_str!("../page/worker.js");
/// What scripts share.
const COMMON: &str = include_str!("../page/common.js");
/// The part that simulates (drawings, verdicts, curves, controls), figures, the one that is dragged, runs.
const SCRIPTS: [&str; 7] = [
    include_str!("../page/drawing.js"),
    include_str!("../page/verdict.js"),
    include_str!("../page/curves.js"),
    include_str!("../page/try.js"),
    include_str!("../page/figures.js"),
    include_str!("../page/mechanism.js"),
    include_str!("../page/runs.js"),
];

/// Returns what makes the page live, for its end; the scripts behind the first are packed to a third.
pub fn scripts() -> String {
    let scripts: String = SCRIPTS.iter().map(|script| bare(script)).collect();
    format!(
        "<script type=\"application/octet-stream\" id=\"module\">{}</script>\n\
         <script type=\"application/octet-stream\" id=\"scripts\">{}</script>\n\
         <script type=\"application/json\" id=\"known\">{}</script>\n\
         <script type=\"text/plain\" id=\"worker\">{}</script>\n<script>{}</script>\n",
        seven_bits(MODULE),
        seven_bits(&gzipped(scripts.as_bytes())),
        known(),
        bare(WORKER),
        bare(COMMON),
    )
}

/// Bytes as a page unpacks them.
pub fn gzipped(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(bytes).and_then(|()| packed.finish()).expect("memory takes what is written")
}

/// A script without its indentation and the lines that are comments; none of ours has a text of several lines.
fn bare(script: &str) -> String {
    let lines = script.lines().map(str::trim_start).filter(|line| !line.is_empty() && !line.starts_with("//"));
    lines.map(|line| format!("{line}\n")).collect()
}

/// Names and colours of the schemes as in the figures, each on light and on dark paper, and the bounds of verdicts.
fn known() -> Value {
    let styles = Styles::standard();
    let of = |name: &str| {
        let color = styles.of_label(name).color;
        let colors = [color, on_dark_paper(color)].map(Color::hex);
        json!({ "name": styles.shown_name(name), "colors": colors })
    };
    let schemes: Map<_, _> =
        standard_schemes().iter().map(|scheme| (scheme.name.to_string(), of(&scheme.name))).collect();
    json!({ "schemes": schemes, "stays_down_m": STAYS_DOWN_M, "usable": USABLE })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_in_the_page_must_not_end_it() {
        for script in [COMMON, WORKER] {
            assert!(!script.contains("</script"));
        }
        assert_eq!(scripts().matches("<script").count(), 5);
    }

    #[test]
    fn every_control_that_the_scripts_ask_for_is_there() {
        let asked = |script: &'static str| script.split("$(\"").skip(1).filter_map(|rest| rest.split('"').next());
        let mut count = 0;
        // Made elsewhere: the data, and what only a page with studies has.
        let made = ["module", "scripts", "worker", "known", "data", "highlight"];
        for id in SCRIPTS.iter().chain([&COMMON]).flat_map(|script| asked(script)).filter(|id| !made.contains(id)) {
            count += 1;
            assert!([SECTION, RUNS].iter().any(|html| html.contains(&format!("id=\"{id}\""))), "{id}");
        }
        assert!(count > 30, "{count}");
    }
}

//! The part of the report that simulates: controls, drawing, and the numerics themselves as a module for the browser.
//!
//! The module is the crate `rimbench-web`, compiled by `.ci/web-module` and committed with a hash of its sources inside, so that
//! neither of the two commands needs another compiler. Everything stands in the one file of the report.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

/// Controls and empty drawings.
pub const SECTION: &str = include_str!("../page/try.html");
/// How they look, in light and dark.
pub const STYLE: &str = include_str!("../page/try.css");

/// The module, compressed.
const MODULE: &[u8] = include_bytes!("../page/rimbench.wasm.gz");
const WORKER: &str = include_str!("../page/worker.js");
const SCRIPT: &str = include_str!("../page/try.js");

/// Returns what makes the section live, for the end of the page.
pub fn scripts() -> String {
    format!(
        "<script type=\"application/octet-stream\" id=\"module\">{}</script>\n\
         <script type=\"text/plain\" id=\"worker\">{WORKER}</script>\n<script>{SCRIPT}</script>\n",
        BASE64_STANDARD.encode(MODULE)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_in_the_page_must_not_end_it() {
        for script in [WORKER, SCRIPT] {
            assert!(!script.contains("</script"));
        }
        // A blank line would end the block of HTML in the Markdown source.
        assert!(!SECTION.contains("\n\n"));
        assert!(scripts().matches("<script").count() == 3);
    }

    #[test]
    fn every_control_that_the_script_asks_for_is_there() {
        let asked = SCRIPT.split("$(\"").skip(1).filter_map(|rest| rest.split('"').next());
        let missing: Vec<&str> = asked
            .filter(|id| !["module", "worker"].contains(id) && !SECTION.contains(&format!("id=\"{id}\"")))
            .collect();
        assert!(missing.is_empty(), "{missing:?}");
    }
}

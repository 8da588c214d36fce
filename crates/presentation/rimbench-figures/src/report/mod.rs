//! The page of a results folder: one HTML file that needs no other, of at most [`MOST_BYTES`].
//!
//! | file | what |
//! |---|---|
//! | `store` | which studies a folder holds, and what their files say |
//! | `address` | which runs the simulator shows, and where |
//! | `claims` | the claims, the paper's and ours apart, each with its bound drawn |
//! | `sections` | head, text of the paper, studies, what is missing |
//! | `grid` | the largest accurate macro step: case × scheme |
//! | `packed` | runs, traces and exact values for the script, as small as they must be |
//!
//! Figures are SVG in the page: they print, and need no script. A script (`page/report.js`) makes them alive, and shows
//! the runs.

mod address;
mod claims;
mod grid;
mod packed;
mod sections;
mod store;

pub use address::address;
pub use claims::measured;
pub use store::{Made, Picture, Study, find_studies};

use crate::live_part;
use packed::Detail;
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use std::path::Path;

/// How the one line of a page begins that says of which day, commit and machine it is.
pub const DATE_LINE: &str = "<p class=\"made\">";

/// No page is larger.
pub const MOST_BYTES: usize = 3_000_000;

/// A box before its stop; as data it needs no request.
const ICON: &str = "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 16 16'%3E%3Cpath fill='%230072b2' d='M1 5h8v8H1z'/%3E\
                    %3Cpath fill='%23d55e00' d='M11 2h3v12h-3z'/%3E%3C/svg%3E";

/// What the page is, for those who find a link to it.
const ABOUT: &str = "Two coupling schemes on a mechanical system with contact, simulated in this page. Drag the macro step and see which one fails.";

/// The picture that a link shows; it lies beside the page, and a host puts its own address before the name.
const PREVIEW: &str = "<meta property=\"og:type\" content=\"website\"><meta property=\"og:image\" content=\"preview.png\">\
                       <meta property=\"og:image:width\" content=\"1200\"><meta property=\"og:image:height\" content=\"630\">\
                       <meta name=\"twitter:card\" content=\"summary_large_image\">";

/// What is said of figures that are packed.
const PACKED: &str = "Figures of the studies are packed, so that the page is no larger than 3 MB, and need scripts: without, they stand in the \
                      folders of the studies, and a page of one group or one study has them.";

/// What a page is made from.
#[derive(Debug)]
pub struct Report<'a> {
    /// The folder that it is about; a page names no other part of its path than the last.
    pub folder: &'a Path,
    /// Studies with their figures and claims, in the order of the page.
    pub studies: Vec<Study>,
    /// The text about the experiments of the paper, given as name and text, if they are among the studies.
    pub text: Option<(&'a Path, &'a str)>,
    /// Every figure that the text may name, with its experiment.
    pub listed: Vec<(String, String)>,
    /// The program that wrote it, in words.
    pub program: String,
}

/// What came of writing a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// Its size.
    pub bytes: usize,
    /// What was left out so that it is no larger; also said in the page.
    pub left_out: Vec<String>,
}

impl Report<'_> {
    /// Writes the page.
    ///
    /// # Errors
    /// [`Error::File`] for a place in the text with no such name, and a file that cannot be written;
    /// [`Error::Incompatible`] if even without runs the page would be larger than [`MOST_BYTES`].
    pub fn write(&self, path: &Path) -> Result<Written> {
        let scripts = live_part::scripts();
        for (packed, detail) in [(false, Detail::Runs), (true, Detail::Runs), (true, Detail::Values)] {
            let body = self.body(packed)?;
            let mut left_out = detail.left_out(&self.studies);
            if packed {
                left_out.push(PACKED.to_owned());
            }
            let around = self.page(&body, &scripts, &left_out, "");
            let Some(data) = packed::data(self, detail, packed, MOST_BYTES.saturating_sub(around.len())) else {
                continue;
            };
            let page = self.page(&body, &scripts, &left_out, &data);
            write_atomically(path, |file| file.write_all(page.as_bytes()))?;
            return Ok(Written { bytes: page.len(), left_out });
        }
        let message = format!(
            "the claims and figures of {} alone make a page of more than {MOST_BYTES} bytes: make a page of fewer studies",
            self.folder.display()
        );
        Err(Error::Incompatible(message))
    }

    /// The name of the folder, escaped.
    fn title(&self) -> String {
        let place = std::path::absolute(self.folder).unwrap_or_else(|_| self.folder.to_owned());
        crate::vector::escaped(&place.file_name().unwrap_or_default().to_string_lossy())
    }

    fn page(&self, body: &str, scripts: &str, left_out: &[String], data: &str) -> String {
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
             <meta name=\"color-scheme\" content=\"light dark\">\
             <link rel=\"icon\" href=\"{ICON}\">\
             <title>rimbench: {title}</title>\n\
             <meta name=\"description\" content=\"{ABOUT}\">\
             <meta property=\"og:title\" content=\"How long may the macro step be?\">\
             <meta property=\"og:description\" content=\"{ABOUT}\">{preview}\n<style>{style}</style></head>\n<body>\n{body}{missing}</main>\n\
             <script type=\"application/octet-stream\" id=\"data\">{data}</script>\n{scripts}</body></html>\n",
            title = self.title(),
            preview = if self.text.is_some() { PREVIEW } else { "" },
            style = live_part::STYLE,
            missing = sections::missing(self, left_out),
        )
    }
}

/// A part under words that open it, where it is folded.
fn folded(is_folded: bool, words: &str, part: &str) -> String {
    match is_folded {
        true => format!("<details class=\"fold\"><summary>{words}</summary>\n{part}</details>\n"),
        false => part.to_owned(),
    }
}

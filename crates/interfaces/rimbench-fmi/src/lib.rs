//! The boundary to FMI (Functional Mock-up Interface): subsystems of rimbench as FMUs for others, FMUs of others as
//! subsystems.
//!
//! | room | what it holds |
//! |---|---|
//! | [`export`] | one side of a case as an archive: variables, `modelDescription.xml`, the library, packed |
//! | `binary` | the functions that a master calls in that library, by hand: no bindgen, no libclang |
//! | [`import`] | a case file that names FMUs, and what drives them: in a process of their own or in this one |
//!
//! `unsafe` stands where a master calls us (`binary/functions.rs`, `functions_2.rs`), and where we call a library
//! (`import/library.rs` and `library/`).

// Exported functions are always linked in: unit tests leave them out, so that they link only what they use.
#[cfg(not(test))]
mod binary;
pub mod export;
pub mod import;
mod last_words;
mod model_parts;

/// The library that this crate is built as, and that every exported FMU holds: its name without prefix and ending.
pub const LIBRARY: &str = "rimbench_fmi";

/// What a library must have been built from to belong to this program: sources of contact, core, cases and this crate,
/// by their hashes.
const SOURCES: [&str; 4] = {
    let [core, contact] = rimbench_core::SOURCES;
    [core, contact, rimbench_cases::SOURCES, env!("RIMBENCH_FMI_SOURCES")]
};

/// Names what a library must have been built from, and the version.
pub fn sources() -> String {
    format!("{} {}", SOURCES.join(" "), env!("CARGO_PKG_VERSION"))
}

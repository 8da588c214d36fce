//! Submissions: a third party's scheme, its results, and what it declares of both.
//!
//! ```text
//! <folder>/
//!     submission.toml     the declaration
//!     scheme.toml, …      the scheme file that it names, with its program
//!     <package>/          data packages, as `export` writes them
//! ```
//! A scheme is always a program of its own that answers line by line: nothing of it runs in this process, and every number is computed
//! here. A submission that computed its own numbers would have to be believed.
//!
//! ```text
//! what is declared (declaration) → what its files are, before anything is started (places) → its packages and a sample of their
//! runs (check) → what the ranking takes of it (accepted)
//! ```

mod accepted;
mod check;
mod declaration;
mod places;

pub use accepted::{Accepted, accept};
pub use check::{CheckedPackage, Workplace, check_package};
pub use declaration::{DECLARATION, Declaration, Tuned};
pub use places::LONGEST_ANSWER_S;

#[cfg(test)]
mod sample {
    use super::Declaration;
    use rimbench_cases::catalogue::Catalogue;
    use rimbench_core::error::Result;
    use std::path::Path;

    /// A declaration as it may be.
    pub(super) const GOOD: &str = r#"
name = "mine"
about = "Holds, but better"
authors = ["Doe, Jane"]
licence = "MIT"
information = "samples"
scheme = "scheme.toml"
packages = ["package"]

[[tuned]]
what = "the share of a new sample"
cases = ["wedge-box"]
"#;

    pub(super) fn parsed(text: &str) -> Result<Declaration> {
        Declaration::parse(Path::new("submission.toml"), text, &Catalogue::standard())
    }
}

//! The archive, and the library in it.

use super::description::description;
use super::variables::Variables;
use super::{Contents, Fmi, LAYERED_STANDARD, RESOURCE};
use crate::LIBRARY;
use rimbench_cases::cases::Case;
use rimbench_core::cosim::Side;
use rimbench_core::error::{Error, Result};
use rimbench_runs::RunSpec;
use rimbench_runs::catalogue::Catalogue;
use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// How the library is built.
const BUILD: &str = "cargo build --release --package rimbench-fmi";

/// The name of this platform in an FMU.
pub(crate) fn platform(fmi: Fmi) -> String {
    let system = if OS == "macos" { "darwin" } else { OS };
    match fmi {
        Fmi::Two => format!("{}{}", if OS == "windows" { "win" } else { system }, usize::BITS),
        Fmi::Three => format!("{ARCH}-{system}"),
    }
}

/// Finds the library that FMUs hold: that which is given, else that beside the program, where Cargo puts it.
///
/// # Errors
/// [`Error::File`] if it is not there, or was built from other sources than this program, with the command that builds
/// it.
pub fn find_library(given: Option<&Path>, program: &Path) -> Result<(PathBuf, Vec<u8>)> {
    let name = format!("{DLL_PREFIX}{LIBRARY}{DLL_SUFFIX}");
    let beside = program.parent().unwrap_or(Path::new("."));
    let candidates = match given {
        Some(given) => vec![given.to_owned()],
        None => vec![beside.join(&name), beside.join("deps").join(&name)],
    };
    let mut other = None;
    for path in &candidates {
        let Ok(bytes) = std::fs::read(path) else { continue };
        if is_ours(&bytes) {
            return Ok((path.clone(), bytes));
        }
        other.get_or_insert_with(|| path.clone());
    }
    Err(match other {
        Some(path) => Error::file(
            path,
            format!("is no library for FMUs, or was built from other sources than this program; `{BUILD}` builds it"),
        ),
        None => {
            let message = format!(
                "is not there: it is the library that FMUs hold; `{BUILD}` builds it, `--library FILE` says where it is"
            );
            Error::file(&candidates[0], message)
        }
    })
}

/// Whether a library was built from the same sources: it has their hashes in it.
fn is_ours(bytes: &[u8]) -> bool {
    crate::SOURCES
        .iter()
        .chain(&["fmi3InstantiateCoSimulation"])
        .all(|wanted| bytes.windows(wanted.len()).any(|window| window == wanted.as_bytes()))
}

/// Refuses a case that is not built in.
///
/// # Errors
/// [`Error::Incompatible`].
pub fn check_case(case: &Case) -> Result<()> {
    if Catalogue::standard().case(&case.name).is_ok() {
        return Ok(());
    }
    Err(Error::Incompatible(format!(
        "case = {}: its sides come from outside, and the library in an FMU has the built-in cases only; valid: a name of \
         `rimbench list cases`",
        case.name
    )))
}

/// Makes the FMU of one side of the case of a run; `library` is what [`find_library`] has found. The same input gives
/// the same bytes.
///
/// # Errors
/// Those of building the case; [`Error::Incompatible`] for a case whose sides are not in that library.
pub fn pack(spec: &RunSpec, side: Side, fmi: Fmi, library: &[u8]) -> Result<Vec<u8>> {
    check_case(&spec.case)?;
    let variables = Variables::of(&spec.case, side, &spec.parameters, fmi)?;
    let contents = Contents::of(spec, side, fmi)?;
    let resource = serde_json::to_string_pretty(&contents).map_err(|error| Error::Incompatible(error.to_string()))?;
    let mut files = vec![
        ("modelDescription.xml".to_owned(), description(spec, &contents, &variables).into_bytes()),
        (format!("resources/{RESOURCE}"), resource.into_bytes()),
        (format!("binaries/{}/{LIBRARY}{DLL_SUFFIX}", platform(fmi)), library.to_vec()),
    ];
    if variables.has_model() {
        let [name, version] = LAYERED_STANDARD;
        let manifest = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiLayeredStandardManifest \
             xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\" fmi-ls:fmi-ls-name=\"{name}\" fmi-ls:fmi-ls-version=\"{version}\" \
             fmi-ls:fmi-ls-description=\"Proposal: the model reduced to its contacts and its interface, in variables rim.*\"/>\n"
        );
        files.push((format!("extra/{name}/fmi-ls-manifest.xml"), manifest.into_bytes()));
    }
    zipped(&files).map_err(|error| Error::Incompatible(format!("the FMU cannot be packed: {error}")))
}

/// Packs files, in less than half of the usual time by a twelfth more bytes; their times are the earliest that there
/// is, so that nothing but their contents counts.
///
/// # Errors
/// Names that no archive can have.
pub fn zipped(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(3))
        .last_modified_time(DateTime::default())
        .unix_permissions(0o755);
    for (name, bytes) in files {
        archive.start_file(name.as_str(), options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_built_from_other_sources_of_any_crate_is_not_ours() {
        let with = |sources: &[&str]| [sources, &["fmi3InstantiateCoSimulation"]].concat().join("\0").into_bytes();
        assert!(is_ours(&with(&crate::SOURCES)));
        for other in 0..crate::SOURCES.len() {
            let mut sources = crate::SOURCES;
            sources[other] = "0";
            assert!(!is_ours(&with(&sources)));
        }
    }
}

//! An FMU unpacked.

use super::description::Description;
use crate::export::{Fmi, LAYERED_STANDARD, platform};
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums::hex;
use rimbench_results::input::read_bytes;
use sha2::{Digest, Sha256};
use std::env::consts::DLL_SUFFIX;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use zip::ZipArchive;

/// Most that an FMU may hold when it is unpacked, bytes: what is more was packed to fill a disk.
const MOST_BYTES: u64 = 4 << 30;
/// Most that its description may hold, which is read whole, bytes.
const MOST_DESCRIBED: u64 = 256 << 20;
/// Most files in it.
const MOST_FILES: usize = 100_000;

/// Folders that are there, for what ends the program without a word to those who hold them.
static UNPACKED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes all folders, whoever still holds them.
pub(super) fn remove_unpacked() {
    let folders = std::mem::take(&mut *UNPACKED.lock().unwrap_or_else(PoisonError::into_inner));
    folders.iter().for_each(|folder| drop(std::fs::remove_dir_all(folder)));
}

/// A folder for an FMU that lives as long as this.
pub(super) struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> std::io::Result<Self> {
        let folder = tempfile::Builder::new().prefix("rimbench-fmu-").tempdir()?;
        UNPACKED.lock().unwrap_or_else(PoisonError::into_inner).push(folder.path().to_owned());
        Ok(Folder(folder))
    }

    pub(super) fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        UNPACKED.lock().unwrap_or_else(PoisonError::into_inner).retain(|folder| folder != self.path());
    }
}

/// An FMU unpacked into a folder that lives as long as this.
pub(super) struct Unpacked {
    /// The file.
    pub(super) file: PathBuf,
    pub(super) description: Description,
    pub(super) library: PathBuf,
    pub(super) folder: Folder,
    /// Hash of the file.
    pub(super) digest: String,
    /// Whether it says that it has the reduced interface model of our proposal.
    pub(super) layered: bool,
}

impl Unpacked {
    /// Opens an FMU.
    ///
    /// # Errors
    /// [`Error::File`] for what cannot be read, is no archive, has no description that can be used, or no library for
    /// this platform.
    pub(super) fn open(file: &Path) -> Result<Self> {
        let wrong = |message: String| Error::file(file, message);
        let bytes = read_bytes(file, MOST_BYTES)?;
        let digest = hex(&Sha256::digest(&bytes)[..8]);
        let mut archive = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| wrong(format!("is no FMU: no zip archive ({error})")))?;
        let folder = Folder::new().map_err(|error| wrong(format!("there is no room to unpack it: {error}")))?;
        check_size(&mut archive, MOST_BYTES).map_err(&wrong)?;
        archive.extract(folder.path()).map_err(|error| wrong(format!("cannot be unpacked: {error}")))?;
        let text = read_bytes(&folder.path().join("modelDescription.xml"), MOST_DESCRIBED).map_err(|error| {
            let Error::File { message, .. } = error else { return error };
            wrong(format!("is no FMU: modelDescription.xml {message}"))
        })?;
        let text = decoded(text).map_err(|message| wrong(format!("modelDescription.xml {message}")))?;
        let description =
            Description::parse(&text).map_err(|message| wrong(format!("modelDescription.xml: {message}")))?;
        let binaries = folder.path().join("binaries");
        let tuple = platform(if description.is_version_2() { Fmi::Two } else { Fmi::Three });
        let library = binaries.join(&tuple).join(format!("{}{DLL_SUFFIX}", description.identifier));
        if !library.is_file() {
            let there = std::fs::read_dir(&binaries).map(|entries| {
                let mut names: Vec<String> =
                    entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
                names.sort();
                names.join(", ")
            });
            let there = there.ok().filter(|names| !names.is_empty()).unwrap_or("none".to_owned());
            return Err(wrong(format!(
                "has no library `{}` for this platform, {tuple}; platforms in it: {there}",
                description.identifier
            )));
        }
        let [name, version] = LAYERED_STANDARD;
        let manifest = std::fs::read_to_string(folder.path().join("extra").join(name).join("fmi-ls-manifest.xml"));
        let layered = manifest.is_ok_and(|text| text.contains(&format!("\"{version}\"")));
        Ok(Unpacked { file: file.to_owned(), description, library, folder, digest, layered })
    }
}

/// Unpacks an archive to nowhere: what its files say of their sizes need not be true.
fn check_size(archive: &mut ZipArchive<Cursor<Vec<u8>>>, most: u64) -> std::result::Result<(), String> {
    if archive.len() > MOST_FILES {
        return Err(format!("has {} files in it; at most {MOST_FILES} make sense", archive.len()));
    }
    let mut rest = most;
    for index in 0..archive.len() {
        let file = archive.by_index(index).map_err(|error| format!("cannot be unpacked: {error}"))?;
        let size = std::io::copy(&mut file.take(rest + 1), &mut std::io::sink());
        let size = size.map_err(|error| format!("cannot be unpacked: {error}"))?;
        rest = rest.checked_sub(size).ok_or_else(|| format!("holds more than {most} bytes when it is unpacked"))?;
    }
    Ok(())
}

/// What a file of UTF-8 may begin with.
const MARK: char = '\u{feff}';

/// An XML file as text: UTF-8, or UTF-16 or Latin-1 where it says so.
fn decoded(bytes: Vec<u8>) -> std::result::Result<String, String> {
    let utf_16 = |of: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| of([pair[0], pair[1]])).collect();
        String::from_utf16(&units).map_err(|_| "is no UTF-16".to_owned())
    };
    match &bytes[..] {
        [0xff, 0xfe, ..] => return utf_16(u16::from_le_bytes),
        [0xfe, 0xff, ..] => return utf_16(u16::from_be_bytes),
        _ => {}
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).to_ascii_uppercase();
    let declaration = head.split("?>").next().unwrap_or_default();
    if ["ISO-8859-1", "LATIN1", "US-ASCII"].iter().any(|name| declaration.contains(name)) {
        return Ok(bytes.into_iter().map(char::from).collect());
    }
    let mut text =
        String::from_utf8(bytes).map_err(|_| "is no UTF-8, and says no other encoding that is known".to_owned())?;
    if text.starts_with(MARK) {
        text.drain(..MARK.len_utf8());
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    #[test]
    fn an_archive_that_would_fill_the_disk_is_not_unpacked() {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        for name in ["modelDescription.xml", "resources/zeros"] {
            writer.start_file(name, SimpleFileOptions::default()).unwrap();
            writer.write_all(&[0; 600_000]).unwrap();
        }
        let mut archive = ZipArchive::new(Cursor::new(writer.finish().unwrap().into_inner())).unwrap();
        // Zeros: the archive itself is small.
        assert!(archive.decompressed_size().unwrap() == 1_200_000);
        assert_eq!(check_size(&mut archive, 1_200_000), Ok(()));
        assert!(check_size(&mut archive, 1_199_999).unwrap_err().contains("more than 1199999 bytes"));
    }
}

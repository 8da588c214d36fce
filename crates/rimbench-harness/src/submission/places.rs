//! Where the files of a submission lie and how long its program may take: looked at before the program is started.

use super::declaration::{DECLARATION, Declaration};
use crate::files::read_text;
use rimbench_core::error::{Error, Result};
use std::path::{Component, Path, PathBuf};

/// Keys of a scheme file: what is started, and which further files its digits depend on.
const COMMAND: &str = "command";
const FILES: &str = "files";

/// Key of a scheme file: how long its program may take for an answer.
const PATIENCE: &str = "answer_within_s";

/// The most that it may ask for, s.
pub const LONGEST_ANSWER_S: f64 = 60.0;

impl Declaration {
    /// Looks at where its files are, links followed, before the program is started: whoever has the folder has all of the submission.
    ///
    /// # Errors
    /// [`Error::File`] for a declaration, a scheme file, a package, or a file that the scheme file names, which lies elsewhere. What is not
    /// there at all is for its reader to say.
    pub fn check_places(&self, folder: &Path) -> Result<()> {
        let whole = folder.canonicalize().map_err(|error| Error::file(folder, format!("cannot be found: {error}")))?;
        let lies_inside =
            |path: &Path| path.canonicalize().is_ok_and(|path| path.starts_with(&whole)) || !path.exists();
        let path = folder.join(DECLARATION);
        if !lies_inside(&path) {
            return Err(Error::file(path, "leads out of the folder of the submission: put the file itself there"));
        }
        for (key, name) in std::iter::once(("scheme", self.scheme.as_path()))
            .chain(self.packages.iter().map(|package| ("packages", Path::new(package))))
        {
            if !lies_inside(&folder.join(name)) {
                return Err(Error::file(path, Error::invalid(key, name.display(), INSIDE)));
            }
        }
        let (path, file) = self.scheme_file(folder)?;
        let beside = path.parent().unwrap_or(folder);
        let words = |key: &str| -> Vec<String> {
            let words = file.get(key).and_then(toml::Value::as_array).into_iter().flatten();
            words.filter_map(|word| word.as_str().map(str::to_owned)).collect()
        };
        for file in words(FILES) {
            // Whether or not it is there, no file of a submission is named so.
            if Path::new(&file).is_absolute() || !lies_inside(&beside.join(&file)) {
                return Err(Error::file(&path, Error::invalid(FILES, file, INSIDE)));
            }
        }
        for word in words(COMMAND) {
            // The value of an option is a path as well, and what has no slash is one where there is such a file.
            for part in std::iter::once(&*word).chain(word.split_once('=').map(|(_, value)| value)) {
                if Path::new(part).is_absolute() || !lies_inside(&beside.join(part)) {
                    return Err(Error::file(
                        &path,
                        Error::invalid(COMMAND, &word, format!("{INSIDE}, or a name on the path")),
                    ));
                }
            }
        }
        Ok(())
    }

    /// Path and keys of the scheme file; no keys if it is no TOML, which is for its reader to say.
    fn scheme_file(&self, folder: &Path) -> Result<(PathBuf, toml::Table)> {
        let path = folder.join(&self.scheme);
        let text = read_text(&path)?;
        Ok((path, toml::from_str(&text).unwrap_or_default()))
    }

    /// Looks at how long the program may take for an answer, before it is started: nobody is kept waiting for longer than
    /// [`LONGEST_ANSWER_S`].
    ///
    /// # Errors
    /// [`Error::File`] naming the scheme file. What else is wrong with it is for its reader to say.
    pub fn check_patience(&self, folder: &Path) -> Result<()> {
        let (path, file) = self.scheme_file(folder)?;
        let asked = file.get(PATIENCE).and_then(|value| value.as_float().or(value.as_integer().map(|s| s as f64)));
        match asked.filter(|seconds| seconds.is_nan() || *seconds > LONGEST_ANSWER_S) {
            None => Ok(()),
            Some(seconds) => {
                let expected = format!("at most {LONGEST_ANSWER_S} s in a submission");
                Err(Error::file(&path, Error::invalid(PATIENCE, seconds, expected)))
            }
        }
    }
}

/// What a path in a submission is.
const INSIDE: &str = "a path below the folder of the submission";

/// A path that does not lead out of the folder.
pub(super) fn inside(key: &str, text: &str) -> Result<PathBuf> {
    let path = Path::new(text);
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_));
    if !text.is_empty() && path.components().all(plain) && !text.contains(char::is_control) {
        return Ok(path.to_owned());
    }
    Err(Error::invalid(key, text, INSIDE))
}

#[cfg(test)]
mod tests {
    use super::super::sample::{GOOD, parsed};

    #[test]
    fn a_program_that_wants_to_be_waited_for_is_not_started() {
        let (folder, declaration) = (tempfile::tempdir().unwrap(), parsed(GOOD).unwrap());
        let check = |text: &str| {
            std::fs::write(folder.path().join("scheme.toml"), text).unwrap();
            declaration.check_patience(folder.path()).map_err(|error| error.to_string())
        };
        for text in ["", "no toml", "answer_within_s = 60", "answer_within_s = 0.5", "answer_within_s = \"long\""] {
            assert_eq!(check(text), Ok(()), "{text}");
        }
        for text in ["answer_within_s = 61", "answer_within_s = 1e9", "answer_within_s = inf", "answer_within_s = nan"]
        {
            let said = check(text).unwrap_err();
            assert!(said.contains("scheme.toml: answer_within_s = ") && said.contains("at most 60 s"), "{said}");
        }
        std::fs::remove_file(folder.path().join("scheme.toml")).unwrap();
        assert!(declaration.check_patience(folder.path()).unwrap_err().to_string().contains("cannot be read"));
    }

    #[cfg(unix)]
    #[test]
    fn a_submission_all_of_which_is_not_in_its_folder_is_refused_links_followed() {
        use std::os::unix::fs::symlink;
        let (above, declaration) = (tempfile::tempdir().unwrap(), parsed(GOOD).unwrap());
        let folder = above.path().join("mine");
        std::fs::create_dir_all(folder.join("package")).unwrap();
        for name in ["mine/lines.py", "mine/submission.toml", "elsewhere.py"] {
            std::fs::write(above.path().join(name), "").unwrap();
        }
        symlink("../elsewhere.py", folder.join("linked.py")).unwrap();
        let check = |text: &str| {
            std::fs::write(folder.join("scheme.toml"), text).unwrap();
            declaration.check_places(&folder).map_err(|error| error.to_string())
        };
        for text in [
            "",
            "command = [\"python3\", \"lines.py\", \"module:Class\", \"--rate=1/2\"]\nfiles = [\"lines.py\"]",
            "command = [\"./lines.py\"]",
            "command = [\"python3\"]\nfiles = [\"is-not-there.py\"]",
        ] {
            assert_eq!(check(text), Ok(()), "{text}");
        }
        for text in [
            "command = [\"python3\", \"../elsewhere.py\"]",
            "command = [\"python3\", \"linked.py\"]",
            "command = [\"python3\", \"/no/such/file.py\"]",
            "command = [\"python3\", \"--from=../elsewhere.py\"]",
            "files = [\"../elsewhere.py\"]",
            "files = [\"linked.py\"]",
            "files = [\"/etc/hostname\"]",
        ] {
            let said = check(text).unwrap_err();
            let key = text.split(' ').next().unwrap();
            let wanted = format!("scheme.toml: {key} = ");
            assert!(said.contains(&wanted) && said.contains("below the folder of the submission"), "{text}: {said}");
        }
        check("").unwrap();
        std::fs::remove_dir(folder.join("package")).unwrap();
        symlink("..", folder.join("package")).unwrap();
        let said = check("").unwrap_err();
        assert!(said.contains("submission.toml: packages = package is not valid"), "{said}");
    }
}

//! The experiments, figures and texts that commands go by: those of the project's folder where the command is called
//! from there, else those that the program carries. The folder that the program was built in is nowhere looked at.

use rimbench::error::{Error, Result};
use rimbench::figures::{FigureList, TableList};
use rimbench::harness::{Experiment, Ranking};
use rimbench::shipped;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Where they are taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Project {
    /// The current folder, which is the project's.
    Here,
    /// The program itself.
    Carried,
}

impl Project {
    /// The project's folder has `experiments` and `paper/figures.toml`; any other folder has not.
    pub(super) fn find() -> Self {
        let here = Path::new("experiments").is_dir() && Path::new(shipped::FIGURES.0).is_file();
        if here { Project::Here } else { Project::Carried }
    }

    /// The experiments of one group, by name.
    ///
    /// # Errors
    /// [`Error::File`] for files that cannot be read or hold no experiment, and for a group without any.
    pub(super) fn experiments(self, group: &str) -> Result<Vec<Experiment>> {
        let experiments: Vec<Experiment> = match self {
            Project::Here => in_folder(&Path::new("experiments").join(group))?,
            Project::Carried => shipped::experiments_of(group)
                .map(|(path, text)| Experiment::parse(Path::new(path), text.to_owned()))
                .collect::<Result<_>>()?,
        };
        if experiments.is_empty() {
            return Err(Error::file(Path::new("experiments").join(group), "holds no experiment (*.toml)"));
        }
        Ok(experiments)
    }

    /// The experiment of a file; if there is none of that name, the one that the program carries as
    /// `experiments/<group>/<name>.toml`.
    ///
    /// # Errors
    /// Those of [`Experiment::read`].
    pub(super) fn experiment(path: &Path) -> Result<Experiment> {
        match shipped::EXPERIMENTS.iter().find(|(known, _)| !path.exists() && Path::new(known) == path) {
            Some((_, text)) => Experiment::parse(path, (*text).to_owned()),
            None => Experiment::read(path),
        }
    }

    /// The text of the experiment `<group>/<name>`, if there is one of that name.
    pub(super) fn experiment_text(self, name: &str) -> Option<Cow<'static, str>> {
        let path = format!("experiments/{name}.toml");
        match self {
            Project::Here => std::fs::read_to_string(path).ok().map(Cow::Owned),
            Project::Carried => {
                let found = shipped::EXPERIMENTS.iter().find(|(known, _)| *known == path)?;
                Some(Cow::Borrowed(found.1))
            }
        }
    }

    /// The ranking of schemes.
    ///
    /// # Errors
    /// Those of [`Ranking::read`].
    pub(super) fn ranking(self) -> Result<Ranking> {
        let (path, text) = self.text(shipped::RANKING)?;
        Ranking::parse(path, &text)
    }

    /// The list of figures.
    ///
    /// # Errors
    /// Those of [`FigureList::read`].
    pub(super) fn figures(self) -> Result<FigureList> {
        let (path, text) = self.text(shipped::FIGURES)?;
        FigureList::parse(path, &text)
    }

    /// The list of tables and values of pages, which only the project's folder has.
    ///
    /// # Errors
    /// Those of [`TableList::read`].
    pub(super) fn tables(self) -> Result<TableList> {
        let path = Path::new("paper/tables.toml");
        if self == Project::Here && path.is_file() { TableList::read(path) } else { Ok(TableList::default()) }
    }

    /// The source of the report: its path and text.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read.
    pub(super) fn report(self) -> Result<(&'static Path, Cow<'static, str>)> {
        self.text(shipped::REPORT)
    }

    fn text(self, (path, carried): (&'static str, &'static str)) -> Result<(&'static Path, Cow<'static, str>)> {
        let path = Path::new(path);
        let text = match self {
            Project::Here => std::fs::read_to_string(path).map(Cow::Owned),
            Project::Carried => Ok(Cow::Borrowed(carried)),
        };
        Ok((path, text.map_err(|error| Error::file(path, format!("cannot be read: {error}")))?))
    }
}

fn in_folder(folder: &Path) -> Result<Vec<Experiment>> {
    let entries = std::fs::read_dir(folder).map_err(|error| Error::file(folder, format!("cannot be read: {error}")))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    files.iter().map(|path| Experiment::read(path)).collect()
}

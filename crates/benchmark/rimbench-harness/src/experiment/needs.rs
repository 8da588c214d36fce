//! What the cases of an experiment need that not every machine has.

use serde::Deserialize;
use std::path::PathBuf;
use std::process::Command;

/// Names the folder of the data of others.
const DATA_OF_OTHERS: &str = "RIMBENCH_DATA_OF_OTHERS";

/// Returns the interpreter of Python that the environment names, if it names one; `python3` is meant else.
pub fn named_python() -> Option<PathBuf> {
    std::env::var_os("RIMBENCH_PYTHON").map(PathBuf::from)
}

/// What the cases of an experiment need that not every machine has.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Needs {
    /// Modules of Python.
    #[serde(default)]
    pub modules: Vec<String>,
    /// Files in the folder of the data of others.
    #[serde(default)]
    pub data: Vec<PathBuf>,
}

impl Needs {
    /// Says what of it is not on this machine, in words; `None` if all is.
    pub fn lacking(&self) -> Option<String> {
        let folder = std::env::var_os(DATA_OF_OTHERS).map(PathBuf::from).unwrap_or_default();
        if let Some(file) = self.data.iter().find(|file| !folder.join(file).is_file()) {
            return Some(format!("needs {} in the folder that {DATA_OF_OTHERS} names", file.display()));
        }
        let python = named_python().unwrap_or_else(|| "python3".into());
        let program = "import importlib, sys\nfor name in sys.argv[1:]: importlib.import_module(name)";
        let imported = || Command::new(&python).args(["-c", program]).args(&self.modules).output();
        if self.modules.is_empty() || imported().is_ok_and(|output| output.status.success()) {
            return None;
        }
        Some(format!("needs the modules of Python {}, which {} has not", self.modules.join(", "), python.display()))
    }
}

//! The runs whose work is recorded, which a table `perf` of an experiment file names.

use super::Experiment;
use crate::grid::scalar;
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{RunRequest, RunSpec};
use rimbench_core::error::{Error, Result, shortened};

/// A run of a table `perf`.
#[derive(Debug, Clone)]
pub struct MeasuredRun {
    /// What the file calls it.
    pub name: String,
    /// The run.
    pub spec: RunSpec,
    /// Mean of its interface force (N), and by how much it may differ; none: whatever comes out of a run that completes.
    pub answer: Option<[f64; 2]>,
}

impl Experiment {
    /// Lists the runs whose work is recorded.
    ///
    /// ```text
    /// [perf]
    /// "wedge-box/my-scheme" = { macro_step_s = 1e-3, answer = [-53.8, 1e-3] }
    /// ```
    /// # Errors
    /// [`Error::File`] naming the run and what is wrong; a file without such a table.
    pub fn measured_runs(&self, catalogue: &Catalogue) -> Result<Vec<MeasuredRun>> {
        if self.perf.is_empty() {
            let expected = "[perf] with \"CASE/SCHEME\" = { macro_step_s = … } for each run";
            return Err(Error::file(&self.path, format!("names no run to record; valid: {expected}")));
        }
        let catalogue = &*self.with_own_schemes(catalogue).map_err(|error| Error::file(&self.path, error))?;
        let run = |name: &String| {
            self.measured_run(name, catalogue)
                .map_err(|error| Error::file(&self.path, format!("[perf] `{}`: {error}", shortened(name))))
        };
        self.perf.keys().map(run).collect()
    }

    fn measured_run(&self, name: &str, catalogue: &Catalogue) -> Result<MeasuredRun> {
        let expected = "CASE/SCHEME, and behind another slash what tells it from others";
        let mut words = name.splitn(3, '/');
        let (Some(case), Some(scheme), false) = (words.next(), words.next(), name.contains(char::is_control)) else {
            return Err(Error::invalid("name", format!("{name:?}"), expected));
        };
        let mut request = RunRequest::of(case, scheme);
        let mut answer = None;
        for (key, value) in &self.perf[name] {
            match (key.as_str(), value) {
                ("answer", value) => {
                    let numbers = value.clone().try_into::<[f64; 2]>().ok().filter(|[_, within]| *within >= 0.0);
                    let expected = "two numbers: the mean of the interface force (N), and by how much it may differ";
                    answer = Some(numbers.ok_or_else(|| Error::invalid("answer", value.type_str(), expected))?);
                }
                ("set", toml::Value::Table(set)) => {
                    let text = |(key, value): (&String, &_)| Ok((key.clone(), scalar(key, value)?.to_string()));
                    request.set = set.iter().map(text).collect::<Result<_>>()?;
                }
                ("case" | "scheme", _) => return Err(Error::invalid(key, "given", "no such key: the name says it")),
                (key, value) => request.put(key, scalar(key, value)?)?,
            }
        }
        // A case of a file is known by the name that the file gives it.
        let of_file = self
            .cases
            .iter()
            .filter(|entry| entry.file.is_some())
            .find_map(|entry| entry.find(catalogue).ok().filter(|known| known.name == case));
        let case = of_file.map_or_else(|| catalogue.case(case).cloned(), Ok)?;
        let mut parameters = case.default_parameters();
        request.set.iter().try_for_each(|(key, value)| parameters.set(key, value))?;
        let spec = request.resolve_for(catalogue, &case, &parameters)?;
        Ok(MeasuredRun { name: name.to_owned(), spec, answer })
    }
}

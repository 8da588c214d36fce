//! The figures of the report, from entries in `paper/figures.toml`: figure → experiment, files, columns, caption.
//!
//! To add one of a known kind: add an entry to the file. To add a kind: write a file with a struct of its keys that
//! implements [`FigureOptions`], and list it in `kinds!`.

mod abscissa;
mod cost;
mod default_figures;
mod dots_figure;
mod manoeuvre_figure;
mod mechanism_figure;
mod preview;
mod stability_figure;
mod statistics;
mod trace_figure;
pub(crate) mod valid;
mod xy_figure;

pub use preview::preview;

use super::drawing::Drawing;
use super::pages::fill_text;
use super::render;
use super::report::find_studies;
use super::style::Styles;
use default_figures::default_figures;
use rimbench_core::error::{Error, Result, shortened};
use rimbench_results::checksums::{self, CHECKSUMS};
use rimbench_results::input::read_text;
use rimbench_results::kept::DIGEST;
use rimbench_results::run_table::RunTable;
use rimbench_results::selection::Runs;
use rimbench_results::text_place::{line_of, said_at};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::cell::OnceCell;
use std::collections::BTreeSet;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use toml::{Spanned, Table};

/// The file that lists all figures.
#[derive(Debug, Clone)]
pub struct FigureList {
    /// In the order of the report.
    pub figures: Vec<FigureEntry>,
}

/// The file before its figures are looked at one by one.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawList {
    #[serde(rename = "figure")]
    figures: Vec<Spanned<Table>>,
}

/// One figure: where its numbers come from and what it shows.
#[derive(Debug, Clone)]
pub struct FigureEntry {
    /// What every figure has.
    head: Head,
    /// What kind of figure it is, with its options.
    pub kind: FigureKind,
    /// Labels of scheme rows that it asks for.
    labels: Vec<String>,
}

/// The keys of every figure besides its kind.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// File name and anchor.
    #[serde(deserialize_with = "valid::file_name")]
    pub id: String,
    /// Experiment whose results it reads, `group/name`, and beside which it is written.
    #[serde(deserialize_with = "valid::experiment")]
    pub experiment: String,
    /// Files it reads, relative to the experiment's folder, for the reader.
    #[serde(default = "rows")]
    pub source: String,
    /// What is found, above the picture.
    #[serde(default)]
    pub title: String,
    /// What is drawn, and under which conditions, below the title.
    #[serde(default)]
    pub subtitle: String,
    /// Claims of its experiment that the title says in words, by their ids.
    #[serde(default)]
    pub claims: Vec<String>,
    /// How to read it.
    #[serde(default)]
    pub caption: String,
}

fn rows() -> String {
    "runs.csv".to_owned()
}

impl Deref for FigureEntry {
    type Target = Head;

    fn deref(&self) -> &Head {
        &self.head
    }
}

/// What figures of one experiment are drawn from.
struct Source {
    /// The experiment's folder.
    folder: PathBuf,
    runs: OnceCell<RunTable>,
}

impl Source {
    /// The results in a folder: half a file, or one that was edited, is no source of a figure.
    fn of(folder: PathBuf) -> Result<Self> {
        checksums::verify(&folder).map(|()| Source { folder, runs: OnceCell::new() })
    }

    /// The table of runs, which is read once.
    fn runs(&self) -> Result<&RunTable> {
        match self.runs.get() {
            Some(table) => Ok(table),
            None => RunTable::read_from(&self.folder).map(|table| self.runs.get_or_init(|| table)),
        }
    }
}

/// The options of a kind of figure, read from the keys of its fields.
trait FigureOptions: DeserializeOwned {
    /// A panel: keys of it that stand in the figure hold for all panels that do not say otherwise. `()` for a kind
    /// without panels.
    type Panel: DeserializeOwned;

    /// Draws the figure from an experiment's folder.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing>;

    /// Fills in what other keys say, and refuses keys that do not go together.
    fn finish(&mut self) -> Result<(), String> {
        Ok(())
    }

    /// Reads the options.
    fn read(mut table: Table) -> Result<Self, String> {
        let [own, of_panels] = [valid::fields::<Self>(), valid::fields::<Self::Panel>()];
        for name in table.keys().filter(|name| !own.contains(&name.as_str())).cloned().collect::<Vec<_>>() {
            if !of_panels.contains(&name.as_str()) {
                return Err(valid::unknown_key(
                    &name,
                    valid::fields::<Head>().iter().chain(own).chain(of_panels).copied(),
                ));
            }
            let value = table.remove(&name).unwrap_or(toml::Value::Boolean(false));
            let panels = table.get_mut("panels").and_then(toml::Value::as_array_mut).into_iter().flatten();
            for panel in panels.filter_map(toml::Value::as_table_mut) {
                panel.entry(name.as_str()).or_insert_with(|| value.clone());
            }
        }
        let mut options: Self = valid::read(table)?;
        options.finish().map(|()| options)
    }
}

/// Declares the kinds of figures, each with its name and its options.
macro_rules! kinds {
    ($($name:literal $(#[$doc:meta])* $kind:ident($figure:ty),)*) => {
        /// The kinds of figures.
        #[derive(Debug, Clone)]
        pub enum FigureKind {
            $($(#[$doc])* $kind($figure),)*
        }

        impl FigureKind {
            fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
                match self {
                    $(FigureKind::$kind(figure) => figure.draw(source, styles),)*
                }
            }

            fn read(name: &str, table: Table) -> Result<Self, String> {
                match name {
                    $($name => <$figure>::read(table).map(FigureKind::$kind),)*
                    _ => Err(Error::unknown("kind of figure", name, [$($name),*]).to_string()),
                }
            }
        }

        /// Every key of the list of figures, each with the kind that has it; those of every figure are of the kind "".
        pub fn figure_keys() -> Vec<(&'static str, &'static str)> {
            let of = |kind, keys: &'static [&'static str]| keys.iter().map(move |key| (kind, *key));
            let all = of("", &["kind"]).chain(of("", valid::fields::<Head>()));
            $(let all = all.chain(of($name, valid::fields::<$figure>()));
            let all = all.chain(of($name, valid::fields::<<$figure as FigureOptions>::Panel>()));)*
            all.collect()
        }
    };
}

kinds! {
    "manoeuvre"
    /// A case at a row of instants.
    Manoeuvre(manoeuvre_figure::ManoeuvreFigure),
    "mechanism"
    /// What schemes believe within one macro step.
    Mechanism(mechanism_figure::MechanismFigure),
    "traces"
    /// Columns of traces over time.
    Traces(trace_figure::TraceFigure),
    "dots"
    /// A metric of many schemes at a few macro steps, in ranked rows.
    Dots(dots_figure::DotsFigure),
    "xy"
    /// A metric against the macro step, a parameter of the case or the cost.
    Xy(xy_figure::XyFigure),
    "stability-map"
    /// What became of the runs by scheme and macro step, the number of cases by scheme and limit, or the share that
    /// fails by case and macro step.
    StabilityMap(stability_figure::StabilityFigure),
}

/// What came of drawing all figures.
#[derive(Debug, Clone, Default)]
pub struct MadeFigures {
    /// Files written.
    pub files: Vec<PathBuf>,
    /// Figures whose experiments have no results yet: id and reason.
    pub missing: Vec<(String, String)>,
    /// Figures that cannot be drawn from the results there are: id and reason, with the older picture if there is one.
    pub failed: Vec<(String, String)>,
}

/// Whether an experiment `group/name` is one, or is of one group; of none is all.
fn is_in(experiment: &str, part: Option<&str>) -> bool {
    part.is_none_or(|part| experiment.strip_prefix(part).is_some_and(|rest| rest.is_empty() || rest.starts_with('/')))
}

/// Whether a folder has the results of a run from which figures are drawn; where only a few files are kept, the figures
/// are among them.
fn has_rows(folder: &Path) -> bool {
    let is_checkout =
        || folder.join(DIGEST).exists() && !["cost.csv", CHECKSUMS].iter().any(|name| folder.join(name).exists());
    folder.join("runs.csv").is_file() && !is_checkout()
}

impl FigureList {
    /// Reads the list.
    ///
    /// # Errors
    /// [`Error::File`] with all that is wrong, each with its line.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, &read_text(path)?)
    }

    /// Reads the text of a list; `path` is what errors name.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let RawList { figures: raw } = toml::from_str(text).map_err(|error| {
            Error::file(path, format!("is no list of figures: {}", said_at(text, error.span(), error.message())))
        })?;
        let (mut figures, mut faults): (Vec<FigureEntry>, Vec<String>) = Default::default();
        for entry in raw {
            let line = line_of(text, entry.span().start);
            let table = entry.into_inner();
            let name = table.get("id").and_then(toml::Value::as_str).unwrap_or_default().to_owned();
            let twice = figures.iter().any(|figure| figure.id == name);
            let read = FigureEntry::checked(table).map(|figure| figures.push(figure));
            let mut wrong: Vec<String> = read.err().into_iter().collect();
            if twice {
                wrong.push("another figure has this id".to_owned());
            }
            let place = if name.is_empty() { String::new() } else { format!(" (`{}`)", shortened(&name)) };
            faults.extend(wrong.iter().map(|fault| format!("[[figure]] in line {line}{place}: {fault}")));
        }
        match faults.len() {
            0 => Ok(FigureList { figures }),
            1 => Err(Error::file(path, &faults[0])),
            count => Err(Error::file(path, format!("{count} things are wrong:\n  {}", faults.join("\n  ")))),
        }
    }

    /// The figures of an experiment's folder, named `group/name`: those of the list, or, where it names none for it, a
    /// stability map and the error against the macro step.
    ///
    /// # Errors
    /// [`Error::File`] for results without the columns of runs.
    pub fn of_experiment(&self, name: &str, folder: &Path) -> Result<Vec<FigureEntry>> {
        let own: Vec<FigureEntry> = self.figures.iter().filter(|figure| figure.experiment == name).cloned().collect();
        if own.is_empty() { default_figures(name, folder) } else { Ok(own) }
    }

    /// The figures of one group of experiments, of one experiment `group/name`, or of all.
    pub fn of_part(&self, part: Option<&str>) -> Vec<&FigureEntry> {
        self.figures.iter().filter(|figure| is_in(&figure.experiment, part)).collect()
    }

    /// The list, with the figures of [`of_experiment`](Self::of_experiment) for every experiment below a folder of
    /// results, in a part of it or in all, that it does not name. Also returned: experiments whose results no figure
    /// can be made of, with the reason.
    pub fn completed(mut self, results: &Path, part: Option<&str>) -> (Self, Vec<(String, String)>) {
        let mut failed = Vec::new();
        for folder in find_studies(results).unwrap_or_default().iter().filter(|folder| has_rows(folder)) {
            let parts = folder.strip_prefix(results).unwrap_or(folder).iter().map(|part| part.to_string_lossy());
            let name = parts.collect::<Vec<_>>().join("/");
            if !is_in(&name, part) || self.figures.iter().any(|figure| figure.experiment == name) {
                continue;
            }
            match default_figures(&name, folder) {
                Ok(figures) => self.figures.extend(figures),
                Err(error) => failed.push((name, error.to_string())),
            }
        }
        (self, failed)
    }

    /// Draws the figures of one group of experiments, of one experiment, or of all, whose rows are there, in one of
    /// [`render::FORMATS`]; names the others.
    ///
    /// Results that lack a file, a column or a label (older than the figure, say) are a failure, with the reason.
    ///
    /// # Errors
    /// [`Error::File`] if there is no such folder of results, and those of [`render::check_format`];
    /// [`Error::UnknownName`] for a part without figures.
    pub fn make_all(
        &self,
        results: &Path,
        part: Option<&str>,
        (styles, format): (&Styles, &str),
    ) -> Result<MadeFigures> {
        if !results.is_dir() {
            return Err(Error::file(results, "is not a folder of results"));
        }
        render::check_format(&results.join(format!("*.{format}")))?;
        if let Some(part) = part.filter(|part| self.of_part(Some(part)).is_empty()) {
            let groups: BTreeSet<&str> = self.figures.iter().map(FigureEntry::group).collect();
            return Err(Error::unknown("group of figures", part, groups));
        }
        let mut made = MadeFigures::default();
        let mut source: Option<Source> = None;
        for figure in self.of_part(part) {
            let folder = results.join(&figure.experiment);
            if !has_rows(&folder) {
                let reason = format!("no results in {}: run experiments/{}.toml", folder.display(), figure.experiment);
                made.missing.push((figure.id.clone(), reason));
                continue;
            }
            // Figures of one experiment stand together.
            let of_it = match source.take_if(|source| source.folder == folder) {
                Some(same) => Ok(same),
                None => Source::of(folder.clone()),
            };
            match of_it.and_then(|of_it| figure.make_from(source.insert(of_it), results, (styles, format))) {
                Ok(files) => made.files.push(files),
                Err(error) => {
                    let old = folder.join("figures").join(format!("{}.{format}", figure.id));
                    let stale = if old.exists() { format!("; {} is older", old.display()) } else { String::new() };
                    made.failed.push((figure.id.clone(), format!("{error}{stale}")));
                }
            }
        }
        Ok(made)
    }
}

/// Labels of scheme rows that a figure asks for anywhere in it, `reference` aside.
fn labels(value: &toml::Value) -> Vec<String> {
    let inside = |value: &toml::Value| match value {
        toml::Value::Table(_) => labels(value),
        toml::Value::Array(values) => values.iter().flat_map(labels).collect(),
        _ => Vec::new(),
    };
    let of_key = |(key, value): (&String, &toml::Value)| match value {
        toml::Value::Array(list) if ["labels", "series", "schemes"].contains(&key.as_str()) => {
            list.iter().filter_map(toml::Value::as_str).filter(|name| *name != "reference").map(str::to_owned).collect()
        }
        value => inside(value),
    };
    value.as_table().into_iter().flatten().flat_map(of_key).collect()
}

impl FigureEntry {
    /// Reads an entry, or says what is wrong with it.
    fn checked(mut table: Table) -> Result<Self, String> {
        let wrong = |(key, value): (&String, &toml::Value)| Some((key.clone(), shortened(valid::unwritable(value)?)));
        if let Some((key, text)) = table.iter().find_map(wrong) {
            return Err(format!("{key} = {text:?} is not valid; valid: text in one line"));
        }
        let labels = labels(&toml::Value::Table(table.clone()));
        let mut own = Table::new();
        own.extend(valid::fields::<Head>().iter().filter_map(|key| table.remove_entry(*key)));
        let head: Head = valid::read(own)?;
        let kind = match table.remove("kind") {
            Some(toml::Value::String(name)) => FigureKind::read(&name, table)?,
            Some(_) => return Err("kind is not valid; valid: the name of a kind of figure, in quotes".to_owned()),
            None => return Err("missing field `kind`".to_owned()),
        };
        Ok(FigureEntry { head, kind, labels })
    }

    /// The group of its experiment.
    pub fn group(&self) -> &str {
        self.experiment.split('/').next().unwrap_or_default()
    }

    /// Lists the labels of scheme rows that it asks for; none if it shows all.
    pub fn labels(&self) -> &[String] {
        &self.labels
    }

    /// What is said of the figure, with what claims in `results` measured where `{claim=…}` asks for it.
    ///
    /// # Errors
    /// [`Error::File`] for a claim that is not there.
    pub fn said(&self, results: &Path) -> Result<Head> {
        let [title, subtitle, caption] =
            [&self.title, &self.subtitle, &self.caption].map(|text| fill_text(text, results));
        Ok(Head { title: title?, subtitle: subtitle?, caption: caption?, ..self.head.clone() })
    }

    /// Draws the figure from the results below `results` and writes it beside them, as SVG.
    ///
    /// # Errors
    /// [`Error::File`] for results that are missing or do not hold what the figure shows.
    pub fn make(&self, results: &Path, styles: &Styles) -> Result<PathBuf> {
        self.make_from(&Source::of(results.join(&self.experiment))?, results, (styles, "svg"))
    }

    fn make_from(&self, source: &Source, results: &Path, (styles, format): (&Styles, &str)) -> Result<PathBuf> {
        let drawing = self.drawn_from(source, results, styles)?;
        let figures = source.folder.join("figures");
        std::fs::create_dir_all(&figures).map_err(|error| Error::file(&figures, format!("cannot be made: {error}")))?;
        let path = figures.join(format!("{}.{format}", self.id));
        render::write(&drawing, &path).map(|()| path)
    }

    /// Draws the figure from the results below `results`.
    ///
    /// # Errors
    /// Those of [`make`](Self::make), writing aside.
    pub fn drawn(&self, results: &Path, styles: &Styles) -> Result<Drawing> {
        self.drawn_from(&Source::of(results.join(&self.experiment))?, results, styles)
    }

    fn drawn_from(&self, source: &Source, results: &Path, styles: &Styles) -> Result<Drawing> {
        self.check_labels(source)?;
        let said = self.said(results)?;
        let mut drawing = self.kind.draw(source, styles)?.headed(&said.title, &said.subtitle);
        // A picture without a heading has a name all the same, for those who do not see it.
        if drawing.title.trim_matches([';', ' ']).is_empty() {
            let sentence = said.caption.split(". ").next().unwrap_or_default();
            drawing.title = if sentence.is_empty() { self.id.clone() } else { sentence.to_owned() };
        }
        Ok(drawing)
    }

    /// A label that no run has would be left out without a word.
    fn check_labels(&self, source: &Source) -> Result<()> {
        if self.labels.is_empty() {
            return Ok(());
        }
        let table = source.runs()?;
        let known = Runs::of(table).labels(&[]);
        let unknown = self.labels.iter().find(|label| !known.contains(&label.as_str()));
        unknown.map_or(Ok(()), |label| {
            Err(Error::file(table.path(), Error::unknown("label", label, known.iter().copied())))
        })
    }
}

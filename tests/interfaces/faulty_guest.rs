//! A mass and a spring as FMUs, or as classes of Python, with faults that are switched on by name, and calls of the program
//! on a case of them.
#![cfg(target_os = "linux")]

use crate::program::process;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Mutex, OnceLock};
use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const SOURCE: &str = include_str!("faulty_fmu.c");

/// A mass of 1 kg at 0.1 m, or the spring of 100 N/m on which it is: x = 0.1 cos 10 t.
pub struct Guest<'a> {
    pub role: &'a str,
    pub version: u32,
    pub faults: &'a [&'a str],
    /// Pieces of the description, each with what stands in its place.
    pub changes: &'a [(&'a str, &'a str)],
    pub state: bool,
}

pub const MASS: Guest<'_> = Guest { role: "mass", version: 3, faults: &[], changes: &[], state: true };
pub const SPRING: Guest<'_> = Guest { role: "spring", ..MASS };

impl Guest<'_> {
    fn description(&self) -> String {
        let (mass, two) = (self.role == "mass", self.version == 2);
        let real = |name: &str, reference: u32, causality: &str, unit: &str, start: &str| {
            let fixed = if causality == "parameter" { "fixed" } else { "continuous" };
            let initial = match causality {
                "output" => " initial=\"calculated\"",
                "parameter" => " initial=\"exact\"",
                _ => "",
            };
            let start = if causality == "output" { String::new() } else { format!(" start=\"{start}\"") };
            let head = format!(
                "name=\"{name}\" valueReference=\"{reference}\" causality=\"{causality}\" variability=\"{fixed}\"{initial}"
            );
            let tail = format!("unit=\"{unit}\"{start}");
            if two {
                format!("<ScalarVariable {head}><Real {tail}/></ScalarVariable>")
            } else {
                format!("<Float64 {head} {tail}/>")
            }
        };
        let [given, taken] = if mass { ["output", "input"] } else { ["input", "output"] };
        let own = if mass { ["m", "kg", "1", "x0", "0.1"] } else { ["k", "N/m", "100", "rest", "0"] };
        let variables = [
            real("x", 0, given, "m", "0"),
            real("v", 1, given, "m/s", "0"),
            real("f", 2, taken, "N", "0"),
            real(own[0], 3, "parameter", own[1], own[2]),
            real("d", 4, "parameter", "N.s/m", "0"),
            real(own[3], 5, "parameter", "m", own[4]),
        ];
        let depend = if mass {
            ""
        } else if two {
            "1 2"
        } else {
            "0 1"
        };
        let outputs: String = (if mass { 0..2 } else { 2..3 })
            .map(|output| match two {
                true => format!("<Unknown index=\"{}\" dependencies=\"{depend}\"/>", output + 1),
                false => format!("<Output valueReference=\"{output}\" dependencies=\"{depend}\"/>"),
            })
            .collect();
        let outputs = if two { format!("<Outputs>{outputs}</Outputs>") } else { outputs };
        let [token, flag] =
            if two { ["guid", "canGetAndSetFMUstate"] } else { ["instantiationToken", "canGetAndSetFMUState"] };
        let mut text = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?><fmiModelDescription fmiVersion=\"{}.0\" modelName=\"guest\" {token}=\"guest\">\
             <CoSimulation modelIdentifier=\"guest\" canHandleVariableCommunicationStepSize=\"true\" {flag}=\"{}\"/><UnitDefinitions>\
             <Unit name=\"m\"><BaseUnit m=\"1\"/></Unit><Unit name=\"m/s\"><BaseUnit m=\"1\" s=\"-1\"/></Unit>\
             <Unit name=\"N\"><BaseUnit kg=\"1\" m=\"1\" s=\"-2\"/></Unit></UnitDefinitions><ModelVariables>{}</ModelVariables>\
             <ModelStructure>{outputs}</ModelStructure></fmiModelDescription>",
            self.version,
            self.state,
            variables.concat(),
        );
        for (from, to) in self.changes {
            assert!(text.contains(from), "{from} is not in {text}");
            text = text.replace(from, to);
        }
        text
    }

    /// Compiles and packs it; nothing where there is no C compiler.
    pub fn packed(&self, file: &Path) -> Option<()> {
        let library = self.compiled()?;
        let mut archive = ZipWriter::new(fs::File::create(file).unwrap());
        let mut put = |name: &str, bytes: &[u8]| {
            archive.start_file(name, SimpleFileOptions::default().unix_permissions(0o755)).unwrap();
            archive.write_all(bytes).unwrap();
        };
        put("modelDescription.xml", self.description().as_bytes());
        let platform =
            if self.version == 2 { "linux64".to_owned() } else { format!("{}-linux", std::env::consts::ARCH) };
        put(&format!("binaries/{platform}/guest.so"), &library);
        archive.finish().unwrap();
        Some(())
    }

    /// The library, compiled once for all tests; nothing where there is no C compiler.
    fn compiled(&self) -> Option<Vec<u8>> {
        static LIBRARIES: Mutex<BTreeMap<Vec<String>, Vec<u8>>> = Mutex::new(BTreeMap::new());
        let of_own = [format!("V={}", self.version), format!("ROLE={}", u32::from(self.role != "mass"))];
        let of_own = of_own.into_iter().chain(self.faults.iter().map(|fault| (*fault).to_owned()));
        let macros: Vec<String> = of_own.map(|own| format!("-D{own}")).collect();
        if let Some(library) = LIBRARIES.lock().unwrap().get(&macros) {
            return Some(library.clone());
        }
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("guest.c"), SOURCE).unwrap();
        let mut compiler = Command::new("cc");
        compiler.args(["-shared", "-fPIC", "-O0", "-w", "-ffp-contract=off", "-o", "guest.so", "guest.c"]);
        if !compiler
            .args(&macros)
            .args(["-lm", "-lpthread"])
            .current_dir(folder.path())
            .status()
            .is_ok_and(|status| status.success())
        {
            eprintln!("skipped: there is no C compiler `cc` on the path");
            return None;
        }
        let library = fs::read(folder.path().join("guest.so")).unwrap();
        LIBRARIES.lock().unwrap().insert(macros, library.clone());
        Some(library)
    }
}

pub const ENDS: &str = "position = \"x\", velocity = \"v\", force = \"f\"";

/// A folder with two sides and a case of them, `changes` made in its text.
pub fn case(mass: &Guest<'_>, spring: &Guest<'_>, changes: &[(&str, &str)]) -> Option<TempDir> {
    let folder = tempfile::tempdir().unwrap();
    mass.packed(&folder.path().join("mass.fmu"))?;
    spring.packed(&folder.path().join("spring.fmu"))?;
    write_case(folder.path(), changes);
    Some(folder)
}

pub fn write_case(folder: &Path, changes: &[(&str, &str)]) {
    let mut text = format!(
        "name = \"pair\"\nduration_s = 0.2\nmacro_step_s = 1e-3\nmicro_step_s = 1e-3\nreference_step_s = 4e-4\n[mechanics]\nfmu = \
         \"mass.fmu\"\n[actuator]\nfmu = \"spring.fmu\"\n[[interface]]\nmechanics = {{ {ENDS} }}\nactuator = {{ {ENDS} }}\n"
    );
    for (from, to) in changes {
        assert!(text.contains(from), "{from} is not in {text}");
        text = text.replacen(from, to, 1);
    }
    fs::write(folder.join("case.toml"), text).unwrap();
}

/// The program in a folder, with a cache of its own there.
pub fn inside(folder: &Path) -> Command {
    let mut command = process();
    command.current_dir(folder).env("RIMBENCH_CACHE", folder.join("cache"));
    if let Some(python) = python() {
        command.env("RIMBENCH_PYTHON", python);
    }
    command
}

/// The interpreter itself, which a `python3` that looks for one first takes longer to start than a run; none where
/// there is none.
pub fn python() -> Option<&'static str> {
    static PYTHON: OnceLock<Option<String>> = OnceLock::new();
    let ask = || {
        let output = Command::new("python3").args(["-c", "import sys; print(sys.executable)"]).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    PYTHON.get_or_init(ask).as_deref()
}

pub fn output(folder: &Path, arguments: &str) -> Output {
    let mut command = inside(folder);
    command.args(["simulate", "--case", "case.toml"]).args(arguments.split_whitespace()).output().unwrap()
}

/// One run as JSON, and what is said besides.
pub fn run(folder: &Path, arguments: &str) -> (Value, String) {
    let output = output(folder, &format!("{arguments} --format json"));
    let shown = String::from_utf8_lossy(&output.stderr).into_owned();
    // A run that is skipped is no answer, and has another exit code.
    assert!(matches!(output.status.code(), Some(0 | 1)), "{shown}");
    (serde_json::from_slice(&output.stdout).unwrap(), shown)
}

/// Bad input, in its words.
pub fn refused(folder: &Path) -> String {
    let output = output(folder, "--scheme zero-order-hold");
    let shown = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{shown}");
    shown
}

/// The last number of a column of the trace of a run.
pub fn last(folder: &Path, column: &str) -> f64 {
    run(folder, "--scheme zero-order-hold --trace trace.csv");
    traced(folder, column)
}

/// The last number of a column of the trace that is there.
pub fn traced(folder: &Path, column: &str) -> f64 {
    let mut reader = csv::Reader::from_path(folder.join("trace.csv")).unwrap();
    let at = reader.headers().unwrap().iter().position(|name| name == column).unwrap();
    reader.records().last().unwrap().unwrap()[at].parse().unwrap()
}

pub const POSITION: &str = "interface_position_m";

/// Both as classes of Python, with heirs that have a fault.
pub const SIDES: &str = r#"
class Mass:
    def __init__(self, parameters):
        self.m, self.x, self.v = parameters.get("m", 1.0), 0.1, 0.0

    def outputs(self, u):
        return self.x, self.v

    def step(self, t, u, h):
        # n steps as the FMU takes them, first the velocity and then the position, in one.
        n = max(round(h / 1e-5), 1)
        self.x += h * self.v + 0.5 * (1 + 1 / n) * h**2 * u[0] / self.m
        self.v += h * u[0] / self.m

    def interface_model(self, h):
        return {"H": [[1 / self.m]], "a": [0.0], "w": [self.v], "position": [self.x], "gap": []}


class Spring:
    direct_feedthrough = True

    def __init__(self, parameters):
        self.k = parameters.get("k", 100.0)

    def outputs(self, u):
        return (-self.k * u[0],)

    def step(self, t, u, h):
        pass


class Stopped(Mass):
    """Before a stop at 90 mm, a row of an engine from 5 mm on."""
    engine_rows, model_from_s = 2, 5e-4
    R, b, k, near = 0.1, 200.0, 1e4, 1

    def step(self, t, u, h):
        free, gap = self.v + h * u[0] / self.m, self.x - 0.09
        wanted = free - (1 - h * self.b) * self.v + h * self.k * gap
        P = max(0.0, -wanted / (1 / self.m + self.R)) if gap < 0.005 else 0.0
        self.v = free + P / self.m
        self.x += h * self.v

    def interface_model(self, h):
        n = self.near * (self.x < 0.095)
        model = {name: [value] * n for name, value in (("compliance", self.R), ("damping", self.b), ("stiffness", self.k), ("gap", self.x - 0.09))}
        return model | {"H": [[1 / self.m] * (n + 1)] * (n + 1), "a": [0.0] * (n + 1), "w": [self.v] * (n + 1), "position": [self.x]}


class Crowded(Stopped):
    near = 3


class Quick(Spring):
    takes_arrays = True

    def outputs(self, u):
        assert not isinstance(u, tuple)
        return super().outputs(u)

    def output_rates(self, t, u):
        assert not isinstance(u, tuple)
        return {"rate": [0.0], "feedthrough": [[-self.k, 0.0]]}


class Forgets(Mass):
    def __deepcopy__(self, memo):
        copy = type(self)({})
        copy.x = self.x
        return copy


class Stale(Mass):
    def interface_model(self, h):
        return {**super().interface_model(h), "w": [0.0]}


class Backwards(Mass):
    def interface_model(self, h):
        return {**super().interface_model(h), "H": [[-1.0]]}


class NotFinite(Mass):
    def interface_model(self, h):
        return {**super().interface_model(h), "H": [[float("nan")]]}


class Reversed(Mass):
    def outputs(self, u):
        return self.x, -self.v

    def interface_model(self, h):
        return {**super().interface_model(h), "w": [-self.v]}


class Millimetres(Mass):
    def outputs(self, u):
        return 1000 * self.x, self.v

    def interface_model(self, h):
        return {**super().interface_model(h), "position": [1000 * self.x]}


class Heavy(Mass):
    def interface_model(self, h):
        return {**super().interface_model(h), "H": [[0.1]]}


class Pushed(Mass):
    def interface_model(self, h):
        return {**super().interface_model(h), "a": [1e4]}


class Texts(Mass):
    def outputs(self, u):
        return str(self.x), str(self.v)


class Turns(Mass):
    time = 0.0

    def step(self, t, u, h):
        self.time = t + h
        super().step(t, u, h)

    def interface_model(self, h):
        model = super().interface_model(h)
        return model if self.time < 0.1 else {**model, "w": [9.0], "position": [5.0]}


class Raises(Mass):
    def step(self, t, u, h):
        raise ValueError("no solution")
"#;

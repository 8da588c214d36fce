"""FMUs between rimbench and others: what it writes is driven by FMPy, what pythonfmu makes is driven by it.

Usage: masters.py PROGRAM FOLDER. Needs FMPy; tests that need more say so and are skipped. Every test is a function; the first that fails
ends it with a traceback.
"""

import csv
import json
import os
import subprocess
import sys
import sysconfig
import time
import zipfile
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

PROGRAM, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
SIDES = ("mechanics", "actuator")
VERSIONS = ("3.0", "2.0")


class Skipped(Exception):
    """What this test needs is not there."""


def rimbench(*arguments, code=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], cwd=FOLDER, capture_output=True, text=True)
    assert done.returncode == code, (arguments, done.returncode, done.stderr)
    return done.stderr if code else done.stdout


# Cases with contact in space, which an FMU has no variables for.
IN_SPACE = {"tripod", "four-legs", "wedge-box-space"}


def cases():
    """Cases that are exported."""
    names = [case["name"] for case in json.loads(rimbench("list", "cases", "--format", "json"))]
    assert IN_SPACE < set(names), names
    return [name for name in names if name not in IN_SPACE]


def rows(file):
    with open(FOLDER / file) as text:
        return list(csv.DictReader(text))


WRITTEN = {}


def export(case, side, *more):
    """An FMU, written once; beside it a run of the case."""
    key = (case, side, *more)
    if key not in WRITTEN:
        WRITTEN[key] = FOLDER / f"{case}-{side}{len(WRITTEN)}.fmu"
        short = ("--duration", SHORT[case]) if case in SHORT and "--duration" not in more else ()
        rimbench("fmu", "--case", case, "--side", side, "--out", WRITTEN[key], *more, *short)
    return WRITTEN[key]


def exchanged(file):
    """The run beside an FMU: inputs and outputs at each communication point, under the names of the FMU and `time`."""
    heard, said = (rows(file.with_name(f"{file.stem}_{kind}.csv")) for kind in ("in", "ref"))
    assert len(heard) == len(said)
    return [{name: float(cell) for name, cell in {**a, **b}.items()} for a, b in zip(heard, said)]


class Side:
    """One instance, by names."""

    def __init__(self, file, **parameters):
        description = read_model_description(file)
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}
        of = lambda causality: [v.name for v in description.modelVariables if v.causality == causality]
        experiment = description.defaultExperiment
        self.macro_step, self.stop = float(experiment.stepSize), float(experiment.stopTime)
        self.inputs = of("input")
        self.outputs = [name for name in of("output") if not name.startswith(("rim.", "der("))]
        self.two = description.fmiVersion == "2.0"
        self.fmu = (FMU2Slave if self.two else FMU3Slave)(
            guid=description.guid,
            unzipDirectory=extract(file),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=str(file),
        )
        self.fmu.instantiate()
        for name, value in parameters.items():
            self.set([name], [value])
        self.begin()

    def begin(self):
        if self.two:
            self.fmu.setupExperiment(startTime=0.0)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=0)
        self.fmu.exitInitializationMode()

    def get(self, names, **more):
        get = self.fmu.getReal if self.two else self.fmu.getFloat64
        return list(get([self.references[name] for name in names], **more))

    def set(self, names, values):
        (self.fmu.setReal if self.two else self.fmu.setFloat64)([self.references[name] for name in names], values)

    def derivative(self, unknown, known):
        return self.fmu.getDirectionalDerivative([self.references[unknown]], [self.references[known]], [1.0])[0]

    def keep(self):
        return self.fmu.getFMUstate() if self.two else self.fmu.getFMUState()

    def restore(self, state):
        (self.fmu.setFMUstate if self.two else self.fmu.setFMUState)(state)

    def serialised(self, state):
        return (self.fmu.serializeFMUstate if self.two else self.fmu.serializeFMUState)(state)

    def restore_serialised(self, data):
        self.restore((self.fmu.deSerializeFMUstate if self.two else self.fmu.deserializeFMUState)(data))


def drive(mechanics, actuator, times, macro_step):
    """A plain loop with held inputs; returns what was said at each communication point.

    All steps are of one length but the one that ends the simulation, which takes what is left.
    """
    said = []
    for k, t in enumerate(times):
        motion = mechanics.get(mechanics.outputs)
        actuator.set(actuator.inputs, motion)
        force = actuator.get(actuator.outputs)
        mechanics.set(mechanics.inputs, force)
        said.append([t, *motion, *force])
        if k + 1 < len(times):
            h = macro_step if times[k + 1] < mechanics.stop else times[k + 1] - t
            mechanics.fmu.doStep(t, h)
            actuator.fmu.doStep(t, h)
    return said


H = 1e-3
# Cases with thousands of macro steps, of which a part will do: durations, s.
SHORT = {"linear-oscillator": 1, "hydraulic-crane": 1, "quarter-car": 1}


def every_exported_fmu_is_valid_and_driven_by_fmpy_gives_the_digits_of_the_run_beside_it_for_both_versions():
    points = 0
    for case in cases():
        runs = []
        for version in VERSIONS:
            files = [export(case, side, "--fmi", version) for side in SIDES]
            for file in files:
                problems = validate_fmu(str(file))
                assert problems == [], (file, problems)
            told = exchanged(files[0])
            mechanics, actuator = (Side(str(file)) for file in files)
            assert ("time" in mechanics.references) == (version == "3.0"), mechanics.references
            try:
                said = drive(mechanics, actuator, [row["time"] for row in told], mechanics.macro_step)
            except Exception as error:
                raise AssertionError(f"{case}, FMI {version}: {error}") from error
            columns = ["time", *mechanics.outputs, *actuator.outputs]
            for row, values in zip(told, said):
                assert [row[column] for column in columns] == values, (case, version, row, values)
            points += len(said)
            # What both have besides, at the end.
            both = {}
            for side in (mechanics, actuator):
                names = [n for n in side.references if n.endswith(("_m", "_n", "_j", "_pa", "_rad", "_s")) and "." not in n]
                # As text: what is not a number is equal to itself.
                both.update((name, repr(side.get([name]))) for name in names)
            runs.append((said, both))
        assert runs[0] == runs[1], case
    print(f"{len(cases())} cases, {points} communication points, to the bit")


def a_master_of_fixed_steps_has_any_phase_by_letting_the_models_wait():
    largest = 0.0
    for case, h in (("wedge-box", 2e-3), ("rocking-block", 1e-3), ("half-car", 1e-3)):
        for version in VERSIONS:
            files = [export(case, side, "--fmi", version) for side in SIDES]
            for phase in (1.0, 0.7639320225002102, 0.1458980337503153):
                arguments = ["--scheme", "zero-order-hold", "--macro-step", h, "--phase", phase, "--duration", 0.4]
                rimbench("simulate", "--case", case, *arguments, "--trace", "phase.csv")
                trace = rows("phase.csv")
                mechanics, actuator = (Side(str(file), wait_s=(1 - phase) * h) for file in files)
                # The last step takes what is left, which such a master cannot.
                said = drive(mechanics, actuator, [k * h for k in range(len(trace) - 1)], h)
                names = [*mechanics.outputs, *actuator.outputs]
                for at, name in enumerate(names, 1):
                    peak = max(abs(float(row[name])) for row in trace)
                    worst = max(abs(float(row[name]) - values[at]) for row, values in zip(trace, said))
                    assert worst <= 1e-9 * peak, (case, version, phase, name, worst, peak)
                    largest = max(largest, worst / peak)
    print(f"within {largest:.1e} of the peaks")


def work_sent_and_received_leave_what_the_program_says():
    arguments = ["--case", "wedge-box", "--scheme", "zero-order-hold", "--macro-step", H, "--format", "json"]
    run = json.loads(rimbench("simulate", *arguments))
    for version in VERSIONS:
        sides = [Side(str(export("wedge-box", side, "--fmi", version))) for side in SIDES]
        drive(*sides, [k * H for k in range(2501)], H)
        (received,), (sent,) = sides[0].get(["interface_work_j"]), sides[1].get(["work_sent_j"])
        assert sent - received == run["interface_residual_j"], (version, sent, received, run["interface_residual_j"])


def the_files_beside_an_fmu_are_those_of_the_cross_check_and_fmpy_repeats_them():
    from fmpy import simulate_fmu
    from fmpy.util import read_csv, read_ref_opt_file

    for version in VERSIONS:
        for side in SIDES:
            file = export("wedge-box", side, "--fmi", version, "--macro-step", H, "--duration", "0.5")
            beside = lambda end: file.with_name(file.stem + end)
            options = read_ref_opt_file(beside("_ref.opt"))
            assert [options[key] for key in ("StartTime", "StopTime", "StepSize")] == [0.0, 0.5, H], options
            assert file.with_name("Readme.txt").read_text().startswith("FMUs of rimbench")
            heard, told = read_csv(beside("_in.csv")), read_csv(beside("_ref.csv"))
            names = {v.name: v.causality for v in read_model_description(file).modelVariables}
            assert {names[name] for name in heard.dtype.names[1:]} == {"input"}
            assert {names[name] for name in told.dtype.names[1:]} == {"output"}
            outputs = list(told.dtype.names[1:])
            seen = simulate_fmu(str(file), stop_time=0.5, output_interval=H, step_size=H, input=heard, output=outputs)
            assert len(seen) == len(told)
            # It reads outputs before it sets inputs: what depends on inputs at once is of the row before.
            if side == "mechanics":
                for name in outputs:
                    peak = abs(told[name]).max()
                    assert abs(seen[name] - told[name]).max() <= options["RelTol"] * peak, (version, name)


def the_wedge_box_driven_by_fmpy_gives_the_digits_of_the_program():
    rimbench("simulate", "--case", "wedge-box", "--scheme", "zero-order-hold", "--macro-step", H, "--trace", "zoh.csv")
    trace = rows("zoh.csv")
    files = [export("wedge-box", side) for side in SIDES]
    began = time.perf_counter()
    said = drive(*(Side(str(file)) for file in files), [float(row["time_s"]) for row in trace], H)
    took = time.perf_counter() - began
    assert len(said) == 2501
    for row, values in zip(trace, said):
        columns = ["time_s", "actuator_length_m", "actuator_velocity_m_s", "actuator_force_n"]
        assert [float(row[column]) for column in columns] == values, (row, values)
    print(f"{len(said) - 1} macro steps in {took:.2f} s")


def states_are_kept_set_and_serialised_to_the_bit():
    for which, version in [(which, version) for which in SIDES for version in VERSIONS]:
        file = str(export("wedge-box", which, "--fmi", version))
        # In the middle of what it waits as well as behind.
        wait = {"wait_s": 0.05 + 0.3 * H}
        side = Side(file, **wait)
        inputs = [900.0] if which == "mechanics" else [2.5, 0.01]

        def push(t):
            side.set(side.inputs, inputs)
            side.fmu.doStep(t, H)

        begin = side.get(side.outputs)
        for k in range(200):
            push(k * H)
            if side.references.get("rim.H"):
                side.get(["rim.H"], nValues=25)
            if k == 20:
                waiting, still = side.serialised(side.keep()), side.get(side.outputs)
        state, before = side.keep(), side.get(side.outputs)
        data = side.serialised(state)
        push(0.2)
        after = side.get(side.outputs)
        assert after != before
        side.restore(state)
        assert side.get(side.outputs) == before
        push(0.2)
        assert side.get(side.outputs) == after
        side.fmu.reset()
        side.begin()
        assert side.get(side.outputs) == begin
        # In another instance as well.
        side = Side(file)
        side.restore_serialised(data)
        assert side.get(side.outputs) == before
        push(0.2)
        assert side.get(side.outputs) == after
        side.restore_serialised(waiting)
        assert side.get(side.outputs) == still and (which == "actuator" or still == begin)
        for k in range(21, 201):
            push(k * H)
        assert side.get(side.outputs) == after


def directional_derivatives_are_those_of_finite_differences():
    for version in VERSIONS:
        check_derivatives(version)


def check_derivatives(version):
    actuator = Side(str(export("wedge-box", "actuator", "--fmi", version)))
    for k in range(150):
        actuator.set(actuator.inputs, [2.5129, 0.02])
        actuator.fmu.doStep(k * H, H)
    output, found = actuator.outputs[0], 0
    for unknown, of in ((output, "D"), (f"der({output})", "R")):
        for known, step in zip(actuator.inputs, (1e-7, 1e-6)):
            exact = actuator.derivative(unknown, known)
            here = actuator.get([known])[0]
            values = []
            for sign in (1, -1):
                actuator.set([known], [here + sign * step])
                values.append(actuator.get([unknown])[0])
            actuator.set([known], [here])
            measured = (values[0] - values[1]) / (2 * step)
            assert abs(measured - exact) <= 1e-4 * max(abs(exact), 1.0), (of, known, exact, measured)
            found += exact != 0.0
    assert found >= 2
    # Positions and velocities of the mechanics do not follow its force at once.
    mechanics = Side(str(export("wedge-box", "mechanics", "--fmi", version)))
    assert [mechanics.derivative(name, mechanics.inputs[0]) for name in mechanics.outputs] == [0.0, 0.0]


def the_interface_model_is_that_of_newton():
    """For one body on a spring H is 1/m, and a the acceleration that the next step has."""
    mechanics = Side(str(export("linear-oscillator", "mechanics", "--set", "mass_2_kg=4")))
    assert mechanics.get(["rim.H"], nValues=1) == [0.25]
    parts = {name: mechanics.get([name], nValues=1)[0] for name in ("rim.position", "rim.w", "rim.a", "rim.stabilisation")}
    assert [parts["rim.position"], parts["rim.w"]] == mechanics.get(mechanics.outputs)


def coupled(name, mechanics, actuator, interface, **times):
    """The text of a case file for two FMUs whose variables have the same names; by rows of the interface."""
    lines = [f'name = "{name}"', *(f"{key} = {value!r}" for key, value in times.items())]
    lines += ["[mechanics]", f'fmu = "{mechanics}"', "[actuator]", f'fmu = "{actuator}"']
    for row in interface:
        lines += ["[[interface]]", f"columns = {json.dumps(row)}"]
        for side in SIDES:
            lines += [f"[interface.{side}]"]
            lines += [f"{key} = {json.dumps(variable)}" for key, variable in zip(("position", "velocity", "force"), row)]
    return "\n".join(lines) + "\n"


def contact_in_space_is_refused_and_nothing_is_written():
    for case in IN_SPACE:
        for side, version in zip(SIDES, VERSIONS):
            said = rimbench("fmu", "--case", case, "--side", side, "--fmi", version, "--out", "space.fmu", code=2)
            assert "contacts with friction in space are not exported" in said, said
            assert not (FOLDER / "space.fmu").exists()


# Cases whose sides are not coupled by positions, velocities and forces.
OTHERS = {"precice-oscillator"}


def every_case_comes_back_from_its_fmus_with_the_same_digits():
    others, points = set(), 0
    for case, version in [(case, version) for case in cases() for version in VERSIONS]:
        files = [export(case, side, "--fmi", version) for side in SIDES]
        mechanics, actuator = (Side(str(file)) for file in files)
        m = len(mechanics.inputs)
        if len(mechanics.outputs) != 2 * m:
            others.add(case)
            continue
        interface = [[mechanics.outputs[row], mechanics.outputs[m + row], mechanics.inputs[row]] for row in range(m)]
        micro = actuator.get(["longest_step_s"])[0]
        times = {
            "duration_s": min(30 * mechanics.macro_step, mechanics.stop), "macro_step_s": mechanics.macro_step, "micro_step_s": micro,
            "reference_step_s": micro, "process": "same",
        }
        (FOLDER / "of.toml").write_text(coupled("of-fmus", files[0].name, files[1].name, interface, **times))
        arguments = ["simulate", "--case", "of.toml", "--scheme", "zero-order-hold", "--trace", "of.csv"]
        done = subprocess.run([PROGRAM, *arguments], cwd=FOLDER, capture_output=True, text=True)
        if done.returncode == 2 and "no unit like" in done.stderr:
            others.add(case)
            continue
        assert done.returncode == 0, (case, done.stderr)
        told, found = exchanged(files[0]), rows("of.csv")
        assert len(found) > 10, (case, done.stdout)
        # The last step takes what is left, and is another by a rounding.
        for row, again in zip(told, found[:-1]):
            again["time"] = again["time_s"]
            assert all(row[name] == float(again[name]) for name in row), (case, version, row, again)
        points += len(found)
    assert others == OTHERS, others
    print(f"{len(cases()) - len(others)} cases for both versions, {points} communication points, to the bit")


def every_exported_side_takes_a_step_alone_in_a_master_that_reads_all_outputs():
    from fmpy import simulate_fmu

    for case in cases():
        for side, version in [(side, version) for side in SIDES for version in VERSIONS]:
            said = []
            log = lambda *words: said.append(words)
            file = export(case, side, "--fmi", version)
            try:
                seen = simulate_fmu(str(file), stop_time=2e-3, output_interval=1e-3, logger=log)
            except Exception as error:
                raise AssertionError((case, side, version, said, error)) from error
            assert len(seen) == 3, (case, side, version, len(seen))


def the_examples_of_the_guide_run():
    guide = (Path(__file__).resolve().parents[4] / "docs/guide/fmi.md").read_text()
    block = lambda language: guide.split(f"```{language}\n")[1].split("```")[0]
    for side in SIDES:
        rimbench("fmu", "--case", "wedge-box", "--side", side, "--out", f"{side}.fmu", "--macro-step", H)
    before = Path.cwd()
    os.chdir(FOLDER)
    try:
        exec(compile(block("python"), "fmi.md", "exec"), {})
    finally:
        os.chdir(before)
    (FOLDER / "box.toml").write_text(block("toml"))
    run = json.loads(rimbench("simulate", "--case", "box.toml", "--scheme", "rim-nonsmooth-gap", "--format", "json"))
    assert run["outcome"] == "completed" and run["interface_residual_j"] is not None, run


BODY = '''
from pythonfmu3 import Fmi3Causality, Fmi3Slave, Float64

class Body(Fmi3Slave):
    """A mass on a spring."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.m, self.k, self.x, self.v, self.f, self.time = 1.0, 0.0, 0.01, 0.0, 0.0, 0.0
        self.die_above, self.fail_above, self.hang_above = 1e9, 1e9, 1e9
        self.register_variable(Float64("time", causality=Fmi3Causality.independent))
        for name in ("x", "v"):
            self.register_variable(Float64(name, causality=Fmi3Causality.output))
        self.register_variable(Float64("f", causality=Fmi3Causality.input))
        for name in ("m", "k", "die_above", "fail_above", "hang_above"):
            self.register_variable(Float64(name, causality=Fmi3Causality.parameter))

    def do_step(self, t, h):
        if h > self.die_above:
            import os
            print("going down", flush=True)
            os.abort()
        if h > self.hang_above:
            import time
            time.sleep(60)
        if h > self.fail_above:
            return False
        self.v += h * (self.f - self.k * self.x) / self.m
        self.x += h * self.v
        return True
'''

SPRING = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

class Spring(Fmi2Slave):
    """A spring and damper to a fixed point; a force of the inputs, once it has stepped."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.stiffness, self.damping, self.x, self.v, self.f = 100.0, 1.0, 0.0, 0.0, 0.0
        for name in ("x", "v"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        self.register_variable(Real("f", causality=Fmi2Causality.output))
        for name in ("stiffness", "damping"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter))

    def do_step(self, t, h):
        self.f = -self.stiffness * self.x - self.damping * self.v
        return True
'''

PAIR = """
name = "body-and-spring"
duration_s = 0.5
macro_step_s = 1e-2
reference_step_s = 1e-3
micro_step_s = 2e-3
answer_within_s = {patience}
[mechanics]
fmu = "Body.fmu"
needs = {needs}
start = {{ k = 10.0{more} }}
[actuator]
fmu = "Spring.fmu"
needs = {needs}
direct_feedthrough = false
[parameters.mass_kg]
default = 2.0
unit = "kg"
mechanics = "m"
[[interface]]
[interface.mechanics]
position = "x"
velocity = "v"
force = "f"
[interface.actuator]
position = "x"
velocity = "v"
force = "f"
"""


def pair(patience, more=""):
    """Such FMUs take the symbols of Python for granted: where the program is none, its library is loaded first."""
    library = sysconfig.get_config_var("INSTSONAME")
    place = Path(sysconfig.get_config_var("LIBDIR")) / library
    if not library.startswith("libpython") or not place.exists():
        raise Skipped("this Python has no shared library")
    return PAIR.format(patience=patience, more=more, needs=json.dumps([str(place)]))


def made_by_others():
    """FMUs for FMI 3.0 and 2.0 that pythonfmu3 and pythonfmu make of classes."""
    for module, name, text in (("pythonfmu3", "body", BODY), ("pythonfmu", "spring", SPRING)):
        (FOLDER / f"{name}.py").write_text(text)
        if (FOLDER / f"{name.title()}.fmu").exists():
            continue
        made = subprocess.run(
            [sys.executable, "-m", module, "build", "-f", f"{name}.py"], cwd=FOLDER, capture_output=True, text=True
        )
        if "No module named" in made.stderr:
            raise Skipped(f"no {module}")
        assert made.returncode == 0, made.stderr


def fmus_of_others_are_simulated_swept_and_limited():
    made_by_others()
    (FOLDER / "pair.toml").write_text(pair(60.0))
    run = json.loads(rimbench("simulate", "--case", "pair.toml", "--scheme", "zero-order-hold", "--format", "json"))
    assert run["outcome"] == "completed" and run["parameters"]["mass_kg"] == 2.0, run
    assert 0 < run["position_error_rms_m"] < 1e-2, run
    heavy = json.loads(
        rimbench("simulate", "--case", "pair.toml", "--scheme", "zero-order-hold", "--set", "mass_kg=8", "--format", "json")
    )
    assert heavy["position_error_rms_m"] != run["position_error_rms_m"]
    (FOLDER / "sweep.toml").write_text(
        'question = "?"\nmacro_steps_s = [1e-2]\n[[cases]]\nname = "body-and-spring"\nset = { mass_kg = 3.0 }\n'
        '[[schemes]]\nscheme = "zero-order-hold"\n[[schemes]]\nscheme = "first-order-hold"\n'
        '[[schemes]]\nscheme = "rim-smooth"\n'
    )
    rimbench("--case-file", "pair.toml", "run", "sweep.toml", "--out", "sweep")
    runs = rows("sweep/runs.csv")
    assert [run["outcome"] for run in runs].count("completed") == 2, runs
    skipped = [run["reason"] for run in runs if run["outcome"] == "skipped"]
    assert len(skipped) == 1 and all("interface model" in reason for reason in skipped), skipped
    limit = rimbench(
        "limit", "--case", "pair.toml", "--scheme", "zero-order-hold", "--from", 0.05, "--to", 0.3, "--per-decade", 1,
        "--relative-tolerance", 0.5, "--format", "json", "--duration", 1,
    )
    assert json.loads(limit)["fraction_stable"], limit


def an_fmu_that_fails_hangs_or_crashes_costs_one_run():
    made_by_others()
    reasons, shown = {}, {}
    for what, patience in (("fail_above", 60.0), ("die_above", 60.0), ("hang_above", 10.0)):
        # The reference takes shorter steps and is there; the run does not get far.
        (FOLDER / f"{what}.toml").write_text(pair(patience, f", {what} = 5e-3"))
        arguments = ["simulate", "--case", f"{what}.toml", "--scheme", "zero-order-hold", "--format", "json"]
        done = subprocess.run([PROGRAM, *arguments], cwd=FOLDER, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        run = json.loads(done.stdout)
        assert run["outcome"] == "subsystem-failed", run
        reasons[what], shown[what] = run["reason"], done.stderr
    assert all("Body.fmu" in reason for reason in reasons.values()), reasons
    assert "DoStep returned" in reasons["fail_above"], reasons
    assert "its process ended (signal: 6" in reasons["die_above"], reasons
    # What it prints is shown, and no part of the result.
    assert "going down" not in reasons["die_above"] and "Body.fmu` printed:\n  going down" in shown["die_above"], (reasons, shown)
    assert "no answer within 10 s" in reasons["hang_above"], reasons


def fixed(file):
    """The same FMU, which says that it takes steps of one length only."""
    out = file.with_name(f"fixed-{file.name}")
    with zipfile.ZipFile(file) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for item in old.infolist():
            data = old.read(item.filename)
            if item.filename == "modelDescription.xml":
                true, false = (f'canHandleVariableCommunicationStepSize="{truth}"'.encode() for truth in ("true", "false"))
                assert true in data
                data = data.replace(true, false)
            new.writestr(item, data)
    return out


def the_advice_as_a_master_prints_the_error_that_the_answer_says():
    row = ("actuator_length_m", "actuator_velocity_m_s", "actuator_force_n")
    free = [export("wedge-box", side, "--macro-step", "1e-3", "--set", "box_mass_kg=250") for side in SIDES]
    times = {"duration_s": 0.3, "macro_step_s": 1e-3, "micro_step_s": 1e-4, "reference_step_s": 1e-4}
    for name, (mechanics, actuator) in {"free": free, "one-fixed": [fixed(free[0]), free[1]]}.items():
        text = coupled(name, mechanics.name, actuator.name, [row], **times).replace("[mechanics]", 'process = "same"\n[mechanics]')
        text = text.replace(f'"{mechanics.name}"', f'"{mechanics.name}"\nstart = {{ disc_mass_kg = 61.0, serialisable = false }}')
        (FOLDER / f"{name}.toml").write_text(text)
        for form in (
            ("zero-order-hold", "--force-return", "end"),
            ("zero-order-hold", "--sequence", "jacobi", "--duration", "0.1007"),
            ("first-order-hold", "--sequence", "gauss-seidel-mechanics-first", "--mechanics-steps", "2"),
            ("second-order-hold", "--force-return", "profile", "--mechanics-steps", "3"),
        ):
            asked = ("--error", "90%", "--from", "1ms", "--to", "1.3ms", "--phases", "3", "--scheme", *form)
            said = json.loads(
                rimbench("advise", "--case", f"{name}.toml", *asked, "--write-master", "own.py", "--format", "json", "--jobs", "1")
            )
            assert said["phases"] == (3 if name == "free" else 1), said
            lines = (FOLDER / "own.py").read_text().splitlines()
            done = subprocess.run([sys.executable, "own.py"], cwd=FOLDER, capture_output=True, text=True)
            assert done.returncode == 0 and len(lines) <= 80, (len(lines), done.stderr)
            printed = float(done.stdout.split("error ")[1].split(" %")[0])
            # Four decimals are printed.
            assert abs(printed - 100 * said["advised"]["worst_error"]) <= 1e-4, (form, done.stdout, said["advised"])


TESTS = [
    states_are_kept_set_and_serialised_to_the_bit,
    directional_derivatives_are_those_of_finite_differences,
    the_interface_model_is_that_of_newton,
    the_examples_of_the_guide_run,
    the_wedge_box_driven_by_fmpy_gives_the_digits_of_the_program,
    an_fmu_that_fails_hangs_or_crashes_costs_one_run,
    the_advice_as_a_master_prints_the_error_that_the_answer_says,
    fmus_of_others_are_simulated_swept_and_limited,
    a_master_of_fixed_steps_has_any_phase_by_letting_the_models_wait,
    work_sent_and_received_leave_what_the_program_says,
    the_files_beside_an_fmu_are_those_of_the_cross_check_and_fmpy_repeats_them,
    every_exported_fmu_is_valid_and_driven_by_fmpy_gives_the_digits_of_the_run_beside_it_for_both_versions,
    every_case_comes_back_from_its_fmus_with_the_same_digits,
    every_exported_side_takes_a_step_alone_in_a_master_that_reads_all_outputs,
    contact_in_space_is_refused_and_nothing_is_written,
]

if __name__ == "__main__":
    os.environ.setdefault("RIMBENCH_CACHE", str(FOLDER / "cache"))
    only = sys.argv[3:]
    for test in TESTS:
        if only and not any(word in test.__name__ for word in only):
            continue
        began = time.perf_counter()
        try:
            test()
            print(f"ok {time.perf_counter() - began:6.1f} s  {test.__name__}", flush=True)
        except Skipped as why:
            print(f"skipped: {test.__name__}: {why}", flush=True)

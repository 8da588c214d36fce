"""Calls of what is built in: the digits and the words of the command line."""

import csv
import json
import re
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import rimbench


def command(program, *arguments):
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("case", "scheme", "macro_step_s", "settings"),
    [
        ("bouncing-ball", "zero-order-hold", 1e-3, {"restitution": 0.8, "duration_s": 0.5}),
        ("bouncing-ball", "rim-nonsmooth-gap", 1.3e-3, {"force_return": "profile", "phase": 0.3, "mechanics_step_s": 4e-4}),
        ("linear-oscillator", "nepce", 1e-3, {"gain": 0.1, "variant": "1", "mechanics_steps": 3}),
        ("gripper", "rim-nonsmooth-gap", 2e-3, {"duration_s": 0.9, "partition": "each", "order": "2;1", "every": "1,2", "known": "law"}),
        ("gripper", "rim-nonsmooth-gap", 2e-3, {"duration_s": 0.9, "partition": "1|2", "share": 0.5, "bond_micro_steps": "5e-5,1e-4"}),
        ("gripper", "rim-nonsmooth-gap", 2e-3, {"duration_s": 0.9, "partition": "each", "every": 4, "bond_schemes": "rim-smooth,zero-order-hold"}),
    ],
)
def test_digits_are_those_of_the_command_line_to_the_bit(program, tmp_path, case, scheme, macro_step_s, settings):
    options = {"duration_s": "--duration", "force_return": "--force-return", "phase": "--phase", "gain": "--gain"}
    options |= {"mechanics_steps": "--mechanics-steps", "mechanics_step_s": "--mechanics-step"}
    bonds = ["partition", "order", "every", "known", "share", "bond_schemes", "bond_micro_steps"]
    options |= {key: "--" + key.replace("_", "-") for key in bonds}
    typed = ["--case", case, "--scheme", scheme, "--macro-step", repr(macro_step_s)]
    for key, value in settings.items():
        typed += [options[key], str(value)] if key in options else ["--set", f"{key}={value}"]
    done = command(program, "simulate", *typed, "--trace", str(tmp_path / "trace.csv"), "--format", "json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    result = rimbench.simulate(case, scheme, macro_step_s, **settings)
    assert said["run_id"] == result.run_id
    assert said["outcome"] == result.outcome
    # JSON knows no infinity.
    finite = {name: value if value is None or np.isfinite(value) else None for name, value in result.metrics.items()}
    # Metrics of friction are keys only where contacts have friction, here and there.
    assert {name: said[name] for name in {metric["name"] for metric in rimbench.metrics()} & said.keys()} == finite
    assert {name: said[name] for name in result.counters} == result.counters
    with open(tmp_path / "trace.csv", newline="") as file:
        header, *rows = csv.reader(file)
    for index, column in enumerate(header):
        np.testing.assert_array_equal(result[column], [float(row[index]) for row in rows], column)


def plain(text):
    return text.replace("--", "").replace("_", "-").replace("-s = ", " = ")


@pytest.mark.parametrize(
    ("typed", "call"),
    [
        (["simulate", "--case", "wedge-boxx"], lambda: rimbench.simulate("wedge-boxx", "nepce")),
        (["simulate", "--scheme", "nepc"], lambda: rimbench.simulate("wedge-box", "nepc")),
        (["simulate", "--gain", "7"], lambda: rimbench.simulate("wedge-box", "nepce", gain=7)),
        (["simulate", "--phase", "2"], lambda: rimbench.simulate("wedge-box", "nepce", phase=2)),
        (["simulate", "--macro-step", "nan"], lambda: rimbench.simulate("wedge-box", "nepce", float("nan"))),
        (["simulate", "--set", "box_mass_kg=-1"], lambda: rimbench.simulate("wedge-box", "nepce", box_mass_kg=-1)),
        (["simulate", "--delivery-up", "delay:9999"], lambda: rimbench.simulate("wedge-box", "nepce", delivery_up="delay:9999")),
        (["simulate", "--delivery-down", "loss:1"], lambda: rimbench.simulate("wedge-box", "nepce", delivery_down="loss:1")),
        (["simulate", "--delivery-up", "missed:7+3"], lambda: rimbench.simulate("wedge-box", "nepce", delivery_up="missed:7+3")),
        (["simulate", "--scheme", "monolithic", "--delivery-up", "delay:1"], lambda: rimbench.simulate("wedge-box", "monolithic", delivery_up="delay:1")),
        (["limit", "--to", "9"], lambda: rimbench.limit("wedge-box", "nepce", to_s=9.0)),
        (["limit", "--method", "spectral"], lambda: rimbench.limit("wedge-box", "nepce", method="spectral")),
        (["run", "missing.toml"], lambda: rimbench.run("missing.toml")),
    ],
)
def test_errors_are_exceptions_with_the_same_words(program, tmp_path, monkeypatch, typed, call):
    monkeypatch.chdir(tmp_path)
    usual = [] if typed[0] == "run" else ["--case", "wedge-box", "--scheme", "nepce"]
    given = [word for pair in zip(usual[::2], usual[1::2]) if pair[0] not in typed for word in pair]
    done = command(program, *typed, *given)
    assert done.returncode == 2
    with pytest.raises(rimbench.RimbenchError) as raised:
        call()
    # The program says a key as its flag, and what is valid in a line of help.
    what = re.split(r"; valid: | \(did you mean ", str(raised.value))[0]
    assert plain(what) in plain(done.stderr)


def test_lists_have_everything_with_units():
    cases = {case["name"]: case for case in rimbench.cases()}
    mass = next(entry for entry in cases["wedge-box"]["parameters"] if entry["name"] == "box_mass_kg")
    assert (mass["unit"], mass["default"]) == ("kg", 200.0)
    assert cases["wedge-box"]["duration_s"] == 2.5
    assert {"zero-order-hold", "rim-nonsmooth-gap"} <= {scheme["name"] for scheme in rimbench.schemes()}
    assert {metric["name"]: metric["unit"] for metric in rimbench.metrics()}["force_error_rms_n"] == "N"


def test_a_diverged_run_is_data_with_its_reason():
    result = rimbench.simulate("linear-oscillator", "zero-order-hold", 0.05)
    assert (result.outcome, result.completed, result.exception) == ("diverged", False, None)
    assert "beyond 3 times the reference maximum" in result.reason
    assert 0.0 < result.outcome_at_s < 10.0
    assert result["time_s"][-1] == result.ended_at_s


def test_a_setting_that_is_none_is_refused_by_name():
    with pytest.raises(rimbench.RimbenchError, match="unknown parameter or option `box_mas_kg` .did you mean `box_mass_kg`"):
        rimbench.simulate("wedge-box", "nepce", box_mas_kg=1)
    with pytest.raises(rimbench.RimbenchError, match="unknown parameter or option `phase`"):
        rimbench.limit("wedge-box", "nepce", phase=0.5)


class Empty:
    """What is called and makes something that is no side."""

    def outputs(self, u):
        return (0.0,)

    step = outputs


BALL = ("bouncing-ball", "zero-order-hold")


@pytest.mark.parametrize(
    ("call", "wanted"),
    [
        (lambda: rimbench.simulate("wedge-box", "nepce", box_mass_kg=[1]), r"box_mass_kg = \[1\] \(list\) .*finite number above 0"),
        (lambda: rimbench.simulate("wedge-box", "nepce", box_mass_kg=None), r"box_mass_kg = None \(NoneType\) .*above 0"),
        (lambda: rimbench.simulate("wedge-box", "nepce", belief={}), r"belief = {} \(dict\) .*a number or a text: What it believes"),
        (lambda: rimbench.simulate("wedge-box", "nepce", [1e-3]), r"macro_step_s = \[0.001\] \(list\) .*Macro step"),
        (lambda: rimbench.simulate(["wedge-box"], "nepce"), r"case = \['wedge-box'\] \(list\) .*the name of a case"),
        (lambda: rimbench.simulate("wedge-box", None), r"scheme = None \(NoneType\) .*the name of a scheme"),
        (lambda: rimbench.limit(*BALL, from_s=[]), r"from_s = \[\] \(list\) .*a number"),
        (lambda: rimbench.limit(*BALL, per_decade="x"), r"per_decade = 'x' \(str\) .*a whole number"),
        (lambda: rimbench.limit(*BALL, per_decade=True), r"per_decade = True \(bool\) .*a whole number"),
        (lambda: rimbench.limit(*BALL, phases=1.5), r"phases = 1.5 \(float\) .*a whole number"),
        (lambda: rimbench.limit(*BALL, relative_tolerance=None), r"relative_tolerance = None \(NoneType\) .*a number"),
        (lambda: rimbench.limit(*BALL, method=None), r"method = None \(NoneType\) .*run, spectral"),
        (lambda: rimbench.limit(*BALL, progress=3), r"progress = 3 \(int\) .*or True"),
        (lambda: rimbench.advise(BALL[0], [1]), r"error = \[1\] \(list\) .*share of the peak"),
        (lambda: rimbench.advise(BALL[0], "1%", model="yes"), r"model = 'yes' \(str\) .*True or False"),
        (lambda: rimbench.advise(BALL[0], "1%", costs=3), r"costs = 3 \(int\) .*four numbers"),
        (lambda: rimbench.advise(BALL[0], "1%", costs=[1, 2]), r"costs = \[1, 2\] \(list\) .*four numbers"),
        (lambda: rimbench.advise(BALL[0], "1%", costs=["a", 1, 1, 1]), r"costs = 'a' \(str\) .*a number"),
        (lambda: rimbench.run(3), r"file = 3 \(int\) .*experiment file"),
        (lambda: rimbench.run("a.toml", out=3), r"out = 3 \(int\) .*a folder"),
        (lambda: rimbench.run("a.toml", quick="no"), r"quick = 'no' \(str\) .*True or False"),
        (lambda: rimbench.run("a.toml", cases=3), r"cases = 3 \(int\) .*a sequence of Case"),
        (lambda: rimbench.run("a.toml", cases=["x"]), r"cases = 'x' \(str\) .*a sequence of Case"),
        (lambda: rimbench.open_case(None), r"file = None \(NoneType\) .*a case file"),
        (lambda: rimbench.Case(3), r"name = 3 \(int\) .*kebab-case"),
        (lambda: rimbench.Case("a", like=3, mechanics=Empty), r"like = 3 \(int\) .*built-in case"),
        (lambda: rimbench.Case("a", reference=None), r"reference = None \(NoneType\) .*own, original"),
        (lambda: rimbench.Case("a", like=BALL[0], mechanics=3), r"mechanics = 3 \(int\) .*called with the parameters"),
        (lambda: rimbench.Case("a", interface="xvf"), r"interface = 'xvf' \(str\) .*three names each"),
        (lambda: rimbench.Case("a", parameters=[1]), r"parameters = \[1\] \(list\) .*a dictionary"),
        (lambda: rimbench.Scheme("a", 3), r"make = 3 \(int\) .*called with"),
        (lambda: rimbench.Scheme(None, Empty), r"name = None \(NoneType\) .*kebab-case"),
        (lambda: rimbench.Scheme("a", Empty, order="x"), r"order = 'x' \(str\) .*a whole number"),
        (lambda: rimbench.Scheme("a", Empty, interface_model=1), r"interface_model = 1 \(int\) .*True or False"),
    ],
)
def test_a_value_of_the_wrong_kind_is_told_with_its_name_and_what_is_valid(call, wanted):
    said, valid = wanted.split(" .*")
    with pytest.raises(TypeError, match=f"^{said} is not valid; valid: .*{valid}"):
        call()


@pytest.mark.parametrize(("name", "value"), [("per_decade", -1), ("per_decade", 2**70), ("phases", -1)])
def test_a_number_beyond_all_use_is_not_valid(name, value):
    with pytest.raises(rimbench.RimbenchError, match="gain = .* is not valid; valid: a number, at most 1.8e308"):
        rimbench.simulate("wedge-box", "nepce", gain=10**400)
    with pytest.raises(rimbench.RimbenchError, match=f"{name} = .* is not valid; valid: a whole number"):
        rimbench.limit(*BALL, **{name: value})


def test_numbers_of_numpy_are_numbers():
    plain = rimbench.simulate("bouncing-ball", "zero-order-hold", 1e-3, restitution=0.7, duration_s=0.2)
    same = rimbench.simulate(
        "bouncing-ball", "zero-order-hold", np.float64(1e-3), restitution=np.float64(0.7), duration_s=0.2
    )
    assert plain.run_id == same.run_id


def test_the_limit_is_that_of_the_command_line(program):
    settings = {"variant": 1, "duration_s": 1.0}
    found = rimbench.limit("linear-oscillator", "zero-order-hold", to_s=0.05, per_decade=4, **settings)
    typed = ["--case", "linear-oscillator", "--scheme", "zero-order-hold", "--set", "variant=1", "--duration", "1"]
    done = command(program, "limit", *typed, "--to", "0.05", "--per-decade", "4", "--format", "json")
    said = json.loads(done.stdout)
    assert said["stability_limit_s"] == found.stability_limit_s
    assert [point["macro_step_s"] for point in said["fraction_stable"]] == [p["macro_step_s"] for p in found.points]


EXPERIMENT = """
question = "Does a small experiment come back?"
macro_steps_s = [1e-3, 2e-3]

[[cases]]
name = "bouncing-ball"

[[schemes]]
scheme = "zero-order-hold"
"""


def test_an_experiment_gives_its_rows_and_goes_on_from_there(tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(EXPERIMENT)
    told = []
    rows = rimbench.run(file, tmp_path / "out", progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (2, 2)
    assert [row["macro_step_s"] for row in rows] == [1e-3, 2e-3]
    for row in rows:
        result = rimbench.simulate("bouncing-ball", "zero-order-hold", row["macro_step_s"])
        assert row["run_id"] == result.run_id
        assert row["force_error_rms_n"] == result.metrics["force_error_rms_n"]
        assert (row["gain"], row["model_exact"], row["scheme"]) == (None, False, "zero-order-hold")
    told.clear()
    assert rimbench.run(file, tmp_path / "out", progress=lambda *step: told.append(step)) == rows
    assert told == []


def test_tables_of_pandas():
    pytest.importorskip("pandas")
    result = rimbench.simulate("bouncing-ball", "zero-order-hold", 1e-2, duration_s=0.2)
    table = result.to_dataframe()
    assert list(table) == list(result.trace) and len(table) == len(result["time_s"])
    rows = rimbench.Rows(None, [{"a": 1.0}, {"a": 2.0}])
    assert rows.to_dataframe()["a"].sum() == 3.0


def test_other_threads_go_on_while_a_run_computes():
    go, gone_on = threading.Event(), threading.Event()

    def other():
        go.wait()
        gone_on.set()

    thread = threading.Thread(target=other)
    thread.start()
    # Nobody is made to give the interpreter up: the other thread gets it only where a call lends it.
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    try:
        go.set()
        result = rimbench.simulate("wedge-box", "zero-order-hold", 2e-5, micro_step_s=2e-5)
        assert gone_on.is_set()
    finally:
        sys.setswitchinterval(usual)
    thread.join()
    assert result.completed


@pytest.mark.skipif(sys.platform == "win32", reason="signals of another kind")
@pytest.mark.parametrize(
    "call",
    [
        "rimbench.simulate('wedge-box', 'zero-order-hold', 1e-6, micro_step_s=1e-6, duration_s=9)",
        "rimbench.limit('wedge-box', 'zero-order-hold', from_s=1e-6, duration_s=9, micro_step_s=1e-6)",
        "rimbench.simulate(endless, 'zero-order-hold', 1e-3, mechanics_steps=100, duration_s=1000)",
    ],
)
def test_ctrl_c_ends_a_call(call):
    # The run asks for its own end, from a thread, once it computes.
    code = f"""
import os, signal, threading, rimbench
class Still:
    def __init__(self, parameters): pass
    def outputs(self, u): return 0.0, 0.0
    def step(self, t, u, h): pass
endless = rimbench.Case("endless", like="linear-oscillator", mechanics=Still, reference="original")
# Whoever is started in the background of a shell inherits that the signal is ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    {call}
except KeyboardInterrupt:
    print("interrupted")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert done.stdout.strip() == "interrupted", done.stderr


def test_calls_from_several_threads_are_those_of_one():
    def error(scheme):
        return rimbench.simulate("bouncing-ball", scheme, 1e-3, duration_s=0.3).metrics

    schemes = ["zero-order-hold", "first-order-hold", "rim-smooth", "rim-nonsmooth-gap"]
    with ThreadPoolExecutor(4) as several:
        assert list(several.map(error, schemes)) == [error(scheme) for scheme in schemes]


def test_a_progress_bar_comes_to_its_end(capsys):
    rimbench.limit("bouncing-ball", "zero-order-hold", per_decade=1, progress=True)
    drawn = capsys.readouterr().err
    assert "4/4" in drawn and drawn.endswith("\n")


def test_an_exception_of_progress_ends_the_call():
    def broken(done, total):
        raise LookupError("no more")

    with pytest.raises(LookupError, match="no more"):
        rimbench.limit("bouncing-ball", "zero-order-hold", per_decade=3, progress=broken)


def test_numbers_of_few_digits_are_what_they_say_and_truths_are_none():
    usual = rimbench.simulate("bouncing-ball", "zero-order-hold", 5e-3, duration_s=0.05)
    for step in (np.float32(5e-3), np.float16(5e-3), np.float64(5e-3), np.array(5e-3, dtype=np.float32)):
        short = rimbench.simulate("bouncing-ball", "zero-order-hold", step, duration_s=0.05)
        assert np.dtype(step.dtype) == np.float16 or short.run_id == usual.run_id, step.dtype
        assert "99999" not in repr(short.settings["macro_step_s"])
    for truth in (True, np.True_):
        with pytest.raises(TypeError, match=f"ball_mass_kg = {truth!r} .* is not valid"):
            rimbench.simulate("bouncing-ball", "zero-order-hold", 5e-3, ball_mass_kg=truth)
        with pytest.raises(TypeError, match=f"duration_s = {truth!r} .* is not valid"):
            rimbench.simulate("bouncing-ball", "zero-order-hold", 5e-3, duration_s=truth)
        with pytest.raises(TypeError, match=f"from_s = {truth!r} .* is not valid"):
            rimbench.limit("bouncing-ball", "zero-order-hold", from_s=truth)
    with pytest.raises(ValueError, match="read-only"):
        usual["time_s"][0] = 1.0


def test_advice_is_that_of_the_command_line(program):
    typed = ["--case", "bouncing-ball", "--error", "2%", "--from", "1ms", "--to", "5ms", "--phases", "2", "--format", "json"]
    done = command(program, "advise", *typed, "--set", "restitution=0.5")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    found = rimbench.advise("bouncing-ball", "2%", from_s="1ms", to_s="5ms", phases=2, restitution=0.5)
    for which in ("advised", "runner_up"):
        choice = getattr(found, which)
        assert (choice.scheme, choice.macro_step_s, choice.cost) == tuple(said[which][key] for key in ("scheme", "macro_step_s", "cost"))
    again = rimbench.simulate("bouncing-ball", found.advised.scheme, **found.advised.settings)
    assert again.run_id == said["advised"]["run_id"]
    for asked, words in (
        ({"error": 5}, "error = 5 is not valid"),
        ({}, "error = None is not valid.*exchanges"),
        ({"error": "1%", "exchanges": 100}, "exchanges = 100.*error is of an error"),
        ({"exchanges": 100}, "needs --mechanics-steps"),
        ({"exchanges": 100, "mechanics_steps": 50}, "mechanics-steps = 50.* is not valid"),
    ):
        with pytest.raises(rimbench.RimbenchError, match=words):
            rimbench.advise("bouncing-ball", **asked)


def test_advice_within_a_budget_is_that_of_the_command_line(program):
    typed = ["--case", "bouncing-ball", "--exchanges", "200", "--mechanics-steps", "400", "--phases", "1", "--duration", "0.5"]
    done = command(program, "advise", *typed, "--format", "json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    found = rimbench.advise("bouncing-ball", exchanges=200, mechanics_steps=400, phases=1, duration_s=0.5)
    pairs = [(found.advised, said["advised"]), (found.runner_up, said["runner_up"]), *zip(found.doubled, said["doubled"], strict=True)]
    for choice, known in pairs:
        assert {key: getattr(choice, key) for key in ("way", "form", "worst_error", "spent_per_s")}.items() <= known.items()
    again = rimbench.simulate("bouncing-ball", found.advised.scheme, **found.advised.settings)
    assert again.run_id == said["advised"]["run_id"]
    assert found.advised.spent_per_s[0] <= 1.03 * 200


def test_a_run_has_the_parts_of_its_error_in_the_words_of_the_command_line(program):
    done = command(program, "simulate", "--case", "wedge-box", "--scheme", "zero-order-hold", "--macro-step", "1ms", "--duration", "0.5")
    run = rimbench.simulate("wedge-box", "zero-order-hold", "1ms", duration_s=0.5)
    assert "of it coupling" in run.error_parts or "cancel in part" in run.error_parts
    assert run.error_parts.split() == " ".join(done.stdout.split()).split(" of the peak, ")[1].split()[: len(run.error_parts.split())]
    assert run.metrics["coupling_share"] is not None and run.error_parts in run._repr_html_().replace("&#x27;", "'")
    undivided = rimbench.simulate("gripper", "rim-nonsmooth-gap", "5ms", duration_s=0.2, partition="each")
    assert undivided.error_parts == "not told apart: its mechanics has several bonds"


def test_times_may_have_units():
    plain = rimbench.simulate("bouncing-ball", "zero-order-hold", 5e-3, duration_s=0.2)
    for text in ("5ms", "5000 us", "0.005", "0.005s"):
        assert rimbench.simulate("bouncing-ball", "zero-order-hold", text, duration_s="200ms").run_id == plain.run_id
    for text in ("5mm", "fast", "1e-ms", ""):
        with pytest.raises(rimbench.RimbenchError, match="macro.step"):
            rimbench.simulate("bouncing-ball", "zero-order-hold", text)


def test_results_show_and_draw_themselves(tmp_path, monkeypatch):
    result = rimbench.simulate("bouncing-ball", "zero-order-hold", "5ms", duration_s=0.2)
    found = rimbench.limit("linear-oscillator", "zero-order-hold", per_decade=1, from_s="1ms", to_s="10ms", duration_s=0.2)
    rows = rimbench.Rows(tmp_path, [{"scheme": "a<b", "h": 1.0, "e": 2.0}, {"scheme": "a<b", "h": 2.0, "e": None}])
    advice = rimbench.advise("bouncing-ball", 0.5, from_s="4ms", to_s="5ms", phases=1, duration_s=0.2)
    for shown, words in ((result, "force_error_rms_n"), (found, "macro_step_s"), (rows, "a&lt;b"), (advice, advice.advised.scheme)):
        assert words in shown._repr_html_() and shown._repr_html_().startswith("<table>")
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(rimbench.RimbenchError, match="valid: pip install matplotlib"):
        result.plot()
    monkeypatch.undo()
    pytest.importorskip("matplotlib").use("Agg")
    forces = [name for name in result.trace if name.endswith("force_n")]
    labels = [label for name in forces for label in (name, f"{name}, reference") if label == name or name in result.reference]
    assert [line.get_label() for line in result.plot().lines] == labels and len(labels) > len(forces)
    assert len(result.reference["time_s"]) == len(result["time_s"]) and len(result.plot("time_s").lines) == 1
    np.testing.assert_array_equal(result.plot("time_s").lines[0].get_ydata(), result["time_s"])
    assert len(found.plot().lines[0].get_xdata()) == len(found.points)
    assert rows.plot("h", "e").lines[0].get_xdata().tolist() == [1.0]
    with pytest.raises(rimbench.RimbenchError, match="no column `nothing`"):
        result.plot("nothing")
    with pytest.raises(rimbench.RimbenchError, match="no column `x`"):
        rows.plot("x", "e")

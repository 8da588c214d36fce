"""Subsystems, cases and schemes written in Python."""

import importlib.util
import inspect
import sys
import traceback
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import EXAMPLES

import rimbench

#: Semi-implicit Euler in Rust and in Python are the same operations in the same order.
SETTINGS = {"integrator": "semi-implicit-euler", "duration_s": 1.0}


def test_what_is_written_in_python_is_short(example):
    for module, kind in [("own_mechanics", "Mass"), ("own_scheme", "Line"), ("own_case", "Weight")]:
        assert len(inspect.getsource(getattr(example(module), kind)).splitlines()) < 40


@pytest.mark.parametrize("scheme", ["zero-order-hold", "first-order-hold", "rim-smooth", "interface-jacobian"])
def test_a_mechanics_in_python_has_the_digits_of_the_one_in_rust(example, scheme):
    # Each step of the one in Python differs by at most a few roundings (a quotient against a product with a reciprocal); with
    # 10^4 steps of a system that neither grows nor decays they add up to at most 10^4 · 8 ε of the largest magnitude.
    own = rimbench.simulate(example("own_mechanics").case, scheme, 1e-3, **SETTINGS)
    built_in = rimbench.simulate("linear-oscillator", scheme, 1e-3, **SETTINGS)
    assert own.outcome == built_in.outcome == "completed"
    bound = 1e4 * 8 * np.finfo(float).eps
    for column, values in own.trace.items():
        largest = np.abs(built_in[column]).max()
        np.testing.assert_allclose(values, built_in[column], rtol=0, atol=bound * largest, err_msg=column)
    assert own.metrics["position_error_rms_m"] == pytest.approx(built_in.metrics["position_error_rms_m"], rel=1e-6)
    assert own.counters["mechanics_micro_steps"] == built_in.counters["mechanics_micro_steps"] == 10_000


def test_a_step_that_returns_its_outputs_costs_one_callback(example):
    Mass = example("own_mechanics").Mass
    calls = {"outputs": 0, "step": 0}

    class Counted(Mass):
        def outputs(self, u):
            calls["outputs"] += 1
            return super().outputs(u)

        def step(self, t, u, h):
            calls["step"] += 1
            return super().step(t, u, h)

    case = rimbench.Case("counted", like="linear-oscillator", mechanics=Counted, reference="original")
    # The check of a case that is made takes at most twenty steps.
    assert calls["step"] <= 20 and calls["outputs"] <= 20
    calls.update(outputs=0, step=0)
    result = rimbench.simulate(case, "zero-order-hold", 1e-3, divide_error=False, **SETTINGS)
    # One of them where both sides agree on where they begin, at a force of 0.
    assert calls == {"outputs": 3, "step": result.counters["mechanics_micro_steps"]}


def test_a_mechanics_is_deep_copied_where_steps_are_taken_again(example):
    own = rimbench.simulate(example("own_mechanics").case, "iterated-aitken", 1e-3, **SETTINGS)
    built_in = rimbench.simulate("linear-oscillator", "iterated-aitken", 1e-3, **SETTINGS)
    assert own.outcome == "completed"
    assert own.counters == built_in.counters
    np.testing.assert_allclose(own["x2_m"], built_in["x2_m"], rtol=0, atol=1e-9 * np.abs(own["x2_m"]).max())


def test_a_mechanics_whose_copy_is_itself_is_not_stepped_again(example):
    class Itself(example("own_mechanics").Mass):
        def __deepcopy__(self, memo):
            return self

    class Shared(example("own_mechanics").Mass):
        def __deepcopy__(self, memo):
            copy = object.__new__(type(self))
            copy.__dict__ = self.__dict__
            return copy

    for kind in (Itself, Shared):
        case = rimbench.Case("itself", like="linear-oscillator", mechanics=kind, reference="original")
        for settings in ({"scheme": "iterated-aitken"},):
            scheme = settings.pop("scheme", "zero-order-hold")
            result = rimbench.simulate(case, scheme, 1e-3, **SETTINGS, **settings)
            assert result.outcome == "skipped" and "cop" in result.reason, (kind, scheme, result.reason)


def test_an_interface_model_that_no_mechanics_can_have_is_refused(example):
    class Skew(example("own_mechanics").Mass):
        def interface_model(self, h):
            model = super().interface_model(h)
            model["H"] = -np.asarray(model["H"])
            return model

    case = rimbench.Case("skew", like="linear-oscillator", mechanics=Skew, reference="original")
    result = rimbench.simulate(case, "rim-smooth", 1e-3, **SETTINGS)
    assert result.outcome == "skipped" and "the sign of the force is reversed" in result.reason


@pytest.mark.parametrize("case", ["wedge-box", "linear-oscillator"])
def test_a_scheme_in_python_has_the_digits_of_the_one_in_rust(example, case):
    settings = SETTINGS if case == "linear-oscillator" else {"duration_s": 0.3}
    own = rimbench.simulate(case, example("own_scheme").scheme, 1.3e-3, phase=0.4, **settings)
    built_in = rimbench.simulate(case, "first-order-hold", 1.3e-3, phase=0.4, **settings)
    assert own.outcome == built_in.outcome == "completed"
    for column, values in own.trace.items():
        np.testing.assert_array_equal(values, built_in[column], column)
    assert own.metrics == built_in.metrics


def test_a_case_in_python_meets_holds_and_models(example):
    case = example("own_case").case
    lifted = {}
    for scheme in ["zero-order-hold", "second-order-hold", "rim-smooth", "rim-nonsmooth", "rim-nonsmooth-gap"]:
        result = rimbench.simulate(case, scheme, 5e-4)
        assert result.outcome == "completed", (scheme, result.reason)
        lifted[scheme] = result["gap_floor_m"].max()
        assert result["gap_floor_m"].min() > -1e-12
    # What a side in Python does not offer.
    for scheme, words in [("interface-jacobian", "no directional derivatives"), ("hydraulic-line", "no volumes of oil")]:
        result = rimbench.simulate(case, scheme, 5e-4)
        assert result.outcome == "skipped" and words in result.reason
    # One motion, however it is coupled; at rest the weight stays where it is.
    assert np.ptp(list(lifted.values())) < 0.1 * min(lifted.values())
    still = rimbench.simulate(case, "rim-nonsmooth-gap", amplitude_m=0.0)
    assert still.outcome == "completed" and np.abs(still["height_m"]).max() == 0.0


def test_both_sides_of_a_built_in_case_may_be_written_in_python(example):
    class Driver:
        """Mass 1 with the coupling spring: position and velocity of mass 2 in, force on it out at once."""

        observables = ("x1_m", "v1_m_s")

        def __init__(self, parameters):
            self.stiffness, self.spring = parameters["stiffness_1_n_m"], parameters["coupling_stiffness_n_m"]
            self.mass, self.x, self.v = parameters["mass_1_kg"], parameters["x1_0_m"], parameters["v1_0_m_s"]

        def outputs(self, u):
            return (self.spring * (self.x - u[0]),)

        def step(self, t, u, h):
            self.v += h * (-self.stiffness * self.x - self.spring * (self.x - u[0])) / self.mass
            self.x += h * self.v

        def observe(self):
            return self.x, self.v

    case = rimbench.Case(
        "all-in-python", like="linear-oscillator", mechanics=example("own_mechanics").Mass, actuator=Driver
    )
    own = rimbench.simulate(case, "zero-order-hold", 1e-3, **SETTINGS)
    built_in = rimbench.simulate("linear-oscillator", "zero-order-hold", 1e-3, **SETTINGS)
    assert own.completed and list(own.trace) == list(built_in.trace)
    for column in own.trace:
        largest = np.abs(built_in[column]).max()
        np.testing.assert_allclose(own[column], built_in[column], rtol=0, atol=1e-9 * largest, err_msg=column)
    # Held against its own sides in one loop, of the first order in 1 ms, instead of the exact solution.
    assert own.metrics["position_error_rms_m"] != built_in.metrics["position_error_rms_m"]


EXPERIMENT = """
question = "How do two macro steps differ?"
macro_steps_s = [1e-3, 2e-3]

[[cases]]
name = "shaken-weight"

[[schemes]]
scheme = "zero-order-hold"

[[schemes]]
scheme = "rim-nonsmooth-gap"
"""


def test_an_experiment_on_a_case_in_python_is_kept_until_its_code_changes(tmp_path):
    (tmp_path / "weight.toml").write_text(EXPERIMENT)
    source = (EXAMPLES / "own_case.py").read_text(encoding="utf-8")

    def rows(text, told):
        (tmp_path / "weight.py").write_text(text)
        spec = importlib.util.spec_from_file_location("weight", tmp_path / "weight.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return rimbench.run(tmp_path / "weight.toml", tmp_path / "out", cases=[module.case], progress=lambda *step: told.append(step))

    first, again, changed = [], [], []
    kept = rows(source, first)
    assert first[-1] == (4, 4) and all(row["outcome"] == "completed" for row in kept)
    assert rows(source, again) == kept and again == []
    other = rows(source + "\n# changed\n", changed)
    assert changed[-1] == (4, 4)
    assert [row["run_id"] for row in other] != [row["run_id"] for row in kept]
    assert [row["force_error_rms_n"] for row in other] == [row["force_error_rms_n"] for row in kept]


HELPED = """
import helper
import rimbench

class Mass(helper.Mass):
    made_from = ["table.bin"]

class Spring:
    direct_feedthrough = True
    def __init__(self, parameters): pass
    def outputs(self, u): return (-100.0 * u[0],)
    def step(self, t, u, h): pass

case = rimbench.Case("shaken-weight", mechanics=Mass, actuator=Spring, interface=[("x_m", "v_m_s", "f_n")], duration_s=0.1, macro_step_s=1e-3)
"""
HELPER = """
class Mass:
    own, moved = 50.0, False
    def __init__(self, parameters): self.x, self.v = 0.1, 0.0
    def outputs(self, u):
        if not self.moved:  # where a spring of its own carries the force
            self.x = 0.1 + u[0] / self.own
        return self.x, self.v
    def step(self, t, u, h):
        self.moved = True
        self.v += h * (u[0] + self.own * (0.1 - self.x))
        self.x += h * self.v
"""


def test_a_case_knows_the_modules_and_files_it_is_made_from_and_begins_where_both_sides_agree(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "weight.toml").write_text(EXPERIMENT.replace('[[schemes]]\nscheme = "rim-nonsmooth-gap"\n', ""))
    ids = []
    for helper, table in [(HELPER, b"1"), (HELPER, b"1"), (HELPER + "# another", b"1"), (HELPER, b"2")]:
        (tmp_path / "helper.py").write_text(helper)
        (tmp_path / "table.bin").write_bytes(table)
        (tmp_path / "weight.py").write_text(HELPED)
        monkeypatch.delitem(sys.modules, "helper", raising=False)
        spec = importlib.util.spec_from_file_location("weight", tmp_path / "weight.py")
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "weight", module)
        spec.loader.exec_module(module)
        ids.append(rimbench.run(tmp_path / "weight.toml", tmp_path / "out", cases=[module.case])[0]["run_id"])
    assert ids[0] == ids[1] and len(set(ids)) == 3
    assert rimbench.simulate(module.case, "zero-order-hold")["x_m"][0] == pytest.approx(0.1 / 3, rel=1e-12)
    module.Mass.own = -100.0
    with pytest.raises(rimbench.RimbenchError, match="do not agree on where they begin: under f_n = .* N the mechanics is at x_m = "):
        rimbench.simulate(module.case, "zero-order-hold")


@pytest.mark.parametrize("micro", ["\u00b5", "\u03bc", "u"])
def test_micro_is_one_letter(micro):
    assert rimbench.simulate("bouncing-ball", "zero-order-hold", f"5000{micro}s", duration_s=0.1).completed


def test_a_case_whose_code_is_not_to_be_had_is_not_kept(tmp_path, example):
    names = {"Mass": example("own_mechanics").Mass}
    exec("class Typed(Mass): pass", names)
    names["Typed"].__module__ = "typed"
    case = rimbench.Case("shaken-weight", like="linear-oscillator", mechanics=names["Typed"], reference="original")
    (tmp_path / "weight.toml").write_text(EXPERIMENT)
    with pytest.raises(rimbench.RimbenchError, match="nothing tells when its code changes.*valid: classes in a file"):
        rimbench.run(tmp_path / "weight.toml", tmp_path / "out", cases=[case])


def test_a_case_in_python_gets_advice(example):
    found = rimbench.advise(example("own_case").case, "5%", from_s="1ms", to_s="4ms", per_decade=4, phases=2)
    assert found.advised is not None and found.prices[1] > 0.0, found.notes
    run = rimbench.simulate(example("own_case").case, found.advised.scheme, **found.advised.settings)
    assert run.metrics["force_error_rms_of_peak"] == pytest.approx(found.advised.worst_error)


def test_the_limit_of_a_case_in_python(example):
    found = rimbench.limit(example("own_case").case, "zero-order-hold", from_s=1e-3, to_s=0.1, per_decade=3)
    assert found.first_unstable_s is not None and found.last_stable_s < found.first_unstable_s <= 0.1


def test_inputs_as_arrays_are_the_same_numbers(example):
    own, told = example("own_mechanics"), {False: set(), True: set()}

    def run(arrays):
        class Side(own.Mass):
            takes_arrays = arrays

            def step(self, t, u, h):
                told[arrays].add(type(u))
                return super().step(t, u, h)

        case = rimbench.Case("arrays", like="linear-oscillator", mechanics=Side, reference="original")
        return rimbench.simulate(case, "zero-order-hold", 1e-3, mechanics_steps=2, duration_s=0.05)

    tuples, arrays = run(False), run(True)
    assert told == {False: {tuple}, True: {np.ndarray}}
    assert tuples.completed and arrays.completed
    for column in tuples.trace:
        np.testing.assert_array_equal(tuples[column], arrays[column])


def test_a_scheme_gets_the_interface_model(example):
    seen = []

    class Curious(example("own_scheme").Line):
        def receive(self, side, sample):
            if side == "mechanics":
                seen.append(sample.model)
            super().receive(side, sample)

    scheme = rimbench.Scheme("curious", Curious, interface_model=True)
    rimbench.simulate("wedge-box", scheme, 1e-2, duration_s=0.1)
    model = seen[0]
    contacts = len(model["gap"])
    assert contacts == 4 and model["H"].shape == (contacts + 1, contacts + 1)
    np.testing.assert_allclose(model["H"], model["H"].T, rtol=0, atol=1e-12)
    assert np.linalg.eigvalsh(model["H"]).min() > -1e-12 and len(model["closed"]) == contacts


@pytest.mark.parametrize("interface_model", [True, False])
def test_a_scheme_is_not_given_a_model_with_friction(example, interface_model):
    scheme = rimbench.Scheme("modelled", example("own_scheme").Line, interface_model=interface_model)
    result = rimbench.simulate("wedge-box-friction", scheme, 1e-3, duration_s=0.01)
    expected = ("skipped", True) if interface_model else ("completed", False)
    assert (result.outcome, "knows no friction" in result.reason) == expected


def test_how_often_a_side_is_made(example):
    made = []

    class Weight(example("own_case").Weight):
        def __init__(self, parameters):
            made.append(parameters)
            super().__init__(parameters)

    own = example("own_case")
    case = rimbench.Case(
        "counted", mechanics=Weight, actuator=own.ShakenSpring, duration_s=0.01, macro_step_s=1e-3,
        parameters={"mass_kg": 2.0, "stiffness_n_m": 1000.0, "amplitude_m": 0.03},
        interface=[("height_m", "speed_m_s", "spring_force_n")],
    )
    counts = [len(made)]
    for _ in range(3):
        rimbench.simulate(case, "zero-order-hold", divide_error=False)
        counts.append(len(made))
    # To know its observables and to be checked; then for the reference and the run; then for runs.
    assert [after - before for before, after in zip([0] + counts, counts)] == [3, 5, 1, 1]


class Broken:
    """Goes on for a while, and then does what it is told."""

    def __init__(self, parameters):
        self.steps = 0

    def outputs(self, u):
        return 0.0, 0.0

    def step(self, t, u, h):
        self.steps += 1
        if self.steps == 100:
            return self.fail()

    def fail(self):
        raise ZeroDivisionError("out of zeros")


def broken(fail, **more):
    kind = type("Told", (Broken,), {"fail": fail, **more})
    return rimbench.Case("broken", like="linear-oscillator", mechanics=kind, reference="original")


def test_an_exception_in_a_callback_is_an_outcome_with_its_traceback():
    def fail(self):
        raise ZeroDivisionError("out of zeros")

    result = rimbench.simulate(broken(fail), "zero-order-hold", 1e-3, mechanics_steps=1)
    assert result.outcome == "subsystem-failed" and 0.09 < result.outcome_at_s < 0.11
    assert result.reason.startswith("ZeroDivisionError: out of zeros (test_own.py, line ")
    assert isinstance(result.exception, ZeroDivisionError)
    shown = "".join(traceback.format_exception(result.exception))
    assert 'raise ZeroDivisionError("out of zeros")' in shown and "in step" in shown


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        ((1.0, 2.0, 3.0), "ValueError: step gives 3 numbers instead of 2"),
        ("nonsense", "TypeError: step gives <class 'str'> instead of a sequence of 2 numbers"),
        (("a", "b"), "TypeError: a number that step gives = 'a' (str) is not valid; valid: a number"),
        (np.zeros(3), "ValueError: step gives 3 numbers instead of 2"),
    ],
)
def test_answers_of_the_wrong_kind_are_outcomes(answer, reason):
    result = rimbench.simulate(broken(lambda self: answer), "zero-order-hold", 1e-3, mechanics_steps=1)
    assert (result.outcome, result.reason[: len(reason)]) == ("subsystem-failed", reason)


def test_numbers_that_are_none_are_a_divergence():
    result = rimbench.simulate(broken(lambda self: (np.nan, 0.0)), "zero-order-hold", 1e-3, mechanics_steps=1)
    assert result.outcome == "diverged" and "not finite" in result.reason


def test_an_observable_that_fails_ends_the_run():
    def observe(self):
        raise OSError("blind")

    case = broken(lambda self: None, observables=("seen_m",), observe=observe)
    result = rimbench.simulate(case, "zero-order-hold", 1e-3)
    assert result.outcome == "subsystem-failed" and "OSError: blind" in result.reason


@pytest.mark.parametrize("name", ["observe", "interface_work"])
def test_what_is_raised_at_the_last_communication_point_is_not_lost(name):
    class Late(Broken):
        observables = ("seen_m",)

        def observe(self):
            return self.late("observe", (0.0,))

        def interface_work(self):
            return self.late("interface_work", 0.0)

        def late(self, asked, answer):
            if asked == name and self.steps == 10:
                raise OSError("blind at the end")
            return answer

    case = rimbench.Case("late", like="linear-oscillator", mechanics=Late, reference="original")
    result = rimbench.simulate(case, "zero-order-hold", 1e-2, micro_step_s=1e-2, mechanics_steps=1, duration_s=0.1)
    assert (result.outcome, result.outcome_at_s) == ("subsystem-failed", pytest.approx(0.1))
    assert result.reason.startswith("OSError: blind at the end") and isinstance(result.exception, OSError)


def test_an_observation_that_fails_at_the_end_of_a_reference_leaves_none(example):
    class Late(example("own_case").Weight):
        time = 0.0

        def step(self, t, u, h):
            self.time = t + h
            return super().step(t, u, h)

        def observe(self):
            # The end of the run, within less than any step.
            if self.time > 0.01 - 1e-6:
                raise OSError("blind at the end")
            return super().observe()

    own = example("own_case")
    case = rimbench.Case(
        "late-reference", mechanics=Late, actuator=own.ShakenSpring, duration_s=0.01, macro_step_s=1e-3,
        parameters={"mass_kg": 2.0, "stiffness_n_m": 1000.0, "amplitude_m": 0.03}, reference_step_s=1e-4,
        interface=[("height_m", "speed_m_s", "spring_force_n")],
    )
    for _ in range(2):
        with pytest.raises(rimbench.RimbenchError, match="has no reference.*is NaN at 0.0100 s") as raised:
            rimbench.simulate(case, "zero-order-hold", 1e-3, micro_step_s=1e-3)
        assert isinstance(raised.value.__cause__, OSError)


def test_runs_of_one_case_in_several_threads_keep_their_exceptions(example):
    class Counted(Broken):
        """Raises its number, if that is odd."""

        def __init__(self, parameters):
            super().__init__(parameters)
            # Parameters are all that a side is told; the velocity at the start is of no use to this one.
            self.number = parameters["v2_0_m_s"]

        def fail(self):
            if self.number % 2 == 1:
                raise LookupError(self.number)

    case = rimbench.Case("threads", like="linear-oscillator", mechanics=Counted, reference="original")
    scheme = rimbench.Scheme("threads", example("own_scheme").Line)

    def once(number):
        return rimbench.simulate(case, scheme, 1e-3, mechanics_steps=1, duration_s=0.2, v2_0_m_s=number)

    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(4) as pool:
            results = list(pool.map(once, range(1, 41)))
    finally:
        sys.setswitchinterval(usual)
    for number, result in enumerate(results, 1):
        if number % 2 == 1:
            assert result.outcome == "subsystem-failed" and result.exception.args == (number,), number
            assert result.reason.startswith(f"LookupError: {float(number)} (test_own.py")
        else:
            assert result.outcome != "subsystem-failed" and result.exception is None, number


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_calls_leave_no_memory_behind(example):
    case = example("own_mechanics").case

    def kilobytes():
        with open("/proc/self/smaps_rollup") as file:
            return next(int(line.split()[1]) for line in file if line.startswith("Anonymous:"))

    def calls(count):
        for _ in range(count):
            rimbench.simulate(case, "zero-order-hold", 1e-2, duration_s=0.02)

    calls(300)
    before = kilobytes()
    calls(1000)
    # A pool of threads that stays takes 7.7 kB a call.
    assert kilobytes() - before < 2000


def test_what_cannot_be_built_is_an_exception_with_its_cause():
    def explode(parameters):
        raise RuntimeError("no such mechanics")

    with pytest.raises(rimbench.RimbenchError, match="RuntimeError: no such mechanics") as raised:
        rimbench.Case("exploding", like="linear-oscillator", mechanics=explode)
    assert isinstance(raised.value.__cause__, RuntimeError)
    with pytest.raises(rimbench.RimbenchError, match="the mechanics of case empty, .* has no method `outputs`"):
        rimbench.Case("empty", like="linear-oscillator", mechanics=lambda parameters: object())


def test_a_case_without_a_reference_is_an_exception_with_its_cause():
    class Failing(Broken):
        def step(self, t, u, h):
            raise ArithmeticError("never")

    # The first steps are taken when the case is made.
    with pytest.raises(rimbench.RimbenchError, match="the mechanics fails in its first steps: ArithmeticError: never") as raised:
        rimbench.Case("no-reference", like="linear-oscillator", mechanics=Failing)
    assert isinstance(raised.value.__cause__, ArithmeticError)

    class Late(Broken):
        fail = Broken.fail

    case = rimbench.Case("no-reference", like="linear-oscillator", mechanics=Late)
    with pytest.raises(rimbench.RimbenchError, match="has no reference .*ZeroDivisionError: out of zeros") as raised:
        rimbench.simulate(case, "zero-order-hold", 1e-3, duration_s=0.1)
    assert isinstance(raised.value.__cause__, ZeroDivisionError)


class Honest:
    """A mass of 1 kg at 0.1 m, on a spring of 100 N/m."""

    direct_feedthrough = False

    def __init__(self, parameters):
        self.x, self.v = 0.1, 0.0

    def outputs(self, u):
        return self.x, self.v

    def step(self, t, u, h):
        self.v += h * u[0]
        self.x += h * self.v

    def interface_model(self, h):
        return {"H": [[1.0]], "a": [0.0], "w": [self.v], "position": [self.x], "gap": []}


class Spring:
    direct_feedthrough = True

    def __init__(self, parameters):
        pass

    def outputs(self, u):
        return (-100.0 * u[0],)

    def step(self, t, u, h):
        return None


def pair(mechanics, actuator=Spring, **more):
    more = {"duration_s": 0.5, "macro_step_s": 1e-3, **more}
    return rimbench.Case(
        "pair", mechanics=mechanics, actuator=actuator, interface=[("x_m", "v_m_s", "f_n")], **more
    )


def told(outputs=(1.0, 1.0), force=1.0, h=1.0, a=0.0):
    class Liar(Honest):
        def outputs(self, u):
            return outputs[0] * self.x, outputs[1] * self.v

        def step(self, t, u, h):
            super().step(t, (force * u[0],), h)

        def interface_model(self, step):
            x, v = self.outputs(())
            return {"H": [[h]], "a": [a], "w": [v], "position": [x], "gap": []}

    return Liar


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"outputs": (1.0, -1.0)}, "the velocity is reversed"),
        ({"outputs": (-1.0, 1.0)}, "the position is reversed"),
        ({"outputs": (1000.0, 1.0)}, "the position is wrong.*mm for m"),
        ({"outputs": (1.0, 1000.0)}, "the velocity is wrong.*mm for m"),
        ({"force": -1.0}, "the sign of the force is reversed"),
        ({"force": 1000.0}, "the force or its interface model"),
        ({"h": 10.0}, "H of the model is 10"),
        ({"a": 1e4}, "a of the model"),
    ],
)
def test_a_side_that_does_not_add_up_is_named(how, words):
    with pytest.raises(rimbench.RimbenchError, match=words):
        pair(told(**how))
    assert rimbench.simulate(pair(told()), "rim-smooth").completed


def test_a_model_that_turns_false_during_the_run_is_the_fault_of_its_side():
    class Turns(Honest):
        time = 0.0

        def step(self, t, u, h):
            self.time = t + h
            super().step(t, u, h)

        def interface_model(self, h):
            model = super().interface_model(h)
            return model if self.time < 0.3 else {**model, "w": [9.0], "position": [5.0]}

    result = rimbench.simulate(pair(Turns), "rim-smooth")
    assert result.outcome == "subsystem-failed" and 0.29 < result.outcome_at_s < 0.32
    assert "position, row 0, is 5" in result.reason and "not of the scheme" in result.reason
    assert rimbench.simulate(pair(Turns), "zero-order-hold").completed


@pytest.mark.parametrize("answer", [0.1, (1.0,), ("0.1", "0.2"), {"x": 1}])
def test_what_is_wrong_in_the_first_steps_is_said_when_the_case_is_made(answer):
    class Wrong(Honest):
        def outputs(self, u):
            return answer

    with pytest.raises(rimbench.RimbenchError, match="the mechanics fails in its first steps: (Type|Value)Error"):
        pair(Wrong)

    class Returns(Spring):
        def step(self, t, u, h):
            return self.outputs(u)

    with pytest.raises(rimbench.RimbenchError, match="the actuator fails in its first steps: TypeError: step gives outputs"):
        pair(Honest, Returns)


OF_BOTH = {
    "name": "mine", "mechanics": Broken, "actuator": Broken, "interface": [("x_m", "v_m_s", "f_n")],
    "duration_s": 1.0, "macro_step_s": 1e-3,
}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"name": "Wedge", "like": "wedge-box", "mechanics": Broken}, "kebab-case"),
        ({"name": "wedge-box", "like": "wedge-box", "mechanics": Broken}, "not taken yet"),
        ({"name": "mine", "like": "wedge-boxx", "mechanics": Broken}, "did you mean `wedge-box`"),
        ({"name": "mine", "like": "wedge-box"}, "needs a mechanics or an actuator of its own"),
        ({"name": "mine", "mechanics": Broken}, "needs mechanics, actuator, interface, duration_s and macro_step_s"),
        ({"name": "mine", "like": "wedge-box", "mechanics": Broken, "reference": "none"}, "valid: own, original"),
        ({"name": "mine", "like": "wedge-box", "mechanics": Broken, "parameters": {}}, "give neither"),
        ({**OF_BOTH, "parameters": {"phase": 0.5}}, "parameter `phase`: an option of a run"),
        ({**OF_BOTH, "parameters": {"mass_kg": 1.0, "from_s": 0.5}}, "parameter `from_s`: an option"),
    ],
)
def test_descriptions_that_make_no_case_are_refused(arguments, words):
    with pytest.raises(rimbench.RimbenchError, match=words):
        rimbench.Case(**arguments)


def test_a_model_of_the_wrong_size_is_an_outcome(example):
    class Wide(example("own_mechanics").Mass):
        contacts = 2

    case = rimbench.Case("wide", like="linear-oscillator", mechanics=Wide, reference="original")
    result = rimbench.simulate(case, "rim-smooth", 1e-3, **SETTINGS)
    assert "`H` has 1 numbers instead of 9" in result.reason


def test_a_scheme_that_fails_is_an_outcome(example):
    class Lost(example("own_scheme").Line):
        def input(self, side, at, own):
            raise IndexError("lost")

    result = rimbench.simulate("bouncing-ball", rimbench.Scheme("lost", Lost), 1e-3)
    assert result.outcome == "scheme-failed" and isinstance(result.exception, IndexError)


SCHEMES = """
class Base:
    def __init__(self, outputs):
        self.held = {}
    def receive(self, side, sample):
        self.held["mechanics" if side == "actuator" else "actuator"] = sample.y

class Polynomial(Base):
    def polynomial(self, side, step):
        return [(y,) for y in self.held[side]]

class Inputs(Base):
    def inputs(self, side, step):
        return [self.held[side]] * step.count

class Input(Base):
    def input(self, side, at, own):
        return self.held[side]
"""


def test_a_hold_in_each_form_is_the_hold_and_is_kept_until_its_code_changes(tmp_path, monkeypatch):
    text = EXPERIMENT[: EXPERIMENT.index("[[cases]]")] + '[[cases]]\nname = "bouncing-ball"\nduration_s = 0.2\n'
    names = ["polynomial", "inputs", "input"]
    rows = "".join(f'[[schemes]]\nscheme = "{name}"\n' for name in ["zero-order-hold", *names])
    (tmp_path / "grid.toml").write_text(text + rows)

    def run(code):
        (tmp_path / "mine.py").write_text(code)
        spec = importlib.util.spec_from_file_location("mine", tmp_path / "mine.py")
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "mine", module)
        spec.loader.exec_module(module)
        made = [rimbench.Scheme(name, getattr(module, name.capitalize())) for name in names]
        return rimbench.run(tmp_path / "grid.toml", tmp_path / "out", schemes=made)

    first, again, changed = run(SCHEMES), run(SCHEMES), run(SCHEMES + "# changed\n")
    assert len({(row["macro_step_s"], row["phase"], row["force_error_rms_n"]) for row in first}) == len(first) / 4
    assert [row["run_id"] for row in first] == [row["run_id"] for row in again]
    assert all((row["run_id"] in {old["run_id"] for old in first}) == (row["label"] == "zero-order-hold") for row in changed)


@pytest.mark.parametrize("told", [[float("nan")] * 2, [], [(1.0, 2.0), (1.0,)], [["1.0"], ["2.0"]], "12", 3.0, [(1.0,) * 5] * 2])
def test_what_is_no_polynomial_is_an_outcome(told):
    class Wrong:
        def __init__(self, outputs):
            pass

        def receive(self, side, sample):
            pass

        def polynomial(self, side, step):
            return told

    result = rimbench.simulate("bouncing-ball", rimbench.Scheme("wrong", Wrong), 1e-3)
    assert result.outcome == "scheme-failed" and result.reason, told

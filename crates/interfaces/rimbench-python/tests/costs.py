"""Measures what Python costs, as ratios of wall times: the table of docs/guide/python.md. By hand: no test looks at times."""

import copy
import os
import statistics
import sys
import time
from pathlib import Path

import rimbench

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from own_mechanics import Mass, case  # noqa: E402
from own_scheme import scheme as line  # noqa: E402

ROUNDS = 11
SETTINGS = {"integrator": "semi-implicit-euler", "duration_s": 10.0, "micro_step_s": 1e-4}


class Silent(Mass):
    """Its steps return no outputs, which are then asked for."""

    def step(self, t, u, h):
        self.v += h * (u[0] / self.mass - self.stiffness * self.x)
        self.x += h * self.v


class Hold:
    """The scheme of the guide."""

    def __init__(self, outputs):
        self.held = {}

    def receive(self, side, sample):
        self.held[side] = sample.y

    def input(self, side, at, own):
        return self.held["actuator" if side == "mechanics" else "mechanics"]


silent = rimbench.Case("silent", like="linear-oscillator", mechanics=Silent, reference="original")
hold = rimbench.Scheme("my-hold", Hold)


def run(case, scheme, steps):
    """Wall time of the coupled run, as the run itself counts it (s), and its mechanics steps."""
    result = rimbench.simulate(case, scheme, 1e-3, mechanics_steps=steps, **SETTINGS)
    assert result.completed, result.reason
    return result.costs["wall_s"], result.counters["mechanics_micro_steps"]


def bare(kind, steps):
    """Wall time of as many calls of the method from Python."""
    side = kind(case_parameters)
    step, u, h = side.step, (0.1,), 1e-7
    start = time.perf_counter()
    for _ in range(steps):
        step(0.0, u, h)
    return time.perf_counter() - start


listed = next(entry for entry in rimbench.cases() if entry["name"] == "linear-oscillator")
case_parameters = {entry["name"]: entry["default"] for entry in listed["parameters"]}
ratios = {}
for _ in range(ROUNDS):
    rust_1, _ = run("linear-oscillator", "zero-order-hold", 1)
    rust_10, steps = run("linear-oscillator", "zero-order-hold", 10)
    python_1, _ = run(case, "zero-order-hold", 1)
    python_10, _ = run(case, "zero-order-hold", 10)
    silent_10, _ = run(silent, "zero-order-hold", 10)
    hold_10, _ = run("linear-oscillator", hold, 10)
    line_10, _ = run("linear-oscillator", line, 10)
    first_order_10, _ = run("linear-oscillator", "first-order-hold", 10)
    for name, ratio in {
        "a mechanics step that returns its outputs, to the bare call": (python_10 - rust_10) / bare(Mass, steps),
        "the same with a call of `outputs` besides": (silent_10 - rust_10) / bare(Silent, steps),
        "a run with the mechanics in Python, one step per macro step": python_1 / rust_1,
        "the same, ten steps": python_10 / rust_10,
        "a run with the scheme in Python, ten steps, holding": hold_10 / rust_10,
        "the same, extrapolating": line_10 / first_order_10,
    }.items():
        ratios.setdefault(name, []).append(ratio)
for name, found in ratios.items():
    low, _, high = statistics.quantiles(found, n=4)
    print(f"{name}: median {statistics.median(found):.2f}, quartiles {low:.2f} to {high:.2f}")


def of_an_engine(machine, rows, parameters, arrays):
    """Parts of a macro step of a machine on servos, each over `mj_step` of the same states in between; H = 10 ms, 40 micro steps. Times are
    those of the run's own thread, to which what else this machine does adds nothing."""
    spent, now = {}, time.thread_time

    def timed(part, call, *given):
        begun = now()
        told = call(*given)
        spent[part] = spent.get(part, 0.0) + now() - begun
        return told

    class Robot(getattr(sides, machine)):
        def look(self, u, h):
            self._take_steps_of(h)
            other = spent["other"] if "other" in spent else spent.setdefault("other", mujoco.MjData(self.model))
            mujoco.mj_copyData(other, self.model, self.data)
            other.qfrc_applied[6:] = u
            timed("mj_step", mujoco.mj_step, self.model, other)
            timed("a copy of the side", copy.deepcopy, self)

        def step(self, t, u, h):
            timed("looks", self.look, u, h)
            told = timed("side", super().step, t, u, h)
            spent["end"] = now()
            return told

        def interface_model(self, h):
            spent.setdefault("begin", now())
            return timed("model", super().interface_model, h)

    class Servos(getattr(sides, f"{machine}Servos")):
        takes_arrays = arrays

    class Timed(Servos):
        calls = []

        def outputs(self, u):
            begun = time.perf_counter()
            told = super().outputs(u)
            self.calls.append(time.perf_counter() - begun)
            return told

    def runs(servos):
        engine = rimbench.Case(
            "engine", mechanics=Robot, actuator=servos, parameters={"kp_n_m_rad": 1000.0, **parameters},
            interface=[(f"q{row}_m", f"v{row}_m_s", f"force{row}_n") for row in range(rows)], duration_s=1.0, macro_step_s=0.01,
            micro_step_s=2.5e-4, reference_step_s=2.5e-4,
        )  # fmt: skip
        while True:
            spent.clear()
            yield rimbench.simulate(engine, "rim-nonsmooth", contacts_act="mechanics-step", divide_error=False)

    parts, plain, looked_at = {}, runs(Servos), runs(Timed)
    next(plain), next(looked_at)
    for _ in range(ROUNDS):
        Timed.calls.clear()
        next(looked_at)
        run = next(plain)
        assert run.completed, run.reason
        found = {part: spent[part] for part in ("model", "side", "a copy of the side")}
        # Of each call what it mostly takes, without those in which others had the processor.
        found["actuator in Python"] = statistics.median(Timed.calls) * run.counters["actuator_micro_steps"]
        known = sum(spent[part] for part in ("model", "side", "looks")) + found["actuator in Python"]
        found["scheme and calls"] = spent["end"] - spent["begin"] - known
        found["model, side, scheme and calls"] = found["model"] + found["side"] + found["scheme and calls"]
        for part, time_s in found.items():
            parts.setdefault(part, []).append(time_s / spent["mj_step"])
    return parts


try:
    import mujoco

    sys.path.insert(0, str(Path(__file__).parents[4] / "experiments" / "study" / "servos"))
    import sides
except ImportError:
    print("skipped: the package `mujoco` is not there")
    sys.exit()
machines = [("Quadruped", 12, {"feet_condim": 3.0})]
if Path(os.environ.get("RIMBENCH_DATA_OF_OTHERS", ""), "mujoco/humanoid.xml").is_file():
    machines.append(("Humanoid", 21, {}))
else:
    print("skipped: RIMBENCH_DATA_OF_OTHERS has no mujoco/humanoid.xml")
for machine, rows, parameters in machines:
    for arrays in (False, True):
        for part, found in of_an_engine(machine, rows, parameters, arrays).items():
            name = f"{machine}, inputs as {'arrays' if arrays else 'tuples'}, {part}, to mj_step"
            print(f"{name}: median {statistics.median(found):.2f}")

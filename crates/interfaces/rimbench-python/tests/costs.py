"""Measures what Python costs, as ratios of wall times: the table of docs/guide/python.md. By hand: no test looks at times."""

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


def of_an_engine():
    """Parts of a macro step of a quadruped on servos, each over `mj_step` of the same state in between; H = 10 ms, 40 micro steps."""
    import mujoco

    sys.path.insert(0, str(Path(__file__).parents[4] / "experiments" / "study" / "servos"))
    import sides

    spent = dict.fromkeys(("mj_step", "model", "side", "servos"), 0.0)

    def timed(part, call, *given):
        begun = time.perf_counter()
        told = call(*given)
        spent[part] += time.perf_counter() - begun
        return told

    class Robot(sides.Quadruped):
        def step(self, t, u, h):
            other = self.__dict__.setdefault("other", mujoco.MjData(self.model))
            self._take_steps_of(h)
            mujoco.mj_copyData(other, self.model, self.data)
            other.qfrc_applied[6:] = u
            timed("mj_step", mujoco.mj_step, self.model, other)
            return timed("side", super().step, t, u, h)

        def interface_model(self, h):
            return timed("model", super().interface_model, h)

    class Servos(sides.QuadrupedServos):
        def outputs(self, u):
            return timed("servos", super().outputs, u)

    rows = [(f"angle{row}_m", f"rate{row}_m_s", f"torque{row}_n") for row in range(12)]
    engine = rimbench.Case(
        "engine", mechanics=Robot, actuator=Servos, interface=rows, parameters={"kp_n_m_rad": 1000.0, "feet_condim": 3.0},
        duration_s=2.0, macro_step_s=0.01, micro_step_s=2.5e-4, reference_step_s=2.5e-4,
    )  # fmt: skip
    rimbench.simulate(engine, "zero-order-hold", 0.01)
    parts = {}
    for _ in range(ROUNDS):
        spent.update(dict.fromkeys(spent, 0.0))
        run = rimbench.simulate(engine, "rim-nonsmooth", contacts_act="mechanics-step", divide_error=False)
        spent["scheme and conversion"] = run.costs["wall_s"] - sum(spent.values())
        for part, time_s in spent.items():
            parts.setdefault(part, []).append(time_s / spent["mj_step"])
        del spent["scheme and conversion"]
    return {part: found for part, found in parts.items() if part != "mj_step"}


try:
    of_parts = of_an_engine()
except ImportError:
    print("skipped: the package `mujoco` is not there")
else:
    for part, found in of_parts.items():
        print(f"{part}, to mj_step: median {statistics.median(found):.2f}")

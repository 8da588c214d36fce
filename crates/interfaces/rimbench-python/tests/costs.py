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

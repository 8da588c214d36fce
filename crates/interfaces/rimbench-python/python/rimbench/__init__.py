"""Co-simulation of mechanical systems with contact: stability, energy, accuracy and cost of coupling schemes.

Times are in seconds, lengths in metres, forces in newtons; every other name ends in its unit. Digits are those of the command line,
to the bit. Bad input raises `RimbenchError`, in the words of the command line; a run that fails is a result, with its outcome and
the reason.
"""

from __future__ import annotations

import csv
import hashlib
import html
import inspect
import json
import os
import re
import site
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

try:
    from ._native import __version__
except ImportError as reason:
    from ._absent import stand_in

    stand_in(reason)
from . import _native, mujoco
from ._native import MicroStep, RimbenchError, Sample, __version__, cases, metrics, schemes

if TYPE_CHECKING:
    import pandas
    from typing_extensions import Self

    from ._native import CouplingScheme, Subsystem

__all__ = [
    "Advice",
    "Case",
    "Choice",
    "Limit",
    "MicroStep",
    "RimbenchError",
    "Result",
    "Rows",
    "Sample",
    "Scheme",
    "__version__",
    "advise",
    "cases",
    "limit",
    "metrics",
    "mujoco",
    "open_case",
    "run",
    "schemes",
    "simulate",
]

#: A time in s, or a text with its unit, such as "5ms".
Time = float | str
_UNITS = {"ns": 1e9, "us": 1e6, "\u00b5s": 1e6, "\u03bcs": 1e6, "ms": 1e3, "min": 1.0 / 60.0, "s": 1.0}


def _seconds(key: str, value: Any) -> Any:
    """The time in s that a text with a unit is; anything else as it is, and of one that is no time the error is the caller's."""
    if not isinstance(value, str) or not key.endswith("_s") or key.endswith(("_m_s", "_rad_s")):
        return value
    found = re.fullmatch(r"\s*([-+.\deE]+)\s*(ns|us|\u00b5s|\u03bcs|ms|min|s)\s*", value)
    try:
        return float(found[1]) / _UNITS[found[2]] if found else value
    except ValueError:
        return value


def _source(maker: Any) -> str:
    """The file that says how a side is made, or its own text where it is in no file, as in a notebook."""
    parts = vars(maker).values() if isinstance(maker, type) else (maker,)
    codes = (getattr(part, "__code__", None) for part in parts)
    for file in (Path(code.co_filename) for code in codes if code):
        if file.is_file():
            return file.read_text(encoding="utf-8")
    return inspect.getsource(maker)


def _modules(maker: Any) -> list[Path]:
    """Files of the modules that the module of a maker names, and those name in turn; without itself, and without what is installed."""
    places = [sys.prefix, sys.base_prefix, str(Path(os.__file__).parent), *site.getsitepackages(), site.getusersitepackages()]
    system = [Path(place).resolve() for place in places]
    parts = (maker, *(vars(maker).values() if isinstance(maker, type) else ()))
    waiting = [names for names in (getattr(part, "__globals__", None) for part in parts) if names][:1]
    seen = {getattr(maker, "__module__", None)}
    files = []
    while waiting:
        for value in list(waiting.pop().values()):
            name = value.__name__ if inspect.ismodule(value) else getattr(value, "__module__", None)
            file = getattr(sys.modules.get(name), "__file__", None) if isinstance(name, str) and name not in seen else None
            if isinstance(name, str) and file and not any(Path(file).resolve().is_relative_to(place) for place in system):
                seen.add(name)
                waiting.append(vars(sys.modules[name]))
                files.append(Path(file))
    return sorted(files)


def _digest(files: Iterable[str | PathLike[str]]) -> str:
    """Hash of names and contents of files."""
    parts = sorted(f"{Path(file).name} {hashlib.sha256(Path(file).read_bytes()).hexdigest()}" for file in files)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def _made_from(side: Any) -> str:
    """What a side says that it is made of besides its code: a text, or files beside its own."""
    said = side.made_from
    if isinstance(said, str):
        return said
    try:
        beside = Path(inspect.getfile(type(side))).parent
    except (TypeError, OSError):
        beside = Path()
    return _digest(beside / file for file in said)


def _code(makers: Iterable[Any]) -> tuple[str | None, str]:
    """Hash of the code that makes sides; else why there is none."""
    text = ""
    for maker in makers:
        try:
            text += _source(maker)
            if files := _modules(maker):
                text += _digest(files)
        except (TypeError, OSError):
            return None, f"the source of {maker!r} is not to be had"
    return hashlib.sha256(text.encode()).hexdigest()[:16], ""


class Case(_native.Case):
    """A case of which Python makes one side or both.

    Parameters
    ----------
    name : kebab-case, not taken by a built-in case.
    like : a built-in case; what is not given here is as there: parameters, times, the other side, columns of the trace.
    mechanics, actuator : called with the parameters, a dictionary, whenever a new side is needed: when the case is made, for each run, and
        for each of the three solutions of an own reference; return an object with `outputs(u)` and `step(t, u, h)`.
    parameters : names (ending in their units) and defaults, for a case that is like no other; no option of a call may have such a name.
    interface : `(position, velocity, force)` names per interface row, for a case that is like no other: the mechanics puts out positions,
        then velocities, and gets forces.
    duration_s, macro_step_s, micro_step_s : times used unless others are asked for, s, or texts such as "5ms".
    reference_step_s : coarsest of the three steps of the reference, s; the micro step if not given.
    reference : "own", both sides in one loop with small steps; or "original", that of the case it is like.
    scale : position (m), velocity (m/s) and force (N) of the size that is to be expected. A row whose peak is below need not be known to a
        tenth of it. A run diverges beyond thrice a row's peak, or thrice a tenth of the scale; if none is given, thrice the peak of all rows.
        Forces that follow the motion at once have no bound.
    """

    def __new__(
        cls,
        name: str,
        *,
        like: str | None = None,
        mechanics: Callable[[dict[str, Any]], Subsystem] | None = None,
        actuator: Callable[[dict[str, Any]], Subsystem] | None = None,
        parameters: dict[str, float] | None = None,
        interface: Sequence[tuple[str, str, str]] | None = None,
        duration_s: Time | None = None,
        macro_step_s: Time | None = None,
        micro_step_s: Time | None = None,
        reference_step_s: Time | None = None,
        reference: Literal["own", "original"] = "own",
        scale: tuple[float, float, float] | None = None,
    ) -> Self:
        steps = (duration_s, macro_step_s, micro_step_s, reference_step_s)
        times = tuple(_seconds("time_s", time) for time in steps)
        sides = (mechanics, actuator)
        code = _code(side for side in sides if side is not None)
        return super().__new__(cls, (name, reference, code), like, sides, parameters, interface, (times, scale))


class Scheme(_native.Scheme):
    """A coupling scheme written in Python.

    Parameters
    ----------
    name : kebab-case, not taken by a built-in scheme.
    make : called for each run with the names of what each side puts out, `{"mechanics": (...), "actuator": (...)}`; returns an object with
        `receive(side, sample)`, called for each side at each communication point, and one of three: `polynomial(side, step)`, once per macro
        step, for each input up to four coefficients of the time since its start; `inputs(side, step)`, the inputs of all `step.count` micro
        steps, a row each; `input(side, at, own)`, for each micro step, its inputs, in the order of the other side's outputs, as their
        mean over the micro step. `own` is what that side itself puts out.
    order : declared order in H, a pure number.
    samples : samples of the past that it needs to be what it is.
    interface_model : whether the samples of the mechanics are to come with its reduced interface model.
    """

    def __new__(
        cls,
        name: str,
        make: Callable[[dict[str, tuple[str, ...]]], CouplingScheme],
        *,
        order: int = 1,
        samples: int = 1,
        interface_model: bool = False,
    ) -> Self:
        code = _code([make])
        return super().__new__(cls, name, make, code, order=order, samples=samples, interface_model=interface_model)


def open_case(file: str | PathLike[str]) -> _native.Case:
    """Opens a case file, whose sides are FMUs or classes of Python in files, each in a process of its own.

    Raises
    ------
    RimbenchError : what does not fit, with file and variable.
    """
    return _native.open_case(file, sys.executable or "python3")


#: Told how much is done of how much; `True` draws a bar on standard error.
Progress = Callable[[int, int], object] | bool
Setting = float | int | str


def _told(progress: Progress | None) -> Callable[[int, int], object] | None:
    if progress is True:
        return _bar
    if progress and not callable(progress):
        valid = "what is called with done and to do, or True"
        raise TypeError(f"progress = {progress!r} ({type(progress).__name__}) is not valid; valid: {valid}")
    return progress or None


def _bar(done: int, total: int) -> None:
    if done > total:
        return  # a search goes on after its scan
    full = 30 * done // max(total, 1)
    sys.stderr.write(f"\r[{'#' * full}{' ' * (30 - full)}] {done}/{total}" + "\n" * (done == total))
    sys.stderr.flush()


def _table(rows: Sequence[Sequence[Any]], head: Sequence[str] = ()) -> str:
    """A table of HTML."""

    def cell(value: Any) -> str:
        return html.escape(f"{value:.4g}" if isinstance(value, float) else "" if value is None else str(value))

    lines = [f"<tr>{''.join(f'<th>{html.escape(name)}</th>' for name in head)}</tr>"] if head else []
    lines += [f"<tr>{''.join(f'<td>{cell(value)}</td>' for value in row)}</tr>" for row in rows]
    return f"<table>{''.join(lines)}</table>"


def _axes(axes: Any) -> Any:
    """Axes of matplotlib to draw in."""
    if axes is not None:
        return axes
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise RimbenchError("plot needs the package `matplotlib`, which is not there; valid: pip install matplotlib") from None
    return plt.subplots(layout="constrained")[1]


@dataclass(frozen=True, eq=False)
class Result:
    """One run, evaluated against its reference."""

    #: Hash of everything that determines the run.
    run_id: str
    #: `completed`, `diverged`, `out-of-range`, `solver-failed`, `subsystem-failed`, `scheme-failed`, `timeout` or `skipped`.
    outcome: str
    #: When the run left the path of a completed one, s; `None` if it did not.
    outcome_at_s: float | None
    #: Why, in words; empty for a completed run.
    reason: str
    #: Time of the last communication point reached, s.
    ended_at_s: float
    #: Metrics of the case by name (see `metrics()` for units and meaning), the keys of `rimbench simulate --format json`;
    #: `None` where one does not apply.
    metrics: dict[str, float | None] = field(repr=False)
    #: How much of the force error is the coupling's, in the words of `rimbench simulate`, or why that is not told apart;
    #: empty where that was not asked for.
    error_parts: str = field(repr=False)
    #: One array per column, one number per communication point; names end in their units.
    trace: dict[str, NDArray[np.float64]] = field(repr=False)
    #: What the run is judged by, at the same times: motion and force of the interface, and gaps.
    reference: dict[str, NDArray[np.float64]] = field(repr=False)
    #: Everything that determines the run, by the names of experiment files.
    settings: dict[str, str | float | int | None] = field(repr=False)
    #: Exact counts of the work.
    counters: dict[str, int] = field(repr=False)
    #: Wall time (s) and latencies (s) on this machine.
    costs: dict[str, float | int | None] = field(repr=False)
    #: What a callback raised, if that is what ended the run; `raise result.exception` shows where.
    exception: BaseException | None = None

    @property
    def completed(self) -> bool:
        """Whether the run came to its end within bounds."""
        return self.outcome == "completed"

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        """A column of the trace."""
        return self.trace[column]

    def to_dataframe(self) -> pandas.DataFrame:
        """The trace as a pandas DataFrame, one row per communication point."""
        import pandas

        return pandas.DataFrame(self.trace)

    def plot(self, *columns: str, ax: Any = None) -> Any:
        """Draws columns over time, by default the forces, beside the reference, and returns the axes of matplotlib."""
        known = [name for name in self.trace if name != "time_s"]
        if unknown := [name for name in columns if name not in self.trace]:
            raise RimbenchError(f"the trace has no column `{unknown[0]}`; valid: {', '.join(known)}")
        ax = _axes(ax)
        for name in columns or [name for name in known if name.endswith("force_n")] or known[:1]:
            ax.plot(self.trace["time_s"], self.trace[name], label=name)
            if name in self.reference and name != "time_s":
                ax.plot(self.reference["time_s"], self.reference[name], "k--", linewidth=1, label=f"{name}, reference")
        ax.set(xlabel="time_s", title=f"{self.settings.get('case')}, {self.settings.get('scheme')}: {self.outcome}")
        ax.legend()
        return ax

    def _repr_html_(self) -> str:
        known = ("case", "scheme", "macro_step_s")
        rows = [(key, self.settings[key]) for key in known if key in self.settings]
        rows += [("outcome", self.outcome), ("reason", self.reason), ("outcome_at_s", self.outcome_at_s)]
        rows += [("force error", self.error_parts)]
        return _table([row for row in (*rows, *self.metrics.items()) if row[1] not in (None, "")])


@dataclass(frozen=True)
class Limit:
    """The largest stable macro step, as far as a scan can tell."""

    #: Largest stable macro step below the first unstable one, s; `None` if the whole scan is stable, or nothing is.
    stability_limit_s: float | None
    #: The same, also where nothing was unstable, s.
    last_stable_s: float | None
    #: Smallest unstable macro step, s.
    first_unstable_s: float | None
    #: Smallest macro step of which nothing is known (time-out, panic), s.
    no_answer_s: float | None
    #: Every macro step that was tried, ascending: `macro_step_s`, `fraction_stable`, `failure`, `spectral_radius`.
    points: list[dict[str, Any]] = field(repr=False)

    def plot(self, ax: Any = None) -> Any:
        """Draws the stable fraction over the macro step, and returns the axes of matplotlib."""
        ax = _axes(ax)
        known = [point for point in self.points if point["fraction_stable"] is not None]
        ax.semilogx([point["macro_step_s"] for point in known], [point["fraction_stable"] for point in known], "o-")
        ax.set(xlabel="macro_step_s", ylabel="fraction_stable")
        return ax

    def _repr_html_(self) -> str:
        keys = ("macro_step_s", "fraction_stable", "failure", "spectral_radius")
        return _table([("stability_limit_s", self.stability_limit_s)]) + _table([[point[key] for key in keys] for point in self.points], keys)


@dataclass(frozen=True)
class Choice:
    """A scheme in one of its forms, at a macro step."""

    scheme: str
    #: The scheme, with what its forms are of besides: contacts over the mechanics' step, or steps that are split.
    way: str
    form: str
    macro_step_s: float
    run_id: str
    #: Rms force error over the peak, at the worst phase.
    worst_error: float | None
    #: Counts of what has a price, each the largest of any phase.
    work: list[float]
    #: In micro steps of the wedge box.
    cost: float
    #: Exchanges and steps of the mechanics, each per second of simulated time.
    spent_per_s: list[float]
    time_per_macro_step_s: float
    #: `processor`, or `wall` where a side is from outside.
    time_is_of: str
    #: What to give `simulate`: `simulate(case, choice.scheme, **choice.settings)`.
    settings: dict[str, str] = field(repr=False)


@dataclass(frozen=True)
class Advice:
    """The cheapest scheme and its largest macro step that keep within an error, or what errs least within a budget."""

    #: `None` if nothing does: `notes` say what came nearest.
    advised: Choice | None
    #: The cheapest of another scheme.
    runner_up: Choice | None
    #: The cheapest of those tried that has at most half of the error of the advised one.
    finer: Choice | None
    #: What has to be said of the choice, or why there is none.
    notes: list[str]
    runs_made: int
    #: Cells of which nothing is known, having taken too long.
    undecided: int
    #: Cells that could not be run, by the reason.
    skipped: dict[str, int] = field(repr=False)
    #: Phases at which the error is met.
    phases: int
    #: Of an exchange, a mechanics step, a micro step and a model solve.
    prices: list[float]
    reference_uncertainty_of_peak: float | None
    #: Of a budget, what the advised scheme comes to with twice the exchanges, and with twice the steps of the mechanics.
    doubled: list[Choice] | None = None

    def _repr_html_(self) -> str:
        keys = ("scheme", "form", "macro_step_s", "worst_error", "cost", "time_per_macro_step_s")
        rows = [[getattr(choice, key) for key in keys] for choice in (self.advised, self.runner_up) if choice]
        return _table(rows, keys) + "".join(f"<p>{html.escape(note)}</p>" for note in self.notes)


class Rows(list[dict[str, Any]]):
    """The rows of an experiment's `runs.csv`, and the folder that holds all its result files."""

    def __init__(self, folder: Path, rows: list[dict[str, Any]]) -> None:
        super().__init__(rows)
        self.folder = folder

    def to_dataframe(self) -> pandas.DataFrame:
        """The rows as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(list(self))

    def plot(self, x: str, y: str, by: str = "scheme", ax: Any = None) -> Any:
        """Draws one column over another, a line for each value of a third, and returns the axes of matplotlib."""
        valid = list(self[0]) if self else []
        if unknown := [name for name in (x, y, by) if name not in valid]:
            raise RimbenchError(f"the rows have no column `{unknown[0]}`; valid: {', '.join(valid)}")
        ax = _axes(ax)
        for value in dict.fromkeys(row[by] for row in self):
            points = sorted((row[x], row[y]) for row in self if row[by] == value and None not in (row[x], row[y]))
            ax.plot([point[0] for point in points], [point[1] for point in points], "o-", label=value)
        ax.set(xlabel=x, ylabel=y)
        ax.legend(title=by)
        return ax

    def _repr_html_(self) -> str:
        filled = [name for name in (self[0] if self else ()) if any(row[name] not in (None, "") for row in self)]
        return _table([[row[name] for name in filled] for row in self[:50]], filled) + f"<p>{len(self)} rows</p>"


def simulate(
    case: str | _native.Case,
    scheme: str | Scheme,
    macro_step_s: Time | None = None,
    *,
    divide_error: bool = True,
    **settings: Setting,
) -> Result:
    """Runs a case with a scheme, and evaluates it against the reference.

    Parameters
    ----------
    case, scheme : names (see `cases()` and `schemes()`), or a `Case` or `Scheme` of your own.
    macro_step_s : macro step H, s, or a text such as "5ms"; that of the case if not given.
    divide_error : whether a second run tells how much of the error is the coupling's; `False` where each step of a side is dear.
    **settings : parameters of the case (`box_mass_kg=250`), and options of a run by the names that they have in experiment files
        (`phase`, `duration_s`, `force_return`, `mechanics_step_s`, `gain`, ...).

    Raises
    ------
    RimbenchError : names that are none and values that are not valid; a case that has no reference with these parameters.
    KeyboardInterrupt : Ctrl-C ends the run in its next step.
    """
    if macro_step_s is not None:
        settings["macro_step_s"] = macro_step_s
    return Result(**_native.simulate(case, scheme, _in_seconds(settings), divide_error))


def _in_seconds(settings: dict[str, Setting]) -> dict[str, Setting]:
    return {key: _seconds(key, value) for key, value in settings.items()}


def advise(
    case: str | _native.Case,
    error: float | str | None = None,
    *,
    exchanges: float | None = None,
    scheme: str | Scheme | None = None,
    from_s: Time | None = None,
    to_s: Time | None = None,
    per_decade: int = 10,
    phases: int = 32,
    model: bool = True,
    feedback: bool = True,
    real_time: bool = False,
    costs: Sequence[float] | None = None,
    progress: Progress | None = None,
    **settings: Setting,
) -> Advice:
    """Finds the cheapest scheme and its largest macro step that keep within an error at every phase, or what errs least within a budget, as
    `rimbench advise` does.

    Parameters
    ----------
    error : rms force error allowed, of the peak force of the reference: "1%" or 0.01.
    exchanges : instead of an error so many exchanges per second of simulated time, with `mechanics_steps=1000` so many steps of the
        mechanics per second. Errors are then those inside macro steps.
    scheme : the one that competes alone; all if not given.
    from_s, to_s, per_decade : macro steps that are tried, as for `limit`.
    phases : size of the ensemble of communication phases.
    model, feedback, real_time : whether there may be an interface model, and a force within its own macro step; and whether no step may be
        taken again.
    costs : of an exchange, a mechanics step, a micro step and a model solve; of sides from outside as measured if not given.
    progress : called with runs done and runs to do; `True` draws a bar.
    **settings : as for `simulate`, without macro step and phase.
    """
    given = {"error": error, "from_s": from_s, "to_s": to_s, "costs": costs}
    beside = [name for name, value in given.items() if value is not None]
    if exchanges is not None and beside:
        raise RimbenchError(f"exchanges = {exchanges!r}: a budget is asked for, and {beside[0]} is of an error; valid: one of the two")
    if exchanges is None and error is None:
        raise RimbenchError('error = None is not valid; valid: a share of the peak force, "1%" or 0.01, or exchanges and mechanics_steps')
    ends = (_seconds("from_s", from_s), _seconds("to_s", to_s))
    search = (ends, per_decade, phases, (model, feedback, real_time), costs)
    found = json.loads(_native.advise(case, scheme, [error, exchanges], _in_seconds(settings), search, _told(progress)))
    for which in ("advised", "runner_up", "finer"):
        found[which] = found[which] and Choice(**found[which])
    if "doubled" in found:
        found["doubled"] = [Choice(**choice) for choice in found["doubled"]]
    return Advice(**found)


def limit(
    case: str | _native.Case,
    scheme: str | Scheme,
    *,
    from_s: Time | None = None,
    to_s: Time | None = None,
    per_decade: int = 12,
    phases: int = 1,
    relative_tolerance: float = 0.01,
    method: Literal["run", "spectral"] = "run",
    progress: Progress | None = None,
    **settings: Setting,
) -> Limit:
    """Searches the largest stable macro step: scans, then narrows the bracket around the first unstable macro step.

    Parameters
    ----------
    from_s, to_s : ends of the scan, s; 1e-4 and 0.1 if not given, less for a short run.
    per_decade : macro steps per decade of the scan.
    phases : size of the ensemble of communication phases; a macro step is stable if all of them are.
    relative_tolerance : relative width to which the bracket is narrowed.
    method : `run` to the end within bounds, or take the `spectral` radius of the macro-step map (linear cases).
    progress : called with macro steps done and macro steps in the scan; the bracket around the first unstable one takes more, so that
        what is done goes beyond. `True` draws a bar, of the scan.
    **settings : as for `simulate`, without macro step and phase.
    """
    ends = (_seconds("from_s", from_s), _seconds("to_s", to_s))
    scan = (ends, per_decade, phases, relative_tolerance)
    found = _native.limit(case, scheme, _in_seconds(settings), scan, method, _told(progress))
    return Limit(**found)


#: Columns whose cells are texts, whatever they look like.
_TEXTS = frozenset(("run_id", "label", "set", "reason", "trace"))


def _cell(column: str, text: str) -> Any:
    if not text:
        return None
    if column in _TEXTS:
        return text
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text


def run(
    file: str | PathLike[str],
    out: str | PathLike[str] | None = None,
    *,
    quick: bool = False,
    fresh: bool = False,
    progress: Progress | None = None,
    cases: Sequence[_native.Case] = (),
    schemes: Sequence[Scheme] = (),
) -> Rows:
    """Runs what is missing of an experiment on all cores, and returns its rows.

    Parameters
    ----------
    file : the experiment file.
    out : folder for results; `results/<group>/<name>` if not given, as on the command line.
    quick : the quick form of the experiment.
    fresh : forget what is stored and start again.
    progress : called with runs done and runs to do; `True` draws a bar.
    cases : cases of your own, which the experiment may name besides the built-in ones; of classes the hash of their files is part of what
        determines a run.
    schemes : schemes of your own, likewise.

    Ctrl-C raises `KeyboardInterrupt`; what is stored is kept, and the same call goes on from there.
    """
    folder = _native.run(file, out, quick, fresh, _told(progress), (cases, schemes))
    with open(folder / "runs.csv", newline="", encoding="utf-8") as table:
        rows = [{column: _cell(column, text) for column, text in row.items()} for row in csv.DictReader(table)]
    return Rows(folder, rows)

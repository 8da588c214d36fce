"""Co-simulation of mechanical systems with contact: stability, energy, accuracy and cost of coupling schemes.

Times are in seconds, lengths in metres, forces in newtons; every other name ends in its unit. Digits are those of the command line,
to the bit. Bad input raises `RimbenchError`, in the words of the command line; a run that fails is a result, with its outcome and
the reason.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._native import MicroStep, RimbenchError, Sample, Scheme, __version__, cases, metrics, schemes

if TYPE_CHECKING:
    import pandas
    from typing_extensions import Self

    from ._native import Subsystem

__all__ = [
    "Case",
    "Limit",
    "MicroStep",
    "RimbenchError",
    "Result",
    "Rows",
    "Sample",
    "Scheme",
    "__version__",
    "cases",
    "limit",
    "metrics",
    "open_case",
    "run",
    "schemes",
    "simulate",
]

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
    duration_s, macro_step_s, micro_step_s : times used unless others are asked for, s.
    reference_step_s : coarsest of the three steps of the reference, s; the micro step if not given.
    reference : "own", both sides in one loop with small steps; or "original", that of the case it is like.
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
        duration_s: float | None = None,
        macro_step_s: float | None = None,
        micro_step_s: float | None = None,
        reference_step_s: float | None = None,
        reference: Literal["own", "original"] = "own",
    ) -> Self:
        times_s = (duration_s, macro_step_s, micro_step_s, reference_step_s)
        return super().__new__(cls, (name, reference), like, (mechanics, actuator), parameters, interface, times_s)


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
    return _bar if progress is True else progress or None


def _bar(done: int, total: int) -> None:
    if done > total:
        return  # a search goes on after its scan
    full = 30 * done // max(total, 1)
    sys.stderr.write(f"\r[{'#' * full}{' ' * (30 - full)}] {done}/{total}" + "\n" * (done == total))
    sys.stderr.flush()


@dataclass(frozen=True, eq=False)
class Result:
    """One run, evaluated against its reference."""

    #: Hash of everything that determines the run.
    run_id: str
    #: `completed`, `diverged`, `out-of-range`, `solver-failed`, `subsystem-failed`, `timeout` or `skipped`.
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
    #: One array per column, one number per communication point; names end in their units.
    trace: dict[str, NDArray[np.float64]] = field(repr=False)
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


class Rows(list[dict[str, Any]]):
    """The rows of an experiment's `runs.csv`, and the folder that holds all its result files."""

    def __init__(self, folder: Path, rows: list[dict[str, Any]]) -> None:
        super().__init__(rows)
        self.folder = folder

    def to_dataframe(self) -> pandas.DataFrame:
        """The rows as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(list(self))


def simulate(
    case: str | _native.Case, scheme: str | Scheme, macro_step_s: float | None = None, **settings: Setting
) -> Result:
    """Runs a case with a scheme, and evaluates it against the reference.

    Parameters
    ----------
    case, scheme : names (see `cases()` and `schemes()`), or a `Case` or `Scheme` of your own.
    macro_step_s : macro step H, s; that of the case if not given.
    **settings : parameters of the case (`box_mass_kg=250`), and options of a run by the names that they have in experiment files
        (`phase`, `duration_s`, `force_return`, `mechanics_step_s`, `gain`, ...).

    Raises
    ------
    RimbenchError : names that are none and values that are not valid; a case that has no reference with these parameters.
    KeyboardInterrupt : Ctrl-C ends the run in its next step.
    """
    if macro_step_s is not None:
        settings["macro_step_s"] = macro_step_s
    return Result(**_native.simulate(case, scheme, settings))


def limit(
    case: str | _native.Case,
    scheme: str | Scheme,
    *,
    from_s: float | None = None,
    to_s: float | None = None,
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
    found = _native.limit(
        case, scheme, settings, ((from_s, to_s), per_decade, phases, relative_tolerance), method, _told(progress)
    )
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
) -> Rows:
    """Runs what is missing of an experiment on all cores, and returns its rows.

    Parameters
    ----------
    file : the experiment file.
    out : folder for results; `results/<group>/<name>` if not given, as on the command line.
    quick : the quick form of the experiment.
    fresh : forget what is stored and start again.
    progress : called with runs done and runs to do; `True` draws a bar.
    cases : of case files (`open_case`), which the experiment may name besides the built-in ones.

    Ctrl-C raises `KeyboardInterrupt`; what is stored is kept, and the same call goes on from there.
    """
    folder = _native.run(file, out, quick, fresh, _told(progress), list(cases))
    with open(folder / "runs.csv", newline="", encoding="utf-8") as table:
        rows = [{column: _cell(column, text) for column, text in row.items()} for row in csv.DictReader(table)]
    return Rows(folder, rows)

from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, Protocol, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

__version__: str

class RimbenchError(ValueError):
    """Bad input, in the words of the command line: what is wrong, and what would be valid."""

class Subsystem(Protocol):
    """What `mechanics` and `actuator` of a `Case` return.

    It may have more: `direct_feedthrough` (bool); `takes_arrays` (bool), to be given inputs as arrays; `observables` (names) and
    `observe()`, their values; `interface_work()`, the work received through the interface since the start (J); and `interface_model(h)`, the system reduced to its interface for its own step h
    (s), with the number of `contacts`, their `stabilisation` and `restitution` (pure numbers in [0, 1]). It returns a dictionary:
    `H` (1/kg), `a` (m/s²), `w` (m/s), rows of contacts first, then of the interface; `gap` (m) of the contacts, `position` (m) of the
    interface; `closed`, which contacts carried impulse, if it knows. One without such a model may say why in `no_interface_model`.

    Rows of an engine that give way may come and go, at most `engine_rows` of them: `compliance` R (1/kg), `damping` b (1/s) and `stiffness` k
    (1/s²) of each say `0 <= w+ - (1 - h b) w + h k g + R P`, complementary to P >= 0, in each of `steps` steps of its own in h; `opposite` is the row
    whose mean with this one is the rate of g, itself if not given. `symmetric`: False where contacts answer to forces of the interface otherwise than the interface to theirs. `model_from_s` is the shortest h (s).

    An actuator may have `output_rates(t, u)`: a dictionary of `rate`, outputs per s with the input held, `feedthrough`, output per input, and
    `rate_gain`, rate per input, if it is not 0.
    """

    def outputs(self, u: tuple[float, ...], /) -> ArrayLike:
        """The outputs of the present state; `u` matters only with direct feedthrough."""
    def step(self, t: float, u: tuple[float, ...], h: float, /) -> ArrayLike | None:
        """Advances from `t` (s) by `h` (s) with the input held; may return the outputs of the state that it has come to."""

class CouplingScheme(Protocol):
    """What `make` of a `Scheme` returns. It must have one more: `polynomial(side, step)`, `inputs(side, step)` or `input(side, at, own)`."""

    def receive(self, side: Literal["mechanics", "actuator"], sample: Sample, /) -> None:
        """Takes note of what a side sends at a communication point."""

class Case:
    """What `rimbench.Case` is made of: name, reference and hash of its code, the case it is like, both sides, and times (s)."""

    def __new__(
        cls,
        name_reference_and_code: tuple[str, str, tuple[str | None, str]],
        like: str | None,
        sides: tuple[Callable[[dict[str, Any]], Subsystem] | None, Callable[[dict[str, Any]], Subsystem] | None],
        parameters: dict[str, float] | None,
        interface: Sequence[tuple[str, str, str]] | None,
        times_and_scale: tuple[tuple[float | None, ...], tuple[float, float, float] | None],
        /,
    ) -> Self: ...
    @property
    def name(self) -> str: ...

class Scheme:
    """What `rimbench.Scheme` is made of, with the hash of its code, or why there is none."""

    def __new__(
        cls,
        name: str,
        make: Callable[[dict[str, tuple[str, ...]]], CouplingScheme],
        code: tuple[str | None, str],
        /,
        *,
        order: int = 1,
        samples: int = 1,
        interface_model: bool = False,
    ) -> Self: ...
    @property
    def name(self) -> str: ...

class EngineRows:
    """The constraint rows of a model of MuJoCo as an interface model: kinds of rows are those of equalities and of edges of pyramids."""

    def __new__(cls, model: Any, kinds: list[int], /) -> Self: ...
    def of(
        self, data: Any, interface: NDArray[np.float64], speeds: NDArray[np.float64], is_sparse: bool, damped: bool, /
    ) -> dict[str, Any]:
        """The model as it is in `data`, without `position` and `steps`, by the factors of M + h D if that is `damped`."""

class Sample:
    """What one side sends at a communication point: time (s), outputs `y`, and the macro step that starts here (s)."""

    @property
    def time(self) -> float: ...
    @property
    def y(self) -> tuple[float, ...]: ...
    @property
    def model(self) -> dict[str, Any] | None: ...
    @property
    def index(self) -> int: ...
    @property
    def start(self) -> float: ...
    @property
    def length(self) -> float: ...

class MicroStep:
    """One micro step inside a macro step; times in s."""

    @property
    def index(self) -> int: ...
    @property
    def count(self) -> int: ...
    @property
    def length(self) -> float: ...
    @property
    def start(self) -> float: ...
    @property
    def middle(self) -> float: ...
    @property
    def since_exchange(self) -> float: ...

class ParameterEntry(TypedDict):
    name: str
    unit: str
    default: float | str
    valid: str
    about: str

class CaseEntry(TypedDict):
    name: str
    about: str
    duration_s: float
    macro_step_s: float
    micro_step_s: float
    columns: list[str]
    parameters: list[ParameterEntry]

class SchemeEntry(TypedDict):
    name: str
    about: str
    order: int
    sequence: str
    gain: float | None
    real_time: bool

class MetricEntry(TypedDict):
    name: str
    unit: str
    about: str

def cases() -> list[CaseEntry]:
    """All cases with their times (s), columns and parameters."""

def schemes() -> list[SchemeEntry]:
    """All schemes with their order in H, usual sequence and gain."""

def metrics() -> list[MetricEntry]:
    """All metrics with their units."""

def simulate(case: str | Case, scheme: str | Scheme, settings: dict[str, Any], divide_error: bool, /) -> dict[str, Any]: ...
def limit(
    case: str | Case,
    scheme: str | Scheme,
    settings: dict[str, Any],
    scan: tuple[tuple[float | None, float | None], int, int, float],
    method: str,
    progress: Callable[[int, int], object] | None,
    /,
) -> dict[str, Any]: ...
def advise(
    case: str | Case,
    scheme: str | Scheme | None,
    goal: list[float | str | None],
    settings: dict[str, Any],
    search: tuple[tuple[float | None, float | None], int, int, tuple[bool, bool, bool], Iterable[float] | None],
    progress: Callable[[int, int], object] | None,
    /,
) -> str: ...
def run(
    file: str | PathLike[str],
    out: str | PathLike[str] | None,
    quick: bool,
    fresh: bool,
    progress: Callable[[int, int], object] | None,
    cases_and_schemes: tuple[Iterable[Case], Iterable[Scheme]],
    /,
) -> Path: ...
def open_case(file: str | PathLike[str], python: str, /) -> Case: ...
def fmu_worker() -> None: ...

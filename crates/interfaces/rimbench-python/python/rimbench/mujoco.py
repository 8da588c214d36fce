"""A model of MuJoCo as the mechanics of a case: sites, tendons or joints take a force, and put out position and velocity.

`Mechanics` gives the exact interface model, of the engine's own constraint rows or of rigid contacts, or says why there is none; and it is
copied with all that the engine keeps, so that schemes that try steps of it can.
"""

from __future__ import annotations

import copy
import difflib
import hashlib
import math
from collections.abc import Callable, Iterable, Sequence
from os import PathLike, fspath
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._native import RimbenchError

__all__ = ["Mechanics"]

Numbers = NDArray[np.float64]

#: The oldest version of MuJoCo with which all tests pass.
OLDEST = 3, 10
#: Most contacts of a pair in the engine, by the kinds of both; of others `OTHERS`. One of a sphere or an ellipsoid has one.
MOST = {("PLANE", "CAPSULE"): 2, ("CAPSULE", "CAPSULE"): 2, ("CAPSULE", "BOX"): 2, ("BOX", "BOX"): 8}
OTHERS = 4
#: Kinds of joints from which on they have one coordinate, a slide and a hinge; a free joint and a ball come before.
SLIDE = 2
#: Time by which the engine is moved on and back for what is left of accelerations without forces, s.
AHEAD = 1e-6
#: What is left without an exact model.
REMAINS = "rim-answers tries steps of the engine instead"
#: Gap of a contact that the engine has not, because it is out of reach, m; its row is 0.
FAR = 1.0


def _engine() -> Any:
    try:
        import mujoco
    except ImportError:
        raise RimbenchError("rimbench.mujoco needs the package `mujoco`, which is not there; valid: pip install mujoco") from None
    return mujoco


def _names(model: Any, kind: str) -> list[str]:
    count = {"site": model.nsite, "tendon": model.ntendon, "joint": model.njnt, "geom": model.ngeom, "key": model.nkey}[kind]
    names = (getattr(model, kind)(index).name for index in range(count))
    return [name for name in names if name]


def _find(model: Any, kind: str, name: object) -> int:
    """Number of what has that name."""
    names = _names(model, kind)
    if name not in names:
        close = difflib.get_close_matches(str(name), names, 1)
        valid = f"did you mean `{close[0]}`?" if close else f"valid: {', '.join(names[:12]) or 'none, it has no names'}"
        raise RimbenchError(f"the MuJoCo model has no {kind} `{name}`; {valid}")
    return int(getattr(model, kind)(name).id)


def _dense(values: Numbers, width: int, sparse: tuple[Any, Any, Any] | None) -> Numbers:
    """Rows of a Jacobian that the engine keeps dense, or as counts, addresses and columns of what is not 0."""
    if sparse is None:
        return values.reshape(-1, width)
    counts, starts, columns = (np.ravel(part) for part in sparse)
    rows, flat, ends = np.zeros((len(counts), width)), np.ravel(values), counts.cumsum()
    at = np.arange(ends[-1] if len(ends) else 0) + np.repeat(starts - ends + counts, counts)
    rows[np.repeat(np.arange(len(counts)), counts), columns[at]] = flat[at]
    return rows


def _span(places: Any) -> Any:
    """Places in an array, as a slice where they follow one another: that is taken out three times as fast."""
    first = int(places[0])
    return slice(first, first + len(places)) if (np.diff(places) == 1).all() else places


class Mechanics:
    """A side made of a model of MuJoCo.

    Parameters
    ----------
    model : an `MjModel`, which is copied, the path of an MJCF file, or its text.
    interface : what takes a force (N) and puts out position (m) and velocity (m/s), one per row: `("tendon", name)`; `("joint", name)` of
        a slide, of a hinge with a lever, `("joint", name, lever_m)`, by which angles are multiplied and torques divided; `("site", name,
        direction)` along a fixed direction, or `("site", name, other)` with the distance to another site, which a force above 0 lengthens.
    contacts : what the exact interface model has of contacts, limits and equality constraints. "engine": the rows of the engine's constraint
        solver, with friction, compliance, margins; then the model's answer is the engine's step. Pairs of names of geoms that may touch:
        rigid contacts of these, and rigid limits. If not given: "engine", or where its rows are none of that kind and nothing can touch, rigid
        limits.
    engine_rows : room for so many rows of the engine at once; a limit is one, a contact 1, 4, 6 or 10 by its condim 1, 3, 4 or 6.
    reach : distance beyond which a rigid contact is no part of that model, m.
    keyframe : name of the keyframe to start from.

    It steps by the model's `timestep`, or by equal steps that are shorter. A subclass may set `self.data.ctrl` in `control(t)`, called
    before each step of the engine, and forces of its own: to `self.data.qfrc_applied` those of the interface are added. It may say what
    else is recorded in `observables` and `observe()`; what it keeps besides is copied.
    """

    stabilisation = 0.0
    takes_arrays = True

    def __init__(
        self,
        model: Any,
        interface: Sequence[tuple[Any, ...]],
        *,
        contacts: Iterable[tuple[str, str]] | Literal["engine"] | None = None,
        engine_rows: int = 128,
        reach: float = 0.1,
        keyframe: str | None = None,
    ) -> None:
        engine = _engine()
        if tuple(int(part) for part in engine.__version__.split(".")[:2]) < OLDEST:
            oldest = ".".join(map(str, OLDEST))
            found = f"rimbench.mujoco needs MuJoCo {oldest} or newer, and this is {engine.__version__}"
            raise RimbenchError(f'{found}; valid: pip install "mujoco>={oldest}"')
        self.model = self._read(engine, model)
        if int(self.model.opt.integrator) == int(engine.mjtIntegrator.mjINT_RK4):
            raise RimbenchError(
                "the MuJoCo model has the integrator RK4, within whose steps forces cannot follow the interface; valid: Euler, implicit, "
                "implicitfast"
            )
        # A state that is no number any more is told, and not reset.
        self.model.opt.disableflags |= engine.mjtDisableBit.mjDSBL_AUTORESET
        self.data = engine.MjData(self.model)
        if keyframe is not None:
            engine.mj_resetDataKeyframe(self.model, self.data, _find(self.model, "key", keyframe))
        #: Results of another model are not taken for those of this one.
        self.made_from = self._digest(engine)
        self._timestep = self._begun = float(self.model.opt.timestep)
        if not interface:
            raise RimbenchError('interface is empty; valid: one or more of ("tendon", name), ("joint", name), ("site", name, other)')
        self._interface = [self._row(row) for row in interface]
        self._pairs: dict[tuple[int, int], int] = {}
        if isinstance(contacts, str) and contacts != "engine":
            raise RimbenchError(f'contacts is `{contacts}`; valid: "engine", [(geom, geom), ...]')
        for pair in () if contacts is None or contacts == "engine" else contacts:
            one, other = (_find(self.model, "geom", name) for name in pair)
            masks = zip(self.model.geom_contype[[one, other]], self.model.geom_conaffinity[[other, one]])
            if not self._given(one, other) and not any(kind & with_kind for kind, with_kind in masks):
                raise RimbenchError(f"geoms `{pair[0]}` and `{pair[1]}` of contacts never touch; valid: contype and conaffinity that meet")
            kinds = tuple(engine.mjtGeom(kind).name[7:] for kind in sorted(self.model.geom_type[[one, other]]))
            is_round = {"SPHERE", "ELLIPSOID"} & set(kinds)
            self._pairs[min(one, other), max(one, other)] = 1 if is_round else MOST.get(kinds, OTHERS)
        self._reach = float(reach)
        self._limits = self._limited()
        self.contacts = sum(self._pairs.values()) + len(self._limits)
        by_engine = contacts is None or contacts == "engine"
        self.no_interface_model = self._refused_rows() if by_engine else self._refused()
        if contacts is None and self.no_interface_model and not self._may_touch() and not self._refused():
            by_engine, self.no_interface_model = False, None
        if by_engine:
            self.contacts, self.engine_rows, self.model_from_s = 0, int(engine_rows), self._timestep
        self._by_engine = by_engine
        #: Rows of sites and tendons turn as the model moves; of joints alone their places in positions and velocities, and levers.
        self._turns = any(row[0] != "joint" for row in interface)
        if not self._turns:
            numbers = [_find(self.model, "joint", row[1]) for row in interface]
            places, dofs = (_span(of[numbers]) for of in (self.model.jnt_qposadr, self.model.jnt_dofadr))
            self._joints = places, dofs, np.array([(*row, 1.0)[2] for row in interface], dtype=float)
            self._rows = np.array([row(self.data)[1] for row in self._interface])
        self._equality, pyramid = (int(getattr(engine.mjtConstraint, f"mjCNSTR_{kind}")) for kind in ("EQUALITY", "CONTACT_PYRAMIDAL"))
        self._engine_rows = _native.EngineRows(self.model, [self._equality, pyramid])
        self._euler = int(engine.mjtIntegrator.mjINT_EULER)
        self._undamped = int(engine.mjtDisableBit.mjDSBL_EULERDAMP | engine.mjtDisableBit.mjDSBL_DAMPER)
        self._whole = int(engine.mjtState.mjSTATE_INTEGRATION)
        self._kept = np.zeros(engine.mj_stateSize(self.model, self._whole))
        if self.no_interface_model:
            self.interface_model = None  # type: ignore[assignment]
        self._wide: list[Any] = []
        self._check_delays(self._timestep)
        self._spare: list[Any] = []
        self._work = 0.0
        self._see()

    @staticmethod
    def _read(engine: Any, model: Any) -> Any:
        if isinstance(model, engine.MjModel):
            return copy.copy(model)
        text = fspath(model) if isinstance(model, PathLike) else model
        if not isinstance(text, str):
            raise RimbenchError(f"model is {type(model).__name__}; valid: an MjModel, the path of an MJCF file, or its text")
        try:
            read = engine.MjModel.from_xml_string if text.lstrip().startswith("<") else engine.MjModel.from_xml_path
            return read(text)
        except ValueError as error:
            raise RimbenchError(f"the MuJoCo model cannot be read: {error}".replace("\n", "; ")) from None

    def _digest(self, engine: Any) -> str:
        whole = np.zeros(engine.mj_sizeModel(self.model), np.uint8)
        engine.mj_saveModel(self.model, None, whole)
        return hashlib.sha256(whole.tobytes()).hexdigest()[:16]

    # What the rows are.

    def _row(self, row: tuple[Any, ...]) -> Callable[[Any], tuple[float, Numbers]]:
        """What gives position and Jacobian of an interface row, from the engine's data."""
        engine, model = _engine(), self.model
        match tuple(row) if isinstance(row, (tuple, list)) else row:
            case ("tendon", name):
                tendon = _find(model, "tendon", name)
                return lambda data: (data.ten_length[tendon], self._tendons(data)[tendon])
            case ("joint", name, *lever) if len(lever) < 2:
                joint, times = _find(model, "joint", name), float(lever[0]) if lever else 1.0
                if model.jnt_type[joint] < SLIDE:
                    raise RimbenchError(f"joint `{name}` has more than one coordinate; valid: a slide or a hinge")
                if not (math.isfinite(times) and times):
                    raise RimbenchError(f"joint `{name}` has the lever {times} m; valid: a finite number that is not 0")
                unit = np.zeros(model.nv)
                unit[model.jnt_dofadr[joint]] = times
                place = model.jnt_qposadr[joint]
                return lambda data: (times * data.qpos[place], unit)
            case ("site", name, str(other)):
                ends = _find(model, "site", name), _find(model, "site", other)
                return lambda data: self._distance(data, *ends)
            case ("site", name, direction):
                site, along = _find(model, "site", name), np.array(direction, dtype=float)
                if along.shape != (3,) or not np.linalg.norm(along) > 0.0:
                    raise RimbenchError(f"site `{name}` has the direction {direction}; valid: three numbers, not all 0")
                along /= np.linalg.norm(along)
                return lambda data: (along @ data.site_xpos[site], along @ self._jacobian(data, site))
        raise RimbenchError(
            f'interface has {row!r}; valid: ("tendon", name), ("joint", name), ("joint", name, lever_m), ("site", name, direction), '
            '("site", name, other site)'
        )

    def _tendons(self, data: Any) -> Numbers:
        sparse = None
        if data.ten_J.ndim == 1 or _engine().mj_isSparse(self.model):
            place = data if hasattr(data, "ten_J_rownnz") else self.model
            sparse = (place.ten_J_rownnz, place.ten_J_rowadr, place.ten_J_colind)
        return _dense(data.ten_J, self.model.nv, sparse)

    def _jacobian(self, data: Any, site: int) -> Numbers:
        jacobian = np.zeros((3, self.model.nv))
        _engine().mj_jacSite(self.model, data, jacobian, None, site)
        return jacobian

    def _distance(self, data: Any, one: int, other: int) -> tuple[float, Numbers]:
        along = data.site_xpos[one] - data.site_xpos[other]
        length = float(np.linalg.norm(along))
        if length == 0.0:
            raise RimbenchError("the two sites of an interface row are at one place, and their distance has no direction")
        return length, along / length @ (self._jacobian(data, one) - self._jacobian(data, other))

    def _limited(self) -> list[tuple[float, float, int, bool]]:
        """Limits of coordinates and tendons: sign, bound (m or rad), number, whether of a tendon."""
        model = self.model
        joints = [at for at in range(model.njnt) if model.jnt_limited[at] and model.jnt_type[at] >= SLIDE]
        tendons = [at for at in range(model.ntendon) if model.tendon_limited[at]]
        ends = [(at, False, *model.jnt_range[at], model.jnt_margin[at]) for at in joints]
        ends += [(at, True, *model.tendon_range[at], model.tendon_margin[at]) for at in tendons]
        lower = [(1.0, low + margin, at, of_tendon) for at, of_tendon, low, _, margin in ends]
        return lower + [(-1.0, high - margin, at, of_tendon) for at, of_tendon, _, high, margin in ends]

    def _given(self, one: int, other: int) -> list[int]:
        """Numbers of the model's own pairs of these geoms."""
        ends = zip(self.model.pair_geom1, self.model.pair_geom2)
        return [pair for pair, both in enumerate(ends) if {one, other} == set(both)]

    def _may_touch(self) -> bool:
        model = self.model
        touches = model.npair > 0 or any(model.geom_contype) and any(model.geom_conaffinity)
        return bool(touches) and not model.opt.disableflags & _engine().mjtDisableBit.mjDSBL_CONTACT

    def _refused_rows(self) -> str | None:
        """Why there is no exact interface model of the engine's rows, if there is none."""
        engine, model = _engine(), self.model
        loss = "bounds" if model.dof_frictionloss.any() or model.tendon_frictionloss.any() else ""
        elliptic = self._may_touch() and int(model.opt.cone) == int(engine.mjtCone.mjCONE_ELLIPTIC)
        integrator = engine.mjtIntegrator(model.opt.integrator).name[6:].lower()
        for what, valid in (
            (elliptic and "elliptic cones, whose rows do not push one by one", "cone pyramidal"),
            (model.opt.noslip_iterations and "noslip_iterations, which solve contacts another time", "0"),
            (loss and "frictionloss at a joint or a tendon, whose rows pull as well as push within bounds", "0"),
            (integrator not in ("euler", "implicitfast") and f"the integrator {integrator}, which has no such model", "Euler, implicitfast"),
        ):
            if what:
                return f"the MuJoCo model has {what}; valid: {valid}; {REMAINS}"
        return None

    def _refused(self) -> str | None:
        """Why there is no exact interface model of rigid contacts, if there is none."""
        model, remains = self.model, REMAINS
        for one, other in self._pairs:
            names = f"`{model.geom(one).name}` and `{model.geom(other).name}`"
            if given := self._given(one, other):
                dim, margin = model.pair_dim[given[0]], model.pair_margin[given[0]]
            else:
                first, second = sorted((one, other), key=lambda geom: -model.geom_priority[geom])
                equal = model.geom_priority[first] == model.geom_priority[second]
                dim = max(model.geom_condim[[one, other]]) if equal else model.geom_condim[first]
                margin = max(model.geom_margin[[one, other]])
            if dim > 1:
                return f"contacts of {names} have friction (condim {dim}), which that model has not; valid: condim 1; {remains}"
            if margin != 0.0:
                return f"contacts of {names} have a margin of {margin} m, at which they push before they touch; valid: 0; {remains}"
        if model.dof_frictionloss.any() or model.tendon_frictionloss.any():
            return f"a joint or a tendon of the MuJoCo model has frictionloss, which that model has not; valid: 0; {remains}"
        if any(model.jnt_limited[joint] and model.jnt_type[joint] < SLIDE for joint in range(model.njnt)):
            return f"a ball joint of the MuJoCo model has limits; valid: limits of hinges, slides and tendons; {remains}"
        return None

    # How it moves.

    def control(self, t: float) -> None:
        """Sets `self.data.ctrl` for a step of the engine that starts at `t` (s); does nothing unless a subclass says so."""

    def _see(self) -> None:
        """Brings positions, velocities and contacts to the present state, and takes the interface from it."""
        _engine().mj_step1(self.model, self.data)
        if self._turns:
            rows = [row(self.data) for row in self._interface]
            self._rows = np.array([jacobian for _, jacobian in rows])
            positions, self._speeds = [float(position) for position, _ in rows], self._rows @ self.data.qvel
        else:
            places, dofs, levers = self._joints
            data = self.data
            positions, self._speeds = (levers * data.qpos[places]).tolist(), levers * data.qvel[dofs]
        self._outputs = (*positions, *self._speeds.tolist())

    def outputs(self, u: Sequence[float]) -> Sequence[float]:
        return self._outputs

    def _check_delays(self, step: float) -> None:
        """Refuses a step in which what the engine keeps of a delay, a number of samples, one per step, is less than the delay."""
        for kind in ("actuator", "sensor"):
            # Before MuJoCo 4 there are none.
            delays = getattr(self.model, f"{kind}_delay", ())
            for at, delay in enumerate(delays):
                room = int(getattr(self.model, f"{kind}_history")[at][0])
                every = max(step, float(self.model.sensor_interval[at][0])) if kind == "sensor" else step
                if delay > 0.0 and room * every < delay * (1 - 1e-9):
                    raise RimbenchError(
                        f"{kind} `{getattr(self.model, kind)(at).name or at}` of the MuJoCo model has a delay of {delay} s and nsample = {room}, which "
                        f"hold {room * every:.3g} s at a step of {step} s: the reference takes shorter steps than the model's {self._timestep} s; "
                        f"valid: nsample of {math.ceil(delay / every * (1 - 1e-9))} and more"
                    )

    def _steps_in(self, h: float) -> int:
        return max(1, math.ceil(h / self._timestep * (1 - 1e-9)))

    def _take_steps_of(self, step: float) -> None:
        """Sets the engine's step (s), on which its constraints depend."""
        # Copies share the model.
        self.model.opt.timestep = step
        if self._begun != step:
            self._begun = step
            self._check_delays(step)
            self._see()

    def step(self, t: float, u: Sequence[float], h: float) -> Sequence[float]:
        engine, model, data = _engine(), self.model, self.data
        count, force = self._steps_in(h), np.asarray(u)
        for index in range(count):
            self._take_steps_of(h / count)
            self.control(t + index * h / count)
            before = self._speeds
            # What a subclass has applied is its own.
            own = data.qfrc_applied.copy()
            data.qfrc_applied += force.dot(self._rows)
            engine.mj_step2(model, data)
            data.qfrc_applied[:] = own
            self._see()
            self._work += 0.5 * h / count * float(force.dot(before + self._speeds))
        bad = (engine.mjtWarning.mjWARN_BADQPOS, engine.mjtWarning.mjWARN_BADQVEL, engine.mjtWarning.mjWARN_BADQACC)
        for warning in bad if data.warning.number.any() else ():
            if data.warning[warning].number:
                what = {"QPOS": "positions", "QVEL": "velocities", "QACC": "accelerations"}[warning.name[-4:]]
                raise ArithmeticError(f"MuJoCo: {what} are no numbers any more, or beyond 1e10")
        return self._outputs

    def interface_work(self) -> float:
        """Work received through the interface since the start, J."""
        return self._work

    # Copies, and the exact model.

    #: What copies share: what does not change after it is made, and room for what is not kept.
    _SHARED = frozenset(
        "model _interface _pairs _limits _rows _joints _speeds _outputs _wide _spare _kept _engine_rows interface_model".split()
    )

    def __deepcopy__(self, memo: dict[int, Any]) -> Mechanics:
        engine = _engine()
        fresh = type(self).__new__(type(self))
        memo[id(self)] = fresh
        # To make one takes as long as tens of steps.
        try:
            fresh.data = self._spare.pop()
        except IndexError:
            fresh.data = engine.MjData(self.model)
        # The rows ask the side for Jacobians of the data that they are given, and for nothing else.
        for name, value in self.__dict__.items():
            if name in self._SHARED or type(value) in (bool, int, float, str):
                fresh.__dict__[name] = value
            elif name != "data":
                fresh.__dict__[name] = copy.deepcopy(value, memo)
        engine.mj_copyData(fresh.data, self.model, self.data)
        return fresh

    def __del__(self) -> None:
        if "_spare" in self.__dict__ and "data" in self.__dict__:
            self._spare.append(self.data)

    def _all_rows(self, data: Any) -> tuple[Numbers, Numbers, list[Any]]:
        """Gaps, Jacobians of contacts and interface, and what each row stands for."""
        engine, model = _engine(), self.model
        gaps, rows = np.full(self.contacts, FAR), np.zeros((self.contacts + len(self._interface), model.nv))
        marks: list[Any] = [None] * self.contacts
        first = dict(zip(self._pairs, np.cumsum([0, *self._pairs.values()])))
        found: dict[tuple[int, int], list[Any]] = {pair: [] for pair in self._pairs}
        for contact in data.contact:
            pair = min(contact.geom1, contact.geom2), max(contact.geom1, contact.geom2)
            if pair in found:
                found[pair].append(contact)
            elif contact.dist < 0.0:
                names = " and ".join(f"`{model.geom(geom).name or geom}`" for geom in pair)
                raise RimbenchError(f"geoms {names} of the MuJoCo model touch, and contacts does not list them")
        for pair, touching in found.items():
            near = [contact for contact in touching if contact.dist < self._reach]
            near = sorted(near, key=lambda contact: float(contact.dist))[: self._pairs[pair]] if len(near) > self._pairs[pair] else near
            for row, contact in enumerate(near, first[pair]):
                ends = np.zeros((2, 3, model.nv))
                for end, geom in zip(ends, (contact.geom1, contact.geom2)):
                    engine.mj_jac(model, data, end, None, contact.pos, model.geom_bodyid[geom])
                gaps[row], rows[row], marks[row] = contact.dist, contact.frame[:3] @ (ends[1] - ends[0]), (pair, len(near))
        for row, (sign, bound, at, of_tendon) in enumerate(self._limits, self.contacts - len(self._limits)):
            if of_tendon:
                gaps[row], rows[row] = sign * (data.ten_length[at] - bound), sign * self._tendons(data)[at]
            else:
                gaps[row] = sign * (data.qpos[model.jnt_qposadr[at]] - bound)
                rows[row, model.jnt_dofadr[at]] = sign
        rows[self.contacts :] = [row(data)[1] for row in self._interface]
        return gaps, rows, marks

    def _equalities(self, data: Any) -> Numbers:
        engine, model = _engine(), self.model
        sparse = (data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind) if engine.mj_isSparse(model) else None
        rows: Numbers = _dense(data.efc_J, model.nv, sparse)[data.efc_type == self._equality]
        return rows

    def interface_model(self, h: float) -> dict[str, Any]:
        """The exact model: H, free accelerations, velocities and gaps from the engine, of its rows or of rigid contacts."""
        if self._by_engine:
            return self._of_rows(h)
        engine, model = _engine(), self.model
        if not self._wide:
            self._wide.append(engine.MjData(model))
        kept = model.geom_margin.copy(), model.pair_margin.copy(), model.opt.disableflags
        model.geom_margin[:] = self._reach
        model.pair_margin[:] = self._reach
        # Bounding volumes know nothing of margins.
        model.opt.disableflags |= engine.mjtDisableBit.mjDSBL_MIDPHASE
        try:
            return self._exact(model, self._wide[0])
        finally:
            model.geom_margin[:], model.pair_margin[:], model.opt.disableflags = kept

    def _exact(self, wide: Any, data: Any) -> dict[str, Any]:
        """The exact model of a model whose contacts are within reach, by data of its own."""
        engine = _engine()
        engine.mj_getState(wide, self.data, self._kept, self._whole)
        engine.mj_setState(wide, data, self._kept, self._whole)
        for stage in (engine.mj_fwdPosition, engine.mj_fwdVelocity, engine.mj_fwdActuation, engine.mj_fwdAcceleration):
            stage(wide, data)
        gaps, rows, marks = self._all_rows(data)
        joints, free, velocity = self._equalities(data), data.qacc_smooth.copy(), data.qvel.copy()
        mass = np.zeros((wide.nv, wide.nv))
        try:
            engine.mj_fullM(wide, data, mass)
        except TypeError:  # before MuJoCo 4
            engine.mj_fullM(wide, mass, data.qM)
        # Rows turn while nothing pushes.
        start, turned = data.qpos.copy(), []
        for ahead in (AHEAD, -AHEAD):
            data.qpos[:] = start
            engine.mj_integratePos(wide, data.qpos, velocity, ahead)
            engine.mj_fwdPosition(wide, data)
            _, at, same = self._all_rows(data)
            known = np.array([a == b for a, b in zip(marks, same)] + [True] * len(self._interface))
            turned.append((np.where(known[:, None], at, np.nan), self._equalities(data)))
        bend, bend_of_joints = (
            (one - other) @ velocity / (2 * AHEAD) for one, other in zip(*turned)
        )
        bend = np.nan_to_num(bend)
        answers = np.linalg.solve(mass, np.vstack([rows, joints]).T)
        answers, of_joints = answers[:, : len(rows)], answers[:, len(rows) :]
        if len(joints):
            held = np.linalg.pinv(joints @ of_joints, rcond=1e-10, hermitian=True)
            free = free - of_joints @ held @ (joints @ free + bend_of_joints)
            answers = answers - of_joints @ held @ (joints @ answers)
        return {
            "H": rows @ answers, "a": rows @ free + bend, "w": rows @ velocity, "gap": gaps,
            "position": self._outputs[: len(self._interface)],
        }

    def _damps(self) -> bool:
        """Makes the factors of the metric M_h = M + h D of damping that the engine's integrator takes implicitly; whether there is any."""
        engine, model, data = _engine(), self.model, self.data
        if euler := int(model.opt.integrator) == self._euler:
            if model.opt.disableflags & self._undamped or not model.dof_damping.any():
                return False
        # It moves positions and velocities and nothing that depends on them.
        engine.mj_getState(model, data, self._kept, self._whole)
        (engine.mj_Euler if euler else engine.mj_implicit)(model, data)
        engine.mj_setState(model, data, self._kept, self._whole)
        return euler or bool(data.qDeriv.any())

    def _of_rows(self, h: float) -> dict[str, Any]:
        """The engine's constraint rows over its own steps in h, and the interface.

        M a = τ + J' f with J a - aref + R f >= 0 complementary to f >= 0, then M_h v+ = M_h v + h M a with the metric M_h = M + h D of the
        integrator. Equality rows are springs that always push, and are eliminated.
        """
        engine, model, data = _engine(), self.model, self.data
        steps = self._steps_in(h)
        self._take_steps_of(h / steps)
        engine.mj_fwdActuation(model, data)
        engine.mj_fwdAcceleration(model, data)
        damped = self._damps()
        told: dict[str, Any] = self._engine_rows.of(data, self._rows, self._speeds, bool(engine.mj_isSparse(model)), damped)
        if self._turns:
            told["a"][len(told["gap"]) :] += self._turning()
        told.update(position=self._outputs[: len(self._interface)], steps=steps, symmetric=not damped)
        return told

    def _turning(self) -> Numbers:
        """Accelerations of the interface because its rows turn, m/s²."""
        engine, model = _engine(), self.model
        if not self._wide:
            self._wide.append(engine.MjData(model))
        data, turned = self._wide[0], []
        for ahead in (AHEAD, -AHEAD):
            data.qpos[:] = self.data.qpos
            engine.mj_integratePos(model, data.qpos, self.data.qvel, ahead)
            for stage in (engine.mj_kinematics, engine.mj_comPos, engine.mj_tendon):
                stage(model, data)
            turned.append(np.array([row(data)[1] for row in self._interface]))
        return np.asarray((turned[0] - turned[1]) @ self.data.qvel / (2 * AHEAD))

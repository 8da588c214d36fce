"""Servos outside MuJoCo that stay stable at its steps: one more forward call gives the torque that holds at the end of the step.

The law τ = K (target - q⁺) - D v⁺ is meant at the end of the engine's step of h, where q⁺ = q + h v⁺ and v⁺ = v + h a. It is affine in a:
τ = τ₀ - (h D + h² K) a. So the engine's own step, contacts, friction, limits and equalities included, is that of a model with inertia
M + h D + h² K under the torque τ₀, and one forward call with that armature answers it. A torque limit makes a row of the law a constant.
Needs NumPy and MuJoCo 3.3 or newer, and nothing else: this file may be copied (MIT licence, docs/guide/servo.md of rimbench).

    step = ServoStep(model, dofs)
    data.qfrc_applied[dofs] = step.torque(data, K, D, target, limit)
    mujoco.mj_step(model, data)
"""

from __future__ import annotations

import warnings
from typing import Any

import mujoco
import numpy as np

__all__ = ["ServoStep"]

SLIDE, UNDAMPED = int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
ZERO = np.zeros(1)
EULER, RK4, IMPLICIT, FAST = range(4)
INTEGRATORS = {RK4: "RK4 evaluates forces four times a step", IMPLICIT: "implicit takes derivatives of Coriolis forces after the contacts"}
WHY = {"SLEEP": "holds bodies still", "DIAGEXACT": "weighs contacts by the inertia", "IPC": "moves positions after the solve"}
FLAGS = {int(getattr(mujoco.mjtEnableBit, f"mjENBL_{name}", 0)): f"flag {name.lower()} {why}" for name, why in WHY.items()}


class ServoStep:
    """Torques of all servos of a model, from the engine's own answer over its next step.

    Parameters
    ----------
    model : the `MjModel`, asked as it is at each call, and changed only during a call: threads need a copy each.
    dofs : degrees of freedom of the servos, each of a hinge or a slide (`model.joint(name).dofadr[0]`), shape (n,).
    """

    def __init__(self, model: Any, dofs: Any) -> None:
        found = np.atleast_1d(np.asarray(dofs))
        if found.ndim != 1 or not found.size or found.dtype.kind not in "iu":
            raise ValueError(f"dofs = {dofs!r} is not valid; valid: a list of integers, one per servo")
        joints, numbers = model.jnt_type[model.dof_jntid], found.tolist()
        for dof in numbers:
            if not 0 <= dof < model.nv or joints[dof] < SLIDE or numbers.count(dof) > 1:
                valid = np.flatnonzero(joints >= SLIDE).tolist()
                raise ValueError(f"dofs: {dof} is not valid; valid: each once, of hinges and slides: {valid}")
        self.model, self.dofs, self.data = model, found.copy(), mujoco.MjData(model)
        self.solves = 0  #: forward calls and steps of the engine made so far
        self._positions = model.jnt_qposadr[model.dof_jntid[found]]
        self._kind = mujoco.mjtState.mjSTATE_INTEGRATION
        self._state = np.zeros(mujoco.mj_stateSize(model, self._kind))
        self._last: Any = None  # data, forces of others, torque, law
        self._given: list[set[bytes]] = [set(), set()]
        self._busy = False

    def torque(self, data: Any, K: Any, D: Any, target: Any, limit: Any = np.inf, again: int = 0) -> Any:
        """The torque clip(K (target - q⁺) - D v⁺, -limit, limit) at the end of the next step, to be held over it, N m or N, shape (n,).

        K (N m/rad or N/m), D (N m s/rad or N s/m), target (rad or m) and limit are numbers or arrays of shape (n,); `data` stays as it is.
        What `qfrc_applied` holds besides the last torque, and `ctrl`, act over the step as well. Joint damping that the engine integrates
        after its contacts leaves an error in their forces: `again` compares with its own step that often, two calls each time.
        Raises `ValueError` for what is not valid, and for a model without such an answer.
        """
        model, i, h = self.model, self.dofs, self.model.opt.timestep
        if self._busy:  # a callback of the engine, within a call of ours
            return data.qfrc_applied[i].copy()
        if data.qpos.size != model.nq or data.qvel.size != model.nv:
            raise ValueError(f"data has {data.qvel.size} degrees of freedom, and the model {model.nv}")
        if not (np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()):
            raise ValueError(f"data: positions or velocities at {data.time} s are not finite")
        K, D, target, limit = law = self._checked(again, K=K, D=D, target=target, limit=limit)
        q, v = data.qpos[self._positions], data.qvel[i].copy()
        slope, tau_0 = h * D + h * h * K, K * (target - q - h * v) - D * v
        others, offset = self._others(data), np.zeros(i.size)
        mujoco.mj_getState(model, data, self._state, self._kind)
        for turn in range(again + 1):
            mujoco.mj_setState(model, self.data, self._state, self._kind)
            tau = self._within(limit, tau_0 - slope * offset, slope, others)
            if turn < again:  # how far the engine's own step under that torque is off
                answer = self.data.qacc[i].copy()
                mujoco.mj_setState(model, self.data, self._state, self._kind)
                self._ask(others + tau)
                offset = (self.data.qvel[i] - v) / h - answer
        exact = not (model.dof_damping.any() or data.xfrc_applied.any() or getattr(model, "tendon_armature", ZERO).any())
        if exact and not getattr(model, "actuator_armature", ZERO).any():  # what moves it so, in digits that τ₀ - slope a has not
            force = np.zeros(model.nv)
            mujoco.mj_rne(model, self.data, 1, force)
            force += model.dof_armature * self.data.qacc - self.data.qfrc_passive - self.data.qfrc_actuator - self.data.qfrc_constraint
            tau = np.where(np.abs(tau) < limit, np.clip(force[i] - others, -limit, limit), tau)
        self._last = data, others, tau.copy(), law
        if len(self._given[0]) > 10_000:
            self._given = [set(), self._given[0]]
        self._given[0].add(tau.tobytes())
        return tau

    def miss(self, data: Any) -> float:
        """Largest difference of the last torque and the law at the state of `data`, N m or N: after the step, how well it was met."""
        _, _, tau, (K, D, target, limit) = self._last
        law = K * (target - data.qpos[self._positions]) - D * data.qvel[self.dofs]
        return float(np.abs(np.clip(law, -limit, limit) - tau).max())

    def _others(self, data: Any) -> Any:
        """What `qfrc_applied` holds without the last torque: that may be there as it was, or with what was added before the step."""
        held = data.qfrc_applied[self.dofs].copy()
        if any(held.tobytes() in given for given in self._given):  # of an earlier state that came back, too
            return np.zeros(held.size)
        if self._last is None or self._last[0] is not data:
            return held
        _, before, tau, _ = self._last
        during = (self.data.qfrc_applied + data.qfrc_smooth - self.data.qfrc_smooth)[self.dofs]  # what the step was made with
        missed = self.miss(data) > 1e-6 * np.abs(held - tau - before).max()  # if that was not what the law knew of
        if np.allclose(held, before + tau, 1e-12, 0.0) or missed and np.allclose(held, during, 1e-9, 1e-9):
            return held - tau
        return np.where(held == tau, 0.0, held)

    def _within(self, limit: Any, tau_0: Any, slope: Any, others: Any) -> Any:
        """The torque that is the law τ₀ - slope a within its limits, by pivoting over `at`: 0 or the sign of the limit a row is at."""

        def sides(torque: Any) -> Any:
            return np.where(np.abs(torque) > limit, np.sign(torque), 0.0)

        def wish() -> Any:
            self._ask(others + np.where(at == 0.0, tau_0, np.copysign(limit, at)), np.where(at == 0.0, slope, 0.0))
            return tau_0 - slope * self.data.qacc[self.dofs]

        at = sides(tau_0 - slope * self.data.qacc_warmstart[self.dofs])
        for _ in range(8):  # all rows at once: nearly always done in two or three calls, but sets may come back
            tau, before = wish(), at
            at = sides(tau)
            if (at == before).all():
                return np.clip(tau, -limit, limit)
        # Row by row: the torque minimises a convex function in a box, which falls with each set of free rows. None comes back.
        tau = np.clip(tau, -limit, limit)
        for _ in range(100 + 10 * at.size):
            wanted, share, inward = wish(), np.full(at.size, np.inf), np.zeros(at.size)
            over, fixed = (at == 0.0) & (np.abs(wanted) > limit), at != 0.0
            share[over] = ((np.copysign(limit, wanted) - tau)[over]) / (wanted - tau)[over]
            inward[fixed] = (limit - at * wanted)[fixed]
            reached = min(share.min(), 1.0)  # of the way to what is wanted, until a row comes to its limit
            at = np.where(over & (share == reached), np.sign(wanted), at)
            tau = np.where(at == 0.0, tau + reached * (wanted - tau), np.copysign(limit, at))
            if not over.any():
                if inward.max() <= 1e-9 * limit[inward.argmax()]:
                    return tau
                at[inward.argmax()] = 0.0
        warnings.warn(f"rows at their torque limit were not found at {self.data.time} s; the torque misses the law", stacklevel=3)
        return tau

    def _ask(self, force: Any, slope: Any = None) -> None:
        """The engine's accelerations under the law of these slopes; without them, its own step."""
        model, self._busy, self.solves = self.model, True, self.solves + 1
        armature, simple = model.dof_armature.copy(), model.dof_M0.copy()
        self.data.qfrc_applied[self.dofs] = force
        try:
            if slope is None:
                return mujoco.mj_step(model, self.data)
            kind, option = model.opt.integrator, model.opt
            after = kind == FAST or kind == EULER and not option.disableflags & UNDAMPED
            more = option.timestep * model.dof_damping * after
            more[self.dofs] += slope
            model.dof_armature += more
            model.dof_M0 += more  # all the inertia of bodies that the engine calls simple
            mujoco.mj_forwardSkip(model, self.data, 0, 1)
        finally:
            model.dof_armature[:], model.dof_M0[:], self._busy = armature, simple, False

    def _checked(self, again: Any, **law: Any) -> list[Any]:
        """The law as arrays; or what of it, or of the model, is not valid."""
        option = self.model.opt
        found = [INTEGRATORS[option.integrator]] if option.integrator in INTEGRATORS else []
        found += [why for flag, why in FLAGS.items() if option.enableflags & flag]
        found += ["noslip changes friction after the solve"] * (option.noslip_iterations > 0)
        if found or not isinstance(again, int) or again < 0:
            what = f"the model has no such torque, {'; '.join(found)}" if found else f"again = {again!r} is not valid"
            raise ValueError(f"{what}; valid: {'Euler, implicitfast, discrete without these' if found else '0, 1, 2, ...'}")
        for name, value in law.items():
            try:
                law[name] = array = np.broadcast_to(np.asarray(value, float), self.dofs.shape).copy()
            except (TypeError, ValueError):
                array = np.array(np.nan)
            if np.isnan(array).any() or name != "limit" and np.isinf(array).any() or name != "target" and (array < 0).any():
                kind = {"target": "finite", "limit": "from 0 to infinity"}.get(name, "finite and not below 0")
                raise ValueError(f"{name} = {value!r} is not valid; valid: a number or an array of shape {self.dofs.shape}, {kind}")
        return list(law.values())


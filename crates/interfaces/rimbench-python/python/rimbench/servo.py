"""Servos outside MuJoCo that stay stable at its steps: one more forward call gives the torque that holds at the end of the step.

The law τ = K (target - q⁺) - D v⁺ is meant at the end of the engine's step of h, where q⁺ = q + h v⁺ and v⁺ = v + h a. It is affine in a:
τ = τ₀ - (h D + h² K) a. So the engine's own step, contacts, friction, limits and equalities included, is that of a model with inertia
M + h D + h² K under the torque τ₀, and one forward call answers it. This file works alone, with NumPy and MuJoCo from 3.3 on (MIT licence).

    step = ServoStep(model, dofs)
    data.qfrc_applied[dofs] = step.torque(data, K, D, target, limit)
    mujoco.mj_step(model, data)
"""

from __future__ import annotations

import warnings
from typing import Any

import mujoco
import numpy as np

STATE, (EULER, RK4, IMPLICIT, FAST) = mujoco.mjtState.mjSTATE_INTEGRATION, range(4)
SLIDE, UNDAMPED = int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
LOW, HIGH = np.array([[0.0], [0.0], [-1e300], [0.0]]), np.array([[1e300], [1e300], [1e300], [np.inf]])  # of K, D, target, limit
WHY = {"SLEEP": "holds bodies still", "DIAGEXACT": "weighs contacts by the inertia", "IPC": "moves positions after the solve"}
FLAGS = {int(getattr(mujoco.mjtEnableBit, f"mjENBL_{name}", 0)): f"{name} {why}" for name, why in WHY.items()}
INTEGRATORS = {RK4: "RK4 evaluates forces four times a step", IMPLICIT: "implicit takes derivatives of Coriolis forces after contacts"}


class ServoStep:
    """Torques of all servos of a model at `dofs`, n degrees of freedom of hinges and slides (`model.joint(name).dofadr[0]`).

    The `MjModel` is asked as it is at each call, and its inertia is another one during a call: threads need a copy each.
    """

    def __init__(self, model: Any, dofs: Any) -> None:
        self.model, self.dofs, self.data = model, np.array(dofs, ndmin=1), mujoco.MjData(model)
        joints, right = np.flatnonzero(model.jnt_type[model.dof_jntid] >= SLIDE), self.dofs.ndim == 1 and self.dofs.dtype.kind in "iu"
        if not right or not np.isin(self.dofs, joints).all() or not 0 < self.dofs.size == np.unique(self.dofs).size:
            raise ValueError(f"dofs = {dofs!r} is not valid; valid: degrees of freedom of hinges and slides, each once: {joints.tolist()}")
        self._positions, self.solves = model.jnt_qposadr[model.dof_jntid[self.dofs]], 0  # solves: calls of the engine so far
        self._state, self._busy = np.zeros(mujoco.mj_stateSize(model, STATE)), False  # busy within a call of the engine
        self._last: Any = ()  # data, forces of others, torque, law
        self._given: list[set[bytes]] = [set(), set()]

    def torque(self, data: Any, K: Any, D: Any, target: Any, limit: Any = np.inf, again: int = 0) -> Any:
        """The torque clip(K (target - q⁺) - D v⁺, -limit, limit) at the end of the next step, to be held over it, N m or N, shape (n,).

        K (N m/rad or N/m), D (N m s/rad or N s/m), target (rad or m) and limit are numbers or arrays of shape (n,); `data` stays as it is.
        Forces in `qfrc_applied` besides the last torque act over the step as well. Joint damping that the engine integrates after contacts
        leaves an error: `again` compares with its own step so often, two calls each. Raises `ValueError` for what has no such torque.
        """
        model, i, h = self.model, self.dofs, self.model.opt.timestep
        if self._busy:
            return data.qfrc_applied[i].copy()  # to a callback of the engine
        if data.qpos.size != model.nq or data.qvel.size != model.nv or not np.isfinite(data.qpos.sum() + data.qvel.sum()):
            raise ValueError(f"data is of another model, or not finite at {data.time} s: qpos {data.qpos}, qvel {data.qvel}")
        K, D, target, limit = law = self._checked(K=K, D=D, target=target, limit=limit)
        q, v, others, offset = data.qpos[self._positions], data.qvel[i], self._others(data), np.zeros(i.size)
        slope, tau_0 = h * D + h * h * K, K * (target - q - h * v) - D * v
        mujoco.mj_getState(model, data, self._state, STATE)
        for turn in range(again + 1):
            mujoco.mj_setState(model, self.data, self._state, STATE)
            tau = self._within(limit, tau_0 - slope * offset, slope, others)
            if turn < again:  # how far the engine's own step under that torque is off
                offset = -self.data.qacc[i]
                mujoco.mj_setState(model, self.data, self._state, STATE)
                self._ask(others + tau)
                offset += (self.data.qvel[i] - v) / h
        force = np.zeros(model.nv)  # that moves it so: where it is the law, in digits that τ₀ - slope a has not
        mujoco.mj_rne(model, self.data, 1, force)
        force += model.dof_armature * self.data.qacc - self.data.qfrc_passive - self.data.qfrc_actuator - self.data.qfrc_constraint
        same = np.abs(force[i] - others - tau) < 1e-11 * (1.0 + np.abs(tau_0))
        tau = np.where(same & (np.abs(tau) < limit), np.minimum(np.maximum(force[i] - others, -limit), limit), tau)
        self._last = data, others, tau.copy(), law
        self._given = [set(), self._given[0]] if len(self._given[0]) > 10_000 else self._given
        self._given[0].add(tau.tobytes())
        return tau

    def miss(self, data: Any) -> float:
        """Largest difference of the last torque and the law at the state of `data`, N m or N: after the step, how well it was met."""
        tau, (K, D, target, limit) = self._last[2:]
        return float(np.abs(np.clip(K * (target - data.qpos[self._positions]) - D * data.qvel[self.dofs], -limit, limit) - tau).max())

    def _others(self, data: Any) -> Any:
        """What `qfrc_applied` holds without the last torque: that may be there as it was, or with what was added before the step."""
        held = data.qfrc_applied[self.dofs]
        ours = any(held.tobytes() in given for given in self._given)  # of an earlier state that came back, too
        if ours or not self._last or self._last[0] is not data:
            return held * (not ours)
        before, tau = self._last[1:3]
        during = (self.data.qfrc_applied + data.qfrc_smooth - self.data.qfrc_smooth)[self.dofs]  # what the step was made with
        missed = self.miss(data) > 1e-6 * np.abs(held - tau - before).max()  # if that was not what the law knew of
        added = missed and (np.abs(held - during) <= 1e-9 * (1.0 + np.abs(held))).all()
        added |= (np.abs(held - before - tau) <= 1e-12 * np.abs(held)).all()
        return held - tau if added else np.where(held == tau, 0.0, held)

    def _within(self, limit: Any, tau_0: Any, slope: Any, others: Any) -> Any:
        """The torque that is the law τ₀ - slope a within its limits, by pivoting over `at`: 0 or the sign of the limit a row is at."""
        def wish() -> Any:
            self._ask(others + np.where(at == 0.0, tau_0, np.copysign(limit, at)), np.where(at == 0.0, slope, 0.0))
            return tau_0 - slope * self.data.qacc[self.dofs]

        at = np.sign(tau := tau_0 - slope * self.data.qacc_warmstart[self.dofs]) * (np.abs(tau) > limit)
        for _ in range(5):  # all rows at once: nearly always done in two or three calls, but sets may come back
            wanted, before = wish(), at
            at, tau = np.sign(wanted) * (np.abs(wanted) > limit), np.minimum(np.maximum(wanted, -limit), limit)
            if (at == before).all():
                return tau
        # Row by row: the torque minimises a convex function in a box, which falls with each set of free rows. None comes back.
        for _ in range(100 + 10 * at.size):
            wanted, share = wish(), np.ones(at.size)  # of the way to what is wanted, until a row comes to its limit
            over, inward = (at == 0.0) & (np.abs(wanted) > limit), np.where(at == 0.0, 0.0, limit - at * wanted)
            np.divide(np.copysign(limit, wanted) - tau, wanted - tau, out=share, where=over)
            at = np.where(over & (share == share.min()), np.sign(wanted), at)
            tau = np.where(at == 0.0, tau + share.min() * (wanted - tau), np.copysign(limit, at))
            if not over.any() and inward.max() <= 1e-9 * limit[inward.argmax()]:
                return tau
            at[inward.argmax()] *= over.any()
        warnings.warn(f"rows at their torque limit were not found at {self.data.time} s; the torque misses the law", stacklevel=3)
        return tau

    def _ask(self, force: Any, slope: Any = None) -> None:
        """The engine's accelerations under the law of these slopes; without them, its own step."""
        model, self._busy, self.solves, self.data.qfrc_applied[self.dofs] = self.model, True, self.solves + 1, force
        armature, simple = model.dof_armature.copy(), model.dof_M0.copy()
        try:
            if slope is not None:
                after = model.opt.integrator == FAST or model.opt.integrator == EULER and not model.opt.disableflags & UNDAMPED
                more = model.opt.timestep * model.dof_damping * after
                more[self.dofs] += slope
                model.dof_armature[:], model.dof_M0[:] = armature + more, simple + more  # M0: of bodies that the engine calls simple
            mujoco.mj_step(model, self.data) if slope is None else mujoco.mj_forwardSkip(model, self.data, 0, 1)
        finally:
            model.dof_armature[:], model.dof_M0[:], self._busy = armature, simple, False

    def _checked(self, **law: Any) -> Any:
        """The law as arrays; or what of it, or of the model, is not valid."""
        option = self.model.opt
        found = [INTEGRATORS.get(option.integrator, ""), "noslip changes friction after the solve" * (option.noslip_iterations > 0)]
        found += [why for flag, why in FLAGS.items() if option.enableflags & flag]
        if why := "; ".join(filter(None, found)):
            raise ValueError(f"the model's step has no such torque: {why}; valid: Euler, implicitfast, discrete, without these")
        rows = np.full((4, self.dofs.size), np.nan)
        for row, value in zip(rows, law.values()):
            if np.shape(value) in ((), (1,), self.dofs.shape):
                row[:] = value
        if not (good := (rows >= LOW) & (rows <= HIGH)).all():
            name, value = list(law.items())[int(good.all(axis=1).argmin())]
            kind = {"target": "finite", "limit": "from 0 to infinity"}.get(name, "finite and not below 0")
            raise ValueError(f"{name} = {value!r} is not valid; valid: a number or an array of shape {self.dofs.shape}, {kind}")
        return rows

"""The sides of the studies of servos: a machine in MuJoCo, and servos outside of it, one for each hinge.

The quadruped is that of the examples of rimbench-python. The humanoid is google-deepmind/mujoco, model/humanoid/humanoid.xml, which is
not in this tree: it is read from `mujoco/humanoid.xml` in the folder of the data of others.
"""

import itertools
import os
import sys
from pathlib import Path

import mujoco
import numpy as np
from rimbench.mujoco import Mechanics

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "crates/interfaces/rimbench-python/examples"))
import quadruped

#: The longest macro step of the studies, s: each is one step of the engine.
LONGEST = 0.02
#: Half of the time between two targets whose difference is the rate of one, s.
AHEAD = 1e-4


def of_quadruped(parameters):
    """Model and first pose of the hinges."""
    return quadruped.robot(int(parameters["feet_condim"])), quadruped.STAND


def of_humanoid(parameters):
    text = Path(os.environ.get("RIMBENCH_DATA_OF_OTHERS", ""), "mujoco/humanoid.xml").read_text(encoding="utf-8")
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.iterations, model.opt.tolerance = 200, 1e-12
    return model, model.qpos0[7:].copy()


class Robot(Mechanics):
    """The machine; all hinges are rows of the interface."""

    def __init__(self, model, pose):
        model.opt.timestep, model.opt.integrator = LONGEST, int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
        hinges = [model.joint(at).name for at in range(1, model.njnt)]
        super().__init__(model, [("joint", name) for name in hinges])
        # Shorter macro steps are shorter steps of the engine: what is asked here.
        self.model_from_s = 0.0
        self.made_from += f", MuJoCo {mujoco.__version__}"
        self.data.qpos[7:] = pose
        self._see()


class Servos:
    """τ = kp (target - q) - kd v at the beginning of each of its own steps; kd is critical for the inertia of the hinge alone."""

    direct_feedthrough = True
    takes_arrays = True

    def __init__(self, parameters, model, pose):
        data = mujoco.MjData(model)
        data.qpos[7:] = pose
        mujoco.mj_forward(model, data)
        self.kp, self.t = parameters["kp_n_m_rad"], 0.0
        self.kd = 2.0 * np.sqrt(self.kp * quadruped.inertia(model, data))

    def outputs(self, u):
        q, v = u.reshape(2, -1)
        return self.kp * (self.target(self.t) - q) - self.kd * v

    def step(self, t, u, h):
        self.t = t + h

    def output_rates(self, t, u):
        rate = (self.target(t + AHEAD) - self.target(t - AHEAD)) / (2.0 * AHEAD)
        return {"rate": self.kp * rate, "feedthrough": -np.hstack([self.kp * np.eye(len(rate)), np.diag(self.kd)])}


class Quadruped(Robot):
    def __init__(self, parameters):
        super().__init__(*of_quadruped(parameters))


class QuadrupedServos(Servos):
    """Legs lift in pairs, to half and to full height, at 1 and 2 Hz."""

    def __init__(self, parameters):
        super().__init__(parameters, *of_quadruped(parameters))
        self.motion = list(itertools.product((0.5, 1.0), (1.0, 2.0)))[int(parameters["motion"])]

    def target(self, t):
        return quadruped.target(t, *self.motion)


class Humanoid(Robot):
    def __init__(self, parameters):
        super().__init__(*of_humanoid(parameters))


class HumanoidServos(Servos):
    """It squats, by 0.2 and 0.35 of the pose in its file, at 0.5 to 1.4 Hz."""

    def __init__(self, parameters):
        model, self.pose = of_humanoid(parameters)
        super().__init__(parameters, model, self.pose)
        self.squat = model.key_qpos[0, 7:] - self.pose
        self.motion = list(itertools.product((0.2, 0.35), (0.5, 0.8, 1.1, 1.4)))[int(parameters["motion"])]

    def target(self, t):
        size, frequency = self.motion
        return self.pose + 0.5 * size * (1.0 - np.cos(2.0 * np.pi * frequency * t)) * self.squat

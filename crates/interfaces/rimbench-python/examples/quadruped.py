"""A quadruped with twelve servos of its own outside MuJoCo, beside the explicit law and the engine's own servos: the table of
docs/guide/servo.md. Usage: python quadruped.py results/perf/servo.csv; without a file it runs one motion.

Errors are those of joint angles at multiples of 20 ms, against the explicit law at steps of 0.05 ms, rms over joints and 1 s, medians of
four motions in which legs lift in pairs. A cost is a ratio of processor times to `mj_step` in the same process, in turns.
"""

import csv
import statistics
import sys
import time

import numpy as np

try:
    import mujoco

    from rimbench.servo import ServoStep
except ImportError:
    print("skipped: the package `mujoco` is not there")
    sys.exit(0)

LEG = """<body name="hip_{name}" pos="{x} {y} 0"><joint name="side_{name}" axis="1 0 0" range="-40 40"/><geom size=".04" mass=".6"/>
 <body pos="0 {out} 0"><joint name="hip_{name}" axis="0 1 0" range="-100 100"/><geom type="capsule" fromto="0 0 0 0 0 -.22" size=".02" mass=".9"/>
 <body pos="0 0 -.22"><joint name="knee_{name}" axis="0 1 0" range="-150 -10"/><geom type="capsule" fromto="0 0 0 0 0 -.22" size=".015" mass=".2"/>
 <geom pos="0 0 -.22" size=".02" mass=".05" condim="{condim}"/></body></body></body>"""
ROBOT = """<mujoco model="quadruped"><compiler angle="degree" autolimits="true"/><option iterations="200" tolerance="1e-12"/>
 <default><joint armature=".01" damping="{damping}"/><geom friction=".7 .02"/></default><worldbody><geom type="plane" size="0 0 1"/>
 <body name="trunk" pos="0 0 .357"><freejoint/><geom type="box" size=".25 .1 .05" mass="8"/>{legs}</body></worldbody>
 <actuator>{actuators}</actuator></mujoco>"""
LEGS = (("fl", 0.2, 0.12), ("fr", 0.2, -0.12), ("rl", -0.2, 0.12), ("rr", -0.2, -0.12))
STAND, LIFT = np.tile([0.0, 0.7, -1.4], 4), np.tile([0.0, 0.45, -0.9], 4)


def robot(condim=3, damping=0.1, gains=None):
    """The model, of trunk and four legs of three joints; feet of condim 3 or 4; with gains (kp, kv of each joint) servos of the engine."""
    legs = "".join(LEG.format(name=name, x=x, y=y, out=0.05 if y > 0 else -0.05, condim=condim) for name, x, y in LEGS)
    joints = [f"{joint}_{name}" for name, _, _ in LEGS for joint in ("side", "hip", "knee")]
    servos = [] if gains is None else zip(joints, *gains, strict=True)
    actuators = "".join(f'<position joint="{joint}" kp="{kp}" kv="{kv}"/>' for joint, kp, kv in servos)
    return mujoco.MjModel.from_xml_string(ROBOT.format(legs=legs, actuators=actuators, damping=damping))


def begin(model):
    data = mujoco.MjData(model)
    data.qpos[7:] = STAND
    mujoco.mj_forward(model, data)
    return data


def inertia(model, data):
    """Of each joint behind the free one, that of its unit acceleration alone, kg m²."""
    joints = range(6, model.nv)
    moved, unit = np.zeros((model.nv, model.nv)), np.eye(model.nv)
    for joint in joints:
        mujoco.mj_mulM(model, data, moved[joint], unit[joint])
    return np.array([moved[joint, joint] for joint in joints])


def gains(kp):
    """kp for all joints, and the damping that is critical for a joint's inertia."""
    model = robot()
    return np.full(12, kp), 2.0 * np.sqrt(kp * inertia(model, begin(model)))


def target(t, size, frequency):
    swing = np.sin(2.0 * np.pi * frequency * t)
    first = np.repeat([True, False, False, True], 3)
    return STAND + size * np.where(first, max(swing, 0.0), max(-swing, 0.0)) * LIFT


def run(how, kp, h, size, frequency, condim=3, duration=1.0):
    """Joint angles at multiples of 20 ms, rad; `None` if the run diverged."""
    K, D = gains(kp)
    model = robot(condim, gains=(K, D) if how in ("implicitfast", "discrete") else None)
    model.opt.timestep = h
    integrator = "DISCRETE" if how == "discrete" else "IMPLICITFAST"
    model.opt.integrator = int(getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}"))
    data, dofs, angles = begin(model), np.arange(6, 18), []
    step = ServoStep(model, dofs)
    for k in range(round(duration / h)):
        now, wanted = target(k * h, size, frequency), target((k + 1) * h, size, frequency)
        if model.nu:
            data.ctrl[:] = wanted
        elif how == "explicit":
            data.qfrc_applied[dofs] = K * (now - data.qpos[7:]) - D * data.qvel[dofs]
        else:
            data.qfrc_applied[dofs] = step.torque(data, K, D, wanted, again=int(how[-1]))
        mujoco.mj_step(model, data)
        if not np.abs(data.qvel).max() < 300.0 or data.warning.number.any():
            return None
        if (k + 1) % round(0.02 / h) == 0:
            angles.append(data.qpos[7:].copy())
    return np.array(angles)


def cost(how, rounds=15, steps=200):
    """Processor time of a step with its torque over that of `mj_step` of the same motion, medians."""
    model = robot()
    model.opt.timestep, model.opt.integrator = 0.005, int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    dofs, (K, D), times = np.arange(6, 18), gains(1000.0), {True: [], False: []}
    step = ServoStep(model, dofs)
    for _ in range(rounds):
        data, torques = begin(model), []
        for asked in (True, False):
            mujoco.mj_resetData(model, data)
            data.qpos[7:] = STAND
            begun = time.process_time()
            for k in range(steps):
                if asked:
                    torques.append(step.torque(data, K, D, STAND, again=int(how[-1])))
                data.qfrc_applied[dofs] = torques[k]
                mujoco.mj_step(model, data)
            times[asked].append(time.process_time() - begun)
    return statistics.median(times[True]) / statistics.median(times[False])


def main(path):
    hows = ["explicit", "ServoStep, again 0", "ServoStep, again 1", "implicitfast", "discrete"]
    if not hasattr(mujoco.mjtIntegrator, "mjINT_DISCRETE"):
        hows.remove("discrete")
    motions = [(size, frequency) for size in (0.5, 1.0) for frequency in (1.0, 2.0)]
    names = {"implicitfast": "engine's, implicitfast", "discrete": "engine's, discrete"}
    costs = {how: cost(how) for how in hows if how.startswith("Servo")}
    rows = []
    for condim, kp in ((3, 300), (3, 1000), (3, 3000), (4, 1000)):
        references = [run("explicit", kp, 5e-5, *motion, condim=condim) for motion in motions]
        for how in hows:
            row = {"feet": f"condim {condim}", "kp": kp, "servos": names.get(how, how)}
            for h in (0.005, 0.01, 0.02):
                found = [run(how, kp, h, *motion, condim=condim) for motion in motions]
                pairs = [(x, y) for x, y in zip(found, references, strict=True) if y is not None]
                errors = [np.inf if x is None else 1e3 * np.sqrt(np.mean((x - y) ** 2)) for x, y in pairs]
                median = statistics.median(errors)
                row[f"error_{1e3 * h:g}ms_mrad"] = f"{median:.3g}" if np.isfinite(median) else ""
                row[f"diverged_{1e3 * h:g}ms"] = sum(map(np.isinf, errors))
            row |= {"of": len(pairs), "cost": f"{costs[how]:.2f}" if how in costs else ""}
            print(row, flush=True)
            rows.append(row)
    with open(path, "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    if sys.argv[1:]:
        main(sys.argv[1])
    else:
        for how in ("explicit", "ServoStep, again 0"):
            print(f"{how}, kp 1000, 10 ms: {'diverged' if run(how, 1000, 0.01, 1.0, 2.0) is None else 'completed'}")

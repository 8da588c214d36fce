"""An excavator's arm in MuJoCo, its hydraulics here: the bucket is lowered to the ground, lifted, and held by closed valves.

The bucket touches the ground at its teeth. Boom and stick each have a cylinder, a row of the interface, with a valve that is closed in the
middle, valves that limit the pressure and valves that let oil in from the tank. `python excavator.py` tells how far the teeth sink with
valves closed; `python excavator.py arm.svg` draws it.
"""

import math
import sys

import rimbench
from rimbench.mujoco import Mechanics

try:
    import mujoco  # noqa: F401
except ImportError:
    print("skipped: the package `mujoco` is not installed")
    sys.exit()

ARM = """
<mujoco>
  <compiler angle="degree"/>
  <option timestep="1e-3" integrator="implicitfast"/>
  <default><geom condim="1" contype="0" conaffinity="0" density="0" solref="0.004 1"/></default>
  <worldbody>
    <geom name="ground" type="plane" size="9 9 1" contype="1"/>
    <site name="boom pin" pos="0.5 0 0.6"/>
    <body name="boom" pos="0 0 1">
      <joint name="boom" type="hinge" axis="0 -1 0"/>
      <inertial pos="1.4 0 0.2" mass="300" diaginertia="5 200 200"/>
      <site name="boom rod" pos="1.3 0 0.1"/><site name="stick pin" pos="1.5 0 0.5"/>
      <body name="stick" pos="3 0 0">
        <joint name="stick" type="hinge" axis="0 -1 0"/>
        <inertial pos="0.7 0 0" mass="150" diaginertia="2 45 45"/>
        <site name="stick rod" pos="-0.45 0 0.1"/>
        <body name="bucket" pos="1.7 0 0">
          <inertial pos="0.1 0 -0.2" mass="{bucket_mass_kg}" diaginertia="15 15 15"/>
          <geom name="teeth" type="sphere" size="0.05" pos="0.3 0 -0.4" conaffinity="1"/>
        </body>
      </body>
    </body>
  </worldbody>
  <tendon>
    <spatial name="boom"><site site="boom pin"/><site site="boom rod"/></spatial>
    <spatial name="stick"><site site="stick pin"/><site site="stick rod"/></spatial>
  </tendon>
  <keyframe><key name="start" qpos="{boom_rad} {stick_rad}"/></keyframe>
</mujoco>
"""

PARAMETERS = {
    "bucket_mass_kg": 200.0,
    "boom_rad": 0.45,
    "stick_rad": -1.7,
    "area_m2": 5e-3,  # of both sides of a piston
    "volume_m3": 2e-3,  # of oil on either side at the start
    "bulk_modulus_pa": 1.2e9,
    "friction_n_s_m": 2e4,
    "valve_m3_s_pa05": 1e-7,  # flow of the open valve over the root of the pressure it falls by
    "supply_pa": 21e6,
    "limit_pa": 30e6,
    "boom_down_s": 0.5,
    "boom_up_s": 2.0,
    "closed_s": 3.0,
    "ramp_s": 0.3,  # in which a valve opens or closes
}


class Arm(Mechanics):
    observables = ("teeth_z_m", "teeth_x_m", "boom_angle_rad", "stick_angle_rad")

    def __init__(self, parameters):
        super().__init__(
            ARM.format(**parameters), [("tendon", "boom"), ("tendon", "stick")], contacts=[("teeth", "ground")], keyframe="start"
        )

    def observe(self):
        x, _, z = self.data.geom("teeth").xpos
        return z - 0.05, x, *self.data.qpos


def holding(parameters):
    """Lengths of the cylinders at the start, and the forces that hold the arm there."""
    (h11, h12), (_, h22) = (model := Arm(parameters).interface_model(1e-3))["H"][1:, 1:]
    a1, a2 = model["a"][1:]
    forces = (h12 * a2 - h22 * a1) / (h11 * h22 - h12 * h12), (h12 * a1 - h11 * a2) / (h11 * h22 - h12 * h12)
    return model["position"], forces


class Cylinders:
    """Two cylinders: length and velocity in, force out, oil behind each piston and before it."""

    direct_feedthrough = True
    observables = ("boom_behind_pa", "boom_before_pa", "stick_behind_pa", "stick_before_pa")

    def __init__(self, parameters):
        self.p = parameters
        self.start, forces = holding(parameters)
        half = [0.5 * force / parameters["area_m2"] for force in forces]
        self.pressures = [pressure for h in half for pressure in (8e6 + h, 8e6 - h)]

    def opening(self, t):
        """Opening of the boom's valve at time t, above 0 where it lengthens: down to the ground, up again, closed."""
        p, opening = self.p, 0.0
        for at, wanted in ((p["boom_down_s"], -1.0), (p["boom_up_s"], 1.0), (p["closed_s"] - p["ramp_s"], 0.0)):
            opening += (wanted - opening) * min(max((t - at) / p["ramp_s"], 0.0), 1.0)
        return opening

    def outputs(self, u):
        area, friction = self.p["area_m2"], self.p["friction_n_s_m"]
        b1, b2, s1, s2 = self.pressures
        return (b1 - b2) * area - friction * u[2], (s1 - s2) * area - friction * u[3]

    def step(self, t, u, h):
        p = self.p
        area, stiffness = p["area_m2"], h * p["bulk_modulus_pa"]
        opened = self.opening(t), 0.0  # the stick's valve stays closed
        for row in (0, 1):
            behind, before = self.pressures[2 * row : 2 * row + 2]
            moved, speed, kappa = area * (u[row] - self.start[row]), area * u[2 + row], p["valve_m3_s_pa05"] * opened[row]
            fed, drained = (p["supply_pa"], 0.0) if kappa > 0.0 else (0.0, p["supply_pa"])
            into = abs(kappa) * math.copysign(math.sqrt(abs(fed - behind)), fed - behind)
            out = abs(kappa) * math.copysign(math.sqrt(abs(drained - before)), drained - before)
            behind += stiffness / (p["volume_m3"] + moved) * (into - speed)
            before += stiffness / (p["volume_m3"] - moved) * (out + speed)
            self.pressures[2 * row : 2 * row + 2] = (min(max(each, 0.0), p["limit_pa"]) for each in (behind, before))

    def observe(self):
        return self.pressures


excavator = rimbench.Case(
    "excavator", mechanics=Arm, actuator=Cylinders, parameters=PARAMETERS,
    interface=[(f"{name}_length_m", f"{name}_velocity_m_s", f"{name}_force_n") for name in ("boom", "stick")],
    duration_s="14s", macro_step_s="5ms", micro_step_s="0.1ms", reference_step_s="0.4ms",
)


def sunk(run):
    """How far the teeth leave their height in the 10 s that begin 1 s after the valves have closed, m; below 0: they sink."""
    left = run["teeth_z_m"][run["time_s"] >= PARAMETERS["closed_s"] + 1.0]
    return max(left - left[0], key=abs)


def draw(runs, file):
    """The arm at the start, on the ground and held, and the height of the teeth over time."""
    import matplotlib.pyplot as plt

    plt.rcParams.update({"svg.hashsalt": "excavator", "path.simplify_threshold": 0.5})
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), width_ratios=(2, 3), layout="constrained")
    arm, run = Arm(PARAMETERS), runs["rim-nonsmooth-gap"]
    for time, grey in ((0.0, "0.75"), (PARAMETERS["boom_up_s"], "0.5"), (PARAMETERS["closed_s"], "0")):
        at = int(time / 5e-3)
        arm.data.qpos[:] = run["boom_angle_rad"][at], run["stick_angle_rad"][at]
        arm._see()
        joints = [arm.data.body(name).xpos for name in ("boom", "stick", "bucket")] + [arm.data.geom("teeth").xpos]
        left.plot(*zip(*((x, z) for x, _, z in joints)), color=grey, marker="o", markersize=3)
        for name in ("boom", "stick"):
            ends = [arm.data.site(f"{name} {end}").xpos for end in ("pin", "rod")]
            left.plot(*zip(*((x, z) for x, _, z in ends)), color=grey, linewidth=4, alpha=0.6)
    left.axhline(0.0, color="0.6")
    left.set(aspect="equal", xlabel="m", title="Arm, cylinders, ground")
    for scheme, run in runs.items():
        right.plot(run["time_s"], 1e3 * run["teeth_z_m"], "--" if scheme == "rim-answers" else "-", label=scheme)
    right.axvline(PARAMETERS["closed_s"], color="0.6", linestyle=":")
    right.set(xlabel="s", ylabel="mm", title="Height of the teeth, valves closed from 3 s on")
    right.legend()
    figure.savefig(file, metadata={"Date": None} if str(file).endswith("svg") else None)


if __name__ == "__main__":
    runs = {}
    for scheme in ("zero-order-hold", "rim-nonsmooth-gap", "rim-answers"):
        run = runs[scheme] = rimbench.simulate(excavator, scheme, "5ms")
        end = "" if run.completed else f" at {run.outcome_at_s:.2f} s"
        print(f"{scheme:18} {run.outcome}{end}: teeth {1e3 * sunk(run):+.3f} mm, error {run.metrics['force_error_rms_n']:.0f} N")
    if sys.argv[1:]:
        draw(runs, sys.argv[1])

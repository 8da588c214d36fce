"""A foreign engine as the mechanics: the wedge box built in MuJoCo, coupled to the hydraulic cylinder of the case `wedge-box`.

MuJoCo lives in the plane of x and z, with four coordinates: x, z and angle of the box, spin of the disc (a sphere of its radius). The
interface model is made from MuJoCo's own mass matrix, Jacobians and distances; its contacts are soft, as MuJoCo has them.
"""

import math
import sys

import numpy as np

import rimbench

try:
    import mujoco
except ImportError:
    print("skipped: the wheel `mujoco` is not installed")
    sys.exit()
if int(mujoco.__version__.split(".")[0]) < 4:
    print(f"skipped: mujoco {mujoco.__version__} is installed, and 4 or later is needed")
    sys.exit()

TIP = 0.05  # radius of the spheres that stand for the wedges, m; their floor is as much lower
XML = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 -{gravity_m_s2}"/>
  <default><geom condim="1" solref="{solref}"/></default>
  <worldbody>
    <geom name="wedge_floor" type="plane" size="9 9 1" pos="0 0 -{tip}" contype="1" conaffinity="0"/>
    <geom name="floor" type="plane" size="9 9 1" contype="2" conaffinity="0"/>
    <geom name="ledge" type="box" size="2 1 0.5" pos="{ledge_x} 0 {ledge_z}" contype="2" conaffinity="0"/>
    <geom name="ramp" type="box" size="1 1 0.5" pos="{ramp_x} 0 {ramp_z}" axisangle="0 1 0 {ramp_rad}" contype="2" conaffinity="0"/>
    <site name="pin" pos="{ground_pin_x_m} 0 {pin_z}"/>
    <body name="box">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 -1 0"/>
      <inertial pos="0 0 0" mass="{box_mass_kg}" diaginertia="{box_inertia} {box_inertia} {box_inertia}"/>
      <geom name="right" type="sphere" size="{tip}" pos="{wedge_tip_x_m} 0 {wedge_tip_y_m}" contype="0" conaffinity="1"/>
      <geom name="left" type="sphere" size="{tip}" pos="-{wedge_tip_x_m} 0 {wedge_tip_y_m}" contype="0" conaffinity="1"/>
      <site name="attachment" pos="{attachment_x_m} 0 {attachment_y_m}"/>
      <body name="disc" pos="{disc_pin_x_m} 0 {disc_pin_y_m}">
        <joint type="hinge" axis="0 -1 0"/>
        <inertial pos="0 0 0" mass="{disc_mass_kg}" diaginertia="{disc_inertia} {disc_inertia} {disc_inertia}"/>
        <geom name="disc" type="sphere" size="{disc_radius_m}" contype="0" conaffinity="2"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def start(p):
    """Angle and height of the box, and place of the disc: right wedge on the floor, disc on the ledge, as in the case."""
    across = np.array([p["disc_pin_x_m"] - p["wedge_tip_x_m"], p["disc_pin_y_m"] - p["wedge_tip_y_m"]])
    rise, offset = (p["ledge_height_m"] + p["disc_radius_m"]) / np.hypot(*across), math.atan2(across[1], across[0])
    angles = [math.remainder(angle - offset, math.tau) for angle in (math.asin(rise), math.pi - math.asin(rise))]
    angle = min(angles, key=abs)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    centre = np.array([0.0, -(turn @ (p["wedge_tip_x_m"], p["wedge_tip_y_m"]))[1]])
    disc, attachment = (centre + turn @ (p[f"{name}_x_m"], p[f"{name}_y_m"]) for name in ("disc_pin", "attachment"))
    return angle, centre, disc, attachment


class WedgeBox:
    """The mechanics. `solref`, time constant (s) and damping ratio of the contacts, is MuJoCo's own default unless said otherwise."""

    solref = "0.02 1"
    contacts = 4
    gaps = ("gap_right_wedge_m", "gap_left_wedge_m", "gap_disc_ledge_m", "gap_disc_floor_m")
    observables = ("box_x_m", "box_y_m", "box_angle_rad", *gaps)

    def __init__(self, parameters):
        p = dict(parameters, solref=self.solref, tip=TIP)
        angle, centre, disc, attachment = start(p)
        slope, corner = math.atan(p["ramp_slope"]), np.array([disc[0] + p["ledge_lead_m"], p["ledge_height_m"]])
        ramp = corner + (math.cos(slope) - 0.5 * math.sin(slope), -math.sin(slope) - 0.5 * math.cos(slope))
        p.update(ledge_x=corner[0] - 2, ledge_z=corner[1] - 0.5, ramp_x=ramp[0], ramp_z=ramp[1], ramp_rad=slope)
        p.update(pin_z=attachment[1], disc_inertia=0.5 * p["disc_mass_kg"] * p["disc_radius_m"] ** 2)
        p.update(box_inertia=p["box_mass_kg"] * (p["box_width_m"] ** 2 + p["box_height_m"] ** 2) / 12)
        self.model = mujoco.MjModel.from_xml_string(XML.format(**p))
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:] = [*centre, angle, 0.0]
        self.work = 0.0
        self.see()

    def see(self):
        """Brings positions, distances and Jacobians to the present state, and takes the interface row from it."""
        mujoco.mj_step1(self.model, self.data)
        along = self.data.site("attachment").xpos - self.data.site("pin").xpos
        self.length = np.linalg.norm(along)
        self.row, self.bend = self.point("box", self.data.site("attachment").xpos, along / self.length)
        self.speed = self.row @ self.data.qvel

    def point(self, body, place, direction):
        """Jacobian row of a point of a body along a direction, and what is left of its acceleration without forces (J̇ v)."""
        jacobian, rate = np.zeros((2, 3, self.model.nv))
        mujoco.mj_jac(self.model, self.data, jacobian, None, place, self.model.body(body).id)
        mujoco.mj_jacDot(self.model, self.data, rate, None, place, self.model.body(body).id)
        return direction @ jacobian, direction @ rate @ self.data.qvel

    def contact(self, geom, *grounds):
        """Distance of a sphere from the nearest of the grounds, and the row of its centre along the normal."""
        ends = np.zeros((len(grounds), 6))
        gaps = [
            mujoco.mj_geomDistance(self.model, self.data, self.model.geom(ground).id, self.model.geom(geom).id, 9.0, end)
            for ground, end in zip(grounds, ends)
        ]
        nearest = int(np.argmin(gaps))
        centre = self.data.geom(geom).xpos
        normal = centre - ends[nearest, :3]
        return gaps[nearest], *self.point("disc" if geom == "disc" else "box", centre, normal / np.linalg.norm(normal))

    def all_contacts(self):
        pairs = ("right", "wedge_floor"), ("left", "wedge_floor"), ("disc", "ledge", "ramp"), ("disc", "floor")
        return zip(*(self.contact(*pair) for pair in pairs))

    def outputs(self, u):
        return self.length, self.speed

    def step(self, t, u, h):
        before = self.speed
        self.model.opt.timestep = h
        self.data.qfrc_applied[:] = u[0] * self.row
        mujoco.mj_step2(self.model, self.data)
        self.see()
        self.work += h * u[0] * 0.5 * (before + self.speed)
        return self.length, self.speed

    def interface_work(self):
        return self.work

    def observe(self):
        return *self.data.qpos[:3], *next(self.all_contacts())

    def interface_model(self, h):
        gaps, rows, bends = self.all_contacts()
        velocity = np.linalg.norm(self.point("box", self.data.site("attachment").xpos, np.eye(3))[0] @ self.data.qvel)
        turning = (velocity**2 - self.speed**2) / self.length  # the direction of the cylinder turns
        jacobian, bends = np.vstack([*rows, self.row]), np.array([*bends, self.bend + turning])
        mass = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, mass)
        free = np.linalg.solve(mass, self.data.qfrc_passive - self.data.qfrc_bias)
        return {
            "H": jacobian @ np.linalg.solve(mass, jacobian.T), "a": jacobian @ free + bends,
            "w": jacobian @ self.data.qvel, "gap": gaps, "position": [self.length],
            "closed": [gap <= 0.0 for gap in gaps],
        }


class StifferWedgeBox(WedgeBox):
    solref = "0.002 1"


soft, stiffer = (
    rimbench.Case(name, like="wedge-box", mechanics=mechanics, reference="original")
    for name, mechanics in (("mujoco-soft", WedgeBox), ("mujoco-stiffer", StifferWedgeBox))
)

if __name__ == "__main__":
    for scheme in ("zero-order-hold", "rim-smooth", "rim-nonsmooth", "rim-nonsmooth-gap"):
        for case in ("wedge-box", soft, stiffer):
            margin = {"contact_detection": "margin:1e-3"} if scheme == "rim-smooth" else {}
            run = rimbench.simulate(case, scheme, 2e-3, mechanics_steps=4, **margin)
            name, end = getattr(case, "name", case), "" if run.completed else f" at {run.outcome_at_s:.3f} s"
            force, position, deep = (run.metrics[key] for key in ("force_error_rms_n", "position_error_rms_m", "penetration_m"))
            print(f"{scheme:18} {name:15} {run.outcome}{end}: {force:.2f} N, {1e6 * position:.0f} µm, {1e3 * deep:.4f} mm deep")

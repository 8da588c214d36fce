"""Draws the moving picture of docs/results/servos.md: the quadruped on servos of 3000 N m/rad outside of the engine, which exchange torques
and motion every 20 ms, one motion, by three schemes. Usage: python moving.py docs/results/quadruped.svg"""

import sys
from pathlib import Path

import mujoco
import numpy as np
import rimbench
import sides

PANELS = {
    "hold": ("zero-order-hold", {}),
    "mass at the interface": ("interface-mass", {}),
    "contacts over the engine's step": ("rim-nonsmooth", {"contacts_act": "mechanics-step"}),
}
PARAMETERS = {"kp_n_m_rad": 3000.0, "feet_condim": 3.0, "motion": 1.0}
STEP_S, DURATION_S = 20e-3, 1.0
#: Seconds that a picture stands, and pixels per metre.
FRAME_S, SCALE = 0.06, 260.0
WIDTH, HEIGHT = 226, 190
#: How far the trunk may be from where it began to be drawn, m: what has diverged is anywhere.
SEEN = 0.25
STYLE = """@media (prefers-color-scheme:dark){{svg{{filter:invert(.93) hue-rotate(180deg)}}}}
.f{{visibility:hidden;animation:f {loop:g}s step-end infinite}}.s{{visibility:visible}}
@keyframes f{{0%{{visibility:visible}}{part:.4g}%{{visibility:hidden}}}}
@media (prefers-reduced-motion:reduce){{.f{{animation:none}}}}
path{{fill:none;stroke:#22262b;stroke-width:3;stroke-linecap:round}}.far{{stroke:#b9bec4}}
.trunk{{fill:#99c7e0;stroke-width:1.1}}.ground{{stroke:#c9ced4;stroke-width:2}}"""


class Recorded(sides.Quadruped):
    """The quadruped that records where its trunk is."""

    observables = tuple(f"trunk_{number}" for number in range(7))

    def observe(self):
        return self.data.qpos[:7].tolist()


def path(points, kind=""):
    at = "L".join(f"{WIDTH / 2 + SCALE * x:.1f} {HEIGHT - 12 - SCALE * z:.1f}" for x, z in points)
    return f'<path{kind} d="M{at}{"z" if "trunk" in kind else ""}"/>'


def picture(model, data, pose):
    """Side view, far legs first."""
    data.qpos[:] = pose
    mujoco.mj_kinematics(model, data)
    trunk, half = model.body("trunk").id, model.geom_size[model.body("trunk").geomadr[0]]
    corners = data.xpos[trunk] + half * [(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)] @ data.xmat[trunk].reshape(3, 3).T
    legs = {}
    for leg in ("fl", "rl", "fr", "rr"):
        knee = model.joint(f"knee_{leg}")
        foot = data.geom_xpos[model.body(int(knee.bodyid[0])).geomadr[0] + 1]
        legs[leg] = [data.xanchor[model.joint(f"hip_{leg}").id], data.xanchor[knee.id], foot]
    drawn = [path([(p[0], p[2]) for p in points], ' class="far"' if leg[1] == "l" else "") for leg, points in legs.items()]
    return "".join(drawn[:2]) + path([(p[0], p[2]) for p in corners], ' class="trunk"') + "".join(drawn[2:])


def main(file):
    model, _ = sides.of_quadruped(PARAMETERS)
    data, frames = mujoco.MjData(model), round(DURATION_S / STEP_S) + 1
    rows = [(f"q_{number}_m", f"v_{number}_m_s", f"tau_{number}_n") for number in range(12)]
    case = rimbench.Case(
        "quadruped", mechanics=Recorded, actuator=sides.QuadrupedServos, parameters=PARAMETERS, interface=rows, duration_s=DURATION_S,
        macro_step_s=STEP_S, micro_step_s=2.5e-4, reference_step_s=1.25e-4, scale=(2.0, 20.0, 300.0),
    )
    panels = []
    for place, (name, (scheme, options)) in enumerate(PANELS.items()):
        run = rimbench.simulate(case, scheme, STEP_S, divide_error=False, **options)
        columns = [*Recorded.observables, *(position for position, *_ in rows)]
        poses = np.column_stack([run[column] for column in columns])
        poses = poses[np.abs(poses[:, :3] - poses[0, :3]).max(axis=1, initial=0.0) < SEEN]
        said = "stands" if run.completed else f"{run.outcome} at {run['time_s'][-1]:.2f} s"
        drawn = [f'<text x="{WIDTH / 2}" y="14" text-anchor="middle">{name}: {said}</text>',
                 path([(-0.42, 0.0), (0.42, 0.0)], ' class="ground"')]
        for number in range(frames):
            kind, last = ("f s", "f")[number > 0], f"end{place}"
            shown = picture(model, data, poses[number]) if number < len(poses) else f'<use href="#{last}"/>'
            shown = f'<g id="{last}">{shown}</g>' if number == len(poses) - 1 else shown
            drawn.append(f'<g class="{kind}" style="animation-delay:{FRAME_S * number:g}s">{shown}</g>')
        panels.append(f'<svg x="{place * WIDTH}" width="{WIDTH}" height="{HEIGHT}">{"".join(drawn)}</svg>')
    loop = FRAME_S * frames
    Path(file).write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {3 * WIDTH} {HEIGHT}" role="img" font-family="sans-serif" font-size="11">'
        f"<title>A quadruped on servos outside of its engine stands or falls</title><style>"
        f'{STYLE.format(loop=loop, part=100.0 / frames)}</style>{"".join(panels)}</svg>\n',
        encoding="utf-8",
    )


if __name__ == "__main__":
    main(sys.argv[1])

#!/usr/bin/env python3
"""Steps the box, the row and the heap in MuJoCo and Siconos, beside ours in the same run.

See README.md in this folder. Nothing here is a test: it measures and checks that answers agree as far as the models allow.
"""

import argparse
import csv
import io
import shlex
import subprocess
import sys
import time

GRAVITY = 9.81
STEP_S = 5e-3
RADIUS = 0.1
BLADE_KG = 100.0
ROW_DISC_KG = 20.0
BOX_KG, PENDULUM_KG = 200.0, 50.0
# Steps from one look at whether a system has settled to the next, looks, and the speed below which it has, m/s or rad/s; then batches of
# steps that are timed: of a batch the mean, of all the shortest.
SETTLE, LOOKS, STILL = 50, 100, 1e-3
BATCHES, BATCH = 15, 10
# Lemke on a dense matrix takes seconds per step from some hundred contacts on.
SICONOS_CONTACTS = 150
# Of what forces must carry. Soft contacts still sink while they are timed; rigid ones hold to their solver's tolerance.
SOFT, RIGID = 0.02, 1e-6


class Disagreement(Exception):
    """An answer that is not what statics says."""


def ours(command, sizes):
    """Rows of the scaling bench: systems, answers and times of ours."""
    text = subprocess.run(shlex.split(command), check=True, stdout=subprocess.PIPE, text=True).stdout
    lines = [line for line in text.splitlines() if line.count(",") > 8]
    rows = list(csv.DictReader(io.StringIO("\n".join(lines))))
    if not rows:
        raise SystemExit(f"error: `{command}` printed no rows; valid: a command that runs the bench `scaling` with --csv")
    return [row for row in rows if int(row["contacts"]) <= sizes]


def sizes_of(row):
    """`columns=6;layers=4` as numbers by name."""
    return {key: float(value) for key, value in (pair.split("=") for pair in row["parameters"].split(";"))}


def heap_centres(columns, layers):
    for layer in range(layers):
        shift = layer % 2
        for column in range(columns - shift):
            yield RADIUS * (1 + shift + 2 * column), RADIUS * (1 + 3**0.5 * layer)


def system(row):
    """Centres of the discs, mass of each, and the push on the blade; for the box none."""
    sizes = sizes_of(row)
    if row["case"] == "disc-row":
        centres = [(RADIUS * (1 + 2 * disc), RADIUS) for disc in range(int(sizes["discs"]))]
        return centres, ROW_DISC_KG
    return list(heap_centres(int(sizes["columns"]), int(sizes["layers"]))), sizes["disc_mass_kg"]


def mujoco_text(row):
    head = f"""<mujoco><option timestep="{STEP_S}" gravity="0 0 {-GRAVITY}" solver="Newton" cone="elliptic"/>
      <size memory="1G"/><default><geom condim="1"/></default><worldbody><geom name="floor" type="plane" size="99 9 1"/>"""
    if row["case"] == "n-wedge-box":
        count = int(sizes_of(row)["supports"])
        tips = [-0.4 + 0.8 * index / (count - 1) for index in range(count)]
        geoms = "".join(f'<geom type="sphere" size="0.01" pos="{x} 0 -0.39" mass="0"/>' for x in tips)
        inertia = BOX_KG * (1.0**2 + 0.6**2) / 12
        return f"""{head}<body pos="0 0 0.4"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
          <joint type="hinge" axis="0 1 0"/><inertial pos="0 0 0" mass="{BOX_KG}" diaginertia="{inertia} {inertia} {inertia}"/>{geoms}
          <body pos="-0.3 0 0.2"><joint type="hinge" axis="0 1 0"/><inertial pos="0 0 0" mass="{PENDULUM_KG}"
          diaginertia="1 1 1"/></body></body></worldbody></mujoco>"""
    centres, mass = system(row)
    last = max(x for x, _ in centres) + RADIUS
    height = max(y for _, y in centres) + RADIUS
    discs = "".join(
        f'<body pos="{x} 0 {z}"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
        f'<geom type="sphere" size="{RADIUS}" mass="{mass}"/></body>'
        for x, z in centres
    )
    # The blade clears the floor, on which it does not stand.
    return f"""{head}<geom type="plane" pos="{last} 0 0" zaxis="-1 0 0" size="9 9 1"/>
      <body pos="-0.5 0 {height / 2 + 1}"><joint type="slide" axis="1 0 0"/>
      <geom type="box" size="0.5 1 {height / 2 + 0.99}" mass="{BLADE_KG}" conaffinity="2" contype="1"/></body>
      {discs}</worldbody></mujoco>"""


def with_mujoco(row, mujoco, numpy):
    model = mujoco.MjModel.from_xml_string(mujoco_text(row))
    data = mujoco.MjData(model)
    is_box = row["case"] == "n-wedge-box"
    if not is_box:
        data.qfrc_applied[0] = float(row["push_n"])
    for _ in range(LOOKS):
        mujoco.mj_step(model, data, nstep=SETTLE)
        if numpy.abs(data.qvel).max(initial=0.0) < STILL:
            break
    else:
        raise Disagreement(f"after {LOOKS * SETTLE} steps something still moves at {numpy.abs(data.qvel).max():.2g} m/s")
    times = []
    for _ in range(BATCHES):
        start = time.perf_counter()
        mujoco.mj_step(model, data, nstep=BATCH)
        times.append((time.perf_counter() - start) / BATCH)
    mujoco.mj_forward(model, data)
    if not numpy.isfinite(data.qvel).all():
        raise Disagreement("velocities are not finite")
    contacts = [data.contact[index] for index in range(data.ncon)]
    carried, force = 0.0, numpy.zeros(6)
    for index, contact in enumerate(contacts):
        if 0 in (contact.geom1, contact.geom2):
            mujoco.mj_contactForce(model, data, index, force)
            carried += force[0]
    weight = (BOX_KG + PENDULUM_KG if is_box else len(system(row)[0]) * system(row)[1]) * GRAVITY
    if abs(carried - weight) > SOFT * weight:
        # What still moves is said, not hidden: a heap that sinks is not at rest.
        print(f"  note: the floor carries {carried:.1f} N of {weight:.1f} N in MuJoCo: it still moves", file=sys.stderr)
    deepest = max([0.0] + [-contact.dist for contact in contacts])
    return min(times), len(contacts), deepest


def with_siconos(row, kernel, numpy):
    """Moreau-Jean with the row or the box, whose gaps are linear; Lemke."""
    if row["case"] == "disc-pile" or int(row["contacts"]) > SICONOS_CONTACTS:
        return None
    if row["case"] == "n-wedge-box":
        count = int(sizes_of(row)["supports"])
        mass = numpy.diag([BOX_KG + PENDULUM_KG, BOX_KG + PENDULUM_KG, BOX_KG * (1.0 + 0.36) / 12])
        force = numpy.array([0.0, -(BOX_KG + PENDULUM_KG) * GRAVITY, 0.0])
        jacobians = [[0.0, 1.0, -0.4 + 0.8 * index / (count - 1)] for index in range(count)]
        expected = -force[1]
    else:
        discs = int(sizes_of(row)["discs"])
        push = float(row["push_n"])
        size = 1 + 2 * discs
        mass = numpy.diag([BLADE_KG] + [ROW_DISC_KG] * (2 * discs))
        force = numpy.array([push] + [0.0, -ROW_DISC_KG * GRAVITY] * discs)
        jacobians = []
        for disc in range(discs):
            before, x = (0 if disc == 0 else 2 * disc - 1), 2 * disc + 1
            chain, floor = [0.0] * size, [0.0] * size
            chain[before], chain[x], floor[x + 1] = -1.0, 1.0, 1.0
            jacobians += [chain, floor]
        wall = [0.0] * size
        wall[2 * discs - 1] = -1.0
        jacobians.append(wall)
        expected = ROW_DISC_KG * GRAVITY * discs + push * (discs + 1)
    size = len(force)
    body = kernel.LagrangianLinearTIDS(numpy.zeros(size), numpy.zeros(size), mass)
    body.setFExtPtr(force)
    model = kernel.NonSmoothDynamicalSystem(0.0, 1e9)
    model.insertDynamicalSystem(body)
    inters = []
    for jacobian in jacobians:
        relation = kernel.LagrangianLinearTIR(numpy.array([jacobian]), numpy.zeros(1))
        inters.append(kernel.Interaction(kernel.NewtonImpactNSL(0.0), relation))
        model.link(inters[-1], body)
    problem = kernel.LCP()
    simulation = kernel.TimeStepping(model, kernel.TimeDiscretisation(0.0, STEP_S), kernel.MoreauJeanOSI(0.5), problem)

    def steps(count):
        for _ in range(count):
            simulation.computeOneStep()
            simulation.nextStep()

    steps(3)
    simulation.computeOneStep()
    carried = sum(inter.lambda_(1)[0] for inter in inters) / STEP_S
    simulation.nextStep()
    if abs(carried - expected) > RIGID * expected:
        raise Disagreement(f"contacts carry {carried:.6g} N instead of {expected:.6g} N")
    times = []
    for _ in range(BATCHES):
        start = time.perf_counter()
        steps(BATCH)
        times.append((time.perf_counter() - start) / BATCH)
    # Its contacts are rigid; how deep they are is not asked.
    return min(times), len(inters), None


def peer(name, module, step, rows):
    """Times of one peer by case and size, or nothing where it is not installed."""
    try:
        import importlib

        import numpy

        engine = importlib.import_module(module)
    except ImportError as error:
        print(f"skipped: {name} is not installed ({error})", file=sys.stderr)
        return {}
    found = {}
    for row in rows:
        try:
            answer = step(row, engine, numpy)
        except Disagreement as error:
            print(f"  {name}, {row['case']} {row['parameters']}: {error}; not compared", file=sys.stderr)
            continue
        if answer:
            found[row["case"], row["parameters"]] = answer
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ours", default="cargo bench -q --bench scaling -- --csv", help="command that prints our rows")
    parser.add_argument("--contacts", type=int, default=1200, help="largest system that is compared")
    parser.add_argument("--csv", help="file that the rows are written to as well")
    arguments = parser.parse_args()

    before = ours(arguments.ours, arguments.contacts)
    peers = {
        "mujoco": peer("MuJoCo", "mujoco", with_mujoco, before),
        "siconos": peer("Siconos", "siconos.kernel", with_siconos, before),
    }
    after = ours(arguments.ours, arguments.contacts)

    header = ["case", "parameters", "contacts", "ours_us", "ours_spread"]
    for name in peers:
        header += [f"{name}_contacts", f"{name}_us", f"{name}_over_ours", f"{name}_penetration_mm"]
    table = [header]
    for first, second in zip(before, after):
        times = [float(row["build_us"]) + float(row["step_us"]) for row in (first, second)]
        mine = (times[0] * times[1]) ** 0.5
        line = [first["case"], first["parameters"], first["contacts"], f"{mine:.2f}", f"{max(times) / min(times):.2f}"]
        for found in peers.values():
            answer = found.get((first["case"], first["parameters"]))
            if answer is None:
                line += [""] * 4
            else:
                seconds, contacts, deepest = answer
                depth = "" if deepest is None else f"{1e3 * deepest:.3g}"
                line += [str(contacts), f"{1e6 * seconds:.2f}", f"{1e6 * seconds / mine:.2f}", depth]
        table.append(line)
    widths = [max(len(line[column]) for line in table) for column in range(len(header))]
    for line in table:
        print("  ".join(cell.rjust(width) for cell, width in zip(line, widths)))
    if arguments.csv:
        with open(arguments.csv, "w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows(table)


if __name__ == "__main__":
    main()

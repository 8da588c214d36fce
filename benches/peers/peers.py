#!/usr/bin/env python3
"""Steps the box, the row and the heap in MuJoCo, Drake and Siconos, in turns with ours.

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
BOXES = ["n-wedge-box", "wedge-box-space"]
# Steps from one look at whether a system has settled to the next, looks, and the speed below which it has, m/s or rad/s; then steps that
# are timed one by one, of which the shortest counts.
SETTLE, LOOKS, STILL = 50, 100, 1e-3
STEPS = 200
# Steps of MuJoCo at rest per call: a call from Python takes microseconds.
BATCH = 20
# In motion: the macro steps of ours until they have settled, and passes over them, of each step the shortest.
MOTION, PASSES = 50, 3
# Drake's contacts are compliant, and each of its steps takes as long as many of the others: fewer of them, and no larger systems.
DRAKE_SETTLES_S, DRAKE_BATCH, DRAKE_CONTACTS = 5.0, 5, 70
# Lemke on a dense matrix takes seconds per step from some hundred contacts on.
SICONOS_CONTACTS = 150
# Gap up to which a contact of Siconos is closed, m.
CLOSED_M = 1e-9
# Of what forces must carry. Soft contacts still sink while they are timed; rigid ones hold to their solver's tolerance.
SOFT, RIGID = 0.02, 1e-6


class Disagreement(Exception):
    """An answer that is not what statics says."""


class NotAsked(Exception):
    """A system that a peer is not given."""


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
    if row["case"] == "wedge-box-space":
        tips = [(0.4, -0.3, -0.39), (0.4, 0.3, -0.39), (-0.4, -0.3, -0.39), (-0.4, 0.3, -0.386)]
        geoms = "".join(f'<geom type="sphere" size="0.01" pos="{x} {y} {z}" mass="0"/>' for x, y, z in tips)
        inertia = " ".join(str(BOX_KG * square / 12) for square in (0.8**2 + 0.6**2, 1.0**2 + 0.6**2, 1.0**2 + 0.8**2))
        head = head.replace('<geom condim="1"/>', '<geom condim="3" friction="0.3"/>')
        return f"""{head}<body pos="0 0 0.4"><freejoint/><inertial pos="0 0 0" mass="{BOX_KG}" diaginertia="{inertia}"/>{geoms}
          <body pos="-0.8 0.15 -0.19"><joint type="ball"/><geom type="sphere" size="0.2" mass="{PENDULUM_KG}"/></body></body>
          </worldbody></mujoco>"""
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


class Mujoco:
    """A system, brought to rest once and timed as often as one likes."""

    def __init__(self, row, mujoco, numpy):
        self.mujoco, self.numpy = mujoco, numpy
        self.model = mujoco.MjModel.from_xml_string(mujoco_text(row))
        self.is_box = row["case"] in BOXES
        # Along x, of the box in space beside its middle and above it: a force and its moments.
        arms = [1.0, 0.0, 0.0, 0.0, 0.3, 0.1] if row["case"] == "wedge-box-space" else [0.0 if self.is_box else 1.0]
        self.push = [float(row["push_n"]) * arm for arm in arms]
        self.data = self.start()
        for _ in range(LOOKS):
            mujoco.mj_step(self.model, self.data, nstep=SETTLE)
            if self.speed() < STILL:
                self.check(row)
                return
        # Its way from the start can be timed all the same.
        self.rests, self.contacts, self.deepest = False, self.data.ncon, None
        moves = f"after {LOOKS * SETTLE} steps something still moves at {self.speed():.2g} m/s"
        print(f"  mujoco, {row['case']} {row['parameters']}: {moves}; compared in motion only", file=sys.stderr)

    def start(self):
        data = self.mujoco.MjData(self.model)
        data.qfrc_applied[: len(self.push)] = self.push
        return data

    def speed(self):
        speed = self.numpy.abs(self.data.qvel).max(initial=0.0)
        if not self.numpy.isfinite(speed):
            raise Disagreement("velocities are not finite")
        return speed

    def check(self, row):
        data, force = self.data, self.numpy.zeros(6)
        self.mujoco.mj_forward(self.model, data)
        contacts = [data.contact[index] for index in range(data.ncon)]
        carried = 0.0
        for index, contact in enumerate(contacts):
            if 0 in (contact.geom1, contact.geom2):
                self.mujoco.mj_contactForce(self.model, data, index, force)
                carried += force[0]
        weight = (BOX_KG + PENDULUM_KG if self.is_box else len(system(row)[0]) * system(row)[1]) * GRAVITY
        if abs(carried - weight) > SOFT * weight:
            raise Disagreement(f"the floor carries {carried:.1f} N of {weight:.1f} N")
        self.rests, self.contacts = True, len(contacts)
        self.deepest = max([0.0] + [-contact.dist for contact in contacts])

    def timed(self, data, steps=1):
        start = time.perf_counter()
        self.mujoco.mj_step(self.model, data, steps)
        return (time.perf_counter() - start) / steps

    def settled(self):
        return min(self.timed(self.data, BATCH) for _ in range(STEPS // BATCH)) if self.rests else None

    def moving(self):
        """The box does not move; of the others the way from the start, with the push held from then on."""
        if self.is_box:
            return None
        shortest = [float("inf")] * MOTION
        for _ in range(PASSES):
            data = self.start()
            shortest = [min(known, self.timed(data)) for known in shortest]
        return float(self.numpy.median(shortest))


def drake_system(row, pydrake, numpy):
    """The box or the row with point contacts without friction, solved by TAMSI, and the joints on which its bodies move."""
    plants, trees, geometry = pydrake.multibody.plant, pydrake.multibody.tree, pydrake.geometry
    builder = pydrake.systems.framework.DiagramBuilder()
    plant, _ = plants.AddMultibodyPlantSceneGraph(builder, STEP_S)
    plant.set_contact_model(plants.ContactModel.kPoint)
    plant.set_discrete_contact_approximation(plants.DiscreteContactApproximation.kTamsi)
    smooth, world = plants.CoulombFriction(0.0, 0.0), plant.world_body()
    at = pydrake.math.RigidTransform

    def solid(mass, square):
        return trees.SpatialInertia(mass, numpy.zeros(3), trees.UnitInertia(square, square, square))

    def slides(name, parent, body, axis):
        plant.AddJoint(trees.PrismaticJoint(name, parent.body_frame(), body.body_frame(), axis))

    def touches(body, where, shape, name):
        plant.RegisterCollisionGeometry(body, where, shape, name, smooth)

    def planar(name, inertia, turns):
        """A body that moves in the plane, on links without mass."""
        links = [plant.AddRigidBody(f"{name} {link}", solid(0.0, 0.0)) for link in range(1 + turns)]
        body = plant.AddRigidBody(name, inertia)
        slides(f"{name} x", world, links[0], [1, 0, 0])
        slides(f"{name} z", links[0], links[1] if turns else body, [0, 0, 1])
        if turns:
            plant.AddJoint(trees.RevoluteJoint(f"{name} turn", links[1].body_frame(), body.body_frame(), [0, 1, 0]))
        return body

    touches(world, at(), geometry.HalfSpace(), "floor")
    if row["case"] == "n-wedge-box":
        count, mass = int(sizes_of(row)["supports"]), BOX_KG + PENDULUM_KG
        box = planar("box", solid(mass, BOX_KG * (1.0**2 + 0.6**2) / 12 / mass), True)
        for index in range(count):
            tip = [-0.4 + 0.8 * index / (count - 1), 0, -0.39]
            touches(box, at(tip), geometry.Sphere(0.01), f"tip {index}")
        start, push = [0.0, 0.4, 0.0], [0.0, 0.0, 0.0]
    else:
        centres, mass = system(row)
        touches(world, at([2 * RADIUS * len(centres) + 0.5, 0, 0]), geometry.Box(1.0, 2.0, 4.0), "wall")
        blade = plant.AddRigidBody("blade", solid(BLADE_KG, 1.0))
        slides("blade x", world, blade, [1, 0, 0])
        touches(blade, at([-0.5, 0, 0.6]), geometry.Box(1.0, 2.0, 1.1), "blade")
        start, push = [0.0], [float(row["push_n"])] + [0.0] * (2 * len(centres))
        for index, (x, z) in enumerate(centres):
            touches(planar(f"disc {index}", solid(mass, 0.08), False), at(), geometry.Sphere(RADIUS), f"disc {index}")
            start += [x, z]
    plant.Finalize()
    simulator = pydrake.systems.analysis.Simulator(builder.Build())
    own = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetPositions(own, start)
    plant.get_applied_generalized_force_input_port().FixValue(own, push)
    simulator.Initialize()
    return simulator, plant, own


class Drake:
    """A system, brought to rest once and timed as often as one likes."""

    def __init__(self, row, pydrake, numpy):
        if row["case"] not in ("n-wedge-box", "disc-row") or int(row["contacts"]) > DRAKE_CONTACTS:
            raise NotAsked
        self.simulator, plant, own = drake_system(row, pydrake, numpy)
        self.time_s = DRAKE_SETTLES_S
        self.simulator.AdvanceTo(self.time_s)
        found = plant.get_contact_results_output_port().Eval(own)
        points = [found.point_pair_contact_info(index) for index in range(found.num_point_pair_contacts())]
        carried = sum(abs(point.contact_force()[2]) for point in points)
        weight = (BOX_KG + PENDULUM_KG if row["case"] in BOXES else len(system(row)[0]) * system(row)[1]) * GRAVITY
        if abs(carried - weight) > SOFT * weight:
            raise Disagreement(f"the floor carries {carried:.1f} N of {weight:.1f} N")
        self.contacts, self.deepest = len(points), max(point.point_pair().depth for point in points)

    def settled(self):
        shortest = float("inf")
        for _ in range(STEPS // DRAKE_BATCH):
            self.time_s += DRAKE_BATCH * STEP_S
            start = time.perf_counter()
            self.simulator.AdvanceTo(self.time_s)
            shortest = min(shortest, (time.perf_counter() - start) / DRAKE_BATCH)
        return shortest

    def moving(self):
        return None


def siconos_steps(row, kernel, numpy):
    """Moreau-Jean with the row or the box, whose gaps are linear; Lemke. Returns what steps, checked, and the number of contacts."""
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
    stepper = kernel.MoreauJeanOSI(0.5)
    # Gaps that are zero up to round-off are closed; without it contacts that carry are left out of the problem.
    stepper.setConstraintActivationThreshold(CLOSED_M)
    simulation = kernel.TimeStepping(model, kernel.TimeDiscretisation(0.0, STEP_S), stepper, problem)

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
    return steps, len(inters)


class Siconos:
    """A system of linear gaps, checked once and timed as often as one likes."""

    # Its contacts are rigid: how deep they are is not asked.
    deepest = None

    def __init__(self, row, kernel, numpy):
        if row["case"] in ("disc-pile", "wedge-box-space") or int(row["contacts"]) > SICONOS_CONTACTS:
            raise NotAsked
        self.steps, self.contacts = siconos_steps(row, kernel, numpy)

    def settled(self):
        shortest = float("inf")
        for _ in range(STEPS // 10):
            start = time.perf_counter()
            self.steps(1)
            shortest = min(shortest, time.perf_counter() - start)
        return shortest

    def moving(self):
        return None


# Of each engine its module, and parts of it that must be there as well.
MODULES = {
    "mujoco": ["mujoco"],
    "drake": ["pydrake"] + [f"pydrake.{part}" for part in ("geometry", "math", "multibody.plant", "multibody.tree", "systems.analysis")],
    "siconos": ["siconos.kernel"],
}


def engine_of(name):
    """The module of a peer and NumPy, or nothing where they are not installed."""
    try:
        import importlib

        import numpy

        for part in MODULES[name][1:]:
            importlib.import_module(part)
        return importlib.import_module(MODULES[name][0]), numpy
    except ImportError as error:
        print(f"skipped: {name} is not installed ({error})", file=sys.stderr)
        return None


def systems_of(name, kind, modules, rows):
    """What of a peer is compared, by case and parameters."""
    found = {}
    for row in rows if modules else []:
        key = row["case"], row["parameters"]
        if key in found or row["state"] != "settled":
            continue
        try:
            found[key] = kind(row, *modules)
        except NotAsked:
            continue
        except Disagreement as error:
            print(f"  {name}, {row['case']} {row['parameters']}: {error}; not compared", file=sys.stderr)
    return found


def less(known, time_s):
    """The shorter of two times, of which either may be none."""
    return min((each for each in (known, time_s) if each is not None), default=None)


def shown(value, digits):
    return "" if value is None else f"{value:.{digits}g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bench", default="cargo bench -q -p rimbench-benches --bench scaling --", help="command that runs the scaling bench")
    parser.add_argument("--contacts", type=int, default=5100, help="largest system that is compared")
    parser.add_argument("--turns", type=int, default=3, help="how often each engine has its turn; of all the shortest time counts")
    parser.add_argument("--csv", help="file that the rows are written to as well")
    arguments = parser.parse_args()
    if arguments.turns < 1:
        parser.error(f"--turns {arguments.turns}: valid: 1 or more")

    parts = ["build_us", "take_us", "use_us", "step_us"]
    turns, peers, times = [], {}, {}
    for turn in range(arguments.turns):
        rows = ours(f"{arguments.bench} --csv", arguments.contacts)
        turns.append(rows)
        if turn == 0:
            for name, kind in (("mujoco", Mujoco), ("drake", Drake), ("siconos", Siconos)):
                peers[name] = systems_of(name, kind, engine_of(name), rows)
        for name, systems in peers.items():
            for key, peer in systems.items():
                for state in ("settled", "moving"):
                    at = (name, *key, state)
                    times[at] = less(times.get(at), getattr(peer, state)())

    header = ["case", "parameters", "state", "contacts", *parts, "ours_us", "ours_spread"]
    for name in peers:
        header += [f"{name}_contacts", f"{name}_us", f"{name}_over_ours", f"{name}_penetration_mm"]
    table = [header]
    for same in zip(*turns):
        first = same[0]
        shortest = [min(float(row[part]) for row in same) for part in parts]
        steps = [sum(float(row[part]) for part in ("build_us", "take_us", "step_us")) for row in same]
        # What the others do in a step, find the contact forces and move on, and what co-simulation needs of it: a model, handed over.
        mine = shortest[0] + shortest[1] + shortest[3]
        line = [first[key] for key in ("case", "parameters", "state", "contacts")]
        line += [f"{time_us:.3f}" for time_us in shortest] + [f"{mine:.3f}", f"{max(steps) / min(steps):.2f}"]
        for name, systems in peers.items():
            key = (first["case"], first["parameters"])
            time_s = times.get((name, *key, first["state"]))
            if time_s is None:
                line += [""] * 4
                continue
            peer, depth = systems[key], systems[key].deepest
            depth = None if depth is None or first["state"] == "moving" else 1e3 * depth
            line += [str(peer.contacts), shown(1e6 * time_s, 4), shown(1e6 * time_s / mine, 3), shown(depth, 3)]
        table.append(line)
    widths = [max(len(line[column]) for line in table) for column in range(len(header))]
    for line in table:
        print("  ".join(cell.rjust(width) for cell, width in zip(line, widths)))
    if arguments.csv:
        with open(arguments.csv, "w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows(table)


if __name__ == "__main__":
    main()

"""A master of one's own with FMPy over the pack's FMUs for FMI 3.0: python fmpy_loop.py PACK H OUT.csv [parallel|mechanics-first] [PHASE]

Both sides hold what they were told over a step. The force of a row is the actuator's output with the inputs of that instant."""
import csv, json, sys
from pathlib import Path
import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave


class Side:
    def __init__(self, file, wait):
        d = read_model_description(str(file))
        self.of = {v.name: v.valueReference for v in d.modelVariables}
        self.fmu = FMU3Slave(guid=d.guid, unzipDirectory=extract(str(file)), modelIdentifier=d.coSimulation.modelIdentifier,
                             instanceName=Path(file).stem)
        self.fmu.instantiate()
        self.put(["wait_s"], [wait])
        self.fmu.enterInitializationMode(startTime=0)
        self.fmu.exitInitializationMode()

    def get(self, names):
        return list(self.fmu.getFloat64([self.of[n] for n in names]))

    def put(self, names, values):
        self.fmu.setFloat64([self.of[n] for n in names], list(values))


def run(pack, H, out, way="parallel", phase=1.0):
    rule = json.loads((Path(pack) / "score.json").read_text())
    wait = (1 - phase) * H  # the model stands still at first: a master of fixed steps has any phase
    mechanics, actuator = (Side(Path(pack) / f"{side}.fmu", wait) for side in ("mechanics", "actuator"))
    motion = [row["position"] for row in rule["rows"]] + [row["velocity"] for row in rule["rows"]]
    forces, m = [row["force"] for row in rule["rows"]], len(rule["rows"])
    received, failed = [0.0] * m, None
    with open(out, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time_s", *motion, *forces, *(row["received"] for row in rule["rows"])])
        for k in range(int(np.floor((rule["duration_s"] + wait) / H + 1e-9)) + 1):
            moved = mechanics.get(motion)
            actuator.put(motion, moved)
            force = actuator.get(forces)
            table.writerow([repr(float(x)) for x in (max(k * H - wait, 0.0), *moved, *force, *received)])
            if (k + 1) * H - wait > rule["duration_s"] * (1 + 1e-9):
                break
            mechanics.put(forces, force)
            received = force
            try:
                mechanics.fmu.doStep(k * H, H)
                if way == "mechanics-first":
                    actuator.put(motion, mechanics.get(motion))
                actuator.fmu.doStep(k * H, H)
            except Exception as why:
                failed = f"after {max(k * H - wait, 0.0):.6g} s: {why}"
                break
    for side in (mechanics, actuator):
        side.fmu.freeInstance()
    return failed


if __name__ == "__main__":
    pack, H, out, *rest = sys.argv[1:]
    failed = run(pack, float(H), out, rest[0] if rest else "parallel", float(rest[1]) if len(rest) > 1 else 1.0)
    sys.exit(failed and f"failed {failed}")

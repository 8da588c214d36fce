"""OSP's fixed-step master (libcosim by libcosimpy) over the pack's FMUs for FMI 2.0: python libcosim.py PACK H OUT.csv [PHASE]

It initialises in its first step, and until then its observer tells zeros: the first row is what the problem begins with. Both sides
step in parallel, and a force follows from the motion of the step before. Its steps are whole numbers of nanoseconds."""
import csv, json, sys
from pathlib import Path
import numpy as np
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def run(pack, H, out, phase=1.0):
    log_output_level(CosimLogLevel.ERROR)
    rule = json.loads((Path(pack) / "score.json").read_text())
    wait, rows = (1 - phase) * H, rule["rows"]
    motion = [row["position"] for row in rows] + [row["velocity"] for row in rows]
    forces = [row["force"] for row in rows]
    execution = CosimExecution.from_step_size(step_size=round(H * 1e9))
    sides = [execution.add_local_slave(CosimLocalSlave(fmu_path=str(Path(pack) / f"fmi2/{side}.fmu"), instance_name=side))
             for side in ("mechanics", "actuator")]
    of = [{v.name.decode(): v.reference for v in execution.slave_variables(side)} for side in sides]
    for names, a, b in ((motion, 0, 1), (forces, 1, 0)):
        for name in names:
            assert execution.connect_real_variables(sides[a], of[a][name], sides[b], of[b][name]) == 0
    for side, variables in zip(sides, of):
        execution.real_initial_value(side, variables["wait_s"], wait)
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    start = [row["start"][k] for k in (0, 1, 2) for row in rows]
    received, failed = start[len(motion):], None
    with open(out, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time_s", *motion, *forces, *(row["received"] for row in rows)])
        table.writerow([0.0, *map(repr, start), *[0.0] * len(rows)])
        for k in range(1, int(np.floor((rule["duration_s"] + wait) / H + 1e-9)) + 1):
            if not execution.step():
                return f"after {max((k - 1) * H - wait, 0.0):.6g} s: a side refused its step"
            values = [*observer.last_real_values(sides[0], [of[0][n] for n in motion]),
                      *observer.last_real_values(sides[1], [of[1][n] for n in forces])]
            if k * H - wait > 0:
                table.writerow([repr(float(x)) for x in (k * H - wait, *values, *received)])
            received = values[len(motion):]
    return failed


if __name__ == "__main__":
    pack, H, out, *rest = sys.argv[1:]
    failed = run(pack, float(H), out, float(rest[0]) if rest else 1.0)
    sys.exit(failed and f"failed {failed}")

"""FMPy's own SSP master over the pack's system.ssp (FMI 2.0): python fmpy_ssp.py PACK H OUT.csv [PHASE]

As it comes its connectors begin at 0, so that the actuator is told a length of 0, and a row has the time at which its step began
with the values of its end. Here they begin with what both sides put out, and rows have the time of their values. Its loop is left
as it is: both sides step in parallel, and a force follows from the motion of the step before."""
import csv, json, sys
from pathlib import Path
import numpy as np
import fmpy.ssp.simulation as ssp


def run(pack, H, out, phase=1.0):
    rule = json.loads((Path(pack) / "score.json").read_text())
    wait, rows = (1 - phase) * H, rule["rows"]
    motion = [row["position"] for row in rows] + [row["velocity"] for row in rows]
    forces, made = [row["force"] for row in rows], ssp.instantiate_fmu
    starts = dict(zip(motion + forces, [row["start"][k] for k in (0, 1, 2) for row in rows]))

    def begun(component, *args, **more):
        made(component, *args, **more)
        for connector in component.connectors:
            connector.value = starts[connector.name]

    class Wait:  # what set_parameters asks for: a start value of each component
        parameters = [type("Parameter", (), {"name": f"{side}.wait_s", "value": wait}) for side in ("mechanics", "actuator")]

    ssp.instantiate_fmu, failed = begun, None
    steps = int(np.floor((rule["duration_s"] + wait) / H + 1e-9))
    try:
        told = ssp.simulate_ssp(str(Path(pack) / "system.ssp"), stop_time=(steps - 0.5) * H, step_size=H, parameter_set=Wait)
    except Exception as why:
        return str(why)
    finally:
        ssp.instantiate_fmu = made
    name = lambda side, own: next(n for n in told.dtype.names if side in n and n.endswith(own))
    columns = [name("mechanics", n) for n in motion] + [name("actuator", n) for n in forces]
    received = [starts[n] for n in forces]
    with open(out, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time_s", *motion, *forces, *(row["received"] for row in rows)])
        table.writerow([0.0, *(repr(starts[n]) for n in motion + forces), *[0.0] * len(rows)])
        for k, row in enumerate(told, 1):
            values = [float(row[n]) for n in columns]
            if k * H - wait > 0:
                table.writerow([repr(x) for x in (k * H - wait, *values, *received)])
            received = values[len(motion):]


if __name__ == "__main__":
    pack, H, out, *rest = sys.argv[1:]
    failed = run(pack, float(H), out, float(rest[0]) if rest else 1.0)
    sys.exit(failed and f"failed: {failed}")

"""Holds a trajectory to its own exchanges, with FMPy: python replay.py FILE.csv [--problem DIR]

The pack's mechanics, driven by the forces that the file says it received, must go where the file says that it went: then steps,
units, parameters and the mechanics are those of the problem. With inputs held over a step, the pack's actuator must put out the
forces of the file as well: then they are not smoothed or shifted, and the class `samples` is shown. Inputs that a scheme makes up
are no fault, and only told apart. Where the mechanics takes more steps per exchange than one, its file has a row for each step."""
import argparse, json, sys
from pathlib import Path
import numpy as np
sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "masters")]
from fmpy_loop import Side
from score import Refused, grid_of, table

ALLOWED = 1e-7  # m; honest runs agree to 1e-13 with the library of the pack, and to rounding that contacts amplify with another


def replay(pack, file):
    rule, run = json.loads((Path(pack) / "score.json").read_text()), table(file)
    rows, t = rule["rows"], run["time_s"]
    motion = [row["position"] for row in rows] + [row["velocity"] for row in rows]
    forces, received = [row["force"] for row in rows], [row["received"] for row in rows]
    if missing := [name for name in received if name not in run]:
        raise Refused(f"columns missing: {', '.join(missing)}: the force that the mechanics received over the step that ends at a row")
    grid_of(t, rule["duration_s"], None)
    at = lambda names, k: [float(run[name][k]) for name in names]
    mechanics, worst = Side(Path(pack) / "mechanics.fmu", 0.0), 0.0
    for k in range(1, len(t)):
        H = t[k] - t[k - 1]
        mechanics.put(forces, at(received, k))
        try:
            mechanics.fmu.doStep(t[k - 1], H)
        except Exception as why:
            raise Refused(f"{received[0]}: at {t[k]:.6g} s the mechanics cannot follow these forces: {why}") from None
        off = np.abs(np.array(mechanics.get(motion)) - at(motion, k)) * ([1.0] * len(rows) + [H] * len(rows))
        worst = max(worst, float(np.nan_to_num(off, nan=np.inf).max()))
        if worst > ALLOWED:
            raise Refused(f"{motion[int(off.argmax())]}: at {t[k]:.6g} s the mechanics under the forces received is {worst:.1e} m from "
                          "where the file says it is")
    told = [f"mechanics: within {worst:.1e} m over {len(t) - 1} steps"]
    size = max(row["force_peak_n"] or 1.0 for row in rows)
    for way, held in (("its start", 1), ("its end", 0)):
        actuator, off = Side(Path(pack) / "actuator.fmu", 0.0), [0.0, 0.0]
        for k in range(1, len(t)):
            actuator.put(motion, at(motion, k - held))
            try:
                actuator.fmu.doStep(t[k - 1], t[k] - t[k - 1])
            except Exception:
                off = [np.inf, np.inf]
                break
            for which in (0, 1):  # as the actuator has put it out, and asked again with the inputs of the exchange
                if which:
                    actuator.put(motion, at(motion, k))
                off[which] = max(off[which], float(np.abs(np.array(actuator.get(forces)) - at(forces, k)).max()))
        if min(off) < 1e-6 * size:
            asked = ", with inputs of the exchange" if off[1] <= off[0] else ", as put out before the exchange"
            told.append(f"actuator: inputs held, those of {way}{asked}: within {min(off):.1e} N: class samples is shown")
    if len(told) == 1:
        told.append("actuator: its inputs were not held: class samples is not shown")
    return told


if __name__ == "__main__":
    options = argparse.ArgumentParser()
    options.add_argument("file")
    options.add_argument("--problem", default=Path(__file__).parent)
    given = options.parse_args()
    try:
        print("\n".join(replay(given.problem, given.file)))
    except (Refused, OSError, KeyError, ValueError) as error:
        sys.exit(f"refused: {error}")
